#!/usr/bin/env bash
# SEAS BP7-QD-A, the community's benchmark of a small patch whose slip is a vector: installs what is missing (Debian 12 and 13, Ubuntu
# 24.04), builds into build/, simulates 2 years, writes the benchmark's own files into output/seas_bp7/, and draws slip
# along both axes.
#
#   examples/seas_bp7.sh [OPTION...]                  options of build/bin/fault
#   CELL=5 YEARS=0.1 examples/seas_bp7.sh             cells of 5 m [m]; a shorter run
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

cell=${CELL:-10}
seconds=$(awk -v years="${YEARS:-2}" 'BEGIN { printf "%.15g", years * 3.15576e7 }')
slipstep_ready
name=$SLIPSTEP_OUTPUT/seas_bp7
cells=$("$SLIPSTEP_PYTHON" examples/make_seas.py bp7 "${name}_fields.h5" --cell "$cell")
read -r nx nz <<<"$cells"
"$SLIPSTEP_BUILD/bin/fault" -options_file examples/seas_bp7.opts -fault_nx "$nx" -fault_nz "$nz" -fault_parameters "${name}_fields.h5" \
  -ts_max_time "$seconds" -fault_output "$name.h5" -fault_catalogue "${name}_events.h5" -fault_output_overwrite "$@"
"$SLIPSTEP_PYTHON" output/seas.py bp7 "$name.h5" "${name}_events.h5"
