/* What the two files of SNES "semismooth" share. */
#pragma once
#include <slipstep/private/slipsnes.h>

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
  PetscInt n_direct, n_krylov, n_picard, n_sweeps, n_exact, n_model; /* since creation, for -snes_view */
} SNES_Semismooth;

/* ss->A for the linear solves at the point evaluated last */
PETSC_INTERN PetscErrorCode SlipSemismoothOperator(SNES_Semismooth *, SlipConstraint);
/* ss->dx from x, the point evaluated last; ok is false when no linear solve worked */
PETSC_INTERN PetscErrorCode SlipSemismoothDirection(SNES, SlipConstraint, Vec x, PetscBool *ok);
/* Direction and search from x, the point evaluated last, the it-th of them, towards a residual of tolerance */
PETSC_INTERN PetscErrorCode SlipSemismoothStep(SNES, SlipConstraint, PetscInt it, PetscReal tolerance, Vec x,
                                               PetscBool *ok);
/* A few projection steps */
PETSC_INTERN PetscErrorCode SlipSemismoothSweep(SNES_Semismooth *, SlipConstraint, Vec x);
/* All remembered merits are that of the point evaluated last */
PETSC_INTERN void SlipSemismoothForget(SNES_Semismooth *, SlipConstraint);
