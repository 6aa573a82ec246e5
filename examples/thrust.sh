#!/usr/bin/env bash
# A thrust that plates drag until it breaks, above it a network of GNSS points: installs what is missing (Debian 12 and 13, Ubuntu
# 24.04), builds into build/, simulates 150 years, and draws the earthquake as a satellite and the network see it.
#
#   examples/thrust.sh [OPTION...]             options of build/bin/fault, as -fault_dip 45
#   CELLS="60 30" YEARS=300 RANKS=4 examples/thrust.sh
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

read -r nx nz <<<"${CELLS:-48 24}"
slipstep_ready
name=$SLIPSTEP_OUTPUT/thrust
"$SLIPSTEP_PYTHON" examples/make_thrust.py "${name}_fields.h5" "${name}_gnss.txt" --cells "$nx" "$nz"
mpirun -n "${RANKS:-2}" "$SLIPSTEP_BUILD/bin/fault" -options_file examples/thrust.opts -fault_nx "$nx" -fault_nz "$nz" \
  -fault_parameters "${name}_fields.h5" -fault_surface_stations "${name}_gnss.txt" -fault_output "$name.h5" \
  -fault_catalogue "${name}_events.h5" -fault_output_overwrite -ts_max_time "${YEARS:-150}y" "$@"
slipstep surface "${name}_events.h5" --event largest --look 257 39 --points "${name}_gnss.txt" \
  --figure "$name.png" --numbers "${name}_points.csv"
