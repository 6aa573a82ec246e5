"""Runs of a fault by the program `fault`, and what they share with those in this process (slipstep.petsc)."""

import ctypes
import functools
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from .errors import Error, warn, warnings_of
from .modules import ENVIRONMENT, program_fault
from .times import written

# of names that are options of PETSc and not parameters of a fault
OPTION = re.compile(r"(ts|snes|ksp|pc|mat|log|options)_")
REPEAT, MINUTE = 0.2, 60.0  # between two lines of progress [s], in a terminal and in a log
PATIENCE = 5.0  # until a program that was asked to end is killed [s]
PR_SET_PDEATHSIG = 1
_libc = ctypes.CDLL(None)


def follow(parent):
    """In a new process: stop as by SIGUSR1, with a checkpoint, when its parent is killed."""
    if hasattr(_libc, "prctl"):
        _libc.prctl(PR_SET_PDEATHSIG, signal.SIGUSR1)
    if os.getppid() != parent:
        os._exit(128 + signal.SIGUSR1)


def say_stopping(what, again=True):
    """After a first Ctrl-C; again: whether a second one does not wait."""
    print(f"slipstep: {what} after the step in work" + ("; Ctrl-C again ends at once" if again else ""),
          file=sys.stderr, flush=True)


class Line:
    """A line of progress, written again and again: in a terminal and below the cell of a notebook; apart: in a log, one
    once a minute."""

    def __init__(self, shown, apart=False):
        self.shown, self.apart, self.begin = shown, apart, time.monotonic()
        self.last = self.begin if apart else 0.0
        self.width, self.newest, self.out = 0, None, sys.stdout

    def show(self, at, end, steps, rate, force=False):
        self.newest = (at, end, steps, rate)
        share = f" ({100 * at / end:.1f} %)" if end and end > 0 and end < 1e300 else ""
        self.tell(f"time {written(at)}{share}, {steps} steps, largest slip rate {rate:.3g} m/s", force)

    def tell(self, text, force=False):
        """How far something is, with the time that it has taken [s]."""
        now = time.monotonic()
        if not self.shown or (now - self.last < (MINUTE if self.apart else REPEAT) and not force):
            return
        self.last = now
        text += f", {now - self.begin:.1f} s"
        self.width = max(self.width, len(text))
        self.out.write(f"{text}\n" if self.apart else "\r" + text.ljust(self.width))
        self.out.flush()

    def close(self):
        if self.shown and self.width and not self.apart:
            if self.newest:
                self.show(*self.newest, force=True)
            self.out.write("\n")
            self.out.flush()


def options_of(path):
    """Names of the options of faults in a file of options, without "fault_"."""
    if path is None:
        return set()
    try:
        with open(path, encoding="utf-8") as file:
            lines = file.read().splitlines()
    except OSError as error:
        raise Error(f"cannot read {path} (options_file): {error.strerror}") from None
    return {match[1] for match in (re.match(r"\s*-fault_(\w+)", line) for line in lines) if match}


@functools.lru_cache(maxsize=None)
def option_units():
    """Units of the parameters of faults by the names of their options without "fault_", as the help of the program has
    them; empty where there is no program."""
    try:
        said = subprocess.run([program_fault(), "-help", "fault"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                              encoding="utf-8", env={**ENVIRONMENT, **os.environ}, check=False).stdout
    except (Error, OSError):
        return {}
    lines = (re.match(r"\s*-fault_(\w+):? <.*?>:(.*)", line) for line in said.splitlines())
    found = {line[1]: re.findall(r" \[([^\[\]]+)\]", line[2]) for line in lines if line}
    return {name: units[0] for name, units in found.items() if units}


def word(value):
    """A value as the command line has it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return repr(value) if isinstance(value, float) else str(value)


def command(fault, given, arrays, folder):
    """The words that start the program on a fault; arrays go into a file in the folder."""
    words = [program_fault()]
    if "options_file" in fault._options:  # what follows overrides it
        words += ["-options_file", word(fault._options["options_file"])]
    words += ["-fault_progress", "no"]
    if arrays:
        if "parameters" in given:
            raise Error(f"parameters is {given['parameters']}, and {', '.join(arrays)} are arrays or functions: "
                        "expected one of them")
        import h5py
        import numpy as np
        given["parameters"] = os.path.join(folder, "parameters.h5")
        nz, nx = int(given.get("nz", 0)), int(given.get("nx", 0))
        with h5py.File(given["parameters"], "w") as file:
            for name, value in arrays.items():
                value = np.asarray(value, dtype=float)
                if value.ndim == 2 and fault._has_mesh():
                    value = value.ravel()
                elif value.ndim == 1 and not fault._has_mesh() and value.size == nz * nx:
                    value = value.reshape(nz, nx)
                file[name] = value
    if fault._stresses and folder:
        if "stress_history" in given:
            raise Error(f"stress_history is {given['stress_history']}, and add_stress() was called: expected one of "
                        "them")
        import h5py
        given["stress_history"] = os.path.join(folder, "stress_history.h5")
        with h5py.File(given["stress_history"], "w") as file:
            for k, stress in enumerate(fault._stresses):
                for name, value in stress.items():
                    if value is not None:
                        file[f"stress_{k + 1}/{name}"] = value
    for name, value in given.items():
        words += [f"-fault_{name}", word(value)]
    for name, value in fault._options.items():
        if name != "options_file":
            words += [f"-{name}", word(value)]
    return words


def np_array(value):
    """Numbers in double precision."""
    import numpy as np
    return np.array(value, dtype=np.float64)


def cells_of(options):
    """The slipstep.fields.Cells of the fault of these options of the program, a list of words."""
    from .fields import read_cells
    folder = Program.folder()
    try:
        path = os.path.join(folder, "cells.h5")
        done = subprocess.run([program_fault(), *options, "-fault_cells", path], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, encoding="utf-8", env={**ENVIRONMENT, **os.environ},
                              check=False)
        warn(*warnings_of(done.stdout))
        if done.returncode:
            raise Error(_reason(done.stdout, done.returncode))
        return read_cells(path)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def refused_mesh(path):
    """What the program says that refuses a file of -fault_mesh; empty: it takes it, or is not there."""
    try:
        cells_of(["-fault_mesh", path])
    except Error as error:
        return str(error)
    return ""


class Program:
    """How the program runs a fault; the same functions of slipstep.petsc run it in this process."""

    @staticmethod
    def folder():
        """A temporary one."""
        if int(os.environ.get("OMPI_COMM_WORLD_SIZE", os.environ.get("PMI_SIZE", "1"))) > 1:
            raise Error("the program cannot be started by several processes: expected one, or petsc4py")
        return tempfile.mkdtemp(prefix="slipstep-")

    @staticmethod
    def remove(folder):
        shutil.rmtree(folder, ignore_errors=True)

    @staticmethod
    def run(fault, given, folder, progress):
        """True when it was interrupted."""
        words = command(fault, given, {**fault._arrays, **fault._evaluated()}, folder)
        line, interrupted = Line(progress), False
        log = os.path.join(folder, "log")
        with open(log, "w+", encoding="utf-8") as output:
            # of a session of its own: a terminal would send it Ctrl-C besides this process, and the second signal ends
            # it at once
            child = subprocess.Popen(words, stdout=output, stderr=subprocess.STDOUT, env={**ENVIRONMENT, **os.environ},
                                     start_new_session=True, preexec_fn=functools.partial(follow, os.getpid()))
            try:
                while child.poll() is None:
                    try:
                        time.sleep(0.05)
                        if progress:
                            _show(line, given["output"] + ".part", fault)
                    except KeyboardInterrupt:
                        if interrupted:
                            raise
                        interrupted = True
                        child.send_signal(signal.SIGINT)
                        say_stopping("the run stops")
            finally:  # whatever was raised, no program is left that writes to a folder which is gone
                _end(child)
                line.close()
            output.seek(0)
            text = output.read()
        warn(*warnings_of(text))
        if child.returncode not in (0, 3) and not interrupted:
            raise Error(_reason(text, child.returncode))
        return interrupted

    @staticmethod
    def warn(result):
        """Of a run that is over; those of the program are told as it printed them, also where it fails."""


class Runs:
    """run(), for the fault of a process and of the program."""

    backends = {"program": Program}

    def _remember(self):
        self._given, self._options, self._arrays, self._functions = {}, {}, {}, {}
        self._stresses = []

    def _record(self, parameters):
        """The parameters of the fault among those given; others are options of PETSc, and are kept for run()."""
        mine = {}
        for name, value in parameters.items():
            name = name[1:] if name.startswith("-") else name
            if OPTION.match(name):
                self._options[name] = value
                continue
            array = getattr(value, "ndim", 0) > 0 or isinstance(value, (list, tuple))
            kinds = [self._functions, self._arrays, self._given]
            kind = kinds[0] if callable(value) else kinds[1] if array else kinds[2]
            for other in kinds:
                other.pop(name, None)
            kind[name] = value
            if kind is not self._functions:  # which wait for the cells
                mine[name] = value
        return mine

    def add_stress(self, time, course, shear=None, normal=None):
        """Add a stress that changes in time, as a group of -fault_stress_history does: course, dimensionless, at times
        [s], ascending, linear between them and constant beyond, times shear along the rake and normal, positive in
        compression [Pa]: numbers, or arrays of the cells, [nz, nx] or [n], of shear also with a last dimension of 2,
        along strike and up dip. Stresses add up."""
        stress = {"time": time, "course": course, "shear": shear, "normal": normal}
        self._stresses.append({name: None if value is None else np_array(value) for name, value in stress.items()})
        return self._stresses[-1]

    def _has_mesh(self):
        return "mesh" in self._given or "mesh" in options_of(self._options.get("options_file"))

    def _with_cells(self):
        """What is given, with the cells that a fault has by default where nothing says how many."""
        given = dict(self._given)
        in_file = options_of(self._options.get("options_file"))
        if not self._has_mesh():
            for name in ("nx", "nz"):
                if name not in in_file:
                    given.setdefault(name, 10)
        return given

    def _evaluated(self):
        """Arrays of the parameters that are functions, for the fault as it is now."""
        if not self._functions:
            return {}
        from .fields import evaluate
        cells = self.cells()
        return {name: evaluate(name, function, cells) for name, function in self._functions.items()}

    def cells(self):
        """The cells of the fault as it is now, slipstep.fields.Cells: centres [m], area [m^2], strike, dip [degrees]
        and fault, each [nz, nx], or [1, n] of a mesh. At any time."""
        given = {name: value for name, value in self._with_cells().items()
                 if name not in ("output", "catalogue", "checkpoint", "restart")}
        return cells_of(command(self, given, {}, None)[1:])

    def centres(self):
        """x north, or along strike of a vertical grid, y east, or to its right, and z down [m] of the cells, each [nz,
        nx], or [1, n] of a mesh. At any time."""
        cells = self.cells()
        return cells.x, cells.y, cells.z

    def write_fields(self, path):
        """A file for -fault_parameters with the parameters that are functions or arrays, for this fault."""
        from .fields import write
        write(path, {**self._arrays, **self._functions}, self.cells())

    def run(self, progress=True, backend=None):
        """Run to the end, and return a Result. The fields, stations and events need no file: files that output= and
        catalogue= name stay, others are temporary.

        progress  a line that tells the simulated time, steps and largest slip rate while the run goes on
        backend   "petsc": in this process; "program": by the program fault; None: that of this object

        An interrupt (Ctrl-C, or the stop button of a notebook) ends the run after its step, and the Result has what
        there is. A second Ctrl-C does not wait for the step: the program is ended and KeyboardInterrupt raised, and of
        the backend "petsc" this process ends, unless it is a notebook's or one of several. Error: what the program
        refuses, by its own line. Warnings of the program are SlipStepWarnings, and in Result.warnings. With several
        processes (mpirun python) every process must call it, and the program backend cannot be used."""
        backend = backend or self.backend
        if backend not in ("petsc", "program"):
            raise ValueError(f"backend is {backend!r}, expected 'petsc' or 'program'")
        if backend not in self.backends:
            raise Error("backend='petsc' needs petsc4py and the library of SlipStep")
        runner = self.backends[backend]
        from .results import Result  # with h5py, after the library that brings an HDF5 of its own
        given = self._with_cells()
        folder = runner.folder()
        try:
            given.setdefault("output", os.path.join(folder, "run.h5"))
            given.setdefault("catalogue", os.path.join(folder, "events.h5"))
            interrupted = runner.run(self, given, folder, progress)
            found = [name if os.path.exists(name) and not interrupted else name + ".part"
                     for name in (given["output"], given["catalogue"])]
            if not os.path.exists(found[0]):
                if interrupted:
                    raise KeyboardInterrupt
                raise Error("the run has written nothing")
            result = Result(found[0], found[1] if os.path.exists(found[1]) else None)
            runner.warn(result)
            return result
        finally:
            runner.remove(folder)


def _reason(text, code):
    """What the program says of its error."""
    lines = re.findall(r"(?m)^\S+: error: (.*)$", text)
    return lines[-1] if lines else f"the program ended with the code {code}: {text.strip()[-300:]}"


def _end(child):
    """Stop a program after its step if it still runs, and at once if it does not end soon or somebody is in a hurry."""
    try:
        if child.poll() is None:
            child.terminate()
            child.wait(PATIENCE)
    except subprocess.TimeoutExpired:
        pass
    finally:
        if child.poll() is None:
            child.kill()
            child.wait()


def _show(line, path, fault):
    """The newest rows of a file that grows."""
    if time.monotonic() - line.last < REPEAT or not os.path.exists(path):
        return
    from .results.files import open_any
    try:
        with open_any(path) as file:
            at, rate = file["series/time"], file["series/max_slip_rate"]
            n = min(len(at), len(rate))
            if n:
                line.show(float(at[n - 1]), None, n - 1, float(rate[n - 1]))
    except (OSError, KeyError, RuntimeError):  # of h5py
        return  # it is being made


class Fault(Runs):
    """A fault that the program simulates: parameters by the names of their options without "fault_" (nx=50,
    normal_stress=50e6, mesh="m.h5", inertia=False), numpy arrays for fields [nz, nx] or functions of the cells
    (slipstep.fields), and options of PETSc such as ts_max_time="100y". Units are SI, as those of the program."""

    backend = "program"

    def __init__(self, **parameters):
        self._remember()
        self.set(**parameters)

    def set(self, name=None, value=None, /, **parameters):
        """Set or replace parameters and options, set("friction_a", value) or set(friction_a=value); names are checked
        when the fault runs."""
        self._record(parameters if name is None else {name: value, **parameters})
