/* What is registered with PETSc once, from PetscInitialize() to PetscFinalize(). */
#include <slipstep/private/slipsys.h>

#define SLIP_MAX_PACKAGES 16

static PetscBool *SlipRegistered[SLIP_MAX_PACKAGES];
static PetscInt SlipNumRegistered;

/* A program may finalize PETSc and initialize it again: what was registered is gone then. */
static PetscErrorCode SlipForgetRegistered(void)
{
  PetscFunctionBegin;
  while (SlipNumRegistered) *SlipRegistered[--SlipNumRegistered] = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Shall the caller, for which the flag stands, register now? True once, until PetscFinalize(). */
PetscErrorCode SlipRegisterOnce(PetscBool *flag, PetscBool *now)
{
  PetscFunctionBegin;
  *now = *flag ? PETSC_FALSE : PETSC_TRUE;
  if (*flag) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(SlipNumRegistered < SLIP_MAX_PACKAGES, PETSC_COMM_SELF, PETSC_ERR_PLIB, "more than %d packages",
             SLIP_MAX_PACKAGES);
  if (!SlipNumRegistered) PetscCall(PetscRegisterFinalize(SlipForgetRegistered));
  SlipRegistered[SlipNumRegistered++] = flag;
  *flag = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
