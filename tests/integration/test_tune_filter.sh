#!/usr/bin/env bash
# -train_algorithm filter: messages of bad input, a tiny tuning that is the same on any number of ranks, and its options in a run.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
tiny=("$bin/train" -train_algorithm filter -train_singles 6 -train_meshes 2 -train_mesh_side 2 -train_validation 3 -train_population 5
  -train_generations 4 -train_validation_interval 2)

refuses "-train_singles is 0" -- "${tiny[@]}" -train_singles 0
refuses "-train_mesh_side is 20" -- "${tiny[@]}" -train_mesh_side 20
refuses "expected them in order and at most 0.1" -- "${tiny[@]}" -train_dial_low 1e-2 -train_dial_high 5e-3
refuses "(-train_population)" -- "${tiny[@]}" -train_population 1

"${tiny[@]}" >out.txt 2>&1 || fail "a tuning: $(cat out.txt)"
[ "$(grep -c "^generation    [24]  mean: cost" out.txt)" = 2 ] || fail "no progress: $(cat out.txt)"
[ "$(grep -c "other episodes: cost" out.txt)" = 2 ] || fail "no score on other episodes: $(cat out.txt)"
grep -q "^-ts_rtol [0-9.e-]* a^[0-9.e-]* for an accuracy a" out.txt || fail "no rtol: $(cat out.txt)"
mpirun -n 2 "${tiny[@]}" >two.txt 2>&1 || fail "a tuning on two ranks: $(cat two.txt)"
cmp out.txt two.txt || fail "a tuning on two ranks differs: $(diff out.txt two.txt)"
"${tiny[@]}" -train_seed 1 >other.txt 2>&1 && cmp -s out.txt other.txt && fail "another seed, the same tuning"
options=$(grep "^-ts_adapt_type pi" out.txt)
"$bin/fault" -fault_nx 2 -fault_nz 2 -ts_max_time 12 -ts_rtol 1e-2 $options >run.txt 2>&1 || fail "a run: $(tail -3 run.txt)"
grep -q "^end:" run.txt || fail "the run did not end: $(cat run.txt)"
"$bin/train" -train_algorithm filter -help >help.txt 2>&1 || fail "-help"
for option in -train_singles -train_validation -train_dial_low -train_minutes; do
  grep -qe "$option" help.txt || fail "$option is not in -help"
done
exit $failed
