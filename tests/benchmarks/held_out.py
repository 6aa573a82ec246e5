#!/usr/bin/env python3
"""Work and precision on faults that no policy was trained on: classical controllers at many tolerances, and learned
ones.

    tests/benchmarks/held_out.py                                  # everything, with the policy of the source tree
    tests/benchmarks/held_out.py --policy mine.h5 --name mine     # another policy; what is there already is reused
    tests/benchmarks/held_out.py --cases one --limit 8 --folder output/quick

Runs are done by the program `fault`, as a user would, and kept in FOLDER/runs.jsonl: an interrupted benchmark goes on
where it was. With --sparse the 40 single cells take 25 s and the heterogeneous meshes 20 s of one core; the 50 x 50
meshes take most of the rest. Writes FOLDER/held_out.h5, FOLDER/summary.png, FOLDER/curves_*.png. Cases and their
distribution: held_out_cases.py; what "best classical controller at the same error" means: held_out_score.py. Needs
numpy, h5py, matplotlib.
"""

import argparse
import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "output"))
from slipstep_modules import need

need("h5py", "numpy", "matplotlib")
import h5py
import numpy as np

sys.dont_write_bytecode = True
import held_out_cases
import held_out_score
from held_out_run import Bench, BenchmarkError, Job

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
UNITS = {"half_time_error": "s"}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.path.join(ROOT, "build"))
    parser.add_argument("--folder", default=os.path.join(ROOT, "output", "held_out"), help="of results")
    parser.add_argument("--policy", default=os.path.join(ROOT, "training", "policies", "fault.h5"))
    parser.add_argument("--name", default="ours", help="what tables and figures call the policy")
    parser.add_argument("--dials", type=float, nargs="+", default=[1e-1, 1e-2, 1e-3], help="of a policy that observes log_accuracy")
    parser.add_argument("--study", metavar="ZIP", help="the study's policy (Stable-Baselines3), run as published")
    parser.add_argument("--seed", type=int, default=held_out_cases.SEED, help="of the drawn faults; another one gives fresh cases")
    parser.add_argument("--cases", nargs="+", default=[""], help="only cases whose name begins like one of these: one, 3, 4, 5, mixed")
    parser.add_argument("--sparse", action="store_true", help="half of the tolerances: half of the time")
    parser.add_argument("--limit", type=int, help="only so many of the cases")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--no-plot", action="store_true")
    return parser.parse_args()


def observes_accuracy(policy):
    with h5py.File(policy) as file:
        return "log_accuracy" in [n.decode() if isinstance(n, bytes) else n for n in file["observation/names"][()]]


def learned(bench, cases, policy, name, dials, extra=()):
    """Runs of a policy at every position of its dial; one run a case (setting 0) when it has none."""
    jobs = []
    for dial in dials if observes_accuracy(policy) else [0]:
        options = ["-ts_adapt_type", "rl", *extra, *(["-ts_adapt_rl_accuracy", f"{dial:g}"] if dial else [])]
        jobs += [Job(case, "policy", name, dial, options, policy) for case in cases]
    return [dict(row, family=name) for row in bench.all(jobs, f"policy {name}")]


def import_study(archive, folder):
    """The study's policy as a file of ours."""
    path = os.path.join(folder, "study.h5")
    script = os.path.join(ROOT, "training", "import_sb3.py")
    done = subprocess.run([sys.executable, script, archive, path], capture_output=True, text=True)
    if done.returncode:
        raise BenchmarkError(f"{script} {archive} failed: {done.stderr.strip()}")
    return path


def write(path, runs, table, worst, chosen):
    """Tables as groups of columns."""
    with h5py.File(path + ".part", "w") as file:
        for group, rows in (("runs", runs), ("cells", table)):
            for name in sorted({n for r in rows for n in r} - {"key"}):
                values = [r.get(name) for r in rows]
                if any(isinstance(v, str) for v in values):
                    file[f"{group}/{name}"] = np.array([v or "" for v in values], dtype=h5py.string_dtype())
                else:
                    file[f"{group}/{name}"] = np.array([np.nan if v is None else v for v in values], float)
                    file[f"{group}/{name}"].attrs["units"] = UNITS.get(name, "m" if name == "mean_slip" else "s" if name == "wall" else "1")
        file.create_group("reference").attrs.update(worst)
        for dial, setting in chosen.items():
            if setting:
                file.require_group("setting").attrs[f"{dial:g}"] = f"{setting[0]}, rtol {setting[1]:g}"
    os.replace(path + ".part", path)


def report(table, chosen):
    stats = held_out_score.statistics(table)
    print(f"\n{'policy':<12}{'dial':>7}{'runs':>6}{'failed':>8}{'kept':>7}{'median':>9}{'solves':>8}   best classical over ours: mean, least, cells below 1")
    for (name, dial), s in stats.items():
        views = "; ".join(f"{v} {s[v]['mean']:.2f}, {s[v]['least']:.2f}, {s[v]['below_1']}/{s[v]['cells']}" for v in held_out_score.VIEWS if v in s)
        kept = f"{100 * s['kept']:.0f} %" if dial else "-"
        print(f"{name:<12}{dial or '-':>7}{s['runs']:>6}{s['failed']:>8}{kept:>7}{s['median_error']:>9.1e}{s['solves']:>8.1f}   {views}")
    for dial, setting in chosen.items():
        if setting:
            print(f"setting that keeps {dial:g} as the dial promises: {setting[0]}, rtol {setting[1]:g}")
    return stats


def main():
    o = arguments()
    folder = os.path.abspath(o.folder)
    os.makedirs(folder, exist_ok=True)
    cases = [c for c in held_out_cases.all_cases(folder, o.seed) if c.name.startswith(tuple(o.cases))][:o.limit]
    for case in cases if o.sparse else ():
        case.tolerances = [t for t in case.tolerances if t in held_out_cases.SPARSE]
    bench = Bench(os.path.abspath(o.build), folder, o.processes)
    worst = bench.references(cases)
    policy = os.path.abspath(o.policy)
    ours = learned(bench, cases, policy, o.name, o.dials)
    if o.study:
        ours += learned(bench, cases, import_study(o.study, folder), "study", [], held_out_cases.PUBLISHED)
    classical = bench.all([Job(c, "classical", *job) for c in cases for job in held_out_cases.classical(c)], "classical controllers")
    table, chosen = held_out_score.cells(ours, classical)
    report(table, chosen)
    write(os.path.join(folder, "held_out.h5"), classical + ours, table, worst, chosen)
    if not o.no_plot:
        import held_out_plot
        held_out_plot.draw(folder, classical, ours, table)


if __name__ == "__main__":
    try:
        main()
    except BenchmarkError as error:
        sys.exit(f"held_out.py: {error}")
