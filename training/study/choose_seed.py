#!/usr/bin/env python3
"""Of trainings that differ by their seed alone, copy the policy of the best one: the highest mean return of an
evaluation.

    choose_seed.py OUT.h5 LOG.h5=POLICY.h5 [LOG.h5=POLICY.h5 ...]

The evaluations are those of the training itself, on random instances that no seed was trained on and that are no
evaluation mesh. Prints one line per seed and the spread, and says which was taken.
"""
import os
import shutil
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "..", "src", "package")]  # of an installed tree, and of the source
from slipstep.modules import need

need("h5py", "numpy")
import h5py
import numpy as np


class NoLog(Exception):
    """A file that is no learning curve with evaluations; the text says why."""


def best_evaluation(path):
    """Seed, and step, return, attempts and error of the best evaluation of one learning curve."""
    try:
        with h5py.File(path, "r") as file:
            columns = {name: file["evaluations/" + name][:] for name in ("step", "return", "length", "error")}
            seed = int(file.attrs["seed"])
    except (OSError, KeyError) as error:
        raise NoLog(f"{path}: {error}; expected a file of train -train_log") from None
    if not np.isfinite(columns["return"]).any():
        raise NoLog(f"{path} has no evaluation; train with -train_evaluate_interval")
    at = int(np.nanargmax(columns["return"]))
    return {"seed": seed, **{name: float(values[at]) for name, values in columns.items()}}


def main(arguments):
    if len(arguments) < 2 or not all("=" in pair for pair in arguments[1:]):
        sys.exit("choose_seed: expected OUT.h5 LOG.h5=POLICY.h5 ...")
    output, pairs = arguments[0], [pair.split("=", 1) for pair in arguments[1:]]
    try:
        found = [best_evaluation(log) for log, _ in pairs]
    except NoLog as error:
        sys.exit(f"choose_seed: {error}")
    chosen = max(range(len(found)), key=lambda k: found[k]["return"])
    name = os.path.basename(output)
    for k, row in enumerate(found):
        print(f"{name}  seed {row['seed']}: return {row['return']:.3f}, {row['length']:.1f} attempts, error "
              f"{100 * row['error']:.2f} % at step {row['step']:.0f}{'  taken' if k == chosen else ''}")
    returns = [row["return"] for row in found]
    if len(found) > 1:
        print(f"{name}  spread over {len(found)} seeds: {min(returns):.3f} to {max(returns):.3f}")
    try:
        shutil.copyfile(pairs[chosen][1], output + ".part")
        os.replace(output + ".part", output)
    except OSError as error:
        sys.exit(f"choose_seed: {error}")


if __name__ == "__main__":
    main(sys.argv[1:])
