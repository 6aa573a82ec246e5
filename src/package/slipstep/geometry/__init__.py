"""Cells in space: their corners and edges, faults drawn flat, what slip does around them, where they are on the Earth,
and triangles in files of other programs."""
