#!/usr/bin/env python3
"""Two trainings that differ by their seed only: how many solves each needs at equal error, on the held-out faults.

    tests/benchmarks/held_out_seeds.py training/policies/fault.h5 seed1.h5 --folder output/held_out

Either policy runs all cases at many positions of its dial. For a group of cases that gives a curve: geometric mean of
the solves against the error that 95 % of the cases keep (and against the median error), one point a position. Solves at
an error lie between points by a straight line between logarithms; the comparison is the ratio of both policies' solves
there. Runs and references are those of held_out.py: a folder of it is reused and added to.
"""

import argparse
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "src", "package"))
from slipstep.modules import need

need("h5py", "numpy", "matplotlib")
import numpy as np

sys.dont_write_bytecode = True
from slipstep.results import course
import held_out_cases
from held_out import ROOT, chosen_cases, learned
from held_out_run import Bench, BenchmarkError
from held_out_score import by, error, solves_at

DIALS = [2e-1, 1e-1, 5e-2, 2e-2, 1e-2, 5e-3, 2e-3, 1e-3]
ERRORS = [5e-2, 2e-2, 1e-2, 3e-3]
QUANTITIES = {"95 % within": lambda e: np.quantile(e, 0.95), "median": np.median}


def curve(rows, measure, quantity):
    """Points of one policy on one group of cases: (solves, error), one a position of the dial."""
    points = [(np.exp(np.mean([np.log(r["solves"]) for r in runs])), quantity([error(r, measure) for r in runs]))
              for runs in by(rows, "setting").values()]
    return np.array(points).T


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("policies", nargs=2)
    parser.add_argument("--build", default=os.path.join(ROOT, "build"))
    parser.add_argument("--folder", default=os.path.join(ROOT, "output", "held_out"))
    parser.add_argument("--measure", choices=course.MEASURES, default="history")
    parser.add_argument("--seed", type=int, default=held_out_cases.SEED, help="seed of the drawn faults")
    parser.add_argument("--cases", nargs="+", default=list(held_out_cases.KINDS),
                        help="only cases whose name begins with one of these")
    parser.add_argument("--jobs", type=int, default=2, help="processes at once")
    o = parser.parse_args()
    folder = os.path.abspath(o.folder)
    os.makedirs(folder, exist_ok=True)
    bench = Bench(os.path.abspath(o.build), folder, o.jobs)
    cases = chosen_cases(bench, o.seed, o.cases)
    bench.references(cases)
    runs = [learned(bench, cases, os.path.abspath(p), os.path.basename(p), DIALS) for p in o.policies]
    for failed in [r for rows in runs for r in rows if r["failed"]]:
        raise BenchmarkError(f"{failed['case']} failed at {failed['setting']:g}: {failed['failed']}")
    print(f"\n{'cases':<16}{'quantity':<14}{'error':>8}{'first':>8}{'second':>8}   second over first")
    groups = [by(rows, "group") for rows in runs]
    for group in groups[0]:
        for name, quantity in QUANTITIES.items():
            curves = [curve(g[group], o.measure, quantity) for g in groups]
            for wanted in ERRORS:
                first, second = (solves_at(*c, wanted) for c in curves)
                print(f"{group:<16}{name:<14}{wanted:>8g}{first:>8.1f}{second:>8.1f}   {second / first:.2f}")


if __name__ == "__main__":
    try:
        main()
    except BenchmarkError as failure:
        sys.exit(f"held_out_seeds.py: {failure}")
