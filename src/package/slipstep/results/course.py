"""The error of a run against a reference, of its whole course: what a position of the accuracy dial promises.

A course is mean slip s(t) and mean slip rate at the ends of the accepted steps, the start included, and the final slip
of every cell. Between steps s(t) is the cubic Hermite polynomial of both. All measures are relative:

    final    |s(T) / s_ref(T) - 1|
    history  largest |s(t) - s_ref(t)| over time, over s_ref(T). The difference is a cubic between neighbours of both
             runs' times together, so its extrema are known and no sampling is needed.
    shift    |t_half - t_half,ref| / (t_90,ref - t_10,ref): t_x is when a run first reaches x % of its own final slip
    peak     |largest rate / largest rate_ref - 1|, of the derivatives of the cubics
    field    root mean square of the difference of the final slips of the cells, weighted by area, over that of s_ref

and a run's error is of MEASURES one that the user chose: `history` is the largest of all, the peak counting a fifth.
"""

import dataclasses

import numpy as np

from .files import open_file

PEAK_WEIGHT = 0.2
PARTS = ("final", "history", "shift", "peak", "field")
MEASURES = {
    "history": lambda e: max(1.0 * e["final"], e["history"], e["shift"], PEAK_WEIGHT * e["peak"], e["field"]),
    "final_slip": lambda e: e["final"],
    "event_time": lambda e: e["shift"],
}
SAME_END = 1e-9  # ends of two runs may differ by so much of the time: both add steps up
BISECTIONS = 60  # halves of a step until rounding


class CourseError(Exception):
    """Two courses cannot be compared; the message says why."""


@dataclasses.dataclass
class Course:
    """time [s], slip [m] and rate [m/s], one value per accepted step and the start; field: final slip of each cell [m];
    area of each cell, in any unit; NumPy arrays, the last two None where nobody asks for them."""
    time: np.ndarray
    slip: np.ndarray
    rate: np.ndarray
    field: np.ndarray = None
    area: np.ndarray = None


def from_start(series, names=("time", "mean_slip", "mean_slip_rate")):
    """Columns of /series with the start. Files of SlipStep 0.4 and older have no row of it: their runs start at rest at
    time 0."""
    before = [0.0] if series["time"][:1] > 0 else []
    return [np.append(before, series[name][()]) for name in names]


def read(path):
    """The course of a run that started at rest at time 0, from its file (-fault_output with the field slip)."""
    with open_file(path, "fault -fault_output writes it") as file:
        series = from_start(file["series"])
        field = file["fields/slip"][-1].ravel()
        mesh = file["mesh"]
        area = mesh["length"][()] * mesh["width"][()] if "length" in mesh else np.ones(len(field))
        area = np.repeat(area, len(field) // len(area))  # slip may have two components
        if abs(file["fields/time"][-1] - series[0][-1]) > SAME_END * series[0][-1]:
            raise CourseError(f"{path}: the last row of /fields is of another time than the last of /series; expected "
                              "the run's end")
    return Course(*series, field, area)


# A cubic on each interval of a grid t [n]: coefficients c [4, n - 1] of s = c0 + c1 x + c2 x^2 + c3 x^3, x = t - t_k.


def hermite(course):
    h = np.diff(course.time)
    s, v = course.slip, course.rate
    secant = np.diff(s) / h
    return np.array([s[:-1], v[:-1], (3 * secant - 2 * v[:-1] - v[1:]) / h, (v[:-1] + v[1:] - 2 * secant) / h ** 2])


def value(c, x):
    return c[0] + x * (c[1] + x * (c[2] + x * c[3]))


def interval_of(course, times):
    return np.clip(np.searchsorted(course.time, times, side="right") - 1, 0, len(course.time) - 2)


def slip_at(course, times):
    """The course's cubics at some times."""
    k = interval_of(course, times)
    return value(hermite(course)[:, k], times - course.time[k])


def refine(course, times):
    """The course's cubics on the intervals of times, which contain its own."""
    k = interval_of(course, times[:-1])
    x, c = times[:-1] - course.time[k], hermite(course)[:, k]
    return np.array([value(c, x), c[1] + x * (2 * c[2] + 3 * x * c[3]), c[2] + 3 * x * c[3], c[3]])


def stationary(c, h):
    """Where the derivative is zero inside the intervals of lengths h: x [2, n - 1], 0 where there is no such point."""
    root = np.sqrt(np.maximum(c[2] ** 2 - 3 * c[1] * c[3], 0))
    q = -(c[2] + np.where(c[2] < 0, -root, root))  # without cancellation: x = q/(3 c3) and c1/q
    with np.errstate(divide="ignore", invalid="ignore"):
        x = np.array([q / (3 * c[3]), c[1] / q])
        inside = (x > 0) & (x < h) & (c[2] ** 2 > 3 * c[1] * c[3])
    return np.where(inside, x, 0)


def largest(c, h):
    """The largest |value| of cubics on intervals of lengths h."""
    x = np.vstack([np.zeros_like(h), h, stationary(c, h)])
    return float(np.abs(value(c, x)).max())


def passage(course, share):
    """When the cubics first reach a share of the final slip [s]."""
    c, h = hermite(course), np.diff(course.time)
    x = np.sort(np.vstack([np.zeros_like(h), stationary(c, h), h]), axis=0)  # monotone between neighbours
    level, s = share * course.slip[-1], value(c, x)
    pieces = np.argwhere((np.maximum(s[1:], s[:-1]) >= level).T)  # in the order of time
    if not len(pieces):
        return float(course.time[-1])
    k, piece = pieces[0]
    low, high = x[piece, k], x[piece + 1, k]
    if s[piece, k] >= level:
        return float(course.time[k] + low)
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if value(c[:, k], middle) >= level else (middle, high)
    return float(course.time[k] + high)


def peak(course):
    """The largest derivative of the cubics [m/s]."""
    c, h = hermite(course), np.diff(course.time)
    with np.errstate(divide="ignore", invalid="ignore"):
        x = -c[2] / (3 * c[3])
    x = np.where((x > 0) & (x < h), x, 0)
    return float(max(course.rate.max(), (c[1] + x * (2 * c[2] + 3 * x * c[3])).max()))


def history(run, reference):
    """The largest difference of mean slip at any time, over the final one of the reference."""
    times = np.append(np.union1d(run.time[:-1], reference.time[:-1]), reference.time[-1])
    return largest(refine(run, times) - refine(reference, times), np.diff(times)) / reference.slip[-1]


def errors(run, reference):
    """The parts of a run's error, by name, and the signed `slip_error` of its final mean slip."""
    if abs(run.time[-1] - reference.time[-1]) > SAME_END * reference.time[-1]:
        raise CourseError(f"a run ends at {run.time[-1]:.10g} s and its reference at {reference.time[-1]:.10g} s; "
                          "expected the same end")
    rise = passage(reference, 0.9) - passage(reference, 0.1)
    difference = run.field - reference.field
    slip_error = float(run.slip[-1] / reference.slip[-1] - 1)
    return {"slip_error": slip_error, "final": abs(slip_error), "history": history(run, reference),
            "shift": abs(passage(run, 0.5) - passage(reference, 0.5)) / rise,
            "peak": abs(peak(run) / peak(reference) - 1),
            "field": float(np.sqrt((run.area * difference ** 2).sum() / (run.area * reference.field ** 2).sum()))}
