"""Slip models of SRCMOD and of the USGS, .fsp, in and out (equake-rc.info/SRCMOD/fileformats/fsp).

Lengths are km, slip is m. Points are the middle of the upper edge of each cell ("top-center") or its centre, as the
header says; where the depth of the upper edge in the header agrees with the other one, that holds. X and Y of most
files of 2007 have each other's name, "X==NS" is east; positions are taken from LAT and LON.
"""

import re

import numpy as np

from ..geometry.cells import directions
from .model import Model, Segment, grid_of, tiled
from .text import NUMBER, FormatError, Text, unused

EQUALS = r"\s*=\s*"
LAYER = re.compile(r"(?:^|(?<=\s))[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?(?=\s|$)")  # a number of a line that has nothing else
UNKNOWN = (999.0, -99.0, -999.0)  # "not known" and "varies" of SRCMOD
KEY = re.compile(rf"\b([A-Za-z]\w*){EQUALS}{NUMBER}")
# of the header
KEYS = ("LAT", "LON", "DEP", "LEN", "WID", "Mw", "Mo", "STRK", "DIP", "RAKE", "Htop", "HypX", "HypZ", "Nx", "Nz", "Dx",
        "Dz")
OF_SEGMENT = ("LEN", "WID", "Dx", "Dz", "Z2top", "Nsbfs")
OURS = ("X", "Y", "STRIKE", "layers")  # not of a value, or read elsewhere
ROUNDED = 0.05  # of a cell: by how much Dx and Dz may be rounded


def said(words, name):
    """The number of NAME = NUMBER in a line as it is written, or None."""
    found = re.search(rf"\b{name}{EQUALS}{NUMBER}", words, re.I)
    return found[1] if found else None


class Reader:
    """One pass over the lines: what is said before the rows, and rows by segment."""

    def __init__(self, path):
        self.text = Text(path)
        self.header, self.layers, self.segments, self.columns, self.place = {}, [], [], None, None
        self.title, self.in_layers, self.nlayers, self.left = "", False, None, {}
        for line, words in self.text:
            if words.lstrip().startswith("%"):
                self.comment(line, words.replace("%", " ").strip())
            elif words.strip() and self.columns:
                self.row(line, [word for word in words.split() if word != "x"])  # as between SLIP and RAKE of Parkfield
            elif words.strip() and not self.header:
                self.text.fail(line, self.text.quoted(line), "a line of FINITE-SOURCE RUPTURE MODEL that begins with %")
        if not {"LAT", "LON", "Mo"} <= set(self.header):
            raise FormatError(f"{path}: no Loc and Size with LAT, LON and Mo in the header, expected an .fsp "
                              "file of SRCMOD")
        if not self.segments or not self.segments[-1]["rows"]:
            self.text.fail(len(self.text) + 1, "", "rows of LAT LON X Y Z SLIP")

    def comment(self, line, words):
        self.left.update({name: value for name, value in KEY.findall(words)
                          if name.lower() not in map(str.lower, (*KEYS, *OF_SEGMENT, *OURS))
                          and self.text.number(line, value) not in UNKNOWN})
        for name in KEYS:
            value = said(words, name)
            if value is not None and not self.segments and name not in self.header:
                self.header[name] = self.text.number(line, value)
        segment = re.search(rf"SEGMENT\s*#?\s*(\d+)\s*:\s*STRIKE{EQUALS}{NUMBER}.*DIP{EQUALS}{NUMBER}", words, re.I)
        if segment:
            self.close(line)
            self.segments.append({"label": int(segment[1]), "strike": self.text.number(line, segment[2]),
                                  "dip": self.text.number(line, segment[3]), "rows": [], "lines": [], "said": {}})
        elif self.segments and not self.segments[-1]["rows"]:
            for name in OF_SEGMENT:
                value = said(words, name)
                if value is not None:
                    self.segments[-1]["said"][name] = self.text.number(line, value)
        elif not self.segments and (value := said(words, "Nsbfs")) is not None:
            self.header["Nsbfs"] = self.text.number(line, value)
        if words.startswith("Event :"):
            self.title = " ".join(words[7:].split())
        if found := re.search(r"given for (top-center|center|top center) of each", words, re.I):
            self.place = "top" if found[1].lower().startswith("top") else "centre"
        if re.search(r"coordinates in", words, re.I) and not re.search(r"coordinates in km;\s*SLIP in m\b", words,
                                                                       re.I):
            self.text.fail(line, self.text.quoted(line), "X,Y,Z coordinates in km; SLIP in m")
        if re.search(r"\bNo\.?\s+of layers", words, re.I):
            self.in_layers, self.nlayers = True, self.text.number(line, said(words, "layers") or "nothing",
                                                                  "a number of layers")
        elif self.in_layers and len(LAYER.findall(words)) == len(words.split()) >= 4:
            self.layers.append([self.text.number(line, w) for w in words.split()[:4]])
        elif self.layers:
            self.in_layers = False
        if re.match(r"LAT\s+LON\b", words, re.I):
            before, self.names = self.columns, words.upper().split()
            self.columns = [w.split("==")[0].upper() for w in words.split()]
            if not {"LAT", "LON", "Z", "SLIP"} <= set(self.columns):
                self.text.fail(line, self.text.quoted(line), "columns LAT LON X Y Z SLIP")
            if before and before != self.columns:
                self.text.fail(line, self.text.quoted(line), " ".join(before) + ", as before")
            if not self.segments:
                self.segments.append({"label": 1, "strike": self.header.get("STRK"), "dip": self.header.get("DIP"),
                                      "rows": [], "lines": [], "said": {}})

    def row(self, line, words):
        segment = self.segments[-1]
        if len(words) < len(self.columns):
            self.text.fail(line, f"{len(words)} numbers", f"{len(self.columns)}: {' '.join(self.columns[:12])}")
        segment["rows"].append([self.text.number(line, word) for word in words[:len(self.columns)]])
        segment["lines"].append(line)

    def close(self, line):
        if self.segments and not self.segments[-1]["rows"]:
            self.text.fail(line, "another segment", f"rows of segment {self.segments[-1]['label']}")

    def check_count(self, segment, remarks):
        """As many rows as the header says; files of the USGS have 27 "subfaults" where 27 times 12 are meant."""
        single = len(self.segments) == 1
        rows, wanted = len(segment["rows"]), segment["said"].get("Nsbfs", self.header.get("Nsbfs") if single else None)
        of_grid = self.header.get("Nx", 0) * self.header.get("Nz", 0) if single else 0
        if wanted is None or rows == wanted:
            return
        if rows == of_grid:
            remarks.append(f"Nsbfs says {wanted:g} cells, Nx and Nz {of_grid:g}, which are there")
            return
        self.text.fail(segment["lines"][-1] + 1, f"{rows} rows of segment {segment['label']}",
                       f"{wanted:g}, as Nsbfs says")


def places(reader, values, projection, remarks):
    """Points [n, 3] of a segment's rows, at LAT and LON; X and Y, of more digits, say where they are in it."""
    columns = reader.columns
    north, east = projection.forward(values[:, columns.index("LON")], values[:, columns.index("LAT")])
    points = np.column_stack([north, east, 1e3 * values[:, columns.index("Z")]])
    if "X" in columns and "Y" in columns:
        own = points[:, :2] - points[:, :2].mean(axis=0)
        flat = 1e3 * values[:, [columns.index("X"), columns.index("Y")]]
        flat -= flat.mean(axis=0)
        off = [np.abs(flat[:, way] - own).max() for way in ([1, 0], [0, 1])]
        way = int(off[1] < off[0])
        if off[way] <= 0.02 * np.abs(own).max() + 30:
            points[:, :2] += (flat[:, [0, 1] if way else [1, 0]]) - own
        names = [name for name in reader.names if name.startswith("X==")]
        if (len(values) > 1 and names and (names[0] == "X==NS") != bool(way)
            and (word := f"{names[0]} is wrong: by LON and LAT its X is {'north' if way else 'east'}") not in remarks):
            remarks.append(word)
    return points


def unrounded(sizes, whole, points, segment):
    """Lengths and widths of cells [km]: Dx and Dz, or what extent and points say, as Dx is often rounded."""
    found = grid_of(points, segment["strike"], segment["dip"], *(1e3 * size for size in sizes))
    if not found:
        return sizes
    along, down = (v[0] for v in directions(np.array([[0, 0, 0, 0, 0, segment["strike"], segment["dip"]]], float)))
    taken = []
    for size, extent, count, way in zip(sizes, whole, found[2][::-1], (along, down)):
        distance = np.ptp(points @ way) / 1e3 / (count - 1) if count > 1 else size
        share = extent / count if extent else size
        taken.append(share if abs(share / size - 1) < ROUNDED and abs(share - distance) < abs(size - distance)
                     else size)
    return taken


def sizes(reader, segment, points, remarks):
    """Length and width [m] of a segment's cells, and what the points are."""
    of, header = segment["said"], reader.header
    dx, dz = (of.get(name, header.get(name)) for name in ("Dx", "Dz"))
    if not dx or not dz or dx <= 0 or dz <= 0:
        raise FormatError(f"{reader.text.path}: segment {segment['label']} has no Dx and Dz, expected lengths of "
                          "cells in km")
    single = len(reader.segments) == 1
    dx, dz = unrounded((dx, dz), [of.get(name, header.get(name) if single else None) for name in ("LEN", "WID")],
                       points, segment)
    place = reader.place or "top"
    top, row = of.get("Z2top", header.get("Htop") if single else None), points[:, 2].min() / 1e3
    half = 0.5 * dz * np.sin(np.radians(segment["dip"]))
    if top is not None and top not in UNKNOWN and half > 0:
        other = "centre" if place == "top" else "top"
        off = {"top": abs(row - top), "centre": abs(row - half - top)}
        if off[other] < 0.25 * half < off[place]:
            remarks.append(f"segment {segment['label']}: coordinates are said to be of the {place} of cells, but by "
                           f"the depth of the upper edge, {top:g} km, they are of the {other}")
            place = other
    return 1e3 * dx, 1e3 * dz, place


def read(path, at, rake=None):
    """The model of a file. at(longitude, latitude): the projection about an origin, by default the hypocentre's."""
    reader = Reader(path)
    header, text = reader.header, reader.text
    projection = at(header["LON"], header["LAT"])
    remarks, cells, rows, segments, labels, count, off = [], [], [], [], [], 0, 0.0
    for segment in reader.segments:
        reader.check_count(segment, remarks)
        values = np.array(segment["rows"])
        if segment["strike"] is None or segment["dip"] is None or not 0 < segment["dip"] <= 90:
            text.fail(segment["lines"][0], f"strike and dip {segment['strike']}, {segment['dip']}",
                      "STRK and a DIP above 0 up to 90 degrees in the header")
        points = places(reader, values, projection, remarks)
        turn = projection.convergence(*points[:, :2].mean(axis=0))
        dx, dz, place = sizes(reader, segment, points, remarks)
        own, shape, order, away = tiled(points, segment["strike"] - turn, segment["dip"], dx, dz, place)
        if shape is None and len(points) > 1:
            remarks.append(f"segment {segment['label']}: its points are in no grid of one strike and dip; its cells "
                           "are at the points")
        off = max(off, away)
        cells.append(own[order])
        rows.append(values[order])
        strike = float(own[0, 5] + turn) % 360
        if abs((strike - segment["strike"] + 180) % 360 - 180) > 1e-6:
            remarks.append(f"segment {segment['label']}: its points run along {strike:.2f} degrees, which is taken; "
                           f"the header has {segment['strike']:g}")
        segments.append(Segment(segment["label"], count + np.arange(len(own)), shape, strike))
        labels += [segment["label"]] * len(own)
        count += len(own)
    cells, rows = np.concatenate(cells), np.concatenate(rows)
    return finished(reader, Model(path, "SRCMOD .fsp", cells, np.zeros(count), fault=np.array(labels),
                                  segments=segments, projection=projection, unit="km", remarks=remarks),
                    rows, rake, off)


def finished(reader, model, rows, rake, off):
    """The model with its columns, and what the header says."""
    header, columns = reader.header, reader.columns
    model.slip = rows[:, columns.index("SLIP")]
    if "RAKE" in columns:
        model.rake = rows[:, columns.index("RAKE")]
    elif rake is not None or header.get("RAKE", 999.0) not in UNKNOWN:
        model.rake = np.full(len(rows), header["RAKE"] if rake is None else rake)
    else:
        raise FormatError(f"{reader.text.path}: no column RAKE and no RAKE in the header, expected --rake DEGREES")
    for name, column, unit in (("rupture_time", "TRUP", "s"), ("rise_time", "RISE", "s"),
                               ("moment", "SF_MOMENT", "N m")):
        if column in columns:
            model.columns[name] = (rows[:, columns.index(column)], unit)
    layers = np.array([row for row in reader.layers if len(row) == 4])
    if (len(layers) and (reader.nlayers is None or len(layers) == reader.nlayers) and (layers[:, 2:] > 0).all()
        and (np.diff(layers[:, 0]) > 0).all()):
        model.layers = layers * (1e3, 1e3, 1e3, 1e3)
    elif reader.layers:
        model.remarks.append(f"its {len(reader.layers)} layers are not used: {reader.nlayers:g} are announced, with "
                             "depths that increase" if reader.nlayers else "its layers are not used")
    windows = [c for c in columns if re.fullmatch(r"(rk|rake)?TW\d+", c, re.I)]
    other = [c for c in columns if c not in windows and c not in ("LAT", "LON", "X", "Y", "Z", "SLIP", "RAKE", "TRUP",
                                                                  "RISE", "SF_MOMENT")]
    model.dropped += (([f"{len(windows)} columns of time windows ({windows[0]} to {windows[-1]})"] if windows else [])
                      + unused(other, (), "column") + unused(reader.left, ()))
    model.claims = {name: header[key] * scale for name, key, scale in (("moment", "Mo", 1), ("magnitude", "Mw", 1),
                                                                       ("length", "LEN", 1e3), ("width", "WID", 1e3),
                                                                       ("strike", "STRK", 1),
                                                                       ("dip", "DIP", 1), ("rake", "RAKE", 1),
                                                                       ("top", "Htop", 1e3), ("along", "HypX", 1e3),
                                                                       ("down", "HypZ", 1e3)) if key in header
                    and header[key] not in UNKNOWN}
    own = [(segment["said"].get("LEN"), segment["said"].get("WID")) for segment in reader.segments]
    if all(length and width for length, width in own):
        model.claims["area"] = sum(1e6 * length * width for length, width in own)
    model.claims["hypocentre"] = (header["LON"], header["LAT"], 1e3 * header.get("DEP", 0.0))
    if reader.title:
        model.claims["title"] = reader.title
    if off > 1:
        model.remarks.append(f"points of the file are up to {off:.0f} m from the regular cells that are made of them")
    return model


# ---- out ----

def write(model, file):
    """An .fsp of a model: points are the middle of upper edges, LAT and LON have five digits, SLIP four."""
    claims = model.claims
    moment = claims.get("moment") or model.moment()[0]
    start = model.hypocentre()
    lon, lat, depth = claims.get("hypocentre") or (*(float(v) for v in model.projection.inverse(*start[:2])), start[2])
    cells, slip = model.cells, model.slip
    weight = model.area * np.abs(slip) if np.any(slip) else model.area
    parts = model.segments or [Segment(int(k), np.flatnonzero(model.fault == k), None, None)
                               for k in np.unique(model.fault)]
    single, first = len(parts) == 1, parts[0]
    _, along, down = model.on_plane(parts)
    shape = first.shape or (1, len(first.rows))
    length, width = (claims.get(name, value) for name, value in zip(("length", "width"), extent(model, parts)))
    names = {"rupture_time": ("TRUP", "{:9.4f}"), "rise_time": ("RISE", "{:9.4f}"), "moment": ("SF_MOMENT", "{:12.4e}")}
    more = [(name, *names[name]) for name in names if name in model.columns]
    rule = "% " + 98 * "-" + "\n"
    tag = re.sub(r"\W+", "_", model.path.rsplit("/", 1)[-1].rsplit(".", 1)[0])
    out = [f"% {34 * '-'}  FINITE-SOURCE RUPTURE MODEL  {32 * '-'}\n%\n% Event : "
           f"{claims.get('title', 'slip by SlipStep')}\n% EventTAG: {tag}\n%\n"]
    out.append(f"% Loc  : LAT = {lat:.5f}   LON = {lon:.5f}   DEP = {depth / 1e3:.3f}\n")
    out.append(f"% Size : LEN = {length / 1e3:.4f} km   WID = {width / 1e3:.4f} km   Mw = "
               f"{2 / 3 * (np.log10(moment) - 9.1) if moment > 0 else 0:.4f}   Mo = {moment:.15g} Nm\n")
    out.append(f"% Mech : STRK = {claims.get('strike', strike_of(model, first)):.4f}   DIP = "
               f"{claims.get('dip', float(np.average(cells[:, 6], weights=weight))):.4f}   "
               f"RAKE = {claims.get('rake', mean_angle(model.rake, weight)):.4f}   Htop = "
               f"{model.corners[..., 2].min() / 1e3:.4f} km\n% Rupt : HypX = {claims.get('along', along) / 1e3:.4f} "
               f"km   HypZ = {claims.get('down', down) / 1e3:.4f} km   avTr = 999 s   avVr = 999 km/s\n%\n")
    out.append(f"% Invs : Nx = {shape[1]}   Nz = {shape[0]}   Fmin = 999 Hz   Fmax = 999 Hz\n% Invs : Dx = "
               f"{cells[first.rows[0], 3] / 1e3:.4f} km   Dz = {cells[first.rows[0], 4] / 1e3:.4f} km\n"
               f"% Invs : Ntw = 1   Nsg = {len(parts)}   (# of time-windows,# of fault segments)\n%\n{rule}%\n% "
               "VELOCITY-DENSITY STRUCTURE\n")
    layers = np.zeros((0, 4)) if model.layers is None else model.layers / 1e3
    out.append(f"% No. of layers = {len(layers)}\n%\n%  DEPTH    P-VEL    S-VEL     DENS\n%  [km]    [km/s]   [km/s]  "
               "[g/cm^3]\n")
    out += ["% " + "".join(f"{v:9.4f}" for v in row) + "\n" for row in layers]
    out.append(f"%\n{rule}% SOURCE MODEL PARAMETERS\n"
               + (f"%   Nsbfs = {len(first.rows)} subfaults\n" if single else "")
               + "%   X,Y,Z coordinates in km; SLIP in m\n%   if applicable: RAKE in deg, RISE in s, TRUP in s\n%\n"
               "%   Coordinates are given for top-center of each subfault or segment: |'|\n%   Origin of local "
               "coordinate system at epicenter: X (EW) = 0, Y (NS) = 0\n")
    titles = ("%     LAT         LON       X==EW      Y==NS        Z        SLIP      RAKE"
              + "".join(f"{title:>12}" for _, title, _ in more) + "\n" + rule)
    out.append(titles if single else f"{rule}% {29 * '-'}   MULTISEGMENT MODEL   {45 * '-'}\n")
    for part in parts:
        out += (([] if single else [segment_header(model, part, rule), titles])
                + list(rows_of(model, part, more, (lon, lat))))
    file.writelines(out)


def segment_header(model, part, rule):
    cells = model.cells[part.rows]
    length, width = extent(model, [part])
    return (f"{rule}% SEGMENT # {part.label}:  STRIKE = {strike_of(model, part):.4f} deg   DIP = "
            f"{cells[:, 6].mean():.4f} deg\n"
            f"%   LEN = {length / 1e3:.4f} km   WID = {width / 1e3:.4f} km\n%   Dx = {cells[0, 3] / 1e3:.4f} km   Dz = "
            f"{cells[0, 4] / 1e3:.4f} km\n"
            f"%   depth to top:   Z2top = {model.corners[part.rows][..., 2].min() / 1e3:.4f} km\n%   Nsbfs = "
            f"{len(cells)} subfaults\n{rule}")


def rows_of(model, part, more, origin):
    """Lines of a segment's cells, along strike and then down dip."""
    upper = model.corners[part.rows][:, :2].mean(axis=1) if model.triangles is None else model.cells[part.rows, :3]
    lon, lat = model.projection.inverse(upper[:, 0], upper[:, 1])
    north, east = (float(v) for v in model.projection.forward(*origin))
    for k, row in enumerate(part.rows):
        yield (f"{lat[k]:11.5f} {lon[k]:11.5f} {(upper[k, 1] - east) / 1e3:10.4f} {(upper[k, 0] - north) / 1e3:10.4f} "
               f"{upper[k, 2] / 1e3:9.4f} {model.slip[row]:9.4f} {model.rake[row]:9.4f}"
               + "".join(" " + form.format(model.columns[name][0][row]).rjust(11) for name, _, form in more) + "\n")


def mean_angle(angles, weight):
    turn = np.exp(1j * np.radians(angles)) @ weight
    return float(np.degrees(np.angle(turn)))


def strike_of(model, part):
    """From true north [degrees]."""
    if part.strike is not None:
        return part.strike
    centre = model.cells[part.rows].mean(axis=0)
    return float((mean_angle(model.cells[part.rows, 5], model.area[part.rows])
                  + model.projection.convergence(*centre[:2])) % 360)


def extent(model, parts):
    """Sum of the lengths of segments and the largest width [m]."""
    length = sum(part.shape[1] * model.cells[part.rows[0], 3] if part.shape else model.cells[part.rows, 3].sum()
                 for part in parts)
    width = max((part.shape[0] if part.shape else 1) * model.cells[part.rows[0], 4] for part in parts)
    return float(length), float(width)
