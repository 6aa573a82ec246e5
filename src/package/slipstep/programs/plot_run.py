"""Plot one run: of a fault slip rate and slip against time and maps near the peak and at the end, of other models their
series; step size and error estimate against time. Or of a fault: snapshots, a rupture, a space-time picture, a film.

    slipstep plot-run RUN.h5 [--figure OUT.png]
    slipstep plot-run RUN.h5 --time 2 4 8 --field slip_rate --log-rate     a field at some times
    slipstep plot-run RUN.h5 --kind rupture                                the largest event, or the one in --window
    slipstep plot-run RUN.h5 --kind space-time --along strike --at 5       against time, or --against step
    slipstep plot-run RUN.h5 --film OUT.mp4 --pace rate                    or OUT.gif
"""

import argparse
import os

import numpy as np
from ..plots.film import PACES, film
from ..plots.maps import draw_map, frames_of, heights_of
from ..plots.panels import (DENSE, DOTS, RED, RUN_STYLES, draw_series, draw_steps, legend_above, log_scale, plt,
                            use_style)
from ..plots.snapshots import rupture, snapshots
from ..plots.spacetime import place, space_time
from ..results.run import Run
from ..times import Clock, seconds

# What each kind of picture takes; all take --figure (the film has its own), --range, --years and --log-rate.
KINDS = {"overview": set(), "snapshots": {"time", "field", "window"}, "rupture": {"time", "window"},
         "space-time": {"field", "window", "along", "at", "against"},
         "film": {"field", "window", "fps", "frames", "pace"}}


HIGH = 3.7  # inches of a row of panels
MAP_WIDTH = 4.0  # inches
MARGIN = 0.03  # of times, at both ends
# of an overview: a bar is as far to the right as the layout before has made its map wide, and the layout leaves room
# for it
LAYOUTS = 3


def draw_error(axes, run, style, clock):
    """Local error estimate of each attempt that has one, with the limit 1 of the tolerances."""
    known = run.steps["error"] > 0
    for chosen, marker in ((known & run.accepted, {"color": style["color"]}), (known & run.rejected, {"color": RED})):
        axes.plot(clock(run.steps["time"][chosen]), run.steps["error"][chosen],
                  **(DOTS if len(run.steps["error"]) > DENSE else {"linestyle": "", "marker": "o", "markersize": 4}),
                  **marker)
    axes.axhline(1.0, color="black", linewidth=0.8, linestyle="--")
    log_scale(axes)
    axes.set(title="Error estimate (1 is the tolerance)", xlabel=clock.label, ylabel="error over the tolerance")


def draw_columns(axes, run, units, clock):
    """Every column of the series that is in one of these units."""
    styles = RUN_STYLES + [dict(style, marker=".") for style in RUN_STYLES]
    for style, (name, unit) in zip(styles, (item for item in run.columns.items() if item[1] in units)):
        draw_series(axes, run, name, style, f"{name} ({unit})", clock)
    axes.set_xlabel(clock.label)
    axes.legend()


def attempt_panels(run):
    """Rows of panels for what the file has of attempts; constant steps have no error estimate."""
    if not len(run.steps["dt"]):
        return []
    return [["steps", "error"]] if (run.steps["error"] > 0).any() else [["steps", "steps"]]


def draw_attempt_panels(axes, run, style, clock):
    if "steps" in axes:
        draw_steps(axes["steps"], run, style, "", clock)
        axes["steps"].set(title="Step size", xlabel=clock.label, ylabel="step (s)")  # in seconds whatever the clock's
        legend_above(axes["steps"])
    if "error" in axes:
        draw_error(axes["error"], run, style, clock)


def small_figure(run, clock):
    """Any other model: the first series' unit apart from the others."""
    use_style()
    rows = [["first", "second"], *attempt_panels(run)]
    canvas, axes = plt.subplot_mosaic(rows, figsize=(11, HIGH * len(rows)), layout="constrained")
    units = list(dict.fromkeys(run.columns.values()))
    draw_columns(axes["first"], run, units[:1], clock)
    draw_columns(axes["second"], run, units[1:] or units, clock)
    draw_attempt_panels(axes, run, RUN_STYLES[0], clock)
    canvas.suptitle(f"{run.title}: {run.result['accepted']} accepted, {run.result['rejected']} rejected")
    return canvas


def draw_rates(axes, run, style, clock, log):
    """Largest and mean slip rate."""
    draw_series(axes, run, "max_slip_rate", {"color": "#9a9a9a", "marker": ".", "zorder": 1}, "largest", clock)
    draw_series(axes, run, "mean_slip_rate", style, "mean", clock)
    axes.set(title="Slip rate", xlabel=clock.label, ylabel="slip rate (m/s)")
    if log and (run.series["max_slip_rate"] > 0).any():
        log_scale(axes)
    legend_above(axes)


def map_height(run):
    """Inches of a row of maps: of a long fault less than of other panels."""
    frames = frames_of(run, tall=True)
    if len(frames) > 1:
        return max(sum(heights_of(frames)) + 0.4, HIGH)
    (x0, x1, z0, z1), = frames
    return float(np.clip(MAP_WIDTH * (z1 - z0) / (x1 - x0) + 1.0, 2.0, HIGH))


def figure(run, clock, log, wanted=None):
    """Time series above, maps of the fields that the run stored below."""
    use_style()
    stored = [name for name in ("slip_rate", "slip") if name in run.field_names]
    maps = [f"map of {name}" for name in stored]
    rows = [["rate", "slip"], *attempt_panels(run), *([maps + ["."] * (2 - len(maps))] if maps else [])]
    heights = [HIGH] * len(rows)
    if maps:
        heights[-1] = map_height(run)
    canvas, axes = plt.subplot_mosaic(rows, figsize=(11, sum(heights)), height_ratios=heights, layout="constrained")
    style = RUN_STYLES[0]
    draw_rates(axes["rate"], run, style, clock, log)
    draw_series(axes["slip"], run, "mean_slip", style, "mean slip", clock)
    axes["slip"].set(title="Mean slip", xlabel=clock.label, ylabel="slip (m)")
    draw_attempt_panels(axes, run, style, clock)
    low, high = (float(clock(time)) for time in (clock.origin, clock.origin + clock.span))
    for name in {"rate", "slip", "steps", "error"} & set(axes):  # all of the run: error estimates begin later
        axes[name].set_xlim(low - MARGIN * (high - low), high + MARGIN * (high - low))
    times = {"slip_rate": run.series["time"][run.peak], "slip": run.series["time"][-1]}
    labels = {"slip_rate": ("Slip rate", "slip rate (m/s)"), "slip": ("Slip", "slip (m)")}
    for plane, name in zip((axes[name] for name in maps), stored):
        time = draw_map(plane, run, name, times[name], labels[name][1], log and name == "slip_rate",
                        wanted if name == "slip_rate" else None)
        plane.set_title(f"{labels[name][0]} at {clock.text(time)}"
                        + (", near its largest" if name == "slip_rate" else ""))
    canvas.suptitle(f"{run.title}: {run.result['accepted']} accepted, {run.result['rejected']} rejected, "
                    f"{'final ' if run.complete else ''}mean slip {run.result['mean_slip']:.4f} m")
    for _ in range(LAYOUTS):
        canvas.get_layout_engine().execute(canvas)
    return canvas


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("run", metavar="FILE", help="output file of a run")
    parser.add_argument("--figure", metavar="PNG",
                        help="file to write, default FILE with .png; its ending chooses the format (png, pdf, svg)")
    parser.add_argument("--kind", choices=[kind for kind in KINDS if kind != "film"],
                        help="the picture; default: snapshots with --time or --field, else overview")
    parser.add_argument("--time", nargs="+", type=seconds, metavar="T",
                        help="times of snapshots: seconds, or a number with s, min, h, d, y, as 250y")
    parser.add_argument("--field", metavar="NAME", help="one of /fields, of two components its magnitude, or a "
                        "component as slip_up_dip or slip_along_strike, or stress_drop, or a parameter of "
                        "the cells as slip_tendency; default slip_rate, of "
                        "space-time slip_rate and slip")
    parser.add_argument("--window", nargs=2, type=seconds, metavar=("BEGIN", "END"),
                        help="draw only this part of the run; times as of --time")
    parser.add_argument("--range", nargs=2, type=float, metavar=("LOW", "HIGH"),
                        help="ends of the colour bar of the field, in its unit")
    parser.add_argument("--along", choices=("strike", "dip", "depth"), help="of space-time: the line, default strike; "
                        "depth is another name of dip")
    parser.add_argument("--at", type=place, metavar="KM",
                        help="of space-time: where the line is in the other direction, or max, or mean "
                        "over that direction; default the middle")
    parser.add_argument("--against", choices=("time", "step"), help="of space-time: default time")
    parser.add_argument("--years", action=argparse.BooleanOptionalAction,
                        help="time in years, default for more than one year")
    parser.add_argument("--log-rate", action=argparse.BooleanOptionalAction,
                        help="slip rate on a logarithmic scale, default for space-time, film and more than three hours")
    parser.add_argument("--film", metavar="FILE",
                        help="write a film, FILE.mp4 (needs ffmpeg) or FILE.gif, a frame for each row of /fields")
    parser.add_argument("--fps", type=float, help="frames of the film a second, default 15")
    parser.add_argument("--frames", type=int, help="frames of the film at most, default 500")
    parser.add_argument("--pace", choices=PACES, help="which rows of /fields the frames are: default rows, equally "
                        "many apart; time, those nearest to equal steps of time; rate, to equal steps of the logarithm "
                        "of the largest slip rate, up or down")
    options = parser.parse_args()
    check(parser, options)
    return options


def check(parser, options):
    """Options that do not fit together, or whose values make no sense."""
    if options.film and (options.kind or options.figure):
        parser.error(f"--film writes no other picture: leave --{'figure' if options.figure else 'kind'} out")
    options.kind = "film" if options.film else options.kind or ("snapshots" if options.time or options.field
                                                                else "overview")
    for name in sorted(set.union(*KINDS.values()) - KINDS[options.kind]):
        if getattr(options, name) is not None:
            takers = " or ".join("--film" if kind == "film" else f"--kind {kind}" for kind in KINDS
                                 if name in KINDS[kind])
            parser.error(f"--{name} is not for {'--film' if options.film else '--kind ' + options.kind}; expected "
                         f"with {takers}")
    for name in ("range", "window"):
        pair = getattr(options, name)
        if pair and not pair[0] < pair[1]:
            parser.error(f"--{name} is {pair[0]:g} {pair[1]:g}, expected the lower one first")
    for name in ("fps", "frames"):
        value = getattr(options, name)
        if value is not None and not value > 0:
            parser.error(f"--{name} is {value:g}, expected a number > 0")
    if options.kind == "space-time" and options.range and not options.field:
        parser.error("--range needs --field NAME with --kind space-time, which draws two fields")


def picture(run, options):
    """The figure of the kind that is asked for."""
    common = {"log": options.log_rate, "wanted": options.range, "years": options.years}
    field = options.field or "slip_rate"
    if options.kind == "snapshots":
        return snapshots(run, field, options.time, options.window, **common)
    if options.kind == "rupture":
        return rupture(run, options.time, options.window, **common)
    if options.kind == "space-time":
        fields = [options.field] if options.field else [name for name in ("slip_rate", "slip")
                                                        if name in run.field_names] or ["slip_rate"]
        return space_time(run, fields, options.along or "strike", options.at, options.against or "time", options.window,
                          **dict(common, log=options.log_rate is not False))
    clock = Clock(0.0, run.series["time"][-1], options.years)
    return (figure(run, clock, clock.logarithmic("slip_rate", options.log_rate), options.range) if run.is_fault
            else small_figure(run, clock))


def main():
    options = arguments()
    suffix = "" if options.kind == "overview" else f"_{options.kind}"
    target = options.film or options.figure or os.path.splitext(options.run)[0] + suffix + ".png"
    run = Run(options.run)
    run.warn()
    if options.kind != "overview":
        run.require_fault(f"--{'film' if options.film else 'kind ' + options.kind}")
    if options.film:
        shown, rows = film(run, target, options.field or "slip_rate", options.window, options.log_rate is not False,
                           options.range, options.years, options.fps or 15.0, options.frames or 500,
                           options.pace or "rows")
        print(f"Film: {target}, {shown} of {rows} rows of /fields")
    else:
        picture(run, options).savefig(target)
        print(f"Figure: {target}")
