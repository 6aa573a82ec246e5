#!/usr/bin/env bash
# A normal fault and its antithetic: two faults of 30 km that dip 60 degrees towards each other, 8 km apart at the ground; the antithetic ends at
# the main fault, 7 km deep. Installs what is missing (Debian 12 and 13, Ubuntu 24.04), builds into build/, runs centuries of both with normal
# stress that follows slip and with shear stress alone, prints the events of each fault, and draws the largest one and what it does to the
# antithetic and to the ground.
#
#   examples/antithetic.sh [OPTION...]                 options of build/bin/fault
#   CELL=500 YEARS=1500 RANKS=4 examples/antithetic.sh
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

slipstep_ready
name=$SLIPSTEP_OUTPUT/antithetic
"$SLIPSTEP_PYTHON" examples/antithetic.py make "$name" --cell "${CELL:-1000}"
for coupling in yes no; do
  mpirun -n "${RANKS:-2}" "$SLIPSTEP_BUILD/bin/fault" -options_file examples/antithetic.opts -fault_mesh "${name}_mesh.h5" \
    -fault_parameters "${name}_fields.h5" -fault_normal_coupling "$coupling" -fault_output "${name}_$coupling.h5" \
    -fault_catalogue "${name}_${coupling}_events.h5" -fault_output_overwrite -ts_max_time "${YEARS:-1000}y" "$@"
done
"$SLIPSTEP_PYTHON" examples/antithetic.py plot "$name"
slipstep surface "${name}_yes_events.h5" --event largest --figure "${name}_surface.png"
