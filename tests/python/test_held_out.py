"""The held-out benchmark: what it concludes from given runs, the plausibility of its cases, and one small benchmark."""

import os
import subprocess
import sys
import tempfile
import unittest

import scripts  # noqa: F401: before modules that may be missing

import h5py
import numpy as np

sys.dont_write_bytecode = True
BENCHMARKS = os.path.join(os.environ["SLIPSTEP_SOURCE"], "tests", "benchmarks")
sys.path.insert(0, BENCHMARKS)
import held_out_cases
import held_out_run
import held_out_seeds
import held_out_score as score


def run(case, family, setting, solves, slip, history=1.0, failed=""):
    return {"case": case, "group": "g", "kind": "classical", "family": family, "setting": setting, "failed": failed, "solves": solves,
            "rejected": 0, "slip_error": slip, "history_error": history, "peak_error": 0, "half_time_error": 0}


class Score(unittest.TestCase):
    classical = [run("a", "x", 1, 10, -0.2, 0.4), run("a", "x", 0.1, 20, 0.001, 0.2), run("a", "x", 0.01, 40, 0.02, 0.1),
                 run("a", "y", 1, 8, 0.5, 0.9), run("a", "y", 0.1, 30, 0.004, 0.05), run("a", "y", 0.01, 5, 0.0, 0.0, "stopped"),
                 run("b", "x", 1, 12, 0.3), run("b", "x", 0.1, 24, 0.05), run("b", "x", 0.01, 50, 0.001),
                 run("b", "y", 1, 9, 0.05), run("b", "y", 0.1, 33, 0.005), run("b", "y", 0.01, 60, 0.0005)]

    def test_cheapest(self):
        a = [r for r in self.classical if r["case"] == "a"]
        self.assertEqual(score.cheapest(a, 0.01)["solves"], 20)  # the lucky one; the one that stopped does not count
        self.assertEqual(score.cheapest(a, 0.3)["solves"], 10)
        self.assertIsNone(score.cheapest(a, 1e-4))
        # that of x and the tighter one keep it; y's tightest stopped
        self.assertEqual(score.steady(a, 0.05)["solves"], 20)
        self.assertIsNone(score.steady(a, 0.01))  # x loses it again

    def test_interpolation(self):
        solves, errors = [10, 20, 15, 40], [1e-1, 1e-2, 2e-1, 1e-3]
        self.assertEqual(score.envelope(solves, errors).tolist(), [[10, 20, 40], [1e-1, 1e-2, 1e-3]])
        self.assertAlmostEqual(score.solves_at(solves, errors, 10 ** -1.5), np.sqrt(200))
        self.assertEqual(score.solves_at(solves, errors, 0.5), 10)
        self.assertEqual(score.solves_at(solves, errors, 1e-4), np.inf)
        solves, family = score.history_best([r for r in self.classical if r["case"] == "a"], 0.1)
        self.assertEqual(family, "y")  # 8 (30/8)^x, x = log(9)/log(18), is less than the 40 of x
        self.assertAlmostEqual(solves, 8 * (30 / 8) ** (np.log(9) / np.log(18)))

    def test_setting(self):
        setting, runs = score.best_setting(self.classical, 0.01, 0.95)
        # x at 0.1 fails in b, at 0.01 in a, y at 0.01 stopped
        self.assertEqual((setting, runs["b"]["solves"]), (("y", 0.1), 33))
        self.assertIsNone(score.best_setting(self.classical, 1e-4, 0.95)[0])

    def test_seeds(self):
        """Geometric mean of the solves and a quantile of the unsigned errors, one point a position of the dial."""
        rows = [run("a", "s", 1e-1, 4, 0.03), run("b", "s", 1e-1, 9, -0.05), run("a", "s", 1e-2, 20, -0.002), run("b", "s", 1e-2, 20, 0.004)]
        solves, errors = held_out_seeds.curve(rows, held_out_seeds.MEASURES["median"])
        self.assertTrue(np.allclose(solves, [6, 20]) and np.allclose(errors, [0.04, 0.003]))
        self.assertAlmostEqual(held_out_seeds.curve(rows, held_out_seeds.MEASURES["95 % within"])[1][0], 0.049)

    def test_cells(self):
        ours = [run("a", "ours", 1e-2, 10, 1e-7, 0.1), run("b", "ours", 1e-2, 11, -0.02), run("a", "ours", 1e-1, 7, 0.0, 0.0, "stopped")]
        table, chosen = score.cells(ours, self.classical)
        self.assertEqual(chosen[1e-2], ("y", 0.1))
        self.assertEqual(table[0]["error_compared"], 1e-3)  # a tenth of the dial: better than that is luck
        self.assertEqual([table[0][f"ratio_{v}"] for v in ("same_error", "dial", "setting")], [2, 2, 3])
        self.assertEqual([table[1][f"ratio_{v}"] for v in ("same_error", "dial", "setting", "steady")], [3, 3, 3, 3])
        statistics = score.statistics(table)
        self.assertEqual(statistics["ours", 1e-2]["kept"], 0.5)
        self.assertEqual(statistics["ours", 1e-2]["same_error"]["mean"], 2.5)
        self.assertEqual((statistics["ours", 1e-1]["failed"], statistics["ours", 1e-1]["kept"]), (1, 0))

    def test_history(self):
        t = np.linspace(0, 4, 41)
        fine = np.array([t, t ** 2, 2 * t])
        self.assertTrue(np.allclose(held_out_run.interpolate(fine, np.array([0.33, 2.22, 3.99])), np.array([0.33, 2.22, 3.99]) ** 2, atol=1e-3))
        found = held_out_run.errors(np.array([[0, 2, 4], [0, 4.8, 16.0], [0, 4, 8]]), fine)
        self.assertAlmostEqual(found["history_error"], 0.8 / 16)
        self.assertAlmostEqual(found["slip_error"], 0)
        self.assertAlmostEqual(found["half_time_error"], 2 + 2 * 3.2 / 11.2 - np.sqrt(8), places=3)


class Benchmark(unittest.TestCase):
    def test_cases(self):
        cases = held_out_cases.single_cases()
        self.assertEqual(len({c.name for c in cases}), 40)
        self.assertEqual([c.options for c in cases], [c.options for c in held_out_cases.single_cases()])
        for case in cases:
            p = dict(zip((o[7:] for o in case.options[::2]), map(float, case.options[1::2])))
            for name, (low, high, _) in held_out_cases.SINGLE.items():
                value = p[name] / p["length_x"] if name == "thickness" else p[name]
                self.assertTrue(low * (1 - 1e-5) <= value <= high * (1 + 1e-5), f"{case.name}: {name} {value}")
            self.assertTrue(0.5e6 <= p["normal_stress"] * p["friction_drop"] <= 20e6)

    def test_failed_run(self):
        """A run that ends with an error ends its process; its message is kept and the others are done."""
        build, case = os.environ["SLIPSTEP_BUILD"], held_out_cases.single_cases(1)[0]
        jobs = [held_out_run.Job(case, "classical", "x", 0, options) for options in (["-ts_rtol", "1e-1"], ["-ts_rtol", "-3"], ["-ts_rtol", "1"])]
        with tempfile.TemporaryDirectory() as folder:
            found = list(held_out_run.execute(build, jobs, folder))
        self.assertEqual([job for job, _, _ in found], jobs)
        self.assertEqual([read is None for _, read, _ in found], [False, True, False])
        self.assertIn("-ts_rtol is -3", found[1][2])
        self.assertGreater(found[0][1][0]["solves"], found[2][1][0]["solves"])
        done = subprocess.run([os.path.join(build, "bin", "fault"), "-fault_sweep", "none"], capture_output=True, text=True)
        self.assertIn("cannot read none (-fault_sweep)", done.stderr)

    def test_one_case(self):
        """Three families' worth of runs of one fault; the second time nothing is run again."""
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, os.path.join(BENCHMARKS, "held_out.py"), "--build", os.environ["SLIPSTEP_BUILD"], "--folder", folder,
                       "--cases", "one 03"]
            first, second = (subprocess.run(command, capture_output=True, text=True) for _ in range(2))
            self.assertEqual((first.returncode, second.returncode), (0, 0), first.stderr + second.stderr)
            self.assertIn("classical controllers: 160 runs, 0 there already", first.stdout)
            self.assertIn("classical controllers: 160 runs, 160 there already", second.stdout)
            for name in ("summary.png", "curves_one.png"):
                self.assertGreater(os.path.getsize(os.path.join(folder, name)), 10000)
            with h5py.File(os.path.join(folder, "held_out.h5")) as file:
                self.assertLess(file["reference"].attrs["slip_spread"], 5e-6)
                self.assertLess(file["reference"].attrs["constant_steps_spread"], 1e-5)
                kind, error, setting = file["runs/kind"][()].astype(str), abs(file["runs/slip_error"][()]), file["runs/setting"][()]
                family = file["runs/family"][()].astype(str)
                tight = (kind == "classical") & (setting == setting[kind == "classical"].min())
                self.assertTrue((error[tight & (family == "heuristic")] < 1e-4).all())
                self.assertGreater(len(file["cells/ratio_same_error"]), 0)


if __name__ == "__main__":
    sys.exit(unittest.main())
