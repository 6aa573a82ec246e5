#!/usr/bin/env python3
"""Make the fields of TPV5 for examples/tpv5.sh, and compare a run of it with a published boundary integral.

    tpv5.py make NAME --cell 300     NAME_fields.h5; prints the numbers of cells along strike and down dip
    tpv5.py plot NAME                NAME.h5 and NAME_events.h5 to a table and NAME.png
"""

import tpv3  # first: it finds the package
import numpy as np
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
    """Distances [m] from the middle and times of rupture along strike at the depths of the table, from those of cells
    [nz, nx]."""
    x, z = centres(times.shape)
    return {way: (x, np.array([np.interp(depth, z, column) for column in times.T])) for way, depth in DEPTHS.items()}


def plot(name):
    tpv3.report(name, PUBLISHED, profiles, "Dunham", (-15, 15))
    print("The mirror image of slip stands for the ground, an approximation")


if __name__ == "__main__":
    tpv3.main(__doc__, make, plot)
