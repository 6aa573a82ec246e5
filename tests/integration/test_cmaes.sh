#!/usr/bin/env bash
# -train_algorithm cmaes: messages of bad input, a tiny training of each problem, its files, and its policy in a run.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
tiny=("$bin/train" -train_algorithm cmaes -train_singles 4 -train_meshes 1 -train_mesh_side 2 -train_batch_singles 3 -train_batch_meshes 1
  -train_validation 2 -train_calibration 2 -train_validation_interval 2 -train_population 6 -train_hidden 3 -train_generations 2 -train_late_generations 1)
refused=("${tiny[@]}" -train_output refused.h5)

refuses "-train_problem pendulum" -- "${refused[@]}" -train_problem pendulum
refuses "-train_hidden is 0" -- "${refused[@]}" -train_hidden 0
refuses "-train_mesh_side is 20" -- "${refused[@]}" -train_mesh_side 20
refuses "-train_sigma is 0" -- "${refused[@]}" -train_sigma 0
refuses "-train_dial_low" -- "${refused[@]}" -train_dial_low 1e-2 -train_dial_high 1e-3
refuses "-train_dt_max" -- "${refused[@]}" -train_dt_min 5 -train_dt_max 1
refuses "-train_within is 2" -- "${refused[@]}" -train_within 2
refuses "(-train_population)" -- "${refused[@]}" -train_population 1
refuses -train_output -train_checkpoint refused.h5 -- "${refused[@]}" -train_checkpoint refused.h5
refuses no/such/p.h5.part -- "${refused[@]}" -train_output no/such/p.h5
refuses "missing.h5" -- "${refused[@]}" -train_resume missing.h5
refuses "nonsense" -- "${refused[@]}" -train_observations log_accuracy,nonsense

"${tiny[@]}" -train_output p.h5 -train_log l.h5 -train_checkpoint c.h5 >out.txt 2>&1 || fail "a training: $(cat out.txt)"
grep -q "generation     2 .* validation: .* left " out.txt || fail "no progress: $(cat out.txt)"
grep -q "dial moved" out.txt || fail "no calibration: $(cat out.txt)"
grep -q "on 4 fresh episodes" out.txt || fail "no word on what the result keeps: $(cat out.txt)"
refuses p.h5 "-train_algorithm cmaes" -- "${refused[@]}" -train_resume p.h5
refuses c.h5 -- "${refused[@]}" -train_resume c.h5 -train_hidden 4
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
# Another training may begin with its network: steps of almost no length leave that, and nothing of what it does not observe.
"${tiny[@]}" -train_problem fault_products -train_start p.h5 -train_sigma 1e-6 -train_within 0 -train_output products.h5 >out.txt 2>&1 ||
  fail "a training that begins with a policy: $(cat out.txt)"
"$SLIPSTEP_PYTHON" - <<'EOF' || fail "the network that a training began with"
import h5py
import numpy as np

with h5py.File("p.h5") as p, h5py.File("products.h5") as q:
    n = p["observation/names"].size
    assert list(q["observation/names"][n:]) == [b"log_step_limit", b"log_solve_cost"], q["observation/names"][:]
    scaled = [f["layers/0/weight"][:, :n] * f["observation/scale"][:n] for f in (p, q)]
    assert np.allclose(*scaled, atol=1e-4) and np.allclose(q["layers/0/weight"][:, n:], 0, atol=1e-4)
    assert not np.allclose(p["layers/0/weight"][:, 0], 0, atol=1e-3)
EOF
refuses "missing.h5" -- "${refused[@]}" -train_start missing.h5
refuses log_growth_time -- "${refused[@]}" -train_start products.h5 -train_observations log_accuracy

# A training that was killed leaves a policy that says so, until it is calibrated. The first validation writes it.
"${tiny[@]}" -train_generations 1000000 -train_output killed.h5 >out.txt 2>&1 &
until [ -e killed.h5 ] || ! kill -0 $! 2>/dev/null; do sleep 0.05; done
kill -9 $!
wait $! 2>/dev/null
"${tiny[@]}" -train_calibrate killed.h5 -train_within 0.5 -train_output ended.h5 >out.txt 2>&1 || fail "a calibration of a killed training: $(cat out.txt)"
"$SLIPSTEP_PYTHON" - <<'EOF' || fail "which policies are unfinished"
import h5py
assert ["unfinished" in h5py.File(name).attrs for name in ("killed.h5", "ended.h5", "p.h5")] == [True, False, False]
EOF
# A dial that is calibrated anew: the same weights, and the policy at a does what the old one does at the dial that a is moved to. What was
# moved once and is calibrated alike again is the same.
{ "${tiny[@]}" -train_within 0 -train_output plain.h5 && "${tiny[@]}" -train_calibrate plain.h5 -train_within 0.5 -train_output moved.h5 &&
  "${tiny[@]}" -train_calibrate moved.h5 -train_within 0.5 -train_output again.h5; } \
  >out.txt 2>&1 || fail "a calibration: $(cat out.txt)"
grep -q "before, on 4 fresh" out.txt || fail "what a policy was before: $(cat out.txt)"
"$SLIPSTEP_PYTHON" - >dial.txt <<'EOF' || fail "what a calibration moves"
import h5py
import numpy as np

with h5py.File("plain.h5") as p, h5py.File("moved.h5") as moved, h5py.File("again.h5") as again:
    names = [n.decode() if isinstance(n, bytes) else n for n in p["observation/names"][:]]
    dial = names.index("log_accuracy")
    for layer in p["layers"]:
        assert all(np.array_equal(p[f"layers/{layer}/{k}"], moved[f"layers/{layer}/{k}"]) for k in ("weight", "bias"))
    scale, offset = ([f[f"observation/{k}"][:] for f in (p, moved, again)] for k in ("scale", "offset"))
    assert np.array_equal(np.delete(scale[0], dial), np.delete(scale[1], dial)) and np.allclose(scale[1], scale[2], rtol=1e-12)
    assert np.array_equal(np.delete(offset[0], dial), np.delete(offset[1], dial)) and np.allclose(offset[1], offset[2], rtol=1e-12)
    assert moved.attrs["measure"] == b"history" and moved.attrs["generations"] == p.attrs["generations"]
    seen = -2 * scale[1][dial] + offset[1][dial]  # of the dial 1e-2
    print("%.15g" % 10 ** ((seen - offset[0][dial]) / scale[0][dial]))
EOF
# Moved by given numbers, from wherever it was, without runs: nothing else of the file changes.
"${tiny[@]}" -train_calibrate moved.h5 -train_move -0.2,0.1 -train_output given.h5 >out.txt 2>&1 || fail "a dial that is moved: $(cat out.txt)"
"$SLIPSTEP_PYTHON" - <<'EOF' || fail "what -train_move moves"
import h5py
import numpy as np

with h5py.File("plain.h5") as p, h5py.File("moved.h5") as moved, h5py.File("given.h5") as given:
    names = [n.decode() if isinstance(n, bytes) else n for n in p["observation/names"][:]]
    dial = names.index("log_accuracy")
    seen = [[x * f["observation/scale"][dial] + f["observation/offset"][dial] for x in (-2, -1)] for f in (p, given)]
    decades = (np.array(seen[1]) - seen[0]) / p["observation/scale"][dial]
    assert np.allclose(decades, [-0.2, -0.1], atol=1e-12), decades
    assert all(np.array_equal(np.delete(moved[f"observation/{k}"], dial), np.delete(given[f"observation/{k}"], dial)) for k in ("scale", "offset"))
    assert moved.attrs["validation_cost"] == given.attrs["validation_cost"] and moved.attrs["generations"] == given.attrs["generations"]
EOF
refuses -train_move -- "${refused[@]}" -train_calibrate p.h5 -train_move 0.1
refuses -train_move -- "${refused[@]}" -train_move 0.1,0
run=("$bin/fault" -fault_nx 2 -fault_nz 2 -ts_max_time 3 -ts_adapt_type rl -ts_adapt_rl_strict)
"${run[@]}" -ts_adapt_rl_policy moved.h5 >new.txt 2>&1 && "${run[@]}" -ts_adapt_rl_policy plain.h5 -ts_adapt_rl_accuracy "$(cat dial.txt)" >old.txt 2>&1 ||
  fail "runs of a calibrated policy: $(cat new.txt old.txt)"
for line in "Bathe solves" "final mean slip"; do
  [ "$(grep "^$line" new.txt)" = "$(grep "^$line" old.txt)" ] || fail "the dial is moved to $(cat dial.txt): $(grep "^$line" new.txt old.txt)"
done
refuses "missing.h5" -- "${refused[@]}" -train_calibrate missing.h5
refuses -train_resume -- "${refused[@]}" -train_calibrate p.h5 -train_resume c.h5
refuses "problem fault" circuit -- "${refused[@]}" -train_problem circuit -train_calibrate p.h5
refuses "-train_within above 0" -- "${refused[@]}" -train_calibrate p.h5 -train_within 0
refuses "/layers/0/weight" -- "${refused[@]}" -train_calibrate p.h5 -train_hidden 4
"$bin/fault" -fault_nx 2 -fault_nz 2 -ts_max_time 3 -ts_adapt_type rl -ts_adapt_rl_policy p.h5 >run.txt 2>&1 ||
  fail "a run with the policy: $(tail -3 run.txt)"
for problem in sliding_mode circuit; do
  "${tiny[@]}" -train_problem $problem -train_dial_low 1e-2 -train_output $problem.h5 >out.txt 2>&1 ||
    fail "a training of $problem: $(cat out.txt)"
  "$bin/$problem" -ts_adapt_type rl -ts_adapt_rl_policy $problem.h5 >run.txt 2>&1 || fail "$problem: $(tail -3 run.txt)"
done
# A training of another problem that goes on from a checkpoint ends in the state of those in one piece, but for the time they took.
for problem in "ode -train_hidden 2 -train_episodes 8 -train_batch 6 -train_validation 6"; do
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
# A family of faults: a training, and files that are refused
family() { printf '%s\n' "$@" >family.opts; }
bad() { # word, line... of a family that is refused by it
  family "${@:2}"
  refuses "$1" -- "${refused[@]}" -train_family family.opts
}
cp "$SLIPSTEP_SOURCE/examples/family.opts" good.opts
"${tiny[@]}" -train_family good.opts -train_output family.h5 >out.txt 2>&1 || fail "a training on a family: $(cat out.txt)"
cmp -s family.h5 p.h5 && fail "a family that changes nothing"
bad "-train_family family.opts: line 1" "-fault_lenght_x 5e3:20e3"
bad "line 2: -fault_length_x" "# comment" "-fault_length_x 5e3:"
bad "-fault_length_x" "-fault_length_x 20e3:5e3"
bad "line 1: " "-fault_damping_ratio -1:1"
bad "line 1: " "-fault_friction_law linear_slip_weakening|nothing"
bad "line 1: -spread_length_x" "-spread_length_x 0.1"
bad "-fault_nx" "-fault_nx 2 -fault_nz 2"
bad "line 2: -fault_nx" "-fault_nx 2" "-fault_nx 3"
bad "50 faults" "-fault_friction_slip 50"
bad "line 1: -fault_length_x" "-fault_length_x"
bad "line 1: -fault_initial_unstable" "-fault_initial_unstable perhaps"
bad "line 1: -weakening: " "-weakening 0.5:3"
bad "line 1: -patch_radius" "-patch_radius 100"
# Ruptures from a given stress, which the file makes the problem; a file of fields
few=(-fault_nx\ 8 -fault_nz\ 4 "-fault_length_x 8e3" "-fault_length_z 4e3" "-fault_normal_stress 50e6" "-fault_normal_stress_gradient 0"
  "-fault_friction_slip 0.2:0.3" "-fault_inertia no" "-fault_initial traction" "-stress_share 0.6:0.7" "-patch_radius 1.2e3:1.5e3" "-margin 1.5")
family "${few[@]}" -fault_initial_unstable "-spread_friction_drop 0.1"
"${tiny[@]}" -train_family family.opts -train_output rupture.h5 >out.txt 2>&1 || fail "a training on ruptures: $(cat out.txt)"
grep -q "dial 2.7e-02 to 1.0e-01: kept by" out.txt || fail "what it keeps: $(cat out.txt)"
"$SLIPSTEP_PYTHON" - <<'EOF' || fail "the policy and the fields of ruptures"
import h5py
import numpy as np

with h5py.File("rupture.h5") as p:
    assert p.attrs["problem"] == b"rupture", dict(p.attrs)
with h5py.File("fields.h5", "w") as f:
    f["friction_drop"] = np.full((4, 8), 0.12)
EOF
family "${few[@]}" -fault_initial_unstable "-fault_parameters fields.h5" "-spread_friction_drop 0.1"
"${tiny[@]}" -train_family family.opts -train_output fields.h5.policy >out.txt 2>&1 || fail "ruptures with a file of fields: $(cat out.txt)"
bad "line 14: -fault_parameters: missing.h5" "${few[@]}" -fault_initial_unstable "-fault_parameters missing.h5"
bad "-train_family family.opts: " "${few[@]/-fault_nx 8/-fault_nx 9}" -fault_initial_unstable "-fault_parameters fields.h5"
bad "line 9: -fault_initial" "${few[@]}"
bad "line 14: -weakening" "${few[@]}" -fault_initial_unstable "-weakening 3"
bad "line 14: -fault_friction_law: rate_and_state" "${few[@]}" -fault_initial_unstable "-fault_friction_law rate_and_state"
bad "-train_family family.opts" "${few[@]/-stress_share 0.6:0.7/-stress_share 0.01}" -fault_initial_unstable
family "${few[@]}" -fault_initial_unstable
refuses "rupture" -- "${refused[@]}" -train_family family.opts -train_problem fault_dial
family "${few[@]}" "-fault_loading_rate 1e-9"
refuses "-train_problem sequence" -- "${refused[@]}" -train_family family.opts -train_problem rupture
refuses "problem sequence" -- "${refused[@]}" -train_family family.opts
bad "-duration" "${few[@]}" "-fault_injection 1e3,1e3"
refuses missing.opts -- "${refused[@]}" -train_family missing.opts
refuses "-train_family" -- "$bin/train" -train_family good.opts -train_steps 5
"$bin/train" -train_algorithm cmaes -help >help.txt 2>&1 || fail "-help"
for option in -train_problem -train_singles -train_minutes -train_within -train_moving_dt_max -train_output; do
  grep -qe "$option" help.txt || fail "$option is not in -help"
done
[ ! -e refused.h5 ] || fail "a policy of a training that was refused"
exit $failed
