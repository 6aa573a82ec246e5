#!/usr/bin/env python3
"""Work and precision on faults that no policy was trained on: classical controllers at many tolerances, and learned
ones, at equal error of the whole course of slip.

    tests/benchmarks/held_out.py                                  # everything, with the policy of the source tree
    tests/benchmarks/held_out.py --policy mine.h5 --name mine     # another policy; what is there already is reused
    tests/benchmarks/held_out.py --cases single --limit 8 --folder output/quick
    tests/benchmarks/held_out.py --measure final_slip             # the same runs by another measure

Runs are done by the program `fault`, as a user would, and kept in FOLDER/runs.jsonl with all parts of their errors: an
interrupted benchmark goes on where it was, and another measure needs no runs. Writes FOLDER/MEASURE.h5 and figures
FOLDER/MEASURE_*.png. Faults and classical controllers: held_out_cases.py; error: slipstep.results.course; what "at
equal error" means: held_out_score.py. Needs numpy, h5py, matplotlib.
"""

import argparse
import os
import sys

from common import ROOT, need

need("matplotlib")
import h5py
import numpy as np

from slipstep.results import course
import held_out_cases
import held_out_score
from held_out_run import Bench, BenchmarkError, Job

DIALS = [1e-1, 5e-2, 2e-2, 1e-2, 3e-3]
UNITS = {"mean_slip": "m", "wall_time_solve": "s"}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.path.join(ROOT, "build"))
    parser.add_argument("--folder", default=os.path.join(ROOT, "output", "held_out"), help="of results")
    parser.add_argument("--policy", default=os.path.join(ROOT, "training", "policies", "fault.h5"))
    parser.add_argument("--name", default="rl", help="name of the policy in tables and figures")
    parser.add_argument("--dials", type=float, nargs="+", default=DIALS, help="values of -ts_adapt_rl_accuracy")
    parser.add_argument("--learned-options", default="", metavar="TEXT",
                        help="further options of the learned runs, in one word")
    parser.add_argument("--measure", choices=course.MEASURES, default="history",
                        help="what is equal, and what the dial promises")
    parser.add_argument("--seed", type=int, default=held_out_cases.SEED,
                        help="seed of the drawn faults; another one gives fresh cases")
    parser.add_argument("--cases", nargs="+", default=[""],
                        help="only cases whose name begins with one of these: single, 3km_25, ...")
    parser.add_argument("--families", nargs="+", default=[""],
                        help="only classical families whose name begins with one of these: heuristic, dsp, ...")
    parser.add_argument("--sparse", action="store_true",
                        help="use half of the tolerances, which takes half of the time")
    parser.add_argument("--limit", type=int, help="at most this many cases of each kind")
    parser.add_argument("--jobs", type=int, default=2, help="processes at once")
    parser.add_argument("--no-plot", action="store_true")
    return parser.parse_args()


def chosen_cases(bench, seed, begins, limit=None):
    """Cases whose name begins like one of the words, of each kind so many."""
    def want(name):
        number = name.rsplit("_", 1)[1]
        return name.startswith(tuple(begins)) and not (limit and name.split("_")[0] in held_out_cases.KINDS
                                                       and int(number) > limit)
    cases = held_out_cases.all_cases(bench.folder, seed, bench.probe, want)
    if not cases:
        raise BenchmarkError(f"no case begins like {' or '.join(begins)}; expected one of "
                             f"{', '.join(held_out_cases.KINDS)}, 3km_25, ...")
    return cases


def check_families(begins):
    """Each word begins some family's name: else there is nothing to compare with."""
    names = held_out_cases.family_names()
    for word in begins:
        if not any(name.startswith(word) for name in names):
            raise BenchmarkError(f"no classical family begins like {word} (--families); expected the beginning of one "
                                 f"of: {'; '.join(names)}")


def learned(bench, cases, policy, name, dials, extra=()):
    """Runs of a policy at positions of its dial."""
    jobs = []
    for dial in dials:
        options = ["-ts_adapt_type", "rl", "-ts_adapt_rl_accuracy", f"{dial:g}", *extra]
        jobs += [Job(case, "policy", name, dial, options, policy) for case in cases]
    return [dict(row, family=name) for row in bench.all(jobs, f"policy {name}")]


def write(path, measure, runs, table, worst, chosen):
    """Tables as groups of columns."""
    with h5py.File(path + ".part", "w") as file:
        file.attrs["measure"] = measure
        for group, rows in (("runs", runs), ("cells", table)):
            for name in sorted({n for r in rows for n in r} - {"key"}):
                values = [r.get(name) for r in rows]
                if any(isinstance(v, str) for v in values):
                    file[f"{group}/{name}"] = np.array([v or "" for v in values], dtype=h5py.string_dtype())
                else:
                    file[f"{group}/{name}"] = np.array([np.nan if v is None else v for v in values], float)
                    file[f"{group}/{name}"].attrs["units"] = UNITS.get(name, "1")
        file.create_group("reference").attrs.update(worst)
        for dial, setting in chosen.items():
            if setting:
                file.require_group("setting").attrs[f"{dial:g}"] = f"{setting[0]}, rtol {setting[1]:g}"
    os.replace(path + ".part", path)


def ratio(s, view, which):
    return f"{s[view][which]:.2f}" if view in s else "-"


def report(table, chosen, measure):
    """One line a kind and position of the dial."""
    other = "history" if measure == "final_slip" else "final slip"
    stats = held_out_score.statistics(table)
    print(f"\nsolves of the best classical run over ours at equal error of the {measure.replace('_', ' ')}; other: of "
          f"the {other}; bound: steps over ours")
    print(f"{'cases':<16}{'policy':<8}{'dial':>7}{'runs':>6}{'failed':>7}{'kept':>6}{'median':>9}{'other':>9}"
          f"{'solves':>8} |{'mean':>7}{'least':>7}"
          f"{'below 1':>9} |{'other':>7}{'least':>7} |{'setting':>8} |{'bound':>6}")
    for (name, dial, group), s in sorted(stats.items(), key=lambda x: (x[0][2] == "all", x[0][2], x[0][0], -x[0][1])):
        below = f"{s['equal']['below_1']}/{s['equal']['cells']}" if "equal" in s else "-"
        print(f"{group:<16}{name:<8}{dial:>7g}{s['runs']:>6}{s['failed']:>7}{100 * s['kept']:>5.0f}%"
              f"{s['median']:>9.1e}{s['median_other']:>9.1e}{s['solves']:>8.1f} |"
              f"{ratio(s, 'equal', 'mean'):>7}{ratio(s, 'equal', 'least'):>7}{below:>9} "
              f"|{ratio(s, 'other', 'mean'):>7}{ratio(s, 'other', 'least'):>7} |"
              f"{ratio(s, 'setting', 'mean'):>8} |{ratio(s, 'bound', 'median'):>6}")
    for dial, setting in chosen.items():
        if setting:
            print(f"setting that keeps {dial:g} as the dial promises: {setting[0]}, rtol {setting[1]:g}")


def main():
    o = arguments()
    folder = os.path.abspath(o.folder)
    check_families(o.families)
    os.makedirs(folder, exist_ok=True)
    bench = Bench(os.path.abspath(o.build), folder, o.jobs)
    cases = chosen_cases(bench, o.seed, o.cases, o.limit)
    for case in cases if o.sparse else ():
        case.tolerances = held_out_cases.SPARSE
    worst = bench.references(cases)
    ours = learned(bench, cases, os.path.abspath(o.policy), o.name, o.dials, o.learned_options.split())
    classical = bench.all([Job(c, "classical", *job) for c in cases for job in held_out_cases.classical(c, o.families)],
                          "classical controllers")
    table, chosen = held_out_score.cells(ours, classical, o.measure)
    report(table, chosen, o.measure)
    write(os.path.join(folder, f"{o.measure}.h5"), o.measure, classical + ours, table, worst, chosen)
    if not o.no_plot:
        import held_out_plot
        held_out_plot.draw(os.path.join(folder, o.measure), o.measure, classical, ours)


if __name__ == "__main__":
    try:
        main()
    except BenchmarkError as error:
        sys.exit(f"held_out.py: {error}")
