#!/usr/bin/env python3
"""Heat, pore pressure and dilatancy across the fault: closed forms of Rice (2006), a Volterra equation that is solved
here by itself, the order in time, cycles with and without them, checkpoints and ranks."""

import math
import unittest

from scripts import FaultTest

import h5py
import numpy as np

RHO_C, LAMBDA, F, SIGMA, THERMAL = 2.7e6, 1e5, 0.6, 1e8, 1e-6
ONE = ("-fault_nx", 1, "-fault_nz", 1, "-fault_normal_stress_gradient", 0, "-fault_output", "o.h5",
       "-fault_output_overwrite", "yes", "-fault_output_interval", 1, "-fault_output_fields")
FIELDS = ("slip", "slip_rate", "traction", "normal_stress", "temperature", "shear_zone_pressure")
PRESSED = ("-fault_thermal_pressurisation", LAMBDA, "-fault_heat_capacity", RHO_C, "-fault_thermal_diffusivity")
DILATES = ("-fault_dilatancy", 1e-4, "-fault_dilatancy_storage", 1e-10, "-fault_dilatancy_time", 1e4)


class Pressurisation(FaultTest):
    def last(self, name="o.h5"):
        """The last entry of each field, of all entries the times"""
        with h5py.File(self.path(name)) as file:
            return {key: data[...] if key == "time" else data[-1].ravel() for key, data in file["fields"].items()
                    if key not in "xz"}

    def creep(self, end, *options):
        """Slip at 1 m/s under the friction f"""
        self.fault(*ONE, ",".join(FIELDS), "-fault_friction_law", "rate_and_state", "-fault_creep", 1,
                   "-fault_loading_rate", 1, "-fault_friction_reference_rate", 1, "-fault_friction_reference", F,
                   "-fault_normal_stress", SIGMA, "-ts_max_time", repr(end), "-ts_adapt_type", "none", *options)
        return {key: value[-1] for key, value in self.last().items()}

    def test_closed_forms(self):
        """Slip on a plane, of whose exact solution the width w is off by w/sqrt(a t) = 1e-4, and undrained, adiabatic
        slip. A thousandth: of the sums 1e-4, and 300 steps of second order leave less."""
        for hydraulic in (1e-4, 1e-6):
            length = 4 / F**2 * (RHO_C / LAMBDA)**2 * (math.sqrt(hydraulic) + math.sqrt(THERMAL))**2
            for x in (0.1, 1.0):
                end = x * length
                now = self.creep(end, *PRESSED, THERMAL, "-fault_hydraulic_diffusivity", hydraulic, "-ts_dt",
                                 repr(end / 300), "-fault_shear_zone_width", 1e-4 * math.sqrt(THERMAL * end))
                left = math.exp(x) * math.erfc(math.sqrt(x))
                with self.subTest(hydraulic=hydraulic, x=x):
                    self.assertLess(abs(now["traction"] / (-F * SIGMA * left) - 1), 1e-3)
                    self.assertLess(abs((now["normal_stress"] + now["shear_zone_pressure"]) / SIGMA - 1), 1e-12)
                    rise = (1 + math.sqrt(hydraulic / THERMAL)) * SIGMA / LAMBDA * (1 - left)
                    self.assertLess(abs(now["temperature"] / rise - 1), 1e-3)
        width = 5e-3
        end = 2 * RHO_C * math.sqrt(2 * math.pi) * width / (F * LAMBDA)
        now = self.creep(end, *PRESSED, 0, "-fault_hydraulic_diffusivity", 0, "-ts_dt", repr(end / 300),
                         "-fault_shear_zone_width", width)
        self.assertLess(abs(now["traction"] / (-F * SIGMA * math.exp(-2)) - 1), 1e-3)
        self.assertLess(abs(now["temperature"] / (SIGMA / LAMBDA * (1 - math.exp(-2))) - 1), 1e-3)

    def test_order(self):
        """A block on a spring under constant friction f, eta v = T - K u - f (sigma - p), p = int K_p(t - s) tau v ds
        with the closed kernel, by the trapezoidal rule with two numbers of steps and extrapolation: right to 1e-8.
        Slip by each integrator in steps that are halved twice: the error falls by 4 each time; of Adams' formulas,
        which begin at order 1, only the second time."""
        K, G, rho, width, hydraulic, sigma, T, end = 1e7, 30e9, 2500.0, 5e-3, 1e-5, 5e7, 31e6, 1.0
        eta = math.sqrt(G * rho) / 2  # G and rho are the defaults

        def reference(n):
            h = end / n
            t = h * np.arange(n + 1)
            g = [a / np.sqrt(2 * np.pi * (width**2 + 2 * a * t)) for a in (THERMAL, hydraulic)]
            kernel = LAMBDA / RHO_C * (g[1] - g[0]) / (hydraulic - THERMAL)
            u, q = np.zeros(n + 1), np.zeros(n + 1)
            v = np.zeros(n + 1)
            tau = F * sigma
            v[0] = (T - tau) / eta
            q[0] = tau * v[0]
            for k in range(1, n + 1):
                past = h * (np.dot(kernel[k - 1:0:-1], q[1:k]) + kernel[k] * q[0] / 2)
                v[k] = v[k - 1]
                for _ in range(60):
                    tau = F * (sigma - past - h / 2 * kernel[0] * tau * v[k])
                    v[k] = (T - K * (u[k - 1] + h / 2 * (v[k - 1] + v[k])) - tau) / eta
                u[k] = u[k - 1] + h / 2 * (v[k - 1] + v[k])
                q[k] = tau * v[k]
            return u[n]

        coarse, fine = reference(1000), reference(2000)
        exact = fine + (fine - coarse) / 3
        self.hdf5("k.h5", stiffness=[[K]])
        options = (*ONE, ",".join(FIELDS), "-fault_stiffness_file", "k.h5", "-fault_friction_law", "constant",
                   "-fault_friction_residual", F, "-fault_friction_drop", 0, "-fault_normal_stress", sigma,
                   "-fault_initial", "traction", "-fault_initial_traction", T, "-fault_initial_unstable", "yes",
                   "-fault_inertia", "no", "-fault_viscosity", "radiation", *PRESSED, THERMAL,
                   "-fault_hydraulic_diffusivity", hydraulic, "-fault_shear_zone_width", width,
                   "-fault_shear_zone_tolerance", 1e-7, "-ts_max_time", end, "-ts_adapt_type", "none")
        for integrator in ("rkc", "adams", "bathe"):
            errors = []
            for n in (100, 200, 400):
                self.fault(*options, "-ts_dt", end / n, "-ts_type", integrator)
                errors.append(self.last()["slip"][0] / exact - 1)
            with self.subTest(integrator=integrator):
                self.assertLess(abs(errors[2]), 1e-5)
                for a, b in list(zip(errors, errors[1:]))[integrator == "adams":]:
                    self.assertTrue(3 < a / b < 5, errors)

    def block(self, *options, end="3e9", name="o.h5", fields="slip,slip_rate"):
        """Events of one block under rate-and-state friction at half its critical stiffness: their times, slip"""
        self.hdf5("k.h5", stiffness=[[0.25e7 * 5]])
        self.fault(*ONE, fields, "-fault_stiffness_file", "k.h5", "-fault_friction_law", "rate_and_state",
                   "-fault_normal_stress", 5e7, "-fault_friction_slip", 0.01, "-fault_loading_rate", 1e-9,
                   "-fault_output_size", 0, "-ts_max_time", end, *options)
        with h5py.File(self.path(name)) as file:
            time, rate, slip = (file["fields/" + key][...].ravel() for key in ("time", "slip_rate", "slip"))
        begin = np.flatnonzero((rate[1:] > 1e-3) & (rate[:-1] <= 1e-3)) + 1
        return time[begin], slip[-1], rate.max()

    def test_cycle(self):
        """Pressure that heat makes takes friction off: an event slips more, and the next one is later. Dilatancy
        makes slow slip of events. Steps of the default tolerance find the times of events to 1e-3, their slip to
        1e-3, by explicit and by implicit steps."""
        heat = (*PRESSED, THERMAL, "-fault_shear_zone_width", 1e-3)
        dry, heated = self.block(), self.block(*heat)
        fine = self.block(*heat, "-ts_rtol", 1e-5)
        implicit = self.block(*heat, "-ts_type", "bathe", "-ts_rtol", 1e-5, end="5e8")
        self.assertEqual((len(dry[0]), len(heated[0]), len(implicit[0])), (5, 2, 1))
        np.testing.assert_allclose(heated[0], fine[0], rtol=1e-3)
        self.assertLess(abs(heated[1] / fine[1] - 1), 1e-3)
        np.testing.assert_allclose(implicit[0], fine[0][:1], rtol=1e-3)
        self.assertGreater(fine[2], 3 * dry[2])
        self.assertLess(self.block(*DILATES)[2], 1e-4)

    def test_dilatancy(self):
        """Pressure of slow slip against dp/dt = -p/t_p + (epsilon/beta) d ln(theta)/dt with the run's own theta, by
        exact exponentials between its steps. A thousandth: ln(theta) is linear there, and changes by a quarter."""
        self.block(*DILATES, "-ts_rtol", 1e-6, fields="slip,slip_rate,state,shear_zone_pressure")
        time, theta, pressure = (x.ravel() for x in self.get("o.h5", *("fields/" + name for name in (
            "time", "state", "shear_zone_pressure"))))
        epsilon, beta, run = DILATES[1::2]
        p = np.zeros(len(time))
        for k, (h, change) in enumerate(zip(np.diff(time), np.diff(np.log(theta)))):
            p[k + 1] = p[k] * np.exp(-h / run) - epsilon / beta * change * np.expm1(-h / run) / (h / run)
        self.assertLess(pressure.min(), -0.3 * epsilon / beta)
        self.assertLess(np.abs(pressure - p).max(), 1e-3 * np.abs(p).max())

    def test_heat_alone(self):
        """Temperature without pressure changes nothing else: the same steps, slips, default controller and estimate. At
        rest, which is skipped in one step, heat flows away as between steps: no cell is as warm as when it slid."""
        quasi = ("-fault_inertia", "no", "-fault_viscosity", "radiation", "-fault_initial", "traction")
        loaded = (*quasi, "-fault_initial_traction", 2.9e7, "-fault_loading_rate", 1e-9, "-fault_healing_time", 3e7,
                  "-fault_friction_slip", 0.05, "-ts_max_time", 1e10)
        for case in (("-fault_stiffness_scaling", "mean_slip"),
                     (*quasi, "-fault_initial_traction", 3.2e7, "-fault_initial_unstable", "yes", "-ts_max_time", 20),
                     loaded,
                     ("-fault_friction_law", "rate_and_state", "-fault_initial_rate", 1e-3, "-fault_friction_slip",
                      0.02, "-ts_max_time", 1e3)):
            common = ("-fault_nx", 4, "-fault_nz", 3, "-fault_length_x", 800, "-fault_length_z", 600,
                      "-fault_normal_stress", 5e7, "-fault_normal_stress_gradient", 100, "-fault_output_overwrite",
                      "yes", "-fault_output_interval", 1, *case)
            with self.subTest(case=case):
                said = [[line for line in self.fault(*common, "-fault_output", name, *more).splitlines() if
                         not line.startswith(("wall", "output", "cost"))]
                        for name, more in (("a.h5", ("-fault_output_fields", "slip,slip_rate")),
                                           ("b.h5", ("-fault_output_fields", "slip,slip_rate,temperature",
                                                     "-fault_shear_zone_width", 1e-3)))]
                self.assertEqual(*said)
                for field in ("time", "slip", "slip_rate"):
                    np.testing.assert_array_equal(self.get("a.h5", f"fields/{field}"),
                                                  self.get("b.h5", f"fields/{field}"), field)
                heat = self.get("b.h5", "fields/temperature")
                self.assertGreater(heat.max(), 1)
                if case is loaded:
                    self.assertLess(heat[-1].max(), 0.1 * heat.max())

    def test_checkpoint_and_ranks(self):
        """The same to the bit after a restart, and to rounding on two ranks: 1e-9, of rates that grow by decades."""
        rupture = ("-fault_initial", "traction", "-fault_initial_traction", 3.2e7, "-fault_initial_unstable", "yes",
                   "-fault_friction_drop", 0.1, "-fault_friction_slip", 0.1, "-ts_max_time", 2, *PRESSED, THERMAL,
                   "-fault_shear_zone_width", 5e-3)
        cycle = ("-fault_friction_law", "rate_and_state", "-fault_friction_slip", 0.02, "-fault_initial_rate", 1e-3,
                 "-ts_max_time", 1e3, *PRESSED, THERMAL, "-fault_shear_zone_width", 5e-3)
        for case in ((*rupture, "-ts_type", "rkc"), (*rupture, "-fault_inertia", "yes"),
                     (*rupture, "-fault_medium", "waves", "-fault_kernel", "full_space"),
                     (*cycle, *DILATES), (*cycle, "-ts_type", "bathe"), (*cycle, *DILATES, "-fault_medium", "waves",
                                                                        "-fault_kernel", "full_space")):
            common = ("-fault_nx", 6, "-fault_nz", 4, "-fault_length_x", 1200, "-fault_length_z", 800,
                      "-fault_normal_stress", 5e7, "-fault_normal_stress_gradient", 100, "-fault_output_fields",
                      ",".join(FIELDS), "-fault_output_overwrite", "yes", "-fault_output_interval", 1,
                      "-fault_stations", "500,500", *case)
            with self.subTest(case=case):
                self.fault(*common, "-fault_output", "whole.h5")
                self.fault(*common, "-fault_output", "ranks.h5", ranks=2)
                self.fault(*common, "-fault_output", "part.h5", "-fault_checkpoint", "c.chk", "-ts_max_steps", 13,
                           code=3)
                self.fault(*common, "-fault_output", "part.h5", "-fault_restart", "c.chk")
                whole, part, ranks = (self.last(name) for name in ("whole.h5", "part.h5", "ranks.h5"))
                self.assertGreater(len(whole["time"]), 20)
                self.assertGreater(whole["temperature"].max(), 1)
                heat, whole_run, ranks_run, part_run = (self.get(name, key) for name, key in (
                    ("whole.h5", "fields/temperature"), ("whole.h5", "stations/0/temperature"),
                    ("ranks.h5", "stations/0/temperature"), ("part.h5", "stations/0/temperature")))
                np.testing.assert_array_equal(heat[:, 2, 2], whole_run)
                np.testing.assert_array_equal(part_run, whole_run)
                np.testing.assert_allclose(ranks_run, whole_run, rtol=1e-9, atol=1e-9)
                for field in ("time", *FIELDS):
                    np.testing.assert_array_equal(whole[field], part[field], field)
                    np.testing.assert_allclose(ranks[field], whole[field], rtol=1e-9, atol=1e-9, err_msg=field)


if __name__ == "__main__":
    unittest.main()
