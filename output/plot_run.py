#!/usr/bin/env python3
"""Plot one run: of a fault slip rate and slip against time and maps near the peak and at the end, of other models their series;
step size and error estimate against time.

    output/plot_run.py output/fault.h5 [--figure OUT.png]
"""

import argparse
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from slipstep_modules import need

need("h5py", "numpy", "matplotlib")
from slipstep_output import OutputError, Run
from slipstep_panels import RED, RUN_STYLES, draw_map, draw_series, draw_steps, log_scale, plt, use_style


def draw_error(axes, run, style):
    """Local error estimate of each attempt that has one, with the limit 1 of the tolerances."""
    known = run.steps["error"] > 0
    for chosen, marker in ((known & run.accepted, {"color": style["color"]}), (known & run.rejected, {"color": RED})):
        axes.plot(run.steps["time"][chosen], run.steps["error"][chosen], linestyle="", marker="o", markersize=4, **marker)
    axes.axhline(1.0, color="black", linewidth=0.8, linestyle="--")
    log_scale(axes)
    axes.set(title="Error estimate (1 is the tolerance)", xlabel="time (s)", ylabel="weighted RMS")


def draw_columns(axes, run, units):
    """Every column of the series that is in one of these units."""
    styles = RUN_STYLES + [dict(style, marker=".") for style in RUN_STYLES]
    for style, (name, unit) in zip(styles, (item for item in run.columns.items() if item[1] in units)):
        draw_series(axes, run, name, style, f"{name} ({unit})")
    axes.set_xlabel("time (s)")
    axes.legend()


def small_figure(run):
    """Any other model: the first series' unit apart from the others."""
    use_style()
    canvas, ((first, second), (steps, error)) = plt.subplots(2, 2, figsize=(11, 7.4), layout="constrained")
    units = list(dict.fromkeys(run.columns.values()))
    draw_columns(first, run, units[:1])
    draw_columns(second, run, units[1:] or units)
    draw_steps(steps, run, RUN_STYLES[0], "attempt")
    steps.set(title="Step size", xlabel="time (s)", ylabel="step (s)")
    steps.legend()
    draw_error(error, run, RUN_STYLES[0])
    canvas.suptitle(f"{run.title}: {run.result['accepted']} accepted, {run.result['rejected']} rejected")
    return canvas


def figure(run):
    """Time series above, maps of the fields that the run stored below."""
    use_style()
    stored = [name for name in ("slip_rate", "slip") if name in run.field_names]
    canvas, axes = plt.subplots(3 if stored else 2, 2, figsize=(11, 11 if stored else 7.4), layout="constrained", squeeze=False)
    style, other = RUN_STYLES[0], {"color": "#9a9a9a", "marker": ".", "zorder": 1}
    (rate, slip), (steps, error) = axes[:2]
    draw_series(rate, run, "max_slip_rate", other, "largest")
    draw_series(rate, run, "mean_slip_rate", style, "mean")
    rate.set(title="Slip rate", xlabel="time (s)", ylabel="slip rate (m/s)")
    rate.legend()
    draw_series(slip, run, "mean_slip", style, "mean slip")
    slip.set(title="Mean slip", xlabel="time (s)", ylabel="slip (m)")
    draw_steps(steps, run, style, "attempt")
    steps.set(title="Step size", xlabel="time (s)", ylabel="step (s)")
    steps.legend()
    draw_error(error, run, style)
    if stored:
        for plane in axes[2][len(stored):]:
            plane.set_axis_off()
        times = {"slip_rate": run.series["time"][run.peak], "slip": run.series["time"][-1]}
        labels = {"slip_rate": ("Slip rate", "slip rate (m/s)"), "slip": ("Slip", "slip (m)")}
        for plane, name in zip(axes[2], stored):
            time = draw_map(plane, run, name, times[name], labels[name][1])
            plane.set_title(f"{labels[name][0]} at {time:.1f} s")
    canvas.suptitle(f"{run.title}: {run.result['accepted']} accepted, {run.result['rejected']} rejected, "
                    f"{'final ' if run.complete else ''}mean slip {run.result['mean_slip']:.4f} m")
    return canvas


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("run", metavar="FILE", help="output file of a run")
    parser.add_argument("--figure", metavar="PNG", help="file to write, default FILE with .png")
    options = parser.parse_args()
    target = options.figure or os.path.splitext(options.run)[0] + ".png"
    try:
        run = Run(options.run)
        run.warn("plot_run.py")
        (figure if run.is_fault else small_figure)(run).savefig(target)
    except (OutputError, OSError) as error:
        sys.exit(f"plot_run.py: {error}")
    print(f"Figure: {target}")


if __name__ == "__main__":
    main()
