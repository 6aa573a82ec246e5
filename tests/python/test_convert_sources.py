#!/usr/bin/env python3
"""slipstep convert: finite faults of the USGS, SRF, files of Coulomb, and slip of runs. Files of known cells become
those cells, whatever their forms; runs become files whose slip and moment are the run's; others are refused by one line
that names the line."""

import os
import sys
import unittest
from unittest import mock

from scripts import PictureTest, FaultTest

import numpy as np

from slipstep import Catalogue, Run
from slipstep.formats import coulomb, fsp, ours, param, runs, srf
from slipstep.formats.projection import Projection
from slipstep.geometry.cells import corners_of, directions
import test_convert_fsp
from test_convert_fsp import plane, pyproj

ORIGIN = (-70.3, -23.4)
SPHERE = Projection(ORIGIN, "sphere")
DEGREE = 1e-6 * 111e3  # [m], the last digit of longitudes here, and more than the rounding of depths
SLIP = 0.1 + 0.03 * np.arange(12)


class SourcesTest(PictureTest, FaultTest):
    def refuse(self, name, content, message):
        self.put(name, content)
        self.refused("convert", f".*{name}.*({message})", self.path(name), self.path("out.h5"), "--projection",
                     "sphere")
        self.assertEqual([f for f in os.listdir(self.folder.name) if f.startswith("out.h5")], [])


def at(lon, lat):
    return Projection(ORIGIN, "sphere")


def lonlat(points):
    return np.column_stack(SPHERE.inverse(points[:, 0], points[:, 1]))


def param_text(share=(0.5, 0.5), margin=0.1, segments=((10.0, 30.0, 4, 3),), size=3e3, top=1e4, up=0.0):
    """Positions at a share of each cell's length and width; the boundary is so many cells within the plane. up: by how
    many cells both are up dip from there."""
    text, cells = f"#Total number of fault_segments= {len(segments):5d}\n", []
    for k, (strike, dip, nx, nz) in enumerate(segments, 1):
        own = plane(strike, dip, 2e4 * k, 0, top, nx, nz, size)
        along, down = directions(own)
        points = own[:, :3] + (share[0] - 0.5) * size * along + (share[1] - 0.5 - up) * size * down
        i, j = (np.array(v) for v in ((margin, nx - margin, nx - margin, margin, margin),
                                      (margin, margin, nz - margin, nz - margin, margin)))
        upper = own[0, :3] - 0.5 * size * (along[0] + (1 + 2 * up) * down[0])
        corners = upper + size * (i[:, None] * along[0] + j[:, None] * down[0])
        text += (f"#Fault_segment = {k:3d} nx(Along-strike)= {nx:3d} Dx= {size / 1e3:5.2f}km ny(downdip)= {nz:3d} Dy= "
                 f"{size / 1e3:5.2f}km\n")
        text += (f"#Boundary of Fault_segment     {k}. EQ in cell 1,1. Lon: {ORIGIN[0]:.4f}   Lat: {ORIGIN[1]:.4f}\n"
                 "#Lon.  Lat.  Depth\n")
        text += "".join(f"  {lon:.6f}  {lat:.6f} {z / 1e3:.6f}\n"
                        for (lon, lat), z in zip(lonlat(corners), corners[:, 2]))
        text += "#Lat. Lon. depth slip rake strike dip t_rup t_ris t_fal mo\n"
        text += "".join(f" {lat:.6f} {lon:.6f} {z / 1e3:.6f} {10 + 3 * n:.6f} {80 + n:.3f} {strike:.3f} {dip:.3f} "
                        f"{2 * n:.3f} 1.5 {0.5 * n:.2f} {1e24 * (n + 1):.6e}\n"
                        for n, ((lon, lat), z) in enumerate(zip(lonlat(points), points[:, 2])))
        cells.append(own)
    return text, np.concatenate(cells)


class Param(SourcesTest):
    def test_positions(self):
        """Cells are the same wherever of them the file has its points."""
        for share in ((0.5, 0.5), (0.3, 0.3), (0.07, 0.17)):
            text, cells = param_text(share)
            model = param.read(self.put("basic.param", text), at)
            np.testing.assert_allclose(model.cells, cells, atol=DEGREE)
            np.testing.assert_allclose(model.slip, SLIP, atol=1e-12)
            np.testing.assert_allclose(model.rake, 80 + np.arange(12))
            np.testing.assert_allclose(model.columns["rupture_time"][0], 2 * np.arange(12))
            np.testing.assert_allclose(model.columns["rise_time"][0], 1.5 + 0.5 * np.arange(12))
            self.assertAlmostEqual(model.moment()[0] / 78e17, 1, 6)  # 1 + ... + 12 times 1e24 dyne cm
            self.assertEqual(len(model.remarks), share != (0.5, 0.5))

    def test_segments(self):
        text, cells = param_text(segments=((10.0, 30.0, 4, 3), (20.0, 45.0, 3, 2)))
        model = param.read(self.put("basic.param", text), at)
        np.testing.assert_allclose(model.cells, cells, atol=DEGREE)
        self.assertEqual([(s.label, s.shape) for s in model.segments], [(1, (3, 4)), (2, (2, 3))])

    def test_refused(self):
        text, _ = param_text()
        lines = text.splitlines(True)
        self.refuse("a.param", "".join(lines[:-1]), f"ends after line {len(lines) - 1} with 0 words, expected 11 "
                    f"numbers, row 12 of 4 x 3|ends after line {len(lines) - 1}, expected 11 numbers, row 12 of 4 x 3")
        self.refuse("b.param", text + lines[-1], f"line {len(lines) + 1}: .*expected the end of 12 rows, nx times ny")
        self.refuse("c.param", text.replace("km ny", "miles ny"), "line 2: lengths in miles and km")
        self.refuse("d.param", text.replace("Dx= ", "DX= "), "line 2")
        self.refuse("e.param", text.replace("t_rup t_ris", "t_ris t_rup"), "line 10")
        self.refuse("f.param", text.replace("segments=     1", "segments=     2"), "1 segments")
        self.refuse("g.param", "".join(lines[:4] + lines[5:]), "line 9: 4 corners of the boundary")
        self.refuse("h.param", "model\n", 'line 1: "model"')
        self.refuse("i.param", text.replace("16.000000", "sixteen"), r"line \d+: \"sixteen\"")


def srf_text(version="2.0", planes=True, strike=350.0, dip=60.0):
    cells = plane(strike, dip, -4e3, 2e3, 2e3)
    top = corners_of(cells[:4])[:, :2].reshape(-1, 3).mean(axis=0)
    (x, y), = lonlat(top[None])
    text = f"{version}\n# a comment\n"
    if planes:
        text += f"PLANE 1\n {x:.6f} {y:.6f} 4 3 12.0 9.0\n {strike:g} {dip:g} {top[2] / 1e3:.6f} 0.5 1.5\n"
    text += "POINTS 12\n"
    for k, (lon, lat) in enumerate(lonlat(cells)):
        more = " 3.00000e+05 2.70000e+00" if version == "2.0" else ""
        text += f" {lon:.6f} {lat:.6f} {cells[k, 2] / 1e3:.6f} {strike:g} {dip:g} 9.0e+10 {0.5 * k:.4f} 0.05{more}\n"
        text += (f" 90 {100 * SLIP[k] * np.cos(0.3):.8f} 8 {100 * SLIP[k] * np.sin(0.3):.8f} 0 0.0 0\n 0 1 2 3 "
                 "4 3\n 2 1\n")
    return text, cells


class Srf(SourcesTest):
    def test_versions(self):
        """Slip along the rake and across it become one; 2.7 g/cm3 (3 km/s)^2 = 24.3 GPa."""
        for version in ("1.0", "2.0"):
            text, cells = srf_text(version)
            model = srf.read(self.put("model.srf", text), at)
            np.testing.assert_allclose(model.cells, cells, atol=DEGREE)
            np.testing.assert_allclose(model.slip, SLIP, rtol=1e-8)
            np.testing.assert_allclose(model.rake, 90 + np.degrees(0.3), rtol=1e-8)
            np.testing.assert_allclose(model.columns["rupture_time"][0], 0.5 * np.arange(12))
            np.testing.assert_allclose(model.columns["rise_time"][0], 0.4)
            self.assertAlmostEqual(model.moment()[0] / ((24.3e9 if version == "2.0" else 30e9) * 9e6 * SLIP.sum()), 1,
                                   7)
            self.assertEqual((model.segments[0].shape, model.remarks), ((3, 4), []))

    def test_without_planes(self):
        """Squares of 9 km2 at the points."""
        text, cells = srf_text(planes=False)
        model = srf.read(self.put("model.srf", text), at)
        np.testing.assert_allclose(model.cells, cells, atol=DEGREE)
        self.assertRegex(model.remarks[0], "no planes")

    def test_there_and_back(self):
        """.srf to .h5 and .srf again: slip, rake, times and moment."""
        text, cells = srf_text()
        self.put("a.srf", text)
        for before, after in (("a.srf", "b.h5"), ("b.h5", "c.srf")):
            self.plot("convert", self.path(before), self.path(after), "--origin", *map(str, ORIGIN), "--projection",
                      "sphere", "--step", "0.05")
        one, two = (srf.read(self.path(name), at) for name in ("a.srf", "c.srf"))
        np.testing.assert_allclose(two.cells, one.cells, atol=DEGREE)
        np.testing.assert_allclose(two.slip, one.slip, atol=0.5e-6)  # 1e-4 cm
        np.testing.assert_allclose(two.columns["rupture_time"][0], one.columns["rupture_time"][0])
        np.testing.assert_allclose(two.columns["rise_time"][0], one.columns["rise_time"][0])
        self.assertAlmostEqual(two.moment()[0] / one.moment()[0], 1, 5)

    def test_round_trips(self):
        """Rise times stay what they are, whatever the step, those of cells without slip as well."""
        self.put("0.srf", srf_text()[0].replace(f" {100 * SLIP[3] * np.cos(0.3):.8f} 8 "
                                                f"{100 * SLIP[3] * np.sin(0.3):.8f} ", " 0 8 0 "))
        for number, step in enumerate((0.1, 0.05, 0.3, 0.1, 0.07)):
            self.plot("convert", self.path(f"{number}.srf"), self.path(f"{number + 1}.srf"), "--origin",
                      *map(str, ORIGIN), "--projection", "sphere", "--step", str(step))
            model = srf.read(self.path(f"{number + 1}.srf"), at)
            np.testing.assert_allclose(model.columns["rise_time"][0], 0.4, rtol=1e-6)  # seven digits of dt
            np.testing.assert_allclose(model.slip, np.where(np.arange(12) == 3, 0, SLIP), atol=0.5e-6)

    def test_no_slip(self):
        """It is said in place of a moment of 0 and a magnitude that is none, and changes no stress."""
        text = "1.0\nPOINTS 2\n" + "".join(f"10.0 {45 + k / 100} 1 0 90 4e10 {k} 0.1\n180 0 3 0 0 0 0\n0 0 0\n"
                                           for k in range(2))
        out = self.plot("convert", self.put("a.srf", text), self.path("a.h5"), "--projection", "sphere")
        self.assertRegex(out, "slip: +none: .*2 cells")
        self.assertNotRegex(out, "Mw|nan|moment:")
        for name in ("b.srf", "c.fsp"):
            self.plot("convert", self.path("a.h5"), self.path(name))
        self.assertFalse(fsp.read(self.path("c.fsp"), at).slip.any())
        self.put("geom.in", "0 0 -5 0 90 1 1 0\n")
        for name, words in (("a.h5", "has no slip in any cell"), ("geom.in", "has no slip")):
            self.refused("convert", f"{name} {words}, expected a slip model for --stress", self.path(name),
                         "--receivers", self.path("a.h5"), "--stress", self.path("out.h5"), "--unit", "km")

    def test_hypocentre(self):
        """That of a plane, 0.5 km from the middle of its upper edge along strike and 1.5 km down dip, is one place on
        the Earth through .h5, .fsp and .srf again, of two planes as well; where a file says none, it is the cell that
        breaks first."""
        text, cells = srf_text()
        along, down = (v[0] for v in directions(cells[:1]))
        place = corners_of(cells[:4])[:, :2].reshape(-1, 3).mean(axis=0) + 500 * along + 1500 * down
        self.put("0.srf", text)
        names = ["0.srf", "1.h5", "2.fsp", "3.srf", "4.fsp", "5.h5", "6.srf"]
        for before, after in zip(names, names[1:]):
            self.plot("convert", self.path(before), self.path(after), "--origin", *map(str, ORIGIN), "--projection",
                      "sphere")
            model = ({"srf": srf, "fsp": fsp}[after[2:]].read(self.path(after), at) if not after.endswith("h5")
                     else ours.read(self.path(after)))
            np.testing.assert_allclose(model.hypocentre(), place, atol=1.5, err_msg=after)  # five digits of degrees
        self.assertRegex(open(self.path("2.fsp"), encoding="utf-8").read(), "HypX = 6.5000 km   HypZ = 1.5000 km")
        silent = srf.read(self.put("a.srf", text.replace(" 0.5 1.5\n",
                                                         " 0 0\n").replace("9.0e+10 0.0000", "9.0e+10 9.0000")), at)
        self.assertNotIn("hypocentre", silent.claims)
        np.testing.assert_array_equal(silent.hypocentre(), silent.cells[1, :3])
        # at the upper left corner of the second plane, but for its depth
        two = self.put("two.fsp", test_convert_fsp.double()[0].replace("DEP = 5.0", "DEP = 4.0"))
        self.plot("convert", two, self.path("two.srf"), "--projection", "sphere", "--rise-time", "1")
        lines = self.content("two.srf").splitlines()
        self.assertEqual([line.split()[3:] for line in lines[4:8:2]][0], ["0", "0"])
        np.testing.assert_allclose([float(word) for word in lines[6].split()[3:]], [-6, 4], atol=2e-3)

    def test_rates(self):
        """The sum of samples times the step is the slip, of .fsp that has rupture times but no rise times."""
        from test_convert_fsp import single
        self.put("model.fsp", single()[0])
        self.refused("convert", "--rise-time S", self.path("model.fsp"), self.path("out.srf"), "--projection", "sphere")
        self.plot("convert", self.path("model.fsp"), self.path("out.srf"), "--projection", "sphere", "--rise-time",
                  "1.3", "--step", "0.2")
        words = self.content("out.srf").split("POINTS 12\n")[1].split()
        for k in range(12):
            head, words = words[:17], words[17:]
            n, dt = int(head[12]), float(head[7])
            self.assertAlmostEqual(dt * sum(map(float, words[:n])), float(head[11]), delta=1e-4 * float(head[11]))
            self.assertAlmostEqual(float(head[11]), 100 * (0.1 + 0.03 * k), 3)
            self.assertLessEqual(dt, 0.2)
            words = words[n:]
        self.assertEqual(words, [])

    def test_refused(self):
        text, _ = srf_text()
        lines = text.splitlines(True)
        self.refuse("a.srf", "".join(lines[:-1]),
                    f"ends after line {len(lines) - 1}, expected point 12 of 12: 8 samples of slip rate")
        self.refuse("b.srf", "".join(lines[:-4]),
                    f"ends after line {len(lines) - 4}, expected point 12 of 12: 10 numbers")
        self.refuse("c.srf", text.replace("POINTS 12", "POINTS 11"), r"line \d+: .*PLANE N or POINTS N")
        self.refuse("d.srf", text.replace("2.0\n", "3.0\n", 1), 'line 1: "3.0"')
        self.refuse("e.srf", text.replace(" 2 1\n", " 2 1 0\n", 1), r"line 10: 1 samples too many")
        self.refuse("f.srf", text.replace("POINTS 12", "POINTS many"), 'line 6: "many"')
        self.refuse("g.srf", "2.0\n", "ends after line 1")
        self.refuse("h.srf", text.replace(" 350 60 9.0e+10", " 350 60 large", 1), 'line 7: "large"')


COULOMB = """a test with Mo = 1.0e25 dyne-cm
two lines
#reg1=  0  #reg2=  0  #fixed=   3  sym=  1
 PR1=       0.250     PR2=       0.250   DEPTH=       7.5
  E1=      8.000e+05   E2=      8.000e+05
FRIC=          0.400

  #   X-start    Y-start     X-fin      Y-fin   Kode  {names}   dip angle     top      bot
xxx xxxxxxxxxx xxxxxxxxxx xxxxxxxxxx xxxxxxxxxx xxx xxxxxxxxxx xxxxxxxxxx xxxxxxxxxx xxxxxxxxxx xxxxxxxxxx
  1     1.0000     2.0000     1.0000    12.0000 100     {one}    30.0000     4.0000     9.0000   north
  2    -5.0000     0.0000     5.0000     0.0000 100     {two}    90.0000     0.0000    10.0000
  3    -5.0000     0.0000     5.0000     0.0000 400     0.0 0.0    90.0000     0.0000    10.0000

    Grid Parameters
     Map info
  3  ---------------------------- zero lon =     -124.5000000
  6  ---------------------------- zero lat =      40.3000000
"""


class Coulomb(SourcesTest):
    def test_cells(self):
        """The upper edge at x = 1 km, a dip of 30 degrees to the east: the centre is 2.5 km / tan 30 further; E of 8e5
        bar is 32 GPa. Right-lateral slip has the rake 180."""
        for names, one, two in (("rt.lat    reverse", "0.0 0.8", "1.5 0.0"),
                                ("rake     netslip", "90.0 0.8", "180.0 1.5")):
            model = coulomb.read(self.put("model.inp", COULOMB.format(names=names, one=one, two=two)),
                                 lambda lon, lat: Projection((lon, lat), "sphere"))
            np.testing.assert_allclose(model.cells, [[7e3, 1e3 + 2.5e3 / np.tan(np.radians(30)), 6.5e3, 1e4, 1e4, 0,
                                                      30], [0, 0, 5e3, 1e4, 1e4, 90, 90]], atol=1e-9)
            np.testing.assert_allclose(model.slip, [0.8, 1.5])
            np.testing.assert_allclose(model.rake, [90, 180])
            self.assertEqual((model.options["poisson_ratio"], model.options["shear_modulus"], model.names),
                             (0.25, 32e9, {1: "north"}))
            self.assertAlmostEqual(model.moment()[0], 32e9 * 1e8 * 2.3, delta=1e5)
            self.assertRegex(model.dropped[0], "1 elements of Kode 400")
        self.assertEqual(model.claims["moment"], 1e18)

    def test_origin(self):
        """Cells are where the zero of the file is, whatever the origin of the frame."""
        text = self.put("model.inp", COULOMB.format(names="rake     netslip", one="90.0 0.8", two="180.0 1.5"))
        own, other = (coulomb.read(text, lambda lon, lat: Projection(origin or (lon, lat), "sphere"))
                      for origin in (None, (-124.0, 40.0)))
        for model in (own, other):
            lon, lat = model.projection.inverse(*model.cells[:, :2].T)
            np.testing.assert_allclose(lat[1], 40.3, atol=1e-9)
            np.testing.assert_allclose(lon[1], -124.5, atol=1e-9)
        np.testing.assert_allclose(other.cells[1, :2], Projection((-124.0, 40.0), "sphere").forward(-124.5, 40.3),
                                   atol=1e-6)

    def test_refused(self):
        text = COULOMB.format(names="rt.lat    reverse", one="0.0 0.8", two="1.5 0.0")
        self.refuse("a.inp", text.replace("xxx xxx", "--- ---"), "xxx xxxxxxxxxx")
        self.refuse("b.inp", text.replace("reverse", "inverse"), "line 8")
        self.refuse("c.inp", text.replace("4.0000     9.0000   north", ""), "line 10: 9 numbers")
        self.refuse("d.inp", text.replace("30.0000     4.0000", "-30.0000     4.0000"), "line 10: a dip of -30")
        self.refuse("e.inp", text.replace("4.0000     9.0000", "9.0000     4.0000"), "line 10: .*9 .*4 km")
        self.refuse("f.inp", text[:text.index("  1   ")], "Kode 100")


class Longitudes(SourcesTest):
    """What a file becomes depends on where it is on the Earth no more on the 180th meridian than elsewhere: cells, and
    rows of .fsp and .srf that are written of them."""

    def texts(self, lon):
        """Files of each kind about a longitude; those of .param and .srf that name no origin as well."""
        me = sys.modules[__name__]
        with mock.patch.multiple(me, ORIGIN=(lon, -20.0), SPHERE=Projection((lon, -20.0), "sphere")), mock.patch.object(
            test_convert_fsp, "SPHERE", Projection((lon, -20.0), "sphere")):
            yield fsp, test_convert_fsp.single()[0].replace("LAT  = 34.2      LON = -116.43",
                                                            f"LAT = -20.0 LON = {lon}")
            yield srf, srf_text()[0]
            yield param, param_text()[0]
            yield param, param_text()[0].replace("Lon:", "none:")
            yield coulomb, COULOMB.format(names="rake     netslip", one="90.0 0.8", two="180.0 1.5").replace(
                "-124.5000000", str(lon)).replace("40.3000000", "-20.0")

    def test_meridian(self):
        for kind in ("sphere", "tmerc") if pyproj else ("sphere",):
            models = {}
            for lon in (20.0, 180.0, -180.0, 179.95, 179.97, -179.97):  # of cells some are on the other side
                for number, (reader, text) in enumerate(self.texts(lon)):
                    with self.subTest(kind=kind, lon=lon, number=number):
                        model = reader.read(self.put("model.txt", text), lambda *origin: Projection(origin, kind))
                        first = models.setdefault(number, model)
                        # digits of LON are other ones
                        np.testing.assert_allclose(model.cells, first.cells, atol=2 * DEGREE if reader is not fsp
                                                   else 2 * 0.5e-5 * 111e3)
                        self.assertTrue(-180 < model.projection.origin[0] <= 180)
                        for write in (fsp.write, srf.write):
                            model.columns.setdefault("rise_time", (np.ones(len(model.cells)), "s"))
                            model.columns.setdefault("rupture_time", (np.ones(len(model.cells)), "s"))
                            with open(self.path("out.txt"), "w", encoding="utf-8") as file:
                                write(model, file)
                            again = (fsp if write is fsp.write else srf).read(self.path("out.txt"),
                                                                              lambda *_: model.projection)
                            # digits of LON
                            np.testing.assert_allclose(again.cells[:, :5], model.cells[:, :5], atol=1.5)
                            # convergence between an upper edge and its cell's centre, 4 km away
                            np.testing.assert_allclose((again.cells[:, 5] - model.cells[:, 5] + 180) % 360, 180,
                                                       atol=0.02)

    @unittest.skipUnless(pyproj, "needs python3-pyproj")
    def test_torn(self):
        """A map that ends at the meridian has its two sides 40,000 km apart."""
        text = dict((reader, text) for reader, text in self.texts(179.95))[srf]
        self.refused("convert", "--projection EPSG:3857 has", self.put("model.srf", text), "--projection", "EPSG:3857")
        self.plot("convert", self.path("model.srf"), "--projection", "EPSG:32760")


class Runs(SourcesTest):
    def test_run(self):
        """A dipping fault of 8 x 6 cells: .srf and .fsp have the slip of the run, and its moment; the moment rate in
        the form of the USGS adds up to it."""
        self.fault(*"-fault_nx 8 -fault_nz 6 -fault_strike 30 -fault_dip 60 -fault_depth_top 500 -fault_rake 90 "
                    "-ts_max_time 20s -fault_output run.h5".split())
        run = Run(self.path("run.h5"))
        slip = run.field("slip")[1][-1].ravel()
        moment = run.series["moment"][-1].sum()
        for name in ("run.srf", "run.fsp"):
            self.plot("convert", self.path("run.h5"), self.path(name), "--origin", *map(str, ORIGIN), "--projection",
                      "sphere")
        one = srf.read(self.path("run.srf"), at)
        np.testing.assert_allclose(one.slip, slip, atol=1e-6)
        np.testing.assert_allclose(one.rake, 90)
        self.assertAlmostEqual(one.moment()[0] / moment, 1, 4)
        out = self.plot("convert", self.path("run.fsp"), "--projection", "sphere")
        self.assertRegex(out, "strike, dip: +30, 60 degrees")
        self.plot("moment_rate", self.path("run.h5"), "--window", "0", "20", "--usgs", self.path("run.mr"), "--step",
                  "0.25")
        with open(self.path("run.mr"), encoding="utf-8") as file:
            self.assertEqual([next(file), next(file)], ["dt: 0.25\n", "Time[s]     Moment_Rate [Nm]\n"])
            time, rate = np.loadtxt(file).T
        np.testing.assert_allclose(np.diff(time), 0.25)
        self.assertAlmostEqual(0.25 * rate.sum() / moment, 1, 9)
        self.refused("convert", "--origin", self.path("run.h5"), self.path("out.srf"))

    def test_window(self):
        """A window of a run: rupture and rise times are those of a fine table of each cell's slip; samples add up to
        its slip, whether cells are in memory together or one row of them at a time; too many samples are refused, which
        .fsp does not have."""
        self.fault(*"-fault_nx 8 -fault_nz 6 -fault_depth_top 500 -ts_max_time 20s -fault_output run.h5".split())
        run, window, place = Run(self.path("run.h5")), (1.5, 9.25), ("--origin", *map(str, ORIGIN), "--projection",
                                                                     "sphere")
        times, slip = run.field("slip")
        grid = np.linspace(*window, 200001)
        texts = []
        for together in (runs.TOGETHER, 1):
            with mock.patch.object(runs, "TOGETHER", together):
                self.plot("convert", self.path("run.h5"), self.path("run.srf"), *place, "--window", *map(str, window))
            texts.append(self.content("run.srf"))
        self.assertEqual(*texts)
        self.plot("convert", self.path("run.h5"), self.path("run.h5.h5"), "--window", *map(str, window))
        model, one = ours.read(self.path("run.h5.h5")), srf.read(self.path("run.srf"), at)
        for cell, course in enumerate(slip.reshape(len(times), -1).T):
            course = np.interp(grid, times, course)
            total = course[-1] - course[0]
            self.assertAlmostEqual(one.slip[cell], total, 5)
            if total:
                begun, done = (grid[np.argmax(course - course[0] >= share * total)] - window[0]
                               for share in (0.02, 0.98))
                # four steps of the table
                self.assertAlmostEqual(model.columns["rupture_time"][0][cell], begun, delta=2e-4)
                self.assertAlmostEqual(model.columns["rise_time"][0][cell], done - begun, delta=2e-4)
        words = texts[0].split("POINTS 48\n")[1].split()
        for cell in range(48):
            head, words = words[:17], words[17:]
            self.assertAlmostEqual(float(head[7]) * sum(map(float, words[:int(head[12])])), 100 * one.slip[cell],
                                   delta=1e-3)
            words = words[int(head[12]):]
        self.refused("convert", "from 1.5 s to 9.25 s has 7.75e[+]07 slip rates, .* in each of 48 cells",
                     self.path("run.h5"), self.path("out.srf"), *place, "--window", *map(str, window), "--step", "1e-7")
        self.assertFalse([name for name in os.listdir(self.folder.name) if name.startswith("out.")])
        self.plot("convert", self.path("run.h5"), self.path("out.fsp"), *place, "--window", *map(str, window), "--step",
                  "1e-7")

    def test_event(self):
        """The largest event of a catalogue, with the rupture times of its map."""
        self.fault(*"-fault_nx 6 -fault_nz 5 -fault_output run.h5 -fault_catalogue events.h5 -fault_catalogue_maps "
                    "-ts_max_time 30".split())
        catalogue = Catalogue(self.path("events.h5"))
        slip, rupture = (catalogue.map(name)[0].ravel() for name in ("slip", "rupture_time"))
        for name in ("event.fsp", "event.srf"):
            self.plot("convert", self.path("events.h5"), self.path(name), "--origin", *map(str, ORIGIN), "--projection",
                      "sphere", "--rise-time", "1")
        one = srf.read(self.path("event.srf"), at)
        np.testing.assert_allclose(one.slip, np.abs(slip), atol=1e-6)
        np.testing.assert_allclose(one.columns["rupture_time"][0], rupture, atol=1e-4)
        self.assertAlmostEqual(one.moment()[0] / catalogue.event["moment"][0], 1, 3)


if __name__ == "__main__":
    unittest.main(verbosity=2)
