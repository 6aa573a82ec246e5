#!/usr/bin/env bash
# SEAS BP5-QD, the community's benchmark of earthquake cycles in three dimensions: installs what is missing (Debian 12 and 13, Ubuntu
# 24.04), builds into build/, simulates 1800 years, writes the benchmark's own files into output/seas_bp5/, and draws
# recurrence, rupture front and cumulative slip.
#
#   examples/seas_bp5.sh [OPTION...]                  options of build/bin/fault
#   CELL=1000 YEARS=500 examples/seas_bp5.sh          cells of 1 km [m]: also 500 and 250; a shorter run
set -euo pipefail
cd "$(dirname "$0")/.."
. examples/seas_run.sh

slipstep_ready
seas_run seas_bp5 bp5 2000 1800 "$@"
