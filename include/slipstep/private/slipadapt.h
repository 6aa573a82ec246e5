/* What the step-size controllers share: creation routines, the error estimate, and the observation table. */
#pragma once
#include <petsc/private/tsimpl.h>
#include <slipadapt.h>
#include <slipcompat.h>

PETSC_EXTERN PetscErrorCode TSAdaptCreate_Heuristic(TSAdapt adapt);
PETSC_EXTERN PetscErrorCode TSAdaptCreate_PI(TSAdapt adapt);
PETSC_EXTERN PetscErrorCode TSAdaptCreate_RL(TSAdapt adapt);

/* Weighted local error E of the step just computed and its order p; E = -1 when the TS gives none. */
PETSC_INTERN PetscErrorCode SlipAdaptEvaluateError(TSAdapt adapt, TS ts, PetscInt *order, PetscReal *E);
/* An error that names -ts_adapt_dt_min when h is below it. why: what made h so small. */
PETSC_INTERN PetscErrorCode SlipAdaptCheckMinimum(TSAdapt adapt, TS ts, PetscReal h, const char why[]);

/* The controllers whose data begins with the factor on the step after a solve that did not converge: their option, in
   (0, 1), "TSAdaptChooseAfterFailure_C" and destruction. */
PETSC_INTERN PetscErrorCode SlipAdaptFailureOption(TSAdapt adapt, SlipOptionItems PetscOptionsObject,
                                                   const char option[]);
PETSC_INTERN PetscErrorCode SlipAdaptAfterFailure(TSAdapt adapt, TS ts, PetscReal h_failed, PetscReal *h_next);
PETSC_INTERN PetscErrorCode SlipAdaptDestroyData(TSAdapt adapt);

/* Pure: the heuristic's factor min(growth, E^-q), E >= 0. */
static inline PetscReal SlipHeuristicFactor(PetscReal E, PetscReal q, PetscReal growth)
{
  return E > 0 ? PetscMin(growth, PetscPowReal(E, -q)) : growth;
}

/* ---- observations ---- */

/* What a row may look at. */
typedef struct {
  TS ts;
  PetscBool started;  /* an attempt was made */
  SlipAttempt last;   /* the last attempt, when started */
  PetscReal time;     /* time of the state that is observed [s] */
  PetscReal max_time; /* [s] */
  PetscReal tstar;    /* T* [s] */
  PetscReal accuracy; /* wanted relative error of the run's result */
  PetscReal dt_min;   /* bounds of the steps that can be chosen [s] */
  PetscReal dt_max;
  PetscInt failures; /* attempts in a row that did not converge */
  Vec w0;            /* first state seen, for observations that the problem does not supply */
  PetscReal w0_norm; /* its 2-norm */
  PetscReal w0_max;  /* its largest magnitude */
} SlipObserver;

typedef enum {
  SLIP_OBSERVES_ATTEMPT, /* anything known without asking for more */
  SLIP_OBSERVES_ERROR,   /* reads last.error */
  SLIP_OBSERVES_STATE    /* the TS solution only: kept over a failed attempt; the problem's own row goes first */
} SlipObservationKind;

typedef struct {
  const char *name;
  SlipObservationKind kind;
  /* one of these: pure, of what the observer knows; or collective, of the state */
  PetscReal (*number)(const SlipObserver *);
  PetscErrorCode (*measure)(const SlipObserver *, PetscInt component, PetscReal *value);
  const char *meaning;
} SlipObservation;

#define SLIP_OBSERVES_ACCURACY "log_accuracy" /* the row that reads the dial */

/* One value that a policy asked for by name. */
typedef struct {
  char name[64];
  const SlipObservation *row; /* NULL: only the problem knows it */
  PetscInt component;         /* k of state_k */
  PetscReal value;            /* last value */
  size_t change;              /* length of "change_" when the name begins with it: the row is that of the rest */
  PetscBool has_base;         /* a change is taken from */
  PetscReal base;             /* the value at the accepted step before */
} SlipObserved;

/* Name and row of what is to be observed; no value yet. */
PETSC_INTERN PetscErrorCode SlipObservedSet(SlipObserved *seen, const char name[]);
PETSC_INTERN PetscErrorCode SlipObserverReset(SlipObserver *o);        /* frees w0 */
PETSC_INTERN PetscErrorCode SlipObserverStart(SlipObserver *o, TS ts); /* remembers the state as w0 */
/* Fill the values; rows of the state only when state_changed. source names the policy in errors. */
PETSC_INTERN PetscErrorCode SlipObserve(const SlipObserver *o, PetscInt n, SlipObserved seen[], PetscBool state_changed,
                                        const char source[]);

/* ---- rl*.c: context of TSADAPTRL ---- */
typedef struct {
  SlipPolicy policy;
  char problem[64];       /* whose default policy to take; empty: ask the TS */
  char default_of[64];    /* the problem whose default policy is; empty: it was given */
  TSAdaptRLActorFn actor; /* asked instead of the policy when set */
  void *actor_ctx;
  PetscReal actor_dt[2];   /* bounds that the observation "step" refers to [s] */
  PetscInt n;              /* observations */
  SlipObserved *seen;      /* [n] */
  PetscReal *obs;          /* [n] their values */
  PetscBool needs_error;   /* an observation reads the error estimate */
  PetscReal accuracy;      /* the dial: wanted relative error of the run's result */
  PetscBool sees_accuracy; /* an observation reads it */
  SlipObserver observer;
  PetscBool begun; /* a solve is under way */
  PetscInt steps;  /* accepted steps at the last call, to notice another solve */
  /* guard rails */
  PetscInt max_failures;   /* failed attempts in a row before steps are halved */
  PetscReal error_ceiling; /* larger error estimates reject; 0: none */
  /* counters */
  PetscInt decisions; /* steps the policy chose */
  PetscInt failures;  /* attempts that did not converge */
  PetscInt halvings;  /* steps halved by the guard rail */
  PetscInt ceilings;  /* steps rejected by the ceiling */
  PetscInt outside;   /* decisions with an observation outside the training range */
} TSAdapt_RL;

/* rlrest.c: limit the step that the policy chose by its attribute moving_dt_max, or extend it to the end of a rest. */
PETSC_INTERN PetscErrorCode TSAdaptRLMind_Private(TSAdapt adapt, TS ts, PetscReal *h);
PETSC_INTERN PetscErrorCode TSAdaptRLSetNames_Private(TSAdapt adapt, PetscInt n, const char *const names[]);
PETSC_INTERN PetscErrorCode TSAdaptRLFindPolicy_Private(TSAdapt adapt, TS ts); /* the default one when there is none */
PETSC_INTERN PetscErrorCode TSAdaptRLForgetDefault_Private(TSAdapt adapt);
PETSC_INTERN PetscErrorCode TSAdaptRLWarnOutside_Private(TSAdapt adapt, PetscInt outside);
PETSC_INTERN PetscErrorCode TSAdaptChooseFirst_RL(TSAdapt adapt, TS ts, PetscReal *h);
PETSC_INTERN PetscErrorCode TSAdaptChooseAfterFailure_RL(TSAdapt adapt, TS ts, PetscReal h_failed, PetscReal *h_next);
PETSC_INTERN PetscErrorCode TSAdaptNeedsError_RL(TSAdapt adapt, PetscBool *flg);
PETSC_INTERN PetscErrorCode TSAdaptChoose_RL(TSAdapt adapt, TS ts, PetscReal h, PetscInt *next_sc, PetscReal *next_h,
                                             PetscBool *accept, PetscReal *wlte, PetscReal *wltea, PetscReal *wlter);
