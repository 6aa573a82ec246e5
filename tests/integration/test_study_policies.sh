#!/usr/bin/env bash
# The policies of the study (training/study/policies). Fault: all converge on a mesh, those of TQC in at most 25 steps
# of one solve and with a final mean slip within 2 % of a fine run, of 600 constant steps of second order, known to
# better than 0.01 %. Sliding mode and circuit: errors below the study's published ones, 2.9e-4 and 19.6 %, with no more
# solves than 0.44 and 0.1 of those of pi, the study's ratios of runtimes; pi needs an error estimate and gets it from
# step doubling, as in the study, these policies need none.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
policies=$SLIPSTEP_SOURCE/training/study/policies

number() { sed -n "s/^$1: *\([-+0-9.e]*\).*/\1/p" <<<"$2"; }
holds() { awk "BEGIN{exit !($1)}"; }

mesh=(-fault_nx 25 -fault_nz 25 -fault_stiffness_scaling mean_slip)
fine=$("$bin/fault" "${mesh[@]}" -ts_adapt_type none -ts_bathe_error none -ts_dt 0.05) || exit 1
for policy in "$policies"/fault_*.h5; do
  name=$(basename "$policy")
  run=$("$bin/fault" "${mesh[@]}" -ts_adapt_type rl -ts_adapt_rl_policy "$policy") || { fail "$name: no convergence"; continue; }
  accepted=$(number "accepted steps" "$run") solves=$(number "Bathe solves" "$run") rejected=$(number "rejected steps" "$run")
  error=$(awk "BEGIN{print 100 * ($(number "final mean slip" "$run") / $(number "final mean slip" "$fine") - 1)}")
  echo "$name: $accepted accepted, $rejected rejected, $solves solves, final mean slip off by $error %"
  case $name in *_tqc_*) ;; *) continue ;; esac
  holds "$accepted <= 25 && $solves == $accepted + $rejected" || fail "$name: too many steps"
  holds "$error < 2 && $error > -2" || fail "$name: too large an error"
done
[ "$(ls "$policies"/fault_tqc_alpha{0.5,1,2,4,8,16,32,128}.h5 | wc -l)" = 8 ] || fail "not eight alphas"

for case in "sliding_mode 2.9e-4 0.44" "circuit 0.196 0.1"; do
  read -r problem limit share <<<"$case"
  reference=()
  [ $problem = sliding_mode ] || reference=(-circuit_reference 1e-3)
  pi=$("$bin/$problem" -ts_adapt_type pi -ts_bathe_error doubling) || exit 1
  for algorithm in tqc td3; do
    name=${problem}_$algorithm
    run=$("$bin/$problem" -ts_adapt_type rl -ts_adapt_rl_policy "$policies/$name.h5" ${reference[@]+"${reference[@]}"}) ||
      { fail "$name: no convergence"; continue; }
    solves=$(number "Bathe solves" "$run") error=$(number "L2 error" "$run")$(number "relative L2 error" "$run")
    echo "$name: $solves solves (pi $(number "Bathe solves" "$pi")), L2 error $error"
    holds "$error < $limit" || fail "$name: error above $limit"
    holds "$solves <= $share * $(number "Bathe solves" "$pi")" || fail "$name: more than $share of pi's solves"
  done
done
exit $failed
