/* Context of TSADAPTRL, shared by rl.c (decisions) and rlset.c (object, options, view). */
#pragma once
#include <slipstep/private/slipadaptimpl.h>

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
