#!/usr/bin/env bash
# A TSAdapt that was of type dsp keeps dsp's safety factors when its type changes: basic then retries refused steps with other lengths.
#
# Seen with PETSc 3.18.5 (Debian 12). A new controller of type basic has the factors 0.9 and, for a step that was refused, 0.5 of
# TSAdaptGetSafety(). TSAdaptSetType(adapt, "dsp") makes the second one 1, and TSAdaptSetType(adapt, "basic") leaves it so. A program that sets
# dsp as its default and lets the user choose by -ts_adapt_type basic has a basic that is not PETSc's: y' = -1e3 (y - cos t) from y = 0 to t = 1
# by rk, 3bs, at 1e-6 takes 416 steps and 199 that are refused, after dsp 417 and 186. Call TSAdaptSetSafety() with both numbers after
# TSAdaptSetType().
#
# Guess before the run: each type begins with its own defaults, as one of a new object does.
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

static PetscErrorCode Rate(TS ts, PetscReal t, Vec y, Vec f, void *context)
{
  const PetscScalar *value;

  VecGetArrayRead(y, &value);
  VecSet(f, -1e3 * (value[0] - PetscCosReal(t)));
  VecRestoreArrayRead(y, &value);
  return 0;
}

static int Run(const char *before, double expected, int *attempts)
{
  TS        ts;
  TSAdapt   adapt;
  Vec       y;
  PetscReal safety, refused;
  PetscInt  accepted, rejected;

  TSCreate(PETSC_COMM_SELF, &ts);
  VecCreateSeq(PETSC_COMM_SELF, 1, &y);
  VecSet(y, 0);
  TSSetType(ts, TSRK);
  TSRKSetType(ts, TSRK3BS);
  TSSetRHSFunction(ts, NULL, Rate, NULL);
  TSGetAdapt(ts, &adapt);
  if (before) TSAdaptSetType(adapt, before);
  TSAdaptSetType(adapt, TSADAPTBASIC);
  TSAdaptGetSafety(adapt, &safety, &refused);
  TSSetTolerances(ts, 1e-6, NULL, 1e-6, NULL);
  TSSetMaxStepRejections(ts, -1);
  TSSetTimeStep(ts, 0.1);
  TSSetMaxTime(ts, 1);
  TSSetMaxSteps(ts, 100000);
  TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP);
  if (TSSolve(ts, y)) return 1;
  TSGetStepNumber(ts, &accepted);
  TSGetStepRejections(ts, &rejected);
  *attempts = (int)(accepted + rejected);
  printf("basic after %s: factors %g and %g, %d steps, %d refused\n", before ? before : "nothing", safety, refused, (int)accepted, (int)rejected);
  TSDestroy(&ts);
  VecDestroy(&y);
  return safety != 0.9 || refused != expected;
}

int main(int argc, char **argv)
{
  int other = 0, alone, after;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  other += Run(NULL, 0.5, &alone);
  other += Run(TSADAPTNONE, 0.5, &after);
  other += after != alone;
  other += Run(TSADAPTDSP, 1, &after);
  other += after == alone;
  PetscFinalize();
  return other > 0;
}
C
include=$(for folder in "$petsc"/include "$petsc"/../include tree/usr/include tree/usr/lib/x86_64-linux-gnu/openmpi/include; do printf ' -I %s' "$folder"; done)
cc $include try.c -o try -L "$petsc"/lib -lpetsc_real -L "$lib" -lmpi -Wl,--allow-shlib-undefined -lm
export LD_LIBRARY_PATH=$petsc/lib:$lib:$room/tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack OPAL_PREFIX=$room/tree/usr PMIX_INSTALL_PREFIX=$lib/pmix2 HWLOC_COMPONENTS=-opencl
export OMPI_MCA_mca_base_component_path=$lib/openmpi/lib/openmpi3 OMPI_MCA_ess_singleton_isolated=1 OMPI_MCA_btl=self OMPI_MCA_pml=ob1 PMIX_MCA_gds=hash
./try 2>error.txt || { tail -5 error.txt; exit 1; }
