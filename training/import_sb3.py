#!/usr/bin/env python3
"""Turn a Stable-Baselines3 zip (TQC, TD3 or SAC) into a SlipStep policy file, without torch.

    import_sb3.py IN.zip OUT.h5 [--preset fault|sliding_mode|circuit] [--dt-min STEP] [--dt-max STEP]

STEP is a number with a unit: seconds (6 or 6s), the problem's time scale (1e-6T*) or the simulated time (0.2t_max).
The circuit's policies observe states over their start: run them with -circuit_unit start. Before the first step
policies of sliding_mode and circuit are shown a last attempt other than the study's, the same as for every problem of
SlipStep. The zip's weights are read by an unpickler that builds tensors and nothing else: no code of the file is ever
run. Exit code 2 and one line on standard error when the zip does not hold such a policy; OUT.h5 is then left as it was.
"""
import argparse
import collections
import json
import os
import pickle
import re
import sys
import time
import zipfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "output")]  # of an installed tree, and of the source
from slipstep_modules import need

need("h5py", "numpy")
import h5py
import numpy as np

MAX_BYTES = 1 << 30  # of one member of the zip, unpacked

# What the study's environments observe, in their networks' order, and the steps they choose from. The circuit's states
# are over their own start there: run it with -circuit_unit start. Before the first step SlipStep shows every policy the
# same last attempt (residual 0.5, converged 0, accuracy 0, step -0.5, as the study's fault does), where the study's
# sliding mode begins with 1.005, 1, 1, 1 and its circuit with 1.005, 0, 0, 0.05: only the first step can differ.
LAST_ATTEMPT = ["residual", "converged", "accuracy", "step"]
PRESETS = {
    "fault": (["energy", "velocity"] + LAST_ATTEMPT, (1e-6, "T*"), (6.0, "s")),
    "sliding_mode": (["energy", "state_0"] + LAST_ATTEMPT, (1e-3, "s"), (2 * np.pi / 500, "s")),
    "circuit": (["energy", "state_2", "state_0", "state_1"] + LAST_ATTEMPT, (1e-3, "s"), (1.0, "s")),
}
ACTIVATIONS = {"ReLU": "relu", "Tanh": "tanh"}


class BadPolicy(Exception):
    """The zip holds no policy that can be imported; the text says why."""


class Storage:
    """Numbers of one tensor storage; stands in for torch's storage types while unpickling."""

    DTYPES = {"FloatStorage": "<f4", "DoubleStorage": "<f8", "LongStorage": "<i8", "IntStorage": "<i4"}


def rebuild_tensor(storage, offset, size, stride, *_unused):
    """torch._utils._rebuild_tensor_v2: a strided copy of a storage, bounds checked."""
    if len(size) != len(stride) or offset < 0 or any(n < 0 for n in size) or any(s < 0 for s in stride):
        raise BadPolicy("policy.pth has a tensor with impossible sizes")
    if 0 not in size and offset + sum((n - 1) * s for n, s in zip(size, stride)) >= storage.size:
        raise BadPolicy("policy.pth has a tensor larger than its data")
    item = storage.dtype.itemsize
    return np.lib.stride_tricks.as_strided(storage[offset:], size, [s * item for s in stride]).copy()


class TensorUnpickler(pickle.Unpickler):
    """Unpickles a state dict of tensors. Every global outside this table is refused, so nothing can be executed."""

    GLOBALS = {
        ("collections", "OrderedDict"): collections.OrderedDict,
        ("torch._utils", "_rebuild_tensor_v2"): rebuild_tensor,
        ("torch._utils", "_rebuild_parameter"): lambda data, *_unused: data,
        **{("torch", name): name for name in Storage.DTYPES},
    }

    def __init__(self, file, read_data):
        super().__init__(file)
        self.read_data = read_data

    def find_class(self, module, name):
        try:
            return self.GLOBALS[module, name]
        except KeyError:
            raise BadPolicy(f"policy.pth refers to {module}.{name}; expected tensors only") from None

    def persistent_load(self, pid):
        kind, storage, key, _device, count = pid
        if kind != "storage" or storage not in Storage.DTYPES:
            raise BadPolicy("policy.pth refers to something other than a tensor storage")
        values = np.frombuffer(self.read_data(str(key)), dtype=Storage.DTYPES[storage])
        if values.size < count:
            raise BadPolicy(f"policy.pth is truncated: data/{key} has {values.size} numbers, expected {count}")
        return values


def member(archive, name):
    """One unpacked member of a zip."""
    try:
        info = archive.getinfo(name)
    except KeyError:
        raise BadPolicy(f"it has no member {name}; expected a Stable-Baselines3 zip") from None
    if info.file_size > MAX_BYTES:
        raise BadPolicy(f"its member {name} unpacks to {info.file_size} bytes; expected less than {MAX_BYTES}")
    return archive.read(info)


def read_state_dict(archive):
    """The tensors of policy.pth by name."""
    with archive.open("policy.pth") if "policy.pth" in archive.namelist() else no_policy() as file:
        if not zipfile.is_zipfile(file):
            raise BadPolicy("its policy.pth is not a torch archive (zip format)")
        with zipfile.ZipFile(file) as tensors:
            root = [n[: -len("data.pkl")] for n in tensors.namelist() if n.endswith("data.pkl")]
            if len(root) != 1:
                raise BadPolicy("its policy.pth has no data.pkl")
            order = root[0] + "byteorder"
            if order in tensors.namelist() and tensors.read(order).strip() != b"little":
                raise BadPolicy("its policy.pth is not little-endian")
            with tensors.open(root[0] + "data.pkl") as pickled:
                state = TensorUnpickler(pickled, lambda key: member(tensors, f"{root[0]}data/{key}")).load()
    if not isinstance(state, dict) or not all(isinstance(v, np.ndarray) for v in state.values()):
        raise BadPolicy("its policy.pth does not hold a state dict of tensors")
    return state


def no_policy():
    raise BadPolicy("it has no member policy.pth; expected a Stable-Baselines3 zip")


def dense(state, prefix):
    """Weight and bias of one linear layer, checked."""
    try:
        weight, bias = state[prefix + ".weight"], state[prefix + ".bias"]
    except KeyError as missing:
        raise BadPolicy(f"its policy has no {missing.args[0]}") from None
    if weight.ndim != 2 or bias.shape != weight.shape[:1]:
        raise BadPolicy(f"{prefix} has weight {list(weight.shape)} and bias {list(bias.shape)}; "
                        "expected [n, m] and [n]")
    if not (np.isfinite(weight).all() and np.isfinite(bias).all()):
        raise BadPolicy(f"{prefix} has weights that are not finite")
    return weight, bias


def sequence(state, prefix):
    """Linear layers of a torch Sequential, in order: prefix.0, prefix.2, ..."""
    found = [re.fullmatch(re.escape(prefix) + r"\.(\d+)\.weight", name) for name in state]
    return [dense(state, f"{prefix}.{k}") for k in sorted(int(m.group(1)) for m in found if m)]


def algorithm_of(data, state):
    """TQC, TD3 or SAC, from the class of the policy, else from the shape of the networks."""
    module = str((data.get("policy_class") or {}).get("__module__", "")).lower()
    for name in ("tqc", "td3", "sac"):
        if f".{name}." in f".{module}.":
            return name
    if not any(name.startswith("actor.latent_pi.") for name in state):
        return "td3"
    last = max((n for n in state if re.fullmatch(r"critic\.qf0\.\d+\.weight", n)), default=None,
               key=lambda n: int(n.split(".")[2]))
    return "tqc" if last and state[last].shape[0] > 1 else "sac"


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
    kwargs = data.get("policy_kwargs") or {}
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
        if clipped and float(kwargs.get("clip_mean", 2.0)) != 2.0:
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
        with zipfile.ZipFile(path) as archive:
            data = json.loads(member(archive, "data"))
            if not isinstance(data, dict):
                raise BadPolicy("its member data is not a JSON object; expected a Stable-Baselines3 zip")
            return data, read_state_dict(archive)
    except BadPolicy:
        raise
    except OSError as error:
        raise BadPolicy(error.strerror or str(error)) from None
    except zipfile.BadZipFile as error:
        raise BadPolicy(f"not a zip, or a damaged one ({error})") from None
    except Exception as error:  # the unpickler meets damaged input with errors of many types
        raise BadPolicy(f"damaged ({type(error).__name__}: {error})") from None


def write_policy(path, layers, names, dt_min, dt_max, attributes):
    """The policy file that slippolicy.h describes, by way of path.part."""
    part = path + ".part"
    try:
        with h5py.File(part, "w") as file:
            file.attrs.update({"format": "slipstep-policy", "version": 1, **attributes})
            file["observation/names"] = np.array(names, dtype=h5py.string_dtype())
            file["observation/scale"] = np.ones(len(names))
            file["observation/offset"] = np.zeros(len(names))
            for k, (weight, bias, activation) in enumerate(layers):
                group = file.create_group(f"layers/{k}")
                group["weight"], group["bias"] = weight, bias
                group.attrs["activation"] = activation
            file.create_group("action").attrs.update({
                "low": -1.0, "high": 1.0, "squash": "tanh", "spacing": "linear",
                "dt_min": dt_min[0], "dt_min_unit": dt_min[1], "dt_max": dt_max[0], "dt_max_unit": dt_max[1]})
        os.replace(part, path)
    except OSError as error:
        if os.path.isfile(part):
            os.remove(part)
        raise BadPolicy(f"cannot write {path}: {error}") from None


def step(text):
    """A step with its unit: 6, 6s, 1e-6T*, 0.2t_max."""
    for unit in ("t_max", "T*", "s", ""):
        if text.endswith(unit):
            value = float(text[: len(text) - len(unit)])
            if not 0 <= value < float("inf"):
                raise ValueError(text)
            return value, unit or "s"
    raise ValueError(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("zip", metavar="IN.zip", help="what model.save() of Stable-Baselines3 wrote")
    parser.add_argument("output", metavar="OUT.h5", help="policy file to write")
    parser.add_argument("--preset", choices=sorted(PRESETS), default="fault", help="observations and steps (fault)")
    parser.add_argument("--dt-min", type=step, metavar="STEP", help="smallest step (fault: 1e-6T*)")
    parser.add_argument("--dt-max", type=step, metavar="STEP", help="largest step (fault: 6s)")
    parser.add_argument("--alpha", type=float, help="weight of the error in the reward, noted in the file")
    args = parser.parse_args()
    names, dt_min, dt_max = PRESETS[args.preset]
    dt_min, dt_max = args.dt_min or dt_min, args.dt_max or dt_max
    try:
        if dt_max[0] <= 0 or (dt_min[1] == dt_max[1] and dt_min[0] >= dt_max[0]):
            raise BadPolicy(f"steps from {dt_min[0]:g} {dt_min[1]} to {dt_max[0]:g} {dt_max[1]}; "
                            "expected --dt-min < --dt-max")
        data, state = read_zip(args.zip)
        algorithm, layers = actor_layers(data, state)
        check_shapes(layers, names)
        attributes = {"algorithm": algorithm, "problem": args.preset, "library_version": "imported by import_sb3.py",
                      "created": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())}
        for name, value in {"alpha": args.alpha, "training_steps": data.get("num_timesteps"),
                            "seed": data.get("seed")}.items():
            if isinstance(value, (int, float)):
                attributes[name] = value
        write_policy(args.output, layers, names, dt_min, dt_max, attributes)
    except BadPolicy as error:
        print(f"import_sb3: {args.zip}: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
