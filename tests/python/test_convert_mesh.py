"""examples/convert_mesh.py: small files of each kind become the triangles that they were made of, which a run reads;
others are refused by one line. What a run refuses is mended: areas and the shared vertices of the result are those that
the surfaces must have."""

import contextlib
import io
import os
import struct
import subprocess
import sys
import unittest
from unittest import mock

from scripts import SOURCE, FaultTest
import h5py
import numpy as np

from meshfiles import enu, gmsh, joined, plane, write_hdf5

sys.path.insert(0, os.path.join(SOURCE, "examples"))
import convert_mesh
from slipstep.geometry.meshrepair import (Mesh, clip, edges_of, faults_of, flatten, normals, repair, rising, shift,
                                          slender)

FIRST, SECOND = plane((2, 1), (500.0, 400.0), 20, 60, (0, 0, 100)), plane((1, 1), (500.0, 400.0), 80, 45,
                                                                          (0, 4000, 300))
VERTICES, TRIANGLES = joined(FIRST, SECOND)
LABEL = np.repeat([0, 1], [len(FIRST[1]), len(SECOND[1])])
RUN = ("-fault_initial", "rest", "-fault_viscosity", "radiation", "-ts_max_steps", "1", "-ts_max_time", "1")


def corners():
    """As files have them: east, north, up"""
    return enu(VERTICES)[TRIANGLES]


def stl_text(solids=(("north", 0), ("south; part", 1))):
    out = ""
    for name, label in solids:
        out += f"solid {name}\n"
        for facet in corners()[LABEL == label]:
            out += "  facet normal 0 0 1\n    outer loop\n" + "".join(f"      vertex {x:.17g} {y:.17g} {z:.17g}\n"
                                                                      for x, y, z
                                                                      in facet) + "    endloop\n  endfacet\n"
        out += f"endsolid {name}\n"
    return out.encode()


def stl_bytes():
    out = b"solid or not".ljust(80) + struct.pack("<I", len(TRIANGLES))
    return out + b"".join(struct.pack("<12fH", 0, 0, 1, *facet.ravel(), 0) for facet in corners())


def gocad(positive="Elevation", first=1, kind="VRTX"):
    out = ""
    for name, label in (("north", 0), ("south", 1)):
        out += (f'GOCAD TSurf 1\nHEADER {{\nname: {name}\n}}\nGOCAD_ORIGINAL_COORDINATE_SYSTEM\nNAME Default\n'
                f'AXIS_UNIT "m" "m" "m"\nZPOSITIVE {positive}\nEND_ORIGINAL_COORDINATE_SYSTEM\nTFACE\n')
        own = TRIANGLES[LABEL == label]
        used = np.unique(own)
        for k, v in enumerate(used):
            x, y, z = enu(VERTICES)[v]
            out += (f"{kind} {first + k} {x:.17g} {y:.17g} "
                    f"{z if positive == 'Elevation' else -z:.17g}{' 7' if kind == 'PVRTX' else ''}\n")
        out += ("".join("TRGL " + " ".join(str(first + int(np.searchsorted(used, v))) for v in t) + "\n" for t in own)
                + "END\n")
    return out.encode()


def rsqsim(names=("north fault", "south"), more=""):
    return ("# x1 y1 z1 ...\n" + "".join(" ".join(f"{c:.17g}" for c in facet.ravel()) + f" {90 - 10 * k} "
                                         f"{1e-9 * (1 + k):.17g} {7 + label} {names[label]}{more}\n"
                                         for k, (facet, label) in enumerate(zip(corners(), LABEL)))).encode()


def obj(face="{0} {1} {2}"):
    """In groups, with the normal of each face"""
    out = ("o both\n" + "".join(f"v {x:.17g} {y:.17g} {z:.17g}\n" for x, y, z in enu(VERTICES))
           + "vt 0 0\nvn 0 0 1\nvn 0 1 0\n")
    for name, label in (("north", 0), ("south; part", 1)):
        out += f"g {name}\n" + "".join("f " + face.format(*(t + 1)) + "\n" for t in TRIANGLES[LABEL == label])
    return out.encode()


class Convert(FaultTest):
    def convert(self, name, content, *options, **more):
        self.put(name, content)
        return self.run_of(name, "mesh.h5", *options, **more)

    def run_of(self, *arguments, code=0):
        """What the script prints, within this process, whose start takes longer than most files"""
        out, err, ended = io.StringIO(), io.StringIO(), 0
        before = os.getcwd()
        os.chdir(self.folder.name)
        try:
            with mock.patch.object(sys, "argv", ["convert_mesh.py", *arguments]), contextlib.redirect_stdout(
                out), contextlib.redirect_stderr(err):
                convert_mesh.main()
        except SystemExit as stop:
            ended = stop.code if isinstance(stop.code, int) else 1
            err.write("" if isinstance(stop.code, int) else f"{stop.code}\n")
        finally:
            os.chdir(before)
        self.assertEqual(ended, code, err.getvalue())
        return out.getvalue() if code == 0 else err.getvalue()

    def check(self, rounding=0.0, label=LABEL, names="0 north; 1 south"):
        """The triangles of the file, and that a run takes them"""
        with h5py.File(self.path("mesh.h5")) as file:
            vertices, triangles = file["vertices"][()], file["triangles"][()]
            self.assertEqual(len(vertices), len(VERTICES))
            np.testing.assert_allclose(vertices[triangles], VERTICES[TRIANGLES], rtol=0, atol=rounding)
            if label is not None:
                np.testing.assert_array_equal(file["fault"], label)
                self.assertEqual(file["fault"].attrs["names"], names)
        self.fault("-fault_mesh", "mesh.h5", *RUN, "-fault_output", "out.h5", "-fault_output_overwrite")

    def test_stl(self):
        self.convert("a.stl", stl_text())
        self.check(1e-12, names="0 north; 1 south part")
        self.convert("b.stl", stl_bytes())
        self.check(2.5e-4, None)  # single precision of 4000 m rounds by 1.2e-4
        moved = stl_text().replace(b"vertex", b"VERTEX").replace(b"solid north", b"solid")
        self.convert("c.stl", moved)
        self.check(1e-12, names="1 south part")

    def units(self):
        with h5py.File(self.path("mesh.h5")) as file:
            return file["vertices"].attrs.get("units")

    def test_frame_and_unit(self):
        out = "solid\n" + "".join("facet normal 0 0 1\nouter loop\n"
                                  + "".join(f"vertex {x / 1000:.17g} " f"{y / 1000:.17g} {z / 1000:.17g}\n" for x, y,
                                            z in facet) + "endloop\nendfacet\n" for facet
                                  in VERTICES[TRIANGLES]) + "endsolid\n"
        self.convert("a.stl", out.encode(), "--frame", "ned", "--unit", "km")
        self.check(1e-9, None)
        self.assertEqual(self.units(), "m")
        # nothing says what its lengths are, and a run asks
        said = self.convert("a.stl", out.encode(), "--frame", "ned")
        self.assertIn("--unit", said)
        self.assertIsNone(self.units())
        self.assertIn("-fault_mesh_unit", self.fault("-fault_mesh", "mesh.h5", code=1))
        self.convert("a.ts", gocad().replace(b'"m" "m" "m"', b'"km" "km" "km"'), "--unit", "km")
        self.assertEqual(self.units(), "m")
        self.assertIn("--unit", self.convert("a.ts", gocad(), "--unit", "km", code=1))
        self.convert("a.ts", gocad().replace(b'AXIS_UNIT "m" "m" "m"\n', b""))
        self.assertIsNone(self.units())
        down = stl_text().decode().splitlines()
        down = "\n".join("vertex {} {} {}".format(*line.split()[1:3], line.split()[3].lstrip("-")) if "vertex" in line
                         else line for line in down)
        self.convert("a.stl", down.encode(), "--frame", "end")
        self.check(1e-12, names="0 north; 1 south part")
        self.assertIn("--frame ned or end", self.convert("a.stl", down.encode()))
        self.convert("a.ts", gocad("Depth"), "--frame", "end")  # both say the same
        self.check(1e-12)
        said = self.convert("a.stl", stl_text(), "--origin", "1e3", "-2000")
        with h5py.File(self.path("mesh.h5")) as file:
            np.testing.assert_allclose(file["vertices"][()][file["triangles"][()]],
                                       VERTICES[TRIANGLES] - [1e3, -2e3, 0], atol=1e-9)
        self.assertNotIn("--origin", said)
        self.assertIn("--origin 3900000 407000", self.convert("a.stl", stl_text(), "--origin", "-3899500", "-404500"))

    def test_gocad(self):
        for k, (positive, first, kind) in enumerate((("Elevation", 1, "VRTX"), ("Depth", 0, "PVRTX"))):
            self.convert(f"{k}.ts", gocad(positive, first, kind))
            self.check(1e-12)

    def test_rsqsim(self):
        self.convert("a.txt", rsqsim(), "--fields", "fields.h5")
        self.check(1e-12, LABEL + 7, "7 north fault; 8 south")
        with h5py.File(self.path("fields.h5")) as file:
            np.testing.assert_array_equal(file["rake"], 90 - 10 * np.arange(len(TRIANGLES)))
            np.testing.assert_allclose(file["loading_rate"], 1e-9 * (1 + np.arange(len(TRIANGLES))), rtol=1e-15)
        self.fault("-fault_mesh", "mesh.h5", "-fault_parameters", "fields.h5", *RUN, "-fault_output", "out.h5",
                   "-fault_output_overwrite")
        np.testing.assert_array_equal(self.get("out.h5", "mesh/rake"), 90 - 10 * np.arange(len(TRIANGLES)))

    def test_columns_of_rsqsim(self):
        """Numbers after names are other columns, unless names are told apart by them."""
        for names, more, want in ((("north fault", "south"), " 3 0.5e-2", "7 north fault; 8 south"),
                                  (("part 1", "part 2"), "", "7 part 1; 8 part 2"),
                                  (("part 1", "part"), "", "7 part 1; 8 part"),
                                  (("part 1", "other"), " 4", "7 part 1; 8 other")):
            with self.subTest(names):
                said = self.convert("a.flt", rsqsim(names, more))
                self.assertEqual(self.get("mesh.h5", "fault@names"), want)
                self.assertEqual("after the names left out" in said, bool(more), said)

    def test_obj(self):
        """Normals are of faces, not of vertices; numbers may count from the last vertex; faces may have four
        corners."""
        n = len(VERTICES)
        for face in ("{0} {1} {2}", "{0}//2 {1}//1 {2}//2", "{0}/1/1 {1}/1/2 {2}/1/1"):
            self.convert("a.obj", obj(face))
            self.check(1e-12, names="0 north; 1 south part")
        last = "\n".join("f " + " ".join(str(int(c) - n - 1) for c in line.split()[1:]) if line.startswith("f ")
                         else line for line in obj().decode().splitlines())
        self.convert("a.obj", last.encode())
        self.check(1e-12, names="0 north; 1 south part")
        square = b"v 0 0 -2000\nv 500 0 -2000\nv 500 0 -1500\nv 0 0 -1500\nf 1 2 3 4\n"
        self.assertIn("cut into 1 triangles more\n2 triangles, 4 vertices", self.convert("a.obj", square))
        for content, message in ((b"v 0 0\n", "line 1: 2 coordinates"),
                                 (square + b"f 1 2 9\n", "line 6: f 1 2 9"), (square + b"f 1 2\n", "line 6"),
                                 (square + b"f 1 2 0\n", "line 6"), (square + b"f 1 two 3\n", "line 6")):
            self.assertIn(message, self.convert("a.obj", content, code=1))

    def test_gmsh_and_hdf5(self):
        """Read to be mended: a row of quadrilaterals beside triangles, groups, and what is of none"""
        elements = [(2, 3 + label, [int(n) for n in t]) for t, label in zip(TRIANGLES, LABEL)]
        # a sign says which way it faces
        for version, binary, groups in (("2.2", False, (3, 4)), ("2.2", True, (-3, 4)), ("4.1", False, (3, -4)),
                                        ("4.1", True, (-3, 4))):
            more = {"names": ((2, 3, "north"), (2, 4, "south"), (1, 3, "edge")),
                    "groups": {3: groups[:1], 4: groups[1:]}, "length": 5}
            self.convert("a.msh", gmsh(version, binary, enu(VERTICES), elements + [(1, 0, [0, 1]), (15, 0, [0])],
                                       **more))
            self.check(1e-12, LABEL + 3, "3 north; 4 south")
        nested = gmsh("2.2", False, enu(VERTICES), elements + [(2, 9, [2, 0, 1] if set(elements[0][2]) == {0, 1, 2}
                                                                else elements[0][2][::-1])], names=((2, 3, "north"),))
        both = gmsh("4.1", True, enu(VERTICES), elements, groups={3: (3, 9), 4: (4,)}, names=((2, 3, "north"),))
        for content in (nested, both):
            self.assertIn('of several physical groups, 3 "north" and 9', self.convert("a.msh", content, code=1))
        os.rename(self.path("mesh.h5"), self.path("a.h5"))
        self.run_of("a.h5", "mesh.h5")
        self.check(1e-12, LABEL + 3, "3 north; 4 south")
        for content, message in ((b"$MeshFormat\n4.0 0 8\n$EndMeshFormat\n", "version 4.0"),
                                 (b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n", "$MeshFormat"),
                                 (gmsh("2.2", False, enu(VERTICES), [(2, 1, [0, 1, 99])]), "has the node 100")):
            self.assertIn(message, self.convert("a.msh", content, code=1))
        self.assertIn("$MeshFormat", self.convert("a.msh", gmsh("4.1", True, enu(VERTICES), elements)[:-200]
                                                  + b"\n$EndElements\n", code=1))
        for vertices, triangles, more, message in ((enu(VERTICES), TRIANGLES, {}, "as where z is upward: --frame enu"),
                                                   (VERTICES, TRIANGLES[:, :2], {}, "shape [any, 3]"),
                                                   (VERTICES, TRIANGLES + 0.5, {}, "not whole"),
                                                   (VERTICES, TRIANGLES - 1, {}, "the vertex -1"),
                                                   (VERTICES, TRIANGLES, {"fault": LABEL[1:]},
                                                    "a label for each triangle")):
            write_hdf5(self.path("a.h5"), vertices, triangles, **more)
            self.assertIn(message, self.run_of("a.h5", "mesh.h5", code=0 if "frame" in message else 1))

    def test_several(self):
        """Labels and names of each file, and numbers on from there where they are the same"""
        self.put("b.ts", gocad(positive="Depth"))
        self.put("plain.stl", stl_bytes())
        self.convert("a.txt", rsqsim())
        self.run_of("a.txt", "b.ts", "plain.stl", "mesh.h5", "--unit", "m")
        with h5py.File(self.path("mesh.h5")) as file:
            np.testing.assert_array_equal(file["fault"], np.concatenate([LABEL + 7, LABEL, 0 * LABEL + 9]))
            self.assertEqual(file["fault"].attrs["names"], "0 north; 1 south; 7 north fault; 8 south; 9 plain")
            self.assertEqual(len(file["triangles"]), 3 * len(TRIANGLES))
        self.assertIn("plain.stl", self.run_of("b.ts", "plain.stl", "mesh.h5", code=1))
        # which says its own, and --unit is that of the other
        kilometres = gocad().replace(b'"m" "m" "m"', b'"km" "km" "km"')
        self.convert("k.ts", kilometres)
        self.run_of("k.ts", "plain.stl", "mesh.h5", "--unit", "m")
        with h5py.File(self.path("mesh.h5")) as file:
            tops = [file["vertices"][()][file["triangles"][()][k * len(TRIANGLES):(k + 1) * len(
                TRIANGLES)]][..., 2].min() for k in range(2)]
            np.testing.assert_allclose(tops, [1e5, 100], rtol=1e-5)
        self.assertIn("plain.stl", self.run_of("b.ts", "plain.stl", code=1))
        self.assertIn("mesh.h5", self.run_of("mesh.h5", "mesh.h5", code=1))
        self.assertEqual(os.path.getsize(self.path("plain.stl")), len(stl_bytes()))

    def test_topography(self):
        """Of a surface above the ground a run asks for one of three remedies, each of which it takes; rows of fields
        follow their triangles."""
        rows = rsqsim().decode().splitlines()
        high = "\n".join(" ".join(f"{float(w) + 300 * (k % 3 == 2)}" if k < 9 else w for k, w in enumerate(row.split()))
                         for row in rows[1:])
        said = self.convert("a.txt", high.encode())
        self.assertIn("4 triangles rise above the ground, by up to 200", said)
        self.assertIn("200 m above the ground", self.fault("-fault_mesh", "mesh.h5", "-fault_mesh_unit", "m", code=1))
        for option, words, least in (("--clip", "clipped: 6 triangles became", None),
                                     ("--shift", "shifted down by 200", 200), ("--flatten", "vertices moved down", 0)):
            said = self.convert("a.txt", high.encode(), option, "--unit", "m", "--fields", "fields.h5")
            self.assertIn(words, said)
            self.assertNotIn("rise above", said)
            self.fault("-fault_mesh", "mesh.h5", "-fault_parameters", "fields.h5", *RUN, "-fault_output", "out.h5",
                       "-fault_output_overwrite")
            with h5py.File(self.path("fields.h5")) as fields, h5py.File(self.path("mesh.h5")) as mesh:
                corners, rake = mesh["vertices"][()][mesh["triangles"][()]], fields["rake"][()]
            centre = VERTICES[TRIANGLES].mean(axis=1) - [0, 0, 300]
            if least is None:  # within the triangle of its rake
                for own, k in zip(corners.mean(axis=1), np.round((90 - rake) / 10).astype(int)):
                    p = VERTICES[TRIANGLES[k]] - [0, 0, 300]
                    share = np.linalg.lstsq(np.vstack([p.T / 1e3, np.ones(3)]), np.append(own / 1e3, 1), rcond=None)[0]
                    self.assertGreater(share.min(), -0.1)  # vertices move along edges by a tenth at most
            else:
                np.testing.assert_array_equal(rake, 90 - 10 * np.arange(len(TRIANGLES)))
            if least == 200:
                np.testing.assert_allclose(corners.mean(axis=1), centre + [0, 0, 200], atol=1e-9)

    def test_meshio_regions(self):
        """What a stand-in for meshio has read: regions are faults, names that no rule knows are said, and
        quadrilaterals are cut."""
        self.put("meshio.py", "import numpy as np\nfrom types import SimpleNamespace as Of\n"
                 f"points = np.array({enu(VERTICES).tolist()})\ntriangles = np.array({TRIANGLES.tolist()})\n"
                 f"label = np.array({(LABEL + 5).tolist()})\n" "def read(path):\n" "    name = path.split('.')[0]\n"
                 "    cells = [Of(type='line', data=np.array([[0, 1]])), Of(type='triangle', data=triangles), "
                 "Of(type='quad', data=np.array([[0, 1, 4, 3]])[:name == 'Quads'])]\n"
                 "    return Of(points=points, cells=cells, cell_data={name: [np.zeros(1, int), label, "
                 "np.full(len(cells[2].data), 9)], 'speed': [np.zeros(1), label + 0.5, "
                 "np.zeros(len(cells[2].data))]},"
                 " field_data={'north': np.array([5, 2]), 'south': np.array([6, 2]), 'edge': " "np.array([0, 1])})\n")
        sys.path.insert(0, self.folder.name)
        self.addCleanup(sys.path.remove, self.folder.name)
        self.addCleanup(sys.modules.pop, "meshio", None)
        sys.modules.pop("meshio", None)
        for name, options, names in (("RegionId.vtu", (), "5 north; 6 south"),
                                     ("fault_ids.vtk", (), "5 north; 6 south"),
                                     ("made.vtu", ("--label", "made"), "5 north; 6 south"),
                                     ("made.vtu", (), None)):
            said = self.convert(name, b"", *options)
            self.check(1e-12, LABEL + 5 if names else None, names)
            self.assertIn(f"faults by its data {name.split('.')[0]}" if names
                          else "its data made, speed not used: --label NAME", said)
        self.assertIn("--label", self.convert("made.vtu", b"", "--label", "other", code=1))
        self.assertIn("speed", self.convert("made.vtu", b"", "--label", "speed", code=1))
        self.assertIn(f"{len(TRIANGLES) + 2} triangles", self.convert("Quads.vtu", b""))

    def test_meshio(self):
        """Kinds of files that only meshio reads, as their descriptions have them; lines of VTK are no triangles.
        Vertices of PLY are in single precision."""
        if not self.meshio():
            self.skipTest("meshio is not installed (Debian's package is python3-meshio)")
        points, n = enu(VERTICES), len(TRIANGLES)
        rows = "".join("{:.17g} {:.17g} {:.17g}\n".format(*place) for place in points)
        faces = "".join("3 {} {} {}\n".format(*t) for t in TRIANGLES)
        vtk = (f"# vtk DataFile Version 3.0\nfault\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {len(points)} double\n"
               f"{rows}\nCELLS {n + 1} {4 * n + 3}\n2 0 1\n{faces}\n" f"CELL_TYPES {n + 1}\n3\n" + n * "5\n")
        ply = (f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\nproperty "
               f"float z\nelement face {n}\n" f"property list uchar int vertex_indices\nend_header\n{rows}{faces}")
        for name, content, digits in (("a.vtk", vtk, 1e-12), ("a.ply", ply, 1e-3)):
            self.convert(name, content.encode())
            self.check(digits, None)
        lines = vtk.split("CELLS")[0] + "CELLS 1 3\n2 0 1\n\nCELL_TYPES 1\n3\n"
        for name, content, message in (("a.vtk", lines, "line"),
                                       ("a.ply", ply[:150], "meshio cannot read it"),
                                       ("a.vtk", "no mesh", "meshio cannot read it")):
            error = self.convert(name, content.encode(), code=1)
            self.assertEqual(error.count("\n"), 1, error)
            self.assertIn(message, error)

    def test_refused(self):
        cases = (("a.stl", b"", "neither text that begins with \"solid\""), ("a.stl", stl_bytes()[:-3], "neither text"),
                 ("a.stl", b"solid\nendsolid\n", "has no triangles"),
                 ("a.stl", stl_text().replace(b"vertex", b"vortex", 1), 'line 4: "vortex"'),
                 ("a.stl", stl_text().replace(b"    endloop", b"      vertex 0 0 0\n    endloop", 1),
                  "a facet of 4 vertices"),
                 ("a.stl", stl_text()[:200], "ends within a facet"), ("a.ts", b"", "is empty"),
                 ("a.ts", b"GOCAD VSet 1\n", "TSurf"),
                 ("a.ts", gocad().replace(b"TRGL 1", b"TRGL 99", 1), "there is no 99"),
                 ("a.ts", gocad().replace(b"Elevation", b"Up", 1), "Elevation or Depth"),
                 ("a.ts", gocad().replace(b'"m" "m" "m"', b'"ft" "ft" "ft"', 1), "m or km"),
                 ("a.txt", b"1 2 3\n", "line 1: 3 columns"),
                 ("a.txt", rsqsim().replace(b" 90 1", b" ninety 1", 1), '"ninety"'),
                 ("a.stl", stl_text().replace(b"vertex 0", b"vertex nan", 1), '"nan"'),
                 ("a.xyz", rsqsim(), "--format rsqsim" if self.meshio()
                  else "--format stl, gocad, obj, gmsh, hdf5 or rsqsim"))
        for name, content, message in cases:
            with self.subTest(name=name, message=message):
                error = self.convert(name, content, code=1)
                self.assertEqual(error.count("\n"), 1, error)
                self.assertTrue(error.startswith("convert_mesh.py: "), error)
                self.assertIn(message, error)
        self.assertIn("--fields", self.convert("a.stl", stl_text(), "--fields", "f.h5", code=1))

    @staticmethod
    def meshio():
        return subprocess.run([sys.executable, "-c", "import meshio"], capture_output=True).returncode == 0


class Repair(unittest.TestCase):
    """The surfaces themselves"""

    @staticmethod
    def surface(seed, cells=(9, 6), top=0.0):
        """Of irregular triangles on a dipping plane of 9 km x 6 km, from a height on"""
        rng = np.random.default_rng(seed)
        vertices, triangles = plane(cells, (1000.0, 1000.0), 20, 60, (0, 0, -top))
        inner = np.array([edge for edge, of in edges_of(triangles).items() if len(of) == 1]).ravel()
        moved = np.setdiff1d(np.arange(len(vertices)), inner)
        along, down = (vertices[1] - vertices[0]) / 1000, (vertices[cells[0] + 1] - vertices[0]) / 1000
        vertices[moved] += (rng.uniform(-250, 250, (len(moved), 1)) * along + rng.uniform(-250, 250, (len(moved), 1))
                            * down)
        return Mesh(vertices, triangles, np.arange(len(triangles)) // len(triangles)), moved, along, down

    def whole(self, mesh, ends=None):
        """No holes, no cracks, one sense of going around, and ends in one line; all triangles are such as a run
        takes."""
        edges = edges_of(mesh.triangles)
        self.assertEqual(len(np.unique(mesh.triangles)), len(mesh.vertices))
        self.assertEqual(len(mesh.vertices) - len(edges) + len(mesh.triangles), 1)
        self.assertEqual(max(map(len, edges.values())), 2)
        sides = [tuple(side) for t in mesh.triangles.tolist() for side in zip(t, t[1:] + t[:1])]
        self.assertEqual(len(set(sides)), len(sides))
        self.assertEqual(faults_of(mesh), (0, 0))
        if ends is not None:
            self.assertEqual(sum(len(of) == 1 for of in edges.values()), ends)

    def test_clip(self):
        """What is left of a plane has its area below the ground, and cut edges have one vertex each."""
        for seed, top in enumerate((10.0, 433.0, 866.0, 1234.0, 2600.0)):
            mesh, *_ = self.surface(seed, top=top)
            words = clip(mesh)
            self.whole(mesh)
            self.assertAlmostEqual(mesh.area, 9000 * (6000 - top / np.sin(np.radians(60))), delta=0.01)
            self.assertEqual(mesh.vertices[:, 2].min(), 0)
            self.assertEqual(rising(mesh), (0, 0.0))
            self.assertIn(f"became {mesh.area:.6g}, {100 * (1 - mesh.area / 54e6):.3g} % less", words)
            # a tenth of the edges, with corners of half their size
            self.assertGreater(slender(mesh.vertices[mesh.triangles]).min(), 0.03)
            self.assertEqual(len(mesh.label), len(mesh.triangles))
        mesh, *_ = self.surface(1, top=6000)
        clip(mesh)
        self.assertEqual(len(mesh.triangles), 0)

    def test_clip_valleys(self):
        """Topography along the trace: the area is that of what is below the ground, up to the moves that words tell."""
        mesh, *_ = self.surface(7)
        mesh.vertices[:, 2] -= (500 + 400 * np.sin(mesh.vertices[:, 0] / 700)) * np.exp(-mesh.vertices[:, 2] / 2000)
        area = 0
        for corners in mesh.vertices[mesh.triangles]:
            z = np.sort(corners[:, 2])
            share = (1 if z[0] >= 0 else 0 if z[2] <= 0 else z[2] ** 2 / ((z[2] - z[1]) * (z[2] - z[0])) if z[1] < 0
                     else 1 - z[0] ** 2 / ((z[1] - z[0]) * (z[2] - z[0])))
            area += 0.5 * share * np.linalg.norm(normals(corners))
        clip(mesh)
        self.whole(mesh)
        self.assertAlmostEqual(mesh.area / area, 1, delta=1e-3)

    def test_shift_and_flatten(self):
        mesh, *_ = self.surface(3, top=700)
        before = mesh.vertices.copy()
        self.assertEqual(shift(mesh), "shifted down by 700")
        np.testing.assert_allclose(mesh.vertices, before + [0, 0, 700])
        mesh, *_ = self.surface(3)
        flat = mesh.vertices.copy()
        along = np.array([np.cos(np.radians(20)), np.sin(np.radians(20))])
        # a slope along the strike, across which the nearest point of the trace lies
        height = 300 + 0.05 * (flat[:, :2] @ along)
        mesh.vertices[:, 2] -= height
        self.assertIn(f"{len(flat)} vertices moved down", flatten(mesh))
        np.testing.assert_allclose(mesh.vertices, flat, atol=1e-6)
        self.assertIn("nothing", flatten(mesh))

    def test_needles(self):
        """Vertices beside vertices, and on edges: the surface stays a whole one of the same area."""
        for seed in range(4):
            mesh, moved, along, down = self.surface(seed)
            vertices, triangles, rng = mesh.vertices.tolist(), mesh.triangles.tolist(), np.random.default_rng(seed)
            area, done = mesh.area, set()
            for k in rng.permutation(len(triangles)).tolist():
                if done & set(triangles[k]) or len(done) > 20:
                    continue
                done |= set(triangles[k])
                a, b, c = np.array([vertices[v] for v in triangles[k]])
                # beside a vertex, or an edge
                place = a + 0.003 * (b - a) + 0.002 * (c - a) if len(done) % 2 else a + 0.4 * (b - a) + 0.004 * (c - a)
                vertices.append(place.tolist())
                p, q, r = triangles[k]
                triangles[k] = [p, q, len(vertices) - 1]
                triangles += [[q, r, len(vertices) - 1], [r, p, len(vertices) - 1]]
            bad = Mesh(vertices, triangles, np.zeros(len(triangles), int))
            self.assertGreater(faults_of(bad)[0], 5)
            words = repair(bad)
            self.whole(bad)
            self.assertAlmostEqual(bad.area / area, 1, delta=1e-4)
            self.assertIn("0 removed; 0 folds", words)

    def test_folds(self):
        """A vertex that has crossed an edge, triangles that are there twice, and one whose corners are two"""
        for seed in range(4):
            mesh, moved, *_ = self.surface(seed)
            area, ends = mesh.area, sum(len(of) == 1 for of in edges_of(mesh.triangles).values())
            k = moved[len(moved) // 2]
            a, b = (v for v in next(t for t in mesh.triangles.tolist() if k in t) if v != k)
            middle = 0.5 * (mesh.vertices[a] + mesh.vertices[b])
            mesh.vertices[k] = middle + 0.1 * (middle - mesh.vertices[k])
            mesh = Mesh(mesh.vertices, mesh.triangles.tolist() + mesh.triangles[[4, 9]].tolist() + [[0, 1, 1]],
                        np.zeros(len(mesh.triangles) + 3, int))
            self.assertIn("3 that were there twice or had no three corners", repair(mesh))
            self.whole(mesh, ends)
            self.assertAlmostEqual(mesh.area / area, 1, delta=1e-9)


if __name__ == "__main__":
    unittest.main()
