"""Cells of a run or catalogue in space: rectangles of any strike and dip, their corners, and the edges that none of
them share."""

import numpy as np

from ..errors import OutputError

# of a cell, along strike and down dip: from its upper left one
CORNERS = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
UPPER, RIGHT, LOWER, LEFT = range(4)  # edges, each from its corner to the next
EDGE = 1e-3  # of its size: how near to its neighbour's a cell's edge is the same one


def directions(cells):
    """Unit vectors [N, 3] along strike and down dip, north, east and down."""
    strike, dip = np.radians(cells[:, 5]), np.radians(cells[:, 6])
    return (np.stack([np.cos(strike), np.sin(strike), 0 * strike], axis=1),
            np.stack([-np.sin(strike) * np.cos(dip), np.cos(strike) * np.cos(dip), np.sin(dip)], axis=1))


def axis_along_strike(strikes, weights):
    """Direction [degrees, from 0 to below 360] of the axis along strike of a picture, from strikes [N] and weights as
    areas [N]: the mean line of all strikes, whichever of its two directions each has, in the direction that most of
    them have, or where neither is, the first."""
    turn = np.exp(1j * np.radians(strikes))
    line = (np.exp(0.5j * np.angle(weights @ turn ** 2)) if np.abs(weights @ turn ** 2) > 1e-9 * np.sum(weights)
            else turn[0])
    sense = weights @ (turn / line).real
    sense = sense if abs(sense) > 1e-9 * np.sum(weights) else (turn[0] / line).real
    return float(np.round(np.degrees(np.angle(line if sense >= 0 else -line)), 9) % 360)


def corners_of(cells):
    """[N, 4, 3]: upper left, upper right, lower right, lower left, north, east and down [m], of cells [N, 7]."""
    along, down = directions(cells)
    return (cells[:, None, :3] + CORNERS[:, :1] * (cells[:, 3, None] * along)[:, None]
            + CORNERS[:, 1:] * (cells[:, 4, None] * down)[:, None])


def grid_cells(of):
    """[N, 7] of a grid by its extents, as the library has them."""
    nx, nz = int(of["nx"]), int(of["nz"])
    strike, dip = np.radians(of["strike"]), np.radians(of["dip"])
    s, d = np.meshgrid((np.arange(nx) + 0.5) * of["length_x"] / nx, (np.arange(nz) + 0.5) * of["length_z"] / nz)
    s, d = s.ravel(), d.ravel()
    right = d * np.cos(dip)
    columns = (np.cos(strike) * s - np.sin(strike) * right, np.sin(strike) * s + np.cos(strike) * right,
               of["depth_top"] + d * np.sin(dip), of["length_x"] / nx, of["length_z"] / nz, of["strike"], of["dip"])
    return np.stack(np.broadcast_arrays(*columns), axis=1)


def mesh_cells(mesh):
    """[N, 7] of a mesh: x, y, z of the centre, length, width [m], strike and dip [degrees]."""
    n = len(mesh["x"])
    columns = [mesh[name] for name in ("x", "y", "z", "length", "width")]
    return np.stack(columns + [mesh.get("strike", np.zeros(n)), mesh.get("dip", np.full(n, 90.0))],
                    axis=1).astype(float)


def cells_of(path, mesh, of):
    """[N, 7], of triangles centroids and extents, and the shape of a grid; of: its extents."""
    if "length" in mesh:
        return mesh_cells(mesh), None
    missing = [name for name in ("length_x", "length_z", "depth_top") if name not in of]
    if missing:
        raise OutputError(f"{path}: the {missing[0]} of the grid is missing; expected a file of SlipStep 0.3 or later")
    nz, nx = len(mesh["z"]), len(mesh["x"])
    return grid_cells({"strike": 0.0, "dip": 90.0, **of, "nx": nx, "nz": nz}), (nz, nx)


def triangles_of(mesh):
    """Corners [N, 3, 3], north, east and down [m], of a mesh of triangles; None of another one."""
    return mesh["vertices"][mesh["triangles"].astype(int)] if "triangles" in mesh else None


def normals(corners):
    """Of triangles [..., 3, 3], as long as twice their area."""
    return np.cross(corners[..., 1, :] - corners[..., 0, :], corners[..., 2, :] - corners[..., 0, :])


def level_of(triangles, depth):
    """Where triangles [N, 3, 3] are at a depth [m]: [n, 2, 3]."""
    below = triangles[:, :, 2] > depth
    cut = triangles[below.any(axis=1) & ~below.all(axis=1)]
    ends = []
    for begin, end in zip(cut, np.roll(cut, -1, axis=1)):
        for a, b in zip(begin, end):
            if (a[2] > depth) != (b[2] > depth):
                ends.append(a + (depth - a[2]) / (b[2] - a[2]) * (b - a))
    return np.reshape(ends, (-1, 2, 3))


def free_sides(triangles):
    """Sides [n, 2, 3] of triangles that no other one has: those on upper ends, and all others."""
    sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    key = np.sort(np.unique(sides.reshape(-1, 3), axis=0, return_inverse=True)[1].reshape(-1, 2), axis=1)
    _, place, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    free = count[place.reshape(-1)] == 1
    other = np.roll(triangles, -2, axis=1).reshape(-1, 3)  # the corner across
    normal = normals(triangles)
    sine = np.repeat(np.hypot(normal[:, 0], normal[:, 1]) / np.linalg.norm(normal, axis=1), 3)  # of the dip
    along = np.abs(sides[:, 1, 2] - sides[:, 0, 2]) < 0.5 * sine * np.linalg.norm(sides[:, 1] - sides[:, 0], axis=1)
    upper = free & along & (sides[:, :, 2].mean(axis=1) < other[:, 2])
    return sides[upper], sides[free & ~upper]


def free_edges(corners, shape=None):
    """Edges that cells do not share [m], [n, 2, 3] each: upper ones, and all others; shape: of a grid."""
    if shape:
        nz, nx = shape
        upper = np.stack([corners[0, 0], corners[nx - 1, 1]])
        right, lower, left = corners[-1, 2], corners[(nz - 1) * nx, 3], corners[0, 0]
        return upper[None], np.array([[upper[1], right], [right, lower], [lower, left]])
    edges = {side: corners[:, (side, (side + 1) % 4)] for side in (UPPER, RIGHT, LOWER, LEFT)}
    free = {side: edges[side][~_touches(edges[side], edges[(side + 2) % 4])] for side in edges}
    return free[UPPER], np.concatenate([free[RIGHT], free[LOWER], free[LEFT]])


def _touches(edges, others):
    """Whether the middle of each edge [n, 2, 3] lies on one of the others: on the middle of most, by a table."""
    middle, begin, reach = edges.mean(axis=1), others[:, 0], others[:, 1] - others[:, 0]
    size = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    unit = EDGE * size.min()
    known = {tuple(key) for key in np.round(others.mean(axis=1) / unit).astype(np.int64).tolist()}
    found = np.array([tuple(key) in known for key in np.round(middle / unit).astype(np.int64).tolist()])
    for k in np.flatnonzero(~found):
        share = np.clip(((middle[k] - begin) * reach).sum(axis=1) / (reach ** 2).sum(axis=1), 0, 1)
        found[k] = (((middle[k] - begin - share[:, None] * reach) ** 2).sum(axis=1) < (EDGE * size[k]) ** 2).any()
    return found
