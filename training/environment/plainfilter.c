/* See plainfilter.h. */
#include "plainfilter.h"
#include <slipcompat.h>

#define AFTER_FAILURE (PetscReal)0.6 /* -ts_adapt_pi_failure_factor's default */
#define POWER (1. / 3)               /* the embedded estimate goes with h^3 */

PetscErrorCode PlainRunFilter(PlainFault *p, const SlipFilter *filter, const PetscReal atol[], PetscReal rtol,
                              PetscReal dt, PetscReal tmax, PetscInt max_steps, PlainWatchFn fn, void *ctx,
                              PlainTotals *totals)
{
  SlipFilterMemory memory = {.error = 1};
  PetscReal h = PetscMin(dt, tmax), E;
  PetscBool accept;

  PetscFunctionBegin;
  *totals = (PlainTotals){0, 0, 0};
  while (totals->time < tmax && totals->accepted < max_steps && totals->attempts < 2 * max_steps) {
    const PetscReal tried = h;

    totals->attempts++;
    if (!PlainFaultAttempt(p, tried)) {
      h = PetscMin(AFTER_FAILURE * tried, tmax - totals->time);
      continue;
    }
    E = PlainFaultError(p, tried, atol, rtol);
    h = tried * SlipControlFilter(filter, &memory, (PetscReal)POWER, E, tried, PETSC_FALSE, &accept);
    if (!accept) continue;
    totals->accepted++;
    totals->time += tried;
    PlainFaultAccept(p);
    h = SlipControlMatch(h, tmax - totals->time);
    PetscCall(fn(p, totals->time, ctx));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
