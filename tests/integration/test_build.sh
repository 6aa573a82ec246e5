#!/usr/bin/env bash
# Which PETSc and HDF5 the build takes: what the user names wins or is refused by name, and two HDF5 in one program are
# refused before anything is compiled.
set -u
. "$SLIPSTEP_SOURCE/tests/integration/prelude.sh"

cached() { sed -n "s/^$1:[A-Z]*=//p" "$SLIPSTEP_BUILD/CMakeCache.txt" | head -n 1; }
pc=$(cached SLIPSTEP_PETSC_PC)
libdir=$(cached PETSC_LIBDIR)
unset PETSC_DIR PETSC_ARCH PKG_CONFIG_PATH

# configure [VARIABLE=VALUE...] [-D...]: into a new folder; its output, wrapped by CMake, as one line in said
configure() {
  rm -rf build
  env "${environment[@]}" cmake -S "$SLIPSTEP_SOURCE" -B build -DBUILD_TESTING=OFF "$@" >log 2>&1
  local code=$?
  said=$(tr -s ' \n' ' ' <log)
  return $code
}

expect() { # words of a message
  if configure "${arguments[@]}"; then fail "no error with ${environment[*]} ${arguments[*]}"; fi
  for words in "$@"; do [[ "$said" == *"$words"* ]] || fail "no \"$words\" with ${environment[*]} ${arguments[*]}: $said"; done
}

# fake DIR VERSION SCALAR: what a PETSc installs, without headers and libraries
fake() {
  mkdir -p "$1/lib/pkgconfig" "$1/lib/petsc/conf"
  printf 'prefix=%s\nlibdir=${prefix}/lib\nName: PETSc\nDescription: none\nVersion: %s\nLibs: -L${libdir} -lpetsc\n' "$1" "$2" >"$1/lib/pkgconfig/PETSc.pc"
  printf 'PETSC_SCALAR = %s\nPETSC_SCALAR_SIZE = 64\nPETSC_INDEX_SIZE = 32\n' "$3" >"$1/lib/petsc/conf/petscvariables"
}
fake "$work/old" 3.17.4 real
fake "$work/complex/arch-x" 3.22.1 complex
fake "$work/empty" 3.22.1 real

arguments=()
environment=(PETSC_DIR="$work/nowhere" PETSC_ARCH=arch-y)
expect "$work/nowhere" "\"arch-y\"" PETSc.pc
environment=(PETSC_DIR="$work/old")
expect "$work/old/lib/pkgconfig/PETSc.pc is version 3.17.4"
environment=(PETSC_DIR="$work/complex" PETSC_ARCH=arch-x PKG_CONFIG_PATH="$libdir/pkgconfig")
expect "complex scalars"
environment=(PKG_CONFIG_PATH="$work/old/lib/pkgconfig:$libdir/pkgconfig") # before the system's
expect "is version 3.17.4"

# taken, also before one on PKG_CONFIG_PATH
environment=(PETSC_DIR="$(dirname "$libdir")" PKG_CONFIG_PATH="$work/empty/lib/pkgconfig")
configure || fail "PETSC_DIR is not taken: $said"
taken=$(sed -n 's/^SLIPSTEP_PETSC_PC:[A-Z]*=//p' build/CMakeCache.txt)
[ "$(readlink -f "$taken")" = "$(readlink -f "$libdir/pkgconfig/$(basename "$pc")")" ] || fail "took $taken instead of $libdir/pkgconfig"
# and a build folder keeps it
if PETSC_DIR="$work/empty" cmake build >log 2>&1; then fail "a build folder changed its PETSc"; fi
tr -s ' \n' ' ' <log | grep -q "this build folder" || fail "no message on a changed PETSc: $(cat log)"
cmake build >log 2>&1 || fail "configuring again without PETSC_DIR: $(cat log)"

# without cmocka a build has the other tests
cat >pkg-config <<SH
#!/bin/sh
case " \$* " in *cmocka*) exit 1 ;; esac
exec $(command -v pkg-config) "\$@"
SH
chmod +x pkg-config
environment=(PETSC_DIR="$(dirname "$libdir")")
configure -DBUILD_TESTING=ON -DPKG_CONFIG_EXECUTABLE="$work/pkg-config" || fail "no build without cmocka: $said"
[[ "$said" == *"no cmocka"* ]] || fail "nothing is said of the missing cmocka: $said"
kinds=$(ctest --test-dir build -N | sed -n 's/^ *Test *#[0-9]*: \([a-z]*\)\..*/\1/p' | sort -u | tr '\n' ' ')
[ "$kinds" = "integration python " ] || fail "kinds of tests without cmocka: $kinds"

# The set-up waits while another program installs packages: locks that go away at the third call, and another error.
mkdir -p fakes
cat >fakes/apt-get <<'SH'
#!/bin/sh
echo x >>calls
[ "$(wc -l <calls)" -ge 3 ] || { echo "E: Could not get lock /var/lib/dpkg/lock-frontend. It is held by process 1 (apt)" >&2; exit 100; }
case " $* " in *" none "*) echo "E: Unable to locate package none" >&2; exit 100 ;; esac
SH
chmod +x fakes/apt-get
for package in some none; do
  : >calls
  code=0
  PATH="$work/fakes:$PATH" SLIPSTEP_LOCK_WAIT=0 bash -c ". '$SLIPSTEP_SOURCE/tests/setup.sh'; slipstep_apt '' install $package" >log 2>err || code=$?
  [ $code = $([ $package = some ] && echo 0 || echo 100) ] && [ "$(wc -l <calls)" = 3 ] || fail "set-up beside another one ends with $code after $(wc -l <calls) calls: $(cat log err)"
  [ "$(grep -c "^Waiting for another program that installs packages: .*lock-frontend" log)" = 1 ] || fail "a set-up waits without a line: $(cat log)"
done
[ "$(cat err)" = "E: Unable to locate package none" ] || fail "an error of apt-get is lost: $(cat err)"

# another HDF5 than PETSc's, where the system has one
used=$(ldd "$(ls "$libdir"/libpetsc*.so | head -n 1)" | sed -n 's/^\s*libhdf5[^ ]* => \([^ ]*\).*/\1/p' | head -n 1)
for other in /usr/lib/*/libhdf5_serial.so.*[0-9]; do
  [ -e "$other" ] && [ -n "$used" ] && [ "$(readlink -f "$other")" != "$(readlink -f "$used")" ] || continue
  environment=(PETSC_DIR="$(dirname "$libdir")")
  arguments=(-DSLIPSTEP_HDF5_LIBRARIES="$other" -DSLIPSTEP_HDF5_INCLUDES="$(sed -n 's/^HDF5_INCLUDE = -I//p' "$libdir/petsc/conf/petscvariables")")
  expect "HDF5"
  [[ "$said" == *"two HDF5 in one program"* || "$said" == *"HDF5's headers are of version"* ]] || fail "another HDF5 is refused for another reason: $said"
  break
done
exit $failed
