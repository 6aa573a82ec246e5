"""SlipStep from Python, on petsc4py: the public functions of libslipstep, by ctypes.

    from petsc4py import PETSc import slipstep

    slipstep.load()                              # the types bathe, heuristic, pi, rl, semismooth, ... are there now
    ts = PETSc.TS().create()
    ts.setType("bathe")                          # and anything else that petsc4py does with a TS
    slipstep.call("TSBatheSetGamma", ts, 2 - 2 ** 0.5)   # any public function, see the reference

load() takes the library two or three folders up, or the one that SLIPSTEP_LIBRARY names. small() makes a TS integrate a
system of a few states with friction, Fault is a fault with one TS. Nothing of the library's memory is laid out again
here: objects are handles, numbers are arguments. Errors are PETSc.Error, as petsc4py's own.
"""

import collections
import contextlib
import ctypes
import io
import os
import re
import signal
import sys
import tempfile
import threading
import time
import traceback

import numpy as np
from petsc4py import PETSc

from .errors import Error, warn
from .running import Line, Program, Runs, say_stopping, word

INT = ctypes.c_int64 if np.dtype(PETSc.IntType).itemsize == 8 else ctypes.c_int32
REALS = ctypes.POINTER(ctypes.c_double)
FORCE = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_double, REALS, REALS, ctypes.c_void_p)
BOUND = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_double, REALS, REALS, REALS, ctypes.c_void_p)
PETSC_ERR_USER = 83
PETSC_ERR_ARG_UNKNOWN_TYPE = 86
# what Fault.solve() writes and reads, and ts.solve() does not
FILES = ("output", "catalogue", "checkpoint", "restart", "stations")
EVENT = ("onset", "end", "x", "y", "z", "cell", "area", "mean_slip", "max_slip", "direction", "moment", "magnitude",
         "stress_drop",
         "peak_slip_rate", "elastic_energy", "kinetic_energy", "dissipated_energy", "radiated_energy", "loading_work",
         "energy_residual", "steps", "fault", "rake", "rupture_speed", "radiated_efficiency", "goes_on", "images")
# of several faults, a number for each
EVENT_OF_FAULTS = ("fault_moment", "fault_area", "fault_mean_slip", "fault_stress_drop", "fault_onset", "fault_cell",
                   "fault_dissipated_energy")

Totals = collections.namedtuple("Totals", "attempts accepted solves newton linear")
_library = None


def message_of(error):
    """The line of an error of PETSc, without its stack."""
    lines = [re.sub(r"^\[\d+\] ?", "", text).strip() for text in str(error).split("\n")]
    lines = [text for text in lines if text and not re.match(r"(error code|\S+\(\) at |\w+\(\) line )", text)]
    return lines[-1] if lines else str(error)


class LibraryError(Error, PETSc.Error):
    """An error of the library: its line, and the code of PETSc as ierr."""

    def __init__(self, code):
        PETSc.Error.__init__(self, code)
        self.line = message_of(PETSc.Error(code))

    def __str__(self):
        return self.line


def load(path=None):
    """The shared library, loaded into the running PETSc with all its types registered; once, then it is remembered."""
    global _library
    if _library is None:
        here = os.path.dirname(os.path.abspath(__file__))
        beside = [os.path.normpath(os.path.join(here, *up, "libslipstep.so")) for up in (("..",) * 2, ("..",) * 3)]
        path = path or os.environ.get("SLIPSTEP_LIBRARY") or next(filter(os.path.exists, beside), "libslipstep.so")
        if np.dtype(PETSc.ScalarType) != np.float64:
            raise ImportError(f"petsc4py has scalars of type {np.dtype(PETSc.ScalarType)}, SlipStep needs double")
        library = ctypes.PyDLL(path)  # with the lock of Python, as petsc4py prints by sys.stdout in notebooks
        running = ctypes.c_int(0)
        library.PetscInitialized(ctypes.byref(running))
        if not running.value:
            raise ImportError(f"{path} was built against another PETSc than that of petsc4py, {PETSc.__file__}")
        _library = library
        call("SlipStepInitializePackage")
        call("PetscSetProgramName", "slipstep")  # which warnings begin with
    return _library


def _argument(value):
    if isinstance(value, PETSc.Object):
        return ctypes.c_void_p(value.handle)
    if isinstance(value, Fault):
        return value.handle
    if isinstance(value, str):
        return ctypes.c_char_p(os.fsencode(value))
    if isinstance(value, (bool, np.bool_)):
        return ctypes.c_int(bool(value))
    if isinstance(value, (int, np.integer)):
        return INT(value)
    if isinstance(value, (float, np.floating)):
        return ctypes.c_double(value)
    if isinstance(value, np.ndarray):
        if value.dtype not in (np.dtype(np.float64), np.dtype(PETSc.IntType)) or not value.flags.c_contiguous:
            raise TypeError(f"an array of {value.dtype}: expected contiguous {np.dtype(np.float64)} or "
                            f"{np.dtype(PETSc.IntType)}")
        return ctypes.c_void_p(value.ctypes.data)
    return value  # None, and what is of ctypes already


def call(name, *arguments):
    """Any public function that returns an error code: petsc4py's objects, numbers, strings, arrays, or ctypes' own, as
    ctypes.byref(x) for an output. Mind that 1 is a PetscInt and 1.0 a PetscReal."""
    code = getattr(load(), name)(*map(_argument, arguments))
    if code:
        raise LibraryError(code)


def version():
    """Of the library."""
    text = ctypes.create_string_buffer(64)
    call("SlipStepGetVersion", text, ctypes.c_size_t(len(text)))
    return text.value.decode()


def used(name):
    """Whether something has read an option of PETSc's database."""
    found = ctypes.c_int(0)
    call("PetscOptionsUsed", None, name, ctypes.byref(found))
    return bool(found.value)


def totals(ts):
    """Attempts, accepted steps, Bathe solves, Newton and linear iterations since ts.solve() began. Types other than
    bathe, as that of rate-and-state friction, have no Bathe solves: 0."""
    if ts.getType() not in ("bathe", "moreau"):
        accepted = ts.getStepNumber()
        return Totals(accepted + ts.getStepRejections(), accepted, 0, ts.getSNESIterations(), ts.getKSPIterations())
    numbers = [INT(0) for _ in Totals._fields]
    call("TSBatheGetTotals", ts, *map(ctypes.byref, numbers))
    return Totals(*(number.value for number in numbers))


def _guarded(function, kind, *sizes):
    """function(t, *arrays) as C calls it, None for no array. An exception is printed, and fails the solve."""

    def guarded(t, *pointers):
        try:
            function(t, *(np.ctypeslib.as_array(p, size) if p else None for p, size in zip(pointers, sizes)))
        except BaseException:
            traceback.print_exc()
            return PETSC_ERR_USER
        return 0

    return kind(guarded)


def small(ts, mass, rows, force, jacobian, bound):
    """Make ts integrate A dw/dt = F_s(t, w) + F_r, |F_r| <= q in some rows (SlipSmall of slipsnes.h), on one process.

    mass [n] is the diagonal of A, rows where reactions enter, ascending. The functions fill arrays: force(t, w, F) [n],
    jacobian(t, w, J) [n, n], zero before, bound(t, w, q, dq) [len(rows)], where dq, the derivatives by |w|, may be
    None.
    """
    mass, rows = np.array(mass, dtype=np.float64).ravel(), np.array(rows, dtype=PETSc.IntType).ravel()
    n, m = (mass.size,), (rows.size,)
    functions = (_guarded(force, FORCE, n, n), _guarded(jacobian, FORCE, n, n * 2), _guarded(bound, BOUND, n, m, m))
    call("SlipSmallConfigureTSByMembers", ts, mass.size, mass, rows.size, rows, *functions, None)
    ts.setAttr("slipstep", functions)  # as long as the TS lives


def largest_rate(ts, w):
    """The largest slip rate of all cells of a state of a fault [m/s], in their planes, as /series has it; collective.
    Rows of w as of configure()."""
    size = w.getBlockSize()
    rates = w.getArray(readonly=True).reshape(-1, size)[:, : min((size - 1) // 2, 2)]
    peak = PETSc.Vec().createMPI((1, PETSc.DECIDE), comm=ts.getComm())
    peak.setArray([np.sqrt((rates ** 2).sum(axis=1)).max(initial=0.0)])
    largest = peak.max()[1]
    peak.destroy()
    return largest


@contextlib.contextmanager
def silence():
    """What PETSc prints on stdout goes nowhere meanwhile, be it by C or, in notebooks, by sys.stdout; errors, on
    stderr, still show."""
    libc = ctypes.CDLL(None)
    libc.fopen.restype = ctypes.c_void_p
    stdout = ctypes.c_void_p.in_dll(load(), "PETSC_STDOUT")
    before, nowhere = stdout.value, libc.fopen(os.devnull.encode(), b"w")
    stdout.value = nowhere
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            yield
    finally:
        stdout.value = before
        libc.fclose(ctypes.c_void_p(nowhere))


@contextlib.contextmanager
def keep_warnings():
    """The first process prints no warnings meanwhile, which are in the result: unless there is none, as there was an
    error."""
    call("SlipWarningsKeep", not PETSc.COMM_WORLD.getRank(), False)
    failed = True
    try:
        yield
        failed = False
    finally:
        call("SlipWarningsKeep", False, failed)


def kills_again():
    """Whether a second SIGINT ends this process at once: not a notebook, which would lose all it has, nor one of
    several, which get signals by two ways."""
    return ("ipykernel" not in sys.modules and PETSc.COMM_WORLD.getSize() == 1
            and hasattr(ctypes.CDLL(None), "sysv_signal"))


@contextlib.contextmanager
def handled(function):
    """SIGINT calls a function meanwhile; other threads than the main one cannot have that."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, function)
    if kills_again():  # C code may compute long, while Python calls no function
        library = ctypes.CDLL(None)
        library.sysv_signal.restype, library.sysv_signal.argtypes = ctypes.c_void_p, (ctypes.c_int, ctypes.c_void_p)
        # Python's own handler, now for one signal
        library.sysv_signal(signal.SIGINT, library.sysv_signal(signal.SIGINT, int(signal.SIG_IGN)))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def database_of(fault, given):
    """PETSc's options are those of a fault meanwhile, with what its file of options has beside what is given. Gives
    what is given, with nx and nz of that file: arrays need the shape before the options are read."""
    database = PETSc.Options()
    before = database.getAll()
    try:
        if "options_file" in fault._options:
            database.insertString("-options_file " + word(fault._options["options_file"]))
            if database.hasName("fault_nx") and "nx" not in given:
                given = {**given, "nx": database.getInt("fault_nx")}
            if database.hasName("fault_nz") and "nz" not in given:
                given = {**given, "nz": database.getInt("fault_nz")}
            for name in (*given, *fault._arrays, *fault._functions):  # what is given here overrides the file
                database.delValue(f"fault_{name}")
        for name, value in fault._options.items():
            if name != "options_file":
                database.setValue(name, word(value))
        yield given
    finally:
        for name in set(database.getAll()) - set(before):
            database.delValue(name)
        for name, value in before.items():
            database.setValue(name, value)


class Process(Program):
    """How a fault runs in this process, as running.Program has it for the program."""

    @staticmethod
    def folder():
        """A temporary one, the same on every process."""
        if PETSc.COMM_WORLD.getSize() == 1:
            return tempfile.mkdtemp(prefix="slipstep-")
        try:
            comm = PETSc.COMM_WORLD.tompi4py()
        except ImportError:
            raise Error("run() on several processes needs mpi4py; Debian's package is python3-mpi4py") from None
        return comm.bcast(tempfile.mkdtemp(prefix="slipstep-") if comm.rank == 0 else None)

    @staticmethod
    def remove(folder):
        PETSc.COMM_WORLD.barrier()
        if not PETSc.COMM_WORLD.getRank():
            Program.remove(folder)

    @staticmethod
    def run(fault, given, folder, progress):
        """True when it was interrupted."""
        line = Line(progress and not PETSc.COMM_WORLD.getRank())
        interrupted, ts = False, None

        def interrupt(number, frame):
            nonlocal interrupted
            if not interrupted:
                say_stopping("the run stops", kills_again())
            interrupted = True  # the monitor ends the run: petsc4py would lose an exception in some places

        def monitor(ts, step, at, w):
            if interrupted:
                raise KeyboardInterrupt
            if progress:  # on every process
                line.show(at, ts.getMaxTime(), step, largest_rate(ts, w))

        try:
            with handled(interrupt), keep_warnings(), database_of(fault, given) as given:
                inner = Fault(getattr(fault, "_comm_given", None), **given, **fault._arrays, **fault._functions)
                for stress in fault._stresses:
                    inner.add_stress(**stress)
                try:
                    ts = PETSc.TS().create(getattr(fault, "_comm_given", None))
                    if "progress" not in given:
                        inner.set(progress=False)
                    inner.configure(ts)
                    ts.setFromOptions()
                    for name in fault._options:
                        if name != "options_file" and not used(name):
                            raise Error(f"nothing reads the option -{name}")
                    ts.setMonitor(monitor)
                    try:
                        with silence():
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
        return interrupted

    @staticmethod
    def warn(result):
        """Those that the library kept."""
        if not PETSc.COMM_WORLD.getRank():
            warn(*result.warnings)


class Fault(Runs):
    """A fault in this process (slipfault.h): the case "3 km" with one cell until parameters are set. What has one
    number a cell is an array [nz, nx] in the order of the grid, or [1, n] of the rows of a mesh, on every rank.

    run() does everything; configure(), solve() and values() are for a TS of yours."""

    backend = "petsc"
    backends = {**Runs.backends, "petsc": Process}

    def __init__(self, comm=None, **parameters):
        self._remember()
        self._comm_given = comm
        self.handle = ctypes.c_void_p()
        self._state = {"solving": False}  # shared with monitors, which do not keep the fault alive
        self._fields, self._switches = {}, {}
        load()
        # A communicator as an argument is a pointer with Open MPI and a number with MPICH: take that of an object.
        of, found = PETSc.TS().create(comm), ctypes.c_void_p()
        call("PetscObjectGetComm", of, ctypes.byref(found))
        call("SlipFaultCreate", found, ctypes.byref(self.handle))
        self.set(**parameters)

    def set(self, name=None, value=None, /, **parameters):
        """Parameters by the names of their options without "fault_", set("friction_a", value) or set(friction_a=value):
        numbers, texts, True and False (inertia=False), and for fields arrays, [nz, nx], or [n] of all cells iz * nx +
        ix, or of the rows of a mesh, or functions of the cells (slipstep.fields). Names as ts_max_time are options of
        PETSc, for run()."""
        parameters = self._record(parameters if name is None else {name: value, **parameters})
        fields = {}
        for name, value in parameters.items():
            if isinstance(value, str):
                call("SlipFaultSetString", self, name, value)
            elif isinstance(value, (bool, np.bool_)):
                call("SlipFaultSetBool", self, name, value)
                self._switches[name] = value
            elif np.ndim(value):
                fields[name] = np.array(value, dtype=np.float64)
            else:
                call("SlipFaultSetReal", self, name, float(value))
                self._fields.pop(name, None)
        for name, field in fields.items():  # when nx and nz are known
            if field.size == np.prod(self.shape):
                self._check_shape(name, field)
            call("SlipFaultSetField", self, name, field.size, field.ravel())
            self._fields[name] = field

    def add_stress(self, time, course, shear=None, normal=None):
        stress = super().add_stress(time, course, shear, normal)
        if stress["time"].ndim != 1 or stress["time"].shape != stress["course"].shape:
            raise ValueError(f"time has the shape {stress['time'].shape} and course {stress['course'].shape}, expected "
                             "two lists of one length")
        fields = [np.zeros(0) if stress[name] is None else stress[name].ravel() for name in ("shear", "normal")]
        call("SlipFaultAddStress", self, stress["time"].size, stress["time"], stress["course"],
             fields[0].size, fields[0], fields[1].size, fields[1])

    add_stress.__doc__ = Runs.add_stress.__doc__

    @property
    def shape(self):
        """(nz, nx), that of fields; (1, n) of a mesh."""
        return int(self._real("nz")), int(self._real("nx"))

    def _check_shape(self, name, field):
        if field.ndim > 1 and field.shape != self.shape:
            raise ValueError(f"{name} has the shape {field.shape}, expected (nz, nx) = {self.shape}, or one dimension")

    def _real(self, name):
        value = ctypes.c_double()
        call("SlipFaultGetReal", self, name, ctypes.byref(value))
        return value.value

    def get(self, name):
        """A parameter: a number or text; a field, as "normal_stress", is its array [nz, nx] once configure() was
        called."""
        if self._state.get("ready"):
            try:
                return self._cells("SlipFaultGetField", name)
            except PETSc.Error as error:
                if error.ierr != PETSC_ERR_ARG_UNKNOWN_TYPE:
                    raise
        if name in self._fields:
            return self._fields[name].copy()
        try:
            return self._real(name)
        except PETSc.Error as number:
            text = ctypes.create_string_buffer(4096)
            try:
                call("SlipFaultGetString", self, name, text, ctypes.c_size_t(len(text)))
            except PETSc.Error:
                raise number from None
            return os.fsdecode(text.value)

    def _ready(self, what):
        if not self._state.get("ready"):
            raise Error(f"{what} of a fault are known after configure(ts)")

    def _cells(self, function, *arguments, components=1):
        values = np.zeros(self.shape if components == 1 else (*self.shape, components))
        call(function, self, *arguments, values.size // components, values)
        return values

    def cells(self):
        """The cells, slipstep.fields.Cells: centres [m], area [m^2], strike, dip [degrees] and fault, each [nz, nx], or
        [1, n] of a mesh. At any time: before configure() those of the fault as it is now. Collective."""
        from .fields import NAMES, Cells
        if self._state.get("ready"):
            return self._geometry(NAMES, Cells)
        given = {name: value for name, value in self._with_cells().items() if name not in FILES}
        try:
            with database_of(self, given) as given:
                inner = Fault(self._comm_given, **given)
                try:
                    call("SlipFaultSetFromOptions", inner)
                    call("SlipFaultSetUpMesh", inner)
                    return inner._geometry(NAMES, Cells)
                finally:
                    inner.destroy()
        except PETSc.Error as error:
            raise Error(message_of(error)) from None

    def _geometry(self, names, kind):
        parts = {name: self._cells("SlipFaultGetGeometry", name) for name in names}
        return kind(**{**parts, "fault": parts["fault"].astype(int)}, mesh=bool(self.get("mesh")))

    def values(self, ts, name):
        """Of the state that ts has now: "slip_rate" [m/s], "slip", "displacement" [m], "traction", "stress" [Pa],
        "state" (a law with several names each), "normal_stress" [Pa], effective, "opening" [m], as [nz, nx], on every
        rank; with slip_components=2 the first five as [nz, nx, 2], along strike and up dip. After configure()."""
        self._ready("values")
        components = INT(0)
        call("SlipFaultGetCellComponents", self, name, ctypes.byref(components))
        return self._cells("SlipFaultGetCellValues", float(ts.getTime()), ts.getSolution(), name,
                           components=components.value)

    def labels(self):
        """Of the faults of a mesh, ascending, the order of what has a number for each fault; after configure()."""
        self._ready("labels")
        count = INT(0)
        call("SlipFaultGetLabels", self, 0, ctypes.byref(count), None)
        found = np.zeros(count.value, dtype=PETSc.IntType)
        call("SlipFaultGetLabels", self, found.size, ctypes.byref(count), found)
        return found

    def events(self):
        """The catalogue (catalogue="F.h5") after solve(): an array with a row an event and a member for each column;
        "fault_moment" and its like, of several faults, have a number for each of labels()."""
        count, faults = INT(0), len(self.labels())
        call("SlipFaultGetEvents", self, EVENT[0], 0, ctypes.byref(count), None)
        columns = [(name, np.float64) for name in EVENT]
        if faults > 1:
            columns += [(name, np.float64, (faults,)) for name in EVENT_OF_FAULTS]
        rows = np.zeros(count.value, dtype=columns)
        for name in rows.dtype.names:
            column = np.zeros(rows[name].shape)
            call("SlipFaultGetEvents", self, name, column.size, ctypes.byref(count), column)
            rows[name] = column
        return rows

    def configure(self, ts, options=True):
        """Make ts integrate the fault from its start: options (-fault_*), set-up, constraint, and the state in the TS.
        Its local part has a row v, u, s for each cell: ts.getSolution().getArray().reshape(-1, 3) [m/s, m, m]. Rows
        have 5 numbers with slip_components=2, v, v, u, u, s, along strike and up dip, and 7 with opening, v, v, v, u,
        u, u, s, across the plane behind them."""
        state = ctypes.c_void_p()
        if options:
            prefix = ctypes.c_char_p()
            call("SlipFaultGetOptionsPrefix", self, ctypes.byref(prefix))
            call("SlipCheckOwnOptions", self._comm(ts), None, prefix)
            call("SlipFaultSetFromOptions", self)
            given, database = (prefix.value or b"").decode(), PETSc.Options()
            for name, value in self._switches.items():  # those that are on whenever options are read
                if not database.hasName(f"{given}fault_{name}"):
                    call("SlipFaultSetBool", self, name, value)
        if self._functions:
            from .fields import NAMES, Cells, evaluate
            call("SlipFaultSetUpMesh", self)
            cells = self._geometry(NAMES, Cells)
            for name, function in self._functions.items():
                self._fields[name] = evaluate(name, function, cells)
                call("SlipFaultSetField", self, name, self._fields[name].size, self._fields[name])
        call("SlipFaultSetUp", self)
        self._state["ready"] = True
        for name, field in self._fields.items():  # options may have changed nx and nz
            self._check_shape(name, field)
        call("SlipFaultCreateState", self, ctypes.byref(state))
        call("SlipFaultSetInitialState", self, state)
        call("SlipFaultConfigureTS", self, ts)
        call("TSSetSolution", ts, state)
        call("VecDestroy", ctypes.byref(state))
        if options:
            call("SlipCheckSolverOptions", ts)
        self._guard(ts)

    @staticmethod
    def _comm(ts):
        found = ctypes.c_void_p()
        call("PetscObjectGetComm", ts, ctypes.byref(found))
        return found

    def _guard(self, ts):
        files, shared = [name for name in FILES if self.get(name)], self._state
        if not files:
            return

        def guard(ts, step, time, w):
            if not shared["solving"]:
                raise RuntimeError(f"{', '.join(files)} of the fault: expected fault.solve(ts), which writes files, "
                                   "not ts.solve()")

        ts.setMonitor(guard)

    def solve(self, ts):
        """What the program `fault` does after its set-up: ts.solve() with the files of output, catalogue, stations,
        checkpoint and restart, and the summary. After ts.setFromOptions(). True when the run has reached its end."""
        code, complete = ctypes.c_int(0), ctypes.c_int(0)
        call("SlipFaultOutputStart", self, ts)
        call("SlipFaultCheckpointStart", self, ts)
        begin, self._state["solving"] = time.time(), True
        try:
            ts.solve(ts.getSolution())
        finally:
            self._state["solving"] = False
        call("SlipFaultCheckpointFinish", self, ts, ctypes.byref(code))
        if code.value:
            call("SlipFaultReportStop", self, ts, 0.0, time.time() - begin)
            return False
        call("SlipFaultOutputFinish", self, ts, 0.0, time.time() - begin)
        call("SlipFaultReportEnd", self, ts, ctypes.byref(complete))
        return bool(complete.value)

    def destroy(self):
        if self.handle and not PETSc.Sys.isFinalized():
            call("SlipFaultDestroy", ctypes.byref(self.handle))

    __del__ = destroy
