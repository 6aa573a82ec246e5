/* A run of a plain fault under a digital filter: what TSSolve() with TSADAPTPI does. */
#pragma once
#include "plainrun.h"

/* atol [3 n] of v, u, s of each cell; dt: first step [s]. Ends as PlainRun(). */
PETSC_INTERN PetscErrorCode PlainRunFilter(PlainFault *p, const SlipFilter *filter, const PetscReal atol[],
                                           PetscReal rtol, PetscReal dt, PetscReal tmax, PetscInt max_steps,
                                           PlainWatchFn fn, void *ctx, PlainTotals *totals);
