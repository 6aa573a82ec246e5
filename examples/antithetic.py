#!/usr/bin/env python3
"""Make the mesh and the fields of a normal fault and its antithetic for examples/antithetic.sh, and plot what their
events do to each other.

    antithetic.py make NAME --cell 1000     NAME_mesh.h5 and NAME_fields.h5
    antithetic.py plot NAME                 runs NAME_{yes,no}.h5 and catalogues NAME_{yes,no}_events.h5 to NAME.png
"""

import argparse
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need, one_line

need("h5py", "numpy", "matplotlib")
import make_mesh
import numpy as np
from slipstep import Run
from slipstep.geometry.cells import mesh_cells
from slipstep.geometry.surface import Elastic, slip_of_event
from slipstep.plots.maps import Span, colour_bar, planes_of
from slipstep.plots.panels import RUN_STYLES, plt, use_style
from slipstep.results.events import Events
from slipstep.results.fields import KINDS
from slipstep.results.files import write_fields
from slipstep.times import YEAR

DIP, LENGTH = 60.0, 30e3  # of both [degrees, m]; the main fault has the strike 0, the antithetic 180
WIDTH = 16e3, 8e3  # down dip [m]: the antithetic ends at the main fault, half as far down
APART = 2 * WIDTH[1] * np.cos(np.radians(DIP))  # of both at the ground [m]
LOADING = 1e-9, 4e-10  # backslip [m/s]
LOCKED = 4e3, 12e3  # where friction weakens: so far from both ends, and so far down the main fault [m]
CHANGE = 3e3  # over which it changes [m]
WEAK, STRONG = 0.006, 0.022  # a, beside b = 0.015
MAIN, ANTITHETIC = NAMES = 1, 2
WORDS = {MAIN: "main fault", ANTITHETIC: "antithetic"}
SHARE = 0.3  # of the largest mean slip of a fault: an event with more is one of it
FRICTION = 0.6  # that of both, for Coulomb stress
WHERE = 180.0, -90.0  # strike and rake of the antithetic [degrees]


def rows_of(strike, corner, width, cell):
    """Cells [n, 7] of a plane, and their distances along its strike and down its dip; corner: where its upper edge
    begins."""
    turn, dip = np.radians(strike), np.radians(DIP)
    along = np.array([np.cos(turn), np.sin(turn), 0])
    down = np.array([-np.sin(turn) * np.cos(dip), np.cos(turn) * np.cos(dip), np.sin(dip)])
    nx, nz = round(LENGTH / cell), round(width / cell)
    s, d = (part.ravel() for part in np.meshgrid((np.arange(nx) + 0.5) * LENGTH / nx,
                                                 (np.arange(nz) + 0.5) * width / nz))
    centres = corner + s[:, None] * along + d[:, None] * down
    return np.column_stack([centres, np.tile([LENGTH / nx, width / nz, strike, DIP], (nx * nz, 1))]), s, d


def make(name, cell):
    planes = [rows_of(0.0, np.zeros(3), WIDTH[0], cell), rows_of(180.0, np.array([LENGTH, APART, 0.0]), WIDTH[1], cell)]
    cells, s, d = (np.concatenate(part) for part in zip(*planes))
    fault = np.repeat(NAMES, [len(plane[0]) for plane in planes])
    make_mesh.write(f"{name}_mesh.h5", cells, fault)
    outside = np.maximum(np.abs(s - LENGTH / 2) - (LENGTH / 2 - LOCKED[0]),
                         np.where(fault == MAIN, d - LOCKED[1], -np.inf))
    write_fields(f"{name}_fields.h5", {"friction_a": (np.interp(outside, [0, CHANGE], [WEAK, STRONG]), "1"),
                                       "loading_rate": (np.where(fault == MAIN, *LOADING), "m/s")})


def slips(events):
    """Mean slip of each fault in each event [n, 2]."""
    area, fault = events.mesh["length"] * events.mesh["width"], events.mesh["fault"]
    maps = np.array([events.map_of("slip", k) * events["direction"][k] for k in range(len(events))])
    return np.stack([np.average(maps[:, fault == name], axis=1, weights=area[fault == name]) for name in NAMES], axis=1)


def broke(events):
    """Which events are of each fault [n, 2]."""
    slip = slips(events)
    return slip >= SHARE * slip.max(axis=0)


def since_main(events):
    """Years since the main fault's last event at each event of the antithetic, 0 where it is the same one, and the
    median interval of the main fault; those before the main fault's first event are left out."""
    own, onset = broke(events), events["onset"] / YEAR
    main = onset[own[:, 0]]
    times = [time - main[main <= time].max() for time in onset[own[:, 1]] if (main <= time).any()]
    return np.array(times), np.median(np.diff(main)) if len(main) > 1 else np.nan


def coulomb(events, number):
    """What the main fault's slip in an event does to the antithetic's cells, by the library: change of Coulomb stress,
    of the shear stress along its rake, and of the normal stress [Pa], NaN on the main fault."""
    source = slip_of_event(events, number)
    main, cells = events.mesh["fault"] == MAIN, mesh_cells(events.mesh)
    source.slip = np.where(main, source.slip, 0.0)
    found = np.full((3, len(main)), np.nan)
    found[:, ~main] = Elastic(source).coulomb(cells[~main, :3], (WHERE[0], DIP, WHERE[1]), FRICTION)
    return found


def plot(name):
    runs = {coupling: (Run(f"{name}_{coupling}.h5"), Events(f"{name}_{coupling}_events.h5"))
            for coupling in ("yes", "no")}
    words = {"yes": "normal stress follows slip", "no": "shear stress alone"}
    for coupling, (_, events) in runs.items():
        own, (after, interval) = broke(events), since_main(events)
        print(f"{words[coupling]}: {own[:, 0].sum()} events of the main fault, every {interval:.0f} years, "
              f"{own[:, 1].sum()} of the antithetic, {own.all(axis=1).sum()} of them of both; years after the main "
              f"fault: {' '.join(f'{time:.3g}' for time in after) or 'none'}")
    events = runs["yes"][1]
    own = broke(events)
    largest = int(np.argmax(np.where(own[:, 0], events["moment"], 0)))
    stress, shear, normal = coulomb(events, largest)
    area = (events.mesh["length"] * events.mesh["width"])[events.mesh["fault"] == ANTITHETIC]
    shear, normal, mean = (np.average(part[events.mesh["fault"] == ANTITHETIC], weights=area) / 1e6
                           for part in (shear, normal, stress))
    print(f"event {largest + 1}, M {events['magnitude'][largest]:.2f}: the main fault's slip changes the mean shear "
          f"stress of the antithetic by {shear:.2f} MPa, "
          f"its pressure by {normal:.2f} MPa, Coulomb stress by {mean:.2f} MPa")
    draw(name, runs, words, largest, stress)
    print(f"Figure: {name}.png")


def draw(name, runs, words, largest, stress):
    """Slip of the largest event on the main fault, what it does to the antithetic, and mean slip of both faults against
    time."""
    use_style()
    events = runs["yes"][1]
    canvas = plt.figure(figsize=(12, 11), layout="constrained")
    grid = canvas.add_gridspec(3, 2, height_ratios=(1.2, 1, 1))
    slip = events.map_of("slip", largest)
    maps = ((slip, KINDS["slip"], "slip (m)",
             f"Event {largest + 1}, M {events['magnitude'][largest]:.2f}: slip of the main fault"),
            (stress / 1e6, KINDS["stress_drop"], "change of Coulomb stress (MPa)",
             "Its Coulomb stress on the antithetic"))
    for column, (plane, (values, kind, label, title)) in enumerate(zip(planes_of(events), maps)):
        axes = canvas.add_subplot(grid[0, column])
        values = plane.values(values)
        norm = Span().see(values).norm(kind)
        artist = plane.draw(axes, values, norm, kind.colours)
        plane.frame(axes)
        axes.set(xlabel=plane.along_label, title=title)
        colour_bar(canvas, artist, norm, label, ax=axes, location="bottom", shrink=0.7, aspect=30, pad=0.02)
    top = None
    for row, (coupling, (run, found)) in enumerate(runs.items()):
        top = axes = canvas.add_subplot(grid[1 + row, :], sharex=top, sharey=top)
        times, maps = run.field("slip")
        fault, area = run.mesh["fault"], run.mesh["length"] * run.mesh["width"]
        own = broke(found)
        for k, label in enumerate(NAMES):
            mean = np.average(maps[:, fault == label], axis=1, weights=area[fault == label])
            axes.plot(times / YEAR, mean, color=RUN_STYLES[k]["color"],
                      label=f"{WORDS[label]}, {own[:, k].sum()} events")
            onset = found["onset"][own[:, k]]
            axes.plot(onset / YEAR, np.interp(onset, times, mean), linestyle="", marker=RUN_STYLES[k]["marker"],
                      color=RUN_STYLES[k]["color"], markersize=5)
        axes.set(title=f"Mean slip: {words[coupling]}", ylabel="slip (m)", xlim=(0, times[-1] / YEAR))
        axes.legend(loc="upper left")
    axes.set_xlabel("time (years)")
    canvas.savefig(f"{name}.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", choices=["make", "plot"])
    parser.add_argument("name", metavar="NAME")
    parser.add_argument("--cell", type=float, default=1000.0, metavar="M", help="approximate side of the cells [m]")
    a = parser.parse_args()
    if not 0 < a.cell <= WIDTH[1]:
        parser.error(f"--cell is {a.cell:g}, expected a number > 0 up to {WIDTH[1]:g}")
    with one_line():
        make(a.name, a.cell) if a.work == "make" else plot(a.name)


if __name__ == "__main__":
    main()
