#!/usr/bin/env bash
# A doublet on two faults that meet: one well injects into the main fault, another produces as much from its branch, so that all fluid flows through
# the line in which they meet. Installs what is missing (Debian 12 and 13, Ubuntu 24.04), builds into build/, makes the faults of rectangles,
# simulates 120 days with the producer and without it, prints where the fluid is and that the flow at the fork balances, and draws pressure, flux and
# slip on both faults. Half a minute.
#
#   examples/doublet.sh [OPTION...]                        options of build/bin/fault
#   CELL=50 examples/doublet.sh                            finer cells: minutes
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

slipstep_ready
name=$SLIPSTEP_OUTPUT/doublet
"$SLIPSTEP_PYTHON" examples/doublet.py make "$name" --cell "${CELL:-100}"
for case in doublet alone; do
  "$SLIPSTEP_BUILD/bin/fault" -options_file examples/doublet.opts -fault_mesh "${name}_mesh.h5" -fault_wells "${name}_$case.csv" \
    -fault_output "${name}_$case.h5" -fault_output_overwrite "$@"
done
"$SLIPSTEP_PYTHON" examples/doublet.py plot "$name"
