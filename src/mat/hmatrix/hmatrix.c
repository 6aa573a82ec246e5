/*
  Stiffness of type "sliphmat": blocks of cells that are far from each other, relative to their size, are low-rank
  products from adaptive cross approximation, and others are full (Hackbusch 2015, Hierarchical Matrices).

  As a stiffness is symmetric, only the blocks on and above the diagonal are stored: others are their transposes.
  hpartition.c chooses the process that computes, stores and applies a block. Before a product it receives x, and after
  it sends what it adds to y, of those cells only that its blocks touch.

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

/* Shares of the tolerance by which rounding may change a full block: a far one that is not of low rank, and a near one
   off the diagonal. All low-rank blocks together have about 4e-4 of the matrix's norm, so that near ones must be more
   accurate by this factor for the total error not to grow. */
#define HMAT_ROUND_FAR 0.2
#define HMAT_ROUND_NEAR 1e-3
#define HMAT_HEAD_MOST 16 /* most double-precision terms of a full block that is otherwise in single precision */

/* The numbers that a process' blocks read or add to, in the tree's order of cells */
typedef struct {
  PetscInt n;
  PetscReal *array;   /* [n], and SLIP_HBLOCK_PAD zeros */
  Vec vec;            /* the numbers as a vector */
  VecScatter scatter; /* from the owners */
} Touched;

typedef struct {
  SlipHLayout layout; /* on several processes only until all blocks are there */
  PetscReal scale, tolerance;
  PetscBool whole;        /* matrix of normal stress: no block is the transpose of another */
  PetscInt N, nblocks;    /* numbers of cells, and of blocks of this process */
  PetscInt rows, columns; /* numbers for each cell */
  SlipHBlock *block;
  PetscMPIInt size;
  Touched x, y;
  Vec diagonal;                /* diagonal without the scale */
  PetscReal *t;                /* work of products */
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
  PetscReal asked; /* for a block */
} EntryContext;

static void Entries(void *ctx, PetscInt i, PetscInt m, PetscInt j, PetscInt n, PetscReal a[])
{
  EntryContext *e = (EntryContext *)ctx;

  e->asked += (PetscReal)m * (PetscReal)n;
  SlipCellsPairsEntries(&e->pairs, i, m, j, n, m * e->rows, a);
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

/* A block's part for another process: its terms and how many are in double precision, U and V */
enum { SENT_RANK, SENT_HEAD, NUM_SENT };
typedef struct {
  PetscReal *data;
  MPI_Request request;
} Sent;

/* Receives, sends or stores blocks one after the other, the same ones on all processes. */
typedef struct {
  MPI_Comm comm;
  PetscMPIInt rank, tag;
  PetscInt nsent;
  Sent *sent;
} Exchange;

/* Approximates a far block by terms U V', if it has fewer numbers so, or computes all of it at once first if that takes
   less time. */
static PetscErrorCode Compress(const HMat *h, EntryContext *e, SlipHBlock *k, PetscReal **U, PetscReal **V,
                               PetscBool *found)
{
  const PetscInt m = k->m / h->rows, n = k->n / h->columns;
  int size = 0;

  PetscFunctionBegin;
  for (PetscInt64 all = (PetscInt64)m * n; all > 1; all /= 2) size++;
  if (e->size[size].asked > e->size[size].all) PetscCall(SlipCellsPairsFill(&e->pairs));
  e->asked = 0;
  PetscCall(SlipCrossApproximate(Entries, e, m, h->rows, n, h->columns, h->tolerance, SlipRankMost(k->m, k->n),
                                 &k->rank, &k->head, U, V, found));
  e->size[size].asked += e->asked + (*found ? 0 : (PetscReal)m * (PetscReal)n);
  e->size[size].all += (PetscReal)m * (PetscReal)n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a block to those of this process. */
static PetscErrorCode AddBlock(HMat *h, const SlipHBlock *k, const PetscReal U[], const PetscReal V[])
{
  SlipHBlock *at = &h->block[h->nblocks];

  PetscFunctionBegin;
  if (k->rank == 0) PetscFunctionReturn(PETSC_SUCCESS);
  *at = *k;
  PetscCall(SlipHBlockStore(at, U, V, NULL));
  h->nblocks++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes a block and sends the parts of others. k: its place and size. */
static PetscErrorCode BlockCreate(HMat *h, const SlipHPair *pair, PetscInt n, const PetscMPIInt keeper[],
                                  EntryContext *e, Exchange *ex, SlipHBlock *k)
{
  const PetscInt *row = h->layout.tree.perm + h->layout.tree.node[pair->a].start,
                 *column = h->layout.tree.perm + h->layout.tree.node[pair->b].start;
  PetscReal *U = NULL, *V = NULL;
  PetscBool found = PETSC_FALSE;
  SlipHBlock all = *k;

  PetscFunctionBegin;
  PetscCall(SlipCellsPairsCreate(e->cells, e->unit, k->m / h->rows, row, k->n / h->columns, column, &e->pairs));
  if (pair->low) PetscCall(Compress(h, e, &all, &U, &V, &found));
  if (!found) {
    *k = (SlipHBlock){.row = k->row, .column = k->column, .m = k->m, .n = k->n, .rank = -1};
    PetscCall(StoreFull(k, e, h->tolerance * (pair->low ? HMAT_ROUND_FAR : pair->a == pair->b ? 0 : HMAT_ROUND_NEAR)));
    h->block[h->nblocks++] = *k;
    all.rank = all.head = 0;
  } else {
    h->low++;
    h->mean_rank += (PetscReal)all.rank;
    h->widest = PetscMax(h->widest, all.rank);
  }
  PetscCall(SlipCellsPairsDestroy(&e->pairs));
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt first = all.rank * i / n, terms = all.rank * (i + 1) / n - first;
    const PetscReal *u = U + (size_t)first * k->m, *v = V + (size_t)first * k->n;
    const size_t size = NUM_SENT + (size_t)terms * (size_t)(k->m + k->n);
    PetscMPIInt count;
    PetscReal *data;

    *k = (SlipHBlock){.row = k->row, .column = k->column, .m = k->m, .n = k->n, .rank = terms};
    k->head = PetscMin(PetscMax(all.head - first, 0), terms);
    if (keeper[i] == ex->rank) {
      PetscCall(AddBlock(h, k, u, v));
      continue;
    }
    PetscCall(PetscMalloc1(size, &data));
    data[SENT_RANK] = (PetscReal)terms;
    data[SENT_HEAD] = (PetscReal)k->head;
    PetscCall(PetscArraycpy(data + NUM_SENT, u, (size_t)terms * k->m));
    PetscCall(PetscArraycpy(data + NUM_SENT + (size_t)terms * k->m, v, (size_t)terms * k->n));
    PetscCall(PetscMPIIntCast((PetscInt)size, &count));
    ex->sent[ex->nsent].data = data;
    PetscCallMPI(MPI_Isend(data, count, MPIU_REAL, keeper[i], ex->tag, ex->comm, &ex->sent[ex->nsent++].request));
  }
  PetscCall(PetscFree(U));
  PetscCall(PetscFree(V));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Receives a part of a block from the process that has computed it. */
static PetscErrorCode BlockReceive(HMat *h, PetscMPIInt from, const Exchange *ex, SlipHBlock *k)
{
  MPI_Status status;
  PetscMPIInt count;
  PetscReal *data;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Probe(from, ex->tag, ex->comm, &status));
  PetscCallMPI(MPI_Get_count(&status, MPIU_REAL, &count));
  PetscCall(PetscMalloc1(count, &data));
  PetscCallMPI(MPI_Recv(data, count, MPIU_REAL, from, ex->tag, ex->comm, MPI_STATUS_IGNORE));
  k->rank = (PetscInt)data[SENT_RANK];
  k->head = (PetscInt)data[SENT_HEAD];
  PetscCall(AddBlock(h, k, data + NUM_SENT, data + NUM_SENT + (size_t)k->rank * k->m));
  PetscCall(PetscFree(data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the matrix ---- */

/* Creates n touched numbers. scatter: theirs, or NULL, if the caller creates it. */
static PetscErrorCode TouchedCreate(VecScatter scatter, PetscInt n, Touched *t)
{
  PetscFunctionBegin;
  t->n = n;
  t->scatter = scatter;
  if (scatter) PetscCall(PetscObjectReference((PetscObject)scatter));
  PetscCall(PetscCalloc1(n + SLIP_HBLOCK_PAD, &t->array));
  PetscCall(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, n, t->array, &t->vec));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TouchedDestroy(Touched *t)
{
  PetscFunctionBegin;
  PetscCall(VecScatterDestroy(&t->scatter));
  PetscCall(VecDestroy(&t->vec));
  PetscCall(PetscFree(t->array));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode HMatMult(Mat S, Vec x, Vec y)
{
  InsertMode mode;
  HMat *h;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(S, &h));
  mode = h->size > 1 ? ADD_VALUES : INSERT_VALUES;
  PetscCall(VecScatterBegin(h->x.scatter, x, h->x.vec, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(h->x.scatter, x, h->x.vec, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(PetscArrayzero(h->y.array, h->y.n + SLIP_HBLOCK_PAD));
  SlipHBlocksApply(h->nblocks, h->block, h->whole, h->x.array, h->y.array, h->t);
  PetscCall(SlipWorkFlops(SLIP_WORK_HIERARCHY, h->flops));
  for (PetscInt i = 0; i < h->y.n; i++) h->y.array[i] *= h->scale;
  if (h->size > 1) PetscCall(VecZeroEntries(y));
  PetscCall(VecScatterBegin(h->y.scatter, h->y.vec, y, mode, SCATTER_REVERSE));
  PetscCall(VecScatterEnd(h->y.scatter, h->y.vec, y, mode, SCATTER_REVERSE));
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
    const SlipHShape shape = {.tree = &h->layout.tree,
                              .N = h->N,
                              .rows = h->rows,
                              .columns = h->columns,
                              .whole = h->whole,
                              .nblocks = h->nblocks,
                              .block = h->block,
                              .order = h->layout.order};

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
  bytes = (PetscReal)sizeof(PetscReal) * (PetscReal)(h->x.n + h->y.n) +
          (PetscReal)sizeof(PetscInt) * (PetscReal)(h->whole ? h->x.n + h->y.n : h->x.n);
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
  PetscCall(TouchedDestroy(&h->x));
  PetscCall(TouchedDestroy(&h->y));
  PetscCall(PetscFree(h->t));
  PetscCall(VecDestroy(&h->diagonal));
  PetscCall(SlipHLayoutDestroy(&h->layout));
  PetscCall(PetscFree(h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the exchange of the cells that the blocks touch, of rows, of columns or of both. runs: these cells */
static PetscErrorCode Touch(Mat S, const HMat *h, PetscBool rows, PetscBool columns, SlipHRuns *runs, Touched *t)
{
  const SlipHLayout *l = &h->layout;
  const PetscInt each = columns ? h->columns : h->rows;
  PetscMPIInt rank;
  PetscInt *row;
  Vec right, left;
  IS from;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm((PetscObject)S), &rank));
  PetscCall(SlipHRunsCreate(&l->tree, &l->list, &l->parts, rank, rows, columns, runs));
  PetscCall(PetscMalloc1(runs->cells, &row));
  for (PetscInt k = 0; k < runs->n; k++)
    PetscCall(
      PetscArraycpy(row + runs->run[k].place, l->order + runs->run[k].start, runs->run[k].end - runs->run[k].start));
  PetscCall(MatCreateVecs(S, &right, &left));
  PetscCall(TouchedCreate(NULL, each * runs->cells, t));
  PetscCall(ISCreateBlock(PETSC_COMM_SELF, each, runs->cells, row, PETSC_COPY_VALUES, &from));
  PetscCall(VecScatterCreate(columns ? right : left, from, t->vec, NULL, &t->scatter));
  PetscCall(ISDestroy(&from));
  PetscCall(VecDestroy(&right));
  PetscCall(VecDestroy(&left));
  PetscCall(PetscFree(row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports the share of the blocks that this process computes before number `done` of its parts, by their cost. */
static PetscErrorCode Report(const HMat *h, PetscMPIInt rank, PetscInt done)
{
  const SlipHLayout *l = &h->layout;
  PetscReal cost[2] = {0, 0}; /* of blocks that are done and of others */

  PetscFunctionBegin;
  for (PetscInt k = l->parts.start[rank]; k < l->parts.start[rank + 1]; k++) {
    const PetscInt i = l->parts.block[k];

    if (l->parts.keeper[l->parts.first[i]] == rank)
      cost[k >= done] += SlipHPairCost(&l->tree, &l->list.pair[i], h->tolerance);
  }
  PetscCall(SlipWaitReport(h->whole ? "normal stress by slip" : "stiffness K", cost[0] / (cost[0] + cost[1])));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the blocks of this process, and their exchange. */
static PetscErrorCode CreateBlocks(Mat S, HMat *h, const SlipCells *cells)
{
  EntryContext entry = {
    .cells = cells, .unit = h->whole ? 0 : SlipCellsUnit(cells), .rows = h->rows, .columns = h->columns};
  Exchange ex = {.comm = PetscObjectComm((PetscObject)S)};
  const SlipHLayout *l = &h->layout;
  const SlipHParts *parts = &l->parts;
  PetscInt sent = 0, start, end;
  PetscLayout map;
  SlipHRuns rows, columns;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(ex.comm, &ex.rank));
  PetscCall(PetscObjectGetNewTag((PetscObject)S, &ex.tag));
  PetscCall(MatGetLayouts(S, &map, NULL));
  PetscCall(SlipHLayoutCreate(map, cells, h->whole, h->tolerance, &h->layout));
  PetscCall(Touch(S, h, (PetscBool)!h->whole, PETSC_TRUE, &columns, &h->x));
  rows = columns;
  if (h->whole)
    PetscCall(Touch(S, h, PETSC_TRUE, PETSC_FALSE, &rows, &h->y));
  else
    PetscCall(TouchedCreate(h->x.scatter, h->x.n, &h->y));
  start = parts->start[ex.rank];
  end = parts->start[ex.rank + 1];
  for (PetscInt k = start; k < end; k++) {
    const PetscInt i = parts->block[k];

    sent += parts->keeper[parts->first[i]] == ex.rank ? parts->first[i + 1] - parts->first[i] - 1 : 0;
  }
  PetscCall(PetscCalloc1(end - start, &h->block));
  PetscCall(PetscCalloc1(sent, &ex.sent));
  for (int receive = 0; receive < 2; receive++) /* what others wait for first */
    for (PetscInt k = start; k < end; k++) {
      const PetscInt i = parts->block[k];
      const SlipHPair *pair = &l->list.pair[i];
      const SlipCluster *p = &l->tree.node[pair->a], *q = &l->tree.node[pair->b];
      const PetscMPIInt *keeper = parts->keeper + parts->first[i];
      SlipHBlock block = {.row = h->rows * SlipHRunsPlace(&rows, p->start),
                          .column = h->columns * SlipHRunsPlace(&columns, q->start),
                          .m = h->rows * (p->end - p->start),
                          .n = h->columns * (q->end - q->start)};

      if (receive && keeper[0] != ex.rank) PetscCall(BlockReceive(h, keeper[0], &ex, &block));
      if (receive || keeper[0] != ex.rank) continue;
      PetscCall(BlockCreate(h, pair, parts->first[i + 1] - parts->first[i], keeper, &entry, &ex, &block));
      if (SlipWaitDue()) PetscCall(Report(h, ex.rank, k + 1));
    }
  for (PetscInt i = 0; i < ex.nsent; i++) {
    PetscCallMPI(MPI_Wait(&ex.sent[i].request, MPI_STATUS_IGNORE));
    PetscCall(PetscFree(ex.sent[i].data));
  }
  PetscCall(PetscFree(ex.sent));
  h->total = l->list.n;
  PetscCall(PetscFree(columns.run));
  if (h->whole) PetscCall(PetscFree(rows.run));
  if (h->size > 1) PetscCall(SlipHLayoutDestroy(&h->layout));
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
  PetscInt work = 1, nlocal, start, end;
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
  PetscCallMPI(MPI_Comm_size(comm, &h->size));
  PetscCall(CreateBlocks(*S, h, cells));
  for (PetscInt b = 0; b < h->nblocks; b++) {
    const SlipHBlock *k = &h->block[b];

    h->bytes += SlipHBlockBytes(k);
    h->flops += (h->whole || k->row == k->column ? 1 : 2) * SlipHBlockFlops(k);
    work = PetscMax(work, SlipHBlockWork(k));
  }
  PetscCallMPI(MPI_Allreduce(&h->bytes, &h->most, 1, MPIU_REAL, MPIU_MAX, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &h->bytes, 1, MPIU_REAL, MPIU_SUM, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &h->low, 1, MPIU_INT, MPI_SUM, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &h->mean_rank, 1, MPIU_REAL, MPIU_SUM, comm));
  h->mean_rank /= (PetscReal)PetscMax(h->low, 1);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &h->widest, 1, MPIU_INT, MPI_MAX, comm));
  PetscCall(PetscMalloc1(work, &h->t));
  if (rows == columns) {
    const PetscReal unit = whole ? 0 : SlipCellsUnit(cells);
    PetscReal *d, block[SLIP_KERNEL_BLOCK];

    PetscCall(MatCreateVecs(*S, &h->diagonal, NULL));
    PetscCall(VecGetOwnershipRange(h->diagonal, &start, &end));
    PetscCall(VecGetArrayWrite(h->diagonal, &d));
    for (PetscInt i = start; i < end; i += h->rows) {
      const PetscInt e = SlipCellsAt(cells, i / h->rows);

      SlipCellsEntries(cells, unit, 1, &e, 1, &e, h->rows, block);
      for (PetscInt c = 0; c < h->rows; c++) d[i - start + c] = block[c * (h->rows + 1)];
    }
    PetscCall(VecRestoreArrayWrite(h->diagonal, &d));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
