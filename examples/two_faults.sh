#!/usr/bin/env bash
# Two parallel faults that break together: installs what is missing (Debian 12), builds into build/, makes a mesh of two
# graded planes, simulates it on two ranks under the trained policy, and plots it.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

mesh=output/two_faults_mesh.h5
run=output/two_faults.h5

slipstep_setup
slipstep_build build -DBUILD_TESTING=OFF
"$SLIPSTEP_PYTHON" examples/make_mesh.py "$mesh" parallel --cells 24 24 --size 3000 3000 --ratio 3 \
  --offset 1000 --shift 500
mpirun -n 2 build/bin/fault -options_file examples/fault_parallel.opts -fault_mesh "$mesh" \
  -ts_adapt_type rl -ts_adapt_rl_policy training/policies/fault.h5 \
  -fault_output "$run" -fault_output_fields slip_rate,slip
slipstep plot-run "$run"
