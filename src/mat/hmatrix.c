/*
  Stiffness of type "sliphmat": blocks of cells that are far from each other, against their size, are stored as low-rank
  products found by adaptive cross approximation, the others as they are (Hackbusch 2015, Hierarchical Matrices).

  Only the blocks on and above the diagonal are kept: the others are their transposes. Processes share the blocks evenly
  by storage; each applies its own to the whole vector, and the results are added up.
*/
#include <petscmat.h>
#include <petscblaslapack.h>
#include <slipmat.h>
#include <slipstep/private/slipcompat.h>
#include <slipstep/private/slipmat.h>
#include <slipstep/private/slipcells.h>

#define HMAT_LEAF 48        /* cells in a leaf of the cluster tree */
#define HMAT_ADMISSIBLE 1.5 /* low rank where the smaller diameter is at most this many distances */

typedef struct {
  PetscInt row, column; /* first cell, in the tree's order */
  PetscInt m, n;
  PetscInt rank;    /* -1: stored as it is, in U */
  PetscReal *U, *V; /* [m * rank], [n * rank], or [m * n] and NULL; column-major */
} Block;

typedef struct {
  SlipClusterTree tree;
  PetscReal scale, tolerance;
  PetscInt N, nblocks; /* blocks of this process */
  Block *block;
  SlipGather gather;
  Vec diagonal; /* before scale */
  PetscReal *x, *y, *t;
  PetscReal numbers;           /* stored on all processes */
  PetscReal mean_rank;         /* of the low-rank ones */
  PetscLogDouble flops;        /* of a product, on this process */
  PetscInt total, low, widest; /* blocks on all processes, low-rank ones, their largest rank */
} HMat;

/* What an entry of a block is computed from. */
typedef struct {
  const SlipCells *cells;
  PetscReal unit;
  const PetscInt *row, *column; /* cells of the block's rows and columns */
} EntryContext;

static PetscReal Entry(void *ctx, PetscInt i, PetscInt j)
{
  const EntryContext *e = (const EntryContext *)ctx;
  const PetscInt a = e->row[i], b = e->column[j];

  return SlipCellsEntry(e->cells, e->unit, PetscMin(a, b), PetscMax(a, b));
}

/* ---- the partition ---- */

/* Leaves of the block tree. */
typedef struct {
  PetscInt a, b; /* nodes of the cluster tree */
  PetscBool low;
} Pair;

typedef struct {
  PetscInt n, capacity;
  Pair *pair;
} PairList;

static PetscErrorCode AddPair(PairList *list, PetscInt a, PetscInt b, PetscBool low)
{
  Pair *more;

  PetscFunctionBegin;
  if (list->n == list->capacity) {
    PetscCall(PetscMalloc1(2 * list->capacity + 64, &more));
    PetscCall(PetscArraycpy(more, list->pair, list->n));
    PetscCall(PetscFree(list->pair));
    list->pair = more;
    list->capacity = 2 * list->capacity + 64;
  }
  list->pair[list->n++] = (Pair){a, b, low};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Pairs of clusters (a, b) that cover the upper triangle of a x b when a == b, all of a x b otherwise. */
static PetscErrorCode Partition(const SlipClusterTree *tree, PetscInt a, PetscInt b, PairList *list)
{
  const SlipCluster *p = &tree->node[a], *q = &tree->node[b];
  const PetscReal smaller = PetscMin(SlipClusterDiameter(p), SlipClusterDiameter(q));
  const PetscBool far = a != b && smaller <= HMAT_ADMISSIBLE * SlipClusterDistance(p, q) ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  if (far || (p->child[0] < 0 && q->child[0] < 0)) {
    PetscCall(AddPair(list, a, b, far));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (int i = 0; i < (p->child[0] < 0 ? 1 : 2); i++)
    for (int j = 0; j < (q->child[0] < 0 ? 1 : 2); j++) {
      if (a == b && j < i) continue;
      PetscCall(Partition(tree, p->child[0] < 0 ? a : p->child[i], q->child[0] < 0 ? b : q->child[j], list));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- blocks ---- */

static PetscErrorCode BlockCreateWhole(Block *k, EntryContext *e)
{
  PetscFunctionBegin;
  k->rank = -1;
  PetscCall(PetscMalloc1((size_t)k->m * k->n, &k->U));
  for (PetscInt j = 0; j < k->n; j++)
    for (PetscInt i = 0; i < k->m; i++) k->U[(size_t)j * k->m + i] = Entry(e, i, j);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BlockCreate(const HMat *h, const Pair *pair, EntryContext *e, Block *k)
{
  const SlipCluster *p = &h->tree.node[pair->a], *q = &h->tree.node[pair->b];
  PetscBool found = PETSC_FALSE;
  PetscReal *U, *V;

  PetscFunctionBegin;
  *k = (Block){.row = p->start, .column = q->start, .m = p->end - p->start, .n = q->end - q->start};
  e->row = h->tree.perm + k->row;
  e->column = h->tree.perm + k->column;
  if (pair->low)
    PetscCall(
      SlipCrossApproximate(Entry, e, k->m, k->n, h->tolerance, k->m * k->n / (k->m + k->n), &k->rank, &U, &V, &found));
  if (!found) {
    PetscCall(BlockCreateWhole(k, e));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc1((size_t)k->m * k->rank, &k->U)); /* what the search had allocated is larger */
  PetscCall(PetscMalloc1((size_t)k->n * k->rank, &k->V));
  PetscCall(PetscArraycpy(k->U, U, (size_t)k->m * k->rank));
  PetscCall(PetscArraycpy(k->V, V, (size_t)k->n * k->rank));
  PetscCall(PetscFree(U));
  PetscCall(PetscFree(V));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static size_t BlockNumbers(const Block *k)
{
  return k->rank < 0 ? (size_t)k->m * k->n : (size_t)k->rank * (k->m + k->n);
}

/* y += alpha op(A) x, A [m * n] */
static PetscErrorCode Gemv(const char *op, PetscInt m, PetscInt n, const PetscReal A[], const PetscReal x[],
                           PetscReal beta, PetscReal y[])
{
  const PetscScalar one = 1;
  PetscBLASInt bm, bn, inc = 1;

  PetscFunctionBegin;
  PetscCall(PetscBLASIntCast(m, &bm));
  PetscCall(PetscBLASIntCast(n, &bn));
  PetscCallBLAS("BLASgemv", BLASgemv_(op, &bm, &bn, &one, A, &bm, x, &inc, &beta, y, &inc));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* y += (block and, off the diagonal, its transpose) x; t [rank] */
static PetscErrorCode BlockApply(const Block *k, const PetscReal x[], PetscReal y[], PetscReal t[])
{
  PetscFunctionBegin;
  if (k->rank == 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (k->rank < 0) {
    PetscCall(Gemv("N", k->m, k->n, k->U, x + k->column, 1, y + k->row));
    if (k->row != k->column) PetscCall(Gemv("T", k->m, k->n, k->U, x + k->row, 1, y + k->column));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(Gemv("T", k->n, k->rank, k->V, x + k->column, 0, t));
  PetscCall(Gemv("N", k->m, k->rank, k->U, t, 1, y + k->row));
  PetscCall(Gemv("T", k->m, k->rank, k->U, x + k->row, 0, t));
  PetscCall(Gemv("N", k->n, k->rank, k->V, t, 1, y + k->column));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the matrix ---- */

static PetscErrorCode HMatMult(Mat S, Vec x, Vec y)
{
  HMat *h;
  const PetscReal *px;
  PetscReal *py;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(S, &h));
  PetscCall(SlipGatherGet(&h->gather, x, &px));
  for (PetscInt i = 0; i < h->N; i++) h->x[i] = px[h->tree.perm[i]];
  PetscCall(SlipGatherRestore(&h->gather, x, &px));
  PetscCall(PetscArrayzero(h->y, h->N));
  for (PetscInt b = 0; b < h->nblocks; b++) PetscCall(BlockApply(&h->block[b], h->x, h->y, h->t));
  PetscCall(PetscLogFlops(h->flops));
  if (h->gather.scatter)
    PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, h->y, (PetscMPIInt)h->N, MPIU_REAL, MPIU_SUM, PetscObjectComm((PetscObject)S)));
  PetscCall(VecGetArrayWrite(y, &py));
  for (PetscInt i = 0; i < h->N; i++) {
    const PetscInt e = h->tree.perm[i];

    if (e >= h->gather.start && e < h->gather.end) py[e - h->gather.start] = h->scale * h->y[i];
  }
  PetscCall(VecRestoreArrayWrite(y, &py));
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
  const PetscReal mega = 1e-6 * sizeof(PetscReal);
  HMat *h;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(S, &h));
  PetscCall(PetscViewerASCIIPrintf(viewer,
                                   "hierarchical stiffness: %" PetscInt_FMT
                                   " cells, relative tolerance %g, %" PetscInt_FMT " blocks of which %" PetscInt_FMT
                                   " of low rank, %.1f on average and at most %" PetscInt_FMT "\n",
                                   h->N, (double)h->tolerance, h->total, h->low, (double)h->mean_rank, h->widest));
  PetscCall(PetscViewerASCIIPrintf(viewer, "memory: %.1f MB, %.2f %% of a dense matrix\n", (double)(mega * h->numbers),
                                   (double)(100 * h->numbers / ((PetscReal)h->N * (PetscReal)h->N))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode HMatGetInfo(Mat S, MatInfoType flag, MatInfo *info)
{
  HMat *h;
  PetscReal numbers;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(S, &h));
  numbers = 2 * (PetscReal)h->N;
  for (PetscInt b = 0; b < h->nblocks; b++) numbers += (PetscReal)BlockNumbers(&h->block[b]);
  PetscCall(SlipInfoFill(S, (PetscReal)sizeof(PetscReal) * numbers + SlipGatherBytes(&h->gather), flag, info));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode HMatDestroy(Mat S)
{
  HMat *h;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(S, &h));
  for (PetscInt b = 0; b < h->nblocks; b++) {
    PetscCall(PetscFree(h->block[b].U));
    PetscCall(PetscFree(h->block[b].V));
  }
  PetscCall(PetscFree(h->block));
  PetscCall(PetscFree3(h->x, h->y, h->t));
  PetscCall(VecDestroy(&h->diagonal));
  PetscCall(SlipGatherDestroy(&h->gather));
  PetscCall(SlipClusterTreeDestroy(&h->tree));
  PetscCall(PetscFree(h));
  PetscCall(PetscObjectComposeFunction((PetscObject)S, "MatConvert_sliphmat_dense_C", NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Storage that a pair is expected to take: ranks are about 15 at the tolerances in use. */
static PetscReal ExpectedCost(const HMat *h, const Pair *pair)
{
  const SlipCluster *p = &h->tree.node[pair->a], *q = &h->tree.node[pair->b];
  const PetscReal m = (PetscReal)(p->end - p->start), n = (PetscReal)(q->end - q->start);

  return pair->low ? PetscMin(15 * (m + n), m * n) : m * n;
}

/* The blocks of this process: each goes to the one with the least so far, alike on every process. */
static PetscErrorCode CreateBlocks(MPI_Comm comm, HMat *h, const SlipCells *cells)
{
  EntryContext entry = {.cells = cells, .unit = SlipCellsUnit(cells)};
  PairList list = {0, 0, NULL};
  PetscMPIInt rank, size;
  PetscReal *load;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(Partition(&h->tree, 0, 0, &list));
  PetscCall(PetscCalloc1(size, &load));
  PetscCall(PetscCalloc1(list.n, &h->block));
  for (PetscInt i = 0; i < list.n; i++) {
    PetscMPIInt least = 0;

    for (PetscMPIInt r = 1; r < size; r++)
      if (load[r] < load[least]) least = r;
    load[least] += ExpectedCost(h, &list.pair[i]);
    if (least == rank) PetscCall(BlockCreate(h, &list.pair[i], &entry, &h->block[h->nblocks++]));
  }
  h->total = list.n;
  PetscCall(PetscFree(load));
  PetscCall(PetscFree(list.pair));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CountStorage(MPI_Comm comm, HMat *h)
{
  PetscFunctionBegin;
  for (PetscInt b = 0; b < h->nblocks; b++) {
    h->numbers += (PetscReal)BlockNumbers(&h->block[b]);
    h->flops += (h->block[b].row == h->block[b].column ? 2 : 4) * (PetscLogDouble)BlockNumbers(&h->block[b]);
    h->low += h->block[b].rank >= 0 ? 1 : 0;
    h->mean_rank += (PetscReal)PetscMax(h->block[b].rank, 0);
    h->widest = PetscMax(h->widest, h->block[b].rank);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &h->numbers, 1, MPIU_REAL, MPIU_SUM, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &h->low, 1, MPIU_INT, MPI_SUM, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &h->mean_rank, 1, MPIU_REAL, MPIU_SUM, comm));
  h->mean_rank /= (PetscReal)PetscMax(h->low, 1);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &h->widest, 1, MPIU_INT, MPI_MAX, comm));
  PetscCall(PetscMalloc3(h->N, &h->x, h->N, &h->y, PetscMax(h->widest, 1), &h->t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillDiagonal(Mat S, HMat *h, const SlipCells *cells)
{
  const PetscReal unit = SlipCellsUnit(cells);
  PetscReal *d;

  PetscFunctionBegin;
  PetscCall(MatCreateVecs(S, &h->diagonal, NULL));
  PetscCall(VecGetArrayWrite(h->diagonal, &d));
  for (PetscInt i = h->gather.start; i < h->gather.end; i++) d[i - h->gather.start] = SlipCellsEntry(cells, unit, i, i);
  PetscCall(VecRestoreArrayWrite(h->diagonal, &d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStiffnessCreate_HMat(MPI_Comm comm, const SlipCells *cells, PetscReal tolerance, Mat *S)
{
  HMat *h;

  PetscFunctionBegin;
  PetscCall(PetscNew(&h));
  h->scale = 1;
  h->tolerance = tolerance;
  h->N = cells->n;
  PetscCall(SlipClusterTreeCreate(cells, HMAT_LEAF, &h->tree));
  PetscCall(CreateBlocks(comm, h, cells));
  PetscCall(CountStorage(comm, h));
  PetscCall(MatCreateShell(comm, PETSC_DECIDE, PETSC_DECIDE, h->N, h->N, h, S));
  PetscCall(MatSetUp(*S));
  PetscCall(MatShellSetManageScalingShifts(*S));
  PetscCall(MatShellSetOperation(*S, MATOP_MULT, SlipMatShellFn(HMatMult)));
  PetscCall(MatShellSetOperation(*S, MATOP_MULT_TRANSPOSE, SlipMatShellFn(HMatMult)));
  PetscCall(MatShellSetOperation(*S, MATOP_GET_DIAGONAL, SlipMatShellFn(HMatGetDiagonal)));
  PetscCall(MatShellSetOperation(*S, MATOP_SCALE, SlipMatShellFn(HMatScale)));
  PetscCall(MatShellSetOperation(*S, MATOP_VIEW, SlipMatShellFn(HMatView)));
  PetscCall(MatShellSetOperation(*S, MATOP_GETINFO, SlipMatShellFn(HMatGetInfo)));
  PetscCall(MatShellSetOperation(*S, MATOP_DESTROY, SlipMatShellFn(HMatDestroy)));
  PetscCall(SlipShellFinish(*S, "sliphmat"));
  PetscCall(SlipGatherCreate(*S, NULL, &h->gather));
  PetscCall(FillDiagonal(*S, h, cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}
