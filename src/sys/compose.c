/* Attaches data to PETSc objects (PetscObjectContainerCompose() of later PETSc releases). */
#include <slipstep/private/slipsys.h>

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
