/* TSBATHE: the implicit composite (trapezoidal, then three-point backward) integrator; TSMOREAU: the explicit one. */
#pragma once
#include <petscts.h>
#include <slipsnes.h>
#include <slipsys.h>

#define TSBATHE "bathe"
#define TSMOREAU "moreau"   /* explicit, with the same set-valued reactions; moreau.c */
#define TSADAMS "adams"     /* explicit, of variable order; adams.c */
#define TSLAPUSTA "lapusta" /* explicit, of constant slip rates within a step, for media that remember; lapusta.c */
#define TSRKC "rkc"         /* explicit, of second order, with as many stages as stability needs; rkc.c */

/* How an attempt is computed: by implicit stages, or by an explicit step of a constraint with SlipExplicitOps; auto: by
   that which takes fewer products */
typedef enum { TSBATHE_METHOD_IMPLICIT, TSBATHE_METHOD_EXPLICIT, TSBATHE_METHOD_AUTO } TSBatheMethod;
/* Treatment of the reaction in stage 1: by the mean of start and end (second order), or at the end (first order). */
typedef enum { TSBATHE_REACTION_TRAPEZOIDAL, TSBATHE_REACTION_IMPLICIT } TSBatheReactionType;
/* Rule of stage 1: trapezoidal, or backward, which reads no force of the step's start. */
typedef enum { TSBATHE_STAGE_TRAPEZOIDAL, TSBATHE_STAGE_BACKWARD } TSBatheFirstStage;
/* Error estimate of a step: from the stage derivatives (no extra solve), by two half steps, or none. */
typedef enum { TSBATHE_ERROR_EMBEDDED, TSBATHE_ERROR_DOUBLING, TSBATHE_ERROR_NONE } TSBatheError;
PETSC_EXTERN const char *const TSBatheMethods[];
PETSC_EXTERN const char *const TSBatheReactionTypes[];
PETSC_EXTERN const char *const TSBatheFirstStages[];
PETSC_EXTERN const char *const TSBatheErrors[];

/* One attempted step, accepted or not. Everything that outputs, controllers and trainers may know of it. */
typedef struct {
  PetscInt step;         /* number of accepted steps before it */
  PetscReal time;        /* time at its start [s] */
  PetscReal dt;          /* step tried [s] */
  PetscBool converged;   /* every stage solve of the attempt converged */
  PetscBool accepted;    /* the controller took it */
  PetscReal error;       /* weighted RMS error estimate; -1 when none was computed */
  PetscReal residual;    /* sum of the Bathe steps' final relative residuals, 2 for each that was not run or failed */
  PetscInt solves;       /* Bathe steps computed (1, or up to 3 with doubling) */
  PetscInt newton;       /* nonlinear iterations */
  PetscInt linear;       /* linear iterations */
  TSBatheMethod method;  /* implicit or explicit */
  PetscInt reason;       /* last SNESConvergedReason */
  SlipProducts products; /* since the attempt before: those of the step, its controller and what it starts from */
  PetscReal wall;        /* wall time [s] */
} SlipAttempt;

/* Called after each attempt, once accepted or rejected is known; w is the state after it (the restored one when
   rejected). */
typedef PetscErrorCode (*TSBatheAttemptFn)(TS ts, const SlipAttempt *attempt, Vec w, void *ctx);

PETSC_EXTERN PetscErrorCode SlipTSInitializePackage(void);   /* called by what creates objects; again does nothing */
PETSC_EXTERN PetscErrorCode TSBatheIs(TS ts, PetscBool *is); /* of type bathe or moreau? */
/* Of the next attempts */
PETSC_EXTERN PetscErrorCode TSBatheSetMethod(TS ts, TSBatheMethod method);
PETSC_EXTERN PetscErrorCode TSBatheSetDefaultMethod(TS ts, TSBatheMethod method);
PETSC_EXTERN PetscErrorCode TSBatheGetMethod(TS ts, TSBatheMethod *method);
PETSC_EXTERN PetscErrorCode TSBatheGetLongestStep(TS ts, PetscReal *h);  /* of an explicit step from here [s] */
PETSC_EXTERN PetscErrorCode TSBatheGetSolveCost(TS ts, PetscReal *cost); /* over that of an explicit step */
PETSC_EXTERN PetscErrorCode TSBatheSetGamma(TS ts, PetscReal gamma);
PETSC_EXTERN PetscErrorCode TSBatheGetGamma(TS ts, PetscReal *gamma);
PETSC_EXTERN PetscErrorCode TSBatheSetReactionType(TS ts, TSBatheReactionType type);
PETSC_EXTERN PetscErrorCode TSBatheGetReactionType(TS ts, TSBatheReactionType *type);
PETSC_EXTERN PetscErrorCode TSBatheSetFirstStage(TS ts, TSBatheFirstStage rule);
PETSC_EXTERN PetscErrorCode TSBatheGetFirstStage(TS ts, TSBatheFirstStage *rule);
PETSC_EXTERN PetscErrorCode TSBatheSetError(TS ts, TSBatheError error);
PETSC_EXTERN PetscErrorCode TSBatheGetError(TS ts, TSBatheError *error);
PETSC_EXTERN PetscErrorCode TSBatheSetDoublingOrder(TS ts, PetscInt p);
PETSC_EXTERN PetscErrorCode TSBatheSetStageError(TS ts, PetscReal share);
PETSC_EXTERN PetscErrorCode TSBatheGetDoublingOrder(TS ts, PetscInt *p);
PETSC_EXTERN PetscErrorCode TSBatheSetConstraint(TS ts, SlipConstraint con);
PETSC_EXTERN PetscErrorCode TSBatheGetConstraint(TS ts, SlipConstraint *con);
/* borrowed: accepted reaction at the current time; restart state */
PETSC_EXTERN PetscErrorCode TSBatheGetReaction(TS ts, Vec *r);
PETSC_EXTERN PetscErrorCode TSBatheSetInitialReaction(TS ts, Vec r);
PETSC_EXTERN PetscErrorCode TSBatheGetLastAttempt(TS ts, SlipAttempt *attempt);
/* several are called in order */
PETSC_EXTERN PetscErrorCode TSBatheMonitorSet(TS ts, TSBatheAttemptFn monitor, void *ctx,
                                              PetscErrorCode (*destroy)(void **));
PETSC_EXTERN PetscErrorCode TSBatheMonitorCancel(TS ts);
/* Of the last attempt, borrowed; NULL: not known. scale makes error solution minus exact; derivative is dw/dt at its
   end. */
PETSC_EXTERN PetscErrorCode TSBatheGetEstimates(TS ts, Vec *error, PetscReal *scale, Vec *derivative);
PETSC_EXTERN PetscErrorCode TSBatheGetOrder(TS ts, PetscReal *order);
/* Integrals over the last accepted step: states, borrowed, at shares of it, with their weights */
PETSC_EXTERN PetscErrorCode TSBatheGetQuadrature(TS ts, PetscReal share[3], PetscReal weight[3], Vec state[3]);
/* Same steps and estimates, finer solution; told of the state [v, u, s per cell] at the end of each part */
typedef PetscErrorCode (*TSBathePartFn)(TS ts, PetscReal time, Vec w, void *ctx);
PETSC_EXTERN PetscErrorCode TSBatheSetParts(TS ts, PetscInt parts, TSBathePartFn told, void *ctx);
/* Totals since TSSolve began. */
PETSC_EXTERN PetscErrorCode TSBatheGetTotals(TS ts, PetscInt *attempts, PetscInt *accepted, PetscInt *solves,
                                             PetscInt *newton, PetscInt *linear);
PETSC_EXTERN PetscErrorCode TSBatheGetExplicitAttempts(TS ts, PetscInt *attempts);
/* Make a TS of type bathe integrate a small system (slipsnes.h); and fail when -ts_type has made it another type since,
   which would ignore the constraint. */
PETSC_EXTERN PetscErrorCode SlipSmallConfigureTS(const SlipSmall *problem, TS ts);
PETSC_EXTERN PetscErrorCode TSBatheCheckOptions(TS ts);
/* SlipSmallConfigureTS() for languages that have no structs of C's: the members of SlipSmall one by one. */
PETSC_EXTERN PetscErrorCode SlipSmallConfigureTSByMembers(
  TS ts, PetscInt n, const PetscReal mass[], PetscInt nrows, const PetscInt rows[],
  PetscErrorCode (*force)(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx),
  PetscErrorCode (*jacobian)(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx),
  PetscErrorCode (*bound)(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx), void *ctx);
/* The last line of a summary: when a run ended, and why it did before its final time. */
PETSC_EXTERN PetscErrorCode SlipReportEnd(TS ts, const char state[], PetscBool *complete);

PETSC_EXTERN PetscErrorCode TSAdamsSetMaxOrder(TS ts, PetscInt order);
PETSC_EXTERN PetscErrorCode TSRKCSetMaxStages(TS ts, PetscInt stages);

/* Composed functions by which TSBATHE, controllers and problems meet without including each other:
   on TSAdapt
     "TSAdaptChooseFirst_C"        (TSAdapt, TS, PetscReal *h)   the first step, before anything is known
     "TSAdaptChooseAfterFailure_C" (TSAdapt, TS, PetscReal h_failed, PetscReal *h_next)
     "TSAdaptNeedsError_C"         (TSAdapt, PetscBool *flg)     no: TSBATHE skips step doubling (absent: yes)
     "TSAdaptResume_C"             (TSAdapt, TS)                 a run goes on from a checkpoint; then "SlipState_C"
   on TS, by TSBATHE
     "TSBatheGetLastAttempt_C"     (TS, SlipAttempt *) */

/* What a problem tells controllers and the integrator of itself. Any function may be NULL. ctx is that of
   TSSetSlipProblem(). */
typedef struct {
  PetscErrorCode (*name)(TS ts, const char **name, void *ctx);      /* whose default policy -ts_adapt_type rl takes */
  PetscErrorCode (*time_scale)(TS ts, PetscReal *tstar, void *ctx); /* T* [s]; NULL: 1 s */
  PetscErrorCode (*untrained)(TS ts, const char **why,
                              void *ctx); /* why no policy was trained for the like of it, asked once a
                                                                  run; NULL: one may have been */
  const char
    *controller; /* the classical type of TSAdapt for it, and after a colon its filter, which -ts_adapt_type rl hands a
                             run over to; NULL: TSADAPTHEURISTIC */
  /* Asked by TSBATHE where a solve begins, before its controller chooses the first step and after (chosen): sets the
     tolerances of ts that the accuracy wanted needs, then remembers those that the controller has set */
  PetscErrorCode (*begin)(TS ts, PetscBool chosen, void *ctx);
  /* Asked by TSADAPTRL when it hands a run over, with the accuracy that it was asked for: sets the tolerances of ts for
     fallback */
  PetscErrorCode (*hand_over)(TS ts, TSAdapt fallback, PetscReal accuracy, void *ctx);
  /* For how long the state w of time t [s] stays exactly at rest, in s; 0 when something moves or is about to,
     PETSC_MAX_REAL for ever */
  PetscErrorCode (*rest_time)(TS ts, PetscReal t, Vec w, PetscReal *rest, void *ctx);
  /* Asked by TSBATHE, TSADAMS and TSLAPUSTA before a step, whose length is that of TSGetTimeStep(): the next time at
     which its loading has a corner that a step is to end at, [s] and after t. PETSC_MAX_REAL: none */
  PetscErrorCode (*corner)(TS ts, PetscReal t, PetscReal *next, void *ctx);
  /* Likewise: does the state w of time t [s] stay at rest beyond t? Then *end is until when, at most limit; half and
     after are the states halfway and at the end, exactly, and *h a step to go on with from there [s]. Otherwise *end =
     t. */
  PetscErrorCode (*rest)(TS ts, PetscReal t, PetscReal limit, Vec w, Vec half, Vec after, PetscReal *end, PetscReal *h,
                         void *ctx);
  /* Asked by TSBATHE after an attempt whose states w0, wm and w1 are at the shares 0, share and 1 of the step; k0 is
     dw/dt at its start. *stop: when after its start [s] something stops of which the step should not average the stop,
     PETSC_MAX_REAL: nothing does. Steps end there. */
  PetscErrorCode (*stop)(TS ts, PetscReal share, Vec w0, Vec wm, Vec w1, Vec k0, PetscReal *stop, void *ctx);
  /* Asked by TSBATHE and TSRKC: the norm of the estimate e of the error of a step from w0 to w1, at most 1 where it is
     as wanted; NULL: the weighted one of the TS */
  PetscErrorCode (*error)(TS ts, Vec e, Vec w0, Vec w1, PetscReal *E, void *ctx);
  /* Asked by TSLAPUSTA: w1 is the state w0 after h [s] at constant slip rates, of which F has those of displacements */
  PetscErrorCode (*drift)(TS ts, PetscReal h, Vec w0, Vec F, Vec w1, void *ctx);
  /* Asked by TSADAPTLAPUSTA of the end of an attempt, F there: the longest step that lets no cell slip too far [s] */
  PetscErrorCode (*slip_step)(TS ts, PetscReal t, Vec w, PetscReal *longest, void *ctx);
  /* Asked by TSLAPUSTA: the shortest step that there is any use in [s]; 0: there is none */
  PetscErrorCode (*shortest)(TS ts, PetscReal *step, void *ctx);
  /* Likewise, of a step's start (t, w): does all rest, but waves are under way that may start something? Then steps are
     four times the shortest at most, and the shortest where something starts, whatever a controller makes of a state
     that does not change */
  PetscErrorCode (*waits)(TS ts, PetscReal t, Vec w, PetscBool *waits, void *ctx);
  /* Asked by TSADAMS and TSRKC at the end t [s] of a step, after the right-hand side there: makes those components of
     the state w that no derivative goes into follow from the others */
  PetscErrorCode (*finish)(TS ts, PetscReal t, Vec w, void *ctx);
  /* Likewise, and after it: the fastest rate at which the solution relaxes at the state w [1/s], which bounds stable
     steps under controllers that observe no such thing; 0: not known */
  PetscErrorCode (*relaxation)(TS ts, Vec w, PetscReal *rate, void *ctx);
  /* Asked by TSBATHE, which goes by explicit steps as well as by solves where there are all of these four, finish() and
     relaxation(), whose rate 0 means solves: f = dw/dt of the state w at t [s], 0 where no derivative goes into; the
     state w1 in the middle of a step h [s] from w0 to w2, whose right-hand sides are f0 and f2; the norm of the error e
     of such a step, as error() is of the others; and the reaction of a state w that finish() has completed */
  PetscErrorCode (*side)(TS ts, PetscReal t, Vec w, Vec f, void *ctx);
  PetscErrorCode (*middle)(TS ts, PetscReal h, Vec w0, Vec w2, Vec f0, Vec f2, Vec w1, void *ctx);
  PetscErrorCode (*side_error)(TS ts, Vec e, Vec w0, Vec w1, PetscReal *E, void *ctx);
  PetscErrorCode (*reaction)(TS ts, PetscReal t, Vec w, Vec r, void *ctx);
  /* Of a problem that remembers its history, for TSBATHE, TSADAMS and TSRKC, all or none of them. A step begins from
     the state w of t [s], which was accepted; first: a run begins, with nothing before it. It is called where the next
     step begins: states in between follow from the history before, as they did when the step was tried. */
  PetscErrorCode (*accept)(TS ts, PetscReal t, Vec w, PetscBool first, void *ctx);
  /* The next part of an attempt begins from w, which is only tried; and an attempt, or a step that an event looks into
     again, is given up: back to the start of the step */
  PetscErrorCode (*advance)(TS ts, PetscReal t, Vec w, void *ctx);
  PetscErrorCode (*rollback)(TS ts, void *ctx);
  /* Observations of its own: number of the row of a name, -1 for none, asked once a run; values of rows [n] in the
     current solution, which is of the time t [s], asked once a state. TSGetTime() is the step's start until the
     controller has chosen. */
  PetscErrorCode (*find)(TS ts, const char name[], PetscInt *row, void *ctx);
  PetscErrorCode (*observe)(TS ts, PetscReal t, PetscInt n, const PetscInt row[], PetscReal value[], void *ctx);
  /* Of a problem that can do with times which count from an origin that moves (TSGetSlipOrigin()). Between two steps:
     the origin is now this one [s], and all times that it remembers fall by so much */
  PetscErrorCode (*origin)(TS ts, PetscReal origin, PetscReal by, void *ctx);
  PetscBool any_integrator; /* it has no constraint: types other than TSBATHE solve it as well */
  PetscBool measures;       /* its errors are those that -ts_adapt_rl_measure names; no: it has one of its own */
} SlipProblemOps;

PETSC_EXTERN PetscErrorCode TSSetSlipProblem(TS ts, const SlipProblemOps *problem, void *ctx);
PETSC_EXTERN PetscErrorCode TSGetSlipProblem(TS ts, const SlipProblemOps **problem, void *ctx);
/* What times of ts count from, in runs of thousands of years [s] */
PETSC_EXTERN PetscErrorCode TSGetSlipOrigin(TS ts, PetscReal *origin);
