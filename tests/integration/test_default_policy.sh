#!/usr/bin/env bash
# -ts_adapt_type rl without a policy finds the one of its problem: in the build tree, after an installation that was
# moved, through SLIPSTEP_POLICY_DIR, and as a plugin of a program that knows nothing of SlipStep. -ts_view names it;
# without one the error says how to.
set -euo pipefail
build=${SLIPSTEP_BUILD:?} source=${SLIPSTEP_SOURCE:?} python=${SLIPSTEP_PYTHON:-python3}
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"

fail() {
  echo "test_default_policy: $*" >&2
  exit 1
}
expect() { # expect FILE TEXT...: a run's output has every text
  local file=$1 text
  shift
  for text in "$@"; do grep -qF -- "$text" "$file" || { cat "$file"; fail "no \"$text\" in $file"; }; done
}
slip() { sed -n 's/^final mean slip: *\([^ ]*\).*/\1/p' "$1"; }
small=(-fault_nx 2 -fault_nz 2 -ts_adapt_type rl)

"$build/bin/fault" "${small[@]}" -ts_adapt_rl_policy "$source/training/policies/fault_products.h5" > named
"$build/bin/fault" "${small[@]}" -ts_view -fault_output run.h5 > tree
expect tree "policy: $(cd "$source" && pwd -P)/training/policies/fault_products.h5" "policy of the problem fault_products"
[ "$(slip tree)" = "$(slip named)" ] || fail "the default policy and the same one named give different runs"
"$python" -c "import h5py; p = h5py.File('run.h5')['run'].attrs['policy']; p = getattr(p, 'decode', lambda: p)(); assert p.endswith('policies/fault_products.h5'), p"

# Installed, and moved.
cmake --install "$build" --prefix "$work/first" > install.log
mv first moved
"$work/moved/bin/fault" "${small[@]}" -ts_view > installed
expect installed "policy: $work/moved/" "/slipstep/policies/fault_products.h5"
[ "$(slip installed)" = "$(slip named)" ] || fail "the installed default policy gives another run"
mpirun --oversubscribe -n 2 "$work/moved/bin/fault" "${small[@]}" -ts_view > ranks
expect ranks "policy: $work/moved/"

# Implicit steps have a policy of their own, which is named, too.
"$build/bin/fault" "${small[@]}" -ts_bathe_method implicit -ts_view > implicit
expect implicit "policies/fault.h5" "policy of the problem fault"
"$build/bin/fault" "${small[@]}" -ts_adapt_rl_policy "$source/training/policies/fault.h5" > its
[ "$(slip its)" = "$(slip implicit)" ] || fail "a policy of implicit steps takes others where it is named"

# A folder of the user's own goes first.
mkdir mine
cp "$source/training/policies/fault.h5" mine/fault.h5
SLIPSTEP_POLICY_DIR=$work/mine "$build/bin/fault" "${small[@]}" -ts_view > folder
expect folder "policy: $work/mine/fault.h5"

# As a plugin: the program names no problem, the option does.
petsc=$(sed -n 's/^PETSC_LIBDIR:INTERNAL=//p' "$build/CMakeCache.txt" | head -n 1)
export PKG_CONFIG_PATH="${PKG_CONFIG_PATH:+$PKG_CONFIG_PATH:}$petsc/pkgconfig"
pc=PETSc
pkg-config --exists "$pc" || pc=petsc
read -ra flags <<< "$(pkg-config --cflags --libs "$pc")"
"${MPICC:-mpicc}" -o ode "$source/tests/plugin/ode.c" "${flags[@]}" -Wl,-rpath,"$petsc" -lm
"$python" - "$(find "$work/moved" -name policies -type d)/oscillator.h5" <<'P'
import sys, h5py, numpy as np
with h5py.File(sys.argv[1], "w") as f:
    f.attrs.update({"format": "slipstep-policy", "version": 1, "algorithm": "by hand"})
    f["observation/names"] = np.array(["time_fraction", "state_0"], dtype=h5py.string_dtype())
    f["observation/scale"], f["observation/offset"] = np.ones(2), np.zeros(2)
    f["layers/0/weight"], f["layers/0/bias"] = np.array([[-1.0, 0.1]]), np.array([0.2])
    f["layers/0"].attrs["activation"] = "tanh"
    f.create_group("action").attrs.update({"low": -1.0, "high": 1.0, "squash": "tanh", "dt_min": 0.005, "dt_max": 0.03,
                                           "dt_min_unit": "s", "dt_max_unit": "s"})
P
plugin=(-dll_prepend "$(find "$work/moved" -name libslipstep.so)" -ts_type bathe -ts_adapt_type rl)
./ode "${plugin[@]}" -ts_adapt_rl_problem oscillator -ts_view > plugin
expect plugin "policy: $work/moved/" "policy of the problem oscillator"

# A problem without a name takes the general policy, as does one with a name that no file has.
./ode "${plugin[@]}" -ts_view > general
expect general "policy: $work/moved/" "policy of the problem ode"
mkdir only
cp "$source/training/policies/ode.h5" only
SLIPSTEP_POLICY_DIR=$work/only "$build/bin/sliding_mode" -ts_adapt_type rl -ts_view > own
expect own "policy: $work/only/ode.h5" "policy of the problem ode"

# Errors: one line that says how to name a policy.
if SLIPSTEP_POLICY_DIR=$work/nowhere ./ode "${plugin[@]}" > none 2>&1; then fail "a missing general policy must fail"; fi
expect none "$work/nowhere/ode.h5" "-ts_adapt_rl_policy <file.h5>"
SLIPSTEP_POLICY_DIR=$work/only "$build/bin/sliding_mode" -ts_adapt_type rl -ts_adapt_rl_problem fault > missing 2> message &&
  fail "a missing default that was asked for must fail"
expect message "problem fault, $work/only/fault.h5"
if SLIPSTEP_POLICY_DIR=$work/nowhere "$build/bin/fault" "${small[@]}" > missing 2> message; then fail "a missing default must fail"; fi
expect message "fault: error: -ts_adapt_type rl" "$work/nowhere/fault.h5" "-ts_adapt_rl_policy <file.h5>"
[ "$(grep -vc ': warning: ' message)" = 1 ] || { cat message; fail "expected one line"; }
SLIPSTEP_POLICY_DIR=$work/nowhere "$build/bin/sliding_mode" -ts_adapt_type rl > missing 2> message && fail "a missing default must fail"
expect message "problem sliding_mode, $work/nowhere/sliding_mode.h5"
SLIPSTEP_POLICY_DIR=$work/nowhere "$build/bin/circuit" -ts_adapt_type rl > missing 2> message && fail "a missing default must fail"
expect message "problem circuit, $work/nowhere/circuit.h5"
# Measured numbers are found likewise; a run that needs them ends without them, and takes no others.
folder=$(dirname "$(find "$work/moved" -name tolerances.h5)")
rm "$folder/tolerances.h5"
if "$work/moved/bin/fault" "${small[@]:0:4}" -ts_adapt_type pi > missing 2> message; then fail "missing tolerances must fail"; fi
expect message "fault: error: " policies/tolerances.h5 -fault_accuracy -ts_rtol
"$work/moved/bin/fault" "${small[@]:0:4}" -ts_adapt_type pi -ts_rtol 1e-3 > given || fail "-ts_rtol needs no tolerances"
rm "$folder/estimates.h5"
if "$work/moved/bin/fault" "${small[@]:0:4}" -ts_adapt_type pi -ts_rtol 1e-3 > missing 2> message; then fail "missing factors of estimates must fail"; fi
expect message "fault: error: " policies/estimates.h5
echo "default policies are found in the build tree, installed and as a plugin"
