#!/usr/bin/env bash
# Cracks of a given speed, a line and a circle, solved with waves and friction and compared with the exact solutions of Kostrov (1964, 1966): installs
# what is missing (Debian 12 and 13, Ubuntu 24.04), builds into build/, simulates them with cells of several sizes, prints how far off their
# slip is, and draws it: seconds.
#
#   examples/kostrov.sh [OPTION...]                         options of build/bin/friction_law
#   SPEED=0.9 examples/kostrov.sh                           of the front, over that of shear waves: 0.3, 0.5, 0.7, 0.8, 0.9 or 0.95
#   LINE="100 800" CIRCLE="50 200" examples/kostrov.sh      other numbers of cells across the fault
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

slipstep_ready
name=$SLIPSTEP_OUTPUT/kostrov
line=${LINE:-50 100 200 400}
circle=${CIRCLE:-25 50 100}
for shape in line circle; do
  for cells in ${!shape}; do
    run=${name}_${shape}_$cells
    of_run=$("$SLIPSTEP_PYTHON" examples/kostrov.py make "$run" --shape "$shape" --cells "$cells" --speed "${SPEED:-0.7}")
    # shellcheck disable=SC2086 # words
    "$SLIPSTEP_BUILD/bin/friction_law" -options_file examples/kostrov.opts $of_run -fault_parameters "${run}_fields.h5" -fault_output "$run.h5" \
      -fault_output_overwrite "$@" >"$run.log" || { cat "$run.log" && exit 1; }
  done
done
"$SLIPSTEP_PYTHON" examples/kostrov.py plot "$name" --line $line --circle $circle --speed "${SPEED:-0.7}"
