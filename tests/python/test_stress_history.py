#!/usr/bin/env python3
"""Stresses in time of the program fault: the same as other options that make them, and in the same energies; closed
forms of rate-and-state friction under a tide; restarts; and bad input, which is one line that names it."""
import os
import subprocess
import unittest

from scripts import FAULT, ScriptTest

import h5py
import numpy as np

from slipstep import OutputError, Run
from slipstep.modules import ENVIRONMENT
from slipstep.programs.tides import Tide, schuster, tides_of

STICKING = ("-fault_nx 3 -fault_nz 2 -fault_normal_stress 5e7 -fault_normal_stress_gradient 0 -fault_initial traction "
            "-fault_initial_traction 1e7 -ts_max_time 120 -fault_friction_law linear_slip_weakening")
SMOOTH = ("-fault_nx 4 -fault_nz 3 -fault_friction_law rate_and_state -fault_friction_slip 0.004 -fault_normal_stress "
          "5e7 -fault_normal_stress_gradient 0 -ts_max_time 5.35y -fault_loading_rate 1e-9")
# one soft cell that strengthens with rate, a sigma = 0.5 MPa
BLOCK = ("-fault_length_x 9e5 -fault_length_z 9e5 -fault_friction_law rate_and_state -fault_friction_a 0.01 "
         "-fault_friction_b 0.006 -fault_friction_slip 0.001 -fault_normal_stress 5e7 -fault_normal_stress_gradient 0 "
         "-fault_loading_rate 1e-9 -fault_initial_rate 1e-9 -fault_tide_shear 1e5 -ts_rtol 1e-4 -ts_adapt_type pi")


class StressHistory(ScriptTest):
    def fault(self, options, *more, ranks=1):
        start = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
        return subprocess.run([*start, FAULT, *options.split(), *more, "-fault_progress", "no",
                               "-fault_output_overwrite", "yes"], cwd=self.folder.name, encoding="utf-8",
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
                              env={**ENVIRONMENT, **os.environ})

    def run_fault(self, options, *more, name="run", ranks=1, code=0):
        done = self.fault(options, *more, "-fault_output", f"{name}.h5", "-fault_catalogue", f"{name}_events.h5",
                          ranks=ranks)
        self.assertEqual(done.returncode, code, done.stdout)
        return done.stdout

    def history(self, name="stress.h5", **terms):
        with h5py.File(self.path(name), "w") as file:
            for term, datasets in terms.items():
                for key, value in datasets.items():
                    file[f"{term}/{key}"] = value

    def events(self, *columns, name="run"):
        return self.get(f"{name}_events.h5", *columns)

    def test_normal_stress_is_pressure(self):
        """The same numbers to rounding, by every kind of step, and in the file's either form."""
        pressure = np.array([0, 2e7, 4e7])
        self.hdf5("pressure.h5", time=[0.0, 50, 100], pressure=np.multiply.outer(pressure, np.ones((2, 3))))
        self.put("stress.csv", "# of a spreadsheet\n\"time\", normal\r\n0,0\r\n\r\n50,-2e7\n100,-4e7\n")
        self.history(a={"time": [0.0, 50, 100], "course": [0, 0.5, 1.0], "normal": np.full((2, 3), -4e7)})
        for steps in ("-fault_inertia no", "-fault_inertia yes", "-fault_inertia no -ts_type rkc"):
            found = []
            for load in ("-fault_pore_pressure pressure.h5", "-fault_stress_history stress.h5",
                         "-fault_stress_history stress.csv"):
                self.run_fault(f"{STICKING} {steps} {load}")
                found.append(np.concatenate([self.get("run.h5", "series/mean_slip")[-1:],
                                             *self.events("onset", "moment", "dissipated_energy", "elastic_energy")]))
            self.assertGreater(found[0][0], 0.1)
            for other in found[1:]:  # onsets differ by rounding, which stiff friction does not amplify
                np.testing.assert_allclose(other, found[0], rtol=1e-6)

    def test_shear_is_a_stressing_rate(self):
        """A course of a line: events and their energies are those of the rate, to the errors of steps, 2e-3 of the
        recurrence, and of powers over steps."""
        self.history(a={"time": [0, 1e9], "course": [0, 1.0], "shear": 1e7})
        self.run_fault(SMOOTH, "-fault_stressing_rate", "0.01", name="rate")
        self.run_fault(SMOOTH, "-fault_stress_history", "stress.h5", name="history")
        one, other = (self.events("onset", "moment", "dissipated_energy", "elastic_energy", name=name)
                      for name in ("rate", "history"))
        self.assertGreater(len(one[0]), 1)
        np.testing.assert_allclose(other[0], one[0], rtol=2e-3)
        for a, b in zip(one[1:], other[1:]):
            np.testing.assert_allclose(b, a, rtol=1e-2)
        self.assertLess(np.abs(self.events("energy_residual", name="history")).max(), 0.01)
        work, heat = self.events("loading_work", "dissipated_energy", name="history")
        self.assertLess(np.abs(work).max(), 1e-2 * heat.min())  # 20 s of 0.01 Pa/s

    def test_terms_add_up(self):
        """Two halves are the whole, shear by the rake is a vector along it, and pressure adds."""
        whole = {"time": [0, 100.0], "course": [0, 1.0], "shear": 3e7}
        half = {**whole, "shear": np.full(6, 1.5e7)}
        vector = {**whole, "shear": np.stack([np.full((2, 3), 3e7), np.zeros((2, 3))], -1)}
        slips = []
        for terms in ({"a": whole}, {"a": half, "b": half}, {"a": vector}):
            self.history(**terms)
            said = self.run_fault(STICKING, "-fault_inertia", "no", "-fault_stress_history", "stress.h5", "-fault_view")
            self.assertEqual(said.count("stress in time: stress.h5/"), len(terms))
            slips.append(self.get("run.h5", "series/mean_slip")[-1])
        self.assertGreater(slips[0], 0.1)
        np.testing.assert_allclose(slips, slips[0], rtol=1e-9)

    def response(self, period, end, *more):
        """The amplitude of ln(V/V0) over the last period."""
        self.run_fault(BLOCK, "-fault_tide_period", str(period), "-ts_max_time", str(end), *more)
        time, rate = self.get("run.h5", "series/time", "series/max_slip_rate")
        last = np.log(rate[time > end - period])
        return (last.max() - last.min()) / 2

    def test_tides_and_rate_and_state(self):
        """dtau/(a sigma) at periods far below d_c/V = 1e6 s, dtau/((a - b) sigma) far above it, and below the
        time of some 1e9 s in which the stiffness of the block answers."""
        for steps in ("adams", "bathe", "rk"):
            with self.subTest(steps):
                self.assertAlmostEqual(self.response(1e4, 3e4, "-ts_type", steps) / (1e5 / 5e5), 1, delta=0.02)
        self.assertAlmostEqual(self.response(6e8, 1.2e9) / (1e5 / 2e5), 1, delta=0.02)

    def test_restart(self):
        """Bit by bit, on one and two ranks."""
        self.history(a={"time": [0, 1e8], "course": [0, 1.0], "shear": 1e6, "normal": np.linspace(-1e5, 1e5, 12)})
        loads = ("-fault_stress_history stress.h5 -fault_tide_period 20d,1y -fault_tide_shear 1e4,1e5 "
                 "-fault_nucleation 1500,1500,1000,2e5,1e7").split()
        for ranks in (1, 2):
            for steps in ("adams", "bathe"):
                with self.subTest(ranks=ranks, steps=steps):
                    more = [*loads, "-ts_type", steps, "-ts_max_time", "1y"]
                    self.run_fault(SMOOTH, *more, name="whole", ranks=ranks)
                    self.run_fault(SMOOTH, *more, "-fault_checkpoint", "state", "-ts_max_steps", "30", name="part",
                                   ranks=ranks, code=3)
                    self.run_fault(SMOOTH, *more, "-fault_restart", "state", name="part", ranks=ranks)
                    for path in ("series/time", "series/max_slip_rate", "series/mean_slip"):
                        whole, part = self.get("whole.h5", path), self.get("part.h5", path)
                        self.assertGreater(len(whole), 60)
                        self.assertEqual(whole.tobytes(), part.tobytes())

    def test_phases(self):
        """Schuster's p of phases that are all the same, evenly spread, and drawn; what slipstep tides refuses."""
        self.assertAlmostEqual(schuster([30.0] * 5)[0], np.exp(-5))
        self.assertAlmostEqual(schuster([30.0] * 5)[1], 30)
        self.assertAlmostEqual(schuster(np.arange(0, 360, 30.0))[0], 1)
        random = np.random.default_rng(1)  # p is uniform: a tenth below 0.1, within three standard deviations of 1000
        below = np.mean([schuster(random.uniform(0, 360, 200))[0] < 0.1 for _ in range(1000)])
        self.assertAlmostEqual(below, 0.1, delta=3 * np.sqrt(0.09 / 1000))
        tide = Tide(100.0, 1e3, 0.0, 30.0)
        self.assertAlmostEqual(float(tide.phase(1025.0)), 120)
        self.assertAlmostEqual(float(tide.course(1025.0)), np.sin(np.radians(120)))
        self.run_fault(STICKING, "-fault_inertia", "no")
        with self.assertRaisesRegex(OutputError, "of a run without tides"):
            tides_of(Run(self.path("run.h5")))

    def test_bad_input(self):
        good = {"time": [0, 1.0], "course": [0, 1.0], "shear": 1e6}
        lines = {"times,shear\n0,1\n": "line 1: expected time,shear,normal",
                 "time\n0\n": "line 1", "time,shear\n0,1\n1\n": "line 3: expected 2 finite numbers",
                 "time,shear\n": "has no times", "time,normal\n1,0\n1,0\n": "normal: time[1] is 1 s",
                 "time,shear\n0,nan\n": "line 2: expected 2 finite numbers",
                 "time,shear\n0,1" + 300 * "0" + "x\n": "line 2"}
        for text, words in lines.items():
            self.put("bad.csv", text)
            self.refused(["-fault_stress_history", "bad.csv"], words)
        files = {"time[1] is 0 s, expected finite times": {"a": {**good, "time": [0, 0.0]}},
                 "/a/course in bad.h5 has shape [3], expected [2]": {"a": {**good, "course": [0, 1, 2.0]}},
                 "has no dataset /a/course": {"a": {"time": [0.0], "shear": 1.0}},
                 "there is neither shear nor normal": {"a": {"time": [0.0], "course": [1.0]}},
                 "holds /a/normals, which nothing reads": {"a": {**good, "normals": 1.0}},
                 "shape [2, 2], expected [2, 3]": {"a": {**good, "shear": np.ones((2, 2))}},
                 "shape [5], expected [6]": {"a": {**good, "normal": np.ones(5)}},
                 "shear[3] is nan": {"a": {**good, "shear": [0, 0, 0, np.nan, 0, 0]}},
                 "is empty, expected a group": {}}
        for words, terms in files.items():
            self.history("bad.h5", **terms)
            self.refused(["-fault_stress_history", "bad.h5"], words)
        self.history("bad.h5", a=good)
        with h5py.File(self.path("bad.h5"), "a") as file:
            file["a/shear"].attrs["units"] = "MPa"
        self.refused(["-fault_stress_history", "bad.h5"], "/a/shear of bad.h5 has the units \"MPa\", expected \"Pa\"")
        self.refused(["-fault_stress_history", "none.h5"], "none.h5")
        for options, words in {
                "-fault_tide_period 10": "-fault_tide_period 10 needs amplitudes",
                "-fault_tide_shear 1e5": "need -fault_tide_period",
                "-fault_tide_period 10,20 -fault_tide_shear 1e5": "-fault_tide_shear is \"1e5\", expected 2 numbers",
                "-fault_tide_period 0 -fault_tide_shear 1e5": "-fault_tide_period is \"0\", expected numbers > 0",
                "-fault_tide_period 1x -fault_tide_shear 1e5": "-fault_tide_period is \"1x\"",
                "-fault_tide_period 10 -fault_tide_normal nan": "-fault_tide_normal is \"nan\"",
                "-fault_tide_period 10 -fault_tide_normal 1 -fault_tide_phase 0,0": "-fault_tide_phase is \"0,0\"",
                "-fault_nucleation 1,2,3": "-fault_nucleation is \"1,2,3\", expected two numbers x,z",
                "-fault_nucleation 1500,1500,0,1,1": "the radius 0",
                "-fault_nucleation 9e4,1500,10,1,1": "no cell's centre within its radius of 10"}.items():
            self.refused(options.split(), words)

    def refused(self, more, words):
        done = self.fault(STICKING, *more)
        errors = [line for line in done.stdout.splitlines() if "error:" in line]
        self.assertTrue(done.returncode and len(errors) == 1, done.stdout)
        self.assertIn(words, errors[0])


if __name__ == "__main__":
    unittest.main()
