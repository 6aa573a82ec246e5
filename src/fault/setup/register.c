/* Registers the classes and types of faults with PETSc. */
#include <slipstep/private/slipfault.h>
#include <slipstep/rooms/slipadapt.h>

PetscClassId SLIP_FAULT_CLASSID;

static PetscErrorCode Register_Fault(void)
{
  PetscFunctionBegin;
  PetscCall(SlipAdaptInitializePackage());
  PetscCall(SlipElasticInitializePackage());
  PetscCall(PetscClassIdRegister("SlipFault", &SLIP_FAULT_CLASSID));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Registers the class of faults and all types that a TS of a fault can consist of. */
PetscErrorCode SlipFaultInitializePackage(void)
{
  return SlipRegisterOnce(Register_Fault);
}
