"""What an injection has moved: events against time with the pressure, and how much of the slip was seismic.

    slipstep injection RUN.h5 EVENTS.h5 [--pressure PRESSURE.h5] [--figure OUT.png] [--csv OUT.csv]

The seismic moment is the sum of the catalogue's events, the moment of all that slipped between their onsets and ends.
The total is that of all slip since the start, and the rest is aseismic. The pressure is that of the file of
-fault_pore_pressure, or of the run's field pore_pressure.
"""

import argparse
import os

import h5py
import numpy as np

from ..errors import OutputError
from ..plots.panels import RUN_STYLES, plt, use_style
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


def figure(run, events, pressure, course):
    use_style()
    time, total, seismic = course
    clock = Clock(0.0, float(time[-1]), None)
    canvas, panels = plt.subplots(3 if pressure else 2, 1, figsize=(9, 7.6 if pressure else 5.4), layout="constrained",
                                  sharex=True)
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
    parser.add_argument("--csv", metavar="OUT", help="table to write, default RUN_injection.csv")
    parser.add_argument("--figure", metavar="OUT", help="picture to write, default RUN_injection.png")
    options = parser.parse_args()
    stem = os.path.splitext(options.run)[0] + "_injection"
    table, picture = options.csv or stem + ".csv", options.figure or stem + ".png"
    run, catalogue = Run(options.run), Catalogue(options.catalogue)
    run.warn()
    run.require_fault("moments")
    events = {name: np.asarray(catalogue.event[name]) for name in ("onset", "end", "moment", "magnitude")}
    pressure = read_pressure(run, options.pressure)
    time, total, seismic = moments(run, events)
    peak = np.interp(time, *pressure) if pressure else np.full(len(time), np.nan)
    write_csv(table, [["time [s]", "largest_pressure [Pa]", "moment [N m]", "seismic_moment [N m]"],
                      *zip(time.tolist(), peak.tolist(), total.tolist(), seismic.tolist())])
    figure(run, events, pressure, (time, total, seismic)).savefig(picture)
    share = seismic[-1] / total[-1] if total[-1] > 0 else 0.0
    print(f"{len(events['onset'])} event{'s' * (len(events['onset']) != 1)}"
          + (f", the largest M {np.nanmax(events['magnitude']):.2f}, the first at "
             f"{written(float(events['onset'].min()))}" if len(events["onset"]) else ""))
    if pressure:
        print(f"Largest pressure: {pressure[1].max() / 1e6:.4g} MPa at "
              f"{written(float(pressure[0][pressure[1].argmax()]))}")
    else:
        print("Pressure: unknown; --pressure FILE, or -fault_output_fields with pore_pressure")
    if not total[-1] > 0:
        print(f"Moment: nothing has slipped\nTable: {table}\nFigure: {picture}")
        return
    print(f"Moment: {total[-1]:.4g} N m (M {magnitude(total[-1]):.2f}), seismic {seismic[-1]:.4g} N m "
          f"({100 * share:.3g} %), aseismic {total[-1] - seismic[-1]:.4g} N m ({100 * (1 - share):.3g} %)\n"
          f"Table: {table}\nFigure: {picture}")
