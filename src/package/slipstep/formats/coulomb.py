"""Input files of Coulomb 3, .inp (Toda et al. 2011): upper edges of faults from start to end [km, x east, y north],
right-lateral slip and reverse slip [m], or rake and net slip, dip, depths of top and bottom [km].

Slip of kind (Kode) 100 is on rectangles; 200 and 300 have opening or tensile slip in a column, and 400 and 500 are
point sources, which are left out.
"""

import re

import numpy as np

from .model import Model
from .text import NUMBER, Text, unused
USED = ("E1", "PR1", "Mo", "zero lon", "zero lat")  # of the lines NAME = NUMBER


def read(path, at, rake=None):
    """The model of a file; rake is that of cells without slip, receivers."""
    text = Text(path)
    start = next((k for k, words in text if re.match(r"\s*x{3}\s+x{5,}", words)), None)
    if start is None:
        text.fail(len(text) + 1, "no line of xxx xxxxxxxxxx", "one above rows of faults")
    titles = text.lines[start - 2].lower() if start > 1 else ""
    net = "netslip" in titles or "rake" in titles
    older = "shear" in titles and "normal" in titles
    if not net and not older and ("rt.lat" not in titles and "right-lat" not in titles or "reverse" not in titles):
        text.fail(start - 1, text.quoted(start - 1), "columns X-start Y-start X-fin Y-fin Kode, rt.lat and reverse, or "
                  "shear and normal, or rake and netslip, dip angle, top, bot")
    rows, names, dropped, line = [], [], [], start + 1
    while line <= len(text) and text.lines[line - 1].strip():
        words = text.lines[line - 1].split()
        if not re.fullmatch(r"-?\d+", words[0]):
            break
        values = [text.number(line, word, "11 numbers: # x-start y-start x-fin y-fin Kode slip slip dip top bot")
                  for word in words[:11]]
        if len(values) < 11:
            text.fail(line, f"{len(values)} numbers", "11: # x-start y-start x-fin y-fin Kode slip slip dip top bot")
        if values[5] != 100:
            dropped.append((line, int(values[5])))
        else:
            check(text, line, values)
            rows.append(values[1:])
            names.append(" ".join(words[11:]))
        line += 1
    if not rows:
        text.fail(line, "no faults of Kode 100", "one or more")
    model = of(path, text, np.array(rows), names, net, rake, at, dropped)
    if older:
        model.remarks.append("its columns shear and normal are right-lateral and reverse slip, as Coulomb takes them "
                             "for Kode 100")
    return model


def check(text, line, values):
    """What a rectangle must be."""
    _, x0, y0, x1, y1, _, _, _, dip, top, bottom = values
    if x0 == x1 and y0 == y1:
        text.fail(line, "a fault without length", "a start and an end that differ")
    if not 0 < dip <= 90:
        text.fail(line, f"a dip of {dip:g}", "0 < dip <= 90 degrees")
    if not 0 <= top < bottom:
        text.fail(line, f"a top at {top:g} and a bottom at {bottom:g} km", "0 <= top < bottom")


def moved(model, projection, lon, lat):
    """Cells whose x = y = 0 is at a longitude and latitude, north upward, in a frame that may have another origin."""
    north, east = (float(v) for v in projection.forward(lon, lat))
    turn = projection.convergence(north, east)
    cos, sin = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    x, y = model.cells[:, 0].copy(), model.cells[:, 1].copy()
    model.cells[:, 0], model.cells[:, 1] = north + cos * x + sin * y, east + cos * y - sin * x
    model.cells[:, 5] = (model.cells[:, 5] - turn) % 360
    model.projection = projection


def of(path, text, rows, names, net, rake, at, dropped):
    x0, y0, x1, y1, _, first, second, dip, top, bottom = rows.T
    dx, dy = 1e3 * (x1 - x0), 1e3 * (y1 - y0)
    length, strike, turn = np.hypot(dx, dy), np.degrees(np.arctan2(dx, dy)) % 360, np.radians(dip)
    width = 1e3 * (bottom - top) / np.sin(turn)
    depth = 500 * (top + bottom)
    out = 500 * (bottom - top) / np.tan(turn)  # start and end are those of the upper edge
    middle = np.stack([500 * (y0 + y1), 500 * (x0 + x1)])
    right = np.stack([-np.sin(np.radians(strike)), np.cos(np.radians(strike))])
    north, east = middle + out * right
    slip, angle = (second, first) if net else (np.hypot(first, second), np.degrees(np.arctan2(second, -first)))
    still = slip == 0
    if rake is not None:
        angle = np.where(still, rake, angle)
    model = Model(path, "Coulomb .inp", np.column_stack([north, east, depth, length, width, strike, dip]), angle, slip,
                  fault=np.arange(1, len(rows) + 1), unit="km")
    model.names = {k: name for k, name in enumerate(names, 1) if name}
    if len(model.names) > 200:
        model.fault, model.names = np.ones(len(rows), int), {}
    words = "\n".join(text.lines)
    if found := re.search(rf"PR1=\s*{NUMBER}", words):
        model.options["poisson_ratio"] = float(found[1])
    if not -1 < model.options.get("poisson_ratio", 0.25) < 0.5:
        text.fail(next(k for k, line in text if "PR1=" in line),
                  f"a Poisson's ratio of {model.options['poisson_ratio']:g}", "PR1 between -1 and 0.5")
    if found := re.search(rf"E1=\s*{NUMBER}", words):  # bar
        model.options["shear_modulus"] = float(found[1]) * 1e5 / (2 * (1 + model.options.get("poisson_ratio", 0.25)))
    if found := re.search(rf"Mo\s*=\s*{NUMBER}\s*dyne-cm", text.lines[0]):
        model.claims["moment"] = float(found[1]) * 1e-7
    zero = [re.search(rf"zero {name}\.? =\s*{NUMBER}", words) for name in ("lon", "lat")]
    if all(zero):
        moved(model, at(*(float(found[1]) for found in zero)), *(float(found[1]) for found in zero))
    if still.any():
        model.remarks.append(f"{still.sum()} of {len(rows)} faults have no slip, receivers"
                             + ("; their rake is 0, or --rake" if rake is None else ""))
    for kode in sorted({k for _, k in dropped}):
        model.dropped.append(f"{sum(k == kode for _, k in dropped)} elements of Kode {kode} (from line "
                             f"{next(line for line, k in dropped if k == kode)})")
    said = set(re.findall(r"((?:zero )?[A-Za-z#][\w#-]*)\.?\s*=", words))
    model.dropped += unused(sorted(said), USED)
    return model
