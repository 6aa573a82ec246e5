#!/usr/bin/env bash
# SEAS BP3-QD, the community's benchmark of earthquake cycles on a dipping fault, whose normal stress slip changes: installs what is missing
# (Debian 12 and 13, Ubuntu 24.04), builds into build/, simulates 1500 years, writes the benchmark's own files into
# output/seas_bp3_60_thrust/, and draws intervals beside published ones, normal stress and cumulative slip.
#
#   examples/seas_bp3.sh [OPTION...]                          a thrust of 60 degrees; options of build/bin/fault
#   DIP=30 SENSE=normal examples/seas_bp3.sh                  a normal fault of 30 degrees; also 90, where both are the same
#   CELL=25 YEARS=500 examples/seas_bp3.sh                    cells of 25 m along the dip: also 100 and 50; a shorter run
set -euo pipefail
cd "$(dirname "$0")/.."
. examples/seas_run.sh

dip=${DIP:-60} sense=${SENSE:-thrust}
case $sense in
  thrust) rake=90 ;;
  normal) rake=-90 ;;
  *) echo "seas_bp3.sh: SENSE is \"$sense\", expected thrust or normal" >&2; exit 1 ;;
esac
slipstep_ready
# the benchmark's twelve stations, by their distance along the dip
stations=$(awk -v dip="$dip" 'BEGIN { s = sin(dip * atan2(0, -1) / 180)
  n = split("0 2500 5000 7500 10000 12500 15000 17500 20000 25000 30000 35000", d)
  for (i = 1; i <= n; i++) printf "%s19.5e6,%.9g", (i > 1 ? ";" : ""), d[i] * s }')
# and those of the ground, by their distance from the trace: on both sides of it, and as far as 32 km
ground="19.5e6,-32e3;19.5e6,-16e3;19.5e6,-8e3;19.5e6,-1e-3;19.5e6,0;19.5e6,8e3;19.5e6,16e3;19.5e6,32e3"
seas_run "seas_bp3_${dip}_$sense" bp3 100 1500 -fault_dip "$dip" -fault_rake "$rake" -fault_stations "$stations" -fault_surface_stations "$ground" "$@"
