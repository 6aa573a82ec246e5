#!/usr/bin/env bash
# SEAS BP7-QD-A, the community's benchmark of a small patch whose slip is a vector: installs what is missing (Debian 12 and 13, Ubuntu
# 24.04), builds into build/, simulates 2 years, writes the benchmark's own files into output/seas_bp7/, and draws slip
# along both axes.
#
#   examples/seas_bp7.sh [OPTION...]                  options of build/bin/fault
#   CELL=5 YEARS=0.1 examples/seas_bp7.sh             cells of 5 m [m]; a shorter run
set -euo pipefail
cd "$(dirname "$0")/.."
. examples/seas_run.sh

slipstep_ready
seas_run seas_bp7 bp7 10 2 "$@"
