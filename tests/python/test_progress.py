#!/usr/bin/env python3
"""-fault_progress: lines on a terminal while a run goes, none within a minute elsewhere, none with "no"; below mpirun
the terminal that counts is mpirun's own."""
import os
import pty
import re
import select
import subprocess
import tempfile
import time
import unittest
from concurrent.futures import ThreadPoolExecutor

from scripts import FAULT, ScriptTest

RANKS = ["mpirun", "--oversubscribe", "-n", "2"]
# Steps without end, each in well under a millisecond
ENDLESS = ["-fault_nx", "3", "-fault_nz", "3", "-fault_stiffness_average", "whole", "-ts_adapt_type", "none", "-ts_dt",
           "1e-6", "-ts_max_time", "600"]
LINE = re.compile(r"time ([0-9.e-]+) s of 10 min \([0-9.]+ %\), largest slip rate ([0-9.e-]+) m/s, ([0-9]+) steps, 0 "
                  r"rejected, [0-9.e+]+ (min|h|days|years) left\r?\n")
SETUP = re.compile(r"set-up of 9 cells(?:, after| took) ([0-9.]+) s")


def printed(command, terminal, lines=None, seconds=None):
    """What a command prints on a terminal or into a pipe until it has so many lines of progress, or for so long; and
    for how long."""
    ours, theirs = pty.openpty() if terminal else os.pipe()
    begin = time.monotonic()
    room = tempfile.TemporaryDirectory()  # of its own: two mpirun that begin at once may both make their folder in one
    run = subprocess.Popen(command, stdout=theirs, stderr=theirs, env={**os.environ, "TMPDIR": room.name})
    os.close(theirs)
    text = b""
    while time.monotonic() < begin + seconds if seconds else len(LINE.findall(text.decode())) < lines:
        if select.select([ours], [], [], 0.1)[0]:
            try:
                more = os.read(ours, 65536)
            except OSError:  # a terminal whose program has ended
                break
            if not more:
                break
            text += more
    run.terminate()
    run.wait()
    os.close(ours)
    room.cleanup()
    return text.decode(), time.monotonic() - begin


def has_terminals():
    try:
        for end in pty.openpty():
            os.close(end)
    except OSError as error:
        print(f"test_progress: no pseudo-terminal can be had here ({error}): tests of terminals are skipped")
        return False
    return True


TERMINALS = has_terminals()


RUNS = {  # command, terminal, and when it ends
    "terminal": ([FAULT] + ENDLESS, True, {"lines": 2}),
    "silence": ([FAULT] + ENDLESS, False, {"seconds": 3}),
    "silence of ranks": (RANKS + [FAULT] + ENDLESS, False, {"seconds": 3}),
    "none wanted": ([FAULT] + ENDLESS + ["-fault_progress", "no"], True, {"seconds": 2.5}),
    "ranks": (RANKS + [FAULT] + ENDLESS, True, {"lines": 1}),
}


class Progress(ScriptTest):
    @classmethod
    def setUpClass(cls):
        """All runs at once, as they mostly wait."""
        with ThreadPoolExecutor(len(RUNS)) as pool:
            jobs = {name: pool.submit(printed, command, terminal, **end)
                    for name, (command, terminal, end) in RUNS.items() if TERMINALS or not terminal}
        cls.printed = {name: job.result() for name, job in jobs.items()}

    @unittest.skipUnless(TERMINALS, "no pseudo-terminal")
    def test_terminal(self):
        text, _ = self.printed["terminal"]
        lines = LINE.findall(text)
        self.assertGreaterEqual(len(lines), 2, text)  # after 2 s and 7 s
        self.assertGreater(float(lines[1][0]), float(lines[0][0]))
        for at, rate, steps, _ in lines:
            self.assertAlmostEqual(float(at), 1e-6 * int(steps), delta=6e-4 * float(at))  # 4 digits of each are printed
            self.assertGreater(float(rate), 0)
        self.assertIn("\r\x1b[Kset-up of 9 cells: stiffness K", text)  # overwritten, as it is short
        self.long_setups(text)

    def long_setups(self, text):
        """A set-up leaves lines where it takes a second, as it does on a busy machine, and says so."""
        self.assertEqual([s for s in SETUP.findall(text) if float(s) < 1], [])

    def test_silence(self):
        """Into a pipe no line comes before a minute is over, also of ranks whose terminals are mpirun's."""
        for name in ("silence", "silence of ranks"):
            text, seconds = self.printed[name]
            self.assertLessEqual(text.count("largest slip rate"), seconds // 60, text)
            self.long_setups(text)

    @unittest.skipUnless(TERMINALS, "no pseudo-terminal")
    def test_none_wanted(self):
        self.assertEqual(self.printed["none wanted"][0], "")

    @unittest.skipUnless(TERMINALS, "no pseudo-terminal")
    def test_ranks(self):
        text, _ = self.printed["ranks"]
        self.assertGreaterEqual(len(LINE.findall(text)), 1, text)

    def test_value(self):
        done = subprocess.run([FAULT, "-fault_progress", "perhaps"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("-fault_progress", done.stderr)


if __name__ == "__main__":
    unittest.main()
