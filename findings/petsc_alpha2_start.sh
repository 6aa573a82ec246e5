#!/usr/bin/env bash
# PETSc's generalised-alpha method for second-order systems starts with twice the acceleration: its order is 1 for every radius but 1.
#
# Seen with PETSc 3.18.5 (Debian 12), TSALPHA2 with steps of one length. u'' = -sin(u) from u = u' = 1 to t = 1: with the default radius, 1,
# half the step divides the error by 4, as the method promises for all radii; with the radius 0.9, which one takes to damp what the mesh
# does not resolve, by 2, and at 128 steps the error is 300 times larger. The first step uses an acceleration from two trial steps of half
# its length, and divides their difference by half of the right time. From u = 0, u' = 1, where the acceleration is 0, every radius has
# order 2, and so has TSALPHA, of first-order systems. PETSc's repository has it mended since September 2024.
#
# Guess before the run: order 2 for all radii, from any state.
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

static PetscErrorCode Pendulum(TS ts, PetscReal t, Vec u, Vec v, Vec a, Vec f, void *context)
{
  PetscScalar x, z;
  PetscInt    first = 0;

  VecGetValues(u, 1, &first, &x);
  VecGetValues(a, 1, &first, &z);
  return VecSet(f, z + PetscSinReal(x));
}

static PetscErrorCode Derivative(TS ts, PetscReal t, Vec u, Vec v, Vec a, PetscReal dv, PetscReal da, Mat A, Mat B, void *context)
{
  PetscScalar x;
  PetscInt    first = 0;

  VecGetValues(u, 1, &first, &x);
  MatSetValue(B, 0, 0, da + PetscCosReal(x), INSERT_VALUES);
  MatAssemblyBegin(B, MAT_FINAL_ASSEMBLY);
  return MatAssemblyEnd(B, MAT_FINAL_ASSEMBLY);
}

/* the motion at t = 1 from u = start and u' = 1 */
static void End(double radius, double start, int n, double end[2])
{
  TS          ts;
  TSAdapt     adapt;
  SNES        snes;
  Vec         u, v;
  Mat         A;
  PetscScalar x;
  PetscInt    first = 0;

  TSCreate(PETSC_COMM_SELF, &ts);
  VecCreateSeq(PETSC_COMM_SELF, 1, &u);
  VecDuplicate(u, &v);
  VecSet(u, start);
  VecSet(v, 1);
  MatCreateSeqDense(PETSC_COMM_SELF, 1, 1, NULL, &A);
  TSSetType(ts, TSALPHA2);
  TSAlpha2SetRadius(ts, radius);
  TSSetI2Function(ts, NULL, Pendulum, NULL);
  TSSetI2Jacobian(ts, A, A, Derivative, NULL);
  TS2SetSolution(ts, u, v);
  TSGetAdapt(ts, &adapt);
  TSAdaptSetType(adapt, TSADAPTNONE);
  TSGetSNES(ts, &snes);
  SNESSetTolerances(snes, PETSC_DEFAULT, 1e-12, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT);
  TSSetTimeStep(ts, 1. / n);
  TSSetMaxSteps(ts, n);
  TSSetMaxTime(ts, 2);
  TSSetExactFinalTime(ts, TS_EXACTFINALTIME_STEPOVER);
  TSSolve(ts, NULL);
  VecGetValues(u, 1, &first, &x);
  end[0] = x;
  VecGetValues(v, 1, &first, &x);
  end[1] = x;
  TSDestroy(&ts);
  VecDestroy(&u);
  VecDestroy(&v);
  MatDestroy(&A);
}

int main(int argc, char **argv)
{
  const double radius[] = {1, 0.9, 0.5, 0};
  double       at128[4];
  int          seen = 1;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 2;
  for (int start = 1; start >= 0; start--) {
    double exact[2];

    End(1, start, 8192, exact);
    for (int k = 0; k < 4; k++) {
      double error[2];

      for (int half = 0; half < 2; half++) {
        double end[2];

        End(radius[k], start, 64 << half, end);
        error[half] = hypot(end[0] - exact[0], end[1] - exact[1]);
      }
      printf("from u = %d, radius %g: errors %.1e and %.1e with 64 and 128 steps, order %.2f\n", start, radius[k], error[0], error[1], log2(error[0] / error[1]));
      if (start) at128[k] = error[1];
      seen = seen && fabs(log2(error[0] / error[1]) - (start && k ? 1 : 2)) < 0.1;
    }
  }
  PetscFinalize();
  return !(seen && at128[1] > 200 * at128[0]);
}
C
include=$(for folder in "$petsc"/include "$petsc"/../include tree/usr/include tree/usr/lib/x86_64-linux-gnu/openmpi/include; do printf ' -I %s' "$folder"; done)
cc $include try.c -o try -L "$petsc"/lib -lpetsc_real -L "$lib" -lmpi -Wl,--allow-shlib-undefined -lm
export LD_LIBRARY_PATH=$petsc/lib:$lib:$room/tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack OPAL_PREFIX=$room/tree/usr PMIX_INSTALL_PREFIX=$lib/pmix2 HWLOC_COMPONENTS=-opencl
export OMPI_MCA_mca_base_component_path=$lib/openmpi/lib/openmpi3 OMPI_MCA_ess_singleton_isolated=1 OMPI_MCA_btl=self OMPI_MCA_pml=ob1 PMIX_MCA_gds=hash
./try 2>error.txt || { tail -5 error.txt; exit 1; }
