#!/usr/bin/env python3
"""Is a run right about its own error? The estimates of -ts_adapt_rl_measure and "likely met", on random faults.

    tests/benchmarks/verdict.py                        # 300 fresh faults: how often "likely met" is said, and right
    tests/benchmarks/verdict.py --calibrate            # prints the factors of estimates, by other faults
    tests/benchmarks/verdict.py --calibrate --output estimates.h5   # and writes them for -fault_estimates
    tests/benchmarks/verdict.py --prove 20             # the reference against finer runs and -fault_check_error first
    tests/benchmarks/verdict.py --measure final_slip   # another measure than history, of its default policy
    tests/benchmarks/verdict.py --method auto          # explicit or implicit steps; with --calibrate, the factors of
                                                       # explicit ones
    tests/benchmarks/verdict.py --more 60              # besides, 60 whose slip is a vector, that dip, of two planes, or
                                                       # that open
    tests/benchmarks/verdict.py --policy F.h5          # another policy than the default one of the measure

Every run is judged for all measures, and the table of a calibration has a column for each. Errors are those of
src/core/course.c. Faults: verdict_cases.py, drawn by a seed; the calibration and the test have different ones. The
truth is a run of constant steps, which one of steps twice as long has to confirm in a calibration: of second order, so
to a third of their difference, 3e-5 of the final slip and 5e-4 of the other errors. (No run by tolerances: where the
start is hardly perturbed, absolute tolerances rule, and heuristic at rtol 1e-7 had an event 2e-3 of its rise time away
from one at 1e-6.) A fault that does not come to rest within 400 T* is drawn again, as the program says "unknown" of it
by rule. Results are kept in FOLDER/faults_SEED.jsonl, a line a fault: an interrupted test goes on where it was. Needs
numpy and h5py.
"""

import argparse
import concurrent.futures
import json
import os
import subprocess
import sys
import tempfile
import time

from common import ROOT
import h5py
import numpy as np

from slipstep.results import course
import verdict_cases
import held_out_run
from held_out_run import BenchmarkError, Job, execute, read_course

SHIPPED = os.path.join(ROOT, "training", "policies", "estimates.h5")
CALIBRATION_SEEDS, TEST_SEEDS = [201, 202], [20261123]
DIALS = {"implicit": [1e-1, 1e-2, 1e-3], "auto": [1e-1, 3e-2, 1e-2, 3e-3]}
MORE_DIALS = {"implicit": [3e-2, 3e-3, 3e-4], "auto": [6e-2, 1.8e-2, 6e-3, 1.8e-3, 1e-3]}  # of the calibration
TOLERANCES = [1, 1e-1, 1e-2, 1e-3]  # of heuristic, in the calibration
FINE_STEPS = 4000  # of references
FIRST = "1e-5"  # rtol of the run that says when a fault rests
AGREE, AGREE_HISTORY = 3e-5, 5e-4  # of references' final slips, and of all errors
# classes of accepted steps
STEPS = {"implicit": [3, 4, 5, 8, 12, 20, 32, 64, 128, np.inf], "auto": [16, 32, 64, np.inf]}
EXPLICIT = 0.5  # share of explicit steps from which on a run has their factors
QUANTILE = 0.9  # of runs that stay below the estimate
ATTRIBUTES = {"history": "history", "final_slip": "slip", "event_time": "event_time"}  # of measures


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.path.join(ROOT, "build"))
    parser.add_argument("--folder", default=os.path.join(ROOT, "output", "verdict"), help="of results")
    parser.add_argument("--faults", type=int, default=300, help="of each seed")
    parser.add_argument("--seeds", type=int, nargs="+",
                        help=f"of the faults (default {TEST_SEEDS}, with --calibrate {CALIBRATION_SEEDS})")
    parser.add_argument("--calibrate", action="store_true", help="print the table of factors")
    parser.add_argument("--output", metavar="F.h5",
                        help="file for the factors of --calibrate, which -fault_estimates reads")
    parser.add_argument("--prove", type=int, default=0, metavar="N", help="compare the references of the first N "
                        "faults with finer ones, and " "-fault_check_error with those")
    parser.add_argument("--measure", default="history", choices=ATTRIBUTES,
                        help="of the default policy, and of the verdicts")
    parser.add_argument("--method", default="implicit", choices=DIALS, help="of the runs: -ts_bathe_method")
    parser.add_argument("--more", type=int, default=0, metavar="N",
                        help="and as many of each seed whose slip is a vector, that dip, of two planes, or open")
    parser.add_argument("--policy", help="another one (default: the library's for the measure)")
    parser.add_argument("--processes", type=int, default=1)
    args = parser.parse_args()
    args.dials = DIALS[args.method] + (MORE_DIALS[args.method] if args.calibrate else [])
    if args.output and not args.calibrate:
        parser.error("--output has the factors of --calibrate, which is not there")
    return args


def errors(run, fine):
    """The parts of a run's error against a fine one, both of held_out_run.read_course()."""
    found = course.errors(run[1], fine[1])
    return {name: found[name] for name in course.PARTS}


def measured(run, measure):
    """The error of a run that a measure means."""
    return course.MEASURES[measure](run["errors"])


def one(args, folder, case, options):
    """What read_course() says of a run; a machine under load sometimes cannot start MPI, so a failure is tried
    again."""
    for _ in range(2):
        (_, found, message), = execute(args.build, [Job(case, "fine", "", 0, options)], folder, read_course)
        if found:
            return found
    raise BenchmarkError(f"{case.name}: {message}")


def constant(args, folder, case, steps):
    return one(args, folder, case, ["-ts_adapt_type", "none", "-ts_bathe_error", "none", "-ts_dt",
                                    f"{case.duration / steps:.10g}", "-ts_max_steps", f"{2 * steps}",
                                    "-ts_bathe_method", args.method])


def reference(args, folder, seed, k, kinds=verdict_cases.KINDS):
    """A fault that comes to rest, with its duration, its fine run, and how well its history is known, 0
    when that was not looked at."""
    prove = args.calibrate or k < args.prove
    for again in range(50):
        random = np.random.default_rng([seed, k, again])
        case, margin = verdict_cases.draw(random, kinds[k % len(kinds)], f"fault_{seed}_{k}", folder)
        rest = one(args, folder, case,
                   ["-ts_adapt_type", "heuristic", "-ts_rtol", FIRST, "-ts_bathe_method", args.method])[0]["rest"]
        if np.isnan(rest):
            continue
        case.duration = verdict_cases.rounded(margin * rest)
        found = constant(args, folder, case, FINE_STEPS)
        if not prove:
            return case, found, 0
        spread = {name: error / 3 for name, error in errors(constant(args, folder, case, FINE_STEPS // 2),
                                                            found).items()}
        history = measured({"errors": spread}, "history")
        if spread["final"] > AGREE or history > AGREE_HISTORY:
            print(f"  {case.name}: its reference is known to {spread['final']:.1e} of the slip and {history:.1e} in "
                  f"all, expected {AGREE:g} and {AGREE_HISTORY:g}: drawn again", flush=True)
            continue
        return case, found, float(history)
    raise BenchmarkError(f"fault {k} of seed {seed}: none of 50 came to rest")


def learned(args, dial):
    """A policy that is named has its own measure."""
    policy = (["-ts_adapt_rl_policy", os.path.abspath(args.policy)] if args.policy
              else ["-ts_adapt_rl_measure", args.measure])
    return ["-ts_adapt_type", "rl", "-ts_adapt_rl_accuracy", f"{dial:g}", "-ts_bathe_method", args.method, *policy]


def fault(args, seed, k, kinds):
    """All runs of a fault."""
    with tempfile.TemporaryDirectory(dir=args.folder) as folder:
        case, fine, spread = reference(args, folder, seed, k, kinds)
        check = ["-fault_check_error"] if k < args.prove else []
        jobs = [Job(case, "policy", "rl", dial, [*learned(args, dial), *check]) for dial in args.dials]
        if args.calibrate:
            jobs += [Job(case, "classical", "heuristic", rtol, ["-ts_adapt_type", "heuristic", "-ts_rtol", f"{rtol:g}",
                                                                "-ts_bathe_method", args.method])
                     for rtol in TOLERANCES]
        runs = []
        done = list(execute(args.build, jobs, folder, read_course))
        if not all(found for _, found, _ in done):
            done = list(execute(args.build, jobs, folder, read_course))
        for job, found, message in done:
            row = {"family": job.family, "setting": job.setting, "failed": message}
            if found:
                result = found[0]
                row.update({name: value for name, value in result.items() if "error_" in name
                            or name.startswith(("policy_handover", "products_")) or name == "cost"})
                row.update(steps=int(result["accepted"]), explicit=result["explicit"], solves=int(result["solves"]),
                           errors={name: float(e) for name, e in errors(found, fine).items()})
            runs.append(row)
        with h5py.File(case.fields) as file:
            cells = int(file["normal_stress"].size)
        return {"k": k, "group": case.group, "cells": cells, "spread": spread, "runs": runs}


def all_faults(args, seed, kinds, n):
    policy = held_out_run.digest(args.policy) if args.policy else args.measure
    which = "".join(f"_{word}" for word, on in ((args.method, args.method != "implicit"),
                                                ("more", kinds is verdict_cases.MORE_KINDS),
                                                ("calibration", args.calibrate)) if on)
    path = os.path.join(args.folder, f"faults_{seed}_{policy}{which}.jsonl")
    rows = {}
    if os.path.exists(path):
        with open(path) as file:
            rows = {row["k"]: row for row in map(json.loads, file)}
    todo = [k for k in range(n) if k not in rows]
    print(f"{n} faults of seed {seed}, {n - len(todo)} there already", flush=True)
    with open(path, "a") as file, concurrent.futures.ThreadPoolExecutor(args.processes) as pool:
        for done in concurrent.futures.as_completed([pool.submit(fault, args, seed, k, kinds) for k in todo]):
            row = done.result()
            rows[row["k"]] = row
            file.write(json.dumps(row) + "\n")
            file.flush()
            if len(rows) % 20 == 0:
                print(f"  {len(rows)} of {n}", flush=True)
    return [rows[k] for k in range(n)]


def table_of_factors(faults, method):
    """Quantiles of error over measure by steps, of runs whose steps are of the method for the most part, printed, and
    returned: {steps at most: [factor of each of ATTRIBUTES]}."""
    runs = [run for row in faults for run in row["runs"] if "slip_error_measure" in run
            and (run["explicit"] >= EXPLICIT) == (method == "auto")]
    steps = np.array([run["steps"] for run in runs])
    factors = {}
    for measure, name in ATTRIBUTES.items():
        ratio = np.array([measured(run, measure) / run[f"{name}_error_measure"] for run in runs])
        print(f"{measure}: {len(runs)} runs with an estimate; error over measure\n steps at most   runs    median  "
              f"factor ({QUANTILE:.0%})   95 %")
        for low, high in zip([0, *STEPS[method]], STEPS[method]):
            inside = (steps > low) & (steps <= high)
            if inside.any():
                factors.setdefault(high, []).append(np.quantile(ratio[inside], QUANTILE))
                print(f"{high:13g} {inside.sum():7d} {np.quantile(ratio[inside], .5):9.2f} {factors[high][-1]:12.2f} "
                      f"{np.quantile(ratio[inside], .95):10.2f}")
    return factors


def write_factors(path, factors, faults, args, seeds, version):
    """The file of -fault_estimates (training/policies/README.md). Factors of the other method, and what measures are
    made of, the attributes of /factor, are those of the library's, by which the runs were, of this version; longer runs
    than there were have the last class."""
    with h5py.File(SHIPPED) as shipped, h5py.File(f"{path}.part", "w") as file:
        for name in shipped:
            shipped.copy(name, file)
        file.attrs.update(shipped.attrs)
        group, attributes = ((file, dict(file["factor"].attrs)) if args.method == "implicit"
                             else (file.require_group("explicit"), {}))
        for name, data in (("steps", np.array([*list(factors)[:-1], np.inf], float)),
                           ("factor",
                            np.array([[float(f"{factor:.2g}") for factor in row] for row in factors.values()]))):
            if name in group:
                del group[name]
            group[name] = data
        group["factor"].attrs.update(attributes)
        texts = {"command": " ".join(sys.argv), "library_version": version,
                 "family": f"verdict_cases.py, seeds {seeds}",
                 "created": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())}
        group.attrs.update({name: np.bytes_(text) for name, text in texts.items()}, episodes=len(faults),
                           quantile=QUANTILE)
    os.replace(f"{path}.part", path)


def verdicts(faults, dials, measure):
    """How often "likely met" is said, and how often it is right."""
    print(f"by {measure}:\naccuracy   runs  kept  |  likely met    right  wrong  |  unknown (of these missed)  |  "
          "handed over  steps  error < estimate")
    kinds = sorted({row["group"].split(",")[0] for row in faults})
    groups = [("all", lambda row: True),
              *((kind, lambda row, kind=kind: row["group"].startswith(kind)) for kind in kinds),
              ("as in training", lambda row: "wide" not in row["group"]), ("wide", lambda row: "wide" in row["group"])]
    estimate = f"{ATTRIBUTES[measure]}_error_estimate"
    for dial in dials:
        for name, chosen in groups:
            runs = [run for row in faults if chosen(row) for run in row["runs"] if run["family"] == "rl"
                    and run["setting"] == dial]
            failed = [run for run in runs if run["failed"]]
            runs = [run for run in runs if not run["failed"]]
            if not runs:
                continue
            kept = np.array([measured(run, measure) <= dial for run in runs])
            # the verdict itself is of the policy's measure
            said = np.array([run.get(estimate, np.inf) <= dial for run in runs])
            below = np.mean([measured(run, measure) <= run[estimate] for run in runs if estimate in run] or [np.nan])
            handed = np.mean(["policy_handover_time" in run for run in runs])
            print(f"{dial:8g} {len(runs):6d} {kept.mean():5.0%}  | {said.sum():5d} {said.mean():5.0%} "
                  f"{kept[said].mean() if said.any() else np.nan:8.1%} {(said & ~kept).sum():6d}"
                  f"  | {(~said).sum():6d} {(~said & ~kept).sum():12d}         | {handed:8.0%} "
                  f"{np.median([run['steps'] for run in runs]):9.0f}"
                  f" {below:12.0%}   {name}{', %d failed' % len(failed) if failed else ''}")


def proof(faults, measure):
    """-fault_check_error against the reference: ratios of errors, and its verdicts."""
    name = f"{ATTRIBUTES[measure]}_error_check"
    runs = [(run, run[name], measured(run, measure)) for row in faults for run in row["runs"] if name in run]
    if not runs:
        return
    ratio = np.array([check / max(error, 1e-6) for _, check, error in runs])
    right = np.mean([(error <= run["setting"]) == (check <= run["setting"]) for run, check, error in runs])
    print(f"-fault_check_error on {len(runs)} runs, its error ({measure}) over the reference's: quantiles 5, 25, 50, "
          "75, 95 %: " + ", ".join(f"{q:.2f}" for q in np.quantile(ratio, [.05, .25, .5, .75, .95]))
          + f"; its met / not met is right in {right:.1%}")


def main():
    args = arguments()
    os.makedirs(args.folder, exist_ok=True)
    seeds = args.seeds or (CALIBRATION_SEEDS if args.calibrate else TEST_SEEDS)
    which = [(verdict_cases.KINDS, args.faults), (verdict_cases.MORE_KINDS, args.more)]
    faults = [row for seed in seeds for kinds, n in which for row in all_faults(args, seed, kinds, n)]
    print(f"references: {FINE_STEPS} constant steps, known to {max(row['spread'] for row in faults):.1e} "
          f"on {sum(row['spread'] > 0 for row in faults)} faults; "
          f"{min(row['cells'] for row in faults)} to {max(row['cells'] for row in faults)} cells")
    proof(faults, args.measure)
    if args.calibrate:
        factors = table_of_factors(faults, args.method)
        if args.output:
            said = subprocess.run([os.path.join(args.build, "bin", "fault"), "-version"], capture_output=True,
                                  text=True, check=True).stdout
            write_factors(args.output, factors, faults, args, seeds, said.splitlines()[0].split()[-1])
    verdicts(faults, args.dials, args.measure)


if __name__ == "__main__":
    try:
        main()
    except BenchmarkError as error:
        sys.exit(f"error: {error}")
