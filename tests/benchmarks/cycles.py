#!/usr/bin/env python3
"""Cycles of rate-and-state faults: products with K for each event against the error of event times, of integrators and controllers, on BP5 at
2 km, BP1 at 200 m and two other faults; bp5_1km and bp1_100m are finer.

    cycles.py [--faults bp5,bp1,core,strip,bp5_1km,bp1_100m] [--program build/bin/fault]

The error is the largest of those of the events after the first, over the last recurrence, against adams under basic at -ts_rtol 1e-7. A run counts at
an error if it, and every tighter one of its family, is as good: the cheapest such run of each family is printed.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "src", "package"))
from slipstep.modules import need

need("h5py", "numpy")
import h5py
import numpy as np

YEAR = 3.15576e7
COMMON = {"fault_friction_law": "rate_and_state", "fault_normal_stress_gradient": 0, "fault_loading_rate": 1e-9, "fault_shear_modulus": 32.03812e9,
          "fault_density": 2670}
FAMILIES = [(f"{rk} {adapt}", ["-ts_type", "rk", "-ts_rk_type", rk, "-ts_adapt_type", adapt], "-ts_rtol", tolerances)
            for rk, tolerances in (("3bs", "1e-2 3e-3 1e-3 3e-4 1e-4"), ("5dp", "1e-3 3e-4 1e-4 5e-5 1e-5")) for adapt in ("basic", "dsp")]
FAMILIES += [(f"adams {adapt}", ["-ts_type", "adams", "-ts_adapt_type", adapt], "-ts_rtol", "3e-2 1e-2 3e-3 1e-3 3e-4 1e-4 1e-5")
             for adapt in ("basic", "dsp", "pi")]
ERRORS = [3e-3, 2e-3, 1e-3, 5e-4, 3e-4, 1e-4, 5e-5]


def bp5(cell=2):
    x, z = np.meshgrid((np.arange(100 // cell) + 0.5) * cell - 50, (np.arange(40 // cell) + 0.5) * cell)
    share = np.clip(np.maximum(abs(z - 10) - 6, abs(x) - 30) / 2, 0, 1)
    patch = (x > -30) & (x < -18) & (z > 4) & (z < 16)
    slip = np.where(patch, 0.13, 0.14)
    fields = {"friction_a": 0.004 + share * 0.036, "friction_slip": slip, "initial_rate": np.where(patch, 0.03, 1e-9), "initial_state": slip / 1e-9}
    return fields, {"fault_length_x": 100e3, "fault_length_z": 40e3, "fault_normal_stress": 25e6, "fault_friction_b": 0.03}, 2340


def bp1(cell=200):
    z = (np.arange(40000 // cell)[:, None] + 0.5) * cell
    return ({"friction_a": np.interp(z, [15e3, 18e3], [0.010, 0.025])},
            {"fault_length_x": 1e7, "fault_length_z": 40e3, "fault_normal_stress": 50e6, "fault_friction_b": 0.015, "fault_friction_slip": 0.008,
             "fault_initial": "traction", "fault_initial_traction": 26.54612e6, "fault_initial_rate": 1e-9}, 1000)


def core(nx=36, nz=18, cell=1200, a=0.008, b=0.02, rim=0.03, slip=0.05, stress=40e6, years=618):
    x, z = np.meshgrid((np.arange(nx) + 0.5) / nx - 0.5, (np.arange(nz) + 0.5) / nz)
    share = np.clip(np.maximum((abs(z - 0.45) - 0.28) * nz, (abs(x) - 0.34) * nx) / 1.5, 0, 1)
    fields = {"friction_a": a + share * (rim - a), "friction_slip": slip * (1 + 0.15 * np.sin(9 * x + 1) * np.cos(11 * z)),
              "initial_rate": np.where((x < -0.2) & (share == 0), 1e-8, 1e-9)}
    return fields, {"fault_length_x": nx * cell, "fault_length_z": nz * cell, "fault_normal_stress": stress, "fault_friction_b": b,
                    "fault_shear_modulus": 30e9, "fault_density": 2700}, years


def strip():
    return core(64, 10, 1500, 0.003, 0.015, 0.025, 0.045, 30e6, 697)


FAULTS = {"bp5": bp5, "bp1": bp1, "core": core, "strip": strip, "bp5_1km": lambda: bp5(1), "bp1_100m": lambda: bp1(100)}


def run(program, folder, fault, options):
    """Onsets [years] of events after the start, and right-hand sides; None of a run that failed."""
    fields, numbers, years = fault
    nz, nx = fields["friction_a"].shape
    parameters, catalogue, log = (os.path.join(folder, name) for name in ("fields.h5", "events.h5", "log.txt"))
    with h5py.File(parameters, "w") as f:
        for name, values in fields.items():
            f[name] = values
    command = [program, "-fault_nx", nx, "-fault_nz", nz, "-fault_parameters", parameters, "-ts_max_time", repr(years * YEAR), "-fault_catalogue", catalogue,
               "-fault_output_overwrite", "-fault_progress", "no", "-log_view", ":" + log, *options]
    for name, value in {**COMMON, **numbers}.items():
        command += ["-" + name, value]
    try:
        subprocess.run([str(word) for word in command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=120, check=True)
    except subprocess.SubprocessError:  # of one that a controller has driven into the wall as well
        return None
    with h5py.File(catalogue) as f:
        onset = f["onset"][()] / YEAR
    with open(log, encoding="utf-8") as f:
        products = int(re.search(r"^TSFunctionEval +(\d+)", f.read(), re.M).group(1))
    onset = onset[onset > 1]
    return onset[np.diff(onset, prepend=-9) > 1], products  # an event that an instant of slower slip cuts in two is one


def error_of(onset, reference):
    if len(onset) != len(reference):
        return np.inf
    return abs(onset - reference).max() / (reference[-1] - reference[-2])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--faults", default="bp5,bp1,core,strip", help="which of them (default: %(default)s)")
    parser.add_argument("--program", default=os.path.join(ROOT, "build", "bin", "fault"), help="default: %(default)s")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for name in args.faults.split(","):
            fault = FAULTS[name]()
            reference = run(args.program, folder, fault, ["-ts_type", "adams", "-ts_adapt_type", "basic", "-ts_rtol", "1e-7"])[0]
            table = {}
            for family, options, key, values in FAMILIES:
                for value in reversed(values.split()):
                    result = run(args.program, folder, fault, options + [key, value])
                    error = error_of(result[0], reference) if result else np.inf
                    products = result[1] / len(reference) if result else np.inf
                    print(f"{name:6s} {family:12s} {value:6s} products {products:7.0f}  error {error:.1e}", flush=True)
                    table.setdefault(family, []).append((error, products))
            for bound in ERRORS:
                best = {}
                for family, rows in table.items():
                    good = next((k for k, row in enumerate(rows) if row[0] > bound), len(rows))
                    best[family] = min((row[1] for row in rows[:good]), default=np.inf)
                pairs = min(value for family, value in best.items() if family[0] in "35")
                adams = min(value for family, value in best.items() if family.startswith("adams"))
                ours = best["adams dsp"]  # the default's
                print(f"{name:6s} error <= {bound:.0e}: pairs {pairs:7.0f}  adams {adams:7.0f}  dsp {ours:7.0f}  "
                      f"pairs/dsp {pairs / ours:.2f}  best/dsp {min(pairs, adams) / ours:.2f}", flush=True)


if __name__ == "__main__":
    main()
