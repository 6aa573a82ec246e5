/* Tables of classes and types: one row each. Log events are in log.c. */
#include <slipstep.h>
#include <slipcompat.h>
#include <slipstep/private/slippackage.h>
#include <slipstep/private/slipadapt.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatstage.h>

PetscErrorCode SlipRegisterClasses(void)
{
  PetscFunctionBegin;
  /* one row per class: PetscClassIdRegister */
  PetscCall(PetscClassIdRegister("Step-size policy", &SLIP_POLICY_CLASSID));
  PetscCall(PetscClassIdRegister("SlipFault", &SLIP_FAULT_CLASSID));
  PetscCall(PetscClassIdRegister("Slip constraint", &SLIP_CONSTRAINT_CLASSID));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipRegisterTypes(void)
{
  PetscFunctionBegin;
  /* one row per type: TSRegister, TSAdaptRegister, SNESRegister, PCRegister */
  PetscCall(PCRegister(PCSLIPSTAGE, PCCreate_SlipStage));
  PetscCall(SNESRegister(SNESSEMISMOOTH, SNESCreate_Semismooth));
  PetscCall(SNESRegister(SNESPROJECTION, SNESCreate_Projection));
  PetscCall(TSRegister(TSBATHE, TSCreate_Bathe));
  PetscCall(TSAdaptRegister(TSADAPTHEURISTIC, TSAdaptCreate_Heuristic));
  PetscCall(TSAdaptRegister(TSADAPTPI, TSAdaptCreate_PI));
  PetscCall(TSAdaptRegister(TSADAPTRL, TSAdaptCreate_RL));
  PetscFunctionReturn(PETSC_SUCCESS);
}
