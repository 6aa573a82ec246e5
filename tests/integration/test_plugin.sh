#!/usr/bin/env bash
# The library as a plugin: a PETSc program that knows nothing of SlipStep runs -ts_type bathe -ts_adapt_type rl.
set -euo pipefail
build=${SLIPSTEP_BUILD:?} source=${SLIPSTEP_SOURCE:?} python=${SLIPSTEP_PYTHON:-python3}
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"

[ -e "$build/lib/libslipstep.so" ] || exit 77 # BUILD_SHARED_LIBS=OFF

# PETSc as CMake found it
petsc=$(sed -n 's/^PETSC_LIBDIR:INTERNAL=//p' "$build/CMakeCache.txt" | head -n 1)
export PKG_CONFIG_PATH="$petsc/pkgconfig${PKG_CONFIG_PATH:+:$PKG_CONFIG_PATH}"
pc=PETSc # Debian; PETSc's own name is petsc
pkg-config --exists "$pc" || pc=petsc
pkg-config --exists "$pc" || { echo "pkg-config does not find PETSc in $petsc/pkgconfig"; exit 1; }
if grep '#include' "$source/tests/plugin/ode.c" | grep -qi slip; then echo "ode.c must not include SlipStep"; exit 1; fi
read -ra flags <<< "$(pkg-config --cflags --libs "$pc")"
"${MPICC:-mpicc}" -o ode "$source/tests/plugin/ode.c" "${flags[@]}" -Wl,-rpath,"$petsc" -lm
if ldd ode | grep -q slipstep; then echo "ode links SlipStep"; exit 1; fi

# A policy that answers h = 0.02 (1 - time/5) + 0.01 approximately: it observes time_fraction and state_0 only.
"$python" - <<'P'
import h5py, numpy as np
with h5py.File("policy.h5", "w") as f:
    f.attrs.update({"format": "slipstep-policy", "version": 1, "algorithm": "by hand"})
    f["observation/names"] = np.array(["time_fraction", "state_0", "energy"], dtype=h5py.string_dtype())
    f["observation/scale"] = np.ones(3)
    f["observation/offset"] = np.zeros(3)
    f["layers/0/weight"] = np.array([[-1.0, 0.1, 0.01]])
    f["layers/0/bias"] = np.array([0.2])
    f["layers/0"].attrs["activation"] = "tanh"
    f.create_group("action").attrs.update({"low": -1.0, "high": 1.0, "squash": "tanh", "dt_min": 0.005, "dt_max": 0.03,
                                           "dt_min_unit": "s", "dt_max_unit": "s"})
P
plugin=(-dll_prepend "$build/lib/libslipstep.so")
# Reference: PETSc's own Runge-Kutta at tolerances far below the 1e-4 that is asked of bathe.
./ode -ts_type rk -ts_rk_type 5dp -ts_adapt_type basic -ts_rtol 1e-12 -ts_atol 1e-12 > reference
./ode "${plugin[@]}" -ts_type bathe -ts_adapt_type rl -ts_adapt_rl_policy policy.h5 -ts_view > out
./ode "${plugin[@]}" -ts_type theta -ts_theta_theta 0.5 -ts_adapt_type rl -ts_adapt_rl_policy policy.h5 > theta
./ode "${plugin[@]}" -ts_type rk -ts_adapt_type heuristic -ts_rtol 1e-8 -ts_atol 1e-8 > rk
./ode "${plugin[@]}" -ts_type bdf -ts_adapt_type pi -ts_rtol 1e-7 -ts_atol 1e-7 > bdf
grep -q 'type: bathe' out && grep -q 'type: rl' out && grep -q 'policy: policy.h5, hash' out
cat reference out theta rk bdf | grep '^time'

# Order 2 with h <= 0.03 over 5 s of a solution with derivatives up to about 10: error below h^2 * 10 / 12 * e^1 = 2e-3.
"$python" - <<'P'
def end(name):
    words = [line for line in open(name) if line.startswith("time ")][0].split()
    return float(words[1]), int(words[3]), float(words[5]), float(words[7])
t, n, x, y = end("reference")
for name, tolerance in (("out", 2e-3), ("theta", 2e-3), ("rk", 1e-4), ("bdf", 1e-3)):
    got = end(name)
    assert abs(got[0] - 5) < 1e-6, (name, got)
    assert max(abs(got[2] - x), abs(got[3] - y)) < tolerance, (name, got, (x, y))
steps = end("out")[1]
assert 5 / 0.03 <= steps <= 5 / 0.005, steps
P

if SLIPSTEP_POLICY_DIR=nowhere ./ode "${plugin[@]}" -ts_type bathe -ts_adapt_type rl > none 2>&1; then
  echo "rl without a policy must fail"
  exit 1
fi
grep -q 'ts_adapt_rl_policy' none

# The stiff oscillator, whose stages fail where it jumps: bathe repeats them under every controller, from any first step, and
# ends only where a limit was given. The time of the jump is late by what steps of the tolerance sum up to: 9e-4 y/s, 10 s of
# a period of 1614 s at the default tolerance, a tenth of that at 1e-6.
stiff=(./ode "${plugin[@]}" -mu 1000 -ts_max_time 2000)
./ode -mu 1000 -ts_max_time 2000 -ts_type arkimex -ts_arkimex_fully_implicit -ts_rtol 1e-9 -ts_atol 1e-9 -ts_max_snes_failures -1 > reference
for type in heuristic pi dsp basic rl; do
  for options in "" "-ts_dt 1000" "-ts_rtol 1e-6 -ts_atol 1e-6"; do
    read -ra words <<< "$options"
    echo "$("${stiff[@]}" -ts_type bathe -ts_adapt_type $type "${words[@]}" 2>&1 | tail -n 1) $type $options" >> stiff
  done
done
"$python" - <<'P'
want = float(open("reference").read().split()[5])
for line in open("stiff"):
    print(line, end="")
    words = line.split()
    assert words[0] == "time" and abs(float(words[1]) - 2000) < 1e-6, line
    assert abs(float(words[5]) - want) < (1e-3 if "-ts_rtol" in words else 1e-2), (line, want)
P
"${stiff[@]}" -ts_type bathe -ts_adapt_type heuristic -ts_max_snes_failures 2 > limit 2>&1 && { echo "-ts_max_snes_failures has no effect"; exit 1; }
grep -q DIVERGED_NONLINEAR_SOLVE limit
"${stiff[@]}" -ts_type bathe -ts_adapt_type pi -ts_dt 1000 -ts_max_reject 3 > limit 2>&1 && { echo "-ts_max_reject has no effect"; exit 1; }
grep -q DIVERGED_STEP_REJECTED limit
# Constant steps that cannot be taken become shorter, are said once, and grow back: a hundred of them and some about the jump.
"${stiff[@]}" -ts_type bathe -ts_adapt_type none -ts_dt 20 > out 2> err
[ "$(grep -c 'warning: a constant step of 20 s' err)" = 1 ] || { cat err; exit 1; }
awk '$1 == "time" { exit !($2 == 2000 && $4 < 500) }' out || { cat out; exit 1; }
# A dial that nothing follows is named, once.
./ode "${plugin[@]}" -ts_type bathe -ts_adapt_type rl -ts_adapt_rl_accuracy 1e-3 > out 2> err
[ "$(grep -c 'ode: warning: -ts_adapt_rl_accuracy 0.001 .*/ode.h5 .*log_accuracy' err)" = 1 ] || { cat err; exit 1; }
./ode "${plugin[@]}" -ts_type bathe -ts_adapt_type rl > out 2> err
[ ! -s err ] || { cat err; exit 1; }

# A program that runs already: -dll_prepend comes too late, PetscDLLibraryAppend() does not.
cat >late.c <<'C'
#include <petscts.h>

int main(int argc, char **argv)
{
  TS ts;

  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(PetscDLLibraryAppend(PETSC_COMM_WORLD, &PetscDLLibrariesLoaded, getenv("LIBRARY")));
  PetscCall(TSCreate(PETSC_COMM_WORLD, &ts));
  PetscCall(TSSetType(ts, "bathe"));
  PetscCall(TSDestroy(&ts));
  PetscCall(PetscFinalize());
  return 0;
}
C
"${MPICC:-mpicc}" -o late late.c "${flags[@]}" -Wl,-rpath,"$petsc" -lm
LIBRARY=$build/lib/libslipstep.so ./late > late.txt 2>&1 || { cat late.txt; echo "PetscDLLibraryAppend() does not load the library"; exit 1; }
if "$python" -c 'import petsc4py' 2>/dev/null; then
  "$python" - "$build/lib/libslipstep.so" <<'P'
import ctypes, sys
from petsc4py import PETSc
assert ctypes.CDLL(sys.argv[1]).SlipStepInitializePackage() == 0
ts = PETSc.TS().create()
ts.setType("bathe")
assert ts.getType() == "bathe"
P
fi
