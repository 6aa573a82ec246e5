"""Files of triangles that tests read: HDF5, and Gmsh 2.2 and 4.1 as text and in bytes, from the description of the
format."""

import os
import struct

import h5py
import numpy as np


def plane(cells, size, strike, dip, corner, flip=False):
    """Vertices [V, 3], north, east and down, of a plane of cells along strike and dip from its upper corner, and
    triangles [N, 3], two a cell with the diagonals in turn."""
    a, d = np.radians(strike), np.radians(dip)
    along = np.array([np.cos(a), np.sin(a), 0])
    down = np.array([-np.sin(a) * np.cos(d), np.cos(a) * np.cos(d), np.sin(d)])
    nx, nz = cells
    i, j = (k.ravel() for k in np.meshgrid(np.arange(nx + 1), np.arange(nz + 1)))
    vertices = np.asarray(corner, float) + np.outer(i * size[0], along) + np.outer(j * size[1], down)
    triangles = []
    for row in range(nz):
        for column in range(nx):
            p = row * (nx + 1) + column
            q, r, s = p + 1, p + nx + 1, p + nx + 2
            triangles += [[p, q, s], [p, s, r]] if (row + column) % 2 == 0 else [[p, q, r], [q, s, r]]
    return vertices, np.array(triangles)


def joined(*parts):
    """One mesh of several."""
    start = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate([triangles + s for (_, triangles), s
                                                                                in zip(parts, start)])


def write_hdf5(path, vertices, triangles, units="m", names=None, **more):
    with h5py.File(path, "w") as file:
        if vertices is not None:
            file["vertices"] = vertices
            if units is not None:
                file["vertices"].attrs["units"] = units
        if triangles is not None:
            file["triangles"] = triangles
        for name, data in more.items():
            file[name] = data
        if names is not None:
            file["fault"].attrs["names"] = names


def enu(vertices):
    """East, north and up of north, east and down."""
    return np.column_stack([vertices[:, 1], vertices[:, 0], -vertices[:, 2]])


def gmsh(version, binary, points, elements, names=(), groups=None, sections="", tag=1, end=True, length=1):
    """Bytes of a file. points [V, 3]; elements: (kind, surface, nodes from 0), surfaces are physical groups unless
    groups {surface: (group, ...)} says otherwise; names: (dim, group, name). length: elements in a block, where 2.2 and
    4.1 have blocks; above 1 there are more kinds of numbers to pass over too: nodes in two blocks of 4.1, of which one
    has their places on its surface, and boundaries of surfaces."""
    groups = {surface: (surface,) if surface else () for _, surface, _ in elements} if groups is None else groups
    dims = {15: 0, 1: 1, 2: 2, 3: 2, 9: 2, 16: 2, 4: 3, 8: 1}
    out = (f"$MeshFormat\n{version} {int(binary)} 8\n".encode() + (struct.pack("=i", 1) + b"\n" if binary else b"")
           + b"$EndMeshFormat\n")
    if names:
        out += (f"$PhysicalNames\n{len(names)}\n".encode()
                + b"".join(f'{dim} {group} "{name}"\n'.encode() for dim, group, name in names) + b"$EndPhysicalNames\n")
    out += sections.encode()

    blocks = []
    for k, element in enumerate(elements):
        if blocks and len(blocks[-1]) < length and elements[blocks[-1][0]][:2] == element[:2]:
            blocks[-1].append(k)
        else:
            blocks.append([k])

    def put(code, *values):
        if binary:
            return struct.pack("=" + code, *values)
        return (" ".join(repr(float(v)) if c == "d" else str(v) for c, v in zip(code, values)) + "\n").encode()

    if version == "4.1":
        surfaces = sorted({surface for kind, surface, _ in elements if dims[kind] == 2})
        out += b"$Entities\n" + put("QQQQ", 0, 0, len(surfaces), 0)
        for surface in surfaces:
            own = groups.get(surface, ())
            out += put("i" + "d" * 6 + "Q" + "i" * len(own) + "Q", surface, *points.min(axis=0), *points.max(axis=0),
                       len(own), *own, 3 * (length > 1)) + put("iii", 1, -2, 3) * (length > 1)
        half = len(points) // 2 if length > 1 else 0
        out += b"\n$EndEntities\n$Nodes\n" + put("QQQQ", 1 + (half > 0), len(points), tag, tag + len(points) - 1)
        for first, last, on in ((0, half, 1), (half, len(points), 0)):
            if last > first:
                out += put("iiiQ", 2, 1, on, last - first) + b"".join(put("Q", tag + k) for k in range(first, last))
                out += b"".join(put("ddd" + "dd" * on, *p, *(7.5, -3.5)[:2 * on]) for p in points[first:last])
        out += b"\n$EndNodes\n$Elements\n" + put("QQQQ", len(blocks), len(elements), tag, tag + len(elements) - 1)
        for block in blocks:
            kind, surface, _ = elements[block[0]]
            out += put("iiiQ", dims[kind], surface, kind, len(block))
            out += b"".join(put("Q" * (1 + len(elements[k][2])), tag + k, *(tag + n for n in elements[k][2]))
                            for k in block)
    else:
        out += f"$Nodes\n{len(points)}\n".encode() + b"".join(put("iddd", tag + k, *p) for k, p in enumerate(points))
        out += f"\n$EndNodes\n$Elements\n{len(elements)}\n".encode()
        for block in blocks:
            kind, surface, _ = elements[block[0]]
            group = (groups.get(surface) or (0,))[0]
            tags = (group, surface) + (1, 1) * (length > 1)  # and parts
            out += put("iii", kind, len(block), len(tags)) if binary else b""
            for k in block:
                own = (tag + k, *(() if binary else (kind, len(tags))), *tags, *(tag + n for n in elements[k][2]))
                out += put("i" * len(own), *own)
    return out + (b"\n$EndElements\n" if end else b"")


def write_gmsh(path, version, binary, vertices, triangles, label=None, **more):
    """Of triangles [N, 3] with vertices north, east and down, or quadrilaterals [N, 4]."""
    label = np.zeros(len(triangles), int) if label is None else label
    kind = {3: 2, 4: 3}[triangles.shape[1]]
    with open(path, "wb") as file:
        file.write(gmsh(version, binary, enu(vertices),
                        [(kind, int(f), [int(n) for n in t]) for t, f in zip(triangles, label)], **more))


def view(path, n):
    """[n, n] of -fault_stiffness_view binary:path: PETSc's integers, of 4 or 8 bytes, four, the length of each row, a
    column for each entry, and the entries"""
    integer = 4 if os.path.getsize(path) == 4 * (4 + n + n * n) + 8 * n * n else 8
    return np.fromfile(path, ">f8", offset=integer * (4 + n + n * n)).reshape(n, n)
