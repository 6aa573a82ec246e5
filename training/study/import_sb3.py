#!/usr/bin/env python3
"""Turn a Stable-Baselines3 zip (TQC, TD3 or SAC) into a SlipStep policy file, without torch.

    import_sb3.py IN.zip OUT.h5 [--preset fault|sliding_mode|circuit] [--dt-min S] [--dt-max S] [--vecnormalize F.pkl]

S is a number with a unit: seconds (6 or 6s), the problem's time scale (1e-6T*) or the simulated time (0.2t_max).
The circuit's policies observe states over their start: run them with -circuit_unit start. Before the first step
policies of sliding_mode and circuit are shown a last attempt other than the study's. The spaces that the zip names must
be the preset's: so many observations, and one action from 0 to 1 or -1 to 1, a share of the way from the smallest step
to the largest. Of an action with other bounds only --dt-min and --dt-max together say which steps they mean.
--vecnormalize takes the file that VecNormalize.save() wrote, and its means and variances become offset and scale of the
policy file; its clipping of observations is left out. No code of the zip is ever run. Exit code 2 and one line on
standard error when the zip does not hold such a policy; OUT.h5 is then left as it was."""
import argparse
import collections
import io
import json
import math
import os
import pickle
import pickletools
import re
import struct
import sys
import time
import zipfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "..", "src", "package")]  # of an installed tree, and of the source
from slipstep.modules import need

need("h5py", "numpy")
import h5py
import numpy as np

# Bounds on what is read, checked before it is: the study's zips have 0.4 MB, their data.pkl 5 kB, their data 11 kB.
MAX_TOTAL = 1 << 27  # bytes of the zip, and of all that is unpacked from it
MAX_DATA = 1 << 23  # of the member data
MAX_PICKLE = 1 << 20  # of data.pkl
MAX_WORD = 64  # of byteorder
MAX_MEMBERS = 10000
MAX_WHOLE = 1 << 53  # integers up to here are doubles

# What the study's environments observe, in their networks' order, and their steps. Before the first its sliding mode
# has 1.005, 1, 1, 1 as the last attempt, its circuit 1.005, 0, 0, 0.05, and SlipStep 0.5, 0, 0, -0.5.
LAST_ATTEMPT = ["residual", "converged", "accuracy", "step"]
PRESETS = {
    "fault": (["energy", "velocity"] + LAST_ATTEMPT, (1e-6, "T*"), (6.0, "s")),
    "sliding_mode": (["energy", "state_0"] + LAST_ATTEMPT, (1e-3, "s"), (2 * np.pi / 500, "s")),
    "circuit": (["energy", "state_2", "state_0", "state_1"] + LAST_ATTEMPT, (1e-3, "s"), (1.0, "s")),
}
ACTIVATIONS = {"ReLU": "relu", "Tanh": "tanh"}


class BadPolicy(Exception):
    """The zip holds no policy that can be imported; the text says why."""


class Budget:
    """How many bytes of the zip may still be unpacked: a small file can unpack to terabytes."""

    def __init__(self, left=MAX_TOTAL):
        self.left = left

    def spend(self, count, what):
        if count > self.left:
            raise BadPolicy(f"{what} would take {count} bytes more; expected less than {MAX_TOTAL} in all")
        self.left -= count


def open_zip(content, what):
    """A zip in memory; its directory is bounded before it is read."""
    if content.count(b"PK\1\2") > MAX_MEMBERS:
        raise BadPolicy(f"{what} has more than {MAX_MEMBERS} members")
    return zipfile.ZipFile(io.BytesIO(content))


def member(archive, name, limit, budget):
    """One unpacked member of a zip, at most limit bytes. Other methods than these unpack without a bound."""
    try:
        info = archive.getinfo(name)
    except KeyError:
        raise BadPolicy(f"it has no member {name}; expected a Stable-Baselines3 zip") from None
    if info.file_size > limit:
        raise BadPolicy(f"its member {name} unpacks to {info.file_size} bytes; expected at most {limit}")
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise BadPolicy(f"its member {name} is compressed by method {info.compress_type}; expected stored or deflated")
    budget.spend(info.file_size, f"its member {name}")
    return archive.read(info)


# ---- the pickle of a state dict: dictionaries, tuples and tensors. Nothing else is built, and nothing is called ----

DTYPES = {"FloatStorage": "<f4", "DoubleStorage": "<f8", "LongStorage": "<i8", "IntStorage": "<i4"}
GLOBALS = {("collections", "OrderedDict"), ("torch._utils", "_rebuild_tensor_v2"),
           ("torch._utils", "_rebuild_parameter"), *(("torch", name) for name in DTYPES)}
Global = collections.namedtuple("Global", "module name")
CONSTANTS = {"NONE": lambda: None, "NEWTRUE": lambda: True, "NEWFALSE": lambda: False, "EMPTY_DICT": dict,
             "EMPTY_TUPLE": tuple, "EMPTY_LIST": list}
LITERALS = {"BININT", "BININT1", "BININT2", "LONG1", "BINFLOAT", "BINUNICODE", "SHORT_BINUNICODE"}
TUPLES = {"TUPLE1": 1, "TUPLE2": 2, "TUPLE3": 3}


class Tensors:
    """The machine that a pickle is a program of, as far as state dicts need it. read(key, limit) gets a storage."""

    def __init__(self, read, budget):
        self.read, self.budget, self.storages = read, budget, {}
        self.stack, self.marks, self.memo = [], [], {}

    def pop(self, count):
        """The uppermost entries of the stack, in order."""
        if count > len(self.stack):
            raise BadPolicy("policy.pth has a pickle that takes more than it gave")
        taken = self.stack[len(self.stack) - count:]
        del self.stack[len(self.stack) - count:]
        return taken

    def pop_to_mark(self):
        return self.pop(len(self.stack) - self.marks.pop())

    def set_items(self, items):
        into = self.stack[-1]
        # Nothing else is hashed: a deeply nested tuple would overflow the interpreter's stack.
        if not isinstance(into, dict) or len(items) % 2 or not all(isinstance(key, str) for key in items[::2]):
            raise BadPolicy("policy.pth has a dictionary whose keys are not names")
        into.update(zip(items[::2], items[1::2]))

    def find(self, module, name):
        if not isinstance(module, str) or not isinstance(name, str) or (module, name) not in GLOBALS:
            raise BadPolicy(f"policy.pth refers to {module}.{name}; expected tensors only")
        self.stack.append(Global(module, name))

    def storage(self, pid):
        """The numbers of one storage."""
        if not isinstance(pid, tuple) or len(pid) != 5 or pid[0] != "storage" or not isinstance(pid[1], Global) \
                or pid[1].name not in DTYPES or not isinstance(pid[2], str) or not isinstance(pid[4], int):
            raise BadPolicy("policy.pth refers to something other than a tensor storage")
        key, count = pid[2], pid[4]
        if key not in self.storages:
            self.storages[key] = self.read(key)
        dtype = np.dtype(DTYPES[pid[1].name])
        if not 0 <= count * dtype.itemsize <= len(self.storages[key]):
            raise BadPolicy(f"policy.pth is truncated: data/{key} has {len(self.storages[key])} bytes, expected "
                            f"{count} numbers")
        return np.frombuffer(self.storages[key], dtype, count)

    def tensor(self, storage, offset, size, stride, *_unused):
        """torch._utils._rebuild_tensor_v2: a strided copy of a storage, bounds checked."""
        if not isinstance(storage, np.ndarray) or not isinstance(size, tuple) or not isinstance(stride, tuple) \
                or not all(isinstance(n, int) and n >= 0 for n in (offset, *size, *stride)) \
                or len(size) != len(stride) or len(size) > 8:
            raise BadPolicy("policy.pth has a tensor with impossible sizes")
        if 0 not in size and offset + sum((n - 1) * s for n, s in zip(size, stride)) >= storage.size:
            raise BadPolicy("policy.pth has a tensor larger than its data")
        item = storage.dtype.itemsize
        self.budget.spend(math.prod(size) * item, "a tensor of policy.pth")  # strides of 0 repeat numbers
        if 0 in size:
            return np.zeros(size, storage.dtype)
        return np.lib.stride_tricks.as_strided(storage[offset:], size, [s * item for s in stride]).copy()

    def reduce(self, what, arguments):
        if not isinstance(what, Global) or not isinstance(arguments, tuple):
            raise BadPolicy("policy.pth calls something; expected tensors only")
        if what.name == "OrderedDict" and not arguments:
            return {}
        if what.name == "_rebuild_parameter" and arguments:
            return arguments[0]
        if what.name == "_rebuild_tensor_v2" and len(arguments) >= 4:
            return self.tensor(*arguments)
        raise BadPolicy(f"policy.pth calls {what.module}.{what.name} otherwise than torch does")

    def run(self, content):
        """What the pickle stands for."""
        for op, argument, _ in pickletools.genops(content):
            if op.name == "STOP":
                return self.pop(1)[0]
            if op.name in CONSTANTS:
                self.stack.append(CONSTANTS[op.name]())
            elif op.name in LITERALS:
                self.stack.append(argument)
            elif op.name == "MARK":
                self.marks.append(len(self.stack))
            elif op.name == "TUPLE":
                self.stack.append(tuple(self.pop_to_mark()))
            elif op.name in TUPLES:
                self.stack.append(tuple(self.pop(TUPLES[op.name])))
            elif op.name in ("SETITEM", "SETITEMS"):
                self.set_items(self.pop(2) if op.name == "SETITEM" else self.pop_to_mark())
            elif op.name in ("BINPUT", "LONG_BINPUT", "MEMOIZE"):
                self.memo[len(self.memo) if argument is None else argument] = self.stack[-1]
            elif op.name in ("BINGET", "LONG_BINGET"):
                self.stack.append(self.memo[argument])
            elif op.name in ("GLOBAL", "STACK_GLOBAL"):
                self.find(*(self.pop(2) if argument is None else argument.split(" ", 1)))
            elif op.name == "BINPERSID":
                self.stack.append(self.storage(self.pop(1)[0]))
            elif op.name == "REDUCE":
                self.stack.append(self.reduce(*self.pop(2)))
            elif op.name == "BUILD":
                self.pop(1)  # a state dict's _metadata
            elif op.name not in ("PROTO", "FRAME"):
                raise BadPolicy(f"policy.pth has the pickle operation {op.name}; expected tensors only")
        raise BadPolicy("policy.pth has a pickle without an end")


def read_state_dict(archive, budget):
    """The tensors of policy.pth by name."""
    content = member(archive, "policy.pth", MAX_TOTAL, budget)
    if not zipfile.is_zipfile(io.BytesIO(content)):
        raise BadPolicy("its policy.pth is not a torch archive (zip format)")
    with open_zip(content, "its policy.pth") as tensors:
        root = [n[: -len("data.pkl")] for n in tensors.namelist() if n.endswith("data.pkl")]
        if len(root) != 1:
            raise BadPolicy("its policy.pth has no data.pkl")
        order = root[0] + "byteorder"
        if order in tensors.namelist() and member(tensors, order, MAX_WORD, budget).strip() != b"little":
            raise BadPolicy("its policy.pth is not little-endian")
        pickled = member(tensors, root[0] + "data.pkl", MAX_PICKLE, budget)
        state = Tensors(lambda key: member(tensors, f"{root[0]}data/{key}", MAX_TOTAL, budget), budget).run(pickled)
    if not isinstance(state, dict) or not all(isinstance(v, np.ndarray) for v in state.values()):
        raise BadPolicy("its policy.pth does not hold a state dict of tensors")
    return state


def dense(state, prefix):
    """Weight and bias of one linear layer, checked."""
    try:
        weight, bias = state[prefix + ".weight"], state[prefix + ".bias"]
    except KeyError as missing:
        raise BadPolicy(f"its policy has no {missing.args[0]}") from None
    if weight.ndim != 2 or bias.shape != weight.shape[:1] or not weight.size:
        raise BadPolicy(f"{prefix} has weight {list(weight.shape)} and bias {list(bias.shape)}; "
                        "expected [n, m] and [n], none of them 0")
    if not (np.isfinite(weight).all() and np.isfinite(bias).all()):
        raise BadPolicy(f"{prefix} has weights that are not finite")
    return weight, bias


def sequence(state, prefix):
    """Linear layers of a torch Sequential, in order: prefix.0, prefix.2, ..."""
    found = [re.fullmatch(re.escape(prefix) + r"\.(\d{1,9})\.weight", name) for name in state]
    return [dense(state, f"{prefix}.{k}") for k in sorted(int(m.group(1)) for m in found if m)]


def dictionary(data, name):
    """An entry of the zip's data that is a dictionary, or nothing."""
    value = data.get(name) or {}
    if not isinstance(value, dict):
        raise BadPolicy(f"{name} of its member data is not a JSON object")
    return value


def algorithm_of(data, state):
    """TQC, TD3 or SAC, from the class of the policy, else from the shape of the networks."""
    module = str(dictionary(data, "policy_class").get("__module__", "")).lower()
    for name in ("tqc", "td3", "sac"):
        if f".{name}." in f".{module}.":
            return name
    if not any(name.startswith("actor.latent_pi.") for name in state):
        return "td3"
    last = max((n for n in state if re.fullmatch(r"critic\.qf0\.\d{1,9}\.weight", n)), default=None,
               key=lambda n: int(n.split(".")[2]))
    return "tqc" if last and state[last].ndim and state[last].shape[0] > 1 else "sac"


def hidden_activation(kwargs):
    """Activation of the hidden layers; Stable-Baselines3's default for these algorithms is ReLU."""
    text = str(kwargs.get("activation_fn", "ReLU"))
    name = re.search(r"(\w+)\W*$", text)
    if not name or name.group(1) not in ACTIVATIONS:
        raise BadPolicy(f"its activation_fn is {text}; expected ReLU or Tanh")
    return ACTIVATIONS[name.group(1)]


def actor_layers(data, state):
    """(algorithm, [(weight, bias, activation)]) of the deterministic policy; a tanh follows in all three."""
    algorithm = algorithm_of(data, state)
    kwargs = dictionary(data, "policy_kwargs")
    hidden = hidden_activation(kwargs)
    if not any(name.startswith("actor.") for name in state):
        raise BadPolicy("it holds no actor; expected TQC, TD3 or SAC")
    if algorithm == "td3":
        layers = sequence(state, "actor.mu")
        if not layers:
            raise BadPolicy("its policy has no actor.mu.0.weight")
        last = "linear"
    else:
        # gSDE wraps the mean head in a Hardtanh(-clip_mean, clip_mean), which shows in the name of its parameters.
        clipped = "actor.mu.0.weight" in state
        layers = sequence(state, "actor.latent_pi") + [dense(state, "actor.mu.0" if clipped else "actor.mu")]
        last = "hardtanh2" if clipped else "linear"
        if clipped and kwargs.get("clip_mean", 2.0) != 2:
            raise BadPolicy(f"its clip_mean is {kwargs['clip_mean']}; expected 2")
    return algorithm, [(w, b, hidden) for w, b in layers[:-1]] + [(*layers[-1], last)]


def check_shapes(layers, names):
    """The network maps len(names) observations to one action."""
    width = len(names)
    for k, (weight, _bias, _activation) in enumerate(layers):
        if weight.shape[1] != width:
            what = f"{width} outputs before it" if k else f"{width} observations of the preset ({', '.join(names)})"
            raise BadPolicy(f"layer {k} of its actor has {weight.shape[1]} inputs; expected the {what}")
        width = weight.shape[0]
    if width != 1:
        raise BadPolicy(f"its actor has {width} outputs; expected 1")


def read_zip(path):
    """(data, state dict) of a Stable-Baselines3 zip."""
    try:
        if os.path.exists(path) and not os.path.isfile(path):
            raise BadPolicy("not a file")
        if os.path.getsize(path) > MAX_TOTAL:
            raise BadPolicy(f"it has {os.path.getsize(path)} bytes; expected at most {MAX_TOTAL}")
        with open(path, "rb") as file:
            content = file.read(MAX_TOTAL)
        budget = Budget()
        with open_zip(content, "it") as archive:
            data = json.loads(member(archive, "data", MAX_DATA, budget))
            if not isinstance(data, dict):
                raise BadPolicy("its member data is not a JSON object; expected a Stable-Baselines3 zip")
            return data, read_state_dict(archive, budget)
    except BadPolicy:
        raise
    except OSError as error:
        raise BadPolicy(error.strerror or str(error)) from None
    except zipfile.BadZipFile as error:
        raise BadPolicy(f"not a zip, or a damaged one ({error})") from None
    except Exception as error:  # zipfile, json and pickletools meet damaged input with errors of many types
        raise BadPolicy(f"damaged ({type(error).__name__}: {error})") from None


# ---- spaces, and normalised observations ----

def box(data, name, width):
    """Least and largest of a space, or None where the zip does not say; refused unless it is a Box [width]."""
    space = dictionary(data, name)
    if not space:
        return None
    kind = re.search(r"(\w+)'?>?$", str(space.get(":type:", "Box")))
    if not kind or kind.group(1) != "Box":
        raise BadPolicy(f"its {name} is {space[':type:']}; expected a Box of {width}")
    shape = space.get("_shape", space.get("shape", [width]))
    if re.findall(r"\d+", str(shape)) != [str(width)]:
        raise BadPolicy(f"its {name} has the shape {shape}; expected [{width}]")
    ends = []
    for end in ("low", "high"):
        text = str(space.get(end, ""))
        try:
            ends.append([float(word) for word in text.strip("[] ").split()])
        except ValueError:
            raise BadPolicy(f"its {name} has {end} = {text}; expected {width} numbers") from None
    return ends if all(len(numbers) == width for numbers in ends) else None


def check_spaces(data, names, both_steps):
    """The preset's observations, and an action that is a share of the range of steps."""
    box(data, "observation_space", len(names))
    action = box(data, "action_space", 1)
    if action is None:
        return
    (low,), (high,) = action
    if not low < high or math.isinf(low) or math.isinf(high):
        raise BadPolicy(f"its action_space is from {low:g} to {high:g}; expected two finite bounds, in order")
    if (low, high) not in ((0, 1), (-1, 1)) and not both_steps:
        raise BadPolicy(f"its action_space is from {low:g} to {high:g}, where the preset's is a share, from 0 to 1 "
                        "or -1 to 1; expected --dt-min and --dt-max, the steps that these bounds mean")


class Thing:
    """What stands for every class and function that a pickle names: none is looked up, and nothing of the file runs."""

    def __new__(cls, *_arguments, **_named):
        return object.__new__(cls)

    def __init__(self, *arguments, **_named):
        self.arguments, self.state = arguments, None

    def __setstate__(self, state):
        self.state = state

    def __setitem__(self, _key, _value):
        pass

    def append(self, _value):
        pass

    extend = add = append


class Things(pickle.Unpickler):
    def find_class(self, module, name):
        return type(name if isinstance(name, str) and name.isidentifier() else "Thing", (Thing,), {})


def numbers_of(thing, what, width):
    """[width] doubles of a pickled array of NumPy's."""
    content, dtype = None, None
    if type(thing).__name__ == "_reconstruct" and isinstance(thing.state, tuple) and len(thing.state) == 5:
        content, dtype = thing.state[4], thing.state[2]
    elif type(thing).__name__ == "_frombuffer" and len(thing.arguments) == 4:
        content, dtype = thing.arguments[0], thing.arguments[1]
    if type(content).__name__ == "encode" and len(content.arguments) == 2 and isinstance(content.arguments[0], str):
        content = content.arguments[0].encode("latin1")  # bytes as protocol 2 has them
    kind = dtype.arguments[0] if isinstance(dtype, Thing) and dtype.arguments else None
    order = (dtype.state[1] if isinstance(dtype, Thing) and isinstance(dtype.state, tuple) and len(dtype.state) > 1
             else "<")
    if not isinstance(content, (bytes, bytearray)) or kind not in ("f8", "f4") or order not in ("<", "=", "|"):
        raise BadPolicy(f"{what} is no array of numbers")
    item = int(kind[1])
    if len(content) != width * item:
        raise BadPolicy(f"{what} has {len(content) // item} numbers; expected {width}, one an observation")
    found = np.frombuffer(content, "<" + kind).astype(float)
    if not np.isfinite(found).all():
        raise BadPolicy(f"{what} has numbers that are not finite")
    return found


def read_vecnormalize(path, width):
    """(scale, offset, clip) by which VecNormalize shows observations: clip((x - mean)/sqrt(var + epsilon))."""
    try:
        if os.path.getsize(path) > MAX_DATA:
            raise BadPolicy(f"{path} has {os.path.getsize(path)} bytes; expected at most {MAX_DATA}")
        with open(path, "rb") as file:
            saved = Things(io.BytesIO(file.read(MAX_DATA))).load()
        state = saved.state if type(saved).__name__ == "VecNormalize" else None
        if not isinstance(state, dict):
            raise BadPolicy(f"{path} holds no VecNormalize; expected the file of its save()")
        if state.get("norm_obs") is False:
            return np.ones(width), np.zeros(width), math.inf
        rms = state.get("obs_rms")
        if not isinstance(rms, Thing) or not isinstance(rms.state, dict):
            raise BadPolicy(f"the obs_rms of {path} is not that of one array of observations")
        mean = numbers_of(rms.state.get("mean"), f"the mean in {path}", width)
        variance = numbers_of(rms.state.get("var"), f"the var in {path}", width)
        epsilon, clip = state.get("epsilon", 1e-8), state.get("clip_obs", math.inf)
        if (not all(isinstance(x, (int, float)) and x >= 0 for x in (epsilon, clip))
            or not (variance + epsilon > 0).all()):
            raise BadPolicy(f"{path} has epsilon {epsilon}, clip_obs {clip} and a variance down to {variance.min():g}; "
                            "expected positive numbers")
        scale = 1 / np.sqrt(variance + epsilon)
        return scale, -mean * scale, clip
    except BadPolicy:
        raise
    except OSError as error:
        raise BadPolicy(f"{path}: {error.strerror or error}") from None
    except Exception as error:  # pickle meets damaged input with errors of many types
        raise BadPolicy(f"{path} is damaged, or no pickle ({type(error).__name__}: {error})") from None


def notes(data, alpha):
    """Numbers of the training, for the file's attributes."""
    found = {"alpha": alpha, "training_steps": data.get("num_timesteps"), "seed": data.get("seed")}
    for name, value in found.items():
        if value is not None and (not isinstance(value, (int, float)) or isinstance(value, bool)
                                  or not abs(value) <= MAX_WHOLE):
            raise BadPolicy(f"its {name} is no number up to {MAX_WHOLE}")
    return {name: value for name, value in found.items() if value is not None}


def checksum(file):
    """SlipPolicyGetHash() of an open policy file (src/policy/policypack.c): FNV-1a of its content as bytes."""
    content = bytearray()

    def integers(*values):
        content.extend(struct.pack(f"={len(values)}q", *values))

    def reals(values):
        content.extend(np.ascontiguousarray(values, "=f8").tobytes())

    def plain(value):  # h5py gives strings of fixed length as bytes
        return value.decode() if isinstance(value, bytes) else value

    def text(value):
        value = plain(value)
        if not isinstance(value, str):
            short = "%.15g" % (value + 0.0)
            value = short if float(short) == value else "%.17g" % value
        integers(len(value.encode()) + 1)
        content.extend(value.encode() + b"\0")

    names, action, own = file["observation/names"][:], file["action"].attrs, ("format", "version", "checksum")
    integers(len(names))
    for name in names:
        text(name)
    reals(file["observation/scale"])
    reals(file["observation/offset"])
    integers("range" in file)
    if "range" in file:
        reals(file["range/minimum"])
        reals(file["range/maximum"])
    integers(len(file["layers"]))
    for k in range(len(file["layers"])):
        layer = file[f"layers/{k}"]
        activations = ["linear", "relu", "tanh", "hardtanh2"]
        integers(*layer["weight"].shape[::-1], activations.index(plain(layer.attrs["activation"])))
        reals(layer["weight"])
        reals(layer["bias"])
    integers(1)
    reals([action[name] for name in ("low", "high", "dt_min", "dt_max")])
    integers(*(["s", "T*", "t_max", "h"].index(plain(action[name])) for name in ("dt_min_unit", "dt_max_unit")))
    integers(plain(action.get("spacing", "linear")) == "log")
    attributes = sorted((name.encode(), name) for name in file.attrs if name not in own)
    integers(len(attributes))
    for _, name in attributes:
        text(name)
        text(file.attrs[name])
    hash_ = 0xCBF29CE484222325
    for byte in content:
        hash_ = (hash_ ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return f"{hash_:016x}"


def write_policy(path, layers, names, scale, offset, dt_min, dt_max, attributes):
    """The policy file that slippolicy.h describes, by way of a file of this process; links are followed."""
    target = os.path.realpath(path)
    part = f"{target}.{os.getpid()}.part"
    try:
        if os.path.exists(target) and not os.path.isfile(target):
            raise BadPolicy(f"cannot write {path}: it is there and not a file")
        with h5py.File(part, "x") as file:
            file.attrs.update({"format": "slipstep-policy", "version": 1, **attributes})
            file["observation/names"] = np.array(names, dtype=h5py.string_dtype())
            file["observation/scale"] = scale
            file["observation/offset"] = offset
            for k, (weight, bias, activation) in enumerate(layers):
                group = file.create_group(f"layers/{k}")
                group["weight"], group["bias"] = weight, bias
                group.attrs["activation"] = activation
            file.create_group("action").attrs.update({
                "low": -1.0, "high": 1.0, "squash": "tanh", "spacing": "linear",
                "dt_min": dt_min[0], "dt_min_unit": dt_min[1], "dt_max": dt_max[0], "dt_max_unit": dt_max[1]})
            file.attrs["checksum"] = checksum(file)
        os.replace(part, target)
    except BadPolicy:
        raise
    except Exception as error:  # h5py meets a full disk with errors of several types
        raise BadPolicy(f"cannot write {path}: {error}") from None
    finally:
        if os.path.isfile(part):
            os.remove(part)


def step(text):
    """A step with its unit: 6, 6s, 1e-6T*, 0.2t_max."""
    for unit in ("t_max", "T*", "s", ""):
        if text.endswith(unit):
            value = float(text[: len(text) - len(unit)])
            if not 0 <= value < float("inf"):
                raise ValueError(text)
            return value, unit or "s"
    raise ValueError(text)


def import_zip(args):
    names, dt_min, dt_max = PRESETS[args.preset]
    dt_min, dt_max = args.dt_min or dt_min, args.dt_max or dt_max
    if dt_max[0] <= 0 or (dt_min[1] == dt_max[1] and dt_min[0] >= dt_max[0]):
        raise BadPolicy(f"steps from {dt_min[0]:g} {dt_min[1]} to {dt_max[0]:g} {dt_max[1]}; "
                        "expected --dt-min < --dt-max")
    data, state = read_zip(args.zip)
    if os.path.exists(args.output) and os.path.samefile(args.zip, args.output):
        raise BadPolicy("it is the output as well; expected another OUT.h5")
    algorithm, layers = actor_layers(data, state)
    check_spaces(data, names, args.dt_min and args.dt_max)
    check_shapes(layers, names)
    scale, offset, clip = np.ones(len(names)), np.zeros(len(names)), math.inf
    if args.vecnormalize:
        scale, offset, clip = read_vecnormalize(args.vecnormalize, len(names))
    write_policy(args.output, layers, names, scale, offset, dt_min, dt_max, {
        "algorithm": algorithm, "problem": args.preset, "library_version": "imported by import_sb3.py",
        "created": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()), **notes(data, args.alpha)})
    if clip < math.inf:
        print(f"{args.output}: observations are normalised as in {args.vecnormalize}, but not clipped at {clip:g}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("zip", metavar="IN.zip", help="zip file written by model.save() of Stable-Baselines3")
    parser.add_argument("output", metavar="OUT.h5", help="policy file to write")
    parser.add_argument("--preset", choices=sorted(PRESETS), default="fault", help="observations and steps (fault)")
    parser.add_argument("--dt-min", type=step, metavar="STEP", help="smallest step (fault: 1e-6T*)")
    parser.add_argument("--dt-max", type=step, metavar="STEP", help="largest step (fault: 6s)")
    parser.add_argument("--vecnormalize", metavar="F.pkl", help="file of VecNormalize.save() of the policy's training")
    parser.add_argument("--alpha", type=float, help="weight of the error in the reward, written to the file")
    args = parser.parse_args()
    try:
        import_zip(args)
    except BadPolicy as error:
        # Names of the zip may hold anything: one line, and only what a terminal shows.
        text = str(error).encode("unicode_escape").decode()
        print(f"import_sb3: {args.zip}: {text[:500]}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
