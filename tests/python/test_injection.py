#!/usr/bin/env python3
"""Injection into a fault of constant friction: edge and slip of the growing crack against the exact solutions of
tests/benchmarks/injection.py, on a line by -fault_pore_pressure, in a circle by -fault_injection, and after the end of
an injection against a model of its own; errors fall with the mesh, and ranks and meshes make the same run."""
import os
import subprocess
import sys
import tempfile

from scripts import BUILD, SOURCE


sys.path.insert(0, os.path.join(SOURCE, "tests", "benchmarks"))
sys.path.insert(0, os.path.join(SOURCE, "examples"))
import h5py
import injection
import make_mesh
import numpy as np

failed = []


def check(good, text):
    print(text if good else "FAILED: " + text, flush=True)
    if not good:
        failed.append(text)


def converges(name, errors, folder, cells, edge, slip):
    """edge, slip: bounds on the finer cells; on the coarser ones the worst of the three times is worse."""
    tables = [abs(errors(BUILD, folder, n)[0]).max(axis=0) for n in cells]
    check((tables[1] < (edge, slip)).all() and (tables[1] < tables[0]).all(),
          f"{name}: worst errors of edge and slip {tables[0]} with {cells[0]} cells, {tables[1]} with {cells[1]}")


with tempfile.TemporaryDirectory() as folder:
    # The issue wants edges within 3 %; measured are 0.18 % (0.75 % of slip) on the line, whose first crack is 14 cells
    # from the middle to the edge, and 2.9 % (0.7 %) in the circle, whose first one is 5.7 cells.
    converges("line", injection.line_errors, folder, (200, 400), 0.01, 0.01)
    converges("circle", injection.circle_run, folder, (20, 40), 0.03, 0.01)
    # Where friction chooses the edge, averages with the core of `cell` have the error of their bulk, 1.8 % of waves of
    # 40 cells: moments of a circle of 12.7 cells are off by 0.80 % by centres, 0.48 % with the cores of `whole`, 4.0 %
    # by `cell` (and 0.54, 0.40 and 2.9 % with 20 x 20 cells).
    centre, cell, whole = (abs(injection.circle_moment_error(BUILD, folder, 14, ["-fault_stiffness_average", name]))
                           for name in ("centre", "cell", "whole"))
    check(max(centre, whole) < 0.012 and cell > 3 * centre,
          f"moment of a circle of 14 cells: off by {centre:.4f} by centre, {cell:.4f} by cell, {whole:.4f} by whole")
    # measured: 0.11 % and 0.03 %
    rows, steps = injection.shut_in_errors(BUILD, folder, 100)
    check(abs(rows[:, 0]).max() < 0.005 and rows[:, 1].max() < 0.002, f"shut-in: {rows} in {steps} steps")

    # a mesh that is the grid, in another order of rows, on ranks
    n = 40
    z = (np.arange(n) + 0.5) / n * 2 * injection.LINE_HALF - injection.LINE_HALF
    order = np.random.default_rng(1).permutation(n)
    cells = np.column_stack([np.full(n, 5e5), np.zeros(n), injection.DEPTH + injection.LINE_HALF + z,
                             np.full(n, 1e6), np.full(n, 2 * injection.LINE_HALF / n)])
    make_mesh.write(os.path.join(folder, "mesh.h5"), cells[order])
    z0, slip, _ = injection.line_run(BUILD, folder, n, (50.0,))
    with h5py.File(os.path.join(folder, "pressure.h5"), "r+") as f:
        pressure = f["pressure"][:, :, 0]
        del f["pressure"]
        f["pressure"] = pressure[:, order]
    base = [os.path.join(BUILD, "bin", "fault"), *injection.COMMON, "-fault_mesh", "mesh.h5", "-fault_thickness", "1e6",
            "-fault_initial_traction", str(injection.LINE_LOAD), "-fault_pore_pressure", "pressure.h5",
            "-ts_max_time", str(50 * injection.DAY)]
    for ranks in (1, 2):
        out = os.path.join(folder, f"mesh{ranks}.h5")
        subprocess.run((["mpirun", "--oversubscribe", "-n", "2"] if ranks > 1 else []) + base + ["-fault_output", out],
                       cwd=folder, check=True, stdout=subprocess.DEVNULL)
        with h5py.File(out) as f:
            off = abs(f["fields/slip"][-1] - slip[0][order]).max() / slip.max()
        # a stage ends at a residual of 1e-13 of the strength, 30 MPa, where the stress drop is 1 MPa
        check(off < 1e-9, f"mesh on {ranks} ranks: the slip of the grid to {off:.1e}")
sys.exit(bool(failed))
