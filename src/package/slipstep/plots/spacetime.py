"""Lines along a fault and what happens on them: a field against time or against the stored steps."""

import numpy as np
from matplotlib.ticker import MaxNLocator

from ..errors import OutputError
from ..results.fields import Fields
from ..times import SECONDS, Clock, digits_for
from .maps import DIGITS, Span, colour_bar, colour_map, planes_of
from .panels import plt, use_style

SLIVER = 1e-5  # of the smallest cell: corners that are nearer to each other are one
COLUMNS = 500  # of a picture against time: some dots of it each, so that none is lost in drawing


def place(text):
    """What --at says: "max", "mean" or km."""
    return text if text in ("max", "mean") else float(text)


def crossing(here, across, at):
    """[2, n]: from where to where the line at `at` is in triangles with corners [3, n]; equal: it is not."""
    low, high = np.full(here.shape[1], np.inf), np.full(here.shape[1], -np.inf)
    for k in range(3):
        begin, end = across[k], across[(k + 1) % 3]
        share = (at - begin) / np.where(end == begin, np.inf, end - begin)
        meets = (np.minimum(begin, end) <= at) & (at <= np.maximum(begin, end))
        for point in (here[k] + share * (here[(k + 1) % 3] - here[k]), np.where(end == at, here[(k + 1) % 3], np.nan)):
            low, high = (np.where(meets, fold(bound, point), bound)
                         for fold, bound in ((np.fmin, low), (np.fmax, high)))
    none = ~(high - low > SLIVER * np.ptp(here, axis=0))
    return np.where(none, 0.0, np.stack([low, high]))


class Line:
    """Intervals along strike, or down dip, and the cells of one plane on each.

    along  "strike", or "dip", also called "depth"
    at     where the line is in the other direction [km], or "max" or "mean" over that direction; None: in the middle
    """

    def __init__(self, plane, along="strike", at=None):
        self.plane, self.along = plane, "strike" if along == "strike" else "depth"
        here, across = self.axes_of(plane, along)
        low, high = across.min(), across.max()
        self.at = 0.5 * (low + high) if at is None else at
        if len(here) == 3:
            if not isinstance(self.at, float):
                raise OutputError(f"--at is {self.at}, which is known of rectangles only; expected a number of km on a "
                                  "fault of triangles")
            here = crossing(here, across, self.at)
            across = np.where(here[1] > here[0], [[low], [high]], np.nan)
        edge = np.unique(across)
        if at is None and np.abs(edge - self.at).min() < 10.0 ** -DIGITS:
            self.at = float(edge[np.abs(edge - self.at).argmin()])
        self.weight = across[1] - across[0]
        if isinstance(self.at, float):
            if not low <= self.at <= high:
                raise OutputError(f"--at is {self.at:g} km, expected a number between {low:g} and {high:g}, where "
                                  "the fault is")
            chosen = (across[0] <= self.at) & (self.at < across[1]) | (across[1] == high) & (self.at == high)
        else:
            chosen = np.ones(here.shape[1], dtype=bool)
        cells = np.flatnonzero(chosen)
        corners = np.unique(np.round(here[:, cells], 9))
        corners = corners[np.append(True, np.diff(corners) > SLIVER * (here[1] - here[0]).min())]
        middle = 0.5 * (corners[1:] + corners[:-1])
        over = [cells[(here[0, cells] <= m) & (m <= here[1, cells])] for m in middle]
        self.edges, self.centres, self.over = corners, middle, over

    @staticmethod
    def axes_of(plane, along):
        """Edges of cells in the line's direction and in the other one."""
        return (plane.x, plane.z) if along == "strike" else (plane.z, plane.x)

    @property
    def label(self):
        return self.plane.along_label if self.along == "strike" else self.plane.down_label

    @property
    def where(self):
        """In words, for titles."""
        other = self.plane.down.replace("down ", "") if self.along == "strike" else "strike"
        if isinstance(self.at, float):
            at = f"{self.at:{'.3g' if abs(self.at) < 999.5 else '.0f'}} km"
            deep = f"at a depth of {at}" if self.plane.vertical else f"at {at} {self.plane.down}"
            place = deep if self.along == "strike" else f"at {at} {self.plane.along}"
        else:
            place = {"max": f"(largest over {other})", "mean": f"(mean over {other})"}[self.at]
        return ", ".join(filter(None, (place, self.plane.name)))

    def values(self, maps):
        """[n, intervals] of maps [n, ...]; NaN where the line is in no cell, as in a notch."""
        values = self.plane.values(maps)
        take = {"max": lambda cells: values[:, cells].max(axis=1),
                "mean": lambda cells: np.average(values[:, cells], axis=1, weights=self.weight[cells])}.get(
                    self.at, lambda cells: values[:, cells[0]])
        return np.stack([take(cells) if len(cells) else np.full(len(values), np.nan) for cells in self.over], axis=1)

    def drawn(self, values):
        """Distances and values [..., intervals] of a curve, through middles; of one cell from end to end."""
        return (self.centres, values) if len(self.centres) > 1 else (self.edges, np.repeat(values, 2, axis=-1))


def lines_of(run, along, at):
    """One of each plane; a number leaves out those which do not reach there, unless none does."""
    planes = planes_of(run)
    if isinstance(at, float):
        across = [Line.axes_of(plane, along)[1] for plane in planes]
        there = [plane for plane, ends in zip(planes, across) if ends.min() <= at <= ends.max()]
        planes = there or planes
    return [Line(plane, along, at) for plane in planes]


def along_line(fields, line):
    """All rows of a field on a line, [n, intervals]."""
    return np.concatenate([line.values(maps) for _, maps in fields.chunks()])


def interpolate(times, values, wanted):
    """Rows of values [n, m] at other times, linear between."""
    right = np.clip(np.searchsorted(times, wanted), 1, len(times) - 1)
    share = np.clip((wanted - times[right - 1]) / (times[right] - times[right - 1]), 0, 1)[:, None]
    return (1 - share) * values[right - 1] + share * values[right]


def resample(times, values, count, largest):
    """Equal columns of a picture between the first and the last time: the largest value within each, so that no event
    is too short to be seen, and between rows the smaller of both neighbours; or the value at its middle, linear between
    rows."""
    bounds = np.linspace(times[0], times[-1], count + 1)
    middle = 0.5 * (bounds[1:] + bounds[:-1])
    if not largest:
        return bounds, interpolate(times, values, middle)
    right = np.clip(np.searchsorted(times, middle), 1, len(times) - 1)
    found = np.minimum(values[right - 1], values[right])
    column = np.clip(((times - times[0]) / (times[-1] - times[0]) * count).astype(int), 0, count - 1)
    np.maximum.at(found, column, values)
    return bounds, found


def draw_time_ticks(axes, fields, clock):
    """Times of some rows above a picture against steps."""
    ticks = [tick for tick in axes.get_xticks() if 0 <= tick < len(fields.times)]
    top = axes.secondary_xaxis("top")
    rows = np.clip(np.round(ticks).astype(int), 0, len(fields.times) - 1)
    gaps = np.diff(fields.times[rows]) / SECONDS[clock.unit]
    digits = max(clock.digits, min(digits_for(gaps[gaps > 0].min()), 4) if (gaps > 0).any() else 0)
    words = [f"{float(clock(time)):.{digits}f}" for time in fields.times[rows]]
    # those of an event may be one
    top.set_xticks(ticks, [word if k == 0 or word != words[k - 1] else "" for k, word in enumerate(words)])
    top.set_xlabel(clock.label)
    top.spines["top"].set_visible(True)


def draw_space_time(axes, fields, line, clock, against, log, wanted):
    """A field on a line: distance upwards (down dip downwards), time or steps to the right."""
    values = along_line(fields, line)
    values = np.abs(values) if log else values
    gaps = np.isnan(values).any(axis=0)
    norm = Span().see(values).norm(fields.kind, log, wanted)
    rows = np.arange(len(values))
    rate = fields.name == "slip_rate"
    if against == "time":
        bounds, values = resample(fields.times, values, COLUMNS, rate)
        bounds = clock(bounds)
    elif len(rows) > 2 * COLUMNS:
        bounds, values = resample(rows.astype(float), values, COLUMNS, rate)
    else:
        bounds = np.append(rows, len(rows)) - 0.5
    image = axes.pcolormesh(bounds, line.edges, values.T, norm=norm, cmap=colour_map(fields.kind.colours),
                            rasterized=True)
    if line.along == "depth":
        axes.invert_yaxis()
    axes.grid(False)
    axes.set(ylabel=line.label)
    axes.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    axes.set_title(f"{fields.kind.title} {line.where}", fontsize=10, fontweight="normal", pad=6)
    colour_bar(axes.figure, image, norm, fields.label, ax=axes, pad=0.01, aspect=18)
    for gap in np.flatnonzero(gaps):  # where the line leaves the fault, no colour is right
        axes.axhspan(*line.edges[gap:gap + 2], color="white", linewidth=0)


def space_time(run, names, along="strike", at=None, against="time", window=None, log=True, wanted=None, years=None):
    """Fields on a line of each plane against time, below each other."""
    use_style()
    fields = [Fields(run, name, window) for name in names]
    short = [field for field in fields if len(field.times) < 2]
    if short:
        raise OutputError(f"{run.path}: a space-time picture needs two rows of /fields, {short[0].kind.source} has one "
                          "in this window")
    lines = lines_of(run, along, at)
    count = len(lines) * len(fields)
    canvas, axes = plt.subplots(count, 1, figsize=(11, 1.2 + 3.2 * count), layout="constrained", squeeze=False,
                                sharex=True)
    clock = Clock(fields[0].times[0], fields[0].times[-1], years)
    panels = [(line, field) for line in lines for field in fields]
    for own, (line, field) in zip(axes[:, 0], panels):
        draw_space_time(own, field, line, clock, against, log and field.name == "slip_rate",
                        wanted if len(fields) == 1 else None)
    axes[-1, 0].set_xlabel(clock.label if against == "time" else "stored step")
    if against == "step":
        draw_time_ticks(axes[0, 0], fields[0], clock)
    canvas.suptitle(run.title)
    return canvas
