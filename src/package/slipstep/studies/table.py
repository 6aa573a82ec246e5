"""Columns of a study's table: what the files of a run say of it."""

import json
import os

import numpy as np

from ..errors import OutputError
from ..results import Catalogue, Run
from ..times import since

DEFAULT = ("events", "magnitude", "duration", "peak_slip_rate", "recurrence", "mean_slip", "accepted", "products_all", "cost", "wall_time")
LARGE = 0.5  # of the largest moment: events that recur


class Files:
    """The files of a run's folder, each read once and only when it is asked for; None: it is not there."""

    def __init__(self, record):
        self.record, self.read = record, {}

    def get(self, name, reader):
        if name not in self.read:
            path = self.record.file(name)
            self.read[name] = reader(path) if os.path.exists(path) else None
        return self.read[name]

    @property
    def run(self):
        return self.get("run.h5", Run)

    @property
    def catalogue(self):
        return self.get("events.h5", Catalogue)

    @property
    def numbers(self):
        """Of a program of one's own, {folder}/numbers.json."""
        def reader(path):
            try:
                with open(path, encoding="utf-8") as file:
                    found = json.load(file)
            except ValueError as error:
                raise OutputError(f"{path}: {error}") from None
            if not isinstance(found, dict):
                raise OutputError(f"{path}: expected an object of numbers by name")
            return found

        return self.get("numbers.json", reader) or {}


def of_largest(name):
    """A column of the catalogue, of the event of largest moment."""
    def column(files):
        found = files.catalogue
        return None if found is None or not found.count or name not in found.event else float(found.event[name][found.number_of("largest")])

    return column


def duration(files):
    found = files.catalogue
    return None if found is None or not found.count else float(found.duration[found.number_of("largest")])


def events(files):
    return None if files.catalogue is None else files.catalogue.count


def intervals(files):
    """Between the onsets of events of at least LARGE of the largest moment [s]; None: there are none."""
    found = files.catalogue
    if found is None or not found.count:
        return None
    large = found.event["moment"] >= LARGE * np.nanmax(found.event["moment"])
    columns = {name: found.event[name][large] for name in ("onset", "onset_rest") if name in found.event}
    return np.diff(since(columns, "onset")) if large.sum() > 1 else None


def recurrence(files):
    found = intervals(files)
    return None if found is None else float(found.mean())


def recurrence_spread(files):
    found = intervals(files)
    return None if found is None or len(found) < 2 else float(found.std(ddof=1))


def peak_slip_rate(files):
    return None if files.run is None or "max_slip_rate" not in files.run.series else float(files.run.series["max_slip_rate"].max())


# name -> (unit, what it is, function of Files)
COLUMNS = {
    "events": ("1", "number of events", events),
    "magnitude": ("1", "moment magnitude of the largest event", of_largest("magnitude")),
    "moment": ("N m", "moment of the largest event", of_largest("moment")),
    "duration": ("s", "duration of the largest event", duration),
    "onset": ("s", "onset of the largest event", of_largest("onset")),
    "area": ("m^2", "area of the largest event", of_largest("area")),
    "event_slip": ("m", "mean slip of the largest event", of_largest("mean_slip")),
    "stress_drop": ("Pa", "stress drop of the largest event", of_largest("stress_drop")),
    "rupture_speed": ("m/s", "rupture speed of the largest event", of_largest("rupture_speed")),
    "radiated_efficiency": ("1", "radiated efficiency of the largest event", of_largest("radiated_efficiency")),
    "peak_slip_rate": ("m/s", "largest slip rate of the run", peak_slip_rate),
    "recurrence": ("s", f"mean time between events of at least {LARGE:g} of the largest moment", recurrence),
    "recurrence_spread": ("s", "standard deviation of these times", recurrence_spread),
}
OF_RECORD = {"wall_time": "s", "attempts": "1", "code": "1"}
OF_RESULT = {"mean_slip": "m", "cost": "s", "processor_time": "s", "wall_time_setup": "s", "wall_time_solve": "s"}  # units; of others 1


def unit(name):
    return COLUMNS[name][0] if name in COLUMNS else OF_RECORD.get(name, OF_RESULT.get(name, "1"))


def value(name, files, outcome):
    """A column of one run that is over: a number or text, None where it has none. Of a program of one's own its numbers go first."""
    if name in OF_RECORD:
        return outcome.get(name)
    if name in files.numbers:
        return files.numbers[name]
    if name in COLUMNS:
        return COLUMNS[name][2](files)
    found = None if files.run is None else files.run.summary.get(name)
    return found if isinstance(found, (int, float, str)) else None
