"""The moment-rate function of a run, and moment magnitudes."""

import numpy as np

from ..errors import OutputError
from ..times import written


def moment_rate(run, begin, end):
    """Times since begin [s], moment rates [N m/s] and moments since begin [N m], both [n, faults], of the steps from
    begin to end and of both ends.

    Within a step a rate goes by a straight line of its logarithm, as that of the catalogue does, and the moment as its
    integral; by a straight line of itself where the rate of one end is no more than 0. Files of before SlipStep 0.4
    have no moments: trapezoids of the rates.
    """
    if "moment_rate" not in run.series:
        raise OutputError(f"{run.path}: no /series/moment_rate; expected a run of SlipStep 0.3 or later")
    time, rate = run.series["time"], np.asarray(run.series["moment_rate"])
    if not (len(time) and begin < end and time[0] <= end and begin <= time[-1]):
        raise OutputError(f"{run.path}: no steps from {written(begin)} to {written(end)}")
    total = run.series.get("moment")
    start = run.steps["time"][0] if len(run.steps["time"]) else time[0]
    # files of SlipStep 0.4 and older have no row of the start: that of a straight line with the first step's moment, or
    # rest
    if start < time[0]:
        first = np.zeros_like(rate[0]) if total is None else np.maximum(2 * total[0] / (time[0] - start) - rate[0], 0)
        time, rate = np.append(start, time), np.vstack([first, rate])
        total = total if total is None else np.vstack([np.zeros_like(rate[0]), total])
    if total is None:
        total = np.vstack([np.zeros_like(rate[0]),
                           np.cumsum(np.diff(time)[:, None] * (rate[1:] + rate[:-1]) / 2, axis=0)])

    def within(at):
        """Rate and moment at a time."""
        k = int(np.clip(np.searchsorted(time, at) - 1, 0, max(len(time) - 2, 0)))
        if len(time) < 2 or not time[k] < time[k + 1]:
            return rate[k], total[k]
        x, low, high = np.clip((at - time[k]) / (time[k + 1] - time[k]), 0, 1), rate[k], rate[k + 1]
        grows = (low > 0) & (high > 0)
        growth = np.log(np.where(grows, high, 1) / np.where(grows, low, 1))
        curved = grows & (np.abs(growth) > 1e-6)
        safe = np.where(curved, growth, 1.0)
        straight = low + x * (high - low)
        whole = np.where(low + high == 0, 1.0, low + high)
        share = np.where(curved, np.expm1(safe * x) / np.expm1(safe),
                         np.where(low + high == 0, x, x * (low + straight) / whole))
        return np.where(curved, low * np.exp(growth * x), straight), total[k] + share * (total[k + 1] - total[k])

    inside = (time > begin) & (time < end)
    ends = [within(at) for at in (begin, end)]
    rates, moments = (np.vstack([ends[0][i], column[inside], ends[1][i]]) for i, column in enumerate((rate, total)))
    return np.concatenate([[0.0], time[inside] - begin, [end - begin]]), rates, moments - moments[0]


def magnitude(moment):
    """Moment magnitude of the standard of the IASPEI (2013), that of the catalogue."""
    return 2 / 3 * (np.log10(moment) - 9.1) if moment > 0 else np.nan
