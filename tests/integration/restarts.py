#!/usr/bin/env python3
"""Restart to the bit: runs that go on from a checkpoint against the unbroken run, for every integrator and controller.

    restarts.py BUILD [--all] [--moments 3] [--seed 1] [--only WORD] [--steps]

Each case is run unbroken, without checkpoints. Then, for each moment, it is stopped after a number of steps
(-ts_max_steps) and goes on to its end from its checkpoint; every other time it goes on for two steps first, and then
from the checkpoint that was written between these, and once more where that one is written right before all cells come
to rest. All datasets of output and catalogue, stations on the fault and on the ground and maps included, and the
attributes of /result are compared bit for bit, wall times aside. Prints a table with a row a case: steps, events, and
for each moment the number of datasets and attributes that differ. The exit code is 1 unless all are 0. Without --all a
few cases, which test_restarts.sh runs; --steps prints where series first differ.
"""
import argparse
import os
import random
import subprocess
import sys
import tempfile

import h5py
import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from kills import MEMORY, differences

os.environ.setdefault("OMPI_MCA_ess_singleton_isolated", "1")
NX, NZ = 8, 4
YEAR = 3.15576e7  # [s]
STEPS = 1200  # of a run at most
CONTROLLERS = ("basic", "pi", "dsp", "heuristic", "rl")
# Rate and state: cells of 1 km, those inside weaken with slip rate; a patch starts faster. Some events.
RATE_STATE = f"""-fault_nx {NX} -fault_nz {NZ} -fault_length_x 8000 -fault_length_z 4000
 -fault_friction_law rate_and_state -fault_normal_stress 50e6 -fault_normal_stress_gradient 0 -fault_loading_rate 1e-9
 -fault_friction_slip 0.02 -fault_friction_b 0.02
 -fault_parameters rate_state.h5 -ts_max_time {60 * YEAR}"""
# Slip weakening and healing under loading, as examples/fault_centuries.opts
WEAKENING = f"""-fault_nx {NX} -fault_nz {NZ} -fault_length_x 8000 -fault_length_z 4000
 -fault_inertia no -fault_viscosity radiation
 -fault_normal_stress 50e6 -fault_normal_stress_gradient 0 -fault_friction_residual 0.5 -fault_initial traction
 -fault_loading_rate 1e-9 -fault_healing_time {YEAR} -fault_parameters weakening.h5 -ts_max_time {10 * YEAR}"""
# A rupture of the same, and its rest
RUPTURE = WEAKENING.replace(f"-fault_healing_time {YEAR}",
                            "-fault_healing_time 1e5 -fault_initial_unstable -fault_stressing_rate 1").replace(
f"-ts_max_time {10 * YEAR}", "-ts_max_time 2e4").replace("weakening.h5", "rupture.h5")
# A single event under inertia
INERTIA = f"-fault_nx {NX} -fault_nz {NZ} -ts_max_time 8"
# The same of more cells, whose root is factorised after some products
ROOTS = "-fault_nx 12 -fault_nz 8 -fault_operator fft -ts_rtol 1e-5 -ts_max_time 12 -fault_stations 500,500;1500,1500"
# The same on a dipping plane, whose normal stress slip changes
THRUST = " -fault_dip 35 -fault_rake 90 -fault_stations 1500,1500;6500,2000"
# The same with slip as a vector, along strike and up dip
VECTORS = THRUST.replace("-fault_rake 90", "-fault_rake 60") + " -fault_slip_components 2"
# Cells of two lengths of weakening, which the policy does not know: it hands over at once
HANDED = f"-fault_nx {NX} -fault_nz {NZ} -fault_parameters two_lengths.h5 -ts_max_time 15"
LAST = ["-ts_max_steps", str(STEPS)]  # some of these controllers do not end, with steps of a rounding
COMMON = ("-fault_stations 1500,1500;6500,2500 -fault_surface_stations 1000,2000;500,-700 -fault_catalogue_maps "
          "-fault_output_interval 7")


def cases():
    """name -> options"""
    found = {}
    for table in ("2a", "3bs", "5f", "5dp", "5bs"):
        for controller in CONTROLLERS:
            rtol = "1e-2" if table == "2a" else "1e-3"
            found[f"rk {table} {controller}"] = (f"{RATE_STATE} -ts_type rk -ts_rk_type {table} -ts_rtol {rtol} "
                                                 f"-ts_adapt_type {controller}")
    for controller in CONTROLLERS:
        found[f"adams {controller}"] = f"{RATE_STATE} -ts_type adams -ts_adapt_type {controller}"
        found[f"bathe, rate and state, {controller}"] = f"{RATE_STATE} -ts_type bathe -ts_adapt_type {controller}"
        found[f"bathe, weakening, {controller}"] = f"{WEAKENING} -ts_adapt_type {controller}"
        found[f"adams, thrust, {controller}"] = f"{RATE_STATE}{THRUST} -ts_type adams -ts_adapt_type {controller}"
        found[f"bathe, weakening, thrust, {controller}"] = f"{WEAKENING}{THRUST} -ts_adapt_type {controller}"
        found[f"bathe, one event, {controller}"] = (f"{INERTIA} -ts_adapt_type {controller} -fault_stations "
                                                    "500,500;1500,1500")
        found[f"moreau, one event, {controller}"] = (f"{INERTIA} -ts_type moreau -ts_adapt_type {controller} "
                                                     "-fault_stations 500,500;1500,1500")
        # explicit steps, and implicit ones at rest
        found[f"auto, one event, {controller}"] = (f"{INERTIA} -ts_max_time 30 -ts_bathe_method auto -ts_adapt_type "
                                                   f"{controller} -fault_stations 500,500;1500,1500")
        found[f"moreau, weakening, thrust, {controller}"] = (f"{WEAKENING}{THRUST} -fault_inertia yes -ts_type moreau "
                                                             f"-ts_adapt_type {controller}")
        found[f"adams, vectors, {controller}"] = f"{RATE_STATE}{VECTORS} -ts_type adams -ts_adapt_type {controller}"
    for kind in ("rkc", "adams", "rk"):
        found[f"{kind}, weakening"] = f"{RUPTURE} -ts_type {kind}"
        found[f"{kind}, weakening, vectors"] = f"{RUPTURE}{VECTORS} -ts_type {kind}"
        found[f"{kind}, weakening, thrust"] = f"{RUPTURE}{THRUST} -ts_type {kind}"
    for controller in CONTROLLERS: # the exact root by Lanczos' method, and factorised on the way
        found[f"one event, roots, {controller}"] = f"{ROOTS} -ts_adapt_type {controller}"
    found["one event, roots, explicit"] = f"{ROOTS} -ts_bathe_method explicit -ts_adapt_type none -ts_dt 0.02"
    found["handed over"] = f"{HANDED} -fault_stations 500,500;1500,1500"
    return found


QUICK = ("handed over", "adams, thrust, rl", "adams, vectors, rl", "bathe, weakening, thrust, dsp", "rk 3bs pi", "rk "
         "5dp basic", "rk 2a dsp", "adams rl", "bathe, weakening, heuristic", "moreau, weakening, thrust, dsp",
         "auto, one event, pi", "moreau, one event, rl", "rkc, weakening", "rkc, weakening, vectors",
         "rk, weakening, vectors")


def write_fields():
    """The fields of the two kinds of faults."""
    x, z = np.meshgrid(np.arange(NX) + 0.5, np.arange(NZ) + 0.5)
    inner = (x > 1) & (x < NX - 1) & (z < NZ - 1)
    with h5py.File("rate_state.h5", "w") as file:
        file["friction_a"] = np.where(inner, 0.012, 0.028)
        file["initial_rate"] = np.where((x < 3) & inner, 3e-9, 1e-9)
    with h5py.File("two_lengths.h5", "w") as file:
        file["friction_slip"] = np.where(x < NX / 2, 0.1, 0.2)
    chance = np.random.default_rng(5)
    with h5py.File("weakening.h5", "w") as file:
        file["friction_drop"] = 0.05 + 0.05 * chance.random((NZ, NX))
        file["friction_slip"] = np.full((NZ, NX), 0.05)
        file["initial_traction"] = 50e6 * (0.5 + 0.045 * chance.random((NZ, NX)))
    with h5py.File("rupture.h5", "w") as file:
        file["friction_drop"] = np.full((NZ, NX), 0.1)
        file["friction_slip"] = np.full((NZ, NX), 0.1)
        file["initial_traction"] = 50e6 * np.where(x < 3, 0.602, 0.57)


def run(build, options, expected, *more):
    done = subprocess.run([os.path.join(build, "bin", "fault"), *COMMON.split(), *options.split(), *more],
                          capture_output=True, text=True)
    if done.returncode not in expected:
        sys.exit(f"exit code {done.returncode} of {options} {' '.join(more)}:\n{done.stdout[-2000:]}{done.stderr}")
    return done


def files(name):
    return "-fault_output", name + ".h5", "-fault_catalogue", name + "_events.h5"


def first_difference():
    with h5py.File("whole.h5") as a, h5py.File("broken.h5") as b:
        for name in ("series/time", "series/mean_slip_rate", "series/mean_displacement"):
            x, y = a[name][...], b[name][...]
            n = min(len(x), len(y))
            wrong = np.flatnonzero(x[:n] != y[:n])
            if len(wrong) or len(x) != len(y):
                k = wrong[0] if len(wrong) else n
                print(f"    {name}: {len(x)} and {len(y)} rows, first at {k}, relative there "
                      f"{abs(y[k] / x[k] - 1) if k < n else 0:.1e}," f" at the end {abs(y[n - 1] / x[n - 1] - 1):.1e}")


def broken_run(build, options, step, between, show):
    """Stopped after a step and gone on with; or once more from the checkpoint that was written between two steps after
    that. How many things differ."""
    for left in [f for f in os.listdir(".") if f.startswith(("broken", "state"))]:
        os.remove(left)
    stop = [*files("broken"), "-fault_checkpoint", "state.h5", "-ts_max_steps"]
    run(build, options, [3], *stop, str(step))
    if between:
        run(build, options, [3], *stop, str(step + 2), "-fault_restart", "state.h5", "-fault_checkpoint_interval", "0")
        os.replace("state.h5.previous", "state.h5")
    run(build, options, [0, 3], *files("broken"), *LAST, "-fault_restart", "state.h5")
    found = []
    for end in (".h5", "_events.h5"):
        with h5py.File("whole" + end) as a, h5py.File("broken" + end) as b:
            found += differences(a, b)
    if found and show:
        print(f"    after {step} steps: {', '.join(found)}")
        first_difference()
    return len(found)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--moments", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--steps", action="store_true")
    args = parser.parse_args()
    build = os.path.abspath(args.build)
    failed = 0
    print("| integrator and controller | steps | rejected | events | restarted after | differ |\n"
          "|---|---|---|---|---|---|")
    for name, options in cases().items():
        if args.only not in name or not (args.all or args.only or name in QUICK):
            continue
        chance = random.Random(f"{args.seed} {name}")
        with tempfile.TemporaryDirectory(dir=MEMORY) as folder:
            os.chdir(folder)
            write_fields()
            run(build, options, [0, 3], *files("whole"), *LAST)
            with h5py.File("whole.h5") as file:
                steps, result = int(file["result"].attrs["accepted"]), dict(file["result"].attrs)
                errors = file["steps/error"][...][file["steps/accepted"][...] > 0]
            moments = sorted(chance.sample(range(3, steps - 4), args.moments))
            found = [broken_run(build, options, step, k % 2, args.steps) for k, step in enumerate(moments)]
            rests = np.flatnonzero((errors[4:-1] >= 0) & (errors[4:-1] <= 1e-10))  # steps without a solve
            if len(rests):
                moments.append(int(rests[0]) + 3)
                found.append(broken_run(build, options, moments[-1], True, args.steps))
            os.chdir("/")
        print(f"| {name} | {steps} | {int(result['rejected'])} | {int(result['events'])} | "
              f"{', '.join(map(str, moments))} | " f"{', '.join(map(str, found))} |", flush=True)
        failed += sum(found) > 0
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
