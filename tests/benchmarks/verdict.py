#!/usr/bin/env python3
"""Is a run right about its own error? The estimate of the slip error and "likely met", on random faults.

    tests/benchmarks/verdict.py                        # 300 fresh faults: how often "likely met" is said, and right
    tests/benchmarks/verdict.py --calibrate            # factors for the table in src/fault/slipestimate.c, other faults
    tests/benchmarks/verdict.py --prove 20             # the reference against finer runs and -fault_check_error first

Faults: verdict_cases.py, drawn by a seed; the calibration and the test have different ones. The truth is a run by
heuristic at rtol 1e-6. On all 400 faults of the calibration one at 1e-7 differed by at most 3e-5 of the slip, 3 % of the
smallest accuracy that is judged. A fault that does not come to rest within 400 T* is drawn again, as the program says
"unknown" of it by rule. Results are kept in FOLDER/faults_SEED.jsonl, a line a fault: an
interrupted test goes on where it was. 300 faults take ten minutes of one core. Needs numpy and h5py.
"""

import argparse
import concurrent.futures
import json
import os
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path[:0] = [os.path.join(ROOT, "output"), os.path.join(ROOT, "examples")]
from slipstep_modules import need

need("h5py", "numpy")
import h5py
import numpy as np

sys.dont_write_bytecode = True
import verdict_cases
from held_out_run import BenchmarkError, Job, execute

CALIBRATION_SEEDS, TEST_SEEDS = [201, 202], [20261123]
DIALS = [1e-1, 1e-2, 1e-3]
MORE_DIALS = [3e-2, 3e-3, 3e-4]  # of the calibration
TOLERANCES = [1e-1, 1e-3]  # of heuristic, in the calibration
FINE, FINER = "1e-6", "1e-7"  # rtol of references
AGREE = 3e-5  # of their slips
STEPS = [3, 4, 5, 8, 12, 20, 32, 64, 128, np.inf]  # classes of accepted steps
QUANTILE = 0.9  # of runs that stay below the estimate


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.path.join(ROOT, "build"))
    parser.add_argument("--folder", default=os.path.join(ROOT, "output", "verdict"), help="of results")
    parser.add_argument("--faults", type=int, default=300, help="of each seed")
    parser.add_argument("--seeds", type=int, nargs="+", help=f"of the faults (default {TEST_SEEDS}, with --calibrate {CALIBRATION_SEEDS})")
    parser.add_argument("--calibrate", action="store_true", help="print the table of factors")
    parser.add_argument("--prove", type=int, default=0, metavar="N", help="of the first N faults a finer reference too, and -fault_check_error against it")
    parser.add_argument("--processes", type=int, default=2)
    return parser.parse_args()


def one(args, folder, case, options):
    """(result, series) of a run; a machine under load sometimes cannot start MPI, so a failure is tried again."""
    for _ in range(2):
        (_, found, message), = execute(args.build, [Job(case, "fine", "", 0, options)], folder)
        if found:
            return found
    raise BenchmarkError(f"{case.name}: {message}")


def reference(args, folder, seed, k):
    """A fault that comes to rest, with its duration, its final mean slip, and by how much a finer run differs, 0 when
    there was none."""
    prove = args.calibrate or k < args.prove
    for again in range(50):
        random = np.random.default_rng([seed, k, again])
        case, margin = verdict_cases.draw(random, verdict_cases.KINDS[k % len(verdict_cases.KINDS)], f"fault_{seed}_{k}", folder)
        fine = ["-ts_adapt_type", "heuristic", "-ts_rtol"]
        _, (time, slip, rate) = one(args, folder, case, [*fine, FINER if prove else FINE])
        if rate[-1] != 0:
            continue
        case.duration = verdict_cases.rounded(margin * time[len(time) - np.argmax(rate[::-1] != 0)])
        if not prove:
            return case, slip[-1], 0
        spread = abs(one(args, folder, case, [*fine, FINE])[1][1][-1] / slip[-1] - 1)
        if spread > AGREE:
            raise BenchmarkError(f"{case.name} has no reference: rtol {FINE} and {FINER} differ by {spread:.1e}, expected < {AGREE:g}")
        return case, slip[-1], float(spread)
    raise BenchmarkError(f"fault {k} of seed {seed}: none of 50 came to rest")


def learned(dial):
    return ["-ts_adapt_type", "rl", "-ts_adapt_rl_accuracy", f"{dial:g}"]


def fault(args, seed, k):
    """All runs of a fault."""
    with tempfile.TemporaryDirectory(dir=args.folder) as folder:
        case, slip, spread = reference(args, folder, seed, k)
        check = ["-fault_check_error"] if k < args.prove else []
        jobs = [Job(case, "policy", "rl", dial, [*learned(dial), *check]) for dial in DIALS + (MORE_DIALS if args.calibrate else [])]
        if args.calibrate:
            jobs += [Job(case, "classical", "heuristic", rtol, ["-ts_adapt_type", "heuristic", "-ts_rtol", f"{rtol:g}"]) for rtol in TOLERANCES]
        runs = []
        done = list(execute(args.build, jobs, folder))
        if not all(found for _, found, _ in done):
            done = list(execute(args.build, jobs, folder))
        for job, found, message in done:
            row = {"family": job.family, "setting": job.setting, "failed": message}
            if found:
                result, series = found
                row.update({name: value for name, value in result.items() if name.startswith(("slip_error", "policy_handover"))})
                row.update(steps=int(result["accepted"]), solves=int(result["solves"]), error=float(series[1][-1] / slip - 1))
            runs.append(row)
        with h5py.File(case.fields) as file:
            cells = int(file["normal_stress"].size)
        return {"k": k, "group": case.group, "cells": cells, "spread": spread, "runs": runs}


def all_faults(args, seed):
    path = os.path.join(args.folder, f"faults_{seed}{'_calibration' if args.calibrate else ''}.jsonl")
    rows = {}
    if os.path.exists(path):
        with open(path) as file:
            rows = {row["k"]: row for row in map(json.loads, file)}
    todo = [k for k in range(args.faults) if k not in rows]
    print(f"{args.faults} faults of seed {seed}, {args.faults - len(todo)} there already", flush=True)
    with open(path, "a") as file, concurrent.futures.ThreadPoolExecutor(args.processes) as pool:
        for done in concurrent.futures.as_completed([pool.submit(fault, args, seed, k) for k in todo]):
            row = done.result()
            rows[row["k"]] = row
            file.write(json.dumps(row) + "\n")
            file.flush()
            if len(rows) % 20 == 0:
                print(f"  {len(rows)} of {args.faults}", flush=True)
    return [rows[k] for k in range(args.faults)]


def table_of_factors(faults):
    """Quantiles of error over measure by steps, and how often the estimate would be too small."""
    runs = [run for row in faults for run in row["runs"] if "slip_error_measure" in run]
    steps = np.array([run["steps"] for run in runs])
    ratio = np.array([abs(run["error"]) / run["slip_error_measure"] for run in runs])
    print(f"{len(runs)} runs with an estimate; error over measure\n steps at most   runs    median  factor ({QUANTILE:.0%})   95 %")
    for low, high in zip([0, *STEPS], STEPS):
        inside = (steps > low) & (steps <= high)
        if inside.any():
            print(f"{high:13g} {inside.sum():7d} {np.quantile(ratio[inside], .5):9.2f} {np.quantile(ratio[inside], QUANTILE):12.2f} "
                  f"{np.quantile(ratio[inside], .95):10.2f}")


def verdicts(faults, dials):
    """How often "likely met" is said, and how often it is right."""
    print("accuracy   runs  kept  |  likely met    right  wrong  |  unknown (of these missed)  |  handed over  steps  error < estimate")
    groups = (("all", lambda row: True), ("grids", lambda row: row["k"] % 2 == 0), ("meshes", lambda row: row["k"] % 2 == 1),
              ("as in training", lambda row: "wide" not in row["group"]), ("wide", lambda row: "wide" in row["group"]))
    for dial in dials:
        for name, chosen in groups:
            runs = [run for row in faults if chosen(row) for run in row["runs"] if run["family"] == "rl" and run["setting"] == dial]
            failed = [run for run in runs if run["failed"]]
            runs = [run for run in runs if not run["failed"]]
            kept = np.array([abs(run["error"]) <= dial for run in runs])
            said = np.array([run["slip_error_estimate_met"] == 1 for run in runs])
            below = np.mean([abs(run["error"]) <= run["slip_error_estimate"] for run in runs if "slip_error_estimate" in run])
            handed = np.mean(["policy_handover_time" in run for run in runs])
            print(f"{dial:8g} {len(runs):6d} {kept.mean():5.0%}  | {said.sum():5d} {said.mean():5.0%} {kept[said].mean():8.1%} {(said & ~kept).sum():6d}"
                  f"  | {(~said).sum():6d} {(~said & ~kept).sum():12d}         | {handed:8.0%} {np.median([run['steps'] for run in runs]):9.0f}"
                  f" {below:12.0%}   {name}{', %d failed' % len(failed) if failed else ''}")


def proof(faults):
    """-fault_check_error against the reference: ratios of errors, and its verdicts."""
    runs = [(run, abs(run["slip_error_check_signed"]), abs(run["error"])) for row in faults for run in row["runs"] if "slip_error_check_signed" in run]
    if not runs:
        return
    ratio = np.array([check / max(error, 1e-6) for _, check, error in runs])
    right = np.mean([(error <= run["setting"]) == (run["slip_error_check_met"] == 1) for run, _, error in runs])
    print(f"-fault_check_error on {len(runs)} runs, its error over the reference's: quantiles 5, 25, 50, 75, 95 %: "
          + ", ".join(f"{q:.2f}" for q in np.quantile(ratio, [.05, .25, .5, .75, .95])) + f"; its met / not met is right in {right:.1%}")


def main():
    args = arguments()
    os.makedirs(args.folder, exist_ok=True)
    seeds = args.seeds or (CALIBRATION_SEEDS if args.calibrate else TEST_SEEDS)
    faults = [row for seed in seeds for row in all_faults(args, seed)]
    print(f"references: runs at rtol {FINE} and {FINER} differ by at most {max(row['spread'] for row in faults):.1e} "
          f"on {sum(row['spread'] > 0 for row in faults)} faults; "
          f"{min(row['cells'] for row in faults)} to {max(row['cells'] for row in faults)} cells")
    proof(faults)
    if args.calibrate:
        table_of_factors(faults)
    verdicts(faults, DIALS + (MORE_DIALS if args.calibrate else []))


if __name__ == "__main__":
    try:
        main()
    except BenchmarkError as error:
        sys.exit(f"error: {error}")
