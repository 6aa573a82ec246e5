#!/usr/bin/env bash
# -train_algorithm cmaes: messages of bad input, a tiny training of each problem, its files, and its policy in a run.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
tiny=("$bin/train" -train_algorithm cmaes -train_singles 4 -train_meshes 1 -train_mesh_side 2 -train_batch_singles 3 -train_batch_meshes 1
  -train_validation 2 -train_calibration 2 -train_validation_interval 2 -train_population 6 -train_hidden 3 -train_generations 2 -train_late_generations 1)
refused=("${tiny[@]}" -train_output refused.h5)

refuses "-train_problem pendulum is not known" -- "${refused[@]}" -train_problem pendulum
refuses "-train_hidden is 0" -- "${refused[@]}" -train_hidden 0
refuses "-train_mesh_side is 20" -- "${refused[@]}" -train_mesh_side 20
refuses "-train_sigma is 0" -- "${refused[@]}" -train_sigma 0
refuses "expected them in order and at most 0.1" -- "${refused[@]}" -train_dial_low 1e-2 -train_dial_high 1e-3
refuses "expected a longer -train_dt_max" -- "${refused[@]}" -train_dt_min 5 -train_dt_max 1
refuses "-train_within is 2" -- "${refused[@]}" -train_within 2
refuses "(-train_population)" -- "${refused[@]}" -train_population 1
refuses "-train_output and -train_checkpoint are both refused.h5" -- "${refused[@]}" -train_checkpoint refused.h5
refuses "cannot create no/such/p.h5.part" -- "${refused[@]}" -train_output no/such/p.h5
refuses "missing.h5" -- "${refused[@]}" -train_resume missing.h5
refuses "nonsense" -- "${refused[@]}" -train_observations log_accuracy,nonsense

"${tiny[@]}" -train_output p.h5 -train_log l.h5 -train_checkpoint c.h5 >out.txt 2>&1 || fail "a training: $(cat out.txt)"
grep -q "generation     2 .* validation: .* left " out.txt || fail "no progress: $(cat out.txt)"
grep -q "dial moved by" out.txt || fail "no calibration: $(cat out.txt)"
refuses "no checkpoint of -train_algorithm cmaes" -- "${refused[@]}" -train_resume p.h5
refuses "it belongs to other networks" -- "${refused[@]}" -train_resume c.h5 -train_hidden 4
"$SLIPSTEP_PYTHON" - <<'EOF' || fail "the files of the training"
import h5py
import numpy as np

with h5py.File("p.h5") as p:
    names = [n.decode() if isinstance(n, bytes) else n for n in p["observation/names"][:]]
    assert "log_accuracy" in names and p.attrs["moving_dt_max"] == 30, dict(p.attrs)
    assert np.all(p["range/minimum"][:] <= p["range/maximum"][:])
    assert p.attrs["measure"] == b"history" and p.attrs["step_factor"] == b"log_growth_time" and "log_growth_time" in names
    assert np.isclose(p["range/minimum"][names.index("log_accuracy")], -3)
    assert p["layers/0/weight"].shape == (3, len(names)) and len(p["layers"]) == 2
with h5py.File("l.h5") as log:
    g = log["generations"]
    assert list(g["generation"][:]) == [2] and g["runs"][0] == 6 * (3 + 1 + 4 + 1) and g["wall_time"][0] > 0
    assert 0 <= g["within_dial"][0] <= 1 and g["best"][0] <= g["median"][0]
EOF
"$bin/fault" -fault_nx 2 -fault_nz 2 -ts_max_time 3 -ts_adapt_type rl -ts_adapt_rl_policy p.h5 >run.txt 2>&1 ||
  fail "a run with the policy: $(tail -3 run.txt)"
for problem in sliding_mode circuit; do
  "${tiny[@]}" -train_problem $problem -train_dial_low 1e-2 -train_output $problem.h5 >out.txt 2>&1 ||
    fail "a training of $problem: $(cat out.txt)"
  "$bin/$problem" -ts_adapt_type rl -ts_adapt_rl_policy $problem.h5 >run.txt 2>&1 || fail "$problem: $(tail -3 run.txt)"
done
# Trainings of the other problems that go on from a checkpoint end in the state of those in one piece, but for the time they took.
for problem in "ode -train_hidden 2 -train_episodes 8 -train_batch 6 -train_validation 6" "cycles -train_episodes 1 -train_batch 1 -train_validation 1"; do
  # shellcheck disable=SC2206 # words
  part=("$bin/train" -train_algorithm cmaes -train_problem $problem -train_population 4 -train_validation_interval 1)
  { "${part[@]}" -train_generations 2 -train_checkpoint whole.h5 && "${part[@]}" -train_generations 1 -train_checkpoint first.h5 &&
    "${part[@]}" -train_generations 2 -train_checkpoint second.h5 -train_resume first.h5; } >out.txt 2>&1 || fail "$problem: $(cat out.txt)"
  "$SLIPSTEP_PYTHON" - <<'EOF' || fail "resumed: $problem"
import h5py
import numpy as np

with h5py.File("whole.h5") as whole, h5py.File("first.h5") as first, h5py.File("second.h5") as second:
    names = [name for name in whole if whole[name].dtype.kind == "f"]
    assert {"mean", "path_sigma", "C", "best", "counters"} <= set(names) == {name for name in second if second[name].dtype.kind == "f"}
    assert all(np.array_equal(whole[name][:9], second[name][:9]) if name == "counters" else np.array_equal(whole[name], second[name]) for name in names)
    assert not np.array_equal(whole["mean"], first["mean"])
EOF
done
# A family of faults: a training, TQC on the same draws, and files that are refused
family() { printf '%s\n' "$@" >family.opts; }
cp "$SLIPSTEP_SOURCE/examples/family.opts" good.opts
"${tiny[@]}" -train_family good.opts -train_output family.h5 >out.txt 2>&1 || fail "a training on a family: $(cat out.txt)"
cmp -s family.h5 p.h5 && fail "a family that changes nothing"
"$bin/train" -train_problem fault_dial -train_reward dial -train_random -train_family good.opts -train_steps 40 -train_learning_starts 30 \
  -train_output tqc.h5 >out.txt 2>&1 || fail "TQC on a family: $(cat out.txt)"
family "-fault_lenght_x 5e3:20e3"
refuses "-train_family family.opts: line 1" -- "${refused[@]}" -train_family family.opts
family "# comment" "-fault_length_x 5e3:" 
refuses "line 2: -fault_length_x has the value 5e3" -- "${refused[@]}" -train_family family.opts
family "-fault_length_x 20e3:5e3"
refuses "expected a number, low:high" -- "${refused[@]}" -train_family family.opts
family "-fault_damping_ratio -1:1"
refuses "line 1: " -- "${refused[@]}" -train_family family.opts
family "-fault_friction_law linear_slip_weakening|nothing"
refuses "line 1: " -- "${refused[@]}" -train_family family.opts
family "-spread_length_x 0.1"
refuses "expected -spread_ and one of" -- "${refused[@]}" -train_family family.opts
family "-fault_nx 2 -fault_nz 2"
refuses "expected an option and its value" -- "${refused[@]}" -train_family family.opts
family "-fault_nx 2" "-fault_nx 3"
refuses "line 2: -fault_nx stands there twice" -- "${refused[@]}" -train_family family.opts
family "-fault_friction_slip 50"
refuses "of 50 faults drawn none slips" -- "${refused[@]}" -train_family family.opts
refuses "cannot be opened" -- "${refused[@]}" -train_family missing.opts
refuses "-train_family is for faults with an accuracy dial" -- "$bin/train" -train_family good.opts -train_steps 5
"$bin/train" -train_algorithm cmaes -help >help.txt 2>&1 || fail "-help"
for option in -train_problem -train_singles -train_minutes -train_within -train_moving_dt_max -train_output; do
  grep -qe "$option" help.txt || fail "$option is not in -help"
done
[ ! -e refused.h5 ] || fail "a policy of a training that was refused"
exit $failed
