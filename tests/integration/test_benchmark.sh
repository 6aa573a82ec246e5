#!/usr/bin/env bash
# tests/benchmarks/run.sh --quick: stopped, it goes on where it was; a cell that fails is marked, does not stop the rest
# and can be tried again; the HDF5 file has every number.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"

# A build whose H-matrix is broken.
mkdir -p build/bin build/tests
ln -s "$SLIPSTEP_BUILD/bin/fault" build/bin/fault
cat >build/tests/operators <<P
#!/bin/sh
case "\$*" in *k_hmat*) echo "operators: error: broken on purpose" >&2; exit 3 ;; esac
exec "$SLIPSTEP_BUILD/tests/operators" "\$@"
P
chmod +x build/tests/operators

benchmark=("$SLIPSTEP_SOURCE/tests/benchmarks/run.sh" --quick --output result.h5)
set -m # else SIGINT is ignored in the background
"${benchmark[@]}" --build build >first.txt 2>&1 &
set +m
first=$!
until grep -q '^\[3/52\]' first.txt || ! kill -0 $first 2>/dev/null; do sleep 0.05; done # two cells are known
kill -INT $first
wait $first && fail "the first run was not stopped"
grep -q "goes on from" first.txt || { cat first.txt; fail "no word on how to go on"; }
known=$("$SLIPSTEP_PYTHON" -c 'import h5py; print(len(h5py.File("result.h5")["cells"]))') || fail "no file of a stopped benchmark"
"${benchmark[@]}" --build build >second.txt 2>&1 || { cat second.txt; fail "the second run"; }
grep -q "$((52 - known)) cells to run, $known known" second.txt || { head -3 second.txt; fail "$known cells were known"; }
grep -q "k_hmat-10-1 .*failed.* operators: error: broken on purpose" first.txt second.txt || fail "the broken cell is not marked"
grep -q "not measured: k_hmat-10-1, k_hmat-15-1, k_hmat-25-1" second.txt || fail "broken cells are not listed at the end"
"${benchmark[@]}" --build "$SLIPSTEP_BUILD" >third.txt 2>&1 || fail "the third run"
grep -q "0 cells to run" third.txt || fail "cells that failed were run again unasked"
"${benchmark[@]}" --build "$SLIPSTEP_BUILD" --retry >fourth.txt 2>&1 || fail "--retry"
grep -q "3 cells to run" fourth.txt || { cat fourth.txt; fail "--retry runs what failed"; }
grep -q "not measured" fourth.txt && fail "--retry left something out"
grep -Eq "^k_fft product +[0-9.]+ +3$" fourth.txt || { cat fourth.txt; fail "no slope of the FFT's product"; }
ls ./*.part* >/dev/null 2>&1 && fail "left behind: $(ls ./*.part*)"

"$SLIPSTEP_PYTHON" - <<'P' || failed=1
import sys
import h5py
import numpy as np

with h5py.File("result.h5") as f:
    operators, runs, iterations = f["operators"], f["runs"], f["iterations"]
    ok = all(np.all(table["status"].asstr()[:] == "ok") for table in (operators, runs, iterations))
    kinds = set(operators["kind"].asstr()[:])
    complete = kinds == {"k_dense", "k_fft", "k_hmat", "h_sqrtm", "h_spectral", "h_lanczos", "b", "pc"}
    dense = operators["kind"].asstr()[:] == "k_dense"
    # what is known without measuring: bytes of a dense matrix
    memory = np.array_equal(operators["memory"][dense], 8 * operators["n"][dense] ** 4)
    positive = all(np.all(operators[k][:] > 0) for k in ("product", "setup", "resident")) and np.all(runs["solve"][:] > 0)
    # ranks do not change what is computed
    slip = {}
    for key in zip(runs["controller"].asstr()[:], runs["n"][:], runs["mean_slip"][:], runs["solves"][:]):
        slip.setdefault(key[:2], []).append(key[2:])
    same = all(len(v) == 2 and abs(v[0][0] / v[1][0] - 1) < 1e-9 and v[0][1] == v[1][1] for v in slip.values())
    grows = np.all(iterations["iterations"][:] >= 1) and iterations["iterations"].shape == (8,)
    units = operators["product"].attrs["units"] == "s" and operators["memory"].attrs["units"] == "B"
    bad = [name for name, good in dict(ok=ok, complete=complete, memory=memory, positive=positive, same=same, grows=grows,
                                       units=units).items() if not good]
print("FAILED: " + ", ".join(bad) if bad else "the file is complete")
sys.exit(bool(bad))
P
exit $failed
