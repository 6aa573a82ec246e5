"""The speed of a rupture from the times at which cells broke, on grids, rectangles and triangles alike."""

import numpy as np

from ..geometry.cells import directions

NEIGHBOURS = 8  # cells about one, of which those that broke give the gradient of its time
NEAR = 2.0  # of a cell's size: how far its neighbours are at most
FLAT = 0.35  # of their distance: how far off its plane
CHUNK = 512  # cells whose distances to all in the same strip of the fault are in memory at once
NUCLEATION = 2.0  # cells about the first one, which no front crosses


def neighbours(cells, shape=None, fault=None):
    """Numbers [N, k] of the cells about each, -1 where there are fewer.

    cells  [N, 7]: centre north, east, down, length, width [m], strike and dip [degrees]
    shape  (nz, nx) of a grid, whose cells have the eight about them; others have the nearest centres of their fault,
           near their plane
    fault  [N] labels, or None"""
    n = len(cells)
    if shape:
        number = np.full((shape[0] + 2, shape[1] + 2), -1)
        number[1:-1, 1:-1] = np.arange(n).reshape(shape)
        return np.stack([number[1 + i:1 + i + shape[0], 1 + j:1 + j + shape[1]].ravel() for i in (-1, 0, 1)
                         for j in (-1, 0, 1) if i or j], axis=1)
    place, size = cells[:, :3], np.sqrt(cells[:, 3] * cells[:, 4])
    along, down = directions(cells)
    normal = np.cross(along, down)
    k = min(NEIGHBOURS, n - 1)
    found = np.full((n, NEIGHBOURS), -1)
    # strips across the longest direction: only those within reach are looked at
    axis = np.argmax(np.ptp(place, axis=0))
    order = np.argsort(place[:, axis], kind="stable")
    line, reach = place[order, axis], NEAR * size.max()
    for begin in range(0, n, CHUNK):
        rows = order[begin:begin + CHUNK]
        others = np.sort(order[np.searchsorted(line, place[rows[0], axis] - reach):np.searchsorted(
            line, place[rows[-1], axis] + reach, side="right")])
        offset = place[others] - place[rows, None]
        distance = np.sqrt((offset ** 2).sum(axis=2))
        bad = ((distance > NEAR * np.maximum(size[rows, None], size[others]))
               | (np.abs(np.einsum("ijk,ik->ij", offset, normal[rows])) > FLAT * distance))
        if fault is not None:
            bad |= fault[rows, None] != fault[others]
        bad |= rows[:, None] == others
        distance[bad] = np.inf
        most = min(k, len(others))
        nearest = np.argpartition(distance, most - 1, axis=1)[:, :most]
        found[rows, :most] = np.where(np.isfinite(np.take_along_axis(distance, nearest, axis=1)), others[nearest], -1)
    return found


def speed(time, cells, shape=None, fault=None):
    """Rupture speed [N] in m/s, one over the length of the gradient of the time [N] in s along the fault; NaN where a
    cell or too many about it never broke, and inf where all broke at once.

    The gradient is that of the plane of least squares through the times of the cell and its neighbours, in the cell's
    directions along strike and down dip, weighted by the inverse squared distance, the cell as its nearest: exact where
    the front is straight and its speed uniform, and of second order on grids."""
    time = np.ravel(time).astype(float)
    about = neighbours(cells, shape, fault)
    there = (about >= 0) & np.isfinite(time[about])
    offset = cells[about, :3] - cells[:, None, :3]
    along, down = directions(cells)
    x, y = (np.where(there, np.einsum("ijk,ik->ij", offset, axis), 0.0) for axis in (along, down))
    squared = np.where(there, x ** 2 + y ** 2, np.inf)
    weight = np.where(there, 1 / np.where(squared > 0, squared, np.inf), 0.0)
    own = 1 / squared.min(axis=1)  # of the cell itself
    t = np.where(there, time[about], 0.0) - np.where(there, time[:, None], 0.0)
    total = weight.sum(axis=1) + own
    with np.errstate(divide="ignore", invalid="ignore"):
        mx, my, mt = ((weight * v).sum(axis=1) / total for v in (x, y, t))
        xx, xy, yy = ((weight * a * b).sum(axis=1) - total * ma * mb
                      for a, b, ma, mb in ((x, x, mx, mx), (x, y, mx, my), (y, y, my, my)))
        xt, yt = ((weight * a * t).sum(axis=1) - total * ma * mt for a, ma in ((x, mx), (y, my)))
        flat = xx * yy - xy ** 2
        gx, gy = (yy * xt - xy * yt) / flat, (xx * yt - xy * xt) / flat
        found = 1 / np.hypot(gx, gy)
    found[~np.isfinite(time) | (there.sum(axis=1) < 2) | ~(flat > 1e-6 * (xx + yy) ** 2)] = np.nan
    return found


def weighted_quantiles(values, weights, shares):
    """Quantiles of values with weights: the median is where half of the weight is below."""
    order = np.argsort(values)
    below = np.cumsum(weights[order]) - weights[order] / 2
    return np.interp(np.asarray(shares) * weights.sum(), below, values[order])


def summary(speeds, time, cells, area=None):
    """Median of the speeds over the area, and their 16th and 84th percentiles [m/s], without the cells about those that
    broke first. None: there are too few."""
    time = np.ravel(time)
    broke = np.isfinite(time)
    if broke.sum() < 3:
        return None
    size = np.sqrt(cells[:, 3] * cells[:, 4])
    first = cells[broke, :3][np.argmin(time[broke])]
    use = np.isfinite(speeds) & (np.linalg.norm(cells[:, :3] - first, axis=1) > NUCLEATION * size)
    if use.sum() < 3:
        return None
    area = cells[:, 3] * cells[:, 4] if area is None else np.ravel(area)
    return tuple(float(value) for value in weighted_quantiles(speeds[use], area[use], (0.5, 0.16, 0.84)))
