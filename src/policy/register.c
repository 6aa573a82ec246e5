/* What policies register with PETSc. */
#include <slipstep/private/slippolicy.h>
#include <slipstep/private/slipsys.h>

PetscClassId SLIP_POLICY_CLASSID;

/*@C
  SlipPolicyInitializePackage - register the class of policies and the event of their forward pass

  Not collective; after PetscInitialize(). Again it does nothing.

  Level: developer

.seealso: SlipStepInitializePackage(), SlipPolicyCreate()
@*/
PetscErrorCode SlipPolicyInitializePackage(void)
{
  static PetscBool registered = PETSC_FALSE;
  PetscBool now;

  PetscFunctionBegin;
  PetscCall(SlipRegisterOnce(&registered, &now));
  if (!now) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipLogRegister());
  PetscCall(PetscClassIdRegister("Step-size policy", &SLIP_POLICY_CLASSID));
  PetscFunctionReturn(PETSC_SUCCESS);
}
