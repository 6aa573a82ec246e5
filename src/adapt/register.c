/* What the step-size controllers register with PETSc. */
#include <slipstep/private/slipadapt.h>
#include <slipstep/private/slippolicy.h>
#include <slipstep/private/slipsys.h>

/*@C
  SlipAdaptInitializePackage - register the step-size controllers, with the integrator and policies

  Not collective; after PetscInitialize(). Again it does nothing.

  Level: developer

.seealso: SlipStepInitializePackage(), TSADAPTRL
@*/
PetscErrorCode SlipAdaptInitializePackage(void)
{
  static PetscBool registered = PETSC_FALSE;
  PetscBool now;

  PetscFunctionBegin;
  PetscCall(SlipRegisterOnce(&registered, &now));
  if (!now) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipPolicyInitializePackage());
  PetscCall(SlipTSInitializePackage());
  PetscCall(TSAdaptRegister(TSADAPTHEURISTIC, TSAdaptCreate_Heuristic));
  PetscCall(TSAdaptRegister(TSADAPTPI, TSAdaptCreate_PI));
  PetscCall(TSAdaptRegister(TSADAPTRL, TSAdaptCreate_RL));
  PetscFunctionReturn(PETSC_SUCCESS);
}
