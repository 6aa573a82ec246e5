"""Events and the fluid that makes them: where a fluid enters a run, how far from there and how late events are, the
diffusivity of their front and of the quiet behind it, and the volume that went in."""

import os
import shlex
from dataclasses import dataclass

import numpy as np

from ..errors import OutputError
from ..wells import read_wells

SHARE = 0.95  # of events that the triggering front leaves behind, and of those that the back front has before it
LEAST = 5  # events without which a front is not fitted
DRAWS = 400  # of the bootstrap
GALIS = 1.5e9  # N m^-3.5: gamma of the largest events that Galis et al. (2017) compare with volumes


@dataclass(frozen=True)
class Source:
    """Where and when fluid enters: name; place x, y, z [m], y NaN where unknown; begin, and stop (inf: none) [s]."""

    name: str
    place: np.ndarray
    begin: float
    stop: float


def words(run):
    """The options of a run by their names, without the hyphen."""
    found, name = {}, None
    for word in shlex.split(str(run.run.get("options", ""))):
        if word.startswith("-") and word[1:2].isalpha():
            name = word[1:]
            found[name] = ""
        elif name:
            found[name] += (" " if found[name] else "") + word
    return found


def sources_of(run, path=None):
    """Of the wells of a CSV file, of that of the run's -fault_wells, or of its -fault_injection; none: []."""
    options = words(run)
    named = path or options.get("fault_wells")
    if named:
        beside = os.path.join(os.path.dirname(os.path.abspath(run.path)), named)
        found = []
        for well in read_wells(named if path or os.path.exists(named) else beside):
            flows = np.flatnonzero(well.value)
            if len(flows):
                last = flows[-1] + 1
                found.append(Source(well.name, well.place, well.time[flows[0]],
                                    well.time[last] if last < len(well.time) else np.inf))
        return found
    if "fault_injection" in options:
        at = [float(word) for word in options["fault_injection"].split(",")]
        place = np.array(at if len(at) == 3 else [at[0], np.nan, at[1]])
        return [Source("-fault_injection", place, 0.0, run.parameters.get("injection_stop", 0.0) or np.inf)]
    return []


def places_of(run):
    """Places of the cells [N, 3] as wells have them; of a grid in its plane, y 0 and down dip in place of depth, and a
    function that brings wells there."""
    if run.planes:
        cells = np.column_stack([run.mesh[name] for name in "xyz"])

        def bring(place):
            if np.isfinite(place[1]):
                return place
            near = np.argmin(np.hypot(cells[:, 0] - place[0], cells[:, 2] - place[2]))
            return np.array([place[0], cells[near, 1], place[2]])
        return cells, bring
    x, z = run.axes
    down = run.mesh.get("down_dip", z)
    cells = np.column_stack([np.tile(x, len(z)), np.zeros(len(x) * len(z)), np.repeat(down, len(x))])
    slope = (down[-1] - down[0]) / (z[-1] - z[0]) if len(z) > 1 else 1.0
    return cells, lambda place: np.array([place[0], 0.0, down[0] + slope * (place[2] - z[0])])


def migration(run, events, sources):
    """Of each event the distance [m] from the nearest source that has begun, the time [s] since that began, and its
    number; NaN, NaN, -1 before the first one. events: onset, cell."""
    cells, bring = places_of(run)
    at = cells[np.asarray(events["cell"], int)]
    onset = np.asarray(events["onset"], float)
    away = np.array([np.linalg.norm(at - bring(source.place), axis=1) for source in sources])
    since = np.array([onset - source.begin for source in sources])
    away[since <= 0] = np.inf
    nearest = away.argmin(axis=0)
    distance, time = (np.take_along_axis(part, nearest[None], axis=0)[0] for part in (away, since))
    none = ~np.isfinite(distance)
    return np.where(none, np.nan, distance), np.where(none, np.nan, time), np.where(none, -1, nearest)


def front(diffusivity, time):
    """Triggering front r = sqrt(4 pi D t) [m] of a pressure that diffuses (Shapiro et al. 1997)."""
    return np.sqrt(4 * np.pi * diffusivity * np.maximum(time, 0))


def back_front(diffusivity, time, stop, dimension):
    """Back front [m], from the well to which the pressure has begun to fall at a time > stop, when the injection at a
    constant rate from 0 on ended (Parotidis et al. 2004): where in a space of this dimension dp/dt = 0."""
    time = np.asarray(time, float)
    with np.errstate(divide="ignore", invalid="ignore"):
        square = 2 * dimension * diffusivity * time * (time / stop - 1) * np.log(time / (time - stop))
    return np.sqrt(np.where(time > stop, square, 0.0))


def quantile(values, share, seed=1):
    """A quantile and its standard error by the bootstrap."""
    random = np.random.default_rng(seed)
    drawn = np.quantile(random.choice(values, (DRAWS, len(values))), share, axis=1)
    return float(np.quantile(values, share)), float(drawn.std())


def fit_front(distance, time):
    """(D, its standard error) [m^2/s] of the front that SHARE of the events do not pass; None: too few events. Each
    event alone would have the front at its place at its time with D = r^2/(4 pi t). Of a front the early and near
    events say as much as the late and far ones: D is a quantile of these, which a few events beyond the front, by
    stress and not by fluid, do not move, as they would the largest."""
    good = np.isfinite(distance) & (time > 0)
    if good.sum() < LEAST:
        return None
    return quantile(distance[good] ** 2 / (4 * np.pi * time[good]), SHARE)


def fit_back_front(distance, time, stop, dimension):
    """(D, its standard error) of the back front, beyond which SHARE of the events after the stop are; None: too
    few."""
    good = np.isfinite(distance) & (time > stop)
    if good.sum() < LEAST:
        return None
    return quantile((distance[good] / back_front(1.0, time[good], stop, dimension)) ** 2, 1 - SHARE)


def volumes_of(run):
    """Injected volume [m^3] at the times of the series; None where the run has none."""
    volume = run.series.get("injected_volume")
    if volume is None:
        return None
    volume = np.asarray(volume, float)
    return volume.sum(axis=1) if volume.ndim > 1 else volume


def largest_so_far(time, onsets, moments):
    """The largest moment of the events that have begun, at each time."""
    order = np.argsort(onsets)
    peak = np.concatenate([[0.0], np.maximum.accumulate(np.abs(moments)[order])])
    return peak[np.searchsorted(np.asarray(onsets)[order], time, side="right")]


def bounds(volume, modulus, gamma=GALIS):
    """{what: largest moment [N m]} of an injected volume [m^3]: G dV (McGarr 2014), and gamma dV^1.5 of ruptures that
    arrest by themselves (Galis et al. 2017)."""
    if not modulus > 0:
        raise OutputError(f"the shear modulus is {modulus:g} Pa, expected a positive number")
    volume = np.maximum(volume, 0)
    return {"G ΔV (McGarr 2014)": modulus * volume,
            f"γ ΔV$^{{3/2}}$, γ = {gamma:.3g} N m$^{{-7/2}}$ (Galis et al. 2017)": gamma * volume ** 1.5}
