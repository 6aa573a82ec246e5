#!/usr/bin/env python3
"""Pore fluid that diffuses in a fault and is coupled to slip: a block whose equations scipy solves by itself, the order
in time, the error estimate; the balance of fluid, restarts and ranks of all laws, loads and meshes; closed forms; and
faults that meet."""

import math
import os
import sys
import unittest

from scripts import SOURCE, FaultTest
from meshfiles import plane, write_hdf5

import h5py
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import exp1

sys.path.insert(0, os.path.join(SOURCE, "examples"))
import seas_bp8

# a block on a spring under rate-and-state friction, from whose border fluid drains the faster the more it slips
K, SIGMA, A, B, DC, F0, V0, G, RHO = 4e8, 5e7, 0.01, 0.015, 1e-3, 0.6, 1e-6, 30e9, 2500.0
RATE, DRIVE, TRACTION, SIDE = 1e-6, 2e-6, 0.612 * 4e7, 10.0
START, MOST, SLIP, HEALING, SCALE, ETA, STORAGE, PRESSURE = 1e-15, 1e-13, 2e-3, 2e4, 3e7, 1e-3, 5e-9, 1e7
BLOCK = ("-fault_nx", 1, "-fault_nz", 1, "-fault_length_x", SIDE, "-fault_length_z", SIDE, "-fault_stiffness_file",
         "k.h5", "-fault_friction_law", "rate_and_state", "-fault_friction_a", A, "-fault_friction_b", B,
         "-fault_friction_slip", DC, "-fault_normal_stress", SIGMA, "-fault_normal_stress_gradient", 0,
         "-fault_initial", "traction", "-fault_initial_traction", TRACTION, "-fault_initial_rate", RATE,
         "-fault_loading_rate", DRIVE, "-fault_permeability", START, "-fault_pore_compressibility", STORAGE / 0.1,
         "-fault_fluid_border", "open", "-fault_fluid_pressure", PRESSURE, "-fault_permeability_law", "valve",
         "-fault_permeability_maximum", MOST, "-fault_permeability_slip", SLIP, "-fault_permeability_healing_time",
         HEALING, "-fault_permeability_stress", SCALE, "-fault_fluid_tolerance", 1e-8, "-fault_output", "o.h5",
         "-fault_output_overwrite", "yes", "-fault_output_fields", "slip,pore_pressure,slip_rate",
         "-fault_output_interval", 1)

# a plane of 30 cells or of 40 triangles near failure with two wells, one of which lies over several cells
WELLS = """well,x,y,z,hours,m3/day,spread
A,500,0,2400,0,40,0
A,500,0,2400,30,0,0
A,500,0,2400,60,-20,0
B,300,0,2200,10,25,150
B,300,0,2200,50,0,150
"""
HELD = "well,x,y,z,hours,MPa\nA,500,0,2400,0,5\nA,500,0,2400,30,2\nB,300,0,2200,20,4\n"
ANY = ("-fault_normal_stress 40e6 -fault_normal_stress_gradient 0 -fault_inertia no -fault_viscosity radiation "
       "-fault_permeability 1e-14 -fault_permeability_ratio 0.5 -ts_max_time 4d -fault_progress no -fault_output "
       "run.h5 -fault_output_overwrite -fault_output_fields slip,pore_pressure -fault_output_precision double "
       "-fault_output_interval 1000000").split()
GRID = "-fault_nx 6 -fault_nz 5 -fault_length_x 1000 -fault_length_z 800 -fault_depth_top 2000".split()
SMOOTH = ("-fault_friction_law rate_and_state -fault_friction_a 0.01 -fault_friction_b 0.014 -fault_friction_slip 1e-3 "
          "-fault_initial traction -fault_initial_traction 23e6 -fault_initial_rate 1e-9").split()
WEAK = ("-fault_friction_law linear_slip_weakening -fault_friction_slip 0.05 -fault_initial traction "
        "-fault_initial_traction 22.5e6").split()
BY_SLIP = "-fault_permeability_maximum 1e-12 -fault_permeability_slip 1e-3 -fault_permeability_healing_time 1e5".split()
LAWS = {"constant": [], "slip": BY_SLIP, "stress": ["-fault_permeability_stress", 1e7],
        "valve": [*BY_SLIP, "-fault_permeability_stress", 1e7]}
RATES, LEAK, OPEN = ["-fault_wells", "rates.csv"], ["-fault_leakoff", 1e-15], ["-fault_fluid_border", "open"]
DILATES = ["-fault_dilatancy", 1e-4]
CARTER = ["-fault_carter_leakoff", 1e-13]
WAVES = "-fault_medium waves -fault_kernel full_space -ts_max_time 2h".split()


def law(name):
    return ["-fault_permeability_law", name, *LAWS[name]]


VALVE = law("valve")
# name, options, whether a restart is compared
CASES = [
    *((f"{name}, {method}", GRID + SMOOTH + law(name) + RATES + LEAK + OPEN + ["-ts_type", method], True)
      for name in LAWS for method in ("adams", "bathe")),
    *((f"{name}, dilates", GRID + SMOOTH + law(name) + RATES + LEAK + OPEN + DILATES, name in ("constant", "valve"))
      for name in LAWS),
    ("closed", GRID + SMOOTH + RATES, False),
    ("reached", GRID + SMOOTH + RATES + CARTER, True),
    ("reached, valve, bathe", GRID + SMOOTH + VALVE + RATES + CARTER + ["-ts_type", "bathe"], True),
    ("pressures in wells",
     GRID + SMOOTH + VALVE + LEAK + ["-fault_wells", "held.csv", "-fault_fluid_pressure", 1e6], True),
    ("source, border held",
     GRID + SMOOTH + VALVE + ["-fault_fluid_source", 1e-10, "-fault_border_pressure", 2e5], False),
    ("long first step", GRID + SMOOTH + VALVE + RATES + LEAK + OPEN + DILATES + ["-ts_dt", "1d"], False),
    ("waves", GRID + SMOOTH + VALVE + RATES + DILATES + WAVES, True),
    ("weakens with slip", GRID + WEAK + VALVE + RATES + LEAK, True),
    ("weakens, rests", GRID + WEAK + RATES + LEAK, False),
    ("rkc", GRID + WEAK + VALVE + RATES + ["-ts_type", "rkc", "-ts_max_time", "6h"], False),
    ("moreau",
     GRID + WEAK + VALVE + RATES + ["-ts_type", "moreau", "-fault_inertia", "yes", "-ts_max_time", 60], False),
    ("rectangles", ["-fault_mesh", "rectangles.h5"] + SMOOTH + VALVE + RATES + OPEN + DILATES, False),
    ("triangles", ["-fault_mesh", "triangles.h5"] + SMOOTH + VALVE + RATES + OPEN + DILATES, True),
]


def block(end, most=MOST):
    """Slip, theta, p and k* of the block at these times [4, n]; radiation damps the rate beyond that of the drive"""
    damping = math.sqrt(G * RHO) / 2

    def rate(t, slip, theta, p):
        load = TRACTION + K * (DRIVE * t - slip)
        grip = (F0 + B * math.log(V0 * theta / DC)) / A
        return math.exp(brentq(lambda x: load - damping * (math.exp(x) - DRIVE) - max(SIGMA - p, 0) * A
                               * math.asinh(math.exp(x + grip) / (2 * V0)), -60, 5, xtol=1e-14))

    def change(t, y):
        slip, theta, p, k = y
        v = rate(t, slip, theta, p)
        now = k * math.exp(-(SIGMA - p - SIGMA) / SCALE)
        return [v, 1 - v * theta / DC, -8 * now / ETA * p / (STORAGE * SIDE**2),
                v / SLIP * (most - k) + (START - k) / HEALING]

    grip = TRACTION / ((SIGMA - PRESSURE) * A)  # the state balances the traction at the rate
    theta = DC / V0 * math.exp((A * math.log(2 * V0 / RATE * math.sinh(grip)) - F0) / B)
    return solve_ivp(change, (0, max(end)), [0, theta, PRESSURE, START], "Radau", t_eval=end, rtol=1e-11,
                     atol=[1e-16, 1e-9, 1e-3, 1e-27]).y


class Fluid(FaultTest):
    def setUp(self):
        super().setUp()
        self.hdf5("k.h5", stiffness=[[K]])

    def last(self, name="o.h5"):
        with h5py.File(self.path(name)) as file:
            return {key: data[-1] for key, data in file["fields"].items() if key not in "xz"}

    def test_carter(self):
        """Fluid that enters everywhere at a constant rate and leaks by Carter's law once p has risen above a level:
        dp/dt = q - a p/v with v the root of the time since then, so that dp/dv = 2 q v - 2 a p. Some tens of steps,
        each with an error of the tolerance 1e-6 at most."""
        q, a, storage, end = 1.0, 1e-3, 1e-9, 1e6
        for level in (0.0, 1e5):
            self.fault("-fault_nx", 1, "-fault_nz", 2, "-fault_length_x", 100, "-fault_length_z", 200,
                       "-fault_normal_stress", 5e7, "-fault_normal_stress_gradient", 0, "-fault_friction_law",
                       "rate_and_state", "-fault_creep", 1, "-fault_loading_rate", 1e-12, "-fault_permeability", 1e-14,
                       "-fault_pore_compressibility", storage / 0.1, "-fault_fluid_source", q * storage,
                       "-fault_carter_leakoff", a * storage, "-fault_carter_pressure", level,
                       "-fault_fluid_tolerance", 1e-6, "-ts_max_time", end, "-fault_output", "o.h5",
                       "-fault_output_overwrite", "yes", "-fault_output_fields", "pore_pressure")
            v = math.sqrt(end - level / q)
            exact = q / a * v - q / (2 * a**2) + (level + q / (2 * a**2)) * math.exp(-2 * a * v)
            with self.subTest(level=level):
                np.testing.assert_allclose(self.last()["pore_pressure"], exact, rtol=1e-5)

    def test_line(self):
        """Fluid that enters at a constant rate in the middle of a line: p = (q/T) sqrt(D t) ierfc(r/sqrt(4 D t))
        (Carslaw and Jaeger 1959), means of cells by differences of its integral, but for the cell of the source, over
        which the rate is spread. Cells of a third: errors fall by 9 or more."""
        k, eta, storage, rate, end = 1e-14, 1e-3, 1e-9, 1e-6, 2e6  # per metre along the fault: rate [m^2/s]
        spread = math.sqrt(4 * k / eta / storage * end)

        def integral(r):  # of ierfc(r/spread) from 0 to r
            z = r / spread
            return spread * ((1 + 2 * z * z) * math.erf(z) / 4 + z * math.exp(-z * z) / (2 * math.sqrt(math.pi))
                             - z * z / 2)

        errors = []
        for n in (25, 75, 225):
            cell = 2000.0 / n
            source = np.zeros((n, 1))
            source[n // 2] = rate / cell
            self.hdf5("f.h5", fluid_source=source)
            self.fault("-fault_nx", 1, "-fault_nz", n, "-fault_length_x", 100, "-fault_length_z", 2000,
                       "-fault_normal_stress", 5e7, "-fault_normal_stress_gradient", 0, "-fault_friction_law",
                       "rate_and_state", "-fault_creep", 1, "-fault_loading_rate", 1e-12, "-fault_permeability", k,
                       "-fault_pore_compressibility", storage / 0.1, "-fault_parameters", "f.h5",
                       "-fault_fluid_tolerance", 1e-5, "-ts_max_time", end, "-fault_output", "o.h5",
                       "-fault_output_overwrite", "yes", "-fault_output_fields", "pore_pressure")
            edges = np.abs((np.arange(n + 1) - n / 2) * cell)
            whole = np.array([integral(r) for r in edges])
            exact = np.abs(np.diff(whole))
            exact *= rate * eta / k * spread / 2 / cell
            error = np.abs(self.last()["pore_pressure"].ravel() - exact)
            error[n // 2] = 0
            errors.append(error.max() / exact.max())
        self.assertLess(errors[2], 5e-4)
        for before, after in zip(errors, errors[1:]):
            self.assertTrue(7 < before / after < 13, errors)

    def test_order(self):
        """Steps that are halved: the errors of slip and pressure fall by 4 at least, and less than by 10 at order 3,
        which Adams' formulas have at first."""
        end = 2000.0
        slip, _, pressure, _ = block([end])[:, 0]
        for method in ("adams", "bathe"):
            errors = []
            for h in (40, 20, 10):
                self.fault(*BLOCK, "-ts_type", method, "-ts_adapt_type", "none", "-ts_dt", h, "-ts_max_time", end,
                           "-fault_fluid_tolerance", 1e-10)
                now = self.last()
                errors.append([abs(now[key].item() / exact - 1) for key, exact in
                               (("pore_pressure", pressure), ("slip", slip))])
            with self.subTest(method=method):
                self.assertLess(max(errors[2]), 5e-6)
                for before, after in zip(errors, errors[1:]):
                    self.assertTrue(all(3 < a / b < 10 for a, b in zip(before, after)), errors)

    def test_estimate(self):
        """One step from the start: the error of the pressure that friction has seen, and its estimate, that of the
        step, where that of friction is smaller. A tolerance of 1 accepts it."""
        for h in (10.0, 20.0, 40.0, 80.0):
            self.fault(*BLOCK, "-fault_permeability_maximum", 2 * MOST, "-ts_type", "bathe", "-ts_adapt_type", "basic",
                       "-ts_dt", h, "-ts_max_time", h, "-ts_rtol", 1)
            (estimate,) = self.get("o.h5", "steps/error")
            true = self.last()["pore_pressure"].item() - block([h], 2 * MOST)[2, 0]
            with self.subTest(h=h):
                self.assertTrue(0.5 < estimate.item() * SIGMA * B / true < 2, (estimate, true))


class Mass(FaultTest):
    def setUp(self):
        super().setUp()
        self.put("rates.csv", WELLS)
        self.put("held.csv", HELD)
        self.make_mesh("rectangles.h5", "graded --cells 6 4 --size 1000 800 --top 2000 --ratio 3")
        write_hdf5(self.path("triangles.h5"), *plane((5, 4), (200, 200), 0, 90, (0, 0, 2000)))

    def series(self, *options, **more):
        """The series of a run, and its last fields; fluid that was injected is stored or has left to a thousand
        roundings of the largest volume, of some thousand that are added."""
        self.fault(*ANY, *options, **more)
        with h5py.File(self.path("run.h5")) as file:
            run = {key: data[...] for key, data in file["series"].items()}
            run.update((f"last {key}", file["fields"][key][-1]) for key in ("slip", "pore_pressure"))
        left = run["injected_volume"] - run["stored_volume"] - run["leaked_volume"] - run["border_volume"]
        scale = max(abs(run[key]).max() for key in run if key.endswith("_volume"))
        self.assertGreater(scale, 0)
        self.assertLess(abs(left).max(), 2e-13 * scale)
        return run

    def test_cost(self):
        """A run that goes on costs what the unbroken one does, whatever factorisations are at hand."""
        options = [*ANY, *GRID, *SMOOTH, *RATES, *LEAK]
        self.fault(*options)
        cost, results = self.get("run.h5", "steps/cost"), self.results()
        self.assertAlmostEqual(results["injected_volume"], (40 * 30 + 25 * 40 - 20 * 36) / 24, delta=1e-10)
        self.assertGreater(results["largest_pressure"], 1e6)
        self.fault(*options, "-ts_max_steps", len(cost) // 2, "-fault_checkpoint", "state", code=3)
        self.fault(*options, "-fault_restart", "state")
        self.assertEqual(self.get("run.h5", "steps/cost").tobytes(), cost.tobytes())
        again = self.results()
        for key in ("injected_volume", "stored_volume", "leaked_volume", "border_volume", "largest_pressure"):
            self.assertEqual(again[key], results[key], key)

    def results(self):
        with h5py.File(self.path("run.h5")) as file:
            return dict(file["result"].attrs)

    def test_balance(self):
        for name, options, restart in CASES:
            with self.subTest(case=name):
                whole = self.series(*options)
                if not restart:
                    continue
                steps = len(whole["time"]) // 2
                self.fault(*ANY, *options, "-ts_max_steps", steps, "-fault_checkpoint", "state", code=3)
                for key, value in self.series(*options, "-fault_restart", "state").items():
                    self.assertEqual(value.tobytes(), whole[key].tobytes(), key)

    def test_ranks(self):
        """Equal to what the solver of the diffusion leaves where steps are given, and to the tolerance of the diffusion
        where they follow estimates of errors, which feel what it leaves."""
        for mesh in ("grid", "rectangles", "triangles"):
            for tolerance, more in ((1e-8, ["-ts_adapt_type", "none", "-ts_dt", 600]), (1e-3, [])):
                cells = GRID if mesh == "grid" else ["-fault_mesh", f"{mesh}.h5"]
                options = cells + SMOOTH + VALVE + RATES + OPEN + DILATES + more
                one, two = self.series(*options), self.series(*options, ranks=2)
                with self.subTest(mesh=mesh, tolerance=tolerance):
                    for key in ("last slip", "last pore_pressure"):
                        np.testing.assert_allclose(two[key], one[key], rtol=0, atol=tolerance * abs(one[key]).max())
                if not more:
                    continue
                self.fault(*ANY, *options, "-ts_max_steps", 100, "-fault_checkpoint", "state", code=3)
                two = self.series(*options, "-fault_restart", "state", ranks=2)
                with self.subTest(mesh=mesh, restart="on two processes"):
                    for key in ("last slip", "last pore_pressure"):
                        np.testing.assert_allclose(two[key], one[key], rtol=0, atol=tolerance * abs(one[key]).max())

    def test_solver(self):
        """Options of the solver of the diffusion have a prefix; those of the stages' solver are not its. They change
        a run by rounding, and are read before it."""
        with self.assertRaisesRegex(AssertionError, "fault_fluid_pc_type"):
            self.fault(*ANY, *GRID, *SMOOTH, *RATES, "-fault_fluid_pc_type", "no_such")
        options = GRID + SMOOTH + RATES
        usual = self.series(*options)["last pore_pressure"]
        for own in ("jacobi", "cholesky"):
            self.assertNotIn("-fault_fluid_pc_type", self.fault(*ANY, *options, "-fault_fluid_pc_type", own))
            given = self.get("run.h5", "fields/pore_pressure")[-1]
            np.testing.assert_allclose(given, usual, rtol=0, atol=1e-6 * abs(usual).max())
            self.assertFalse(np.array_equal(given, usual))

    def test_short_run(self):
        """A run that ends before its wells do says so."""
        said = "the run ends at 3600 s (-ts_max_time), before the last change of -fault_wells"
        self.assertIn(said, self.fault(*ANY, *GRID, *SMOOTH, *RATES, "-ts_max_time", "1h"))
        self.assertNotIn("the run ends at", self.fault(*ANY, *GRID, *SMOOTH, *RATES))

    def test_pores(self):
        """Without flow pores that dilate are those of -fault_dilatancy with the storage of the fluid, whose pressure
        takes forever to flow away."""
        uniform = [*SMOOTH, "-fault_nx", 1, "-fault_nz", 1, "-fault_length_x", 1000, "-fault_length_z", 1000,
                   "-fault_depth_top", 2000, "-fault_loading_rate", 1e-7, "-fault_dilatancy", 1e-4, "-ts_rtol", 1e-6]
        self.fault(*ANY, *uniform)
        own = self.get("run.h5", "fields/slip")[-1]
        self.fault(*ANY, *uniform, "-fault_permeability", 0, "-fault_permeability_ratio", 1, "-fault_dilatancy_storage",
                   1e-10, "-fault_dilatancy_time", 1e30, "-fault_output_fields", "slip")
        slip = self.get("run.h5", "fields/slip")[-1]
        self.assertGreater(slip.item(), 1e-3)
        np.testing.assert_allclose(own, slip, rtol=1e-5)


class Wells(FaultTest):
    def test_theis(self):
        """A well in a plane, 0.1 m wide in cells of 20 m: pressure around it and in it at a rate, and the rate when its
        pressure is held, which superposition of Theis' solution gives."""
        cells, side, k, eta, storage, rate, end = 61, 20.0, 5e-14, 1e-3, 1e-9, 1e-3, 3.6e5
        diffusivity, middle = k / (eta * storage), cells * side / 2

        def theis(r, t):
            return eta / (4 * math.pi * k) * exp1(r**2 / (4 * diffusivity * t))  # per rate

        options = ["-fault_nx", cells, "-fault_nz", cells, "-fault_length_x", cells * side, "-fault_length_z",
                   cells * side, "-fault_permeability", k, "-fault_pore_compressibility", storage / 0.1,
                   "-fault_normal_stress", 1e8, "-fault_normal_stress_gradient", 0, "-fault_initial", "traction",
                   "-fault_initial_traction", 1e6, "-fault_inertia", "no", "-fault_viscosity", "radiation",
                   "-fault_wells", "wells.csv", "-fault_fluid_tolerance", 1e-4, "-fault_output", "run.h5",
                   "-fault_output_overwrite", "-fault_output_fields", "pore_pressure", "-fault_progress", "no",
                   "-ts_max_time", end]
        self.put("wells.csv", f"well,x,z,s,m3/s\nA,{middle},{middle},0,{rate}\n")
        self.fault(*options)
        pressure, well = self.get("run.h5", "fields/pore_pressure", "series/well_pressure")
        x = (np.arange(cells) - cells // 2) * side
        r = np.hypot.outer(x, x)
        seen = (r > 2.5 * side) & (r < 300)
        # a grid's own logarithm differs from ln r^2 by (side/r)^2/6 at most and by higher orders
        unit = rate * eta / (4 * math.pi * k)
        self.assertLess(((abs(pressure[-1] - rate * theis(r + (r == 0), end))
                          / (unit * (0.25 * (side / (r + (r == 0)))**2 + 2e-3)))[seen]).max(), 1)
        self.assertAlmostEqual(well[-1].item() / (rate * theis(0.1, end)), 1, delta=2e-3)
        # the same pressure held from the start
        self.put("wells.csv", f"well,x,z,s,Pa\nA,{middle},{middle},0,{well[-1].item()}\n")
        self.fault(*options)
        times = end * np.linspace(0, 1, 400)**3
        jumps = np.zeros(399)  # of the rate at these times, so that the pressure is right at the next
        for i in range(399):
            before = (jumps[:i] * theis(0.1, times[i + 1] - times[:i])).sum()
            jumps[i] = (well[-1].item() - before) / theis(0.1, times[i + 1] - times[i])
        self.assertAlmostEqual(self.get("run.h5", "series/well_rate")[-1].item() / jumps.sum(), 1, delta=5e-3)


class OneWay(FaultTest):
    def test_record(self):
        """BP8 at 10 m: the Gaussian source of a well in 20 days is the record that examples/seas_bp8.py computes in
        closed form, to the error of cells, 1.5e-3 of the largest and 6.2e-3 at 20 m, and of -fault_fluid_tolerance,
        and so is slip."""
        make = ("make", "bp8", "--cell", 10)
        n = int(self.run_example("seas_bp8.py", *make))
        self.run_example("seas_bp8.py", *make, "--diffusion")
        options = ("-options_file", os.path.join(SOURCE, "examples", "seas_bp8.opts"), "-fault_nx", n, "-fault_nz", n,
                   "-fault_output_fields", "slip,pore_pressure", "-fault_progress", "no", "-ts_max_time", "20d")
        self.fault(*options, "-fault_pore_pressure", "bp8_pressure.h5", "-fault_output", "record.h5")
        self.fault(*options, "-fault_wells", "bp8_wells.csv", "-fault_permeability", seas_bp8.PERMEABILITY,
                   "-fault_pore_compressibility", seas_bp8.STORAGE / 0.1, "-fault_output", "well.h5")
        x = seas_bp8.centres(n)
        times, pressure, slip = self.get("well.h5", "fields/time", "fields/pore_pressure", "fields/slip")
        exact = np.array([seas_bp8.pressure(x, x, t) for t in times])
        self.assertGreater(len(times), 30)
        self.assertLess(abs(pressure - exact).max(), 2.5e-3 * exact.max())
        other = self.get("record.h5", "fields/slip")[-1]
        self.assertGreater(other.max(), 0.02)
        self.assertLess(abs(slip[-1] - other).max(), 5e-3 * other.max())


class Meet(FaultTest):
    """A fault of 5 x 2 cells, where another one of 2 x 2 cells meets it at right angles"""
    def crossing(self, x, y):
        rows = [[100 + 200 * i, 0, 2100 + 200 * j, 200, 200, 0, 90] for j in range(2) for i in range(5)]
        rows += [[x, y - 100 + 200 * i, 2100 + 200 * j, 200, 200, 90, 90] for j in range(2) for i in range(2)]
        with h5py.File(self.path("cross.h5"), "w") as file:
            file["cells"] = np.array(rows, float)
            file["cells"].attrs["columns"] = "x y z length width strike dip"
            file["cells"].attrs["units"] = "m"
            file["fault"] = np.array([3] * 10 + [7] * 4)
        self.put("rates.csv", WELLS)
        return self.fault(*ANY, *WEAK, "-fault_initial_traction", 1e6, "-fault_mesh", "cross.h5", "-fault_wells",
                          "rates.csv", "-fault_view", "-ts_max_time", "1d")

    def test_common_sides(self):
        said = self.crossing(400, 0)
        self.assertRegex(said, r" 1 bodies")
        self.assertNotIn("no fluid flows between", said)
        self.assertGreater(self.get("run.h5", "fields/pore_pressure")[-1][10:].min(), 0)

    def test_without(self):
        """With sides in the middle of cells; nearly; not at all. Cells that cross are errors of the mesh."""
        for x, y, cells in ((500, 200, 2 + 2), (500, 200.1, 2 + 2), (1300, 0, 0)):
            said = self.crossing(x, y)
            with self.subTest(x=x, y=y):
                self.assertRegex(said, r" 2 bodies")
                self.assertEqual(f"no fluid flows between {cells} cells" in said, cells > 0, said)
                self.assertEqual("faults 3 and 7" in said, cells > 0)
                np.testing.assert_array_equal(self.get("run.h5", "fields/pore_pressure")[-1][10:], 0)


if __name__ == "__main__":
    unittest.main()
