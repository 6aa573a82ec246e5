#!/usr/bin/env python3
"""What stress that waves bring from one plane to others would need as hierarchical matrices in retarded time; what came
out is in tests/benchmarks/README.md, Waves.

    wave_networks.py [--planes 10] [--cells 100] [--size 200] [--gap 3000]

Parallel square planes of cells x cells. A block of receivers i and sources j whose clusters are at least their diameter
apart has g(t - r_ij/c)/r_ij = sum over l of f_l(t - a_i - b_j) A_l,ij, with a_i and b_j the delays between each cell
and the other cluster's centre: a few functions of time f_l, each with a matrix A_l of low rank. g is a pulse as wide as
a cell; its singular values say how many numbers an error takes.
"""

import argparse

import common  # noqa: F401: before modules that may be missing
import numpy as np

WIDE = 4  # standard deviations of a pulse that count
SIDE = 10  # cells along a side of the clusters whose ranks are found
APART = 1.0  # distance of clusters over their diameter, at least


def ranks(tolerance):
    """Functions of time, and the sum of the ranks of their matrices, of clusters of SIDE x SIDE cells whose centres are
    their diameter apart, on planes at 60 degrees."""
    along = np.arange(SIDE) - (SIDE - 1) / 2
    x, y = (axis.ravel() for axis in np.meshgrid(along, along))
    centre = APART * SIDE * np.sqrt(2) * np.array([0.60, 0.50, 0.62])
    sources = np.column_stack([x, y, 0 * x])
    receivers = centre + np.column_stack([x / 2, y, x * np.sqrt(3) / 2])
    distance = np.linalg.norm(receivers[:, None] - sources, axis=2)
    late = distance - np.linalg.norm(receivers, axis=1)[:, None] - (np.linalg.norm(centre - sources, axis=1)
                                                                    - np.linalg.norm(centre))
    time = np.arange(late.min() - WIDE, late.max() + WIDE, 0.5)
    pulses = np.exp(-0.5 * (time - late[..., None]) ** 2) / distance[..., None]
    left, values, _ = np.linalg.svd(pulses.reshape(-1, len(time)), full_matrices=False)
    functions = int((values > tolerance * values[0]).sum())
    return functions, sum(int((np.linalg.svd((left[:, k] * values[k]).reshape(late.shape), compute_uv=False) > tolerance
                               * values[0]).sum()) for k in range(functions))


def blocks(cells, size, gap):
    """Of a pair of planes: rows and columns of all blocks of low rank, and pairs of cells beside them."""
    count = {"sides": 0, "near": 0}

    def split(one, other, n):
        width = n * size
        apart = np.sqrt(sum(max(0.0, abs(p - q) - width) ** 2 for p, q in zip(one, other)) + gap ** 2)
        if apart >= APART * width * np.sqrt(2):
            count["sides"] += 2 * n * n
        elif n <= SIDE:
            count["near"] += n ** 4
        else:
            parts = [(u, v) for u in (-width / 4, width / 4) for v in (-width / 4, width / 4)]
            for p in parts:
                for q in parts:
                    split((one[0] + p[0], one[1] + p[1]), (other[0] + q[0], other[1] + q[1]), n / 2)

    split((0.0, 0.0), (0.0, 0.0), cells)
    return count["sides"], count["near"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--planes", type=int, default=10, metavar="N")
    parser.add_argument("--cells", type=int, default=100, metavar="N", help="along each side of a plane")
    parser.add_argument("--size", type=float, default=200.0, metavar="M", help="of cells [m]")
    parser.add_argument("--gap", type=float, default=3000.0, metavar="M", help="between planes [m]")
    a = parser.parse_args()
    sides = near = 0
    for k in range(1, a.planes):
        pair = blocks(a.cells, a.size, k * a.gap)
        sides, near = sides + 2 * (a.planes - k) * pair[0], near + 2 * (a.planes - k) * pair[1]
    print(f"{a.planes} planes of {a.cells ** 2} cells, {a.gap:g} m apart: {sides:.3g} rows and columns of blocks, "
          f"{near:.3g} pairs of cells in none")
    for tolerance in 1e-2, 1e-3:
        functions, rank = ranks(tolerance)
        print(f"error {tolerance:g}: {functions} functions of time, ranks {rank} in all, {4e-9 * rank * sides:.1f} GB "
              "in single precision for each wave, component of slip and of stress")


if __name__ == "__main__":
    main()
