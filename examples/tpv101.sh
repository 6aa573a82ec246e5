#!/usr/bin/env bash
# TPV101, a dynamic rupture with rate-and-state friction and waves in a full space, started by a stress that rises within a
# second: installs what is missing (Debian 12 and 13, Ubuntu 24.04), builds into build/, simulates it, prints when cells break
# beside another code's times, and draws slip rate, slip and times of rupture. tpv103.sh: with strong rate weakening.
#
#   examples/tpv101.sh [OPTION...]                options of build/bin/fault: seconds
#   CELL=150 RANKS=2 examples/tpv101.sh           cells of 150 m: a minute
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

slipstep_ready
benchmark=${BENCHMARK:-tpv101}
name=$SLIPSTEP_OUTPUT/$benchmark
cells=$("$SLIPSTEP_PYTHON" examples/tpv101.py make "$benchmark" "$name" --cell "${CELL:-300}")
read -r nx nz <<<"$cells"
mpirun -n "${RANKS:-1}" "$SLIPSTEP_BUILD/bin/fault" -options_file "examples/$benchmark.opts" -fault_nx "$nx" -fault_nz "$nz" \
  -fault_parameters "${name}_fields.h5" -fault_output "$name.h5" -fault_catalogue "${name}_events.h5" -fault_output_overwrite "$@"
"$SLIPSTEP_PYTHON" examples/tpv101.py plot "$benchmark" "$name"
