"""Faults of other programs for cycles with rate-and-state friction: HBI (.in with its parameters and STL), interact
(geom.in), Quake-DFN (Input_BulkFaultGeometry.txt) and PyQuake3D (parameter.txt with a mesh and its parameters). x is
taken to be east, y north, z up, as these draw them."""

import glob
import os
import re

import numpy as np

from .meshes import triangles_of
from .model import Model, Segment
from .surfaces import read as read_surfaces
from .text import FormatError, Text, beyond, unused

MPA, KM = 1e6, 1e3
MOST = 10 ** 7  # cells
# Parameters of these programs -> field of -fault_parameters, unit and factor
FIELDS = {"a": ("friction_a", "1", 1.0), "b": ("friction_b", "1", 1.0), "dc": ("friction_slip", "m", 1.0),
          "f0": ("friction_reference", "1", 1.0), "tau": ("initial_traction", "Pa", MPA),
          "sigma": ("normal_stress", "Pa", MPA), "vel": ("initial_rate", "m/s", 1.0)}
LOADS = ("shear_loading", "normal_loading")  # of PyQuake3D, mostly 0


def put_fields(model, columns):
    """Columns {name: [N]} of a program as fields; those that fault does not have are dropped."""
    for name, values in columns.items():
        values = np.broadcast_to(values, len(model.cells)).astype(float)
        if name == "rake":
            model.rake = values
        elif name in FIELDS:
            field, unit, factor = FIELDS[name]
            model.fields[field] = (values * factor, unit)
        elif name not in LOADS or np.any(values):
            model.dropped.append(f"column {name}")
    model.options["friction_law"] = "rate_and_state"


def table(path, count, names=None):
    """Columns {name: [count]} of a file, by its first line or given names, and a line of what else it has."""
    text = Text(path)
    first = 1 if names else 2
    names = names or text.lines[0].split() if len(text) else []
    if names and re.fullmatch(r"[-+.\deEdD]+", names[0]):
        text.fail(1, text.quoted(1), "names of columns, as a dc tau vel")
    rows = [(line, words.split()) for line, words in text if line >= first and words.strip()]
    if len(rows) != count:
        text.fail(rows[count][0] if len(rows) > count else len(text) + 1, f"{len(rows)} rows",
                  f"{count}, one for each cell")
    for line, words in rows[:count]:
        if len(words) < len(names):
            text.fail(line, f"{len(words)} numbers", f"{len(names)}: {' '.join(names)}")
    return {name: np.array([text.number(line, words[k]) for line, words in rows])
            for k, name in enumerate(names)}, beyond([words for _, words in rows], len(names))


# ---- HBI ----

# rigidity [GPa], S wave [km/s] and Poisson's ratio where an input does not set them (m_const.f90); the reference rate
# [m/s] is then left to fault, whose default this is
HBI_DEFAULTS = {"rigid": 32.04, "vs": 3.464, "pois": 0.25, "vref": 1e-6}
HBI_STATE = {"aging": "aging", "slip": "slip"}  # evlaw -> -fault_state_law
HBI_USED = {"problem", "imax", "jmax", "ds", "ztop", "dipangle", "geometry_file", "a", "b", "dc", "f0", "tauinit",
            "sigmainit", "velinit", "muinit", "crake", "parameterfromfile",
            "parameter_file", "vpl", "evlaw", *HBI_DEFAULTS}

def read_hbi(path, at, rake=None):
    """Problems 3dp, 3dph, 3dht and 3dnt: lengths in km, stress in MPa; cells by columns along strike."""
    text, said = Text(path), {}
    for line, words in text:
        words = words.split("!")[0].split()
        if words:
            said[words[0]] = (line, words[1].strip("'\"") if len(words) > 1 else "")
    if "problem" not in said:
        text.fail(len(text) + 1, "no problem", "one of 3dp, 3dph, 3dht, 3dnt")

    def value(name, default=None):
        if name not in said and default is None:
            text.fail(len(text) + 1, f"no {name}", "a number")
        return text.number(*said[name]) if name in said else default

    problem = said["problem"][1]
    if problem in ("3dp", "3dph"):
        counts = [text.whole(*said[name]) if name in said else value(name) for name in ("imax", "jmax")]
        if min(counts) < 1 or counts[0] * counts[1] > MOST or value("ds") <= 0 or not 0 < value("dipangle", 90.0) <= 90:
            text.fail(said["problem"][0], f"imax {counts[0]}, jmax {counts[1]}, ds {value('ds'):g} and dipangle "
                      f"{value('dipangle', 90.0):g}", f"cells up to {MOST}, ds > 0 and 0 < dipangle <= 90")
        model = hbi_grid(path, problem, *counts, KM * value("ds"), value("dipangle", 90.0), KM * value("ztop", 0.0))
    elif problem in ("3dht", "3dnt") and "geometry_file" in said:
        found = read_surfaces(beside(path, said["geometry_file"][1]))
        cells, corners = triangles_of(path, found, KM)
        model = Model(path, "HBI", cells, np.zeros(len(cells)), None, corners, found.fault, found.names, unit="km")
    else:
        text.fail(said["problem"][0], f"the problem {problem}", "3dp, 3dph, or 3dht or 3dnt with a geometry_file")
    columns = {name: value(key) for key, name in (("a", "a"), ("b", "b"), ("dc", "dc"), ("f0", "f0"),
                                                  ("tauinit", "tau"), ("sigmainit", "sigma"), ("velinit", "vel"),
                                                  ("crake", "rake")) if key in said}
    if "muinit" in said and "sigmainit" in said:
        columns["tau"] = value("muinit") * value("sigmainit")
    if said.get("parameterfromfile", (0, "F"))[1].upper().startswith("T"):
        more, left = table(beside(path, said["parameter_file"][1] if "parameter_file" in said else "no parameter_file"),
                           len(model.cells))
        columns.update(more)
        model.dropped += left
    put_fields(model, columns)
    constants = {name: value(name, default) for name, default in HBI_DEFAULTS.items()}
    shear, speed = constants["rigid"] * 1e9, constants["vs"] * KM
    if min(shear, speed, constants["vref"]) <= 0 or not -1 < constants["pois"] < 0.5:
        at = next(said[name][0] for name in HBI_DEFAULTS if name in said)
        text.fail(at, ", ".join(f"{name} {constants[name]:g}" for name in HBI_DEFAULTS),
                  "rigid, vs and vref > 0 and pois from -1 to 0.5")
    model.options.update(shear_modulus=shear, density=shear / speed ** 2, poisson_ratio=constants["pois"],
                         loading_rate=value("vpl", 0.0))
    if "vref" in said:
        model.options["friction_reference_rate"] = constants["vref"]
    if "evlaw" in said:
        line, law = said["evlaw"]
        if law not in HBI_STATE:
            text.fail(line, f"evlaw {law}", "aging or slip, the laws that fault has")
        model.options["state_law"] = HBI_STATE[law]
    if problem == "3dnt":
        model.options["kernel"] = "full_space"
    model.dropped += unused(said, HBI_USED)
    return model


def beside(path, name):
    """A file that is named from the folder of the program, which is that of the input or one above it."""
    folder = os.path.dirname(os.path.abspath(path))
    if os.path.exists(found := os.path.join(folder, os.path.basename(name))):
        return found
    for _ in range(3):
        if os.path.exists(found := os.path.join(folder, name)):
            return found
        folder = os.path.dirname(folder)
    raise FormatError(f"{path} names {name}, which is not there, expected it from its folder or one above it")


def hbi_grid(path, problem, nx, nz, ds, dip, top):
    """x along strike, which is east; planes of 3dp are in a full space about z = 0, those of 3dph dip to -y below
    ztop."""
    i, j = (k.ravel() for k in np.meshgrid(np.arange(nx), np.arange(nz), indexing="ij"))
    east = (i + 0.5 - nx // 2) * ds
    down = (j + 0.5) * ds if problem == "3dph" else (j + 0.5 - nz // 2) * ds
    turn = np.radians(dip if problem == "3dph" else 90.0)
    cells = np.column_stack([-down * np.cos(turn), east, down * np.sin(turn) - top,
                             *(np.full(nx * nz, v) for v in (ds, ds, 90.0, np.degrees(turn)))])
    model = Model(path, f"HBI, problem {problem}", cells, np.zeros(nx * nz), unit="km")
    if problem == "3dp":
        model.options["kernel"] = "full_space"
    return model


# ---- interact ----

def read_interact(path, at, rake=None, unit=None):
    """Rectangular patches: x y z strike dip half length half width group; lengths have no unit in the file."""
    text, rows = Text(path), []
    for line, words in text:
        if words.strip() and not words.lstrip().startswith("#"):
            values = text.numbers(line, 8, "8: x y z strike dip half-length half-width group")
            if min(values[5:7]) <= 0:
                text.fail(line, f"half a length of {values[5]:g} and half a width of {values[6]:g}",
                          "both above 0: triangles, points and planes of two dimensions are not read")
            if values[7] != int(values[7]):
                text.fail(line, f"a group {values[7]:g}", "a whole number")
            if not 0 < values[4] < 180:
                text.fail(line, f"a dip of {values[4]:g}", "0 < dip < 180 degrees")
            rows.append(values)
    if not rows:
        text.fail(len(text) + 1, "", "8 numbers: x y z strike dip half-length half-width group")
    if unit is None:
        raise FormatError(f"{path} does not say the unit of its lengths, expected --unit m or km")
    rows = np.array(rows)
    size = {"m": 1.0, "km": KM}[unit]
    over = rows[:, 4] > 90  # the other side is the hanging wall, from which a rake has the other sign
    strike, dip = np.where(over, rows[:, 3] + 180, rows[:, 3]) % 360, np.where(over, 180 - rows[:, 4], rows[:, 4])
    cells = np.column_stack([size * rows[:, 1], size * rows[:, 0], -size * rows[:, 2], 2 * size * rows[:, 5],
                             2 * size * rows[:, 6], strike, dip])
    rake = np.full(len(rows), 0.0 if rake is None else rake)
    model = Model(path, "patches of interact", cells, np.where(over, -rake, rake), fault=rows[:, 7].astype(int),
                  unit=unit)
    model.dropped += beyond([words.split() for _, words in text if not words.lstrip().startswith("#")], 8)
    if over.any():
        model.remarks.append(f"{over.sum()} patches dip by more than 90 degrees: their strike and dip are those of the "
                             "other side, and --rake has the other sign there")
    return model


# ---- Quake-DFN ----

DFN = "Ctr_X Ctr_Y Ctr_Z St_L Dip_L StAng DipAng LR/RN a b Dc Theta_i V_i Fric_i Sig0 SigGrad V_Const MaxLeng".split()
V0 = 1e-9  # [m/s], Functions_RSFDFN3DMain_D.jl


def read_dfn(path, at, rake=None):
    """Rectangles in m, by their centres, which are cut into cells no longer than MaxLeng; faults with V_Const creep."""
    text = Text(path)
    head = text.numbers(2, 7, "7: SwitchSS/RN ShearMod PoissonRatio R_Density Crit_TooClose TooCloseNormal_Multiplier "
                        "Minimum_NS")
    names = [name.lower() for name in text.lines[2].split()] if len(text) > 2 else []
    if missing := [name for name in DFN if name.lower() not in names]:
        text.fail(3, text.quoted(3) if len(text) > 2 else "", f"{' '.join(DFN)}; there is no {missing[0]}")
    order = [names.index(name.lower()) for name in DFN]
    rows = [(line, np.array(text.numbers(line, len(names), f"{len(names)} numbers: " + " ".join(DFN)))[order])
            for line, words in text if line > 3 and words.strip()]
    if not rows:
        text.fail(len(text) + 1, "", "18 numbers: " + " ".join(DFN))
    up = all(values[2] < 0 for _, values in rows)
    cells, fault, kept, segments, count = [], [], [], [], 0
    for number, (line, values) in enumerate(rows, 1):
        if not 0 < values[6] < 180 or min(values[3], values[4], values[17]) <= 0:
            text.fail(line, f"lengths {values[3]:g} and {values[4]:g}, a dip of {values[6]:g} and MaxLeng "
                      f"{values[17]:g}", "lengths above 0 and 0 < dip < 180 degrees")
        if min(values[10:13]) <= 0:
            text.fail(line, f"Dc, Theta_i and V_i {values[10]:g}, {values[11]:g}, {values[12]:g}", "numbers > 0")
        nx, nz = (int(np.ceil(values[k] / values[17])) for k in (3, 4))
        if count + nx * nz > MOST:
            text.fail(line, f"{nx} x {nz} cells by MaxLeng {values[17]:g}", f"up to {MOST} in all")
        own = dfn_cells(values, nx, nz, -1 if up else 1)
        segments.append(Segment(number, count + np.arange(len(own)), (nz, nx), None))
        count += len(own)
        cells.append(own)
        fault += [number] * len(own)
        kept.append(np.tile(np.append(values, dfn_rake(head[0], values)), (len(own), 1)))
    cells, kept = np.concatenate(cells), np.concatenate(kept)
    model = Model(path, "Quake-DFN", cells, np.where(kept[:, 6] > 90, -kept[:, 18], kept[:, 18]), fault=np.array(fault),
                  segments=segments, unit="m")
    normal = np.maximum(kept[:, 14] + kept[:, 15] * cells[:, 2], head[6])
    a, b, dc, state, rate, friction = kept[:, 8:14].T
    fields = {"friction_a": (a, "1"), "friction_b": (b, "1"), "friction_slip": (dc, "m"),
              "friction_reference": (friction - a * np.log(rate / V0) - b * np.log(state * V0 / dc), "1"),
              "initial_rate": (rate, "m/s"), "initial_state": (state, "s"), "normal_stress": (normal, "Pa")}
    if kept[:, 16].any():
        fields.update(creep=((kept[:, 16] > 0).astype(float), "1"), loading_rate=(kept[:, 16], "m/s"))
    model.fields = fields
    model.options.update(friction_law="rate_and_state", shear_modulus=head[1], poisson_ratio=head[2], density=head[3],
                         friction_reference_rate=V0)
    model.dropped.append("Crit_TooClose and TooCloseNormal_Multiplier")
    model.dropped += beyond([text.lines[1].split()], 7) + unused(names, [name.lower() for name in DFN], "column")
    return model


def dfn_rake(switch, values):
    """LR/RN by the switch: 1 strike-slip, -1 left-lateral; 2 dip-slip, -1 reverse; 0: a rake."""
    if switch == 0:
        return (values[7] + 180) % 360 - 180
    if switch == 1:
        return 0.0 if values[7] == -1 else 180.0
    return 90.0 if (values[7] == -1) == (values[6] < 90) else -90.0


def dfn_cells(values, nx, nz, down):
    """Cells by rows from the upper left: StAng is counterclockwise from x, dips above 90 degrees are to its left."""
    x, y, z, length, width, angle, dip = values[:7]
    strike = 90.0 - angle
    if dip > 90:
        strike, dip = strike + 180, 180 - dip
    turn, lean = np.radians(strike), np.radians(dip)
    along = np.array([np.cos(turn), np.sin(turn), 0])
    below = np.array([-np.sin(turn) * np.cos(lean), np.cos(turn) * np.cos(lean), np.sin(lean)])
    i, j = (k.ravel() for k in np.meshgrid((np.arange(nx) + 0.5) / nx - 0.5, (np.arange(nz) + 0.5) / nz - 0.5))
    centres = np.array([y, x, down * z]) + (i * length)[:, None] * along + (j * width)[:, None] * below
    return np.column_stack([centres, *(np.full(nx * nz, v) for v in (length / nx, width / nz, strike % 360, dip))])


# ---- PyQuake3D ----

def read_pyquake(path, at, rake=None, mesh=None):
    """parameter.txt with the mesh beside it, and a row of rake a b dc f0 tau sigma vel loads for each cell."""
    text, said = Text(path), {}
    for line, words in text:
        if words.strip() and not words.lstrip().startswith("#"):
            name, _, value = words.partition(":")
            said[name.strip()] = (line, value.strip())
    of_cells = said.get("InputHetoparamter", (0, "False"))[1] == "True"
    missing = [name for name in ("Scale_km", "Shear modulus", "Rock density") + ("Inputparamter file",) * of_cells
               if name not in said]
    if missing:
        text.fail(len(text) + 1, f"no {missing[0]}", f"a line {missing[0]}: VALUE of PyQuake3D")
    if mesh is None:
        meshes = sorted(found for ending in ("msh", "inp") for found
                        in glob.glob(os.path.join(glob.escape(os.path.dirname(os.path.abspath(path))), f"*.{ending}")))
        if len(meshes) != 1:
            raise FormatError(f"{path}: {len(meshes)} meshes (.msh, .inp) are beside it, expected one or --mesh FILE")
        mesh = meshes[0]
    found = read_surfaces(mesh)
    cells, corners = triangles_of(mesh, found, KM if said["Scale_km"][1] == "True" else 1.0)
    model = Model(path, "PyQuake3D", cells, np.zeros(len(cells)), None, corners, found.fault, found.names,
                  unit="km" if said["Scale_km"][1] == "True" else "m")
    model.remarks.append(f"mesh: {mesh}")
    if of_cells:
        columns, left = table(beside(path, said["Inputparamter file"][1]), len(cells), ["rake", *FIELDS, *LOADS])
        put_fields(model, columns)
        model.dropped += left
    else:
        model.dropped.append("stress and friction by regions, which are not a file: only cells are read")
    shear, density = (text.number(*said[name]) for name in ("Shear modulus", "Rock density"))
    lame = text.number(*said["Lame constants"]) if "Lame constants" in said else shear
    if min(shear, density, lame + shear) <= 0:
        text.fail(said["Shear modulus"][0], f"shear modulus {shear:g}, density {density:g} and Lame constant {lame:g}",
                  "numbers > 0")
    model.options.update(shear_modulus=shear, density=density, poisson_ratio=lame / (2 * (lame + shear)))
    if "Plate loading rate" in said:
        model.options["loading_rate"] = text.number(*said["Plate loading rate"])
    if said.get("Half space", (0, "True"))[1] != "True":
        model.options["kernel"] = "full_space"
    model.dropped += unused(said, {"InputHetoparamter", "Scale_km", "Shear modulus", "Rock density",
                                   "Inputparamter file", "Lame constants", "Plate loading rate", "Half space"})
    return model


def is_interact(path):
    """Whether the first line that is no comment begins with eight numbers."""
    words = next((w.split() for _, w in Text(path) if w.strip() and not w.lstrip().startswith("#")), [])
    return len(words) >= 8 and all(re.fullmatch(r"[-+.\deE]+", w) for w in words[:8])


def is_hbi(path):
    """Whether a line has a problem of HBI."""
    return any(re.match(r"\s*problem\s+\w", words) for _, words in Text(path))
