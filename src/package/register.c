/* The one list of all types that SlipStep adds to PETSc, and the package's life. */
#include <slipstep.h>
#include <slipcompat.h>
#include <slipstep/private/slippackage.h>
#include <slipstep/private/slipsys.h>

static PetscBool SlipStepPackageInitialized = PETSC_FALSE;

/*@C
  SlipStepFinalizePackage - forget the registrations; called by PetscFinalize()

  Collective

  Level: developer

.seealso: SlipStepInitializePackage()
@*/
PetscErrorCode SlipStepFinalizePackage(void)
{
  PetscFunctionBegin;
  SlipStepPackageInitialized = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipStepInitializePackage - register every class, type and event of SlipStep with PETSc

  Not collective; call after PetscInitialize(). Calling it again does nothing.

  Level: advanced

.seealso: PetscDLLibraryRegister_slipstep()
@*/
PetscErrorCode SlipStepInitializePackage(void)
{
  PetscFunctionBegin;
  if (SlipStepPackageInitialized) PetscFunctionReturn(PETSC_SUCCESS);
  SlipStepPackageInitialized = PETSC_TRUE;
  PetscCall(SlipRegisterClasses());
  PetscCall(SlipRegisterTypes());
  PetscCall(SlipLogRegister());
  PetscCall(PetscRegisterFinalize(SlipStepFinalizePackage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  PetscDLLibraryRegister_slipstep - entry point of the plugin, called by PETSc for `-dll_prepend libslipstep.so`

  Collective

  Level: developer

.seealso: SlipStepInitializePackage()
@*/
PetscErrorCode PetscDLLibraryRegister_slipstep(void)
{
  PetscFunctionBegin;
  PetscCall(SlipStepInitializePackage());
  PetscFunctionReturn(PETSC_SUCCESS);
}
