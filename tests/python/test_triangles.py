"""Faults of triangles: what a run on them is against rectangles, turned, on several ranks, from every kind of file, and
through the vertical."""

import os
import sys
import unittest

from scripts import BUILD, SOURCE, FaultTest
import h5py
import numpy as np

from meshfiles import gmsh, enu, joined, plane, view, write_gmsh, write_hdf5

sys.path.insert(0, os.path.join(SOURCE, "tests", "benchmarks"))
import crack
import crack_triangles

# rate-and-state thrusting under load, which knows normal stress that follows slip
THRUST = ("-fault_friction_law", "rate_and_state", "-fault_normal_stress", "50e6", "-fault_normal_stress_gradient", "0",
          "-fault_rake", "90", "-fault_loading_rate", "1e-9", "-fault_friction_slip", "0.05", "-fault_thickness",
          "4000", "-ts_max_time", "1e7")
BASE = plane((4, 3), (500.0, 400.0), 20, 60, (0, 0, 100))


def turned(vertices, angle, shift):
    """About the vertical, and moved"""
    a = np.radians(angle)
    x, y, z = vertices.T
    return np.column_stack([np.cos(a) * x - np.sin(a) * y, np.sin(a) * x + np.cos(a) * y, z]) + shift


class Run(FaultTest):
    def end(self, mesh, *options, ranks=1, name="out.h5"):
        """Last entry of each field, and the mesh."""
        self.fault("-fault_mesh", mesh, *THRUST, "-fault_output_fields",
                   "slip_rate,slip,displacement,traction,normal_stress", *options, "-fault_output",
                   name, "-fault_output_overwrite", ranks=ranks)
        with h5py.File(self.path(name)) as file:
            last = {key: data[-1] for key, data in file["fields"].items() if key != "time"}
            return last, {key: data[()] for key, data in file["mesh"].items()}

    def close(self, got, expected, share=1e-9):
        """1e-9 of the largest: stiffnesses differ by rounding, and steps depend on errors continuously"""
        for name, values in expected.items():
            np.testing.assert_allclose(got[name], values, rtol=0, atol=share * np.abs(values).max(), err_msg=name)

    def test_cells_of_two_triangles_are_the_grid(self):
        """Both take stress at centres, whose error of the slip goes with the size of a cell and is another one on
        triangles: the difference halves with the cells. Measured at 8 x 6 and 16 x 12 cells: mean slip of a stress drop
        -4.0 and -2.1 %, of a rupture from the instability -8.6 and -4.4 %. A wrong entry or area is off by the same
        share at every size."""
        for options, most in ((("-fault_initial", "rest", "-fault_stiffness_scaling", "mean_slip",
                                "-fault_normal_coupling", "no", "-ts_max_steps", 1,
                                "-ts_max_time", "1e-3", "-fault_viscosity", "radiation"), 0.05),
                              (("-ts_max_time", 30), 0.1)):
            off = []
            for n in (1, 2):
                grid = ("-fault_nx", 8 * n, "-fault_nz", 6 * n, "-fault_length_x", 4000, "-fault_length_z", 2400,
                        "-fault_depth_top", 1000, "-fault_dip", 60)
                write_hdf5(self.path("mesh.h5"), *plane((8 * n, 6 * n), (500.0 / n, 400.0 / n), 0, 60, (0, 0, 1000)))
                slip = []
                for mesh in (grid, ("-fault_mesh", "mesh.h5")):
                    self.fault(*mesh, "-fault_rake", 90, "-fault_thickness", 4000, "-fault_output", "out.h5",
                               "-fault_output_overwrite", *options)
                    with h5py.File(self.path("out.h5")) as file:
                        slip.append(file["run"].attrs["stiffness_scaling_factor"] if most < 0.1
                                    else file["result"].attrs["mean_slip"])
                off.append(slip[1] / slip[0] - 1)
            self.assertLess(abs(off[0]), most)
            self.assertTrue(0.4 < off[1] / off[0] < 0.6, off)

    def test_the_file_is_the_output(self):
        """Vertices and corners of the output are those of the file, the latter perhaps turned over, with the normal (P2
        - P1) x (P3 - P1) upward; the old columns describe them."""
        vertices, triangles = BASE
        write_hdf5(self.path("mesh.h5"), vertices, triangles, fault=np.arange(len(triangles)) % 2 + 4,
                   names="4 one; 5 other")
        _, mesh = self.end("mesh.h5")
        np.testing.assert_array_equal(np.sort(mesh["triangles"], axis=1), np.sort(triangles, axis=1))
        np.testing.assert_array_equal(mesh["vertices"], vertices)
        corners = mesh["vertices"][mesh["triangles"]]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.assertTrue((normal[:, 2] < 0).all())
        np.testing.assert_allclose(0.5 * np.linalg.norm(normal, axis=1), mesh["length"] * mesh["width"], rtol=1e-12)
        np.testing.assert_allclose(np.column_stack([mesh[k] for k in "xyz"]), corners.mean(axis=1), rtol=1e-12)
        np.testing.assert_allclose(mesh["strike"], 20, rtol=1e-12)
        with h5py.File(self.path("out.h5")) as file:
            self.assertEqual(file["mesh/fault"].attrs["names"], b"4 one; 5 other")
            np.testing.assert_array_equal(file["xdmf/points"][()] * (1, 1, -1), vertices)
            np.testing.assert_array_equal(file["xdmf/cells"][()], mesh["triangles"])
        self.assertIn(f'TopologyType="Triangle" NumberOfElements="{len(triangles)}"', self.content("out.h5.xdmf2"))
        from slipstep import Run as Output
        run = Output(self.path("out.h5"))
        self.assertEqual([(label, len(cells)) for label, cells in run.planes], [(4, 12), (5, 12)])
        # read again, the output's own mesh is the same fault
        write_hdf5(self.path("again.h5"), mesh["vertices"], mesh["triangles"])
        again = self.end("again.h5", name="again_out.h5")[1]
        for name in ("triangles", "strike", "dip", "x", "length"):
            np.testing.assert_array_equal(again[name], mesh[name])

    def test_turned_and_moved(self):
        write_hdf5(self.path("mesh.h5"), *BASE)
        first, mesh = self.end("mesh.h5")
        write_hdf5(self.path("mesh.h5"), turned(BASE[0], 77, (3e5, -4e5, 0)), BASE[1])
        second, other = self.end("mesh.h5")
        self.close(second, first)
        np.testing.assert_allclose(other["strike"], mesh["strike"] + 77, rtol=1e-9)

    def test_ranks_and_storage(self):
        """K of 1, 2 and 4 ranks in the order of the file to 1e-9, symmetric; hierarchical storage, of which 384
        triangles have blocks of low rank, gives the run of the dense one to ten times its tolerance of blocks."""
        write_hdf5(self.path("mesh.h5"), *joined(plane((16, 8), (250.0, 300.0), 20, 60, (0, 0, 100)),
                                                 plane((16, 4), (250.0, 300.0), 70, 40, (3e3, 9e3, 500))))
        first = None
        for ranks in (1, 2, 4):
            last, _ = self.end("mesh.h5", "-fault_stiffness_view", f"binary:{ranks}", "-fault_operator", "dense",
                               ranks=ranks)
            K = view(self.path(str(ranks)), 384)
            np.testing.assert_array_equal(K, K.T)
            if first is None:
                first, dense = K, last
            self.assertLess(np.abs(K - first).max(), 1e-9 * np.abs(first).max())
            self.close(last, dense)
        for ranks in (1, 2, 4):
            hierarchical, _ = self.end("mesh.h5", "-fault_operator", "hmat", "-fault_hmat_tolerance", "1e-7",
                                       ranks=ranks)
            self.close(hierarchical, dense, 1e-6)

    def test_all_kinds_of_files(self):
        """Gmsh 2.2 and 4.1, as text and in bytes, and HDF5 have the same K and normal stress to the bit: frames only
        exchange numbers."""
        vertices, triangles = joined(BASE, plane((2, 2), (500.0, 400.0), 60, 45, (0, 5000, 200)))
        label = np.where(np.arange(len(triangles)) < len(BASE[1]), 7, 3)
        write_hdf5(self.path("mesh.h5"), vertices, triangles, fault=label)
        write_hdf5(self.path("enu.h5"), enu(vertices) / 1000, triangles, fault=label)
        last, mesh = self.end("mesh.h5", "-fault_stiffness_view", "binary:hdf5")
        K = view(self.path("hdf5"), len(triangles))
        for version in ("2.2", "4.1"):
            for binary in (False, True):
                with self.subTest(version=version, binary=binary):
                    write_gmsh(self.path("mesh.msh"), version, binary, vertices, triangles, label,
                               names=((2, 3, "south"), (1, 3, "edge"), (2, 7, "north; or so")), length=5)
                    other, own = self.end("mesh.msh", "-fault_stiffness_view", "binary:gmsh")
                    np.testing.assert_array_equal(view(self.path("gmsh"), len(triangles)), K)
                    np.testing.assert_array_equal(other["normal_stress"], last["normal_stress"])
                    np.testing.assert_array_equal(own["fault"], label)
                    self.assertEqual(self.get("out.h5", "mesh/fault@names"), b"3 south; 7 north  or so")
        # by options, in another frame and unit: to rounding of a thousandth
        other, _ = self.end("enu.h5", "-fault_mesh_frame", "enu", "-fault_mesh_unit", "km", "-fault_stiffness_view",
                            "binary:enu")
        self.assertLess(np.abs(view(self.path("enu"), len(triangles)) - K).max(), 1e-12 * K.max())
        write_hdf5(self.path("end.h5"), vertices[:, [1, 0, 2]], triangles, fault=label)
        self.end("end.h5", "-fault_mesh_frame", "end", "-fault_stiffness_view", "binary:end")
        np.testing.assert_array_equal(view(self.path("end"), len(triangles)), K)

    def test_rectangles_of_gmsh(self):
        """Quadrilaterals that are rectangles are the list of cells."""
        vertices, _ = plane((3, 2), (500.0, 400.0), 20, 60, (0, 0, 100))
        cells = np.array([[p, p + 1, p + 5, p + 4] for p in (0, 1, 2, 4, 5, 6)])
        write_gmsh(self.path("mesh.msh"), "4.1", False, vertices, cells, np.ones(6, int))
        first, mesh = self.end("mesh.msh")
        rows = np.column_stack([vertices[cells].mean(axis=1), np.full((6, 4), [500, 400, 20, 60])])
        np.testing.assert_allclose(np.column_stack([mesh[k] for k in ("x", "y", "z", "length", "width", "strike",
                                                                      "dip")]), rows, rtol=1e-12)
        self.hdf5("cells.h5", units={"cells": "m"}, cells=rows)
        self.close(self.end("cells.h5")[0], first)

    def test_faults_of_a_meshed_volume(self):
        """Tetrahedra, edges and points beside a physical surface are the rest of a model, and so is a surface of no
        group."""
        vertices, triangles = BASE
        points = np.concatenate([enu(vertices), [[0, 0, 9e3], [1e4, 0, 9e3], [0, 1e4, 9e3]]])
        n = len(vertices)
        rest = [(15, 0, [0]), (1, 0, [0, 1]), (4, 0, [0, n, n + 1, n + 2]), (2, 9, [n, n + 1, n + 2])]
        own = [(2, 5, [int(k) for k in t]) for t in triangles]
        for version in ("2.2", "4.1"):
            self.put("mesh.msh", gmsh(version, False, points, rest + own, groups={5: (5,), 9: ()}))
            _, mesh = self.end("mesh.msh")
            np.testing.assert_array_equal(mesh["vertices"], vertices)
            self.assertEqual(set(mesh["fault"]), {5})

    def test_a_surface_through_the_vertical(self):
        """A fault that dips with 80 degrees and below with 100 has one strike and one hanging wall. Its lower part as a
        fault of its own dips the other way, with the other strike, and slip up its dip has the other sign: the same
        run, by a field of rakes, and the same ground. 1e-9 as directions come by other angles."""
        down = np.array([0, np.cos(np.radians(80)), np.sin(np.radians(80))])
        upper = plane((4, 3), (500.0, 300.0), 0, 80, (0, 0, 100))
        lower = plane((4, 2), (500.0, 300.0), 0, 100, np.array([0, 0, 100]) + 900 * down)
        vertices, triangles = joined(upper, lower)
        lies = np.arange(len(triangles)) >= len(upper[1])
        ground = ("-fault_surface_stations", "700,900;-4e3,5e3")
        rake = np.full(len(triangles), 60.0)
        last = []
        for name, label in (("one", np.zeros(len(triangles), int)), ("two", lies.astype(int))):
            write_hdf5(self.path("mesh.h5"), vertices, triangles, fault=label)
            self.hdf5("fields.h5", rake=np.where(lies & (name == "two"), -rake, rake))
            fields, mesh = self.end("mesh.h5", "-fault_parameters", "fields.h5", *ground, name=f"{name}.h5")
            last.append(fields)
            np.testing.assert_allclose(mesh["dip"], np.where(lies, 100 if name == "one" else 80, 80), rtol=1e-12)
            np.testing.assert_allclose(mesh["strike"] % 360, np.where(lies & (name == "two"), 180, 0), atol=1e-9)
        # the merged vertices of the joint have 5 fewer
        self.assertEqual(len(mesh["vertices"]), len(vertices) - 5)
        self.close(last[1], last[0])
        with h5py.File(self.path("one.h5")) as one, h5py.File(self.path("two.h5")) as two:
            for k in "01":
                moved = one[f"surface/{k}/displacement"][-1]
                np.testing.assert_allclose(two[f"surface/{k}/displacement"][-1], moved, rtol=0,
                                           atol=1e-9 * np.abs(moved).max())

    def test_the_ground_far_away(self):
        """At 25 lengths of a fault displacement goes with its moment: that of triangles and of the grid per mean
        displacement agree to what quadrupoles leave, (1/25)^2 of the difference of both distributions of slip, which is
        below a tenth: 2e-4."""
        ground = ("-fault_surface_stations", "6e4,8e4;-1e5,2e4")
        per = []
        self.fault("-fault_nx", 8, "-fault_nz", 6, "-fault_length_x", 4000, "-fault_length_z", 2400, "-fault_depth_top",
                   1000, "-fault_dip", 60, "-fault_output", "grid.h5", *ground, *THRUST)
        write_hdf5(self.path("mesh.h5"), *plane((8, 6), (500.0, 400.0), 0, 60, (0, 0, 1000)))
        self.end("mesh.h5", *ground)
        for name in ("grid.h5", "out.h5"):
            with h5py.File(self.path(name)) as file:
                u = file["fields/displacement"]
                moved = u[-1].mean() - u[0].mean()
                per.append(np.array([file[f"surface/{k}/displacement"][-1] for k in "01"]) / moved)
        np.testing.assert_allclose(per[1], per[0], rtol=0, atol=2e-4 * np.abs(per[0]).max())

    def test_stations(self):
        """The triangle that contains the point; x,z of a surface that is there twice needs y, and so may a point be off
        a surface by a tenth of a triangle."""
        vertices, triangles = BASE
        write_hdf5(self.path("mesh.h5"), vertices, triangles)
        centre = vertices[triangles].mean(axis=1)
        along = np.array([np.cos(np.radians(20)), np.sin(np.radians(20))])
        points = [f"{float(centre[k, :2] @ along)!r},{float(centre[k, 2])!r}" for k in (0, 7, 23)]
        points.append(",".join(repr(float(c)) for c in centre[11] + [0, 0, 20]))
        points.append(",".join(repr(float(c)) for c in vertices[6]))
        self.end("mesh.h5", "-fault_stations", ";".join(points))
        with h5py.File(self.path("out.h5")) as file:
            cells = [int(file[f"stations/{k}"].attrs["cell"]) for k in range(5)]
            self.assertEqual(cells[:4], [0, 7, 23, 11])
            self.assertIn(6, triangles[cells[4]])
            np.testing.assert_array_equal(file["stations/1/slip"][-1], file["fields/slip"][-1][7])
        outside = self.fault("-fault_mesh", "mesh.h5", *THRUST, "-fault_output", "out.h5", "-fault_stations",
                             "0,0,2000", code=1)
        self.assertIn("-fault_stations", outside)
        write_hdf5(self.path("mesh.h5"), *joined(BASE, (vertices + [-3000 * along[1], 3000 * along[0], 0], triangles)))
        twice = self.fault("-fault_mesh", "mesh.h5", *THRUST, "-fault_output", "out.h5", "-fault_stations", points[0],
                           code=1)
        self.assertIn("-fault_stations", twice)

    def test_a_restart(self):
        """To the bit, stations and ground included; a mesh with one vertex moved is another one."""
        write_hdf5(self.path("mesh.h5"), *BASE)
        ground = ("-fault_surface_stations", "700,900", "-fault_stations", "300,300", "-ts_type", "adams",
                  "-ts_max_time", "3e8")
        whole, _ = self.end("mesh.h5", *ground, name="whole.h5")
        steps = ("-fault_checkpoint", "state.h5", "-fault_output", "part.h5")
        self.fault("-fault_mesh", "mesh.h5", *THRUST, *ground, *steps, "-ts_max_steps", 3, code=3)
        moved = BASE[0] + np.where(np.arange(len(BASE[0]))[:, None] == 7, 1e-3, 0)
        write_hdf5(self.path("moved.h5"), moved, BASE[1])
        other = self.fault("-fault_mesh", "moved.h5", *THRUST, *ground, "-fault_restart", "state.h5", "-fault_output",
                           "part.h5", code=1)
        self.assertIn("mesh", other)
        self.fault("-fault_mesh", "mesh.h5", *THRUST, *ground, "-fault_restart", "state.h5", "-fault_output", "part.h5",
                   ranks=1)
        with h5py.File(self.path("whole.h5")) as one, h5py.File(self.path("part.h5")) as two:
            for group in ("series", "stations/0", "surface/0"):
                for name in one[group]:
                    np.testing.assert_array_equal(one[group][name], two[group][name], err_msg=name)
            np.testing.assert_array_equal(one["fields/slip"][-1], two["fields/slip"][-1])

    def test_maps(self):
        """Each fault is seen across its mean plane, along its strike and down its dip: corners of a plane keep their
        distances, to 1e-9 of 2 km."""
        write_hdf5(self.path("mesh.h5"), *joined(BASE, plane((2, 2), (500.0, 400.0), 70, 90, (3e3, 9e3, 500))),
                   fault=np.repeat([4, 2], [24, 8]))
        self.end("mesh.h5")
        from slipstep.plots.maps import planes_of
        from slipstep import Run as Output
        run = Output(self.path("out.h5"))
        first, second = planes_of(run)[::-1]
        self.assertEqual((len(first.cells), len(second.cells), first.x.shape), (24, 8, (3, 24)))
        self.assertIn("fault 4", first.name)
        np.testing.assert_allclose((np.ptp(first.x), np.ptp(first.z), first.z.min()), (2.0, 1.2, 0), atol=2e-9)
        np.testing.assert_allclose((np.ptp(second.x), np.ptp(second.z), second.z.min()), (1.0, 0.8, 0.5), atol=2e-9)
        areas = 0.5 * np.abs((first.x[1] - first.x[0]) * (first.z[2] - first.z[0]) - (first.x[2] - first.x[0])
                             * (first.z[1] - first.z[0]))
        np.testing.assert_allclose(areas, 0.1, rtol=1e-9)
        done = self.script("plot-run", self.path("out.h5"), "--figure", self.path("run.png"))
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_whole_is_refused(self):
        write_hdf5(self.path("mesh.h5"), *BASE)
        error = self.fault("-fault_mesh", "mesh.h5", *THRUST, "-fault_stiffness_average", "whole", code=1)
        self.assertIn("-fault_stiffness_average whole", error)

    def test_crack_of_averages(self):
        """Eshelby's circular crack, 10 triangles across that have next to nothing in common: within 0.7 of the radius
        averages over cells leave 1.1 to 1.4 % of the largest slip, which is the 1/across^2 of smooth slip, for any
        rake; stress at centroids leaves more than ten times as much.
        Rakes differ by the mesh only, which is the same in all directions: by a tenth of the error."""
        points, triangles = crack_triangles.lattice(10, 0.25)
        write_hdf5(self.path("mesh.h5"), np.stack([points[:, 0], 0 * points[:, 0], crack.DEPTH + points[:, 1]], axis=1),
                   triangles)
        error = {}
        for average, rake in (("cell", 0), ("cell", 37), ("cell", 90), ("centre", 37)):
            S = crack.stiffness(BUILD, self.path("mesh.h5"), len(triangles), average, 0.25, self.folder.name,
                                "-fault_rake", str(rake))
            np.testing.assert_allclose(S, S.T, rtol=0, atol=1e-12 * S.max())
            error[average, rake] = crack_triangles.measure(points, triangles, S, 0.25)[1]
        inside = [error["cell", rake] for rake in (0, 37, 90)]
        self.assertLess(max(inside), 0.02)
        self.assertLess(np.ptp(inside), 0.003)
        self.assertGreater(error["centre", 37], 10 * max(inside))


if __name__ == "__main__":
    unittest.main()
