"""Compare runs of one fault under different controllers: a table, and a figure.

    slipstep compare --reference FINE.h5 --figure OUT.png rl=output/rl.h5 heuristic=output/heuristic.h5

Each run is LABEL=FILE or FILE. Errors are those of the final mean slip and of the mean slip at any time, over the final
one. The slip-rate map is that of the first run. The reference is such an output file too, of a run with much smaller
steps on the same mesh.
"""

import argparse
import os

from ..errors import OutputError
from ..plots.maps import draw_map
from ..plots.panels import (RUN_STYLES, draw_reference, draw_series, draw_steps, legend_above, legend_of_dots,
                            log_scale, plt, use_style)
from ..results.course import Course, from_start, history, passage
from ..results.run import Run
from ..times import Clock


def load(argument):
    """(label, Run) of LABEL=FILE; the label of a bare file is its name."""
    label, equals, path = argument.partition("=")
    run = Run(path if equals else argument)
    run.require_fault("a comparison")
    run.warn()
    return ((label if equals else os.path.splitext(os.path.basename(argument))[0])
            + ("" if run.complete else " (unfinished)"), run)


def check_same_case(run, reference):
    """A reference for another mesh or duration would make every error meaningless."""
    if run.shape != reference.shape:
        raise OutputError(f"{run.path} has {run.shape} cells (depth, strike) but the reference {reference.path} has "
                          f"{reference.shape}")
    for axis, mine, theirs in zip("xz", run.axes, reference.axes):
        if abs(mine - theirs).max() > 1e-6 * abs(theirs).max():
            raise OutputError(f"{run.path} and the reference {reference.path} differ in the cell centres {axis}")
    end, fine = run.series["time"][-1], reference.series["time"][-1]
    if abs(end - fine) > 1e-6 * fine and run.complete:
        raise OutputError(f"{run.path} ends at {end:g} s but the reference {reference.path} at {fine:g} s")


def slip_error(run, reference):
    """Error of the final mean slip, relative to the reference."""
    return run.result["mean_slip"] / reference.result["mean_slip"] - 1.0


def course_of(run):
    return Course(*from_start(run.series))


def half_slip_time(run):
    """When the mean slip passes half of its end [s]."""
    return passage(course_of(run), 0.5) if run.result["mean_slip"] > 0 else float("nan")


def products(run):
    """Products with stiffness and viscosity (older files: stiffness, or none) + of the preconditioner."""
    known = [run.result[name] for name in ("products_all", "products") if name in run.result]
    preconditioner = run.result.get("products_pc", 0)
    return (f"{known[0]:.0f}" if known else "-") + (f" + {preconditioner:.0f}" if preconditioner else "")


def cost(run):
    """Modelled processor time of the whole run [s]; older files do not know it."""
    return f"{run.result['cost']:.3f}" if "cost" in run.result else "-"


def table(runs, reference):
    """The comparison as lines of text."""
    heads = ["controller", "accepted", "rejected", "Bathe solves", "products", "cost (s)", "wall time (s)",
             "final mean slip (m)", "error (%)", "largest over time (%)", "half of it at (s)"]
    rows = [[label, str(run.result["accepted"]), str(run.result["rejected"]), str(run.result["solves"]), products(run),
             cost(run), f"{run.result['wall_time_solve']:.2f}", f"{run.result['mean_slip']:.5f}",
             *((f"{100 * slip_error(run, reference):+.2f}",
                f"{100 * history(course_of(run), course_of(reference)):.2f}") if reference and run.complete
               else ("-", "-")), f"{half_slip_time(run):.2f}"] for label, run in runs]
    if reference:
        rows.append(["reference", str(reference.result["accepted"]), str(reference.result["rejected"]),
                     str(reference.result["solves"]), products(reference), cost(reference), "-",
                     f"{reference.result['mean_slip']:.5f}", "", "", f"{half_slip_time(reference):.2f}"])
    widths = [max(len(row[i]) for row in [heads] + rows) for i in range(len(heads))]
    line = lambda row: "  ".join(c.ljust(w) if i == 0 else c.rjust(w)
                                 for i, (c, w) in enumerate(zip(row, widths))).rstrip()
    return [line(heads), "  ".join("-" * w for w in widths)] + [line(row) for row in rows]


def figure(runs, reference, title):
    """Slip rate, slip and step size against time for all runs, and the map of the first near its peak."""
    use_style()
    canvas, ((rate, slip), (steps, plane)) = plt.subplots(2, 2, figsize=(11, 7.6), layout="constrained")
    clock = Clock(0.0, max(run.series["time"][-1] for _, run in runs))
    log = clock.logarithmic("slip_rate")
    for axes, name in ((rate, "mean_slip_rate"), (slip, "mean_slip")):
        if reference:
            draw_reference(axes, reference, name, "fine reference", clock)
        for (label, run), style in zip(runs, RUN_STYLES):
            draw_series(axes, run, name, style, f"{label}: {run.result['accepted']} steps", clock)
        axes.set_xlabel(clock.label)
    for (label, run), style in zip(runs, RUN_STYLES):
        draw_steps(steps, run, style, label, clock)
    rate.set(title="Mean slip rate", ylabel="slip rate (m/s)")
    slip.set(title="Mean slip", ylabel="slip (m)")
    steps.set(title="Step size", xlabel=clock.label, ylabel="step (s)")
    if log and any((run.series["mean_slip_rate"] > 0).any() for _, run in runs):
        log_scale(rate)
    if log:  # lines are everywhere
        legend_above(rate)
    else:
        rate.legend(loc="upper right")
    legend_of_dots(steps, loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=2)

    label, run = runs[0]
    peak = run.series["time"][run.peak]
    stored = draw_map(plane, run, "slip_rate", peak, "slip rate (m/s)", log)
    plane.set_title(f"Slip rate at {clock.text(stored)} ({label})")
    if title:
        canvas.suptitle(title)
    return canvas


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("runs", nargs="+", metavar="[LABEL=]FILE", help="output files of runs, at most four")
    parser.add_argument("--reference", metavar="FILE", help="output file of a fine run on the same mesh")
    parser.add_argument("--figure", metavar="PNG", help="write the figure to this file")
    parser.add_argument("--title", help="title of the figure")
    options = parser.parse_args()
    if len(options.runs) > len(RUN_STYLES):
        parser.error(f"at most {len(RUN_STYLES)} runs, got {len(options.runs)}")
    runs = [load(argument) for argument in options.runs]
    reference = load(options.reference)[1] if options.reference else None
    for _, run in runs if reference else ():
        check_same_case(run, reference)
    print("\n".join(table(runs, reference)))
    if options.figure:
        figure(runs, reference, options.title).savefig(options.figure)
        print(f"\nFigure: {options.figure}")
