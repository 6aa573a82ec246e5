/* Long works of the library report which share of them is done to whoever listens, which a run does to print it. */
#include <petsctime.h>
#include <slipstep/private/slipsys.h>

#define WAIT_SECONDS 5 /* wall time between reports */

static SlipWaitFn listener;
static void *context;
static PetscLogDouble last; /* time of the last report, or when listening began */

/* Calls a function with ctx for reports from now on; NULL: for none. */
PetscErrorCode SlipWaitListen(SlipWaitFn fn, void *ctx)
{
  PetscFunctionBegin;
  listener = fn;
  context = ctx;
  PetscCall(PetscTime(&last));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a report is due. */
PetscBool SlipWaitDue(void)
{
  PetscLogDouble now;

  return listener && !PetscTime(&now) && now - last >= WAIT_SECONDS ? PETSC_TRUE : PETSC_FALSE;
}

/* Reports which share, in [0, 1], of a work this process has done. Not collective. */
PetscErrorCode SlipWaitReport(const char what[], PetscReal share)
{
  PetscFunctionBegin;
  PetscCall(PetscTime(&last));
  if (listener) PetscCall((*listener)(context, what, share));
  PetscFunctionReturn(PETSC_SUCCESS);
}
