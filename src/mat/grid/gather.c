/* Gathers a whole distributed vector on every rank, for small fields, or the rows of cells that a rank transforms. In
   both cases the results of operators do not depend on the number of ranks. */
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatgrid.h>

/* Creates a gather. With a pencil it gathers A's rows, one or several per cell, of the pencil's cells; NULL: all of a
   vector that A multiplies. Collective. */
PetscErrorCode SlipGatherCreate(Mat A, SlipTransposedFFT pencil, SlipGather *g)
{
  PetscMPIInt size;
  Vec x;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)A), &size));
  PetscCall(MatGetSize(A, &g->N, NULL));
  PetscCall(MatGetOwnershipRange(A, &g->start, &g->end));
  if (size > 1) {
    PetscCall(MatCreateVecs(A, pencil ? NULL : &x, pencil ? &x : NULL));
    if (pencil) {
      const PetscInt cell = g->N / (pencil->nx * pencil->nz), n = pencil->layout.rows * pencil->nx * cell;
      IS from;

      g->rows = PETSC_TRUE;
      PetscCall(VecCreateSeq(PETSC_COMM_SELF, n, &g->all));
      PetscCall(ISCreateStride(PETSC_COMM_SELF, n, pencil->layout.row_start * pencil->nx * cell, 1, &from));
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

/* Sets y from an array of the shape of SlipGatherGet(). Collective. */
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

/* Returns the memory of a gather on this process. */
PetscReal SlipGatherBytes(const SlipGather *g)
{
  PetscInt n = 0;

  if (g->all) (void)VecGetLocalSize(g->all, &n);
  return (PetscReal)sizeof(PetscReal) * (PetscReal)n;
}
