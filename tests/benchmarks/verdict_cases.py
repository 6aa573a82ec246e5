"""Random faults for the verdict on the accuracy of a run (verdict.py): half of them irregular meshes, three in ten from
ranges much wider than those of the shipped policy's training.

Fault k of a seed is of the kind KINDS[k % 8], with 1 to 400 cells: single cells, uniform grids, planes whose cells are
graded, and two parallel planes, graded or not; or MORE_KINDS[k % 4]: slip as a vector along any rake, dipping faults
whose slip changes their normal stress, and both in one, from a given stress that is above the strength in a patch, of
cells that may open. Parameters are log-uniform in the ranges of RANGES; those of cells vary by random fields. It starts
at its instability. The duration is that of a fine run to rest times a random margin.
"""

import os

import h5py
import numpy as np

import make_mesh
from held_out_cases import Case, fault_options, log_uniform, rounded

KINDS = ["one", "graded", "grid", "two planes", "grid", "graded", "grid", "two planes"]
MORE_KINDS = ["vectors", "dipping", "two planes", "opening"]
WIDE_SHARE = 0.3
# lowest and highest in training, and in the wide share
RANGES = {
    "length_x": ((500, 20e3), (100, 100e3)),  # m
    "thickness": ((0.5, 2), (0.2, 5)),  # length_x
    "damping_ratio": ((0.1, 0.6), (0.03, 1.2)),
    "normal_stress": ((5e6, 150e6), (1e6, 400e6)),  # Pa
    "friction_residual": ((0.2, 0.7), (0.1, 0.9)),
    "friction_drop": ((0.03, 0.3), (0.01, 0.6)),
    "weakening": ((1.5, 15), (1.2, 50)),  # stress drop over d_c, over the stiffness
    "initial_perturbation": ((1e-6, 1e-3), (1e-8, 1e-2)),
    "margin": ((1.2, 3.5), (1.05, 10)),  # duration over the time to rest
    "spread": ((0.02, 0.4), (0.1, 0.9)),  # standard deviation of the logarithm of a field
}
SHARE_MEAN_SLIP = 0.3  # of the faults with -fault_stiffness_scaling mean_slip
LIMIT = 400  # a fault that does not rest by then is drawn again [T*]


def mesh(random, kind, length):
    """Rows [n, 5] of cells."""
    cells = [3 + int(12 * random.random()), 3 + int(12 * random.random())]
    size = [length, rounded(length * log_uniform(random, 0.4, 1.5))]
    top = 0 if random.random() < 0.5 else log_uniform(random, 100, 5e3)
    ratio = log_uniform(random, 1.5, 8) if kind == "graded" or random.random() < 0.5 else 1
    rows = make_mesh.plane(cells, size, top, ratio)
    if kind == "graded":
        return rows
    offset, shift = log_uniform(random, 0.1, 1) * length, (random.random() - 0.5) * length
    return np.concatenate([rows, make_mesh.plane(cells, size, top, ratio, x0=shift, y=offset)])


def fields(random, p, spread, x, z):
    """Per-cell parameters at positions in units of the length; three in ten are uniform but for the stress."""
    n = len(x)
    stress = p["normal_stress"] * (2 * (z - z.min() + 0.05) / (z.max() - z.min() + 0.1) if random.random() < 0.4
                                   and n > 1 else np.ones(n))
    mean = {"normal_stress": stress, "friction_drop": p["friction_drop"], "friction_residual": p["friction_residual"],
            "friction_slip": 1.0}
    smooth = random.random() < 0.3 or n == 1
    return {name: value * np.exp((0 if smooth or random.random() < 0.25
                                  else spread * (0.3 if name == "friction_residual" else 1)) * waves(random, x, z))
            for name, value in mean.items()}


def waves(random, x, z):
    """Zero mean and unit variance over the cells: plane waves of up to two periods and white noise, as in
    held_out_cases.random_field(), at any positions."""
    field = np.zeros(len(x))
    for _ in range(6):
        kx, kz, phase = random.random(3)
        field += np.cos(2 * np.pi * (2 * kx * x + (4 * kz - 2) * z + phase))
    field = field / (field.std() or 1) + random.standard_normal(len(x)) / 3
    return (field - field.mean()) / (field.std() or 1)


def draw(random, kind, name, folder):
    """A fault and the margin of its duration; its duration is the limit."""
    wide = random.random() < WIDE_SHARE
    p = {key: rounded(log_uniform(random, *ranges[wide])) for key, ranges in RANGES.items()}
    margin, spread, weakening, length = (p.pop(key) for key in ("margin", "spread", "weakening", "length_x"))
    thickness = rounded(p.pop("thickness") * length)
    scaled = random.random() < SHARE_MEAN_SLIP and kind != "opening"
    path = os.path.join(folder, name + ".h5")
    more = []
    if kind in ("dipping", "opening"):
        cells, size = [4 + int(9 * random.random()),
                       4 + int(7 * random.random())], [length, rounded(length * log_uniform(random, 0.4, 1.2))]
        top = (rounded(length / cells[0]) if kind == "opening" else 0 if random.random() < 0.5
               else rounded(log_uniform(random, 100, 5e3)))
        rows = make_mesh.listric(cells, size, top, 1, 0,
                                 [rounded(20 + (20 if kind == "opening" else 60) * random.random())] * 2)
        geometry, shape = {"mesh": path}, (len(rows),)
        x, z, area = rows[:, 0] / length, rows[:, 2] / length, np.prod(size)
        rake = 90 if kind == "opening" or random.random() < 0.5 else 360 * random.random() - 180
        more = ["-fault_rake", f"{rounded(rake):g}"]
        more += ["-fault_slip_components", "2", "-fault_opening", "yes", "-fault_initial", "traction",
                 "-fault_initial_unstable", "-fault_inertia", "yes"] if kind == "opening" else []
    elif kind in ("graded", "two planes"):
        rows = mesh(random, kind, length)
        geometry = {"mesh": path}
        x, z, area = rows[:, 0] / length, rows[:, 2] / length, np.ptp(rows[:, 0]) * np.ptp(rows[:, 2])
        shape = (len(rows),)
    else:
        nx, nz = (1, 1) if kind == "one" else (2 + int(17 * random.random()) for _ in range(2))
        size_z = length if kind == "one" else rounded(length * nz / nx * log_uniform(random, 0.5, 2))
        top = 0 if random.random() < 0.5 else rounded(log_uniform(random, 100, 5e3))
        geometry = {"nx": nx, "nz": nz, "length_x": length, "length_z": size_z, "depth_top": top}
        if kind == "vectors":
            more = ["-fault_slip_components", "2", "-fault_rake", f"{rounded(360 * random.random() - 180):g}"]
        z, x = (g.ravel() for g in np.meshgrid((np.arange(nz) + 0.5) * size_z / nz / length, (np.arange(nx) + 0.5) / nx,
                                               indexing="ij"))
        area, shape, rows = length * size_z, (nz, nx), None
    f = fields(random, p, spread, x, z)
    # the stiffness against uniform slip of all cells, roughly; exactly that of mean_slip
    stiffness = 30e9 / thickness if scaled else 30e9 / np.sqrt(area) * (2.3 - 1.3 / np.sqrt(len(x)))
    f["friction_slip"] *= float((f["normal_stress"] * f["friction_drop"]).mean()) / stiffness / weakening
    if kind == "opening":
        down, share, radius = (z - z.min()) / np.ptp(z), 0.3 + 0.4 * random.random(), 0.25 + 0.2 * random.random()
        f["normal_stress"] *= 0.005 + 0.5 * down
        share = np.where(np.hypot((x - x.mean()) / np.ptp(x), down - 0.5) < radius, 1.02, share)
        f["initial_traction"] = f["normal_stress"] * (f["friction_residual"] + share * f["friction_drop"])
    with h5py.File(path, "w") as file:
        if rows is not None:
            file["cells"] = rows
            file["cells"].attrs["columns"] = make_mesh.COLUMNS + (" strike dip" if rows.shape[1] == 7 else "")
            file["cells"].attrs["units"] = "m"
        for key, value in f.items():
            file[key] = value.reshape(shape)
    tstar = thickness * np.sqrt(2500 / 30e9)
    options = [word for key, value in geometry.items()
               for word in (f"-fault_{key}", value if key == "mesh" else f"{value:.10g}")]
    options += fault_options({"thickness": thickness, "damping_ratio": p["damping_ratio"],
                              "initial_perturbation": p["initial_perturbation"]})
    options += ["-fault_parameters", path, "-fault_stiffness_scaling", "mean_slip" if scaled else "none", *more]
    return Case(name, kind + (", wide" if wide else ""), options, tstar, rounded(LIMIT * tstar), [], path), margin
