"""A column of a study's table against what was varied."""

import numpy as np

from ..times import NAMES, SECONDS, unit_of
from .panels import log_scale, plt, use_style

WIDE = 50.0  # largest over smallest of an axis, above which it is logarithmic
MARKERS = "osD^vP*X"


def number(value):
    return not isinstance(value, (str, bool)) and value is not None and np.isfinite(value)


def wide(values):
    return len(values) > 1 and min(values) > 0 and max(values) > WIDE * min(values)


def points(rows, x, y):
    """Places on x in their order, and there the mean, standard deviation and number of values of y."""
    places = sorted({row[x] for row in rows})
    groups = [[row[y] for row in rows if row[x] == place] for place in places]
    return places, np.array([np.mean(g) for g in groups]), np.array([np.std(g, ddof=1) if len(g) > 1 else 0.0 for g in groups]), max(map(len, groups))


def figure(rows, x, y, by=None, unit=""):
    """A line for each value of `by`; runs without a number of y are left out, and the title says how many."""
    use_style()
    shown = [row for row in rows if number(row[y])]
    if unit == "s" and shown:  # in the unit that fits
        name = unit_of(max(abs(row[y]) for row in shown))
        shown, unit = [{**row, y: row[y] / SECONDS[name]} for row in shown], NAMES[name]
    canvas, axes = plt.subplots(figsize=(7, 4.4), layout="constrained")
    texts = None if all(number(row[x]) for row in rows) else sorted({str(row[x]) for row in rows})
    if texts:
        shown = [{**row, x: texts.index(str(row[x]))} for row in shown]
        axes.set_xticks(range(len(texts)), texts)
        axes.set_xlim(-0.5, len(texts) - 0.5)
    lines = list(dict.fromkeys(row[by] for row in shown)) if by else [None]
    shade = plt.get_cmap("viridis")
    most = 1
    for k, line in enumerate(lines):
        own = [row for row in shown if by is None or row[by] == line]
        if not own:
            continue
        places, mean, spread, several = points(own, x, y)
        most = max(most, several)
        axes.errorbar(places, mean, yerr=spread if several > 1 else None, color=shade(0.9 * k / max(len(lines) - 1, 1)), marker=MARKERS[k % len(MARKERS)], markersize=5, capsize=3,
                      linestyle="" if texts else "-", label=f"{line:g}" if number(line) else str(line))
    if shown and not texts and wide([row[x] for row in shown]):
        axes.set_xscale("log")
    if shown and wide([row[y] for row in shown]):
        log_scale(axes)
    if by:
        axes.legend(title=by, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    missing = len(rows) - len(shown)
    axes.set(xlabel=x, ylabel=y + (f" ({unit})" if unit not in ("", "1") else ""), title=f"{len(shown)} runs" + (f", {missing} without a number" if missing else "")
             + (f"; mean and standard deviation of up to {most}" if most > 1 else ""))
    return canvas
