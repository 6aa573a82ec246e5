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
  const PetscReal m = rows * (PetscReal)(p->end - p->start), k = columns * (PetscReal)(q->end - q->start);
  const PetscReal all = m * k, terms = SlipHRank(tolerance), low = terms * (m + k);
  const PetscBool compressed = pair->low && low < all ? PETSC_TRUE : PETSC_FALSE;
  const PetscReal numbers = (compressed ? low : all) / n, digits = -PetscLog10Real(tolerance);
  /* of near blocks the numbers that are in double precision: none at 1e-4, 0.43 of them at 1e-8 (measured) */
  const PetscReal doubles = pair->a == pair->b ? 1 : compressed ? 0 : 0.107 * PetscMax(digits - 4, 0);

  f->bytes += numbers * (PetscReal)(sizeof(float) + doubles * (sizeof(PetscReal) - sizeof(float)));
  f->flops += 2 * numbers * (both && pair->a != pair->b ? 2 : 1);
  if (compressed)
    f->entries += SlipHSearched(tolerance) * (m + k) / n;
  else
    f->entries += all / n + (pair->low ? low : 0);
}

/* Predicts K, or Kn if whole, for size processes. order [n], count [size]: cells of each process, one after the
   other; forecast [size]: is added to */
PetscErrorCode SlipHMatForecast(const SlipCells *cells, PetscBool whole, PetscReal tolerance, PetscMPIInt size,
                                const PetscInt order[], const PetscInt count[], SlipCellsForecast forecast[])
{
  const PetscInt N = cells->n, c = cells->kernel.type->components;
  const PetscReal rows = whole ? 1 : (PetscReal)c, columns = (PetscReal)c;
  PetscInt *place, *change, *next, *part, depth;
  SlipClusterTree tree;
  PetscMPIInt *owner;
  SlipHPairs list;
  SlipHParts parts;

  PetscFunctionBegin;
  PetscCall(SlipHPairsCreate(cells, whole, &tree, &list));
  PetscCall(PetscMalloc4(N, &owner, N, &place, N + 1, &change, size + 1, &next));
  for (PetscInt i = 0; i < N; i++) place[tree.perm[i]] = i;
  for (PetscInt r = 0, i = 0; r < size; r++)
    for (const PetscInt end = i + count[r]; i < end; i++) owner[place[order[i]]] = (PetscMPIInt)r;
  PetscCall(SlipHPairsAssign(&tree, &list, tolerance, owner, size, &parts));
  /* sort the parts by process */
  PetscCall(PetscMalloc1(parts.first[list.n], &part));
  PetscCall(PetscArrayzero(next, size + 1));
  for (PetscInt k = 0; k < parts.first[list.n]; k++) next[parts.keeper[k] + 1]++;
  for (PetscMPIInt r = 0; r < size; r++) next[r + 1] += next[r];
  for (PetscInt i = 0; i < list.n; i++)
    for (PetscInt k = parts.first[i]; k < parts.first[i + 1]; k++) part[next[parts.keeper[k]]++] = i;
  for (PetscInt r = 0, k = 0; r < size; k = next[r], r++) {
    SlipCellsForecast *f = &forecast[r];

    f->cells = (PetscReal)count[r];
    f->blocks += (PetscReal)(next[r] - k);
    for (PetscInt j = k; j < next[r]; j++) {
      const PetscInt i = part[j];

      AddBlock(&tree, &list.pair[i], (PetscReal)(parts.first[i + 1] - parts.first[i]), (PetscBool)!whole, rows, columns,
               tolerance, f);
    }
    for (int side = 0; side < 2; side++) { /* rows, columns; of a stiffness both are the same */
      PetscCall(PetscArrayzero(change, N + 1));
      for (PetscInt j = k; j < next[r]; j++)
        for (int end = 0; end < 2; end++) {
          const SlipCluster *p = &tree.node[end ? list.pair[part[j]].b : list.pair[part[j]].a];

          if (whole && end != side) continue;
          change[p->start]++;
          change[p->end]--;
        }
      depth = 0;
      for (PetscInt i = 0; i < N; i++) {
        const PetscReal each = side ? columns : rows;

        depth += change[i];
        if (!depth) continue;
        f->touched += each;
        if (owner[i] != r) f->foreign += each;
      }
    }
  }
  PetscCall(PetscFree(part));
  PetscCall(PetscFree4(owner, place, change, next));
  PetscCall(SlipHPartsDestroy(&parts));
  PetscCall(PetscFree(list.pair));
  PetscCall(SlipClusterTreeDestroy(&tree));
  PetscFunctionReturn(PETSC_SUCCESS);
}
