"""Plot learning curves: what training episodes and evaluations of the policy without noise returned, their steps and
errors.

    slipstep plot-training LOG.h5 [LOG.h5 ...] [--figure OUT.png]

LOG.h5 are files of `train -train_log`, of one problem and one reward. Trainings that differ by their seed alone share a
colour; the thick line is their mean.
"""

import argparse
import os

import numpy as np
from ..errors import OutputError
from ..plots.panels import log_scale, plt, save, use_style
from ..results.files import attributes, open_file

WINDOW = 50  # episodes in a running mean
COLUMNS = {"episodes": ("step", "return", "length"), "evaluations": ("step", "return", "length", "error")}
DEFAULTS = {"algorithm": "tqc", "alpha": 1, "problem": "fault", "reward": "published", "error": "error"}


class Log:
    """One file of -train_log: attributes and columns, checked."""

    def __init__(self, path):
        self.path = path
        with open_file(path, "train -train_log writes it") as file:
            self.attributes = DEFAULTS | attributes(file)
            for group, columns in COLUMNS.items():
                missing = [name for name in columns if f"{group}/{name}" not in file]
                if missing:
                    raise OutputError(f"{path}: no dataset /{group}/{missing[0]}; expected a file of train -train_log")
                setattr(self, group, {name: file[f"{group}/{name}"][:] for name in columns})
        if not len(self.episodes["step"]):
            raise OutputError(f"{path}: no episode; the training ended before its first one did")

    @property
    def label(self):
        """What the trainings of one colour have in common."""
        return f"{self.attributes['algorithm']}, alpha {float(self.attributes['alpha']):g}"

    @property
    def task(self):
        return self.attributes["problem"], self.attributes["reward"]


def read_logs(paths):
    logs = [Log(path) for path in paths]
    for log in logs[1:]:
        if log.task != logs[0].task:
            raise OutputError(f"{log.path} is of problem {log.task[0]} and reward {log.task[1]}, {logs[0].path} of "
                              f"{logs[0].task[0]} and {logs[0].task[1]}; expected one of each")
    return logs


def groups(logs):
    """Logs by label, ordered by algorithm and alpha."""
    ordered = sorted(logs, key=lambda log: (log.attributes["algorithm"], float(log.attributes["alpha"])))
    labels = list(dict.fromkeys(log.label for log in ordered))
    return {label: [log for log in ordered if log.label == label] for label in labels}


def running_mean(x, y):
    """Means of WINDOW neighbours; fewer where there are not that many."""
    width = max(1, min(WINDOW, len(x) // 4))
    weights = np.ones(width) / width
    return np.convolve(x, weights, "valid"), np.convolve(y, weights, "valid")


def draw_group(axes, curves, color, label):
    """Every curve thin; their mean thick over the steps that all have, when there are several."""
    alone = len(curves) == 1
    for x, y in curves:
        axes.plot(x, y, color=color, linewidth=1.8 if alone else 0.8, alpha=1 if alone else 0.45,
                  label=label if alone else None)
    if alone:
        return
    steps = np.unique(np.concatenate([x for x, _ in curves]))
    steps = steps[(steps >= max(x[0] for x, _ in curves)) & (steps <= min(x[-1] for x, _ in curves))]
    mean = np.mean([np.interp(steps, x, y) for x, y in curves], axis=0)
    axes.plot(steps, mean, color=color, linewidth=2.2, label=f"{label} ({len(curves)} seeds)")


def colors(names):
    """Dark to light within an algorithm, other hues for the next one."""
    maps = {"tqc": plt.cm.viridis, "td3": plt.cm.autumn}
    shades = {}
    for algorithm in dict.fromkeys(name.split(",")[0] for name in names):
        of = [name for name in names if name.startswith(algorithm + ",")]
        for name, shade in zip(of, np.linspace(0.0, 0.88 if len(of) > 1 else 0, len(of))):
            shades[name] = maps.get(algorithm, plt.cm.cool)(shade)
    return shades


def figure(logs):
    use_style()
    by_label = groups(logs)
    many = len(by_label) > 4  # then the legend gets a row of its own
    canvas = plt.figure(figsize=(11, 8.4 if many else 7.6), layout="constrained")
    grid = canvas.add_gridspec(2 + many, 2, height_ratios=[1, 1] + [0.2] * many)
    training, returns, length, error = (canvas.add_subplot(grid[i, k]) for i in range(2) for k in range(2))
    shades = colors(list(by_label))
    for label, members in by_label.items():
        color = shades[label]
        draw_group(training, [running_mean(log.episodes["step"], log.episodes["return"]) for log in members], color,
                   label)
        evaluated = [log.evaluations for log in members if len(log.evaluations["step"])]
        if not evaluated:
            continue
        for axes, column, scale in ((returns, "return", 1), (length, "length", 1), (error, "error", 100)):
            draw_group(axes, [(e["step"], scale * e[column]) for e in evaluated], color, label)
    training.set(title="Training episodes", ylabel=f"return (running mean of {WINDOW})")
    returns.set(title="Evaluations without noise", ylabel="mean return")
    length.set(title="Steps of an evaluated run", ylabel="mean number of attempts")
    error.set(title="Error of an evaluated run", ylabel=f"{logs[0].attributes['error']}: mean error (%)")
    for axes in (training, returns, length, error):
        axes.set_xlabel("environment steps")
        axes.set_xlim(left=0)
    for axes in (length, error):
        if axes.lines:
            log_scale(axes)
    for axes in (training, returns):  # the first episodes are far below all others
        values = np.concatenate([line.get_ydata() for line in axes.lines]) if axes.lines else np.zeros(0)
        if len(values) and np.quantile(values, 0.25) - values.min() > np.ptp(np.quantile(values, [0.25, 1])):
            bottom = np.quantile(values, 0.25) - np.ptp(np.quantile(values, [0.25, 1]))
            axes.set_ylim(bottom, values.max() + 0.05 * (values.max() - bottom))
    handles = training.get_legend_handles_labels()
    if many:
        below = canvas.add_subplot(grid[2, :])
        below.set_axis_off()
        below.legend(*handles, loc="center", ncols=4, fontsize=9)
    else:  # in the panel whose upper right stays empty: policies come to take fewer steps
        length.legend(*handles, loc="upper right", fontsize=9)
    problem, reward = logs[0].task
    canvas.suptitle(f"Learning curves: {problem}, reward {reward}")
    return canvas


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("logs", metavar="LOG", nargs="+", help="log files of train (-train_log)")
    parser.add_argument("--figure", metavar="PNG", help="file to write, default the first LOG with .png")
    options = parser.parse_args()
    target = options.figure or os.path.splitext(options.logs[0])[0] + ".png"
    save(figure(read_logs(options.logs)), target)
    print(f"Figure: {target}")
