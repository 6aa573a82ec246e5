/* Constant steps of small systems, for tests. */
#pragma once
#include "models.h"

/* n constant steps over [0, tmax] of a TS that is configured; w holds the start and receives the end */
static inline void Steps(TS ts, Vec w, PetscReal tmax, PetscInt n)
{
  SetAdapt(ts, TSADAPTNONE);
  ok(TSSetTime(ts, 0));
  ok(TSSetStepNumber(ts, 0));
  ok(TSSetMaxTime(ts, tmax));
  ok(TSSetTimeStep(ts, tmax / n));
  ok(TSSolve(ts, w));
}

static inline void Get(Vec w, PetscInt n, PetscReal values[])
{
  const PetscScalar *a = VecRead(w);

  for (PetscInt i = 0; i < n; i++) values[i] = a[i];
}

static inline Vec State(PetscInt n, const PetscReal values[])
{
  Vec w;
  PetscScalar *a;

  ok(VecCreateSeq(PETSC_COMM_SELF, n, &w));
  ok(VecGetArray(w, &a));
  for (PetscInt i = 0; i < n; i++) a[i] = values[i];
  ok(VecRestoreArray(w, &a));
  return w;
}
