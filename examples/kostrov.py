#!/usr/bin/env python3
"""Make the fields of cracks whose front is given for examples/kostrov.sh, and compare runs of them with Kostrov's exact
slip.

    kostrov.py make NAME --shape line --cells 100 --speed 0.7     NAME_fields.h5; prints options of the run
    kostrov.py plot NAME --line 50 100 --circle 25 50             NAME_line_50.h5, ... to a table and NAME.png
"""

import argparse
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need, one_line

need("h5py", "numpy", "matplotlib")
import numpy as np
from slipstep import Run
from slipstep.plots.maps import Span, colour_bar, planes_of
from slipstep.plots.panels import RUN_STYLES, plt, save, use_style
from slipstep.results.fields import KINDS
from slipstep.results.files import write_fields

LENGTH = 20e3  # of the fault, in each direction [m]
REACH = 9e3  # of the front at the end [m]
MODULUS, DENSITY, DROP = 32.03812e9, 2670.0, 5e6  # [Pa], [kg/m^3], stress drop [Pa], as in kostrov.opts
SHEAR = np.sqrt(MODULUS / DENSITY)  # speed of shear waves [m/s]
# Of a circle and Poisson's ratio 1/4, by the front's speed over that of shear waves: slip rate in the middle times
# density and speed of shear waves over the stress drop (Kostrov 1966; Dahlen 1974, Bull. Seismol. Soc. Am. 64)
CIRCLE = {0.3: 0.317429, 0.5: 0.507099, 0.7: 0.674635, 0.8: 0.750178, 0.9: 0.820515, 0.95: 0.853818}
# A cell weakens while the front goes from so many cells before its centre on. At once, it would send waves of the size
# of cells, which stop others for moments; and it breaks when its strength meets the stress before the front, late in
# this time.
BEFORE, LASTS = 1.5, 2.0
SHOWN = 5  # times
NEAR = 0.9  # of the front's distance: beyond, next to the front, slip is steeper than cells can follow


def centres(n):
    """Of cells, from the middle [m]."""
    return (np.arange(n) + 0.5) * LENGTH / n - LENGTH / 2


def distances(shape, n):
    """Of cells from the middle [m], [n, 1] of a line."""
    return np.abs(centres(n))[:, None] if shape == "line" else np.hypot(centres(n)[:, None], centres(n))


def rate(shape, speed):
    """Slip rate in the middle [m/s]; of an antiplane line by the complete elliptic integral of the second kind (Kostrov
    1964)."""
    if shape == "circle":
        return CIRCLE[speed] * DROP / (DENSITY * SHEAR)
    angle = (np.arange(1000) + 0.5) * np.pi / 2000  # the midpoint rule is exact to rounding
    return 2 * DROP * speed * SHEAR / (MODULUS * np.pi / 2 * np.mean(np.sqrt(1 - (1 - speed**2) * np.sin(angle) ** 2)))


def exact(shape, speed, r, t):
    """Slip at the distance r at the time t [m]."""
    return rate(shape, speed) * np.sqrt(np.maximum(t**2 - (r / (speed * SHEAR)) ** 2, 0))


def make(name, shape, n, speed):
    cell = LENGTH / n / (speed * SHEAR)  # time of the front from cell to cell [s]
    weakens = np.maximum(distances(shape, n) / (speed * SHEAR) - BEFORE * cell, 0)
    write_fields(f"{name}_fields.h5", {"weakening_time": (weakens, "s")})
    size = {"line": "-fault_nx 1 -fault_length_x 1e7",
            "circle": f"-fault_nx {n} -fault_length_x {LENGTH} -fault_slip_components 2"}[shape]
    end = REACH / (speed * SHEAR)
    return (f"{size} -fault_nz {n} -fault_weakening_duration {LASTS * cell} -ts_max_time {end} "
            f"-fault_output_time_interval {end / SHOWN}")


class Crack:
    """A run, and how far its slip is from the exact one, over that in the middle."""

    def __init__(self, name, shape, n, speed):
        self.shape, self.n, self.speed = shape, n, speed
        self.run = Run(f"{name}_{shape}_{n}.h5")
        self.times, self.slip = self.run.field("slip")
        self.r = distances(shape, n)
        off = (self.slip[-1] - exact(shape, speed, self.r, self.times[-1])) / exact(shape, speed, 0, self.times[-1])
        front = speed * SHEAR * self.times[-1]
        self.rms = np.sqrt((off[self.r < front] ** 2).mean())
        self.middle = off[self.r < self.r.min() + 1].mean()
        self.largest = np.abs(off[self.r < NEAR * front]).max()


def order(coarse, fine):
    return np.log(coarse.rms / fine.rms) / np.log(fine.n / coarse.n)


def plot(name, numbers, speed):
    cracks = {shape: [Crack(name, shape, n, speed) for n in sorted(numbers[shape])] for shape in numbers}
    print(f"error of slip when the front is {REACH / 1e3:g} km away, over that in the middle (order: of the root mean "
          "square, in the size of cells)")
    print("         cells across     root mean square       order    middle      up to 90 % of the front, at most")
    for shape, runs in cracks.items():
        for k, one in enumerate(runs):
            said = f"{order(runs[k - 1], one):.2f}" if k else ""
            print(f"{shape:8} {one.n:12d}     {100 * one.rms:14.2f} %   {said:>10}  {100 * one.middle:+7.2f} %   "
                  f"{100 * one.largest:7.2f} %")
    draw(name, cracks, speed)
    print(f"Figure: {name}.png")


def draw(name, cracks, speed):
    use_style()
    canvas, axes = plt.subplots(2, 2, figsize=(11, 8), layout="constrained")
    canvas.suptitle(f"A crack whose front runs at {speed:g} of the speed of shear waves: slip as computed beside "
                    "Kostrov's exact solution")
    within = np.sin(np.linspace(-np.pi / 2, np.pi / 2, 401))  # of the front
    line, circle = (cracks[shape][-1] for shape in ("line", "circle"))

    one = axes[0, 0]
    for t, slip in zip(line.times[1:], line.slip[1:]):
        broken = line.r[:, 0] < speed * SHEAR * t
        x = speed * SHEAR * t * within
        one.plot(x / 1e3, exact("line", speed, x, t), color="black", linewidth=1, label="exact" if t == line.times[-1]
                 else None)
        every = max(1, line.n // 80)
        one.plot(centres(line.n)[broken][::every] / 1e3, slip[broken, 0][::every], linestyle="", marker="o",
                 markersize=3.5, markerfacecolor="none", color=RUN_STYLES[0]["color"],
                 label=f"{line.n} cells" if t == line.times[-1] else None)
        one.annotate(f"{t:.1f} s", (0, exact("line", speed, 0, t)), xytext=(0, 3), textcoords="offset points",
                     ha="center", fontsize=9)
    one.set(title="A line, at several times", xlabel="from the middle (km)", ylabel="slip (m)",
            ylim=(0, 1.2 * line.slip[-1].max()))
    one.legend(loc="upper right")

    plane, = planes_of(circle.run)
    scale = Span().see(circle.slip[-1]).norm(KINDS["slip"])
    artist = plane.draw(axes[0, 1], circle.slip[-1].ravel(), scale, KINDS["slip"].colours)
    plane.frame(axes[0, 1])
    angle, front = np.linspace(0, 2 * np.pi, 400), speed * SHEAR * circle.times[-1]
    axes[0, 1].plot((LENGTH / 2 + front * np.cos(angle)) / 1e3, (LENGTH / 2 + front * np.sin(angle)) / 1e3,
                    color="black", linestyle="--", linewidth=1)
    axes[0, 1].set(title=f"A circle after {circle.times[-1]:.1f} s; dashed: the front", xlabel="along strike (km)")
    colour_bar(canvas, artist, scale, "slip (m)", ax=axes[0, 1], shrink=0.8)

    half, far = circle.n // 2, centres(circle.n)[circle.n // 2:]
    for t, slip in zip(circle.times[1:], circle.slip[1:]):
        last, x = t == circle.times[-1], speed * SHEAR * t * within[200:]
        axes[1, 0].plot(x / 1e3, exact("circle", speed, x, t), color="black", linewidth=1,
                        label="exact" if last else None)
        for k, (way, values) in enumerate((("along strike", slip[half, half:]), ("down dip", slip[half:, half]))):
            broken = far < speed * SHEAR * t
            axes[1, 0].plot(far[broken] / 1e3, values[broken], linestyle="", marker=RUN_STYLES[k]["marker"],
                            markersize=3.5, markerfacecolor="none", color=RUN_STYLES[k]["color"],
                            label=way if last else None)
    axes[1, 0].set(title=f"The circle of {circle.n} cells across, at the same times", xlabel="from the middle (km)",
                   ylabel="slip (m)", xlim=(0, None), ylim=(0, None))
    axes[1, 0].legend(loc="upper right")

    one = axes[1, 1]
    for k, (shape, runs) in enumerate(cracks.items()):
        n = np.array([run.n for run in runs])
        one.loglog(n, [100 * run.rms for run in runs], color=RUN_STYLES[k]["color"], marker=RUN_STYLES[k]["marker"],
                   label=f"{shape}, root mean square")
        one.loglog(n, [100 * abs(run.middle) for run in runs], color=RUN_STYLES[k]["color"],
                   marker=RUN_STYLES[k]["marker"], linestyle=":", markerfacecolor="none",
                   label=f"{shape}, in the middle")
    every = np.array(sorted({run.n for runs in cracks.values() for run in runs}))
    one.loglog(every, 100 * cracks["line"][0].rms * 0.5 * cracks["line"][0].n / every, color="#9a9a9a", linestyle="--",
               label="first order")
    one.set_xticks(every, [str(n) for n in every])
    one.minorticks_off()
    one.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    one.set(title="Error over the slip in the middle", xlabel="cells across the fault", ylabel="%")
    one.legend(loc="best", fontsize=9)
    save(canvas, f"{name}.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", choices=["make", "plot"])
    parser.add_argument("name", metavar="NAME")
    parser.add_argument("--shape", choices=["line", "circle"], default="line", help="of the crack")
    parser.add_argument("--cells", type=int, default=100, metavar="N", help="across the fault")
    parser.add_argument("--line", type=int, nargs="+", default=[50, 100, 200, 400], metavar="N",
                        help="cells of the runs of a line")
    parser.add_argument("--circle", type=int, nargs="+", default=[25, 50, 100], metavar="N",
                        help="cells across those of a circle")
    parser.add_argument("--speed", type=float, default=0.7, choices=list(CIRCLE), metavar="V",
                        help="of the front, over that of shear waves")
    a = parser.parse_args()
    if a.cells < 10:
        parser.error(f"--cells is {a.cells}, expected at least 10")
    with one_line():
        if a.work == "make":
            print(make(a.name, a.shape, a.cells, a.speed))
        else:
            plot(a.name, {"line": a.line, "circle": a.circle}, a.speed)


if __name__ == "__main__":
    main()
