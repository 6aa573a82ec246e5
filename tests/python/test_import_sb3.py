#!/usr/bin/env python3
"""training/study/import_sb3.py: made-up zips of all three algorithms, broken zips, and the published one when it is
there."""
import base64
import collections
import glob
import io
import json
import os
import pickle
import resource
import struct
import subprocess
import sys
import tempfile
import traceback
import zipfile

import scripts  # noqa: F401: before modules that may be missing

sys.path.append(os.path.join(scripts.SOURCE, "training", "study"))
import h5py
import import_sb3
import numpy as np

SOURCE = os.environ.get("SLIPSTEP_SOURCE", os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
SCRIPT = os.path.join(SOURCE, "training", "study", "import_sb3.py")
PUBLISHED = os.path.join(os.environ.get("SLIPSTEP_PUBLISHED", os.path.join(SOURCE, "..", "shared", "published")),
                         "tqc_alpha1_single_element.zip")
FAULT = ["energy", "velocity", "residual", "converged", "accuracy", "step"]


# ---- a torch state dict without torch: the pickle opcodes that torch.save() writes ----

def text(s):
    return b"X" + struct.pack("<I", len(s)) + s.encode()


def number(n):
    return b"J" + struct.pack("<i", n)


def numbers(values):
    return b"(" + b"".join(number(v) for v in values) + b"t"


def pickled_tensor(key, array):
    strides = [s // array.itemsize for s in array.strides]
    storage = (b"(" + text("storage") + b"ctorch\nFloatStorage\n" + text(str(key)) + text("cpu") + number(array.size)
               + b"tQ")
    return (b"ctorch._utils\n_rebuild_tensor_v2\n(" + storage + number(0) + numbers(array.shape) + numbers(strides)
            + b"\x89ccollections\nOrderedDict\n)RtR")


def policy_pth(state, spoil_pickle=lambda p: p, drop=()):
    items = b"".join(text(name) + pickled_tensor(k, a) for k, (name, a) in enumerate(state.items()))
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as z:
        z.writestr("archive/data.pkl", spoil_pickle(b"\x80\x02ccollections\nOrderedDict\n)R(" + items + b"u."))
        z.writestr("archive/byteorder", "little")
        for k, array in enumerate(state.values()):
            if k not in drop:
                z.writestr(f"archive/data/{k}", array.astype("<f4").tobytes())
    return buffer.getvalue()


def write_zip(path, data, pth):
    with zipfile.ZipFile(path, "w") as z:
        if data is not None:
            z.writestr("data", data if isinstance(data, str) else json.dumps(data))
        if pth is not None:
            z.writestr("policy.pth", pth)


# ---- networks, and what they compute written out ----

RNG = np.random.default_rng(7)


def layer(state, prefix, n_in, n_out):
    state[prefix + ".weight"] = RNG.normal(0, 0.7, (n_out, n_in)).astype("f4")
    state[prefix + ".bias"] = RNG.normal(0, 0.7, n_out).astype("f4")


def network(algorithm, sde, n=6, hidden=(5, 4)):
    """(data, state) as the library stores them."""
    state, widths = {"actor.log_std": np.zeros((hidden[-1], 1), "f4")} if sde else {}, (n, *hidden)
    prefix = "actor.mu" if algorithm == "td3" else "actor.latent_pi"
    for k in range(len(hidden)):
        layer(state, f"{prefix}.{2 * k}", widths[k], widths[k + 1])
    if algorithm == "td3":
        layer(state, f"actor.mu.{2 * len(hidden)}", hidden[-1], 1)
    else:
        layer(state, "actor.mu.0" if sde else "actor.mu", hidden[-1], 1)
        if not sde:
            layer(state, "actor.log_std", hidden[-1], 1)
    layer(state, "critic.qf0.0", n + 1, 25 if algorithm == "tqc" else 1)
    module = {"tqc": "sb3_contrib.tqc.policies", "td3": "stable_baselines3.td3.policies",
              "sac": "stable_baselines3.sac.policies"}
    return {"policy_class": {"__module__": module[algorithm]}, "num_timesteps": 321, "seed": 5, "use_sde": sde,
            "policy_kwargs": {"activation_fn": "<class 'torch.nn.modules.activation.ReLU'>", "use_sde": sde}}, state


def forward(state, obs, sde, act=lambda x: np.maximum(x, 0)):
    """tanh(clip(mu)) or tanh(mu), from the tensors in the order of the zip."""
    names = [n[:-7] for n in state if n.endswith(".weight") and n.startswith("actor.") and "log_std" not in n]
    x = np.asarray(obs, float)
    for name in names[:-1]:
        x = act(state[name + ".weight"].astype(float) @ x + state[name + ".bias"])
    x = state[names[-1] + ".weight"].astype(float) @ x + state[names[-1] + ".bias"]
    return np.tanh(np.clip(x, -2, 2) if sde else x)[0]


def file_forward(path, obs):
    """What SlipPolicy computes, from the file (slippolicy.h)."""
    kinds = {"relu": lambda x: np.maximum(x, 0), "tanh": np.tanh, "linear": lambda x: x,
             "hardtanh2": lambda x: np.clip(x, -2, 2)}
    with h5py.File(path) as f:
        x = np.asarray(obs) * f["observation/scale"][:] + f["observation/offset"][:]
        for k in range(len(f["layers"])):
            g = f[f"layers/{k}"]
            x = kinds[g.attrs["activation"]](g["weight"][:].astype(float) @ x + g["bias"][:])
        a = f["action"].attrs
        return a["low"] + (np.tanh(x[0]) + 1) / 2 * (a["high"] - a["low"])


Done = collections.namedtuple("Done", "returncode stderr")


def run(*args):
    """The script in a process of its own, which need not import its modules again."""
    with tempfile.TemporaryFile() as errors:
        child = os.fork()
        if not child:
            code = 99
            try:
                os.dup2(errors.fileno(), 2)
                sys.argv = [SCRIPT, *args]
                code = import_sb3.main()
            except SystemExit as end:
                code = end.code
            except BaseException:
                traceback.print_exc()
            finally:
                sys.stderr.flush()
                os._exit(code)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        errors.seek(0)
        return Done(code, errors.read().decode())


def imports(zip_path, state, sde, *options, names=FAULT, act=lambda x: np.maximum(x, 0)):
    done = run(zip_path, "out.h5", *options)
    assert done.returncode == 0, done.stderr
    with h5py.File("out.h5") as f:
        assert list(f["observation/names"].asstr()) == names
        assert f.attrs["format"] == "slipstep-policy" and f.attrs["version"] == 1
        attributes, action = dict(f.attrs), dict(f["action"].attrs)
    for _ in range(20):
        obs = RNG.normal(0, 2, len(names))
        # the same double-precision sums in both: only their order could differ
        assert abs(file_forward("out.h5", obs) - forward(state, obs, sde, act)) < 1e-12
    assert not [name for name in os.listdir() if "part" in name]
    return attributes, action


def bounds(action):
    return tuple(action[name] for name in ("dt_min", "dt_min_unit", "dt_max", "dt_max_unit"))


def test_algorithms():
    for algorithm in ("tqc", "td3", "sac"):
        for sde in (False, True):
            if algorithm == "td3" and sde:
                continue
            data, state = network(algorithm, sde)
            write_zip("in.zip", data, policy_pth(state))
            attributes, action = imports("in.zip", state, sde)
            assert attributes["algorithm"] == algorithm
            assert attributes["training_steps"] == 321 and attributes["seed"] == 5
            assert bounds(action) == (1e-6, "T*", 6, "s")
            del data["policy_class"]  # told apart by the networks then
            write_zip("in.zip", data, policy_pth(state))
            assert imports("in.zip", state, sde)[0]["algorithm"] == algorithm


def test_options():
    data, state = network("tqc", True, n=8, hidden=(3,))
    data["policy_kwargs"]["activation_fn"] = "<class 'torch.nn.modules.activation.Tanh'>"
    write_zip("in.zip", data, policy_pth(state))
    names = ["energy", "state_2", "state_0", "state_1", "residual", "converged", "accuracy", "step"]
    _, action = imports("in.zip", state, True, "--preset", "circuit", "--dt-min", "1e-5T*", "--dt-max", "0.1t_max",
                        names=names, act=np.tanh)
    assert bounds(action) == (1e-5, "T*", 0.1, "t_max")


def space(width, low, high):
    return {":type:": "<class 'gymnasium.spaces.box.Box'>", "_shape": f"[{width}]",
            "low": str([low] * width).replace(",", ""),
            "high": str([high] * width).replace(",", "")}


def test_spaces():
    """An action other than a share of the steps, and other numbers of observations, are refused by name."""
    data, state = network("tqc", True)
    for low, high in ((0.0, 1.0), (-1.0, 1.0)):
        data |= {"action_space": space(1, low, high), "observation_space": space(6, -np.inf, np.inf)}
        write_zip("in.zip", data, policy_pth(state))
        imports("in.zip", state, True)
    data["action_space"] = space(1, 0.001, 0.5)
    write_zip("in.zip", data, policy_pth(state))
    refused("bounds", "action_space is from 0.001 to 0.5", "--dt-min", "0.001")
    _, action = imports("in.zip", state, True, "--dt-min", "0.001", "--dt-max", "0.5")
    assert bounds(action) == (0.001, "s", 0.5, "s")
    for name, value, want in (("action_space", space(1, 0.0, np.inf), "bounds"),
                              ("action_space", space(2, 0.0, 1.0), "its action_space has the shape [2]"),
                              ("action_space", {":type:": "<class 'gymnasium.spaces.discrete.Discrete'>", "n": "3"},
                               "Box of 1"),
                              ("observation_space", space(5, -np.inf, np.inf),
                               "its observation_space has the shape [5]")):
        write_zip("in.zip", data | {"action_space": space(1, 0.0, 1.0), name: value}, policy_pth(state))
        refused(want, want)


class RunningMeanStd:
    pass


class VecNormalize:
    pass


class Payload:
    def __reduce__(self):
        return os.system, ("touch executed",)


def test_vecnormalize():
    """The network sees (x - mean)/sqrt(var + epsilon), of statistics of either precision; nothing of the file runs."""
    data, state = network("td3", False)
    write_zip("in.zip", data, policy_pth(state))
    statistics, saved = RunningMeanStd(), VecNormalize()
    saved.__dict__ |= {"obs_rms": statistics, "clip_obs": 10.0, "epsilon": 1e-8, "norm_obs": True,
                       "callbacks": Payload()}
    for dtype, protocol in (("f8", 2), ("f4", 4), ("f8", 5)):
        statistics.mean, statistics.var = RNG.normal(0, 3, 6).astype(dtype), RNG.uniform(0.1, 9, 6).astype(dtype)
        with open("norm.pkl", "wb") as file:
            pickle.dump(saved, file, protocol)
        done = run("in.zip", "out.h5", "--vecnormalize", "norm.pkl")
        assert done.returncode == 0 and not os.path.exists("executed"), done.stderr
        for _ in range(10):
            seen = RNG.normal(0, 2, 6)
            shown = (seen - statistics.mean.astype(float)) / np.sqrt(statistics.var.astype(float) + 1e-8)
            assert abs(file_forward("out.h5", seen) - forward(state, shown, False)) < 1e-12
    statistics.mean = np.zeros(5)
    wrong = {"five.pkl": saved, "other.pkl": {"obs_rms": 3}, "text.pkl": "no pickle"}
    for name, content in wrong.items():
        with open(name, "wb") as file:
            file.write(content.encode() if isinstance(content, str) else pickle.dumps(content))
    refused("five", "five.pkl has 5 numbers", "--vecnormalize", "five.pkl")
    refused("other", "other.pkl holds no VecNormalize", "--vecnormalize", "other.pkl")
    refused("text", "text.pkl", "--vecnormalize", "text.pkl")
    refused("absent", "absent.pkl", "--vecnormalize", "absent.pkl")
    for name in ("norm.pkl", *wrong):
        os.remove(name)


def test_checksum():
    """Python's checksum is the one of the library: of files that it wrote, and it reads those written here."""
    for path in glob.glob(os.path.join(SOURCE, "training", "**", "*.h5"), recursive=True):
        if os.path.basename(path) in ("tolerances.h5", "estimates.h5"):  # no policies
            continue
        with h5py.File(path) as file:
            written = file.attrs["checksum"]  # HDF5 knows two kinds of strings
            assert import_sb3.checksum(file) == (written.decode() if isinstance(written, bytes) else written), path
    data, state = network("sac", True)
    write_zip("in.zip", data, policy_pth(state))
    done = subprocess.run([sys.executable, SCRIPT, "in.zip", "out.h5", "--alpha", "0.3"], check=False)
    assert done.returncode == 0
    fault = os.path.join(os.environ.get("SLIPSTEP_BUILD", ""), "bin", "fault")
    if not os.access(fault, os.X_OK):
        print("no build (SLIPSTEP_BUILD): what is imported is not read by the library")
        return
    command = [fault, "-ts_adapt_type", "rl", "-ts_adapt_rl_policy", "out.h5", "-ts_max_time", "1e-3",
               "-fault_stiffness_average", "whole"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    with h5py.File("out.h5", "r+") as file:
        file["layers/0/weight"][1, 2] *= 1 + 1e-6
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode != 0 and "checksum" in done.stderr and done.stderr.count("\n") == 1, done


def refused(name, want, *options):
    """import_sb3.py refuses in.zip in one line, and leaves nothing behind."""
    before = sorted(os.listdir())
    done = run("in.zip", "out.h5", *options)
    assert done.returncode == 2, (name, done)
    assert want in done.stderr and done.stderr.count("\n") == 1 and len(done.stderr) < 700, (name, done.stderr)
    assert sorted(os.listdir()) == before, name


def test_payloads():
    """Pickles that would run a command if anything ran them: `touch executed`."""
    data, state = network("tqc", True)
    command = text("touch executed")
    pickles = {"REDUCE": b"\x80\x02cos\nsystem\n(" + command + b"tR.",
               "INST": b"\x80\x02(" + command + b"ios\nsystem\n.",
               "OBJ": b"\x80\x02(cos\nsystem\n" + command + b"o.",
               "NEWOBJ": b"\x80\x02csubprocess\nPopen\n(" + command + b"t\x81.",
               "STACK_GLOBAL": b"\x80\x04" + text("os") + text("system") + b"\x93(" + command + b"tR.",
               "a value of the state": b"\x80\x02}" + text("actor.mu.weight") + b"cbuiltins\neval\n("
               + text("__import__('os').system('touch executed')") + b"tRs.",
               "BUILD": b"\x80\x02ctorch._utils\n_rebuild_tensor_v2\nN}" + text("__code__") + b"cos\nsystem\ns\x86b.",
               "EXT1": b"\x80\x02\x82\x01(" + command + b"tR.",
               "a storage": b"\x80\x02(" + text("storage") + b"cos\nsystem\n" + command + text("cpu") + b"K\x01tQ.",}
    for name, pickled in pickles.items():
        write_zip("in.zip", data, policy_pth(state, lambda _: pickled))
        refused(name, "policy.pth")
    # Stable-Baselines3 would unpickle this one; here it is text.
    data["policy_class"][":serialized:"] = base64.b64encode(pickles["REDUCE"]).decode()
    write_zip("in.zip", data, policy_pth(state))
    assert run("in.zip", "out.h5").returncode == 0 and not os.path.exists("executed")
    os.remove("out.h5")


def tensor(size, stride, numbers_=4):
    """A pickle of one tensor of a storage data/0 of some numbers."""
    return (b"\x80\x02}" + text("actor.mu.weight") + b"ctorch._utils\n_rebuild_tensor_v2\n((" + text("storage")
            + b"ctorch\nFloatStorage\n" + text("0") + text("cpu") + number(numbers_) + b"tQ" + number(0)
            + numbers(size) + numbers(stride) + b"\x89}tRs.")


def test_sizes():
    """Small zips that would unpack, or build, gigabytes: refused before they do."""
    data, state = network("tqc", True)
    huge = 200 << 20

    def pth(method=zipfile.ZIP_DEFLATED, **members):
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w", method) as z:
            for name, content in {"data.pkl": b"\x80\x02}.", "byteorder": b"little", **members}.items():
                with z.open("archive/" + name.replace("data_", "data/"), "w") as file:
                    for _ in range(content >> 20 if isinstance(content, int) else 0):
                        file.write(bytes(1 << 20))
                    file.write(b"" if isinstance(content, int) else content)
        return buffer.getvalue()

    cases = {
        "byteorder": (pth(byteorder=huge), "unpacks to"),
        "data.pkl": (pth(**{"data.pkl": huge}), "unpacks to"),
        "a storage": (pth(**{"data.pkl": tensor((2, 2), (2, 1)), "data_0": huge}), "unpacks to"),
        "lzma": (pth(zipfile.ZIP_LZMA, **{"data.pkl": 1 << 20}), "compressed by method 14"),
        "a repeated number": (pth(**{"data.pkl": tensor((100000, 100000), (0, 0)), "data_0": bytes(16)}), "in all"),
        "many dimensions": (pth(**{"data.pkl": tensor((1,) * 40, (1,) * 40), "data_0": bytes(16)}), "impossible"),
        "beyond its data": (pth(**{"data.pkl": tensor((2, 2), (9, 1)), "data_0": bytes(16)}), "larger than its data"),
        "a memo": (pth(**{"data.pkl": b"\x80\x02}r\xff\xff\xff\x7f."}), "no actor"),
        "a long text": (pth(**{"data.pkl": b"\x80\x04\x8d" + struct.pack("<Q", 1 << 40) + b"."}), "policy.pth|damaged"),
        "a nested key": (pth(**{"data.pkl": b"\x80\x02})" + b"\x85" * 900000 + b"Ns."}), "keys are not names"),
        "an empty stack": (pth(**{"data.pkl": b"\x80\x020000."}), "POP"),
        "no stack": (pth(**{"data.pkl": b"\x80\x02\x87."}), "takes more than it gave"),
        "too many members": (pth(**{f"m{k}": b"" for k in range(10001)}), "more than 10000 members"),
    }
    for name, (content, want) in cases.items():
        write_zip("in.zip", data, content)
        refused(name, want.split("|")[-1])
    with zipfile.ZipFile("in.zip", "w", zipfile.ZIP_DEFLATED) as z:
        z.writestr("data", bytes(huge))
    refused("data", "unpacks to")
    write_zip("in.zip", "[" * 500000, policy_pth(state))
    refused("nested data", "damaged")
    with open("in.zip", "wb") as file:
        file.truncate(1 << 40)
    refused("in.zip", "it has 1099511627776 bytes")
    os.remove("in.zip")
    os.mkfifo("in.zip")
    refused("a pipe", "in.zip")
    os.remove("in.zip")
    # 128 MB at most are unpacked; the modules alone take a third of that
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss < 400 << 10


def test_output():
    """Links are followed, and what is no file is left alone."""
    data, state = network("tqc", True)
    write_zip("in.zip", data, policy_pth(state))
    os.mkdir("folder")
    os.symlink("folder/policy.h5", "out.h5")
    assert (run("in.zip", "out.h5").returncode == 0 and os.path.islink("out.h5")
            and os.listdir("folder") == ["policy.h5"])
    for bad in ("folder", os.devnull):
        done = run("in.zip", bad)
        assert done.returncode == 2 and "in.zip" in done.stderr, done
    done = run("in.zip", "in.zip")
    assert done.returncode == 2 and "output as well" in done.stderr and zipfile.is_zipfile("in.zip"), done
    os.remove("out.h5")


def test_broken():
    data, state = network("tqc", True)

    def changed(**tensors):
        return {**state, **tensors}

    nan = state["actor.latent_pi.0.weight"].copy()
    nan[1, 2] = np.nan
    evil = b"\x80\x02cos\nsystem\n(" + text("touch executed") + b"tR."
    good = policy_pth(state)
    cases = {
        "no zip": (None, None, "not a zip"),
        "no data": ((None, good), None, "no member data"),
        "no policy": ((data, None), None, "no member policy.pth"),
        "data no JSON": (("{", good), None, "damaged"),
        "code in the pickle": ((data, policy_pth(state, lambda p: evil)), None, "refers to os.system"),
        "truncated pickle": ((data, policy_pth(state, lambda p: p[: len(p) // 2])), None, "damaged"),
        "missing storage": ((data, policy_pth(state, drop=(1,))), None, "no member archive/data/1"),
        "not torch": ((data, b"pickle"), None, "not a torch archive"),
        "no actor": ((data, policy_pth({"q_net.weight": np.ones((1, 6), "f4")})), None, "no actor"),
        "NaN": ((data, policy_pth(changed(**{"actor.latent_pi.0.weight": nan}))), None, "not finite"),
        "chain": ((data, policy_pth(changed(**{"actor.latent_pi.2.weight": np.ones((4, 9), "f4")}))), None, "9 inputs"),
        "two actions": ((data, policy_pth(changed(**{"actor.mu.0.weight": np.ones((2, 4), "f4"),
                                                     "actor.mu.0.bias": np.ones(2, "f4")}))), None, "2 outputs"),
        "activation": (({**data, "policy_kwargs": {"activation_fn": "<class 'torch.nn.GELU'>"}}, good), None, "GELU"),
        "clip_mean no number": (({**data, "policy_kwargs": {"clip_mean": {}}}, good), None, "clip_mean"),
        "kwargs a text": (({**data, "policy_kwargs": "ReLU"}, good), None, "policy_kwargs of its member data"),
        "class a list": (({**data, "policy_class": [1]}, good), None, "policy_class of its member data"),
        "a long seed": (({**data, "seed": 10 ** 400}, good), None, "seed"),
        "a wide seed": (({**data, "seed": 2 ** 70}, good), None, "seed"),
        "seed a text": (({**data, "seed": "5"}, good), None, "seed"),
        "an endless seed": (('{"seed": Infinity}', good), None, "seed"),
        "alpha": ((data, good), ["--alpha", "nan"], "alpha"),
        "lines in a name": ((data, policy_pth(state, lambda p: p.replace(b"ctorch\nFloat", b"c\rt\x1b\nFloat"))), None,
                            "refers to"),
        "no rows": ((data, policy_pth(changed(**{"actor.latent_pi.0.weight": np.ones((0, 6), "f4"),
                                                 "actor.latent_pi.0.bias": np.ones(0, "f4")}))), None,
                    "none of them 0"),
        "a scalar": ((data, policy_pth(changed(**{"actor.latent_pi.0.weight": np.ones((), "f4")}))), None,
                     "[n, m]"),
        "clip_mean": (({**data, "policy_kwargs": {"clip_mean": 3.0}}, good), None, "clip_mean"),
        "preset": ((data, good), ["--preset", "circuit"], "8 observations"),
        "steps": ((data, good), ["--dt-min", "7s"], "--dt-min < --dt-max"),
    }
    with open("out.h5", "w", encoding="utf-8") as old:
        old.write("an older policy")
    for name, (content, options, want) in cases.items():
        if content is None:
            with open("in.zip", "w", encoding="utf-8") as f:
                f.write("no zip")
        else:
            write_zip("in.zip", *content)
        done = run("in.zip", "out.h5", *(options or []))
        assert done.returncode == 2, (name, done)
        assert want in done.stderr and done.stderr.count("\n") == 1, (name, done.stderr)
        with open("out.h5", encoding="utf-8") as old:
            assert old.read() == "an older policy", name
        assert sorted(os.listdir()) == ["in.zip", "out.h5"], name
    os.remove("out.h5")
    write_zip("in.zip", data, good)
    done = run("in.zip", "no/such/directory/out.h5")
    assert done.returncode == 2 and "cannot write" in done.stderr and done.stderr.count("\n") == 1
    assert run("absent.zip", "out.h5").returncode == 2


def test_published():
    """Weights read here with Python's own unpickler under a table of three names, then the same numbers."""
    with zipfile.ZipFile(PUBLISHED) as outer, zipfile.ZipFile(io.BytesIO(outer.read("policy.pth"))) as z:
        root = [n for n in z.namelist() if n.endswith("data.pkl")][0][: -len("data.pkl")]

        class Tensors(pickle.Unpickler):
            def persistent_load(self, pid):
                return np.frombuffer(z.read(f"{root}data/{pid[2]}"), "<f4")

            def find_class(self, module, name):
                return {"OrderedDict": collections.OrderedDict, "FloatStorage": None, "_rebuild_tensor_v2":
                        lambda s, offset, size, *_: s[offset: offset + int(np.prod(size))].reshape(size)}[name]

        state = Tensors(z.open(root + "data.pkl")).load()
    attributes, _ = imports(PUBLISHED, state, True)
    assert attributes["algorithm"] == "tqc" and attributes["training_steps"] == 20000


def main():
    tests = [test_algorithms, test_options, test_spaces, test_vecnormalize, test_broken, test_checksum, test_payloads,
             test_sizes, test_output]
    if os.path.exists(PUBLISHED):
        tests.append(test_published)
    else:
        print("the published zip is not here (../shared/published): only made-up ones are imported")
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for test in tests:
            test()
            print(f"ok {test.__name__}")


if __name__ == "__main__":
    main()
