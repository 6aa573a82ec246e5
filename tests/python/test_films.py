"""Films of a run by plot_run.py --film, on a synthetic century."""

import os
import shutil
import subprocess
import sys
import unittest

from scripts import OUTPUT, PictureTest

import century
import numpy as np
from PIL import Image

from slipstep_time import YEAR


class Films(PictureTest):
    def test_gif_has_a_frame_for_each_row(self):
        run = century.write_run(self.path("run.h5"), cells=century.graded(), shape=(10, 20), step=1.0)
        onset = century.EVENTS[-1][0]
        said = self.plot("plot_run", run, "--film", self.path("film.gif"), "--window", f"{onset - 5}y", f"{onset + 5}y", "--fps", "5")
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

    @unittest.skipUnless(shutil.which("ffmpeg"), "no ffmpeg")
    def test_mp4(self):
        run = century.write_run(self.path("run.h5"), shape=(5, 9), step=2.0)
        self.plot("plot_run", run, "--film", self.path("film.mp4"), "--frames", "6")
        with open(self.path("film.mp4"), "rb") as file:
            self.assertEqual(file.read(12)[4:8], b"ftyp")
        seen = subprocess.run(["ffmpeg", "-i", self.path("film.mp4"), "-f", "framemd5", "-"], capture_output=True, text=True).stdout
        self.assertEqual(sum(not line.startswith("#") for line in seen.splitlines()), 6)

    def test_mp4_without_ffmpeg(self):
        run = century.write_run(self.path("run.h5"), shape=(5, 9), step=2.0)
        done = subprocess.run([sys.executable, os.path.join(OUTPUT, "plot_run.py"), run, "--film", self.path("film.mp4")], capture_output=True,
                              text=True, env=dict(os.environ, PATH=self.folder.name))
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"^plot_run.py: --film is .*film.mp4, but there is no program ffmpeg .*\.gif needs none\n$")


if __name__ == "__main__":
    unittest.main()
