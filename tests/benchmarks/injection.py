#!/usr/bin/env python3
"""Fluid injected into a fault of constant friction f, quasi-static: edge and slip of the crack against exact ones.

    tests/benchmarks/injection.py [--build build] [--line 100 200 400 800] [--circle 20 40 60] [--shut-in 200 400]
    [--output F.h5]

A crack that grows into rock at its strength has no singular stress at its edge, which says where the edge is.

`line`: antiplane, one row of cells much longer (1000 km) than the crack is wide; slip along x, the crack grows along z
under the pressure of SEAS BP6. The stress drop of the crack, D(z) = tau0 - f (sigma - p(z)), has the stress intensity
integral_-a^a D/sqrt(a^2 - z^2) dz = 0, so (1/pi) integral_0^pi f p(a cos q) dq = f sigma - tau0 gives a, and the slip
is (2/(pi G)) integral_-a^a D(y) arccosh|(a^2 - z y)/(a (z - y))| dy.

`circle`: -fault_injection, p = p* E1(r^2/(4 D t)), nu = 0: then the wavenumber k of slip along x costs G k/2 of stress,
whatever its direction, and gives none along z, so that the crack is that of a scalar, and round. Abel's transform
inverts it: with g(s) = integral_0^s D(r) r/sqrt(s^2 - r^2) dr the slip is (4/(pi G)) integral_r^a g(s)/sqrt(s^2 - r^2)
ds (for a uniform D it is Eshelby's 4 D/(pi G) sqrt(a^2 - r^2)), whose edge is not singular where g(a) = 0: with a =
lambda sqrt(4 D t) integral_0^1 E1(lambda^2 x^2) x/sqrt(1 - x^2) dx = T, T = (f sigma - tau0)/(f p*). Both sides do not
depend on t: lambda is a number. Its limits are 1/sqrt(2 T) for T -> 0 and exp((2 - 0.5772 - T)/2)/2 for large T; T = 1
here.

`shut-in`: the line after the end of the injection at 100 days: where pressure falls the crack sticks again, from the
middle outwards, while its edge goes on, for which there is no closed form; compared with a model of its own, of the
antiplane kernel of strips in closed form, half as wide as the program's cells, with the increments of slip >= 0 of a
complementarity problem in 600 equal steps.

The edge in a run is where slip^(2/3), extrapolated from the outermost cells that have slipped, vanishes: the slip at an
edge without singular stress goes as its distance^(3/2).
"""

import argparse
import math
import os
import subprocess
import tempfile

from common import ROOT
import h5py
import numpy as np

DAY = 86400.0
G, FRICTION, SIGMA = 30e9, 0.6, 50e6
# BP6: hydraulic diffusivity [m^2/s], compressibility [1/Pa], porosity, flux [m/s], its end [s]
ALPHA, BETA, PHI, FLUX, STOP = 0.1, 1e-8, 0.1, 1.25e-6, 100 * DAY
LINE_LOAD = FRICTION * SIGMA - 0.8e6  # tau0 [Pa]
LINE_HALF, LINE_LENGTH, DEPTH = 3200.0, 1e6, 10e3
LINE_DAYS = (10.0, 50.0, 100.0)
SHUT_DAYS = (110.0, 125.0, 150.0)
SOURCE, CIRCLE_T, CIRCLE_END = 1e6, 1.0, 20 * DAY  # p* [Pa], T, end [s]
CIRCLE_SHARES = (0.1, 0.4, 1.0)  # of the end, where edges are compared
COMMON = ["-fault_kernel", "full_space", "-fault_friction_law", "constant", "-fault_friction_residual", str(FRICTION),
          "-fault_normal_stress", str(SIGMA), "-fault_normal_stress_gradient", "0", "-fault_shear_modulus", str(G),
          "-fault_initial", "traction", "-fault_inertia", "no", "-fault_viscosity", "radiation", "-fault_progress",
          "no"]
erfc = np.vectorize(math.erfc)


def run(build, folder, options):
    """Times [m], slip [m, Nz, Nx] and the numbers of accepted and rejected steps of a run."""
    out = os.path.join(folder, "run.h5")
    if os.path.exists(out):
        os.remove(out)
    command = [os.path.join(build, "bin", "fault"), *COMMON, *options, "-fault_output", out, "-fault_output_fields",
               "slip"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    if done.returncode:
        raise SystemExit(f"{' '.join(command)} failed:\n{done.stderr}")
    with h5py.File(out) as f:
        return f["fields/time"][...], f["fields/slip"][...], f["result"].attrs["accepted"], f["result"].attrs[
            "rejected"]


# ---- line ----

def line_pressure(z, t):
    """BP6 [Pa]"""
    def spread(t):
        if t <= 0:
            return 0 * z
        x = abs(z) / math.sqrt(4 * ALPHA * t)
        return math.sqrt(t) * (np.exp(-x * x) / math.sqrt(math.pi) - x * erfc(x))
    z = np.asarray(z, float)
    return FLUX / (BETA * PHI * math.sqrt(ALPHA)) * (spread(t) - spread(t - STOP))


def bisect(f, low, high):
    """Where the falling f vanishes"""
    for _ in range(100):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if f(middle) > 0 else (low, middle)
    return low


def line_edge(t):
    q = (np.arange(2000) + 0.5) / 2000 * np.pi
    return bisect(lambda a: np.mean(FRICTION * line_pressure(a * np.cos(q), t)) - (FRICTION * SIGMA - LINE_LOAD), 1e-3,
                  1e5)


def line_slip(t):
    """In the middle: y = a sin q takes the root out of the edge; midpoints keep off the logarithm at y = 0."""
    a = line_edge(t)
    q = (np.arange(20000) + 0.5) / 20000 * np.pi / 2
    y = a * np.sin(q)
    drop = LINE_LOAD - FRICTION * (SIGMA - line_pressure(y, t))
    return 2 * 2 / (np.pi * G) * np.mean(drop * np.arccosh(a / y) * a * np.cos(q)) * np.pi / 2


def line_times(end):
    """Of the record: dense at first, where the pressure grows as sqrt(t), and after the end of the injection"""
    times = np.concatenate([STOP * (np.arange(61) / 60) ** 2, DAY * np.array(LINE_DAYS + SHUT_DAYS),
                            STOP + 50 * DAY * (np.arange(41) / 40) ** 2])
    times = np.unique(np.round(times))
    return times[times <= end + 1]


def line_run(build, folder, n, days, options=()):
    """Depth of the centres from the middle [n], slip on the days [days, n], each the end of a run, steps of the last
    one."""
    h = 2 * LINE_HALF / n
    z = (np.arange(n) + 0.5) * h - LINE_HALF
    times = line_times(days[-1] * DAY)
    with h5py.File(os.path.join(folder, "pressure.h5"), "w") as f:
        f["time"] = times
        f["pressure"] = np.array([line_pressure(z, t) for t in times])[:, :, None]
    last = []
    for day in days:
        _, slip, *steps = run(build, folder, [
            "-fault_nx", "1", "-fault_nz", str(n), "-fault_length_x", str(LINE_LENGTH), "-fault_length_z",
            str(2 * LINE_HALF),
            "-fault_depth_top", str(DEPTH), "-fault_initial_traction", str(LINE_LOAD), "-fault_pore_pressure",
            "pressure.h5", "-ts_max_time", str(day * DAY), *options])
        last.append(slip[-1, :, 0])
    return z, np.array(last), tuple(steps)


def edge_of(z, slip, cells=6):
    edges = []
    for side in (1, -1):
        which = np.flatnonzero((slip > 0) & (side * z > 0))
        which = which[np.argsort(side * z[which])][-cells:]
        line = np.polyfit(side * z[which], slip[which] ** (2 / 3), 1)
        edges.append(-line[1] / line[0])
    return np.mean(edges)


def strips(n, times, days):
    """The model of the shut-in: slip of n strips across both halves of the line, which are alike, on the days"""
    h = 2 * LINE_HALF / n
    z = (np.arange(n // 2) + 0.5) * h

    def stress(c):  # of unit slip of a strip around c
        return G / (2 * np.pi) * (1 / (z[:, None] - c - h / 2) - 1 / (z[:, None] - c + h / 2))
    K = -(stress(z[None, :]) + stress(-z[None, :]))
    slip, slides, kept = np.zeros(n // 2), np.zeros(n // 2, bool), []
    for t in times:
        excess = LINE_LOAD - FRICTION * (SIGMA - line_pressure(z, t)) - K @ slip
        for _ in range(100):  # primal-dual active set
            more = np.zeros(n // 2)
            which = np.flatnonzero(slides)
            if len(which):
                more[which] = np.linalg.solve(K[np.ix_(which, which)], excess[which])
            left = excess - K @ more
            new = np.where(slides, more > 0, left > 0)
            if (new == slides).all():
                break
            slides = new
        else:
            raise SystemExit("the sets of the model of strips do not settle")
        slip = slip + more
        if any(abs(t - d * DAY) < 1 for d in days):
            kept.append(slip.copy())
    return np.concatenate([-z[::-1], z]), np.array([np.concatenate([s[::-1], s]) for s in kept])


# ---- circle ----

def exponential_integral(x):
    """E1(x): the series, or the continued fraction from its far end (Abramowitz & Stegun 5.1.11, 5.1.22)."""
    x = np.asarray(x, float)
    series, term = -np.log(x) - 0.57721566490153286, np.ones_like(x)
    for k in range(1, 60):
        term = term * np.where(x <= 1, -x, 0) / k
        series = series - term / k
    tail = 0 * x
    for k in range(300, 0, -1):
        tail = k / (1 + k / (x + tail))
    return np.where(x <= 1, series, np.exp(-np.minimum(x, 700)) / (x + tail))


def circle_lambda(T):
    x, w = np.polynomial.legendre.leggauss(400)
    q, w = (x + 1) * np.pi / 4, w * np.pi / 4
    return bisect(lambda l: np.sum(w * exponential_integral((l * np.sin(q)) ** 2) * np.sin(q)) - T, 1e-6, 1e3)


def circle_slip(a, t, r):
    """(4/(pi G)) integral_r^a g(s)/sqrt(s^2 - r^2) ds, with s^2 = r^2 + (a^2 - r^2) y^2 and r = s sin q inside, which
    take both roots out"""
    x, w = np.polynomial.legendre.leggauss(400)
    q, y, wq, wy = (x + 1) * np.pi / 4, (x + 1) / 2, w * np.pi / 4, w / 2
    s = np.sqrt(r * r + (a * a - r * r) * y * y)
    drop = FRICTION * SOURCE * (exponential_integral((s[:, None] * np.sin(q)) ** 2 / (4 * ALPHA * t)) - CIRCLE_T)
    return 4 / (np.pi * G) * math.sqrt(a * a - r * r) * (drop @ (wq * np.sin(q))) @ wy


def circle_moment(a, t):
    """Slip integrated over the crack [m^3]: by reciprocity the drop times the slip 4/(pi G) sqrt(a^2 - r^2) of a
    uniform unit drop; r = a sin q."""
    x, w = np.polynomial.legendre.leggauss(400)
    q, w = (x + 1) * np.pi / 4, w * np.pi / 4
    drop = FRICTION * SOURCE * (exponential_integral((a * np.sin(q)) ** 2 / (4 * ALPHA * t)) - CIRCLE_T)
    return 8 / G * a**3 * np.sum(w * drop * np.cos(q) ** 2 * np.sin(q))


def circle_solve(build, folder, n, options=()):
    """Times, slip [m, n, n], steps, distances of cells from the middle [n, n], side of a cell, lambda."""
    number = circle_lambda(CIRCLE_T)
    half = 1.1 * number * math.sqrt(4 * ALPHA * CIRCLE_END)
    t, slip, accepted, rejected = run(build, folder, [
        "-fault_nx", str(n), "-fault_nz", str(n), "-fault_length_x", str(2 * half), "-fault_length_z", str(2 * half),
        "-fault_depth_top", str(DEPTH), "-fault_poisson_ratio", "0", "-fault_injection", f"{half},{DEPTH + half}",
        "-fault_injection_pressure", str(SOURCE), "-fault_injection_diffusivity", str(ALPHA),
        "-fault_initial_traction", str(FRICTION * (SIGMA - CIRCLE_T * SOURCE)), "-ts_max_time", str(CIRCLE_END),
        *options])
    h = 2 * half / n
    z = (np.arange(n) + 0.5) * h - half
    return t, slip, (accepted, rejected), np.hypot(*np.meshgrid(z, z)), h, number


def circle_moment_error(build, folder, n, options=()):
    """Moment at the end over the exact one less 1"""
    t, slip, _, _, h, number = circle_solve(build, folder, n, options)
    return slip[-1].sum() * h * h / circle_moment(number * math.sqrt(4 * ALPHA * t[-1]), t[-1]) - 1


def circle_run(build, folder, n, options=()):
    """Edge, and slip of the cells in the middle, over the exact ones less 1 at three times [3, 2], steps."""
    t, slip, steps, r, h, number = circle_solve(build, folder, n, options)
    table = []
    for share in CIRCLE_SHARES:
        i = int(np.argmin(abs(t - share * CIRCLE_END)))
        a = number * math.sqrt(4 * ALPHA * t[i])
        which = slip[i] > 0
        which &= r > r[which].max() - 4 * h
        line = np.polyfit(r[which], slip[i][which] ** (2 / 3), 1)
        table.append((-line[1] / line[0] / a - 1, slip[i].max() / circle_slip(a, t[i], r.min()) - 1))
    return np.array(table), steps


def line_errors(build, folder, n):
    z, slip, steps = line_run(build, folder, n, LINE_DAYS)
    return np.array([(edge_of(z, s) / line_edge(d * DAY) - 1, s.max() / line_slip(d * DAY) - 1)
                     for s, d in zip(slip, LINE_DAYS)]), steps


def shut_in_errors(build, folder, n):
    """Edge over that of the model less 1, and the largest difference of the slips over the largest slip"""
    z, slip, steps = line_run(build, folder, n, SHUT_DAYS)
    zm, model = strips(2 * n, np.arange(1, 601) / 600 * SHUT_DAYS[-1] * DAY, SHUT_DAYS)
    # of two runs, whose steps pass other corners of the record: far below the tolerance
    assert abs(slip[-1][n // 2] / slip[-2][n // 2] - 1) < 1e-4, "the middle has not stuck"
    return np.array([(edge_of(z, s) / edge_of(zm, m, 12) - 1, abs(s - np.interp(z, zm, m)).max() / m.max())
                     for s, m in zip(slip, model)]), steps


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.path.join(ROOT, "build"))
    parser.add_argument("--line", type=int, nargs="*", default=[100, 200, 400, 800])
    parser.add_argument("--circle", type=int, nargs="*", default=[20, 40, 60])
    parser.add_argument("--shut-in", type=int, nargs="*", default=[200, 400], dest="shut_in")
    parser.add_argument("--output", default=None, metavar="F.h5", help="keep the table")
    a = parser.parse_args()
    build, table = os.path.abspath(a.build), []
    print("case     cells  steps      error of the edge and of slip, at three times")
    with tempfile.TemporaryDirectory() as folder:
        for k, (name, errors, cells) in enumerate((("line", line_errors, a.line), ("circle", circle_run, a.circle),
                                                   ("shut-in", shut_in_errors, a.shut_in))):
            for n in cells:
                rows, steps = errors(build, folder, n)
                table.append((k, n, *steps, *rows.ravel()))
                print(f"{name:7}  {n:5d}  {steps[0]:4d}+{steps[1]:<3d}  "
                      + "   ".join(f"{100 * e:7.2f}% {100 * s:7.2f}%" for e, s in rows), flush=True)
    if a.output:
        with h5py.File(a.output, "w") as f:
            f["injection"] = np.array(table, float)
            f["injection"].attrs[
                "columns"] = "case(line,circle,shut-in) cells accepted rejected then edge slip at three times"


if __name__ == "__main__":
    main()
