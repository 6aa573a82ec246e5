/* Internal header of the constraint object, for the two cone solvers */
#pragma once
#include <slipstep/rooms/slipsnes.h>
#include <petsc/private/snesimpl.h>
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>

struct _p_SlipConstraint {
  PETSCHEADER(SlipConstraintOps);
  void *ctx;           /* the problem's */
  Vec x;               /* layout of the reduced unknowns, also work */
  PetscInt components; /* of x per cell; three: two in its plane, and the opening */
  Vec cells;           /* one number per cell, if x has more, also work; else NULL */
  PetscBool single;    /* cells cannot have more than one component */
  Vec w;               /* full, work; created on first use */

  PetscBool refuse; /* solves fail where the Jacobian on the sliding set is not positive definite (SlipDirectSolve()) */

  /* one stage */
  PetscBool unstable;           /* the last solve failed for that reason */
  PetscReal omega;              /* weight of the reaction */
  PetscReal share;              /* allowed residual over the first one, 0: the SNES decides */
  PetscReal target;             /* residual at which an inexact solve ends, 0: it is exact */
  PetscReal scale;              /* characteristic traction, the unit of residuals */
  Vec r;                        /* reaction of the last solve */
  PetscReal resnorm;            /* relative residual of the last solve */
  PetscInt worst;               /* global index of the cell with the largest residual of the last solve, or: */
#define SLIP_WORST_UNKNOWN (-2) /* not searched yet, in F */
  const PetscInt *number;       /* the user's number of each cell (global index), borrowed; NULL: equal */
  Mat B;                        /* dG/dx at the last iterate, borrowed from the problem */

  /* at the last point evaluated */
  Vec g, q, dq, F, mask, slope;
  Mat C;        /* of bounds that depend on other rows' x, borrowed; NULL: none */
  Vec row, cx;  /* its factors in sliding rows: F_i gains row_i (C dx)_i for cell i; a product. With three components
                   per cell the normal row of dG/dx replaces C */
  Vec friction; /* with three components per cell: q over the pressure, else NULL */
  Vec rho;      /* step of the natural map, 1 / diag(B), with the larger entry of a cell */
  /* two components per cell, else NULL: directions n, factors that hold x along them (SlipDiskNatural()), and the
     off-diagonal entry of the slope; spare: the same entry of other slopes */
  Vec normal, hold, cross, spare;
  PetscReal merit; /* 2-norm of F / scale */
  PetscReal norm;  /* max-norm of F / scale */

  PetscBool balanced; /* g is G of the last solution, no entry of which was set to zero afterwards */
};

/* A stage with A x + offset instead of G(x) and the same cone; functions that get NULL for it solve the stage
   itself. */
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
/* Computes the largest |v_i| of all cells, infinite if one is not a number. */
PETSC_INTERN PetscErrorCode SlipConstraintNorm(SlipConstraint, Vec v, PetscReal *norm);
/* Multiplies v, of cells, by the pressure at the last evaluated point if cells open. */
PETSC_INTERN PetscErrorCode SlipConstraintPress(SlipConstraint, Vec x, Vec v);
/* Computes the slope at the last evaluated point with dq (NULL: 0); cross is NULL with one component. */
PETSC_INTERN PetscErrorCode SlipConstraintSlope(SlipConstraint, Vec x, Vec dq, Vec slope, Vec *cross);
/* For a step that subtracts x, y = B x: y_i += row_i (C x)_i, nothing without a coupling */
PETSC_INTERN PetscErrorCode SlipConstraintAddCoupling(SlipConstraint, Vec x, Vec y);
/* The same if con->g is G(x) already */
PETSC_INTERN PetscErrorCode SlipConstraintEvaluateKnown(SlipConstraint, Vec x);
PETSC_INTERN PetscErrorCode SlipConstraintFinish(SlipConstraint, Vec x); /* reaction, worst cell */
PETSC_INTERN PetscErrorCode SlipConstraintQuery(SNES, SlipConstraint *); /* raises an error if the SNES has none */
PETSC_INTERN PetscErrorCode SlipConstraintReport(SNES, SlipConstraint, PetscInt it, SNESConvergedReason *reason);

/* Sets the off-diagonal entries of the slope, one per cell, for the next parts; NULL: cells have one component. */
PETSC_INTERN PetscErrorCode MatSlipJacobianSetCross(Mat J, Vec cross);
/* y += product of these entries with x on the sliding set */
PETSC_INTERN PetscErrorCode SlipAddCross(Vec cross, Vec mask, Vec x, Vec y);
/* y_i += row_i (C x)_i with the product in cx; with two components the two rows of a cell share it */
PETSC_INTERN PetscErrorCode SlipAddCoupling(Mat C, Vec row, Vec x, Vec cx, Vec y);
/* The same with the normal rows of z = B x instead of C x, minus gain x there (NULL: 0) */
PETSC_INTERN PetscErrorCode SlipAddPressure(Vec row, Vec z, Vec x, Vec rho, Vec y);
PETSC_INTERN PetscErrorCode MatSlipJacobianGetProduct(Mat J, Vec *product);
/* Sets the coupling of the bounds in a generalised Jacobian; C NULL and row: by the normal rows; both NULL: none. */
PETSC_INTERN PetscErrorCode MatSlipJacobianSetCoupling(Mat J, Mat C, Vec row);

/* Does one self-adaptive projection step from the evaluated point x; rho is updated, x1 and g1 are work. */
PETSC_INTERN PetscErrorCode SlipProjectionStep(SlipConstraint, const SlipStageModel *, Vec x, Vec rho, Vec x1, Vec g1);

/* Solves the dense system on the sliding set: J_ss dx_s = rhs_s, with cross as above, by Cholesky, or by LU with C and
   its factors row (NULL: none; row alone: the normal rows of B instead of C) or with a B that is known to be
   unsymmetric. done is false if the entries of B or C are not available; pd is false, and dx unchanged, if the matrix
   is not positive definite, with LU if an eigenvalue of D^-1 J_ss, D the diagonal of B, has no positive real part. */
PETSC_INTERN PetscErrorCode SlipDirectSolve(Mat B, Mat C, Vec row, Vec mask, Vec slope, Vec cross, Vec rhs, Vec dx,
                                            PetscInt max, PetscBool *done, PetscBool *pd);

/* The beginning of the context of both types */
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
  SEMISMOOTH_XS,     /* start of the step */
  SEMISMOOTH_RHO,    /* of the projection steps */
  SEMISMOOTH_ZERO,   /* zero slope of the bound */
  SEMISMOOTH_OFFSET, /* of the model */
  SEMISMOOTH_LOAD,   /* of the cells, of a smooth bound */
  SEMISMOOTH_GS,     /* G at the step's start */
  SEMISMOOTH_BDX,    /* its change by the step, and */
  SEMISMOOTH_BXT,    /* the part of that by sticking cells, if G is affine */
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

/* Computes the step from x, the last evaluated point, with A for dG/dx; picard: it omitted the slope; ok is false if no
   linear solve succeeded. */
PETSC_INTERN PetscErrorCode SlipSemismoothDirection(SNES, SlipConstraint, Mat A, Vec x, PetscBool *picard,
                                                    PetscBool *ok);
/* Computes the it-th direction and searches along it from x, the last evaluated point, for a residual below
   tolerance. */
PETSC_INTERN PetscErrorCode SlipSemismoothStep(SNES, SlipConstraint, const SlipStageModel *, PetscInt it,
                                               PetscReal tolerance, Vec x, PetscBool *ok);
/* Gets con->B, or its approximation. */
PETSC_INTERN PetscErrorCode SlipSemismoothOperator(SlipConstraint, PetscBool exact, Mat *A);
/* Krylov solve with A and the slope for SEMISMOOTH_DX; pd is false if the matrix turns out to be indefinite or, with
   coupled bounds, has an eigenvalue without a positive real part */
PETSC_INTERN PetscErrorCode SlipSemismoothKrylov(SNES, SlipConstraint, Mat A, Vec slope, Vec cross, PetscBool *ok,
                                                 PetscBool *pd);
/* smoothbound.c: the whole solve if the bound is smooth */
PETSC_INTERN PetscErrorCode SlipSmoothBoundSolve(SNES, SlipConstraint, Vec x);
/* Evaluates x = xs + lambda dx; SlipSemismoothFrom() has set xs to x, the last evaluated point. */
PETSC_INTERN PetscErrorCode SlipSemismoothFrom(SNES, SlipConstraint, Vec x);
PETSC_INTERN PetscErrorCode SlipSemismoothMoveTo(SNES, SlipConstraint, const SlipStageModel *, PetscReal lambda, Vec x);
/* Does a few projection steps. */
PETSC_INTERN PetscErrorCode SlipSemismoothProject(SNES, SlipConstraint, const SlipStageModel *, Vec x);
