"""Small policies as stable-baselines3 saves them, a zip within a zip, and mutants of them, for
training/study/import_sb3.py."""
import os
import struct
import zipfile

import numpy as np

from fuzz_mutants import mutate_bytes


def pickled_state(arrays):
    def text(s):
        return b"X" + struct.pack("<I", len(s)) + s.encode()

    def numbers(values):
        return b"(" + b"".join(b"J" + struct.pack("<i", v) for v in values) + b"t"

    items = b""
    for key, (name, array) in enumerate(arrays.items()):
        storage = (b"(" + text("storage") + b"ctorch\nFloatStorage\n" + text(str(key)) + text("cpu") + b"J"
                   + struct.pack("<i", array.size) + b"tQ")
        items += text(name) + (b"ctorch._utils\n_rebuild_tensor_v2\n(" + storage + b"K\0" + numbers(array.shape)
                               + numbers(s // array.itemsize for s in array.strides)
                               + b"\x89ccollections\nOrderedDict\n)RtR")
    return b"\x80\x02ccollections\nOrderedDict\n)R(" + items + b"u."


def zip_parts():
    """(outer, inner) members of a small TQC policy."""
    rng = np.random.default_rng(3)
    arrays = {}
    for name, n, m in (("actor.latent_pi.0", 6, 5), ("actor.latent_pi.2", 5, 4), ("actor.mu.0", 4, 1)):
        arrays[name + ".weight"] = rng.normal(0, 0.5, (m, n)).astype("f4")
        arrays[name + ".bias"] = rng.normal(0, 0.5, m).astype("f4")
    inner = {"archive/data.pkl": pickled_state(arrays), "archive/byteorder": b"little",
             **{f"archive/data/{k}": array.tobytes() for k, array in enumerate(arrays.values())}}
    outer = {"data": b'{"policy_class": {"__module__": "sb3_contrib.tqc.policies"}, "num_timesteps": 321, "seed": 5, '
             b'"use_sde": true, "policy_kwargs": {"activation_fn": "<class \'torch.nn.modules.activation.ReLU\'>", '
             b'"clip_mean": 2.0}}'}
    return outer, inner


def write_zip(path, members, method=zipfile.ZIP_STORED):
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, content in members.items():
            archive.writestr(name, content)


def make_zip(folder):
    path = os.path.join(folder, "seed.zip")
    outer, inner = zip_parts()
    write_zip(path + ".pth", inner)
    with open(path + ".pth", "rb") as file:
        write_zip(path, {**outer, "policy.pth": file.read()})
    os.remove(path + ".pth")
    return path


def mutate_members(rng, members):
    """One member mutated, missing, empty or long, or compressed otherwise."""
    members = dict(members)
    name, how = rng.choice(sorted(members)), rng.randrange(8)
    if how < 5:
        members[name] = mutate_bytes(rng, members[name])
    elif how == 5:
        del members[name]
    elif how == 6:
        members[rng.choice(sorted(members))] = members[name]
    else:
        members[name] = bytes(rng.choice([0, 1, 1 << 16, 9 << 20, 130 << 20]))
    return members, rng.choice([zipfile.ZIP_STORED] * 3 + [zipfile.ZIP_DEFLATED] * 3
                               + [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])


def mutate_zip(rng, seed, path):
    outer, inner = zip_parts()
    where = rng.randrange(3)
    if where == 0:  # checksums of the zip find nearly all of these
        with open(seed, "rb") as file:
            content = mutate_bytes(rng, file.read())
        with open(path, "wb") as file:
            file.write(content)
        return
    method = zipfile.ZIP_DEFLATED
    if where == 1:
        inner, method = mutate_members(rng, inner)
    write_zip(path + ".pth", inner, method)
    with open(path + ".pth", "rb") as file:
        outer["policy.pth"] = file.read()
    os.remove(path + ".pth")
    method = zipfile.ZIP_STORED
    if where == 2:
        outer, method = mutate_members(rng, outer)
    write_zip(path, outer, method)
