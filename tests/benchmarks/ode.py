#!/usr/bin/env python3
"""Compare step-size controllers at equal error on twenty equations that the general policy was not trained on.

  ode.py [--controllers basic,dsp:PI42,rl,...] [--output RUNS.txt]     run tests/benchmarks/ode.c (build/tests/odebench)
  ode.py --read RUNS.txt [MORE.txt ...]                               compare runs that are there

For every method of every problem a controller runs at seven tolerances. Its work is interpolated between the logarithms
of its errors, as is that of basic, and compared at nine errors that both reach. Ratios of work are averaged
geometrically over methods, then over problems. A method in which a controller does not get to the end drops out of its
average, so the last columns compare pairs of controllers, where both do."""
import argparse
import collections
import math
import os
import statistics
import subprocess
import sys

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
BUILD = os.environ.get("SLIPSTEP_BUILD", os.path.join(SOURCE, "build"))
FILTERS = ("basic", "PI42", "PI33", "PC11", "H211PI", "H211b", "H312PID")
CONTROLLERS = ["basic", "basic:4", *(f"dsp:{name}" for name in FILTERS), "pi", "heuristic", "rl"]
BASE = "basic"

Run = collections.namedtuple("Run", "tolerance work error steps rejected end")


def read(files):
    """runs[problem][method][controller]: list of Run; the first file's of a controller count."""
    runs, done = {}, {}
    for file in files:
        for line in file:
            problem, method, controller, tolerance, work, error, steps, rejected, end = line.split()
            key = problem, method, controller
            if done.setdefault(key, id(file)) != id(file):
                continue
            row = Run(float(tolerance), float(work), float(error), int(steps), int(rejected), end)
            runs.setdefault(problem, {}).setdefault(method, {}).setdefault(controller, []).append(row)
    return runs


def curve(rows):
    """Logarithms of error and work of the runs that ended, by error"""
    return sorted((math.log(r.error), math.log(r.work)) for r in rows if r.end == "end" and r.error > 0)


def interpolate(x, points):
    """Linearly between points (x, y), x within them"""
    for (x0, y0), (x1, y1) in zip(points, points[1:]):
        if x <= x1 and x1 > x0:
            return y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    return points[-1][1]


def log_ratio(rows, base):
    """Mean logarithm of the work over that of base at equal error; None without an error that both reach"""
    a, b = curve(rows), curve(base)
    if not a or not b:
        return None
    low, high = max(a[0][0], b[0][0]), min(a[-1][0], b[-1][0])
    if not low < high:
        return None
    at = [low + (high - low) * k / 8 for k in range(9)]
    return statistics.fmean(interpolate(x, a) - interpolate(x, b) for x in at)


def compare(runs, controller, base=BASE):
    """By problem: mean logarithm over its methods"""
    found = {}
    for problem, methods in runs.items():
        logs = [log_ratio(m[controller], m[base]) for m in methods.values() if controller in m and base in m]
        logs = [x for x in logs if x is not None]
        if logs:
            found[problem] = statistics.fmean(logs)
    return found


def failures(runs, controller):
    """Runs that did not end, and those among them where basic's did"""
    own, worse = [], []
    for problem, methods in runs.items():
        for method, by in methods.items():
            fine = {r.tolerance for r in by[BASE] if r.end == "end"}
            for r in by.get(controller, []):
                if r.end != "end":
                    own.append((problem, method, r.tolerance))
                    if r.tolerance in fine:
                        worse.append((problem, method, r.tolerance))
    return own, worse


def rejections(runs, controller):
    rows = [r for methods in runs.values() for by in methods.values() for r in by.get(controller, []) if r.end == "end"]
    return sum(r.rejected for r in rows) / max(1, sum(r.steps + r.rejected for r in rows))


def report(runs):
    controllers = sorted({c for methods in runs.values() for by in methods.values() for c in by})
    logs = {c: compare(runs, c) for c in controllers}
    mean = {c: math.exp(statistics.fmean(logs[c].values())) for c in controllers}
    learned = [c for c in controllers if c.startswith("rl")]
    untuned = [c for c in controllers if not c.startswith("rl")]
    print("| controller | work at equal error over basic's | rejected | runs that did not end (basic's did) | "
          + " | ".join(f"`{c}` over this one" for c in learned) + " |\n|---|---|---|---|" + "---|" * len(learned))
    for c in sorted(controllers, key=mean.get):
        own, worse = failures(runs, c)
        pairs = [compare(runs, l, c) for l in learned]
        cells = [f"{math.exp(statistics.fmean(pair.values())):.3f}" for pair in pairs]
        print(f"| `{c}` | {mean[c]:.3f} | {100 * rejections(runs, c):.1f} % | {len(own)} ({len(worse)}) | "
              f"{' | '.join(cells)} |")
    best = min(untuned, key=mean.get)
    hindsight = math.exp(statistics.fmean(min(logs[c][p] for c in untuned if p in logs[c]) for p in runs))
    print(f"\nbest untuned controller: {best}; the best of each problem in hindsight: {hindsight:.3f}")
    print("\n| problem | methods | " + " | ".join(f"`{c}`" for c in learned) + f" | `{best}` | best in hindsight |")
    print("|---|---|" + "---|" * (len(learned) + 2))
    for p, methods in runs.items():
        least = min((c for c in untuned if p in logs[c]), key=lambda c: logs[c][p])
        cells = [f"{math.exp(logs[c][p]):.2f}" if p in logs[c] else "–" for c in (*learned, best)]
        print(f"| {p} | {', '.join(methods)} | {' | '.join(cells)} | {math.exp(logs[least][p]):.2f} `{least}` |")
    for c in learned:
        for kind, rows in zip(("not ended", "not ended where basic did"), failures(runs, c)):
            if rows:
                print(f"{c} {kind}: {rows}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--controllers", default=",".join(CONTROLLERS), help="to run")
    parser.add_argument("--problems", help="to run, by commas (all)")
    parser.add_argument("--output", default="ode_runs.txt", help="file for the results of runs")
    parser.add_argument("--read", nargs="+", help="files of runs to compare")
    arguments = parser.parse_args()
    names = arguments.read
    if not names:
        names = [arguments.output]
        command = [os.path.join(BUILD, "tests", "odebench"), "-bench_controllers", arguments.controllers]
        command += ["-bench_problems", arguments.problems] if arguments.problems else []
        with open(arguments.output, "w", encoding="utf-8") as out:
            subprocess.run(command, stdout=out, check=True)
    files = [open(name, encoding="utf-8") for name in names]
    report(read(files))
    for file in files:
        file.close()


if __name__ == "__main__":
    sys.exit(main())
