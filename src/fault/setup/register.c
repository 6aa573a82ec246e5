/* What faults register with PETSc. */
#include <slipstep/private/slipfault.h>
#include <slipadapt.h>

PetscClassId SLIP_FAULT_CLASSID;

static PetscErrorCode Register_Fault(void)
{
  PetscFunctionBegin;
  PetscCall(SlipAdaptInitializePackage());
  PetscCall(SlipElasticInitializePackage());
  PetscCall(PetscClassIdRegister("SlipFault", &SLIP_FAULT_CLASSID));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultInitializePackage - register the class of faults and all that a TS of a fault can be made of

  Not collective; after PetscInitialize(). Again it does nothing.

  Level: developer

.seealso: SlipStepInitializePackage(), SlipFaultCreate()
@*/
PetscErrorCode SlipFaultInitializePackage(void)
{
  return SlipRegisterOnce(Register_Fault);
}
