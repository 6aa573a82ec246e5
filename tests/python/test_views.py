"""Faults of any planes drawn flat: where cells are in maps, and films and pictures of them."""

import os
import sys
import unittest
from types import SimpleNamespace
from unittest import mock

from scripts import SOURCE, PictureTest

import century
import h5py
import numpy as np

sys.path.insert(0, os.path.join(SOURCE, "examples"))
import make_mesh
from slipstep import OutputError, Run
from slipstep.geometry.cells import corners_of, free_edges, free_sides
from slipstep.geometry.unroll import overlap, unroll
from slipstep.plots.maps import Plane, frames_of, planes_of
from slipstep.plots import snapshots as snapshot_module
from slipstep.plots.snapshots import Layout, chosen_rows, snapshots
from slipstep.plots.spacetime import Line, lines_of
from slipstep.programs import plot_run
from slipstep.programs.plot_catalogue import hypocentres
from slipstep.results.events import Events
from slipstep.results.fields import Fields
from slipstep.times import YEAR, Clock
from test_mesh_planes import plane

SIZE = (10000.0, 8000.0)


def segments(strikes, dip, cells=(10, 8)):
    return make_mesh.segmented(cells, SIZE, 0.0, 1.0, strikes, dip)


class Unroll(unittest.TestCase):
    """Coordinates are sums of numbers of up to 4e4 m, in double precision: 1e-6 m."""

    def whole(self, cells):
        parts = unroll(cells)
        self.assertEqual(len(parts), 1)
        index, s, d = parts[0]
        np.testing.assert_array_equal(index, np.arange(len(cells)))
        np.testing.assert_allclose(s[1] - s[0], cells[:, 3], rtol=1e-12)
        np.testing.assert_allclose(d[1] - d[0], cells[:, 4], rtol=1e-9)
        return s, d

    def filled(self, s, d, rows):
        """Rows are as deep as given, and cells of each follow each other without gap or overlap."""
        for low, high in zip(rows[:-1], rows[1:]):
            own = np.flatnonzero(np.abs(d[0] - low) < 1e-6)
            np.testing.assert_allclose(d[1, own], high, atol=1e-6)
            order = own[np.argsort(s[0, own])]
            np.testing.assert_allclose(s[0, order[1:]], s[1, order[:-1]], atol=1e-6)

    def test_a_listric_fault_goes_on_down_dip(self):
        """Its rows are as wide as the mesh made them, one below the other; x is that along the strike."""
        cells = make_mesh.listric((6, 9), SIZE, 500.0, 2.0, 35.0, (80.0, 15.0))
        s, d = self.whole(cells)
        down = make_mesh.edges_in_depth(9, SIZE[1], 0, 2.0)
        self.filled(s, d, down)
        np.testing.assert_allclose(s[0].reshape(9, 6),
                                   np.tile(make_mesh.edges_along_strike(6, SIZE[0], 2.0)[:-1], (9, 1)), atol=1e-6)

    def test_segments_follow_each_other(self):
        """Vertical ones fill a rectangle in which depth is down; the first keeps its place. Of dipping ones each row is
        as long as its cells."""
        cells, _ = segments((10.0, 40.0, -5.0), 90.0)
        s, d = self.whole(cells)
        np.testing.assert_allclose(d.mean(axis=0), cells[:, 2], atol=1e-6)
        self.filled(s, d, np.arange(9) * 1000.0)
        np.testing.assert_allclose((s.min(), s.max()), (0, 30000), atol=1e-6)
        cells, segment = segments((10.0, 40.0, -5.0), 50.0)
        s, d = self.whole(cells)
        self.filled(s, d, np.arange(9) * 1000.0)
        own = segment == 0
        along = cells[:, 0] * np.cos(np.radians(10)) + cells[:, 1] * np.sin(np.radians(10))
        np.testing.assert_allclose(s.mean(axis=0)[own], along[own], atol=1e-6)
        for k in (0, 1):
            self.assertLess(s[:, segment == k].mean(), s[:, segment == k + 1].mean())

    def test_neither_order_nor_opposite_strikes_matter(self):
        """Cells in another order, and a vertical segment that is described from its other end, as it then is."""
        cells, segment = segments((0.0, 25.0), 90.0)
        s, d = self.whole(cells)
        shuffle = np.append(0, 1 + np.random.default_rng(3).permutation(len(cells) - 1))
        t, e = self.whole(cells[shuffle])
        np.testing.assert_allclose((t, e), (s[:, shuffle], d[:, shuffle]), atol=1e-6)
        cells[segment == 1, 5] += 180
        t, e = self.whole(cells)
        np.testing.assert_allclose((t, e), (s, d), atol=1e-6)

    def test_rows_that_do_not_match(self):
        """Coarse cells beside fine ones, and a segment with cells in no rows: nothing overlaps, and there is one
        map."""
        first = plane(0, 90, (0, 0, 0), (4, 6), (1000.0, 500.0))
        for others in ([plane(20, 90, (4000, 0, 0), (4, 4), (1000.0, 750.0))],
                       [plane(20, 90, (4000, 0, 0), (1, 3), (1000.0, 1000.0)),
                        plane(20, 90, (4000 + 1000 * np.cos(np.radians(20)), 1000 * np.sin(np.radians(20)), 0), (2, 2),
                              (1000.0, 1500.0))]):
            cells = np.concatenate([first, *others])
            s, d = self.whole(cells)
            np.testing.assert_allclose(d.mean(axis=0), cells[:, 2], atol=1e-6)
            np.testing.assert_allclose((s.min(), s.max()), (0, 4000 + 1000 * sum(len(set(o[:, 0])) for o in others)),
                                       atol=1e-6)
            self.assertFalse(any(overlap(s[:, [k]], d[:, [k]], s[:, k + 1:], d[:, k + 1:], 1e-3)
                                 for k in range(len(cells) - 1)))

    def test_branches_and_what_is_apart_are_parts(self):
        """A fault that forks: the straight branch is drawn with the trunk, the other one, and a plane far off, by
        themselves."""
        trunk, straight, branch = plane(0, 90, (0, 0, 0), (4, 3),
                                        (500.0, 500.0)), plane(5, 90, (2000, 0, 0), (4, 3), (500.0, 500.0)), \
            plane(40, 90, (2000, 0, 0), (4, 3), (500.0, 500.0))
        far = plane(0, 60, (0, 9000, 0), (4, 3), (500.0, 500.0))
        parts = unroll(np.concatenate([trunk, straight, branch, far]))
        self.assertEqual([sorted(set(index // 12)) for index, _, _ in parts], [[0, 1], [2], [3]])
        up = plane(0, 60, (0, 0, 0), (4, 3), (500.0, 500.0))
        line = 1500 * np.array([0, np.cos(np.radians(60)), np.sin(np.radians(60))])
        parts = unroll(np.concatenate([up, plane(0, 30, line, (4, 3), (500.0, 500.0)),
                                       plane(0, 80, line, (4, 3), (500.0, 500.0))]))
        self.assertEqual([sorted(set(index // 12)) for index, _, _ in parts], [[0, 1], [2]])
        np.testing.assert_allclose(parts[0][2].max(), 3000, atol=1e-6)

    def test_a_fault_that_turns_over(self):
        """From a dip of 80 degrees to the right of the strike to one of 70 to its left: one map, rows down dip."""
        top = plane(0, 80, (0, 0, 0), (4, 3), (500.0, 400.0))
        line = 1200 * np.array([0, np.cos(np.radians(80)), np.sin(np.radians(80))])
        below = plane(180, 70, line + [2000, 0, 0], (4, 2), (500.0, 300.0))
        s, d = self.whole(np.concatenate([top, below]))
        self.filled(s, d, [0, 400, 800, 1200, 1500, 1800])
        np.testing.assert_allclose(s.mean(axis=0), np.concatenate([top, below])[:, 0], atol=1e-6)


class Maps(PictureTest):
    def run_of(self, cells, fault, along, down):
        """A run whose values are those of the century at distances along and down [m]."""
        path = century.write_run(self.path("run.h5"), cells=(along, down, cells[:, 3], cells[:, 4]), step=1.0)
        return Run(century.turn(path, cells, fault))

    def two(self):
        """A listric fault of 40 cells, label 7, and a small plane, label 3."""
        cells = np.concatenate([make_mesh.listric((8, 5), (16000.0, 8000.0), 0.0, 1.0, 350.0, (70.0, 30.0)),
                                plane(80, 45, (3e4, 0, 2000), (4, 3), (1500.0, 1200.0))])
        return self.run_of(cells, np.repeat([7, 3], [40, 12]), np.arange(52.0) * 300, np.arange(52.0) * 100)

    def test_grids_that_dip(self):
        """A map of a grid is as long down dip as that is, and says so."""
        path = century.write_run(self.path("run.h5"), step=1.0)
        down = (np.arange(20) + 0.5) * 500
        with h5py.File(path, "r+") as file:
            file["mesh/z"][...] = 1000 + down * np.sin(np.radians(30))
            century.put(file, "mesh/down_dip", down, "m")
        own, = planes_of(Run(path))
        self.assertEqual((own.down_label, own.vertical), ("down dip (km)", False))
        np.testing.assert_allclose(own.extent, (0, 20, 0, 10), atol=1e-12)
        line = Line(own, "dip", 10.0)
        np.testing.assert_allclose(line.edges, np.arange(21) / 2)
        self.assertEqual((line.label, line.where, Line(own, "strike", 3.0).where),
                         ("down dip (km)", "at 10 km along strike", "at 3 km down dip"))

    def test_panels_have_names_and_one_scale(self):
        run = self.two()
        planes = planes_of(run)
        self.assertEqual([own.name for own in planes],
                         ["fault 3 (strike 80°, dip 45°)", "fault 7 (strike 350°, dip 34 to 66°)"])
        np.testing.assert_allclose([own.extent[2:] for own in planes], [(0, 3.6), (0, 8)], atol=1e-9)
        np.testing.assert_allclose([x1 - x0 for x0, x1, _, _ in frames_of(run)], 16)
        layout = Layout(run, 1, 1)
        block = layout.fill(layout.canvas)[0]
        artists = layout.draw(block, np.arange(52.0), None, "viridis", "now", True)
        layout.canvas.canvas.draw()
        scale = []
        for axes, own, artist in zip(block, planes, artists):
            np.testing.assert_array_equal(artist.get_array(), own.cells)
            drawn = np.array([path.vertices[:4] for path in artist.get_paths()])
            np.testing.assert_allclose(drawn[:, 0].T, (own.x[0], own.z[0]))  # corners of the cells of the map
            np.testing.assert_allclose(drawn[:, 2].T, (own.x[1], own.z[1]))
            box = axes.get_window_extent()
            scale += [box.width / np.ptp(axes.get_xlim()), box.height / np.ptp(axes.get_ylim())]
            self.assertEqual((axes.get_ylabel(), axes.yaxis_inverted()), ("down dip (km)", True))
        np.testing.assert_allclose(scale, scale[0], rtol=0.01)  # pixels for a km

    def test_names_of_faults_and_room_for_them(self):
        """The names that the file has, in all pictures; titles and numbers of neighbouring panels do not meet, also
        where names are long, and maps are as large as their row."""
        run = self.two()
        with h5py.File(run.path, "r+") as file:
            file["mesh/fault"].attrs[
                "names"] = ("3 Northern Long Valley fault of the western strand; 7 San Cristobal detachment, lower "
                            "part of its southern segment")
        run = Run(run.path)
        self.assertEqual([own.short for own in planes_of(run)],
                         ["Northern Long Valley fault of the western strand",
                          "San Cristobal detachment, lower part of its southern segment"])
        self.assertTrue(planes_of(run)[0].name.endswith("western strand (strike 80°, dip 45°)"))
        self.assertEqual((run.fault_name(3), run.fault_name(5)),
                         ("Northern Long Valley fault of the western strand", "fault 5"))
        clock = Clock(0.0, run.series["time"][-1])
        overview = plot_run.figure(run, clock, True)
        snaps = snapshots(run, "slip", [50 * YEAR, 60 * YEAR, 70 * YEAR])
        for canvas in (overview, snaps):
            canvas.canvas.draw()
            panels = [axes for axes in (*canvas.axes, *(child for axes in canvas.axes for child in axes.child_axes))
                      if axes.axison and "km" in axes.get_ylabel() + axes.get_xlabel()]
            boxes = [text.get_window_extent() for axes in panels
                     for text in (axes._left_title, axes.title, axes.xaxis.label, axes.yaxis.label) if text.get_text()
                     and text.get_visible()]
            boxes += [label.get_window_extent() for axes in panels for label in axes.get_xticklabels()
                      if label.get_text() and label.get_visible()
                      and axes.get_xlim()[0] <= label.get_position()[0] <= axes.get_xlim()[1]]
            self.assertGreater(len(boxes), 10)
            for k, one in enumerate(boxes):
                # pixels
                self.assertTrue(-1 <= one.x0 and one.x1 <= canvas.bbox.width + 1 and -1 <= one.y0
                                and one.y1 <= canvas.bbox.height + 1, one)
                self.assertFalse([k for other in boxes[:k] if one.overlaps(other)])
        maps = [child for axes in overview.axes for child in axes.child_axes if child.get_title(loc="left")
                or child.get_title()]
        self.assertEqual(len(maps), 4)
        for child in maps:
            self.assertGreater(child.get_window_extent().width, 200)  # pixels, of 1100

    def test_lines_cross_a_bend(self):
        """Along strike at one distance down dip through both segments of a fault: the cells of one row, in order."""
        cells, _ = segments((0.0, 30.0), 60.0)
        run = self.run_of(cells, np.ones(len(cells), int), np.arange(160.0) * 100, np.full(160, 5000.0))
        line, = lines_of(run, "strike", 2.5)
        row = [int(own[0]) for own in line.over]
        self.assertEqual(row, [*range(20, 30), *range(100, 110)])
        np.testing.assert_allclose(np.diff(line.edges), cells[row, 3] / 1e3, atol=1e-9)
        slip = Fields(run, "slip")
        np.testing.assert_array_equal(line.values(slip.maps([5])), slip.maps([5])[:, row])

    def test_a_line_on_an_edge(self):
        """Through the middle of an even number of rows, whose edges are known to rounding: the row below it, of every
        strike."""
        for strike in (3, 77, 111, 200, 285, 357):
            run = self.run_of(plane(strike, 57, (12345.6, -7654.3, 100), (6, 8), (700.0, 300.0)), np.ones(48, int),
                              np.arange(48.0), np.arange(48.0))
            line, = lines_of(run, "strike", None)
            self.assertEqual([int(own[0]) for own in line.over], [*range(24, 30)])

    def test_lines_leave_out_faults_that_end_before(self):
        run = self.two()
        self.assertEqual([line.plane.name[:7] for line in lines_of(run, "strike", 7.0)], ["fault 7"])
        self.assertEqual(len(lines_of(run, "dip", None)), 2)
        self.refused("plot_run", "--at is 9 km", run.path, "--kind", "space-time", "--at", "9")

    def test_pictures(self):
        run = self.two().path
        for k, arguments in enumerate(((), ("--kind", "rupture"), ("--kind", "space-time", "--along", "dip"),
                                       ("--time", "50y", "--field", "slip"))):
            self.plot("plot_run", run, *arguments, "--figure", self.path(f"{k}.png"))
            self.look(self.path(f"{k}.png"))
        self.plot("plot_run", run, "--film", self.path("film.gif"), "--frames", "3")

    def test_hypocentres_are_on_their_faults(self):
        """Of each fault in its own panel, at the middles of their cells on its map."""
        cells = np.concatenate([plane(60, 45, (0, 0, 500)), plane(150, 30, (9000, 0, 500))])
        path = century.turn(century.write_catalogue(self.path("c.h5"), maps=False), cells, np.repeat([4, 2], 12))
        with h5py.File(path, "r+") as file:
            file["cell"][...] = (0, 11, 12, 14, 23)
        events = Events(path)
        (_, name, along, down, rows, x, z), other = hypocentres(events)
        self.assertEqual((name[:7], down), ("fault 2", "down dip (km)"))
        np.testing.assert_array_equal(rows, (2, 3, 4))
        np.testing.assert_allclose(z, (0.2, 0.2, 1.0), atol=1e-9)
        np.testing.assert_allclose(np.diff(x), (1, 0.5), atol=1e-9)
        np.testing.assert_allclose((other[5], other[6]), ((0.25, 1.75), (0.2, 1.0)), atol=1e-9)
        self.plot("plot_catalogue", path)
        self.look(self.path("c.png"))


class Lines(PictureTest):
    def test_lines_cross_triangles(self):
        """Squares of 1 km, each of two triangles: a line a quarter down the first row is three quarters of each square
        in the one and a quarter in the other; one down dip likewise; one on an edge between rows has the sides of the
        squares."""
        corner = np.array([[[i, 0], [i + 1, 0], [i, 1]] if k else [[i + 1, 0], [i + 1, 1], [i, 1]] for i in range(3)
                           for k in (1, 0)], float)
        corner = np.concatenate([corner, corner + [0, 1]])
        flat = Plane(*np.moveaxis(corner, -1, 0).swapaxes(1, 2), cells=np.arange(12))
        for at, want in ((0.25, [0, 0.75, 1, 1.75, 2, 2.75, 3]), (1.0, [0, 1, 2, 3])):
            line = Line(flat, "strike", at)
            np.testing.assert_allclose(line.edges, want, atol=1e-9)
            if at == 0.25:
                np.testing.assert_array_equal(line.values(np.arange(12.0)[None]), [[0, 1, 2, 3, 4, 5]])
        np.testing.assert_allclose(Line(flat, "dip", 0.25).edges, [0, 0.75, 1, 1.75, 2], atol=1e-9)
        with self.assertRaisesRegex(OutputError, "--at is max"):
            Line(flat, "strike", "max")

    def test_bent_surfaces_have_a_mean_strike(self):
        """Triangles of a plane lie along strike and down dip; those of a bent surface are seen across its mean plane,
        and labels say so."""
        for bend, labels in ((0.0, ("along strike (km)", "down dip (km)", "at 1 km down dip")),
                             (0.2,
                              ("along the mean strike (km)", "down the mean dip (km)", "at 1 km down the mean dip"))):
            s, d = np.meshgrid(np.arange(5) * 1000.0, np.arange(4) * 1000.0)
            points = np.stack([s, d / 2 + bend * (s - 2000) ** 2 / 1000, d * np.sqrt(0.75)], axis=-1).reshape(-1, 3)
            number = np.arange(20).reshape(4, 5)
            a, b, c, e = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
            mesh = {"vertices": points, "triangles": np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, e], 1)]),
                    "x": np.zeros(24), "strike": np.zeros(24)}
            plane, = planes_of(SimpleNamespace(mesh=mesh, planes=[(1, np.arange(24))]))
            self.assertEqual((plane.along_label, plane.down_label, Line(plane, "strike", 1.0).where), labels)

    def test_rows_are_not_alike(self):
        """Frames of a run that rests for most of its time are at equal shares of its slip; of one that slips all the
        time at equal times."""
        times = np.linspace(0, 1000, 101)
        for slip, expected in ((np.minimum(times, 40.0), (0, 1, 2, 4)), (times, (12, 37, 62, 87))):
            fields = SimpleNamespace(name="slip", times=times, run=SimpleNamespace())
            with mock.patch.object(snapshot_module, "event_around", lambda *_: None), mock.patch.object(
                snapshot_module, "mean_slip_at", lambda run, at, slip=slip: np.interp(at, times, slip)):
                rows = chosen_rows(fields, None, 4)
            self.assertLessEqual(np.abs(np.array(rows) - expected).max(), 1)
            self.assertGreater(np.diff(slip[rows]).min(), 0.1 * slip[-1])

    def test_outlines_are_the_rims(self):
        """Of rectangles and of triangles; an edge within a plane is none."""
        corners = corners_of(plane(0, 60, (0, 0, 0), (4, 3), (500.0, 400.0)))
        upper, others = free_edges(corners)
        self.assertEqual((len(upper), len(others)), (4, 3 + 4 + 3))
        np.testing.assert_allclose(upper[..., 2], 0, atol=1e-9)
        x, t = np.meshgrid(np.arange(4) * 1000.0, [0.0, 1000.0, 1900.0])  # two rows that bend
        points = np.stack([x, np.interp(t, (0, 1000, 1900), (0, 500, 1200)),
                           np.interp(t, (0, 1000, 1900), (100, 966, 1500))], axis=-1)
        corner = [points[[j, j, j + 1], [i, i + 1, i + 1]] for j in range(2) for i in range(3)]
        corner += [points[[j, j + 1, j + 1], [i, i + 1, i]] for j in range(2) for i in range(3)]
        upper, others = free_sides(np.array(corner))
        np.testing.assert_array_equal(np.sort(upper[:, :, 0].ravel()), [0, 1000, 1000, 2000, 2000, 3000])
        np.testing.assert_array_equal(upper[:, :, 2], 100.0)
        self.assertEqual(len(others), 3 + 4)

    def test_bad_input(self):
        grid = century.write_run(self.path("grid.h5"), shape=(5, 10), step=1.0)
        for message, arguments in (("--time is not for --film", ("--film", "a.gif", "--time", "3")),
                                   ("--film writes no other picture: leave --kind out",
                                    ("--kind", "rupture", "--film", "a.gif"))):
            self.refused("plot_run", message, grid, *arguments, code=2)


if __name__ == "__main__":
    unittest.main()
