"""Forty damaged files of each kind, see tests/fuzz.py; tests/fuzz.py by hand reads thousands, under the sanitizers too."""
import os
import subprocess
import sys

from scripts import SOURCE

sys.exit(subprocess.run([sys.executable, os.path.join(SOURCE, "tests", "fuzz.py"), "--count", "40", "--seed", "2"]).returncode)
