"""HDF5 files of SlipStep: opened for reading, also while they grow; attributes, columns and components; new files that
are whole or not there."""

import contextlib
import csv
import os
import time

import h5py
import numpy as np

from ..errors import OutputError

# to open a file that grows: HDF5 takes its length first and its superblock then, between which a run may have written
# it twice
ATTEMPTS = 5
# of a field of two: what follows its name, and words for it
COMPONENTS = {"_along_strike": "along strike", "_up_dip": "up dip"}
CATALOGUE = "slipstep-catalogue"  # the attribute format of a catalogue


def open_file(path, writer):
    """The HDF5 file, for reading; writer: the words that say which program would write it."""
    path = os.fspath(path)
    if not os.path.exists(path):
        part = (f"; {path}.part is there, of a run that has not ended: read that one" if os.path.exists(f"{path}.part")
                else "")
        raise OutputError(f"{path}: no such file{part or '; ' + writer}")
    for attempt in reversed(range(ATTEMPTS if path.endswith(".part") else 1)):
        try:
            return h5py.File(path, "r")
        except OSError as error:
            if not attempt:
                raise OutputError(f"{path}: not a complete HDF5 file ({error})") from error
        time.sleep(0.05)


def open_any(path):
    """The file of a run or of a catalogue, for reading."""
    return open_file(path, "a run writes it with -fault_output, or -fault_catalogue")


def plain(value):
    """A Python or numpy value of an attribute; HDF5 strings arrive as bytes."""
    if isinstance(value, bytes):
        return value.decode()
    if isinstance(value, np.ndarray) and value.size == 1:
        return plain(value.reshape(-1)[0])
    return value.item() if isinstance(value, np.generic) else value


def names_of(data):
    """Names of faults by their labels, of a dataset of labels with "1 North; 2 South", or of None."""
    text = plain(data.attrs.get("names", "")) if data is not None else ""
    return {int(word.split(" ", 1)[0]): word.split(" ", 1)[1] for word in text.split("; ") if " " in word
            and word.split(" ", 1)[0].lstrip("-").isdigit()}


def attributes(item):
    """Those of a file, group or dataset as a dict; of a group that is not there none."""
    return {} if item is None else {name: plain(value) for name, value in item.attrs.items()}


def is_catalogue(file):
    return plain(file.attrs.get("format", "")) == CATALOGUE


def is_complete(file):
    """Whether its run has ended; files of before 0.3 do not say so."""
    return bool(file.attrs.get("complete", 1))


def datasets(group):
    """Those of a group by name, without the dimensions of netCDF that are no variables."""
    return {name: item for name, item in group.items() if isinstance(item, h5py.Dataset)
            and not ("CLASS" in item.attrs and plain(item.attrs["NAME"]).startswith("This is a netCDF dimension"))}


def columns(group, grows=False, rows="time"):
    """(arrays, units) by name of the datasets of a group. Of a file that grows those with a row for each of the dataset
    rows have as many as all of them have, as some may have more; axes, and all of a group without that dataset, are
    whole."""
    found = datasets(group)
    cut = [name for name, item in found.items() if grows and rows in found
           and (name == rows or "CLASS" not in item.attrs)]
    least = min((len(found[name]) for name in cut), default=0)
    return ({name: item[:least] if name in cut else item[()] for name, item in found.items()},
            {name: plain(item.attrs.get("units", "")) for name, item in found.items()})


def split(name):
    """A field's dataset and the component that its name asks for: ("slip", 1) of "slip_up_dip"; None: the magnitude."""
    for number, part in enumerate(COMPONENTS):
        if name.endswith(part):
            return name.removesuffix(part), number
    return name, None


def drawn(vectors, part=None):
    """One component of vectors [..., 2], or their magnitude."""
    return np.hypot(vectors[..., 0], vectors[..., 1]) if part is None else vectors[..., part]


@contextlib.contextmanager
def replacing(target, source=None):
    """with replacing("out.csv") as part: write to the file part, which takes the target's name at the end. After an
    error it is removed, and an older target stays as it was. The source, which is read, is no target."""
    if source and os.path.exists(target) and os.path.samefile(source, target):
        raise OutputError(f"{target} is the file itself that is read, expected another name")
    part = target + ".part"
    try:
        yield part
        os.replace(part, target)
    except BaseException:
        if os.path.exists(part):
            os.remove(part)
        raise


def write_csv(path, rows, source=None):
    """Rows of Python's numbers, to their last bit, and texts, the first of them the names; see replacing()."""
    with replacing(path, source) as part, open(part, "w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)


def put(file, name, values, unit):
    file[name] = values
    file[name].attrs["units"] = unit


def write_fields(path, fields):
    """A file for -fault_parameters, or another with arrays and their units, of {name: (array, unit)}."""
    with replacing(path) as part, h5py.File(part, "w") as file:
        for name, (values, unit) in fields.items():
            put(file, name, values, unit)
