/* What the operators register with PETSc. */
#include <slipstep/private/slipmatstage.h>
#include <slipstep/private/slipsys.h>
#include <slipmat.h>

/*@C
  SlipMatInitializePackage - register the preconditioner slipstage and the events of -log_view

  Not collective; after PetscInitialize(). Again it does nothing.

  Level: developer

.seealso: SlipStepInitializePackage(), MatCreateSlipStiffness(), MatCreateSlipStage()
@*/
PetscErrorCode SlipMatInitializePackage(void)
{
  static PetscBool registered = PETSC_FALSE;
  PetscBool now;

  PetscFunctionBegin;
  PetscCall(SlipRegisterOnce(&registered, &now));
  if (!now) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipLogRegister());
  PetscCall(PCRegister(PCSLIPSTAGE, PCCreate_SlipStage));
  PetscFunctionReturn(PETSC_SUCCESS);
}
