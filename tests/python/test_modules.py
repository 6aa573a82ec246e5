"""Every script under a Python without h5py, numpy and matplotlib: one line that names Debian's packages. The programs of output/ are those of the
package, and names that were modules there say where they are."""

import glob
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

from scripts import OUTPUT, SOURCE

from slipstep import modules

# -S leaves site-packages out; no other Python takes over
BARE = "import runpy, sys, slipstep.modules; slipstep.modules.DEBIAN = ''; sys.argv = sys.argv[1:]; " \
       "runpy.run_path(sys.argv[0], run_name='__main__')"


MOVED = {"slipstep_output.py", "slipstep_catalogue.py", "slipstep_surface.py"}  # modules of output/ of before 0.4
NO_FILE = {"numbers.py"}  # programs of `slipstep NAME` alone: beside others a file of this name would hide Python's own module from them
STANDARD = {"tests/benchmarks/ode.py"}  # needs none of them


def bare(script):
    path = os.pathsep.join([os.path.join(SOURCE, "src", "package"), os.path.dirname(script)])
    return subprocess.run([sys.executable, "-S", "-c", BARE, script], capture_output=True, text=True,
                          env=dict(os.environ, PYTHONPATH=path, PYTHONDONTWRITEBYTECODE="1"))


def scripts():
    found = []
    for folder in ("output", "training/study", "examples", "tests/benchmarks", "tests/python"):
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
                self.assertRegex(done.stderr, r"\A[\w.]+: \S+ has no (?:(h5py|petsc4py), )?numpy.*; Debian's packages are (?(1)python3-\1 )"
                                 r"python3-numpy.*\n\Z")

    def test_names_of_packages(self):
        """Debian's have hyphens where modules have underscores."""
        for script, packages in ((os.path.join(SOURCE, "src", "site", "build.py"), "python3-sphinx python3-myst-parser python3-sphinx-rtd-theme"),):
            done = bare(script)
            self.assertEqual(done.returncode, 1)
            self.assertIn(f"Debian's packages are {packages}, for", done.stderr)

    def test_another_python(self):
        """A program goes on under Debian's, also by its name there; whoever imports it does not."""
        for name, goes_on in (("plot_run.py", True), ("slipstep-plot-run", True), ("slipstep", True), ("pytest", False)):
            with mock.patch.object(modules.os, "execv") as execv, mock.patch.object(modules, "DEBIAN", "/bin/sh"), \
                    mock.patch.object(sys.modules["__main__"], "__file__", f"/usr/bin/{name}"), mock.patch.object(sys.modules["__main__"], "__spec__", None), \
                    self.assertRaisesRegex(SystemExit, "has no nothing_has_this_name"):
                modules.need("nothing_has_this_name")
            self.assertEqual(execv.called, goes_on, name)

    def test_programs(self):
        """Each file of output/ starts the program of its name, from any folder and by a link; none is without, and no program without a file."""
        programs = {name for name in glob.glob("[a-z]*.py", root_dir=os.path.join(SOURCE, "src", "package", "slipstep", "programs"))}
        files = {name for name in glob.glob("*.py", root_dir=OUTPUT) if name not in MOVED}
        self.assertEqual(files, programs - NO_FILE)
        for name in files:
            with open(os.path.join(OUTPUT, name), encoding="utf-8") as file:
                lines = file.read().splitlines()
            self.assertTrue(os.access(os.path.join(OUTPUT, name), os.X_OK), name)
            self.assertIn(f"from slipstep.programs.{name[:-3]} import main", lines)
            self.assertLess(len(lines), 15, name)
        with tempfile.TemporaryDirectory() as folder:
            os.symlink(os.path.join(OUTPUT, "catalogue_csv.py"), os.path.join(folder, "slipstep-catalogue-csv"))
            done = subprocess.run([sys.executable, os.path.join(folder, "slipstep-catalogue-csv"), "none.h5"], cwd=folder, capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr), (1, "slipstep-catalogue-csv: none.h5: no such file; fault -fault_catalogue writes it\n"))

    def test_one_program_for_all(self):
        """slipstep NAME is the program NAME, by a link, as a module and installed elsewhere; hyphens as Debian has them."""
        with tempfile.TemporaryDirectory() as folder:
            link, prefix = os.path.join(folder, "slipstep"), os.path.join(folder, "prefix")
            os.symlink(os.path.join(SOURCE, "src", "package", "program.py"), link)
            os.makedirs(os.path.join(prefix, "share", "slipstep", "python"))
            os.makedirs(os.path.join(prefix, "bin"))
            os.symlink(os.path.join(SOURCE, "src", "package", "slipstep"), os.path.join(prefix, "share", "slipstep", "python", "slipstep"))
            installed = shutil.copy(link, os.path.join(prefix, "bin", "slipstep"))
            for command, more in (([link], {}), ([installed], {}), (["-m", "slipstep"], {"PYTHONPATH": os.path.join(SOURCE, "src", "package")})):
                def start(*words):
                    return subprocess.run([sys.executable, *command, *words], cwd=folder, capture_output=True, text=True, env={**os.environ, **more})

                for name in ("catalogue-csv", "catalogue_csv"):
                    done = start(name, "none.h5")
                    self.assertEqual((done.returncode, done.stderr), (1, "slipstep catalogue-csv: none.h5: no such file; fault -fault_catalogue writes it\n"))
                self.assertIn("usage: slipstep catalogue-csv [-h]", start("catalogue-csv", "--help").stdout)
                self.assertIn("\n  plot-run ", start().stdout)
                done = start("plot-rum")
                self.assertEqual((done.returncode, done.stderr), (1, "slipstep: there is no program plot-rum; did you mean plot-run?\n"))

    def test_names_that_moved(self):
        """Modules that pages told to import have what those used, and say where it is."""
        uses = {"slipstep_output.py": "Run, OutputError", "slipstep_catalogue.py": "Catalogue", "slipstep_surface.py": "Elastic, slip_of_run"}
        self.assertEqual(set(uses), MOVED)
        for file, names in uses.items():
            module = file[:-3]
            done = subprocess.run([sys.executable, "-c", f"from {module} import {names}"], env=dict(os.environ, PYTHONPATH=OUTPUT), capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertRegex(done.stderr, rf"FutureWarning: {module} has moved: from slipstep\S* import (\w+)")
            advice = done.stderr.split("has moved: ")[1].splitlines()[0]
            done = subprocess.run([sys.executable, "-c", advice], env=dict(os.environ, PYTHONPATH=os.path.join(SOURCE, "src", "package")), capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr), (0, ""))


if __name__ == "__main__":
    unittest.main()
