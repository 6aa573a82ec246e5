#!/usr/bin/env bash
# -fault_checkpoint and -fault_restart: runs that are killed or stopped become the unbroken ones (few moments here,
# kills.py by hand does many), on other numbers of ranks to rounding; a longer -ts_max_time lengthens a run; checkpoints
# of other runs, damaged ones and other files are refused; signals and -fault_wall_limit have their exit codes.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
"$SLIPSTEP_PYTHON" -c 'import h5py, numpy' || exit 77
export TMPDIR=$work
fault=$bin/fault
here=$SLIPSTEP_SOURCE/tests/integration
grid=(-fault_nx 6 -fault_nz 5)

for which in "KILL heuristic" "KILL rl" "KILL fft" "KILL loaded" "TERM dsp" "TERM grid on 2"; do
  "$SLIPSTEP_PYTHON" "$here/kills.py" "$SLIPSTEP_BUILD" --moments 1 --signal "${which%% *}" --only "${which#* }" ||
    fail "$which"
done

# same A B TOLERANCE: two outputs
same() {
  "$SLIPSTEP_PYTHON" - "$@" <<'P'
import sys
import h5py
import numpy as np
a, b = h5py.File(sys.argv[1]), h5py.File(sys.argv[2])
for name in ("steps/time", "series/time", "series/mean_slip", "series/viscous_power", "fields/slip_rate", "fields/traction"):
    x, y = a[name][...], b[name][...]
    assert x.shape == y.shape and abs(x - y).max() <= float(sys.argv[3]) * abs(x).max(), name
P
}

# ---- on another number of ranks, and longer ----
"$SLIPSTEP_PYTHON" "$SLIPSTEP_SOURCE/examples/make_mesh.py" mesh parallel --cells 5 5 --ratio 2 >/dev/null || fail "a mesh"
mesh=(-fault_mesh mesh)
for kind in grid mesh; do
  declare -n options=$kind
  "$fault" "${options[@]}" -ts_max_time 4 -fault_output "$kind.h5" >/dev/null || fail "$kind"
  "$fault" "${options[@]}" -ts_max_time 4 -ts_max_steps 9 -fault_output part.h5 -fault_checkpoint "$kind.state" >/dev/null
  [ $? = 3 ] || fail "$kind, nine steps"
  mpirun --oversubscribe -n 2 "$fault" "${options[@]}" -ts_max_time 4 -fault_restart "$kind.state" -fault_output part.h5 \
    >/dev/null || fail "$kind on 2 ranks"
  same "$kind.h5" part.h5 1e-10 || fail "$kind on 2 ranks: another run"
  rm -f part.h5
done
run=("$fault" "${grid[@]}" -ts_max_time 4)
"${run[@]}" -fault_checkpoint end.state -fault_output long.h5 >/dev/null || fail "a run to its end"
"${run[@]}" -ts_max_time 6 -fault_restart end.state -fault_output long.h5 >/dev/null || fail "a longer run"
"$SLIPSTEP_PYTHON" - <<'P' || fail "a run was not lengthened"
import h5py
with h5py.File("grid.h5") as a, h5py.File("long.h5") as b:
    n = len(a["series/time"])
    assert b["series/time"][-1] == 6 and (a["series/time"][...] == b["series/time"][:n]).all()
    assert b["run"].attrs["restarts"] == 1
P

# ---- behind links: the state, the one before it and the output are where the links point ----
mkdir scratch
ln -s scratch/there.state link.state
ln -s scratch/there.h5 link.h5
linked=("${run[@]}" -fault_output link.h5)
"${linked[@]}" -ts_max_steps 5 -fault_checkpoint link.state >/dev/null 2>err.txt
[ $? = 3 ] && [ -f scratch/there.state ] && [ -L link.state ] && [ -f scratch/there.h5 ] || fail "a checkpoint behind a link: $(cat err.txt)"
"${linked[@]}" -fault_restart link.state -fault_checkpoint link.state >/dev/null || fail "a restart behind links"
[ -f scratch/there.state.previous ] && [ -L link.h5 ] || fail "links were replaced: $(ls -l . scratch)"
same grid.h5 scratch/there.h5 0 || fail "another run behind links"
echo damaged >scratch/there.state
"${run[@]}" -ts_max_time 5 -fault_restart link.state >/dev/null 2>err.txt || fail "$(cat err.txt)"
grep -q "scratch/there.state.previous is used" err.txt || fail "no file before: $(cat err.txt)"

# ---- the step ----
"${run[@]}" -ts_max_time 5 -ts_dt 1e-3 -fault_restart end.state -fault_output '' >out.txt 2>/dev/null
"${run[@]}" -ts_max_time 5 -ts_dt 1e-3 -fault_restart end.state >out.txt || fail "-ts_dt beside a restart"
grep -q "the step of its checkpoint, .* s, and not that of -ts_dt: -fault_restart_dt" out.txt || fail "$(cat out.txt)"
"${run[@]}" -ts_max_time 5 -fault_restart_dt 1e-3 -fault_restart end.state -fault_output dt.h5 >/dev/null || fail "dt"
"$SLIPSTEP_PYTHON" -c 'import h5py; assert h5py.File("dt.h5")["steps/dt"][0] == 1e-3' || fail "-fault_restart_dt"

# ---- without a step to take nothing is written, and an end before the checkpoint is refused ----
"${run[@]}" -ts_max_time 3 -fault_catalogue idle_events.h5 -fault_output idle.h5 -fault_checkpoint idle.state >/dev/null || fail "a run to 3 s"
idle=("${run[@]}" -fault_catalogue idle_events.h5 -fault_output idle.h5 -fault_checkpoint idle.state -fault_restart idle.state)
"${idle[@]}" -ts_max_time 31 >/dev/null || fail "a run to 31 s"
sums=$(cksum idle*)
for end in "0:31:final time of 31 s (-ts_max_time): nothing is left to do" "3:40 -ts_max_steps 0:-ts_max_steps is 0: no step is left" \
  "3:40 -ts_max_steps 5:-ts_max_steps is 5: no step is left" "0:31 -ts_exact_final_time stepover -fault_check_error:nothing is written"; do
  IFS=: read -r expected options words <<<"$end"
  code=0
  timeout $hang "${idle[@]}" -ts_max_time $options >out.txt 2>err.txt || code=$?
  [ $code = "$expected" ] && grep -qF -e "-fault_restart idle.state is at" out.txt && grep -qF -e "$words" out.txt || fail "no step, $options: $code $(cat out.txt err.txt)"
  [ "$(cksum idle*)" = "$sums" ] || fail "no step, $options, and yet files were written: $(cksum idle*)"
done
refuses "idle.state is at time 31 s" " 2 s (-ts_max_time)" -- "${idle[@]}" -ts_max_time 2
refuses "idle.state is at time 31 s" " 30 s (-ts_max_time, which" -- \
  "$fault" "${grid[@]}" -fault_restart idle.state -fault_checkpoint idle.state
[ "$(cksum idle*)" = "$sums" ] || fail "runs that were refused wrote: $(cksum idle*)"
# A last step beyond the end, and a wall limit that leaves time for one step alone
over=("${run[@]}" -ts_exact_final_time stepover -fault_checkpoint over.state)
"${over[@]}" -ts_max_time 3 >/dev/null || fail "stepover"
sums=$(cksum over*)
"${over[@]}" -ts_max_time 3 -fault_restart over.state >out.txt && grep -q "final time of 3 s .*nothing" out.txt || fail "stepover again: $(cat out.txt)"
[ "$(cksum over*)" = "$sums" ] || fail "stepover again wrote: $(cksum over*)"
code=0
"${over[@]}" -ts_max_time 4 -fault_wall_limit 1e-3 -fault_restart over.state -fault_output over.h5 >/dev/null 2>&1 || code=$?
[ $code = 152 ] && "${over[@]}" -ts_max_time 4 -fault_restart over.state -fault_output over.h5 >/dev/null || fail "one step: exit code $code"
# No step from the start: there is no state to keep
"${run[@]}" -ts_max_steps 0 -fault_checkpoint none.state >/dev/null
[ $? = 3 ] && [ ! -e none.state ] || fail "a checkpoint without a step"

# ---- a run that fails by its steps ends with a checkpoint, and goes on by other steps ----
years=(-fault_friction_law rate_and_state -fault_friction_slip 0.05 -fault_loading_rate 1e-9 -fault_normal_stress 5e7 -fault_normal_stress_gradient 0)
for kind in "a constant step of .* is no state:${years[*]} -ts_max_time 200y -ts_adapt_type none -ts_dt 5y" \
  "below -ts_adapt_dt_min:-ts_max_time 30 -ts_adapt_type heuristic -ts_adapt_dt_min 2e-2 -ts_rtol 1e-5" \
  "DIVERGED_STEP_REJECTED:-ts_max_time 30 -ts_adapt_type heuristic -ts_max_reject 0"; do
  rm -f fails.*
  words=(${kind#*:})
  code=0
  timeout $hang "$fault" -fault_nx 4 -fault_nz 4 "${words[@]}" -fault_checkpoint fails.state -fault_output fails.h5 >out.txt 2>err.txt || code=$?
  [ $code = 1 ] && [ -e fails.state ] && [ -e fails.h5.part ] && grep -q "error: At time .*${kind%%:*}" err.txt &&
    grep -q "warning: steps fail at time .* -fault_restart_dt: .* -fault_restart fails.state" err.txt || fail "${kind%%:*}: exit code $code, $(ls), $(cat err.txt)"
  more=(-ts_adapt_type heuristic -ts_adapt_dt_min 1e-20 -ts_max_reject -1 -ts_rtol 1e-3 -fault_restart fails.state)
  if [[ $kind = *constant* ]]; then # which have left a state that no shorter steps mend
    code=0
    "$fault" -fault_nx 4 -fault_nz 4 "${words[@]}" "${more[@]}" -fault_checkpoint again.state >out.txt 2>err.txt || code=$?
    [ $code = 1 ] && [ ! -e again.state ] && grep -q "error: At time .* below the rounding of that time" err.txt || fail "shorter steps: $(cat err.txt)"
    continue
  fi
  "$fault" -fault_nx 4 -fault_nz 4 "${words[@]}" "${more[@]}" -fault_restart_dt 1e-2 -fault_output fails.h5 >/dev/null 2>err.txt ||
    fail "${kind%%:*}, on with other steps: $(cat err.txt)"
  "$fault" -fault_nx 4 -fault_nz 4 "${words[@]}" "${more[@]:0:8}" -fault_output fine.h5 >/dev/null 2>&1 || fail "${kind%%:*}: another tolerance"
  "$SLIPSTEP_PYTHON" - <<'P' || fail "${kind%%:*}: another end"
import h5py
with h5py.File("fails.h5") as a, h5py.File("fine.h5") as b:
    assert a["series/time"][-1] == b["series/time"][-1] and (a["steps/time"][1:] >= a["steps/time"][:-1]).all()
    x, y = a["series/mean_slip"][-1], b["series/mean_slip"][-1]
    assert abs(x - y) < 0.02 * y, (x, y)  # each off by its tolerance; a step of the failed attempt counted twice is off by more
P
done

# ---- refused ----
other=(-fault_restart grid.state)
refuses "-fault_restart grid.state" "friction_drop is 0.2, was 0.1" -- "${run[@]}" -fault_friction_drop 0.2 "${other[@]}"
refuses "nx is 7, was 6" "length_x is 2000 m, was 3000 m" -- "${run[@]}" -fault_nx 7 -fault_length_x 2000 "${other[@]}"
refuses "operator is" "was dense" -- "${run[@]}" -fault_operator fft "${other[@]}"
refuses "normal_stress is 5500000 to 41500000" 23500000 -- "${run[@]}" -fault_normal_stress 1e6 -fault_normal_stress_gradient 15e3 "${other[@]}"
refuses "mesh is of 50 cells" -- "$fault" -fault_mesh mesh "${other[@]}"
refuses "friction_law is constant" exponential_slip_weakening -- "${run[@]}" -fault_friction_law constant "${other[@]}"
refuses "missing.h5" "-fault_restart" -- "${run[@]}" -fault_restart missing.h5
refuses "mesh" "no checkpoint" "-fault_restart" -- "${run[@]}" -fault_restart mesh
refuses "-fault_restart grid.state" "-fault_output_overwrite" -- \
  "${run[@]}" -fault_checkpoint grid.state
refuses "grid.h5" "no checkpoint" "-fault_checkpoint" -- "${run[@]}" -fault_checkpoint grid.h5
refuses "no/c.h5" "-fault_checkpoint" -- "${run[@]}" -fault_checkpoint no/c.h5
refuses "dt.h5" -- "${run[@]}" "${other[@]}" -ts_max_time 5 -fault_output dt.h5

# The entries of a stiffness file, whatever it is called; on other ranks they are the same.
"$SLIPSTEP_PYTHON" - <<'P'
import h5py
import numpy as np
distance = np.abs(np.subtract.outer(np.arange(4), np.arange(4)))
for name, factor in (("one.h5", 1), ("same.h5", 1), ("twice.h5", 2)):
    with h5py.File(name, "w") as file:
        file["stiffness"] = factor * np.where(distance, -1e6 / (1 + distance ** 2), 1e7)
for name, turn in (("field.h5", 1), ("turned.h5", -1)):
    with h5py.File(name, "w") as file:
        file["friction_a"] = np.array([[0.01, 0.011], [0.012, 0.013]])[::turn]
# a checkpoint of an older version of the format
good = open("grid.state", "rb").read()
open("older.state", "wb").write(good.replace(b"slipstep-checkpoint 11\n", b"slipstep-checkpoint 10\n", 1))
P
file=("$fault" -fault_nx 2 -fault_nz 2 -fault_viscosity none -ts_max_time 4)
"${file[@]}" -fault_stiffness_file one.h5 -ts_max_steps 5 -fault_checkpoint file.state >/dev/null
[ $? = 3 ] || fail "a stiffness file"
mpirun --oversubscribe -n 2 "${file[@]}" -fault_stiffness_file same.h5 -fault_restart file.state >/dev/null 2>err.txt ||
  fail "a copy of the stiffness file on 2 ranks: $(cat err.txt)"
refuses "file.state" "stiffness is of 4 x 4" -- "${file[@]}" -fault_stiffness_file twice.h5 -fault_restart file.state
refuses "file.state" "stiffness is no" -- "${file[@]}" -fault_restart file.state
# What the law has chosen may be given, and a number be written in another way; a field whose cells changed places is another.
smooth=("$fault" -fault_nx 2 -fault_nz 2 "${years[@]}" -ts_max_time 200y)
"${smooth[@]}" -fault_parameters field.h5 -ts_rtol 1e-3 -ts_max_steps 5 -fault_checkpoint smooth.state >/dev/null
[ $? = 3 ] || fail "a field"
"${smooth[@]}" -fault_parameters field.h5 -ts_rtol 0.001 -fault_inertia no -ts_max_steps 6 -fault_restart smooth.state >out.txt 2>err.txt
[ $? = 3 ] && ! grep -q "goes on with other" err.txt || fail "the same by other words: $(cat err.txt)"
refuses "smooth.state" "friction_a is 0.01 to 0.013" -- "${smooth[@]}" -fault_parameters turned.h5 -ts_rtol 1e-3 -fault_restart smooth.state
refuses "older.state" 11 -- "${run[@]}" -fault_restart older.state

# ---- one name for two files, links and what the run makes of names included: refused before anything is written ----
ln -s grid.state soft.state
ln grid.state hard.state
sum=$(cksum <grid.state)
for pair in "-fault_catalogue grid.state" "-fault_output ./grid.state" "-fault_catalogue soft.state" "-fault_output hard.state" \
  "-fault_output grid.state.previous"; do
  refuses "-fault_restart grid.state" "${pair% *}" -- "${run[@]}" "${other[@]}" $pair
done
refuses "-fault_output x.h5" "-fault_catalogue x.h5.xdmf2" -- "${run[@]}" -fault_output x.h5 -fault_catalogue x.h5.xdmf2
refuses "-fault_output x.state.previous" "-fault_checkpoint x.state" -- "${run[@]}" -fault_output x.state.previous -fault_checkpoint x.state
refuses "-fault_output x.h5" "-fault_checkpoint scratch/../x.h5.part" -- "${run[@]}" -fault_output x.h5 -fault_checkpoint scratch/../x.h5.part
refuses "-fault_output x.h5" "-fault_stiffness_view x.h5" -- "${run[@]}" -fault_output x.h5 -fault_stiffness_view binary:x.h5
refuses "-fault_parameters one.h5" "-fault_checkpoint one.h5" -- "${run[@]}" -fault_parameters one.h5 -fault_checkpoint one.h5
[ "$(cksum <grid.state)" = "$sum" ] && [ ! -e x.h5 ] || fail "a run with one name for two files wrote one"

# ---- a damaged catalogue at a restart is refused within seconds ----
events=("$fault" -fault_nx 1 -fault_nz 1 -fault_loading_rate 1e-9 -fault_initial rest -fault_friction_law rate_weakening)
"${events[@]}" -ts_max_time 2e9 -fault_catalogue events.h5 -fault_checkpoint events.state >/dev/null || fail "a catalogue"
"$SLIPSTEP_PYTHON" - <<'P'
content = bytearray(open("events.h5", "rb").read())
place = content.find(b"EAIB")  # the first index block of a column
content[place + 20] ^= 1
open("damaged.h5", "wb").write(content)
P
refuses "damaged.h5" "-fault_catalogue" -- "${events[@]}" -ts_max_time 4e9 -fault_catalogue damaged.h5 -fault_restart events.state

# Every bit counts; the file before is taken instead.
"$SLIPSTEP_PYTHON" - <<'P'
import random
good = open("grid.state", "rb").read()
chance = random.Random(3)
places = [0, 20, 40, 100, 511, 512, 600, len(good) - 1] + [chance.randrange(len(good)) for _ in range(4)]
for k, place in enumerate(places):
    bad = bytearray(good)
    bad[place] ^= 1 << chance.randrange(8)
    open(f"flipped{k}", "wb").write(bad)
open("flipped12", "wb").write(good[:-100])
open("flipped13", "wb").write(good + b"\0")
open("flipped14", "wb").write(b"")
P
for k in $(seq 0 14); do
  refuses "flipped$k" -- "${run[@]}" -fault_restart "flipped$k"
done
cp grid.state flipped9.previous
"${run[@]}" -fault_restart flipped9 -fault_output again.h5 >/dev/null 2>err.txt || fail "the file before"
[ "$(grep -c "warning: cannot continue from flipped9: it is damaged.*flipped9.previous is used" err.txt)" = 1 ] || fail "$(cat err.txt)"
[ "$(grep -c "flipped9" err.txt)" = 1 ] || fail "more than one warning: $(cat err.txt)"

# ---- stopped ----
# the limit bounds what no signal reaches, by another exit code
slow=("${grid[@]}" -ts_adapt_type none -ts_dt 1e-5 -fault_checkpoint_interval 0.1 -fault_wall_limit 100)
# stops SIGNAL CODE -- command; after its first checkpoint
stops() {
  local signal=$1 expected=$2 code=0
  shift 3
  "$@" >out.txt 2>err.txt &
  until [ -e "a b.state" ] || ! kill -0 $! 2>/dev/null; do sleep 0.05; done
  kill -"$signal" $! || fail "it ended by itself: $(cat err.txt)"
  wait $! || code=$?
  [ $code = "$expected" ] || fail "exit code $code after SIG$signal, expected $expected: $(cat err.txt)"
  grep -q "stopped by SIG$signal at time .* steps; to continue: .*fault .*-fault_restart 'a b.state'" err.txt || fail "$(cat err.txt)"
}
for pair in TERM:143 INT:130 USR1:138 XCPU:152; do
  rm -f "a b.state"*
  stops "${pair%:*}" "${pair#*:}" -- "$fault" "${slow[@]}" -fault_output "o.h5" -fault_checkpoint "a b.state" -fault_output_overwrite
  [ -e o.h5.part ] && [ ! -e o.h5 ] || fail "the output of a run that was stopped: $(ls)"
done
rm -f "a b.state"*
stops USR1 138 -- mpirun --oversubscribe -n 2 "$fault" "${slow[@]}" -fault_checkpoint "a b.state"
grep -q "to continue: mpirun -n 2 " err.txt || fail "$(cat err.txt)"
# a file, which needs no launcher; the command that goes on removes it, and without that it is refused
rm -f "a b.state"*
stop=("${slow[@]}" -fault_checkpoint "a b.state" -fault_stop_file "s top")
code=0
mpirun --oversubscribe -n 2 "$fault" "${stop[@]}" -fault_output stopped.h5 >out.txt 2>err.txt &
until [ -e "a b.state" ] || ! kill -0 $! 2>/dev/null; do sleep 0.05; done
touch "s top"
wait $! || code=$?
[ $code = 138 ] && [ -e stopped.h5.part ] && [ ! -e stopped.h5 ] || fail "exit code $code after the file of -fault_stop_file: $(cat err.txt)"
grep -q "stopped by the file s top (-fault_stop_file) at time .* steps; to continue: rm 's top' && mpirun -n 2 .*fault .*-fault_restart 'a b.state'" err.txt || fail "$(cat err.txt)"
command=$(sed -n 's/.*to continue: //p' err.txt)
rm -f ./*.part
refuses "s top" "-fault_stop_file" -- "$fault" "${stop[@]}" -fault_restart "a b.state"
code=0
eval "timeout $hang $command -fault_wall_limit 2" >out.txt 2>&1 || code=$?
[ $code = 152 ] && grep -q "continues from a b.state" out.txt || fail "\"$command\": exit code $code, $(cat out.txt)"
[ "$(sed -n 's/.*to continue: //p' out.txt | grep -o 'a b.state' | wc -l)" = 2 ] || fail "not one -fault_checkpoint and one -fault_restart: $(cat out.txt)"
rm -f ./*.part
refuses "same.h5" "fault_stop_file" -- "$fault" "${slow[@]}" -fault_stop_file same.h5 -fault_output same.h5
code=0
"$fault" "${slow[@]}" -fault_wall_limit 3 -fault_checkpoint limit.state >/dev/null 2>err.txt || code=$?
[ $code = 152 ] && grep -q "stopped by the wall limit of 3 s" err.txt || fail "wall limit: exit code $code, $(cat err.txt)"
command=$(sed -n 's/.*to continue: //p' err.txt)
code=0
eval "timeout $hang $command -fault_wall_limit 1e-3" >out.txt 2>&1 || code=$?
[ $code = 152 ] && grep -q "continues from limit.state" out.txt || fail "\"$command\": exit code $code, $(cat out.txt)"
exit $failed
