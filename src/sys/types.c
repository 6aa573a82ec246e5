/* Tables of classes, types and log events: one row each. */
#include <slipstep.h>
#include <slipstep/private/slipcompat.h>
#include <slipstep/private/slipregister.h>
#include <slipstep/private/slipmat.h>

PetscErrorCode SlipRegisterClasses(void)
{
  PetscFunctionBegin;
  /* one row per class: PetscClassIdRegister */
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipRegisterTypes(void)
{
  PetscFunctionBegin;
  /* one row per type: TSRegister, TSAdaptRegister, SNESRegister, PCRegister */
  PetscCall(PCRegister(PCSLIPSTAGE, PCCreate_SlipStage));
  PetscCall(PetscLogEventRegister("SlipKSetUp", MAT_CLASSID, &SLIP_StiffnessSetUp));
  PetscCall(PetscLogEventRegister("SlipHSetUp", MAT_CLASSID, &SLIP_ViscositySetUp));
  PetscFunctionReturn(PETSC_SUCCESS);
}
