/* What the step-size controllers share: creation routines, the error estimate, and the observation table. */
#pragma once
#include <petsc/private/tsimpl.h>
#include <slipadapt.h>
#include <slipcompat.h>
#include <slipcore.h>
#include <slipstep/private/slipstate.h>

/* The controllers, which register.c names */
PETSC_EXTERN PetscErrorCode TSAdaptCreate_RL(TSAdapt adapt);
PETSC_EXTERN PetscErrorCode TSAdaptCreate_Heuristic(TSAdapt adapt);
PETSC_EXTERN PetscErrorCode TSAdaptCreate_PI(TSAdapt adapt);
PETSC_EXTERN PetscErrorCode TSAdaptCreate_Lapusta(TSAdapt adapt);

/* ---- adapterror.c ---- */
/* Weighted local error E of the step just computed, -1 when the TS gives none, and its exponent q. */
PETSC_INTERN PetscErrorCode SlipAdaptEvaluateError(TSAdapt adapt, TS ts, PetscReal *q, PetscReal *E);
/* An error that names -ts_adapt_dt_min when h is below it. why: what made h so small. */
/* PETSc's default of -ts_adapt_clip */
#define SLIP_CLIP_LOW 0.1
#define SLIP_CLIP_HIGH 10
PETSC_INTERN PetscBool SlipAdaptClips(TSAdapt adapt, PetscReal low, PetscReal high);
PETSC_INTERN PetscErrorCode SlipAdaptCheckMinimum(TSAdapt adapt, TS ts, PetscReal h, const char why[]);

/* A controller that goes by the error estimate: its context begins with this. next: its rule, the
   next step [s] after h; E < 0: no estimate, h. */
typedef PetscReal (*SlipAdaptNextFn)(TSAdapt adapt, TS ts, PetscReal h, PetscReal E, PetscReal q, PetscBool *accept);
typedef struct {
  SlipAdaptNextFn next;
  PetscReal failure;               /* factor on the step when a solve did not converge */
  PetscReal safety, reject_safety; /* of the TSAdapt before it had this type, which the next type finds again */
} SlipAdaptByError;
PETSC_INTERN PetscErrorCode SlipAdaptCreateByError(TSAdapt adapt, SlipAdaptByError *ctx, SlipAdaptNextFn next,
                                                   PetscErrorCode (*state)(TSAdapt, SlipState));
PETSC_INTERN PetscErrorCode SlipAdaptFailureOption(TSAdapt adapt, SlipOptionItems PetscOptionsObject,
                                                   const char option[]);

/* ---- watch.c ---- */
/* What is known of an attempt of any TS that asks its controller: time, dt, converged, accepted, error */
typedef PetscErrorCode (*SlipAdaptWatchFn)(TS ts, const SlipAttempt *attempt);
PETSC_INTERN PetscErrorCode SlipAdaptWatch(TS ts, SlipAdaptWatchFn told);

/* ---- observations.c ---- */
typedef struct {
  TS ts;
  const SlipProblemOps *problem; /* NULL: the TS integrates something that tells nothing of itself */
  void *ctx;                     /* that its functions take */
  SlipAttempt last;              /* the last attempt, when there was one */
  SlipRunNumbers run;            /* what rows read; of the last attempt once SlipObserve() has begun */
  Vec w0;                        /* first state seen, for observations that the problem does not supply */
  PetscInt nown, *own;           /* the problem's own rows that are observed */
  PetscReal *value;              /* their values */
} SlipObserver;

PETSC_INTERN PetscErrorCode SlipObserverReset(SlipObserver *o);        /* frees what it holds */
PETSC_INTERN PetscErrorCode SlipObserverStart(SlipObserver *o, TS ts); /* remembers the state as w0 */
/* Look every name up, once a run. source names the policy in errors. */
PETSC_INTERN PetscErrorCode SlipObserverFindRows(SlipObserver *o, PetscInt n, SlipObserved seen[], const char source[]);
/* Fill the values; rows of the state only when state_changed. */
PETSC_INTERN PetscErrorCode SlipObserve(SlipObserver *o, PetscInt n, SlipObserved seen[], PetscBool state_changed);

/* ---- rl.c, rlset.c: context of TSADAPTRL ---- */
typedef struct {
  SlipPolicy policy;
  char problem[64];       /* whose default policy to take; empty: ask the TS */
  char default_of[64];    /* the problem whose default policy is; empty: it was given */
  TSAdaptRLActorFn actor; /* asked instead of the policy when set */
  void *actor_ctx;
  PetscReal actor_dt[2];      /* bounds that the observation "step" refers to [s] */
  PetscInt n;                 /* observations */
  SlipObserved *seen;         /* [n] */
  PetscReal *obs;             /* [n] their values */
  PetscBool needs_error;      /* an observation reads the error estimate */
  PetscBool relative;         /* the policy's steps are multiples of the last attempt's, which E > 1 rejects */
  PetscReal accuracy;         /* the dial: wanted relative error of the run's result */
  PetscBool accuracy_given;   /* by the user; else the problem may have another default */
  const SlipMeasure *measure; /* of that error; NULL: that of the policy */
  PetscReal told_dial;        /* this one was clipped, and the line of message printed */
  PetscBool told_idle;        /* options that do nothing were named */
  PetscBool sees_accuracy;    /* an observation reads it */
  SlipObserver observer;
  PetscBool begun; /* a solve is under way */
  PetscInt steps;  /* accepted steps at the last call, to notice another solve */
  /* handing over */
  PetscBool strict;        /* never */
  PetscBool handed;        /* the run under way goes on by fallback */
  TSAdapt fallback;        /* the controller that it goes on by, rlfallback.c; NULL before that */
  char fallback_name[64];  /* its type, and its filter after a colon */
  PetscBool from_options;  /* which has options */
  PetscReal handover_time; /* since then [s] */
  PetscInt handover_step;  /* accepted steps until then */
  PetscInt outside_run;    /* decisions in a row with an observation outside the training range */
  PetscBool printed;       /* the line of message */
  PetscBool told_rtol;     /* and that of a tolerance that the policy was not trained with */
  /* guard rails */
  PetscInt paced;              /* decisions since the one at pace_time */
  PetscReal pace_time;         /* [s] */
  PetscInt max_failures;       /* failed attempts in a row before steps are halved */
  PetscReal error_ceiling;     /* larger error estimates reject; 0: the policy's own, or none */
  PetscReal ceiling;           /* that of the run; 0: none */
  PetscInt solves_failed;      /* of the TS, at the last attempt */
  PetscInt hold;               /* attempts left without growth */
  PetscInt hold_after_failure; /* so many after a failed solve */
  /* counters */
  PetscInt decisions; /* steps the policy chose */
  PetscInt failures;  /* attempts that did not converge */
  PetscInt halvings;  /* steps halved by the guard rail */
  PetscInt ceilings;  /* steps rejected by the ceiling */
  PetscInt outside;   /* decisions with an observation outside the training range */
} TSAdapt_RL;

/* rlfallback.c */
PETSC_INTERN const char *TSAdaptRLFallbackType_Private(const TSAdapt_RL *rl);
PETSC_INTERN PetscErrorCode TSAdaptRLFallbackOptions_Private(TSAdapt adapt, SlipOptionItems PetscOptionsObject);
PETSC_INTERN PetscErrorCode TSAdaptRLFallbackCreate_Private(TSAdapt adapt, TS ts);
PETSC_INTERN PetscErrorCode TSAdaptRLFallbackChoose_Private(TSAdapt adapt, TS ts, PetscReal h, PetscInt *next_sc,
                                                            PetscReal *next_h, PetscBool *accept, PetscReal *wlte,
                                                            PetscReal *wltea, PetscReal *wlter);
PETSC_INTERN PetscErrorCode TSAdaptRLFallbackAfterFailure_Private(TSAdapt adapt, TS ts, PetscReal h_failed,
                                                                  PetscReal *h_next);

/* rlmeasure.c */
PETSC_INTERN PetscErrorCode TSAdaptRLFindDefault_Private(MPI_Comm comm, const char problem[], const char measure[],
                                                         char file[], size_t len, PetscBool *found);
PETSC_INTERN PetscErrorCode TSAdaptRLCheckMeasure_Private(TSAdapt adapt, const SlipProblemOps *problem,
                                                          const char name[]);
PETSC_INTERN PetscErrorCode TSAdaptRLClipDial_Private(TSAdapt adapt, PetscReal *used);

/* rlnumbers.c: what a policy says in numbers of its own; all are of the run that begins */
PETSC_INTERN PetscErrorCode TSAdaptRLSetTolerance_Private(TSAdapt adapt, TS ts);
PETSC_INTERN PetscErrorCode TSAdaptRLFirstStep_Private(TSAdapt adapt, TS ts, PetscReal *h);
PETSC_INTERN PetscErrorCode TSAdaptRLFindGuards_Private(TSAdapt adapt);

/* rlidle.c */
PETSC_INTERN PetscErrorCode TSAdaptRLWarnOfIdle_Private(TSAdapt adapt, TS ts);

/* rlset.c */
/* NULL when the controller is of another type */
static inline PetscErrorCode TSAdaptRLContext_Private(TSAdapt adapt, TSAdapt_RL **rl)
{
  PetscBool learned;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(adapt, TSADAPT_CLASSID, 1);
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTRL, &learned));
  *rl = learned ? (TSAdapt_RL *)adapt->data : NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PETSC_INTERN PetscErrorCode TSAdaptRLFindPolicy_Private(TSAdapt adapt, TS ts); /* the default one when there is none */

/* ---- adaptstate.c: for checkpoints ---- */
PETSC_INTERN PetscErrorCode SlipStateController(SlipState s, const char name[], TSAdapt adapt);
PETSC_INTERN PetscErrorCode SlipStateAdapt(SlipState s, TS ts);
