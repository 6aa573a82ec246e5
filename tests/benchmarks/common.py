"""What scripts of this folder share: the repository, with its package and its examples on Python's path, and files."""

import os
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path[:0] = [os.path.join(ROOT, "src", "package"), os.path.join(ROOT, "examples")]
sys.dont_write_bytecode = True
from slipstep.modules import need

need("h5py", "numpy")
import h5py


def write(path, **datasets):
    """An HDF5 file of these datasets."""
    with h5py.File(path, "w") as file:
        for name, values in datasets.items():
            file[name] = values
