#!/usr/bin/env python3
"""Make the fault, its patches and the well of examples/shut_in.sh.

    shut_in.py NAME --cell 100     NAME_mesh.h5, triangles of a fault that is not flat, NAME_fields.h5, weak patches at
                                   random places, each of which fails at a pressure of its own, and NAME_wells.csv
"""

import argparse
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need, one_line

need("h5py", "numpy")
import h5py
import numpy as np
from slipstep.results.files import write_fields

SIZE, TOP = 8e3, 2e3  # of the fault along strike and in depth, and of its upper edge [m]
WAVES = ((120.0, 1, 0.3), (50.0, 2, 1.1))  # its distance from a plane: amplitudes [m], waves along each side, phases
JITTER = 0.2  # of cells: how far vertices within the fault are moved, so that triangles are of any shape
RADIUS, APART, TRIES = 300.0, 900.0, 20000  # of patches, between their centres [m], and for a free place
STRESS, STRENGTH, REST, DROP = 40e6, 0.6, 0.42, 0.03  # normal [Pa], friction, shear stress beside patches over normal
PRESSURES = 5e4, 8e5  # at which patches fail: from and to, uniform in the logarithm [Pa]
RATE, STOP = 650.0, 30.0  # of the well [m^3/day], and when it is shut in [days]


def bend(x, z):
    """Distance east of the plane [m] at north x and depth z below the upper edge."""
    return sum(size * np.cos(2 * np.pi * (count * x / SIZE + phase)) * np.cos(np.pi * count * z / SIZE + phase)
               for size, count, phase in WAVES)


def surface(cell):
    """Vertices [V, 3], north, east and down, and triangles [N, 3]: their rows."""
    n, rng = round(SIZE / cell), np.random.default_rng(1)
    i, j = (part.ravel() for part in np.meshgrid(np.arange(n + 1), np.arange(n + 1)))
    inside = (i % n > 0) & (j % n > 0)
    x, z = ((k + inside * rng.uniform(-JITTER, JITTER, len(k))) * SIZE / n for k in (i, j))
    p = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    q, r, s = p + 1, p + n + 1, p + n + 2
    odd = ((p % (n + 1) + p // (n + 1)) % 2 == 1)[:, None, None]
    triangles = np.where(odd, np.stack([np.stack([p, q, s], 1), np.stack([p, s, r], 1)], 1),
                         np.stack([np.stack([p, q, r], 1), np.stack([q, s, r], 1)], 1)).reshape(-1, 3)
    return np.column_stack([x, bend(x, z), TOP + z]), triangles


def patches(rng):
    """Centres [n, 2] in the plane, none within APART of another or of the well, nor at the border."""
    found = [np.full(2, SIZE / 2)]
    for place in rng.uniform(1.2 * RADIUS, SIZE - 1.2 * RADIUS, (TRIES, 2)):
        if np.linalg.norm(place - found, axis=1).min() > APART:
            found.append(place)
    return np.array(found[1:])


def make(name, cell):
    vertices, triangles = surface(cell)
    rng = np.random.default_rng(2)
    places = patches(rng)
    limits = np.exp(rng.uniform(*np.log(PRESSURES), len(places)))
    centres = vertices[triangles].mean(axis=1)
    away = np.linalg.norm(centres[:, None, (0, 2)] - (0, TOP) - places, axis=2)
    own, weak = away.argmin(axis=1), away.min(axis=1) < RADIUS
    with h5py.File(f"{name}_mesh.h5", "w") as file:
        file["vertices"], file["triangles"] = vertices, triangles
        file["vertices"].attrs["units"] = "m"
    write_fields(f"{name}_fields.h5", {
        "friction_drop": (np.where(weak, DROP, 0.0), "1"),
        "friction_residual": (STRENGTH - np.where(weak, DROP, 0.0), "1"),
        "initial_traction": (np.where(weak, STRENGTH * (STRESS - limits[own]), REST * STRESS), "Pa")})
    with open(f"{name}_wells.csv", "w") as file:
        middle = centres[np.linalg.norm(centres[:, (0, 2)] - (SIZE / 2, TOP + SIZE / 2), axis=1).argmin()]
        place = ",".join(f"{value:.3f}" for value in middle)
        print("well,x,y,z,days,m3/day", f"A,{place},0,{RATE:g}", f"A,{place},{STOP:g},0", sep="\n", file=file)
    print(f"{len(triangles)} triangles, {len(places)} patches")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", metavar="NAME")
    parser.add_argument("--cell", type=float, default=280.0, metavar="M", help="shorter sides of triangles, about [m]")
    a = parser.parse_args()
    if not 0 < a.cell <= 500:
        parser.error(f"--cell is {a.cell:g}, expected a number > 0 up to 500")
    with one_line():
        make(a.name, a.cell)


if __name__ == "__main__":
    main()
