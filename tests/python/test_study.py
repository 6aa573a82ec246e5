"""The reader, figures and tables of a study, on a synthetic file in the format of evaluate with known numbers."""

import os
import re
import tempfile
import unittest

from scripts import SOURCE, ScriptTest

import h5py
import numpy as np

from slipstep import OutputError, Run
from slipstep.programs.plot_study import shown_policies, transfers
from slipstep.programs.results_table import advantage, contents, equal_accuracy, fill, number, processor_time, published
from slipstep.results.course import Course, slip_at
from slipstep.results.study import Study, cheapest, envelope, family

COLUMNS = "time s, mean_slip m, mean_slip_rate m/s, max_slip_rate m/s"
CASE = "fault_3km_25x25"


def write_cell(file, name, controller, solves, error, treatment=("embedded", "trapezoidal"), tolerance=1.0, policy=None,
               alpha=np.nan, converged=1, guarded=0, max_error=None, case=CASE, mesh=25, size=3.0):
    group = file.create_group(f"cells/{case}/{name}_{treatment[0]}_{treatment[1]}")
    max_error = 2 * abs(error) if max_error is None else max_error
    group.attrs.update({
        "problem": "fault", "size_km": size, "mesh": mesh, "controller": controller, "error": treatment[0],
        "reaction": treatment[1],
        "tolerance": tolerance, "steps": 0, "converged": converged, "accepted": solves, "rejected": 0, "solves": solves,
        "newton_iterations": 3 * solves, "linear_iterations": 9 * solves, "failures": 0, "guarded": guarded,
        "repetitions": 1,
        "final": 0.24 * (1 + error), "final_error": error, "max_error": max_error, "l2_error": max_error,
        "rate_error": max_error,
        "wall": 0.01 * solves, "wall_min": 0.01 * solves, "wall_max": 0.01 * solves, "wall_setup": 0.1,
        "cpu": 0.01 * solves,
        "reason": "" if converged else "did not converge"})
    if policy:
        group.attrs.update({"policy": policy, "policy_hash": "0", "policy_algorithm": "tqc", "policy_alpha": alpha,
                            "policy_file": policy})
    time = np.linspace(0, 30, 11)
    # mean slip between the steps: the reference and a bump that is max_error of the final slip high at 15 s, with flat
    # rates there
    bump = 0.24 * max_error * np.where(time == 15, 1, 0)
    rows = np.stack([time, 0.008 * time + bump, 0.008 + 0 * time, 0.01 + 0 * time], axis=1)
    group.create_dataset("series", data=rows).attrs["columns"] = COLUMNS
    group["attempts"] = np.stack([time[:-1], np.diff(time), 1 + 0 * time[1:], 0.5 + 0 * time[1:], 1 + 0 * time[1:]],
                                 axis=1).astype("f4")
    group["profile"] = np.concatenate([time[:, None], np.ones((11, mesh)) * 0.008], axis=1).astype("f4")


def write_study(path):
    """Three classical runs: 100 solves for 0.1 %, 40 for 1 %, 20 for 10 %; policies with 10 solves each."""
    with h5py.File(path, "w") as file:
        file.attrs.update({"format": "slipstep-evaluation", "version": 1, "settings": ""})
        for k, (solves, error) in enumerate(((100, 1e-3), (60, 3e-3), (40, 1e-2), (20, -0.1))):
            write_cell(file, f"heuristic_x{10**k}", "heuristic", solves, error, tolerance=10.0**k)
        write_cell(file, "heuristic_x1", "heuristic", 300, 3e-3, ("doubling", "implicit"))
        write_cell(file, "pi_x1", "pi", 240, 3e-3, ("doubling", "implicit"))
        for alpha, error, converged in ((1.0, 5e-3, 1), (2.0, -0.05, 1), (8.0, 0.01, 0)):
            for treatment in (("embedded", "trapezoidal"), ("doubling", "implicit")):
                write_cell(file, f"rl_p_alpha_{alpha:g}", "rl", 10 if treatment[0] == "embedded" else 30, error,
                           treatment, policy=f"p_alpha_{alpha:g}", alpha=alpha,
                           converged=converged, guarded=int(alpha == 2.0))
        reference = file.create_group(f"references/{CASE}")
        reference.attrs.update({"problem": "fault", "size_km": 3.0, "mesh": 25, "kind": "constant steps", "steps": 4000,
                                "self_final": 1e-6, "self_max": 1e-5, "wall": 1.0, "final": 0.24})
        time = np.linspace(0, 30, 101)
        rows = np.stack([time, 0.008 * time, 0.008 + 0 * time, 0.01 + 0 * time], axis=1)
        reference.create_dataset("series", data=rows).attrs["columns"] = COLUMNS
        reference["profile"] = np.concatenate([time[:, None], np.ones((101, 25)) * 0.008], axis=1).astype("f4")
    return path


class StudyTest(ScriptTest):
    def test_reads_cells_and_references(self):
        study = Study(write_study(self.path("s.h5")))
        cell = study.one(policy="p_alpha_2", error="embedded")
        self.assertEqual((cell["solves"], cell.name, cell.case, cell.error()), (10, "p_alpha_2", CASE, 0.05))
        self.assertEqual(set(cell.series()), {"time", "mean_slip", "mean_slip_rate", "max_slip_rate"})
        self.assertEqual(len(cell.attempts()["dt"]), 10)
        self.assertEqual(study.reference(CASE)["mean_slip"][-1], 0.24)
        self.assertEqual(study.sweeps(), {"p": {1.0: "p_alpha_1", 2.0: "p_alpha_2", 8.0: "p_alpha_8"}})
        self.assertIsNone(study.one(policy="nobody"))
        with self.assertRaisesRegex(OutputError, "fault_9km"):
            study.reference("fault_9km")

    def test_family(self):
        for name, expected in (("fault_tqc_alpha_0.5", "fault_tqc"), ("fault-a16", "fault"), ("fault", "fault"),
                               ("fault_tqc_alpha8_mesh30", "fault_tqc_mesh30")):
            self.assertEqual(family(name), expected)

    def test_transferred_policies_are_paired_by_name(self):
        path = write_study(self.path("s.h5"))
        with h5py.File(path, "a") as file:
            write_cell(file, "rl_p_alpha_8_mesh30", "rl", 9, 0.01, policy="p_alpha_8_mesh30", alpha=8.0)
        study = Study(path)
        self.assertEqual(transfers(study), [("p_alpha_8_mesh30", "p_alpha_8")])
        self.assertNotIn("p_alpha_8_mesh30", study.sweeps()["p"].values())

    def test_cells_of_a_replaced_policy_are_left_out(self):
        path = write_study(self.path("s.h5"))
        with h5py.File(path, "a") as file:
            # p_alpha_2 and one setting of its dial with a newer file; the cell of another treatment is still of the old
            # one
            write_cell(file, "rl_p_alpha_2@0.1", "rl", 7, 0.01, policy="p_alpha_2", alpha=2.0)
            for name, accuracy in (("rl_p_alpha_2", 0.0), ("rl_p_alpha_2@0.1", 0.1)):
                file[f"cells/{CASE}/{name}_embedded_trapezoidal"].attrs.update(
                    {"policy_hash": "1", "accuracy": accuracy, "created": "2026-11-21T17:00:00Z"})
        study = Study(path)
        self.assertEqual(study.outdated, {"p_alpha_2": 1})
        self.assertEqual([cell.treatment for cell in study.select(policy="p_alpha_2")], [("embedded", "trapezoidal")])
        self.assertEqual(len(study.select(policy="p_alpha_2@0.1")), 1)
        self.assertEqual(len(study.select(policy="p_alpha_1")), 2)
        done = self.script("plot-study", path, "--figures", self.path("figures"), "--only", "steps")
        self.assertEqual(done.returncode, 0)
        self.assertRegex(done.stderr, "^slipstep plot-study: warning: .*s.h5 has 1 cells .*p_alpha_2")

    def test_crowded_panels_show_one_of_a_kind(self):
        path = write_study(self.path("s.h5"))
        with h5py.File(path, "a") as file:
            for policy, name, alpha in (("p", "rl_p", 0.5), ("dial", "rl_dial", np.nan),
                                        ("p_alpha_8_mesh30", "rl_p_alpha_8_mesh30", 8.0)):
                write_cell(file, name, "rl", 9, 0.01, policy=policy, alpha=alpha)
            write_cell(file, "rl_dial@0.1", "rl", 9, 0.01, policy="dial")
            file[f"cells/{CASE}/rl_dial@0.1_embedded_trapezoidal"].attrs["accuracy"] = 0.1
        study = Study(path)
        self.assertEqual(study.policies("fault"),
                         ["dial", "dial@0.1", "p", "p_alpha_1", "p_alpha_2", "p_alpha_8", "p_alpha_8_mesh30"])
        self.assertEqual(shown_policies(study, "fault"), ["dial", "p_alpha_2"])

    def test_processor_time_counts_runs_and_the_reference(self):
        path = write_study(self.path("s.h5"))
        study = Study(path)
        # 0.01 s a solve: 220 and 540 of the classical runs, 120 of the policies'; a reference of 1 s
        self.assertAlmostEqual(processor_time(study, CASE, study.cells), 9.8)
        with h5py.File(path, "a") as file:
            cell = file[f"cells/{CASE}/pi_x1_doubling_implicit"]
            # too short for the clock: three times its 2.4 s by the wall
            cell.attrs.update({"cpu": 0.0, "repetitions": 3})
        study = Study(path)
        self.assertAlmostEqual(processor_time(study, CASE, study.cells), 14.6)
        self.assertIn("| **all up to 50 x 50** |  |  |  |  |  | **15** (0.243 min) |", contents(study))

    def test_envelope_and_cheapest(self):
        study = Study(write_study(self.path("s.h5")))
        classical = study.select(controller=("heuristic", "pi"))
        solves, errors = envelope(classical)
        np.testing.assert_array_equal(solves, [20, 40, 60, 100])
        np.testing.assert_allclose(errors, [0.1, 1e-2, 3e-3, 1e-3])
        self.assertEqual(cheapest(classical, {"final_error": 0.05})["solves"], 40)
        self.assertEqual(cheapest(classical, {"final_error": 0.1})["solves"], 20)
        self.assertIsNone(cheapest(classical, {"final_error": 1e-5}))

    def test_equal_accuracy_counts_solves_for_the_same_error(self):
        study = Study(write_study(self.path("s.h5")))
        # 0.5 % takes a classical run 60 solves, 5 % takes 40; the policies take 10. Their histories, twice the error,
        # 40 and 20.
        one, two = (study.one(policy=f"p_alpha_{alpha}", error="embedded") for alpha in (1, 2))
        self.assertEqual([advantage(study, cell, ("final_error",))[0] for cell in (one, two)], [6.0, 4.0])
        self.assertEqual([advantage(study, cell, ("history_error",))[0] for cell in (one, two)], [6.0, 4.0])
        text = equal_accuracy(study)
        self.assertIn("| `p_alpha_1` | 1 of 1 | 10 to 10 | 0.5 % | **6** (6 to 6) | 1 % | **6** (6 to 6) | **6** "
                      "(6 to 6) |", text)
        self.assertIn("| `p_alpha_8` | 0 of 1 | – |", text)

    def test_error_between_steps(self):
        study = Study(write_study(self.path("s.h5")))
        # the bump is at a step's end, and the cubics rise to it monotonically
        self.assertAlmostEqual(study.one(policy="p_alpha_1", error="embedded")["history_error"], 0.01, places=9)
        # y = t^3 is its own cubic, also across a single step
        time, at = np.array([0.0, 2.0]), np.linspace(0, 2, 7)
        np.testing.assert_allclose(slip_at(Course(time, time**3, 3 * time**2), at), at**3, atol=1e-14)

    def test_published_ratios_carry_errors_and_failures(self):
        text = published(Study(write_study(self.path("s.h5"))))
        # 300 and 240 solves (and attempts, here) against 30, of the two that converged; their mean error is 2.75 %,
        # that of both others 0.3 %
        self.assertRegex(text, r"\| 3 km \| doubling, implicit \| 2 of 3 \| 10 \(10 to 10\) \| 10 \(10 to 10\) \| 10 "
                         r".* \| 11\.0 .* \| 8 .* \| 2\.8 % \| 9\.85 % \| 0\.3 % \| 0\.3 % \|")

    def test_tables_fill_a_page_and_leave_its_text(self):
        study = Study(write_study(self.path("s.h5")))
        page = "before\n<!-- table failures -->\nold\n<!-- end failures -->\nafter\n"
        text = fill(page, study, "page")
        self.assertRegex(text, r"before\n<!-- table failures -->\n\| case .*\n(\|.*\n)+<!-- end failures -->\nafter\n")
        self.assertEqual(len(re.findall("did not converge", text)), 2)
        self.assertEqual(fill(text, study, "page"), text)
        for broken in ("<!-- table nonsense -->", "nothing", "<!-- table failures -->"):
            with self.assertRaises(OutputError):
                fill(broken, study, "page")

    def test_numbers(self):
        for value, text in ((0.00215, "0.00215"), (12345.6, "12346"), (2.5e-5, "2.5e-05"), (3.0, "3"),
                            (float("nan"), "–"), (999.7, "1000")):
            self.assertEqual(number(value), text)
        for value, text in ((123.4, "123"), (99.7, "100"), (99.4, "99"), (0.0004, "4.0e-04")):
            self.assertEqual(number(value, 2), text)

    def test_all_figures_of_a_study_with_gaps(self):
        done = self.script("plot-study", write_study(self.path("s.h5")), "--figures", self.path("figures"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(os.listdir(self.path("figures"))), 11)

    def test_an_empty_study_has_empty_figures_and_tables(self):
        with h5py.File(self.path("e.h5"), "w") as file:
            file.attrs["format"] = "slipstep-evaluation"
        done = self.script("plot-study", self.path("e.h5"), "--figures", self.path("figures"))
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(os.path.join(SOURCE, "output", "RESULTS.md"),
                  encoding="utf-8") as source, open(self.path("page.md"), "w", encoding="utf-8") as page:
            page.write(source.read())
        done = self.script("results-table", self.path("e.h5"), "--page", self.path("page.md"))
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_other_files_are_refused(self):
        with h5py.File(self.path("other.h5"), "w") as file:
            file.attrs["format"] = "slipstep-policy"
        for script, name in (("plot-study", "other.h5"), ("results-table", "other.h5"), ("plot-study", "missing.h5")):
            done = self.script(script, self.path(name))
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, f"^slipstep {script}: .*{name}: (not a file of evaluate|no such file)")
            self.assertNotIn("Traceback", done.stderr)
        done = self.script("plot-study", write_study(self.path("s.h5")), "--figures", self.path("s.h5"))
        self.assertRegex(done.stderr, "^slipstep plot-study: .*s.h5'\n$")  # a file, not a folder
        done = self.script("plot-study", self.path("s.h5"), "--only", "nonsense")
        self.assertEqual(done.returncode, 2)
        self.assertIn("nonsense", done.stderr)


class SmallRunTest(ScriptTest):
    """Run reads the files of the small models too."""

    def test_columns_of_another_model(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "small.h5")
            with h5py.File(path, "w") as file:
                for name in ("time", "dt", "accepted", "error", "converged", "newton_iterations", "linear_iterations",
                             "reason", "wall"):
                    file[f"steps/{name}"] = np.ones(4)
                for name, unit in (("time", "s"), ("V1", "V"), ("reaction", "A")):
                    file.create_dataset(f"series/{name}", data=np.arange(4.0)).attrs["units"] = unit
                file.create_group("run")
                file.create_group("result").attrs.update({key: 1 for key in (
                    "accepted", "rejected", "solves", "newton_iterations", "linear_iterations", "wall_time_setup",
                    "wall_time_solve")})
            run = Run(path)
            self.assertFalse(run.is_fault)
            self.assertEqual(run.columns, {"V1": "V", "reaction": "A"})
            with self.assertRaisesRegex(OutputError, "not the output of a fault"):
                run.require_fault("a map")
            done = self.script("plot-run", path)
            self.assertEqual(done.returncode, 0, done.stderr)
            done = self.script("compare", path)
            self.assertIn("not the output of a fault", done.stderr)


if __name__ == "__main__":
    unittest.main()
