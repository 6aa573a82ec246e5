"""Heat maps over policies and meshes for slipstep plot-study."""

import numpy as np
from matplotlib.colors import LogNorm

from .panels import plt

MISSING, FAILED = "#f0f0f0", "#f3c7c7"


class Table:
    """Values over policies and meshes of one size, nan where a run is missing or failed, with marks."""

    def __init__(self, policies, meshes):
        self.policies, self.meshes = policies, meshes
        self.values = np.full((len(policies), len(meshes)), np.nan)
        self.marks = np.full(self.values.shape, "", dtype=object)

    def fill(self, study, size, treatment, value):
        """value(policy's cell, cells) of each entry; cells(controller) finds a classical run of the same case."""
        error, reaction = treatment
        for i, policy in enumerate(self.policies):
            for k, mesh in enumerate(self.meshes):
                case = {"problem": "fault", "size_km": size, "mesh": mesh, "error": error, "reaction": reaction}
                cell = study.one(policy=policy, **case)
                if cell is None:
                    continue
                self.marks[i, k] = "*" if cell["guarded"] else ""
                if not cell.converged:
                    self.marks[i, k] = "failed"
                    continue
                self.values[i, k] = value(cell, lambda controller: study.one(controller=controller, tolerance=1.0,
                                                                             steps=0, **case))
        return self


def ratio_to(controller, quantity):
    """How many times more of a quantity a classical controller takes; nan when it did not converge or is missing."""
    def value(cell, find):
        other = find(controller)
        return (other[quantity] / cell[quantity] if other is not None and other.converged and cell[quantity] > 0
                else np.nan)
    return value


def error_of(measure):
    return lambda cell, find: 100 * cell.error(measure)


def error_ratio(controller, measure):
    """How many times larger a policy's error is."""
    def value(cell, find):
        other = find(controller)
        return (cell.error(measure) / other.error(measure) if other is not None and other.converged
                and other.error(measure) else np.nan)
    return value


def shorten(value):
    """Three digits at most."""
    return f"{value:.0f}" if value >= 99.5 else f"{value:.3g}" if value >= 10 else f"{value:.2g}"


def colours(tables, diverging):
    """One norm for several maps; white at 1 for ratios."""
    values = np.concatenate([table.values[np.isfinite(table.values)] for table in tables])
    values = values[values > 0]
    if not len(values):
        return LogNorm(0.1, 10)
    if not diverging:
        return LogNorm(values.min(), max(values.max(), 1.01 * values.min()))
    top = max(np.abs(np.log10(values)).max(), 0.1)
    return LogNorm(10**-top, 10**top)


def draw_heat(axes, table, norm, cmap, rows, title):
    """One map with its numbers; * where guard rails stepped in."""
    axes.set_facecolor(MISSING)
    axes.imshow(np.ma.masked_invalid(table.values), norm=norm, cmap=cmap, aspect="auto")
    middle = np.log10(norm.vmin * norm.vmax) / 2
    reach = np.log10(norm.vmax / norm.vmin) / 2
    for i in range(len(table.policies)):
        for k in range(len(table.meshes)):
            value, mark = table.values[i, k], table.marks[i, k]
            if mark == "failed":
                axes.add_patch(plt.Rectangle((k - 0.5, i - 0.5), 1, 1, color=FAILED))
                axes.text(k, i, "failed", ha="center", va="center", fontsize=7)
            elif not np.isfinite(value):
                axes.text(k, i, "–", ha="center", va="center", fontsize=8, color="#888888")
            else:
                far = abs(np.log10(max(value, 1e-300)) - middle) > 0.6 * reach
                dark = far if cmap in ("RdBu", "RdBu_r") else np.log10(max(value, 1e-300)) < middle
                axes.text(k, i, shorten(value) + mark, ha="center", va="center", fontsize=8,
                          color="white" if dark else "black")
    axes.set_xticks(range(len(table.meshes)), [f"{mesh}²" for mesh in table.meshes])
    axes.set_yticks(range(len(table.policies)), rows if rows else [])
    axes.tick_params(length=0, labelsize=8)
    axes.grid(False)
    axes.set_title(title, fontsize=9)
