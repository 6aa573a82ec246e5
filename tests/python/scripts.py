"""What the tests of the package and of its programs share: the package on Python's path, and a test case with a folder
for its files."""

import contextlib
import importlib
import importlib.util
import io
import os
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

SOURCE = os.environ.get("SLIPSTEP_SOURCE", os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
BUILD = os.environ.get("SLIPSTEP_BUILD", os.path.join(SOURCE, "build"))
FAULT = os.path.join(BUILD, "bin", "fault")
PROGRAM = os.path.join(SOURCE, "src", "package", "program.py")  # slipstep NAME
TWO_PLANES = "parallel --cells 5 4 --ratio 2 --offset 1000 --shift 500"  # for make_mesh()
sys.path.insert(0, os.path.join(SOURCE, "src", "package"))
from slipstep.modules import need

need("h5py", "numpy", "matplotlib")
import h5py


class ScriptTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def put(self, name, content):
        """A file of this text or these bytes; its path."""
        with open(self.path(name), "wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode())
        return self.path(name)

    def content(self, name, encoding="utf-8"):
        """The text of a file; its bytes, of no encoding."""
        with open(self.path(name), "r" if encoding else "rb", encoding=encoding) as file:
            return file.read()

    def hdf5(self, name, units=None, **datasets):
        """A file of these datasets, some of which have units."""
        with h5py.File(self.path(name), "w") as file:
            for key, values in datasets.items():
                file[key] = values
            for key, unit in (units or {}).items():
                file[key].attrs["units"] = unit

    def get(self, name, *paths):
        """A dataset of an HDF5 file, or an attribute as "group@attribute"; a list of several."""
        with h5py.File(self.path(name)) as file:
            found = [file[path].attrs[key] if key else file[path][()] for path, _,
                     key in (p.partition("@") for p in paths)]
        return found if len(found) > 1 else found[0]

    def run_example(self, script, *arguments):
        """What a script of examples/ prints that succeeds."""
        command = [sys.executable, os.path.join(SOURCE, "examples", script), *map(str, arguments)]
        return subprocess.run(command, cwd=self.folder.name, check=True, capture_output=True, text=True).stdout

    def make_mesh(self, name, words):
        self.run_example("make_mesh.py", name, *words.split())

    def script(self, name, *arguments, **more):
        """slipstep NAME"""
        return subprocess.run([sys.executable, PROGRAM, name, *arguments], capture_output=True, text=True, **more)


class FaultTest(ScriptTest):
    """Runs of the program fault in a folder of their own."""

    def fault(self, *options, ranks=1, code=0, program=FAULT, **more):
        """What a run prints that ends with this code."""
        command = (["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []) + [program, *map(str, options)]
        done = subprocess.run(command, cwd=self.folder.name, capture_output=True, text=True, **more)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stdout + done.stderr


def called(module):
    """The name of a program, or of a script of examples/, in its messages."""
    ours = importlib.util.find_spec(f"slipstep.programs.{module}")
    return f"slipstep {module.replace('_', '-')}" if ours else f"{module}.py"


class PictureTest(ScriptTest):
    """Scripts within this process: most of a picture's time is that of starting Python and Matplotlib."""

    def main(self, module, *arguments):
        """Exit code, output and error output of main() of a script."""
        out, err, code = io.StringIO(), io.StringIO(), 0
        *words, name = called(module).split(" ")
        script = importlib.import_module(module if name.endswith(".py") else "slipstep.__main__")
        with mock.patch.object(sys, "argv", [*words, name, *arguments]), contextlib.redirect_stdout(
                out), contextlib.redirect_stderr(err):
            try:
                script.main()
            except SystemExit as stop:
                code = stop.code if isinstance(stop.code, int) else 1
                err.write("" if isinstance(stop.code, int) else f"{stop.code}\n")
        importlib.import_module("slipstep.plots.panels").plt.close("all")
        return code, out.getvalue(), err.getvalue()

    def plot(self, module, *arguments):
        """What a script prints that succeeds without a warning."""
        code, out, err = self.main(module, *arguments)
        self.assertEqual((code, err), (0, ""))
        return out

    def refused(self, module, message, *arguments, code=1):
        """A script ends with one line that has a message; with code 2 after the usage."""
        found, _, err = self.main(module, *arguments)
        self.assertEqual(found, code, err)
        self.assertRegex(err.splitlines()[-1], f"^{called(module)}: .*{message}")
        self.assertTrue(code == 2 or err.count("\n") == 1, err)

    def look(self, path):
        """A picture is there, with the many colours of maps and smooth lines, not only axes."""
        from PIL import Image
        with Image.open(path) as image:
            self.assertGreater(len(image.convert("RGB").resize((400, 400), Image.Resampling.NEAREST).getcolors(160000)),
                               50, path)
