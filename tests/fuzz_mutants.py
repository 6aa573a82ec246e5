"""Mutants of files: of their bytes, and of the objects of HDF5. The random numbers that are handed over decide alone
what a mutant is."""
import os
import shutil
import struct

import h5py
import numpy as np

NUMBERS = [0, 1, 0xFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 1 << 32, 1 << 62, (1 << 63) - 1, 1 << 63, (1 << 64) - 1]
VALUES = [np.nan, np.inf, -np.inf, 0.0, -0.0, -1.0, 1e308, -1e308, 5e-324, 1e30, 1e-30, 2.0 ** 53]
SIZES = [0, 1, 2, 3, 7, 100, 10 ** 4, 10 ** 9, 2 ** 31 - 1, 2 ** 31, 2 ** 32 + 6, 2 ** 40, 2 ** 62]


def mutate_bytes(rng, content):
    """Flipped bits, numbers written over others, and pieces cut out, zeroed, doubled or moved."""
    content = bytearray(content)
    used = [k for k, byte in enumerate(content) if byte]  # most of a small HDF5 file is empty

    def place():
        return rng.choice(used) if used and rng.random() < 0.8 else rng.randrange(len(content))

    for _ in range(rng.choice([1, 1, 1, 2, 4, 16])):
        k, how = min(place(), len(content) - 1), rng.randrange(10)
        length = rng.choice([1, 2, 4, 8, 64, 512])
        if how < 4:
            content[k] ^= 1 << rng.randrange(8)
        elif how < 6:
            number = struct.pack("<Q", rng.choice(NUMBERS))[: rng.choice([1, 2, 4, 8])]
            content[k:k + len(number)] = number[: len(content) - k]
        elif how == 6:
            content[k] = rng.randrange(256)
        elif how == 7:
            content[k:k + length] = bytes(min(length, len(content) - k))
        elif how == 8:
            piece = content[place():][:length]
            content[k:k + len(piece)] = piece[: len(content) - k]
        elif rng.random() < 0.5:
            del content[max(k, 1):]
        elif rng.random() < 0.5:
            del content[k:k + length]
        else:
            content[k:k] = content[k:k + length]
        used = [p for p in used if p < len(content)] if len(content) < len(used) else used
        if not content:
            break
    return bytes(content)


def mutate_words(rng, content):
    """Words of a text that became others of it, or numbers that are too large, or none; lines that are gone or
    twice."""
    lines = [line.split(b" ") for line in content.split(b"\n")]
    for _ in range(rng.choice([1, 1, 1, 2, 4])):
        k, how = rng.randrange(len(lines)), rng.randrange(6)
        line = lines[k]
        if how < 3:
            number = rng.choice([*VALUES, *SIZES, *NUMBERS, -1, -7, 1, 2, 3])
            line[rng.randrange(len(line))] = str(number).encode()
        elif how == 3:
            line[rng.randrange(len(line))] = rng.choice(rng.choice(lines))
        elif how == 4:
            lines.insert(rng.randrange(len(lines)), list(line))
        elif len(lines) > 1:
            del lines[k]
    return b"\n".join(b" ".join(line) for line in lines)


def objects(file):
    """Paths of all groups and datasets but the root."""
    found = []
    file.visit(found.append)
    return sorted(found)


def other_type(rng, data):
    """An array of the same shape and another type."""
    kind = rng.choice(["<f4", "<f2", "<i1", ">f8", "<u8", "?", "S5", "vlen", "compound", "<c16", "opaque", "ragged",
                       "array"])
    if kind == "vlen":
        return np.full(data.shape, "text", dtype=h5py.string_dtype())
    if kind == "ragged":
        ragged = np.empty(data.shape, dtype=h5py.vlen_dtype("f8"))
        for k in np.ndindex(data.shape):
            ragged[k] = np.ones(3)
        return ragged
    if kind == "compound":
        return np.zeros(data.shape, dtype=[("a", "f8"), ("b", "i4")])
    if kind == "opaque":
        return np.zeros(data.shape, dtype="V16").astype(h5py.opaque_dtype("V16"))
    if kind == "array":
        return np.zeros(data.shape, dtype=[("a", "f8", (3,))])
    with np.errstate(all="ignore"):
        return data.astype(kind) if data.dtype.kind in "fiu" or kind == "S5" else np.zeros(data.shape, kind)


def mutate_attribute(rng, file, owner):
    attributes = file[owner].attrs
    if not len(attributes) or rng.random() < 0.1:
        attributes[rng.choice(["format", "version", "extra", "checksum", "columns", "x" * 300])] = 1.5
        return
    name = rng.choice(sorted(attributes))
    old = attributes[name]
    how = rng.randrange(9)
    del attributes[name]
    if how == 0:
        return
    text = old.decode(errors="replace") if isinstance(old, bytes) else str(old)
    attributes[name] = [None, rng.choice(VALUES), np.ones((2, 3)), h5py.Empty("f8"),
                        text + "x" * rng.choice([1, 70, 5000, 60000]), text[:-1] + "\n\x1b", h5py.Empty("S4"),
                        np.array([text.encode()[:9], b"other"]), rng.choice([0, -1, 2, 2 ** 31, 2 ** 62])][how]


def mutate_object(rng, file):
    """One object or attribute of an open file is another, or gone."""
    paths = objects(file)
    path = rng.choice(paths)
    how = rng.randrange(10)
    if how < 3:
        mutate_attribute(rng, file, rng.choice(["/", *paths]))
        return
    is_data = isinstance(file[path], h5py.Dataset)
    data = None
    if is_data:
        if (file[path].size or 0) > 10 ** 5:
            raise ValueError("an earlier mutation has made it gigabytes")
        data = file[path][()]
    attributes = dict(file[path].attrs)
    if how == 3 or not is_data:
        if rng.random() < 0.5:
            del file[path]
            file[path] = rng.choice([h5py.SoftLink("/" + path), h5py.SoftLink("/nothing"),
                                     h5py.ExternalLink("none.h5", "/x"), file["/"], 1.0, "text", np.ones((1,) * 7)])
        elif rng.random() < 0.5:
            del file[path]
        else:
            file[path + "x" if not is_data else os.path.dirname(path) + "/" + str(rng.randrange(4)) + "y"] = np.ones(3)
        return
    data = np.asarray(data)
    if how in (4, 5):
        if data.dtype.kind == "f" and data.size:
            for _ in range(rng.choice([1, 2, data.size])):
                data[tuple(rng.randrange(n) for n in data.shape)] = rng.choice(VALUES)
            file[path][...] = data
            return
        data = np.array([rng.choice([b"", b"x" * 4000, b"energy", b"\xff\xfe", b"a\nb"])] * max(data.size, 1),
                        dtype=h5py.string_dtype())
    elif how == 6:
        data = other_type(rng, data)
    elif how == 7:
        data = rng.choice([data.ravel(), data.reshape((1,) * rng.randrange(7) + data.shape),
                           data[:-1] if data.ndim else data, data.reshape(data.shape + (1,)),
                           data.ravel()[:1].reshape(()) if data.size else data, data.T])
    else:
        shape = list(data.shape) or [1]
        shape[rng.randrange(len(shape))] = rng.choice(SIZES)
        if rng.random() < 0.2:
            shape = [rng.choice(SIZES) for _ in range(rng.randrange(1, 4))]
        del file[path]
        dtype = h5py.string_dtype() if data.dtype.kind == "O" else data.dtype
        file.create_dataset(path, shape, dtype, chunks=tuple(min(max(n, 1), 4) for n in shape),
                            maxshape=(None,) * len(shape), compression=rng.choice([None, "gzip"])
                            if dtype != h5py.string_dtype() else None)
        file[path].attrs.update({name: value for name, value in attributes.items()
                                 if not isinstance(value, h5py.Empty)})
        return
    del file[path]
    file[path] = data
    for name, value in attributes.items():
        file[path].attrs[name] = value


def mutate_hdf5(rng, seed, path):
    """A mutant of the HDF5 file `seed` as `path`."""
    shutil.copyfile(seed, path)
    if rng.random() < 0.45:
        try:
            with h5py.File(path, "r+") as file:
                for _ in range(rng.choice([1, 1, 2])):
                    mutate_object(rng, file)
            return
        except Exception:  # h5py cannot write every mutant; its bytes are mutated then
            shutil.copyfile(seed, path)
    with open(seed, "rb") as file:
        content = file.read()
    with open(path, "wb") as file:
        file.write(mutate_bytes(rng, content))
