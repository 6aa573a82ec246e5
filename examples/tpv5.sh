#!/usr/bin/env bash
# TPV5, a dynamic rupture with waves of a fault that reaches the ground: what examples/tpv3.sh does with TPV3.
#
#   examples/tpv5.sh [OPTION...]                options of build/bin/fault: seconds
#   CELL=100 RANKS=2 examples/tpv5.sh           cells of 100 m, as the published solution has: minutes
BENCHMARK=tpv5 exec "$(dirname "$0")/tpv3.sh" "$@"
