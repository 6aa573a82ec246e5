#!/usr/bin/env bash
# TPV3, a dynamic rupture with waves in a full space: installs what is missing (Debian 12 and 13, Ubuntu 24.04), builds into build/,
# simulates it, prints when cells break beside a published solution, and draws slip rate, slip and times of rupture. tpv5.sh: TPV5.
#
#   examples/tpv3.sh [OPTION...]                options of build/bin/fault: seconds
#   CELL=100 RANKS=2 examples/tpv3.sh           cells of 100 m, as the published solution has: a minute
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

slipstep_ready
benchmark=${BENCHMARK:-tpv3}
name=$SLIPSTEP_OUTPUT/$benchmark
cells=$("$SLIPSTEP_PYTHON" "examples/$benchmark.py" make "$name" --cell "${CELL:-300}")
read -r nx nz <<<"$cells"
mpirun -n "${RANKS:-1}" "$SLIPSTEP_BUILD/bin/fault" -options_file "examples/$benchmark.opts" -fault_nx "$nx" -fault_nz "$nz" \
  -fault_parameters "${name}_fields.h5" -fault_output "$name.h5" -fault_catalogue "${name}_events.h5" -fault_output_overwrite "$@"
"$SLIPSTEP_PYTHON" "examples/$benchmark.py" plot "$name"
