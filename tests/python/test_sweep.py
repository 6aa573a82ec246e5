#!/usr/bin/env python3
"""Studies of many runs: each is over once, whatever is killed and whoever else comes; one table of them."""

import csv
import glob
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time
import unittest
from unittest import mock

from scripts import BUILD, PROGRAM, SOURCE, ScriptTest

from slipstep import Error
from slipstep.studies import Study
from slipstep.studies import plan, slurm, table
from slipstep.studies.record import lock

SWEEP = [sys.executable, PROGRAM, "sweep"]
HANG = 300  # ends what hangs [s]
# a program of one's own: it waits while the file GATE is there, fails for x = 3, and counts how often it began
OWN = """import json, os, sys, time
folder, x = sys.argv[1], float(sys.argv[2])
open(os.path.join(folder, "began"), "a").write("x")
while os.path.exists("gate"):
    time.sleep(0.01)
if x == 3:
    sys.exit("own: error: three is too many")
json.dump({"square": x * x, "magnitude": -x}, open(os.path.join(folder, "numbers.json"), "w"))
"""


def environment():
    return {**os.environ, "SLIPSTEP_BUILD": BUILD}


class Sweep(ScriptTest):
    def setUp(self):
        super().setUp()
        patched = mock.patch.dict(os.environ, SLIPSTEP_BUILD=BUILD)
        patched.start()
        self.addCleanup(patched.stop)

    def write(self, name, text):
        self.put(name, text)
        return self.path(name)

    def own(self, values="[1, 2, 3, 4]", more=""):
        self.write("own.py", OWN)
        return self.write("own.toml", f'command = "{sys.executable} own.py {{folder}} {{x}}"\ntable = ["square", '
                          f'"magnitude"]\n{more}\n[vary]\nx = {values}\n')

    def sweep(self, *arguments, code=0):
        done = subprocess.run([*SWEEP, *arguments], cwd=self.folder.name, env=environment(), capture_output=True,
                              text=True, timeout=HANG)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def wait(self, condition, what):
        end = time.monotonic() + HANG
        while not condition():
            self.assertLess(time.monotonic(), end, what)
            time.sleep(0.01)

    def rows(self, name):
        with open(self.path(name), encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def began(self, study):
        return [os.path.getsize(run.file("began")) if os.path.exists(run.file("began")) else 0 for run in study.runs]

    def test_thirty_runs_of_which_two_fail_and_a_killed_driver(self):
        """Faults: 28 end and 2 are refused; the driver is killed while two are under way, which go on from their
        checkpoints. Every number is that of a study that nobody killed."""
        text = """table = ["events", "magnitude", "peak_slip_rate", "mean_slip", "accepted", "corner_frequency",
         "attempts"]
[options]
nx = 8
nz = 8
ts_adapt_type = "none"
ts_dt = 0.04
ts_max_time = "12s"
checkpoint_interval = 0.05
[vary]
normal_stress = [-1e6, 38e6, 40e6, 42e6, 44e6, 46e6, 48e6, 50e6, 52e6, 54e6, 56e6, 58e6, 60e6, 62e6, 64e6]
friction_slip = [0.15, 0.25]
"""
        study = Study(self.write("study.toml", text))
        driver = subprocess.Popen([*SWEEP, "study.toml", "--cores", "2"], cwd=self.folder.name, env=environment(),
                                  stdout=subprocess.DEVNULL)
        try:
            self.wait(lambda: sum(run.outcome is not None for run in study.runs) >= 6
                      and any(run.status == "begun" and os.path.exists(run.file("state.h5")) for run in study.runs),
                      "no run ends")
        finally:
            driver.kill()
            driver.wait()
        over = [run.number for run in study.runs if run.outcome]
        self.assertLess(len(over), 30)
        said = self.sweep("study.toml", "--cores", "2", code=1)
        self.assertRegex(said, r"(?m)^Table: study.csv, 30 runs: 28 ended, 2 failed; 28 with warnings$")
        self.assertRegex(said, r"(?m)^28 runs of 30 warn, the first of them run 3 \(\S+log.txt\): 8 x 8 cells are few")
        self.assertRegex(said, r"(?m)^run 1 failed \(.*log.txt\): .*normal_stress")
        rows = self.rows("study.csv")
        self.assertEqual([int(row["run"]) for row in rows], list(range(1, 31)))
        self.assertEqual([row["run"] for row in rows if row["status"] == "failed"], ["1", "2"])
        twice = [int(row["run"]) for row in rows if row["attempts"] != "1"]
        self.assertTrue(1 <= len(twice) <= 2 and not set(twice) & set(over), (twice, over))
        with open(study.runs[twice[0] - 1].file("attempts"), encoding="utf-8") as file:
            self.assertEqual([line.split(" ", 1)[1] for line in file.read().splitlines()][0], "begins")
        self.write("whole.toml", text)
        self.sweep("whole.toml", code=1)
        names = ("status", "normal_stress", "friction_slip", "events", "magnitude", "peak_slip_rate [m/s]",
                 "mean_slip [m]", "accepted", "corner_frequency [Hz]")
        self.assertEqual([[row[name] for name in names] for row in rows],
                         [[row[name] for name in names] for row in self.rows("whole.csv")])
        before = {run.file("result.json"): os.stat(run.file("result.json")).st_mtime_ns for run in study.runs}
        self.assertIn("30 of 30 runs are over", self.sweep("study.toml", code=1))
        self.assertEqual(before, {path: os.stat(path).st_mtime_ns for path in before})

    def test_one_that_fails(self):
        """Is reported with its line, the others end; again, nothing begins; --retry begins it alone."""
        study = Study(self.own())
        said = self.sweep("own.toml", code=1)
        self.assertIn("(x = 3) failed: three is too many;", said)
        self.assertEqual([(row["status"], row["square"]) for row in self.rows("own.csv")],
                         [("ended", "1.0"), ("ended", "4.0"), ("failed", ""), ("ended", "16.0")])
        self.sweep("own.toml", code=1)
        self.assertEqual(self.began(study), [1, 1, 1, 1])
        self.sweep("own.toml", "--retry", code=1)
        self.assertEqual(self.began(study), [1, 1, 2, 1])

    def test_warnings_are_counted(self):
        """Those of SlipStep's programs, of scripts and of Python, in the table, in the line of each run and in the
        summary: one line for a text whose numbers differ."""
        warn = """import warnings
if x > 2:
    print(f"own: warning: {x:.2f} cells in the zone", file=sys.stderr)
    print(f"own: warning: {x:.2f} cells in the zone")
if x == 4:
    warnings.warn("all is lost")
"""
        self.own("[1, 2, 4, 5]")
        self.write("own.py", OWN + warn)
        self.write("own.toml", f'command = "{sys.executable} own.py {{folder}} {{x}}"\ntable = ["warnings", "square"]\n'
                   '[vary]\nx = [1, 2, 4, 5]\n')
        said = self.sweep("own.toml")
        self.assertIn("(x = 4) ended, with 2 warnings;", said)
        self.assertRegex(said, r"(?m)^2 runs of 4 warn, the first of them run 3 \(\S+log.txt\): 4.00 cells in the "
                         r"zone\n1 run of 4 warns, the first of them run 3 \(\S+log.txt\): all is lost\nTable: .*; 2 "
                         r"with warnings$")
        self.assertEqual([row["warnings"] for row in self.rows("own.csv")], ["0", "0", "2", "1"])

    def test_added_values(self):
        """A run is known by its options: what was over stays over wherever it stands. A file that it names counts by
        its content."""
        Study(self.own("[1, 2]")).run(progress=False)
        study = Study(self.own("[4, 2, 1]")).run(progress=False)
        self.assertEqual([row["square"] for row in study.rows], [16, 4, 1])
        self.assertEqual(self.began(study), [1, 1, 1])
        self.write("own.py", OWN + "\n# changed")
        self.assertEqual([run.status for run in Study(self.path("own.toml")).runs], ["open"] * 3)

    def test_two_drivers(self):
        """The second is refused while the first is at work, and a task of a job array too. A driver that is killed
        leaves no process that goes on."""
        study = Study(self.own())
        self.write("gate", "")
        driver = subprocess.Popen([*SWEEP, "own.toml", "--cores", "2"], cwd=self.folder.name, env=environment(),
                                  stdout=subprocess.DEVNULL)
        try:
            self.wait(lambda: sum(self.began(study)) == 2, "nothing begins")
            for more in ((), ("--task", "4")):
                self.assertRegex(self.sweep("own.toml", *more, code=1),
                                 r"slipstep sweep: own.toml: another driver or a job array is at work in \S+own.runs")
        finally:
            driver.kill()
            driver.wait()
        def free(run):
            held = lock(run.file("lock"))
            if held is not None:
                os.close(held)
            return held is not None

        # the gate is still there
        self.wait(lambda: all(free(run) for run in study.runs[:2]), "a run goes on without its driver")
        os.remove(self.path("gate"))
        self.sweep("own.toml", code=1)
        self.assertEqual(sorted(self.began(study)), [1, 1, 2, 2])
        self.assertEqual([run.status for run in study.runs], ["ended", "ended", "failed", "ended"])
        self.assertEqual([name for run in study.runs for name in os.listdir(run.folder) if name == "tmp"], [])

    def test_a_run_of_a_killed_driver_is_waited_for(self):
        """Whoever holds a run's lock still writes its files."""
        study = Study(self.own("[1, 2]"))
        os.makedirs(study.runs[0].folder)
        held = lock(study.runs[0].file("lock"))
        driver = subprocess.Popen([*SWEEP, "own.toml"], cwd=self.folder.name, env=environment(),
                                  stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.assertEqual(driver.stderr.readline(),
                         "own.toml: run 1 still stops under a driver that was killed; waiting\n")
        self.assertEqual([run.status for run in study.runs], ["open", "ended"])
        os.close(held)
        self.assertEqual(driver.wait(HANG), 0)
        driver.stderr.close()
        self.assertEqual(self.began(study), [1, 1])

    def test_interrupted(self):
        """Ctrl-C stops faults with a checkpoint, from which they go on to the bits of an unbroken run."""
        text = ('[options]\nnx = 8\nnz = 8\nts_adapt_type = "none"\nts_dt = 0.02\nts_max_time = "40s"\n{}\n[vary]\n'
                'normal_stress = [50e6, 60e6]\n')
        study = Study(self.write("study.toml", text.format("checkpoint_interval = 0.02")))
        driver = subprocess.Popen([*SWEEP, "study.toml", "--cores", "2"], cwd=self.folder.name, env=environment(),
                                  stdout=subprocess.PIPE, text=True)
        self.wait(lambda: all(os.path.exists(run.file("state.h5")) for run in study.runs), "no checkpoint")
        driver.send_signal(signal.SIGINT)
        said = driver.communicate(timeout=HANG)[0]
        self.assertEqual(driver.returncode, 130, said)
        self.assertIn("stopped, goes on at the next call", said)
        self.assertIn("Stopped", said)
        begun = [run.number for run in study.runs if run.status == "begun"]
        self.assertTrue(begun)
        self.sweep("study.toml")
        whole = Study(self.write("whole.toml", text.format(""))).run(progress=False)
        for run, other in zip(study.runs, whole.runs):
            self.assertEqual((run.attempts, run.result.run["restarts"]), (2, 1) if run.number in begun else (1, 0))
            self.assertEqual(run.result.summary["mean_slip"], other.result.summary["mean_slip"])

    def test_interrupted_again(self):
        """A second Ctrl-C ends runs that do not listen; the first one says so."""
        self.write("deaf.py", "import signal, sys, time\nsignal.signal(signal.SIGUSR1, signal.SIG_IGN)\n"
                   "open(sys.argv[1] + '/began', 'a').write('x')\nwhile True:\n    time.sleep(1)\n")
        study = Study(self.write("deaf.toml", f'command = "{sys.executable} deaf.py {{folder}}"\ntable = ["a"]\n'
                                 '[vary]\nx = [1, 2]\n'))
        driver = subprocess.Popen([*SWEEP, "deaf.toml", "--cores", "2"], cwd=self.folder.name, env=environment(),
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.wait(lambda: self.began(study) == [1, 1], "nothing begins")
        driver.send_signal(signal.SIGINT)
        self.assertEqual(driver.stderr.readline(),
                         "slipstep: all runs stop after the step in work; Ctrl-C again ends at once\n")
        driver.send_signal(signal.SIGINT)
        said = driver.communicate(timeout=HANG)[0]
        self.assertEqual((driver.returncode, said.count("stopped, goes on at the next call")), (130, 2), said)

    def test_cores_are_shared(self):
        """As many at once as cores and ranks allow, and no run of more ranks than cores."""
        study = Study(self.own("[1, 2, 4, 5]", "ranks = 2\nlauncher = \"env RANKS={ranks}\""))
        self.write("gate", "")
        driver = subprocess.Popen([*SWEEP, "own.toml", "--cores", "5"], cwd=self.folder.name, env=environment(),
                                  stdout=subprocess.DEVNULL)
        self.wait(lambda: sum(self.began(study)) == 2, "nothing begins")
        time.sleep(0.3)
        self.assertEqual(self.began(study), [1, 1, 0, 0])
        os.remove(self.path("gate"))
        self.assertEqual(driver.wait(HANG), 0)
        self.assertIn("a run has 2 ranks, and there are 1 cores",
                      self.sweep(os.path.basename(self.own("[7]", "ranks = 2")), "--cores", "1", code=1))

    def test_ranks(self):
        """The same numbers on two ranks; ranks may be varied."""
        study = Study(folder=self.path("ranks"), options={"nx": 8, "nz": 8, "ts_max_time": "5s"},
                      vary={"ranks": [1, 2]}, table=["mean_slip", "accepted"], cores=2)
        with mock.patch.dict(os.environ, OMPI_MCA_rmaps_base_oversubscribe="1",
                             PRTE_MCA_rmaps_default_mapping_policy=":oversubscribe"):
            one, two = study.run(progress=False).rows
        self.assertEqual([one["status"], two["status"]], ["ended", "ended"], study.rows)
        self.assertAlmostEqual(one["mean_slip"], two["mean_slip"], delta=1e-9 * one["mean_slip"])
        self.assertEqual([run.result.run["ranks"] for run in study.runs], [1, 2])

    def test_seeds(self):
        """What makes the fields of a run is called before it, with its seed and folder; the mean over seeds is in the
        picture."""
        shutil.copy(os.path.join(SOURCE, "examples", "make_fault.py"), self.path("make_fault.py"))
        before = (f"{sys.executable} {SOURCE}/examples/make_fault.py {{folder}}/fields.h5 --cells 8 4 --size 8000 4000 "
                  f"--seed {{seed}} --stress 0.5")
        study = Study(folder=self.path("seeds"), seeds=2, before=before,
                      options={"options_file": os.path.join(SOURCE, "examples", "fault_centuries.opts")} and
                      {"nx": 8, "nz": 4, "length_x": 8e3, "length_z": 4e3, "parameters": "{folder}/fields.h5",
                       "ts_max_time": "1y", "output_time_interval": 1e7},
                      options_file=os.path.join(SOURCE, "examples", "fault_centuries.opts"),
                      vary={"loading_rate": [1e-9, 2e-9]}, table=["mean_slip", "accepted"])
        rows = study.run(progress=False).rows
        self.assertEqual([row["status"] for row in rows], ["ended"] * 4, rows)
        self.assertEqual([row["seed"] for row in rows], [1, 2, 1, 2])
        fields = [plan.digest(run.file("fields.h5")) for run in study.runs]
        self.assertEqual((fields[0] == fields[2], fields[0] == fields[1]), (True, False))
        study.plot("mean_slip", "loading_rate", self.path("mean.png"))
        self.assertGreater(os.path.getsize(self.path("mean.png")), 5000)

    def test_tables(self):
        """CSV, pandas and xarray have the same numbers; a dimension for each list, one for a zip."""
        self.write("own.py", OWN.replace("x * x", "x * x + float(sys.argv[3])"))
        study = Study(folder=self.path("own"), command=f"{sys.executable} {self.path('own.py')} {{folder}} {{x}} {{a}}",
                      vary={"x": [1, 3, 2.5]},
                      zip=[{"a": [10, 20], "label": ["p", "q"]}], table=["square", "wall_time"]).run(progress=False)
        self.assertEqual([(row["x"], row["a"], row["square"]) for row in study.rows],
                         [(1, 10, 11), (1, 20, 21), (3, 10, None), (3, 20, None), (2.5, 10, 16.25), (2.5, 20, 26.25)])
        dataset, table = study.dataset, study.table
        self.assertEqual(dataset["square"].dims, ("x", "a_label"))
        self.assertEqual(list(dataset["label"].values), ["p", "q"])
        self.assertEqual(float(dataset["square"].sel(x=2.5)[1]), 26.25)
        self.assertEqual(dataset["wall_time"].attrs["units"], "s")
        self.assertEqual([None if v != v else v for v in table["square"]], [row["square"] for row in study.rows])
        study.write_csv(self.path("out.csv"))
        self.assertEqual([row["square"] for row in self.rows("out.csv")], ["11.0", "21.0", "", "", "16.25", "26.25"])
        self.assertIn("wall_time [s]", self.rows("out.csv")[0])

    def test_pictures_and_lists(self):
        self.own("[1, 2, 3, 4]")
        self.sweep("own.toml", code=1)
        self.assertIn("Figure: own_square.png", self.sweep("own.toml", "--plot", "square", "x"))
        self.assertGreater(os.path.getsize(self.path("own_square.png")), 5000)
        self.assertIn("run, status, x, square", self.sweep("own.toml", "--plot", "cube", "x", code=1))
        self.assertRegex(self.sweep("own.toml", "--list"), r"<run 3: x = 3: failed>\n<run 4: x = 4: ended>")
        os.remove(self.path("own.csv"))
        self.assertIn("4 runs: 3 ended, 1 failed", self.sweep("own.toml", "--table"))
        self.assertEqual(len(self.rows("own.csv")), 4)

    def test_axes_have_units_and_spreads(self):
        """Units of options as the help of the program has them, of columns in the unit that fits; bars of several runs,
        and of a number's own spread."""
        from slipstep.plots import sweep
        from slipstep.running import option_units
        self.assertEqual([option_units()[name] for name in ("normal_stress", "friction_slip", "loading_rate", "dip",
                                                            "density")], ["Pa", "m", "m/s", "degrees", "kg/m^3"])
        self.assertFalse({"nx", "friction_a", "poisson_ratio"} & set(option_units()))
        study = Study(folder=self.path("none"), vary={"normal_stress": [40e6, 50e6], "fault_nx": [4, 5],
                                                      "ts_max_time": [5.0, 6.0]}, table=["recurrence", "events"])
        self.assertEqual([study.unit(name) for name in ("normal_stress", "fault_nx", "ts_max_time", "recurrence",
                                                        "events")], ["Pa", "", "s", "s", ""])
        self.assertEqual(Study(self.own("[1, 2]")).unit("x"), "")
        rows = [{"x": x, "b": b, "y": 3.0e7 * (x + b)} for x in (1, 2) for b in (0, 1)]
        canvas = sweep.figure(rows, "x", "y", "b", {"x": "Pa", "b": "m", "y": "s"},
                              [(2.7e7 * (row["x"] + row["b"]), 3.6e7 * (row["x"] + row["b"])) for row in rows])
        axes, = canvas.axes
        self.assertEqual((axes.get_xlabel(), axes.get_ylabel(), axes.get_legend().get_title().get_text()),
                         ("x (Pa)", "y (years)", "b (m)"))
        self.assertEqual(axes.get_title(loc="left"), "4 runs; bars: spread of each number")
        year = 365.25 * 86400
        ends = [[segment[:, 1] for segment in bars.lines[2][0].get_segments()] for bars in axes.containers]
        self.assertTrue(all(abs(found - expected).max() < 1e-9 for found, expected
                            in zip(ends[1], ([5.4e7 / year, 7.2e7 / year], [8.1e7 / year, 10.8e7 / year]))))
        axes, = sweep.figure(rows, "x", "y", None, {"y": "Pa"}).axes
        segment = axes.containers[0].lines[2][0].get_segments()[0][:, 1]
        self.assertAlmostEqual((segment[1] - segment[0]) / 2 / (3e7 * 0.5 ** 0.5), 1)
        self.assertIn("mean and standard deviation of up to 2", axes.get_title(loc="left"))
        axes, = sweep.figure(rows[:1], "x", "y", None, {"y": "Pa"}).axes
        self.assertFalse(axes.containers[0].has_yerr)

    def test_slurm(self):
        """A job array by stubs of Slurm: each task runs its run; one that is asked to end stops and goes back into the
        queue; over ones are left out."""
        study = Study(self.own("[1, 2, 4, 5]", '[slurm]\ntime = "00:10:00"\npartition = "short"\n'))
        study.task(2)
        self.sweep("own.toml", "--slurm")
        text = self.content("own.slurm.sh")
        for line in ("--array=1,3-4", "--time=00:10:00", "--partition=short", "--mem-per-cpu=2G", "--ntasks=1"):
            self.assertIn(f"#SBATCH {line}\n", text)
        os.mkdir(self.path("bin"))
        os.chmod(self.write("bin/scontrol", '#!/bin/sh\necho "$@" >>"$HOME/requeued"\n'), 0o755)
        program = re.search(r"^(\S+) sweep \S+ --task", text, re.M)[1]
        more = {**environment(), "PATH": f"{self.path('bin')}:{os.environ['PATH']}", "HOME": self.folder.name,
                "SLURM_ARRAY_JOB_ID": "77"}

        def start(task):
            return subprocess.Popen(["bash", self.path("own.slurm.sh")], cwd="/",
                                    env={**more, "SLURM_ARRAY_TASK_ID": str(task)}, stdout=subprocess.PIPE,
                                    stderr=subprocess.STDOUT, text=True)

        self.assertTrue(os.path.exists(program), program)
        said = start(1).communicate(timeout=HANG)[0]
        self.assertEqual(study.runs[0].status, "ended", said)
        self.write("gate", "")
        job = start(3)
        self.wait(lambda: self.began(study)[2] == 1, "the task does not begin")
        job.send_signal(signal.SIGUSR1)
        said = job.communicate(timeout=HANG)[0]
        self.assertEqual((job.returncode, study.runs[2].status), (0, "begun"), said)
        self.assertEqual(self.content("requeued"), "requeue 77_3\n")
        os.remove(self.path("gate"))
        for task in (3, 4, 4):
            job = start(task)
            said = job.communicate(timeout=HANG)[0]
            self.assertEqual(job.returncode, 0, said)
        self.sweep("own.toml", "--table")
        self.assertEqual([row["square"] for row in self.rows("own.csv")], ["1.0", "4.0", "16.0", "25.0"])
        self.assertEqual(self.began(study), [1, 1, 2, 1])
        self.assertEqual(slurm.ranges([1, 2, 3, 7, 9, 10]), "1-3,7,9-10")
        self.assertIn("all runs are over", self.sweep("own.toml", "--slurm", code=1))
        self.assertIn("run 5", self.sweep("own.toml", "--task", "5", code=1))

    def test_ranges(self):
        for given, expected in (({"from": 1, "to": 2, "count": 3}, [1, 1.5, 2]),
                                ({"from": 0.1, "to": 0.5, "step": 0.1}, [0.1, 0.2, 0.3, 0.4, 0.5]),
                                ({"from": 2, "to": 9, "step": 3}, [2, 5, 8]),
                                ({"from": 1, "to": 1000, "count": 4, "spacing": "log"}, [1, 10, 100, 1000]),
                                ([True, False], [True, False])):
            self.assertEqual(plan.values_of("s", "x", given), expected)

    def test_bad_studies(self):
        """One line that names the file, the key and what was expected; nothing runs."""
        for text, message in (("[vary\n", "TOML"), ("varry = 1", "there is no key varry; did " "you mean vary?"),
                              ("[vary]\nx = 3", r"vary.x is 3"),
                              ("[vary]\nx = []", "vary.x is \\[\\]"),
                              ("[vary]\nx = [1, 1]", "no value twice"),
                              ("[vary]\nx = {from = 1, to = 2}", "one of count and step"),
                              ("[vary]\nx = {from = 0, to = 2, count = 3, spacing = \"log\"}", "numbers above 0"),
                              ("[vary]\nx = {from = 1, to = 2, step = -1}", "a step that leads"),
                              ("[options]\nx = 1\n[vary]\nx = [1, 2]", "x is in options and varied"),
                              ("table = [\"x\"]\n[vary]\nx = [1, 2]", "table names x, which is varied"),
                              ("[options]\nnx = 1\n[vary]\nfault_nx = [1, 2]", "fault_nx and another name"),
                              ("[[zip]]\na = [1, 2]\nb = [1]", "lists of one length"),
                              ("[[zip]]\na = [1, 1]\n", "runs 1 and 2 are the same"),
                              ("seeds = -1", "a number of seeds"),
                              ("ranks = 0", "ranks is 0"),
                              ("[options]\noutput = \"a.h5\"", "output is of each run"),
                              ("[options]\nx = [1, 2]", "lists belong into vary"),
                              ("options_file = \"none.opts\"", "cannot read none.opts"),
                              ("command = \"no_such_program {x}\"\n[vary]\nx = [1]",
                               "there is no program no_such_program"),
                              ("table = [\"magnitud\"]", "table names magnitud, which no run has; did you mean "
                               "magnitude?"), ("table = [\"events\", \"events\"]", "which is there twice"),
                              ("table = [\"status\"]", "table names status, which is a column of each table"),
                              ("[vary]\nfolder = [1, 2]", "folder is varied, and is a column of each table"),
                              ("table = [\"coupling\"]",
                               "table names coupling, which needs loading_rate: no run has that"),
                              ("table = [\"stress_drop_area\"]\n[options]\noutput_fields = \"slip\"",
                               "stress_drop_area, which needs output_fields with slip and traction"),
                              ("table = [\"rupture_speed_median\"]\n[options]\noutput_fields = \"slip\"",
                               "which needs catalogue_maps, or output_fields with slip_rate"),
                              ("[options]\nfriction_sip = 0.1", "there is no option -fault_friction_sip: did you mean "
                               "-fault_friction_slip"),
                              ("spin_up = \"5x\"", "spin-up is 5x"),
                              ("spin_up = true", "spin-up is True"),
                              ("[slurm]\narray = \"1-3\"", None),
                              ("cores = true", "cores is True")):
            path = self.write("bad.toml", text)
            if message is None:
                with self.assertRaisesRegex(Error, "slurm.array"):
                    Study(path).slurm(self.path("bad.sh"), ["slipstep"])
                self.assertFalse(os.path.exists(self.path("bad.sh")))
                continue
            with self.subTest(text=text), self.assertRaisesRegex(Error, f"bad.toml.*{message}|{message}"):
                Study(path).run(progress=False)
            self.assertFalse(os.path.exists(self.path("bad.runs"))
                             and [name for name in os.listdir(self.path("bad.runs")) if name != "lock"])
        with self.assertRaisesRegex(Error, "cannot read .*none.toml"):
            Study(self.path("none.toml"))
        with self.assertRaisesRegex(Error, "a file, or a folder"):
            Study(vary={"nx": [1]})

    def test_the_page(self):
        """The study of the how-to page: 3 x 2 x 2 runs with 3 seeds, whose options are those of its file."""
        with open(os.path.join(SOURCE, "examples", "howto", "studies.md"), encoding="utf-8") as file:
            text = re.search(r"(?s)```toml\n(.*?)```", file.read())[1]
        for name in ("fault_centuries.opts", "make_fault.py"):
            shutil.copy(os.path.join(SOURCE, "examples", name), self.path(name))
        study = Study(self.write("study.toml", text))
        self.assertEqual(len(study.runs), 36)
        self.assertEqual(study.runs[-1].values, {"loading_rate": 4e-9, "healing_time": 3e8, "friction_residual": 0.4,
                                                 "normal_stress": 60e6, "seed": 3})
        self.assertEqual(study.runs[12].values["loading_rate"], 2e-9)

    def test_columns_of_faults(self):
        """What an ended run of a fault has in /result is a name that is known before the first run, and what no run has
        is said after the last, with the reason."""
        study = Study(folder=self.path("runs"), options={"nx": 4, "nz": 4, "ts_max_time": "2s"},
                      vary={"ts_bathe_method": ["auto", "implicit"]},
                      table=["recurrence", "b", "mean_slip", "slip_error_check"])
        study.run(progress=False)
        self.assertEqual(study.empty, [("recurrence", "it needs two events of at least half of the largest moment "
                                        "after the spin-up"),
                                       ("b", "it needs 30 events from the magnitude of completeness on"),
                                       ("slip_error_check", "no run has such a number")])
        for run in study.runs:
            for name in run.result.summary:
                table.check_name("study", name)
        sources = glob.glob(os.path.join(SOURCE, "src", "**", "*.c"), recursive=True)
        named = {name for path in sources
                 for name in re.findall(r'SlipOutputAddResult\(\w+, "(\w+)"|"/result", "(\w+)", t->',
                                        pathlib.Path(path).read_text(encoding="utf-8")) for name in name if name}
        self.assertGreater(len(named), 20)
        for name in named - {"event"}:  # a text
            table.check_name("study", name)

    def test_several_processes(self):
        with mock.patch.dict(os.environ, OMPI_COMM_WORLD_SIZE="2"), self.assertRaisesRegex(Error, "own.toml: "):
            Study(self.own()).run()

    def test_damaged_record(self):
        """A record that is no JSON is an error which names it; a column that nobody has is said to be none."""
        study = Study(self.own("[1]")).run(progress=False)
        self.own("[1]")
        text = self.content("own.toml").replace('"square"', '"sqare"')
        self.write("own.toml", text)
        self.assertIn("the column sqare is empty in all runs that ended: no run has such a number; did you "
                      "mean square?", self.sweep("own.toml", "--table"))
        with open(study.runs[0].file("result.json"), "w", encoding="utf-8") as file:
            file.write(json.dumps({"status": "ended"})[:-5])
        self.assertRegex(self.sweep("own.toml", code=1), r"result.json: ")


if __name__ == "__main__":
    unittest.main()
