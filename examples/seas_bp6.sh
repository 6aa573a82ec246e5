#!/usr/bin/env bash
# SEAS BP6-QD-A, the community's benchmark of slow slip by injection: installs what is missing (Debian 12 and 13, Ubuntu 24.04), builds
# into build/, simulates 100 days of injection into a fault of rate-and-state friction and the time until two years, writes
# the benchmark's own files into output/seas_bp6/, and draws pressure, slip and slip rate.
#
#   examples/seas_bp6.sh [OPTION...]                  options of build/bin/fault, as -fault_state_law slip (BP6-QD-S)
#   CELL=50 YEARS=1 examples/seas_bp6.sh              cells of 50 m; a shorter run
set -euo pipefail
cd "$(dirname "$0")/.."
. examples/seas_run.sh

slipstep_ready
seas_run seas_bp6 bp6 100 2 -fault_pore_pressure "$SLIPSTEP_OUTPUT/seas_bp6_fields_pressure.h5" "$@"
