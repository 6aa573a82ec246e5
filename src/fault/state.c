/* The state of a fault: its vector and its start. */
#include <slipstep/private/slipfault.h>

/*@
  SlipFaultCreateState - a vector for the state w: block size 3, (v [m/s], u [m], s [m]) per cell

  Collective; after SlipFaultSetUp().

  Input Parameter:
. fault - the fault

  Output Parameter:
. w - zero, of global size 3 N; destroy it

  Level: beginner

  Notes:
  Cell e = iz * nx + ix is entry e. The cells of a mesh are numbered process by process instead.

  Errors: PETSC_ERR_ORDER before SlipFaultSetUp()

.seealso: SlipFaultSetInitialState()
@*/
PetscErrorCode SlipFaultCreateState(SlipFault fault, Vec *w)
{
  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscAssertPointer(w, 2);
  PetscCall(VecCreate(fault->comm, w));
  PetscCall(VecSetSizes(*w, 3 * fault->n, 3 * fault->N));
  PetscCall(VecSetBlockSize(*w, 3));
  PetscCall(VecSetType(*w, VECSTANDARD));
  PetscCall(VecZeroEntries(*w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultSetInitialState - the start that -fault_initial names

  Collective. "critical": v = 0, s = 0, u = -(1 + perturbation) K^-1 q(0), so that -K u slightly exceeds the strength
  everywhere; "rest": all zero.

  Input Parameters:
+ fault - the fault
- w     - of SlipFaultCreateState(); overwritten

  Options Database Keys:
+ -fault_initial <critical,rest>       - which start
- -fault_initial_perturbation <1e-5>   - relative excess of the critical start, dimensionless

  Level: beginner

  Errors: PETSC_ERR_ORDER before SlipFaultSetUp()

.seealso: SlipFaultCreateState()
@*/
PetscErrorCode SlipFaultSetInitialState(SlipFault fault, Vec w)
{
  const PetscReal factor = -(1 + fault->value[FAULT_INITIAL_PERTURBATION]);
  PetscBool critical;
  PetscReal *a;
  const PetscReal *uc;

  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscValidHeaderSpecific(w, VEC_CLASSID, 2);
  PetscCall(PetscStrcmp(fault->text[FAULT_INITIAL], "critical", &critical));
  PetscCall(VecZeroEntries(w));
  if (!critical) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArray(w, &a));
  PetscCall(VecGetArrayRead(fault->uc, &uc));
  for (PetscInt i = 0; i < fault->n; i++) a[3 * i + 1] = factor * uc[i];
  PetscCall(VecRestoreArrayRead(fault->uc, &uc));
  PetscCall(VecRestoreArray(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}
