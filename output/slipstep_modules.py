"""Modules that a Python may lack: need() before they are imported says which of Debian's packages have them."""

import importlib.util
import os
import sys

DEBIAN = "/usr/bin/python3"


def need(*modules):
    """Returns when all modules are there. Else the script goes on under Debian's python3, or ends with one line that
    names the packages."""
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    if not missing:
        return
    main = sys.modules["__main__"]
    is_script = getattr(main, "__spec__", None) is None and str(getattr(main, "__file__", "")).endswith(".py")
    if is_script and os.path.exists(DEBIAN) and os.path.realpath(sys.executable) != os.path.realpath(DEBIAN):
        os.execv(DEBIAN, [DEBIAN, *sys.argv])
    sys.exit(f"{os.path.basename(sys.argv[0])}: {sys.executable} has no {', '.join(missing)}; Debian's packages are "
             + " ".join("python3-" + name.lower().replace("_", "-") for name in modules) + f", for {DEBIAN}")  # whose names have no underscores
