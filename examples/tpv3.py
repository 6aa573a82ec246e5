#!/usr/bin/env python3
"""Make the fields of TPV3 for examples/tpv3.sh, and compare a run of it with the published boundary integral.

    tpv3.py make NAME --cell 300     NAME_fields.h5; prints the numbers of cells along strike and down dip
    tpv3.py plot NAME                NAME.h5 and NAME_events.h5 to a table and NAME.png
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
from slipstep.plots.panels import RUN_STYLES, plt, use_style
from slipstep.results.events import Events
from slipstep.results.fields import KINDS
from slipstep.results.files import write_fields

LENGTH, WIDTH = 30e3, 15e3  # [m]
SQUARE = 3e3  # of nucleation, in the middle [m]
STRESS = 70e6, 81.6e6  # beyond it and within [Pa]
# When cells of 100 m are first above 1 mm/s [s], by distance from the middle along strike and down dip [km]: the
# boundary integral of Day, Dalguer, Lapusta & Liu (2005), J. Geophys. Res. 110, as github.com/elygeo/coseis has it; the
# edge of the cell that is nearer to the middle is there
PUBLISHED = {"along strike": {2: 0.654, 3: 1.087, 4.5: 1.751, 6: 2.406, 7.5: 3.002, 9: 3.560},
             "down dip": {2: 0.770, 3: 1.338, 4.5: 2.184, 6: 2.916}}
CENTRE = 50.0  # of these cells beyond it [m]
SHOWN = 3.0, 5.0  # slip rates [s]
CONTOURS = np.arange(0.5, 8, 0.5)  # times of rupture [s]


def shape_of(cell):
    return round(WIDTH / cell), round(LENGTH / cell)


def centres(length, n):
    """Of cells, from the middle [m]."""
    return (np.arange(n) + 0.5) * length / n - length / 2


def make(name, cell):
    nz, nx = shape_of(cell)
    x, z = np.meshgrid(centres(LENGTH, nx), centres(WIDTH, nz))
    inside = np.maximum(np.abs(x), np.abs(z)) < SQUARE / 2
    write_fields(f"{name}_fields.h5", {"initial_traction": (np.where(inside, STRESS[1], STRESS[0]), "Pa")})


def profiles(times):
    """Distances [m] from the middle, as the published cells are counted, and times of rupture there, through these
    cells beside the middle: linear between the centres of cells, whose times are [nz, nx]."""
    z, x = (centres(length, n) for length, n in zip((WIDTH, LENGTH), times.shape))
    return {"along strike": (x - CENTRE, np.array([np.interp(CENTRE, z, column) for column in times.T])),
            "down dip": (z - CENTRE, np.array([np.interp(CENTRE, x, row) for row in times]))}


def compare(published, found):
    """Rows of the table: where, kilometres along a profile, published and found time [s]."""
    return [(way, far, time, np.interp(1e3 * far, *found[way])) for way, rows in published.items()
            for far, time in rows.items()]


def broken(name):
    """The run, its largest event's numbers, and when each cell broke in it [s]."""
    run, events = Run(f"{name}.h5"), Events(f"{name}_events.h5")
    first = int(np.argmax(events["moment"]))
    numbers = {key: events[key][first] for key in ("onset", "peak_slip_rate", "max_slip")}
    return run, numbers, numbers["onset"] + events.map_of("rupture_time", first)


def report(name, published, profiles, source, reach):
    """Prints times of rupture beside published ones, and draws them."""
    run, event, times = broken(name)
    found = profiles(times)
    rows = compare(published, found)
    print("first above 1 mm/s       published     here")
    for way, far, time, here in rows:
        print(f"{far:5g} km {way:14}   {time:.3f} s   {here:.3f} s  {100 * (here / time - 1):+.1f} %")
    share = np.array([here / time - 1 for _, _, time, here in rows])
    print(f"root mean square: {100 * np.sqrt((share ** 2).mean()):.2f} %; largest slip rate: "
          f"{event['peak_slip_rate']:.1f} m/s")
    draw(name, run, times, found, [row[1:3] for row in rows], source, reach)


def draw(name, run, times, found, points, source, reach):
    """Slip rates at two times, slip at the end with the rupture's front every half second, its times in profiles
    within reach [km], and published points (km, s). Other benchmarks draw by it as well."""
    use_style()
    canvas, axes = plt.subplots(2, 2, figsize=(12, 1.6 + 10 * times.shape[0] / times.shape[1]), layout="constrained")
    plane, = planes_of(run)
    (at, rates), (_, slip) = run.field("slip_rate"), run.field("slip")
    shown = [int(np.argmin(np.abs(at - time))) for time in SHOWN]
    norm = Span().see(rates[shown]).norm(KINDS["slip_rate"])
    maps = [(axes[0, k], rates[row], KINDS["slip_rate"], norm, f"Slip rate at {at[row]:.2f} s")
            for k, row in enumerate(shown)]
    maps.append((axes[1, 0], slip[-1], KINDS["slip"], Span().see(slip[-1]).norm(KINDS["slip"]),
                 f"Slip after {at[-1]:.0f} s, front every 0.5 s"))
    for one, values, kind, scale, title in maps:
        artist = plane.draw(one, values.ravel(), scale, kind.colours)
        plane.frame(one)
        one.set(title=title, xlabel="along strike (km)")
        if one is not axes[0, 0]:
            colour_bar(canvas, artist, scale, "slip (m)" if one is axes[1, 0] else "slip rate (m/s)", ax=one,
                       shrink=0.8)
    plane.contour(axes[1, 0], times.ravel(), CONTOURS)
    for k, (way, (far, when)) in enumerate(found.items()):
        side = far > 1e3 * reach[0]
        axes[1, 1].plot(far[side] / 1e3, when[side], color=RUN_STYLES[k]["color"], label=way)
    if points:
        axes[1, 1].plot(*zip(*points), linestyle="", marker="o", markersize=7, markerfacecolor="none",
                        markeredgecolor="black", label=source)
    axes[1, 1].set(title="Rupture's front", xlabel="from the middle (km)", ylabel="time (s)", xlim=reach,
                   ylim=(0, None))
    axes[1, 1].legend(loc="upper left" if reach[0] == 0 else "upper center")
    canvas.savefig(f"{name}.png")
    print(f"Figure: {name}.png")


def plot(name):
    report(name, PUBLISHED, profiles, "Day et al. (2005)", (0, 15))


def main(doc=__doc__, make=make, plot=plot):
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", choices=["make", "plot"])
    parser.add_argument("name", metavar="NAME")
    parser.add_argument("--cell", type=float, default=300.0, metavar="M", help="side of the cells [m]")
    a = parser.parse_args()
    if not 0 < a.cell <= SQUARE or abs(WIDTH / a.cell - round(WIDTH / a.cell)) > 1e-9:
        parser.error(f"--cell is {a.cell:g} m, expected a whole part of {WIDTH:g} m, at most {SQUARE:g}")
    with one_line():
        if a.work == "make":
            make(a.name, a.cell)
            print(*shape_of(a.cell)[::-1])
        else:
            plot(a.name)


if __name__ == "__main__":
    main()
