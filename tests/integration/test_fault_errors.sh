#!/bin/bash
# Bad input of the fault program: one line "fault: error: ..." that names the option, file or dataset; a non-zero exit
# code; an older output file left as it was, and no .part of a run that did not begin.
set -u
fault=$SLIPSTEP_BUILD/bin/fault
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"

"$SLIPSTEP_PYTHON" - <<'PY' || exit 77
import os
import shutil
import h5py
import numpy as np
K = np.eye(4) * 3e7
with h5py.File("k.h5", "w") as f:
    f["stiffness"] = K
    f["asymmetric"] = K + np.diag([1e6, 0, 0], 1)
    f["indefinite"] = np.diag([3e7, -1.0, 3e7, 3e7])
    f["text"] = "abc"
    f["nan"] = K * np.nan
    f["oblong"] = np.ones((4, 3))
    f["list"] = np.ones(4)
good = np.array([[50, 0, 50, 100, 100], [150, 0, 50, 100, 100], [50, 200, 60, 100, 100.0]])


def mesh(name, row, columns="x y z length width"):
    with h5py.File(name, "w") as f:
        f["cells"] = np.vstack([good, [row]])
        f["cells"].attrs["columns"] = columns
        f["cells"].attrs["units"] = "m"


mesh("mesh.h5", [150, 200, 60, 100, 100])
mesh("zero.h5", [150, 200, 60, 0, 100])
mesh("negative.h5", [150, 200, 60, 100, -5])
mesh("nan.h5", [150, 200, np.nan, 100, 100])
mesh("above.h5", [150, 200, 40, 100, 100])
mesh("overlap.h5", [149, 200, 60, 100, 100])
mesh("columns.h5", [150, 200, 60, 100, 100], "x z y length width")
for name, values in {"many": np.full(5, 1e7), "grid": np.full((2, 2), 1e7)}.items():
    with h5py.File(f"cells_{name}.h5", "w") as f:
        f["normal_stress"] = values
with h5py.File("narrow.h5", "w") as f:
    f["cells"] = good[:, :4]
for name, values in {"shape": np.full((3, 2), 1e7), "nan": np.full((2, 2), np.nan), "negative": np.full((2, 2), -1.0),
                     "text": "abc"}.items():
    with h5py.File(f"stress_{name}.h5", "w") as f:
        f["normal_stress"] = values
with h5py.File("stress_list.h5", "w") as f:
    f["normal_stress"] = np.full(3, 1e7)

# Sizes that the files only claim: refused before anything is read.
for name, path, shape in (("wide", "cells", (3, 10**9)), ("long", "cells", (10**9, 5)), ("wide_stress", "normal_stress", (3, 10**9)),
                          ("wide_k", "stiffness", (10**6, 10**6)), ("wrap", "cells", (2**31, 5))):
    with h5py.File(f"{name}.h5", "w") as f:
        f.create_dataset(path, shape, chunks=(1, 5))

# of damaged policies tests/unit/test_policy.c has all kinds; this one has an observation that a fault does not know
for name in ("p_good.h5", "p_names.h5"):
    shutil.copy(os.environ["SLIPSTEP_SOURCE"] + "/training/study/policies/fault_tqc_alpha8.h5", name)
with h5py.File("p_names.h5", "r+") as f:
    del f.attrs["checksum"]
    names = f["observation/names"][:]
    del f["observation/names"]
    f["observation/names"] = np.array(["weather"] + [n.decode() for n in names[1:]], dtype=h5py.string_dtype())
PY
echo "no HDF5" >not.h5
head -c 900 k.h5 >truncated.h5
head -c 5000 p_good.h5 >p_truncated.h5
"$SLIPSTEP_PYTHON" -c 'import h5py; h5py.File("old.h5", "w")["older"] = 1'
cp old.h5 reference

# expect WORD|WORD... ARGUMENTS...: the fault refuses and names each, and an older output file stays as it was
expect() {
  local words
  IFS='|' read -ra words <<<"$1"
  refuses "${words[@]}" -- "$fault" "${@:2}"
  cmp -s old.h5 reference || { fail "$*: old.h5 was touched"; cp reference old.h5; }
}

mesh=(-fault_nx 2 -fault_nz 2)
expect "-fault_nx is 0" -fault_nx 0
expect "-fault_nz is -3" -fault_nz -3
expect '-fault_nx is "2.5"' -fault_nx 2.5
expect "-fault_length_x is 0" -fault_length_x 0
expect "-fault_length_z is -2" -fault_length_z -2
expect '-fault_density is "heavy"' -fault_density heavy
expect '-fault_friction_law is "velcro"' -fault_friction_law velcro
expect '-fault_medium is "jelly"' -fault_medium jelly
expect '-fault_operator is "sparse"' -fault_operator sparse
expect '-fault_initial is "later"' -fault_initial later
expect "truncated.h5" -fault_stiffness_file truncated.h5
expect "[4, 4]|[9, 9]" -fault_nx 3 -fault_nz 3 -fault_stiffness_file k.h5
expect "k.h5|/K" "${mesh[@]}" -fault_stiffness_file k.h5:/K
expect "/text|k.h5" "${mesh[@]}" -fault_stiffness_file k.h5:/text
expect "k.h5:/asymmetric" "${mesh[@]}" -fault_stiffness_file k.h5:/asymmetric
expect "k.h5:/indefinite" "${mesh[@]}" -fault_stiffness_file k.h5:/indefinite
expect "none.h5" -fault_parameters none.h5
expect "k.h5|/asymmetric" "${mesh[@]}" -fault_parameters k.h5
expect "-fault_friction_alpha|4 cells" "${mesh[@]}" -fault_friction_law rate_and_state -fault_friction_alpha 0.2 -fault_friction_b 0
expect "-fault_output" -fault_output .
expect '-fault_output_fields has "weather"' -fault_output x.h5 -fault_output_fields slip,weather
expect "weather" -ts_adapt_type weather
expect "-ts_type rk" -ts_type rk
expect "none.h5" -fault_mesh none.h5
expect "not.h5|-fault_mesh" -fault_mesh not.h5
echo "solid" >facets.stl
expect "facets.stl (-fault_mesh)|convert_mesh.py facets.stl facets.h5" -fault_mesh facets.stl
mkdir folder
expect "folder (-fault_mesh)" -fault_mesh folder
expect "k.h5|/cells" -fault_mesh k.h5
: >empty.txt
expect "empty.txt (-fault_sweep)" -fault_sweep empty.txt
expect "/cells|narrow.h5|[3, 4]|[any, 5]|-fault_mesh" -fault_mesh narrow.h5
expect '/cells|"x z y length width"' -fault_mesh columns.h5
expect "zero.h5 (-fault_mesh): row 3 has length = 0" -fault_mesh zero.h5
expect "negative.h5 (-fault_mesh): row 3 has width = -5" -fault_mesh negative.h5
expect "nan.h5 (-fault_mesh): row 3 has z = nan" -fault_mesh nan.h5
expect "row 3" -fault_mesh above.h5
expect "0.0523599 m|-fault_dip" -fault_dip 0.01
expect "rows 2 and 3" -fault_mesh overlap.h5
expect "-fault_operator fft|-fault_mesh mesh.h5" -fault_mesh mesh.h5 -fault_operator fft
expect "-fault_mesh mesh.h5" -fault_mesh mesh.h5 -fault_viscosity spectral
expect "-fault_operator hmat" -fault_operator hmat -fault_viscosity spectral
expect "-fault_stiffness_file k.h5" "${mesh[@]}" -fault_stiffness_file k.h5 -fault_viscosity spectral
for type in fft hmat; do
  expect "-fault_stiffness_file k.h5" "${mesh[@]}" -fault_stiffness_file k.h5 -fault_operator $type
done
expect "[3, 2]" -fault_mesh mesh.h5 -fault_parameters stress_shape.h5
expect "[3]|[4]" -fault_mesh mesh.h5 -fault_parameters stress_list.h5
expect "/cells in wide.h5|[3, 1000000000]" -fault_mesh wide.h5
expect "/cells|long.h5|[1000000000, 5]|0 bytes" -fault_mesh long.h5
expect "/cells in wrap.h5|[2147483648, 5]" -fault_mesh wrap.h5
expect "[3, 1000000000]|[2, 2]" "${mesh[@]}" -fault_parameters wide_stress.h5
expect "/stiffness in wide_k.h5|[1000000, 1000000]" "${mesh[@]}" -fault_stiffness_file wide_k.h5
expect "-fault_rate_tolerance is 0" -fault_rate_tolerance 0
expect "-fault_stiffness_file k.h5|-fault_mesh mesh.h5" -fault_mesh mesh.h5 -fault_stiffness_file k.h5

# What the option, its file or its dataset must be is named.
mesh+=(-fault_output old.h5)
expect "none.h5|-fault_stiffness_file" "${mesh[@]}" -fault_stiffness_file none.h5
expect "not.h5|-fault_stiffness_file" "${mesh[@]}" -fault_stiffness_file not.h5
expect "-fault_stiffness_file" "${mesh[@]}" -fault_stiffness_file
expect "/nan[0, 0] is nan" "${mesh[@]}" -fault_stiffness_file k.h5:/nan
expect "/oblong in k.h5|[4, 3]" "${mesh[@]}" -fault_stiffness_file k.h5:/oblong
expect "/list in k.h5|[4]" "${mesh[@]}" -fault_stiffness_file k.h5:/list
expect "/normal_stress in stress_shape.h5|[3, 2]" "${mesh[@]}" -fault_parameters stress_shape.h5
expect "/normal_stress[0, 0] is nan" "${mesh[@]}" -fault_parameters stress_nan.h5
expect "/normal_stress[0, 0] is -1" "${mesh[@]}" -fault_parameters stress_negative.h5
expect "/normal_stress|stress_text.h5" "${mesh[@]}" -fault_parameters stress_text.h5
expect "none.h5|-fault_parameters" "${mesh[@]}" -fault_parameters none.h5
expect "-fault_output" -fault_output no/such/directory/x.h5
expect "-fault_output" -fault_output
expect '-fault_nx is "abc"' "${mesh[@]}" -fault_nx abc
expect "-fault_length_x is nan" "${mesh[@]}" -fault_length_x nan
expect "-fault_normal_stress is nan" "${mesh[@]}" -fault_normal_stress nan
expect "$dt is 0" "${mesh[@]}" -ts_dt 0
expect "($dt)" "${mesh[@]}" -ts_dt abc
expect "-ts_max_time is -1" "${mesh[@]}" -ts_max_time -1
expect "-ts_max_steps is -4" "${mesh[@]}" -ts_max_steps -4
expect "-ts_adapt_dt_min is -1" "${mesh[@]}" -ts_adapt_dt_min -1
for option in ts_type snes_type ksp_type pc_type; do
  expect "velcro|-$option" "${mesh[@]}" -$option velcro
done
for option in ts_rtol ts_adapt_safety ts_bathe_gamma snes_rtol ksp_max_it; do
  expect "abc|-$option" "${mesh[@]}" -$option abc
done
for clip in abc 0.2 1,2 0.2,0.5 0.2,3,4 0.2,3x nan,2; do
  expect "-ts_adapt_clip|$clip" "${mesh[@]}" -ts_adapt_clip $clip
done
expect "-ts_adapt_dsp_pid|1,2,3,4" "${mesh[@]}" -ts_adapt_type dsp -ts_adapt_dsp_pid 1,2,3,4
expect "-ts_max_reject is 0" "${mesh[@]}" -ts_adapt_type heuristic -ts_dt 5 -ts_max_reject 0
expect "-fault_density is 1e+308" "${mesh[@]}" -fault_density 1e308
sticks=("${mesh[@]}" -fault_inertia no -fault_viscosity radiation -ts_type rkc)
expect "-ts_rkc_rate is 1e+308" "${sticks[@]}" -ts_rkc_rate 1e308
expect "-ts_rkc_rate 1e+50" "${sticks[@]}" -ts_rkc_rate 1e50
for gamma in 0 1.5; do expect "-ts_bathe_gamma is $gamma" "${mesh[@]}" -ts_bathe_gamma $gamma; done
expect "-ts_bathe_order is 0" "${mesh[@]}" -ts_bathe_order 0
for option in ts_max_steps ts_max_snes_failures snes_max_it ksp_max_it; do
  expect "2.5|-$option" "${mesh[@]}" -$option 2.5
done
expect "-ts_bathe_max_failures is 0" "${mesh[@]}" -ts_bathe_max_failures 0
expect "-ts_bathe_reaction|trapezoidal implicit" "${mesh[@]}" -ts_bathe_reaction velcro
expect "-ts_bathe_error|embedded doubling none" "${mesh[@]}" -ts_bathe_error velcro
expect "-snes_type newtonls|semismooth" "${mesh[@]}" -snes_type newtonls

# Policies.
rl=("${mesh[@]}" -ts_adapt_type rl)
expect "none.h5|-ts_adapt_rl_policy" "${rl[@]}" -ts_adapt_rl_policy none.h5
expect "not.h5|-ts_adapt_rl_policy" "${rl[@]}" -ts_adapt_rl_policy not.h5
expect "p_truncated.h5" "${rl[@]}" -ts_adapt_rl_policy p_truncated.h5
expect 'entry 0 of /observation/names is "weather"' "${rl[@]}" -ts_adapt_rl_policy p_names.h5
expect "-ts_adapt_rl_policy" "${rl[@]}" -ts_adapt_rl_policy
other=$SLIPSTEP_SOURCE/training/study/policies/sliding_mode_tqc.h5
expect "sliding_mode|fault|-ts_adapt_rl_policy" "${rl[@]}" -ts_adapt_rl_policy "$other"
"$fault" -fault_nx 2 -fault_nz 2 -ts_max_time 1 -ts_adapt_type rl -ts_adapt_rl_policy "$other" -ts_adapt_rl_problem \
  sliding_mode >out.txt 2>err.txt || fail "a policy of another problem that was asked for: $(cat err.txt)"

# An error before or during the run leaves an older output file alone.
expect "none.h5" "${mesh[@]}" -fault_output old.h5 -fault_stiffness_file none.h5
"$fault" "${mesh[@]}" -ts_adapt_type heuristic -ts_rtol 1e-3 -ts_adapt_dt_min 5 -ts_dt 20 >out.txt 2>err.txt && failed=1
grep -q -e "-ts_adapt_dt_min" err.txt || fail "-ts_adapt_dt_min is not named"
cmp old.h5 reference || fail "old.h5 was touched"
rm -f old.h5.part # what that run had computed would be kept
[ ! -e x.h5 ] && [ ! -e x.h5.part ] || fail "x.h5 was written"

# An output destroys nothing: neither what is special, nor of another format, nor an input, by whatever name. Links are
# followed.
mkfifo pipe
ln -s ../"$(basename "$work")"/stress_list.h5 link.h5
ln -s round.h5 round.h5
expect "/dev/null" -fault_output /dev/null
expect "pipe" -fault_output pipe
expect "not.h5|-fault_output" -fault_output not.h5
expect "round.h5" -fault_output round.h5
"$SLIPSTEP_PYTHON" -c 'import h5py, numpy; h5py.File("stress.h5", "w")["normal_stress"] = numpy.full((2, 2), 1e7)'
ln -s stress.h5 input.h5
expect "-fault_parameters stress.h5|-fault_output input.h5" -fault_nx 2 -fault_nz 2 -fault_parameters stress.h5 -fault_output input.h5
expect "-ts_adapt_rl_policy p_good.h5|-fault_output ./p_good.h5" "${rl[@]}" -ts_adapt_rl_policy p_good.h5 -fault_output ./p_good.h5
code=0
"$fault" -fault_friction_law rate_and_state -fault_loading_rate 1e-9 -ts_max_time 1 -fault_check_error >/dev/null 2>err.txt || code=$?
[ $code = 1 ] && grep -q "error: -fault_check_error .* -ts_type adams .* -ts_type bathe" err.txt ||
  fail "-fault_check_error of explicit steps: exit code $code, $(cat err.txt)"
ln -s k.h5 new.h5.part
if "$fault" -fault_nx 2 -fault_nz 2 -fault_output new.h5 >out.txt 2>err.txt; then fail "FILE.part was a link"; fi
grep -qF "new.h5.part" err.txt || fail "FILE.part is a link: $(cat err.txt)"
rm new.h5.part
mkdir far && ln -s far/out.h5 near.h5
"$fault" -fault_nx 2 -fault_nz 2 -ts_max_time 1 -fault_output near.h5 >out.txt 2>err.txt || fail "a link to a new file: $(cat err.txt)"
[ -L near.h5 ] && [ -f far/out.h5 ] || fail "a link was not followed"

# On two ranks as well: the message once, an error code, no hang, nothing written.
for option in "-fault_nx 0" "-fault_stiffness_file none.h5" "-fault_output no/such/directory/x.h5" \
  "${mesh[*]} -fault_stiffness_file k.h5:/asymmetric" "${mesh[*]} -fault_parameters stress_nan.h5" "${mesh[*]} -ts_dt 0" \
  "${mesh[*]} -ts_bathe_reaction velcro" "${rl[*]} -ts_adapt_rl_policy p_truncated.h5" \
  "${rl[*]} -ts_adapt_rl_policy p_names.h5" \
  "${rl[*]} -ts_adapt_rl_policy $other" "-fault_sweep empty.txt" "-fault_mesh none.h5" "-fault_mesh overlap.h5" "-fault_mesh mesh.h5 -fault_parameters stress_list.h5" \
  "-fault_mesh mesh.h5 -fault_viscosity spectral" "-fault_mesh mesh.h5 -fault_operator fft"; do
  read -r -a args <<<"$option"
  refuses "fault: error: " -- mpirun --oversubscribe -n 2 "$fault" "${args[@]}"
  cmp -s old.h5 reference || fail "$option on two ranks: old.h5 was touched"
done

# A second run with the output of one that is writing is refused, and does the first no harm. The
# first waits while the second starts.
rm -f old.h5
"$fault" -fault_nx 10 -fault_nz 10 -ts_adapt_type none -ts_bathe_error none -ts_dt 5e-3 -fault_output_fields slip -fault_output old.h5 \
  >first.txt 2>&1 &
first=$!
until [ -e old.h5.part ] || ! kill -0 $first 2>/dev/null; do sleep 0.05; done
sleep 0.1 # it takes hold of the file as it makes it
kill -STOP $first
if timeout $hang "$fault" -fault_nx 2 -fault_nz 2 -fault_output old.h5 >out.txt 2>err.txt; then fail "two runs with one output"; fi
grep -q "fault: error: .*old.h5.part.*-fault_output" err.txt ||
  fail "two runs with one output: $(cat err.txt)"
kill -CONT $first
wait $first || fail "the first of two runs with one output: $(cat first.txt)"
"$SLIPSTEP_PYTHON" - <<'PY' || fail "the first of two runs with one output has lost data"
import h5py
import numpy as np
with h5py.File("old.h5") as f:
    time = f["series/time"][:]
    assert len(time) == 6001 and time[0] == 0 and np.allclose(np.diff(time), 5e-3), time
    assert np.all(f["series/mean_slip"][1:] > 0) and np.all(f["fields/slip"][1:] > 0)
PY

# More ranks than cells: either the run of one rank, or one clear error.
"$fault" -fault_nx 2 -fault_nz 1 -ts_max_time 2 >one.txt 2>err.txt || failed=1
for storage in "-fault_operator auto" "-fault_operator fft" "-fault_operator hmat -fault_viscosity lanczos"; do
  read -r -a args <<<"$storage"
  timeout $hang mpirun --oversubscribe -n 4 "$fault" -fault_nx 2 -fault_nz 1 -ts_max_time 2 "${args[@]}" >out.txt 2>err.txt
  code=$?
  if [ $code = 0 ]; then
    # seven digits
    paste <(grep "final mean slip" one.txt) <(grep "final mean slip" out.txt) |
      awk '{d = $4 - $9; exit !($4 > 0 && (d < 0 ? -d : d) <= 2e-6 * $4)}' ||
      fail "$storage on 4 ranks for 2 cells: another slip"
  elif [ $code = 124 ] || [ "$(grep -c "fault: error: 4 .* 2 " err.txt)" != 1 ]; then
    fail "$storage on 4 ranks for 2 cells: exit code $code, $(cat err.txt)"
  fi
done

# Options that a mesh makes idle are named.
"$fault" -fault_mesh mesh.h5 -fault_nx 3 -ts_max_time 0.1 >out.txt 2>err.txt || failed=1
grep -q "fault: warning: -fault_nx .*-fault_mesh mesh.h5" err.txt ||
  fail "-fault_nx beside -fault_mesh"

# No state of rate and state follows from a traction of 0.
refuses "-fault_initial_traction" "4 of 4 cells" -- "$fault" -fault_nx 2 -fault_nz 2 -fault_friction_law rate_and_state -fault_loading_rate 1e-9 \
  -fault_initial traction -ts_max_time 1y

# A strength that falls with rate faster than viscosity grows leaves no slip rate without inertia.
refuses "-fault_inertia no" "rate_weakening" -- "$fault" -fault_inertia no -fault_viscosity radiation \
  -fault_friction_law rate_weakening -fault_friction_rate 1e-3

# More ranks than cells.
refuses "5 processes" "4 cells" -- mpirun --oversubscribe -n 5 "$fault" -fault_mesh mesh.h5

exit $failed
