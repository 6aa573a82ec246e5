#!/usr/bin/env python3
"""Every option of ours, by kind of run: obeyed, refused, or named as without effect.

    effects.py BUILD [--all] [--only OPTION] [--kind WORD] [--jobs 2]

The options are those that `fault -help fault` and the small programs list for each kind of run, and those of all kinds
together.
Each is given other values than its own to a run of each kind. An option is

    obeyed   if something of the result differs: numbers of the files, names of files and datasets, or what is printed,
    refused  if the run ends with an error,
    named    if nothing differs, and a warning has its name.

Nothing of these is a fault, and so is a warning beside another result. Prints a table with a row an option, and the
faults below it; the exit code is their number. Without --all a few options and kinds, which test_effects.sh runs.
"""
import argparse
import concurrent.futures
import os
import re
import shutil
import subprocess
import sys
import tempfile

import h5py
import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from kills import MEMORY

os.environ.setdefault("OMPI_MCA_ess_singleton_isolated", "1")
YEAR = 3.15576e7  # [s]
NX, NZ = 6, 4
GRID = f"-fault_nx {NX} -fault_nz {NZ}"
CELLS = f"{GRID} -fault_length_x 6000 -fault_length_z 4000"
PATCH = (f"{CELLS} -fault_normal_stress 50e6 -fault_normal_stress_gradient 0 -fault_initial traction -fault_parameters "
         "patch.h5 -fault_initial_unstable")
LOADED = (f"{CELLS} -fault_normal_stress 50e6 -fault_normal_stress_gradient 0 -fault_initial traction "
          f"-fault_parameters loaded.h5 -fault_loading_rate 1e-9 -fault_healing_time {YEAR} -ts_max_time {7 * YEAR}")
SMOOTH = (f"{CELLS} -fault_friction_law rate_and_state -fault_normal_stress 50e6 -fault_normal_stress_gradient 0 "
          "-fault_loading_rate 1e-9 -fault_friction_slip 0.02 -fault_friction_b 0.02 -fault_parameters smooth.h5 "
          f"-ts_max_time {20 * YEAR}")
FILES = "-fault_output run.h5 -fault_catalogue events.h5"
# kind -> program, options: friction law, inertia, loading, planes, controller
KINDS = {"event": ("fault", f"{GRID} -ts_max_time 12 {FILES}"),
         "event, heuristic": ("fault", f"{GRID} -ts_max_time 12 -ts_adapt_type heuristic {FILES}"),
         "event, pi": ("fault", f"{GRID} -ts_max_time 12 -ts_adapt_type pi {FILES}"),
         "event, constant steps": ("fault", f"{GRID} -ts_max_time 12 -ts_adapt_type none -ts_dt 0.2 {FILES}"),
         "event, rate weakening": ("fault", f"{GRID} -fault_friction_law rate_weakening -ts_max_time 5 {FILES}"),
         "rupture": ("fault", f"{PATCH} -ts_max_time 5 {FILES}"),
         "rupture, inertia": ("fault", f"{PATCH} -fault_inertia yes -ts_max_time 5 {FILES}"),
         "loaded": ("fault", f"{LOADED} {FILES}"),
         "loaded, inertia": ("fault", f"{LOADED} -fault_inertia yes {FILES}"),
         "injection": ("fault",
                       f"{CELLS} -fault_friction_law constant -fault_initial traction -fault_initial_traction 20e6 "
                       "-fault_normal_stress 50e6"
                       " -fault_normal_stress_gradient 0 -fault_injection 3000,2000 -fault_injection_pressure 2e7 "
                       f"-fault_injection_diffusivity 0.1 -ts_max_time 90d {FILES}"),
         "rate and state": ("fault", f"{SMOOTH} {FILES}"),
         "rate and state, bathe": ("fault", f"{SMOOTH} -ts_type bathe {FILES}"),
         "rate and state, rk": ("fault", f"{SMOOTH} -ts_type rk -ts_adapt_type pi {FILES}"),
         "thrust": ("fault", f"{GRID} -fault_dip 35 -fault_rake 90 -ts_max_time 30 {FILES}"),
         "opening": ("fault", f"{PATCH} -fault_slip_components 2 -fault_opening -ts_max_time 3 {FILES}"),
         "mesh": ("fault", f"-fault_mesh mesh.h5 -ts_max_time 30 {FILES}"),
         "circuit": ("circuit", "-circuit_output run.h5"),
         "sliding mode": ("sliding_mode", "-sliding_mode_output run.h5"),
         "oscillator": ("oscillator", "-oscillator_output run.h5"),}
POLICIES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "training", "policies")
QUICK_KINDS = ("event", "loaded", "rate and state")
QUICK = ("ts_bathe_gamma", "ts_bathe_reaction", "ts_bathe_order", "ts_adapt_pi_g1", "ts_adapt_rl_accuracy",
         "fault_accuracy", "fault_healing_time")

# Values that are no multiples of the default: files that must exist, lists, and numbers that only mean something near
# some value
VALUES = {"fault_parameters": ["other.h5"],
          "fault_mesh": ["other_mesh.h5"],
          "fault_pore_pressure": ["pressure.h5"],
          "fault_stiffness_file": ["stiffness.h5"],
          "fault_injection": ["1000,1000"],
          "fault_sweep": ["sweep.txt"],
          "fault_cells": ["cells.h5"],
          "fault_restart": ["state.h5"],
          "fault_tolerances": ["tolerances.h5"], "fault_estimates": ["estimates.h5"],
          "fault_stations": ["500,500"],
          "fault_surface_stations": ["500,500"],
          "fault_output": ["other_run.h5"],
          "fault_catalogue": ["other_events.h5"],
          "fault_checkpoint": ["other_state.h5"],
          "fault_output_fields": ["slip"],
          "fault_rake": ["30"], "fault_strike": ["40"], "fault_dip": ["60"],
          "fault_creep": ["1"],
          "fault_initial_rate": ["2e-9"], "fault_initial_state": ["1e6"],
          "fault_initial_traction": ["1e7"],
          "fault_stressing_rate": ["1e5", "1e-3"],
          "fault_loading_rate": ["1e-2", "2e-9"],
          "fault_healing_time": ["5", "2e7"],
          "fault_output_time_interval": ["2", "3e7"], "fault_output_slip_interval": ["0.01"],
          "fault_output_rate_change": ["1.5"], "fault_output_size": ["3000"],
          "fault_accuracy": ["2e-3", "5e-2"], "ts_adapt_rl_accuracy": ["2e-3", "5e-2"],
          "fault_wall_limit": ["1e-3"],
          "ts_adapt_rl_policy": ["policy.h5"], "ts_adapt_rl_problem": ["rupture", "ode"],
          "ts_adapt_rl_measure": ["final_slip"], "ts_adapt_rl_error_ceiling": ["1e-3"],
          "ts_adapt_dt_max": ["0.05", "1e5", "1e-3"], "ts_adapt_dt_min": ["1", "1e7"],
          "ts_bathe_max_failures": ["1"], "mat_slipfft_depth": ["blocks", "transform"],
          "pc_slipstage_type": ["diagonal"],
          "snes_slip_direct_max": ["0"],
          "ts_max_steps": ["3"], "ts_type": ["bathe", "rk", "adams"],
          "snes_type": ["projection", "newtonls"],
          "circuit_start": ["1,1,1"], "circuit_output": ["other_run.h5"], "sliding_mode_output": ["other_run.h5"],
          "oscillator_output": ["other_run.h5"], "fault_view": [""], "fault_stiffness_view": [":k.txt"],}
# Options that nothing of these runs can show, and why
ARGUED = {"slip_traceback": "shows where an error happened: there is none",
          "fault_progress": "lines by wall time: these runs are over before the first",
          "fault_output_overwrite": "of an unfinished file: there is none",
          "fault_checkpoint_interval": "wall time between checkpoints: these runs are over before",
          "mat_slip_share": "spreads wavenumbers over ranks: there is one",
          "ts_bathe_max_failures": "of solves that fail, which these runs have not",
          "ts_adapt_rl_max_failures": "likewise",
          "ts_adapt_heuristic_failure_factor": "likewise", "ts_adapt_pi_failure_factor": "likewise",
          "ts_adapt_rl_strict": "of runs that are handed over",
          "mat_slipfft_depth": "another way to the same product",
          "snes_slip_direct_max": "another way to the same solution, of operators with rows at hand",
          "fault_thickness": "without inertia the time scale of first steps and tolerances, which may not show",
          "fault_rate_tolerance": "far below the slip rates of some of these runs",
          "ts_adapt_dt_min": "ends a run that would go below",
          "ts_dt": "of a fault that rests first, whose first step is the rest",
          "circuit_unit": "of what policies observe",
          "circuit_output_overwrite": "of an unfinished file", "sliding_mode_output_overwrite": "likewise",}


def write_inputs():
    x, z = np.meshgrid(np.arange(NX) + 0.5, np.arange(NZ) + 0.5)
    inner = (x > 1) & (x < NX - 1) & (z < NZ - 1)
    with h5py.File("patch.h5", "w") as file:
        file["initial_traction"] = np.where((x > 2) & (x < 4) & (z > 1) & (z < 3), 31e6, 26e6)
    chance = np.random.default_rng(5)
    with h5py.File("loaded.h5", "w") as file:
        file["friction_drop"] = 0.05 + 0.05 * chance.random((NZ, NX))
        file["friction_slip"] = np.full((NZ, NX), 0.05)
        file["initial_traction"] = 50e6 * (0.5 + 0.045 * chance.random((NZ, NX)))
    with h5py.File("smooth.h5", "w") as file:
        file["friction_a"] = np.where(inner, 0.012, 0.028)
        file["initial_rate"] = np.where((x < 3) & inner, 3e-9, 1e-9)
    with h5py.File("other.h5", "w") as file:
        file["normal_stress"] = np.where(x < NX / 2, 48e6, 52e6)
    with h5py.File("pressure.h5", "w") as file:
        file["time"] = [0.0, 1.0, 2.0]
        file["pressure"] = np.stack([np.zeros((NZ, NX)), np.full((NZ, NX), 1e5), np.full((NZ, NX), 2e5)])
    with h5py.File("stiffness.h5", "w") as file:
        n = NX * NZ
        file["stiffness"] = 3e7 * (np.eye(n) + 0.1 * np.exp(-np.abs(np.subtract.outer(np.arange(n), np.arange(n)))))
    with h5py.File("mesh.h5", "w") as file:
        file["cells"] = np.stack([(500.0 * x).ravel(), np.zeros(NX * NZ), (500.0 * z).ravel(), np.full(NX * NZ, 500.0),
                                  np.full(NX * NZ, 500.0)], 1)
        file["cells"].attrs["columns"] = "x y z length width"
    with h5py.File("other_mesh.h5", "w") as file:
        file["cells"] = np.array([(50.0 + 500 * k, 0, 250, 500, 500) for k in range(3)])
        file["cells"].attrs["columns"] = "x y z length width"
    for name, numbers in (("tolerances.h5", ("event/rtol", "rupture/rtol", "sequence/rtol", "injection/rtol")),
                          ("estimates.h5", ("factor",))):
        shutil.copy(os.path.join(POLICIES, name), name)
        with h5py.File(name, "a") as file:
            for path in numbers:
                file[path][...] *= 0.5
    with open("sweep.txt", "w", encoding="utf-8") as file:
        file.write("-fault_nx 2 -fault_nz 2\n")


def help_of(program, build, options):
    """name -> (type, default, choices) of the options of SlipStep"""
    done = subprocess.run([os.path.join(build, "bin", program), *options.split(), "-help", program],
                          capture_output=True, text=True, check=True)
    found = {}
    for line in done.stdout.splitlines():
        match = re.match(r"\s+-(\w+)(:?)(.*)", line)
        if (not match or match[1].startswith(("help", "options_file")) or "[:[filename]" in line
            or "[:drawtype]" in line or "[:port]" in line):
            continue
        name, rest = match[1], match[3]
        now = re.search(r"<(?:now )?(.*?) : ", rest)
        choices = re.search(r"(?:; one of|\(one of\)|\(choose one of\)) ([^()]*)", rest)
        words = re.split(r"[, ]+", choices[1].strip()) if choices else []
        found.setdefault(name, (match[2] == ":", now[1] if now else "", words))
    return found


def values(name, switch, default, choices):
    if name in VALUES:
        return VALUES[name]
    if switch and default in ("FALSE", "TRUE"):
        return ["yes", "no"]
    if choices:
        return [word for word in choices if word != default]
    try:
        number = float(default)
    except ValueError:
        return []
    if number == 0:
        return ["1"]
    if re.fullmatch(r"-?\d+", default):
        return [str(int(number) + 1), str(max(int(number) // 2, 1))] if number != 1 else ["2"]
    return [repr(number * 1.3), repr(number * 0.7), repr(number * 100)]


RESULTS = ("run", "events", "other_", "k.txt")
NOISE = re.compile(r"^(wall time|products with K: .* s).*$|^.*\b[0-9.]+ s wall.*$", re.M)


def result(folder):
    """What a run left there: names of files, and every number of those that are HDF5, but for wall times"""
    found = {}
    for name in sorted(os.listdir(folder)):
        if name.startswith(RESULTS):
            found[name] = b""
        if not name.startswith(RESULTS) or not name.endswith(".h5") or name == "other_state.h5":
            continue
        with h5py.File(os.path.join(folder, name)) as file:
            def visit(path, item):
                if (isinstance(item, h5py.Dataset) and path not in ("steps/wall", "steps/cost")
                    and not path.startswith(("xdmf", "mesh"))):
                    data = str(item[...].tolist()).encode() if item.dtype.kind == "O" else item[...].tobytes()
                    found[f"{name}/{path}"] = (str(item.dtype), item.shape, item.compression_opts, data)
            file.visititems(visit)
            for group in ("mesh", "result"):
                attributes = file[group].attrs.items() if group in file else ()
                found |= {f"{name}/{group}@{key}": str(value) for key, value in attributes
                          if not key.startswith(("wall", "cost", "processor_time"))}
    return found


def run(build, program, options, more, inputs):
    with tempfile.TemporaryDirectory(dir=MEMORY) as folder:
        for name in os.listdir(inputs):
            os.symlink(os.path.join(inputs, name), os.path.join(folder, name))
        for _ in range(5):
            done = subprocess.run([os.path.join(build, "bin", program), *options.split(), *more], capture_output=True,
                                  text=True, cwd=folder, timeout=20)
            if "MPI_Init" not in done.stderr:  # two programs that begin at the same moment may disturb each other
                break
        return done.returncode, NOISE.sub("", done.stdout), done.stderr, result(folder)


def try_option(build, program, options, option, tries, base, inputs):
    """[value, verdict] of the values up to the first that is obeyed"""
    found = []
    for value in tries:
        more = [f"-{option}", *([value] if value else [])]
        try:
            found.append((value, judge(option, base, run(build, program, options, more, inputs))))
        except subprocess.TimeoutExpired:
            found.append((value, "obeyed"))  # the base takes a second
        if found[-1][1] not in ("silent", "refused", "named"):
            break
    return found


def judge(name, base, other):
    """obeyed, refused, named or what is wrong; what differs"""
    code, out, err, left = other
    if code not in (0, 3, 152):
        return "refused" if "error:" in err else f"exit code {code}: {out[-200:]} {err[-500:]}"
    warned = re.search(rf"warning: (nothing has read the option -{name}\b|-{name}( \S+)? (has no effect|does nothing))",
                       err)
    differ = code != base[0] or left != base[3]
    if differ or (out != base[1] and not warned):
        return "obeyed" if not warned else "warned of, yet the result differs"
    return "named" if warned else "silent"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("--kind", default="")
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    build = os.path.abspath(args.build)
    every = args.all or args.only or args.kind
    kinds = {name: kind for name, kind in KINDS.items() if (args.kind in name if every else name in QUICK_KINDS)}
    faults, table = [], {}
    with tempfile.TemporaryDirectory(dir=MEMORY) as inputs:
        os.chdir(inputs)
        write_inputs()
        subprocess.run([os.path.join(build, "bin", "fault"),
                        *f"{GRID} -ts_max_time 1 -fault_checkpoint state.h5".split()], capture_output=True, check=True)
        shutil.copy(os.path.join(POLICIES, "..", "study", "policies", "fault_tqc_alpha0.5.h5"), "policy.h5")
        lists = {name: help_of(program, build, options) for name, (program, options) in kinds.items()}
        union = {}
        for name, (program, _) in kinds.items():
            for option, row in lists[name].items():
                union.setdefault(program, {}).setdefault(option, row)
        with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
            bases = dict(zip(kinds, pool.map(lambda kind: run(build, *kind, [], inputs), kinds.values())))
            for name, base in bases.items():
                if base[0] not in (0, 3):
                    sys.exit(f"{name}: exit code {base[0]}: {base[2]}")
            for name, (program, options) in kinds.items():
                wanted = {o: values(o, *lists[name].get(o, row)) for o, row in union[program].items() if args.only in o
                          and (every or o in QUICK)}
                found = pool.map(lambda o: try_option(build, program, options, o, wanted[o], bases[name], inputs),
                                 wanted)
                for option, tried in zip(wanted, found):
                    table.setdefault(option, {})[name] = tried
                    if not tried or tried[-1][1] not in ("obeyed", "refused", "named"):
                        print(name, option, tried, flush=True)
    for option, row in table.items():
        for name, found in row.items():
            verdicts = {verdict for _, verdict in found}
            bad = verdicts - {"obeyed", "refused", "named", "silent"}
            if verdicts == {"silent"} and option not in ARGUED:
                bad = {"silent"}
            if bad:
                faults.append(f"{name}: -{option} {found}")
    for option, row in table.items():
        print(f"| {option} | " + "; ".join(f"{name}: {'/'.join(sorted({v for _, v in found}))}"
                                           for name, found in row.items()) + " |")
    for line in faults:
        print("FAULT", line)
    return min(len(faults), 99)


if __name__ == "__main__":
    sys.exit(main())
