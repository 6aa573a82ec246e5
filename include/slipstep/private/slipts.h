/* Internal header of src/ts, mainly of TSBATHE */
#pragma once
#include <slipstep/rooms/slipts.h>
#include <petsc/private/tsimpl.h>
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>
#include <slipstep/private/sliploops.h>
#include <slipstep/private/slipclock.h>
#include <slipstep/private/slipstate.h>
#include <slipstep/private/slipsys.h>

#define TSBATHE_CONSTRAINT "TSBatheConstraint" /* name by which a TS of any type stores it */

typedef struct TSBatheMonitor TSBatheMonitor;
struct TSBatheMonitor {
  TSBatheAttemptFn fn;
  void *ctx;
  PetscErrorCode (*destroy)(void **);
  TSBatheMonitor *next;
};

/* Constant steps, one of which was rejected */
typedef struct {
  PetscReal asked; /* their length, to which they will return; 0: unchanged [s] */
  PetscBool told;
} SlipConstant;

/* Cached data at the start or end of explicit steps: the driving force of the state, the damping of the inner rates of
   the last two steps, that of the state, and these steps [s], 0 if the damping is that of a state; reduced */
typedef struct {
  PetscBool known;
  Vec f, p, p_before, p_end;
  PetscReal h, h_before;
} SlipMoreauMemory;

typedef struct {
  /* what the user chose */
  TSBatheMethod method, now;                    /* now: of the attempt, implicit or explicit */
  PetscReal gamma;                              /* split of the step, in (0, 1), with a trapezoidal stage 1 */
  TSBatheFirstStage first;                      /* rule of stage 1 */
  PetscBool first_set;                          /* it was chosen */
  SlipBathe c;                                  /* coefficients of both stages */
  TSBatheReactionType reaction;                 /* of stage 1 */
  TSBatheError error;                           /* error estimate */
  PetscBool error_set;                          /* the user chose it, so that adapt none does not disable doubling */
  PetscInt order;                               /* p of doubling's (2^p - 1) */
  PetscInt max_failures;                        /* attempts in a row that may fail to converge */
  PetscReal stage_error;                        /* allowed error of stages, relative to that of the step */
  PetscBool lifted_failures, lifted_rejections; /* PETSc's default limits, restored for another type */
  PetscInt parts;                               /* parts in which the solution of each step is computed; 0 or 1: one */
  TSBathePartFn part;                           /* called at the end of each, or NULL */
  void *part_ctx;
  SlipConstraint con;           /* NULL: unconstrained */
  const SlipConstraintOps *ops; /* its operations */
  void *ctx;                    /* and their context */

  /* the accepted step */
  Vec X0;         /* state at the step's start, for rollback */
  Vec Y[2];       /* stages: the state at t0 + gamma h and at t0 + h */
  Vec K0, K1, K2; /* A^-1 (F_s + r) at the start, after stage 1, at the end; K1 is also work */
  Vec Wm;         /* interpolation: a state inside, at this fraction of the step */
  PetscReal share;
  PetscBool k0_known, k2_known; /* K0, K2 are valid for this step's start and end */
  PetscBool stops;              /* the attempt ends where motion stops (SlipProblemOps) */
  PetscObjectId sol_id;         /* vec_sol after the last step: K2 and r are valid only while it is unchanged */
  PetscObjectState sol_state;

  /* explicit steps, created on first use */
  SlipMoreauMemory start, end;
  Vec push, p_inner;      /* the force of a kick, and the damping of a step's inner rate */
  Vec p_first;            /* and that of the first kick */
  PetscReal omega, ratio; /* by SlipExplicitOps.frequency, at the step's start */
  Vec K_before;           /* K0 of the step before */
  Vec rows;               /* full: 2 in rows without r */
  PetscReal dt_before;    /* that step [s]; 0: K_before is invalid */
  PetscBool bound_told;

  /* explicit steps without inertia */
  PetscBool stabilised;         /* the problem has them */
  PetscBool k0_sides, k2_sides; /* K0, K2 are right-hand sides of theirs */
  Vec cheb[3];                  /* stages, on first use */
  PetscReal rate;               /* fastest relaxation rate of the solution [1/s] */
  PetscReal implicit;           /* cost of an implicit solve over that of a stage; 0: unknown */

  /* TSBATHE_METHOD_AUTO */
  PetscBool method_given; /* by the user, or as the default of a problem */
  SlipMethodCosts costs;
  PetscReal longest;  /* longest stable explicit step [s] */
  PetscReal refused;  /* until when steps do not grow beyond the controller's, after a long one was rejected [s] */
  PetscInt cut, wait; /* explicit steps since then that were shortened, and how many of them end this */
  PetscInt explicits; /* attempts of the run that were explicit */

  /* doubling, created on first use */
  Vec Wfull, Wmid;

  /* one Bathe step */
  PetscReal stage_time, theta;
  PetscReal error_share,
    error_dt;                /* error of the rates of the last step, and that step [s], over their change; 0: unknown */
  Vec base, affine, Xdot, E; /* E: the error estimate */

  /* constraint */
  Vec r, r0, r1, rmid; /* reaction: accepted, at the step's start, after stage 1, after the first half step */
  Vec x;               /* reduced work */
  Vec Fs;              /* explicit part of stage 1, full */
  PetscBool r_given;   /* the user set the initial reaction */

  /* bookkeeping */
  TSStepStatus status;
  SlipAttempt last;
  PetscInt failures;    /* attempts in a row that failed to converge */
  PetscReal stagnated;  /* residual that the first of them ended with */
  PetscBool floor_told; /* message that shorter steps do not reduce it */
  SlipConstant constant;
  PetscReal barrier;                                   /* end of an attempt that would have passed an instability [s] */
  PetscInt towards;                                    /* steps in a row that were shortened because of it */
  PetscInt attempts, accepted, solves, newton, linear; /* totals since TSSolve() began */
  SlipProducts cost;                                   /* of the run, when monitors got the last attempt */
  TSBatheMonitor *monitors;
} TS_Bathe;

/* The problem's operations */
PETSC_INTERN PetscErrorCode SlipConstraintGetOps(SlipConstraint, const SlipConstraintOps **);
PETSC_INTERN PetscErrorCode SlipConstraintCreateReduced(SlipConstraint, Vec *);

PETSC_INTERN PetscErrorCode TSBatheGetData(TS, PetscBool required, TS_Bathe **);

/* One step h from (t, w0, r0) to (w2, r2) through w1; ok: no stage failed. resnorm: the larger one of the stages */
PETSC_INTERN PetscErrorCode TSBatheSubstep(TS, PetscReal t, PetscReal h, Vec w0, Vec r0, Vec w1, Vec w2, Vec r2,
                                           PetscReal *resnorm, PetscBool *ok);
/* moreau.c: the same for an explicit step, whose inner state is w1; K2 is dw/dt at its end */
PETSC_INTERN PetscErrorCode TSMoreauSubstep(TS, PetscReal t, PetscReal h, Vec w0, Vec w1, Vec w2, Vec r2,
                                            PetscBool *ok);
PETSC_INTERN PetscErrorCode TSMoreauStart(TS);                      /* recomputes start from X0, r0 and K0 */
PETSC_INTERN PetscErrorCode TSMoreauBegin(TS, PetscBool unchanged); /* likewise, from the last step's end if possible */
PETSC_INTERN PetscErrorCode TSMoreauError(TS, PetscReal h, Vec e);
PETSC_INTERN PetscErrorCode TSMoreauReset(TS);
PETSC_INTERN PetscErrorCode TSMoreauState(SlipState, TS);
PETSC_INTERN PetscErrorCode TSMoreauCut(TS, PetscReal *whole); /* shortens ts->time_step to a stable one */
/* bathemethod.c: sets ba->now, for a step of ts->time_step */
PETSC_INTERN PetscErrorCode TSBatheChooseMethod(TS);
PETSC_INTERN PetscErrorCode TSBatheMethodWish(TS, PetscReal whole, PetscReal *next);
PETSC_INTERN PetscErrorCode TSBatheMethodBegin(TS);
PETSC_INTERN void TSBatheMethodRefused(TS);
PETSC_INTERN PetscErrorCode TSBatheMethodState(SlipState, TS);
PETSC_INTERN PetscErrorCode TSCreate_Moreau(TS);
PETSC_INTERN PetscErrorCode TSBatheStartDerivative(TS, PetscReal t, Vec w0, Vec r0, Vec k0, PetscBool *known);
PETSC_INTERN PetscErrorCode TSBatheEndDerivative(TS, PetscReal h, Vec w0, Vec w1, Vec w2, Vec k2);
PETSC_INTERN PetscErrorCode TSBatheDropSticking(TS ts, Vec w, Vec e); /* zeroes the rate rows of cells at rest in w */
PETSC_INTERN PetscErrorCode TSBatheEmbeddedError(TS, PetscReal h, Vec e);
PETSC_INTERN PetscErrorCode TSBatheDoublingError(TS, Vec e);
PETSC_INTERN PetscErrorCode TSBatheErrorNorm(TS, NormType, PetscReal *norm);
PETSC_INTERN PetscErrorCode TSBatheKeepErrorShare(TS);
PETSC_INTERN PetscReal TSBatheStageShare(TS, PetscReal h); /* SlipStage.share of a step h */
/* batheattempt.c */
PETSC_INTERN PetscErrorCode TSBatheWorst(TS, PetscInt *index, PetscReal *residual);
PETSC_INTERN PetscErrorCode TSBatheTellFloor(TS);
PETSC_INTERN PetscErrorCode TSStep_Bathe(TS);
PETSC_INTERN PetscErrorCode TSRollBack_Bathe(TS);
PETSC_INTERN PetscErrorCode SNESTSFormFunction_Bathe(SNES, Vec, Vec, TS);
PETSC_INTERN PetscErrorCode SNESTSFormJacobian_Bathe(SNES, Vec, Mat, Mat, TS);
PETSC_INTERN PetscErrorCode TSCreate_Bathe(TS);
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

/* ---- stabilised.c: explicit steps of TSBATHE without inertia ---- */
PETSC_INTERN PetscErrorCode TSStabilisedIs(TS, PetscBool *is);
PETSC_INTERN PetscErrorCode TSStabilisedChoose(TS);                     /* ba->now */
PETSC_INTERN PetscErrorCode TSStabilisedStart(TS, PetscBool unchanged); /* K0, for ba->now */
PETSC_INTERN PetscErrorCode TSStabilisedSubstep(TS, PetscReal t, PetscReal h, Vec w0, Vec w1, Vec w2, Vec r2,
                                                PetscBool *ok);
PETSC_INTERN PetscErrorCode TSStabilisedError(TS, PetscReal h, Vec e);
PETSC_INTERN PetscErrorCode TSStabilisedReset(TS);
PETSC_INTERN PetscErrorCode TSStabilisedState(SlipState, TS);
PETSC_INTERN void TSStabilisedLearn(TS);

/* ---- explicitattempts.c: a step of several attempts from one state ---- */
/* The first member of the context of a type that uses it */
typedef struct {
  Vec start;           /* state at the start of the step */
  Vec f;               /* rates there, for types that start with those at the end of the last step; else NULL */
  PetscBool known;     /* f is valid */
  PetscInt rejections; /* rejected attempts of this step */
  PetscReal whole;     /* the attempt's step before it was limited [s] */
  PetscReal corner;    /* of the loading, where the attempt ends unless its type limits it further [s]; PETSC_MAX_REAL:
                          none */
  PetscReal before, h; /* time at the start of the last accepted step, and its length [s] */
} SlipAttempts;
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
} SlipAttemptOps;
PETSC_INTERN PetscErrorCode SlipAttemptsStep(TS ts, const SlipAttemptOps *ops, PetscBool *accepted);
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
} TS_Adams;
PETSC_INTERN void SlipAdamsCorrector(const TS_Adams *ad, PetscReal h, PetscInt k, PetscReal weight[]);
PETSC_INTERN PetscReal SlipAdamsPromise(TS ts, PetscReal norm, PetscInt k);
PETSC_INTERN PetscErrorCode SlipAdamsSetCorrections(TS ts, PetscInt most);
PETSC_INTERN void SlipAdamsCount(TS ts);
PETSC_INTERN PetscErrorCode SlipAdamsBoundStep(TS ts, const SlipProblemOps *problem, void *ctx);
PETSC_INTERN PetscErrorCode SlipAdamsCorrectMore(TS ts, Vec predicted, Vec y, PetscBool *good);

/* ---- meetcorner.c: any integrator and controller ---- */
/* Makes ts->time_step end at a corner of the loading that it would pass, and limits a first step to the controller's
   longest one. whole: the step before it was shortened for a corner; corner: the end of the step then, PETSC_MAX_REAL
   if there is no corner [s]. Collective, before each attempt */
PETSC_INTERN PetscErrorCode SlipMeetCorner(TS ts, PetscReal *whole, PetscReal *corner);
/* From TSPreStep: the same before a step of a type of PETSc's. Prints a warning, once, if constant steps of PETSc's
   types pass a corner, or if ours, which end there, are longer than the time to the next one. */
PETSC_EXTERN PetscErrorCode SlipMeetCornerBefore(TS ts, PetscBool ours, PetscBool *warned);
/* From TSPreStep: limits ts->time_step, of an explicit type of PETSc's, so that no slip rate oscillates. */
PETSC_EXTERN PetscErrorCode SlipMeetRelaxation(TS ts);

/* ---- guard.c ---- */
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
/* problem.c: passes the history to problems that store it, see SlipProblemOps */
PETSC_INTERN PetscErrorCode SlipProblemAccept(TS ts);
PETSC_INTERN PetscErrorCode SlipProblemAdvance(TS ts, PetscReal t, Vec w);
PETSC_INTERN PetscErrorCode SlipProblemRollBack(TS ts);
