"""Events of a run under tides (-fault_tide_period): when they were, slip rates with the stress, and the phases of the
events, with Schuster's p value.

    slipstep tides RUN.h5 EVENTS.h5 [--tide 1] [--since 20d] [--figure OUT.png]

The phase of an event is that of its onset in A sin(phase): at 90 degrees the shear stress of a positive amplitude is
largest. Schuster's p = exp(-R^2/N), R the length of the sum of N unit vectors in the directions of the phases, is how
likely events without a preferred phase have an R as large. Aftershocks, which are not independent, lower it.
"""

import argparse
import os

import numpy as np

from ..errors import OutputError
from ..plots.panels import RUN_STYLES, log_scale, plt, use_style
from ..results.catalogue import Catalogue
from ..results.run import Run
from ..times import Clock, seconds, written

BINS = 18
WINDOW = 6  # periods in the panel of slip rates


class Tide:
    """A sin(2 pi t/P + phase) of shear and normal stress [Pa], P [s], phase [radians]."""

    def __init__(self, period, shear, normal, phase):
        self.period, self.shear, self.normal, self.offset = period, shear, normal, np.radians(phase)

    def phase(self, time):
        """In degrees, 0 to 360."""
        return np.degrees(2 * np.pi * (np.asarray(time) / self.period % 1) + self.offset) % 360

    def course(self, time):
        return np.sin(np.radians(self.phase(time)))


def tides_of(run):
    """The Tides of a run."""
    lists = {}
    for name in ("period", "shear", "normal", "phase"):
        text = run.parameters.get(f"tide_{name}", "")
        text = text.decode() if isinstance(text, bytes) else str(text)
        lists[name] = [float(number) for number in text.split(",")] if text and text != "none" else []
    if not lists["period"]:
        raise OutputError(f"{run.path} is of a run without tides: expected one with -fault_tide_period")
    zero = [0.0] * len(lists["period"])
    return [Tide(*numbers) for numbers in zip(lists["period"], *(lists[name] or zero
                                                                 for name in ("shear", "normal", "phase")))]


def schuster(phases):
    """Schuster's p, and the mean phase [degrees]; 1 and nan without events."""
    if not len(phases):
        return 1.0, np.nan
    total = np.exp(1j * np.radians(phases)).sum()
    return float(np.exp(-abs(total) ** 2 / len(phases))), float(np.degrees(np.angle(total)) % 360)


def quiet_window(period, begin, end, onsets):
    """Start of the window of some periods with the fewest events."""
    starts = np.arange(begin, max(end - WINDOW * period, begin + period / 2), period)
    counts = [np.sum((onsets >= start) & (onsets < start + WINDOW * period)) for start in starts]
    return float(starts[int(np.argmin(counts))])


def draw_rates(axes, run, tide, start):
    """Slip rates of the whole fault over some periods, and the stress."""
    time = run.series["time"]
    inside = (time >= start) & (time <= start + WINDOW * tide.period)
    hours = 3600.0 if tide.period < 10 * 86400 else 86400.0
    axes.plot((time[inside] - start) / hours, run.series["mean_slip_rate"][inside], color=RUN_STYLES[0]["color"])
    log_scale(axes)
    axes.set(title=f"Mean slip rate over {WINDOW} periods from {written(start)} on, with the stress (grey)",
             ylabel="slip rate (m/s)", xlabel="time (hours)" if hours == 3600.0 else "time (days)",
             xlim=(0, WINDOW * tide.period / hours))
    grid = np.linspace(start, start + WINDOW * tide.period, 400)
    other = axes.twinx()
    amplitude = tide.shear or tide.normal
    other.plot((grid - start) / hours, amplitude * tide.course(grid) / 1e3, color="0.6", linewidth=1)
    other.set_ylabel(f"{'shear' if tide.shear else 'normal'} stress (kPa)", color="0.4")


def draw_phases(axes, phases, p, mean):
    counts, edges = np.histogram(phases, bins=BINS, range=(0, 360))
    axes.bar(edges[:-1], counts, width=360 / BINS, align="edge", color=RUN_STYLES[0]["color"], alpha=0.7,
             edgecolor="white")
    level = len(phases) / BINS
    axes.axhline(level, color="black", linewidth=1, linestyle=":", label="without a tide")
    grid = np.linspace(0, 360, 181)
    axes.plot(grid, level * (1 + 0.5 * np.sin(np.radians(grid))), color="0.5", linewidth=1,
              label="course of the stress")
    axes.set(title=f"Phases of {len(phases)} events: Schuster's p = {p:.2g}, mean phase {mean:.0f} degrees",
             xlabel="phase of the onset (degrees)", ylabel="events", xlim=(0, 360), xticks=range(0, 361, 45))
    axes.legend(loc="upper right", ncols=2)


def figure(run, events, tide, since, found):
    use_style()
    time = run.series["time"]
    clock = Clock(0.0, float(time[-1]), None)
    canvas, panels = plt.subplots(3, 1, figsize=(9, 8.4), layout="constrained")
    onset, magnitude = events
    panels[0].plot(clock(time), run.series["max_slip_rate"], color="0.7", linewidth=0.6)
    log_scale(panels[0])
    panels[0].set(ylabel="largest slip rate (m/s)", xlabel=clock.label, xlim=(0, float(clock(clock.span))),
                  title=f"{len(onset)} events, largest slip rate (grey)")
    other = panels[0].twinx()
    other.plot(clock(onset), magnitude, linestyle="", marker="o", markersize=4, color=RUN_STYLES[0]["color"],
               markeredgewidth=0)
    other.set_ylabel("moment magnitude", color=RUN_STYLES[0]["color"])
    draw_rates(panels[1], run, tide, quiet_window(tide.period, since, float(time[-1]), onset))
    draw_phases(panels[2], *found)
    return canvas


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("run", metavar="RUN", help="output file of the run")
    parser.add_argument("catalogue", metavar="EVENTS", help="its catalogue of events")
    parser.add_argument("--tide", type=int, default=1, metavar="K", help="number in -fault_tide_period, from 1 on")
    parser.add_argument("--since", type=seconds, default=0.0, metavar="TIME",
                        help="events before it do not count: how the start went on [s, or with a unit]")
    parser.add_argument("--figure", metavar="OUT", help="picture to write, default RUN_tides.png")
    options = parser.parse_args()
    picture = options.figure or os.path.splitext(options.run)[0] + "_tides.png"
    run, catalogue = Run(options.run), Catalogue(options.catalogue)
    run.warn()
    tides = tides_of(run)
    if not 1 <= options.tide <= len(tides):
        raise OutputError(f"--tide is {options.tide}, expected 1 to {len(tides)}, as {run.path} has as many")
    tide = tides[options.tide - 1]
    onset, magnitude = np.asarray(catalogue.event["onset"]), np.asarray(catalogue.event["magnitude"])
    phases = tide.phase(onset[onset >= options.since])
    p, mean = schuster(phases)
    figure(run, (onset, magnitude), tide, options.since, (phases, p, mean)).savefig(picture)
    print(f"{len(phases)} events, of the tide of {written(tide.period)}: Schuster's p {p:.3g}, mean phase {mean:.0f} "
          f"degrees\nFigure: {picture}")
