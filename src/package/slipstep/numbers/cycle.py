"""Between and after events: coupling, episodes of slip within a window of rates, afterslip."""

import numpy as np

from .source import golden


def seismic_coupling(moment, plates):
    """Share of the moment that plates bring, shear modulus times area times rate times span [N m], which events release
    (Scholz and Campos 2012)."""
    return float(np.sum(moment) / plates)


def crossings(time, rate, level):
    """(begin, end) of each stretch with rates of a level or more, between rows by a straight line of the logarithm; cut
    at the first and last row."""
    fast = np.concatenate([[False], rate >= level, [False]])
    first, last = np.flatnonzero(fast[1:] & ~fast[:-1]), np.flatnonzero(fast[:-1] & ~fast[1:]) - 1

    def at(below, above):
        if rate[below] <= 0:
            return time[above]
        return (time[below] + (time[above] - time[below]) * np.log(level / rate[below])
                / np.log(rate[above] / rate[below]))

    return [(at(a - 1, a) if a > 0 else time[0], at(b + 1, b) if b + 1 < len(time) else time[-1])
            for a, b in zip(first, last)]


def episodes(time, rate, low, high, longest=np.inf):
    """Episodes whose largest slip rate is at least low and stays below high [m/s], and lasts no longer than `longest`
    [s]: list of (begin, end, largest rate).
    Slow slip: low ten times the plates' rate, high that of events; tremor-like: a higher low and a short `longest`."""
    found = []
    for begin, end in crossings(time, rate, low):
        inside = (time >= begin) & (time <= end)
        peak = float(rate[inside].max(initial=low))
        if peak < high and end - begin <= longest:
            found.append((float(begin), float(end), peak))
    return found


def fit_afterslip(time, slip):
    """(a, t0, root mean square) of slip = a ln(1 + time/t0), steady-state friction that grows with the logarithm of the
    rate (Marone et al. 1991): least squares, times [s] since the event. Slip in any unit, as moment."""
    time, slip = np.asarray(time, float), np.asarray(slip, float)

    def solve(log_t0):
        shape = np.log1p(time / np.exp(log_t0))
        a = (shape @ slip) / (shape @ shape)
        return a, np.sqrt(np.mean((slip - a * shape) ** 2))

    positive = time[time > 0]
    best = golden(lambda value: solve(value)[1],
                  np.linspace(np.log(positive.min()) - 5, np.log(positive.max()) + 5, 200))
    a, error = solve(best)
    return float(a), float(np.exp(best)), float(error)
