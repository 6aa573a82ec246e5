#!/usr/bin/env python3
"""Damaged files of every kind that SlipStep reads: none may crash or hang our code, take a gigabyte, or pass for what it was.

    tests/fuzz.py [--count 2000] [--seed 1] [--keep DIR] [KIND ...]

KIND: policy, mesh, parameters, stiffness, cache (read by tests/fuzz.c), checkpoint (by the program fault, where it has
-fault_restart), catalogue and output (by a run that goes on in them) and zip (by training/import_sb3.py). A mutant is a good file with flipped bits, other numbers, pieces cut out,
doubled or missing, or a dataset or attribute of another type, rank, size or value, a missing or additional one, links in its
place. Its number and --seed alone decide what it is. Each must be read within 20 s and 1 GB, and be refused with one message
or accepted; where the file has a checksum, only with the content that it was taken of. Crashes whose innermost frame is in
HDF5 are counted apart, with its version: they are not ours to mend.

SLIPSTEP_BUILD names the build (default build); of a build with -DSLIPSTEP_SANITIZE=ON the sanitizers report. The exit code is
1 when a mutant broke a rule; it is then kept (--keep, else a folder that is named).
"""
import argparse
import collections
import glob
import os
import random
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import zipfile

SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
sys.path[:0] = [os.path.join(SOURCE, folder) for folder in ("output", "training")]
from slipstep_modules import need

need("h5py", "numpy")
import h5py
import import_sb3
import numpy as np

BUILD = os.path.abspath(os.environ.get("SLIPSTEP_BUILD", os.path.join(SOURCE, "build")))
READER = os.path.join(BUILD, "tests", "fuzz")
TIMEOUT = 200  # [s], on a busy machine as well
HUNG = f"signal {int(signal.SIGALRM)}"
MEMORY = 1 << 20  # [kB]
CHUNK = 200  # mutants that are on the disk at a time
ENVIRONMENT = dict(os.environ, OPENBLAS_NUM_THREADS="1", OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_ess_singleton_isolated="1", OMPI_MCA_pml="ob1", OMPI_MCA_btl="^tcp,openib,uct,ofi,usnic",
                   ASAN_OPTIONS="detect_leaks=0:allocator_may_return_null=1:exitcode=99",
                   UBSAN_OPTIONS="halt_on_error=1:print_stacktrace=1:exitcode=99")

Result = collections.namedtuple("Result", "path end seconds memory text")  # end: accepted, refused, or how it died
Kind = collections.namedtuple("Kind", "make mutate read checksum")


# ---- mutants: of bytes, and of HDF5's objects ----

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


def objects(file):
    """Paths of all groups and datasets but the root."""
    found = []
    file.visit(found.append)
    return sorted(found)


def other_type(rng, data):
    """An array of the same shape and another type."""
    kind = rng.choice(["<f4", "<f2", "<i1", ">f8", "<u8", "?", "S5", "vlen", "compound", "<c16", "opaque", "ragged", "array"])
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
    attributes[name] = [None, rng.choice(VALUES), np.ones((2, 3)), h5py.Empty("f8"), text + "x" * rng.choice([1, 70, 5000, 60000]),
                        text[:-1] + "\n\x1b", h5py.Empty("S4"), np.array([text.encode()[:9], b"other"]),
                        rng.choice([0, -1, 2, 2 ** 31, 2 ** 62])][how]


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
            file[path] = rng.choice([h5py.SoftLink("/" + path), h5py.SoftLink("/nothing"), h5py.ExternalLink("none.h5", "/x"),
                                     file["/"], 1.0, "text", np.ones((1,) * 7)])
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
        data = np.array([rng.choice([b"", b"x" * 4000, b"energy", b"\xff\xfe", b"a\nb"])] * max(data.size, 1), dtype=h5py.string_dtype())
    elif how == 6:
        data = other_type(rng, data)
    elif how == 7:
        data = rng.choice([data.ravel(), data.reshape((1,) * rng.randrange(7) + data.shape), data[:-1] if data.ndim else data,
                           data.reshape(data.shape + (1,)), data.ravel()[:1].reshape(()) if data.size else data, data.T])
    else:
        shape = list(data.shape) or [1]
        shape[rng.randrange(len(shape))] = rng.choice(SIZES)
        if rng.random() < 0.2:
            shape = [rng.choice(SIZES) for _ in range(rng.randrange(1, 4))]
        del file[path]
        dtype = h5py.string_dtype() if data.dtype.kind == "O" else data.dtype
        file.create_dataset(path, shape, dtype, chunks=tuple(min(max(n, 1), 4) for n in shape), maxshape=(None,) * len(shape),
                            compression=rng.choice([None, "gzip"]) if dtype != h5py.string_dtype() else None)
        file[path].attrs.update({name: value for name, value in attributes.items() if not isinstance(value, h5py.Empty)})
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


# ---- policy, mesh, parameters, stiffness, cache: read by tests/fuzz.c ----

def make_by_reader(kind):
    def make(folder):
        subprocess.run([READER, kind, "-make", os.path.join(folder, "seed.h5")], env=ENVIRONMENT, check=True)
        return glob.glob(os.path.join(folder, "*.h5"))[0]
    return make


def make_mesh(folder):
    path = os.path.join(folder, "seed.h5")
    with h5py.File(path, "w") as file:
        file["cells"] = np.array([[x, 0, z, 500, 400] for z in (200.0, 600.0) for x in (250.0, 750.0, 1250.0)])
        file["cells"].attrs["columns"] = "x y z length width"
    return path


def make_parameters(folder):
    path = os.path.join(folder, "seed.h5")
    with h5py.File(path, "w") as file:
        for name, value in (("normal_stress", 2e7), ("friction_residual", 0.5), ("friction_drop", 0.1), ("friction_slip", 0.2),
                            ("loading_rate", 0.0)):
            file[name] = value * np.linspace(1, 1.5, 6).reshape(2, 3)
    return path


def make_stiffness(folder):
    path = os.path.join(folder, "seed.h5")
    distance = np.abs(np.subtract.outer(np.arange(6), np.arange(6)))
    with h5py.File(path, "w") as file:
        file["stiffness"] = np.where(distance, -1e6 / (1 + distance ** 2), 1e7)
    return path


def crash_report(path, kind):
    """Frames of a crash on one mutant: of the reader's standard error, or for the program by gdb where there is one."""
    if kind in ("checkpoint", "catalogue", "output"):
        if not shutil.which("gdb"):
            return ""
        command = [*RUN, "-fault_restart", path] if kind == "checkpoint" else resumed(kind, path)
        return subprocess.run(["gdb", "-batch", "-ex", "run", "-ex", "bt", "--args", *command, "-no_signal_handler"],
                              env=ENVIRONMENT, capture_output=True, text=True, errors="replace", timeout=10 * TIMEOUT).stdout
    return subprocess.run([READER, kind], input=path + "\n", env=ENVIRONMENT, capture_output=True, text=True, errors="replace").stderr


def read_by_reader(kind):
    def read(paths):
        # a cache's file has the name that its key gives it
        done = subprocess.run([READER, kind], input="".join(path + "\n" for path in paths), env=ENVIRONMENT, capture_output=True,
                              text=True, errors="replace")
        results = [Result(*line.split("\t", 4)) for line in done.stdout.splitlines()]
        if len(results) != len(paths):
            sys.exit(f"{READER} {kind} stopped: {done.stderr[-2000:]}")
        return [r._replace(seconds=float(r.seconds), memory=int(r.memory)) for r in results]
    return read


# ---- checkpoint: read by the program ----

FAULT = os.path.join(BUILD, "bin", "fault")
RUN = [FAULT, "-fault_nx", "3", "-fault_nz", "2", "-ts_max_time", "30"]
CHECKPOINT_BLOCK = 512  # bytes before those of HDF5, with their checksum


def has_checkpoints():
    done = subprocess.run([FAULT, "-help"], env=ENVIRONMENT, capture_output=True, text=True)
    return "-fault_restart " in done.stdout


def make_checkpoint(folder):
    path = os.path.join(folder, "seed.h5")
    subprocess.run([*RUN, "-ts_max_steps", "5", "-fault_checkpoint", path], env=ENVIRONMENT, capture_output=True)
    if not os.path.exists(path):
        sys.exit("fault -fault_checkpoint wrote no file")
    return path


def mutate_checkpoint(rng, seed, path):
    """Half of the mutants get the checksum of what they became, so that what is behind it is reached."""
    with open(seed, "rb") as file:
        block, content = file.read(CHECKPOINT_BLOCK), file.read()
    if rng.random() < 0.4:
        with open(path, "wb") as file:
            file.write(mutate_bytes(rng, block + content))
        return
    with open(path + ".in", "wb") as file:
        file.write(content)
    mutate_hdf5(rng, path + ".in", path)
    with open(path, "rb") as file:
        content = file.read()
    os.remove(path + ".in")
    value, words = 0xCBF29CE484222325, content + bytes(-len(content) % 8)
    for (word,) in struct.iter_unpack("=Q", words):
        value = (value ^ word) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
        value ^= value >> 32
    head = b"".join(block.rstrip(b"\0").splitlines(True)[:1])
    head += f"checksum {value:016x} of {len(content)} bytes\n".encode()
    with open(path, "wb") as file:
        file.write(head + bytes(CHECKPOINT_BLOCK - len(head)) + content)


def run_program(path, command):
    """Result of a run of `command` for the mutant `path`, its text the final slip or the message."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        begin = time.time()
        child = subprocess.Popen(command, env=ENVIRONMENT, stdout=out, stderr=err, preexec_fn=lambda: signal.alarm(TIMEOUT))
        _, status, used = os.wait4(child.pid, 0)
        child.returncode = status
        out.seek(0), err.seek(0)
        slip = re.search(rb"final mean slip: *(\S+)", out.read())
        error = err.read().decode(errors="replace").strip()
    code = os.waitstatus_to_exitcode(status)
    end = f"signal {-code}" if code < 0 else "accepted" if code == 0 else "refused" if code == 1 and error else f"exit {code}"
    text = error.replace("\n", " | ") if code else slip[1].decode() if slip else "no slip"
    return Result(path, end, time.time() - begin, used.ru_maxrss, text)


def read_with_program(paths):
    results = []
    for path in paths:
        result = run_program(path, [*RUN, "-fault_restart", path])
        if result.end == "accepted" and not has_checksum_of_seed(path):
            result = result._replace(text="none")  # of what it became: it may differ
        results.append(result)
    return results


def has_checksum_of_seed(path):
    seed = os.path.join(os.path.dirname(os.path.dirname(path)), "seed.h5")
    if not os.path.exists(seed):
        return True  # it is the seed
    with open(path, "rb") as file, open(seed, "rb") as good:
        return file.read(CHECKPOINT_BLOCK) == good.read(CHECKPOINT_BLOCK)


# ---- catalogue, output: gone on with by the program ----

EVENTS = [FAULT, *"-fault_nx 1 -fault_nz 1 -fault_loading_rate 1e-9 -fault_initial rest -fault_friction_law rate_weakening".split()]
EVENTS += ["-fault_catalogue_maps", "-ts_max_time", "4e9"]


def make_grown(kind):
    """The file of a run that was stopped after some events, with the run's checkpoint beside it."""
    def make(folder):
        path = os.path.join(folder, "seed.h5")
        subprocess.run([*EVENTS, "-ts_max_time", "2e9", f"-fault_{kind}", path, "-fault_checkpoint", os.path.join(folder, "state")],
                       env=ENVIRONMENT, capture_output=True)
        if not os.path.exists(path):
            sys.exit(f"fault -fault_{kind} wrote no file")
        return path
    return make


def resumed(kind, path):
    """The run that goes on in a copy of `path`."""
    folder = os.path.dirname(path)
    state = next(name for name in (os.path.join(folder, "state"), os.path.join(os.path.dirname(folder), "state")) if os.path.exists(name))
    shutil.copyfile(path, path + ".copy")
    return [*EVENTS, f"-fault_{kind}", path + ".copy", "-fault_restart", state]


def read_grown(kind):
    def read(paths):
        results = []
        for path in paths:
            results.append(run_program(path, resumed(kind, path)))
            for left in glob.glob(glob.escape(path + ".copy") + "*"):
                os.remove(left)
        return results
    return read


# ---- zip: read by import_sb3.py ----

def pickled_state(arrays):
    def text(s):
        return b"X" + struct.pack("<I", len(s)) + s.encode()

    def numbers(values):
        return b"(" + b"".join(b"J" + struct.pack("<i", v) for v in values) + b"t"

    items = b""
    for key, (name, array) in enumerate(arrays.items()):
        storage = b"(" + text("storage") + b"ctorch\nFloatStorage\n" + text(str(key)) + text("cpu") + b"J" + struct.pack("<i", array.size) + b"tQ"
        items += text(name) + (b"ctorch._utils\n_rebuild_tensor_v2\n(" + storage + b"K\0" + numbers(array.shape)
                               + numbers(s // array.itemsize for s in array.strides) + b"\x89ccollections\nOrderedDict\n)RtR")
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
    outer = {"data": b'{"policy_class": {"__module__": "sb3_contrib.tqc.policies"}, "num_timesteps": 321, "seed": 5, "use_sde": true,'
                     b' "policy_kwargs": {"activation_fn": "<class \'torch.nn.modules.activation.ReLU\'>", "clip_mean": 2.0}}'}
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
    return members, rng.choice([zipfile.ZIP_STORED] * 3 + [zipfile.ZIP_DEFLATED] * 3 + [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])


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


def read_zips(paths):
    """Each by a process of its own that has import_sb3.py loaded; what it writes must be a policy."""
    results, written = [], []
    for path in paths:
        out, begin = path + ".h5", time.time()
        with tempfile.TemporaryFile() as errors:
            child = os.fork()
            if not child:
                code = 99
                try:
                    signal.alarm(TIMEOUT)
                    os.dup2(errors.fileno(), 2)
                    sys.argv = ["import_sb3.py", path, out]
                    code = import_sb3.main()
                except BaseException as error:
                    os.write(2, repr(error).encode())
                finally:
                    sys.stderr.flush()
                    os._exit(code)
            _, status, used = os.wait4(child, 0)
            errors.seek(0)
            text = errors.read().decode(errors="replace")
        code = os.waitstatus_to_exitcode(status)
        end = f"signal {-code}" if code < 0 else {0: "accepted", 2: "refused"}.get(code, f"exit {code}")
        if end == "refused" and text.count("\n") != 1:
            end = "more than one line"
        if end == "accepted":
            written.append(out)
        left = set(os.path.basename(name) for name in glob.glob(glob.escape(path) + "*")) - {os.path.basename(path)}
        if left != ({os.path.basename(out)} if end == "accepted" else set()):
            end = f"left {sorted(left)}"
        results.append(Result(path, end, time.time() - begin, used.ru_maxrss, text.strip() or "none"))
    for bad in read_by_reader("policy")(written):
        if bad.end != "accepted":
            results = [r._replace(end="wrote no policy", text=bad.text) if r.path + ".h5" == bad.path else r for r in results]
    for out in written:
        os.remove(out)
    return results


KINDS = {
    **{name: Kind(make, mutate_hdf5, read_by_reader(name), name in ("policy", "cache"))
       for name, make in (("policy", make_by_reader("policy")), ("mesh", make_mesh), ("parameters", make_parameters),
                          ("stiffness", make_stiffness), ("cache", make_by_reader("cache")))},
    "checkpoint": Kind(make_checkpoint, mutate_checkpoint, read_with_program, True),
    **{name: Kind(make_grown(name), mutate_hdf5, read_grown(name), False) for name in ("catalogue", "output")},
    "zip": Kind(make_zip, mutate_zip, read_zips, False),
}


# ---- the rules ----

def in_hdf5(report):
    """Is the innermost frame, of what is no runtime of C or of a sanitizer, in HDF5?"""
    frames = [line for line in report.splitlines() if re.match(r"\s*#\d+ |\S+\(.*\[0x", line)]
    runtime = re.compile(r"\blib(c|m|asan|ubsan|pthread)[.-]|interceptor|sanitizer")
    if "\ncrash\n" in report:  # written by the handler of signals, which the C library called
        frames = frames[[("libc.so" in line) for line in frames].index(True):]
    inner = [line for line in frames if not runtime.search(line)]
    return bool(inner) and "libhdf5" in inner[0]


def broken_rule(kind, result, good):
    if result.end not in ("accepted", "refused"):
        return result.end
    if result.seconds > TIMEOUT:
        return f"took {result.seconds:.0f} s"
    if result.memory > MEMORY:
        return f"took {result.memory // 1024} MB"
    if result.end == "refused" and not result.text:
        return "no message"
    if result.end == "accepted" and KINDS[kind].checksum and result.text not in ("none", good):
        return f"another content, {result.text} for {good}, was accepted"
    return None


def place(folder, kind, seed, number):
    """Where a mutant is: a cache's file has the name that its key gives it."""
    if kind == "cache":
        os.makedirs(os.path.join(folder, str(number)), exist_ok=True)
        return os.path.join(folder, str(number), os.path.basename(seed))
    return os.path.join(folder, f"{kind}{number}{os.path.splitext(seed)[1]}")


def fuzz(kind, count, seed_number, keep):
    """Counts of how `count` mutants ended, and how many broke a rule."""
    ends, broken, slowest, largest = collections.Counter(), 0, 0.0, 0
    with tempfile.TemporaryDirectory() as folder:
        seed = KINDS[kind].make(folder)
        (first,) = KINDS[kind].read([seed])
        if first.end != "accepted":
            sys.exit(f"{kind}: the good file is {first.end}: {first.text}")
        for begin in range(0, count, CHUNK):
            mutants = os.path.join(folder, "mutants")
            os.mkdir(mutants)
            paths = []
            for number in range(begin, min(begin + CHUNK, count)):
                paths.append(place(mutants, kind, seed, number))
                KINDS[kind].mutate(random.Random(f"{kind} {seed_number} {number}"), seed, paths[-1])
            for number, result in enumerate(KINDS[kind].read(paths), begin):
                rule = broken_rule(kind, result, first.text)
                slowest, largest = max(slowest, result.seconds), max(largest, result.memory)
                if rule and rule == result.end and rule != HUNG and kind != "zip" and in_hdf5(crash_report(result.path, kind)):
                    ends["crashed in HDF5"] += 1
                    print(f"{kind} {number}: {rule} inside HDF5 {h5py.version.hdf5_version}")
                elif rule:
                    broken += 1
                    kept = os.path.join(keep, f"{kind}{number}_{os.path.basename(result.path)}")
                    shutil.copyfile(result.path, kept)
                    print(f"{kind} {number}: {rule} ({result.text}); kept as {kept}")
                else:
                    ends[result.end] += 1
            shutil.rmtree(mutants)
    print(f"{kind}: {count} mutants, " + ", ".join(f"{n} {end}" for end, n in sorted(ends.items())) + f", {broken} broke a rule; "
          f"at most {slowest:.1f} s and {largest // 1024} MB")
    return broken


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kinds", nargs="*", metavar="KIND", help="what to damage (all)")
    parser.add_argument("--count", type=int, default=2000, help="mutants of each kind (2000)")
    parser.add_argument("--seed", type=int, default=1, help="of the random numbers (1)")
    parser.add_argument("--keep", metavar="DIR", help="where mutants go that broke a rule (a new folder)")
    args = parser.parse_args()
    if set(args.kinds) - set(KINDS):
        parser.error(f"expected KINDs among {', '.join(KINDS)}")
    kinds = args.kinds or list(KINDS)
    if "checkpoint" in kinds and not has_checkpoints():
        print("checkpoint: left out, this fault has no -fault_restart")
        kinds.remove("checkpoint")
    keep = args.keep or tempfile.mkdtemp(prefix="slipstep-fuzz-")
    os.makedirs(keep, exist_ok=True)
    with tempfile.TemporaryDirectory() as session:
        ENVIRONMENT["TMPDIR"] = session  # Open MPI's folder: others may be removing theirs
        broken = sum(fuzz(kind, args.count, args.seed, keep) for kind in kinds)
    if not args.keep and not os.listdir(keep):
        os.rmdir(keep)
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
