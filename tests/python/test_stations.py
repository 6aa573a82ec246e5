#!/usr/bin/env python3
"""-fault_stations: the cells that contain the points are recorded at every accepted step, with the numbers that /fields
and /series have, on grids, meshes and ranks, and over a restart."""
import os
import unittest

from scripts import TWO_PLANES, FaultTest

import h5py
import numpy as np

GRID = ["-fault_nx", "6", "-fault_nz", "5", "-ts_max_time", "4"]
UNITS = {"time": "s", "slip": "m", "slip_rate": "m/s", "traction": "Pa", "state": "m"}
# Displacements are of 0.5 m, so that their differences are rounded by 1e-16 m each step: slip to 1e-14 m
ROUNDING = 1e-14


class Stations(FaultTest):
    def mesh(self):
        """Two planes with an offset of 1000 m, which overlap along strike."""
        self.make_mesh("mesh", TWO_PLANES)
        return self.get("mesh", "cells")

    def compare(self, name, cells):
        """Each station with the fields, which have an entry for the start and every step, and with /series."""
        with h5py.File(self.path(name)) as file:
            self.assertEqual(list(file["stations"]), [str(k) for k in range(len(cells))])
            time = file["series/time"][...]
            self.assertGreater(len(time), 10)
            fields = {key: file[f"fields/{key}"][...].reshape(len(time), -1)
                      for key in ("slip", "slip_rate", "traction")}
            for k, cell in enumerate(cells):
                station = file[f"stations/{k}"]
                self.assertEqual({key: data.attrs["units"].decode() for key, data in station.items()}, UNITS)
                self.assertEqual(station.attrs["cell"], cell)
                np.testing.assert_array_equal(station["time"], time)
                np.testing.assert_array_equal(station["slip_rate"], fields["slip_rate"][:, cell])
                np.testing.assert_array_equal(station["state"], fields["slip"][:, cell])
                # a weight is divided out by one rounding here and two there
                np.testing.assert_allclose(station["traction"], fields["traction"][:, cell], rtol=1e-15)
                np.testing.assert_allclose(station["slip"], fields["slip"][:, cell], rtol=0, atol=ROUNDING)

    def test_grid(self):
        """Edges and corners, and loading, of which slip knows nothing. Cells are 500 m x 600 m."""
        points = "250,300; 3000 , 3000;1600,1e3"
        self.fault(*GRID, "-fault_loading_rate", "1e-3", "-fault_output", "a.h5", "-fault_stations", points)
        self.compare("a.h5", [0, 29, 9])
        with h5py.File(self.path("a.h5")) as file:
            attributes = file["stations/2"].attrs
            self.assertEqual([attributes[key] for key in ("x", "z", "cell_x", "cell_z")], [1600, 1000, 1750, 900])

    def test_slip_is_signed(self):
        """A fault loaded from rest: slip is the integral of the rate, by the trapezoidal rule of each stage to 1 % on
        1000 steps."""
        self.fault(*GRID, "-fault_loading_rate", "-0.01", "-fault_initial", "rest", "-fault_friction_residual", "0",
                   "-fault_friction_drop", "0", "-ts_max_time", "3", "-ts_adapt_type", "none", "-ts_dt", "0.003",
                   "-fault_output", "a.h5", "-fault_stations", "1000,1000")
        with h5py.File(self.path("a.h5")) as file:
            station = {key: data[...] for key, data in file["stations/0"].items()}
        integral = np.sum(0.5 * (station["slip_rate"][1:] + station["slip_rate"][:-1]) * np.diff(station["time"]))
        self.assertLess(station["slip"][-1], 0)
        self.assertGreater(station["state"][-1], 0)
        self.assertAlmostEqual(integral / (station["slip"][-1] - station["slip"][0]), 1, delta=0.01)

    def test_mesh_on_ranks(self):
        cells = self.mesh()
        asked = [7, 33, 12]
        points = ";".join(f"{x:.17g},{y:.17g},{z:.17g}" for x, y, z in cells[asked, :3])
        for ranks in (1, 2):
            self.fault("-fault_mesh", "mesh", "-ts_max_time", "3", "-fault_output", f"{ranks}.h5", "-fault_stations",
                       points, ranks=ranks)
            self.compare(f"{ranks}.h5", asked)
        with h5py.File(self.path("2.h5")) as file:
            np.testing.assert_array_equal([file["stations/1"].attrs["cell_" + key] for key in "xyz"], cells[33, :3])
        message = self.fault("-fault_mesh", "mesh", "-fault_output", "b.h5", "-fault_stations", "1500,1500", code=1)
        self.assertIn("x,y,z", message)

    def test_planes_that_dip(self):
        """A point in whole metres is on the plane near to it, and one on the edge that two rows share, or two segments,
        of either; along the strike and in depth it is in a row of a listric fault."""
        load = ["-fault_friction_law", "rate_and_state", "-fault_normal_stress", "50e6",
                "-fault_normal_stress_gradient", "0", "-fault_rake", "90", "-fault_loading_rate", "1e-9",
                "-fault_friction_slip", "0.05", "-ts_max_time", "1e6", "-fault_output_overwrite"]
        for kind, options in (("listric", "--strike 33 --dip 70"), ("segmented", "--strikes 0 30 --dip 90")):
            self.make_mesh("mesh", f"{kind} --cells 5 4 --size 5000 4000 {options}")
            cells = self.get("mesh", "cells")
            asked = list(range(len(cells)))
            points = [",".join(f"{x:.0f}" for x in cell[:3]) for cell in cells]
            if kind == "listric":
                along = cells[7, 0] * np.cos(np.radians(33)) + cells[7, 1] * np.sin(np.radians(33))
                down = np.array([-np.sin(np.radians(33)), np.cos(np.radians(33))]) * np.cos(np.radians(cells[7, 6]))
                edge = np.append(cells[7, :2] + 500 * down, cells[7, 2] + 500 * np.sin(np.radians(cells[7, 6])))
                points += [f"{along},{cells[7, 2]}", f"{along},{edge[2]}", ",".join(f"{x!r}" for x in edge.tolist())]
                asked += [7, 7, 7]
            else:
                points += ["5000,0,1500"]  # where the segments meet
                asked += [9]
            self.fault(*load, "-fault_mesh", "mesh", "-fault_output", "a.h5", "-fault_stations", ";".join(points))
            with h5py.File(self.path("a.h5")) as file:
                self.assertEqual([file[f"stations/{k}"].attrs["cell"] for k in range(len(points))], asked)
                np.testing.assert_allclose([file[f"stations/{k}/slip_rate"][-1] for k in range(len(points))],
                                           file["fields/slip_rate"][-1][asked], rtol=0)
        # 1.5 % of a cell
        message = self.fault(*load, "-fault_mesh", "mesh", "-fault_output", "a.h5", "-fault_stations", "2500,15,1500",
                             code=1)
        self.assertIn("-fault_stations", message)

    def test_restart_with_other_points(self):
        """Is refused; with the same ones it is the unbroken run (tests/integration/restarts.py)."""
        self.fault(*GRID, "-fault_stations", "1000,1000;2000,2000", "-fault_output", "part.h5", "-fault_checkpoint",
                   "state", "-ts_max_steps", "8", code=3)
        for points in ("1000,1000", "1000,1000;1,1", "1000,1000;2000,2000;1,1"):
            message = self.fault(*GRID, "-fault_output", "part.h5", "-fault_restart", "state", "-fault_stations",
                                 points, code=1)
            self.assertIn("another -fault_output", message)

    def test_long_runs(self):
        """Beyond 2^37 s the rest of each time has a column, whose name each of several tables finds wherever it lies in
        memory."""
        points = ";".join(f"{x},9000" for x in (1000, 3000, 5000, 7000))
        self.fault("-fault_nx", "4", "-fault_nz", "2", "-fault_length_x", "8e3", "-fault_length_z", "4e3",
                   "-fault_depth_top", "8e3", "-fault_viscosity", "radiation", "-fault_inertia", "no",
                   "-fault_friction_law", "rate_and_state", "-fault_initial", "rate", "-fault_initial_rate", "1e-9",
                   "-fault_loading_rate", "1e-9", "-fault_normal_stress", "50e6", "-ts_max_time", "5000y",
                   "-fault_stations", points, "-fault_output", "long.h5")
        with h5py.File(self.path("long.h5")) as file:
            for k in range(4):
                station = file[f"stations/{k}"]
                self.assertEqual(set(station), {*UNITS, "time_rest"})
                self.assertEqual(len(station["time_rest"]), len(station["time"]))

    def test_stations_that_begin_at_a_restart(self):
        """Slip counts from where the stations begin, and loading with it: in an output that begins at a restart the
        slip of a fault that slides one way is what the state has grown by since the checkpoint."""
        mine = [*GRID, "-fault_loading_rate", "0.01"]
        self.fault(*mine, "-fault_checkpoint", "state", "-fault_output", "early.h5", "-ts_max_time", "3")
        self.fault(*mine, "-fault_restart", "state", "-fault_output", "late.h5", "-fault_stations",
                   "1250,900;1750,2100", "-ts_max_time", "6")
        with h5py.File(self.path("early.h5")) as file:
            self.assertEqual(file["fields/time"][-1], 3)
            before = file["fields/slip"][-1].ravel()
        with h5py.File(self.path("late.h5")) as file:
            for k in "01":
                station = {key: data[...] for key, data in file[f"stations/{k}"].items()}
                self.assertEqual((station["time"][0], station["slip"][0]), (3, 0))
                self.assertGreaterEqual(station["slip_rate"].min(), 0)
                self.assertGreater(station["slip"][-1], 0.01)
                slip = station["state"] - before[file[f"stations/{k}"].attrs["cell"]]
                np.testing.assert_allclose(station["slip"], slip, rtol=0, atol=ROUNDING)

    def test_errors(self):
        self.assertIn("-fault_output", self.fault(*GRID, "-fault_stations", "1,1", code=1))
        for points, message in (("1", 'the point "1"'), ("1,2,3,4", '"1,2,3,4"'), ("a,b", '"a,b"'),
                                ("1,nan", '"1,nan"'), ("1,2 m", '"1,2 m"'),
                                (";", 'is ";"'), ("1,1;3001,1", "3001,1 outside the fault"),
                                ("1,-1", "the nearest is at x = 250")):
            self.assertIn(message, self.fault(*GRID, "-fault_output", "a.h5", "-fault_stations", points, code=1))
        self.put("points.txt", "1 1\n1 a\n")
        self.assertIn('points.txt (-fault_stations), line 2: "1 a"', self.fault(
            *GRID, "-fault_output", "a.h5", "-fault_stations", "points.txt", code=1))
        self.assertFalse(os.path.exists(self.path("a.h5")))

    def test_file(self):
        """A file of points is a list of them, and a list may be long."""
        points = [(250, 300), (1250, 900)] + [(2750, 2700)] * 600
        with open(self.path("points.txt"), "w") as file:
            file.write("# x z\n\n" + "".join(f"{x} {z}  # a comment\n" for x, z in points[:2]) + "2750,0,2700\n")
        for name, stations, cells in (("file.h5", "points.txt", [0, 8, 29]),
                                      ("list.h5", ";".join(f"{x},{z}" for x, z in points), [0, 8] + [29] * 600)):
            self.fault(*GRID, "-fault_output", name, "-fault_stations", stations, "-ts_max_time", "1")
            self.assertEqual([self.get(name, f"stations/{k}@cell") for k in range(len(cells))], cells)


if __name__ == "__main__":
    unittest.main()
