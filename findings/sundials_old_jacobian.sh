#!/usr/bin/env bash
# CVODE's BDF lets a stuck slider stay stuck: its Newton iteration takes an old Jacobian and calls that convergence.
#
# Seen with CVODE of SUNDIALS 6.4.1 (Debian 12). A slider of mass 1 under a force t with the friction tanh(v/1e-8), as Coulomb friction is
# regularised: v is about 0 to t = 1 and (t - 1)^2/2 after it, 0.5 at t = 2. With the tolerances 1e-5 and 1e-7 CVODE returns CV_SUCCESS and
# 0.279 after 28 steps; with 1e-3 and 1e-5 it returns 3.5e-8 after 3, the slider never moves. At rest the Jacobian is -1e8; kept for later
# steps, it makes each correction tiny, which passes for convergence and, as the error estimate, for accuracy, so that steps grow. A
# Jacobian in each step (CVodeSetLSetupFrequency() and CVodeSetJacEvalFrequency(), 1) and a coefficient of 1e-4 instead of 0.1 in
# CVodeSetNonlinConvCoef() cure it, in 20 and 51 steps; so does an absolute tolerance below the width of the law. lsode of Octave 7.3.0,
# VODE and RADAU5 of deSolve 1.34 do alike at 1e-3.
#
# Guess before the run: an error of about the tolerance, or a failure of the solver.
# Exit code: 0 as seen, 1 when it behaves in another way, 77 when the packages cannot be had.
set -euo pipefail
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
cd "$room"
mkdir -p debs/partial tree && : >status
apt-get -qq -y -o Dir::State::status="$room/status" -o Dir::Cache::archives="$room/debs" -o Debug::NoLocking=1 --no-install-recommends \
  --download-only install libsundials-dev=6.4.1+dfsg1-3 >apt.log 2>&1 || { tail -3 apt.log; exit 77; }
rm -f debs/libc6_*.deb debs/libc6-dev_*.deb
for deb in debs/*.deb; do dpkg -x "$deb" tree; done
lib=$room/tree/usr/lib/x86_64-linux-gnu

cat >try.c <<'C'
#include <cvode/cvode.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <stdio.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

static int Rate(realtype t, N_Vector v, N_Vector rate, void *context)
{
  NV_Ith_S(rate, 0) = t - tanh(NV_Ith_S(v, 0) / 1e-8);
  return 0;
}

/* v at t = 2; strict: a new Jacobian in each step, and a smaller coefficient of convergence */
static double Slide(SUNContext context, double relative, double absolute, int strict, int *flag, long *steps)
{
  N_Vector        v = N_VNew_Serial(1, context);
  SUNMatrix       A = SUNDenseMatrix(1, 1, context);
  SUNLinearSolver solver = SUNLinSol_Dense(v, A, context);
  void           *m = CVodeCreate(CV_BDF, context);
  realtype        t = 0;
  double          end;

  NV_Ith_S(v, 0) = 0;
  CVodeInit(m, Rate, 0, v);
  CVodeSStolerances(m, relative, absolute);
  CVodeSetLinearSolver(m, solver, A);
  CVodeSetMaxNumSteps(m, 100000);
  if (strict) CVodeSetLSetupFrequency(m, 1);
  if (strict) CVodeSetJacEvalFrequency(m, 1);
  if (strict) CVodeSetNonlinConvCoef(m, 1e-4);
  *flag = CVode(m, 2, v, &t, CV_NORMAL);
  CVodeGetNumSteps(m, steps);
  end = NV_Ith_S(v, 0);
  CVodeFree(&m);
  SUNLinSolFree(solver);
  SUNMatDestroy(A);
  N_VDestroy(v);
  return end;
}

int main(void)
{
  const double relative[] = {1e-3, 1e-5, 1e-7}, absolute[] = {1e-5, 1e-7, 1e-9};
  SUNContext   context;
  int          seen = 1;

  SUNContext_Create(NULL, &context);
  for (int k = 0; k < 3; k++)
    for (int strict = 0; strict < 2; strict++) {
      int    flag;
      long   steps;
      double v = Slide(context, relative[k], absolute[k], strict, &flag, &steps);

      printf("tolerances %.0e and %.0e, %s: v = %.4g after %ld steps, 0.5 is right; flag %d\n", relative[k], absolute[k],
             strict ? "strict" : "as it is", v, steps, flag);
      seen = seen && flag == CV_SUCCESS && (strict || k == 2 ? fabs(v - 0.5) < 1e-3 : k ? fabs(v - 0.5) > 0.1 : v < 1e-6);
    }
  return !seen;
}
C
cc -I tree/usr/include -I "$lib"/openmpi/include try.c -o try -L "$lib" -lsundials_cvode -lsundials_sunlinsoldense -lsundials_sunmatrixdense -lsundials_nvecserial -lm -Wl,--allow-shlib-undefined
LD_LIBRARY_PATH=$lib:$room/tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack ./try
