"""The readers and figures of output/, on a synthetic file with the layout of the output format.

The synthetic run is a slip pulse with a known integral, on 6 x 4 cells, with two rejected attempts.
"""

import os
import shutil
import unittest
import unittest.mock

from scripts import ScriptTest

import h5py
import numpy as np

import slipstep
from slipstep import OutputError, Run
from slipstep.programs.compare import slip_error, table
from slipstep.results.files import open_file

NX, NZ, END = 6, 4, 30.0


def write_run(path, steps, slip_scale=1.0, rejected=(3, 7), nx=NX, end=END, skip=(), fields=True):
    """A file with the format's layout; skip lists datasets, groups and /result attributes to leave out."""
    dt = np.full(steps, end / steps)
    time = np.cumsum(dt)
    shape = np.exp(-0.5 * ((time - 8.0) / 2.5) ** 2)
    slip = slip_scale * 0.3 * np.cumsum(shape * dt)
    attempts = [(t - h, h, 1, 0.5, 1) for t, h in zip(time, dt)]
    for row in sorted(rejected, reverse=True):
        attempts.insert(row, (attempts[row][0], 4 * attempts[row][1], 0, 20.0, 1))
    attempts = np.array(attempts)
    count = len(attempts)
    columns = {
        "steps": {"time": attempts[:, 0], "dt": attempts[:, 1], "accepted": attempts[:, 2].astype(int),
                  "error": attempts[:, 3],
                  "converged": attempts[:, 4].astype(int), "newton_iterations": np.full(count, 4),
                  "linear_iterations": np.full(count, 9), "reason": np.full(count, 2), "wall": np.full(count, 0.01)},
        "series": {"time": time, "mean_slip_rate": 0.3 * slip_scale * shape, "max_slip_rate": 0.5 * slip_scale * shape,
                   "mean_slip": slip, "mean_displacement": slip - 0.6,
                   "sliding_fraction": (shape > 1e-3).astype(float)},
    }
    x, z = (np.arange(nx) + 0.5) * 3000 / nx, (np.arange(NZ) + 0.5) * 3000 / NZ
    units = {"time": "s", "dt": "s", "wall": "s", "mean_slip": "m", "mean_slip_rate": "m/s"}
    with h5py.File(path, "w") as file:
        for group, data in columns.items():
            for name, values in data.items():
                if f"{group}/{name}" not in skip:
                    file.create_dataset(f"{group}/{name}", data=values).attrs["units"] = units.get(name, "1")
        file["mesh/x"], file["mesh/z"] = x, z
        file.create_group("run").attrs.update({"options": "-fault_nx 6", "ranks": 1})
        if fields:
            plane = np.outer(np.sin(np.pi * z / 3000), np.sin(np.pi * x / 3000))
            file["fields/time"] = time
            file["fields/slip_rate"] = 0.5 * slip_scale * shape[:, None, None] * plane
        result = {"mean_slip": slip[-1], "accepted": steps, "rejected": len(rejected), "solves": count,
                  "newton_iterations": 4 * count, "linear_iterations": 9 * count, "wall_time_setup": 0.1,
                  "wall_time_solve": 1.25}
        if "result" not in skip:
            file.create_group("result").attrs.update({k: v for k, v in result.items() if k not in skip})
        for group in skip:
            if group in file:
                del file[group]
    return path


class OutputTest(ScriptTest):
    def test_reads_what_was_written(self):
        run = Run(write_run(self.path("a.h5"), 40))
        self.assertEqual(len(run.series["time"]), 40)
        self.assertEqual(run.shape, (NZ, NX))
        self.assertEqual(run.units["/series/mean_slip_rate"], "m/s")
        self.assertEqual(run.result["accepted"], 40)
        np.testing.assert_array_equal(np.flatnonzero(run.rejected), [3, 8])
        # Steps of 0.75 s: the largest value of the pulse centred on 8 s is the one at 8.25 s.
        self.assertAlmostEqual(run.series["time"][run.peak], 8.25)
        times, maps = run.field("slip_rate")
        self.assertEqual(maps.shape, (40, NZ, NX))
        self.assertEqual(run.field_at("slip_rate", 8.3)[0], times[10])

    def test_errors_name_file_and_dataset(self):
        cases = [("missing.h5", None, "no such file"), ("dt.h5", ("steps/dt",), "/steps/dt is missing"),
                 ("series.h5", ("series",), "/series is missing"), ("result.h5", ("result",), "/result is missing"),
                 ("attr.h5", ("mean_slip",), "attribute mean_slip of /result")]
        for name, skip, message in cases:
            if skip is not None:
                write_run(self.path(name), 40, skip=skip)
            with self.assertRaisesRegex(OutputError, f"{name}.*{message}"):
                Run(self.path(name))

    def test_truncated_file(self):
        with open(write_run(self.path("whole.h5"), 40), "rb") as file:
            whole = file.read()
        self.put("cut.h5", whole[: len(whole) // 2])
        with self.assertRaisesRegex(OutputError, "cut.h5: "):
            Run(self.path("cut.h5"))

    def test_file_that_is_just_written(self):
        """A reader of a file that grows comes between its length and its superblock, and reads again; nobody waits for
        a whole file."""
        opened, calls = h5py.File, []

        def late(path, mode):
            calls.append(path)
            if len(calls) < 3:
                raise OSError("truncated file")
            return opened(path, mode)

        part = self.path("late.h5.part")
        with opened(part, "w"):
            pass
        shutil.copy(part, self.path("late.h5"))
        with unittest.mock.patch("h5py.File", late):
            open_file(part, "").close()
            self.assertEqual(calls, 3 * [part])
            calls.clear()
            with self.assertRaisesRegex(OutputError, "late.h5: "):
                open_file(self.path("late.h5"), "")
        self.assertEqual(len(calls), 1)

    def test_file_that_grows(self):
        """Both readers take the rows that all datasets of a group have, of fields as well; axes are no rows."""
        path = write_run(self.path("a.h5.part"), 40)
        with h5py.File(path, "a") as file:
            file.attrs["complete"] = 0
            file["fields/x"] = file["mesh/x"][()]
            file["fields/x"].make_scale("x")
            for name, rows in (("series/mean_slip", 37), ("steps/dt", 41), ("fields/slip_rate", 36)):
                data = file[name][:rows]
                del file[name]
                file[name] = data
        run, result = Run(path), slipstep.open(path)
        for found in (run, result):
            self.assertEqual({len(values) for values in found.series.values()}, {37})
            self.assertEqual({len(values) for values in found.steps.values()}, {41})
        self.assertFalse(result.complete)
        self.assertEqual((len(run.field("slip_rate")[0]), len(result.time), result["slip_rate"].shape,
                          len(result.fields["x"])), (36, 36, (36, NZ, NX), NX))
        self.assertEqual(run.result["mean_slip"], result["mean_slip"][36])

    def test_field_that_was_not_stored(self):
        run = Run(write_run(self.path("a.h5"), 40))
        with self.assertRaisesRegex(OutputError, "traction .*slip_rate"):
            run.field("traction")

    def test_error_of_final_slip(self):
        reference = Run(write_run(self.path("fine.h5"), 1000))
        run = Run(write_run(self.path("a.h5"), 1000, slip_scale=1.02))
        # The same sum times 1.02: exact up to rounding of 1000 additions.
        self.assertAlmostEqual(slip_error(run, reference), 0.02, delta=1e-12)
        text = "\n".join(table([("rl", run)], reference))
        self.assertRegex(text, r"rl +1000 +2 +1002 +- +- +1\.25 +[0-9.]+ +\+2\.00")

    def test_compare_writes_table_and_figure(self):
        write_run(self.path("fine.h5"), 1000)
        write_run(self.path("rl.h5"), 20, slip_scale=1.01, rejected=(2,))
        write_run(self.path("heuristic.h5"), 45)
        png = self.path("figure.png")
        done = self.script("compare", "--reference", self.path("fine.h5"), "--figure", png, f"rl={self.path('rl.h5')}",
                           f"heuristic={self.path('heuristic.h5')}")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"(?m)^rl .*\n^heuristic .*\n^reference ")
        with open(png, "rb") as file:
            self.assertEqual(file.read(8), b"\x89PNG\r\n\x1a\n")

    def test_compare_refuses_a_reference_of_another_case(self):
        run = write_run(self.path("rl.h5"), 20)
        for name, change in (("mesh.h5", {"nx": 8}), ("end.h5", {"end": 50.0})):
            write_run(self.path(name), 100, **change)
            done = self.script("compare", "--reference", self.path(name), f"rl={run}")
            self.assertEqual(done.returncode, 1)
            self.assertIn(name, done.stderr)
            self.assertNotIn("Traceback", done.stderr)

    def test_compact_keeps_results_and_the_last_row(self):
        whole = Run(write_run(self.path("whole.h5"), 1003))
        done = self.script("compact", self.path("whole.h5"), self.path("small.h5"), "--rows", "100")
        self.assertEqual(done.returncode, 0, done.stderr)
        small = Run(self.path("small.h5"))
        self.assertEqual(small.result, whole.result)
        self.assertLessEqual(len(small.series["time"]), 101)
        self.assertEqual(small.series["mean_slip"][-1], whole.series["mean_slip"][-1])
        self.assertEqual(small.units["/series/mean_slip"], "m")
        self.assertEqual(small.field_names, [])

    def test_what_cannot_be_written_is_refused_by_name(self):
        run = write_run(self.path("a.h5"), 40)
        before = os.path.getsize(run)
        for script, arguments, message in (("compact", (run, run), "a.h5 is the file itself"),
                                           ("compact", (run, self.path("no/b.h5")), "no/b.h5"),
                                           ("compare", (run, "--figure", self.path("no/c.png")), "no/c.png"),
                                           ("plot-run", (run, "--figure", self.path("no/d.png")), "no/d.png")):
            done = self.script(script, *arguments)
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, f"^slipstep {script}: .*{message}")
            self.assertNotIn("Traceback", done.stderr)
        self.assertEqual(os.path.getsize(run), before)
        self.assertEqual(self.script("compact", run, self.path("b.h5"), "--rows", "0").returncode, 2)

    def test_plot_run_with_and_without_fields(self):
        for name, fields in (("with.h5", True), ("without.h5", False)):
            write_run(self.path(name), 40, fields=fields)
            done = self.script("plot-run", self.path(name))
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue(os.path.getsize(self.path(name).replace(".h5", ".png")) > 10000)


if __name__ == "__main__":
    unittest.main()
