#!/usr/bin/env python3
"""The default tolerance of the hierarchical stiffness: what it adds to a rupture, and where the run tells it."""

import os
import re
import unittest

from scripts import SOURCE, FaultTest
import h5py
import numpy as np

ACCURACY = 1e-2
ENERGIES = "elastic_energy", "dissipated_energy", "radiated_energy"
SMALL = ("-fault_nx", 14, "-fault_nz", 14, "-fault_operator", "hmat", "-ts_adapt_type", "heuristic", "-ts_max_time", 12,
         "-fault_progress", "no")


class ToleranceTest(FaultTest):
    def rupture(self, name, *options):
        """The event of a rupture that jumps from a fault to another, with normal stress that follows slip."""
        text = self.fault("-options_file", os.path.join(SOURCE, "examples", "step_over.opts"), "-fault_mesh",
                          "jump_mesh.h5", "-fault_parameters", "jump_fields.h5", "-fault_normal_coupling", "yes",
                          "-fault_event_rate", "1e-2", "-fault_catalogue", f"{name}.h5", "-fault_catalogue_maps",
                          "-fault_view", "-fault_progress", "no", *options)
        with h5py.File(self.path(f"{name}.h5")) as file:
            self.assertEqual(len(file["onset"]), 1)
            return text, {key: file[key][0] for key in ("maps/slip", "maps/rupture_time", "moment", *ENERGIES)}

    def errors(self, got, exact):
        """Of slip, of when cells break, of the moment and of energies, relative"""
        times = got["maps/rupture_time"], exact["maps/rupture_time"]
        broke = ~np.isnan(times[1])
        np.testing.assert_array_equal(~np.isnan(times[0]), broke)
        return {"slip": np.abs(got["maps/slip"] - exact["maps/slip"]).max() / exact["maps/slip"].max(),
                "times": np.abs(times[0] - times[1])[broke].mean() / times[1][broke].max(),
                "moment": abs(got["moment"] / exact["moment"] - 1),
                "energies": max(abs(got[key] - exact[key]) for key in ENERGIES) / abs(exact["dissipated_energy"])}

    def test_adds_less_than_a_tenth(self):
        """The default tolerance against dense storage, on 576 cells, with blocks of low rank. Finer steps, the same in
        both, as differences of those at 1e-2 are 1e-3 by themselves. A tolerance of 0.5 adds 1e-2: the test sees it."""
        self.run_example("step_over.py", "make", "jump", "--cells", 24, 12, "--distance", 1000)
        exact = self.rupture("dense", "-fault_operator", "dense", "-fault_accuracy", 1e-3)[1]
        for tolerance, adds in ((self.default(), False), (0.5, True)):
            text, got = self.rupture("hmat", "-fault_operator", "hmat", "-fault_accuracy", 1e-3,
                                     "-fault_hmat_tolerance", tolerance)
            low = re.search(r"hierarchical stiffness: 576 cells, .* \d+ blocks of which (\d+)", text)
            self.assertGreater(int(low[1]), 10)
            found = self.errors(got, exact)
            self.assertEqual(max(found.values()) > 0.1 * ACCURACY, adds, found)

    def default(self):
        """The tolerance at the default accuracy, by the view"""
        text = self.fault(*SMALL[:-4], "-ts_max_time", 1e-3, "-fault_view", "-fault_progress", "no")
        found = re.search(rf"hmat_tolerance: (\S+) \(from -fault_accuracy {ACCURACY:g}\)", text)
        self.assertIn(f"relative tolerance {found[1]},", text)
        return found[1]

    def test_is_told(self):
        for options, tolerance, why in (((), 1e-4, "from -fault_accuracy 0.01"),
                                        (("-ts_rtol", 1e-4), 1e-6, "from -ts_rtol 0.0001"),
                                        (("-fault_hmat_tolerance", 1e-3), 1e-3, "as asked")):
            text = self.fault(*SMALL[:-2], *options, "-fault_output", "run.h5", "-fault_output_overwrite")
            self.assertRegex(text, rf"stiffness: +hierarchical, -fault_hmat_tolerance {tolerance:g}, {why}\n")
            self.assertRegex(text, rf"tolerance of stiffness: +{tolerance:g} {why}\n")
            self.assertAlmostEqual(self.get("run.h5", "result@hmat_tolerance") / tolerance, 1, 12)
        text = self.fault(*SMALL[:-2], "-fault_operator", "dense", "-fault_output", "run.h5",
                          "-fault_output_overwrite")
        self.assertNotIn("tolerance of stiffness", text)

    def test_restart(self):
        """Goes on to the bit at the same accuracy. Another one brings another stiffness, and a line that says so; where
        the stiffness is not hierarchical the line is of the accuracy alone. A tolerance that is asked for is refused
        unless it is that of the run."""
        series = [f"series/{name}" for name in ("time", "mean_slip", "max_slip_rate")]
        for operator in ("hmat", "dense"):
            this = *SMALL, "-fault_operator", operator, "-fault_output_overwrite"
            self.fault(*this, "-fault_output", "whole.h5")
            self.fault(*this, "-fault_checkpoint", "state", "-ts_max_steps", 12, "-fault_output", "run.h5", code=3)
            parts = {name: self.content(name, None) for name in os.listdir(self.folder.name) if name != "whole.h5"}

            def go_on(*options, code=0):
                for name, content in parts.items():
                    self.put(name, content)
                return self.fault(*this, "-fault_restart", "state", "-fault_output", "run.h5", *options, code=code)

            self.assertNotIn("was", go_on())
            for one, other in zip(self.get("run.h5", *series), self.get("whole.h5", *series)):
                np.testing.assert_array_equal(one, other)
            told = go_on("-fault_accuracy", 1e-3)
            self.assertIn("accuracy is 0.001, was 0.01", told)
            self.assertEqual("hmat_tolerance is 1e-05, was 0.0001" in told, operator == "hmat")
            if operator == "hmat":
                self.assertNotIn("was", go_on("-fault_hmat_tolerance", 1e-4))
                self.assertIn("checkpoint of another run: hmat_tolerance is 1e-06, was 0.0001",
                              go_on("-fault_hmat_tolerance", 1e-6, code=1))


if __name__ == "__main__":
    unittest.main()
