/* Time integrators: TSBATHE, implicit and composite (a trapezoidal stage, then a three-point backward one), TSMOREAU,
   the explicit one for set-valued reactions, and the functions that problems supply to all of them. */
#pragma once
#include <petscts.h>
#include <slipsnes.h>
#include <slipsys.h>

#define TSBATHE "bathe"
#define TSMOREAU "moreau"   /* explicit, for the same set-valued reactions; moreau.c */
#define TSADAMS "adams"     /* explicit, with variable order; adams.c */
#define TSLAPUSTA "lapusta" /* explicit, with constant slip rates in a step, for media with memory; lapusta.c */
#define TSRKC "rkc"         /* explicit, of second order, with as many stages as stability needs; rkc.c */

/* How an attempt is computed: by implicit stages, or by an explicit step of a constraint that has SlipExplicitOps; auto
   chooses the one that takes fewer products. */
typedef enum { TSBATHE_METHOD_IMPLICIT, TSBATHE_METHOD_EXPLICIT, TSBATHE_METHOD_AUTO } TSBatheMethod;
/* How stage 1 treats the reaction: as the mean of start and end (second order), or as that at the end (first order). */
typedef enum { TSBATHE_REACTION_TRAPEZOIDAL, TSBATHE_REACTION_IMPLICIT } TSBatheReactionType;
/* Rule of stage 1: trapezoidal, or backward, which does not use the force at the start of the step. */
typedef enum { TSBATHE_STAGE_TRAPEZOIDAL, TSBATHE_STAGE_BACKWARD } TSBatheFirstStage;
/* How the error of a step is estimated: from the stage derivatives (no extra solve), by two half steps, or not. */
typedef enum { TSBATHE_ERROR_EMBEDDED, TSBATHE_ERROR_DOUBLING, TSBATHE_ERROR_NONE } TSBatheError;
PETSC_EXTERN const char *const TSBatheMethods[];
PETSC_EXTERN const char *const TSBatheReactionTypes[];
PETSC_EXTERN const char *const TSBatheFirstStages[];
PETSC_EXTERN const char *const TSBatheErrors[];

/* One attempted step, accepted or not: all that outputs, controllers and trainers may use of it. */
typedef struct {
  PetscInt step;         /* number of accepted steps before it */
  PetscReal time;        /* time at its start [s] */
  PetscReal dt;          /* attempted step [s] */
  PetscBool converged;   /* every stage solve of the attempt converged */
  PetscBool accepted;    /* the controller accepted it */
  PetscReal error;       /* weighted RMS error estimate; -1 when none was computed */
  PetscReal residual;    /* sum of the Bathe steps' final relative residuals, 2 for each that was not run or failed */
  PetscInt solves;       /* Bathe steps computed (1, or up to 3 with doubling) */
  PetscInt newton;       /* nonlinear iterations */
  PetscInt linear;       /* linear iterations */
  TSBatheMethod method;  /* implicit or explicit */
  PetscInt reason;       /* last SNESConvergedReason */
  SlipProducts products; /* since the last attempt: those of the step, its controller and its start */
  PetscReal wall;        /* wall time [s] */
} SlipAttempt;

/* Called after each attempt, once it is accepted or rejected; w is the state after it (restored if rejected). */
typedef PetscErrorCode (*TSBatheAttemptFn)(TS ts, const SlipAttempt *attempt, Vec w, void *ctx);

/* The method of the next attempts */
PETSC_EXTERN PetscErrorCode TSBatheSetMethod(TS ts, TSBatheMethod method);
PETSC_EXTERN PetscErrorCode TSBatheGetMethod(TS ts, TSBatheMethod *method);
PETSC_EXTERN PetscErrorCode TSBatheGetLongestStep(TS ts, PetscReal *h); /* the longest stable explicit step [s] */
PETSC_EXTERN PetscErrorCode TSBatheSetGamma(TS ts, PetscReal gamma);
PETSC_EXTERN PetscErrorCode TSBatheGetGamma(TS ts, PetscReal *gamma);
PETSC_EXTERN PetscErrorCode TSBatheSetReactionType(TS ts, TSBatheReactionType type);
PETSC_EXTERN PetscErrorCode TSBatheGetReactionType(TS ts, TSBatheReactionType *type);
PETSC_EXTERN PetscErrorCode TSBatheSetFirstStage(TS ts, TSBatheFirstStage rule);
PETSC_EXTERN PetscErrorCode TSBatheGetFirstStage(TS ts, TSBatheFirstStage *rule);
PETSC_EXTERN PetscErrorCode TSBatheSetError(TS ts, TSBatheError error);
PETSC_EXTERN PetscErrorCode TSBatheGetError(TS ts, TSBatheError *error);
PETSC_EXTERN PetscErrorCode TSBatheSetStageError(TS ts, PetscReal share);
PETSC_EXTERN PetscErrorCode TSBatheSetConstraint(TS ts, SlipConstraint con);
PETSC_EXTERN PetscErrorCode TSBatheGetConstraint(TS ts, SlipConstraint *con);
/* A borrowed vector: the accepted reaction at the current time, which a restarted run starts with */
PETSC_EXTERN PetscErrorCode TSBatheGetReaction(TS ts, Vec *r);
PETSC_EXTERN PetscErrorCode TSBatheSetInitialReaction(TS ts, Vec r);
PETSC_EXTERN PetscErrorCode TSBatheGetLastAttempt(TS ts, SlipAttempt *attempt);
/* Several monitors are called in the order in which they were set. */
PETSC_EXTERN PetscErrorCode TSBatheMonitorSet(TS ts, TSBatheAttemptFn monitor, void *ctx,
                                              PetscErrorCode (*destroy)(void **));
PETSC_EXTERN PetscErrorCode TSBatheMonitorCancel(TS ts);
/* Estimates of the last attempt, borrowed; NULL means that there is none. scale times error is solution minus exact
   solution; derivative is dw/dt at the end of the attempt. */
PETSC_EXTERN PetscErrorCode TSBatheGetEstimates(TS ts, Vec *error, PetscReal *scale, Vec *derivative);
PETSC_EXTERN PetscErrorCode TSBatheGetOrder(TS ts, PetscReal *order);
/* Totals since TSSolve() began */
PETSC_EXTERN PetscErrorCode TSBatheGetTotals(TS ts, PetscInt *attempts, PetscInt *accepted, PetscInt *solves,
                                             PetscInt *newton, PetscInt *linear);
/* Makes a TS of type bathe integrate a small system (slipsnes.h). TSBatheCheckOptions() fails if -ts_type has changed
   the type since then, because another type would ignore the constraint. */
PETSC_EXTERN PetscErrorCode SlipSmallConfigureTS(const SlipSmall *problem, TS ts);
PETSC_EXTERN PetscErrorCode TSBatheCheckOptions(TS ts);
/* SlipSmallConfigureTS() for languages without C structs: it takes the members of SlipSmall one by one. */
PETSC_EXTERN PetscErrorCode SlipSmallConfigureTSByMembers(
  TS ts, PetscInt n, const PetscReal mass[], PetscInt nrows, const PetscInt rows[],
  PetscErrorCode (*force)(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx),
  PetscErrorCode (*jacobian)(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx),
  PetscErrorCode (*bound)(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx), void *ctx);
/* Prints the last line of a summary: when a run ended, and why if that was before its final time. */
PETSC_EXTERN PetscErrorCode SlipReportEnd(TS ts, const char state[], PetscBool *complete);

PETSC_EXTERN PetscErrorCode TSAdamsSetMaxOrder(TS ts, PetscInt order);
PETSC_EXTERN PetscErrorCode TSRKCSetMaxStages(TS ts, PetscInt stages);

/* Composed functions by which TSBATHE, controllers and problems call each other without including each other's headers:
   on TSAdapt
     "TSAdaptChooseFirst_C"        (TSAdapt, TS, PetscReal *h)   chooses the first step, before any attempt
     "TSAdaptChooseAfterFailure_C" (TSAdapt, TS, PetscReal h_failed, PetscReal *h_next)
     "TSAdaptNeedsError_C"         (TSAdapt, PetscBool *flg)     false: TSBATHE skips step doubling (absent: true)
     "TSAdaptResume_C"             (TSAdapt, TS)                 a run continues from a checkpoint; then "SlipState_C"
   on TS, by TSBATHE
     "TSBatheGetLastAttempt_C"     (TS, SlipAttempt *) */

/* What a problem says of itself, in a struct for each of those who ask. Any function and any struct may be absent, NULL
   or 0; ctx is that of TSSetSlipProblem(). */

/* Controllers */
typedef struct {
  PetscErrorCode (*name)(TS ts, const char **name, void *ctx);      /* its name, which selects a default policy */
  PetscErrorCode (*time_scale)(TS ts, PetscReal *tstar, void *ctx); /* T* [s]; NULL: 1 s */
  /* Why no policy was trained for such a problem, called once a run; NULL: one may have been trained */
  PetscErrorCode (*untrained)(TS ts, const char **why, void *ctx);
  /* The classical TSAdapt type of the problem, and after a colon its filter, with which a run under -ts_adapt_type rl
     continues outside of the policy's training; NULL: TSADAPTHEURISTIC */
  const char *controller;
  /* TSADAPTRL calls it when another controller (fallback) takes over a run; it sets the tolerances of ts that this
     controller needs for the accuracy. */
  PetscErrorCode (*hand_over)(TS ts, TSAdapt fallback, PetscReal accuracy, void *ctx);
  /* How long the state w at t [s] stays exactly at rest [s]: 0 if a cell moves or is about to, PETSC_MAX_REAL for ever
     */
  PetscErrorCode (*rest_time)(TS ts, PetscReal t, Vec w, PetscReal *rest, void *ctx);
  /* TSADAPTLAPUSTA calls it after an attempt, with F at its end: the longest step, 0: the shortest there is [s] */
  PetscErrorCode (*slip_step)(TS ts, PetscReal t, Vec w, PetscReal *longest, void *ctx);
  PetscBool measures; /* -ts_adapt_rl_measure names its errors; false: it has an error measure of its own */
} SlipControlOps;

/* Integrators, of any step */
typedef struct {
  /* TSBATHE calls it when a solve begins, before the controller chooses the first step and after it (chosen): sets the
     tolerances of ts for the wanted accuracy, and afterwards stores those that the controller has set. */
  PetscErrorCode (*begin)(TS ts, PetscBool chosen, void *ctx);
  /* TSBATHE, TSADAMS and TSLAPUSTA call it before a step of the length TSGetTimeStep(). next is the first time after t
     [s] at which the loading has a corner where a step must end; PETSC_MAX_REAL: there is none. */
  PetscErrorCode (*corner)(TS ts, PetscReal t, PetscReal *next, void *ctx);
  /* They call it likewise to learn whether the state w at t [s] stays at rest beyond t. If so, *end is until when, at
     most limit; half and after are the exact states halfway and at the end, and *h is a step to continue with [s].
     Otherwise *end = t. */
  PetscErrorCode (*rest)(TS ts, PetscReal t, PetscReal limit, Vec w, Vec half, Vec after, PetscReal *end, PetscReal *h,
                         void *ctx);
  /* TSBATHE calls it after an attempt whose states w0, wm and w1 are at the fractions 0, share and 1 of the step; k0 is
     dw/dt at its start. *stop is how long after the start [s] a motion stops over which the step should not average,
     PETSC_MAX_REAL if none does; a step then ends there. */
  PetscErrorCode (*stop)(TS ts, PetscReal share, Vec w0, Vec wm, Vec w1, Vec k0, PetscReal *stop, void *ctx);
  /* TSBATHE and TSRKC call it for the norm of the error estimate e of a step from w0 to w1; a step is accurate enough
     if the norm is at most 1. NULL: the weighted norm of the TS */
  PetscErrorCode (*error)(TS ts, Vec e, Vec w0, Vec w1, PetscReal *E, void *ctx);
  /* TSADAMS and TSRKC call it at the end t [s] of a step, after the right-hand side there: it computes the components
     of w that have no derivative from the others. */
  PetscErrorCode (*finish)(TS ts, PetscReal t, Vec w, void *ctx);
  /* They call it likewise, and then: the fastest rate at which the solution relaxes at the state w [1/s]. It bounds
     stable steps under controllers that do not observe it; 0: unknown */
  PetscErrorCode (*relaxation)(TS ts, Vec w, PetscReal *rate, void *ctx);
  PetscBool any_integrator; /* it has no constraint, so that types other than TSBATHE solve it as well */
} SlipStepOps;

/* TSLAPUSTA, whose steps have constant slip rates */
typedef struct {
  /* w1 is the state h [s] after w0 at constant slip rates; F has the rates of the displacements. */
  PetscErrorCode (*drift)(TS ts, PetscReal h, Vec w0, Vec F, Vec w1, void *ctx);
  PetscErrorCode (*shortest)(TS ts, PetscReal *step, void *ctx); /* the shortest useful step [s]; 0: there is none */
  /* At the start (t, w) of a step: do all cells rest while waves are under way that may start slip? If so, steps are at
     most four times the shortest one, and the shortest one where slip starts, because a controller would lengthen the
     steps of a state that does not change. */
  PetscErrorCode (*waits)(TS ts, PetscReal t, Vec w, PetscBool *waits, void *ctx);
} SlipDriftOps;

/* TSBATHE takes explicit steps besides implicit ones if a problem has all of these, finish() and relaxation(), where
   the rate 0 means implicit steps. */
typedef struct {
  /* f = dw/dt of the state w at t [s], 0 where a component has no derivative */
  PetscErrorCode (*side)(TS ts, PetscReal t, Vec w, Vec f, void *ctx);
  /* The state w1 in the middle of a step h [s] from w0 to w2, whose right-hand sides are f0 and f2 */
  PetscErrorCode (*middle)(TS ts, PetscReal h, Vec w0, Vec w2, Vec f0, Vec f2, Vec w1, void *ctx);
  /* The norm of the error e of such a step, as error() of SlipStepOps is of the others */
  PetscErrorCode (*error)(TS ts, Vec e, Vec w0, Vec w1, PetscReal *E, void *ctx);
  /* The reaction of a state w which finish() has completed */
  PetscErrorCode (*reaction)(TS ts, PetscReal t, Vec w, Vec r, void *ctx);
} SlipSideOps;

/* The history of a problem that has one. TSBATHE, TSADAMS, TSRKC and TSLAPUSTA call the first three, or the problem has
   none of them. */
typedef struct {
  /* A step begins from the accepted state w at t [s]; first: a run begins, without a history. It is called when the
     next step begins, so that states inside the last step still follow from the history before it. */
  PetscErrorCode (*accept)(TS ts, PetscReal t, Vec w, PetscBool first, void *ctx);
  /* The next part of an attempt begins from w, which is not accepted yet. */
  PetscErrorCode (*advance)(TS ts, PetscReal t, Vec w, void *ctx);
  /* An attempt is given up, or a step that an event interpolates again; the history is that of the step's start. */
  PetscErrorCode (*rollback)(TS ts, void *ctx);
  /* TSBATHE, TSADAMS, TSRKC and TSLAPUSTA call it after an attempt that ends in w at t: the norm of the error, of the
     order of the step's cube, that the history adds to the problem there; a step is accurate enough if it is at most 1
     */
  PetscErrorCode (*error)(TS ts, PetscReal t, Vec w, PetscReal *E, void *ctx);
  /* For problems that allow times to count from a moving origin (TSGetSlipOrigin()). Between two steps the origin
     becomes this one [s], and the problem subtracts `by` from all times that it stores. */
  PetscErrorCode (*origin)(TS ts, PetscReal origin, PetscReal by, void *ctx);
} SlipHistoryOps;

/* The problem's own observations, for policies and records */
typedef struct {
  /* Called once a run: the number of the row with a name, -1 for none */
  PetscErrorCode (*find)(TS ts, const char name[], PetscInt *row, void *ctx);
  /* Called once a state: values of rows [n] in the current solution at the time t [s]; TSGetTime() is the start of the
     step until the controller has chosen. */
  PetscErrorCode (*observe)(TS ts, PetscReal t, PetscInt n, const PetscInt row[], PetscReal value[], void *ctx);
} SlipObserveOps;

/* All of these, for TSSetSlipProblem() */
typedef struct {
  SlipControlOps control;
  SlipStepOps steps;
  SlipDriftOps drifts;
  SlipSideOps sides;
  SlipHistoryOps history;
  SlipObserveOps observations;
} SlipProblemOps;

PETSC_EXTERN PetscErrorCode TSSetSlipProblem(TS ts, const SlipProblemOps *problem, void *ctx);
PETSC_EXTERN PetscErrorCode TSGetSlipProblem(TS ts, const SlipProblemOps **problem, void *ctx);
/* The origin of the times of ts in runs of thousands of years [s] */
PETSC_EXTERN PetscErrorCode TSGetSlipOrigin(TS ts, PetscReal *origin);
