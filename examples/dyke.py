#!/usr/bin/env python3
"""Make mesh, stress and pressure of a dyke below a normal fault for examples/dyke.sh, and plot the run.

    dyke.py make NAME --cell 250 --pressure 6    NAME_mesh.h5, NAME_fields.h5 and NAME_pressure.h5; the pressure in MPa
    dyke.py plot NAME                            plot the run NAME.h5 to NAME.png, and print its results
"""

import argparse
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need, one_line

need("h5py", "numpy", "matplotlib")
import h5py
import numpy as np
from slipstep import Run
from slipstep.plots.maps import Span, colour_bar, planes_of
from slipstep.plots.panels import RUN_STYLES, plt, save, use_style
from slipstep.results.fields import KINDS
from slipstep.results.files import write_fields

DAY = 86400.0
DYKE, FAULT = 0, 1  # labels
LENGTH = 10e3  # of both along strike [m]
TOP, BOTTOM = 2e3, 6e3  # depths of the dyke [m]
# of the fault: it dips west, towards the dyke, from a trace so far east of it to this depth [m]
DIP, TRACE, REACH = 60.0, 2e3, 1.8e3
GRADIENT = 15e3  # effective normal stress per depth [Pa/m]
SHARE = 0.56  # of the fault's normal stress that its shear stress is; friction is 0.6
DROP = 0.15  # by which friction falls on the fault; it does not on the dyke, which has no shear stress
RISE, HOLD, FALL = 8.0, 4.0, 16.0  # of the pressure [days]
UNDER = 2e6  # by which it is below what presses the dyke together before and after [Pa]


def plane(strike, dip, along, corner, size, counts):
    """Rows x, y, z, length, width, strike, dip of a plane of cells from the middle of its upper edge."""
    a, d = np.radians(strike), np.radians(dip)
    s, w = np.meshgrid((np.arange(counts[0]) + 0.5) * along / counts[0] - along / 2,
                       (np.arange(counts[1]) + 0.5) * size / counts[1])
    x = corner[0] + s * np.cos(a) - w * np.cos(d) * np.sin(a)
    y = corner[1] + s * np.sin(a) + w * np.cos(d) * np.cos(a)
    full = np.full_like(s, 1.0)
    return np.stack([x, y, corner[2] + w * np.sin(d), full * along / counts[0], full * size / counts[1], full * strike,
                     full * dip], axis=-1).reshape(-1, 7)


def make(name, cell, pressure):
    counts = [(max(1, round(LENGTH / cell)), max(1, round(size / cell)))
              for size in (BOTTOM - TOP, REACH / np.sin(np.radians(DIP)))]
    dyke = plane(0, 90, LENGTH, (0, 0, TOP), BOTTOM - TOP, counts[0])
    fault = plane(180, DIP, LENGTH, (0, TRACE, 0), REACH / np.sin(np.radians(DIP)), counts[1])
    rows, label = np.concatenate([dyke, fault]), np.repeat([DYKE, FAULT], [len(dyke), len(fault)])
    with h5py.File(f"{name}_mesh.h5", "w") as file:
        file["cells"] = rows
        file["cells"].attrs.update(columns="x y z length width strike dip", units="m")
        file["fault"] = label
        file["fault"].attrs["names"] = f"{DYKE} dyke; {FAULT} normal fault"
    sigma = GRADIENT * rows[:, 2]
    write_fields(f"{name}_fields.h5", {"normal_stress": (sigma, "Pa"),
                                       "initial_traction": (np.where(label == FAULT, SHARE * sigma, 0.0), "Pa"),
                                       "rake": (np.where(label == FAULT, -90.0, 0.0), "degrees"),
                                       "friction_drop": (np.where(label == FAULT, DROP, 0.0), "1")})
    over = np.array([-UNDER, pressure * 1e6, pressure * 1e6, -UNDER])  # above the normal stress, the same at all depths
    write_fields(f"{name}_pressure.h5", {"time": (DAY * np.cumsum([0, RISE, HOLD, FALL]), "s"),
                                         "pressure": (np.where(label == DYKE, sigma + over[:, None], 0.0), "Pa")})


def course(run):
    """Times [days], largest opening and mean opening of the dyke, mean and largest slip of the fault [m]; entry of the
    largest opening."""
    times, opening = run.field("opening")
    slip = run.field("slip")[1]
    fault = run.mesh["fault"] == FAULT
    return times / DAY, opening.max(axis=1), opening[:, ~fault].mean(axis=1), slip[:, fault].mean(
        axis=1), slip[:, fault].max(axis=1), int(opening.max(axis=1).argmax())


def draw(run):
    days, widest, mean, slip, _, peak = course(run)
    canvas, axes = plt.subplots(3, 1, figsize=(8, 9), layout="constrained",
                                gridspec_kw={"height_ratios": [1.6, 1, 1.4]})
    dyke, fault = planes_of(run)
    maps = ((dyke, "opening", peak, f"Opening of the dyke after {days[peak]:.1f} days"),
            (fault, "slip", -1, f"Slip of the normal fault after {days[-1]:.0f} days"))
    for panel, (plane, field, row, title) in zip(axes, maps):
        values, kind = plane.values(run.field(field)[1][row]), KINDS["slip"]
        norm = Span().see(values).norm(kind)
        artist = plane.draw(panel, values, norm, kind.colours)
        plane.frame(panel)
        panel.set(title=title, xlabel="along strike (km)")
        colour_bar(canvas, artist, norm, f"{field} (m)", ax=panel)
    first, second = RUN_STYLES[0]["color"], RUN_STYLES[1]["color"]
    axes[2].plot(days, widest, color=first, label="largest opening of the dyke")
    axes[2].plot(days, mean, color=first, linestyle=":", label="mean opening of the dyke")
    axes[2].plot(days, slip, color=second, label="mean slip of the normal fault")
    axes[2].set(xlabel="time (days)", ylabel="m", title="Course", xlim=(0, days[-1]))
    axes[2].legend()
    return canvas


def say(run, events):
    days, widest, _, slip, most, peak = course(run)
    print(f"dyke:               opens by {widest.max():.3f} m at most, after {days[peak]:.1f} days; "
          f"{'closed' if widest[-1] == 0 else f'{widest[-1]:.3f} m open'} at the end")
    print(f"normal fault:       slips by {slip[-1]:.3f} m on average, {most[-1]:.3f} m at most")
    with h5py.File(events) as file:
        onset, magnitude = file["onset"][()] / DAY, file["magnitude"][()]
    for row in zip(onset, magnitude):
        print("event:              after {:.2f} days, magnitude {:.2f}".format(*row))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    commands = parser.add_subparsers(dest="command", required=True)
    making = commands.add_parser("make")
    plotting = commands.add_parser("plot")
    making.add_argument("name")
    making.add_argument("--cell", type=float, default=250.0, help="size of cells [m], default 250")
    making.add_argument("--pressure", type=float, default=6.0,
                        help="of the magma above what presses the dyke together [MPa], default 6")
    plotting.add_argument("name")
    options = parser.parse_args()
    if options.command == "make":
        if not options.cell > 0:
            parser.error(f"--cell is {options.cell:g}, expected a number > 0 [m]")
        make(options.name, options.cell, options.pressure)
        return
    with one_line():
        run = Run(f"{options.name}.h5")
        use_style()
        save(draw(run), f"{options.name}.png")
        say(run, f"{options.name}_events.h5")


if __name__ == "__main__":
    main()
