"""The faults of the held-out benchmark, none of them seen in training, and the controllers that run them.

Drawn faults (KINDS): parameters log-uniform in RANGES, by a seed; every other fault of a kind has its stiffness as it
is computed, the rest as the study scaled it. The weakening slip follows from a drawn weakening rate over the stiffness
against uniform slip. Per-cell fields vary by a random field of a few waves and white noise, so that cells slip and
stick at different times. The duration is the time to rest in a run at PROBE_RTOL, times a drawn margin; a fault that
does not rest in time or hardly slips is drawn again.
Meshes: the faults of 3, 4 and 5 km at 25 x 25 and 50 x 50 cells, with either scaling, all else at its default.

What is drawn is kept in FOLDER/cases_SEED: NAME.json, the fields in NAME.h5, and NAME.opts, with which any program can
run the fault: `fault -options_file NAME.opts`.
"""

import dataclasses
import json
import os

import common  # noqa: F401: before modules that may be missing
import h5py
import numpy as np

import make_mesh

SEED = 20261203
RANGES = {
    "length_x": (500, 20e3),  # m
    "thickness": (0.5, 2.0),  # length_x
    "shear_modulus": (20e9, 40e9),  # Pa
    "density": (2300, 3000),  # kg/m^3
    "damping_ratio": (0.1, 0.6),
    "normal_stress": (5e6, 150e6),  # Pa, mean
    "friction_residual": (0.2, 0.7),
    "friction_drop": (0.03, 0.3),
    "initial_perturbation": (1e-6, 1e-3),
    "margin": (1.2, 2.5),  # duration over the time to rest
}
PLAUSIBLE_DROP, PLAUSIBLE_FRICTION = (0.5e6, 20e6), 0.85  # mean stress drop [Pa], static friction
LIMIT = 250  # a fault that does not rest by then is drawn again [periods over 2 pi of one cell]
LEAST_SLIP = 0.2  # so is one whose final slip is below this share of drop over stiffness
# standard deviation of the logarithm over that of friction_drop
SPREAD = {"normal_stress": 1, "friction_drop": 1, "friction_residual": 0.3, "friction_slip": 1}


@dataclasses.dataclass
class Kind:
    """count of faults; cells along each side; width over length, 0: that of square cells; weakening: rate over
    stiffness; spread of fields; mesh: graded planes, every other time two of them."""
    count: int
    cells: tuple = (4, 12)
    aspect: tuple = (0, 0)
    weakening: tuple = (2.5, 10)
    spread: tuple = (0.15, 0.35)
    law: str = ""
    mesh: bool = False


KINDS = {"single": Kind(40, cells=(1, 1), weakening=(1.5, 15), spread=(0, 0)),
         "heterogeneous": Kind(10),
         "rectangle": Kind(20, cells=(3, 20), aspect=(0.25, 1.5), spread=(0, 0.15)),
         "irregular": Kind(10, cells=(4, 10), aspect=(0.3, 1.2), spread=(0.05, 0.3), mesh=True),
         "linear": Kind(10, cells=(1, 10), law="linear_slip_weakening"),}

# rtol: 1e-5 to 10; the sparse ones for 50 x 50, and for everything with --sparse
TOLERANCES = [float(f"{10 ** e:.6g}") for e in np.arange(19) / 3 - 5]
SPARSE = TOLERANCES[::2]
PROBE_RTOL = 1e-3
LONG_START = 0.3  # first step over T*, against the program's 0.01
# PETSc 3.18's, and those of SlipStep
DSP_FILTERS = "basic PI30 PI42 PI33 PI34 PC11 PC47 PC36 H0211 H211b H211PI H0312 H312b H312PID H0321 H321".split()
PI_FILTERS = "fault_history elementary PI33 PI34 PI42 H211PI H211b2 H211b4".split()  # the first is tuned
CONSTANT = [float(f"{s:.4g}") for s in np.geomspace(3, 0.04, 16)]  # steps [T*]


def families():
    """(name, options, every how many-th tolerance). Variants of one controller take turns at the tolerances."""
    yield "heuristic", ["-ts_adapt_type", "heuristic"], 1
    yield "heuristic, safety 0.9", ["-ts_adapt_type", "heuristic", "-ts_adapt_safety", "0.9"], 1
    yield "heuristic, long start", ["-ts_adapt_type", "heuristic", "-ts_adapt_safety", "0.9"], 1
    yield "basic", ["-ts_adapt_type", "basic"], 1
    for name in DSP_FILTERS:
        yield f"dsp {name}", ["-ts_adapt_type", "dsp", "-ts_adapt_dsp_filter", name], 2
    for name in PI_FILTERS:
        yield f"pi {name}", ["-ts_adapt_type", "pi", "-ts_adapt_pi_filter", name], 1 if name == PI_FILTERS[0] else 2


def classical(case, begins=("",)):
    """(family, rtol or step, options) of every classical run of a case by families whose name begins like one of
    these."""
    return (run for run in every_classical(case) if run[0].startswith(tuple(begins)))


def family_names():
    return [family for family, _, _ in families()] + ["constant"]


def every_classical(case):
    for k, (family, options, stride) in enumerate(families()):
        start = ["-ts_dt", f"{LONG_START * case.tstar:.6g}"] if family == "heuristic, long start" else []
        for rtol in case.tolerances[k % stride::stride]:
            yield family, rtol, [*options, "-ts_bathe_error", "embedded", *start, "-ts_rtol", f"{rtol:.6g}"]
    for step in CONSTANT[::1 if case.tolerances == TOLERANCES else 2]:
        yield "constant", step, ["-ts_adapt_type", "none", "-ts_bathe_error", "none", "-ts_dt",
                                 f"{step * case.tstar:.6g}"]


@dataclasses.dataclass
class Case:
    """One fault. tstar: T* [s]; duration [s]; tolerances: the rtol of the classical controllers."""
    name: str
    group: str
    options: list
    tstar: float
    duration: float
    tolerances: list
    fields: str = ""  # file of per-cell parameters, and of the cells of a mesh


def log_uniform(random, low, high):
    return float(low * (high / low) ** random.random())


def rounded(x):
    """Six digits: the options say exactly what is run."""
    return float(f"{x:.6g}")


def fault_options(p):
    return [word for name, value in p.items()
            for word in (f"-fault_{name}", value if isinstance(value, str) else f"{value:.6g}")]


def random_field(random, x, z):
    """Zero mean, unit variance over cells at x, z in units of the fault: six plane waves of up to two periods along it,
    and a third of white noise."""
    waves = np.zeros(len(x))
    for _ in range(6):
        kx, kz, phase = random.random(3)
        waves += np.cos(2 * np.pi * (2 * kx * x + (4 * kz - 2) * z + phase))
    field = waves / waves.std() + random.standard_normal(len(x)) / 3
    return (field - field.mean()) / field.std()


def geometry(random, kind, k, length):
    """Options of the cells; rows of a mesh or None; x, z [n] of the cells in units of the length, their shape and
    area."""
    nx, nz = (kind.cells[0] + int((kind.cells[1] + 1 - kind.cells[0]) * random.random()) for _ in range(2))
    width = rounded(length * (log_uniform(random, *kind.aspect) if kind.aspect[1] else nz / nx))
    top = 0.0 if random.random() < 0.3 else rounded(log_uniform(random, 100, 5e3))
    if not kind.mesh:
        z, x = (g.ravel() for g in np.meshgrid((np.arange(nz) + 0.5) * width / nz / length, (np.arange(nx) + 0.5) / nx,
                                               indexing="ij"))
        p = {"length_x": length, "length_z": width, "depth_top": top, "nx": nx, "nz": nz}
        return p, None, x, z, (nz, nx), length * width
    ratio = log_uniform(random, 1.5, 5)
    rows, planes = make_mesh.plane((nx, nz), (length, width), top, ratio), 1 + k // 2 % 2
    if planes == 2:
        offset = rounded(log_uniform(random, 0.2, 1) * length)
        rows = np.concatenate([rows, make_mesh.plane((nx, nz), (length, width), top, ratio, x0=rounded(0.3 * length),
                                                     y=offset)])
    return {}, rows, rows[:, 0] / length, (rows[:, 2] - top) / length, (len(rows),), planes * length * width


def stiffness(scaled, modulus, thickness, area, n):
    """Against uniform slip [Pa/m]: of a scaled one, and roughly of one as it is computed."""
    return modulus / thickness if scaled else modulus / np.sqrt(area) * (2.3 - 1.3 / np.sqrt(n))


def draw(random, kind, k, path):
    """A fault, its fields in the file path: options, T*, time unit of one cell, margin of the duration, least final
    slip."""
    while True:
        p = {name: rounded(log_uniform(random, *limits)) for name, limits in RANGES.items()}
        drop = p["normal_stress"] * p["friction_drop"]
        if (PLAUSIBLE_DROP[0] <= drop <= PLAUSIBLE_DROP[1] and p["friction_residual"]
            + p["friction_drop"] <= PLAUSIBLE_FRICTION):
            break
    scaled, spread = k % 2 == 1, random.uniform(*kind.spread)
    weakening, margin, length = log_uniform(random, *kind.weakening), p.pop("margin"), p.pop("length_x")
    p["thickness"] = rounded(p["thickness"] * length)
    cells, rows, x, z, shape, area = geometry(random, kind, k, length)
    n = len(x)
    stiff = stiffness(scaled, p["shear_modulus"], p["thickness"], area, n)
    mean = {name: p.pop(name) for name in ("normal_stress", "friction_drop", "friction_residual")}
    mean["friction_slip"] = drop / stiff / weakening
    # than half: more stress
    deeper = 2 * (z + 0.1 * z.max()) / (1.2 * z.max()) if n > 1 and random.random() < 0.5 else 1
    with h5py.File(path, "w") as file:
        if rows is not None:
            file["cells"] = rows
            file["cells"].attrs["columns"] = make_mesh.COLUMNS
        for name, value in mean.items():
            factor = np.exp(spread * SPREAD[name] * random_field(random, x, z)) if n > 1 else np.ones(n)
            file[name] = (value * factor * (deeper if name == "normal_stress" else 1)).reshape(shape)
    p.update(cells, parameters=path, stiffness_scaling="mean_slip" if scaled else "none")
    p.update({"mesh": path} if rows is not None else {}, **({"friction_law": kind.law} if kind.law else {}))
    tstar = p["thickness"] * np.sqrt(p["density"] / p["shear_modulus"])
    return fault_options(p), tstar, np.sqrt(p["density"] * p["thickness"] / stiff), margin, LEAST_SLIP * drop / stiff


def make(kind, k, seed, name, folder, probe):
    """The k-th fault of a kind: the first draw that rests in time having slipped. probe: (time to rest or None, final
    slip) of a case's run."""
    path = os.path.join(folder, f"{name}.h5")
    for attempt in range(100):
        random = np.random.default_rng([seed, list(KINDS).index(kind), k, attempt])
        options, tstar, unit, margin, least = draw(random, KINDS[kind], k, path)
        case = Case(name, kind, options, float(tstar), rounded(LIMIT * unit), TOLERANCES, path)
        rest, slip = probe(case)
        if rest and slip >= least:
            case.duration = rounded(margin * rest)
            return case
    raise RuntimeError(f"{name}: no draw of 100 slips and rests within {LIMIT} periods over 2 pi")


def drawn_cases(folder, seed, probe, want):
    """Those of KINDS whose name is wanted; made once."""
    room = os.path.join(folder, f"cases_{seed}")
    os.makedirs(room, exist_ok=True)
    cases = []
    for kind, row in KINDS.items():
        for k in range(row.count):
            name = f"{kind}_{k + 1:02d}"
            if not want(name):
                continue
            path = os.path.join(room, f"{name}.json")
            if not os.path.exists(path):
                store(make(kind, k, seed, name, room, probe), path)
            with open(path) as file:
                cases.append(Case(**json.load(file)))
    return cases


def store(case, path):
    pairs = zip(case.options[::2], case.options[1::2])
    with open(path[:-5] + ".opts", "w") as file:
        file.writelines(f"{key} {value}\n" for key, value in [*pairs, ("-ts_max_time", f"{case.duration:.10g}")])
    with open(path + ".part", "w") as file:
        json.dump(dataclasses.asdict(case), file, indent=1)
    os.replace(path + ".part", path)


def mesh_cases(sizes=(25, 50)):
    cases = []
    for n in sizes:
        for km, duration in ((3, 30.0), (4, 40.0), (5, 50.0)):
            for scaling in ("none", "mean_slip"):
                p = {"length_x": km * 1e3, "length_z": km * 1e3, "nx": n, "nz": n, "stiffness_scaling": scaling}
                scaled = "_scaled" if scaling != "none" else ""
                cases.append(Case(f"{km}km_{n}{scaled}", f"{n} x {n}{scaled.replace('_', ', ')}", fault_options(p),
                                  km * 1e3 * np.sqrt(2500 / 30e9), duration, TOLERANCES if n < 50 else SPARSE))
    return cases


def all_cases(folder, seed, probe, want=lambda name: True):
    return drawn_cases(folder, seed, probe, want) + [c for c in mesh_cases() if want(c.name)]
