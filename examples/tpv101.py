#!/usr/bin/env python3
"""Make the fields of TPV101 or TPV103 for examples/tpv101.sh and tpv103.sh, and print and draw when a run broke.

    tpv101.py make tpv101 NAME --cell 300     NAME_fields.h5; prints the numbers of cells along strike and down dip
    tpv101.py plot tpv101 NAME                NAME.h5 and NAME_events.h5 to a table and NAME.png
"""

import argparse

import tpv3
from slipstep.modules import one_line
from slipstep.results.files import write_fields

import numpy as np

LENGTH, WIDTH = 36e3, 21e3  # [m]
WEAK, EDGE = (15e3, 7.5e3), 3e3  # half of what weakens, along strike and down dip, and the transition beyond it [m]
A, RATE = {"tpv101": 0.008, "tpv103": 0.010}, 0.1  # a and V_w [m/s] in the middle; a is twice that beyond, V_w 1 m/s
STATIONS = ((0, 0), (6, 0), (9, 0), (12, 0), (-9, 0), (0, 3), (0, 6), (9, 6))  # from the middle [km]
# When cells of 150 m are first above 0.1 m/s [s], linear within steps, in UGUCA (ElsevierSoftwareX/SOFTX-D-21-00041)
PUBLISHED = {"tpv101": {(0, 0): 0.845, (6, 0): 3.475, (0, 6): 4.064}, "tpv103": {}}


def box(x, half):
    """1 within half of the middle, 0 from 3 km beyond, smooth between, as the benchmarks have it."""
    share = np.clip((np.abs(x) - half) / EDGE, 1e-3, 1 - 1e-3)  # tanh(1000) is 1
    return 0.5 * (1 + np.tanh(1 / (share - 1) + 1 / share))


def make(benchmark, name, cell):
    nx, nz = round(LENGTH / cell), round(WIDTH / cell)
    beyond = 1 - np.outer(box(tpv3.centres(WIDTH, nz), WEAK[1]), box(tpv3.centres(LENGTH, nx), WEAK[0]))
    fields = {"friction_a": (A[benchmark] * (1 + beyond), "1")}
    if benchmark == "tpv103":
        fields["friction_weakening_rate"] = RATE + (1 - RATE) * beyond, "m/s"
    write_fields(f"{name}_fields.h5", fields)
    print(nx, nz)


def at(times, x, z):
    """Times [nz, nx] at places from the middle [m], bilinear between the centres of cells."""
    rows = [np.interp(x, tpv3.centres(LENGTH, times.shape[1]), row) for row in times]
    return np.interp(z, tpv3.centres(WIDTH, times.shape[0]), rows)


def plot(benchmark, name):
    run, event, times = tpv3.broken(name)
    print("first above 0.1 m/s at         here    UGUCA, 150 m")
    for place in STATIONS:
        here, other = at(times, *(1e3 * one for one in place)), PUBLISHED[benchmark].get(place)
        print(f"({place[0]:3} km, {place[1]} km)  {here:15.3f} s", f"  {other:.3f} s  {100 * (here / other - 1):+.1f} %"
              if other else "")
    print(f"largest slip rate: {event['peak_slip_rate']:.1f} m/s; largest slip: {event['max_slip']:.2f} m")
    strike, dip = (tpv3.centres(length, n) for length, n in zip((LENGTH, WIDTH), times.shape[::-1]))
    found = {"along strike": (strike, np.array([at(times, x, 0) for x in strike])),
             "down dip": (dip, np.array([at(times, 0, z) for z in dip]))}
    tpv3.draw(name, run, times, found, [(max(place), time) for place, time in PUBLISHED[benchmark].items()],
              "UGUCA, 150 m", (0, 15))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", choices=["make", "plot"])
    parser.add_argument("benchmark", choices=sorted(A))
    parser.add_argument("name", metavar="NAME")
    parser.add_argument("--cell", type=float, default=300.0, metavar="M", help="side of the cells [m]")
    a = parser.parse_args()
    if not a.cell > 0 or abs(3e3 / a.cell - round(3e3 / a.cell)) > 1e-9:
        parser.error(f"--cell is {a.cell:g} m, expected a whole part of 3000 m")
    with one_line():
        if a.work == "make":
            make(a.benchmark, a.name, a.cell)
        else:
            plot(a.benchmark, a.name)


if __name__ == "__main__":
    main()
