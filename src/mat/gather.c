/* The whole of a distributed vector on every rank, for small fields; or the rows of cells that a rank transforms. Either
   way operators give the same numbers at every rank count. */
#include <slipmat.h>
#include <slipstep/private/slipcompat.h>
#include <slipstep/private/slipmat.h>

/* pencil: NULL for the whole. Collective. */
PetscErrorCode SlipGatherCreate(Mat A, SlipPencil pencil, SlipGather *g)
{
  PetscMPIInt size;
  Vec x;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)A), &size));
  PetscCall(MatGetSize(A, &g->N, NULL));
  PetscCall(MatGetOwnershipRange(A, &g->start, &g->end));
  if (size > 1) {
    PetscCall(MatCreateVecs(A, &x, NULL));
    if (pencil) {
      const PetscInt n = pencil->layout.rows * pencil->nx;
      IS from;

      g->rows = PETSC_TRUE;
      PetscCall(VecCreateSeq(PETSC_COMM_SELF, n, &g->all));
      PetscCall(ISCreateStride(PETSC_COMM_SELF, n, pencil->layout.row_start * pencil->nx, 1, &from));
      PetscCall(VecScatterCreate(x, from, g->all, NULL, &g->scatter));
      PetscCall(ISDestroy(&from));
    } else
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

/* y from what SlipGatherGet() gave the shape of. Collective. */
PetscErrorCode SlipGatherPut(SlipGather *g, const PetscReal array[], Vec y)
{
  PetscReal *py;
  PetscInt n;

  PetscFunctionBegin;
  if (g->rows) {
    PetscCall(VecGetLocalSize(g->all, &n));
    PetscCall(VecGetArrayWrite(g->all, &py));
    PetscCall(PetscArraycpy(py, array, n));
    PetscCall(VecRestoreArrayWrite(g->all, &py));
    PetscCall(VecScatterBegin(g->scatter, g->all, y, INSERT_VALUES, SCATTER_REVERSE));
    PetscCall(VecScatterEnd(g->scatter, g->all, y, INSERT_VALUES, SCATTER_REVERSE));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecGetArrayWrite(y, &py));
  PetscCall(PetscArraycpy(py, array + g->start, g->end - g->start));
  PetscCall(VecRestoreArrayWrite(y, &py));
  PetscFunctionReturn(PETSC_SUCCESS);
}
