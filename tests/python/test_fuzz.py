"""Forty damaged files of each kind, twelve of those that a program of its own reads: see tests/fuzz.py, which reads
thousands by hand, under the sanitizers too."""
import os
import subprocess
import sys

from scripts import SOURCE

FUZZ = [sys.executable, os.path.join(SOURCE, "tests", "fuzz.py"), "--seed", "2"]
codes = [subprocess.run([*FUZZ, "--count", count, *kinds]).returncode
         for count, kinds in (("40", ("policy", "mesh", "planes", "triangles", "gmsh22", "gmsh41", "parameters",
                                      "stiffness", "history", "history_csv", "zip")),
                         ("12", ("checkpoint", "catalogue", "output", "stations")))]
sys.exit(max(codes))
