#!/usr/bin/env bash
# PETSc's TSGLEE passes over the IFunction: the solution stays what it was, and the run ends as one that went well.
#
# Seen with PETSc 3.18.5 (Debian 12). y' = -y from 1 to t = 1, given as y' + y = 0 by TSSetIFunction(), as stiff equations are. rk and ssp
# refuse it: "Arguments are incompatible". arkimex, rosw and bdf solve it. glee, explicit methods that estimate the global error, and BE1,
# which is implicit, ends at t = 1 with CONVERGED_TIME and y = 1, and an estimate of the global error of 0: all its rates are those of the
# right-hand side, which nobody set. With TSSetRHSFunction() it is right. "-ts_type glee" alone turns a good run into one that stands.
#
# Guess before the run: the error that rk gives, or the solution.
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

static PetscErrorCode Residual(TS ts, PetscReal t, Vec y, Vec rate, Vec f, void *context)
{
  return VecWAXPY(f, 1, y, rate);
}

static PetscErrorCode Derivative(TS ts, PetscReal t, Vec y, Vec rate, PetscReal shift, Mat A, Mat B, void *context)
{
  MatSetValue(B, 0, 0, shift + 1, INSERT_VALUES);
  MatAssemblyBegin(B, MAT_FINAL_ASSEMBLY);
  return MatAssemblyEnd(B, MAT_FINAL_ASSEMBLY);
}

static PetscErrorCode Rate(TS ts, PetscReal t, Vec y, Vec f, void *context)
{
  return VecCopy(y, f) || VecScale(f, -1);
}

/* y at t = 1 as `type` finds it; an error code of PETSc's is returned */
static int Solve(const char *type, const char *scheme, int implicit, double *end, TSConvergedReason *reason, double *estimate)
{
  TS                 ts;
  Vec                y, error;
  Mat                A;
  const PetscScalar *value;
  int                ierr;

  TSCreate(PETSC_COMM_SELF, &ts);
  VecCreateSeq(PETSC_COMM_SELF, 1, &y);
  VecSet(y, 1);
  MatCreateSeqDense(PETSC_COMM_SELF, 1, 1, NULL, &A);
  TSSetType(ts, type);
  if (scheme) TSGLEESetType(ts, scheme);
  if (implicit) TSSetIFunction(ts, NULL, Residual, NULL);
  if (implicit) TSSetIJacobian(ts, A, A, Derivative, NULL);
  if (!implicit) TSSetRHSFunction(ts, NULL, Rate, NULL);
  TSSetTimeStep(ts, 0.01);
  TSSetMaxTime(ts, 1);
  TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP);
  if ((ierr = TSSolve(ts, y))) return ierr;
  TSGetConvergedReason(ts, reason);
  VecGetArrayRead(y, &value);
  *end = value[0];
  VecRestoreArrayRead(y, &value);
  *estimate = NAN;
  if (scheme) {
    VecDuplicate(y, &error);
    TSGetTimeError(ts, 0, &error);
    VecNorm(error, NORM_INFINITY, estimate);
    VecDestroy(&error);
  }
  TSDestroy(&ts);
  VecDestroy(&y);
  MatDestroy(&A);
  return 0;
}

int main(int argc, char **argv)
{
  const char       *scheme[] = {TSGLEEi1, TSGLEE23, TSGLEE24, TSGLEE35, TSGLEERK285EX}, *other[] = {TSRK, TSSSP, TSARKIMEX, TSROSW, TSBDF};
  double            end, estimate;
  TSConvergedReason reason = TS_CONVERGED_ITERATING;
  int               seen = 1;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 2;
  PetscPushErrorHandler(PetscIgnoreErrorHandler, NULL);
  for (int k = 0; k < 5; k++) {
    const int ierr = Solve(other[k], NULL, 1, &end, &reason, &estimate);

    if (ierr) printf("%s, IFunction: error %d of PETSc's\n", other[k], ierr);
    else printf("%s, IFunction: y = %.6f\n", other[k], end);
    seen = seen && (k < 2 ? ierr != 0 : !ierr && fabs(end - exp(-1)) < 0.01);
  }
  for (int k = 0; k < 5; k++)
    for (int implicit = 1; implicit >= 0; implicit--) {
      if (Solve(TSGLEE, scheme[k], implicit, &end, &reason, &estimate)) return 3;
      printf("glee %s, %s: y = %.6f, global error by its estimate %.1e, %s\n", scheme[k], implicit ? "IFunction" : "RHSFunction", end, estimate, TSConvergedReasons[reason]);
      seen = seen && reason == TS_CONVERGED_TIME && (implicit ? end == 1 && estimate == 0 : fabs(end - exp(-1)) < 0.01 && estimate > 0);
    }
  PetscFinalize();
  return !seen;
}
C
include=$(for folder in "$petsc"/include "$petsc"/../include tree/usr/include tree/usr/lib/x86_64-linux-gnu/openmpi/include; do printf ' -I %s' "$folder"; done)
cc $include try.c -o try -L "$petsc"/lib -lpetsc_real -L "$lib" -lmpi -Wl,--allow-shlib-undefined -lm
export LD_LIBRARY_PATH=$petsc/lib:$lib:$room/tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack OPAL_PREFIX=$room/tree/usr PMIX_INSTALL_PREFIX=$lib/pmix2 HWLOC_COMPONENTS=-opencl
export OMPI_MCA_mca_base_component_path=$lib/openmpi/lib/openmpi3 OMPI_MCA_ess_singleton_isolated=1 OMPI_MCA_btl=self OMPI_MCA_pml=ob1 PMIX_MCA_gds=hash
./try 2>error.txt || { tail -5 error.txt; exit 1; }
