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
    """Places on x, means and errors [2, n] of y there (of several runs their deviation), and how many runs."""
    places = sorted({row[x] for row in rows})
    groups = [[row for row in rows if row[x] == place] for place in places]
    errors = [[np.std([row[y] for row in own], ddof=1)] * 2 if len(own) > 1
              else [max(row[y] - row["low"], 0), max(row["high"] - row[y], 0)] for own in groups for row in own[:1]]
    return places, np.array([np.mean([row[y] for row in own])
                             for own in groups]), np.array(errors).T, max(map(len, groups))


def named(name, unit):
    return f"{name} ({unit})" if unit else name


def figure(rows, x, y, by=None, units=(), spreads=None):
    """A line for each value of `by`; runs without a number of y are left out, and the title says how many. units: of x,
    y and by, by their names; spreads: from and to of y in each row, or None."""
    use_style()
    units = dict(units)
    spreads = spreads or [None] * len(rows)
    shown = [{**row, "low": (between or (row[y],))[0], "high": (between or (row[y],))[-1]}
             for row, between in zip(rows, spreads) if number(row[y])]
    if units.get(y) == "s" and shown:  # in the unit that fits
        name = unit_of(max(abs(row[y]) for row in shown))
        shown, units[y] = [{**row, **{key: row[key] / SECONDS[name] for key in (y, "low", "high")}}
                           for row in shown], NAMES[name]
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
        places, mean, errors, several = points(own, x, y)
        most = max(most, several)
        axes.errorbar(places, mean, yerr=errors if errors.any() else None,
                      color=shade(0.9 * k / max(len(lines) - 1, 1)), marker=MARKERS[k % len(MARKERS)], markersize=5,
                      capsize=4, elinewidth=1.2, linestyle="" if texts else "-", label=f"{line:g}" if number(line)
                      else str(line))
    if shown and not texts and wide([row[x] for row in shown]):
        axes.set_xscale("log")
    if shown and wide([row[y] for row in shown]):
        log_scale(axes)
    if by:
        axes.legend(title=named(by, units.get(by)), loc="upper left", bbox_to_anchor=(1.0, 1.0))
    missing = len(rows) - len(shown)
    bars = (f"; mean and standard deviation of up to {most}" if most > 1 else "; bars: spread of each number"
            if any(row["low"] < row["high"] for row in shown) else "")
    axes.set(xlabel=named(x, "" if texts else units.get(x)), ylabel=named(y, units.get(y)),
             title=f"{len(shown)} runs" + (f", {missing} without a number" if missing else "") + bars)
    return canvas
