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
good = np.array([[50, 0, 50, 100, 100], [150, 0, 50, 100, 100], [50, 200, 60, 100, 100.0]])


def mesh(name, row, columns="x y z length width"):
    with h5py.File(name, "w") as f:
        f["cells"] = np.vstack([good, [row]])
        f["cells"].attrs["columns"] = columns


mesh("mesh.h5", [150, 200, 60, 100, 100])
mesh("zero.h5", [150, 200, 60, 0, 100])
mesh("negative.h5", [150, 200, 60, 100, -5])
mesh("nan.h5", [150, 200, np.nan, 100, 100])
mesh("above.h5", [150, 200, 40, 100, 100])
mesh("overlap.h5", [149, 200, 60, 100, 100])
mesh("columns.h5", [150, 200, 60, 100, 100], "x z y length width")
with h5py.File("narrow.h5", "w") as f:
    f["cells"] = good[:, :4]
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
expect "none.h5" -fault_mesh none.h5
expect "k.h5 has no dataset /cells" -fault_mesh k.h5
expect "/cells has shape [3, 4], expected [n, 5]" -fault_mesh narrow.h5
expect 'the columns of /cells are "x z y length width"' -fault_mesh columns.h5
expect "zero.h5 (-fault_mesh): row 3 has length = 0" -fault_mesh zero.h5
expect "negative.h5 (-fault_mesh): row 3 has width = -5" -fault_mesh negative.h5
expect "nan.h5 (-fault_mesh): row 3 has z = nan" -fault_mesh nan.h5
expect "the cell of row 3 reaches above the surface" -fault_mesh above.h5
expect "the cells of rows 2 and 3 overlap" -fault_mesh overlap.h5
expect "-fault_operator fft needs a uniform grid, but -fault_mesh mesh.h5" -fault_mesh mesh.h5 -fault_operator fft
expect "needs a stiffness on a uniform grid" -fault_mesh mesh.h5 -fault_viscosity spectral
expect "-fault_stiffness_file k.h5 and -fault_mesh mesh.h5 exclude each other" -fault_mesh mesh.h5 -fault_stiffness_file k.h5

# An error before or during the run leaves an older output file alone.
expect "none.h5" "${mesh[@]}" -fault_output old.h5 -fault_stiffness_file none.h5
expect "-ts_adapt_dt_min" "${mesh[@]}" -fault_output old.h5 -ts_adapt_type heuristic -ts_adapt_dt_min 5 -ts_dt 20
[ "$(cat old.h5)" = "an older result" ] || { echo "FAILED: old.h5 was touched"; failed=1; }
[ ! -e x.h5 ] && [ ! -e x.h5.part ] || { echo "FAILED: x.h5 was written"; failed=1; }

# On two ranks as well: the message, an error code, and no hang.
for option in "-fault_nx 0" "-fault_stiffness_file none.h5" "-fault_output no/such/directory/x.h5" "-fault_mesh overlap.h5"; do
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
