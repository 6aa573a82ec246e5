#!/usr/bin/env python3
"""Make the fields of TPV5 for examples/tpv5.sh, and compare a run of it with a published boundary integral.

    tpv5.py make NAME --cell 300     NAME_fields.h5; prints the numbers of cells along strike and down dip
    tpv5.py plot NAME                NAME.h5 and NAME_events.h5 to a table and NAME.png
"""

import argparse

import tpv3  # first: it finds the package
import numpy as np
from slipstep import Run
from slipstep.modules import one_line
from slipstep.plots.maps import Span, colour_bar, planes_of
from slipstep.plots.panels import RUN_STYLES, plt, use_style
from slipstep.results.events import Events
from slipstep.results.fields import KINDS
from slipstep.results.files import write_fields

DEPTH = 7.5e3  # of the middle of the squares [m]
SQUARES = {0: 81.6e6, -7.5e3: 78e6, 7.5e3: 62e6}  # stress by the middle along strike [m, Pa]
STRESS = 70e6  # beyond them
# When cells of 100 m break [s], by kilometres along strike, in the uppermost row and beside the depth of 7.5 km: the
# boundary integral of E. Dunham in the project of Harris et al. (2009), Seismol. Res. Lett. 80, as
# github.com/ranjkunn/TBSBIEM has it; between the centres of cells linear
PUBLISHED = {"at the ground": {-12: 5.177, -9: 4.590, -7.5: 4.311, -4.5: 3.815, 0: 3.483, 4.5: 3.815, 7.5: 4.301,
                               9: 4.580, 12: 5.153},
             "at 7.5 km": {-12: 4.080, -9: 2.969, -7.5: 2.637, -4.5: 1.727, 4.5: 1.727, 7.5: 3.878, 9: 4.677,
                           12: 5.273}}
DEPTHS = {"at the ground": 50.0, "at 7.5 km": DEPTH}  # [m]


def centres(shape):
    """Of cells, along strike from the middle and below the ground [m]."""
    return tpv3.centres(tpv3.LENGTH, shape[1]), tpv3.centres(tpv3.WIDTH, shape[0]) + tpv3.WIDTH / 2


def make(name, cell):
    x, z = np.meshgrid(*centres(tpv3.shape_of(cell)))
    stress = np.full(x.shape, STRESS)
    for middle, value in SQUARES.items():
        stress[np.maximum(np.abs(x - middle), np.abs(z - DEPTH)) < tpv3.SQUARE / 2] = value
    write_fields(f"{name}_fields.h5", {"initial_traction": (stress, "Pa")})


def profiles(times):
    """Times of rupture along strike at the depths of the table, from those of cells [nz, nx]."""
    x, z = centres(times.shape)
    return x, {way: np.array([np.interp(depth, z, column) for column in times.T]) for way, depth in DEPTHS.items()}


def compare(x, found):
    """Rows of the table: where, kilometres along strike, published and found time [s]."""
    return [(way, far, time, np.interp(1e3 * far, x, found[way])) for way, rows in PUBLISHED.items()
            for far, time in rows.items()]


def plot(name):
    run, events = Run(f"{name}.h5"), Events(f"{name}_events.h5")
    first = int(np.argmax(events["moment"]))
    times = events["onset"][first] + events.map_of("rupture_time", first)
    x, found = profiles(times)
    print("first above 1 mm/s       published     here")
    for way, far, time, here in compare(x, found):
        print(f"{far:5g} km {way:14}   {time:.3f} s   {here:.3f} s  {100 * (here / time - 1):+.1f} %")
    share = [here / time - 1 for _, _, time, here in compare(x, found)]
    print(f"root mean square: {100 * np.sqrt(np.mean(np.square(share))):.2f} %; the mirror image stands for the "
          "ground, an approximation")
    draw(name, run, times, x, found)
    print(f"Figure: {name}.png")


def draw(name, run, times, x, found):
    """Slip rates at two times, slip at the end with the rupture's front every half second, and the table's times."""
    use_style()
    canvas, axes = plt.subplots(2, 2, figsize=(12, 6.6), layout="constrained")
    plane, = planes_of(run)
    (at, rates), (_, slip) = run.field("slip_rate"), run.field("slip")
    shown = [int(np.argmin(np.abs(at - time))) for time in tpv3.SHOWN]
    for one, field, values, title in ((axes[0, 0], "slip_rate", rates[shown[0]], f"Slip rate at {at[shown[0]]:.2f} s"),
                                      (axes[0, 1], "slip_rate", rates[shown[1]], f"Slip rate at {at[shown[1]]:.2f} s"),
                                      (axes[1, 0], "slip", slip[-1],
                                       f"Slip after {at[-1]:.0f} s, front every 0.5 s")):
        kind = KINDS[field]
        scale = Span().see(rates[shown] if field == "slip_rate" else values).norm(kind)
        artist = plane.draw(one, values.ravel(), scale, kind.colours)
        plane.frame(one)
        one.set(title=title, xlabel="along strike (km)")
        colour_bar(canvas, artist, scale, "slip (m)" if field == "slip" else "slip rate (m/s)", ax=one, shrink=0.8)
    plane.contour(axes[1, 0], times.ravel(), tpv3.CONTOURS)
    for k, (way, rows) in enumerate(PUBLISHED.items()):
        axes[1, 1].plot(x / 1e3, found[way], color=RUN_STYLES[k]["color"], label=way)
        axes[1, 1].plot(list(rows), list(rows.values()), linestyle="", marker="o", markersize=7,
                        markerfacecolor="none", markeredgecolor="black", label="Dunham" if k else None)
    axes[1, 1].set(title="Rupture's front", xlabel="along strike (km)", ylabel="time (s)", ylim=(0, None))
    axes[1, 1].legend(loc="upper center")
    canvas.savefig(f"{name}.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", choices=["make", "plot"])
    parser.add_argument("name", metavar="NAME")
    parser.add_argument("--cell", type=float, default=300.0, metavar="M", help="side of the cells [m]")
    a = parser.parse_args()
    if not 0 < a.cell <= tpv3.SQUARE or abs(tpv3.WIDTH / a.cell - round(tpv3.WIDTH / a.cell)) > 1e-9:
        parser.error(f"--cell is {a.cell:g} m, expected a whole part of {tpv3.WIDTH:g} m, at most {tpv3.SQUARE:g}")
    with one_line():
        if a.work == "make":
            make(a.name, a.cell)
            print(*tpv3.shape_of(a.cell)[::-1])
        else:
            plot(a.name)


if __name__ == "__main__":
    main()
