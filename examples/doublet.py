#!/usr/bin/env python3
"""Make the faults and wells of examples/doublet.sh, and draw and check its runs.

    doublet.py make NAME --cell 100     NAME_mesh.h5, a main fault and a branch of rectangles that share the line in
                                        which they meet, NAME_doublet.csv, wells of equal rates, and NAME_alone.csv,
                                        the first of them
    doublet.py plot NAME                NAME.png, from the runs NAME_doublet.h5 and NAME_alone.h5, with its numbers
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
from slipstep.results.moment import magnitude

DAY = 86400.0
TOP, DEPTH = 2e3, 2e3  # of the upper edge, and from there to the lower one [m]
MAIN, FORK, BRANCH, TURN = 4e3, 2e3, 1.5e3, -20.0  # lengths, where the branch leaves, its strike [m, degrees]
WELLS = {"injector": (0, 1250.0), "producer": (1, 450.0)}  # fault, distance along it [m]
BOTTOM = 2950.0  # depth of the wells [m]
RATE = 110.0  # [m^3/day]


def place(fault, along):
    """North and east [m] of a distance along a fault."""
    turn = np.radians(TURN * fault)
    return FORK * fault + np.cos(turn) * along, np.sin(turn) * along


def make(name, cell):
    rows, side = round(DEPTH / cell), FORK / round(FORK / cell)  # of which one ends at the fork
    cells, faults = [], []
    for fault, length in enumerate((MAIN, BRANCH)):
        s, z = (part.ravel() for part in np.meshgrid((np.arange(round(length / side)) + 0.5) * side,
                                                     TOP + (np.arange(rows) + 0.5) * DEPTH / rows))
        one = np.ones(len(s))
        cells.append(np.column_stack([*place(fault, s), z, one * side, one * DEPTH / rows, one * TURN * fault,
                                      90 * one]))
        faults.append(np.full(len(s), fault))
    with h5py.File(f"{name}_mesh.h5", "w") as file:
        file["cells"] = np.concatenate(cells)
        file["cells"].attrs["columns"] = "x y z length width strike dip"
        file["cells"].attrs["units"] = "m"
        file["fault"] = np.concatenate(faults)
    for case, share in (("doublet", 1), ("alone", 0)):
        with open(f"{name}_{case}.csv", "w") as file:
            print("well,x,y,z,days,m3/day", file=file)
            for well, rate in zip(WELLS, (RATE, -share * RATE)):
                if rate:
                    print(well, *(f"{x:.9g}" for x in place(*WELLS[well])), BOTTOM, 0, rate, sep=",", file=file)


class Case:
    """A run: its series, its fields as [time, depth, along], one of each fault."""

    def __init__(self, path):
        with h5py.File(path) as file:
            self.series = {name: data[...] for name, data in file["series"].items()}
            fields = {name: data[...] for name, data in file["fields"].items()}
            mesh = {name: data[...] for name, data in file["mesh"].items()}
        self.aperture = mesh["aperture"][0]
        self.storage = mesh["porosity"][0] * mesh["pore_compressibility"][0] * self.aperture
        self.time = fields["time"]
        rows = len(np.unique(mesh["z"]))
        self.length, self.width = mesh["length"][0], mesh["width"][0]
        self.fields = [{name: values[:, mesh["fault"] == fault].reshape(len(self.time), rows, -1, *values.shape[2:])
                        for name, values in fields.items() if values.ndim > 1} for fault in (0, 1)]

    def stored(self, fault):
        """Volume that the pores of a fault hold beyond that of the start [m^3]."""
        return self.storage * self.length * self.width * self.fields[fault]["pore_pressure"].sum(axis=(1, 2))

    def through(self, fault, column):
        """What flows along a fault through a column of its cells [m^3/s]."""
        return self.aperture * self.width * self.fields[fault]["fluid_flux"][:, :, column, 0].sum(axis=1)

    def junction(self):
        """What flows at the fork: up to it and on from it along the main fault, and into the branch [m^3/s]. The
        centres of the cells are half a cell away, where the flow differs by what they store."""
        fork = round(FORK / self.length)
        flows = []
        for fault, column, side in ((0, fork - 1, -1), (0, fork, 1), (1, 0, 1)):
            held = self.storage * self.length * self.width * self.fields[fault]["pore_pressure"][:, :, column].sum(1)
            flows.append(self.through(fault, column) + side * np.gradient(held, self.time) / 2)
        return flows


def describe(run):
    """Prints where the fluid of a doublet is and flows, at the end."""
    volume, before, after, branch = RATE * run.time[-1] / DAY, *(flow[-1] * DAY for flow in run.junction())
    print(f"{volume:.6g} m^3 went in, and as much out; the main fault holds {run.stored(0)[-1]:.4g} m^3 more than at "
          f"the start, the branch {run.stored(1)[-1]:.4g} m^3")
    print(f"at the fork at the end {before:.4f} m^3/day arrive along the main fault from the injector and "
          f"{-after:.4f} from its other side, and {branch:.4f} flow into the branch: they balance to "
          f"{abs(before - after - branch) / RATE:.1e} of the rate")


UNIT = {"pore_pressure": (1e6, "pressure (MPa)"), "slip": (1, "slip (m)")}


def draw_fault(axes, run, fault, name, limits, colours):
    """One quantity on one fault at the end, with arrows of the flux over pressure, whose length is its square root."""
    values = run.fields[fault][name][-1] / UNIT[name][0]
    rows, columns = values.shape
    start = 0 if fault else -FORK
    s, z = start + np.arange(columns + 1) * run.length, TOP + np.arange(rows + 1) * run.width
    drawn = axes.pcolormesh(s / 1e3, z / 1e3, values, cmap=colours, vmin=limits[0], vmax=limits[1], rasterized=True)
    if name == "pore_pressure":
        step = max(rows // 10, 1)
        part = np.s_[step // 2::step, step // 2::step]
        flux = run.fields[fault]["fluid_flux"][-1][part]
        size = np.hypot(flux[..., 0], flux[..., 1])
        flux = flux / np.sqrt(size.max() * np.maximum(size, 1e-300))[..., None]
        x, y = (one[part] for one in np.meshgrid((s[1:] + s[:-1]) / 2e3, (z[1:] + z[:-1]) / 2e3))
        axes.quiver(x, y, flux[..., 0], flux[..., 1], angles="xy", scale_units="xy",
                    scale=1e3 / (1.2 * step * run.length), width=0.004 * MAIN / columns / run.length, color="0.1")
    if fault < run.series["well_rate"].shape[1]:
        axes.plot((start + WELLS[list(WELLS)[fault]][1]) / 1e3, BOTTOM / 1e3, marker="v^"[fault],
                  color="white", markeredgecolor="black", markersize=9)
    axes.axvline(0, color="0.2", linestyle="--", linewidth=1)
    axes.set(ylim=((TOP + DEPTH) / 1e3, TOP / 1e3), aspect="equal")
    axes.grid(False)
    return drawn


def plot(name):
    runs = {case: Case(f"{name}_{case}.h5") for case in ("doublet", "alone")}
    run = runs["doublet"]
    describe(run)
    for case, words in (("doublet", "with the producer"), ("alone", "without it")):
        series, fields = runs[case].series, runs[case].fields
        moment = np.abs(series["moment"][-1]).sum()
        print(f"{words}: the largest slip rate is {series['max_slip_rate'].max():.2g} m/s, slip at most "
              f"{fields[0]['slip'][-1].max():.3g} m on the main fault and {fields[1]['slip'][-1].max():.3g} m on the "
              f"branch, moment M {magnitude(moment):.2f}")
    use_style()
    canvas, axes = plt.subplots(4, 2, figsize=(12, 13), width_ratios=(MAIN, BRANCH), layout="constrained")
    for row, (case, field, title, colours) in enumerate((
            ("doublet", "pore_pressure", "pressure and flux", "RdBu_r"), ("doublet", "slip", "slip", "viridis"),
            ("alone", "slip", "without the producer", "viridis"))):
        largest = max(np.abs(one[field][-1]).max() for one in runs[case].fields) / UNIT[field][0]
        for fault in (0, 1):
            drawn = draw_fault(axes[row, fault], runs[case], fault, field,
                               (0 if field == "slip" else -largest, largest), colours)
            axes[row, fault].set_title(f"{('Main fault', 'Branch')[fault]}: {title}")
        canvas.colorbar(drawn, ax=axes[row, :], label=UNIT[field][1])
        axes[row, 0].set_ylabel("depth (km)")
    for fault in (0, 1):
        axes[2, fault].set_xlabel("distance from the fork (km)")
    for flow, label, style in zip(run.junction(), ("up to the fork", "on along the main fault", "into the branch"),
                                  RUN_STYLES):
        axes[3, 0].plot(run.time / DAY, flow * DAY, label=label, color=style["color"])
    axes[3, 0].axhline(RATE, color="0.5", linestyle=":", label="rate of the wells")
    axes[3, 0].set(title="Flow at the fork", xlabel="time (days)", ylabel="m$^3$/day")
    axes[3, 0].legend()
    for (case, one), style in zip(runs.items(), RUN_STYLES):
        axes[3, 1].plot(one.series["time"] / DAY, np.abs(one.series["moment"]).sum(axis=1), color=style["color"],
                        label={"doublet": "with the producer", "alone": "without it"}[case])
    axes[3, 1].set(title="Moment", xlabel="time (days)", ylabel="N m")
    axes[3, 1].legend()
    canvas.savefig(f"{name}.png")
    print(f"Figure: {name}.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", choices=["make", "plot"])
    parser.add_argument("name", metavar="NAME")
    parser.add_argument("--cell", type=float, default=100.0, metavar="M", help="side of the cells [m]")
    a = parser.parse_args()
    if not 0 < a.cell <= 500:
        parser.error(f"--cell is {a.cell:g}, expected a number > 0 up to 500")
    with one_line():
        if a.work == "make":
            make(a.name, a.cell)
        else:
            plot(a.name)


if __name__ == "__main__":
    main()
