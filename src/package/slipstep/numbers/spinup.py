"""The spin-up of a loaded run: what its artificial start still shows in, up to the end of its first large event, which
numbers of cycles leave out."""

import argparse
import dataclasses
import re

import numpy as np

from ..errors import Error
from ..times import seconds, written

LARGE = 0.5  # of the largest moment: events that recur
# of its moment, a magnitude less: what has to follow the first large event for that to be left out by default
AGAIN = 1 / 30


EXPECTED = "expected a number of events, as 3, or a time with its unit, as 50y"


@dataclasses.dataclass
class SpinUp:
    """events: how many are left out, the first ones; until: what is counted begins then [s]; words: what is said of it
    in each line, "" where nothing is to be said."""
    events: int = 0
    until: float = -np.inf
    words: str = ""


def parsed(text):
    """A number of events, or a time [s], of "3", "50y" and the like, or of a number. Error: neither."""
    if isinstance(text, str) and not re.fullmatch(r"[0-9]+", text):
        try:
            found = seconds(text)
        except argparse.ArgumentTypeError:
            found = -1.0
        if not re.search(r"[a-z]$", text) or not 0 <= found < np.inf:
            raise Error(f"spin-up is {text}, {EXPECTED}")
        return float(found)
    if not isinstance(text, (str, int)) or isinstance(text, bool) or int(text) < 0:
        raise Error(f"spin-up is {text}, {EXPECTED}")
    return int(text)


def is_loaded(run, catalogue):
    """Whether plates load a fault, or, where there is no run, whether anything has done work on it in events."""
    if run is not None:
        return bool(np.any(run.mesh["loading_rate"] if "loading_rate" in run.mesh
                           else run.parameters.get("loading_rate", 0.0)))
    work = catalogue.event.get("loading_work", np.zeros(1))
    return bool(np.any(np.nan_to_num(work)))


def spin_up(run, catalogue, given=None):
    """The SpinUp of a run and its catalogue. given: a number of events, or a time as "50y"; None: of loaded runs the
    first event that has LARGE of the largest moment from it on, and those before it, if one with AGAIN of its moment
    follows; of others nothing."""
    if catalogue is None:
        if given is None or isinstance(parsed(given), int):
            return SpinUp()
        return SpinUp(0, parsed(given), f"without the first {written(parsed(given))}")
    if given is not None:
        given = parsed(given)
        if isinstance(given, float):
            events = int((catalogue.event["onset"] < given).sum())
            return SpinUp(events, given, f"without the first {written(given)}, {counted(events)}")
        if given > catalogue.count:
            raise Error(f"{catalogue.path} has {counted(catalogue.count)}, and a spin-up of {given} is asked for")
    elif not is_loaded(run, catalogue) or not catalogue.count:
        return SpinUp()
    else:
        moment = np.nan_to_num(catalogue.event["moment"])
        largest_from = np.maximum.accumulate(moment[::-1])[::-1]
        first = int(np.argmax(moment >= LARGE * largest_from))
        if not (moment[first + 1:] >= AGAIN * moment[first]).any():
            return SpinUp(0, -np.inf, "with the spin-up, as no second large event follows")
        given = first + 1
    if not given:
        return SpinUp(0, -np.inf, "with the spin-up" if is_loaded(run, catalogue) else "")
    until = float(catalogue.event["end"][given - 1])
    return SpinUp(given, until,
                  f"without the first {'event' if given == 1 else f'{given} events'}, until {written(until)}")


def counted(events):
    return f"{events} event{'s' * (events != 1)}"
