"""Errors of a run, estimated for nothing and by -fault_check_error, against runs of known error."""

import os
import subprocess
import sys
import tempfile
import unittest

from scripts import FAULT, SOURCE

import h5py
import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tests", "benchmarks"))
import verdict

# one process without neighbours starts in a quarter of the time
ALONE = dict(os.environ, OMPI_MCA_ess_singleton_isolated="1", OMPI_MCA_pml="ob1", OMPI_MCA_btl="self")
ONE = ["-fault_nx", "1", "-fault_nz", "1", "-fault_stiffness_scaling", "mean_slip"]


class SlipError(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.room = tempfile.TemporaryDirectory()
        cls.path = os.path.join(cls.room.name, "run.h5")
        # 20000 constant steps: of second order, 100 of them are off by 1e-3, so these by 1e-7 or less
        run = cls.run_fault(*ONE, "-ts_adapt_type", "none", "-ts_bathe_error", "none", "-ts_dt", "0.0015")
        cls.fine, cls.fine_run = run["mean_slip"], run["run"]

    @classmethod
    def tearDownClass(cls):
        cls.room.cleanup()

    @classmethod
    def run_fault(cls, *options, ranks=1):
        """Attributes of /result, and what was printed as "text"."""
        command = [FAULT, *options, "-fault_output", cls.path]
        if ranks > 1:
            command = ["mpirun", "--oversubscribe", "-n", str(ranks), *command]
        done = subprocess.run(command, capture_output=True, text=True, env=ALONE if ranks == 1 else None)
        assert done.returncode == 0, done.stderr
        with h5py.File(cls.path) as file:
            result = {name: float(value) for name, value in file["result"].attrs.items()}
            rows = {group: len(file[group]["time"]) for group in ("steps", "series", "fields")}
        return {**result, **rows, "text": done.stdout, "run": verdict.read_course(cls.path)}

    def error(self, run):
        return run["mean_slip"] / self.fine - 1

    def test_constant_steps(self):
        """With constant steps the first variation is the error, to first order in the step: right in sign, and within a
        factor of two where the arrest, whose own error the smooth formula does not know, falls somewhere within a
        step."""
        for steps in (50, 100, 200, 400):
            run = self.run_fault(*ONE, "-ts_adapt_type", "none", "-ts_dt", str(30 / steps))
            ratio = run["slip_error_signed"] / self.error(run)
            self.assertTrue(0.5 < ratio < 2, f"{steps} steps: estimated over true error {ratio}")

    def test_vectors(self):
        """Slip as a vector: what moves along the strike has the estimates that it has with one component, and along
        another rake the estimate is on the safe side, as with one."""
        for method in ("implicit", "explicit"):
            steps = ["-ts_adapt_type", "none", "-ts_dt", "0.15", "-ts_bathe_method", method]
            one, two = (self.run_fault(*ONE, *steps, "-fault_slip_components", c) for c in "12")
            for name in ("slip_error_signed", "history_error_measure", "event_time_error_measure"):
                self.assertAlmostEqual(two[name] / one[name], 1, delta=1e-6, msg=f"{method}: {name}")
            oblique = [*ONE, "-fault_slip_components", "2", "-fault_rake", "40", "-fault_normal_coupling", "no",
                       "-ts_bathe_method", method]
            run, fine = (self.run_fault(*oblique, "-ts_adapt_type", "none", "-ts_dt", dt) for dt in ("0.15", "0.01"))
            ratio = (run["history_error_estimate"]
                     / verdict.measured({"errors": verdict.errors(run["run"], fine["run"])}, "history"))
            self.assertTrue(1 <= ratio < 30, f"{method}: estimated over true error {ratio}")
            self.assertNotIn("not estimated", run["text"])

    def test_timing(self):
        """Likewise the first variation of the event's time, which knows no arrest: off by a share that falls with the
        step, 9 % at 100 steps and 2 % at 400 here."""
        for steps in (50, 100, 200, 400):
            run = self.run_fault(*ONE, "-ts_adapt_type", "none", "-ts_dt", str(30 / steps))
            ratio = run["event_time_error_measure"] / verdict.errors(run["run"], self.fine_run)["shift"]
            self.assertLess(abs(ratio - 1), 12 / steps, f"{steps} steps: estimated over true shift {ratio}")

    def test_safe_side(self):
        """What is printed is rarely too small and seldom useless: between the error and 30 times it for usual
        controllers."""
        for options in (["-ts_adapt_type", "heuristic", "-ts_rtol", "1e-2"],
                        ["-ts_adapt_type", "heuristic", "-ts_rtol", "1e-1"],
                        ["-ts_adapt_type", "basic", "-ts_rtol", "1e-2"],
                        ["-ts_adapt_type", "pi", "-ts_rtol", "1e-1"], ["-ts_adapt_type", "dsp", "-ts_rtol", "1e-2"]):
            run = self.run_fault(*ONE, *options)
            ratio = run["slip_error_estimate"] / abs(self.error(run))
            self.assertTrue(1 <= ratio < 30, f"{options}: estimated over true error {ratio}")
            errors = verdict.errors(run["run"], self.fine_run)
            for measure, name in verdict.ATTRIBUTES.items():
                ratio = run[f"{name}_error_estimate"] / verdict.measured({"errors": errors}, measure)
                self.assertTrue(1 <= ratio < 30, f"{options}: estimated over true error of {measure} {ratio}")
            self.assertIn("estimated history error:", run["text"])
            # and by the policy for each measure
        for measure, label in (("history", "history"), ("final_slip", "slip"), ("event_time", "time")):
            text = self.run_fault(*ONE, "-ts_adapt_type", "rl", "-ts_adapt_rl_measure", measure)["text"]
            self.assertIn(f"estimated {label} error:", text)

    def test_check(self):
        """Richardson's estimate of a method of order 2 (1 when implicit): the leading term, so within a factor of two
        here. The repetition leaves no rows and no counts in the output of the run."""
        for options in (["-ts_adapt_type", "heuristic", "-ts_rtol", "1e-2"],
                        ["-ts_adapt_type", "none", "-ts_dt", "0.3"],
                        ["-ts_adapt_type", "heuristic", "-ts_bathe_error", "doubling", "-ts_rtol", "1e-2"],
                        ["-ts_adapt_type", "dsp", "-ts_rtol", "1e-2"],
                        ["-ts_adapt_type", "heuristic", "-ts_bathe_reaction", "implicit", "-ts_rtol", "1e-1"]):
            plain = self.run_fault(*ONE, *options)
            run = self.run_fault(*ONE, *options, "-fault_check_error")
            ratio = run["slip_error_check_signed"] / self.error(run)
            self.assertTrue(0.5 < ratio < 2, f"{options}: checked over true error {ratio}")
            errors = verdict.errors(run["run"], self.fine_run)
            for name, error in errors.items():
                ratio = run[f"check_error_{name}"] / error
                self.assertTrue(0.5 < ratio < 2, f"{options}: checked over true error {name} {ratio}")
            for measure, name in verdict.ATTRIBUTES.items():
                # printed to two digits
                self.assertTrue(np.isclose(run[f"{name}_error_check"],
                                           verdict.measured({"errors": {k: run[f"check_error_{k}"] for k in errors}},
                                                            measure), rtol=0.051))
            for name in ("mean_slip", "solves", "accepted", "rejected", "steps", "series", "fields"):
                self.assertEqual(run[name], plain[name], f"{options}: {name}")
            self.assertGreaterEqual(run["check_solves"], 2 * run["accepted"] * 0.8)

    def test_ranks(self):
        """The sums do not depend on the distribution, but for rounding that a controller divides by (compare
        test_fault_ranks)."""
        mesh = ["-fault_nx", "6", "-fault_nz", "5", "-ts_rtol", "1e-2", "-fault_check_error"]
        one, two = self.run_fault(*mesh), self.run_fault(*mesh, ranks=2)
        for name in ("slip_error_signed", "slip_error_check_signed", "history_error_measure",
                     "event_time_error_measure", "check_error_history", "check_error_field"):
            self.assertTrue(np.isclose(one[name], two[name], rtol=1e-4),
                            f"{name}: {one[name]}, on two ranks {two[name]}")

    def test_absent(self):
        """No number where nothing is known: no local errors, or the fault still slides."""
        for options in (["-ts_adapt_type", "none", "-ts_bathe_error", "none", "-ts_dt", "0.3"], ["-ts_max_time", "10"]):
            run = self.run_fault(*ONE, *options)
            self.assertNotIn("slip_error_estimate", run)
            self.assertIn("estimated history error: not estimated (", run["text"])

    def test_dial(self):
        """A policy that observes log_accuracy has its dial judged; any other has not."""
        policy = os.path.join(self.room.name, "dial.h5")
        with h5py.File(policy, "w") as f:  # h = 0.3 s (1e-3) to 0.6 s (1e-1), as good as constant
            f.attrs.update({"format": "slipstep-policy", "version": 1, "algorithm": "by hand"})
            f["observation/names"] = np.array(["log_accuracy"], dtype=h5py.string_dtype())
            f["observation/scale"], f["observation/offset"] = np.ones(1), np.zeros(1)
            f["layers/0/weight"], f["layers/0/bias"] = np.array([[0.5]]), np.array([1.0])
            f["layers/0"].attrs["activation"] = "linear"
            f.create_group("action").attrs.update({"low": -1.0, "high": 1.0, "squash": "tanh", "dt_min": 0.25,
                                                   "dt_max": 0.65,
                                                   "dt_min_unit": "s", "dt_max_unit": "s"})
        for wanted, verdict, check in (("0.1", "likely met", "met"),
                                       ("0.0001", "perhaps not met, -fault_check_error measures it", "not met")):
            run = self.run_fault(*ONE, "-ts_adapt_type", "rl", "-ts_adapt_rl_policy", policy, "-ts_adapt_rl_accuracy",
                                 wanted, "-fault_check_error")
            self.assertEqual(run["accuracy_requested"], float(wanted))
            self.assertEqual(run["slip_error_estimate_met"], 1 if verdict == "likely met" else -1)
            self.assertEqual(run["slip_error_check_met"], abs(self.error(run)) <= float(wanted))
            for word in (verdict, check):
                self.assertIn(f"(wanted {wanted}: {word})", run["text"])
        self.assertNotIn("accuracy_requested", self.run_fault(*ONE, "-ts_adapt_type", "pi"))


if __name__ == "__main__":
    sys.exit(unittest.main())
