"""Columns of a study's table: what the files of a run say of it."""

import json
import os

from ..errors import OutputError
from ..numbers import of_run
from ..numbers.report import LARGE, UNITS, intervals
from ..results import Catalogue, Run

DEFAULT = ("events", "magnitude", "duration", "peak_slip_rate", "recurrence", "mean_slip", "accepted", "products_all", "cost", "wall_time", "warnings")


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

    @property
    def quoted(self):
        """What slipstep.numbers has of the run."""
        if "quoted" not in self.read:
            self.read["quoted"] = {} if self.run is None else {one.name: float(one.value) for one in of_run(self.run, self.catalogue)}
        return self.read["quoted"]


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


def recurrence(files):
    found = () if files.catalogue is None else intervals(files.catalogue)
    return float(found.mean()) if len(found) else None


def recurrence_spread(files):
    found = () if files.catalogue is None else intervals(files.catalogue)
    return float(found.std(ddof=1)) if len(found) > 1 else None


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
    "warnings": ("1", "number of warnings that the run printed", lambda files: len(files.record.warnings)),
}
OF_RECORD = {"wall_time": "s", "attempts": "1", "code": "1"}
OF_RESULT = {"mean_slip": "m", "cost": "s", "processor_time": "s", "wall_time_setup": "s", "wall_time_solve": "s"}  # units; of others 1


def unit(name):
    return COLUMNS[name][0] if name in COLUMNS else {**UNITS, **OF_RESULT, **OF_RECORD}.get(name, "1")


def value(name, files, outcome):
    """A column of one run that is over: a number or text, None where it has none. Of a program of one's own its numbers go first."""
    if name in OF_RECORD:
        return outcome.get(name)
    if name in files.numbers:
        return files.numbers[name]
    if name in COLUMNS:
        return COLUMNS[name][2](files)
    if name in UNITS:
        return files.quoted.get(name)
    found = None if files.run is None else files.run.summary.get(name)
    return found if isinstance(found, (int, float, str)) else None
