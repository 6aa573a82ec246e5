#!/usr/bin/env bash
# SEAS BP1-QD, the community's benchmark of earthquake cycles in two dimensions, as a long fault: installs what is missing (Debian 12 and
# 13, Ubuntu 24.04), builds into build/, simulates 3000 years, writes the benchmark's own files into output/seas_bp1/, and
# draws recurrence and cumulative slip.
#
#   examples/seas_bp1.sh [OPTION...]                  options of build/bin/fault
#   CELL=50 YEARS=1000 examples/seas_bp1.sh           cells of 50 m in depth: also 100 and 25; a shorter run
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

cell=${CELL:-200}
seconds=$(awk -v years="${YEARS:-3000}" 'BEGIN { printf "%.15g", years * 3.15576e7 }')
slipstep_ready
name=$SLIPSTEP_OUTPUT/seas_bp1
cells=$("$SLIPSTEP_PYTHON" examples/make_seas.py bp1 "${name}_fields.h5" --cell "$cell")
read -r nx nz <<<"$cells"
"$SLIPSTEP_BUILD/bin/fault" -options_file examples/seas_bp1.opts -fault_nx "$nx" -fault_nz "$nz" -fault_parameters "${name}_fields.h5" \
  -ts_max_time "$seconds" -fault_output "$name.h5" -fault_catalogue "${name}_events.h5" -fault_output_overwrite "$@"
"$SLIPSTEP_PYTHON" output/seas.py bp1 "$name.h5" "${name}_events.h5"
