#!/usr/bin/env bash
# PETSc's BDF of orders 3 to 6 has order 2 with steps of one length: its first steps are of low order, and their error stays.
#
# Seen with PETSc 3.18.5 (Debian 12). y' = y cos t from 1 to t = 3, TSAdapt none. Order 2 divides the error by 4 with half the step, as it
# should; orders 3 to 6 do so too, and with 320 steps the error of order 6 is 0.6 times that of order 2. The first step is a backward Euler
# step, the next ones climb one order at a time, all with the length that was asked for: together an error of h^2 that nothing takes away.
# With adaptive steps the first ones are short and errors follow the tolerance. In a test of convergence higher orders look broken.
#
# Guess before the run: the order that is asked for, by a start with short steps or a one-step method.
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
  return VecCopy(y, f) || VecScale(f, PetscCosReal(t));
}

static PetscErrorCode Derivative(TS ts, PetscReal t, Vec y, Mat A, Mat B, void *context)
{
  MatSetValue(B, 0, 0, PetscCosReal(t), INSERT_VALUES);
  MatAssemblyBegin(B, MAT_FINAL_ASSEMBLY);
  return MatAssemblyEnd(B, MAT_FINAL_ASSEMBLY);
}

static double Error(int order, int n)
{
  TS                 ts;
  TSAdapt            adapt;
  SNES               snes;
  Vec                y;
  Mat                A;
  const PetscScalar *value;
  double             error;

  TSCreate(PETSC_COMM_SELF, &ts);
  VecCreateSeq(PETSC_COMM_SELF, 1, &y);
  VecSet(y, 1);
  MatCreateSeqDense(PETSC_COMM_SELF, 1, 1, NULL, &A);
  TSSetType(ts, TSBDF);
  TSBDFSetOrder(ts, order);
  TSSetRHSFunction(ts, NULL, Rate, NULL);
  TSSetRHSJacobian(ts, A, A, Derivative, NULL);
  TSSetTimeStep(ts, 3. / n);
  TSSetMaxSteps(ts, n);
  TSSetMaxTime(ts, 4);
  TSSetExactFinalTime(ts, TS_EXACTFINALTIME_STEPOVER);
  TSGetAdapt(ts, &adapt);
  TSAdaptSetType(adapt, TSADAPTNONE);
  TSGetSNES(ts, &snes);
  SNESSetTolerances(snes, 1e-13, 1e-13, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT);
  if (TSSolve(ts, y)) return NAN;
  VecGetArrayRead(y, &value);
  error = fabs(value[0] - exp(sin(3)));
  VecRestoreArrayRead(y, &value);
  TSDestroy(&ts);
  VecDestroy(&y);
  MatDestroy(&A);
  return error;
}

int main(int argc, char **argv)
{
  double at[7];
  int    seen = 1;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 2;
  for (int order = 1; order <= 6; order++) {
    const double wide = Error(order, 160), narrow = Error(order, 320), seen_order = log2(wide / narrow);

    at[order] = narrow;
    printf("order %d: errors %.1e and %.1e with 160 and 320 steps, order %.2f\n", order, wide, narrow, seen_order);
    seen = seen && (order == 1 ? fabs(seen_order - 1) < 0.1 : fabs(seen_order - 2) < 0.25);
  }
  PetscFinalize();
  return !(seen && at[6] > 0.1 * at[2]);
}
C
include=$(for folder in "$petsc"/include "$petsc"/../include tree/usr/include tree/usr/lib/x86_64-linux-gnu/openmpi/include; do printf ' -I %s' "$folder"; done)
cc $include try.c -o try -L "$petsc"/lib -lpetsc_real -L "$lib" -lmpi -Wl,--allow-shlib-undefined -lm
export LD_LIBRARY_PATH=$petsc/lib:$lib:$room/tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack OPAL_PREFIX=$room/tree/usr PMIX_INSTALL_PREFIX=$lib/pmix2 HWLOC_COMPONENTS=-opencl
export OMPI_MCA_mca_base_component_path=$lib/openmpi/lib/openmpi3 OMPI_MCA_ess_singleton_isolated=1 OMPI_MCA_btl=self OMPI_MCA_pml=ob1 PMIX_MCA_gds=hash
./try 2>error.txt || { tail -5 error.txt; exit 1; }
