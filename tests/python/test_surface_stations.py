#!/usr/bin/env python3
"""-fault_surface_stations: points of the free surface move by what slip on every cell makes by Okada's closed form
(1985), on grids, meshes and ranks, and over a restart; on dipping faults as published for SEAS BP3, and turned as the
fault is."""
import re
import unittest

from scripts import TWO_PLANES, FaultTest

import h5py
import numpy as np

from slipstep.times import YEAR

GRID = ["-fault_nx", "6", "-fault_nz", "5", "-ts_max_time", "4", "-fault_loading_rate", "1e-3"]
POINTS = [(1200, 300), (1200, -300), (-4000, 2500), (3700, -0.5)]
TEXT = ";".join(f"{x},{y}" for x, y in POINTS)
BP3 = """-fault_nx 1 -fault_nz 200 -fault_length_z 40e3 -fault_dip 60 -fault_rake 90 -fault_shear_modulus 32.03812e9
    -fault_density 2670
    -fault_friction_law rate_and_state -fault_friction_b 0.015 -fault_friction_slip 0.008 -fault_normal_stress 50e6
    -fault_normal_stress_gradient 0 -fault_loading_rate 1e-9 -fault_initial traction -fault_initial_traction 26.54612e6
    -fault_initial_rate 1e-9 -fault_parameters fields.h5 -fault_output bp3.h5 -ts_max_time 1.58e9""".split()
CREEP = """-fault_nx 6 -fault_nz 5 -fault_friction_law rate_and_state -fault_normal_stress 20e6 -fault_friction_b 0.005
    -fault_normal_stress_gradient 0 -fault_loading_rate 1e-9 -fault_initial_rate 1e-10 -fault_depth_top 100
    -ts_max_time 3y""".split()
# Slip of 1 m times some 40 kernels of at most 1 / 2, each rounded by some ten operations
ROUNDING = 1e-14


def okada(x, y, rectangle):
    """Displacement along x, y (to the right) and z (down) for unit left-lateral slip on a vertical rectangle (x, y, z
    of its centre, length, width), nu = 1/4: equations 25 and 28 of Okada (1985) with cos(dip) = 0, whose y is to the
    left and z upward."""
    x0, y0, z0, length, width = rectangle
    q, alpha = -(y - y0), 0.5  # mu / (lambda + mu)
    total = np.zeros(3)
    for i, xi in ((1, x - x0 + length / 2), (-1, x - x0 - length / 2)):
        for j, eta in ((1, z0 + width / 2), (-1, z0 - width / 2)):
            r = np.sqrt(xi**2 + eta**2 + q**2)
            i3 = alpha / 2 * (eta / (r + eta) + q**2 / (r + eta)**2 - np.log(r + eta))
            total += i * j * np.array([xi * q / (r * (r + eta)) + np.arctan(xi * eta / (q * r)) - alpha / 2 * xi * q
                                       / (r + eta)**2, q**2 / (r * (r + eta)) - alpha * np.log(r + eta) - i3,
                                       eta * q / (r * (r + eta)) + q / (r + eta) - alpha * q / (r + eta)])
    return -total / (2 * np.pi) * [1, -1, -1]


class SurfaceStations(FaultTest):
    def compare(self, name, cells, loading):
        """With the sum over the cells [N, 5] of what /fields has, an entry for the start and every step; the largest
        displacement"""
        kernel = np.array([[okada(x, y, cell) for cell in cells] for x, y in POINTS])  # [point, cell, 3]
        with h5py.File(self.path(name)) as file:
            time = file["series/time"][...]
            u = file["fields/displacement"][...].reshape(len(time), -1)
            v = file["fields/slip_rate"][...].reshape(len(time), -1) - loading
            for k, (x, y) in enumerate(POINTS):
                group = file[f"surface/{k}"]
                self.assertEqual((group.attrs["x"], group.attrs["y"]), (x, y))
                self.assertEqual({key: data.attrs["units"].decode() for key, data in group.items()},
                                 {"time": "s", "displacement": "m", "velocity": "m/s"})
                np.testing.assert_array_equal(group["time"], time)
                np.testing.assert_allclose(group["displacement"], (u - u[0]) @ kernel[k], rtol=0,
                                           atol=len(cells) * ROUNDING)
                np.testing.assert_allclose(group["velocity"], v @ kernel[k], rtol=0, atol=len(cells) * ROUNDING)
            return np.abs(file["surface/0/displacement"][...]).max()

    def test_uniform_slip(self):
        """One cell of 3 km."""
        self.fault("-fault_nx", "1", "-fault_nz", "1", "-fault_output", "one.h5", "-fault_surface_stations", TEXT)
        self.assertGreater(self.compare("one.h5", [(1500, 0, 1500, 3000, 3000)], 0), 0.05)
        with h5py.File(self.path("one.h5")) as file:  # the sides move apart
            np.testing.assert_array_equal(file["surface/0/displacement"][:, 0], -file["surface/1/displacement"][:, 0])
            self.assertEqual(np.transpose([file[f"ground_points/{axis}"] for axis in "xy"]).tolist(),
                             [list(map(float, point)) for point in POINTS])
            self.assertEqual((file["ground"].attrs["total"], file["ground/velocity"].shape),
                             (0, (len(file["series/time"]), len(POINTS), 3)))
            for k in range(len(POINTS)):  # each station's group shows its part
                for key in ("displacement", "velocity"):
                    np.testing.assert_array_equal(file[f"surface/{k}/{key}"], file[f"ground/{key}"][:, k])

    def test_grid_on_ranks(self):
        cells = [(250 + 500 * i, 0, 300 + 600 * j, 500, 600) for j in range(5) for i in range(6)]
        for ranks in (1, 2, 4):
            self.fault(*GRID, "-fault_output", f"{ranks}.h5", "-fault_surface_stations", TEXT, ranks=ranks)
            self.assertGreater(self.compare(f"{ranks}.h5", cells, 1e-3), 1e-3)

    def test_mesh_of_planes(self):
        self.make_mesh("mesh", TWO_PLANES)
        cells = self.get("mesh", "cells")
        self.assertEqual(len(set(cells[:, 1])), 2)
        for ranks in (1, 2):
            self.fault("-fault_mesh", "mesh", "-ts_max_time", "15", "-fault_output", f"{ranks}.h5",
                       "-fault_surface_stations", TEXT, ranks=ranks)
            self.assertGreater(self.compare(f"{ranks}.h5", cells, 0), 1e-3)

    def test_restart_with_other_points(self):
        """Is refused; with the same ones it is the unbroken run (tests/integration/restarts.py)."""
        self.fault(*GRID, "-fault_surface_stations", TEXT, "-fault_output", "part.h5", "-fault_checkpoint", "state",
                   "-ts_max_steps", "12", code=3)
        places = [[point.split(",") for point in TEXT.split(";")] for _ in range(2)]
        for axis, place in enumerate(places):
            place[-1][axis] = repr(float(place[-1][axis]) + 1)
        # other points, and one whose x, or y, differs
        for other in ["1,2", *(";".join(map(",".join, place)) for place in places)]:
            message = self.fault(*GRID, "-fault_output", "part.h5", "-fault_restart", "state",
                                 "-fault_surface_stations", other, code=1)
            self.assertIn("error: part.h5 ", message)

    def test_restart_to_another_output(self):
        """A new file is of displacement since its own beginning."""
        mine = [*GRID, "-fault_surface_stations", TEXT]
        self.fault(*mine, "-fault_output", "before.h5", "-fault_checkpoint", "state", "-ts_max_steps", "12", code=3)
        self.fault(*mine, "-fault_output", "after.h5", "-fault_restart", "state")
        self.fault(*mine, "-fault_output", "whole.h5")
        for k in range(len(POINTS)):
            with h5py.File(self.path("whole.h5")) as whole, h5py.File(self.path("after.h5")) as after:
                u, last = (file[f"surface/{k}/displacement"][...] for file in (whole, after))
            self.assertGreater(abs(u[12]).max(), 1e-6)
            np.testing.assert_allclose(last, u[12:] - u[12], rtol=0, atol=30 * ROUNDING)

    def test_bp3(self):
        """SEAS BP3, thrust of 60 degrees: displacement, horizontal and down, at 50.0307 years, before the first event,
        as published for the code FDRA with cells of 25 m, with the rigid motion of the plates: half of the slip along
        the dip, up on the right."""
        published = {16e3: (-0.400304, -0.418260), -16e3: (-0.031915, 0.527212), 0.0: (-0.303663, 0.227878)}
        length, depth = 3.9e7, (np.arange(200) + 0.5) * 200
        self.hdf5("fields.h5", friction_a=np.interp(depth, [15e3, 18e3], [0.010, 0.025])[:, None])
        self.fault(*BP3, "-fault_length_x", length, "-fault_surface_motion", "total", "-fault_surface_stations",
                   ";".join(f"{length / 2},{y}" for y in published))
        time = 50.0307 * YEAR
        with h5py.File(self.path("bp3.h5")) as file:
            for k, (y, wanted) in enumerate(published.items()):
                found = [np.interp(time, file[f"surface/{k}/time"], file[f"surface/{k}/displacement"][:, c])
                         for c in range(3)]
                self.assertEqual(found[0], 0)  # the middle of the strike
                # 7e-5 to 1.2e-4 m are between the two codes, with cells of 25 m too. And the fault has an end: 1.4e-4 m
                # down, 5.3e-4 m times 1e7 m / length, as slip deficit times width over half of the length is.
                np.testing.assert_allclose(found[1:], wanted, rtol=0, atol=3e-4)

    def test_motion_of_plates(self):
        """Between plates that slip at V below a depth D the ground moves along the strike with V/pi arctan(y/D) (Savage
        & Burford 1973), y the distance to the right; a rate that is not one, or planes that are several, have no
        plates; and a restart is in the frame of its file."""
        depth, rate, length = 10e3, 1e-9, 3.9e7
        across = np.array([3e3, 10e3, 40e3, 1e-3])
        points = ";".join(f"{length / 2},{y}" for y in (*across, *-across))
        rest = ("-fault_nx", 1, "-fault_nz", 1, "-fault_length_x", length, "-fault_length_z", depth, "-fault_initial",
                "rest", "-fault_loading_rate", rate, "-ts_max_time",
                "1y", "-fault_surface_stations", points, "-fault_output", "run.h5")
        for motion in ("total", "relative"):
            self.fault(*rest, "-fault_surface_motion", motion, "-fault_checkpoint", "state", "-fault_output_overwrite")
            with h5py.File(self.path("run.h5")) as file:
                moved, moves, time = file["ground/displacement"][-1, :, 0], file["ground/velocity"][-1, :, 0], file[
                    "ground/time"][-1]
                y = file["ground_points/y"][()]
            # the ends of the fault are 2,000 D away, where the deficit is a double couple: D^2/r^2
            exact = rate / np.pi * np.arctan(y / depth) - (rate / 2 * np.sign(y) if motion == "relative" else 0)
            np.testing.assert_allclose(moves, exact, rtol=0, atol=1e-6 * rate)
            np.testing.assert_allclose(moved, exact * time, rtol=0, atol=1e-6 * rate * time)
        self.assertIn("-fault_surface_motion relative",
                      self.fault(*rest, "-fault_surface_motion", "total", "-fault_restart", "state", "-ts_max_time",
                                 "2y", code=1))
        self.hdf5("fields.h5", loading_rate=np.full((1, 2), 1e-9) * [1, 2])
        self.assertIn("-fault_surface_motion total",
                      self.fault(*rest, "-fault_nx", 2, "-fault_parameters", "fields.h5", "-fault_surface_motion",
                                 "total", "-fault_output_overwrite", code=1))

    def test_long_lists(self):
        """A list has no end at 4,095 characters, which a file's name has."""
        points = [(10.0 * k, 7.0) for k in range(600)]
        text = ";".join(f"{x},{y}" for x, y in points)
        self.assertGreater(len(text), 4200)
        self.fault(*GRID, "-fault_output", "long.h5", "-fault_surface_stations", text, "-ts_max_time", "1")
        with h5py.File(self.path("long.h5")) as file:
            self.assertEqual((file["ground_points/x"][-1], len(file["surface"])), (points[-1][0], 600))
        self.assertIn("-fault_output has 5000 characters", self.fault(*GRID, "-fault_output", 5000 * "a", code=1))

    def test_strike_and_rake(self):
        """A fault that is turned turns what it does, and on a vertical one rake 180 is rake 0 with the other sign."""
        angle = np.radians(35)
        turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
        turned = ";".join(f"{x!r},{y!r}" for x, y in (turn[:2, :2] @ np.transpose(POINTS)).T.tolist())

        def displacements(name, *options, points=TEXT, ranks=1):
            # steps that accuracy bounds
            self.fault(*CREEP, "-ts_rtol", "1e-7", "-fault_output", name, "-fault_surface_stations", points, *options,
                       ranks=ranks)
            return np.array([[self.get(name, f"surface/{k}/{what}")[-1] for what in ("displacement", "velocity")] for k
                             in range(len(POINTS))])

        dipping = ["-fault_dip", "50", "-fault_rake", "70"]
        plain = displacements("plain.h5", *dipping)
        self.assertGreater(np.abs(plain[:, 0]).max(), 1e-4)
        # Both runs take the same steps, some hundred; each rounds the products of the stiffness, 1e-16 times a factor
        # of some ten
        close = {"rtol": 0, "atol": 1e-12 * np.abs(plain[:, 0]).max()}
        for ranks in (1, 2):
            found = displacements(f"turned{ranks}.h5", *dipping, "-fault_strike", "35", points=turned, ranks=ranks)
            np.testing.assert_allclose(found[:, 0], plain[:, 0] @ turn.T, **close)
        left, right = displacements("left.h5"), displacements("right.h5", "-fault_rake", "180")
        # two closed forms of the same
        np.testing.assert_allclose(right, -left, rtol=0, atol=1e-13 * np.abs(left).max())

    def test_file(self):
        """A file of points is a list of them."""
        self.put("points.txt", "# x y\n\n" + "".join(f" {x}{between}{y} {more}\n" for (x, y), between, more
                                                     in zip(POINTS, (",", " ", "\t", " , "), ("", "# far", "\r", ""))))
        for ranks in (1, 2):
            self.fault(*GRID, "-fault_output", "list.h5", "-fault_surface_stations", TEXT, ranks=ranks)
            self.fault(*GRID, "-fault_output", "file.h5", "-fault_surface_stations", "points.txt", ranks=ranks)
            with h5py.File(self.path("list.h5")) as one, h5py.File(self.path("file.h5")) as other:
                self.assertEqual(len(other["surface"]), len(POINTS))
                for k in range(len(POINTS)):
                    self.assertEqual(dict(one[f"surface/{k}"].attrs), dict(other[f"surface/{k}"].attrs))
                    np.testing.assert_array_equal(one[f"surface/{k}/displacement"], other[f"surface/{k}/displacement"])
        for content, message in (("1 2\n# 3\n4;5\n", 'line 3: "4;5"'),
                                 ("1 2 3\n", 'line 1: "1 2 3"'),
                                 ("1\n", 'line 1: "1"'),
                                 ("1 2\n3,inf", 'line 2: "3,inf"'),
                                 ("1 2" + 300 * " ", "line 1: "), ("# nothing\n", "has no points"),
                                 ("", "has no points")):
            self.put("bad.txt", content)
            found = self.fault(*GRID, "-fault_output", "a.h5", "-fault_surface_stations", "bad.txt", code=1)
            self.assertRegex(found, re.escape("bad.txt (-fault_surface_stations)"))
            self.assertIn(message, found)
        self.assertIn("-fault_surface_stations",
                      self.fault(*GRID, "-fault_output", "points.txt", "-fault_surface_stations", "points.txt", code=1))

    def test_errors(self):
        self.assertIn("-fault_output", self.fault(*GRID, "-fault_surface_stations", "1,1", code=1))
        for points in ("1", "1,2,3", "1,a", "1 2", "1,2;;3", ";", "no.txt"):
            self.assertIn("expected points \"x,y;x,y\" in m",
                          self.fault(*GRID, "-fault_output", "a.h5", "-fault_surface_stations", points, code=1))
        self.assertIn("-fault_kernel half_space", self.fault(*GRID, "-fault_output", "a.h5", "-fault_surface_stations",
                                                             "1,1", "-fault_kernel", "full_space", code=1))


if __name__ == "__main__":
    unittest.main()
