#!/usr/bin/env python3
"""Make the fields for -fault_parameters of examples/valve.opts, a fault that is a valve of rising fluid, and plot its
swarms: fluid gathers below, slip rises with its pressure and opens the fault, the fluid drains upwards, and time seals
the fault again.

    valve.py OUT.h5                 the fields
    valve.py plot RUN.h5 OUT.png    slip rate, pressure and permeability against time and depth, of the whole run and of
                                    its largest swarm; prints a line for each swarm
"""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need, one_line

need("h5py", "numpy", "matplotlib")
import h5py
import numpy as np
from slipstep.plots.panels import RED, plt, use_style
from slipstep.results.files import write_fields
from slipstep.times import YEAR

CELLS, DEPTH = 32, 16e3  # [m]
STRESS, MODULUS, DENSITY = 60e6, 32.03812e9, 2670.0  # [Pa], [kg/m^3]
LOADING, B, REFERENCE, FRICTION = 1e-9, 0.015, 1e-6, 0.6
PATCH, TRANSITION, WEAK, STRONG = (3e3, 11e3), 2e3, 0.008, 0.025  # depths [m], a within and far from them
INFLOW, APERTURE = 2e-8, 1.0  # Darcy velocity from below [m/s], [m]


def fields():
    """{name: (array [Nz, Nx], unit)}. Cells that weaken begin at a tenth of the loading rate, all at the state that is
    steady at that rate."""
    z = (np.arange(CELLS) + 0.5) * DEPTH / CELLS
    a = WEAK + (STRONG - WEAK) * np.clip(np.maximum(PATCH[0] - z, z - PATCH[1]) / TRANSITION, 0, 1)
    rate = np.where(a < B, 0.1, 1.0) * LOADING
    steady = (FRICTION + B * np.log(REFERENCE / LOADING)) / a
    traction = (STRESS * a * np.arcsinh(rate / (2 * REFERENCE) * np.exp(steady))
                + np.sqrt(MODULUS * DENSITY) / 2 * rate)
    source, border = np.zeros(CELLS), np.full(CELLS, np.nan)
    source[-1] = INFLOW * APERTURE / (DEPTH / CELLS)
    border[0] = 0
    return {name: (values[:, None], unit) for name, values, unit in
            (("friction_a", a, "1"), ("initial_rate", rate, "m/s"), ("initial_traction", traction, "Pa"),
             ("fluid_source", source, "m/s"), ("border_pressure", border, "Pa"))}


BURST, FAST = 1e-4, 1e-6  # a burst is faster, and a front of slip where rates pass the other upwards [m/s]
MONTH = YEAR / 12  # bursts less than this apart are one swarm


def bursts(time, rate):
    """Times [s] at which the largest slip rate passes BURST, the first one since it was a tenth of that or less."""
    found, armed = [], True
    for t, v in zip(time, rate):
        if armed and v > BURST:
            found.append(t)
        armed = v < BURST / 10 or (armed and v <= BURST)
    return np.array(found)


def front(time, rate, begin, end):
    """When each cell first passed FAST between two times [s]; NaN: it did not."""
    within = (time >= begin) & (time <= end)
    fast = rate[within] > FAST
    return np.where(fast.any(axis=0), time[within][fast.argmax(axis=0)], np.nan)


def describe(swarm, z, run):
    """What is said of a swarm: how far its front rises, and how the pressure at the foot falls within the next year."""
    time, rate, pressure = run["time"], run["slip_rate"], run["pore_pressure"]
    passed = front(time, rate, swarm[0] - 3 * MONTH, swarm[-1] + MONTH)
    deep = np.nanargmin(passed)
    above = np.flatnonzero(np.isfinite(passed[:deep + 1]))
    top = above[0]
    foot = np.interp([swarm[0] - MONTH, swarm[-1] + YEAR], time, pressure[:, -1]) / 1e6
    return (f"{swarm[0] / YEAR:6.1f} years: {len(swarm)} burst{'s' * (len(swarm) > 1)}, slip begins at "
            f"{z[deep] / 1e3:.1f} km and reaches {z[top] / 1e3:.1f} km after "
            f"{(passed[top] - passed[deep]) / 86400:.3g} days; the pressure below falls from {foot[0]:.3g} to "
            f"{foot[1]:.3g} MPa within a year")


def plot(path, picture):
    with h5py.File(path) as file:
        run = {name: file["fields"][name][...] for name in ("time", "slip_rate", "pore_pressure", "permeability")}
        time, largest, left = (file["series"][name][...] for name in ("time", "max_slip_rate", "border_volume"))
    run.update({name: values[:, :, 0] for name, values in run.items() if name != "time"})
    z = (np.arange(CELLS) + 0.5) * DEPTH / CELLS
    times = bursts(time, largest)
    swarms = np.split(times, np.flatnonzero(np.diff(times) > MONTH) + 1) if len(times) else []
    print(f"{len(times)} bursts of more than {BURST:g} m/s in {time[-1] / YEAR:.4g} years, in {len(swarms)} swarms")
    for swarm in swarms:
        print(describe(swarm, z, run))
    starts = np.array([swarm[0] for swarm in swarms])
    ends = np.minimum(np.append(starts[1:], time[-1]), starts + YEAR)
    drained = (np.interp(ends, time, left) - np.interp(starts, time, left)).sum() / left[-1]
    print(f"{100 * drained:.3g} % of the fluid that has left the fault did so within a year after a swarm began, "
          f"{100 * (ends - starts).sum() / time[-1]:.3g} % of the time")
    use_style()
    windows = [(0.0, time[-1])]
    if swarms:
        at = max(swarms, key=len)
        windows.append((at[0] - 2 * MONTH, at[-1] + 2 * MONTH))
    canvas, axes = plt.subplots(3, len(windows), figsize=(7 * len(windows), 9.5), sharey=True, sharex="col",
                                squeeze=False, layout="constrained")
    rows = (("slip rate (m/s), log$_{10}$", np.log10(run["slip_rate"]), "magma", (-13, 0)),
            ("pressure (MPa)", run["pore_pressure"] / 1e6, "viridis", None),
            ("permeability (m$^2$), log$_{10}$", np.log10(run["permeability"]), "cividis", None))
    for column, (begin, end) in enumerate(windows):
        near = slice(max(np.searchsorted(run["time"], begin) - 1, 0), np.searchsorted(run["time"], end) + 1)
        # hours are too short for years
        clock = run["time"][near] / YEAR if not column else (run["time"][near] - at[0]) / 86400
        for row, (name, values, colours, limits) in enumerate(rows):
            low, high = limits or (values.min(), values.max())
            drawn = axes[row, column].pcolormesh(clock, z / 1e3, values[near].T, shading="nearest", cmap=colours,
                                                 vmin=low, vmax=high, rasterized=True)
            axes[row, column].grid(False)
            axes[row, column].set(ylim=(DEPTH / 1e3, 0), xlim=((begin, end) - at[0]) / np.array(86400.0) if column
                                  else (begin / YEAR, end / YEAR))
        axes[-1, column].set_xlabel("time (years)" if not column else "days since the first burst of this swarm")
    for row, (name, *_) in enumerate(rows):
        canvas.colorbar(axes[row, -1].collections[0], ax=axes[row, :], label=name, aspect=15)
        axes[row, 0].set_ylabel("depth (km)")
    axes[0, 0].plot(times / YEAR, np.full(len(times), 0.35), "v", color=RED, markersize=5)
    axes[0, 0].set_title("Bursts")
    if swarms:
        axes[0, 1].set_title(f"{len(at)} bursts, {at[0] / YEAR:.1f} years after the start")
    canvas.savefig(picture)
    print(f"Figure: {picture}")


def main():
    if len(sys.argv) == 4 and sys.argv[1] == "plot":
        plot(*sys.argv[2:])
    elif len(sys.argv) == 2 and sys.argv[1] != "plot":
        write_fields(sys.argv[1], fields())
    else:
        sys.exit(f"usage: {sys.argv[0]} OUT.h5, or {sys.argv[0]} plot RUN.h5 OUT.png")


if __name__ == "__main__":
    with one_line():
        main()
