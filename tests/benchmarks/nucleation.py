#!/usr/bin/env python3
"""The length at which a loaded fault that weakens linearly with slip becomes unstable, against the theory's.

nucleation.py FAULT [CELLS ...]

A fault of 10 km in depth and 500 km along strike in a full space, one cell wide, is a two-dimensional one in antiplane
strain. Its shear stress has a parabolic peak just below the strength, and grows by 0.01 Pa/s everywhere. Uenishi and
Rice (2003, J. Geophys. Res. 108, 2042) showed that quasi-static slip stops to exist when the sliding part is 1.158 G/W
long, whatever the peak's shape; W is the weakening rate, here such that this is 1 km: 20 of 200 cells. Measured is the
length of all cells that slide when the largest slip rate first exceeds 1e-6 m/s: ten thousand times what loading makes
of it, and reached within seconds of the instability.
"""

import os
import subprocess
import sys
import tempfile

import common  # noqa: F401: before modules that may be missing
import h5py
import numpy as np

G, WIDTH, CRITICAL, STRESS, DROP, RESIDUAL = 30e9, 10e3, 1e3, 50e6, 0.1, 0.5
WEAKENING = 1.158 * G / CRITICAL
# of the peak [Pa/m^2]: it rises above the strength by less than a tenth of the friction drop before the instability
CURVATURE = 0.6e6 / CRITICAL ** 2


def length(fault, cells, options=()):
    """Sliding length at the instability [m], its time [s], and attempts of the run"""
    z = (np.arange(cells) + 0.5) * WIDTH / cells
    # off the middle of the fault, so that cells join on one side at a time
    below = np.minimum(CURVATURE * (z - 0.5 * WIDTH - 0.23 * WIDTH / cells) ** 2, 10e6)
    with tempfile.TemporaryDirectory() as folder:
        with h5py.File(os.path.join(folder, "peak.h5"), "w") as file:
            file["initial_traction"] = ((RESIDUAL + DROP) * STRESS - 1e3 - below)[:, None]
        command = [fault, "-fault_nx", 1, "-fault_nz", cells, "-fault_length_x", 50 * WIDTH, "-fault_length_z", WIDTH,
                   "-fault_depth_top", 0, "-fault_kernel", "full_space", "-fault_normal_stress", STRESS,
                   "-fault_normal_stress_gradient", 0, "-fault_friction_residual", RESIDUAL, "-fault_friction_drop",
                   DROP, "-fault_friction_law", "linear_slip_weakening", "-fault_friction_slip",
                   STRESS * DROP / WEAKENING, "-fault_initial", "traction", "-fault_parameters", "peak.h5",
                   "-fault_stressing_rate", 0.01, "-fault_inertia", "no", "-fault_viscosity", "radiation",
                   "-ts_adapt_type", "heuristic", "-ts_max_time", 1e8, "-ts_max_steps", 1500, "-fault_output", "run.h5",
                   "-fault_output_fields", "slip_rate", "-fault_output_interval", 10 ** 6, "-fault_output_rate_change",
                   3, "-fault_progress", "no", *options]
        done = subprocess.run([str(word) for word in command], cwd=folder, capture_output=True, text=True)
        with h5py.File(os.path.join(folder, "run.h5" if done.returncode == 0 else "run.h5.part"), "r") as run:
            rate, time = np.abs(run["fields/slip_rate"][...]).reshape(-1, cells), run["fields/time"][...]
            attempts = len(run["steps/time"])
    fast = np.flatnonzero(rate.max(axis=1) > 1e-6)
    if not len(fast):
        sys.exit(f"no instability with {cells} cells: {done.stdout[-500:]}{done.stderr[-500:]}")
    return (rate[fast[0]] > 0).sum() * WIDTH / cells, time[fast[0]], attempts


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    print("cells  length/theory  time [s]  attempts")
    for n in map(int, sys.argv[2:] or (200, 400, 800)):
        found, when, attempts = length(os.path.abspath(sys.argv[1]), n)
        print(f"{n:5d}  {found / CRITICAL:.4f}  {when:.6g}  {attempts}", flush=True)
