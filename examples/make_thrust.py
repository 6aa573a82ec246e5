#!/usr/bin/env python3
"""Make the friction of the thrust's cells and a network of GNSS points above it, for examples/thrust.sh.

    examples/make_thrust.py FIELDS.h5 POINTS.txt --cells 48 24
"""

import argparse
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need

need("h5py", "numpy")
import numpy as np
from slipstep.results.files import write_fields

SIZE = 60e3, 30e3  # along strike and down dip [m], as in thrust.opts
LOCKED = 8e3, 20e3  # where friction weakens: so far from both ends, and so far down [m]
WIDTH = 4e3  # over which friction changes [m]
WEAK, STRONG = 0.006, 0.022  # a, beside b = 0.015
STRIKE = np.radians(20)


def direct_effect(nx, nz):
    """a [nz, nx]: cells weaken in the middle, up to the ground, and creep around."""
    s, d = np.meshgrid((np.arange(nx) + 0.5) * SIZE[0] / nx, (np.arange(nz) + 0.5) * SIZE[1] / nz)
    outside = np.maximum(np.abs(s - SIZE[0] / 2) - (SIZE[0] / 2 - LOCKED[0]), d - LOCKED[1])
    return np.interp(outside, [0, WIDTH], [WEAK, STRONG])


def network():
    """Points [n, 2], 10 to 18 km apart, denser near the trace: rows along strike, shifted against each other."""
    points = []
    for row, across in enumerate((-32e3, -18e3, -8e3, -2e3, 4e3, 12e3, 22e3, 34e3, 50e3)):
        spacing = 12e3 if abs(across) < 20e3 else 18e3
        for along in np.arange(-18e3 + 0.5 * spacing * (row % 2), 78e3, spacing):
            points.append((np.cos(STRIKE) * along - np.sin(STRIKE) * across,
                           np.sin(STRIKE) * along + np.cos(STRIKE) * across))
    return np.array(points)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("fields", help="file for -fault_parameters")
    parser.add_argument("points", help="file for -fault_surface_stations")
    parser.add_argument("--cells", nargs=2, type=int, metavar=("NX", "NZ"), default=(48, 24))
    options = parser.parse_args()
    if min(options.cells) < 1:
        parser.error("--cells is {} {}, expected numbers > 0".format(*options.cells))
    write_fields(options.fields, {"friction_a": (direct_effect(*options.cells), "1")})
    np.savetxt(options.points, network(), fmt="%.0f", delimiter=",", header="x north, y east [m]")


if __name__ == "__main__":
    main()
