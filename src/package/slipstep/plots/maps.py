"""Maps of a fault: its planes of equal or irregular cells, drawn flat along strike and down dip, their colours and
contours."""

import numpy as np
from matplotlib.collections import Collection, PolyCollection
from matplotlib.colors import LogNorm, Normalize
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from ..errors import OutputError
from ..geometry.cells import axis_along_strike, mesh_cells, normals
from ..geometry.unroll import unroll
from ..results.fields import Fields
from .panels import plt, wrapped

DIGITS = 9  # of coordinates of unrolled cells [km], so that edges of a row are equal
DECADES = 13  # of a logarithmic scale at most
FEW = 0.01  # of all cells, at either end of a scale, are few
STRETCHED = 2 / 3  # where those few need a scale longer than the others' by more than half, they are beyond it
NUMBERS = 6  # contours with their values
SIDES = np.arange(1, 8) / 8  # of a side: where it is looked whether that is within cells
WIDER = 1.01
BENT = 1.0  # degrees of a surface that is no plane
SHADES = 256  # of a colour map: what is beyond its ends by less than one is not
NOISE = {"m": 1e-9}  # by unit: sizes that are rounding
EXTEND = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}


def edges(centres, others, length=None):
    """Edges of equal cells from their centres; of a single row by its length, or as those of squares."""
    if len(centres) == 1 and length:
        return centres[0] + np.array([-0.5, 0.5]) * length
    spaced = centres if len(centres) > 1 else others
    half = 0.5 * (spaced[1] - spaced[0]) if len(spaced) > 1 else 0.5 * max(abs(centres[0]), 1e-3)
    return np.append(centres - half, centres[-1] + half)


def aspect_of(extent):
    """Of a map with these limits: equal scales, unless the fault would be a line, as those of nearly two dimensions."""
    x0, x1, z0, z1 = extent
    return "equal" if 0.1 < abs((z1 - z0) / (x1 - x0)) < 10 else "auto"


class Plane:
    """Cells that are drawn together: low and high edges along strike and down dip, or three corners of triangles [km],
    which of a map's values are theirs (None: all, of a grid of this shape), what they are called, also in short,
    whether down dip is the depth, and whether they are of a bent surface, seen across its mean plane."""

    def __init__(self, x, z, cells=None, shape=None, name="", vertical=True, short="", bent=False):
        self.x, self.z, self.cells, self.shape, self.name, self.vertical, self.short, self.bent = (
            x, z, cells, shape, name, vertical, short or name, bent)

    @classmethod
    def of_grid(cls, run):
        """All of a grid, which down dip begins at its upper edge."""
        x, z = run.axes[0] / 1e3, run.mesh.get("down_dip", run.axes[1]) / 1e3
        length, width = (run.extents.get(name, 0) / 1e3 for name in ("length_x", "length_z"))
        x, z = edges(x, z, length), edges(z, x, width)
        shape = len(z) - 1, len(x) - 1
        x, z = (np.stack([e[:-1], e[1:]]) for e in (x, z))
        return cls(np.tile(x, shape[0]), np.repeat(z, shape[1], axis=1), shape=shape,
                   vertical="down_dip" not in run.mesh)

    @property
    def down(self):
        return "depth" if self.vertical else "down the mean dip" if self.bent else "down dip"

    @property
    def along(self):
        return "along the mean strike" if self.bent else "along strike"

    @property
    def along_label(self):
        return f"{self.along} (km)"

    @property
    def down_label(self):
        return f"{self.down} (km)"

    def centre(self, cell):
        """Along strike and down dip [km] of a cell of the grid or mesh; None where it is of another plane."""
        own = np.arange(self.x.shape[1]) if self.cells is None else self.cells
        found = np.flatnonzero(own == cell)
        return (self.x[:, found[0]].mean(), self.z[:, found[0]].mean()) if len(found) else None

    def values(self, maps):
        """Those of its cells, [..., N], from maps [..., Nz, Nx] or [..., N]."""
        return maps.reshape(*maps.shape[:-2], -1) if self.cells is None else maps[..., self.cells]

    def draw(self, axes, values, norm, colours):
        """Values of its cells [N]; the artist, whose set_array() takes others."""
        colours = colour_map(colours)
        around = ([0, 1, 1, 0], [0, 0, 1, 1]) if len(self.x) == 2 else ([0, 1, 2], [0, 1, 2])
        corners = np.stack([self.x[around[0]], self.z[around[1]]], axis=-1).swapaxes(0, 1)
        if self.shape:
            extent = (self.x.min(), self.x.max(), self.z.max(), self.z.min())
            artist = axes.imshow(values.reshape(self.shape), norm=norm, cmap=colours, extent=extent,
                                 interpolation="nearest")
            take = artist.set_data
            artist.show = lambda new: take(new.reshape(self.shape))
        else:
            artist = PolyCollection(corners, array=values, norm=norm, cmap=colours, edgecolor="face", linewidth=0.2)
            axes.add_collection(artist)
            artist.show = artist.set_array
        axes.set(aspect=aspect_of(self.extent), ylabel=self.down_label)
        axes.spines[:].set_visible(True)
        axes.grid(False)
        return artist

    def between(self):
        """Triangles between the centres of neighbouring cells: none across a notch or a hole."""
        x, z = self.x.mean(axis=0), self.z.mean(axis=0)
        # so that flat cells have their neighbours beside them
        size = [np.median(np.ptp(sides, axis=0)) for sides in (self.x, self.z)]
        mesh = Triangulation(x / size[0], z / size[1])
        near = np.concatenate([mesh.triangles, opposite(mesh)], axis=1)
        corners = np.stack([x, z], axis=-1)[mesh.triangles]
        inside = np.ones(len(near), bool)
        for share in SIDES:  # points of its sides are in cells of its corners, or of the triangles beside it
            points = corners + share * (np.roll(corners, -1, axis=1) - corners)
            inside &= np.array([self.within(near, points[:, side]).any(axis=1) for side in range(3)]).all(axis=0)
        return Triangulation(x, z, mesh.triangles, mask=~inside)

    def within(self, cells, points):
        """Whether points [n, 2] are in cells [n, m], [n, m]; their edges, widened by a hundredth, count."""
        x, z = self.x[:, cells], self.z[:, cells]
        px, pz = points[:, :1], points[:, 1:]
        if len(x) == 2:
            return ((np.abs(px - x.mean(axis=0)) <= WIDER * 0.5 * (x[1] - x[0]))
                    & (np.abs(pz - z.mean(axis=0)) <= WIDER * 0.5 * (z[1] - z[0])))
        px, pz = (x.mean(axis=0) + (px - x.mean(axis=0)) / WIDER, z.mean(axis=0) + (pz - z.mean(axis=0)) / WIDER)
        turn = np.array([(x[(k + 1) % 3] - x[k]) * (pz - z[k]) - (z[(k + 1) % 3] - z[k]) * (px - x[k])
                         for k in range(3)])
        return (turn >= 0).all(axis=0) | (turn <= 0).all(axis=0)

    def contour(self, axes, values, levels):
        """Lines of equal value through centres of cells, some numbered; none at nan and outside of cells."""
        x, z = self.x.mean(axis=0), self.z.mean(axis=0)
        good = np.isfinite(values)
        if good.sum() < 4 or np.ptp(x[good]) == 0 or np.ptp(z[good]) == 0:
            return
        style = {"levels": levels, "colors": "black", "linewidths": 0.9}
        if self.shape and min(self.shape) > 1:
            lines = axes.contour(x.reshape(self.shape)[0], z.reshape(self.shape)[:, 0], values.reshape(self.shape),
                                 **style)
        else:
            mesh = self.between()
            mesh.set_mask(mesh.mask | ~good[mesh.triangles].all(axis=1))
            if mesh.mask.all():
                return
            lines = axes.tricontour(mesh, np.where(good, values, 0), **style)
        halo = [withStroke(linewidth=2.2, foreground="white", alpha=0.7)]
        # one artist from Matplotlib 3.8 on
        for line in [lines] if isinstance(lines, Collection) else lines.collections:
            line.set_path_effects(halo)
        named = lines.levels[:: -(-len(lines.levels) // NUMBERS)]
        plt.setp(axes.clabel(lines, named, fmt="%g", fontsize=8), path_effects=halo)

    def frame(self, axes, extent=None):
        """Limits of its own, or those shared with others."""
        low_x, high_x, low_z, high_z = extent or self.extent
        axes.set(xlim=(low_x, high_x), ylim=(high_z, low_z))
        axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
        axes.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))

    @property
    def extent(self):
        return self.x.min(), self.x.max(), self.z.min(), self.z.max()


def opposite(mesh):
    """Of each triangle the corners [n, 3] opposite to it beyond its sides; at the rim its own."""
    beside = mesh.neighbors
    total = mesh.triangles.sum(axis=1)
    # neighbour k is across the side from corner k to the next one
    shared = mesh.triangles + np.roll(mesh.triangles, -1, axis=1)
    return np.where(beside >= 0, total[beside] - shared, mesh.triangles)


def span(angles, turn):
    """Angles in words: one, or from the least to the largest; those that turn may pass 360."""
    middle = np.degrees(np.angle(np.exp(1j * np.radians(angles)).mean())) if turn else 0.0
    around = (angles - middle + 180) % 360 - 180 if turn else angles
    low, high = (f"{round(float(value + middle) % 360 if turn else float(value), 1) % (360 if turn else 1e9):g}"
                 for value in (around.min(), around.max()))
    return f"{low}°" if low == high else f"{low} to {high}°"


def names_of(run, label, cells, part):
    """Of a plane of several: with its strike and dip, and in short."""
    short = run.fault_name(label) + part
    return {"name": f"{short} (strike {span(run.mesh['strike'][cells], True)}, dip "
                    f"{span(run.mesh['dip'][cells], False)})", "short": short}


def planes_of(run):
    """The planes of a run, front to back; of a mesh with dips its faults, flat as by geometry.unroll."""
    if not hasattr(run, "drawn"):
        run.drawn = _planes(run)
    return run.drawn


def flat_triangles(mesh, cells):
    """Corners [3, N] of triangles across their mean plane, from their highest down [m]; whether it bends."""
    corners = mesh["vertices"][mesh["triangles"][cells]]
    across = normals(corners)
    size = np.linalg.norm(across, axis=1)
    # of the mean plane, whichever way the corners go round
    normal = np.linalg.eigh((across / size[:, None]).T @ across)[1][:, -1]
    strike = np.radians(axis_along_strike(mesh["strike"][cells], size))
    along, right = np.array([np.cos(strike), np.sin(strike), 0]), np.array([-np.sin(strike), np.cos(strike), 0])
    down = np.cross(normal, along)
    down /= np.linalg.norm(down) * (np.sign(down[2] if abs(down[2]) > 1e-9 else down @ right) or 1)
    s, d = corners @ along, corners @ down
    bent = bool((np.abs(across @ normal) < np.cos(np.radians(BENT)) * size).any())
    return s.T, (d - d.min() + corners[..., 2].min() * (abs(normal[2]) < 1e-6)).T, bent


def _planes(run):
    if not run.planes:
        return [Plane.of_grid(run)]
    if "triangles" in run.mesh:
        found = []
        for label, cells in run.planes:
            s, d, bent = flat_triangles(run.mesh, cells)
            found.append(Plane(s / 1e3, d / 1e3, cells, **(names_of(run, label, cells, "") if len(run.planes) > 1
                                                           else {}), vertical=False, bent=bent))
        return found
    found, every, mesh = [], mesh_cells(run.mesh), run.mesh
    for label, cells in run.planes:
        if "dip" in mesh:
            parts = unroll(every[cells])
            for k, (index, s, d) in enumerate(parts):
                own = cells[index]
                names = names_of(run, label, own, f", part {k + 1}" if len(parts) > 1 else "")
                found.append(Plane(np.round(s / 1e3, DIGITS), np.round(d / 1e3, DIGITS), own, **names,
                                   vertical=(mesh["dip"][own] == 90).all()))
        else:  # vertical, and along x
            x, z, length, width = (mesh[name][cells] / 1e3 for name in ("x", "z", "length", "width"))
            name = run.fault_name(label) if "fault" in mesh else f"plane at y = {label:g} m"
            found.append(Plane(np.stack([x - length / 2, x + length / 2]), np.stack([z - width / 2, z + width / 2]),
                               cells, name=name))
    if len(found) == 1:
        found[0].name = ""
    return found


def extent_of(planes):
    """Limits that hold every plane."""
    x0, x1, z0, z1 = np.array([plane.extent for plane in planes]).T
    return x0.min(), x1.max(), z0.min(), z1.max()


def beside(run):
    """Whether the places of all planes are those of one map: there is one, or they are vertical and along x."""
    return len(planes_of(run)) == 1 or "dip" not in run.mesh


def frames_of(run, tall=False):
    """Limits of each plane's map: shared ones where x is, else its own at one scale; tall: and as wide."""
    planes = planes_of(run)
    if beside(run):
        return [extent_of(planes)] * len(planes)
    x0, x1, z0, z1 = np.array([plane.extent for plane in planes]).T
    z1 = z0 + (z1 - z0).max() if tall else z1
    return list(zip(x0, x0 + (x1 - x0).max(), z0, z1))


class Nothing(Normalize):
    """Colours of a field that is zero, or rounding, everywhere: the bar has a 0 and no number that nothing has."""


def norm_of(kind, low, high, smallest, log=False, wanted=None):
    """Colours for values from low to high; smallest: about the least positive one; wanted: the user's limits."""
    if not wanted and max(abs(low), abs(high)) <= NOISE.get(kind.unit, 0):
        return Nothing(-1 if kind.limits == "even" else 0, 1)
    if wanted:
        low, high = wanted
        if log and low <= 0:
            raise OutputError(f"--range begins at {low:g}, expected a number > 0 on a logarithmic scale "
                              "(--no-log-rate: a linear one)")
        return LogNorm(low, high) if log else Normalize(low, high)
    if log:
        # what creeps is not as what rests
        bottom = 10.0 ** np.floor(np.log10(smallest if 0 < smallest < high else high) - 0.3)
        return LogNorm(min(max(bottom, high * 10.0 ** -DECADES), high / 100), high)
    if kind.limits == "even":
        high = max(abs(low), abs(high)) or 1.0
        return Normalize(-high, high)
    if kind.limits == "zero":
        low, high = min(0.0, low if low < -0.01 * high else 0.0), max(high, 0.0)
    return Normalize(low, high if high > low else low + (abs(low) or 1.0))


def colour_map(name):
    """A map of colours in which the logarithm of 0 counts as below the scale."""
    colours = plt.get_cmap(name).copy()
    colours.set_bad(colours(0.0))
    return colours


class Span:
    """Least, largest and about the least positive value of maps, and between what nearly all values are."""

    def __init__(self):
        self.low, self.high, self.smallest = np.inf, -np.inf, []
        self.most = np.array([np.inf, -np.inf])

    def see(self, values):
        values = values[np.isfinite(values)]
        self.low, self.high = min(self.low, values.min()), max(self.high, values.max())
        low, high = np.quantile(values, (FEW, 1 - FEW), method="closest_observation")
        self.most = np.array([min(self.most[0], low), max(self.most[1], high)])
        positive = values[values > 0]
        if len(positive):
            self.smallest.append(np.quantile(positive, 0.05))
        return self

    def norm(self, kind, log=False, wanted=None):
        """Of a field with values of both signs, single cells do not choose the scale where they would stretch it."""
        low, high = self.low, self.high
        if kind.limits == "even" and 0 < abs(self.most).max() < STRETCHED * max(abs(low), abs(high)):
            low, high = self.most
        return norm_of(kind, low, high, np.quantile(self.smallest, 0.05) if self.smallest else 0.0, log, wanted)


def colour_bar(canvas, artist, norm, label, extend=None, **place):
    """A bar with arrows towards values beyond it, and below a logarithmic scale: a cell at rest has the slip rate 0."""
    if extend is None:
        values = artist.get_array()
        least = 0 if isinstance(norm, LogNorm) else (norm.vmax - norm.vmin) / SHADES
        extend = EXTEND[isinstance(norm, LogNorm) or np.nanmin(values) < norm.vmin - least,
                        np.nanmax(values) > norm.vmax + least]
    bar = canvas.colorbar(artist, label=label, extend=extend, **place)
    if isinstance(norm, Nothing):
        bar.set_ticks([0])
    elif not isinstance(norm, LogNorm):
        bar.locator = MaxNLocator(6, steps=[1, 2, 5, 10])
        bar.formatter.set_powerlimits((-3, 4))
        bar.update_ticks()
    return bar


PANEL = 1.6  # width over height of a panel of the overview, about
PANEL_WIDTH = 4.6  # inches, of the maps of several planes, without their bar
ROOM = 0.75  # inches above and below each of them, for its name and numbers
SMALL = 9  # points of their names


def columns_for(frames):
    """How many maps beside each other make those of all planes largest in a panel."""
    x0, x1, z0, z1 = frames[0]
    size = {columns: min(PANEL / columns / (x1 - x0), 1 / -(-len(frames) // columns) / (z1 - z0))
            for columns in range(1, len(frames) + 1)}
    return max(size, key=size.get)


def heights_of(frames):
    """Inches of each row of the maps of several planes."""
    columns = columns_for(frames)
    rows = [frames[k:k + columns] for k in range(0, len(frames), columns)]
    return [ROOM + 0.85 * PANEL_WIDTH / columns
            * max(np.clip((z1 - z0) / (x1 - x0), 0.1, 1.5) for x0, x1, z0, z1 in row) for row in rows]


def draw_map(axes, run, name, time, label, log=False, wanted=None):
    """A field near a time [s], the stored one of which it returns; several planes where their maps are larger."""
    fields = Fields(run, name)
    row = int(np.argmin(np.abs(fields.times - time)))
    values = fields.maps([row])[0]
    planes, frames = planes_of(run), frames_of(run, tall=True)
    values = np.abs(values) if log else values
    norm = Span().see(values).norm(fields.kind, log, wanted)
    many = len(planes) > 1
    columns = columns_for(frames) if many else 1
    heights, width = np.array(heights_of(frames) if many else [1.0]), 0.9 / columns
    room, ends = ROOM / heights.sum(), np.cumsum(heights) / heights.sum()
    if many:
        axes.set_axis_off()
    for k, plane in enumerate(planes):
        line, column = divmod(k, columns)
        below = k + columns >= len(planes)
        own = axes.inset_axes([0.06 + column * width, 1 - ends[line] + 0.55 * room, 0.9 * width,
                               heights[line] / heights.sum() - room]) if many else axes
        artist = plane.draw(own, plane.values(values), norm, fields.kind.colours)
        plane.frame(own, frames[k])
        own.set(xlabel=plane.along_label if below else "", ylabel=own.get_ylabel() if column == 0 else "")
        if many:
            own.set_title(wrapped(plane.short, 0.8 * PANEL_WIDTH / columns, SMALL), fontsize=SMALL, fontweight="normal")
            own.tick_params(labelbottom=below or not beside(run), labelleft=column == 0 or not beside(run))
            if not beside(run):
                own.xaxis.set_major_locator(MaxNLocator(4 if columns > 1 else 6, steps=[1, 2, 5, 10]))
    if not many:
        axes.set_anchor("W")
    colour_bar(axes.figure, artist, norm, label,
               cax=axes.inset_axes([0.97, 0.1, 0.03, 0.8] if many else [1.04, 0.0, 0.05, 1.0]))
    return fields.times[row]
