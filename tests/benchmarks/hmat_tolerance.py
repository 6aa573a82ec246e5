#!/usr/bin/env python3
"""What the tolerance of the hierarchical stiffness adds to the errors of runs, and what it saves.

    tests/benchmarks/hmat_tolerance.py [--build build] [--folder /tmp/hmat_tolerance] [--cases rupture ...]
    [--tolerances 1e-8 1e-6 1e-5 1e-4 1e-3 1e-2] [--accuracy 1e-3]

Each run at a tolerance is compared with the same run at 1e-10. Columns: the final slip, the largest difference over the
largest slip; the times of the first two events, over the later one; of the first event the times at which cells break,
the mean and the largest difference over its duration, its slip, its moment, its energies over the dissipated one, and
the energy residual; the memory of K and Kn [MB]; accepted steps. Where steps differ from those at 1e-10, differences
are those of steps as well; finer steps (--accuracy) show what the tolerance adds. Later events are chaotic and not
compared.
"""

import argparse
import os
import re
import subprocess
import sys

from common import ROOT, write
import h5py
import numpy as np

REFERENCE = "1e-10"
ENERGIES = "elastic_energy", "dissipated_energy", "radiated_energy", "kinetic_energy", "loading_work"
TILT = 0.02  # by which the normal stress of the thrust rises from its middle to its end
SLIP_WEAKENING = ("-fault_shear_modulus 32e9 -fault_density 2670 -fault_normal_stress 120e6 "
                  "-fault_normal_stress_gradient 0 -fault_friction_law linear_slip_weakening "
                  "-fault_friction_residual 0.525 -fault_friction_drop 0.152 -fault_friction_slip 0.8 "
                  "-fault_initial traction -fault_initial_unstable -ts_max_time 40").split()


def triangles(name, nx=50, nz=30, size=500.0):
    """Writes the mesh and the stress of a fault whose dip falls from 60 to 40 degrees and whose trace is a wave."""
    x, d = np.meshgrid(size * np.arange(nx + 1), np.arange(nz + 1))
    dip = np.radians(60 - 20 * d[:, 0] / nz)
    y = np.cumsum(size * np.cos(dip))[:, None] + 500 * np.sin(6 * x / x.max())
    z = 100 + np.cumsum(size * np.sin(dip))[:, None] + 0 * x
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    corner = (np.arange(nz)[:, None] * (nx + 1) + np.arange(nx)).ravel()
    cells = np.concatenate([np.stack([corner, corner + 1, corner + nx + 1], axis=1),
                            np.stack([corner + 1, corner + nx + 2, corner + nx + 1], axis=1)])
    centre = vertices[cells].mean(axis=1)
    patch = np.linalg.norm(centre - (*vertices[(nz // 2) * (nx + 1) + nx // 3],), axis=1) < 3e3
    write(f"{name}_mesh.h5", vertices=vertices, triangles=cells)
    write(f"{name}_fields.h5", initial_traction=np.where(patch, 1.01 * 0.677 * 120e6, 76e6))


def script(name, *arguments):
    subprocess.run([sys.executable, os.path.join(ROOT, "examples", name), *arguments], check=True,
                   stdout=subprocess.DEVNULL)


def case(name, at):
    """Options of a case, whose files are made."""
    opts = os.path.join(ROOT, "examples", "%s.opts")
    if name == "rupture":
        triangles(at)
        return [*SLIP_WEAKENING, "-fault_mesh", f"{at}_mesh.h5", "-fault_parameters", f"{at}_fields.h5"]
    if name == "step_over":
        script("step_over.py", "make", at, "--cells", "40", "20", "--distance", "1000")
        return ["-options_file", opts % "step_over", "-fault_mesh", f"{at}_mesh.h5", "-fault_parameters",
                f"{at}_fields.h5", "-fault_normal_coupling", "yes"]
    if name == "inertia":
        script("make_mesh.py", f"{at}_mesh.h5", "parallel", "--cells", "24", "24", "--size", "3000", "3000", "--offset",
               "1000", "--shift", "500")
        return ["-options_file", opts % "fault_parallel", "-fault_mesh", f"{at}_mesh.h5", "-fault_viscosity", "lanczos",
                "-ts_adapt_type", "heuristic"]
    if name == "thrust":
        script("make_thrust.py", f"{at}_fields.h5", f"{at}_points.txt", "--cells", "30", "15")
        with h5py.File(f"{at}_fields.h5", "a") as f:  # the example is symmetric, and its halves are equally strong
            f["normal_stress"] = 40e6 * np.broadcast_to(1 + TILT * np.linspace(-1, 1, 30), (15, 30))
            f["normal_stress"].attrs["units"] = "Pa"
        return ["-options_file", opts % "thrust", "-fault_nx", "30", "-fault_nz", "15", "-fault_parameters",
                f"{at}_fields.h5", "-ts_max_time", "300y"]
    if name == "bp5":
        script("make_seas.py", "bp5", f"{at}_fields.h5", "--cell", "2000")
        return ["-options_file", opts % "seas_bp5", "-fault_nx", "50", "-fault_nz", "20", "-fault_parameters",
                f"{at}_fields.h5", "-ts_max_time", "240y"]
    if name == "opening":
        script("dyke.py", "make", at, "--cell", "500", "--pressure", "6")
        return ["-options_file", opts % "dyke", "-fault_mesh", f"{at}_mesh.h5", "-fault_parameters", f"{at}_fields.h5",
                "-fault_pore_pressure", f"{at}_pressure.h5", "-ts_max_time", "864000"]
    raise SystemExit(f"no case {name}")


def run(build, options, at, tolerance, accuracy):
    """The first two events of a run, its final slip, and the memory of its matrices [MB]."""
    command = [os.path.join(build, "bin", "fault"), *options, "-fault_operator", "hmat", "-fault_hmat_tolerance",
               tolerance, "-fault_accuracy", accuracy, "-fault_output", f"{at}.h5", "-fault_catalogue",
               f"{at}_events.h5", "-fault_catalogue_maps", "-fault_output_overwrite", "-fault_progress", "no",
               "-fault_view", "-fault_output_fields", "slip", "-fault_output_precision", "double", "-fault_event_rate",
               "1e-2"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{' '.join(command)} failed:\n{done.stderr}")
    with h5py.File(f"{at}_events.h5") as f:
        events = {key: data[:2] for key, data in f.items() if isinstance(data, h5py.Dataset)}
        events.update({key: data[:2] for key, data in f["maps"].items()})
    with h5py.File(f"{at}.h5") as f:
        events["final"], events["accepted"] = f["fields/slip"][-1], f["result"].attrs["accepted"]
    events["memory"] = sum(float(size) for size in re.findall(r"memory: ([0-9.]+) MB, .* of a dense", done.stdout))
    return events


def compare(got, exact):
    """The differences of the columns, relative."""
    n, largest = len(exact["onset"]), np.abs(exact["final"]).max()
    row = {"slip": np.abs(got["final"] - exact["final"]).max() / largest}
    if not n or len(got["onset"]) != n:
        return row
    row["onset"] = np.abs(got["onset"] - exact["onset"]).max() / (exact["onset"][-1] or 1)
    times = np.abs(got["rupture_time"][0] - exact["rupture_time"][0])
    whole = np.nanmax(exact["rupture_time"][0])
    row["breaks"], row["worst"] = np.nanmean(times) / whole, np.nanmax(times) / whole
    row["event slip"] = np.abs(got["slip"][0] - exact["slip"][0]).max() / np.abs(exact["slip"][0]).max()
    row["moment"] = abs(got["moment"][0] / exact["moment"][0] - 1)
    row["energy"] = max(abs(got[e][0] - exact[e][0]) for e in ENERGIES) / abs(exact["dissipated_energy"][0])
    row["residual"] = abs(got["energy_residual"][0] - exact["energy_residual"][0])
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.path.join(ROOT, "build"))
    parser.add_argument("--folder", default="/tmp/hmat_tolerance")
    parser.add_argument("--cases", nargs="+", default=["rupture", "inertia", "step_over", "thrust", "bp5", "opening"])
    parser.add_argument("--tolerances", nargs="+", default=["1e-8", "1e-6", "1e-5", "1e-4", "1e-3", "1e-2"])
    parser.add_argument("--accuracy", default="1e-3", help="of the steps, -fault_accuracy")
    a = parser.parse_args()
    os.makedirs(a.folder, exist_ok=True)
    columns = "slip", "onset", "breaks", "worst", "event slip", "moment", "energy", "residual"
    print("| case | tolerance |", *(f"{c} |" for c in columns), "memory | steps |")
    for name in a.cases:
        at = os.path.join(a.folder, f"{name}_{a.accuracy}")
        options = case(name, at)
        exact = run(a.build, options, f"{at}_{REFERENCE}", REFERENCE, a.accuracy)
        print(f"# {name}: {len(exact['onset'])} events, {exact['accepted']:.0f} steps, {exact['memory']:.1f} MB",
              flush=True)
        for tolerance in a.tolerances:
            got = run(a.build, options, f"{at}_{tolerance}", tolerance, a.accuracy)
            row = compare(got, exact)
            print(f"| {name} | {tolerance} |", *(f"{row[c]:.1e} |" if c in row else "- |" for c in columns),
                  f"{got['memory']:.1f} | {got['accepted']:.0f} |", flush=True)


if __name__ == "__main__":
    main()
