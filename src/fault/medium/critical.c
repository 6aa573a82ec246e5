/* Computes the critical state, in which elastic stress equals the strength, by a solve with K, and its means. */
#include <slipstep/private/slipfault.h>

/* Computes uc = K^-1 q(0) from the first guess K^-1 sigma_n in uc, which is proportional for uniform friction. */
PetscErrorCode SlipFaultCriticalSetUp(SlipFault fault)
{
  SlipFrictionCells friction;
  const PetscInt c = fault->layout.components;
  PetscReal mu, ds, dv, strength, sum[4] = {0, 0, 0, 0}, mode[2] = {0, 0};
  const PetscReal *uc;
  PetscBool critical;
  PetscReal *q;
  Vec q0;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(fault->kind.initial, "critical", &critical));
  fault->critical.start_share = critical ? -(1 + fault->options.value[FAULT_INITIAL_PERTURBATION]) : 0;
  PetscCall(SlipFaultGetFriction(fault, 0, &friction));
  PetscCall(SlipFaultGetWork(fault, &q0));
  PetscCall(VecGetArrayWrite(q0, &q));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    SlipFrictionEvaluate(&friction, i, NULL, 0, &mu, &ds, &dv);
    strength = mu * (fault->mesh.weight[i] * fault->fields.cell[FIELD_NORMAL_STRESS][i]);
    for (PetscInt k = 0; k < c; k++) q[c * i + k] = strength * SlipFaultAlong(fault, i)[k];
    sum[0] += strength;
    sum[1] += fault->mesh.weight[i] * fault->fields.cell[FIELD_FRICTION_SLIP][i];
    sum[2] += mu;
    sum[3] +=
      (mu - SlipFrictionWeakest(&friction, i)) * (fault->mesh.weight[i] * fault->fields.cell[FIELD_NORMAL_STRESS][i]);
  }
  PetscCall(VecRestoreArrayWrite(q0, &q));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 4, MPIU_REAL, MPIU_SUM, fault->comm));
  fault->critical.mean_q0 = sum[0] / fault->mesh.N;
  fault->critical.mean_dc = sum[1] / fault->mesh.N;
  fault->critical.mean_drop = sum[3] / fault->mesh.N;
  if (!fault->critical.known) {
    PetscCall(SlipFaultRestoreWork(fault, &q0));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecScale(fault->critical.uc, sum[2] / fault->mesh.N));
  PetscCall((*fault->told)(fault, "K^-1 of the strength, the critical state"));
  PetscCall(SlipElasticSolve(fault->medium, q0, fault->critical.uc));
  PetscCall(VecDot(fault->critical.uc, q0, &fault->critical.energy));
  PetscCall(SlipFaultRestoreWork(fault, &q0));
  PetscCall(SlipFaultWeightedSum(fault, fault->critical.uc, &fault->critical.mean_uc));
  fault->critical.mean_uc /= fault->mesh.N;
  fault->critical.drop_slip = fault->critical.mean_drop / fault->critical.mean_q0 * fault->critical.mean_uc;
  /* the weakening and the inertia that determine how uc grows at the start */
  PetscCall(SlipFaultGetFriction(fault, 0, &friction));
  PetscCall(VecGetArrayRead(fault->critical.uc, &uc));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal square = PetscSqr(SlipFaultLength(fault, uc + c * i));

    SlipFrictionEvaluate(&friction, i, NULL, 0, &mu, &ds, &dv);
    mode[0] -= ds * (fault->mesh.weight[i] * fault->fields.cell[FIELD_NORMAL_STRESS][i]) * square;
    mode[1] += fault->operators.mass * fault->mesh.weight[i] * square;
  }
  PetscCall(VecRestoreArrayRead(fault->critical.uc, &uc));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, mode, 2, MPIU_REAL, MPIU_SUM, fault->comm));
  fault->critical.weakening = mode[0];
  fault->critical.inertia = mode[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}
