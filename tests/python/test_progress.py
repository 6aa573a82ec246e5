#!/usr/bin/env python3
"""-fault_progress: lines on a terminal while a run goes, none within a minute elsewhere, none with "no"; below mpirun the
terminal that counts is mpirun's own."""
import os
import pty
import re
import select
import subprocess
import time
import unittest

from scripts import ScriptTest

FAULT = os.path.join(os.environ["SLIPSTEP_BUILD"], "bin", "fault")
# Steps without end, each in well under a millisecond
ENDLESS = ["-fault_nx", "3", "-fault_nz", "3", "-ts_adapt_type", "none", "-ts_dt", "1e-6", "-ts_max_time", "600"]
LINE = re.compile(r"time ([0-9.e-]+) s of 10 min \([0-9.]+ %\), largest slip rate ([0-9.e-]+) m/s, ([0-9]+) steps, 0 rejected, [0-9.]+ (min|h|days) left\r?\n")


def printed(command, seconds, terminal, lines=100):
    """What a command prints in so many seconds or until it has so many lines of progress, on a terminal or into a pipe."""
    ours, theirs = pty.openpty() if terminal else os.pipe()
    run = subprocess.Popen(command, stdout=theirs, stderr=theirs)
    os.close(theirs)
    text, end = b"", time.monotonic() + seconds
    while time.monotonic() < end and len(LINE.findall(text.decode())) < lines:
        if select.select([ours], [], [], 0.1)[0]:
            try:
                text += os.read(ours, 65536)
            except OSError:
                break
    run.terminate()
    run.wait()
    os.close(ours)
    return text.decode()


class Progress(ScriptTest):
    def test_terminal(self):
        text = printed([FAULT] + ENDLESS, 60, True, 2)
        lines = LINE.findall(text)
        self.assertGreaterEqual(len(lines), 2, text)  # after 2 s and 7 s
        self.assertGreater(float(lines[1][0]), float(lines[0][0]))
        for at, rate, steps, _ in lines:
            self.assertAlmostEqual(float(at), 1e-6 * int(steps), delta=6e-4 * float(at))  # 4 digits of each are printed
            self.assertGreater(float(rate), 0)
        self.assertIn("\r\x1b[Kset-up of 9 cells: stiffness K", text)  # overwritten, as it is short
        self.assertNotIn("cells took", text)

    def test_silence(self):
        """Into a pipe nothing is printed before the summary of a short run, and nothing with "no" on a terminal."""
        self.assertEqual(re.findall("rate|set-up", printed([FAULT] + ENDLESS, 2.5, False)), [])
        self.assertEqual(printed([FAULT] + ENDLESS + ["-fault_progress", "no"], 2.5, True), "")
        self.assertNotIn("rate", printed(["mpirun", "--oversubscribe", "-n", "2", FAULT] + ENDLESS, 3, False))

    def test_ranks(self):
        text = printed(["mpirun", "--oversubscribe", "-n", "2", FAULT] + ENDLESS, 60, True, 1)
        self.assertGreaterEqual(len(LINE.findall(text)), 1, text)

    def test_value(self):
        done = subprocess.run([FAULT, "-fault_progress", "perhaps"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("-fault_progress", done.stderr)


if __name__ == "__main__":
    unittest.main()
