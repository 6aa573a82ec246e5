#!/usr/bin/env python3
"""slipstep convert: faults of databases and meshes. Traces with dip and depths become rectangles, grids of depths
triangles, the meshes that SlipStep writes receivers; of other files the message says what they are."""

import json
import unittest

from test_convert_sources import ORIGIN, SourcesTest, at, lonlat
import h5py
import meshfiles
import numpy as np

from slipstep.formats import maps, meshes
from slipstep.geometry.cells import corners_of, directions
from slipstep.formats.surfaces import read as read_surfaces

NORTH = np.array([[-5e3, 0, 0], [5e3, 0, 0]])  # a trace to the north


def feature(places, kind="LineString", **properties):
    coordinates = (lonlat(np.asarray(places)).tolist() if kind == "LineString"
                   else [lonlat(np.asarray(line)).tolist() for line in places])
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": coordinates}}


class Traces(SourcesTest):
    def model(self, *features, rake=None):
        return maps.read_traces(self.put("traces.geojson",
                                         json.dumps({"type": "FeatureCollection", "features": features})), at, rake)

    def test_planes(self):
        """A trace to the north at 0 E, of a dip of 60 degrees from 2 to 8 km: to the east by 5 km / tan 60, or to the
        west where the file says so, by names of several databases."""
        out, width = 5e3 / np.tan(np.radians(60)), 6e3 / np.sin(np.radians(60))
        for properties, side in (({"DipDeg": 60, "UpDepth": 2, "LowDepth": 8, "Rake": -90, "FaultName": "one"}, 1),
                                 ({"average_dip": "(60,50,70)", "upper_seis_depth": "(2,,)",
                                   "lower_seis_depth": "(8,7,9)",
                                   "average_rake": "(-90,,)", "name": "one", "dip_dir": "W"}, -1),
                                 ({"dip": "60", "min_depth": 2.0, "max_depth": 8.0, "rake": -90, "name": "one",
                                   "dip_dir": "95"}, 1),
                                 ({"dip": 60, "top_depth": 2, "bottom_depth": 8, "rake": -90, "name": "one",
                                   "dip_direction": "South-West"}, -1)):
            model = self.model(feature(NORTH, **properties))
            np.testing.assert_allclose(model.cells, [[0, side * out, 5e3, 1e4, width, 0 if side > 0 else 180, 60]],
                                       atol=1e-6)
            self.assertEqual((model.rake.tolist(), model.names, model.dropped), ([-90], {1: "one"}, []))
            _, down = directions(model.cells)
            corners = corners_of(model.cells)[0]
            # up dip of the upper edge is the trace
            np.testing.assert_allclose(corners[:2].mean(axis=0) - 2e3 / down[0, 2] * down[0], 0, atol=1e-6)

    def test_parts(self):
        """Each part of a trace is a cell, of several lines as well; what has no depths is named, as are other
        properties."""
        bent = [[0, 0, 0], [0, 3e3, 0], [4e3, 3e3, 0], [4e3, 3e3, 0]]
        model = self.model(feature([bent, NORTH + 2e4], "MultiLineString", dip=90, upper_depth=0, lower_depth=10,
                                   slip_rate=3), feature(NORTH, name="two", upper_depth=1, dip=30), rake=170.0)
        np.testing.assert_allclose(model.cells[:, 2:],
                                   [[5e3, 3e3, 1e4, 90, 90], [5e3, 4e3, 1e4, 0, 90], [5e3, 1e4, 1e4, 0, 90]], atol=2e-6)
        np.testing.assert_allclose(model.cells[:2, :2], [[0, 1.5e3], [2e3, 3e3]], atol=1e-6)
        self.assertEqual((model.rake.tolist(), model.fault.tolist()), ([170] * 3, [1] * 3))
        self.assertEqual(model.dropped, ["1 traces without a dip or depths (two)", "property slip_rate"])
        self.put("traces.geojson", json.dumps(feature(NORTH, dip=60, upper_depth=0, lower_depth=10)))
        self.plot("convert", self.path("traces.geojson"), self.path("out.h5"), "--projection", "sphere", "--rake", "90",
                  "--figure", self.path("out.png"))
        self.fault("-fault_mesh", "out.h5", "-fault_normal_stress", "50e6", "-ts_max_steps", "1", "-ts_max_time", "1",
                   code=3)

    def test_refused(self):
        good = {"dip": 60, "upper_depth": 0, "lower_depth": 10}
        for name, content, message in (
                ("a.geojson", json.dumps(feature(NORTH, dip=60, colour="red")),
                 "1 features of GeoJSON, and none has a dip, an upper and a lower depth; .*colour"),
                ("b.geojson", json.dumps(feature(NORTH, **{**good, "dip": 120})),
                 "feature 1: a dip of 120"),
                ("c.geojson", json.dumps(feature(NORTH, **{**good, "lower_depth": 10000})),
                 "depths of 0 and 10000"),
                ("d.geojson", json.dumps(feature(NORTH, **good)).replace("LineString", "Polygon"),
                 "feature 1: the geometry Polygon"),
                ("e.geojson", json.dumps({**feature(NORTH, **good),
                                          "geometry": {"type": "LineString",
                                                       "coordinates": [[500000, 4e6], [500100, 4e6]]}}),
                 "-360"),
                ("f.geojson", '{"type": "FeatureCollection",\n "features": [', "line 2"),
                ("g.geojson", "[1, 2]", "FeatureCollection")):
            with self.subTest(name):
                self.refuse(name, content, message)


class Depths(SourcesTest):
    def grid(self, sign=-1, nx=5, ny=4):
        """A plane that dips by 1 in 5 to the east, and where one has no depth."""
        lon, lat = np.meshgrid(ORIGIN[0] + 0.1 * np.arange(nx), ORIGIN[1] + 0.1 * np.arange(ny))
        depth = sign * (10 + 20 * (lon - ORIGIN[0]))
        depth[0, 0] = np.nan
        return lon, lat, depth

    def text(self, separator=" ", order=slice(None), **more):
        return "".join(separator.join(f"{v:.6g}" if np.isfinite(v) else "NaN" for v in row) + "\n"
                       for row in np.column_stack([part.ravel() for part in self.grid(**more)])[order])

    def test_surface(self):
        """12 squares less half of one; the plane through all corners; rows in any order, by commas, with depths of
        either sign, in m; on both sides of the 180th meridian; and of netCDF-4."""
        first = maps.read_depths(self.put("slab.xyz", self.text()), at)
        self.assertEqual(len(first.cells), 23)
        corners = first.triangles.reshape(-1, 3)
        east = 111194.926 * np.cos(np.radians(ORIGIN[1]))  # [m] a degree of longitude of a sphere of 6371 km
        np.testing.assert_allclose(corners[:, 2], 1e4 + 2e4 * corners[:, 1] / east, atol=0.1)
        np.testing.assert_allclose(first.cells[:, 6], np.degrees(np.arctan(2e4 / east)), rtol=1e-6)
        # upward
        self.assertTrue((np.cross(first.triangles[:, 1] - first.triangles[:, 0],
                                  first.triangles[:, 2] - first.triangles[:, 0])[:, 2] < 0).all())
        lon, lat, depth = self.grid()
        self.hdf5("slab.grd", x=lon[0], y=lat[:, 0], z=depth)
        for path in (self.put("b.xyz", "lon,lat,depth\n" + self.text(",", slice(None, None, -1))),
                     self.put("c.xyz", self.text(sign=1)), self.path("slab.grd")):
            np.testing.assert_allclose(np.unique(maps.read_depths(path, at).triangles.reshape(-1, 3), axis=0),
                                       np.unique(corners, axis=0), atol=1e-6)
        np.testing.assert_allclose(maps.read_depths(self.put("m.xyz", self.text(sign=1e3)), at, None, "m").cells,
                                   first.cells)
        shifted = np.column_stack([part.ravel() for part in self.grid()]) + (179.8 - ORIGIN[0], 0, 0)
        shifted[:, 0] = (shifted[:, 0] + 180) % 360 - 180
        self.put("d.xyz", "".join(f"{a:.6f} {b:.6f} {c:.6f}\n" for a, b, c in shifted))
        out = self.plot("convert", self.path("d.xyz"), self.path("out.h5"), "--projection", "sphere")
        self.assertRegex(out, r"triangles: +23 in 1 fault(.|\n)*extent: +north -\d.* to \d.*, east -\d.* to \d.*, "
                         r"depth 10 to 18 km(.|\n)*19 of 20 points of the grid have a depth")
        self.assertNotIn("fault refuses", out)
        self.plot("convert", self.path("slab.grd"), "--projection", "sphere", "--figure", self.path("out.png"))

    def test_refused(self):
        self.refuse("a.xyz", "120 30 NaN\n120.05 30 -20.5\n",
                    "a grid of depths of 2 longitudes and 1 latitudes, of which 1 points have one")
        self.refuse("b.xyz", self.text(sign=1e3), "18000 km")
        self.refuse("c.xyz", self.text() + "-70.3 -23.0 30\n", "depths from ")
        self.refuse("d.xyz", "\n".join(f"{k} {k * k % 37} 5" for k in range(30)), "30 points of 30 longitudes")
        self.refuse("e.xyz", "5e5 4e6 -5\n5.1e5 4e6 -5\n5e5 4.1e6 -5\n5.1e5 4.1e6 -5\n", "degrees")
        self.refuse("f.xyz", "120 30\n", "line 1: 2 words")


class Meshes(SourcesTest):
    def test_receivers(self):
        """The .ts and .msh of bends.py's kind, and HDF5 of rectangles and triangles, as receivers: one fault has one
        stress, whatever its file."""
        from test_convert_fsp import single
        self.put("source.fsp", single()[0])
        self.plot("convert", self.path("source.fsp"), self.path("source.h5"), "--projection", "sphere")
        vertices, triangles = meshfiles.plane((4, 3), (1000, 900), 40, 70, (2e4, 5e3, 1e3))
        meshfiles.write_hdf5(self.path("mesh.h5"), vertices, triangles)
        meshfiles.write_gmsh(self.path("mesh.msh"), "4.1", False, vertices, triangles)
        self.put("mesh.ts", "GOCAD TSurf 1\nHEADER {\nname:a\n}\nTFACE\n"
                 + "".join(f"VRTX {k} {y} {x} {-z} 7\n" for k, (x, y, z) in enumerate(vertices.tolist()))
                 + "".join("TRGL {} {} {} CN\n".format(*row) for row in triangles.tolist()) + "END\n")
        found = {}
        for name in ("mesh.h5", "mesh.msh", "mesh.ts"):
            out = self.plot("convert", self.path("source.h5"), "--receivers", self.path(name), "--stress",
                            self.path("out.h5"), "--rake", "170", "--unit", "m")
            self.assertRegex(out, f"stress: +on {len(triangles)} cells of .*{name}")
            found[name] = self.get("out.h5", "shear")
        for name, shear in found.items():  # three decimals of .msh
            np.testing.assert_allclose(shear, found["mesh.h5"], rtol=1e-6, atol=1e-6 * np.abs(shear).max(),
                                       err_msg=name)
        with h5py.File(self.path("mesh.h5"), "a") as file:
            file["vertices"][:, 0] += 4e6
        _, _, err = self.main("convert", self.path("source.h5"), "--receivers", self.path("mesh.h5"), "--stress",
                              self.path("out.h5"), "--unit", "m")
        self.assertRegex(err, "warning: .*mesh.h5 .*4.* km .*source.h5")
        rows = np.array([[0, 0, 1e3, 2e3, 1e3], [2e3, 0, 1e3, 2e3, 1e3]])
        with h5py.File(self.path("cells.h5"), "w") as file:
            file["cells"] = rows
            file["cells"].attrs.update(columns="x y z length width", units="m")
        model = meshes.read(self.path("cells.h5"), at)
        np.testing.assert_array_equal(model.cells, np.column_stack([rows, np.zeros(2), np.full(2, 90.0)]))

    def test_units(self):
        """Lengths whose unit nothing says are asked for, unless they are deeper than any fault in km; another unit than
        the file's is refused."""
        vertices, triangles = meshfiles.plane((2, 2), (100, 90), 40, 70, (0, 0, 10))
        for scale, unit, size in ((1, None, None), (1, "km", 1e3), (1, "m", 1), (10, None, 1)):
            meshfiles.write_gmsh(self.path("a.msh"), "2.2", False, scale * vertices, triangles)
            if size is None:
                self.refused("convert", "a.msh .*--unit m or km", self.path("a.msh"))
                continue
            model = meshes.read(self.path("a.msh"), at, None, unit)
            np.testing.assert_allclose(model.triangles.reshape(-1, 3).max(axis=0), size * scale * vertices.max(axis=0),
                                       rtol=1e-6)

    def test_words_after_numbers(self):
        """Words after the numbers of VRTX and TRGL are left out, which is said."""
        text = ("GOCAD TSurf 1\nHEADER {\nname:a\n}\nTFACE\nVRTX 1 0 0 0{0}\nVRTX 2 1 0 0{0}\nVRTX 3 0 0 -1{0}\nTRGL 1 "
                "2 3{1}\nEND\n")
        plain, more = (read_surfaces(self.put("a.ts", text.replace("{0}", a).replace("{1}", b)))
                       for a, b in (("", ""), (" CNXYZ", " CNXYZ 5")))
        np.testing.assert_array_equal(plain.corners, more.corners)
        self.assertEqual((plain.remarks, more.remarks),
                         ([], ["words after the numbers of 4 vertices and triangles, as properties, are left out"]))
        with self.assertRaisesRegex(Exception, "line 9: TRGL 1 2"):
            read_surfaces(self.put("b.ts", text.replace("{0}", "").replace("TRGL 1 2 3{1}", "TRGL 1 2")))


class Others(SourcesTest):
    def test_patches(self):
        """Eight numbers and more are patches of interact by any name.in, after comments."""
        for text in ("0 0 -5 0 90 1 1 0\n", "# x y z\n\n0 0 -5 0 90 1 1 0 7.5\n"):
            self.assertRegex(self.plot("convert", self.put("any.in", text), "--unit", "km"), "interact")

    def test_what_a_file_is(self):
        for name, content, message in (("a.in", "grid nx=5\ntime t=3\n", "neither an input of HBI, which has a line "
                                        "problem, nor patches of interact"),
                                       ("b.shp", "x", "ogr2ogr"),
                                       ("c.kml", "<kml/>", "ogr2ogr"),
                                       ("d.opts", "-fault_nx 3\n", "options of fault"),
                                       ("e.vtk", "x", "convert_mesh.py"),
                                       ("f.dat", "x", "--format fsp")):
            with self.subTest(name):
                self.refuse(name, content, message)


if __name__ == "__main__":
    unittest.main(verbosity=2)
