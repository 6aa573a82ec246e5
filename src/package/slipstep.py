"""SlipStep from Python, on petsc4py: the public functions of libslipstep, by ctypes.

    from petsc4py import PETSc
    import slipstep

    slipstep.load()                              # the types bathe, heuristic, pi, rl, semismooth, ... are there now
    ts = PETSc.TS().create()
    ts.setType("bathe")                          # and anything else that petsc4py does with a TS
    slipstep.call("TSBatheSetGamma", ts, 2 - 2 ** 0.5)   # any public function, see the reference

load() takes the library beside this file, or the one that SLIPSTEP_LIBRARY names. small() makes a TS integrate a system
of a few states with friction, Fault is the strike-slip fault. Nothing of the library's memory is laid out again here:
objects are handles, numbers are arguments. Errors are PETSc.Error, as petsc4py's own.
"""

import collections
import ctypes
import os
import traceback

import numpy as np
from petsc4py import PETSc

INT = ctypes.c_int64 if np.dtype(PETSc.IntType).itemsize == 8 else ctypes.c_int32
REALS = ctypes.POINTER(ctypes.c_double)
FORCE = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_double, REALS, REALS, ctypes.c_void_p)
BOUND = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_double, REALS, REALS, REALS, ctypes.c_void_p)
PETSC_ERR_USER = 83

Totals = collections.namedtuple("Totals", "attempts accepted solves newton linear")
_library = None


def load(path=None):
    """The shared library, loaded into the running PETSc with all its types registered; once, then it is remembered."""
    global _library
    if _library is None:
        here = os.path.dirname(os.path.abspath(__file__))
        path = path or os.environ.get("SLIPSTEP_LIBRARY") or os.path.join(here, "..", "libslipstep.so")
        if np.dtype(PETSc.ScalarType) != np.float64:
            raise ImportError(f"petsc4py has scalars of type {np.dtype(PETSc.ScalarType)}, SlipStep needs double")
        library = ctypes.CDLL(path)
        running = ctypes.c_int(0)
        library.PetscInitialized(ctypes.byref(running))
        if not running.value:
            raise ImportError(f"{path} was built against another PETSc than that of petsc4py, {PETSc.__file__}")
        _library = library
        call("SlipStepInitializePackage")
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
            raise TypeError(f"an array of {value.dtype}: expected contiguous {np.dtype(np.float64)} or {np.dtype(PETSc.IntType)}")
        return ctypes.c_void_p(value.ctypes.data)
    return value  # None, and what is of ctypes already


def call(name, *arguments):
    """Any public function that returns an error code: petsc4py's objects, numbers, strings, arrays, or ctypes' own, as
    ctypes.byref(x) for an output. Mind that 1 is a PetscInt and 1.0 a PetscReal."""
    code = getattr(load(), name)(*map(_argument, arguments))
    if code:
        raise PETSc.Error(code)


def version():
    """Of the library."""
    text = ctypes.create_string_buffer(64)
    call("SlipStepGetVersion", text, ctypes.c_size_t(len(text)))
    return text.value.decode()


def totals(ts):
    """Attempts, accepted steps, Bathe solves, Newton and linear iterations since ts.solve() began."""
    numbers = [INT(0) for _ in Totals._fields]
    call("TSBatheGetTotals", ts, *map(ctypes.byref, numbers))
    return Totals(*(number.value for number in numbers))


def _guarded(function, kind, *sizes):
    """function(t, *arrays) as C calls it; an array that C has not is None. An exception is printed, and fails the solve."""

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
    jacobian(t, w, J) [n, n], zero before, bound(t, w, q, dq) [len(rows)], where dq, the derivatives by |w|, may be None.
    """
    mass, rows = np.array(mass, dtype=np.float64).ravel(), np.array(rows, dtype=PETSc.IntType).ravel()
    n, m = (mass.size,), (rows.size,)
    functions = (_guarded(force, FORCE, n, n), _guarded(jacobian, FORCE, n, n * 2), _guarded(bound, BOUND, n, m, m))
    call("SlipSmallConfigureTSByMembers", ts, mass.size, mass, rows.size, rows, *functions, None)
    ts.setAttr("slipstep", functions)  # as long as the TS lives


class Fault:
    """The strike-slip fault (slipfault.h): the case "3 km" with one cell until parameters are set."""

    def __init__(self, comm=None, **parameters):
        self.handle = ctypes.c_void_p()
        load()
        # A communicator as an argument is a pointer with Open MPI and a number with MPICH: take that of an object.
        of, found = PETSc.TS().create(comm), ctypes.c_void_p()
        call("PetscObjectGetComm", of, ctypes.byref(found))
        call("SlipFaultCreate", found, ctypes.byref(self.handle))
        self.set(**parameters)

    def set(self, **parameters):
        """Parameters by the names of their options without "fault_": numbers, texts, and arrays for fields."""
        for name, value in parameters.items():
            if isinstance(value, str):
                call("SlipFaultSetString", self, name, value)
            elif np.ndim(value):
                field = np.ascontiguousarray(value, dtype=np.float64).ravel()
                call("SlipFaultSetField", self, name, field.size, field)
            else:
                call("SlipFaultSetReal", self, name, float(value))

    def get(self, name):
        value = ctypes.c_double()
        call("SlipFaultGetReal", self, name, ctypes.byref(value))
        return value.value

    def configure(self, ts, options=True):
        """Make ts integrate the fault from its start: options (-fault_*), set-up, constraint, and the state in the TS.
        Its local part has a row v, u, s for each cell: ts.getSolution().getArray().reshape(-1, 3) [m/s, m, m]."""
        state = ctypes.c_void_p()
        if options:
            call("SlipFaultSetFromOptions", self)
        call("SlipFaultSetUp", self)
        call("SlipFaultCreateState", self, ctypes.byref(state))
        call("SlipFaultSetInitialState", self, state)
        call("SlipFaultConfigureTS", self, ts)
        call("TSSetSolution", ts, state)
        call("VecDestroy", ctypes.byref(state))

    def destroy(self):
        if self.handle and not PETSc.Sys.isFinalized():
            call("SlipFaultDestroy", ctypes.byref(self.handle))

    __del__ = destroy
