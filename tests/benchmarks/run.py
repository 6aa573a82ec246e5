#!/usr/bin/env python3
"""Run the benchmark cell by cell; tests/benchmarks/run.sh sets the environment and calls this.

A cell is one process: an operator at one size (tests/operators), the linear solver at one size and step, or a full run
(fault). All numbers of a cell are attributes of /cells/<name> of the output, which is written anew after each cell, so
a benchmark that was stopped goes on where it was. Cells that fail are marked and do not stop the rest; --retry tries
them again. At the end the same numbers are in tables (/operators, /iterations, /runs, one dataset a column, and
/slopes), and printed.
"""

import argparse
import math
import os
import platform
import re
import subprocess
import sys
import time

from common import ROOT
import h5py
import numpy as np

SIZES = (25, 50, 100, 200, 512, 1000)
# Largest size of each operator: dense matrices fill the memory, the others the day.
LARGEST = {"k_dense": 100, "k_fft": 1000, "k_hmat": 200, "h_sqrtm": 512, "h_spectral": 1000, "h_lanczos": 512, "b": 512,
           "pc": 512}
TWO_RANKS = ("k_fft", "h_sqrtm", "b", "pc")
STEPS = (0.05, 0.5, 2.0, 7.0)  # of the linear solver [T*]
RUN_LARGEST = {"rl": 512, "heuristic": 100}  # a heuristic run at 200 takes more than five minutes
SUMMARY = {"accepted": r"accepted steps: *(\d+)", "rejected": r"rejected steps: *(\d+)",
           "solves": r"Bathe solves: *(\d+)", "newton": r"Newton iterations: *(\d+)",
           "linear": r"linear iterations: *(\d+)", "products_k": r"products with K: *(\d+)",
           "products_h": r"products with H: *(\d+)", "mean_slip": r"final mean slip: *([-+.\de]+)",
           "setup": r"wall time of set-up: *([.\d]+)", "solve": r"wall time of the solve: *([.\d]+)",
           "resident": r"Maximum \(over computational time\) process memory: +total +\S+ +max +(\S+)"}
UNITS = {"setup": "s", "product": "s", "solve": "s", "wall": "s", "mean_slip": "m", "memory": "B", "memory_all": "B",
         "resident": "B", "step": "T*"}


def arguments():
    parser = argparse.ArgumentParser(description="Benchmark of the operators, the linear solver and full runs of the "
                                                 "3 km fault.")
    parser.add_argument("--quick", action="store_true", help="sizes up to 25 and short runs: less than a minute")
    parser.add_argument("--max-n", type=int, default=200, metavar="N",
                        help="largest number of cells a side (default 200)")
    parser.add_argument("--output", default=os.path.join(ROOT, "output", "benchmark.h5"), metavar="F.h5")
    parser.add_argument("--build", default=os.path.join(ROOT, "build"), metavar="DIR")
    parser.add_argument("--timeout", type=float, default=3600, metavar="S",
                        help="longest time of a cell [s] (default 3600)")
    parser.add_argument("--retry", action="store_true", help="run failed cells again")
    return parser.parse_args()


# ---- cells ----

class Cell:
    """table: operators, iterations or runs. cost: a guess of the time it takes [s], for the time left only."""

    def __init__(self, table, name, n, ranks, cost, program, options, **keys):
        self.table, self.name, self.n, self.ranks, self.cost = table, name, n, ranks, cost
        self.program, self.options, self.keys = program, options, keys


def operator_cells(sizes):
    """Set-up grows about as n^3 where wavenumbers are diagonalised, as n^4 or more for what is dense or compressed."""
    guess = {"k_dense": (2, 4), "k_fft": (0.1, 2), "k_hmat": (10, 2.5), "h_sqrtm": (10, 3.5), "h_spectral": (0.1, 3),
             "h_lanczos": (1, 3), "b": (0.3, 3), "pc": (0.3, 3)}
    for n in sizes:
        for kind, (at_100, power) in guess.items():
            if n > LARGEST[kind]:
                continue
            for ranks in (1, 2) if kind in TWO_RANKS else (1,):
                options = ["-bench_kind", kind, "-bench_n", str(n)]
                yield Cell("operators", f"{kind}-{n}-{ranks}", n, ranks, 1 + at_100 * (n / 100) ** power, "operators",
                           options, kind=kind)


def iteration_cells(sizes):
    for n in sizes:
        for step in STEPS if n <= LARGEST["b"] else ():
            options = ["-bench_kind", "cg", "-bench_n", str(n), "-bench_step", str(step)]
            yield Cell("iterations", f"cg-{n}-{step:g}", n, 1, 1 + 0.5 * (n / 100) ** 3, "operators", options,
                       step=step)


def run_cells(sizes, extra):
    policy = os.path.join(ROOT, "training", "policies", "fault.h5")
    controllers = {"rl": ["-ts_adapt_type", "rl", "-ts_adapt_rl_policy", policy],
                   "heuristic": ["-ts_adapt_type", "heuristic", "-ts_rtol", "1e-3"]}
    for n in sizes:
        for controller, options in controllers.items():
            for ranks in (1, 2) if n <= RUN_LARGEST[controller] else ():
                cost = (1 if controller == "rl" else 20) * (n / 100) ** 3
                grid = ["-fault_nx", str(n), "-fault_nz", str(n), "-fault_stiffness_scaling", "mean_slip"]
                yield Cell("runs", f"{controller}-{n}-{ranks}", n, ranks, 1 + cost, "fault",
                           [*grid, *options, "-memory_view", *extra], controller=controller)


def all_cells(args):
    """In order of size, so that a benchmark that is stopped has the small ones complete."""
    sizes = (10, 15, 25) if args.quick else [n for n in SIZES if n <= args.max_n]
    run_sizes = (10, 15) if args.quick else sizes
    iteration_sizes = (15, 25) if args.quick else [n for n in sizes if n >= 50]
    extra = ["-ts_max_time", "5"] if args.quick else []
    cells = [*operator_cells(sizes), *iteration_cells(iteration_sizes), *run_cells(run_sizes, extra)]
    return sorted(cells, key=lambda c: (c.n, ("operators", "iterations", "runs").index(c.table)))


def command(cell, build):
    program = os.path.join(build, {"operators": "tests/operators", "fault": "bin/fault"}[cell.program])
    line = [program, *cell.options]
    return line if cell.ranks == 1 else ["mpirun", "--oversubscribe", "-n", str(cell.ranks), *line]


def numbers_of(cell, text):
    if cell.program == "fault":
        found = {name: re.search(pattern, text) for name, pattern in SUMMARY.items()}
        return {name: float(match[1]) for name, match in found.items() if match}
    pairs = (line.split() for line in text.splitlines())
    return {pair[0]: float(pair[1]) for pair in pairs if len(pair) == 2}


def hopeless(cell, cells):
    """Did the same on a smaller mesh take too long already?"""
    return any(c["status"] == "timeout" and c["n"] < cell.n and c["table"] == cell.table and c["ranks"] == cell.ranks
               and all(c.get(key) == value for key, value in cell.keys.items()) for c in cells.values())


def ended(words, seconds):
    """The end of a command. Where it is stopped it is told so first: an mpirun that is killed leaves its ranks."""
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
        try:
            out, err = run.communicate(timeout=seconds)
        except BaseException:
            run.terminate()
            try:
                run.wait(5)
            except subprocess.TimeoutExpired:
                run.kill()
            raise
    return subprocess.CompletedProcess(words, run.returncode, out, err)


def measure(cell, cells, args):
    """Attributes of the cell: its numbers, or why there are none."""
    begin = time.monotonic()
    result = dict(cell.keys, table=cell.table, n=cell.n, ranks=cell.ranks, status="failed", message="")
    if hopeless(cell, cells):
        return dict(result, status="skipped", message="a smaller size took too long", wall=0.0)
    try:
        done = ended(command(cell, args.build), args.timeout)
        numbers = numbers_of(cell, done.stdout)
        wanted = {"operators": "product", "iterations": "iterations", "runs": "mean_slip"}[cell.table]
        if done.returncode == 0 and wanted in numbers:
            result.update(numbers, status="ok")
        else:
            lines = [line for line in done.stderr.splitlines() if "error" in line] or [f"exit code {done.returncode}"]
            result["message"] = lines[0][:500]
    except subprocess.TimeoutExpired:
        result.update(status="timeout", message=f"not done in {args.timeout:g} s")
    except OSError as error:
        result["message"] = str(error)
    result["wall"] = time.monotonic() - begin
    return result


# ---- the file ----

def load(path):
    """Cells of an earlier benchmark: {name: attributes}."""
    if not os.path.exists(path):
        return {}
    with h5py.File(path) as file:
        return {name: dict(group.attrs) for name, group in file.get("cells", {}).items()}


def column(values):
    if all(isinstance(v, str) for v in values):
        return np.array(values, dtype=h5py.string_dtype())
    return np.array([v if not isinstance(v, str) else np.nan for v in values], dtype=float)


def write_tables(file, cells):
    for table in ("operators", "iterations", "runs"):
        rows = [cells[name] for name in sorted(cells) if cells[name]["table"] == table]
        for key in sorted(set().union(*rows)) if rows else ():
            if key in ("table", "message"):
                continue
            values = [row.get(key, np.nan) for row in rows]
            data = file.create_dataset(f"{table}/{key}", data=column(values))
            if key in UNITS:
                data.attrs["units"] = UNITS[key]


def machine(args):
    def output(*line):
        try:
            return subprocess.run(line, capture_output=True, text=True, cwd=ROOT).stdout.strip()
        except OSError:
            return ""

    model = re.search(r"model name\s*: (.*)", open("/proc/cpuinfo").read()) if os.path.exists("/proc/cpuinfo") else None
    return {"processor": model[1] if model else platform.processor(), "cores": os.cpu_count() or 0,
            "system": platform.platform(), "commit": output("git", "rev-parse", "HEAD"),
            "date": time.strftime("%Y-%m-%d %H:%M:%S %z"),
            "load_average": os.getloadavg()[0], "threads": os.environ.get("OPENBLAS_NUM_THREADS", ""),
            "quick": int(args.quick)}


def store(path, cells, about):
    """To a temporary file that takes the place of the old one, so that it is complete at any time."""
    part = path + ".part"
    with h5py.File(part, "w") as file:
        file.create_group("machine").attrs.update(about)
        for name, cell in cells.items():
            file.create_group(f"cells/{name}").attrs.update(cell)
        write_tables(file, cells)
        slopes = fit_all(cells)
        group = file.create_group("slopes")
        group.create_dataset("quantity", data=np.array([s[0] for s in slopes], dtype=h5py.string_dtype()))
        group.create_dataset("exponent", data=np.array([s[1] for s in slopes], dtype=float))
        group.create_dataset("sizes", data=np.array([s[2] for s in slopes], dtype=int))
    os.replace(part, path)


# ---- what the numbers say ----

def select(cells, table, **keys):
    """Rows that are complete and have these keys, by size."""
    rows = [c for c in cells.values() if c["table"] == table and c["status"] == "ok"
            and all(c.get(k) == v for k, v in keys.items())]
    return sorted(rows, key=lambda c: c["n"])


def fit(rows, quantity, smallest):
    """Exponent a of quantity ~ n^a by least squares in logarithms, and the number of sizes; NaN below two."""
    points = [(math.log(r["n"]), math.log(r[quantity])) for r in rows if r.get(quantity, 0) > 0 and r["n"] >= smallest]
    if len(points) < 2:
        return math.nan, len(points)
    return float(np.polyfit(*zip(*points), 1)[0]), len(points)


def fit_all(cells):
    """(quantity, exponent, sizes) of everything that grows; sizes below 50 are overhead, and left out if there are
    larger ones."""
    smallest = 50 if max((c["n"] for c in cells.values()), default=0) > 50 else 0
    slopes = []
    for kind in LARGEST:
        rows = select(cells, "operators", kind=kind, ranks=1)
        slopes += [(f"{kind} {q}", *fit(rows, q, smallest)) for q in ("setup", "product", "memory")]
    for step in STEPS:
        slopes.append((f"cg iterations at h = {step:g} T*",
                       *fit(select(cells, "iterations", step=step), "iterations", smallest)))
    for controller in ("rl", "heuristic"):
        rows = select(cells, "runs", controller=controller, ranks=1)
        slopes.append((f"run {controller} solve", *fit(rows, "solve", smallest)))
    return [s for s in slopes if s[2] > 0]


def number(value):
    return f"{value:10.3g}" if isinstance(value, (int, float, np.number)) and math.isfinite(value) else f"{'-':>10}"


def show(cells):
    """The tables, as text."""
    titles = {"operators": ("kind", "n", "ranks", "setup", "product", "memory", "resident", "status"),
              "iterations": ("step", "n", "iterations", "solve", "status"),
              "runs": ("controller", "n", "ranks", "solves", "linear", "products_k", "products_h", "mean_slip", "setup",
                       "solve", "resident", "status")}
    for table, keys in titles.items():
        rows = sorted((c for c in cells.values() if c["table"] == table),
                      key=lambda c: (str(c[keys[0]]), c["n"], c["ranks"]))
        print(f"\n{table}\n" + " ".join(f"{k:>10}" for k in keys))
        for row in rows:
            print(" ".join(f"{row[k]:>10}" if isinstance(row.get(k), str) else number(row.get(k)) for k in keys) +
                  (f"  {row['message']}" if row["message"] else ""))
    print("\nspeed-up of 2 ranks")
    for table, key, quantity in (("operators", "kind", "product"), ("runs", "controller", "solve")):
        for two in select(cells, table, ranks=2):
            for one in select(cells, table, ranks=1, n=two["n"], **{key: two[key]}):
                print(f"{two[key]:>10} n = {int(two['n']):<5}" + number(one[quantity] / two[quantity]))
    print("\ngrowth as n^a\n" + f"{'quantity':32} {'a':>10} {'sizes':>6}")
    for quantity, exponent, sizes in fit_all(cells):
        print(f"{quantity:32} {number(exponent)} {sizes:6}")


# ---- all of it ----

def duration(seconds):
    minutes, seconds = divmod(int(seconds + 0.5), 60)
    return f"{minutes // 60} h {minutes % 60} min" if minutes >= 60 else f"{minutes} min {seconds} s"


def run_all(args, cells):
    todo = [c for c in all_cells(args) if c.name not in cells or (args.retry and cells[c.name]["status"] != "ok")]
    about = machine(args)
    total, begin, spent = sum(c.cost for c in todo), time.monotonic(), 0.0
    print(f"{len(todo)} cells to run, {len(cells)} known from {args.output}" if cells else f"{len(todo)} cells to run",
          flush=True)
    for i, cell in enumerate(todo):
        left = (total - spent) * ((time.monotonic() - begin) / spent if spent else 1)
        print(f"[{i + 1}/{len(todo)}] {cell.name:22} about {duration(left)} left", end="  ", flush=True)
        cells[cell.name] = measure(cell, cells, args)
        spent += cell.cost
        print(f"{cells[cell.name]['status']}, {cells[cell.name]['wall']:.1f} s {cells[cell.name]['message']}",
              flush=True)
        store(args.output, cells, about)
    return len(todo)


def main():
    args = arguments()
    args.output = os.path.abspath(args.output)
    for program in ("bin/fault", "tests/operators"):
        if not os.access(os.path.join(args.build, program), os.X_OK):
            sys.exit(f"benchmark: {os.path.join(args.build, program)} is not there: build first, or give --build")
    os.makedirs(os.path.dirname(args.output), exist_ok=True)
    cells = load(args.output)
    try:
        run_all(args, cells)
    except KeyboardInterrupt:
        sys.exit(f"\nbenchmark: stopped; the same command goes on from {args.output}")
    show(cells)
    failed = [name for name, cell in cells.items() if cell["status"] != "ok"]
    print(f"\n{args.output}" + (f"\nnot measured: {', '.join(failed)}" if failed else ""))


if __name__ == "__main__":
    main()
