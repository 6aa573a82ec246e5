/* TSBATHE's inside, shared by the files of src/ts. */
#pragma once
#include <slipts.h>
#include <petsc/private/tsimpl.h>
#include <slipcompat.h>
#include <slipcore.h>
#include <slipstep/private/slipclock.h>
#include <slipstep/private/slipstate.h>
#include <slipstep/private/slipsys.h>

#define TSBATHE_CONSTRAINT "TSBatheConstraint" /* under which a TS knows it, of whatever type it is */

typedef struct TSBatheMonitor TSBatheMonitor;
struct TSBatheMonitor {
  TSBatheAttemptFn fn;
  void *ctx;
  PetscErrorCode (*destroy)(void **);
  TSBatheMonitor *next;
};

/* Constant steps of which one was refused */
typedef struct {
  PetscReal asked; /* what they were, and will be again; 0: they are [s] */
  PetscBool told;
} SlipConstant;

/* What explicit steps know where one starts or has ended: the driving force of the state there, the damping of the
   inner rates of the last two steps, that of the state, and these steps [s], 0 where the damping is a state's;
   reduced */
typedef struct {
  PetscBool known;
  Vec f, p, p_before, p_end;
  PetscReal h, h_before;
} SlipMoreauMemory;

typedef struct {
  /* what the user chose */
  TSBatheMethod method, now;                    /* now: of the attempt; implicit or explicit */
  PetscReal gamma;                              /* split of the step, in (0, 1), with a trapezoidal stage 1 */
  TSBatheFirstStage first;                      /* rule of stage 1 */
  PetscBool first_set;                          /* it was chosen */
  SlipBathe c;                                  /* numbers of both */
  TSBatheReactionType reaction;                 /* treatment of the reaction in stage 1 */
  TSBatheError error;                           /* error estimate */
  PetscBool error_set;                          /* chosen explicitly, so that adapt none does not switch doubling off */
  PetscInt order;                               /* p of doubling's (2^p - 1) */
  PetscInt max_failures;                        /* attempts in a row that may fail to converge */
  PetscReal stage_error;                        /* what stages may add to a step's error, over that */
  PetscBool lifted_failures, lifted_rejections; /* PETSc's default limits, which another type finds again */
  PetscInt parts;     /* the solution is computed in so many parts of each step; 0 or 1: in one */
  TSBathePartFn part; /* called at the end of each, or NULL */
  void *part_ctx;
  SlipConstraint con;           /* NULL: unconstrained */
  const SlipConstraintOps *ops; /* its operations */
  void *ctx;                    /* and their context */

  /* the accepted step */
  Vec X0;         /* state at the step's start, for rollback */
  Vec Y[2];       /* stages: the state at t0 + gamma h and at t0 + h */
  Vec K0, K1, K2; /* A^-1 (F_s + r) at the start, after stage 1, at the end; K1 also serves as work */
  Vec Wm;         /* interpolation: an inner state, at this share of the step */
  PetscReal share;
  PetscBool k0_known, k2_known; /* K0, K2 are those of this step's start and end */
  PetscBool stops;              /* the attempt ends where something stops (SlipProblemOps) */
  PetscObjectId sol_id;         /* vec_sol as the last step left it: K2 and r belong to it only while it is unchanged */
  PetscObjectState sol_state;

  /* explicit steps, on first use */
  SlipMoreauMemory start, end;
  Vec push, p_inner;      /* the force of a kick, and the damping of a step's inner rate */
  Vec p_first;            /* and of the first kick */
  PetscReal omega, ratio; /* SlipExplicitOps.frequency, of the step's start */
  Vec K_before;           /* K0 of the step before */
  Vec rows;               /* full: 2 where r does not enter */
  PetscReal dt_before;    /* that step [s]; 0: K_before is not known */
  PetscBool bound_told;

  /* explicit steps without inertia */
  PetscBool stabilised;         /* the problem has them */
  PetscBool k0_sides, k2_sides; /* K0, K2 are right-hand sides of theirs */
  Vec cheb[3];                  /* stages, on first use */
  PetscReal rate;               /* the fastest that the solution relaxes at [1/s] */
  PetscReal implicit;           /* what an implicit solve costs, over a stage; 0: not known */

  /* TSBATHE_METHOD_AUTO */
  PetscBool method_given; /* or another is the default of a problem */
  SlipMethodCosts costs;
  PetscReal longest;  /* explicit step that is stable [s] */
  PetscReal refused;  /* until when steps do not grow beyond the controller's, as a long one was refused [s] */
  PetscInt cut, wait; /* explicit steps since then that were cut, and how many of them end that */
  PetscInt explicits; /* attempts of the run that were explicit */

  /* doubling, on first use */
  Vec Wfull, Wmid;

  /* one Bathe step */
  PetscReal stage_time, theta;
  PetscReal error_share,
    error_dt;                /* error of the rates of the last step, and that step [s], over their change; 0: it is
                                      not known */
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
  PetscBool floor_told; /* that shorter steps leave it as it is */
  SlipConstant constant;
  PetscReal barrier; /* where an attempt ended that would have gone past an instability [s] */
  PetscInt towards;  /* steps in a row that were cut because of it */
  PetscInt attempts, accepted, solves, newton, linear; /* totals since TSSolve() began */
  SlipProducts cost;                                   /* of the run, when the monitors were told of the last attempt */
  TSBatheMonitor *monitors;
} TS_Bathe;

/* The problem's operations */
PETSC_INTERN PetscErrorCode SlipConstraintGetOps(SlipConstraint, const SlipConstraintOps **);
PETSC_INTERN PetscErrorCode SlipConstraintCreateReduced(SlipConstraint, Vec *);

PETSC_INTERN PetscErrorCode TSBatheGetData(TS, PetscBool required, TS_Bathe **);

/* One step h from (t, w0, r0) to (w2, r2) through w1; ok: no stage failed. resnorm: larger of the stages' */
PETSC_INTERN PetscErrorCode TSBatheSubstep(TS, PetscReal t, PetscReal h, Vec w0, Vec r0, Vec w1, Vec w2, Vec r2,
                                           PetscReal *resnorm, PetscBool *ok);
/* moreau.c: the same of an explicit step, whose inner state is w1; K2 is dw/dt at its end */
PETSC_INTERN PetscErrorCode TSMoreauSubstep(TS, PetscReal t, PetscReal h, Vec w0, Vec w1, Vec w2, Vec r2,
                                            PetscBool *ok);
PETSC_INTERN PetscErrorCode TSMoreauStart(TS);                      /* start of X0, r0 and K0, anew */
PETSC_INTERN PetscErrorCode TSMoreauBegin(TS, PetscBool unchanged); /* likewise, from the last step's end if it can */
PETSC_INTERN PetscErrorCode TSMoreauError(TS, PetscReal h, Vec e);
PETSC_INTERN PetscErrorCode TSMoreauReset(TS);
PETSC_INTERN PetscErrorCode TSMoreauState(SlipState, TS);
PETSC_INTERN PetscErrorCode TSMoreauCut(TS, PetscReal *whole); /* ts->time_step, to what is stable */
/* bathemethod.c: ba->now, for a step of ts->time_step */
PETSC_INTERN PetscErrorCode TSBatheChooseMethod(TS);
PETSC_INTERN PetscErrorCode TSBatheMethodWish(TS, PetscReal whole, PetscReal *next);
PETSC_INTERN PetscErrorCode TSBatheMethodBegin(TS);
PETSC_INTERN void TSBatheMethodRefused(TS);
PETSC_INTERN PetscErrorCode TSBatheMethodState(SlipState, TS);
PETSC_INTERN PetscErrorCode TSCreate_Moreau(TS);
PETSC_INTERN PetscErrorCode TSBatheStartDerivative(TS, PetscReal t, Vec w0, Vec r0, Vec k0, PetscBool *known);
PETSC_INTERN PetscErrorCode TSBatheEndDerivative(TS, PetscReal h, Vec w0, Vec w1, Vec w2, Vec k2);
PETSC_INTERN PetscErrorCode TSBatheDropSticking(TS ts, Vec w, Vec e); /* zero the rate rows of what rests in w */
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

/* ---- adamssum.c: a step's sums in one pass ---- */
typedef struct {
  const PetscReal *absolutes, *relatives; /* or NULL: the numbers */
  PetscReal absolute, relative;
  const PetscReal *inverse; /* 1 / absolutes where the relative ones are all 0, 0 where both are; else NULL */
} SlipAdamsTolerance;
typedef struct {
  PetscBool finite;
  PetscReal most[3], squares[3]; /* of each estimate: largest share of its tolerance, sum of squares, */
  PetscReal count[3];            /* and entries that have a tolerance, where they are not those of inverse */
} SlipAdamsSums;
typedef struct { /* inverse, kept until the vectors change */
  PetscReal *inverse;
  PetscInt entries; /* of this rank that have a tolerance */
  PetscObjectState state[2];
  PetscObjectId id[2]; /* of the absolute tolerances and the relative ones */
} SlipAdamsInverse;
PETSC_INTERN PetscErrorCode SlipAdamsGetTolerance(TS ts, SlipAdamsInverse *kept, SlipAdamsTolerance *tolerance);
PETSC_INTERN void SlipAdamsSum(PetscInt n, const PetscReal start[], PetscInt m, const PetscReal *const rate[],
                               const PetscReal weight[][SLIP_ADAMS_NODES], PetscInt estimates,
                               const SlipAdamsTolerance *tolerance, PetscReal y[], SlipAdamsSums *sums);

/* The same of vectors that are on the device, in adamsdevice.c; with estimates tolerances are vectors */
PETSC_INTERN PetscErrorCode SlipAdamsSumDevice(TS ts, PetscBool star, PetscInt m,
                                               const PetscReal weight[][SLIP_ADAMS_NODES], PetscInt estimates, Vec y,
                                               SlipAdamsSums *sums);

/* ---- rkc.c ---- */
#define SLIP_RATE_MARGIN 1.05 /* the fastest rate of a problem is found by products, from below */
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

/* ---- explicitattempts.c: a step of attempts from one state ---- */
/* The first member of what a type that uses it keeps */
typedef struct {
  Vec start;           /* state at the start of the step */
  Vec f;               /* rates there, of types that begin with those of the last step's end; else NULL */
  PetscBool known;     /* f is that */
  PetscInt rejections; /* attempts of this step that were refused */
  PetscReal whole;     /* the attempt's step before it was limited [s] */
  PetscReal corner;    /* of the loading, at which the attempt ends unless its type limits it further [s];
                          PETSC_MAX_REAL: none */
  PetscReal before, h; /* time at the start of the last accepted step, and its length [s] */
} SlipAttempts;
/* What a type does; each but attempt and accept may be NULL */
typedef struct {
  PetscErrorCode (*begin)(TS); /* from start and f */
  PetscErrorCode (*limit)(TS); /* ts->time_step of an attempt */
  /* vec_sol after ts->time_step; not good: it has left the domain of the right-hand side */
  PetscErrorCode (*attempt)(TS, PetscBool *good);
  PetscInt (*order)(TS);                       /* of the attempt; NULL: 2 */
  PetscBool (*whatever)(TS);                   /* is it taken whatever its error is? NULL: no */
  PetscErrorCode (*retry)(TS, PetscBool good); /* it was refused, and ts->time_step is the next */
  PetscErrorCode (*accept)(TS);                /* it was not, and ts->ptime is its end and ts->time_step the next */
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
  PetscInt n;         /* derivatives in hand */
  PetscInt since;     /* accepted steps with this order */
  Vec rate[ADAMS_SLOTS];
  PetscReal age[ADAMS_SLOTS]; /* how long ago they were, newest first, as sums of steps [s] */
  Vec star;                   /* f* */
  Vec y;
  SlipAdamsInverse inverse;
  PetscInt dense;      /* derivatives that the last step's polynomial goes through, that of its end first */
  PetscBool estimated; /* norm is that of this attempt, for the next order */
  PetscReal norm;
  PetscBool normed; /* norms are those of this attempt, by their type, of its order, the one below and the one above */
  NormType type;
  PetscReal norms[3];
  PetscInt most;        /* corrections of a step */
  PetscInt corrections; /* of the attempt */
  PetscReal rates[2]; /* fastest rates of relaxation at the starts of this step and the one before; 0: unknown [1/s] */
  Vec room[2];        /* of corrections */
} TS_Adams;
PETSC_INTERN void SlipAdamsCorrector(const TS_Adams *ad, PetscReal h, PetscInt k, PetscReal weight[]);
PETSC_INTERN PetscReal SlipAdamsPromise(TS ts, PetscReal norm, PetscInt k);
PETSC_INTERN PetscErrorCode SlipAdamsSetCorrections(TS ts, PetscInt most);
PETSC_INTERN void SlipAdamsCount(TS ts);
PETSC_INTERN PetscErrorCode SlipAdamsBoundStep(TS ts, const SlipProblemOps *problem, void *ctx);
PETSC_INTERN PetscErrorCode SlipAdamsCorrectMore(TS ts, Vec predicted, Vec y, PetscBool *good);

/* ---- meetcorner.c: any integrator and controller ---- */
/* Makes ts->time_step end at the corner of the loading that it would pass, and a first step no longer than the longest
   one of the controller. whole: the step before it was cut for a corner; corner: where it ends then, PETSC_MAX_REAL
   where it passes none [s]. Collective, before each attempt */
PETSC_INTERN PetscErrorCode SlipMeetCorner(TS ts, PetscReal *whole, PetscReal *corner);
/* From TSPreStep: the same before a step of a type of PETSc's own. Constant steps are warned of, once, where those of
   PETSc's types pass a corner, and where ours, which end there, are longer than from it to the next one. */
PETSC_EXTERN PetscErrorCode SlipMeetCornerBefore(TS ts, PetscBool ours, PetscBool *warned);
/* From TSPreStep: makes ts->time_step, of an explicit type of PETSc's, one that lets no slip rate chatter */
PETSC_EXTERN PetscErrorCode SlipMeetRelaxation(TS ts);

/* ---- guard.c ---- */
/* Constant steps go on as they were before one was cut to end at a corner of the loading, at end [s]. whole: that step
   [s] */
PETSC_INTERN PetscReal SlipStepAfterCorner(TS ts, PetscReal end, PetscReal whole);
PETSC_INTERN PetscReal SlipTimeAfterStep(TS ts);
PETSC_INTERN PetscErrorCode SlipStepAfterFailure(TS ts, PetscReal *next_h);
PETSC_INTERN PetscErrorCode SlipGuardConstant(TS ts, PetscReal h); /* an error where steps are constant */
PETSC_INTERN PetscErrorCode SlipConstantRefused(TS ts, PetscReal h, SlipConstant *steps);
PETSC_INTERN PetscReal SlipConstantAfter(TS ts, PetscReal h, PetscReal next, SlipConstant *steps);
PETSC_INTERN PetscErrorCode SlipGuardRejections(TS ts, PetscInt rejections);
PETSC_INTERN PetscErrorCode SlipGuardStep(TS ts); /* an error where ts->time_step is below the rounding of time */
PETSC_INTERN PetscBool SlipStepIsLost(TS ts, PetscReal h, PetscReal *least);
/* Collective, within a step: the run ends by an error, which is raised next, as its steps lead nowhere. Who keeps
   states of the run, as checkpoints do, composes a function (TS) with the TS, and is told here; the state of the step's
   start is rollback()'s. */
#define SLIP_RUN_FAILS_METHOD "SlipRunFails_C"
PETSC_INTERN PetscErrorCode SlipRunFails(TS ts);
PETSC_INTERN PetscErrorCode SlipGuardState(Vec w, PetscBool *good); /* all of it are numbers; collective */

/* ---- bathestate.c: for checkpoints ---- */
PETSC_INTERN PetscErrorCode SlipStateTS(SlipState, TS);
PETSC_INTERN PetscErrorCode SlipStateAttempt(SlipState, SlipAttempt *);
/* problem.c: what remembers is told of its history, as SlipProblemOps says */
PETSC_INTERN PetscErrorCode SlipProblemAccept(TS ts);
PETSC_INTERN PetscErrorCode SlipProblemAdvance(TS ts, PetscReal t, Vec w);
PETSC_INTERN PetscErrorCode SlipProblemRollBack(TS ts);
