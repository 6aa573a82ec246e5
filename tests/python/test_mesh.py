"""The mesh generator, and the output file of a run on its meshes."""

import os
import re
import unittest

from scripts import FaultTest, PictureTest

import h5py
import numpy as np

from slipstep import Run

# the study's scaling of the stiffness, by which these faults break all over
SCALED = ("-fault_mesh", "mesh.h5", "-fault_stiffness_scaling", "mean_slip")


class Mesh(FaultTest, PictureTest):
    def make(self, words):
        self.make_mesh("mesh.h5", words)
        self.assertEqual(self.get("mesh.h5", "cells@columns"), "x y z length width")
        return self.get("mesh.h5", "cells")

    def test_cells_fill_the_planes(self):
        for kind, planes, ratio in (("uniform", 1, 1), ("graded", 1, 5), ("parallel", 2, 3)):
            rows = self.make(f"{kind} --cells 8 5 --size 2000 1500 --top 100 --ratio {ratio}")
            self.assertEqual(rows.shape, (40 * planes, 5))
            self.assertAlmostEqual((rows[:, 3] * rows[:, 4]).sum(), 2000 * 1500 * planes, delta=1e-3)
            self.assertAlmostEqual((rows[:, 2] - rows[:, 4] / 2).min(), 100)
            self.assertAlmostEqual(rows[:, 4].max() / rows[:, 4].min(), ratio)

    def test_output_holds_cells_and_area_means(self):
        rows = self.make("parallel --cells 6 5 --ratio 3 --offset 800 --shift 200")
        self.fault(*SCALED, "-fault_output", "run.h5", "-ts_max_time", 8)
        with h5py.File(self.path("run.h5")) as file:
            for k, name in enumerate(("x", "y", "z", "length", "width")):
                np.testing.assert_array_equal(file["mesh"][name][()], rows[:, k])
            slip, traction = file["fields/slip"][()], file["fields/traction"][()]
            self.assertEqual(slip.shape, (len(file["fields/time"]), 60))
            area = rows[:, 3] * rows[:, 4]
            mean = (slip[-1] * area).sum() / area.sum()
            # the same sums in another order
            self.assertAlmostEqual(mean / file["result"].attrs["mean_slip"], 1, delta=1e-12)
            self.assertGreater(mean, 0.01)
            # tractions are per unit area: they are bounded by the strength at the start, 0.6 sigma_n
            sigma = file["mesh/normal_stress"][()]
            np.testing.assert_allclose(sigma, 15e3 * rows[:, 2], rtol=1e-12)
            ratio = np.abs(traction) / (0.6 * sigma)
            self.assertLessEqual(ratio.max(), 1 + 1e-9)
            self.assertGreater(ratio.max(axis=0).min(), 0.8)

    def test_planes_are_plotted(self):
        rows = self.make("parallel --cells 5 4 --offset 800 --shift 200")
        self.fault(*SCALED, "-fault_output", "run.h5", "-ts_max_time", 8)
        planes = Run(self.path("run.h5")).planes
        self.assertEqual([y for y, _ in planes], [0, 800])
        np.testing.assert_array_equal(np.concatenate([cells for _, cells in planes]), np.arange(len(rows)))
        self.plot("plot_run", self.path("run.h5"), "--figure", self.path("run.png"))
        self.look(self.path("run.png"))

    def run_on(self, ranks, *arguments):
        output, view = f"run{ranks}.h5", self.path(f"k{ranks}.bin")
        self.fault(*SCALED, "-fault_output", output, "-fault_stiffness_view", f"binary:{view}", "-ts_max_time", 6,
                   "-ts_adapt_type", "heuristic", "-ts_rtol", 1e-3, *arguments, ranks=ranks)
        names = ("fields/slip", "fields/slip_rate", "fields/traction", "mesh/normal_stress", "mesh/x", "steps/dt")
        fields = dict(zip(names, self.get(output, *names)))
        n = len(fields["mesh/x"])
        # PETSc's integers, of 4 or 8 bytes: four, the length of each row, a column for each entry
        integer = 4 if os.path.getsize(view) == 4 * (4 + n + n * n) + 8 * n * n else 8
        fields["stiffness"] = np.fromfile(view, ">f8", offset=integer * (4 + n + n * n)).reshape(n, n)
        return fields

    def test_ranks_keep_the_order_of_the_file(self):
        """Shares of the cells go to ranks; fields, parameters and the stiffness stay in the order of the file."""
        rows = self.make("parallel --cells 9 8 --ratio 3 --offset 600 --shift 300")
        rows = rows[np.random.default_rng(3).permutation(len(rows))]
        with h5py.File(self.path("mesh.h5"), "r+") as file:
            file["cells"][...] = rows
        self.hdf5("stress.h5", normal_stress=1e6 + 15e3 * rows[:, 2] + 1e3 * np.arange(len(rows)))
        for operator in ("dense", "hmat"):
            one, two = (self.run_on(ranks, "-fault_parameters", "stress.h5", "-fault_operator", operator)
                        for ranks in (1, 2))
            np.testing.assert_array_equal(two["mesh/x"], rows[:, 0])
            for name in one:
                # 1e-9, relative to the largest: rounding alone differs, and steps depend on errors continuously
                np.testing.assert_allclose(two[name], one[name], rtol=0, atol=1e-9 * np.abs(one[name]).max(),
                                           err_msg=name)
            self.assertGreater(one["fields/slip"][-1].min(), 1e-3)

    def test_plan(self):
        """What is planned, without a run, is what the stiffness on one rank takes: memory within a quarter. Shares of
        two ranks are halves, and both exchange cells."""
        self.make("graded --cells 24 20 --size 3000 3000")
        hmat = ("-fault_mesh", "mesh.h5", "-fault_operator", "hmat")
        lines = self.fault(*hmat, "-fault_plan", "1,2").splitlines()
        one, two = ([float(word) for word in line.split()] for line in lines[-2:])
        view = self.fault(*hmat, "-fault_view", "-ts_max_time", 0.1)
        memory = float(re.search(r"memory: ([0-9.]+) MB", view).group(1))
        self.assertAlmostEqual(one[1] / memory, 1, delta=0.25)
        self.assertAlmostEqual(two[1] / one[1], 0.5, delta=0.1)  # printed to 0.1 MB, of 0.7
        self.assertEqual(one[4], 0)
        self.assertGreater(two[4], 0)
        # before assembly -fault_view has a row for each rank, with the memory of the plan
        view = self.fault(*hmat, "-fault_view", "-ts_max_time", 0.1, ranks=2)
        rows = re.findall(r"^ +K +(\d) +(\d+) +\d+ +([0-9.]+) ", view, re.MULTILINE)
        self.assertEqual([int(row[0]) for row in rows], [0, 1])
        self.assertEqual(sum(int(row[1]) for row in rows), 480)
        self.assertAlmostEqual(max(float(row[2]) for row in rows), two[2], delta=0.06)
        self.assertLess(view.index("before assembly"), view.index("memory: "))
        for wrong in (0, 481):
            self.assertIn("-fault_plan", self.fault(*hmat, "-fault_plan", wrong, code=1))
        self.assertIn("-fault_mesh", self.fault("-fault_plan", 2, code=1))


if __name__ == "__main__":
    unittest.main()
