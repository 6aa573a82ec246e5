# What the scripts of the SEAS benchmarks share. Source it, call slipstep_ready, then
#   seas_run NAME BENCHMARK CELL YEARS [OPTION...]
# with cells of CELL metres and for YEARS, unless the user has set either; options of build/bin/fault besides those of
# examples/seas_BENCHMARK.opts. It writes the benchmark's own files into $SLIPSTEP_OUTPUT/NAME/ and a picture beside them.
. tests/setup.sh

seas_run() {
  local name=$SLIPSTEP_OUTPUT/$1 benchmark=$2 cell=${CELL:-$3} years=${YEARS:-$4} cells nx nz seconds
  shift 4
  seconds=$(awk -v years="$years" 'BEGIN { printf "%.15g", years * 3.15576e7 }')
  cells=$("$SLIPSTEP_PYTHON" examples/make_seas.py "$benchmark" "${name}_fields.h5" --cell "$cell")
  read -r nx nz <<<"$cells"
  "$SLIPSTEP_BUILD/bin/fault" -options_file "examples/seas_$benchmark.opts" -fault_nx "$nx" -fault_nz "$nz" -fault_parameters "${name}_fields.h5" \
    -ts_max_time "$seconds" -fault_output "$name.h5" -fault_catalogue "${name}_events.h5" -fault_output_overwrite "$@"
  slipstep seas "$benchmark" "$name.h5" "${name}_events.h5" --figure "$name.png"
}
