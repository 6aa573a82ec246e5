#!/usr/bin/env python3
"""Fields for -fault_parameters of the benchmarks of SEAS, Sequences of Earthquakes and Aseismic Slip
(strike.scec.org/cvws/seas); prints the numbers of cells along strike and in depth.

    make_seas.py bp4 OUT.h5 --cell 1000       BP4-QD: 100 km x 80 km of a full space
    make_seas.py bp5 OUT.h5 --cell 2000       BP5-QD: 100 km x 40 km
    make_seas.py bp1 OUT.h5 --cell 200        BP1-QD: one long cell along strike, 40 km deep
    make_seas.py bp3 OUT.h5 --cell 100        BP3-QD: likewise, 40 km along the dip
    make_seas.py bp6 OUT.h5 --cell 100        BP6-QD: likewise, 40 km around the injection, and OUT_pressure.h5 for
                                              -fault_pore_pressure
    make_seas.py bp7 OUT.h5 --cell 10         BP7-QD-A: 800 m x 800 m

Values that are the same in all cells are in examples/seas_*.opts. A cell of BP4, BP5 or BP7 has the parameters of its
centre.
"""

import argparse
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need

need("h5py", "numpy")
import h5py
import numpy as np
from slipstep.results.files import write_fields
from slipstep.results.seas import ORIGIN, STOP, pressure

DEPTH, STRIKE = 40e3, 100e3  # of the faults, and of BP4 and BP5 [m]
WHOLE = 80e3  # of BP4, in depth [m]
SIDE = 800.0  # of BP7 [m]
END = 2 * 3.15576e7  # of the record of pressure [s]: the benchmark's two years


def centres(length, cell):
    return (np.arange(round(length / cell)) + 0.5) * cell


def bp5(cell):
    """a = 0.004 in the core |x| < 30 km, 4 km < z < 16 km, 0.04 beyond a transition of 2 km; the patch at the western
    end of the core begins at 0.03 m/s and has a shorter d_c. theta = d_c/(1e-9 m/s) everywhere."""
    x, z = np.meshgrid(centres(STRIKE, cell) - STRIKE / 2, centres(DEPTH, cell))
    share = np.clip(np.maximum(abs(z - 10e3) - 6e3, abs(x) - 30e3) / 2e3, 0, 1)
    patch = (x > -30e3) & (x < -18e3) & (z > 4e3) & (z < 16e3)
    slip = np.where(patch, 0.13, 0.14)
    return {"friction_a": (0.004 + share * 0.036, "1"), "friction_slip": (slip, "m"),
            "initial_rate": (np.where(patch, 0.03, 1e-9), "m/s"), "initial_state": (slip / 1e-9, "s")}


def bp4(cell):
    """a = 0.0065 for |x2| < 30 km and |x3| < 15 km, 0.025 beyond a transition of 3 km. The same shear stress
    everywhere, with which cells that strengthen slip at 1e-9 m/s, gives the state of each; a square of 12 km in a
    corner begins at 0.03 m/s, as the codes that were compared have it."""
    x, z = np.meshgrid(centres(STRIKE, cell) - STRIKE / 2, centres(WHOLE, cell) - WHOLE / 2)
    a = 0.0065 + np.clip(np.maximum(abs(z) - 15e3, abs(x) - 30e3) / 3e3, 0, 1) * 0.0185
    patch = (abs(x + 22.5e3) < 6e3) & (abs(z + 7.5e3) < 6e3)
    sigma, b, slip, rate, reference = 50e6, 0.013, 0.04, 1e-9, 1e-6
    steady = sigma * 0.025 * np.arcsinh(rate / (2 * reference) * np.exp((0.6 + b * math.log(reference / rate)) / 0.025))
    theta = slip / reference * np.exp((a * np.log(2 * reference / rate * np.sinh(steady / (a * sigma))) - 0.6) / b)
    return {"friction_a": (a, "1"), "initial_rate": (np.where(patch, 0.03, rate), "m/s"), "initial_state": (theta, "s")}


def bp1(cell):
    """a = 0.010 above 15 km, 0.025 below 18 km, linear between: BP1's depth, BP3's distance along the dip."""
    z = centres(DEPTH, cell)[:, None]
    return {"friction_a": (np.interp(z, [15e3, 18e3], [0.010, 0.025]), "1")}


def bp6(cell):
    """Uniform: what varies is the pressure."""
    return {"friction_a": (np.full((round(DEPTH / cell), 1), 0.007), "1")}


def bp7(cell):
    """a = 0.004 within 200 m of the middle, 0.016 beyond. Steady at 1e-9 m/s along strike, and at (-50, -50) m up to
    1.75 MPa of shear stress more."""
    x, z = np.meshgrid(centres(SIDE, cell) - SIDE / 2, centres(SIDE, cell) - SIDE / 2)
    a = np.where(np.hypot(x, z) <= 200, 0.004, 0.016)
    sigma, b, slip, rate, reference, damping = 25e6, 0.010, 5e-4, 1e-9, 1e-6, 0.5 * math.sqrt(32.03812e9 * 2670)
    steady = (sigma * a * np.arcsinh(rate / (2 * reference) * np.exp((0.6 + b * math.log(reference / rate)) / a))
              + damping * rate)
    r2 = (x + 50) ** 2 + (z + 50) ** 2
    inside = r2 < 150.0 ** 2
    more = np.where(inside, 1.75e6 * np.exp(r2 / np.where(inside, r2 - 150.0 ** 2, -1)), 0)
    return {"friction_a": (a, "1"), "initial_traction": (steady + more, "Pa"),
            "initial_state": (np.full_like(a, slip / rate), "s")}


def record():
    """Times [s] of the record, which is linear between: dense where the pressure goes as a root of time."""
    return np.unique(np.concatenate([STOP * np.linspace(0, 1, 201) ** 2,
                                     STOP + (END - STOP) * np.linspace(0, 1, 301) ** 2]))


MAKE = {"bp1": bp1, "bp3": bp1, "bp4": bp4, "bp5": bp5, "bp6": bp6, "bp7": bp7}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("benchmark", choices=sorted(MAKE))
    parser.add_argument("output", metavar="OUT.h5")
    parser.add_argument("--cell", type=float, required=True, metavar="M", help="side of the cells, in depth [m]")
    a = parser.parse_args()
    # edges of cells are where the properties of BP5 change
    unit = {"bp1": 1e3, "bp3": 1e3, "bp4": 1e3, "bp7": 100.0}.get(a.benchmark, 4e3)
    if not a.cell > 0 or abs(unit / a.cell - round(unit / a.cell)) > 1e-9:
        parser.error(f"--cell is {a.cell:g} m, expected {unit:g} m or a whole part of it, as {unit / 2:g} or "
                     f"{unit / 4:g}")
    return a


def main():
    a = arguments()
    made = MAKE[a.benchmark](a.cell)
    try:
        write_fields(a.output, made)
    except OSError as error:
        sys.exit(f"make_seas.py: {a.output}: {error}")
    if a.benchmark == "bp6":
        z, times = centres(DEPTH, a.cell) - ORIGIN["bp6"], record()
        with h5py.File(os.path.splitext(a.output)[0] + "_pressure.h5", "w") as file:
            file["time"] = times
            file["pressure"] = np.array([pressure(z, t) for t in times])[:, :, None]
    rows, columns = made["friction_a"][0].shape
    print(columns, rows)


if __name__ == "__main__":
    main()
