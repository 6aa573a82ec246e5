#!/usr/bin/env bash
# From clone to picture: installs what is missing (Debian 12 and 13, Ubuntu 24.04), builds into build/, simulates the
# 3 km fault on 50 x 50 cells by default (a trained policy, steps that are explicit or implicit), by the same steps under
# the best classical controller, and by implicit steps alone, and compares with a stored fine run.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

reference=examples/reference/fault_50x50_3km.h5
figure=output/quickstart.png

# simulate NAME OPTION...: one run on two ranks, its output in output/quickstart_NAME.h5
simulate() {
  local name=$1
  shift
  set -- mpirun -n 2 build/bin/fault -options_file examples/fault_3km.opts "$@" -fault_output "output/quickstart_$name.h5" -fault_output_fields slip_rate
  printf '\n\n== %s ==\n%s\n\n' "$name" "$*"
  "$@"
}

slipstep_setup
# no tests in a new build; one that has them keeps them
options=()
[ -e build/CMakeCache.txt ] || options=(-DBUILD_TESTING=OFF)
slipstep_build build "${options[@]}"
simulate rl
simulate dsp -ts_adapt_type dsp -ts_bathe_method auto -ts_rtol 1e-2
simulate rl_implicit -ts_bathe_method implicit

printf '\n\n== 3 km fault, 50 x 50 cells ==\n\n'
slipstep compare --reference "$reference" --figure "$figure" \
  rl=output/quickstart_rl.h5 dsp=output/quickstart_dsp.h5 "rl, implicit=output/quickstart_rl_implicit.h5"
