#!/usr/bin/env python3
"""Make the faults of examples/bends.sh and a weak patch on each: a bent strike-slip fault in the format of community
fault models, and a fault with a branch by Gmsh.

    bends.py bend NAME --cell 650       NAME.ts, a GOCAD TSurf of a fault that bends, and NAME_fields.h5
    bends.py branch NAME --cell 650     NAME.msh, physical surfaces "main" and "branch" that share an edge, and
                                        NAME_fields.h5
"""

import argparse
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need, one_line

need("h5py", "numpy")
import numpy as np
from slipstep.results.files import write_fields

LENGTH, DEPTH = 24e3, 10e3  # along strike, and in depth [m]
# the strike turns by so much to the right, between these distances along it [degrees, m]
BEND, WITHIN = 10.0, (10e3, 14e3)
FORK, TURN, REACH = 12e3, -15.0, 10e3  # where the branch begins, its strike, to the left, and its length
ORIGIN = 400e3, 3770e3  # of the bent fault, east and north: coordinates are those of a map
JITTER = 0.2  # of cells: how far vertices within the fault are moved, so that triangles are of any shape
RESIDUAL, WEAK = 0.525, 0.475  # friction; in the patch with its drop of 0.152 below 76 MPa over 120 MPa of the stress
PATCH = 5e3, 5e3, 4e3  # distance along strike, depth and radius [m]


def bend(name, cell):
    """Vertices along the trace, jittered, in rows of depth, as VRTX and TRGL. Corners [N, 3, 3] of the triangles,
    north, east and down."""
    nx, nz = round(LENGTH / cell), round(DEPTH / cell)
    rng = np.random.default_rng(1)
    i, j = (part.ravel() for part in np.meshgrid(np.arange(nx + 1), np.arange(nz + 1)))
    inside = (i % nx > 0) & (j % nz > 0)
    along, depth = ((k + inside * rng.uniform(-JITTER, JITTER, len(k))) * size
                    for k, size in ((i, LENGTH / nx), (j, DEPTH / nz)))
    line = np.linspace(0, LENGTH, 2001)
    strike = np.radians(np.interp(line, WITHIN, (0, BEND)))
    north, east = (np.interp(along, line, np.concatenate([[0], np.cumsum((part[1:] + part[:-1]) / 2 * np.diff(line))]))
                   for part in (np.cos(strike), np.sin(strike)))
    triangles = []
    for row in range(nz):
        for column in range(nx):
            p = row * (nx + 1) + column
            q, r, s = p + 1, p + nx + 1, p + nx + 2
            triangles += [(p, q, s), (p, s, r)] if (row + column) % 2 else [(p, q, r), (q, s, r)]
    with open(f"{name}.ts", "w") as file:
        file.write("GOCAD TSurf 1\nHEADER {\nname:bend\n}\nGOCAD_ORIGINAL_COORDINATE_SYSTEM\nNAME \"UTM\"\nAXIS_NAME "
                   "\"X\" \"Y\" \"Z\"\n"
                   "AXIS_UNIT \"m\" \"m\" \"m\"\nZPOSITIVE Elevation\nEND_ORIGINAL_COORDINATE_SYSTEM\nTFACE\n")
        for k, place in enumerate(zip(ORIGIN[0] + east, ORIGIN[1] + north, -depth), 1):
            file.write("VRTX {} {:.3f} {:.3f} {:.3f}\n".format(k, *place))
        for corners in triangles:
            file.write("TRGL {} {} {}\n".format(*(k + 1 for k in corners)))
        file.write("END\n")
    return np.column_stack([north, east, depth])[np.array(triangles)]


def branch(name, cell):
    """Two planes of the main fault and one of the branch, which share the line of the fork; in Gmsh x is east, y north,
    z up. Corners as of bend()."""
    need("gmsh")
    import gmsh
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    geo, turn = gmsh.model.geo, np.radians(TURN)
    ends = (0, 0), (0, FORK), (0, LENGTH), (np.sin(turn) * REACH, FORK + np.cos(turn) * REACH)
    upper, lower = ([geo.addPoint(*end, -depth, cell) for end in ends] for depth in (0, DEPTH))
    down = [geo.addLine(a, b) for a, b in zip(upper, lower)]
    planes = []
    for a, b in ((0, 1), (1, 2), (1, 3)):
        top, bottom = geo.addLine(upper[a], upper[b]), geo.addLine(lower[a], lower[b])
        planes.append(geo.addPlaneSurface([geo.addCurveLoop([top, down[b], -bottom, -down[a]])]))
    geo.synchronize()
    for number, (label, own) in enumerate((("main", planes[:2]), ("branch", planes[2:])), 1):
        gmsh.model.addPhysicalGroup(2, own, number)
        gmsh.model.setPhysicalName(2, number, label)
    gmsh.model.mesh.generate(2)
    tags, places, _ = gmsh.model.mesh.getNodes()
    of = dict(zip(tags, places.reshape(-1, 3)[:, (1, 0, 2)] * (1, 1, -1)))
    corners = np.array([of[tag] for tag in gmsh.model.mesh.getElementsByType(2)[1]]).reshape(-1, 3, 3)
    gmsh.write(f"{name}.msh")
    gmsh.finalize()
    return corners


def write_friction(path, corners):
    """Residual friction, which in the patch leaves less strength than the shear stress there."""
    north, _, depth = corners.mean(axis=1).T
    patch = np.hypot(north - PATCH[0], depth - PATCH[1]) < PATCH[2]
    write_fields(path, {"friction_residual": (np.where(patch, WEAK, RESIDUAL), "1")})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", choices=["bend", "branch"])
    parser.add_argument("name", metavar="NAME")
    parser.add_argument("--cell", type=float, default=650.0, metavar="M", help="approximate sides of the triangles [m]")
    a = parser.parse_args()
    if not 0 < a.cell <= DEPTH / 4:
        parser.error(f"--cell is {a.cell:g}, expected a number > 0 up to {DEPTH / 4:g}")
    with one_line():
        write_friction(f"{a.name}_fields.h5", {"bend": bend, "branch": branch}[a.work](a.name, a.cell))


if __name__ == "__main__":
    main()
