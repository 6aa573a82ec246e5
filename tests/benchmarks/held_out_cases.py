"""The faults of the held-out benchmark, none of them seen in training, and the controllers that run them.

One cell: 40 faults drawn from SINGLE, log-uniform, by a fixed seed; draws that violate PLAUSIBLE are repeated. The
excess over the strength at the start grows like exp(rate t); the duration is the time that takes and half a period of
the oscillation after it, in which the event happens, times a factor of 1.3 to 2.5.
Meshes: the faults of 3, 4 and 5 km at 25 x 25 and 50 x 50 cells, all else at its default.
Heterogeneous: 10 faults of 4 x 4 to 12 x 12 square cells; normal stress, friction drop, residual friction and
weakening slip vary from cell to cell, by a random field of a few waves and white noise, so that cells slip and
stick at different times.
"""

import dataclasses
import os

import h5py
import numpy as np

SEED = 20261121
SINGLE_COUNT = 40
MIXED_COUNT = 10

# name of the option without fault_: lowest, highest, unit
SINGLE = {
    "length_x": (500, 20e3, "m"), "thickness": (0.5, 2.0, "length_x"), "shear_modulus": (20e9, 40e9, "Pa"),
    "density": (2300, 3000, "kg/m^3"), "damping_ratio": (0.1, 0.6, "1"), "normal_stress": (5e6, 150e6, "Pa"),
    "friction_residual": (0.2, 0.7, "1"), "friction_drop": (0.03, 0.3, "1"), "friction_slip": (0.005, 1.0, "m"),
    "initial_perturbation": (1e-6, 1e-3, "1"),
}
DURATION = (1.3, 2.5)
PLAUSIBLE = "stress drop 0.5 to 20 MPa, static friction <= 0.85, weakening rate 1.5 to 15 times the stiffness G/thickness"
MIXED = {
    "length_x": (1e3, 10e3, "m"), "depth_top": (100, 5e3, "m"), "damping_ratio": (0.15, 0.5, "1"),
    "friction_drop": (0.06, 0.2, "1"), "weakening": (2.5, 10, "stiffness"),
}
# standard deviation of the logarithm
SPREAD = {"normal_stress": 0.25, "friction_drop": 0.25, "friction_residual": 0.08, "friction_slip": 0.25}

# 1e-5 to 4.2; the sparse ones for 50 x 50, and for everything with --sparse
TOLERANCES = [float(f"{10 ** e:.6g}") for e in np.arange(16) * 0.375 - 5]
SPARSE = TOLERANCES[1::2]
# family: options; each with every tolerance
EMBEDDED, DOUBLING = ["-ts_bathe_error", "embedded"], ["-ts_bathe_error", "doubling"]
FAMILIES = {
    "heuristic": ["-ts_adapt_type", "heuristic", *EMBEDDED],
    "heuristic, safety 0.9": ["-ts_adapt_type", "heuristic", "-ts_adapt_safety", "0.9", *EMBEDDED],
    "heuristic, long start": ["-ts_adapt_type", "heuristic", "-ts_adapt_safety", "0.9", *EMBEDDED],  # and LONG_START
    "basic": ["-ts_adapt_type", "basic", *EMBEDDED],
    "dsp": ["-ts_adapt_type", "dsp", *EMBEDDED],
    "pi": ["-ts_adapt_type", "pi", *EMBEDDED],
    "heuristic, doubling": ["-ts_adapt_type", "heuristic", *DOUBLING],
    "basic, doubling": ["-ts_adapt_type", "basic", *DOUBLING],
    "dsp, doubling": ["-ts_adapt_type", "dsp", *DOUBLING],
    "pi, doubling": ["-ts_adapt_type", "pi", *DOUBLING],
}
LONG_START = 0.3  # first step over T*, against the program's 0.01
PUBLISHED = ["-ts_bathe_reaction", "implicit", *DOUBLING]  # how the study ran its policies


@dataclasses.dataclass
class Case:
    """One fault. tstar: T* [s]; duration [s]; tolerances: the rtol of the classical controllers."""
    name: str
    group: str
    options: list
    tstar: float
    duration: float
    tolerances: list
    fields: str = ""  # file of per-cell parameters


def log_uniform(random, low, high):
    return float(low * (high / low) ** random.random())


def rounded(x):
    """Six digits: the options say exactly what is run."""
    return float(f"{x:.6g}")


def event_time(weakening, damping, perturbation, tstar):
    """When a single cell's event is over, roughly [s]: the excess grows from its first value to 1 at the rate of
    x'' + 2 zeta x' + (1 - W) x = 0, then half a damped period of the oscillation follows (time in T*)."""
    rate = np.sqrt(damping ** 2 + weakening - 1) - damping
    return tstar * (np.log(1 / perturbation) / rate + np.pi / np.sqrt(1 - damping ** 2))


def draw_single(random):
    """Parameters of one cell and T*, weakening over stiffness."""
    while True:
        p = {name: rounded(log_uniform(random, low, high)) for name, (low, high, _) in SINGLE.items()}
        p["thickness"] = rounded(p["thickness"] * p["length_x"])
        drop = p["normal_stress"] * p["friction_drop"]
        weakening = drop / p["friction_slip"] * p["thickness"] / p["shear_modulus"]
        if 0.5e6 <= drop <= 20e6 and p["friction_residual"] + p["friction_drop"] <= 0.85 and 1.5 <= weakening <= 15:
            return p, p["thickness"] * np.sqrt(p["density"] / p["shear_modulus"]), weakening


def fault_options(p):
    return [word for name, value in p.items() for word in (f"-fault_{name}", f"{value:.6g}")]


def single_cases(count=SINGLE_COUNT, seed=SEED):
    random = np.random.default_rng(seed)
    cases = []
    for k in range(count):
        p, tstar, weakening = draw_single(random)
        duration = log_uniform(random, *DURATION) * event_time(weakening, p["damping_ratio"], p["initial_perturbation"], tstar)
        p.update(length_z=p["length_x"], normal_stress_gradient=0, nx=1, nz=1)
        cases.append(Case(f"one {k + 1:02d}", "one cell", fault_options(p), tstar, rounded(duration), TOLERANCES))
    return cases


def mesh_cases(sizes=(25, 50)):
    cases = []
    for n in sizes:
        for km, duration in ((3, 30.0), (4, 40.0), (5, 50.0)):
            p = {"length_x": km * 1e3, "length_z": km * 1e3, "nx": n, "nz": n}
            cases.append(Case(f"{km} km, {n} x {n}", f"mesh {n} x {n}", fault_options(p), km * 1e3 * np.sqrt(2500 / 30e9), duration,
                              TOLERANCES if n < 50 else SPARSE))
    return cases


def random_field(random, nz, nx):
    """Zero mean, unit variance: six plane waves of up to two periods along the fault, and a third of white noise [nz,
    nx]."""
    z, x = np.meshgrid((np.arange(nz) + 0.5) / nz, (np.arange(nx) + 0.5) / nx, indexing="ij")
    waves = np.zeros((nz, nx))
    for _ in range(6):
        kx, kz, phase = random.random(3)
        waves += np.cos(2 * np.pi * (2 * kx * x + (4 * kz - 2) * z + phase))
    noise = np.sqrt(-2 * np.log(1 - random.random((nz, nx)))) * np.cos(2 * np.pi * random.random((nz, nx)))
    field = waves / waves.std() + noise / 3
    return (field - field.mean()) / field.std()


def draw_mixed(random, path):
    """Write the per-cell parameters of one fault to a file; its options, T* and mean weakening over stiffness."""
    nx, nz = (4 + int(9 * random.random()) for _ in range(2))
    p = {name: rounded(log_uniform(random, low, high)) for name, (low, high, _) in MIXED.items()}
    weakening = p.pop("weakening")
    length, modulus = p["length_x"], 30e9
    depth = p["depth_top"] + (np.arange(nz) + 0.5) * length / nx
    mean = {"normal_stress": 15e3 * depth[:, None], "friction_drop": p.pop("friction_drop"), "friction_residual": 0.5}
    mean["friction_slip"] = float(mean["normal_stress"].mean()) * mean["friction_drop"] * length / modulus / weakening
    with h5py.File(path, "w") as file:
        for name, spread in SPREAD.items():
            file[name] = np.broadcast_to(mean[name], (nz, nx)) * np.exp(spread * random_field(random, nz, nx))
    p.update(length_z=rounded(length * nz / nx), nx=nx, nz=nz)
    return p, length * np.sqrt(2500 / modulus), weakening


def mixed_cases(folder, count=MIXED_COUNT, seed=SEED):
    random = np.random.default_rng(seed + 1)
    cases = []
    for k in range(count):
        path = os.path.join(folder, f"mixed_{k + 1:02d}.h5")
        p, tstar, weakening = draw_mixed(random, path)
        # cells differ in their weakening: the slowest part sets the pace, so more time than for one cell
        duration = 2 * event_time(max(0.6 * weakening, 1.5), p["damping_ratio"], 1e-5, tstar)
        cases.append(Case(f"mixed {k + 1:02d}, {p['nz']} x {p['nx']}", "heterogeneous", fault_options(p) + ["-fault_parameters", path],
                          tstar, rounded(duration), TOLERANCES, path))
    return cases


def all_cases(folder, seed=SEED):
    return single_cases(seed=seed) + mesh_cases() + mixed_cases(folder, seed=seed)


def classical(case):
    """(family, rtol, options) of every classical run of a case."""
    for family, options in FAMILIES.items():
        start = ["-ts_dt", f"{LONG_START * case.tstar:.6g}"] if family == "heuristic, long start" else []
        for rtol in case.tolerances:
            yield family, rtol, [*options, *start, "-ts_rtol", f"{rtol:.6g}"]
