#!/usr/bin/env bash
# -train_algorithm steps: messages of bad input, and plans of a small fault, the same on any number of ranks; and tolerances.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
search=("$bin/train" -train_algorithm steps)

refuses "-train_steps_least is 9 and -train_steps_most 6" -- "${search[@]}" -train_steps_least 9 -train_steps_most 6
refuses "-train_steps_least is 1" -- "${search[@]}" -train_steps_least 1
refuses "expected a grid of at most 144 cells" -- "${search[@]}" -fault_nx 20 -fault_nz 20
refuses "expected a grid of at most 144 cells" -- "${search[@]}" -fault_mesh m.h5
refuses "-ts_max_time is -3" -- "${search[@]}" -ts_max_time -3
refuses "cannot create no/such/b.h5.part" -- "${search[@]}" -train_output no/such/b.h5

small=(-fault_nx 2 -fault_nz 1 -train_steps_least 6 -train_steps_most 8 -train_generations 40 -train_restarts 4 -train_seed 3)
"${search[@]}" "${small[@]}" -train_output one.h5 >one.txt 2>&1 || fail "a search: $(cat one.txt)"
mpirun -n 2 "${search[@]}" "${small[@]}" -train_output two.h5 >two.txt 2>&1 || fail "a search on two ranks: $(cat two.txt)"
cmp one.txt two.txt || fail "two ranks find something else"
"$SLIPSTEP_PYTHON" - <<'EOF' || fail "the file"
import h5py
import numpy as np

with h5py.File("one.h5") as a, h5py.File("two.h5") as b:
    assert a.attrs["format"] == b"slipstep-steps" and a.attrs["measure"] == b"history"
    for name in ("steps", "error", "dt"):
        assert a[name][...].tobytes() == b[name][...].tobytes(), name
    steps, error, dt = (a[name][...] for name in ("steps", "error", "dt"))
    assert list(steps) == [6, 7, 8] and dt.shape == (3, 8)
    # steps drawn about equal ones have errors of order one: a search is worth its name when it halves that
    assert np.all((error > 0) & (error < 0.5)), error
    assert np.allclose(np.nansum(dt, axis=1), 30) and np.all(np.isfinite(dt).sum(axis=1) <= steps)
EOF

# A rupture from a given stress, by the library: more steps are better, by more than rounding and less than without a search
refuses "-train_draw has 1 numbers" -- "${search[@]}" -train_draw 98
rupture=(-fault_nx 6 -fault_nz 3 -fault_length_x 6e3 -fault_length_z 3e3 -fault_normal_stress 50e6 -fault_normal_stress_gradient 0
  -fault_initial traction -fault_initial_unstable -fault_friction_slip 0.2)
refuses "of -ts_max_time" -- "${search[@]}" "${rupture[@]}" -fault_initial_traction 29e6 -ts_max_time 20
"${search[@]}" "${rupture[@]}" -fault_initial_traction 30.5e6 -ts_max_time 20 -train_steps_least 6 -train_steps_most 18 -train_steps_stride 12 \
  -train_generations 20 -train_restarts 1 -train_output rupture.h5 >rupture.txt 2>&1 || fail "steps of a rupture: $(cat rupture.txt)"
"$SLIPSTEP_PYTHON" - <<'EOF' || fail "the steps of a rupture: $(cat rupture.txt)"
import h5py
import numpy as np

with h5py.File("rupture.h5") as f:
    steps, error, dt = (f[name][...] for name in ("steps", "error", "dt"))
assert list(steps) == [6, 18] and np.allclose(np.nansum(dt, axis=1), 20)
assert 0 < error[1] < error[0] / 3 and error[0] < 0.3, error  # of second order: a ninth for three times the steps
EOF

# -train_algorithm tolerances of a user's faults, and a run that takes the file
cat >faults.opts <<'EOF'
-fault_nx 1
-fault_nz 1
-fault_length_x 2e3:3e3
-fault_friction_drop 0.1
EOF
"$bin/train" -train_algorithm tolerances -train_family faults.opts -train_problem fault_dial -train_calibration 2 -train_controllers pi,dsp -train_output mine.h5 \
  >mine.txt 2>&1 || fail "tolerances of a family: $(cat mine.txt)"
rtol=$(awk '$1 == "dsp" && $2 == "1e-02" { print $3 }' mine.txt)
"$bin/fault" -fault_nx 1 -fault_nz 1 -fault_tolerances mine.h5 -ts_adapt_type dsp >run.txt 2>&1 || fail "$(cat run.txt)"
grep -q -e "-ts_adapt_type dsp -ts_rtol $rtol, which keep -fault_accuracy 0.01" run.txt || fail "dsp has not the tolerance $rtol: $(cat run.txt)"
"$bin/fault" -fault_nx 1 -fault_nz 1 -fault_tolerances mine.h5 -ts_adapt_type heuristic -ts_max_steps 1 >run.txt 2>&1
grep -q "fault_tolerances mine.h5 has no effect on the steps: it has no tolerance of this controller" run.txt || fail "$(cat run.txt)"
refuses "mine.h5 has no group /sequence" -- "$bin/fault" -fault_tolerances mine.h5 -fault_loading_rate 1e-3
"$SLIPSTEP_PYTHON" - <<'EOF' || fail "the file of tolerances"
import h5py
import numpy as np

with h5py.File("mine.h5") as f:
    event = f["event"]
    assert f.attrs["format"] == b"slipstep-tolerances" and f.attrs["version"] == 2 and event.attrs["episodes"] == 2
    assert b"-train_family faults.opts" in event.attrs["command"] and event.attrs["family"] == b"faults.opts"
    assert list(event["controllers"]) == [b"pi", b"dsp"] and event["rtol"].shape == event["solves"].shape == (2, 5)
    assert np.all(np.diff(event["rtol"]) <= 0) and np.all(event["kept"][...] >= event.attrs["within"])
EOF
exit $failed
