"""The held-out benchmark: what it concludes from given runs, the plausibility of its cases, and one small benchmark."""

import os
import subprocess
import sys
import tempfile
import unittest

import scripts

import h5py
import numpy as np

sys.dont_write_bytecode = True
BENCHMARKS = os.path.join(scripts.SOURCE, "tests", "benchmarks")
sys.path.insert(0, BENCHMARKS)
from slipstep.results import course
import held_out_cases
import held_out_run
import held_out_score as score


def run(case, family, setting, solves, error, final=0.0, failed=""):
    """history is the largest part"""
    return {"case": case, "group": "g", "kind": "classical", "family": family, "setting": setting, "failed": failed,
            "solves": solves, "rejected": 0,
            "slip_error": -final, "final": final, "history": error, "shift": 0, "peak": 0, "field": 0}


class Score(unittest.TestCase):
    classical = [run("a", "x", 1, 10, 0.2, 0.1), run("a", "x", 0.1, 20, 0.001, 0.001),
                 run("a", "x", 0.01, 40, 0.02, 0.002), run("a", "y", 1, 8, 0.5, 0.3),
                 run("a", "y", 0.1, 30, 0.004, 0.004), run("a", "y", 0.01, 5, 0.0, 0.0, "stopped"),
                 run("b", "x", 1, 12, 0.3, 0.3), run("b", "x", 0.1, 24, 0.05, 0.05),
                 run("b", "x", 0.01, 50, 0.001, 0.001), run("b", "y", 1, 9, 0.05, 0.05),
                 run("b", "y", 0.1, 33, 0.005, 0.005), run("b", "y", 0.01, 60, 0.0005, 0.0005)]

    def test_cheapest(self):
        a = [r for r in self.classical if r["case"] == "a"]
        # those of x at 0.1 and 0.01 keep it; y's tightest stopped
        self.assertEqual(score.cheapest(a, "history", 0.05)["solves"], 20)
        self.assertIsNone(score.cheapest(a, "history", 0.01))  # x loses it again
        self.assertEqual(score.cheapest(a, "final_slip", 0.01)["solves"], 20)
        self.assertEqual(score.cheapest([r for r in self.classical if r["case"] == "b"], "history", 0.05)["solves"], 9)

    def test_interpolation(self):
        solves, errors = [10, 20, 15, 40], [1e-1, 1e-2, 2e-1, 1e-3]
        self.assertEqual(score.envelope(solves, errors).tolist(), [[10, 20, 40], [1e-1, 1e-2, 1e-3]])
        self.assertAlmostEqual(score.solves_at(solves, errors, 10 ** -1.5), np.sqrt(200))
        self.assertEqual(score.solves_at(solves, errors, 0.5), 10)
        self.assertEqual(score.solves_at(solves, errors, 1e-4), np.inf)

    def test_setting(self):
        setting, runs = score.best_setting(self.classical, "history", 0.01)
        # x at 0.1 fails in b, at 0.01 in a, y at 0.01 stopped
        self.assertEqual((setting, runs["b"]["solves"]), (("y", 0.1), 33))
        self.assertIsNone(score.best_setting(self.classical, "history", 1e-4)[0])

    def test_cells(self):
        ours = [run("a", "ours", 1e-2, 10, 0.02, 1e-7), run("b", "ours", 1e-2, 11, 0.005, 0.002),
                run("a", "ours", 1e-1, 7, 0.0, 0.0, "stopped")]
        table, chosen = score.cells(ours, self.classical, "history")
        self.assertEqual(chosen[1e-2], ("y", 0.1))
        a, b, stopped = table
        self.assertEqual([a["ratio_equal"], a["best_equal_by"]], [2, "x, 0.1"])
        self.assertTrue(np.isnan(a["ratio_other"]))  # a tenth of the dial: better than that is luck, but x loses 1e-3
        self.assertEqual([b[f"ratio_{v}"] for v in score.VIEWS], [3, 50 / 11, 3])
        self.assertNotIn("ratio_equal", stopped)
        statistics = score.statistics(table)
        self.assertEqual(statistics["ours", 1e-2, "g"]["kept"], 0.5)
        self.assertEqual(statistics["ours", 1e-2, "all"]["equal"],
                         {"mean": 2.5, "median": 2.5, "least": 2, "below_1": 0, "cells": 2})
        self.assertEqual((statistics["ours", 1e-1, "g"]["failed"], statistics["ours", 1e-1, "g"]["kept"]), (1, 0))
        final, _ = score.cells(ours[:2], self.classical, "final_slip")
        self.assertEqual([final[1]["ratio_equal"], final[1]["ratio_other"]], [50 / 11, 3])


class Benchmark(scripts.ScriptTest):
    build = os.environ.get("SLIPSTEP_BUILD", "build")

    def test_draws(self):
        """Within their ranges, the same for the same seed; twenty of each kind."""
        for kind, row in held_out_cases.KINDS.items():
            for k in range(20):
                path = self.path("fields.h5")
                options, tstar, unit, margin, least = held_out_cases.draw(np.random.default_rng(k), row, k, path)
                self.assertEqual(options, held_out_cases.draw(np.random.default_rng(k), row, k, path)[0])
                p = dict(zip((o[7:] for o in options[::2]), options[1::2]))
                self.assertEqual(p["stiffness_scaling"], "mean_slip" if k % 2 else "none")
                self.assertEqual(p.get("friction_law", ""), row.law)
                with h5py.File(path) as file:
                    n = file["friction_drop"].size
                    drop = (file["normal_stress"][()] * file["friction_drop"][()]).mean()
                    self.assertEqual("cells" in file, row.mesh)
                self.assertEqual("mesh" in p, row.mesh)
                limits = row.cells[0] ** 2, row.cells[1] ** 2 * (2 if row.mesh else 1)
                self.assertTrue(limits[0] <= n <= limits[1], f"{kind}: {n} cells")
                # fields vary, and grow with depth
                self.assertTrue(0.5e6 / 2 < drop < 20e6 * 2, f"{kind}: drop {drop:g} Pa")
                self.assertTrue(held_out_cases.RANGES["margin"][0] <= margin <= held_out_cases.RANGES["margin"][1]
                                and min(tstar, unit, least) > 0)

    def test_runs(self):
        """At least a hundred classical runs of any case, those of one family with tolerances of their own."""
        for case in held_out_cases.mesh_cases() + [held_out_cases.Case("x", "single", [], 1.0, 1.0,
                                                                       held_out_cases.TOLERANCES)]:
            runs = list(held_out_cases.classical(case))
            self.assertGreaterEqual(len(runs), 100)
            self.assertEqual(len({(family, setting) for family, setting, _ in runs}), len(runs))
        self.assertEqual({f for f, _, _ in held_out_cases.classical(case, ["pi PI4", "const"])},
                         {"pi PI42", "constant"})

    def test_filters(self):
        """Every named filter that the program knows is there."""
        for adapt, known in (("dsp", held_out_cases.DSP_FILTERS), ("pi", held_out_cases.PI_FILTERS)):
            done = subprocess.run([os.path.join(self.build, "bin", "fault"), "-ts_adapt_type", adapt, "-help"],
                                  capture_output=True, text=True)
            line, = (line for line in done.stdout.splitlines() if f"-ts_adapt_{adapt}_filter" in line)
            names = set(line.split("(choose one of)" if "(choose one of)" in line
                                   else "(one of)")[1].split("(")[0].split())
            self.assertEqual(names, set(known))

    def test_failed_run(self):
        """A run that ends with an error ends its process; its message is kept and the others are done."""
        case = held_out_cases.Case("x", "one", ["-fault_nx", "1", "-fault_nz", "1"], 0.866, 15.0, [])
        jobs = [held_out_run.Job(case, "classical", "x", 0, options)
                for options in (["-ts_rtol", "1e-1"], ["-ts_rtol", "-3"], ["-ts_rtol", "1"])]
        with tempfile.TemporaryDirectory() as folder:
            found = list(held_out_run.execute(self.build, jobs, folder))
        self.assertEqual([job for job, _, _ in found], jobs)
        self.assertEqual([read is None for _, read, _ in found], [False, True, False])
        self.assertIn("-ts_rtol is -3", found[1][2])
        self.assertGreater(found[0][1][0]["solves"], found[2][1][0]["solves"])
        done = subprocess.run([os.path.join(self.build, "bin", "fault"), "-fault_sweep", "none"], capture_output=True,
                              text=True)
        self.assertIn("-fault_sweep", done.stderr)

    def test_rest(self):
        """Steps of a constant run until it rests, and one for what is left; a run that still moves counts whole."""
        options = ["-ts_adapt_type", "none", "-ts_bathe_error", "none", "-ts_dt", "0.1"]
        found = {}
        for end in (30.0, 5.0):
            case = held_out_cases.Case("x", "one", ["-fault_nx", "1", "-fault_nz", "1"], 0.866, end, [])
            (_, (found[end], run_of), _), = held_out_run.execute(
                self.build, [held_out_run.Job(case, "", "", 0, options)], self.folder.name, held_out_run.read_course)
            self.assertEqual(len(run_of.time), end / 0.1 + 1)
        self.assertEqual(found[30.0]["moving"], round(found[30.0]["rest"] / 0.1) + 1)
        self.assertTrue(5 < found[30.0]["rest"] < 30)
        self.assertTrue(np.isnan(found[5.0]["rest"]) and found[5.0]["moving"] == 50)

    def test_policy_of_another_problem(self):
        """dials runs whatever policy is named. Of a rupture's or an injection's, the library itself would refuse the
        first step of a sequence."""
        policy = os.path.join(scripts.SOURCE, "training", "policies", "rupture.h5")
        done = subprocess.run([os.path.join(self.build, "tests", "dials"), "-problem", "sequence", "-policy", policy,
                               "-cases", "1", "-first", "3",
                               "-controllers", "dsp", "-most_solves", "1"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [line.split("|") for line in done.stdout.splitlines() if line.startswith(("| 0.1 |", "| 0.01 |"))][:2]
        for row in rows:
            self.assertLess(float(row[3]), 0.5)
            self.assertGreater(float(row[4]), 20)

    def test_one_case(self):
        """Two families' worth of runs of one fault; the second time nothing is run again, and another measure is
        scored."""
        folder = self.folder.name
        command = [sys.executable, os.path.join(BENCHMARKS, "held_out.py"), "--build", self.build, "--folder", folder,
                   "--cases", "linear_01",
                   "--families", "heuristic, s", "constant", "--dials", "1e-1", "1e-2", "--sparse"]
        first, second = (subprocess.run([*command, *more], capture_output=True, text=True)
                         for more in (["--no-plot"], ["--measure", "final_slip"]))
        self.assertEqual((first.returncode, second.returncode), (0, 0), first.stderr + second.stderr)
        self.assertIn("classical controllers: 18 runs, 0 there already", first.stdout)
        self.assertIn("classical controllers: 18 runs, 18 there already", second.stdout)
        for name in ("final_slip.png", "final_slip_linear.png"):
            self.assertGreater(os.path.getsize(os.path.join(folder, name)), 10000)
        with h5py.File(os.path.join(folder, "history.h5")) as file:
            self.assertLess(file["reference"].attrs["spread"], held_out_run.FINE_AGREE)
            # 2000 constant steps, an error of second order
            self.assertLess(file["reference"].attrs["constant_steps_spread"], 1e-2)
            family, setting, parts = file["runs/family"][()].astype(str), file["runs/setting"][()], {
                p: file[f"runs/{p}"][()] for p in course.PARTS}
            tight = np.flatnonzero((family == "heuristic, safety 0.9") & (setting == 1e-5))
            self.assertEqual(len(tight), 1)
            self.assertLess(max(parts[p][tight[0]] for p in course.PARTS), 1e-2)
            self.assertEqual(len(file["cells/ratio_equal"]), 2)
        with h5py.File(os.path.join(folder, "final_slip.h5")) as file:
            self.assertEqual(len(file["cells/ratio_equal"]), 2)
        # the options that it leaves are those of the case
        case = os.path.join(folder, f"cases_{held_out_cases.SEED}", "linear_01.opts")
        done = subprocess.run([os.path.join(self.build, "bin", "fault"), "-options_file", case, "-ts_adapt_type", "rl",
                               "-ts_adapt_rl_accuracy", "1e-1"], capture_output=True, text=True)
        self.assertIn("end:", done.stdout, done.stderr)

    def test_no_family(self):
        """A word that begins no family's name is refused before anything runs."""
        wrong = subprocess.run([sys.executable, os.path.join(BENCHMARKS, "held_out.py"), "--build", self.build,
                                "--folder", self.folder.name,
                                "--families", "heuristic", "euler"], capture_output=True, text=True)
        self.assertEqual(wrong.returncode, 1)
        self.assertRegex(wrong.stderr, r"^held_out.py: .*euler \(--families\)")


if __name__ == "__main__":
    sys.exit(unittest.main())
