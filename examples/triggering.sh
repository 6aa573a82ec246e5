#!/usr/bin/env bash
# Two parallel faults that trigger each other: installs what is missing (Debian 12 and 13, Ubuntu 24.04), builds into build/,
# makes a mesh of two loaded faults that heal, the second ahead of the first, simulates them together and each alone, and
# draws when each of them breaks.
#
#   examples/triggering.sh [OPTION...]                    options of build/bin/fault
#   YEARS=600 CELLS="20 10" examples/triggering.sh        longer, finer cells
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

read -r nx nz <<<"${CELLS:-10 5}"
seconds=$(awk -v years="${YEARS:-400}" 'BEGIN { printf "%.15g", years * 3.15576e7 }')
slipstep_ready
name=$SLIPSTEP_OUTPUT/triggering

"$SLIPSTEP_PYTHON" examples/make_mesh.py "${name}_mesh.h5" parallel --cells "$nx" "$nz" --size 10000 5000 \
  --offset 500 --shift 10000
"$SLIPSTEP_PYTHON" examples/make_fault.py "${name}_fields.h5" --mesh "${name}_mesh.h5" --stress 0.5
"$SLIPSTEP_PYTHON" examples/triggering.py split "$name"
for case in both first second; do
  printf '\n== %s ==\n' "$case"
  "$SLIPSTEP_BUILD/bin/fault" -options_file examples/fault_centuries.opts -fault_mesh "${name}_${case}_mesh.h5" \
    -fault_parameters "${name}_${case}_fields.h5" -fault_thickness 10000 -ts_max_time "$seconds" \
    -fault_catalogue "${name}_${case}.h5" -fault_catalogue_maps -fault_output_overwrite "$@"
done
"$SLIPSTEP_PYTHON" examples/triggering.py plot "$name"
