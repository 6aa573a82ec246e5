#!/usr/bin/env python3
"""A fault valve by a small code of its own, to test runs of SlipStep in which slip and fluid drive each other.

A line of cells down dip slips antiplane by rate-and-state friction (regularised, aging law) with radiation damping.
Fluid enters the lowest cell, flows up the line and leaves at the upper border, where its pressure is held. Slip opens
the line to the fluid, time closes it, and pressure opens it too (Zhu et al. 2020, Nature Communications 11, 4833):

    s' mu(v, psi) + eta v = T0 - K u,    s' = s0 - p,    du/dt = v - v_load,    dpsi/dt = V0/d_c exp(-psi) - v/d_c
    mu = a asinh(v/(2 V0) exp((f0 + b psi)/a))
    S w dp/dt = source - (outflow through the sides)/(width of a cell),    k = k* exp(p/s*)
    dk*/dt = v/L (k_max - k*) + (k0 - k*)/T

with s0 the effective normal stress at p = 0. It is a method of lines: ln v, psi, p, k* and u of all cells go together
through the implicit method Radau IIA of order 5 (SciPy), ln v by the balance differentiated in time. Nothing is split,
and nothing is taken from SlipStep but the stiffness matrix, if one is given:

    examples/valve.py valve.h5
    build/bin/fault -options_file examples/valve.opts -fault_parameters valve.h5 -fault_stiffness_view binary:K.bin ...
    valve_reference.py examples/valve.opts valve.h5 --stiffness K.bin --figure valve.png

prints when the largest slip rate passes --rate upwards, by two tolerances, which say how far these times are known:
those of valve.opts are in valve_reference.txt. With --run RUN.h5 it compares these with a run of SlipStep instead.
"""
import argparse
import os
import sys
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the matrices are small
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "src", "package"))
from slipstep.modules import need

need("h5py", "numpy", "scipy", "matplotlib")
import h5py
import matplotlib
import numpy as np
from scipy.integrate import Radau

matplotlib.use("Agg")
import matplotlib.pyplot as plt

YEAR = 365.25 * 86400


def antiplane(edges, modulus):
    """Stress drop [Pa/m] at the centres of cells between edges [m] of depth by slip of each, below a free surface."""
    low, high, z = edges[:-1], edges[1:], (edges[1:] + edges[:-1])[:, None] / 2
    return modulus / (2 * np.pi) * (1 / (z - low) - 1 / (z - high) + 1 / (z + high) - 1 / (z + low))


def read_petsc(path):
    """A full matrix in PETSc's binary format, dense or of rows with all columns in order; values are last."""
    with open(path, "rb") as file:
        data = file.read()
    kind, rows, columns, entries = np.frombuffer(data, ">i4", 4)
    if kind != 1211216 or entries not in (-1, rows * columns):
        raise ValueError(f"{path}: expected a full matrix in PETSc's binary format")
    return np.frombuffer(data[-8 * rows * columns:], ">f8").reshape(rows, columns).astype(float)


def read_case(options, fields, stiffness):
    """The fault of an options file of SlipStep and of its -fault_parameters; depths of its cells [m]."""
    with open(options, encoding="utf-8") as file:
        words = [line.split("#")[0].split() for line in file]
    value = {line[0].removeprefix("-fault_"): line[1] for line in words if line}

    def number(name):
        return float(value[name])
    n, depth, modulus = int(value["nz"]), number("length_z"), number("shear_modulus")
    edges = np.linspace(0, depth, n + 1)
    with h5py.File(fields) as file:
        field = {name: file[name][:, 0] for name in file}
    if (np.isfinite(field["border_pressure"]) != (np.arange(n) == 0)).any():
        raise ValueError(f"{fields}: expected a border_pressure of the uppermost cell alone")
    names = {"a": "friction_a", "traction": "initial_traction", "rate0": "initial_rate", "source": "fluid_source"}
    scalars = {"s0": "normal_stress", "b": "friction_b", "f0": "friction_reference", "V0": "friction_reference_rate",
               "dc": "friction_slip", "v_load": "loading_rate", "k0": "permeability", "k_max": "permeability_maximum",
               "L": "permeability_slip", "T": "permeability_healing_time", "stress": "permeability_stress",
               "porosity": "porosity", "compressibility": "pore_compressibility", "aperture": "aperture",
               "viscosity": "fluid_viscosity"}
    K = read_petsc(stiffness) if stiffness else antiplane(edges, modulus)
    return (edges[1:] + edges[:-1]) / 2, Valve(
        K, depth / n, eta=np.sqrt(modulus * number("density")) / 2, pressure=0.0, top=field["border_pressure"][0],
        **{key: field[name] for key, name in names.items()}, **{key: number(name) for key, name in scalars.items()})


class Valve:
    """Numbers, or arrays of the cells [N], in SI units, of which the names are those of the docstring."""

    def __init__(self, K, width, **numbers):
        self.K, self.width, self.n = K, width, len(K)
        self.__dict__.update(numbers)
        self.storage = self.porosity * self.compressibility * self.aperture

    def friction(self, v, psi):
        """mu, and its derivatives by ln v and psi."""
        x = np.log(v / (2 * self.V0)) + (self.f0 + self.b * psi) / self.a
        share = 1 / np.sqrt(1 + np.exp(-2 * x))
        return self.a * np.arcsinh(np.exp(x)), self.a * share, self.b * share

    def start(self):
        """All unknowns at rate0 and traction, with the state that balances them."""
        s = self.s0 - self.pressure
        mu = (self.traction - self.eta * self.rate0) / s
        psi = (self.a * np.log(2 * self.V0 / self.rate0 * np.sinh(mu / self.a)) - self.f0) / self.b
        return np.concatenate([np.broadcast_to(x, self.n) for x in
                               (np.log(self.rate0), psi, self.pressure, self.k0, 0.0)]).astype(float)

    def flow(self, p, star):
        """dp/dt and its derivatives by p and k*, [N, N]: sides between cells have the harmonic mean of both halves."""
        n, h = self.n, self.width
        k = star * np.exp(p / self.stress)
        half = 2 * k * self.aperture / (self.viscosity * h)  # from the centre to a side, per metre along strike
        side = half[:-1] * half[1:] / (half[:-1] + half[1:])
        up = side * (p[1:] - p[:-1])  # what flows up from each cell but the first
        out = np.zeros(n)
        out[1:] += up
        out[:-1] -= up
        out[0] += half[0] * (p[0] - self.top)
        by_p, by_half = np.zeros((n, n)), np.zeros((n, n))
        i = np.arange(n - 1)
        weight = [(side / half[:-1]) ** 2 * (p[1:] - p[:-1]), (side / half[1:]) ** 2 * (p[1:] - p[:-1])]
        for row, sign in ((i + 1, 1), (i, -1)):
            by_p[row, i + 1] += sign * side
            by_p[row, i] -= sign * side
            by_half[row, i] += sign * weight[0]
            by_half[row, i + 1] += sign * weight[1]
        by_p[0, 0] += half[0]
        by_half[0, 0] += p[0] - self.top
        by_p += by_half * half / self.stress
        scale = -1 / (self.storage * h)
        return self.source / self.storage + scale * out, scale * by_p, scale * by_half * half / star

    def rates(self, t, y, jacobian=False):
        """dy/dt; with jacobian its derivative."""
        n = self.n
        x, psi, p, star, _ = y.reshape(5, n)
        v = np.exp(x)
        mu, mx, mpsi = self.friction(v, psi)
        s = self.s0 - p
        heal = self.V0 / self.dc * np.exp(-psi)
        dpsi = heal - v / self.dc
        dp, dp_p, dp_star = self.flow(p, star)
        dstar = v / self.L * (self.k_max - star) + (self.k0 - star) / self.T
        stiff = s * mx + self.eta * v
        force = -self.K @ (v - self.v_load) + mu * dp - s * mpsi * dpsi
        dx = force / stiff
        if not jacobian:
            return np.concatenate([dx, dpsi, dp, dstar, v - self.v_load])
        J = np.zeros((5, n, 5, n))
        i = np.arange(n)
        share = mx / self.a
        # d share/dx = share (1 - share^2), and share's argument is x + b psi/a
        curve = self.a * share * (1 - share ** 2)
        J[0, :, 0] = -self.K * v / stiff[:, None]
        J[0, i, 0, i] += (mx * dp - s * curve * self.b / self.a * dpsi + s * mpsi * v / self.dc
                          - dx * (s * curve + self.eta * v)) / stiff
        J[0, i, 1, i] = (mpsi * dp - s * curve * (self.b / self.a) ** 2 * dpsi + s * mpsi * heal
                         - dx * s * curve * self.b / self.a) / stiff
        J[0, :, 2] = mu[:, None] * dp_p / stiff[:, None]
        J[0, i, 2, i] += (mpsi * dpsi + dx * mx) / stiff
        J[0, :, 3] = mu[:, None] * dp_star / stiff[:, None]
        J[1, i, 0, i], J[1, i, 1, i] = -v / self.dc, -heal
        J[2, :, 2], J[2, :, 3] = dp_p, dp_star
        J[3, i, 0, i], J[3, i, 3, i] = v / self.L * (self.k_max - star), -v / self.L - 1 / self.T
        J[4, i, 0, i] = v
        return J.reshape(5 * n, 5 * n)

    def imbalance(self, y):
        """Of the balance of stresses, which is integrated in time, over the strength: the largest."""
        x, psi, p, _, u = y.reshape(5, self.n)
        strength = (self.s0 - p) * self.friction(np.exp(x), psi)[0]
        return np.abs((strength + self.eta * np.exp(x) - self.traction + self.K @ u) / strength).max()

    def solve(self, end, rate, rtol=1e-9, bursts=None, keep=0.01, most=10 ** 7):
        """Times at which the largest slip rate passes rate upwards, the first time since it was a tenth of that or less
        (a front that jumps from cell to cell passes it often), and the course (times, unknowns [m, 5, N]): a state
        whenever ln v, or ln k*, or the pressure over s*, has changed by keep somewhere."""
        scale = np.repeat([1.0, 1.0, 1e6, 1e-15, 1e-3], self.n)
        method = Radau(self.rates, 0.0, self.start(), end, rtol=rtol, atol=rtol * scale, first_step=1.0,
                       jac=lambda t, y: self.rates(t, y, True))
        found, times, states = [], [0.0], [method.y]
        high, last, armed = np.log(rate), method.y, True
        steps = 0
        while method.status == "running" and (bursts is None or len(found) < bursts) and steps < most:
            armed = armed or method.y[:self.n].max() < high - np.log(10)
            method.step()
            steps += 1
            if armed and high <= method.y[:self.n].max():
                armed = False
                dense = method.dense_output()
                low, up = method.t_old, method.t
                for _ in range(200):
                    middle = (low + up) / 2
                    if not low < middle < up:
                        break
                    low, up = (middle, up) if dense(middle)[:self.n].max() < high else (low, middle)
                found.append(up)
            change = np.abs(method.y - last).reshape(5, self.n).max(axis=1)
            if max(change[0], change[2] / self.stress) > keep or method.status != "running":
                times.append(method.t)
                states.append(method.y)
                last = method.y
        return np.array(found), np.array(times), np.array(states).reshape(-1, 5, self.n), steps


def bursts_of(times, rates, rate):
    """Those of solve() of a series of largest slip rates, whose logarithm goes by straight lines."""
    found, armed, x = [], True, np.log(rates / rate)
    for k in range(1, len(times)):
        armed = armed or x[k - 1] < -np.log(10)
        if armed and x[k] >= 0:
            armed = False
            found.append(times[k - 1] - x[k - 1] * (times[k] - times[k - 1]) / (x[k] - x[k - 1]))
    return np.array(found)


def compare(path, rate):
    """Prints how far the bursts of a run are from the stored ones."""
    stored = np.loadtxt(os.path.join(os.path.dirname(os.path.abspath(__file__)), "valve_reference.txt"), ndmin=1)
    with h5py.File(path) as file:
        found = bursts_of(file["series/time"][...], file["series/max_slip_rate"][...], rate)
    print(f"{len(found)} bursts, expected {len(stored)} or more")
    for own, burst in zip(found, stored):
        print(f"{own:.9e}  # s, {own / YEAR:.6f} years, off by {own / burst - 1:.1e}")


def figure(path, z, valve, bursts, times, states):
    """Largest slip rate, pressure and permeability at some depths, and slip rate, against time."""
    years, rate, pressure = times / YEAR, states[:, 0] / np.log(10), states[:, 2]
    canvas, axes = plt.subplots(4, 1, figsize=(11, 12), sharex=True, layout="constrained")
    axes[0].semilogy(years, 10 ** rate.max(axis=1), color="black", linewidth=0.8)
    axes[0].plot(bursts / YEAR, np.full(len(bursts), 10 ** rate.max()), "v", color="#d62728")
    axes[0].set(ylabel="largest slip rate (m/s)")
    for k in range(1, valve.n, 5):
        axes[1].plot(years, pressure[:, k] / 1e6, label=f"{z[k] / 1e3:.1f} km")
        axes[2].semilogy(years, states[:, 3, k] * np.exp(pressure[:, k] / valve.stress))
    axes[1].set(ylabel="pressure (MPa)")
    axes[1].legend(ncols=4, fontsize=8)
    axes[2].set(ylabel="permeability (m$^2$)")
    drawn = axes[3].pcolormesh(years, z / 1e3, rate.T, vmin=-14, shading="nearest", cmap="magma", rasterized=True)
    canvas.colorbar(drawn, ax=axes[3], location="bottom", label="log$_{10}$ slip rate (m/s)", aspect=60,
                    extend="min")
    axes[3].set(ylabel="depth (km)", xlabel="time (years)", ylim=(z[-1] / 1e3, z[0] / 1e3))
    canvas.savefig(path, dpi=100)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("options", nargs="?", help="options file, as examples/valve.opts")
    parser.add_argument("fields", nargs="?", help="its -fault_parameters, as examples/valve.py writes them")
    parser.add_argument("--run", metavar="RUN.h5", help="-fault_output of SlipStep to compare with the stored times")
    parser.add_argument("--stiffness", metavar="K.bin", help="of -fault_stiffness_view binary:K.bin (default: that of "
                        "screw dislocations below a free surface)")
    parser.add_argument("--rate", type=float, default=1e-4, help="of a burst [m/s] (default %(default)g)")
    parser.add_argument("--years", type=float, default=250)
    parser.add_argument("--bursts", type=int, help="after which it ends")
    parser.add_argument("--tolerance", type=float, nargs="+", default=[1e-8, 1e-9])
    parser.add_argument("--figure", metavar="OUT.png")
    options = parser.parse_args()
    if options.run:
        compare(options.run, options.rate)
        return
    if not options.fields:
        parser.error("expected an options file and its -fault_parameters, or --run")
    z, valve = read_case(options.options, options.fields, options.stiffness)
    before = None
    for tolerance in options.tolerance:
        begin = time.process_time()
        bursts, times, states, steps = valve.solve(options.years * YEAR, options.rate, tolerance, options.bursts)
        print(f"# tolerance {tolerance:g}: {steps} steps, {time.process_time() - begin:.1f} s of processor time, "
              f"imbalance {valve.imbalance(states[-1].ravel()):.1e} of the strength", flush=True)
        for k, burst in enumerate(bursts):
            print(f"{burst:.9e}  # s, {burst / YEAR:.6f} years"
                  + (f", off by {burst / before[k] - 1:.1e}" if before is not None and k < len(before) else ""),
                  flush=True)
        before = bursts
    if options.figure:
        figure(options.figure, z, valve, bursts, times, states)


if __name__ == "__main__":
    main()
