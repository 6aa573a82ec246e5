"""Panels that the figures are made of; each draws one thing about one run into given axes."""

import io
import textwrap

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import FuncFormatter, LogFormatterMathtext, LogLocator, NullFormatter
from PIL import Image

RED = "#d62728"
REFERENCE = "#9a9a9a"
LETTER = 0.6  # width of letters over their size, about
# The first run is drawn on top of the others.
RUN_STYLES = [{"color": "#0062a5", "marker": "o", "zorder": 5}, {"color": "#e08a00", "marker": "s", "zorder": 4},
              {"color": "#2c8a4b", "marker": "^", "zorder": 3}, {"color": "#8a4fa3", "marker": "D", "zorder": 2}]
STYLE = {
    "font.size": 11, "axes.titlesize": 11, "axes.titleweight": "bold", "axes.titlelocation": "left",
    "axes.labelsize": 11,
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#e6e6e6",
    "grid.linewidth": 0.8, "axes.axisbelow": True, "legend.frameon": False, "legend.fontsize": 10,
    "lines.linewidth": 1.4, "figure.dpi": 100,
    "savefig.dpi": 150, "savefig.facecolor": "white",
}


def use_style():
    plt.rcParams.update(STYLE)


def wrapped(text, inches, size):
    """Lines of a text in a size [points] that is no wider than so many inches, about."""
    return textwrap.fill(text, max(int(inches * 72 / (LETTER * size)), 12))


SIZE_LIMIT = 140_000  # bytes of a PNG, above which it gets a palette: the figures are under version control


def save(canvas, target):
    """As PNG; a large one with 256 colours, which takes a third of the size."""
    buffer = io.BytesIO()
    canvas.savefig(buffer, format="png", dpi=100)
    plt.close(canvas)
    data = buffer.getvalue()
    if len(data) > SIZE_LIMIT:
        small = io.BytesIO()
        Image.open(buffer).convert("RGB").quantize(256, dither=Image.Dither.NONE).save(small, "PNG", optimize=True)
        data = small.getvalue()
    with open(target, "wb") as file:
        file.write(data)


def log_scale(axes):
    """A logarithmic y axis; with plain numbers at 1, 2 and 5 when it spans less than three decades."""
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    if high < 1e3 * low:
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    else:
        axes.yaxis.set_major_locator(LogLocator(numticks=9))
        axes.yaxis.set_major_formatter(LogFormatterMathtext())
    axes.yaxis.set_minor_formatter(NullFormatter())


def draw_reference(axes, run, name, label, clock=np.asarray):
    """A fine run as a broad grey line, under the others."""
    axes.plot(clock(run.series["time"]), run.series[name], color=REFERENCE, linewidth=3.5, alpha=0.7, label=label,
              zorder=1)


DENSE = 3000  # steps from which on each has a small dot, or none
DOTS = {"linestyle": "", "marker": "o", "markersize": 1.6, "markeredgewidth": 0, "alpha": 0.5, "rasterized": True}


def legend_of_dots(axes, **place):
    """A legend in which small dots are large enough to see."""
    for line in axes.legend(**place).get_lines():
        line.set(alpha=1)
        if line.get_marker() == "o" and line.get_markersize() < 3:
            line.set_markersize(4)


def legend_above(axes):
    """A legend above the axes, to the right of the title, where it hides nothing."""
    legend_of_dots(axes, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.2, handlelength=1.2,
                   columnspacing=1.0)


def draw_series(axes, run, name, style, label, clock=np.asarray):
    """One quantity against time, every accepted step marked; clock: times in the unit of the axis."""
    small, dense = len(run.series["time"]) > 60, len(run.series["time"]) > DENSE
    axes.plot(clock(run.series["time"]), run.series[name], color=style["color"],
              marker="" if dense else style["marker"], markersize=2.5 if small else 5,
              markeredgewidth=0, linewidth=0.6 if dense else 1.0, label=label, zorder=style["zorder"], rasterized=dense)


def draw_steps(axes, run, style, label, clock=np.asarray):
    """Step size of each attempt at the time it started; rejected attempts in red, with the run's marker."""
    time, dt, rejected = clock(run.steps["time"]), run.steps["dt"], run.rejected
    label += ", " if label else ""
    if len(dt) > DENSE:
        for chosen, colour, text in ((~rejected, style["color"], f"{label}accepted"),
                                     (rejected, RED, f"{label}rejected ({rejected.sum()})")):
            axes.plot(time[chosen], dt[chosen], **DOTS, color=colour, label=text)
        log_scale(axes)
        return
    axes.step(np.append(time[~rejected], clock(run.steps["time"][~rejected][-1:] + dt[~rejected][-1:])),
              np.append(dt[~rejected], dt[~rejected][-1:]), where="post", color=style["color"], linewidth=1.0,
              alpha=0.6, zorder=1)
    axes.plot(time[~rejected], dt[~rejected], linestyle="", color=style["color"], marker=style["marker"],
              markersize=4.5 if len(dt) < 100 else 3, markeredgewidth=0, label=f"{label}accepted",
              zorder=style["zorder"])
    few = rejected.sum() < 40
    axes.plot(time[rejected], dt[rejected], linestyle="", marker=style["marker"], markersize=6.5 if few else 5,
              markerfacecolor="none",
              markeredgecolor=RED, markeredgewidth=1.5 if few else 0.8, label=f"{label}rejected ({rejected.sum()})",
              zorder=style["zorder"])
    log_scale(axes)
