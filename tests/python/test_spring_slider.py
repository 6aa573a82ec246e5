#!/usr/bin/env python3
"""Rate-and-state friction of one block: runs against a reference in extended precision, the steady state, the stiffness at which
it becomes unstable, and runs that go on from checkpoints."""

import os
import unittest

from scripts import BUILD, FaultTest
from slider import Slider

import h5py
import numpy as np

SIGMA, A, B, SLIP, F0, V0, LOADING = 10e6, 0.01, 0.015, 0.01, 0.6, 1e-6, 1e-9
G, RHO = 30e9, 2500.0
ETA = 0.5 * np.sqrt(G * RHO)
CUT_OFF = ("-fault_friction_law", "cut_off")  # of examples/friction_law.c
CRITICAL = SIGMA * (B - A) / SLIP  # stiffness [Pa/m] (Ruina 1983); eta V/sigma is 1e-9 of it


class SpringSlider(FaultTest):
    def fault(self, K, end, *options, name="o.h5", code=0, program="fault", cells=1):
        with h5py.File(self.path("k.h5"), "w") as file:
            file["stiffness"] = np.eye(cells) * K
        return super().fault("-fault_nx", cells, "-fault_nz", 1, "-fault_stiffness_file", "k.h5", "-fault_friction_law", "rate_and_state",
                             "-fault_normal_stress", SIGMA, "-fault_normal_stress_gradient", 0, "-fault_friction_a", A, "-fault_friction_b", B,
                             "-fault_friction_slip", SLIP, "-fault_loading_rate", LOADING, "-fault_shear_modulus", G, "-fault_density", RHO,
                             "-ts_max_time", repr(float(end)), "-fault_output", name, "-fault_output_interval", 1000000,
                             "-fault_stations", "1500,1500", *options, code=code, program=os.path.join(BUILD, "bin", program))

    def station(self, name="o.h5", number=0):
        with h5py.File(self.path(name)) as file:
            return {key: data[...] for key, data in file[f"stations/{number}"].items()}

    def test_reference(self):
        """Half of the critical stiffness, from 100 times the loading rate: through an event, of 0.2 m/s after 8e4 s, to the quiet
        after it, and through a second one after 5.24e8 s. 1e-10, relative: local errors of 1e-13 in a thousand steps, and roundings
        of a traction by 1e-16, of which T/(a sigma), 60 times as much, is that of a slip rate."""
        for law, ends in (("aging", (6e6, 5.3e8)), ("slip", (6e6,))):
            slider = Slider(0.5 * CRITICAL, ETA, SIGMA, A, B, SLIP, F0, V0, LOADING, law)
            psi = np.log(V0 / LOADING)
            for end in ends:
                log_rate, state, u = slider.run(np.log(np.longdouble(100 * LOADING)), np.longdouble(psi), end, 1e3)
                for integrator in (("-ts_type", "rk", "-ts_rk_type", "8vr"), ("-ts_type", "adams", "-ts_adams_max_order", "8")):
                    self.fault(0.5 * CRITICAL, end, "-fault_initial_rate", repr(100 * LOADING), "-fault_state_law", law, "-ts_rtol", "1e-13",
                               "-ts_adapt_type", "basic", *integrator)
                    last = {key: values[-1] for key, values in self.station().items()}
                    self.assertEqual(last["time"], end)
                    # Adams' steps are shorter, and roundings of more of them are left: 2e-10, as much at a tighter tolerance
                    bound = 1e-9 if "adams" in integrator else 1e-10
                    with self.subTest(law=law, end=end, integrator=integrator):
                        self.assertLess(abs(last["slip_rate"] / float(np.exp(log_rate)) - 1), bound)
                        self.assertLess(abs(last["state"] / float(SLIP / V0 * np.exp(state)) - 1), bound)
                        self.assertLess(abs(last["slip"] / float(u + LOADING * end) - 1), bound)
                        self.assertLess(abs(-last["traction"] / float(SIGMA * slider.friction(log_rate, state)) - 1), 1e-11)  # mu is 0.6, and a of it goes with ln V

    def test_normal_stress(self):
        """A pore pressure takes a third of the normal stress within 2e6 s, and the state follows it, whether the steps are explicit or not;
        by the equations as Linker and Dieterich (1992) write them, with the rate of the stress. To what tolerances leave: 1e-9 of
        explicit steps; local errors of 1e-7 of ln V in 400 steps of second order, 4e-5."""
        end, fall = 2e6, SIGMA / 3
        with h5py.File(self.path("p.h5"), "w") as file:
            file["time"] = [0.0, end]
            file["pressure"] = np.array([0.0, fall]).reshape(2, 1, 1)
        rates = []
        for alpha in (0, 0.2):
            slider = Slider(2 * CRITICAL, ETA, SIGMA, A, B, SLIP, F0, V0, LOADING, ramp=-fall / end, alpha=alpha)
            psi = np.log(V0 / LOADING)
            log_rate, state, u = slider.run(np.log(np.longdouble(LOADING)), np.longdouble(psi), end, 1e3)
            rates.append(float(log_rate))
            for integrator, bound in ((("-ts_type", "rk", "-ts_rk_type", "8vr", "-ts_rtol", "1e-12"), 1e-9), (("-ts_type", "bathe", "-ts_rtol", "1e-7"), 1e-4)):
                self.fault(2 * CRITICAL, end, "-fault_initial_rate", repr(LOADING), "-fault_pore_pressure", "p.h5", "-fault_friction_alpha", alpha,
                           "-ts_adapt_type", "basic", *integrator)
                last = {key: values[-1] for key, values in self.station().items()}
                with self.subTest(alpha=alpha, integrator=integrator):
                    self.assertLess(abs(np.log(last["slip_rate"]) - float(log_rate)), bound)
                    self.assertLess(abs(np.log(last["state"]) - float(state + np.log(SLIP / V0))), bound)
        self.assertGreater(abs(rates[0] - rates[1]), 0.1)

    def test_steady(self):
        """Steady sliding at the loading rate stays, above the critical stiffness, for 1e4 d_c/v."""
        self.fault(2 * CRITICAL, 1e11, "-fault_initial_rate", repr(LOADING), "-ts_rtol", "1e-6", "-ts_type", "rk", "-ts_adapt_type", "basic")
        s = self.station()
        # explicit steps grow until they are unstable, and what grows then is seen when it is as large as the tolerance
        np.testing.assert_allclose(s["slip_rate"], LOADING, rtol=1e-5)
        np.testing.assert_allclose(s["state"], SLIP / LOADING, rtol=1e-5)

    def test_stability(self):
        """One percent above the critical stiffness a disturbance decays and one percent below it grows, as fast as the
        eigenvalues of the linear equations say. Their real part is 1/4 of a percent of the rate V/d_c, so that in 20 periods a
        disturbance changes by a factor of 1.6; 1 %: of a disturbance of 1e-4 the square is left out, local errors are 1e-10."""
        for factor in (0.99, 1.01):
            K = factor * CRITICAL
            # (ln V, psi) about steady sliding: sigma a dlnV/dt = -K V dlnV - sigma b dpsi/dt, dpsi/dt = -V/d_c (dlnV + dpsi)
            rate = LOADING / SLIP
            matrix = np.array([[-K * LOADING / (SIGMA * A) + B / A * rate, B / A * rate], [-rate, -rate]])
            value = np.linalg.eigvals(matrix)[0]
            period = 2 * np.pi / abs(value.imag)
            self.assertEqual(value.real > 0, factor < 1)
            self.fault(K, 21 * period, "-fault_initial_rate", repr(LOADING * (1 + 1e-4)), "-ts_rtol", "1e-10", "-ts_type", "rk", "-ts_rk_type", "5dp", "-ts_adapt_type", "basic")
            s = self.station()
            x, time = np.abs(np.log(s["slip_rate"] / LOADING)), s["time"]
            first, last = (np.max(x[(time > k * period) & (time < (k + 1) * period)]) for k in (0, 20))
            self.assertLess(abs(last / first / np.exp(20 * period * value.real) - 1), 0.01)

    def test_restart(self):
        """A run that is stopped and goes on is the same, bit by bit."""
        for integrator in (("-ts_type", "rk", "-ts_adapt_type", "basic"), ("-ts_type", "adams", "-ts_adapt_type", "basic"), ("-ts_type", "adams")):
            whole, part = f"whole{len(integrator)}{integrator[1]}.h5", f"part{len(integrator)}{integrator[1]}.h5"
            options = ("-fault_initial_rate", repr(100 * LOADING), "-ts_rtol", "1e-6", *integrator)
            self.fault(0.5 * CRITICAL, 1e7, *options, name=whole)
            self.fault(0.5 * CRITICAL, 1e7, *options, "-ts_max_steps", "60", "-fault_checkpoint", "c.chk", name=part, code=3)
            self.fault(0.5 * CRITICAL, 1e7, *options, "-fault_restart", "c.chk", "-fault_checkpoint", "c.chk", name=part)
            one, two = self.station(whole), self.station(part)
            for key in one:
                np.testing.assert_array_equal(one[key], two[key])
            for file in ("c.chk", "c.chk.previous"):
                if os.path.exists(self.path(file)):
                    os.remove(self.path(file))

    def test_own_law(self):
        """The example's law without its cut-off is rate-and-state friction, by another way to the balance: the same final state to
        1e-6, a hundred roundings and steps of 1e-8; with it the event is smaller."""
        end, slip = ("-fault_initial_rate", repr(100 * LOADING), "-ts_rtol", "1e-8", "-ts_type", "rk", "-ts_adapt_type", "basic"), []
        self.fault(0.5 * CRITICAL, 6e6, *end, name="ours.h5")
        slip.append(self.station("ours.h5")["slip"][-1])
        for rate in ("1e30", "1e-3"):
            self.fault(0.5 * CRITICAL, 6e6, *end, *CUT_OFF, "-fault_cut_off_rate", rate, program="friction_law")
            slip.append(self.station()["slip"][-1])
        self.assertLess(abs(slip[1] / slip[0] - 1), 1e-6)
        self.assertLess(slip[2], 0.9 * slip[0])

    def fields(self, *values):
        with h5py.File(self.path("fields.h5"), "w") as file:
            file["cut_off_rate"] = np.array([values])
            file["cut_off_rate"].attrs["units"] = "m/s"

    def test_own_parameter(self):
        """Two blocks without a spring between, with a cut-off rate each, through an event: both as the reference has one alone, to
        the bounds of test_reference; a number for all is a block's own result."""
        rates, end, places = (1e-3, 3e-2), 6e6, ("-fault_stations", "750,1500;2250,1500")
        options = ("-fault_initial_rate", repr(100 * LOADING), "-ts_rtol", "1e-13", "-ts_adapt_type", "basic", "-ts_type", "rk", "-ts_rk_type", "8vr", *CUT_OFF)
        self.fields(*rates)
        self.fault(0.5 * CRITICAL, end, *options, *places, "-fault_parameters", "fields.h5", program="friction_law", cells=2)
        with h5py.File(self.path("o.h5")) as file:
            np.testing.assert_array_equal(file["mesh/cut_off_rate"], [rates])
            self.assertEqual(file["mesh/cut_off_rate"].attrs["units"], b"m/s")
        cells = [self.station(number=k) for k in range(2)]
        self.fault(0.5 * CRITICAL, end, *options, "-fault_cut_off_rate", repr(rates[1]), program="friction_law")
        for rate, s in zip((*rates, rates[1]), (*cells, self.station())):
            slider = Slider(0.5 * CRITICAL, ETA, SIGMA, A, B, SLIP, F0, V0, LOADING, cut_off=rate)
            log_rate, state, u = slider.run(np.log(np.longdouble(100 * LOADING)), np.log(np.longdouble(V0 / LOADING)), end, 1e3)
            last = {key: values[-1] for key, values in s.items()}
            with self.subTest(rate=rate):
                self.assertLess(abs(last["slip_rate"] / float(np.exp(log_rate)) - 1), 1e-9)
                self.assertLess(abs(last["state"] - float(state)), 1e-9)
                self.assertLess(abs(last["slip"] / float(u + LOADING * end) - 1), 1e-9)

    def test_own_parameter_restart(self):
        """A run with a field of the law's own that is stopped goes on bit by bit, and not with another field."""
        options = ("-fault_initial_rate", repr(100 * LOADING), "-ts_rtol", "1e-6", "-ts_type", "adams", *CUT_OFF, "-fault_parameters", "fields.h5")
        more = {"program": "friction_law", "cells": 2}
        self.fields(1e-3, 3e-2)
        self.fault(0.5 * CRITICAL, 6e6, *options, name="whole.h5", **more)
        self.fault(0.5 * CRITICAL, 6e6, *options, "-ts_max_steps", "60", "-fault_checkpoint", "c.chk", name="part.h5", code=3, **more)
        self.fields(1e-3, 2e-2)
        text = self.fault(0.5 * CRITICAL, 6e6, *options, "-fault_restart", "c.chk", name="other.h5", code=1, **more)
        self.assertIn("cut_off_rate is", text)
        self.fields(1e-3, 3e-2)
        self.fault(0.5 * CRITICAL, 6e6, *options, "-fault_restart", "c.chk", name="part.h5", **more)
        one, two = self.station("whole.h5"), self.station("part.h5")
        self.assertGreater(len(one["time"]), 100)
        for key in one:
            np.testing.assert_array_equal(one[key], two[key])

    def test_own_parameter_refused(self):
        """Bad values are refused by the name of option or dataset; what the chosen law does not read is warned of."""
        for value, words in (("0", ("-fault_cut_off_rate", "> 0 m/s")), ("fast", ("-fault_cut_off_rate", '"fast"')), ("nan", ("-fault_cut_off_rate", "nan"))):
            text = self.fault(CRITICAL, 1, *CUT_OFF, "-fault_cut_off_rate", value, code=1, program="friction_law")
            for word in words:
                self.assertIn(word, text)
        self.fields(1e-3, -1)
        text = self.fault(CRITICAL, 1, *CUT_OFF, "-fault_parameters", "fields.h5", code=1, program="friction_law", cells=2)
        self.assertIn("/cut_off_rate[0, 1] is -1", text)
        text = self.fault(CRITICAL, 1, *CUT_OFF, "-fault_cut_of_rate", "1", code=1, program="friction_law")
        self.assertIn("did you mean -fault_cut_off_rate", text)
        text = self.fault(CRITICAL, 1, "-fault_cut_off_rate", "1", program="friction_law")
        self.assertIn("warning: -fault_cut_off_rate has no effect", text)
        text = self.fault(CRITICAL, 1, "-fault_cut_off_rate", "1", code=1)  # of the program without the law
        self.assertIn("there is no option -fault_cut_off_rate", text)


if __name__ == "__main__":
    unittest.main()
