#!/usr/bin/env bash
# 500 years of a loaded fault that heals, with its catalogue of events: installs what is missing (Debian 12 and 13, Ubuntu
# 24.04), builds into build/, makes a field of strength, simulates it, and draws the catalogue with cumulative slip, a
# space-time picture and the largest event. Stopped, by Ctrl-C for example, it goes on when it is started again.
#
#   examples/centuries.sh [OPTION...]                          options of build/bin/fault
#   YEARS=2000 CELLS="60 30" SEED=7 examples/centuries.sh      longer, finer cells, another fault
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

read -r nx nz <<<"${CELLS:-32 16}"
seconds=$(awk -v years="${YEARS:-500}" 'BEGIN { printf "%.15g", years * 3.15576e7 }')
slipstep_ready
name=$SLIPSTEP_OUTPUT/centuries
state=$name.state.h5

"$SLIPSTEP_PYTHON" examples/make_fault.py "${name}_fields.h5" --cells "$nx" "$nz" --size 20000 10000 \
  --stress 0.5 --seed "${SEED:-3}"
if [ -e "$name.h5.part" ] && [ -e "$state" ]; then
  again=(-fault_restart "$state")
  echo "The run before was stopped: this one goes on from $state; remove that file to begin anew."
else
  again=(-fault_output_overwrite)
fi
"$SLIPSTEP_BUILD/bin/fault" -options_file examples/fault_centuries.opts -fault_nx "$nx" -fault_nz "$nz" \
  -fault_length_x 20000 -fault_length_z 10000 -fault_parameters "${name}_fields.h5" -ts_max_time "$seconds" -fault_output "$name.h5" \
  -fault_catalogue "${name}_events.h5" -fault_catalogue_maps -fault_checkpoint "$state" -fault_checkpoint_interval 60 \
  "${again[@]}" "$@"
slipstep plot-catalogue "${name}_events.h5" "$name.h5" --every-event 5
slipstep plot-catalogue "${name}_events.h5" --event largest
slipstep plot-run "$name.h5" --kind space-time
slipstep report "$name.h5" --catalogue "${name}_events.h5"
