/* How long a fault at rest stays at rest. */
#include <slipstep/private/slipfault.h>
#include <slipcompat.h>

/* Until an cell with force f and its rate of change d reaches the strength q; 0 when f exceeds it. */
static PetscReal SlipFaultTimeToSlip(PetscReal f, PetscReal d, PetscReal q)
{
  if (PetscAbsReal(f) > q) return 0;
  if (d == 0) return PETSC_MAX_REAL;
  return ((d > 0 ? q : -q) - f) / d;
}

/*
  SlipFaultRestTime - for how long the state w stays exactly at rest [s]

  Collective. 0 when an cell moves or its force exceeds the strength; PETSC_MAX_REAL without loading. At v = 0 the
  force is f = -K u + H v_inf and, because du/dt = -v_inf, grows by K v_inf in time, while the strength stays what it
  is.
*/
PetscErrorCode SlipFaultRestTime(SlipFault fault, Vec w, PetscReal *rest)
{
  Vec rate = fault->work[0], force = fault->work[1], hold = fault->work[2];
  SlipFrictionCells friction;
  const SlipFaultSums *sums;
  const PetscReal *a, *d, *f, *g;
  PetscReal *u;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetFriction(fault, &friction));
  *rest = 0;
  PetscCall(SlipFaultGetSums(fault, w, &sums));
  if (sums->max_v > 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArrayWrite(rate, &u));
  for (PetscInt i = 0; i < fault->n; i++) u[i] = a[3 * i + 1];
  PetscCall(VecRestoreArrayWrite(rate, &u));
  PetscCall(MatMult(fault->K, rate, force));
  PetscCall(VecZeroEntries(rate));
  PetscCall(VecZeroEntries(hold));
  if (fault->loaded) {
    PetscCall(MatMult(fault->H, fault->vinf, hold));
    PetscCall(MatMult(fault->K, fault->vinf, rate));
  }
  PetscCall(VecGetArrayRead(force, &f));
  PetscCall(VecGetArrayRead(rate, &d));
  PetscCall(VecGetArrayRead(hold, &g));
  *rest = PETSC_MAX_REAL;
  for (PetscInt i = 0; i < fault->n; i++) {
    PetscReal mu, ds, dv;

    SlipFrictionEvaluate(&friction, i, a[3 * i + 2], 0, &mu, &ds, &dv);
    *rest = PetscMin(
      *rest, SlipFaultTimeToSlip(g[i] - f[i], d[i], mu * fault->weight[i] * fault->field[FIELD_NORMAL_STRESS][i]));
  }
  PetscCall(VecRestoreArrayRead(hold, &g));
  PetscCall(VecRestoreArrayRead(rate, &d));
  PetscCall(VecRestoreArrayRead(force, &f));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, rest, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
