/* A plain PETSc program that has never heard of SlipStep: the Van der Pol oscillator x'' = mu (1 - x^2) x' - x (-mu
   <1>). Run it with -dll_prepend libslipstep.so -ts_type bathe -ts_adapt_type rl -ts_adapt_rl_policy policy.h5 */
#include <petscts.h>

static PetscErrorCode Rhs(TS ts, PetscReal t, Vec y, Vec f, void *ctx)
{
  const PetscReal mu = *(PetscReal *)ctx;
  const PetscScalar *a;
  PetscScalar *b;

  PetscFunctionBeginUser;
  (void)ts, (void)t;
  PetscCall(VecGetArrayRead(y, &a));
  PetscCall(VecGetArrayWrite(f, &b));
  b[0] = a[1];
  b[1] = mu * (1 - a[0] * a[0]) * a[1] - a[0];
  PetscCall(VecRestoreArrayRead(y, &a));
  PetscCall(VecRestoreArrayWrite(f, &b));
  PetscFunctionReturn(0);
}

static PetscErrorCode Jacobian(TS ts, PetscReal t, Vec y, Mat J, Mat P, void *ctx)
{
  const PetscReal mu = *(PetscReal *)ctx;
  const PetscInt rows[2] = {0, 1};
  const PetscScalar *a;
  PetscScalar v[4] = {0, 1, 0, 0};

  PetscFunctionBeginUser;
  (void)ts, (void)t, (void)J;
  PetscCall(VecGetArrayRead(y, &a));
  v[2] = -2 * mu * a[0] * a[1] - 1;
  v[3] = mu * (1 - a[0] * a[0]);
  PetscCall(VecRestoreArrayRead(y, &a));
  PetscCall(MatSetValues(P, 2, rows, 2, rows, v, INSERT_VALUES));
  PetscCall(MatAssemblyBegin(P, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(P, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  PetscReal mu = 1, t;
  PetscInt steps;
  TS ts;
  Vec y;
  Mat J;
  const PetscScalar *a;

  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-mu", &mu, NULL));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, 2, &y));
  PetscCall(VecSetValue(y, 0, 2, INSERT_VALUES));
  PetscCall(VecAssemblyBegin(y));
  PetscCall(VecAssemblyEnd(y));
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, 2, 2, NULL, &J));
  PetscCall(TSCreate(PETSC_COMM_SELF, &ts));
  PetscCall(TSSetRHSFunction(ts, NULL, Rhs, &mu));
  PetscCall(TSSetRHSJacobian(ts, J, J, Jacobian, &mu));
  PetscCall(TSSetTimeStep(ts, 0.01));
  PetscCall(TSSetMaxTime(ts, 5));
  PetscCall(TSSetMaxSteps(ts, 100000));
  PetscCall(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  PetscCall(TSSetFromOptions(ts));
  PetscCall(TSSolve(ts, y));
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSGetStepNumber(ts, &steps));
  PetscCall(VecGetArrayRead(y, &a));
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "time %.6f steps %d x %.8f y %.8f\n", (double)t, (int)steps,
                        (double)PetscRealPart(a[0]), (double)PetscRealPart(a[1])));
  PetscCall(VecRestoreArrayRead(y, &a));
  PetscCall(TSDestroy(&ts));
  PetscCall(MatDestroy(&J));
  PetscCall(VecDestroy(&y));
  PetscCall(PetscFinalize());
  return 0;
}
