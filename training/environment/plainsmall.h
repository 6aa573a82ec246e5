/* Runs of a small system under a policy without objects: what TSSolve() with TSADAPTRL does, and what the observations
   say, some ten times faster. The default integrator; systems A dw/dt = G w + f(t) e_0 + F_r e_0 with F_r in -q
   Sign(w_0). */
#pragma once
#include "plainpolicy.h"
#include "problem.h"
#include <slipstep/rooms.h>

/* ---- errors of a run of a small system against its exact solution ---- */

#define SMALL_MAX_STATES 3

/* The exact solution, linear between its times. */
struct _EnvReference {
  PetscReal dt;
  PetscInt n, states;
  PetscReal *state; /* [n][states] */
};

typedef struct {
  EnvReference reference;
  PetscReal seen, error2, size2;    /* time, squared error and squared size at the last accepted step */
  PetscReal last[SMALL_MAX_STATES]; /* state there */
  PetscReal errors, sizes;          /* their integrals, trapezoidal rule */
  PetscInt next;                    /* first time of the table that is not seen yet */
  PetscReal between, between_size;  /* sums over the times of the table, the run taken linear between its steps */
} SmallErrors;

/* w: state at time 0 [states] */
PETSC_INTERN void SmallErrorsStart(EnvReference reference, const PetscReal w[], SmallErrors *e);
/* A step from the last state to w at time t */
PETSC_INTERN void SmallErrorsStep(SmallErrors *e, PetscReal t, const PetscReal w[]);
/* The relative L2 norm at the ends of steps, and that with the times between them */
PETSC_INTERN void SmallErrorsEnd(const SmallErrors *e, PetscReal error[2]);

/* ---- runs ---- */

typedef struct {
  PetscInt n;
  PetscReal A[SMALL_MAX_STATES], G[SMALL_MAX_STATES][SMALL_MAX_STATES], q;
  PetscReal start[SMALL_MAX_STATES];
  PetscReal tstar, tmax, dt_low, dt_high; /* [s]; the controller's limits of the step */
  SlipModel model;                        /* whose load (NULL: none) and observations these are */
  PetscReal (*force)(SlipModel model, PetscReal t);
} PlainSmall;

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
