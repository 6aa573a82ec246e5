#!/usr/bin/env python3
"""Processor time by products against the measured one, attempts alone: a table in Markdown.

    cost.py [BUILD]

Runs of seconds on one core: the 3 km fault with a spectral and an exact viscosity, examples/rupture.sh without inertia, hierarchical
storage, a root by Lanczos' method, and 300 years of SEAS BP5 on cells of 2 km.
"""
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "src", "package"))
from slipstep.modules import need

need("h5py", "numpy")
import h5py

SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
EXAMPLES = os.path.join(SOURCE, "examples")
FAULT = ["-options_file", os.path.join(EXAMPLES, "fault_3km.opts")]


def make(script, *options):
    return subprocess.run([sys.executable, os.path.join(EXAMPLES, script), *options], check=True, capture_output=True, text=True).stdout


def square(n, *options):
    return [*FAULT, "-fault_nx", n, "-fault_nz", n, *options]


def rupture(nx, nz):
    make("make_fault.py", f"rupture{nx}.h5", "--cells", nx, nz, "--size", "20000", "10000", "--slip", "0.1", "--stress", "0.6", "--patch", "5000",
         "6000", "2000", "--seed", "3")
    return ["-options_file", os.path.join(EXAMPLES, "fault_rupture.opts"), "-fault_nx", nx, "-fault_nz", nz, "-fault_parameters", f"rupture{nx}.h5"]


def bp5():
    nx, nz = make("make_seas.py", "bp5", "bp5.h5", "--cell", "2000").split()
    return ["-options_file", os.path.join(EXAMPLES, "seas_bp5.opts"), "-fault_nx", nx, "-fault_nz", nz, "-fault_parameters", "bp5.h5", "-ts_max_time", "300y"]


def cases():
    """(what, options) of each row."""
    for n in ("24", "50", "100"):
        for viscosity, name in (("spectral", "spectral H"), ("sqrtm", "exact H")):
            yield f"3 km, {n} x {n}, {name}", square(n, "-fault_viscosity", viscosity)
    yield "3 km, 40 x 40, H by Lanczos' method", square("40", "-fault_viscosity", "lanczos")
    yield "3 km, 24 x 24, hierarchical", square("24", "-fault_operator", "hmat")
    yield "rupture, 24 x 12, quasi-dynamic", rupture("24", "12")
    yield "rupture, 100 x 50, quasi-dynamic", rupture("100", "50")
    yield "BP5, 2 km, 300 years, `adams`", bp5()


def main(build=os.path.join(SOURCE, "build")):
    program = os.path.abspath(os.path.join(build, "bin", "fault"))
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    print("| run | solves | products with K | with H | preconditioner | set-up, with K | cost (s) | measured (s) | cost / measured |\n|" + "---|" * 9)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for what, options in cases():
            subprocess.run([program, *options, "-fault_output", "out.h5", "-fault_output_interval", "1000000"], check=True, capture_output=True)
            with h5py.File("out.h5") as file:
                r = dict(file["result"].attrs)
            counts = [r[name] for name in ("solves", "products_k", "products_h", "products_pc", "products_k_setup")]
            print(f"| {what} | {' | '.join(f'{n:,.0f}' for n in counts)} | {r['cost']:.3f} | {r['processor_time']:.3f} | {r['cost'] / r['processor_time']:.2f} |", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
