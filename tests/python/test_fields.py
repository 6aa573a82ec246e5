"""Parameters as functions of cells (slipstep.fields): where cells are against sums of one's own, points against
functions that their interpolation holds, random fields against von Karman's correlation, and runs by the program and in
this process against files of -fault_parameters."""

import os
import subprocess
import sys
import unittest
import warnings

from scripts import BUILD, FaultTest

import h5py
import meshfiles
import numpy as np
import slipstep
from slipstep import fields
from test_from_python import environment

PETSC4PY = subprocess.run([sys.executable, "-c", "import slipstep; slipstep.load()"], env=environment(),
                          capture_output=True, check=False).returncode == 0
try:
    import scipy
except ImportError:
    scipy = None


def cells_of(x, y, z):
    x, y, z = np.broadcast_arrays(*np.atleast_2d(x, y, z))
    return fields.Cells(x, y, z, np.ones_like(x), np.zeros_like(x), np.full_like(x, 90), np.zeros_like(x, dtype=int))


class Fields(FaultTest):
    def setUp(self):
        super().setUp()
        os.environ["SLIPSTEP_FAULT"] = os.path.join(BUILD, "bin", "fault")
        self.addCleanup(os.environ.pop, "SLIPSTEP_FAULT")

    def refused(self, message, function, *arguments, **more):
        with self.assertRaisesRegex(slipstep.Error, message):
            function(*arguments, **more)

    def csv(self, head, rows):
        path = self.path("points.csv")
        with open(path, "w", encoding="utf-8") as file:
            file.write("# of a test\n"
                       + "\n".join([head, *(",".join(f"{number:.17g}" for number in row) for row in rows)]) + "\n")
        return path

    # ---- where the cells are ----

    def test_dipping_grid(self):
        self.fault("-fault_nx", 5, "-fault_nz", 3, "-fault_length_x", 5e3, "-fault_length_z", 6e3, "-fault_dip", 30,
                   "-fault_strike", 120, "-fault_depth_top", 700, "-fault_cells", "cells.h5")
        c = fields.read_cells(self.path("cells.h5"))
        s, d = np.meshgrid(np.arange(500, 5000, 1000), np.arange(1000, 6000, 2000))
        strike, dip = np.radians(120), np.radians(30)
        self.assertFalse(c.mesh)
        for found, expected in ((c.x, s * np.cos(strike) - d * np.cos(dip) * np.sin(strike)),
                                (c.y, s * np.sin(strike) + d * np.cos(dip) * np.cos(strike)),
                                (c.z, 700 + d * np.sin(dip)), (c.area, 2e6 + 0 * s), (c.strike, 120 + 0 * s),
                                (c.dip, 30 + 0 * s), (c.fault, 0 * s)):
            self.assertEqual(found.shape, (3, 5))
            np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-9)

    def mesh(self):
        """Two dipping planes of triangles, of the faults 4 and 9."""
        first, second = (meshfiles.plane(cells, (500, 400), strike, dip, corner) for cells, strike, dip, corner in
                         (((4, 3), 30, 60, (0, 0, 100)), ((3, 2), 200, 45, (9e3, 0, 50))))
        vertices, triangles = meshfiles.joined(first, second)
        meshfiles.write_hdf5(self.path("mesh.h5"), vertices, triangles)
        with h5py.File(self.path("mesh.h5"), "a") as file:
            file["fault"] = np.repeat([4, 9], (len(first[1]), len(second[1])))
        return vertices[triangles], np.repeat([60, 45], (len(first[1]), len(second[1]))), np.repeat([4, 9], (
            len(first[1]), len(second[1])))

    def test_triangles_on_any_number_of_ranks(self):
        corners, dip, fault = self.mesh()
        for ranks in (1, 2):
            self.fault("-fault_mesh", "mesh.h5", "-fault_cells", f"{ranks}.h5", ranks=ranks)
            c = fields.read_cells(self.path(f"{ranks}.h5"))
            self.assertTrue(c.mesh)
            np.testing.assert_allclose(c.centres, corners.mean(axis=1), rtol=1e-12, atol=1e-9)
            np.testing.assert_allclose(c.area[0], np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2]
                                                                          - corners[:, 0]), axis=1) / 2, rtol=1e-12)
            np.testing.assert_allclose(c.dip[0], dip, rtol=1e-9)
            np.testing.assert_array_equal(c.fault[0], fault)

    def test_errors_of_the_program(self):
        self.assertIn("-fault_nx is 0", self.fault("-fault_nx", 0, "-fault_cells", "c.h5", code=1))
        self.assertFalse(os.path.exists(self.path("c.h5")))
        self.assertIn("nowhere", self.fault("-fault_cells", "nowhere/c.h5", code=1))

    # ---- functions and points ----

    def test_what_functions_return(self):
        c = cells_of([0, 1, 2], [0], [[5], [6]])
        self.assertEqual(fields.evaluate("a", lambda c: 3, c).tolist(), [[3, 3, 3], [3, 3, 3]])
        self.assertEqual(fields.evaluate("a", lambda c: (c.x + c.z).ravel(), c).tolist(), [[5, 6, 7], [6, 7, 8]])
        self.refused(r"function of a returned the shape \(3,\)", fields.evaluate, "a", lambda c: c.x[0], c)
        self.refused(r"inf in 2 of 6 cells, .*0, 0, 5 m", fields.evaluate, "a",
                     lambda c: np.where(c.x == 0, np.inf, 1), c)
        self.refused("function of a", fields.evaluate, "a", lambda c: "text", c)

    def test_profile(self):
        path = self.csv("z,friction_a,friction_b", [(4000, 0.02, 1), (0, 0.01, 2), (1000, 0.012, 3)])
        c = cells_of(0, 0, [-5, 500, 2400, 9000])
        np.testing.assert_allclose(fields.points(path, "friction_a")(c), [0.01, 0.011, 0.012 + 0.008 * 14 / 30, 0.02],
                                   rtol=1e-14)
        self.assertEqual(fields.points(path, "friction_b", method="nearest")(c).tolist(), [2, 2, 3, 1])
        self.refused("column=", fields.points, path)
        self.refused("sigma, .*friction_a, friction_b", fields.points, path, "sigma")

    @unittest.skipUnless(scipy, "no SciPy")
    def test_points_of_a_linear_function(self):
        """Linear interpolation holds linear functions, in space, on a dipping plane and on a line; outside the nearest
        point's value counts, which is found by all distances."""
        draw = np.random.default_rng(2)
        slope = np.array([2e-3, -1e-3, 5e-4])
        dip = np.array([[1, 0, 0], [0, 0.6, 0.8]])
        for places, inside in ((draw.uniform(0, 1e4, (80, 3)), draw.uniform(4e3, 6e3, (40, 3))),
                               (draw.uniform(0, 1e4, (60, 2)) @ dip + 300, draw.uniform(4e3, 6e3, (40, 2)) @ dip + 300),
                               (draw.uniform(0, 1e4, (9, 1)) @ dip[1:] + 300,
                                draw.uniform(4e3, 6e3, (40, 1)) @ dip[1:] + 300)):
            path = self.csv("x,y,z,value", np.column_stack([places, 7 + places @ slope]))
            np.testing.assert_allclose(fields.points(path)(cells_of(*inside.T)), 7 + inside @ slope, rtol=1e-9)
            far = draw.uniform(-3e4, 3e4, (50, 3))
            near = ((far[:, None] - places) ** 2).sum(axis=2).argmin(axis=1)
            if np.linalg.matrix_rank(places - places[0]) == 3:
                np.testing.assert_array_equal(fields.points(path, method="nearest")(cells_of(*far.T)),
                                              (7 + places @ slope)[near])
                far = far[(far < 0).any(axis=1)]
                near = ((far[:, None] - places) ** 2).sum(axis=2).argmin(axis=1)
                np.testing.assert_array_equal(fields.points(path)(cells_of(*far.T)), (7 + places @ slope)[near])

    @unittest.skipUnless(scipy, "no SciPy")
    def test_points_elsewhere(self):
        """Points in km or in another frame, of which no cell is among, are told; one cell among them, or cells in their
        plane but for rounding, are not."""
        x, z = np.meshgrid(np.arange(500, 6000, 1000.0), np.arange(500, 4000, 1000.0))
        grid, wide = (0, 6000), (0, 4000)
        for scale, shift, told in ((1, 0, False), (1e-3, 0, True), (1, 4e6, True), (0.2, 0, False)):
            path = self.csv("x,y,z,v", [(scale * a + shift, 0, scale * b, 1 + a) for a in grid for b in wide])
            with self.subTest(scale=scale, shift=shift), warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                fields.points(path)(cells_of(x, 1e-9, z))
                self.assertEqual([w.category for w in caught], [slipstep.SlipStepWarning] * told)
                if told:
                    self.assertRegex(str(caught[0].message), "points.csv: no cell lies among its points, which are at "
                                     "x = .* m, and cells at x = 500 to 5500, y = 1e-09 to 1e-09, z = 500 to 3500 m")

    def test_bounds_of_the_program(self):
        """What fault refuses or doubts of a field is refused or said when its file is written, and names the first such
        cell."""
        c, path = cells_of([0, 1, 2], [0], [[5], [6]]), self.path("f.h5")
        self.refused("f.h5: friction_a of cell 5 is -0.02", fields.write, path,
                     {"friction_a": lambda c: np.where((c.x == 1) & (c.z == 6), -0.02, 0.01)}, c)
        self.refused("f.h5: rake of cell 1 is 360", fields.write, path, {"rake": 360.0, "of_my_law": 3.0}, c)
        self.assertFalse(os.path.exists(path))
        with self.assertWarnsRegex(slipstep.SlipStepWarning,
                                   "f.h5: /normal_stress is at most 60 Pa: is it given in MPa"):
            fields.write(path, {"normal_stress": lambda c: 50 + 10 * (c.x == 1)}, c)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            fields.write(path, {"normal_stress": 50e6, "friction_a": 0.01, "of_my_law": 3.0}, c)

    def test_bad_points(self):
        for head, rows, message in (("a,b", [(1, 2)], "first line is a,b"),
                                    ("x,z", [(1, 2)], "at least one more"),
                                    ("x,x,v", [(1, 2, 3)], "different names"), ("x,v", [], "no points"),
                                    ("x,v", [(1, 2), (1, 3)], "1 points in places of others"),
                                    ("x,v", [(1, 2, 3)], "line 3"),
                                    ("x,v", [(1, np.nan)], "line 3")):
            with self.subTest(message):
                self.refused(message, fields.points, self.csv(head, rows))
        self.refused("cannot read .*nothing.csv", fields.points, self.path("nothing.csv"))
        self.assertRaises(ValueError, fields.points, self.csv("x,v", [(1, 2)]), method="cubic")

    # ---- random fields ----

    def test_a_seed_is_one_field(self):
        """At the same places it is the same, whatever else is there; another seed is another one."""
        field = fields.random(50e6, 0.2, 2e3, 5)
        x = np.linspace(0, 1e4, 21)
        fine, coarse = field(cells_of(x, 300, 1000)), field(cells_of(x[::2], 300, 1000))
        np.testing.assert_array_equal(fine[0, ::2], coarse[0])
        self.assertFalse(np.allclose(fine, fields.random(50e6, 0.2, 2e3, 6)(cells_of(x, 300, 1000))))
        self.assertGreaterEqual(fields.random(1, 9, 2e3, 1, least=0.3)(cells_of(x, 0, 0)).min(), 0.3)
        self.assertRaises(ValueError, fields.random, 1, 0.1, 0, 1)

    @unittest.skipUnless(scipy, "no SciPy")
    def test_von_karman(self):
        """The correlation of a field in space, along any direction, is von Karman's, 2^(1 - H)/Gamma(H) (r/a)^H
        K_H(r/a). 2000 seeds: the mean product of two numbers of variance 1 has a standard error of at most sqrt(2/2000)
        = 0.032; waves that are left out, those above 16 pi/a, hold (1 + 256 pi^2)^-H of the variance at most, 0.003, by
        which the rest is too large."""
        from scipy.special import gamma, kv
        hurst, a, seeds = 0.75, 2000.0, 2000
        r = np.array([0, 200, 1000, 2000, 4000, 8000.0])
        for direction in ([1, 0, 0], [0.6, 0, 0.8]):
            made = np.array([fields.waves(tuple(np.outer(direction, r)), a, np.random.default_rng(seed), hurst)
                             for seed in range(seeds)])
            found = (made[:, :1] * made).mean(axis=0)
            expected = np.concatenate([[1], 2 ** (1 - hurst) / gamma(hurst) * (r[1:] / a) ** hurst
                                       * kv(hurst, r[1:] / a)])
            np.testing.assert_allclose(found, expected, atol=3 * np.sqrt(2 / seeds) + 0.003)
            self.assertLess(abs(made.mean()), 4 / np.sqrt(seeds))

    # ---- runs ----

    RUN = """
import sys, numpy as np, slipstep
from slipstep import fields
mesh = dict(mesh="mesh.h5") if sys.argv[1] == "mesh" else dict(nx=6, nz=4, length_x=6e3, length_z=4e3)
fault = slipstep.Fault(**mesh, friction_law="exponential_slip_weakening", normal_stress=50e6, ts_max_time=0.3,
                       friction_drop=0.1)
fault.set("friction_drop", lambda c: 0.1 + 1e-6 * c.z + 1e-7 * c.fault)
fault.set(friction_slip=fields.random(0.1, 0.2, 2e3, 3))
x, y, z = fault.centres()
assert fault.cells().shape == x.shape and x.size == (36 if sys.argv[1] == "mesh" else 24)
fault.write_fields("fields.h5")
slip = fault.run(progress=False)["slip"][-1]
again = slipstep.Fault(**mesh, friction_law="exponential_slip_weakening", normal_stress=50e6, ts_max_time=0.3,
                       parameters="fields.h5")
assert slip.max() > 0 and np.array_equal(slip, again.run(progress=False)["slip"][-1])
fault.set("friction_drop", 0.1)        # takes the place of the function
fault.set(friction_slip=0.1)
assert not np.array_equal(slip, fault.run(progress=False)["slip"][-1])
fault.set("friction_drop", lambda c: c.z[0, :1])
try:
    fault.run(progress=False)
except slipstep.Error as error:
    assert "expected" in str(error) and "that of the cells" in str(error), error
else:
    sys.exit("no error")
np.save(sys.argv[2], slip)
"""

    def test_runs(self):
        """By the program and in this process a function gives what its file gives, on a grid and on triangles; both
        agree."""
        self.mesh()
        for kind in ("grid", "mesh"):
            found = []
            for backend in ("program", "petsc") if PETSC4PY else ("program",):
                done = subprocess.run([sys.executable, "-c", self.RUN, kind, f"{backend}.npy"], cwd=self.folder.name,
                                      env={**environment(), "SLIPSTEP_BACKEND": backend},
                                      capture_output=True, text=True, check=False)
                self.assertEqual(done.returncode, 0, f"{kind} {backend}: {done.stderr}")
                found.append(np.load(self.path(f"{backend}.npy")))
            np.testing.assert_array_equal(found[0], found[-1])


if __name__ == "__main__":
    unittest.main()
