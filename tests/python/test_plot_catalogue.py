"""Pictures of a catalogue by slipstep plot-catalogue, on synthetic ones in the format of -fault_catalogue."""

import unittest

from scripts import PictureTest

import century
import h5py
import numpy as np

from slipstep import OutputError, Run
from slipstep.plots.cumulative import Course, between, during, plain
from slipstep.plots.maps import planes_of
from slipstep.plots.spacetime import Line
from slipstep.programs import plot_catalogue
from slipstep.results.events import Events, b_value, completeness
from slipstep.times import YEAR, Clock


class Reading(PictureTest):
    def test_columns_and_maps(self):
        events = Events(century.write_catalogue(self.path("c.h5")))
        self.assertEqual(len(events), 5)
        np.testing.assert_array_equal(events["onset"], [event[0] * YEAR for event in century.EVENTS])
        self.assertEqual((events.shape, events.planes), ((20, 40), None))
        slip = events.map_of("slip", 4)
        self.assertAlmostEqual(slip.max(), events["max_slip"][4])
        self.assertAlmostEqual((slip * 500 * 500).sum() * century.MODULUS / events["moment"][4], 1)

    def test_a_catalogue_that_grows(self):
        """Columns of one that is written may differ in length: the least counts, and a picture says that it is
        unfinished."""
        path = century.write_catalogue(self.path("c.h5"), skip=("onset",), complete=0)
        with h5py.File(path, "r+") as file:
            century.put(file, "onset", [1.0, 2.0, 3.0], "s")
        events = Events(path)
        self.assertEqual((len(events), len(events["magnitude"])), (3, 3))
        code, _, err = self.main("plot_catalogue", path, "--event", "3")
        self.assertEqual(code, 0)
        self.assertRegex(err, r"^slipstep plot-catalogue: .*c.h5 .*3 s\n$")

    def test_bad_files(self):
        none = {name: (values[:0], unit) for name, (values, unit) in century.columns().items()}
        for name, message, options in (("a.h5", "dataset /moment is missing; it has area, cell, end, ",
                                        {"skip": ("moment",)}),
                                       ("b.h5", "no event is there$", {"data": none}),
                                       ("d.h5", "no event is there yet", {"data": none, "complete": 0})):
            with self.assertRaisesRegex(OutputError, f"{name}: {message}"):
                Events(century.write_catalogue(self.path(name), **options))
        path = century.write_catalogue(self.path("c.h5"))
        with h5py.File(path, "r+") as file:
            file["onset"].attrs["units"] = "years"
        with self.assertRaisesRegex(OutputError, 'c.h5: /onset has units "years"'):
            Events(path)


class Laws(unittest.TestCase):
    def test_b_of_a_known_law(self):
        """20000 magnitudes of an exponential law with b = 0.9, and fewer small ones: b within three standard errors,
        0.02."""
        random = np.random.default_rng(5)
        magnitude = 3 + random.exponential(1 / (0.9 * np.log(10)), 20000)
        magnitude = np.concatenate([magnitude, random.uniform(2, 3, 2000)])  # not all that there are
        least = completeness(magnitude)
        self.assertAlmostEqual(least, 3.0, delta=1e-9)
        b, error = b_value(magnitude, least)
        self.assertAlmostEqual(b, 0.9, delta=3 * error)
        self.assertAlmostEqual(error, 0.9 / np.sqrt(20000), delta=1e-4)

    def test_intervals_in_words(self):
        for interval, words in ((1, "1 s"), (86400, "1 day"), (2 * 86400, "2 days"), (43200, "12 hours"),
                                (100000, "100000 s"), (5 * YEAR, "5 years")):
            self.assertEqual(plain(interval), words)

    def test_times_between_events(self):
        np.testing.assert_allclose(between(50.0, 10.0, [(9.0, 11.0), (30.0, 31.0)]), (0, 20, 30, 40, 50))

    def test_times_during_an_event(self):
        """Lines between rows that are close, at rows that are not."""
        close, dense, wanted = during(np.arange(0, 10, 0.3), 3.05, 6.0, 1.0)
        self.assertEqual((dense, wanted), (True, 3))
        np.testing.assert_allclose(close, (3.05, 4.05, 5.05))
        far, dense, wanted = during(np.array([0.0, 3.0, 6.0, 9.0]), 2.0, 7.0, 1.0)
        self.assertEqual((dense, wanted), (False, 6))
        np.testing.assert_array_equal(far, (3, 6))


class Fit(PictureTest):
    """Which events have a b, on cells of 500 m: a crack of 3 MPa over one of them has M 3.39, over one and a half
    3.57."""

    def events(self, data, **attributes):
        path = century.write_catalogue(self.path("c.h5"), data, skip=())
        with h5py.File(path, "r+") as file:
            file.attrs.update(attributes)
        return Events(path)

    def test_events_of_one_cell_are_left_out(self):
        data = century.many(4000)
        events = self.events(data)
        self.assertEqual(events.cell_magnitude, np.median(data["magnitude"][0][data["area"][0] < 1.5 * 500 * 500]))
        least, b, error, above = events.fit()
        self.assertGreater(least, 3.56)
        self.assertEqual(above, (data["magnitude"][0] >= least).sum())
        self.assertAlmostEqual(b, 1.0, delta=3 * error)
        # as many again, each over one cell, with magnitudes around 3.2 up to 4: fitted alike
        more = {name: (np.concatenate([values, values]), unit) for name, (values, unit) in data.items()}
        more["area"][0][4000:] = 500.0 * 500.0
        more["magnitude"][0][4000:] = np.linspace(2.4, 4, 4000)
        self.assertEqual(self.events(more).fit(), (least, b, error, above))

    def test_nothing_to_fit(self):
        large = Events(century.write_catalogue(self.path("large.h5"), century.many(100, smallest=3.6)))
        self.assertAlmostEqual(large.cell_magnitude, (np.log10(16 / 7 * 3e6 * (500 * 500 / np.pi) ** 1.5) - 9.1) / 1.5)
        few = century.many(100)  # 27 of them in the mean are larger than one and a half cells
        self.assertRegex(self.events(few).fit(), "^no b: 2[0-9] events of several cells")
        narrow = century.many(4000)
        keep = (narrow["magnitude"][0] > 3.5) & (narrow["magnitude"][0] < 4.05)
        self.assertRegex(self.events({name: (values[keep], unit) for name, (values, unit) in narrow.items()}).fit(),
                         r"of M 3\.[67] to 4\.0$")
        self.assertEqual(self.events(century.many(4000), weakens=0).fit(), "no b: friction weakens nowhere")
        for path in (century.write_catalogue(self.path("a.h5")),
                     century.write_catalogue(self.path("b.h5"), century.many(4000))):
            self.plot("plot_catalogue", path)
            self.look(path.replace(".h5", ".png"))


class Networks(PictureTest):
    def catalogue(self, count):
        """The events of the century on so many parallel faults of 100 cells that strike north, all on the third."""
        path = century.write_catalogue(self.path("c.h5"))
        x, z = (part.ravel() for part in np.meshgrid(np.arange(20) * 1e3 + 500, np.arange(5) * 2e3 + 1e3))
        cells = np.concatenate([np.column_stack([x, np.full(100, 4e3 * k), z, *np.tile([[1e3], [2e3], [0], [90]], 100)])
                                for k in range(count)])
        slip = np.zeros((5, 100 * count))
        slip[:, 200:300] = 1.0
        with h5py.File(path, "r+") as file:
            del file["maps"], file["cell"]
            century.put(file, "y", np.full(5, 8e3), "m")
            century.put(file, "cell", np.full(5, 205), "1")
            century.put(file, "maps/slip", slip, "m")
            century.put(file, "maps/rupture_time", np.where(slip > 0, 1.0, np.nan), "s")
        return century.turn(path, cells, np.repeat(np.arange(1, count + 1), 100))

    def test_faults_without_events(self):
        """The last of few faults has none, and so no colours."""
        self.plot("plot_catalogue", self.catalogue(4))
        self.plot("plot_catalogue", self.path("c.h5"), "--event", "1")

    def test_many_faults(self):
        """Hypocentres are on one map, north up; a picture of an event has the one fault that slipped."""
        events = Events(self.catalogue(30))
        canvas, _ = plot_catalogue.figure(events, [], None)
        panel, = (axes for axes in canvas.axes if axes.get_title(loc="left") == "Hypocentres")
        self.assertEqual((panel.get_xlabel(), panel.get_ylabel()), ("east (km)", "north (km)"))
        np.testing.assert_allclose((panel.get_xlim(), panel.get_ylim()), ((0, 116), (0, 20)), atol=1e-9)
        dots = next(one for one in panel.collections if len(one.get_offsets()) == 5)
        np.testing.assert_allclose(np.sort(dots.get_offsets(), axis=0), np.sort(
            [[8.0, event[1] / 1e3] for event in century.EVENTS], axis=0))
        self.assertLess(canvas.get_figheight(), 12)
        canvas = plot_catalogue.event_figure(events, 1)
        self.assertIn("without 29 faults that slipped by less than 1%", " ".join(canvas._suptitle.get_text().split()))
        self.assertEqual([own.short for own in planes_of(events)], ["fault 3"])


class Cumulative(PictureTest):
    def test_lines_are_the_slip_of_their_times(self):
        """Every 5 years outside of events, and every second within the last one, against the synthetic slip itself."""
        run = Run(century.write_run(self.path("run.h5")))
        course = Course(run, Line(planes_of(run)[0], "depth", 10.2), "slip", 5 * YEAR, 1.0)
        onset, end = century.EVENTS[-1][0] * YEAR, century.EVENTS[-1][0] * YEAR + century.duration(century.EVENTS[-1])
        solid, dashed, poor, wanted = course.lines([(onset, end)])
        self.assertEqual((len(solid), len(dashed), poor), (23, 6, 0))
        x, z = np.full(20, 10250.0), (np.arange(20) + 0.5) * 500
        expected = np.array([century.state(x, z, time)[0] for time in np.arange(23) * 5 * YEAR])
        # linear between rows that are at most 4.1 years apart and on which slip is linear but for events, which have
        # rows of their own
        np.testing.assert_allclose(solid, expected, atol=1e-6)
        expected = np.array([century.state(x, z, onset + k)[0] for k in range(6)])
        # rows are 0.25 s apart and times of 3e9 s known to 5e-7 s, at slip rates up to 1.1 m/s
        np.testing.assert_allclose(dashed, expected, atol=1e-6)
        _, rows, poor, wanted = Course(run, Line(planes_of(run)[0]), "slip", None, 0.01).lines([(onset, end)])
        # 5.8 s of rows every 0.25 s, too far apart for lines every 0.01 s
        self.assertEqual((len(rows), poor, wanted), (24, 1, 581))


class Pictures(PictureTest):
    def test_catalogue_with_its_run(self):
        events = century.write_catalogue(self.path("c.h5"))
        run = century.write_run(self.path("run.h5"))
        self.assertEqual(self.plot("plot_catalogue", events, run), f"Figure: {self.path('c.png')}\n")
        self.look(self.path("c.png"))

    def test_events_of_several_faults(self):
        """A colour for each fault of the hypocentres, and the faults that broke in the title of an event."""
        from slipstep.programs import plot_catalogue
        path = century.write_catalogue(self.path("c.h5"))
        with h5py.File(path, "r+") as file:
            century.put(file, "fault", [7, -3, 7, 7, -3], "1")
            century.put(file, "rake", [90.0] * 5, "degrees")
            century.put(file, "fault_area", [[0.0, 4e6]] * 4 + [[2e6, 1e6]], "m^2")
            file.attrs["faults"] = [-3, 7]
        events = Events(path)
        _, axes = plot_catalogue.plt.subplots()
        plot_catalogue.draw_times(axes, events, Clock(0.0, 110 * YEAR))
        self.assertEqual([text.get_text() for text in axes.get_legend().get_texts()], ["fault -3", "fault 7"])
        with h5py.File(path, "r+") as file:
            century.put(file["mesh"], "fault", file["fault"][()], "1")
            file["mesh/fault"].attrs["names"] = "7 Camp Rock fault; -3 Northern Long Valley fault, western strand"
        named = Events(path)
        _, others = plot_catalogue.plt.subplots()
        plot_catalogue.draw_times(others, named, Clock(0.0, 110 * YEAR))
        self.assertEqual([text.get_text() for text in others.get_legend().get_texts()],
                         ["Northern Long Valley fault, western strand", "Camp Rock fault"])
        self.assertEqual(plot_catalogue.broken_faults(named, 4),
                         "Northern Long Valley fault, western strand, Camp Rock fault, ")
        with h5py.File(path, "r+") as file:
            del file["mesh/fault"]
        self.assertEqual([len(line.get_xdata()) for line in axes.lines], [2, 3])
        self.assertRegex(plot_catalogue.event_figure(events, 0)._suptitle.get_text(),
                         r"M [\d.]+, fault 7, rake 90°, stress drop ")
        self.assertIn(", faults -3, 7, rake", plot_catalogue.event_figure(events, 4)._suptitle.get_text())
        self.plot("plot_catalogue", path)
        self.look(self.path("c.png"))

    def test_a_single_event(self):
        """Has its magnitude in words, and neither a frequency nor a bar of magnitudes; faults without an event do not
        push panels away."""
        from slipstep.programs import plot_catalogue
        one = {name: (values[-1:], unit) for name, (values, unit) in century.columns().items()}
        path = century.write_catalogue(self.path("one.h5"), one)
        with h5py.File(path, "r+") as file:
            century.put(file, "fault", [7], "1")
            file.attrs["faults"] = [-3, 7]
        canvas, _ = plot_catalogue.figure(Events(path), [], None)
        canvas.canvas.draw()
        top, places = canvas.axes
        self.assertEqual([text.get_text() for text in top.texts], [f"M {one['magnitude'][0][0]:.2f}"])
        self.assertEqual(places.get_title(loc="left"), "Hypocentre: the ruptured area is too large for a circle")
        for axes in canvas.axes:
            self.assertGreater(axes.get_window_extent().height, 120)  # pixels, of 720
        self.plot("plot_catalogue", path)
        two = {name: (np.repeat(values, 2), unit) for name, (values, unit) in one.items()}
        canvas, _ = plot_catalogue.figure(Events(century.write_catalogue(self.path("two.h5"), two)), [], None)
        frequency, bar = canvas.axes[1], canvas.axes[-1]
        self.assertEqual(frequency.get_title(loc="left"), "Magnitude and frequency")
        self.assertGreaterEqual(np.ptp(frequency.get_xlim()), 0.2)
        self.assertAlmostEqual(np.ptp(bar.get_xlim()), 0.2)

    def test_lines_of_a_single_cell(self):
        from slipstep.programs import plot_catalogue
        from slipstep.plots.cumulative import draw_cumulative
        run = Run(century.write_run(self.path("cell.h5"), shape=(1, 1)))
        _, axes = plot_catalogue.plt.subplots()
        draw_cumulative(axes, Course(run, Line(planes_of(run)[0]), "slip", 5 * YEAR, 1.0), [])
        drawn = axes.collections[-1].get_segments()
        self.assertGreater(len(drawn), 10)
        self.assertTrue(all(line[:, 0].tolist() == [0, 20] for line in drawn))

    def test_legends_say_what_is_drawn(self):
        """As many lines as they name, or how many of those there are; none of events where there is none."""
        from slipstep.programs import plot_catalogue
        from slipstep.plots.cumulative import draw_cumulative
        run = Run(century.write_run(self.path("run.h5")))
        onset = century.EVENTS[-1][0] * YEAR
        event = [(onset, onset + century.duration(century.EVENTS[-1]))]
        for every, events, said in ((1.0, event, "every 1 s during events"),
                                    (0.01, event, "every 0.01 s during events: the 24 of 581 that rows are stored for"),
                                    (1.0, [], None)):
            _, axes = plot_catalogue.plt.subplots()
            draw_cumulative(axes, Course(run, Line(planes_of(run)[0]), "slip", 5 * YEAR, every), events)
            self.assertEqual([text.get_text() for text in axes.get_legend().get_texts()],
                             ["every 5 years", *([said] if said else [])])
            self.assertEqual(len(axes.collections[0].get_segments()), 0 if not said else 24 if "of" in said else 6)

    def test_circles_leave_their_panel_free(self):
        """However many events there are: circles are no wider than the panel, together no larger, and the title says
        how many there are."""
        from slipstep.programs import plot_catalogue
        for data, title in ((century.many(271), "circles of 5 of 271 ruptured areas"),
                            (century.many(50, smallest=4.5), "of 50 ruptured areas"),
                            (None, "circles of 4 of 5 ruptured areas")):
            canvas, _ = plot_catalogue.figure(Events(century.write_catalogue(self.path("c.h5"), data)), [], None)
            axes = next(axes for axes in canvas.axes if "Hypocentre" in axes.get_title(loc="left"))
            self.assertIn(title, axes.get_title(loc="left"))
            circles, = (found for found in axes.collections if type(found).__name__ == "EllipseCollection")
            width = 2 * circles._widths  # kept as half widths
            self.assertLessEqual(width.max(), 10)
            self.assertLessEqual((np.pi * (width / 2) ** 2).sum(), 200)

    def test_legends_are_above_the_events(self):
        from slipstep.programs import plot_catalogue
        canvas, _ = plot_catalogue.figure(Events(century.write_catalogue(self.path("c.h5"),
                                                                         century.many(60, smallest=3.6))), [], None)
        canvas.canvas.draw()
        axes = canvas.axes[1]
        low = axes.transData.inverted().transform(axes.get_legend().get_window_extent())[0, 1]
        self.assertGreater(low, 60)

    def test_many_events_of_irregular_cells(self):
        data = century.many()
        data["magnitude"][0][7] = np.nan  # of no moment
        events = century.write_catalogue(self.path("c.h5"), data)
        run = century.write_run(self.path("run.h5"), cells=century.graded(), step=2.0)
        code, _, err = self.main("plot_catalogue", events, run, "--along", "depth", "--at", "3", "--every", "10y",
                                 "--every-event", "0.5")
        self.assertEqual(code, 0, err)
        self.assertRegex(err, r"^slipstep plot-catalogue: .*run.h5 has too few rows of /fields in \d+ events for a "
                         r"line every 0.5 s: .* " r"-fault_output_interval or -fault_output_slip_interval\n$")
        self.look(self.path("c.png"))

    def test_one_event(self):
        events = century.write_catalogue(self.path("c.h5"))
        for number in ("2", "largest"):
            self.plot("plot_catalogue", events, "--event", number)
            self.look(self.path(f"c_event_{number}.png"))

    def test_bad_input(self):
        events = century.write_catalogue(self.path("c.h5"))
        bare = century.write_catalogue(self.path("bare.h5"), maps=False)
        run = century.write_run(self.path("run.h5"), fields=("slip_rate",), shape=(4, 8), step=1.0)
        for message, arguments, code in ((r"c.h5: no event 6", (events, "--event", "6"), 1),
                                         (r"c.h5: no event 0", (events, "--event", "0"), 1),
                                         (r"bare.h5: no /maps/slip; fault -fault_catalogue_maps writes it",
                                          (bare, "--event", "1"), 1),
                                         (r"run.h5: field slip was not stored", (events, run), 1),
                                         (r"run.h5: no catalogue of events, as fault -fault_catalogue writes it",
                                          (run,), 1),
                                         (r"c.h5: group /steps is missing", (events, events), 1),
                                         (r"none.h5: no such file; fault -fault_catalogue writes it",
                                          (self.path("none.h5"),), 1),
                                         (r"error: --at needs RUN", (events, "--at", "3"), 2),
                                         (r"error: --event is two", (events, "--event", "two"), 2),
                                         (r"error: --every is 0 s", (events, run, "--every", "0"), 2)):
            with self.subTest(message):
                self.refused("plot_catalogue", message, *arguments, code=code)


if __name__ == "__main__":
    unittest.main()
