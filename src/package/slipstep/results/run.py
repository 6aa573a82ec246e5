"""Read the HDF5 file of one run, of the fault (-fault_output), the sliding mode controller, the circuit or a model of
one's own: Run(path) and its steps, series, fields and results in SI units.

    from slipstep import Run
    run = Run("output/fault.h5")
    run.series["time"], run.series["mean_slip"]      # of the start and each accepted step
    run.accepted, run.steps["dt"][~run.accepted]     # one value per attempt
    time, maps = run.field("slip_rate")              # [n], [n, Nz, Nx]
"""

import os
import sys

import h5py
import numpy as np

from ..errors import OutputError
from ..modules import program
from ..times import written
from .files import attributes, columns, drawn, is_complete, names_of, open_file, split

STEPS = ("time", "dt", "accepted", "error", "converged", "newton_iterations", "linear_iterations", "reason", "wall")
RESULT = ("accepted", "rejected", "solves", "newton_iterations", "linear_iterations", "wall_time_setup",
          "wall_time_solve")
# Besides, of a fault:
SERIES = ("mean_slip_rate", "max_slip_rate", "mean_slip", "mean_displacement", "sliding_fraction")
MESH = ("x", "z")
TIMES = ("time", "time_rest")  # the second of runs of thousands of years: what a double leaves of the first


class Cells:
    """What has the cells of a fault in a dict mesh: x, z, and of irregular cells y, length, width [m], where they are
    not all vertical along x also strike and dip [degrees] and the fault's label."""

    @property
    def shape(self):
        """(Nz, Nx), from the cell centres whether those are per axis or per cell."""
        return len(np.unique(self.mesh["z"])), len(np.unique(self.mesh["x"]))

    def fault_name(self, label):
        """The name that the file of the mesh has for a fault, or "fault" and its label."""
        if not hasattr(self, "_names"):
            with self.open() as file:
                self._names = names_of(file.get("mesh/fault"))
        return self._names.get(int(label), f"fault {label:g}")

    @property
    def axes(self):
        """Cell centres along strike and in depth [m]."""
        return np.unique(self.mesh["x"]), np.unique(self.mesh["z"])

    @property
    def planes(self):
        """Of a mesh of irregular cells: offset y across strike [m] of each of its planes and the numbers of their
        cells, front to back; of one that names its faults, or whose cells are not all vertical along x, labels of
        faults in place of offsets; None on a grid."""
        if "length" not in self.mesh:
            return None
        if "fault" in self.mesh:
            return [(label, np.flatnonzero(self.mesh["fault"] == label)) for label in np.unique(self.mesh["fault"])]
        return [(y, np.flatnonzero(self.mesh["y"] == y)) for y in np.unique(self.mesh["y"])]


class Contents:
    """What the file of a run holds but for its fields, as it is, in memory after construction; the file is not kept
    open.

    steps   dict of arrays, one value per attempt: time at its start [s], dt [s], error, ...
    series  dict of arrays, a value for the start and one per accepted step: time [s], mean_slip_rate [m/s], mean_slip
            [m], ...
    mesh    dict: x, z cell centres [m] and the per-cell parameters; of irregular cells also y, length, width [m];
            empty for other models than the fault
    summary dict of attributes of /result, of a run that has not ended empty
    parameters  dict: every parameter that is one number, and choices; of files of before 0.3 empty
    run     dict of attributes: options, versions, ranks, policy, wall time
    complete  whether the run has ended; a file that grows is read up to the rows that all datasets of a group have
    units   dict from "/group/dataset" to its unit
    """

    def __init__(self, path):
        self.path = os.fspath(path)
        self.units = {}
        with self.open() as file:
            self.read(file)

    def open(self):
        return open_file(self.path, f"a run writes it with -fault_output {self.path} (or -circuit_output, ...)")

    def read(self, file):
        self.complete = is_complete(file)
        self.run, self.summary, self.parameters = (attributes(file.get(name))
                                                   for name in ("run", "result", "parameters"))
        self.steps, self.series, self.mesh = (self.group(file, name) for name in ("steps", "series", "mesh"))

    def group(self, file, name):
        """Columns and attributes of a group, empty where it is not there."""
        if name not in file:
            return {}
        data, units = columns(file[name], not self.complete)
        self.units.update((f"/{name}/{key}", unit) for key, unit in units.items())
        return {**attributes(file[name]), **data}


class Constant:
    """A number for each cell as a dataset with one row."""

    def __init__(self, cells):
        self.attrs, self.name, self.shape, self.ndim = cells.attrs, cells.name, (1, *cells.shape), 1 + cells.ndim
        self._cells = cells

    def __len__(self):
        return 1

    def __getitem__(self, rows):
        return self._cells[...][np.newaxis][rows]


class Run(Contents, Cells):
    """The contents of a file that has all that pictures and tables need, and what follows from them.

    result  dict of numbers: accepted, rejected, solves, mean_slip [m] of a fault, ...; so far, of a run that has not
            ended
    faults  labels of the faults that series["moment_rate"] [n, faults] has a column for; of older files and other
            models none
    accepted  for each attempt
    """

    def read(self, file):
        self.is_fault = "mesh" in file or "mean_slip" in file.get("series", ())
        fault = self.is_fault
        for name, names in (("steps", STEPS), ("series", ("time",) + (SERIES if fault else ())),
                            *((("mesh", MESH),) if fault else ())):
            self._require_datasets(file, name, names)
        self._require_attributes(file, "run", ())
        if is_complete(file):
            self._require_attributes(file, "result", RESULT + (("mean_slip",) if fault else ()))
        super().read(file)
        for name, data in (("steps", self.steps), ("series", self.series)):
            self._check_rows(name, data)
        self.result = self.summary if self.complete else self._so_far()
        # without axes
        self.field_names = [name for name, data in file.get("fields", {}).items() if name not in TIMES
                            and "CLASS" not in data.attrs]
        rates = file["series"].get("moment_rate")
        self.faults = (np.atleast_1d(rates.attrs["faults"]) if rates is not None and "faults" in rates.attrs
                       else np.array([], int))
        self.accepted = self.steps["accepted"].astype(bool)

    def _require_datasets(self, file, name, required):
        group = file.get(name)
        if not isinstance(group, h5py.Group):
            raise OutputError(f"{self.path}: group /{name} is missing; expected the output of a SlipStep run")
        missing = [key for key in required if not isinstance(group.get(key), h5py.Dataset)]
        if missing:
            raise OutputError(f"{self.path}: dataset /{name}/{missing[0]} is missing; /{name} has {sorted(group)}")

    def _require_attributes(self, file, name, required):
        if name not in file:
            raise OutputError(f"{self.path}: group /{name} is missing; did the run reach its end?")
        missing = [key for key in required if key not in file[name].attrs]
        if missing:
            raise OutputError(f"{self.path}: attribute {missing[0]} of /{name} is missing; it has "
                              f"{sorted(file[name].attrs)}")

    def _so_far(self):
        """What /result will hold, from the rows of a run that has not ended."""
        if not len(self.series["time"]):
            raise OutputError(f"{self.path}: no step of the run is there yet")
        accepted = int(self.steps["accepted"].sum())
        result = {"accepted": accepted, "rejected": len(self.steps["accepted"]) - accepted, "wall_time_setup": 0.0,
                  "wall_time_solve": float(self.steps["wall"].sum())}
        result.update((key, int(self.steps[key].sum())) for key in ("solves", "newton_iterations", "linear_iterations")
                      if key in self.steps)
        if self.is_fault:
            result["mean_slip"] = float(self.series["mean_slip"][-1])
        return result

    @property
    def title(self):
        """The name of the file, and that its run has not ended."""
        return os.path.basename(self.path) + ("" if self.complete
                                              else f" (unfinished, to {written(self.series['time'][-1])})")

    def warn(self):
        """One line on stderr for a run that has not ended."""
        if not self.complete:
            print(f"{program()}: {self.path} is unfinished: complete = 0, its rows end at "
                  f"{written(self.series['time'][-1])}", file=sys.stderr)

    def _check_rows(self, name, columns):
        rows = {key: len(value) for key, value in columns.items() if isinstance(value, np.ndarray) and value.ndim}
        if len(set(rows.values())) > 1:
            raise OutputError(f"{self.path}: datasets of /{name} differ in length: {rows}")

    @property
    def columns(self):
        """Names of the series besides time, with their units."""
        return {name: self.units[f"/series/{name}"] for name in self.series
                if name not in TIMES and f"/series/{name}" in self.units}

    @property
    def extents(self):
        """Of a grid: length_x, length_z, as a catalogue has them."""
        return self.parameters

    def require_fault(self, purpose):
        """What only a fault has is asked for."""
        if not self.is_fault:
            raise OutputError(f"{self.path}: not the output of a fault (/series has {', '.join(self.columns)}); "
                              f"{purpose} needs one")

    @property
    def rejected(self):
        """True for every attempt that was not accepted."""
        return ~self.accepted

    @property
    def peak(self):
        """Index into series of the largest mean slip rate."""
        return int(np.argmax(self.series["mean_slip_rate"]))

    def field(self, name):
        """Times [n] and maps [n, Nz, Nx], or [n, N] of irregular cells, of a field that the run stored; of two
        components the magnitude, or one of them, as of "slip_along_strike" and "slip_up_dip"."""
        source, part = split(name)
        with self.open() as file:
            times, data = self.stored(file, source)
            maps = data[:len(times)]
            if maps.ndim > (2 if self.planes else 3):
                maps = drawn(maps, part)
            elif part is not None:
                raise OutputError(f"{self.path}: {source} has one component; expected a run with "
                                  "-fault_slip_components 2")
            return times, maps

    def stored(self, file, source):
        """Times of the rows that a dataset of /fields has, and the dataset, which may have more; of a parameter of the
        cells one row, for the start."""
        group, cells = file.get("fields"), file.get(f"mesh/{source}")
        shape = (len(self.mesh["x"]),) if self.planes else self.shape
        if (group is None or source not in group) and cells is not None and cells.shape == shape:
            return np.zeros(1), Constant(cells)
        if group is None or source not in group or "time" not in group or source in TIMES:
            raise OutputError(f"{self.path}: field {source} was not stored (there are: "
                              f"{', '.join(self.field_names) or 'none'}); run with -fault_output_fields {source}")
        return group["time"][:len(group[source])], group[source]

    def has_vectors(self, name):
        """Whether a field has two components, which field() takes apart by "slip_along_strike" and "slip_up_dip"."""
        with self.open() as file:
            data = file.get(f"fields/{name}")
            return data is not None and data.ndim > (2 if self.planes else 3)

    def field_at(self, name, time):
        """The stored map nearest to a time [s]: its own time and the map [Nz, Nx], or [N] of irregular cells."""
        times, maps = self.field(name)
        if not len(times):
            raise OutputError(f"{self.path}: /fields/{name} has no rows")
        row = int(np.argmin(np.abs(times - time)))
        return times[row], maps[row]
