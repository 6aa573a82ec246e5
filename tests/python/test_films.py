"""Films of a run by slipstep plot-run --film, on a synthetic century."""

import os
import re
import shutil
import subprocess
import unittest
from unittest import mock

from scripts import PictureTest

import century
import h5py
import numpy as np
from PIL import Image

from slipstep import Run
from slipstep.plots import film
from slipstep.times import NAMES, SECONDS, YEAR


class Films(PictureTest):
    def test_gif_has_a_frame_for_each_row(self):
        run = century.write_run(self.path("run.h5"), cells=century.graded(), shape=(10, 20), step=1.0)
        onset = century.EVENTS[-1][0]
        said = self.plot("plot_run", run, "--film", self.path("film.gif"), "--window", f"{onset - 5}y", f"{onset + 5}y",
                         "--fps", "5")
        rows = np.abs(century.stored_times(1.0) / YEAR - onset) <= 5
        self.assertEqual(said, f"Film: {self.path('film.gif')}, {rows.sum()} of {rows.sum()} rows of /fields\n")
        with Image.open(self.path("film.gif")) as film:
            # PIL joins equal frames; each of these has another time in its title
            self.assertEqual(film.n_frames, rows.sum())
            self.assertEqual(film.info["duration"], 200)
            first = np.asarray(film.convert("RGB"))
            film.seek(4)
            later = np.asarray(film.convert("RGB"))
        self.assertGreater((first != later).any(axis=2).mean(), 0.02)  # the rupture
        self.plot("plot_run", run, "--film", self.path("few.gif"), "--frames", "3", "--field", "slip")
        with Image.open(self.path("few.gif")) as film:
            self.assertEqual(film.n_frames, 3)

    def test_paces(self):
        """Frames at equal steps of time are of the rows nearest to them; at equal steps of the rate's logarithm those
        of the five events, in which it goes up and down most, while quiet years have few."""
        run = Run(century.write_run(self.path("run.h5"), shape=(4, 8)))
        times = run.field("slip")[0]
        rows = film.paced(run, times, "rows", 50)
        self.assertLessEqual(abs(np.diff(rows) - (len(times) - 1) / 49).max(), 1)
        rows = film.paced(run, times, "time", 50)
        wanted = np.linspace(times[0], times[-1], 50)
        self.assertEqual(len(rows), 50)
        np.testing.assert_array_equal(rows, [np.argmin(abs(times - time)) for time in wanted])
        rows = film.paced(run, times, "rate", 50)
        self.assertEqual((rows[0], rows[-1]), (0, len(times) - 1))
        rate = np.log(np.append(run.series["max_slip_rate"][0], run.series["max_slip_rate"]))
        way = np.append(0, np.cumsum(abs(np.diff(rate))))
        # each frame goes on by a step of the way, or by that of one row
        most = np.maximum(way[-1] / 49, abs(np.diff(rate)).max())
        self.assertLess(np.diff(way[rows]).max(), 1.5 * most)
        inside = [((times[rows] >= event[0] * YEAR) & (times[rows] <= event[0] * YEAR + 20)).sum()
                  for event in century.EVENTS]
        self.assertGreater(min(inside), 1)
        self.assertGreater(sum(inside), 0.7 * len(rows))
        for pace in film.PACES:
            said = self.plot("plot_run", run.path, "--film", self.path("film.gif"), "--pace", pace, "--frames", "12")
            self.assertRegex(said, rf"^Film: .*film.gif, \d+ of {len(times)} rows of /fields\n$")
        self.refused("plot_run", "--pace is not for --kind overview", run.path, "--pace", "rate", code=2)

    def titles(self, run, *arguments):
        """Of the frames of a film, as they are drawn."""
        found = []
        with mock.patch.object(film.Gif, "grab_frame",
                               lambda self: found.append(self.fig.subfigs[0]._suptitle.get_text())), \
                mock.patch.object(film.Gif, "finish",
                                  lambda self: None), mock.patch.object(film.Stage, "draw", lambda self: None):
            self.plot("plot_run", run, "--film", self.path("film.gif"), *arguments)
        return found

    def test_titles_tell_frames_apart(self):
        """Each frame of a window has a title of its own, which names what its time counts from: read back they are the
        times of the rows, to half of their last digits. Windows are of a month about an event and a creep before it, of
        years with an event, of the event, and all of the run."""
        run = century.write_run(self.path("run.h5"), shape=(4, 8))
        onset = century.EVENTS[-1][0]
        with h5py.File(run, "r+") as file:  # a month before, an hour before, and slow ends
            for group, every in (("fields", ("slip", "slip_rate", "traction")),
                                 ("series", [name for name in file["series"] if name != "time"])):
                times = file[f"{group}/time"][...]
                more = onset * YEAR + np.array([-30 * 86400, -36 * 3600, -3600, -5, 30, 90, 600])
                order = np.argsort(np.append(times, more))
                for name in ("time", *every):
                    data = file[f"{group}/{name}"]
                    values, attributes = data[...], dict(data.attrs)
                    extra = more if name == "time" else np.repeat(values[:1] * 0 + (2e-3 if "rate" in name else 0),
                                                                  len(more), axis=0)
                    del file[f"{group}/{name}"]
                    file[f"{group}/{name}"] = np.append(values, extra, axis=0)[order]
                    file[f"{group}/{name}"].attrs.update(attributes)
            for name in list(file["steps"]):
                del file[f"steps/{name}"]
                century.put(file, f"steps/{name}", np.zeros(0), "s")
        stored = Run(run).field("slip")[0]
        for low, high in ((onset - 0.1, onset + 0.01), (onset - 4, onset + 4), (onset, onset + 1e-6), (0, 110)):
            said = self.titles(run, "--window", f"{low}y", f"{high}y")
            times = stored[(stored >= low * YEAR) & (stored <= high * YEAR)]
            self.assertEqual((len(said), len(set(said))), (len(times), len(times)), said)
            self.assertTrue(low == 0 or all("years" in title for title in said), said)
            for title, time in zip(said, times):
                total = error = 0.0
                for sign, number, unit in re.findall(r"(^|[+−] )([0-9.]+) (\w+)", title):
                    size = SECONDS[next(key for key, name in NAMES.items() if name == unit)]
                    total += (-1 if sign.startswith("−") else 1) * float(number) * size
                    # origins have three digits or more
                    error += 0.5 * 10.0 ** -max(3 * (unit == "years" and title.count(" ") > 1),
                                                len(number.partition(".")[2])) * size
                self.assertAlmostEqual(total, time, delta=1.01 * error, msg=title)

    @unittest.skipUnless(shutil.which("ffmpeg"), "no ffmpeg")
    def test_mp4(self):
        run = century.write_run(self.path("run.h5"), shape=(5, 9), step=2.0)
        self.plot("plot_run", run, "--film", self.path("film.mp4"), "--frames", "6")
        with open(self.path("film.mp4"), "rb") as file:
            self.assertEqual(file.read(12)[4:8], b"ftyp")
        seen = subprocess.run(["ffmpeg", "-i", self.path("film.mp4"), "-f", "framemd5", "-"], capture_output=True,
                              text=True).stdout
        self.assertEqual(sum(not line.startswith("#") for line in seen.splitlines()), 6)

    def test_mp4_without_ffmpeg(self):
        run = century.write_run(self.path("run.h5"), shape=(5, 9), step=2.0)
        done = self.script("plot-run", run, "--film", self.path("film.mp4"),
                           env=dict(os.environ, PATH=self.folder.name))
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"^slipstep plot-run: --film is .*film.mp4, but there is no program ffmpeg "
                         r".*\.gif needs none\n$")


if __name__ == "__main__":
    unittest.main()
