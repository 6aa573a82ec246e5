#!/usr/bin/env bash
# Set-up, build, format check and all tests. Arguments go to ctest: tests/run.sh -L unit (or mpi, python, integration),
# tests/run.sh -R kernel -V; arguments that select no test are an error. SLIPSTEP_BUILD_DIR chooses the build folder
# (default build).
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

# Formatting of every C file under git, with the .clang-format of the tree.
check_format() {
  if ! git rev-parse --is-inside-work-tree >/dev/null 2>&1; then
    echo "Format check skipped: no git, or not a git work tree."
  elif git ls-files -z '*.c' '*.h' | xargs -0 -r clang-format --dry-run -Werror; then
    echo "Format check passed."
  else
    echo "Format check failed: run clang-format -i on the files above."
    return 1
  fi
}

slipstep_setup libcmocka-dev clang-format
build=${SLIPSTEP_BUILD_DIR:-build}
slipstep_build "$build" -DBUILD_TESTING=ON -DSLIPSTEP_PYTHON="$SLIPSTEP_PYTHON"

status=0
ctest --test-dir "$build" --output-on-failure --no-tests=error -j 2 "$@" || status=1
check_format || status=1 # last, where it is seen
exit $status
