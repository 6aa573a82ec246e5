"""Pictures of a rupture: a field at several times, when each cell broke, and what came of it."""

import numpy as np

from ..errors import OutputError
from ..results.fields import Fields, event_around, events_within, largest_event, mean_slip_at, rupture_times
from ..times import Clock
from .maps import Span, beside, colour_bar, frames_of, planes_of
from .panels import plt, use_style, wrapped
from .titles import titles_of

COUNT = 6  # snapshots where no times are asked for
WIDTH = 11.0  # inches
LINE = 0.17  # inches of another line of a title
LONGEST = "113.271 years + 12.31 s"  # time of a panel, about
LINES = 12  # contours of the times of rupture of most cells, about
MOST = 0.9  # of all cells
MOST_LINES = 18  # contours of all
SAME = 0.01  # of all slip: rows between which it grows by less are alike
AT_ONCE = 0.01  # of the duration
BLACK = 0.2  # of the largest rate of all maps: on a linear scale a map whose largest is below is black or nearly so


def round_step(span, lines):
    """1, 2 or 5 times a power of ten: an interval of which some so many make a span."""
    raw = span / lines
    power = 10.0 ** np.floor(np.log10(raw))
    return power * next(k for k in (1, 2, 5, 10) if k * power >= raw * (1 - 1e-9))


class Layout:
    """Maps of the planes of a fault in a grid: blocks of one panel for each plane, below each other."""

    def __init__(self, run, blocks, columns, extra=0):
        use_style()
        self.planes, self.frames, self.shared = planes_of(run), frames_of(run), beside(run)
        columns = min(columns, blocks)
        self.rows = -(-blocks // columns)
        ratio = [np.clip((z1 - z0) / (x1 - x0), 0.15, 2.0) for x0, x1, z0, z1 in self.frames]
        self.columns, self.blocks = columns, blocks
        lines = [self.title(LONGEST if k == 0 else "", plane).count("\n") for k, plane in enumerate(self.planes)]
        height = sum(WIDTH / columns * 0.8 * one + (0.45 if self.shared else 0.65) + LINE * more
                     for one, more in zip(ratio, lines))
        self.ratio = ratio
        self.canvas = plt.figure(figsize=(WIDTH, 1.1 + height * self.rows + extra), layout="constrained")
        self.canvas.get_layout_engine().set(h_pad=0.06, w_pad=0.06)

    def title(self, text, plane):
        """Of a panel: a text and the name of its plane, in short where there are panels beside it."""
        return wrapped(", ".join(filter(None, (text, plane.name if self.columns == 1 else plane.short))),
                       0.85 * WIDTH / self.columns, 10)

    def fill(self, parent):
        """Axes [block][plane] within a figure or part of one; labels only at its rim."""
        many = len(self.planes)
        shared = {"sharex": True, "sharey": True} if self.shared else {"height_ratios": self.ratio * self.rows}
        grid = parent.subplots(self.rows * many, self.columns, squeeze=False, **shared)
        blocks = [[grid[(k // self.columns) * many + p, k % self.columns] for p in range(many)]
                  for k in range(self.rows * self.columns)]
        for block in blocks[self.blocks:]:
            for axes in block:
                axes.remove()
        for k, block in enumerate(blocks[:self.blocks]):
            below = k + self.columns >= self.blocks
            block[-1].set_xlabel(self.planes[-1].along_label if below else "")
            block[-1].tick_params(labelbottom=below or not self.shared)
        return blocks[:self.blocks]

    def draw(self, block, values, norm, colours, title, first):
        """One map over the panels of a block; the artists."""
        artists = []
        for axes, plane, frame in zip(block, self.planes, self.frames):
            label = axes.get_xlabel()
            artists.append(plane.draw(axes, plane.values(values), norm, colours))
            plane.frame(axes, frame)
            axes.set(xlabel=label, ylabel=plane.down_label if first else "")
            axes.set_title(self.title(title if axes is block[0] else "", plane), fontsize=10, fontweight="normal")
        return artists


def columns_of(run, count):
    """Panels beside each other, fewer for long faults; four make a square."""
    if count == 4:
        return 2
    x0, x1, z0, z1 = max(frames_of(run), key=lambda frame: frame[3] - frame[2])
    return min(count, 3 if (x1 - x0) < 3.5 * (z1 - z0) else 2 if (x1 - x0) < 7 * (z1 - z0) else 1)


def spread(at, count):
    """About so many rows at equal distances of what grows from row to row, none twice."""
    wanted = at[0] + (np.arange(count) + 0.5) / count * (at[-1] - at[0])
    return np.unique([np.argmin(np.abs(at - one)) for one in wanted])


def chosen_rows(fields, times, count=COUNT):
    """Rows nearest to the times asked for. Else some at equal times, or of what an event shows, and where most of these
    would be alike, at equal shares of its slip: at equal times most would be of its slow begin and end, or of rest."""
    if times:
        return np.array([fields.row_at(time) for time in times])
    of_event = fields.name in ("slip_rate", "stress_drop") or event_around(fields.run, *fields.times[[0, -1]])
    slip = np.maximum.accumulate(np.abs(mean_slip_at(fields.run, fields.times)
                                        - mean_slip_at(fields.run, fields.times[0])))
    rows = spread(fields.times, count)
    same = np.diff(slip[rows]) < SAME * slip[-1]
    return spread(slip, count) if slip[-1] > 0 and (of_event or same.sum() > len(same) / 2) else rows


def draw_snapshots(canvas, layout, fields, rows, clock, log, wanted):
    """Maps of a field at some rows under one scale of colours."""
    words = titles_of(fields.run, fields.times[rows], clock, named=False)
    maps = fields.maps(rows)
    maps = np.abs(maps) if log else maps
    norm = Span().see(maps).norm(fields.kind, log, wanted)
    blocks = layout.fill(canvas)
    for k, (block, values) in enumerate(zip(blocks, maps)):
        artists = layout.draw(block, values, norm, fields.kind.colours, words[k], k % layout.columns == 0)
    colour_bar(canvas, artists[0], norm, fields.label, ax=[axes for block in blocks for axes in block], shrink=0.8,
               aspect=30, pad=0.02)


def logarithmic(fields, rows, clock, wanted):
    """Whether snapshots are logarithmic, also where a few cells would make most maps of an event black."""
    log = clock.logarithmic(fields.name, wanted)
    if log or wanted is not None or fields.name != "slip_rate":
        return log
    peaks = np.array([np.nanmax(np.abs(values)) for values in fields.maps(rows)])
    return bool(np.median(peaks) < BLACK * peaks.max())


def since(clock):
    return f" (times since {clock.since})" if clock.since else ""


def clock_of(run, times, years):
    """Of snapshots: those within one event count from its begin, others from the run's."""
    event = event_around(run, times.min(), times.max())
    if event and not years:
        return Clock(*event)
    return Clock(0.0 if len(times) == 1 else times.min(), times.max(), years)


def snapshots(run, name, times, window=None, log=None, wanted=None, years=None):
    """A field at several times."""
    if not times and window is None and name in ("slip_rate", "stress_drop"):
        window = largest_event(run)
    fields = Fields(run, name, window)
    rows = chosen_rows(fields, times)
    clock = clock_of(run, fields.times[rows], years)
    log = logarithmic(fields, rows, clock, log)
    if min(planes_of(run)[0].shape or (2, 2)) == 1:
        return curves(run, fields, rows, clock, log, wanted)
    layout = Layout(run, len(rows), columns_of(run, len(rows)))
    draw_snapshots(layout.canvas, layout, fields, rows, clock, log, wanted)
    layout.canvas.suptitle(f"{run.title}: {fields.kind.title.lower()}{since(clock)}")
    return layout.canvas


def curves(run, fields, rows, clock, log, wanted):
    """Snapshots of a fault that is a single row of cells: a curve for each time."""
    use_style()
    canvas, axes = plt.subplots(figsize=(WIDTH, 5.0), layout="constrained")
    plane = planes_of(run)[0]
    across = plane.shape[0] == 1
    shades = plt.get_cmap("viridis")(np.linspace(0.0, 0.9, len(rows)))
    maps = fields.maps(rows).reshape(len(rows), -1)
    sides = plane.x if across else plane.z
    at = sides.mean(axis=0) if sides.shape[1] > 1 else sides[:, 0]  # a single cell has a line as long as it is
    words = titles_of(run, fields.times[rows], clock, named=False)
    for shade, text, values in zip(shades, words, np.abs(maps) if log else maps):
        values = np.broadcast_to(np.where(values > 0, values, np.nan) if log else values, at.shape)
        axes.plot(at, values, color=shade, label=text)
    axes.set(xlabel=plane.along_label if across else plane.down_label, ylabel=fields.label)
    if log:
        axes.set_yscale("log")
    elif fields.kind.limits == "zero":
        axes.set_ylim(bottom=min(0.0, axes.dataLim.y0))
    if wanted:
        axes.set_ylim(wanted)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    canvas.suptitle(f"{run.title}: {fields.kind.title.lower()}{since(clock)}")
    return canvas


def rates_of(run, window):
    """Rows of the slip rate in the largest event of a window, else all of it; in words what else there is."""
    event, count = largest_event(run, window), len(events_within(run, window))
    rates = Fields(run, "slip_rate", window or event)
    inside = (rates.times >= event[0]) & (rates.times <= event[1])
    if not inside.any():
        return rates, ""
    return Fields(run, "slip_rate",
                  event), f" in the largest of {count} events of the window" if window and count > 1 else ""


def rupture(run, times, window=None, log=None, wanted=None, years=None):
    """Slip rate of the largest event at several times; slip with the front's contours, and stress drop."""
    rates, others = rates_of(run, window)
    missing = [name for name in ("slip", "traction") if name not in run.field_names]
    if missing:
        raise OutputError(f"{run.path}: field {missing[0]} was not stored; a picture of a rupture needs slip_rate, "
                          "slip and traction: run with -fault_output_fields slip_rate,slip,traction")
    rows = chosen_rows(rates, times)
    clock = Clock(*rates.times[[0, -1]], years)
    log = logarithmic(rates, rows, clock, log)
    layout = Layout(run, len(rows), columns_of(run, len(rows)))
    result = Layout(run, 2, 2)
    plt.close(result.canvas)
    height = layout.canvas.get_figheight(), result.canvas.get_figheight()
    layout.canvas.set_figheight(sum(height))
    above, below = layout.canvas.subfigures(2, 1, height_ratios=height)
    draw_snapshots(above, layout, rates, rows, clock, log, wanted)
    above.suptitle(f"{run.title}: slip rate{others}{since(clock)}")
    draw_result(below, result, run, rates, clock)
    return layout.canvas


def contours_of(broke, clock):
    """A title that names their interval, and the times of rupture at which there are contours, in the clock's unit. The
    interval is that of most cells:
    few late ones would leave the others without. None where all cells broke at about once."""
    good = broke[np.isfinite(broke)]
    if not len(good) or np.ptp(good) < AT_ONCE * float(clock(clock.origin + clock.span)):
        return "Slip", []
    step = round_step((np.quantile(good, MOST) - good.min()) or np.ptp(good), LINES)
    levels = np.arange(np.floor(good.min() / step) + 1, np.ceil(good.max() / step)) * step
    last = f" to {levels[MOST_LINES - 1]:g}" if len(levels) > MOST_LINES else ""
    return f"Slip, rupture time every {step:g}{last} {clock.name}", levels[:MOST_LINES]


def draw_result(canvas, layout, run, rates, clock):
    """Slip during a window with contours of the time of rupture, and the static stress drop."""
    slip, drops = Fields(run, "slip", rates.window), Fields(run, "stress_drop", rates.window)
    first, final = slip.outer()
    broke = clock(rupture_times(rates))
    blocks = layout.fill(canvas)
    title, levels = contours_of(broke, clock)
    for k, (fields, values,
            head) in enumerate(((slip, final - first, title), (drops, drops.outer()[1], drops.kind.title))):
        norm = Span().see(values).norm(fields.kind)
        artists = layout.draw(blocks[k], values, norm, fields.kind.colours, head, k == 0)
        for plane, axes in zip(layout.planes, blocks[k] if k == 0 and len(levels) else ()):
            plane.contour(axes, plane.values(broke), levels)
        colour_bar(canvas, artists[0], norm, fields.label, ax=blocks[k], location="bottom", shrink=0.7, aspect=30,
                   pad=0.02)
