/* Set-valued reactions in an implicit stage: the constraint object and the two cone solvers (SNES types). */
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
  PetscReal t;         /* time of the stage's end [s] */
  PetscReal theta;     /* [s] */
  PetscReal omega;     /* weight of the reaction, 1 or 2 */
  Vec base;            /* full space */
  Vec explicit_part;   /* full space, or NULL */
  Vec from[2];         /* states whose sum, with these factors, is base, and their number, 0: unknown. A problem */
  PetscReal factor[2]; /* that has cached products with them can combine those. explicit_part is that of from[0]. */
  PetscInt nfrom;
  PetscReal share; /* allowed residual relative to that of the guess, in (0, 1); 0: -snes_rtol decides */
} SlipStage;

/* A set-valued reaction for the cone solvers, TSBATHE and TSMOREAU; it is a PETSc object. */
typedef struct _p_SlipConstraint *SlipConstraint;
PETSC_EXTERN PetscClassId SLIP_CONSTRAINT_CLASSID;

/* Position of a state in an explicit step */
typedef enum { SLIP_NODE_START, SLIP_NODE_INSIDE, SLIP_NODE_END, SLIP_NUM_NODES } SlipNode;

/* What a problem supplies besides for explicit steps (TSMOREAU), which move x and the other rows of a state w in turn.
   The rows of x in A dw/dt = F_s + r are g = f(t, w) - p(t, w): f does not depend on x; p is damping without that by a
   row's own x. f, p and g are reduced, in the units of r [Pa for the fault]. All are collective. */
typedef struct {
  /* Computes f of a state. The other operations, also those of SlipConstraintOps, may use what was computed for it. */
  PetscErrorCode (*drive)(SlipConstraint, PetscReal t, Vec w, Vec f, void *ctx);
  /* Computes p; NULL: 0, because damping couples no rows. */
  PetscErrorCode (*damping)(SlipConstraint, PetscReal t, Vec w, Vec p, void *ctx);
  /* Computes x of w after a [s] of A dx/dt = g + r with constant g and r in -q Sign(x), cell by cell; q and all other
     rows are those of (t, w), and a row's own damping is included. Sets *ok (of this process) to false if a cell has no
     solution, and leaves it alone otherwise. */
  PetscErrorCode (*kick)(SlipConstraint, PetscReal t, PetscReal a, Vec g, Vec w, PetscBool *ok, void *ctx);
  /* Moves the other rows of w from t to t + h with constant x: first the first half of a step, from its start, then the
     other half, from inside. */
  PetscErrorCode (*drift)(SlipConstraint, SlipNode from, PetscReal t, PetscReal h, Vec w, void *ctx);
  /* States that w is a node of the step and p its damping, so that smooth() and others can reuse what drive() has
     computed for this state; NULL: there is nothing to reuse. */
  PetscErrorCode (*settle)(SlipConstraint, SlipNode node, PetscReal t, Vec w, Vec p, void *ctx);
  /* Computes, at a state, the largest frequency [rad/s], 0 if steps of any length are stable, and the largest damping
     ratio of p, for SlipLagLimit(). */
  PetscErrorCode (*frequency)(SlipConstraint, PetscReal t, Vec w, PetscReal *omega, PetscReal *ratio, void *ctx);
  /* True if p of the state is exactly 0, which saves a product for cells at rest; NULL: it may not be */
  PetscErrorCode (*undamped)(SlipConstraint, PetscReal t, Vec w, PetscBool *undamped, void *ctx);
  PetscBool by_default; /* if the controller bounds an error, TSBATHE takes explicit steps where they cost less */
} SlipExplicitOps;

/* What a problem supplies, here for reduced vectors with one number per cell; SlipConstraintSetComponents() describes
   more. "Full" vectors have the layout of the TS solution w, "reduced" ones that of x, as the reaction r [Pa for the
   fault]. F_s and explicit_part are full, in units of A dw/dt (fault: row v in Pa, rows u and s in m/s). All are
   collective. */
typedef struct {
  PetscErrorCode (*stage)(SlipConstraint, const SlipStage *, void *ctx); /* prepares B and c for this stage */
  PetscErrorCode (*residual)(SlipConstraint, Vec x, Vec g, void *ctx);   /* g = G(x), reduced */
  PetscErrorCode (*jacobian)(SlipConstraint, Vec x, Mat *B, void *ctx);  /* borrowed: B = dG/dx, symmetric */
  /* q_i >= 0 and dq_i/d|x_i| at the stage (through s_i(|x_i|) and the rate); rows with q_i = 0 are free; dq may be
     NULL */
  PetscErrorCode (*bound)(SlipConstraint, Vec x, Vec q, Vec dq, void *ctx);
  PetscErrorCode (*reduce)(SlipConstraint, Vec w, Vec x, void *ctx); /* x of the full state w */
  PetscErrorCode (*lift)(SlipConstraint, Vec x, Vec w, void *ctx);   /* full state at the stage's end from x */
  PetscErrorCode (*smooth)(SlipConstraint, PetscReal t, Vec w, Vec Fs, void *ctx); /* Fs = F_s(t, w), full */
  PetscErrorCode (*add_reaction)(SlipConstraint, PetscReal a, Vec r, Vec F,
                                 void *ctx);                             /* F += a r, added to the rows of the full
                                                                            vector that r acts on */
  PetscErrorCode (*solve_mass)(SlipConstraint, Vec F, Vec k, void *ctx); /* k = A^-1 F, full (F == k allowed) */
  PetscErrorCode (*bound_state)(SlipConstraint, PetscReal t, Vec w, Vec q,
                                void *ctx);                    /* q(w) at an accepted state, reduced */
  PetscErrorCode (*at_rest)(SlipConstraint, Vec g, void *ctx); /* g = G(0), reduced; NULL: by residual() */
  /* For a bound that is smooth and 0 at x = 0, so that nothing sticks: solves D_i x_i + omega q_i(|x_i|) sign(x_i) =
     f_i cell by cell from the guess in x, and sets *unstable (of this process) if q falls faster than D x grows. With a
     coupling, q takes other rows from the last x that bound() got. NULL: the reaction is set-valued */
  PetscErrorCode (*solve_cells)(SlipConstraint, PetscReal omega, Vec D, Vec f, Vec x, PetscBool *unstable, void *ctx);
  /* For such a bound: mask = 0 where solve_cells() prescribes x, 1 elsewhere; NULL: 1 everywhere */
  PetscErrorCode (*prescribed)(SlipConstraint, Vec mask, void *ctx);
  /* dq_i/d|x_i| like that of bound(), but at the start of the stage, for SlipConstraintSetRefuseUnstable(); NULL: only
     that at the end is used */
  PetscErrorCode (*start_slope)(SlipConstraint, Vec dq, void *ctx);
  /* By how much the bound of a row grows if x changes by dx, in addition to dq_i/d|x_i|: a_i (C dx)_i, at the last x
     that bound() got; C is borrowed, a reduced. NULL: each bound depends only on its own x */
  PetscErrorCode (*coupling)(SlipConstraint, Mat *C, Vec a, void *ctx);
  const SlipExplicitOps *explicit_ops; /* borrowed; NULL: TSMOREAU cannot integrate the problem */
  PetscBool affine; /* dG/dx is constant: solvers then compute G after a step from their products with dG/dx */
} SlipConstraintOps;

PETSC_EXTERN PetscErrorCode SlipConstraintCreate(MPI_Comm comm, const SlipConstraintOps *ops, void *ctx,
                                                 Vec reduced_template, SlipConstraint *con);
PETSC_EXTERN PetscErrorCode SlipConstraintDestroy(SlipConstraint *con);
/* Reduced vectors have c numbers per cell side by side. With 2, |r_i| <= q_i in the Euclidean norm and r_i = -q_i x_i /
   |x_i| where x_i != 0. With 3, the third is the opening x >= 0 with the reaction r >= 0 and x r = 0, and q is a bound
   in addition to that r. cells: a vector with one number per cell, as q. To be called before the first solve. */
PETSC_EXTERN PetscErrorCode SlipConstraintSetComponents(SlipConstraint con, PetscInt c, Vec cells);
PETSC_EXTERN PetscErrorCode SlipConstraintGetContext(SlipConstraint con, void *ctx);
PETSC_EXTERN PetscErrorCode SlipConstraintSetRefuseUnstable(SlipConstraint con, PetscBool refuse);
PETSC_EXTERN PetscErrorCode SlipConstraintWasUnstable(SlipConstraint con, PetscBool *unstable);
/* Reaction at the start: -q sign(x) where x != 0; where x = 0, the projection on the cone of the static balance -F_s
   restricted to the reduced rows. */
PETSC_EXTERN PetscErrorCode SlipConstraintInitialReaction(SlipConstraint con, PetscReal t, Vec w, Vec r);

/* A small dense system A dw/dt = F_s(t, w) + F_r of n states on one process: F_r acts on the listed rows, with one
   reaction |F_r| <= q each. All data are arrays. The user chooses the units, which A dw/dt, F_s and q of a row
   share. */
typedef struct {
  PetscInt n;            /* states */
  const PetscReal *mass; /* diagonal of A, positive [n] */
  PetscInt nrows;
  const PetscInt *rows; /* rows on which reactions act, ascending [nrows] */
  PetscErrorCode (*force)(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx);    /* F_s [n] */
  PetscErrorCode (*jacobian)(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx); /* J[i n + j] = dF_i/dw_j,
                                                                                             zero on entry */
  /* q >= 0 [nrows], and unless dq is NULL its derivative by |w_rows[k]| (zero on entry); q = 0: there is no reaction */
  PetscErrorCode (*bound)(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx);
  void *ctx;
} SlipSmall;
PETSC_EXTERN PetscErrorCode SlipConstraintCreateSmall(const SlipSmall *problem, SlipConstraint *con);

/* SNES types that solve G(x) = omega r(x) by the natural map of the cone; both need the constraint below. On success,
   sticking cells have exactly x = 0, |r| <= q, and r = -q sign(x) where x != 0. */
#define SNESSEMISMOOTH "semismooth"
#define SNESPROJECTION "projection"
PETSC_EXTERN PetscErrorCode SNESSetSlipConstraint(SNES snes, SlipConstraint con);
PETSC_EXTERN PetscErrorCode SNESGetSlipConstraint(SNES snes, SlipConstraint *con);
/* Solves one stage: x is the initial guess on entry and the solution on return; r is the reaction, resnorm the
   dimensionless relative residual at the end. The SNES gets a converged reason as usual. */
PETSC_EXTERN PetscErrorCode SNESSlipSolveStage(SNES snes, const SlipStage *stage, Vec x, Vec r, PetscReal *resnorm);
/* The cell (global index) with the largest residual of the last solve, and that residual, for error messages */
PETSC_EXTERN PetscErrorCode SNESSlipGetWorstCell(SNES snes, PetscInt *cell, PetscReal *residual);

/* KSP type: conjugate gradients for that Jacobian, which also compute B x of their solution x */
#define KSPSLIPCG "slipcg"

/* The generalised Jacobian as a Mat: (J y)_i = [B (m.y)]_i m_i + d_i m_i y_i + (1 - m_i) y_i, with the 0/1 mask m of
   sliding cells and the slope d of the bound (a block of two rows if cells have two components). It is symmetric. The
   PC "slipstage" reads its parts. */
#define MATSLIPJACOBIAN "slipjacobian"
