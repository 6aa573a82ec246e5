#!/usr/bin/env python3
"""Rate-and-state friction of one block: runs against a reference in extended precision, the steady state, the stiffness
at which it becomes unstable, and runs that go on from checkpoints; also with two states, and of blocks that springs
connect."""

import os
import unittest

from scripts import BUILD, FaultTest
from slider import Slider, Sliders
from slipstep import Run
from slipstep.results.fields import Fields

import h5py
import numpy as np

SIGMA, A, B, SLIP, F0, V0, LOADING = 10e6, 0.01, 0.015, 0.01, 0.6, 1e-6, 1e-9
G, RHO = 30e9, 2500.0
CUTOFF = 1e-8  # default of -fault_state_cutoff_rate
ETA = 0.5 * np.sqrt(G * RHO)
CUT_OFF = ("-fault_friction_law", "cut_off")  # of examples/friction_law.c
TWO = ("-fault_friction_law", "two_states")
CRITICAL = SIGMA * (B - A) / SLIP  # stiffness [Pa/m] (Ruina 1983); eta V/sigma is 1e-9 of it


class SpringSlider(FaultTest):
    def fault(self, K, end, *options, name="o.h5", code=0, program="fault", cells=1, ranks=1):
        self.hdf5("k.h5", stiffness=np.eye(cells) * K if np.ndim(K) == 0 else K)
        return super().fault("-fault_nx", cells, "-fault_nz", 1, "-fault_stiffness_file", "k.h5", "-fault_friction_law",
                             "rate_and_state", "-fault_normal_stress", SIGMA, "-fault_normal_stress_gradient", 0,
                             "-fault_friction_a", A, "-fault_friction_b", B, "-fault_friction_slip", SLIP,
                             "-fault_loading_rate", LOADING, "-fault_shear_modulus", G, "-fault_density", RHO,
                             "-ts_max_time", repr(float(end)), "-fault_output", name, "-fault_output_interval", 1000000,
                             "-fault_stations", "1500,1500", *options, code=code,
                             program=os.path.join(BUILD, "bin", program), ranks=ranks)

    def station(self, name="o.h5", number=0):
        with h5py.File(self.path(name)) as file:
            return {key: data[...] for key, data in file[f"stations/{number}"].items()}

    def test_reference(self):
        """Half of the critical stiffness, from 100 times the loading rate: through an event, of 0.2 m/s after 8e4 s, to
        the quiet after it, and through a second one after 5.24e8 s. 1e-10, relative: local errors of 1e-13 in a
        thousand steps, and roundings of a traction by 1e-16, of which T/(a sigma), 60 times as much, is that of a slip
        rate."""
        for law, ends in (("aging", (6e6, 5.3e8)), ("slip", (6e6,)), ("composite", (6e6,)), ("prz", (6e6,)),
                          ("strong_rate_weakening", (6e6,))):
            slider = Slider(0.5 * CRITICAL, ETA, SIGMA, A, B, SLIP, F0, V0, LOADING, law, cutoff_rate=CUTOFF)
            psi = np.log(V0 / LOADING)
            if law == "composite":
                y = 0.5  # ln(V theta/d_c), y exp(y) = exp(-V/V_c), by Newton's method
                for _ in range(20):
                    y -= (y - np.exp(-LOADING / CUTOFF - y)) / (1 + np.exp(-LOADING / CUTOFF - y))
                psi += y
            if law == "prz":
                psi += np.log(2)
            if law == "strong_rate_weakening":  # the steady state at the loading rate
                steady = np.float64(slider.strong(LOADING)) / A
                psi = (A * (np.log(V0 / LOADING) + steady + np.log1p(-np.exp(-2 * steady))) - F0) / B
            named = ("-fault_friction_law" if law == "strong_rate_weakening" else "-fault_state_law", law)
            for end in ends:
                log_rate, state, u = slider.run(np.log(np.longdouble(100 * LOADING)), np.longdouble(psi), end, 1e3)
                for integrator in (("-ts_type", "rk", "-ts_rk_type", "8vr"),
                                   ("-ts_type", "adams", "-ts_adams_max_order", "8")):
                    self.fault(0.5 * CRITICAL, end, "-fault_initial_rate", repr(100 * LOADING), *named,
                               "-ts_rtol", "1e-13", "-ts_adapt_type", "basic", *integrator)
                    last = {key: values[-1] for key, values in self.station().items()}
                    self.assertEqual(last["time"], end)
                    # Adams' steps are shorter, and roundings of more of them are left: 2e-10, as much at a tighter
                    # tolerance
                    bound = 1e-9 if "adams" in integrator else 1e-10
                    with self.subTest(law=law, end=end, integrator=integrator):
                        self.assertLess(abs(last["slip_rate"] / float(np.exp(log_rate)) - 1), bound)
                        self.assertLess(abs(last["state"] / float(SLIP / V0 * np.exp(state)) - 1), bound)
                        self.assertLess(abs(last["slip"] / float(u + LOADING * end) - 1), bound)
                        # mu is 0.6, and a of it goes with ln V
                        self.assertLess(abs(-last["traction"] / float(SIGMA * slider.friction(log_rate, state)) - 1),
                                        1e-11)

    def test_normal_stress(self):
        """A pore pressure takes a third of the normal stress within 2e6 s, and the state follows it, whether the steps
        are explicit or not; by the equations as Linker and Dieterich (1992) write them, with the rate of the stress. To
        what tolerances leave: 1e-9 of explicit steps; local errors of 1e-7 of ln V in 400 steps of second order,
        4e-5."""
        end, fall = 2e6, SIGMA / 3
        self.hdf5("p.h5", time=[0.0, end], pressure=np.array([0.0, fall]).reshape(2, 1, 1))
        rates = []
        for alpha in (0, 0.2):
            slider = Slider(2 * CRITICAL, ETA, SIGMA, A, B, SLIP, F0, V0, LOADING, ramp=-fall / end, alpha=alpha)
            psi = np.log(V0 / LOADING)
            log_rate, state, u = slider.run(np.log(np.longdouble(LOADING)), np.longdouble(psi), end, 1e3)
            rates.append(float(log_rate))
            for integrator, bound in ((("-ts_type", "rk", "-ts_rk_type", "8vr", "-ts_rtol", "1e-12"), 1e-9),
                                      (("-ts_type", "bathe", "-ts_rtol", "1e-7"), 1e-4)):
                self.fault(2 * CRITICAL, end, "-fault_initial_rate", repr(LOADING), "-fault_pore_pressure", "p.h5",
                           "-fault_friction_alpha", alpha, "-ts_adapt_type", "basic", *integrator)
                last = {key: values[-1] for key, values in self.station().items()}
                with self.subTest(alpha=alpha, integrator=integrator):
                    self.assertLess(abs(np.log(last["slip_rate"]) - float(log_rate)), bound)
                    self.assertLess(abs(np.log(last["state"]) - float(state + np.log(SLIP / V0))), bound)
        self.assertGreater(abs(rates[0] - rates[1]), 0.1)

    def test_steady(self):
        """Steady sliding at the loading rate stays, above the critical stiffness, for 1e4 d_c/v."""
        self.fault(2 * CRITICAL, 1e11, "-fault_initial_rate", repr(LOADING), "-ts_rtol", "1e-6", "-ts_type", "rk",
                   "-ts_adapt_type", "basic")
        s = self.station()
        # explicit steps grow until they are unstable, and what grows then is seen when it is as large as the tolerance
        np.testing.assert_allclose(s["slip_rate"], LOADING, rtol=1e-5)
        np.testing.assert_allclose(s["state"], SLIP / LOADING, rtol=1e-5)

    def test_stability(self):
        """One percent above the critical stiffness a disturbance decays and one percent below it grows, as fast as the
        eigenvalues of the linear equations say. Their real part is 1/4 of a percent of the rate V/d_c, so that in 20
        periods a disturbance changes by a factor of 1.6; 1 %: of a disturbance of 1e-4 the square is left out, local
        errors are 1e-10."""
        for factor in (0.99, 1.01):
            K = factor * CRITICAL
            # (ln V, psi) about steady sliding: sigma a dlnV/dt = -K V dlnV - sigma b dpsi/dt, dpsi/dt = -V/d_c (dlnV +
            # dpsi)
            rate = LOADING / SLIP
            matrix = np.array([[-K * LOADING / (SIGMA * A) + B / A * rate, B / A * rate], [-rate, -rate]])
            value = np.linalg.eigvals(matrix)[0]
            period = 2 * np.pi / abs(value.imag)
            self.assertEqual(value.real > 0, factor < 1)
            self.fault(K, 21 * period, "-fault_initial_rate", repr(LOADING * (1 + 1e-4)), "-ts_rtol", "1e-10",
                       "-ts_type", "rk", "-ts_rk_type", "5dp", "-ts_adapt_type", "basic")
            s = self.station()
            x, time = np.abs(np.log(s["slip_rate"] / LOADING)), s["time"]
            first, last = (np.max(x[(time > k * period) & (time < (k + 1) * period)]) for k in (0, 20))
            self.assertLess(abs(last / first / np.exp(20 * period * value.real) - 1), 0.01)

    def test_own_law(self):
        """The example's law without its cut-off is rate-and-state friction, by another way to the balance: the same
        final state to 1e-6, a hundred roundings and steps of 1e-8; with it the event is smaller."""
        end, slip = ("-fault_initial_rate", repr(100 * LOADING), "-ts_rtol", "1e-8", "-ts_type", "rk", "-ts_adapt_type",
                     "basic"), []
        self.fault(0.5 * CRITICAL, 6e6, *end, name="ours.h5")
        slip.append(self.station("ours.h5")["slip"][-1])
        for rate in ("1e30", "1e-3"):
            self.fault(0.5 * CRITICAL, 6e6, *end, *CUT_OFF, "-fault_cut_off_rate", rate, program="friction_law")
            slip.append(self.station()["slip"][-1])
        self.assertLess(abs(slip[1] / slip[0] - 1), 1e-6)
        self.assertLess(slip[2], 0.9 * slip[0])

    def two(self, b, slip):
        """Options of two states, whose b and d_c these are"""
        return (*TWO, "-fault_friction_b", b[0], "-fault_friction_b_2", b[1], "-fault_friction_slip", slip[0],
                "-fault_friction_slip_2", slip[1])

    def test_two_states(self):
        """One block whose second state takes four times the slip of the first, from 100 times the loading rate through
        an event of 0.2 m/s to the quiet after it: bounds as in test_reference, and what TSBATHE leaves, local errors of
        1e-6 of ln V in a thousand steps."""
        end, b, slip = 6e6, (0.012, 0.006), (SLIP, 4 * SLIP)
        K = 0.3 * CRITICAL
        for law, integrators in (("aging", ("rk", "adams", "bathe")), ("slip", ("rk",))):
            slider = Sliders([[K]], ETA, SIGMA, A, b, slip, F0, V0, LOADING, law)
            log_rate, states, u = (np.squeeze(x) for x in slider.run(np.log(100 * LOADING), np.log(V0 / LOADING), end,
                                                                     1e3))
            for integrator in integrators:
                more, bound = {"rk": (("-ts_rk_type", "8vr", "-ts_rtol", "1e-13"), 1e-10),
                               "adams": (("-ts_adams_max_order", "8", "-ts_rtol", "1e-13"), 1e-9),
                               "bathe": (("-ts_rtol", "1e-6"), 1e-3)}[integrator]
                self.fault(K, end, *self.two(b, slip), "-fault_initial_rate", repr(100 * LOADING), "-fault_state_law",
                           law, "-ts_type", integrator, "-ts_adapt_type", "basic", *more, "-fault_output_fields",
                           "slip,state,state_2", program="friction_law")
                last = {key: values[-1] for key, values in self.station().items()}
                with self.subTest(law=law, integrator=integrator):
                    self.assertLess(abs(np.log(last["slip_rate"]) - float(log_rate)), bound)
                    for name, psi, d in zip(("state", "state_2"), states, slip):
                        self.assertLess(abs(np.log(last[name] * V0 / d) - float(psi)), bound)
                    self.assertLess(abs(last["slip"] / float(u + LOADING * end) - 1), bound)
                    self.assertLess(abs(-last["traction"] / float(SIGMA * slider.friction(log_rate, states)) - 1),
                                    bound)
                    self.assertGreater(last["slip"], 5 * SLIP)
                    for name in ("state", "state_2"):
                        fields = Fields(Run(self.path("o.h5")), name)
                        self.assertEqual((fields.maps([len(fields.rows) - 1])[0, 0, 0], fields.kind.unit),
                                         (last[name], "s"))

    def test_two_states_of_blocks(self):
        """Three blocks with springs between them that start with rates and states of their own, on one and two ranks,
        to the bound of test_reference."""
        end, b, slip = 3e6, (0.012, 0.006), (SLIP, 4 * SLIP)
        K = CRITICAL * np.array([[0.8, -0.2, -0.1], [-0.2, 0.7, -0.2], [-0.1, -0.2, 0.9]])
        rates, theta = np.array([1, 100, 3]) * LOADING, np.array([[1, 3, 1], [1, 0.5, 1]]) * np.array([[SLIP], [
            4 * SLIP]]) / LOADING
        with h5py.File(self.path("fields.h5"), "w") as file:
            for name, values, unit in (("initial_rate", rates, "m/s"), ("initial_state", theta[0], "s"),
                                       ("initial_state_2", theta[1], "s")):
                file[name] = values[None]
                file[name].attrs["units"] = unit
        slider = Sliders(K, ETA, SIGMA, A, b, slip, F0, V0, LOADING)
        log_rate, states, u = slider.run(np.log(np.array(rates, dtype=np.longdouble)),
                                         np.log(V0 * theta / np.array(slip)[:, None]), end, 1e2)
        options = (*self.two(b, slip), "-fault_parameters", "fields.h5", "-ts_type", "rk", "-ts_rk_type", "8vr",
                   "-ts_rtol", "1e-13", "-ts_adapt_type", "basic",
                   "-fault_output_fields", "slip_rate,displacement,state,state_2")
        more, results = {"program": "friction_law", "cells": 3}, []
        for ranks in (1, 2):
            self.fault(K, end, *options, ranks=ranks, **more)
            with h5py.File(self.path("o.h5")) as file:
                results.append({name: file["fields/" + name][-1, 0]
                                for name in ("slip_rate", "displacement", "state", "state_2")})
                np.testing.assert_allclose(file["fields/state_2"][0, 0], theta[1], rtol=1e-14)  # ln and exp of it
            np.testing.assert_allclose(np.log(results[-1]["slip_rate"]), np.array(log_rate, dtype=float), atol=1e-10)
            np.testing.assert_allclose(results[-1]["displacement"], np.array(u, dtype=float), atol=1e-10 * SLIP)
            for k, name in enumerate(("state", "state_2")):
                np.testing.assert_allclose(np.log(V0 * results[-1][name] / slip[k]), np.array(states[k], dtype=float),
                                           atol=1e-10)
        for name in results[0]:
            np.testing.assert_allclose(results[0][name], results[1][name], rtol=1e-10)

    def test_two_states_restart(self):
        """Stopped and gone on with bit by bit, by every integrator, with both states in the stations and fields"""
        b, slip = (0.012, 0.006), (SLIP, 4 * SLIP)
        for integrator in (("rk", "-ts_adapt_type", "basic"), ("adams",), ("bathe", "-ts_adapt_type", "basic")):
            options = (*self.two(b, slip), "-fault_initial_rate", repr(100 * LOADING), "-ts_rtol", "1e-5",
                       "-fault_output_fields", "state,state_2", "-ts_type", *integrator)
            whole, part, more = f"whole_{integrator[0]}.h5", f"part_{integrator[0]}.h5", {"program": "friction_law"}
            self.fault(0.3 * CRITICAL, 6e6, *options, name=whole, **more)
            self.fault(0.3 * CRITICAL, 6e6, *options, "-ts_max_steps", "60", "-fault_checkpoint",
                       integrator[0] + ".chk", name=part, code=3, **more)
            text = self.fault(0.3 * CRITICAL, 6e6, *options, "-fault_initial_state_2", "1e7", "-fault_restart",
                              integrator[0] + ".chk", name="other.h5", code=1, **more)
            self.assertIn("initial_state_2 is", text)
            self.fault(0.3 * CRITICAL, 6e6, *options, "-fault_restart", integrator[0] + ".chk", name=part, **more)
            one, two = self.station(whole), self.station(part)
            self.assertGreater(len(one["time"]), 80)
            for key in ("state_2", *one):
                np.testing.assert_array_equal(one[key], two[key])

    def test_two_states_are_one(self):
        """A second state without weight, or with the slip of the first, is none: the same final state to 1e-6, as in
        test_own_law"""
        end, last = ("-fault_initial_rate", repr(100 * LOADING), "-ts_rtol", "1e-8", "-ts_type", "rk", "-ts_adapt_type",
                     "basic"), []
        for law in ((), self.two((B, 0), (SLIP, 7 * SLIP)), self.two((B - 0.006, 0.006), (SLIP, SLIP))):
            self.fault(0.5 * CRITICAL, 6e6, *end, *law, program="friction_law")
            last.append({key: values[-1] for key, values in self.station().items()})
        for other in last[1:]:
            for key in last[0]:
                self.assertLess(abs(other[key] / last[0][key] - 1), 1e-6)
        self.assertLess(abs(last[2]["state_2"] / last[2]["state"] - 1), 1e-6)

    def test_two_states_stability(self):
        """As test_stability, about the stiffness of Gu et al. (1984): neutral oscillations of the frequency w have a =
        sum of b_k/(1 + W d_k^2), W = (w/V)^2, and K = sigma times the sum of b_k/d_k (W d_k^2)/(1 + W d_k^2)."""
        b, slip = np.array([0.015, 0.006]), np.array([SLIP, 4 * SLIP])
        low, high = 0.0, 1e12
        for _ in range(200):
            W = (low + high) / 2
            low, high = (W, high) if np.sum(b / (1 + W * slip**2)) > A else (low, W)
        critical = SIGMA * np.sum(b / slip * W * slip**2 / (1 + W * slip**2))
        for factor in (0.99, 1.01):
            K, rate = factor * critical, LOADING / slip
            matrix = np.array([[-K * LOADING / (SIGMA * A) + np.sum(b * rate) / A, *(b * rate / A)],
                               *([-r, *(-r * (k == np.arange(2)))] for k, r in enumerate(rate))])
            value = max(np.linalg.eigvals(matrix), key=lambda x: (x.real, x.imag))
            period = 2 * np.pi / abs(value.imag)
            self.assertEqual(value.real > 0, factor < 1)
            self.fault(K, 21 * period, *self.two(b, slip), "-fault_initial_rate", repr(LOADING * (1 + 1e-4)),
                       "-ts_rtol", "1e-10", "-ts_type", "rk",
                       "-ts_rk_type", "5dp", "-ts_adapt_type", "basic", program="friction_law")
            s = self.station()
            x, time = np.abs(np.log(s["slip_rate"] / LOADING)), s["time"]
            # the third eigenvalue has died away after five periods
            first, last = (np.max(x[(time > k * period) & (time < (k + 1) * period)]) for k in (5, 20))
            self.assertLess(abs(last / first / np.exp(15 * period * value.real) - 1), 0.01)

    def fields(self, *values):
        self.hdf5("fields.h5", units={"cut_off_rate": "m/s"}, cut_off_rate=np.array([values]))

    def test_own_parameter(self):
        """Two blocks without a spring between, with a cut-off rate each, through an event: both as the reference has
        one alone, to the bounds of test_reference; a number for all is a block's own result."""
        rates, end, places = (1e-3, 3e-2), 6e6, ("-fault_stations", "750,1500;2250,1500")
        options = ("-fault_initial_rate", repr(100 * LOADING), "-ts_rtol", "1e-13", "-ts_adapt_type", "basic",
                   "-ts_type", "rk", "-ts_rk_type", "8vr", *CUT_OFF)
        self.fields(*rates)
        self.fault(0.5 * CRITICAL, end, *options, *places, "-fault_parameters", "fields.h5", program="friction_law",
                   cells=2)
        with h5py.File(self.path("o.h5")) as file:
            np.testing.assert_array_equal(file["mesh/cut_off_rate"], [rates])
            self.assertEqual(file["mesh/cut_off_rate"].attrs["units"], b"m/s")
        cells = [self.station(number=k) for k in range(2)]
        self.fault(0.5 * CRITICAL, end, *options, "-fault_cut_off_rate", repr(rates[1]), program="friction_law")
        for rate, s in zip((*rates, rates[1]), (*cells, self.station())):
            slider = Slider(0.5 * CRITICAL, ETA, SIGMA, A, B, SLIP, F0, V0, LOADING, cut_off=rate)
            log_rate, state, u = slider.run(np.log(np.longdouble(100 * LOADING)), np.log(np.longdouble(V0 / LOADING)),
                                            end, 1e3)
            last = {key: values[-1] for key, values in s.items()}
            with self.subTest(rate=rate):
                self.assertLess(abs(last["slip_rate"] / float(np.exp(log_rate)) - 1), 1e-9)
                self.assertLess(abs(last["state"] - float(state)), 1e-9)
                self.assertLess(abs(last["slip"] / float(u + LOADING * end) - 1), 1e-9)

    def test_own_parameter_restart(self):
        """A run with a field of the law's own that is stopped goes on bit by bit, and not with another field."""
        options = ("-fault_initial_rate", repr(100 * LOADING), "-ts_rtol", "1e-6", "-ts_type", "adams", *CUT_OFF,
                   "-fault_parameters", "fields.h5")
        more = {"program": "friction_law", "cells": 2}
        self.fields(1e-3, 3e-2)
        self.fault(0.5 * CRITICAL, 6e6, *options, name="whole.h5", **more)
        self.fault(0.5 * CRITICAL, 6e6, *options, "-ts_max_steps", "60", "-fault_checkpoint", "c.chk", name="part.h5",
                   code=3, **more)
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
        for value, words in (("0", ("-fault_cut_off_rate", "> 0 m/s")), ("fast", ("-fault_cut_off_rate", '"fast"')),
                             ("nan", ("-fault_cut_off_rate", "nan"))):
            text = self.fault(CRITICAL, 1, *CUT_OFF, "-fault_cut_off_rate", value, code=1, program="friction_law")
            for word in words:
                self.assertIn(word, text)
        self.fields(1e-3, -1)
        text = self.fault(CRITICAL, 1, *CUT_OFF, "-fault_parameters", "fields.h5", code=1, program="friction_law",
                          cells=2)
        self.assertIn("/cut_off_rate[0, 1] is -1", text)
        text = self.fault(CRITICAL, 1, *CUT_OFF, "-fault_cut_of_rate", "1", code=1, program="friction_law")
        self.assertIn("-fault_cut_off_rate?", text)
        text = self.fault(CRITICAL, 1, "-fault_cut_off_rate", "1", program="friction_law")
        self.assertIn("warning: -fault_cut_off_rate", text)
        text = self.fault(CRITICAL, 1, "-fault_cut_off_rate", "1", code=1)  # of the program without the law
        self.assertIn("-fault_cut_off_rate", text)


if __name__ == "__main__":
    unittest.main()
