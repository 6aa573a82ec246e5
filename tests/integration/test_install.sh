#!/usr/bin/env bash
# Installs into a temporary folder, moves that, and builds a small program against it with CMake and with pkg-config.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
prefix="$room/moved"
cmake --install "$SLIPSTEP_BUILD" --prefix "$room/first" >"$room/install.log"
mv "$room/first" "$prefix"

fail() {
  echo "test_install: $*" >&2
  exit 1
}

pc=$(find "$prefix" -name slipstep.pc)
library=$(find "$prefix" -name libslipstep.so)
[ -n "$pc" ] && [ -n "$library" ] || fail "slipstep.pc or libslipstep.so was not installed"
for policy in "$SLIPSTEP_SOURCE"/training/policies/*.h5; do
  [ ! -e "$policy" ] || cmp "$policy" "$prefix/share/slipstep/policies/$(basename "$policy")"
done
[ -x "$prefix/share/slipstep/python/compare.py" ] || fail "compare.py was not installed"

# Every program of the build is installed, and finds all its libraries without help from the environment.
for program in "$SLIPSTEP_BUILD"/bin/*; do
  [ -e "$program" ] || continue
  installed="$prefix/bin/$(basename "$program")"
  [ -x "$installed" ] || fail "$(basename "$program") was not installed"
  if ldd "$installed" | grep 'not found'; then fail "$installed lacks libraries"; fi
  [ -z "$(ldd "$installed" | grep libslipstep | grep -v "$prefix")" ] || fail "$installed uses a libslipstep outside of the prefix"
done

mkdir "$room/user"
cat >"$room/user/user.c" <<'C'
#include <petscts.h>
#include <slipstep.h>

int main(int argc, char **argv)
{
  TS     ts;
  TSType type;
  char   version[16];

  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(SlipStepInitializePackage());
  PetscCall(TSCreate(PETSC_COMM_WORLD, &ts));
  PetscCall(TSSetType(ts, TSBATHE));
  PetscCall(TSGetType(ts, &type));
  PetscCall(SlipStepGetVersion(version, sizeof(version)));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "SlipStep %s (headers %s) has TS type %s\n", version, SLIPSTEP_VERSION, type));
  PetscCall(TSDestroy(&ts));
  PetscCall(PetscFinalize());
  return 0;
}
C
cat >"$room/user/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.25)
project(user LANGUAGES C)
find_package(slipstep 0.2 REQUIRED)
add_executable(user user.c)
target_link_libraries(user PRIVATE slipstep::slipstep)
CMAKE
expected="SlipStep 0.2.0 (headers 0.2.0) has TS type bathe"

cmake -S "$room/user" -B "$room/user/build" -DCMAKE_PREFIX_PATH="$prefix" >"$room/user.log" || { cat "$room/user.log"; fail "find_package(slipstep)"; }
cmake --build "$room/user/build" >>"$room/user.log" || { cat "$room/user.log"; fail "building with CMake"; }
said=$("$room/user/build/user") || fail "the program built with CMake failed: $said"
[ "$said" = "$expected" ] || fail "built with CMake: expected '$expected', got '$said'"

export PKG_CONFIG_PATH
PKG_CONFIG_PATH="$(dirname "$pc"):${PKG_CONFIG_PATH:-}"
mpicc -std=c17 "$room/user/user.c" -o "$room/user/user" $(pkg-config --cflags --libs slipstep) || fail "building with pkg-config"
said=$("$room/user/user") || fail "the program built with pkg-config failed: $said"
[ "$said" = "$expected" ] || fail "built with pkg-config: expected '$expected', got '$said'"
echo "installed programs and both ways of linking work"
