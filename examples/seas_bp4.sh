#!/usr/bin/env bash
# SEAS BP4-QD, the community's benchmark of earthquake cycles in a full space: installs what is missing (Debian 12 and 13, Ubuntu
# 24.04), builds into build/, simulates 1500 years, writes the benchmark's own files into output/seas_bp4/, and draws
# recurrence, rupture front and cumulative slip.
#
#   examples/seas_bp4.sh [OPTION...]                  options of build/bin/fault
#   CELL=250 YEARS=500 examples/seas_bp4.sh           cells of 250 m [m]; a shorter run
set -euo pipefail
cd "$(dirname "$0")/.."
. examples/seas_run.sh

slipstep_ready
seas_run seas_bp4 bp4 500 1500 "$@"
