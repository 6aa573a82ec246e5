#!/usr/bin/env python3
"""Draw a benchmark's HDF5 file: tests/benchmarks/plot.py F.h5 [F.png]"""

import os
import sys

from common import need

need("matplotlib")
import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

LABELS = {"k_dense": "K dense", "k_fft": "K FFT", "k_hmat": "K H-matrix", "h_sqrtm": "H exact",
          "h_spectral": "H spectral", "h_lanczos": "H Lanczos", "b": "B", "pc": "preconditioner"}
CONTROLLERS = {"rl": "policy", "heuristic": "heuristic"}
STYLE = {1: "-", 2: "--"}


def table(file, name):
    """Columns of a table, those rows only that were measured."""
    if name not in file:
        return {}
    columns = {key: (data.asstr()[:] if data.dtype.kind == "O" else data[:]) for key, data in file[name].items()}
    good = columns["status"] == "ok"
    return {key: values[good] for key, values in columns.items()}


def curve(ax, columns, chosen, quantity, label, color, style="-", scale=1.0):
    """quantity against the number of cells, for the rows chosen; nothing when there are none."""
    if quantity not in columns:
        return
    chosen = chosen & (columns[quantity] > 0)
    order = np.argsort(columns["n"][chosen])
    n, y = columns["n"][chosen][order], columns[quantity][chosen][order]
    if len(n):
        ax.loglog(n * n, scale * y, "o" + style, color=color, label=label, markersize=3.5, linewidth=1.2)


def draw_operators(axes, columns):
    panels = ((axes[0], "product", 1, "time of a product (s)"), (axes[1], "setup", 1, "time of set-up (s)"),
              (axes[2], "memory", 1e-6, "memory, most on a rank (MB)"))
    for ax, quantity, scale, title in panels:
        for i, (kind, label) in enumerate(LABELS.items()):
            chosen = (columns["kind"] == kind) & (columns["ranks"] == 1)
            curve(ax, columns, chosen, quantity, label, f"C{i}", scale=scale)
        ax.set_title(title)


def draw_scaling(ax, columns, runs):
    """Time on 1 rank over that on 2, of products and of runs."""
    sets = [(columns, "kind", kind, "product", label, f"C{i}", "-") for i, (kind, label) in enumerate(LABELS.items())]
    sets += [(runs, "controller", name, "solve", f"run, {label}", "black", style)
             for (name, label), style in zip(CONTROLLERS.items(), ("--", ":"))]
    for data, key, value, quantity, label, color, style in sets:
        if not data:
            continue
        one, two = ({n: t for n, t, k, r in zip(data["n"], data[quantity], data[key], data["ranks"]) if k == value and r
                     == p} for p in (1, 2))
        sizes = sorted(set(one) & set(two))
        if sizes:
            ax.semilogx([n * n for n in sizes], [one[n] / two[n] for n in sizes], "o" + style, color=color, label=label,
                        markersize=3.5, linewidth=1.2)
    for level in (1, 2):
        ax.axhline(level, color="0.7", linewidth=0.8, zorder=0)
    ax.set_ylim(bottom=0)
    ax.set_title("speed-up of 2 ranks over 1")


def draw_iterations(ax, columns):
    for i, step in enumerate(np.unique(columns["step"]) if columns else ()):
        curve(ax, columns, columns["step"] == step, "iterations", f"h = {step:g} T*", f"C{i}")
    ax.set_yscale("linear")
    ax.set_ylim(bottom=0)
    ax.set_title("CG iterations to 1e-8, 60 % of the fault sliding")


def draw_runs(ax, runs):
    for i, (name, label) in enumerate(CONTROLLERS.items() if runs else ()):
        for ranks in (1, 2):
            chosen = (runs["controller"] == name) & (runs["ranks"] == ranks)
            curve(ax, runs, chosen, "solve", f"{label}, {ranks} rank{'s' if ranks > 1 else ''}", f"C{i}", STYLE[ranks])
    ax.set_title("full run, time of the solve (s)")


def draw(source, target):
    with h5py.File(source) as file:
        operators, iterations, runs = (table(file, name) for name in ("operators", "iterations", "runs"))
        about = dict(file["machine"].attrs)
    figure, axes = plt.subplots(2, 3, figsize=(15, 9), constrained_layout=True)
    if operators:
        draw_operators(axes[0], operators)
        draw_scaling(axes[1, 0], operators, runs)
    draw_iterations(axes[1, 1], iterations)
    draw_runs(axes[1, 2], runs)
    sizes = sorted({int(n) for columns in (operators, iterations, runs) for n in columns.get("n", ())})
    for ax in axes.flat:
        ax.set_xlabel("cells")
        ax.set_xticks([n * n for n in sizes], [f"${n}^2$" for n in sizes])
        ax.minorticks_off()
        ax.grid(alpha=0.3)
        if ax.get_legend_handles_labels()[0] and ax not in (axes[0, 1], axes[0, 2]):
            ax.legend(fontsize=8)
    figure.suptitle(f"3 km fault; {about['processor']}, {about['cores']} cores, load {about['load_average']:.1f} at "
                    "the start; " f"commit {str(about['commit'])[:10]}, {about['date']}", fontsize=10)
    part = os.path.splitext(target)[0] + ".part.png"
    figure.savefig(part, dpi=110)
    plt.close(figure)
    os.replace(part, target)


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    draw(sys.argv[1], sys.argv[2] if len(sys.argv) == 3 else os.path.splitext(sys.argv[1])[0] + ".png")
