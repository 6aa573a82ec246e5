/* A run of a plain fault under a policy: what TSSolve() with TSADAPTRL does, and what the library's observations would
   say. */
#pragma once
#include "plainfault.h"

typedef struct {
  PetscInt attempts, accepted;
  double time; /* reached [s] */
} PlainTotals;

/* After each accepted step: its end [s]; the state is p's. */
typedef PetscErrorCode (*PlainWatchFn)(const PlainFault *p, double time, void *ctx);

/* From p's state at time 0 to tmax or max_steps accepted steps or twice as many attempts. */
PETSC_INTERN PetscErrorCode PlainRun(PlainFault *p, SlipPolicy policy, PetscReal accuracy, PetscReal tmax,
                                     PetscInt max_steps, PlainWatchFn fn, void *ctx, PlainTotals *totals);
