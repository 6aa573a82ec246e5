"""The learning-curve figure of output/, on synthetic logs with the layout of train -train_log."""

import unittest

from scripts import ScriptTest

import h5py
import numpy as np

from slipstep import OutputError
from slipstep.programs.plot_training import Log, groups, read_logs, running_mean


def write_log(path, alpha=2.0, seed=1, algorithm="tqc", problem="fault", evaluations=5, skip=None):
    steps = np.arange(20.0, 2001.0, 20.0)
    with h5py.File(path, "w") as file:
        file.attrs.update({"alpha": alpha, "seed": seed, "algorithm": algorithm, "problem": problem,
                           "reward": "balanced",
                           "error": "final mean slip"})
        file["episodes/step"], file["episodes/return"] = steps, -40 * np.exp(-steps / 400) - 5 - seed
        file["episodes/length"] = np.full(len(steps), 20.0)
        at = np.linspace(400.0, 2000.0, evaluations) if evaluations else np.zeros(0)
        for name, values in (("step", at), ("return", -6 - at / 4000), ("length", 18 + 0 * at),
                             ("error", 0.01 + 0 * at)):
            if name != skip:
                file[f"evaluations/{name}"] = values
    return path


class PlotTraining(ScriptTest):
    def test_seeds_share_a_group(self):
        paths = [write_log(self.path(f"{a}{s}{g}.h5"), alpha=a, seed=s, algorithm=g)
                 for a, s, g in ((8.0, 1, "tqc"), (2.0, 1, "td3"), (2.0, 2, "tqc"), (2.0, 1, "tqc"))]
        sizes = {label: len(logs) for label, logs in groups(read_logs(paths)).items()}
        self.assertEqual(sizes, {"td3, alpha 2": 1, "tqc, alpha 2": 2, "tqc, alpha 8": 1})

    def test_running_mean_of_a_line_is_the_line(self):
        x = np.arange(400.0)
        self.assertTrue(np.allclose(np.subtract(*running_mean(x, 3 + x)), -3))

    def test_figure(self):
        logs = [write_log(self.path("a.h5")), write_log(self.path("b.h5"), seed=2),
                write_log(self.path("c.h5"), evaluations=0)]
        done = self.script("plot-training", *logs, "--figure", self.path("curves.png"))
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(self.path("curves.png"), "rb") as file:
            self.assertEqual(file.read(8), b"\x89PNG\r\n\x1a\n")

    def test_errors_name_file_and_dataset(self):
        write_log(self.path("short.h5"), skip="error")
        with self.assertRaisesRegex(OutputError, "short.h5: no dataset /evaluations/error"):
            Log(self.path("short.h5"))
        pair = [write_log(self.path("fault.h5")), write_log(self.path("circuit.h5"), problem="circuit")]
        with self.assertRaisesRegex(OutputError, "circuit.h5 "):
            read_logs(pair)
        done = self.script("plot-training", self.path("none.h5"))
        self.assertEqual(done.returncode, 1)
        self.assertIn("slipstep plot-training", done.stderr)
        self.assertIn("none.h5", done.stderr)
        self.assertEqual(len(done.stderr.splitlines()), 1)
        done = self.script("plot-training", pair[0], "--figure", self.path("no/such.png"))
        self.assertRegex(done.stderr, "^slipstep plot-training: .*no/such.png'\n$")


if __name__ == "__main__":
    unittest.main()
