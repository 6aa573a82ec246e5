"""What a run says of each fault of a mesh by its label: moment rates, and the numbers of an event."""

import csv
import os
import sys
import unittest

from scripts import SOURCE, FaultTest

import h5py
import numpy as np

from slipstep import Catalogue, OutputError, Run

sys.path.insert(0, os.path.join(SOURCE, "examples"))
import make_mesh

os.environ.setdefault("OMPI_MCA_ess_singleton_isolated", "1")  # as in test_output_whole.py
G = 30e9
LABELS = np.array([-3, 7])
# Slip weakening without healing from below the strength, which the loading reaches on both faults, and another rake on
# each
RUN = ("-fault_mesh", "two.h5", "-fault_parameters", "fields.h5", "-fault_normal_stress", "50e6",
       "-fault_normal_stress_gradient", "0", "-fault_inertia", "no", "-fault_viscosity", "radiation", "-fault_initial",
       "traction", "-fault_loading_rate", "1e-9", "-fault_friction_residual", "0.5", "-fault_friction_drop", "0.1",
       "-fault_friction_slip", "0.05", "-fault_healing_time", "3e7", "-ts_adapt_type", "heuristic", "-ts_max_time",
       "8e8")
EVENTS = ("-fault_catalogue_maps", "-fault_catalogue")


def two_faults():
    """A listric fault, 7, of four planes and a bent one, -3, of two, 1.2 km east of it, in a random order: rows and
    labels."""
    listric = make_mesh.listric((4, 4), (4000, 3000), 1000, 1.0, 0.0, (80, 65))
    bent, _ = make_mesh.segmented((3, 3), (2000, 2500), 1000, 1.0, [0.0, 15.0], 75.0)
    bent[:, 1] += 1200
    order = np.random.default_rng(3).permutation(len(listric) + len(bent))
    return np.concatenate([listric, bent])[order], np.repeat([7, -3], (len(listric), len(bent)))[order]


class Faults(FaultTest):
    def setUp(self):
        super().setUp()
        self.rows, self.label = two_faults()
        make_mesh.write(self.path("two.h5"), self.rows, self.label)
        chance = np.random.default_rng(11)
        self.hdf5("fields.h5", initial_traction=50e6 * (0.52 + 0.06 * chance.random(len(self.rows))),
                  rake=np.where(self.label == 7, 90.0, 30.0))

    def test_moment_rates(self):
        """G times area times slip rate, summed over the cells of each label, and the attribute that says which is
        which."""
        self.fault(*RUN, "-ts_max_steps", 60, "-fault_output_interval", 1, "-fault_output", "run.h5", code=3)
        run = Run(self.path("run.h5"))
        np.testing.assert_array_equal(run.faults, LABELS)
        rate, area = run.field("slip_rate")[1], self.rows[:, 3] * self.rows[:, 4]
        expected = np.stack([G * (rate * area)[:, self.label == label].sum(axis=1) for label in LABELS], axis=1)
        self.assertEqual(run.series["moment_rate"].shape, expected.shape)
        self.assertTrue((expected > 0).any(axis=0).all())
        np.testing.assert_allclose(run.series["moment_rate"], expected, rtol=1e-13)  # rounding of twenty terms
        # moments are those of slip since the start, also where that has displacements
        self.fault("-fault_mesh", "two.h5", "-ts_max_steps", 1, "-fault_output", "critical.h5", code=3)
        moment, mean = (Run(self.path("critical.h5")).series[name][0] for name in ("moment", "mean_displacement"))
        self.assertEqual(moment.shape, (2,))
        self.assertLess(mean, -1e-3)
        self.assertLess(abs(moment).max(), 1e-12 * G * area.sum() * abs(mean))

    def test_which_faults_there_are(self):
        """Without labels planes are faults, and many of them the parts of one; a grid is one; labels may be many."""
        many = np.array([[500.0 * k, 0, 600, 500, 400, 90, 60 + k] for k in range(30)])
        few = ("-fault_initial", "traction", "-fault_loading_rate", "1e-9", "-ts_max_time", "1", "-fault_output",
               "run.h5", "-fault_inertia", "no", "-fault_viscosity", "radiation")
        for rows, label, expected in ((self.rows, None, np.arange(6)), (many[:21], None, np.arange(21)),
                                      (many[:22], None, [0]),
                                      (many, np.arange(30)[::-1] * 10 - 40, np.arange(30) * 10 - 40),
                                      (many, np.full(30, 5), [5])):
            make_mesh.write(self.path("mesh.h5"), rows, label)
            self.fault("-fault_mesh", "mesh.h5", *few)
            run = Run(self.path("run.h5"))
            np.testing.assert_array_equal(run.faults, expected)
            self.assertEqual(run.series["moment_rate"].shape[1], len(expected))
            self.assertEqual(set(run.mesh["fault"]), set(expected))
        self.fault("-fault_nx", 2, *few)
        self.assertEqual(Run(self.path("run.h5")).faults.tolist(), [0])
        make_mesh.write(self.path("mesh.h5"), np.array([[500.0 * k, 0, 600, 500, 400, 90, 60] for k in range(4097)]),
                        np.arange(4097))
        said = self.fault("-fault_mesh", "mesh.h5", *few, code=1)
        self.assertIn("/fault in mesh.h5 (-fault_mesh) has 4097 labels", said)

    def check_events(self, name):
        """Sums over the faults are the event's numbers, and each fault's those of its cells in the maps."""
        catalogue = Catalogue(self.path(name))
        event, mesh = catalogue.event, catalogue.mesh
        slip, rupture, area = catalogue.map("slip"), catalogue.map("rupture_time"), mesh["length"] * mesh["width"]
        np.testing.assert_array_equal(catalogue.faults, LABELS)
        np.testing.assert_array_equal(event["fault"], mesh["fault"][event["cell"]])
        # of at most 34 terms, each rounded
        near = {"rtol": 1e-12, "equal_nan": False}
        np.testing.assert_allclose(event["fault_moment"].sum(axis=1), event["moment"], **near)
        np.testing.assert_allclose(event["fault_area"].sum(axis=1), event["area"], **near)
        np.testing.assert_allclose(event["fault_dissipated_energy"].sum(axis=1), event["dissipated_energy"], **near)
        for mean in ("mean_slip", "stress_drop"):
            np.testing.assert_allclose(np.nansum(event["fault_area"] * event[f"fault_{mean}"], axis=1),
                                       event["area"] * event[mean], **near)
        for k, label in enumerate(LABELS):
            own = mesh["fault"] == label
            broke = np.isfinite(rupture) & own
            any_broke = broke.any(axis=1)
            of = {column: catalogue.of_fault(column, label)
                  for column in ("moment", "area", "mean_slip", "stress_drop", "onset", "cell")}
            np.testing.assert_array_equal(of["moment"], event["fault_moment"][:, k])
            self.assertTrue((abs(of["moment"] - G * (slip * area)[:, own].sum(axis=1)) < 1e-12 * event["moment"]).all())
            np.testing.assert_allclose(of["area"], (broke * area).sum(axis=1), rtol=1e-13, atol=0)
            for column in ("mean_slip", "stress_drop", "onset"):
                np.testing.assert_array_equal(np.isfinite(of[column]), any_broke)
            np.testing.assert_array_equal(of["cell"] >= 0, any_broke)
            for n in np.flatnonzero(any_broke):
                self.assertAlmostEqual(of["mean_slip"][n] / ((slip[n] * area)[broke[n]].sum() / of["area"][n]), 1,
                                       delta=1e-12)
                self.assertEqual(of["onset"][n], event["onset"][n] + rupture[n][broke[n]].min())
                self.assertTrue(broke[n][of["cell"][n]])
        # one is the other and a time of rounding
        np.testing.assert_allclose(np.nanmin(event["fault_onset"], axis=1), event["onset"], rtol=1e-15, atol=0)
        column = np.searchsorted(LABELS, event["fault"])
        np.testing.assert_array_equal(event["fault_cell"][np.arange(catalogue.count), column], event["cell"])
        # the mean vector of what ruptured, along strike and up dip of each cell
        angle = np.radians(np.where(mesh["fault"] == 7, 90.0, 30.0))
        vector = np.where(np.isfinite(rupture), slip * area * event["direction"][:, None],
                          0) @ np.stack([np.cos(angle), np.sin(angle)], axis=1)
        np.testing.assert_allclose(event["rake"], np.degrees(np.arctan2(vector[:, 1], vector[:, 0])), rtol=1e-13)
        return catalogue

    def test_numbers_of_events(self):
        """And the line of an event has the name that the mesh's file gives to its fault, if it does."""
        with h5py.File(self.path("two.h5"), "r+") as file:
            file["fault"].attrs["names"] = "70 No fault; 7 Listric (north)"
        said = self.fault(*RUN, *EVENTS, "events.h5")
        catalogue = self.check_events("events.h5")
        both = np.isfinite(catalogue.event["fault_onset"]).all(axis=1)
        self.assertTrue(both.any() and not both.all())  # events of both faults and of one
        self.assertEqual(set(catalogue.event["fault"]), {-3, 7})
        for n, label in enumerate(catalogue.event["fault"]):
            name = {-3: "-3", 7: r"7 Listric \(north\)"}[label]
            self.assertRegex(said, rf"(?m)^event {n + 1}  t .*  Mw [\d.]+  fault {name}  x ")

    def test_ranks(self):
        """Steps of a prescribed length, whose rounding 200 of them amplify; energies differ by what remains of larger
        ones."""
        run = (*RUN, "-ts_adapt_type", "none", "-ts_dt", "0.25", "-ts_max_time", "40", "-fault_initial_unstable",
               *EVENTS)
        with h5py.File(self.path("fields.h5"), "r+") as file:
            file["initial_traction"][...] = np.where(self.rows[:, 2] < 2500, 31e6, 29e6)
        for ranks in (1, 2, 4):
            self.fault(*run, f"{ranks}.h5", ranks=ranks)
        one = self.check_events("1.h5")
        self.assertTrue(one.count >= 1 and np.isfinite(one.event["fault_onset"]).all())
        for ranks in (2, 4):
            other = self.check_events(f"{ranks}.h5")
            for name in one.event:
                if name not in ("energy_residual", "kinetic_energy", "loading_work"):
                    np.testing.assert_allclose(other.event[name], one.event[name], rtol=1e-8, err_msg=name)

    def test_restart_within_events(self):
        """Bit by bit, also from a checkpoint within an event, where one fault has broken."""
        self.fault(*RUN, *EVENTS, "whole.h5", "-fault_output", "run.h5")
        whole, run = Catalogue(self.path("whole.h5")), Run(self.path("run.h5"))
        event = int(np.flatnonzero(np.isfinite(whole.event["fault_onset"]).all(axis=1))[0])
        begin, second, end = whole.event["onset"][event], whole.event["fault_onset"][event].max(), whole.event["end"][
            event]
        time = run.series["time"]
        for moment in ((begin + second) / 2, (second + end) / 2, end + 1e4):
            steps = np.searchsorted(time, moment) - 1  # the first row is the start
            self.assertTrue(begin < time[steps] < second or moment > second)
            for name in os.listdir(self.folder.name):
                if name.startswith(("short", "state")):
                    os.remove(self.path(name))
            self.fault(*RUN, *EVENTS, "short.h5", "-fault_checkpoint", "state.h5", "-ts_max_steps", steps, code=3)
            self.fault(*RUN, *EVENTS, "short.h5", "-fault_restart", "state.h5")
            short = Catalogue(self.path("short.h5"))
            self.assertEqual(set(short.event), set(whole.event))
            for name, values in whole.event.items():
                np.testing.assert_array_equal(short.event[name], values, err_msg=f"{name}, {moment}")
        # the file of other faults is not gone on with
        with h5py.File(self.path("short.h5"), "r+") as file:
            values = file["fault_moment"][...]
            del file["fault_moment"]
            file.create_dataset("fault_moment", data=np.column_stack([values, values]), maxshape=(None, 4))
        said = self.fault(*RUN, *EVENTS, "short.h5", "-fault_restart", "state.h5", code=1)
        self.assertIn("-fault_catalogue", said)

    def test_backward_slip_of_one_fault(self):
        """Of one fault there is nothing for each fault; what slips backward along its direction has the opposite
        rake."""
        for rake, sign, expected in ((0, 1, 0), (0, -1, 180), (90, -1, -90), (-120, -1, 60), (180, -1, 0), (30, 1, 30)):
            self.fault("-fault_dip", 60, "-fault_rake", rake, "-fault_initial", "traction", "-fault_initial_traction",
                       sign * 16e6, "-fault_initial_unstable",
                       "-fault_normal_stress", "20e6", "-fault_normal_stress_gradient", "0", "-fault_normal_coupling",
                       "no", "-ts_max_time", 30, "-fault_catalogue", "events.h5")
            catalogue = Catalogue(self.path("events.h5"))
            self.assertEqual(catalogue.count, 1)
            self.assertEqual(catalogue.event["direction"][0], sign)
            self.assertAlmostEqual(catalogue.event["rake"][0], expected, delta=1e-12)
            self.assertEqual((catalogue.event["fault"].tolist(), catalogue.faults.tolist()), ([0], [0]))
            self.assertFalse([name for name in catalogue.event if name.startswith("fault_")])
            np.testing.assert_array_equal(catalogue.of_fault("moment", 0), catalogue.event["moment"])

    def test_csv_and_older_files(self):
        self.fault(*RUN, *EVENTS, "events.h5", "-ts_max_time", "3e8")
        catalogue = Catalogue(self.path("events.h5"))
        self.assertGreater(catalogue.count, 0)
        with self.assertRaisesRegex(OutputError, "no fault 5"):
            catalogue.of_fault("moment", 5)
        with self.assertRaisesRegex(OutputError, "/fault_rake"):
            catalogue.of_fault("rake", 7)
        rows = list(csv.DictReader(self.script("catalogue-csv", self.path("events.h5")).stdout.splitlines()))
        self.assertEqual([int(row["fault"]) for row in rows], catalogue.event["fault"].tolist())
        self.assertEqual([float(row["rake [degrees]"]) for row in rows], catalogue.event["rake"].tolist())
        for label in LABELS:
            for name, unit in (("moment", " [N m]"), ("cell", ""), ("onset", " [s]")):
                np.testing.assert_array_equal([float(row[f"fault_{name} {label}{unit}"]) for row in rows],
                                              catalogue.of_fault(name, label))
        # as files were before
        with h5py.File(self.path("events.h5"), "r+") as file:
            del file.attrs["faults"]
            for name in [name for name in file if name.startswith("fault")] + ["rake"]:
                del file[name]
        older = Catalogue(self.path("events.h5"))
        self.assertEqual(older.faults.tolist(), [-3, 7])
        done = self.script("catalogue-csv", self.path("events.h5"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("fault", done.stdout)


if __name__ == "__main__":
    unittest.main()
