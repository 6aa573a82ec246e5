"""Results of a run as arrays: of Fault.run(), and of files that the program wrote."""

import os

from .errors import Error


def plain(value):
    """A string or number of an attribute."""
    if isinstance(value, bytes):
        return value.decode()
    return value.item() if getattr(value, "ndim", None) == 0 else value


class Result:
    """What a run found, in SI units.

    fields      dict: "time" [n], "slip" [n, nz, nx], ... of a mesh [n, cells]; of two components of slip one more dimension
    series      dict: "time" [steps], "mean_slip", "moment_rate" [steps, faults], ...
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
            with _opened(run) as file:
                self._read(file)
        if catalogue:
            with _opened(catalogue) as file:
                self._read_events(file)
                if not run:
                    self.complete = bool(file.attrs.get("complete", 1))
                    self.mesh = {name: data[()] for name, data in file["mesh"].items()}

    def _columns(self, group, where, unit_prefix=""):
        """Datasets of a group cut to the rows that all of them have, as a file that grows may have more in some."""
        import h5py
        data = {name: item for name, item in group.items() if isinstance(item, h5py.Dataset)}
        rows = min((len(item) for name, item in data.items() if name == "time" or "CLASS" not in item.attrs), default=0) if "time" in data else None
        found = {}
        for name, item in data.items():
            axis = "CLASS" in item.attrs and name != "time"
            if axis and plain(item.attrs["NAME"]).startswith("This is a netCDF dimension"):
                continue  # without coordinates
            found[name] = item[()] if axis or rows is None else item[:rows]
            unit = plain(item.attrs.get("units", ""))
            if self.units.setdefault(name, unit) != unit:
                self.units[f"{where}/{name}"] = unit
        return found

    def _read(self, file):
        self.complete = bool(file.attrs.get("complete", 1))
        self.run, self.summary, self.parameters = ({name: plain(value) for name, value in file[group].attrs.items()} if group in file else {}
                                                   for group in ("run", "result", "parameters"))
        for name in ("fields", "series", "steps", "mesh"):
            if name in file:
                setattr(self, name, self._columns(file[name], name))
        grid = "length" not in self.mesh
        for name, values in self.fields.items():
            if name not in ("time", "x", "z"):
                inner = ("z", "x") if grid else ("cell",)
                self.dimensions[name] = ("time", *inner, "component")[: values.ndim]
        for name in ("stations", "surface"):
            for k in range(len(file.get(name, ()))):
                group = file[f"{name}/{k}"]
                getattr(self, name).append({**self._columns(group, name), **{key: plain(value) for key, value in group.attrs.items()}})

    def _read_events(self, file):
        import h5py
        import numpy as np
        columns = {name: item for name, item in file.items() if isinstance(item, h5py.Dataset) and (name == "onset" or "CLASS" not in item.attrs)}  # without axes
        rows = min((len(item) for item in columns.values()), default=0)
        self._event_units = {name: plain(item.attrs.get("units", "")) for name, item in columns.items()}
        order = ["onset", "end", "magnitude"] + sorted(set(columns) - {"onset", "end", "magnitude"})
        self._events = np.zeros(rows, dtype=[(name, columns[name].dtype, columns[name].shape[1:]) for name in order])
        for name in order:
            self._events[name] = columns[name][:rows]

    def __getitem__(self, name):
        for group in (self.fields, self.series):
            if name in group:
                return group[name]
        raise KeyError(f"{name}: fields has {', '.join(self.fields) or 'nothing'}; series has {', '.join(self.series) or 'nothing'}")

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
        variables = {name: (dims, self.fields[name], {"units": self.units.get(f"fields/{name}", self.units[name])}) for name, dims in self.dimensions.items()}
        coordinates = {"time": ("time", self.fields["time"], {"units": "s"})} if "time" in self.fields else {}
        if "length" not in self.mesh and "x" in self.mesh:
            coordinates.update((axis, (axis, self.mesh[axis], {"units": "m"})) for axis in ("x", "z"))
        elif "x" in self.mesh and variables:
            coordinates.update((axis, ("cell", self.mesh[axis], {"units": "m"})) for axis in ("x", "y", "z"))
        return xarray.Dataset(variables, coordinates, {name: value for name, value in self.parameters.items() if isinstance(value, (int, float, str))})

    def __repr__(self):
        if not self.series:
            return f"<slipstep.Result: a catalogue of {len(self._events)} events>" if self._events is not None else "<slipstep.Result: empty>"
        end = self.series["time"][-1] if len(self.series["time"]) else 0.0
        events = "" if self._events is None else f", {len(self._events)} events"
        slip = f", mean slip {self.series['mean_slip'][-1]:.6g} m" if len(self.series.get("mean_slip", ())) else ""
        return f"<slipstep.Result: {'ended' if self.complete else 'stopped'} at {end:.6g} s{slip}, {len(self.series['time'])} steps{events}>"


def _opened(path):
    try:
        import h5py
    except ImportError:
        raise Error("results need h5py; Debian's package is python3-h5py") from None
    path = os.fspath(path)
    if not os.path.exists(path):
        part = f"; {path}.part is there, of a run that has not ended" if os.path.exists(path + ".part") else ""
        raise Error(f"{path}: no such file{part}")
    try:
        return h5py.File(path, "r", swmr=path.endswith(".part"))
    except OSError as error:
        raise Error(f"{path}: not an HDF5 file, or truncated ({error})") from None


def open(path, catalogue=None):
    """The Result of a file that the program wrote: of -fault_output, with the file of -fault_catalogue if it is given, or of a catalogue
    alone. FILE.part of a run that has not ended is read as far as it has come. Error: it is missing, or no such file."""
    with _opened(path) as file:
        kind = plain(file.attrs.get("format", ""))
        groups = set(file)
    if kind == "slipstep-catalogue":
        return Result(None, path)
    if not {"run", "series"} <= groups:
        raise Error(f"{os.fspath(path)}: neither the output of a run (-fault_output) nor a catalogue (-fault_catalogue)")
    return Result(path, catalogue)
