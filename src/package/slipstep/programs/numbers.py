"""The numbers that papers quote of a run: rupture speed, stress drops, corner frequency, durations, coupling, b,
afterslip.

    slipstep numbers RUN.h5 --catalogue EVENTS.h5 [--event largest] [--csv OUT.csv] [--figure OUT.png]
    slipstep numbers EVENTS.h5

Each is defined, with its source, in output/howto/numbers.md.
"""

import argparse

import numpy as np
from matplotlib.colors import Normalize

from ..numbers import of_catalogue, of_event, of_run, rupture, source, spin_up
from ..numbers.report import area_of, event_window, fastest, speed_or_none
from ..plots.maps import colour_bar, planes_of
from ..plots.panels import RUN_STYLES, plt, use_style
from ..plots.snapshots import contours_of
from ..results.catalogue import Catalogue
from ..results.events import Events
from ..results.files import is_catalogue, open_any, write_csv
from ..results.moment import moment_rate
from ..results.run import Run
from ..geometry.cells import cells_of
from ..times import Clock, written


def spectrum_panel(axes, run, onset, end):
    """Spectrum of the moment rate, and the omega-square spectrum that fits."""
    time, rate, _ = moment_rate(run, onset, end)
    rate = np.abs(rate.sum(axis=1))
    keep = np.concatenate([[True], np.diff(time) > 0])
    time, rate = time[keep], rate[keep]
    corner, _ = source.corner_frequency(time, rate)
    frequency = np.geomspace(corner / 30, 30 * corner, 400)
    axes.loglog(frequency, source.spectrum(time, rate, frequency), color=RUN_STYLES[0]["color"], label="run")
    axes.loglog(frequency, source.brune(frequency, source.moments(time, rate)[0], corner), color=RUN_STYLES[1]["color"],
                linestyle="--", label=f"corner {corner:.3g} Hz")
    axes.set(title="Spectrum of the moment rate", xlabel="frequency (Hz)", ylabel="amplitude (N m)")
    axes.legend(loc="lower left")


def speed_panel(axes, catalogue, row, limit):
    """Map of the rupture speed, with lines of equal time of rupture [s], of the plane of which most cells broke."""
    cells, shape = cells_of(catalogue.path, catalogue.mesh, catalogue.extents)
    time = catalogue.map_of("rupture_time", row)
    speeds = rupture.speed(time, cells, shape, catalogue.mesh.get("fault"))
    found = rupture.summary(speeds, time, cells, area_of(catalogue, cells))
    planes = planes_of(catalogue)
    plane = max(planes, key=lambda one: np.isfinite(one.values(time)).sum())
    drawn = plane.values(np.reshape(np.where(np.isfinite(speeds), speeds, np.nan), time.shape)) / 1e3
    norm = Normalize(0, 2 * found[0] / 1e3 if found else np.nanmax(drawn, initial=1e-3))
    artist = plane.draw(axes, drawn, norm, "viridis")
    plane.contour(axes, plane.values(time), contours_of(plane.values(time), Clock(0, np.nanmax(time)))[1])
    plane.frame(axes)
    known = found is not None and np.isfinite(speed_or_none(found[0], limit)[0])
    axes.set(xlabel=plane.along_label, title="Rupture speed" + (f", median {found[0] / 1e3:.2f} km/s" if known else "")
             + (f", {plane.name}" if len(planes) > 1 else "") + "; lines: time (s)")
    colour_bar(axes.figure, artist, norm, "rupture speed (km/s)", extend="max", ax=axes, shrink=0.8)


def figure(run, catalogue, event, spin=None):
    """Rupture speed and spectrum of an event, those that the files have."""
    use_style()
    row, onset, end = event_window(catalogue, event, spin_up(run, catalogue, spin))
    panels = ([lambda axes: speed_panel(axes, Events(catalogue.path), row, fastest(run))] if catalogue.has_maps
              else []) + ([lambda axes: spectrum_panel(axes, run, onset, end)] if run is not None else [])
    if not panels:
        raise ValueError(f"{catalogue.path}: no maps (-fault_catalogue_maps) and no run: there is nothing to draw")
    canvas, axes = plt.subplots(1, len(panels), figsize=(6.2 * len(panels), 4.2), layout="constrained", squeeze=False)
    for one, draw in zip(axes[0], panels):
        draw(one)
    canvas.suptitle(f"Event {row + 1} at {written(onset)}: M {catalogue.event['magnitude'][row]:.2f}")
    return canvas


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("file", metavar="FILE", help="output file of a run, or its catalogue of events")
    parser.add_argument("--catalogue", metavar="EVENTS", help="catalogue of the run")
    parser.add_argument("--event", default="largest", metavar="N",
                        help="the event: its number from 1 on, or largest (default)")
    parser.add_argument("--spin-up", metavar="N|TIME", help="what is left out at the start: a number of events, or a "
                        "time as 50y (default: of loaded runs the first large "
                        "event, with those before it; each line says it)")
    parser.add_argument("--slow", nargs=2, type=float, metavar=("LOW", "HIGH"),
                        help="slip rates of slow slip [m/s], default ten times the plates' rate, and the "
                             "rate of events")
    parser.add_argument("--csv", metavar="OUT", help="table to write")
    parser.add_argument("--figure", metavar="OUT", help="picture to write: map of the rupture speed "
                                                        "(-fault_catalogue_maps) and spectrum of the moment rate")
    options = parser.parse_args()
    if options.event != "largest" and not options.event.isdigit():
        parser.error(f"--event is {options.event}, expected a number from 1 on, or largest")
    if options.slow and not 0 < options.slow[0] < options.slow[1]:
        parser.error(f"--slow is {options.slow[0]:g} {options.slow[1]:g}, expected two rates above 0, the "
                     "lower one first")
    with open_any(options.file) as file:
        alone = is_catalogue(file)
    if alone and options.catalogue:
        parser.error(f"{options.file} is a catalogue, expected a run before --catalogue")
    run = None if alone else Run(options.file)
    catalogue = Catalogue(options.file) if alone else Catalogue(options.catalogue) if options.catalogue else None
    if run is not None:
        run.require_fault("a rupture")
    for data in (run, catalogue):
        if data is not None:
            data.warn()
    if run is not None:
        found = of_run(run, catalogue, options.event, options.slow, options.spin_up)
    else:
        found = ((of_event(None, catalogue, options.event, options.spin_up) if catalogue.count else [])
                 + of_catalogue(catalogue, spin_up(None, catalogue, options.spin_up)))
    if not found:
        raise ValueError(f"{options.file}: no number: a run without loading needs --catalogue")
    for one in found:
        spread = f"{one.low:.4g} to {one.high:.4g}" if np.isfinite(one.low) else ""
        print(f"{one.name:27} {one.value:12.5g} {'' if one.unit == '1' else one.unit:4} {spread:22} "
              f"{one.note}".rstrip())
    if options.csv:
        write_csv(options.csv, [("name", "value", "low", "high", "unit", "note"),
                                *((one.name, float(one.value), float(one.low), float(one.high), one.unit, one.note)
                                  for one in found)])
        print(f"Table: {options.csv}")
    if options.figure:
        if catalogue is None:
            raise ValueError(f"{options.file}: a picture is of an event, expected --catalogue")
        figure(run, catalogue, options.event, options.spin_up).savefig(options.figure)
        print(f"Figure: {options.figure}")
