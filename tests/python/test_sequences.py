"""Events of one block that is loaded and heals, against other means (oneblock.py) and a closed form."""

import os
import subprocess
import tempfile
import unittest
from math import exp, log, pi, sqrt

import scripts
from oneblock import Block

import numpy as np

from slipstep_catalogue import Catalogue

os.environ.setdefault("OMPI_MCA_ess_singleton_isolated", "1")  # as in test_output_whole.py
FAULT = os.path.join(os.environ["SLIPSTEP_BUILD"], "bin", "fault")
G, RHO, NU, SIDE, SIGMA, RESIDUAL, DROP, SLIP, LOADING, HEALING = 30e9, 2500.0, 0.25, 1000.0, 50e6, 0.5, 0.1, 0.05, 1e-9, 3.15576e7
K = G * sqrt(2) / pi * (7 / 3) / SIDE  # of a square in a full space
H = G / (2 * sqrt(G / RHO))
BLOCK = ("-fault_nx", 1, "-fault_nz", 1, "-fault_length_x", SIDE, "-fault_length_z", SIDE, "-fault_kernel", "full_space", "-fault_normal_stress", SIGMA,
         "-fault_normal_stress_gradient", 0, "-fault_friction_residual", RESIDUAL, "-fault_friction_drop", DROP, "-fault_initial", "rest",
         "-fault_loading_rate", LOADING, "-fault_viscosity", "radiation", "-fault_progress", "no", "-fault_catalogue", "events.h5")


class SequencesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """The first events of the reference; from the fifth on they repeat themselves, to 2e-7 of the interval with inertia."""
        cls.reference = {}
        for inertia, mass in (("no", 0.0), ("yes", RHO * SIDE)):
            block = Block(K, H, mass, SIGMA, RESIDUAL, DROP, SLIP, LOADING, HEALING, tolerance=1e-8)
            cls.reference[inertia] = block.run(np.inf, count=6)

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def events(self, *options, count=100, slip=SLIP, healing=HEALING, until=None):
        inertia = options[1]
        end = self.expected(inertia, count)[-1, 1] + 1e7 if until is None else until
        path = os.path.join(self.folder.name, "events.h5")
        if os.path.exists(path):
            os.remove(path)
        command = [FAULT, *map(str, BLOCK), "-fault_friction_slip", str(slip), "-fault_healing_time", str(healing), "-ts_max_time", f"{end:.17g}", *options]
        done = subprocess.run(command, cwd=self.folder.name, capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)
        return Catalogue(path).event

    def expected(self, inertia, count):
        """onset, end, slip, largest rate, its time of so many events"""
        first = self.reference[inertia]
        self.assertLess(abs((first[5, 0] - first[4, 0]) / (first[4, 0] - first[3, 0]) - 1), 1e-6)
        rows = np.tile(first[-1], (max(count - 6, 0), 1))
        rows[:, [0, 1, 4]] += np.arange(1, len(rows) + 1)[:, None] * (first[5, 0] - first[4, 0])
        return np.vstack([first, rows])[:count]

    def compare(self, event, expected, tolerance):
        """Times of the onsets, intervals between them, slips and largest rates, all relative."""
        count = min(len(event["onset"]), len(expected))
        self.assertGreaterEqual(count, len(expected) - 1)  # the last one may come after the run's end
        self.assertLessEqual(len(event["onset"]), len(expected))
        onset, expected = event["onset"][:count], expected[:count]
        for value, want in ((onset, expected[:, 0]), (np.diff(onset), np.diff(expected[:, 0])), (event["mean_slip"][:count], expected[:, 2]),
                            (event["peak_slip_rate"][:count], expected[:, 3])):
            np.testing.assert_allclose(value, want, rtol=tolerance)

    def test_hundred_events(self):
        for inertia in ("no", "yes"):
            expected = self.expected(inertia, 100)
            with self.subTest(inertia):
                self.compare(self.events("-fault_inertia", inertia, "-ts_rtol", "1e-5"), expected, 1e-4)
                self.compare(self.events("-fault_inertia", inertia), expected, 1e-2)

    def test_controllers_and_rate_tolerances_find_the_same_events(self):
        ways = [("-ts_adapt_type", name) for name in ("pi", "basic", "dsp")] + [("-fault_rate_tolerance", value) for value in ("1e-6", "1e-4")]
        for inertia in ("no", "yes"):
            expected = self.expected(inertia, 20)
            for way in ways:
                with self.subTest((inertia, *way)):
                    self.compare(self.events("-fault_inertia", inertia, *way, count=20), expected, 1e-2)

    def test_recurrence(self):
        """Weakening within a thirtieth of the slip and healing within 1e-4 of the interval: all of the strength's drop is lost in an event and
        loaded again, D = sigma dmu/K and T = D/v_inf. What remains is the creep at the residual strength after an event, until healing
        outruns the loading, sigma dmu/d_c exp(-s/d_c) s/t_h = K v_inf: it lasts t_h ln(D/s), which adds to the interval."""
        D = SIGMA * DROP / K
        slip, healing = D / 30, 1e-4 * D / LOADING
        s = D
        for _ in range(100):
            s = slip * log(SIGMA * DROP / slip * s / (K * LOADING * healing))
        creep = healing * log(D / s)
        event = self.events("-fault_inertia", "no", "-ts_rtol", "1e-5", "-fault_event_rate", "1e-6", count=20, slip=slip, healing=healing, until=25.5 * D / LOADING)
        # the first comes after six intervals, as the strength at rest is six times the drop
        self.assertEqual(len(event["onset"]), 20)
        np.testing.assert_allclose(event["mean_slip"], D, rtol=1e-4)
        np.testing.assert_allclose(np.diff(event["onset"]), D / LOADING + creep, rtol=1e-4)
        # from no stress to the strength at rest
        self.assertAlmostEqual(event["onset"][0] / (SIGMA * (RESIDUAL + DROP) / K / LOADING), 1, delta=1e-6)


if __name__ == "__main__":
    unittest.main()
