#!/usr/bin/env python3
"""-fault_surface_stations: points of the free surface move by what slip on every cell makes by Okada's closed form (1985), on grids,
meshes and ranks, and over a restart."""
import os
import subprocess
import sys
import unittest

from scripts import SOURCE, FaultTest

import h5py
import numpy as np

GRID = ["-fault_nx", "6", "-fault_nz", "5", "-ts_max_time", "4", "-fault_loading_rate", "1e-3"]
POINTS = [(1200, 300), (1200, -300), (-4000, 2500), (3700, -0.5)]
TEXT = ";".join(f"{x},{y}" for x, y in POINTS)
# Slip of 1 m times some 40 kernels of at most 1 / 2, each rounded by some ten operations
ROUNDING = 1e-14


def okada(x, y, rectangle):
    """Displacement along x, y (to the right) and z (down) for unit left-lateral slip on a vertical rectangle (x, y, z of its centre, length,
    width), nu = 1/4: equations 25 and 28 of Okada (1985) with cos(dip) = 0, whose y is to the left and z upward."""
    x0, y0, z0, length, width = rectangle
    q, alpha = -(y - y0), 0.5  # mu / (lambda + mu)
    total = np.zeros(3)
    for i, xi in ((1, x - x0 + length / 2), (-1, x - x0 - length / 2)):
        for j, eta in ((1, z0 + width / 2), (-1, z0 - width / 2)):
            r = np.sqrt(xi**2 + eta**2 + q**2)
            i3 = alpha / 2 * (eta / (r + eta) + q**2 / (r + eta)**2 - np.log(r + eta))
            total += i * j * np.array([xi * q / (r * (r + eta)) + np.arctan(xi * eta / (q * r)) - alpha / 2 * xi * q / (r + eta)**2,
                                       q**2 / (r * (r + eta)) - alpha * np.log(r + eta) - i3,
                                       eta * q / (r * (r + eta)) + q / (r + eta) - alpha * q / (r + eta)])
    return -total / (2 * np.pi) * [1, -1, -1]


class SurfaceStations(FaultTest):
    def compare(self, name, cells, loading):
        """With the sum over the cells [N, 5] of what /fields has, an entry for the start and every step; the largest displacement"""
        kernel = np.array([[okada(x, y, cell) for cell in cells] for x, y in POINTS])  # [point, cell, 3]
        with h5py.File(self.path(name)) as file:
            time = file["series/time"][...]
            u = file["fields/displacement"][...].reshape(len(time) + 1, -1)
            v = file["fields/slip_rate"][1:].reshape(len(time), -1) - loading
            for k, (x, y) in enumerate(POINTS):
                group = file[f"surface/{k}"]
                self.assertEqual((group.attrs["x"], group.attrs["y"]), (x, y))
                self.assertEqual({key: data.attrs["units"].decode() for key, data in group.items()},
                                 {"time": "s", "displacement": "m", "velocity": "m/s"})
                np.testing.assert_array_equal(group["time"], time)
                np.testing.assert_allclose(group["displacement"], (u[1:] - u[0]) @ kernel[k], rtol=0, atol=len(cells) * ROUNDING)
                np.testing.assert_allclose(group["velocity"], v @ kernel[k], rtol=0, atol=len(cells) * ROUNDING)
            return np.abs(file["surface/0/displacement"][...]).max()

    def test_uniform_slip(self):
        """One cell of 3 km."""
        self.fault("-fault_nx", "1", "-fault_nz", "1", "-fault_output", "one.h5", "-fault_surface_stations", TEXT)
        self.assertGreater(self.compare("one.h5", [(1500, 0, 1500, 3000, 3000)], 0), 0.05)
        with h5py.File(self.path("one.h5")) as file:  # the sides move apart
            np.testing.assert_array_equal(file["surface/0/displacement"][:, 0], -file["surface/1/displacement"][:, 0])

    def test_grid_on_ranks(self):
        cells = [(250 + 500 * i, 0, 300 + 600 * j, 500, 600) for j in range(5) for i in range(6)]
        for ranks in (1, 2, 4):
            self.fault(*GRID, "-fault_output", f"{ranks}.h5", "-fault_surface_stations", TEXT, ranks=ranks)
            self.assertGreater(self.compare(f"{ranks}.h5", cells, 1e-3), 1e-3)

    def test_mesh_of_planes(self):
        subprocess.run([sys.executable, os.path.join(SOURCE, "examples", "make_mesh.py"), "mesh", "parallel", "--cells", "5", "4",
                        "--ratio", "2", "--offset", "1000", "--shift", "500"], cwd=self.folder.name, check=True, capture_output=True)
        with h5py.File(self.path("mesh")) as file:
            cells = file["cells"][...]
        self.assertEqual(len(set(cells[:, 1])), 2)
        for ranks in (1, 2):
            self.fault("-fault_mesh", "mesh", "-ts_max_time", "15", "-fault_output", f"{ranks}.h5", "-fault_surface_stations", TEXT, ranks=ranks)
            self.assertGreater(self.compare(f"{ranks}.h5", cells, 0), 1e-3)

    def test_restart(self):
        mine = [*GRID, "-fault_surface_stations", TEXT]
        self.fault(*mine, "-fault_output", "whole.h5")
        self.fault(*mine, "-fault_output", "part.h5", "-fault_checkpoint", "state", "-ts_max_steps", "12", code=3)
        self.fault(*mine, "-fault_output", "part.h5", "-fault_restart", "state")
        with h5py.File(self.path("whole.h5")) as whole, h5py.File(self.path("part.h5")) as part:
            for k in range(len(POINTS)):
                for key, data in whole[f"surface/{k}"].items():
                    np.testing.assert_array_equal(data, part[f"surface/{k}/{key}"])
        message = self.fault(*GRID, "-fault_output", "part.h5", "-fault_restart", "state", "-fault_surface_stations", "1,2", code=1)
        self.assertIn("has other points of the surface than -fault_surface_stations", message)

    def test_errors(self):
        self.assertIn("expected -fault_output", self.fault(*GRID, "-fault_surface_stations", "1,1", code=1))
        for points in ("1", "1,2,3", "1,a", "1,2;;3", ";"):
            self.assertIn("expected points \"x,y;x,y\" in m", self.fault(*GRID, "-fault_output", "a.h5", "-fault_surface_stations", points, code=1))
        self.assertIn("expected -fault_kernel half_space",
                      self.fault(*GRID, "-fault_output", "a.h5", "-fault_surface_stations", "1,1", "-fault_kernel", "full_space", code=1))


if __name__ == "__main__":
    unittest.main()
