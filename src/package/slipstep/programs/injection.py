"""What an injection has moved: events against time with the pressure, how much of the slip was seismic, how far events
migrate, and moments against the injected volume.

    slipstep injection RUN.h5 EVENTS.h5 [--wells WELLS.csv] [--pressure PRESSURE.h5] [--figure OUT.png] [--csv OUT.csv]

The seismic moment is the sum of the catalogue's events, the moment of all that slipped between their onsets and ends.
The total is that of all slip since the start, and the rest is aseismic. The pressure is that of the file of
-fault_pore_pressure, or of the run's field pore_pressure.

Distances are from the nearest well of -fault_wells, of --wells or of -fault_injection that has begun, times since then.
The diffusivity D of the triggering front r = sqrt(4 pi D t) (Shapiro et al. 1997) is that beyond which 5 % of the
events before the shut-in are, and that of the back front after it (Parotidis et al. 2004) that behind which 5 % are;
errors are standard errors by the bootstrap. Stress that slip moves makes events, too: D is that of the rock where
pressure alone does. Moments are compared with G dV (McGarr 2014) and gamma dV^1.5 (Galis et al. 2017), where the run
computes the volume dV in /series/injected_volume.
"""

import argparse
import os

import h5py
import numpy as np

from ..errors import OutputError
from ..numbers.migration import (GALIS, back_front, bounds, fit_back_front, fit_front, front, largest_so_far, migration,
                                 sources_of, volumes_of)
from ..plots.panels import RED, RUN_STYLES, plt, use_style
from ..results.catalogue import Catalogue
from ..results.files import write_csv
from ..results.run import Run
from ..results.moment import magnitude
from ..times import Clock, written


def moments(run, events):
    """Times [s], moments since the start and those of events [N m], at every step; slip counts by its amount."""
    if "moment" not in run.series:
        raise OutputError(f"{run.path}: no /series/moment; expected a run of SlipStep 0.4 or later")
    time = run.series["time"]
    total = np.abs(np.asarray(run.series["moment"])).sum(axis=1)
    seismic = np.zeros(len(time))
    order = np.argsort(events["onset"])
    for onset, end, moment in zip(events["onset"][order], events["end"][order], events["moment"][order]):
        inside = np.interp([onset, end], time, total)
        grown = np.clip((np.interp(np.clip(time, onset, end), time, total) - inside[0]) / (inside[1] - inside[0])
                        if inside[1] > inside[0] else (time >= end).astype(float), 0, 1)
        seismic += np.abs(moment) * grown
    return time, total, seismic


def read_pressure(run, path):
    """Times [s] and the largest pressure [Pa], its source, or None."""
    if path:
        with h5py.File(path) as file:
            if "time" not in file or "pressure" not in file:
                raise OutputError(f"{path}: expected /time and /pressure, as of -fault_pore_pressure")
            values = file["pressure"][...]
            return file["time"][...], values.reshape(len(values), -1).max(axis=1)
    try:
        times, values = run.field("pore_pressure")
    except (OutputError, KeyError):
        return None
    return times, values.reshape(len(values), -1).max(axis=1)


class Fluid:
    """What is known of the fluid beside its pressure: distance and time since its begin of each event, the fits of
    their fronts, and the injected volume; sources is empty, and volume None, where the run does not say it."""

    def __init__(self, run, events, options):
        self.sources = sources_of(run, options.wells)
        self.volume, self.gamma = volumes_of(run), options.galis
        self.modulus = run.parameters.get("shear_modulus", 0.0)
        if not self.sources:
            return
        self.dimension = options.dimension or (1 if not run.planes and 1 in run.shape else 2)
        self.distance, self.time, nearest = migration(run, events, self.sources)
        stops = np.array([source.stop - source.begin for source in self.sources])
        own = np.where(nearest >= 0, stops[nearest], np.inf)
        during = self.time <= own
        self.front = fit_front(self.distance[during], self.time[during])
        # a curve has one time of shut-in
        self.stop = stops[0] if np.isfinite(stops[0]) and np.ptp(stops) <= 1e-9 * stops[0] else None
        self.back = self.stop and fit_back_front(self.distance, self.time, self.stop, self.dimension)

    def lines(self):
        """What is printed of it."""
        if not self.sources:
            yield "Migration: unknown, the run has neither -fault_wells nor -fault_injection; --wells WELLS.csv"
        else:
            for what, fit in (("front", self.front), ("back front", self.back)):
                if fit:
                    yield f"D of the {what}: {fit[0]:.3g} m^2/s, standard error {fit[1]:.2g} m^2/s"
                elif what == "front" or self.stop:
                    yield f"D of the {what}: too few events"
        if self.volume is None:
            yield ("Injected volume: unknown, as a pressure that is given has none; a run with -fault_permeability has "
                   "/series/injected_volume")
        else:
            yield (f"Injected volume: {self.volume[-1]:.4g} m^3, at most {self.volume.max():.4g} m^3"
                   + "".join(f"; {what}: M {magnitude(size):.2f}" for what, size in
                             zip(("G dV", f"{self.gamma:.3g} dV^1.5"),
                                 bounds(self.volume.max(), self.modulus, self.gamma).values())))


def draw_migration(axes, fluid, events, clock):
    """Distance of events against time since the injection began, with both fronts; areas of dots go with moments."""
    share = np.abs(events["moment"]) / np.abs(events["moment"]).max()
    axes.scatter(clock(fluid.time), fluid.distance, s=8 + 120 * share ** (2 / 3), color=RUN_STYLES[0]["color"],
                 alpha=0.6, linewidth=0)
    end = np.nanmax(fluid.time)
    if fluid.front:
        time = np.linspace(0, end, 300)
        axes.plot(clock(time), front(fluid.front[0], time), color="black",
                  label=f"front, D = {fluid.front[0]:.2g} ± {fluid.front[1]:.1g} m²/s")
    if fluid.stop and fluid.stop < end:
        axes.axvline(clock(fluid.stop), color="0.5", linestyle=":", linewidth=1.2, label="shut-in")
    if fluid.back:
        time = fluid.stop + (end - fluid.stop) * np.linspace(0, 1, 300) ** 2
        axes.plot(clock(time), back_front(fluid.back[0], time, fluid.stop, fluid.dimension), color=RED, linestyle="--",
                  label=f"back front, D = {fluid.back[0]:.2g} ± {fluid.back[1]:.1g} m²/s")
    axes.set(title="Events from the nearest well", ylabel="distance (m)",
             xlabel=f"time since its injection began ({clock.name})", xlim=(0, None),
             ylim=(0, 1.5 * np.nanmax(fluid.distance) or None))  # room for the legend
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left")


def draw_volume(axes, fluid, events, course):
    """Moments against the injected volume, with the bounds of its largest event."""
    time, total, seismic = course
    shown = fluid.volume > 0
    volume = fluid.volume[shown]
    for values, style in ((total[shown], {"color": "black", "label": "all slip"}),
                          (seismic[shown], {"color": RUN_STYLES[0]["color"], "label": "events"}),
                          (largest_so_far(time, events["onset"], events["moment"])[shown],
                           {"color": RED, "label": "largest event"})):
        axes.plot(volume, np.where(values > 0, values, np.nan), **style)
    least = np.inf
    for (name, values), dashes in zip(bounds(volume, fluid.modulus, fluid.gamma).items(), ("--", ":")):
        axes.plot(volume, values, color="0.45", linestyle=dashes, label=name)
        least = min(least, values.min())
    # moments of the first creep would fill the axis
    axes.set(xscale="log", yscale="log", ylim=(1e-2 * least, None), title="Moment and injected volume",
             xlabel="injected volume (m³)", ylabel="moment (N m)")
    axes.legend(loc="upper left", bbox_to_anchor=(0, -0.2), fontsize=9)


def figure(run, events, pressure, course, fluid):
    use_style()
    time, total, seismic = course
    clock = Clock(0.0, float(time[-1]), None)
    left, right = 3 if pressure else 2, []
    if fluid.sources and np.isfinite(fluid.time).any():
        right.append(lambda axes: draw_migration(axes, fluid, events, Clock(0.0, float(np.nanmax(fluid.time)), None)))
    if fluid.volume is not None and (fluid.volume > 0).any():
        right.append(lambda axes: draw_volume(axes, fluid, events, course))
    canvas = plt.figure(figsize=(15 if right else 9, 7.6 if left > 2 or right else 5.4), layout="constrained")
    parts = canvas.subfigures(1, 2, width_ratios=(3, 2)) if right else [canvas]
    for axes, draw in zip(parts[-1].subplots(len(right), 1, squeeze=False).ravel() if right else (), right):
        draw(axes)
    panels = parts[0].subplots(left, 1, sharex=True)
    if pressure:
        panels[0].plot(clock(pressure[0]), pressure[1] / 1e6, color=RUN_STYLES[0]["color"])
        panels[0].set(title="Largest pore pressure", ylabel="pressure (MPa)",
                      ylim=(min(0, float(pressure[1].min()) / 1e6), None))
    middle, last = panels[-2], panels[-1]
    known = np.isfinite(events["magnitude"])
    if known.any():
        size = events["magnitude"][known]
        bottom = np.floor(2 * size.min() - 0.2) / 2
        middle.vlines(clock(events["onset"][known]), bottom, size, color=RUN_STYLES[0]["color"], linewidth=0.8,
                      alpha=0.7)
        middle.plot(clock(events["onset"][known]), size, linestyle="", marker="o", markersize=4,
                    color=RUN_STYLES[0]["color"], markeredgewidth=0)
        middle.set_ylim(bottom, size.max() + 0.3)
    count = len(events["onset"])
    middle.set(title=f"{count or 'No'} event{'s' * (count != 1)}", ylabel="moment magnitude")
    last.plot(clock(time), total, color="black", label="all slip")
    last.plot(clock(time), seismic, color=RUN_STYLES[0]["color"], label="events")
    last.fill_between(clock(time), seismic, total, color="0.85", linewidth=0, label="aseismic")
    share = seismic[-1] / total[-1] if total[-1] > 0 else 0.0
    last.set(title=f"Moment, {100 * share:.3g} % seismic", ylabel="moment (N m)", xlabel=clock.label,
             xlim=(0, float(clock(clock.span))), ylim=(0, None))
    last.legend(loc="upper left")
    return canvas


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("run", metavar="RUN", help="output file of the run")
    parser.add_argument("catalogue", metavar="EVENTS", help="its catalogue of events")
    parser.add_argument("--pressure", metavar="FILE",
                        help="that of -fault_pore_pressure (default: the run's field pore_pressure)")
    parser.add_argument("--wells", metavar="WELLS.csv", help="wells from which distances count (default: those of the "
                        "run's -fault_wells, or its -fault_injection)")
    parser.add_argument("--dimension", type=int, choices=(1, 2, 3), help="of the space in which the fluid spreads, for "
                        "the back front (default 2, the fault; 1 for a grid that is a line)")
    parser.add_argument("--galis", type=float, default=GALIS, metavar="GAMMA", help="gamma of the moment gamma dV^1.5 "
                        "[N m^-3.5] (default %(default)g)")
    parser.add_argument("--csv", metavar="OUT", help="table to write, default RUN_injection.csv")
    parser.add_argument("--figure", metavar="OUT", help="picture to write, default RUN_injection.png")
    options = parser.parse_args()
    if not 0 < options.galis < np.inf:
        parser.error(f"--galis is {options.galis:g}, expected a positive number")
    stem = os.path.splitext(options.run)[0] + "_injection"
    table, picture = options.csv or stem + ".csv", options.figure or stem + ".png"
    run, catalogue = Run(options.run), Catalogue(options.catalogue)
    run.warn()
    run.require_fault("moments")
    events = {name: np.asarray(catalogue.event[name]) for name in ("onset", "end", "moment", "magnitude", "cell")}
    pressure = read_pressure(run, options.pressure)
    time, total, seismic = moments(run, events)
    peak = np.interp(time, *pressure) if pressure else np.full(len(time), np.nan)
    write_csv(table, [["time [s]", "largest_pressure [Pa]", "moment [N m]", "seismic_moment [N m]"],
                      *zip(time.tolist(), peak.tolist(), total.tolist(), seismic.tolist())])
    fluid = Fluid(run, events, options)
    figure(run, events, pressure, (time, total, seismic), fluid).savefig(picture)
    share = seismic[-1] / total[-1] if total[-1] > 0 else 0.0
    print(f"{len(events['onset'])} event{'s' * (len(events['onset']) != 1)}"
          + (f", the largest M {np.nanmax(events['magnitude']):.2f}, the first at "
             f"{written(float(events['onset'].min()))}" if len(events["onset"]) else ""))
    if pressure:
        print(f"Largest pressure: {pressure[1].max() / 1e6:.4g} MPa at "
              f"{written(float(pressure[0][pressure[1].argmax()]))}")
    else:
        print("Pressure: unknown; --pressure FILE, or -fault_output_fields with pore_pressure")
    print("\n".join(fluid.lines()))
    if not total[-1] > 0:
        print(f"Moment: nothing has slipped\nTable: {table}\nFigure: {picture}")
        return
    print(f"Moment: {total[-1]:.4g} N m (M {magnitude(total[-1]):.2f}), seismic {seismic[-1]:.4g} N m "
          f"({100 * share:.3g} %), aseismic {total[-1] - seismic[-1]:.4g} N m ({100 * (1 - share):.3g} %)\n"
          f"Table: {table}\nFigure: {picture}")
