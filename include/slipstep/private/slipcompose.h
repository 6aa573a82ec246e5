/* Data of the library's own that an object of PETSc's carries under a name, and frees when it goes. */
#pragma once
#include <petscsys.h>
#include <slipstep/private/slipcompat.h>

/* Takes data over, in place of what had the name. destroy: SlipContainerDestroyDefault for memory of PetscMalloc() */
PETSC_INTERN PetscErrorCode SlipObjectComposeData(PetscObject obj, const char name[], void *data,
                                                  PetscErrorCode (*destroy)(SlipContainerArg));
/* data: address of a pointer, borrowed; NULL when there is nothing of that name */
PETSC_INTERN PetscErrorCode SlipObjectQueryData(PetscObject obj, const char name[], void *data);
