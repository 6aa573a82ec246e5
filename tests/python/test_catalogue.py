"""-fault_catalogue of whole programs: what its numbers mean, by hand from the run's output; ranks, meshes, restarts,
kills; CSV."""

import csv
import os
import re
import subprocess
import time
import unittest

from scripts import FAULT, SOURCE, FaultTest

import h5py
import numpy as np

from slipstep import Catalogue

os.environ.setdefault("OMPI_MCA_ess_singleton_isolated", "1")  # as in test_output_whole.py
GRID = ("-fault_nx", "6", "-fault_nz", "5", "-ts_adapt_type", "heuristic", "-ts_rtol", "1e-3")
G = 30e9
# of stick slip: 13 events in 1e9 s
LOADED = ("-fault_nx", "1", "-fault_nz", "1", "-fault_loading_rate", "1e-9", "-fault_initial", "rest",
          "-fault_friction_law", "rate_weakening")
# no inertia, a patch that slips at once
RUPTURE = ("-fault_nx", 42, "-fault_nz", 21, "-fault_length_x", 20000, "-fault_length_z", 10000, "-fault_inertia", "no",
           "-fault_viscosity", "radiation", "-fault_normal_stress", 50e6, "-fault_normal_stress_gradient", 0,
           "-fault_friction_residual", 0.5, "-fault_initial", "traction", "-fault_initial_unstable", "-ts_max_time", 40)
FIXED = ("onset", "end", "x", "z", "area", "mean_slip", "max_slip", "moment", "magnitude", "stress_drop",
         "peak_slip_rate")


class CatalogueTest(FaultTest):
    def same(self, a, b, tolerance):
        """Two catalogues, relative to the largest value of each column"""
        a, b = Catalogue(self.path(a)), Catalogue(self.path(b))
        self.assertEqual(a.count, b.count)
        for name in a.event:
            if name in ("energy_residual", "kinetic_energy", "loading_work"):  # differences of much larger numbers
                continue
            np.testing.assert_allclose(a.event[name], b.event[name], rtol=tolerance, err_msg=name)
        return a, b

    def test_name_of_earlier_versions(self):
        """The energy residual was /ledger before version 0.5."""
        self.fault(*GRID, "-fault_catalogue", "events.h5")
        named = Catalogue(self.path("events.h5"))
        with h5py.File(self.path("events.h5"), "a") as file:
            file.move("energy_residual", "ledger")
        again = Catalogue(self.path("events.h5"))
        self.assertEqual((set(again.event), again.units), (set(named.event), named.units))
        np.testing.assert_array_equal(again.event["energy_residual"], named.event["energy_residual"])

    def test_numbers_by_hand(self):
        said = self.fault(*GRID, "-fault_catalogue", "events.h5", "-fault_catalogue_maps", "-fault_output", "run.h5")
        catalogue = Catalogue(self.path("events.h5"))
        self.assertTrue(catalogue.complete and catalogue.count == 1 and set(FIXED) <= set(catalogue.event))
        event = {name: values[0] for name, values in catalogue.event.items()}
        self.assertRegex(said, r"(?m)^events: +1$")
        line = re.search(r"(?m)^event 1  t ([\d.]+) s  Mw ([\d.]+)  x ([\d.]+) km  z ([\d.]+) km  slip ([\d.]+) m  "
                         r"drop ([\d.]+) MPa  ([\d.]+) s$", said)
        for text, value in zip(line.groups(), (event["onset"], event["magnitude"], event["x"] / 1e3, event["z"] / 1e3,
                                               event["mean_slip"],
                                               event["stress_drop"] / 1e6, event["end"] - event["onset"])):
            self.assertAlmostEqual(float(text), value, delta=0.006 * value)  # three digits
        with h5py.File(self.path("run.h5")) as file:
            t, v, s = (file[f"fields/{name}"][()] for name in ("time", "slip_rate", "slip"))
            self.assertEqual(file["result"].attrs["events"], 1)
        largest = v.max(axis=(1, 2))
        first = np.argmax(largest > 1e-3)  # steps are the run's: what is between them is interpolated
        last = len(t) - 1 - np.argmax(largest[::-1] > 1e-3)
        self.assertTrue(t[first - 1] < event["onset"] < t[first] and t[last] < event["end"] <= t[last + 1])
        # but for the state within the step, which is not in the file, a straight line of the rate's logarithm: 2e-4 of
        # the step off
        self.assertAlmostEqual(event["onset"],
                               np.interp(np.log(1e-3), np.log(largest[first - 1:first + 1]), t[first - 1:first + 1]),
                               delta=1e-3 * (t[first] - t[first - 1]))
        # two cells beside the middle are alike: rounding says which of them is first
        self.assertGreater(v[first].flat[int(event["cell"])], (1 - 1e-6) * v[first].max())
        self.assertEqual((event["x"], event["z"]), (500 * (event["cell"] % 6 + 0.5), 600 * (event["cell"] // 6 + 0.5)))
        self.assertEqual(event["area"], 300e3 * (v.max(axis=0) > 1e-3).sum())
        # within the part of the two outer steps that is slower than the event rate
        slip, outer = s[last + 1] - s[first - 1], 1e-3 * (t[first] - t[first - 1] + t[last + 1] - t[last])
        maps = catalogue.map("slip")[0]
        self.assertTrue((maps <= slip + 1e-12).all() and (maps >= slip - outer).all())
        self.assertAlmostEqual(event["mean_slip"], maps.mean(), delta=1e-12)
        self.assertAlmostEqual(event["max_slip"], maps.max(), delta=1e-15)
        self.assertAlmostEqual(event["moment"] / (G * 300e3 * maps.sum()), 1, delta=1e-12)
        self.assertAlmostEqual(event["magnitude"], 2 / 3 * (np.log10(event["moment"]) - 9.1), delta=1e-12)
        self.assertTrue(largest.max() <= event["peak_slip_rate"] < 1.01 * largest.max())
        rupture = catalogue.map("rupture_time")[0]
        for e in np.ndindex(5, 6):
            k = np.argmax(v[(slice(None), *e)] > 1e-3)
            self.assertTrue(t[k - 1] - 1e-9 <= rupture[e] + event["onset"] <= t[k] + 1e-9)
        self.assertLess(abs(event["energy_residual"]), 2e-4)  # of steps at the reference tolerances; measured 3e-5
        total = (event["elastic_energy"] + event["kinetic_energy"] + event["dissipated_energy"]
                 + event["radiated_energy"] - event["loading_work"])
        self.assertAlmostEqual(event["energy_residual"], total / -event["elastic_energy"], delta=1e-12)

    def test_one_event_passes_its_rate_to_and_fro(self):
        """On cells that are too large for rate-and-state friction rates go up and down: an event begins where the
        largest passes the event rate and is over where it is below a tenth of it; what passes it in between is the same
        event, which ends where it did so last."""
        run = ("-fault_nx", "8", "-fault_nz", "4", "-fault_length_x", "16e3", "-fault_length_z", "8e3",
               "-fault_friction_law", "rate_and_state", "-fault_normal_stress", "50e6", "-fault_normal_stress_gradient",
               "0", "-fault_loading_rate", "1e-9", "-fault_initial_rate", "1e-10", "-fault_friction_slip", "0.02",
               "-fault_friction_a", "0.008", "-fault_friction_b", "0.012", "-ts_type", "rk", "-ts_rk_type", "3bs",
               "-ts_adapt_type", "basic", "-ts_max_time", "2e9", "-fault_event_rate", "3e-4", "-fault_output_interval",
               "1000000")
        self.fault(*run, "-fault_catalogue", "events.h5", "-fault_output", "run.h5", "-fault_catalogue_maps")
        t, v = self.get("run.h5", "series/time", "series/max_slip_rate")
        expected, simple = [], 0
        for k in range(1, len(t)):
            simple += v[k - 1] <= 3e-4 < v[k]
            if v[k - 1] <= 3e-4 < v[k] and (not expected or over):
                expected.append([t[k - 1], t[k], 0, 0])
                over = False
            if expected and v[k - 1] > 3e-4 >= v[k]:
                expected[-1][2:] = t[k - 1], t[k]
            over = expected and (over or v[k] <= 3e-5)
        expected = np.array(expected)
        events = Catalogue(self.path("events.h5"))
        self.assertGreater(simple, len(expected))
        self.assertEqual(events.count, len(expected))
        self.assertTrue(((expected[:, 0] <= events.event["onset"]) & (events.event["onset"] <= expected[:, 1])).all())
        self.assertTrue(((expected[:, 2] <= events.event["end"]) & (events.event["end"] <= expected[:, 3])).all())
        self.assertTrue((events.event["mean_slip"] > 0).all())
        # what is put in and taken out of an event that has a pause: steps of a pair of order 3, by a trapezoidal rule
        # measured 4e-4; 7e-3 without the work of a pause
        self.assertLess(abs(events.event["energy_residual"]).max(), 1e-3)
        # and on from checkpoints, one of them within a pause
        paused = next(k for k in range(1, len(t)) if v[k - 1] > 3e-4 >= v[k] and v[k] > 3e-5 and v[k + 1] > 3e-5)
        for steps in (paused + 1, paused + 2):
            two, state = f"two{steps}.h5", f"state{steps}"
            self.fault(*run, "-fault_catalogue", two, "-fault_catalogue_maps", "-fault_checkpoint", state,
                       "-ts_max_steps", str(steps), code=3)
            self.fault(*run, "-fault_catalogue", two, "-fault_catalogue_maps", "-fault_restart", state)
            _, catalogue = self.same("events.h5", two, 0)
            for name in ("slip", "rupture_time"):
                np.testing.assert_array_equal(catalogue.map(name), events.map(name))

    def test_ranks_and_meshes(self):
        """A mesh of the grid's cells is the grid; the order in which processes number its cells does not show."""
        self.make_mesh("mesh.h5", "uniform --cells 6 5")
        steps = ("-ts_adapt_type", "none", "-ts_dt", "0.1", "-ts_bathe_stage_error", "0", "-fault_catalogue_maps",
                 "-fault_catalogue")
        self.fault(*GRID, *steps, "grid.h5")
        for ranks in (1, 2):
            self.fault("-fault_mesh", "mesh.h5", *steps, f"mesh{ranks}.h5", ranks=ranks)
            # rounding, which 300 steps amplify
            grid, mesh = self.same("grid.h5", f"mesh{ranks}.h5", 1e-8)
            for name in ("slip", "rupture_time"):
                np.testing.assert_allclose(mesh.map(name), grid.map(name).reshape(1, 30), rtol=1e-6, atol=1e-9)
        self.fault(*GRID, *steps, "grid2.h5", ranks=2)
        self.same("grid.h5", "grid2.h5", 1e-8)
        self.make_mesh("mesh.h5", "parallel --cells 5 4 --ratio 3 --offset 800")
        two = ("-fault_mesh", "mesh.h5", "-fault_stiffness_scaling", "mean_slip", *steps)
        self.fault(*two, "two.h5")
        self.fault(*two, "both.h5", ranks=2)
        catalogue, _ = self.same("two.h5", "both.h5", 1e-8)
        area = catalogue.mesh["length"] * catalogue.mesh["width"]
        for slip, rupture, moment, mean, size, y, cell in zip(
                catalogue.map("slip"), catalogue.map("rupture_time"),
                *(catalogue.event[name] for name in ("moment", "mean_slip", "area", "y", "cell"))):
            broke = np.isfinite(rupture)
            self.assertAlmostEqual(moment / (G * (slip * area).sum()), 1, delta=1e-12)
            self.assertAlmostEqual(size / area[broke].sum(), 1, delta=1e-12)
            self.assertAlmostEqual(mean / ((slip * area)[broke].sum() / size), 1, delta=1e-12)
            self.assertEqual(y, catalogue.mesh["y"][int(cell)])

    def test_elastic_energy(self):
        """Of one cell of 3 km at the ground, whose stiffness is known (0.311646 G/km): u K u/2 - T u, T the load.
        (test_stress has that of the catalogue.)"""
        load, stiffness = 20e6, 0.311646 * G / 1e3
        self.fault("-fault_nx", 1, "-fault_nz", 1, "-fault_initial", "traction", "-fault_initial_traction", load,
                   "-fault_initial_unstable", "-fault_stressing_rate", 1e4,
                   "-fault_output", "run.h5", "-ts_max_time", 5)
        time, u, energy = self.get("run.h5", "series/time", "series/mean_displacement", "series/elastic_energy")
        # six digits of the stiffness
        np.testing.assert_allclose(energy, stiffness * u**2 / 2 - (load + 1e4 * time) * u, rtol=2e-6,
                                   atol=2e-6 * abs(energy).max())
        self.assertLess(energy.min(), -0.1 * load * u.max())  # and without T it would not be negative

    def test_cells_of_other_areas(self):
        """Cells that differ by nine in area break otherwise than those of a grid (here by 10 % in slip), but the stress
        that a metre of slip releases, and the energy that a moment does, are the fault's: measured 0.4 and 1.6 % apart,
        and 41 % with the stress of rows that keep their weights."""
        self.make_mesh("mesh.h5", "graded --cells 16 14 --ratio 3")
        self.fault("-fault_nx", "16", "-fault_nz", "14", "-fault_catalogue", "grid.h5")
        self.fault("-fault_mesh", "mesh.h5", "-fault_catalogue", "mesh_events.h5")
        grid, mesh = (Catalogue(self.path(name)).event for name in ("grid.h5", "mesh_events.h5"))
        for over, under, tolerance in (("stress_drop", "mean_slip", 0.01), ("elastic_energy", "moment", 0.03),
                                       ("area", "area", 1e-12)):
            self.assertAlmostEqual(mesh[over][0] / mesh[under][0] / (grid[over][0] / grid[under][0]), 1,
                                   delta=tolerance)
        # of second order in the steps, 2.5e-4 by those of the accuracy 1e-2
        self.assertLess(abs(mesh["energy_residual"][0]), 5e-4)

    def rupture(self, kind, rtol, *options):
        """Event, times of rupture and /result of an explicit run of friction that sticks"""
        self.fault(*RUPTURE, "-fault_parameters", "rupture_fields.h5", "-ts_type", kind, "-ts_rtol", rtol, *options,
                   "-fault_catalogue", "explicit.h5", "-fault_catalogue_maps",
                   "-fault_output", "explicit_run.h5", "-fault_output_overwrite", "-fault_output_time_interval", 1e9)
        catalogue = Catalogue(self.path("explicit.h5"))
        self.assertEqual(catalogue.count, 1)
        with h5py.File(self.path("explicit.h5")) as file, h5py.File(self.path("explicit_run.h5")) as run:
            found = {name: values[0] for name, values
                     in catalogue.event.items()}, file["maps/rupture_time"][0], dict(run["result"].attrs)
        os.remove(self.path("explicit.h5"))
        return found

    def speed_of_most(self, speed, times, place):
        """The line of times over distances has the least sum of absolute errors, of which that of least squares has
        1.01 times as much."""
        early = np.exp(-times / (0.1 * times.mean()))[:, None]
        far = np.linalg.norm(place - (early * place).sum(axis=0) / early.sum(), axis=1)

        def errors(slope):
            late = times - slope * far
            return abs(late - np.median(late)).sum()

        self.assertLess(errors(1 / speed), 1.001 * min(map(errors, np.linspace(0, 4 / speed, 4001))))

    def test_explicit_steps_of_friction_that_sticks(self):
        """A catalogue costs no product a step, only those of an event's onset, end and row. Bounds are twice what was
        measured; with rates of the balance in the middle of steps, a product each, times of rupture were off by 8 times
        as much, the balance of energies by 3 to 46 times."""
        x, z = np.meshgrid(np.arange(42) + 0.5, np.arange(21) + 0.5)
        chance = np.random.default_rng(3)
        self.hdf5("rupture_fields.h5", friction_drop=0.1 + 0.01 * chance.random((21, 42)),
                  friction_slip=0.2 + 0.02 * chance.random((21, 42)),
                  initial_traction=50e6 * np.where(np.hypot(x - 10.5, z - 12.5) < 6, 0.625, 0.56))
        exact, times, _ = self.rupture("adams", 1e-6)
        self.assertTrue((times >= 0).mean() > 0.9 and abs(exact["energy_residual"]) < 1e-5)
        self.speed_of_most(exact["rupture_speed"], times[times >= 0],
                           np.stack([x * 20e3 / 42, z * 10e3 / 21], axis=-1)[times >= 0])
        # states within steps heal: measured 4e-5, and 3e-4 without that
        self.assertLess(abs(self.rupture("adams", 1e-5, "-fault_healing_time", 0.3)[0]["energy_residual"]), 1e-4)
        for kind, rtol, *bounds in (("rkc", 3e-2, 1e-4, 2.8e-3, 6.8e-3), ("rkc", 3e-3, 2.7e-5, 1.5e-4, 1.5e-3),
                                    ("adams", 1e-3, 1.9e-5, 4e-5, 2e-3), ("rk", 1e-3, 1.4e-5, 7e-5, 3.2e-3)):
            with self.subTest(kind=kind, rtol=rtol):
                event, broke, result = self.rupture(kind, rtol)
                self.assertGreater(event["steps"], 100)
                self.assertLess(result["products"] - result["products_all"], 45)
                off = abs(event["energy_residual"]), abs(event["radiated_energy"] / exact["radiated_energy"]
                                                - 1), np.abs(broke - times)[times >= 0].mean()
                for value, bound in zip(off, bounds):  # the last one of 12 s that the rupture takes
                    self.assertLess(value, bound)

    def test_explicit_steps_on_cells_of_other_areas(self):
        """The balance of energies closes on a graded mesh as on the grid: measured 6.7e-5, and 3.9e-3 where the damping
        of a cell did not count its area."""
        self.make_mesh("uneven.h5", "graded --cells 24 12 --ratio 5 --size 20000 10000")
        with h5py.File(self.path("uneven.h5")) as file:
            x, _, z = file["cells"][:, :3].T
        self.hdf5("uneven_fields.h5", initial_traction=50e6 * np.where(np.hypot(x - 5e3, z - 6e3) < 3e3, 0.625, 0.56))
        self.fault(*RUPTURE[8:], "-fault_mesh", "uneven.h5", "-fault_parameters", "uneven_fields.h5",
                   "-fault_friction_drop", 0.105, "-fault_friction_slip", 0.2, "-ts_type", "rkc", "-ts_rtol", 3e-3,
                   "-fault_catalogue", "uneven_events.h5")
        event = Catalogue(self.path("uneven_events.h5")).event
        self.assertGreater(event["steps"][0], 100)
        self.assertLess(abs(event["energy_residual"][0]), 3e-4)

    def test_restart_within_an_event(self):
        for ranks, other, options in ((1, 1, GRID), (1, 2, GRID)):
            events = ("-fault_catalogue_maps", "-fault_catalogue")
            self.fault(*options, *events, "whole.h5", ranks=ranks)
            said = self.fault(*options, *events, "cut.h5", "-fault_checkpoint", "state.h5", "-fault_output_overwrite",
                              "-ts_max_time", "9", ranks=ranks)
            found = re.search(r"(?m)^event that goes on: +M ([\d.]+) so far, since t (4\.7\d+) s: the last row, of "
                              r"this much; a later -ts_max_time continues it$", said)
            self.assertTrue(found, said)
            cut = Catalogue(self.path("cut.h5"))
            self.assertEqual((cut.count, cut.goes_on["end"], f"{cut.goes_on['magnitude']:.2f}", cut.over[0]),
                             (1, 9, found[1], False))
            self.assertAlmostEqual(cut.goes_on["onset"], float(found[2]), delta=1e-5)
            # its map has the slip of its row, its moment is the sum of that
            self.assertAlmostEqual(np.abs(cut.map("slip")).max(), cut.event["max_slip"][0],
                                   delta=1e-6 * cut.event["max_slip"][0])
            self.assertEqual(np.isfinite(cut.map("rupture_time")).sum() * 500 * 600, cut.event["area"][0])
            table = self.script("catalogue-csv", self.path("cut.h5"))
            # the names of the columns, and its row
            self.assertEqual((table.returncode, len(table.stdout.splitlines())), (0, 2))
            self.assertIn(f"M {found[1]} ", table.stderr)
            self.fault(*options, *events, "cut.h5", "-fault_restart", "state.h5", ranks=other)
            cut = Catalogue(self.path("cut.h5"))
            self.assertEqual((cut.count, cut.goes_on), (1, None))
            self.fault(*options, *events, "short.h5", "-fault_checkpoint", "state.h5", "-fault_output_overwrite",
                       "-ts_max_steps", "37", ranks=ranks, code=3)
            self.fault(*options, *events, "short.h5", "-fault_restart", "state.h5", ranks=other)
            whole, short = self.same("whole.h5", "short.h5", 0 if ranks == other else 1e-6)
            self.assertEqual(whole.count, 1)
            np.testing.assert_allclose(short.map("slip"), whole.map("slip"), rtol=1e-6)
            # without the file, and with a checkpoint that knows no catalogue
            os.remove(self.path("short.h5"))
            self.fault(*options, *events, "short.h5", "-fault_restart", "state.h5")
            self.same("whole.h5", "short.h5", 1e-6)
            self.assertIn("-fault_catalogue_maps yes",
                          self.fault(*options, events[1], "whole.h5", "-fault_restart", "state.h5", code=1))
            self.assertIn("-fault_event_rate is 0.01 m/s, was 0.001 m/s", self.fault(
                *options, *events, "short.h5", "-fault_event_rate", "0.01", "-fault_restart", "state.h5", code=1))
            os.remove(self.path("state.h5"))
            self.fault(*options, "-fault_checkpoint", "state.h5", "-ts_max_steps", "37", code=3)
            self.fault(*options, *events, "late.h5", "-fault_restart", "state.h5")
            self.assertTrue(9 < Catalogue(self.path("late.h5")).event["onset"][0] < 13.4)  # from the checkpoint on
            for name in ("whole.h5", "short.h5", "late.h5", "cut.h5", "state.h5"):
                os.remove(self.path(name))

    def test_restart_before_later_events(self):
        """A run that goes on from a checkpoint older than its catalogue writes the later events anew: rows and maps are
        those of the unbroken run. A catalogue without the checkpoint's last event is refused, and stays as it is."""
        run = (*LOADED, "-ts_max_time", "1e13", "-fault_catalogue_maps", "-fault_catalogue")
        self.fault(*run, "whole.h5", "-ts_max_steps", "1000", code=3)
        self.fault(*run, "short.h5", "-fault_checkpoint", "state.h5", "-ts_max_steps", "500", code=3)
        at_checkpoint = Catalogue(self.path("short.h5")).count
        self.fault(*run, "short.h5", "-fault_restart", "state.h5", "-ts_max_steps", "900", code=3)
        self.assertGreater(Catalogue(self.path("short.h5")).count, at_checkpoint)
        self.fault(*run, "short.h5", "-fault_restart", "state.h5", "-ts_max_steps", "1000", code=3)
        whole, short = self.same("whole.h5", "short.h5", 0)
        self.assertGreater(whole.count, at_checkpoint + 1)
        self.assertGreater(at_checkpoint, 0)
        for name in ("slip", "rupture_time"):
            self.assertEqual(whole.map(name).shape, (whole.count, 1, 1))
            np.testing.assert_array_equal(short.map(name), whole.map(name))
        self.fault(*run, "fewer.h5", "-ts_max_steps", "20", code=3)
        self.fault(*run, "others.h5", "-ts_max_steps", "1000", "-fault_loading_rate", "1.5e-9", code=3)
        self.assertLess(Catalogue(self.path("fewer.h5")).count, at_checkpoint)
        self.assertGreaterEqual(Catalogue(self.path("others.h5")).count, at_checkpoint)
        for name in ("fewer.h5", "others.h5"):
            before = self.content(name, None)
            said = self.fault(*run, name, "-fault_restart", "state.h5", code=1)
            self.assertIn(f"{name} (-fault_catalogue)", said)
            self.assertEqual(self.content(name, None), before)

    def test_many_events_and_a_kill(self):
        run = (*LOADED, "-fault_catalogue", "events.h5")
        self.fault(*run, "-ts_max_time", "1e13", "-ts_max_steps", "4000", code=3)
        whole = Catalogue(self.path("events.h5"))
        self.assertGreater(whole.count, 20)
        over = whole.event["mean_slip"][whole.over]
        self.assertGreaterEqual(len(over), whole.count - 1)
        self.assertTrue((whole.event["onset"][1:] > whole.event["end"][:-1]).all()
                        and (whole.event["end"] > whole.event["onset"]).all())
        self.assertLess(abs(whole.event["energy_residual"]).max(), 1e-3)  # measured 1.1e-4
        # of one cell the slip is what the loading has brought from one event to the next, but for creep before and
        # after
        brought = 1e-9 * np.diff(whole.event["onset"])
        np.testing.assert_allclose(over[1:], brought[:len(over) - 1], rtol=0.1)
        older = self.content("events.h5", None)
        process = subprocess.Popen([FAULT, *run, "-ts_max_time", "1e13"], cwd=self.folder.name,
                                   stdout=subprocess.DEVNULL)
        part, rows = self.path("events.h5.part"), 0
        while rows < 2 and process.poll() is None:
            time.sleep(0.05)
            if os.path.exists(part):
                with h5py.File(part, "r", swmr=True) as file:  # rows that all columns have
                    rows = min(len(file[name]) for name in whole.event)
        process.kill()
        process.wait()
        killed = Catalogue(part)
        self.assertGreaterEqual(killed.count, 2)
        self.assertFalse(killed.complete)
        n = min(killed.count, whole.count)
        for name in whole.event:
            np.testing.assert_array_equal(killed.event[name][:n], whole.event[name][:n])
        self.assertEqual(self.content("events.h5", None), older)
        said = self.fault(*run, "-ts_max_time", "1e3", code=1)
        self.assertIn("-fault_restart", said)
        self.assertIn("-fault_output_overwrite", said)
        self.fault(*run, "-ts_max_time", "1e3", "-fault_output_overwrite")
        self.assertEqual(Catalogue(self.path("events.h5")).count, 0)

    def test_csv(self):
        self.fault(*LOADED, "-ts_max_time", "2e9", "-fault_catalogue", "events.h5")
        done = self.script("catalogue-csv", self.path("events.h5"), self.path("events.csv"))
        self.assertEqual((done.returncode, done.stdout.split(", ")[0], done.stderr),
                         (0, f"Table: {self.path('events.csv')}", ""))
        shown = self.script("catalogue-csv", self.path("events.h5"))
        text = self.content("events.csv")
        self.assertEqual(shown.stdout, text)
        rows = list(csv.DictReader(text.splitlines()))
        catalogue = Catalogue(self.path("events.h5"))
        self.assertEqual(len(rows), catalogue.count)
        for name, values in catalogue.event.items():
            unit = catalogue.units[name]
            np.testing.assert_array_equal([float(row[name if unit == "1" else f"{name} [{unit}]"]) for row in rows],
                                          values)
        for wrong, message in ((self.path("missing.h5"), "missing.h5"),
                               (self.path("events.csv"), "events.csv"),
                               (os.path.join(SOURCE, "training/policies/fault.h5"), "fault.h5")):
            done = self.script("catalogue-csv", wrong)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1))
            self.assertIn(message, done.stderr)

    def test_refused(self):
        for options, message in ((("-fault_event_rate", "0"), "-fault_event_rate is 0"),
                                 (("-fault_catalogue", "no/events.h5"), "no/events.h5"),
                                 (("-fault_catalogue", "a.h5", "-fault_output", "a.h5"), "a.h5"),
                                 (("-fault_catalogue_maps", "maybe"), "-fault_catalogue_maps")):
            said = self.fault(*GRID, *options, code=1)
            self.assertIn(message, said)
            self.assertEqual(sum(": warning: " not in line for line in said.splitlines()), 1, said)


if __name__ == "__main__":
    unittest.main()
