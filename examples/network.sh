#!/usr/bin/env bash
# Centuries of a network of faults with rate-and-state friction: installs what is missing (Debian 12 and 13, Ubuntu 24.04), builds into build/,
# makes triangles of fault sections (random ones, or those of a national model), runs them, and draws the catalogue and the largest event.
# Stopped, by Ctrl-C for example, it goes on when it is started again.
#
#   examples/network.sh [OPTION...]                    options of build/bin/fault
#   FAULTS=50 TRIANGLES=100000 YEARS=1000 SECTIONS="sections.geojson rates.geojson" BOX="-118.9 -115.4 32.6 35.2" examples/network.sh
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

slipstep_ready
name=$SLIPSTEP_OUTPUT/network
state=$name.state.h5
make=(--faults "${FAULTS:-8}" --triangles "${TRIANGLES:-3000}" --seed "${SEED:-1}")
# shellcheck disable=SC2206 # words are files, and numbers
[ -z "${SECTIONS:-}" ] || make+=(--sections $SECTIONS ${BOX:+--box $BOX})
"$SLIPSTEP_PYTHON" examples/network.py "$name" "${make[@]}"
if [ -e "$name.h5.part" ] && [ -e "$state" ]; then
  again=(-fault_restart "$state")
  echo "The run before was stopped: this one goes on from $state; remove that file to begin anew."
else
  again=(-fault_output_overwrite)
fi
mpirun -n "${RANKS:-2}" "$SLIPSTEP_BUILD/bin/fault" -options_file examples/network.opts -fault_mesh "${name}_mesh.h5" \
  -fault_parameters "${name}_fields.h5" -ts_max_time "${YEARS:-300}y" -fault_output "$name.h5" -fault_catalogue "${name}_events.h5" \
  -fault_checkpoint "$state" "${again[@]}" "$@"
slipstep plot-catalogue "${name}_events.h5"
slipstep plot-catalogue "${name}_events.h5" --event largest
