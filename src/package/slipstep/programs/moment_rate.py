"""The moment-rate function of an event: a table as CSV, and a picture.

    slipstep moment-rate RUN.h5 --catalogue EVENTS.h5 [--event largest] [--csv OUT.csv] [--figure OUT.png]
    slipstep moment-rate RUN.h5 --window 96.4y 96.4y+30s --usgs OUT.mr [--step 0.1]   source time functions of the USGS

The run has it at the start and every accepted step (/series/moment_rate, of every fault); the event, or the window,
says from when to when. The moment is that of the slip between (/series/moment), which trapezoids of the rates miss
where a step raises them many times over.
"""

import argparse
import os

import numpy as np

from ..plots.panels import RUN_STYLES, plt, use_style
from ..results.catalogue import Catalogue
from ..results.files import replacing, write_csv
from ..results.moment import magnitude, moment_rate
from ..results.run import Run
from ..times import seconds, written


def write_usgs(file, time, moment, step):
    """As moment_rate.mr of the USGS: step, titles, and rows of time and rate, whose sum is the moment."""
    grid = step * np.arange(int(np.ceil(time[-1] / step)) + 1)
    edges = np.interp(np.append(grid - step / 2, grid[-1] + step / 2), time, moment.sum(axis=1))
    file.write(f"dt: {step:g}\nTime[s]     Moment_Rate [Nm]\n")
    file.writelines(f"{at:.10g}\t\t{rate:.10e}\n" for at, rate in zip(grid, np.diff(edges) / step))


def figure(time, rate, names, title):
    """names: of the faults of the columns."""
    use_style()
    canvas, axes = plt.subplots(figsize=(8, 4.2), layout="constrained")
    total = rate.sum(axis=1)
    axes.fill_between(time, 0, total, color=RUN_STYLES[0]["color"], alpha=0.25, linewidth=0)
    axes.plot(time, total, color=RUN_STYLES[0]["color"], label="all faults" if rate.shape[1] > 1 else "")
    for k in range(rate.shape[1] if 1 < rate.shape[1] <= 6 else 0):
        axes.plot(time, rate[:, k], color=f"C{k + 1}", linewidth=1.0, label=names[k])
    axes.set(title=title, xlabel="time since the onset (s)", ylabel="moment rate (N m/s)", xlim=(0, time[-1]))
    if total.min() >= 0:
        axes.set_ylim(bottom=0)
    if rate.shape[1] > 1:
        axes.legend()
    return canvas


def window(options):
    """Begin and end [s], and a title."""
    if options.window:
        return (*options.window, f"From {written(options.window[0])} to {written(options.window[1])}")
    catalogue = Catalogue(options.catalogue)
    number = catalogue.number_of(options.event)
    onset, end = (float(catalogue.event[name][number]) for name in ("onset", "end"))
    return onset, end, f"Event {number + 1} at {written(onset)}: M {catalogue.event['magnitude'][number]:.2f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("run", metavar="RUN", help="output file of the run")
    parser.add_argument("--catalogue", metavar="EVENTS", help="its catalogue of events")
    parser.add_argument("--event", default="largest", metavar="N",
                        help="the event: its number from 1 on, or largest (default)")
    parser.add_argument("--window", nargs=2, type=seconds, metavar=("BEGIN", "END"),
                        help="the interval to use if there is no catalogue: seconds, or numbers with s, min, h, d, y")
    parser.add_argument("--csv", metavar="OUT", help="table to write, default RUN_moment_rate.csv")
    parser.add_argument("--figure", metavar="OUT", help="picture to write, default RUN_moment_rate.png")
    parser.add_argument("--usgs", metavar="OUT.mr", help="file to write in the form of the USGS as well")
    parser.add_argument("--step", type=float, default=0.1, metavar="S", help="of --usgs (0.1)")
    options = parser.parse_args()
    if not options.step > 0:
        parser.error(f"--step is {options.step:g}, expected a number > 0")
    if bool(options.catalogue) == bool(options.window):
        parser.error("expected either --catalogue or --window")
    if options.event != "largest" and not options.event.isdigit():
        parser.error(f"--event is {options.event}, expected a number from 1 on, or largest")
    stem = os.path.splitext(options.run)[0] + "_moment_rate"
    table, picture = options.csv or stem + ".csv", options.figure or stem + ".png"
    run = Run(options.run)
    run.warn()
    run.require_fault("a moment rate")
    begin, end, title = window(options)
    time, rate, moment = moment_rate(run, begin, end)
    faults = run.faults if len(run.faults) == rate.shape[1] else np.arange(rate.shape[1])
    of_faults = [f"moment_rate {label} [N m/s]" for label in faults] if len(faults) > 1 else []
    write_csv(table, [["time [s]", "moment_rate [N m/s]", *of_faults, "moment [N m]"],
                      *([at, sum(row), *(row if of_faults else []), so_far]
                        for at, row, so_far in zip(time.tolist(), rate.tolist(), moment.sum(axis=1).tolist()))])
    if options.usgs:
        with replacing(options.usgs, options.run) as part, open(part, "w", encoding="utf-8") as file:
            write_usgs(file, time, moment, options.step)
    figure(time, rate, [run.fault_name(label) for label in faults], title).savefig(picture)
    total = float(moment[-1].sum())
    if options.usgs:
        print(f"Moment rate: {options.usgs}")
    print(f"Moment: {total:.4g} N m, M {magnitude(total):.2f}, in {end - begin:.4g} s and {len(time) - 2} steps\n"
          f"Table: {table}\nFigure: {picture}")
