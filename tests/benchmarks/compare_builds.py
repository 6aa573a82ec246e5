#!/usr/bin/env python3
"""Do two builds compute the same, bit for bit? Runs the option sets below with the programs of both, and compares.

    tests/benchmarks/compare_builds.py BASE NEW [--only REGEX] [--keep DIR]

BASE and NEW are build folders, such as a build of the commit before a change and one after it. Each set runs once with
each build, the two at the same time, in a folder of its own; some stop on the way and go on from their checkpoint, and
both parts count. All datasets and attributes of the HDF5 files written are compared (output, stations, catalogue with
maps, checkpoint, policies), XDMF files, and the lines on stdout and warnings, without wall times, dates, versions,
memory and paths. Of what differs it prints both shapes, or the largest absolute difference and that over the largest
magnitude in BASE's dataset. At the end a table, a line a set: the same bits, or its largest relative difference
(iterations, products and residuals only where nothing else differs); then how many sets and datasets there were, and
whether all are equal. The exit code is 0 if all sets have the same bits, else 1. --only takes the sets whose name
matches, --keep leaves inputs and runs in DIR, which must be new. Both builds together take two minutes of two cores.

Meshes, fields and named policies are those of the repository this script is in; a policy that is not named is what each
build finds by itself. Self-test: --perturb 'OPTIONS' appends options to the runs of NEW's program fault, so that

    tests/benchmarks/compare_builds.py BASE BASE --perturb '-fault_density 2500.000001'

has to find differences in all sets of that program, and in no other.
"""

import argparse
import collections
import concurrent.futures
import os
import re
import shlex
import subprocess
import sys
import tempfile
import time

import common
from common import ROOT
import h5py
import numpy as np


# What every set of a program begins with. The scaling of the stiffness and the controller are named in every set, so
# that a new default changes nothing. Trainings on random faults (cmaes) name
# theirs.
COMMON = {"fault": "-fault_output run.h5 -fault_stiffness_scaling mean_slip",
          "friction_law": "-fault_output run.h5 -fault_stiffness_scaling none",
          "sliding_mode": "-sliding_mode_output run.h5",
          "circuit": "-circuit_output run.h5",
          "oscillator": "",
          "train": "-train_output policy.h5 -train_log log.h5",
          "evaluate": "-evaluate_output matrix.h5 -evaluate_repetitions 1 -fault_stiffness_scaling mean_slip",}
TRAIN = "-train_progress 0 -train_steps 300 -train_batch 32"
TRAIN_FAULT = f"{TRAIN} -fault_stiffness_scaling mean_slip"
CMAES = ("-train_algorithm cmaes -train_singles 4 -train_meshes 2 -train_mesh_side 3 -train_batch_singles 3"
         " -train_batch_meshes 1 -train_validation 2 -train_calibration 2 -train_validation_interval 2"
         " -train_population 6 -train_hidden 3 -train_generations 4")
ODE = "-train_algorithm cmaes -train_hidden 2 -train_episodes 8 -train_batch 4 -train_population 5 -train_generations 2"
RUNS = ("-train_algorithm cmaes -train_singles 2 -train_batch_singles 2 -train_validation 1 -train_calibration 1"
        " -train_generations 2 -train_population 4 -train_validation_interval 1")
# Faults with stress that lasts: under loading, pressure, or with rate-and-state friction; years are 3.15576e7 s.
BLOCK = "-fault_normal_stress 50e6 -fault_normal_stress_gradient 0"
GRID = f"-fault_nx 8 -fault_nz 4 -fault_length_x 8000 -fault_length_z 4000 {BLOCK}"
PLANES = f"-fault_mesh IN/planes.h5 {BLOCK}"
WEAKENING = "-fault_initial traction -fault_loading_rate 1e-9 -fault_parameters IN/weakening.h5"
WEAKENING_PLANES = WEAKENING.replace("weakening", "weakening_planes")
HEALING = "-fault_healing_time 3.15576e7 -ts_max_time 1.8e8"
RATE_STATE = ("-fault_friction_law rate_and_state -fault_loading_rate 1e-9 -fault_friction_slip 0.02"
              " -fault_friction_b 0.02 -fault_parameters IN/rate_state.h5")
RATE_STATE_PLANES = RATE_STATE.replace("rate_state.h5", "rate_state_planes.h5")
# Near the strength, 25 MPa under a constant law, else 30 MPa; a point source brings 5 MPa E1(r^2/(4 D t)) for two days
PUSHED = "-fault_initial traction -fault_initial_traction 24e6 -ts_max_time 4e5"
PUSHED_WEAKENING = PUSHED.replace("24e6", "28.5e6")
POINT = "-fault_injection_pressure 5e6 -fault_injection_diffusivity 2 -fault_injection_stop 172800 -fault_injection"
# All that observes a run
WATCH = "-fault_stations 1500,1500;6500,2500 -fault_catalogue events.h5 -fault_catalogue_maps"
WATCH_PLANES = WATCH.replace("1500,1500;6500,2500", "1500,0,1500;6500,1000,2500")
WORDS = {"TRAIN": TRAIN, "TRAIN_FAULT": TRAIN_FAULT, "CMAES": CMAES, "ODE": ODE, "RUNS": RUNS, "GRID": GRID,
         "PLANES": PLANES, "WEAKENING": WEAKENING, "WEAKENING_PLANES": WEAKENING_PLANES, "HEALING": HEALING,
         "RATE_STATE": RATE_STATE,
         "RATE_STATE_PLANES": RATE_STATE_PLANES, "PUSHED": PUSHED, "PUSHED_WEAKENING": PUSHED_WEAKENING,
         "POINT": POINT, "WATCH": WATCH, "WATCH_PLANES": WATCH_PLANES}

# "name: [ranks] [@steps] program arguments", one rank unless it says otherwise. A run with @steps is stopped by
# -ts_max_steps and goes on from its checkpoint. "12x9" at the start of the arguments stands for -fault_nx 12 -fault_nz
# 9, {NAME} for the text above; IN is the folder of inputs(), POLICIES training/policies, STUDY training/study/policies,
# EXAMPLES examples. All were the same bits run after run, also on 2 ranks and beside other work.
SETS = r"""
# friction laws, starts, loading
law exponential: fault 15x15 -fault_friction_law exponential_slip_weakening -ts_adapt_type heuristic
law linear: fault 12x12 -fault_friction_law linear_slip_weakening -ts_adapt_type heuristic
law rate: fault 8x8 -fault_friction_law rate_weakening -ts_adapt_type heuristic -ts_max_time 10
law constant: fault 8x8 -fault_friction_law constant -fault_initial rest -fault_loading_rate 0.05 \
  -ts_adapt_type heuristic -ts_max_time 40
rest, loaded: 2 fault 9x7 -fault_initial rest -fault_loading_rate 0.02 -fault_normal_stress 1e6 \
  -fault_normal_stress_gradient 0 -ts_adapt_type heuristic -ts_max_time 40
loaded, critical: fault 10x10 -fault_loading_rate 1e-3 -ts_adapt_type heuristic -ts_max_time 20
larger perturbation: fault 10x10 -fault_initial_perturbation 1e-3 -ts_adapt_type pi
# faults and fields
one element: fault 1x1 -ts_adapt_type heuristic
fields: 2 fault 12x9 -fault_parameters IN/fields.h5 -ts_adapt_type heuristic
fields of a mesh: fault -fault_mesh IN/graded.h5 -fault_parameters IN/cells.h5 -ts_adapt_type rl
unscaled: fault 10x10 -fault_stiffness_scaling none -ts_adapt_type heuristic
stiffness from a file: fault 6x5 -fault_stiffness_file IN/stiffness.h5 -ts_adapt_type heuristic
stiffness to a file: fault 20x16 -fault_stiffness_view binary:K.bin -fault_kernel full_space -fault_operator fft \
  -ts_adapt_type rl -fault_stiffness_scaling none
buried: fault 12x10 -fault_depth_top 2000 -fault_length_x 5000 -fault_thickness 4000 -ts_adapt_type heuristic
buried, full space: 2 fault 10x10 -fault_depth_top 1000 -fault_kernel full_space -ts_adapt_type heuristic
few fields written: fault 10x10 -fault_output_interval 3 -fault_output_fields slip -ts_adapt_type heuristic
file of options: fault -fault_nx 9 -fault_nz 9 -options_file EXAMPLES/fault_5km.opts -ts_adapt_type pi
check of the error: fault 10x10 -fault_check_error -ts_adapt_type rl
check on a mesh: 2 fault -fault_mesh IN/parallel.h5 -fault_check_error -ts_adapt_type rl
sweep: fault -fault_sweep IN/sweep.txt
# explicit steps
moreau: fault 12x12 -fault_operator fft -ts_type moreau -ts_adapt_type heuristic
moreau, 2 ranks: 2 fault 24x20 -fault_operator fft -mat_slipsqrtm_setup lanczos -ts_type moreau -ts_adapt_type rl
moreau, radiation: fault 12x10 -fault_viscosity radiation -ts_type moreau -ts_adapt_type pi
moreau, parts: fault 10x10 -ts_type moreau -fault_check_error -ts_adapt_type heuristic
moreau, two components: fault 10x10 -fault_slip_components 2 -ts_type moreau -ts_adapt_type heuristic
auto: fault 24x20 -fault_operator fft -ts_bathe_method auto -ts_adapt_type rl
auto, doubling: fault 10x8 -ts_bathe_method auto -ts_bathe_error doubling -ts_adapt_type heuristic
# operators and viscosities
dense: fault 18x14 -fault_operator dense -ts_adapt_type heuristic
dense, 2 ranks: 2 fault 18x14 -fault_operator dense -ts_adapt_type heuristic
dense, lanczos: fault 10x8 -fault_operator dense -fault_viscosity lanczos -ts_adapt_type rl
fft: fault 20x16 -fault_operator fft -ts_adapt_type heuristic
fft, 2 ranks: 2 fault 24x20 -fault_operator fft -ts_adapt_type rl
auto on a grid: fault 30x30 -fault_operator auto -ts_adapt_type rl
sqrtm auto: fault 20x20 -fault_operator fft -mat_slipsqrtm_setup auto -ts_adapt_type rl
sqrtm sketch: 2 fault 24x20 -fault_operator fft -mat_slipsqrtm_setup sketch -ts_adapt_type rl
sqrtm lanczos: fault 24x20 -fault_operator fft -mat_slipsqrtm_setup lanczos -ts_adapt_type rl
lanczos, 2 ranks: 2 fault 20x18 -fault_operator fft -fault_viscosity lanczos -ts_adapt_type rl
spectral: fault 20x16 -fault_operator fft -fault_viscosity spectral -ts_adapt_type heuristic
spectral lanczos: 2 fault 20x16 -fault_operator fft -fault_viscosity spectral -mat_slipspectral_type lanczos \
  -ts_adapt_type rl
no viscosity: fault 6x6 -fault_viscosity none -ts_adapt_type heuristic -ts_max_time 4
auto on a mesh: fault -fault_mesh IN/graded.h5 -fault_operator auto -ts_adapt_type heuristic -fault_rate_tolerance 1e-6
dense on two planes: fault -fault_mesh IN/parallel.h5 -fault_operator dense -ts_adapt_type rl
hmat: fault -fault_mesh IN/graded.h5 -fault_operator hmat -ts_adapt_type rl
hmat, 2 ranks: 2 fault -fault_mesh IN/parallel.h5 -fault_operator hmat -ts_adapt_type rl
hmat, lanczos: 2 fault -fault_mesh IN/graded.h5 -fault_operator hmat -fault_viscosity lanczos -ts_adapt_type rl
hmat, tolerances: fault -fault_mesh IN/parallel.h5 -fault_operator hmat -fault_viscosity lanczos -fault_hmat_tolerance \
  1e-5 -fault_krylov_tolerance 1e-7 -ts_adapt_type none -ts_dt 1
# solvers
projection: fault 2x2 -snes_type projection -ts_adapt_type heuristic -ts_max_time 3
projection, 2 ranks: 2 fault 2x2 -snes_type projection -ts_adapt_type none -ts_dt 0.1 -ts_max_time 1
no direct solves: fault 16x16 -snes_slip_direct_max 0 -ts_adapt_type rl
exact jacobian: fault 20x18 -fault_operator fft -mat_slipstage_jacobian exact -pc_slipstage_type symbol -ts_adapt_type \
  rl
approximate jacobian: fault 20x18 -fault_operator fft -mat_slipstage_jacobian approximate -ts_adapt_type rl
minres, jacobi: fault 12x12 -ksp_type minres -pc_type jacobi -snes_slip_direct_max 0 -ts_adapt_type rl
# integrator
implicit reaction: fault 10x10 -ts_bathe_reaction implicit -ts_adapt_type heuristic
as published: fault 10x10 -ts_bathe_reaction implicit -ts_bathe_error doubling -ts_adapt_type heuristic
doubling: fault 10x10 -ts_bathe_error doubling -ts_adapt_type pi
no estimate: fault 10x10 -ts_bathe_error none -ts_adapt_type rl -ts_adapt_rl_policy STUDY/fault_tqc_alpha1.h5
gamma: fault 10x10 -ts_bathe_gamma 0.5857864376 -ts_adapt_type heuristic
# controllers
pi elementary: fault 8x8 -ts_adapt_type pi -ts_adapt_pi_filter elementary
pi PI42: fault 8x8 -ts_adapt_type pi -ts_adapt_pi_filter PI42 -ts_rtol 1e-4
pi H211PI: fault 8x8 -ts_adapt_type pi -ts_adapt_pi_filter H211PI
pi H211b2: 2 fault 8x8 -ts_adapt_type pi -ts_adapt_pi_filter H211b2
pi by hand: fault 8x8 -ts_adapt_type pi -ts_adapt_pi_g1 3 -ts_adapt_pi_g2 5 -ts_adapt_pi_kappa 0.1
rl 1e-1: fault 14x14 -ts_adapt_type rl -ts_adapt_rl_accuracy 1e-1
rl 1e-2: 2 fault 14x14 -ts_adapt_type rl -ts_adapt_rl_accuracy 1e-2
rl 1e-3: fault 14x14 -ts_adapt_type rl -ts_adapt_rl_accuracy 1e-3
rl tqc: fault 10x10 -ts_adapt_type rl -ts_adapt_rl_policy STUDY/fault_tqc_alpha8.h5
rl study tqc: fault 10x10 -ts_adapt_type rl -ts_adapt_rl_policy STUDY/fault_tqc_alpha8.h5 -ts_bathe_reaction \
  implicit -ts_bathe_error doubling
rl study td3: fault 10x10 -ts_adapt_type rl -ts_adapt_rl_policy STUDY/fault_td3_alpha1.h5
basic: fault 8x8 -ts_adapt_type basic
dsp: fault 8x8 -ts_adapt_type dsp
constant steps: fault 10x10 -ts_adapt_type none -ts_dt 0.1 -ts_bathe_error none
# loading and healing, with catalogue, stations and restarts
healing: @60 fault {GRID} {WEAKENING} {HEALING} {WATCH} -ts_max_time 2e8
healing, 2 ranks: 2 @100 fault {GRID} {WEAKENING} {HEALING} {WATCH} -ts_adapt_type heuristic -fault_operator fft
healing, general policy: @80 fault {GRID} {WEAKENING} {HEALING} {WATCH} -ts_adapt_type rl -ts_adapt_rl_policy \
  POLICIES/ode.h5 -fault_output_time_interval 3e7 -fault_output_rate_change 10 -fault_output_slip_interval 0.02
healing, two planes: 2 @70 fault {PLANES} {WEAKENING_PLANES} {HEALING} {WATCH_PLANES} -ts_adapt_type pi -ts_max_time \
  1.95e8 -fault_output_size 20000
healing, inertia: @90 fault {GRID} {WEAKENING} {HEALING} {WATCH} -fault_inertia yes -fault_viscosity sqrtm \
  -ts_adapt_type dsp
healing, no viscosity: fault {GRID} {WEAKENING} {HEALING} -fault_inertia yes -fault_viscosity none -ts_adapt_type \
  basic -ts_max_time 1.14e8
loaded, linear law: @40 fault {GRID} {WEAKENING} {WATCH} -fault_friction_law linear_slip_weakening -ts_adapt_type \
  heuristic -ts_max_time 1.5e8 -fault_output_fields slip,state -fault_output_precision single \
  -fault_output_compression 4 -ts_bathe_first_stage trapezoidal
loaded, rate law: @25 fault {GRID} {WATCH} -fault_friction_law rate_weakening -fault_initial rest \
  -fault_viscosity radiation -fault_loading_rate 1e-8 -ts_max_time 4e8 -ts_adapt_type pi
stressing rate: 2 @20 fault {GRID} {WATCH} -fault_initial rest -fault_stressing_rate 0.1 -fault_healing_time 1e7 \
  -fault_inertia no -fault_viscosity radiation -ts_max_time 3.3e8 -ts_adapt_type dsp
law of the user's: friction_law 4x3 -fault_friction_law cut_off -fault_cut_off_rate 1e-2 -fault_loading_rate 1e-9 \
  -ts_max_time 1e9
# pore pressure
record, constant law: @9 fault {GRID} {PUSHED} {WATCH} -fault_friction_law constant -fault_pore_pressure \
  IN/pressure.h5 -fault_output_fields slip,pore_pressure -ts_adapt_type none -ts_dt 4e3
point, event: 2 @15 fault {GRID} {PUSHED_WEAKENING} {WATCH} {POINT} 4000,2000 -fault_friction_slip 0.05
point, measure: fault {GRID} {PUSHED_WEAKENING} {POINT} 4000,2000 -fault_inertia yes -ts_adapt_type rl \
  -ts_adapt_rl_measure final_slip
record and point, two planes: 2 @12 fault {PLANES} {PUSHED_WEAKENING} {WATCH_PLANES} {POINT} 4000,0,2000 \
  -fault_pore_pressure IN/pressure_planes.h5 -fault_operator hmat -ts_adapt_type pi -ts_rtol 1e-4 -ts_max_time 5.6e4
# rate and state
rate and state: @90 fault {GRID} {RATE_STATE} {WATCH} -ts_max_time 6.83e6
rate and state, slip law: 2 @200 fault {GRID} {RATE_STATE} {WATCH} -fault_state_law slip -ts_type rk -ts_rk_type 3bs \
  -ts_adapt_type basic -ts_max_time 3.2155e6 -fault_output_fields slip_rate,state
rate and state, two planes: 2 @80 fault {PLANES} {RATE_STATE_PLANES} {WATCH_PLANES} -ts_max_time 6.1735e6 -fault_view
rate and state, bathe: @40 fault {GRID} {RATE_STATE} {WATCH} -ts_type bathe -ts_adapt_type heuristic -ts_max_time \
  6.61e6
rate and state, creep: @60 fault {GRID} {RATE_STATE} {WATCH} -fault_parameters IN/creep.h5 -fault_operator fft \
  -fault_stiffness_average cell -ts_type rk -ts_rk_type 5dp -ts_adapt_type dsp -ts_max_time 6.75e6
rate and state, pressure: 2 @12 fault {GRID} {RATE_STATE} {WATCH} {POINT} 4000,2000 -fault_pore_pressure \
  IN/pressure.h5 -fault_initial traction -fault_initial_traction 28e6 -fault_initial_rate 1e-10 -ts_max_time 2e5 \
  -ts_adapt_type pi
rate and state, inertia: fault {GRID} {RATE_STATE} -fault_inertia yes -fault_viscosity sqrtm -ts_adapt_type pi \
  -ts_max_time 6.62e6
# small models
sliding mode, pi: sliding_mode -sliding_mode_case evaluation -ts_adapt_type pi
sliding mode, heuristic: sliding_mode -sliding_mode_case training -ts_adapt_type heuristic
sliding mode, rl: sliding_mode -sliding_mode_case evaluation -ts_adapt_type rl
sliding mode, study: sliding_mode -ts_adapt_type rl -ts_adapt_rl_policy STUDY/sliding_mode_td3.h5
circuit, pi: circuit -circuit_case evaluation -ts_adapt_type pi -circuit_reference 1e-3
circuit, heuristic: circuit -circuit_case training -ts_adapt_type heuristic
circuit, rl: circuit -circuit_case evaluation -circuit_reference 1e-3 -ts_adapt_type rl -ts_adapt_rl_accuracy 3e-3
circuit, study: circuit -ts_adapt_type rl -ts_adapt_rl_policy STUDY/circuit_tqc.h5
oscillator, pi: oscillator -ts_adapt_type pi
oscillator, heuristic: oscillator -ts_adapt_type heuristic
# training and the matrix of the study
train tqc: train {TRAIN_FAULT}
train td3: train {TRAIN_FAULT} -train_algorithm td3 -train_reward accuracy
train four, 2 ranks: 2 train {TRAIN_FAULT} -train_alpha 1,2 -train_seed 1,2
train tqc, circuit: train {TRAIN} -train_problem circuit -train_random
train cmaes: train {CMAES}
train cmaes, 2 ranks: 2 train {CMAES} -train_seed 1
train cmaes, circuit: train {CMAES} -train_problem circuit -train_dial_low 1e-2
train cmaes, sliding mode: train {CMAES} -train_problem sliding_mode -train_dial_low 1e-2
train ode: train {ODE} -train_problem ode -train_validation 4
train family of ruptures: train {RUNS} -train_family EXAMPLES/family_rupture.opts
evaluate: evaluate -evaluate_quick -evaluate_problems fault,sliding_mode,circuit -evaluate_reference_steps 200 \
  -evaluate_policies POLICIES/fault.h5,POLICIES/circuit.h5
"""

SWEEP = """-fault_nx 3 -fault_nz 2 -fault_output a.h5 -ts_adapt_type heuristic
-fault_nx 4 -fault_nz 4 -fault_output b.h5 -ts_adapt_type rl
"""

# Not compared: names of datasets and attributes (a policy's checksum is also of its date, lists are of places in a
# file), and lines of stdout
IGNORED = re.compile(
    r"wall|^cpu$|version$|_LIST$|^(cost|processor_time|options|policy|policy_file|created|date|checksum)$")
# Progress is printed by the clock, and -fault_view has the times of parts
IGNORED_LINE = re.compile(r"wall time|\bleft\b|memory|^set-up of|^calibration, up to about|\bafter \d+ s$"
                          r"|^time .* largest slip rate|^  [a-z -]+ +[\d.]+( +[\d.]+ %)? +[\d.]+( +[\d.]+ %)?$")
SECONDS = re.compile(r"(^generation .*) \d+ s\b", re.M)  # of a training so far
# How the solvers went, not what they found: named in the table only if nothing else differs
WORK = re.compile(r"residual|iterations|products|^(restarted )?std(out|err)")
TIME_LIMIT = 300  # [s] of a run


def sets():
    """[name, ranks, program, arguments, steps before the restart or 0] of each set"""
    found = []
    for name, row in re.findall(r"^([^#:\n]+): (.*)", SETS.replace("\\\n", ""), re.M):
        ranks, steps, program, text = re.fullmatch(r"(\d*) ?(?:@(\d+) )?(\w+) (.*)", row).groups()
        found.append([name, int(ranks or 1), program, text.format(**WORDS), int(steps or 0)])
    return found


def inputs(folder):
    """The files that sets read: meshes, fields of a grid and of a mesh, a stiffness, lines of sweeps."""
    def mesh(name, *arguments):
        subprocess.run([sys.executable, os.path.join(ROOT, "examples", "make_mesh.py"), os.path.join(folder, name),
                        *arguments], check=True, stdout=subprocess.DEVNULL)

    def write(name, **datasets):
        common.write(os.path.join(folder, name), **datasets)

    os.makedirs(folder)
    mesh("graded.h5", "graded", "--cells", "24", "18")
    mesh("parallel.h5", "parallel", "--cells", "16", "14", "--ratio", "2", "--shift", "500")
    z, x = np.mgrid[0:9, 0:12]
    write("fields.h5", normal_stress=20e6 + 2e6 * z + 1e6 * np.sin(x), friction_slip=0.1 + 0.02 * np.cos(x + z),
          friction_drop=0.1 + 0.001 * x * z)
    write("cells.h5", friction_drop=0.1 + 0.02 * np.sin(np.arange(24 * 18)))
    # A grid and two planes of cells of 1 km. Strength and stress scatter; under rate and state the inside weakens, from
    # a patch on that starts faster, and the corners below creep.
    mesh("planes.h5", "parallel", "--cells", "8", "4", "--size", "8000", "4000", "--offset", "1000", "--shift", "2500")
    z, x = np.mgrid[0:4, 0:8]
    inner = (x > 0) & (x < 7) & (z < 3)
    uneven = np.sin(37.0 * x + 61.0 * z)
    time = np.array([0, 1e5, 2e5, 3e5])
    for end, shape in (("", (4, 8)), ("_planes", (64,))):
        def cells(values):
            return np.broadcast_to(values, (1 + bool(end), 4, 8)).reshape(shape)

        rate_state = {"friction_a": cells(np.where(inner, 0.012, 0.028)),
                      "initial_rate": cells(np.where(inner & (x < 3), 3e-9, 1e-9))}
        write(f"rate_state{end}.h5", **rate_state)
        write(f"creep{end}.h5", creep=cells((z == 3) & (x % 7 == 0)).astype(float), **rate_state)
        write(f"weakening{end}.h5", friction_drop=cells(0.075 + 0.025 * uneven), friction_slip=cells(0.05 + 0 * x),
              initial_traction=cells(26e6 + 1e6 * np.cos(x + uneven)))
        pressure = np.array([0, 4e6, 5e6, 3e6])[:, None] * cells(np.exp(-0.1 * x)).ravel()
        write(f"pressure{end}.h5", time=time, pressure=pressure.reshape(4, *shape))
    n = np.arange(30.0)
    write("stiffness.h5", stiffness=3e7 * np.exp(-np.abs(n[:, None] - n[None, :])))
    with open(os.path.join(folder, "sweep.txt"), "w") as file:
        file.write(SWEEP)


def environment():
    """One thread a rank, ranks without cores of their own; options from the table only; each build's own policies."""
    env = {name: value for name, value in os.environ.items() if name not in ("SLIPSTEP_POLICY_DIR", "PETSC_OPTIONS")}
    env.update(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1", OMPI_MCA_btl_vader_single_copy_mechanism="none")
    if os.geteuid() == 0:
        env.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    return env


def command(build, ranks, program, text, folder):
    """The words of a set's command; folder: of inputs()."""
    places = {"IN/": folder, "POLICIES/": os.path.join(ROOT, "training", "policies"),
              "STUDY/": os.path.join(ROOT, "training", "study", "policies"),
              "EXAMPLES/": os.path.join(ROOT, "examples")}
    words = shlex.split(re.sub(r"^(\d+)x(\d+)", r"-fault_nx \1 -fault_nz \2", text))
    words = [re.sub(r"\b(IN|POLICIES|STUDY|EXAMPLES)/", lambda m: os.path.join(places[m[0]], ""), word)
             for word in words]
    mpirun = ["mpirun", "-n", str(ranks), "--oversubscribe"] if ranks > 1 else []
    return [*mpirun, os.path.join(build, "bin", program), *shlex.split(COMMON[program]), *words]


def runs(words, steps):
    """The commands of a set with the exit code each is to have; with steps, one that stops and one that goes on."""
    if not steps:
        return [(words, 0)]
    words = [*words, "-fault_checkpoint", "state.h5"]
    return [([*words, "-ts_max_steps", str(steps)], 3), ([*words, "-fault_restart", "state.h5"], 0)]


def run(arguments, folder, code):
    """What a run has written, as read_hdf5(), read_binary() and lines() give it; a text if its exit code is another."""
    os.makedirs(folder, exist_ok=True)
    try:
        done = subprocess.run(arguments, cwd=folder, env=environment(), capture_output=True, text=True,
                              timeout=TIME_LIMIT)
    except subprocess.TimeoutExpired:
        return f"no end after {TIME_LIMIT} s"
    for name in ("stdout", "stderr"):
        with open(os.path.join(folder, name), "a") as file:
            file.write(getattr(done, name))
    if done.returncode != code:
        said = done.stderr.splitlines()
        said = [line for line in said if "error" in line] or said or ["no message"]
        return f"exit code {done.returncode}: {said[0]}"
    values = lines("stdout", done.stdout)
    values.update(lines("stderr", "\n".join(line for line in done.stderr.splitlines() if "warning" in line)))
    for name in sorted(os.listdir(folder)):
        if name.endswith(".h5"):
            values.update(read_hdf5(os.path.join(folder, name)))
        elif name.endswith(".bin"):
            values.update(read_binary(os.path.join(folder, name)))
        elif name.endswith(".xdmf2"):
            values[name] = np.fromfile(os.path.join(folder, name), "u1")
    return values


def run_set(chosen, build, inputs_folder, folder, extra):
    """What all runs of a set have written with a build, those before a restart under names of their own."""
    _, ranks, program, text, steps = chosen
    words = command(build, ranks, program, text + extra, inputs_folder)
    found = {}
    for k, (arguments, code) in enumerate(runs(words, steps)):
        values = run(arguments, folder, code)
        if isinstance(values, str):
            return values
        found.update({f"restarted {key}" if k else key: value for key, value in values.items()})
    return found


def lines(stream, text):
    """Lines by their label, numbered where it repeats."""
    values, count = {}, collections.Counter()
    for line in SECONDS.sub(r"\1", text).splitlines():
        if line.strip() and not IGNORED_LINE.search(line):
            label, _, value = line.partition(":")
            count[label] += 1
            values[f"{stream} {label}" + (f" ({count[label]})" if count[label] > 1 else "")] = value.strip()
    return values


def read_hdf5(path):
    """All datasets and attributes by their names: arrays of numbers, all else as text."""
    values, base = {}, os.path.basename(path)

    def add(name, value):
        value = np.asarray(value)
        values[name] = value if value.dtype.kind in "biuf" else str(value.tolist())

    def visit(name, item):
        if any(IGNORED.search(part) for part in name.split("/")):
            return
        if isinstance(item, h5py.Dataset):
            add(f"{base}/{name}", item[()])
        for key, value in item.attrs.items():
            if not IGNORED.search(key):
                add(f"{base}/{name}@{key}", value)

    with h5py.File(path) as file:
        visit("", file)
        file.visititems(visit)
    return values


def read_binary(path):
    """A matrix in PETSc's binary format, dense or sparse: its integers, and its numbers, which come last."""
    with open(path, "rb") as file:
        data = file.read()
    _, rows, columns, nonzeros = np.frombuffer(data, ">i4", 4)
    start = len(data) - 8 * int(nonzeros if nonzeros >= 0 else rows * columns)
    base = os.path.basename(path)
    return {f"{base}/structure": np.frombuffer(data[:start], ">i4"),
            f"{base}/numbers": np.frombuffer(data[start:], ">f8")}


def difference(a, b):
    """None for the same bits; else a text, and the largest difference over the largest magnitude of a (or None)."""
    if a is None or b is None:
        return f"only in {'NEW' if a is None else 'BASE'}", None
    if isinstance(a, str) or isinstance(b, str):
        return None if str(a) == str(b) else (f"{a} -> {b}", None)
    if a.shape != b.shape or a.dtype != b.dtype:
        return f"{a.dtype} {list(a.shape)} -> {b.dtype} {list(b.shape)}", None
    if a.tobytes() == b.tobytes():
        return None
    a, b = a.astype("f8"), b.astype("f8")
    with np.errstate(invalid="ignore"):
        absolute = np.max(np.where((a == b) | (np.isnan(a) & np.isnan(b)), 0, np.abs(a - b)))  # NaN if only one is
    largest = np.max(np.abs(a[np.isfinite(a)]), initial=0)
    relative = absolute / largest if largest else np.inf if absolute else 0.0
    return f"largest difference {absolute:.3g}, relative {relative:.3g}", float(relative)


def compare(base, new):
    """Two runs: the differences in words, and the cell of the table, None for the same bits."""
    failed = {who: what for who, what in (("BASE", base), ("NEW", new)) if isinstance(what, str)}
    if failed:
        return [f"{who}: {what}" for who, what in failed.items()], " and ".join(failed) + " failed"
    found = {key: difference(base.get(key), new.get(key)) for key in dict.fromkeys([*base, *new])}
    found = {key: value for key, value in found.items() if value}
    if not found:
        return [], None
    numbers = {key: relative for key, (_, relative) in found.items() if relative is not None}
    numbers = {key: relative for key, relative in numbers.items() if not WORK.search(key)} or numbers
    others = [f"{key} {text}" for key, (text, relative) in found.items() if relative is None and not WORK.search(key)]
    cell = [f"{len(found)} of {len(base)} values differ"]
    if numbers:
        worst = max(numbers, key=lambda key: np.inf if np.isnan(numbers[key]) else numbers[key])
        cell.insert(0, f"{numbers[worst]:.1e} in {worst}")
    cell += sorted(others, key=lambda text: "/steps/" not in text)[:1]  # another number of steps, if any
    return [f"{key}: {text}" for key, (text, _) in found.items()], "; ".join(cell)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("base", metavar="BASE", help="build folder to compare with")
    parser.add_argument("new", metavar="NEW", help="build folder to compare")
    parser.add_argument("--only", metavar="REGEX", default="", help="only sets whose name matches")
    parser.add_argument("--keep", metavar="DIR", help="new folder for inputs and runs")
    parser.add_argument("--perturb", metavar="OPTIONS", default="", help=argparse.SUPPRESS)  # the self-test
    o = parser.parse_args()
    builds = {"base": os.path.abspath(o.base), "new": os.path.abspath(o.new)}
    chosen = [s for s in sets() if re.search(o.only, s[0])]
    for program in [os.path.join(build, "bin", s[2]) for build in builds.values() for s in chosen]:
        if not os.access(program, os.X_OK):
            parser.error(f"there is no program {program}")
    if not chosen:
        parser.error(f"no set matches {o.only}")
    if o.keep and os.path.exists(o.keep):
        parser.error(f"--keep {o.keep} exists")
    begin = time.time()
    table, count = [], 0
    with tempfile.TemporaryDirectory() as temporary:
        work = os.path.abspath(o.keep or os.path.join(temporary, "work"))
        inputs(os.path.join(work, "inputs"))
        for one in chosen:
            name = one[0]

            def result(who):
                extra = f" {o.perturb}" if who == "new" and one[2] == "fault" else ""
                folder = os.path.join(work, re.sub(r"\W+", "_", name), who)
                return run_set(one, builds[who], os.path.join(work, "inputs"), folder, extra)

            with concurrent.futures.ThreadPoolExecutor(2) as pool:
                base, new = pool.map(result, builds)
            found, cell = compare(base, new)
            table.append((name, cell))
            count += len(base)
            if cell:
                print("\n  ".join([f"{name}: {cell}", *found]), flush=True)
    same = sum(cell is None for _, cell in table)
    print(f"\n{'set':<28} largest relative difference")
    for name, cell in table:
        print(f"{name:<28} {cell or 'same bits'}")
    result = "all equal" if same == len(table) else f"{len(table) - same} sets differ: see above"
    print(f"{len(table)} sets, {count} datasets, attributes and lines, {result}; {time.time() - begin:.0f} s")
    return 0 if same == len(table) else 1


if __name__ == "__main__":
    sys.exit(main())
