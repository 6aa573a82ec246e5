#!/usr/bin/env bash
# SlipTrain(), by examples/train_oscillator.c: messages of bad input, a tiny training, the same bits on two processes, its
# files, and a run with its policy. Tables that are wrong: tests/unit/test_user_problem.c.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
tiny=("$bin/train_oscillator" -train_singles 4 -train_batch_singles 3 -train_validation 2 -train_calibration 2 -train_validation_interval 2
  -train_population 6 -train_hidden 3 -train_generations 3)
refused=("${tiny[@]}" -train_output refused.h5)

refuses "-train_hidden is 0" -- "${refused[@]}" -train_hidden 0
refuses "-train_meshes" -- "${refused[@]}" -train_meshes 3
refuses "-train_dt_max" -- "${refused[@]}" -train_dt_min 5
refuses "nonsense" -- "${refused[@]}" -train_observations log_accuracy,nonsense

"${tiny[@]}" -train_output p.h5 -train_log l.h5 -train_checkpoint c.h5 >out.txt 2>&1 || fail "a training: $(cat out.txt)"
grep -q "generation     3 .* validation: .* left " out.txt || fail "no progress: $(cat out.txt)"
grep -q "dial moved" out.txt || fail "no calibration: $(cat out.txt)"
mpirun --oversubscribe -n 2 "${tiny[@]}" -train_output p2.h5 >out.txt 2>&1 || fail "on two processes: $(cat out.txt)"
"${tiny[@]}" -train_generations 4 -train_resume c.h5 -train_output r.h5 >out.txt 2>&1 || fail "resumed: $(cat out.txt)"
"$SLIPSTEP_PYTHON" - <<'EOF' || fail "the files of the training"
import h5py
import numpy as np

def content(path):
    found = {}
    with h5py.File(path) as f:
        f.visititems(lambda name, x: found.update({name: x[()].tobytes()}) if isinstance(x, h5py.Dataset) and x.dtype.kind == "f" else None)
    return found

assert len(content("p.h5")) >= 8 and content("p.h5") == content("p2.h5"), "other bits on two processes"
with h5py.File("p.h5") as p:
    names = [n.decode() if isinstance(n, bytes) else n for n in p["observation/names"][:]]
    assert names == ["log_accuracy", "log_turn", "log_swing", "log_time_left"]
    assert p.attrs["problem"] == b"oscillator" and "measure" not in p.attrs
    low, high = p["range/minimum"][:], p["range/maximum"][:]
    # the dial's range; turns from now to a half cycle, and beyond 10 at rest; amplitudes below the start
    assert np.isclose(low[0], np.log10(3e-3)) and np.isclose(high[0], -1) and np.isclose(high[1], 1) and np.all(low <= high) and high[2] <= 0.01
    assert p["action"].attrs["dt_max_unit"] == b"T*" and p["action"].attrs["dt_max"] == 3
with h5py.File("l.h5") as log:
    assert list(log["generations/generation"][:]) == [2, 3] and list(log["generations/runs"][:]) == [36, 54]
EOF
"$bin/oscillator" -ts_adapt_type rl -ts_adapt_rl_policy p.h5 -ts_adapt_rl_accuracy 1e-2 >run.txt 2>&1 || fail "a run with the policy: $(cat run.txt)"
solves() { "$bin/oscillator" -ts_adapt_type rl -ts_adapt_rl_policy p.h5 -ts_adapt_rl_accuracy "$1" | sed -n 's/^Bathe solves: *//p'; }
[ "$(solves 3e-3)" -gt "$(solves 1e-1)" ] || fail "the dial: $(solves 3e-3) solves at 3e-3, $(solves 1e-1) at 1e-1"

exit $failed
