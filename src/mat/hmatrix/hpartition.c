/*
  The blocks of a hierarchical matrix, and which process computes, stores and applies each of them.

  A process owns some of the block's rows or, by symmetry, of its columns: this is a distribution by rows except for the
  half that symmetry saves. Of several such processes the one with the least expected work so far is chosen. The terms
  of a low-rank block that is a large part of the mean work are divided among several of them. Blocks do not depend on
  the number of processes, so that results agree to rounding.
*/
#include <petscmat.h>
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmathmatrix.h>

#define HMAT_LEAF 48 /* cells in a leaf of the cluster tree */
/* A block is low-rank if the smaller diameter is at most this many distances. Entries of dipping cells take ten times
   as long: two planes of 8000 cells took 16 % less time and memory with 2 than with 1.5. */
#define HMAT_ADMISSIBLE 1.5
#define HMAT_ADMISSIBLE_DIPPING 2
#define HMAT_USUAL 1e-4 /* the tolerance for which cells are distributed */
/* The terms of a block are divided where its work is more than this share of the mean work of a process. */
#define HMAT_DIVIDE 0.5
/* To receive and send the numbers of a cell takes as long as so many numbers of the matrix (8 + 8 bytes over a network
   of some GB/s). */
#define HMAT_TOUCH 4

/* ---- the blocks ---- */

/* Lists pairs of clusters that cover all of a x b, or only its upper triangle if a == b and not whole. */
static PetscErrorCode Partition(const SlipClusterTree *tree, PetscBool whole, PetscInt a, PetscInt b, SlipHPairs *list)
{
  const SlipCluster *p = &tree->node[a], *q = &tree->node[b];
  const PetscReal smaller = PetscMin(p->diameter, q->diameter);
  const PetscBool far = a != b && smaller <= list->admissible * SlipClusterDistance(p, q) ? PETSC_TRUE : PETSC_FALSE;
  SlipHPair *more;

  PetscFunctionBegin;
  if (far || (p->child[0] < 0 && q->child[0] < 0)) {
    if (list->n == list->capacity) {
      PetscCall(PetscMalloc1(2 * list->capacity + 64, &more));
      PetscCall(PetscArraycpy(more, list->pair, list->n));
      PetscCall(PetscFree(list->pair));
      list->pair = more;
      list->capacity = 2 * list->capacity + 64;
    }
    list->pair[list->n++] = (SlipHPair){a, b, far};
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (int i = 0; i < (p->child[0] < 0 ? 1 : 2); i++)
    for (int j = 0; j < (q->child[0] < 0 ? 1 : 2); j++) {
      if (!whole && a == b && j < i) continue;
      PetscCall(Partition(tree, whole, p->child[0] < 0 ? a : p->child[i], q->child[0] < 0 ? b : q->child[j], list));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the cluster tree and the pairs of clusters of all blocks, or only of those on and above the diagonal. */
PetscErrorCode SlipHPairsCreate(const SlipCells *cells, PetscBool whole, SlipClusterTree *tree, SlipHPairs *list)
{
  PetscFunctionBegin;
  *list = (SlipHPairs){.admissible = cells->dip ? HMAT_ADMISSIBLE_DIPPING : HMAT_ADMISSIBLE};
  PetscCall(SlipClusterTreeCreate(cells, HMAT_LEAF, tree));
  PetscCall(Partition(tree, whole, 0, 0, list));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal SlipHRank(PetscReal tolerance)
{
  return 0.8 * PetscSqr(PetscLog10Real(tolerance));
}

/* The search goes on to a share of the tolerance, and ends after some rows for confirmation (aca.c). */
PetscReal SlipHSearched(PetscReal tolerance)
{
  return 1.08 * SlipHRank(0.3 * tolerance) + 5;
}

/* Returns the expected storage of a pair's block, in numbers of scalar slip. */
PetscReal SlipHPairCost(const SlipClusterTree *tree, const SlipHPair *pair, PetscReal tolerance)
{
  const SlipCluster *p = &tree->node[pair->a], *q = &tree->node[pair->b];
  const PetscReal m = (PetscReal)(p->end - p->start), n = (PetscReal)(q->end - q->start);

  return pair->low ? PetscMin(SlipHRank(tolerance) * (m + n), m * n) : m * n;
}

/* Computes cost [n], each cell's share of the storage of its blocks. */
PetscErrorCode SlipHMatCosts(const SlipCells *cells, PetscReal cost[])
{
  SlipClusterTree tree;
  SlipHPairs list;

  PetscFunctionBegin;
  PetscCall(SlipHPairsCreate(cells, PETSC_FALSE, &tree, &list));
  PetscCall(PetscArrayzero(cost, cells->n));
  for (PetscInt i = 0; i < list.n; i++) {
    const PetscReal half = 0.5 * SlipHPairCost(&tree, &list.pair[i], HMAT_USUAL);

    for (int side = 0; side < 2; side++) {
      const SlipCluster *p = &tree.node[side ? list.pair[i].b : list.pair[i].a];

      for (PetscInt k = p->start; k < p->end; k++) cost[tree.perm[k]] += half / (PetscReal)(p->end - p->start);
    }
  }
  PetscCall(PetscFree(list.pair));
  PetscCall(SlipClusterTreeDestroy(&tree));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the processes ---- */

/* Finds the processes that own rows of a pair's clusters, and what their blocks touch so far, by pieces of PIECE cells
   in the tree's order. */
#define PIECE 32
typedef struct {
  const SlipClusterTree *tree;
  const PetscMPIInt *owner; /* [N] of each cell in the tree's order */
  PetscInt *next;           /* [N] the next cell of another owner */
  PetscInt *seen;           /* [size] the last search that has found each process */
  PetscReal *load;          /* [size] work so far, in numbers of the matrix */
  PetscInt search, pieces;
  char *touched;               /* [size][pieces] */
  PetscMPIInt size, n, *found; /* found [n] */
} Candidates;

static PetscErrorCode CandidatesCreate(const SlipClusterTree *tree, const PetscMPIInt owner[], PetscMPIInt size,
                                       Candidates *c)
{
  const PetscInt N = tree->node[0].end;

  PetscFunctionBegin;
  *c = (Candidates){.tree = tree, .owner = owner, .size = size, .pieces = (N + PIECE - 1) / PIECE};
  PetscCall(PetscMalloc2(N, &c->next, size, &c->found));
  PetscCall(PetscCalloc3(size, &c->seen, size, &c->load, (size_t)size * c->pieces, &c->touched));
  for (PetscInt i = N - 1; i >= 0; i--) c->next[i] = i + 1 < N && owner[i + 1] == owner[i] ? c->next[i + 1] : i + 1;
  for (PetscInt i = 0; i < N; i++) c->touched[(size_t)owner[i] * c->pieces + i / PIECE] = 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CandidatesDestroy(Candidates *c)
{
  PetscFunctionBegin;
  PetscCall(PetscFree2(c->next, c->found));
  PetscCall(PetscFree3(c->seen, c->load, c->touched));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Find(Candidates *c, const SlipHPair *pair)
{
  c->n = 0;
  c->search++;
  for (int side = 0; side < 2; side++) {
    const SlipCluster *p = &c->tree->node[side ? pair->b : pair->a];

    for (PetscInt k = p->start; k < p->end && c->n < c->size; k = c->next[k]) {
      const PetscMPIInt r = c->owner[k];

      if (c->seen[r] == c->search) continue;
      c->seen[r] = c->search;
      c->found[c->n++] = r;
    }
  }
}

/* Counts the cells of a pair that a process does not touch yet, to a piece, and marks them if asked. */
static PetscReal Untouched(Candidates *c, const SlipHPair *pair, PetscMPIInt r, PetscBool mark)
{
  char *touched = c->touched + (size_t)r * c->pieces;
  PetscInt pieces = 0;

  for (int side = 0; side < 2; side++) {
    const SlipCluster *p = &c->tree->node[side ? pair->b : pair->a];

    for (PetscInt k = p->start / PIECE; k <= (p->end - 1) / PIECE; k++) {
      pieces += !touched[k];
      if (mark) touched[k] = 1;
    }
  }
  return PIECE * (PetscReal)pieces;
}

/* Gives a part of a pair's block, of some cost, to the candidate that will have the least work with it, of equal ones
   to the first process, and moves that to the end of the list. */
static PetscMPIInt Give(Candidates *c, const SlipHPair *pair, PetscReal cost)
{
  PetscReal least = PETSC_MAX_REAL;
  PetscMPIInt best = 0, r;

  for (PetscMPIInt k = 0; k < c->n; k++) {
    const PetscMPIInt s = c->found[k];
    PetscReal load = c->load[s];

    if (load > least) continue;
    load += HMAT_TOUCH * Untouched(c, pair, s, PETSC_FALSE);
    if (load > least || (load == least && s > c->found[best])) continue;
    least = load;
    best = k;
  }
  r = c->found[best];
  c->load[r] += cost + HMAT_TOUCH * Untouched(c, pair, r, PETSC_TRUE);
  c->found[best] = c->found[--c->n];
  c->found[c->n] = r;
  return r;
}

/* Assigns the parts of all blocks to `size` processes, the same on each of them. owner [N]: the process that owns each
   cell of the tree's order. */
PetscErrorCode SlipHPairsAssign(const SlipClusterTree *tree, const SlipHPairs *list, PetscReal tolerance,
                                const PetscMPIInt owner[], PetscMPIInt size, SlipHParts *parts)
{
  enum { ALONE, LARGE, SMALL, NUM };
  PetscReal mean = 0;
  Candidates c;
  char *kind;

  PetscFunctionBegin;
  PetscCall(CandidatesCreate(tree, owner, size, &c));
  PetscCall(PetscMalloc1(list->n, &kind));
  PetscCall(PetscMalloc1(list->n + 1, &parts->first));
  for (PetscInt i = 0; i < list->n; i++) mean += SlipHPairCost(tree, &list->pair[i], tolerance) / size;
  parts->first[0] = 0;
  for (PetscInt i = 0; i < list->n; i++) {
    const PetscReal cost = SlipHPairCost(tree, &list->pair[i], tolerance), most = HMAT_DIVIDE * mean;
    PetscInt n = 1;

    Find(&c, &list->pair[i]);
    kind[i] = c.n == 1 ? ALONE : cost > 0.1 * most ? LARGE : SMALL;
    if (c.n > 1 && list->pair[i].low && cost > most)
      n = PetscMin((PetscInt)PetscCeilReal(cost / most), PetscMin(c.n, (PetscInt)SlipHRank(tolerance)));
    parts->first[i + 1] = parts->first[i] + n;
  }
  PetscCall(PetscMalloc1(parts->first[list->n], &parts->keeper));
  for (int pass = ALONE; pass < NUM; pass++)
    for (PetscInt i = 0; i < list->n; i++) {
      const PetscInt n = parts->first[i + 1] - parts->first[i];

      if (kind[i] != pass) continue;
      Find(&c, &list->pair[i]);
      for (PetscInt k = 0; k < n; k++) {
        const PetscReal cost = SlipHPairCost(tree, &list->pair[i], tolerance) / (PetscReal)n;

        parts->keeper[parts->first[i] + k] = Give(&c, &list->pair[i], cost);
      }
    }
  PetscCall(PetscCalloc1(size + 2, &parts->start));
  PetscCall(PetscMalloc1(parts->first[list->n], &parts->block));
  for (PetscInt k = 0; k < parts->first[list->n]; k++) parts->start[parts->keeper[k] + 2]++;
  for (PetscMPIInt r = 0; r < size; r++) parts->start[r + 2] += parts->start[r + 1];
  for (PetscInt i = 0; i < list->n; i++)
    for (PetscInt k = parts->first[i]; k < parts->first[i + 1]; k++)
      parts->block[parts->start[parts->keeper[k] + 1]++] = i; /* which moves each start to where it belongs */
  PetscCall(PetscFree(kind));
  PetscCall(CandidatesDestroy(&c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipHPartsDestroy(SlipHParts *parts)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(parts->first));
  PetscCall(PetscFree(parts->keeper));
  PetscCall(PetscFree(parts->start));
  PetscCall(PetscFree(parts->block));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static int CompareRuns(const void *a, const void *b)
{
  const SlipHRun *p = (const SlipHRun *)a, *q = (const SlipHRun *)b;

  return (p->start > q->start) - (p->start < q->start);
}

/* Finds the runs of cells, of the tree's order, that a process' blocks touch: of rows or of columns, or of both. */
PetscErrorCode SlipHRunsCreate(const SlipClusterTree *tree, const SlipHPairs *list, const SlipHParts *parts,
                               PetscMPIInt rank, PetscBool rows, PetscBool columns, SlipHRuns *runs)
{
  const PetscInt first = parts->start[rank], blocks = parts->start[rank + 1] - first;
  PetscInt all = 0, n = 0, place = 0;
  SlipHRun *run;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(2 * blocks + 1, &run));
  for (PetscInt k = first; k < first + blocks; k++)
    for (int side = 0; side < 2; side++) {
      const SlipHPair *pair = &list->pair[parts->block[k]];
      const SlipCluster *p = &tree->node[side ? pair->b : pair->a];

      if (side ? columns : rows) run[all++] = (SlipHRun){p->start, p->end, 0};
    }
  qsort(run, (size_t)all, sizeof(*run), CompareRuns);
  for (PetscInt k = 0; k < all; k++)
    if (n && run[k].start <= run[n - 1].end)
      run[n - 1].end = PetscMax(run[n - 1].end, run[k].end);
    else
      run[n++] = run[k];
  for (PetscInt k = 0; k < n; k++) {
    run[k].place = place;
    place += run[k].end - run[k].start;
  }
  *runs = (SlipHRuns){.n = n, .cells = place};
  PetscCall(PetscMalloc1(n, &runs->run));
  PetscCall(PetscArraycpy(runs->run, run, n));
  PetscCall(PetscFree(run));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the number of a cell of the tree's order among those of the runs, of which it is one. */
PetscInt SlipHRunsPlace(const SlipHRuns *runs, PetscInt cell)
{
  PetscInt low = 0, top = runs->n - 1;

  while (low < top) {
    const PetscInt middle = (low + top + 1) / 2;

    if (runs->run[middle].start <= cell)
      low = middle;
    else
      top = middle - 1;
  }
  return runs->run[low].place + cell - runs->run[low].start;
}
