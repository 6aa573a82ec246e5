#!/usr/bin/env python3
"""Numbers that papers quote, on closed forms: Haskell's source, Brune's spectrum, fronts of known speed, cracks, draws
of Gutenberg and Richter, plates that are locked, the logarithm of afterslip; and of a run by the program, against its
catalogue."""

import csv
import unittest
from types import SimpleNamespace

from scripts import FaultTest, PictureTest

import h5py
import meshfiles
import numpy as np

from slipstep.geometry.cells import cells_of, grid_cells
from slipstep.numbers import cycle, of_event, of_run, rupture, source, spin_up, stress
from slipstep.numbers.report import UNITS, area_of, fastest, speed_or_none
from slipstep.results import Catalogue, Run
from slipstep.results.moment import moment_rate
from slipstep.studies.table import Files, value
from slipstep.times import YEAR, written
from slipstep.results.magnitudes import b_error, b_value, completeness, completeness_by_fit, goodness_of_fit


def haskell(rupture_time, rise_time, moment=1.0):
    """Moment rate of a line that breaks at a uniform speed with a ramp of slip: a box of one length convolved with one
    of the other, a trapezoid."""
    long, short = max(rupture_time, rise_time), min(rupture_time, rise_time)
    return np.array([0, short, long, long + short]), np.array([0, 1, 1, 0]) * moment / long


def brune(corner, moment=1.0, n=20000):
    """Moment rate whose spectrum is Brune's: moment w^2 t exp(-w t), to 30 of its times, with steps that grow."""
    w = 2 * np.pi * corner
    time = np.concatenate([[0], np.geomspace(1e-6, 30, n)]) / w
    return time, moment * w ** 2 * time * np.exp(-w * time)


class Source(unittest.TestCase):
    def test_spectrum_of_haskell(self):
        """|sinc(f T) sinc(f t)|, to rounding at all frequencies, also where times are added."""
        time, rate = haskell(8.0, 1.5, 3e18)
        frequency = np.geomspace(1e-5, 30, 500)
        exact = 3e18 * np.abs(np.sinc(frequency * 8.0) * np.sinc(frequency * 1.5))
        np.testing.assert_allclose(source.spectrum(time + 1e4, rate, frequency), exact, atol=1e-11 * 3e18)
        more = np.union1d(time, np.geomspace(1e-3, 9, 300))
        np.testing.assert_allclose(source.spectrum(more, np.interp(more, time, rate), frequency), exact,
                                   atol=1e-12 * 3e18)

    def test_durations_of_haskell(self):
        """Of a trapezoid: variance (T^2 + t^2)/12; of a box, with a rise time of nothing, 0.9 T between 5 and 95 %."""
        time, rate = haskell(8.0, 1.5)
        moment, centroid, variance = source.moments(time, rate)
        np.testing.assert_allclose([moment, centroid, variance], [1, 4.75, (8.0 ** 2 + 1.5 ** 2) / 12], rtol=1e-12)
        np.testing.assert_allclose(source.durations(time, rate)[1], 2 * np.sqrt(variance), rtol=1e-12)
        time, rate = haskell(8.0, 1e-9)
        np.testing.assert_allclose(source.durations(time, rate), [7.2, 8 / np.sqrt(3)], rtol=1e-6)
        # a triangle of length 2: the first 5 % of it end at sqrt(0.1)
        np.testing.assert_allclose(source.durations(np.array([0, 1.0, 2.0]), np.array([0, 1.0, 0]))[0],
                                   2 - 2 * np.sqrt(0.1), rtol=1e-12)

    def test_corner_of_haskell(self):
        """By integrals w^2 = 2/(t (T - t/3)). A fit far above both corners sees the mean of log|sin|, -log 2, twice:
        half of 1/(pi sqrt(T t)), to what three decades of a sum of logarithms leave, 2 %."""
        time, rate = haskell(8.0, 1.5)
        np.testing.assert_allclose(source.corner_of_integrals(time, rate), np.sqrt(2 / (1.5 * (8 - 0.5))) / (2 * np.pi),
                                   rtol=1e-12)
        frequency = np.linspace(20, 200, 40000)
        corner, _ = source.fit_brune(frequency, source.spectrum(time, rate, frequency), 1.0)
        np.testing.assert_allclose(corner, 0.5 / (np.pi * np.sqrt(8.0 * 1.5)), rtol=0.02)

    def test_corner_of_brune(self):
        """Within 1e-3, by the fit and by the integrals; variance 2/w^2; and with a rate that a run's steps of a
        hundredth of its length know."""
        for corner in (1e-3, 0.2, 10):
            time, rate = brune(corner, 1e18)
            found, misfit = source.corner_frequency(time, rate)
            self.assertAlmostEqual(found, corner, delta=1e-3 * corner)
            self.assertLess(misfit, 1e-3)
            self.assertAlmostEqual(source.corner_of_integrals(time, rate), corner, delta=1e-3 * corner)
            self.assertAlmostEqual(source.moments(time, rate)[2], 2 / (2 * np.pi * corner) ** 2,
                                   delta=1e-3 * 2 / (2 * np.pi * corner) ** 2)
        coarse = np.concatenate([[0], np.geomspace(3e-3, 20, 100)]) / (2 * np.pi)
        found, _ = source.corner_frequency(coarse, (2 * np.pi) ** 2 * coarse * np.exp(-2 * np.pi * coarse))
        self.assertAlmostEqual(found, 1, delta=0.01)

    def test_band_of_the_fit(self):
        """From a fifth of the corner by integrals to five times that, not above what the steps resolve, and at least to
        twice that."""
        for n, span in ((20000, 30), (13, 12), (4, 12)):
            time = np.linspace(0, span, n) / (2 * np.pi)
            rate = (2 * np.pi) ** 2 * time * np.exp(-2 * np.pi * time)
            guess = source.corner_of_integrals(time, rate)
            nyquist = 0.5 / (time[1] - time[0])
            high = {20000: 5 * guess, 13: nyquist, 4: 2 * guess}[n]
            self.assertTrue({20000: nyquist > 5 * guess, 13: 2 * guess < nyquist < 5 * guess,
                             4: nyquist < 2 * guess}[n], (n, nyquist / guess))
            frequency = np.geomspace(guess / 5, high, 400)
            expected = source.fit_brune(frequency, source.spectrum(time, rate, frequency),
                                        source.moments(time, rate)[0])
            np.testing.assert_allclose(source.corner_frequency(time, rate), expected, rtol=1e-9)

    def test_spectrum_of_a_change(self):
        """A rate from -1 to 1 has no moment: its amplitude is the odd part alone, 2 (sin x - x cos x)/x^2 over half a
        length, x = pi f, also where x is small."""
        x = np.array([1e-3, 9.9e-3, 1.01e-2, 0.5, 3.0])
        series = 2 * (x / 3 - x ** 3 / 30 + x ** 5 / 840 - x ** 7 / 45360)
        exact = np.where(x < 0.1, series, 2 * (np.sin(x) - x * np.cos(x)) / x ** 2)
        np.testing.assert_allclose(source.spectrum(np.array([0.0, 2.0]), np.array([-1.0, 1.0]), x / (2 * np.pi)), exact,
                                   rtol=1e-9)

    def test_corner_of_noise(self):
        """Amplitudes with a scatter of 30 %: the corner is that within a few of its errors, 0.3/sqrt(n) times what the
        slope of the spectrum makes of it."""
        rng = np.random.default_rng(1)
        frequency = np.geomspace(0.01, 10, 400)
        found = [source.fit_brune(frequency, source.brune(frequency, 2.0, 0.3) * np.exp(0.3 * rng.standard_normal(400)),
                                  2.0)[0] for _ in range(40)]
        # log A falls by g = 2 x^2/(1 + x^2) per log corner: its standard error is 0.3/sqrt(sum g^2)
        x2 = (frequency / 0.3) ** 2
        error = 0.3 / np.sqrt(((2 * x2 / (1 + x2)) ** 2).sum())
        self.assertLess(abs(np.mean(np.log(np.array(found) / 0.3))), 4 * error / np.sqrt(40))
        self.assertLess(np.std(np.log(found)), 1.5 * error)


def grid(nx, nz, length_x, length_z, strike=30.0, dip=60.0):
    return grid_cells({"nx": nx, "nz": nz, "length_x": length_x, "length_z": length_z, "depth_top": 0.0,
                       "strike": strike, "dip": dip}), (nz, nx)


def in_plane(cells):
    """Distances along strike and down dip [m] of cells of one strike and dip."""
    along, down = rupture.directions(cells)
    return (cells[:, :3] * along).sum(axis=1), (cells[:, :3] * down).sum(axis=1)


def triangles(nx, nz, size, seed):
    """Centroids, extents, strike and dip of triangles [N, 7] of a plane whose inner corners are shifted by up to a
    fifth of their distance."""
    rng = np.random.default_rng(seed)
    s, d = np.meshgrid(np.arange(nx + 1.0), np.arange(nz + 1.0))
    inner = (s > 0) & (s < nx) & (d > 0) & (d < nz)
    s, d = (size * (value + inner * rng.uniform(-0.2, 0.2, s.shape)) for value in (s, d))
    number = np.arange((nx + 1) * (nz + 1)).reshape(nz + 1, nx + 1)
    a, b, c, e = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    corners = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, e], 1)])
    s, d = s.ravel()[corners].mean(axis=1), d.ravel()[corners].mean(axis=1)
    cells = np.zeros((len(s), 7))
    cells[:, 3:5], cells[:, 5], cells[:, 6] = size / np.sqrt(2), 20.0, 40.0
    along, down = rupture.directions(cells)
    cells[:, :3] = s[:, None] * along + d[:, None] * down
    return cells


class Fronts(unittest.TestCase):
    def test_straight_fronts_are_exact(self):
        """On a grid, rectangles of one plane and triangles, whatever the direction; cells at the edges and beside cells
        that never broke too."""
        for name, (cells, shape) in (("grid", grid(20, 12, 20e3, 6e3)),
                                     ("rectangles", (grid(20, 12, 20e3, 9e3)[0], None)),
                                     ("triangles", (triangles(15, 10, 700.0, 3), None))):
            s, d = in_plane(cells)
            for angle in (0.0, 0.7, 2.0):
                time = 5 + (np.cos(angle) * s + np.sin(angle) * d) / 2700
                time[(s - s.mean()) ** 2 + (d - d.mean()) ** 2 < 1500 ** 2] = np.nan
                found = rupture.speed(time, cells, shape)
                self.assertTrue(np.isnan(found[np.isnan(time)]).all(), name)
                known = np.isfinite(found)
                self.assertGreater(known.sum(), 0.95 * np.isfinite(time).sum(), name)
                np.testing.assert_allclose(found[known], 2700, rtol=1e-9, err_msg=name)

    def test_circular_front(self):
        """The median over the area within 1 %, and half of the area within 2 %, of the speed; the error of a cell is a
        number times (cell/distance)^2."""
        for name, (cells, shape) in (("grid", grid(41, 41, 20e3, 20e3)),
                                     ("triangles", (triangles(30, 30, 700.0, 5), None))):
            s, d = in_plane(cells)
            time = np.hypot(s - s.mean(), d - d.mean()) / 3000
            speeds = rupture.speed(time, cells, shape)
            median, low, high = rupture.summary(speeds, time, cells)
            self.assertAlmostEqual(median, 3000, delta=30, msg=name)
            self.assertTrue(0.97 * 3000 < low <= median <= high < 1.03 * 3000, (name, low, high))
        errors = []
        for n in (21, 41):
            cells, shape = grid(n, n, 20e3, 20e3)
            s, d = in_plane(cells)
            time = np.hypot(s - s.mean() + 14e3, d - d.mean()) / 3000
            # 6 km from where it began, and within the edges
            far = (time > 2) & (np.abs(s - s.mean()) < 9e3) & (np.abs(d - d.mean()) < 9e3)
            errors.append(np.abs(rupture.speed(time, cells, shape) - 3000)[far].max())
        self.assertLess(errors[1], errors[0] / 3.5)

    def test_two_speeds(self):
        """A front that is slower beyond a line: both are among the percentiles, weighted by area."""
        cells, shape = grid(60, 10, 60e3, 10e3)
        s, _ = in_plane(cells)
        time = np.where(s < 30e3, s / 3000, 10 + (s - 30e3) / 1000)
        median, low, high = rupture.summary(rupture.speed(time, cells, shape), time, cells)
        np.testing.assert_allclose([low, high], [1000, 3000], rtol=1e-6)

    def test_two_faults(self):
        """Cells of another fault nearby, and of a parallel one without labels, are no neighbours."""
        one, two = grid(10, 10, 10e3, 10e3)[0], grid(10, 10, 10e3, 10e3)[0]
        normal = np.cross(*(axis[0] for axis in rupture.directions(one)))
        two[:, :3] += 800 * normal
        s, _ = in_plane(one)
        both, time = np.concatenate([one, two]), np.concatenate([s / 3000, 50 - s / 2000])
        for labels in (None, np.repeat([1, 2], 100)):
            np.testing.assert_allclose(rupture.speed(time, both, None, labels), np.repeat([3000, 2000], 100), rtol=1e-9)

    def test_too_few(self):
        cells, shape = grid(5, 5, 5e3, 5e3)
        time = np.full(25, np.nan)
        self.assertTrue(np.isnan(rupture.speed(time, cells, shape)).all())
        time[12:14] = [0, 1]
        self.assertTrue(np.isnan(rupture.speed(time, cells, shape)).all())  # along one line no gradient is known
        self.assertIsNone(rupture.summary(rupture.speed(time, cells, shape), time, cells))


    def test_gradients_are_of_least_squares(self):
        """The plane through the times of a cell and those about it, weighted by the inverse squared distance, the cell
        as its nearest: against a solver of least squares, also at edges, where the cell's own weight counts."""
        rng = np.random.default_rng(9)
        for cells, shape in (grid(9, 7, 9e3, 6e3), (triangles(9, 7, 700.0, 2), None)):
            s, d = in_plane(cells)
            time = (s / 3000 + 0.3 * d / 3000) + rng.uniform(0, 0.1, len(s))
            found = rupture.speed(time, cells, shape)
            for k, others in enumerate(rupture.neighbours(cells, shape)):
                others = others[others >= 0]
                x, y = s[others] - s[k], d[others] - d[k]
                square = x ** 2 + y ** 2
                weight = np.append(1 / square, 1 / square.min())
                rows = (np.column_stack([np.append(x, 0), np.append(y, 0), np.ones(len(x) + 1)])
                        * np.sqrt(weight)[:, None])
                gradient = np.linalg.lstsq(rows, np.append(time[others], time[k]) * np.sqrt(weight), rcond=None)[0]
                self.assertAlmostEqual(found[k] * np.hypot(*gradient[:2]), 1, places=8)

    def test_neighbours_of_many(self):
        """Of more cells than are looked at once, in any order: the eight about each."""
        cells, shape = grid(40, 30, 40e3, 30e3)
        order = np.random.default_rng(1).permutation(len(cells))
        place = np.empty(len(cells), int)
        place[order] = np.arange(len(cells))
        expected = rupture.neighbours(cells, shape)
        found = rupture.neighbours(cells[order])
        # at edges there are farther ones in place of those that are none
        inner = np.flatnonzero((expected >= 0).all(axis=1))
        self.assertEqual(len(inner), 38 * 28)
        for k, row in zip(inner, expected[inner]):
            self.assertEqual(sorted(place[row[row >= 0]]), sorted(value for value in found[place[k]] if value >= 0))

    def test_faults_that_touch(self):
        """Two halves of one plane with labels of their own: no gradient goes across; without labels it does."""
        cells, _ = grid(20, 10, 20e3, 10e3)
        s, _ = in_plane(cells)
        label = (s > s.mean()).astype(int)
        time = np.where(label, 50 - s / 2000, s / 3000)
        np.testing.assert_allclose(rupture.speed(time, cells, None, label), np.where(label, 2000, 3000), rtol=1e-9)
        self.assertGreater(np.abs(rupture.speed(time, cells) - np.where(label, 2000, 3000)).max(), 100)

    def test_corner_of_three_cells(self):
        """Two neighbours in different directions are enough: cells that broke as an L have the speed of a straight
        front in the middle."""
        cells, shape = grid(5, 5, 5e3, 5e3)
        s, d = in_plane(cells)
        time = np.full(25, np.nan)
        own = [6, 7, 11]
        time[own] = (s[own] + 0.5 * d[own]) / 2500
        self.assertAlmostEqual(rupture.speed(time, cells, shape)[6], 2500 / np.hypot(1, 0.5), places=6)

    def test_quantiles(self):
        """By weights, between the middles of their steps; the summary takes 16, 50 and 84 %, by the cells' areas,
        without those within two cells of the first."""
        np.testing.assert_allclose(rupture.weighted_quantiles(np.array([3.0, 1.0]), np.array([1.0, 1.0]),
                                                              (0.25, 0.5, 0.75)), (1, 2, 3))
        np.testing.assert_allclose(rupture.weighted_quantiles(np.array([1.0, 2.0, 3.0]), np.array([2.0, 1.0, 1.0]),
                                                              (0.25, 0.5, 0.625, 0.9)), (1, 1 + 1 / 1.5, 2, 3))
        cells, _ = grid(60, 1, 60e3, 1e3)
        cells[:, 4] *= np.linspace(1, 3, 60)
        time = np.arange(60.0)
        time[5] = -1  # where it began
        speeds = 1000 + 10.0 * np.arange(60)
        near = np.abs(np.arange(60) - 5) < 3
        far = np.linalg.norm(cells[:, :3] - cells[5, :3], axis=1) > 2 * np.sqrt(cells[:, 3] * cells[:, 4])
        speeds[~far] = 1e6
        self.assertTrue(near[~far].any() and far.sum() > 50)
        expected = rupture.weighted_quantiles(speeds[far], (cells[:, 3] * cells[:, 4])[far], (0.5, 0.16, 0.84))
        np.testing.assert_allclose(rupture.summary(speeds, time, cells), expected, rtol=1e-12)
        self.assertLess(expected.max(), 2000)
        np.testing.assert_allclose(rupture.summary(speeds, time, cells, np.ones(60)),
                                   np.quantile(speeds[far], (0.5, 0.16, 0.84), method="hazen"), rtol=1e-12)
        self.assertIsNone(rupture.summary(speeds, np.full(60, np.nan), cells))
        few = np.full(60, np.nan)
        few[[20, 30, 40]] = speeds[[20, 30, 40]]
        self.assertEqual(rupture.summary(few, time, cells)[0],
                         rupture.weighted_quantiles(speeds[[20, 30, 40]], (cells[:, 3] * cells[:, 4])[[20, 30, 40]],
                                                    (0.5,))[0])
        few[20] = np.nan
        self.assertIsNone(rupture.summary(few, time, cells))


class Stress(unittest.TestCase):
    def test_circular_crack(self):
        """A crack of uniform stress drop: all three are that, the moment's with Eshelby's slip, 24/(7 pi) drop/G
        sqrt(a^2 - r^2). With a drop that grows with r^2: 1/2 by area, 2/5 by slip. Cells of a fiftieth of the
        radius."""
        n, a, drop, modulus = 100, 3000.0, 3e6, 30e9
        x, y = np.meshgrid(*[(np.arange(n) + 0.5) / n * 2 * a - a] * 2)
        r = np.hypot(x, y).ravel()
        inside, area = r < a, np.full(n * n, (2 * a / n) ** 2)
        slip = 24 / (7 * np.pi) * drop / modulus * np.sqrt(np.maximum(a ** 2 - r ** 2, 0))
        self.assertAlmostEqual(stress.of_area(np.full(inside.sum(), drop), area[inside]), drop)
        self.assertAlmostEqual(stress.of_energy(np.full(n * n, drop), slip, area), drop)
        self.assertAlmostEqual(stress.of_moment(modulus * (slip * area).sum(), area[inside].sum()), drop,
                               delta=0.01 * drop)
        grows = drop * (r / a) ** 2
        self.assertAlmostEqual(stress.of_area(grows[inside], area[inside]), drop / 2, delta=0.01 * drop / 2)
        self.assertAlmostEqual(stress.of_energy(grows, slip, area), 0.4 * drop, delta=0.01 * 0.4 * drop)

    def test_of_moment(self):
        """7/16 M0/a^3 at Poisson's ratio 1/4, 3/8 in a fluid-like rock of 0, and with the exact moment of a crack 16 (1
        - nu)/(3 (2 - nu)) drop a^3 the drop at any."""
        self.assertAlmostEqual(stress.of_moment(16.0, np.pi), 7.0)
        self.assertAlmostEqual(stress.of_moment(8.0, np.pi, 0.0), 3.0)
        for nu in (0.0, 0.2, 0.25, 0.4):
            self.assertAlmostEqual(stress.of_moment(16 * (1 - nu) / (3 * (2 - nu)) * 2e6 * 1e9, np.pi * 1e6, nu), 2e6,
                                   delta=1)


def draw(rng, n, b, least=1.0):
    return least + rng.exponential(np.log10(np.e) / b, n)


class Magnitudes(unittest.TestCase):
    def test_b_within_its_error(self):
        """2000 draws of 400 events: b is within one and two of its errors in 68.3 and 95.4 % of them. Draws leave 1.0
        and 0.5 %, and that errors go with b itself 1 %."""
        rng = np.random.default_rng(7)
        for b in (0.7, 1.0, 1.3):
            found, of_aki, of_bolt = [], [], []
            for _ in range(2000):
                magnitude = draw(rng, 400, b)
                value, error = b_value(magnitude, 1.0)
                found.append(value)
                of_aki.append(error)
                of_bolt.append(b_error(magnitude, 1.0, value))
            self.assertAlmostEqual(np.mean(found), b * 400 / 399, delta=4 * b / np.sqrt(400 * 2000))
            for errors in (of_aki, of_bolt):
                off = np.abs(np.array(found) - b) / np.array(errors)
                self.assertAlmostEqual((off < 1).mean(), 0.683, delta=0.04)
                self.assertAlmostEqual((off < 2).mean(), 0.954, delta=0.02)

    def test_b_of_bins(self):
        """Rounded to 0.1 and 0.5 the estimate is that of the draw; taken as continuous it is not."""
        magnitude = draw(np.random.default_rng(3), 400000, 1.0, 0.75)
        for width in (0.1, 0.5):
            rounded = np.round(magnitude / width) * width
            least = 1.0
            b, error = b_value(rounded, least, width)
            self.assertAlmostEqual(b, 1.0, delta=4 * error)
            self.assertGreater(abs(b_value(rounded[rounded >= least - 1e-9], least)[0] - 1), 20 * error)

    def test_completeness(self):
        """Of a draw that is seen in whole from 1.5 on, and ever less below: within a bin by maximum curvature with its
        correction, not above by the fit, and b is that from there on."""
        rng = np.random.default_rng(5)
        magnitude = draw(rng, 60000, 1.0, 0.0)
        magnitude = magnitude[rng.uniform(size=len(magnitude)) < 10 ** (2.5 * np.minimum(magnitude - 1.5, 0))]
        least = completeness(magnitude)
        self.assertAlmostEqual(least, 1.5, delta=0.11)
        by_fit, fit = completeness_by_fit(magnitude)
        self.assertTrue(1.2 <= by_fit <= 1.6 and fit >= 95, (by_fit, fit))
        b, error = b_value(magnitude, 1.6)
        self.assertAlmostEqual(b, 1.0, delta=4 * error)
        self.assertGreater(goodness_of_fit(magnitude, 1.6), 97)
        self.assertLess(goodness_of_fit(magnitude, 0.5), 80)
        self.assertIsNone(completeness_by_fit(rng.uniform(1, 2, 500)))


class Cycle(unittest.TestCase):
    def test_seismic_coupling(self):
        self.assertAlmostEqual(cycle.seismic_coupling([1e18, 3e18], 8e18), 0.5)

    def test_episodes(self):
        """A rate that grows and falls by an exponential of time: it passes a level where its logarithm does. Events are
        none, nor what lasts too long."""
        time = np.arange(0, 4001.0, 10)
        rate = (1e-10 * np.exp(10 * np.exp(-((time - 1000) / 300) ** 2)) + 1e-10
                * np.exp(22 * np.exp(-((time - 3000) / 100) ** 2)))
        (begin, end, peak), = cycle.episodes(time, rate, 1e-8, 1e-3)
        half = 300 * np.sqrt(np.log(10 / np.log(1e-8 / 1e-10)))
        np.testing.assert_allclose([begin, end], [1000 - half, 1000 + half], atol=0.5)
        self.assertAlmostEqual(peak, 1e-10 * np.exp(10), delta=0.01 * peak)
        self.assertEqual(len(cycle.episodes(time, rate, 1e-8, 1.0)), 2)
        self.assertEqual(len(cycle.episodes(time, rate, 1e-8, 1.0, longest=300)), 1)
        self.assertEqual(cycle.crossings(time, np.ones(len(time)), 0.5), [(0.0, 4000.0)])
        # no logarithm of 0
        self.assertEqual(cycle.crossings(np.arange(5.0), np.array([0, 0, 1.0, 1.0, 0]), 0.5), [(2.0, 3.0)])
        one = np.array([1e-9, 1e-5, 2e-5, 1e-5, 1e-9])
        self.assertEqual([len(cycle.episodes(np.arange(5.0), one, 1e-8, high)) for high in (1.9e-5, 2.1e-5)], [0, 1])

    def test_afterslip(self):
        """The logarithm's own numbers back, also from rows that lie unevenly; with a scatter of 1 % within 5 %."""
        time = np.concatenate([[0], np.geomspace(10, 1e8, 200)])
        slip = 0.03 * np.log1p(time / 4e4)
        np.testing.assert_allclose(cycle.fit_afterslip(time, slip)[:2], [0.03, 4e4], rtol=1e-5)
        noisy = slip + 0.01 * slip.max() * np.random.default_rng(2).standard_normal(len(slip))
        np.testing.assert_allclose(cycle.fit_afterslip(time, noisy)[:2], [0.03, 4e4], rtol=0.15)
        a, t0, error = cycle.fit_afterslip(time, noisy)
        self.assertAlmostEqual(error, np.sqrt(np.mean((noisy - a * np.log1p(time / t0)) ** 2)), places=12)


class Program(FaultTest, PictureTest):
    def test_of_a_run(self):
        """An event by the program: its numbers are those of the catalogue where both have one, and the picture is
        there."""
        self.fault("-fault_nx", 20, "-fault_nz", 20, "-fault_output", "run.h5", "-fault_catalogue", "events.h5",
                   "-fault_catalogue_maps", "-fault_progress", "no")
        run, catalogue = Run(self.path("run.h5")), Catalogue(self.path("events.h5"))
        found = {one.name: one for one in of_run(run, catalogue)}
        event = {name: values[0] for name, values in catalogue.event.items()}
        self.assertEqual(found["moment"].value, event["moment"])
        # the same cells, but rows of fields lie around the event, and with inertia friction is not the elastic stress
        # before all cells rest: of 1e-3 m/s, mass and damping hold some percent
        self.assertAlmostEqual(found["stress_drop_area"].value, event["stress_drop"], delta=0.05 * event["stress_drop"])
        self.assertTrue(0.5 < found["stress_drop_energy"].value / event["stress_drop"] < 2)
        self.assertTrue(0.3 * event["rupture_speed"] < found["rupture_speed_median"].value < 3 * event["rupture_speed"])
        self.assertTrue(0.2 * event["end"] < found["duration_90"].value < event["end"])
        self.assertTrue(0.1 < found["corner_frequency"].value * found["duration_90"].value < 2)
        said = self.plot("numbers", self.path("run.h5"), "--catalogue", self.path("events.h5"), "--csv",
                         self.path("out.csv"), "--figure", self.path("out.png"))
        self.look(self.path("out.png"))
        self.assertIn("corner_frequency_integrals", said)
        with open(self.path("out.csv"), encoding="utf-8") as file:
            rows = {row["name"]: row for row in csv.DictReader(file)}
        self.assertEqual(float(rows["stress_drop_energy"]["value"]), found["stress_drop_energy"].value)
        said = self.plot("numbers", self.path("events.h5"))
        self.assertIn("rupture_speed_median", said)
        self.assertNotIn("corner", said)
        self.refused("numbers", "no event 2", self.path("events.h5"), "--event", "2")
        self.refused("numbers", "two rates", self.path("events.h5"), "--slow", "2", "1", code=2)
        self.refused("numbers", "--catalogue", self.path("run.h5"))

    def test_of_triangles(self):
        """The same fault on triangles and on its grid of half as many cells: areas alike, and numbers as near as two
        meshes have them."""
        vertices, cells = meshfiles.plane((16, 16), (187.5, 187.5), 0, 90, (0, 0, 0))
        meshfiles.write_hdf5(self.path("mesh.h5"), vertices, cells)
        found = []
        for name, mesh in (("grid", ("-fault_nx", 16, "-fault_nz", 16)), ("triangles", ("-fault_mesh", "mesh.h5"))):
            self.fault(*mesh, "-fault_output", f"{name}.h5", "-fault_catalogue", f"{name}_events.h5",
                       "-fault_catalogue_maps", "-fault_progress", "no")
            run, catalogue = Run(self.path(f"{name}.h5")), Catalogue(self.path(f"{name}_events.h5"))
            self.assertAlmostEqual(area_of(run, cells_of(run.path, run.mesh, run.extents)[0]).sum(), 9e6, delta=1)
            found.append({one.name: one.value for one in of_run(run, catalogue)})
        self.plot("numbers", self.path("triangles.h5"), "--catalogue", self.path("triangles_events.h5"), "--figure",
                  self.path("out.png"))
        self.look(self.path("out.png"))
        for name in ("stress_drop_area", "stress_drop_energy", "stress_drop_moment", "duration_90",
                     "corner_frequency_integrals", "rupture_speed_median"):
            self.assertAlmostEqual(found[1][name] / found[0][name], 1, delta=0.15, msg=name)

    def test_of_plates(self):
        """A fault that plates load and that stays locked: its deficit is rate times time, to the stiffness' share that
        creeps, and its coupling 1."""
        self.fault("-fault_nx", 8, "-fault_nz", 4, "-fault_initial", "traction", "-fault_initial_traction", 0,
                   "-fault_inertia", "no", "-fault_viscosity", "radiation", "-fault_loading_rate", 1e-9,
                   "-fault_normal_stress", 50e6, "-fault_normal_stress_gradient", 0, "-fault_healing_time", 3e7,
                   "-ts_max_time", "10y", "-fault_output", "run.h5", "-fault_catalogue", "events.h5",
                   "-fault_progress", "no")
        found = {one.name: one.value for one in of_run(Run(self.path("run.h5")), Catalogue(self.path("events.h5")))}
        self.assertAlmostEqual(found["slip_deficit"], 1e-9 * 10 * 365.25 * 86400, delta=1e-9)
        self.assertAlmostEqual(found["coupling"], 1, delta=1e-9)
        self.assertLessEqual(set(found), set(UNITS))
        self.assertEqual((found["seismic_coupling"], found["events"], found["slow_slip_episodes"]), (0, 0, 0))

    CYCLES = ("-fault_nx 32 -fault_nz 16 -fault_length_x 16e3 -fault_length_z 8e3 -fault_friction_law rate_and_state "
              "-fault_friction_slip 0.015 -fault_loading_rate 1e-9 -fault_normal_stress 5e7 "
              "-fault_normal_stress_gradient 0 -fault_inertia no -fault_catalogue_maps -fault_progress no "
              "-ts_max_time 200y").split()

    def test_spin_up(self):
        """A loaded fault whose first event is of the start: by default all numbers are of what follows its end, and
        each line says so; events and times that are given are left out as well, in programs and in studies. Afterslip
        ends where the fault slips as the plates move."""
        self.fault(*self.CYCLES, "-fault_output", "run.h5", "-fault_catalogue", "events.h5")
        files = self.path("run.h5"), "--catalogue", self.path("events.h5")
        run, catalogue = Run(files[0]), Catalogue(files[2])
        moment, onset, end = (catalogue.event[name] for name in ("moment", "onset", "end"))
        self.assertEqual(np.argmax(moment), 0)
        self.assertGreater(len(moment), 3)
        for spin, first, words in ((None, 1, f"without the first event, until {written(end[0])}"),
                                   ("2", 2, f"without the first 2 events, until {written(end[1])}"),
                                   ("60y", 1, "without the first 60 years, 1 event"), (0, 0, "with the spin-up")):
            found = {one.name: one for one in of_run(run, catalogue, spin=spin)}
            self.assertTrue(all(one.note.endswith(words) for one in found.values()), found)
            self.assertEqual((found["moment"].value, found["events"].value),
                             (moment[first:].max(), len(moment) - first))
            np.testing.assert_allclose(found["recurrence"].value, np.diff(onset[first:]).mean(), rtol=1e-12)
            begin = {None: end[0], "2": end[1], "60y": 60 * YEAR, 0: 0.0}[spin]
            after = run.series["time"] >= begin
            time, slipped = run.series["time"][after], run.series["moment"][after].sum(axis=1)
            plates = 30e9 * 128e6 * 1e-9 * (time[-1] - time[0])
            self.assertAlmostEqual(found["coupling"].value, 1 - (slipped[-1] - slipped[0]) / plates, places=9)
            self.assertAlmostEqual(found["seismic_coupling"].value, moment[first:].sum() / plates, places=9)
            self.assertAlmostEqual(found["slip_deficit"].value, (plates - slipped[-1] + slipped[0]) / (30e9 * 128e6),
                                   places=9)
        after = of_event(run, catalogue, 2)
        self.assertFalse(any("spin-up" in one.note or "without" in one.note for one in after))
        found = {one.name: one for one in after}
        time, rate, so_far = moment_rate(run, end[1], onset[2])
        fast = np.abs(rate.sum(axis=1)) > 30e9 * 128e6 * 1e-9
        self.assertTrue(fast[0])
        self.assertEqual(found["afterslip_moment"].value, abs(so_far[np.argmin(fast)].sum()))
        self.assertLess(found["afterslip_moment"].value, 0.1 * abs(so_far[-1].sum()))
        said = self.plot("numbers", *files, "--spin-up", "2")
        self.assertEqual(said.count("without the first 2 events"), len(said.splitlines()))
        self.assertIn(f"without the first event, until {written(end[0])}", self.plot("numbers", files[2]))
        self.assertRegex(self.plot("numbers", *files, "--figure", self.path("out.png")), "Figure")
        self.look(self.path("out.png"))
        self.refused("numbers", "spin-up is 5x", *files, "--spin-up", "5x")
        self.refused("numbers", "spin-up is -1", *files, "--spin-up=-1")
        self.refused("numbers", f"events.h5 has {len(moment)} events, and a spin-up of 99 is asked for", *files,
                     "--spin-up", "99")
        for spin, left in ((None, 1), (2, 2), ("60y", 1), (0, 0)):
            study = Files(SimpleNamespace(file=self.path), spin)
            self.assertEqual([value(name, study, {}) for name in ("left_out", "events", "moment", "recurrence")],
                             [left, len(moment) - left, moment[left:].max(), np.diff(onset[left:]).mean()])
            self.assertEqual(value("peak_slip_rate", study, {}),
                             run.series["max_slip_rate"][run.series["time"] >= (end[left - 1] if left and spin != "60y"
                                                                                else 60 * YEAR if left else 0)].max())

    def test_spin_up_by_default(self):
        """The first large event and those before it, if one of a magnitude less follows; nothing of faults that are not
        loaded."""
        def left(moment, loaded=True):
            event = {"moment": np.array(moment), "loading_work": np.full(len(moment), float(loaded)),
                     "end": 1.0 + np.arange(len(moment)), "onset": np.arange(len(moment))}
            return spin_up(None, SimpleNamespace(event=event, count=len(moment), path="events.h5"))

        self.assertEqual([left(moment).events for moment in ([3, 2, 2, 2], [0.1, 3, 2, 2], [9, 1, 1, 1], [1, 1, 1, 30],
                                                             [90, 1, 1], [5])], [1, 2, 1, 0, 0, 0])
        self.assertEqual((left([3, 2], False).events, left([3, 2], False).words), (0, ""))
        self.assertEqual(left([90, 1]).words, "with the spin-up, as no second large event follows")
        self.assertEqual((left([0.1, 3, 2]).until, left([5]).until), (2.0, -np.inf))

    def test_no_rupture_speed_above_the_waves(self):
        """Cells that break at once have a gradient, but no front: above the longitudinal waves it is no number, and the
        line says why."""
        self.fault("-fault_nx", 12, "-fault_nz", 12, "-fault_output", "run.h5", "-fault_catalogue", "events.h5",
                   "-fault_catalogue_maps", "-fault_progress", "no")
        run = Run(self.path("run.h5"))
        self.assertAlmostEqual(fastest(run) / np.sqrt(3 * 30e9 / 2500), 1, places=12)
        before = {one.name: one for one in of_run(run, Catalogue(self.path("events.h5")))}["rupture_speed_median"]
        self.assertTrue(0 < before.value < fastest(run))
        factor = 1.001 * fastest(run) / before.value
        with h5py.File(self.path("events.h5"), "r+") as file:
            file["maps/rupture_time"][...] /= factor
            file["rupture_speed"][...] = 1.001 * fastest(run)
        found = {one.name: one for one in of_run(run, Catalogue(self.path("events.h5")))}["rupture_speed_median"]
        self.assertTrue(np.isnan([found.value, found.low, found.high]).all())
        self.assertRegex(found.note, r"^none: \S+ m/s is above the longitudinal waves' 6000 m/s")
        self.assertTrue(np.isnan(value("rupture_speed", Files(SimpleNamespace(file=self.path)), {})))
        self.assertEqual(speed_or_none(5000.0, 6000.0), (5000.0, ""))


if __name__ == "__main__":
    unittest.main()
