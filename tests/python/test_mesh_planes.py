"""Meshes of planes of any strike and dip: what a run on them is, and which are refused, by the one error that each must
give."""

import os
import subprocess
import sys
import unittest

from scripts import FAULT, SOURCE, FaultTest

import h5py
import numpy as np

COLUMNS = "x y z length width strike dip"
# rate-and-state thrusting under load, which knows normal stress that follows slip
THRUST = ("-fault_friction_law", "rate_and_state", "-fault_normal_stress", "50e6", "-fault_normal_stress_gradient", "0",
          "-fault_rake", "90", "-fault_loading_rate", "1e-9", "-fault_friction_slip", "0.05", "-ts_max_time", "1e7")


def plane(strike, dip, corner, cells=(4, 3), size=(500.0, 400.0)):
    """Rows [n, 7] of a plane from its upper corner where the strike begins, along the strike first."""
    a, d = np.radians(strike), np.radians(dip)
    along = np.array([np.cos(a), np.sin(a), 0])
    down = np.array([-np.sin(a) * np.cos(d), np.cos(a) * np.cos(d), np.sin(d)])
    i, j = (k.ravel() for k in np.meshgrid(np.arange(cells[0]) + 0.5, np.arange(cells[1]) + 0.5))
    centre = np.asarray(corner) + np.outer(i * size[0], along) + np.outer(j * size[1], down)
    return np.column_stack([centre, np.full((len(i), 4), [*size, strike, dip])])


def write(path, rows, columns=None, units="m", **more):
    with h5py.File(path, "w") as file:
        file["cells"] = rows
        file["cells"].attrs["columns"] = columns or COLUMNS
        file["cells"].attrs["units"] = units
        for name, data in more.items():
            file[name] = data


class Run(FaultTest):
    def test_a_dipping_list_is_the_grid(self):
        """The same cells as grid and as list, shuffled, on 1 and 2 ranks: the same steps and fields. 1e-9 of the
        largest: the stiffness differs by rounding, and steps depend on errors continuously."""
        rows = plane(0, 60, (0, 0, 1000))
        shuffle = np.random.default_rng(1).permutation(len(rows))
        write(self.path("mesh.h5"), rows[shuffle], fault=np.arange(len(rows)) // 5)
        self.fault("-fault_nx", 4, "-fault_nz", 3, "-fault_length_x", 2000, "-fault_length_z", 1200, "-fault_depth_top",
                   1000, "-fault_dip", 60, "-fault_output", "grid.h5", *THRUST)
        with h5py.File(self.path("grid.h5")) as file:
            grid = {name: file["fields"][name][()].reshape(len(file["fields/time"]), -1)
                    for name in ("slip", "slip_rate", "traction")}
            self.assertEqual((file["mesh"].attrs["strike"], file["mesh"].attrs["dip"]), (0, 60))
            np.testing.assert_allclose(file["mesh/down_dip"], [200, 600, 1000], rtol=1e-15)
            np.testing.assert_allclose(file["mesh/z"], 1000 + np.sin(np.radians(60)) * np.array([200, 600, 1000]),
                                       rtol=1e-14)
        for ranks in (1, 2):
            self.fault("-fault_mesh", "mesh.h5", "-fault_output", f"{ranks}.h5", "-fault_thickness", 2000, *THRUST,
                       ranks=ranks)
            with h5py.File(self.path(f"{ranks}.h5")) as file:
                for name, expected in grid.items():
                    got = np.empty_like(expected)
                    got[:, shuffle] = file["fields"][name][()]
                    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-9 * np.abs(expected).max(), err_msg=name)
                for k, name in enumerate(COLUMNS.split()):
                    np.testing.assert_array_equal(file["mesh"][name], rows[shuffle, k])
                np.testing.assert_array_equal(file["mesh/fault"], np.arange(len(rows)) // 5)
                corners = file["xdmf/points"][()][file["xdmf/cells"][()]]
                np.testing.assert_allclose(corners.mean(axis=1) * (1, 1, -1), rows[shuffle, :3], atol=1e-9)

    def test_a_vertical_list_keeps_its_bits(self):
        """[N, 7] of strike 0 and dip 90 is [N, 5]."""
        rows = np.concatenate([plane(0, 90, (0, y, 0)) for y in (0, 700)])
        write(self.path("7.h5"), rows)
        write(self.path("5.h5"), rows[:, :5], "x y z length width")
        for name in ("5", "7"):
            self.fault("-fault_mesh", f"{name}.h5", "-fault_output", f"out{name}.h5", "-ts_max_time", 5,
                       "-fault_stiffness_scaling", "mean_slip")
        with h5py.File(self.path("out5.h5")) as five, h5py.File(self.path("out7.h5")) as seven:
            self.assertEqual(sorted(five["mesh"]), sorted(seven["mesh"]))
            for group in ("mesh", "fields", "series"):
                for name in five[group]:
                    np.testing.assert_array_equal(five[group][name], seven[group][name])

    def test_rakes_of_cells(self):
        """A field of rakes turns with the frame: thrusting and left-lateral cells on a plane have the slip of the same
        plane elsewhere.
        1e-9: coordinates of 1e5 m round, and steps depend on errors continuously."""
        rake = np.where(np.arange(12) % 3 == 0, 90.0, 30.0)
        self.hdf5("fields.h5", rake=rake)
        slip = []
        for strike, corner in ((0, (0, 0, 500)), (125, (8e4, -1e5, 500))):
            write(self.path("mesh.h5"), plane(strike, 40, corner))
            self.fault("-fault_mesh", "mesh.h5", "-fault_parameters", "fields.h5", "-fault_output", f"{strike}.h5",
                       *THRUST)
            with h5py.File(self.path(f"{strike}.h5")) as file:
                np.testing.assert_array_equal(file["mesh/rake"], rake)
                slip.append(file["fields/slip"][-1])
        np.testing.assert_allclose(slip[1], slip[0], rtol=1e-9)
        self.assertGreater(np.ptp(slip[0]), 1e-3 * slip[0].max())

    def test_faults_are_plotted(self):
        """A panel for each fault, whose cells lie along its strike and down its dip; the catalogue's pictures go by it
        too."""
        rows = np.concatenate([plane(60, 45, (0, 0, 500)), plane(60, 30, (5000, 0, 500))])
        write(self.path("mesh.h5"), rows, fault=np.repeat([4, 2], 12))
        self.fault("-fault_mesh", "mesh.h5", "-fault_output", "run.h5", "-fault_catalogue", "events.h5", *THRUST)
        from slipstep.plots.maps import planes_of
        from slipstep import Run
        planes = planes_of(Run(self.path("run.h5")))
        self.assertEqual([p.name for p in planes], ["fault 2 (strike 60°, dip 30°)", "fault 4 (strike 60°, dip 45°)"])
        np.testing.assert_array_equal(planes[1].cells, np.arange(12))
        first = planes[1]  # four cells of 500 m along the strike, and three of 400 m that dip with 45 degrees
        np.testing.assert_allclose((first.x.min(), first.x.max()), (0, 2), atol=1e-12)
        np.testing.assert_allclose((first.z.min(), first.z.max()), (0, 1.2), atol=1e-12)
        np.testing.assert_allclose(first.centre(0), (0.25, 0.2), rtol=1e-12)
        self.assertIsNone(first.centre(12))
        done = self.script("plot-run", self.path("run.h5"), "--figure", self.path("run.png"))
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_an_injection_is_on_the_plane(self):
        """x along the strike and the depth are a point of one plane, and its pressure is that of x, y, z of two planes
        of which it is one."""
        rows = plane(30, 50, (100, 200, 600))
        i = 5
        point = rows[i, :3]
        along = point[0] * np.cos(np.radians(30)) + point[1] * np.sin(np.radians(30))
        source = ("-fault_injection_pressure", "1e5", "-fault_injection_diffusivity", "1", "-ts_max_time", "1e5")
        write(self.path("one.h5"), rows)
        write(self.path("two.h5"), np.concatenate([rows, plane(30, 50, (5100, 9200, 600))]))
        pressure = []
        for mesh, at in (("one", f"{float(along)!r},{float(point[2])!r}"),
                         ("two", ",".join(repr(float(x)) for x in point))):
            self.fault("-fault_mesh", f"{mesh}.h5", *THRUST, *source, "-fault_injection", at, "-fault_output",
                       f"out_{mesh}.h5", "-fault_output_fields", "slip,pore_pressure")
            with h5py.File(self.path(f"out_{mesh}.h5")) as file:
                self.assertAlmostEqual(file["fields/time"][-1] / 1e5, 1)
                pressure.append(file["fields/pore_pressure"][-1][:12])
        np.testing.assert_allclose(pressure[0], pressure[1], rtol=1e-9)
        self.assertEqual(pressure[0].argmax(), i)


BASE = plane(20, 60, (0, 0, 100))


def edited(row, column, value):
    rows = BASE.copy()
    rows[row, column] = value
    return rows


def beside(*others):
    return np.concatenate([BASE, *others])


def through(share, strike=110.0, dip=90.0):
    """Besides BASE a cell whose centre is that of row 5, moved down its own dip by this share of its width"""
    a, d = np.radians(strike), np.radians(dip)
    down = np.array([-np.sin(a) * np.cos(d), np.cos(a) * np.cos(d), np.sin(d)])
    return beside([[*(BASE[5, :3] + share * 300 * down), 300, 300, strike, dip]])


VERTICAL = plane(0, 90, (0, 0, 0))
LABELS = np.zeros(len(BASE), int)
# What is wrong, what is written, and what the error must say besides the name of the file.
BAD = {
    "six columns": (dict(rows=BASE[:, :6]), "has shape [12, 6]"),
    "eight columns": (dict(rows=np.hstack([BASE, BASE[:, :1]])), "has shape [12, 8]"),
    "one dimension": (dict(rows=BASE[0]), "has shape [7]"),
    "no rows": (dict(rows=BASE[:0]), "has no rows"),
    "text": (dict(rows=np.array([[b"a"] * 7])), "does not hold numbers"),
    "columns in another order": (dict(rows=BASE, columns="x y z length width dip strike"),
                                 'the columns of /cells are "x y z length width dip strike"'),
    "five names for seven columns": (dict(rows=BASE, columns="x y z length width"),
                                     'expected "x y z length width strike dip"'),
    "seven names for five columns": (dict(rows=BASE[:, :5], columns=COLUMNS), 'expected "x y z length width"'),
    "kilometres that are not said": (dict(rows=BASE * np.array([1e-3] * 5 + [1, 1]), units=None),
                                     "may be one of metres or one of kilometres"),
    "kilometres that are said": (dict(rows=BASE, units="km"), 'has the units "km"'),
    "a strike of 400": (dict(rows=edited(3, 5, 400)), "row 3 has strike = 400 degrees"),
    "no strike": (dict(rows=edited(3, 5, np.nan)), "row 3 has strike = nan degrees"),
    "a dip of 0": (dict(rows=edited(3, 6, 0)), "row 3 has dip = 0 degrees"),
    "a dip of 120": (dict(rows=edited(3, 6, 120)), "row 3 has dip = 120 degrees"),
    "a dip of -60": (dict(rows=edited(3, 6, -60)), "row 3 has dip = -60 degrees"),
    "no dip": (dict(rows=edited(11, 6, np.nan)), "row 11 has dip = nan degrees"),
    "no depth": (dict(rows=edited(0, 2, np.nan)), "row 0 has z = nan m"),
    "an infinite length": (dict(rows=edited(0, 3, np.inf)), "row 0 of /cells has length = inf"),
    "a width of 0": (dict(rows=edited(7, 4, 0)), "row 7 has width = 0 m"),
    "too far": (dict(rows=edited(2, 1, 5e7)), "row 2 of /cells has y = 5e+07"),
    "above the ground": (dict(rows=plane(20, 60, (0, 0, -1))), "the cell of row 0 reaches above the surface"),
    "above the ground by its dip": (dict(rows=beside([[0, 5000, 100, 300, 240, 0, 70]])),
                                    "the cell of row 12 reaches above the surface"),
    "on the ground": (dict(rows=beside([[0, 5000, 0.21, 300, 240, 0, 0.1]])),
                      "row 12 lies on the ground, with its lowest point 0.419"),
    "twice": (dict(rows=beside(BASE[4:5])), "the cells of rows 4 and 12 overlap"),
    "overlap along the strike": (
        dict(rows=beside(plane(20, 60, (1990 * np.cos(np.radians(20)), 1990 * np.sin(np.radians(20)), 100), (1, 1)))),
        "the cells of rows 3 and 12 overlap"),
    "the other strike of one vertical plane": (dict(
        rows=np.concatenate([VERTICAL, [[300, 0, 300, 100, 100, 180, 90]]])), "the cells of rows 0 and 12 overlap"),
    "crossing at a right angle": (dict(rows=through(0)), "the cells of rows 5 and 12 cross: planes that cross must be "
                                  "cut at their line of intersection"),
    "crossing at a small angle": (dict(rows=through(0, 20, 61)), "the cells of rows 5 and 12 cross"),
    "crossing at an edge": (dict(rows=through(0.45, 20, 30)), "the cells of rows 5 and 12 cross"),
    "labels of other cells": (dict(rows=BASE, fault=LABELS[1:]),
                              "/fault in mesh.h5 has shape [11]"),
    "labels of two dimensions": (dict(rows=BASE, fault=LABELS[:, None]), "1 dimension"),
    "labels that are not whole": (dict(rows=BASE, fault=LABELS + 0.5),
                                  "row 0 of /fault is 0.5"),
    "no label": (dict(rows=BASE, fault=np.where(LABELS + np.arange(12) == 8, np.nan, 1)), "row 8 of /fault is nan"),
    "labels in words": (dict(rows=BASE, fault=np.array([b"north"] * 12)), "/fault in mesh.h5 does not hold numbers"),
    "another dataset": (dict(rows=BASE, faults=LABELS), "holds /faults, which nothing reads"),
}
# Rakes of -fault_parameters
RAKES = {"a rake of 400": (np.where(np.arange(12) == 3, 400.0, 90), "is 400"),
         "no rake": (np.where(np.arange(12) == 3, np.nan, 90), "is nan"),
         "rakes of other cells": (np.zeros(11), "/rake in fields.h5 has shape [11]"),}
GOOD = {"a listric fault": np.concatenate([plane(20, 60, (0, 0, 100)),
                                           plane(20, 30, np.array([0, 0, 100]) + 1200
                                                 * np.array([-np.sin(np.radians(20)) * 0.5,
                                                             np.cos(np.radians(20)) * 0.5, np.sqrt(0.75)]))]),
        "a splay whose edge is inside of a cell": through(-0.5, 20, 90),
        "a branch whose edge is inside of a cell": through(0.5, 20, 30),
        "segments of a bend": np.concatenate([plane(0, 90, (0, 0, 0)), plane(35, 90, (2000, 0, 0))]),
        "four planes that meet in a line": np.concatenate([plane(strike, dip, (0, 0, 1000), (2, 2)) for strike,
                                                           dip in ((0, 90), (180, 30), (0, 30), (0, 60))]),
        "planes cut where they cross": np.concatenate([plane(0, 90, (-1000, 0, 0), (4, 4)),
                                                       plane(90, 90, (0, 0, 0), (2, 4)),
                                                       plane(90, 90, (0, -1000, 0), (2, 4))]),
        "parallel planes a metre apart": np.concatenate([BASE, BASE + [0, 1.0, 0, 0, 0, 0, 0]]),
        "cells of other sizes beside each other": np.concatenate([plane(20, 60, (0, 0, 100), (1, 1), (600.0, 300.0)),
                                                                  plane(20, 60, np.array([np.cos(np.radians(20)),
                                                                                          np.sin(np.radians(20)), 0])
                                                                        * 600 + [0, 0, 100], (3, 3), (70.0, 100.0))]),}


class Input(FaultTest):
    def run_of(self, rows, columns=None, units="m", options=(), **more):
        with h5py.File(self.path("mesh.h5"), "w") as file:
            file["cells"] = rows
            five = getattr(rows, "ndim", 2) == 2 and rows.shape[1] == 5
            file["cells"].attrs["columns"] = columns or (COLUMNS[:-11] if five else COLUMNS)
            if units is not None:
                file["cells"].attrs["units"] = units
            for name, data in more.items():
                file[name] = data
        return subprocess.run([FAULT, "-fault_mesh", "mesh.h5", *THRUST, "-ts_max_steps", "1", *options],
                              cwd=self.folder.name, capture_output=True, text=True)

    def refused(self, done, message):
        self.assertNotEqual(done.returncode, 0)
        errors = [line for line in done.stderr.splitlines() if line]
        self.assertEqual(len(errors), 1, done.stderr)
        self.assertTrue(errors[0].startswith("fault: error: "), errors[0])
        self.assertIn(message, errors[0])
        return errors[0]

    def test_bad_meshes(self):
        for name, (what, message) in BAD.items():
            with self.subTest(name):
                error = self.refused(self.run_of(**what), message)
                self.assertIn("-fault_mesh", error)
                self.assertIn("mesh.h5", error)

    def test_bad_rakes(self):
        for name, (rake, message) in RAKES.items():
            with self.subTest(name), h5py.File(self.path("fields.h5"), "w") as file:
                file["rake"] = rake
                file.close()
                self.assertIn("-fault_parameters",
                              self.refused(self.run_of(BASE, options=("-fault_parameters", "fields.h5")), message))

    def test_good_meshes(self):
        """A step is taken, so the operators were made as well."""
        for name, rows in GOOD.items():
            with self.subTest(name):
                done = self.run_of(rows)
                self.assertIn("accepted steps:          1", done.stdout, done.stderr)
                turned = rows.copy()
                a = np.radians(77)
                turned[:, 0], turned[:, 1] = (np.cos(a) * rows[:, 0] - np.sin(a) * rows[:, 1] + 3e5,
                                              np.sin(a) * rows[:, 0] + np.cos(a) * rows[:, 1] - 4e5)
                turned[:, 5] = rows[:, 5] + 77
                self.assertIn("accepted steps:          1", self.run_of(turned).stdout, "turned and moved")


class Generator(FaultTest):
    """Meshes of examples/make_mesh.py: their shape, and that runs take them."""

    def make(self, *arguments, code=0):
        done = subprocess.run([sys.executable, os.path.join(SOURCE, "examples/make_mesh.py"), self.path("mesh.h5"),
                               *arguments], capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stderr)
        if code:
            return done.stderr
        with h5py.File(self.path("mesh.h5")) as file:
            self.assertEqual(file["cells"].attrs["columns"], COLUMNS)
            return file["cells"][()], file["fault"][()]

    def accepted(self):
        self.fault("-fault_mesh", "mesh.h5", *THRUST, "-ts_max_time", 1, "-fault_operator", "hmat")

    def test_dipping(self):
        rows, label = self.make("dipping", "--cells", "4", "3", "--size", "2000", "1200", "--top", "1000", "--strike",
                                "30", "--dip", "60")
        # rounding of coordinates of some 1e3 m
        np.testing.assert_allclose(rows, plane(30, 60, (0, 0, 1000)), atol=1e-9)
        self.assertEqual(set(label), {0})
        self.accepted()

    def test_graded(self):
        rows, _ = self.make("dipping", "--cells", "10", "8", "--size", "5000", "3000", "--strike", "200", "--dip", "35",
                            "--ratio", "3")
        self.assertAlmostEqual((rows[:, 3] * rows[:, 4]).sum(), 5000 * 3000, delta=1e-6)
        self.assertAlmostEqual(rows[:, 4].max() / rows[:, 4].min(), 3)
        self.accepted()

    def test_listric(self):
        rows, label = self.make("listric", "--cells", "12", "20", "--size", "6000", "8000", "--strike", "-40", "--dip",
                                "70", "--dip-bottom", "15")
        self.assertAlmostEqual((rows[:, 3] * rows[:, 4]).sum(), 6000 * 8000, delta=1e-6)
        dips = rows[::12, 6]
        np.testing.assert_allclose(np.diff(dips), (15 - 70) / 20)
        self.assertAlmostEqual(dips[0], 70 - 55 / 40)
        sine = np.sin(np.radians(rows[:, 6]))
        # each row begins where one ends
        np.testing.assert_allclose((rows[:, 2] + rows[:, 4] / 2 * sine)[:-12],
                                   (rows[:, 2] - rows[:, 4] / 2 * sine)[12:])
        self.assertEqual(set(label), {0})
        self.accepted()

    def test_segmented(self):
        for dip, most in (("90", 0), ("50", 0.05), ("25", 0.12)):
            with self.subTest(dip):
                rows, label = self.make("segmented", "--cells", "8", "10", "--size", "4000", "3000", "--strikes", "0",
                                        "30", "-15", "--dip", dip)
                self.assertEqual(len(rows), 3 * 80)
                np.testing.assert_array_equal(label, np.repeat([0, 1, 2], 80))
                # what is missing are triangles at bends: halves of what a row's bend changes by along the way down
                missing = 1 - (rows[:, 3] * rows[:, 4]).sum() / (3 * 4000 * 3000)
                self.assertLessEqual(abs(missing), most + 1e-12)
                self.accepted()

    def test_bad_options(self):
        for arguments, message in ((("uniform", "--dip", "60"),
                                    "--dip is of dipping, listric, segmented meshes, not of a uniform one"),
                                   (("dipping", "--dip", "0"), "--dip and --dip-bottom must be above 0 and at most 90"),
                                   (("listric", "--dip-bottom", "95"),
                                    "--dip and --dip-bottom must be above 0 and at most 90"),
                                   (("dipping", "--strikes", "0", "10"), "--strikes is of segmented meshes"),
                                   (("segmented", "--strikes", "0", "100"), "must turn by less than 90 degrees"),
                                   (("dipping", "--strike", "400"), "must be from -360 to 360")):
            self.assertIn(message, self.make(*arguments, code=2))
        self.assertIn("lower edge",
                      self.make("segmented", "--size", "500", "9000", "--strikes", "0", "60", "--dip", "30", code=1))


if __name__ == "__main__":
    unittest.main()
