#!/bin/bash
# What a program does not know, and numbers without sense, are errors before the run, with the name and what was meant;
# options that do nothing are named before it. What a run has used and why it ended is in -fault_view, the summary and
# the exit code.
set -u
fault=$SLIPSTEP_BUILD/bin/fault
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"

"$SLIPSTEP_PYTHON" - <<'PY' || exit 77
import h5py
import numpy as np
stress = np.array([[1e6, 2e6], [3e6, 6e6]])


def write(name, attributes=None, units=None, **datasets):
    with h5py.File(name, "w") as f:
        for path, data in datasets.items():
            f[path] = data
            if units:
                f[path].attrs["units"] = units
            f[path].attrs.update(attributes or {})


write("fields.h5", normal_stress=stress)
write("fields_pa.h5", units="Pa", normal_stress=stress)
write("fields_mpa.h5", units="MPa", normal_stress=stress / 1e6)
write("k_km.h5", units="1/km", stiffness=np.eye(4) * 3e7)
write("misspelt.h5", normal_stress=stress, normal_stres=stress)
write("pressure.h5", normal_stress=stress, pore_pressure=stress)
write("density.h5", normal_stress=stress, density=stress)
with h5py.File("group.h5", "w") as f:
    f["normal_stress"] = stress
    f["more/friction_drop"] = stress
cells = np.array([[50, 0, 50, 100, 100], [150, 0, 50, 100, 100], [50, 200, 60, 100, 100], [150, 200, 60, 100, 100.0]])
columns = {"columns": "x y z length width"}
write("cells.h5", columns, cells=cells)
write("cells_m.h5", columns, "m", cells=cells / 1e3)
write("cells_km.h5", columns, cells=cells / 1e3)
write("cells_said_km.h5", columns, "km", cells=cells / 1e3)
deep = cells.copy()
deep[3, 2] = 1e30
write("cells_deep.h5", columns, cells=deep)
far = cells.copy()
far[3, 0] = 5e7
write("cells_far.h5", columns, cells=far)
write("cells_attribute.h5", {"colums": "x y z length width"}, cells=cells)
write("cells_more.h5", columns, cells=cells, friction=cells[:, 0])
PY

mesh() { refuses "$1" -- "$fault" -ts_max_time 0.1 -fault_mesh "${@:2}"; } # MESSAGE FILE
tiny=(-fault_nx 2 -fault_nz 2 -ts_max_time 1)
expect() { # WORD|WORD... OPTION...
  local words
  IFS='|' read -ra words <<<"$1"
  refuses "${words[@]}" -- "$fault" "${tiny[@]}" -fault_output run.h5 "${@:2}"
}

# Options and words.
expect "-fault_length_x?" -fault_lenght_x 3
expect "-fault_kernel?" -FAULT_kernal full_space
expect "-fault_bogus" -fault_bogus
refuses_hint() { # OPTION: unknown, and near to nothing
  "$fault" "${tiny[@]}" "$1" 60 >out.txt 2>err.txt && fail "no error with $1"
  grep -qF -e "$1" err.txt && ! grep -q "?" err.txt || fail "$1, or a hint at another option: $(cat err.txt)"
}
for option in -fault_wqj -fault_ab -fault_initial_foo -ts_bathe_x; do refuses_hint $option; done
expect "-fault_output_time_interval?" -fault_output_time_intervall 1
expect "-ts_adams_max_order?" -ts_adams_max_ordr 3
expect "-ts_bathe_gamma?" -ts_bathe_gama 0.5
expect "-ts_adapt_rl_accuracy?" -ts_adapt_rl_acuracy 1e-3
expect "-mat_slipsqrtm_setup?" -mat_slipsqrtm_setupp auto
expect "-fault_nz?" -fualt_nz 3
expect "-ts_max_time?" -ts_max_tmie 5
expect "-ts_adapt_type?" -ts_adaptt_type pi
expect "-snes_type?" -snes_typ semismooth
expect "-ksp_type?" -ksp_tpye cg
expect "--fault_nx" --fault_nx 3
expect "-fault_nx=3" -fault_nx=3
expect "–fault_nx| -fault_nx" –fault_nx 3
expect "–fault_nx| -fault_nx" -fault_view –fault_nx 3
expect "-fault_nx?" fault_nx 3
expect "error: 3 " -fault_length_x 3 3
printf -- '-fault_nz=4\n' >equals.opts
expect "-fault_nz=4" -options_file equals.opts
printf -- '-fault_nx 2 fault_nz 2\n' >words.txt
refuses "fault_nz (-fault_sweep)" -- "$fault" -fault_sweep words.txt
printf -- '-fault_nx 2 -fault_nzz 2\n' >names.txt
refuses "-fault_nzz" -- "$fault" -fault_sweep names.txt
# Two lines that write one file: refused before the first runs, unless the second goes on where the first has ended
ln -s sweep_b.h5 sweep_link.h5
two=("$fault" -fault_nx 2 -fault_nz 2 -ts_max_time 1)
for pair in "-fault_output sweep_a.h5:-fault_output ./sweep_a.h5" "-fault_catalogue sweep_link.h5:-fault_output sweep_b.h5" \
  "-fault_checkpoint sweep_a.h5.xdmf2:-fault_output sweep_a.h5" "-fault_view ascii:sweep_a.h5:-fault_stiffness_view binary:sweep_a.h5"; do
  printf "%s\n" "# first" "${pair%%:-*}" "" "-ts_max_time 2 -${pair#*:-}" >one_file.txt
  refuses "line 2 of -fault_sweep: ${pair%% *}" "line 4 of -fault_sweep: " -- "${two[@]}" -fault_sweep one_file.txt
done
refuses "line 2 of -fault_sweep: -fault_output sweep_a.h5" "line 4" -- "${two[@]}" -fault_output sweep_a.h5 -fault_sweep one_file.txt
[ -z "$(ls sweep_[ab]* 2>/dev/null)" ] || fail "a sweep that was refused wrote $(ls sweep_*)"
printf "%s\n" "-fault_checkpoint sweep.state" "-ts_max_time 2 -fault_restart sweep.state -fault_checkpoint sweep.state" >goes_on.txt
"${two[@]}" -fault_output sweep_a.h5 -fault_sweep goes_on.txt >out.txt 2>err.txt || fail "a sweep that goes on: $(cat err.txt)"
rm -f sweep*
PETSC_OPTIONS="-fault_densty 3" expect "-fault_density?"
echo "-ts_max_steps 36893488147419103236" >large.txt
refuses "-ts_max_steps is 36893488147419103236" -- "$fault" "${tiny[@]}" -options_file large.txt
PETSC_OPTIONS="-ts_max_steps 36893488147419103236" refuses "-ts_max_steps is 36893488147419103236" -- "$bin/circuit"
refuses "-train_seed is 36893488147419103236" -- "$bin/train" -train_seed 1,36893488147419103236
refuses "-circuit_c3" -- "$bin/circuit" -circuit_c3 1
refuses "-sliding_mode_gain?" -- "$bin/sliding_mode" -sliding_mode_gian 2
refuses "-oscillator_mass?" -- "$bin/oscillator" -oscillator_mas 2
refuses "-train_steps?" -- "$bin/train" -train_stpes 2
refuses "-evaluate_meshes?" -- "$bin/evaluate" -evaluate_mehes 2
refuses "error: steps " -- "$bin/train" steps 2
refuses "-fault_lenght_x" -- mpirun --oversubscribe -n 2 "$fault" "${tiny[@]}" -fault_lenght_x 3

# What nothing reads is named before the run, once; what PETSc reads later, and what is read, is not.
warns() { # WARNING OPTION...: once, and before an error at the first step
  "$fault" "${tiny[@]}" "${@:2}" -fault_output no/run.h5 >out.txt 2>err.txt && fail "no error with $*"
  [ "$(grep -c "fault: warning: .*$1" err.txt)" = 1 ] || fail "no warning \"$1\": $(cat err.txt)"
  grep -q "accepted steps" out.txt && fail "$1 after the run"
  "$fault" "${tiny[@]}" "${@:2}" >out.txt 2>err.txt || fail "$*: $(cat err.txt)"
  [ "$(grep -c "fault: warning: .*$1" err.txt)" = 1 ] || fail "not one warning \"$1\": $(cat err.txt)"
}
warns "-ts_adapt_rl_accuracy" -ts_adapt_type pi -ts_adapt_rl_accuracy 1e-3
warns "-pc_factor_levels" -pc_factor_levels 1
warns "-train_steps" -train_steps 3
# PETSc's own, near to others that are known here, but not ours to refuse
warns "-dm_type" -dm_type da
"$fault" "${tiny[@]}" -ts_bathe_method implicit -log_view :log.txt -snes_view :view.txt -snes_converged_reason :view.txt -ts_view :view.txt -ksp_rtol 1e-6 \
  -ts_adapt_type rl -ts_adapt_rl_accuracy 1e-3 -mat_slipstage_jacobian exact -pc_type jacobi -citations :cite.txt -fault_view \
  -fault_start_ksp_type cg -fault_stiffness_average whole >out.txt 2>err.txt || fail "options that are read: $(cat err.txt)"
[ ! -s err.txt ] || fail "options that are read: $(cat err.txt)"

# Options before a file lose to it, and are named with both values; those behind it, and equal ones, are not.
printf -- '-fault_nx 4\n-fault_view\n' >four.opts
run_four() { "$fault" "$@" -fault_nz 2 -ts_max_time 0.1 >out.txt 2>err.txt || fail "$*: $(cat err.txt)"; }
run_four -fault_nx 2 -options_file four.opts
grep -q "fault: warning: -fault_nx 2 .*-options_file.* -fault_nx 4" err.txt || fail "a lost option: $(cat err.txt)"
for words in "-fault_nx 4 -options_file four.opts" "-options_file four.opts -fault_nx 2" "-fault_nx 2 -options_file four.opts -fault_nx 2"; do
  read -r -a words <<<"$words"
  run_four "${words[@]}"
  grep -q "warning: .*-options_file" err.txt && fail "${words[*]}: $(cat err.txt)"
done

# A healthy run of years computes no number that nobody uses.
"$fault" -fault_nx 20 -fault_nz 10 -fault_length_x 20000 -fault_length_z 10000 -fault_friction_law rate_and_state -fault_normal_stress 50e6 \
  -fault_normal_stress_gradient 0 -fault_loading_rate 1e-9 -fault_friction_slip 0.02 -fault_friction_b 0.02 -ts_max_time 30y -fp_trap >out.txt 2>err.txt ||
  fail "-fp_trap: $(cat err.txt)"

# Constant steps that cannot be taken: explicit ones end the run, implicit ones become shorter and grow back, and it is said.
smooth=(-fault_nx 6 -fault_nz 4 -fault_length_x 6000 -fault_length_z 4000 -fault_friction_law rate_and_state -fault_normal_stress 50e6
  -fault_normal_stress_gradient 0 -fault_loading_rate 1e-9 -fault_friction_slip 0.02 -fault_friction_b 0.02 -fault_initial_rate 3e-9)
for type in adams rk; do
  refuses "8.64e+06 s" "-ts_type $type" -- \
    "$fault" "${smooth[@]}" -ts_max_time 60y -ts_type $type -ts_adapt_type none "$dt" 100d
done

# Files of options that cannot be read: one line, and nothing of PETSc's.
printf -- '-options_file no.opts\n' >nested.opts
for file in no.opts nested.opts; do
  refuses "no.opts" -- "$fault" -options_file $file
  [ "$(wc -l <err.txt)" = 1 ] || fail "more than a line: $(cat err.txt)"
done
"$fault" -options_file no.opts 2>err.txt
[ $? = 1 ] || fail "the exit code of a missing -options_file: $(cat err.txt)"

# Versions and help.
for program in "$bin"/*; do
  for option in -version --version -slipstep_version; do
    "$program" $option >out.txt 2>err.txt || fail "$program $option: $(cat err.txt)"
    for name in "SlipStep [0-9]+\.[0-9]+\.[0-9]+$" "^PETSc [0-9.]+$" "^MPI: ." "^HDF5 [0-9.]+$"; do
      grep -qE "$name" out.txt || fail "$program $option says no $name: $(cat out.txt)"
    done
    [ "$(wc -l <out.txt)" = 4 ] || fail "$program $option: $(cat out.txt)"
  done
done
mpirun --oversubscribe -n 2 "$fault" -version >out.txt 2>err.txt || fail "-version on two ranks: $(cat err.txt)"
[ "$(grep -c "^PETSc" out.txt)" = 1 ] || fail "-version on two ranks: $(cat out.txt)"
"$fault" -help >all.txt 2>err.txt || fail "-help: $(cat err.txt)"
for words in "" fault; do # a pager that is left before the end
  read -r -a words <<<"$words"
  { "$fault" -help "${words[@]}" 2>err.txt || true; } | head -1 >one.txt
  [ -s one.txt ] && [ ! -s err.txt ] || fail "-help ${words[*]} into a pager: $(cat err.txt)"
done
# Nobody reads what is printed: quiet, by SIGPIPE, or where that is ignored to the end
for words in "-fault_view" "-fault_output pipe.h5" "-ts_monitor"; do
  read -r -a words <<<"$words"
  { "$fault" -fault_nx 4 -fault_nz 4 -fault_stiffness_average whole -ts_max_time 1 "${words[@]}" 2>err.txt; echo $? >code.txt; } | true
  grep -qxE "141|0" code.txt && [ ! -s err.txt ] || fail "${words[*]} into a closed pipe: $(cat code.txt err.txt)"
done
rm -f pipe.h5*
head -1 all.txt | grep -q "fault -help fault" || fail "-help does not begin with where ours are"
"$fault" -help fault >out.txt 2>err.txt || fail "-help fault: $(cat err.txt)"
for option in fault_nx fault_friction_law fault_check_error fault_view fault_sweep ts_bathe_gamma ts_max_time ts_adapt_type; do
  grep -q -- "-$option\b" out.txt || fail "-help fault has no -$option"
done
grep -qE -- "-(ksp_|pc_type|fault_start_ksp|malloc|log_view|fp_trap)" out.txt && fail "-help fault has options of PETSc's"
grep -qE -- "-ksp_" all.txt || fail "-help has none of PETSc's"
ln -s "$fault" slipstep-fault # as the package names it, found on PATH
PATH=$PWD:$PATH slipstep-fault -help slipstep-fault >installed.txt 2>err.txt || fail "-help of an installed program: $(cat err.txt)"
head -1 installed.txt | grep -q "^slipstep-fault -help slipstep-fault prints" || fail "an installed program calls itself $(head -1 installed.txt)"
"$bin/circuit" -help circuit >out.txt 2>err.txt || fail "-help circuit: $(cat err.txt)"
grep -q -- "-circuit_c1" out.txt || fail "-help circuit: $(cat out.txt)"

# Numbers and choices, by name.
expect "-snes_atol is inf" -snes_atol inf
expect "-snes_atol is 0.0001" -snes_atol 1e-4
for option in snes_rtol snes_stol ksp_rtol fault_start_ksp_rtol; do
  for value in nan -1 1 inf; do expect "-$option is $value" -$option $value; done
done
for option in snes_atol ksp_atol ksp_divtol fault_start_ksp_atol fault_start_ksp_divtol ts_rtol ts_atol ts_init_time \
  ts_max_time ts_adapt_dt_min ts_adapt_dt_max ts_adapt_safety ts_adapt_pi_g1 ts_adapt_heuristic_growth "${dt#-}"; do
  expect "-$option is nan" -$option nan
done
expect "-fault_start_ksp_max_it is -3" -fault_start_ksp_max_it -3
expect "(-fault_start_ksp_max_it)" -fault_start_ksp_max_it two
expect "give -fault_start_ksp_rtol" -fault_start_ksp_rtol 0.9
expect "nix|-ts_adapt_type" -ts_adapt_type nix
expect "-ts_adapt_safety is 2" -ts_adapt_safety 2
expect '-fault_check_error is "maybe"' -fault_check_error maybe
expect "$dt is 1e-30 s|1e+30" -ts_adapt_type none -ts_dt 1e-30
expect "-ts_adapt_dt_max is 1e-14 s" -ts_adapt_dt_max 1e-14
expect "1 s|2 s|-ts_adapt_dt_max" -ts_adapt_dt_min 2 -ts_adapt_dt_max 1
for program in circuit sliding_mode oscillator; do
  refuses "-ts_adapt_dt_max is nan" -- "$bin/$program" -ts_adapt_dt_max nan
  refuses "-snes_atol is inf" -- "$bin/$program" -snes_atol inf
  refuses "$dt is 1e-30 s" -- "$bin/$program" -ts_adapt_type none -ts_dt 1e-30
  refuses "(-ts_max_time)" -- "$bin/$program" -ts_max_time soon
done
for option in "circuit -circuit_c1" "circuit -circuit_r" "circuit -circuit_m" "circuit -circuit_reference" "sliding_mode -sliding_mode_gain" \
  "sliding_mode -sliding_mode_frequency" "oscillator -oscillator_mass" "oscillator -oscillator_start"; do
  read -r program name <<<"$option"
  for value in nan inf; do refuses "$name is $value" -- "$bin/$program" "$name" $value; done
  refuses abc "$name" -- "$bin/$program" "$name" abc
done
refuses "-circuit_start has nan" -- "$bin/circuit" -circuit_start 1,nan,1
refuses '-train_random is "maybe"' -- "$bin/train" -train_random maybe
refuses '-evaluate_quick is "maybe"' -- "$bin/evaluate" -evaluate_quick maybe
refuses '-ts_adapt_safety is 2' -- "$bin/evaluate" -evaluate_quick -evaluate_output e.h5 -ts_adapt_safety 2
rm -f e.h5

# The end of a run: all that is written and compared is of one time, whatever PETSc offers.
refuses "-ts_exact_final_time interpolate" matchstep -- "$fault" "${tiny[@]}" -ts_exact_final_time interpolate
for program in circuit sliding_mode oscillator; do
  refuses "-ts_exact_final_time interpolate" -- "$bin/$program" -ts_exact_final_time interpolate
done
"$bin/oscillator" -ts_exact_final_time stepover -ts_max_time 1 -ts_adapt_type none -ts_dt 0.3 -oscillator_output over.h5 >out.txt || fail "stepover"
grep -qE "^end: +t = 1.2 s" out.txt || fail "stepover ends elsewhere: $(cat out.txt)"

# Times with a unit.
expect '"100q"|-ts_max_time|s, min, h, d or y' -ts_max_time 100q
expect '-fault_healing_time is "5m"' -fault_healing_time 5m
expect "-fault_healing_time is -3.15576e+07" -fault_healing_time -1y
expect '"1y"|-ts_rtol' -ts_rtol 1y

# Inputs: names, units, metres.
expect "misspelt.h5|/normal_stres|normal_stress?" -fault_parameters misspelt.h5
expect "pressure.h5|/pore_pressure" -fault_parameters pressure.h5
expect "density.h5|/density" -fault_parameters density.h5
expect "group.h5|/more" -fault_parameters group.h5
expect '/normal_stress|fields_mpa.h5|"MPa"|"Pa"' -fault_parameters fields_mpa.h5
expect '/stiffness|k_km.h5|"1/km"|"Pa/m"' -fault_stiffness_file k_km.h5
mesh "0.2828 " cells_km.h5
mesh '"km"' cells_said_km.h5
mesh "row 3 of /cells has z = 1e+30" cells_deep.h5
mesh "row 3 of /cells has x = 5e+07" cells_far.h5
mesh "columns?" cells_attribute.h5
mesh "/friction" cells_more.h5
expect "-fault_length_x is 1e+30" -fault_length_x 1e30
expect "-fault_depth_top is 3e+06" -fault_depth_top 3e6
run() { "$fault" "$@" >out.txt 2>err.txt; }
run -ts_max_time 0.1 -fault_mesh cells_m.h5 -fault_normal_stress 1e6 -fault_normal_stress_gradient 15e3 || fail "a small mesh that says its units: $(cat err.txt)"
run "${tiny[@]}" -fault_parameters fields_pa.h5 || fail "fields with units: $(cat err.txt)"

# What is used.
run "${tiny[@]}" -fault_parameters fields.h5 -fault_friction_drop 0.2 -fault_view || fail "-fault_view: $(cat err.txt)"
grep -qF "normal_stress: least 1e+06, mean 3e+06, largest 6e+06 Pa (from fields.h5)" out.txt || fail "the field used: $(cat out.txt)"
grep -q "normal_stress_gradient" out.txt && fail "-fault_view shows a scalar that the file has replaced"
grep -q "friction_drop: 0.2 *$" out.txt || fail "a uniform field"
run "${tiny[@]}" -fault_view || fail "-fault_view: $(cat err.txt)" # 15 kPa/m at 750 m and 2250 m
grep -qF "normal_stress: least 1.125e+07, mean 2.25e+07, largest 3.375e+07 Pa" out.txt || fail "stress by depth"
grep -q "^stiffness:" out.txt && fail "the stiffness was scaled"
run "${tiny[@]}" -fault_stiffness_scaling mean_slip || fail "mean_slip: $(cat err.txt)"
grep -qE "^stiffness: +multiplied by [0-9.]+ \(-fault_stiffness_scaling mean_slip\)$" out.txt || fail "the scaling is not told"

# The end.
ends() { # CODE LINE COMMAND...
  "${@:3}" >out.txt 2>err.txt
  local code=$?
  [ $code = "$1" ] || fail "exit code $code of ${*:3}"
  grep -qE "^end: +$2" out.txt || fail "no \"$2\" from ${*:3}: $(cat out.txt err.txt)"
}
ends 0 't = 30 s, all cells rest$' "$fault" -fault_nx 3 -fault_nz 3 -fault_stiffness_scaling mean_slip
ends 3 'stopped by -ts_max_steps 5 at t = [0-9.]+ of 30 s, 9 of 9 cells slide' "$fault" -fault_nx 3 -fault_nz 3 -ts_max_steps 5
ends 0 't = 8 s, [1-9] of 9 cells slide: the error of unfinished slip is not estimated$' "$fault" -fault_nx 3 -fault_nz 3 \
  -fault_stiffness_scaling mean_slip -ts_max_time 8
grep -q "estimated slip error: *[0-9]" out.txt && fail "an estimate while the fault slides"
ends 3 'stopped by -ts_max_steps 5 at' mpirun --oversubscribe -n 2 "$fault" -fault_nx 3 -fault_nz 3 -ts_max_steps 5
for program in circuit sliding_mode oscillator; do
  ends 0 't = [0-9.]+ s$' "$bin/$program"
  ends 3 'stopped by -ts_max_steps 5 at t = ' "$bin/$program" -ts_max_steps 5
done
ends 0 't = 1 s' "$fault" "${tiny[@]}" -ts_adapt_type none -ts_dt 0.1 -ts_max_steps 10
ends 0 't = 6 s' "$fault" -fault_nx 2 -fault_nz 2 -ts_max_time 0.1min
ends 0 't = 6 s' "$bin/oscillator" -ts_max_time 0.1min
printf -- '-ts_max_time 0.1min\n-ts_max_time 0.2min\n' >minutes.txt
ends 0 't = 12 s' "$fault" -fault_nx 2 -fault_nz 2 -fault_sweep minutes.txt

# A run that a signal stops says what it has done, also without a checkpoint.
"$fault" -fault_nx 8 -fault_nz 8 -ts_adapt_type none -ts_dt 1e-7 >out.txt 2>err.txt &
job=$!
sleep 2
kill -USR1 $job
wait $job
code=$?
[ $code = 138 ] || fail "exit code $code after SIGUSR1: $(cat err.txt)"
grep -qE "^accepted steps: +[1-9]" out.txt || fail "no summary of a run that was stopped: $(cat out.txt)"
grep -qE "^end: +stopped on demand at t = [0-9.e-]+ of 30 s" out.txt || fail "no end of a run that was stopped: $(cat out.txt)"
grep -qE "SIGUSR1 at time [0-9.e-]+ s after [1-9][0-9]* steps.*-fault_checkpoint" err.txt || fail "stopped: $(cat err.txt)"
printf -- '-fault_nx 2 -fault_nz 2 -ts_max_steps 3\n-fault_nx 2 -fault_nz 2 -ts_max_time 1\n' >two.txt
ends 3 't = 1 s' "$fault" -fault_sweep two.txt
# ---- an option of old scripts that nothing needs any more: the run goes on, with one line that says why ----
"$fault" "${tiny[@]}" -upper_fault_cache_dir x -fault_cache_dir cache >log 2>err || fail "an option of old scripts ends the run: $(cat err)"
[ "$(grep -c "fault_cache_dir" err)" = 2 ] && grep -q "warning: -fault_cache_dir" err || fail "not one line on an option of old scripts: $(cat err)"

exit $failed
