"""Faults that slip and pressure open to fluid: bursts of examples/valve.opts against a small code of its own, a steady
state in closed form, and a program that SlipStep once had, of which the numbers are stored."""

import os
import sys
import unittest

from scripts import SOURCE, FaultTest

import numpy as np

sys.path.insert(0, os.path.join(SOURCE, "tests", "benchmarks"))
try:
    import valve_reference
except ImportError:
    valve_reference = None

OPTIONS = os.path.join(SOURCE, "examples", "valve.opts")
REFERENCE = os.path.join(SOURCE, "tests", "benchmarks", "valve_reference.txt")
DAY = 86400.0
NX, NZ = 24, 20  # cells of 100 m
GRID = (f"-fault_nx {NX} -fault_nz {NZ} -fault_length_x 2400 -fault_length_z 2000 -fault_depth_top 2000 "
        "-fault_inertia no -fault_viscosity radiation -fault_normal_stress 40e6 -fault_normal_stress_gradient 0 "
        "-fault_friction_slip 0.05 -fault_wells wells.csv -fault_output run.h5 -fault_output_overwrite "
        "-fault_output_fields slip,pore_pressure -fault_permeability 5e-15").split()  # a diffusivity of 0.05 m^2/s
WELL = 4 * np.pi * 0.05 * 1e-10  # [m^3/s] over the strength p* = Q eta/(4 pi k w) of a point [Pa]


@unittest.skipUnless(valve_reference, "no SciPy")
class Valve(FaultTest):
    def valve(self, *more, **how):
        return self.fault("-options_file", OPTIONS, "-fault_parameters", "valve.h5", "-fault_output_overwrite", *more,
                          **how)

    def well(self, strength):
        self.put("wells.csv", f"well,x,z,s,m3/s\nA,1150,3050,0,{strength * WELL:.17g}\n")

    def test_ten_bursts(self):
        """Over 187 years by default, 10 of the 17 stored ones: to 1e-4, of which 4e-5 were left when measured."""
        self.run_example("valve.py", "valve.h5")
        self.valve("-ts_max_time", "187.46y", "-fault_output", "run.h5", "-fault_output_time_interval", "10y")
        found = valve_reference.bursts_of(*self.get("run.h5", "series/time", "series/max_slip_rate"), 1e-4)
        self.assertGreaterEqual(len(found), 10)
        np.testing.assert_allclose(found[:10], np.loadtxt(REFERENCE)[:10], rtol=1e-4)

    def test_restart_and_ranks(self):
        """Through two bursts, 19.2 years: a run that stops and goes on has the same bits, one on two ranks rounds
        otherwise, which the controller's steps feel, by less than their error of 4e-5."""
        self.run_example("valve.py", "valve.h5")
        end = ("-ts_max_time", "19.2y")
        self.valve(*end, "-fault_output", "whole.h5")
        steps = len(self.get("whole.h5", "series/time"))
        self.valve(*end, "-fault_output", "part.h5", "-fault_checkpoint", "state", "-ts_max_steps", steps // 2, code=3)
        self.valve(*end, "-fault_output", "part.h5", "-fault_checkpoint", "state", "-fault_restart", "state")
        self.valve(*end, "-fault_output", "two.h5", ranks=2)
        for name in ("series/time", "series/max_slip_rate", "series/border_volume", "fields/slip",
                     "fields/pore_pressure", "fields/permeability"):
            self.assertEqual(self.get("whole.h5", name).tobytes(), self.get("part.h5", name).tobytes(), name)
        one, two = (valve_reference.bursts_of(*self.get(name, "series/time", "series/max_slip_rate"), 1e-4)
                    for name in ("whole.h5", "two.h5"))
        self.assertEqual(len(one), 2)
        np.testing.assert_allclose(two, one, rtol=4e-5)

    def test_program_of_before(self):
        """The program valve, which SlipStep had before, had the diffusivity D0 (1 + F (1 - exp(-slip/L))) exp(p/S) in
        cells whose sides have the harmonic mean, -fault_permeability_law valve without healing, in steps of the
        diffusion and of the fault that made errors of first order. These are its pressures of six cells and its mean
        slip after 20 days of injection, 13 days after an event, with steps of 30 minutes and 6 hours and with half
        these, which changed them by 1.7 to 1.9 times less than halving before. The rest of
        such a series is 1.1 to 1.4 of its last difference; 1 is order 1, and 0.2 are left for the error of this run."""
        before = np.array([[1683244.9, 742621.52, 745806.43, 393471.36, 363336.98, 302205.6, 0.093602637],
                           [1683188.7, 742595.86, 745780.76, 393468.62, 363345.86, 302224.94, 0.093602576]])
        self.well(2e6)
        self.fault(*GRID, "-fault_initial", "traction", "-fault_initial_traction", "23.4e6", "-ts_max_time", "20d",
                   "-fault_permeability_law", "valve", "-fault_permeability_maximum", "45e-15",
                   "-fault_permeability_slip", "0.005", "-fault_permeability_stress", "5e6", "-ts_rtol", "1e-6",
                   "-fault_fluid_tolerance", "1e-4")
        pressure, slip = (self.get("run.h5", f"fields/{name}")[-1] for name in ("pore_pressure", "slip"))
        cells = (10, 11), (10, 14), (7, 11), (10, 19), (2, 5), (18, 22)  # row in depth, along strike
        found = np.array([*(pressure[cell] for cell in cells), slip.mean()])
        left = (found - before[1]) / (before[1] - before[0])
        self.assertTrue(((0.8 < left) & (left < 1.5)).all(), left)

    def test_steady_state(self):
        """With k = k0 exp(p/S) between borders at 0, S (exp(p/S) - 1) is the steady pressure of k0 alone (Kirchhoff's
        transform): within 1 % away from the well, where sides take the mean of k. From the centre of a cell to the
        border k is that of the centre, larger than the mean by the share p/(2 S)."""
        self.well(4e5)
        runs = []
        for more in ((), ("-fault_permeability_law", "stress", "-fault_permeability_stress", "1e6")):
            self.fault(*GRID, "-fault_fluid_border", "open", "-ts_max_time", 3000 * DAY, *more)
            runs.append(self.get("run.h5", "fields/pore_pressure")[-1])
        linear, pressure = runs
        x, z = np.meshgrid(np.arange(NX) - 11, np.arange(NZ) - 10)
        far = np.hypot(x, z) > 2
        self.assertGreater(linear[far].max(), 3e5)
        bound = np.full(linear.shape, 0.01)
        for edge in (np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1]):
            bound[edge] += pressure[edge] / 2e6
        self.assertLess((np.abs(1e6 * np.expm1(pressure / 1e6) / linear - 1) / bound)[far].max(), 1)


if __name__ == "__main__":
    unittest.main()
