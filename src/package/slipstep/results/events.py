"""A catalogue as pictures need it: columns checked, its cells, and the law of Gutenberg and Richter."""

import sys

import numpy as np

from ..errors import OutputError
from ..modules import program
from ..times import written
from .catalogue import Catalogue
from .magnitudes import b_value, completeness
from .run import Cells

FITTED = 30  # events from the magnitude of completeness on, below which no b is worth a line
RANGE = 0.5  # of magnitudes, likewise
FEW = 5  # events of one cell, below which their median is not one
SEVERAL = 1.5  # areas of a cell, above which an event is one of several cells
COLUMNS = {"onset": "s", "end": "s", "x": "m", "z": "m", "area": "m^2", "mean_slip": "m", "max_slip": "m",
           "moment": "N m", "magnitude": "1", "stress_drop": "Pa", "peak_slip_rate": "m/s"}


class Events(Catalogue, Cells):
    """All events of a catalogue: events["onset"], len(events), and its maps one by one."""

    def __init__(self, path):
        super().__init__(path)
        for name, expected in COLUMNS.items():
            if name not in self.event:
                raise OutputError(f"{self.path}: dataset /{name} is missing; it has {', '.join(sorted(self.event))}")
            if self.units[name] != expected:
                raise OutputError(f"{self.path}: /{name} has units \"{self.units[name]}\", expected \"{expected}\"")
        if not self.count:
            raise OutputError(self.none())

    def __getitem__(self, name):
        return self.event[name]

    def __len__(self):
        return self.count

    @property
    def cell_area(self):
        """Area of the largest cell [m^2], None where the file does not tell: one cell, and no extent of the fault."""
        if self.planes:
            return float(np.max(self.mesh["length"] * self.mesh["width"]))
        if "fault_area" in self.attributes:
            return float(self.attributes["fault_area"]) / np.prod(self.shape)
        return float(np.prod([np.diff(axis)[0] for axis in self.axes])) if min(self.shape) > 1 else None

    @property
    def cell_magnitude(self):
        """Magnitude of an event of one cell: the median of those that there are, or, where they are few, a circular
        crack (Eshelby 1957, nu = 1/4) of its area with the median of the stress drops."""
        drops = self["stress_drop"][self["stress_drop"] > 0]
        if self.cell_area is None or not len(drops):
            return None
        alone = self["magnitude"][np.isfinite(self["magnitude"]) & (self["area"] <= SEVERAL * self.cell_area)]
        if len(alone) >= FEW:
            return float(np.median(alone))
        return (np.log10(16 / 7 * np.median(drops) * (self.cell_area / np.pi) ** 1.5) - 9.1) / 1.5

    def fit(self):
        """The law of Gutenberg and Richter: (least magnitude, b, its standard error, number of events), or why there is
        none, in words. Events of one cell are left out: how many there are, and how large, is of the mesh."""
        if not self.attributes.get("weakens", 1):
            return "no b: friction weakens nowhere"
        several = np.isfinite(self["magnitude"]) & self.over
        if self.cell_area is not None:
            several &= self["area"] > SEVERAL * self.cell_area
        magnitude = self["magnitude"][several]
        words = "events" if self.cell_area is None else "events of several cells"
        if len(magnitude) < FITTED:
            return f"no b: {len(magnitude)} {words.replace('events', 'event') if len(magnitude) == 1 else words}"
        least = max(completeness(magnitude), -np.inf if self.cell_magnitude is None else self.cell_magnitude
                    + np.log10(SEVERAL))
        above = int((magnitude >= least).sum())
        if above < FITTED:
            return f"no b: {above} {words} from M {least:.1f} on"
        if magnitude.max() - least < RANGE:
            return f"no b: {words} of M {least:.1f} to {magnitude.max():.1f}"
        return least, *b_value(magnitude, least), above

    def warn(self):
        """One line on stderr for a run that has not ended, and for an event that goes on."""
        super().warn()
        if not self.complete:
            print(f"{program()}: {self.path} is unfinished: complete = 0, its last event is at "
                  f"{written(self['onset'][-1])}", file=sys.stderr)

    def map_of(self, name, event):
        """Slip [m], or time of rupture after the onset [s], of each cell in one event: [Nz, Nx], or [N] of irregular
        cells."""
        maps = self.map(name)
        expected = (len(self.mesh["x"]),) if self.planes else self.shape
        if maps.shape[1:] != expected:
            raise OutputError(f"{self.path}: /maps/{name} is {maps.shape[1:]} for each event, expected {expected} as "
                              "the cells of /mesh")
        return maps[event]
