"""A mesh of triangles on several ranks, of which one is killed: the run goes on from its checkpoint on other numbers of
ranks and ends like one that nothing happened to, and no shared memory is left."""

import glob
import os
import signal
import subprocess
import time
import unittest

from scripts import FAULT, FaultTest
import numpy as np

from meshfiles import plane, write_hdf5

# 900 triangles that creep, so that K and Kn are hierarchical and rounding does not grow, by steps that are many
SLOW = ("-fault_friction_law", "rate_and_state", "-fault_normal_stress", "50e6", "-fault_normal_stress_gradient", "0",
        "-fault_rake", "90", "-fault_loading_rate", "1e-9", "-fault_friction_slip", "0.05", "-fault_thickness", "4000",
        "-fault_friction_a", "0.02", "-fault_friction_b", "0.015", "-fault_hmat_tolerance", "1e-8",
        "-fault_output_time_interval", "1e8", "-ts_adapt_dt_max", "2e6", "-ts_max_time", "2e9")


class Killed(FaultTest):
    def run_of(self, ranks, *options):
        return self.fault("-fault_mesh", "mesh.h5", *SLOW, *options, ranks=ranks)

    def test_goes_on_on_other_numbers(self):
        write_hdf5(self.path("mesh.h5"), *plane((30, 15), (500.0, 400.0), 20, 60, (0, 0, 100)))
        self.run_of(2, "-fault_output", "whole.h5")
        before = set(glob.glob("/dev/shm/slipstep-*"))
        command = ["mpirun", "--oversubscribe", "-n", "2", FAULT, "-fault_mesh", "mesh.h5", *SLOW, "-fault_output",
                   "killed.h5", "-fault_checkpoint", "state.h5", "-fault_checkpoint_interval", "0.2"]
        with subprocess.Popen(command, cwd=self.folder.name, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL) as run:
            while not os.path.exists(self.path("state.h5")) and run.poll() is None:
                time.sleep(0.05)
            ranks = subprocess.run(["pgrep", "-P", str(run.pid)], capture_output=True, text=True).stdout.split()
            os.kill(int(ranks[-1]), signal.SIGKILL)
            self.assertNotEqual(run.wait(), 0)
        self.assertEqual(set(glob.glob("/dev/shm/slipstep-*")) - before, set())
        whole = self.get("whole.h5", "series/time", "series/mean_slip")
        for ranks in (1, 3):
            said = self.run_of(ranks, "-fault_output", f"on{ranks}.h5", "-fault_restart", "state.h5")
            time_, slip = self.get(f"on{ranks}.h5", "series/time", "series/mean_slip")
            self.assertEqual(time_[-1], whole[0][-1], said)
            np.testing.assert_allclose(slip[-1], whole[1][-1], rtol=1e-9)


if __name__ == "__main__":
    unittest.main()
