#!/usr/bin/env python3
"""Convert meshes of triangles from files of other programs to HDF5 for -fault_mesh.

    convert_mesh.py fault.stl OUT.h5 --frame enu --unit m
    convert_mesh.py fault.ts OUT.h5                          GOCAD TSurf, as those of community fault models
    convert_mesh.py faults.txt OUT.h5 --fields FIELDS.h5     rows of RSQSim

OUT.h5 has /vertices [V, 3], north, east and down in m, /triangles [N, 3], numbers of vertices from 0, and /fault [N], where the file has several surfaces or names; the
attribute names of /fault has the names. Vertices at the same place are merged.

STL, text or binary: each solid is a fault. The file has no frame and no unit: --frame and --unit set them (default enu, x east, y north, z up, and m).
GOCAD .ts: VRTX, PVRTX, ATOM, TRGL and ZPOSITIVE (Elevation or Depth) of each TSurf, which is a fault; x east and y north, in m.
RSQSim: each row has three corners, x y z each, rake, slip rate, and optionally number and name of the fault; x east, y north, z up, in m; # begins a comment. Rakes [deg] and slip
rates [m/s, or by --rate-unit mm/yr or m/yr] go to the fields rake and loading_rate of --fields, for -fault_parameters.
Rakes are measured from the strike of the triangle in that file, which is that of SlipStep except for overturned triangles.

Files of other kinds are read by meshio where that is installed. Gmsh's .msh needs no conversion: -fault_mesh reads it.
"""

import argparse
import contextlib
import io
import os
import re
import struct
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "output"))
from slipstep_modules import need

need("h5py", "numpy")
import h5py
import numpy as np

YEAR = 365.25 * 86400  # [s]
RATES = {"m/s": 1.0, "m/yr": 1 / YEAR, "mm/yr": 1e-3 / YEAR}
UNITS = {"m": 1.0, "km": 1000.0}


class MeshError(Exception):
    """What is wrong with a file: its name and what was expected."""


class Surfaces:
    """Corners [N, 3, 3] as the file has them, the number of each one's fault, and names of faults."""

    def __init__(self, corners, fault, names, fields=None):
        self.corners = np.asarray(corners, float).reshape(-1, 3, 3)
        self.fault, self.names, self.fields = np.asarray(fault, int), names, fields or {}


def number(path, line, word):
    try:
        return float(word)
    except ValueError:
        raise MeshError(f"{path}, line {line}: \"{word[:40]}\", expected a number") from None


# ---- STL ----

def read_stl(path):
    with open(path, "rb") as file:
        content = file.read()
    if len(content) >= 84 and len(content) == 84 + 50 * struct.unpack("<I", content[80:84])[0]:
        rows = np.frombuffer(content, np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("colour", "<u2")]), offset=84)
        return Surfaces(rows["corners"], np.zeros(len(rows), int), {})
    if b"\0" in content or not content.lstrip().lower().startswith(b"solid"):
        raise MeshError(f"{path}: {len(content)} bytes, which are neither text that begins with \"solid\" nor 84 and 50 for each of the triangles that they say: expected STL")
    corners, fault, names, solid, facet = [], [], {}, -1, []
    for line, text in enumerate(content.decode(errors="replace").splitlines(), 1):
        words = text.split()
        if not words:
            continue
        word = words[0].lower()
        if word == "solid":
            solid += 1
            names[solid] = " ".join(words[1:])
        elif word == "vertex":
            if len(words) != 4:
                raise MeshError(f"{path}, line {line}: {len(words) - 1} coordinates, expected 3")
            facet.append([number(path, line, w) for w in words[1:]])
        elif word == "endfacet":
            if len(facet) != 3:
                raise MeshError(f"{path}, line {line}: a facet of {len(facet)} vertices, expected 3")
            corners.append(facet)
            fault.append(solid)
            facet = []
        elif word not in ("facet", "outer", "endloop", "endsolid"):
            raise MeshError(f"{path}, line {line}: \"{words[0][:40]}\", expected a word of STL")
    if facet:
        raise MeshError(f"{path} ends within a facet")
    return Surfaces(corners, fault, names)


# ---- GOCAD ----

def read_gocad(path):
    corners, fault, names, surface, places, up, unit, system = [], [], {}, -1, {}, True, 1.0, False
    with open(path, errors="replace") as file:
        for line, text in enumerate(file, 1):
            words = text.split()
            if not words:
                continue
            word = words[0].upper()
            if word == "GOCAD":
                if len(words) < 2 or words[1].upper() != "TSURF":
                    raise MeshError(f"{path}, line {line}: a GOCAD {' '.join(words[1:2])}, expected a TSurf")
                surface, places, up, unit, system = surface + 1, {}, True, 1.0, False
                names[surface] = ""
            elif surface < 0:
                raise MeshError(f"{path}, line {line}: \"{words[0][:40]}\", expected GOCAD TSurf")
            elif word in ("GOCAD_ORIGINAL_COORDINATE_SYSTEM", "END_ORIGINAL_COORDINATE_SYSTEM"):
                system = not word.startswith("END")  # which has a NAME of its own
            elif not system and (word.startswith("NAME:") or (word == "NAME" and len(words) > 1)):
                names[surface] = text.split(":", 1)[-1].strip() if ":" in text else " ".join(words[1:])
            elif word == "ZPOSITIVE":
                if len(words) != 2 or words[1].lower() not in ("elevation", "depth"):
                    raise MeshError(f"{path}, line {line}: ZPOSITIVE {' '.join(words[1:])}, expected Elevation or Depth")
                up = words[1].lower() == "elevation"
            elif word == "AXIS_UNIT":
                found = {w.strip('"').lower() for w in words[1:]}
                if len(found) != 1 or not found <= set(UNITS):
                    raise MeshError(f"{path}, line {line}: {text.strip()}, expected m or km for all axes")
                unit = UNITS[found.pop()]
            elif word in ("VRTX", "PVRTX"):
                if len(words) < 5:
                    raise MeshError(f"{path}, line {line}: {len(words) - 2} coordinates, expected 3")
                place = np.array([number(path, line, w) for w in words[2:5]]) * unit
                places[words[1]] = place * (1, 1, 1 if up else -1)
            elif word in ("ATOM", "PATOM"):
                if len(words) < 3 or words[2] not in places:
                    raise MeshError(f"{path}, line {line}: {text.strip()[:60]}, expected the number of a vertex before it")
                places[words[1]] = places[words[2]]
            elif word == "TRGL":
                missing = [w for w in words[1:4] if w not in places]
                if len(words) != 4 or missing:
                    raise MeshError(f"{path}, line {line}: {text.strip()[:60]}, expected the numbers of three vertices"
                                    + (f", but there is no {missing[0][:20]}" if missing else ""))
                corners.append([places[w] for w in words[1:]])
                fault.append(surface)
    if surface < 0:
        raise MeshError(f"{path} is empty, expected GOCAD TSurf")
    return Surfaces(corners, fault, names)


# ---- RSQSim ----

def read_rsqsim(path, rate_unit):
    corners, fault, names, rake, rate = [], [], {}, [], []
    with open(path, errors="replace") as file:
        for line, text in enumerate(file, 1):
            words = text.split("#", 1)[0].split()
            if not words:
                continue
            if len(words) < 11:
                raise MeshError(f"{path}, line {line}: {len(words)} columns, expected x1 y1 z1 x2 y2 z2 x3 y3 z3 rake rate, and perhaps id name")
            values = [number(path, line, w) for w in words[:12]]
            own = int(values[11]) if len(words) > 11 else 0
            if len(words) > 11 and own != values[11]:
                raise MeshError(f"{path}, line {line}: the fault's number is {words[11]}, expected a whole one")
            corners.append(np.reshape(values[:9], (3, 3)))
            rake.append(values[9])
            rate.append(values[10] * RATES[rate_unit])
            fault.append(own)
            if len(words) > 12:
                names[own] = " ".join(words[12:])
    return Surfaces(corners, fault, names, {"rake": (rake, "degrees"), "loading_rate": (rate, "m/s")})


def read_meshio(path):
    try:
        import meshio
    except ImportError:
        raise MeshError(f"{path}: expected .stl, .ts, or .txt, .dat or .flt of RSQSim; others need meshio, which is not installed") from None
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            mesh = meshio.read(path)
    except (Exception, SystemExit) as error:  # its readers raise what they like, and it may print a line and end the program
        words = " ".join((said.getvalue() or str(error)).split())
        raise MeshError(f"{path}: meshio cannot read it: {words or type(error).__name__}") from None
    blocks = [block.data for block in mesh.cells if block.type == "triangle"]
    if not blocks:
        raise MeshError(f"{path}: {', '.join(sorted({block.type for block in mesh.cells})) or 'nothing'}, expected triangles")
    points = np.column_stack([mesh.points, np.zeros((len(mesh.points), 3 - mesh.points.shape[1]))])
    return Surfaces(np.concatenate([points[block] for block in blocks]), np.zeros(sum(map(len, blocks)), int), {})


def frame_of(corners, frame, unit):
    """North, east and down [m]"""
    corners = corners * UNITS[unit]
    return corners if frame == "ned" else corners[..., [1, 0, 2]] * (1, 1, -1)


def shared(corners):
    """Vertices [V, 3], each once, in the order in which they come, and triangles [N, 3]"""
    points, first, of = np.unique(corners.reshape(-1, 3), axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(order), int)
    rank[order] = np.arange(len(order))
    return points[order], rank[of.reshape(-1)].reshape(-1, 3)


def plain(name):
    """Without what parts names"""
    return re.sub(r"[;\s]+", " ", name).strip()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("input", metavar="IN", help="file to read")
    parser.add_argument("output", metavar="OUT.h5", help="mesh file to write")
    parser.add_argument("--format", choices=("stl", "gocad", "rsqsim", "meshio"), help="kind of the file (by its ending)")
    parser.add_argument("--frame", choices=("enu", "ned"), default="enu", help="axes: x east, y north, z up, or x north, y east, z down (enu)")
    parser.add_argument("--unit", choices=tuple(UNITS), default="m", help="of lengths in the file (m)")
    parser.add_argument("--fields", metavar="FIELDS.h5", help="rakes and slip rates of RSQSim, for -fault_parameters")
    parser.add_argument("--rate-unit", choices=tuple(RATES), default="m/s", help="of slip rates of RSQSim (m/s)")
    args = parser.parse_args()
    ending = os.path.splitext(args.input)[1].lower()
    kind = args.format or {".stl": "stl", ".ts": "gocad", ".txt": "rsqsim", ".dat": "rsqsim", ".flt": "rsqsim"}.get(ending, "meshio")
    try:
        if not os.path.isfile(args.input):
            raise MeshError(f"{args.input}: no such file")
        found = {"stl": read_stl, "gocad": read_gocad, "meshio": read_meshio, "rsqsim": lambda path: read_rsqsim(path, args.rate_unit)}[kind](args.input)
        if not len(found.corners):
            raise MeshError(f"{args.input} has no triangles")
        if not np.isfinite(found.corners).all():
            raise MeshError(f"{args.input}: triangle {int(np.flatnonzero(~np.isfinite(found.corners).all(axis=(1, 2)))[0])} has a coordinate that is not finite")
        if args.fields and not found.fields:
            raise MeshError(f"{args.input}: only rows of RSQSim have rakes and slip rates for --fields")
    except MeshError as error:
        sys.exit(f"convert_mesh.py: {error}")
    vertices, triangles = shared(frame_of(found.corners, args.frame, args.unit))
    names = "; ".join(f"{label} {plain(name)}" for label, name in sorted(found.names.items()) if name)
    with h5py.File(args.output, "w") as file:
        file["vertices"], file["triangles"] = vertices, triangles
        file["vertices"].attrs["units"] = "m"
        if names or len(np.unique(found.fault)) > 1:
            file["fault"] = found.fault
            if names:
                file["fault"].attrs["names"] = names
    if args.fields:
        with h5py.File(args.fields, "w") as file:
            for name, (values, unit) in found.fields.items():
                file[name] = np.asarray(values, float)
                file[name].attrs["units"] = unit
    print(f"{len(triangles)} triangles, {len(vertices)} vertices, {len(np.unique(found.fault))} faults, depths {vertices[:, 2].min():.6g} to {vertices[:, 2].max():.6g} m")


if __name__ == "__main__":
    main()
