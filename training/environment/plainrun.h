/* Runs of a plain fault: under a policy what TSSolve() with TSADAPTRL does, and what the library's observations would
   say. */
#pragma once
#include "plainfault.h"
#include "plainpolicy.h"

typedef struct {
  PetscInt attempts, accepted;
  double products; /* with K and H, of a run whose steps may be explicit: those of implicit ones by what they cost */
  double time;     /* reached [s] */
} PlainTotals;

/* After each accepted step: its end [s]; the state is p's. */
typedef PetscErrorCode (*PlainWatchFn)(const PlainFault *p, double time, void *ctx);

/* From p's state at time 0 to tmax or max_steps accepted steps or twice as many attempts. costs: steps are explicit,
   and no longer than stable, where that takes fewer products; NULL: all are implicit. */
PETSC_INTERN PetscErrorCode PlainRun(PlainFault *p, PlainPolicy *policy, PetscReal accuracy, PetscReal tmax,
                                     const SlipMethodCosts *costs, PetscInt max_steps, PlainWatchFn fn, void *ctx,
                                     PlainTotals *totals);
