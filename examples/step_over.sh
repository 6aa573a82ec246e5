#!/usr/bin/env bash
# Does a rupture jump to a fault beside it? Two vertical left-lateral faults of 20 km x 10 km overlap by 5 km, the second at some distances to the
# right of the first (a compressional step) and to the left (an extensional one). Installs what is missing (Debian 12 and 13, Ubuntu 24.04),
# builds into build/, runs each distance with normal stress that follows slip and with shear stress alone, and draws how far the rupture jumps.
#
#   examples/step_over.sh [OPTION...]                              options of build/bin/fault
#   DISTANCES="500 1000 2000" CELLS="80 40" examples/step_over.sh  other distances [m], finer cells
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

read -r nx nz <<<"${CELLS:-40 20}"
slipstep_ready
name=$SLIPSTEP_OUTPUT/step_over
for distance in ${DISTANCES:-500 750 1000 1250 1500}; do
  for side in "" -; do
    "$SLIPSTEP_PYTHON" examples/step_over.py make "$name" --cells "$nx" "$nz" --distance="$side$distance"
    for coupling in yes no; do
      run=${name}_$side${distance}_$coupling
      "$SLIPSTEP_BUILD/bin/fault" -options_file examples/step_over.opts -fault_mesh "${name}_mesh.h5" -fault_parameters "${name}_fields.h5" \
        -fault_normal_coupling "$coupling" -fault_output "$run.h5" -fault_output_overwrite -fault_progress no "$@" >"$run.txt" 2>&1 ||
        { cat "$run.txt" >&2; exit 1; }
    done
  done
done
"$SLIPSTEP_PYTHON" examples/step_over.py plot "$name"
