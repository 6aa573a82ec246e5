#!/usr/bin/env python3
"""Convert meshes of triangles from files of other programs to HDF5 for -fault_mesh, and mend those that a run refuses.

    convert_mesh.py fault.stl OUT.h5 --frame enu --unit m
    convert_mesh.py fault.ts OUT.h5 --clip                   GOCAD TSurf, as those of community fault models, cut at the
                                                             ground
    convert_mesh.py north.ts south.ts OUT.h5 --repair        several files in one
    convert_mesh.py faults.txt OUT.h5 --fields FIELDS.h5     rows of RSQSim

OUT.h5 has /vertices [V, 3], north, east and down in m, /triangles [N, 3], numbers of vertices from 0, and /fault [N],
where there are several surfaces or names; the attribute names of /fault has the names. Vertices at the same place are
merged. Labels are those of the file; where several files have the same ones, those of later files are counted on, and a
file without names gives its own.

Units: /vertices says units = "m" only where --unit or the file (AXIS_UNIT of GOCAD, units of HDF5) says what its
lengths are. Else numbers are left as they are, and fault asks where they may be metres, kilometres or degrees. --frame:
enu, x east, y north, z up (default; of HDF5 ned); ned, x north, y east, z down; end, x east, y north, z down.

STL, text or binary: each solid is a fault. GOCAD .ts: VRTX, PVRTX, ATOM, TRGL and ZPOSITIVE (Elevation or Depth) of
each TSurf, which is a fault; x east, y north.
OBJ: groups (g), or objects (o), are faults. Gmsh .msh and HDF5, to mend them; fault itself reads them.
RSQSim: each row has three corners, x y z each, rake, slip rate, and optionally number and name of the fault, and more
columns of numbers, which are left out; # begins a comment. Rakes [deg] and slip rates [m/s, or by --rate-unit mm/yr or
m/yr] go to the fields rake and loading_rate of --fields, for -fault_parameters.
Rakes are measured from the strike of the triangle in that file, which is that of SlipStep except for overturned
triangles.
Files of other kinds, as .vtk, .vtu and .ply, are read by meshio where that is installed; data of cells named region,
fault, group or the like, or by --label, are faults.

What rises above the ground, z = 0, is refused by fault. One of
  --clip      cuts triangles at z = 0 and leaves out what is above; vertices within a tenth of an edge from the ground
              are moved onto it along that edge
  --shift     moves all down until the highest vertex is at z = 0
  --flatten   moves each vertex down by the elevation of the horizontally nearest end of the surface above the ground,
              so that depths are those below topography; what is still above is clipped
--repair takes away needles, triangles of a height below a fiftieth of their longest side: a short side becomes one
vertex, else the neighbour on the longest side is cut at the corner that lies on it. It turns the edge between triangles
that are folded on each other, and removes triangles that are there twice.
All that changes says by how much. Rows of --fields follow their triangles.
"""

import argparse
import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need, one_line

need("h5py", "numpy")
import h5py
import numpy as np
from slipstep.formats.surfaces import FORMATS, KINDS, RATES, UNITS, Surfaces, read
from slipstep.formats.text import FormatError
from slipstep.geometry.meshrepair import Mesh, clip, faults_of, flatten, repair, rising, shift
from slipstep.results.files import replacing, write_fields

FAR = 10  # times its extent from its origin: coordinates of a map projection


def in_frame(corners, frame):
    """North, east and down"""
    if frame == "ned":
        return corners
    return corners[..., [1, 0, 2]] * (1, 1, -1 if frame == "enu" else 1)


def shared(corners):
    """Vertices [V, 3], each once, in the order in which they come, and triangles [N, 3]"""
    points, first, of = np.unique(corners.reshape(-1, 3), axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(order), int)
    rank[order] = np.arange(len(order))
    return points[order], rank[of.reshape(-1)].reshape(-1, 3)


def joined(paths, found, unit, frame):
    """Surfaces of all files in one, in metres where the unit is said"""
    for path, own in zip(paths, found):
        if own.unit and unit not in (None, own.unit) and all(other.unit for other in found):
            raise FormatError(f"{path} says that its lengths are in {own.unit}, and --unit says {unit}")
        if not (own.unit or unit) and any(other.unit for other in found):
            raise FormatError(f"{path} does not say the unit of its lengths and another file does: expected "
                            "--unit m or km")
    corners, fault, names, free = [], [], {}, 0
    for path, own in zip(paths, found):
        places = own.corners * (1.0 if own.unit else UNITS[unit or "m"])
        if frame in ("ned", "end"):  # as ZPOSITIVE Depth says
            places[own.down, :, 2] *= -1
        corners.append(in_frame(places, frame or own.frame))
        labels = np.unique(own.fault)
        step = (free - labels[0] if len(paths) > 1 and set(labels.tolist())
                & {k for f in fault for k in np.unique(f).tolist()} else 0)
        fault.append(own.fault + step)
        free = max(free, int(labels[-1]) + step + 1)
        stem = os.path.splitext(os.path.basename(path))[0]
        for label in labels.tolist():
            name = own.names.get(label) or (stem if len(paths) > 1 else "")
            if name:
                names[label + step] = name
    fields = {}
    if all(own.fields for own in found):
        fields = {name: (np.concatenate([own.fields[name][0] for own in found]), unit)
                  for name, (_, unit) in found[0].fields.items()}
    return Surfaces(np.concatenate(corners), np.concatenate(fault), names, fields, found[0].unit or unit)


def plain(name):
    """Without what parts names"""
    return re.sub(r"[;\s]+", " ", name).strip()


def write(path, mesh, surfaces):
    left = set(mesh.label.tolist())
    names = "; ".join(f"{label} {plain(name)}" for label, name in sorted(surfaces.names.items()) if plain(name)
                      and label in left)
    with replacing(path) as part, h5py.File(part, "w") as file:
        file["vertices"], file["triangles"] = mesh.vertices, mesh.triangles
        if surfaces.unit:
            file["vertices"].attrs["units"] = "m"
        if names or len(np.unique(mesh.label)) > 1:
            file["fault"] = mesh.label
            if names:
                file["fault"].attrs["names"] = names


def hints(mesh, done, up, degree):
    """What a run will refuse, and what helps; up: z was taken to be upward; degree: coordinates up to this may be
    degrees, which no shift makes lengths"""
    above, most = rising(mesh)
    if above and above == len(mesh.triangles) and mesh.vertices[:, 2].max() <= 0:
        yield ("all triangles are above the ground, as where z is "
               f"{'downward: --frame ned or end' if up else 'upward: --frame enu'}")
    elif above:
        yield f"{above} triangles rise above the ground, by up to {most:.6g}: --clip, --shift or --flatten"
    needles, folds = faults_of(mesh)
    if needles or folds:
        yield f"{needles} needles" + (f" and {folds} folds" if folds else "") + (" remain" if done else ": --repair")
    middle, reach = 0.5 * (mesh.vertices.min(axis=0)
                           + mesh.vertices.max(axis=0))[:2], np.ptp(mesh.vertices[:, :2], axis=0)
    if np.hypot(*middle) > FAR * np.hypot(*reach) > 0 and np.abs(middle).max() > degree:
        digits = 10.0 ** np.floor(np.log10(np.hypot(*reach)))
        north, east = np.round(middle / digits) * digits
        yield (f"coordinates are far from their origin, as of a map projection: --origin {north:.0f} {east:.0f} "
               "(north, east) makes them local, as --origin of catalogue scripts expects")


def check_output(paths, target):
    if (os.path.splitext(target)[1].lower() in set(KINDS) - {".h5", ".hdf5"}
        or (os.path.exists(target) and not h5py.is_hdf5(target))):
        raise FormatError(f"{target} is the last name, which is of the HDF5 file to write: expected IN... OUT.h5")
    if any(os.path.exists(target) and os.path.exists(path) and os.path.samefile(path, target) for path in paths):
        raise FormatError(f"{target} is a file to read, expected another name to write")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("input", metavar="IN", nargs="+", help="files to read")
    parser.add_argument("output", metavar="OUT.h5", help="mesh file to write")
    parser.add_argument("--format", choices=FORMATS, help="kind of the files (by their endings)")
    parser.add_argument("--frame", choices=("enu", "ned", "end"), help="axes: x east, y north, z up; x north, y east, "
                        "z down; x east, y north, z down (enu, of HDF5 ned)")
    parser.add_argument("--unit", choices=tuple(UNITS), help="of lengths in files that do not say it (not said)")
    parser.add_argument("--origin", nargs=2, type=float, metavar=("NORTH", "EAST"),
                        help="point that becomes x = y = 0, in lengths as those of OUT.h5 (0 0)")
    ground = parser.add_mutually_exclusive_group()
    ground.add_argument("--clip", action="store_true", help="cut triangles at the ground")
    ground.add_argument("--shift", action="store_true", help="move all below the ground")
    ground.add_argument("--flatten", action="store_true", help="depths below topography")
    parser.add_argument("--repair", action="store_true", help="take needles and folds away")
    parser.add_argument("--label", metavar="NAME", help="data of cells, of files that meshio reads, that say which "
                                                        "fault each is of (region, fault and the like)")
    parser.add_argument("--fields", metavar="FIELDS.h5", help="rakes and slip rates of RSQSim, for -fault_parameters")
    parser.add_argument("--rate-unit", choices=tuple(RATES), default="m/s", help="of slip rates of RSQSim (m/s)")
    args = parser.parse_args()
    with one_line():
        check_output(args.input, args.output)
        found = [read(path, args.format, args.rate_unit, args.label) for path in args.input]
        surfaces = joined(args.input, found, args.unit, args.frame)
        if args.fields and not surfaces.fields:
            raise FormatError(f"{args.input[0]}: only rows of RSQSim have rakes and slip rates for --fields")
        mesh = Mesh(*shared(surfaces.corners), surfaces.fault)
        said = [f"{path}: {remark}" for path, own in zip(args.input, found) for remark in own.remarks]
        if args.origin:
            mesh.vertices[:, :2] -= args.origin
        if args.shift:
            said.append(shift(mesh))
        if args.flatten:
            said.append(flatten(mesh))
        if args.clip or (args.flatten and rising(mesh)[0]):
            said.append(clip(mesh))
        if not len(mesh.triangles):
            up = (args.frame or found[0].frame) == "enu"
            hint = "if z is downward, --frame ned or end" if up else "if z is upward, --frame enu"
            raise FormatError(f"{args.input[0]}: nothing is below the ground; {hint} says so")
        if args.repair:
            said.append(repair(mesh))
        write(args.output, mesh, surfaces)
        if args.fields:
            write_fields(args.fields, {name: (np.asarray(values, float)[mesh.parent], unit)
                                       for name, (values, unit) in surfaces.fields.items()})
    unit = "m" if surfaces.unit else "in a unit that nothing says: --unit m or km does"
    print("".join(f"{line}\n" for line in said)
          + f"{len(mesh.triangles)} triangles, {len(mesh.vertices)} vertices, {len(np.unique(mesh.label))} faults, "
            f"depths {0 + mesh.vertices[:, 2].min():.6g} to {0 + mesh.vertices[:, 2].max():.6g} {unit}")
    for line in hints(mesh, args.repair, (args.frame or found[0].frame) == "enu", 360 * UNITS[surfaces.unit or "m"]):
        print(line)


if __name__ == "__main__":
    main()
