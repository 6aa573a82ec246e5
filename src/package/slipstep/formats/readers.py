"""Which reader a file is for, by its name and what is in it."""

import os

import h5py

from . import coulomb, faults, fsp, ours, param, runs, srf
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
}


def kind_of(path):
    """The name of a format."""
    stem = path.lower().removesuffix(".gz")
    found = [name for name, (endings, _) in READERS.items() if stem.endswith(endings)]
    if not found and os.path.exists(path) and Text(path).lines[:1] and Text(path).lines[0].startswith("SwitchSS/RN"):
        return "quake-dfn"
    if "interact" in found:
        return "interact" if os.path.exists(path) and faults.is_interact(path) else "hbi"
    if len(found) == 1:
        return found[0]
    raise FormatError(f"{path}: its kind is not clear from its name, expected --format {' or '.join(found or READERS)}")


def read(path, at, kind=None, rake=None, unit=None, mesh=None, **of_run):
    """The model of a file of any kind. at(lon, lat): the projection about an origin that a file suggests; unit: of lengths of interact; mesh: of PyQuake3D; of_run: arguments of
    runs.read()."""
    if not os.path.exists(path):
        raise FormatError(f"{path}: no such file, expected a slip model or patches of a fault")
    if ours.is_model(path):
        return ours.read(path)
    if h5py.is_hdf5(path):
        return runs.read(path, **of_run)
    kind = kind or kind_of(path)
    more = {"interact": {"unit": unit}, "pyquake3d": {"mesh": mesh}}.get(kind, {})
    return READERS[kind][1](path, at, rake, **more)
