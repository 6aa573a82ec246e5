#!/usr/bin/env python3
"""How accurate a mesh of n cells across is: a circular crack of uniform stress drop, whose slip is known.

    tests/benchmarks/crack.py [--build build] [--cells 10 20 40 56] [--ratio 1 4] [--poisson 0.25] [--output
    output/crack.h5]

The crack is of the cells of `examples/make_mesh.py`, uniform or graded, whose centres lie in a circle of a full space:
`alone`, with nothing around it, or `held`, with two rows of cells around its square that do not slip. The stiffness is
that of the program (-fault_stiffness_view) and the slip the solution of K u = drop. The exact slip of a shear crack is
8 (1 - nu) / (pi (2 - nu)) drop / G sqrt(a^2 - r^2), along the load for every Poisson's ratio (Eshelby 1957). Errors are
over the largest slip: root of the mean square over the area, the worst cell, the cell in the middle; that of the moment
is over the exact one, beside what the cells' total area, to the power 3/2, makes of it.
"""

import argparse
import itertools
import os
import subprocess
import tempfile

from common import ROOT
import h5py
import numpy as np

import make_mesh

G, RADIUS, DEPTH = 30e9, 1000.0, 20e3
AVERAGES = ("centre", "cell", "whole")
COLUMNS = "rms worst middle moment area"


def square(cells, ratio, held):
    """Rows [n, 5] of the fault's cells, and which of them slip."""
    side = RADIUS * (1 + 4 / cells if held else 1)
    count = cells + 4 if held else cells
    rows = make_mesh.plane((count, count), (2 * side, 2 * side), DEPTH - side, ratio, x0=-side)
    slips = rows[:, 0] ** 2 + (rows[:, 2] - DEPTH) ** 2 < RADIUS**2
    return (rows, slips) if held else (rows[slips], slips[slips])


def stiffness(build, mesh, n, average, poisson, folder, *options):
    """The area-weighted stiffness [n, n] of the fault program [Pa/m]."""
    view = os.path.join(folder, "K.bin")
    command = [os.path.join(build, "bin", "fault"), "-fault_mesh", mesh, "-fault_kernel", "full_space",
               "-fault_operator", "dense", "-fault_poisson_ratio", str(poisson), "-fault_stiffness_average", average,
               "-fault_damping_ratio", "0", "-fault_initial", "rest", "-ts_max_steps", "0", "-ts_max_time", "1e-3",
               "-fault_stiffness_view", f"binary:{view}", *options]
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    if not os.path.exists(view):
        raise SystemExit(f"{' '.join(command)} failed:\n{done.stderr}")
    return np.fromfile(view, ">f8", offset=os.path.getsize(view) - 8 * n * n).reshape(n, n)  # after PETSc's integers


def errors(rows, slips, S, poisson):
    mean = rows[:, 3] @ rows[:, 4] / len(rows)
    rows, S = rows[slips], S[np.ix_(slips, slips)]
    area = rows[:, 3] * rows[:, 4]
    r = np.hypot(rows[:, 0], rows[:, 2] - DEPTH)
    largest = 8 * (1 - poisson) / (np.pi * (2 - poisson)) / G * RADIUS
    slip = np.linalg.solve(S, area / mean)
    wrong = (slip - largest * np.sqrt(1 - (r / RADIUS) ** 2)) / largest
    moment = (slip @ area) / (largest * 2 / 3 * np.pi * RADIUS**2) - 1
    return (np.sqrt(wrong**2 @ area / area.sum()), abs(wrong).max(), wrong[np.argmin(r)], moment,
            (area.sum() / (np.pi * RADIUS**2)) ** 1.5 - 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.path.join(ROOT, "build"))
    parser.add_argument("--cells", type=int, nargs="+", default=[10, 20, 40, 56], help="across")
    parser.add_argument("--ratio", type=float, nargs="+", default=[1, 4], help="largest over smallest side")
    parser.add_argument("--poisson", type=float, default=0.25)
    parser.add_argument("--output", default=None, metavar="F.h5", help="keep the table")
    a = parser.parse_args()
    table = []
    print("edge   ratio  across  slips  average    " + "".join(f"{name:>10}" for name in COLUMNS.split()))
    with tempfile.TemporaryDirectory() as folder:
        mesh = os.path.join(folder, "mesh.h5")
        for held, ratio, cells in itertools.product((False, True), a.ratio, a.cells):
            rows, slips = square(cells, ratio, held)
            make_mesh.write(mesh, rows)
            for average in AVERAGES:
                S = stiffness(os.path.abspath(a.build), mesh, len(rows), average, a.poisson, folder)
                row = errors(rows, slips, S, a.poisson)
                table.append((held, ratio, cells, AVERAGES.index(average), *row))
                print(f"{'held' if held else 'alone':5}  {ratio:5g}  {cells:6d}  {slips.sum():5d}  {average:8}   " +
                      "".join(f"{100 * x:9.2f}%" for x in row), flush=True)
    if a.output:
        with h5py.File(a.output, "w") as file:
            file["crack"] = np.array(table, float)
            file["crack"].attrs["columns"] = "held ratio across average " + COLUMNS


if __name__ == "__main__":
    main()
