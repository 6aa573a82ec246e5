"""What a run says of itself: rl gives up where no policy was trained."""

import os
import subprocess
import sys
import tempfile
import unittest

import scripts  # noqa: F401: before modules that may be missing

import h5py
import numpy as np

FAULT = os.path.join(os.environ["SLIPSTEP_BUILD"], "bin", "fault")
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
        done = subprocess.run([FAULT, *options, "-fault_output", path], capture_output=True, text=True, env=ALONE, timeout=100)
        assert done.returncode == 0, done.stderr
        found = {"text": done.stdout}
        with h5py.File(path) as file:
            found.update({name: float(value) for name, value in file["result"].attrs.items()})
            file.visititems(lambda name, item: found.update({name: item[()]} if isinstance(item, h5py.Dataset) and "wall" not in name else {}))
        return found


class Handover(Runs):
    """rl hands a loaded fault over to heuristic."""
    STUDY = ["-fault_stiffness_scaling", "mean_slip"]
    BLOCK = [*STUDY, "-fault_nx", "1", "-fault_nz", "1", "-fault_friction_law", "rate_weakening", "-fault_loading_rate", "1e-2", "-ts_max_time", "510"]
    LINE = "At time 0. s rl hands the run over to heuristic, because the fault is loaded (-fault_loading_rate)"

    @staticmethod
    def events(run):
        """Times at which a block begins to move, the start not counted: there it moves already."""
        rate = run["series/max_slip_rate"]
        return int(((rate[1:] > 0) & (rate[:-1] == 0)).sum())

    def test_block(self):
        """A block under loading: all numbers are those of heuristic, with its options. The policy alone slips too
        often."""
        for more in ([], ["-ts_adapt_heuristic_growth", "1.5", "-ts_rtol", "1e-2"]):
            ours, theirs = (self.run_fault(*self.BLOCK, "-ts_adapt_type", name, *more) for name in ("rl", "heuristic"))
            for name, value in theirs.items():
                if isinstance(value, np.ndarray):
                    self.assertTrue(np.array_equal(ours[name], value), f"{name} is not that of heuristic")
            self.assertEqual(ours["text"].count("hands the run over"), 1)
            self.assertIn(self.LINE, ours["text"])
            self.assertIn("handed to heuristic at:  0 s", ours["text"])
            self.assertEqual(ours["policy_handover_time"], 0)
            if not more:
                self.assertEqual(self.events(ours), 32)

    def test_strict(self):
        run = self.run_fault(*self.BLOCK, "-ts_adapt_type", "rl", "-ts_adapt_rl_strict")
        self.assertEqual(self.events(run), 40)
        self.assertNotIn("policy_handover_time", run)
        self.assertNotIn("hands the run over", run["text"])

    def test_centuries(self):
        """40 x 20 cells, 500 years: some hundred steps (the policy alone: 1e9 of 12.9 s)."""
        run = self.run_fault(*self.STUDY, "-fault_nx", "40", "-fault_nz", "20", "-fault_loading_rate", "1e-9", "-ts_max_time", "1.58e10", "-ts_adapt_type", "rl",
                             "-fault_output_interval", "1000000")
        self.assertLess(run["accepted"], 2000)
        self.assertIn(self.LINE, run["text"])

    def test_outside(self):
        """A duration of 350 T*, longer than any in training: handed over at the third decision, said by one line, and from
        the attempt before it on steps keep error estimates of at most 1."""
        options = [*self.STUDY, "-fault_nx", "3", "-fault_nz", "3", "-ts_adapt_type", "rl", "-ts_max_time", "300"]
        run, strict = self.run_fault(*options), self.run_fault(*options, "-ts_adapt_rl_strict")
        self.assertEqual(run["text"].count("hands the run over to heuristic, because its observations stay outside the policy's"), 1)
        self.assertEqual(run["policy_outside_range"], 3)
        self.assertTrue(np.array_equal(run["steps/dt"][:2], strict["steps/dt"][:2]))
        later = (run["steps/time"] >= run["policy_handover_time"]) & (run["steps/accepted"] == 1)
        self.assertGreater(later.sum(), 10)
        self.assertLessEqual(run["steps/error"][later].max(), 1)
        self.assertGreater(strict["steps/error"].max(), 10)
        self.assertNotIn("policy_handover_time", strict)


if __name__ == "__main__":
    sys.exit(unittest.main())
