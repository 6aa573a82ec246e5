#!/usr/bin/env python3
"""Cost against error on the 3 km fault: what the published study compares, and learned, classical and constant steps
today.

    tests/benchmarks/work.py                      # 50 x 50 cells, a few minutes; output/work.json and the figure
    tests/benchmarks/work.py --cells 24 --figure f.png

The cost is the modelled processor time of the whole run (/result of its output file, the same each time;
tests/benchmarks/cost.py has its error); products with stiffness and viscosity are printed too. The error is that of the
whole history against 8,000 constant explicit steps, which 8,000 implicit ones confirm.
"""

import argparse
import json
import os
import subprocess
import tempfile

from common import ROOT, need

need("matplotlib")
import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from slipstep.results import course  # noqa: E402

DURATION = 30  # s
FINE = 8000  # steps of the reference
STUDY = os.path.join(ROOT, "training", "study", "policies", "fault_tqc_alpha{}.h5")
DIALS = ("1e-1", "3e-2", "1e-2", "3e-3", "1e-3")
PUBLISHED = ("-ts_bathe_method", "implicit", "-ts_bathe_reaction", "implicit")


def constant(steps):
    return "-ts_adapt_type", "none", "-ts_bathe_error", "none", "-ts_dt", repr(DURATION / steps)


TOLERANCES = ("1e-2", "3e-3", "1e-3", "3e-4", "1e-4")


def classical(name):
    return [("-ts_bathe_method", "auto", "-ts_adapt_type", name, "-ts_rtol", tolerance) for tolerance in TOLERANCES]


# label: (marker and line, runs)
SETS = {"study's heuristic": ("s--", [(*PUBLISHED, "-ts_bathe_error", "doubling", "-ts_adapt_type", "heuristic",
                                       "-ts_rtol", tolerance) for tolerance in TOLERANCES]),
        "study's agent (TQC, TD3)": ("x", [(*PUBLISHED, "-ts_adapt_type", "rl", "-ts_adapt_rl_strict",
                                            "-ts_adapt_rl_policy", STUDY.format(alpha)) for alpha
                                           in ("0.5", "1", "2", "4", "8", "16", "32", "128")]),
        "rl, implicit steps": ("o-", [("-ts_bathe_method", "implicit", "-fault_accuracy", dial) for dial in DIALS]),
        "explicit or implicit, heuristic": ("^:", classical("heuristic")),
        "explicit or implicit, pi": ("<:", classical("pi")),
        "explicit or implicit, dsp": (">:", classical("dsp")),
        "explicit, constant": ("v:", [("-ts_type", "moreau", *constant(n)) for n in (200, 260, 340, 500, 800)]),
        "default: explicit or implicit, rl": ("D-", [("-fault_accuracy", dial) for dial in DIALS]),}


def run(fault, cells, options, path):
    subprocess.run([fault, "-options_file", os.path.join(ROOT, "examples", "fault_3km.opts"), "-fault_nx", str(cells),
                    "-fault_nz", str(cells), *options, "-fault_output", path, "-fault_output_overwrite"], check=True,
                   capture_output=True, text=True)
    with h5py.File(path) as f:
        result = {key: float(f["result"].attrs[key]) for key in ("cost", "products_all", "products_pc", "solves",
                                                                 "processor_time")}
        result["explicit"] = float(f["result"].attrs.get("explicit_attempts", 0))
    return course.read(path), result


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--build", default=os.path.join(ROOT, "build"))
    parser.add_argument("--cells", type=int, default=50, help="along each side")
    parser.add_argument("--results", default=os.path.join(ROOT, "output", "work.json"))
    parser.add_argument("--figure", default=os.path.join(ROOT, "output", "work.png"))
    args = parser.parse_args()
    fault = os.path.join(args.build, "bin", "fault")
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "run.h5")
        fine, _ = run(fault, args.cells, ("-ts_type", "moreau", *constant(FINE)), path)
        other, _ = run(fault, args.cells, ("-ts_bathe_method", "implicit", *constant(FINE)), path)
        agree = course.MEASURES["history"](course.errors(other, fine))
        print(f"explicit and implicit references differ by {agree:.1e}")
        for label, (_, runs) in SETS.items():
            for options in runs:
                c, result = run(fault, args.cells, options, path)
                error = course.MEASURES["history"](course.errors(c, fine))
                rows.append({"set": label, "options": " ".join(options), "error": error, **result})
                print(f"{label:34} {result['products_all']:7.0f} + {result['products_pc']:5.0f} products, "
                      f"{result['solves']:5.0f} attempts ({result['explicit']:.0f} explicit), "
                      f"cost {result['cost']:7.3f} s, clock {result['processor_time']:6.2f} s, error {error:.1e}")
    with open(args.results, "w", encoding="utf-8") as f:
        json.dump({"cells": args.cells, "agree": agree, "runs": rows}, f, indent=1)
    draw(args, rows)


def draw(args, rows):
    figure, axes = plt.subplots(figsize=(6.4, 5.2), layout="constrained")
    for label, (style, _) in SETS.items():
        mine = sorted((r["error"], r["cost"]) for r in rows if r["set"] == label)
        axes.loglog([cost for _, cost in mine], [error for error, _ in mine], style, label=label, markersize=5)
    axes.set(xlabel="cost [s]", ylabel="error of the history", title=f"3 km fault, {args.cells} x {args.cells} cells")
    axes.set_xticks((0.2, 0.5, 1, 2, 5), ("0.2", "0.5", "1", "2", "5"))
    axes.set_xticks((), minor=True)
    axes.grid(True, which="both", alpha=0.25)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncol=2)
    figure.savefig(args.figure, dpi=150)


if __name__ == "__main__":
    main()
