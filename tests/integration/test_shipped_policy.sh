#!/usr/bin/env bash
# The shipped policy for the final slip, trained on single cells and meshes of up to 7 x 7, on finer meshes of the 3 km fault and of the
# 5 km fault: at three positions of the accuracy dial the error of the final mean slip against a fine run keeps within
# the dial, with fewer solves than the classical controllers need by far; and more accuracy costs more solves. The fine
# run takes constant steps, 600 of them: of second order, and 100 steps were measured at 0.13 % on a 15 x 15 mesh, so it
# is known to better than 0.01 %, a tenth of the finest dial here.
set -uo pipefail
fault=$SLIPSTEP_BUILD/bin/fault
policy=$SLIPSTEP_SOURCE/training/policies/fault_final_slip.h5
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"

number() { sed -n "s/^$1: *\([-+0-9.e]*\).*/\1/p" <<<"$2"; }

for case in "3000 30 25" "5000 50 25" "3000 30 50"; do
  read -r length duration n <<<"$case"
  common=(-fault_nx "$n" -fault_nz "$n" -fault_length_x "$length" -fault_length_z "$length" -ts_max_time "$duration"
    -fault_stiffness_scaling mean_slip)
  fine=$("$fault" "${common[@]}" -ts_adapt_type none -ts_bathe_error none -ts_dt "$(awk "BEGIN{print $duration / 600}")") || exit 1
  last=0
  for dial in "1e-1 12" "1e-2 20" "1e-3 50"; do
    read -r accuracy most <<<"$dial"
    run=$("$fault" "${common[@]}" -ts_adapt_type rl -ts_adapt_rl_policy "$policy" -ts_adapt_rl_accuracy "$accuracy") || exit 1
    rejected=$(number "rejected steps" "$run") solves=$(number "Bathe solves" "$run")
    error=$(awk "BEGIN{print $(number "final mean slip" "$run") / $(number "final mean slip" "$fine") - 1}")
    echo "$length m, $n x $n, dial $accuracy: $solves solves, $rejected rejected, final mean slip off by $error"
    [ "$solves" -le "$most" ] && [ "$rejected" -le 2 ] || fail "too many steps"
    [ "$solves" -gt "$last" ] || fail "the dial does not buy accuracy for solves"
    awk "BEGIN{exit !($error < $accuracy && $error > -$accuracy)}" || fail "not within the dial"
    last=$solves
  done
done
exit $failed
