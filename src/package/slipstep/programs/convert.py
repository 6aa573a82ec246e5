"""Slip models and patches of faults of other programs to files for fault and elastic, and back; it says what it
understood.

    slipstep convert s1992LANDER01COHE.fsp                                  # only says it
    slipstep convert s1992LANDER01COHE.fsp slip.h5 [--figure slip.png]      # cells and slip, for elastic, -fault_mesh
                                                                            # and slipstep surface
    slipstep convert slip.h5 back.fsp                                       # and back
    slipstep convert model.fsp --receivers faults.h5 --stress change.h5     # what its slip does to other faults

IN: .fsp of SRCMOD and the USGS, .param of the USGS, .srf, .inp of Coulomb, .in of HBI and of interact (geom.in),
Input_BulkFaultGeometry.txt of Quake-DFN, parameter.txt of PyQuake3D, .geojson of traces with dip and depths, .xyz and
.grd of depths, meshes (.msh, .ts, .stl, .obj, .h5), .h5 of this program, of a run or of a catalogue with maps. OUT:
.h5, .fsp, .srf. Nothing is written where a file is refused.
"""

import argparse
import os

import numpy as np

from ..checks import check_fields
from ..errors import Error, warn
from ..formats import fsp, ours, said, srf
from ..formats.projection import TMERC, Projection
from ..formats.readers import READERS, read
from ..geometry.geographic import FALSE_POINT
from ..geometry.surface import Elastic, Source
from ..results.files import replacing, write_fields
from ..running import refused_mesh
from ..times import seconds

DIGITS = 1.0  # [m]: of depths in km with three digits and more
WRITERS = {".fsp": fsp.write, ".srf": srf.write}  # of text


def shifted(model):
    """The model moved down until its highest corner is at the ground."""
    above = -float(model.corners[..., 2].min())
    if above > 0:
        model.cells[:, 2] += above
        if model.triangles is not None:
            model.triangles[..., 2] += above
        model.remarks.append(f"moved down by {above:.4g} m")
    return model


def grounded(model):
    """Rectangles of faults that are above the ground by the digits of their file, moved down to it."""
    if model.triangles is not None:
        return
    top = model.corners[..., 2].min(axis=1)
    for label in np.unique(model.fault):
        own = model.fault == label
        above = -float(top[own].min())
        if 0 < above <= DIGITS:
            model.cells[own, 2] += above
            if above > 0.1 * DIGITS:
                model.remarks.append(f"fault {label} is moved down to the ground by {above:.2g} m")


def timed(model, options):
    """Rupture and rise times that the file does not have."""
    model.step = options.step
    if model.slip is not None and options.rupture_speed and "rupture_time" not in model.columns:
        model.columns["rupture_time"] = (np.linalg.norm(model.cells[:, :3] - model.hypocentre(), axis=1)
                                         / options.rupture_speed, "s")
    if model.slip is not None and options.rise_time and "rise_time" not in model.columns:
        model.columns["rise_time"] = (np.full(len(model.cells), options.rise_time), "s")


def of_rigidity(model, given):
    """The model with the rigidity [Pa] of --rigidity in place of its own."""
    if given == "header" and not (model.slip is not None and model.potency > 0 and model.claims.get("moment")):
        raise Error(f"--rigidity is header, but {model.path} has no slip, or no moment in a header: expected a "
                    "number of Pa")
    model.options["shear_modulus"] = model.claims["moment"] / model.potency if given == "header" else given
    model.layers = None
    for name in ("rigidity", "moment"):
        model.columns.pop(name, None)


def rigidity(word):
    """Of --rigidity: header, or a number [Pa]."""
    if word == "header":
        return word
    try:
        value = float(word)
    except ValueError:
        value = 0.0
    if not 1e6 <= value <= 1e13:
        raise argparse.ArgumentTypeError(f"{word}, expected header, or a number from 1e6 to 1e13 Pa")
    return value


def write(model, path, points):
    ending = os.path.splitext(path)[1].lower()
    if ending in (".h5", ".hdf5"):
        check_fields(model.path, {name: values for name, (values, _) in model.fields.items()}, model.options)
        ours.write(model, path, points)
        return
    if ending not in WRITERS:
        raise Error(f"{path}: unknown ending, expected .h5, {', '.join(WRITERS)}")
    if model.slip is None:
        raise Error(f"{model.path} has no slip, expected a slip model for {path}")
    if model.projection is None:
        raise Error(f"{model.path} does not say where it is on the Earth, expected --origin LON LAT of x = y = 0")
    missing = [name for name in ("rupture_time", "rise_time") if name not in model.columns and model.rates is None]
    if ending == ".srf" and missing:
        raise Error(f"{model.path} has no {missing[0]} of its cells, expected "
                    + ("--rupture-speed M/S" if missing[0] == "rupture_time" else "--rise-time S"))
    with replacing(path, model.path) as part, open(part, "w", encoding="utf-8") as file:
        WRITERS[ending](model, file)


def receivers_of(options, model):
    """The cells of another file in the frame of the model."""
    def at(lon, lat):
        return model.projection or Projection(options.origin or (lon, lat), options.projection)

    receivers = read(options.receivers, at, None, options.rake, options.unit)
    if model.projection and receivers.projection is None:
        model.remarks.append(f"x = y = 0 of {options.receivers} is taken to be that of the frame")
    away = np.hypot(*(np.median(receivers.cells[:, :2], axis=0) - np.median(model.cells[:, :2], axis=0)))
    if away > FALSE_POINT:
        warn(f"the cells of {options.receivers} are {away / 1e3:.0f} km from those of {options.input}, as where x and "
             "y are of a map projection (UTM) whose origin is elsewhere: expected one frame")
    mine, theirs = ((p.origin, p.kind) if p else None for p in (model.projection, receivers.projection))
    if mine and theirs and mine != theirs:
        raise Error(f"{options.receivers} has the frame {receivers.projection.words} and {model.path} "
                    f"{model.projection.words}, expected one: --origin LON LAT")
    return receivers


def stress_on(model, receivers, options):
    """Changes of shear and normal stress [Pa] on the receivers' cells, written to a file."""
    if model.slip is None or not np.any(model.slip):
        raise Error(f"{model.path} has no slip{' in any cell' if model.slip is not None else ''}, expected a slip "
                    "model for --stress")
    source = Source(model.path, model.cells, model.rake, model.slip, *model.rock(), "slip", None, model.triangles)
    shear, normal = Elastic(source).tractions(receivers.cells, receivers.rake)
    if options.background:
        depth = receivers.cells[:, 2]
        fields = {name: at_ground + gradient * depth + change for name, at_ground, gradient, change in
                  zip(("initial_traction", "normal_stress"), options.background,
                      options.background_gradient or (0.0, 0.0), (shear, normal))}
        fields["rake"] = receivers.rake
        check_fields("--background", fields)
    else:
        fields = {"shear": shear, "normal": normal, "coulomb": shear - options.friction * normal}
    write_fields(options.stress, {name: (values, "degrees" if name == "rake" else "Pa")
                                  for name, values in fields.items()})
    return shear, normal


def check(parser, options):
    """Refuses options that do not go together."""
    if options.stress and not options.receivers:
        parser.error("--stress is of other faults, expected --receivers FILE")
    if options.background and not options.stress:
        parser.error("--background is for --stress, expected --stress OUT.h5")
    if options.background_gradient and not options.background:
        parser.error("--background-gradient is of --background, expected --background SHEAR NORMAL, as 0 0")
    for name in ("rupture_speed", "rise_time", "step"):
        if getattr(options, name) is not None and not getattr(options, name) > 0:
            parser.error(f"--{name.replace('_', '-')} is {getattr(options, name):g}, expected a number > 0")
    outputs = [os.path.abspath(path) for path in (options.output, options.stress, options.figure) if path]
    for path in (options.input, options.receivers):
        if path and os.path.abspath(path) in outputs:
            parser.error(f"{path} is read and written, expected another name")
    if len(set(outputs)) < len(outputs):
        parser.error("two outputs have one name")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("input", metavar="IN", help="file to read")
    parser.add_argument("output", metavar="OUT", nargs="?",
                        help="file to write, .h5, .fsp or .srf; none: only says what it understood")
    parser.add_argument("--format", choices=tuple(READERS), help="kind of IN (by its name)")
    parser.add_argument("--origin", nargs=2, type=float, metavar=("LON", "LAT"),
                        help="longitude and latitude [degrees] of x = y = 0 (hypocentre or middle of the file)")
    parser.add_argument("--projection", default=TMERC, metavar="P", help="tmerc (default), transverse Mercator about "
                        "the origin by PROJ; sphere; or a coordinate system of PROJ, as EPSG:32611")
    parser.add_argument("--rake", type=float, metavar="DEGREES", help="rake where the file has none")
    parser.add_argument("--rigidity", type=rigidity, metavar="PA", help="of the rock, or header: that by which the "
                        "slip has the moment of the header (what the file says, else 30e9)")
    parser.add_argument("--rupture-speed", type=float, metavar="M/S",
                        help="of .srf, where IN has no rupture times: they are distances from the hypocentre over it")
    parser.add_argument("--rise-time", type=float, metavar="S", help="of .srf, where IN has none")
    parser.add_argument("--step", type=float, default=0.1, metavar="S", help="of slip rates in .srf, at most (0.1)")
    parser.add_argument("--unit", choices=("m", "km"),
                        help="of lengths in files that do not say it: interact, meshes, depths in a grid (km)")
    parser.add_argument("--mesh", metavar="FILE", help="of PyQuake3D (the one beside parameter.txt)")
    parser.add_argument("--event", metavar="N", help="of a catalogue: number from 1 on, or largest (default)")
    parser.add_argument("--window", nargs=2, type=seconds, metavar=("BEGIN", "END"),
                        help="of a run (all of it): seconds, or numbers with s, min, h, d, y")
    parser.add_argument("--shift", action="store_true",
                        help="move cells that rise above the ground down, all by the same")
    parser.add_argument("--receivers", metavar="FILE", help="file of cells of other faults, which IN's slip changes "
                        "the stress of: elastic computes at their centres in place of IN's")
    parser.add_argument("--stress", metavar="OUT.h5", help="write that change: shear along the rakes of --receivers, "
                                                           "normal (compression) and coulomb [Pa], a row for each cell")
    parser.add_argument("--friction", type=float, default=0.4, metavar="MU", help="of the Coulomb stress (0.4)")
    parser.add_argument("--background", nargs=2, type=float, metavar=("SHEAR", "NORMAL"),
                        help="stress [Pa] before: in place of the change --stress has the sum of both, "
                        "initial_traction and normal_stress, and rake, for -fault_parameters")
    parser.add_argument("--background-gradient", nargs=2, type=float, metavar=("SHEAR", "NORMAL"),
                        help="by which the background grows with depth [Pa/m]: --background is that at the ground")
    parser.add_argument("--figure", metavar="PNG", help="picture of the cells and their slip")
    options = parser.parse_intermixed_args()  # options may be between IN and OUT
    check(parser, options)
    return options


def main():
    options = arguments()

    def at(lon, lat):
        return Projection(options.origin or (lon, lat), options.projection)

    model = read(options.input, at, options.format, options.rake, options.unit, options.mesh, event=options.event,
                 window=options.window, step=options.step)
    if options.origin and model.projection is None:
        model.projection = Projection(options.origin, options.projection)
    if options.shift:
        model = shifted(model)
    grounded(model)
    timed(model, options)
    if options.rigidity:
        of_rigidity(model, options.rigidity)
    receivers = receivers_of(options, model) if options.receivers else None
    for name, text in said.lines(model):
        print(f"{name + ':':<20}{text}")
    if options.output:
        write(model, options.output, None if receivers is None else receivers.cells[:, :3])
        print(f"{'written:':<20}{options.output}")
        if options.output.lower().endswith((".h5", ".hdf5")) and (words := refused_mesh(options.output)):
            print(f"{'note:':<20}fault refuses these cells: {words}")
    if options.stress:
        shear, normal = stress_on(model, receivers, options)
        print(f"{'stress:':<20}on {len(shear)} cells of {options.receivers}: shear {said.span(shear, 1e6, 4)} MPa, "
              f"normal {said.span(normal, 1e6, 4)} MPa, written to {options.stress}")
    if options.figure:
        from ..plots.model import draw
        draw(model).savefig(options.figure)
        print(f"{'Figure:':<20}{options.figure}")
