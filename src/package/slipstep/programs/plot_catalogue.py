"""Plot a catalogue of events: magnitude against time, magnitude and frequency, where they were; with the run that had
them, cumulative slip along a line. Or one event: its slip and when each cell broke.

    slipstep plot-catalogue CATALOGUE.h5 [RUN.h5] [--figure OUT.png]
    slipstep plot-catalogue CATALOGUE.h5 RUN.h5 --along depth --at 10 --every 5y --every-event 1
    slipstep plot-catalogue CATALOGUE.h5 --event 3          or --event largest
"""

import argparse
import os

import numpy as np
from matplotlib.collections import EllipseCollection, PolyCollection
from matplotlib.ticker import MaxNLocator
from ..geometry.cells import corners_of, mesh_cells
from ..plots.cumulative import courses, draw_cumulative, warn
from ..plots.maps import Span, aspect_of, colour_bar, extent_of, frames_of, planes_of
from ..plots.panels import RUN_STYLES, log_scale, plt, use_style, wrapped
from ..plots.snapshots import WIDTH, Layout, contours_of
from ..plots.spacetime import place
from ..results.events import Events
from ..results.fields import KINDS
from ..results.run import Run
from ..times import Clock, seconds, written

MANY = 300  # events, beyond which only the largest have stems
FAULTS = len(RUN_STYLES)  # up to which each has a colour
MANY_PLANES = 6  # of a network, beyond which hypocentres are on a map, and an event has those that slipped
SLIPPED = 0.01  # of the largest slip
MANY_CIRCLES = 60  # events, beyond which only the largest have circles
CIRCLES = 5  # so many
BESIDE = 6.0  # inches, of the panels of hypocentres beside the frequencies
SMALL, TITLE = 9, 12  # points of their names, and of titles of figures
ROOM = 0.8  # inches of each, for its name and numbers
LARGEST = 60
LEAST_SPAN = 0.2  # of magnitudes, of axes and colours: less is no difference that one should see


def draw_times(axes, events, clock):
    """A stem and a dot for each event, in a colour for each of several faults."""
    known = np.isfinite(events["magnitude"])
    order = np.argsort(events["magnitude"][known])[::-1]
    time, magnitude = clock(events["onset"][known][order]), events["magnitude"][known][order]
    bottom = np.floor(2 * magnitude.min() - 0.2) / 2
    many = len(time) > MANY
    stems = slice(None, LARGEST if many else None)
    several = "fault" in events.event and 1 < len(events.faults) <= FAULTS
    label = events["fault"][known][order] if several else np.zeros(len(time))
    for style, fault in zip(RUN_STYLES, events.faults if several else [0]):
        own = label == fault
        axes.vlines(time[stems][own[stems]], bottom, magnitude[stems][own[stems]], color=style["color"], linewidth=0.8,
                    alpha=0.7)
        axes.plot(time[own], magnitude[own], linestyle="", marker="o", markersize=2 if many else 5,
                  color=style["color"], markeredgewidth=0,
                  # an empty one would be at the figure's corner
                  alpha=0.5 if len(time) > 10 * MANY else 1, clip_on=not own.any(), label=events.fault_name(fault))
    if len(time) == 1:
        axes.annotate(f"M {magnitude[0]:.2f}", (time[0], magnitude[0]), xytext=(8, 0), textcoords="offset points",
                      va="center")
    if several:
        axes.legend(loc="lower right", bbox_to_anchor=(1, 1), borderaxespad=0, ncols=len(events.faults))
    axes.set(title="1 event" if len(events) == 1 else f"{len(events)} events", xlabel=clock.label,
             ylabel="moment magnitude", ylim=(bottom, magnitude.max() + 0.3))


def draw_frequency(axes, events):
    """How many events have at least each magnitude, that of one cell, and Gutenberg and Richter's law."""
    magnitude = np.sort(events["magnitude"][np.isfinite(events["magnitude"])])
    count = len(magnitude) - np.arange(len(magnitude))
    axes.plot(magnitude, count, linestyle="", marker="o", markersize=3.5, color=RUN_STYLES[0]["color"],
              markeredgewidth=0)
    if events.cell_magnitude is not None:
        axes.axvline(events.cell_magnitude, color="0.5", linewidth=1.2, linestyle=":",
                     label=f"one cell (M {events.cell_magnitude:.1f})")
    law = events.fit()
    if isinstance(law, str):
        axes.plot([], [], linestyle="", label=law)
    else:
        least, b, error, above = law
        reach = np.array([least, min(magnitude[-1], least + np.log10(above) / b)])
        axes.plot(reach, above * 10 ** (-b * (reach - least)), color="black", linewidth=1.2, linestyle="--",
                  label=f"b = {b:.2f} ± {error:.2f} (M ≥ {least:.1f}, several cells)")
    axes.legend(loc="upper right")
    axes.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    low, high = axes.get_xlim()
    if high - low < LEAST_SPAN:
        axes.set_xlim((low + high - LEAST_SPAN) / 2, (low + high + LEAST_SPAN) / 2)
    axes.set(title="Magnitude and frequency", xlabel="moment magnitude M", ylabel="events of at least M")
    log_scale(axes)
    # a quarter of it above all events, for the legend
    axes.set_ylim(0.7, max(0.7 * (len(magnitude) / 0.7) ** 1.35, 12))


def seen_from_above(events):
    """Corners of the cells [n, 3 or 4, 2], north and east [m]."""
    mesh = events.mesh
    corners = mesh["vertices"][mesh["triangles"]] if "triangles" in mesh else corners_of(mesh_cells(mesh))
    return corners[..., :2]


def hypocentres(events):
    """Of each panel limits, title, labels, rows of events and places [km]; vertical planes along x share one. Of many
    planes the panel is a map, whose limits have the north above."""
    planes = planes_of(events)
    if len(planes) > MANY_PLANES:
        north, east = seen_from_above(events).reshape(-1, 2).T / 1e3
        return [((east.min(), east.max(), north.max(), north.min()), "", "east (km)", "north (km)",
                 np.arange(len(events)), events["y"] / 1e3, events["x"] / 1e3)]
    if not {"dip", "down_dip"} & set(events.mesh) and not events.attributes.get("strike", 0):
        return [(extent_of(planes), "", planes[0].along_label, planes[0].down_label, np.arange(len(events)),
                 events["x"] / 1e3, events["z"] / 1e3)]
    found = []
    for plane, frame in zip(planes, frames_of(events)):
        places = [plane.centre(cell) for cell in events["cell"]]
        rows = np.array([k for k, at in enumerate(places) if at], int)
        x, z = np.array([places[k] for k in rows]).reshape(-1, 2).T
        found.append((frame, plane.name, plane.along_label, plane.down_label, rows, x, z))
    return found


def circled(events, places, many):
    """Which events have a circle of their area: the largest that fit, and fill the panels once at most."""
    size, share = np.zeros(len(events)), np.zeros(len(events))
    for (x0, x1, z0, z1), _, _, _, rows, _, _ in places:
        size[rows], share[rows] = min(x1 - x0, z1 - z0), events["area"][rows] / ((x1 - x0) * (z1 - z0) * 1e6)
    sized = np.zeros(len(events), bool)
    for row in np.argsort(-events["area"], kind="stable"):
        if (2e-3 * np.sqrt(events["area"][row] / np.pi) <= size[row] and share[sized].sum() + share[row] <= len(places)
            and sized.sum() < (CIRCLES if many else len(events))):
            sized[row] = True
    return sized


def draw_places(canvas, panels, events):
    """Hypocentres, large events on top, and circles of the ruptured areas around them."""
    radius, magnitude = np.sqrt(events["area"] / np.pi) / 1e3, events["magnitude"]
    many = len(events) > MANY_CIRCLES
    places = hypocentres(events)
    sized = circled(events, places, many)
    least, most = np.nanmin(magnitude), np.nanmax(magnitude)
    middle, half = (least + most) / 2, max(most - least, LEAST_SPAN) / 2
    norm = plt.Normalize(middle - half, middle + half)
    colours = plt.get_cmap("viridis_r")
    above = len(planes_of(events)) > MANY_PLANES
    if aspect_of(places[0][0]) == "auto" or above:
        sized[:] = False  # circles would be none, or seen from the side
    if above:
        panels[0].add_collection(PolyCollection(seen_from_above(events)[..., ::-1] / 1e3, facecolor="0.85",
                                                edgecolor="0.7", linewidth=0.8, rasterized=True))
    drawn = []
    for axes, (frame, name, along, down, rows, x, z) in zip(panels, places):
        order = np.argsort(events["area"][rows])
        rows, x, z = rows[order], x[order], z[order]
        large = rows[sized[rows]]
        circles = EllipseCollection(2 * radius[large], 2 * radius[large], np.zeros(len(large)), units="xy",
                                    offsets=np.stack([x, z], axis=1)[sized[rows]],
                                    offset_transform=axes.transData, edgecolors=colours(norm(magnitude[large])),
                                    facecolors="none", linewidths=1.2, zorder=4)
        axes.add_collection(circles)
        drawn.append(axes.scatter(x, z, c=magnitude[rows], norm=norm, cmap=colours,
                                  s=22 if not many else 12 if len(events) < MANY else 5, linewidth=0, zorder=3))
        x0, x1, z0, z1 = frame
        axes.set(xlabel=along if axes is panels[-1] else "", ylabel=down, aspect=aspect_of(frame), xlim=(x0, x1),
                 ylim=(z1, z0))
        if name:
            axes.set_title(wrapped(name, WIDTH if len(events) == 1 else BESIDE, SMALL), fontsize=SMALL,
                           fontweight="normal")
        axes.spines[:].set_visible(True)
        for axis, ticks in ((axes.xaxis, 6), (axes.yaxis, 5)):
            axis.set_major_locator(MaxNLocator(ticks, steps=[1, 2, 5, 10]))
        axes.grid(False)
    title = "Hypocentre" if len(events) == 1 else "Hypocentres"
    if sized.any():
        title += (f", circle{'s' * int(sized.sum() > 1)} of "
                  f"{'the ruptured area' if sized.all() else f'{sized.sum()} of {len(events)} ruptured areas'}")
    elif aspect_of(places[0][0]) == "equal" and not above:
        title += (": the ruptured area is too large for a circle" if len(events) == 1
                  else ": ruptured areas are too large for circles")
    panels[0].set_title("\n".join(filter(None, (title, panels[0].get_title(loc="left")))))
    if len(events) > 1:
        most = max(drawn, key=lambda dots: len(dots.get_offsets()))  # a plane without events has no colours
        colour_bar(canvas, most, norm, "moment magnitude", ax=panels if len(panels) > 1 else panels[0],
                   location="bottom", shrink=0.8, aspect=30, pad=0.02)


def figure(events, lines, years):
    """All events with courses of slip, one for each plane; and how many events have too few rows."""
    use_style()
    tall = [4.6 if course.line.along == "strike" else 5.4 for course in lines]
    frames = [frame for frame, *_ in hypocentres(events)]
    ratios = [float(np.clip(abs((z1 - z0) / (x1 - x0)), 0.1, 1.5)) for x0, x1, z0, z1 in frames]
    middle = max(4.2, sum(BESIDE * ratio + ROOM for ratio in ratios)
                 if len(frames) > 1 or len(planes_of(events)) > MANY_PLANES else 0.0)
    canvas = plt.figure(figsize=(WIDTH, 3.0 + middle + sum(tall)), layout="constrained")
    grid = canvas.add_gridspec(2 + len(lines), 2, height_ratios=[3.0, middle, *tall], width_ratios=(1, 1.35))
    clock = Clock(0.0, max(events["end"].max(), *(course.times[-1] for course in lines), 0.0), years)
    top = canvas.add_subplot(grid[0, :])
    draw_times(top, events, clock)
    top.set_xlim(0, float(clock(clock.span)))
    beside = grid[1, 1] if len(events) > 1 else grid[1, :]
    if len(events) > 1:  # of one there is no frequency
        draw_frequency(canvas.add_subplot(grid[1, 0]), events)
    rows = beside.subgridspec(len(frames), 1, height_ratios=ratios)
    draw_places(canvas, [canvas.add_subplot(row) for row in rows] if len(frames) > 1 else [canvas.add_subplot(beside)],
                events)
    pairs = np.stack([events["onset"], events["end"]], axis=1)
    poor = [draw_cumulative(canvas.add_subplot(grid[2 + k, :]), course, pairs) for k, course in enumerate(lines)]
    canvas.suptitle(os.path.basename(events.path) + ("" if events.complete else " (unfinished)"))
    return canvas, max(poor, default=0)


def broken_faults(events, number):
    """In words which faults broke in an event; nothing where there is one, or nobody knows."""
    if "fault_area" not in events.event:
        return ""
    names = [events.fault_name(label) for label in events.faults[events["fault_area"][number] > 0]]
    return ", ".join(names[:1] + [name.removeprefix("fault ") for name
                                  in names[1:]]).replace("fault ", "faults " if len(names) > 1 else "fault ", 1) + ", "


def leave_out(events, slip, cell):
    """Of many planes those that hardly slipped in an event, nor have its hypocentre, are not drawn; how many."""
    planes = planes_of(events)
    if len(planes) <= MANY_PLANES:
        return 0
    least = SLIPPED * np.abs(slip).max()
    events.drawn = [plane for plane in planes if np.abs(slip[plane.cells]).max() > least or cell in plane.cells]
    return len(planes) - len(events.drawn)


def event_figure(events, number):
    """Slip of one event with contours of the time of rupture."""
    slip, broke = events.map_of("slip", number), events.map_of("rupture_time", number)
    left = leave_out(events, slip, events["cell"][number])
    layout = Layout(events, 1, 1)
    block = layout.fill(layout.canvas)[0]
    kind = KINDS["slip"]
    norm = Span().see(slip).norm(kind)
    onset, duration = events["onset"][number], events.duration[number]
    clock = Clock(0.0, duration)
    broke = clock(broke)
    head, levels = contours_of(broke, clock)
    artists = layout.draw(block, slip, norm, kind.colours, head, True)
    for plane, axes in zip(layout.planes, block):
        if len(levels):
            plane.contour(axes, plane.values(broke), levels)
        place = plane.centre(events["cell"][number])
        if place:
            star, = axes.plot(*place, marker="*", markersize=14, color="white", markeredgecolor="black")
            star.set_clip_on(False)
    colour_bar(layout.canvas, artists[0], norm, "slip (m)", ax=block, location="bottom", shrink=0.7, aspect=35,
               pad=0.02)
    layout.canvas.suptitle(wrapped(f"Event {number + 1} at {written(onset)}: M {events['magnitude'][number]:.2f}, "
                                   f"{broken_faults(events, number)}"
                                   + (f"rake {events['rake'][number]:.0f}°, " if "rake" in events.event else "")
                                   + f"stress drop {events['stress_drop'][number] / 1e6:.2g} MPa, "
                                     f"{duration:{'.3g' if duration < 999.5 else '.0f'}} s"
                                   + (f"; without {left} faults that slipped by less than {SLIPPED:.0%} of the most"
                                      if left else ""), WIDTH, TITLE))
    return layout.canvas


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("catalogue", metavar="CATALOGUE", help="file of -fault_catalogue")
    parser.add_argument("run", metavar="RUN", nargs="?", help="output file of the run, for cumulative slip")
    parser.add_argument("--figure", metavar="PNG",
                        help="file to write, default CATALOGUE with .png; its ending chooses the format")
    parser.add_argument("--event", metavar="N", help="draw only this event: its number from 1 on, or largest")
    parser.add_argument("--field", metavar="NAME", help="field of the run that is the slip, default slip")
    parser.add_argument("--along", choices=("strike", "dip", "depth"),
                        help="the line of cumulative slip, default strike; depth is another name of dip")
    parser.add_argument("--at", type=place, metavar="KM", help="where it is in the other direction, or max, or mean "
                                                               "over that direction; default the middle")
    parser.add_argument("--every", type=seconds, metavar="T",
                        help="interval of the lines between events: seconds, or a number with s, min, h, d, y, as 5y")
    parser.add_argument("--every-event", type=seconds, metavar="T",
                        help="interval of the lines during events, default 1 s")
    parser.add_argument("--years", action=argparse.BooleanOptionalAction,
                        help="time in years, default for more than one year")
    options = parser.parse_args()
    for name in ("field", "along", "at", "every", "every_event"):
        value = getattr(options, name)
        if value is not None and not options.run:
            parser.error(f"--{name.replace('_', '-')} needs RUN, the output file of the run")
        if name.startswith("every") and value is not None and not value > 0:
            parser.error(f"--{name.replace('_', '-')} is {value:g} s, expected a time > 0")
    if options.event is not None and options.run:
        parser.error("--event draws one event of the catalogue: leave RUN out")
    if options.event not in (None, "largest") and not options.event.isdigit():
        parser.error(f"--event is {options.event}, expected a number from 1 on, or largest")
    return options


def main():
    options = arguments()
    suffix = f"_event_{options.event}" if options.event else ""
    target = options.figure or os.path.splitext(options.catalogue)[0] + suffix + ".png"
    events = Events(options.catalogue)
    events.warn()
    if options.event:
        event_figure(events, events.number_of(options.event)).savefig(target)
    else:
        lines = []
        if options.run:
            run = Run(options.run)
            run.warn()
            run.require_fault("a line of its slip")
            lines = courses(run, options.field or "slip", options.along or "strike", options.at, options.every,
                            options.every_event or 1.0)
        canvas, poor = figure(events, lines, options.years)
        canvas.savefig(target)
        if poor:
            warn(run, poor, lines[0])
    print(f"Figure: {target}")
