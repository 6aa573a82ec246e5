"""The small code of a fault valve that runs of SlipStep are compared with, tests/benchmarks/valve_reference.py: its
derivatives, its fluid against closed forms, and its fault without fluid against SlipStep."""

import os
import sys
import unittest
from math import erfc

from scripts import SOURCE, FaultTest

import h5py
import numpy as np

sys.path.insert(0, os.path.join(SOURCE, "tests", "benchmarks"))
try:
    import scipy.integrate
    import valve_reference
except ImportError:
    scipy = None

OPTIONS = os.path.join(SOURCE, "examples", "valve.opts")
FLUID = "output_fields", "permeability", "porosity", "pore_compressibility", "fluid_", "aperture"


@unittest.skipUnless(scipy, "no SciPy")
class ValveReference(FaultTest):
    def case(self, stiffness=None):
        self.run_example("valve.py", "valve.h5")
        return valve_reference.read_case(OPTIONS, self.path("valve.h5"), stiffness)

    def test_derivatives(self):
        """Each column by central differences, at a state of fast slip and pressure that differs from cell to cell; they
        leave 1e-7 of the column."""
        _, valve = self.case()
        size = np.repeat([1.0, 1.0, 1e6, 1e-15, 1.0], valve.n)
        y = valve.start() + size * np.random.default_rng(0).random(5 * valve.n)
        y[:valve.n] += 5
        exact = valve.rates(0, y, True)
        for j in range(5 * valve.n):
            step = np.zeros(5 * valve.n)
            step[j] = 1e-6 * size[j]
            found = (valve.rates(0, y + step) - valve.rates(0, y - step)) / (2e-6 * size[j])
            self.assertLess(abs(found - exact[:, j]).max(), 1e-6 * abs(exact[:, j]).max() + 1e-300, j)

    def fluid(self, n, stress, inflow, end):
        """Pressure of a column of n cells that does not slip; its valve."""
        edges = np.linspace(0, 16e3, n + 1)
        source = np.zeros(n)
        source[-1] = inflow / (16e3 / n)
        valve = valve_reference.Valve(
            valve_reference.antiplane(edges, 3e10), 16e3 / n, s0=60e6, a=0.025, b=0.015, f0=0.6, V0=1e-6, dc=0.02,
            eta=4.6e6, v_load=0.0, traction=1e6, rate0=1e-60, k0=2e-16, k_max=2e-13, L=1.0, T=1e8, stress=stress,
            source=source, pressure=0.0, top=0.0, porosity=0.05, compressibility=4e-10, aperture=1.0, viscosity=2e-4)
        found = scipy.integrate.solve_ivp(lambda t, p: valve.flow(p, valve.k0)[0], (0, end), np.zeros(n), "Radau",
                                          rtol=1e-9, atol=1e-2, jac=lambda t, p: valve.flow(p, valve.k0)[1])
        return (edges[1:] + edges[:-1]) / 2, found.y[:, -1], valve

    def test_steady_flow(self):
        """k0/eta exp(p/s) dp/dz = q has p = s ln(1 + q eta z/(k0 s)); of order 2 in the cells."""
        q, s = 1e-9, 15e6
        off = []
        for n in (16, 32):
            z, p, _ = self.fluid(n, s, q, 1e13)
            off.append(abs(p - s * np.log1p(q * 2e-4 * z / (2e-16 * s))).max() / p.max())
        self.assertLess(off[1], 1e-3)
        self.assertGreater(off[0] / off[1], 3.0)

    def test_inflow(self):
        """Of constant k, while the top does not feel it: p = q eta/k 2 sqrt(D t) ierfc(x/(2 sqrt(D t))) at the height x
        above the foot; all that enters is stored."""
        q, end, n = 1e-9, 3e7, 64
        D = 2e-16 / (2e-4 * 0.05 * 4e-10)
        z, p, valve = self.fluid(n, 1e60, q, end)
        self.assertAlmostEqual(valve.storage * p.sum() * 250 / (q * end), 1, places=9)
        x = (16e3 - z) / (2 * np.sqrt(D * end))
        exact = q * 2e-4 / 2e-16 * 2 * np.sqrt(D * end) * np.array(
            [np.exp(-v * v) / np.sqrt(np.pi) - v * erfc(v) for v in x])
        # h^2/(24 D t) of the largest pressure and less
        self.assertLess(abs(p - exact).max() / exact.max(), 2 * 250 ** 2 / (24 * D * end) + 1e-6)

    def test_dry_fault_is_that_of_slipstep(self):
        """Without fluid the first burst is SlipStep's, and so is its stiffness, of cells 10,000 km long, to 1e-8."""
        self.run_example("valve.py", "valve.h5")
        with open(OPTIONS, encoding="utf-8") as file:
            self.put("dry.opts", "".join(line for line in file if not any(f"-fault_{name}" in line for name in FLUID)))
        with h5py.File(self.path("valve.h5")) as file, h5py.File(self.path("dry.h5"), "w") as dry:
            for name in ("friction_a", "initial_rate", "initial_traction"):
                file.copy(name, dry)
        self.fault("-options_file", "dry.opts", "-fault_parameters", "dry.h5", "-fault_stiffness_view", "binary:K.bin",
                   "-ts_rtol", "1e-6", "-ts_max_time", "45y", "-fault_output", "run.h5")
        _, valve = self.case(self.path("K.bin"))
        _, own = self.case()
        self.assertLess(abs(valve.K - own.K).max() / own.K.max(), 1e-8)
        valve.source = 0 * valve.source
        burst, = valve.solve(45 * valve_reference.YEAR, 1e-4, 1e-7, 1)[0]
        found, = valve_reference.bursts_of(*self.get("run.h5", "series/time", "series/max_slip_rate"), 1e-4)
        self.assertLess(abs(found / burst - 1), 2e-6)  # -ts_rtol 1e-6 has it to 3e-7, 1e-5 to 5e-6

    def test_bursts_of_a_series(self):
        """A rate that stays above a tenth of the threshold is one burst; times are those of straight lines of ln v."""
        rates = 1e-4 * np.exp([-5.0, 1.0, -1.0, 2.0, -3.0, -1.0, 3.0, 4.0])
        np.testing.assert_allclose(valve_reference.bursts_of(np.arange(8.0), rates, 1e-4), [5 / 6, 5.25])


if __name__ == "__main__":
    unittest.main()
