/* Registers the operators with PETSc. */
#include <slipstep/private/slipmatstage.h>
#include <slipstep/private/slipsys.h>
#include <slipmat.h>

static PetscErrorCode Register_Mat(void)
{
  PetscFunctionBegin;
  PetscCall(SlipLogRegister());
  PetscCall(PCRegister(PCSLIPSTAGE, PCCreate_SlipStage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipMatInitializePackage - registers the preconditioner slipstage and the events of -log_view

  Not collective; after PetscInitialize(). Further calls do nothing.

  Level: developer

.seealso: SlipStepInitializePackage(), MatCreateSlipStiffness(), MatCreateSlipViscosity(), MatCreateSlipStage()
@*/
PetscErrorCode SlipMatInitializePackage(void)
{
  return SlipRegisterOnce(Register_Mat);
}
