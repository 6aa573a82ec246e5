/* What the integrator's last attempt tells a controller: sums over the cells of its error and of its
   acceleration. */
#include <slipstep/private/slipfault.h>

/* The arrays of w, of the error and of the derivative hold (v, u, s) per cell; both of the latter may be NULL. */
static void SlipFaultAddEstimates(SlipFault fault, const PetscReal *w, const PetscReal *error,
                                  const PetscReal *derivative, PetscReal sum[])
{
  for (PetscInt i = 0; i < fault->n; i++) {
    const PetscReal v = w[3 * i];

    if (error) sum[ESTIMATE_SLIP_ERROR] += fault->weight[i] * PetscAbsReal(error[3 * i + 2]);
    if (derivative && v != 0) sum[ESTIMATE_GROWTH] += fault->weight[i] * PetscSign(v) * derivative[3 * i];
  }
}

/*
  SlipFaultEstimate - sum up the integrator's estimates for observations

  Collective. w: state after the attempt; error, derivative: the attempt's local error and dw/dt at its end, NULL when
  not known. An cell that has just stopped has no derivative.
*/
PetscErrorCode SlipFaultKeepEstimates(SlipFault fault, Vec w, Vec error, Vec derivative)
{
  SlipFaultEstimates *c = &fault->estimates;
  const PetscReal *a, *e = NULL, *d = NULL;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(c, sizeof(*c)));
  if (!error && !derivative) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(w, &a));
  if (error) PetscCall(VecGetArrayRead(error, &e));
  if (derivative) PetscCall(VecGetArrayRead(derivative, &d));
  SlipFaultAddEstimates(fault, a, e, d, c->sum);
  if (derivative) PetscCall(VecRestoreArrayRead(derivative, &d));
  if (error) PetscCall(VecRestoreArrayRead(error, &e));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, c->sum, FAULT_NUM_ESTIMATES, MPIU_REAL, MPIU_SUM, fault->comm));
  c->known = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
