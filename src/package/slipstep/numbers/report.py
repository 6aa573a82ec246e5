"""The numbers of a run and its catalogue, as many as their files have."""

import dataclasses

import numpy as np

from ..errors import OutputError
from ..geometry.cells import cells_of, normals, triangles_of
from ..results.fields import Fields, rupture_times
from ..results.magnitudes import b_error, b_value, completeness, completeness_by_fit
from ..results.moment import moment_rate
from ..times import since, written
from . import cycle, rupture, source, stress
from .spinup import LARGE, SpinUp, is_loaded, spin_up

FEWEST = 30  # events from the magnitude of completeness on, below which there is no b
SLOW = 10.0  # times the plates' rate: slip that is faster, and slower than events, is slow slip


UNITS = {"magnitude": "1", "moment": "N m", "duration": "s", "duration_90": "s", "duration_second_moment": "s",
         "corner_frequency": "Hz", "corner_frequency_integrals": "Hz",
         "rupture_speed_median": "m/s", "stress_drop": "Pa", "stress_drop_area": "Pa", "stress_drop_energy": "Pa",
         "stress_drop_moment": "Pa", "afterslip_moment": "N m",
         "afterslip_share": "1", "afterslip_time": "s", "events": "1", "recurrence": "s", "completeness": "1",
         "completeness_fit": "1", "b": "1", "slip_deficit": "m", "coupling": "1",
         "seismic_coupling": "1", "seismic_share": "1", "slow_slip_episodes": "1", "slow_slip_duration": "s"}


@dataclasses.dataclass
class Number:
    """name and value, in its unit; low and high where it has a spread, or an error on both sides; note: what else to
    know."""
    name: str
    value: float
    low: float = np.nan
    high: float = np.nan
    note: str = ""

    @property
    def unit(self):
        return UNITS[self.name]


def event_window(catalogue, event, left=SpinUp()):
    """(number of the row, onset, end) of an event, "largest" of those after a spin-up or a number from 1 on."""
    row = (left.events + int(np.nanargmax(catalogue.event["moment"][left.events:])) if event == "largest"
           and left.events < catalogue.count else catalogue.number_of(event))
    return row, float(catalogue.event["onset"][row]), float(catalogue.event["end"][row])


def area_of(data, cells):
    """Areas of the cells [m^2] of a run or a catalogue; those of triangles are half of their sides' product."""
    if "triangles" in data.mesh:
        return np.linalg.norm(normals(triangles_of(data.mesh)), axis=1) / 2
    return cells[:, 3] * cells[:, 4]


def fastest(run):
    """The speed of longitudinal waves [m/s], which no rupture passes; inf where a file does not know it."""
    known = {} if run is None else run.parameters
    if not {"shear_modulus", "density", "poisson_ratio"} <= set(known):
        return np.inf
    return float(np.sqrt(2 * known["shear_modulus"] * (1 - known["poisson_ratio"])
                         / ((1 - 2 * known["poisson_ratio"]) * known["density"])))


def speed_or_none(speed, limit):
    """A rupture speed [m/s], and why it is none: NaN above the fastest waves, where cells broke at once, as by their
    start or by a load."""
    return (speed, "") if not speed > limit else (np.nan, f"none: {speed:.4g} m/s is above the longitudinal waves' "
                                                  f"{limit:.4g} m/s, cells broke at once")


def of_fronts(data, time, limit=np.inf):
    """Rupture speed of cells of a run or catalogue that broke at times [s], NaN where they did not: (speeds [N],
    Numbers). Above a limit [m/s] it is none."""
    cells, shape = cells_of(data.path, data.mesh, data.extents)
    speeds = rupture.speed(time, cells, shape, data.mesh.get("fault"))
    found = rupture.summary(speeds, time, cells, area_of(data, cells))
    if found is None:
        return speeds, []
    median, why = speed_or_none(found[0], limit)
    return speeds, [Number("rupture_speed_median", median,
                           *((np.nan, np.nan, why) if why
                             else (found[1], found[2], "16th and 84th percentiles over the area")))]


def stress_drops(run, begin, end, broke=None):
    """Stress drops [Pa] by area and by slip between two times, from the fields traction and slip."""
    if not {"traction", "slip"} <= set(run.field_names):
        return []
    cells, _ = cells_of(run.path, run.mesh, run.extents)
    area = area_of(run, cells)
    with run.open() as file:
        rows = Fields(run, "slip", (begin, end))._outer
        slip, traction = (np.array([file[f"fields/{name}"][row] for row in rows]).reshape(2, len(area), -1)
                          for name in ("slip", "traction"))
    slip, drop = slip[1] - slip[0], traction[1] - traction[0]  # the traction is that which resists slip
    mean = (slip * area[:, None]).sum(axis=0)
    size = np.linalg.norm(slip, axis=1)
    if not np.any(mean) or not size.any():
        return []
    broke = np.isfinite(broke).ravel() if broke is not None and np.isfinite(broke).any() else size > 0
    along = drop @ mean / np.linalg.norm(mean)  # as that of the catalogue
    by_slip = np.where(size > 0, (drop * slip).sum(axis=1) / np.where(size > 0, size, 1), 0)
    return [Number("stress_drop_area", stress.of_area(along[broke], area[broke]),
                   note="mean over the area that ruptured"),
            Number("stress_drop_energy", stress.of_energy(by_slip, size, area), note="weighted by slip")]


def noted(numbers, words):
    """Numbers with words in the note of each."""
    for one in numbers:
        one.note = "; ".join(filter(None, (one.note, words)))
    return numbers


def of_event(run, catalogue, event="largest", spin=None):
    """Numbers of one event, of a catalogue and, where there is one, of its run. The largest is that after the spin-up,
    as spin_up() has it of `spin`."""
    left = spin_up(run, catalogue, spin) if event == "largest" else SpinUp()
    if left.events and left.events == catalogue.count:
        return []
    row, onset, end = event_window(catalogue, event, left)
    of = {name: values[row] for name, values in catalogue.event.items()}
    found = [Number("magnitude", of["magnitude"]), Number("moment", of["moment"]),
             Number("duration", catalogue.duration[row], note="onset to end of the catalogue")]
    broke = catalogue.map("rupture_time")[row] if catalogue.has_maps else None
    if run is not None:
        time, rate, _ = moment_rate(run, onset, end)
        rate = np.abs(rate.sum(axis=1))
        keep = np.concatenate([[True], np.diff(time) > 0])
        time, rate = time[keep], rate[keep]
        if len(time) > 4 and rate.any():
            corner, misfit = source.corner_frequency(time, rate)
            shares, second = source.durations(time, rate)
            found += [Number("duration_90", shares, note="from 5 to 95 % of the moment"),
                      Number("duration_second_moment", second),
                      Number("corner_frequency", corner, corner * np.exp(-misfit), corner * np.exp(misfit),
                             "omega-square fit; its misfit as a factor"),
                      Number("corner_frequency_integrals", source.corner_of_integrals(time, rate))]
        if broke is None and "slip_rate" in run.field_names:
            try:
                broke = rupture_times(Fields(run, "slip_rate", (onset, end)),
                                      catalogue.attributes.get("event_rate", 1e-3)) - onset
            except OutputError:  # no rows within the event
                pass
    if broke is not None and np.isfinite(broke).any():
        found += of_fronts(catalogue, broke, fastest(run))[1]
    found.append(Number("stress_drop", of["stress_drop"], note="of the catalogue, mean over the area"))
    if run is not None:
        found += stress_drops(run, onset, end, broke)
    found.append(Number("stress_drop_moment",
                        stress.of_moment(of["moment"], of["area"], catalogue.attributes.get("poisson_ratio", 0.25)),
                        note="circular crack of the area"))
    return noted(found + (afterslip(run, catalogue, row) if run is not None else []), left.words)


def afterslip(run, catalogue, row):
    """Moment after an event until the fault slips no faster than plates move, or the next event or the end of the run,
    and the logarithm's time."""
    end, next_onset = float(catalogue.event["end"][row]), catalogue.event["onset"][row + 1:]
    until = float(next_onset[0]) if len(next_onset) else float(run.series["time"][-1])
    if "moment" not in run.series or until <= end:
        return []
    time, rate, moment = moment_rate(run, end, until)
    note = "until the next event or the end"
    slow = np.flatnonzero(np.abs(rate.sum(axis=1)) <= plates_moment_rate(run))
    if is_loaded(run, catalogue) and len(slow):
        time, moment = time[:slow[0] + 1], moment[:slow[0] + 1]
        note = f"for {written(time[-1])}, until the fault slips as the plates move"
    moment = np.abs(moment.sum(axis=1))
    if len(time) < 5 or not moment[-1] > 0:
        return []
    _, t0, _ = cycle.fit_afterslip(time, moment)
    return [Number("afterslip_moment", moment[-1], note=note),
            Number("afterslip_share", moment[-1] / catalogue.event["moment"][row]),
            # else it grows by a straight line
            *([Number("afterslip_time", t0, note="t0 of ln(1 + t/t0)")] if t0 < time[-1] else [])]


def intervals(catalogue, left=SpinUp()):
    """Times between the onsets of events after a spin-up of at least LARGE of the largest moment [s]; empty where there
    are not two."""
    event = {name: values[left.events:] for name, values in catalogue.event.items()
             if name in ("moment", "onset", "onset_rest")}
    if not len(event["moment"]):
        return np.array([])
    large = event.pop("moment") >= LARGE * np.nanmax(catalogue.event["moment"][left.events:])
    return np.diff(since({name: values[large] for name, values in event.items()}, "onset"))


def of_catalogue(catalogue, left=SpinUp()):
    """Numbers of all events of a catalogue after a spin-up."""
    return noted(_of_catalogue(catalogue, left), left.words)


def _of_catalogue(catalogue, left):
    magnitude = catalogue.event["magnitude"][left.events:]
    magnitude = magnitude[np.isfinite(magnitude)]
    found = [Number("events", float(catalogue.count - left.events))]
    times = intervals(catalogue, left)
    if len(times):
        spread = np.std(times, ddof=1) if len(times) > 1 else np.nan
        found.append(Number("recurrence", np.mean(times), np.mean(times) - spread, np.mean(times) + spread,
                            f"of events with {LARGE:g} of the largest moment"))
    if len(magnitude) < FEWEST:
        return found
    least = completeness(magnitude)
    found.append(Number("completeness", least, note="maximum curvature"))
    by_fit = completeness_by_fit(magnitude)
    if by_fit:
        found.append(Number("completeness_fit", by_fit[0], note=f"goodness of fit, R = {by_fit[1]:.1f} %"))
    if (magnitude >= least).sum() >= FEWEST:
        b, _ = b_value(magnitude, least)
        error = b_error(magnitude, least, b)
        found.append(Number("b", b, b - error, b + error, f"{(magnitude >= least).sum()} events from M {least:.1f} on"))
    return found


def plates_rate(run):
    """Loading rate of each cell or of all [m/s]; 0: no loading."""
    return np.abs(run.mesh["loading_rate"].ravel() if "loading_rate" in run.mesh
                  else run.parameters.get("loading_rate", 0.0))


def plates_moment_rate(run):
    """Moment that plates bring in a second [N m/s]."""
    cells, _ = cells_of(run.path, run.mesh, run.extents)
    return run.parameters["shear_modulus"] * float(np.sum(area_of(run, cells) * plates_rate(run)))


def of_run(run, catalogue=None, event="largest", slow=None, spin=None):
    """All numbers that the files of a run have: of an event, of the catalogue, and of the whole run. slow: (low, high)
    rates of slow slip [m/s], by default from SLOW times the plates' rate to that of events. spin: what is left out at
    the start, a number of events or a time as "50y"; None: what spin_up() takes of loaded runs, and says."""
    left = spin_up(run, catalogue, spin)
    found = of_event(run, catalogue, event, spin) if catalogue is not None and catalogue.count else []
    found += of_catalogue(catalogue, left) if catalogue is not None else []
    return found + noted(_of_plates(run, catalogue, slow, left), left.words)


def _of_plates(run, catalogue, slow, left):
    rate, after = plates_rate(run), run.series["time"] >= left.until
    if not rate.any() or after.sum() < 2:
        return []
    found = []
    series = {name: values[after] for name, values in run.series.items()}
    time = since(series)
    cells, _ = cells_of(run.path, run.mesh, run.extents)
    area = area_of(run, cells).sum()
    modulus, span = run.parameters["shear_modulus"], float(time[-1])
    plates = plates_moment_rate(run) * span
    slipped = abs(float(np.sum(series["moment"][-1] - series["moment"][0]))) if "moment" in series else np.nan
    begin = "the start" if left.until == -np.inf else written(left.until)
    found += [Number("slip_deficit", (plates - slipped) / (modulus * area), note=f"mean over the fault, since {begin}"),
              Number("coupling", 1 - slipped / plates, note="mean over the fault and that time")]
    if catalogue is not None:
        seismic = catalogue.event["moment"][left.events:]
        found += [Number("seismic_coupling", cycle.seismic_coupling(seismic, plates)),
                  Number("seismic_share", float(np.sum(seismic)) / slipped if slipped else np.nan,
                         note="of the moment of all slip")]
    low, high = slow or (SLOW * float(rate.max()), catalogue.attributes["event_rate"] if catalogue is not None
                         else 1e-3)
    slips = cycle.episodes(time, series["max_slip_rate"], low, high)
    found.append(Number("slow_slip_episodes", float(len(slips)), note=f"largest rate from {low:.2g} to {high:.2g} m/s"))
    if slips:
        found.append(Number("slow_slip_duration", float(np.median([end - begin for begin, end, _ in slips])),
                            note="median"))
    return found
