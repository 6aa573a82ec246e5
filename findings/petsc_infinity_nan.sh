#!/usr/bin/env bash
# PETSc's step control by the infinity norm does not see NaN: the run goes on and ends well, with NaN in its result.
#
# Seen with PETSc 3.18.5 (Debian 12). y1' = -sqrt(y1) from 1 and y2' = -y2, whose first equation has no real rate once a step went below
# zero, near t = 2. With -ts_adapt_wnormtype 2, the default, TSRK ends with the error "Infinite or not-a-number generated". With infinity,
# which one takes so that the worst component counts, all steps after it are accepted by the other component, the reason is CONVERGED_TIME
# at t = 4, and y1 is NaN: a comparison with NaN is false, so the largest of the errors is that of the numbers. The check for NaN comes
# after it and finds a number. Test the state by a sum, as VecNorm() with NORM_2 or VecSum().
#
# Guess before the run: the same error with both norms.
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
  PetscScalar       *rate;

  VecGetArrayRead(y, &value);
  VecGetArray(f, &rate);
  rate[0] = -PetscSqrtReal(value[0]);
  rate[1] = -value[1];
  VecRestoreArrayRead(y, &value);
  VecRestoreArray(f, &rate);
  return 0;
}

int main(int argc, char **argv)
{
  const char *pair[] = {TSRK3BS, TSRK5DP};
  NormType    norm[] = {NORM_2, NORM_INFINITY};
  int         seen = 1;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 2;
  PetscPushErrorHandler(PetscIgnoreErrorHandler, NULL);
  for (int k = 0; k < 2; k++)
    for (int n = 0; n < 2; n++) {
      TS                 ts;
      TSConvergedReason  reason;
      Vec                y;
      PetscReal          t;
      PetscInt           steps;
      const PetscScalar *value;
      int                ierr;

      TSCreate(PETSC_COMM_SELF, &ts);
      VecCreateSeq(PETSC_COMM_SELF, 2, &y);
      VecSet(y, 1);
      TSSetType(ts, TSRK);
      TSRKSetType(ts, pair[k]);
      TSSetRHSFunction(ts, NULL, Rate, NULL);
      PetscOptionsSetValue(NULL, "-ts_adapt_wnormtype", norm[n] == NORM_2 ? "2" : "infinity");
      TSSetTimeStep(ts, 0.01);
      TSSetMaxTime(ts, 4);
      TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP);
      TSSetFromOptions(ts);
      ierr = TSSolve(ts, y);
      TSGetTime(ts, &t);
      TSGetStepNumber(ts, &steps);
      TSGetConvergedReason(ts, &reason);
      VecGetArrayRead(y, &value);
      if (ierr) printf("%s, norm %s: error %d of PETSc's at t = %.2f\n", pair[k], n ? "infinity" : "2", ierr, t);
      else printf("%s, norm %s: %s at t = %g after %d steps, y = %g, %g\n", pair[k], n ? "infinity" : "2", TSConvergedReasons[reason], t, (int)steps, fabs(value[0]), value[1]);
      seen = seen && (n ? !ierr && reason == TS_CONVERGED_TIME && isnan(value[0]) && fabs(value[1] - exp(-4)) < 1e-3 : ierr == PETSC_ERR_FP);
      VecRestoreArrayRead(y, &value);
    }
  return !seen;
}
C
include=$(for folder in "$petsc"/include "$petsc"/../include tree/usr/include tree/usr/lib/x86_64-linux-gnu/openmpi/include; do printf ' -I %s' "$folder"; done)
cc $include try.c -o try -L "$petsc"/lib -lpetsc_real -L "$lib" -lmpi -Wl,--allow-shlib-undefined -lm
export LD_LIBRARY_PATH=$petsc/lib:$lib:$room/tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack OPAL_PREFIX=$room/tree/usr PMIX_INSTALL_PREFIX=$lib/pmix2 HWLOC_COMPONENTS=-opencl
export OMPI_MCA_mca_base_component_path=$lib/openmpi/lib/openmpi3 OMPI_MCA_ess_singleton_isolated=1 OMPI_MCA_btl=self OMPI_MCA_pml=ob1 PMIX_MCA_gds=hash
./try 2>error.txt || { tail -5 error.txt; exit 1; }
