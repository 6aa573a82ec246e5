#!/usr/bin/env bash
# -train_algorithm tolerances of a user's faults, and a run that takes the file
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"

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
grep -q -e "-ts_adapt_type dsp -ts_rtol $rtol.*-fault_accuracy 0.01" run.txt || fail "dsp has not the tolerance $rtol: $(cat run.txt)"
"$bin/fault" -fault_nx 1 -fault_nz 1 -fault_tolerances mine.h5 -ts_adapt_type heuristic -ts_max_steps 1 >run.txt 2>&1
grep -q "warning: -fault_tolerances mine.h5" run.txt || fail "$(cat run.txt)"
refuses mine.h5 /sequence -- "$bin/fault" -fault_tolerances mine.h5 -fault_loading_rate 1e-3
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
