"""Every script under a Python without h5py, numpy and matplotlib: one line that names Debian's packages."""

import glob
import os
import subprocess
import sys
import unittest

from scripts import OUTPUT, SOURCE

# -S leaves site-packages out; no other Python takes over
BARE = "import runpy, sys, slipstep.modules; slipstep.modules.DEBIAN = ''; sys.argv = sys.argv[1:]; " \
       "runpy.run_path(sys.argv[0], run_name='__main__')"


STANDARD = {"tests/benchmarks/ode.py"}  # needs none of them


def bare(script):
    path = os.pathsep.join([os.path.join(SOURCE, "src", "package"), os.path.dirname(script)])
    return subprocess.run([sys.executable, "-S", "-c", BARE, script], capture_output=True, text=True,
                          env=dict(os.environ, PYTHONPATH=path, PYTHONDONTWRITEBYTECODE="1"))


def scripts():
    found = []
    for folder in ("output", "training", "examples", "tests/benchmarks", "tests/python"):
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


if __name__ == "__main__":
    unittest.main()
