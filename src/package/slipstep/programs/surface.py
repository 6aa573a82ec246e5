"""What slip does to the ground and to other faults: maps of displacement, of the line of sight of a satellite, vectors
at GNSS points, and the change of Coulomb stress, for a run, a part of it, or an event of a catalogue.

    slipstep surface RUN.h5                                            # the whole run: north, east and up
    slipstep surface RUN.h5 --window 113.2y 113.3y --look 257 39       # a part of it, as a satellite in the west sees
                                                                       # it
    slipstep surface EVENTS.h5 --event largest --points stations.txt   # an event (-fault_catalogue_maps) with vectors
                                                                       # at points
    slipstep surface EVENTS.h5 --event 3 --receiver 30 60 90 --depth 8 --friction 0.4
    slipstep surface RUN.h5 --look 257 39 --numbers los.h5             # or los.csv
    slipstep surface SLIP.h5                                           # a slip model of slipstep convert, or another
                                                                       # input of elastic

Formulas are those of the library, by its program elastic (build/bin, or SLIPSTEP_BUILD).
"""

import argparse
import os

import h5py
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize
from matplotlib.patheffects import Normal, withStroke
from ..errors import OutputError
from ..geometry.surface import Elastic, look_vector, slip_of_event, slip_of_input, slip_of_run
from ..plots.maps import colour_bar
from ..plots.panels import plt, use_style
from ..results.catalogue import Catalogue
from ..results.files import is_catalogue, open_any, plain, put, replacing, write_csv
from ..results.run import Run
from ..times import seconds

ACROSS = 81  # points of a map along its longer side
BEYOND = 0.01  # share of a map of stress, infinite along edges of cells, that may be beyond the ends of its colours
UNITS = ((1.0, "m"), (1e-2, "cm"), (1e-3, "mm"))
ARROW = 0.13  # of the map's longer side: the longest vector
HEAD = 0.018  # of the map's longer side: the head of an arrow
SHAFT = 2.5  # an arrow's length over that of its head, at least


def unit_of(size):
    """The unit of length in which a size [m] has a number of 0.5 or more, if there is one."""
    return next((unit for unit in UNITS if size >= 0.5 * unit[0]), UNITS[-1])


class Map:
    """Points of a level rectangle [m]: x north, y east [nx, ny]."""

    def __init__(self, source, extent, spacing, depth):
        corners = source.corners
        (x0, y0, _), (x1, y1, z1) = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        if extent is None:
            margin = 0.5 * max(x1 - x0, y1 - y0, z1)
            extent = x0 - margin, x1 + margin, y0 - margin, y1 + margin
        else:
            extent = [1e3 * km for km in extent]
        self.extent = extent
        spacing = 1e3 * spacing if spacing else max(extent[1] - extent[0], extent[3] - extent[2]) / (ACROSS - 1)
        self.axes = [np.linspace(low, high, max(2, round((high - low) / spacing) + 1))
                     for low, high in (extent[:2], extent[2:])]
        self.x, self.y = np.meshgrid(*self.axes, indexing="ij")
        self.depth = 1e3 * depth

    @property
    def points(self):
        return np.stack([self.x.ravel(), self.y.ravel(), np.full(self.x.size, self.depth)], axis=1)


def points_of(text, path):
    """Points [n, 2] [m] of a list "x,y;x,y", a file as of -fault_surface_stations, or those of the run itself."""
    if text == "":
        with open_any(path) as file:
            points = [[plain(file[f"surface/{name}"].attrs[axis]) for axis in "xy"]
                      for name in sorted(file.get("surface", ()), key=int)]
        if not points:
            raise OutputError(f"{path} has no points of -fault_surface_stations: expected --points FILE or \"x,y;x,y\"")
        return np.array(points)
    if os.path.isfile(text):
        with open(text, encoding="utf-8") as file:
            lines = [(f"{text}, line {k}", line.split("#")[0].strip()) for k, line in enumerate(file, 1)]
        lines = [(where, line) for where, line in lines if line]
    else:
        lines = [("--points", line) for line in text.split(";")]
    points = []
    for where, line in lines:
        try:
            x, y = map(float, line.replace(",", " ", 1).split())
            points.append((x, y))
        except ValueError:
            raise OutputError(f"{where}: \"{line}\", expected a point x,y in m"
                              + ("" if where != "--points" else ", or a file of such lines")) from None
    if not points or not np.isfinite(points).all():
        raise OutputError(f"{text}: expected points x,y in m")
    return np.array(points)


class Picture:
    """Panels of one map, beside each other."""

    def __init__(self, source, plane, count):
        use_style()
        self.source, self.plane = source, plane
        tall = (plane.extent[1] - plane.extent[0]) / (plane.extent[3] - plane.extent[2])
        columns = min(count, 3 if tall > 0.6 else 2)
        rows = -(-count // columns)
        wide = np.clip(11 / columns, 3.6, 7)
        high = np.clip((wide - 0.7) * tall, 2.2, 9) + 1.7  # title and bar
        self.canvas, axes = plt.subplots(rows, columns, figsize=(columns * wide, rows * high + 0.4), squeeze=False,
                                         layout="constrained")
        self.axes = axes.ravel()
        for spare in self.axes[count:]:
            spare.remove()
        self.used = 0

    def draw(self, title, values, label, scale, most=None, depth=None):
        """A map; values and most in the file's unit, scale: of the bar in it; depth: of the map [m]."""
        axes, plane = self.axes[self.used], self.plane
        self.used += 1
        most = (most if most is not None else np.abs(values).max()) / scale or 1.0
        artist = axes.pcolormesh(plane.axes[1] / 1e3, plane.axes[0] / 1e3, values.reshape(plane.x.shape) / scale,
                                 norm=Normalize(-most, most), cmap="RdBu_r", shading="gouraud", rasterized=True)
        upper, others = (edges[:, :, 1::-1] / 1e3 for edges in self.source.outline())  # east, north
        axes.add_collection(LineCollection(others, colors="black", linewidths=0.8, zorder=3))
        axes.add_collection(LineCollection(upper, colors="black", linewidths=2.6, zorder=4, capstyle="round"))
        if depth is not None:
            axes.add_collection(LineCollection(self.source.level(depth)[:, :, 1::-1] / 1e3, colors="black",
                                               linewidths=1.0, linestyles="dashed", zorder=3))
        axes.set(title=title, xlabel="east (km)", aspect="equal", xlim=np.array(plane.extent[2:]) / 1e3,
                 ylim=np.array(plane.extent[:2]) / 1e3)
        if axes.get_subplotspec().is_first_col():
            axes.set_ylabel("north (km)")
        axes.grid(False)
        axes.spines[:].set_visible(True)
        colour_bar(self.canvas, artist, artist.norm, label, ax=axes, location="bottom", shrink=0.9, aspect=28, pad=0.02)
        return axes

    def vectors(self, axes, points, u, scale, unit, norm):
        """Arrows of the horizontal displacement, dots in the colour of the vertical one."""
        length = np.hypot(u[:, 0], u[:, 1]).max() / scale
        key = float(f"{length or 1:.1g}")
        reach = max(self.plane.extent[1] - self.plane.extent[0], self.plane.extent[3] - self.plane.extent[2]) / 1e3
        y, x = points[:, 1] / 1e3, points[:, 0] / 1e3
        axes.scatter(y, x, c=-u[:, 2] / scale, norm=norm, cmap="RdBu_r", s=20, edgecolor="black", linewidth=0.7,
                     zorder=6)
        size = ARROW * reach / (length or 1)  # km for each of the unit
        self.arrows(axes, np.stack([y, x], axis=1), size * u[:, 1::-1] / scale, reach)
        south, north, west, east = np.array(self.plane.extent) / 1e3
        begin = np.array([west + 0.04 * (east - west), south + 0.05 * (north - south)])
        self.arrows(axes, begin[None], np.array([[size * key, 0.0]]), reach)
        axes.text(begin[0] + 0.5 * size * key, begin[1] + 0.012 * reach, f"{key:g} {unit}", ha="center", va="bottom",
                  zorder=8, path_effects=[withStroke(linewidth=3, foreground="white")])

    @staticmethod
    def arrows(axes, begin, vectors, reach):
        """Arrows [n, 2] km from points [n, 2]; heads of short ones are a share of them, so that each has a shaft that
        shows where it goes. Above the points' dots, which would hide the short ones."""
        length = np.linalg.norm(vectors, axis=1)
        begin, vectors, length = begin[length > 0], vectors[length > 0], length[length > 0, None]
        head, along = np.minimum(HEAD * reach, length / SHAFT), vectors / length
        tip, foot, across = begin + vectors, begin + vectors - head * along, 0.4 * head * along[:, ::-1] * [-1, 1]
        halo = [withStroke(linewidth=2.4, foreground="white"), Normal()]
        axes.add_collection(LineCollection(np.stack([begin, foot + 0.2 * head * along], axis=1), colors="black",
                                           linewidths=1.3, path_effects=halo, zorder=7))
        axes.add_collection(PolyCollection(np.stack([tip, foot + across, foot - across], axis=1), facecolors="black",
                                           edgecolors="white", linewidths=0.4, zorder=7))


def numbers_of(target, source, plane, on_map, points, at_points):
    """HDF5 with groups /map and /points, or CSV with a line for each of the points, or of the map where none are given.
    What is in both dicts: (array, unit, columns)."""
    if target.endswith(".csv"):
        where, columns = (points, at_points) if at_points else (plane.points[:, :2], on_map)
        head, table = ["x [m]", "y [m]"], [*where.T]
        for name, (data, unit, parts) in columns.items():
            for k, part in enumerate(parts or [""]):
                head.append(f"{name}{part and '_' + part} [{unit}]")
                table.append(data.reshape(len(where), -1)[:, k])
        write_csv(target, [head, *zip(*(column.tolist() for column in table))])
    else:
        with replacing(target) as out, h5py.File(out, "w") as file:
            file.attrs["source"], file.attrs["slip"] = source.path, source.words
            for group, axes, columns in (("map", plane.axes, on_map),
                                         ("points", points.T if at_points else [], at_points)):
                for name, (data, unit, parts) in columns.items():
                    shape = plane.x.shape if group == "map" else (len(points),)
                    put(file, f"{group}/{name}", data.reshape(shape + ((len(parts),) if parts else ())), unit)
                for name, axis in zip("xy", axes if columns else []):
                    put(file, f"{group}/{name}", axis, "m")
            if "map" in file:
                file["map"].attrs["stress_depth"] = plane.depth


def draw(source, options, points):
    """The figure, and what is drawn on the map and at the points."""
    elastic = Elastic(source, options.ranks)
    depth = options.depth if options.depth is not None else 0.5e-3 * (source.corners[..., 2].min()
                                                                      + source.corners[..., 2].max())
    plane = Map(source, options.extent, options.spacing, depth)
    parts = ["north", "east", "down"]
    components = options.components or not (options.look or options.receiver or points is not None)
    on_map, at_points, panels = {}, {}, []
    if components or options.look or points is not None:
        u = elastic.displacement(plane.points * [1, 1, 0])
        on_map["displacement"] = u, "m", parts
        size = unit_of(np.abs(u).max())
        if components:
            panels += [(name.capitalize(), sign * u[:, k], f"displacement ({size[1]})", size[0], None)
                       for name, sign, k in
                       (("north", 1, 0), ("east", 1, 1), ("up", -1, 2))]
        if options.look:
            seen = u @ look_vector(*options.look)
            on_map["line_of_sight"] = seen, "m", None
            size = unit_of(np.abs(seen).max())
            panels.append(("Towards a satellite\nazimuth {:g}°, incidence {:g}°".format(*options.look), seen,
                           f"line of sight ({size[1]})", size[0], None))
    if options.receiver:
        on_map["coulomb"], on_map["shear"], on_map["normal"] = ((values, "Pa", None)
                                                                for values in elastic.coulomb(
                                                                    plane.points, options.receiver, options.friction))
        stress = on_map["coulomb"][0]
        title = "Coulomb stress at {:g} km, μ = {:g}\nstrike {:g}°, dip {:g}°, rake {:g}°".format(
            round(depth, 3), options.friction, *options.receiver)
        panels.append((title, stress, "ΔCFS (MPa)", 1e6, np.quantile(np.abs(stress), 1 - BEYOND), plane.depth))
    picture = Picture(source, plane, len(panels) + (points is not None))
    for panel in panels:
        picture.draw(*panel)
    if points is not None:
        at = np.column_stack([points, np.zeros(len(points))])
        u_at = elastic.displacement(at)
        at_points["displacement"] = u_at, "m", parts
        if options.look:
            at_points["line_of_sight"] = u_at @ look_vector(*options.look), "m", None
        size = unit_of(np.abs(u).max())
        axes = picture.draw("Arrows: horizontal\nColours: up", -u[:, 2], f"up ({size[1]})", size[0])
        picture.vectors(axes, points, u_at, *size, axes.collections[0].norm)
    picture.canvas.suptitle(f"{os.path.basename(source.path)}: {source.words}")
    return picture.canvas, plane, on_map, at_points


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0],
                                     epilog="\n\n".join(__doc__.split("\n\n")[1:]),
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", metavar="FILE", help="output of a run, or catalogue with maps (-fault_catalogue_maps)")
    parser.add_argument("--figure", metavar="PNG", help="file to write, default FILE with _surface and --event, look, "
                        "points and receiver where they are drawn, as "
                        "_surface_look.png; its ending chooses the format (png, pdf, svg)")
    parser.add_argument("--numbers", metavar="OUT", help="write what is drawn to OUT.h5 or OUT.csv: x north, y east "
                                                         "[m], displacement north, east, down [m], stress [Pa]")
    parser.add_argument("--window", nargs=2, type=seconds, metavar=("BEGIN", "END"),
                        help="part of a run: seconds, or a number with s, min, h, d, y; default all")
    parser.add_argument("--field", choices=("displacement", "slip"), help="quantity of a run: displacement, relative "
                        "to the far field, as stations have it (default), or slip")
    parser.add_argument("--event", metavar="N", help="event of a catalogue: its number from 1 on, or largest (default)")
    parser.add_argument("--components", action="store_true",
                        help="north, east and up, default without --look, --points and --receiver")
    parser.add_argument("--look", nargs=2, type=float, metavar=("AZIMUTH", "INCIDENCE"),
                        help="line of sight, positive towards the satellite: azimuth, clockwise "
                        "from north, of the direction from the ground to it, and incidence from the vertical, degrees. "
                        "A satellite with the heading h "
                        "that looks to its right is at the azimuth h - 90: 257 39 is about Sentinel-1, ascending")
    parser.add_argument("--points", nargs="?", const="", metavar="FILE",
                        help="vectors at points: a file with a point x,y or x y [m] on each line, or \"x,y;x,y\"; "
                        "without FILE those of -fault_surface_stations")
    parser.add_argument("--receiver", nargs=3, type=float, metavar=("STRIKE", "DIP", "RAKE"),
                        help="change of Coulomb stress on planes of this direction, degrees: "
                        "shear stress along the rake less friction times normal stress, positive in compression")
    parser.add_argument("--depth", type=float, metavar="KM", help="of these planes, default the middle of the fault")
    parser.add_argument("--friction", type=float, default=0.4, help="of these planes, default 0.4")
    parser.add_argument("--extent", nargs=4, type=float, metavar=("SOUTH", "NORTH", "WEST", "EAST"),
                        help="of the map [km], default the fault and half of its extent around")
    parser.add_argument("--spacing", type=float, metavar="KM",
                        help=f"of the map's points, default {ACROSS} on the longer side")
    parser.add_argument("--ranks", type=int, default=1, help="processes that compute, default 1")
    options = parser.parse_args()
    check(parser, options)
    return options


def check(parser, options):
    """Values that make no sense."""
    if options.window and not options.window[0] < options.window[1]:
        parser.error("--window is {:g} {:g}, expected the earlier time first".format(*options.window))
    if options.extent and not (options.extent[0] < options.extent[1] and options.extent[2] < options.extent[3]):
        parser.error("--extent is {:g} {:g} {:g} {:g}, expected south, north, west, east in km".format(*options.extent))
    if options.look and not 0 <= options.look[1] < 90:
        parser.error(f"--look has the incidence {options.look[1]:g}, expected degrees from the vertical, from 0 "
                     "to below 90")
    if options.receiver and not 0 <= options.receiver[1] <= 90:
        parser.error(f"--receiver has the dip {options.receiver[1]:g}, expected degrees from 0 to 90")
    if options.depth is not None and not options.receiver:
        parser.error("--depth is that of planes: expected with --receiver")
    for name, least in (("spacing", 0), ("ranks", 0.5), ("depth", -1e-300), ("friction", -1e-300)):
        value = getattr(options, name)
        if value is not None and not value > least:
            parser.error(f"--{name} is {value:g}, expected a number {'>' if least == 0 else '>='} "
                         f"{max(0, round(least + 0.1))}")
    if options.numbers and not options.numbers.endswith((".h5", ".csv")):
        parser.error(f"--numbers is {options.numbers}, expected a name that ends with .h5 or .csv")
    if options.event not in (None, "largest") and not options.event.isdigit():
        parser.error(f"--event is {options.event}, expected a number from 1 on, or largest")


def suffix_of(options):
    """What tells pictures of one file apart: the event, and what is drawn besides displacement."""
    event = f"_event_{options.event}" if options.event not in (None, "largest") else ""
    return event + "".join(f"_{name}" for name in ("look", "points", "receiver") if getattr(options, name) is not None)


def source_of(options):
    """The slip that is asked for."""
    with open_any(options.file) as file:
        of_events, of_input = is_catalogue(file), "slip" in file and "mesh" not in file
    if of_input and not of_events:
        if options.event or options.window or options.field:
            raise OutputError(f"{options.file} has slip of one time, expected no --event, --window or --field")
        return slip_of_input(options.file)
    if not of_events:
        if options.event:
            raise OutputError(f"--event is one of a catalogue, but {options.file} is none: expected the file of "
                              "-fault_catalogue, or --window")
        run = Run(options.file)
        run.warn()
        return slip_of_run(run, *(options.window or (None, None)), options.field or "displacement")
    for name in ("window", "field"):
        if getattr(options, name):
            raise OutputError(f"--{name} is of a run, but {options.file} is a catalogue: expected --event")
    catalogue = Catalogue(options.file)
    return slip_of_event(catalogue, catalogue.number_of(options.event or "largest"))


def main():
    options = arguments()
    target = options.figure or f"{os.path.splitext(options.file)[0]}_surface{suffix_of(options)}.png"
    source = source_of(options)
    points = None if options.points is None else points_of(options.points, options.file)
    canvas, plane, on_map, at_points = draw(source, options, points)
    canvas.savefig(target)
    south, north, west, east = plane.extent
    outside = 0 if points is None else int(((points < (south, west)) | (points > (north, east))).any(axis=1).sum())
    print(f"Figure: {target}" + (f", without {outside} of {len(points)} points that are outside of the map (--extent)"
                                 if outside else ""))
    if options.numbers:
        numbers_of(options.numbers, source, plane, on_map, points, at_points)
        print(f"Numbers: {options.numbers}")
