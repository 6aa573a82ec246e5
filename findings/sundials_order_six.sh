#!/usr/bin/env bash
# SUNDIALS' ERKStep of order 6 has order 3: from the second step on its first stage uses the rate of another state.
#
# Seen with ARKODE of SUNDIALS 6.4.1 (Debian 12), ERKStepSetOrder(m, 6), which takes the table ARKODE_VERNER_8_5_6. The table is right, a
# single step too, and ARKodeButcherTable_CheckOrder() says 6. But then the rate of the last stage, which also stands at the end of
# the step (c = 1), is taken for the rate at the new state, as in methods whose first stage is the last one before: 7 calls a step for 8
# stages. y' = y to t = 2: half the step divides the error by 8 only, and order 5 is 3000 times closer with as many steps. ARKStep with the
# same table has order 6. SUNDIALS' issue 311 is about it; the list of changes has it fixed after 6.6.1, which Debian 12 does not have.
#
# Guess before the run: order 6 by both.
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
#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_erkstep.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <stdio.h>

static int calls;

static int Growth(realtype t, N_Vector y, N_Vector rate, void *context)
{
  calls++;
  NV_Ith_S(rate, 0) = NV_Ith_S(y, 0);
  return 0;
}

/* the error after steps of y' = y from 1 by fixed steps that all end where they are compared */
static double Error(SUNContext context, int order, int erk, double h, int steps)
{
  N_Vector y = N_VNew_Serial(1, context);
  realtype t = 0;
  void    *memory;

  NV_Ith_S(y, 0) = 1;
  memory = erk ? ERKStepCreate(Growth, 0, y, context) : ARKStepCreate(Growth, NULL, 0, y, context);
  if (erk) {
    ERKStepSetOrder(memory, order);
    ERKStepSStolerances(memory, 1e-6, 1e-6);
    ERKStepSetFixedStep(memory, h);
  } else {
    ARKStepSetOrder(memory, order);
    ARKStepSStolerances(memory, 1e-6, 1e-6);
    ARKStepSetFixedStep(memory, h);
  }
  calls = 0;
  for (int k = 0; k < steps; k++) {
    if ((erk ? ERKStepEvolve(memory, 10, y, &t, ARK_ONE_STEP) : ARKStepEvolve(memory, 10, y, &t, ARK_ONE_STEP)) < 0) return NAN;
  }
  return fabs(NV_Ith_S(y, 0) - exp(t));
}

int main(void)
{
  SUNContext         context;
  ARKodeButcherTable table = ARKodeButcherTable_LoadERK(ARKODE_VERNER_8_5_6);
  int                q, p, seen;

  if (SUNContext_Create(NULL, &context)) return 2;
  ARKodeButcherTable_CheckOrder(table, &q, &p, NULL);
  printf("ARKODE_VERNER_8_5_6: %d stages, order %d by its check; one step of 0.125 is off by %.1e\n", table->stages, q, Error(context, 6, 1, 0.125, 1));
  seen = q == 6 && table->stages == 8 && Error(context, 6, 1, 0.125, 1) < 1e-10;
  for (int erk = 0; erk < 2; erk++) {
    for (int order = 5; order < 7; order++) {
      double wide = Error(context, order, erk, 0.125, 16), narrow = Error(context, order, erk, 0.0625, 32), measured = log2(wide / narrow);

      printf("%s, order %d: error %.1e by 16 steps, %.1e by 32, order %.2f; %d calls\n", erk ? "ERKStep" : "ARKStep", order, wide, narrow, measured, calls);
      seen = seen && (order == 5 ? fabs(measured - 5) < 0.1 : erk ? measured < 3.1 && wide > 1e-4 && calls == 32 * 7 + 1 : fabs(measured - 6) < 0.1);
    }
  }
  return !seen;
}
C
cc -I tree/usr/include -I "$lib"/openmpi/include try.c -o try -L "$lib" -lsundials_arkode -lsundials_nvecserial -lm -Wl,--allow-shlib-undefined
LD_LIBRARY_PATH=$lib:$room/tree/lib/x86_64-linux-gnu:$lib/blas:$lib/lapack ./try
