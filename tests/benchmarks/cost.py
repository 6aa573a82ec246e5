#!/usr/bin/env python3
"""The cost that runs are given against the processor time that they take, and the prices of work that it is made of.

    cost.py [--build DIR] [--seed S] [--count N]    N runs of each kind: a table in Markdown, and a line a share of time
    cost.py --check                                 exits with 1 where one of these is not within 15 % of the clock
    cost.py --calibrate                             draws other runs, and writes src/sys/workprices.h; then build again

Kinds: single events with inertia by dense, spectral, sketched and Lanczos' roots, of vectors, and on hierarchical
storage; one cell; ruptures without inertia by rkc, adams and bathe; sequences without inertia and with it; injections,
by a source and by wells; BP5 by adams and rk; waves on a plane; dipping rectangles; a dyke that opens; and long
outputs. Sizes, controllers and durations are drawn by the seed. The time is that of the whole process, user and system,
the least of three runs one after the other on one thread. Prices are the least squares of relative errors, none
negative.
"""

import argparse
import os
import pickle
import re
import subprocess
import sys
import tempfile

from common import ROOT, need, write

need("scipy")
import h5py
import numpy as np
from scipy.optimize import nnls

sys.path.insert(0, os.path.join(ROOT, "tests", "python"))
from meshfiles import plane, write_hdf5
from ruptures import draw as draw_rupture

EXAMPLES = os.path.join(ROOT, "examples")
PRICES = os.path.join(ROOT, "src", "sys", "workprices.h")
SEED, CALIBRATION_SEED, CALIBRATION_COUNT = 2, 1000, 4
REPEATS = 3
WITHIN = 0.15
SHARE_WEIGHT = 0.3  # of the equations of shares beside those of whole runs


def log_uniform(random, low, high):
    return float(low * (high / low) ** random.random())


def size(random, low, high):
    return round(log_uniform(random, low, high))


def made(script, *arguments):
    return subprocess.run([sys.executable, os.path.join(EXAMPLES, script), *map(str, arguments)], check=True,
                          capture_output=True, text=True).stdout


def file(name):
    return ["-options_file", os.path.join(EXAMPLES, f"{name}.opts")]


def controller(random):
    return [[], [], ["-ts_adapt_type", "pi", "-ts_rtol", "1e-3"],
            ["-ts_adapt_type", "heuristic", "-ts_rtol", "1e-2"]][random.integers(4)]


def event(random, low, high, *options):
    nx = size(random, low, high)
    return [*file("fault_3km"), "-fault_nx", nx, "-fault_nz", max(1, round(nx * random.uniform(0.6, 1.2))),
            *controller(random), *options]


def rupture(random, *options):
    words, fields, duration = draw_rupture(["small", "large", "vector", "scattered"][random.integers(4)],
                                           int(random.integers(10**6)))
    write("rupture.h5", **fields)
    return [*words, "-fault_parameters", "rupture.h5", "-ts_max_time", duration, *options]


def sequence(random, cells, years, *options):
    nx = size(random, *cells)
    made("make_fault.py", "sequence.h5", "--cells", nx, max(2, nx // 2), "--size", 20000, 10000, "--stress", 0.5,
         "--seed", random.integers(1000))
    return [*file("fault_centuries"), "-fault_nx", nx, "-fault_nz", max(2, nx // 2), "-fault_length_x", 20000,
            "-fault_length_z", 10000, "-fault_parameters",
            "sequence.h5", "-ts_max_time", f"{size(random, *years)}y", "-fault_catalogue", "events.h5", *options]


def injection(random):
    n = size(random, 16, 48)
    k = np.hypot(*np.meshgrid(np.fft.fftfreq(n, 2400 / n), np.fft.fftfreq(n, 2400 / n)))
    noise = np.real(np.fft.ifft2(np.fft.fft2(random.normal(size=(n, n))) * np.exp(-((2 * np.pi * k * 300) ** 2) / 2)))
    write("injection.h5", initial_traction=np.minimum(20.8e6 + 2e6 * noise / noise.std(), 23.8e6))
    return [*file("injection"), "-fault_nx", n, "-fault_nz", n, "-fault_friction_slip", 0.024 * 48 / n,
            "-fault_parameters", "injection.h5", "-fault_catalogue", "events.h5", "-ts_max_time",
            f"{size(random, 10, 40)}d"]


def fluid(random):
    n = made("seas_bp8.py", "make", "bp8", "--diffusion", "--cell", [40, 20, 10][random.integers(3)]).strip()
    law = [[], ["-fault_permeability_law", "stress", "-fault_permeability_stress", 2e7]][random.integers(2)]
    return [*file("seas_bp8"), "-fault_nx", n, "-fault_nz", n, "-fault_wells", "bp8_wells.csv", "-fault_permeability",
            5e-14, "-fault_pore_compressibility", 1e-8, "-ts_max_time", f"{size(random, 5, 30)}d", *law]


def bp5(random, *options):
    cell = [1000, 2000, 4000, 4000][random.integers(4)]
    nx, nz = made("make_seas.py", "bp5", "bp5.h5", "--cell", cell).split()
    return [*file("seas_bp5"), "-fault_nx", nx, "-fault_nz", nz, "-fault_parameters", "bp5.h5", "-ts_max_time",
            f"{size(random, 100, 500) if cell > 1000 else 80}y", *options]


def waves(random):
    nz = size(random, 16, 40)
    x, z = np.meshgrid((np.arange(2 * nz) + 0.5) / nz - 1, (np.arange(nz) + 0.5) / nz - 0.5)
    write("waves.h5", initial_traction=np.where(np.maximum(np.abs(x), np.abs(z)) < 0.12, 81.6e6, 70e6))
    return [*file("tpv3"), "-fault_nx", 2 * nz, "-fault_nz", nz, "-fault_parameters", "waves.h5", "-ts_max_time",
            random.uniform(4, 13)]


def dipping(random):
    nx = size(random, 6, 24)
    made("make_mesh.py", "dipping.h5", "listric", "--cells", nx, max(4, nx // 2), "--size", 3000, 2000, "--dip",
         random.uniform(30, 60), "--dip-bottom", 30)
    return [*slides("dipping.h5"), *controller(random)]


def triangles(random, *options):
    n = size(random, 6, 24)
    write_hdf5("triangles.h5", *plane((n, max(4, n // 2)), (3000 / n, 3000 / n), 20, 60, (0, 0, 500)))
    return [*slides("triangles.h5"), *controller(random), *options]


def slides(mesh):
    return ["-fault_mesh", mesh, "-fault_rake", 90, "-ts_max_time", 30]


def dyke(random):
    made("dyke.py", "make", "dyke", "--cell", size(random, 500, 1200), "--pressure", random.uniform(4, 7))
    return [*file("dyke"), "-fault_mesh", "dyke_mesh.h5", "-fault_parameters", "dyke_fields.h5", "-fault_pore_pressure",
            "dyke_pressure.h5"]


SPARSE = ["-fault_output_interval", 1000000]
KINDS = {
    "event, dense": lambda r: event(r, 3, 16, *SPARSE),
    "event, spectral": lambda r: event(r, 30, 110, "-fault_viscosity", "spectral", *SPARSE),
    "event, sketch": lambda r: event(r, 20, 55, "-mat_slipsqrtm_setup", "sketch", *SPARSE),
    "event, Lanczos": lambda r: event(r, 30, 100, "-mat_slipsqrtm_setup", "lanczos", *SPARSE),
    "event, vectors": lambda r: event(r, 12, 40, "-fault_slip_components", 2, "-fault_rake", r.uniform(0, 90), *SPARSE),
    "event, hierarchical": lambda r: event(r, 16, 40, "-fault_operator", "hmat", *SPARSE),
    "one cell": lambda r: ["-fault_nx", 1, "-fault_nz", 1, "-ts_adapt_type", ["pi", "heuristic"][r.integers(2)],
                           "-ts_rtol", log_uniform(r, 1e-8, 1e-4)],
    "rupture, rkc": lambda r: rupture(r, "-ts_type", "rkc", "-ts_rtol", log_uniform(r, 1e-3, 1e-1)),
    "rupture, adams": lambda r: rupture(r, "-ts_type", "adams", "-ts_rtol", log_uniform(r, 1e-4, 1e-2)),
    "rupture, bathe": lambda r: rupture(r, "-ts_type", "bathe"),
    "sequence": lambda r: sequence(r, (6, 30), (20, 100)),
    "sequence, inertia": lambda r: sequence(r, (8, 20), (20, 60), "-fault_inertia", "yes", "-fault_viscosity", "sqrtm"),
    "injection": injection,
    "fluid": fluid,
    "BP5, adams": lambda r: bp5(r, "-ts_type", "adams", "-ts_adapt_type", "rl"),
    "BP5, rk": lambda r: bp5(r),
    "waves": waves,
    "dipping": dipping,
    "triangles": triangles,
    "triangles, hierarchical": lambda r: triangles(r, "-fault_operator", "hmat"),
    "dyke": dyke,
    "long output": lambda r: event(r, 16, 40, "-fault_output_interval", 1, "-fault_stations",
                                   "500,500;1500,1500;2500,2500"),
    "long output of cycles": lambda r: bp5(r, "-ts_type", "adams", "-ts_adapt_type", "rl", "-fault_output_interval",
                                           size(r, 2, 8)),
}


class Build:
    def __init__(self, folder):
        self.program = os.path.abspath(os.path.join(folder, "bin", "fault"))
        self.environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

    def __call__(self, words):
        """(processor time [s], cost [s]) of a run"""
        pid = os.posix_spawn(self.program, [self.program, *words, "-fault_output", "run.h5", "-fault_output_overwrite",
                                            "-fault_progress", "no"],
                             self.environment, file_actions=[(os.POSIX_SPAWN_OPEN, 1, "out.txt",
                                                              os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600),
                                                             (os.POSIX_SPAWN_OPEN, 2, "err.txt",
                                                              os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)])
        _, status, used = os.wait4(pid, 0)
        if status:
            with open("err.txt") as said:
                raise SystemExit(f"{' '.join(words)}\nended with {status}: {said.read()}")
        with h5py.File("run.h5") as run:
            return used.ru_utime + used.ru_stime, float(run["result"].attrs["cost"])

    def work(self, words):
        """{kind of work: units for each share of the time}, and {share: (measured, cost)}"""
        self([*words, "-fault_view", "ascii:view.txt:ascii_info_detail"])
        with open("view.txt") as out:
            text = out.read()
        shares = {name.strip(): (float(a), float(b)) for name, a, b
                  in re.findall(r"^\s+([a-z -]+?)\s+([\d.]+) +[\d.]+ % +([\d.]+) +[\d.]+ %$", text, re.M)}
        return {name: np.array(n.split(), float)
                for name, n in re.findall(r"^\s+work (\w+): (.*)$", text, re.M)}, shares


def drawn(seed, count):
    """(kind, words), with the files of the run in this folder"""
    for at in range(count):
        for k, (kind, draw) in enumerate(KINDS.items()):
            yield kind, [str(word) for word in draw(np.random.default_rng([seed, at, k]))]


def compare(build, seed, count):
    print("| run | cells along strike, or of a mesh | processor time (s) | cost (s) | cost / time |\n"
          "|---|---|---|---|---|")
    ratios, shares = [], {}
    for kind, words in drawn(seed, count):
        times, costs = zip(*(build(words) for _ in range(REPEATS)))
        if len(set(costs)) > 1:
            raise SystemExit(f"{kind}: the same run costs {costs}")
        ratios.append(costs[0] / min(times))
        with h5py.File("run.h5") as run:
            cells = run["mesh/x"].size
        print(f"| {kind} | {cells} | {min(times):.3f} | {costs[0]:.3f} | {ratios[-1]:.2f} |", flush=True)
        for name, (measured, cost) in build.work(words)[1].items():
            shares.setdefault(name, []).append((measured, cost))
    ratios = np.array(ratios)
    print(f"\n{np.sum(np.abs(ratios - 1) <= WITHIN)} of {len(ratios)} within {100 * WITHIN:.0f} %, ratios from "
          f"{ratios.min():.2f} to {ratios.max():.2f}")
    for name, pairs in shares.items():
        measured, cost = np.sum(pairs, axis=0)
        print(f"{name}: {measured:.2f} s measured, {cost:.2f} s by cost")
    return np.all(np.abs(ratios - 1) <= WITHIN)


def calibrate(build, keep):
    runs = []
    for kind, words in drawn(CALIBRATION_SEED, CALIBRATION_COUNT):
        units, shares = build.work(words)
        time = min(build(words)[0] for _ in range(REPEATS))
        runs.append((kind, time, np.array([measured for measured, _ in shares.values()]),
                     np.array(list(units.values()))))
        print(f"{kind}: {time:.3f} s", file=sys.stderr, flush=True)
    if keep:
        with open(keep, "wb") as out:
            pickle.dump((list(units), runs), out)
    solve(list(units), runs)


def solve(names, runs):
    """Prices from runs: (kind, time, time of each share with a clock that is read at each change, [work, share]
    units)."""
    kinds, times, shares, units = (np.array(values) for values in zip(*runs))
    whole = units.sum(axis=2)
    scale = np.maximum(whole.max(axis=0), 1)
    begin = 0.8 * times.min()  # about what any process takes, beside which errors do not show
    weight = 1 / (times - begin)
    shares = shares * (times / shares.sum(axis=1))[:, None]  # without the clock that is read at each change
    rows, right = [whole * weight[:, None]], [times * weight]
    for k in range(shares.shape[1]):
        weight = SHARE_WEIGHT / (np.maximum(shares[:, k] - begin * (k == 0), 0) + 0.15 * (times - begin))
        rows.append(units[:, :, k] * weight[:, None])
        right.append(shares[:, k] * weight)
    prices, _ = nnls(np.concatenate(rows) / scale, np.concatenate(right))
    prices /= scale
    cost = whole @ prices
    ratio, beyond = cost / times, (cost - begin) / (times - begin)
    print(f"ratios from {ratio.min():.2f} to {ratio.max():.2f}; {np.sum(np.abs(ratio - 1) <= WITHIN)} of {len(ratio)} "
          f"within {100 * WITHIN:.0f} %")
    for kind in KINDS:
        print(kind, *(f"{t:.2f}:{r:.2f}/{b:.2f}" for k, t, r, b in zip(kinds, times, ratio, beyond) if k == kind))
    for k in range(shares.shape[1]):
        print(f"share {k}: {shares[:, k].sum():.2f} s, {(units[:, :, k] @ prices).sum():.2f} s")
    with open("/proc/cpuinfo") as info:
        machine = next((line.split(":")[1].strip() for line in info if line.startswith("model name")), "a processor")
    with open(PRICES, "w") as out:
        out.write(f"/* Processor time of a unit of each kind of work [s], by {len(times)} runs on one core of an "
                  f"{machine}.\n" "   tests/benchmarks/cost.py --calibrate writes this file. */\n"
                  "static const PetscReal WorkPrices[SLIP_WORKS] = {\n"
                  + "".join(f"  [SLIP_WORK_{name}] = (PetscReal){price:.4g},\n" for name, price in zip(names, prices))
                  + "};\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--build", default=os.path.join(ROOT, "build"))
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--count", type=int, default=1)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--calibrate", action="store_true")
    parser.add_argument("--keep", help="file for the units and times of --calibrate")
    a = parser.parse_args()
    build, keep = Build(a.build), a.keep and os.path.abspath(a.keep)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        good = compare(build, a.seed, a.count) if not a.calibrate else calibrate(build, keep)
    sys.exit(a.check and not good)


if __name__ == "__main__":
    main()
