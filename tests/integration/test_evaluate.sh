#!/usr/bin/env bash
# The evaluate program: a tiny matrix end to end, going on after kill -9, ranks, failing cells, wrong use, figures and
# tables.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
source=$SLIPSTEP_SOURCE
policy=$source/training/policies/fault.h5

# left FILE NUMBERS: how many cells its last lines say there are, were there, failed and are left
left() { grep -qE ": $2 cells [^0-9]*$3 [^0-9]*$4 [^0-9]*$5 left" "$1"; }

tiny=(-evaluate_sizes 3 -evaluate_meshes 3 -evaluate_reference_steps 600 -evaluate_repetitions 1)

# ---- a matrix, twice: the second time there is nothing to do ----
matrix=("${tiny[@]}" -evaluate_problems fault,sliding_mode,circuit -evaluate_policies "$policy" -evaluate_tolerances 1,10,100,1000
  -evaluate_steps 20,100)
"$bin/evaluate" "${matrix[@]}" -evaluate_output a.h5 >a.txt 2>&1 || fail "a matrix: $(tail -3 a.txt)"
left a.txt 160 0 0 0 || fail "summary: $(tail -1 a.txt)"
grep -Eq "^\[[0-9]+/160\] fault_3km_3x3/heuristic_x1_embedded_trapezoidal: .* left$" a.txt || fail "no progress with the time left"
"$bin/evaluate" "${matrix[@]}" -evaluate_output a.h5 >again.txt 2>&1 || fail "the same matrix again"
left again.txt 160 160 0 0 || fail "runs again what is there: $(cat again.txt)"
"$bin/evaluate" "${matrix[@]}" -evaluate_output a.h5 -evaluate_list >list.txt 2>&1 || fail "-evaluate_list"
[ "$(grep -c '^done ' list.txt)" = 160 ] || fail "-evaluate_list does not list 160 done cells"

# ---- killed while it runs, the file is whole, and the same command completes it ----
: >b.txt
mpirun --oversubscribe -n 2 "$bin/evaluate" "${matrix[@]}" -evaluate_problems fault,sliding_mode -evaluate_output b.h5 >b.txt 2>&1 &
launcher=$!
until [ "$(grep -c '^\[' b.txt)" -ge 12 ] || ! kill -0 $launcher 2>/dev/null; do sleep 0.05; done
pids=$(pgrep -P $launcher -f "$bin/evaluate" || true)
kill -9 $pids $launcher 2>/dev/null
wait $launcher 2>/dev/null
# a killed rank may stay a zombie for as long as its new parent does not ask for it
for pid in $pids; do while [[ $(ps -o stat= -p "$pid") == [!Z]* ]]; do sleep 0.05; done; done
before=$("$SLIPSTEP_PYTHON" -c "import h5py; print(sum(len(c) for c in h5py.File('b.h5')['cells'].values()))") || fail "not whole after kill -9"
reported=$(grep -c '^\[[0-9]*/108\]' b.txt)
[ "$before" -ge "$reported" ] || fail "$reported cells reported but $before in the file"
"$bin/evaluate" "${matrix[@]}" -evaluate_problems fault,sliding_mode -evaluate_output b.h5 >c.txt 2>&1 || fail "going on: $(tail -3 c.txt)"
left c.txt 108 "$before" 0 0 || fail "after kill -9 with $before cells: $(tail -1 c.txt)"

# ---- cells on two ranks together, and one repeated by the program fault ----
mpirun --oversubscribe -n 2 "$bin/evaluate" "${tiny[@]}" -evaluate_spread 0 -evaluate_policies "$policy" -evaluate_errors embedded \
  -evaluate_reactions trapezoidal -evaluate_reference_steps 100 -evaluate_output d.h5 >d.txt 2>&1 ||
  fail "on two ranks together: $(tail -3 d.txt)"
"$bin/fault" -fault_nx 3 -fault_nz 3 -fault_stiffness_scaling mean_slip -ts_adapt_type pi -ts_rtol 1e-3 -ts_bathe_error doubling -fault_output run.h5 >/dev/null || fail "fault"
"$bin/sliding_mode" -ts_adapt_type pi -sliding_mode_output small.h5 >/dev/null || fail "sliding_mode"
"$SLIPSTEP_PYTHON" - <<'P' || fail "results differ"
import h5py
a, b, d, run, small = (h5py.File(name) for name in ("a.h5", "b.h5", "d.h5", "run.h5", "small.h5"))
for case, cells in b["cells"].items():
    for name, cell in cells.items():
        other = a["cells"][case][name].attrs
        # the same bits, killed or not, on one rank or spread over two
        for key in ("solves", "accepted", "final_error", "max_error", "l2_error"):
            assert cell.attrs[key] == other[key], (case, name, key)
for name, cell in d["cells/fault_3km_3x3"].items():
    mine = a["cells/fault_3km_3x3"][name].attrs
    assert cell.attrs["solves"] == mine["solves"] and cell.attrs["ranks"] == 2, name
    assert abs(cell.attrs["final"] / mine["final"] - 1) < 1e-6, name  # sums in another order; solves end at 1e-8
pi = a["cells/fault_3km_3x3/pi_x1_doubling_trapezoidal"].attrs
assert pi["solves"] == run["result"].attrs["solves"]
assert abs(pi["final"] / run["result"].attrs["mean_slip"] - 1) < 1e-12
w = a["cells/sliding_mode/pi_x1_embedded_trapezoidal"].attrs
assert abs(w["l2_error"] / small["result"].attrs["l2_error"] - 1) < 1e-9 and w["solves"] == small["result"].attrs["solves"]
assert a["references/fault_3km_3x3"].attrs["self_max"] < 0.01
P

# ---- a run that fails is a result, with its reason ----
"$bin/evaluate" "${tiny[@]}" -evaluate_controllers heuristic,none -ts_adapt_dt_min 0.5 -evaluate_output f.h5 >f.txt 2>&1 ||
  fail "a failing cell ends the program: $(tail -2 f.txt)"
grep -q "FAILED, At time .* below -ts_adapt_dt_min" f.txt || fail "no reason of the failure: $(cat f.txt)"
left f.txt 6 0 4 0 || fail "failures are not counted: $(tail -1 f.txt)"
"$bin/evaluate" "${tiny[@]}" -evaluate_controllers heuristic -evaluate_max_attempts 5 -evaluate_output g.h5 >g.txt 2>&1 || fail "a limit"
grep -q "FAILED, 5 attempts (-evaluate_max_attempts)" g.txt || fail "no limit of attempts: $(cat g.txt)"
"$bin/evaluate" "${tiny[@]}" -evaluate_controllers heuristic -evaluate_repeat_failed -evaluate_output g.h5 >g.txt 2>&1 || fail "repeating"
left g.txt 4 0 0 0 || fail "failed cells are not repeated: $(tail -1 g.txt)"
"$bin/evaluate" "${tiny[@]}" -evaluate_controllers pi -evaluate_time_limit 1e-9 -evaluate_output g.h5 >g.txt 2>&1 || fail "a time limit"
left g.txt 4 0 0 4 || fail "no time limit: $(tail -1 g.txt)"

# ---- another file of a policy's name: its cells count for nothing, and are made anew ----
trained=$source/training/study/policies
mkdir named && cp "$trained/fault_tqc_alpha1.h5" named/p.h5
renamed=("$bin/evaluate" "${tiny[@]}" -evaluate_controllers rl -evaluate_policies named/p.h5 -evaluate_output h.h5)
"${renamed[@]}" >h.txt 2>&1 || fail "a policy: $(tail -2 h.txt)"
cp "$trained/fault_tqc_alpha128.h5" named/p.h5
"${renamed[@]}" -evaluate_list >h.txt 2>&1 || fail "the list of a replaced policy"
[ "$(grep -c '^outdated fault_3km_3x3/rl_p_' h.txt)" = 4 ] || fail "cells of a replaced policy are not outdated: $(cat h.txt)"
"${renamed[@]}" -evaluate_errors embedded >h.txt 2>&1 || fail "a replaced policy: $(tail -2 h.txt)"
grep -q "h.h5: 2 cells" h.txt || fail "no word of a replaced policy"
left h.txt 2 0 0 0 || fail "a replaced policy: $(tail -1 h.txt)"
cp "$source/output/RESULTS.md" page.md
printf '\n<!-- table contents -->\n<!-- end contents -->\n' >>page.md
"$SLIPSTEP_PYTHON" "$source/src/package/program.py" results-table h.h5 --page page.md >h.txt 2>&1 || fail "tables of a replaced policy: $(cat h.txt)"
grep -q "h.h5 has 2 cells .* p," h.txt || fail "no warning of mixed cells: $(cat h.txt)"
grep -q "^| fault 3km 3x3 | 2 |" page.md || fail "mixes cells of two policies: $(grep "3km 3x3" page.md)"

# ---- entries that a list has twice are run once ----
"$bin/evaluate" "${tiny[@]}" -evaluate_meshes 3,3 -evaluate_controllers pi,none,pi -evaluate_steps 20,20 -evaluate_output h.h5 >h.txt 2>&1 || fail "twice"
left h.txt 6 0 0 0 || fail "runs entries of a list twice: $(tail -1 h.txt)"

# ---- wrong use: one message, and the file stays as it is ----
sum=$(sha256sum <a.h5)
same=("$bin/evaluate" "${tiny[@]}" -evaluate_output a.h5)
refuses "-evaluate_controllers nonsense" heuristic pi dsp none rl -- "${same[@]}" -evaluate_controllers pi,nonsense
refuses "-evaluate_problems pendulum" sliding_mode -- "${same[@]}" -evaluate_problems pendulum
refuses "-evaluate_errors tripling" embedded doubling -- "${same[@]}" -evaluate_errors tripling
refuses "-evaluate_policies" -- "${same[@]}" -evaluate_controllers rl
refuses fault.h5 -- "${same[@]}" -evaluate_problems circuit -evaluate_policies "$policy"
refuses fault_tqc_alpha2.h5 -- "${same[@]}" -evaluate_policies "$trained"/fault_tqc_alpha[12].h5
refuses "-evaluate_steps" 64 -- "${same[@]}" -evaluate_steps "$(seq -s, 3 67)"
refuses "-evaluate_controllers" 64 -- "${same[@]}" -evaluate_controllers "$(yes pi | head -65 | paste -sd,)"
refuses "-evaluate_accuracies has 2" -- "${same[@]}" -evaluate_accuracies 0.1,2
refuses "no/such.h5" -evaluate_policies -- "${same[@]}" -evaluate_policies no/such.h5
mkdir twin && cp "$policy" twin/
refuses "name fault" -- "${same[@]}" -evaluate_policies "$policy,twin/fault.h5"
refuses a.h5 fault_3km_4x4 -evaluate_reference_steps -- "${same[@]}" -evaluate_meshes 4 -evaluate_reference_steps 0
refuses twin/fault.h5 "slipstep-policy" -- "$bin/evaluate" "${tiny[@]}" -evaluate_output twin/fault.h5
refuses a.h5 "-fault_friction_slip 0.2" -- "${same[@]}" -fault_friction_slip 0.2
refuses -ts_rtol -evaluate_tolerances -- "${same[@]}" -ts_rtol 1e-4
refuses "-evaluate_meshes has -3" -- "${same[@]}" -evaluate_meshes -3
refuses "-evaluate_spread is -1" -- "${same[@]}" -evaluate_spread -1
refuses "-evaluate_repetitions is 0" -- "${same[@]}" -evaluate_repetitions 0
refuses "-evaluate_output" -- "$bin/evaluate" "${tiny[@]}" -evaluate_output no/such/dir.h5
head -c 3000 a.h5 >cut.h5
refuses "cut.h5" -- "$bin/evaluate" "${tiny[@]}" -evaluate_output cut.h5
[ "$sum" = "$(sha256sum <a.h5)" ] || fail "wrong use changed the file"
"$bin/evaluate" -help >help.txt 2>&1 || fail "-help"
for option in output problems sizes meshes controllers policies accuracies errors reactions tolerances steps repetitions reference_steps spread \
  max_attempts time_limit list repeat_failed quick; do
  grep -q -e "-evaluate_$option" help.txt || fail "-evaluate_$option is not in -help"
done

# ---- the whole study by its command, on what is there already ----
cp "$source/output/RESULTS.md" page.md
MESHES=3 POLICIES=$policy TOLERANCES=1,10,100,1000 STEPS=20,100 REFERENCE_STEPS=600 BUILD=$SLIPSTEP_BUILD \
  FIGURES=figures PAGE=page.md "$source/output/study.sh" a.h5 >study.txt 2>&1 || fail "study.sh: $(tail -3 study.txt)"
[ "$(find figures -name 'study_*.png' -size +2k | wc -l)" = 11 ] || fail "not 11 figures: $(ls -l figures)"
grep -Eq '^\| `fault` \| 2 of 2 \| [0-9]+ to [0-9]+ \| [0-9.]+ % \| \*\*[0-9.]+\*\*' page.md || fail "no ratio at equal accuracy: $(head -25 page.md)"
"$SLIPSTEP_PYTHON" "$source/src/package/program.py" plot-study twin/fault.h5 --figures figures >plot.txt 2>&1 && fail "draws a policy"
grep -q "^slipstep plot-study: twin/fault.h5: " plot.txt || fail "no message of another file: $(cat plot.txt)"
exit $failed
