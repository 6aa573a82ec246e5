"""Faults that open: a disc under pressure, a fault that is pressed and might as well not open, a thrust whose tip
opens: its files, its energies, on several ranks and from a checkpoint."""

import os
import sys
import unittest

from scripts import SOURCE, FaultTest
import h5py
import numpy as np

from meshfiles import plane, write_hdf5

sys.path.insert(0, os.path.join(SOURCE, "tests", "benchmarks"))
import crack_triangles

OPENS = ("-fault_slip_components", "2", "-fault_opening", "yes", "-fault_initial", "traction")
# a thrust that reaches the ground; cells are coarse against its cohesive zone: their fronts are not of interest here
CELLS, SIZE, DIP = (12, 8), (650.0, 600.0), 25
THRUST = ("-fault_mesh", "mesh.h5", "-fault_parameters", "fields.h5", "-fault_stiffness_average", "cell", "-fault_rake",
          "90", "-fault_slip_components", "2", "-fault_initial", "traction", "-fault_initial_unstable",
          "-fault_friction_law", "linear_slip_weakening", "-fault_friction_slip", "0.1", "-fault_viscosity",
          "radiation", "-fault_thickness", "2000")
DYNAMIC = ("-fault_inertia", "yes", "-ts_max_time", "20", "-fault_output_slip_interval", "0.1",
           "-fault_output_fields", "slip_rate,slip,traction,normal_stress")


class Opening(FaultTest):
    def thrust(self, gradient, offset=0):
        """Friction falls from 0.6 to 0.1 but at the sides and the lower end, under half the normal stress, and more
        than its strength in a disc"""
        vertices, triangles = plane(CELLS, SIZE, 0, DIP, (0, 0, 0))
        write_hdf5(self.path("mesh.h5"), vertices, triangles)
        centre = vertices[triangles].mean(axis=1)
        x, down = centre[:, 0], centre[:, 2] / np.sin(np.radians(DIP))
        length, width = CELLS[0] * SIZE[0], CELLS[1] * SIZE[1]
        sigma = gradient * centre[:, 2] + offset
        edge = np.minimum(np.minimum(x, length - x), width - down) < 700
        self.hdf5("fields.h5", normal_stress=sigma,
                  initial_traction=np.where(np.hypot(x - length / 2, down - 0.65 * width) < 900, 0.61, 0.5) * sigma,
                  friction_residual=np.full_like(x, 0.1), friction_drop=np.where(edge, 1.5, 0.5))

    def test_penny_crack(self):
        """Sneddon's (1946) opening w = 4 (1 - nu) p sqrt(a^2 - r^2) / (pi G) of a disc of unstructured triangles in a
        full space, with averages over them, as the error of its volume: that of the slip of a shear crack, which halves
        with the cells. Measured at 10, 20, 40 across: 6.9, 3.0, 1.2 %; within 0.7 of the radius 1.1, 0.5, 0.3 % of the
        largest. (Stress at centroids is no use where triangles are irregular: 22, 33, 73 %.)"""
        radius, p, G, nu = crack_triangles.RADIUS, 0.5e6, 30e9, 0.25
        off, inside = [], []
        for across in (10, 20):
            points, triangles = crack_triangles.lattice(across, 0.25)
            dip = np.radians(30)
            vertices = np.stack([points[:, 0], points[:, 1] * np.cos(dip), 3 * radius + points[:, 1] * np.sin(dip)],
                                axis=1)
            write_hdf5(self.path("disc.h5"), vertices, triangles)
            self.hdf5("pressure.h5", time=[0.0, 1.0], pressure=np.full((2, len(triangles)), 1e6 + p))
            self.fault("-fault_mesh", "disc.h5", "-fault_kernel", "full_space", *OPENS, "-fault_stiffness_average",
                       "cell", "-fault_inertia", "no", "-fault_viscosity", "radiation", "-fault_normal_stress", "1e6",
                       "-fault_normal_stress_gradient", 0, "-fault_friction_law", "constant", "-fault_pore_pressure",
                       "pressure.h5", "-fault_output", "disc_out.h5", "-fault_output_overwrite", "-ts_adapt_type",
                       "basic", "-ts_max_time", "30")
            a, b, c = (points[triangles[:, k]] for k in range(3))
            area = abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
            opening, slip = self.get("disc_out.h5", "fields/opening")[-1], self.get("disc_out.h5", "fields/slip")[-1]
            exact = 4 * (1 - nu) * p * radius / (np.pi * G)
            off.append(opening @ area / (exact * 2 / 3 * np.pi * radius**2) - 1)
            r = np.hypot(*(points[triangles].mean(axis=1).T / radius))
            wrong = (opening / exact - np.sqrt(np.maximum(1 - r**2, 0)))[r < 0.7]
            inside.append(np.sqrt(wrong**2 @ area[r < 0.7] / area[r < 0.7].sum()))
            self.assertLess(abs(slip).max(), 1e-9 * exact)
        self.assertTrue(off[0] < 0.08 and off[1] < 0.55 * off[0], off)
        self.assertTrue(inside[0] < 0.015 and inside[1] < 0.6 * inside[0], inside)

    def test_pressed_all_the_time(self):
        """Where nothing opens the constraint of three components finds what that of two with normal stress that follows
        slip does, to what their Newton solves leave: averages over cells are reciprocal, so that the third rows of the
        stiffness are the normal stress of the other."""
        self.thrust(15e3, 2e6)
        slip = []
        for opening in ("no", "yes"):
            printed = self.fault(*THRUST, "-fault_inertia", "no", "-fault_opening", opening, "-ts_adapt_type", "basic",
                                 "-ts_max_time", "20", "-fault_output", "out.h5", "-fault_output_overwrite")
            slip.append(self.get("out.h5", "fields/slip")[-1])
        self.assertIn("cells that opened:       0", printed)
        self.assertGreater(abs(slip[0]).max(), 0.1)
        np.testing.assert_allclose(slip[1], slip[0], rtol=0, atol=1e-6 * abs(slip[0]).max())

    def test_tip_of_a_thrust(self):
        """A rupture that reaches the ground opens its tip, which falls shut behind it, and runs to its end. In every
        entry of its fields a cell is open or pressed, never both, and friction is within its cone; the ledger of
        energies and powers closes; two ranks do the same, and a run that goes on from a checkpoint does so to the
        bit."""
        self.thrust(25e3)
        run = (*THRUST, "-fault_opening", "yes", *DYNAMIC, "-fault_stations", "3683.33,362.523,169.047")
        for name, ranks, more in (("one.h5", 1, ()), ("two.h5", 2, ()),
                                  ("cut.h5", 1, ("-ts_max_steps", "160", "-fault_checkpoint", "state.h5")),
                                  ("cut.h5", 1, ("-fault_restart", "state.h5", "-fault_checkpoint", "state.h5"))):
            printed = self.fault(*run, *more, "-fault_output", name, ranks=ranks, code=3 if "-ts_max_steps" in more
                                 else 0)
        self.assertIn("cells open, first cell", self.fault(*run, "-fault_output", "one.h5", "-fault_output_overwrite"))
        with h5py.File(self.path("one.h5")) as file:
            opening, sigma, slip, traction = (file["fields/" + name][()]
                                              for name in ("opening", "normal_stress", "slip", "traction"))
            series = {name: data[()] for name, data in file["series"].items()}
            station = {name: data[()] for name, data in file["stations/0"].items()}
            result = dict(file["result"].attrs)
            self.assertEqual(file["parameters"].attrs["opening"], 1)
        self.assertEqual(slip.shape, (*opening.shape, 2))
        self.assertTrue((opening >= 0).all() and (sigma >= 0).all() and (opening * sigma == 0).all())
        # cells open and close again
        self.assertGreater(result["cells_without_stress"], 5)
        self.assertGreater((opening > 0).sum(axis=1).max(), 3 * (opening[-1] > 0).sum())
        self.assertGreater(result["largest_opening"], 0.01)
        self.assertLessEqual(opening.max(), result["largest_opening"])
        most = self.get("fields.h5", "friction_residual") + self.get("fields.h5", "friction_drop")
        size = np.hypot(traction[..., 0], traction[..., 1])
        self.assertTrue((size <= most * sigma * (1 + 1e-9)).all())
        self.assertTrue((size[opening > 0] == 0).all())
        self.assertEqual(station["slip"].shape, (len(station["time"]), 2))
        self.assertTrue((station["opening"] * station["normal_stress"] == 0).all())
        with self.subTest("energy_residual"):
            stored = series["kinetic_energy"] + series["elastic_energy"]
            power = series["loading_power"] - series["viscous_power"] - series["friction_power"]
            work = (np.diff(series["time"]) * (power[1:] + power[:-1]) / 2).sum()
            self.assertLess(abs(stored[-1] - stored[0] - work), 0.01 * abs(stored - stored[0]).max())
        np.testing.assert_allclose(self.get("two.h5", "fields/slip")[-1], slip[-1], rtol=0, atol=1e-6 * slip.max())
        with h5py.File(self.path("cut.h5")) as file:
            for name, expected in (("opening", opening), ("slip", slip)):
                np.testing.assert_array_equal(file["fields/" + name][()], expected)
            for name in ("least_normal_stress", "cells_without_stress", "largest_opening"):
                self.assertEqual(file["result"].attrs[name], result[name])

    def test_lost_normal_stress(self):
        """A thrust to the ground that slips by more than its normal stress bears, and does not open: cells without it
        have none at all; what the run says of them, in its summary and while it runs, is what /fields have of every
        step."""
        options = ("-fault_nx", 5, "-fault_nz", 4, "-fault_length_x", 5e3, "-fault_length_z", 4e3, "-fault_dip", 20,
                   "-fault_rake", 90, "-fault_normal_stress_gradient", 0, "-fault_friction_law", "constant",
                   "-fault_friction_residual", 0.3, "-fault_initial", "traction", "-fault_initial_unstable",
                   "-fault_inertia", "no", "-fault_viscosity", "radiation", "-fault_output_fields", "normal_stress")
        for stress, lost, ranks in ((2e6, True, 1), (2e6, True, 2), (2e6, False, 2), (500, False, 1)):
            name = f"clamp_{stress}_{lost}_{ranks}.h5"
            text = self.fault(*options, "-fault_normal_stress", stress, "-fault_initial_traction",
                              (3 if lost else 0.75) * stress, "-ts_max_time", 20, "-fault_output", name, ranks=ranks)
            with h5py.File(self.path(name)) as file:
                sigma = file["fields/normal_stress"][()].reshape(-1, 20)
                result = dict(file["result"].attrs)
                self.assertEqual(len(sigma), result["accepted"] + 1)
            bare = sigma <= 0
            self.assertEqual(sigma.min() == 0, lost)
            self.assertEqual(result["least_normal_stress"], sigma.min())
            self.assertNotEqual(sigma.min(), sigma[:, -1].min())
            self.assertEqual(result["cells_without_stress"], bare.any(0).sum())
            said = [line for line in text.splitlines() if "warning: at" in line
                    and "has taken the normal stress" in line]
            self.assertEqual(len(said), lost)
            if lost:
                first = bare[bare.any(1)][0]
                self.assertGreater(bare.sum(), bare.any(0).sum())
                self.assertIn(f"of {first.sum()} cells, first of cell {np.flatnonzero(first)[0]}:", said[0])

    def test_vertical_planes(self):
        """Slip in a vertical plane leaves its own normal stress as it is, whatever its direction, and changes that of a
        parallel plane."""
        for count in (1, 2):
            self.hdf5("planes.h5", units={"cells": "m"},
                      cells=[[0, 1000 * k, 5000, 1000, 1000, 0, 90] for k in range(count)])
            text = self.fault("-fault_mesh", "planes.h5", "-fault_slip_components", 2, "-fault_viscosity", "radiation",
                              "-ts_max_time", 0.1)
            self.assertEqual("least normal stress:" in text, count == 2)
        # a stiffness from a file does not say what slip changes, whatever the dip
        self.hdf5("k.h5", K=1e7 * np.eye(2))
        text = self.fault("-fault_nx", 2, "-fault_nz", 1, "-fault_dip", 30, "-fault_stiffness_file", "k.h5:/K",
                          "-fault_viscosity", "radiation", "-ts_max_time", 0.1)
        self.assertNotIn("least normal stress:", text)

    def test_refused(self):
        """What does not go with opening is refused by the option's name"""
        grid = ("-fault_nx", 4, "-fault_nz", 3, "-fault_depth_top", 5000, "-fault_viscosity", "radiation",
                "-ts_max_time", 1)
        for options, said in ((("-fault_slip_components", 1), "-fault_slip_components 2"),
                              (("-fault_initial", "critical"), "-fault_initial critical"),
                              (("-fault_friction_law", "rate_and_state"), "whose cells always slide"),
                              (("-fault_normal_coupling", "no"), "-fault_normal_coupling"),
                              (("-fault_stiffness_scaling", "mean_slip"), "-fault_stiffness_scaling mean_slip"),
                              (("-fault_depth_top", 0, "-fault_dip", 5), "-fault_stiffness_average cell")):
            self.assertIn(said, self.fault(*grid, *OPENS, *options, code=1), options)
        self.assertIn("-fault_opening yes",
                      self.fault(*grid, "-fault_output", "o.h5", "-fault_output_fields", "opening", code=1))
        # a checkpoint of the other kind, whose state has other numbers
        closed = ("-fault_slip_components", 2, "-fault_initial", "traction")
        self.fault(*grid, *OPENS, "-fault_checkpoint", "open")
        self.fault(*grid, *closed, "-fault_checkpoint", "closed")
        self.assertIn("opening is no", self.fault(*grid, *closed, "-fault_restart", "open", code=1))
        self.assertIn("opening is yes", self.fault(*grid, *OPENS, "-fault_restart", "closed", code=1))
        with h5py.File(self.path("cells.h5"), "w") as file:
            file["cells"] = [[1000.0 * k, 0, 6000, 1000, 1000] for k in range(2)]
            file["cells"].attrs["columns"] = "x y z length width"
        for average in ("cell", "whole"):
            self.assertIn(f"-fault_stiffness_average {average} supports only triangles",
                          self.fault("-fault_mesh", "cells.h5", "-fault_slip_components", 2,
                                   "-fault_stiffness_average", average, code=1))


if __name__ == "__main__":
    unittest.main()
