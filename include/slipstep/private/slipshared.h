/* Internal: arrays that the processes of a machine hold once */
#pragma once
#include <slipstep/rooms/slipsys.h>

PETSC_EXTERN PetscErrorCode SlipSharedCreate(MPI_Comm comm, SlipShared *shared);
PETSC_EXTERN PetscErrorCode SlipSharedDestroy(SlipShared *shared);
PETSC_EXTERN PetscErrorCode SlipSharedMalloc(SlipShared shared, size_t bytes, void *array);
PETSC_EXTERN PetscErrorCode SlipSharedFree(SlipShared shared, void *array);
PETSC_EXTERN PetscBool SlipSharedFills(SlipShared shared, const void *array);
PETSC_EXTERN void SlipSharedSlice(SlipShared shared, const void *array, PetscInt n, PetscInt *start, PetscInt *end);
PETSC_EXTERN PetscErrorCode SlipSharedReady(SlipShared shared);
PETSC_EXTERN PetscErrorCode SlipSharedBcast(SlipShared shared, void *array, PetscInt n, MPI_Datatype type);
PETSC_EXTERN PetscErrorCode SlipSharedMove(SlipShared shared, size_t bytes, void *array);
PETSC_EXTERN PetscErrorCode SlipSharedValues(SlipShared shared, PetscInt n, PetscInt values[]);
PETSC_EXTERN PetscBool SlipSharedFirst(SlipShared shared);
PETSC_EXTERN PetscReal SlipSharedMachineBytes(SlipShared shared);

#define SlipSharedMalloc1(shared, n, array)                                                                            \
  SlipSharedMalloc(shared, (size_t)PetscMax(n, 1) * sizeof(**(array)), (void *)(array))
