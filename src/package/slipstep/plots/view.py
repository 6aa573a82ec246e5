"""A fault of any planes in space: its cells as a viewer far away sees them, what is behind hidden, in a box of north, east and depth.

Cells are cut into pieces of about one size and drawn from the farthest to the nearest by their middles, which is right to the size of a piece
where planes touch or cut each other. The projection is orthographic, and scales are the same in all directions."""

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.ticker import MaxNLocator

from ..geometry.cells import axis_along_strike, cells_of, corners_of, free_edges, free_sides, mesh_cells, triangles_of
from ..results.fields import Fields, largest_event
from ..times import written
from .maps import Span, colour_bar, colour_map
from .panels import plt, use_style
from .snapshots import WIDTH, chosen_rows, clock_of, logarithmic, since
from .titles import titles_of

PIECES = 8000  # about, of all cells
BAR = 1.2  # inches, of the colour bar
COUNT = 4  # views where no times are asked for
ASIDE, ABOVE = 40.0, 25.0  # degrees, of the view where none is asked for: from across the strike, and elevation
PAD = 0.04  # of the box around the cells, of its longest side
CORNER = 0.05  # of the box as it is seen
THIN = 0.25  # of the longest side: the other ones at least
NAMES = ("north (km)", "east (km)", "depth (km)")


def screen(azimuth, elevation):
    """Directions to the right, upwards and to the viewer, each as north, east and down, of one at an azimuth from north and an elevation
    [degrees]."""
    a, e = np.radians((azimuth, elevation))
    return np.array([[np.sin(a), -np.cos(a), 0.0],
                     [-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), -np.cos(e)],
                     [np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), -np.sin(e)]])


def cut(corners, size):
    """Pieces [n, 4, 3] of rectangles [N, 4, 3] with sides of about a size at most, and the rectangle of each."""
    sides = [np.linalg.norm(corners[:, k] - corners[:, 0], axis=1) for k in (1, 3)]
    count = [np.maximum(np.ceil(side / size - 1e-9), 1).astype(int) for side in sides]
    each = count[0] * count[1]
    of = np.repeat(np.arange(len(corners)), each)
    number = np.arange(len(of)) - np.repeat(np.cumsum(each) - each, each)
    i, j = number % count[0][of], number // count[0][of]
    along, down = corners[of, 1] - corners[of, 0], corners[of, 3] - corners[of, 0]
    a, b = ([(k / n[of])[:, None], ((k + 1) / n[of])[:, None]] for k, n in ((i, count[0]), (j, count[1])))
    return np.stack([corners[of, 0] + a[p] * along + b[q] * down for p, q in ((0, 0), (1, 0), (1, 1), (0, 1))], axis=1), of


def cut_triangles(corners, size):
    """Pieces [n, 4, 3] of triangles [N, 3, 3] with sides of about a size at most, their last corner twice, and the triangle of each."""
    of = np.arange(len(corners))
    while True:
        long = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1) > 2 * size
        if not long.any():
            return corners[:, (0, 1, 2, 2)], of
        a, b, c = corners[long].swapaxes(0, 1)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        parts = [np.stack(part, axis=1) for part in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        corners, of = np.concatenate([corners[~long], *parts]), np.concatenate([of[~long], *[of[long]] * 4])


def box_of(corners):
    """Low and high ends [2, 3] of what is around the cells [km]; up to the ground where that is near."""
    low, high = corners.reshape(-1, 3).min(axis=0), corners.reshape(-1, 3).max(axis=0)
    most = (high - low).max()
    grow = np.maximum(PAD * most, 0.5 * (THIN * most - (high - low)))
    box = np.stack([low - grow, high + grow])
    box[0, 2] = 0.0 if low[2] < 0.5 * most else low[2] - PAD * most
    return box


class View:
    """What does not depend on the values: pieces, their order, outlines and the box; for as many drawings as are wanted."""

    def __init__(self, run, of, viewer=None):
        triangles, shape = triangles_of(run.mesh), None
        if triangles is None:
            cells, shape = cells_of(run.path, run.mesh, of)
            corners = corners_of(cells) / 1e3
        else:
            cells, corners = mesh_cells(run.mesh), triangles / 1e3
        self.azimuth, self.elevation = viewer or ((axis_along_strike(cells[:, 5], cells[:, 3] * cells[:, 4]) + 90 + ASIDE) % 360, ABOVE)
        self.axes = screen(self.azimuth, self.elevation)
        self.box = box_of(corners)
        self.size = np.sqrt((cells[:, 3] * cells[:, 4]).sum() / PIECES) / 1e3
        pieces, self.of = cut(corners, self.size) if triangles is None else cut_triangles(corners, self.size)
        lines, self.thick = self.outline(corners, shape)
        self.polygons = np.concatenate([pieces, lines])
        self.of = np.concatenate([self.of, np.full(len(lines), -1)])
        near = self.polygons.mean(axis=1) @ self.axes[2] + np.where(self.of < 0, 0.75 * self.size, 0.0)
        order = np.argsort(near, kind="stable")
        self.polygons, self.of = self.polygons[order], self.of[order]
        self.thick = np.concatenate([np.zeros(len(pieces)), self.thick])[order]

    def outline(self, corners, shape):
        """Edges that cells do not share, cut into pieces, as flat rectangles [n, 4, 3], and whether each is of an upper edge."""
        lines, thick = [], []
        for upper, edges in zip((1.0, 0.0), free_edges(corners, shape) if corners.shape[1] == 4 else free_sides(corners)):
            pieces, _ = cut(edges[:, (0, 1, 1, 0)], self.size)
            lines.append(pieces)
            thick.append(np.full(len(pieces), upper))
        return np.concatenate(lines), np.concatenate(thick)

    def seen(self, points):
        """Points north, east, down [..., 3] on the screen [..., 2]."""
        return points @ self.axes[:2].T

    @property
    def extent(self):
        """Of the box on the screen: left, right, lower, upper [km]."""
        corners = self.seen(np.stack(np.meshgrid(*self.box.T, indexing="ij"), axis=-1).reshape(-1, 3))
        (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
        return x0, x1, y0, y1

    def draw(self, axes, norm, colours, missing=None):
        """The artist, whose show() takes values of the cells; missing: the colour of those without."""
        self.draw_box(axes)
        artist = PolyCollection(self.seen(self.polygons), zorder=3)
        artist.set_linewidths(np.where(self.of < 0, np.where(self.thick > 0, 1.8, 0.7), 0.25))
        scale = ScalarMappable(norm, colour_map(colours))
        black = np.array([0.0, 0.0, 0.0, 1.0])

        def show(values):
            faces = scale.to_rgba(values.ravel())
            if missing:
                faces[~np.isfinite(values.ravel())] = to_rgba(missing)
            faces = faces[np.maximum(self.of, 0)]
            faces[self.of < 0] = black
            artist.set_facecolors(faces)
            artist.set_edgecolors(faces)

        artist.show = show
        axes.add_collection(artist)
        x0, x1, y0, y1 = self.extent
        axes.set(xlim=(x0, x1), ylim=(y0, y1), aspect="equal")
        axes.set_axis_off()
        axes.spines[:].set_visible(False)
        return artist

    def draw_box(self, axes):
        """Its faces behind the cells with lines at ticks, and numbers along its edges."""
        behind = np.where(self.axes[2] > 0, self.box[0], self.box[1])  # of both faces across an axis the one away from the viewer
        before = np.where(self.axes[2] > 0, self.box[1], self.box[0])
        ticks = [self.ticks(k) for k in range(3)]
        faces, lines = [], []
        for k in range(3):
            i, j = (n for n in range(3) if n != k)
            face = np.tile(behind, (4, 1))
            face[:, i], face[:, j] = self.box[[0, 1, 1, 0], i], self.box[[0, 0, 1, 1], j]
            faces.append(face)
            for m, n in ((i, j), (j, i)):
                for tick in ticks[m]:
                    line = np.tile(behind, (2, 1))
                    line[:, m], line[:, n] = tick, self.box[:, n]
                    lines.append(line)
        axes.add_collection(PolyCollection(self.seen(np.array(faces)), facecolor="#f6f6f6", edgecolor="#bbbbbb", linewidth=0.8, zorder=1))
        axes.add_collection(LineCollection(self.seen(np.array(lines)), colors="#dddddd", linewidths=0.6, zorder=2))
        low = before.copy()
        low[2] = self.box[1, 2]
        sides = [np.where(np.arange(3) == k, before, behind) for k in (0, 1)]  # vertical edges at the rim, where depths are on the left one
        left = min(sides, key=lambda point: self.seen(point)[0])
        short = min((0, 1), key=lambda k: np.linalg.norm(self.axes[:2, k]) * (self.box[1, k] - self.box[0, k]))
        for k, start in ((0, low), (1, low), (2, left)):
            self.number(axes, k, start, ticks[k], low if k == short else None)

    def ticks(self, k):
        low, high = self.box[:, k]
        found = MaxNLocator(5, steps=[1, 2, 5, 10]).tick_values(low, high)
        return found[(found >= low - 1e-9) & (found <= high + 1e-9)]

    def number(self, axes, k, start, ticks, corner=None):
        """Ticks and their numbers along the edge of the box in a direction k, and its name; none where it is seen nearly from its end, or near a corner
        where another edge has its numbers."""
        edge = np.tile(start, (2, 1))
        edge[:, k] = self.box[:, k]
        edge = self.seen(edge)
        along = edge[1] - edge[0]
        length = np.linalg.norm(along)
        x0, x1, y0, y1 = self.extent
        if length < 0.08 * max(x1 - x0, y1 - y0):
            return
        along /= length
        out = np.array([-along[1], along[0]])
        out *= np.sign(out @ (edge.mean(axis=0) - ((x0 + x1) / 2, (y0 + y1) / 2))) or 1.0
        every = slice(None, None, 1 if length > 0.25 * max(x1 - x0, y1 - y0) else 2)
        for tick in ticks[every]:
            at = start.copy()
            at[k] = tick
            if corner is not None and np.linalg.norm(self.seen(at) - self.seen(corner)) < CORNER * max(x1 - x0, y1 - y0):
                continue
            axes.annotate(f"{tick:g}", self.seen(at), xytext=11 * out, textcoords="offset points", ha="center", va="center", fontsize=9,
                          annotation_clip=False, arrowprops={"arrowstyle": "-", "color": "#888888", "linewidth": 0.7, "shrinkA": 6, "shrinkB": 0})
        turn = np.degrees(np.arctan2(along[1], along[0]))
        axes.annotate(NAMES[k], edge.mean(axis=0), xytext=(28 if k < 2 else 32) * out, textcoords="offset points", ha="center", va="center",
                      rotation=(turn + 89.9) % 180 - 89.9, fontsize=10, annotation_clip=False)

    def height(self, width):
        """Inches of a panel of a width [inches], with its title and numbers."""
        x0, x1, y0, y1 = self.extent
        return float(np.clip((width - 0.9) * (y1 - y0) / (x1 - x0), 1.2, 12)) + 1.0

    @property
    def words(self):
        return f"from azimuth {self.azimuth:.0f}°, elevation {self.elevation:.0f}°"


def bar(canvas, values, norm, colours, label, axes, **place):
    """The colour bar of views."""
    scale = ScalarMappable(norm, colour_map(colours))
    scale.set_array(np.asarray(values).ravel())
    return colour_bar(canvas, scale, norm, label, ax=axes, **place)


def views(run, name, times, window=None, log=None, wanted=None, years=None, viewer=None):
    """A field at several times."""
    use_style()
    if not times and window is None and name in ("slip_rate", "stress_drop"):
        window = largest_event(run)
    fields = Fields(run, name, window)
    view = View(run, run.parameters, viewer)
    rows = chosen_rows(fields, times, COUNT)
    clock = clock_of(run, fields.times[rows], years)
    log = logarithmic(fields, rows, clock, log)
    columns = 1 if len(rows) == 1 else 2 if len(rows) < 5 else 3
    wide = WIDTH if columns > 1 else 0.8 * WIDTH
    down = -(-len(rows) // columns)
    canvas, axes = plt.subplots(down, columns, figsize=(wide, down * view.height((wide - BAR) / columns) + 0.5), layout="constrained", squeeze=False)
    maps = fields.maps(rows)
    maps = np.abs(maps) if log else maps
    norm = Span().see(maps).norm(fields.kind, log, wanted)
    for own, text, values in zip(axes.flat, titles_of(run, fields.times[rows], clock, named=False), maps):
        view.draw(own, norm, fields.kind.colours).show(values)
        own.set_title(text, fontsize=10, fontweight="normal")
    for spare in axes.flat[len(rows):]:
        spare.remove()
    bar(canvas, maps, norm, fields.kind.colours, fields.label, list(axes.flat[:len(rows)]), shrink=0.7, aspect=30, pad=0.02)
    canvas.suptitle(f"{run.title}: {fields.kind.title.lower()}{since(clock)}, {view.words}")
    return canvas


def event_view(events, number, kind, viewer=None):
    """Slip of one event of a catalogue."""
    use_style()
    view = View(events, events.attributes, viewer)
    slip = events.map_of("slip", number)
    norm = Span().see(slip).norm(kind)
    wide = 0.8 * WIDTH
    canvas, axes = plt.subplots(figsize=(wide, view.height(wide - BAR) + 0.5), layout="constrained")
    view.draw(axes, norm, kind.colours).show(slip)
    bar(canvas, slip, norm, kind.colours, "slip (m)", axes, shrink=0.7, aspect=30, pad=0.02)
    canvas.suptitle(f"Event {number + 1} at {written(events['onset'][number])}: M {events['magnitude'][number]:.2f}, {view.words}")
    return canvas
