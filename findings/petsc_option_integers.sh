#!/usr/bin/env bash
# PETSc reads integers of options that do not fit PetscInt modulo 2^32, without an error.
#
# Seen with PETSc 3.18.5 (Debian 12, 32-bit PetscInt). Text that is no number ("12abc", "1e3") is refused with the value, so a number
# that is too large could be expected to be. PetscOptionsGetInt() reads it as a 64-bit number and keeps the lower half: 4294967316 becomes
# 20, 2147483648 becomes -2147483648. PETSc's own options do the same: with -ts_max_steps 4294967299 a run of TS stops after 3 steps and
# reports TS_CONVERGED_ITS, as if that had been asked for.
#
# Guess before the run: "Argument out of range", as for other text that is no PetscInt.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 --no-install-recommends \
  --download-only install libpetsc-real3.18=3.18.5+dfsg1-1 libpetsc-real3.18-dev=3.18.5+dfsg1-1 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb debs/libc6-dev_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
lib=$room/tree/usr/lib/x86_64-linux-gnu petsc=$(echo "$room"/tree/usr/lib/petscdir/petsc*/x86_64-linux-gnu-real)

cat >try.c <<'C'
#include <petscts.h>

static PetscErrorCode Decay(TS ts, PetscReal t, Vec x, Vec f, void *context)
{
  return VecCopy(x, f) || VecScale(f, -1);
}

int main(int argc, char **argv)
{
  TS       ts;
  Vec      x;
  PetscInt first = 0, second = 0, steps;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 2;
  if (PetscOptionsGetInt(NULL, NULL, "-first", &first, NULL)) return 3;
  PetscOptionsGetInt(NULL, NULL, "-second", &second, NULL);
  TSCreate(PETSC_COMM_SELF, &ts);
  VecCreateSeq(PETSC_COMM_SELF, 1, &x);
  VecSet(x, 1);
  TSSetType(ts, TSEULER);
  TSSetRHSFunction(ts, NULL, Decay, NULL);
  TSSetTimeStep(ts, 0.01);
  TSSetMaxTime(ts, 1);
  TSSetExactFinalTime(ts, TS_EXACTFINALTIME_STEPOVER);
  TSSetFromOptions(ts);
  TSSolve(ts, x);
  TSGetStepNumber(ts, &steps);
  PetscPrintf(PETSC_COMM_SELF, "%ld %ld %ld\n", (long)first, (long)second, (long)steps);
  TSDestroy(&ts);
  VecDestroy(&x);
  PetscFinalize();
  return 0;
}
C
include=$(for folder in "$petsc"/include "$petsc"/../include tree/usr/include tree/usr/lib/x86_64-linux-gnu/openmpi/include; do printf ' -I %s' "$folder"; done)
cc $include try.c -o try -L "$petsc"/lib -lpetsc_real -L "$lib" -lmpi -Wl,--allow-shlib-undefined
export LD_LIBRARY_PATH=$petsc/lib:$lib:$room/tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack OPAL_PREFIX=$room/tree/usr PMIX_INSTALL_PREFIX=$lib/pmix2 HWLOC_COMPONENTS=-opencl
export OMPI_MCA_mca_base_component_path=$lib/openmpi/lib/openmpi3 OMPI_MCA_ess_singleton_isolated=1 OMPI_MCA_btl=self OMPI_MCA_pml=ob1 PMIX_MCA_gds=hash
./try -first 4294967316 -second 2147483648 -ts_max_steps 4294967299 >seen.txt 2>error.txt || { tail -5 error.txt; exit 1; }
echo "-first 4294967316 -second 2147483648 -ts_max_steps 4294967299: first, second and steps taken are $(cat seen.txt)"
[ "$(cat seen.txt)" = "20 -2147483648 3" ] && ! ./try -first 12abc >refused.txt 2>&1
