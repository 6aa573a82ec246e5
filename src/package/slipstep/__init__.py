"""SlipStep from Python: faults that stick and slip, with results as numpy arrays.

    import slipstep

    fault = slipstep.Fault(nx=50, nz=50, ts_max_time="30s")     # options of the program, without "fault_"
    result = fault.run()                                         # with a line of progress
    result["slip"][-1], result.units["slip"]                     # [nz, nx], "m"
    result.dataset, result.catalogue                             # xarray and pandas, where they are installed
    slipstep.open("run.h5")                                      # the same of a file of the program
    slipstep.Study("study.toml").run().table                     # many runs, see slipstep.studies
    slipstep.Run("run.h5"), slipstep.Catalogue("events.h5")      # readers that pictures and tables are made with,
                                                                 # fields when asked for

A fault runs in this process where petsc4py of the library's PETSc is there, else by the program `fault`. load(),
call(), small(), totals() and version() need petsc4py: they are the functions of the library for a TS of yours, see
slipstep.petsc.
"""

import importlib
import os

from .errors import Error, SlipStepWarning

__all__ = ["Fault", "Study", "Error", "SlipStepWarning", "Result", "open", "Run", "Catalogue", "OutputError", "load",
           "call", "small", "totals", "version", "Totals"]
_MODULES = ("checks", "errors", "fields", "formats", "geometry", "modules", "numbers", "petsc", "plots", "programs",
            "results", "running", "studies", "times", "wells")
_RESULTS = ("Catalogue", "OutputError", "Result", "Run", "open")


def _fault_class():
    """The Fault of this machine: with petsc4py and the library that of slipstep.petsc, else one that starts the
    program."""
    backend = os.environ.get("SLIPSTEP_BACKEND")
    if backend != "program":
        try:
            from . import petsc
            petsc.load()
            return petsc.Fault
        except (ImportError, OSError):
            if backend == "petsc":
                raise
    from .running import Fault
    return Fault


def __getattr__(name):
    """What needs h5py or petsc4py is imported when it is asked for."""
    if name in _MODULES:
        return importlib.import_module("." + name, __name__)
    if name.startswith("__"):
        raise AttributeError(name)
    if name == "Fault":
        return _fault_class()
    if name == "Study":
        return importlib.import_module(".studies", __name__).Study
    if name in _RESULTS:
        return getattr(importlib.import_module(".results", __name__), name)
    try:
        return getattr(importlib.import_module(".petsc", __name__), name)
    except AttributeError:
        raise AttributeError(f"module slipstep has no attribute {name}") from None
