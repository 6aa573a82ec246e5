"""Cells in space: their corners and edges, faults drawn flat, what slip does around them, where they are on the Earth;
and repairs of surfaces of triangles."""
