#!/usr/bin/env python3
"""Make the mesh and the fields of a network of faults for examples/network.sh: NAME_mesh.h5 and NAME_fields.h5.

    network.py NAME --faults 8 --triangles 3000       random sections, of one --seed
    network.py NAME --faults 50 --triangles 100000 --sections SECTIONS.geojson RATES.geojson \\
        --box -118.9 -115.4 32.6 35.2                 those of files, here of southern California

Sections of files are features of GeoJSON, a trace of longitudes and latitudes each, with the properties FaultID,
FaultName, DipDeg, DipDir (N, NE, ..., Vertical), Rake, UpDepth and LowDepth [km] and SlipRate [mm/a] of the US National
Seismic Hazard Model of 2023, which is in the public domain: https://doi.org/10.5066/P9AU713N has sections and rates.
Properties of one FaultID in several files are put together.

Each section becomes rows of triangles along its trace, which are moved down its dip. The faster of two sections that
meet is whole; the other ends about a triangle before it.
"""

import argparse
import json
import os
import sys
from dataclasses import dataclass

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need, one_line

need("h5py", "numpy")
import h5py
import numpy as np
from slipstep.errors import OutputError
from slipstep.results.files import replacing, write_fields
from slipstep.times import YEAR

EARTH = 6371e3  # radius [m]
COMPASS = {name: np.radians(45 * k) for k, name in enumerate(("N", "NE", "E", "SE", "S", "SW", "W", "NW"))}
NEAR = 5e3  # a trace that ends so far from another one goes on there [m]
KEPT = 0.3  # of a section's triangles: one that loses more to others is left out
GAP = 0.6  # between points of faults, at least, in sides: those of triangles that cross are within 2/sqrt(12)
WEAK, STRONG, B = 0.004, 0.022, 0.015  # a where friction weakens and strengthens; b as in network.opts
EDGE, CHANGE = 500.0, 1.5e3  # friction strengthens so near to edges, and changes over the next metres
CYCLE = 20.0  # ln of the rate within events over that of loading
PHASES = 0.1, 0.9  # of a cycle, at the start
# numbers of the cubes of a lattice by their places, and those of a cube and its neighbours less its own
LATTICE = np.array([1, 2**20, 2**40], np.int64)
AROUND = np.array([LATTICE @ step for step in np.ndindex(3, 3, 3)]) - LATTICE.sum()


@dataclass
class Section:
    name: str
    trace: np.ndarray  # [n, 2], north and east [m]; the dip is down to its right
    dip: float  # [degrees]
    rake: float
    depths: tuple  # of the edges [m]
    rate: float  # [m/s]

    @property
    def chord(self):
        along = self.trace[-1] - self.trace[0]
        return along / np.linalg.norm(along)

    @property
    def length(self):
        return np.linalg.norm(np.diff(self.trace, axis=0), axis=1).sum()

    @property
    def width(self):
        return (self.depths[1] - self.depths[0]) / np.sin(np.radians(self.dip))


def read(paths, box):
    """Sections of the files whose traces' means are in the box (west, east, south, north), and the box's middle."""
    properties, traces = {}, {}
    for path in paths:
        with open(path, encoding="utf-8") as file:
            features = json.load(file)["features"]
        for feature in features:
            own, shape = feature["properties"], feature["geometry"]
            properties.setdefault(own["FaultID"], {}).update(own)
            parts = shape["coordinates"] if shape["type"] == "MultiLineString" else [shape["coordinates"]]
            traces[own["FaultID"]] = np.concatenate([np.array(part, float)[:, :2] for part in parts])
    west, east, south, north = box
    middle = (south + north) / 2, (west + east) / 2
    return [section(properties[number], trace, middle) for number, trace in traces.items()
            if west < trace[:, 0].mean() < east and south < trace[:, 1].mean() < north
            and properties[number].get("SlipRate")], middle


def section(own, degrees, middle):
    """One of properties and longitudes and latitudes: lengths along circles of latitude are those of the middle."""
    places = np.radians(degrees[:, ::-1] - middle) * EARTH * (1, np.cos(np.radians(middle[0])))
    places = places[np.append(True, np.linalg.norm(np.diff(places, axis=0), axis=1) > 0)]
    found = Section(own["FaultName"], places, own["DipDeg"], own["Rake"],
                    (own["UpDepth"] * 1e3, own["LowDepth"] * 1e3), own["SlipRate"] * 1e-3 / YEAR)
    if own["DipDir"] in COMPASS:
        towards = COMPASS[own["DipDir"]]
        if np.dot((-found.chord[1], found.chord[0]), (np.cos(towards), np.sin(towards))) < 0:
            found.trace = places[::-1]
    return found


def draw_sections(count, seed):
    """Random ones, whose numbers are like those of southern California: lengths of 30 to 80 km, rates from 1 to 34
    mm/a, of which few are fast, right-lateral faults of strikes around 310 degrees and a third of thrusts across, in a
    square that they fill as densely."""
    random = np.random.default_rng(seed)
    extent = np.sqrt(count * 50e3 * 25e3)
    for k in range(count):
        length, thrust = random.uniform(30e3, 80e3), k % 3 == 2
        strike = np.radians((280 if thrust else 312) + random.normal(0, 8))
        bends = strike + np.radians(random.normal(0, 6, 5))
        trace = np.cumsum(np.vstack([random.uniform(0, extent, 2),
                                     length / 5 * np.stack([np.cos(bends), np.sin(bends)], axis=1)]), axis=0)
        yield Section(f"Thrust {k + 1}" if thrust else f"Strike-slip {k + 1}", trace - length / 2 * np.array(
            [np.cos(strike), np.sin(strike)]), 45.0 if thrust else 90.0, 90.0 if thrust else 180.0,
            (0.0, random.uniform(12e3, 16e3)), (34e-3 / (k + 1) ** 0.8 + 1e-3) / YEAR)


def drape(own, side):
    """Vertices [v, 3] in rows down the dip, every second one shifted by half a side, triangles [n, 3], and of the
    vertices the distances along the trace and down the dip."""
    nx, nz = max(round(own.length / side), 2), max(round(own.width / (side * np.sqrt(3) / 2)), 2)
    whole = np.arange(nx + 1) / nx
    half = np.concatenate([[0], (np.arange(nx) + 0.5) / nx, [1]])
    rows = [half if row % 2 else whole for row in range(nz + 1)]
    along = np.concatenate(rows) * own.length
    down = np.repeat(np.arange(nz + 1) / nz, [len(row) for row in rows]) * own.width
    steps = np.append(0, np.cumsum(np.linalg.norm(np.diff(own.trace, axis=0), axis=1)))
    places = np.stack([np.interp(along, steps, own.trace[:, axis]) for axis in (0, 1)], axis=1)
    dip, right = np.radians(own.dip), np.array([-own.chord[1], own.chord[0]])
    vertices = np.column_stack([places + down[:, None] * np.cos(dip) * right, own.depths[0] + down * np.sin(dip)])
    first = np.cumsum([0] + [len(row) for row in rows])
    triangles = []
    for row in range(nz):
        p, q = (first[row], first[row + 1]) if row % 2 == 0 else (first[row + 1], first[row])  # whole, half
        k = np.arange(nx)
        triangles.append(np.stack([p + k, p + k + 1, q + k + 1], axis=1))
        k = np.arange(nx + 1)
        triangles.append(np.stack([p + k, q + k, q + k + 1], axis=1))
    return vertices, np.concatenate(triangles), along, down


def cubes(corners, size):
    """Numbers of the cubes of a lattice that hold points of triangles [n, 3, 3]: corners, middles of sides, centroids
    [n, 7]."""
    points = np.concatenate([corners, (corners + np.roll(corners, 1, axis=1)) / 2,
                             corners.mean(axis=1, keepdims=True)], axis=1)
    return np.floor(points / size).astype(np.int64) @ LATTICE


def largest_part(triangles):
    """Which triangles [n] belong to the largest part that shares sides: labels spread to neighbours."""
    sides = np.sort(np.concatenate([triangles[:, pair] for pair in ((0, 1), (1, 2), (2, 0))]), axis=1)
    _, number = np.unique(sides, axis=0, return_inverse=True)
    number = number.reshape(3, -1).T
    label, before = np.arange(len(triangles)), None
    while before is None or (label != before).any():
        before = label.copy()
        least = np.full(number.max() + 1, len(triangles))
        np.minimum.at(least, number, label[:, None])
        label = least[number].min(axis=1)
    return label == np.bincount(label).argmax()


def place(sections, count, side):
    """The first so many sections as (section, vertices, triangles, along, down), each without triangles that are near
    those before it; those that lose too much are left out."""
    found, taken = [], np.zeros(0, np.int64)
    for own in sections:
        vertices, triangles, along, down = drape(own, side)
        own_cubes = cubes(vertices[triangles], GAP * side)
        keep = ~np.isin(own_cubes, taken).any(axis=1)
        if keep.sum() < KEPT * len(keep):
            continue
        keep[keep] = largest_part(triangles[keep])
        if keep.sum() < KEPT * len(keep):
            continue
        taken = np.union1d(taken, (np.unique(own_cubes[keep])[:, None] + AROUND).ravel())
        found.append((own, vertices, triangles[keep], along, down))
        if len(found) == count:
            return found
    raise OutputError(f"only {len(found)} faults keep {KEPT:.0%} of their triangles beside others, expected {count}: a "
                      "larger --box, or fewer --faults")


def fit(sections, count, triangles):
    """The same with about so many triangles, and their side [m]."""
    side = np.sqrt(sum(own.length * own.width for own in sections[:count]) / triangles / (np.sqrt(3) / 4))
    for _ in range(4):
        found = place(sections, count, side)
        number = sum(len(part[2]) for part in found)
        if abs(number / triangles - 1) < 0.005:
            break
        side *= np.sqrt(number / triangles)
    return found, side


def strengthens(k, found):
    """How far [m] each triangle's centroid is within the edges where friction strengthens: the ground, the lower edge,
    and ends of the trace that are far from other faults. Below 0: outside of them."""
    own, _, triangles, along, down = found[k]
    s, d = along[triangles].mean(axis=1), down[triangles].mean(axis=1)
    others = [part[1][part[4] == 0, :2] for j, part in enumerate(found) if j != k]
    reach = [own.width - d] + ([d] if own.depths[0] == 0 else [])
    for end, distance in ((0, s), (-1, own.length - s)):
        if all(np.linalg.norm(trace - own.trace[end], axis=1).min() > NEAR for trace in others):
            reach.append(distance)
    return EDGE - np.min(reach, axis=0)


def make(name, sections, count, triangles, seed):
    sections = sorted(sections, key=lambda own: -own.rate)
    found, side = fit(sections, count, triangles)
    sizes = [len(part[2]) for part in found]
    first = np.cumsum([0] + [len(part[1]) for part in found])
    vertices, rows = np.concatenate([part[1] for part in found]), np.concatenate(
        [part[2] + start for part, start in zip(found, first)])
    used, rows = np.unique(rows, return_inverse=True)
    with replacing(f"{name}_mesh.h5") as part, h5py.File(part, "w") as file:
        file["vertices"], file["triangles"] = vertices[used], rows.reshape(-1, 3)
        file["vertices"].attrs["units"] = "m"
        file["fault"] = np.repeat(np.arange(1, count + 1), sizes)
        file["fault"].attrs["names"] = "; ".join(f"{k} {own.name.replace(';', ',')}"
                                                 for k, (own, *_) in enumerate(found, 1))
    a = np.concatenate([np.interp(strengthens(k, found), [-CHANGE, 0], [WEAK, STRONG]) for k in range(count)])
    rate, rake = (np.repeat([getattr(part[0], what) for part in found], sizes) for what in ("rate", "rake"))
    phase = np.repeat(np.random.default_rng(seed).uniform(*PHASES, count), sizes)
    # stress that is lower than the steady one by a share of an event's drop, at a rate that is lower by its exponential
    start = rate * np.exp(-np.maximum(B - a, 0) / a * CYCLE * (1 - phase))
    write_fields(f"{name}_fields.h5", {"friction_a": (a, "1"), "rake": (rake, "degrees"), "loading_rate": (rate, "m/s"),
                                       "initial_rate": (start, "m/s")})
    for (own, *_), size in zip(found, sizes):
        print(f"{own.name:50s} {own.length / 1e3:4.0f} km, dip {own.dip:2g}, rake {own.rake:3g}, "
              f"{own.rate * YEAR * 1e3:5.2f} mm/a, {size} triangles")
    print(f"{count} faults, {sum(sizes)} triangles of {side:.0f} m")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", metavar="NAME")
    parser.add_argument("--faults", type=int, default=8, metavar="N", help="the fastest of the sections")
    parser.add_argument("--triangles", type=int, default=3000, metavar="N", help="of all faults, about")
    parser.add_argument("--sections", nargs="+", metavar="FILE", help="GeoJSON with traces, properties and rates")
    parser.add_argument("--box", type=float, nargs=4, default=(-180, 180, -90, 90),
                        metavar=("WEST", "EAST", "SOUTH", "NORTH"), help="where means of traces are [degrees]")
    parser.add_argument("--seed", type=int, default=1, help="of the phases at the start, and of random sections")
    a = parser.parse_args()
    if a.faults < 1 or a.triangles < 20 * a.faults:
        parser.error(f"--faults is {a.faults} and --triangles {a.triangles}, expected at least 1, and 20 each")
    with one_line():
        if a.sections:
            sections, middle = read(a.sections, a.box)
            make(a.name, sections, a.faults, a.triangles, a.seed)
            print(f"x and y are north and east of latitude {middle[0]:g}, longitude {middle[1]:g}")
        else:
            make(a.name, draw_sections(2 * a.faults, a.seed), a.faults, a.triangles, a.seed)


if __name__ == "__main__":
    main()
