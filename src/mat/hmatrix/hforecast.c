/* Predicts from a mesh what each of some number of processes will store, exchange and compute, before anything is
   assembled: the blocks are those that hmatrix.c creates, and their ranks follow from the tolerance. */
#include <petscmat.h>
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmathmatrix.h>

/* Adds the work of a block, or of one of n parts of its terms. both: it is its transpose, too; c: components */
static void AddBlock(const SlipClusterTree *tree, const SlipHPair *pair, PetscReal n, PetscBool both, PetscReal rows,
                     PetscReal columns, PetscReal tolerance, SlipCellsForecast *f)
{
  const SlipCluster *p = &tree->node[pair->a], *q = &tree->node[pair->b];
  const PetscReal cells[2] = {(PetscReal)(p->end - p->start), (PetscReal)(q->end - q->start)};
  const PetscReal m = rows * cells[0], k = columns * cells[1], more = columns - 1;
  /* blocks of vectors have 1.46 and 1.53 times the terms at 1e-4 and 1e-6, and 1.16 and 1.12 times the pairs are
     computed (8,000 triangles of a bent fault, two components) */
  const PetscReal all = m * k, terms = (1 + 0.5 * more) * SlipHRank(tolerance), low = terms * (m + k);
  const PetscBool compressed = pair->low && low < all ? PETSC_TRUE : PETSC_FALSE;
  const PetscReal numbers = (compressed ? low : all) / n, digits = -PetscLog10Real(tolerance);
  /* of near blocks the numbers that are in double precision: none at 1e-4, 0.43 of them at 1e-8 (measured) */
  const PetscReal doubles = pair->a == pair->b ? 1 : compressed ? 0 : 0.107 * PetscMax(digits - 4, 0);

  f->bytes += numbers * (PetscReal)(sizeof(float) + doubles * (sizeof(PetscReal) - sizeof(float)));
  f->flops += 2 * numbers * (both && pair->a != pair->b ? 2 : 1);
  if (compressed)
    f->pairs += (1 + 0.14 * more) * SlipHSearched(tolerance) * (cells[0] + cells[1]) / n;
  else
    f->pairs += cells[0] * cells[1] / n;
}

/* Predicts K, or Kn if whole, for size processes. order [n], count [size]: cells of each process, one after the
   other; forecast [size]: is added to */
PetscErrorCode SlipHMatForecast(const SlipCells *cells, PetscBool whole, PetscReal tolerance, PetscMPIInt size,
                                const PetscInt order[], const PetscInt count[], SlipCellsForecast forecast[])
{
  const PetscInt N = cells->n, c = cells->kernel.type->components;
  const PetscReal rows = whole ? 1 : (PetscReal)c, columns = (PetscReal)c;
  const SlipKernelLanes *lanes = SlipKernelGetLanes(&cells->kernel);
  SlipClusterTree tree;
  PetscMPIInt *owner;
  SlipHPairs list;
  SlipHParts parts;
  PetscInt *place;
  PetscReal held; /* by a machine */

  PetscFunctionBegin;
  PetscCall(SlipHPairsCreate(cells, whole, &tree, &list));
  PetscCall(PetscMalloc2(N, &owner, N, &place));
  for (PetscInt i = 0; i < N; i++) place[tree.perm[i]] = i;
  for (PetscInt r = 0, i = 0; r < size; r++)
    for (const PetscInt end = i + count[r]; i < end; i++) owner[place[order[i]]] = (PetscMPIInt)r;
  PetscCall(SlipHPairsAssign(&tree, &list, tolerance, owner, size, &parts));
  held = (PetscReal)N * (PetscReal)(2 * sizeof(PetscInt) + sizeof(PetscReal) * (size_t)(lanes ? lanes->numbers : 0)) +
         (PetscReal)(cells->vertices ? 9 * sizeof(PetscReal) : 0) * (PetscReal)N +
         (PetscReal)tree.nnodes * (PetscReal)sizeof(*tree.node) + (PetscReal)list.n * (PetscReal)sizeof(*list.pair) +
         (PetscReal)parts.first[list.n] * (PetscReal)(sizeof(*parts.keeper) + sizeof(*parts.block));
  for (PetscMPIInt r = 0; r < size; r++) {
    SlipCellsForecast *f = &forecast[r];

    f->machine = held;
    f->cells = (PetscReal)count[r];
    f->blocks += (PetscReal)(parts.start[r + 1] - parts.start[r]);
    for (PetscInt k = parts.start[r]; k < parts.start[r + 1]; k++) {
      const PetscInt i = parts.block[k];

      AddBlock(&tree, &list.pair[i], (PetscReal)(parts.first[i + 1] - parts.first[i]), (PetscBool)!whole, rows, columns,
               tolerance, f);
    }
    for (int side = 0; side < 2; side++) { /* rows, columns; of a stiffness both are the same */
      const PetscReal each = side ? columns : rows;
      SlipHRuns runs;

      PetscCall(
        SlipHRunsCreate(&tree, &list, &parts, r, (PetscBool)(!whole || !side), (PetscBool)(!whole || side), &runs));
      f->touched += each * (PetscReal)runs.cells;
      for (PetscInt k = 0; k < runs.n; k++)
        for (PetscInt i = runs.run[k].start; i < runs.run[k].end; i++)
          if (owner[i] != r) f->foreign += each;
      PetscCall(PetscFree(runs.run));
    }
  }
  PetscCall(PetscFree2(owner, place));
  PetscCall(SlipHPartsDestroy(&parts));
  PetscCall(PetscFree(list.pair));
  PetscCall(SlipClusterTreeDestroy(&tree));
  PetscFunctionReturn(PETSC_SUCCESS);
}
