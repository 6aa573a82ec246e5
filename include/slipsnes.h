/* Set-valued reactions inside an implicit stage: the constraint object and the two cone solvers (SNES types). */
#pragma once
#include <petscsnes.h>
#include <petscmat.h>

/* One implicit stage, in the full state w:
       A (w - base) = theta [ F_s(t, w) + explicit_part + omega r ],   r_i in -q_i Sign(x_i)
   x is the reduced unknown (fault: slip rate v, one per cell; or vectors, SlipConstraintSetComponents()). After
   elimination the balance is
       G(x) = omega r(x),   G(x) = B x - c for a linear smooth part (fault: B(theta) of slipmat.h).
   Stage 1 (trapezoidal): theta = gamma h/2, base = w0, explicit_part = F_s(w0) + r0 and omega = 1 (reaction
   "trapezoidal"), or explicit_part = F_s(w0) and omega = 2 ("implicit"). Stage 2 (BDF2): theta = b h,
   base = a1 w1 - a0 w0, explicit_part = NULL, omega = 1. */
typedef struct {
  PetscReal t;       /* time of the stage's end [s] */
  PetscReal theta;   /* [s] */
  PetscReal omega;   /* weight of the reaction, 1 or 2 */
  Vec base;          /* full space */
  Vec explicit_part; /* full space, or NULL */
  Vec from[2]; /* states that base is the sum of, as well as their factors and number; 0: nobody says. A problem */
  PetscReal factor[2]; /* that has products with them need not make those with base. explicit_part is of from[0] */
  PetscInt nfrom;
  PetscReal share; /* of the residual of the guess that may be left, in (0, 1); 0: as little as -snes_rtol says */
} SlipStage;

/* A set-valued reaction for the cone solvers, TSBATHE and TSMOREAU; a PETSc object. */
typedef struct _p_SlipConstraint *SlipConstraint;
PETSC_EXTERN PetscClassId SLIP_CONSTRAINT_CLASSID;

/* Where a state is in an explicit step */
typedef enum { SLIP_NODE_START, SLIP_NODE_INSIDE, SLIP_NODE_END, SLIP_NUM_NODES } SlipNode;

/* What a problem supplies besides for explicit steps (TSMOREAU), in which x and the other rows of a state w move in
   turn. Of A dw/dt = F_s + r the rows of x are g = f(t, w) - p(t, w), f what does not depend on x, p damping, less what
   each row's own x adds to it; f, p and g are reduced and in the units of r [Pa for the fault]. All are collective. */
typedef struct {
  /* f of a state; of what is computed for it the other operations, also those of SlipConstraintOps, may use the rest */
  PetscErrorCode (*drive)(SlipConstraint, PetscReal t, Vec w, Vec f, void *ctx);
  /* p; NULL: 0, all damping is a row's own */
  PetscErrorCode (*damping)(SlipConstraint, PetscReal t, Vec w, Vec p, void *ctx);
  /* x of w after a [s] of A dx/dt = g + r with g as it is and r in -q Sign(x), cell by cell, q and all other rows those
     of (t, w), a row's own damping included. *ok, of this process: no when a cell has no solution; left alone else */
  PetscErrorCode (*kick)(SlipConstraint, PetscReal t, PetscReal a, Vec g, Vec w, PetscBool *ok, void *ctx);
  /* the other rows of w from t to t + h, with x as it is: the first half of a step, from its start, and then the other,
     from inside of it */
  PetscErrorCode (*drift)(SlipConstraint, SlipNode from, PetscReal t, PetscReal h, Vec w, void *ctx);
  /* w is the state of a node of the step, p its damping: smooth and others may take it and what drive has computed for
     this state from there; NULL: they need not */
  PetscErrorCode (*settle)(SlipConstraint, SlipNode node, PetscReal t, Vec w, Vec p, void *ctx);
  /* at a state, the largest frequency [rad/s], 0: steps of any length are stable, and the largest damping ratio of p
     there, SlipLagLimit() */
  PetscErrorCode (*frequency)(SlipConstraint, PetscReal t, Vec w, PetscReal *omega, PetscReal *ratio, void *ctx);
  /* is p of the state exactly 0, which spares what rests a product? NULL: it may not be */
  PetscErrorCode (*undamped)(SlipConstraint, PetscReal t, Vec w, PetscBool *undamped, void *ctx);
  PetscBool by_default; /* under controllers that obey an error, TSBATHE takes explicit steps where they cost less */
} SlipExplicitOps;

/* What a problem supplies, for reduced vectors with one number a cell; SlipConstraintSetComponents() says what is
   different with two. "full" vectors have the layout of the TS solution w, "reduced" ones that of x. The reaction r
   is reduced [Pa for the fault]. F_s and explicit_part are full, in units of A dw/dt (fault: row v in Pa, rows u and
   s in m/s). All are collective. */
typedef struct {
  PetscErrorCode (*stage)(SlipConstraint, const SlipStage *, void *ctx); /* prepare B and c for this stage */
  PetscErrorCode (*residual)(SlipConstraint, Vec x, Vec g, void *ctx);   /* g = G(x), reduced */
  PetscErrorCode (*jacobian)(SlipConstraint, Vec x, Mat *B, void *ctx);  /* borrowed: B = dG/dx, symmetric */
  /* q_i >= 0 and dq_i/d|x_i| at the stage (through s_i(|x_i|) and the rate); q_i = 0 marks an unconstrained row; dq may
     be NULL */
  PetscErrorCode (*bound)(SlipConstraint, Vec x, Vec q, Vec dq, void *ctx);
  PetscErrorCode (*reduce)(SlipConstraint, Vec w, Vec x, void *ctx); /* x of a full state */
  PetscErrorCode (*lift)(SlipConstraint, Vec x, Vec w, void *ctx);   /* full state at the stage's end from its x */
  PetscErrorCode (*smooth)(SlipConstraint, PetscReal t, Vec w, Vec Fs, void *ctx); /* Fs = F_s(t, w), full */
  PetscErrorCode (*add_reaction)(SlipConstraint, PetscReal a, Vec r, Vec F,
                                 void *ctx);                             /* F += a r, spread into the full space */
  PetscErrorCode (*solve_mass)(SlipConstraint, Vec F, Vec k, void *ctx); /* k = A^-1 F, full (F == k allowed) */
  PetscErrorCode (*bound_state)(SlipConstraint, PetscReal t, Vec w, Vec q,
                                void *ctx);                    /* q(w) at an accepted state, reduced */
  PetscErrorCode (*at_rest)(SlipConstraint, Vec g, void *ctx); /* g = G(0), reduced; NULL: by residual */
  /* A bound that is 0 at x = 0 and smooth: then nothing sticks. Cell by cell D_i x_i + omega q_i(|x_i|) sign(x_i) = f_i
     from the guess in x; *unstable (of this process) when q falls faster than D x grows. With a coupling q depends on
     other rows as it did at the x that bound was asked about last. NULL: the reaction is set-valued */
  PetscErrorCode (*solve_cells)(SlipConstraint, PetscReal omega, Vec D, Vec f, Vec x, PetscBool *unstable, void *ctx);
  /* of such a bound: mask = 0 where solve_cells prescribes x, 1 elsewhere; NULL: nowhere */
  PetscErrorCode (*prescribed)(SlipConstraint, Vec mask, void *ctx);
  /* dq_i/d|x_i| as bound gives it, but at the stage's start, for SlipConstraintSetRefuseUnstable(); NULL: that at the
     end alone counts */
  PetscErrorCode (*start_slope)(SlipConstraint, Vec dq, void *ctx);
  /* What the bound of a row gains where x changes by dx, besides dq_i/d|x_i|: a_i (C dx)_i, at the x that bound was
     asked about last; C borrowed, a reduced. NULL: a bound depends on its own x only */
  PetscErrorCode (*coupling)(SlipConstraint, Mat *C, Vec a, void *ctx);
  const SlipExplicitOps *explicit_ops; /* borrowed; NULL: TSMOREAU cannot integrate it */
  PetscBool affine; /* dG/dx does not depend on x: solvers then know G after a step from their products with dG/dx */
} SlipConstraintOps;

PETSC_EXTERN PetscErrorCode SlipSNESInitializePackage(void); /* called by what creates objects; again does nothing */
PETSC_EXTERN PetscErrorCode SlipConstraintCreate(MPI_Comm comm, const SlipConstraintOps *ops, void *ctx,
                                                 Vec reduced_template, SlipConstraint *con);
PETSC_EXTERN PetscErrorCode SlipConstraintDestroy(SlipConstraint *con);
/* The reduced vectors have c numbers a cell, 1, 2 or 3, side by side: with 2 |r_i| <= q_i in the Euclidean norm, r_i =
   -q_i x_i / |x_i| where x_i != 0; with 3 the third opens the cell, x >= 0, its reaction r >= 0 and x r = 0, and q is
   over that r. cells: a vector with one number a cell, the layout of q; before the first solve. */
PETSC_EXTERN PetscErrorCode SlipConstraintSetComponents(SlipConstraint con, PetscInt c, Vec cells);
PETSC_EXTERN PetscErrorCode SlipConstraintGetComponents(SlipConstraint con, PetscInt *c);
PETSC_EXTERN PetscErrorCode SlipConstraintGetContext(SlipConstraint con, void *ctx);
PETSC_EXTERN PetscErrorCode SlipConstraintSetRefuseUnstable(SlipConstraint con, PetscBool refuse);
PETSC_EXTERN PetscErrorCode SlipConstraintWasUnstable(SlipConstraint con, PetscBool *unstable);
/* Reaction of the start: the projection of the static balance -F_s restricted to the reduced rows on the cone where x =
   0, -q sign(x) where x != 0. */
PETSC_EXTERN PetscErrorCode SlipConstraintInitialReaction(SlipConstraint con, PetscReal t, Vec w, Vec r);
PETSC_EXTERN PetscErrorCode SlipConstraintReactionOf(SlipConstraint con, PetscReal t, Vec w, Vec Fs, Vec r);

/* A small system A dw/dt = F_s(t, w) + F_r of n states, dense, on one process: F_r enters the rows listed, one reaction
   with |F_r| <= q each, and all is written with arrays. Units are the user's; A dw/dt, F_s and q share those of their
   row. */
typedef struct {
  PetscInt n;            /* states */
  const PetscReal *mass; /* diagonal of A, positive [n] */
  PetscInt nrows;
  const PetscInt *rows; /* where the reactions enter, ascending [nrows] */
  PetscErrorCode (*force)(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx);    /* F_s [n] */
  PetscErrorCode (*jacobian)(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx); /* J[i n + j] = dF_i/dw_j,
                                                                                             zero on entry */
  /* q >= 0 [nrows], and unless dq is NULL its derivative by |w_rows[k]| (zero on entry); q = 0: no reaction now */
  PetscErrorCode (*bound)(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx);
  void *ctx;
} SlipSmall;
PETSC_EXTERN PetscErrorCode SlipConstraintCreateSmall(const SlipSmall *problem, SlipConstraint *con);

/* SNES types that solve G(x) = omega r(x) through the natural map of the cone; both take the constraint below. On
   success sticking cells have x = 0 exactly and the reaction satisfies |r| <= q and r = -q sign(x) where x != 0. */
#define SNESSEMISMOOTH "semismooth"
#define SNESPROJECTION "projection"
PETSC_EXTERN PetscErrorCode SNESSetSlipConstraint(SNES snes, SlipConstraint con);
PETSC_EXTERN PetscErrorCode SNESGetSlipConstraint(SNES snes, SlipConstraint *con);
/* Solve one stage: x is the initial guess in, the solution out; r the reaction. resnorm is the dimensionless relative
   residual at the end. Sets the SNES converged reason as usual. */
PETSC_EXTERN PetscErrorCode SNESSlipSolveStage(SNES snes, const SlipStage *stage, Vec x, Vec r, PetscReal *resnorm);
/* Cell (global index) with the largest residual of the last solve and that residual, for error messages. */
PETSC_EXTERN PetscErrorCode SNESSlipGetWorstCell(SNES snes, PetscInt *cell, PetscReal *residual);

/* KSP type: conjugate gradients for that Jacobian that know B x of their solution x as well. */
#define KSPSLIPCG "slipcg"

/* The generalised Jacobian as a Mat: (J y)_i = [B (m.y)]_i m_i + d_i m_i y_i + (1 - m_i) y_i, m the 0/1 mask of sliding
   cells, d the slope of the bound (a block of two rows where cells have two components). Symmetric. The PC
   "slipstage" reads its parts. */
#define MATSLIPJACOBIAN "slipjacobian"
PETSC_EXTERN PetscErrorCode MatCreateSlipJacobian(Mat B, Mat *J);
PETSC_EXTERN PetscErrorCode MatSlipJacobianSetParts(Mat J, Mat B, Vec mask, Vec slope);
PETSC_EXTERN PetscErrorCode MatSlipJacobianGetParts(Mat J, Mat *B, Vec *mask, Vec *slope); /* borrowed */
