#!/usr/bin/env python3
"""Rates of events after a step of stress, against Dieterich's closed form (1994, J. Geophys. Res. 99, 2601-2618), by a
population of independent blocks of rate and state friction.

    tests/benchmarks/dieterich.py [--blocks 3000] [--figure OUT.png]

A block far beyond nucleation accelerates by itself: under a stressing rate S it fails after t = t_a ln(1 + S/(H sigma
V)), t_a = a sigma/S, H = b/d_c - K/sigma. Rates V at the start are those of failures that are evenly spaced over six
t_a, which is the background rate r. After a step of stress dtau at time 0 the rate is

    R/r = 1/((exp(-dtau/(a sigma)) - 1) exp(-t/t_a) + 1).

Bins of time have equal numbers of expected events; a number N may be off by 2 sqrt(N). Blocks are cells whose stiffness
is their own alone, -fault_stiffness_file of a diagonal matrix, a hundred in each run. Exits with 1 when a bin fails.
"""
import argparse
import os
import subprocess
import sys
import tempfile

from common import ROOT
import h5py
import numpy as np

FAULT = os.path.join(os.environ.get("SLIPSTEP_BUILD", os.path.join(ROOT, "build")), "bin", "fault")
A, B, DC, SIGMA, RATE = 0.01, 0.015, 1e-3, 5e7, 0.01  # ..., [m], [Pa], [Pa/s]
STIFFNESS, TOGETHER, SPAN, BINS = 2e6, 100, 6.0, 10  # [Pa/m], blocks of a run, t_a of the background, ...
BEYOND = 1e4  # V theta/d_c at the start, 1 in steady slip
TIME = A * SIGMA / RATE


def end(step):
    """When the last block fails [s]."""
    return TIME * np.log1p(np.expm1(SPAN) * np.exp(-step / (A * SIGMA)))


def onsets(folder, failures, step):
    """Onsets of the events of blocks that would fail at these times without the step [s]."""
    n = len(failures)
    weakening = B / DC - STIFFNESS / SIGMA
    rate = RATE / (weakening * SIGMA * np.expm1(failures / TIME))
    with h5py.File(os.path.join(folder, "fields.h5"), "w") as file:
        file["initial_rate"] = rate.reshape(1, n)
        file["initial_state"] = (BEYOND * DC / rate).reshape(1, n)
    with h5py.File(os.path.join(folder, "k.h5"), "w") as file:
        file["stiffness"] = STIFFNESS * np.eye(n)
    with open(os.path.join(folder, "step.csv"), "w", encoding="utf-8") as file:
        file.write(f"time,shear\n0,0\n1,{step}\n")
    options = {"nx": n, "nz": 1, "length_x": 1000 * n, "length_z": 1000, "friction_law": "rate_and_state",
               "friction_a": A, "friction_b": B, "friction_slip": DC, "normal_stress": SIGMA,
               "normal_stress_gradient": 0, "stressing_rate": RATE, "parameters": "fields.h5",
               "stiffness_file": "k.h5", "stress_history": "step.csv", "catalogue": "events.h5", "progress": "no",
               "output_overwrite": "yes"}
    words = [word for name, value in options.items() for word in (f"-fault_{name}", str(value))]
    subprocess.run([FAULT, *words, "-ts_max_time", str(1.05 * end(step)), "-ts_rtol", "1e-3"], cwd=folder, check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with h5py.File(os.path.join(folder, "events.h5")) as file:
        cell, onset = file["cell"][...].astype(int), file["onset"][...]
    return np.array([onset[cell == k].min() for k in range(n)])  # the first of each


def draw(axes, step, time, count):
    edges = np.geomspace(end(step) / 300, end(step), 16)
    numbers = np.histogram(time, edges)[0]
    middle, background = np.sqrt(edges[1:] * edges[:-1]), count / SPAN / TIME
    axes.errorbar(middle / TIME, numbers / np.diff(edges) / background, np.sqrt(numbers) / np.diff(edges) / background,
                  fmt="o", markersize=4, label=f"{step / 1e6:g} MPa")
    grid = np.geomspace(edges[0], edges[-1], 200)
    axes.plot(grid / TIME, 1 / (np.expm1(-step / (A * SIGMA)) * np.exp(-grid / TIME) + 1), color="black", linewidth=1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--blocks", type=int, default=3000)
    parser.add_argument("--figure", metavar="OUT")
    options = parser.parse_args()
    count = options.blocks // TOGETHER * TOGETHER
    failures = SPAN * TIME * (np.arange(count) + 0.5) / count
    wrong, found = 0, {}
    for step in (5e5, 2e6):
        with tempfile.TemporaryDirectory() as folder:
            found[step] = np.concatenate([onsets(folder, failures[k::count // TOGETHER], step)
                                          for k in range(count // TOGETHER)])
        edges = TIME * np.log1p(np.expm1(SPAN * np.arange(BINS + 1) / BINS) * np.exp(-step / (A * SIGMA)))
        numbers = np.histogram(found[step], np.append(edges[:-1], np.inf))[0]
        print(f"step of {step / 1e6:g} MPa, {count} events, {count // BINS} expected in each bin of time")
        for low, high, number in zip(edges[:-1], edges[1:], numbers):
            off = (number - count / BINS) / np.sqrt(count / BINS)
            wrong += abs(off) > 2
            print(f"  {low / TIME:8.4f} to {high / TIME:8.4f} t_a  {number:5d}  {off:+5.2f} standard deviations")
    if options.figure:
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot as plt
        canvas, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
        for step, time in found.items():
            draw(axes, step, time, count)
        axes.set(xscale="log", yscale="log", xlabel="time after the step (a sigma/S)", ylabel="rate over background",
                 title=f"{count} blocks after a step of stress; lines: Dieterich (1994)")
        axes.legend()
        canvas.savefig(options.figure, dpi=120)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
