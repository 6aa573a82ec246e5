"""Times of frames and snapshots in words, with digits enough to tell each from its neighbours."""

import numpy as np

from ..results.fields import events, largest_rates
from ..times import NAMES, SECONDS, digits_for, unit_of, written

FINEST = 1e-4  # s, of digits


def titles_of(run, times, clock, named=True):
    """Each time [s] in words, in any order. Those of a part of a long run count from the clock's origin, which is named
    (named: unless that stands elsewhere); those too close for its unit, as in an event, count from the event's begin:
    "64.007629 years + 12.31 s"."""
    order = np.sort(times)
    gaps, size = np.diff(order), SECONDS[clock.unit]
    usual = clock.span / max(len(gaps), 1)
    if clock.unit == "s" and (gaps > 0).any():
        usual = max(gaps[gaps > 0].min(), FINEST)
    digits = max(clock.digits, digits_for(usual / size))
    since = f"{clock.since} + " if named and clock.since else ""
    words = {time: f"{since}{float(clock(time)):.{digits}f} {clock.name}" for time in order}
    if clock.unit != "s":
        starts = [begin for begin, _ in events(*largest_rates(run))]
        for group in np.split(order, np.flatnonzero(gaps >= 10.0 ** -digits * size) + 1):
            if len(group) > 1:
                words.update(zip(group, close(group, starts)))
    return [words[time] for time in times]


def close(times, starts):
    """Times that are close together, from the begin of the first event among them, or from the first of them."""
    origin = next((start for start in starts if times[0] <= start <= times[-1]), times[0])
    name, away = written(origin, np.ptp(times)), times - origin
    units = np.array([unit_of(abs(time)) for time in away])
    words = np.empty(len(times), object)
    for unit in np.unique(units):
        own = units == unit
        gaps = np.diff(np.unique(away[own])) / SECONDS[unit]
        digits = max(2, digits_for(gaps.min()) if len(gaps) else 0)
        words[own] = [f"{name} {'−' if time < 0 else '+'} {abs(time) / SECONDS[unit]:.{digits}f} {NAMES[unit]}"
                      for time in away[own]]
    return words
