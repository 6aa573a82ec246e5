#!/usr/bin/env python3
"""When an entry of /fields is written (-fault_output_interval, _slip_interval, _time_interval, _rate_change), against
the rules applied here to a run that writes every step; how it is stored (-fault_output_precision,
-fault_output_compression); and the size that is printed."""
import os
import re
import unittest

from scripts import FaultTest

import h5py
import numpy as np

GRID = ["-fault_nx", "6", "-fault_nz", "5", "-fault_loading_rate", "1e-3", "-ts_max_time", "30"]
FLOOR = 1e-10 / (3000 * (2500 / 30e9) ** 0.5)  # the tolerance of slip rates [m/s], below which they do not count
LOADING = 1e-3  # [m/s]


def due(time, displacement, rate, steps=0, slip=np.inf, interval=np.inf, factor=np.inf):
    """Numbers of the steps with entries, by the rules; the last is always there. A number that rounding could turn is
    an error."""
    largest = np.maximum(np.abs(rate).max(axis=1), FLOOR)
    found = [0]
    for i in range(1, len(time)):
        last = found[-1]
        slipped = np.abs(displacement[i] - displacement[last] + LOADING * (time[i] - time[last])).max()
        assert abs(slipped / slip - 1) > 1e-9
        change = largest[i] / largest[last]
        if ((steps and i % steps == 0) or slipped >= slip or time[i] // interval > time[i - 1] // interval
            or not 1 / factor < change < factor):
            found.append(i)
    return found if found[-1] == len(time) - 1 else found + [len(time) - 1]


class When(FaultTest):
    def fault(self, *options, grid=GRID, **more):
        return super().fault(*grid, *options, **more)

    def fields(self, name):
        with h5py.File(self.path(name)) as file:
            n = len(file["fields/time"])
            return [file[f"fields/{key}"][...].reshape(n, -1) for key in ("time", "displacement", "slip_rate")]

    def expect(self, name, every, **rules):
        time, displacement, rate = every
        steps = due(time[:, 0], displacement, rate, **rules)
        self.assertGreater(len(steps), 4, rules)
        self.assertLess(len(steps), len(time), rules)
        found = self.fields(name)
        for mine, theirs in zip(found, every):
            np.testing.assert_array_equal(mine, theirs[steps], str(rules))

    def test_rules(self):
        self.fault("-fault_output", "every.h5")
        every = self.fields("every.h5")
        self.assertGreater(len(every[0]), 40)
        top = np.abs(every[1] - every[1][0]).max()
        cases = [(["-fault_output_interval", "7"], {"steps": 7}),
                 (["-fault_output_slip_interval", str(top / 8.1)], {"slip": top / 8.1}),
                 (["-fault_output_time_interval", "2.5"], {"interval": 2.5}),
                 (["-fault_output_rate_change", "2"], {"factor": 2.0}),
                 (["-fault_output_time_interval", "4", "-fault_output_interval", "9", "-fault_output_rate_change", "3"],
                  {"steps": 9, "interval": 4.0, "factor": 3.0}),
                 (["-fault_output_slip_interval", str(top / 5.3), "-fault_output_time_interval", "7"],
                  {"slip": top / 5.3, "interval": 7.0})]
        for k, (options, rules) in enumerate(cases):
            with self.subTest(options):
                self.fault("-fault_output", f"{k}.h5", *options)
                self.expect(f"{k}.h5", every, **rules)
                # stopped in between and continued: what it remembers is in the checkpoint
                self.fault("-fault_output", f"{k}b.h5", "-fault_checkpoint", f"{k}.state", "-ts_max_steps", "23",
                           *options, code=3)
                self.fault("-fault_output", f"{k}b.h5", "-fault_restart", f"{k}.state", *options)
                self.expect(f"{k}b.h5", every, **rules)
        # a rule that the run of before did not have counts from where this one goes on
        self.fault("-fault_output", "0b.h5", "-fault_restart", "0.state", "-fault_output_slip_interval", str(top / 8.1),
                   "-fault_output_rate_change", "2")

    def test_ranks_and_mesh(self):
        self.make_mesh("mesh", "parallel --cells 4 4 --offset 1000")
        mesh = ["-fault_mesh", "mesh", "-ts_max_time", "12"]
        rules = ["-fault_output_slip_interval", "0.02", "-fault_output_rate_change", "3"]
        times = []
        for ranks in (1, 2):
            self.fault("-fault_output", f"{ranks}.h5", *rules, ranks=ranks, grid=mesh)
            times.append(self.fields(f"{ranks}.h5")[0])
        self.assertGreater(len(times[0]), 8)
        np.testing.assert_allclose(times[0], times[1], rtol=1e-9)  # sums in another order differ by rounding
        # and on from a checkpoint of the other number of ranks, whose cells are numbered in another way
        for before, after in ((1, 2), (2, 1)):
            name = f"{before}{after}"
            self.fault("-fault_output", f"{name}.h5", "-fault_checkpoint", f"{name}.state", "-ts_max_steps", "30",
                       *rules, ranks=before, grid=mesh, code=3)
            self.fault("-fault_output", f"{name}.h5", "-fault_restart", f"{name}.state", *rules, ranks=after, grid=mesh)
            np.testing.assert_allclose(self.fields(f"{name}.h5")[0], times[0], rtol=1e-9)

    def test_errors(self):
        for option, value, message in (("rate_change", "1", "> 1"),
                                       ("rate_change", "-2", ">= 0"),
                                       ("slip_interval", "-1", ">= 0 m"),
                                       ("time_interval", "x", ">= 0 s"),
                                       ("compression", "10", ">= 0 and < 10"),
                                       ("precision", "half", "double, single")):
            text = self.fault(f"-fault_output_{option}", value, "-fault_output", "a.h5", code=1)
            self.assertIn(f"-fault_output_{option} is", text)
            self.assertIn(message, text)

    def test_default(self):
        """Without a rule every step has an entry, or as many as fit: a fifth of them at once, the others by time and
        slip, as here; the start and the end are among them, and a run in two parts has the same ones."""
        self.fault("-fault_output", "every.h5", "-fault_output_interval", "1")
        every = self.fields("every.h5")
        self.fault("-fault_output", "all.h5")
        for mine, theirs in zip(self.fields("all.h5"), every):
            np.testing.assert_array_equal(mine, theirs)
        with h5py.File(self.path("every.h5")) as file:  # what a fault from its instability slips by
            stress, drop, residual = (file[f"mesh/{name}"][...].mean()
                                      for name in ("normal_stress", "friction_drop", "friction_residual"))
            start = file["mesh/critical_displacement"][...].mean()
        expected = 30 * 1e-3 + start * drop / (drop + residual)
        time, slip = every[0][:, 0], (every[1] - every[1][0]).mean(axis=1) + 1e-3 * every[0][:, 0]
        progress = 0.5 * (time / 30 + np.minimum(abs(slip) / expected, 1))
        for most in (5, 20):
            found = [0]
            for i in range(1, len(time)):
                if len(found) + 2 <= max(2, 0.2 * most) or len(found) + 2 <= most * (0.2 + 0.8 * progress[i]):
                    found.append(i)
            found = found if found[-1] == len(time) - 1 else found + [len(time) - 1]
            self.assertLess(most // 2, len(found))
            self.assertLessEqual(len(found), most)
            size = ["-fault_output_size", str(968 * most + 100)]
            self.fault("-fault_output", "some.h5", *size)
            np.testing.assert_array_equal(self.fields("some.h5")[0], every[0][found])
        self.fault("-fault_output", "two.h5", "-fault_checkpoint", "state", "-ts_max_steps", "23", *size, code=3)
        self.fault("-fault_output", "two.h5", "-fault_restart", "state", *size)
        np.testing.assert_array_equal(self.fields("two.h5")[0], every[0][found])

    def test_storage(self):
        """Single precision is the double rounded; compression changes no value and takes less."""
        size = {}
        grid = ["-fault_nx", "20", "-fault_nz", "20", "-ts_max_time", "20"]
        for name, options in (("plain", []), ("single", ["-fault_output_precision", "single"]),
                              ("small", ["-fault_output_compression", "4"]),
                              ("smallest", ["-fault_output_precision", "single", "-fault_output_compression", "9"])):
            self.fault("-fault_output", f"{name}.h5", *options, grid=grid)
            size[name] = os.path.getsize(self.path(f"{name}.h5"))
            with h5py.File(self.path("plain.h5")) as plain, h5py.File(self.path(f"{name}.h5")) as file:
                for key in ("slip", "slip_rate", "displacement", "traction"):
                    data = file[f"fields/{key}"]
                    np.testing.assert_array_equal(data, plain[f"fields/{key}"][...].astype(data.dtype))
                    self.assertEqual(data.dtype.itemsize, 4 if "-fault_output_precision" in options else 8)
                    self.assertEqual(data.compression_opts, int(options[-1]) if "-fault_output_compression" in options
                                     else None)
                    self.assertEqual(data.shuffle, "-fault_output_compression" in options)
                self.assertEqual(file["fields/time"].dtype, "f8")
        print(size)
        self.assertLess(max(size["single"], size["small"]), size["plain"])
        self.assertLess(size["smallest"], size["single"])

    def test_restart_keeps_storage(self):
        options = ["-fault_output", "a.h5", "-fault_output_precision", "single", "-fault_output_compression", "3"]
        self.fault(*options, "-fault_checkpoint", "state", "-ts_max_steps", "9", code=3)
        text = self.fault("-fault_output", "a.h5", "-fault_restart", "state", code=1)
        self.assertIn("expected -fault_output_precision single -fault_output_compression 3, or another -fault_output",
                      text)
        self.fault(*options, "-fault_restart", "state")
        self.fault("-fault_output", "b.h5")
        with h5py.File(self.path("a.h5")) as a, h5py.File(self.path("b.h5")) as b:
            np.testing.assert_array_equal(a["fields/slip"], b["fields/slip"][...].astype("f4"))

    def test_size(self):
        """An entry has 8 bytes of time, and 4 fields of 30 doubles."""
        for options, all_of_them in (([], "at most 100 MB in all (-fault_output_size)"),
                                     (["-fault_output_interval", "1"], "968 kB for every 1000 steps"),
                                     (["-fault_output_size", "0"], "968 kB for every 1000 steps"),
                                     (["-fault_output_interval", "5"], "194 kB for every 1000 steps"),
                                     (["-fault_output_rate_change", "2"], "968 kB for 1000")):
            text = re.sub(" +", " ", self.fault("-fault_output", "a.h5", *options))
            self.assertIn(f"output: 968 bytes an entry of /fields, {all_of_them}\n", text)
        text = self.fault("-fault_output", "a.h5", "-fault_output_time_interval", "2.5", "-fault_output_precision",
                          "single", "-fault_output_compression", "1")
        self.assertIn("at most 488 bytes an entry of /fields, at most 6.83 kB for the entries of the run, at most 14\n",
                      text)
        self.assertLessEqual(len(self.get("a.h5", "fields/time")), 14)


if __name__ == "__main__":
    unittest.main()
