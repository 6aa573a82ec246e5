"""What the tests of the scripts in output/ share: the folder on Python's path, and a test case with a folder for its
files."""

import os
import subprocess
import sys
import tempfile
import unittest

SOURCE = os.environ.get("SLIPSTEP_SOURCE", os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
OUTPUT = os.path.join(SOURCE, "output")
sys.path.insert(0, OUTPUT)
from slipstep_modules import need

need("h5py", "numpy", "matplotlib")


class ScriptTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def script(self, name, *arguments):
        return subprocess.run([sys.executable, os.path.join(OUTPUT, name), *arguments], capture_output=True, text=True)
