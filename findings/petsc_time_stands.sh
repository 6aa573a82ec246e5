#!/usr/bin/env bash
# PETSc's TS integrates on where its time no longer moves: a step below the rounding of the time is taken, and its result is kept.
#
# Seen with PETSc 3.18.5 (Debian 12). y' = 1 from t = 1e16, whose neighbour is 2 away, to 1e16 + 100 with steps of 0.5: rk, ssp, euler and
# beuler take as many steps as TSSetMaxSteps() allows, t stays 1e16, y grows by half a step count, and the reason is CONVERGED_ITS, which is
# positive, as of a run that ended well. With steps of 1.5 the time goes by 2 each: it gets to its end, CONVERGED_TIME, with y = 75 in place
# of 100. There is no message. Count long times from an origin that moves, or compare the time before and after a step.
#
# Guess before the run: an error, as TSAdapt has a shortest step, or a time that is summed up with what rounding leaves.
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

static PetscErrorCode One(TS ts, PetscReal t, Vec y, Vec f, void *context)
{
  return VecSet(f, 1);
}

static int Run(const char *type, double h, int steps, double moved, double grown, TSConvergedReason expected)
{
  TS                 ts;
  TSAdapt            adapt;
  Vec                y;
  PetscReal          t;
  PetscInt           n;
  TSConvergedReason  reason;
  const PetscScalar *value;
  int                same;

  TSCreate(PETSC_COMM_SELF, &ts);
  VecCreateSeq(PETSC_COMM_SELF, 1, &y);
  TSSetType(ts, type);
  TSSetRHSFunction(ts, NULL, One, NULL);
  TSGetAdapt(ts, &adapt);
  TSAdaptSetType(adapt, TSADAPTNONE);
  TSSetTime(ts, 1e16);
  TSSetMaxTime(ts, 1e16 + 100);
  TSSetTimeStep(ts, h);
  TSSetMaxSteps(ts, 1000);
  TSSetExactFinalTime(ts, TS_EXACTFINALTIME_STEPOVER);
  if (TSSolve(ts, y)) return 1;
  TSGetTime(ts, &t);
  TSGetStepNumber(ts, &n);
  TSGetConvergedReason(ts, &reason);
  VecGetArrayRead(y, &value);
  printf("%s, h = %g: %d steps, time on by %g, y = %g, %s\n", type, h, (int)n, t - 1e16, value[0], TSConvergedReasons[reason]);
  same = n == steps && t - 1e16 == moved && PetscAbsReal(value[0] - grown) < 1e-6 && reason == expected;
  VecRestoreArrayRead(y, &value);
  TSDestroy(&ts);
  VecDestroy(&y);
  return !same;
}

int main(int argc, char **argv)
{
  const char *const types[] = {TSRK, TSSSP, TSEULER, TSBEULER};
  int               other = 0;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  for (int k = 0; k < 4; k++) {
    other += Run(types[k], 0.5, 1000, 0, 500, TS_CONVERGED_ITS);
    other += Run(types[k], 1.5, 50, 100, 75, TS_CONVERGED_TIME);
  }
  PetscFinalize();
  return other > 0;
}
C
include=$(for folder in "$petsc"/include "$petsc"/../include tree/usr/include tree/usr/lib/x86_64-linux-gnu/openmpi/include; do printf ' -I %s' "$folder"; done)
cc $include try.c -o try -L "$petsc"/lib -lpetsc_real -L "$lib" -lmpi -Wl,--allow-shlib-undefined -lm
export LD_LIBRARY_PATH=$petsc/lib:$lib:$room/tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack OPAL_PREFIX=$room/tree/usr PMIX_INSTALL_PREFIX=$lib/pmix2 HWLOC_COMPONENTS=-opencl
export OMPI_MCA_mca_base_component_path=$lib/openmpi/lib/openmpi3 OMPI_MCA_ess_singleton_isolated=1 OMPI_MCA_btl=self OMPI_MCA_pml=ob1 PMIX_MCA_gds=hash
./try 2>error.txt || { tail -5 error.txt; exit 1; }
