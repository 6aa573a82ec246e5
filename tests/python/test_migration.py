"""Fronts of events that a fluid makes, on synthetic catalogues of known diffusivity, and what slipstep injection says
of them and of the injected volume."""

import re
import unittest

from scripts import PictureTest

import century
import h5py
import numpy as np
from slipstep import Run
from slipstep.errors import Error
from slipstep.numbers import migration

D, DAY = 0.05, 86400.0
CSV = "well,x,z,days,L/s,spread\nA,4000,6000,0,6,50\nA,4000,6000,20,0,50\nB,15000,5000,2,3,0\nB,15000,5000,30,0,0\n"


def during(random, count=400, scatter=0.0):
    """Distances and times of events below a front of D at 20 days of injection: uniform in the area that it has passed,
    places scattered by a factor."""
    time = random.uniform(0.1, 20, count) * DAY
    return (np.sqrt(4 * np.pi * D * time * random.uniform(0, 1, count)) * np.exp(scatter * random.normal(size=count)),
            time)


class Fronts(PictureTest):
    def test_front_within_its_error(self):
        """r^2/(4 pi D t) is u exp(2 scatter n) with u uniform: its quantile is found from a million draws of its own.
        Over 40 catalogues the errors are those that the fit says, about: their standard deviation over it is 1 within
        0.27, three standard errors of 1/sqrt(120) each."""
        for scatter in (0.0, 0.1):
            random = np.random.default_rng(3)
            true = D * np.quantile(random.uniform(size=10 ** 6) * np.exp(2 * scatter * random.normal(size=10 ** 6)),
                                   migration.SHARE)
            off = [(fit - true) / error for fit, error in (migration.fit_front(*during(random, 400, scatter))
                                                           for _ in range(60))]
            self.assertLess(abs(np.mean(off)), 4 / np.sqrt(40))
            # 0.34, and the error of the bootstrap of a quantile
            self.assertLess(abs(np.sqrt(np.mean(np.square(off))) - 1), 0.5)
        self.assertIsNone(migration.fit_front(*during(random, migration.LEAST - 1)))

    def test_back_front_is_where_the_pressure_turns(self):
        """The pressure of a point source from 0 to the stop, by quadrature of the heat kernel, falls within the back
        front and rises beyond it."""
        stop, h = 20 * DAY, 10.0

        def pressure(r, time, dimension):
            ages = np.linspace(max(time - stop, 0.0), time, 50001)[1:]
            return (ages ** (-dimension / 2) * np.exp(-r * r / (4 * D * ages))).mean() * (time - max(time - stop, 0.0))
        for dimension in (1, 2, 3):
            for time in (21 * DAY, 30 * DAY, 80 * DAY):
                r = float(migration.back_front(D, time, stop, dimension))
                for factor, falls in ((0.97, True), (1.03, False)):
                    change = (pressure(factor * r, time + h, dimension) - pressure(factor * r, time - h, dimension))
                    self.assertEqual(change < 0, falls, (dimension, time, factor))
        self.assertEqual(migration.back_front(D, 19 * DAY, stop, 2), 0)

    def test_back_front_within_its_error(self):
        """Squares of distances are those of the front times 1 and an exponential number."""
        random, stop, off = np.random.default_rng(5), 20 * DAY, []
        for _ in range(40):
            time = random.uniform(21, 60, 300) * DAY
            distance = migration.back_front(D, time, stop, 2) * np.sqrt(1 + random.exponential(size=300))
            fit, error = migration.fit_back_front(distance, time, stop, 2)
            off.append((fit - D * (1 - np.log(migration.SHARE))) / error)
        self.assertLess(abs(np.mean(off)), 4 / np.sqrt(40))
        self.assertLess(abs(np.sqrt(np.mean(np.square(off))) - 1), 0.5)

    def test_largest_and_bounds(self):
        onsets, moments = np.array([5.0, 1.0, 3.0]), np.array([2.0, 1.0, -4.0])
        np.testing.assert_array_equal(migration.largest_so_far(np.array([0, 1, 2, 3, 9.0]), onsets, moments),
                                      [0, 1, 1, 4, 4])
        linear, power = migration.bounds(np.array([-1.0, 100.0]), 30e9, 2e9).values()
        np.testing.assert_allclose(linear, [0, 3e12])
        np.testing.assert_allclose(power, [0, 2e12])


class Injections(PictureTest):
    """Of a century whose times are days in place of years, so that the injection lasts as long."""

    def write(self, options="", mesh=None, volume=True):
        run = century.write_run(self.path("run.h5"), cells=mesh, shape=(20, 40), fields=("slip",), step=2.0)
        with h5py.File(run, "r+") as file:
            time = file["series/time"][...]
            file["parameters"].attrs["shear_modulus"] = century.MODULUS
            file["run"].attrs["options"] = f"-fault_nx 40 {options} -fault_nz 20"
            moment = century.MODULUS * 2e8 * file["series/mean_slip"][...]
            century.put(file, "series/moment", moment[:, None], "N m")
            if volume:
                century.put(file, "series/injected_volume", 1e-2 * np.minimum(time, 20 * DAY), "m^3")
        self.put("wells.csv", CSV)
        return run

    def catalogue(self, seed=2):
        """Events in cells near those of D from the well A; moments of M 2 to 3."""
        x, z = (part.reshape(20, 40) for part in century.grid()[:2])
        random = np.random.default_rng(seed)
        distance, time = during(random, 300)
        distance *= 30  # 500 m are the cells
        angle = random.uniform(0, 2 * np.pi, 300)
        at = 4000 + distance * np.cos(angle), 6000 + distance * np.sin(angle)
        inside = (abs(at[0] - 5000) < 5000) & (abs(at[1] - 5000) < 5000)
        cell = np.array([np.argmin(np.hypot(x.ravel() - a, z.ravel() - b)) for a, b in zip(*at)])[inside]
        time = time[inside]
        moment = 10 ** (1.5 * random.uniform(2, 3, len(time)) + 9.1)
        data = {name: (np.ones(len(time)), unit) for name, (_, unit) in century.columns().items()}
        data.update(onset=(time, "s"), end=(time + 1, "s"), cell=(cell, "1"), moment=(moment, "N m"),
                    magnitude=((np.log10(moment) - 9.1) / 1.5, "1"), x=(x.ravel()[cell], "m"), z=(z.ravel()[cell], "m"))
        return century.write_catalogue(self.path("events.h5"), data), time

    def test_sources(self):
        """A file is found beside the run; a well ends where its last rate is 0; a point is -fault_injection's."""
        wells = migration.sources_of(Run(self.write("-fault_wells wells.csv")))
        self.assertEqual([(w.name, w.begin / DAY, w.stop / DAY) for w in wells], [("A", 0, 20), ("B", 2, 30)])
        point, = migration.sources_of(Run(self.write("-fault_injection 1000,2000")))
        np.testing.assert_array_equal(point.place, [1000, np.nan, 2000])
        self.assertEqual((point.begin, point.stop), (0, np.inf))
        self.assertEqual(migration.sources_of(Run(self.write())), [])
        self.put("wells.csv", CSV.replace("30,0,0", "30,0,7"))
        with self.assertRaisesRegex(Error, "line 5: the well B .*: expected one place, radius and spread"):
            migration.sources_of(Run(self.path("run.h5")), self.path("wells.csv"))

    def test_distances(self):
        """From the nearest well that has begun, on a grid, and on two planes of a mesh where y is unknown."""
        events = {"cell": [17 * 40 + 30, 17 * 40 + 30, 10 * 40 + 8], "onset": np.array([1.0, 3.0, 0.0]) * DAY}
        x, z = (np.arange(40) + 0.5) * 500, (np.arange(20) + 0.5) * 500
        run = Run(self.write("-fault_wells wells.csv"))
        distance, time, nearest = migration.migration(run, events, migration.sources_of(run))
        np.testing.assert_allclose(distance[:2], [np.hypot(x[30] - 4000, z[17] - 6000),
                                                  np.hypot(x[30] - 15000, z[17] - 5000)])
        np.testing.assert_array_equal(time[:2], [DAY, DAY])
        np.testing.assert_array_equal(nearest, [0, 1, -1])
        self.assertTrue(np.isnan(distance[2]))
        with h5py.File(run.path, "r+") as file:  # dips by 30 degrees: the lower edge is 5 km deep
            century.put(file, "mesh/down_dip", file["mesh/z"][...], "m")
            file["mesh/z"][...] /= 2
        run = Run(run.path)
        distance = migration.migration(run, events, migration.sources_of(run))[0]
        self.assertAlmostEqual(distance[1], np.hypot(x[30] - 15000, z[17] - 10000))
        run = Run(self.write("-fault_wells wells.csv", mesh=century.grid()))
        distance = migration.migration(run, events, migration.sources_of(run))[0]
        self.assertAlmostEqual(distance[0], np.hypot(x[30] - 4000, z[17] - 6000))

    def test_program(self):
        """D is printed with its error and found: distances are 30 times those of D, those of cells off by up to 350 m,
        and what was beyond the fault is missing, so that D is less."""
        run, (catalogue, time) = self.write("-fault_wells wells.csv"), self.catalogue()
        one = self.put("one.csv", "\n".join(line for line in CSV.splitlines() if not line.startswith("B")))
        said = self.plot("injection", run, catalogue, "--wells", one)
        found, error = map(float, re.search(r"D of the front: (\S+) m\^2/s, standard error (\S+) m", said).groups())
        self.assertLess(abs(found - 900 * D * migration.SHARE), 0.15 * 900 * D + 3 * error, said)
        self.assertRegex(said, "D of the back front: too few events")
        self.assertRegex(said, r"Injected volume: 1\.728e\+04 m\^3, .*G dV: M 3\.74; 1\.5e\+09 dV\^1\.5: M 4\.29")
        self.look(self.path("run_injection.png"))
        said = self.plot("injection", run, catalogue)
        self.assertEqual(said.count("D of the"), 1)  # two wells end at two times
        said = self.plot("injection", self.write("-fault_injection 4000,6000", volume=False), catalogue)
        self.assertIn("Injected volume: unknown", said)
        said = self.plot("injection", self.write(volume=False), catalogue)
        self.assertRegex(said, "Migration: unknown.*--wells")
        self.refused("injection", "--galis is -1, expected a positive number", run, catalogue, "--galis", "-1", code=2)
        self.refused("injection", "no.csv", run, catalogue, "--wells", self.path("no.csv"))


if __name__ == "__main__":
    unittest.main()
