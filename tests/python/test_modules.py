"""Every script and program under a Python without h5py, numpy and matplotlib: one line that names Debian's packages.
slipstep NAME starts all programs."""

import glob
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

from scripts import PROGRAM, SOURCE

from slipstep import modules

# -S leaves site-packages out; no other Python takes over
BARE = "import runpy, sys, slipstep.modules; slipstep.modules.DEBIAN = ''; sys.argv = sys.argv[1:]; " \
       "runpy.run_path(sys.argv[0], run_name='__main__')"


LACKING = r": \S+ has no (?:(h5py|petsc4py), )?numpy.*; Debian's packages are (?(1)python3-\1 )python3-numpy.*\n\Z"
STANDARD = {"tests/benchmarks/ode.py"}  # needs none of them


def bare(script, *arguments):
    path = os.pathsep.join([os.path.join(SOURCE, "src", "package"), os.path.dirname(script)])
    return subprocess.run([sys.executable, "-S", "-c", BARE, script, *arguments], capture_output=True, text=True,
                          env=dict(os.environ, PYTHONPATH=path, PYTHONDONTWRITEBYTECODE="1"))


def scripts():
    found = []
    for folder in ("training/study", "examples", "tests/benchmarks", "tests/python"):
        for path in sorted(glob.glob(os.path.join(SOURCE, folder, "*.py"))):
            with open(path, encoding="utf-8") as file:
                if "\nif __name__ ==" in file.read():
                    found.append(path)
    return found


class Modules(unittest.TestCase):
    def test_one_line_names_the_packages(self):
        self.assertGreater(len(scripts()), 15)
        for script in scripts():
            if os.path.samefile(script, __file__) or os.path.relpath(script, SOURCE) in STANDARD:
                continue
            with self.subTest(script=os.path.relpath(script, SOURCE)):
                done = bare(script)
                self.assertEqual(done.returncode, 1, done.stderr)
                self.assertRegex(done.stderr, rf"\A[\w.]+{LACKING}")
        programs = glob.glob("[a-z]*.py", root_dir=os.path.join(SOURCE, "src", "package", "slipstep", "programs"))
        self.assertGreater(len(programs), 15)
        for name in (name[:-len(".py")].replace("_", "-") for name in programs):
            with self.subTest(program=name):
                done = bare(PROGRAM, name)
                self.assertEqual(done.returncode, 1, done.stderr)
                self.assertRegex(done.stderr, rf"\Aslipstep {name}{LACKING}")

    def test_names_of_packages(self):
        """Debian's have hyphens where modules have underscores."""
        for script, packages in ((os.path.join(SOURCE, "src", "site", "build.py"),
                                  "python3-sphinx python3-myst-parser python3-sphinx-rtd-theme"),):
            done = bare(script)
            self.assertEqual(done.returncode, 1)
            self.assertIn(f"Debian's packages are {packages}, for", done.stderr)

    def test_another_python(self):
        """A program goes on under Debian's, also by its name there; whoever imports it does not."""
        for name, goes_on in (("plot_run.py", True), ("slipstep-plot-run", True), ("slipstep", True),
                              ("pytest", False)):
            with mock.patch.object(modules.os, "execv") as execv, mock.patch.object(modules, "DEBIAN", "/bin/sh"), \
                    mock.patch.object(sys.modules["__main__"], "__file__", f"/usr/bin/{name}"), mock.patch.object(
                        sys.modules["__main__"], "__spec__", None), \
                    self.assertRaisesRegex(SystemExit, "has no nothing_has_this_name"):
                modules.need("nothing_has_this_name")
            self.assertEqual(execv.called, goes_on, name)

    def test_one_program_for_all(self):
        """slipstep NAME is the program NAME, by a link, as a module and installed elsewhere; with hyphens or
        underscores."""
        with tempfile.TemporaryDirectory() as folder:
            link, prefix = os.path.join(folder, "slipstep"), os.path.join(folder, "prefix")
            os.symlink(os.path.join(SOURCE, "src", "package", "program.py"), link)
            os.makedirs(os.path.join(prefix, "share", "slipstep", "python"))
            os.makedirs(os.path.join(prefix, "bin"))
            os.symlink(os.path.join(SOURCE, "src", "package", "slipstep"),
                       os.path.join(prefix, "share", "slipstep", "python", "slipstep"))
            installed = shutil.copy(link, os.path.join(prefix, "bin", "slipstep"))
            for command, more in (([link], {}), ([installed], {}),
                                  (["-m", "slipstep"], {"PYTHONPATH": os.path.join(SOURCE, "src", "package")})):
                def start(*words):
                    return subprocess.run([sys.executable, *command, *words], cwd=folder, capture_output=True,
                                          text=True, env={**os.environ, **more})

                for name in ("catalogue-csv", "catalogue_csv"):
                    done = start(name, "none.h5")
                    self.assertEqual((done.returncode, done.stderr), (1, "slipstep catalogue-csv: none.h5: no such "
                                                                      "file; fault -fault_catalogue writes it\n"))
                self.assertIn("usage: slipstep catalogue-csv [-h]", start("catalogue-csv", "--help").stdout)
                self.assertIn("\n  plot-run ", start().stdout)
                done = start("plot-rum")
                self.assertEqual((done.returncode, done.stderr),
                                 (1, "slipstep: there is no program plot-rum; did you mean plot-run?\n"))


if __name__ == "__main__":
    unittest.main()
