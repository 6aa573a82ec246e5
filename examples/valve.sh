#!/usr/bin/env bash
# A fault that is a valve (Sibson 1992; Zhu et al. 2020) and makes swarms: fluid that rises from below gathers under sealed rock, its pressure lets
# slip climb the fault, slip opens the fault to the fluid, which drains upwards, and time seals the fault again. Installs what is missing (Debian
# 12 and 13, Ubuntu 24.04), builds into build/, makes fields, simulates 250 years of 16 km of depth, prints each swarm, and draws slip rate,
# pressure and permeability against time and depth. Some 15 s.
#
#   examples/valve.sh [OPTION...]                          options of build/bin/fault
#   examples/valve.sh -fault_permeability_healing_time 1e9 -ts_max_time 100y    the fault seals ten times as slowly
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

slipstep_ready
name=$SLIPSTEP_OUTPUT/valve
"$SLIPSTEP_PYTHON" examples/valve.py "${name}_fields.h5"
"$SLIPSTEP_BUILD/bin/fault" -options_file examples/valve.opts -fault_parameters "${name}_fields.h5" -fault_output "$name.h5" -fault_output_overwrite "$@"
"$SLIPSTEP_PYTHON" examples/valve.py plot "$name.h5" "$name.png"
