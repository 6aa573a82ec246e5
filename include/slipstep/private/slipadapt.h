/* Internal interface of the step-size controllers: creation routines, the error estimate, and the observation table */
#pragma once
#include <petsc/private/tsimpl.h>
#include <slipstep/rooms/slipadapt.h>
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>
#include <slipstep/private/slipstate.h>

/* The controllers that register.c registers */
PETSC_EXTERN PetscErrorCode TSAdaptCreate_RL(TSAdapt adapt);
PETSC_EXTERN PetscErrorCode TSAdaptCreate_Heuristic(TSAdapt adapt);
PETSC_EXTERN PetscErrorCode TSAdaptCreate_PI(TSAdapt adapt);
PETSC_EXTERN PetscErrorCode TSAdaptCreate_Lapusta(TSAdapt adapt);

/* ---- adapterror.c ---- */
/* Weighted local error E of the last step, -1 if the TS estimates none, and its exponent q */
PETSC_INTERN PetscErrorCode SlipAdaptEvaluateError(TSAdapt adapt, TS ts, PetscReal *q, PetscReal *E);
/* PETSc's default of -ts_adapt_clip */
#define SLIP_CLIP_LOW 0.1
#define SLIP_CLIP_HIGH 10
PETSC_INTERN PetscBool SlipAdaptClips(TSAdapt adapt, PetscReal low, PetscReal high);
/* Raises an error that names -ts_adapt_dt_min if h is below it. why: what made h so small */
PETSC_INTERN PetscErrorCode SlipAdaptCheckMinimum(TSAdapt adapt, TS ts, PetscReal h, const char why[]);

/* Context of a controller that uses the error estimate; the context of each such type begins with it. next is its rule,
   the next step [s] after h; E < 0: there is no estimate, and h is returned. */
typedef PetscReal (*SlipAdaptNextFn)(TSAdapt adapt, TS ts, PetscReal h, PetscReal E, PetscReal q, PetscBool *accept);
typedef struct {
  SlipAdaptNextFn next;
  PetscReal failure;               /* factor on the step when a solve did not converge */
  PetscReal safety, reject_safety; /* of the TSAdapt before it had this type, restored for the next type */
} SlipAdaptByError;
PETSC_INTERN PetscErrorCode SlipAdaptCreateByError(TSAdapt adapt, SlipAdaptByError *ctx, SlipAdaptNextFn next,
                                                   PetscErrorCode (*state)(TSAdapt, SlipState));
PETSC_INTERN PetscErrorCode SlipAdaptFailureOption(TSAdapt adapt, SlipOptionItems PetscOptionsObject,
                                                   const char option[]);

/* ---- watch.c ---- */
/* Called for each attempt of any TS that calls its controller, with time, dt, converged, accepted and error */
typedef PetscErrorCode (*SlipAdaptWatchFn)(TS ts, const SlipAttempt *attempt);
PETSC_INTERN PetscErrorCode SlipAdaptWatch(TS ts, SlipAdaptWatchFn told);

/* ---- observations.c ---- */
typedef struct {
  TS ts;
  const SlipProblemOps *problem; /* NULL: the TS integrates something else than a SlipStep problem */
  void *ctx;                     /* context of its functions */
  SlipAttempt last;              /* the last attempt, if there was one */
  SlipRunNumbers run;            /* input of the rows, for the last attempt once SlipObserve() has begun */
  Vec w0;                        /* first state, for observations that the problem does not supply */
  PetscInt nown, *own;           /* the problem's own rows that are observed */
  PetscReal *value;              /* their values */
} SlipObserver;

PETSC_INTERN PetscErrorCode SlipObserverReset(SlipObserver *o);        /* frees its content */
PETSC_INTERN PetscErrorCode SlipObserverStart(SlipObserver *o, TS ts); /* stores the state as w0 */
/* Looks every name up, once a run. source names the policy in errors. */
PETSC_INTERN PetscErrorCode SlipObserverFindRows(SlipObserver *o, PetscInt n, SlipObserved seen[], const char source[]);
/* Computes the values; rows of the state only if state_changed. */
PETSC_INTERN PetscErrorCode SlipObserve(SlipObserver *o, PetscInt n, SlipObserved seen[], PetscBool state_changed);

/* ---- rl.c, rlset.c: context of TSADAPTRL ---- */
typedef struct {
  SlipPolicy policy;
  char problem[64];       /* whose default policy to use; empty: that of the TS */
  char default_of[64];    /* the problem whose default policy this is; empty: the user set it */
  TSAdaptRLActorFn actor; /* called instead of the policy if set */
  void *actor_ctx;
  PetscReal actor_dt[2];      /* bounds that the observation "step" refers to [s] */
  PetscInt n;                 /* observations */
  SlipObserved *seen;         /* [n] */
  PetscReal *obs;             /* [n] their values */
  PetscBool needs_error;      /* an observation reads the error estimate */
  PetscBool relative;         /* the policy's steps are multiples of the last attempt's, which E > 1 rejects */
  PetscReal accuracy;         /* wanted relative error of the run's result */
  PetscBool accuracy_given;   /* by the user; otherwise the problem may have another default */
  const SlipMeasure *measure; /* that of the error; NULL: that of the policy */
  PetscReal told_dial;        /* this accuracy was clipped, and the message printed */
  PetscBool told_idle;        /* the warning of options without effect was printed */
  PetscBool sees_accuracy;    /* an observation reads it */
  SlipObserver observer;
  PetscBool begun; /* a solve has begun */
  PetscInt steps;  /* accepted steps at the last call, to detect another solve */
  /* handover to a classical controller */
  PetscBool strict;        /* it never happens */
  PetscBool handed;        /* fallback controls the present run */
  TSAdapt fallback;        /* the classical controller, rlfallback.c; NULL before the handover */
  char fallback_name[64];  /* its type, and its filter after a colon */
  PetscBool from_options;  /* that type has options */
  PetscReal handover_time; /* time of the handover [s] */
  PetscInt handover_step;  /* accepted steps before it */
  PetscInt outside_run;    /* decisions in a row with an observation outside the training range */
  PetscBool printed;       /* the message was printed */
  PetscBool told_rtol;     /* so was that of a tolerance that the policy was not trained with */
  /* guard rails */
  PetscInt paced;              /* decisions since the one at pace_time */
  PetscReal pace_time;         /* [s] */
  PetscInt max_failures;       /* failed attempts in a row before steps are halved */
  PetscReal error_ceiling;     /* larger error estimates reject; 0: the policy's own limit, or none */
  PetscReal ceiling;           /* the limit in this run; 0: none */
  PetscInt solves_failed;      /* failed solves of the TS at the last attempt */
  PetscInt hold;               /* attempts for which the step may not grow */
  PetscInt hold_after_failure; /* number of them after a failed solve */
  /* counters */
  PetscInt decisions; /* steps that the policy chose */
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

/* rlnumbers.c: numbers of a policy's file, for the run that begins */
PETSC_INTERN PetscErrorCode TSAdaptRLSetTolerance_Private(TSAdapt adapt, TS ts);
PETSC_INTERN PetscErrorCode TSAdaptRLFirstStep_Private(TSAdapt adapt, TS ts, PetscReal *h);
PETSC_INTERN PetscErrorCode TSAdaptRLFindGuards_Private(TSAdapt adapt);

/* rlidle.c */
PETSC_INTERN PetscErrorCode TSAdaptRLWarnOfIdle_Private(TSAdapt adapt, TS ts);

/* rlset.c */
/* Gets the context; NULL if the controller has another type. */
static inline PetscErrorCode TSAdaptRLContext_Private(TSAdapt adapt, TSAdapt_RL **rl)
{
  PetscBool learned;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(adapt, TSADAPT_CLASSID, 1);
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTRL, &learned));
  *rl = learned ? (TSAdapt_RL *)adapt->data : NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PETSC_INTERN PetscErrorCode TSAdaptRLFindPolicy_Private(TSAdapt adapt, TS ts); /* the default one if none is set */

/* ---- adaptstate.c: for checkpoints ---- */
PETSC_INTERN PetscErrorCode SlipStateController(SlipState s, const char name[], TSAdapt adapt);
PETSC_INTERN PetscErrorCode SlipStateAdapt(SlipState s, TS ts);
