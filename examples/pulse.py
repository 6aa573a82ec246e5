#!/usr/bin/env python3
"""Make fields and stresses of examples/pulse.sh, and draw how much earlier its event comes by a pulse that passes.

    pulse.py fields NAME                                    NAME_fields.h5
    pulse.py make NAME --before 1h 2d --amplitude 6e5 8e5   NAME_CASE_stress.h5 for -fault_stress_history, a case for
                                                            each time before the event of NAME_without_events.h5 and
                                                            each largest stress [Pa]; prints a time a minute after that
                                                            event [s], and the cases
    pulse.py plot NAME                                      their events to a table and NAME.png

The pulse runs along strike: each block of columns has a course of its own, which is a Gaussian that comes later from
block to block. While slip accelerates by itself, far from a steady state, a stress dtau(t) brings it forward by the
integral of exp(dtau/(a sigma)) - 1, whenever it comes (after Dieterich 1994): the lines in the picture. Here it is a
sixth more, because contacts heal while slip accelerates slowly. A pulse that comes later starts the event at once.
"""

import argparse
import glob
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need, one_line

need("h5py", "numpy", "matplotlib")
import h5py
import numpy as np
from slipstep import Run
from slipstep.plots.panels import RUN_STYLES, plt, use_style
from slipstep.results.events import Events
from slipstep.results.files import write_fields
from slipstep.times import seconds

NX, NZ, CELL = 56, 32, 125.0
BLOCK = 4  # columns with one course
SPEED = 3500.0  # of the pulse [m/s]
WIDTH = 3.0  # its standard deviation [s]
NODES = np.linspace(-4, 4, 25)  # of its course, over the width
STRENGTH = 0.01 * 10e6  # a sigma [Pa]


def fields(name):
    """The middle weakens, and begins above its steady state: it accelerates. What is around it creeps."""
    x, z = np.meshgrid((np.arange(NX) - NX / 2 + 0.5) * CELL, (np.arange(NZ) - NZ / 2 + 0.5) * CELL)
    weak = (abs(x) < 3000) & (abs(z) < 1500)
    write_fields(f"{name}_fields.h5", {"friction_b": (np.where(weak, 0.018, 0.006), "1"),
                                       "initial_state": (np.where(weak, 3, 1) * 0.0025 / 1e-9, "s")})


def event_of(name, case):
    return Events(f"{name}_{case}_events.h5")["onset"][0]


def make(name, before, amplitudes):
    event, cases = event_of(name, "without"), []
    for time in before:
        for amplitude in amplitudes:
            case = f"{time:g}_{amplitude:g}"
            with h5py.File(f"{name}_{case}_stress.h5", "w") as file:
                file.attrs["before"], file.attrs["amplitude"] = time, amplitude
                for block in range(NX // BLOCK):
                    columns = np.arange(NX) // BLOCK == block
                    arrival = event - time + (block - NX // BLOCK / 2) * BLOCK * CELL / SPEED
                    file[f"block{block}/time"] = arrival + WIDTH * NODES
                    file[f"block{block}/course"] = np.exp(-NODES ** 2 / 2) - np.exp(-NODES[0] ** 2 / 2)
                    file[f"block{block}/shear"] = amplitude * np.tile(columns, (NZ, 1))
            cases.append(case)
    print(event + 60, *cases)


def integral(amplitude):
    """Of exp(dtau/(a sigma)) - 1 over the pulse [s]."""
    t = np.linspace(NODES[0], NODES[-1], 2001)
    course = np.interp(t, NODES, np.exp(-NODES ** 2 / 2) - np.exp(-NODES[0] ** 2 / 2))
    return WIDTH * np.trapz(np.expm1(amplitude / STRENGTH * course), t)


def plot(name):
    event, rows = event_of(name, "without"), []
    for path in glob.glob(f"{glob.escape(name)}_*_stress.h5"):
        with h5py.File(path) as file:
            case = path[len(name) + 1:-len("_stress.h5")]
            rows.append((file.attrs["amplitude"], file.attrs["before"], event - event_of(name, case), case))
    rows.sort()
    print("largest stress     pulse before the event    event earlier by    by the integral")
    for amplitude, before, earlier, _ in rows:
        print(f"{amplitude / 1e6:10.2f} MPa {before / 3600:20.2f} h {earlier / 3600:18.3f} h "
              f"{min(before, integral(amplitude)) / 3600:17.3f} h")
    draw(name, event, rows)
    print(f"Figure: {name}.png")


def draw(name, event, rows):
    """How much earlier the event comes; and largest slip rates until it, without the pulse and with the largest."""
    use_style()
    canvas, axes = plt.subplots(1, 2, figsize=(11, 4.6), layout="constrained")
    before = np.array([row[1] for row in rows]) / 3600
    reach = np.geomspace(before.min() / 1.5, before.max() * 1.5)
    axes[0].plot(reach, reach, color="black", linewidth=0.9, linestyle=(0, (4, 2)), label="at once")
    for k, amplitude in enumerate(sorted({row[0] for row in rows})):
        own = np.array([row[1:3] for row in rows if row[0] == amplitude]).T / 3600
        colour = RUN_STYLES[k % len(RUN_STYLES)]["color"]
        axes[0].plot(reach, np.minimum(reach, integral(amplitude) / 3600), color=colour, linewidth=0.9)
        axes[0].plot(*own, linestyle="", marker="o", color=colour, label=f"{amplitude / 1e6:g} MPa")
    axes[0].set(xscale="log", yscale="log", xlabel="pulse before the event (h)", ylabel="event earlier by (h)",
                title="Lines: self-acceleration (Dieterich 1994)")
    axes[0].legend()
    shown = [("without", "without", "black")]
    strongest = [row for row in rows if row[0] == rows[-1][0]]
    for style, row in zip(RUN_STYLES, (strongest[-1], strongest[len(strongest) // 2])):
        shown.append((row[3], f"{row[1] / 3600:.3g} h before it", style["color"]))
    for case, label, colour in shown:
        run = Run(f"{name}_{case}.h5")
        time, rate = (event - run.series["time"]) / 3600, run.series["max_slip_rate"]
        until = time >= (event - event_of(name, case)) / 3600
        axes[1].plot(time[until], rate[until], color=colour, label=label)
    axes[1].set(xscale="log", yscale="log", xlim=(1.5 * before.max(), 0.1),
                xlabel="before the event without a pulse (h)", ylabel="m/s",
                title=f"Largest slip rate, pulse of {rows[-1][0] / 1e6:g} MPa")
    axes[1].legend()
    canvas.savefig(f"{name}.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", choices=["fields", "make", "plot"])
    parser.add_argument("name", metavar="NAME")
    parser.add_argument("--before", nargs="+", type=seconds, metavar="TIME",
                        help="of the pulse in the middle before the event")
    parser.add_argument("--amplitude", nargs="+", type=float, metavar="PA", help="largest stress [Pa]")
    a = parser.parse_args()
    with one_line():
        if a.work == "fields":
            fields(a.name)
        elif a.work == "make":
            make(a.name, a.before, a.amplitude)
        else:
            plot(a.name)


if __name__ == "__main__":
    main()
