"""Faults with inertia of eight kinds, and ruptures from a patch, for the benchmark of products (products.py).

Those from the instability are drawn as held_out_cases.py draws, with other numbers of cells and options besides; every
third is weakened linearly where its kind does not say how. Their duration is the time to rest times a margin. Ruptures
are those that training/runs/rupture.c draws, with inertia: a patch of radius above what becomes unstable by itself, in
a field of strength and stress that varies.
"""

import dataclasses
import os

from common import write
import h5py
import numpy as np

import held_out_cases
from held_out_cases import Case, Kind, log_uniform, rounded

import make_fault

WIDE = {"weakening": (1.5, 15), "spread": (0, 0.3)}
GRID = {"cells": (2, 14), "aspect": (0.25, 1.5), **WIDE}


@dataclasses.dataclass
class Row:
    """kind: as held_out_cases.draw() takes it; number: of the k-th fault, by which that scales the stiffness (odd ones)
    and has two planes (every other pair); options(random): more of them; triangles: each rectangle is cut in two."""
    kind: Kind = None
    number: object = lambda k: k
    options: object = lambda random: []
    triangles: bool = False


def unscaled(k):
    return 2 * k


def one_plane(k):
    return 4 * (k // 2) + k % 2


def two_planes(k):
    return one_plane(k) + 2


def dipping(random):
    return ["-fault_dip", f"{30 + 40 * random.random():.4g}", "-fault_rake", "90"]


def vectors(random):
    return ["-fault_slip_components", "2", "-fault_rake", f"{360 * random.random() - 180:.4g}",
            "-fault_normal_coupling", "no"]


def opening(random):
    return ["-fault_slip_components", "2", "-fault_opening", "yes", *dipping(random)]


def start(random):
    """The perturbation that is the default, from which slip takes long to grow, and much damping as often as little"""
    return ["-fault_initial_perturbation", "1e-5", "-fault_damping_ratio", f"{0.1 + 0.5 * random.random():.4g}"]


EVENTS = {"event": Row(Kind(0, cells=(1, 20), aspect=(0.25, 1.5), law="exponential_slip_weakening", **WIDE)),
          "linear": Row(Kind(0, cells=(1, 20), aspect=(0.25, 1.5), law="linear_slip_weakening", **WIDE)),
          "irregular": Row(Kind(0, cells=(3, 10), aspect=(0.3, 1.2), mesh=True, **WIDE), one_plane),
          "parallel": Row(Kind(0, cells=(3, 8), aspect=(0.3, 1.2), mesh=True, **WIDE), two_planes),
          "vectors": Row(Kind(0, **GRID), unscaled, vectors),
          "dipping": Row(Kind(0, **GRID), unscaled, dipping),
          "triangles": Row(Kind(0, cells=(3, 7), aspect=(0.3, 1.2), mesh=True, **WIDE), one_plane, triangles=True),}
RUPTURES = {"rupture": Row(), "opening": Row(options=opening)}
KINDS = {**EVENTS, **RUPTURES}
LIMIT = 250  # an event that does not rest by then is drawn again [periods over 2 pi of one cell]
MESHES = (12, 6), (16, 6), (10, 10), (16, 8), (24, 4), (20, 6)  # of ruptures
CELL_STIFFNESS = np.sqrt(2) / np.pi * 7 / 3  # of a square, nu = 1/4 [shear modulus over side]
RUPTURE_LIMIT = 30  # T*: a rupture that goes on is cut
LEAST_STRESS = 1e-3  # of the highest normal stress, in upper cells, which open where slip below pulls
LEAST_BROKEN = 0.1  # of the cells, else it is drawn again


def cut(path):
    """Rectangles of a vertical plane, cut in two; the values of cells twice."""
    with h5py.File(path, "r+") as file:
        rows = file["cells"][()]
        corners = rows[:, None, :3] + 0.5 * np.stack([[a * rows[:, 3], 0 * rows[:, 3], b * rows[:, 4]] for a, b
                                                      in ((-1, -1), (1, -1), (1, 1), (-1, 1))]).transpose(2, 0, 1)
        vertices, index = np.unique(np.round(corners.reshape(-1, 3), 6), axis=0, return_inverse=True)
        square = index.reshape(-1, 4)
        del file["cells"]
        file["vertices"], file["triangles"] = vertices, square[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
        file["vertices"].attrs["columns"] = "x y z"
        for name in [n for n in file if n not in ("vertices", "triangles")]:
            values = np.repeat(file[name][()], 2)
            del file[name]
            file[name] = values


def event(random, row, k, path):
    """(case, margin of its duration, least final slip)"""
    law = row.kind.law or ("linear_slip_weakening" if k % 3 == 2 else "exponential_slip_weakening")
    options, tstar, unit, margin, least = held_out_cases.draw(random, dataclasses.replace(row.kind, law=law),
                                                              row.number(k), path)
    if row.triangles:
        cut(path)
        options += ["-fault_mesh_frame", "ned"]
    if random.random() < 0.5:
        options += start(random)
    return Case("", law.split("_")[0], options + row.options(random), float(tstar), rounded(LIMIT * unit), [],
                path), margin, least


def rupture(random, row, k, path):
    """Likewise; the least final slip is a share of that of the patch's cells at their weakening slip."""
    nx, nz = MESHES[int(len(MESHES) * random.random())]
    side, stress = log_uniform(random, 100, 1000), log_uniform(random, 15e6, 100e6)
    drop, weakening, scatter = log_uniform(random, 0.05, 0.3), log_uniform(random, 0.2, 0.8), 0.3 * random.random()
    radius = (1.2 + 1.3 * random.random()) * 0.58 / (CELL_STIFFNESS * weakening) + 0.8
    patch = [side * nx * random.random(), side * nz * random.random(), side * radius]
    x, z, _ = make_fault.grid((nx, nz), (side * nx, side * nz), 0)
    extra = row.options(random)
    if extra:  # cells near the upper edge have hardly any normal stress
        stress = stress * np.maximum(LEAST_STRESS, z / z.max() - 0.3)
    a = make_fault.argparse.Namespace(seed=int(2**31 * random.random()), drop=drop, scatter=scatter,
                                      correlation=side * log_uniform(random, 2, 8), shear_modulus=30e9,
                                      slip=None, weakening=weakening, stress=0.45 + 0.3 * random.random(), patch=patch,
                                      residual=0.5, normal_stress=stress)
    fields = make_fault.fields(x, z, side, a)
    if extra:
        fields["normal_stress"] = (stress, "Pa")
    law = "linear_slip_weakening" if k % 3 == 2 else "exponential_slip_weakening"
    write(path, **{name: values for name, (values, _) in fields.items()})
    p = {"nx": nx, "nz": nz, "length_x": side * nx, "length_z": side * nz, "depth_top": side if extra else 0,
         "friction_residual": 0.5, "friction_law": law,
         "thickness": log_uniform(random, 0.3, 1) * side * max(nx, nz), "initial": "traction",
         "initial_unstable": "yes", "inertia": "yes", "viscosity": "sqrtm" if k % 2 else "radiation",
         "parameters": path}
    p.update({} if extra else {"normal_stress": stress})
    tstar = p["thickness"] * np.sqrt(2500 / 30e9)
    least = LEAST_BROKEN * float(fields["friction_slip"][0].mean())
    return Case("", law.split("_")[0], held_out_cases.fault_options(p) + extra, float(tstar),
                rounded(RUPTURE_LIMIT * tstar), [], path), 1 + 2 * random.random() ** 2, least


def make(kind, k, seed, folder, probe):
    """The k-th fault of a kind: the first draw that slips and, of events, rests in time. probe: (time to rest or None,
    final slip) of a case's run."""
    name = f"{kind}_{k + 1:02d}"
    path, row = os.path.join(folder, f"{name}.h5"), KINDS[kind]
    for attempt in range(200):
        random = np.random.default_rng([seed, list(KINDS).index(kind), k, attempt])
        case, margin, least = (event if kind in EVENTS else rupture)(random, row, k, path)
        case.name, case.group = name, f"{kind} {case.group}"
        rest, slip = probe(case)
        if slip >= least and (rest or kind in RUPTURES):
            case.duration = rounded(min(margin * rest, case.duration) if rest else case.duration)
            return case
    raise RuntimeError(f"{name}: no draw of 200 slips and rests within {LIMIT} periods over 2 pi")
