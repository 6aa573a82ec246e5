#!/usr/bin/env python3
"""Cycles of rate-and-state faults: products with K for each event against the error of event times, of integrators and
controllers, on BP5 at 2 km, BP1 at 200 m and two other faults; bp5_1km and bp1_100m are finer.

    cycles.py [--faults bp5,bp1,core,strip,bp5_1km,bp1_100m] [--program build/bin/fault]
    cycles.py --drawn 20 [--seed 1000] [--options "-ts_adapt_type dsp -ts_rtol 1e-2"]

The error is the largest of those of the events after the first, over the last recurrence, against adams under basic at
-ts_rtol 1e-7. A run counts at an error if it, and every tighter one of its family, is as good: the cheapest such run of
each family is printed.

--drawn draws lines of 32 to 96 cells and planes of 128 to 512, with five events that come regularly, against basic at
1e-4, which 5dp at 1e-4 confirms to 2e-3; it prints what the default, or the options, has of each kind: products for an
event, errors, and the share within 1e-2 and 3e-3.
"""

import argparse
import os
import re
import subprocess
import tempfile

from common import ROOT, write
import h5py
import numpy as np

YEAR = 3.15576e7
COMMON = {"fault_friction_law": "rate_and_state", "fault_normal_stress_gradient": 0, "fault_loading_rate": 1e-9,
          "fault_shear_modulus": 32.03812e9, "fault_density": 2670}
FAMILIES = [(f"{rk} {adapt}", ["-ts_type", "rk", "-ts_rk_type", rk, "-ts_adapt_type", adapt], "-ts_rtol", tolerances)
            for rk, tolerances in (("3bs", "1e-2 3e-3 1e-3 3e-4 1e-4"), ("5dp", "1e-3 3e-4 1e-4 5e-5 1e-5"))
            for adapt in ("basic", "dsp")]
FAMILIES += [(f"adams {adapt}", ["-ts_type", "adams", "-ts_adapt_type", adapt], "-ts_rtol",
              "3e-2 1e-2 3e-3 1e-3 3e-4 1e-4 1e-5") for adapt in ("basic", "dsp", "pi")]
ERRORS = [3e-3, 2e-3, 1e-3, 5e-4, 3e-4, 1e-4, 5e-5]


def bp5(cell=2):
    x, z = np.meshgrid((np.arange(100 // cell) + 0.5) * cell - 50, (np.arange(40 // cell) + 0.5) * cell)
    share = np.clip(np.maximum(abs(z - 10) - 6, abs(x) - 30) / 2, 0, 1)
    patch = (x > -30) & (x < -18) & (z > 4) & (z < 16)
    slip = np.where(patch, 0.13, 0.14)
    fields = {"friction_a": 0.004 + share * 0.036, "friction_slip": slip, "initial_rate": np.where(patch, 0.03, 1e-9),
              "initial_state": slip / 1e-9}
    return fields, {"fault_length_x": 100e3, "fault_length_z": 40e3, "fault_normal_stress": 25e6,
                    "fault_friction_b": 0.03}, 2340


def bp1(cell=200):
    z = (np.arange(40000 // cell)[:, None] + 0.5) * cell
    return ({"friction_a": np.interp(z, [15e3, 18e3], [0.010, 0.025])},
            {"fault_length_x": 1e7, "fault_length_z": 40e3, "fault_normal_stress": 50e6, "fault_friction_b": 0.015,
             "fault_friction_slip": 0.008, "fault_initial": "traction", "fault_initial_traction": 26.54612e6,
             "fault_initial_rate": 1e-9}, 1000)


def core(nx=36, nz=18, cell=1200, a=0.008, b=0.02, rim=0.03, slip=0.05, stress=40e6, years=618):
    x, z = np.meshgrid((np.arange(nx) + 0.5) / nx - 0.5, (np.arange(nz) + 0.5) / nz)
    share = np.clip(np.maximum((abs(z - 0.45) - 0.28) * nz, (abs(x) - 0.34) * nx) / 1.5, 0, 1)
    fields = {"friction_a": a + share * (rim - a),
              "friction_slip": slip * (1 + 0.15 * np.sin(9 * x + 1) * np.cos(11 * z)),
              "initial_rate": np.where((x < -0.2) & (share == 0), 1e-8, 1e-9)}
    return fields, {"fault_length_x": nx * cell, "fault_length_z": nz * cell, "fault_normal_stress": stress,
                    "fault_friction_b": b, "fault_shear_modulus": 30e9, "fault_density": 2700}, years


def strip():
    return core(64, 10, 1500, 0.003, 0.015, 0.025, 0.045, 30e6, 697)


FAULTS = {"bp5": bp5, "bp1": bp1, "core": core, "strip": strip, "bp5_1km": lambda: bp5(1), "bp1_100m": lambda: bp1(100)}


def run(program, folder, fault, options):
    """Onsets [years] of events after the start, and right-hand sides; None of a run that failed."""
    fields, numbers, years = fault
    nz, nx = fields["friction_a"].shape
    parameters, catalogue, log = (os.path.join(folder, name) for name in ("fields.h5", "events.h5", "log.txt"))
    write(parameters, **fields)
    command = [program, "-fault_nx", nx, "-fault_nz", nz, "-fault_parameters", parameters, "-ts_max_time",
               repr(years * YEAR), "-fault_catalogue", catalogue,
               "-fault_output_overwrite", "-fault_progress", "no", "-log_view", ":" + log, *options]
    for name, value in {**COMMON, **numbers}.items():
        command += ["-" + name, value]
    try:
        subprocess.run([str(word) for word in command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                       timeout=120, check=True)
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


def drawn(seed):
    """A line or a plane whose core weakens with slip rate, 2.5 to 4.5 cells of b sigma d_c/G wide, one end of which
    starts faster."""
    random = np.random.default_rng(seed)
    nx, nz = ((1, int(random.choice([32, 48, 64, 96]))) if random.random() < 0.5
              else [(16, 8), (20, 10), (12, 12), (24, 6), (32, 16), (40, 12)][random.integers(6)])
    cell, stress, b = (float(np.exp(random.uniform(*np.log(bounds))))
                       for bounds in ((200, 2500), (15e6, 60e6), (0.01, 0.03)))
    a, rim, length = b * random.uniform(0.13, 0.53), b * random.uniform(1.15, 2.15), float(
        np.exp(random.uniform(*np.log((2.5, 4.5)))))
    x, z = np.meshgrid((np.arange(nx) + 0.5) / nx - 0.5, (np.arange(nz) + 0.5) / nz)
    inner = (abs(x) < 1 / 3) & (z > 0.2) & (z < 0.75)
    first = inner & ((z > 0.6) if nx == 1 else (x < -0.2))
    return ({"friction_a": np.where(inner, a, rim), "initial_rate": np.where(first, 1e-8, 1e-9)},
            {"fault_length_x": 1e7 if nx == 1 else nx * cell, "fault_length_z": nz * cell,
             "fault_normal_stress": stress, "fault_friction_b": b,
             "fault_friction_slip": length * cell * b * stress / 32e9})


def five_events(program, folder, seed):
    """A drawn fault with its duration, and the onsets of five events; None where there are no such."""
    fields, numbers = drawn(seed)
    years = 30.0
    while (loose := run(program, folder, (fields, numbers, years),
                        ["-ts_type", "adams", "-ts_adapt_type", "pi", "-ts_rtol", "3e-3"])) and len(loose[0]) < 6:
        years *= 1.7
        if years > 2e4:
            return None
    if not loose or (gaps := np.diff(loose[0][:5])).max() > 2 * gaps.min():
        return None
    fault = fields, numbers, float(loose[0][4] + 0.3 * gaps[-1])
    reference, other = (run(program, folder, fault, ["-ts_type", *kind, "-ts_adapt_type", "basic", "-ts_rtol", "1e-4"])
                        for kind in (["adams"], ["rk", "-ts_rk_type", "5dp"]))
    good = reference and other and len(reference[0]) == 5 and error_of(other[0], reference[0]) < 2e-3
    return (fault, reference[0]) if good else None


def of_drawn(program, folder, number, seed, options):
    found = {"lines": [], "planes": []}
    while min(len(rows) for rows in found.values()) < number:
        case, seed = five_events(program, folder, seed), seed + 1
        kind = "lines" if case and case[0][0]["friction_a"].shape[1] == 1 else "planes"
        if case and len(found[kind]) < number:
            result = run(program, folder, case[0], options)
            found[kind].append((result[1] / 5, error_of(result[0], case[1])) if result else (np.nan, np.inf))
    for kind, rows in found.items():
        products, errors = np.array(rows).T
        print(f"{kind:6s} products {np.exp(np.nanmean(np.log(products))):7.0f}  error median {np.median(errors):.1e}  "
              f"95 % {np.quantile(errors, 0.95):.1e}  "
              f"within 1e-2 {np.mean(errors < 1e-2):.2f}  3e-3 {np.mean(errors < 3e-3):.2f}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--faults", default="bp5,bp1,core,strip", help="which of them (default: %(default)s)")
    parser.add_argument("--program", default=os.path.join(ROOT, "build", "bin", "fault"), help="default: %(default)s")
    parser.add_argument("--drawn", type=int, default=0, help="so many lines and planes, in place of these")
    parser.add_argument("--seed", type=int, default=1000, help="of the first of them (default: %(default)s)")
    parser.add_argument("--options", default="", help="of their runs (default: none, the default)")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        if args.drawn:
            of_drawn(args.program, folder, args.drawn, args.seed, args.options.split())
            return
        for name in args.faults.split(","):
            fault = FAULTS[name]()
            reference = run(args.program, folder, fault,
                            ["-ts_type", "adams", "-ts_adapt_type", "basic", "-ts_rtol", "1e-7"])[0]
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
                ours = best["adams pi"]  # the default's
                print(f"{name:6s} error <= {bound:.0e}: pairs {pairs:7.0f}  adams {adams:7.0f}  pi {ours:7.0f}  "
                      f"pairs/pi {pairs / ours:.2f}  best/pi {min(pairs, adams) / ours:.2f}", flush=True)


if __name__ == "__main__":
    main()
