#!/usr/bin/env bash
# A listric thrust of 20 km x 16 km, whose dip falls from 60 degrees at the ground to 15, as rectangles and as the unstructured triangles of Gmsh:
# installs what is missing (Debian 12 and 13, Ubuntu 24.04; python3-gmsh too), builds into build/, simulates its earthquakes on rectangles, on
# triangles with stress at centroids and on triangles with averages of stress, prints how often it breaks, and draws it.
#
#   examples/listric.sh [OPTION...]                    options of build/bin/fault
#   CELL=500 YEARS=250 examples/listric.sh             cells of 500 m
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

slipstep_ready python3-gmsh
name=$SLIPSTEP_OUTPUT/listric
"$SLIPSTEP_PYTHON" examples/listric.py make "$name" --cell "${CELL:-1000}"
for kind in rectangles centre cell; do
  case $kind in
    rectangles) mesh=${name}_rectangles_mesh.h5 fields=${name}_rectangles_fields.h5 average=centre ;;
    *) mesh=${name}_triangles_mesh.msh fields=${name}_triangles_fields.h5 average=$kind ;;
  esac
  "$SLIPSTEP_BUILD/bin/fault" -options_file examples/listric.opts -fault_mesh "$mesh" -fault_parameters "$fields" -fault_stiffness_average "$average" \
    -fault_output "${name}_$kind.h5" -fault_catalogue "${name}_${kind}_events.h5" -fault_output_overwrite -ts_max_time "${YEARS:-250}y" "$@"
done
"$SLIPSTEP_PYTHON" examples/listric.py plot "$name"
