"""The mesh generator, and the output file of a run on its meshes."""

import os
import subprocess
import sys
import unittest

from scripts import BUILD, PROGRAM, SOURCE, ScriptTest

import h5py
import numpy as np

# the study's scaling of the stiffness, by which these faults break all over
SCALED = ("-fault_stiffness_scaling", "mean_slip")


class Mesh(ScriptTest):
    def setUp(self):
        super().setUp()
        self.mesh = self.path("mesh.h5")

    def make(self, *arguments):
        subprocess.run([sys.executable, os.path.join(SOURCE, "examples/make_mesh.py"), self.mesh, *arguments],
                       check=True,
                       stdout=subprocess.DEVNULL)
        with h5py.File(self.mesh) as file:
            self.assertEqual(file["cells"].attrs["columns"], "x y z length width")
            return file["cells"][()]

    def test_cells_fill_the_planes(self):
        for kind, planes, ratio in (("uniform", 1, 1), ("graded", 1, 5), ("parallel", 2, 3)):
            rows = self.make(kind, "--cells", "8", "5", "--size", "2000", "1500", "--top", "100", "--ratio", str(ratio))
            self.assertEqual(rows.shape, (40 * planes, 5))
            self.assertAlmostEqual((rows[:, 3] * rows[:, 4]).sum(), 2000 * 1500 * planes, delta=1e-3)
            self.assertAlmostEqual((rows[:, 2] - rows[:, 4] / 2).min(), 100)
            self.assertAlmostEqual(rows[:, 4].max() / rows[:, 4].min(), ratio)

    def test_output_holds_cells_and_area_means(self):
        rows = self.make("parallel", "--cells", "6", "5", "--ratio", "3", "--offset", "800", "--shift", "200")
        output = os.path.join(self.folder.name, "run.h5")
        subprocess.run([os.path.join(BUILD, "bin/fault"), "-fault_mesh", self.mesh, "-fault_output", output, *SCALED,
                        "-ts_max_time",
                        "8"], check=True, stdout=subprocess.DEVNULL)
        with h5py.File(output) as file:
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
        rows = self.make("parallel", "--cells", "5", "4", "--offset", "800", "--shift", "200")
        output = os.path.join(self.folder.name, "run.h5")
        figure = os.path.join(self.folder.name, "run.png")
        subprocess.run([os.path.join(BUILD, "bin/fault"), "-fault_mesh", self.mesh, "-fault_output", output, *SCALED,
                        "-ts_max_time",
                        "8"], check=True, stdout=subprocess.DEVNULL)
        sys.path.insert(0, os.path.join(SOURCE, "src", "package"))
        from slipstep import Run
        planes = Run(output).planes
        self.assertEqual([y for y, _ in planes], [0, 800])
        np.testing.assert_array_equal(np.concatenate([cells for _, cells in planes]), np.arange(len(rows)))
        subprocess.run([sys.executable, PROGRAM, "plot-run", output, "--figure", figure], check=True,
                       stdout=subprocess.DEVNULL)
        self.assertGreater(os.path.getsize(figure), 10000)

    def run_on(self, ranks, *arguments):
        output = os.path.join(self.folder.name, f"run{ranks}.h5")
        view = os.path.join(self.folder.name, f"k{ranks}.bin")
        subprocess.run(["mpirun", "--oversubscribe", "-n", str(ranks), os.path.join(BUILD, "bin/fault"), "-fault_mesh",
                        self.mesh, "-fault_output", output, *SCALED, "-fault_stiffness_view", f"binary:{view}",
                        "-ts_max_time",
                        "6", "-ts_adapt_type", "heuristic", "-ts_rtol", "1e-3", *arguments], check=True,
                       stdout=subprocess.DEVNULL)
        with h5py.File(output) as file:
            fields = {name: file["fields"][name][()] for name in ("slip", "slip_rate", "traction")}
            fields["normal_stress"] = file["mesh/normal_stress"][()]
            fields["x"] = file["mesh/x"][()]
            fields["steps"] = file["steps/dt"][()]
        n = len(fields["x"])
        # PETSc's integers, of 4 or 8 bytes: four, the length of each row, a column for each entry
        integer = 4 if os.path.getsize(view) == 4 * (4 + n + n * n) + 8 * n * n else 8
        fields["stiffness"] = np.fromfile(view, ">f8", offset=integer * (4 + n + n * n)).reshape(n, n)
        return fields

    def test_ranks_keep_the_order_of_the_file(self):
        """Shares of the cells go to ranks; fields, parameters and the stiffness stay in the order of the file."""
        rows = self.make("parallel", "--cells", "9", "8", "--ratio", "3", "--offset", "600", "--shift", "300")
        rows = rows[np.random.default_rng(3).permutation(len(rows))]
        with h5py.File(self.mesh, "r+") as file:
            file["cells"][...] = rows
        stress = os.path.join(self.folder.name, "stress.h5")
        with h5py.File(stress, "w") as file:
            file["normal_stress"] = 1e6 + 15e3 * rows[:, 2] + 1e3 * np.arange(len(rows))
        for operator in ("dense", "hmat"):
            one, two = (self.run_on(ranks, "-fault_parameters", stress, "-fault_operator", operator)
                        for ranks in (1, 2))
            np.testing.assert_array_equal(two["x"], rows[:, 0])
            for name in one:
                # 1e-9, relative to the largest: rounding alone differs, and steps depend on errors continuously
                np.testing.assert_allclose(two[name], one[name], rtol=0, atol=1e-9 * np.abs(one[name]).max(),
                                           err_msg=name)
            self.assertGreater(one["slip"][-1].min(), 1e-3)


if __name__ == "__main__":
    unittest.main()
