/* Work that the ranks of a communicator share: counters on rank 0 that all of them raise, so that each takes the next
   job when it is free. */
#pragma once
#include <petscsys.h>

typedef struct {
  MPI_Win window;
  int *counter; /* [n], rank 0's */
} Queue;

PETSC_INTERN PetscErrorCode QueueCreate(MPI_Comm comm, PetscMPIInt n, Queue *q); /* n counters at 0; collective */
PETSC_INTERN PetscErrorCode QueueRaise(Queue *q, PetscMPIInt counter, int add, PetscInt *before); /* its value before */
PETSC_INTERN PetscErrorCode QueueDestroy(Queue *q);                                               /* collective */
