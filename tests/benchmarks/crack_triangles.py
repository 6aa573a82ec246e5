#!/usr/bin/env python3
"""How accurate unstructured triangles are: a circular crack of uniform stress drop, whose slip is known, in a full
space.

    tests/benchmarks/crack_triangles.py [--build build] [--across 10 20 40] [--rake 0 37 90] [--jitter 0.25 | --gmsh]

The disc is meshed by Gmsh (python3-gmsh), or by points of a triangular lattice that are moved at random by `--jitter`
of their distance.
Slip along each rake is that of K u = drop by the stiffness of the program, and exact as in crack.py for any rake
(Eshelby 1957). Printed are the root mean square of its error, over all cells and over those within 0.7 of the radius,
and the error of the moment; and of the stress that slip in proportion to x makes within half of the radius, the root
mean square about a smooth course (a cubic), over G/radius times that slip: stress at centroids keeps such an
oscillation however small the triangles are (Noda 2025), averages over cells do not.
"""

import argparse
import os
import tempfile

import crack
from crack import G, RADIUS, DEPTH, np, h5py

from matplotlib.tri import Triangulation


def lattice(across, jitter, seed=1):
    h = 2 * RADIUS / across
    border = 2 * np.pi * np.arange(max(6, round(np.pi * across))) / max(6, round(np.pi * across))
    i, j = np.mgrid[-across:across + 1, -2 * across:2 * across + 1].reshape(2, -1)
    points = np.stack([h * (i + 0.5 * (j % 2)), h * np.sqrt(0.75) * j], axis=1)
    points += jitter * h * np.random.default_rng(seed).standard_normal(points.shape)
    points = points[np.hypot(*points.T) < RADIUS - 0.6 * h]
    points = np.concatenate([RADIUS * np.stack([np.cos(border), np.sin(border)], axis=1), points])
    return points, Triangulation(*points.T).triangles


def gmsh_disc(across):
    import gmsh

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.occ.addDisk(0, 0, 0, RADIUS, RADIUS)
    gmsh.model.occ.synchronize()
    for end in ("Min", "Max"):
        gmsh.option.setNumber(f"Mesh.MeshSize{end}", 2 * RADIUS / across)
    gmsh.model.mesh.generate(2)
    tags, points, _ = gmsh.model.mesh.getNodes()
    place = {tag: k for k, tag in enumerate(tags)}
    kinds, _, nodes = gmsh.model.mesh.getElements(2)
    triangles = np.array([place[tag] for tag in nodes[list(kinds).index(2)]]).reshape(-1, 3)
    gmsh.finalize()
    return points.reshape(-1, 3)[:, :2], triangles


def measure(points, triangles, S, poisson):
    corner = points[triangles]
    a, b = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    area, centre = abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2, corner.mean(axis=1)
    r = np.hypot(*centre.T) / RADIUS
    largest = 8 * (1 - poisson) / (np.pi * (2 - poisson)) / G * RADIUS
    slip = np.linalg.solve(S, area / area.mean())
    wrong = slip / largest - np.sqrt(np.maximum(1 - r**2, 0))
    x, y = centre[r < 0.5].T / RADIUS
    stress = (S @ (centre[:, 0] / RADIUS) * area.mean() / area)[r < 0.5] / (G / RADIUS)
    smooth = np.stack([np.ones_like(x), x, y, x**3, x * y**2], axis=1)
    rest = stress - smooth @ np.linalg.lstsq(smooth, stress, rcond=None)[0]
    inner = r < 0.7
    return (*(np.sqrt(wrong[own]**2 @ area[own] / area[own].sum()) for own in (r < 2, inner)),
            slip @ area / (largest * 2 / 3 * np.pi * RADIUS**2) - 1, rest.std())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.path.join(crack.ROOT, "build"))
    parser.add_argument("--across", type=int, nargs="+", default=[10, 20, 40])
    parser.add_argument("--rake", type=float, nargs="+", default=[0, 37, 90])
    parser.add_argument("--jitter", type=float, default=0.25)
    parser.add_argument("--gmsh", action="store_true")
    parser.add_argument("--poisson", type=float, default=0.25)
    a = parser.parse_args()
    print("across  cells  average  rake       rms    inside    moment  oscillation")
    with tempfile.TemporaryDirectory() as folder:
        for across in a.across:
            points, triangles = gmsh_disc(across) if a.gmsh else lattice(across, a.jitter)
            mesh = os.path.join(folder, "mesh.h5")
            with h5py.File(mesh, "w") as file:
                file["vertices"] = np.stack([points[:, 0], 0 * points[:, 0], DEPTH + points[:, 1]], axis=1)
                file["triangles"] = triangles
            for average in ("centre", "cell"):
                for rake in a.rake:
                    S = crack.stiffness(os.path.abspath(a.build), mesh, len(triangles), average, a.poisson, folder,
                                        "-fault_rake", str(rake))
                    rms, inside, moment, rest = measure(points, triangles, S, a.poisson)
                    print(f"{across:6d}  {len(triangles):5d}  {average:7}  {rake:4g}  {100 * rms:7.2f}%  "
                          f"{100 * inside:7.2f}%  {100 * moment:7.2f}%" f"  {rest:11.4f}", flush=True)


if __name__ == "__main__":
    main()
