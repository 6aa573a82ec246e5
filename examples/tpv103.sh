#!/usr/bin/env bash
# TPV103, a dynamic rupture with strong rate weakening and waves in a full space: what examples/tpv101.sh does with TPV101.
#
#   examples/tpv103.sh [OPTION...]                options of build/bin/fault: seconds
BENCHMARK=tpv103 exec "$(dirname "$0")/tpv101.sh" "$@"
