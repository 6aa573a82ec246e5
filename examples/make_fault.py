#!/usr/bin/env python3
"""Fields for -fault_parameters of a heterogeneous fault: strength that varies in space, and stress that makes it break
from a patch.

    make_fault.py OUT.h5 --cells 40 20 --size 20000 10000                      friction_drop and friction_slip
    make_fault.py OUT.h5 --mesh MESH.h5 --scatter 0.1
    make_fault.py OUT.h5 --cells 80 40 --size 20000 10000 --patch 5000 6000 1500 --stress 0.5
            initial_traction too

Friction falls from mu_d + friction_drop to mu_d. friction_drop is a random field with von Karman's spectrum (Hurst
exponent 0.75), --correlation [m] and --scatter (standard deviation over mean); it does not depend on the cells.
friction_slip is --slip [m], or makes each cell weaken at --weakening times the stiffness of a square cell of the mean
size. Below 1 a cell fails only together with neighbours.
With --stress the shear stress at the start is the residual strength plus this share of the drop. It varies in the same
way and is at most 98 % of the strength, but 1 % above it within --patch X Z RADIUS [m].
"""

import argparse
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need

need("h5py", "numpy")
import h5py
import numpy as np
from slipstep.fields import waves
from slipstep.results.files import write_fields


def grid(cells, size, top):
    """Centres [Nz, Nx] and mean side of a cell."""
    x, z = ((np.arange(n) + 0.5) * length / n for n, length in zip(cells, size))
    return *np.meshgrid(x, top + z), np.sqrt(size[0] * size[1] / (cells[0] * cells[1]))


def mesh(path):
    """The same of a mesh, [N]. A plane has its own field: x goes on where the plane before ends."""
    with h5py.File(path) as file:
        x, y, z, length, width = file["cells"][...].T
    return x + 1e6 * np.unique(y, return_inverse=True)[1], z, np.sqrt(np.mean(length * width))


def fields(x, z, side, a):
    random = np.random.default_rng(a.seed)
    drop = a.drop * np.maximum(1 + a.scatter * waves((x, z), a.correlation, random), 0.1)
    stiffness = a.shear_modulus * np.sqrt(2) / np.pi * (7 / 3) / side  # of a square in a full space, nu = 1/4
    made = {"friction_drop": (drop, "1"),
            "friction_slip": (np.full_like(drop, a.slip) if a.slip else drop * a.normal_stress
                              / (a.weakening * stiffness), "m")}
    if a.stress is not None:
        share = a.stress * (1 + a.scatter * waves((x, z), a.correlation, random))
        strength = (a.residual + drop) * a.normal_stress
        stress = np.minimum(a.normal_stress * (a.residual + share * drop), 0.98 * strength)
        if a.patch:
            stress = np.where(np.hypot(x - a.patch[0], z - a.patch[1]) < a.patch[2], 1.01 * strength, stress)
        made["initial_traction"] = (stress, "Pa")
    return made


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", metavar="OUT.h5")
    parser.add_argument("--cells", type=int, nargs=2, default=[40, 20], metavar=("NX", "NZ"))
    parser.add_argument("--size", type=float, nargs=2, default=[20000, 10000], metavar=("LX", "LZ"), help="[m]")
    parser.add_argument("--top", type=float, default=0, help="depth of the upper edge [m]")
    parser.add_argument("--mesh", metavar="MESH.h5", help="cells of this mesh in place of a grid")
    parser.add_argument("--drop", type=float, default=0.1, help="mean of friction_drop")
    parser.add_argument("--scatter", type=float, default=0.2)
    parser.add_argument("--correlation", type=float, default=2000, help="[m]")
    parser.add_argument("--weakening", type=float, default=0.55, help="rate of weakening over the stiffness of a cell")
    parser.add_argument("--slip", type=float, help="friction_slip [m], in place of --weakening")
    parser.add_argument("--stress", type=float, help="share of the drop in the shear stress at the start")
    parser.add_argument("--patch", type=float, nargs=3, metavar=("X", "Z", "RADIUS"),
                        help="circle in which the rupture begins [m]")
    parser.add_argument("--normal-stress", type=float, default=50e6, help="of the run [Pa]")
    parser.add_argument("--residual", type=float, default=0.5, help="friction_residual of the run")
    parser.add_argument("--shear-modulus", type=float, default=30e9, help="of the run [Pa]")
    parser.add_argument("--seed", type=int, default=3)
    a = parser.parse_args()
    if (min(a.cells) < 1 or min(a.size) <= 0 or min(a.drop, a.correlation, a.weakening, a.normal_stress) <= 0
        or a.scatter < 0):
        parser.error("--cells, --size, --drop, --correlation, --weakening and --normal-stress must be positive, "
                     "--scatter zero or positive")
    if a.patch and a.stress is None:
        parser.error("--patch needs --stress")
    return a


def main():
    a = arguments()
    try:
        cells = mesh(a.mesh) if a.mesh else grid(a.cells, a.size, a.top)
    except (OSError, KeyError, ValueError) as error:
        sys.exit(f"make_fault.py: {a.mesh}: {error}")
    write_fields(a.output, fields(*cells, a))
    print(f"{a.output}: {cells[0].size} cells")


if __name__ == "__main__":
    main()
