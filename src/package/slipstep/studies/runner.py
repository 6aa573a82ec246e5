"""The processes of a study: as many runs at once as cores and ranks allow, each over once.

A run is recorded as over in one file, after it has ended (record.py). Whoever starts one holds its lock, and so do the
processes of the run: when a driver is killed, they are asked by the system to stop after their step, and the next
driver waits until they have. The run then goes on from its checkpoint, or anew where it has none.
"""

import contextlib
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from ..errors import Error
from ..modules import ENVIRONMENT, find_program, program_fault
from ..running import follow, say_stopping, word
from .plan import filled
from .record import Record, lock, write_whole

ENDED = {0: "ended", 3: "early"}  # exit codes of runs that are over without an error
STOPPED = (tuple(128 + n for n in (signal.SIGUSR1, signal.SIGXCPU, signal.SIGTERM, signal.SIGINT))
           + tuple(-n for n in (signal.SIGUSR1, signal.SIGXCPU, signal.SIGTERM, signal.SIGINT)))
LAUNCHER = "mpirun --bind-to none -n {ranks}"  # bound, the ranks of all runs would share the first cores
SRUN = "srun -n {ranks}"
PAUSE = 0.02  # between two looks at the processes [s]
SHORT = 40  # characters of a folder for sockets, whose paths may have 107


def resolved(command, base):
    """Words of a command with its program's path."""
    words = shlex.split(command)
    path = program_fault() if words[0] == "fault" else find_program(words[0]) if os.sep not in words[0] else None
    beside = os.path.join(base, words[0])
    if not path and os.path.isfile(beside):
        path = beside
    path = path or shutil.which(words[0])
    if not path:
        raise Error(f"there is no program {words[0]}, of SlipStep, in {base} or on PATH")
    return [path, *words[1:]]


class Process:
    """One run under way: commands one after the other, printing into log.txt, under a lock until it is over."""

    def __init__(self, plan, record, descriptor):
        self.plan, self.record, self.descriptor = plan, record, descriptor
        self.begin, self.asked = time.monotonic(), False
        run, folder = record.planned, record.folder
        self.places = plan.places(run, folder)
        continued = any(os.path.exists(record.file(name)) for name in ("state.h5", "state.h5.previous"))
        before = plan.given["before"]
        self.stages = [self.main_words(run, continued)]
        if before and not continued:
            self.stages.insert(0, [filled(text, self.places) for text in resolved(before, plan.base)])
        self.launched = run.ranks > 1 or plan.given["launcher"] is not None
        if self.launched:
            self.stages[-1][:0] = shlex.split((plan.given["launcher"]
                                               or (SRUN if os.environ.get("SLURM_JOB_ID")
                                                   else LAUNCHER)).replace("{ranks}", str(run.ranks)))
        with contextlib.suppress(FileNotFoundError):
            os.remove(record.file("stop"))
        write_whole(record.file("run.json"),
                    {"number": run.number, "values": run.values, "command": self.stages[-1], "folder": plan.base})
        with open(record.file("attempts"), "a", encoding="utf-8") as file:
            file.write(time.strftime("%Y-%m-%dT%H:%M:%S%z") + f" {'goes on' if continued else 'begins'}\n")
        record.clean()
        self.temporary = tempfile.mkdtemp(prefix="slipstep-", dir="/tmp" if len(tempfile.gettempdir()) > SHORT
                                          else None)
        os.symlink(self.temporary, record.file("tmp"))
        self.log = open(record.file("log.txt"), "ab")
        self.start = self.log.tell()
        self.next()

    def main_words(self, run, continued):
        command = [filled(text, self.places) for text in resolved(self.plan.command, self.plan.base)]
        if self.plan.placed:
            return command
        folder = self.record.folder
        if self.plan.given["options_file"]:
            command += ["-options_file", self.plan.given["options_file"]]
        for name, value in run.options.items():
            command += [f"-{name}", filled(word(value), {"folder": folder})]
        if self.plan.command == "fault":
            command += ["-fault_stop_file", self.record.file("stop"), "-fault_output", self.record.file("run.h5"),
                        "-fault_catalogue", self.record.file("events.h5"), "-fault_progress", "no",
                        "-fault_output_xdmf", "no"]
            if self.plan.given["checkpoint"]:
                command += ["-fault_checkpoint", self.record.file("state.h5")]
            command += ["-fault_restart", self.record.file("state.h5")] if continued else ["-fault_output_overwrite"]
        return command

    def next(self):
        """Start the next command; what cannot be started has ended with an error."""
        environment = {**ENVIRONMENT, **os.environ, "TMPDIR": self.temporary}
        if self.launched and len(self.stages) == 1:
            environment.pop("OMPI_MCA_ess_singleton_isolated", None)  # of a program without mpirun
        parent = os.getpid()
        try:
            self.child = subprocess.Popen(self.stages[0], cwd=self.plan.base, env=environment, stdin=subprocess.DEVNULL,
                                          stdout=self.log, stderr=subprocess.STDOUT,
                                          start_new_session=True, pass_fds=(self.descriptor,),
                                          preexec_fn=lambda: follow(parent))
        except OSError as error:
            self.child = None
            self.log.write(f"{self.stages[0][0]}: {error.strerror}\n".encode())
            self.log.flush()

    def poll(self):
        """None while it goes on, then its recorded status: one of ENDED, "failed" or "stopped"."""
        code = 127 if self.child is None else self.child.poll()
        if code is None:
            return None
        if code == 0 and len(self.stages) > 1 and not self.asked:
            self.stages.pop(0)
            self.next()
            return None
        stopped = code in STOPPED or (self.asked and (code not in ENDED or len(self.stages) > 1))
        status = "stopped" if stopped else ENDED.get(code, "failed") if len(self.stages) == 1 else "failed"
        self.log.close()
        self.record.clean()
        if not stopped:
            self.record.finish(status, code, self.error() if status == "failed" else "", time.monotonic() - self.begin)
        os.close(self.descriptor)
        return status

    def error(self):
        """Of the last attempt: the line of an error, else the last one."""
        with open(self.record.file("log.txt"), "rb") as file:
            file.seek(self.start)
            text = file.read()[-100000:].decode(errors="replace")
        lines = re.findall(r"(?m)^\S+: error: (.*)$", text) or [line for line in text.splitlines() if line.strip()]
        return lines[-1].strip() if lines else "nothing was printed"

    def stop(self):
        """After its step, with a checkpoint; asked again, at once."""
        if self.child is None or self.child.poll() is not None:
            return
        with contextlib.suppress(ProcessLookupError):
            if self.asked:
                os.killpg(self.child.pid, signal.SIGKILL)
            elif self.launched and self.plan.command == "fault":  # launchers pass on some signals, and some kill
                with open(self.record.file("stop"), "w", encoding="utf-8"):
                    pass
            else:
                self.child.send_signal(signal.SIGUSR1)
        self.asked = True


class Stop:
    """with Stop() as stop: SIGINT, SIGTERM and SIGUSR1 count, and end nothing by themselves."""

    def __enter__(self):
        self.count, self.before = 0, {}
        try:
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1):
                self.before[number] = signal.signal(number, self.add)
        except ValueError:  # not in the main thread
            pass
        return self

    def add(self, *_):
        self.count += 1

    def __exit__(self, *_):
        for number, handler in self.before.items():
            signal.signal(number, handler)


def begin(plan, record):
    """The Process of a run; None: it is over; False: somebody else has it."""
    os.makedirs(record.folder, exist_ok=True)
    if record.outcome:
        return None
    descriptor = lock(record.file("lock"))
    if descriptor is None:
        return False
    if record.outcome:  # by whoever had the lock
        os.close(descriptor)
        return None
    try:
        return Process(plan, record, descriptor)
    except BaseException:
        os.close(descriptor)
        raise


def check_options(plan):
    """Error: an option of the runs that the program fault does not have, which all of them would end with."""
    if plan.command != "fault" or plan.placed:
        return
    file = plan.given["options_file"]
    words = [*(["-options_file", file] if file else []),
             *(text for name, value in plan.runs[0].options.items() for text in (f"-{name}", word(value)))]
    done = subprocess.run([program_fault(), *words, "-help", "fault"], cwd=plan.base, env={**ENVIRONMENT, **os.environ},
                          capture_output=True, encoding="utf-8", errors="replace", check=False)
    found = re.search(r"error: (there is no option .*)", done.stderr)
    if found:
        raise Error(f"{plan.source}: {found[1]}")


def drive(plan, folder, runs, cores, say=None):
    """Runs that are not over, as many at once as fit, until all are or a signal stops them: the number of signals.
    say(record, status, active, left) is called for each that ends."""
    cores = cores or plan.given["cores"] or len(os.sched_getaffinity(0))
    waiting = [record for record in (Record(folder, run) for run in runs) if not record.outcome]
    largest = max((record.planned.ranks for record in waiting), default=0)
    if largest > cores:
        raise Error(f"{plan.source}: a run has {largest} ranks, and there are {cores} cores: expected at most as many, "
                    f"or cores = {largest}")
    resolved(plan.command, plan.base)
    if waiting:
        check_options(plan)
    active, busy, told = [], [], False
    with Stop() as stop:
        asked = 0
        while active or ((waiting or busy) and not stop.count):
            while (waiting and not stop.count and waiting[0].planned.ranks <= cores
                   - sum(process.record.planned.ranks for process in active)):
                record = waiting.pop(0)
                process = begin(plan, record)
                if process:
                    active.append(process)
                elif process is False:
                    busy.append(record)
            if busy and not waiting and not active:
                if not told:
                    print(f"{plan.source}: run {busy[0].planned.number} still stops under a driver that was "
                          "killed; waiting", file=sys.stderr)
                told = True
                time.sleep(10 * PAUSE)
            if not waiting:
                waiting, busy = busy, []
            time.sleep(PAUSE)
            if stop.count > asked:
                if active and not asked:
                    say_stopping("all runs stop")
                asked += 1  # one at a time: a second signal may come while the first is told
                for process in active:
                    process.stop()
            for process in list(active):
                status = process.poll()
                if status:
                    active.remove(process)
                    if say:
                        say(process.record, status, len(active), len(waiting) + len(busy))
        return stop.count
