"""Triangles in files of other programs: STL, GOCAD TSurf, rows of RSQSim, OBJ, Gmsh, HDF5 of -fault_mesh, and what
meshio reads."""

import contextlib
import io
import os
import re
import struct

import h5py
import numpy as np

from ..results.files import names_of, plain
from ..times import YEAR
from .text import LARGE, NUMBER, FormatError, Text

RATES = {"m/s": 1.0, "m/yr": 1 / YEAR, "mm/yr": 1e-3 / YEAR}
UNITS = {"m": 1.0, "km": 1000.0}


class Surfaces:
    """Corners [N, 3, 3] as the file has them, the number of each one's fault, names of faults, and what the file says
    besides: a unit of lengths, in which case they are metres here, axes, and remarks for the user. down [N]: the file
    says that z is downward, and here it is upward."""

    def __init__(self, corners, fault, names, fields=None, unit=None, frame="enu", remarks=(), down=None):
        self.corners = np.asarray(corners, float).reshape(-1, 3, 3)
        self.fault, self.names, self.fields = np.asarray(fault, int), names, fields or {}
        self.unit, self.frame, self.remarks = unit, frame, list(remarks)
        self.down = np.zeros(len(self.corners), bool) if down is None else np.asarray(down, bool)


def fans(faces):
    """Triangles of polygons, lists of their corners, and the number of the polygon that each is of."""
    triangles = [(face[0], face[k], face[k + 1]) for face in faces for k in range(1, len(face) - 1)]
    return triangles, np.repeat(np.arange(len(faces)), [len(face) - 2 for face in faces])


# ---- STL ----

def read_stl(path):
    with open(path, "rb") as file:
        content = file.read()
    if len(content) >= 84 and len(content) == 84 + 50 * struct.unpack("<I", content[80:84])[0]:
        rows = np.frombuffer(content, np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("colour", "<u2")]),
                             offset=84)
        return Surfaces(rows["corners"], np.zeros(len(rows), int), {})
    if b"\0" in content or not content.lstrip().lower().startswith(b"solid"):
        raise FormatError(f"{path}: {len(content)} bytes, which are neither text that begins with \"solid\" nor 84 and "
                        "50 for each of the triangles that they say: expected STL")
    corners, fault, names, solid, facet, text = [], [], {}, -1, [], Text(path)
    for line, words in text:
        words = words.split()
        if not words:
            continue
        word = words[0].lower()
        if word == "solid":
            solid += 1
            names[solid] = " ".join(words[1:])
        elif word == "vertex":
            if len(words) != 4:
                text.fail(line, f"{len(words) - 1} coordinates", "3")
            facet.append([text.number(line, w) for w in words[1:]])
        elif word == "endfacet":
            if len(facet) != 3:
                text.fail(line, f"a facet of {len(facet)} vertices", "3")
            corners.append(facet)
            fault.append(solid)
            facet = []
        elif word not in ("facet", "outer", "endloop", "endsolid"):
            text.fail(line, f"\"{words[0][:40]}\"", "a word of STL")
    if facet:
        raise FormatError(f"{path} ends within a facet")
    return Surfaces(corners, fault, names)


# ---- GOCAD ----

def read_gocad(path):
    corners, fault, down, names, surface, said = [], [], [], {}, -1, set()
    text, more = Text(path), 0  # vertices and triangles with properties
    for line, whole in text:
        words = whole.split()
        if not words:
            continue
        word = words[0].upper()
        if word == "GOCAD":
            if len(words) < 2 or words[1].upper() != "TSURF":
                text.fail(line, f"a GOCAD {' '.join(words[1:2])}", "a TSurf")
            surface, places, up, unit, system = surface + 1, {}, True, np.ones(3), False
            own = None  # the unit of all axes
            names[surface] = ""
        elif surface < 0:
            text.fail(line, f"\"{words[0][:40]}\"", "GOCAD TSurf")
        elif word in ("GOCAD_ORIGINAL_COORDINATE_SYSTEM", "END_ORIGINAL_COORDINATE_SYSTEM"):
            system = not word.startswith("END")  # which has a NAME of its own
        elif word == "HDR" and len(words) > 1 and words[1].lower().startswith("name:"):
            names[surface] = whole.split(":", 1)[1].strip()
        elif not system and (word.startswith("NAME:") or (word == "NAME" and len(words) > 1)):
            names[surface] = whole.split(":", 1)[-1].strip() if ":" in whole else " ".join(words[1:])
        elif word == "ZPOSITIVE":
            if len(words) != 2 or words[1].lower() not in ("elevation", "depth"):
                text.fail(line, f"ZPOSITIVE {' '.join(words[1:])}", "Elevation or Depth")
            up = words[1].lower() == "elevation"
        elif word == "AXIS_UNIT":
            found = [w.lower() for w in whole.replace('"', " ").split()[1:]]
            if len(found) != 3 or not set(found) <= set(UNITS):
                text.fail(line, whole.strip(), "m or km for each of three axes")
            unit, own = np.array([UNITS[w] for w in found]), found[0] if len(set(found)) == 1 else "m"
        elif word in ("VRTX", "PVRTX"):
            if len(words) < 5:
                text.fail(line, f"{len(words) - 2} coordinates", "3")
            place = np.array([text.number(line, w) for w in words[2:5]]) * unit
            more += len(words) > 5
            said.add(own)
            places[words[1]] = place * (1, 1, 1 if up else -1)
        elif word in ("ATOM", "PATOM"):
            if len(words) < 3 or words[2] not in places:
                text.fail(line, whole.strip()[:60], "the number of a vertex before it")
            places[words[1]] = places[words[2]]
        elif word == "TRGL":
            missing = [w for w in words[1:4] if w not in places]
            if len(words) < 4 or missing:
                text.fail(line, whole.strip()[:60], "the numbers of three vertices"
                          + (f", but there is no {missing[0][:20]}" if missing else ""))
            corners.append([places[w] for w in words[1:4]])
            more += len(words) > 4
            fault.append(surface)
            down.append(not up)
    if surface < 0:
        raise FormatError(f"{path} is empty, expected GOCAD TSurf")
    if None in said and len(said) > 1:
        raise FormatError(f"{path}: some surfaces have AXIS_UNIT and some have not, expected all or none")
    return Surfaces(corners, fault, names, unit=said.pop() if len(said) == 1 else "m", down=down,
                    remarks=[f"words after the numbers of {more} vertices and triangles, as properties, are left out"]
                    if more else ())


# ---- RSQSim ----

def names_and_columns(rows):
    """Names of faults from the words after their numbers, {number: [words, ...]}, and how many columns of numbers
    follow the names. As many as every row ends with are columns, unless names are told apart by them alone."""
    ending = [next((k for k, word in enumerate(reversed(words)) if not re.fullmatch(NUMBER, word)),
                   max(len(words) - 1, 0))
              for all_words in rows.values() for words in all_words]
    columns = min(ending, default=0)
    short = {label: " ".join(words[0][:len(words[0]) - columns]) for label, words in rows.items()}
    if (len(set(short.values())) < len({" ".join(words[0]) for words in rows.values()})
        and all(len(set(map(tuple, words))) == 1 for words in rows.values())):
        columns, short = 0, {label: " ".join(words[0]) for label, words in rows.items()}
    return short, columns


def read_rsqsim(path, rate_unit):
    corners, fault, words_of, rake, rate, text = [], [], {}, [], [], Text(path)
    for line, words in text:
        words = words.split("#", 1)[0].split()
        if not words:
            continue
        if len(words) < 11:
            text.fail(line, f"{len(words)} columns", "x1 y1 z1 x2 y2 z2 x3 y3 z3 rake rate, and perhaps id name, of "
                      "RSQSim")
        values = [text.number(line, w) for w in words[:12]]
        own = int(values[11]) if len(words) > 11 else 0
        if len(words) > 11 and own != values[11]:
            text.fail(line, f"the fault's number is {words[11]}", "a whole one")
        corners.append(np.reshape(values[:9], (3, 3)))
        rake.append(values[9])
        rate.append(values[10] * RATES[rate_unit])
        fault.append(own)
        if len(words) > 12:
            words_of.setdefault(own, []).append(words[12:])
    names, columns = names_and_columns(words_of)
    return Surfaces(corners, fault, names, {"rake": (rake, "degrees"), "loading_rate": (rate, "m/s")},
                    remarks=[f"{columns} column{'s' * (columns > 1)} after the names left out"] if columns else ())


# ---- OBJ ----

def read_obj(path):
    """Vertices and faces, without normals and places in pictures. Groups are faults, or else objects."""
    points, faces, groups, objects, group, thing, text = [], [], [], [], "", "", Text(path)
    for line, whole in text:
        words = whole.split("#", 1)[0].split()
        if not words:
            continue
        if words[0] == "v":
            if len(words) < 4:
                text.fail(line, f"{len(words) - 1} coordinates", "3")
            points.append([text.number(line, w) for w in words[1:4]])
        elif words[0] == "g":
            group = " ".join(words[1:])
        elif words[0] == "o":
            thing = " ".join(words[1:])
        elif words[0] == "f":
            try:
                numbers = [int(w.split("/")[0]) for w in words[1:]]
            except ValueError:
                numbers = []
            corners = [n - 1 if n > 0 else len(points) + n for n in numbers]
            if len(corners) < 3 or 0 in numbers or not all(0 <= c < len(points) for c in corners):
                text.fail(line, whole.strip()[:60], "the numbers of three or more vertices before it")
            faces.append(corners)
            groups.append(group)
            objects.append(thing)
    triangles, of = fans(faces)
    said = groups if len(set(groups)) > 1 or not any(objects) else objects
    names = list(dict.fromkeys(said))
    fault = np.array([names.index(name) for name in said], int)[of] if faces else []
    corners = np.array(points)[np.array(triangles, int)] if triangles else []
    many = len(triangles) - len(faces)
    return Surfaces(corners, fault, dict(enumerate(names)),
                    remarks=[f"faces of more than three corners cut into {many} triangles more"] if many else ())


# ---- HDF5 of -fault_mesh ----

def read_hdf5(path):
    with h5py.File(path) as file:
        if "vertices" not in file or "triangles" not in file:
            raise FormatError(f"{path}: expected /vertices and /triangles; rectangles need no conversion")
        vertices, triangles = file["vertices"][()], file["triangles"][()]
        for name, values in (("vertices", vertices), ("triangles", triangles)):
            if values.ndim != 2 or values.shape[1] != 3 or not np.issubdtype(values.dtype, np.number):
                raise FormatError(f"{path}: /{name} has shape {list(values.shape)}, expected numbers of shape [any, 3]")
        if not np.all(triangles == np.floor(triangles)):
            raise FormatError(f"{path}: /triangles has numbers that are not whole, expected rows of /vertices")
        triangles = triangles.astype(int)
        fault = file["fault"][()].astype(int) if "fault" in file else np.zeros(len(triangles), int)
        if fault.shape != (len(triangles),):
            raise FormatError(f"{path}: /fault has shape {list(fault.shape)}, expected [{len(triangles)}], a label for "
                            "each triangle")
        names, unit = names_of(file.get("fault")), plain(file["vertices"].attrs.get("units"))
    if triangles.size and (triangles.min() < 0 or triangles.max() >= len(vertices)):
        raise FormatError(f"{path}: /triangles has the vertex "
                        f"{triangles.min() if triangles.min() < 0 else triangles.max()}, expected 0 to "
                        f"{len(vertices) - 1}")
    if unit not in (None, "m"):
        raise FormatError(f"{path}: /vertices has the units {unit}, expected m")
    return Surfaces(vertices[triangles], fault, names, unit=unit, frame="ned")


# ---- Gmsh ----

class _Words:
    """Numbers of a section as text: take(count, code) by codes of struct, d of floating point, others whole."""

    def __init__(self, content):
        self.words = iter(content.decode(errors="replace").split())

    def take(self, count, code="i"):
        kind = float if code == "d" else int
        return [kind(next(self.words)) for _ in range(count)]

    def count(self):
        return self.take(1)[0]


class _Bytes:
    """Those of a section in bytes; sections of 2.2 begin with a line of text."""

    def __init__(self, content, order):
        self.content, self.order, self.at = content, order, 0

    def take(self, count, code="i"):
        values = struct.unpack_from(f"{self.order}{count}{code}", self.content, self.at)
        self.at += struct.calcsize(f"{self.order}{count}{code}")
        return list(values)

    def count(self):
        end = self.content.index(b"\n", self.at)
        value, self.at = int(self.content[self.at:end]), end + 1
        return value


def read_gmsh(path):
    """2.2 and 4.1: triangles of physical surfaces, or all where there are none; fault itself says more of errors."""
    with open(path, "rb") as file:
        sections = dict(re.findall(rb"\$(\w+)[ \t]*\r?\n(.*?)\$End\1", file.read(), re.DOTALL))
    try:
        version, binary = sections[b"MeshFormat"].split()[:2]
        if version not in (b"2.2", b"4.1"):
            raise FormatError(f"{path} is of version {version.decode(errors='replace')} of the format, expected "
                            "2.2 or 4.1")
        order = "<" if b"\n\1\0\0\0" in sections[b"MeshFormat"] else ">"
        numbers = {name: _Bytes(content, order) if binary == b"1" else _Words(content)
                   for name, content in sections.items() if name in (b"Nodes", b"Elements", b"Entities")}
        points, elements = (_gmsh_old if version == b"2.2" else _gmsh)(numbers)
    except FormatError:
        raise
    except (KeyError, ValueError, StopIteration, RuntimeError, struct.error, MemoryError):
        raise FormatError(f"{path}: expected $MeshFormat, $Nodes and $Elements of Gmsh 2.2 or 4.1") from None
    said = sections.get(b"PhysicalNames", b"").decode(errors="replace")
    names = {int(tag): name for dim, tag, name in re.findall(r'(\d+)\s+(\d+)\s+"(.*)"', said) if dim == "2"}
    own = {}
    for nodes, groups in elements:
        own.setdefault(tuple(sorted(nodes)), set()).update(groups)
    several = next((sorted(groups) for groups in own.values() if len(groups) > 1), None)
    if several:
        words = [f'{group} "{names[group]}"' if group in names else str(group) for group in several]
        raise FormatError(f"{path}: a triangle is of several physical groups, {' and '.join(words)}, expected one: a "
                        "triangle is of one fault")
    if any(groups for _, groups in elements):
        elements = [element for element in elements if element[1]]
    faces, labels = [nodes for nodes, _ in elements], [next(iter(groups), 0) for _, groups in elements]
    triangles, of = fans(faces)
    try:
        corners = [[points[node] for node in nodes] for nodes in triangles]
    except KeyError as error:
        raise FormatError(f"{path}: an element has the node {error}, which $Nodes does not have") from None
    return Surfaces(corners, np.array(labels, int)[of] if faces else [], names)


NODES = {1: 2, 2: 3, 3: 4, 4: 4, 5: 8, 6: 6, 7: 5, 15: 1}  # of elements of Gmsh of the first order


def _gmsh_old(numbers):
    """Places of nodes, and (nodes, physical groups) of elements, whose sign says which way a surface faces"""
    nodes, of, points, elements = numbers[b"Nodes"], numbers[b"Elements"], {}, []
    for _ in range(nodes.count()):
        tag = nodes.take(1)[0]
        points[tag] = nodes.take(3, "d")
    left = of.count()
    while left > 0:
        if isinstance(of, _Bytes):
            kind, count, tags = of.take(3)
            rows = [of.take(1 + tags + NODES[kind])[1:] for _ in range(count)]
        else:
            _, kind, tags = of.take(3)
            rows = [of.take(tags + NODES[kind])]
        left -= max(len(rows), 1)
        if kind in (2, 3):
            elements += [(row[tags:], {abs(row[0])} - {0} if tags else set()) for row in rows]
    return points, elements


def _gmsh(numbers):
    points, elements, groups, of = {}, [], {}, numbers.get(b"Entities")
    for dim, count in enumerate(of.take(4, "Q") if of else ()):
        for _ in range(count):
            tag = of.take(1)[0]
            of.take(6 if dim else 3, "d")
            physical = of.take(of.take(1, "Q")[0])
            if dim:
                of.take(of.take(1, "Q")[0])
            if dim == 2:
                groups[tag] = {abs(group) for group in physical} - {0}
    of = numbers[b"Nodes"]
    for _ in range(of.take(4, "Q")[0]):
        dim, _, parametric = of.take(3)
        tags = of.take(of.take(1, "Q")[0], "Q")
        for tag in tags:
            points[tag] = of.take(3, "d")
            of.take(dim if parametric else 0, "d")
    of = numbers[b"Elements"]
    for _ in range(of.take(4, "Q")[0]):
        _, tag, kind = of.take(3)
        for _ in range(of.take(1, "Q")[0]):
            corners = of.take(1 + NODES[kind], "Q")[1:]
            if kind in (2, 3):
                elements.append((corners, groups.get(tag, set())))
    return points, elements


# ---- meshio ----

# Names of data of cells that say which fault a cell is of, in small letters, without "id" at their end and signs
REGIONS = ("fault", "region", "segment", "patch", "surface", "section", "group", "gmshphysical", "objgroup", "celltag",
           "meditref", "part", "body", "block", "zone", "label", "material", "tag")


def region_of(data):
    """The name of the array, of {name: values}, that says which fault each cell is of, or None"""
    plain = {re.sub(r"ids?$", "", re.sub("[^a-z]", "", name.lower())).rstrip("s"): name for name in data}
    found = [plain[name] for name in REGIONS if name in plain]
    return next((name for name in found if np.ndim(data[name]) == 1 and np.all(data[name] == np.round(data[name]))),
                None)


def read_meshio(path, label):
    """label: the name of the data of cells that says which fault a cell is of, or None."""
    try:
        import meshio
    except ImportError:
        raise FormatError(f"{path}: expected .stl, .ts, .obj, .msh, .h5, or .txt, .dat or .flt of RSQSim, or --format "
                        "stl, gocad, obj, gmsh, hdf5 or rsqsim; others need meshio, which is not installed") from None
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            mesh = meshio.read(path)
    except (Exception, SystemExit) as error:
        # its readers raise what they like, and it may print a line and end the program
        words = " ".join((said.getvalue() or str(error)).split())
        raise FormatError(f"{path}: meshio cannot read it: {words or type(error).__name__} (rows of RSQSim: "
                        "--format rsqsim)") from None
    taken = [k for k, block in enumerate(mesh.cells) if block.type in ("triangle", "quad", "polygon")]
    if not taken:
        raise FormatError(f"{path}: {', '.join(sorted({block.type for block in mesh.cells})) or 'nothing'}, "
                        "expected triangles")
    data = {name: np.concatenate([np.broadcast_to(values[k], (len(mesh.cells[k].data), *np.shape(values[k])[1:]))
                                  for k in taken]) for name, values in mesh.cell_data.items()}
    if label and label not in data:
        raise FormatError(f"{path} has no data of cells of the name {label} (--label): it has "
                        f"{', '.join(data) or 'none'}")
    points = np.column_stack([mesh.points, np.zeros((len(mesh.points), 3 - mesh.points.shape[1]))])
    triangles, of = fans([list(face) for k in taken for face in mesh.cells[k].data])
    region, remarks = label or region_of(data), []
    fault = np.zeros(len(triangles), int)
    if region:
        if np.ndim(data[region]) != 1 or not np.all(data[region] == np.round(data[region])):
            raise FormatError(f"{path}: {region} has other values than a whole number for each cell (--label)")
        fault = np.asarray(data[region]).astype(int)[of]
        remarks.append(f"faults by its data {region}")
    elif data:
        remarks.append(f"its data {', '.join(data)} not used: --label NAME makes faults of one")
    known = {int(value[0]): name for name, value in mesh.field_data.items() if len(value) > 1 and int(value[1]) == 2}
    return Surfaces(points[np.array(triangles, int)], fault,
                    {key: known[key] for key in np.unique(fault) if key in known} if region else {}, remarks=remarks)


KINDS = {".stl": "stl", ".ts": "gocad", ".obj": "obj", ".msh": "gmsh", ".h5": "hdf5", ".hdf5": "hdf5", ".txt": "rsqsim",
         ".dat": "rsqsim", ".flt": "rsqsim"}
FORMATS = ("stl", "gocad", "obj", "gmsh", "hdf5", "rsqsim", "meshio")


def read(path, kind=None, rate_unit="m/s", label=None):
    """Surfaces of a file whose kind is that of its ending by default."""
    if not os.path.isfile(path):
        raise FormatError(f"{path}: no such file")
    kind = kind or KINDS.get(os.path.splitext(path)[1].lower(), "meshio")
    if kind == "hdf5" and not h5py.is_hdf5(path):
        raise FormatError(f"{path} is not an HDF5 file")
    found = {"stl": read_stl, "gocad": read_gocad, "obj": read_obj, "gmsh": read_gmsh, "hdf5": read_hdf5,
             "meshio": lambda p: read_meshio(p, label), "rsqsim": lambda p: read_rsqsim(p, rate_unit)}[kind](path)
    if not len(found.corners):
        raise FormatError(f"{path} has no triangles")
    size = np.abs(found.corners).max(axis=(1, 2))
    if not (size <= LARGE).all():
        k = int(np.argmin(size <= LARGE))
        raise FormatError(f"{path}: triangle {k} has a coordinate of {size[k]:g}, expected {LARGE:g} at most")
    return found
