#!/usr/bin/env bash
# SEAS BP4-FD, earthquake cycles on a plane in a full space, with waves: the fault of seas_bp4.sh, which radiates instead of being
# damped. Installs what is missing (Debian 12 and 13, Ubuntu 24.04), builds into build/, simulates it, writes the benchmark's own files
# into output/seas_bp4_fd/, and draws recurrence, rupture front and cumulative slip.
#
#   examples/seas_bp4_fd.sh [OPTION...]                 options of build/bin/fault
#   CELL=1000 YEARS=500 examples/seas_bp4_fd.sh        cells of 1 km, which are too large for more than a look; a longer run
set -euo pipefail
cd "$(dirname "$0")/.."
. examples/seas_run.sh

slipstep_ready
seas_run seas_bp4_fd bp4 500 250 -fault_medium waves "$@"
