"""examples/convert_mesh.py: small files of each kind become the triangles that they were made of, which a run reads; others are refused by one line."""

import os
import struct
import subprocess
import sys
import unittest

from scripts import SOURCE, FaultTest
import h5py
import numpy as np

from meshfiles import enu, joined, plane

CONVERT = os.path.join(SOURCE, "examples", "convert_mesh.py")
FIRST, SECOND = plane((2, 1), (500.0, 400.0), 20, 60, (0, 0, 100)), plane((1, 1), (500.0, 400.0), 80, 45, (0, 4000, 300))
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
            out += "  facet normal 0 0 1\n    outer loop\n" + "".join(f"      vertex {x:.17g} {y:.17g} {z:.17g}\n" for x, y, z in facet) + "    endloop\n  endfacet\n"
        out += f"endsolid {name}\n"
    return out.encode()


def stl_bytes():
    out = b"solid or not".ljust(80) + struct.pack("<I", len(TRIANGLES))
    return out + b"".join(struct.pack("<12fH", 0, 0, 1, *facet.ravel(), 0) for facet in corners())


def gocad(positive="Elevation", first=1, kind="VRTX"):
    out = ""
    for name, label in (("north", 0), ("south", 1)):
        out += f'GOCAD TSurf 1\nHEADER {{\nname: {name}\n}}\nGOCAD_ORIGINAL_COORDINATE_SYSTEM\nNAME Default\nAXIS_UNIT "m" "m" "m"\nZPOSITIVE {positive}\nEND_ORIGINAL_COORDINATE_SYSTEM\nTFACE\n'
        own = TRIANGLES[LABEL == label]
        used = np.unique(own)
        for k, v in enumerate(used):
            x, y, z = enu(VERTICES)[v]
            out += f"{kind} {first + k} {x:.17g} {y:.17g} {z if positive == 'Elevation' else -z:.17g}{' 7' if kind == 'PVRTX' else ''}\n"
        out += "".join("TRGL " + " ".join(str(first + int(np.searchsorted(used, v))) for v in t) + "\n" for t in own) + "END\n"
    return out.encode()


def rsqsim():
    names = ("north fault", "south")
    return ("# x1 y1 z1 ...\n" + "".join(" ".join(f"{c:.17g}" for c in facet.ravel()) + f" {90 - 10 * k} {1e-9 * (1 + k):.17g} {7 + label} {names[label]}\n"
                                         for k, (facet, label) in enumerate(zip(corners(), LABEL)))).encode()


class Convert(FaultTest):
    def convert(self, name, content, *options, code=0):
        with open(self.path(name), "wb") as file:
            file.write(content)
        done = subprocess.run([sys.executable, CONVERT, name, "mesh.h5", *options], cwd=self.folder.name, capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stdout if code == 0 else done.stderr

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

    def test_frame_and_unit(self):
        out = "solid\n" + "".join("facet normal 0 0 1\nouter loop\n" + "".join(f"vertex {x / 1000:.17g} {y / 1000:.17g} {z / 1000:.17g}\n" for x, y, z in facet) + "endloop\nendfacet\n"
                                  for facet in VERTICES[TRIANGLES]) + "endsolid\n"
        self.convert("a.stl", out.encode(), "--frame", "ned", "--unit", "km")
        self.check(1e-9, None)

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
        self.fault("-fault_mesh", "mesh.h5", "-fault_parameters", "fields.h5", *RUN, "-fault_output", "out.h5", "-fault_output_overwrite")
        with h5py.File(self.path("out.h5")) as file:
            np.testing.assert_array_equal(file["mesh/rake"], 90 - 10 * np.arange(len(TRIANGLES)))

    def test_meshio(self):
        """Kinds of files that only meshio reads, as their descriptions have them; lines of VTK are no triangles. Vertices of PLY are in single precision."""
        if not self.meshio():
            self.skipTest("meshio is not installed (Debian's package is python3-meshio)")
        points, n = enu(VERTICES), len(TRIANGLES)
        rows = "".join("{:.17g} {:.17g} {:.17g}\n".format(*place) for place in points)
        faces = "".join("3 {} {} {}\n".format(*t) for t in TRIANGLES)
        vtk = (f"# vtk DataFile Version 3.0\nfault\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {len(points)} double\n{rows}\nCELLS {n + 1} {4 * n + 3}\n2 0 1\n{faces}\n"
               f"CELL_TYPES {n + 1}\n3\n" + n * "5\n")
        ply = (f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\nelement face {n}\n"
               f"property list uchar int vertex_indices\nend_header\n{rows}{faces}")
        for name, content, digits in (("a.vtk", vtk, 1e-12), ("a.ply", ply, 1e-3)):
            self.convert(name, content.encode())
            self.check(digits, None)
        lines = vtk.split("CELLS")[0] + "CELLS 1 3\n2 0 1\n\nCELL_TYPES 1\n3\n"
        for name, content, message in (("a.vtk", lines, "line, expected triangles"), ("a.ply", ply[:150], "meshio cannot read it"), ("a.vtk", "no mesh", "meshio cannot read it")):
            error = self.convert(name, content.encode(), code=1)
            self.assertEqual(error.count("\n"), 1, error)
            self.assertIn(message, error)

    def test_refused(self):
        cases = (("a.stl", b"", "neither text that begins with \"solid\""), ("a.stl", stl_bytes()[:-3], "neither text"), ("a.stl", b"solid\nendsolid\n", "has no triangles"),
                 ("a.stl", stl_text().replace(b"vertex", b"vortex", 1), "line 4: \"vortex\", expected a word of STL"),
                 ("a.stl", stl_text().replace(b"    endloop", b"      vertex 0 0 0\n    endloop", 1), "a facet of 4 vertices"),
                 ("a.stl", stl_text()[:200], "ends within a facet"), ("a.ts", b"", "is empty"), ("a.ts", b"GOCAD VSet 1\n", "expected a TSurf"),
                 ("a.ts", gocad().replace(b"TRGL 1", b"TRGL 99", 1), "there is no 99"), ("a.ts", gocad().replace(b"Elevation", b"Up", 1), "expected Elevation or Depth"),
                 ("a.ts", gocad().replace(b'"m" "m" "m"', b'"ft" "ft" "ft"', 1), "expected m or km"), ("a.txt", b"1 2 3\n", "line 1: 3 columns, expected x1 y1 z1"),
                 ("a.txt", rsqsim().replace(b" 90 1", b" ninety 1", 1), '"ninety", expected a number'),
                 ("a.stl", stl_text().replace(b"vertex 0", b"vertex nan", 1), "is not finite"), ("a.xyz", b"", "meshio"))
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


if __name__ == "__main__":
    unittest.main()
