"""What a run says of itself: rl gives up where no policy was trained, and "likely met" is not said where it is
wrong."""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

from scripts import FAULT, SOURCE

import h5py
import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tests", "benchmarks"))
import verdict

# one process without neighbours starts in a quarter of the time
ALONE = dict(os.environ, OMPI_MCA_ess_singleton_isolated="1", OMPI_MCA_pml="ob1", OMPI_MCA_btl="self")


class Runs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.room = tempfile.TemporaryDirectory()

    @classmethod
    def tearDownClass(cls):
        cls.room.cleanup()

    @classmethod
    def run_fault(cls, *options):
        """Datasets of a run, attributes of its /result, and what it printed as "text"."""
        path = os.path.join(cls.room.name, "run.h5")
        done = subprocess.run([FAULT, *options, "-fault_output", path], capture_output=True, text=True, env=ALONE,
                              timeout=1000)
        assert done.returncode == 0, done.stderr
        found = {"text": done.stdout}
        with h5py.File(path) as file:
            found.update({name: float(value) for name, value in file["result"].attrs.items()})
            file.visititems(lambda name, item: found.update({name: item[()]} if isinstance(item, h5py.Dataset)
                                                            and name not in ("steps/wall", "steps/cost") else {}))
        return found


class Handover(Runs):
    """rl hands a run that no policy was trained for over to the controller that its kind takes by default."""
    STUDY = ["-fault_stiffness_scaling", "mean_slip"]
    BLOCK = [*STUDY, "-fault_nx", "1", "-fault_nz", "1", "-fault_friction_law", "rate_weakening", "-fault_loading_rate",
             "1e-2", "-ts_max_time", "510"]
    LINE = (r"At time 0\. s rl hands the run over to dsp with -ts_rtol (9\.14e-05|0\.01), because the fault is loaded "
            r"or heals or has no inertia")

    @staticmethod
    def events(run):
        """Times at which a block begins to move, the start included, whose row has it at rest."""
        rate = run["series/max_slip_rate"]
        return int(((rate[1:] > 0) & (rate[:-1] == 0)).sum())

    def test_block(self):
        """A block under loading: all numbers are those of dsp, with its options, and those of the default. The policy
        alone slips too often."""
        for more in ([], ["-ts_adapt_dsp_filter", "H211b", "-ts_adapt_safety", "0.8", "-ts_rtol", "1e-2"]):
            ours, theirs = (self.run_fault(*self.BLOCK, "-ts_adapt_type", name, *more) for name in ("rl", "dsp"))
            self.same(ours, theirs)
            self.assertEqual(ours["text"].count("hands the run over"), 1)
            self.assertRegex(ours["text"], self.LINE)
            self.assertIn("handed to dsp at:        0 s", ours["text"])
            self.assertEqual(ours["policy_handover_time"], 0)
            if not more:
                self.assertEqual(self.events(ours), 33)
                default = self.run_fault(*self.BLOCK)
                self.same(default, theirs)
                self.assertEqual(default["text"].count("-ts_adapt_type dsp -ts_rtol 9.14e-05, which keep"), 1)

    def same(self, ours, theirs):
        for name, value in theirs.items():
            if isinstance(value, np.ndarray):
                self.assertTrue(np.array_equal(ours[name], value), f"{name} differs")

    def test_rupture(self):
        """A block under more than its strength, without loading: pi, with its options, and an option is not overridden.
        rl has a policy for it, which keeps its dial in fewer solves than pi takes by default, and says that a tolerance
        is not its own."""
        block = ["-fault_nx", "1", "-fault_nz", "1", "-fault_normal_stress", "50e6", "-fault_normal_stress_gradient",
                 "0", "-fault_initial", "traction", "-fault_initial_traction", "31e6", "-fault_initial_unstable",
                 "-fault_inertia", "no", "-fault_viscosity", "radiation", "-ts_max_time", "20"]
        theirs, default = (self.run_fault(*block, *more, "-ts_adapt_pi_filter", "PI42")
                           for more in (["-ts_adapt_type", "pi"], []))
        self.same(default, theirs)
        self.assertRegex(default["text"], r"-ts_adapt_type pi -ts_adapt_pi_filter PI42 -ts_rtol 0\.0\d+, which keep "
                         r"-fault_accuracy 0\.01,")
        self.assertRegex(default["text"], r"(?m)^tolerance of pi:PI42: +0\.0\d+ for an accuracy of 0\.01$")
        self.assertEqual((default["accuracy"], default["rtol"]), (0.01, theirs["rtol"]))
        other = self.run_fault(*block, "-ts_adapt_type", "heuristic", "-ts_rtol", "1e-3")
        self.assertNotEqual(other["accepted"], theirs["accepted"])
        self.assertNotIn("-ts_adapt_type", other["text"])
        fine = self.run_fault(*block, "-ts_rtol", "1e-6")["mean_slip"]
        for dial in (1e-1, 1e-2):
            ours = self.run_fault(*block, "-ts_adapt_type", "rl", "-ts_adapt_rl_accuracy", f"{dial:g}")
            self.assertNotIn("hands the run over", ours["text"])
            self.assertNotIn("-ts_rtol", ours["text"])
            self.assertLess(abs(ours["mean_slip"] / fine - 1), dial)
            self.assertLess(ours["solves"], theirs["solves"])
        given = self.run_fault(*block, "-ts_adapt_type", "rl", "-ts_rtol", "1e-2")
        self.assertEqual(given["text"].count("-ts_rtol 0.01, of the command line"), 1)

    def test_strict_on_creep(self):
        """A block that creeps: by its policy's steps of 0.1 s a thousand years would take 3e11 of them."""
        run = subprocess.run([FAULT, "-fault_nx", "1", "-fault_nz", "1", "-fault_normal_stress", "50e6",
                              "-fault_friction_law", "constant", "-fault_initial", "rest", "-fault_loading_rate",
                              "1e-9", "-fault_inertia", "no", "-fault_viscosity", "radiation", "-ts_max_time", "3.2e10",
                              "-ts_adapt_type", "rl", "-ts_adapt_rl_strict", "-fault_progress", "no"],
                             capture_output=True, text=True, timeout=300)
        self.assertEqual(run.returncode, 1)
        self.assertIn("-ts_adapt_rl_strict", run.stderr)

    def test_strict(self):
        run = self.run_fault(*self.BLOCK, "-ts_adapt_type", "rl", "-ts_adapt_rl_measure", "final_slip",
                             "-ts_adapt_rl_strict")
        self.assertNotEqual(self.events(run), 32)  # of steps too long; 32 is right
        self.assertNotIn("policy_handover_time", run)
        self.assertNotIn("hands the run over", run["text"])

    def test_centuries(self):
        """40 x 20 cells, 500 years: some hundred steps (the policy alone: 1e9 of 12.9 s)."""
        run = self.run_fault(*self.STUDY, "-fault_nx", "40", "-fault_nz", "20", "-fault_loading_rate", "1e-9",
                             "-ts_max_time", "1.58e10", "-ts_adapt_type", "rl", "-fault_output_interval", "1000000")
        self.assertLess(run["accepted"], 2000)
        self.assertRegex(run["text"], self.LINE)

    def test_outside(self):
        """A duration of 350 T*, longer than any in training: handed over at the third decision, said by one line, and
        what goes on keeps the accuracy of the dial, 1e-2, against a tight run. The policy alone takes steps that are
        too long, and is farther off."""
        fault = [*self.STUDY, "-fault_nx", "3", "-fault_nz", "3", "-ts_max_time", "300"]
        options = [*fault, "-ts_adapt_type", "rl", "-ts_adapt_rl_measure", "final_slip"]
        run, strict = self.run_fault(*options), self.run_fault(*options, "-ts_adapt_rl_strict")
        line = (r"hands the run over to pi:fault_history with -ts_rtol [0-9.e-]+, because its observations stay "
                r"outside the policy's")
        self.assertEqual(len(re.findall(line, run["text"])), 1)
        self.assertEqual(run["policy_outside_range"], 3)
        self.assertTrue(np.array_equal(run["steps/dt"][:2], strict["steps/dt"][:2]))
        later = (run["steps/time"] >= run["policy_handover_time"]) & (run["steps/accepted"] == 1)
        self.assertGreater(later.sum(), 10)
        tight = self.run_fault(*fault, "-ts_adapt_type", "heuristic", "-ts_rtol", "1e-6")
        off, alone = (abs(found["mean_slip"] / tight["mean_slip"] - 1) for found in (run, strict))
        self.assertLess(off, 1e-2)
        self.assertLess(off, alone)
        self.assertGreater(strict["steps/error"].max(), 10)
        self.assertNotIn("policy_handover_time", strict)


class Verdict(Runs):
    """Random faults of tests/benchmarks/verdict.py on which "likely met" or "met" was said before the calibration, and
    was wrong: seed, number, accuracy, the error of the policy's run."""
    SLIP = ["-ts_adapt_type", "rl", "-ts_adapt_rl_measure", "final_slip"]
    WRONG = [(201, 89, 1e-2, 2.9e-2, "graded plane, observations out of range"),
             (202, 54, 1e-2, 2.4e-2, "grid, observations out of range"),
             (201, 31, 1e-2, 3.2e-2, "two planes, 7 steps"), (201, 199, 1e-2, 1.6e-2, "two planes, 9 steps")]

    def case(self, seed, k):
        """Its options and a fine run of it, as read_course() has it."""
        args = argparse.Namespace(build=os.environ["SLIPSTEP_BUILD"], calibrate=False, prove=0, method="implicit")
        case, fine, _ = verdict.reference(args, self.room.name, seed, k)
        return [*case.options, "-ts_max_time", f"{case.duration:.10g}", "-fault_output_interval", "1000000"], fine

    def test_wrong(self):
        """None of them is called met, and the check tells. Where observations stay out of range the run is handed over,
        and is as exact as wanted."""
        for seed, k, dial, error, what in self.WRONG:
            options, fine = self.case(seed, k)
            slip = fine[1].slip[-1]
            rl = [*options, *self.SLIP, "-ts_adapt_rl_accuracy", f"{dial:g}"]
            run = self.run_fault(*rl, "-ts_adapt_rl_strict", "-fault_check_error")
            # still the case that it was: other roundings change its error by less
            self.assertTrue(abs(abs(run["mean_slip"] / slip - 1) - error) < 0.1 * error,
                            f"fault {k} of seed {seed}: error {run['mean_slip'] / slip - 1}")
            self.assertLessEqual(abs(run["slip_error_signed"]), dial, "the first variation believed otherwise")
            self.assertEqual(run["slip_error_estimate_met"], -1, what)
            self.assertIn(f"(wanted {dial:g}: perhaps not met, -fault_check_error measures it)", run["text"])
            self.assertEqual(run["slip_error_check_met"], 0, what)
            self.assertIn(f"(wanted {dial:g}: not met)", run["text"])
            if "range" in what:
                run = self.run_fault(*rl)
                self.assertIn("policy_handover_time", run)
                self.assertLess(abs(run["mean_slip"] / slip - 1), dial)

    def test_said(self):
        """And it is said of the usual fault, where it is true, at every accuracy."""
        options = ["-fault_nx", "12", "-fault_nz", "12", "-fault_stiffness_scaling", "mean_slip"]
        fine = self.run_fault(*options, "-ts_adapt_type", "heuristic", "-ts_rtol", "1e-6")["mean_slip"]
        for dial in (1e-1, 1e-2, 1e-3):
            run = self.run_fault(*options, *self.SLIP, "-ts_adapt_rl_accuracy", f"{dial:g}")
            self.assertEqual(run["slip_error_estimate_met"], 1, f"at {dial}")
            self.assertIn(f"(wanted {dial:g}: likely met)", run["text"])
            self.assertLess(abs(run["mean_slip"] / fine - 1), dial)

    def test_by_tolerance(self):
        """Sequences and injections have the accuracy of which their tolerance is that of the calibration: the one asked
        for, and others by -ts_rtol."""
        loaded = ["-fault_nx", "2", "-fault_nz", "2", "-fault_loading_rate", "1e-2", "-ts_max_time", "5",
                  "-fault_inertia", "no", "-fault_viscosity", "radiation"]
        injected = ["-options_file", os.path.join(SOURCE, "examples", "injection.opts"), "-fault_nx", "8", "-fault_nz",
                    "8", "-fault_initial_traction", "22e6"]
        for options, verdict in ((loaded, "likely met in each event"), (injected, "likely met")):
            for accuracy in (1e-2, 5e-3):
                run = self.run_fault(*options, "-fault_accuracy", repr(accuracy))
                self.assertIn(f"estimated history error: {accuracy:g} (wanted {accuracy:g}: {verdict})", run["text"])
                self.assertEqual(run["slip_error_estimate_met"], 1)
            last = 0
            for rtol in (1e-4, 2e-4, 4e-4):
                run = self.run_fault(*options, "-ts_rtol", repr(rtol))
                self.assertNotIn("likely", run["text"])
                self.assertGreater(run["history_error_estimate"], last)
                last = run["history_error_estimate"]
            # -ts_rtol needs no file, at the end neither
            with mock.patch.dict(ALONE, SLIPSTEP_POLICY_DIR=tempfile.gettempdir()):
                self.assertIn("not estimated (", self.run_fault(*options, "-ts_rtol", "1e-4")["text"])

    def test_unknown(self):
        """What was not calibrated is said to be unknown, with the reason."""
        for options, why in ((["-ts_max_time", "5"], "the fault still slides"),
                             (["-fault_nx", "4", "-fault_nz", "4", "-fault_stiffness_scaling", "none", "-fault_initial",
                               "traction", "-fault_initial_traction", "14e6", "-fault_initial_unstable", "-ts_max_time",
                               "0.2"], "the fault still slides"),  # by TSRKC
                             (["-fault_friction_law", "linear_slip_weakening"], "not calibrated for this friction law"),
                             (["-ts_bathe_error", "none", "-ts_adapt_type", "none", "-ts_dt", "0.3"],
                              "its steps have no error estimates"),
                             (["-ts_bathe_reaction", "implicit"], "not calibrated for this integrator"),
                             (["-fault_inertia", "no", "-fault_viscosity", "radiation"],
                              "not calibrated without inertia"),
                             (["-fault_loading_rate", "1e-2", "-ts_max_time", "5", "-ts_adapt_type", "none", "-ts_dt",
                               "0.1"], "events follow each other"),
                             (["-fault_loading_rate", "1e-2", "-ts_max_time", "5", "-ts_rtol", "1"],
                              "events follow each other"),
                             (["-fault_stiffness_scaling", "none", "-fault_slip_components", "2", "-fault_opening",
                               "yes", "-fault_initial", "traction", "-fault_initial_traction", "20e6",
                               "-fault_initial_unstable", "-fault_inertia", "yes", "-ts_bathe_method", "implicit"],
                              "not calibrated for implicit steps of cells that may open"),
                             (["-ts_adapt_type", "none", "-ts_dt", "10"], "too few steps")):
            run = self.run_fault("-fault_nx", "2", "-fault_nz", "2", "-fault_stiffness_scaling", "mean_slip", *options)
            self.assertIn(f"not estimated ({why})", run["text"])
            for name in ("slip", "history", "event_time"):
                self.assertNotIn(f"{name}_error_estimate", run)

    def test_unknown_with_pressure(self):
        """No estimate was calibrated for faults that heat: an event, a rupture, a sequence, a cycle."""
        heat = ["-fault_nx", "4", "-fault_nz", "3", "-fault_shear_zone_width", "1e-3", "-fault_thermal_pressurisation",
                "1e4"]
        quasi = ["-fault_inertia", "no", "-fault_viscosity", "radiation"]
        loaded = [*quasi, "-fault_loading_rate", "1e-2", "-ts_max_time", "5"]
        for options in (["-ts_max_time", "5"],
                        [*quasi, "-fault_initial", "traction", "-fault_initial_traction", "35e6",
                         "-fault_initial_unstable", "-ts_max_time", "5"],
                        loaded,
                        [*loaded, "-fault_friction_law", "rate_and_state", "-fault_friction_slip", "0.02"]):
            run = self.run_fault(*heat, *options)
            self.assertIn("not estimated (not calibrated where slip changes the pore pressure)", run["text"])
            self.assertNotIn("likely", run["text"])

    def test_factors_of_a_file(self):
        """Factors that a calibration writes are those of a run: errors of 4, 3 and 4 times the measures in runs of up
        to 64 steps, and twice that in longer ones."""
        measure = {f"{name}_error_measure": 0.01 for name in verdict.ATTRIBUTES.values()}
        faults = [{"runs": [{**measure, "explicit": 0, "steps": steps, "errors": dict.fromkeys(verdict.course.PARTS, 0)
                             | {"final": 0.03 * scale, "shift": 0.04 * scale}} for steps, scale in ((50, 1), (70, 2))]}]
        path = os.path.join(self.room.name, "mine.h5")
        with h5py.File(verdict.SHIPPED) as file:
            shipped = file["explicit/factor"][()]
        verdict.write_factors(path, verdict.table_of_factors(faults, "implicit"), faults,
                              argparse.Namespace(method="implicit"), [1], "0")
        with h5py.File(path) as file:
            self.assertEqual(list(file["steps"]), [64, np.inf])
            np.testing.assert_array_equal(file["factor"], [[4, 3, 4], [8, 6, 8]])
            np.testing.assert_array_equal(file["explicit/factor"], shipped)
        run = self.run_fault("-fault_nx", "2", "-fault_nz", "2", "-ts_bathe_method", "implicit", "-fault_estimates",
                             path)
        scale = 1 if run["accepted"] <= 64 else 2
        for name, factor in (("history", 4), ("slip", 3), ("event_time", 4)):
            # two digits
            self.assertAlmostEqual(run[f"{name}_error_estimate"] / (factor * scale * run[f"{name}_error_measure"]), 1,
                                   delta=0.05)
        for name, value, says in (("steps", [64, 64], "infinity"),
                                  ("factor", [[1, 2, 3]], "/factor in"),
                                  ("factor", np.zeros((2, 3)), "a number in row 0 of /factor is 0"),
                                  ("explicit/factor", [[0, 1, 1]] * len(shipped),
                                   "a number in row 0 of /explicit/factor is 0"),
                                  ("measures", np.array(["history", "final_slip", "other"], "S"), 'no "event_time"')):
            bad = os.path.join(self.room.name, "bad.h5")
            shutil.copy(path, bad)
            with h5py.File(bad, "a") as file:
                attributes = dict(file[name].attrs)
                del file[name]
                file[name] = value
                file[name].attrs.update(attributes)
            done = subprocess.run([FAULT, "-fault_nx", "2", "-fault_estimates", bad], capture_output=True, text=True,
                                  env=ALONE, timeout=1000)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn("bad.h5", done.stderr)
            self.assertIn(says, done.stderr)
            self.assertIn("(-fault_estimates)", done.stderr)

    def test_factors_of_explicit_steps(self):
        """A run most of whose steps are explicit has factors of its own, and those of all runs where the file has none,
        as files of 0.4 have."""
        path = os.path.join(self.room.name, "explicit.h5")
        measure = {f"{name}_error_measure": 0.01 for name in verdict.ATTRIBUTES.values()}
        errors = dict.fromkeys(verdict.course.PARTS, 0) | {"final": 0.03, "shift": 0.04}
        faults = [{"runs": [{**measure, "explicit": share, "steps": 70,
                             "errors": {name: scale * error for name, error in errors.items()}}
                            for share, scale in ((0.4, 7), (0.6, 1))]}]
        verdict.write_factors(path, verdict.table_of_factors(faults, "auto"), faults, argparse.Namespace(method="auto"),
                              [1], "0")
        with h5py.File(path) as file, h5py.File(verdict.SHIPPED) as shipped:
            np.testing.assert_array_equal(file["explicit/factor"], [[4, 3, 4]])
            np.testing.assert_array_equal(file["factor"], shipped["factor"])
            of_all = shipped["factor"][-1]
        # 300 steps
        fault = ["-fault_nx", "2", "-fault_nz", "2", "-fault_estimates", path, "-ts_dt", "0.1", "-ts_adapt_type",
                 "none"]
        for method, factors in (("explicit", (4, 3, 4)), ("implicit", of_all), ("explicit", of_all)):
            run = self.run_fault(*fault, "-ts_bathe_method", method)
            for name, factor in zip(("history", "slip", "event_time"), factors):
                self.assertAlmostEqual(run[f"{name}_error_estimate"] / (factor * run[f"{name}_error_measure"]), 1,
                                       delta=0.05, msg=f"{method}: {name}")
            if method == "implicit":
                with h5py.File(path, "a") as file:
                    del file["explicit"]


if __name__ == "__main__":
    sys.exit(unittest.main())
