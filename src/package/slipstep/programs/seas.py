"""The files of a SEAS benchmark from a run of it, and a picture: how often it breaks beside what other codes have
found.

    slipstep seas bp5 RUN.h5 CATALOGUE.h5 [--folder DIR] [--figure OUT.png]
    slipstep seas bp4 RUN.h5 CATALOGUE.h5
    slipstep seas bp1 RUN.h5 CATALOGUE.h5
    slipstep seas bp3 RUN.h5 CATALOGUE.h5
    slipstep seas bp6 RUN.h5 CATALOGUE.h5
    slipstep seas bp7 RUN.h5 CATALOGUE.h5

bp5 and bp4: fltst_strk*dp*, global.dat, rupture.dat; bp1 and bp3: fltst_dp*, slip.dat, and of bp3 srfst_fn*; bp6:
fltst_strk*, global.dat, slip.dat; bp7: fltst_strk*dp*, global.dat. slipstep/results/seas.py says what is in them.
examples/seas_bp5.sh, seas_bp4.sh, seas_bp1.sh, seas_bp3.sh, seas_bp6.sh and seas_bp7.sh make the runs.
"""

import argparse
import os

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.ticker import MaxNLocator
from ..errors import OutputError
from ..plots.cumulative import Course, draw_cumulative
from ..plots.maps import Span, colour_bar, planes_of
from ..plots.panels import RED, REFERENCE, RUN_STYLES, log_scale, plt, save, use_style
from ..plots.spacetime import Line
from ..results.catalogue import Catalogue
from ..results.events import Events
from ..results.fields import KINDS, RUPTURE_RATE, kind_of
from ..results.run import Run
from ..results.seas import (BENCHMARKS, DAY, FRONT_RATE, ORIGIN, STOP, cycles, dip_of, first_event, front, has_waves,
                            name_of, pressure, stations_of, surface_of, write_files)
from ..times import YEAR

# Recurrence [years] once cycles repeat, of boundary-element codes, as github.com/thwbecker/interact has found and
# compared it: BP5 with cells of 1 km, BP1 with cells of 25 to 100 m
PUBLISHED = {"bp5": (235.4, "interact, cells of 1 km: 235.4 years"), "bp1": (78.2, "other codes: 78.2 years")}
# Intervals [years] of BP3 that repeat in this order, for a dip and 1 (thrust) or -1 (normal): FDRA with cells of 25 m,
# as github.com/rmskarbek/RSFaultZ has them
CYCLE = {(60, 1): (63.31, 87.12, 91.12, 97.45), (30, -1): (74.05, 109.75)}
# Displacement of the ground there [m], to the right and down, by years and km from the trace
GROUND = {(60, 1): {50.0307: {16: (-0.400304, -0.418260), -16: (-0.031915, 0.527212), 0: (-0.303663, 0.227878)},
                    150.0728: {16: (-1.183382, -1.256208), -16: (-0.085960, 1.584125)}}}
# Slip along strike and up dip [m] of BP7-QD-A's first event at places [m], as EQquasi has it with finite elements of 25
# m in a box of 1 km; what it has at (100, -100) has the sign and size of the side away from the perturbation, (100,
# 100) here
QUASI = {(0, 0): (0.021122, -0.000085), (100, 0): (0.015508, -0.000169), (100, 100): (0.012076, -0.000224)}
STEADY = 2  # intervals that the start still shows in: the later ones are averaged
SNAPSHOTS = (5, 10, 25, 50, 100, 200, 400, 730)  # days, of BP6
SHOWN = 600 * YEAR  # of BP1's cumulative slip


def intervals(events):
    """Years from each cycle's event to the next."""
    return np.diff(events["onset"][cycles(events)]) / YEAR


def recurrence(events):
    """Mean of the intervals that repeat [years]; nan where there are none."""
    later = intervals(events)[STEADY:]
    return later.mean() if len(later) else np.nan


def summary(events):
    """What is compared with other codes, a line each."""
    repeated = recurrence(events)
    first = cycles(events)
    yield f"cycles: {len(first)}, the first from {events['onset'][0] / YEAR:.3f} years on"
    if len(first) > 1:
        yield f"first interval: {intervals(events)[0]:.3f} years"
    if np.isfinite(repeated):
        yield f"recurrence from cycle {STEADY + 1} on: {repeated:.3f} years"
    for name, scale, unit, digits in (("peak_slip_rate", 1, "m/s", 3), ("mean_slip", 1, "m", 3),
                                      ("stress_drop", 1e-6, "MPa", 3), ("moment", 1, "N m", 4)):
        values = scale * events[name][first]
        yield f"{name.replace('_', ' ')}: {values[0]:.{digits}g} {unit} first, {values[-1]:.{digits}g} {unit} last"
    duration = (events["end"] - events["onset"])[first]
    yield f"above {RUPTURE_RATE:g} m/s for {duration[0]:.0f} s first, {duration[-1]:.0f} s last"


def ground_summary(run):
    """BP3: displacement of the ground before the first event beside others', a line each."""
    dip, sign = dip_of(run)
    found = {round(y / 1e3): values for y, values in surface_of(run).items()}
    for years, places in GROUND.get((round(dip), sign), {}).items():
        for x, wanted in places.items():
            if x not in found or found[x][0][-1] < years * YEAR:
                continue
            time, displacement, _ = found[x]
            right, down = (np.interp(years * YEAR, time, displacement[:, k]) for k in (0, 1))
            yield (f"ground at {x:+d} km after {years:g} years: {right:.4f} m to the right, {down:.4f} m down (FDRA: "
                   f"{wanted[0]:.4f}, {wanted[1]:.4f})")


def draw_rate(axes, run, events):
    time = run.series["time"] / YEAR
    axes.plot(time, run.series["max_slip_rate"], color=RUN_STYLES[0]["color"], linewidth=0.9)
    axes.axhline(RUPTURE_RATE, color=RED, linewidth=0.8, linestyle=(0, (4, 2)), label="1 mm/s: events are faster")
    axes.set(title=f"Largest slip rate: {len(cycles(events))} cycles", xlabel="time (years)", ylabel="m/s",
             xlim=(0, time[-1]))
    log_scale(axes)
    axes.legend(loc="upper right", bbox_to_anchor=(1.0, 1.12))


def published(benchmark, run):
    """Recurrence [years] of other codes, and in words; None where there is none: those are of runs without waves."""
    return None if has_waves(run) else PUBLISHED.get(benchmark)


def draw_recurrence(axes, run, events, benchmark):
    """Intervals beside those of other codes; of BP3 those that repeat, from the place in their order that fits best."""
    years, repeated = intervals(events), recurrence(events)
    number = np.arange(1, len(years) + 1)
    axes.set(title="From one event to the next", xlabel="interval", ylabel="years",
             xlim=(0.5, max(len(years), 1) + 0.5))
    if benchmark == "bp3":
        repeated = np.nan  # there is no single one
        dip, sign = dip_of(run)
        cycle = np.array(CYCLE.get((round(dip), sign), ()))
        if len(cycle) and len(years):
            later = years[STEADY:] if len(years) > STEADY else years
            shifts = [np.abs(later - cycle[(np.arange(len(later)) + k) % len(cycle)]).mean() for k in range(len(cycle))]
            first = int(np.argmin(shifts)) - (STEADY if len(years) > STEADY else 0)
            axes.plot(number, cycle[(np.arange(len(years)) + first) % len(cycle)], color=REFERENCE, linestyle="",
                      marker="_", markersize=22, markeredgewidth=3, label="FDRA, repeated")
    else:
        value, label = published(benchmark, run) or (np.mean(years) if len(years) else 1.0, None)
        reach = max(0.02 * value, 1.15 * abs(years - value).max()) if len(years) else 0.02 * value
        axes.set(ylim=(value - reach, value + reach))
        if label:
            axes.axhline(value, color=REFERENCE, linewidth=3.5, alpha=0.7, label=label)
    axes.plot(number, years, **{**RUN_STYLES[0], "linestyle": "", "markersize": 6}, markeredgewidth=0,
              label=f"SlipStep, from interval {STEADY + 1} on: {repeated:.2f} years" if np.isfinite(repeated)
              else "SlipStep")
    axes.xaxis.set_major_locator(MaxNLocator(8, integer=True))
    axes.legend(loc="best")


def draw_normal(axes, run):
    """BP3: effective normal stress at the stations."""
    stations = stations_of(run)
    for station, colour in zip(stations[::2], plt.get_cmap("viridis")(np.linspace(0, 0.92, len(stations[::2])))):
        along = station["z"] / np.sin(np.radians(dip_of(run)[0])) / 1e3
        axes.plot(station["time"] / YEAR, station["normal_stress"] / 1e6, color=colour, linewidth=0.8,
                  label=f"{along:g} km")
    axes.set(title="Normal stress at distances along the dip", xlabel="time (years)", ylabel="MPa",
             xlim=(0, run.series["time"][-1] / YEAR))
    axes.legend(fontsize=8, ncols=6, loc="upper left", bbox_to_anchor=(0, -0.16))


def draw_front(canvas, axes, run, events):
    """The rupture front of the first event, over its slip."""
    plane, = planes_of(run)
    window = first_event(events)
    slip = run.field_at("slip", window[1])[1] - (run.field_at("slip", window[0])[1] if window[0] else 0.0)
    norm = Span().see(slip).norm(KINDS["slip"])
    artist = plane.draw(axes, plane.values(slip), norm, KINDS["slip"].colours)
    broke = plane.values(front(run, window))
    broke -= window[0]
    levels = np.arange(5, np.nanmax(broke, initial=0), 5)
    if len(levels):
        plane.contour(axes, broke, levels)
    plane.frame(axes)
    axes.set(title=f"First {'large ' if window[0] else ''}event: slip, and when {FRONT_RATE:g} m/s\nwas "
                   "reached, every 5 s", xlabel="along strike (km)")
    colour_bar(canvas, artist, norm, "slip (m)", ax=axes, location="bottom", shrink=0.8, aspect=30, pad=0.02)


def draw_slip(axes, benchmark, run, events):
    """Cumulative slip: of BP5 at a depth of 10 km, of BP1 over depth for the first cycles."""
    plane, = planes_of(run)
    pairs = np.stack([events["onset"], events["end"]], axis=1)
    if benchmark in ("bp4", "bp5"):
        draw_cumulative(axes, Course(run, Line(plane, "strike", 40.0 if benchmark == "bp4" else 10.0), "slip", None,
                                     10.0), pairs)
        return
    course = Course(run, Line(plane, "depth"), "slip", 5 * YEAR, 10.0)
    draw_cumulative(axes, course, pairs)
    shown = min(SHOWN, course.times[-1])
    axes.set(xlim=(0, 1.03 * course.values[course.times <= shown].max()))
    axes.set_title(f"Cumulative slip, {shown / YEAR:.0f} years", pad=22)
    axes.xaxis.set_major_locator(MaxNLocator(8, steps=[1, 2, 5, 10]))


def injection_summary(run):
    """Of BP6, a line each."""
    time, rate = run.series["time"], run.series["max_slip_rate"]
    times, slip = run.field("slip")
    middle = slip.shape[1] // 2
    yield f"largest slip rate: {rate.max():.4g} m/s at {time[rate.argmax()] / DAY:.2f} days"
    for days in (STOP / DAY, times[-1] / DAY):
        if days <= times[-1] / DAY * (1 + 1e-9):
            yield (f"slip at the injection after {days:.4g} days: "
                   f"{np.interp(days * DAY, times, slip[:, middle, 0]):.5f} m")


def injection_figure(run):
    """BP6: pressure and slip at some times, and the slip rate over all, with lines of equal pressure."""
    use_style()
    canvas = plt.figure(figsize=(11, 10), layout="constrained")
    grid = canvas.add_gridspec(2, 2, height_ratios=(3, 4))
    times, slip = run.field("slip")
    rates = run.field("slip_rate")[1][:, :, 0]
    z = (run.axes[1] - ORIGIN["bp6"]) / 1e3
    chosen = [days for days in SNAPSHOTS if days * DAY <= times[-1]]
    colours = plt.get_cmap("viridis")(np.linspace(0, 0.92, len(chosen)))
    left, right = canvas.add_subplot(grid[0, 0]), canvas.add_subplot(grid[0, 1])
    for days, colour in zip(chosen, colours):
        left.plot(z, pressure(1e3 * z, days * DAY) / 1e6, color=colour, label=f"{days} days")
        right.plot(z, [np.interp(days * DAY, times, column) for column in slip[:, :, 0].T], color=colour)
    left.set(title="Pore pressure", ylabel="MPa")
    right.set(title="Slip", ylabel="m")
    left.legend(fontsize=9)
    reach = 1.3 * abs(z[slip[-1, :, 0] > 1e-3]).max(initial=1.0)
    for axes in (left, right):
        axes.set(xlabel="distance from the injection (km)", xlim=(-reach, reach))
    axes = canvas.add_subplot(grid[1, :])
    norm = LogNorm(1e-13, rates.max())
    image = axes.pcolormesh(times / DAY, z, np.maximum(rates, 1e-13).T, norm=norm, cmap="magma", shading="nearest",
                            rasterized=True)
    p = np.array([pressure(1e3 * z, t) for t in times]) / 1e6
    lines = axes.contour(times / DAY, z, p.T, levels=[0.1, 0.8, 2, 4], colors="white", linewidths=0.9)
    axes.clabel(lines, fmt="%g MPa", fontsize=8)
    axes.axvline(STOP / DAY, color="white", linestyle=(0, (4, 2)), linewidth=0.9)
    axes.set(title="Slip rate, with lines of equal pore pressure; dashed: end of the injection", xlabel="time (days)",
             ylabel="distance from the injection (km)", ylim=(-reach, reach))
    axes.grid(False)
    colour_bar(canvas, image, norm, "slip rate (m/s)", ax=axes, pad=0.01, aspect=25)
    canvas.suptitle(f"SEAS {name_of('bp6', run)}, cells of {np.diff(run.axes[1])[0]:g} m: {run.title}")
    return canvas


def vector_summary(run, events):
    """Of BP7, a line each."""
    yield (f"first event: {events['end'][0] - events['onset'][0]:.3g} s, peak slip rate "
           f"{events['peak_slip_rate'][0]:.4g} m/s, moment {events['moment'][0]:.4g} N m")
    for station in stations_of(run):
        place = tuple(round(station[axis] - ORIGIN["bp7"]) for axis in ("x", "z"))
        slip = [np.interp(events["end"][0] + 10, station["time"], station["slip"][:, k]) for k in (0, 1)]
        other = "" if place not in QUASI else " (EQquasi: {:.6f}, {:.6f})".format(*QUASI[place])
        yield (f"slip 10 s after it at ({place[0]}, {place[1]}) m: {slip[0]:.6f} m along strike, {slip[1]:.6f} m up "
               f"dip{other}")


def vector_figure(run, events):
    """BP7: the largest slip rate, and both components of slip after the first event."""
    use_style()
    canvas = plt.figure(figsize=(11, 8), layout="constrained")
    grid = canvas.add_gridspec(2, 2, height_ratios=(2, 4))
    axes = canvas.add_subplot(grid[0, :])
    axes.plot(run.series["time"] / DAY, run.series["max_slip_rate"], color=RUN_STYLES[0]["color"], linewidth=0.9)
    axes.axhline(RUPTURE_RATE, color=RED, linewidth=0.8, linestyle=(0, (4, 2)))
    axes.set(title="Largest slip rate", xlabel="time (days)", ylabel="m/s", xlim=(0, run.series["time"][-1] / DAY))
    log_scale(axes)
    plane = planes_of(run)[0]
    for k, name in enumerate(("slip_along_strike", "slip_up_dip")):
        kind = kind_of(name, "m")
        values = run.field_at(name, events["end"][0] + 10)[1]
        norm, axes = Span().see(values).norm(kind), canvas.add_subplot(grid[1, k])
        artist = plane.draw(axes, plane.values(values), norm, kind.colours)
        axes.set(title=f"{kind.title} after the first event")
        colour_bar(canvas, artist, norm, f"{kind.title.lower()} (m)", ax=axes, location="bottom", shrink=0.8, aspect=30,
                   pad=0.02)
    canvas.suptitle(f"SEAS {name_of('bp7', run)}, cells of {np.diff(run.axes[1])[0]:g} m: {run.title}")
    return canvas


def figure(benchmark, run, events):
    use_style()
    rows = {"bp4": (2.6, 4.4, 5.0), "bp5": (2.6, 3.4, 5.0), "bp3": (2.6, 3.2, 5.0)}.get(benchmark, (2.6, 6.0))
    canvas = plt.figure(figsize=(11, sum(rows)), layout="constrained")
    grid = canvas.add_gridspec(len(rows), 2, height_ratios=rows, width_ratios=(1, 1.5))
    draw_rate(canvas.add_subplot(grid[0, :]), run, events)
    draw_recurrence(canvas.add_subplot(grid[1, 0]), run, events, benchmark)
    if benchmark == "bp3":
        draw_normal(canvas.add_subplot(grid[1, 1]), run)
    if benchmark in ("bp4", "bp5"):
        draw_front(canvas, canvas.add_subplot(grid[1, 1]), run, events)
    draw_slip(canvas.add_subplot(grid[1, 1] if benchmark == "bp1" else grid[2, :]), benchmark, run, events)
    dip, sign = dip_of(run)
    side = np.diff(run.axes[1])[0] / np.sin(np.radians(dip))
    what = f", {'thrust' if sign > 0 else 'normal fault'} of {dip:g} degrees" if benchmark == "bp3" else ""
    canvas.suptitle(f"SEAS {name_of(benchmark, run)}{what}, cells of {side:g} m: {run.title}")
    return canvas


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("benchmark", choices=sorted(BENCHMARKS))
    parser.add_argument("run", metavar="RUN", help="output file of the run")
    parser.add_argument("catalogue", metavar="CATALOGUE", help="file of its -fault_catalogue")
    parser.add_argument("--folder", metavar="DIR", help="folder for the benchmark's files, default RUN without .h5")
    parser.add_argument("--figure", metavar="PNG",
                        help="file to write, default RUN with _seas.png; its ending chooses the format")
    options = parser.parse_args()
    stem = os.path.splitext(options.run)[0]
    target = options.figure or stem + "_seas.png"
    injection = options.benchmark == "bp6"  # which has no events
    run, events = Run(options.run), (Catalogue if injection else Events)(options.catalogue)
    run.warn()
    if run.planes or len(run.axes[1]) < 2:
        raise OutputError(f"{run.path}: expected a run on a grid, with two rows of cells at least")
    paths = write_files(options.benchmark, run, events, options.folder or stem)
    canvas = (injection_figure(run) if injection else vector_figure(run, events) if options.benchmark == "bp7"
              else figure(options.benchmark, run, events))
    save(canvas, target) if target.endswith(".png") else canvas.savefig(target)
    lines = list(injection_summary(run) if injection else vector_summary(run, events) if options.benchmark == "bp7"
                 else summary(events))
    for line in lines + (list(ground_summary(run)) if options.benchmark == "bp3" else []):
        print(line)
    if published(options.benchmark, run):
        print(f"recurrence of {published(options.benchmark, run)[1]}")
    print(f"Files: {len(paths)} in {os.path.dirname(paths[0])}")
    print(f"Figure: {target}")
