"""Which reader a file is for, by its name and what is in it."""

import os

import h5py

from . import coulomb, faults, fsp, maps, meshes, ours, param, runs, srf
from .text import FormatError, Text

# Name of --format -> (endings of names, reader)
READERS = {
    "fsp": ((".fsp",), fsp.read),
    "srf": ((".srf",), srf.read),
    "coulomb": ((".inp",), coulomb.read),
    "param": ((".param", "solucion.txt"), param.read),
    "hbi": ((".in",), faults.read_hbi),
    "interact": ((".in",), faults.read_interact),
    "quake-dfn": (("bulkfaultgeometry.txt",), faults.read_dfn),
    "pyquake3d": (("parameter.txt",), faults.read_pyquake),
    "traces": ((".geojson", ".json"), maps.read_traces),
    "depths": ((".xyz", ".grd"), maps.read_depths),
    "mesh": ((".msh", ".ts", ".stl", ".obj", ".flt"), meshes.read),
}
OF_UNIT = ("interact", "depths", "mesh")  # that --unit is for
# Ending of names -> what such files are, and what to do with them
OTHERS = {".shp": "a map of a geographic information system, expected GeoJSON: ogr2ogr -t_srs EPSG:4326 -f GeoJSON "
                  "OUT.geojson FILE", ".nc": "no slip model or grid of depths as .grd, expected one of them",
          ".vtk": "a mesh, expected HDF5: convert_mesh.py",
          ".opts": "options of fault, expected the file of -fault_output of its run"}
OTHERS.update({ending: OTHERS[".shp"] for ending in (".kml", ".kmz", ".gpkg", ".gml", ".gmt")},
              **{ending: OTHERS[".vtk"] for ending in (".vtu", ".ply", ".vtp")})


def kind_of(path):
    """The name of a format."""
    stem = path.lower().removesuffix(".gz")
    found = [name for name, (endings, _) in READERS.items() if stem.endswith(endings)]
    if not found and os.path.exists(path) and Text(path).lines[:1] and Text(path).lines[0].startswith("SwitchSS/RN"):
        return "quake-dfn"
    if "interact" in found:
        if not os.path.exists(path) or faults.is_hbi(path):
            return "hbi"
        if faults.is_interact(path):
            return "interact"
        raise FormatError(f"{path} is neither an input of HBI, which has a line problem, nor patches of interact, "
                          f"whose lines have eight numbers, expected one of them, or --format {' or '.join(READERS)}")
    if len(found) == 1:
        return found[0]
    if what := next((words for ending, words in OTHERS.items() if stem.endswith(ending)), None):
        raise FormatError(f"{path} is by its name {what}")
    raise FormatError(f"{path}: its kind is not clear from its name, expected --format {' or '.join(found or READERS)}")


def read(path, at, kind=None, rake=None, unit=None, mesh=None, **of_run):
    """The model of a file of any kind. at(lon, lat): the projection about an origin that a file suggests; unit: of
    lengths of files that do not say it; mesh: of PyQuake3D; of_run: arguments of runs.read()."""
    if not os.path.exists(path):
        raise FormatError(f"{path}: no such file, expected a slip model or patches of a fault")
    if ours.is_model(path):
        return ours.read(path)
    if h5py.is_hdf5(path):
        with h5py.File(path) as file:
            kind = kind or ("mesh" if "cells" in file or "triangles" in file else "depths" if maps.is_grid(file)
                            else None)
        if kind not in ("mesh", "depths"):
            return runs.read(path, **of_run)
    kind = kind or kind_of(path)
    more = {"unit": unit} if kind in OF_UNIT else {"mesh": mesh} if kind == "pyquake3d" else {}
    return READERS[kind][1](path, at, rake, **more)
