"""What programs in Python share: need() says before modules are imported which of Debian's packages have them,
find_program() where a program of the library is, one_line() how errors end."""

import contextlib
import csv
import importlib.util
import os
import shutil
import sys
import warnings

from .errors import Error, SlipStepWarning

DEBIAN = "/usr/bin/python3"
# of the program, unless it is set: one thread, and no look at OpenCL's devices, whose drivers take over signals
ENVIRONMENT = {"OPENBLAS_NUM_THREADS": "1", "HWLOC_COMPONENTS": "-opencl"}
HERE = os.path.dirname(os.path.abspath(__file__))


def need(*modules):
    """Returns when modules are there; else the script goes on under Debian's python3, or names packages and ends."""
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    if not missing:
        return
    main = sys.modules["__main__"]
    name = os.path.basename(str(getattr(main, "__file__", "")))
    # as Debian's package calls them
    is_script = getattr(main, "__spec__", None) is None and (name.endswith(".py") or name.startswith("slipstep-")
                                                             or name == "slipstep")
    if is_script and os.path.exists(DEBIAN) and os.path.realpath(sys.executable) != os.path.realpath(DEBIAN):
        os.execv(DEBIAN, [DEBIAN, *sys.orig_argv[1:]])
    sys.exit(f"{program()}: {sys.executable} has no {', '.join(missing)}; Debian's packages are "
             # whose names have no underscores
             + " ".join("python3-" + name.lower().replace("_", "-") for name in modules) + f", for {DEBIAN}")


def program():
    """The name under which this one was started."""
    return os.path.basename(sys.argv[0])


@contextlib.contextmanager
def one_line():
    """Errors of files and values end the program with one line with its name, as SlipStepWarnings are."""
    show = warnings.showwarning

    def one(message, category, *more, **rest):
        if issubclass(category, SlipStepWarning):
            print(f"{program()}: warning: {message}", file=sys.stderr)
        else:
            show(message, category, *more, **rest)

    with warnings.catch_warnings():
        warnings.showwarning = one
        try:
            yield
        except (Error, OSError, ValueError) as error:
            sys.exit(f"{program()}: {error}")


def csv_rows(path):
    """Numbers of lines and words of a CSV file, without blank ones and comments (#). Error: it cannot be read."""
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            rows = [(number, [word.strip() for word in row]) for number, row in enumerate(csv.reader(file), 1)]
    except (OSError, UnicodeDecodeError) as error:
        raise Error(f"cannot read {path}: {getattr(error, 'strerror', None) or error}") from None
    return [(number, row) for number, row in rows if any(row) and not row[0].startswith("#")]


def find_program(name):
    """A program of SlipStep: of the build that SLIPSTEP_BUILD names, of the source, build or installation that this
    package is in, or on PATH, where Debian's names begin with slipstep-; None: there is none."""
    folders = [os.path.join(os.environ["SLIPSTEP_BUILD"], "bin")] if "SLIPSTEP_BUILD" in os.environ else []
    folders += [os.path.normpath(os.path.join(HERE, *up)) for up
                in (("..", "..", "..", "build", "bin"), ("..", "..", "..", "bin"), ("..", "..", "..", "..", "bin"))]
    for path in (*folders, None):
        for word in (f"slipstep-{name}", name):
            found = shutil.which(word, path=path)
            if found:
                return found
    return None


def program_fault():
    """The program `fault`: that of SLIPSTEP_FAULT, or as find_program() has it."""
    named = os.environ.get("SLIPSTEP_FAULT")
    if named and not os.access(named, os.X_OK):
        raise Error(f"SLIPSTEP_FAULT is {named}, expected a program")
    path = named or find_program("fault")
    if not path:
        raise Error("there is neither petsc4py with the library of SlipStep nor the program fault: set "
                    "SLIPSTEP_LIBRARY, or SLIPSTEP_FAULT to the program")
    return path
