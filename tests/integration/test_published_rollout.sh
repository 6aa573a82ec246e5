#!/usr/bin/env bash
# The rollout that the study's authors recorded with their policy on one cell: step times to 1e-3 s, final mean slip
# to 1e-3 relative. Where their zip is at hand it is converted again and must give the policy of tests/published.
set -euo pipefail
build=${SLIPSTEP_BUILD:?} source=${SLIPSTEP_SOURCE:?} python=${SLIPSTEP_PYTHON:-python3}
published=$source/tests/published
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"

zip=${SLIPSTEP_PUBLISHED:-$source/../shared/published}/tqc_alpha1_single_element.zip
if [ -f "$zip" ]; then
  "$python" "$source/training/study/import_sb3.py" "$zip" "$work/imported.h5"
  "$python" - "$work/imported.h5" "$published/tqc_alpha1_single_element.h5" <<'P'
import sys
import h5py
import numpy as np

def contents(path):
    """Every attribute and dataset by name, but for the date of the conversion and the checksum of all"""
    with h5py.File(path) as f:
        found = {f"/{k}": v for k, v in f.attrs.items() if k not in ("created", "checksum")}
        def visit(name, item):
            found.update({f"{name}@{k}": v for k, v in item.attrs.items()})
            if isinstance(item, h5py.Dataset):
                found[name] = item[()]
        f.visititems(visit)
        return found

new, kept = contents(sys.argv[1]), contents(sys.argv[2])
assert set(new) == set(kept), set(new) ^ set(kept)
different = [name for name in new if not np.array_equal(new[name], kept[name])]
assert not different, f"the zip gives another policy than tests/published has: {different}"
print(f"the zip gives the policy of tests/published, {len(new)} entries alike")
P
else
  echo "the authors' zip is not here (SLIPSTEP_PUBLISHED, ../shared/published): its conversion is not repeated"
fi

run=("$build/bin/fault" -fault_nx 1 -fault_nz 1 -fault_stiffness_scaling mean_slip -ts_bathe_reaction implicit
     -ts_bathe_error doubling -ts_exact_final_time stepover -ts_adapt_type rl
     -ts_adapt_rl_policy "$published/tqc_alpha1_single_element.h5")
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
