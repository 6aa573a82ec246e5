#!/usr/bin/env python3
"""slipstep convert: signs, factors and limits of the readers and writers of other programs, each by a value that is
known from elsewhere."""

import json
import re
import unittest

from test_convert_sources import COULOMB, ORIGIN, SourcesTest, param_text, srf_text
import numpy as np

from slipstep.formats import coulomb, faults, fsp, maps, param, srf
from slipstep.formats.model import Model, Segment
from slipstep.formats.projection import Projection
from slipstep.geometry.cells import corners_of, directions
from test_convert_faults import DFN
from test_convert_fsp import COLUMNS, HEADER, plane, pyproj, rows, single
from test_convert_maps import feature

FAR = 4.0  # [degrees] of longitude: how far frames are from their origin
PLACE = (ORIGIN[0] - FAR, ORIGIN[1])
# [degrees], clockwise from true north: the strike of x there, of a transverse Mercator projection to the first order in
# the longitude; the next term is 0.006 times as large
TURN = FAR * np.sin(np.radians(ORIGIN[1]))
CLOSE = 0.03  # [degrees], of that term and of files a few km away


def far(lon, lat):
    return Projection(PLACE)


@unittest.skipUnless(pyproj, "needs python3-pyproj")
class Convergence(SourcesTest):
    """Strikes of files are from true north; cells have them less the strike of x, at PLACE."""

    def strikes(self, path):
        """Of the plane and of the first point of an .srf."""
        with open(path, encoding="utf-8") as file:
            lines = [line.split() for line in file if not line.startswith("#")]
        first = next(k for k, words in enumerate(lines) if words[0] == "POINTS")
        return float(lines[3][0]), float(lines[first + 1][3])

    def test_srf(self):
        for planes in (True, False):
            model = srf.read(self.put("a.srf", srf_text(planes=planes, strike=300.0)[0]), far)
            np.testing.assert_allclose(model.cells[:, 5], 300 - TURN, atol=CLOSE)
            with open(self.path("b.srf"), "w", encoding="utf-8") as file:
                srf.write(model, file)
            plane_of, point = self.strikes(self.path("b.srf"))
            self.assertAlmostEqual(point, 300, delta=CLOSE)
            if planes:
                self.assertAlmostEqual(plane_of, 300, delta=1e-3)
                self.assertAlmostEqual(model.segments[0].strike, 300, delta=1e-3)
                row = model.cells[1, :3] - model.cells[0, :3]  # of the grid, whose places know nothing of strikes
                self.assertAlmostEqual(np.degrees(np.arctan2(row[1], row[0])) % 360, 300 - TURN, delta=CLOSE)

    def test_coulomb(self):
        """x is east and y north where the zero is: cells are at the same longitudes and latitudes in a frame about it
        and in one far away, and have the same strike."""
        text = self.put("a.inp", COULOMB.format(names="rake     netslip", one="90.0 0.8", two="180.0 1.5").replace(
            "-124.5", str(ORIGIN[0])).replace("40.3", str(ORIGIN[1])))
        own, other = coulomb.read(text, lambda lon, lat: Projection((lon, lat))), coulomb.read(text, far)
        places = [np.array(model.projection.inverse(*model.cells[:, :2].T)) for model in (own, other)]
        np.testing.assert_allclose(places[1], places[0], atol=2e-4)  # 7 km times the scale of the map, 1.002
        np.testing.assert_allclose((own.cells[:, 5] - other.cells[:, 5] + 180) % 360, 180 + TURN, atol=CLOSE)
        other.columns["rupture_time"] = (np.zeros(2), "s")
        with open(self.path("b.fsp"), "w", encoding="utf-8") as file:
            fsp.write(other, file)
        self.assertAlmostEqual((float(re.search(r"STRIKE = (\S+)", self.content("b.fsp"))[1]) + 180) % 360, 180,
                               delta=2 * CLOSE)

    def test_side_of_trace(self):
        """Of a trace to true north that dips by less than the turn to one side of it: directions of dip are from true
        north too."""
        lon, lat = ORIGIN
        for towards, strike in ((0.5, 0.0), (359.5, 180.0)):
            trace = {"type": "Feature", "properties": {"dip": 50, "upper_depth": 3, "lower_depth": 9,
                                                       "dip_dir": towards},
                     "geometry": {"type": "LineString", "coordinates": [[lon, lat - 0.05], [lon, lat + 0.05]]}}
            model = maps.read_traces(self.put("a.geojson", json.dumps(trace)), far)
            self.assertAlmostEqual((model.cells[0, 5] + TURN - strike + 180) % 360, 180, delta=CLOSE)


class Places(SourcesTest):
    def test_coordinates_of_fsp(self):
        """X and Y are those from the epicentre, whatever the origin of the frame; Mw is that of Mo by 2/3 (log10 Mo -
        9.1)."""
        self.put("a.fsp", single()[0])
        self.plot("convert", self.path("a.fsp"), self.path("b.fsp"), "--projection", "sphere", "--origin", "-115.43",
                  "34.2")
        tables = []
        for name in ("a.fsp", "b.fsp"):
            text = self.content(name)
            tables.append([[float(word) for word in line.split()[2:5]] for line in text.splitlines() if line
                           and not line.startswith("%")])
        np.testing.assert_allclose(*tables, atol=2e-3)  # [km], digits of LON
        self.assertAlmostEqual(float(re.search(r"Mw = (\S+)", text)[1]), 2 / 3 * (np.log10(2.3456e18) - 9.1), 3)

    def fsp_of(self, cells, strike, **said):
        text = HEADER.format(strike=strike, dip=60.0, segments=1, place="top-center",
                             count="") + COLUMNS.format(x="X==EW", y="Y==NS") + "".join(rows(cells))
        for name, value in said.items():
            text = re.sub(rf"{name}(\s*)= +[\d.]+", rf"{name}\1= {value}", text)
        return fsp.read(self.put("model.fsp", text), lambda lon, lat: Projection((lon, lat), "sphere"))

    def test_rounded_sizes(self):
        """Dx of 3.0 km whose LEN and points say 2.96 is that; LEN of something else is not taken."""
        cells = plane(350.0, 60.0, 0, 0, 2e3, size=2960.0)
        for length, expected in ((11.84, 2960.0), (9.0, 3000.0)):
            model = self.fsp_of(cells, 350.0, LEN=length, WID=8.88, Dz="2.96 km #")
            np.testing.assert_allclose(model.cells[:, 3], expected, rtol=1e-9)

    def test_rounded_strike(self):
        """Points of 40 cells that run along 350.7 degrees where the header says 350: that is taken; where they run
        along 353, more than a degree off, they keep their places."""
        for off, shape in ((0.7, (3, 40)), (3.0, None)):
            cells = plane(350.0 + off, 60.0, 0, 0, 2e3, nx=40)
            model = self.fsp_of(cells, 350.0, LEN=120.0)
            self.assertEqual(model.segments[0].shape, shape)
            if shape:
                np.testing.assert_allclose(model.cells[:, 5], 350.7, atol=2e-3)  # the last digits of places over 120 km

    def test_awry(self):
        """A point a sixth of a cell away is put into the grid, one 0.4 of it away is not, nor are the others then."""
        for away, shape in ((500.0, (3, 4)), (1200.0, None)):
            cells = plane(0.0, 60.0, 0, 0, 2e3)
            cells[5, 0] += away
            model = self.fsp_of(cells, 0.0)
            self.assertEqual(model.segments[0].shape, shape)
            self.assertRegex(model.remarks[-1], f"points of the file are up to {away * 11 / 12:.0f} m" if shape
                             else "in no grid of one strike and dip; its cells are at the points")

    def test_srf_sides(self):
        """Where one point of a plane is missing, cells at the others have its sides, but squares of the areas of points
        where these are other ones."""
        text, cells = srf_text()
        lines = text.splitlines(True)
        short = "".join(lines[:-4]).replace("POINTS 12", "POINTS 11").replace(
            " 4 3 12.0 9.0", " 4 3 12.0 6.75").replace("9.0e+10", "6.75e+10")
        for content, sides in ((short, (3000, 2250)), (short.replace("6.75e+10", "4.0e+10"), (2000, 2000))):
            model = srf.read(self.put("a.srf", content), lambda *_: Projection(ORIGIN, "sphere"))
            np.testing.assert_allclose(model.cells[:, 3:5], [sides] * 11)
            np.testing.assert_allclose(model.cells[:, :3], cells[:11, :3], atol=0.2)

    def test_srf_numbers(self):
        """mag= by genslip's constant, 9.05; slip across the rake alone, which lasts longest."""
        model = srf.read(self.put("a.srf", srf_text()[0].replace("# a comment", "# mag= 6.50")),
                         lambda *_: Projection(ORIGIN, "sphere"))
        self.assertAlmostEqual(model.claims["moment"] / 10 ** (1.5 * 6.5 + 9.05), 1, 12)
        model = srf.read(self.put("b.srf", "1.0\nPOINTS 1\n10 45 1 0 90 4e10 0 0.1\n0 0 0 50 4 0 0\n1 2 1 1\n"),
                         lambda *_: Projection((10, 45), "sphere"))
        self.assertEqual((model.slip[0], model.rake[0], model.columns["rise_time"][0][0]), (0.5, 90, 0.4))

    def test_param_upper_edges(self):
        """Positions that as centres would be above the ground are upper edges."""
        text, cells = param_text(top=0.0, up=0.5)  # half a cell of 3 km that dips by 30 degrees is 750 m high
        model = param.read(self.put("b.param", text), lambda *_: Projection(ORIGIN, "sphere"))
        np.testing.assert_allclose(model.cells, cells, atol=0.2)
        self.assertRegex(model.remarks[0], "750 m")

    def test_quake_dfn(self):
        """f0 by rate and state at the start, where neither is steady at V0; a dip of 120 degrees is one of 60 of the
        other strike, and its rake is seen from there."""
        text = DFN.replace("0.02\t0.13\t1.3e8\t1e-9",
                           "0.02\t0.13\t2.6e8\t1e-8").replace("0.0\t60.0\t1.0", "0.0\t120.0\t1.0")
        model = faults.read_dfn(self.put("dfn.txt", text), None)
        self.assertAlmostEqual(model.fields["friction_reference"][0][6], 0.6 - 0.01 * np.log(10) - 0.02 * np.log(2), 12)
        np.testing.assert_allclose(model.cells[6, 5:], [270, 60])
        before = faults.read_dfn(self.put("dfn.txt", DFN), None)
        np.testing.assert_allclose(model.cells[6, :3], before.cells[6, :3])

    def test_hypocentre_of_planes(self):
        """Of three planes in a row, the one that it is in, and where it is there; beside them all, the nearest."""
        cells = np.concatenate([plane(30.0, 70.0, *(k * 12e3 * np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)])), 1e3)
                                for k in range(3)])
        parts = [Segment(k + 1, np.arange(12 * k, 12 * k + 12), (3, 4), 30.0) for k in range(3)]
        model = Model("of a test", "cells", cells, np.zeros(36), np.ones(36), segments=parts)
        along, down = (v[0] for v in directions(cells[:1]))
        for s, d, number, place in ((2e3, 1e3, 0, (2e3, 1e3)), (17e3, 8e3, 1, (5e3, 8e3)), (25e3, 4e3, 2, (1e3, 4e3)),
                                    (-3e3, 2e3, 0, (-3e3, 2e3)), (40e3, 20e3, 2, (16e3, 20e3))):
            model.claims["start"] = (corners_of(cells)[0, 0] + s * along + d * down + 50
                                     * np.cross(along, down)).tolist()
            found = model.on_plane(parts)
            self.assertEqual(found[0], number)
            np.testing.assert_allclose(found[1:], place, atol=1e-6)

    def test_trace(self):
        """Of any direction: up dip of the upper edge of each cell is its part of the trace."""
        for angle in (30.0, 100.0, 250.0):
            turn = np.radians(angle)
            ends = np.array([[-5e3, 0, 0], [5e3, 0, 0]]) @ np.array([[np.cos(turn), np.sin(turn), 0],
                                                                     [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
            text = self.put("a.geojson", json.dumps(feature(ends, dip=50, upper_depth=3, lower_depth=9)))
            model = maps.read_traces(text, lambda *_: Projection(ORIGIN, "sphere"))
            _, down = directions(model.cells)
            np.testing.assert_allclose(corners_of(model.cells)[0, :2] - 3e3 / down[0, 2] * down[0], ends, atol=1e-5)
            self.assertAlmostEqual(model.cells[0, 5], angle, 6)


if __name__ == "__main__":
    unittest.main(verbosity=2)
