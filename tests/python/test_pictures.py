"""Pictures and films of a run by slipstep plot-run, on a synthetic century of circular ruptures and on irregular
cells."""

import unittest
from types import SimpleNamespace

from scripts import FaultTest, PictureTest

import century
import h5py
import numpy as np

from slipstep.programs.plot_run import attempt_panels, figure
from matplotlib.colors import LogNorm
from slipstep import OutputError, Run
from slipstep.plots.maps import Nothing, Plane, Span, colour_bar, columns_for, planes_of
from slipstep.plots.panels import plt
from slipstep.plots.snapshots import contours_of, logarithmic, rupture, snapshots
from slipstep.plots.spacetime import Line, along_line, resample, space_time
from slipstep.results.fields import KINDS, Fields, events, largest_event, rupture_times
from slipstep.times import YEAR, Clock, seconds, written


class Times(unittest.TestCase):
    def test_units_of_the_command_line(self):
        self.assertEqual([seconds(text) for text in ("12.5", "2min", "3h", "1d", "250y", "-.5", "1e+3s",
                                                     "96.4y+2+1e2min")],
                         [12.5, 120, 10800, 86400, 250 * YEAR, -0.5, 1000, 96.4 * YEAR + 6002])
        for text in ("", "3x", "y", "1 y", "nan", "1e", "1y+", "1y2"):
            with self.assertRaisesRegex(Exception, "s, min, h, d or y"):
                seconds(text)

    def test_clock_takes_the_unit_that_fits(self):
        for begin, end, years, label in ((0, 30, None, "time (s)"), (0, 86400, None, "time (hours)"),
                                         (0, 30 * 86400, None, "time (days)"),
                                         (0, 500 * YEAR, None, "time (years)"), (0, 500 * YEAR, False, "time (days)"),
                                         (0, 30, True, "time (years)"),
                                         (113.25 * YEAR, 113.25 * YEAR + 20, None, "time since 113.25 years (s)")):
            self.assertEqual(Clock(begin, end, years).label, label)
        self.assertEqual(Clock(0, 30)(12.5), 12.5)
        self.assertEqual(Clock(0, 500 * YEAR).text(96.44 * YEAR), "96.4 years")
        self.assertEqual(Clock(0, 30).text(8.251), "8.3 s")
        self.assertEqual([written(64.0076319 * YEAR, span) for span in (np.inf, 3 * 86400, 200)],
                         ["64.008 years", "64.0076 years", "64.007632 years"])
        # 8.25 s after the begin, which is known to 4e-7 s at 3.6e9 s
        self.assertAlmostEqual(float(Clock(113.25 * YEAR, 113.25 * YEAR + 20)(113.25 * YEAR + 8.25)), 8.25, delta=1e-6)


class Scales(unittest.TestCase):
    def test_single_cells_do_not_choose_the_scale_of_a_stress_drop(self):
        values = np.linspace(-1, 5, 1000)
        self.assertEqual(Span().see(values).norm(KINDS["stress_drop"]).vmax, 5)
        values[[3, 500]] = -60, 40
        norm = Span().see(values).norm(KINDS["stress_drop"])
        self.assertEqual((-norm.vmin, norm.vmax), (norm.vmax, norm.vmax))
        self.assertAlmostEqual(norm.vmax, 5, delta=0.1)  # that of which a hundredth is larger
        self.assertEqual(Span().see(values).norm(KINDS["slip"]).vmax, 40)

    def test_nothing_has_no_scale(self):
        """A field that is zero, or rounding, has one number at its bar, not a scale of its own; what is less than a
        shade beyond an end has no arrow."""
        for name, values in (("slip_rate", np.zeros(4)), ("slip", np.array([0, -2e-16])), ("stress_drop", np.zeros(3))):
            norm = Span().see(values).norm(KINDS[name], log=name == "slip_rate")
            self.assertIsInstance(norm, Nothing)
            canvas, axes = plt.subplots()
            bar = colour_bar(canvas, axes.pcolormesh(np.zeros((2, 2)), norm=norm), norm, name)
            self.assertEqual(list(bar.get_ticks()), [0])
        for beyond, extend in ((1e-15, "neither"), (0.1, "both")):
            canvas, axes = plt.subplots()
            norm = plt.Normalize(0, 1)
            self.assertEqual(colour_bar(canvas, axes.pcolormesh(np.array([[-beyond, 1 + beyond]]), norm=norm), norm,
                                        "").extend, extend)
        plt.close("all")

    def test_slip_rates_of_more_than_an_event_are_logarithmic(self):
        self.assertEqual([Clock(0, end).logarithmic("slip_rate") for end in (30, 3 * 3600, 40 * 86400, 500 * YEAR)],
                         [False, False, True, True])
        self.assertEqual([Clock(0, 40 * 86400).logarithmic(name, wanted)
                          for name, wanted in (("slip_rate", False), ("slip", None), ("slip", True))], [False] * 3)
        self.assertTrue(Clock(0, 30).logarithmic("slip_rate", True))
        for peaks, wanted, log in (((0.3, 0.7, 1.0, 0.9, 0.5, 0.2), None, False),
                                   ((0.1, 1.0, 0.15, 0.02, 0.17, 0.06), None, True),
                                   ((0.1, 1.0, 0.15, 0.02, 0.17, 0.06), False, False)):
            maps = SimpleNamespace(name="slip_rate", maps=lambda rows,
                                   peaks=peaks: np.multiply.outer(peaks, [[-1.0, 0.5], [0.0, np.nan]]))
            self.assertEqual(logarithmic(maps, range(6), Clock(0, 30), wanted), log)  # of an event with one fast cell

    def test_planes_lie_where_their_maps_are_larger(self):
        for length, width, planes, columns in ((3, 3, 2, 2), (20, 5, 2, 1), (3, 3, 4, 2), (1, 3, 3, 3), (3, 3, 1, 1)):
            self.assertEqual(columns_for([(0, length, 0, width)] * planes), columns, (length, width, planes))


class Overview(PictureTest):
    def test_panels_are_of_what_is_there(self):
        """An unfinished run is named in the unit of its axes; without error estimates or attempts there is no panel for
        them."""
        path = century.write_run(self.path("run.h5"))
        with h5py.File(path, "r+") as file:
            file.attrs["complete"] = 0
            end = file["series/time"][-1]
        self.assertEqual(Run(path).title, f"run.h5 (unfinished, to {end / YEAR:.3f}".rstrip("0").rstrip(".")
                         + " years)")
        self.assertEqual(attempt_panels(Run(path)), [["steps", "error"]])
        clock = Clock(0.0, end)
        for change, panels in (("error", ["Step size"]), ("none", [])):
            with h5py.File(path, "r+") as file:
                for name in list(file["steps"]):
                    data = file[f"steps/{name}"][...]
                    del file[f"steps/{name}"]
                    century.put(file, f"steps/{name}", data[:0] if change == "none" else -1 + 0 * data
                                if name == "error" else data, "s")
            canvas = figure(Run(path), clock, True)
            titles = [axes.get_title(loc="left") for axes in canvas.axes]
            self.assertEqual([title for title in titles
                              if title in ("Step size", "Error estimate (1 is the tolerance)")], panels)
            canvas.savefig(self.path("overview.png"))

    def test_bars_are_within_the_picture(self):
        """Whatever the shape of the map, those that fill their panels in both directions too: labels of the bars end
        before the picture does."""
        for share in (1.4, 1.43, 1.45):
            path = century.write_run(self.path("run.h5"))
            with h5py.File(path, "r+") as file:
                file["mesh/z"][...] *= share
                end = file["series/time"][-1]
            canvas = figure(Run(path), Clock(0.0, end), True)
            canvas.savefig(self.path("overview.png"))
            right = max(bar.get_tightbbox(canvas.canvas.get_renderer()).x1 for axes in canvas.axes
                        for bar in axes.child_axes)
            self.assertLessEqual(right, canvas.bbox.width, share)


class Ruptures(PictureTest):
    """Pictures of the largest event of a run or window, whatever else that holds."""

    def test_a_window_shows_its_largest_event(self):
        """Of twenty years with two events: times count from the second, every panel has a good part of the largest
        rate, contours are few."""
        run = Run(century.write_run(self.path("run.h5")))
        onset = century.EVENTS[-1][0] * YEAR
        for window, others in (((onset - 18 * YEAR, onset + 2 * YEAR), " in the largest of 2 events of the window"),
                               ((onset - 1e6, onset + 1e6), ""), (None, "")):
            canvas = rupture(run, None, window)
            above, below = canvas.subfigs
            self.assertEqual(above._suptitle.get_text(), f"run.h5: slip rate{others} (times since 96.4 years)")
            images = [axes.images[0] for axes in above.axes if axes.images]
            self.assertEqual(len(images), 6)
            self.assertGreater(min(image.get_array().max() for image in images), 0.2 * images[0].norm.vmax)
            self.assertNotIsInstance(images[0].norm, LogNorm)
            titles = [axes.get_title(loc="left") for axes in above.axes if axes.images]
            self.assertTrue(all(title.endswith(" s") for title in titles) and len(set(titles)) == 6, titles)
            drops = below.axes[1].images[0].get_array()
            np.testing.assert_allclose(drops.max(), century.STIFFNESS * 1e-6 * 2.2, rtol=0.01)
            plt.close(canvas)

    def test_rows_are_at_equal_shares_of_slip(self):
        """Of an event of 5.8 s that begins slowly and ends so; other fields of a long run are at equal times."""
        run = Run(century.write_run(self.path("run.h5"), step=0.05))
        canvas = snapshots(run, "slip_rate", None)
        found = [float(axes.get_title(loc="left").split()[0]) for axes in canvas.axes if axes.images]
        times = np.linspace(0, 5.8, 5801)
        x, z, length, width = century.grid()
        slip = np.array([century.rupture(century.EVENTS[-1], x, z, time)[0].sum() for time in times[::50]])
        shares = np.interp(found, times[::50], slip) / slip[-1]
        # rows each 0.05 s, in which a twentieth slips
        np.testing.assert_allclose(shares, (np.arange(6) + 0.5) / 6, atol=0.05)
        titles = [axes.get_title(loc="left") for axes in snapshots(run, "slip", None).axes if axes.images]
        # rows each four years
        np.testing.assert_allclose([float(title.split()[0]) for title in titles], (np.arange(6) + 0.5) / 6 * 110,
                                   atol=2.1)
        plt.close("all")

    def test_the_largest_event_is_that_of_most_slip(self):
        path = century.write_run(self.path("run.h5"))
        with h5py.File(path, "r+") as file:  # fast, and small
            rate, time = file["series/mean_slip_rate"], file["series/time"][...]
            rate[...] *= np.where(np.abs(time - century.EVENTS[3][0] * YEAR) < 100, 1e3, 1)
        self.assertAlmostEqual(largest_event(Run(path))[0], century.EVENTS[-1][0] * YEAR, delta=0.3)
        self.assertAlmostEqual(largest_event(Run(path), (0, 60 * YEAR))[0], century.EVENTS[1][0] * YEAR, delta=0.3)
        self.assertEqual(largest_event(Run(path), (0, 10 * YEAR)), (0, 10 * YEAR))  # none

    def test_contours_are_of_most_cells(self):
        """Few late cells do not take the others' contours, and their own are left out; cells that break at once have
        none."""
        broke = np.append(np.linspace(0, 10, 190), np.linspace(100, 1000, 10))
        title, levels = contours_of(broke, Clock(0, 1200))
        self.assertEqual(title, "Slip, rupture time every 1 to 18 s")
        np.testing.assert_allclose(levels, np.arange(1, 19))
        title, levels = contours_of(np.append(np.linspace(0, 12, 200), np.nan), Clock(0, 20))
        self.assertEqual((title, list(levels)), ("Slip, rupture time every 1 s", list(range(1, 12))))
        self.assertEqual(contours_of(np.linspace(0, 1e-3, 50), Clock(0, 14)), ("Slip", []))

    def test_lines_stay_within_the_fault(self):
        """A fault with a notch, of squares and of triangles: no contour crosses it, and elsewhere they are as they
        were."""
        x, z = (part.ravel() + 0.5 for part in np.meshgrid(np.arange(20.0), np.arange(10.0)))
        kept = (z < 5) | (x < 8) | (x > 15)
        x, z = x[kept], z[kept]
        squares = np.stack([x - 0.5, x + 0.5]), np.stack([z - 0.5, z + 0.5])
        halves = [np.concatenate([part - 0.5 + np.array(first)[:, None], part - 0.5 + np.array(second)[:, None]],
                                 axis=1)
                  for part, first, second in ((x, (0, 1, 1), (0, 1, 0)), (z, (0, 0, 1), (0, 1, 1)))]
        for sides in (squares, halves):
            plane = Plane(*sides, cells=np.arange(sides[0].shape[1]))
            _, axes = plt.subplots()
            plane.contour(axes, plane.x.mean(axis=0), np.arange(1.0, 20) + 0.1)
            drawn = np.concatenate([np.concatenate([path.vertices for path in lines.get_paths() if len(path.vertices)])
                                    for lines in axes.collections])
            inside = (drawn[:, 1] > 5.15) & (drawn[:, 0] > 8.15) & (drawn[:, 0] < 14.85)  # but for corners of the notch
            self.assertFalse(inside.any(), drawn[inside])
            for low, high in ((0.5, 9.5), (15.5, 19.5)):  # beside the notch lines reach the lower row
                self.assertGreater(drawn[(drawn[:, 0] > low) & (drawn[:, 0] < high)][:, 1].max(),
                                   9 if low > 8 or high < 8 else 4.4)
        plt.close("all")
        # faults without a notch, rows of the second shifted
        for (x, z, length, width), shift in ((century.graded(), 0.0), (century.grid(), 0.37)):
            x, z = np.stack([x - length / 2,
                             x + length / 2]) / 1e3 + shift * z / 1e3, np.stack([z - width / 2, z + width / 2]) / 1e3
            self.assertFalse(Plane(x, z).between().mask.any())


class Ends(PictureTest):
    """Runs of few cells, and of few of anything."""

    def test_a_single_cell(self):
        """Is as large as the file says, in maps, curves and space-time pictures."""
        run = Run(century.write_run(self.path("cell.h5"), shape=(1, 1)))
        plane, = planes_of(run)
        self.assertEqual(plane.extent, (0, 20, 0, 10))
        onset = century.EVENTS[-1][0] * YEAR
        lines = snapshots(run, "slip", [onset + 1, onset + 3]).axes[0].lines
        self.assertEqual([list(line.get_xdata()) for line in lines], [[0, 20]] * 2)
        self.assertEqual([line.get_ydata()[0] for line in lines], [line.get_ydata()[1] for line in lines])
        self.assertEqual(Line(plane).drawn(np.array([[2.0]]))[1].tolist(), [[2.0, 2.0]])
        plt.close("all")

    def test_a_line_across_a_notch_has_a_gap(self):
        x, z, length, width = century.grid(20, 10)
        kept = (z < 5000) | (x < 8000) | (x > 15000)
        run = Run(century.write_run(self.path("run.h5"), cells=[part[kept] for part in (x, z, length, width)]))
        line = Line(planes_of(run)[0], "strike", 6.5)
        values = along_line(Fields(run, "slip"), line)
        np.testing.assert_array_equal(np.isnan(values[-1]), (line.centres > 8) & (line.centres < 15))
        canvas = space_time(run, ["slip"], at=6.5)
        axes = canvas.axes[0]
        # rectangles from Matplotlib 3.9 on
        spans = [patch.get_patch_transform().transform(patch.get_path().vertices)[:, 1].min() for patch in axes.patches]
        np.testing.assert_allclose(spans, [8], atol=1e-6)
        mesh = axes.collections[0]
        self.assertAlmostEqual(mesh.norm.vmax, np.nanmax(values))
        plt.close("all")

    def test_a_century_is_compared_in_years(self):
        from slipstep.programs import compare
        runs = [(label, Run(century.write_run(self.path(f"{label}.h5")))) for label in "ab"]
        rate, slip, steps, plane = compare.figure(runs, runs[1][1], None).axes[:4]
        self.assertEqual({axes.get_xlabel() for axes in (rate, slip, steps)}, {"time (years)"})
        self.assertEqual((rate.get_yscale(), slip.get_yscale()), ("log", "linear"))
        self.assertRegex(plane.get_title(loc="left"), r"^Slip rate at 96\.4 years \(a\)$")
        self.assertTrue(all(line.get_xdata().max() < 111 for line in rate.lines))
        plt.close("all")

    def test_panels_have_the_times_of_the_run(self):
        run = Run(century.write_run(self.path("run.h5")))
        canvas = figure(run, Clock(0.0, run.series["time"][-1]), True)
        limits = {axes.get_xlim() for axes in canvas.axes if axes.get_xlabel() == "time (years)"}
        self.assertEqual(len(limits), 1)
        self.assertLess(min(limits)[0], 0)
        self.assertGreater(min(limits)[1], 110)
        plt.close("all")


class FieldsTest(PictureTest):
    def test_rupture_times_are_those_of_the_front(self):
        """Rows every 0.1 s, linear between: a cell breaks between the last row at rest and the first above 1 mm/s. Its
        rate grows by 2 m/s^2 at first, so that it is above in the row after the front: at most 0.1 s late, never
        early."""
        path = century.write_run(self.path("run.h5"), step=0.1)
        with h5py.File(path, "r+") as file:  # as the program stores it
            single = file["fields/slip_rate"][:].astype(np.float32)
            del file["fields/slip_rate"]
            century.put(file, "fields/slip_rate", single, "m/s")
        run = Run(path)
        window = largest_event(run)
        onset = century.EVENTS[-1][0] * YEAR
        self.assertAlmostEqual(window[0], onset, delta=0.2)
        found = rupture_times(Fields(run, "slip_rate", window)).ravel() - onset
        x, z, _, _ = century.grid()
        slip, _, front = century.rupture(century.EVENTS[-1], x, z, 1e9)
        np.testing.assert_array_equal(np.isfinite(found), slip > 0)
        late = (found - front)[slip > 0.05]
        self.assertLess(late.max(), 0.1 + 1e-6)
        self.assertGreater(late.min(), -0.1 - 1e-6)

    def test_stress_drop_is_stiffness_times_slip(self):
        run = Run(century.write_run(self.path("run.h5")))
        drops = Fields(run, "stress_drop", largest_event(run))
        x, z, _, _ = century.grid()
        slip, _, _ = century.rupture(century.EVENTS[-1], x, z, 1e9)
        # in MPa; seconds of loading change it by 1e-8 MPa, and creep below 8 km likewise
        np.testing.assert_allclose(drops.outer()[1].ravel(), century.STIFFNESS * 1e-6 * slip, atol=1e-6)
        with h5py.File(run.path, "r+") as file:  # the other sense of slip has the same drop
            file["fields/traction"][...] *= -1
        np.testing.assert_allclose(Fields(run, "stress_drop", largest_event(run)).outer()[1].ravel(),
                                   century.STIFFNESS * 1e-6 * slip, atol=1e-6)

    def test_window_begins_at_the_row_before_it(self):
        """A drop is measured from the last row before an event, not from the first one within it."""
        run = Run(century.write_run(self.path("run.h5")))
        onset = century.EVENTS[-1][0] * YEAR
        fields = Fields(run, "slip", (onset + 0.3, onset + 1.1))  # rows every 0.25 s
        np.testing.assert_allclose(fields.times - onset, (0.5, 0.75, 1.0), atol=1e-6)
        outer = [century.state(*century.grid()[:2], onset + time)[0] for time in (0.25, 1.25)]
        # times of 3e9 s are known to 5e-7 s, slip rates are up to 1 m/s
        np.testing.assert_allclose(fields.outer().reshape(2, -1), outer, atol=1e-6)

    def test_events_are_where_rates_are_high(self):
        times, rates = np.arange(8.0), np.array([0, 1, 1, 0, 0, 1, 0, 1.0])
        self.assertEqual(events(times, rates, 0.5), [(0, 3), (4, 6), (6, 7)])

    def test_lines_meet_the_cells_that_they_cross(self):
        run = Run(century.write_run(self.path("run.h5")))
        slip = Fields(run, "slip")
        plane, = planes_of(run)
        _, maps = run.field("slip")
        for line, expected in ((Line(plane, "strike", 6.3), maps[:, 12]), (Line(plane, "depth", 20.0), maps[:, :, 39]),
                               (Line(plane, "strike", "max"), maps.max(axis=1)),
                               (Line(plane, "depth", "mean"), maps.mean(axis=2))):
            # sums of 40 numbers in another order
            np.testing.assert_allclose(along_line(slip, line), expected, rtol=1e-13)
        np.testing.assert_allclose(Line(plane).edges, np.linspace(0, 20, 41))

    def test_lines_of_irregular_cells(self):
        """Rows of the mesh: on a line at one depth each cell has an interval of its own; means have areas as
        weights."""
        x, z, length, width = century.graded()
        run = Run(century.write_run(self.path("run.h5"), cells=century.graded(), planes=2))
        second = planes_of(run)[1]
        self.assertEqual(second.name, "plane at y = 2000 m")
        slip = Fields(run, "slip")
        maps = slip.maps([len(slip.times) - 1])[:, 200:]
        line = Line(second, "strike", 4.5)
        np.testing.assert_allclose(line.edges, np.append((x - length / 2)[:20], 20000) / 1e3, atol=1e-9)
        np.testing.assert_array_equal(line.values(slip.maps([len(slip.times) - 1])), maps[:, 80:100])
        mean = Line(second, "depth", "mean").values(slip.maps([len(slip.times) - 1]))[0]
        np.testing.assert_allclose(mean, (maps[0] * length).reshape(10, 20).sum(axis=1) / 20000, rtol=1e-12)

    def test_columns_keep_every_event(self):
        """A century in 500 columns: seconds of slip are in the column of their time, and gaps have the smaller
        neighbour."""
        run = Run(century.write_run(self.path("run.h5")))
        rates = Fields(run, "slip_rate")
        values = along_line(rates, Line(planes_of(run)[0], "strike", "max"))
        bounds, columns = resample(rates.times, values, 500, True)
        fast = np.flatnonzero((columns > 1e-3).any(axis=1))
        expected = [np.searchsorted(bounds, event[0] * YEAR) - 1 for event in century.EVENTS]
        np.testing.assert_array_equal(fast, expected)
        self.assertEqual(columns.max(), values.max())
        _, gap = resample(np.array([0.0, 1.0, 9.0, 10.0]), np.array([[0.0], [5.0], [1.0], [2.0]]), 10, True)
        # the two ends of the gap are 5 and 1
        np.testing.assert_array_equal(gap.ravel(), (0, 5, 1, 1, 1, 1, 1, 1, 1, 2))
        _, linear = resample(np.array([0.0, 1.0, 3.0]), np.array([[0.0], [1.0], [5.0]]), 3, False)
        np.testing.assert_allclose(linear.ravel(), (0.5, 2, 4))

    def test_parameters_of_cells_are_fields_of_one_row(self):
        """A dataset of /mesh with a number for each cell; of irregular cells, too. What else is there is no field."""
        for name, more in (("run.h5", {}), ("mesh.h5", {"cells": century.graded(), "planes": 2})):
            path = century.write_run(self.path(name), step=1.0, **more)
            run = Run(path)
            shape = (len(run.mesh["x"]),) if run.planes else run.shape
            tendency = np.random.default_rng(1).random(shape)
            with h5py.File(path, "r+") as file:
                file["mesh/slip_tendency"] = tendency
                file["mesh/odd"] = np.zeros(3)
            run = Run(path)
            fields = Fields(run, "slip_tendency")
            np.testing.assert_array_equal(fields.times, [0])
            np.testing.assert_array_equal(fields.maps([0]), tendency[np.newaxis])
            np.testing.assert_array_equal(fields.outer()[0], tendency)
            with self.assertRaisesRegex(OutputError, "field odd was not stored"):
                Fields(run, "odd")

    def test_maps_of_another_shape_are_refused(self):
        path = century.write_run(self.path("run.h5"))
        with h5py.File(path, "r+") as file:
            del file["mesh/x"]
            file["mesh/x"] = np.arange(7.0)
        with self.assertRaisesRegex(OutputError, r"run.h5: /fields/slip is \(20, 40\) at each time"):
            Fields(Run(path), "slip")


class Pictures(PictureTest):
    def test_kinds(self):
        grid = century.write_run(self.path("grid.h5"), shape=(10, 20), step=0.5)
        for arguments, suffix in (((), ""), (("--time", "31.31y", "50y", "--field", "slip"), "_snapshots"),
                                  (("--kind", "space-time", "--against", "step", "--along", "depth", "--at", "7"),
                                   "_space-time")):
            self.assertEqual(self.plot("plot_run", grid, *arguments), f"Figure: {self.path('grid')}{suffix}.png\n")
            self.look(self.path(f"grid{suffix}.png"))

    def test_kinds_on_irregular_cells(self):
        mesh = century.write_run(self.path("mesh.h5"), cells=century.graded(), planes=2, step=0.5)
        for arguments in (("--kind", "rupture", "--log-rate", "--range", "1e-9", "1", "--time",
                           f"{century.EVENTS[-1][0] * YEAR + 2}"),
                          ("--kind", "space-time", "--at", "max", "--field", "slip")):
            self.plot("plot_run", mesh, *arguments, "--figure", self.path("mesh.png"))
            self.look(self.path("mesh.png"))

    def test_a_single_row_of_cells_has_curves(self):
        from slipstep.plots.snapshots import snapshots
        run = Run(century.write_run(self.path("row.h5"), shape=(1, 40)))
        onset = century.EVENTS[-1][0] * YEAR
        for log in (False, True):
            lines = snapshots(run, "slip_rate", [onset + 3, onset + 1], log=log).axes[0].lines
            self.assertEqual([line.get_label() for line in lines], ["3.00 s", "1.00 s"])
            rate = century.state((np.arange(40) + 0.5) * 500, np.full(40, 5000.0), onset + 1)[1]
            np.testing.assert_allclose(lines[1].get_ydata(), np.where(log & (rate == 0), np.nan, rate), atol=1e-6)
            np.testing.assert_allclose(lines[1].get_xdata(), (np.arange(40) + 0.5) / 2)

    def test_colours_begin_at_zero(self):
        """The colour bar of a slip rate, and limits of the user's own, as the scale of the drawn image."""
        from slipstep.plots.snapshots import snapshots
        run = Run(century.write_run(self.path("run.h5")))
        for arguments, limits in (({}, (0, None)), ({"wanted": (0.2, 0.4)}, (0.2, 0.4)),
                                  ({"log": True, "wanted": (1e-9, 1)}, (1e-9, 1))):
            canvas = snapshots(run, "slip_rate", [century.EVENTS[-1][0] * YEAR + 2], **arguments)
            image = next(axes.images[0] for axes in canvas.axes if axes.images)
            self.assertEqual(image.norm.vmin, limits[0])
            self.assertTrue(limits[1] is None or image.norm.vmax == limits[1])
        for name, low, high in (("slip", 0, 3), ("traction", 2, 3), ("stress_drop", -3, 3)):  # of values from 2 to 3
            norm = Span().see(np.array([2.0, 3.0])).norm(KINDS[name])
            self.assertEqual((norm.vmin, norm.vmax), (low, high))

    def test_bad_input(self):
        run = century.write_run(self.path("run.h5"), fields=("slip_rate",), shape=(4, 8), step=1.0)
        plain = century.write_run(self.path("none.h5"), fields=(), shape=(4, 8), step=1.0)
        for message, arguments in (
                ("run.h5: no field at 1.57.*e.10 s", (run, "--time", "500y")),
                ("run.h5: field slip was not stored; a picture of a rupture needs .* -fault_output_fields "
                 "slip_rate,slip,traction", (run, "--kind", "rupture")),
                ("run.h5: field mood was not stored .there are: slip_rate.; run with -fault_output_fields mood",
                 (run, "--field", "mood")),
                ("none.h5: field slip_rate was not stored .there are: none", (plain, "--kind", "space-time")),
                ("--at is 11 km", (run, "--kind", "space-time", "--at", "11")),
                ("--range begins at 0",
                 (run, "--kind", "space-time", "--field", "slip_rate", "--range", "0", "1")),
                ("/fields/slip_rate has no rows between .* s", (run, "--kind", "rupture", "--window", "10y", "10.1y")),
                ("--film is .*film.avi",
                 (run, "--film", self.path("film.avi"))),
                ("--film is .*film.gif, but there is no folder", (run, "--film", self.path("no/film.gif"))),
                ("missing.h5: no such file", (self.path("missing.h5"), "--film", self.path("film.gif")))):
            with self.subTest(message):
                self.refused("plot_run", message, *arguments)
        for message, arguments in (("error: argument --time: 3x is no time", ("--time", "3x")),
                                   ("error: --along is not for --kind rupture",
                                    ("--kind", "rupture", "--along", "depth")),
                                   ("error: --range is 2 1", ("--range", "2", "1")),
                                   ("error: --fps is 0", ("--film", "a.gif", "--fps", "0")),
                                   ("error: --fps is not for --kind overview", ("--fps", "3"))):
            with self.subTest(message):
                self.refused("plot_run", message, run, *arguments, code=2)


class ManySteps(FaultTest, PictureTest):
    def test_many_steps_have_small_dots_and_legends_hide_nothing(self):
        self.fault("-fault_nx", "1", "-fault_nz", "1", "-ts_adapt_type", "none", "-ts_dt", "1e-3", "-ts_max_time",
                   "3.1", "-fault_output", self.path("many.h5"), "-fault_output_interval", "1000")
        run = Run(self.path("many.h5"))
        canvas = figure(run, Clock(0, 3.1), False)
        panels = {axes.get_title(loc="left") or axes.get_title(): axes for axes in canvas.axes}
        steps = panels["Step size"]
        self.assertEqual(len(run.steps["dt"]), 3100)
        self.assertLess(max(line.get_markersize() for line in steps.lines), 3)
        self.assertEqual({line.get_marker() for line in panels["Mean slip"].lines}, {""})
        for axes in (steps, panels["Slip rate"]):
            self.assertGreaterEqual(axes.get_legend().get_window_extent().y0, axes.get_window_extent().y1 - 1)


if __name__ == "__main__":
    unittest.main()
