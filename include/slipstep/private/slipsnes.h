/* The constraint object's inside, shared by the two cone solvers. */
#pragma once
#include <slipsnes.h>
#include <petsc/private/snesimpl.h>
#include <slipcompat.h>

struct _p_SlipConstraint {
  PETSCHEADER(SlipConstraintOps);
  void *ctx; /* the problem's */
  Vec x;     /* layout of the reduced unknowns, also work */

  /* one stage */
  PetscReal omega;        /* weight of the reaction */
  PetscReal scale;        /* characteristic traction by which residuals are divided */
  Vec r;                  /* reaction of the last solve */
  PetscReal resnorm;      /* relative residual of the last solve */
  PetscInt worst;         /* global index of the cell with the largest residual of the last solve */
  const PetscInt *number; /* what users call the cell of each global index, borrowed from the problem; NULL: that */
  Mat B;                  /* dG/dx at the last point, borrowed from the problem */
  Mat model;              /* when set, points are evaluated with G(x) = model x + offset; both borrowed */
  Vec offset;

  /* at the last point evaluated */
  Vec g, q, dq, F, mask, slope;
  Vec rho;         /* step of the natural map, 1 / diag(B) */
  PetscReal merit; /* 2-norm of F / scale */
  PetscReal norm;  /* max-norm of F / scale */
};

PETSC_INTERN PetscErrorCode SlipConstraintGetOps(SlipConstraint, const SlipConstraintOps **);
PETSC_INTERN PetscErrorCode SlipConstraintCreateReduced(SlipConstraint, Vec *);
PETSC_INTERN PetscErrorCode SlipConstraintSetUpWork(SlipConstraint);
PETSC_INTERN PetscErrorCode SlipConstraintBegin(SlipConstraint, Vec x); /* rho and scale of a stage */
PETSC_INTERN PetscErrorCode SlipConstraintResidual(SlipConstraint, Vec x, Vec g);
PETSC_INTERN PetscErrorCode SlipConstraintEvaluate(SlipConstraint, Vec x); /* g, q, dq, F, mask, slope, merit, norm */
PETSC_INTERN PetscErrorCode SlipConstraintFinish(SlipConstraint, Vec x);   /* reaction, worst cell */
PETSC_INTERN PetscErrorCode SlipConstraintQuery(SNES, SlipConstraint *);   /* error when the SNES has none */
PETSC_INTERN PetscErrorCode SlipConstraintReport(SNES, SlipConstraint, PetscInt it, SNESConvergedReason *reason);

/* A few self-adaptive projection steps from x; rho is kept between calls, x1 and g1 are work. */
PETSC_INTERN PetscErrorCode SlipProjectionStep(SlipConstraint, Vec x, Vec rho, Vec x1, Vec g1);

/* Dense Cholesky solve on the sliding set: J_ss dx_s = rhs_s. done is false when B's entries are not at hand, pd is
   false when the matrix is not positive definite (dx then untouched). */
PETSC_INTERN PetscErrorCode SlipDirectSolve(Mat B, Vec mask, Vec slope, Vec rhs, Vec dx, PetscInt max, PetscBool *done,
                                            PetscBool *pd);

PETSC_INTERN PetscErrorCode SNESCreate_Semismooth(SNES);
PETSC_INTERN PetscErrorCode SNESCreate_Projection(SNES);

/* ---- semismooth.c, semismoothstep.c ---- */
#define SLIP_SEMISMOOTH_ROUNDING 1e-15 /* relative residual that summation errors leave */
#define SLIP_SEMISMOOTH_MEMORY 5       /* merits that a new one is compared with */

typedef struct {
  Mat J;
  Mat A;                                    /* what stands for dG/dx in it: con->B, or its approximation; borrowed */
  PetscBool exact;                          /* approximations have failed in this solve */
  PetscInt slow;                            /* iterations in a row with an approximation that hardly converged */
  Vec rhs, dx, xs, zero, rho;               /* right side, step, start of the step, no slope, rho of the projection */
  Vec offset;                               /* of the model's residual */
  PetscInt direct_max;                      /* largest sliding set that is solved directly */
  PetscBool picard;                         /* the last step left out the slope */
  PetscReal recent[SLIP_SEMISMOOTH_MEMORY]; /* merits */
  PetscInt stalls;                          /* steps in a row without enough decrease */
  PetscInt n_direct, n_krylov, n_picard, n_projections, n_exact, n_model; /* since creation, for -snes_view */
} SNES_Semismooth;

/* ss->A for the linear solves at the point evaluated last */
PETSC_INTERN PetscErrorCode SlipSemismoothOperator(SNES_Semismooth *, SlipConstraint);
/* ss->dx from x, the point evaluated last; ok is false when no linear solve worked */
PETSC_INTERN PetscErrorCode SlipSemismoothDirection(SNES, SlipConstraint, Vec x, PetscBool *ok);
/* Direction and search from x, the point evaluated last, the it-th of them, towards a residual of tolerance */
PETSC_INTERN PetscErrorCode SlipSemismoothStep(SNES, SlipConstraint, PetscInt it, PetscReal tolerance, Vec x,
                                               PetscBool *ok);
/* A few projection steps */
PETSC_INTERN PetscErrorCode SlipSemismoothProject(SNES_Semismooth *, SlipConstraint, Vec x);
/* All remembered merits are that of the point evaluated last */
PETSC_INTERN void SlipSemismoothForget(SNES_Semismooth *, SlipConstraint);
