#!/usr/bin/env python3
"""Mesh files for -fault_mesh: rectangular cells on parallel vertical planes.

    make_mesh.py OUT.h5 uniform --cells 20 20 --size 3000 3000
    make_mesh.py OUT.h5 graded --cells 40 30 --size 3000 3000 --ratio 4
    make_mesh.py OUT.h5 parallel --cells 20 20 --size 3000 3000 --offset 1000 --shift 500

The file holds /cells [n, 5], one row per cell: x (centre along strike), y (across), z (centre's depth), length (along
strike), width (in depth), all in m, with the attribute columns = "x y z length width". In graded meshes the widths grow
geometrically with depth and the lengths towards both ends, so that the largest is --ratio times the smallest: small
cells are in the middle at the top. Parallel faults lie at y = 0 and y = --offset, the second --shift further along
strike; both may be graded.
"""

import argparse
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "output"))
from slipstep_modules import need

need("h5py", "numpy")
import h5py
import numpy as np

COLUMNS = "x y z length width"


def edges_in_depth(n, size, top, ratio):
    """n + 1 depths [m] from top on; the deepest interval is ratio times the shallowest."""
    widths = np.geomspace(1, ratio, n)
    return top + np.concatenate([[0], np.cumsum(widths)]) * size / widths.sum()


def edges_along_strike(n, size, ratio):
    """n + 1 positions [m] from 0 to size, symmetric; the outermost intervals are ratio times those in the middle."""
    distance = np.abs(np.arange(n) - (n - 1) / 2) / max((n - 1) / 2, 1)
    lengths = ratio**distance
    return np.concatenate([[0], np.cumsum(lengths)]) * size / lengths.sum()


def plane(cells, size, top, ratio, x0=0.0, y=0.0):
    """Rows [n, 5] of one plane whose left end is at x0, x fastest."""
    x = x0 + edges_along_strike(cells[0], size[0], ratio)
    z = edges_in_depth(cells[1], size[1], top, ratio)
    cx, cz = np.meshgrid((x[1:] + x[:-1]) / 2, (z[1:] + z[:-1]) / 2)
    lx, lz = np.meshgrid(np.diff(x), np.diff(z))
    return np.stack([cx, np.full_like(cx, y), cz, lx, lz], axis=-1).reshape(-1, 5)


def write(path, rows):
    with h5py.File(path, "w") as file:
        file["cells"] = rows
        file["cells"].attrs["columns"] = COLUMNS
        file["cells"].attrs["units"] = "m"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", metavar="OUT.h5")
    parser.add_argument("kind", choices=["uniform", "graded", "parallel"])
    parser.add_argument("--cells", type=int, nargs=2, default=[20, 20], metavar=("NX", "NZ"), help="of each fault")
    parser.add_argument("--size", type=float, nargs=2, default=[3000, 3000], metavar=("LX", "LZ"),
                        help="of each fault [m]")
    parser.add_argument("--top", type=float, default=0, help="depth of the upper edge [m]")
    parser.add_argument("--ratio", type=float, default=None, help="largest over smallest side (graded: 4, parallel: 1)")
    parser.add_argument("--offset", type=float, default=1000, help="between parallel faults [m]")
    parser.add_argument("--shift", type=float, default=0, help="of the second fault along strike [m]")
    a = parser.parse_args()
    if min(a.cells) < 1 or min(a.size) <= 0 or a.top < 0:
        parser.error("--cells and --size must be positive, --top zero or positive")
    ratio = {"uniform": 1.0, "graded": a.ratio or 4.0, "parallel": a.ratio or 1.0}[a.kind]
    if ratio < 1:
        parser.error("--ratio must be at least 1")
    rows = plane(a.cells, a.size, a.top, ratio)
    if a.kind == "parallel":
        if a.offset == 0:
            parser.error("--offset must not be 0")
        rows = np.concatenate([rows, plane(a.cells, a.size, a.top, ratio, x0=a.shift, y=a.offset)])
    write(a.output, rows)
    print(f"{a.output}: {len(rows)} cells")


if __name__ == "__main__":
    main()
