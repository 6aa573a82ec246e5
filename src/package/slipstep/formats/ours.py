"""Slip models as HDF5 files of this project, which -fault_mesh, -fault_parameters and `elastic` read: /cells or
/vertices and /triangles, /fault, /rake and other parameters, /slip, /points; and in /model and the file's attributes
what else the other program's file has said."""

import json

import h5py
import numpy as np

from ..geometry.cells import normals
from ..results.files import names_of, plain, put, replacing
from .model import LEAST, Model, Segment
from .projection import Projection
from .text import FormatError

FORMAT = "slipstep-slip"  # the attribute format of such a file
# what is no other parameter of a fault
OTHERS = ("cells", "vertices", "triangles", "hanging_wall", "fault", "rake", "slip", "points", "model")


def write(model, path, points=None):
    """A file for -fault_mesh, and with slip for `elastic`; points [n, 3] [m], by default the centres of cells."""
    with replacing(path, model.path) as part, h5py.File(part, "w") as file:
        file.attrs["format"], file.attrs["version"], file.attrs["source"], file.attrs[
            "kind"] = FORMAT, 1, model.path, model.kind
        if model.triangles is None:
            put(file, "cells", model.cells, "m")
        else:
            corners, number = np.unique(model.triangles.reshape(-1, 3), axis=0, return_inverse=True)
            put(file, "vertices", corners, "m")
            file["triangles"] = number.reshape(-1, 3)
        file["fault"] = model.fault
        if model.names:
            file["fault"].attrs["names"] = "; ".join(f"{label} {name}" for label, name in sorted(model.names.items()))
        # as fault takes them
        put(file, "rake", np.where(np.abs(model.rake) < 360, model.rake, (model.rake + 180) % 360 - 180), "degrees")
        if model.slip is not None and model.triangles is not None:
            file["hanging_wall"] = normals(model.triangles)
        if model.slip is not None:
            turn = np.radians(model.rake)
            put(file, "slip", np.column_stack([model.slip * np.cos(turn), model.slip * np.sin(turn), 0 * turn]), "m")
            put(file, "points", model.cells[:, :3] if points is None else points, "m")
            file.attrs["shear_modulus"], file.attrs["poisson_ratio"] = model.rock()
        for name, (values, unit) in model.fields.items():
            put(file, name, values, unit)
        for name, (values, unit) in model.columns.items():
            put(file, f"model/{name}", values, unit)
        if model.layers is not None:
            file["model/layers"] = model.layers
            file["model/layers"].attrs["columns"] = "depth [m], P velocity [m/s], S velocity [m/s], density [kg/m3]"
        file.attrs["claims"], file.attrs["options"] = json.dumps(model.claims), json.dumps(model.options)
        file.attrs["segments"] = json.dumps([(int(s.label), len(s.rows), s.shape, s.strike) for s in model.segments])
        if model.projection:
            file.attrs["origin"], file.attrs["projection"] = model.projection.origin, model.projection.kind


def is_model(path):
    """Whether a file is one that write() made."""
    if not h5py.is_hdf5(path):
        return False
    with h5py.File(path) as file:
        return plain(file.attrs.get("format", "")) == FORMAT


def read(path):
    """The model of a file that write() made."""
    with h5py.File(path) as file:
        try:
            cells, triangles = ((file["cells"][()], None) if "cells" in file
                                else cells_of_triangles(file["vertices"][()][file["triangles"][()]]))
            rake = file["rake"][()]
            slip = file["slip"][()] if "slip" in file else None
            model = Model(path, plain(file.attrs["kind"]), cells, rake, None, triangles, file["fault"][()])
            if slip is not None:
                model.slip = slip[:, 0] * np.cos(np.radians(rake)) + slip[:, 1] * np.sin(np.radians(rake))
            model.names = names_of(file["fault"])
            model.columns = {name: (data[()], plain(data.attrs["units"]))
                             for name, data in file.get("model", {}).items() if name != "layers"}
            model.fields = {name: (data[()], plain(data.attrs["units"])) for name, data in file.items()
                            if name not in OTHERS and "units" in data.attrs}
            model.layers = file["model/layers"][()] if "model/layers" in file else None
            model.claims, model.options = json.loads(plain(file.attrs["claims"])), json.loads(
                plain(file.attrs["options"]))
            first = 0
            for label, count, shape, strike in json.loads(plain(file.attrs["segments"])):
                model.segments.append(Segment(label, first + np.arange(count), tuple(shape) if shape else None, strike))
                first += count
            if "origin" in file.attrs:
                model.projection = Projection(tuple(file.attrs["origin"]), plain(file.attrs["projection"]))
        except KeyError as error:
            raise FormatError(f"{path}: {error.args[0]}, expected a file that slipstep convert wrote") from None
    return model


def cells_of_triangles(triangles):
    """Centroids, extents along strike, widths, strikes and dips [N, 7] of triangles, and these with normals upward."""
    normal = normals(triangles)
    # to the right of a strike in [0, 180) degrees
    upright = np.abs(normal[:, 2]) <= 1e-9 * np.linalg.norm(normal, axis=1)
    down = np.where(upright, np.degrees(np.arctan2(-normal[:, 0], normal[:, 1])) % 360 >= 180, normal[:, 2] > 0)
    triangles = np.where(down[:, None, None], triangles[:, ::-1], triangles)
    normal = np.where(down[:, None], -normal, normal)
    size = np.linalg.norm(normal, axis=1)
    if not (size > LEAST ** 2).all():
        raise FormatError(f"triangle {int(np.argmin(size > LEAST ** 2)) + 1} has no area, expected one")
    strike = np.arctan2(-normal[:, 0], normal[:, 1])
    dip = np.degrees(np.arccos(np.clip(-normal[:, 2] / size, -1, 1)))
    along = np.stack([np.cos(strike), np.sin(strike), 0 * strike], axis=1)
    length = np.ptp(np.einsum("nij,nj->ni", triangles, along), axis=1)
    return np.column_stack([triangles.mean(axis=1), length, size / 2 / length, np.degrees(strike) % 360,
                            dip]), triangles
