"""Finite-fault models of the USGS, basic_inversion.param (the inversion code of Ji et al. 2002, Solucion.txt): LAT,
LON, depth [km], slip [cm], rake, strike, dip, rupture, rise and fall time [s], moment [dyne cm].

Positions of cells are those of one of their point sources, in older files that at 0.3 of a cell's width: the middle of
the boundary that each segment begins with is that of its plane, whose cells are laid out from there by nx, Dx, ny and
Dy.
"""

import re

import numpy as np

from ..geometry.cells import directions
from ..geometry.geographic import mean_place
from .model import Model, Segment, grid_of
from .text import FormatError, Text, beyond, unused

NAMES = "#Lat. Lon. depth slip rake strike dip t_rup t_ris t_fal mo"
NUMBER = r"\s*=\s*([-+]?[\d.]+)"
DYNE_CM = 1e-7  # N m


def header(text, line, words):
    """Label, nx, Dx, ny and Dy [m] of a line #Fault_segment."""
    found = re.match(
        rf"#Fault_segment{NUMBER}\s*nx\(Along-strike\){NUMBER}\s*Dx{NUMBER}\s*(\w+)\s+"
        rf"ny\(downdip\){NUMBER}\s*Dy{NUMBER}\s*(\w+)", words)
    if not found:
        text.fail(line, text.quoted(line), "#Fault_segment = K nx(Along-strike)= N Dx= L km ny(downdip)= N Dy= W km")
    label, nx, dx, unit, ny, dy, other = found.groups()
    if (unit, other) != ("km", "km"):
        text.fail(line, f"lengths in {unit} and {other}", "km")
    return text.whole(line, label), text.whole(line, nx), 1e3 * text.number(line, dx), text.whole(
        line, ny), 1e3 * text.number(line, dy)


def read_segment(text, line):
    """What a segment's lines say, from #Fault_segment on, and the number of the line after them."""
    label, nx, dx, ny, dy = header(text, line, text.lines[line - 1].strip())
    line += 1
    boundary, hypocentre = [], re.search(r"Lon:\s*([-\d.]+)\s+Lat:\s*([-\d.]+)",
                                         text.lines[line - 1] if line <= len(text) else "")
    left = []
    while line <= len(text) and text.lines[line - 1].strip().startswith("#"):
        left += [f"line {text.quoted(line)}"] * (not re.match(r"\s*#\s*(Boundary|Lon)", text.lines[line - 1]))
        line += 1
    while line <= len(text) and not text.lines[line - 1].strip().startswith("#"):
        boundary.append(text.numbers(line, 3, "longitude, latitude and depth of a corner"))
        line += 1
    names = text.lines[line - 1].split() if line <= len(text) else []
    if [name.lower() for name in names[:11]] != NAMES.lower().split():
        text.fail(line, text.quoted(line) if names else "", NAMES)
    if len(boundary) != 5:
        text.fail(line, f"{len(boundary)} corners of the boundary", "5, the first of which is the last")
    rows, first = [], line
    while len(rows) < nx * ny:
        line += 1
        if line <= len(text) and text.lines[line - 1].strip().startswith("#"):
            text.fail(line, f"another segment after {len(rows)} rows", f"{nx * ny}, nx times ny")
        rows.append(text.numbers(line, 11, f"11 numbers, row {len(rows) + 1} of {nx} x {ny}"))
    left += unused(names, NAMES.split() + names[:11],
                   "column") + beyond([words.split() for words in text.lines[first:line]], max(len(names), 11))
    line += 1
    while line <= len(text) and not text.lines[line - 1].strip():
        line += 1
    if line <= len(text) and not text.lines[line - 1].strip().startswith("#Fault_segment"):
        text.fail(line, text.quoted(line), f"the end of {nx * ny} rows, nx times ny")
    return {"label": label, "nx": nx, "dx": dx, "ny": ny, "dy": dy, "boundary": np.array(boundary[:4]),
            "rows": np.array(rows), "line": line, "left": left,
            "hypocentre": tuple(map(float, hypocentre.groups())) if hypocentre else None}


def layout(segment, projection, remarks):
    """Cells [n, 7] by rows from the upper left, the order of the file's rows, and the strike from true north."""
    rows, nx, ny, dx, dy = (segment[name] for name in ("rows", "nx", "ny", "dx", "dy"))
    if np.ptp(rows[:, 5]) > 1e-3 or np.ptp(rows[:, 6]) > 1e-3:
        raise FormatError(f"segment {segment['label']}: strikes or dips of its cells differ, expected one plane")
    strike, dip = float(rows[0, 5]), float(rows[0, 6])
    north, east = projection.forward(segment["boundary"][:, 0], segment["boundary"][:, 1])
    centre = np.array([north.mean(), east.mean(), 1e3 * segment["boundary"][:, 2].mean()])
    strike -= projection.convergence(*centre[:2])
    along, down = (v[0] for v in directions(np.array([[0, 0, 0, 0, 0, strike, dip]], float)))
    i, j = (k.ravel() for k in np.meshgrid(np.arange(nx) - (nx - 1) / 2, np.arange(ny) - (ny - 1) / 2))
    points = np.column_stack([*projection.forward(rows[:, 1], rows[:, 0]), 1e3 * rows[:, 2]])
    found = grid_of(points, strike, dip, dx, dy) if nx * ny > 1 else (np.zeros(1, int), np.zeros(1, int), (1, 1))
    if not found or found[2] != (ny, nx):
        raise FormatError(f"segment {segment['label']}: its rows are in no grid of {nx} x {ny} cells of one strike and "
                          "dip, expected one plane")
    order = np.argsort(found[1] * nx + found[0], kind="stable")
    centres = centre + (i * dx)[:, None] * along + (j * dy)[:, None] * down
    top = centres[0, 2] - dy / 2 * down[2]
    if top < -1.0:  # positions of upper edges: the boundary joins those of the first and last cells
        centres += dy / 2 * down
        remarks.append(f"segment {segment['label']}: as centres its positions would be {-top:.0f} m above the ground, "
                       "so that they are taken for upper edges")
    else:
        offset = (points[order] - centres).mean(axis=0)
        shares = float(offset @ along) / dx + 0.5, float(offset @ down) / dy + 0.5
        if max(abs(share - 0.5) for share in shares) > 0.05:
            remarks.append(f"segment {segment['label']}: positions of the file are at {shares[0]:.2f} of a cell's "
                           f"length and {shares[1]:.2f} of its width; cells are laid out from the boundary's middle")
    cells = np.column_stack([centres, *(np.full(nx * ny, value) for value in (dx, dy, strike, dip))])
    return cells, order, float(rows[0, 5])


def read(path, at, rake=None):
    """The model of a file; rake is not used."""
    text = Text(path)
    line = next((k for k, words in text if words.strip()), len(text) + 1)
    found = (re.match(rf"#Total number of fault_segments{NUMBER}", text.lines[line - 1].strip()) if line <= len(text)
             else None)
    if not found:
        text.fail(line, text.quoted(line) if line <= len(text) else "", "#Total number of fault_segments= N")
    total, parts = text.whole(line, found[1]), []
    line += 1
    for number in range(total):
        if line > len(text):
            text.fail(line, f"{number} segments", f"{total}")
        parts.append(read_segment(text, line))
        line = parts[-1]["line"]
    if line <= len(text):
        text.fail(line, text.quoted(line), f"the end of {total} segments")
    first = parts[0]["hypocentre"] or mean_place(*parts[0]["boundary"][:, :2].T)
    projection, remarks, segments, cells, rows = at(*first), [], [], [], []
    for part in parts:
        try:
            own, order, strike = layout(part, projection, remarks)
        except FormatError as error:
            raise FormatError(f"{path}: {error}") from None
        segments.append(Segment(part["label"], sum(map(len, cells)) + np.arange(len(own)), (part["ny"], part["nx"]),
                                strike))
        cells.append(own)
        rows.append(part["rows"][order])
    rows = np.concatenate(rows)
    columns = {"rupture_time": (rows[:, 7], "s"), "rise_time": (rows[:, 8] + rows[:, 9], "s"),
               "moment": (DYNE_CM * rows[:, 10], "N m")}
    claims = {"area": sum(p["nx"] * p["ny"] * p["dx"] * p["dy"] for p in parts),
              "moment": float(DYNE_CM * rows[:, 10].sum()), "title": "finite fault of the USGS"}
    if parts[0]["hypocentre"]:
        k = int(np.argmin(rows[:, 7]))
        claims["hypocentre"] = (*first, float(np.concatenate(cells)[k, 2]))
    model = Model(path, "USGS finite fault .param", np.concatenate(cells), rows[:, 4], 1e-2 * rows[:, 3],
                  fault=np.repeat([p["label"] for p in parts], [len(c) for c in cells]),
                  columns=columns, claims=claims, segments=segments, projection=projection, unit="km", remarks=remarks)
    model.dropped += ["the shares of rise and fall in rise_time",
                      *dict.fromkeys(left for part in parts for left in part["left"])]
    return model
