#!/usr/bin/env python3
"""Mesh files for -fault_mesh: rectangular cells on planes, and triangles by Gmsh.

    make_mesh.py OUT.h5 uniform --cells 20 20 --size 3000 3000
    make_mesh.py OUT.h5 graded --cells 40 30 --size 3000 3000 --ratio 4
    make_mesh.py OUT.h5 parallel --cells 20 20 --size 3000 3000 --offset 1000 --shift 500
    make_mesh.py OUT.h5 dipping --cells 40 20 --size 20000 10000 --strike 30 --dip 60
    make_mesh.py OUT.h5 listric --cells 40 20 --size 20000 10000 --dip 70 --dip-bottom 20
    make_mesh.py OUT.msh listric --cells 40 20 --size 20000 10000 --dip 70 --dip-bottom 20
    make_mesh.py OUT.h5 segmented --cells 20 20 --size 10000 10000 --strikes 0 20 -10 --dip 70

The first three are vertical, and the file holds /cells [n, 5], one row per cell: x (centre along strike), y (across), z
(centre's depth), length (along strike), width (in depth), all in m, with the attribute columns = "x y z length width".
In graded meshes the widths grow geometrically with depth and the lengths towards both ends, so that the largest is
--ratio times the smallest: small cells are in the middle at the top. Parallel faults lie at y = 0 and y = --offset, the
second --shift further along strike; both may be graded.

The others have /cells [n, 7]: x north, y east, z down, length along strike, width along the dip, and strike and dip in
degrees (src/geometry.md); they may be graded as well. The upper edge begins at x = y = 0 and runs along the strike; the
plane dips to the right of it. Of a listric fault the dip falls from row to row, from --dip at the top to --dip-bottom.
Segments, of --size each, follow each other along strike. Segments that dip meet in lines that are not edges of
rectangles: a row ends where both its edges are still within the segment. This leaves steps, half as large with twice
the rows.
/fault [n] has the number of the segment.

OUT.msh is for triangles, of dipping and listric faults: Gmsh (python3-gmsh) fills the fault without rows, with sides
that are on average as long as those of the cells, and writes its own format. Listric faults are arcs of a circle down
dip; vertices are on the arc, and the cells of OUT.h5 are its chords.
"""

import argparse
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need

need("h5py", "numpy")
import h5py
import numpy as np

COLUMNS = "x y z length width"
VERTICAL = ("uniform", "graded", "parallel")
DIPPING = ("dipping", "listric", "segmented")


def edges_in_depth(n, size, top, ratio):
    """n + 1 depths [m] from top on; the deepest interval is ratio times the shallowest."""
    widths = np.geomspace(1, ratio, n)
    return top + np.concatenate([[0], np.cumsum(widths)]) * size / widths.sum()


def edges_along_strike(n, size, ratio):
    """n + 1 positions [m] from 0 to size, symmetric; the outermost intervals are ratio times those in the middle."""
    distance = np.abs(np.arange(n) - (n - 1) / 2) / max((n - 1) / 2, 1)
    lengths = ratio**distance
    return np.concatenate([[0], np.cumsum(lengths)]) * size / lengths.sum()


def plane(cells, size, top, ratio, x0=0.0, y=0.0):
    """Rows [n, 5] of one plane whose left end is at x0, x fastest."""
    x = x0 + edges_along_strike(cells[0], size[0], ratio)
    z = edges_in_depth(cells[1], size[1], top, ratio)
    cx, cz = np.meshgrid((x[1:] + x[:-1]) / 2, (z[1:] + z[:-1]) / 2)
    lx, lz = np.meshgrid(np.diff(x), np.diff(z))
    return np.stack([cx, np.full_like(cx, y), cz, lx, lz], axis=-1).reshape(-1, 5)


def strip(x, strike, dip, upper, lower):
    """Rows [n, 7] of cells beside each other, between positions x along the strike; upper and lower edge: distance to
    the right of the origin, and depth."""
    a = np.radians(strike)
    middle, right, z = (x[1:] + x[:-1]) / 2, (upper[0] + lower[0]) / 2, (upper[1] + lower[1]) / 2
    return np.column_stack([np.cos(a) * middle - np.sin(a) * right, np.sin(a) * middle + np.cos(a) * right,
                            np.full_like(middle, z), np.diff(x),
                            np.full((len(middle), 3), [np.hypot(*np.subtract(lower, upper)), strike, dip])])


def listric(cells, size, top, ratio, strike, dips):
    """Rows [n, 7] of one fault, x fastest, whose dip goes from dips[0] to dips[1] with the distance down dip."""
    x, down = edges_along_strike(cells[0], size[0], ratio), edges_in_depth(cells[1], size[1], 0, ratio)
    rows, upper = [], np.array([0, top])
    for k in range(cells[1]):
        dip = dips[0] + (dips[1] - dips[0]) * (down[k] + down[k + 1]) / (2 * size[1])
        lower = upper + (down[k + 1] - down[k]) * np.array([np.cos(np.radians(dip)), np.sin(np.radians(dip))])
        rows.append(strip(x, strike, dip, upper, lower))
        upper = lower
    return np.concatenate(rows)


def segmented(cells, size, top, ratio, strikes, dip):
    """Rows [n, 7], and the number of each one's segment. At a distance h to the right of the trace a bend by an angle b
    shortens both segments by h tan(b / 2)."""
    x, down = edges_along_strike(cells[0], size[0], ratio) / size[0], edges_in_depth(cells[1], size[1], 0, ratio)
    c, s = np.cos(np.radians(dip)), np.sin(np.radians(dip))
    bends = np.concatenate([[0], np.tan(np.radians(np.diff(strikes)) / 2), [0]])
    rows, start = [], np.zeros(2)
    for k, strike in enumerate(strikes):
        first = len(rows)
        for upper, lower in zip(down[:-1], down[1:]):
            begin = max(c * d * bends[k] for d in (upper, lower))
            end = min(size[0] - c * d * bends[k + 1] for d in (upper, lower))
            if end <= begin:
                sys.exit(f"make_mesh.py: segment {k} of {size[0]:g} m ends above the lower edge, between its bends: "
                         "expected longer ones, less width or smaller bends")
            rows.append(strip(begin + (end - begin) * x, strike, dip, (c * upper, top + s * upper),
                              (c * lower, top + s * lower)))
        for own in rows[first:]:
            own[:, :2] += start
        start = start + size[0] * np.array([np.cos(np.radians(strike)), np.sin(np.radians(strike))])
    return np.concatenate(rows), np.repeat(np.arange(len(strikes)), cells[0] * cells[1])


def arc(size, top, dips):
    """Where a point is at a distance down dip of a fault whose dip goes from dips[0] to dips[1] with that: a function
    of distances to distances to the right and depths."""
    first, bend = np.radians(dips[0]), np.radians(dips[1] - dips[0]) / size[1]

    def at(down):
        half = bend * down / 2  # a chord has the dip of its middle
        chord = down * np.sinc(half / np.pi)
        return chord * np.cos(first + half), top + chord * np.sin(first + half)
    return at


def write_triangles(path, cells, size, top, strike, dips):
    """A file of Gmsh, of a fault that is a plane or an arc down dip: its plane of distances along strike and down dip
    is filled with triangles, and vertices then moved to where they are in space, which keeps lengths. Returns their
    corners [N, 3, 3], north, east and down, in the file's order."""
    need("gmsh")
    import gmsh
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    side = np.sqrt(size[0] * size[1] / (cells[0] * cells[1]))
    corners = [gmsh.model.geo.addPoint(x, y, 0, side) for x, y in ((0, 0), (size[0], 0), size, (0, size[1]))]
    lines = [gmsh.model.geo.addLine(a, b) for a, b in zip(corners, corners[1:] + corners[:1])]
    surface = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(lines)])
    gmsh.model.geo.synchronize()
    gmsh.model.addPhysicalGroup(2, [surface], 1)
    gmsh.model.setPhysicalName(2, 1, "fault")
    gmsh.model.mesh.generate(2)
    tags, places, _ = gmsh.model.mesh.getNodes()
    a = np.radians(strike)
    along, down, _ = places.reshape(-1, 3).T
    right, depth = arc(size, top, dips)(down)
    places = np.column_stack([np.cos(a) * along - np.sin(a) * right, np.sin(a) * along + np.cos(a) * right, depth])
    for tag, (north, east, depth) in zip(tags, places):
        gmsh.model.mesh.setNode(tag, [east, north, -depth], [])
    of = dict(zip(tags, places))
    corners = np.array([of[tag] for tag in gmsh.model.mesh.getElementsByType(2)[1]]).reshape(-1, 3, 3)
    gmsh.write(path)
    gmsh.finalize()
    return corners


def write(path, rows, label=None):
    with h5py.File(path, "w") as file:
        file["cells"] = rows
        file["cells"].attrs["columns"] = COLUMNS + (" strike dip" if rows.shape[1] == 7 else "")
        file["cells"].attrs["units"] = "m"
        if label is not None:
            file["fault"] = label


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", metavar="OUT.h5", help="or OUT.msh, triangles of a dipping or listric fault")
    parser.add_argument("kind", choices=[*VERTICAL, *DIPPING])
    parser.add_argument("--cells", type=int, nargs=2, default=[20, 20], metavar=("NX", "NZ"), help="of each fault")
    parser.add_argument("--size", type=float, nargs=2, default=[3000, 3000], metavar=("LX", "LZ"),
                        help="of each fault [m]")
    parser.add_argument("--top", type=float, default=0, help="depth of the upper edge [m]")
    parser.add_argument("--ratio", type=float, default=None, help="largest over smallest side (graded: 4, others: 1)")
    parser.add_argument("--offset", type=float, default=1000, help="between parallel faults [m]")
    parser.add_argument("--shift", type=float, default=0, help="of the second fault along strike [m]")
    parser.add_argument("--strike", type=float, default=None,
                        help="of dipping and listric faults, clockwise from north (0) [degrees]")
    parser.add_argument("--dip", type=float, default=None,
                        help="of dipping, listric (at the top) and segmented faults, to the right of the strike "
                        "(60) [degrees]")
    parser.add_argument("--dip-bottom", type=float, default=None, help="of a listric fault (20) [degrees]")
    parser.add_argument("--strikes", type=float, nargs="+", default=None, metavar="STRIKE",
                        help="of the segments (0 20) [degrees]")
    a = parser.parse_args()
    if min(a.cells) < 1 or min(a.size) <= 0 or a.top < 0:
        parser.error("--cells and --size must be positive, --top zero or positive")
    ratio = {"uniform": 1.0, "graded": a.ratio or 4.0}.get(a.kind, a.ratio or 1.0)
    if ratio < 1:
        parser.error("--ratio must be at least 1")
    uses = {"strike": ("dipping", "listric"), "dip": DIPPING, "dip_bottom": ("listric",), "strikes": ("segmented",)}
    for name, kinds in uses.items():
        if getattr(a, name) is not None and a.kind not in kinds:
            parser.error(f"--{name.replace('_', '-')} is of {', '.join(kinds)} meshes, not of a {a.kind} one")
    strike, dip = a.strike or 0.0, 60.0 if a.dip is None else a.dip
    bottom = 20.0 if a.dip_bottom is None else a.dip_bottom
    strikes = a.strikes or [0.0, 20.0]
    if not (0 < dip <= 90 and 0 < bottom <= 90):
        parser.error("--dip and --dip-bottom must be above 0 and at most 90")
    if max(map(abs, [strike, *strikes])) > 360:
        parser.error("--strike and --strikes must be from -360 to 360")
    if max(np.abs(np.diff(strikes)), default=0) >= 90:
        parser.error("--strikes must turn by less than 90 degrees from one to the next")
    if a.output.endswith(".msh"):
        if a.kind not in ("dipping", "listric") or ratio != 1:
            parser.error(f"{a.output} is for triangles of one size on a dipping or listric fault, expected OUT.h5 for "
                         f"a {a.kind} one of ratio {ratio:g}")
        corners = write_triangles(a.output, a.cells, a.size, a.top, strike,
                                  (dip, bottom if a.kind == "listric" else dip))
        print(f"{a.output}: {len(corners)} triangles")
        return
    label = None
    if a.kind == "segmented":
        rows, label = segmented(a.cells, a.size, a.top, ratio, strikes, dip)
    elif a.kind in DIPPING:
        rows = listric(a.cells, a.size, a.top, ratio, strike, (dip, bottom if a.kind == "listric" else dip))
        label = np.zeros(len(rows), int)
    else:
        rows = plane(a.cells, a.size, a.top, ratio)
    if a.kind == "parallel":
        if a.offset == 0:
            parser.error("--offset must not be 0")
        rows = np.concatenate([rows, plane(a.cells, a.size, a.top, ratio, x0=a.shift, y=a.offset)])
    write(a.output, rows, label)
    print(f"{a.output}: {len(rows)} cells")


if __name__ == "__main__":
    main()
