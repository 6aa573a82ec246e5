"""Pore pressure of wells in an aquifer along a fault: any number of them, each with a history of rates or of pressures, superposed (Theis 1935).

A well whose rate changes by dQ at the time s adds p* E1(r^2 / (4 D (t - s))), p* = dQ eta / (4 pi k h), with E1 the exponential integral: the pressure of a line source in a layer of the
thickness h, permeability k and hydraulic diffusivity D, filled with a fluid of the viscosity eta. That is the source of -fault_injection.
"""

from dataclasses import dataclass

import numpy as np

from .errors import Error
from .modules import csv_rows

TIMES = {"s": 1.0, "hours": 3600.0, "days": 86400.0}  # columns, and their seconds
PRESSURES = {"Pa": 1.0, "MPa": 1e6}
RATES = {"m3/s": 1.0, "L/s": 1e-3, "m3/day": 1 / 86400.0}
PER_DECADE = 8  # steps of a rate that holds a pressure, a decade of time
LEAST_STEP = 1e-6  # the first of them over the time until the next change
TOGETHER = 0.01  # of the age of steps that are taken together
HALVINGS = 20  # of an interval between two changes, in which the pressure is linear in the record


@dataclass(frozen=True)
class Well:
    """name; place: x, y, z [m], y NaN where the file has none; time [n] from when on [s]; value [n] [Pa], or [m^3/s] where it is no pressure."""

    name: str
    place: np.ndarray
    time: np.ndarray
    value: np.ndarray
    is_pressure: bool


def _column(path, head, units, what):
    found = [name for name in head if name in units]
    if len(found) != 1:
        raise Error(f"{path}: the first line is {','.join(head)}, expected one column {what}: {' or '.join(units)}")
    return found[0]


def read_wells(path):
    """The wells of a CSV file: columns well (a name), x, z and perhaps y [m], days (or hours, s), and MPa (Pa) or m3/day (L/s, m3/s). A row says what holds from its time on, until
    the next one of that well. Error: what the file does not hold, with its line."""
    rows = csv_rows(path)
    if len(rows) < 2:
        raise Error(f"{path} has no rows, expected a line of names and a line for each change of a well")
    head = rows[0][1]
    when, what = _column(path, head, TIMES, "of times"), _column(path, head, {**PRESSURES, **RATES}, "of pressures or rates")
    known = ["well", "x", "y", "z", when, what]
    if not {"well", "x", "z"} <= set(head) or set(head) - set(known) or len(set(head)) < len(head):
        raise Error(f"{path}: the first line is {','.join(head)}, expected well,x,y,z,{when},{what}, of which y may be left out")
    found = {}
    for number, row in rows[1:]:
        try:
            if len(row) != len(head) or not row[head.index("well")]:
                raise ValueError
            numbers = {name: float(row[head.index(name)]) if name in head else np.nan for name in known[1:]}
            if not all(np.isfinite(value) for name, value in numbers.items() if name in head):
                raise ValueError
        except ValueError:
            raise Error(f"{path}, line {number}: expected a name and {len(head) - 1} finite numbers for {','.join(head)}") from None
        place, time = np.array([numbers[name] for name in "xyz"]), numbers[when] * TIMES[when]
        value = numbers[what] * {**PRESSURES, **RATES}[what]
        well = found.setdefault(row[head.index("well")], (place, [], []))
        if not np.array_equal(well[0], place, equal_nan=True):
            raise Error(f"{path}, line {number}: the well {row[head.index('well')]} is at {tuple(map(float, place))}, and at {tuple(map(float, well[0]))} before: expected one place")
        if well[1] and time <= well[1][-1]:
            raise Error(f"{path}, line {number}: {numbers[when]:g} {when} is not after the line before of this well: expected times that rise")
        well[1].append(time)
        well[2].append(value)
    return [Well(name, place, np.array(time), np.array(value), what in PRESSURES) for name, (place, time, value) in found.items()]


def _substeps(begin, end):
    """Times from begin to end at which the rate that holds a pressure changes, and its end."""
    span = end - begin
    return begin + span * np.concatenate([[0.0], np.logspace(np.log10(LEAST_STEP), 0, int(np.ceil(-PER_DECADE * np.log10(LEAST_STEP))) + 1)])


class Pressure:
    """The pressure of wells at places.

    wells        of one kind, from read_wells()
    diffusivity  D [m^2/s]
    places       [n, 3] [m]
    area         [n] [m^2] of the cells there: a cell around a well has the mean of a disc of its area, as with -fault_injection
    end          [s], until when it is asked for
    per_rate     p* over the rate, eta / (4 pi k h) [Pa s/m^3], of wells with rates
    radius       of the wells [m], where their pressure is, of wells with pressures

    The rate that holds a well's pressure is one step after the other, eight a decade of the time since its last change, at whose ends all wells have their pressures.
    """

    def __init__(self, wells, diffusivity, places, area, end, per_rate=None, radius=None):
        if len({well.is_pressure for well in wells}) > 1:
            raise Error("some wells have pressures and others rates: expected one of them")
        self.diffusivity = diffusivity
        self.corners = np.unique(np.concatenate([well.time for well in wells]))
        at = np.array([np.where(np.isnan(well.place), places[:, 1].mean(), well.place) for well in wells])
        self.distance2 = np.maximum(((places[:, None, :] - at) ** 2).sum(axis=2), area[:, None] / (np.pi * np.e))
        if wells[0].is_pressure:
            self.steps = self._held(wells, at, end, radius)
        else:
            self.steps = [(time, j, step * per_rate) for j, well in enumerate(wells) for time, step in zip(well.time, np.diff(well.value, prepend=0.0)) if step]
        self.steps = sorted(step for step in self.steps if step[0] < end)

    def _held(self, wells, at, end, radius):
        """Steps (time, well, p*) by which wells have their pressures at their radius at the end of each."""
        from scipy.special import exp1
        distance2 = ((at[:, None, :] - at) ** 2).sum(axis=2)
        apart = distance2[~np.eye(len(wells), dtype=bool)]
        if apart.size and apart.min() <= (2 * radius) ** 2:
            raise Error(f"two wells are less than two radii, {2 * radius:g} m, apart: expected wells at different places")
        np.fill_diagonal(distance2, radius ** 2)
        changes = [time for time in self.corners if time < end] + [end]
        begins, ends = [], []
        for low, high in zip(changes, changes[1:]):
            times = _substeps(low, high)
            begins += list(times[:-1])
            ends += list(times[1:])
        begins, ends = np.array(begins), np.array(ends)
        wanted = np.array([[well.value[k - 1] if (k := np.searchsorted(well.time, begin, side="right")) else 0.0 for well in wells] for begin in begins])
        size = np.zeros((len(begins), len(wells)))
        for k, time in enumerate(ends):
            kernel = exp1(distance2 / (4 * self.diffusivity * (time - begins[:k + 1, None, None])))
            size[k] = np.linalg.solve(kernel[k], wanted[k] - np.einsum("kij,kj->i", kernel[:k], size[:k]))
        return [(begins[k], j, size[k, j]) for k in range(len(begins)) for j in range(len(wells)) if size[k, j]]

    def __call__(self, time):
        """[n] [Pa] at a time [s]."""
        from scipy.special import exp1
        found = np.zeros(len(self.distance2))
        for j, age, size, moment in self._together(time):
            x = self.distance2[:, j] / (4 * self.diffusivity * age)
            found += size * exp1(x)
            if moment:
                found += moment / age * np.exp(-x)
        return found

    def _together(self, time):
        """Steps before a time, those of a well whose ages agree to TOGETHER as one: well, its first age [s], sum of p* and of p* times (age - first age). E1 goes by its tangent there,
        dE1/d(age) = exp(-x)/age, off by p* TOGETHER^2/2 at most: what holds a pressure is many steps of its first minutes, which are one after days."""
        open_, done = {}, []
        for begin, j, size in self.steps:
            if begin >= time:
                break
            age = time - begin
            if j in open_ and open_[j][1] - age <= TOGETHER * open_[j][1]:
                open_[j][2] += size
                open_[j][3] += size * (age - open_[j][1])
            else:
                done += [open_[j]] if j in open_ else []
                open_[j] = [j, age, size, 0.0]
        return done + list(open_.values())

    def record(self, end, accuracy):
        """Times [m] [s] from 0 to end, pressures [m, n] [Pa] between which a straight line is off by accuracy times the largest pressure at most in the middle, and by how much it is."""
        known = {time: self(time) for time in (0.0, *self.corners[(self.corners > 0) & (self.corners < end)], end)}
        most, worst = 0.0, 0.0
        todo = list(zip(sorted(known), sorted(known)[1:]))
        for low, high in todo:  # the largest pressure first, which errors are over
            for k in range(1, 8):
                known[low + (high - low) * 2.0 ** -k] = self(low + (high - low) * 2.0 ** -k)
        most = max(np.abs(values).max() for values in known.values())
        todo = [(low, high, 0) for low, high in zip(sorted(known), sorted(known)[1:])]
        while todo:
            low, high, depth = todo.pop()
            middle = (low + high) / 2
            values = self(middle)
            error = np.abs(values - (known[low] + known[high]) / 2).max()
            if error <= accuracy * most or depth == HALVINGS:
                worst = max(worst, error)
                continue
            known[middle] = values
            todo += [(low, middle, depth + 1), (middle, high, depth + 1)]
        times = np.array(sorted(known))
        return times, np.array([known[time] for time in times]), worst
