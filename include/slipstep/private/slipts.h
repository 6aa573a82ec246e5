/* Internal header of src/ts: its types but TSBATHE (slipbathe.h), and what they share with it */
#pragma once
#include <slipstep/rooms/slipts.h>
#include <petsc/private/tsimpl.h>
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>
#include <slipstep/private/sliploops.h>
#include <slipstep/private/slipclock.h>
#include <slipstep/private/slipstate.h>
#include <slipstep/private/slipsys.h>

/* Constant steps, one of which was rejected */
typedef struct {
  PetscReal asked; /* their length, to which they will return; 0: unchanged [s] */
  PetscBool told;
} SlipConstant;

PETSC_INTERN PetscErrorCode TSCreate_Adams(TS);
PETSC_INTERN PetscErrorCode TSCreate_RKC(TS);
PETSC_INTERN PetscErrorCode TSCreate_Lapusta(TS);

/* ---- adamssum.c: all sums of a step in one pass over memory ---- */
typedef struct {
  const PetscReal *absolutes, *relatives; /* or NULL: the numbers */
  PetscReal absolute, relative;
  const PetscReal *inverse; /* 1 / absolutes if all relative ones are 0, 0 where both are; else NULL */
} SlipAdamsTolerance;
typedef struct { /* inverse, cached until the vectors change */
  PetscReal *inverse;
  PetscInt entries; /* of this rank with a tolerance */
  PetscObjectState state[2];
  PetscObjectId id[2]; /* of the absolute tolerances and the relative ones */
} SlipAdamsInverse;
PETSC_INTERN PetscErrorCode SlipAdamsGetTolerance(TS ts, SlipAdamsInverse *kept, SlipAdamsTolerance *tolerance);
PETSC_INTERN void SlipAdamsSum(PetscInt n, const PetscReal start[], PetscInt m, const PetscReal *const rate[],
                               const PetscReal weight[][SLIP_ADAMS_NODES], PetscInt estimates,
                               const SlipAdamsTolerance *tolerance, PetscReal y[], SlipVecsSums *sums);

/* ---- rkc.c ---- */
#define SLIP_RATE_MARGIN 1.05 /* products estimate the fastest rate of a problem from below */
typedef PetscErrorCode (*SlipSideFn)(TS ts, PetscReal t, Vec w, Vec f);
PETSC_INTERN PetscErrorCode SlipChebyshevStages(TS ts, SlipSideFn side, PetscReal t, PetscReal h, PetscInt s, Vec start,
                                                Vec f, Vec y[2], Vec work);
PETSC_INTERN PetscErrorCode SlipChebyshevError(PetscReal h, Vec start, Vec end, Vec f_start, Vec f_end, Vec e);

/* ---- explicitattempts.c: a step of several attempts from one state ---- */
/* Operations of a type; each except attempt and accept may be NULL */
typedef struct {
  PetscErrorCode (*begin)(TS); /* from start and f */
  PetscErrorCode (*limit)(TS); /* ts->time_step of an attempt */
  /* vec_sol after ts->time_step; good is false if it has left the domain of the right-hand side */
  PetscErrorCode (*attempt)(TS, PetscBool *good);
  PetscInt (*order)(TS);                       /* of the attempt; NULL: 2 */
  PetscBool (*whatever)(TS);                   /* is it accepted whatever its error is? NULL: no */
  PetscErrorCode (*retry)(TS, PetscBool good); /* it was rejected, and ts->time_step is the next one */
  PetscErrorCode (*accept)(TS);                /* it was accepted: ts->ptime is its end, ts->time_step the next */
  PetscErrorCode (*bound)(TS);                 /* bounds ts->time_step, after SlipStepOps.finish; NULL: no */
} SlipAttemptOps;
/* The first member of the context of a type that uses it */
typedef struct {
  const SlipAttemptOps *ops;
  PetscInt nown; /* vectors of the type */
  Vec *own[8];
  Vec start;           /* state at the start of the step */
  Vec f;               /* rates there, for types that start with those at the end of the last step; else NULL */
  PetscBool known;     /* f is valid */
  PetscInt rejections; /* rejected attempts of this step */
  PetscReal whole;     /* the attempt's step before it was limited [s] */
  PetscReal corner;    /* of the loading, where the attempt ends unless its type limits it further [s]; PETSC_MAX_REAL:
                          none */
  PetscReal before, h; /* time at the start of the last accepted step, and its length [s] */
} SlipAttempts;
PETSC_INTERN PetscErrorCode SlipAttemptsStep(TS ts);
PETSC_INTERN PetscErrorCode SlipAttemptsSetUp(TS ts);
PETSC_INTERN PetscErrorCode SlipAttemptsReset(TS ts);
PETSC_INTERN PetscErrorCode SlipAttemptsDestroy(TS ts);
PETSC_INTERN PetscErrorCode SlipAttemptsRollBack(TS ts);
PETSC_INTERN PetscErrorCode SlipAttemptsState(TS ts, SlipState s);
PETSC_INTERN PetscErrorCode SlipAttemptsError(TS ts, Vec e, NormType type, PetscInt *order, PetscReal *wlte);

/* ---- adams.c, adamscorrect.c ---- */
enum { ADAMS_MAX = SLIP_ADAMS_NODES - 2, ADAMS_SLOTS = ADAMS_MAX + 3 };

typedef struct {
  SlipAttempts at;
  PetscInt max_order; /* of the predictor */
  PetscInt order;     /* of the attempt */
  PetscInt next;      /* of the step after it */
  PetscInt n;         /* stored derivatives */
  PetscInt since;     /* accepted steps with this order */
  Vec rate[ADAMS_SLOTS];
  PetscReal age[ADAMS_SLOTS]; /* their ages, newest first, as sums of steps [s] */
  Vec star;                   /* f* */
  Vec y;
  SlipAdamsInverse inverse;
  PetscInt dense;      /* derivatives in the last step's polynomial, that at its end first */
  PetscBool estimated; /* norm is valid for this attempt, to choose the next order */
  PetscReal norm;
  PetscBool normed; /* norms are valid for this attempt, by type, and orders around its own */
  NormType type;
  PetscReal norms[3];
  PetscInt most;        /* corrections of a step */
  PetscInt corrections; /* of the attempt */
  PetscReal rates[2]; /* fastest rates of relaxation at the starts of this step and the one before; 0: unknown [1/s] */
  Vec room[2];        /* work vectors of corrections */
  /* of TSLAPUSTA */
  PetscReal shortest; /* shortest step [s]; 0: there is none */
  PetscBool constant; /* the user chose constant steps */
  PetscBool waits;    /* all cells rest, and steps are short because waves may start slip */
  PetscBool adams;    /* long steps are of TSADAMS */
  PetscBool straight; /* slip rates are constant in the attempt, and in the last step */
} TS_Adams;
extern const SlipAttemptOps SlipAdamsOps;
PETSC_INTERN PetscErrorCode TSSetUp_Adams(TS ts);
PETSC_INTERN PetscErrorCode TSEvaluateWLTE_Adams(TS ts, NormType type, PetscInt *order, PetscReal *wlte);
PETSC_INTERN PetscErrorCode TSInterpolate_Adams(TS ts, PetscReal t, Vec x);
PETSC_INTERN void SlipAdamsCorrector(const TS_Adams *ad, PetscReal h, PetscInt k, PetscReal weight[]);
PETSC_INTERN PetscReal SlipAdamsPromise(TS ts, PetscReal norm, PetscInt k);
PETSC_INTERN PetscErrorCode SlipAdamsSetCorrections(TS ts, PetscInt most);
PETSC_INTERN void SlipAdamsCount(TS ts);
PETSC_INTERN PetscErrorCode SlipAdamsBoundStep(TS ts);
PETSC_INTERN PetscErrorCode SlipAdamsCorrectMore(TS ts, Vec predicted, Vec y, PetscBool *good);

/* ---- guard.c: any integrator and controller ---- */
/* Makes ts->time_step end at a corner of the loading that it would pass, and limits a first step to the controller's
   longest one. whole: the step before it was shortened for a corner; corner: the end of the step then, PETSC_MAX_REAL
   if there is no corner [s]. Collective, before each attempt */
PETSC_INTERN PetscErrorCode SlipMeetCorner(TS ts, PetscReal *whole, PetscReal *corner);
/* From TSPreStep: the same before a step of a type of PETSc's. Prints a warning, once, if constant steps of PETSc's
   types pass a corner, or if ours, which end there, are longer than the time to the next one. */
PETSC_EXTERN PetscErrorCode SlipMeetCornerBefore(TS ts, PetscBool ours, PetscBool *warned);
/* From TSPreStep: limits ts->time_step, of an explicit type of PETSc's, so that no slip rate oscillates. */
PETSC_EXTERN PetscErrorCode SlipMeetRelaxation(TS ts);
/* Gets the constant step after one that was shortened to end at a corner of the loading, at end [s]; whole: its
   length */
PETSC_INTERN PetscReal SlipStepAfterCorner(TS ts, PetscReal end, PetscReal whole);
PETSC_INTERN PetscReal SlipTimeAfterStep(TS ts);
PETSC_INTERN PetscErrorCode SlipStepAfterFailure(TS ts, PetscReal *next_h);
PETSC_INTERN PetscErrorCode SlipGuardConstant(TS ts, PetscReal h); /* raises an error if steps are constant */
PETSC_INTERN PetscErrorCode SlipConstantRefused(TS ts, PetscReal h, SlipConstant *steps);
PETSC_INTERN PetscReal SlipConstantAfter(TS ts, PetscReal h, PetscReal next, SlipConstant *steps);
PETSC_INTERN PetscErrorCode SlipGuardRejections(TS ts, PetscInt rejections);
PETSC_INTERN PetscErrorCode SlipGuardStep(TS ts); /* raises an error if ts->time_step is below the rounding of time */
PETSC_INTERN PetscBool SlipStepIsLost(TS ts, PetscReal h, PetscReal *least);
/* Collective, within a step: the run ends by an error, which is raised next, because its steps do not advance. Code
   that stores states of the run, such as checkpoints, composes a function (TS) with the TS, which is called here; the
   state of the step's start is that of rollback(). */
#define SLIP_RUN_FAILS_METHOD "SlipRunFails_C"
PETSC_INTERN PetscErrorCode SlipRunFails(TS ts);
PETSC_INTERN PetscErrorCode SlipGuardState(Vec w, PetscBool *good); /* true if all entries are finite; collective */

/* ---- bathestate.c: for checkpoints ---- */
PETSC_INTERN PetscErrorCode SlipStateTS(SlipState, TS);
PETSC_INTERN PetscErrorCode SlipStateAttempt(SlipState, SlipAttempt *);

/* ---- problem.c ---- */
/* Calls a function of the problem of ts, if there is one, as PetscTryTypeMethod() does: SlipProblemTry(ts,
   steps.corner, t, next) */
#define SlipProblemTry(ts, function, ...)                                                                              \
  do {                                                                                                                 \
    const SlipProblemOps *problem_;                                                                                    \
    void *problem_ctx_;                                                                                                \
                                                                                                                       \
    PetscCall(TSGetSlipProblem(ts, &problem_, &problem_ctx_));                                                         \
    if (problem_ && problem_->function) PetscCall((*problem_->function)(ts, __VA_ARGS__, problem_ctx_));               \
  } while (0)
PETSC_INTERN PetscErrorCode SlipProblemRollBack(TS ts);
PETSC_INTERN PetscErrorCode SlipHistoryError(TS ts, Vec w, PetscReal *E, PetscInt *order);
