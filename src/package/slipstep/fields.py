"""Parameters of a fault as functions of its cells, for Fault.set() and files of -fault_parameters.

    fault.set("friction_a", lambda c: 0.01 + 1e-6 * c.z)                  # any function of Cells
    fault.set("normal_stress", fields.points("stress.csv"))               # scattered points, linear or nearest
    fault.set("friction_drop", fields.random(0.1, scatter=0.2, correlation=2000, seed=3))
    fields.write("parameters.h5", {"friction_a": lambda c: ...}, fault.cells())

Functions take Cells and return a number for each cell, in the shape of c.x, or one number. They run on every process,
and must give the same there.
"""

import os
from dataclasses import dataclass

import numpy as np

from .checks import check_fields
from .errors import Error, warn
from .modules import csv_rows

NAMES = ("x", "y", "z", "area", "strike", "dip", "fault")
WAVES = 500  # of a random field
SHORTEST = 1 / 8  # wave over the correlation length: no mesh shows shorter ones
FLAT = 1e-6  # extent of points in a direction over their largest, below which they are in a plane or on a line


@dataclass(frozen=True)
class Cells:
    """The cells of a fault, arrays in the shape of its fields: [nz, nx] of a grid, [1, n] of a mesh.

    x, y, z      centres [m]: north, or along strike of a vertical grid; east, or to its right; down
    area         [m^2]
    strike, dip  [degrees], as Aki and Richards define them
    fault        label of the fault, an integer
    mesh         whether they are of a mesh
    """

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    area: np.ndarray
    strike: np.ndarray
    dip: np.ndarray
    fault: np.ndarray
    mesh: bool = False

    @property
    def shape(self):
        return self.x.shape

    @property
    def centres(self):
        """[cells, 3], x, y and z [m]."""
        return np.column_stack([part.ravel() for part in (self.x, self.y, self.z)])


def read_cells(path):
    """The Cells of a file of -fault_cells."""
    import h5py
    with h5py.File(path) as file:
        mesh = file["x"].ndim == 1
        parts = [np.atleast_2d(file[name][...]) for name in NAMES]
    return Cells(*parts[:-1], parts[-1].astype(int), mesh)


def evaluate(name, function, cells):
    """function(cells) as an array of doubles in the shape of the cells. Error: another shape, or what is no finite
    number."""
    try:
        values = np.asarray(function(cells), dtype=float)
    except (TypeError, ValueError) as error:
        raise Error(f"the function of {name}: {error}") from error
    if values.size == cells.x.size and values.ndim:
        values = values.reshape(cells.shape)
    elif values.ndim:
        raise Error(f"the function of {name} returned the shape {values.shape}, expected {cells.shape}, that of the "
                    "cells, or one number")
    values = np.array(np.broadcast_to(values, cells.shape))
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        k = bad[0]
        raise Error(f"the function of {name} returned {values.flat[k]} in {bad.size} of {values.size} cells, the first "
                    "at x, y, z = "
                    f"{cells.x.flat[k]:.6g}, {cells.y.flat[k]:.6g}, {cells.z.flat[k]:.6g} m: expected finite numbers")
    return values


def _read_points(path, column):
    """Names of the coordinates, [points, coordinates] and [points] of a CSV file."""
    rows = csv_rows(path)
    if not rows:
        raise Error(f"{path} is empty, expected a line of names and a line for each point")
    head = rows[0][1]
    place = [name for name in ("x", "y", "z") if name in head]
    others = [name for name in head if name not in place]
    if not place or not others or len(set(head)) < len(head):
        raise Error(f"{path}: the first line is {','.join(head)}, expected different names, with x, y or z among them "
                    "[m] and at least one more")
    if column is None and len(others) > 1:
        raise Error(f"{path} has {', '.join(others)}: expected column= one of them")
    if column is not None and column not in others:
        raise Error(f"{path} has no column {column}, expected one of {', '.join(others)}")
    wanted = [head.index(name) for name in (*place, column or others[0])]
    numbers = []
    for number, row in rows[1:]:
        try:
            numbers.append([float(row[k]) for k in wanted])
            if len(row) != len(head) or not np.isfinite(numbers[-1]).all():
                raise ValueError
        except (ValueError, IndexError):
            raise Error(f"{path}, line {number}: expected {len(head)} finite numbers for {','.join(head)}") from None
    if not numbers:
        raise Error(f"{path} has no points, expected a line for each")
    numbers = np.array(numbers)
    return place, numbers[:, :-1], numbers[:, -1]


def _reduced(places, at):
    """Both in as many directions as the points have: those of a plane in two, of a line in one."""
    middle = places.mean(axis=0)
    _, size, directions = np.linalg.svd(places - middle, full_matrices=False)
    keep = directions[size > FLAT * size[0]] if size[0] > 0 else directions[:0]
    return (places - middle) @ keep.T, (at - middle) @ keep.T


def points(path, column=None, method="linear"):
    """A function of cells by the scattered points of a CSV file.

    path    a line of names, then a line a point: x, y, z [m], those of them that matter, and one or more columns of
            values in SI units
    column  of the values, where there are several
    method  "linear", by triangles or tetrahedra between the points, and the nearest point's value beyond them; or
            "nearest"

    With one coordinate, as z, that is a profile. With more it needs SciPy (python3-scipy). Points of one plane make
    triangles in that plane, onto which cells are projected. Error: what the file does not hold, points in the same
    place. A SlipStepWarning: no cell lies within the extent of the points."""
    if method not in ("linear", "nearest"):
        raise ValueError(f"method is {method!r}, expected 'linear' or 'nearest'")
    place, places, values = _read_points(path, column)
    if len(np.unique(places, axis=0)) < len(places):
        raise Error(f"{path} has {len(places) - len(np.unique(places, axis=0))} points in places of others, expected "
                    "one value a place")

    def function(cells):
        at = np.column_stack([getattr(cells, name).ravel() for name in place])
        known, wanted = _reduced(places, at)
        slack = FLAT * np.ptp(known, axis=0)
        if known.shape[1] and not ((wanted >= known.min(axis=0) - slack)
                                   & (wanted <= known.max(axis=0) + slack)).all(axis=1).any():
            spans = (", ".join(f"{name} = {column.min():.6g} to {column.max():.6g}"
                               for name, column in zip(place, part.T)) + " m" for part in (places, at))
            warn("{}: no cell lies among its points, which are at {}, and cells at {}: each takes the value of the "
                 "nearest point. Expected places in m, in the frame of the cells".format(path, *spans))
        if known.shape[1] == 0:
            return values[0]
        if known.shape[1] == 1:
            order = np.argsort(known[:, 0])
            line, heights = known[order, 0], values[order]
            if method == "linear":
                return np.interp(wanted[:, 0], line, heights)
            return heights[np.searchsorted((line[1:] + line[:-1]) / 2, wanted[:, 0])]
        try:
            from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator
        except ImportError:
            raise Error(f"{path} has points in {known.shape[1]} directions, which needs SciPy; Debian's package is "
                        "python3-scipy") from None
        found = NearestNDInterpolator(known, values)(wanted)
        if method == "linear":
            inside = LinearNDInterpolator(known, values)(wanted)
            found = np.where(np.isnan(inside), found, inside)
        return found

    return function


def waves(places, correlation, random, hurst=0.75):
    """A random field of mean 0 and variance 1 over all seeds, with von Karman's spectrum, (1 + (k a)^2)^-(hurst + d/2)
    in d dimensions.

    places       d arrays of coordinates [m] of one shape, which the field has as well
    correlation  a [m], or d of them
    random       a numpy Generator

    It is a sum of waves whose wavenumbers are drawn from the spectrum, by which k a has Student's law of 2 hurst
    degrees of freedom, so that it does not depend on the cells. Those shorter than an eighth of a are drawn again: no
    mesh shows them."""
    d = len(places)
    k = np.full((WAVES, d), np.inf)
    while (short := np.linalg.norm(k, axis=1) > 2 * np.pi / SHORTEST).any():
        k[short] = random.standard_normal((short.sum(), d)) / np.sqrt(random.chisquare(2 * hurst, (short.sum(), 1)))
    phase = random.uniform(0, 2 * np.pi, WAVES)
    field = np.zeros_like(places[0])
    for wave, shift in zip(k / correlation, phase):
        at = wave[0] * places[0]
        for number, coordinate in zip(wave[1:], places[1:]):
            at = at + number * coordinate
        field += np.cos(at + shift)
    return field * np.sqrt(2 / WAVES)


def random(mean, scatter, correlation, seed, hurst=0.75, least=0.1):
    """A function of cells that varies at random around a mean, by waves() in space: cells of all faults are part of one
    field.

    mean         a number, or a function of cells
    scatter      standard deviation over the mean
    correlation  length [m], or three along x, y and z
    seed         an integer; the same seed gives the same field on any mesh
    least        share of the mean that no cell falls below
    """
    if not scatter >= 0 or not np.all(np.asarray(correlation) > 0) or not hurst > 0:
        raise ValueError(f"scatter is {scatter}, correlation {correlation}, hurst {hurst}: expected scatter zero or "
                         "positive, the others positive")

    def function(cells):
        middle = mean(cells) if callable(mean) else mean
        return middle * np.maximum(1 + scatter * waves((cells.x, cells.y, cells.z), correlation,
                                                       np.random.default_rng(seed), hurst), least)

    return function


def write(path, fields, cells):
    """A file for -fault_parameters with fields by their names, in SI units, each a function of cells, an array in their
    shape, or a number; whole or not at all. Error: values that the program fault refuses, as one of another shape."""
    import h5py
    made = {name: evaluate(name, value if callable(value) else lambda _, value=value: value, cells)
            for name, value in fields.items()}
    check_fields(path, made)
    part = f"{path}.part"
    try:
        with h5py.File(part, "w") as file:
            for name, values in made.items():
                file[name] = values.ravel() if cells.mesh else values
        os.replace(part, path)
    except OSError as error:
        raise Error(f"cannot write {path}: {error.strerror or error}") from None
    finally:
        if os.path.exists(part):
            os.remove(part)
