"""Meshes for -fault_mesh and of other programs as cells without slip: HDF5 of rectangles or triangles, Gmsh, GOCAD,
STL, OBJ, RSQSim."""

import contextlib

import h5py
import numpy as np

from ..results.files import plain
from .model import Model
from .ours import cells_of_triangles
from .surfaces import UNITS, read as read_surfaces
from .text import FormatError, unused

DEEPEST = 800.0  # [km]: larger depths are m, as fault takes them


def triangles_of(path, found, unit):
    """Cells [N, 7] and corners [N, 3, 3], north, east and down [m], of a file's surfaces in a unit [m]."""
    corners = found.corners if found.frame == "ned" else found.corners[..., [1, 0, 2]] * (1, 1, -1)
    try:
        return cells_of_triangles(corners * unit)
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from None


def unit_of(path, said, given, depth):
    """Of lengths [m], and its name: the file's, --unit's, or metres where kilometres would be too deep."""
    if said and given not in (None, said):
        raise FormatError(f"{path} says that its lengths are in {said}, expected no --unit {given}")
    unit = said or given or ("m" if depth > DEEPEST else None)
    if unit is None:
        raise FormatError(f"{path} does not say the unit of its lengths, expected --unit m or km")
    return UNITS[unit], unit


def of_rectangles(path, file, unit):
    """The model of /cells of an HDF5 file."""
    rows = file["cells"][()].astype(float)
    if rows.ndim != 2 or rows.shape[1] not in (5, 7):
        raise FormatError(f"{path}: /cells has the shape {rows.shape}, expected 5 or 7 columns, x y z length width and "
                          "perhaps strike dip")
    said = file["cells"].attrs.get("units")
    size, unit = unit_of(path, said and plain(said), unit, np.abs(rows[:, 2]).max())
    cells = rows if rows.shape[1] == 7 else np.column_stack([rows, np.zeros(len(rows)), np.full(len(rows), 90.0)])
    cells[:, :5] *= size
    return Model(path, "mesh of rectangles", cells, np.zeros(len(cells)), fault=file["fault"][()].astype(int)
                 if "fault" in file else np.ones(len(cells), int), unit=unit)


def of_surfaces(path, unit):
    """The model of triangles, with fields of RSQSim."""
    found = read_surfaces(path)
    size, unit = (1.0, found.unit) if found.unit else unit_of(path, None, unit, np.abs(found.corners[..., 2]).max())
    cells, corners = triangles_of(path, found, size)
    names = {k: name for k, name in found.names.items() if name}
    model = Model(path, "mesh of triangles", cells, np.zeros(len(cells)), None, corners, found.fault, names, unit=unit,
                  remarks=found.remarks)
    model.fields = {name: (np.array(values, float), unit) for name, (values, unit) in found.fields.items()}
    return model


def read(path, at, rake=None, unit=None):
    """The model of a mesh. Lengths are in its unit, or unit, m or km; rakes are its own, else rake, else 0."""
    with h5py.File(path) if h5py.is_hdf5(path) else contextlib.nullcontext({}) as file:
        model = of_rectangles(path, file, unit) if "cells" in file else of_surfaces(path, unit)
        rakes = file["rake"][()].ravel() if "rake" in file else model.fields.pop("rake", (None,))[0]
        model.dropped += unused(file, ("cells", "vertices", "triangles", "hanging_wall", "fault", "rake"), "dataset")
    if rakes is None and rake is None:
        model.remarks.append("its cells have no rake; it is 0, or --rake")
    model.rake = np.array(np.broadcast_to(rakes if rakes is not None else 0.0 if rake is None else rake,
                                          len(model.cells)), float)
    return model
