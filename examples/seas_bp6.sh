#!/usr/bin/env bash
# SEAS BP6-QD-A, the community's benchmark of slow slip by injection: installs what is missing (Debian 12 and 13, Ubuntu 24.04), builds
# into build/, simulates 100 days of injection into a fault of rate-and-state friction and the time until two years, writes
# the benchmark's own files into output/seas_bp6/, and draws pressure, slip and slip rate.
#
#   examples/seas_bp6.sh [OPTION...]                  options of build/bin/fault, as -fault_state_law slip (BP6-QD-S)
#   CELL=50 YEARS=1 examples/seas_bp6.sh              cells of 50 m; a shorter run
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

cell=${CELL:-100}
seconds=$(awk -v years="${YEARS:-2}" 'BEGIN { printf "%.15g", years * 3.15576e7 }')
slipstep_ready
name=$SLIPSTEP_OUTPUT/seas_bp6
cells=$("$SLIPSTEP_PYTHON" examples/make_seas.py bp6 "${name}_fields.h5" --cell "$cell")
read -r nx nz <<<"$cells"
"$SLIPSTEP_BUILD/bin/fault" -options_file examples/seas_bp6.opts -fault_nx "$nx" -fault_nz "$nz" -fault_parameters "${name}_fields.h5" \
  -fault_pore_pressure "${name}_fields_pressure.h5" -ts_max_time "$seconds" -fault_output "$name.h5" -fault_catalogue "${name}_events.h5" \
  -fault_output_overwrite "$@"
"$SLIPSTEP_PYTHON" output/seas.py bp6 "$name.h5" "${name}_events.h5"
