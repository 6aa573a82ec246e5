#!/usr/bin/env bash
# PETSc's Runge-Kutta pairs but 5dp interpolate by a straight line through the step: runs that end by interpolation have order 2.
#
# Seen with PETSc 3.18.5 (Debian 12). TSInterpolate(), and with it -ts_exact_final_time interpolate, works without an error for every pair
# of TSRK, but only 5dp brings coefficients of interpolation. y' = y from 1, with the end in the middle of a step: the error falls by
# 4 when the step is halved, with 3bs (the default, order 3) as with 8vr (order 8). With 5f and a step of 0.05 it is 10^6 times that
# of the step itself. A run that ends or writes between steps therefore needs 5dp, or steps that end there.
#
# Guess before the run: the order of the pair or one less, as in other codes, or an error for a pair that cannot interpolate.
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

static PetscErrorCode Growth(TS ts, PetscReal t, Vec x, Vec f, void *context)
{
  return VecCopy(x, f);
}

/* the error at the end of y' = y from 1 to the middle of a step, or to the end of that step */
static double Error(const char *pair, double h, TSExactFinalTimeOption end)
{
  TS                 ts;
  TSAdapt            adapt;
  Vec                x;
  PetscReal          t;
  const PetscScalar *value;
  double             error;

  TSCreate(PETSC_COMM_SELF, &ts);
  VecCreateSeq(PETSC_COMM_SELF, 1, &x);
  VecSet(x, 1);
  TSSetType(ts, TSRK);
  TSRKSetType(ts, pair);
  TSSetRHSFunction(ts, NULL, Growth, NULL);
  TSGetAdapt(ts, &adapt);
  TSAdaptSetType(adapt, TSADAPTNONE);
  TSSetTimeStep(ts, h);
  TSSetMaxTime(ts, 1 + h / 2);
  TSSetExactFinalTime(ts, end);
  if (TSSolve(ts, x)) return NAN;
  TSGetSolveTime(ts, &t);
  VecGetArrayRead(x, &value);
  error = fabs(value[0] - exp(t));
  VecRestoreArrayRead(x, &value);
  TSDestroy(&ts);
  VecDestroy(&x);
  return error;
}

int main(int argc, char **argv)
{
  const char *pair[] = {TSRK3BS, TSRK4, TSRK5F, TSRK6VR, TSRK8VR, TSRK5DP};
  int         seen   = 1;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 2;
  for (int k = 0; k < 6; k++) {
    double wide = Error(pair[k], 0.1, TS_EXACTFINALTIME_INTERPOLATE), narrow = Error(pair[k], 0.05, TS_EXACTFINALTIME_INTERPOLATE);
    double order = log2(wide / narrow), step = Error(pair[k], 0.05, TS_EXACTFINALTIME_STEPOVER);

    printf("%s: interpolated %.1e at a step of 0.1, %.1e at 0.05, order %.2f; end of that step %.1e\n", pair[k], wide, narrow, order, step);
    seen = seen && (k < 5 ? fabs(order - 2) < 0.1 && narrow > 50 * step : order > 4.5);
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
