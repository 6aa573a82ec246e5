"""SlipStep from Python: faults that stick and slip, with results as numpy arrays.

    import slipstep

    fault = slipstep.Fault(nx=50, nz=50, ts_max_time="30s")     # options of the program, without "fault_"
    result = fault.run()                                         # with a line of progress
    result["slip"][-1], result.units["slip"]                     # [nz, nx], "m"
    result.dataset, result.catalogue                             # xarray and pandas, where they are installed
    slipstep.open("run.h5")                                      # the same of a file of the program

A fault runs in this process where petsc4py of the library's PETSc is there, else by the program `fault`. load(), call(), small(),
totals() and version() need petsc4py: they are the functions of the library for a TS of yours, see slipstep.petsc.
"""

from .errors import Error
from .results import Result, open

__all__ = ["Fault", "Error", "Result", "open", "load", "call", "small", "totals", "version", "Totals"]


def __getattr__(name):
    """What needs petsc4py is imported when it is asked for."""
    import importlib
    if name == "Fault":
        from .running import fault_class
        return fault_class()
    if name.startswith("__"):
        raise AttributeError(name)
    petsc = importlib.import_module(".petsc", __name__)
    try:
        return getattr(petsc, name)
    except AttributeError:
        raise AttributeError(f"module slipstep has no attribute {name}") from None
