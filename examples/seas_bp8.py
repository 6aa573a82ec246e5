#!/usr/bin/env python3
"""Make the pore pressure of SEAS BP8-QD for examples/seas_bp8.sh, and print and draw the slip of a run under it.

    seas_bp8.py make NAME --cell 10 [--well] [--rate 0.003]   NAME_pressure.h5 for -fault_pore_pressure; prints the
                                                              cells along each side
    seas_bp8.py make NAME --diffusion ...                     NAME_wells.csv for -fault_wells in its place
    seas_bp8.py plot NAME                                     NAME.h5 to a table and NAME.png

The pressure diffuses on the square fault, whose border lets nothing through. A Gaussian source is a sum of cosines,
each of which grows as (1 - exp(-t D k^2))/(D k^2). A well is a point: what it injected in the last TAU seconds lies
around it as in a plane without border, p* E1(r^2/(4 D t)), and what it injected before has become the Gaussian.
"""

import argparse
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need, one_line

need("h5py", "numpy", "scipy", "matplotlib")
import h5py
import numpy as np
from scipy.special import exp1
from slipstep import Run
from slipstep.plots.maps import Span, colour_bar, planes_of
from slipstep.plots.panels import plt, use_style
from slipstep.results.fields import KINDS

HALF = 400.0  # of the fault's side [m]
PERMEABILITY, VISCOSITY, STORAGE = 5e-14, 1e-3, 1e-9  # [m^2], [Pa s], porosity times compressibility [1/Pa]
DIFFUSIVITY = PERMEABILITY / VISCOSITY / STORAGE  # [m^2/s]
RATE, STOP = 0.003, 360e3  # injected [m^3/s] through a thickness of 1 m, until [s]
WIDTH = 50.0  # standard deviation of the Gaussian [m]
TAU = WIDTH ** 2 / (2 * DIFFUSIVITY)  # after which a point has become it [s]
NORMAL = 25e6  # normal stress [Pa]
DAY, END = 86400.0, 30 * 86400.0  # [s]
POINTS = 0.0, 200.0  # of the table: from the middle along strike [m]
SHOWN = 1, 2, STOP / DAY, 7, 15, 30  # [days]


def centres(n):
    return (np.arange(n) + 0.5) * 2 * HALF / n - HALF


def gaussian(x, z, t):
    """Pressure [z, x] [Pa] of an injection by the Gaussian since time 0 that does not end."""
    k = 2 * np.arange(48) * np.pi / (2 * HALF)  # odd ones vanish in the middle; the last is 1e-35 of the Gaussian
    share = np.exp(-(k * WIDTH) ** 2 / 2) * np.where(k, 2, 1) / (2 * HALF) * np.cos(k * HALF)
    decay = DIFFUSIVITY * (k[:, None] ** 2 + k ** 2)
    decay[0, 0] = 1.0
    grown = -np.expm1(-decay * t) / decay
    grown[0, 0] = t
    # cosines from the border; the source's are cos(k HALF)
    modes_x, modes_z = (np.cos(np.outer(k, place + HALF)) * share[:, None] for place in (x, z))
    return RATE / STORAGE * modes_z.T @ grown @ modes_x


def point(x, z, t):
    """The same of a well."""
    r2 = np.add.outer(z ** 2, x ** 2)
    recent = RATE * VISCOSITY / (4 * np.pi * PERMEABILITY) * exp1(r2 / (4 * DIFFUSIVITY * min(t, TAU)))
    return recent + (gaussian(x, z, t - TAU) if t > TAU else 0)


def pressure(x, z, t, source=gaussian):
    """[z, x] [Pa] of the injection that ends at STOP."""
    return (source(x, z, t) if t > 0 else np.zeros((len(z), len(x)))) - (source(x, z, t - STOP) if t > STOP else 0)


def record():
    """Times [s], between which the pressure is linear: dense after the start and the end of the injection."""
    return np.unique(np.concatenate([STOP * np.linspace(0, 1, 101) ** 2,
                                     STOP + (END - STOP) * np.linspace(0, 1, 101) ** 2]))


def make(name, cell, well, rate, diffusion):
    n, times = round(2 * HALF / cell), record()
    x = centres(n)
    values = np.array([pressure(x, x, t, point if well else gaussian) for t in times]) * (rate / RATE)
    if values.max() >= 0.99 * NORMAL:
        sys.exit(f"seas_bp8.py: the pressure reaches {values.max() / 1e6:.1f} MPa, the normal stress is "
                 f"{NORMAL / 1e6:g} MPa: expected a lower --rate than {rate:g}")
    if diffusion:
        place, spread = f"injection,{HALF:g},{HALF:g}", 0 if well else WIDTH
        with open(f"{name}_wells.csv", "w", encoding="utf-8") as file:
            file.write(f"well,x,z,s,m3/s,spread\n{place},0,{rate!r},{spread:g}\n{place},{STOP:g},0,{spread:g}\n")
        print(n)
        return
    with h5py.File(f"{name}_pressure.h5", "w") as file:
        file["time"], file["pressure"] = times, values
    print(n)


def profile(run):
    """Distances [m], times [s] and slip [times, x] along strike through the middle."""
    times, slip = run.field("slip")
    middle = slip.shape[1] // 2
    rows = slip[:, middle - 1:middle + 1] if slip.shape[1] % 2 == 0 else slip[:, middle:middle + 1]
    return run.axes[0] - HALF, times, rows.mean(axis=1)


def plot(name):
    run = Run(f"{name}.h5")
    x, times, slip = profile(run)
    print(f"after {times[-1] / DAY:g} days: " + ", ".join(
        f"{1e3 * np.interp(place, x, slip[-1]):.2f} mm at {place:g} m" for place in POINTS)
        + f"; largest slip rate: {run.series['max_slip_rate'].max():.3g} m/s")
    draw(name, run, x, times, slip)
    print(f"Figure: {name}.png")


def draw(name, run, x, times, slip):
    """Slip at the end as a map; pressure, slip and slip rate along strike, slip rate in time."""
    use_style()
    canvas, axes = plt.subplots(2, 2, figsize=(11, 8.4), layout="constrained")
    plane, = planes_of(run)
    whole = run.field("slip")[1][-1]
    norm = Span().see(whole).norm(KINDS["slip"])
    artist = plane.draw(axes[0, 0], plane.values(whole), norm, KINDS["slip"].colours)
    axes[0, 0].set(title=f"Slip after {times[-1] / DAY:g} days", xlabel="along strike (km)")
    colour_bar(canvas, artist, norm, "slip (m)", ax=axes[0, 0], shrink=0.8)
    with h5py.File(f"{name}.h5") as file:
        computed = "pore_pressure" in file["fields"]
    if computed:
        at, values = run.field("pore_pressure")
    else:
        with h5py.File(f"{name}_pressure.h5") as file:
            at, values = file["time"][...], file["pressure"][...]
    middle = values.shape[1] // 2
    days = [day for day in SHOWN if day * DAY <= times[-1] * (1 + 1e-9)]
    for day, colour in zip(days, plt.get_cmap("viridis")(np.linspace(0, 0.92, len(days)))):
        shown = [np.interp(day * DAY, at, column) for column in values[:, middle].T]
        axes[0, 1].plot(x, np.array(shown) / 1e6, color=colour, label=f"day {day:.3g}")
        axes[1, 0].plot(x, [1e3 * np.interp(day * DAY, times, column) for column in slip.T], color=colour)
    axes[0, 1].set(title="Pore pressure through the middle", ylabel="MPa", ylim=(0, None))
    axes[1, 0].set(title="Slip through the middle", ylabel="mm", ylim=(0, None))
    for one in (axes[0, 1], axes[1, 0]):
        one.set(xlabel="from the middle (m)", xlim=(-HALF, HALF))
    axes[0, 1].legend()
    axes[1, 1].semilogy(run.series["time"] / DAY, run.series["max_slip_rate"])
    axes[1, 1].axvline(STOP / DAY, color="black", linestyle=(0, (4, 2)), linewidth=0.9)
    axes[1, 1].set(title="Largest slip rate; dashed: end of the injection", xlabel="time (days)", ylabel="m/s",
                   xlim=(0, times[-1] / DAY))
    canvas.savefig(f"{name}.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", choices=["make", "plot"])
    parser.add_argument("name", metavar="NAME")
    parser.add_argument("--cell", type=float, default=10.0, metavar="M", help="side of the cells [m]")
    parser.add_argument("--well", action="store_true", help="a point in place of the Gaussian")
    parser.add_argument("--diffusion", action="store_true", help="wells for a fault that computes the diffusion")
    parser.add_argument("--rate", type=float, default=RATE, metavar="Q", help="injected [m^3/s]")
    a = parser.parse_args()
    if not a.cell > 0 or abs(HALF / a.cell - round(HALF / a.cell)) > 1e-9:
        parser.error(f"--cell is {a.cell:g} m, expected a whole part of {HALF:g} m")
    with one_line():
        if a.work == "make":
            make(a.name, a.cell, a.well, a.rate, a.diffusion)
        else:
            plot(a.name)


if __name__ == "__main__":
    main()
