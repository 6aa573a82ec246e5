"""Pore pressure of wells, for -fault_pore_pressure: from a CSV file with the rates or pressures of any number of wells.

    slipstep wells WELLS.csv OUT.h5 --diffusivity 0.05 --permeability-thickness 1e-13 -- -options_file run.opts
    slipstep wells WELLS.csv OUT.h5 --diffusivity 0.05 --radius 0.1 -- -fault_mesh mesh.h5

WELLS.csv has the columns well (a name), x, y, z [m], days (or hours, s), and MPa (Pa) or m3/day (L/s, m3/s); y may be
left out. A row says what holds from its time on. Columns radius and spread are for -fault_wells. What follows -- are
the options of the fault whose cells are meant.
"""

import argparse
import sys

from ..modules import need

need("scipy")
import numpy as np

from ..checks import PLAUSIBLE, doubt
from ..errors import Error
from ..results.files import write_fields
from ..running import Line, cells_of
from ..times import seconds, written
from ..wells import Pressure, read_wells

MOST = 4e9  # bytes of pressures


def arguments():
    parser = argparse.ArgumentParser(usage="%(prog)s WELLS.csv OUT.h5 --diffusivity D [OPTION ...] [-- OPTION OF THE "
                                           "FAULT ...]", description=__doc__.split("\n")[0],
                                     formatter_class=argparse.RawDescriptionHelpFormatter,
                                     epilog=__doc__.split("\n", 2)[2])
    parser.add_argument("wells", metavar="WELLS.csv")
    parser.add_argument("output", metavar="OUT.h5", help="file for -fault_pore_pressure")
    parser.add_argument("--diffusivity", type=float, required=True, help="hydraulic diffusivity D [m^2/s]")
    parser.add_argument("--permeability-thickness", type=float, metavar="KH",
                        help="of wells with rates: permeability times thickness of the layer, k h [m^3]")
    parser.add_argument("--viscosity", type=float, default=1e-3, help="of the fluid [Pa s] (default 1e-3)")
    parser.add_argument("--radius", type=float, default=0.1, help="of wells with pressures [m] (default 0.1)")
    parser.add_argument("--end", type=seconds, metavar="TIME", help="until when: seconds, or a number with s, min, h, "
                        "d, y (default: twice the last time of WELLS.csv); then the pressure stays")
    parser.add_argument("--accuracy", type=float, default=0.01, help="largest error of the straight lines between the "
                                                                     "times, over the largest pressure (default 0.01)")
    words = sys.argv[1:]
    cut = words.index("--") if "--" in words else len(words)
    options = parser.parse_args(words[:cut])
    options.fault = words[cut + 1:]
    for name in ("diffusivity", "viscosity", "radius", "accuracy", "permeability_thickness", "end"):
        value = getattr(options, name)
        if value is not None and not 0 < value < np.inf:
            parser.error(f"--{name.replace('_', '-')} is {value}, expected a positive number")
        if value is not None and name in PLAUSIBLE:
            doubt(f"--{name.replace('_', '-')}", name, value)
    return options


def main():
    options = arguments()
    wells = read_wells(options.wells)
    if not wells[0].is_pressure and options.permeability_thickness is None:
        raise Error(f"{options.wells} has rates: expected --permeability-thickness")
    if any(well.spread > 0 or (well.is_pressure and well.radius > 0) for well in wells):
        raise Error(f"{options.wells} has a spread, or a radius beside pressures, which are for -fault_wells: "
                    "expected points, and --radius for all")
    last = max(well.time[-1] for well in wells)
    end = options.end or 2 * last
    if end <= max(0.0, *(well.time[0] for well in wells)):
        raise Error(f"--end is {written(end)}, and a well begins later: expected a time after it" if options.end
                    else f"{options.wells} has one time alone: expected --end")
    cells = cells_of(options.fault)
    per_rate = (options.viscosity / (4 * np.pi * options.permeability_thickness) if options.permeability_thickness
                else None)
    pressure = Pressure(wells, options.diffusivity, cells.centres, cells.area.ravel(), end, per_rate, options.radius)
    line = Line(True, apart=not sys.stdout.isatty())
    times, values, error = pressure.record(options.accuracy, line.tell)
    line.close()
    if values.nbytes > MOST:
        raise Error(f"{len(times)} times of {values.shape[1]} cells take {values.nbytes / 1e9:.3g} GB: expected a "
                    "larger --accuracy, or fewer cells")
    shape = (-1,) if cells.mesh else cells.shape
    write_fields(options.output, {"time": (times, "s"), "pressure": (values.reshape(len(times), *shape), "Pa")})
    k, cell = np.unravel_index(values.argmax(), values.shape)
    x, y, z = cells.centres[cell]
    print(f"{len(wells)} well{'s' * (len(wells) > 1)} with {'pressures' if wells[0].is_pressure else 'rates'}, "
          f"{len(times)} times until {written(end)}, {values.shape[1]} cells\n"
          f"Largest pressure: {values.max() / 1e6:.4g} MPa, at {written(times[k])}, x, y, z = {x:.6g}, {y:.6g}, "
          f"{z:.6g} m; straight lines are off by {error / 1e6:.2g} MPa at most\nPressure: {options.output}")
