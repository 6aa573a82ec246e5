"""The examples of one command whose pore fluid diffuses in the fault, small: their pictures, and what they print
against their files."""

import os
import re
import subprocess
import sys
import unittest

from scripts import SOURCE, PictureTest

import h5py
import numpy as np

sys.path.insert(0, os.path.join(SOURCE, "examples"))
import doublet
import shut_in
import valve
from slipstep.times import YEAR

try:
    from scipy.special import exp1
except ImportError:
    exp1 = None


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

    def test_doublet(self):
        """All that the producer takes, and what the branch's pores gain, has come through the fork: the flow into the
        branch, summed by trapezoids over half days, within 1 %; at each time what arrives is what goes on, within 1 %
        of the rate, as the flow of cells is known half a cell away. Cells of the three sides of the fork have the same
        pressure there, and the main fault holds what the branch has lost, to the balance of fluid."""
        said = self.example("doublet.sh", "-ts_max_time", "20d", "-fault_output_time_interval", "12h",
                            "-ts_adapt_dt_max", "12h", "-fault_progress", "no", CELL="200")
        self.look(self.path("doublet.png"))
        run = doublet.Case(self.path("doublet_doublet.h5"))
        before, after, branch = run.junction()
        rate = doublet.RATE / doublet.DAY
        np.testing.assert_allclose(run.stored(0) + run.stored(1), 0, atol=1e-9 * rate * run.time[-1])
        through = np.concatenate([[0], np.cumsum((branch[1:] + branch[:-1]) / 2 * np.diff(run.time))])
        np.testing.assert_allclose(through, run.stored(1) + rate * run.time, atol=0.01 * rate * run.time[-1])
        late = run.time > 2 * doublet.DAY
        self.assertLess(np.abs(before - after - branch)[late].max(), 0.01 * rate)
        self.assertGreater(branch[-1], 0.5 * rate)
        self.assertLess(after[late].max(), 0)  # the dead end drains
        self.assertLess(float(re.search(r"balance to ([\d.e+-]+) of the rate", said)[1]), 0.01)

    @unittest.skipUnless(exp1, "no SciPy")
    def test_shut_in(self):
        """The pressure of the triangles before and after the shut-in, on average over rings of two cells around the
        well, is that of a line source in a plane, as long as the border is far: within 1 % of the largest there; one
        triangle is off by up to some 8 %, as its pressure is a mean over it and 300 m change it by a third. Waves of
        120 m in 8 km lengthen ways by less than 1 %. Events begin in the weak patches."""
        said = self.example("shut_in.sh", "-fault_progress", "no", CELL="400", DAYS="36")
        for picture in ("injection", "pressure", "slip"):
            self.look(self.path(f"shut_in_{picture}.png"))
        self.assertGreater(os.path.getsize(self.path("shut_in.gif")), 10000)
        self.assertIn("Injected volume: 1.95e+04 m^3", said)
        self.assertRegex(said, r"D of the front: (0\.\d+ m\^2/s, standard error|too few)")
        with h5py.File(self.path("shut_in.h5")) as file:
            time, pressure = file["fields/time"][...], file["fields/pore_pressure"][...]
            places = np.column_stack([file["mesh"][axis] for axis in "xyz"])
        with open(self.path("shut_in_wells.csv")) as file:
            well = np.array([float(word) for word in file.readlines()[1].split(",")[1:4]])
        r2, day = ((places - well) ** 2).sum(axis=1), 86400.0
        strength = shut_in.RATE / day * 1e-3 / (4 * np.pi * 3e-14 * 10)
        for at in (np.searchsorted(time, 25 * day), len(time) - 1):
            exact = strength * exp1(r2 / (1.2 * time[at]))
            if time[at] > 30 * day:
                exact -= strength * exp1(r2 / (1.2 * (time[at] - 30 * day)))
            for ring in (r2 > 800 ** 2) & (r2 < 1600 ** 2), (r2 > 1600 ** 2) & (r2 < 2400 ** 2):
                self.assertLess(abs((pressure[at] - exact)[ring].mean()), 0.01 * exact[ring].max())
                self.assertLess(np.abs(pressure[at] - exact)[ring].max(), 0.12 * exact[ring].max())
        with h5py.File(self.path("shut_in_events.h5")) as file, h5py.File(self.path("shut_in_fields.h5")) as fields:
            self.assertGreater(len(file["onset"]), 0)
            self.assertTrue((fields["friction_drop"][...][file["cell"][...].astype(int)] > 0).all())


if __name__ == "__main__":
    unittest.main()
