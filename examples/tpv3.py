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
PUBLISHED = {"strike": {2: 0.654, 3: 1.087, 4.5: 1.751, 6: 2.406, 7.5: 3.002, 9: 3.560},
             "dip": {2: 0.770, 3: 1.338, 4.5: 2.184, 6: 2.916}}
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
    """Distances from the middle [m] and times of rupture there, along strike and down dip, through the published cells
    beside the middle: linear between the centres of cells, whose times are [nz, nx]."""
    z, x = (centres(length, n) for length, n in zip((WIDTH, LENGTH), times.shape))
    return {"strike": (x, np.array([np.interp(CENTRE, z, column) for column in times.T])),
            "dip": (z, np.array([np.interp(CENTRE, x, row) for row in times]))}


def compare(found):
    """Rows of the table: direction, distance [km], published and found time [s]."""
    return [(way, far, time, np.interp(1e3 * far + CENTRE, *found[way])) for way, rows in PUBLISHED.items()
            for far, time in rows.items()]


def plot(name):
    run, events = Run(f"{name}.h5"), Events(f"{name}_events.h5")
    first = int(np.argmax(events["moment"]))
    times = events["onset"][first] + events.map_of("rupture_time", first)
    found = profiles(times)
    print("first above 1 mm/s     published     here")
    for way, far, time, here in compare(found):
        print(f"{far:4g} km along {way:6}    {time:.3f} s   {here:.3f} s  {100 * (here / time - 1):+.1f} %")
    share = np.array([here / time - 1 for _, _, time, here in compare(found)])
    print(f"root mean square: {100 * np.sqrt((share ** 2).mean()):.2f} %; largest slip rate: "
          f"{events['peak_slip_rate'][first]:.1f} m/s")
    draw(name, run, times, found, {way: [(far + CENTRE / 1e3, time) for far, time in rows.items()]
                                   for way, rows in PUBLISHED.items()}, "Day et al. (2005)")


def draw(name, run, times, found, published, source):
    """Slip rates at two times, slip at the end with the rupture's front every half second, its times in profiles from
    the middle, and published points (km, s) of each. tpv101.py draws by it as well."""
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
        side = far > 0
        axes[1, 1].plot(far[side] / 1e3, when[side], color=RUN_STYLES[k]["color"],
                        label="along strike" if way == "strike" else "down dip")
    points = [point for rows in published.values() for point in rows]
    if points:
        axes[1, 1].plot(*zip(*points), linestyle="", marker="o", markersize=7, markerfacecolor="none",
                        markeredgecolor="black", label=source)
    axes[1, 1].set(title="Rupture's front", xlabel="from the middle (km)", ylabel="time (s)", xlim=(0, 15),
                   ylim=(0, None))
    axes[1, 1].legend(loc="upper left")
    canvas.savefig(f"{name}.png")
    print(f"Figure: {name}.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
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
