"""One program for all of them: slipstep NAME ..., or python3 -m slipstep NAME ..., runs slipstep.programs.NAME."""

import ast
import difflib
import glob
import importlib
import os
import re
import sys

from .modules import find_program, need, one_line

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "programs")


def programs():
    """Name of each, with hyphens, and the begin of what its module says."""
    found = {}
    for path in sorted(glob.glob(os.path.join(FOLDER, "[a-z]*.py"))):
        with open(path, encoding="utf-8") as file:
            found[os.path.basename(path)[:-len(".py")].replace("_", "-")] = re.split(
                r"[:.;]\s", " ".join(ast.get_docstring(ast.parse(file.read())).split("\n\n")[0].split()))[0].rstrip(".")
    return found


def main():
    if len(sys.argv) < 2 or sys.argv[1] in ("-h", "--help"):
        print("usage: slipstep NAME [ARGUMENT ...]\n\nPrepare, run and evaluate simulations of faults.\n\nslipstep "
              "NAME --help says more of each:\n")
        print("\n".join(f"  {name:20} {text}" for name, text in programs().items()))
        return
    if sys.argv[1] in ("-version", "--version", "-slipstep_version"):
        fault = find_program("fault")
        if not fault:
            sys.exit("slipstep: the program fault is not there, which knows the version; set SLIPSTEP_BUILD "
                     "to the build")
        sys.stdout.flush()
        os.execv(fault, ["fault", "-version"])
    name = sys.argv[1].replace("_", "-")
    if name not in programs():
        near = difflib.get_close_matches(name, programs(), 1)
        sys.exit(f"slipstep: there is no program {sys.argv[1]}"
                 + (f"; did you mean {near[0]}?" if near else "; slipstep --help lists them"))
    sys.argv[:2] = [f"slipstep {name}"]
    need("h5py", "numpy", "matplotlib")
    with one_line():
        importlib.import_module(f"slipstep.programs.{name.replace('-', '_')}").main()


if __name__ == "__main__":
    main()
