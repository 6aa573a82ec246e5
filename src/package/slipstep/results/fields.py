"""Fields of a run as pictures need them: rows of /fields read when they are asked for, and what follows from them, the
static stress drop and the times of rupture.

    fields = Fields(run, "slip_rate", window=(0, 20))
    fields.times, fields.maps([3, 7])                # [n], [2, Nz, Nx] or [2, N]
"""

import collections

import numpy as np

from ..errors import OutputError
from .course import from_start
from .files import COMPONENTS, drawn, plain, split

RUPTURE_RATE = 1e-3  # m/s: what slips faster is in an event
CHUNK = 128  # rows that are in memory at once

# source: the dataset; scale: from its unit to the one drawn; limits: "zero" begins colours at 0, "even" puts 0 in the
# middle
Kind = collections.namedtuple("Kind", "source title unit scale colours limits")
KINDS = {
    "slip_rate": Kind("slip_rate", "Slip rate", "m/s", 1.0, "magma", "zero"),
    "slip": Kind("slip", "Slip", "m", 1.0, "viridis", "zero"),
    "displacement": Kind("displacement", "Displacement", "m", 1.0, "viridis", "free"),
    "traction": Kind("traction", "Shear traction", "MPa", 1e-6, "cividis", "free"),
    "stress_drop": Kind("traction", "Static stress drop", "MPa", 1e-6, "coolwarm", "even"),
}


def kind_of(name, unit):
    """How a field is drawn; one without a row above in its own unit, and a component of slip as the field whose it
    is."""
    if name in KINDS:
        return KINDS[name]
    for part, words in COMPONENTS.items():
        if name.endswith(part):
            whole = kind_of(name.removesuffix(part), unit)
            return whole._replace(title=f"{whole.title} {words}", limits="even" if whole.limits == "zero"
                                  else whole.limits, colours="coolwarm" if whole.limits == "zero" else whole.colours)
    scale = 1e-6 if unit == "Pa" else 1.0
    return Kind(name, name.replace("_", " ").capitalize(), "MPa" if unit == "Pa" else unit, scale, "viridis", "free")


class Fields:
    """The rows of one field within a window of time."""

    def __init__(self, run, name, window=None):
        self.run, self.name, self.window = run, name, window
        source, self._part = split(KINDS[name].source if name in KINDS else name)
        with run.open() as file:
            times, data = run.stored(file, source)
            self._source, rows = source, len(times)
            self.kind = kind_of(name, plain(data.attrs.get("units", "")))
            self._check_shape(data)
        low, high = window or (-np.inf, np.inf)
        self.rows = np.flatnonzero((times >= low) & (times <= high))
        self.times = times[self.rows]
        if not len(self.rows):
            part = (f" between {low:g} and {high:g} s; it has {rows} rows from {times[0]:g} to {times[-1]:g} s" if rows
                    else "")
            raise OutputError(f"{run.path}: /fields/{source} has no rows{part}")
        after = int(np.searchsorted(times, high))
        self._outer = max(int(np.searchsorted(times, low, side="right")) - 1, 0), min(after, rows - 1)

    @property
    def _cells(self):
        return (len(self.run.mesh["x"]),) if self.run.planes else self.run.shape

    def _check_shape(self, data):
        expected = self._cells
        if data.shape[1:] == (*expected, 2):
            return
        if self._part is not None:
            raise OutputError(f"{self.run.path}: {data.name} has one component; expected a run with "
                              "-fault_slip_components 2")
        if data.shape[1:] != expected:
            raise OutputError(f"{self.run.path}: {data.name} is {data.shape[1:]} at each time, expected {expected} as "
                              "the cells of /mesh")

    @property
    def label(self):
        return f"{self.kind.title.lower()} ({self.kind.unit})"

    def maps(self, rows):
        """Maps [n, Nz, Nx], or [n, N] of irregular cells, of some rows of the window, in the unit of the label."""
        with self.run.open() as file:
            return self._drawn(self.run.stored(file, self._source)[1], [self.rows[row] for row in rows])

    def outer(self):
        """The maps at the begin and the end of the window, or at the next rows outside of it."""
        with self.run.open() as file:
            return self._drawn(self.run.stored(file, self._source)[1], self._outer)

    def _drawn(self, data, rows):
        together = (np.diff(rows) == 1).all()
        values = data[rows[0]:rows[-1] + 1] if together else np.array([data[row] for row in rows])
        if data.ndim > 1 + len(self._cells):
            values = drawn(values, self._part)
        if self.name != "stress_drop":
            return self.kind.scale * values
        start = data[self._outer[0]]
        return self.kind.scale * drop(drawn(start, self._part) if start.ndim > len(self._cells) else start, values)

    def chunks(self, rows=None):
        """(rows, maps) a few rows at a time, so that a long run fits into memory."""
        rows = np.arange(len(self.rows)) if rows is None else np.asarray(rows)
        for k in range(0, len(rows), CHUNK):
            yield rows[k:k + CHUNK], self.maps(rows[k:k + CHUNK])

    def row_at(self, time):
        """The row nearest to a time [s], which must lie within the window's rows."""
        first, last = self.times[0], self.times[-1]
        slack = 1e-6 * max(abs(first), abs(last))
        if not first - slack <= time <= last + slack:
            raise OutputError(f"{self.run.path}: no field at {time:g} s, expected a time from {first:g} to {last:g} s"
                              + (", as in the window (--window BEGIN END takes another)" if self.window else ""))
        return int(np.argmin(np.abs(self.times - time)))


def drop(start, traction):
    """Static stress drop: how much the traction, which resists slip, has fallen from the start in its own direction."""
    reference = start if np.any(start) else traction[-1]
    return (start - traction) * np.sign(reference.sum())


def rupture_times(fields, threshold=RUPTURE_RATE):
    """When the slip rate of each cell first passes a threshold [s], linear between stored rows; nan where it never
    does."""
    found = before = previous = None
    for rows, maps in fields.chunks():
        for time, rate in zip(fields.times[rows], np.abs(maps)):
            if found is None:
                found = np.where(rate >= threshold, time, np.nan)
            else:
                fresh = np.isnan(found) & (rate >= threshold)
                share = (threshold - before[fresh]) / (rate[fresh] - before[fresh])
                # in single precision, as rates are stored, centuries have steps of 512 s
                found[fresh] = previous + (time - previous) * share.astype(float)
            before, previous = rate, time
    return found


def events(times, rates, threshold=RUPTURE_RATE):
    """(begin, end) of the stretches of time in which the largest slip rate is above a threshold, with the rows around
    them."""
    fast = np.concatenate(([False], rates >= threshold, [False]))
    first, last = np.flatnonzero(fast[1:] & ~fast[:-1]), np.flatnonzero(fast[:-1] & ~fast[1:]) - 1
    last_row = len(times) - 1
    return [(times[max(a - 1, 0)], times[min(b + 1, last_row)]) for a, b in zip(first, last)]


def largest_rates(run):
    """Times from the start on [s], and the largest slip rate at each [m/s]."""
    return from_start(run.series, ("time", "max_slip_rate"))


def event_around(run, begin, end):
    """The event of the series that holds these times [s]; None where they are not within a single one."""
    return next(((first, last) for first, last in events(*largest_rates(run)) if first <= begin and end <= last), None)


def events_within(run, window=None):
    """(begin, end) of the events of the series, or of their parts within a window."""
    low, high = window or (-np.inf, np.inf)
    parts = [(max(first, low), min(last, high)) for first, last in events(*largest_rates(run))]
    return [(first, last) for first, last in parts if first < last]


def mean_slip_at(run, times):
    """Mean slip [m] at some times [s], between steps linear."""
    return np.interp(times, *from_start(run.series, ("time", "mean_slip")))


def largest_event(run, window=None):
    """Of the events within a window, or in all of the run, the one with most slip, as of the largest moment; the window
    itself, or the whole run, where nothing is that fast."""
    found = events_within(run, window)
    if not found:
        return window or (0.0, run.series["time"][-1])
    return max(found, key=lambda event: abs(np.diff(mean_slip_at(run, event))[0]))
