/* The version of the library at run time, for programs that were linked with another one */
#include <slipstep/rooms/slipsys.h>
#include <slipcompat.h>

/*@C
  SlipStepGetVersion - gets the version of the library that the program runs with, for example "0.5.0"

  Not collective.

  Input Parameter:
. len - size of version [characters, with the final zero]

  Output Parameter:
. version - the version, truncated to len; compare it with SLIPSTEP_VERSION of the headers

  Level: beginner

.seealso: SlipStepGetVersionNumber(), PetscGetVersion()
@*/
PetscErrorCode SlipStepGetVersion(char version[], size_t len)
{
  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(version, len, "%s", SLIPSTEP_VERSION));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipStepGetVersionNumber - gets the version of the library that the program runs with, as numbers to compare

  Not collective.

  Output Parameters:
+ major - changes when programs must be changed; may be NULL
. minor - changes with new features, and before 1.0 when programs must be changed; may be NULL
- patch - changes with repairs; may be NULL

  Level: intermediate

.seealso: SlipStepGetVersion(), PetscGetVersionNumber()
@*/
PetscErrorCode SlipStepGetVersionNumber(PetscInt *major, PetscInt *minor, PetscInt *patch)
{
  PetscFunctionBegin;
  if (major) *major = SLIPSTEP_VERSION_MAJOR;
  if (minor) *minor = SLIPSTEP_VERSION_MINOR;
  if (patch) *patch = SLIPSTEP_VERSION_PATCH;
  PetscFunctionReturn(PETSC_SUCCESS);
}
