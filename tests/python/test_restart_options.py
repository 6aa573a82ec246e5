#!/usr/bin/env python3
"""Every option of `fault -help fault`, changed where a run goes on from its checkpoint. Rows of
src/fault/setup/parameters.c say what they are part of, and -help says it: what is of the problem is refused by its
name with both values, what is of the steps is announced likewise, and what is of the run or of the output leaves the
result as it is. An option that -help has and the table below has not is a failure, and so is one that changes the
result without a word.

    test_restart_options.py --table     prints what became of each"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor

from scripts import FAULT, SOURCE

import h5py
import numpy as np

REFUSED, FILE, ANNOUNCED, SAME = "refused", "refused by the file", "announced", "same"
EVENT = "-fault_nx 4 -fault_nz 3 -ts_max_time 12 -ts_adapt_type heuristic"
SMOOTH = """-fault_nx 4 -fault_nz 3 -fault_friction_law rate_and_state -fault_friction_slip 0.02 
 -fault_loading_rate 1e-9 -fault_normal_stress 5e7 -fault_normal_stress_gradient 0 -ts_max_time 30y"""
# Runs, and the steps after which they stop and go on
RUNS = {"event": (EVENT, 12),
        "policy": ("-fault_nx 4 -fault_nz 3 -ts_max_time 12", 12),
        "pi": (EVENT.replace("heuristic", "pi"), 12),
        "thrust": (EVENT + " -fault_dip 40 -fault_rake 90", 12),
        "mesh": (EVENT.replace("-fault_nx 4 -fault_nz 3",
                               "-fault_mesh mesh.h5 -fault_mesh_frame ned -fault_mesh_unit km"), 12),
        "waves": (EVENT.split(" -ts_adapt")[0]
                  + " -fault_medium waves -fault_kernel full_space -fault_initial traction "
                  "-fault_initial_traction 1e8 " "-fault_initial_unstable", 12),
        "regional": (EVENT + " -fault_dip 60 -fault_regional_stress 6e7,8e7,5e7,-5e7,0,0 "
                     "-fault_regional_stress_gradient 0,0,0,0,10,0 -fault_initial_unstable", 12),
        "ratios": (EVENT + " -fault_dip 30 -fault_rake 90 -fault_regional_ratios 3.4,1.1 -fault_regional_azimuth 80 "
                   "-fault_initial_unstable", 12),
        "lanczos": (EVENT + " -fault_viscosity lanczos", 12),
        "hmat": (EVENT + " -fault_operator hmat", 12),
        "rate": (EVENT + " -fault_friction_law rate_weakening", 12),
        "smooth": (SMOOTH, 12),
        "composite": (SMOOTH + " -fault_state_law composite", 12),
        "strong": (SMOOTH.replace("rate_and_state", "strong_rate_weakening"), 12),
        "zone": (SMOOTH + " -fault_shear_zone_width 0.01 -fault_thermal_pressurisation 1e5 -fault_dilatancy 1e-6", 12),
        "fluid": (SMOOTH + " -fault_permeability 1e-15 -fault_permeability_law valve -fault_permeability_maximum 1e-14 "
                  "-fault_permeability_slip 0.01 -fault_permeability_healing_time 1y -fault_permeability_stress 1e7 "
                  "-fault_leakoff 1e-17 -fault_carter_leakoff 1e-14 -fault_carter_pressure 2e3 "
                  "-fault_wells wells.csv", 12),
        "transforms": (SMOOTH + " -fault_operator fft", 12),
        "loaded": (EVENT + " -fault_loading_rate 0.1 -fault_initial traction -fault_initial_traction 1e6 "
                   "-fault_healing_time 100", 12),
        "injection": (EVENT + " -fault_initial traction -fault_initial_traction 1e6 -fault_injection 1500,1500 "
                      "-fault_injection_pressure 2e7 " "-fault_injection_diffusivity 1e3 -ts_max_time 500", 5),
        "terms": (EVENT + " -fault_initial traction -fault_initial_traction 1e6 -fault_stress_history stress.csv "
                  "-fault_tide_period 20,30 -fault_tide_shear 1e6,2e6 -fault_tide_normal 0,1e6 -fault_tide_phase 0,90 "
                  "-fault_nucleation 1500,1500,2000,1e6,10 -ts_max_time 60", 5),
        "record": (EVENT + " -fault_initial traction -fault_initial_traction 1e6 -fault_pore_pressure pressure.h5 "
                   "-ts_max_time 200", 5),}
# What becomes of an option by what it is part of: the first, or where the table says so another
BECOMES = {"problem": (REFUSED, FILE), "steps": (ANNOUNCED,), "run": (SAME, ANNOUNCED), "output": (SAME, FILE, REFUSED)}
# option: (run, value), in a run where it counts, and what becomes of it where -help does not say what it is part of, or
# where that is not the first that may; of values None the option stands alone
TABLE = {
    "fault_nx": ("event", "5"),
    "fault_nz": ("event", "4"),
    "fault_length_x": ("event", "3100"),
    "fault_length_z": ("event", "3100"),
    "fault_depth_top": ("event", "100"),
    "fault_strike": ("thrust", "30"),
    "fault_dip": ("thrust", "50"),
    "fault_rake": ("thrust", "80"),
    "fault_slip_components": ("thrust", "2"),
    "fault_thickness": ("event", "2000"),
    "fault_shear_modulus": ("event", "31e9"),
    "fault_poisson_ratio": ("thrust", "0.3"),
    "fault_density": ("event", "2600"),
    "fault_damping_ratio": ("event", "0.3"),
    "fault_loading_rate": ("loaded", "0.2"),
    "fault_normal_stress": ("event", "1e6"),
    "fault_normal_stress_gradient": ("event", "16e3"),
    "fault_friction_residual": ("event", "0.49"),
    "fault_friction_drop": ("event", "0.2"),
    "fault_friction_slip": ("event", "0.2"),
    "fault_friction_rate": ("rate", "0.2"),
    "fault_friction_a": ("smooth", "0.011"),
    "fault_friction_b": ("smooth", "0.016"),
    "fault_friction_alpha": ("smooth", "0.1"),
    "fault_friction_reference": ("smooth", "0.61"),
    "fault_friction_reference_rate": ("smooth", "2e-6"),
    "fault_healing_time": ("loaded", "50"),
    "fault_initial_traction": ("loaded", "2e6"),
    "fault_initial_rate": ("smooth", "2e-9"),
    "fault_initial_state": ("smooth", "1e7"),
    "fault_creep": ("smooth", "1"),
    "fault_stressing_rate": ("loaded", "1"),
    "fault_injection_pressure": ("injection", "1e7"),
    "fault_injection_diffusivity": ("injection", "2e3"),
    "fault_injection_stop": ("injection", "100"),
    "fault_shear_zone_width": ("zone", "0.02"),
    "fault_shear_zone_tolerance": ("zone", "1e-5"),
    "fault_heat_capacity": ("zone", "2.8e6"),
    "fault_thermal_diffusivity": ("zone", "2e-6"),
    "fault_hydraulic_diffusivity": ("zone", "2e-5"),
    "fault_thermal_pressurisation": ("zone", "2e5"),
    "fault_dilatancy": ("zone", "2e-6"),
    "fault_dilatancy_storage": ("zone", "2e-11"),
    "fault_dilatancy_time": ("zone", "2e5"),
    "fault_permeability": ("fluid", "2e-15"),
    "fault_permeability_ratio": ("fluid", "0.5"),
    "fault_permeability_maximum": ("fluid", "2e-14"),
    "fault_permeability_slip": ("fluid", "0.02"),
    "fault_permeability_healing_time": ("fluid", "2y"),
    "fault_permeability_stress": ("fluid", "2e7"),
    "fault_porosity": ("fluid", "0.2"),
    "fault_pore_compressibility": ("fluid", "2e-9"),
    "fault_fluid_viscosity": ("fluid", "2e-3"),
    "fault_aperture": ("fluid", "2"),
    "fault_leakoff": ("fluid", "2e-17"),
    "fault_carter_leakoff": ("fluid", "2e-14"),
    "fault_carter_pressure": ("fluid", "3e3"),
    "fault_border_pressure": ("fluid", "1e5"),
    "fault_fluid_source": ("fluid", "1e-12"),
    "fault_fluid_pressure": ("fluid", "1e5"),
    "fault_fluid_tolerance": ("fluid", "1e-4"),
    "fault_fluid_border": ("fluid", "open"),
    "fault_wells": ("fluid", "other_wells.csv"),
    "fault_permeability_law": ("fluid", "slip -fault_permeability_stress 0"),
    "fault_initial_perturbation": ("event", "2e-5"),
    "fault_velocity_scale": ("policy", "0.08"),
    "fault_hmat_tolerance": ("hmat", "1e-6"),
    "fault_friction_law": ("event", "linear_slip_weakening"),
    "fault_state_law": ("smooth", "slip"),
    "fault_state_cutoff_rate": ("composite", "2e-8"),
    "fault_friction_weakened": ("strong", "0.3"),
    "fault_friction_weakening_rate": ("strong", "0.2"),
    "fault_medium": ("waves", "static"),
    "fault_kernel": ("event", "full_space"),
    "fault_normal_coupling": ("thrust", "no"),
    "fault_initial": ("event", "rest"),
    "fault_operator": ("event", "fft"),
    "fault_viscosity": ("event", "spectral"),
    "fault_stiffness_average": ("event", "cell"),
    "fault_stiffness_file": ("event", "stiffness.h5"),
    "fault_stiffness_scaling": ("event", "mean_slip"),
    "fault_parameters": ("event", "parameters.h5"),
    "fault_mesh": ("mesh", "other_mesh.h5"),
    "fault_mesh_frame": ("mesh", "enu", FILE),
    "fault_mesh_unit": ("mesh", "m"),
    "fault_pore_pressure": ("record", "other_pressure.h5"),
    "fault_stress_history": ("terms", "other_stress.csv"),
    "fault_tide_period": ("terms", "20,31"),
    "fault_tide_shear": ("terms", "1e6,3e6"),
    "fault_tide_normal": ("terms", "0,0.5e6"),
    "fault_tide_phase": ("terms", "0,80"),
    "fault_nucleation": ("terms", "1500,1500,2000,2e6,10"),
    "fault_event_rate": ("event", "1e-2", REFUSED),  # by the catalogue
    "fault_injection": ("injection", "1600,1500"),
    "fault_regional_stress": ("regional", "6e7,8e7,5e7,-5.1e7,0,0"),
    "fault_regional_stress_gradient": ("regional", "0,0,0,0,100,0"),
    "fault_regional_ratios": ("ratios", "3.4,1.2"),
    "fault_regional_azimuth": ("ratios", "85"),
    "fault_regional_pressure": ("ratios", "none"),
    "fault_regional_rake": ("ratios", "shear"),
    "fault_inertia": ("event", "no -fault_viscosity sqrtm"),
    "fault_opening": ("thrust", "yes -fault_slip_components 2 -fault_initial traction"),
    "ts_type": ("smooth", "rk", REFUSED),
    "fault_waves_tolerance": ("waves", "1e-5"),
    "fault_waves_padding": ("waves", "3"),
    # how it is computed
    "fault_device": ("transforms", "opencl"),
    "fault_device_name": ("smooth", "0"),
    "fault_krylov_tolerance": ("lanczos", "1e-6"),
    "fault_rate_tolerance": ("event", "1e-9"),
    "fault_accuracy": ("event", "1e-1"),
    "fault_tolerances": ("event", "tolerances.h5"),
    "fault_restart_dt": ("event", "1e-4", ANNOUNCED),
    "mat_slipfft_depth": ("event", "transform", ANNOUNCED),
    "mat_slip_share": ("event", "yes", ANNOUNCED),
    "ts_rtol": ("event", "1e-2", ANNOUNCED),
    "ts_bathe_method": ("event", "explicit", ANNOUNCED),
    "ts_bathe_gamma": ("event", "0.6", ANNOUNCED),
    "ts_bathe_first_stage": ("event", "backward", ANNOUNCED),
    "ts_bathe_reaction": ("event", "implicit", ANNOUNCED),
    "ts_bathe_error": ("event", "doubling", ANNOUNCED),
    "ts_bathe_order": ("event", "2", ANNOUNCED),
    "ts_bathe_stage_error": ("event", "1e-3", ANNOUNCED),
    "ts_bathe_max_failures": ("event", "40", ANNOUNCED),
    "ts_adapt_type": ("event", "pi", ANNOUNCED),
    "ts_adapt_dt_min": ("event", "1e-12", ANNOUNCED),
    "ts_adapt_dt_max": ("event", "0.05", ANNOUNCED),
    "ts_adapt_rl_policy": ("policy", "other_policy.h5", ANNOUNCED),
    "ts_adapt_rl_problem": ("policy", "rupture", ANNOUNCED),
    "ts_adapt_rl_max_failures": ("policy", "4", ANNOUNCED),
    "ts_adapt_rl_error_ceiling": ("policy", "1e-3", ANNOUNCED),
    "ts_adapt_rl_accuracy": ("policy", "5e-2", ANNOUNCED),
    "ts_adapt_rl_measure": ("policy", "history", ANNOUNCED),
    "ts_adapt_rl_strict": ("policy", "yes", ANNOUNCED),
    "ts_adapt_heuristic_growth": ("event", "1.5", ANNOUNCED),
    "ts_adapt_heuristic_failure_factor": ("event", "0.5", ANNOUNCED),
    "ts_adapt_pi_filter": ("pi", "PI33", ANNOUNCED),
    "ts_adapt_pi_g1": ("pi", "5", ANNOUNCED),
    "ts_adapt_pi_g2": ("pi", "5", ANNOUNCED),
    "ts_adapt_pi_kappa": ("pi", "0.3", ANNOUNCED),
    "ts_adapt_pi_ratio_min": ("pi", "0.7", ANNOUNCED),
    "ts_adapt_pi_ratio_max": ("pi", "1.3", ANNOUNCED),
    "ts_adapt_pi_failure_factor": ("pi", "0.5", ANNOUNCED),
    "snes_type": ("event", "semismooth", ANNOUNCED),
    "snes_slip_direct_max": ("event", "2", ANNOUNCED),
    "pc_slipstage_type": ("event", "symbol", ANNOUNCED),
    # of the start alone, or what is written and printed and when
    "slip_traceback": ("event", "yes", SAME),
    "fault_sweep": ("event", "sweep.txt", SAME),
    "fault_features": ("event", "no", SAME),
    "fault_cells": ("event", "nowhere/cells.h5", FILE),
    "fault_plan": ("event", "2", FILE),
    "fault_initial_unstable": ("loaded", "yes"),
    "fault_output_interval": ("event", "3"),
    "fault_output_slip_interval": ("event", "0.01"),
    "fault_output_time_interval": ("event", "1"),
    "fault_output_rate_change": ("event", "2"),
    "fault_output_size": ("event", "1e4"),
    "fault_output_compression": ("event", "3", FILE),
    "fault_output_fields": ("event", "slip", FILE),
    "fault_output_precision": ("event", "single", FILE),
    "fault_output": ("event", "elsewhere.h5"),
    "fault_output_xdmf": ("event", "no"),
    "fault_output_overwrite": ("event", "yes"),
    "fault_stations": ("event", "500,500", FILE),
    "fault_surface_stations": ("event", "500,500", FILE),
    "fault_surface_motion": ("loaded", "total"),
    "fault_catalogue": ("event", "elsewhere_events.h5"),
    "fault_catalogue_maps": ("event", "yes", FILE),
    "fault_checkpoint": ("event", "elsewhere.state"),
    "fault_checkpoint_interval": ("event", "0"),
    "fault_restart": ("event", "state.copy"),
    "fault_wall_limit": ("event", "1000"),
    "fault_estimates": ("event", "estimates.h5"),
    "fault_stop_file": ("event", "elsewhere.stop"),
    "fault_check_error": ("event", "yes"),
    "fault_progress": ("event", "no"),
    "fault_view": ("event", None, SAME),
    "fault_stiffness_view": ("event", "binary:K.bin", SAME),
    "ts_max_time": ("event", "13", SAME),
    "ts_max_steps": ("event", "100000", SAME),
    "ts_dt": ("event", "1e-3", SAME),
}


def options_of_help():
    """{option: what it is part of, or None}"""
    done = subprocess.run([FAULT, "-help", "fault"], capture_output=True, text=True, check=True)
    return {name: (re.findall(r"; of the (\w+)", text) or [None])[-1]
            for name, text in re.findall(r"(?m)^ +-(\w+)(?::| <)(.*)$", done.stdout)}


def expected(option, part):
    """What the test wants to see, which what the option is part of allows"""
    wanted = TABLE[option][2] if len(TABLE[option]) > 2 else BECOMES[part][0]
    if part and wanted not in BECOMES[part]:
        raise AssertionError(f"-{option} is of the {part}, which is never {wanted}")
    return wanted


def write_inputs():
    distance = np.abs(np.subtract.outer(np.arange(12), np.arange(12)))
    with h5py.File("stiffness.h5", "w") as file:
        file["stiffness"] = np.where(distance, -1e5 / (1 + distance ** 2), 1e7)
    with h5py.File("parameters.h5", "w") as file:
        file["friction_drop"] = np.linspace(0.09, 0.11, 12).reshape(3, 4)
    for name, depth in (("mesh.h5", 3.0), ("other_mesh.h5", 3.1)):
        with h5py.File(name, "w") as file:
            file["vertices"] = [[x, 0, z] for z in (0.1, depth) for x in (0.0, 2.0, 4.0)]
            file["triangles"] = [[k, k + 1, k + 3] for k in range(2)] + [[k + 1, k + 4, k + 3] for k in range(2)]
    for name, pressure in (("pressure.h5", 2e7), ("other_pressure.h5", 1e7)):
        with h5py.File(name, "w") as file:
            file["time"] = [0.0, 100.0]
            file["pressure"] = np.multiply.outer([0, pressure], np.ones((3, 4)))
    for name, shear in (("stress.csv", 2e7), ("other_stress.csv", 1e7)):
        with open(name, "w", encoding="utf-8") as file:
            file.write(f"time,shear,normal\n0,0,0\n50,{shear},-1e7\n")
    for name, rate in (("wells.csv", 1), ("other_wells.csv", 2)):
        with open(name, "w", encoding="utf-8") as file:
            file.write(f"well,x,z,days,m3/day\nA,1500,1500,0,{rate}\nA,1500,1500,90,0\n")
    shutil.copy(os.path.join(SOURCE, "training", "policies", "fault.h5"), "other_policy.h5")
    for name in ("tolerances.h5", "estimates.h5"):
        shutil.copy(os.path.join(SOURCE, "training", "policies", name), name)
    with h5py.File("tolerances.h5", "a") as file:
        file["event/rtol"][...] *= 0.5
    with open("sweep.txt", "w", encoding="utf-8") as file:
        file.write("-fault_progress no\n")


def fault(folder, words):
    with tempfile.TemporaryDirectory() as own:  # of Open MPI, away from the programs that begin at the same time
        return subprocess.run([FAULT, *words], cwd=folder, env={**os.environ, "TMPDIR": own}, capture_output=True,
                              text=True)


def files(*names):
    return [word for name in names
            for word in (f"-fault_{name}", {"output": "run.h5", "catalogue": "events.h5"}.get(name, "state"))]


def begin(run):
    """A run to its end, and one that stops on the way, in folders of their own."""
    options, steps = RUNS[run]
    for name, more, code in ((run, [], 0), (run + "_part", ["-ts_max_steps", str(steps), *files("checkpoint")], 3)):
        os.mkdir(name)
        for file in os.listdir("inputs"):
            shutil.copy(os.path.join("inputs", file), name)
        done = fault(name, [*options.split(), *files("output", "catalogue"), *more])
        if done.returncode != code:
            raise AssertionError(f"{run} ended with {done.returncode}: {done.stderr}")


def until(name, end):
    """What the run has computed until a time, bit by bit."""
    with h5py.File(name) as file:
        n = np.searchsorted(file["series/time"][...], end, side="right")
        return [file["series"][path][:n].tobytes() for path in ("time", "mean_slip", "max_slip_rate")]


def go_on(option):
    """What becomes of a run that goes on with this option changed, and the words about it"""
    run, value = TABLE[option][:2]
    folder = "option_" + option
    shutil.copytree(run + "_part", folder)
    shutil.copy(os.path.join(folder, "state"), os.path.join(folder, "state.copy"))
    if option == "fault_output":
        shutil.copy(os.path.join(folder, "run.h5"), os.path.join(folder, value))
    done = fault(folder, [*RUNS[run][0].split(), *files("output", "catalogue", "restart"), f"-{option}",
                          *(value or "").split()])
    lines = (done.stdout + done.stderr).splitlines()
    told = f"{option.removeprefix('fault_')} is .*, was "
    mesh = "mesh is .*, was " if "_mesh" in option else told
    # what follows from the option
    fields = f"({mesh}|(normal_stress|initial_traction|friction_drop|stiffness) is .*, was )"
    for line in lines:
        if (done.returncode
            and re.search(rf"error: -fault_(restart state is the checkpoint of another run: .*)?{fields}", line)):
            return REFUSED, line
        if done.returncode and re.search(rf"error: .*(-{option}|another -fault_output|\(-fault_mesh\))", line):
            return FILE, line
        if (not done.returncode
            and re.search(rf"warning: the run goes on with other .*{told}|The run continues .*\(-{option}\)", line)):
            return ANNOUNCED, line
    # the last steps meet the end
    end = 0.75 * float(RUNS[run][0].split("-ts_max_time ")[-1].split()[0]) if option == "ts_max_time" else np.inf
    output = value if option == "fault_output" else "run.h5"
    if not done.returncode and until(os.path.join(run, "run.h5"), end) == until(os.path.join(folder, output), end):
        return SAME, ""
    return f"ended with {done.returncode}, another result", lines[-1]


class RestartOptions(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            os.mkdir("inputs")
            os.chdir("inputs")
            write_inputs()
            os.chdir("..")
            with ThreadPoolExecutor(2) as pool:
                list(pool.map(begin, RUNS))
                cls.found = dict(zip(TABLE, pool.map(go_on, TABLE)))
            os.chdir("/")
            cls.parts = options_of_help()

    def test_every_option_is_known(self):
        """A new option needs a row of TABLE, and every one of faults says what it is part of, but for those of viewers
        and of programs."""
        self.assertEqual(set(self.parts), set(TABLE))
        programs = {f"fault_{name}" for name in ("sweep", "features", "cells", "plan", "view", "stiffness_view")}
        self.assertEqual({name for name, part in self.parts.items() if name.startswith("fault_") and not part},
                         programs)

    def test_what_becomes_of_each(self):
        for option, (what, words) in self.found.items():
            if option == "fault_device" and ("there is no device of OpenCL" in words
                                             or "built without OpenCL" in words):
                continue
            with self.subTest(option):
                self.assertEqual(what, expected(option, self.parts[option]), words)


def print_table():
    RestartOptions.setUpClass()
    print("| option | part of | run, changed to | becomes | words |\n|---|---|---|---|---|")
    for option, (what, words) in RestartOptions.found.items():
        print(f"| `-{option}` | {RestartOptions.parts[option] or ''} | {TABLE[option][0]}, "
              f"{TABLE[option][1] or 'given'} | {what} | {re.sub('^fault: .*?: ', '', words)[-160:]} |")


if __name__ == "__main__":
    if "--table" in sys.argv:
        print_table()
    else:
        unittest.main()
