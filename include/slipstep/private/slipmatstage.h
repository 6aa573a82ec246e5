/* Internal header of src/mat: the stage operator, its cheap approximation and its preconditioner */
#pragma once
#include <slipstep/private/slipmatviscosity.h>

/* ---- stageoperator.c: the parts of the stage operator ---- */
typedef struct {
  Mat K, H;            /* borrowed */
  PetscReal mass;      /* [kg/m^2] */
  PetscReal theta;     /* [s] */
  PetscReal scale;     /* of K relative to the kernel of its grid; 0 without a grid */
  PetscReal damping;   /* H = damping * sqrt(K); 0 if unknown */
  PetscReal radiation; /* H = radiation * I; 0 if it is not */
} SlipStageParts;
PETSC_INTERN PetscErrorCode SlipStageGetParts(Mat B, SlipStageParts *parts);

/* ---- secant.c: corrects a cheap stage operator on directions with cached exact products ---- */
typedef struct _n_SlipSecant *SlipSecant;
PETSC_INTERN PetscErrorCode SlipSecantCreate(Mat K, Mat R, PetscReal mass, PetscReal mean, SlipSecant *c);
PETSC_INTERN PetscErrorCode SlipSecantDestroy(SlipSecant *c);
PETSC_INTERN PetscErrorCode SlipSecantUpdate(SlipSecant c, const SlipRecycled *known, PetscReal theta,
                                             PetscBool *changed);
PETSC_INTERN PetscErrorCode SlipSecantAdd(SlipSecant c, Vec x, Vec y);
PETSC_INTERN PetscReal SlipSecantVectors(SlipSecant c);
PETSC_INTERN PetscErrorCode SlipSecantState(SlipSecant c, const SlipRecycled *known, SlipState s); /* for checkpoints */

/* ---- pcslipstage.c ---- */
PETSC_INTERN PetscErrorCode PCCreate_SlipStage(PC pc);

typedef struct {
  Mat K, H;           /* stiffness, referenced, and viscosity as applied now */
  Mat given;          /* viscosity, referenced: H, or the operator whose factorised root is H */
  PetscReal mass;     /* [kg/m^2] */
  Vec weights;        /* of the rows of K and H, borrowed from K; NULL when all are 1 */
  PetscReal theta;    /* [s] */
  PetscBool assemble; /* both operands are dense, and small enough to form B at each theta */
  Mat assembled;      /* B as MATDENSE, or NULL */
  Mat entries;        /* K as MATDENSE, for StageGetEntries(), on first use */
  Vec diagonal;       /* (mass / theta + radiation) times the weights, at this theta */
  PetscReal diagonal_theta;
  PetscReal assembled_theta; /* theta of assembled or of blocks */
  SlipCirculant strike;      /* both operands are per wavenumber: one pair of FFTs serves both; else NULL */
  PetscReal *blocks;         /* [nk][nz][nz] spectral part of B */
  PetscBool counts;          /* H is counted, unlike that of an approximation */
  PetscReal damping;         /* H = damping * sqrt(K) if known, else 0 */
  PetscReal radiation;       /* H = radiation times the weights, else 0 */
  PetscReal scale;           /* of K relative to the kernel */
  SlipGather gather;
  PetscReal *y; /* [N] */
  Vec work;
  Vec parts[2];       /* diagonals of K and H on a device, on first use */
  SlipToeplitz plane; /* borrowed from K, NULL unless one pair of transforms serves K and H of type "sliptoeplitz" */
  SlipToeplitzSymbol sum; /* of B; its factors, on the processor and on a device: */
  PetscReal sum_here[3], sum_there[3];
  PetscReal mean;        /* B = mean ((mass / theta) I + theta K), H is NULL; 0 if H is used */
  PetscInt jacobian;     /* row of the choices of MatSlipStageSetJacobian() */
  Mat approximation;     /* NULL if Jacobians are exact */
  SlipSecant correction; /* of an approximation, if H caches products; else NULL */
} SlipStageContext;

PETSC_INTERN PetscErrorCode SlipStageMult(Mat B, Vec x, Vec y);
PETSC_INTERN PetscErrorCode SlipStageGetDiagonal(Mat B, Vec d);
