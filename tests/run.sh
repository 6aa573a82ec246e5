#!/usr/bin/env bash
# Set-up, build, format check and all tests. Arguments go to ctest: tests/run.sh -L unit (or mpi, python, integration),
# tests/run.sh -R kernel -V; arguments that select no test are an error. SLIPSTEP_BUILD_DIR chooses the build folder
# (default build).
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh

# Formatting of every C file under git, with the .clang-format of the tree. Other versions than 14 break lines elsewhere.
check_format() {
  local tool found=""
  for tool in clang-format-14 clang-format; do
    if command -v $tool >/dev/null && $tool --version | grep -q 'version 14\.'; then found=$tool && break; fi
  done
  if [ -z "$found" ]; then
    echo "Format check skipped: no clang-format 14."
  elif ! git rev-parse --is-inside-work-tree >/dev/null 2>&1; then
    echo "Format check skipped: no git, or not a git work tree."
  elif git ls-files -z '*.c' '*.h' | xargs -0 -r "$found" --dry-run -Werror; then
    echo "Format check passed."
  else
    echo "Format check failed: run $found -i on the files above."
    return 1
  fi
}

packages=($(slipstep_test_packages))
slipstep_setup "${packages[@]}"
build=${SLIPSTEP_BUILD_DIR:-build}
# a build without cmocka is one without most of the tests, in silence
pkg-config --exists cmocka || slipstep_die "tests/run.sh: no cmocka, which unit and mpi tests need (Debian's libcmocka-dev)"
slipstep_build "$build" -DBUILD_TESTING=ON -DSLIPSTEP_PYTHON="$SLIPSTEP_PYTHON"

status=0 failures=""
ran=$(cd "$build" && pwd -P)/tests.xml
rm -f "$ran"
ctest --test-dir "$build" --output-on-failure --no-tests=error -j 2 --output-junit "$ran" "$@" || failures=yes
# near the end, where it is seen
if [ -n "$failures" ]; then
  status=1
  slipstep_failures "$build"
fi
check_format || status=1
echo "Tests: $(slipstep_count "$ran")"
exit $status
