"""Implicit runs of rate-and-state friction (TSBATHE with a smooth bound), against other means: the explicit run without
inertia, and Radau's method of scipy in (ln v, u, psi) with inertia, for one cell and for several."""

import os
import unittest
from math import log, pi, sqrt

from scripts import FaultTest

import h5py
import numpy as np

from slipstep import Catalogue

try:
    from scipy.integrate import solve_ivp
except ImportError:
    solve_ivp = None

os.environ.setdefault("OMPI_MCA_ess_singleton_isolated", "1")  # as in test_output_whole.py
G, RHO, SIDE, SIGMA, A, B, SLIP, F0, V0, LOADING = 30e9, 2500.0, 20e3, 25e6, 0.012, 0.02, 0.05, 0.6, 1e-6, 1e-9
START, THETA, ZETA, THICKNESS = 3e-9, 5e7, 0.8 / 3, 3e3
THRESHOLD = 1e-2
BASE = ("-fault_friction_law", "rate_and_state", "-fault_length_x", SIDE, "-fault_length_z", SIDE, "-fault_thickness",
        THICKNESS, "-fault_normal_stress", SIGMA, "-fault_normal_stress_gradient", 0, "-fault_friction_a", A,
        "-fault_friction_b", B, "-fault_friction_slip", SLIP, "-fault_loading_rate", LOADING, "-fault_initial_rate",
        START, "-fault_initial_state", THETA, "-fault_friction_reference", F0, "-fault_friction_reference_rate", V0,
        "-fault_kernel", "full_space", "-fault_progress", "no", "-fault_event_rate", THRESHOLD)


def friction(v, psi, a=A):
    return a * np.arcsinh(v / (2 * V0) * np.exp((F0 + B * psi) / a))


class Reference:
    """M dv/dt = T0 - K u - H (v - v_inf) - sigma mu(v, psi) of cells with this K, by scipy"""

    def __init__(self, K, start):
        n = len(K)
        values, vectors = np.linalg.eigh(K)
        M = RHO * THICKNESS
        self.K, self.M, self.n = K, M, n
        self.H = 2 * ZETA * sqrt(M) * (vectors * np.sqrt(values)) @ vectors.T
        psi = log(V0 * THETA / SLIP)
        self.T0 = SIGMA * friction(start, psi) + self.H @ (start - LOADING)
        self.start = np.concatenate([np.log(start), np.zeros(n), np.full(n, psi)])

    def rate(self, t, y):
        n, v = self.n, np.exp(y[:self.n])
        u, psi = y[n:2 * n], y[2 * n:]
        force = self.T0 - self.K @ u - self.H @ (v - LOADING) - SIGMA * friction(v, psi)
        return np.concatenate([force / (self.M * v), v - LOADING, V0 / SLIP * np.exp(-psi) - v / SLIP])

    def run(self, end):
        """times at which the first cell passes the threshold, and its state at the end"""
        crossing = lambda t, y: np.max(y[:self.n]) - log(THRESHOLD)
        done = solve_ivp(self.rate, (0, end), self.start, "Radau", rtol=1e-8, atol=1e-9, events=crossing,
                         first_step=1.0)
        assert done.success, done.message
        n = self.n
        return done.t_events[0], np.exp(done.y[:n, -1]), done.y[n:2 * n, -1] + LOADING * end, np.exp(
            done.y[2 * n:, -1]) * SLIP / V0


class SmoothStageTest(FaultTest):
    def run_fault(self, *options):
        """times at which the fault passes the threshold, slip rates, slips and states theta at the end"""
        for name in ("events.h5", "run.h5"):
            if os.path.exists(self.path(name)):
                os.remove(self.path(name))
        self.fault(*BASE, "-fault_catalogue", "events.h5", "-fault_output", "run.h5", "-fault_output_fields",
                   "slip_rate,displacement,state", *options, timeout=1000)
        event = Catalogue(self.path("events.h5")).event
        with h5py.File(self.path("run.h5")) as f:
            last = [f["fields"][name][-1].ravel() for name in ("slip_rate", "displacement", "state")]
            end = f["fields/time"][-1]
        return np.ravel(np.column_stack([event["onset"], event["end"]])), last[0], last[1] + LOADING * end, last[2]

    ONE = ("-fault_nx", 1, "-fault_nz", 1)

    def test_without_inertia(self):
        """Onsets and ends of the explicit run at 1e-9, four events in 380 years. The local error, of order h^3, sums up
        as rtol^(2/3): ten times less makes the error 4.6 times less, of the first event 4.2 times, from 1.6e-3 on.
        Times of the others were 2.0e-5 off at 1e-4 and 2.3e-6 at 1e-5; twice as much is allowed."""
        end = ("-ts_max_time", 1.2e10)
        want = self.run_fault(*self.ONE, *end, "-ts_type", "rk", "-ts_adapt_type", "basic", "-ts_rk_type", "5dp",
                              "-ts_rtol", 1e-9)[0]
        self.assertEqual(len(want), 8)
        first = []
        for rtol, tolerance in ((1e-4, 4e-5), (1e-5, 4e-6)):
            got = self.run_fault(*self.ONE, *end, "-ts_type", "bathe", "-ts_rtol", rtol)[0]
            self.assertEqual(len(got), len(want))
            first.append(abs(got[0] / want[0] - 1))
            np.testing.assert_allclose(got[2:], want[2:], rtol=tolerance)
        self.assertLess(first[0], 3e-3)
        self.assertLess(first[1], first[0] / 3)

    def test_order(self):
        """Constant steps through the start of an instability: half the step has a quarter of the error, to the next
        order, the step over the time in which it grows, some 3e6 s, over a hundred: orders were 1.999 to 2.000."""
        end = ("-ts_max_time", 8e6, "-ts_adapt_type", "none")
        want = self.run_fault(*self.ONE, "-ts_max_time", 8e6, "-ts_type", "rk", "-ts_adapt_type", "basic",
                              "-ts_rk_type", "5dp", "-ts_rtol", 1e-10)
        error = []
        for step in (4e4, 2e4, 1e4):
            got = self.run_fault(*self.ONE, *end, "-ts_type", "bathe", "-ts_dt", step)
            error.append([abs(x[0] / y[0] - 1) for x, y in zip(got[1:], want[1:])])
        for k in range(3):
            self.assertAlmostEqual(log(error[1][k] / error[2][k], 2), 2, delta=0.01)

    @unittest.skipIf(solve_ivp is None, "needs scipy")
    def test_with_inertia(self):
        """One cell through its first event"""
        one = np.array([[G * sqrt(2) / pi * (7 / 3) / SIDE]])
        self.compare(one, np.array([START]), *self.ONE)

    @unittest.skipIf(solve_ivp is None, "needs scipy")
    def test_several_cells_with_inertia(self):
        """3 x 2 cells, which break one after the other: six events"""
        x, z = np.meshgrid(np.arange(3.0), np.arange(2.0))
        distance = np.hypot(x.ravel()[:, None] - x.ravel(), z.ravel()[:, None] - z.ravel())
        K = -4e5 / np.maximum(distance, 1)**3
        np.fill_diagonal(K, 3e6)
        start = START * (1 + 0.5 * np.arange(6) / 6)
        with h5py.File(os.path.join(self.folder.name, "K.h5"), "w") as f:
            f["K"] = K
        with h5py.File(os.path.join(self.folder.name, "p.h5"), "w") as f:
            f["initial_rate"] = start.reshape(2, 3)
        self.compare(K, start, "-fault_nx", 3, "-fault_nz", 2, "-fault_stiffness_file", "K.h5:/K", "-fault_parameters",
                     "p.h5")

    def compare(self, K, start, *options, end=1.8e7):
        """At 1e-5 times were 1e-5 off and slips 1.6e-5, ten times less at 1e-6; three times that is allowed. States at
        the end, long after the events, were 4e-4 off."""
        want = Reference(K, start).run(end)
        got = self.run_fault(*options, "-fault_inertia", "yes", "-fault_viscosity", "sqrtm", "-ts_max_time", end,
                             "-ts_rtol", 1e-5)
        self.assertEqual(len(got[0]), len(want[0]))
        np.testing.assert_allclose(got[0], want[0], rtol=3e-5)
        np.testing.assert_allclose(got[2], want[2], rtol=5e-5)
        np.testing.assert_allclose(got[3], want[3], rtol=1e-3)


if __name__ == "__main__":
    unittest.main()
