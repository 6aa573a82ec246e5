#!/usr/bin/env bash
# A rupture of a heterogeneous fault from a nucleation patch: installs what is missing (Debian 12 and 13, Ubuntu 24.04), builds
# into build/, makes fields of strength and stress, simulates them, and draws slip rate, rupture times and stress drop.
#
#   examples/rupture.sh [OPTION...]             options of build/bin/fault, as -ts_max_time 60
#   CELLS="80 40" SEED=7 examples/rupture.sh    coarser cells, another fault
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

read -r nx nz <<<"${CELLS:-168 84}"
slipstep_ready
name=$SLIPSTEP_OUTPUT/rupture
"$SLIPSTEP_PYTHON" examples/make_fault.py "${name}_fields.h5" --cells "$nx" "$nz" --size 20000 10000 --slip 0.1 \
  --stress 0.6 --patch 5000 6000 2000 --seed "${SEED:-3}"
"$SLIPSTEP_BUILD/bin/fault" -options_file examples/fault_rupture.opts -fault_nx "$nx" -fault_nz "$nz" \
  -fault_parameters "${name}_fields.h5" -fault_output "$name.h5" -fault_catalogue "${name}_events.h5" \
  -fault_output_overwrite "$@"
slipstep plot-run "$name.h5" --kind rupture
