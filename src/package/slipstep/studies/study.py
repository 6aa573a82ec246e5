"""A study of many runs, from a file or from Python."""

import os
import re

import numpy as np

from ..errors import Error
from ..results import Result
from ..running import option_units
from ..results.files import replacing, write_csv
from .plan import Plan
from .record import Record, lock
from .runner import drive
from . import slurm, table as columns


# options of PETSc in seconds, where they are numbers
TIMES = ("ts_max_time", "ts_dt", "ts_time_step", "ts_adapt_dt_min", "ts_adapt_dt_max", "ts_init_time")


def read(path):
    """The content of a study file, TOML."""
    import tomllib
    try:
        with open(path, "rb") as file:
            return tomllib.load(file)
    except OSError as error:
        raise Error(f"cannot read {path}: {error.strerror}; expected a study file") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise Error(f"{path}: {error}; expected a study file in TOML") from None


class StudyRun(Record):
    """One run of a study: number, values (what differs between runs), folder, status: "ended", "early" (before its
    final time), "failed", "begun" or "open" (not started); error, its line; warnings, a list of lines; result, the
    Result of its files."""

    number = property(lambda self: self.planned.number)
    values = property(lambda self: self.planned.values)

    @property
    def error(self):
        return (self.outcome or {}).get("error", "")

    @property
    def result(self):
        """The Result of run.h5 and events.h5; of one that has not ended as far as it has come."""
        found = [next((path for path in (self.file(name), self.file(name) + ".part") if os.path.exists(path)), None)
                 for name in ("run.h5", "events.h5")]
        if found == [None, None]:
            raise Error(f"run {self.number} has no files in {self.folder}")
        return Result(*found)

    def __repr__(self):
        return f"<run {self.number}: {self.words}: {self.status}>"

    @property
    def words(self):
        """What differs, in words."""
        return ", ".join(f"{name} = {value:g}" if isinstance(value, float) else f"{name} = {value}"
                         for name, value in self.values.items())


class Study:
    """Many runs with options that differ, each over once, and one table of them.

        study = slipstep.Study("study.toml")
        study = slipstep.Study(folder="stress", options={"ts_max_time": "30s"}, vary={"normal_stress": [40e6, 50e6]},
        seeds=3)
        study.run(cores=8)                  # also after it was killed: what is over is not run again
        study.rows, study.table             # dicts; a pandas.DataFrame where pandas is installed
        study.dataset                       # xarray.Dataset, a dimension for each that is varied
        study.plot("magnitude", "normal_stress", "stress.png")

    file    a study file; without it the keywords are its keys (see slipstep.studies.plan): command, options_file,
            options, vary, zip, seeds, before, ranks, launcher, cores, checkpoint, table, folder, slurm. Lists of vary
            may be NumPy arrays
    folder  of the runs; by default the name of the file with .runs in place of .toml
    runs    list of StudyRun

    Relative names in a study are from the folder of its file, in which its commands start; without a file from the
    current folder. Error: a key, value or file that is not as expected."""

    def __init__(self, file=None, **given):
        if file is None and not given.get("folder"):
            raise Error("a study needs a file, or a folder for its runs (folder=)")
        self.source = os.path.abspath(file) if file else f"study {given['folder']}"
        base = os.path.dirname(self.source) if file else os.getcwd()
        self.plan = Plan(self.source if file is None else os.fspath(file), {**(read(file) if file else {}), **given},
                         base)
        self.folder = os.path.join(base, self.plan.given["folder"] or os.path.splitext(self.source)[0] + ".runs")
        self.runs = [StudyRun(self.folder, planned) for planned in self.plan.runs]

    # Runs

    def hold(self, shared=False):
        """The lock of the study: one driver, or any number of tasks of a job array."""
        if int(os.environ.get("OMPI_COMM_WORLD_SIZE", os.environ.get("PMI_SIZE", "1"))) > 1:
            raise Error(f"{self.plan.source}: a study cannot be run by several processes: expected one, which starts "
                        "the ranks of each run")
        os.makedirs(self.folder, exist_ok=True)
        held = lock(os.path.join(self.folder, "lock"), shared)
        if held is None:
            raise Error(f"{self.plan.source}: another driver or a job array is at work in {self.folder}; wait for "
                        "it, or end it")
        return held

    def run(self, cores=None, retry=False, progress=True):
        """Run what is not over, as many runs at once as cores and their ranks allow, and return self. A run that fails
        is reported, and the others go on; retry begins failed ones anew. Ctrl-C stops all with a checkpoint, from which
        the next call goes on; KeyboardInterrupt follows."""
        held = self.hold()
        try:
            for run in self.runs:
                if retry and run.status == "failed":
                    run.forget()
            over = sum(run.status in ("ended", "early", "failed") for run in self.runs)
            if progress and over:
                print(f"{over} of {len(self.runs)} runs are over", flush=True)
            if drive(self.plan, self.folder, self.plan.runs, cores, self.say if progress else None):
                raise KeyboardInterrupt
        finally:
            os.close(held)
        return self

    def say(self, record, status, active, left):
        run = self.runs[record.planned.number - 1]
        what = {"ended": "ended", "early": "ended before its final time", "failed": f"failed: {run.error}",
                "stopped": "stopped, goes on at the next call"}[status]
        what += f", with {counted(len(run.warnings), 'warning')}" if run.warnings else ""
        print(f"run {run.number} of {len(self.runs)} ({run.words}) {what}; {active} under way, {left} left", flush=True)

    def task(self, number):
        """Run one alone, as a task of a job array does: True when it is over, False when a signal has stopped it."""
        if not 1 <= number <= len(self.runs):
            raise Error(f"{self.plan.source}: there is no run {number}, expected 1 to {len(self.runs)}")
        held = self.hold(shared=True)
        try:
            planned = self.plan.runs[number - 1]
            return not drive(self.plan, self.folder, [planned], planned.ranks, self.say)
        finally:
            os.close(held)

    def slurm(self, path, program):
        """Write a job array for the runs that are not over; program: the words that start slipstep sweep there."""
        os.makedirs(self.folder, exist_ok=True)
        text = slurm.script(self.plan, self.folder, self.source, [run.number for run in self.runs if run.status not
                                                                  in ("ended", "early", "failed")], path, program)
        with replacing(path) as part, open(part, "w", encoding="utf-8") as file:
            file.write(text)

    # Table

    @property
    def columns(self):
        names = list(self.plan.given["table"] or columns.DEFAULT)
        return (names if self.plan.command != "fault" or "left_out" in names or not any(map(columns.is_spun, names))
                else ["left_out", *names])

    @property
    def varied(self):
        """Names of what differs between runs."""
        return [name for names, _ in self.plan.axes for name in names]

    @property
    def rows(self):
        """A dict for each run: run (its number), status, what differs, columns (None where there is no such number),
        folder, error."""
        found = []
        for run in self.runs:
            outcome = run.outcome
            row = {"run": run.number, "status": run.status, **run.values}
            files = columns.Files(run, self.plan.given["spin_up"])
            for name in self.columns:
                row[name] = columns.value(name, files, outcome) if outcome else None
            found.append({**row, "folder": os.path.relpath(run.folder, self.folder), "error": run.error})
        return found

    @property
    def empty(self):
        """Columns that are asked for and that no run which ended has, and why."""
        rows = [row for row in self.rows if row["status"] in ("ended", "early")]
        names = sorted({name for run in self.runs if run.status in ("ended", "early")
                        for name in columns.Files(run).numbers})
        return [(name, columns.why_empty(name, names)) for name in self.plan.given["table"] or () if rows
                and all(row[name] is None or row[name] != row[name] for row in rows)]

    @property
    def warnings(self):
        """Of what runs warn: for each text, whose numbers may differ between runs, the first one's line and the runs
        that have it."""
        found = {}
        for run in self.runs:
            for line in run.warnings:
                found.setdefault(re.sub(r"[-+]?[0-9][0-9.]*(?:e[-+]?[0-9]+)?", "#", line),
                                 (line, {}))[1][run.number] = run
        return [(line, list(runs.values())) for line, runs in found.values()]

    @property
    def table(self):
        """Rows as a pandas.DataFrame, or as a structured array where there is no pandas; numbers that are not there are
        NaN."""
        rows = self.rows
        try:
            import pandas
        except ImportError:
            kinds = [(name, *array(rows, name).dtype.descr[0][1:]) for name in rows[0]]
            found = np.empty(len(rows), dtype=kinds)
            for name in rows[0]:
                found[name] = array(rows, name)
            return found
        return pandas.DataFrame({name: array(rows, name) for name in rows[0]})

    @property
    def dataset(self):
        """The table as xarray.Dataset: a dimension for each list of vary and for the seeds, one for each zip."""
        try:
            import xarray
        except ImportError:
            raise Error("dataset needs xarray; Debian's package is python3-xarray") from None
        rows = self.rows
        shape = [len(positions) for _, positions in self.plan.axes]
        dims = [names[0] if len(names) == 1 else "_".join(names) for names, _ in self.plan.axes]
        coordinates = {name: (dim, [row[k] for row in positions])
                       for dim, (names, positions) in zip(dims, self.plan.axes) for k, name in enumerate(names)}
        names = [name for name in rows[0] if name not in self.varied]
        variables = {name: (dims, array(rows, name).reshape(shape),
                            {"units": columns.unit(name)} if name in self.columns else {}) for name in names}
        return xarray.Dataset(variables, coordinates, {"study": self.plan.source})

    def write_csv(self, path):
        """The table, a line for each run, numbers to their last bit."""
        rows = self.rows
        write_csv(path, [[name + (f" [{columns.unit(name)}]" if name in self.columns and columns.unit(name) != "1"
                                  else "") for name in rows[0]], *(row.values() for row in rows)])

    def plot(self, y, x, path, by=None):
        """A picture of one column against what is varied: a line for each value of `by`, by default of the first other
        thing that is varied; of several runs at a point (seeds) mean and standard deviation, of single ones the spread
        of the number itself, where it has one."""
        from ..plots.sweep import figure
        rows = self.rows
        for name in (y, x, *([by] if by else [])):
            if name not in rows[0]:
                raise Error(f"{self.plan.source}: there is no column {name}, expected one of {', '.join(rows[0])}")
        by = by or next((name for name in self.varied if name not in (x, "seed")), None)
        spreads = [columns.spread(y, columns.Files(run, self.plan.given["spin_up"])) if run.outcome else None
                   for run in self.runs]
        figure(rows, x, y, by, {name: self.unit(name) for name in (x, y, by) if name}, spreads).savefig(path)

    def unit(self, name):
        """Of a column, be it what runs find or an option that is varied: "" where there is none."""
        found = columns.unit(name) if name in self.columns else option_units().get(
            name.removeprefix("fault_"), "s" if name in TIMES else "") if self.plan.command == "fault" else ""
        return "" if found == "1" else found


def counted(number, name):
    return f"{number} {name}{'s' * (number != 1)}"


def array(rows, name):
    """A column: numbers as floats or integers, NaN where there is none, else texts."""
    values = [row[name] for row in rows]
    if all(isinstance(value, bool) for value in values):
        return np.array(values)
    if all(isinstance(value, int) and not isinstance(value, bool) for value in values):
        return np.array(values)
    if all(value is None or isinstance(value, (int, float)) for value in values):
        return np.array([np.nan if value is None else value for value in values], dtype=float)
    return np.array(["" if value is None else str(value) for value in values])


