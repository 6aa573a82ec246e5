#!/usr/bin/env python3
"""Runs that are killed or stopped at random moments and go on: every number of their outputs is the unbroken run's.

    kills.py BUILD [--moments 40] [--signal KILL|TERM|USR1|XCPU] [--seed 1] [--only WORD]

Each case (controller, grid or mesh, number of ranks) is run once unbroken. Then runs of it are ended by the signal at
random moments after the first step, some of them several times over, and continued until they end by themselves, up to
the given number of moments that met a run. All datasets and the attributes of /result are compared bit for bit, but for
wall times and what a restart needs besides. Prints a line a case; exit code 1 when anything differs or a stop was not
announced. test_checkpoint.sh runs it with few moments.
"""
import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time

import h5py
import numpy as np

# The daemon that Open MPI 4 starts for a program without mpirun fills the memory when that program is killed while it
# begins.
os.environ.setdefault("OMPI_MCA_ess_singleton_isolated", "1")
SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
GRID = "-fault_nx 6 -fault_nz 5 -ts_max_time 10"
MESH = "-fault_mesh mesh -fault_viscosity lanczos -ts_max_time 5"
FFT = "-fault_nx 12 -fault_nz 10 -fault_operator fft -ts_max_time 6"
# Waiting for a disk would take most of the time, and a process that is killed leaves what it wrote either way.
MEMORY = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
# name, ranks, options: some hundred steps each
CASES = [("heuristic", 1, GRID + " -ts_rtol 1e-5"),
         ("pi", 1, GRID + " -ts_adapt_type pi -ts_rtol 1e-5"),
         ("rl", 1, GRID + " -ts_adapt_type rl -ts_adapt_dt_max 0.03"),
         ("basic", 1, GRID + " -ts_adapt_type basic -ts_rtol 1e-5"),
         ("dsp", 1, GRID + " -ts_adapt_type dsp -ts_rtol 1e-5"),
         ("doubling", 1, GRID + " -ts_bathe_error doubling -ts_bathe_reaction implicit -ts_rtol 1e-2"),
         ("fft", 1, FFT + " -ts_rtol 1e-4"),
         ("lanczos", 1, FFT + " -fault_viscosity lanczos -ts_rtol 1e-4"),
         ("mesh", 1, MESH + " -ts_rtol 1e-4"),
         ("grid on 2 ranks", 2, "-fault_nx 6 -fault_nz 5 -ts_max_time 4"),
         ("mesh on 2 ranks", 2, MESH + " -ts_rtol 1e-4"),
         ("loaded", 1, "-fault_nx 1 -fault_nz 1 -fault_loading_rate 1e-9 -fault_initial rest -fault_friction_law "
          "rate_weakening -ts_max_time 4e9 -ts_adapt_type rl"),]
# in place of those, by --only, where there is a device of OpenCL
DEVICE = [("device", 1, "-fault_nx 16 -fault_nz 8 -fault_length_x 32e3 -fault_length_z 16e3 -fault_friction_law "
           "rate_and_state -fault_normal_stress 25e6 "
           "-fault_normal_stress_gradient 0 -fault_loading_rate 1e-9 -fault_friction_slip 0.1 -fault_friction_a 0.015 "
           "-fault_friction_b 0.02 " "-ts_max_time 4e9 -fault_device opencl")]
# of a catalogue: of the loaded fault it has many events, in the others one is under way
EVENTS = ["-fault_catalogue_maps", "-fault_catalogue"]


def start(build, ranks, options):
    command = [os.path.join(build, "bin", "fault"), *options]
    if ranks > 1:
        command = ["mpirun", "--oversubscribe", "-n", str(ranks), *command]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def begins(build, ranks, options):
    """Seconds until the first step of a run: Open MPI's start is no moment of a run."""
    begin = time.time()
    run = start(build, ranks, options + ["-ts_monitor"])
    run.stdout.readline()
    first = time.time() - begin
    run.communicate(timeout=1000)
    return first


def processes_of(parent):
    """The programs that mpirun has started."""
    found = []
    for name in os.listdir("/proc"):
        try:
            if name.isdigit() and open(f"/proc/{name}/stat").read().rsplit(")", 1)[1].split()[1] == str(parent):
                found.append(int(name))
        except OSError:
            pass  # it has just ended
    return found


def end(run, ranks, number):
    """SIGKILL to all, another signal to one of the ranks."""
    targets = processes_of(run.pid) if ranks > 1 else [run.pid]
    if number == signal.SIGKILL and ranks > 1:
        targets.append(run.pid)
    elif ranks > 1:
        targets = targets[-1:]
    for pid in targets:
        try:
            os.kill(pid, number)
        except ProcessLookupError:
            pass


def state_exists():
    return os.path.exists("state.h5") or os.path.exists("state.h5.previous")


def broken_run(build, ranks, options, number, moments, interval):
    """Until it ends by itself, ended at the moments [s] after its starts. How many of them met a run."""
    met = 0
    complaint = ""
    for moment in [*moments, None]:
        more = [*EVENTS, "broken_events.h5", "-fault_output", "broken.h5", "-fault_checkpoint", "state.h5",
                "-fault_checkpoint_interval", interval]
        more += ["-fault_restart", "state.h5"] if state_exists() else ["-fault_output_overwrite"]
        run = start(build, ranks, options + more)
        if moment is not None:
            time.sleep(moment)
            if run.poll() is None:
                end(run, ranks, number)
        out, err = run.communicate(timeout=1000)
        if run.returncode == 0 and "nothing is written" in out and os.path.exists("broken.h5.part"):
            # killed after its last checkpoint and before its files had their names, which stay as they are
            return 0, None
        if run.returncode == 0:
            return met, complaint
        met += 1
        if moment is None:
            return met, f"exit code {run.returncode}: {err}"
        if number != signal.SIGKILL and "to continue: " in err and run.returncode != 128 + number:
            complaint = f"exit code {run.returncode} of a run that was stopped: {err}"
        if number != signal.SIGKILL and "stopped by" not in err and run.returncode != -number and ranks == 1:
            complaint = f"exit code {run.returncode}: {err}"  # before the handlers are there it dies of the signal
    return met, complaint


def differences(a, b):
    found = []

    def compare(name, x):
        if not isinstance(x, h5py.Dataset) or name.endswith("wall"):
            return
        # of the same products, but for what a restart computes once more of cells
        if name == "steps/cost" and name in b and x.shape == b[name].shape:
            same = a["steps/products_k"][...] == b["steps/products_k"][...]
            if (abs(x[...] / b[name][...] - 1)[same] > 1e-2).any() or (x[...] != b[name][...]).sum() > 3:
                found.append(name)
            return
        # of what is known of forces a restart may know less or more: two
        if name == "steps/products_k" and name in b and x.shape == b[name].shape:
            if not set(b[name][...] - x[...]) <= {-2, -1, 0, 1, 2}:  # after the last step before a cell rests for years
                found.append(name)
        elif name not in b or x.shape != b[name].shape or x[...].tobytes() != b[name][...].tobytes():
            found.append(name)

    a.visititems(compare)
    if "result" not in a:
        return found
    names = set(a["result"].attrs) | set(b["result"].attrs)
    # with what a restart makes again
    for name in sorted(n for n in names if not n.startswith(("wall", "cost", "processor_time", "products", "device"))):
        if name not in a["result"].attrs or name not in b["result"].attrs:
            found.append("result:" + name)
        elif np.asarray(a["result"].attrs[name]).tobytes() != np.asarray(b["result"].attrs[name]).tobytes():
            found.append("result:" + name)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build")
    parser.add_argument("--moments", type=int, default=40)
    parser.add_argument("--signal", default="KILL")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    args = parser.parse_args()
    build = os.path.abspath(args.build)
    number = getattr(signal, "SIG" + args.signal)
    chance = random.Random(args.seed)
    failed = False
    for name, ranks, options in DEVICE if args.only == "device" else CASES:
        if args.only and args.only not in name:
            continue
        options = options.split()
        with tempfile.TemporaryDirectory(dir=MEMORY) as folder:
            os.chdir(folder)
            os.environ["TMPDIR"] = folder  # of Open MPI, away from other runs
            make = [sys.executable, os.path.join(SOURCE, "examples", "make_mesh.py"), "mesh", "parallel"]
            make += ["--cells", "6", "6", "--ratio", "3", "--offset", "1000", "--shift", "500"]
            subprocess.run(make, check=True, stdout=subprocess.DEVNULL)
            begin = time.time()
            whole = start(build, ranks, options + [*EVENTS, "whole_events.h5", "-fault_output", "whole.h5"])
            out, err = whole.communicate(timeout=1000)
            if whole.returncode:
                print(f"{name}: exit code {whole.returncode}: {err}")
                failed = True
                continue
            wall = time.time() - begin
            first = min(begins(build, ranks, options) for _ in range(3))
            met = wrong = runs = 0
            while met < args.moments and not wrong:
                runs += 1
                for left in [f for f in os.listdir(".") if f.startswith(("broken", "state"))]:
                    os.remove(left)
                moments = [chance.uniform(first, wall) for _ in range(chance.choice([1, 1, 2, 3]))]
                n, complaint = broken_run(build, ranks, options, number, moments,
                                          chance.choice(["0.01", "0.05", "0.2"]))
                met += n
                if complaint is None:
                    continue
                if not n:  # it may be faster than those that were measured, beside less other work
                    first, wall = 0.9 * first, 0.9 * wall
                if not complaint:
                    for end_of_name in (".h5", "_events.h5"):
                        with h5py.File("whole" + end_of_name) as a, h5py.File("broken" + end_of_name) as b:
                            complaint += ", ".join(differences(a, b))
                if complaint:
                    wrong += 1
                    print(f"{name}: ended at {moments}: {complaint}")
            with h5py.File("whole.h5") as a:
                steps, events = int(a["result"].attrs["accepted"]), int(a["result"].attrs["events"])
            print(f"{name}: {steps} steps, {events} events, {runs} runs ended {met} times by SIG{args.signal}, "
                  f"{wrong} wrong", flush=True)
            failed = failed or wrong > 0
            os.chdir("/")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
