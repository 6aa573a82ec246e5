#!/usr/bin/env python3
"""Make one listric thrust as rectangles and as triangles, with its friction, for examples/listric.sh, and plot the
results of both.

    listric.py make NAME --cell 1000     NAME_rectangles_mesh.h5, NAME_triangles_mesh.msh (by Gmsh), and
                                         NAME_{rectangles,triangles}_fields.h5
    listric.py plot NAME                 runs NAME_{rectangles,centre,cell}.h5 and catalogues NAME_..._events.h5 to
                                         NAME.png
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
from slipstep.plots.maps import Span, colour_bar
from slipstep.plots.panels import RUN_STYLES, plt, use_style
from slipstep.plots.snapshots import Layout
from slipstep.results.events import Events
from slipstep.results.fields import KINDS
from slipstep.results.files import write_fields
from slipstep.times import YEAR

SIZE, TOP, STRIKE = (20e3, 16e3), 0.0, 30.0  # along strike and down dip [m], upper edge [m], degrees
DIPS = 60.0, 15.0  # at the ground and at the lower edge [degrees]
LOCKED = 3e3, (3e3, 11e3)  # where friction weakens: so far from both ends, and between these distances down dip [m]
CHANGE = 3e3  # over which it changes [m]
WEAK, STRONG = 0.003, 0.022  # a, beside b = 0.015
# backslip in the middle [m/s], and by which share it is faster at the northern end, where events then begin
LOADING, TILT = 3e-9, 0.2
WORDS = {"rectangles": "rectangles", "centre": "triangles, stress at centroids",
         "cell": "triangles, averages over them"}
FIRST = 2  # events until the start is forgotten


def write_friction(path, centres):
    """friction_a and loading_rate of cells by their centres [n, 3]: distance along strike, and down dip by the depth on
    the arc."""
    along = np.cos(np.radians(STRIKE)) * centres[:, 0] + np.sin(np.radians(STRIKE)) * centres[:, 1]
    down = np.linspace(0, SIZE[1], 2001)
    down = np.interp(centres[:, 2], make_mesh.arc(SIZE, TOP, DIPS)(down)[1], down)
    outside = np.max([np.abs(along - SIZE[0] / 2) - (SIZE[0] / 2 - LOCKED[0]), LOCKED[1][0] - down,
                      down - LOCKED[1][1]], axis=0)
    write_fields(path, {"friction_a": (np.interp(outside, [0, CHANGE], [WEAK, STRONG]), "1"),
                        "loading_rate": (LOADING * (1 + TILT * (2 * along / SIZE[0] - 1)), "m/s")})


def make(name, cell):
    cells = [round(extent / cell) for extent in SIZE]
    rows = make_mesh.listric(cells, SIZE, TOP, 1.0, STRIKE, DIPS)
    make_mesh.write(f"{name}_rectangles_mesh.h5", rows, np.zeros(len(rows), int))
    write_friction(f"{name}_rectangles_fields.h5", rows[:, :3])
    corners = make_mesh.write_triangles(f"{name}_triangles_mesh.msh", cells, SIZE, TOP, STRIKE, DIPS)
    write_friction(f"{name}_triangles_fields.h5", corners.mean(axis=1))
    print(f"{len(rows)} rectangles, {len(corners)} triangles")


def large(events):
    """Events of at least half of the largest slip, which break the fault."""
    return np.flatnonzero(events["moment"] >= 0.5 * events["moment"].max())


def recurrence(events):
    """Mean interval [years] of the events that break the fault, from the third on, and how many intervals that are."""
    onset = events["onset"][large(events)][FIRST:] / YEAR
    return (onset[-1] - onset[0]) / (len(onset) - 1) if len(onset) > 1 else np.nan, max(len(onset) - 1, 0)


def plot(name):
    runs = {kind: (Run(f"{name}_{kind}.h5"), Events(f"{name}_{kind}_events.h5")) for kind in WORDS}
    reference = recurrence(runs["rectangles"][1])[0]
    for kind, (run, events) in runs.items():
        interval, count = recurrence(events)
        own = large(events)[FIRST:]
        print(f"{WORDS[kind]}: {len(run.mesh['x'])} cells, {len(large(events))} events, every {interval:.2f} years (of "
              f"{count}), {100 * (interval / reference - 1):+.2f} %, M {events['magnitude'][own].mean():.3f}, stress "
              f"drop {events['stress_drop'][own].mean() / 1e6:.2f} MPa, set-up {run.result['wall_time_setup']:.0f} s, "
              f"run {run.result['wall_time_solve']:.0f} s")
    draw(name, runs)
    print(f"Figure: {name}.png")


def draw(name, runs):
    """Slip of the last event that broke the fault, on rectangles and on triangles; mean slip of all against time."""
    use_style()
    canvas = plt.figure(figsize=(12, 9), layout="constrained")
    above, below = canvas.subfigures(2, 1, height_ratios=(1.6, 1))
    maps = {kind: runs[kind][1].map_of("slip", large(runs[kind][1])[-1]) for kind in ("rectangles", "cell")}
    norm = Span().see(np.concatenate(list(maps.values()))).norm(KINDS["slip"])
    for part, (kind, slip) in zip(above.subfigures(1, 2), maps.items()):
        events = runs[kind][1]
        title = f"{WORDS[kind].split(',')[0].capitalize()}: M {events['magnitude'][large(events)[-1]]:.2f}"
        layout = Layout(events, 1, 1)
        plt.close(layout.canvas)
        block, = layout.fill(part)
        artists = layout.draw(block, slip, norm, KINDS["slip"].colours, title, True)
        colour_bar(part, artists[0], norm, "slip (m)", ax=block, location="bottom", shrink=0.7, aspect=30, pad=0.02)
    axes = below.subplots()
    for style, (kind, (run, events)) in zip(RUN_STYLES, runs.items()):
        axes.plot(run.series["time"] / YEAR, run.series["mean_slip"], color=style["color"],
                  label=f"{WORDS[kind]}: every {recurrence(events)[0]:.2f} years")
    axes.set(title="Mean slip", ylabel="slip (m)", xlabel="time (years)", xlim=(0, run.series["time"][-1] / YEAR))
    axes.legend(loc="upper left")
    canvas.savefig(f"{name}.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", choices=["make", "plot"])
    parser.add_argument("name", metavar="NAME")
    parser.add_argument("--cell", type=float, default=1000.0, metavar="M",
                        help="approximate side of rectangles and triangles [m]")
    a = parser.parse_args()
    if not 0 < a.cell <= SIZE[1] / 4:
        parser.error(f"--cell is {a.cell:g}, expected a number > 0 up to {SIZE[1] / 4:g}")
    with one_line():
        make(a.name, a.cell) if a.work == "make" else plot(a.name)


if __name__ == "__main__":
    main()
