#!/usr/bin/env bash
# -log_view has the stages and events of a run with counts that agree with what the run did; -fault_view tells of the
# operators, their memory and the cache.
set -uo pipefail
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
fault=$SLIPSTEP_BUILD/bin/fault
policy=(-ts_adapt_type rl -ts_adapt_rl_policy "$SLIPSTEP_SOURCE/training/policies/fault.h5" -ts_adapt_rl_strict)
run() { "$@" >log 2>&1 || { cat log; exit 1; }; }

run "$fault" -fault_nx 20 -fault_nz 20 -mat_slipsqrtm_setup sketch "${policy[@]}" -fault_output fft.h5 -log_view :fft.log
run mpirun --oversubscribe -n 2 "$fault" -fault_nx 20 -fault_nz 20 -mat_slipsqrtm_setup sketch "${policy[@]}" -fault_output two.h5 -log_view :two.log
run "$fault" -fault_nx 8 -fault_nz 8 "${policy[@]}" -fault_output dense.h5 -log_view :dense.log
run "$fault" -fault_nx 8 -fault_nz 8 -fault_operator hmat -fault_viscosity lanczos -ts_max_time 4 -ts_bathe_method implicit -fault_output hmat.h5 \
  -log_view :hmat.log
run "$fault" -fault_nx 8 -fault_nz 8 -snes_type projection -ts_adapt_type heuristic -ts_max_time 1 -fault_output projection.h5 -log_view :projection.log
for i in 1 2 3; do (while :; do :; done) & load[i]=$!; done
run "$fault" -fault_nx 8 -fault_nz 8 "${policy[@]}" -fault_output loaded.h5
kill "${load[@]}"
"$SLIPSTEP_PYTHON" - <<'P' || failed=1
import re
import sys
import h5py

failed = False

def check(good, text):
    global failed
    if not good:
        failed = True
        print("FAILED: " + text)

def counts(log):
    """{stage: {event: (count, flops)}}; PETSc numbers the stages and says so again where it lists objects."""
    stages, current = {}, None
    with open(log) as f:
        for line in f:
            if line.startswith("Object Type"):
                break
            if match := re.match(r"--- Event Stage \d+: (.*)", line):
                current = stages.setdefault(match[1].strip(), {})
            elif current is not None and (match := re.match(r"(\S+) +(\d+) +\S+ +\S+ +\S+ +(\S+)", line)):
                current[match[1]] = int(match[2]), float(match[3])
    return stages

for name in ("fft", "two", "dense", "hmat", "projection"):
    stages = counts(name + ".log")
    with h5py.File(name + ".h5") as f:
        result, columns = dict(f["result"].attrs), {name: f["steps"][name][...] for name in ("products_k", "products_h", "products_pc")}
    check(all(stage in stages for stage in ("Slip set-up", "Slip run", "Slip output")), f"{name}: stages {list(stages)}")
    if failed:
        break
    setup, run, output = (stages[s] for s in ("Slip set-up", "Slip run", "Slip output"))
    count = lambda stage, event: stage.get(event, (0, 0))[0]
    flops = lambda stage, event: stage.get(event, (0, 0))[1]
    attempts, accepted = result["accepted"] + result["rejected"], result["accepted"]
    check(count(setup, "SlipKSetUp") == 1 and count(setup, "SlipHSetUp") == 1, f"{name}: set-up of K and H once, in its stage")
    check(count(setup, "SlipKMult") >= 3, f"{name}: the start solves with K")
    # an evaluation has one product with B; right-hand sides and linear iterations have more
    evaluations = count(run, "SlipCone")
    check(evaluations >= result["newton_iterations"] + 2 * result["solves"], f"{name}: {evaluations} evaluations of the cone")
    # (or know it)
    check(0 < count(run, "SlipBMult") <= evaluations + result["linear_iterations"], f"{name}: {count(run, 'SlipBMult')} products with B")
    check(count(run, "SlipKMult") >= 2 * result["solves"], f"{name}: a product with K for each stage")
    check(count(run, "SlipHMult") + count(run, "SlipBMult") >= result["solves"], f"{name}: a product with H for each step")
    # attempts have the products of the run; with those of output and estimates they are the events of K, and of B where it has them at once
    for column, rows in columns.items():
        check(rows.sum() == result[column], f"{name}: {column} {result[column]:.0f} of {rows.sum()} in the attempts")
    # (some of set-up is made when it is needed first)
    found, fused = sum(count(stage, "SlipKMult") for stage in (setup, run, output)), name != "hmat"
    told = result["products"] + result["products_k_setup"]
    check(told == found + fused * count(run, "SlipBMult"), f"{name}: {told:.0f} products with K, events {found}")
    check(result["products_h"] == count(run, "SlipHMult") + fused * count(run, "SlipBMult"), f"{name}: {result['products_h']:.0f} products with H")
    check(result["products_pc"] == (count(run, "SlipPCApply") if name in ("fft", "two", "dense") else 0), f"{name}: {result['products_pc']:.0f} times the preconditioner")
    check(name == "hmat" or result["products_k_setup"] == count(setup, "SlipKMult"), f"{name}: {result['products_k_setup']:.0f} products of set-up")
    for event in ("SlipKMult", "SlipHMult", "SlipBMult"):
        check(flops(run, event) > 0, f"{name}: {event} counts no flops")
    # the policy chooses the first step, and one after each attempt
    want = attempts + 1 if name != "projection" else 0
    for event in ("SlipPolicy", "SlipObserve"):
        check(count(run, event) == want, f"{name}: {event} {count(run, event)} times, {want} expected")
    # opening, a row of each attempt, a row and the fields of each accepted step, the start's fields, the end
    want = 1 + attempts + 2 * accepted + 1 + 1
    found = count(output, "SlipOutput")
    check(found == want, f"{name}: {found} pieces of output, {want} expected")
    check(not any(e.startswith("SlipOutput") for e in run), f"{name}: output has a stage of its own")
    if name in ("fft", "two"):
        check(count(run, "SlipPCApply") >= result["linear_iterations"] - 2 * result["newton_iterations"] > 0 and
              0 < count(run, "SlipPCSetUp") <= count(run, "PCSetUp"), f"{name}: {run.get('SlipPCApply')}, {run.get('SlipPCSetUp')}")
# Counts are those of one rank where steps are
with h5py.File("fft.h5") as one, h5py.File("two.h5") as two:
    for column in ("solves", "products_k", "products_h", "products_pc"):
        check((one["steps"][column][...] == two["steps"][column][...]).all(), f"two ranks have other {column} than one")
    for file in (one, two):
        rows, r = file["steps/cost"][...], file["result"].attrs
        # costs are multiples of 2^-30 s, whose sums have no rounding
        check((rows > 0).all() and rows.sum() + r["cost_setup"] + r["cost_output"] == r["cost"], f"cost {r['cost']} s, {rows.sum()} s of attempts")
# The same run costs the same to the bit, whatever else the machine does. Of processor time it is what the processor of the prices takes: others take
# from a third to three times as long, beside other work half as much again.
with h5py.File("dense.h5") as one, h5py.File("loaded.h5") as two:
    same = lambda path: one[path][...].tobytes() == two[path][...].tobytes()
    r, q = one["result"].attrs, two["result"].attrs
    check(same("steps/cost") and all(r[name] == q[name] for name in ("cost", "cost_setup", "cost_output")), f"a loaded machine: {q['cost']} s, not {r['cost']} s")
    check(0.2 < r["cost"] / r["processor_time"] < 5, f"cost {r['cost']} s, processor time {r['processor_time']} s")
# A dense product is 2 N^2 - N flops.
dense = counts("dense.log")["Slip run"]["SlipKMult"]
check(abs(dense[1] / (dense[0] * 64 * 127) - 1) < 1e-2, f"dense: {dense[1]} flops in {dense[0]} products with K of 64 rows")
sys.exit(failed)
P

# The operators of a view, from rank counts 1 and 2; 1600 cells.
grid=(-fault_nx 40 -fault_nz 40 -ts_max_time 0.1 -fault_view)
run "$fault" "${grid[@]}" -fault_operator dense && mv log dense1
run mpirun --oversubscribe -n 2 "$fault" "${grid[@]}" -fault_operator dense && mv log dense2
run mpirun --oversubscribe -n 2 "$fault" "${grid[@]}" && mv log fft2
run "$fault" "${grid[@]}" && mv log fft1
run "$fault" -fault_nx 30 -fault_nz 30 -fault_operator hmat -ts_max_time 0.1 -fault_view && mv log hmat1
slides=(-fault_friction_law rate_and_state -fault_friction_slip 0.1 -fault_initial_rate 1e-9 -fault_depth_top 1e3)
run "$fault" "${grid[@]}" "${slides[@]}" -fault_dip 30 && mv log kn1
run mpirun --oversubscribe -n 2 "$fault" "${grid[@]}" "${slides[@]}" -fault_dip 90 && mv log slides2
expect() { grep -qE -- "$2" "$1" || { echo "FAILED: no line \"$2\" in $1:"; cat "$1"; failed=1; }; }
expect dense1 "cells: 1600 on 1 ranks, 1600 to 1600 on each"
expect dense2 "cells: 1600 on 2 ranks, 800 to 800 on each"
expect dense1 "stiffness K: seqdense \(dense as asked\)"
expect dense1 "memory of K: $((8 * 1600 * 1600)) bytes \(20.5 MB\) at most on a rank, 20.5 MB in all, 100.00 %"
expect dense2 "memory of H: $((4 * 1600 * 1600)) bytes \(10.2 MB\) at most on a rank, 20.5 MB in all, 100.00 %"
expect fft1 "stiffness K: slipfft \(auto: a uniform grid of more than 256 cells\)"
expect fft1 "viscosity H: [a-z]+ \(sqrtm"
expect fft1 "memory of K: [1-9][0-9]+ bytes"
expect fft1 "memory of the preconditioner, .* bytes"
expect kn1 "normal stress of slip Kn: slipdippingfft"
expect kn1 "memory of Kn, beside K: [1-9][0-9]+ bytes"
expect slides2 "memory of K: [1-9][0-9]+ bytes"
expect slides2 "memory of H: 0 bytes" # radiation damping is one number
expect hmat1 "stiffness K: sliphmat \(hmat as asked\)"
expect hmat1 "memory of K: [0-9]+ bytes .* [0-9.]+ % of a dense matrix"
# Where the time went, at the end: shares of the whole, by the clock and by cost
"$SLIPSTEP_PYTHON" - <<'P' || failed=1
import re
import sys

names = ["set-up", "products", "direct solves", "cells", "observation", "output"]
for file in ("dense1", "fft2", "hmat1"):
    with open(file) as view:
        text = view.read().partition("where the time of the run went")[2]
    rows = {name: [float(x) for x in numbers] for name, *numbers in re.findall(r"^ +([a-z -]+?) +([\d.]+) +([\d.]+) % +([\d.]+) +([\d.]+) %$", text, re.M)}
    whole = re.search(r"^ +all +([\d.]+) +([\d.]+)$", text, re.M)
    good = list(rows) == names and whole and all(rows[name][i] > 0 for name in ("set-up", "products", "cells") for i in (0, 2))
    for column, total in ((0, 1), (2, 2)) if good else ():  # rounded to 1e-4 s and 0.01 %
        good = good and abs(sum(row[column] for row in rows.values()) - float(whole[total])) < 1e-3 and abs(sum(row[column + 1] for row in rows.values()) - 100) < 0.1
    if not good:
        print(f"FAILED: shares of time in {file}: {rows}, {whole and whole.groups()}")
        sys.exit(1)
P
# A rupture whose stages are solved directly, on a few cells' rows
run "$fault" -fault_nx 12 -fault_nz 12 -fault_viscosity radiation -fault_inertia no -fault_initial traction -fault_initial_traction 30.5e6 -fault_initial_unstable -fault_normal_stress 50e6 \
  -fault_normal_stress_gradient 0 -ts_type bathe -ts_max_time 1 -fault_view -log_view :direct.log && mv log direct1
expect direct.log "^SlipDirect +[1-9]"
expect direct1 "^ +direct solves +[0-9.]+ +[0-9.]+ % +0[.]000*[1-9]"
for file in dense1 fft1 fft2 hmat1; do expect $file "memory of the process after set-up: [0-9.]+ MB at most on a rank"; done
exit $failed
