#!/usr/bin/env bash
# The train program: messages of bad input, two policies side by side, the same bits for the same seed, the policy in a
# run.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"

train=("$bin/train" -train_steps 10 -train_output refused.h5)
refuses -train_problem pendulum fault sliding_mode circuit -- "${train[@]}" -train_problem pendulum
refuses -train_algorithm dqn tqc td3 -- "${train[@]}" -train_algorithm dqn
refuses -train_reward nonsense published accuracy -- "${train[@]}" -train_reward nonsense
refuses -train_cost days iterations wall -- "${train[@]}" -train_cost days
refuses -train_steps -- "${train[@]}" -train_steps 0
refuses "-train_drop_quantiles is 25" -- "${train[@]}" -train_drop_quantiles 25
refuses "-train_network is 0" -- "${train[@]}" -train_network 64,0
refuses "-train_policy_delay is 0" -- "${train[@]}" -train_policy_delay 0
refuses "-train_hidden is 0" -- "${train[@]}" -train_hidden 0
refuses "-train_batch is -1" -- "${train[@]}" -train_batch -1
refuses "-train_alpha is nan" -- "${train[@]}" -train_alpha nan
refuses "-train_learning_rate is nan" -- "${train[@]}" -train_learning_rate nan
refuses "-train_discount is 2" -- "${train[@]}" -train_discount 2
refuses "-train_buffer is nan" -- "${train[@]}" -train_buffer nan
refuses "(-train_steps)" -- "${train[@]}" -train_steps many
refuses "-ts_max_time is 0" -- "${train[@]}" -ts_max_time 0
refuses "-train_dt_min is 4.33013 s" "-train_dt_max 1 s" -- "${train[@]}" -train_dt_min 5 -train_dt_max 1
refuses "-fault_nx is 0" -- "${train[@]}" -fault_nx 0
# files that could not be written at the end of the training are refused at its start
refuses no/such/p.h5.part -train_output -- "${train[@]}" -train_output no/such/p.h5
refuses -train_checkpoint -- "${train[@]}" -train_checkpoint .
refuses no/such/l.h5.part -train_log -- "${train[@]}" -train_log no/such/l.h5
refuses -train_output -train_log refused.h5 -- "${train[@]}" -train_log refused.h5
refuses -train_log -train_checkpoint c.h5 -- "${train[@]}" -train_log c.h5 -train_checkpoint c.h5
refuses "nonsense" -- "${train[@]}" -train_log log.h5 -train_observations nonsense
refuses "-train_steps?" -- "${train[@]}" -train_stepz 5
"$bin/train" -train_steps 10 -train_progress 0 -nobody_reads 5 >out.txt 2>&1 || fail "another's option stops it"
grep -q "train: warning: .*-nobody_reads" out.txt || fail "no warning of an option that nobody reads"
refuses missing.h5 -- "${train[@]}" -train_resume missing.h5
refuses -train_transfer -train_resume -- "${train[@]}" -train_transfer
refuses nonsense energy -- "${train[@]}" -train_observations energy,nonsense
echo "not HDF5" >text.h5
refuses text.h5 -- "${train[@]}" -train_resume text.h5

short="-train_steps 300 -train_batch 32 -train_progress 0"
# four trainings on two ranks; one of them, under another name, is what one process trains
mpirun --oversubscribe -n 2 "$bin/train" ${short/-train_progress 0/-train_progress 100} -train_seed 4,5 -train_alpha 1,2 \
  -train_output p.h5 -train_log l.h5 -train_checkpoint c.h5 >sweep.txt || fail "a sweep on two ranks"
for file in p l c; do
  for name in alpha1_seed4 alpha2_seed4 alpha1_seed5 alpha2_seed5; do [ -s ${file}_$name.h5 ] || fail "no ${file}_$name.h5"; done
done
grep -q "alpha 2 seed 5: step" sweep.txt || fail "no progress of a training: $(cat sweep.txt)"
grep -q "4 of 4 .* 0 failed" sweep.txt || fail "no progress of the sweep: $(cat sweep.txt)"
"$bin/train" $short -train_seed 5 -train_alpha 2 -train_output q.h5 -train_checkpoint d.h5 || fail "one rank"
# one training fails, for its checkpoint is missing; the others go on
rm c_alpha1_seed4.h5
if mpirun --oversubscribe -n 2 "$bin/train" ${short/300/320} -train_seed 4,5 -train_alpha 1,2 -train_resume c.h5 -train_log m.h5 \
  -train_output r.h5 2>error.txt >sweep.txt; then fail "a sweep with a failed training exits with 0"; fi
grep -q "train: error: alpha 1 seed 4: .*c_alpha1_seed4.h5" error.txt || fail "no message of the failed one: $(cat error.txt)"
for name in alpha2_seed4 alpha1_seed5 alpha2_seed5; do [ -s r_$name.h5 ] || fail "no r_$name.h5"; done
[ ! -e r_alpha1_seed4.h5 ] || fail "a policy of the failed training"
[ -z "$(ls ./*.part 2>/dev/null)" ] || fail "left behind: $(ls ./*.part)"
refuses -train_resume -- "${train[@]}" -train_resume d.h5 -train_hidden 32
refuses -train_resume "-train_algorithm tqc" td3 -- "${train[@]}" -train_resume d.h5 -train_algorithm td3
refuses -train_resume checkpoint -- "${train[@]}" -train_resume q.h5
"$SLIPSTEP_PYTHON" - <<'EOF' || fail "the sweep and a single run differ, or the learning curve is wrong"
import h5py, numpy as np
a, b = h5py.File("c_alpha2_seed5.h5"), h5py.File("d.h5")
for name in ("actor/parameters", "critics/parameters", "critics/target", "buffer", "random/agent"):
    assert np.array_equal(a[name][:], b[name][:]), name
assert not np.array_equal(a["actor/parameters"][:], h5py.File("c_alpha1_seed5.h5")["actor/parameters"][:])
curve = h5py.File("l_alpha2_seed5.h5")["episodes"]
assert curve["step"][-1] == 300 and np.all(np.diff(curve["step"][:]) > 0)
assert curve["length"][:].sum() == 300
EOF
"$bin/fault" -fault_nx 2 -fault_nz 2 -ts_adapt_type rl -ts_adapt_rl_policy q.h5 >run.txt 2>&1 || fail "a run with the policy: $(tail -3 run.txt)"
grep -q "final mean slip" run.txt || fail "no summary of the run"
"$bin/train" -help >help.txt 2>&1 || fail "-help"
for option in -train_problem -train_algorithm -train_alpha -train_steps -train_seed -train_output -train_resume -train_checkpoint \
  -train_reward -train_cost -train_rtol -train_atol -train_random -train_log -fault_length_x; do
  grep -qe "$option" help.txt || fail "$option is not in -help"
done
[ ! -e refused.h5 ] || fail "a policy of a training that was refused"
exit $failed
