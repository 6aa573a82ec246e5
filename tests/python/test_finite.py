"""Numbers that are none are not written: output, catalogue and checkpoint of explicit runs under controllers and first
steps that let them become unstable are finite, however the run ends, and the checkpoint is one to go on from."""

import os
import subprocess
import unittest

from scripts import FAULT, ScriptTest

import h5py
import numpy as np

# rate and state from its unstable steady state, with a first step of three years
RUN = ("-fault_friction_law", "rate_and_state", "-fault_nx", "6", "-fault_nz", "3", "-fault_length_x", "24e3",
       "-fault_length_z", "12e3", "-fault_kernel", "full_space", "-fault_normal_stress", "50e6",
       "-fault_normal_stress_gradient", "0", "-fault_loading_rate", "1e-9", "-fault_friction_a", "0.01",
       "-fault_friction_b", "0.015", "-fault_friction_slip", "0.02", "-fault_initial_rate", "1e-9", "-fault_progress",
       "no", "-ts_max_time", "1e10")
FILES = {"output": "-fault_output", "catalogue": "-fault_catalogue", "state": "-fault_checkpoint"}

# NaN where an event has none; a row of the catalogue in a checkpoint has the last two
UNKNOWN = "rupture_time", "rupture_speed", "radiated_efficiency", "catalogue/row"


class Finite(ScriptTest):
    def fault(self, *options):
        done = subprocess.run([FAULT, *RUN, *options], cwd=self.folder.name, capture_output=True, text=True,
                              timeout=120)
        # a run may fail here, with an error, but not crash
        self.assertIn(done.returncode, (0, 1, 3), done.stderr)
        return done

    def numbers(self, name):
        """How many a file has, all of which are finite."""
        path = self.path(name)
        if not os.path.exists(path):
            path += ".part"
        if not os.path.exists(path):
            return 0  # the run failed before there was anything to keep
        count, bad = 0, []

        def look(key, data):
            nonlocal count
            values = [data.attrs[k] for k in data.attrs]
            if isinstance(data, h5py.Dataset) and not any(name in key for name in UNKNOWN):
                values.append(data[...])
            for value in map(np.asarray, values):
                if value.dtype.kind == "f":
                    count += value.size
                    if not np.isfinite(value).all():
                        bad.append(key)

        with h5py.File(path) as file:
            file.visititems(look)
        self.assertEqual(bad, [], name)
        return count

    def test_controllers(self):
        for integrator in ("rk", "adams"):
            for controller in ("none", "basic", "dsp", "pi"):
                with self.subTest((integrator, controller)):
                    names = {kind: f"{integrator}_{controller}_{kind}" for kind in FILES}
                    self.fault("-ts_type", integrator, "-ts_adapt_type", controller, "-ts_dt", "1e8", "-ts_max_steps",
                               "150", *(word for kind, option in FILES.items() for word in (option, names[kind])))
                    self.assertGreater(self.numbers(names["output"]), 100)
                    self.numbers(names["catalogue"])
                    if not self.numbers(names["state"]):
                        continue
                    self.fault("-ts_type", integrator, "-ts_adapt_type", "basic", "-fault_restart", names["state"],
                               "-ts_max_steps", "170", "-fault_output", "more.h5", "-fault_output_overwrite")
                    self.numbers("more.h5")


if __name__ == "__main__":
    unittest.main()
