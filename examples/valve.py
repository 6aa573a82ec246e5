#!/usr/bin/env python3
"""Make the fields for -fault_parameters of examples/valve.opts, a fault that is a valve of rising fluid.

    valve.py OUT.h5
"""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "package"))
from slipstep.modules import need, one_line

need("h5py", "numpy")
import numpy as np
from slipstep.results.files import write_fields

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


def main():
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} OUT.h5")
    write_fields(sys.argv[1], fields())


if __name__ == "__main__":
    with one_line():
        main()
