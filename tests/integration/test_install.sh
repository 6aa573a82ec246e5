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
[ -n "$library" ] || library=$(find "$prefix" -name libslipstep.a) # built with BUILD_SHARED_LIBS=OFF
[ -n "$pc" ] && [ -n "$library" ] || fail "slipstep.pc or libslipstep was not installed"
for policy in "$SLIPSTEP_SOURCE"/training/policies/*.h5; do
  [ ! -e "$policy" ] || cmp "$policy" "$prefix/share/slipstep/policies/$(basename "$policy")"
done
# the Python package has the library two folders up, and the programs in Python find it, whatever folders there are in the source
[ -f "$(dirname "$library")/python3/slipstep/petsc.py" ] || fail "the Python package was not installed"
diff -r -x __pycache__ "$SLIPSTEP_SOURCE/src/package/slipstep" "$(dirname "$library")/python3/slipstep" || fail "the Python package is not that of the source"
for program in convert_mesh import_sb3; do
  [ -x "$prefix/share/slipstep/python/$program.py" ] || fail "$program.py was not installed"
  "$SLIPSTEP_PYTHON" "$prefix/share/slipstep/python/$program.py" --help >/dev/null || fail "$program.py was not installed with what it needs"
done
"$SLIPSTEP_PYTHON" "$prefix/bin/slipstep" plot-run --help >/dev/null || fail "slipstep does not find the package"
said=$(env -u SLIPSTEP_BUILD PYTHONPATH="$(dirname "$library")/python3" "$SLIPSTEP_PYTHON" -c 'from slipstep import modules; print(modules.find_program("elastic"))')
[ "$said" -ef "$prefix/bin/elastic" ] || fail "the package does not find the programs beside it: $said"

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
#include <math.h>
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
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "SlipStep %s (headers %s) has TS type %s%s\n", version, SLIPSTEP_VERSION, type,
                        cbrt((double)argc) > 0 ? "" : "?"));
  PetscCall(TSDestroy(&ts));
  PetscCall(PetscFinalize());
  return 0;
}
C
cat >"$room/user/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.25)
project(user LANGUAGES C)
find_package(slipstep 0.5 REQUIRED)
add_executable(user user.c)
target_link_libraries(user PRIVATE slipstep::slipstep)
CMAKE
expected="SlipStep 0.5.0 (headers 0.5.0) has TS type bathe"

cmake -S "$room/user" -B "$room/user/build" -DCMAKE_PREFIX_PATH="$prefix" >"$room/user.log" || { cat "$room/user.log"; fail "find_package(slipstep)"; }
cmake --build "$room/user/build" >>"$room/user.log" || { cat "$room/user.log"; fail "building with CMake"; }
said=$("$room/user/build/user") || fail "the program built with CMake failed: $said"
[ "$said" = "$expected" ] || fail "built with CMake: expected '$expected', got '$said'"

# static: the same program, which then needs no libslipstep
if [ "$library" != "${library%.so}" ]; then
  sed -i 's/slipstep::slipstep)/slipstep::slipstep_static)/' "$room/user/CMakeLists.txt"
  cmake -S "$room/user" -B "$room/user/static" -DCMAKE_PREFIX_PATH="$prefix" >"$room/user.log" && cmake --build "$room/user/static" >>"$room/user.log" ||
    { cat "$room/user.log"; fail "building with the static library"; }
  said=$("$room/user/static/user") || fail "the static program failed: $said"
  [ "$said" = "$expected" ] || fail "static: expected '$expected', got '$said'"
  if ldd "$room/user/static/user" | grep slipstep; then fail "the static program needs libslipstep"; fi
fi

# another PETSc than the one that was built against is refused, by CMake and by the compiler
mkdir -p "$room/other/lib/petsc/conf"
touch "$room/other/lib/petsc/conf/petscvariables"
if PETSC_DIR="$room/other" PETSC_ARCH= cmake -S "$room/user" -B "$room/user/other" -DCMAKE_PREFIX_PATH="$prefix" >"$room/user.log" 2>&1; then
  fail "find_package(slipstep) took another PETSc"
fi
tr -s ' \n' ' ' <"$room/user.log" | grep -q "other/lib" || { cat "$room/user.log"; fail "no message on another PETSc"; }
mkdir "$room/header"
sed 's/\(SLIPSTEP_PETSC_MINOR\) .*/\1 17/' "$(find "$prefix" -name slipbuild.h)" >"$room/header/slipbuild.h"

export PKG_CONFIG_PATH
PKG_CONFIG_PATH="$(dirname "$pc"):${PKG_CONFIG_PATH:-}"
mpicc -std=c17 "$room/user/user.c" -o "$room/user/user" $(pkg-config --cflags --libs slipstep) || fail "building with pkg-config"
said=$("$room/user/user") || fail "the program built with pkg-config failed: $said"
[ "$said" = "$expected" ] || fail "built with pkg-config: expected '$expected', got '$said'"
if mpicc -std=c17 -I"$room/header" "$room/user/user.c" -o "$room/user/wrong" $(pkg-config --cflags --libs slipstep) 2>"$room/user.log"; then
  fail "a program for another PETSc was compiled"
fi
grep -q "built against another PETSc" "$room/user.log" || { cat "$room/user.log"; fail "no message of the compiler"; }
if [ "$library" != "${library%.so}" ]; then
  static=$(pkg-config --static --cflags --libs slipstep | sed 's/-lslipstep/-l:libslipstep.a/')
  mpicc -std=c17 "$room/user/user.c" -o "$room/user/static-user" $static || fail "building with pkg-config --static"
  said=$("$room/user/static-user") || fail "the static program built with pkg-config failed: $said"
  [ "$said" = "$expected" ] || fail "static with pkg-config: expected '$expected', got '$said'"
fi
version=$(pkg-config --variable=petsc_version slipstep)
grep -q "PETSC_VERSION \"$version\"" "$(find "$prefix" -name slipbuild.h)" || fail "slipstep.pc names PETSc '$version', slipbuild.h another"
[ -e "$(pkg-config --variable=petsc_pc slipstep)" ] || fail "slipstep.pc names no PETSc"

# a program that trains: the library of the trainer, by CMake and by pkg-config
mkdir "$room/train"
cp "$SLIPSTEP_SOURCE"/examples/train_oscillator.c "$SLIPSTEP_SOURCE"/examples/oscillator.h "$room/train"
cat >"$room/train/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.25)
project(user LANGUAGES C)
find_package(slipstep 0.5 REQUIRED)
add_executable(train train_oscillator.c)
target_link_libraries(train PRIVATE slipstep::sliptrain)
CMAKE
cmake -S "$room/train" -B "$room/train/build" -DCMAKE_PREFIX_PATH="$prefix" >"$room/train.log" && cmake --build "$room/train/build" >>"$room/train.log" ||
  { cat "$room/train.log"; fail "building with the trainer's library"; }
mpicc -std=c17 "$room/train/train_oscillator.c" -o "$room/train/train" $(pkg-config --cflags --libs sliptrain) || fail "building with sliptrain.pc"
for program in "$room/train/build/train" "$room/train/train"; do
  "$program" -train_singles 1 -train_batch_singles 1 -train_validation 1 -train_calibration 1 -train_generations 1 -train_population 4 -train_hidden 1 \
    -train_output "$room/train/p.h5" >"$room/train.log" 2>&1 && [ -s "$room/train/p.h5" ] || { cat "$room/train.log"; fail "a training by an installed library"; }
  rm "$room/train/p.h5"
done

# the shared library is of its minor version, as that is of the interface
version=$(sed -n 's/^Version: //p' "$pc")
case $library in *.so) readelf -d "$library" | grep -q "libslipstep.so.${version%.*}\]" || fail "the SONAME is not that of version $version: $(readelf -d "$library" | grep SONAME)" ;; esac
# the Debian package: all programs, each with a manual page made of its help
if command -v cpack >/dev/null && command -v dpkg-shlibdeps >/dev/null && [ "${library%.so}" != "$library" ]; then
  (cd "$SLIPSTEP_BUILD" && cpack -G DEB -B "$room/deb") >"$room/cpack.log" 2>&1 || { tail -20 "$room/cpack.log"; fail "cpack -G DEB"; }
  dpkg-deb -c "$room"/deb/*.deb >"$room/deb.list"
  for name in slipstep-fault slipstep-train slipstep-evaluate slipstep-circuit slipstep slipstep-convert-mesh; do
    grep -q "/bin/$name\( -> .*\)\?\$" "$room/deb.list" && grep -q "/man1/$name.1.gz\$" "$room/deb.list" || fail "the package lacks $name or its manual page"
  done
  grep -q '/man1/slipstep-plot-run.1.gz$' "$room/deb.list" || fail "the package lacks the manual page of slipstep plot-run"
fi
echo "installed programs and both ways of linking work"
