#!/usr/bin/env python3
"""Damaged files of every kind that SlipStep reads: none may crash or hang our code, take a gigabyte, or pass for what
it was.

    tests/fuzz.py [--count 2000] [--seed 1] [--keep DIR] [KIND ...]

KIND: policy, mesh, planes, triangles, gmsh22 (text), gmsh41 (bytes), parameters, stiffness, history, history_csv (of
stresses), tolerances, estimates (read by tests/fuzz.c), stations (of the surface, by the program fault), checkpoint
(by the program fault, where it has -fault_restart), catalogue and output (by a run that goes on in them) and zip (by
training/study/import_sb3.py). A mutant is a good file with flipped bits, other numbers, pieces cut out, doubled or
missing, or a dataset or attribute of another type, rank, size or value, a missing or additional one, links in its
place. Its number and --seed alone decide what it is. Each must be read within 20 s and 1 GB, and be refused with one
message or accepted; where the file has a checksum, only with the content that it was taken of. Crashes and hangs whose
innermost frame is in HDF5 are counted apart, with its version: they are not ours to mend.

SLIPSTEP_BUILD names the build (default build); of a build with -DSLIPSTEP_SANITIZE=ON the sanitizers report. The exit
code is 1 when a mutant broke a rule; it is then kept (--keep, else a folder that is named).
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

SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
sys.path[:0] = [os.path.join(SOURCE, folder) for folder
                in (os.path.join("src", "package"), os.path.join("training", "study"), os.path.join("tests", "python"))]
from slipstep.modules import need

need("h5py", "numpy")
import h5py
import import_sb3
import meshfiles
import numpy as np
from fuzz_mutants import mutate_bytes, mutate_hdf5, mutate_words
from fuzz_zip import make_zip, mutate_zip

BUILD = os.path.abspath(os.environ.get("SLIPSTEP_BUILD", os.path.join(SOURCE, "build")))
READER = os.path.join(BUILD, "tests", "fuzz")
TIMEOUT = 200  # [s], on a busy machine as well
HUNG = f"signal {int(signal.SIGALRM)}"
HUNG_AT = f"exit {128 + int(signal.SIGALRM)}"  # of the reader, which then writes where
MEMORY = 1 << 20  # [kB]
CHUNK = 200  # mutants that are on the disk at a time
ENVIRONMENT = dict(os.environ, OPENBLAS_NUM_THREADS="1", OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_ess_singleton_isolated="1", OMPI_MCA_pml="ob1", OMPI_MCA_btl="^tcp,openib,uct,ofi,usnic",
                   ASAN_OPTIONS="detect_leaks=0:allocator_may_return_null=1:exitcode=99",
                   UBSAN_OPTIONS="halt_on_error=1:print_stacktrace=1:exitcode=99")

Result = collections.namedtuple("Result", "path end seconds memory text")  # end: accepted, refused, or how it died
Kind = collections.namedtuple("Kind", "make mutate read checksum")


# ---- policy, mesh, parameters, stiffness: read by tests/fuzz.c ----

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


def make_planes(folder):
    """Two planes of other directions, with names of faults"""
    path = os.path.join(folder, "seed.h5")
    with h5py.File(path, "w") as file:
        file["cells"] = [[x, y, 900, 500, 400, strike, dip] for y, strike, dip in ((0.0, 0, 60), (5e3, 30, 45))
                         for x in (250.0, 750.0)]
        file["cells"].attrs["columns"] = "x y z length width strike dip"
        file["fault"] = [7, 7, 2, 2]
    return path


def make_triangles(folder):
    """A bend of two faults with names"""
    path = os.path.join(folder, "seed.h5")
    with h5py.File(path, "w") as file:
        file["vertices"] = VERTICES
        file["triangles"] = CORNERS
        file["fault"] = [7, 7, 2, 2]
        file["fault"].attrs["names"] = "2 west; 7 east"
    return path


# north, east, down
VERTICES = np.array([[0, 0, 500], [700, 0, 500], [1400, 300, 500], [0, 300, 1200], [700, 300, 1200], [1400, 600, 1200]],
                    float)
CORNERS = [[0, 1, 4], [0, 4, 3], [1, 2, 4], [2, 5, 4]]


def make_gmsh(version, binary):
    """The same of Gmsh, with lines and points"""
    def make(folder):
        path = os.path.join(folder, "seed.msh")
        points = np.column_stack([VERTICES[:, 1], VERTICES[:, 0], -VERTICES[:, 2]])
        elements = [(15, 0, [0]), (1, 0, [0, 1])] + [(2, fault, corners)
                                                     for corners, fault in zip(CORNERS, (7, 7, 2, 2))]
        with open(path, "wb") as file:
            file.write(meshfiles.gmsh(version, binary, points, elements, names=((2, 2, "west"), (2, 7, "east"))))
        return path
    return make


def make_parameters(folder):
    path = os.path.join(folder, "seed.h5")
    with h5py.File(path, "w") as file:
        for name, value in (("normal_stress", 2e7), ("friction_residual", 0.5), ("friction_drop", 0.1),
                            ("friction_slip", 0.2), ("loading_rate", 0.0)):
            file[name] = value * np.linspace(1, 1.5, 6).reshape(2, 3)
    return path


def make_stiffness(folder):
    path = os.path.join(folder, "seed.h5")
    distance = np.abs(np.subtract.outer(np.arange(6), np.arange(6)))
    with h5py.File(path, "w") as file:
        file["stiffness"] = np.where(distance, -1e6 / (1 + distance ** 2), 1e7)
    return path


def make_history(folder):
    """Two stresses in time, one of numbers and one of fields, of which shear has two components"""
    path = os.path.join(folder, "seed.h5")
    with h5py.File(path, "w") as file:
        for group, shear, normal in (("quake", 2e5, -1e5), ("wave", 1e5 * np.arange(12.0).reshape(2, 3, 2),
                                                             np.full((2, 3), 5e4))):
            for name, values, unit in (("time", [0.0, 5, 20, 60], "s"), ("course", [0.0, 1, 0.4, 0.6], "1"),
                                       ("shear", shear, "Pa"), ("normal", normal, "Pa")):
                file[f"{group}/{name}"] = values
                file[f"{group}/{name}"].attrs["units"] = unit
    return path


def make_history_csv(folder):
    path = os.path.join(folder, "seed.csv")
    with open(path, "w") as file:
        file.write("time, shear, normal\n0, 0, 0\n5.5, 1e5, -2e4\n\n60, 2.5e5, 0\n")
    return path


def make_shipped(name):
    """A file of measured numbers that comes with the library"""
    def make(folder):
        return shutil.copy(os.path.join(SOURCE, "training", "policies", name), folder)
    return make


def crash_report(path, kind):
    """Frames of a crash on one mutant: of the reader's standard error, or for the program by gdb where there is one."""
    if kind in ("checkpoint", "catalogue", "output", "stations"):
        if not shutil.which("gdb"):
            return ""
        command = {"checkpoint": restarted, "stations": with_stations}.get(kind, lambda path: resumed(kind, path))(path)
        return subprocess.run(["gdb", "-batch", "-ex", "run", "-ex", "bt", "--args", *command, "-no_signal_handler"],
                              env=ENVIRONMENT, capture_output=True, text=True, errors="replace",
                              timeout=10 * TIMEOUT).stdout
    kind = ("mesh" if kind in ("planes", "triangles", "gmsh22", "gmsh41") else "history" if kind == "history_csv"
            else kind)
    return subprocess.run([READER, kind], input=path + "\n", env=ENVIRONMENT, capture_output=True, text=True,
                          errors="replace").stderr


def read_by_reader(kind):
    def read(paths):
        done = subprocess.run([READER, kind], input="".join(path + "\n" for path in paths), env=ENVIRONMENT,
                              capture_output=True, text=True, errors="replace")
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
        child = subprocess.Popen(command, env=ENVIRONMENT, stdout=out, stderr=err,
                                 preexec_fn=lambda: signal.alarm(TIMEOUT))
        _, status, used = os.wait4(child.pid, 0)
        child.returncode = status
        out.seek(0), err.seek(0)
        slip = re.search(rb"final mean slip: *(\S+)", out.read())
        error = err.read().decode(errors="replace").strip()
    code = os.waitstatus_to_exitcode(status)
    end = (f"signal {-code}" if code < 0 else "accepted" if code == 0 else "refused" if code == 1 and error
           else f"exit {code}")
    text = error.replace("\n", " | ") if code else slip[1].decode() if slip else "no slip"
    return Result(path, end, time.time() - begin, used.ru_maxrss, text)


def restarted(path):
    return [*RUN, "-fault_restart", path]


def read_with_program(paths):
    results = []
    for path in paths:
        result = run_program(path, restarted(path))
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


# ---- stations: read by the program ----

def make_stations(folder):
    path = os.path.join(folder, "seed.txt")
    with open(path, "w") as file:
        file.write("# east of the fault\n1000,2000\n-1e3 2.5e3  # and west\n\n0,0\n")
    return path


def mutate_file(rng, seed, path):
    with open(seed, "rb") as file:
        content = file.read()
    words = seed.endswith((".msh", ".csv")) and rng.random() < 0.5
    content = (mutate_words if words else mutate_bytes)(rng, content)
    with open(path, "wb") as file:
        file.write(content)


def with_stations(path):
    return [*RUN, "-ts_max_time", "0.1", "-fault_output", path + ".h5", "-fault_surface_stations", path]


def read_stations(paths):
    results = []
    for path in paths:
        results.append(run_program(path, with_stations(path)))
        for left in glob.glob(glob.escape(path) + ".h5*"):
            os.remove(left)
    return results


# ---- catalogue, output: gone on with by the program ----

# Two faults of a cell each, for which files have a number each
EVENTS = [FAULT, *"-fault_thickness 3000 -fault_loading_rate 1e-9 -fault_initial rest -fault_friction_law "
                  "rate_weakening".split()]
EVENTS += ["-fault_catalogue_maps", "-ts_max_time", "4e9"]


def make_grown(kind):
    """The file of a run that was stopped after some events, with the run's checkpoint and mesh beside it."""
    def make(folder):
        path, mesh = os.path.join(folder, "seed.h5"), os.path.join(folder, "mesh.h5")
        with h5py.File(mesh, "w") as file:
            file["cells"] = [[1500, y, 1500, 3000, 3000] for y in (0.0, 5e3)]
            file["fault"] = [7, 2]
        subprocess.run([*EVENTS, "-fault_mesh", mesh, "-ts_max_time", "2e9", f"-fault_{kind}", path,
                        "-fault_checkpoint", os.path.join(folder, "state")], env=ENVIRONMENT, capture_output=True)
        if not os.path.exists(path):
            sys.exit(f"fault -fault_{kind} wrote no file")
        return path
    return make


def resumed(kind, path):
    """The run that goes on in a copy of `path`."""
    folder = os.path.dirname(path)
    if not os.path.exists(os.path.join(folder, "state")):
        folder = os.path.dirname(folder)
    shutil.copyfile(path, path + ".copy")
    return [*EVENTS, "-fault_mesh", os.path.join(folder, "mesh.h5"), f"-fault_{kind}", path + ".copy", "-fault_restart",
            os.path.join(folder, "state")]


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
            results = [r._replace(end="wrote no policy", text=bad.text) if r.path + ".h5" == bad.path else r
                       for r in results]
    for out in written:
        os.remove(out)
    return results


KINDS = {**{name: Kind(make, mutate_hdf5, read_by_reader(name), name == "policy") for name,
            make in (("policy", make_by_reader("policy")), ("mesh", make_mesh), ("parameters", make_parameters),
                     ("stiffness", make_stiffness), ("history", make_history),
                     ("tolerances", make_shipped("tolerances.h5")), ("estimates", make_shipped("estimates.h5")))},
         "history_csv": Kind(make_history_csv, mutate_file, read_by_reader("history"), False),
         "planes": Kind(make_planes, mutate_hdf5, read_by_reader("mesh"), False),
         "triangles": Kind(make_triangles, mutate_hdf5, read_by_reader("mesh"), False),
         **{f"gmsh{version.replace('.', '')}": Kind(make_gmsh(version, binary), mutate_file, read_by_reader("mesh"),
                                                    False) for version, binary in (("2.2", False), ("4.1", True))},
         "stations": Kind(make_stations, mutate_file, read_stations, False),
         "checkpoint": Kind(make_checkpoint, mutate_checkpoint, read_with_program, True),
         **{name: Kind(make_grown(name), mutate_hdf5, read_grown(name), False) for name in ("catalogue", "output")},
         "zip": Kind(make_zip, mutate_zip, read_zips, False),}


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
    """Where a mutant is"""
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
                if (rule and rule == result.end and rule != HUNG and kind != "zip"
                    and in_hdf5(crash_report(result.path, kind))):
                    ends["hung in HDF5" if rule == HUNG_AT else "crashed in HDF5"] += 1
                    print(f"{kind} {number}: {f'no end within {TIMEOUT} s' if rule == HUNG_AT else rule} inside HDF5 "
                          f"{h5py.version.hdf5_version}")
                elif rule:
                    broken += 1
                    kept = os.path.join(keep, f"{kind}{number}_{os.path.basename(result.path)}")
                    shutil.copyfile(result.path, kept)
                    print(f"{kind} {number}: {rule} ({result.text}); kept as {kept}")
                else:
                    ends[result.end] += 1
            shutil.rmtree(mutants)
    print(f"{kind}: {count} mutants, " + ", ".join(f"{n} {end}" for end, n in sorted(ends.items()))
          + f", {broken} broke a rule; " f"at most {slowest:.1f} s and {largest // 1024} MB")
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
