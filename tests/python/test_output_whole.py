"""Whatever happens to a run, its output holds whole rows that any reader opens: it is killed, or its disk fills, at
random moments.

MOMENTS of each kind (default 3), drawn by a SEED: test_output_whole.py [MOMENTS [SEED]]; 20 is what a release shows."""

import os
import random
import resource
import subprocess
import sys
import tempfile
import time

from scripts import FAULT, PROGRAM

import h5py
import numpy as np

# The daemon that Open MPI 4 starts for a program without mpirun fills the memory when that program is killed while it
# begins.
os.environ.setdefault("OMPI_MCA_ess_singleton_isolated", "1")
# Open MPI 5 begins with a file of 16 MB in /dev/shm for its messages, under the limits of sizes below too, whose signal
# ends the process within MPI_Init(); and what is killed leaves that file, which a later process whose random name is
# the same takes as its own, without the signal.
os.environ["OMPI_MCA_btl"] = "self"  # runs on one rank send nothing
MOMENTS = int(sys.argv[1]) if len(sys.argv) > 1 else 3
STEP, STEPS = 0.0625, 480  # [s]; 3.2 kB of fields a step
RUN = [FAULT, "-fault_nx", "10", "-fault_nz", "10", "-ts_adapt_type", "none", "-ts_bathe_error", "none", "-ts_dt",
       str(STEP), "-fault_output_interval", "1", "-fault_output_overwrite"]
random.seed(int(sys.argv[2]) if len(sys.argv) > 2 else 11)


def check_rows(path, *complete):
    """The rows of a file of RUN: no gap, no zero. Their number."""
    with h5py.File(path, "r") as file:  # a plain reader
        assert file.attrs["complete"] in complete, (path, file.attrs["complete"])
        assert b"-ts_dt" in file["run"].attrs["options"] and file["run"].attrs["ranks"] == 1
        rows = {name: min(len(dataset) for dataset in file[name].values()) for name in ("steps", "series", "fields")}
        steps, series, fields = ({key: dataset[:rows[name]] for key, dataset in file[name].items()} for name in rows)
        assert file["mesh/normal_stress"].shape == (10, 10)
    assert np.array_equal(steps["time"], STEP * np.arange(rows["steps"])) and np.all(steps["dt"] == STEP), path
    assert np.all(steps["accepted"] == 1) and np.all(steps["solves"] == 1)
    assert np.array_equal(series["time"], STEP * np.arange(rows["series"])), path
    assert (np.all(series["mean_slip"][1:] > 0) and not series["mean_slip"][:1].any()
            and np.all(series["elastic_energy"] > 0))
    assert np.array_equal(fields["time"], STEP * np.arange(rows["fields"])), path
    assert np.all(fields["traction"] != 0) and np.all(fields["displacement"]
                                                      != 0) and np.all(fields["slip"][1:] > 0), path
    return rows["steps"]


def clean(folder):
    for name in os.listdir(folder):
        os.remove(os.path.join(folder, name))


def killed(folder, *more):
    """SIGKILL: the file that is there, if any, can be read by everybody."""
    clean(folder)
    begin = time.monotonic()
    subprocess.run(RUN + ["-fault_output", "run.h5", *more], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    length = time.monotonic() - begin
    assert check_rows(os.path.join(folder, "run.h5"), 1) == STEPS
    found = []
    for _ in range(2 * MOMENTS):
        clean(folder)
        run = subprocess.Popen(RUN + ["-fault_output", "run.h5", *more], cwd=folder, stdout=subprocess.DEVNULL)
        time.sleep(random.uniform(0, length))
        run.kill()
        run.wait()
        part, whole = (os.path.join(folder, name) for name in ("run.h5.part", "run.h5"))
        assert not (os.path.exists(part) and os.path.exists(whole))
        if os.path.exists(part):
            found.append(check_rows(part, 0, 1))  # 1 just before it gets its name
        elif os.path.exists(whole):
            found.append(check_rows(whole, 1))
    print(f"killed {2 * MOMENTS} times, {' '.join(more) or 'as by default'}: rows {found}")


def read_by_scripts(folder):
    """plot-run and compare take an unfinished file and say that it is; a new run refuses to overwrite it."""
    clean(folder)
    endless = ["-fault_output", "run.h5", "-ts_max_time", str(10000 * STEPS * STEP), "-ts_max_steps",
               str(10000 * STEPS)]
    run = subprocess.Popen(RUN + endless, cwd=folder, stdout=subprocess.DEVNULL)
    rows = 0
    while rows < 2:  # read while it is written: one whole row of all datasets at least, whenever it is killed
        time.sleep(0.02)
        assert run.poll() is None
        if os.path.exists(os.path.join(folder, "run.h5.part")):
            with h5py.File(os.path.join(folder, "run.h5.part"), "r", swmr=True) as file:
                rows = min(len(dataset) for name in ("steps", "series", "fields") for dataset in file[name].values())
    run.kill()
    run.wait()
    rows = check_rows(os.path.join(folder, "run.h5.part"), 0)
    for command in (["plot-run", "run.h5.part"], ["compare", "run.h5.part", "--figure", "c.png"]):
        done = subprocess.run([sys.executable, PROGRAM, *command], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert f"slipstep {command[0]}: run.h5.part is unfinished: complete = 0" in done.stderr and done.stderr.count(
            "\n") == 1, done.stderr
    done = subprocess.run([sys.executable, PROGRAM, "plot-run", "run.h5"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 1 and "run.h5.part is there, of a run that has not ended" in done.stderr, done.stderr
    done = subprocess.run(RUN[:-1] + ["-fault_output", "run.h5"], cwd=folder, capture_output=True, text=True)
    assert (done.returncode == 1 and "rows of an unfinished run: continue it with -fault_restart CHECKPOINT"
            in done.stderr)
    assert "-fault_output_overwrite" in done.stderr and check_rows(os.path.join(folder, "run.h5.part"), 0) == rows > 0


def stopped_by_disk(run, folder, older, reasons):
    """After the disk was full: the program says so, is not killed, and leaves whole rows and the older file. Its
    rows."""
    message = run.communicate(timeout=1000)[1].decode()
    part = os.path.join(folder, "run.h5.part")
    if run.returncode == 0:  # there was enough after all
        return check_rows(os.path.join(folder, "run.h5"), 1)
    assert run.returncode == 1, (run.returncode, message)
    message = "".join(line for line in message.splitlines(True) if ": warning: " not in line)
    assert message.count("\n") == 1 and "run.h5" in message and any(reason in message for reason in reasons), message
    with open(os.path.join(folder, "run.h5"), "rb") as file:
        assert file.read() == older
    if not os.path.exists(part):
        return 0
    assert "row " in message and "of /" in message or "cannot write run.h5.part" in message, message
    return check_rows(part, 0)


def start(folder, older, **more):
    """A run with an older file; every second one writes single numbers, compressed."""
    clean(folder)
    start.runs += 1
    storage = ["-fault_output_precision", "single", "-fault_output_compression", "6"] if start.runs % 2 else []
    with open(os.path.join(folder, "run.h5"), "wb") as file:
        file.write(older)
    return subprocess.Popen(RUN + ["-fault_output", "run.h5"] + storage, cwd=folder, stdout=subprocess.DEVNULL,
                            stderr=subprocess.PIPE, **more)


start.runs = 0


def wait_for(run, path, size):
    """Until the file has this size, or the run has ended, which takes the file's name away."""
    while run.poll() is None:
        try:
            if os.path.getsize(path) >= size:
                return
        except FileNotFoundError:  # not yet, or no longer
            pass
        time.sleep(0.002)


def limit_size(run, size):
    """Of the files of a run that may have ended; None: no limit"""
    try:
        resource.prlimit(run.pid, resource.RLIMIT_FSIZE,
                         (resource.RLIM_INFINITY if size is None else size, resource.RLIM_INFINITY))
    except ProcessLookupError:
        pass


def limited(folder, older, size):
    """RLIMIT_FSIZE: files end at a random size, for the whole run or for at most 3 s of it."""
    found = []
    for again in (False, True):
        for _ in range(MOMENTS):
            limit = random.randrange(size)
            run = start(folder, older,
                        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY)))
            if again:
                wait_for(run, os.path.join(folder, "run.h5.part"), random.uniform(0.5, 1) * limit)
                limit_size(run, None)
            found.append(stopped_by_disk(run, folder, older, ["File too large"]))
    print(f"limited {2 * MOMENTS} times: rows {found}")


def lowered(folder, older, size):
    """The limit comes while the file is written, which is longer by then: the rows in its reserved space cannot be
    written any more."""
    found = []
    for _ in range(MOMENTS):
        run = start(folder, older)
        wait_for(run, os.path.join(folder, "run.h5.part"), random.randrange(size))
        limit_size(run, random.randrange(os.path.getsize(os.path.join(folder, "run.h5.part"))) if run.poll() is None
                   else None)
        found.append(stopped_by_disk(run, folder, older, ["File too large"]))
    print(f"limits lowered {MOMENTS} times: rows {found}")


def filled(folder, older, size):
    """A small disk of its own that another program fills, for good or for at most 3 s."""
    found = []
    for again in (False, True):
        for _ in range(MOMENTS):
            other = os.path.join(folder, "other")
            run = start(folder, older)
            wait_for(run, os.path.join(folder, "run.h5.part"), random.randrange(size))
            with open(other, "wb", buffering=0) as file:
                try:
                    while True:
                        file.write(bytes(1 << 16))
                except OSError:
                    pass
            if again:
                try:
                    run.wait(3)
                except subprocess.TimeoutExpired:
                    pass
                os.remove(other)
            found.append(stopped_by_disk(run, folder, older, ["No space left on device"]))
    print(f"filled {2 * MOMENTS} times: rows {found}")


def main():
    with tempfile.TemporaryDirectory() as folder:
        killed(folder)
        killed(folder, "-fault_output_precision", "single", "-fault_output_compression", "4", "-fault_stations",
               "1000,1000;2000,2000")
        read_by_scripts(folder)
        clean(folder)
        with h5py.File(os.path.join(folder, "run.h5"), "w") as file:
            file["older"] = np.arange(1000.0)
        with open(os.path.join(folder, "run.h5"), "rb") as file:
            older = file.read()
        limited(folder, older, 2000000)
        lowered(folder, older, 2000000)
        disk = os.path.join(folder, "disk")
        os.mkdir(disk)
        if os.geteuid() or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=3m", "tmpfs", disk],
                                          stderr=subprocess.DEVNULL).returncode:
            print("no disk of its own: not root, or no mount")
            os.rmdir(disk)
            clean(folder)
            return
        try:
            filled(disk, older, 3000000)
        finally:
            subprocess.run(["umount", disk], check=True)
            os.rmdir(disk)


if __name__ == "__main__":
    main()
