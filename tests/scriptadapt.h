/* The controller "script" of tests of integrators, whose Choose() is the test's own */
#pragma once
#include "unit.h"
#include <petsc/private/tsimpl.h>

static PetscErrorCode Choose(TSAdapt adapt, TS ts, PetscReal h, PetscInt *scheme, PetscReal *next, PetscBool *accept,
                             PetscReal *wlte, PetscReal *wltea, PetscReal *wlter);

static inline PetscErrorCode CreateAdapt(TSAdapt adapt)
{
  adapt->ops->choose = Choose;
  return PETSC_SUCCESS;
}

static inline int Register(void **state)
{
  return (int)TSAdaptRegister("script", CreateAdapt);
}

/* Tolerance 1, without PETSc's own care for the end of a run */
static inline void Configure(TS ts, TSAdaptType adapt, PetscReal end, Vec x)
{
  SetAdapt(ts, adapt);
  ts->adapt->matchstepfac[0] = ts->adapt->matchstepfac[1] = 0;
  ok(TSSetTolerances(ts, 1, NULL, 0, NULL));
  ok(TSSetMaxTime(ts, end));
  ok(TSSetSolution(ts, x));
}
