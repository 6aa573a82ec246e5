/* Registrations with PETSc that happen once between PetscInitialize() and PetscFinalize() */
#include <slipstep/private/slipsys.h>
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
