/* Errors of a run of a small system against its exact solution. */
#pragma once
#include "problem.h"

#define SMALL_MAX_STATES 3

/* The exact solution, linear between its times. */
struct _EnvReference {
  PetscReal dt;
  PetscInt n, states;
  PetscReal *state; /* [n][states] */
};

typedef struct {
  EnvReference reference;
  PetscReal seen, error2, size2;    /* time, squared error and squared size at the last accepted step */
  PetscReal last[SMALL_MAX_STATES]; /* state there */
  PetscReal errors, sizes;          /* their integrals, trapezoidal rule */
  PetscInt next;                    /* first time of the table that is not seen yet */
  PetscReal between, between_size;  /* sums over the times of the table, the run taken linear between its steps */
} SmallErrors;

/* w: state at time 0 [states] */
PETSC_INTERN void SmallErrorsStart(EnvReference reference, const PetscReal w[], SmallErrors *e);
/* A step from the last state to w at time t */
PETSC_INTERN void SmallErrorsStep(SmallErrors *e, PetscReal t, const PetscReal w[]);
/* The relative L2 norm at the ends of steps, and that with the times between them */
PETSC_INTERN void SmallErrorsEnd(const SmallErrors *e, PetscReal error[2]);
