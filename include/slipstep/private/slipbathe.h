/* Internal header of TSBATHE and TSMOREAU: their context, and the methods of their attempts. Each part of the context
   stands with the functions of the file that owns it. */
#pragma once
#include <slipstep/private/slipts.h>

#define TSBATHE_CONSTRAINT "TSBatheConstraint" /* name by which a TS of any type stores it */

typedef struct TS_Bathe TS_Bathe;

/* A method of attempts: a row of functions in a file of its own, which bathemethod.c chooses for each attempt. An
   attempt leads from X0, r0 and K0 to Y[1], r and K2. Any function but begin, substep and error may be NULL. */
typedef struct {
  TSBatheMethod method; /* its name in records */
  PetscBool hermite;    /* K0 and K2 interpolate within its steps; otherwise K2 and the inner state do */
  /* A step begins from X0: sets r0 and K0. unchanged: X0 is the end of the last step. */
  PetscErrorCode (*begin)(TS, PetscBool unchanged);
  /* Cuts ts->time_step to what is stable; *whole: the step before it was cut, also by others [s] */
  PetscErrorCode (*limit)(TS, PetscReal *whole);
  /* An attempt begins, perhaps after attempts by other methods: sets K0 and what else the method needs of X0 */
  PetscErrorCode (*start)(TS);
  /* One step h from (t, w0, r0) to (w2, r2) through w1, at the fraction ba->share; ok: it succeeded. residual is
     the larger relative one of its solves, 0 before the call. */
  PetscErrorCode (*substep)(TS, PetscReal t, PetscReal h, Vec w0, Vec r0, Vec w1, Vec w2, Vec r2, PetscReal *residual,
                            PetscBool *ok);
  /* K2, from the last substep of an attempt; NULL: substep sets it */
  PetscErrorCode (*end)(TS, PetscReal h, Vec w0, Vec w1, Vec w2);
  PetscErrorCode (*error)(TS, PetscReal h, Vec e);        /* embedded estimate of the step h from X0 to Y[1] */
  PetscErrorCode (*norm)(TS, PetscReal *norm);            /* its norm if the problem has one; NULL: SlipStepOps.error */
  void (*weights)(const TS_Bathe *, PetscReal weight[3]); /* quadrature over X0, Wm and Y[1]; NULL: quadratic */
  /* For TSBATHE_METHOD_AUTO: does the problem have such steps (NULL: yes)? Does one of ts->time_step cost less than an
     implicit one? The last attempt, by either method, took so many products. */
  PetscErrorCode (*exists)(TS, PetscBool *exists);
  PetscErrorCode (*pays)(TS, PetscBool *pays);
  void (*learn)(TS, PetscReal products);
} TSBatheMethodOps;

/* ---- bathestage.c: implicit stages ---- */
typedef struct {
  PetscReal gamma;              /* split of the step, in (0, 1), with a trapezoidal stage 1 */
  TSBatheFirstStage first;      /* rule of stage 1 */
  PetscBool first_set;          /* it was chosen */
  TSBatheReactionType reaction; /* of stage 1 */
  SlipBathe c;                  /* coefficients of both stages */
  PetscReal allowed;            /* error of stages, relative to that of the step */
  /* error of the rates of the last step, and that step [s], over their change; 0: unknown */
  PetscReal error_share, error_dt;
  PetscReal time, theta; /* of the stage that is solved */
  Vec base, affine, Xdot;
  Vec r1; /* reaction after stage 1 */
  Vec Fs; /* explicit part of stage 1, full */
} TSBatheStages;
PETSC_INTERN const TSBatheMethodOps TSBatheImplicit;
PETSC_INTERN PetscErrorCode TSBatheStartReaction(TS, PetscBool unchanged); /* r0 */
PETSC_INTERN PetscErrorCode TSBatheStartDerivative(TS, PetscReal t, Vec w0, Vec r0, Vec k0, PetscBool *known);
PETSC_INTERN PetscErrorCode TSBatheKeepErrorShare(TS);
PETSC_INTERN PetscErrorCode SNESTSFormFunction_Bathe(SNES, Vec, Vec, TS);
PETSC_INTERN PetscErrorCode SNESTSFormJacobian_Bathe(SNES, Vec, Mat, Mat, TS);

/* ---- moreau.c: explicit steps with inertia ---- */
/* Cached data at the start or end of explicit steps: the driving force of the state, the damping of the inner rates of
   the last two steps, that of the state, and these steps [s], 0 if the damping is that of a state; reduced */
typedef struct {
  Vec f, p, p_before, p_end;
  PetscReal h, h_before;
} SlipMoreauMemory;
typedef struct {
  PetscBool started; /* start is that of X0 */
  SlipMoreauMemory start, end;
  Vec push, p_inner;      /* the force of a kick, and the damping of a step's inner rate */
  Vec p_first;            /* and that of the first kick */
  PetscReal omega, ratio; /* by SlipExplicitOps.frequency, at the step's start */
  PetscReal longest;      /* longest stable step [s], for the choice of a method */
  SlipMethodCosts costs;  /* of such steps and of implicit ones, in products */
  Vec K_before;           /* K0 of the step before */
  PetscReal dt_before;    /* that step [s]; 0: K_before is invalid */
  Vec rows;               /* full: 2 in rows without r */
  PetscBool bound_told;
} TSMoreau;
PETSC_INTERN const TSBatheMethodOps TSBatheMoreau;
PETSC_INTERN PetscErrorCode TSMoreauReset(TS);
PETSC_INTERN PetscErrorCode TSMoreauState(SlipState, TS);
PETSC_INTERN PetscErrorCode TSCreate_Moreau(TS);

/* ---- stabilised.c: explicit steps without inertia ---- */
typedef struct {
  PetscBool k0_sides, k2_sides; /* K0, K2 are right-hand sides of such steps */
  Vec cheb[3];                  /* stages, on first use */
  PetscReal rate;               /* fastest relaxation rate of the solution [1/s] */
  PetscReal implicit;           /* cost of an implicit solve over that of a stage; 0: unknown */
} TSStabilised;
PETSC_INTERN const TSBatheMethodOps TSBatheStabilised;
PETSC_INTERN PetscErrorCode TSStabilisedReset(TS);
PETSC_INTERN PetscErrorCode TSStabilisedState(SlipState, TS);

/* ---- bathemethod.c: the method of the next attempt ---- */
typedef struct {
  TSBatheMethod method; /* the user's, or auto */
  PetscBool given;      /* by the user, or as the default of a problem */
  PetscReal refused;    /* until when steps do not grow beyond the controller's, after a long one was rejected [s] */
  PetscInt cut, wait;   /* explicit steps since then that were shortened, and how many of them end this */
} TSBatheChoice;
PETSC_INTERN PetscErrorCode TSBatheChooseMethod(TS); /* ba->now and ba->other, for a step of ts->time_step */
PETSC_INTERN PetscErrorCode TSBatheMethodWish(TS, PetscReal whole, PetscReal *next);
PETSC_INTERN PetscErrorCode TSBatheMethodBegin(TS);
PETSC_INTERN void TSBatheMethodRefused(TS);
PETSC_INTERN PetscErrorCode TSBatheMethodState(SlipState, TS);

/* ---- batheerror.c: error estimates ---- */
typedef struct {
  TSBatheError type;
  PetscBool given; /* the user chose it, so that adapt none does not disable doubling */
  PetscInt order;  /* p of doubling's (2^p - 1) */
  Vec E;           /* the estimate of the last attempt */
} TSBatheEstimate;
PETSC_INTERN PetscErrorCode TSBatheDropSticking(TS ts, Vec w, Vec e); /* zeroes the rate rows of cells at rest in w */
PETSC_INTERN PetscErrorCode TSBatheErrorNorm(TS, NormType, PetscReal *norm);

/* ---- batheparts.c: steps in parts; vectors are created on first use ---- */
typedef struct {
  PetscInt n;       /* parts in which the solution of each step is computed; 0 or 1: one */
  TSBathePartFn fn; /* called at the end of each, or NULL */
  void *ctx;
  Vec Wfull, Wmid; /* end of the whole step, and of every other part */
  Vec rmid;        /* reaction at that */
} TSBatheParts;
/* The substep of the attempt's method; it is counted, and its residual, or 2 if it fails, is added */
PETSC_INTERN PetscErrorCode TSBatheSubstep(TS, PetscReal t, PetscReal h, Vec w0, Vec r0, Vec w1, Vec w2, Vec r2,
                                           PetscReal *residual, PetscBool *ok);
PETSC_INTERN PetscErrorCode TSBatheWantsDoubling(TS, PetscBool *flg);
PETSC_INTERN PetscErrorCode TSBatheDoubling(TS, PetscReal h, PetscReal *residual, PetscBool *ok);
PETSC_INTERN PetscErrorCode TSBatheInParts(TS, PetscReal h, PetscInt parts, PetscReal *residual, PetscBool *ok);

/* ---- bathefailed.c: failed attempts, and instabilities ahead ---- */
typedef struct {
  PetscInt most;                /* attempts in a row that may fail to converge */
  PetscInt row;                 /* those that did */
  PetscBool lifted, rejections; /* PETSc's default limits of both were lifted; restored for another type */
  PetscReal stagnated;          /* residual that the first of them ended with */
  PetscBool floor_told;         /* message that shorter steps do not reduce it */
  SlipConstant constant;
  PetscReal barrier; /* end of an attempt that would have passed an instability [s] */
  PetscInt towards;  /* steps in a row that were shortened because of it */
} TSBatheFailures;
PETSC_INTERN PetscErrorCode TSBatheRestore(TS); /* the state and the reaction at the step's start */
PETSC_INTERN PetscErrorCode TSBatheSetStep(TS, PetscReal h);
PETSC_INTERN void TSBatheFailuresBegin(TSBatheFailures *);
PETSC_INTERN PetscErrorCode TSBatheFailed(TS, PetscReal whole);
PETSC_INTERN void TSBatheApproach(TS, PetscReal *h);

/* ---- batheattempt.c: what is reported of attempts ---- */
typedef struct TSBatheMonitor TSBatheMonitor;
struct TSBatheMonitor {
  TSBatheAttemptFn fn;
  void *ctx;
  PetscErrorCode (*destroy)(void **);
  TSBatheMonitor *next;
};
typedef struct {
  PetscInt attempts, accepted, solves, newton, linear; /* since TSSolve() began */
  PetscInt explicits;                                  /* attempts that were explicit */
  SlipProducts cost;                                   /* of the run, when monitors got the last attempt */
} TSBatheTotals;
PETSC_INTERN PetscErrorCode TSBatheRunMonitors(TS);

/* ---- bathestep.c: what several of these files use ---- */
struct TS_Bathe {
  SlipConstraint con;           /* NULL: unconstrained */
  const SlipConstraintOps *ops; /* its operations */
  void *ctx;                    /* and their context */
  Vec x, r;                     /* reduced: work, and the accepted reaction */
  PetscBool r_given;            /* the user set it */

  Vec X0, r0;                   /* state and reaction at the step's start, for rollback */
  Vec Y[2];                     /* the state inside an attempt and that at its end, or of its last part */
  Vec K0, K1, K2;               /* A^-1 (F_s + r) at the start, after stage 1, at the end; K1 is also work */
  PetscBool k0_known, k2_known; /* K0, K2 are valid for this step's start and end */
  Vec Wm;                       /* a state inside the step, at this fraction of it */
  PetscReal share;
  PetscBool stops;      /* the attempt ends where motion stops (SlipStepOps) */
  PetscObjectId sol_id; /* vec_sol after the last step: K2 and r are valid only while it is unchanged */
  PetscObjectState sol_state;
  TSStepStatus status;

  const TSBatheMethodOps *now;   /* of the next attempt */
  const TSBatheMethodOps *was;   /* of the last one */
  const TSBatheMethodOps *other; /* what TSBATHE_METHOD_AUTO may take in place of implicit steps; NULL: nothing */
  SlipAttempt last;
  TSBatheMonitor *monitors;

  TSBatheChoice choice;
  TSBatheStages stages;
  TSMoreau moreau;
  TSStabilised stabilised;
  TSBatheEstimate estimate;
  TSBatheParts parts;
  TSBatheFailures failures;
  TSBatheTotals totals;
};
PETSC_INTERN PetscErrorCode TSStep_Bathe(TS);
PETSC_INTERN PetscErrorCode TSRollBack_Bathe(TS);

PETSC_INTERN PetscErrorCode TSBatheGetData(TS, PetscBool required, TS_Bathe **);
PETSC_INTERN PetscErrorCode TSCreate_Bathe(TS);

/* The problem's operations */
PETSC_INTERN PetscErrorCode SlipConstraintGetOps(SlipConstraint, const SlipConstraintOps **);
PETSC_INTERN PetscErrorCode SlipConstraintCreateReduced(SlipConstraint, Vec *);
