#!/usr/bin/env python3
"""When TPV101 breaks, by a solver that shares nothing with the library, for `examples/tpv101.sh`; what came out is in
examples/howto/waves.md, How exact it is.

    spectral.py [--cell 300] [--courant 0.0875] [--correctors 2] [--end 4.4]

Slip goes along strike alone, u = u(|x|, |z|), so that its spectrum is real, a cosine transform of a quarter of a
periodic plane whose nodes include the middle. Each wavenumber k has the stress -G |k|/2 (K(0) u - int W(k cs t') V(t -
t') dt'), W(T) the integral of C from T on (Geubelle & Rice 1995). With p the Laplace variable of T, K(p) = p + L[C] is

    mode III   as = sqrt(1 + p^2)                     C = J1(T)/T
    mode II    (as - 1/as) + 4 (as - ad)/p^2          C = J1(T)/T - J0(T) + 4 (1 - g) + 4 int int (J1(T) - J1(T/g))/T

with ad = sqrt(1 + g^2 p^2), g = cs/cp. The whole history is summed, nothing is cut off. Steps are equal, of --courant
times what S waves take for a cell; rates are constant in them, W is integrated exactly; the mean of the rates at both
ends is found by a predictor and correctors (second order).
"""

import argparse

import common  # noqa: F401: before modules that may be missing
from slipstep.modules import need

need("scipy")
import numpy as np
from scipy import fft, special
from scipy.interpolate import CubicSpline

import tpv101

CP, CS, RHO = 6000.0, 3464.0, 2670.0  # [m/s], [kg/m^3]
G, ETA, RATIO = RHO * CS**2, RHO * CS / 2, CS / CP
NORMAL, SHEAR, V0, F0, B, DC, START = 120e6, 75e6, 1e-6, 0.6, 0.012, 0.02, 1e-12  # TPV101, shared/references/loads.md
PERIOD = 36e3, 24e3  # [m]: 48 x 42 km change no time by more than 0.1 ms
PLACES = (0, 0), (3, 0), (6, 0), (0, 3), (0, 6)  # [km]
FINE = 2e-3  # spacing of the tables of kernels: waves have the period 2 pi and, of P waves, 3.6


def kernels(largest):
    """K(0) and the function int W from 0 to T, for modes II and III, up to T = largest."""
    T = np.arange(0, largest + 10 * FINE, FINE)

    def total(y):
        return np.concatenate(([0], np.cumsum(y[1:] + y[:-1]) * FINE / 2))

    def bessel(x):  # J1(x)/x
        return np.divide(special.j1(x), x, out=np.full_like(x, 0.5), where=x > 0)

    third = bessel(T)
    second = third - special.j0(T) + 4 * (1 - RATIO) + 4 * total(total(third - bessel(T / RATIO) / RATIO))
    return [(K, CubicSpline(T, total(K - total(C)))) for K, C in ((2 * (1 - RATIO**2), second), (1.0, third))]


def stress_of_waves(cell, shape, dt, steps):
    """Static stiffness [nx, nz] and memory of the rates of so many past steps [steps, nx, nz], by wavenumber."""
    kx, kz = (np.pi * np.arange(n) / ((n - 1) * cell) for n in shape)
    k = np.hypot(kx[:, None], kz)
    k[0, 0] = 1
    in_plane = kx[:, None] ** 2 / k**2
    ends = k * CS * dt * np.arange(steps + 1)[:, None, None]
    static, memory = 0, 0
    for share, (K, W) in zip((in_plane, 1 - in_plane), kernels(ends.max())):
        static = static + G * k / 2 * share * K
        memory = memory + G / (2 * CS) * share * np.diff(W(ends), axis=0)
    static[0, 0] = memory[:, 0, 0] = 0  # a fault that slips as a whole has no stress but damping
    return static, memory


def load(t, r):
    inside = np.minimum(r, 3e3 * (1 - 1e-9)) ** 2
    rise = 1 if t >= 1 else np.exp((t - 1) ** 2 / (t * (t - 2)))
    return SHEAR + ETA * START + 25e6 * rise * np.exp(inside / (inside - 9e6))


def rate(stress, theta, a, guess):
    """V of stress - eta V = a sigma asinh(Z V), by Newton's method for asinh(Z V)."""
    Z = np.exp((F0 + B * np.log(V0 * theta / DC)) / a) / (2 * V0)
    y = np.arcsinh(Z * guess)
    for _ in range(100):
        change = (stress - ETA * np.sinh(y) / Z - a * NORMAL * y) / (ETA * np.cosh(y) / Z + a * NORMAL)
        y += np.minimum(change, 3)
        if np.abs(change).max() < 1e-11:
            return np.sinh(y) / Z
    raise SystemExit("Newton's method does not converge")


def rupture(cell, courant, correctors, end):
    """Times [nx, nz] at which nodes of the quarter x >= 0, z >= 0 are first above 0.1 m/s, linear within steps."""
    x, z = (cell * np.arange(round(length / cell / 2) + 1) for length in PERIOD)
    dt = courant * cell / CS
    steps = int(end / dt)
    static, memory = stress_of_waves(cell, (len(x), len(z)), dt, steps)
    r = np.hypot(x[:, None], z)
    a = 0.008 * (2 - np.outer(tpv101.box(x, 15e3), tpv101.box(z, 7.5e3)))
    theta = DC / V0 * np.exp((a * np.log(2 * V0 / START * np.sinh(SHEAR / NORMAL / a)) - F0) / B)
    slip, V, times = np.zeros_like(a), np.full_like(a, START), np.full_like(a, np.nan)
    history = np.zeros((steps, *a.shape))  # spectra of rates, the latest first from steps - i on
    for i in range(steps):
        t, mean, following = (i + 1) * dt, V, V
        past = np.einsum("jxz,jxz->xz", memory[1:i + 1], history[steps - i:])
        for _ in range(correctors + 1):
            moved, spectrum = slip + dt * mean, fft.dctn(mean, type=1)
            stress = load(t, r) + fft.idctn(past + memory[0] * spectrum - static * fft.dctn(moved, type=1), type=1)
            aged = theta * np.exp(-mean * dt / DC) - DC / mean * np.expm1(-mean * dt / DC)
            following = rate(stress, aged, a, following)
            mean = (V + following) / 2
        history[steps - 1 - i] = spectrum
        new = np.isnan(times) & (following >= 0.1)
        times[new] = t - dt * (following[new] - 0.1) / (following[new] - V[new])
        slip, theta, V = moved, aged, following
    return times


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cell", type=float, default=300.0, metavar="M", help="distance of nodes [m]")
    parser.add_argument("--courant", type=float, default=0.0875, help="steps over the time of S waves for a cell")
    parser.add_argument("--correctors", type=int, default=2)
    parser.add_argument("--end", type=float, default=4.4, metavar="S", help="[s]")
    a = parser.parse_args()
    if not a.cell > 0 or abs(3e3 / a.cell - round(3e3 / a.cell)) > 1e-9:
        parser.error(f"--cell is {a.cell:g} m, expected a whole part of 3000 m")
    times = rupture(a.cell, a.courant, a.correctors, a.end)
    print("first above 0.1 m/s at")
    for place in PLACES:
        print(f"({place[0]} km, {place[1]} km)  {times[tuple(round(1e3 * one / a.cell) for one in place)]:.4f} s")


if __name__ == "__main__":
    main()
