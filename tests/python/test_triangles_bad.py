"""Files of triangles that are refused, by the one error that each must give, and unusual ones that are not."""

import struct
import subprocess
import unittest

from scripts import FAULT, FaultTest
import numpy as np

from meshfiles import enu, gmsh, joined, plane, write_hdf5

THRUST = ("-fault_friction_law", "rate_and_state", "-fault_normal_stress", "50e6", "-fault_normal_stress_gradient", "0",
          "-fault_rake", "90",
          "-fault_loading_rate", "1e-9", "-fault_friction_slip", "0.05", "-ts_max_time", "1e7", "-ts_max_steps", "1")
VERTICES, TRIANGLES = plane((4, 3), (500.0, 400.0), 20, 60, (0, 0, 100))
N, V = len(TRIANGLES), len(VERTICES)


def moved(row, place):
    vertices = VERTICES.copy()
    vertices[row] = place
    return vertices


def shifted(row, by):
    return moved(row, VERTICES[row] + by)


def corner(row, column, value):
    triangles = TRIANGLES.astype(float)
    triangles[row, column] = value
    return triangles


def beside(*corners):
    """BASE and one triangle more: of new vertices [m], or numbers of old ones"""
    vertices, last = VERTICES, []
    for c in corners:
        if not np.isscalar(c):
            vertices = np.concatenate([vertices, [c]])
            c = len(vertices) - 1
        last.append(c)
    return dict(vertices=vertices, triangles=np.concatenate([TRIANGLES, [last]]))


def mobius(n=12):
    """A strip of n cells across itself once, 2 km around"""
    vertices = []
    for k in range(n):
        a = 2 * np.pi * k / n
        radial = np.array([np.cos(a), np.sin(a), 0])
        across = np.cos(a / 2) * radial + np.sin(a / 2) * np.array([0, 0, 1])
        vertices += [2000 * radial + [0, 0, 3000] - 500 * across, 2000 * radial + [0, 0, 3000] + 500 * across]
    triangles = []
    for k in range(n):
        p, q, r, s = 2 * k, 2 * k + 1, 2 * k + 2, 2 * k + 3
        if k == n - 1:
            r, s = 1, 0
        triangles += [[p, q, s], [p, s, r]]
    return np.array(vertices), np.array(triangles)


CENTRE = VERTICES[TRIANGLES[5]].mean(axis=0)
NORMAL = np.cross(VERTICES[1] - VERTICES[0], VERTICES[5] - VERTICES[0])
NORMAL = NORMAL / np.linalg.norm(NORMAL)
# latitude, longitude, depth in km
LONLAT = np.column_stack([38 + 0.1 * (np.arange(V) // 5) + 0.02 * (np.arange(V) % 5), 138 + 0.25 * (np.arange(V) % 5),
                          9 + 7 * (np.arange(V) // 5)])
# in km, 38 and 138 km away
TALL = np.column_stack([38 + np.arange(V) % 5, 138 + 0.5 * (np.arange(V) % 5), 1 + 10 * (np.arange(V) // 5)])
ALONG = (VERTICES[1] - VERTICES[0]) / 500
DOWN = (VERTICES[5] - VERTICES[0]) / 400
MIRROR = VERTICES[1] + VERTICES[0] - VERTICES[5]  # beyond the upper edge of cell 0, above the ground

# What is wrong, what is written in HDF5, and what the error must say besides the name of the file.
BAD = {
    "triangles without vertices": (dict(vertices=None), "holds /triangles but no /vertices"),
    "vertices without triangles": (dict(triangles=None), "holds /vertices but no /triangles"),
    "rectangles and triangles": (dict(cells=[[0, 0, 900, 100, 100]]),
                                 "holds /cells and /triangles"),
    "two columns of vertices": (dict(vertices=VERTICES[:, :2]),
                                "/vertices in mesh.h5 has shape [20, 2]"),
    "four corners": (dict(triangles=np.column_stack([TRIANGLES, TRIANGLES[:, 0]])),
                     "has shape [24, 4]"),
    "no triangle": (dict(triangles=TRIANGLES[:0]), "/triangles in mesh.h5 has no rows"),
    "text": (dict(triangles=np.array([[b"a"] * 3])), "does not hold numbers"),
    "corners that are not whole": (dict(triangles=corner(3, 1, 2.5)),
                                   "row 3 of /triangles is 2.5"),
    "no corner": (dict(triangles=corner(3, 1, np.nan)), "row 3 of /triangles is nan"),
    "a vertex that is not there": (dict(triangles=corner(7, 2, V)), "triangle 7 has the vertex 20"),
    "numbers from 1": (dict(triangles=TRIANGLES + 1), "has the vertex 20"),
    "a negative vertex": (dict(triangles=corner(7, 0, -1)), "triangle 7 has the vertex -1"),
    "a vertex twice": (dict(triangles=corner(4, 1, TRIANGLES[4, 0])), "triangle 4 has the vertex 2 twice"),
    "two vertices in one place": (dict(vertices=moved(6, VERTICES[5])),
                                  "vertices 6 and 5 of triangle 1 are in one place"),
    "no depth": (dict(vertices=moved(6, [0, 0, np.nan])), "vertex 6 has z = nan m"),
    "an infinite vertex": (dict(vertices=moved(6, [np.inf, 0, 100])), "vertex 6 has x = inf m"),
    "too far": (dict(vertices=moved(6, [0, 5e7, 100])),
                "vertex 6 has y = 5e+07 m"),
    "no area": (dict(vertices=moved(6, 0.5 * (VERTICES[0] + VERTICES[1]))), "is a needle, with a height of"),
    "a needle": (beside(CENTRE + 3000 * NORMAL, CENTRE + 3000 * NORMAL + 500 * ALONG,
                        CENTRE + 3000 * NORMAL + 250 * ALONG + 4.9 * DOWN),
                 "triangle 24 is a needle, with a height of 4.9 m on a side of 500 m"),
    "above the ground": (dict(vertices=shifted(0, [0, 0, -101])), "vertex 0 of triangle 0 is 1 m above the ground"),
    "upward": (dict(vertices=VERTICES * [1, 1, -1]),
               "brings topography there; if z is upward, -fault_mesh_frame enu says so"),
    "kilometres that are not said": (dict(vertices=VERTICES / 1000, units=None), "may be one of metres or one of "
                                     "kilometres, and nothing says which: expected -fault_mesh_unit m or km"),
    "kilometres that are said": (dict(vertices=VERTICES / 1000, units="km"), 'has the units "km"'),
    "a slab in kilometres to a depth of 120": (dict(vertices=VERTICES / [20, 20, 9.5], units=None),
                                               "121.5 across and reaches down to 119.9, in cells of 30.7"),
    "a slab in kilometres to a depth of 660": (dict(vertices=VERTICES / 1.7258, units=None),
                                               "reaches down to 660.1, in cells of 259"),
    "degrees and kilometres": (dict(vertices=LONLAT, units=None), "from 38 to 38.38 and from 138 to 139, beside depths "
                               "to 30, look like latitudes and longitudes"),
    "degrees that are said to be metres": (dict(vertices=LONLAT), "look like latitudes and longitudes"),
    "degrees of coarse cells": (dict(vertices=LONLAT * [40, 20, 1] - [1520, 2640, 0], units=None),
                                "or one of kilometres, or x and y are degrees"),
    "degrees and metres": (dict(vertices=LONLAT * [1, 1, 1000], units=None), "look like latitudes and longitudes"),
    "kilometres and metres": (dict(vertices=VERTICES * [1e-3, 1e-3, 1], units=None),
                              "do not look like one unit of length"),
    "metres and kilometres": (dict(vertices=VERTICES * [10, 10, 1e-3], units=None),
                              "do not look like one unit of length"),
    "level on the ground": (dict(vertices=VERTICES * [1, 1, 0]), "triangle 0 lies on the ground, with its lowest point "
                            "0 m deep, as in a mesh of two dimensions"),
    "nearly level on the ground": (dict(vertices=VERTICES * [1, 1, 0.003]),
                                   "triangle 0 lies on the ground, with its lowest point 1.3"),
    "a triangle twice": (dict(triangles=np.concatenate([TRIANGLES, TRIANGLES[5:6, [1, 2, 0]]])),
                         "triangles 5 and 24 have the same vertices"),
    "a triangle twice, with vertices of its own": (dict(
        zip(("vertices", "triangles"), joined((VERTICES, TRIANGLES), (VERTICES[TRIANGLES[9]] + 1e-5, [[0, 1, 2]])))),
                                                   "triangles 9 and 24 have the same vertices"),
    "overlap in one plane": (beside(*(VERTICES[TRIANGLES[5]] + 0.3 * (CENTRE - VERTICES[TRIANGLES[5]]) + 100 * ALONG)),
                             "and 24 overlap"),
    "within another": (beside(*(0.5 * (VERTICES[TRIANGLES[5]] + CENTRE))), "triangles 5 and 24 overlap"),
    "overlap from an edge on": (beside(0, 1, VERTICES[0] + 100 * DOWN + 250 * ALONG),
                                "triangles 0 and 24 share an edge with an angle of"),
    "folded back": (beside(0, 1, VERTICES[0] + 300 * DOWN + 200 * ALONG + 2 * NORMAL),
                    "share an edge with an angle of 0.382 degrees between them"),
    "crossing": (beside(CENTRE - 200 * NORMAL, CENTRE + 200 * NORMAL, CENTRE + 200 * NORMAL + 100 * DOWN),
                 "triangles 5 and 24 cross"),
    "crossing at a small angle": (beside(CENTRE - 10 * NORMAL - 100 * ALONG, CENTRE + 10 * NORMAL + 100 * ALONG,
                                         CENTRE + 90 * DOWN), "and 24 cross"),
    "crossing from a vertex on": (beside(0, CENTRE + 200 * NORMAL, CENTRE - 200 * NORMAL), "and 24 cross"),
    "a strip with one side": (dict(zip(("vertices", "triangles"), mobius())), "are of a surface with one side only"),
    "labels of other cells": (dict(fault=np.zeros(N - 1, int)),
                              "/fault in mesh.h5 has shape [23]"),
    "labels that are not whole": (dict(fault=np.full(N, 0.5)),
                                  "row 0 of /fault is 0.5"),
    "no label": (dict(fault=np.where(np.arange(N) == 8, np.nan, 1)), "row 8 of /fault is nan"),
    "another dataset": (dict(faces=TRIANGLES), "holds /faces, which nothing reads"),
}
POINTS = enu(VERTICES)
FACETS = [(2, 7, [int(k) for k in t]) for t in TRIANGLES]


def text(version="4.1", elements=FACETS, points=POINTS, binary=False, **more):
    return gmsh(version, binary, points, elements, **more)


# The same of files of Gmsh
BAD_GMSH = {
    "nothing": (b"", "ends without $MeshFormat"),
    "another kind of file": (b"*Heading\n an Abaqus file\n", "line 1 begins no section"),
    "version 1": (b"$NOD\n1\n1 0 0 0\n$ENDNOD\n", "has $NOD before $MeshFormat"),
    "version 4.0": (text().replace(b"4.1", b"4.0"), "is of version 4 of the format"),
    "version 2.1": (text("2.2").replace(b"2.2", b"2.1"), "is of version 2.1 of the format"),
    "floats of four bytes": (text().replace(b"4.1 0 8", b"4.1 0 4"), "has $MeshFormat 4.1 0 4"),
    "the other order of bytes": (text(binary=True).replace(b"\x01\x00\x00\x00\n$EndMesh", b"\x00\x00\x00\x01\n"
                                                           b"$EndMesh"), "this machine's order of bytes"),
    "an end before the nodes": (text(end=False).split(b"$Nodes")[0], "ends without $Nodes"),
    "an end before the elements": (text().split(b"$Elements")[0], "ends without $Elements"),
    "an end in the elements": (text("2.2")[:-60], "whole number"),
    "an end without $EndElements": (text(end=False), "$EndElements"),
    "an end in the bytes": (text("2.2", binary=True)[:-60], "4 bytes"),
    "a block of more elements than there are": (
        text("2.2", binary=True, length=50).replace(struct.pack("=iii", 2, N, 4), struct.pack("=iii", 2, N + 1, 4)),
        "$Elements has a block of 25 elements"),
    "a last block of more elements than are left": (text("2.2", binary=True, length=12)[::-1].replace(
        struct.pack("=iii", 2, 12, 4)[::-1], struct.pack("=iii", 2, 13, 4)[::-1], 1)[::-1],
                                                    "has a block of 13 elements"),
    "more tags than the file can hold": (text("2.2").replace(b"\n1 2 2 7 7", b"\n1 2 99999 7 7", 1),
                                         "99999 tags are to follow"),
    "more nodes in the last block": (text(length=9).replace(b"2 1 0 10\n", b"2 1 0 11\n"),
                                     "$Nodes has more nodes in its blocks than the 20"),
    "a block of no elements": (text("2.2", binary=True, length=50).replace(
        struct.pack("=iii", 2, N, 4), struct.pack("=iii", 2, 0, 4)), "has a block of 0 elements"),
    "more nodes in blocks than in all": (text(length=9).replace(b"2 1 1 10\n", b"2 1 1 21\n"),
                                         "$Nodes has more nodes in its blocks than the 20 that it begins with"),
    "an end in the bytes of 4.1": (text(binary=True)[:-20], "8 bytes"),
    "a word for a number": (text("2.2").replace(b"\n7 ", b"\nseven ", 1), '"seven"'),
    "more nodes than the file can hold": (text("2.2").replace(b"$Nodes\n20\n", b"$Nodes\n2000000000\n"),
                                          "2000000000 nodes are to follow"),
    "fewer nodes than are said": (text("2.2").replace(b"$Nodes\n20\n", b"$Nodes\n21\n"),
                                  'line 27: "$EndNodes"'),
    "a node twice": (text("2.2").replace(b"\n7 0", b"\n6 0", 1) if b"\n7 0" in text("2.2")
                     else text("2.2").replace(b"\n7 ", b"\n6 ", 1), "$Nodes has the node 6 twice"),
    "a node that is not there": (text("2.2", elements=FACETS[:-1] + [(2, 7, [0, 1, 400])]),
                                 "element 24 has the node 401, which $Nodes does not have"),
    "a node that is before all": (text("2.2", elements=FACETS[:-1] + [(2, 7, [0, 1, -1])]),
                                  "element 24 has the node 0, which $Nodes does not have"),
    "a node that is no number": (text("2.2", points=np.where(np.arange(V)[:, None] == 6, np.nan, POINTS)),
                                 "vertex 7 has x = nan m"),
    "six nodes a triangle": (text(elements=FACETS + [(9, 7, [0, 1, 5, 2, 3, 4])]),
                             "element 25 is of the type 9, of 6 nodes"),
    "a type that is none": (text("2.2").replace(b"\n1 2 2 7 7", b"\n1 77 2 7 7", 1),
                            "elements of the type 77"),
    "quadrilaterals that are no rectangles": (text(elements=[(3, 7, [0, 1, 6, 7])]),
                                              "element 1 is a quadrilateral but no rectangle"),
    "rectangles and triangles": (text(elements=FACETS + [(3, 7, [0, 1, 6, 5])]),
                                 "element 25 has 4 sides and element 1 3"),
    "points and lines alone": (text(elements=[(15, 0, [0]), (1, 0, [0, 1])]), "has no triangles"),
    "volumes without groups": (text(elements=[(2, 0, [0, 1, 5]), (4, 0, [0, 1, 5, 6])]),
                               "physical surface"),
    "several groups": (text(groups={7: (-7, 8)}), "surface 7 is of several physical groups, 7 and 8"),
    "several groups in 2.2": (text("2.2", elements=FACETS + [(2, 8, f[2]) for f in FACETS[4:6]],
                                   names=((2, 7, "fault"), (2, 8, "asperity")), groups={7: (-7,), 8: (8,)}),
                              'element 5 is of several physical groups, 7 "fault" and 8 "asperity"'),
    "several groups of a turned triangle": (text("2.2", elements=[(2, 7, [0, 1, 5]), (2, 7, [0, 1, 6]),
                                                                  (2, 8, [5, 0, 1])]),
                                            "element 1 is of several physical groups, 7 and 8"),
    "a triangle twice in one group": (text("2.2", elements=FACETS + FACETS[:1]),
                                      "triangles 1 and 25 have the same vertices"),
    "parts": (text(sections="$PartitionedEntities\n0\n$EndPartitionedEntities\n"), "is partitioned"),
    "a name without an end": (text(sections='$PhysicalNames\n1\n2 7 "fault\n$EndPhysicalNames\n'.replace(
        '"fault', "fault")), "quotation marks"),
    "a section without an end": (text(sections="$Parametrizations\n0 0\n"), "$EndParametrizations"),
    "overlap": (text(elements=FACETS + [(2, 7, [0, 1, 5])]), "triangles 1 and 25 "),
    "crossing": (text(elements=FACETS + [(2, 7, [V, V + 1, V + 2])],
                      points=enu(beside(CENTRE - 200 * NORMAL, CENTRE + 200 * NORMAL,
                                        CENTRE + 200 * NORMAL + 100 * DOWN)["vertices"])),
                 "triangles 6 and 25 cross"),
    "z downward": (text(points=POINTS * [1, 1, -1]), "above the ground"),
}
GOOD = {
    "a branch of three at one edge": beside(5, 6, CENTRE + 400 * NORMAL),
    "a splay whose edge is inside of triangles": beside(CENTRE, CENTRE + 400 * NORMAL,
                                                        CENTRE + 300 * NORMAL + 200 * ALONG),
    "vertices of their own for each triangle": dict(vertices=VERTICES[TRIANGLES].reshape(-1, 3),
                                                    triangles=np.arange(3 * N).reshape(-1, 3)),
    "vertices nearly in one place": dict(vertices=VERTICES[TRIANGLES].reshape(-1, 3)
                                         + np.random.default_rng(1).uniform(-5e-5, 5e-5, (3 * N, 3)),
                                         triangles=np.arange(3 * N).reshape(-1, 3)),
    "vertices above the ground that nothing uses": dict(vertices=np.concatenate([VERTICES,
                                                                                 [[0, 0, -1e3], [np.nan, 0, 0]]])),
    "turned over in part": dict(triangles=np.where(np.arange(N)[:, None] % 3 == 0, TRIANGLES[:, [1, 0, 2]], TRIANGLES)),
    "a strip with one side, cut by labels": dict(zip(("vertices", "triangles"), mobius()), fault=np.arange(24) // 6),
    "a level triangle": dict(vertices=np.array([[0, 0, 1e3], [500, 0, 1e3], [0, 500, 1e3]]), triangles=[[0, 1, 2]]),
    "up to the ground": dict(vertices=VERTICES - [0, 0, 100]),
}


class Input(FaultTest):
    def run_of(self, path, *options):
        return subprocess.run([FAULT, "-fault_mesh", path, *THRUST, *options], cwd=self.folder.name,
                              capture_output=True, text=True)

    def refused(self, done, path, *messages):
        self.assertEqual(done.returncode, 1, done.stderr)
        errors = [line for line in done.stderr.splitlines() if line]
        self.assertEqual(len(errors), 1, done.stderr)
        self.assertTrue(errors[0].startswith("fault: error: "), errors[0])
        for message in (path, "-fault_mesh", *messages):
            self.assertIn(message, errors[0])

    def write(self, what):
        write_hdf5(self.path("mesh.h5"), **{"vertices": VERTICES, "triangles": TRIANGLES, **what})

    def test_bad_hdf5(self):
        for name, (what, message) in BAD.items():
            with self.subTest(name):
                self.write(what)
                self.refused(self.run_of("mesh.h5"), "mesh.h5", message)

    def test_bad_gmsh(self):
        for name, (content, message) in BAD_GMSH.items():
            with self.subTest(name):
                self.put("mesh.msh", content)
                self.refused(self.run_of("mesh.msh"), "mesh.msh", message)

    def test_bad_options(self):
        self.write({})
        self.hdf5("cells.h5", cells=[[0.0, 0, 900, 100, 100]])
        for path, options, message in (("cells.h5", ("-fault_mesh_frame", "enu"), "-fault_mesh_frame ned"),
                                       ("mesh.h5", ("-fault_mesh_frame", "enu"), "above the ground"),
                                       ("mesh.h5", ("-fault_mesh_unit", "km"), "has z = "),
                                       ("mesh.h5", ("-fault_operator", "fft"),
                                        "-fault_operator fft needs a uniform grid")):
            if options[1] == "km":
                self.write(dict(vertices=VERTICES * 2))
            with self.subTest(options):
                self.refused(self.run_of(path, *options), path, message)
        self.refused(subprocess.run([FAULT, "-fault_mesh_unit", "km"], capture_output=True, text=True),
                     "-fault_mesh_unit km", "which is not given")

    def test_units_that_are_said(self):
        """Of a laboratory, of kilometres, and of numbers that look like degrees; they take a step."""
        for what, options in ((dict(vertices=VERTICES / 1000, units=None), ("-fault_mesh_unit", "m")),
                              (dict(vertices=VERTICES / 17, units=None), ("-fault_mesh_unit", "km")),
                              (dict(vertices=TALL, units=None),
                               ("-fault_mesh_unit", "km", "-fault_mesh_frame", "ned"))):
            with self.subTest(options):
                self.write(what)
                done = self.run_of("mesh.h5", *options, "-fault_friction_slip", "1e-5" if options[1] == "m" else "5")
                self.assertIn("accepted steps:          1", done.stdout, done.stderr)

    def test_good_meshes(self):
        """A step is taken, so the operators were made as well."""
        for name, what in GOOD.items():
            with self.subTest(name):
                self.write(what)
                done = self.run_of("mesh.h5")
                self.assertIn("accepted steps:          1", done.stdout, done.stderr)


if __name__ == "__main__":
    unittest.main()
