/* Counters that ranks share, see queue.h. */
#include "queue.h"
#include <slipcompat.h>

PetscErrorCode QueueCreate(MPI_Comm comm, PetscMPIInt n, Queue *q)
{
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Win_allocate((MPI_Aint)((rank ? 0 : n) * (int)sizeof(int)), (int)sizeof(int), MPI_INFO_NULL, comm,
                                &q->counter, &q->window));
  for (PetscMPIInt i = 0; !rank && i < n; ++i) q->counter[i] = 0;
  PetscCallMPI(MPI_Barrier(comm));
  PetscCallMPI(MPI_Win_lock_all(0, q->window));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode QueueRaise(Queue *q, PetscMPIInt counter, int add, PetscInt *before)
{
  int value = 0;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Fetch_and_op(&add, &value, MPI_INT, 0, counter, MPI_SUM, q->window));
  PetscCallMPI(MPI_Win_flush(0, q->window));
  *before = value;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode QueueDestroy(Queue *q)
{
  PetscFunctionBegin;
  PetscCallMPI(MPI_Win_unlock_all(q->window));
  PetscCallMPI(MPI_Win_free(&q->window));
  PetscFunctionReturn(PETSC_SUCCESS);
}
