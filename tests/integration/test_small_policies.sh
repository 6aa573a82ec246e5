#!/usr/bin/env bash
# The shipped policies of sliding_mode and circuit, on the evaluation settings: found by default; the dial buys accuracy for solves; and
# no run of a classical controller at any of nine tolerances is both as cheap and as accurate (L2 error of the states) at any of four
# positions of the dial. The circuit's reference takes 20,000 constant steps: of second order, and 1,000 have an error of 1e-3, so it is
# off by some 1e-5, a hundredth of the smallest error here.
set -uo pipefail
bin=$SLIPSTEP_BUILD/bin
policies=$SLIPSTEP_SOURCE/training/policies
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1

for problem in sliding_mode circuit; do
  "$bin/$problem" -ts_adapt_type rl -ts_view >out.txt 2>&1 || { cat out.txt; exit 1; }
  grep -q "policies/$problem.h5" out.txt || { echo "FAILED: $problem has not found its policy"; cat out.txt; exit 1; }
done
evaluate() { "$bin/evaluate" -evaluate_output e.h5 -evaluate_repetitions 1 -evaluate_reactions trapezoidal "$@" >out.txt 2>&1 || { cat out.txt; exit 1; }; }
evaluate -evaluate_problems sliding_mode,circuit -evaluate_reference_steps 20000 -evaluate_controllers heuristic,pi,dsp,basic \
  -evaluate_tolerances 1,10,30,100,200,500,1000,3000,10000
for problem in sliding_mode circuit; do
  evaluate -evaluate_problems $problem -evaluate_reference_steps 0 -evaluate_controllers rl -evaluate_errors embedded \
    -evaluate_policies "$policies/$problem.h5" -evaluate_accuracies 5e-2,3e-2,1e-2,3e-3
done
"$SLIPSTEP_PYTHON" - <<'EOF'
import sys

import h5py

failed = False
with h5py.File("e.h5") as file:
    for problem, cells in file["cells"].items():
        runs = {name: (int(c.attrs["solves"]), float(c.attrs["l2_error"])) for name, c in cells.items() if c.attrs["converged"]}
        ours = {name: run for name, run in runs.items() if "@" in name}
        assert len(ours) == 4 and len(runs) > 50, (problem, len(ours), len(runs))
        for name, (solves, error) in sorted(ours.items(), key=lambda item: item[1]):
            better = [n for n, (s, e) in runs.items() if n not in ours and not n.startswith("rl") and s <= solves and e <= error]
            print(f"{problem}: {name}: {solves} solves, error {error:.2e}" + (f", beaten by {better}" if better else ""))
            failed = failed or bool(better)
        by_solves = sorted(ours.values())
        if by_solves[-1][1] > 0.3 * by_solves[0][1]:
            print(f"FAILED: {problem}: the dial does not buy accuracy for solves")
            failed = True
sys.exit(failed)
EOF
