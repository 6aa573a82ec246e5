#!/usr/bin/env bash
# The whole study: run the matrix, draw its figures, write the tables of RESULTS.md. Stopped at any time, it goes on; cells of a
# policy whose file has changed since are made anew.
#   output/study.sh [FILE.h5]     default output/study.h5
# Environment: BUILD (build), RANKS (2), MESHES (25,50,75,100), SWEEP_MESHES (those up to 50: with a sweep of tolerances; empty: none),
# POLICIES (patterns), ACCURACIES (settings of a policy with a dial, besides its default of 1e-2), TOLERANCES (factors) and STEPS of the sweep,
# REFERENCE_STEPS (4000 up to 50 x 50), FINE_STEPS (1000, of finer meshes), TIME_LIMIT (seconds for each part of the matrix, 0: none),
# FIGURES (folder), PAGE (RESULTS.md), SLIPSTEP_PYTHON (python3 with h5py and matplotlib)
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
file=${1:-$here/output/study.h5}
meshes=${MESHES:-25,50,75,100}
policies=${POLICIES:-$here/training/policies/*.h5,$here/training/study/policies/*.h5}
tolerances=${TOLERANCES:-0.3,1,3,5,7,10,15,20,30,50,70,100,150,200,300,500,700,1000,2000,3000,10000,30000,100000,1000000}
steps=${STEPS:-3,4,5,6,7,8,9,10,12,15,17,20,25,30,35,40,50,60,70,85,100,150,200,300,500,1000}
python=${SLIPSTEP_PYTHON:-python3}
"$python" -c 'import h5py, matplotlib' 2>/dev/null || python=/usr/bin/python3
. "$here/tests/setup.sh"
slipstep_environment

evaluate() {
  mpirun -n "${RANKS:-2}" "${BUILD:-$here/build}/bin/evaluate" -evaluate_output "$file" -evaluate_time_limit "${TIME_LIMIT:-0}" "$@"
}
# The meshes of a list up to 50, or above
part() { # list test
  local out="" mesh
  for mesh in ${1//,/ }; do
    if [ "$mesh" "$2" 50 ]; then out=$out${out:+,}$mesh; fi
  done
  echo "$out"
}
coarse=$(part "$meshes" -le)
fine=$(part "$meshes" -gt)
sweep=$(part "${SWEEP_MESHES-$coarse}" -le)
all=(-evaluate_problems sliding_mode,circuit,fault -evaluate_policies "$policies" -evaluate_accuracies "${ACCURACIES:-1e-3,1e-1}")
many=(-evaluate_controllers heuristic,pi,dsp,none -evaluate_steps "$steps" -evaluate_repetitions 1 -evaluate_tolerances "$tolerances")
# every controller at the reference tolerance, three runs each for the times; then the sweeps; then fine meshes, one run each
if [ -n "$coarse" ]; then evaluate "${all[@]}" -evaluate_meshes "$coarse" -evaluate_reference_steps "${REFERENCE_STEPS:--1}"; fi
evaluate -evaluate_problems sliding_mode,circuit "${many[@]}"
if [ -n "$sweep" ]; then
  evaluate -evaluate_problems fault -evaluate_meshes "$sweep" "${many[@]}" -evaluate_reference_steps "${REFERENCE_STEPS:--1}"
fi
if [ -n "$fine" ]; then
  evaluate "${all[@]}" -evaluate_meshes "$fine" -evaluate_repetitions 1 -evaluate_reference_steps "${FINE_STEPS:-1000}"
fi
"$python" "$here/src/package/program.py" plot-study "$file" --figures "${FIGURES:-$here/output/figures}"
"$python" "$here/src/package/program.py" results-table "$file" --page "${PAGE:-$here/output/RESULTS.md}"
