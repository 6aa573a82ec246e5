#!/bin/bash
# Bad input of the fault program: one line "fault: error: ..." that names the option, file or dataset; a non-zero exit
# code; an older output file left as it was.
set -u
fault=$SLIPSTEP_BUILD/bin/fault
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failed=0

"$SLIPSTEP_PYTHON" - <<'PY' || exit 77
import h5py
import numpy as np
K = np.eye(4) * 3e7
with h5py.File("k.h5", "w") as f:
    f["stiffness"] = K
    f["asymmetric"] = K + np.diag([1e6, 0, 0], 1)
    f["indefinite"] = np.diag([3e7, -1.0, 3e7, 3e7])
    f["text"] = "abc"
PY
echo "no HDF5" >not.h5
head -c 900 k.h5 >truncated.h5
echo "an older result" >old.h5

# expect TEXT ARGUMENTS...: fails, and its only line on stderr holds TEXT
expect() {
  local text=$1 lines
  shift
  if timeout 100 "$fault" "$@" >out.txt 2>err.txt; then
    echo "FAILED: fault $* succeeded"
    failed=1
  fi
  lines=$(grep -c . err.txt)
  if [ "$lines" != 1 ] || ! grep -qF -- "fault: error: " err.txt || ! grep -qF -- "$text" err.txt; then
    echo "FAILED: fault $*: expected one line with \"$text\", got:"
    cat err.txt
    failed=1
  fi
}

mesh=(-fault_nx 2 -fault_nz 2)
expect "-fault_nx is 0, expected a whole number >= 1" -fault_nx 0
expect "-fault_nz is -3, expected a whole number >= 1" -fault_nz -3
expect '-fault_nx is "2.5", expected a whole number >= 1' -fault_nx 2.5
expect "-fault_length_x is 0, expected a number > 0 m" -fault_length_x 0
expect "-fault_length_z is -2, expected a number > 0 m" -fault_length_z -2
expect '-fault_density is "heavy", expected a number > 0 kg/m^3' -fault_density heavy
expect '-fault_friction_law is "velcro", expected one of exponential_slip_weakening' -fault_friction_law velcro
expect '-fault_operator is "sparse", expected one of' -fault_operator sparse
expect '-fault_initial is "later", expected one of critical, rest' -fault_initial later
expect "cache directory no/dir (-fault_cache_dir): no such directory" -fault_cache_dir no/dir
expect "none.h5" -fault_stiffness_file none.h5
expect "not.h5 is not an HDF5 file" -fault_stiffness_file not.h5
expect "truncated.h5" -fault_stiffness_file truncated.h5
expect "/stiffness has shape [4, 4], expected [N, N] with N = nx nz = 9" -fault_nx 3 -fault_nz 3 \
  -fault_stiffness_file k.h5
expect "k.h5 has no dataset /K" "${mesh[@]}" -fault_stiffness_file k.h5:/K
expect "/text in k.h5 does not hold numbers" "${mesh[@]}" -fault_stiffness_file k.h5:/text
expect "k.h5:/asymmetric: the stiffness is not symmetric" "${mesh[@]}" -fault_stiffness_file k.h5:/asymmetric
expect "k.h5:/indefinite: the stiffness is not positive definite" "${mesh[@]}" -fault_stiffness_file k.h5:/indefinite
expect "none.h5" -fault_parameters none.h5
expect "holds none of the fields normal_stress" "${mesh[@]}" -fault_parameters k.h5
expect "cannot create no/such/directory/x.h5.part" -fault_output no/such/directory/x.h5
expect "is a directory" -fault_output .
expect '-fault_output_fields has "weather"' -fault_output x.h5 -fault_output_fields slip,weather
expect "weather" -ts_adapt_type weather
expect "-ts_type rk knows no friction, expected bathe" -ts_type rk

# An error before or during the run leaves an older output file alone.
expect "none.h5" "${mesh[@]}" -fault_output old.h5 -fault_stiffness_file none.h5
expect "-ts_adapt_dt_min" "${mesh[@]}" -fault_output old.h5 -ts_adapt_type heuristic -ts_adapt_dt_min 5 -ts_dt 20
[ "$(cat old.h5)" = "an older result" ] || { echo "FAILED: old.h5 was touched"; failed=1; }
[ ! -e x.h5 ] && [ ! -e x.h5.part ] || { echo "FAILED: x.h5 was written"; failed=1; }

# On two ranks as well: the message, an error code, and no hang.
for option in "-fault_nx 0" "-fault_stiffness_file none.h5" "-fault_output no/such/directory/x.h5"; do
  read -r -a args <<<"$option"
  timeout 100 mpirun --oversubscribe -n 2 "$fault" "${args[@]}" >out.txt 2>err.txt
  code=$?
  if [ $code = 0 ] || [ $code = 124 ] || ! grep -q "fault: error: " err.txt; then
    echo "FAILED: fault $option on two ranks: exit code $code"
    cat err.txt
    failed=1
  fi
done

# A mistyped option is named.
"$fault" -fault_nx 1 -fault_nz 1 -ts_max_time 0.1 -fault_lenght_x 5 >out.txt 2>err.txt || failed=1
grep -q "nothing has read the option -fault_lenght_x" err.txt || { echo "FAILED: mistyped option"; failed=1; }
exit $failed
