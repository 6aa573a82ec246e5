/* The whole of a distributed vector on every rank. Operators that every rank applies to the whole field give the same
   numbers at every rank count. */
#include <slipmat.h>
#include <slipstep/private/slipcompat.h>
#include <slipstep/private/slipmat.h>

PetscErrorCode SlipGatherCreate(Mat A, SlipGather *g)
{
  PetscMPIInt size;
  Vec x;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)A), &size));
  PetscCall(MatGetSize(A, &g->N, NULL));
  PetscCall(MatGetOwnershipRange(A, &g->start, &g->end));
  if (size > 1) {
    PetscCall(MatCreateVecs(A, &x, NULL));
    PetscCall(VecScatterCreateToAll(x, &g->scatter, &g->all));
    PetscCall(VecDestroy(&x));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipGatherDestroy(SlipGather *g)
{
  PetscFunctionBegin;
  PetscCall(VecScatterDestroy(&g->scatter));
  PetscCall(VecDestroy(&g->all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipGatherGet(SlipGather *g, Vec x, const PetscReal **array)
{
  PetscFunctionBegin;
  if (g->scatter) {
    PetscCall(VecScatterBegin(g->scatter, x, g->all, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecScatterEnd(g->scatter, x, g->all, INSERT_VALUES, SCATTER_FORWARD));
  }
  PetscCall(VecGetArrayRead(g->scatter ? g->all : x, array));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipGatherRestore(SlipGather *g, Vec x, const PetscReal **array)
{
  PetscFunctionBegin;
  PetscCall(VecRestoreArrayRead(g->scatter ? g->all : x, array));
  PetscFunctionReturn(PETSC_SUCCESS);
}
