/* The critical state, in which elastic stress equals the strength: its solve with K, and the means of it. */
#include <slipstep/private/slipfault.h>
#include <petscksp.h>

/* Relative residual of K^-1 q that is accepted: a thousandth of what the critical start exceeds the strength by */
#define SLIP_FAULT_START_RESIDUAL 1e-8

/* x += K^-1 (b - K x), once. */
static PetscErrorCode SlipFaultRefine(SlipFault fault, KSP ksp, Vec b, Vec x)
{
  Vec r = fault->work[1], d = fault->work[2];
  KSPConvergedReason reason;

  PetscFunctionBegin;
  PetscCall(MatMult(fault->operators.K, x, r));
  PetscCall(VecAYPX(r, -1, b));
  PetscCall(KSPSolve(ksp, r, d));
  PetscCall(KSPGetConvergedReason(ksp, &reason));
  PetscCheck(reason > 0, fault->comm, PETSC_ERR_NOT_CONVERGED,
             "K^-1 q of the critical state was not found (%s): is the stiffness positive definite?",
             KSPConvergedReasons[reason]);
  PetscCall(VecAXPY(x, 1, d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  x = K^-1 b, started from x, by conjugate gradients (K is symmetric positive definite) and iterative refinement.

  The critical start exceeds the strength by a relative 1e-5 only, so that an error of K^-1 q counts 1e5 times: three
  passes of 1e-7 leave nothing but the rounding of K x. What options of the solver leave is looked at. b must not be
  work[1] or work[2].
*/
PetscErrorCode SlipFaultSolveStiffness(SlipFault fault, Vec b, Vec x)
{
  const char *prefix = SlipFaultPrefix(fault);
  Vec r = fault->work[1];
  PetscReal left, all;
  KSP ksp;
  PC pc;

  PetscFunctionBegin;
  PetscCall(KSPCreate(fault->comm, &ksp));
  PetscCall(KSPSetOptionsPrefix(ksp, ((PetscObject)fault)->prefix));
  PetscCall(KSPAppendOptionsPrefix(ksp, "fault_start_"));
  PetscCall(KSPSetOperators(ksp, fault->operators.K, fault->operators.K));
  PetscCall(KSPSetType(ksp, KSPCG));
  PetscCall(KSPSetTolerances(ksp, 1e-7, 0, 1e10, PetscMax(1000, 10 * fault->layout.components * fault->mesh.N)));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCSLIPSTAGE));
  PetscCall(KSPSetFromOptions(ksp));
  for (PetscInt pass = 0; pass < 3; pass++) PetscCall(SlipFaultRefine(fault, ksp, b, x));
  PetscCall(KSPDestroy(&ksp));
  PetscCall(MatMult(fault->operators.K, x, r));
  PetscCall(VecAYPX(r, -1, b));
  PetscCall(VecNorm(r, NORM_2, &left));
  PetscCall(VecNorm(b, NORM_2, &all));
  PetscCheck(left <= SLIP_FAULT_START_RESIDUAL * all, fault->comm, PETSC_ERR_NOT_CONVERGED,
             "K^-1 q of the critical state has a relative residual of %.3g, expected at most %.6g: give "
             "-%sfault_start_ksp_rtol, -%sfault_start_ksp_atol or -%sfault_start_ksp_type other values",
             (double)(left / all), SLIP_FAULT_START_RESIDUAL, prefix, prefix, prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What uc's growth at the start is made of */
static PetscErrorCode CriticalMode(SlipFault fault)
{
  SlipFrictionCells friction;
  PetscReal sum[2] = {0, 0};
  const PetscReal *uc;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetFriction(fault, 0, &friction));
  PetscCall(VecGetArrayRead(fault->critical.uc, &uc));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal mu, ds, dv;

    SlipFrictionEvaluate(&friction, i, NULL, 0, &mu, &ds, &dv);
    {
      const PetscReal square = PetscSqr(SlipFaultLength(fault, uc + fault->layout.components * i));

      sum[0] -= ds * (fault->mesh.weight[i] * fault->fields.cell[FIELD_NORMAL_STRESS][i]) * square;
      sum[1] += fault->operators.mass * fault->mesh.weight[i] * square;
    }
  }
  PetscCall(VecRestoreArrayRead(fault->critical.uc, &uc));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, fault->comm));
  fault->critical.weakening = sum[0];
  fault->critical.inertia = sum[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* uc = K^-1 q(0); uc holds K^-1 sigma_n, which is proportional to it when friction is uniform: a good first guess. */
PetscErrorCode SlipFaultCriticalSetUp(SlipFault fault)
{
  SlipFrictionCells friction;
  const PetscInt c = fault->layout.components;
  PetscReal mu, ds, dv, strength, sum[4] = {0, 0, 0, 0};
  PetscBool critical;
  PetscReal *q;
  Vec q0 = fault->work[0];

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(fault->kind.initial, "critical", &critical));
  fault->critical.start_share = critical ? -(1 + fault->options.value[FAULT_INITIAL_PERTURBATION]) : 0;
  PetscCall(SlipFaultGetFriction(fault, 0, &friction));
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
  if (!fault->critical.known) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecScale(fault->critical.uc, sum[2] / fault->mesh.N));
  PetscCall((*fault->told)(fault, "K^-1 of the strength, the critical state"));
  PetscCall(SlipFaultSolveStiffness(fault, q0, fault->critical.uc));
  PetscCall(VecDot(fault->critical.uc, q0, &fault->critical.energy));
  PetscCall(SlipFaultWeightedSum(fault, fault->critical.uc, &fault->critical.mean_uc));
  fault->critical.mean_uc /= fault->mesh.N;
  fault->critical.drop_slip = fault->critical.mean_drop / fault->critical.mean_q0 * fault->critical.mean_uc;
  PetscCall(CriticalMode(fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}
