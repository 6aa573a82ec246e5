#!/usr/bin/env python3
"""import slipstep: a fault by keywords, in this process and by the program, with the same numbers; files; errors; what
may be missing."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import textwrap
import time
import unittest

from scripts import FAULT, FaultTest
from test_from_python import environment, python

WITHOUT = """
import sys
class Block:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {blocked}:
            raise ImportError(name)
sys.meta_path.insert(0, Block())
"""
RUN = """
import json, numpy as np, slipstep
stress = np.linspace(3e7, 5e7, 12).reshape(3, 4)
fault = slipstep.Fault(nx=4, nz=3, normal_stress=stress, normal_stress_gradient=0.0, inertia=False,
                       viscosity="radiation", initial="traction",
                       initial_traction=0.6 * stress, initial_unstable=True, stations="500,500", ts_max_time="0.1min")
result = fault.run(progress=False)
assert result.complete and result["slip"].shape[1:] == (3, 4) and result.units["slip"] == "m" and result.time[-1] == 6.0
assert set(result.stations[0]) >= {"time", "slip", "x"}
assert len(result.stations[0]["slip"]) == len(result.series["time"])
assert result.mesh["normal_stress"].shape == (3, 4) and abs(result.mesh["normal_stress"] - stress).max() == 0
try:
    fault.set(nx=0)
    fault.run(progress=False)
    raise SystemExit("no error")
except slipstep.Error as error:
    text = str(error)
print(json.dumps([fault.backend, result["slip"][-1].tolist(), result.summary["accepted"], text,
                  type(result.catalogue).__name__]))
"""


class Results(FaultTest):
    def numbers(self, blocked=(), **more):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, "-c", WITHOUT.format(blocked=set(blocked) or "()") + RUN],
                                  env={**environment(), "SLIPSTEP_FAULT": FAULT, "TMPDIR": folder, **more},
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual([name for name in os.listdir(folder) if name.startswith("slipstep-")], [])
        return json.loads(done.stdout.splitlines()[-1])

    def test_backends(self):
        """The same bits; pandas and petsc4py may be missing. Errors have the line of the program."""
        program = self.numbers(blocked=("petsc4py", "pandas", "xarray"))
        self.assertEqual((program[0], program[4]), ("program", "ndarray"))
        self.assertTrue(program[3].startswith("-fault_nx is 0, "), program[3])
        process = self.numbers(SLIPSTEP_BACKEND="")
        self.assertEqual(process[1:4], program[1:4])

    def test_files(self):
        """open() has what run() returns; FILE.part of a run that was stopped; what is no such file."""
        self.fault("-fault_nx", 4, "-fault_nz", 3, "-fault_stiffness_average", "whole", "-fault_output", "run.h5",
                   "-fault_catalogue", "events.h5")
        self.put("text", "no HDF5")
        done = python("-c", textwrap.dedent(f"""
            import os, slipstep
            folder = {self.folder.name!r}
            run, events = slipstep.open(folder + "/run.h5", folder + "/events.h5"), slipstep.open(folder + "/events.h5")
            assert len(run.catalogue) == len(events.catalogue) == 1 and "ended at 30 s" in repr(run)
            assert run["slip"].shape == (len(run.time), 3, 4) and not run.warnings
            for name in ("none.h5", "text"):
                try:
                    slipstep.open(os.path.join(folder, name))
                    raise SystemExit(name)
                except slipstep.Error as error:
                    assert name in str(error)
            os.rename(folder + "/run.h5", folder + "/run.h5.part")
            assert slipstep.open(folder + "/run.h5.part").summary["accepted"] > 0
            """))
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_options_file(self):
        """Keywords override the file, and what it has of cells overrides the default of 10 x 10, on both backends."""
        self.put("few.opts", "-fault_nx 6\n-fault_nz 4\n-ts_max_time 2\n")
        done = python("-c", textwrap.dedent(f"""
            import slipstep
            for backend in ["program", slipstep.Fault.backend]:
                for given, shape in (({{}}, (4, 6)), ({{"nx": 5}}, (4, 5)), ({{"nx": 5, "nz": 3}}, (3, 5))):
                    fault = slipstep.Fault(options_file={self.path("few.opts")!r}, **given)
                    result = fault.run(progress=False, backend=backend)
                    assert result["slip"].shape[1:] == shape, (backend, given, result["slip"].shape)
                    assert result.series["time"][-1] == 2, (backend, given)
            """))
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_warnings(self):
        """What the program warns of are SlipStepWarnings of the line that called run(), those of Result.warnings; also
        of a run that is refused, and of its cells alone."""
        for backend in ("program", "petsc"):
            done = python("-c", textwrap.dedent(f"""
                import warnings, slipstep

                def caught(function, **more):
                    with warnings.catch_warnings(record=True) as found:
                        warnings.simplefilter("always")
                        try:
                            result = function(**more)
                        except slipstep.Error as error:
                            result = error
                    assert all(one.category is slipstep.SlipStepWarning and one.filename == "<string>"
                               for one in found), found
                    return [str(one.message) for one in found], result

                fault = slipstep.Fault(nx=2, nz=2, friction_a=0.01, ts_max_time=1)
                backend = {backend!r} if fault.backend == "petsc" else "program"
                found, result = caught(fault.run, progress=False, backend=backend)
                assert found == result.warnings and any(line.startswith("2 x 2 cells are few") for line in found), found
                assert backend == "petsc" or any(line.startswith("-fault_friction_a has no effect")
                                                 for line in found), found
                warnings.simplefilter("error", category=slipstep.SlipStepWarning)
                try:
                    fault.run(progress=False, backend=backend)
                    raise SystemExit("no error")
                except slipstep.SlipStepWarning:
                    pass
                if backend == "program":
                    fault.set(mesh="nowhere.h5")
                    found, error = caught(fault.run, progress=False, backend=backend)
                    assert "nowhere.h5" in str(error) and found and "-fault_nx does nothing" in found[0], (found, error)
                """), SLIPSTEP_FAULT=FAULT)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotIn("warning", done.stderr)  # a second time
        failed = python("-c", textwrap.dedent("""
            import slipstep
            if slipstep.Fault.backend != "petsc":
                raise SystemExit("no petsc4py")
            slipstep.Fault(nx=2, nz=2, output="nowhere/run.h5").run(progress=False)
            """))
        if "no petsc4py" not in failed.stderr:
            self.assertRegex(failed.stderr, r"warning: 2 x 2 cells are few(.|\n)*Error: cannot create nowhere")

    def test_interrupt(self):
        """Ctrl-C ends a run after its step, and says so; the result has the steps until then, and the program's as
        well, be Python slow to pass it on."""
        for backend in ("program", "petsc"):
            done = python("-c", textwrap.dedent(f"""
                import os, re, signal, sys, time, slipstep
                from slipstep import running

                class Out:
                    sent = False

                    def write(self, text):
                        if not self.sent and re.search(", [1-9][0-9]* steps", text):
                            self.sent = True
                            signal.pthread_sigmask(signal.SIG_BLOCK, {{signal.SIGINT}})
                            os.killpg(0, signal.SIGINT)  # as a terminal does
                            time.sleep(0.3)  # after 0.1 s a signal is the second one
                            signal.pthread_sigmask(signal.SIG_UNBLOCK, {{signal.SIGINT}})

                    def flush(self):
                        pass

                os.setsid()
                children, before = [], running._end
                running._end = lambda child: (children.append(child), before(child))
                fault = slipstep.Fault(nx=3, nz=3, ts_adapt_type="none", ts_dt=1e-6, ts_max_time=600,
                                       output_interval=1000)
                sys.stdout = Out()
                result = fault.run(backend={backend!r} if fault.backend == "petsc" else None)
                assert not result.complete and 0 < result.series["time"][-1] < 600, result
                codes = [child.returncode for child in children]
                assert codes == [128 + signal.SIGINT] * len(children), codes
                """))
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertRegex(done.stderr,
                             r"(?m)^slipstep: the run stops after the step in work; Ctrl-C again ends at once$")

    def test_a_second_interrupt(self):
        """It ends a process that computes without a look at Python's signals."""
        run = subprocess.Popen([sys.executable, "-c", textwrap.dedent("""
            import itertools, os, slipstep

            def stress(cells):  # in C from the line that it writes on
                return sum(itertools.chain(map(os.write, [1], [b"computes\\n"]), itertools.repeat(0)))

            fault = slipstep.Fault(nx=2, nz=2, normal_stress=stress)
            if fault.backend == "program":
                print("none", flush=True)
                raise SystemExit
            fault.run(progress=False)
            """)], env=environment(), stdout=subprocess.PIPE, text=True)
        try:
            if run.stdout.readline() == "none\n":
                self.skipTest("no petsc4py")
            sent = 0
            while run.poll() is None and sent < 100:
                run.send_signal(signal.SIGINT)
                sent += 1
                time.sleep(0.1)
            self.assertEqual((run.poll(), sent > 1), (-signal.SIGINT, True))
        finally:
            run.kill()
            run.wait()
            run.stdout.close()

    def test_the_program_ends_with_its_run(self):
        """Whatever ends run() early, the program has ended before its folder is removed, be it one that does not
        listen."""
        deaf = self.path("deaf")
        with open(deaf, "w") as file:
            file.write("#!/bin/sh\ntrap '' INT TERM\n: > $0.listens\nwhile :; do sleep 0.05; done\n")
        os.chmod(deaf, 0o755)
        for program, raised, code in (
                (FAULT, "ZeroDivisionError",
                 "running._show = lambda line, path, fault: os.path.exists(path) and 1 / 0"),
                (deaf, "KeyboardInterrupt", "threading.Thread(target=interrupts, daemon=True).start()")):
            done = python("-c", textwrap.dedent(f"""
                import os, shutil, signal, subprocess, threading, time, slipstep
                from slipstep import running
                children, removed, heard = [], [], threading.Event()
                running.say_stopping = lambda what: heard.set()

                def interrupts():
                    while not (children and os.path.exists({deaf!r} + ".listens")):
                        time.sleep(0.01)
                    os.kill(os.getpid(), signal.SIGINT)
                    heard.wait()
                    os.kill(os.getpid(), signal.SIGINT)

                class Popen(subprocess.Popen):
                    def __init__(self, *arguments, **more):
                        super().__init__(*arguments, **more)
                        children.append(self)

                def rmtree(folder, **more):
                    removed.append(children[0].returncode is not None)
                    rmtree_before(folder, **more)

                running.subprocess.Popen, running.PATIENCE = Popen, 0.5
                rmtree_before, shutil.rmtree = shutil.rmtree, rmtree
                {code}
                fault = slipstep.Fault(nx=3, nz=3, ts_adapt_type="none", ts_dt=1e-6, ts_max_time=600,
                                       output_interval=1000)
                try:
                    fault.run(backend="program")
                except {raised}:
                    assert removed == [True], removed
                    raise SystemExit(0)
                raise SystemExit("no {raised}")
                """), SLIPSTEP_FAULT=program)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
