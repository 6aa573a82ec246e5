"""Read the file of -fault_catalogue, one entry an event: Catalogue(path), in SI units.

    from slipstep_catalogue import Catalogue
    events = Catalogue("output/catalogue.h5")
    events["onset"], events["magnitude"], events.map("slip", 3)
"""

import os

import h5py
import numpy as np

from slipstep_output import Cells, OutputError, _plain, open_file

COLUMNS = {"onset": "s", "end": "s", "x": "m", "z": "m", "area": "m^2", "mean_slip": "m", "max_slip": "m", "moment": "N m",
           "magnitude": "1", "stress_drop": "Pa", "peak_slip_rate": "m/s"}


class Catalogue(Cells):
    """All events, in the order of the file: columns by name, mesh as of a Run; {} where the file has none."""

    def __init__(self, path):
        self.path = os.fspath(path)
        with self._open() as file:
            missing = [name for name in COLUMNS if not isinstance(file.get(name), h5py.Dataset)]
            if missing:
                raise OutputError(f"{self.path}: dataset /{missing[0]} is missing, expected a file of -fault_catalogue with "
                                  f"{', '.join(COLUMNS)}; it has {', '.join(sorted(file)) or 'nothing'}")
            self._check_units(file)
            self.columns = {name: data[()] for name, data in file.items() if isinstance(data, h5py.Dataset) and data.ndim == 1}
            self.mesh = {name: data[()] for name, data in file["mesh"].items()} if "mesh" in file else {}
            self.maps = [name for name in file.get("maps", ())]
        rows = {len(self.columns[name]) for name in COLUMNS}
        self.columns = {name: column[:min(rows)] for name, column in self.columns.items()}
        if not min(rows):
            raise OutputError(f"{self.path}: no event is there yet")

    def _open(self):
        return open_file(self.path, f"a run writes it with -fault_catalogue {self.path}")

    def _check_units(self, file):
        for name, expected in COLUMNS.items():
            unit = _plain(file[name].attrs.get("units", expected))
            if unit != expected:
                raise OutputError(f"{self.path}: /{name} has units \"{unit}\", expected \"{expected}\"")

    def __getitem__(self, name):
        return self.columns[name]

    def __len__(self):
        return len(self["onset"])

    def map(self, name, event):
        """Slip [m] or time of rupture [s] of each cell in one event, [Nz, Nx] or [N] of irregular cells."""
        if name not in self.maps or "x" not in self.mesh or "z" not in self.mesh:
            raise OutputError(f"{self.path}: no {'/maps/' + name if name not in self.maps else '/mesh with x and z'}; expected a catalogue with the "
                              "maps of its events")
        if not 0 <= event < len(self):
            raise OutputError(f"{self.path}: no event {event + 1}, expected a number from 1 to {len(self)}")
        expected = (len(self.mesh["x"]),) if self.planes else self.shape
        with self._open() as file:
            data = file[f"maps/{name}"]
            if data.shape[1:] != expected or len(data) <= event:
                raise OutputError(f"{self.path}: /maps/{name} is {data.shape}, expected {(len(self), *expected)} as events and cells")
            return data[event]


def completeness(magnitude, width=0.1):
    """The magnitude from which on a catalogue is complete, by the largest count in bins of a width: their lower edge."""
    bins = np.floor(magnitude / width + 1e-9).astype(int)
    return width * (bins.min() + np.argmax(np.bincount(bins - bins.min())))


def b_value(magnitude, least):
    """b of Gutenberg and Richter by maximum likelihood (Aki 1965), and its standard error, of the events from a magnitude on."""
    above = magnitude[magnitude >= least]
    b = np.log10(np.e) / (above.mean() - least)
    return b, b / np.sqrt(len(above))
