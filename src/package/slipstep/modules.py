"""What a Python or a machine may lack: need() says before modules are imported which of Debian's packages have them, find_program() where a program is."""

import importlib.util
import os
import shutil
import sys

DEBIAN = "/usr/bin/python3"
HERE = os.path.dirname(os.path.abspath(__file__))


def need(*modules):
    """Returns when all modules are there. Else the script goes on under Debian's python3, or ends with one line that
    names the packages."""
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    if not missing:
        return
    main = sys.modules["__main__"]
    name = os.path.basename(str(getattr(main, "__file__", "")))
    is_script = getattr(main, "__spec__", None) is None and (name.endswith(".py") or name.startswith("slipstep-"))  # as Debian's package calls them
    if is_script and os.path.exists(DEBIAN) and os.path.realpath(sys.executable) != os.path.realpath(DEBIAN):
        os.execv(DEBIAN, [DEBIAN, *sys.argv])
    sys.exit(f"{os.path.basename(sys.argv[0])}: {sys.executable} has no {', '.join(missing)}; Debian's packages are "
             + " ".join("python3-" + name.lower().replace("_", "-") for name in modules) + f", for {DEBIAN}")  # whose names have no underscores


def find_program(name):
    """A program of SlipStep: of the build that SLIPSTEP_BUILD names, of the source, build or installation that this package is in, or on PATH, where
    Debian's names begin with slipstep-; None: there is none."""
    folders = [os.path.join(os.environ["SLIPSTEP_BUILD"], "bin")] if "SLIPSTEP_BUILD" in os.environ else []
    folders += [os.path.normpath(os.path.join(HERE, *up)) for up in (("..", "..", "..", "build", "bin"), ("..", "..", "..", "bin"), ("..", "..", "..", "..", "bin"))]
    for path in (*folders, None):
        for word in (f"slipstep-{name}", name):
            found = shutil.which(word, path=path)
            if found:
                return found
    return None
