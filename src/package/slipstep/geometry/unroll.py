"""A fault of any planes drawn flat: where its cells are along strike and down dip.

1. Cells of one strike, or the opposite one, have the distance along it, in the direction of cells.axis_along_strike(),
   from the origin. A plane whose upper edge is the lower edge of another one (a listric fault) goes on down dip where
   that ends. What is joined so is a column; it has the cells of a plane beside each other as they are.
2. A column whose cells begin where those of another one end (a segmented fault) is put beside it: each row of its cells
   begins where the row ends that is as far down dip. Segments that dip meet in lines that are not along the dip; so
   lower rows are shifted against upper ones, and none overlap or leave a gap. Where the cells of a column are in no
   rows, it is put as a whole where it overlaps with nothing.
3. The column of the first cell stays in its place. Down dip counts from the upper edge; on faults that are vertical
   everywhere it is the depth.
4. What touches nothing, or would lie on other cells, as branches do, is another part, drawn by itself.

    for index, s, d in unroll(cells):   # cells [N, 7]; s, d [2, n]: low and high edges along strike and down dip [m]
"""

import numpy as np

from .cells import EDGE, LEFT, RIGHT, axis_along_strike, corners_of

ANGLE = 1e-6  # degrees that are rounding
NEAR = 0.3  # of a cell's smaller side: how far apart ends may be that meet
CHUNK = 2000  # cells that are compared with all others at once


def overlap(s, d, others_s, others_d, slack):
    """Whether any rectangle [2, n] lies on one of the others by more than rounding."""
    box = [(max(a.min(), b.min()) + slack, min(a.max(), b.max()) - slack) for a, b in ((s, others_s), (d, others_d))]
    inside = [(s[1] > box[0][0]) & (s[0] < box[0][1]) & (d[1] > box[1][0]) & (d[0] < box[1][1]),
              (others_s[1] > box[0][0]) & (others_s[0] < box[0][1]) & (others_d[1] > box[1][0])
              & (others_d[0] < box[1][1])]
    s, d, others_s, others_d = s[:, inside[0]], d[:, inside[0]], others_s[:, inside[1]], others_d[:, inside[1]]
    for k in range(0, s.shape[1], CHUNK):
        one = [axis[:, k:k + CHUNK, None] for axis in (s, d)]
        if ((one[0][0] < others_s[1] - slack) & (one[0][1] > others_s[0] + slack)
                & (one[1][0] < others_d[1] - slack) & (one[1][1] > others_d[0] + slack)).any():
            return True
    return False


def groups(values, slack, turn=None):
    """A number for each value, equal where values follow by no more than rounding; turn: what is 0 again."""
    order = np.argsort(values, kind="stable")
    number = np.empty(len(values), int)
    number[order] = np.concatenate([[0], np.cumsum(np.diff(values[order]) > slack)])
    if turn and values[order[0]] + turn - values[order[-1]] <= slack:
        number[number == number[order[-1]]] = number[order[0]]
    return number


def free_ends(s, d, slack):
    """Whether the low and the high end of each cell [2, n] is none of another one's, next to which it lies."""
    free, keys = np.ones(s.shape, bool), np.round(s / slack).astype(np.int64)
    begins = {}
    for cell, key in enumerate(keys[0]):
        begins.setdefault(key, []).append(cell)
    ends = {}
    for cell, key in enumerate(keys[1]):
        ends.setdefault(key, []).append(cell)
    for key, cells in ends.items():
        others = [cell for near in (key - 1, key, key + 1) for cell in begins.get(near, ())]
        if others:
            touch = np.minimum(d[1, cells][:, None],
                               d[1, others]) - np.maximum(d[0, cells][:, None], d[0, others]) > slack
            free[1, cells] &= ~touch.any(axis=1)
            free[0, others] &= ~touch.any(axis=0)
    return free


class Column:
    """Planes of one strike, joined along it: cells, their edges s and d [2, n], their left and right ends from the
    upper to the lower corner [n, 2, 2, 3], and whether those are of no neighbours [2, n]."""

    def __init__(self, index, s, d, ends, slack):
        self.index, self.s, self.d, self.ends = index, s, d, ends
        self.free = free_ends(s, d, slack)

    def flip(self):
        self.s, self.ends, self.free = -self.s[::-1], self.ends[:, ::-1], self.free[::-1]


class Strike:
    """Cells of one strike or its opposite, seen from one side: r is to the right of the strike, z down."""

    def __init__(self, cells, index):
        own = cells[index]
        angle = np.radians(own[0, 5])
        angle += np.pi * (np.cos(angle - np.radians(axis_along_strike(own[:, 5], own[:, 3] * own[:, 4]))) < 0)
        same = np.where(np.cos(np.radians(own[:, 5]) - angle) > 0, 1.0, -1.0)
        self.index = index
        s = own[:, 0] * np.cos(angle) + own[:, 1] * np.sin(angle)
        self.s = np.stack([s - own[:, 3] / 2, s + own[:, 3] / 2])
        dip = np.radians(own[:, 6])
        self.down = np.stack([np.where(own[:, 6] == 90, 0.0, same * np.cos(dip)), np.sin(dip)])
        centre = np.stack([own[:, 1] * np.cos(angle) - own[:, 0] * np.sin(angle), own[:, 2]])
        # [upper and lower, r and z, n]
        self.edges = centre + np.array([-0.5, 0.5])[:, None, None] * own[:, 4] * self.down
        along = (centre * self.down).sum(axis=0)
        self.d = np.stack([along - own[:, 4] / 2, along + own[:, 4] / 2])
        self.slack = EDGE * own[:, 3:5].min()
        corners = corners_of(own)
        ends = np.stack([corners[:, (0, LEFT)], corners[:, (RIGHT, RIGHT + 1)]], axis=1)
        self.ends = np.where((same > 0)[:, None, None, None], ends, ends[:, ::-1])

    def planes(self):
        """Cells of each plane, in the order of their first ones."""
        dip = groups(np.degrees(np.arctan2(self.down[1], self.down[0])), ANGLE)
        number = np.zeros(len(dip), int)
        for k in np.unique(dip):  # their distances across
            own = np.flatnonzero(dip == k)
            normal = np.array([-self.down[1, own[0]], self.down[0, own[0]]])
            number[own] = number.max() + 1 + groups(normal @ self.edges[0][:, own], self.slack)
        first = {}
        for cell, k in enumerate(number):
            first.setdefault(k, []).append(cell)
        return [np.array(own) for own in first.values()]

    def lines(self, own):
        """Lines along strike of upper and of lower edges: r, z, d, from where and to where, [5, m] each."""
        found = []
        for side in (0, 1):
            _, which = np.unique(np.round(self.d[side, own] / self.slack), return_inverse=True)
            first = np.array([np.flatnonzero(which == k)[0] for k in range(which.max() + 1)])
            reach = [np.array([part[which == k].min() for k in range(which.max() + 1)])
                     for part in (self.s[0, own], -self.s[1, own])]
            found.append(np.stack([*self.edges[side][:, own[first]], self.d[side, own[first]], reach[0], -reach[1]]))
        return found

    def step(self, upper, lower):
        """What to add to d below a line that is lower edge of one and upper edge of the other; None: none is."""
        if upper[1][1].max() < lower[0][1].min() - self.slack or upper[1][1].min() > lower[0][1].max() + self.slack:
            return None
        a, b = upper[1][:, :, None], lower[0][:, None, :]
        meets = (np.hypot(a[0] - b[0], a[1] - b[1]) < self.slack) & (np.minimum(a[4], b[4])
                                                                     - np.maximum(a[3], b[3]) > self.slack)
        where = np.argwhere(meets)
        return a[2, where[0][0], 0] - b[2, 0, where[0][1]] if len(where) else None

    def columns(self):
        planes = self.planes()
        lines = [self.lines(own) for own in planes]
        left, found = list(range(len(planes))), []
        while left:
            inside, shift, queue = [left[0]], {left[0]: 0.0}, [left.pop(0)]
            while queue:
                p = queue.pop(0)
                for q in list(left):
                    down, up = self.step(lines[p], lines[q]), self.step(lines[q], lines[p])
                    more = down if down is not None else -up if up is not None else None
                    if more is None:
                        continue
                    d = self.d[:, planes[q]] + shift[p] + more
                    if any(overlap(self.s[:, planes[q]], d, self.s[:, planes[k]], self.d[:, planes[k]] + shift[k],
                                   self.slack) for k in inside):
                        continue
                    shift[q] = shift[p] + more
                    inside.append(q)
                    queue.append(q)
                    left.remove(q)
            own = np.concatenate([planes[k] for k in inside])
            d = np.concatenate([self.d[:, planes[k]] + shift[k] for k in inside], axis=1)
            found.append(Column(self.index[own], self.s[:, own], d, self.ends[own], self.slack))
        return found


def distances(points, ends):
    """Of points [n, 3] from lines [m, 2, 3] between two corners: [n, m]."""
    reach = ends[:, 1] - ends[:, 0]
    away = points[:, None] - ends[:, 0]
    share = np.clip((away * reach).sum(axis=2) / (reach ** 2).sum(axis=1), 0, 1)
    return np.linalg.norm(away - share[..., None] * reach, axis=2)


def meeting(column, other, cells):
    """The ends, 0 low and 1 high, at which two columns meet, and what to add to the other's d; or None."""
    best = None
    for side in (1, 0):
        for facing in (0, 1):
            if np.sum((column.ends[0, side] - column.ends[0, 1 - side])
                      * (other.ends[0, facing] - other.ends[0, 1 - facing])) >= 0:
                continue  # they go off in one direction
            rim = [np.flatnonzero(column.free[side]), np.flatnonzero(other.free[facing])]
            if not all(map(len, rim)):
                continue
            a, b = column.ends[rim[0], side], other.ends[rim[1], facing]
            near = np.minimum(np.minimum(*(distances(b[:, k], a).T for k in (0, 1))),
                              np.minimum(*(distances(a[:, k], b) for k in (0, 1))))
            own = [cells[one.index[ends], 3:5].min(axis=1) for one, ends in ((column, rim[0]), (other, rim[1]))]
            i, j = np.nonzero(near <= NEAR * np.maximum(own[0][:, None], own[1]))
            if len(i) and (best is None or len(i) > best[0]):
                i, j = rim[0][i], rim[1][j]
                below = other.ends[j, facing, :, 2].mean(axis=1) - column.ends[i, side, :, 2].mean(axis=1)
                deeper = below / np.sin(np.radians(cells[column.index[i], 6]))
                best = len(i), side, facing, np.median(column.d[:, i].mean(axis=0) + deeper
                                                       - other.d[:, j].mean(axis=0))
    return best and best[1:]


def row_numbers(d, slack):
    """The row of each cell; None: their intervals down dip are neither the same nor apart."""
    _, first, number = np.unique(np.round(d[0] / slack), return_index=True, return_inverse=True)
    low, high = d[:, first]
    if (np.abs(d - d[:, first][:, number]) > 2 * slack).any() or (high[:-1] > low[1:] + 2 * slack).any():
        return None
    return number


def put_beside(column, other, side, slack):
    """The other's s [2, n], with each row moved to where the column ends on this side, 0 low and 1 high."""
    sign = 1 if side else -1
    middle, number = np.unique(np.round(other.d.mean(axis=0) / slack), return_inverse=True)
    middle, end = middle * slack, np.full(len(middle), np.nan)
    last = np.argsort(-sign * column.s[side])  # a cell further out comes first
    low, high, farthest = column.d[0, last], column.d[1, last], column.s[side, last]
    for k, deep in enumerate(middle):
        there = (low <= deep) & (deep < high)
        if there.any():
            end[k] = farthest[there.argmax()]
    known = np.isfinite(end)
    if known.any():
        nearest = np.abs(middle[:, None] - middle[known]).argmin(axis=1)
        end = np.where(known, end, end[known][nearest])
    else:
        end[:] = farthest[0]
    end, begin, rows = end[number], other.s[1 - side], row_numbers(other.d, slack)
    if rows is None:
        return other.s + sign * (sign * (end - begin)).max()
    shift = np.array([sign * (sign * (end - begin)[rows == k]).max() for k in range(rows.max() + 1)])
    return other.s + (shift.mean() if np.ptp(shift) < slack else shift[rows])


def unroll(cells):
    """Parts of a fault, [(cells, s [2, n], d [2, n])] in m, from cells [N, 7]; see above."""
    strike = groups(np.mod(cells[:, 5], 180.0), ANGLE, 180.0)
    left = [column for k in np.unique(strike) for column in Strike(cells, np.flatnonzero(strike == k)).columns()]
    left.sort(key=lambda column: column.index.min())
    slack, wide = EDGE * cells[:, 3:5].min(), NEAR * cells[:, 3:5].min(axis=1).max()
    for k, column in enumerate(left):
        column.number = k
    low, high = (np.array([limit(column.ends.reshape(-1, 3), axis=0) for column in left]) for limit in (np.min, np.max))
    parts = []
    while left:
        inside = [left.pop(0)]
        queue, s, d = list(inside), inside[0].s, inside[0].d
        while queue:
            column = queue.pop(0)
            close = ((low <= high[column.number] + wide) & (high >= low[column.number] - wide)).all(axis=1)
            for other in [one for one in left if close[one.number]]:
                meets = meeting(column, other, cells)
                if meets is None:
                    continue
                side, facing, deeper = meets
                kept = other.s, other.d, other.ends, other.free
                if side == facing:
                    other.flip()
                other.d = other.d + deeper
                other.s = put_beside(column, other, side, slack)
                if overlap(other.s, other.d, s, d, 2 * slack):
                    other.s, other.d, other.ends, other.free = kept
                    continue
                s, d = np.concatenate([s, other.s], axis=1), np.concatenate([d, other.d], axis=1)
                inside.append(other)
                queue.append(other)
                left.remove(other)
        index = np.concatenate([column.index for column in inside])
        order = np.argsort(index)
        s, d = s[:, order], d[:, order]
        parts.append((index[order], s, d if (cells[index, 6] == 90).all() else d - d.min()))
    return parts
