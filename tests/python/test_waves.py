"""Faults that radiate waves: restarts, ranks, energies, and what is refused; test_examples.py has ruptures beside
published ones and exact slip."""

import os
import re
import subprocess
import sys
import unittest
import unittest.mock

from scripts import BUILD, SOURCE, FaultTest

import h5py
import numpy as np
from slipstep.results.catalogue import Catalogue

sys.path.insert(0, os.path.join(SOURCE, "examples"))
import kostrov
import tpv3
import tpv5

OPTIONS = "-options_file", os.path.join(SOURCE, "examples",
                                        "tpv3.opts"), "-fault_progress", "no", "-fault_output_overwrite"
WHOLE = 1e6  # interval of output [s]: the start and the end


class WavesTest(FaultTest):
    def tpv3(self, cell, *options, **more):
        """A run of TPV3 with cells of so many metres."""
        if not os.path.exists(self.path("t_fields.h5")):
            tpv3.make(self.path("t"), cell)
        nz, nx = tpv3.shape_of(cell)
        return self.fault(*OPTIONS, "-fault_parameters", "t_fields.h5", "-fault_nx", nx, "-fault_nz", nz, *options,
                          **more)

    def last(self, name):
        return self.get(name, "fields/time")[-1], self.get(name, "fields/slip")[-1]

    def test_restart_in_the_rupture(self):
        """To the bit: the memory is in the checkpoint."""
        options = ("-fault_output_precision", "double", "-fault_output_time_interval", WHOLE, "-ts_max_time", 1.5,
                   "-fault_output")
        self.tpv3(500, *options, "whole.h5")
        self.tpv3(500, *options, "part.h5", "-ts_max_steps", 20, "-fault_checkpoint", "state.h5", code=3)
        self.tpv3(500, *options, "part.h5", "-fault_restart", "state.h5")
        (time, slip), (same, again) = self.last("whole.h5"), self.last("part.h5")
        self.assertEqual(time, same)
        self.assertGreater(slip.max(), 0.5)
        np.testing.assert_array_equal(slip, again)

    def test_ranks(self):
        """To rounding, which cells that are about to slide multiply: 4e-12 on one kind of processor, 1e-13 on another.
        A field that did not stay real would mix rows of cells by pairs, which differ with the ranks."""
        options = ("-fault_output_precision", "double", "-fault_output_time_interval", WHOLE, "-ts_max_time", 1.5,
                   "-fault_output")
        self.tpv3(500, *options, "one.h5")
        self.tpv3(500, *options, "two.h5", ranks=2)
        slip, other = self.last("one.h5")[1], self.last("two.h5")[1]
        np.testing.assert_allclose(other, slip, rtol=0, atol=1e-10 * np.abs(slip).max())

    def test_rate_weakening(self):
        """Before waves from the edges arrive slip has the rate that friction and the impedance balance, (q - residual
        sigma - eta v) (1 + v/V0) = drop sigma, a quadratic equation; where the strength falls faster than the impedance
        gains there is none."""
        law = "-fault_parameters", "u.h5", "-fault_friction_law", "rate_weakening", "-fault_friction_rate"
        self.hdf5("u.h5", initial_traction=np.full(tpv3.shape_of(500), 81.6e6))
        said = self.tpv3(500, "-fault_output", "r.h5", "-ts_max_time", 0.3, *law, 5)
        self.assertIn("size of the cells", said)
        rates = self.get("r.h5", "fields/slip_rate")[-1]
        rates = np.linalg.norm(rates.reshape(*tpv3.shape_of(500), 2), axis=2)
        eta = np.sqrt(32.03812e9 * 2670) / 2
        above, drop, scale = 81.6e6 - 0.525 * 120e6, 0.152 * 120e6, 5
        expected = max(np.roots([-eta / scale, above / scale - eta, above - drop]))
        self.assertAlmostEqual(rates[15, 30] / expected, 1, delta=1e-3)
        self.assertIn("3.94 times", self.tpv3(500, *law, 1, code=1))

    def test_energies_and_speed(self):
        """A crack of 200 cells whose cells weaken at once, so that friction takes no energy at the front, and which
        stops at 4 km. While it grows it is Kostrov's, and with the static stress drop D/E of its slip it has radiated D
        S (1 - 1/(2 E)), S the sum of slip, D the stress drop, E the elliptic integral: within 0.5 %, measured 0.25 %
        and half of that with half the cells' size. Its front's speed is the one that is given: 1e-3, a ninth of a step
        in the 1.6 s that it takes, measured 3e-5. What it could radiate is half of slip times the static stress that it
        takes away, by the closed form of cells: measured 1e-4, as that is the small difference of energies."""
        speed, stop = 0.7, 4e3
        with unittest.mock.patch.multiple(kostrov, BEFORE=0.0, LASTS=0.0):
            options = kostrov.make(self.path("k"), "line", 200, speed).split()
        with h5py.File(self.path("k_fields.h5"), "r+") as file:
            file["weakening_time"][kostrov.distances("line", 200) > stop] = 1e6
        self.fault("-options_file", os.path.join(SOURCE, "examples", "kostrov.opts"), *options, "-ts_max_time", 8,
                   "-fault_parameters", "k_fields.h5", "-fault_output", "k.h5", "-fault_catalogue", "events.h5",
                   "-fault_catalogue_maps", "-fault_progress", "no", program=os.path.join(BUILD, "bin", "friction_law"))
        with h5py.File(self.path("k.h5")) as file:
            time, power = file["series/time"][...], file["series/viscous_power"][...] * file["parameters"].attrs["area"]
            length = file["parameters"].attrs["length_x"]
        radiated = np.append(0, np.cumsum(np.diff(time) * (power[1:] + power[:-1]) / 2))
        end = 0.95 * stop / (speed * kostrov.SHEAR)
        slip = kostrov.exact("line", speed, 0, end)  # in the middle, at the end; 2 D a/(G E)
        sum_of_slip, integral = np.pi / 2 * slip * 0.95 * stop * length, 2 * kostrov.DROP * 0.95 * stop / (
            kostrov.MODULUS * slip)
        self.assertAlmostEqual(np.interp(end, time, radiated) / (kostrov.DROP * sum_of_slip * (1 - 1 / (2 * integral))),
                               1, delta=5e-3)
        with h5py.File(self.path("events.h5")) as file:
            event = {name: file[name][...] for name in file if isinstance(file[name], h5py.Dataset)}
            slips = file["maps/slip"][0].ravel()
        self.assertEqual(len(event["onset"]), 1)
        event = {name: values[0] for name, values in event.items()}
        self.assertAlmostEqual(event["rupture_speed"] / (speed * kostrov.SHEAR), 1, delta=1e-3)
        self.assertLess(abs(event["energy_residual"]), 1e-3)  # measured 4e-5
        self.assertAlmostEqual(event["radiated_energy"] / np.interp(event["end"], time, radiated), 1, delta=1e-3)
        apart = np.subtract.outer(np.arange(200), np.arange(200))
        stiffness = kostrov.MODULUS / (2 * np.pi * kostrov.LENGTH / 200) * (1 / (apart + 0.5) - 1 / (apart - 0.5))
        available = (slips @ stiffness @ slips) / 2 * kostrov.LENGTH / 200 * length
        self.assertAlmostEqual(event["radiated_efficiency"], event["radiated_energy"] / available, delta=5e-4)

    def test_steps_of_every_controller(self):
        """Of the list, and none shorter than the shortest, whatever the error: a controller that is refused there would
        shorten steps for ever."""
        shortest = 1500 / 3464 / 3
        for adapt in "lapusta", "basic", "dsp", "pi", "heuristic":
            self.tpv3(1500, "-ts_max_time", 1.5, "-ts_adapt_type", adapt, "-ts_rtol", 1e-6, "-ts_dt", 1.7 * shortest,
                      "-fault_output", "list.h5", "-fault_output_overwrite", "-fault_output_time_interval", WHOLE)
            with h5py.File(self.path("list.h5")) as f:
                step = f["steps/dt"][:-2] / shortest  # the last two share what is left
            power = 2.0 ** np.floor(np.log2(step * 1.0001))
            # cs in six digits
            np.testing.assert_allclose(np.where(step > 1.4 * power, 1.5 * power, power), step, rtol=1e-6)
            self.assertGreater(step.min(), 0.999)
            self.assertLess(len(step), 20)

    def test_states_that_follow_normal_stress(self):
        """Steps of constant rates on a dipping fault without waves, whose normal stress slip changes, and with it the
        state: slip is of second order from that of TSADAMS in tight steps, so that its error falls by 4 as steps are
        halved (it stayed at 1.4 % where states followed the load alone)."""
        common = ("-fault_nx", 8, "-fault_nz", 6, "-fault_length_x", 800, "-fault_length_z", 600, "-fault_dip", 40,
                  "-fault_rake", 90, "-fault_normal_coupling", "yes", "-fault_depth_top", 100, "-fault_friction_law",
                  "rate_and_state", "-fault_friction_alpha", 0.3, "-fault_friction_slip", 0.02, "-fault_initial_rate",
                  1e-3, "-fault_normal_stress", 2e7, "-ts_max_time", 300, "-fault_output", "o.h5",
                  "-fault_output_overwrite", "yes")
        slip = []
        for steps in (("adams", "-ts_rtol", 1e-8), ("lapusta", "-ts_adapt_type", "none", "-ts_dt", 1),
                      ("lapusta", "-ts_adapt_type", "none", "-ts_dt", 0.5)):
            self.fault(*common, "-ts_type", *steps)
            slip.append(self.get("o.h5", "series/mean_slip")[-1])
        self.assertLess(abs(slip[1] / slip[0] - 1), 1e-3)
        self.assertLess(abs(slip[2] - slip[0]), abs(slip[1] - slip[0]) / 3)

    def test_waves_that_start_an_event(self):
        """A patch breaks and comes to rest; its waves reach a second one 18 km away, 0.34 MPa below its strength, when
        nothing slides.
        Whatever chooses the steps, they stay short until then, and the run is that of the shortest ones; a restart in
        the rest is of the same bits."""
        x, z = np.meshgrid((np.arange(120) + 0.5) * 250 - 15e3, (np.arange(40) + 0.5) * 250 - 5e3)
        stress = np.full(x.shape, 40e6)  # below the residual strength, 63 MPa
        stress[np.hypot(x + 9e3, z) < 2000] = 84e6  # above the strength, 81.24 MPa
        stress[np.hypot(x - 9e3, z) < 2500] = 80.9e6
        self.hdf5("stress.h5", units={"initial_traction": "Pa"}, initial_traction=stress)
        options = ("-fault_kernel full_space -fault_nx 120 -fault_nz 40 -fault_length_x 30e3 -fault_length_z 10e3 "
                   "-fault_shear_modulus 32.03812e9 -fault_density 2670 "
                   "-fault_medium waves -fault_slip_components 2 -fault_friction_law linear_slip_weakening "
                   "-fault_friction_residual 0.525 -fault_friction_drop 0.152 "
                   "-fault_friction_slip 0.2 -fault_normal_stress 120e6 -fault_normal_stress_gradient 0 -fault_initial "
                   "traction -fault_initial_unstable -fault_parameters stress.h5 "
                   "-fault_progress no -fault_output_overwrite -ts_max_time 5.5").split()
        outcome = {}
        for controller in ("none", "lapusta", "basic", "dsp"):
            step = ("-ts_dt", 250 / 3 / np.sqrt(32.03812e9 / 2670)) if controller == "none" else ()
            self.fault(*options, "-ts_adapt_type", controller, *step, "-fault_catalogue", "events.h5", "-fault_output",
                       "run.h5")
            outcome[controller] = self.get("run.h5", "series/mean_slip")[-1], self.get("run.h5", "result@accepted")
            self.assertEqual(self.fault(*options, "-ts_adapt_type", controller, *step, "-ts_max_time",
                                        4).count("all cells rest"), 1)
        shortest = outcome["none"]
        for controller, (slip, steps) in outcome.items():
            # the first patch slips 0.0609 m in the mean of all cells, the second adds to it by 5.5 s
            self.assertGreater(slip, 0.062, controller)
            self.assertLess(abs(slip / shortest[0] - 1), 0.01, controller)
            self.assertLessEqual(steps, shortest[1] + 10, controller)
        # the gap between the fault and its images, 20 km with padding 2.2, is 3.3 s long for P waves
        for padding, first, marks in ((2.2, 20e3, [0, 1]), (4, 50e3, [0, 0])):
            said = self.fault(*options, "-fault_waves_padding", padding, "-fault_catalogue", "events.h5")
            arrival = float(re.search(r"(?m)^images: +waves of periodic images arrive ([\d.]+) s after slip", said)[1])
            self.assertAlmostEqual(arrival * np.sqrt(3 * 32.03812e9 / 2670), first, delta=1e-3 * first)
            events = Catalogue(self.path("events.h5")).event
            self.assertEqual((events["images"].tolist(), events["goes_on"].tolist()), (marks, [0, 1]))
            self.assertEqual("1 of 2 events (the first is event 2) began when waves of periodic images" in said,
                             bool(marks[1]))
        # a short event at 6.9 s has few of the shortest steps, which no controller shortens
        said = self.fault(*options, "-ts_adapt_type", "lapusta", "-fault_catalogue", "events.h5", "-ts_max_time", 7)
        self.assertIn("Use smaller cells", said)
        whole = (*options, "-fault_output_precision", "double", "-fault_output_interval", 1000)
        self.fault(*whole, "-fault_output", "whole.h5", "-fault_catalogue", "whole_events.h5")
        for steps in 20, 80:  # in the first event, and in the rest
            files = "-fault_output", "part.h5", "-fault_catalogue", "part_events.h5"
            self.fault(*whole, *files, "-fault_checkpoint", "state", "-ts_max_steps", steps, code=3)
            self.fault(*whole, *files, "-fault_restart", "state")
            for one, other in zip(self.last("whole.h5"), self.last("part.h5")):
                np.testing.assert_array_equal(one, other)
            with h5py.File(self.path("whole_events.h5")) as one, h5py.File(self.path("part_events.h5")) as other:
                for name in ("onset", "end", "moment", "radiated_energy", "radiated_efficiency", "energy_residual",
                             "dissipated_energy"):
                    np.testing.assert_array_equal(one[name], other[name], err_msg=name)

    def test_refused(self):
        for options, message in ((("-fault_kernel", "half_space"), "-fault_kernel full_space"),
                                 (("-ts_type", "bathe"), "lapusta with -fault_medium waves"),
                                 (("-ts_adapt_type", "rl"), "lapusta, basic, dsp, heuristic or none"),
                                 (("-fault_kernel", "mirror"), "-fault_slip_components 1"),
                                 (("-fault_inertia", "yes", "-fault_viscosity", "radiation"), "-fault_inertia no"),
                                 (("-fault_opening", "yes"), "-fault_opening no"),
                                 (("-fault_waves_tolerance", 1e-9), "-fault_waves_tolerance is 1e-09")):
            said = self.tpv3(1500, *options, code=1)
            errors = [line for line in said.splitlines() if "error" in line]
            self.assertEqual(len(errors), 1, said)
            self.assertIn(message, errors[0])

    def test_cycle(self):
        """BP1-FD with cells of 200 m, up to its first event: by default within 0.03 years of the limit, 198.022 years
        by two methods, Adams' steps at 1e-5 and steps that bound slip at a twentieth of their bound; at their bound
        those are 0.1 years late. A restart among Adams' steps before the rupture goes on to the bit."""
        subprocess.run([sys.executable, os.path.join(SOURCE, "examples", "make_seas.py"), "bp1", self.path("c.h5"),
                        "--cell", "200"], check=True, stdout=subprocess.DEVNULL)
        options = ("-options_file", os.path.join(SOURCE, "examples", "seas_bp1.opts"), "-fault_nx", 1,
                   "-fault_nz", 200, "-fault_parameters", "c.h5", "-fault_medium", "waves", "-fault_progress", "no",
                   "-ts_max_time", 198.1 * 3.15576e7, "-fault_output_overwrite")
        whole, part = (("-fault_output", f"{name}.h5", "-fault_catalogue", f"{name}_events.h5")
                       for name in ("whole", "part"))
        said = self.fault(*options, *whole)
        self.assertAlmostEqual(self.get("whole_events.h5", "onset")[0] / 3.15576e7, 198.022, delta=0.03)
        self.assertLess(int(re.search(r"(?m)^products with K: +(\d+)", said)[1]), 12000)
        self.fault(*options, *part, "-ts_max_steps", 1000, "-fault_checkpoint", "state.h5", code=3)
        self.fault(*options, *part, "-fault_restart", "state.h5")
        for one, other in zip(self.last("whole.h5"), self.last("part.h5")):
            np.testing.assert_array_equal(one, other)

    def test_mirror(self):
        """A plane up to the ground slips as the lower half of one twice as wide in a full space, with its image above:
        with waves, whose memory has single precision, and without, where steps differ by their own error (5e-4): the
        fastest rate of the whole bounds them. The energy of its waves is half of that."""
        nz, nx = tpv3.shape_of(500)
        tpv5.make(self.path("half"), 500)
        stress = self.get("half_fields.h5", "initial_traction").reshape(nz, nx)
        self.hdf5("whole_fields.h5", initial_traction=np.vstack((stress[::-1], stress)))
        for medium, end, rounding in ("waves", 6, 1e-6), ("static", 20, 2e-3):
            double = "-fault_nz", 2 * nz, "-fault_length_z", 30e3, "-fault_kernel", "full_space"
            for name, more in (("half", ("-fault_nz", nz)), ("whole", double)):
                self.fault("-options_file", os.path.join(SOURCE, "examples", "tpv5.opts"), "-fault_nx", nx, *more,
                           "-fault_parameters", f"{name}_fields.h5", "-fault_progress", "no", "-fault_output",
                           f"{name}.h5", "-fault_catalogue", f"{name}_events.h5", "-fault_output_overwrite",
                           "-fault_output_precision", "double", "-ts_max_time", end, "-fault_medium", medium,
                           "-fault_operator", "fft")
            slip, whole = self.last("half.h5")[1].reshape(nz, nx), self.last("whole.h5")[1].reshape(2 * nz, nx)
            self.assertGreater(slip[0].max(), 0.5)
            np.testing.assert_allclose(slip, whole[nz:], rtol=0, atol=rounding * slip.max())
            if medium == "static":
                continue
            half, both = (self.get(f"{name}_events.h5", "radiated_energy")[0] for name in ("half", "whole"))
            self.assertAlmostEqual(2 * half / both, 1, delta=1e-5)

    def test_stops_and_starts_again(self):
        """Two patches with a barrier between them: waves of the first one's rupture start the second one's. Cells that
        stop have no rate at all, none slips back, some stop and start again, and hardly any slides for a single step:
        75 of 1,704 times."""
        nz, nx = tpv3.shape_of(500)
        x, z = np.meshgrid(tpv3.centres(tpv3.LENGTH, nx), tpv3.centres(tpv3.WIDTH, nz))
        first, second = np.hypot(x + 6e3, z) < 4e3, np.hypot(x - 4e3, z) < 4e3
        self.hdf5("two.h5", initial_traction=np.where(np.hypot(x + 6e3, z) < 1.6e3, 83e6,
                                                      np.where(first, 74e6, np.where(second, 78e6, 55e6))))
        self.tpv3(500, "-fault_parameters", "two.h5", "-fault_output", "r.h5", "-fault_output_precision", "double",
                  "-fault_output_time_interval", 0, "-fault_output_interval", 1,
                  "-fault_friction_slip", 0.2, "-ts_max_time", 12)
        with h5py.File(self.path("r.h5")) as file:
            slip, rate = file["fields/slip"][:].reshape(-1, nz, nx,
                                                        2)[..., 0], file["fields/slip_rate"][:].reshape(-1, nz, nx, 2)
        moves = (rate != 0).any(axis=3)
        starts = (moves[1:] & ~moves[:-1]).sum(axis=0)
        self.assertGreater(moves[:, second].any(axis=1).argmax(), 10)
        self.assertGreater(slip[-1][second].mean(), 1)
        self.assertGreater(starts.max(), 1)
        self.assertLess((moves[1:-1] & ~moves[:-2] & ~moves[2:]).sum(), 0.1 * starts.sum())
        self.assertFalse(moves[-1].any())
        self.assertGreaterEqual(np.diff(slip, axis=0).min(), 0)

if __name__ == "__main__":
    unittest.main()
