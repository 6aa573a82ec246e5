/* The library as a whole: every room registers its own classes, types and events, here they are all called. */
#include <slipstep.h>
#include <slipcompat.h>

/* A plugin meets the PETSc of the program, which may be another than that of its headers. */
static PetscErrorCode SlipStepCheckPetsc(void)
{
  PetscInt major, minor, patch;
  size_t size;

  PetscFunctionBegin;
  PetscCall(PetscGetVersionNumber(&major, &minor, &patch, NULL));
  PetscCheck(major == PETSC_VERSION_MAJOR && minor == PETSC_VERSION_MINOR, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "SlipStep was built against PETSc %d.%d and the program runs with %d.%d; build it against that one",
             PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, (int)major, (int)minor);
  PetscCall(PetscDataTypeGetSize(PETSC_INT, &size));
  PetscCheck(size == sizeof(PetscInt), PETSC_COMM_SELF, PETSC_ERR_SUP,
             "SlipStep was built with PetscInt of %d bits and the program's PETSc has %d; build it against that one",
             8 * (int)sizeof(PetscInt), 8 * (int)size);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipStepInitializePackage - register every class, type and event of SlipStep with PETSc

  Not collective; call after PetscInitialize(). Calling it again does nothing.

  Notes:
  Creating an object initializes what that object uses: a fault all of it, a constraint the solvers, a policy only
  itself. Programs that choose controllers of SlipStep for problems of their own call this.

  Level: advanced

  Errors: PETSC_ERR_SUP when the program's PETSc is of another version, or has another PetscInt, than the library's.

.seealso: PetscDLLibraryRegister_slipstep()
@*/
PetscErrorCode SlipStepInitializePackage(void)
{
  PetscFunctionBegin;
  PetscCall(SlipStepCheckPetsc());
  PetscCall(SlipMatInitializePackage());
  PetscCall(SlipElasticInitializePackage());
  PetscCall(SlipSNESInitializePackage());
  PetscCall(SlipTSInitializePackage());
  PetscCall(SlipPolicyInitializePackage());
  PetscCall(SlipAdaptInitializePackage());
  PetscCall(SlipFaultInitializePackage());
  PetscCall(SlipFaultDeclareOptions());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  PetscDLLibraryRegister_slipstep - entry point of the plugin, called by PETSc for `-dll_prepend libslipstep.so`

  Collective

  Note:
  PETSc reads `-dll_prepend` in PetscInitialize() only. A program that runs already loads the library by
  PetscDLLibraryAppend(PETSC_COMM_WORLD, &PetscDLLibrariesLoaded, "libslipstep.so"); from Python,
  ctypes.CDLL("libslipstep.so").SlipStepInitializePackage() after petsc4py.init() does the same.

  Level: developer

.seealso: SlipStepInitializePackage()
@*/
PetscErrorCode PetscDLLibraryRegister_slipstep(void)
{
  PetscFunctionBegin;
  PetscCall(SlipStepInitializePackage());
  PetscFunctionReturn(PETSC_SUCCESS);
}
