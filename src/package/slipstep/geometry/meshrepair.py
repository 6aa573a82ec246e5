"""Surfaces of triangles that a run can use: what rises above the ground is cut, moved or draped, and needles and folds
are taken away. Each function says in a line what it did. Surfaces that shared vertices share them afterwards: a vertex
has one place, and an edge is cut once."""

import numpy as np

from .cells import normals

# share of an edge: a vertex that near to where its edges meet the ground is moved there, as cutting would leave a
# needle
SNAP = 0.1
NEEDLE = 0.02  # height over the longest side of triangles that are taken away, twice what a run refuses
# shortest side over the longest: a needle with such a side has its ends made one, another one its neighbours cut
SHORT = 0.05
FOLD = 1.5  # [degrees] between neighbours, of which a run refuses less than 1
ROUNDS = 60


class Mesh:
    """vertices [V, 3], north, east, down; triangles [N, 3]; of each the file's triangle and the fault's label."""

    def __init__(self, vertices, triangles, label):
        self.vertices, self.triangles, self.label = np.array(vertices,
                                                             float), np.array(triangles, int), np.array(label, int)
        self.parent = np.arange(len(triangles))

    def set(self, triangles, parent):
        """Other triangles, each of a triangle of the file"""
        known = dict(zip(self.parent.tolist(), self.label.tolist()))
        self.triangles, self.parent = np.array(triangles, int).reshape(-1, 3), np.array(parent, int)
        self.label = np.array([known[k] for k in self.parent.tolist()], int)

    def pack(self):
        """Without vertices that no triangle has"""
        used, place = np.unique(self.triangles, return_inverse=True)
        self.vertices, self.triangles = self.vertices[used], place.reshape(-1, 3)

    @property
    def area(self):
        return 0.5 * np.linalg.norm(normals(self.vertices[self.triangles]), axis=1).sum()


def sides(corners):
    """Lengths [..., 3] from each corner to the next"""
    return np.linalg.norm(np.roll(corners, -1, axis=-2) - corners, axis=-1)


def slender(corners):
    """Heights over longest sides"""
    longest = sides(corners).max(axis=-1)
    return np.linalg.norm(normals(corners), axis=-1) / np.maximum(longest, np.finfo(float).tiny) ** 2


def edges_of(triangles):
    """{(low, high): [triangle, ...]}"""
    found = {}
    for k, corners in enumerate(triangles.tolist()):
        for a, b in zip(corners, corners[1:] + corners[:1]):
            found.setdefault((min(a, b), max(a, b)), []).append(k)
    return found


# ---- the ground ----

def rising(mesh):
    """How many triangles reach above the ground, and how far: more than rounding of the coordinates"""
    up = -mesh.vertices[mesh.triangles][:, :, 2]
    above = up.max(axis=1) > 1e-9 * np.abs(mesh.vertices).max()
    return int(above.sum()), float(up.max())


def shift(mesh):
    by = max(0.0, float(-mesh.vertices[:, 2].min()))
    mesh.vertices[:, 2] += by
    return f"shifted down by {by:.6g}"


def trace_of(mesh):
    """Edges [n, 2, 3] where the surface ends above the ground, but those that lead down from there"""
    edges = np.array([edge for edge, of in edges_of(mesh.triangles).items() if len(of) == 1], int).reshape(-1, 2)
    ends = mesh.vertices[edges]
    step = ends[:, 1] - ends[:, 0]
    above = ends[:, :, 2] < 0
    return ends[above.all(axis=1) | (above.any(axis=1) & (np.hypot(step[:, 0], step[:, 1]) > np.abs(step[:, 2])))]


def elevation_of(trace, points):
    """Elevation [V] of the ground at the nearest point of the trace [n, 2, 3]; 0 where it is below."""
    begin, step = trace[:, 0], trace[:, 1] - trace[:, 0]
    length2 = np.maximum(step[:, 0] ** 2 + step[:, 1] ** 2, np.finfo(float).tiny)
    found = np.zeros(len(points))
    for first in range(0, len(points), 1024):
        away = points[first:first + 1024, None, :2] - begin[:, :2]
        share = np.clip((away * step[:, :2]).sum(axis=2) / length2, 0, 1)
        near = ((away - share[..., None] * step[:, :2]) ** 2).sum(axis=2).argmin(axis=1)
        depth = begin[near, 2] + share[np.arange(len(near)), near] * step[near, 2]
        found[first:first + 1024] = np.maximum(0, -depth)
    return found


def flatten(mesh):
    trace = trace_of(mesh)
    if not len(trace):
        return "flattened: nothing ends above the ground"
    by = elevation_of(trace, mesh.vertices)
    mesh.vertices[:, 2] += by
    touch = np.abs(mesh.vertices[:, 2]) < 1e-9 * np.abs(mesh.vertices).max()
    mesh.vertices[touch, 2] = 0.0
    return (f"flattened: {int((by > 0).sum())} vertices moved down by the elevation of the nearest end of the surface, "
            f"{by[by > 0].mean():.6g} on average, {by.max():.6g} at most")


def clip(mesh):
    before, count = mesh.area, len(mesh.triangles)
    most, moved = _snap(mesh)
    z = mesh.vertices[:, 2]
    vertices, cut = mesh.vertices.tolist(), {}

    def ground(a, b):
        """The vertex where an edge meets the ground"""
        key = (min(a, b), max(a, b))
        if key not in cut:
            p, q = mesh.vertices[key[0]], mesh.vertices[key[1]]
            place = p + p[2] / (p[2] - q[2]) * (q - p)
            cut[key] = len(vertices)
            vertices.append([place[0], place[1], 0.0])
        return cut[key]

    triangles, parent, pieces = [], [], 0
    for own, corners in zip(mesh.parent.tolist(), mesh.triangles.tolist()):
        if (z[corners] >= 0).all() and (z[corners] > 0).any():
            new = [corners]
        else:
            outline = []  # of what is below the ground, around the triangle
            for a, b in zip(corners, corners[1:] + corners[:1]):
                outline += [a] if z[a] >= 0 else []
                outline += [ground(a, b)] if z[a] * z[b] < 0 else []
            new = [] if not (z[corners] > 0).any() or len(outline) < 3 else [outline]
            if new and len(outline) == 4:
                p = np.array([vertices[v] for v in outline])
                turn = int(np.linalg.norm(p[0] - p[2]) > np.linalg.norm(p[1] - p[3]))  # along the shorter diagonal
                o = outline[turn:] + outline[:turn]
                new = [[o[0], o[1], o[2]], [o[0], o[2], o[3]]]
            pieces += len(new)
        triangles += new
        parent += [own] * len(new)
    mesh.vertices = np.array(vertices)
    mesh.set(triangles, parent)
    if len(triangles):
        mesh.pack()
    words = (f"clipped: {count} triangles became {len(triangles)}, {pieces} of them cut at the ground; area "
             f"{before:.6g} became {mesh.area:.6g}, {100 * (1 - mesh.area / before):.3g} % less")
    return words + (f"; {moved} vertices near the ground moved along their edges onto it, by up to {most:.6g}" if moved
                    else "")


def _snap(mesh):
    """Vertices to where their edges meet the ground, where that is near; the largest move, and how many"""
    edges = np.array(list(edges_of(mesh.triangles)), int)
    ends = mesh.vertices[edges]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    shortest = np.full(len(mesh.vertices), np.inf)
    for side in (0, 1):
        np.minimum.at(shortest, edges[:, side], length)
    near = {}
    for k in np.flatnonzero(ends[:, 0, 2] * ends[:, 1, 2] < 0):
        share = ends[k, 0, 2] / (ends[k, 0, 2] - ends[k, 1, 2])
        place = ends[k, 0] + share * (ends[k, 1] - ends[k, 0])
        for vertex, part in zip(edges[k].tolist(), (share, 1 - share)):
            if part < SNAP and part * length[k] < 2 * SNAP * shortest[vertex]:
                near.setdefault(vertex, []).append((part * length[k], place))
    most = 0.0
    for vertex, places in near.items():
        by, place = min(places, key=lambda item: item[0])
        mesh.vertices[vertex] = place[0], place[1], 0.0
        most = max(most, by)
    return most, len(near)


# ---- needles and folds ----

class _Round:
    """One pass over a mesh, in which a vertex is concerned once."""

    def __init__(self, mesh):
        self.mesh, self.edges = mesh, edges_of(mesh.triangles)
        self.of = {}
        for k, corners in enumerate(mesh.triangles.tolist()):
            for vertex in corners:
                self.of.setdefault(vertex, []).append(k)
        ends = [edge for edge, of in self.edges.items() if len(of) != 2 or mesh.label[of[0]] != mesh.label[of[1]]]
        self.ends, self.end_edges = {v for edge in ends for v in edge}, set(ends)
        self.touched, self.gone, self.new, self.parent = set(), set(), [], []

    def corners(self, triangles):
        return self.mesh.vertices[np.array(triangles, int)]

    def free(self, triangles):
        return not any(v in self.touched for k in triangles for v in self.mesh.triangles[k])

    def replace(self, old, new, parent):
        self.touched |= {v for k in old for v in self.mesh.triangles[k].tolist()}
        self.gone |= set(old)
        self.new += new
        self.parent += parent

    def finish(self):
        if not self.gone:
            return
        kept = [k for k in range(len(self.mesh.triangles)) if k not in self.gone]
        self.mesh.set(self.mesh.triangles[kept].tolist() + self.new, self.mesh.parent[kept].tolist() + self.parent)

    def faces_as(self, new, old):
        """Do triangles look the way the one they come from does, and are they no needles?"""
        made = self.corners(new)
        return bool(((normals(made) * normals(self.corners(old))).sum(axis=-1) > 0).all()
                    and (slender(made) > 1e-3).all())

    def collapse(self, kept, gone):
        """Vertex gone becomes kept; what is said of it"""
        mesh = self.mesh
        if gone in self.ends and (kept not in self.ends or (min(kept, gone), max(kept, gone)) not in self.end_edges):
            return False
        if mesh.vertices[gone, 2] == 0 and mesh.vertices[kept, 2] != 0:
            return False
        star = self.of[gone]
        if not self.free(star) or kept in self.touched:
            return False
        both = [k for k in star if kept in mesh.triangles[k]]
        rest = [k for k in star if kept not in mesh.triangles[k]]
        across = {v for k in both for v in mesh.triangles[k].tolist()} - {kept, gone}
        around = {v for k in star for v in mesh.triangles[k].tolist()} & {v for k in self.of[kept]
                                                                          for v in mesh.triangles[k].tolist()}
        if around - {kept, gone} != across:
            return False
        new = [[kept if v == gone else v for v in mesh.triangles[k].tolist()] for k in rest]
        if rest and not self.faces_as(new, mesh.triangles[rest]):
            return False
        self.replace(star, new, mesh.parent[rest].tolist())
        return True

    def cut(self, needle):
        """The neighbours across the longest side are cut at the corner on it; of none, the needle alone goes."""
        mesh = self.mesh
        corners = mesh.triangles[needle].tolist()
        first = int(sides(self.corners(corners)).argmax())
        u, v, w = (corners[(first + k) % 3] for k in range(3))
        beyond = [k for k in self.edges[min(u, v), max(u, v)] if k != needle]
        if not self.free([needle, *beyond]) or any(w in mesh.triangles[k] for k in beyond):
            return False
        new, parent = [], []
        for k in beyond:
            own = mesh.triangles[k].tolist()
            pair = [[w if x == v else x for x in own], [w if x == u else x for x in own]]
            if not self.faces_as(pair, mesh.triangles[[k, k]]):
                return False
            new += pair
            parent += [mesh.parent[k]] * 2
        self.replace([needle, *beyond], new, parent)
        return True

    def turn(self, edge, one, other):
        """The edge of two triangles, one folded on the other, becomes that between their other corners."""
        mesh = self.mesh
        a, b = edge
        c, d = ([v for v in mesh.triangles[k].tolist() if v not in edge][0] for k in (one, other))
        if (c == d or (min(c, d), max(c, d)) in self.edges or mesh.label[one] != mesh.label[other]
            or not self.free([one, other])):
            return False
        base = mesh.triangles[other].tolist()  # in its sense of going around
        new = [[c if v == a else v for v in base], [c if v == b else v for v in base]]
        size = np.linalg.norm(normals(self.corners([*new, base, mesh.triangles[one]])), axis=1)
        # the other corner is within the triangle on which this one is folded
        inside = abs(size[0] + size[1] + size[3] - size[2]) < 0.01 * size[2]
        if not inside or not self.faces_as(new, mesh.triangles[[other, other]]):
            return False
        self.replace([one, other], new, [mesh.parent[other]] * 2)
        return True


def _needles(mesh, last):
    """One pass; last: those for which nothing else is found go"""
    collapsed = cut = dropped = 0
    most, now = 0.0, _Round(mesh)
    corners = mesh.vertices[mesh.triangles]
    share, lengths = slender(corners), sides(corners)
    for k in np.argsort(share, kind="stable").tolist():
        if not share[k] < NEEDLE:
            break
        if not now.free([k]):
            continue
        first = int(lengths[k].argmin())
        a, b = int(mesh.triangles[k, first]), int(mesh.triangles[k, (first + 1) % 3])
        if lengths[k, first] < SHORT * lengths[k].max() and (now.collapse(a, b) or now.collapse(b, a)):
            collapsed += 1
            most = max(most, float(lengths[k, first]))
        elif now.cut(k):
            cut += 1
        elif last:
            now.replace([k], [], [])
            dropped += 1
    now.finish()
    return collapsed, cut, dropped, most


def _folds(mesh, last):
    """Likewise: a triangle is removed only where no edge can be turned, as that of a vertex which has crossed one folds
    its triangle on three neighbours."""
    turned = dropped = 0
    now = _Round(mesh)
    for edge, one, other in folds_of(mesh, now.edges, FOLD):
        if not now.free([one, other]):
            continue
        small, large = sorted((one, other), key=lambda k: np.linalg.norm(normals(mesh.vertices[mesh.triangles[k]])))
        if len(now.edges[edge]) == 2 and now.turn(edge, small, large):
            turned += 1
        elif last:
            now.replace([small], [], [])
            dropped += 1
    now.finish()
    return turned, dropped


def folds_of(mesh, edges, least):
    """[(edge, triangle, other)] that meet at an edge with an angle below least [degrees]: 180 of a plane"""
    pairs = [(edge, one, other) for edge, of in edges.items() for i, one in enumerate(of) for other in of[i + 1:]]
    if not pairs:
        return []
    ends = np.array([edge for edge, _, _ in pairs])
    begin = mesh.vertices[ends[:, 0]]
    along = mesh.vertices[ends[:, 1]] - begin
    along /= np.maximum(np.linalg.norm(along, axis=1), np.finfo(float).tiny)[:, None]
    inward = []
    for side in (1, 2):
        corners = mesh.triangles[[pair[side] for pair in pairs]]
        across = mesh.vertices[corners.sum(axis=1) - ends.sum(axis=1)] - begin  # to the third corner
        across -= (across * along).sum(axis=1)[:, None] * along
        inward.append(across / np.maximum(np.linalg.norm(across, axis=1), np.finfo(float).tiny)[:, None])
    angle = 2 * np.degrees(np.arcsin(np.minimum(1.0, 0.5 * np.linalg.norm(inward[1] - inward[0], axis=1))))
    return [pairs[k] for k in np.flatnonzero(angle < least)]


def faults_of(mesh):
    """How many needles and folds a run would refuse"""
    # else the third corner of an edge is none
    proper = (np.sort(mesh.triangles, axis=1)[:, 1:] != np.sort(mesh.triangles, axis=1)[:, :-1]).all(axis=1)
    needles = int((slender(mesh.vertices[mesh.triangles]) < 0.01).sum())
    return needles, len(folds_of(mesh, edges_of(mesh.triangles), 1.0)) if proper.all() else 0


def repair(mesh):
    before, count = mesh.area, len(mesh.triangles)
    _, first = np.unique(np.sort(mesh.triangles, axis=1), axis=0, return_index=True)
    # a vertex twice is no triangle
    first = np.array([k for k in np.sort(first) if len(set(mesh.triangles[k].tolist())) == 3], int)
    twice = count - len(first)
    mesh.set(mesh.triangles[first].tolist(), mesh.parent[first].tolist())
    total, most, last = np.zeros(5, int), 0.0, False
    for _ in range(ROUNDS):
        collapsed, cut, dropped, by = _needles(mesh, last)
        turned, folded = _folds(mesh, last)
        done = np.array([collapsed, cut, dropped, turned, folded])
        total, most = total + done, max(most, by)
        if not done.any() and last:
            break
        last = not done.any()
    collapsed, cut, dropped, turned, folded = total.tolist()
    if len(mesh.triangles):
        mesh.pack()
    return (f"repaired: {count} triangles became {len(mesh.triangles)}: {twice} that were there twice or had no three "
            f"corners, {collapsed} needles made one vertex of their short side (moved by up to {most:.6g}), "
            f"{cut} cut into neighbours, {dropped} removed; {turned} folds turned, {folded} removed; area {before:.6g} "
            f"became {mesh.area:.6g}, {100 * (1 - mesh.area / before):.3g} % less")
