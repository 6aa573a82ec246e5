#!/usr/bin/env bash
# The rollout that the study's authors recorded with their policy on one cell: step times to 1e-3 s, final mean slip
# to 1e-3 relative.
set -euo pipefail
build=${SLIPSTEP_BUILD:?} source=${SLIPSTEP_SOURCE:?} python=${SLIPSTEP_PYTHON:-python3}
published=$source/../shared/published
if [ ! -d "$published" ]; then published=${SLIPSTEP_PUBLISHED:-}; fi
if [ ! -f "$published/rollout_single_element_alpha1.json" ]; then
  echo "skipped: the published rollout is not here (../shared/published, or SLIPSTEP_PUBLISHED)"
  exit 77
fi
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"

"$python" "$source/training/import_sb3.py" "$published/tqc_alpha1_single_element.zip" "$work/imported.h5"
run=("$build/bin/fault" -fault_nx 1 -fault_nz 1 -fault_stiffness_scaling mean_slip -ts_bathe_reaction implicit
     -ts_bathe_error doubling -ts_exact_final_time stepover -ts_adapt_type rl -ts_adapt_rl_policy "$work/imported.h5")
for solver in semismooth projection; do
  "${run[@]}" -snes_type "$solver" -fault_output "$work/$solver.h5" > "$work/log" 2>&1 || { cat "$work/log"; exit 1; }
  "$python" - "$work/$solver.h5" "$published/rollout_single_element_alpha1.json" "$solver" <<'P'
import json, sys
import h5py, numpy as np
with h5py.File(sys.argv[1]) as f:
    time, slip, rate = (f["series/" + name][:] for name in ("time", "mean_slip", "mean_slip_rate"))
with open(sys.argv[2]) as f:
    published = json.load(f)
expected = np.array(published["times"])
time, rate = time[time > 0], rate[time > 0]
assert time.shape == expected.shape, f"{len(time)} accepted steps, the authors took {len(expected)}"
dt, ds = np.abs(time - expected).max(), abs(1e3 * slip[-1] / published["s_end_mean"] - 1)
dv = np.abs(rate - published["mean_v"]).max() / max(published["mean_v"])
print(f"{sys.argv[3]}: step times within {dt:.1e} s, final mean slip within {ds:.1e}, slip rates within {dv:.1e} of the peak")
assert dt < 1e-3 and ds < 1e-3 and dv < 1e-3
P
done
