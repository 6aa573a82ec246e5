"""The error of a run's whole course (slipstep.results.course): closed forms, dense sampling, and files of runs."""

import os
import subprocess
import sys
import unittest

import scripts

import h5py
import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(scripts.SOURCE, "tests", "benchmarks"))
from slipstep.results import course
from slipstep.results.course import Course


def cubic(times, factor=1.0):
    """s = t^2 (3 - 2 t) times a factor, 0 to 1 on [0, 1], which Hermite interpolation reproduces."""
    t = np.asarray(times, float)
    return Course(t, factor * t ** 2 * (3 - 2 * t), factor * 6 * t * (1 - t), factor * np.ones(1), np.ones(1))


def hermite_by_basis(c, t):
    """Value and derivative at times t by Hermite's basis functions: another formula than the module's."""
    k = np.clip(np.searchsorted(c.time, t, side="right") - 1, 0, len(c.time) - 2)
    h = c.time[k + 1] - c.time[k]
    x = (t - c.time[k]) / h
    s = (2 * x ** 3 - 3 * x ** 2 + 1) * c.slip[k] + (3 * x ** 2 - 2 * x ** 3) * c.slip[k + 1]
    s += h * ((x ** 3 - 2 * x ** 2 + x) * c.rate[k] + (x ** 3 - x ** 2) * c.rate[k + 1])
    v = ((6 * x ** 2 - 6 * x) * (c.slip[k] - c.slip[k + 1]) / h + (3 * x ** 2 - 4 * x + 1) * c.rate[k]
         + (3 * x ** 2 - 2 * x) * c.rate[k + 1])
    return s, v


def drawn(random, n, end):
    """Any course: neither slip nor rate is monotone, and the cubics overshoot."""
    t = np.linspace(0, end, n + 1)
    t[1:-1] += (random.random(n - 1) - 0.5) * 0.5 * end / n
    s = np.append(0, np.cumsum(random.random(n)) + 0.3 * random.standard_normal(n))
    s[-1] = abs(s[-1]) + 0.5
    return Course(t, s, np.append(0, 3 * random.standard_normal(n)), random.random(6), 0.5 + random.random(6))


class ClosedForms(unittest.TestCase):
    def test_same(self):
        """The same cubic on other steps has no error but rounding."""
        found = course.errors(cubic([0, 0.3, 1]), cubic(np.linspace(0, 1, 41)))
        for part in course.PARTS:
            self.assertLess(found[part], 1e-13, part)  # tens of operations of numbers around 1
        self.assertEqual({name: fn(found) < 1e-13 for name, fn in course.MEASURES.items()},
                         dict.fromkeys(course.MEASURES, True))

    def test_factor(self):
        """1.1 s: 10 % in all but the time of the event."""
        found = course.errors(cubic([0, 0.2, 0.9, 1], 1.1), cubic([0, 0.5, 1]))
        for part in ("slip_error", "final", "history", "peak", "field"):
            self.assertAlmostEqual(found[part], 0.1, places=12, msg=part)
        self.assertAlmostEqual(found["shift"], 0, places=12)
        self.assertAlmostEqual(course.errors(cubic([0, 1], 0.9), cubic([0, 1]))["slip_error"], -0.1, places=12)

    def test_extremum_between(self):
        """Of the straight line t against t^2 (3 - 2 t) the largest difference is sqrt(3)/18, where 6 t (1 - t) = 1, and
        no step of either run ends there."""
        line = Course(np.array([0, 1.0]), np.array([0, 1.0]), np.ones(2), np.ones(1), np.ones(1))
        found = course.errors(line, cubic([0, 0.4, 1]))
        self.assertAlmostEqual(found["history"], np.sqrt(3) / 18, places=13)
        self.assertAlmostEqual(found["peak"], 1 / 3, places=13)  # 1 against 6/4

    def test_passages(self):
        """t^2 (3 - 2 t) = 1/2 at 1/2; = 0.1 and 0.9 at 1/2 -+ sin(asin(0.8)/3), the cubic's roots in trigonometric
        form."""
        c = cubic([0, 0.37, 1])
        off = np.sin(np.arcsin(0.8) / 3)
        for share, expected in ((0, 0), (0.1, 0.5 - off), (0.5, 0.5), (0.9, 0.5 + off), (1, 1)):
            # flat at its end
            self.assertAlmostEqual(course.passage(c, share), expected, places=7 if share == 1 else 13)
        late = Course(c.time + 0.0, np.where(c.time > 0.5, c.slip, 0), c.rate * (c.time > 0.5), c.field, c.area)
        found = course.errors(late, c)
        self.assertAlmostEqual(found["shift"], abs(course.passage(late, 0.5) - 0.5) / (2 * off), places=12)

    def test_overshoot(self):
        """A course that passes half of its final slip, comes back and passes it again: the first time counts."""
        c = Course(np.array([0, 1.0, 2, 3]), np.array([0, 0.8, 0.2, 1]), np.zeros(4), np.ones(1), np.ones(1))
        # 0.8 x^2 (3 - 2 x) = 0.5: x = 1/2 - sin(asin(1 - 2 * 0.625)/3)
        self.assertAlmostEqual(course.passage(c, 0.5), 0.5 - np.sin(np.arcsin(-0.25) / 3), places=13)

    def test_field(self):
        a, b = cubic([0, 1]), cubic([0, 1])
        a.field, b.field, a.area = np.array([1, 2.0]), np.array([2, 2.0]), np.array([1, 3.0])
        self.assertAlmostEqual(course.errors(a, b)["field"], np.sqrt(1 / 16))

    def test_measures(self):
        e = {"final": 0.1, "history": 0.2, "shift": 0.3, "peak": 2.0, "field": 0.15}
        self.assertEqual([course.MEASURES[m](e) for m in ("history", "final_slip", "event_time")], [0.4, 0.1, 0.3])
        for part, rest in (("final", 0), ("history", 0), ("shift", 0), ("field", 0)):
            self.assertEqual(course.MEASURES["history"]({**dict.fromkeys(course.PARTS, rest), part: 0.7}), 0.7)

    def test_other_end(self):
        with self.assertRaisesRegex(course.CourseError, "0.9 s .* 1 s"):
            course.errors(cubic([0, 0.9]), cubic([0, 1]))


class Sampled(unittest.TestCase):
    def test_drawn(self):
        """Against 400,000 samples, dt = 5e-6 apart. On steps h >= 0.1 the second derivatives of slip and rate are below
        12/h^2 + 12/h and 24/h^3 + 36/h^2, so that the sample next to an extremum misses it by less than dt^2/2 times
        that, 2e-8 and 4e-7; a passage is off by dt at most, and slips and rates are of order 1."""
        random = np.random.default_rng(3)
        t = np.linspace(0, 2, 400001)
        for _ in range(20):
            a, b = drawn(random, 5, 2.0), drawn(random, 9, 2.0)
            (s, v), (s_ref, v_ref) = hermite_by_basis(a, t), hermite_by_basis(b, t)
            found, last = course.errors(a, b), b.slip[-1]
            first = lambda slip, share: t[np.argmax(slip >= share * slip[-1])]
            self.assertAlmostEqual(found["history"], np.abs(s - s_ref).max() / last, delta=1e-6)
            self.assertAlmostEqual(found["peak"], abs(v.max() / v_ref.max() - 1), delta=1e-5)
            rise = first(s_ref, 0.9) - first(s_ref, 0.1)
            shift = abs(first(s, 0.5) - first(s_ref, 0.5)) / rise
            self.assertAlmostEqual(found["shift"], shift, delta=1e-5 * (1 + shift) / rise)


class Files(scripts.ScriptTest):
    def run_fault(self, name, *options):
        path = self.path(name)
        done = subprocess.run([os.path.join(os.environ["SLIPSTEP_BUILD"], "bin", "fault"), "-fault_output", path,
                               *options], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return path

    def test_grid(self):
        """Half the step, a quarter of the error: all parts are of the integrator's order 2."""
        options = ["-fault_nx", "3", "-fault_nz", "2", "-ts_max_time", "15", "-ts_adapt_type", "none",
                   "-ts_bathe_error", "none", "-fault_output_interval", "100000"]
        reference, coarse, fine = (course.read(self.run_fault(f"{n}.h5", *options, "-ts_dt", f"{15 / n:.17g}"))
                                   for n in (4800, 150, 300))
        with h5py.File(self.path("150.h5")) as file:
            self.assertEqual(coarse.slip[-1], file["result"].attrs["mean_slip"])
            self.assertEqual(len(coarse.time), 151)
        self.assertEqual(len(coarse.field), 6)
        self.assertAlmostEqual(coarse.field.mean(), coarse.slip[-1])
        a, b = course.errors(coarse, reference), course.errors(fine, reference)
        for part in ("history", "shift"):
            # between 3 and 5: cells that stop and start within a step add terms that are not regular
            self.assertTrue(3 < a[part] / b[part] < 5, f"{part}: {a[part]:.2e}, {b[part]:.2e}")
        self.assertLess(max(b[p] for p in course.PARTS), 0.05)

    def test_mesh(self):
        """Areas of irregular cells, of each component where slip is a vector."""
        self.hdf5("mesh.h5", cells=np.array([[0, 0, 500, 1000, 1000], [1500, 0, 500, 2000, 1000.0]]))
        c = course.read(self.run_fault("run.h5", "-fault_mesh", self.path("mesh.h5"), "-ts_max_time", "5"))
        self.assertEqual(c.area.tolist(), [1e6, 2e6])
        c = course.read(self.run_fault("run.h5", "-fault_mesh", self.path("mesh.h5"), "-fault_slip_components", "2",
                                       "-ts_max_time", "5"))
        self.assertEqual(c.area.tolist(), [1e6, 1e6, 2e6, 2e6])
        self.assertEqual(len(c.field), 4)

    def test_no_final_field(self):
        path = self.run_fault("run.h5", "-fault_nx", "1", "-fault_nz", "1", "-ts_max_time", "5")
        with h5py.File(path, "a") as file:
            file["fields/time"][-1] = 1.0
        with self.assertRaisesRegex(course.CourseError, "run.h5"):
            course.read(path)


if __name__ == "__main__":
    sys.exit(unittest.main())
