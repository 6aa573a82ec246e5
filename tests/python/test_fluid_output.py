#!/usr/bin/env python3
"""What a run with pore fluid in its fault writes: volumes and wells in /series, pressure, permeability and flux in
/fields, and the columns of the catalogue, against sums over the cells and the file of the wells; on two ranks, and
after a restart."""
import os
import subprocess
import unittest

from scripts import FAULT, ScriptTest

import h5py
import numpy as np

from slipstep.modules import ENVIRONMENT

# a fault near failure, which the pressure of two wells makes slip
RUN = ("-fault_nx 8 -fault_nz 6 -fault_length_x 2400 -fault_length_z 1800 -fault_depth_top 2000 -fault_inertia no "
       "-fault_viscosity radiation -fault_normal_stress 40e6 -fault_normal_stress_gradient 0 -fault_friction_slip "
       "0.004 -fault_friction_law linear_slip_weakening -fault_initial traction -fault_initial_traction 23.9e6 "
       "-fault_permeability 1e-13 -fault_permeability_ratio 0.5 -fault_leakoff 1e-16 -fault_fluid_border open "
       "-fault_wells wells.csv -fault_output_fields slip,pore_pressure,permeability,fluid_flux -ts_max_time 20d "
       "-fault_output run.h5 -fault_catalogue events.h5 -fault_output_overwrite -fault_progress no")
WELLS = "well,x,z,days,m3/day\nA,1150,2950,0,30\nB,450,2450,2,20\nA,1150,2950,6,-10\nB,450,2450,12,0\n"
STORAGE = 0.1 * 1e-9 * 1 * 300 * 300  # of a cell: porosity, compressibility, aperture and area
NAMES = ("injected_volume", "stored_volume", "leaked_volume", "border_volume", "well_pressure", "well_rate")


class FluidOutput(ScriptTest):
    def fault(self, *more, ranks=1, code=0):
        self.put("wells.csv", WELLS)
        start = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
        done = subprocess.run([*start, FAULT, *RUN.split(), *more], cwd=self.folder.name, encoding="utf-8",
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
                              env={**ENVIRONMENT, **os.environ})
        self.assertEqual(done.returncode, code, done.stdout)

    def series(self, name="run.h5"):
        with h5py.File(self.path(name)) as file:
            return {key: file["series"][key][...] for key in ("time", *NAMES)}

    def test_volumes_wells_and_fields(self):
        self.fault()
        run = self.series()
        with h5py.File(self.path("run.h5")) as file:
            times, pressure, k, flux = (file[f"fields/{name}"][...]
                                        for name in ("time", "pore_pressure", "permeability", "fluid_flux"))
            self.assertEqual(file["series/well_rate"].attrs["wells"].decode(), "A;B")
            self.assertEqual(file["parameters"].attrs["fluid_border"].decode(), "open")
            self.assertEqual(flux.shape, (len(times), 6, 8, 2))
        day, t = 86400.0, run["time"]
        rate = np.column_stack([np.select([t < 6 * day * (1 - 1e-12)], [30.0], -10.0),
                                np.select([t < 2 * day * (1 - 1e-12), t < 12 * day * (1 - 1e-12)], [0.0, 20.0], 0.0)])
        np.testing.assert_allclose(run["well_rate"], rate / day, rtol=1e-14)
        exact = 30 * np.minimum(t, 6 * day) - 10 * np.maximum(t - 6 * day, 0) + 20 * np.clip(t - 2 * day, 0, 10 * day)
        scale = run["injected_volume"].max()
        # sums of rates over steps that end at their changes, to rounding of some thousand of them
        np.testing.assert_allclose(run["injected_volume"], exact / day, atol=1e-12 * scale)
        np.testing.assert_allclose(run["stored_volume"] + run["leaked_volume"] + run["border_volume"],
                                   run["injected_volume"], atol=1e-10 * scale)
        for name in ("stored_volume", "leaked_volume", "border_volume"):
            self.assertGreater(run[name].max(), 1e-3 * scale)
        for time, row in zip(times, pressure):
            at = np.flatnonzero(t == time)[0]
            self.assertAlmostEqual(row.sum() * STORAGE, run["stored_volume"][at], delta=1e-12 * scale)
        np.testing.assert_allclose(k, 1e-13, rtol=1e-14)
        # the pressure in an injecting well is above that of its cell
        at = [np.flatnonzero(t == time)[0] for time in times]
        self.assertTrue((run["well_pressure"][at, 0] > pressure[:, 3, 3])[(times < 6 * day) & (times > 0)].all())
        # flux leaves the well: along strike to both sides, and half as much per slope of pressure down dip
        early = np.flatnonzero((times > 0.5 * day) & (times < 2 * day))[-1]
        self.assertGreater(flux[early, 3, 5, 0], 0)
        self.assertLess(flux[early, 3, 1, 0], 0)
        self.assertGreater(flux[early, 5, 3, 1], 0)
        self.assertLess(flux[early, 1, 3, 1], 0)
        with h5py.File(self.path("events.h5")) as file:
            event = {key: file[key][...] for key in ("onset", "x", "z", "cell", "well_distance", "pore_pressure")}
        self.assertGreater(len(event["onset"]), 0)
        near = np.minimum(np.hypot(event["x"] - 1150, event["z"] - 2950), np.hypot(event["x"] - 450, event["z"] - 2450))
        np.testing.assert_allclose(event["well_distance"], near, rtol=1e-14)
        for onset, cell, p in zip(event["onset"], event["cell"], event["pore_pressure"]):
            before, after = np.searchsorted(times, onset) + np.array([-1, 0])
            around = pressure.reshape(len(times), -1)[[before, after], int(cell)]
            self.assertTrue(around.min() * (1 - 1e-3) <= p <= around.max() * (1 + 1e-3), (around, p))

    def test_ranks_and_restart(self):
        self.fault()
        whole = self.series()
        os.rename(self.path("events.h5"), self.path("whole_events.h5"))
        os.rename(self.path("run.h5"), self.path("whole.h5"))
        self.fault(ranks=2)
        both = self.series()
        np.testing.assert_allclose(both["time"][-1], whole["time"][-1])
        for name in NAMES[:4]:
            self.assertAlmostEqual(both[name][-1], whole[name][-1], delta=1e-6 * whole["injected_volume"].max())
        steps = len(whole["time"]) // 2
        self.fault("-ts_max_steps", str(steps), "-fault_checkpoint", "state", code=3)
        self.fault("-fault_restart", "state")
        again = self.series()
        for name, value in whole.items():
            self.assertEqual(again[name].tobytes(), value.tobytes(), name)
        with h5py.File(self.path("run.h5")) as file, h5py.File(self.path("whole.h5")) as other:
            for name in ("pore_pressure", "permeability", "fluid_flux"):
                self.assertEqual(file[f"fields/{name}"][...].tobytes(), other[f"fields/{name}"][...].tobytes(), name)
        with h5py.File(self.path("events.h5")) as file, h5py.File(self.path("whole_events.h5")) as other:
            for name in ("onset", "well_distance", "pore_pressure"):
                self.assertEqual(file[name][...].tobytes(), other[name][...].tobytes(), name)


if __name__ == "__main__":
    unittest.main()
