/*
  Stiffness of type "sliphmat": blocks of cells that are far from each other, relative to their size, are low-rank
  products from adaptive cross approximation, and others are full (Hackbusch 2015, Hierarchical Matrices).

  As a stiffness is symmetric, only the blocks on and above the diagonal are stored: others are their transposes. One
  process computes, stores and applies a block. It owns some of the block's rows or, by symmetry, of its columns: this
  is a distribution by rows except for the half that symmetry saves. Of several such processes the one with the least
  storage so far is chosen. Blocks do not depend on the number of processes, so that results agree to rounding.

  Where slip is a vector a block has two columns, and in a stiffness two rows, for each cell, and is compressed as one.
*/
#include <petscmat.h>
#include <float.h>
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatgrid.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmathmatrix.h>
#include <slipstep/private/slipwork.h>

#define HMAT_LEAF 48 /* cells in a leaf of the cluster tree */
/* A block is low-rank if the smaller diameter is at most this many distances. Entries of dipping cells take ten times
   as long: two planes of 8000 cells took 16 % less time and memory with 2 than with 1.5. */
#define HMAT_ADMISSIBLE 1.5
#define HMAT_ADMISSIBLE_DIPPING 2
/* Shares of the tolerance by which rounding may change a full block: a far one that is not of low rank, and a near one
   off the diagonal. All low-rank blocks together have about 4e-4 of the matrix's norm, so that near ones must be more
   accurate by this factor for the total error not to grow. */
#define HMAT_ROUND_FAR 0.2
#define HMAT_ROUND_NEAR 1e-3
#define HMAT_HEAD_MOST 16 /* most double-precision terms of a full block that is otherwise in single precision */

typedef struct {
  SlipClusterTree tree;
  PetscReal scale, tolerance;
  PetscBool whole;        /* matrix of normal stress: no block is the transpose of another */
  PetscInt N, nblocks;    /* numbers of cells, and of blocks of this process */
  PetscInt rows, columns; /* numbers for each cell */
  SlipHBlock *block;
  SlipGather gather;
  PetscInt *row;               /* [N] number among the rows' cells of each cell in the tree's order */
  Vec diagonal;                /* diagonal without the scale */
  PetscReal *x, *y, *z, *t;    /* [columns N], [rows N] */
  PetscBool *seen;             /* work of the assignment of blocks */
  PetscReal bytes, most;       /* bytes of the blocks on all processes, and on the one with the most */
  PetscReal mean_rank;         /* mean rank of the low-rank blocks */
  PetscLogDouble flops;        /* operations of a product on this process */
  PetscInt total, low, widest; /* numbers of blocks on all processes and of low-rank ones; their largest rank */
  SlipHDevice device;          /* NULL: not in use */
} HMat;

/* The data from which an entry of a block is computed */
typedef struct {
  const SlipCells *cells;
  PetscReal unit;         /* 0: an entry of normal stress */
  PetscInt rows, columns; /* numbers for each cell */
  SlipCellsPairs pairs;   /* of the block */
  /* Of the far blocks of a size, by its logarithm: pairs that the approximations asked for, with those of the full
     blocks of which there was none, and all pairs. Where the former are more, blocks are computed at once. */
  struct {
    PetscReal asked, all;
  } size[8 * sizeof(PetscInt64)];
  PetscReal asked;       /* for a block */
  PetscReal rank, ranks; /* sum of the pairs that far blocks asked for over their rows and columns; number of blocks */
} EntryContext;

static void Entries(void *ctx, PetscInt i, PetscInt m, PetscInt j, PetscInt n, PetscReal a[])
{
  EntryContext *e = (EntryContext *)ctx;

  e->asked += (PetscReal)m * (PetscReal)n;
  SlipCellsPairsEntries(&e->pairs, i, m, j, n, m * e->rows, a);
}

/* ---- the partition ---- */

/* Leaves of the block tree. */
typedef struct {
  PetscInt a, b; /* nodes of the cluster tree */
  PetscBool low;
} Pair;

typedef struct {
  PetscReal admissible;
  PetscInt n, capacity;
  Pair *pair;
} PairList;

static PairList PairListOf(const SlipCells *cells)
{
  return (PairList){.admissible = cells->dip ? HMAT_ADMISSIBLE_DIPPING : HMAT_ADMISSIBLE};
}

/* Lists pairs of clusters that cover all of a x b, or only its upper triangle if a == b and not whole. */
static PetscErrorCode Partition(const SlipClusterTree *tree, PetscBool whole, PetscInt a, PetscInt b, PairList *list)
{
  const SlipCluster *p = &tree->node[a], *q = &tree->node[b];
  const PetscReal smaller = PetscMin(p->diameter, q->diameter);
  const PetscBool far = a != b && smaller <= list->admissible * SlipClusterDistance(p, q) ? PETSC_TRUE : PETSC_FALSE;
  Pair *more;

  PetscFunctionBegin;
  if (far || (p->child[0] < 0 && q->child[0] < 0)) {
    if (list->n == list->capacity) {
      PetscCall(PetscMalloc1(2 * list->capacity + 64, &more));
      PetscCall(PetscArraycpy(more, list->pair, list->n));
      PetscCall(PetscFree(list->pair));
      list->pair = more;
      list->capacity = 2 * list->capacity + 64;
    }
    list->pair[list->n++] = (Pair){a, b, far};
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (int i = 0; i < (p->child[0] < 0 ? 1 : 2); i++)
    for (int j = 0; j < (q->child[0] < 0 ? 1 : 2); j++) {
      if (!whole && a == b && j < i) continue;
      PetscCall(Partition(tree, whole, p->child[0] < 0 ? a : p->child[i], q->child[0] < 0 ? b : q->child[j], list));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- blocks ---- */

/* Stores a full block k, in single precision besides its head terms if that takes less memory. Rounding changes the
   block by at most `share` of itself. */
static PetscErrorCode StoreFull(SlipHBlock *k, EntryContext *e, PetscReal share)
{
  const size_t size = (size_t)k->m * k->n;
  /* a number of a term takes 8 bytes, and single precision saves 4 per number of the rest */
  const PetscInt most = share > 0 ? PetscMin(HMAT_HEAD_MOST, SlipRankMost(k->m, k->n) / 2) : 0;
  PetscReal *A, *rest, *U, *V;

  PetscFunctionBegin;
  PetscCall(PetscMalloc4(size, &A, size, &rest, (size_t)k->m * most, &U, (size_t)k->n * most, &V));
  SlipCellsPairsEntries(&e->pairs, 0, k->m / e->rows, 0, k->n / e->columns, k->m, A);
  PetscCall(PetscArraycpy(rest, A, size));
  if (most) SlipCrossSplit(k->m, k->n, 2 * share / FLT_EPSILON, most, rest, &k->head, U, V, &k->single);
  if (!k->single) k->head = 0;
  PetscCall(SlipHBlockStore(k, U, V, k->single ? rest : A));
  PetscCall(PetscFree4(A, rest, U, V));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BlockCreate(const HMat *h, const Pair *pair, EntryContext *e, SlipHBlock *k)
{
  const SlipCluster *p = &h->tree.node[pair->a], *q = &h->tree.node[pair->b];
  const PetscInt m = p->end - p->start, n = q->end - q->start;
  PetscBool found = PETSC_FALSE;
  PetscReal *U, *V;
  int size = 0;

  PetscFunctionBegin;
  *k = (SlipHBlock){
    .row = h->rows * p->start, .column = h->columns * q->start, .m = h->rows * m, .n = h->columns * n, .rank = -1};
  PetscCall(SlipCellsPairsCreate(e->cells, e->unit, m, h->tree.perm + p->start, n, h->tree.perm + q->start, &e->pairs));
  if (pair->low) {
    for (PetscInt64 all = (PetscInt64)m * n; all > 1; all /= 2) size++;
    if (e->size[size].asked > e->size[size].all) PetscCall(SlipCellsPairsFill(&e->pairs));
    e->asked = 0;
    PetscCall(SlipCrossApproximate(Entries, e, m, h->rows, n, h->columns, h->tolerance, SlipRankMost(k->m, k->n),
                                   &k->rank, &k->head, &U, &V, &found));
    e->rank += e->asked / (PetscReal)(m + n);
    e->ranks++;
    e->size[size].asked += e->asked + (found ? 0 : (PetscReal)m * (PetscReal)n);
    e->size[size].all += (PetscReal)m * (PetscReal)n;
  }
  if (!found) {
    *k = (SlipHBlock){.row = k->row, .column = k->column, .m = k->m, .n = k->n, .rank = -1};
    PetscCall(StoreFull(k, e, h->tolerance * (pair->low ? HMAT_ROUND_FAR : pair->a == pair->b ? 0 : HMAT_ROUND_NEAR)));
  } else {
    PetscCall(SlipHBlockStore(k, U, V, NULL));
    PetscCall(PetscFree(U));
    PetscCall(PetscFree(V));
  }
  PetscCall(SlipCellsPairsDestroy(&e->pairs));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the matrix ---- */

static PetscErrorCode HMatMult(Mat S, Vec x, Vec y)
{
  HMat *h;
  const PetscReal *px;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(S, &h));
  PetscCall(SlipGatherGet(&h->gather, x, &px));
  for (PetscInt i = 0; i < h->N; i++)
    for (PetscInt c = 0; c < h->columns; c++) h->x[h->columns * i + c] = px[h->columns * h->row[i] + c];
  PetscCall(SlipGatherRestore(&h->gather, x, &px));
  PetscCall(PetscArrayzero(h->y, h->rows * h->N + SLIP_HBLOCK_PAD));
  SlipHBlocksApply(h->nblocks, h->block, h->whole, h->x, h->y, h->t);
  PetscCall(SlipWorkFlops(SLIP_WORK_HIERARCHY, h->flops));
  for (PetscInt i = 0; i < h->N; i++)
    for (PetscInt c = 0; c < h->rows; c++) h->z[h->rows * h->row[i] + c] = h->scale * h->y[h->rows * i + c];
  PetscCall(SlipGatherSum(&h->gather, h->z, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode HMatDeviceMult(Mat S, Vec x, Vec y)
{
  HMat *h;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(S, &h));
  PetscCall(SlipHDeviceApply(h->device, h->scale, x, y));
  PetscCall(SlipWorkFlops(SLIP_WORK_HIERARCHY, h->flops));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode HMatDevice(Mat S, PetscBool use, PetscReal *bytes)
{
  HMat *h;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(S, &h));
  {
    const SlipHShape shape = {.tree = &h->tree,
                              .N = h->N,
                              .rows = h->rows,
                              .columns = h->columns,
                              .whole = h->whole,
                              .nblocks = h->nblocks,
                              .block = h->block,
                              .order = h->row};

    if (use)
      PetscCall(SlipHDeviceCreate(&shape, &h->device));
    else
      PetscCall(SlipHDeviceBytes(&shape, bytes));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode HMatGetDiagonal(Mat S, Vec d)
{
  HMat *h;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(S, &h));
  PetscCall(VecCopy(h->diagonal, d));
  PetscCall(VecScale(d, h->scale));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode HMatScale(Mat S, PetscScalar a)
{
  HMat *h;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(S, &h));
  h->scale *= PetscRealPart(a);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode HMatView(Mat S, PetscViewer viewer)
{
  PetscReal dense;
  HMat *h;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(S, &h));
  dense = (PetscReal)sizeof(PetscReal) * (PetscReal)(h->rows * h->N) * (PetscReal)(h->columns * h->N);
  PetscCall(PetscViewerASCIIPrintf(viewer,
                                   "hierarchical %s: %" PetscInt_FMT " cells, relative tolerance %g, %" PetscInt_FMT
                                   " blocks of which %" PetscInt_FMT
                                   " of low rank, %.1f on average and at most %" PetscInt_FMT "\n",
                                   h->whole         ? "normal stress"
                                   : h->columns > 1 ? "stiffness of vectors"
                                                    : "stiffness",
                                   h->N, (double)h->tolerance, h->total, h->low, (double)h->mean_rank, h->widest));
  PetscCall(
    PetscViewerASCIIPrintf(viewer, "memory: %.1f MB, %.2f %% of a dense matrix, at most %.1f MB on one process\n",
                           (double)(1e-6 * h->bytes), (double)(100 * h->bytes / dense), (double)(1e-6 * h->most)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode HMatGetInfo(Mat S, MatInfoType flag, MatInfo *info)
{
  HMat *h;
  PetscReal bytes;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(S, &h));
  bytes =
    SlipGatherBytes(&h->gather) + (PetscReal)sizeof(PetscReal) * (PetscReal)(h->rows + h->columns) * (PetscReal)h->N;
  for (PetscInt b = 0; b < h->nblocks; b++) bytes += SlipHBlockBytes(&h->block[b]);
  PetscCall(SlipInfoFill(S, bytes, flag, info));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode HMatDestroy(Mat S)
{
  HMat *h;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(S, &h));
  PetscCall(SlipHDeviceDestroy(&h->device));
  for (PetscInt b = 0; b < h->nblocks; b++) PetscCall(PetscFree(h->block[b].data));
  PetscCall(PetscFree(h->block));
  PetscCall(PetscFree(h->x));
  PetscCall(PetscFree3(h->y, h->z, h->row));
  PetscCall(PetscFree(h->t));
  PetscCall(VecDestroy(&h->diagonal));
  PetscCall(SlipGatherDestroy(&h->gather));
  PetscCall(SlipClusterTreeDestroy(&h->tree));
  PetscCall(PetscFree(h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Estimates the numbers of a pair of clusters from the rank of far ones. */
static PetscReal CostOf(const SlipClusterTree *tree, const Pair *pair, PetscReal rank)
{
  const SlipCluster *p = &tree->node[pair->a], *q = &tree->node[pair->b];
  const PetscReal m = (PetscReal)(p->end - p->start), n = (PetscReal)(q->end - q->start);

  return pair->low ? PetscMin(rank * (m + n), m * n) : m * n;
}

/* Estimates the storage of a pair: ranks are about 15 at usual tolerances. */
static PetscReal ExpectedCost(const SlipClusterTree *tree, const Pair *pair)
{
  return CostOf(tree, pair, 15);
}

/* Computes cost [n], each cell's share of the storage of its blocks. */
PetscErrorCode SlipHMatCosts(const SlipCells *cells, PetscReal cost[])
{
  SlipClusterTree tree;
  PairList list = PairListOf(cells);

  PetscFunctionBegin;
  PetscCall(SlipClusterTreeCreate(cells, HMAT_LEAF, &tree));
  PetscCall(Partition(&tree, PETSC_FALSE, 0, 0, &list));
  PetscCall(PetscArrayzero(cost, cells->n));
  for (PetscInt i = 0; i < list.n; i++) {
    const PetscReal half = 0.5 * ExpectedCost(&tree, &list.pair[i]);

    for (int side = 0; side < 2; side++) {
      const SlipCluster *p = &tree.node[side ? list.pair[i].b : list.pair[i].a];

      for (PetscInt k = p->start; k < p->end; k++) cost[tree.perm[k]] += half / (PetscReal)(p->end - p->start);
    }
  }
  PetscCall(PetscFree(list.pair));
  PetscCall(SlipClusterTreeDestroy(&tree));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts the processes that own rows of a pair's clusters, and finds the one with the least load among them. */
static PetscMPIInt Candidates(const HMat *h, const PetscMPIInt owner[], const Pair *pair, PetscMPIInt size,
                              const PetscReal load[], PetscMPIInt *least)
{
  PetscMPIInt found = 0, last = -1;
  PetscBool *seen = h->seen;

  *least = -1;
  for (PetscMPIInt r = 0; r < size; r++) seen[r] = PETSC_FALSE;
  for (int side = 0; side < 2; side++) {
    const SlipCluster *p = &h->tree.node[side ? pair->b : pair->a];

    for (PetscInt k = p->start; k < p->end && found < size; k++) {
      const PetscMPIInt r = owner[k];

      if (r == last || seen[r]) continue;
      last = r;
      seen[r] = PETSC_TRUE;
      found++;
    }
  }
  for (PetscMPIInt r = 0; r < size; r++)
    if (seen[r] && (*least < 0 || load[r] < load[*least])) *least = r;
  return found;
}

/* Computes keeper [list->n], equal on all processes: pairs with one candidate come first, then others balance loads. */
static PetscErrorCode Assign(Mat S, HMat *h, const PairList *list, PetscMPIInt keeper[])
{
  const PetscInt *ranges;
  PetscMPIInt *owner, size, rank = 0;
  PetscReal *load;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)S), &size));
  PetscCall(MatGetOwnershipRanges(S, &ranges));
  PetscCall(PetscMalloc1(h->N, &owner));
  PetscCall(PetscCalloc1(size, &load));
  PetscCall(PetscMalloc1(size, &h->seen));
  for (PetscInt i = 0; i < h->N; i++) {
    while (h->rows * h->row[i] < ranges[rank]) rank--;
    while (h->rows * h->row[i] >= ranges[rank + 1]) rank++;
    owner[i] = rank;
  }
  for (int shared = 0; shared < 2; shared++)
    for (PetscInt i = 0; i < list->n; i++) {
      PetscMPIInt least;

      if ((Candidates(h, owner, &list->pair[i], size, load, &least) > 1) != shared) continue;
      keeper[i] = least;
      load[least] += ExpectedCost(&h->tree, &list->pair[i]);
    }
  PetscCall(PetscFree(h->seen));
  PetscCall(PetscFree(owner));
  PetscCall(PetscFree(load));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports the share of this process' blocks that are done, blocks before number `done` of the list. Their cost is the
   number of pairs; that of far blocks to come is what those before asked for, per row and column. */
static PetscErrorCode Report(const HMat *h, const PairList *list, const PetscMPIInt keeper[], PetscMPIInt rank,
                             PetscInt done, const EntryContext *e)
{
  PetscReal cost[2] = {0, 0}; /* of blocks that are done and of others */

  PetscFunctionBegin;
  for (PetscInt i = 0; i < list->n; i++)
    if (keeper[i] == rank) cost[i >= done] += CostOf(&h->tree, &list->pair[i], e->ranks > 0 ? e->rank / e->ranks : 15);
  PetscCall(SlipWaitReport(h->whole ? "normal stress by slip" : "stiffness K", cost[0] / (cost[0] + cost[1])));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the blocks of this process. */
static PetscErrorCode CreateBlocks(Mat S, HMat *h, const SlipCells *cells)
{
  EntryContext entry = {
    .cells = cells, .unit = h->whole ? 0 : SlipCellsUnit(cells), .rows = h->rows, .columns = h->columns};
  PairList list = PairListOf(cells);
  PetscMPIInt rank, *keeper;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm((PetscObject)S), &rank));
  PetscCall(Partition(&h->tree, h->whole, 0, 0, &list));
  PetscCall(PetscMalloc1(list.n, &keeper));
  PetscCall(Assign(S, h, &list, keeper));
  for (PetscInt i = 0; i < list.n; i++) h->nblocks += keeper[i] == rank ? 1 : 0;
  PetscCall(PetscCalloc1(h->nblocks, &h->block));
  h->nblocks = 0;
  for (PetscInt i = 0; i < list.n; i++) {
    if (keeper[i] != rank) continue;
    PetscCall(BlockCreate(h, &list.pair[i], &entry, &h->block[h->nblocks++]));
    if (SlipWaitDue()) PetscCall(Report(h, &list, keeper, rank, i + 1, &entry));
  }
  h->total = list.n;
  PetscCall(PetscFree(keeper));
  PetscCall(PetscFree(list.pair));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates S, or if whole Kn. */
PetscErrorCode SlipCellMatCreate_HMat(MPI_Comm comm, const SlipCells *cells, PetscReal tolerance, PetscBool whole,
                                      Mat *S)
{
  const PetscInt columns = cells->kernel.type->components, rows = whole ? 1 : columns;
  const SlipShellOps ops = {.mult = HMatMult,
                            .diagonal = rows == columns ? HMatGetDiagonal : NULL,
                            .scale = HMatScale,
                            .view = HMatView,
                            .info = HMatGetInfo,
                            .destroy = HMatDestroy,
                            .device = HMatDevice,
                            .device_mult = HMatDeviceMult,
                            .unsymmetric = whole};
  PetscInt work = 1, nlocal, *row;
  HMat *h;

  PetscFunctionBegin;
  PetscCall(PetscNew(&h));
  h->scale = 1;
  h->whole = whole;
  h->tolerance = tolerance;
  h->N = cells->n;
  h->rows = rows;
  h->columns = columns;
  PetscCall(SlipCellsRows(comm, cells, &nlocal));
  PetscCall(
    SlipShellCreateOfSize(comm, rows * nlocal, columns * nlocal, rows * h->N, columns * h->N, "sliphmat", &ops, h, S));
  PetscCall(SlipClusterTreeCreate(cells, HMAT_LEAF, &h->tree));
  /* the places of cells in the tree's order */
  PetscCall(PetscCalloc1(h->columns * h->N + SLIP_HBLOCK_PAD, &h->x));
  PetscCall(PetscMalloc3(h->rows * h->N + SLIP_HBLOCK_PAD, &h->y, h->rows * h->N, &h->z, h->N, &h->row));
  PetscCall(PetscMalloc1(h->N, &row));
  for (PetscInt i = 0; i < h->N; i++) row[SlipCellsAt(cells, i)] = i;
  for (PetscInt i = 0; i < h->N; i++) h->row[i] = row[h->tree.perm[i]];
  PetscCall(PetscFree(row));
  PetscCall(CreateBlocks(*S, h, cells));
  for (PetscInt b = 0; b < h->nblocks; b++) {
    const SlipHBlock *k = &h->block[b];

    h->bytes += SlipHBlockBytes(k);
    h->flops += (h->whole || k->row == k->column ? 1 : 2) * SlipHBlockFlops(k);
    work = PetscMax(work, SlipHBlockWork(k));
    h->low += k->rank >= 0 ? 1 : 0;
    h->mean_rank += (PetscReal)PetscMax(k->rank, 0);
    h->widest = PetscMax(h->widest, k->rank);
  }
  PetscCallMPI(MPI_Allreduce(&h->bytes, &h->most, 1, MPIU_REAL, MPIU_MAX, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &h->bytes, 1, MPIU_REAL, MPIU_SUM, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &h->low, 1, MPIU_INT, MPI_SUM, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &h->mean_rank, 1, MPIU_REAL, MPIU_SUM, comm));
  h->mean_rank /= (PetscReal)PetscMax(h->low, 1);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &h->widest, 1, MPIU_INT, MPI_MAX, comm));
  PetscCall(PetscMalloc1(work, &h->t));
  PetscCall(SlipGatherCreate(*S, NULL, &h->gather));
  if (rows == columns) {
    const PetscReal unit = whole ? 0 : SlipCellsUnit(cells);
    PetscReal *d, block[SLIP_KERNEL_BLOCK];

    PetscCall(MatCreateVecs(*S, &h->diagonal, NULL));
    PetscCall(VecGetArrayWrite(h->diagonal, &d));
    for (PetscInt i = h->gather.start; i < h->gather.end; i += h->rows) {
      const PetscInt e = SlipCellsAt(cells, i / h->rows);

      SlipCellsEntries(cells, unit, 1, &e, 1, &e, h->rows, block);
      for (PetscInt c = 0; c < h->rows; c++) d[i - h->gather.start + c] = block[c * (h->rows + 1)];
    }
    PetscCall(VecRestoreArrayWrite(h->diagonal, &d));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
