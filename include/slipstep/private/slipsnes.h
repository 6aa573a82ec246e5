/* The constraint object's inside, shared by the two cone solvers. */
#pragma once
#include <slipsnes.h>
#include <petsc/private/snesimpl.h>
#include <slipcompat.h>
#include <slipcore.h>

struct _p_SlipConstraint {
  PETSCHEADER(SlipConstraintOps);
  void *ctx;           /* the problem's */
  Vec x;               /* layout of the reduced unknowns, also work */
  PetscInt components; /* of x, a cell's; three: two in its plane and what opens it */
  Vec cells;           /* one number a cell, where x has more, also work; else NULL */
  PetscBool single;    /* cells cannot have more than one */
  Vec w;               /* full, work; on first use */

  PetscBool refuse; /* solves fail where the Jacobian on the sliding set is not positive definite (SlipDirectSolve()) */

  /* one stage */
  PetscBool unstable;           /* the last solve failed for that */
  PetscReal omega;              /* weight of the reaction */
  PetscReal share;              /* of the first residual that may be left, 0: what the SNES says */
  PetscReal target;             /* residual at which an inexact solve ends, 0: it is not inexact */
  PetscReal scale;              /* characteristic traction by which residuals are divided */
  Vec r;                        /* reaction of the last solve */
  PetscReal resnorm;            /* relative residual of the last solve */
  PetscInt worst;               /* global index of the cell with the largest residual of the last solve, or: */
#define SLIP_WORST_UNKNOWN (-2) /* not yet looked for, in F */
  const PetscInt *number; /* what users call the cell of each global index, borrowed from the problem; NULL: that */
  Mat B;                  /* dG/dx at the last iterate, borrowed from the problem */

  /* at the last point evaluated */
  Vec g, q, dq, F, mask, slope;
  Mat C;        /* of bounds that depend on other rows' x, borrowed; NULL: none does */
  Vec row, cx;  /* its factors in sliding rows: F_i gains row_i (C dx)_i, a cell's i; a product. With three components a
                  cell there is no C: its normal row of dG/dx is in its place */
  Vec friction; /* with three components a cell: q over the pressure, else NULL */
  Vec rho;      /* step of the natural map, 1 / diag(B), of the larger entry of a cell's */
  /* two components a cell, else NULL: directions n, what holds x along them (SlipDiskNatural()), and the entry of the
     slope beside its diagonal; spare: the same entry of other slopes */
  Vec normal, hold, cross, spare;
  PetscReal merit; /* 2-norm of F / scale */
  PetscReal norm;  /* max-norm of F / scale */

  PetscBool balanced; /* g is G of the x that the last solve has given out, which was set to zero nowhere after it */
};

/* A stage with A x + offset for G(x), the same cone; what takes a model solves the stage itself when that is NULL. */
typedef struct {
  Mat A;
  Vec offset;
} SlipStageModel;

PETSC_INTERN PetscErrorCode SlipConstraintGetOps(SlipConstraint, const SlipConstraintOps **);
PETSC_INTERN PetscErrorCode SlipConstraintCreateReduced(SlipConstraint, Vec *);
PETSC_INTERN PetscErrorCode SlipConstraintSetUpWork(SlipConstraint);
PETSC_INTERN PetscErrorCode SlipConstraintBegin(SlipConstraint, Vec x);    /* rho and scale of a stage */
PETSC_INTERN PetscErrorCode SlipConstraintJacobian(SlipConstraint, Vec x); /* B; once an iterate */
PETSC_INTERN PetscErrorCode SlipConstraintResidual(SlipConstraint, const SlipStageModel *, Vec x, Vec g);
/* g, q, dq, F, mask, slope, merit, norm */
PETSC_INTERN PetscErrorCode SlipConstraintEvaluate(SlipConstraint, const SlipStageModel *, Vec x);
/* Largest |v_i| of all cells, infinite where one is not a number */
PETSC_INTERN PetscErrorCode SlipConstraintNorm(SlipConstraint, Vec v, PetscReal *norm);
/* v, of cells, times the pressure at the point evaluated last, where cells open; else as it is */
PETSC_INTERN PetscErrorCode SlipConstraintPress(SlipConstraint, Vec x, Vec v);
/* Slope at the point evaluated last with dq (NULL: 0) in place of its own; cross NULL with one component */
PETSC_INTERN PetscErrorCode SlipConstraintSlope(SlipConstraint, Vec x, Vec dq, Vec slope, Vec *cross);
/* Of a step that takes x away, y = B x: y_i += row_i (C x)_i, nothing without a coupling */
PETSC_INTERN PetscErrorCode SlipConstraintAddCoupling(SlipConstraint, Vec x, Vec y);
/* The same where con->g is G(x) already */
PETSC_INTERN PetscErrorCode SlipConstraintEvaluateKnown(SlipConstraint, Vec x);
PETSC_INTERN PetscErrorCode SlipConstraintFinish(SlipConstraint, Vec x); /* reaction, worst cell */
PETSC_INTERN PetscErrorCode SlipConstraintQuery(SNES, SlipConstraint *); /* error when the SNES has none */
PETSC_INTERN PetscErrorCode SlipConstraintReport(SNES, SlipConstraint, PetscInt it, SNESConvergedReason *reason);

/* Entries of the slope beside its diagonal, one a cell, of the next parts; NULL: cells have one component */
PETSC_INTERN PetscErrorCode MatSlipJacobianSetCross(Mat J, Vec cross);
/* y += what they do to x on the sliding set */
PETSC_INTERN PetscErrorCode SlipAddCross(Vec cross, Vec mask, Vec x, Vec y);
/* y_i += row_i (C x)_i, the product in cx; with two components a cell the rows of both have its product */
PETSC_INTERN PetscErrorCode SlipAddCoupling(Mat C, Vec row, Vec x, Vec cx, Vec y);
/* The same with the normal rows of z = B x in the place of C x, less gain x there (NULL: 0) */
PETSC_INTERN PetscErrorCode SlipAddPressure(Vec row, Vec z, Vec x, Vec rho, Vec y);
PETSC_INTERN PetscErrorCode MatSlipJacobianGetProduct(Mat J, Vec *product);
/* The coupling of the bounds in a generalised Jacobian; C NULL and row: by the normal rows; both NULL: none */
PETSC_INTERN PetscErrorCode MatSlipJacobianSetCoupling(Mat J, Mat C, Vec row);

/* One self-adaptive projection step from x, evaluated; rho is kept between calls, x1 and g1 are work. */
PETSC_INTERN PetscErrorCode SlipProjectionStep(SlipConstraint, const SlipStageModel *, Vec x, Vec rho, Vec x1, Vec g1);

/* Dense solve on the sliding set: J_ss dx_s = rhs_s, cross as above, by Cholesky, with C and its factors row (NULL:
   none; row alone: the normal rows of B for C) or with a B that is known not to be symmetric by LU. done is false when
   the entries of B or C are not at hand; pd is false when the matrix is not positive definite, by LU when an eigenvalue
   of D^-1 J_ss, D the diagonal of B, has no positive real part (dx then untouched). */
PETSC_INTERN PetscErrorCode SlipDirectSolve(Mat B, Mat C, Vec row, Vec mask, Vec slope, Vec cross, Vec rhs, Vec dx,
                                            PetscInt max, PetscBool *done, PetscBool *pd);

/* What both types start with. */
typedef struct {
  Vec *work; /* reduced */
  PetscInt nwork;
} SNES_Slip;
PETSC_INTERN PetscErrorCode SNESCreate_Slip(SNES, SNES_Slip *, PetscInt nwork, PetscInt max_it);
PETSC_INTERN PetscErrorCode SNESReset_Slip(SNES);
PETSC_INTERN PetscErrorCode SNESCreate_Semismooth(SNES);
PETSC_INTERN PetscErrorCode SNESCreate_Projection(SNES);
PETSC_INTERN PetscErrorCode KSPCreate_SlipCG(KSP);

/* ---- semismooth.c, semismoothstep.c ---- */
enum {
  SEMISMOOTH_RHS,    /* right side of the linear solve */
  SEMISMOOTH_DX,     /* step */
  SEMISMOOTH_XS,     /* its start */
  SEMISMOOTH_RHO,    /* of the projection steps */
  SEMISMOOTH_ZERO,   /* no slope of the bound */
  SEMISMOOTH_OFFSET, /* of the model */
  SEMISMOOTH_LOAD,   /* of the cells, of a smooth bound */
  SEMISMOOTH_GS,     /* G at the step's start */
  SEMISMOOTH_BDX,    /* what the step adds to it, and */
  SEMISMOOTH_BXT,    /* of that what sticking cells do, where G is affine */
  SEMISMOOTH_NWORK
};

typedef struct {
  SNES_Slip slip;
  Mat J;
  PetscInt direct_max; /* largest sliding set that is solved directly */
  SlipSearch search;
  PetscBool rtol_set, ksp_set; /* the user has chosen -snes_rtol, -ksp_rtol */
  PetscInt n_direct, n_krylov, n_picard, n_projections, n_exact, n_model; /* since creation, for -snes_view */
} SNES_Semismooth;

/* The step from x, the point evaluated last, with A for dG/dx; picard when it left out the slope, ok is false when no
   linear solve worked */
PETSC_INTERN PetscErrorCode SlipSemismoothDirection(SNES, SlipConstraint, Mat A, Vec x, PetscBool *picard,
                                                    PetscBool *ok);
/* Direction and search from x, the point evaluated last, the it-th of them, towards a residual of tolerance */
PETSC_INTERN PetscErrorCode SlipSemismoothStep(SNES, SlipConstraint, const SlipStageModel *, PetscInt it,
                                               PetscReal tolerance, Vec x, PetscBool *ok);
/* con->B, or its approximation */
PETSC_INTERN PetscErrorCode SlipSemismoothOperator(SlipConstraint, PetscBool exact, Mat *A);
/* Krylov solve with A and the slope for SEMISMOOTH_DX; pd is false when the matrix shows itself indefinite, where
   bounds are coupled an eigenvalue without a positive real part */
PETSC_INTERN PetscErrorCode SlipSemismoothKrylov(SNES, SlipConstraint, Mat A, Vec slope, Vec cross, PetscBool *ok,
                                                 PetscBool *pd);
/* smoothbound.c: the whole solve where the bound is smooth */
PETSC_INTERN PetscErrorCode SlipSmoothBoundSolve(SNES, SlipConstraint, Vec x);
/* x = xs + lambda dx, evaluated; SlipSemismoothFrom() has made x, the point evaluated last, xs */
PETSC_INTERN PetscErrorCode SlipSemismoothFrom(SNES, SlipConstraint, Vec x);
PETSC_INTERN PetscErrorCode SlipSemismoothMoveTo(SNES, SlipConstraint, const SlipStageModel *, PetscReal lambda, Vec x);
/* A few projection steps */
PETSC_INTERN PetscErrorCode SlipSemismoothProject(SNES, SlipConstraint, const SlipStageModel *, Vec x);
