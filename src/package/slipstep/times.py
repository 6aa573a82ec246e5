"""Times in the unit that fits: seconds of a rupture, hours of an injection, years of a century."""

import argparse
import re

import numpy as np

YEAR = 365.25 * 86400.0
SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0, "y": YEAR}
NAMES = {"s": "s", "h": "hours", "d": "days", "y": "years"}
LIMITS = (("s", 3 * 3600.0), ("h", 3 * 86400.0), ("d", YEAR))  # the unit of a span up to so many seconds; years beyond


TIME = r"([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)(s|min|h|d|y)?"


def seconds(text):
    """A time of the command line in seconds: "12.5", "250y", or a sum as "96.4y+2.5s"."""
    if not re.fullmatch(rf"{TIME}(?:\+{TIME})*", text):
        raise argparse.ArgumentTypeError(f"{text} is no time, expected seconds or numbers with s, min, h, d or y, as "
                                         "12.5, 250y or 96.4y+2s")
    return sum(float(number) * SECONDS[unit or "s"] for number, unit in re.findall(TIME, text))


def since(columns, name="time", start=None):
    """Times [s] of a run after one of them, with all digits that its file has, as since(run.series) for those after the
    first. A double knows a million years to 4 ms; what it leaves of a time is in a column of its own in files of such
    runs, time_rest.

    columns  dict of arrays: series or steps of a run, or the events of a catalogue, whose name is "onset" or "end"
    start    number of the row from which to count, or a pair of arrays, times and what they leave; by default the first
             row"""
    rest = columns.get(f"{name}_rest", np.zeros_like(columns[name]))
    begin, left = start if isinstance(start, tuple) else (columns[name][start or 0], rest[start or 0])
    return (columns[name] - begin) + (rest - left)


def unit_of(span, years=None):
    """The unit of an axis that spans so many seconds; years: True and False take or refuse years, None leaves the
    choice."""
    if years:
        return "y"
    for unit, limit in LIMITS:
        if span <= limit:
            return unit
    return "y" if years is None else "d"


class Clock:
    """How times [s] between begin and end are drawn and written. A short part of a long run is counted from its
    begin."""

    def __init__(self, begin, end, years=None):
        self.span = max(end - begin, 1e-300)
        self.unit = unit_of(self.span, years)
        self.origin = begin if self.span < 1e-2 * abs(begin) else 0.0

    def __call__(self, time):
        """Times in the clock's unit."""
        return (np.asarray(time) - self.origin) / SECONDS[self.unit]

    @property
    def since(self):
        """The begin of the part, in words; empty where times count from 0."""
        return written(self.origin, self.span) if self.origin else ""

    @property
    def name(self):
        """The unit in words."""
        return NAMES[self.unit]

    @property
    def label(self):
        """Of an axis."""
        name = NAMES[self.unit]
        return f"time since {self.since} ({name})" if self.since else f"time ({name})"

    @property
    def digits(self):
        """Of times in words, about a thousandth of the span."""
        return digits_for(self.span / SECONDS[self.unit], 2 + (self.unit == "y"))

    def logarithmic(self, name, wanted=None):
        """Whether a field is drawn on a logarithmic scale, unless the user wants it so or not: slip rates of more than
        an event."""
        return name == "slip_rate" and (self.unit != "s" if wanted is None else wanted)

    def text(self, time):
        """A time in words, to about a thousandth of the span."""
        return f"{float(self(time)):.{self.digits}f} {self.name}"


def digits_for(size, more=0):
    """How many digits after the point a number needs to show a size, and some more; 6 at most."""
    return int(np.clip(more - np.floor(np.log10(size)), 0, 6))


def written(time, span=np.inf):
    """A time [s] by itself, in its unit: "113.271 years"; of one from which a span [s] is counted more digits where
    that is short."""
    unit = unit_of(abs(time))
    digits = max(3, digits_for(span / SECONDS[unit], 1))
    return f"{time / SECONDS[unit]:.{digits}f}".rstrip("0").rstrip(".") + f" {NAMES[unit]}"
