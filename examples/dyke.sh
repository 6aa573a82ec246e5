#!/usr/bin/env bash
# A dyke that opens under the pressure of its magma, and closes again, below a normal fault that it makes slip: installs what is missing (Debian
# 12 and 13, Ubuntu 24.04), builds into build/, simulates 40 days, and draws opening, slip and their course.
#
#   examples/dyke.sh [OPTION...]                options of build/bin/fault
#   CELL=500 PRESSURE=8 examples/dyke.sh        cells of 500 m; magma 8 MPa above what presses the dyke together
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

slipstep_ready
name=$SLIPSTEP_OUTPUT/dyke
"$SLIPSTEP_PYTHON" examples/dyke.py make "$name" --cell "${CELL:-250}" --pressure "${PRESSURE:-6}"
"$SLIPSTEP_BUILD/bin/fault" -options_file examples/dyke.opts -fault_mesh "${name}_mesh.h5" -fault_parameters "${name}_fields.h5" \
  -fault_pore_pressure "${name}_pressure.h5" -fault_output "$name.h5" -fault_catalogue "${name}_events.h5" -fault_output_overwrite "$@"
"$SLIPSTEP_PYTHON" examples/dyke.py plot "$name"
