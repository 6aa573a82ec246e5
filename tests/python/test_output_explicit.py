#!/usr/bin/env python3
"""What the output of an explicit run of rate-and-state friction holds: attempts and what they cost, moment rate and the
parameters that it is made of, pore pressure; also of planes, and of a run that goes on from a checkpoint."""
import unittest

from scripts import TWO_PLANES, FaultTest

import h5py
import numpy as np

YEAR = 31557600.0
RUN = ["-fault_nx", "6", "-fault_nz", "4", "-fault_length_x", "12e3", "-fault_length_z", "8e3", "-fault_friction_law",
       "rate_and_state", "-fault_normal_stress", "50e6", "-fault_normal_stress_gradient", "0", "-fault_loading_rate",
       "1e-9", "-fault_initial_rate", "1e-10", "-fault_shear_modulus", "32e9", "-fault_friction_slip", "0.05"]
ADAMS, RK = ["-ts_adapt_type", "basic"], ["-ts_type", "rk", "-ts_rk_type", "3bs", "-ts_adapt_type", "basic"]


class Explicit(FaultTest):
    def fault(self, name, *options, **more):
        return super().fault(*RUN, "-fault_output", name, *options, **more)

    def test_attempts(self):
        """Rows are all attempts, in order; an attempt has the right-hand sides of its integrator, two of Adams'
        formulas and one where it was rejected, three of the pair, which has its first from the step before."""
        for name, options, costs in (("adams.h5", ADAMS, (2, 1)), ("rk.h5", RK, (3, 3))):
            said = self.fault(name, *options, "-ts_dt", "1e8", "-ts_max_time", str(20 * YEAR))
            with h5py.File(self.path(name)) as file:
                steps = {key: file[f"steps/{key}"][...] for key in file["steps"]}
                result, series = dict(file["result"].attrs), file["series/time"][...]
            accepted = steps["accepted"].astype(bool)
            self.assertEqual((accepted.sum(), (~accepted).sum()), (result["accepted"], result["rejected"]))
            self.assertGreater(result["rejected"], 0)
            begins = series[np.cumsum(accepted) - accepted]
            np.testing.assert_array_equal(steps["time"], begins)
            # a step of 1e8 s of which only the end is known to 1e-16 of 20 years
            np.testing.assert_allclose(steps["dt"][accepted], np.diff(series), rtol=1e-9, atol=1e-6)
            judged = steps["converged"] == 1
            self.assertTrue((steps["error"][~accepted & judged] > 1).all() and (steps["error"][accepted] <= 1).all())
            self.assertTrue((steps["error"][accepted] > 0).all() and (steps["wall"] >= 0).all())
            sides = steps["right_hand_sides"]
            # the first step also has the derivative at its start, in each attempt of the pair; others the stages of
            # attempts before that a stage ended
            whole = judged & np.concatenate([[False], judged[:-1]]) & (steps["time"] > 0)
            self.assertEqual(set(sides[whole & accepted]), {costs[0]})
            self.assertEqual(set(sides[whole & ~accepted]), {costs[1]})
            self.assertEqual(sides.sum(), result["right_hand_sides"])
            self.assertEqual(result["products_k"], steps["products_k"].sum())
            self.assertGreaterEqual(result["products_k"], result["right_hand_sides"])
            self.assertEqual(set(steps["products_k"][whole & accepted]), {costs[0]})
            self.assertEqual(result["products_h"], 0)
            self.assertNotIn("Bathe", said)
            self.assertRegex(said, rf"(?m)^right-hand sides: +{result['right_hand_sides']:.0f}\nproducts with K: "
                             rf"+{result['products_k']:.0f}$")

    def test_moment_of_planes(self):
        """A column for each of two planes that slip differently, of a mesh in any order, on ranks, and over a
        restart."""
        self.make_mesh("mesh", TWO_PLANES)
        with h5py.File(self.path("mesh"), "r+") as file:
            cells = file["cells"][...]
            cells = cells[np.random.default_rng(1).permutation(len(cells))]
            file["cells"][...] = cells
        planes = [np.flatnonzero(cells[:, 1] == y) for y in dict.fromkeys(cells[:, 1])]
        self.assertEqual(len(planes), 2)
        self.hdf5("fields", friction_slip=np.where(cells[:, 1] == 0, 0.1, 0.2))
        more = ["-fault_mesh", "mesh", "-fault_parameters", "fields", "-ts_adapt_type", "heuristic", "-ts_max_time",
                "15", "-fault_output_interval", "1"]
        for ranks in (1, 2):
            super().fault(*more, "-fault_output", "planes.h5", ranks=ranks)
            with h5py.File(self.path("planes.h5")) as file:
                v, rate = file["fields/slip_rate"][...], file["series/moment_rate"][...]
                area = file["parameters"].attrs["shear_modulus"] * cells[:, 3] * cells[:, 4]
                for k, plane in enumerate(planes):  # sums of 20 cells
                    np.testing.assert_allclose(rate[:, k], v[:len(rate), plane] @ area[plane], rtol=1e-13)
                self.assertEqual(rate.shape[1], 2)
                self.assertGreater(np.abs(rate[:, 0] - rate[:, 1]).max(), 0.01 * np.abs(rate).max())
        super().fault(*more, "-fault_output", "part.h5", "-fault_checkpoint", "state", "-ts_max_steps", "9", ranks=2,
                      code=3)
        super().fault(*more, "-fault_output", "part.h5", "-fault_restart", "state", ranks=2)
        np.testing.assert_array_equal(self.get("part.h5", "series/moment_rate"), rate)

    def test_moment(self):
        """G sum A v of /fields and /parameters, with the sign of the slip; and the counts of a run in two parts."""
        fields = ["-fault_output_interval", "1", "-fault_output_fields", "slip_rate"]
        for sign in (1, -1):
            name = f"{sign}.h5"
            more = ["-ts_max_time", str(30 * YEAR), *fields, *ADAMS, "-fault_loading_rate", str(sign * 1e-9),
                    "-fault_initial_rate", str(sign * 1e-10)]
            self.fault(name, *more)
            with h5py.File(self.path(name)) as file:
                parameters = dict(file["parameters"].attrs)
                v, rate = file["fields/slip_rate"][...], file["series/moment_rate"]
                self.assertEqual((rate.shape[1:], rate.attrs["units"]), ((1,), b"N m/s"))
                moment = parameters["shear_modulus"] * parameters["area"] * v.mean(axis=(1, 2))
                np.testing.assert_allclose(rate[:, 0], moment[:len(rate)], rtol=1e-12)
                self.assertTrue((sign * rate[:, 0] > 0).all())
                whole = {key: file[key][...] for key in ("series/moment_rate", "steps/right_hand_sides",
                                                         "steps/error")}, dict(file["result"].attrs)
        self.assertEqual((parameters["shear_modulus"], parameters["poisson_ratio"], parameters["area"],
                          parameters["length_x"], parameters["nx"], parameters["friction_law"], parameters["inertia"]),
                         (32e9, 0.25, 96e6, 12e3, 6, b"rate_and_state", 0))
        self.assertNotIn("normal_stress", parameters)  # cell by cell in /mesh
        self.fault("two.h5", *more, "-ts_max_steps", "25", "-fault_checkpoint", "state", code=3)
        self.fault("two.h5", *more, "-fault_restart", "state")
        with h5py.File(self.path("two.h5")) as file:
            for key, values in whole[0].items():
                np.testing.assert_array_equal(file[key], values)
            self.assertEqual(file["result"].attrs["right_hand_sides"], whole[1]["right_hand_sides"])

    def test_pore_pressure(self):
        """p* E1(r^2/(4 D t)) of a source far from the cell that is looked at, and none where there is none"""
        source = ["-fault_injection", "1000,1000", "-fault_injection_pressure", "1e5", "-fault_injection_diffusivity",
                  "10"]
        self.fault("run.h5", *source, *ADAMS, "-ts_max_time", "1e6", "-fault_output_fields", "pore_pressure")
        with h5py.File(self.path("run.h5")) as file:
            time, p = file["fields/time"][...], file["fields/pore_pressure"]
            self.assertEqual((sorted(file["fields"]), p.attrs["units"]), (["pore_pressure", "time", "x", "z"], b"Pa"))
            self.assertTrue((p[0] == 0).all())
            x = (10e3 ** 2 + 6e3 ** 2) / (4 * 10 * time[-1])  # to the centre of the last cell, 11 km and 7 km
            series = -np.euler_gamma - np.log(x) - sum((-x) ** k / (k * np.prod(np.arange(1.0, k + 1)))
                                                       for k in range(1, 40))
            self.assertAlmostEqual(p[-1, 3, 5] / (1e5 * series), 1, delta=1e-9)
        said = self.fault("none.h5", "-fault_output_fields", "slip_rate,pore_pressure", code=1)
        self.assertIn("-fault_output_fields has pore_pressure", said)


if __name__ == "__main__":
    unittest.main()
