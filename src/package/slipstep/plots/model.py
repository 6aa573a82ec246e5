"""A slip model or the patches of a fault: on the map, and along strike and depth, coloured by slip or by fault."""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize

from ..geometry.cells import axis_along_strike
from .maps import colour_bar
from .panels import plt, use_style


def draw(model):
    """A picture of a model of slipstep.formats."""
    use_style()
    corners = model.corners / 1e3
    if model.slip is not None:
        values, label, cmap = np.abs(model.slip), "slip (m)", "viridis"
    else:
        values, label, cmap = next(((v, f"{name.replace('_', ' ')} ({unit})", "viridis")
                                    for name, (v, unit) in model.fields.items() if np.ptp(v) > 1e-6 * np.abs(v).max()),
                                   (np.searchsorted(np.unique(model.fault), model.fault) + 1.0, "fault", "tab20"))
    strike = axis_along_strike(model.cells[:, 5], model.area)
    turn = np.radians(strike)
    along = corners[..., 0] * np.cos(turn) + corners[..., 1] * np.sin(turn)
    order = np.argsort(-corners[..., 2].mean(axis=1), kind="stable")  # deep ones below shallow ones
    across = corners[..., 1] * np.cos(turn) - corners[..., 0] * np.sin(turn)
    behind = np.argsort(across.mean(axis=1), kind="stable")
    canvas, axes = plt.subplots(1, 2, figsize=(11, 4.8), layout="constrained", width_ratios=(1, 1.35))
    norm = Normalize(min(0.0, values.min()) if model.slip is not None else values.min(),
                     values.max() if values.max() > values.min() else values.min() + 1)
    few = len(values) < 2000
    panels = (("seen from above", np.stack([corners[..., 1], corners[..., 0]], axis=-1), order, "east (km)",
               "north (km)"),
              (f"along {round(strike) % 360} degrees", np.stack([along, corners[..., 2]], axis=-1), behind,
               "along strike (km)", "depth (km)"))
    for panel, (title, polygons, sequence, xlabel, ylabel) in zip(axes, panels):
        seen = panel is axes[1] and few
        artist = PolyCollection(polygons[sequence], array=values[sequence], cmap=cmap, norm=norm, edgecolors="black"
                                if seen else "face", linewidths=0.3 if seen else 0.3 if panel is axes[1] else 1.5,
                                rasterized=not few)
        panel.add_collection(artist)
        panel.autoscale_view()
        panel.set(title=title, xlabel=xlabel, ylabel=ylabel, aspect="equal")
        panel.grid(False)
    x, y = corners[..., 1], corners[..., 0]
    half = 0.55 * max(np.ptp(x), np.ptp(y), 1e-3)
    for limit, values_on in ((axes[0].set_xlim, x), (axes[0].set_ylim, y)):  # vertical faults are lines
        middle = (values_on.min() + values_on.max()) / 2
        limit(middle - half, middle + half)
    axes[1].invert_yaxis()
    colour_bar(canvas, artist, norm, label, ax=axes, location="bottom", shrink=0.6, aspect=40, pad=0.02)
    canvas.suptitle(model.path.rsplit("/", 1)[-1])
    return canvas
