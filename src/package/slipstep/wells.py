"""Pore pressure of wells in an aquifer along a fault: any number of them, each with a history of rates or of pressures,
superposed (Theis 1935).

A well whose rate changes by dQ at the time s adds p* E1(r^2 / (4 D (t - s))), p* = dQ eta / (4 pi k h), with E1 the
exponential integral: the pressure of a line source in a layer of the thickness h, permeability k and hydraulic
diffusivity D, filled with a fluid of the viscosity eta. That is the source of -fault_injection.
"""

import functools
from dataclasses import dataclass

import numpy as np

from .checks import doubt
from .errors import Error, warn
from .modules import csv_rows
from .times import written

TIMES = {"s": 1.0, "hours": 3600.0, "days": 86400.0}  # columns, and their seconds
PRESSURES = {"Pa": 1.0, "MPa": 1e6}
SIZES = "radius", "spread"  # columns that may be left out
RATES = {"m3/s": 1.0, "L/s": 1e-3, "m3/day": 1 / 86400.0}
PER_DECADE = 8  # steps of a rate that holds a pressure, a decade of time
LEAST_STEP = 1e-6  # the first of them over the time until the next change
FELT = 5.0  # R^2/(4 D t) of a well's own radius from which on a rate is felt there: E1(5) = 1.1e-3
YOUNG = 30.0  # r^2/(4 D age) from which on a step is not felt: E1(30) = 3e-15
PER_E = 8  # ages between which E1 is interpolated, in a factor of e
AROUND = np.arange(-2, 4)  # six of them, about the age: E1 is off by 4e-7 at most
COARSE = 8  # steps in place of many, when these are longer ago than they are apart: off by 1e-6 of their sum
FINE = 0.05  # of the accuracy: what is left between the times at which a record is compared with straight lines
BLOCK = 2e7  # pressures in memory at once
HALVINGS = 20  # of an interval between two of those times
FAR = 10.0  # r^2/(4 D t) of the nearest cell, E1(10) = 4e-6, from which on a well is said not to reach the fault


@dataclass(frozen=True)
class Well:
    """name; place: x, y, z [m], y NaN where the file has none; time [n] from when on [s]; value [n] [Pa], or [m^3/s]
    where it is no pressure; radius, and standard deviation of a rate that is spread [m], NaN where the file has
    none."""

    name: str
    place: np.ndarray
    time: np.ndarray
    value: np.ndarray
    is_pressure: bool
    radius: float = np.nan
    spread: float = np.nan


def _column(path, head, units, what):
    found = [name for name in head if name in units]
    if len(found) != 1:
        raise Error(f"{path}: the first line is {','.join(head)}, expected one column {what}: {' or '.join(units)}")
    return found[0]


def read_wells(path):
    """The wells of a CSV file: columns well (a name), x, z and perhaps y [m], days (or hours, s), and MPa (Pa) or
    m3/day (L/s, m3/s); for -fault_wells also radius and spread [m]. A row says what holds from its time on, until the
    next one of that well. Error: what the file does not hold, with its line."""
    rows = csv_rows(path)
    if len(rows) < 2:
        raise Error(f"{path} has no rows, expected a line of names and a line for each change of a well")
    head = rows[0][1]
    when, what = _column(path, head, TIMES, "of times"), _column(path, head, {**PRESSURES, **RATES},
                                                                 "of pressures or rates")
    known = ["well", "x", "y", "z", when, what, *SIZES]
    if not {"well", "x", "z"} <= set(head) or set(head) - set(known) or len(set(head)) < len(head):
        raise Error(f"{path}: the first line is {','.join(head)}, expected well,x,y,z,{when},{what},radius,spread, of "
                    "which y, radius and spread may be left out")
    found = {}
    for number, row in rows[1:]:
        try:
            if len(row) != len(head) or not row[head.index("well")]:
                raise ValueError
            numbers = {name: float(row[head.index(name)]) if name in head else np.nan for name in known[1:]}
            if not all(np.isfinite(value) for name, value in numbers.items() if name in head):
                raise ValueError
        except ValueError:
            raise Error(f"{path}, line {number}: expected a name and {len(head) - 1} finite numbers for "
                        f"{','.join(head)}") from None
        place, time = np.array([numbers[name] for name in "xyz"]), numbers[when] * TIMES[when]
        value = numbers[what] * {**PRESSURES, **RATES}[what]
        sizes = [numbers[name] for name in SIZES]
        well = found.setdefault(row[head.index("well")], (place, [], [], sizes))
        if not np.array_equal(well[0], place, equal_nan=True):
            raise Error(f"{path}, line {number}: the well {row[head.index('well')]} is at {tuple(map(float, place))}, "
                        f"and at {tuple(map(float, well[0]))} before: expected one place")
        if not np.array_equal(well[3], sizes, equal_nan=True):
            raise Error(f"{path}, line {number}: the well {row[head.index('well')]} has another radius or spread than "
                        "before: expected one")
        if well[1] and time <= well[1][-1]:
            raise Error(f"{path}, line {number}: {numbers[when]:g} {when} is not after the line before of this well: "
                        "expected times that rise")
        well[1].append(time)
        well[2].append(value)
    return [Well(name, place, np.array(time), np.array(value), what in PRESSURES, *sizes)
            for name, (place, time, value, sizes) in found.items()]


def _substeps(begin, end, felt):
    """Times at which the rate that holds a pressure changes; felt: until it is felt at the radius [s]."""
    span = end - begin
    least = min(max(LEAST_STEP, felt / span), 1.0)
    return (begin + span
            * np.concatenate([[0.0], np.logspace(np.log10(least), 0, int(np.ceil(-PER_DECADE * np.log10(least))) + 1)]))


def _lagrange(nodes, at):
    """[nodes, *at]: the polynomials that are 1 at one node and 0 at the others."""
    away = [at - node for node in nodes]
    return np.array([functools.reduce(np.multiply, [away[k] / (node - other) for k, other in enumerate(nodes)
                                                    if other != node]) for node in nodes])


@dataclass(frozen=True)
class Steps:
    """begin [k] [s], size [k, wells] p* [Pa], which count at times from since [k] on and before until [k] [s]."""

    begin: np.ndarray
    size: np.ndarray
    since: np.ndarray
    until: np.ndarray

    @classmethod
    def join(cls, parts):
        return cls(*(np.concatenate([getattr(part, name) for part in parts])
                     for name in ("begin", "size", "since", "until")))

    @classmethod
    def of(cls, begin, size, since=-np.inf):
        return cls(begin, size, np.full(len(begin), since), np.full(len(begin), np.inf))


class History:
    """Steps of spans of time, one after the other. When a span, or two of equal numbers of them, and so on, are longer
    ago than they are long, COARSE steps count in place of theirs."""

    def __init__(self):
        # of the spans that wait for the next one: their begin and Steps by how many they are
        self.parts, self.open = [], {}

    def add(self, low, high, begin, size):
        parts, count = [Steps.of(begin, size)], 1
        self.parts += parts
        while True:
            steps = Steps.join(parts)
            if len(steps.begin) > COARSE:
                nodes = (low + high) / 2 + (high - low) / 2 * np.cos(np.pi * (np.arange(COARSE) + 0.5) / COARSE)
                old = 2 * high - low
                for part in parts:
                    part.until[:] = old
                parts = [Steps.of(nodes, _lagrange(nodes, steps.begin) @ steps.size, old)]
                self.parts += parts
            if count not in self.open:
                self.open[count] = low, parts
                return
            low, before = self.open.pop(count)
            parts, count = before + parts, 2 * count

    @property
    def steps(self):
        return Steps.join(self.parts)


class Response:
    """E1(r^2/(4 D age)) of wells at places by a product of matrices: the sum over steps of any ages is one over nodes,
    as many in each factor of e of the ages, with E1 between them by polynomials of the logarithm.

    distance2    [places, wells] [m^2]
    oldest       the largest age [s]
    """

    def __init__(self, distance2, diffusivity, oldest):
        from scipy.special import exp1
        self.youngest = distance2.min() / (4 * diffusivity * YOUNG)
        self.nodes = max(int(np.ceil(PER_E * np.log(oldest / self.youngest))), 0) + len(AROUND)
        ages = self.youngest * np.exp((np.arange(self.nodes) + AROUND[0]) / PER_E)
        # [wells * nodes, places]
        self.kernel = np.concatenate([exp1(column / (4 * diffusivity * ages[:, None])) for column in distance2.T])

    def shares(self, steps, times):
        """[times, wells * nodes] [Pa], which times the kernel is the pressure."""
        wells = steps.size.shape[1]
        found = np.zeros((len(times), wells, self.nodes))
        keep = ((steps.begin < times.max(initial=-np.inf)) & (steps.since <= times.max(initial=-np.inf))
                & (steps.until > times.min(initial=np.inf)))
        begin, size, since, until = (part[keep] for part in (steps.begin, steps.size, steps.since, steps.until))
        ages = times[:, None] - begin
        row, step = np.nonzero((ages > self.youngest) & (times[:, None] >= since) & (times[:, None] < until))
        at = np.log(ages[row, step] / self.youngest) * PER_E
        node = np.floor(at).astype(int)
        for offset, weight in zip(AROUND, _lagrange(AROUND, at - node)):
            for j in range(wells):
                found[:, j] += np.bincount(row * self.nodes + node + offset - AROUND[0], weight * size[step, j],
                                           found[:, j].size).reshape(-1, self.nodes)
        return found.reshape(len(times), -1)


class Pressure:
    """The pressure of wells at places.

    wells        of one kind, from read_wells()
    diffusivity  D [m^2/s]
    places       [n, 3] [m]
    area         [n] [m^2] of the cells there: a cell around a well has the mean of a disc of its area, as with
                 -fault_injection
    end          [s], until when it is asked for
    per_rate     p* over the rate, eta / (4 pi k h) [Pa s/m^3], of wells with rates
    radius       of the wells [m], where their pressure is, of wells with pressures

    The rate that holds a well's pressure is one step after the other, eight a decade of the time since its last change,
    at whose ends all wells have their pressures. Error: wells above the ground or in one place. A SlipStepWarning for
    each well whose pressure does not reach the places until the end, and for numbers that look as in another unit."""

    def __init__(self, wells, diffusivity, places, area, end, per_rate=None, radius=None):
        if len({well.is_pressure for well in wells}) > 1:
            raise Error("some wells have pressures and others rates: expected one of them")
        self.diffusivity, self.end = diffusivity, end
        self.corners = np.unique(np.concatenate([well.time for well in wells]))
        self.first = self.corners[0]
        at = np.array([np.where(np.isnan(well.place), places[:, 1].mean(), well.place) for well in wells])
        for well in wells:
            if well.place[2] < 0 <= places[:, 2].min():
                raise Error(f"the well {well.name} is at z = {well.place[2]:g} m, above the ground: expected a depth, "
                            f"as those of the cells, {places[:, 2].min():g} to {places[:, 2].max():g} m")
            doubt(f"the largest {'pressure' if well.is_pressure else 'rate'} of the well {well.name}",
                  "pressure" if well.is_pressure else "rate", np.abs(well.value).max())
            doubt(f"the last time of the well {well.name}", "time", well.time[-1])
        self.distance2 = np.maximum(((places[:, None, :] - at) ** 2).sum(axis=2), area[:, None] / (np.pi * np.e))
        self._tell_far(wells, places)
        changes = [time for time in self.corners if time < end] + [end]
        if wells[0].is_pressure:
            self.steps = self._held(wells, at, changes, radius)
        else:
            history = History()
            for low, high, change in zip(changes, changes[1:],
                                         np.diff(self._wanted(wells, changes), axis=0, prepend=0.0)):
                history.add(low, high, np.array([low]), change[None] * per_rate)
            self.steps = history.steps
        self.response = Response(self.distance2, diffusivity, end - self.first)

    def _tell_far(self, wells, places):
        low, high = places.min(axis=0), places.max(axis=0)
        for well, nearest in zip(wells, self.distance2.min(axis=0)):
            since = self.end - well.time[0]
            if since > 0 and nearest > FAR * 4 * self.diffusivity * since:
                warn(f"the pressure of the well {well.name} does not reach the fault until {written(self.end)}: it is "
                     f"{np.sqrt(nearest):.4g} m from the nearest cell, and sqrt(4 D t) is "
                     f"{np.sqrt(4 * self.diffusivity * since):.4g} m. Expected places in the frame of the cells, x = "
                     f"{low[0]:.6g} to {high[0]:.6g}, y = {low[1]:.6g} to {high[1]:.6g}, "
                     f"z = {low[2]:.6g} to {high[2]:.6g} m")

    @staticmethod
    def _wanted(wells, changes):
        """[changes - 1, wells] what holds between two of them."""
        return np.array([[well.value[k - 1] if (k := np.searchsorted(well.time, begin, side="right")) else 0.0
                          for well in wells] for begin in changes[:-1]])

    def _held(self, wells, at, changes, radius):
        """Steps by which wells have their pressures at their radius at the end of each."""
        from scipy.special import exp1
        distance2 = ((at[:, None, :] - at) ** 2).sum(axis=2)
        apart = distance2[~np.eye(len(wells), dtype=bool)]
        if apart.size and apart.min() <= (2 * radius) ** 2:
            raise Error(f"two wells are less than two radii, {2 * radius:g} m, apart: expected wells at "
                        "different places")
        np.fill_diagonal(distance2, radius ** 2)
        felt = radius ** 2 / (4 * self.diffusivity * FELT)
        if min(np.diff(changes)) < felt:
            raise Error(f"a pressure is held for {min(np.diff(changes)):.4g} s, in which no rate is felt at a radius "
                        f"of {radius:g} m: expected changes {felt:.4g} s apart at least, or a smaller radius")
        response = Response(distance2, self.diffusivity, self.end - self.first)
        past = History()
        for low, high, wanted in zip(changes, changes[1:], self._wanted(wells, changes)):
            times = _substeps(low, high, felt)
            begins, ends = times[:-1], times[1:]
            missing = wanted - (response.shares(past.steps, ends) @ response.kernel if past.parts
                                else np.zeros((len(ends), len(wells))))
            size = np.zeros((len(begins), len(wells)))
            for k, time in enumerate(ends):
                kernel = exp1(distance2 / (4 * self.diffusivity * (time - begins[:k + 1, None, None])))
                size[k] = np.linalg.solve(kernel[k], missing[k] - np.einsum("kij,kj->i", kernel[:k], size[:k]))
            past.add(low, high, begins, size)
        return past.steps

    def __call__(self, time):
        """[n] [Pa] at a time [s] until the end; of times [m] [m, n]."""
        found = self.response.shares(self.steps, np.atleast_1d(np.asarray(time, float))) @ self.response.kernel
        return found if np.ndim(time) else found[0]

    def record(self, accuracy, tell=lambda text: None):
        """Times [m] [s] from 0 to the end, pressures [m, n] [Pa] between which a straight line is off by accuracy times
        the largest pressure at most, at any time, and a bound of by how much it is. tell() is called with how far it
        is."""
        times = self._samples()
        shares = self._shares(times, tell)
        kernel, rows = self.response.kernel, max(int(BLOCK / self.response.kernel.shape[1]), 1)
        most = max(np.abs(shares[k:k + rows] @ kernel).max() for k in range(0, len(times), rows))
        times, shares, left = self._refined(times, shares, FINE * accuracy * most, rows, tell)
        chosen, pressures, worst = _fewest(times, (row for k in range(0, len(times), rows) for row in shares[k:k + rows]
                                                   @ kernel), (1 - 2 * FINE) * accuracy * most, tell)
        return times[chosen], pressures, worst + left

    def _samples(self):
        """Changes, and times after each, twice as late one after the other, from when the nearest cell feels it."""
        corners = [0.0, *self.corners[(self.corners > 0) & (self.corners < self.end)], self.end]
        least = self.response.youngest
        return np.unique(np.concatenate([[low, high, *(low + (high - low) * 2.0 ** -np.arange(
            1, max(np.log2((high - low) / least), 1) + 1))] for low, high in zip(corners, corners[1:])]))

    def _shares(self, times, tell):
        rows = max(int(BLOCK / len(self.steps.begin)), 1)
        parts = []
        for k in range(0, len(times), rows):
            tell(f"pressures: {written(times[k])} of {written(self.end)}")
            parts.append(self.response.shares(self.steps, times[k:k + rows]))
        return np.concatenate(parts)

    def _refined(self, times, shares, enough, rows, tell):
        """Times between which a straight line is off by enough at most in the middle, where it is off most when they
        are that close, their shares, and by how much it is."""
        todo, left = np.arange(len(times) - 1), 0.0
        for depth in range(HALVINGS + 1):
            middle = (times[todo] + times[todo + 1]) / 2
            between = self._shares(middle, tell)
            off = np.concatenate([np.abs((between[k:k + rows]
                                          - (shares[todo[k:k + rows]] + shares[todo[k:k + rows] + 1]) / 2)
                                         @ self.response.kernel).max(axis=1) for k in range(0, len(todo), rows)])
            keep = off > enough if depth < HALVINGS else np.zeros(len(off), dtype=bool)
            left = max(left, off[~keep].max(initial=0.0))
            if not keep.any():
                return times, shares, left
            order = np.argsort(np.concatenate([times, middle[keep]]), kind="stable")
            begins = np.isin(order, np.concatenate([todo[keep], len(times) + np.arange(keep.sum())]))  # of halves
            times, shares = np.concatenate([times, middle[keep]])[order], np.concatenate([shares, between[keep]])[order]
            todo = np.flatnonzero(begins)


def _fewest(times, values, accuracy, tell):
    """Numbers of the times between which straight lines are off by accuracy at most at all others, from one as far as
    it goes, their values, and by how much they are off: the slopes of lines from there that pass all later times within
    the accuracy are an interval, which only shrinks."""
    values = iter(values)
    first = next(values)
    chosen, kept, worst = [0], [first], 0.0
    ahead = []  # (number, values) since the last chosen one
    number, waiting = 1, []
    low = high = None
    best = None
    while True:
        row = waiting.pop(0) if waiting else next(values, None)
        if row is not None:
            span = times[number] - times[chosen[-1]]
            slope, slack = (row - kept[-1]) / span, accuracy / span
            if low is None:
                low, high = np.full_like(slope, -np.inf), np.full_like(slope, np.inf)
            ahead.append(row)
            if ((slope >= low) & (slope <= high)).all():
                best = len(ahead)
            np.maximum(low, slope - slack, out=low)
            np.minimum(high, slope + slack, out=high)
            number += 1
            if (low <= high).all():
                continue
        elif not ahead:
            return np.array(chosen), np.array(kept), worst
        start, to = chosen[-1], ahead[best - 1]
        for k, passed in enumerate(ahead[:best - 1], start + 1):
            share = (times[k] - times[start]) / (times[start + best] - times[start])
            worst = max(worst, np.abs(passed - kept[-1] - share * (to - kept[-1])).max())
        chosen.append(start + best)
        kept.append(to)
        tell(f"straight lines: {written(times[chosen[-1]])} of {written(times[-1])}")
        waiting = ahead[best:] + waiting
        number, ahead, low, high, best = chosen[-1] + 1, [], None, None, None
