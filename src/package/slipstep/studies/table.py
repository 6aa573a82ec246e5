"""Columns of a study's table: what the files of a run say of it."""

import difflib
import json
import math
import os
import re

from ..errors import Error, OutputError
from ..numbers import of_run, spin_up
from ..numbers.report import UNITS, event_window, fastest, intervals, speed_or_none
from ..numbers.spinup import LARGE
from ..results import Catalogue, Run

DEFAULT = ("left_out", "events", "magnitude", "duration", "peak_slip_rate", "recurrence", "mean_slip", "accepted",
           "products_all", "cost", "wall_time", "warnings")


class Files:
    """The files of a run's folder, each read once and only when it is asked for; None: it is not there."""

    def __init__(self, record, spin=None):
        self.record, self.spin, self.read = record, spin, {}

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
            found = [] if self.run is None else of_run(self.run, self.catalogue, spin=self.spin)
            self.read["quoted"], self.read["spreads"] = {one.name: float(one.value) for one in found}, {
                one.name: (float(one.low), float(one.high)) for one in found}
        return self.read["quoted"]

    @property
    def left(self):
        """The SpinUp that is left out."""
        if "left" not in self.read:
            self.read["left"] = spin_up(self.run, self.catalogue, self.spin)
        return self.read["left"]

    @property
    def largest(self):
        """The row of the largest event after the spin-up; None: there is none."""
        found = self.catalogue
        return (None if found is None or found.count == self.left.events
                else event_window(found, "largest", self.left)[0])


def of_largest(name):
    """A column of the catalogue, of the event of largest moment."""
    def column(files):
        return (None if files.largest is None or name not in files.catalogue.event
                else float(files.catalogue.event[name][files.largest]))

    return column


def rupture_speed(files):
    found = of_largest("rupture_speed")(files)
    return None if found is None else speed_or_none(found, fastest(files.run))[0]


def recurrence(files):
    found = () if files.catalogue is None else intervals(files.catalogue, files.left)
    return float(found.mean()) if len(found) else None


def recurrence_spread(files):
    found = () if files.catalogue is None else intervals(files.catalogue, files.left)
    return float(found.std(ddof=1)) if len(found) > 1 else None


def peak_slip_rate(files):
    if files.run is None or "max_slip_rate" not in files.run.series:
        return None
    rates = files.run.series["max_slip_rate"][files.run.series["time"] >= files.left.until]
    return float(rates.max()) if len(rates) else None


# name -> (unit, what it is, function of Files)
COLUMNS = {
    "events": ("1", "number of events",
               lambda files: files.catalogue and files.catalogue.count - files.left.events),
    "magnitude": ("1", "moment magnitude of the largest event", of_largest("magnitude")),
    "moment": ("N m", "moment of the largest event", of_largest("moment")),
    "duration": ("s", "duration of the largest event",
                 lambda files: None if files.largest is None else float(files.catalogue.duration[files.largest])),
    "onset": ("s", "onset of the largest event", of_largest("onset")),
    "area": ("m^2", "area of the largest event", of_largest("area")),
    "event_slip": ("m", "mean slip of the largest event", of_largest("mean_slip")),
    "stress_drop": ("Pa", "stress drop of the largest event", of_largest("stress_drop")),
    "rupture_speed": ("m/s", "rupture speed of the largest event, none where it is above that of longitudinal waves",
                      rupture_speed),
    "radiated_efficiency": ("1", "radiated efficiency of the largest event", of_largest("radiated_efficiency")),
    "peak_slip_rate": ("m/s", "largest slip rate of the run", peak_slip_rate),
    "recurrence": ("s", f"mean time between events of at least {LARGE:g} of the largest moment", recurrence),
    "recurrence_spread": ("s", "standard deviation of these times", recurrence_spread),
    "left_out": ("1", "number of events that the spin-up leaves out, from which these numbers are free",
                 lambda files: files.catalogue and files.left.events),
    "warnings": ("1", "number of warnings that the run printed", lambda files: len(files.record.warnings)),
}
OF_RECORD = {"wall_time": "s", "attempts": "1", "code": "1"}
# attributes of /result that runs of faults may have, with their units
OF_RESULT = {**dict.fromkeys(("accepted", "rejected", "solves", "explicit_attempts", "newton_iterations",
                              "linear_iterations", "right_hand_sides", "products", "products_k", "products_h",
                              "products_pc",
                              "products_all", "products_k_setup", "products_h_setup", "device_puts", "device_fetches",
                              "device_numbers", "policy_decisions", "policy_outside_range", "policy_halvings",
                              "policy_steps", "heir_steps", "check_solves", "rtol", "accuracy", "accuracy_requested",
                              "hmat_tolerance", "least_resolution", "cells_fail_alone", "cells_without_stress",
                              "magnitude_so_far"), "1"),
             **dict.fromkeys(("cost", "cost_setup", "cost_output", "processor_time", "wall_time_setup",
                              "wall_time_solve", "policy_handover_time"), "s"), "mean_slip": "m",
             "largest_opening": "m", "max_slip_rate": "m/s",
             **dict.fromkeys(("injected_volume", "stored_volume", "leaked_volume", "border_volume"), "m^3"),
             "least_normal_stress": "Pa", "largest_pressure": "Pa", "largest_frequency": "rad/s"}
ERRORS = r"\w+_error(_\w+)?|check_error_\w+"  # and those of their errors
RESERVED = ("run", "status", "folder", "error")  # columns of each table
PLATES = ("slip_deficit", "coupling", "seismic_coupling", "seismic_share", "slow_slip_episodes", "slow_slip_duration")
WHY = {"recurrence": "it needs two events of at least half of the largest moment after the spin-up",
       "recurrence_spread": "it needs three events of at least half of the largest moment after the spin-up",
       "stress_drop_area": "it needs the fields slip and traction, and an event",
       "rupture_speed_median": "it needs an event with a front, and -fault_catalogue_maps or the field slip_rate",
       "b": "it needs 30 events from the magnitude of completeness on", "completeness": "it needs 30 events",
       **dict.fromkeys(PLATES, "it needs a loading rate")}
WHY["stress_drop_energy"], WHY["completeness_fit"] = WHY["stress_drop_area"], WHY["completeness"]


def spread(name, files):
    """From and to which a column's number of one run is spread, as its note in slipstep.numbers has it, or None."""
    if name == "recurrence":
        middle, half = recurrence(files), recurrence_spread(files)
        return None if half is None else (middle - half, middle + half)
    if name not in UNITS or name in COLUMNS or files.run is None:
        return None
    files.quoted
    low, high = files.read["spreads"].get(name, (math.nan, math.nan))
    return None if math.isnan(low) else (low, high)


def is_spun(name):
    """Whether a column is of what comes after the spin-up, of which left_out tells."""
    return name in UNITS or name in COLUMNS and name not in ("left_out", "warnings")


def check_name(source, name):
    """Error: a run of the program fault has no such column."""
    known = [*COLUMNS, *UNITS, *OF_RECORD, *OF_RESULT]
    if name not in known and not re.fullmatch(ERRORS, name):
        near = difflib.get_close_matches(name, known, 1)
        raise Error(f"{source}: table names {name}, which no run has"
                    + (f"; did you mean {near[0]}?" if near else "; its columns are in examples/howto/studies.md"))


def missing(name, options):
    """What a column needs that a run with these options (without "fault_") does not have; "": nothing."""
    fields = set(str(options["output_fields"]).split(",")) if options.get("output_fields") else None
    if (name.startswith("stress_drop_") and name != "stress_drop_moment" and fields is not None
        and not {"slip", "traction"} <= fields):
        return "output_fields with slip and traction"
    if (name == "rupture_speed_median" and fields is not None and "slip_rate" not in fields
        and "catalogue_maps" not in options):
        return "catalogue_maps, or output_fields with slip_rate"
    return "loading_rate" if name in PLATES and not {"loading_rate", "parameters"} & set(options) else ""


def why_empty(name, own):
    """Why a column has no number in any run; own: names of the numbers that programs of one's own have written."""
    near = difflib.get_close_matches(name, own, 1)
    return WHY.get(name) or ("it needs an event" if is_spun(name) else "no run has such a number"
                             + (f"; did you mean {near[0]}?" if near else ""))


def unit(name):
    return COLUMNS[name][0] if name in COLUMNS else {**UNITS, **OF_RESULT, **OF_RECORD}.get(name, "1")


def value(name, files, outcome):
    """A column of a run that is over: a number or text, or None; numbers of its own program go first."""
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
