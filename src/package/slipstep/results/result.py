"""Results of a run as arrays: of Fault.run(), and of files that the program wrote."""

import os

import numpy as np

from ..errors import Error, OutputError
from .catalogue import Catalogue
from .files import is_catalogue, open_any
from .run import Contents


GROUPS = ("fields", "series", "steps", "mesh", "stations", "surface")  # whose unit a name has where it is in several


class Whole(Contents):
    """All that the file of a run holds."""

    def read(self, file):
        super().read(file)
        self.fields = self.group(file, "fields")
        self.stations, self.surface = ([self.group(file, f"{name}/{k}") for k in range(len(file.get(name, ())))]
                                       for name in ("stations", "surface"))


class Result:
    """What a run found, in SI units.

    fields      dict: "time" [n], "slip" [n, nz, nx], ... of a mesh [n, cells]; of two components of slip one more
                dimension
    series      dict: "time" [1 + steps], "mean_slip", "moment_rate" [1 + steps, faults], ..., the start and each
                accepted step
    steps       dict, a number for each attempt of a step: "dt", "error", "accepted", ...
    mesh        dict: centres "x", "z" of a grid, of a mesh a number for each cell; parameters of the cells
    stations    list of dicts, as series, for each point of -fault_stations, with attributes "x", "z"; surface likewise
    units       dict: unit of each name; with a group for what has another one there, as "steps/time"
    summary     dict: accepted, rejected, solves, mean_slip, errors, wall times, ...
    parameters  dict: every parameter that is one number or one choice
    run         dict: versions, options, date, host
    warnings    list of lines
    complete    whether the run has reached its end
    catalogue   events: a pandas.DataFrame where pandas is installed, else a structured array; None without a catalogue
    dataset     fields as xarray.Dataset with coordinates and units; needs xarray
    result["slip"]   one of fields, else of series
    """

    def __init__(self, run=None, catalogue=None):
        """From the files of a run and of its catalogue; either may be None."""
        self.fields, self.series, self.steps, self.mesh, self.units = {}, {}, {}, {}, {}
        self.stations, self.surface, self.summary, self.parameters, self.run = [], [], {}, {}, {}
        self.dimensions, self.complete, self._events, self._event_units = {}, True, None, {}
        if run:
            self._read(Whole(run))
        if catalogue:
            self._read_events(Catalogue(catalogue), run is None)

    def _read(self, found):
        self.complete, self.run, self.summary, self.parameters = (found.complete, found.run, found.summary,
                                                                  found.parameters)
        self.series, self.steps = found.series, found.steps
        self.mesh = {name: values for name, values in found.mesh.items() if f"/mesh/{name}" in found.units}
        self.fields, self.stations, self.surface = found.fields, found.stations, found.surface
        for group in GROUPS:
            for path, unit in found.units.items():
                name = path.rsplit("/", 1)[1]
                if path.startswith(f"/{group}/") and self.units.setdefault(name, unit) != unit:
                    self.units[f"{group}/{name}"] = unit
        inner = ("z", "x") if "length" not in self.mesh else ("cell",)
        for name, values in self.fields.items():
            if name not in ("time", "x", "z"):
                self.dimensions[name] = ("time", *inner, "component")[: values.ndim]

    def _read_events(self, found, alone):
        self._event_units = found.units
        order = ["onset", "end", "magnitude"] + sorted(set(found.event) - {"onset", "end", "magnitude"})
        self._events = np.zeros(found.count,
                                dtype=[(name, found.event[name].dtype, found.event[name].shape[1:]) for name in order])
        for name in order:
            self._events[name] = found.event[name]
        if alone:
            self.complete, self.mesh = found.complete, found.mesh

    def __getitem__(self, name):
        for group in (self.fields, self.series):
            if name in group:
                return group[name]
        raise KeyError(f"{name}: fields has {', '.join(self.fields) or 'nothing'}; series has "
                       f"{', '.join(self.series) or 'nothing'}")

    @property
    def time(self):
        """Times of the fields [n], in s; result.series["time"] are those of the series."""
        return self.fields["time"]

    @property
    def warnings(self):
        return [line for line in self.run.get("warnings", "").split("\n") if line]

    @property
    def catalogue(self):
        if self._events is None:
            return None
        try:
            import pandas
        except ImportError:
            return self._events
        table = {}
        for name in self._events.dtype.names:
            values = self._events[name]
            if values.ndim == 1:
                table[name] = values
            else:
                table.update((f"{name}_{k}", values[:, k]) for k in range(values.shape[1]))
        frame = pandas.DataFrame(table)
        frame.attrs["units"] = dict(self._event_units)
        return frame

    @property
    def dataset(self):
        try:
            import xarray
        except ImportError:
            raise Error("dataset needs xarray; Debian's package is python3-xarray") from None
        variables = {name: (dims, self.fields[name], {"units": self.units.get(f"fields/{name}", self.units[name])})
                     for name, dims in self.dimensions.items()}
        coordinates = {"time": ("time", self.fields["time"], {"units": "s"})} if "time" in self.fields else {}
        if "length" not in self.mesh and "x" in self.mesh:
            coordinates.update((axis, (axis, self.mesh[axis], {"units": "m"})) for axis in ("x", "z"))
        elif "x" in self.mesh and variables:
            coordinates.update((axis, ("cell", self.mesh[axis], {"units": "m"})) for axis in ("x", "y", "z"))
        return xarray.Dataset(variables, coordinates, {name: value for name, value in self.parameters.items()
                                                       if isinstance(value, (int, float, str))})

    def __repr__(self):
        if not self.series:
            return (f"<slipstep.Result: a catalogue of {len(self._events)} events>" if self._events is not None
                    else "<slipstep.Result: empty>")
        end = self.series["time"][-1] if len(self.series["time"]) else 0.0
        events = "" if self._events is None else f", {len(self._events)} events"
        slip = f", mean slip {self.series['mean_slip'][-1]:.6g} m" if len(self.series.get("mean_slip", ())) else ""
        return (f"<slipstep.Result: {'ended' if self.complete else 'stopped'} at {end:.6g} s{slip}, "
                f"{int(self.steps['accepted'].sum())} steps{events}>")


def open(path, catalogue=None):
    """The Result of a file that the program wrote: of -fault_output, with the file of -fault_catalogue if it is given,
    or of a catalogue alone. FILE.part of a run that has not ended is read as far as it has come. Error: it is missing,
    or no such file."""
    with open_any(path) as file:
        events, groups = is_catalogue(file), set(file)
    if events:
        return Result(None, path)
    if not {"run", "series"} <= groups:
        raise OutputError(f"{os.fspath(path)}: neither the output of a run (-fault_output) nor a catalogue "
                          "(-fault_catalogue)")
    return Result(path, catalogue)
