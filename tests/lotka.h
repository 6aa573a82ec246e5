/* Two rates of change that tests of integrators share */
#pragma once
#include "unit.h"
#include <petscts.h>

/* Lotka's and Volterra's: x' = x (1 - y), y' = y (x - 1), which keeps x - ln x + y - ln y */
static PetscInt evaluations;

static PetscErrorCode Rate(TS ts, PetscReal t, Vec u, Vec f, void *ctx)
{
  const PetscScalar *x;
  PetscScalar *r;

  evaluations++;
  x = VecRead(u);
  PetscCall(VecGetArrayWrite(f, &r));
  r[0] = x[0] * (1 - x[1]);
  r[1] = x[1] * (x[0] - 1);
  return VecRestoreArrayWrite(f, &r);
}

#define END 8.0

static void Make(TS *ts, Vec *u, const char type[], PetscReal dt)
{
  ok(VecCreateSeq(PETSC_COMM_SELF, 2, u));
  ok(VecSetValues(*u, 2, (const PetscInt[]){0, 1}, (const PetscScalar[]){2, 0.5}, INSERT_VALUES));
  ok(VecAssemble(*u));
  *ts = MakeTS(type, dt, END);
  ok(TSSetProblemType(*ts, TS_NONLINEAR));
  ok(TSSetRHSFunction(*ts, NULL, Rate, NULL));
  evaluations = 0;
}
