#!/usr/bin/env python3
"""Displacement and stress by the program elastic, against published numbers; and maps of them by slipstep surface,
against what a run records at its own points of the ground."""

import csv
import os
import sys
import unittest

from scripts import BUILD, TWO_PLANES, FaultTest, PictureTest

import h5py
import numpy as np

from meshfiles import joined, plane, write_hdf5
from slipstep import Catalogue, Run
from slipstep.geometry.cells import corners_of
from slipstep.geometry.surface import Elastic, Source, look_vector, slip_of_event, slip_of_run

ELASTIC = os.path.join(BUILD, "bin", "elastic")
# DC3D (Okada 1992) in double precision, lambda = mu: depth 10, dip 30, 10 along strike and 8 along dip, unit slip.
# Rows: displacement and its derivatives along x, y and z; Okada's y points to the left of the strike and his z up.
DC3D = [((1, 0, 0), (3.00, 1.00, -6.00), [[1.406147270713609e-01, -1.669708433372420e-02, 7.485063667815837e-02],
                                          [-1.440317225441210e-02, -7.374407949459760e-03, 2.825356697517980e-02],
                                          [-7.867391061529708e-04, 7.473642128086010e-03, -4.264382186713333e-03],
                                          [-4.671192005346890e-02, 5.094750031777914e-03, -4.882063345343449e-03]]),
        ((0, 1, 0), (-2.00, -4.00, -12.00), [[2.955032880741316e-03, 1.834326652701142e-01, -5.771583782856805e-02],
                                             [-1.942729769894523e-03, 3.888685188564652e-03, -2.708500868986128e-03],
                                             [-4.121915438935045e-03, 6.794160185865560e-02, -7.002494174521352e-02],
                                             [7.592653821992374e-03, 3.912635358546211e-01, 3.239447672084607e-02]])]
SIGN = np.array([1, -1, -1])
# Its sixteen digits, and corners that cancel to some of the last ones
DIGITS = 1e-13
GRID = """-fault_nx 6 -fault_nz 5 -fault_length_x 12e3 -fault_length_z 8e3 -fault_strike 20 -fault_dip 30
    -fault_depth_top 500 -fault_friction_law rate_and_state -fault_normal_stress 20e6 -fault_friction_b 0.005
    -fault_normal_stress_gradient 0 -fault_loading_rate 1e-9 -fault_initial_rate 1e-10 -ts_max_time 3y
    -fault_output run.h5""".split()
POINTS = "2000,3000;-4000,2500;1e4,6e3"


class SurfaceTest(FaultTest, PictureTest):
    def write(self, name, cells, slip, points):
        self.hdf5(name, cells=np.array(cells, float), slip=np.array(slip, float), points=np.array(points, float))

    def elastic(self, name, *options, ranks=1):
        self.fault("-elastic_input", name, "-elastic_output", "out.h5", *options, ranks=ranks, program=ELASTIC)
        with h5py.File(self.path("out.h5")) as file:
            return {key: (data[()], data.attrs["units"].decode()) for key, data in file.items()}


class Program(SurfaceTest):
    def test_published(self):
        """Displacement, and the stress 2 G strain + lambda tr(strain) with lambda = G = 1."""
        for slip, at, rows in DC3D:
            self.write("in.h5", [[0, 0, 10, 10, 8, 0, 30]], [slip], [np.array(at) * SIGN])
            found = self.elastic("in.h5", "-elastic_shear_modulus", "1", "-elastic_stress")
            u, gradient = np.array(rows[0]) * SIGN, (np.array(rows[1:]) * np.outer(SIGN, SIGN)).T
            stress = gradient + gradient.T + np.trace(gradient) * np.eye(3)
            self.assertEqual((found["displacement"][1], found["stress"][1], sorted(found)),
                             ("m", "Pa", ["displacement", "stress"]))
            np.testing.assert_allclose(found["displacement"][0][0], u, rtol=0, atol=DIGITS)
            np.testing.assert_allclose(found["stress"][0][0], stress[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)], rtol=0,
                                       atol=DIGITS)

    def test_sum_ranks_and_receiver(self):
        """A rectangle is its two halves, on any number of ranks; the traction is that of the stress on the receiver, by
        hand."""
        strike, dip, rake = np.radians([50, 40, 70])
        half = 2.0 * np.array([np.cos(strike), np.sin(strike)])
        halves = [[*(sign * half), 10, 4, 6, 50, 40] for sign in (1, -1)]
        # above the rectangle's upper edge, 8.1
        points = np.random.default_rng(1).uniform([-20, -20, 0], [20, 20, 4], (7, 3))
        slip, options = [0.5, 1.5, 0.2], ("-elastic_receiver", "50,40,70", "-elastic_shear_modulus", "3",
                                          "-elastic_poisson_ratio", "0.3")
        self.write("one.h5", [[0, 0, 10, 8, 6, 50, 40]], [slip], points)
        self.write("two.h5", halves + [[0, 0, 10, 1, 1, 0, 90]], [slip, slip, [0, 0, 0]], points)
        one = self.elastic("one.h5", *options)
        for ranks in (1, 2, 4):
            two = self.elastic("two.h5", *options, ranks=ranks)
            for key, (data, _) in one.items():  # a sum of two rounds once more
                np.testing.assert_allclose(two[key][0], data, rtol=0, atol=1e-13 * np.abs(data).max())
        along = np.array([np.cos(strike), np.sin(strike), 0])
        right = np.array([-np.sin(strike), np.cos(strike), 0])
        up = -np.cos(dip) * right - np.sin(dip) * np.array([0, 0, 1])
        normal = np.sin(dip) * right - np.cos(dip) * np.array([0, 0, 1])  # into the hanging wall, which is above
        for stress, traction in zip(one["stress"][0], one["traction"][0]):
            tensor = stress[[[0, 3, 4], [3, 1, 5], [4, 5, 2]]]
            directions = [np.cos(rake) * along + np.sin(rake) * up, np.cos(rake) * up - np.sin(rake) * along, normal]
            np.testing.assert_allclose(traction, [-d @ tensor @ normal for d in directions], rtol=0,
                                       atol=1e-13 * np.abs(stress).max())

    def test_triangles(self):
        """A rectangle is its two triangles, on any number of ranks, with corners in any order; from its other side,
        which is the opposite strike, slip up dip has the other sign. 1e-10: both closed forms lose a few digits where
        their edges cancel, a hundred times less."""
        points = np.random.default_rng(2).uniform([-20, -20, 0], [20, 20, 4], (9, 3))
        options = ("-elastic_receiver", "50,40,70", "-elastic_shear_modulus", "3", "-elastic_poisson_ratio", "0.3")
        for strike, dip in ((50, 40), (50, 90), (230, 90)):
            cell = np.array([[1, 2, 10, 8, 6, strike, dip]], float)
            slip = np.array([0.5, 1.5, 0.2])
            self.write("one.h5", cell, [slip], points)
            wanted = self.elastic("one.h5", *options)
            # into the foot wall: the corners go clockwise around the other one
            normal = np.cross(*np.diff(corners_of(cell)[0, :3], axis=0))
            triangles = [[0, 2, 1], [3, 0, 2], [0, 1, 2]]  # the last one without slip
            for side, sign in ((None, 1 if strike < 180 else -1), (-normal, 1), (normal, -1)):
                own = slip * (1, sign, 1)
                with h5py.File(self.path("two.h5"), "w") as file:
                    file["vertices"], file["triangles"], file["points"] = corners_of(cell)[0], triangles, points
                    file["slip"] = [own, own, 0 * own]
                    if side is not None:
                        file["hanging_wall"] = np.tile(side, (3, 1))
                for ranks in (1, 2) if side is None else (1,):
                    found = self.elastic("two.h5", *options, ranks=ranks)
                    self.assertEqual(sorted(found), sorted(wanted))
                    for key, (data, unit) in wanted.items():
                        self.assertEqual(found[key][1], unit)
                        np.testing.assert_allclose(found[key][0], data, rtol=0, atol=1e-10 * np.abs(data).max(),
                                                   err_msg=f"{strike} {dip} {sign}")

    def test_errors_of_triangles(self):
        good = {"vertices": [[0, 0, 1], [4, 0, 1], [0, 0, 5]], "triangles": [[0, 1, 2]], "slip": [[1, 0, 0]],
                "points": [[0, 9, 0]]}
        for message, change in (("neither /cells nor /triangles", {"triangles": None}),
                                ("/vertices", {"vertices": None}),
                                ("/cells and /triangles", {"cells": [[0, 0, 10, 10, 8, 0, 30]]}),
                                ("/triangles, row 0 has the vertex 3", {"triangles": [[0, 1, 3]]}),
                                ("/triangles, row 0 has the vertex 0.5", {"triangles": [[0, 0.5, 2]]}),
                                ("/triangles, row 0 has the vertex -1", {"triangles": [[0, 1, -1]]}),
                                ("/triangles", {"triangles": [[0, 1]]}),
                                ("/slip", {"slip": [[1, 0, 0], [1, 0, 0]]}),
                                ("/hanging_wall", {"hanging_wall": [[0, 1, 0], [0, 1, 0]]}),
                                ("lies in the plane of a triangle", {"hanging_wall": [[1, 0, 0]]}),
                                ("above the ground", {"vertices": [[0, 0, -1], [4, 0, 1], [0, 0, 5]]})):
            with h5py.File(self.path("in.h5"), "w") as file:
                for name, data in {**good, **change}.items():
                    if data is not None:
                        file[name] = np.array(data, float)
            found = self.fault("-elastic_input", "in.h5", "-elastic_output", "out.h5", program=ELASTIC, code=1)
            self.assertIn(message, found)
            self.assertEqual(found.count("\n"), 1, found)

    def test_rock(self):
        """That of the input's attributes, of the options before those, or the default, whichever is said; of Okada's
        solution stress is G times a function of Poisson's ratio."""
        cells, slip, at = [[0, 0, 10, 10, 8, 0, 30]], [[1, 0, 0]], [[3, 4, 5]]
        stress = {}
        for shear, poisson, attributes, options in ((30e9, 0.25, {}, ()),
                                                    (41e9, 0.3, {"shear_modulus": 41e9, "poisson_ratio": 0.3}, ()),
                                                    (7.5, 0.3, {"shear_modulus": 41e9, "poisson_ratio": 0.3},
                                                     ("-elastic_shear_modulus", "7.5")),
                                                    (41e9, 0.25, {"shear_modulus": 41e9}, ()),
                                                    (30e9, 0.3, {"poisson_ratio": 0.1},
                                                     ("-elastic_poisson_ratio", "0.3"))):
            self.write("in.h5", cells, slip, at)
            with h5py.File(self.path("in.h5"), "a") as file:
                file.attrs.update(attributes)
            said = self.fault("-elastic_input", "in.h5", "-elastic_output", "out.h5", "-elastic_stress", *options,
                              ranks=2, program=ELASTIC)
            words = [option if (option := f"-elastic_{name}") in options else "in.h5" if name in attributes
                     else "by default" for name in ("shear_modulus", "poisson_ratio")]
            self.assertIn(f"shear modulus {shear:g} Pa ({words[0]}), Poisson's ratio {poisson:g} ({words[1]})\n", said)
            found = self.get("out.h5", "stress") / shear
            np.testing.assert_allclose(found, stress.setdefault(poisson, found), rtol=1e-13)  # roundings of one product
        self.assertGreater(np.abs(stress[0.3] - stress[0.25]).max(), 1e-3 * np.abs(stress[0.25]).max())
        for name, value in (("shear_modulus", -1.5), ("poisson_ratio", 0.75)):
            self.write("in.h5", cells, slip, at)
            with h5py.File(self.path("in.h5"), "a") as file:
                file.attrs[name] = value
            found = self.fault("-elastic_input", "in.h5", "-elastic_output", "none.h5", program=ELASTIC, code=1)
            self.assertRegex(found, rf"attribute {name} of / in in.h5 is {value:g}, expected a number")
            self.assertEqual(found.count("\n"), 1, found)

    def test_errors(self):
        self.write("in.h5", [[0, 0, 10, 10, 8, 0, 30]], [[1, 0, 0]], [[0, 0, 0]])
        self.write("high.h5", [[0, 0, 1, 10, 8, 0, 30]], [[1, 0, 0]], [[0, 0, 0]])
        self.write("slip.h5", [[0, 0, 10, 10, 8, 0, 30]], [[1, 0, 0], [1, 0, 0]], [[0, 0, 0]])
        files = ["-elastic_input", "in.h5", "-elastic_output", "out.h5"]
        for message, *options in (("-elastic_input and -elastic_output",),
                                  ("there is no option -elastic_outptu", "-elastic_outptu", "a"),
                                  ("cannot read no.h5", "-elastic_input", "no.h5", "-elastic_output", "out.h5"),
                                  ("-elastic_receiver", *files, "-elastic_receiver", "1,2"),
                                  ("-elastic_receiver", *files, "-elastic_receiver", "1,92,3"),
                                  ("-elastic_poisson_ratio is 0.5", *files, "-elastic_poisson_ratio", "0.5"),
                                  ("-elastic_shear_modulus is 0", *files, "-elastic_shear_modulus", "0"),
                                  ("in.h5 is read and written", *files[:3], "in.h5"),
                                  ("above the ground", "-elastic_input", "high.h5", *files[2:]),
                                  ("/slip", "-elastic_input", "slip.h5", *files[2:])):
            found = self.fault(*options, program=ELASTIC, code=1)
            self.assertIn(message, found)
            self.assertEqual(found.count("\n"), 1, found)
        self.assertFalse(os.path.exists(self.path("out.h5")))


class Maps(SurfaceTest):
    def run_of_grid(self):
        rake = np.linspace(60, 120, 30).reshape(5, 6)
        self.hdf5("rake.h5", rake=rake)
        self.fault(*GRID, "-fault_parameters", "rake.h5", "-fault_surface_stations", POINTS)
        return self.path("run.h5")

    def recorded(self, path):
        with h5py.File(path) as file:
            return np.array([file[f"surface/{k}/displacement"][-1] for k in range(len(file["surface"]))])

    def numbers(self, path, *options, name="n.h5"):
        self.plot("surface", path, "--figure", self.path("a.png"), "--numbers", self.path(name), "--spacing", "2",
                  *options)
        self.look(self.path("a.png"))
        return self.path(name)

    def test_what_a_run_records(self):
        """The points of a run, by the last entry of its fields: the same sums in another order."""
        path = self.run_of_grid()
        wanted = self.recorded(path)
        with h5py.File(self.numbers(path, "--points", "--look", "257", "39")) as file:
            found, seen = file["points/displacement"][...], file["points/line_of_sight"][...]
            np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-13 * np.abs(wanted).max())
            np.testing.assert_allclose(np.column_stack([file["points/x"], file["points/y"]]),
                                       [[2e3, 3e3], [-4e3, 2.5e3], [1e4, 6e3]])
            # satellite in the west by south, 39 degrees from the zenith
            look = [np.sin(np.radians(39)) * np.cos(np.radians(257)), np.sin(np.radians(39)) * np.sin(np.radians(257)),
                    -np.cos(np.radians(39))]
            self.assertTrue(look[0] < 0 and look[1] < 0)
            np.testing.assert_allclose(seen, found @ look, rtol=0, atol=1e-16)
            self.assertEqual(file["map/displacement"].shape, (len(file["map/x"]), len(file["map/y"]), 3))
            k = tuple(np.argmin(np.abs(file[f"map/{axis}"][...] - at)) for axis, at in (("x", 2e3), ("y", 3e3)))
            at = [file[f"map/{axis}"][i] for axis, i in zip("xy", k)]
            near = Elastic(slip_of_run(Run(path))).displacement(np.array([[*at, 0]]))[0]
            np.testing.assert_allclose(file["map/displacement"][k], near, rtol=0, atol=1e-13 * np.abs(wanted).max())
        with open(self.numbers(path, "--points", POINTS, "--components", name="n.csv"), encoding="utf-8") as file:
            head, *rows = csv.reader(file)
        self.assertEqual(head,
                         ["x [m]", "y [m]", "displacement_north [m]", "displacement_east [m]", "displacement_down [m]"])
        np.testing.assert_array_equal(np.array(rows, float)[:, 2:], found)

    def test_vectors(self):
        """Both components of slip, of a run with its points and of an event: vectors along strike and up dip, which
        turn where the load does not."""
        self.fault(*GRID, "-fault_rake", "50", "-fault_slip_components", "2", "-fault_friction_b", "0.03",
                   "-fault_friction_slip", "0.02", "-ts_max_time", "60y",
                   "-fault_surface_stations", POINTS, "-fault_catalogue", "events.h5", "-fault_catalogue_maps")
        wanted, source = self.recorded(self.path("run.h5")), slip_of_run(Run(self.path("run.h5")))
        self.assertEqual(source.slip.shape, (30, 2))
        rakes = np.degrees(np.arctan2(*source.slip.T[::-1]))
        self.assertGreater(np.ptp(rakes), 0.5)
        with h5py.File(self.numbers(self.path("run.h5"), "--points", "--components")) as file:
            np.testing.assert_allclose(file["points/displacement"], wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())
        catalogue = Catalogue(self.path("events.h5"))
        self.assertGreater(catalogue.count, 0)
        event, (onset, end) = slip_of_event(catalogue, 0), (catalogue.event[name][0] for name in ("onset", "end"))
        # between that of the steps within the event and that with the two in which it begins and ends: in these fields
        # are no straight lines
        run = Run(self.path("run.h5"))
        times = run.field("slip")[0]
        first, last = np.searchsorted(times, (onset, end))
        inner, outer = (slip_of_run(run, times[a], times[b]).slip for a, b in ((first, last - 1), (first - 1, last)))
        rounding = 1e-6 * np.abs(outer).max()  # and loading in the minute of the first step, 5e-8 m
        self.assertTrue((event.slip >= np.minimum(inner, outer) - rounding).all()
                        and (event.slip <= np.maximum(inner, outer) + rounding).all())
        self.assertGreater(np.abs(inner).max(), 0.7 * np.abs(outer).max())
        broke = np.isfinite(catalogue.map("rupture_time")[0].ravel())
        self.assertAlmostEqual(catalogue.event["rake"][0], np.degrees(np.arctan2(*event.slip[broke].sum(axis=0)[::-1])),
                               delta=1e-9)
        self.assertAlmostEqual(catalogue.event["moment"][0], 30e9 * 12e3 * 8e3 / 30
                               * np.linalg.norm(event.slip.sum(axis=0)), delta=1e-9 * catalogue.event["moment"][0])

    def test_windows(self):
        """Two windows add up to the whole; the outline of a grid is what its cells' free edges are."""
        path = self.run_of_grid()
        run = Run(path)
        end = run.field("displacement")[0][-1]
        whole, first, second = slip_of_run(run), slip_of_run(run, 0, 0.37 * end), slip_of_run(run, 0.37 * end, end)
        np.testing.assert_allclose(first.slip + second.slip, whole.slip, rtol=0,
                                   atol=1e-15 * np.abs(whole.slip).max() * 4)
        self.assertGreater(np.abs(first.slip).max(), 0)
        upper, others = whole.outline()
        whole.shape = None
        upper_edges, other_edges = whole.outline()
        self.assertEqual((len(upper_edges), len(other_edges)), (6, 2 * 5 + 6))
        np.testing.assert_allclose(upper_edges[[0, -1], [0, 1]], upper[0], atol=1e-9)
        corners = {tuple(np.round(corner)) for corner in other_edges.reshape(-1, 3)}
        self.assertTrue({tuple(np.round(corner)) for corner in others.reshape(-1, 3)} <= corners)
        self.assertAlmostEqual(whole.level(2500.0)[0, 0, 2], 2500)

    def test_mesh(self):
        """Planes of irregular cells that slip as they weaken."""
        self.make_mesh("mesh", TWO_PLANES)
        self.fault("-fault_mesh", "mesh", "-ts_max_time", "15", "-fault_output", "run.h5", "-fault_surface_stations",
                   POINTS)
        wanted = self.recorded(self.path("run.h5"))
        with h5py.File(self.numbers(self.path("run.h5"), "--points", "--components", "--receiver", "30", "70", "20",
                                    "--depth", "2")) as file:
            # two closed forms: that of strike slip, and that of any dip
            np.testing.assert_allclose(file["points/displacement"], wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())
            np.testing.assert_allclose(file["map/coulomb"], file["map/shear"][...] - 0.4 * file["map/normal"][...],
                                       rtol=0, atol=1e-6)
            self.assertEqual(file["map"].attrs["stress_depth"], 2000)

    def test_triangles(self):
        """Points of a run of triangles, on a fault that goes through the vertical, where some slip with the other
        wall's sign; a window of it is an event of its catalogue; where the triangles are at a depth, and their
        outline."""
        down = np.array([0, np.cos(np.radians(80)), np.sin(np.radians(80))])
        mesh = joined(plane((4, 3), (500.0, 300.0), 0, 80, (0, 0, 100)),
                      plane((4, 2), (500.0, 300.0), 0, 100, np.array([0, 0, 100]) + 900 * down))
        write_hdf5(self.path("mesh.h5"), *mesh)
        self.fault("-fault_mesh", "mesh.h5", "-fault_rake", "60", "-fault_friction_slip", "0.02", "-fault_output",
                   "run.h5", "-fault_catalogue", "events.h5",
                   "-fault_catalogue_maps", "-fault_surface_stations", POINTS)
        wanted = self.recorded(self.path("run.h5"))
        with h5py.File(self.numbers(self.path("run.h5"), "--points", "--look", "257", "39", "--components")) as file:
            # the run adds the same numbers in another order; cancellation between cells
            np.testing.assert_allclose(file["points/displacement"], wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())
        source = slip_of_run(Run(self.path("run.h5")))
        upper, others = source.outline()
        self.assertEqual((len(upper), len(others)), (4, 4 + 2 * 5))
        line = source.level(250.0)
        np.testing.assert_allclose(line[..., 2], 250)
        self.assertAlmostEqual(np.linalg.norm(line[:, 1] - line[:, 0], axis=1).sum(), 2000)
        event, window = slip_of_event(Catalogue(self.path("events.h5")), 0), Catalogue(self.path("events.h5")).event
        window = slip_of_run(Run(self.path("run.h5")), window["onset"][0], window["end"][0])
        np.testing.assert_array_equal(event.triangles, source.triangles)
        np.testing.assert_allclose(event.slip, window.slip, rtol=0, atol=0.02 * window.slip.max())  # as in test_event
        self.numbers(self.path("events.h5"), "--event", "1", "--receiver", "0", "80", "60")
        # at the centroid of a triangle in the middle, slip relieves its plane
        centre = event.cells[12:13]
        change, shear, _ = Elastic(event).coulomb(centre[:, :3], (*centre[0, 5:7], 60), 0.0)
        self.assertLess(shear[0], 0)
        self.assertEqual(change[0], shear[0])

    def test_event(self):
        """An event of a catalogue is the window of the run in which it was; slip that relieves a plane lowers its own
        Coulomb stress."""
        self.fault("-fault_nx", "6", "-fault_nz", "5", "-fault_output", "run.h5", "-fault_catalogue", "events.h5",
                   "-fault_catalogue_maps", "-ts_max_time", "30")
        event, catalogue = slip_of_event(Catalogue(self.path("events.h5")), 0), Catalogue(self.path("events.h5"))
        window = slip_of_run(Run(self.path("run.h5")), catalogue.event["onset"][0], catalogue.event["end"][0])
        np.testing.assert_array_equal(event.cells, window.cells)
        # entries are a step apart, and slip within a step is no straight line: a step has at most some hundredths of
        # all slip
        np.testing.assert_allclose(event.slip, window.slip, rtol=0, atol=0.02 * window.slip.max())
        self.numbers(self.path("events.h5"), "--event", "1", "--receiver", "0", "90", "0")
        centre = event.cells[13:14, :3]
        change, shear, _ = Elastic(event).coulomb(centre, (0, 90, 0), 0.4)
        self.assertLess(shear[0], 0)
        self.assertEqual(change[0], shear[0])  # strike slip leaves the normal stress of its own plane

    def test_arrows_have_shafts(self):
        """Of all lengths: heads end where vectors do, and are a share of them."""
        from slipstep.programs import surface
        _, axes = surface.plt.subplots()
        begin, vectors = np.zeros((4, 2)), np.array([[10.0, 0], [0, 0.5], [-1e-3, 1e-3], [0, 0]])
        surface.Picture.arrows(axes, begin, vectors, 100.0)
        shafts, heads = axes.collections[-2].get_segments(), [path.vertices[:3]
                                                              for path in axes.collections[-1].get_paths()]
        self.assertEqual((len(shafts), len(heads)), (3, 3))
        for vector, shaft, head in zip(vectors, shafts, heads):
            length = np.hypot(*vector)
            np.testing.assert_allclose(head[0], vector)
            foot = head[1:].mean(axis=0)
            self.assertLessEqual(np.hypot(*(head[0] - foot)), min(0.4 * length, 1.8) * (1 + 1e-9))
            self.assertLess(np.hypot(*(head[1] - head[2])), 0.4 * length)
            self.assertGreater(np.hypot(*(shaft[1] - shaft[0])), 0.6 * length)
        surface.plt.close("all")

    def test_pictures_of_one_file_have_names_of_their_own(self):
        from slipstep.programs import surface
        for options, suffix in (((), ""), (("--look", "257", "39"), "_look"),
                                (("--look", "257", "39", "--points", "1,2"), "_look_points"),
                                (("--event", "3"), "_event_3"),
                                (("--event", "largest", "--receiver", "0", "90", "0"), "_receiver")):
            with unittest.mock.patch.object(sys, "argv", ["slipstep surface", "run.h5", *options]):
                self.assertEqual(surface.suffix_of(surface.arguments()), suffix)

    def test_look(self):
        np.testing.assert_allclose(look_vector(0, 30), [0.5, 0, -np.sqrt(3) / 2], atol=1e-15)
        np.testing.assert_allclose(look_vector(90, 0), [0, 0, -1], atol=1e-15)

    def test_errors(self):
        self.fault("-fault_output", "run.h5", "-fault_kernel", "full_space", "-ts_max_time", "1")
        path = self.path("run.h5")
        self.refused("surface", "full space", path)
        self.fault("-fault_output", "run.h5", "-ts_max_time", "1")
        self.refused("surface", "--event .*run.h5", path, "--event", "1")
        self.refused("surface", "/fields is from 0 s to 1 s", path, "--window", "0", "2")
        self.refused("surface", "-fault_surface_stations", path, "--points")
        self.assertIn("2 of 3 points",
                      self.plot("surface", path, "--points", "1,1;900000,1;1,-900000", "--spacing", "1"))
        self.refused("surface", '--points: "1,b"', path, "--points", "1,1;1,b")
        self.put("p.txt", "# x y\n1 2\n3\n")
        self.refused("surface", 'p.txt, line 3: "3"', path, "--points", self.path("p.txt"))
        self.refused("surface", "no such file", self.path("no.h5"))
        for message, *options in (("--look has the incidence 90", "--look", "0", "90"),
                                  ("--receiver has the dip 91", "--receiver", "0", "91", "0"),
                                  ("--depth is that of planes", "--depth", "3"),
                                  ("--window is 2 1", "--window", "2", "1"),
                                  ("--spacing is 0", "--spacing", "0"),
                                  ("--ranks is 0", "--ranks", "0"),
                                  ("--friction is -1", "--friction", "-1"),
                                  ("--extent is 1 0 0 1", "--extent", "1", "0", "0", "1"),
                                  ("--numbers is a.txt", "--numbers", "a.txt"), ("--event is -1", "--event", "-1")):
            self.refused("surface", message, path, *options, code=2)
        source = Source("", np.array([[0, 0, 10e3, 1e3, 1e3, 0, 90]]), np.zeros(1), np.ones(1), 30e9, 0.25, "")
        with unittest.mock.patch.dict(os.environ, {"SLIPSTEP_BUILD": self.path("nowhere"), "PATH": ""}), \
                unittest.mock.patch("slipstep.modules.HERE", self.path("a/b/c")), self.assertRaisesRegex(
                    Exception, "elastic"):
            Elastic(source)
        debian = self.path("slipstep-elastic")  # as Debian's package calls it
        with open(debian, "w") as file:
            file.write("#!/bin/sh\n")
        os.chmod(debian, 0o755)
        with unittest.mock.patch.dict(os.environ, {"SLIPSTEP_BUILD": self.path("nowhere"),
                                                   "PATH": self.folder.name}), unittest.mock.patch(
                                                       "slipstep.modules.HERE", self.path("a/b/c")):
            self.assertEqual(Elastic(source).program, debian)


if __name__ == "__main__":
    unittest.main()
