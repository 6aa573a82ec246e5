"""The examples of one command whose pore fluid diffuses in the fault, small: their pictures, and what they print against
their files."""

import os
import re
import subprocess
import sys
import unittest

from scripts import SOURCE, PictureTest

import h5py
import numpy as np

sys.path.insert(0, os.path.join(SOURCE, "examples"))
import valve
from slipstep.times import YEAR


class FluidExamplesTest(PictureTest):
    def example(self, name, *options, **more):
        done = subprocess.run([os.path.join(SOURCE, "examples", name), *options], capture_output=True, text=True,
                              env=dict(os.environ, SLIPSTEP_OUTPUT=self.folder.name, SLIPSTEP_PYTHON=sys.executable,
                                       **more))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_valve(self):
        """Two swarms in 20 years, of one burst each. Slip rises to the surface, whose cells are the last to be fast,
        and the fluid below the burst drains: a tenth of its pressure is left."""
        said = self.example("valve.sh", "-ts_max_time", "20.5y", "-ts_rtol", "1e-3", "-fault_progress", "no")
        self.look(self.path("valve.png"))
        self.assertIn("2 bursts of more than 0.0001 m/s in 20.5 years, in 2 swarms", said)
        with h5py.File(self.path("valve.h5")) as file:
            time, rate, pressure = (file["fields"][name][...].reshape(len(file["fields/time"]), -1)
                                    for name in ("time", "slip_rate", "pore_pressure"))
        found = re.findall(r"^ *([\d.]+) years: 1 burst, slip begins at ([\d.]+) km and reaches 0.2 km", said, re.M)
        self.assertEqual(len(found), 2)
        for begin, depth in found:
            near = np.abs(time[:, 0] / YEAR - float(begin)) < 0.2
            fast = (rate[near] > valve.FAST).argmax(axis=0)
            self.assertGreater(fast[0], fast[int(float(depth) * 1e3 / 500)])
        before = np.searchsorted(time[:, 0], (float(found[1][0]) - 0.3) * YEAR)
        self.assertLess(pressure[-1, -1], 0.1 * pressure[before, -1])

    def test_valve_without_bursts(self):
        said = self.example("valve.sh", "-ts_max_time", "0.5y", "-fault_progress", "no")
        self.look(self.path("valve.png"))
        self.assertIn("0 bursts", said)


if __name__ == "__main__":
    unittest.main()
