#!/bin/bash
# The programs sliding_mode, circuit and oscillator: every controller, the layout of their files, errors recomputed from
# the files with independent exact solutions, and messages for wrong use.
set -u
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"
"$SLIPSTEP_PYTHON" -c "import h5py, numpy" || exit 77

# run NAME PROGRAM ARGUMENTS...: writes NAME.h5, must succeed without warnings
run() {
  local name=$1 program=$2
  shift 2
  if ! timeout $hang "$bin/$program" "-${program}_output" "$name.h5" "$@" >"$name.txt" 2>"$name.err" || [ -s "$name.err" ]; then
    fail "$program $*: $(cat "$name.err")"
  fi
}

# Policies that look at their problem: the step grows as the state falls.
"$SLIPSTEP_PYTHON" - <<'PY' || failed=1
import h5py
import numpy as np

def policy(path, problem, names, weight, bias, low, high):
    with h5py.File(path, "w") as f:
        f.attrs.update({"format": "slipstep-policy", "version": 1, "problem": problem, "algorithm": "by hand"})
        names_type = h5py.string_dtype()
        f.create_dataset("observation/names", data=np.array(names, dtype=object), dtype=names_type)
        f["observation/scale"], f["observation/offset"] = np.ones(len(names)), np.zeros(len(names))
        layer = f.create_group("layers/0")
        layer["weight"], layer["bias"] = np.array([weight], dtype=float), np.array([bias], dtype=float)
        layer.attrs["activation"] = "linear"
        f.create_group("action").attrs.update({"low": 0.0, "high": 1.0, "squash": "tanh", "dt_min": low, "dt_max": high,
                                               "dt_min_unit": "s", "dt_max_unit": "s"})
        f["range/minimum"], f["range/maximum"] = -10 * np.ones(len(names)), 10 * np.ones(len(names))

policy("sliding_mode.h5", "sliding_mode", ["state_0", "energy", "velocity"], [-1, -1, -1], 0.5, 1e-4, 2e-3)
policy("circuit.h5", "circuit", ["state_0", "state_1", "state_2", "energy"], [0, 0, 0, -1], 0.0, 1e-3, 2e-2)
policy("oscillator.h5", "oscillator", ["state_1", "converged"], [0, -0.5], 0.0, 1e-3, 2e-2)
PY

for program in sliding_mode circuit oscillator; do
  for controller in heuristic pi basic dsp none rl; do
    more=()
    [ $controller = rl ] && more=(-ts_adapt_rl_policy "$program.h5")
    [ $program = circuit ] && more+=(-circuit_reference 1e-3)
    run "$program-$controller" $program -ts_adapt_type $controller "${more[@]}"
  done
done
run sliding_mode-training sliding_mode -sliding_mode_case training
run circuit-training circuit -circuit_case training -circuit_reference 1e-3
run oscillator-fine oscillator -ts_adapt_type none -ts_dt 1e-3
run oscillator-renamed oscillator -ts_adapt_type none -ts_time_step 1e-3 # as PETSc 3.25 calls it

"$SLIPSTEP_PYTHON" - <<'PY' || failed=1
import math
import sys
import h5py
import numpy as np

trapezoid = getattr(np, "trapezoid", None) or np.trapz  # named so from NumPy 2 on

def root(f, a, b):
    """Zero of f, which changes sign between a and b, by bisection to rounding"""
    low = f(a)
    for _ in range(100):
        c = 0.5 * (a + b)
        a, b = (c, b) if (f(c) > 0) == (low > 0) else (a, c)
    return 0.5 * (a + b)

bad = 0
def check(name, truth, text):
    global bad
    if not truth:
        print(f"FAILED: {name}: {text}")
        bad = 1

STEPS = {"time", "dt", "accepted", "error", "converged", "newton_iterations", "linear_iterations", "solves", "residual", "right_hand_sides",
         "method", "products_k", "products_h", "products_pc", "cost", "reason", "wall"}
SERIES = {"sliding_mode": {"w", "reaction", "energy", "exact", "exact_reaction"},
          "circuit": {"V1", "V2", "i", "reaction", "energy"}, "oscillator": {"v", "x", "reaction", "energy"}}
RESULT = {"accepted", "rejected", "solves", "newton_iterations", "linear_iterations", "wall_time_setup", "wall_time_solve"}

def read(name):
    """Series as a dict, after checks of the layout that all programs share"""
    with h5py.File(name + ".h5") as f:
        steps, series = f["steps"], f["series"]
        accepted = steps["accepted"][()].astype(bool)
        check(name, set(steps) == STEPS, f"/steps has {sorted(steps)}")
        check(name, set(series) == SERIES[name.split("-")[0]] | {"time"}, f"/series has {sorted(series)}")
        check(name, all("units" in series[k].attrs for k in series), "a dataset of /series has no units")
        check(name, RESULT <= set(f["result"].attrs), f"/result has {sorted(f['result'].attrs)}")
        check(name, f["result"].attrs["accepted"] == accepted.sum() == len(series["time"]) - 1, "accepted steps differ")
        check(name, f["result"].attrs["rejected"] == (~accepted).sum(), "rejected steps differ")
        check(name, series["time"][0] == steps["time"][0] and np.allclose(series["time"][1:], (steps["time"][()] + steps["dt"][()])[accepted], rtol=1e-12), "times differ")
        controller = f["run"].attrs["ts_adapt_type"]
        controller = controller.decode() if isinstance(controller, bytes) else controller
        check(name, ("policy_hash" in f["run"].attrs) == (controller == "rl"), f"policy of {controller} in /run")
        return {k: series[k][()] for k in series}, dict(f["result"].attrs)

def sliding_mode(case, names):
    """The disturbance is weaker than the gain, so w slides once to zero and stays: closed form and one root"""
    D, start = {"training": (1.5, 0.1), "evaluation": (1.75, 0.15)}[case]
    k, omega = 2.0, 50.0
    slide = lambda t: start + D / omega * (1 - np.cos(omega * t)) - k * t
    arrest = root(slide, 0, 1)
    for name in names:
        s, result = read("sliding_mode-" + name)
        t, w, r = s["time"], s["w"], s["reaction"]
        exact = np.where(t < arrest, slide(t), 0)
        # to the bisection's and the cosine's rounding
        check(name, np.abs(exact - s["exact"]).max() < 1e-14, "the exact solution differs")
        e2 = np.concatenate([[0], (w - exact) ** 2])
        l2 = math.sqrt(trapezoid(e2, np.concatenate([[0], t])) / t[-1])
        check(name, abs(l2 - result["l2_error"]) < 1e-9 * l2, f"L2 error {result['l2_error']} instead of {l2}")
        check(name, w[-1] == 0 and abs(r[-1] + D * math.sin(omega * t[-1])) < 1e-12, f"the end is {w[-1]}, {r[-1]}")
        check(name, (np.abs(r) <= k).all() and (r[w != 0] == -k * np.sign(w[w != 0])).all(), "reaction outside its law")
        # no error beyond what one largest step travels
        h = np.diff(np.concatenate([[0], t]))
        check(name, np.abs(w - exact).max() < (k + D) * h.max(), f"largest error {np.abs(w - exact).max()}")

def circuit(names):
    for name in names:
        s, result = read("circuit-" + name)
        m = 0.8
        energy = (s["V1"] ** 2 / 9 + s["V2"] ** 2 + s["i"] ** 2 / 7) / 2
        check(name, np.allclose(energy, s["energy"], rtol=1e-12), "energy differs")
        check(name, (np.diff(energy) <= 1e-12 * energy[0]).all(), "energy rises")
        check(name, energy[-1] < 1e-2 * energy[0], f"energy is left: {energy[-1]} of {energy[0]}")
        V1, r = s["V1"], s["reaction"]
        check(name, (np.abs(r) <= m).all() and (r[V1 != 0] == -m * np.sign(V1[V1 != 0])).all(), "reaction outside its law")
        # tolerances of 1e-6 with thousands of steps, or a policy with 2e-2 s in a circuit of R C1 = 0.16 s:
        # (0.02/0.16)^2 = 1.6 %
        check(name, result["l2_error"] < (2e-2 if name == "rl" else 1e-3), f"relative L2 error {result['l2_error']}")

def oscillator(names):
    """Amplitudes fall by 2 mu N/k a half cycle; the mass sticks where k |x| <= mu N"""
    m, k, q, start = 1.0, 40.0, 3.0, 1.0
    expected = [start]
    while k * abs(expected[-1]) > q:
        expected.append(math.copysign(2 * q / k, expected[-1]) - expected[-1])
    half = math.pi * math.sqrt(m / k)
    for name in names:
        s, result = read("oscillator-" + name)
        t, v, x, r = s["time"], s["v"], s["x"], s["reaction"]
        fine = name == "fine"
        # a turn within a step of 1e-3 s hides k/m |x| h^2/8 = 5e-6 m; phase errors of second order are as small
        for n in range(len(expected) - 1):
            at = np.abs(t - n * half) < half / 4 if n else t < half / 4
            peak = x[at][np.argmax(np.abs(x[at]))]
            if fine:
                check(name, abs(peak - expected[n]) < 3e-5, f"turn {n} at {peak} instead of {expected[n]} m")
        limit = 3e-5 if fine else 3e-3  # 40 cm travelled at tolerances of 1e-4, with a safety of several
        check(name, abs(x[-1] - expected[-1]) < limit, f"rests at {x[-1]} instead of {expected[-1]} m")
        check(name, v[-1] == 0 and k * abs(x[-1]) <= q, "does not rest within the cone")
        check(name, abs(r[-1] - k * x[-1]) < 1e-9, "the reaction does not hold the spring")
        rest = t > (len(expected) - 1) * half + 0.1
        check(name, (v[rest] == 0).all() and np.ptp(x[rest]) == 0, "moves after it has come to rest")
        check(name, abs(result["x_error"] - abs(x[-1] - expected[-1])) < 1e-12, "the error printed differs")

controllers = ["heuristic", "pi", "basic", "dsp", "none", "rl"]
sliding_mode("evaluation", controllers)
sliding_mode("training", ["training"])
circuit(controllers + ["training"])
oscillator(controllers + ["fine"])
check("renamed", np.array_equal(read("oscillator-fine")[0]["x"], read("oscillator-renamed")[0]["x"]), "-ts_time_step is not -ts_dt")
sys.exit(bad)
PY

grep -q "^L2 error: " sliding_mode-pi.txt && grep -q "^relative L2 error: " circuit-pi.txt || fail "no error in the summary"
"$SLIPSTEP_PYTHON" -c 'import h5py; h5py.File("old.h5", "w")["older"] = 1'
cp old.h5 reference
refuses later "for -sliding_mode_case" -- "$bin/sliding_mode" -sliding_mode_case later
refuses "-sliding_mode_start is 0" -- "$bin/sliding_mode" -sliding_mode_start 0
refuses "-sliding_mode_frequency is -1" -- "$bin/sliding_mode" -sliding_mode_frequency -1
refuses "-ts_type theta" -- "$bin/sliding_mode" -ts_type theta -sliding_mode_output old.h5
refuses "-sliding_mode_start is nan" -- "$bin/sliding_mode" -sliding_mode_start nan
refuses "-sliding_mode_amplitude is nan" -- "$bin/sliding_mode" -sliding_mode_amplitude nan
refuses "-ts_max_time is -1" -- "$bin/sliding_mode" -ts_max_time -1
refuses "-ts_max_time is 0.5" -- "$bin/sliding_mode" -ts_init_time 2
refuses "-ts_max_time is -1" -- "$bin/oscillator" -ts_max_time -1
refuses "$dt is nan" -- "$bin/oscillator" -ts_dt nan
refuses "$dt is -1" -- "$bin/circuit" -ts_dt -1
refuses "-ts_rtol is -1" -- "$bin/circuit" -ts_rtol -1
refuses sliding_mode.h5 "problem sliding_mode" circuit -- "$bin/circuit" -ts_adapt_type rl \
  -ts_adapt_rl_policy sliding_mode.h5 -circuit_output old.h5
refuses "-circuit_c1 is 0" -- "$bin/circuit" -circuit_c1 0
refuses "-circuit_start has 2 numbers" -- "$bin/circuit" -circuit_start 1,2
refuses "-circuit_reference is -1" -- "$bin/circuit" -circuit_reference -1
refuses "-circuit_unit start" -circuit_start -- "$bin/circuit" -circuit_start 1,0,1 -circuit_unit start
refuses "none.h5" -- "$bin/circuit" -ts_adapt_type rl -ts_adapt_rl_policy none.h5
refuses state_1 -- "$bin/sliding_mode" -ts_adapt_type rl -ts_adapt_rl_policy circuit.h5 \
  -ts_adapt_rl_problem circuit
refuses "-oscillator_stiffness is 0" -- "$bin/oscillator" -oscillator_stiffness 0
refuses "-oscillator_mass is -1" -- "$bin/oscillator" -oscillator_mass -1
refuses ">= 0 N" -- "$bin/oscillator" -oscillator_normal -1
cmp -s old.h5 reference || fail "an older file was touched"

# The rows of an unfinished run are kept, and given up by the option that the message names.
for program in circuit sliding_mode; do
  run=("$bin/$program" -ts_max_time 0.1 "-${program}_output" kept.h5)
  "${run[@]}" >/dev/null && mv kept.h5 kept.h5.part || fail "${run[*]}"
  "${run[@]}" >/dev/null 2>err.txt && fail "$program: an unfinished file was replaced"
  overwrite=$(grep -o -- "-[a-z_]*_overwrite" err.txt) && "${run[@]}" "$overwrite" >/dev/null && [ -e kept.h5 ] ||
    fail "$program: an unfinished file was not given up: $(cat err.txt)"
  rm -f kept.h5*
done
refuses "-circuit_reference?" -- "$bin/circuit" -circuit_refrence 1e-3
mpirun --oversubscribe -n 2 "$bin/oscillator" >out.txt 2>&1 && fail "oscillator on 2 processes"
grep -q "2 states .*not on 2" out.txt || fail "message on 2 processes"

[ $failed = 0 ] && echo "the example cases pass"
exit $failed
