"""A catalogue as pictures need it: columns checked, its cells, and the law of Gutenberg and Richter."""

import sys

import numpy as np

from slipstep_catalogue import Catalogue
from slipstep_output import Cells, OutputError

COLUMNS = {"onset": "s", "end": "s", "x": "m", "z": "m", "area": "m^2", "mean_slip": "m", "max_slip": "m", "moment": "N m",
           "magnitude": "1", "stress_drop": "Pa", "peak_slip_rate": "m/s"}


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
            raise OutputError(f"{self.path}: no event is there" + ("" if self.complete else " yet"))

    def __getitem__(self, name):
        return self.event[name]

    def __len__(self):
        return self.count

    def warn(self, program):
        """One line on stderr for a run that has not ended."""
        if not self.complete:
            print(f"{program}: {self.path} is unfinished: complete = 0, its last event is at {self['onset'][-1]:g} s", file=sys.stderr)

    def map_of(self, name, event):
        """Slip [m], or time of rupture after the onset [s], of each cell in one event: [Nz, Nx], or [N] of irregular cells."""
        if not 0 <= event < len(self):
            raise OutputError(f"{self.path}: no event {event + 1}, expected a number from 1 to {len(self)}")
        maps = self.map(name)
        expected = (len(self.mesh["x"]),) if self.planes else self.shape
        if maps.shape[1:] != expected:
            raise OutputError(f"{self.path}: /maps/{name} is {maps.shape[1:]} for each event, expected {expected} as the cells of /mesh")
        return maps[event]


def completeness(magnitude, width=0.1):
    """The magnitude from which on a catalogue is complete, by the largest count in bins of a width: their lower edge."""
    bins = np.floor(magnitude / width + 1e-9).astype(int)
    return width * (bins.min() + np.argmax(np.bincount(bins - bins.min())))


def b_value(magnitude, least):
    """b of Gutenberg and Richter by maximum likelihood (Aki 1965), and its standard error, of the events from a magnitude on."""
    above = magnitude[magnitude >= least]
    b = np.log10(np.e) / (above.mean() - least)
    return b, b / np.sqrt(len(above))
