#!/usr/bin/env python3
"""No integrator and no controller steps over a pulse of the loading: each slips as the others do, or says that it may
not."""
import re
import unittest

from scripts import FaultTest

import h5py
import numpy as np

DAY = 86400.0
GRID = ("-fault_nx 4 -fault_nz 4 -fault_length_x 2e3 -fault_length_z 2e3 -fault_normal_stress 40e6 "
        "-fault_normal_stress_gradient 0 -fault_inertia no "
        "-fault_viscosity radiation -fault_initial traction -fault_pore_pressure pulse.h5 -ts_max_time 40d "
        "-fault_output run.h5 -fault_output_overwrite").split()
# nearly locked, at 1e-14 m/s: every controller would have grown its steps to days when the pulse comes
CREEPS = "-fault_friction_law rate_and_state -fault_initial_traction 12e6 -fault_initial_rate 1e-14".split()
STICKS = "-fault_friction_law exponential_slip_weakening -fault_friction_slip 0.5 -fault_initial_traction 16e6".split()
TABLE = [(CREEPS, pair) for pair in ("adams basic", "adams dsp", "rk basic", "rk dsp", "rk pi", "rk heuristic",
                                     "lapusta dsp", "lapusta basic", "bathe dsp", "bathe basic")]
TABLE += [(STICKS, pair) for pair in ("rkc basic", "rkc dsp", "rk basic", "adams basic", "bathe heuristic", "bathe pi",
                                      "bathe dsp")]


class Corners(FaultTest):
    def pulse(self, length):
        """30 MPa for so long, with ramps of a tenth of a second, ten days after the start."""
        times = [0, 10 * DAY, 10 * DAY + 0.1, 10 * DAY + length, 10 * DAY + length + 0.1, 40 * DAY]
        self.hdf5("pulse.h5", units={"time": "s", "pressure": "Pa"}, time=np.array(times),
                  pressure=np.array([0, 0, 30e6, 30e6, 0, 0])[:, None, None] * np.ones((6, 4, 4)))

    def slip(self, *options):
        return self.slip_of(GRID, *options)

    def slip_of(self, *options):
        self.fault(*options[0], *options[1:])
        return float(self.get("run.h5", "result@mean_slip"))

    def test_pulses(self):
        """Slips agree to 1 %, ten times the errors that tolerances of 1e-3 leave in the worst cell; a run that misses
        the pulse slips 1e-8 m at most."""
        for length in (1.5, 60, 3600, DAY):
            self.pulse(length)
            for law in (CREEPS, STICKS):
                right = self.slip(*law, "-ts_type", "bathe", "-ts_adapt_type", "dsp", "-ts_rtol", "1e-6")
                self.assertGreater(right, 1e-3)
                for options, pair in TABLE:
                    if options is law:
                        integrator, controller = pair.split()
                        with self.subTest(length=length, pair=pair):
                            got = self.slip(*law, "-ts_type", integrator, "-ts_adapt_type", controller)
                            self.assertLess(abs(got / right - 1), 0.01, f"{got} for {right}")

    def test_injection(self):
        """The pressure of a well that stops after an hour, whose corner is that stop: slips within 2 %. PETSc's
        explicit steps slip by 1.2 % too much where they are as long as their stability allows, 11 times as much where a
        cell opens (16 MPa); Adams' steps of several corrections 1.12 times."""
        well = [option for option in GRID if option not in ("-fault_pore_pressure", "pulse.h5")]
        well += ("-fault_injection 900,1100 -fault_injection_diffusivity 100 -fault_injection_stop 3600 -ts_max_time "
                 "20d -fault_injection_pressure".split())
        some = [(law, pair) for law, pair in TABLE if pair in ("adams basic", "adams dsp", "rk basic",
                                                               "lapusta dsp", "bathe dsp") and law is CREEPS]
        some += [(STICKS, pair) for pair in ("rkc basic", "rkc dsp", "bathe heuristic", "bathe basic")]
        for law, pressure, table in ((CREEPS, "12e6", some), (STICKS, "12e6", some),
                                     (STICKS, "16e6", [(STICKS, "rk basic"), (STICKS, "adams basic")])):
            right = self.slip_of(well + [pressure], *law, "-ts_type", "bathe", "-ts_adapt_type", "dsp", "-ts_rtol",
                                 "1e-6")
            self.assertGreater(right, 1e-2)
            for options, pair in table:
                if options is law:
                    integrator, controller = pair.split()
                    with self.subTest(pressure=pressure, pair=pair):
                        got = self.slip_of(well + [pressure], *law, "-ts_type", integrator, "-ts_adapt_type",
                                           controller)
                        self.assertLess(abs(got / right - 1), 0.02, f"{got} for {right}")

    def test_accuracy_of_the_default(self):
        """The default steps keep -fault_accuracy where a pulse starts the slip, of which no policy knows: on 100 cells
        1e-2 in 45 of 48 pulses, and 1.8e-2 in all, in which the policy that was the default here missed it by up to 170
        times. Of 16 cells one that starts early is more: 3.5e-2 at any tolerance. A second run with steps of another
        accuracy says what the error is."""
        x, z = np.meshgrid(np.arange(4) - 1.2, np.arange(4) - 2.1)
        shape = np.exp(-(x ** 2 + z ** 2) / 3)
        for law in ("exponential_slip_weakening -fault_friction_slip 0.5".split(), ("constant",)):
            for ramp, length in ((0.1, 1.5), (1000, DAY)):
                self.hdf5("pulse.h5", units={"time": "s", "pressure": "Pa"},
                          time=np.cumsum([0, 10 * DAY, ramp, length, ramp, 25 * DAY]),
                          pressure=np.array([0, 0, 20e6, 20e6, 0, 0])[:, None, None] * shape)
                options = (*GRID, "-fault_friction_law", *law, "-fault_initial_traction", "16e6", "-fault_check_error")
                error = float(re.search(r"checked history error: +(\S+)", self.fault(*options))[1])
                self.assertLess(error, 0.04, (law, ramp))
        self.assertIn("pore pressures", self.fault(*options, "-ts_adapt_type", "rl"))
        # rate and state: the policy's slips are off by up to 20 %
        right = self.slip(*CREEPS, "-ts_adapt_type", "basic", "-ts_rtol", "1e-7")
        self.assertLess(abs(self.slip(*CREEPS) / right - 1), 0.02)  # measured 0.012
        self.assertIn("-ts_adapt_type dsp", self.fault(*GRID, *CREEPS, "-ts_adapt_type", "rl"))

    def test_longest_step(self):
        """The controller's longest step holds for the first step too, which no controller has chosen."""
        self.pulse(3600)
        for integrator, controller in (("lapusta", "dsp"), ("rk", "basic"), ("adams", "basic")):
            self.slip(*CREEPS, "-ts_type", integrator, "-ts_adapt_type", controller, "-ts_adapt_dt_max", "1d", "-ts_dt",
                      "5d")
            steps = self.get("run.h5", "steps/dt")[self.get("run.h5", "steps/accepted") == 1]
            self.assertLessEqual(steps.max(), DAY * (1 + 1e-12), integrator)

    def test_constant_steps(self):
        """Of PETSc's types they stay as they are, with one warning; where corners are ends of steps there is none. Ours
        end at corners, with one where two are within a step."""
        self.pulse(1.5)
        with h5py.File(self.path("pulse.h5"), "r+") as file:
            file["time"][...] = [0, 8000, 8500, 9000, 9500, 40 * DAY]
            file["pressure"][...] *= 1e-3
        constant = [*GRID, *CREEPS, "-ts_type", "rk", "-ts_adapt_type", "none", "-ts_max_time", "10500"]
        self.assertNotIn("corner", self.fault(*constant, "-ts_dt", "500"))
        self.assertEqual(self.fault(*constant, "-ts_dt", "3000").count("corner of the loading at 8000 s"), 1)
        constant = [*GRID, *CREEPS, "-ts_type", "bathe", "-ts_adapt_type", "none", "-ts_max_time", "10500"]
        for step, warnings in (("500", 0), ("333", 0), ("600", 1)):
            self.assertEqual(self.fault(*constant, "-ts_dt", step).count("between its corners at 8000 and 8500 s the "
                                                                         "loading changes within less than"), warnings,
                             step)


if __name__ == "__main__":
    unittest.main()
