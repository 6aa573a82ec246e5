/* What the integrator registers with PETSc. */
#include <slipstep/private/slipts.h>
#include <slipstep/private/slipsnes.h>
#include <slipstep/private/slipsys.h>

/*@C
  SlipTSInitializePackage - register TSBATHE and the solvers of its stages

  Not collective; after PetscInitialize(). Again it does nothing.

  Level: developer

.seealso: SlipStepInitializePackage(), SlipSmallConfigureTS()
@*/
PetscErrorCode SlipTSInitializePackage(void)
{
  static PetscBool registered = PETSC_FALSE;
  PetscBool now;

  PetscFunctionBegin;
  PetscCall(SlipRegisterOnce(&registered, &now));
  if (!now) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipSNESInitializePackage());
  PetscCall(TSRegister(TSBATHE, TSCreate_Bathe));
  PetscFunctionReturn(PETSC_SUCCESS);
}
