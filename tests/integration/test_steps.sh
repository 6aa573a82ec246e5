#!/usr/bin/env bash
# -train_algorithm steps: messages of bad input, and plans of a small fault, the same on any number of ranks.
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
exit $failed
