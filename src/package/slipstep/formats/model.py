"""What every file of another program becomes: cells with slip, in the frame x north, y east, z down [m]."""

import dataclasses

import numpy as np

from ..geometry.cells import corners_of, directions, normals
from .text import FormatError

AWRY = 0.25  # of a cell: how far points may be from a regular grid that is made of them
LEAST = 1e-6  # [m], of a length
RIGIDITY, POISSON = 30e9, 0.25  # [Pa], where nothing says it: those of fault and elastic


@dataclasses.dataclass
class Segment:
    """Cells of one plane: label, their rows, shape (nz, nx) of a grid whose rows run along strike from the upper left
    cell, or None, and the strike from true north [degrees]."""
    label: int
    rows: np.ndarray
    shape: tuple
    strike: float


@dataclasses.dataclass
class Model:
    """Cells of a file.

    cells      [N, 7]     x y z of the centre, length, width [m], strike and dip [degrees]; of triangles their extents
    triangles  [N, 3, 3]  corners, or None
    rake, slip [N]        [degrees], [m] along the rake; slip is None of faults alone
    fault      [N]        labels; names: of some of them
    columns    {name: ([N], unit)}  rupture_time, rise_time [s], moment [N m], rigidity [Pa]
    fields     {name: ([N], unit)}  parameters of -fault_parameters
    options    {name: value}        options of fault that the file says
    layers     [n, 4]     depth of the top [m], P and S velocity [m/s], density [kg/m3], or None
    claims     {name: value}        what the header says of moment, length, width, top [m], strike, dip, rake,
                                    magnitude, hypocentre (longitude, latitude, depth [m]), start (the same in the frame
                                    [m])
    rates      runs.Rates, slip rates of a run, for SRF; step: [s], of the triangles in their place
    remarks, dropped      lines for the user
    """
    path: str
    kind: str
    cells: np.ndarray
    rake: np.ndarray
    slip: np.ndarray = None
    triangles: np.ndarray = None
    fault: np.ndarray = None
    names: dict = dataclasses.field(default_factory=dict)
    columns: dict = dataclasses.field(default_factory=dict)
    fields: dict = dataclasses.field(default_factory=dict)
    options: dict = dataclasses.field(default_factory=dict)
    layers: np.ndarray = None
    claims: dict = dataclasses.field(default_factory=dict)
    segments: list = dataclasses.field(default_factory=list)
    projection: object = None
    unit: str = "m"
    rates: object = None
    step: float = 0.1
    remarks: list = dataclasses.field(default_factory=list)
    dropped: list = dataclasses.field(default_factory=list)

    def __post_init__(self):
        if self.fault is None:
            self.fault = np.zeros(len(self.cells), int)
        wrong = ~(np.isfinite(self.cells).all(axis=1) & (self.cells[:, 3:5] > LEAST).all(axis=1)
                  & (self.cells[:, 6] >= 0) & (self.cells[:, 6] <= 180))
        if wrong.any() or not len(self.cells):
            raise FormatError(f"{self.path}: " + (f"cell {int(np.flatnonzero(wrong)[0]) + 1} has the length, "
                                                  "width and dip "
                                                  + ", ".join(f"{v:g}" for v in self.cells[wrong][0, [3, 4, 6]])
                                                  if len(self.cells) else "no cells")
                              + ", expected cells with lengths above 0")

    @property
    def area(self):
        """[N] [m2]"""
        if self.triangles is None:
            return self.cells[:, 3] * self.cells[:, 4]
        return np.linalg.norm(normals(self.triangles), axis=1) / 2

    @property
    def corners(self):
        return corners_of(self.cells) if self.triangles is None else self.triangles

    @property
    def potency(self):
        """Area times slip, summed up [m3]."""
        return float(self.area @ np.abs(self.slip))

    def hypocentre(self):
        """North, east and down [m], of the file, else of the cell that breaks first, or slips most."""
        if "hypocentre" in self.claims and self.projection is not None:
            lon, lat, depth = self.claims["hypocentre"]
            return np.array([*(float(v) for v in self.projection.forward(lon, lat)), depth])
        if "start" in self.claims:
            return np.array(self.claims["start"], float)
        times = self.columns.get("rupture_time", (np.zeros(1), "s"))[0]
        moving = (np.where(self.slip != 0, -times, -np.inf) if np.ptp(times) > 0 and np.any(self.slip)
                  else np.abs(self.slip))
        return self.cells[int(np.argmax(moving)), :3]

    def on_plane(self, parts):
        """The segment of the hypocentre, and how far it is there along strike and down dip [m] from its corner."""
        found = []
        for number, part in enumerate(parts):
            cells = self.cells[part.rows]
            along, down = (v[0] for v in directions(cells[:1]))
            away = self.hypocentre() - cells[:, :3]
            # from the ends of each cell
            s, d = ((away @ way)[:, None] + cells[:, size, None] * (0.5, -0.5) for way, size in ((along, 3), (down, 4)))
            out = np.array([0.0, -s[:, 0].max(), s[:, 1].min()]).max(), np.array([
                0.0, -d[:, 0].max(), d[:, 1].min()]).max(), away[0] @ np.cross(along, down)
            found.append((float(np.linalg.norm(out)), number, float(s[:, 0].max()), float(d[:, 0].max())))
        return min(found)[1:]

    def rigidity(self):
        """[N] [Pa], and where it is from: cells, layers, moments or rock of the file, else fault and elastic."""
        if "rigidity" in self.columns:
            return self.columns["rigidity"][0], "rigidities of the file"
        if self.layers is not None:
            within = np.clip(np.searchsorted(self.layers[:, 0], self.cells[:, 2], side="right") - 1, 0, None)
            return self.layers[within, 3] * self.layers[within, 2] ** 2, "layers of the file"
        if "moment" in self.columns and "shear_modulus" not in self.options and self.potency > 0:
            return np.full(len(self.cells), self.moment()[0] / self.potency), "moments of the file's cells"
        value = self.options.get("shear_modulus", RIGIDITY)
        return np.full(len(self.cells), value), (
            f"G = {value / 1e9:g} GPa{'' if 'shear_modulus' in self.options else ', which the file does not say'}")

    def rock(self):
        """Shear modulus [Pa] by which all slip has the moment of its cells' rigidities, and Poisson's ratio."""
        weight = self.area * np.abs(self.slip) if self.slip is not None and self.potency > 0 else self.area
        return float(np.average(self.rigidity()[0], weights=weight)), self.options.get("poisson_ratio", POISSON)

    def moment(self):
        """Scalar moment [N m] and where its rigidity is from: moments of cells, else rigidity times potency."""
        if "moment" in self.columns:
            return float(self.columns["moment"][0].sum()), "moments of the file's cells"
        rigidity, words = self.rigidity()
        return float((rigidity * self.area) @ np.abs(self.slip)), words


def grid_of(points, strike, dip, dx, dz):
    """Points [n, 3] of cells in a grid of one plane: their columns, rows and (nz, nx); None where they are in no grid.

    Points of a full grid are told apart by their distances along strike and down dip, whatever the order and scale of
    the file.
    """
    along, down = (v[0] for v in directions(np.array([[0, 0, 0, 0, 0, strike, dip]], float)))
    s, d = points @ along, points @ down
    shape = []
    for values, size in ((d, dz), (s, dx)):
        shape.append(int(round(np.ptp(values) / size)) + 1)
    nz, nx = shape
    if nz * nx != len(points):  # scales that differ between the header and the points
        nz = next((n for n in (nz, nz - 1, nz + 1) if n > 0 and len(points) % n == 0), 0)
        nx = len(points) // nz if nz else 0
        if nz * nx != len(points):
            return None
    number = []
    for values, n in ((s, nx), (d, nz)):
        number.append(np.rint((values - values.min()) / np.ptp(values) * (n - 1)).astype(int) if n > 1
                      else np.zeros(len(points), int))
    column, row = number
    return (column, row, (nz, nx)) if len(np.unique(row * nx + column)) == len(points) else None


def tiled(points, strike, dip, dx, dz, place="centre"):
    """Cells [n, 7] of points [n, 3] that are in a grid of one plane, without gaps and overlaps; also (nz, nx), the
    order of its cells by rows from the upper left, and how far points were away [m]. Where they are in none: cells at
    the points, None, their own order and 0. place: what of a cell its point is, centre or top.

    Strikes of headers are often rounded to degrees. Where points are off by more than a tenth of a cell, and run along
    another strike within a degree, that is taken.
    """
    found, taken, allowed = grid_of(points, strike, dip, dx,
                                    dz), strike, AWRY * max(min(dx, dz), 0.02 * np.ptp(points[:, :2], axis=0).max())
    order = np.arange(len(points))

    def fitted(strike):
        """Centres of a grid, those of the points, and how far these are from it."""
        along, down = (v[0] for v in directions(np.array([[0, 0, 0, 0, 0, strike, dip]], float)))
        centres = points + (dz / 2 * down if place == "top" else 0.0)
        if not found:
            return centres, centres, 0.0
        column, row, (nz, nx) = found
        regular = (((column - (nx - 1) / 2) * dx)[:, None] * along + ((row - (nz - 1) / 2) * dz)[:, None] * down
                   + centres.mean(axis=0))
        return regular, centres, float(np.linalg.norm(regular - centres, axis=1).max())

    regular, centres, off = fitted(strike)
    if found and off > 0.1 * min(dx, dz) and found[2][1] > 2:
        north, east = (found[0] - found[0].mean()) @ points[:, :2]
        other = float(np.degrees(np.arctan2(east, north)))  # the strike along which columns run
        if abs((other - strike + 180) % 360 - 180) <= 1.0 and fitted(other)[2] < off:
            taken = other % 360
            regular, centres, off = fitted(taken)
    shape = found[2] if found and off <= allowed else None
    if shape:
        centres, order = regular, np.argsort(found[1] * shape[1] + found[0], kind="stable")
    turned = (np.full(len(points), value) for value in (dx, dz, taken if shape else strike, dip))
    return np.column_stack([centres, *turned]), shape, order, off if shape else 0.0
