#!/usr/bin/env bash
# Makes the fine run that quickstart.sh compares with: small constant steps, second-order reaction, no error control.
#   examples/make_reference.sh [CELLS [OPTIONS_FILE [STEP]]]     default 50 examples/fault_3km.opts 0.0075
# Writes examples/reference/NAME_CELLSxCELLS_CASE.h5 without the fields. Repeating it with another STEP shows how
# far it has converged (final mean slip is printed); needs a build in build/.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

cells=${1:-50}
options=${2:-examples/fault_3km.opts}
step=${3:-0.0075}
case=$(basename "$options" .opts)
target=examples/reference/fault_${cells}x${cells}_${case#fault_}.h5

slipstep_environment
slipstep_find_python
mkdir -p output examples/reference
mpirun -n 2 build/bin/fault -options_file "$options" -fault_nx "$cells" -fault_nz "$cells" \
  -ts_adapt_type none -ts_dt "$step" -ts_bathe_reaction trapezoidal -ts_bathe_error none \
  -ts_max_steps 1000000 -ts_exact_final_time matchstep -fault_output output/reference.h5
slipstep compact output/reference.h5 "$target"
