"""Cumulative slip along a line as seismologists draw it: solid lines at equal times between events, dashed ones at
equal, much shorter times during them."""

import sys

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.ticker import MaxNLocator

from ..modules import program
from ..results.fields import Fields
from ..times import NAMES, SECONDS, unit_of
from .panels import wrapped
from .snapshots import round_step
from .spacetime import along_line, interpolate, lines_of

SOLID, DASHED = "#0062a5", "#d9541e"
LINES = 40  # solid ones where no interval is given


def between(end, interval, events):
    """Multiples of an interval up to an end that are not within any event."""
    wanted = np.arange(np.floor(end / interval * (1 + 1e-12)) + 1) * interval
    inside = np.zeros(len(wanted), dtype=bool)
    for onset, last in events:
        inside |= (wanted > onset) & (wanted < last)
    return wanted[~inside]


def during(times, onset, end, interval):
    """Times at an interval from an onset to an end, True, and how many these would be; where the stored ones are
    further apart than twice that, so that lines between them would be made up, the stored ones, one in each interval at
    most, and False."""
    wanted = onset + np.arange(np.floor((end - onset) / interval * (1 + 1e-12)) + 1) * interval
    right = np.searchsorted(times, wanted, side="right")
    gap = times[np.clip(right, 0, len(times) - 1)] - times[np.clip(right - 1, 0, len(times) - 1)]
    near = (gap <= 2 * interval) & (right > 0) & (right < len(times))
    if near.mean() > 0.5:
        return wanted[near], True, len(wanted)
    stored = times[(times >= onset) & (times <= end)]
    return stored[np.unique(np.floor((stored - onset) / interval), return_index=True)[1]], False, len(wanted)


class Course:
    """Slip along a line of a run, with the intervals at which it is drawn."""

    def __init__(self, run, line, name, every=None, every_event=1.0):
        self.line = line
        self.fields = Fields(run, name)
        self.times = self.fields.times
        self.values = along_line(self.fields, line)
        span = max(self.times[-1], 1e-300)
        unit = SECONDS[unit_of(span)]
        self.every, self.every_event = every or round_step(span / unit, LINES) * unit, every_event

    def lines(self, events):
        """Slip [n, m] between and during events; how many events have too few rows, and lines all with enough."""
        events = [(onset, end) for onset, end in events if onset < self.times[-1]]
        solid = interpolate(self.times, self.values, between(self.times[-1], self.every, events))
        inside = [during(self.times, onset, end, self.every_event) for onset, end in events]
        dashed = np.concatenate([np.zeros(0), *(times for times, *_ in inside)])
        return solid, interpolate(self.times, self.values, dashed), sum(not dense for _, dense, _
                                                                        in inside), sum(wanted for *_, wanted in inside)


def draw_cumulative(axes, course, events):
    """Slip over distance along strike, or distance down dip over slip; how many events have too few rows."""
    line = course.line
    solid, dashed, poor, wanted = course.lines(events)
    for values, colour, style, width in ((dashed, DASHED, (0, (4, 2)), 0.7), (solid, SOLID, "solid", 1.0)):
        along, rows = line.drawn(values)
        pairs = [(along, row) if line.along == "strike" else (row, along) for row in rows]
        axes.add_collection(LineCollection([np.stack(pair, axis=1) for pair in pairs], colors=colour, linestyles=style,
                                           linewidths=width))
    low, high = min(0.0, np.nanmin(course.values)), np.nanmax(course.values) * 1.03 or 1.0
    distance, slip = (line.edges[0], line.edges[-1]), (low, high)
    if line.along == "strike":
        axes.set(xlim=distance, ylim=slip, xlabel=line.label, ylabel=f"cumulative {course.fields.label}")
    else:
        axes.set(xlim=slip, ylim=distance[::-1], xlabel=f"cumulative {course.fields.label}", ylabel=line.label)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(8, steps=[1, 2, 5, 10]))
    axes.plot([], [], color=SOLID, label=f"every {plain(course.every)}")
    if wanted:
        stored = "" if len(dashed) == wanted else f": the {len(dashed)} of {wanted} that rows are stored for"
        axes.plot([], [], color=DASHED, linestyle=(0, (4, 2)), linewidth=1.0,
                  label=f"every {plain(course.every_event)} during events{stored}")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
    axes.set_title(wrapped(f"Cumulative slip {line.where}", 0.9 * axes.figure.get_figwidth(), 11))
    return poor


def plain(interval):
    """An interval in the largest unit in which it is a short number: "5 years", "2 days", "1 s"."""
    unit = next((unit for unit in ("y", "d", "h") if interval >= SECONDS[unit]
                 and len(f"{interval / SECONDS[unit]:g}") <= 3), "s")
    value = interval / SECONDS[unit]
    return f"{value:g} {NAMES[unit] if value != 1 or unit == 's' else NAMES[unit][:-1]}"


def courses(run, name, along, at, every, every_event):
    """One for each plane of a run."""
    return [Course(run, line, name, every, every_event) for line in lines_of(run, along, at)]


def warn(run, poor, course):
    if poor:
        print(f"{program()}: {run.path} has too few rows of /fields in {poor} events for a line every "
              f"{plain(course.every_event)}: those have lines at their rows; "
              "run with a smaller -fault_output_interval or -fault_output_slip_interval", file=sys.stderr)
