/* Registers the operators with PETSc. */
#include <slipstep/private/slipmatstage.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/rooms/slipmat.h>

static PetscErrorCode Register_Mat(void)
{
  PetscFunctionBegin;
  PetscCall(SlipLogRegister());
  PetscCall(PCRegister(PCSLIPSTAGE, PCCreate_SlipStage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Registers the preconditioner slipstage and the events of -log_view. */
PetscErrorCode SlipMatInitializePackage(void)
{
  return SlipRegisterOnce(Register_Mat);
}
