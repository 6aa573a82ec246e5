#!/usr/bin/env python3
"""Make the mesh and the stress of two faults side by side for examples/step_over.sh, and plot how far a rupture jumps.

    step_over.py make NAME --cells 40 20 --distance 1000    NAME_mesh.h5 and NAME_fields.h5; a distance < 0 is to the
                                                            left
    step_over.py plot NAME                                  runs NAME_DISTANCE_{yes,no}.h5 to NAME.png
"""

import argparse
import glob
import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need, one_line

need("h5py", "numpy", "matplotlib")
import make_mesh
import numpy as np
from slipstep import OutputError, Run
from slipstep.plots.panels import RUN_STYLES, plt, use_style
from slipstep.results.files import write_fields

SIZE = 20e3, 10e3  # of each fault, along strike and in depth [m]
OVERLAP = 5e3  # [m]
STRESS, STRENGTH = 76e6, (0.525 + 0.152) * 120e6  # [Pa]
PATCH = 6e3, 5e3, 3e3  # centre and radius [m]
JUMPED = 0.1  # m of mean slip of the second fault


def make(name, cells, distance):
    def plane(x0, y):
        x, z = np.meshgrid(x0 + (np.arange(cells[0]) + 0.5) * SIZE[0] / cells[0],
                           (np.arange(cells[1]) + 0.5) * SIZE[1] / cells[1])
        return np.stack([x, np.full_like(x, y), z, np.full_like(x, SIZE[0] / cells[0]),
                         np.full_like(x, SIZE[1] / cells[1])], axis=-1).reshape(-1, 5)

    rows = np.concatenate([plane(0.0, 0.0), plane(SIZE[0] - OVERLAP, distance)])
    make_mesh.write(f"{name}_mesh.h5", rows)
    patch = (rows[:, 1] == 0) & (np.hypot(rows[:, 0] - PATCH[0], rows[:, 2] - PATCH[1]) < PATCH[2])
    write_fields(f"{name}_fields.h5", {"initial_traction": (np.where(patch, 1.01 * STRENGTH, STRESS), "Pa")})


def final(path):
    """Final slip [m] of both faults as maps [nz, nx], and their edges along strike and in depth [km]."""
    run = Run(path)
    slip, mesh = run.field("slip")[1][-1], run.mesh
    maps = []
    for own in (mesh["y"] == 0, mesh["y"] != 0):
        x, z = np.unique(mesh["x"][own]), np.unique(mesh["z"][own])
        order = np.lexsort((mesh["x"][own], mesh["z"][own]))
        half = mesh["length"][0] / 2, mesh["width"][0] / 2
        edges = [np.append(axis - side, axis[-1] + side) / 1e3 for axis, side in ((x, half[0]), (z, half[1]))]
        maps.append((*edges, slip[own][order].reshape(len(z), len(x))))
    return maps


def runs(name):
    """Runs by distance [m] and coupling."""
    found = {}
    for path in glob.glob(f"{glob.escape(name)}_*.h5"):
        match = re.fullmatch(r"_(-?[0-9.]+)_(yes|no)\.h5", path[len(name):])
        if match:
            found[float(match[1]), match[2]] = path
    if not found:
        raise OutputError(f"{name}_DISTANCE_yes.h5, ...: no such files; examples/step_over.sh makes them")
    return found


def draw_jumps(axes, slips):
    for k, (side, what) in enumerate(((1, "to the right, compressional"), (-1, "to the left, extensional"))):
        for coupling, marker, line in (("yes", "o", "-"), ("no", "s", ":")):
            points = sorted((abs(d), slip) for (d, c), slip in slips.items() if c == coupling and d * side > 0)
            if points:
                axes.plot(*zip(*points), color=RUN_STYLES[k]["color"], marker=marker, linestyle=line,
                          markerfacecolor="none" if coupling == "no" else None,
                          label=f"{what}, "
                                f"{'normal stress follows slip' if coupling == 'yes' else 'shear stress alone'}")
    axes.set(xlabel="distance between the faults (m)", ylabel="mean slip of the second fault (m)",
             title="How far the rupture jumps")
    axes.legend(fontsize=8, loc="upper right")


def draw_maps(canvas, rows, found, distance):
    """Final slip of both faults with and without, at one distance."""
    maps = {coupling: final(found[distance, coupling]) for coupling in ("yes", "no")}
    most = max(m[2].max() for pair in maps.values() for m in pair)
    for row, (coupling, what) in zip(rows, (("yes", "normal stress follows slip"), ("no", "shear stress alone"))):
        for axes, (x, z, slip), name in zip(row, maps[coupling], ("first fault", "second fault")):
            image = axes.pcolormesh(x, z, slip, vmin=0, vmax=most, cmap="viridis", rasterized=True)
            axes.set(aspect="equal", xlabel="along strike (km)", ylabel="depth (km)")
            axes.set_title(f"{name}, {abs(distance):g} m to the {'right' if distance > 0 else 'left'}: {what}"
                           if name == "second fault" else name, fontsize=9)
            axes.invert_yaxis()
            axes.grid(False)
    canvas.colorbar(image, ax=list(np.ravel(rows)), label="final slip (m)", shrink=0.8, aspect=30)


def reach(slips, side, coupling):
    """The longest distance [m] over which the rupture jumps from there down to the shortest; 0: over none."""
    longest = 0.0
    for distance, slip in sorted((abs(d), slip) for (d, c), slip in slips.items() if c == coupling and d * side > 0):
        if slip < JUMPED:
            break
        longest = distance
    return longest


def plot(name):
    found = runs(name)
    slips = {key: float(final(path)[1][2].mean()) for key, path in found.items()}
    for side, what in ((1, "right (compressional)"), (-1, "left (extensional)")):
        print(f"to the {what}: the rupture jumps {reach(slips, side, 'yes'):g} m where normal stress follows slip, "
              f"{reach(slips, side, 'no'):g} m by shear stress alone")
    use_style()
    canvas = plt.figure(figsize=(11, 10), layout="constrained")
    grid = canvas.add_gridspec(3, 2, height_ratios=(1.5, 1, 1))
    draw_jumps(canvas.add_subplot(grid[0, :]), slips)
    distances = sorted({d for d, _ in found if (d, "yes") in found and (d, "no") in found},
                       key=lambda d: (-abs(slips[d, "yes"] - slips[d, "no"]), abs(d)))
    draw_maps(canvas, [[canvas.add_subplot(grid[row, column]) for column in range(2)] for row in (1, 2)], found,
              distances[0])
    canvas.savefig(f"{name}.png")
    print(f"Figure: {name}.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", choices=["make", "plot"])
    parser.add_argument("name", metavar="NAME")
    parser.add_argument("--cells", type=int, nargs=2, default=[40, 20], metavar=("NX", "NZ"), help="of each fault")
    parser.add_argument("--distance", type=float, default=1000, metavar="M",
                        help="of the second fault, to the right of the first [m]")
    a = parser.parse_args()
    if min(a.cells) < 1 or a.distance == 0:
        parser.error("--cells must be at least 1 each way, and --distance not 0")
    with one_line():
        make(a.name, a.cells, a.distance) if a.work == "make" else plot(a.name)


if __name__ == "__main__":
    main()
