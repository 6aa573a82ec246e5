#!/usr/bin/env python3
"""Pore fluid that diffuses in a fault and is coupled to slip: a block whose equations scipy solves by itself, the order
in time, the error estimate, the balance of fluid, BP8 with its diffusion computed, restarts and ranks."""

import math
import unittest

from scripts import FaultTest

import h5py
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

# a block on a spring under rate-and-state friction, from whose border fluid drains the faster the more it slips
K, SIGMA, A, B, DC, F0, V0, G, RHO = 4e8, 5e7, 0.01, 0.015, 1e-3, 0.6, 1e-6, 30e9, 2500.0
RATE, DRIVE, TRACTION, SIDE = 1e-6, 2e-6, 0.612 * 4e7, 10.0
START, MOST, SLIP, HEALING, SCALE, ETA, STORAGE, PRESSURE = 1e-15, 1e-13, 2e-3, 2e4, 3e7, 1e-3, 5e-9, 1e7
BLOCK = ("-fault_nx", 1, "-fault_nz", 1, "-fault_length_x", SIDE, "-fault_length_z", SIDE, "-fault_stiffness_file",
         "k.h5", "-fault_friction_law", "rate_and_state", "-fault_friction_a", A, "-fault_friction_b", B,
         "-fault_friction_slip", DC, "-fault_normal_stress", SIGMA, "-fault_normal_stress_gradient", 0,
         "-fault_initial", "traction", "-fault_initial_traction", TRACTION, "-fault_initial_rate", RATE,
         "-fault_loading_rate", DRIVE, "-fault_permeability", START, "-fault_pore_compressibility", STORAGE / 0.1,
         "-fault_fluid_border", "open", "-fault_fluid_pressure", PRESSURE, "-fault_permeability_law", "valve",
         "-fault_permeability_maximum", MOST, "-fault_permeability_slip", SLIP, "-fault_permeability_healing_time",
         HEALING, "-fault_permeability_stress", SCALE, "-fault_fluid_tolerance", 1e-8, "-fault_output", "o.h5",
         "-fault_output_overwrite", "yes", "-fault_output_fields", "slip,pore_pressure,slip_rate",
         "-fault_output_interval", 1)


def block(end, most=MOST):
    """Slip, theta, p and k* of the block at these times [4, n]; radiation damps the rate beyond that of the drive"""
    damping = math.sqrt(G * RHO) / 2

    def rate(t, slip, theta, p):
        load = TRACTION + K * (DRIVE * t - slip)
        grip = (F0 + B * math.log(V0 * theta / DC)) / A
        return math.exp(brentq(lambda x: load - damping * (math.exp(x) - DRIVE) - max(SIGMA - p, 0) * A
                               * math.asinh(math.exp(x + grip) / (2 * V0)), -60, 5, xtol=1e-14))

    def change(t, y):
        slip, theta, p, k = y
        v = rate(t, slip, theta, p)
        now = k * math.exp(-(SIGMA - p - SIGMA) / SCALE)
        return [v, 1 - v * theta / DC, -8 * now / ETA * p / (STORAGE * SIDE**2),
                v / SLIP * (most - k) + (START - k) / HEALING]

    grip = TRACTION / ((SIGMA - PRESSURE) * A)  # the state balances the traction at the rate
    theta = DC / V0 * math.exp((A * math.log(2 * V0 / RATE * math.sinh(grip)) - F0) / B)
    return solve_ivp(change, (0, max(end)), [0, theta, PRESSURE, START], "Radau", t_eval=end, rtol=1e-11,
                     atol=[1e-16, 1e-9, 1e-3, 1e-27]).y


class Fluid(FaultTest):
    def setUp(self):
        super().setUp()
        self.hdf5("k.h5", stiffness=[[K]])

    def last(self, name="o.h5"):
        with h5py.File(self.path(name)) as file:
            return {key: data[-1] for key, data in file["fields"].items() if key not in "xz"}

    def test_line(self):
        """Fluid that enters at a constant rate in the middle of a line: p = (q/T) sqrt(D t) ierfc(r/sqrt(4 D t))
        (Carslaw and Jaeger 1959), means of cells by differences of its integral, but for the cell of the source, over
        which the rate is spread. Cells of a third: errors fall by 9 or more."""
        k, eta, storage, rate, end = 1e-14, 1e-3, 1e-9, 1e-6, 2e6  # per metre along the fault: rate [m^2/s]
        spread = math.sqrt(4 * k / eta / storage * end)

        def integral(r):  # of ierfc(r/spread) from 0 to r
            z = r / spread
            return spread * ((1 + 2 * z * z) * math.erf(z) / 4 + z * math.exp(-z * z) / (2 * math.sqrt(math.pi))
                             - z * z / 2)

        errors = []
        for n in (25, 75, 225):
            cell = 2000.0 / n
            source = np.zeros((n, 1))
            source[n // 2] = rate / cell
            self.hdf5("f.h5", fluid_source=source)
            self.fault("-fault_nx", 1, "-fault_nz", n, "-fault_length_x", 100, "-fault_length_z", 2000,
                       "-fault_normal_stress", 5e7, "-fault_normal_stress_gradient", 0, "-fault_friction_law",
                       "rate_and_state", "-fault_creep", 1, "-fault_loading_rate", 1e-12, "-fault_permeability", k,
                       "-fault_pore_compressibility", storage / 0.1, "-fault_parameters", "f.h5",
                       "-fault_fluid_tolerance", 1e-5, "-ts_max_time", end, "-fault_output", "o.h5",
                       "-fault_output_overwrite", "yes", "-fault_output_fields", "pore_pressure")
            edges = np.abs((np.arange(n + 1) - n / 2) * cell)
            whole = np.array([integral(r) for r in edges])
            exact = np.abs(np.diff(whole))
            exact *= rate * eta / k * spread / 2 / cell
            error = np.abs(self.last()["pore_pressure"].ravel() - exact)
            error[n // 2] = 0
            errors.append(error.max() / exact.max())
        self.assertLess(errors[2], 5e-4)
        for before, after in zip(errors, errors[1:]):
            self.assertTrue(7 < before / after < 13, errors)

    def test_order(self):
        """Steps that are halved: the errors of slip and pressure fall by 4 at least, and less than by 10 at order 3,
        which Adams' formulas have at first."""
        end = 2000.0
        slip, _, pressure, _ = block([end])[:, 0]
        for method in ("adams", "bathe"):
            errors = []
            for h in (40, 20, 10):
                self.fault(*BLOCK, "-ts_type", method, "-ts_adapt_type", "none", "-ts_dt", h, "-ts_max_time", end)
                now = self.last()
                errors.append([abs(now[key].item() / exact - 1) for key, exact in
                               (("pore_pressure", pressure), ("slip", slip))])
            with self.subTest(method=method):
                self.assertLess(max(errors[2]), 5e-6)
                for before, after in zip(errors, errors[1:]):
                    self.assertTrue(all(3 < a / b < 10 for a, b in zip(before, after)), errors)

    def test_estimate(self):
        """One step from the start: the error of the pressure that friction has seen, and its estimate, that of the
        step, where that of friction is smaller. A tolerance of 1 accepts it."""
        for h in (10.0, 20.0, 40.0, 80.0):
            self.fault(*BLOCK, "-fault_permeability_maximum", 2 * MOST, "-ts_type", "bathe", "-ts_adapt_type", "basic",
                       "-ts_dt", h, "-ts_max_time", h, "-ts_rtol", 1)
            (estimate,) = self.get("o.h5", "steps/error")
            true = self.last()["pore_pressure"].item() - block([h], 2 * MOST)[2, 0]
            with self.subTest(h=h):
                self.assertTrue(0.5 < estimate.item() * SIGMA * B / true < 2, (estimate, true))


if __name__ == "__main__":
    unittest.main()
