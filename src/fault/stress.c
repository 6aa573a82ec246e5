/* The elastic shear stress of a fault, its energy, and what loading does: here, and nowhere else, stands what acts on a
   cell besides friction and viscosity. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipmatcells.h>
#include <slipstep/private/slipsys.h>

/* What rows with a weight of one stand for */
PetscReal SlipFaultMeanArea(SlipFault fault)
{
  if (fault->mesh.n) return 0.5 / SlipCellsUnit(&fault->mesh);
  return fault->value[FAULT_LENGTH_X] * fault->value[FAULT_LENGTH_Z] / (PetscReal)fault->N;
}

/*@
  SlipFaultStress - elastic shear stress on each cell

  Collective; after SlipFaultSetUp()

  Input Parameters:
+ fault - the fault
. t     - time of the state [s]
- w     - state, of SlipFaultCreateState()

  Output Parameter:
. T - shear stress [Pa], one number for each cell in the distribution of the state, positive where it drives slip forward

  Level: intermediate

  Notes:
  -K u, per area of the cell itself, also on meshes, where rows of K are weighted by area. It costs a product with K.
  Friction and viscosity are not part of it.

.seealso: SlipFaultGetObservables(), SlipFaultGetOperators()
@*/
PetscErrorCode SlipFaultStress(SlipFault fault, PetscReal t, Vec w, Vec T)
{
  PetscReal *a;

  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscValidHeaderSpecific(w, VEC_CLASSID, 3);
  PetscValidHeaderSpecific(T, VEC_CLASSID, 4);
  (void)t;
  PetscCall(VecStrideGather(w, 1, fault->work[0], INSERT_VALUES));
  PetscCall(MatMult(fault->K, fault->work[0], T));
  PetscCall(VecGetArray(T, &a));
  for (PetscInt i = 0; i < fault->n; i++) a[i] /= -fault->weight[i];
  PetscCall(VecRestoreArray(T, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* u K u/2, of the whole fault [J]; a product with K. Collective. */
PetscErrorCode SlipFaultElasticEnergy(SlipFault fault, PetscReal t, Vec w, PetscReal *energy)
{
  PetscFunctionBegin;
  (void)t;
  PetscCall(VecStrideGather(w, 1, fault->work[0], INSERT_VALUES));
  PetscCall(MatMult(fault->K, fault->work[0], fault->work[1]));
  PetscCall(VecDot(fault->work[0], fault->work[1], energy));
  *energy *= 0.5 * SlipFaultMeanArea(fault);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What loading adds to the elastic energy, -v_inf K u [W]: with K v_inf, computed once, no product. Collective. */
PetscErrorCode SlipFaultLoadingPower(SlipFault fault, PetscReal t, Vec w, PetscReal *power)
{
  PetscFunctionBegin;
  (void)t;
  *power = 0;
  if (!fault->loaded) PetscFunctionReturn(PETSC_SUCCESS);
  if (!fault->kvinf) {
    PetscCall(VecDuplicate(fault->vinf, &fault->kvinf));
    PetscCall(MatMult(fault->K, fault->vinf, fault->kvinf));
  }
  PetscCall(VecStrideGather(w, 1, fault->work[0], INSERT_VALUES));
  PetscCall(VecDot(fault->kvinf, fault->work[0], power));
  *power *= -SlipFaultMeanArea(fault);
  PetscFunctionReturn(PETSC_SUCCESS);
}
