/*
  Products with a hierarchical matrix on a device. Its numbers are stored there as in hblocks.c, in at most four arrays,
  because devices limit the size of an array. A panel is the factor of a low-rank block, or a full block:

     t = P' x of all panels whose columns are needed, V of u v' and, where a block also represents its transpose, U and
         full blocks: a group of work items for each, and several for tall ones, whose sums are added;
     y = the sum of P t by rows: the rows of a leaf of the cluster tree have a list of all panels that contain them, so
         that each row is always summed in the same order.

  A block that represents its transpose is read twice and stored once.
*/
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipmathmatrix.h>

enum { PARTS = 4, TALL = 512 /* rows of a panel for a group */, STAGED = 1 << 22 /* numbers sent at once */ };

/* The structs that kernels/hmat.cl reads */
typedef struct {
  int64_t at;
  int kind, stride, rows, columns, x, t;
} Dots;
typedef struct {
  int64_t at;
  int kind, stride, columns, t;
} Sums;
typedef struct {
  int row, rows, first, start, end, unused;
} Chunk;
typedef struct {
  int to, from, parts, apart;
} Fold;

/* The lists of a product, which the processor makes and sends to the device */
typedef struct {
  const SlipHShape *h;
  PetscBool count;               /* count only */
  PetscInt nleaf, *leaf, *start; /* [N] the leaf of each cell; [nleaf + 1] its first cell */
  PetscInt *items; /* [nleaf + 1] first item of each leaf; while lists are filled, the place of the next item */
  PetscInt ndots, nfolds, nsums, nchunks, nv;
  Dots *dots;
  Fold *folds;
  Sums *sums;
  Chunk *chunks;
  size_t part[PARTS]; /* numbers */
} Plan;

struct _n_SlipHDevice {
  SlipDevice device;
  int ndots, nfolds, nchunks, nx, shift;
  SlipDeviceMemory part[PARTS], dots, folds, sums, chunks, v, from, to;
};

/* Returns how many numbers a block has, on the processor as on the device. */
static size_t NumbersOf(const SlipHBlock *k)
{
  return (size_t)(SlipHBlockBytes(k) / (PetscReal)sizeof(PetscReal));
}

static PetscInt Padded(PetscInt m)
{
  return (m + SLIP_HBLOCK_PAD - 1) / SLIP_HBLOCK_PAD * SLIP_HBLOCK_PAD;
}

/* Adds the product t = P' x, and returns the place of t; P has m rows, of x from number x on. */
static PetscInt AddDots(Plan *p, int64_t at, int kind, PetscInt m, PetscInt columns, PetscInt x)
{
  const PetscInt tiles = (m + TALL - 1) / TALL, t = p->nv, parts = tiles > 1 ? t + columns : t;

  p->nv += columns * (tiles > 1 ? tiles + 1 : 1);
  for (PetscInt i = 0; i < tiles; i++, p->ndots++)
    if (!p->count)
      p->dots[p->ndots] = (Dots){at + i * TALL,
                                 kind,
                                 (int)Padded(m),
                                 (int)PetscMin(TALL, m - i * TALL),
                                 (int)columns,
                                 (int)(x + i * TALL),
                                 (int)(parts + i * columns)};
  for (PetscInt j = 0; j < columns && tiles > 1; j++, p->nfolds++)
    if (!p->count) p->folds[p->nfolds] = (Fold){(int)(t + j), (int)(parts + j), (int)tiles, (int)columns};
  return t;
}

/* Adds the sum P t to m rows of y from `row` on, each of which is one of the `rows` of a cell. */
static void AddSums(Plan *p, int64_t at, int kind, PetscInt m, PetscInt columns, PetscInt t, PetscInt row,
                    PetscInt rows)
{
  for (PetscInt k = p->leaf[row / rows]; k < p->nleaf && rows * p->start[k] < row + m; k++) {
    const PetscInt skip = rows * p->start[k] - row;

    p->nsums++;
    if (p->count)
      p->items[k]++;
    else
      p->sums[p->items[k]++] =
        (Sums){kind < 0 ? 0 : at + skip, kind, (int)Padded(m), (int)columns, (int)(kind < 0 ? t + skip : t)};
  }
}

/* Adds `terms` columns of U and V in one precision, one after the other. */
static void AddTerms(Plan *p, const SlipHBlock *k, int64_t at, int kind, PetscInt terms, PetscBool both)
{
  const int64_t v = at + (int64_t)terms * Padded(k->m);
  const PetscInt rows = p->h->rows, columns = p->h->columns;

  if (!terms) return;
  AddSums(p, at, kind, k->m, terms, AddDots(p, v, kind, k->n, terms, k->column), k->row, rows);
  if (both) AddSums(p, v, kind, k->n, terms, AddDots(p, at, kind, k->m, terms, k->row), k->column, columns);
}

static void AddBlock(Plan *p, const SlipHBlock *k, PetscInt part, size_t start)
{
  const PetscBool both = (PetscBool)(!p->h->whole && k->row != k->column), single = k->rank >= 0 || k->single;
  const int64_t behind = (int64_t)start + (int64_t)k->head * (Padded(k->m) + Padded(k->n)),
                rest = single ? 2 * behind : behind;
  const int kind = (int)(2 * part) + (single ? 1 : 0);

  AddTerms(p, k, (int64_t)start, (int)(2 * part), k->head, both);
  if (k->rank >= 0) {
    AddTerms(p, k, rest, kind, k->rank - k->head, both);
    return;
  }
  AddSums(p, rest, kind, k->m, k->n, k->column, k->row, p->h->rows);
  if (both) AddSums(p, 0, -1, k->n, 1, AddDots(p, rest, kind, k->m, k->n, k->row), k->column, p->h->columns);
}

/* Adds all blocks, one after the other, and continues in the next array when one is full. */
static PetscErrorCode AddBlocks(Plan *p, size_t most)
{
  PetscInt part = 0;

  PetscFunctionBegin;
  p->ndots = p->nfolds = p->nsums = 0;
  p->nv = p->h->columns * p->h->N;
  PetscCall(PetscArrayzero(p->part, PARTS));
  for (PetscInt b = 0; b < p->h->nblocks; b++) {
    const size_t numbers = NumbersOf(&p->h->block[b]);

    if (p->part[part] + numbers > most) part++;
    PetscCheck(
      part < PARTS && numbers <= most && p->nv < PETSC_MAX_INT - 4 * p->h->N, PETSC_COMM_SELF, PETSC_ERR_MEM,
      "the hierarchical stiffness does not fit into %d arrays of the device, of at most %.4g MB each: expected "
      "fewer cells, a larger -fault_hmat_tolerance, or another device (-fault_device_name)",
      PARTS, 1e-6 * (double)sizeof(PetscReal) * (double)most);
    AddBlock(p, &p->h->block[b], part, p->part[part]);
    p->part[part] += numbers;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static int Shift(const SlipHShape *h)
{
  return h->rows > 1 ? 5 : 4; /* a leaf has 24 to 48 cells */
}

/* Divides the rows of each leaf into chunks of as many as a group takes. */
static void AddChunks(Plan *p)
{
  const PetscInt rows = p->h->rows, lanes = (PetscInt)1 << Shift(p->h);

  p->nchunks = 0;
  for (PetscInt k = 0; k < p->nleaf; k++)
    for (PetscInt i = rows * p->start[k]; i < rows * p->start[k + 1]; i += lanes, p->nchunks++)
      if (!p->count)
        p->chunks[p->nchunks] = (Chunk){(int)i,
                                        (int)PetscMin(lanes, rows * p->start[k + 1] - i),
                                        (int)(i - rows * p->start[k]),
                                        k ? (int)p->items[k - 1] : 0,
                                        (int)p->items[k],
                                        0};
}

static PetscErrorCode FindLeaves(Plan *p)
{
  const SlipClusterTree *tree = p->h->tree;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(p->h->N, &p->leaf, p->h->N + 1, &p->start, p->h->N + 1, &p->items));
  for (PetscInt i = 0; i < p->h->N; i++) p->leaf[i] = 0;
  for (PetscInt k = 0; k < tree->nnodes; k++)
    if (tree->node[k].child[0] < 0) p->leaf[tree->node[k].start] = 1;
  for (PetscInt i = 0; i < p->h->N; i++) {
    if (p->leaf[i]) p->start[p->nleaf++] = i;
    p->leaf[i] = p->nleaf - 1;
  }
  p->start[p->nleaf] = p->h->N;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the plan, which is first counted and then filled. */
static PetscErrorCode PlanCreate(const SlipHShape *h, SlipDevice device, PetscBool fill, Plan *p)
{
  const size_t most = SlipDeviceLargest(device) / sizeof(PetscReal);
  PetscInt first = 0;

  PetscFunctionBegin;
  *p = (Plan){.h = h, .count = PETSC_TRUE};
  PetscCall(FindLeaves(p));
  PetscCall(PetscArrayzero(p->items, p->nleaf));
  PetscCall(AddBlocks(p, most));
  AddChunks(p);
  if (!fill) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < p->nleaf; k++) {
    const PetscInt n = p->items[k];

    p->items[k] = first;
    first += n;
  }
  PetscCall(PetscMalloc4(p->ndots, &p->dots, p->nfolds, &p->folds, p->nsums, &p->sums, p->nchunks, &p->chunks));
  p->count = PETSC_FALSE;
  PetscCall(AddBlocks(p, most));
  AddChunks(p); /* now the items of a leaf end where those of the next one begin */
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PlanDestroy(Plan *p)
{
  PetscFunctionBegin;
  PetscCall(PetscFree3(p->leaf, p->start, p->items));
  PetscCall(PetscFree4(p->dots, p->folds, p->sums, p->chunks));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the bytes besides those of the blocks. */
static size_t BytesBeside(const Plan *p)
{
  const size_t orders = sizeof(int) * (size_t)(p->h->N * (p->h->rows + p->h->columns) + 2);

  return sizeof(Dots) * (size_t)p->ndots + sizeof(Fold) * (size_t)p->nfolds + sizeof(Sums) * (size_t)p->nsums +
         sizeof(Chunk) * (size_t)p->nchunks + sizeof(PetscReal) * (size_t)p->nv + orders;
}

PetscErrorCode SlipHDeviceBytes(const SlipHShape *h, PetscReal *bytes)
{
  SlipDevice device;
  Plan p;

  PetscFunctionBegin;
  *bytes = 0;
  PetscCall(SlipDeviceGet(&device));
  for (PetscInt b = 0; b < h->nblocks; b++) *bytes += SlipHBlockBytes(&h->block[b]);
  if (device) {
    PetscCall(PlanCreate(h, device, PETSC_FALSE, &p));
    *bytes += (PetscReal)BytesBeside(&p);
    PetscCall(PlanDestroy(&p));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- on the device ---- */

/* Sends records or integers as numbers, of which the last one may be half used. */
static PetscErrorCode Send(SlipDevice device, size_t bytes, const void *from, SlipDeviceMemory *to)
{
  const size_t n = (bytes + sizeof(PetscReal) - 1) / sizeof(PetscReal);
  PetscReal *copy;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(n, &copy));
  PetscCall(PetscMemcpy(copy, from, bytes));
  PetscCall(SlipDeviceAllocate(device, sizeof(PetscReal) * n, "the hierarchical stiffness", to));
  PetscCall(SlipDevicePut(device, n, copy, *to));
  PetscCall(PetscFree(copy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SendBlocks(const Plan *p, SlipHDevice d)
{
  PetscReal *staged;
  PetscInt b = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(STAGED, &staged));
  for (PetscInt part = 0; part < PARTS; part++) {
    size_t sent = 0;

    PetscCall(
      SlipDeviceAllocate(d->device, sizeof(PetscReal) * p->part[part], "the hierarchical stiffness", &d->part[part]));
    while (sent < p->part[part]) {
      size_t n = 0;

      for (; b < p->h->nblocks && sent + n < p->part[part]; b++) {
        const size_t numbers = NumbersOf(&p->h->block[b]);

        if (n + numbers > STAGED) break;
        PetscCall(PetscArraycpy(staged + n, p->h->block[b].data, numbers));
        n += numbers;
      }
      if (!n) { /* one larger than that */
        n = NumbersOf(&p->h->block[b]);
        PetscCall(SlipDevicePutAt(d->device, sent, n, p->h->block[b++].data, d->part[part]));
      } else
        PetscCall(SlipDevicePutAt(d->device, sent, n, staged, d->part[part]));
      sent += n;
    }
  }
  PetscCall(PetscFree(staged));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sends the positions, in vectors with `many` numbers per cell, of the numbers in the tree's order. */
static PetscErrorCode SendOrder(const SlipHShape *h, SlipDevice device, PetscInt many, SlipDeviceMemory *to)
{
  int *order;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(h->N * many, &order));
  for (PetscInt i = 0; i < h->N * many; i++) order[i] = (int)(many * h->order[i / many] + i % many);
  PetscCall(Send(device, sizeof(int) * (size_t)(h->N * many), order, to));
  PetscCall(PetscFree(order));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipHDeviceCreate(const SlipHShape *h, SlipHDevice *device)
{
  SlipHDevice d;
  Plan p;

  PetscFunctionBegin;
  PetscCall(PetscNew(&d));
  *device = d;
  PetscCall(SlipDeviceGet(&d->device));
  PetscCall(PlanCreate(h, d->device, PETSC_TRUE, &p));
  d->ndots = (int)p.ndots;
  d->nfolds = (int)p.nfolds;
  d->nchunks = (int)p.nchunks;
  d->nx = (int)(h->columns * h->N);
  d->shift = Shift(h);
  PetscCall(Send(d->device, sizeof(Dots) * (size_t)p.ndots, p.dots, &d->dots));
  PetscCall(Send(d->device, sizeof(Fold) * (size_t)p.nfolds, p.folds, &d->folds));
  PetscCall(Send(d->device, sizeof(Sums) * (size_t)p.nsums, p.sums, &d->sums));
  PetscCall(Send(d->device, sizeof(Chunk) * (size_t)p.nchunks, p.chunks, &d->chunks));
  PetscCall(SlipDeviceAllocate(d->device, sizeof(PetscReal) * (size_t)p.nv, "the hierarchical stiffness", &d->v));
  PetscCall(SendOrder(h, d->device, h->columns, &d->from));
  PetscCall(SendOrder(h, d->device, h->rows, &d->to));
  PetscCall(SendBlocks(&p, d));
  PetscCall(PlanDestroy(&p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipHDeviceDestroy(SlipHDevice *device)
{
  SlipHDevice d = *device;

  PetscFunctionBegin;
  *device = NULL;
  if (!d) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < PARTS; k++) PetscCall(SlipDeviceFree(d->device, &d->part[k]));
  PetscCall(SlipDeviceFree(d->device, &d->dots));
  PetscCall(SlipDeviceFree(d->device, &d->folds));
  PetscCall(SlipDeviceFree(d->device, &d->sums));
  PetscCall(SlipDeviceFree(d->device, &d->chunks));
  PetscCall(SlipDeviceFree(d->device, &d->v));
  PetscCall(SlipDeviceFree(d->device, &d->from));
  PetscCall(SlipDeviceFree(d->device, &d->to));
  PetscCall(PetscFree(d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes y = scale * (the matrix) x, both on the device. */
PetscErrorCode SlipHDeviceApply(SlipHDevice d, PetscReal scale, Vec x, Vec y)
{
  SlipDeviceMemory from, to;

  PetscFunctionBegin;
  PetscCall(SlipDeviceVecRead(x, &from));
  PetscCall(SlipDeviceVecWrite(y, &to));
  {
    const SlipDeviceArg order[] = {SLIP_DEVICE_ARG(d->nx), SLIP_DEVICE_ARG(d->from), SLIP_DEVICE_ARG(from),
                                   SLIP_DEVICE_ARG(d->v)};
    const SlipDeviceArg dots[] = {SLIP_DEVICE_ARG(d->ndots),   SLIP_DEVICE_ARG(d->dots),    SLIP_DEVICE_ARG(d->part[0]),
                                  SLIP_DEVICE_ARG(d->part[1]), SLIP_DEVICE_ARG(d->part[2]), SLIP_DEVICE_ARG(d->part[3]),
                                  SLIP_DEVICE_ARG(d->v)};
    const SlipDeviceArg folds[] = {SLIP_DEVICE_ARG(d->nfolds), SLIP_DEVICE_ARG(d->folds), SLIP_DEVICE_ARG(d->v)};
    const SlipDeviceArg sums[] = {SLIP_DEVICE_ARG(d->nchunks), SLIP_DEVICE_ARG(d->shift),   SLIP_DEVICE_ARG(d->chunks),
                                  SLIP_DEVICE_ARG(d->sums),    SLIP_DEVICE_ARG(d->part[0]), SLIP_DEVICE_ARG(d->part[1]),
                                  SLIP_DEVICE_ARG(d->part[2]), SLIP_DEVICE_ARG(d->part[3]), SLIP_DEVICE_ARG(d->v),
                                  SLIP_DEVICE_ARG(scale),      SLIP_DEVICE_ARG(d->to),      SLIP_DEVICE_ARG(to)};

    PetscCall(SlipDeviceRun(d->device, KERNEL_HMAT_ORDER, (size_t)d->nx, 1, 4, order));
    PetscCall(SlipDeviceRunGroups(d->device, KERNEL_HMAT_DOTS, (size_t)d->ndots, 7, dots));
    PetscCall(SlipDeviceRun(d->device, KERNEL_HMAT_FOLD, (size_t)d->nfolds, 1, 3, folds));
    PetscCall(SlipDeviceRunGroups(d->device, KERNEL_HMAT_SUMS, (size_t)d->nchunks, 12, sums));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
