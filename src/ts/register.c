/* Registers the integrators with PETSc. */
#include <slipstep/private/slipbathe.h>
#include <slipstep/private/slipsnes.h>
#include <slipstep/private/slipsys.h>

static PetscErrorCode Register_TS(void)
{
  PetscFunctionBegin;
  PetscCall(SlipSNESInitializePackage());
  PetscCall(TSRegister(TSBATHE, TSCreate_Bathe));
  PetscCall(TSRegister(TSMOREAU, TSCreate_Moreau));
  PetscCall(TSRegister(TSADAMS, TSCreate_Adams));
  PetscCall(TSRegister(TSRKC, TSCreate_RKC));
  PetscCall(TSRegister(TSLAPUSTA, TSCreate_Lapusta));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Registers TSBATHE, TSMOREAU, TSADAMS, TSRKC, TSLAPUSTA and the solvers of stages. */
PetscErrorCode SlipTSInitializePackage(void)
{
  return SlipRegisterOnce(Register_TS);
}
