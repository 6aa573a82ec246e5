"""Cells in space: their corners and edges, faults drawn flat, what slip does around them, and where they are on the Earth."""
