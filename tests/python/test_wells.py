"""Pressure of wells (slipstep wells) against the diffusion equation, Laplace's transform of a well that holds its
pressure, and the program's own point source; slipstep injection."""

import contextlib
import io
import os
import re
import unittest
from unittest import mock

from scripts import BUILD, SOURCE, FaultTest, PictureTest

import h5py
import numpy as np
import slipstep
from slipstep import checks, running

try:
    from scipy.special import exp1, kv
    from slipstep import wells
except ImportError:
    kv = None

GRID = ("-fault_nx 8 -fault_nz 6 -fault_length_x 2400 -fault_length_z 1800 -fault_depth_top 2000 -fault_inertia no "
        "-fault_viscosity radiation -fault_normal_stress 40e6 "
        "-fault_normal_stress_gradient 0 -fault_friction_slip 0.5").split()
DAY = 86400.0


def laplace(radius, well, D, time, terms=12):
    """Pressure over that of a well of this radius which holds it from 0 on, by Stehfest's inversion of K0(r q)/(s K0(R
    q)), q^2 = s/D (van Everdingen and Hurst 1949)."""
    from math import factorial
    total, half = 0.0, terms // 2
    for i in range(1, terms + 1):
        weight = sum(k ** half * factorial(2 * k)
                     / (factorial(half - k) * factorial(k) * factorial(k - 1) * factorial(i - k) * factorial(2 * k - i))
                     for k in range((i + 1) // 2, min(i, half) + 1))
        s = i * np.log(2) / time
        q = np.sqrt(s / D)
        total += (-1) ** (half + i) * weight * kv(0, radius * q) / (s * kv(0, well * q))
    return total * np.log(2) / time


@unittest.skipUnless(kv, "no SciPy")
class Wells(FaultTest, PictureTest):
    def setUp(self):
        super().setUp()
        os.environ["SLIPSTEP_FAULT"] = os.path.join(BUILD, "bin", "fault")
        self.addCleanup(os.environ.pop, "SLIPSTEP_FAULT")

    def csv(self, text):
        self.put("wells.csv", text)
        return self.path("wells.csv")

    def read(self, text):
        return wells.read_wells(self.csv(text))

    def test_two_wells_diffuse(self):
        """The pressure of rates obeys dp/dt = D (d2p/dx2 + d2p/dz2) away from the wells, by central differences, whose
        errors are h^2/12 times fourth over second derivatives, some 1e-3 of a term 120 m from a well."""
        made = self.read("well,x,z,days,L/s\nA,0,1000,0,2\nA,0,1000,3,0.5\nB,300,1200,1,1\n")
        D, at, h, dt = 0.1, np.array([120.0, 0, 1090]), 3.0, 60.0
        places = at + np.array([[0, 0, 0], [h, 0, 0], [-h, 0, 0], [0, 0, h], [0, 0, -h]])
        pressure = wells.Pressure(made, D, places, np.zeros(5), 10 * DAY, per_rate=1e9)
        for time in (2 * DAY, 6 * DAY):
            p = pressure(time)
            rate = (pressure(time + dt) - pressure(time - dt))[0] / (2 * dt)
            spread = D * (p[1:].sum() - 4 * p[0]) / h ** 2
            self.assertGreater(abs(rate), 1e-3)
            self.assertLess(abs(rate - spread), 5e-3 * max(abs(rate), D * abs(p[1] - 2 * p[0] + p[2]) / h ** 2))

    def test_a_rate_is_fluid_that_is_stored(self):
        """4 pi D p* t is what the layer holds of a rate's p*: the sum of p over the plane (Theis: S = k h/(eta D))."""
        made = self.read("well,x,z,days,m3/s\nA,0,0,0,0.2\n")
        x = (np.arange(-150, 150) + 0.5) * 10
        grid = np.stack(np.meshgrid(x, x), -1).reshape(-1, 2)
        places = np.column_stack([grid[:, 0], 0 * grid[:, 0], grid[:, 1]])
        pressure = wells.Pressure(made, 0.5, places, np.full(len(places), 100.0), DAY, per_rate=3.0)
        self.assertAlmostEqual(pressure(DAY).sum() * 100 / (4 * np.pi * 0.5 * 0.6 * DAY), 1, delta=2e-3)

    def test_a_well_that_holds_its_pressure(self):
        """Against Laplace's transform: steps of the rate, eight a decade, leave 2 % of the pressure, and the well's
        size is not seen after many R^2/D."""
        radius, D = 0.1, 0.05
        made = self.read("well,x,y,z,days,MPa\nA,0,0,0,0,8\n")
        distance = np.array([5.0, 30, 100, 200])
        places = np.column_stack([distance, 0 * distance, 0 * distance])
        pressure = wells.Pressure(made, D, places, np.zeros(4), 20 * DAY, radius=radius)
        for time in (2 * DAY, 7 * DAY, 20 * DAY):
            expected = np.array([laplace(r, radius, D, time) for r in distance])
            np.testing.assert_allclose(pressure(time) / 8e6, expected, atol=0.02 * expected[0])

    def test_wells_hold_their_pressures_beside_each_other(self):
        """At the radius of each, in the middle between the changes of rates too: within 2 % of the largest."""
        made = self.read("well,x,y,z,days,MPa\nA,0,0,0,0,8\nB,40,0,0,2,5\nA,0,0,0,6,1\n")
        places = np.array([[0.1, 0, 0], [40.1, 0, 0]])
        pressure = wells.Pressure(made, 0.05, places, np.zeros(2), 10 * DAY, radius=0.1)
        for time, expected in ((1 * DAY, (8, None)), (3 * DAY, (8, 5)), (5.4 * DAY, (8, 5)), (7.3 * DAY, (1, 5)),
                               (10 * DAY, (1, 5))):
            for found, wanted in zip(pressure(time) / 1e6, expected):
                if wanted:
                    self.assertAlmostEqual(found, wanted, delta=0.16)

    def test_a_product_in_place_of_the_sum(self):
        """The pressure of many steps by a product of matrices is the sum over all, be they alone or many in place of
        which a few count: E1 is interpolated to 4e-7, and the least double of what cancels is far below."""
        random = np.random.default_rng(4)
        places, star = np.array([[5.0, 0, 3], [30, 0, 0], [100, 0, 50], [400, 0, 0]]), 2e6
        times = np.cumsum(random.choice([0.2, 1.0, 1.0, 30.0], 200))
        rates = random.uniform(-0.5, 1, (2, 200))
        made = [wells.Well(name, np.array([x, 0, 0]), times * DAY, rate, False)
                for name, x, rate in (("A", 0.0, rates[0]), ("B", 40.0, rates[1]))]
        pressure = wells.Pressure(made, 0.05, places, np.zeros(4), times[-1] * 1.5 * DAY, per_rate=star)
        held = wells.Pressure(self.read("well,x,y,z,days,MPa\nA,0,0,0,0,8\nB,40,0,0,2,5\nA,0,0,0,6,1\n"), 0.05, places,
                              np.zeros(4), 10 * DAY, radius=0.1)
        for found, instants, most in ((pressure, random.uniform(0, times[-1] * 1.5, 20), star),
                                      (held, [1e-3, 1, 2.0001, 5.5, 6.001, 10], 8e6)):
            steps = found.steps
            all_of = steps.since == -np.inf  # without those that are in place of others
            for time in np.array(instants) * DAY:
                alone = sum(size[j] * exp1(found.distance2[:, j] / (4 * 0.05 * (time - begin))) for begin, size
                            in zip(steps.begin[all_of], steps.size[all_of]) for j in range(2) if begin < time)
                np.testing.assert_allclose(found(time), alone, atol=1e-6 * most)
        self.assertEqual((pressure.steps.since == -np.inf).sum(), 200)
        last = times[-1] * 1.5 * DAY
        self.assertLess(((pressure.steps.since <= last) & (last < pressure.steps.until)).sum(), 60)

    def test_the_record_keeps_its_accuracy_at_all_times(self):
        """Two wells whose rates change every day for two years: straight lines are off by what was asked for at most,
        over the largest pressure, at any time, above all in the hours after a change; the bound that is told holds, and
        at 1 % there are little more times than the 1460 changes."""
        random = np.random.default_rng(2)
        places, area = self.places()
        made = [wells.Well(name, np.array([x, 0, 2800.0]), np.arange(730) * DAY, random.uniform(0, 5e-3, 730), False)
                for name, x in (("A", 450.0), ("B", 1900.0))]
        pressure = wells.Pressure(made, 0.5, places, area, 1458 * DAY, per_rate=1e9)
        at = np.sort(np.concatenate([random.uniform(0, 1458 * DAY, 1500),
                                     made[0].time + random.uniform(0, DAY / 3, 730)]))
        exact = np.concatenate([pressure(part) for part in np.array_split(at, 10)])
        for accuracy, fewest in ((0.01, 1700), (1e-3, 5000)):
            said = []
            times, values, bound = pressure.record(accuracy, said.append)
            most = values.max()
            self.assertEqual((times[0], times[-1]), (0, 1458 * DAY))
            self.assertLess(len(times), fewest)
            np.testing.assert_allclose(values[len(times) // 2], pressure(times[len(times) // 2]), rtol=1e-12)
            off = max(np.abs(np.interp(at, times, values[:, cell]) - exact[:, cell]).max() for cell in range(48))
            self.assertLess(off, bound)
            self.assertLess(bound, accuracy * most)
            self.assertGreater(off, 0.5 * bound)
            self.assertTrue(any(text.startswith("pressures: ") for text in said)
                            and said[-1] == "straight lines: 3.992 years of 3.992 years", said[-1])

    def test_units(self):
        """Hours, seconds and days, and all units of rates and pressures are the same well."""
        for head, row in (("hours,m3/s", "48,0.001"), ("s,L/s", "172800,1"), ("days,m3/day", "2,86.4")):
            found = self.read(f"well,x,z,{head}\nA,0,0,{row}\n")[0]
            self.assertFalse(found.is_pressure)
            np.testing.assert_allclose([found.time[0], found.value[0]], [172800, 1e-3], rtol=1e-14)
        for head, value in (("MPa", "2.5"), ("Pa", "2.5e6")):
            found = self.read(f"well,x,z,days,{head}\nA,0,0,2,{value}\n")[0]
            self.assertEqual((found.is_pressure, found.value[0]), (True, 2.5e6))

    def test_doubtful_numbers(self):
        """A well that does not reach the fault, as one in map coordinates, one above the ground, and numbers in other
        units: said, with the well, and what was expected."""
        rates = ["--permeability-thickness", "1e-13", "--diffusivity", "0.05"]
        for text, more, message in (
                ("well,x,y,z,days,m3/day\nP1,500000,5900000,2000,0,300\nP1,500000,5900000,2000,3,0\n", rates,
                 r"the pressure of the well P1 does not reach the fault until 6 days: it is 5.921e\+06 m from the "
                 r"nearest cell, .* x = 150 to 2250, y = 0 to 0, z = 2150 to 3650 m"),
                ("well,x,z,days,m3/day\nA,1200,2900,0,300\nA,1200,2900,3,0\nB,9e4,2900,0,300\n", rates,
                 "the pressure of the well B does not reach"),
                ("well,x,z,days,m3/s\nA,1200,2900,0,300\nA,1200,2900,3,0\n", rates,
                 r"the largest rate of the well A is 300 m\^3/s: is it given in L/s or m\^3/day\? Expected 1e-12 "
                 r"to 1 m\^3/s"),
                ("well,x,z,days,MPa\nA,1200,2900,0,3e6\n", ["--diffusivity", "0.05", "--end", "9d"],
                 r"the largest pressure of the well A is 3e\+12 Pa: is it given in Pa, in a column of MPa\?"),
                ("well,x,z,days,Pa\nA,1200,2900,0,3\n", ["--diffusivity", "0.05", "--end", "9d"],
                 r"the largest pressure of the well A is 3 Pa: is it given in MPa\? Expected 100 to 1e\+10 Pa"),
                ("well,x,z,days,L/s\nA,1200,2900,0,3\nA,1200,2900,864000,0\n", rates + ["--end", "9d"],
                 "the last time of the well A is .* s: is it given in s, in a column of days"),
                ("well,x,z,days,L/s\nA,1200,2900,0,3\n", rates + ["--end", "9d", "--viscosity", "1"],
                 "--viscosity is 1 Pa s: is it given in mPa s"),
                ("well,x,z,days,L/s\nA,1200,2900,0,3\n",
                 ["--end", "9d", "--permeability-thickness", "100", "--diffusivity", "0.05"],
                 r"--permeability-thickness is 100 m\^3: is it given in mD m"),
                ("well,x,z,days,L/s\nA,1200,2900,0,3\n",
                 ["--end", "9d", "--permeability-thickness", "1e-13", "--diffusivity", "4320"],
                 r"--diffusivity is 4320 m\^2/s: is it given in m\^2/day"),
                ("well,x,z,days,MPa\nA,1200,2900,0,3\n", ["--diffusivity", "0.05", "--end", "9d", "--radius", "100"],
                 "--radius is 100 m: is it given in mm or cm")):
            with self.subTest(message):
                code, out, err = self.main("wells", self.csv(text), self.path("p.h5"), *more, "--", *GRID)
                self.assertEqual((code, err.count("\n")), (0, 1), err)
                self.assertRegex(err, f"^slipstep wells: warning: .*{message}")
                self.assertIn("Pressure: ", out)
        os.remove(self.path("p.h5"))
        self.refused("wells", r"well A is at z = -2900 m",
                     self.csv("well,x,z,days,L/s\nA,1200,-2900,1,2\nA,1200,-2900,2,0\n"), self.path("p.h5"), *rates,
                     "--", *GRID)
        self.refused("wells", r"held for 0.5 s, .*2 m",
                     self.csv("well,x,z,s,MPa\nA,1200,2900,0,2\nA,1200,2900,0.5,4\n"), self.path("p.h5"),
                     "--diffusivity", "0.05", "--radius", "2", "--end", "9d", "--", *GRID)
        self.assertFalse(os.path.exists(self.path("p.h5")))

    def test_ranges_are_those_of_fault(self):
        """What the package and the program both know has one range."""
        with open(os.path.join(SOURCE, "src", "run", "watch", "warn.c"), encoding="utf-8") as file:
            found = re.search(r"\{FAULT_INJECTION_PRESSURE, (\S+), (\S+), \"(.*?)\"", file.read())
        self.assertEqual((float(found[1]), float(found[2]), found[3]), checks.PLAUSIBLE["pressure"][1:4])

    def test_progress_in_a_log(self):
        """A line once a minute where the output is no terminal, each on its own."""
        out = io.StringIO()
        with mock.patch.object(running, "MINUTE", 0.0), contextlib.redirect_stdout(out):
            line = running.Line(True, apart=True)
            line.tell("pressures: 1 s of 2 s")
            line.tell("pressures: 2 s of 2 s")
            line.close()
        self.assertRegex(out.getvalue(), r"^pressures: 1 s of 2 s, \S+ s\npressures: 2 s of 2 s, \S+ s\n$")

    def test_record_and_the_point_source(self):
        """A well with one rate until it stops is -fault_injection: the pressures that the run writes agree to the
        accuracy asked for, at all its steps."""
        self.csv("well,x,z,days,m3/s\nA,1050,2750,0,0.002\nA,1050,2750,10,0\n")
        said = self.plot("wells", self.path("wells.csv"), self.path("p.h5"), "--diffusivity", "0.05",
                         "--permeability-thickness", "1e-13", "--accuracy", "0.005", "--end", "30d", "--", *GRID)
        star = 0.002 * 1e-3 / (4 * np.pi * 1e-13)
        rest = [*GRID, "-ts_max_time", "30d", "-fault_output_fields", "pore_pressure", "-fault_output_time_interval",
                "0.5d"]
        self.fault(*rest, "-fault_pore_pressure", "p.h5", "-fault_output", "record.h5")
        self.fault(*rest, "-fault_injection", "1050,2750", "-fault_injection_pressure", star,
                   "-fault_injection_diffusivity", 0.05, "-fault_injection_stop", 10 * DAY,
                   "-fault_output", "source.h5")
        with h5py.File(self.path("p.h5")) as file:
            most = file["pressure"][...].max()
            self.assertEqual(file["pressure"].shape[1:], (6, 8))
            self.assertLess(len(file["time"]), 60)
        self.assertRegex(said,
                         rf"Largest pressure: {most / 1e6:.4g} MPa, at 10(\.\d+)? days, x, y, z = 1050, 0, 2750 m")
        for name in ("record", "source"):
            times, values = self.get(f"{name}.h5", "fields/time", "fields/pore_pressure")
            for time, row in zip(times, values):
                exact = wells.Pressure(wells.read_wells(self.path("wells.csv")), 0.05, *self.places(), 30 * DAY,
                                       per_rate=star / 0.002)(time)
                np.testing.assert_allclose(row.ravel(), exact, atol=(0.005 if name == "record" else 1e-6) * most)

    def places(self):
        x, z = np.meshgrid((np.arange(8) + 0.5) * 300, 2000 + (np.arange(6) + 0.5) * 300)
        return np.column_stack([x.ravel(), 0 * x.ravel(), z.ravel()]), np.full(48, 9e4)

    def test_bad_wells(self):
        for text, message in (("well,x,z,days,MPa\n", "no rows"), ("well,x,z,days\nA,0,0,0\n", "expected one column of "
                                                                   "pressures or rates: Pa or MPa or m3/s"),
                              ("well,x,z,MPa\nA,0,0,0\n", "s or hours or days"),
                              ("name,x,z,days,MPa\nA,0,0,0,1\n", "well,x,y,z,days,MPa"),
                              ("well,x,z,days,MPa\nA,0,0,0\n", "line 2"),
                              ("well,x,z,days,MPa\nA,0,0,0,nan\n", "line 2"),
                              ("well,x,z,days,MPa\nA,0,0,1,1\nA,0,0,1,2\n", "line 3: 1 days is not after"),
                              ("well,x,z,days,MPa\nA,0,0,1,1\nA,0,9,2,2\n", "line 3: the well A is at")):
            with self.subTest(message), self.assertRaisesRegex(slipstep.Error, message):
                self.read(text)
        with self.assertRaisesRegex(slipstep.Error, "cannot read"):
            wells.read_wells(self.path("none.csv"))
        path = self.csv("well,x,z,days,L/s\nA,1200,2900,1,2\n")
        self.refused("wells", "--permeability-thickness", path, self.path("p.h5"), "--diffusivity", "0.1", "--", *GRID)
        self.refused("wells", "--diffusivity is -1.0", path, self.path("p.h5"), "--diffusivity", "-1", code=2)
        self.refused("wells", "-fault_nx is 0", path, self.path("p.h5"), "--diffusivity", "1",
                     "--permeability-thickness", "1e-13", "--", "-fault_nx", "0")
        self.refused("wells", "two radii", self.csv("well,x,z,days,MPa\nA,1200,2900,0,2\n" "B,1200,2900,1,2\n"),
                     self.path("p.h5"), "--diffusivity", "1", "--", *GRID)
        for text in ("well,x,z,days,m3/day,spread\nA,0,0,0,1,20\n", "well,x,z,days,MPa,radius\nA,0,0,0,1,0.2\n"):
            self.refused("wells", "are for -fault_wells", self.csv(text), self.path("p.h5"), "--diffusivity", "0.1",
                         "--permeability-thickness", "1e-13", "--", *GRID)
        self.assertFalse(os.path.exists(self.path("p.h5")))

    def test_injection(self):
        """Events are those of the catalogue, and their moments never exceed that of all slip; the picture has all three
        panels."""
        self.csv("well,x,z,days,L/s\nA,1200,2900,0,6\nA,1200,2900,20,0\n")
        self.plot("wells", self.path("wells.csv"), self.path("p.h5"), "--diffusivity", "0.05",
                  "--permeability-thickness", "1e-13", "--", *GRID)
        with h5py.File(self.path("stress.h5"), "w") as file:
            x, z = np.meshgrid(np.arange(8), np.arange(6))
            file["initial_traction"] = 21e6 + 2e6 * np.sin(2.1 * x + 0.3) * np.cos(1.7 * z)
        for more in ((), ("-fault_output_fields", "slip,pore_pressure")):
            self.fault(*GRID, "-fault_initial", "traction", "-fault_parameters", "stress.h5", "-fault_friction_slip",
                       0.004, "-fault_pore_pressure", "p.h5", "-ts_max_time", "40d", "-fault_output", "run.h5",
                       "-fault_catalogue", "events.h5", "-fault_output_overwrite", *more)
            said = self.plot("injection", self.path("run.h5"), self.path("events.h5"),
                             *(() if more else ("--pressure", self.path("p.h5"))))
            self.look(self.path("run_injection.png"))
            events = slipstep.Catalogue(self.path("events.h5")).event
            table = np.loadtxt(self.path("run_injection.csv"), delimiter=",", skiprows=1)
            self.assertGreater(len(events["moment"]), 0)
            self.assertAlmostEqual(table[-1, 3] / events["moment"].sum(), 1, places=9)
            self.assertTrue((table[:, 3] <= table[:, 2] * (1 + 1e-3)).all())  # between steps of an event, measured 7e-5
            self.assertTrue((np.diff(table[:, 2:], axis=0) >= -1e-9 * table[-1, 2]).all())
            self.assertIn(f"{len(events['moment'])} events, the largest M {np.nanmax(events['magnitude']):.2f}", said)
            self.assertIn(f"({100 * table[-1, 3] / table[-1, 2]:.3g} %), aseismic", said)
            self.assertRegex(said, "Largest pressure: [0-9.]+ MPa at")


if __name__ == "__main__":
    unittest.main()
