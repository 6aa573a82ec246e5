/* Private to src/mat/stage.c and stageproducts.c: the data of the shell matrix "slipstage" and its products. */
#pragma once
#include <slipmat.h>
#include <slipcells.h>
#include <slipstep/private/slipcompat.h>
#include <slipstep/private/slipmat.h>

typedef struct {
  Mat K, H;                  /* stiffness and viscosity, referenced */
  PetscReal mass;            /* [kg/m^2] */
  Vec weights;               /* of the rows of K and H, borrowed from K; NULL when all are 1 */
  PetscReal theta;           /* [s] */
  PetscBool assemble;        /* both operands are dense and small enough for B to be formed at each theta */
  Mat assembled;             /* B as MATDENSE, or NULL */
  PetscReal assembled_theta; /* theta of assembled or of blocks */
  SlipStrike strike;         /* both operands are per wavenumber: one pair of FFTs serves both; NULL otherwise */
  PetscReal *blocks;         /* [nk][nz][nz] spectral part of B */
  PetscReal damping;         /* H = damping * sqrt(K) as far as known, else 0 */
  PetscReal scale;           /* of K against the kernel */
  SlipGather gather;
  PetscReal *y; /* [N] */
  Vec work;
  SlipPlane plane;     /* borrowed from K, NULL unless one pair of transforms serves K and H of type "sliptoeplitz" */
  SlipPlaneSymbol sum; /* of B at assembled_theta */
  PetscReal mean;      /* B = mean ((mass / theta) I + theta K), H is NULL; 0 when H is used */
  Mat approximation;   /* NULL when Jacobians are to be exact */
  SlipCorrection correction; /* of an approximation without a grid; else NULL */
} SlipStageContext;

PETSC_INTERN PetscErrorCode SlipStageMult(Mat B, Vec x, Vec y);
PETSC_INTERN PetscErrorCode SlipStageGetDiagonal(Mat B, Vec d);
