#!/usr/bin/env bash
# SEAS BP1-FD, the community's benchmark of earthquake cycles in two dimensions, with waves: the fault of seas_bp1.sh, which radiates instead of being
# damped. Installs what is missing (Debian 12 and 13, Ubuntu 24.04), builds into build/, simulates it, writes the benchmark's own files
# into output/seas_bp1_fd/, and draws recurrence and cumulative slip.
#
#   examples/seas_bp1_fd.sh [OPTION...]                 options of build/bin/fault
#   CELL=50 YEARS=500 examples/seas_bp1_fd.sh          cells of 50 m; a shorter run
set -euo pipefail
cd "$(dirname "$0")/.."
. examples/seas_run.sh

slipstep_ready
seas_run seas_bp1_fd bp1 100 1000 -fault_medium waves "$@"
