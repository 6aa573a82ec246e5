/* Registers the class of policies with PETSc. */
#include <slipstep/private/slippolicy.h>
#include <slipstep/private/slipsys.h>

PetscClassId SLIP_POLICY_CLASSID;

static PetscErrorCode Register_Policy(void)
{
  PetscFunctionBegin;
  PetscCall(SlipLogRegister());
  PetscCall(PetscClassIdRegister("Step-size policy", &SLIP_POLICY_CLASSID));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Registers the class of policies and the event of their evaluation. */
PetscErrorCode SlipPolicyInitializePackage(void)
{
  return SlipRegisterOnce(Register_Policy);
}
