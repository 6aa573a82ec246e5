/* Which process has which blocks of a hierarchical matrix. Each process needs the clusters of all blocks and the owners
   of all cells while it computes its own, so that the processes of a machine hold them once: the first one computes. */
#include <petscmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmathmatrix.h>

/* Finds the process that owns a row. ranges [size + 1]: the first row of each */
static PetscMPIInt Owner(PetscMPIInt size, const PetscInt ranges[], PetscInt row)
{
  PetscMPIInt low = 0, top = size - 1;

  while (low < top) {
    const PetscMPIInt middle = (low + top + 1) / 2;

    if (ranges[middle] <= row)
      low = middle;
    else
      top = middle - 1;
  }
  return low;
}

/* Computes all of it on one process. */
static PetscErrorCode Compute(const SlipCells *cells, PetscBool whole, PetscReal tolerance, PetscMPIInt size,
                              const PetscInt ranges[], SlipHLayout *layout)
{
  const PetscInt N = cells->n;
  PetscMPIInt *owner;
  PetscInt *row;

  PetscFunctionBegin;
  PetscCall(SlipHPairsCreate(cells, whole, &layout->tree, &layout->list));
  PetscCall(PetscMalloc1(N, &layout->order));
  PetscCall(PetscMalloc2(N, &row, N, &owner));
  for (PetscInt i = 0; i < N; i++) row[SlipCellsAt(cells, i)] = i;
  for (PetscInt i = 0; i < N; i++) {
    layout->order[i] = row[layout->tree.perm[i]];
    owner[i] = Owner(size, ranges, layout->order[i]);
  }
  PetscCall(SlipHPairsAssign(&layout->tree, &layout->list, tolerance, owner, size, &layout->parts));
  PetscCall(PetscFree2(row, owner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the layout for the processes of comm. ranges [processes + 1]: the first cell's row of each. Collective. */
PetscErrorCode SlipHLayoutCreate(MPI_Comm comm, const SlipCells *cells, PetscBool whole, PetscReal tolerance,
                                 const PetscInt ranges[], SlipHLayout *layout)
{
  SlipHParts *parts = &layout->parts;
  PetscMPIInt size;
  PetscInt number[2] = {0, 0}; /* of nodes and of blocks */
  size_t all = 0;              /* parts */

  PetscFunctionBegin;
  *layout = (SlipHLayout){.shared = NULL};
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(SlipSharedCreate(comm, &layout->shared));
  if (SlipSharedFirst(layout->shared)) {
    PetscCall(Compute(cells, whole, tolerance, size, ranges, layout));
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
  PetscCall(SlipSharedMove(layout->shared, (size_t)(size + 2) * sizeof(*parts->start), &parts->start));
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
