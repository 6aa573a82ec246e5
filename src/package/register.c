/* The library as a whole: every room registers its own classes, types and events, here they are all called. */
#include <slipstep.h>
#include <slipcompat.h>

/*@C
  SlipStepInitializePackage - register every class, type and event of SlipStep with PETSc

  Not collective; call after PetscInitialize(). Calling it again does nothing.

  Notes:
  Creating an object initializes what that object uses: a fault all of it, a constraint the solvers, a policy only
  itself. Programs that choose controllers of SlipStep for problems of their own call this.

  Level: advanced

.seealso: PetscDLLibraryRegister_slipstep()
@*/
PetscErrorCode SlipStepInitializePackage(void)
{
  PetscFunctionBegin;
  PetscCall(SlipMatInitializePackage());
  PetscCall(SlipSNESInitializePackage());
  PetscCall(SlipTSInitializePackage());
  PetscCall(SlipPolicyInitializePackage());
  PetscCall(SlipAdaptInitializePackage());
  PetscCall(SlipFaultInitializePackage());
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
