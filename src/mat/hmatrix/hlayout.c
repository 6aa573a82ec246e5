/* Which process has which blocks of a hierarchical matrix. Each process needs the clusters of all blocks and the owners
   of all cells while it computes its own, so that the processes of a machine hold them once: the first one computes. */
#include <petscmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmathmatrix.h>

/* Computes all of it on one process. */
static PetscErrorCode Compute(const SlipCells *cells, PetscBool whole, PetscReal tolerance, PetscLayout rows,
                              SlipHLayout *layout)
{
  const PetscInt N = cells->n, each = rows->N / N;
  PetscMPIInt *owner;
  PetscInt *row;

  PetscFunctionBegin;
  PetscCall(SlipHPairsCreate(cells, whole, &layout->tree, &layout->list));
  PetscCall(PetscMalloc1(N, &layout->order));
  PetscCall(PetscMalloc2(N, &row, N, &owner));
  for (PetscInt i = 0; i < N; i++) row[SlipCellsAt(cells, i)] = i;
  for (PetscInt i = 0; i < N; i++) {
    layout->order[i] = row[layout->tree.perm[i]];
    PetscCall(PetscLayoutFindOwner(rows, each * layout->order[i], &owner[i]));
  }
  PetscCall(SlipHPairsAssign(&layout->tree, &layout->list, tolerance, owner, rows->size, &layout->parts));
  PetscCall(PetscFree2(row, owner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the layout of a matrix with these rows, one or more for each cell. Collective. */
PetscErrorCode SlipHLayoutCreate(PetscLayout rows, const SlipCells *cells, PetscBool whole, PetscReal tolerance,
                                 SlipHLayout *layout)
{
  SlipHParts *parts = &layout->parts;
  PetscInt number[2] = {0, 0}; /* of nodes and of blocks */
  size_t all = 0;              /* parts */

  PetscFunctionBegin;
  *layout = (SlipHLayout){.shared = NULL};
  PetscCall(SlipSharedCreate(rows->comm, &layout->shared));
  if (SlipSharedFirst(layout->shared)) {
    PetscCall(Compute(cells, whole, tolerance, rows, layout));
    number[0] = layout->tree.nnodes;
    number[1] = layout->list.n;
    all = (size_t)parts->first[layout->list.n];
  }
  PetscCall(SlipSharedValues(layout->shared, 2, number));
  layout->tree.nnodes = number[0];
  layout->list.n = number[1];
  PetscCall(SlipSharedMove(layout->shared, (size_t)cells->n * sizeof(*layout->tree.perm), &layout->tree.perm));
  PetscCall(SlipSharedMove(layout->shared, (size_t)number[0] * sizeof(*layout->tree.node), &layout->tree.node));
  PetscCall(SlipSharedMove(layout->shared, (size_t)number[1] * sizeof(*layout->list.pair), &layout->list.pair));
  PetscCall(SlipSharedMove(layout->shared, (size_t)cells->n * sizeof(*layout->order), &layout->order));
  PetscCall(SlipSharedMove(layout->shared, (size_t)(number[1] + 1) * sizeof(*parts->first), &parts->first));
  PetscCall(SlipSharedMove(layout->shared, all * sizeof(*parts->keeper), &parts->keeper));
  PetscCall(SlipSharedMove(layout->shared, all * sizeof(*parts->block), &parts->block));
  PetscCall(SlipSharedMove(layout->shared, (size_t)(rows->size + 2) * sizeof(*parts->start), &parts->start));
  SlipMemoryReturn();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipHLayoutDestroy(SlipHLayout *layout)
{
  PetscFunctionBegin;
  PetscCall(SlipSharedDestroy(&layout->shared));
  *layout = (SlipHLayout){.shared = NULL};
  PetscFunctionReturn(PETSC_SUCCESS);
}
