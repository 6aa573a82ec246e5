/* Runs of a small system under a policy without objects: what TSSolve() with TSADAPTRL does, and what the observations
   say, some ten times faster. The default integrator; systems A dw/dt = G w + f(t) e_0 + F_r e_0 with F_r in -q
   Sign(w_0). */
#pragma once
#include "plainpolicy.h"
#include "smallerrors.h"
#include <slipstep/rooms.h>

typedef struct PlainSmall PlainSmall;
struct PlainSmall {
  PetscInt n;
  PetscReal A[SMALL_MAX_STATES], G[SMALL_MAX_STATES][SMALL_MAX_STATES], q;
  PetscReal start[SMALL_MAX_STATES];
  PetscReal tstar, tmax, dt_low, dt_high; /* [s]; the controller's limits of the step */
  SlipModel model;                        /* whose load (NULL: none) and observations these are */
  PetscReal (*force)(SlipModel model, PetscReal t);
};

typedef struct {
  PetscInt steps;
  PetscBool finished;
  PetscReal error[2]; /* as SmallErrorsEnd() */
} PlainSmallResult;

/* After each choice: the observations of the policy [n] */
typedef void (*PlainSmallWatchFn)(PetscInt n, const PetscReal obs[], void *ctx);

/* From the start to tmax or max_steps steps. fn: NULL allowed */
PETSC_INTERN PetscErrorCode PlainSmallRun(const PlainSmall *p, PlainPolicy *policy, PetscReal accuracy,
                                          EnvReference reference, PetscInt max_steps, PlainSmallWatchFn fn, void *ctx,
                                          PlainSmallResult *result);
