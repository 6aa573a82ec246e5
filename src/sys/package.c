/* Registrations with PETSc that happen once between PetscInitialize() and PetscFinalize(), data attached to its objects
   (PetscObjectContainerCompose() of later releases), and the version at run time, for programs that were linked with
   another one */
#include <slipcompat.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/rooms/slipsys.h>
#include <petsctime.h>

enum { SLIP_MAX_PACKAGES = 16 };

static PetscErrorCode (*SlipRegistered[SLIP_MAX_PACKAGES])(void);
static PetscInt SlipNumRegistered;
static PetscLogDouble SlipStartTime; /* time of the first registration */

/* A program may finalize PETSc and initialize it again, which removes all that was registered. */
static PetscErrorCode SlipForgetRegistered(void)
{
  SlipNumRegistered = 0;
  return PETSC_SUCCESS;
}

PetscErrorCode SlipRegisterOnce(PetscErrorCode (*registers)(void))
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < SlipNumRegistered; i++)
    if (SlipRegistered[i] == registers) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(SlipNumRegistered < SLIP_MAX_PACKAGES, PETSC_COMM_SELF, PETSC_ERR_PLIB, "more than %d packages",
             SLIP_MAX_PACKAGES);
  if (!SlipNumRegistered) {
    PetscCall(PetscRegisterFinalize(SlipForgetRegistered));
    PetscCall(PetscTime(&SlipStartTime));
  }
  SlipRegistered[SlipNumRegistered++] = registers; /* set before the call, which may call this function again */
  PetscCall((*registers)());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipGetStartTime(PetscLogDouble *time)
{
  PetscFunctionBegin;
  *time = SlipStartTime;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Each process has its own container, because one process may have data where another has none. */
PetscErrorCode SlipObjectComposeData(PetscObject obj, const char name[], void *data,
                                     PetscErrorCode (*destroy)(SlipContainerArg))
{
  PetscContainer container;

  PetscFunctionBegin;
  PetscCall(PetscContainerCreate(PETSC_COMM_SELF, &container));
  PetscCall(PetscContainerSetPointer(container, data));
  PetscCall(SlipContainerSetDestroy(container, destroy));
  PetscCall(PetscObjectCompose(obj, name, (PetscObject)container));
  PetscCall(PetscContainerDestroy(&container));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipObjectQueryData(PetscObject obj, const char name[], void *data)
{
  PetscContainer container;
  void *pointer = NULL;

  PetscFunctionBegin;
  PetscCall(PetscObjectQuery(obj, name, (PetscObject *)&container));
  if (container) PetscCall(PetscContainerGetPointer(container, &pointer));
  *(void **)data = pointer;
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
