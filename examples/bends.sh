#!/usr/bin/env bash
# Ruptures of faults of triangles: a strike-slip fault that bends, from a file as community fault models have them (GOCAD TSurf), and a fault with a
# branch, two physical surfaces of Gmsh. Installs what is missing (Debian 12 and 13, Ubuntu 24.04; python3-gmsh too), builds into build/, converts,
# runs, and draws both.
#
#   examples/bends.sh [OPTION...]                      options of build/bin/fault
#   CELL=500 examples/bends.sh                         smaller triangles
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

slipstep_ready python3-gmsh
name=$SLIPSTEP_OUTPUT/bends
for kind in bend branch; do
  "$SLIPSTEP_PYTHON" examples/bends.py "$kind" "${name}_$kind" --cell "${CELL:-650}"
  mesh=${name}_$kind.msh
  if [ "$kind" = bend ]; then
    mesh=${name}_bend_mesh.h5
    "$SLIPSTEP_PYTHON" examples/convert_mesh.py "${name}_bend.ts" "$mesh"
  fi
  "$SLIPSTEP_BUILD/bin/fault" -options_file examples/bends.opts -fault_mesh "$mesh" -fault_parameters "${name}_${kind}_fields.h5" \
    -fault_output "${name}_${kind}.h5" -fault_catalogue "${name}_${kind}_events.h5" -fault_output_overwrite "$@"
  slipstep plot-run "${name}_${kind}.h5" --field slip --time 8 16 120 --figure "${name}_${kind}.png"
done
