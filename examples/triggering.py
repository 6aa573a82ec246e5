#!/usr/bin/env python3
"""Split meshes and fields of two faults for examples/triggering.sh, and plot when the faults break, together and alone.

    triggering.py split NAME      NAME_mesh.h5 and NAME_fields.h5 to NAME_{both,first,second}_{mesh,fields}.h5
    triggering.py plot NAME       catalogues NAME_{both,first,second}.h5 to NAME.png
"""

import argparse
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need, one_line

need("h5py", "numpy", "matplotlib")
import h5py
import numpy as np
from slipstep.plots.panels import RUN_STYLES, plt, use_style
from slipstep.results.events import Events
from slipstep.times import YEAR

SHARE = 0.3  # of the largest mean slip of a fault: events of less are left out
NEAR = 1.0  # years within which an event follows another


def split(name):
    with h5py.File(f"{name}_mesh.h5") as mesh:
        sides = mesh["cells"][:, 1] == mesh["cells"][0, 1]
    for case, rows in (("both", np.full(len(sides), True)), ("first", sides), ("second", ~sides)):
        for kind in ("mesh", "fields"):
            with h5py.File(f"{name}_{kind}.h5") as source, h5py.File(f"{name}_{case}_{kind}.h5", "w") as target:
                for dataset in source:
                    target[dataset] = source[dataset][rows]
                    target[dataset].attrs.update(source[dataset].attrs)


def slips(events, y):
    """Years when the large events broke the fault at y first, and their mean slip on it."""
    own = events.mesh["y"] == y
    share = (events.mesh["length"] * events.mesh["width"])[own]
    share /= share.sum()
    maps = [(events.map_of("slip", k)[own], events.map_of("rupture_time", k)[own]) for k in range(len(events))]
    slip = np.array([(one * share).sum() for one, _ in maps])
    start = np.array([np.nanmin(broke, initial=np.inf) for _, broke in maps])
    large = (slip >= SHARE * slip.max()) & np.isfinite(start)
    return (events["onset"] + start)[large] / YEAR, slip[large]


def follow(times, others):
    """Which events begin within NEAR years after one of the others."""
    after = np.searchsorted(others, times, side="right") - 1
    return (after >= 0) & (times - others[np.maximum(after, 0)] < NEAR)


def by_chance(others, span):
    """The share of a time that is within NEAR years after one of the others."""
    return np.minimum(np.diff(np.append(others, span)), NEAR).sum() / span


def draw(axes, number, own, alone, other, span):
    """Events of one fault, those with the other fault and those alone; when the other breaks."""
    name, rest = (("first", "second"), ("second", "first"))[number]
    colour = RUN_STYLES[number]["color"]
    times, slip = own
    triggered = follow(times, other)
    share, chance = triggered.mean(), by_chance(other, span)
    axes.vlines(other, 0, 1, transform=axes.get_xaxis_transform(), color="#a9a9a9", linewidth=0.9, zorder=0,
                label=f"the {rest} fault breaks")
    axes.plot(*alone, linestyle="", marker="o", markerfacecolor="none", color="black", markersize=6, label="alone")
    axes.vlines(times, 0, slip, color=colour, linewidth=1.2)
    axes.plot(times[~triggered], slip[~triggered], linestyle="", marker="o", color=colour, markersize=6,
              label="together")
    axes.plot(times[triggered], slip[triggered], linestyle="", marker="*", color=colour, markeredgecolor="black",
              markersize=14, label="triggered")
    axes.set(ylabel="mean slip (m)", xlim=(0, 1.01 * span))
    axes.set_title(f"The {name} fault: {triggered.sum()} of {len(times)} events within {NEAR:g} year after one of the "
                   f"other ({chance:.0%} of the time)", fontsize=10, fontweight="normal")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    print(f"{name} fault: {len(times)} events ({len(alone[0])} alone), {share:.0%} of them within {NEAR:g} year after "
          f"one of the other, which is {chance:.0%} of the time")


def plot(name):
    together, *single = (Events(f"{name}_{case}.h5") for case in ("both", "first", "second"))
    use_style()
    canvas, axes = plt.subplots(2, 1, figsize=(11, 6.4), layout="constrained", sharex=True, sharey=True)
    pair = [slips(together, events.mesh["y"][0]) for events in single]
    span = max(events["end"].max() for events in (together, *single)) / YEAR
    for k, events in enumerate(single):
        draw(axes[k], k, pair[k], slips(events, events.mesh["y"][0]), pair[1 - k][0], span)
    axes[0].set_ylim(0, 1.1 * max(slip.max() for _, slip in pair))
    axes[1].set_xlabel("time (years)")
    canvas.suptitle("Two faults, together and each alone")
    canvas.savefig(f"{name}.png")
    print(f"Figure: {name}.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", choices=["split", "plot"])
    parser.add_argument("name", metavar="NAME")
    a = parser.parse_args()
    with one_line():
        {"split": split, "plot": plot}[a.work](a.name)


if __name__ == "__main__":
    main()
