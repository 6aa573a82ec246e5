#!/usr/bin/env bash
# The preset "sanitize": address and undefined-behaviour sanitizers on every C test and on short runs of the programs, in about
# six minutes on two idle cores, two of them for the build; .ci/run does it:
#   tests/sanitize.sh            (SLIPSTEP_BUILD_DIR chooses the build folder, default build-sanitize)
# The first finding ends its program with an error. Leaks are looked for by PETSc's -malloc_dump in the runs of the
# programs: all our memory is PETSc's, and the sanitizer's own list is full of what MPI keeps until the process ends.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

slipstep_setup libcmocka-dev
build=${SLIPSTEP_BUILD_DIR:-build-sanitize}
SLIPSTEP_SOURCE=$PWD
slipstep_build "$build" --preset sanitize -DBUILD_TESTING=ON -DSLIPSTEP_PYTHON="$SLIPSTEP_PYTHON"
export ASAN_OPTIONS=detect_leaks=0:detect_stack_use_after_return=1 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
export OPENBLAS_NUM_THREADS=1
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1

status=0
ran=$(cd "$build" && pwd -P)/tests.xml
rm -f "$ran"
ctest --test-dir "$build" --output-on-failure --no-tests=error -j 2 --output-junit "$ran" -L '^(unit|mpi)$' || status=1

room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
bin=$(cd "$build" && pwd)/bin # the folder may be named from here or from /
policy=$SLIPSTEP_SOURCE/training/policies/fault.h5
try() {
  if (cd "$room" && "$@" -malloc_dump >out 2>&1 && ! grep -q "^\[ *[0-9]*\] *[0-9]* bytes" out); then
    echo "clean: ${*/#$bin\//}"
  else
    echo "FAILED: $*"
    tail -40 "$room/out"
    status=1
  fi
}
mesh=(-fault_nx 8 -fault_nz 6 -fault_output run.h5)
for ranks in 1 2; do
  fault=(mpirun --oversubscribe -n $ranks "$bin/fault" "${mesh[@]}")
  try "${fault[@]}" -ts_adapt_type heuristic -fault_view
  try "${fault[@]}" -ts_adapt_type rl -ts_adapt_rl_policy "$policy" -ts_view
  try "${fault[@]}" -ts_adapt_type pi -ts_rtol 1e-2 -ts_bathe_error doubling -ts_bathe_reaction implicit -ts_max_time 5
  try "${fault[@]}" -ts_adapt_type none -ts_dt 0.5 -snes_type projection -fault_operator fft -fault_viscosity spectral
done
try "$bin/fault" -help
try "$bin/train" -train_steps 600 -train_progress 0 -train_output p.h5 -train_log l.h5 -train_checkpoint c.h5
try "$bin/train" -train_steps 700 -train_progress 0 -train_resume c.h5 -train_checkpoint c.h5
try "$bin/train" -train_steps 300 -train_progress 0 -train_random -train_reward accuracy -train_evaluate_interval 200 \
  -train_evaluate_episodes 2 -train_output q.h5
[ $status = 0 ] || slipstep_failures "$build"
echo "Tests: $(slipstep_count "$ran") under sanitizers"
exit $status
