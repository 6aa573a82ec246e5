#!/usr/bin/env bash
# PETSc's ARKIMEX method bpr3, documented as of third order, has order 1 as soon as there is an explicit part.
#
# Seen with PETSc 3.18.5 (Debian 12). y' = -y from 1 to t = 1, split into an implicit and an explicit share: with all of it implicit, half
# the step divides the error by 8; with half of it or all of it explicit, by 2, and at 160 steps the error is more than 10^4 times that of
# ars443, the other method of order 3 in five stages. The last row of the explicit table sums up to 0.85 where its stage is at 1: it has 1/4
# and 3/5 (3/4 would fit). PETSc's repository of August 2026 has the same numbers. Errors look like those of any first-order method, so that
# only a series of steps shows it.
#
# Guess before the run: order 3, whatever the split.
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

static double share; /* of the implicit part */

static PetscErrorCode Explicit(TS ts, PetscReal t, Vec y, Vec f, void *context)
{
  return VecCopy(y, f) || VecScale(f, share - 1);
}

static PetscErrorCode Implicit(TS ts, PetscReal t, Vec y, Vec rate, Vec f, void *context)
{
  return VecWAXPY(f, share, y, rate);
}

static PetscErrorCode Derivative(TS ts, PetscReal t, Vec y, Vec rate, PetscReal shift, Mat A, Mat B, void *context)
{
  MatSetValue(B, 0, 0, shift + share, INSERT_VALUES);
  MatAssemblyBegin(B, MAT_FINAL_ASSEMBLY);
  return MatAssemblyEnd(B, MAT_FINAL_ASSEMBLY);
}

static double Error(const char *method, int n)
{
  TS                 ts;
  TSAdapt            adapt;
  Vec                y;
  Mat                A;
  const PetscScalar *value;
  double             error;

  TSCreate(PETSC_COMM_SELF, &ts);
  VecCreateSeq(PETSC_COMM_SELF, 1, &y);
  VecSet(y, 1);
  MatCreateSeqDense(PETSC_COMM_SELF, 1, 1, NULL, &A);
  TSSetType(ts, TSARKIMEX);
  TSARKIMEXSetType(ts, method);
  TSSetProblemType(ts, TS_LINEAR);
  if (share < 1) TSSetRHSFunction(ts, NULL, Explicit, NULL);
  if (share > 0) TSSetIFunction(ts, NULL, Implicit, NULL);
  if (share > 0) TSSetIJacobian(ts, A, A, Derivative, NULL);
  TSGetAdapt(ts, &adapt);
  TSAdaptSetType(adapt, TSADAPTNONE);
  TSSetTimeStep(ts, 1. / n);
  TSSetMaxTime(ts, 1);
  TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP);
  if (TSSolve(ts, y)) return NAN;
  VecGetArrayRead(y, &value);
  error = fabs(value[0] - exp(-1));
  VecRestoreArrayRead(y, &value);
  TSDestroy(&ts);
  VecDestroy(&y);
  MatDestroy(&A);
  return error;
}

int main(int argc, char **argv)
{
  const char *method[] = {TSARKIMEXBPR3, TSARKIMEXARS443};
  int         seen = 1;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 2;
  for (share = 0; share <= 1; share += 0.5) {
    double narrow[2];

    for (int k = 0; k < 2; k++) {
      const double wide = Error(method[k], 80);

      narrow[k] = Error(method[k], 160);
      printf("%s, implicit share %g: errors %.1e and %.1e with 80 and 160 steps, order %.2f\n", method[k], share, wide, narrow[k], log2(wide / narrow[k]));
      seen = seen && fabs(log2(wide / narrow[k]) - (k == 0 && share < 1 ? 1 : 3)) < 0.2;
    }
    seen = seen && (share == 1 || narrow[0] > 1e4 * narrow[1]);
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
