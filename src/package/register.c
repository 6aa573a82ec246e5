/* Registration of the whole library: every folder registers its classes, types and events, and this calls them all. */
#include <slipstep/rooms.h>
#include <slipcompat.h>

/* A plugin uses the PETSc of the program, which may differ from that of its headers. */
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
  SlipStepInitializePackage - registers every class, type and event of SlipStep with PETSc

  Not collective; call after PetscInitialize(). Later calls do nothing.

  Notes:
  Creating an object registers what that object uses: a fault all of it, a constraint the solvers, a policy only itself.
  Programs that choose controllers of SlipStep for problems of their own call this.

  Level: advanced

  Errors: PETSC_ERR_SUP if the program's PETSc differs from the library's in version or in the size of PetscInt.

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
  PetscDLLibraryRegister_slipstep - registers the library as a plugin; PETSc calls it for `-dll_prepend libslipstep.so`

  Collective

  Note:
  PETSc reads `-dll_prepend` only in PetscInitialize(). A program that is already running loads the library by
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
