"""Standard Rupture Format 1.0 and 2.0, .srf, in and out (Graves 2014, SCEC's Standard Rupture Format): lengths of
planes are km, slip is cm, area is cm2, points are centres of cells."""

import re

import numpy as np

from ..geometry.cells import directions
from ..geometry.geographic import mean_place
from .model import Model, Segment, tiled
from .text import NUMBER, Text

DENSITY = 2700.0  # [kg/m3] where nothing says it; S velocities then have the rigidity
# of the magnitudes of genslip, which writes mag= into comments: log10 of the moment [N m] less 1.5 times the magnitude
# (Hanks and Kanamori 1979)
GENSLIP = 9.05
CLOSE = 0.01  # by which areas may differ


class Reader:
    """One pass over the lines: planes, and points with slip along their rakes and across them."""

    def __init__(self, path):
        self.text, self.line, self.planes, self.blocks, self.comments, self.more = Text(path), 0, [], [], [], 0
        version = self.following("a version, 1.0 or 2.0")
        if version.split()[0] not in ("1.0", "2.0"):
            self.text.fail(self.line, self.text.quoted(self.line), "a version, 1.0 or 2.0")
        self.count = 8 if version.split()[0] == "1.0" else 10
        while (words := self.following("POINTS N or PLANE N", not self.blocks)) is not None:
            name, _, number = words.strip().partition(" ")
            if name == "PLANE":
                self.planes += [self.plane()
                                for _ in range(self.text.whole(self.line, number.strip() or "nothing", "PLANE N"))]
            elif name == "POINTS":
                total = self.text.whole(self.line, number.strip() or "nothing", "POINTS N")
                self.blocks.append(np.array([self.point(k + 1, total) for k in range(total)]))
            else:
                self.text.fail(self.line, self.text.quoted(self.line), "PLANE N or POINTS N")
        if not sum(map(len, self.blocks)):
            self.text.fail(len(self.text) + 1, "", "POINTS N with one point or more")

    def following(self, expected, needed=True):
        """The next line that is neither empty nor a comment; None at the end where none is needed."""
        while self.line < len(self.text):
            self.line += 1
            words = self.text.lines[self.line - 1]
            if words.lstrip().startswith("#"):
                self.comments.append(words)
            elif words.strip():
                return words
        if needed:
            self.text.fail(len(self.text) + 1, "", expected)
        return None

    def numbers(self, count, what):
        words = self.following(what).split()
        if len(words) < count:
            self.text.fail(self.line, f"{len(words)} numbers", what)
        self.more += len(words) > count
        return [self.text.number(self.line, word) for word in words[:count]]

    def plane(self):
        first = self.numbers(6, "longitude, latitude, nstk, ndip, length and width of a plane")
        return first + self.numbers(5, "strike, dip, depth of the top and hypocentre of a plane")

    def point(self, number, total):
        """lon lat dep stk dip area tinit dt, vs den or 0, rake, slip along, across, opening, samples."""
        first = self.numbers(self.count, f"point {number} of {total}: {self.count} numbers of lon lat dep stk dip area "
                             f"tinit dt{' vs den' if self.count == 10 else ''}")
        second = self.numbers(7, f"point {number} of {total}: rake slip1 nt1 slip2 nt2 slip3 nt3")
        left = samples = sum(self.text.whole(self.line, str(second[k])) for k in (2, 4, 6))
        while left > 0:
            words = self.following(f"point {number} of {total}: {samples} samples of slip rate").split()
            left -= len(words)
            if left < 0:
                self.text.fail(self.line, f"{-left} samples too many", f"{samples} of point {number}")
            for word in words:
                self.text.number(self.line, word)
        return first + [0.0] * (10 - self.count) + [second[0], second[1], second[3], second[5],
                                                    max(second[2], second[4])]


def of_plane(plane, points, places, projection, remarks, number):
    """Cells [n, 7], their order and (nz, nx) of the points of a plane."""
    nx, nz, length, width, strike, dip = (*map(int, plane[2:4]), 1e3 * plane[4], 1e3 * plane[5], plane[6], plane[7])
    dx, dz = length / max(nx, 1), width / max(nz, 1)
    turn = projection.convergence(*places[:, :2].mean(axis=0))
    cells, shape, order, off = tiled(places, strike - turn, dip, dx, dz)
    whole = len(points) == nx * nz
    if whole and shape == (nz, nx):
        if off > 1:
            remarks.append(f"plane {number}: points of the file are up to {off:.0f} m from the regular cells that are "
                           "made of them")
        return cells, order, shape, float(cells[0, 5] + turn) % 360
    sides = (dx, dz) if abs(dx * dz / (1e-4 * np.median(points[:, 5])) - 1) < 0.05 else None
    remarks.append(f"plane {number}: " + (f"{len(points)} points of {nx} x {nz}" if not whole else "its points are in "
                                          "no grid of one strike and dip") + "; its cells are at the points")
    return loose(points, places, turn, sides), np.arange(len(points)), None, None


def loose(points, places, turn, sides=None):
    """Cells at the points, squares of their areas unless the sides are known."""
    side = np.sqrt(1e-4 * points[:, 5])
    length, width = (side, side) if sides is None else (np.full(len(points), v) for v in sides)
    return np.column_stack([places, length, width, points[:, 3] - turn, points[:, 4]])


def read(path, at, rake=None):
    """The model of a file; rake is not used."""
    reader = Reader(path)
    points = np.concatenate([block for block in reader.blocks if len(block)])
    projection, remarks, segments = at(*mean_place(*points[:, :2].T)), [], []
    north, east = projection.forward(points[:, 0], points[:, 1])
    places = np.column_stack([north, east, 1e3 * points[:, 2]])
    counts, rows, cells, first, label = [int(p[2]) * int(p[3]) for p in reader.planes], [], [], 0, []
    if len(reader.blocks) == len(counts):
        counts = [len(block) for block in reader.blocks]
    elif sum(counts) != len(points):
        counts = [len(points)] if len(counts) == 1 else []
    for number, (plane, count) in enumerate(zip(reader.planes, counts), 1):
        part = np.arange(first, first + count)
        own, order, shape, strike = of_plane(plane, points[part], places[part], projection, remarks, number)
        segments.append(Segment(number, part, shape, strike))
        cells.append(own[order])
        rows.append(points[part][order])
        label += [number] * count
        first += count
    if not counts:
        remarks.append("no planes are described for its points, whose cells become squares of their areas")
        cells, rows, label = [loose(points, places,
                                    projection.convergence(north.mean(), east.mean()))], [points], [1] * len(points)
    rows, cells = np.concatenate(rows), np.concatenate(cells)
    model = Model(path, f"SRF {1 if reader.count == 8 else 2}.0", cells,
                  (rows[:, 10] + np.degrees(np.arctan2(rows[:, 12], rows[:, 11]))) % 360,
                  1e-2 * np.hypot(rows[:, 11], rows[:, 12]),
                  fault=np.array(label), segments=segments if all(s.shape for s in segments) else [],
                  projection=projection, unit="km and cm", remarks=remarks)
    model.rake[model.rake > 180] -= 360
    model.columns = {"rupture_time": (rows[:, 6], "s"), "rise_time": (rows[:, 7] * rows[:, 14], "s")}
    start(model, reader)
    if (rows[:, 8:10] > 0).all():
        model.columns["rigidity"] = (1e3 * rows[:, 9] * (1e-2 * rows[:, 8]) ** 2, "Pa")
    claim(model, reader, rows)
    return model


def start(model, reader):
    """The hypocentre of the plane that breaks first, which it gives from the middle of its upper edge; 0 0 is none."""
    first = model.fault[int(np.argmin(model.columns["rupture_time"][0]))]
    part = next((part for part in model.segments if part.label == first), None)
    if part is None or not any(reader.planes[first - 1][9:]):
        return
    own = model.cells[part.rows]
    along, down = (v[0] for v in directions(own[:1]))
    top = model.corners[part.rows[:part.shape[1]], :2].reshape(-1, 3).mean(axis=0)
    north, east, depth = top + 1e3 * (reader.planes[first - 1][9] * along + reader.planes[first - 1][10] * down)
    model.claims["hypocentre"] = (*(float(v) for v in model.projection.inverse(north, east)), float(depth))


def claim(model, reader, rows):
    """What planes and comments of the file say, and what is left out."""
    planes = np.array(reader.planes).reshape(-1, 11)
    if len(planes):
        model.claims |= {"length": 1e3 * planes[:, 4].sum(), "width": 1e3 * planes[:, 5].max(),
                         "area": 1e6 * float(planes[:, 4] @ planes[:, 5]), "strike": planes[0, 6],
                         "dip": planes[0, 7], "top": 1e3 * planes[:, 8].min()}
    if found := re.search(rf"mag=\s*{NUMBER}", " ".join(reader.comments)):
        model.claims["magnitude"] = float(found[1])
        model.claims["moment"] = 10 ** (1.5 * model.claims["magnitude"] + GENSLIP)
    area = float(1e-4 * rows[:, 5].sum())
    if abs(area / model.area.sum() - 1) > CLOSE:
        model.remarks.append(f"areas of its points add up to {area / 1e6:.6g} km2")
    if rows[:, 13].any():
        model.dropped.append(f"opening of {np.count_nonzero(rows[:, 13])} points")
    if "rigidity" not in model.columns and rows[:, 8:10].any():
        model.dropped.append(f"S velocities and densities, which {np.count_nonzero((rows[:, 8:10] <= 0).any(axis=1))} "
                             f"of {len(rows)} points do not have")
    if reader.more:
        model.dropped.append(f"more numbers than the format has in {reader.more} lines")
    if others := [words for words in reader.comments if "mag=" not in words]:
        model.dropped.append(f"{len(others)} lines of comments")
    model.dropped.append("shapes of slip rates: rise_time is how long slip lasts")


# ---- out ----

def write(model, file):
    """An SRF 2.0 of a model: slip rates are those of a run, model.rates, or isosceles triangles of the rise times."""
    rigidity = model.rigidity()[0]
    density = (np.full(len(rigidity), DENSITY) if model.layers is None
               else model.layers[np.clip(np.searchsorted(model.layers[:, 0], model.cells[:, 2], side="right") - 1, 0,
                                         None), 3])
    lon, lat = model.projection.inverse(model.cells[:, 0], model.cells[:, 1])
    file.write("2.0\n# written by SlipStep\n")
    parts = model.segments if model.segments and all(part.shape for part in model.segments) else []
    if parts:
        file.write(f"PLANE {len(parts)}\n")
        broken, along, down = model.on_plane(parts)
    for number, part in enumerate(parts):
        cells, (nz, nx) = model.cells[part.rows], part.shape
        top = model.corners[part.rows[:nx]][:, :2].reshape(-1, 3).mean(axis=0)
        x, y = model.projection.inverse(top[0], top[1])
        shyp, dhyp = ((along - nx * cells[0, 3] / 2) / 1e3, down / 1e3) if number == broken else (0, 0)
        file.write(f"{float(x):.6f} {float(y):.6f} {nx} {nz} {nx * cells[0, 3] / 1e3:.6f} "
                   f"{nz * cells[0, 4] / 1e3:.6f}\n{part.strike % 360:.4f} {cells[0, 6]:.4f} {top[2] / 1e3:.6f} "
                   f"{shyp:.6g} {dhyp:.6g}\n")
    turn = model.projection.convergence(*model.cells[:, :2].mean(axis=0))
    strikes = model.cells[:, 5] + turn
    for part in parts:
        strikes[part.rows] = part.strike
    for rows in [part.rows for part in parts] or [np.arange(len(model.cells))]:
        file.write(f"POINTS {len(rows)}\n")
        for k in rows:
            start, dt, rates = rates_of(model, k)
            file.write(f"{lon[k]:.6f} {lat[k]:.6f} {model.cells[k, 2] / 1e3:.6f} {strikes[k] % 360:.4f} "
                       f"{model.cells[k, 6]:.4f} {1e4 * model.area[k]:.6e} {start:.4f} {dt:.6e} "
                       f"{100 * np.sqrt(rigidity[k] / density[k]):.6e} {density[k] / 1e3:.6e}\n{model.rake[k]:.4f} "
                       f"{100 * model.slip[k]:.4f} {len(rates)} 0 0 0 0\n")
            for begin in range(0, len(rates), 6):
                file.write(" ".join(f"{100 * rate:.5e}" for rate in rates[begin:begin + 6]) + "\n")


def rates_of(model, cell):
    """Start [s], step [s] and slip rates [m/s] of a cell: their sum times the step is its slip."""
    if model.rates is not None:
        return model.rates(cell)
    start, rise, slip = model.columns["rupture_time"][0][cell], model.columns["rise_time"][0][cell], model.slip[cell]
    if rise <= 0:
        return start, model.step, []
    n = max(3, int(np.ceil(rise / model.step - 1e-6)))
    shape = 1 - np.abs(2 * np.arange(n) / (n - 1) - 1)
    return start, rise / n, slip * shape / shape.sum() / (rise / n)
