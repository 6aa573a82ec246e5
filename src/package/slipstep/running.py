"""Runs of a fault: in this process by petsc4py, or by the program `fault`."""

import contextlib
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

from .errors import Error
from .results import Result

OPTION = re.compile(r"(ts|snes|ksp|pc|mat|log|options)_")  # of names that are options of PETSc and not parameters of a fault
# of the program, unless it is set: one thread, and no look at OpenCL's devices, whose drivers take over signals
ENVIRONMENT = {"OPENBLAS_NUM_THREADS": "1", "HWLOC_COMPONENTS": "-opencl"}
REPEAT = 0.2  # between two lines of progress [s]
PATIENCE = 5.0  # until a program that was asked to end is killed [s]


def fault_class():
    """The Fault of this machine: with petsc4py and the library that of slipstep.petsc, else one that starts the program."""
    if os.environ.get("SLIPSTEP_BACKEND") != "program":
        try:
            from . import petsc
            petsc.load()
            return petsc.Fault
        except (ImportError, OSError):
            if os.environ.get("SLIPSTEP_BACKEND") == "petsc":
                raise
    return Fault


def find_program():
    """The program `fault`: that of SLIPSTEP_FAULT, beside this package, or on PATH."""
    named = os.environ.get("SLIPSTEP_FAULT")
    if named:
        if not os.access(named, os.X_OK):
            raise Error(f"SLIPSTEP_FAULT is {named}, expected a program")
        return named
    folder = os.path.dirname(os.path.abspath(__file__))
    for up in (("..", "..", ".."), ("..", "..", "..", "..")):
        for name in ("slipstep-fault", "fault"):
            path = os.path.normpath(os.path.join(folder, *up, "bin", name))
            if os.access(path, os.X_OK):
                return path
    path = shutil.which("slipstep-fault") or shutil.which("fault")
    if not path:
        raise Error("there is neither petsc4py with the library of SlipStep nor the program fault: set SLIPSTEP_LIBRARY, or SLIPSTEP_FAULT to the program")
    return path


class Line:
    """A line of progress, written again and again: in a terminal and below the cell of a notebook."""

    def __init__(self, shown):
        self.shown, self.last, self.begin = shown, 0.0, time.monotonic()
        self.width, self.newest, self.out = 0, None, sys.stdout

    def show(self, at, end, steps, rate, force=False):
        now = time.monotonic()
        self.newest = (at, end, steps, rate)
        if not self.shown or (now - self.last < REPEAT and not force):
            return
        self.last = now
        share = f" ({100 * at / end:.1f} %)" if end and end > 0 and end < 1e300 else ""
        text = f"time {written(at)}{share}, {steps} steps, largest slip rate {rate:.3g} m/s, {now - self.begin:.1f} s"
        self.width = max(self.width, len(text))
        self.out.write("\r" + text.ljust(self.width))
        self.out.flush()

    def close(self):
        if self.shown and self.newest:
            self.show(*self.newest, force=True)
            self.out.write("\n")
            self.out.flush()


def written(at):
    for unit, size in (("years", 3.15576e7), ("days", 86400.0), ("hours", 3600.0)):
        if at >= 2 * size:
            return f"{at / size:.4g} {unit}"
    return f"{at:.4g} s"


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


def word(value):
    """A value as the command line has it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return repr(value) if isinstance(value, float) else str(value)


class Runs:
    """run(), for the fault of a process and of the program."""

    def _remember(self):
        self._given, self._options, self._arrays = {}, {}, {}

    def _record(self, parameters):
        """The parameters of the fault among those given; others are options of PETSc, and are kept for run()."""
        mine = {}
        for name, value in parameters.items():
            name = name[1:] if name.startswith("-") else name
            if OPTION.match(name):
                self._options[name] = value
                continue
            mine[name] = value
            array = getattr(value, "ndim", 0) > 0 or isinstance(value, (list, tuple))
            (self._arrays if array else self._given)[name] = value
            (self._given if array else self._arrays).pop(name, None)
        return mine

    def run(self, progress=True, backend=None):
        """Run to the end, and return a Result. The fields, stations and events need no file: files that output= and catalogue= name stay,
        others are temporary.

        progress  a line that tells the simulated time, steps and largest slip rate while the run goes on
        backend   "petsc": in this process; "program": by the program fault; None: that of this object

        An interrupt (Ctrl-C, or the stop button of a notebook) ends the run after its step, and the Result has what there is. Error: what the
        program refuses, by its own line. With several processes (mpirun python) every process must call it, and the program backend cannot be used."""
        backend = backend or self.backend
        if backend not in ("petsc", "program"):
            raise ValueError(f"backend is {backend!r}, expected 'petsc' or 'program'")
        if backend == "petsc" and self.backend != "petsc":
            raise Error("backend='petsc' needs petsc4py and the library of SlipStep")
        given = dict(self._given)
        in_file = options_of(self._options.get("options_file"))
        if "mesh" not in given and "mesh" not in in_file:
            for name in ("nx", "nz"):
                if name not in in_file:
                    given.setdefault(name, 10)
        folder = _folder(self, backend)
        try:
            given.setdefault("output", os.path.join(folder, "run.h5"))
            given.setdefault("catalogue", os.path.join(folder, "events.h5"))
            run = _in_process if backend == "petsc" else _by_program
            interrupted = run(self, given, folder, progress)
            found = [name if os.path.exists(name) and not interrupted else name + ".part" for name in (given["output"], given["catalogue"])]
            if not os.path.exists(found[0]):
                if interrupted:
                    raise KeyboardInterrupt
                raise Error("the run has written nothing")
            return Result(found[0], found[1] if os.path.exists(found[1]) else None)
        finally:
            _remove(self, backend, folder)


def _folder(fault, backend):
    """A temporary folder, the same on every process."""
    if backend == "petsc":
        from petsc4py import PETSc
        if PETSc.COMM_WORLD.getSize() > 1:
            try:
                comm = PETSc.COMM_WORLD.tompi4py()
            except ImportError:
                raise Error("run() on several processes needs mpi4py; Debian's package is python3-mpi4py") from None
            return comm.bcast(tempfile.mkdtemp(prefix="slipstep-") if comm.rank == 0 else None)
    elif int(os.environ.get("OMPI_COMM_WORLD_SIZE", os.environ.get("PMI_SIZE", "1"))) > 1:
        raise Error("the program cannot be started by several processes: expected one, or petsc4py")
    return tempfile.mkdtemp(prefix="slipstep-")


def _remove(fault, backend, folder):
    if backend == "petsc":
        from petsc4py import PETSc
        PETSc.COMM_WORLD.barrier()
        if PETSc.COMM_WORLD.getRank():
            return
    shutil.rmtree(folder, ignore_errors=True)


def _in_process(fault, given, folder, progress):
    """True when it was interrupted."""
    from petsc4py import PETSc
    from . import petsc
    database = PETSc.Options()
    before = database.getAll()
    line = Line(progress and not PETSc.COMM_WORLD.getRank())
    interrupted, ts = False, None

    def interrupt(number, frame):
        nonlocal interrupted
        interrupted = True  # the monitor ends the run: petsc4py would lose an exception in some places

    def monitor(ts, step, at, w):
        if interrupted:
            raise KeyboardInterrupt
        if progress:  # on every process
            line.show(at, ts.getMaxTime(), step, petsc.largest_rate(ts, w))

    try:
        if "options_file" in fault._options:
            database.insertString("-options_file " + word(fault._options["options_file"]))
            if database.hasName("fault_nx") and "nx" not in given:  # arrays need the shape before the options are read
                given = {**given, "nx": database.getInt("fault_nx")}
            if database.hasName("fault_nz") and "nz" not in given:
                given = {**given, "nz": database.getInt("fault_nz")}
            for name in (*given, *fault._arrays):  # what is given here overrides the file
                database.delValue(f"fault_{name}")
        for name, value in fault._options.items():
            if name != "options_file":
                database.setValue(name, word(value))
        inner = petsc.Fault(getattr(fault, "_comm_given", None), **given, **fault._arrays)
        try:
            ts = PETSc.TS().create(getattr(fault, "_comm_given", None))
            if "progress" not in given:
                inner.set(progress=False)
            inner.configure(ts)
            ts.setFromOptions()
            for name in fault._options:
                if name != "options_file" and not petsc.used(name):
                    raise Error(f"nothing reads the option -{name}")
            ts.setMonitor(monitor)
            try:
                with handled(interrupt), petsc.silence():
                    inner.solve(ts)
            except (KeyboardInterrupt, PETSc.Error):
                if not interrupted:
                    raise
        finally:
            inner.destroy()
            if ts:
                ts.destroy()
    except PETSc.Error as error:
        raise Error(message_of(error)) from None
    finally:
        line.close()
        for name in set(database.getAll()) - set(before):
            database.delValue(name)
        for name, value in before.items():
            database.setValue(name, value)
    return interrupted


@contextlib.contextmanager
def handled(function):
    """SIGINT calls a function meanwhile; other threads than the main one cannot have that."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, function)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def message_of(error):
    """The line of an error of PETSc, without its stack."""
    lines = [re.sub(r"^\[\d+\] ?", "", text).strip() for text in str(error).split("\n")]
    lines = [text for text in lines if text and not re.match(r"(error code|\S+\(\) at |\w+\(\) line )", text)]
    return lines[-1] if lines else str(error)


def _by_program(fault, given, folder, progress):
    """True when it was interrupted."""
    words = [find_program()]
    if "options_file" in fault._options:  # what follows overrides it
        words += ["-options_file", word(fault._options["options_file"])]
    words += ["-fault_progress", "no"]
    if fault._arrays:
        if "parameters" in given:
            raise Error(f"parameters is {given['parameters']}, and {', '.join(fault._arrays)} are arrays: expected one of them")
        import h5py
        import numpy as np
        given["parameters"] = os.path.join(folder, "parameters.h5")
        nz, nx = int(given.get("nz", 0)), int(given.get("nx", 0))
        with h5py.File(given["parameters"], "w") as file:
            for name, value in fault._arrays.items():
                value = np.asarray(value, dtype=float)
                if value.ndim == 2 and "mesh" in given:
                    value = value.ravel()
                elif value.ndim == 1 and "mesh" not in given and value.size == nz * nx:
                    value = value.reshape(nz, nx)
                file[name] = value
    for name, value in given.items():
        words += [f"-fault_{name}", word(value)]
    for name, value in fault._options.items():
        if name != "options_file":
            words += [f"-{name}", word(value)]
    line, interrupted = Line(progress), False
    log = os.path.join(folder, "log")
    with open(log, "w+", encoding="utf-8") as output:
        child = subprocess.Popen(words, stdout=output, stderr=subprocess.STDOUT, env={**ENVIRONMENT, **os.environ})
        try:
            while child.poll() is None:
                try:
                    time.sleep(0.05)
                    if progress:
                        _show(line, given["output"] + ".part", fault)
                except KeyboardInterrupt:
                    interrupted = True
                    child.send_signal(signal.SIGINT)
                    child.wait()
        finally:  # whatever was raised, no program is left that writes to a folder which is gone
            _end(child)
            line.close()
        output.seek(0)
        text = output.read()
    if child.returncode not in (0, 3) and not interrupted:
        lines = re.findall(r"(?m)^\S+: error: (.*)$", text)
        raise Error(lines[-1] if lines else f"the program ended with the code {child.returncode}: {text.strip()[-300:]}")
    return interrupted


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
    import h5py
    try:
        with h5py.File(path, "r", swmr=True) as file:
            at, rate = file["series/time"], file["series/max_slip_rate"]
            n = min(len(at), len(rate))
            if n:
                line.show(float(at[n - 1]), None, n, float(rate[n - 1]))
    except (OSError, KeyError, RuntimeError):  # of h5py
        return  # it is being made


class Fault(Runs):
    """A fault that the program simulates: parameters by the names of their options without "fault_" (nx=50, normal_stress=50e6, mesh="m.h5",
    inertia=False), numpy arrays for fields [nz, nx], and options of PETSc such as ts_max_time="100y". Units are SI, as those of the program."""

    backend = "program"

    def __init__(self, **parameters):
        self._remember()
        self.set(**parameters)

    def set(self, **parameters):
        """Set or replace parameters and options; names are checked when the fault runs."""
        self._record(parameters)
