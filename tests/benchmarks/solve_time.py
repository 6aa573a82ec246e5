#!/usr/bin/env python3
"""Wall time of the solve of the 3 km fault under `heuristic` and under the shipped policy, beside a plain reference.

    tests/benchmarks/solve_time.py [--build build] [--ranks 1 2] [--repeat 5] [--sizes 25 50]
                                   [--output output/solve_time.h5]

The plain reference is the same program, steps and tolerances with dense matrices and no preconditioner, on one rank.
Times are medians over the repetitions with their spread (largest over smallest); on a shared machine only the ratio
means much.
"""

import argparse
import os
import re
import statistics
import subprocess
import sys

from common import ROOT
import h5py

PLAIN = ["-fault_operator", "dense", "-pc_type", "none"]
NUMBERS = {"accepted": r"accepted steps: *(\d+)", "rejected": r"rejected steps: *(\d+)",
           "solves": r"Bathe solves: *(\d+)", "mean_slip": r"final mean slip: *([-+.\de]+)",
           "setup": r"wall time of set-up: *([.\d]+)", "solve": r"wall time of the solve: *([.\d]+)"}
UNITS = {"mean_slip": "m", "setup": "s", "solve": "s", "plain": "s"}
COLUMNS = ("size", "controller", "ranks", "solves", "mean_slip", "setup", "solve", "spread", "plain")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--build", default=os.path.join(ROOT, "build"))
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--sizes", type=int, nargs="+", default=[25, 50], help="cells along strike and in depth")
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--output", help="HDF5 file for the table")
    return parser.parse_args()


def environment():
    env = dict(os.environ, OPENBLAS_NUM_THREADS="1")
    if os.geteuid() == 0:
        env.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    return env


def run(build, ranks, size, options):
    """The numbers of one run's summary."""
    command = ["mpirun", "--oversubscribe", "-n", str(ranks), os.path.join(build, "bin", "fault"),
               "-fault_nx", str(size), "-fault_nz", str(size), "-fault_stiffness_scaling", "mean_slip", *options]
    done = subprocess.run(command, env=environment(), capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"solve_time.py: {' '.join(command)} failed:\n{done.stderr}")
    return {name: float(re.search(pattern, done.stdout).group(1)) for name, pattern in NUMBERS.items()}


def measure(build, ranks, size, options, repeat):
    runs = [run(build, ranks, size, options) for _ in range(repeat)]
    times = sorted(r["solve"] for r in runs)
    return {**runs[0], "solve": statistics.median(times), "spread": times[-1] / times[0]}


def main():
    o = arguments()
    policy = os.path.join(ROOT, "training", "policies", "fault.h5")
    controllers = {"heuristic": ["-ts_adapt_type", "heuristic", "-ts_rtol", "1e-3"],
                   "rl": ["-ts_adapt_type", "rl", "-ts_adapt_rl_policy", policy]}
    rows = []
    print("cells  controller  ranks  solves  set-up (s)  solve (s)  spread  plain (s)  plain/ours")
    for size in o.sizes:
        for name, options in controllers.items():
            plain = measure(o.build, 1, size, options + PLAIN, 1)["solve"]
            for ranks in o.ranks:
                r = measure(o.build, ranks, size, options, o.repeat)
                rows.append((size, name, ranks, r["solves"], r["mean_slip"], r["setup"], r["solve"], r["spread"],
                             plain))
                print(f"{size:>3} x {size:<3} {name:>10} {ranks:>6} {r['solves']:>7.0f} {r['setup']:>11.2f}"
                      f" {r['solve']:>10.3f} {r['spread']:>7.1f} {plain:>10.2f} {plain / r['solve']:>11.1f}",
                      flush=True)
    if o.output:
        with h5py.File(o.output, "w") as file:
            for name, column in zip(COLUMNS, zip(*rows)):
                file[name] = column
                file[name].attrs["units"] = UNITS.get(name, "")


if __name__ == "__main__":
    main()
