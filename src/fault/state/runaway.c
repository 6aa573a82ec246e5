/* Detects instability by the loss of damping. Where strength falls with the slip rate by more than the viscosity, a
   stiff cell swings about the loading rate and sticks within seconds, repeatedly; long steps average that, as creep.
   Where stiffness is small against the loss, as in large parts that slide together, motion runs away. The matrices of
   long stages are positive definite there too, and their steps would go past the event. So they count as errors while
   motion runs away, for a cell by itself or for the present slip rates. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>

/* Largest accepted theta of a stage over the time of growth */
static const PetscReal share = 0.5;

/* Returns the time in which a motion with mass m, damping d and stiffness k grows, if it grows without swinging. */
static PetscReal Time(PetscReal m, PetscReal d, PetscReal k)
{
  const PetscReal root = d * d - 4 * m * k;

  return d < 0 && root > 0 ? 2 * m / (-d + PetscSqrtReal(root)) : PETSC_MAX_REAL;
}

/*
  SlipFaultRunaway - computes the stage's theta over the longest one that follows runaway motion, else 0

  Collective; at the last stage, w: the state at its end, at the time t. It costs a product with H and one with K where
  strength falls with rate.
*/
PetscErrorCode SlipFaultRunaway(SlipFault fault, PetscReal t, Vec w, PetscReal *ratio)
{
  const PetscInt c = fault->layout.components;
  Vec v, d, Kv; /* Kv contains the slopes [n] first */
  const PetscReal *a, *k, *h, *dv, *rate;
  SlipFrictionCells friction;
  PetscReal sum[3] = {0, 0, 0}, least = PETSC_MAX_REAL; /* v M v, v (H + D) v, v K v */
  PetscBool weakens = PETSC_FALSE;
  PetscReal *slope;
  Vec diagonal[2];

  PetscFunctionBegin;
  *ratio = 0;
  if (!fault->kind.inertia || !fault->friction.law->by_rate) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetFrictionOf(fault, t, w, &friction));
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(SlipFaultGetWork(fault, &v));
  PetscCall(SlipFaultGetWork(fault, &d));
  PetscCall(SlipFaultGetWork(fault, &Kv));
  PetscCall(SlipElasticGetDiagonals(fault->medium, &diagonal[0], &diagonal[1]));
  PetscCall(VecGetArrayRead(diagonal[0], &k));
  PetscCall(VecGetArrayRead(diagonal[1], &h));
  PetscCall(VecGetArrayWrite(Kv, &slope));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal mu, dmu_ds, dmu_dv;

    slope[i] = 0;
    if (SlipFaultSpeed(fault, a, i) == 0) continue;
    SlipFrictionEvaluate(&friction, i, a + SlipFaultStateAt(fault, i), SlipFaultSpeed(fault, a, i), &mu, &dmu_ds,
                         &dmu_dv);
    slope[i] = dmu_dv * friction.stress[i] * fault->mesh.weight[i];
    if (slope[i] < 0) weakens = PETSC_TRUE;
    if (SlipFaultLargest(fault, h, i) + slope[i] < 0)
      least = PetscMin(least, Time(fault->operators.mass * fault->mesh.weight[i],
                                   SlipFaultLargest(fault, h, i) + slope[i], SlipFaultLargest(fault, k, i)));
  }
  PetscCall(VecRestoreArrayWrite(Kv, &slope));
  PetscCall(VecRestoreArrayRead(diagonal[1], &h));
  PetscCall(VecRestoreArrayRead(diagonal[0], &k));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &weakens, 1, MPIU_BOOL, MPI_LOR, fault->comm));
  if (!weakens) {
    PetscCall(SlipFaultRestoreWork(fault, &Kv));
    PetscCall(SlipFaultRestoreWork(fault, &d));
    PetscCall(SlipFaultRestoreWork(fault, &v));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipFaultGetRate(fault, w, v));
  PetscCall(SlipElasticForce(fault->medium, t, NULL, v, d, NULL));
  PetscCall(VecGetArrayRead(v, &rate));
  PetscCall(VecGetArrayRead(d, &dv));
  PetscCall(VecGetArrayRead(Kv, &h));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    for (PetscInt j = c * i; j < c * (i + 1); j++) {
      sum[0] += fault->operators.mass * fault->mesh.weight[i] * PetscSqr(rate[j]);
      sum[1] += rate[j] * (dv[j] + (j < c * i + 2 ? h[i] : 0) * rate[j]); /* friction acts in the plane */
    }
  }
  PetscCall(VecRestoreArrayRead(Kv, &h));
  PetscCall(VecRestoreArrayRead(d, &dv));
  PetscCall(VecRestoreArrayRead(v, &rate));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, fault->comm));
  if (sum[1] < 0) {
    PetscCall(SlipElasticApply(fault->medium, v, Kv, NULL));
    PetscCall(VecDot(v, Kv, &sum[2]));
    least = PetscMin(least, Time(sum[0], sum[1], sum[2]));
  }
  PetscCall(SlipFaultRestoreWork(fault, &Kv));
  PetscCall(SlipFaultRestoreWork(fault, &d));
  PetscCall(SlipFaultRestoreWork(fault, &v));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  *ratio = fault->stage.theta / (share * least);
  PetscFunctionReturn(PETSC_SUCCESS);
}
