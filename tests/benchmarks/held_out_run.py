"""Runs of the held-out benchmark, done by the program `fault`; the numbers of each are a line of a file, so that a
benchmark resumes."""

import concurrent.futures
import dataclasses
import hashlib
import json
import os
import subprocess
import tempfile
import threading
import time

import h5py
import numpy as np

from slipstep.results import course
import held_out_cases

PART = 40  # runs in one process
TIMEOUT = 1200  # of a process [s]; one that takes longer is an error of the benchmark, not a result
FINE = (1e-5, 1e-6, 1e-7, 1e-8)  # rtol of fine runs, one after the other until two agree; the last is the reference
FINE_AGREE = 5e-5  # in the measure `history`: the smallest dial is sixty times that
FINE_STEPS = 2000  # constant steps of an independent third run
LEAN = ["-fault_output_interval", "1000000000", "-fault_output_fields", "slip"]


class BenchmarkError(Exception):
    """The benchmark cannot go on; the message says why."""


def environment():
    """Of one process without neighbours: Open MPI's singleton start without its daemon and its shared memory takes 0.07
    s instead of 0.4 s."""
    env = dict(os.environ, OPENBLAS_NUM_THREADS="1", OMPI_MCA_ess_singleton_isolated="1", OMPI_MCA_pml="ob1",
               OMPI_MCA_btl="self")
    if os.geteuid() == 0:
        env.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    return env


def digest(*paths):
    h = hashlib.sha1()
    for path in paths:
        with open(path, "rb") as file:
            h.update(file.read())
    return h.hexdigest()[:12]


@dataclasses.dataclass
class Job:
    """One run: options of the controller, and how the results call it."""
    case: object
    kind: str  # "classical", "policy" or "fine"
    family: str
    setting: float  # rtol, or position of the dial; 0: none
    options: list
    policy: str = ""  # its file: the run's key has its content, not its name

    @property
    def key(self):
        c = self.case
        fields = digest(c.fields) if c.fields else ""
        options = [o for o in c.options if o != c.fields]
        policy = digest(self.policy) if self.policy else ""
        return hashlib.sha1(json.dumps([options, c.duration, fields, self.options, policy]).encode()).hexdigest()[:20]


class Store:
    """Results by key in a file of lines; a line cut short by an interruption is ignored."""

    def __init__(self, path):
        self.path, self.rows, self.lock = path, {}, threading.Lock()
        if os.path.exists(path):
            with open(path) as file:
                for line in file:
                    try:
                        row = json.loads(line)
                    except ValueError:
                        continue
                    self.rows[row["key"]] = row

    def add(self, row):
        with self.lock:
            self.rows[row["key"]] = row
            with open(self.path, "a") as file:
                file.write(json.dumps(row) + "\n")


def command_line(job, output):
    c = job.case
    return [*c.options, "-ts_max_time", f"{c.duration:.10g}", *job.options,
            *(["-ts_adapt_rl_policy", job.policy] if job.policy else []), "-fault_output", output, *LEAN]


def read(output):
    """Attributes of /result and [time, mean slip, mean slip rate], the start included."""
    with h5py.File(output) as file:
        result = {name: float(value) for name, value in file["result"].attrs.items()}
        return result, np.array(course.from_start(file["series"]))


def read_course(output):
    """Attributes of /result and the course. Among the attributes `rest`, when the fault came to rest for good [s], NaN
    when it did not, `moving`, the accepted steps until then and one more for the time that is left, and `explicit`, the
    share of explicit steps."""
    run = course.read(output)
    with h5py.File(output) as file:
        result = {name: float(value) for name, value in file["result"].attrs.items()}
        result["explicit"] = float(file["steps/method"][()][file["steps/accepted"][()] == 1].mean())
        moves = np.flatnonzero(course.from_start(file["series"], ("max_slip_rate",))[0])
    last, n = (moves[-1] if len(moves) else 0), len(run.time) - 1
    result.update(rest=float(run.time[last + 1]) if last < n else np.nan, moving=int(min(last + 2, n)))
    return result, run


def execute(build, jobs, folder, read=read):
    """Do runs in one process (-fault_sweep); yield of each what read() makes of its output, or None and the message it
    ended with. A run that fails ends the process: the others go to another one. A machine under load sometimes cannot
    start MPI, so the first run of a process is tried again."""
    program, again = os.path.join(build, "bin", "fault"), False
    while jobs:
        with tempfile.TemporaryDirectory(dir=folder) as room:
            sweep = os.path.join(room, "sweep")
            outputs = [os.path.join(room, f"{k}.h5") for k in range(len(jobs))]
            with open(sweep, "w") as file:
                file.writelines(" ".join(command_line(job, output)) + "\n" for job, output in zip(jobs, outputs))
            done = subprocess.run([program, "-fault_sweep", sweep], env=environment(), capture_output=True, text=True,
                                  timeout=TIMEOUT)
            count = 0
            for job, output in zip(jobs, outputs):
                if not os.path.exists(output):
                    break
                yield job, read(output), ""
                count += 1
        if count < len(jobs):
            if not done.returncode:
                raise BenchmarkError(f"{program} wrote no output for {' '.join(command_line(jobs[count], 'F'))}")
            again = not count and not again
            if again:
                continue
            lines = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
            yield jobs[count], None, lines[-1][:300]
            count += 1
        jobs = jobs[count:]


class Bench:
    """Where the runs are done and kept."""

    def __init__(self, build, folder, processes):
        self.build, self.folder, self.processes = build, folder, processes
        os.makedirs(os.path.join(folder, "reference"), exist_ok=True)
        self.store = Store(os.path.join(folder, "runs.jsonl"))
        self.fine = {}
        self.check_build()

    def check_build(self):
        """Results of another library are not mixed with ours without a word."""
        mark = os.path.join(self.folder, "library")
        library = digest(os.path.join(self.build, "lib", "libslipstep.so"))
        if os.path.exists(mark):
            with open(mark) as file:
                before = file.read().strip()
            if before != library:
                print(f"Note: {self.folder} was begun with another build of the library ({before}, now {library}); "
                      "what it has is" " reused. Remove the folder to start again.")
        else:
            with open(mark, "w") as file:
                file.write(library + "\n")

    def probe(self, case):
        """(time to rest or None, final mean slip) of a run of moderate accuracy."""
        options = ["-ts_adapt_type", "heuristic", "-ts_rtol", f"{held_out_cases.PROBE_RTOL:g}"]
        (_, found, _), = execute(self.build, [Job(case, "fine", "", 0, options)], self.folder, read_course)
        if not found or np.isnan(found[0]["rest"]):
            return None, 0.0
        return float(found[0]["rest"]), found[0]["mean_slip"]

    def run(self, jobs):
        """Runs against their reference, stored."""
        for job, found, message in execute(self.build, jobs, self.folder, read_course):
            row = {"key": job.key, "case": job.case.name, "group": job.case.group, "kind": job.kind,
                   "family": job.family, "setting": job.setting, "failed": message}
            if found:
                result, done = found
                row.update({name: result[name] for name in ("solves", "accepted", "rejected", "mean_slip",
                                                            "wall_time_solve")})
                row.update({name: value for name, value in result.items() if name.startswith(("slip_error", "products"))
                            or name in ("cost", "explicit_attempts")})
                if job.family == "constant":
                    row["solves"] = result["moving"]
                row.update(course.errors(done, self.fine[job.case.name]))
            self.store.add(row)
        return len(jobs)

    def all(self, jobs, title):
        """Every run that is not there yet, with progress and the time left."""
        keys = [job.key for job in jobs]
        todo = [job for key, job in zip(keys, jobs) if key not in self.store.rows]
        if jobs:
            print(f"{title}: {len(jobs)} runs, {len(jobs) - len(todo)} there already", flush=True)
        # cheap ones first would make the time left a lie: parts of many cases each
        parts = [todo[k::-(-len(todo) // PART)] for k in range(-(-len(todo) // PART))] if todo else []
        begin = last = time.time()
        done = 0
        with concurrent.futures.ThreadPoolExecutor(self.processes) as pool:
            for future in concurrent.futures.as_completed([pool.submit(self.run, part) for part in parts]):
                done += future.result()
                if time.time() - last > 10 or done == len(todo):
                    last = time.time()
                    print(f"  {done} of {len(todo)}, {last - begin:.0f} s, about "
                          f"{(last - begin) / done * (len(todo) - done):.0f} s left", flush=True)
        return [self.store.rows[key] for key in keys]

    def reference(self, case):
        """The fine run of a case, computed once; the spread of independent ones is kept with it."""
        path = os.path.join(self.folder, "reference", Job(case, "fine", "heuristic", 0, []).key + ".h5")
        if not os.path.exists(path):
            self.make_reference(case, path)
        with h5py.File(path) as file:
            self.fine[case.name] = course.Course(**{name: file[name][()] for name in file})
            return dict(file.attrs)

    def make_reference(self, case, path):
        coarse, spread = None, None
        for rtol in FINE:
            rest, fine = self.fine_run(case, ["-ts_adapt_type", "heuristic", "-ts_rtol", f"{rtol:g}"])
            if coarse is not None:
                spread = course.MEASURES["history"](course.errors(coarse, fine))
                if spread < FINE_AGREE:
                    break
            coarse = fine
        else:
            raise BenchmarkError(f"{case.name} has no reference: fine runs still differ by {spread:.1e} in the course "
                                 f"at rtol {rtol:g}," f" expected < {FINE_AGREE:g}")
        if np.isnan(rest):
            raise BenchmarkError(f"{case.name}: the event is not over at {case.duration:g} s, expected rest")
        _, steps = self.fine_run(case, ["-ts_adapt_type", "none", "-ts_bathe_error", "none", "-ts_dt",
                                        f"{case.duration / FINE_STEPS:.10g}"])
        with h5py.File(path + ".part", "w") as file:
            for name, values in vars(fine).items():
                file[name] = values
            file.attrs.update({"case": case.name, "rtol": rtol, "spread": spread,
                               "constant_steps_spread": course.MEASURES["history"](course.errors(steps, fine))})
        os.replace(path + ".part", path)

    def fine_run(self, case, options):
        (_, found, message), = execute(self.build, [Job(case, "fine", "", 0, options)], self.folder, read_course)
        if not found:
            raise BenchmarkError(f"the reference of {case.name} failed: {message}")
        return found[0]["rest"], found[1]

    def references(self, cases):
        """All of them, and the largest differences between the fine runs."""
        print(f"references: {len(cases)}", flush=True)
        begin, found = time.time(), []
        with concurrent.futures.ThreadPoolExecutor(self.processes) as pool:
            for r in pool.map(self.reference, cases):
                found.append(r)
                if time.time() - begin > 10 and len(found) % 10 == 0:
                    print(f"  {len(found)} of {len(cases)}, {time.time() - begin:.0f} s", flush=True)
        worst = {name: max(r[name] for r in found) for name in ("spread", "constant_steps_spread")}
        print(f"  two refinements differ by at most {worst['spread']:.1e} in the course, {FINE_STEPS} constant steps by"
              f" {worst['constant_steps_spread']:.1e}", flush=True)
        return worst
