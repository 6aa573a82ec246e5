#!/usr/bin/env bash
# SEAS BP1-QD, the community's benchmark of earthquake cycles in two dimensions, as a long fault: installs what is missing (Debian 12 and
# 13, Ubuntu 24.04), builds into build/, simulates 3000 years, writes the benchmark's own files into output/seas_bp1/, and
# draws recurrence and cumulative slip.
#
#   examples/seas_bp1.sh [OPTION...]                  options of build/bin/fault
#   CELL=50 YEARS=1000 examples/seas_bp1.sh           cells of 50 m in depth: also 100 and 25; a shorter run
set -euo pipefail
cd "$(dirname "$0")/.."
. examples/seas_run.sh

slipstep_ready
seas_run seas_bp1 bp1 200 3000 "$@"
