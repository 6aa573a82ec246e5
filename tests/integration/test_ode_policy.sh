#!/usr/bin/env bash
# The general policy: -ts_adapt_type rl in a program that knows nothing of SlipStep, with PETSc's own methods and bathe, is
# accurate, and in two problems of the comparison takes less work than basic; its training writes the same numbers again, on
# any number of ranks.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
build=${SLIPSTEP_BUILD:?} source=${SLIPSTEP_SOURCE:?}

tiny=("$bin/train" -train_algorithm cmaes -train_problem ode -train_hidden 2 -train_episodes 8 -train_batch 6 -train_validation 6
  -train_population 5 -train_generations 3 -train_validation_interval 2)
refuses "-train_hidden is 0" -- "${tiny[@]}" -train_hidden 0
refuses "-train_batch is 0" -- "${tiny[@]}" -train_batch 0
"${tiny[@]}" -train_output a.h5 >out.txt 2>&1 || fail "a training: $(cat out.txt)"
grep -q "19 weights, population 5" out.txt && grep -q "generation     3 .* of basic's" out.txt || fail "no progress: $(cat out.txt)"
mpirun --oversubscribe -n 2 "${tiny[@]}" -train_output b.h5 >out.txt 2>&1 || fail "a training on two ranks: $(cat out.txt)"
"${tiny[@]}" -train_seed 1 -train_output c.h5 >out.txt 2>&1 || fail "another seed: $(cat out.txt)"
"$SLIPSTEP_PYTHON" - <<'EOF' || fail "the policies of the trainings"
import h5py
import numpy as np

def weights(name):
    with h5py.File(name) as p:
        assert p["action"].attrs["dt_min_unit"] in ("h", b"h") and p.attrs["problem"] in ("ode", b"ode")
        return np.concatenate([p[f"layers/{k}/{part}"][:].ravel() for k in (0, 1) for part in ("weight", "bias")])

assert np.array_equal(weights("a.h5"), weights("b.h5"))
assert not np.array_equal(weights("a.h5"), weights("c.h5"))
EOF

# A run that goes on from a checkpoint is the unbroken one: what the policy remembers of attempts is kept.
run=("$bin/fault" -fault_nx 2 -fault_nz 2 -ts_max_time 8 -ts_adapt_type rl -ts_adapt_rl_policy "$source/training/policies/ode.h5")
"${run[@]}" -fault_output whole.h5 >out.txt 2>&1 || fail "a fault: $(cat out.txt)"
"${run[@]}" -fault_output part.h5 -fault_checkpoint run.state -ts_max_steps 9 >/dev/null 2>&1
"${run[@]}" -fault_output part.h5 -fault_restart run.state >out.txt 2>&1 || fail "a restart: $(cat out.txt)"
"$SLIPSTEP_PYTHON" - <<'EOF' || fail "a restart gives another run"
import h5py
import numpy as np

with h5py.File("whole.h5") as whole, h5py.File("part.h5") as part:
    pairs = [(whole[g][k][:], part[g][k][:]) for g in ("steps", "series") for k in whole[g] if k not in ("wall", "cost")]
    assert len(pairs) > 10 and all(np.array_equal(a, b) for a, b in pairs)
EOF

# A run in PETSc's programs
[ -e "$build/lib/libslipstep.so" ] || exit $failed # BUILD_SHARED_LIBS=OFF
petsc=$(sed -n 's/^PETSC_LIBDIR:INTERNAL=//p' "$build/CMakeCache.txt" | head -n 1)
export PKG_CONFIG_PATH="$petsc/pkgconfig${PKG_CONFIG_PATH:+:$PKG_CONFIG_PATH}"
pc=PETSc
pkg-config --exists "$pc" || pc=petsc
read -ra flags <<< "$(pkg-config --cflags --libs "$pc")"
"${MPICC:-mpicc}" -o ode "$source/tests/plugin/ode.c" "${flags[@]}" -Wl,-rpath,"$petsc" -lm || fail "ode.c"
./ode -ts_type rk -ts_rk_type 5dp -ts_adapt_type basic -ts_rtol 1e-12 -ts_atol 1e-12 > reference
for type in "rk -ts_rk_type 3bs" "rk -ts_rk_type 5dp" arkimex "bdf" bathe; do
  for adapt in basic rl; do
    # shellcheck disable=SC2086 # options of the type
    ./ode -dll_prepend "$build/lib/libslipstep.so" -ts_type $type -ts_adapt_type $adapt -ts_rtol 1e-5 -ts_atol 1e-5 -ts_view \
      > "$adapt $type" 2>&1 || fail "$type with $adapt: $(tail -5 "$adapt $type")"
  done
  grep -q "policy of the problem ode" "rl $type" || fail "$type: rl does not take the general policy"
done
"$SLIPSTEP_PYTHON" - <<'EOF' || fail "runs of the general policy"
import glob

def run(name):
    words = [line for line in open(name) if line.startswith("time ")][0].split()
    return float(words[1]), float(words[5]), float(words[7])

_, x, y = run("reference")
names = sorted(glob.glob("rl *"))
assert len(names) == 5, names
for name in names:
    t, *state = run(name)
    error = max(abs(state[0] - x), abs(state[1] - y))
    print(name, error)
    assert abs(t - 5) < 1e-9, (name, t)
    # local errors of 1e-5 of states up to 3 add up to a hundred times that at most: 5 s of a stable cycle
    assert error < 3e-3, (name, error)
EOF

# Two of the problems of the comparison: it runs, and the policy takes less work than basic at equal error
"$SLIPSTEP_PYTHON" "$source/tests/benchmarks/ode.py" --controllers basic,rl --problems duffing,fitzhugh --output runs.txt > table.txt 2>&1 ||
  fail "ode.py: $(cat table.txt)"
awk -F'|' '/^. `rl`/ { found = 1; if ($3 > 1 || $5 !~ /^ 0 /) exit 1 } END { if (!found) exit 1 }' table.txt ||
  fail "the policy against basic: $(cat table.txt)"
exit $failed
