#!/usr/bin/env python3
"""slipstep convert: slip models of SRCMOD in and out. Files of known cells become those cells; files go there and back
with the same digits; others are refused by one line that names the line, and nothing is written."""

import os
import re
import sys
import unittest
from types import SimpleNamespace
from unittest import mock

from scripts import BUILD, FaultTest, PictureTest

import h5py
import meshfiles
import numpy as np

from slipstep.formats import fsp, ours
from slipstep.formats.model import Model
from slipstep.formats.projection import Projection
from slipstep.geometry.cells import axis_along_strike, corners_of, directions
from slipstep.geometry.surface import Elastic, slip_of_input
from slipstep.geometry.unroll import unroll
from slipstep.plots.maps import planes_of
from slipstep.plots.model import draw
from slipstep.plots.panels import plt

try:
    import pyproj
except ImportError:
    pyproj = None

ORIGIN = (-116.43, 34.2)
SPHERE = Projection(ORIGIN, "sphere")
DIGITS = 0.6  # [m]: half of the last of five digits of LAT, by which a plane is where it is
HEADER = """% ----------------------------------  FINITE-SOURCE RUPTURE MODEL  --------------------------------
%
% Event : Somewhere 06/28/1992 [one (1994)]
% EventTAG: s1992SOME01ONE
%
% Loc  : LAT  = 34.2      LON = -116.43      DEP = 5.0
% Size : LEN  = 12.0 km   WID =  9.0 km      Mw = 6.17    Mo = 2.3456e+18 Nm
% Mech : STRK = {strike}  DIP = {dip}        RAKE = 170.0 Htop = 2.0 km
%
% Invs :  Nx  =  4        Nz  = 3            Fmin = 0.05 Hz  Fmax = 0.25 Hz
% Invs :  Dx  =  3.00 km  Dz  = 3.00 km
% Invs :  Ntw =  1        Nsg =  {segments}
%
% VELOCITY-DENSITY STRUCTURE
% No. of layers = 2
%  DEPTH    P-VEL    S-VEL    DENS
%  [km]     [km/s]   [km/s]   [g/cm^3]
%  0.00     5.00     3.00     2.50
%  4.00     6.00     3.50     2.70
%
% SOURCE MODEL PARAMETERS
{count}%              X,Y,Z coordinates in km; SLIP in m
%   Coordinates are given for {place} of each subfault or segment: |'|
%   Origin of local coordinate system at epicenter: X (EW) = 0,  Y (NS) = 0
"""
COLUMNS = "%   LAT      LON     {x}   {y}     Z     SLIP    RAKE    TRUP\n%\n"


def plane(strike, dip, north, east, top, nx=4, nz=3, size=3e3):
    """Cells [n, 7] of a plane whose upper left corner is at a point, by rows, as fault has them."""
    along, down = (v[0] for v in directions(np.array([[0, 0, 0, 0, 0, strike, dip]], float)))
    i, j = (k.ravel() for k in np.meshgrid(np.arange(nx) + 0.5, np.arange(nz) + 0.5))
    centres = np.array([north, east, top]) + size * (i[:, None] * along + j[:, None] * down)
    return np.column_stack([centres, *(np.full(nx * nz, value) for value in (size, size, strike, dip))])


def rows(cells, place="top-center", names=("EW", "NS")):
    """Lines of cells, with slip, rake and rupture time that tell them apart."""
    _, down = directions(cells)
    points = cells[:, :3] - (down * cells[:, 4:5] / 2 if place == "top-center" else 0)
    lon, lat = SPHERE.inverse(points[:, 0], points[:, 1])
    for k, (north, east, z) in enumerate(points / 1e3):
        yield (f"{lat[k]:10.5f} {lon[k]:10.5f} {east:9.4f} {north:9.4f} {z:8.4f} {0.1 + 0.03 * k:8.4f} {160 + k:8.3f} "
               f"{0.5 * k:7.3f}\n")


def single(strike=350.0, dip=60.0, place="top-center", shuffle=False, names=("X==EW", "Y==NS"),
           count="% Nsbfs = 12 subfaults\n"):
    cells = plane(strike, dip, -4e3, 2e3, 2e3)
    lines = list(rows(cells, place))
    return HEADER.format(strike=strike, dip=dip, segments=1, place=place, count=count) + COLUMNS.format(
        x=names[0], y=names[1]) + "".join(lines[::-1] if shuffle else lines), cells


def double():
    parts = [plane(350.0, 80.0, -9e3, 1e3, 0.5e3, 3, 2), plane(320.0, 90.0, 0, 0, 0, 4, 3)]
    text = HEADER.format(strike=330.0, dip=85.0, segments=2, place="top-center",
                         count="") + "% ---- MULTISEGMENT MODEL ----\n"
    for k, (cells, (nx, nz)) in enumerate(zip(parts, ((3, 2), (4, 3))), 1):
        text += (f"% SEGMENT #  {k}:  STRIKE =  {cells[0, 5]} deg       DIP =  {cells[0, 6]} deg\n%   LEN  =  {3 * nx} "
                 f"km  WID =  {3 * nz} km\n%   Dx = 3.00 km   Dz = 3.00 km\n"
                 f"%   depth to top:   Z2top = {0.5 if k == 1 else 0.0} km\n%   Nsbfs =  {nx * nz} subfaults\n"
                 + COLUMNS.format(x="X==EW", y="Y==NS") + "".join(rows(cells)))
    return text, np.concatenate(parts)


class FspTest(PictureTest, FaultTest):
    def convert(self, *arguments):
        return self.plot("convert", *(self.path(a) if re.fullmatch(r"[\w.]+\.(fsp|h5|png)", a) else a
                                      for a in arguments), "--projection", "sphere")

    def model(self, text):
        return fsp.read(self.put("model.fsp", text), lambda lon, lat: Projection((lon, lat), "sphere"))


class Read(FspTest):
    def test_cells(self):
        """Strikes, dips and places."""
        for strike, dip in ((350.0, 60.0), (0.0, 90.0), (123.0, 15.0)):
            for place in ("top-center", "center"):
                text, cells = single(strike, dip, place)
                model = self.model(text)
                with self.subTest(strike=strike, dip=dip, place=place):
                    np.testing.assert_allclose(model.cells, cells, atol=DIGITS)
                    np.testing.assert_allclose(model.slip, 0.1 + 0.03 * np.arange(12), atol=1e-12)
                    np.testing.assert_allclose(model.columns["rupture_time"][0], 0.5 * np.arange(12))
                    self.assertEqual((model.segments[0].shape, model.remarks), ((3, 4), []))

    def test_order_and_wrong_names(self):
        """Rows in any order become rows along strike from the top; X that is called NS but is east is known by LON."""
        text, cells = single(shuffle=True, names=("X==NS", "Y==EW"))
        model = self.model(text)
        np.testing.assert_allclose(model.cells, cells, atol=DIGITS)
        np.testing.assert_allclose(model.slip, 0.1 + 0.03 * np.arange(12), atol=1e-12)
        self.assertRegex(model.remarks[0], "X==NS")

    def test_place_by_depth(self):
        """Points that are said to be centres, whose depths say that they are upper edges."""
        text, cells = single()
        model = self.model(text.replace("given for top-center", "given for center"))
        np.testing.assert_allclose(model.cells, cells, atol=DIGITS)
        self.assertRegex(model.remarks[0], "centre of cells")

    def test_segments(self):
        text, cells = double()
        model = self.model(text)
        np.testing.assert_allclose(model.cells, cells, atol=DIGITS)
        self.assertEqual([(s.label, s.shape) for s in model.segments], [(1, (2, 3)), (2, (3, 4))])
        np.testing.assert_array_equal(model.fault, [1] * 6 + [2] * 12)

    def test_moment(self):
        """Layers: 2.5 * 3^2 = 22.5 GPa above 4 km, 2.7 * 3.5^2 = 33.075 GPa below."""
        model = self.model(single(dip=90.0)[0])
        rigidity = np.where(np.repeat([3.5, 6.5, 9.5], 4) < 4, 22.5e9, 33.075e9)
        self.assertAlmostEqual(model.moment()[0] / (rigidity @ (0.1 + 0.03 * np.arange(12)) * 9e6), 1, 12)

    def test_said(self):
        self.put("model.fsp", single()[0])
        out = self.convert("model.fsp")
        for line in (r"cells: +12 of 3 x 3 km in 1 fault, 4 x 3",
                     r"area: +108 km2; the header has 108, ours is \+0.00 %",
                     r"strike, dip: +350, 60 degrees; the header has 350, 60",
                     r"moment: .* by layers of the file; the header has 2.3456e\+18",
                     r"frame: +x north, y east of 116.4300 W, 34.2000 N"):
            self.assertRegex(out, line)

    @unittest.skipUnless(pyproj, "needs python3-pyproj")
    def test_projection(self):
        """Transverse Mercator: distances by the geodesic, directions less the convergence of meridians, there and
        back."""
        projection, geod = Projection(ORIGIN), pyproj.Geod(ellps="WGS84")
        lon, lat = np.array([-116.0, -115.2, -117.9]), np.array([34.9, 33.1, 34.2])
        north, east = projection.forward(lon, lat)
        azimuth, _, distance = geod.inv(*np.repeat([ORIGIN], 3, axis=0).T, lon, lat)
        # east^2 / 6 R^2 at 130 km, and more in the scale of the end
        np.testing.assert_allclose(np.hypot(north, east), distance, rtol=3e-4)
        np.testing.assert_allclose(np.degrees(np.arctan2(east, north)), azimuth, atol=0.02)
        np.testing.assert_allclose(np.array(projection.inverse(north, east)), [lon, lat], atol=1e-9)
        turn = projection.convergence(north[1], east[1])
        self.assertAlmostEqual(turn, (lon[1] - ORIGIN[0]) * np.sin(np.radians(lat[1])), 2)
        model = fsp.read(self.put("model.fsp", single()[0]), lambda a, b: Projection((a, b)))
        # 1 km from where the points are
        np.testing.assert_allclose(model.cells[:, 5], 350.0 - projection.convergence(*model.cells[:, :2].mean(axis=0)),
                                   atol=0.01)

    def test_ground(self):
        """A depth that is rounded to 1 m: the dipping plane that reaches the ground is not above it, so that a run
        takes it."""
        cells = plane(350.0, 83.0, -4e3, 2e3, 0.0)
        lines = [line.replace(f"{(c[2] - 1500 * np.sin(np.radians(83))) / 1e3:8.4f}",
                              f"{round((c[2] - 1500 * np.sin(np.radians(83))) / 1e3 - 0.0004, 3):8.3f}", 1)
                 for c, line in zip(cells, rows(cells))]
        self.put("model.fsp", HEADER.format(strike=350.0, dip=83.0, segments=1, place="top-center", count="").replace(
            "Htop = 2.0", "Htop = 0.0") + COLUMNS.format(x="X==EW", y="Y==NS") + "".join(lines))
        self.convert("model.fsp", "model.h5")
        self.assertAlmostEqual(corners_of(self.get("model.h5", "cells"))[..., 2].min(), 0, 9)
        self.fault("-fault_mesh", "model.h5", "-fault_normal_stress", "50e6", "-fault_initial", "traction",
                   "-ts_max_steps", "1", "-ts_max_time", "1")

    def test_whole_turns(self):
        """A rake of 360 degrees, which fault does not take, is 0 in its file."""
        self.put("model.fsp", single()[0].replace("160.000", "360.000"))
        self.convert("model.fsp", "model.h5")
        np.testing.assert_allclose(self.get("model.h5", "rake"), [0, *range(161, 172)])

    def test_without_proj(self):
        self.put("model.fsp", single()[0])
        with mock.patch.dict(sys.modules, {"pyproj": None}):
            self.refused("convert", "--projection sphere", self.path("model.fsp"), self.path("out.h5"))
        self.assertFalse(os.path.exists(self.path("out.h5")))


class BackAndForth(FspTest):
    def test_digits(self):
        """Slip, rake, rupture time and moment have the same digits after .fsp, .h5 and .fsp again, and once more."""
        for text in (single()[0], double()[0]):
            self.put("a.fsp", text)
            names = ["a.fsp", "b.h5", "c.fsp", "d.h5", "e.fsp"]
            for before, after in zip(names, names[1:]):
                self.convert(before, after)
            tables = []
            for name in ("a.fsp", "c.fsp", "e.fsp"):
                written = self.content(name)
                tables.append(([[float(w) for w in line.split()[5:8]] for line in written.splitlines()
                                if not line.startswith("%")], re.search(r"Mo\s*=\s*(\S+)", written)[1],
                               re.search(r"LEN\s*=\s*([\d.]+) km\s+WID\s*=\s*([\d.]+)", written).groups()))
            self.assertEqual(tables[0][0], tables[1][0])
            self.assertEqual(tables[1], tables[2])
            self.assertEqual([float(t[1]) for t in tables], [2.3456e18] * 3)
            models = [fsp.read(self.path(name), lambda lon, lat: Projection((lon, lat), "sphere"))
                      for name in ("a.fsp", "e.fsp")]
            np.testing.assert_allclose(models[1].cells, models[0].cells, atol=0.5)
            self.assertEqual(models[0].moment()[0], models[1].moment()[0])

    def test_stress_and_back(self):
        """Slip to stress on receivers, and back: the stress of `elastic` for one receiver of the same directions; .fsp
        with the same slip and moment."""
        self.put("source.fsp", single(strike=10.0, dip=50.0)[0])
        self.convert("source.fsp", "source.h5")
        cells = plane(40.0, 70.0, 2e4, 5e3, 1e3, 3, 2)
        with h5py.File(self.path("faults.h5"), "w") as file:
            file["cells"], file["rake"], file["fault"] = cells, np.full(6, 160.0), np.ones(6, int)
            file.attrs.update({"format": ours.FORMAT, "kind": "cells", "claims": "{}", "options": "{}",
                               "segments": "[]"})
        out = self.convert("source.h5", "points.h5", "--receivers", self.path("faults.h5"), "--stress",
                           self.path("change.h5"))
        self.assertRegex(out, "stress: +on 6 cells")
        self.fault("-elastic_input", "points.h5", "-elastic_output", "out.h5", "-elastic_receiver", "40,70,160",
                   program=os.path.join(BUILD, "bin", "elastic"))
        with h5py.File(self.path("out.h5")) as given, h5py.File(self.path("change.h5")) as change:
            traction = given["traction"][()]
            scale = np.abs(traction).max()
            np.testing.assert_allclose(change["shear"][()], -traction[:, 0], atol=1e-12 * scale)
            np.testing.assert_allclose(change["normal"][()], traction[:, 2], atol=1e-12 * scale)
            np.testing.assert_allclose(change["coulomb"][()], -traction[:, 0] - 0.4 * traction[:, 2],
                                       atol=1e-12 * scale)
            self.convert("source.h5", "--receivers", self.path("faults.h5"), "--stress", self.path("sum.h5"),
                         "--background", "5e6", "20e6")
            with h5py.File(self.path("sum.h5")) as total:
                np.testing.assert_array_equal(total["initial_traction"][()], 5e6 + change["shear"][()])
                np.testing.assert_array_equal(total["normal_stress"][()], 20e6 + change["normal"][()])
            self.convert("source.h5", "--receivers", self.path("faults.h5"), "--stress", self.path("deep.h5"),
                         "--background", "1e6", "2e6", "--background-gradient", "6e3", "15e3")
            with h5py.File(self.path("deep.h5")) as total:
                np.testing.assert_allclose(total["initial_traction"][()], 1e6 + 6e3 * cells[:, 2] + change["shear"][()],
                                           rtol=1e-14)
                np.testing.assert_allclose(total["normal_stress"][()], 2e6 + 15e3 * cells[:, 2] + change["normal"][()],
                                           rtol=1e-14)
            self.refused("convert", "--background SHEAR NORMAL", self.path("source.h5"),
                         "--background-gradient", "1", "2", code=2)
            code, _, err = self.main("convert", self.path("source.h5"), "--receivers", self.path("faults.h5"),
                                     "--stress", self.path("doubt.h5"), "--background", "5", "20", "--projection",
                                     "sphere")
            self.assertEqual(code, 1)  # the change alone is tension somewhere
            self.assertRegex(err, "--background: normal_stress of cell . is -")
        run = ("-fault_initial", "traction", "-fault_mesh_unit", "m", "-ts_max_steps", "2", "-ts_max_time", "1")
        self.fault("-fault_mesh", "faults.h5", "-fault_parameters", "sum.h5", *run)
        self.fault("-fault_mesh", "source.h5", "-fault_normal_stress", "50e6", *run)
        self.convert("points.h5", "back.fsp")
        back = fsp.read(self.path("back.fsp"), lambda lon, lat: Projection((lon, lat), "sphere"))
        self.assertEqual(back.claims["moment"], 2.3456e18)
        np.testing.assert_array_equal(back.slip, np.round(0.1 + 0.03 * np.arange(12), 4))

    def test_rock(self):
        """The moment, the file, slipstep surface, --stress and elastic have one rigidity, which is said: that of
        layers, that of --rigidity, that of cells' moments, or where nothing says it the default of elastic."""
        slip, rigidity = 0.1 + 0.03 * np.arange(12), np.where(np.repeat([3.5, 6.5, 9.5], 4) < 4, 22.5e9, 33.075e9)
        text = single(strike=10.0, dip=90.0)[0]
        plain = text.replace("No. of layers = 2", "No. of layers = 0").replace("%  0.00     5.00     3.00     2.50\n%  "
                                                                               "4.00     6.00     3.50     2.70\n", "")
        moments = plain.replace("    TRUP", "    TRUP   SF_MOMENT").splitlines(True)
        moments = "".join(line.replace("\n", f" {1e17 * (k + 1)}\n") if not line.startswith("%") else line
                          for k, line in enumerate(moments, 12 - len(moments)))
        with h5py.File(self.path("faults.h5"), "w") as file:
            file["cells"], file["rake"], file["fault"] = plane(40.0, 70.0, 2e4, 5e3, 1e3, 3,
                                                               2), np.full(6, 160.0), np.ones(6, int)
            file.attrs.update({"format": ours.FORMAT, "kind": "cells", "claims": "{}", "options": "{}",
                               "segments": "[]"})
        for words, more, expected in ((text, (), rigidity @ slip / slip.sum()), (plain, (), 30e9),
                                      (moments, (), 78e17 / (9e6 * slip.sum())),
                                      (text, ("--rigidity", "header"), 2.3456e18 / (9e6 * slip.sum())),
                                      (plain, ("--rigidity", "41e9"), 41e9)):
            self.put("model.fsp", words)
            out = self.convert("model.fsp", "model.h5", "--receivers", self.path("faults.h5"), "--stress",
                               self.path("change.h5"), *more)
            self.assertAlmostEqual(h5py.File(self.path("model.h5")).attrs["shear_modulus"] / expected, 1, 9)
            self.assertAlmostEqual(slip_of_input(self.path("model.h5")).shear_modulus / expected, 1, 9)
            # five digits
            self.assertAlmostEqual(float(re.search(r"moment: +(\S+)", out)[1]) / (9e6 * slip.sum() * expected), 1, 4)
            self.fault("-elastic_input", "model.h5", "-elastic_output", "out.h5", "-elastic_receiver", "40,70,160",
                       program=os.path.join(BUILD, "bin", "elastic"))
            with h5py.File(self.path("out.h5")) as given, h5py.File(self.path("change.h5")) as change:
                np.testing.assert_allclose(change["shear"][()], -given["traction"][:, 0],
                                           atol=1e-12 * np.abs(given["traction"]).max())
        self.refused("convert", "--rigidity: large", self.path("model.fsp"), "--rigidity", "large", code=2)

    def test_pictures(self):
        self.put("model.fsp", single()[0])
        self.convert("model.fsp", "model.h5", "--figure", "cells.png")
        source = slip_of_input(self.path("model.h5"))
        np.testing.assert_allclose(np.hypot(*source.slip.T), 0.1 + 0.03 * np.arange(12), atol=1e-12)
        self.look(self.path("cells.png"))
        self.plot("surface", self.path("model.h5"), "--spacing", "4", "--figure", self.path("ground.png"))
        self.look(self.path("ground.png"))
        self.assertEqual(Elastic(source).displacement(np.array([[0.0, 0.0, 0.0]])).shape, (1, 3))


class Directions(FspTest):
    def test_twelve_strikes(self):
        """A hypocentre a quarter of the length before the middle is left of it in the picture of the slip model and in
        those of runs, whose axes run along the strike that the label says."""
        for strike in np.arange(15.0, 360, 30):
            cells = plane(strike, 60.0, 1e4, -2e4, 1e3, 8, 3)
            # the second of a row of eight
            model = Model("of a test", "cells", cells, np.zeros(24), np.where(np.arange(24) == 9, 3.0, 1.0))
            with self.subTest(strike=strike):
                picture = draw(model)
                self.addCleanup(plt.close, picture)
                panel = picture.axes[1]
                self.assertEqual((panel.get_title(loc="left"), panel.get_xlabel()),
                                 (f"along {strike:.0f} degrees", "along strike (km)"))
                artist = panel.collections[0]
                x = np.array([path.vertices[:4, 0].mean() for path in artist.get_paths()])
                # [km], cells 1 of 0 to 7, of 3 km
                self.assertAlmostEqual(x[np.argmax(artist.get_array())] - x.mean(), -7.5)
                low, high = panel.get_xlim()
                self.assertLess(low, high)
                (_, s, _), = unroll(cells)
                self.assertAlmostEqual((s[:, 9].mean() - s.mean()) / 1e3, -7.5)

    def test_runs(self):
        """Of rectangles and of triangles, whose corners go round either way, cells before the middle along strike are
        left in maps, and down is down."""
        for strike in np.arange(15.0, 360, 30):
            for dip in (40.0, 90.0):
                vertices, triangles = meshfiles.plane((8, 3), (1e3, 1e3), strike, dip, (1e4, -2e4, 1e3))
                triangles[::2] = triangles[::2, ::-1]
                mesh = {"vertices": vertices, "triangles": triangles,
                        **dict(zip("xyz", vertices[triangles].mean(axis=1).T)), "length": np.full(48, 1e3),
                        "width": np.full(48, 1e3),
                        "strike": np.full(48, strike), "dip": np.full(48, dip)}
                cells = plane(strike, dip, 1e4, -2e4, 1e3, 8, 3)
                names = ("x", "y", "z", "length", "width", "strike", "dip")
                for kind in (mesh, dict(zip(names, cells.T))):
                    n = len(kind["x"])
                    run = SimpleNamespace(mesh=kind, planes=[(1, np.arange(n))], path="", fault_name=str)
                    flat, = planes_of(run)
                    along = ((kind["x"] - 1e4) * np.cos(np.radians(strike)) + (kind["y"] + 2e4)
                             * np.sin(np.radians(strike)))
                    with self.subTest(strike=strike, dip=dip, cells=n):
                        self.assertFalse(flat.bent)
                        np.testing.assert_allclose(flat.x.mean(axis=0) - flat.x.mean(), (along - along.mean()) / 1e3,
                                                   atol=1e-9)
                        down = (kind["z"] - kind["z"].mean()) / np.sin(np.radians(dip))
                        np.testing.assert_allclose(flat.z.mean(axis=0) - flat.z.mean(), down / 1e3, atol=1e-9)

    def test_most(self):
        """Cells that dip to the other side count along the same line: that of most of the area, of neither the
        first."""
        for strikes, areas, expected in (([200.0, 20.0], [2, 1], 200), ([200.0, 20.0], [1, 2], 20),
                                         ([200.0, 20.0], [1, 1], 200), ([350.0, 10.0], [1, 1], 0),
                                         ([0.0, 90.0], [1, 1], 0), ([170.0, 20.0, 185.0], [1, 0.5, 1], 180.2)):
            self.assertAlmostEqual((axis_along_strike(np.array(strikes), np.array(areas, float)) - expected
                                    + 180) % 360, 180, delta=0.1 if len(strikes) < 3 else 3, msg=str(strikes))


class Refused(FspTest):
    def test_files(self):
        text = single()[0]
        lines = text.splitlines(True)
        first = next(k for k, line in enumerate(lines) if not line.startswith("%"))
        cases = {"without its last rows": ("".join(lines[:-2]), rf"line {len(lines) - 2 + 1}|ends after line "
                                           rf"{len(lines) - 2}, expected 12|10 rows of segment 1, expected 12"),
                 "cut within a row": (text[:-30],
                                      rf"line {len(lines)}: \d numbers, expected 8: LAT LON X Y Z SLIP RAKE TRUP"),
                 "without rows": ("".join(lines[:first]),
                                  f"ends after line {first}, expected rows of LAT LON X Y Z SLIP"),
                 "a word": ("".join(lines[:first + 1] + [lines[first + 1].replace("0.1300", "deep  ")]
                                    + lines[first + 2:]), f"line {first + 2}: \"deep\", expected a number"),
                 "another count": (text.replace("Nsbfs = 12", "Nsbfs = 13").replace("Nx  =  4", "Nx  =  5"),
                                   "12 rows of segment 1"),
                 "other units": (text.replace("coordinates in km; SLIP in m", "coordinates in km; SLIP in cm"),
                                 r"line \d+: .*SLIP in cm\""),
                 "no header": ("a slip model\n", 'line 1: "a slip model"'),
                 "no moment": (re.sub(r"Mo = \S+ Nm", "", text), "no Loc and Size with LAT, LON and Mo"),
                 "no cells": (text.replace("Dx  =  3.00 km", ""), "segment 1 has no Dx and Dz"),
                 "a dip": (text.replace("DIP = 60.0", "DIP = 160.0"), "STRK and a DIP"),
                 "bytes": ("\0\1\2", "not a text file"),}
        for name, (content, message) in cases.items():
            with self.subTest(name):
                self.put("bad.fsp", content)
                self.refused("convert", f".*bad.fsp.*({message})", self.path("bad.fsp"), self.path("out.h5"),
                             "--projection", "sphere")
                self.assertFalse(os.path.exists(self.path("out.h5")))
                self.assertFalse(os.path.exists(self.path("out.h5.part")))

    def test_arguments(self):
        self.put("model.fsp", single()[0])
        model, target = self.path("model.fsp"), self.path("out.h5")
        self.refused("convert", "nothing.fsp", self.path("nothing.fsp"), target)
        self.refused("convert", "--format", self.put("model.dat", single()[0]), target)
        self.refused("convert", "out.txt", model, self.path("out.txt"), "--projection", "sphere")
        self.refused("convert", "model.fsp", model, model, code=2)
        self.refused("convert", "--receivers FILE", model, "--stress", target, code=2)
        self.refused("convert", "-360 to 360", model, "--origin", "12", "95")

    def test_script(self):
        done = self.script("convert", "--help")
        self.assertIn("--receivers", done.stdout)


if __name__ == "__main__":
    unittest.main(verbosity=2)
