/* Registers the step-size controllers with PETSc. */
#include <slipstep/private/slipadapt.h>
#include <slipstep/private/slippolicy.h>
#include <slipstep/private/slipsys.h>

static PetscErrorCode Register_Adapt(void)
{
  PetscFunctionBegin;
  PetscCall(SlipPolicyInitializePackage());
  PetscCall(SlipTSInitializePackage());
  PetscCall(TSAdaptRegister(TSADAPTRL, TSAdaptCreate_RL));
  PetscCall(TSAdaptRegister(TSADAPTHEURISTIC, TSAdaptCreate_Heuristic));
  PetscCall(TSAdaptRegister(TSADAPTPI, TSAdaptCreate_PI));
  PetscCall(TSAdaptRegister(TSADAPTLAPUSTA, TSAdaptCreate_Lapusta));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Registers the step-size controllers, with the integrator and policies. */
PetscErrorCode SlipAdaptInitializePackage(void)
{
  return SlipRegisterOnce(Register_Adapt);
}
