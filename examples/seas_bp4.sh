#!/usr/bin/env bash
# SEAS BP4-QD, the community's benchmark of earthquake cycles in a full space: installs what is missing (Debian 12 and 13, Ubuntu
# 24.04), builds into build/, simulates 1500 years, writes the benchmark's own files into output/seas_bp4/, and draws
# recurrence, rupture front and cumulative slip.
#
#   examples/seas_bp4.sh [OPTION...]                  options of build/bin/fault
#   CELL=250 YEARS=500 examples/seas_bp4.sh           cells of 250 m [m]; a shorter run
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

cell=${CELL:-500}
seconds=$(awk -v years="${YEARS:-1500}" 'BEGIN { printf "%.15g", years * 3.15576e7 }')
slipstep_ready
name=$SLIPSTEP_OUTPUT/seas_bp4
cells=$("$SLIPSTEP_PYTHON" examples/make_seas.py bp4 "${name}_fields.h5" --cell "$cell")
read -r nx nz <<<"$cells"
"$SLIPSTEP_BUILD/bin/fault" -options_file examples/seas_bp4.opts -fault_nx "$nx" -fault_nz "$nz" -fault_parameters "${name}_fields.h5" \
  -ts_max_time "$seconds" -fault_output "$name.h5" -fault_catalogue "${name}_events.h5" -fault_output_overwrite "$@"
"$SLIPSTEP_PYTHON" output/seas.py bp4 "$name.h5" "${name}_events.h5"
