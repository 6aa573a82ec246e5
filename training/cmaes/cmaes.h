/* Covariance matrix adaptation evolution strategy: pure functions on arrays, no PETSc object.
   Hansen, N. (2016), The CMA Evolution Strategy: A Tutorial, arXiv:1604.00772, with its default parameters, active
   (negative) weights included. Minimises. */
#pragma once
#include "common/random.h"

typedef struct {
  PetscInt n;      /* dimension */
  PetscInt lambda; /* population */
  PetscInt mu;     /* parents */
  PetscInt64 generation;
  double sigma;       /* step length */
  double *mean;       /* [n] */
  double *ps;         /* [n] evolution path of sigma */
  double *pc;         /* [n] evolution path of C */
  double *C;          /* [n n] covariance */
  double *B;          /* [n n] row i: eigenvector i of C */
  double *D;          /* [n] roots of the eigenvalues */
  PetscBool diagonal; /* C stays diagonal and is learnt (n + 2)/3 times as fast: Ros and Hansen (2008), PPSN X */
  /* what follows from n and lambda */
  double *weight; /* [lambda] positive for parents, negative for the rest */
  double mueff, cc, cs, c1, cmu, damps, chi;
  PetscInt64 interval; /* generations between eigendecompositions */
  double *work;        /* [n (lambda + 2)] */
} CMAES;

/* lambda 0: 4 + floor(3 ln n). mean [n] is copied. */
PETSC_INTERN PetscErrorCode CMAESCreate(PetscInt n, PetscInt lambda, const double mean[], double sigma, CMAES *es);
/* Switch between a diagonal and a full C; what was learnt stays. */
PETSC_INTERN void CMAESSetDiagonal(CMAES *es, PetscBool diagonal);
PETSC_INTERN PetscErrorCode CMAESDestroy(CMAES *es);
/* Draw a population x [lambda][n]. The same random state gives the same population. */
PETSC_INTERN PetscErrorCode CMAESAsk(CMAES *es, Random *random, double x[]);
/* Learn from the values f [lambda] of a population; NaN counts as the worst. Equal values keep their order. */
PETSC_INTERN PetscErrorCode CMAESTell(CMAES *es, const double x[], const double f[]);
