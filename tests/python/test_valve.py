"""The program valve, fluid that diffuses in a fault whose slip and pressure open it: against point sources, what is
injected, a steady state in closed form, and the same scheme written again with SciPy's sparse matrices."""

import os
import re
import unittest

from scripts import BUILD, FaultTest

import h5py
import numpy as np

try:
    from scipy import sparse
    from scipy.sparse.linalg import spsolve
    from scipy.special import exp1
except ImportError:
    sparse = None

VALVE = os.path.join(BUILD, "bin", "valve")
DAY = 86400.0
NX, NZ, SIDE, D0 = 24, 20, 100.0, 0.05
GRID = (f"-fault_nx {NX} -fault_nz {NZ} -fault_length_x {NX * SIDE} -fault_length_z {NZ * SIDE} -fault_depth_top 2000 "
        "-fault_inertia no -fault_viscosity radiation -fault_normal_stress 40e6 "
        "-fault_normal_stress_gradient 0 -fault_friction_slip 0.05 -fault_output_fields slip,pore_pressure "
        f"-fault_output_overwrite -valve_diffusivity {D0}").split()
POINT = "-valve_points 1150,3050 -valve_pressures 2e6".split()  # the cell 11, 10
STRESS = ["-fault_initial", "traction", "-fault_initial_traction", "23.4e6"]  # it slides from 1 MPa on


@unittest.skipUnless(sparse, "no SciPy")
class Valve(FaultTest):
    def valve(self, *options, **more):
        return self.fault(*GRID, *options, program=VALVE, **more)

    def read(self, name):
        return self.get(name, "fields/time", "fields/slip", "fields/pore_pressure")

    def test_point_source(self):
        """Without feedback it is p* E1(r^2/(4 D t)): three cells and more from the point, before the edges matter,
        within 4 % of the pressure at three cells, (1/3)^2/4 for second differences of a logarithm; with cells and steps
        of half the size the error falls at least by 1.8 (space alone is of second order, steps of first)."""
        errors = []
        for half in (1, 2):
            n = [NX * half, NZ * half]
            self.valve("-fault_nx", n[0], "-fault_nz", n[1], *POINT, "-valve_points",
                       "1150,3050" if half == 1 else "1125,3025,1125,3075,1175,3025,1175,3075",
                       "-valve_pressures", "2e6" if half == 1 else "5e5,5e5,5e5,5e5", "-ts_max_time", 10 * DAY,
                       "-valve_step", 7200 / half, "-fault_output", "run.h5")
            times, _, pressure = self.read("run.h5")
            self.assertEqual(times[-1], 10 * DAY)
            x, z = np.meshgrid((np.arange(n[0]) + 0.5) * SIDE / half, 2000 + (np.arange(n[1]) + 0.5) * SIDE / half)
            r = np.hypot(x - 1150, z - 3050)
            exact = 2e6 * exp1(r ** 2 / (4 * D0 * times[-1]))
            far = (r > 300) & (r < 800)
            errors.append(np.abs(pressure[-1] - exact)[far].max())
        self.assertLess(errors[0], 0.04 * 2e6 * exp1(300 ** 2 / (4 * D0 * 10 * DAY)))
        self.assertGreater(errors[0] / errors[1], 1.8)

    def test_nothing_is_lost(self):
        """Behind closed edges the pressure holds all that was injected, 4 pi D0 p* until the stop, with any feedback,
        to the linear solver's 1e-10 a step; open edges let it out."""
        for more in ((), ("-valve_pressure_scale", "2e6", "-valve_slip_factor", "20", *STRESS)):
            self.valve(*POINT, "-valve_stop", 20 * DAY, "-ts_max_time", 40 * DAY, "-fault_output", "run.h5", *more)
            times, _, pressure = self.read("run.h5")
            held = pressure.reshape(len(times), -1).sum(axis=1) * SIDE ** 2
            np.testing.assert_allclose(held, 4 * np.pi * D0 * 2e6 * np.minimum(times, 20 * DAY), rtol=1e-6, atol=1e-3)
        self.valve(*POINT, "-valve_stop", 20 * DAY, "-ts_max_time", 400 * DAY, "-valve_edges", "open", "-fault_output",
                   "run.h5")
        self.assertLess(self.read("run.h5")[2][-1].sum() * SIDE ** 2, 0.7 * 4 * np.pi * D0 * 2e6 * 20 * DAY)

    def test_steady_state(self):
        """With D = D0 exp(p/S) between edges at 0, S (exp(p/S) - 1) is the steady pressure of D0 alone (Kirchhoff's
        transform): within 1 % away from the point, where faces take the mean of D."""
        runs = []
        for more in ((), ("-valve_pressure_scale", "1e6")):
            self.valve("-valve_points", "1150,3050", "-valve_pressures", "4e5", "-valve_edges", "open", "-ts_max_time",
                       3000 * DAY, "-valve_step", 20 * DAY, "-fault_output", "run.h5", *more)
            runs.append(self.read("run.h5")[2][-1])
        linear, found = runs[0], 1e6 * np.expm1(runs[1] / 1e6)
        x, z = np.meshgrid(np.arange(NX) - 11, np.arange(NZ) - 10)
        far = np.hypot(x, z) > 2
        self.assertGreater(linear[far].max(), 3e5)
        np.testing.assert_allclose(found[far], linear[far], rtol=0.01)

    def followed(self, times, slip, step, factor, length, scale):
        """Pressures at these times, by the same scheme."""
        number = np.arange(NX * NZ).reshape(NZ, NX)
        pairs = np.concatenate([np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], 1),
                                np.stack([number[:-1].ravel(), number[1:].ravel()], 1)])
        p, found = np.zeros(NX * NZ), []
        source = np.zeros(NX * NZ)
        source[10 * NX + 11] = 4 * np.pi * D0 * 2e6 / SIDE ** 2
        for k, (begin, end) in enumerate(zip(times, times[1:])):
            whole = int(np.floor((end - begin) / step))
            for dt in [step] * whole + ([end - begin - whole * step] if end - begin > whole * step else []):
                D = D0 * (1 + factor * (1 - np.exp(-np.abs(slip[k].ravel()) / length))) * np.exp(p / scale)
                flow = dt / SIDE ** 2 * 2 / (1 / D[pairs[:, 0]] + 1 / D[pairs[:, 1]])
                off = sparse.coo_matrix((flow, pairs.T), shape=(p.size, p.size))
                off = off + off.T
                p = spsolve(sparse.diags(1 + np.asarray(off.sum(axis=1)).ravel()).tocsc() - off.tocsc(),
                            p + dt * source)
            found.append(p)
        return np.array(found)

    FEEDBACK = ("-valve_slip_factor", "8", "-valve_slip", "0.005", "-valve_pressure_scale", "5e6", "-valve_step",
                "7200", *STRESS)

    def test_feedback(self):
        """Of slip and of pressure: what the run has at each of its steps is what the scheme gives for the slip that the
        run had. It slips, and fluid spreads farther than without."""
        self.valve(*POINT, *self.FEEDBACK, "-ts_max_time", 20 * DAY, "-ts_adapt_dt_max", DAY, "-fault_output", "run.h5",
                   "-fault_output_interval", 1)
        times, slip, pressure = self.read("run.h5")
        self.assertGreater(slip[-1].max(), 0.005)
        expected = self.followed(times, slip, 7200, 8, 0.005, 5e6)
        np.testing.assert_allclose(pressure[1:].reshape(len(times) - 1, -1), expected, atol=1e-7 * expected.max())
        self.valve(*POINT, *STRESS, "-ts_max_time", 20 * DAY, "-fault_output", "alone.h5")
        self.assertGreater((pressure[-1] > 1e5).sum(), 1.3 * (self.read("alone.h5")[2][-1] > 1e5).sum())

    def test_steps_converge(self):
        """Halving both steps changes the slip at the end less and less."""
        ends = []
        for k in (1, 2, 4):
            self.valve(*POINT, *self.FEEDBACK, "-valve_step", 7200 / k, "-ts_max_time", 20 * DAY, "-ts_adapt_dt_max",
                       DAY / k, "-fault_output", "run.h5", "-ts_rtol", 1e-5, "-ts_adapt_type", "basic")
            ends.append(self.read("run.h5")[1][-1].max())
        self.assertLess(abs(ends[2] - ends[1]), 0.75 * abs(ends[1] - ends[0]))
        self.assertLess(abs(ends[2] - ends[1]), 0.03 * ends[2])

    def test_restart_and_ranks(self):
        run = [*POINT, *self.FEEDBACK, "-ts_max_time", 20 * DAY, "-ts_adapt_dt_max", DAY]
        self.valve(*run, "-fault_output", "whole.h5")
        self.valve(*run, "-fault_output", "part.h5", "-fault_checkpoint", "state", "-ts_max_steps", 30, code=3)
        self.valve(*run, "-fault_output", "part.h5", "-fault_checkpoint", "state", "-fault_restart", "state")
        for one, other in zip(self.read("whole.h5"), self.read("part.h5")):
            self.assertEqual(one[-1].tobytes(), other[-1].tobytes())
        # before the event: there rounding chooses steps
        same = [*POINT, *self.FEEDBACK, "-ts_max_time", 5 * DAY, "-ts_adapt_type", "none", "-ts_dt", 7200]
        for ranks in (1, 2):
            self.valve(*same, "-fault_output", f"{ranks}.h5", ranks=ranks)
        for one, other in zip(self.read("1.h5"), self.read("2.h5")):
            np.testing.assert_allclose(other[-1], one[-1], rtol=1e-7, atol=1e-8 * np.abs(one[-1]).max())
        self.assertGreater(self.read("1.h5")[1][-1].max(), 0.005)

    def test_times_have_units_and_numbers_are_in_them(self):
        """5 days are 432000 s, also of the step; numbers as in another unit are warned of, in the words of fault."""
        for name, more in (("one.h5", ("-valve_stop", "5d", "-valve_step", "2h")),
                           ("two.h5", ("-valve_stop", "432000", "-valve_step", "7200"))):
            self.valve(*POINT, "-ts_max_time", "10d", "-fault_output", name, *more)
        for one, other in zip(self.read("one.h5"), self.read("two.h5")):
            np.testing.assert_array_equal(one, other)
        for option, value, message in (("pressures", "2",
                                        "-valve_pressures has 2 Pa: is it given in MPa? Expected 100 to 1e+10 Pa"),
                                       ("diffusivity", "4320", "-valve_diffusivity is 4320 m^2/s: is it given in "
                                        "m^2/day or mm^2/s?"),
                                       ("slip", "50", "-valve_slip is 50 m: is it given in mm?")):
            self.assertIn(f"valve: warning: {message}",
                          self.valve(*POINT, f"-valve_{option}", value, "-ts_max_time", 100, "-fault_output", "run.h5"))

    def test_the_example_of_the_help(self):
        """Runs as it is, to its end."""
        said = self.valve("-help", "valve")
        words = re.search(r"^  valve (-.*)$", said, re.M)[1].split()
        self.fault(*words, program=VALVE)
        with h5py.File(self.path("run.h5")) as file:
            self.assertEqual((file.attrs["complete"], file["series/time"][-1]), (1, 40 * DAY))
            self.assertGreater(file["fields/slip"][-1].max(), 0)

    def test_refused(self):
        for option, value, message in (("diffusivity", "nan", "-valve_diffusivity is nan"),
                                       ("step", "inf", "-valve_step is inf"),
                                       ("slip", "abc", '"abc" is not a number (-valve_slip)'),
                                       ("stop", "5w",
                                        '"5w" is not a number (-valve_stop), nor one with s, min, h, d or y behind it'),
                                       ("stop", "-5d", "-valve_stop is -432000"),
                                       ("step", "0", "-valve_step is 0"),
                                       ("slip_factor", "-1", "-valve_slip_factor is -1"),
                                       ("pressure_scale", "-1", "-valve_pressure_scale is -1"),
                                       ("diffusivity", "5d", '"5d" is not a number (-valve_diffusivity)'),
                                       ("points", "1150,abc", '-valve_points is "1150,abc": "abc" is no finite number'),
                                       ("pressures", "nan", '-valve_pressures is "nan": "nan" is no finite number'),
                                       ("pressures", "2e6;", '"2e6;" is no finite number')):
            with self.subTest(option=option, value=value):
                said = self.valve(*POINT, f"-valve_{option}", value, code=1)
                self.assertIn(message, said)
                self.assertEqual(said.count("error:"), 1, said)
        for words, message in ((["-valve_points", "1,2"], "2 numbers and -valve_pressures 0"),
                               ([], "0 numbers"),
                               ([*POINT, "-valve_diffusivity", "0"], "-valve_diffusivity is 0"),
                               ([*POINT, "-valve_edges", "ajar"], "closed or open"),
                               (["-valve_points", "-5,3000", "-valve_pressures", "1e6"],
                                "x = -5, z = 3000 is not on the fault"),
                               ([*POINT, "-fault_mesh", "m.h5"], "-fault_mesh m.h5: the fluid of this program is on a "
                                "uniform grid"), ([*POINT, "-valve_pint", "3"], "valve_pint")):
            with self.subTest(message):
                self.assertIn(message, self.valve(*words, code=1))


if __name__ == "__main__":
    unittest.main()
