#!/usr/bin/env bash
# BP5 and events of the 3 km fault on a device of OpenCL beside one process of the processor: times of a right-hand side, events, and on a card whole
# runs. On a card it is to end within seven minutes: each run has a limit.
#
#   tests/benchmarks/device.sh [DEVICE]           part of a device's name, or its number in clinfo -l
#   SMALL=1 tests/benchmarks/device.sh            cells of 1 km and 0.25 km, and an event on 64 x 64, without whole runs: for processors
#
# It runs from the tree after a build, or from a folder that device_bundle.sh has packed.
set -euo pipefail
cd "$(dirname "$0")"
export HWLOC_COMPONENTS=-opencl OPENBLAS_NUM_THREADS=1 OMPI_MCA_ess_singleton_isolated=1 OMPI_MCA_btl=self
if [ -d bundle ]; then
  export LD_LIBRARY_PATH=$PWD/bundle/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH} OMPI_MCA_mca_base_component_path=$PWD/bundle/openmpi/lib/openmpi3
  fault=("$PWD/bundle/bin/fault")
  inputs=$PWD/bundle
else
  . ../setup.sh
  slipstep_environment
  fault=("${SLIPSTEP_BUILD:-$PWD/../../build}/bin/fault")
  inputs=$(mktemp -d)
  trap 'rm -rf "$inputs"' EXIT
  grep -v '^-ts_type\|^-ts_adapt_type\|^-fault_stations\|^-fault_output' ../../examples/seas_bp5.opts >"$inputs/bp5.opts"
  for cell in 1000 250 ${SMALL:-100}; do
    [ "$cell" = "${SMALL:-}" ] || "${SLIPSTEP_PYTHON:-python3}" ../../examples/make_seas.py bp5 "$inputs/f$cell.h5" --cell "$cell" >/dev/null
  done
fi
name=()
[ $# = 0 ] || name=(-fault_device_name "$1")
declare -A nx=([1000]=100 [250]=400 [100]=1000) nz=([1000]=40 [250]=160 [100]=400)

# A run of a cell size by a device: its summary
run() { # cell, option...
  "${fault[@]}" -options_file "$inputs/bp5.opts" -fault_parameters "$inputs/f$1.h5" -fault_nx "${nx[$1]}" -fault_nz "${nz[$1]}" -fault_progress no "${@:2}" 2>&1 || [ $? = 3 ]
}
value() { awk -F: -v what="$1" '$1 == what { print $2 + 0 }'; }
# Milliseconds of a right-hand side: between two numbers of steps, the better of two
each() { # cell, steps, option...
  local best=
  for _ in 1 2; do
    local a b
    a=$(run "$1" -ts_max_time 1e12 -ts_max_steps "$2" "${@:3}")
    b=$(run "$1" -ts_max_time 1e12 -ts_max_steps $((5 * $2)) "${@:3}")
    best=$({ echo "$best"; echo "$a" | value "wall time of the solve"; echo "$a" | value "right-hand sides"; echo "$b" | value "wall time of the solve"; echo "$b" | value "right-hand sides"; } |
      awk 'NR == 1 { best = $1 } NR > 1 { x[NR - 1] = $1 } END { t = x[4] > x[2] ? 1000 * (x[3] - x[1]) / (x[4] - x[2]) : "nan"; print best == "" || t < best ? t : best }')
  done
  echo "$best"
}

view=$(run 1000 -ts_max_time 1 -fault_device opencl "${name[@]}" -fault_view)
echo "$view" | grep '^ *device: .*MB' || { echo "$view" | tail -1; exit 1; }
grep -m1 'model name' /proc/cpuinfo || true
echo "| cells | a right-hand side on the device [ms] | by one process [ms] | ratio |"
echo "|---|---|---|---|"
for cell in 1000 250 ${SMALL:-100}; do
  [ "$cell" != "${SMALL:-}" ] || continue
  steps=$((cell == 1000 ? 200 : cell == 250 ? 40 : 10))
  there=$(each $cell $steps -fault_device opencl "${name[@]}")
  here=$(each $cell $steps -fault_device none)
  awk -v cell=$cell -v n=$((nx[$cell] * nz[$cell])) -v a="$there" -v b="$here" 'BEGIN { printf "| %d (%g km) | %.3f | %.3f | %.2f |\n", n, cell / 1000, a, b, a / b }'
done
# Single events of friction that sticks, at the default accuracy of 1e-2
event() { # cells a side, option...
  "${fault[@]}" -fault_nx "$1" -fault_nz "$1" -fault_progress no -fault_wall_limit 60 "${@:2}" 2>&1 || [ $? = 152 ]
}
echo "| 3 km fault | on the device [s] | by one process [s] | products with K | |"
echo "|---|---|---|---|---|"
for n in $([ -n "${SMALL:-}" ] && echo 64 || echo 512 1000); do
  there=$(event "$n" -fault_device opencl "${name[@]}")
  here=$([ "$n" = 1000 ] || event "$n") # a minute at most
  echo "| $n x $n | $(echo "$there" | value "wall time of the solve") | $(echo "$here" | value "wall time of the solve") | $(echo "$there" | value "products with K") | $(echo "$there" | grep '^end:' | cut -c1-90)"
done
[ -z "${SMALL:-}" ] || exit 0
echo "| run on the device | wall [s] | right-hand sides |"
echo "|---|---|---|"
for case in "250 3000 60" "100 1800 200"; do
  read -r cell years limit <<<"$case"
  out=$(run "$cell" -ts_max_time "$(awk -v y="$years" 'BEGIN { printf "%.15g", y * 3.15576e7 }')" -fault_wall_limit "$limit" -fault_device opencl "${name[@]}" || true)
  echo "| $(awk -v c="$cell" 'BEGIN { print c / 1000 }') km, $years years | $(echo "$out" | value "wall time of the solve") | $(echo "$out" | value "right-hand sides") | $(echo "$out" | grep '^end:' | cut -c1-90)"
done
