/* Cells of an irregular mesh: the entries of their stiffness, and the weights that are composed with it. */
#include <slipstep/rooms/slipmat.h>
#include <slipstep/rooms/slipsys.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipmatcells.h>
#include <slipstep/private/slipwork.h>

int SlipCellKeyCompare(const void *a, const void *b)
{
  const SlipCellKey *p = (const SlipCellKey *)a, *q = (const SlipCellKey *)b;

  if (p->key != q->key) return p->key < q->key ? -1 : 1;
  return p->cell < q->cell ? -1 : p->cell > q->cell;
}

/* Destroys cells whose x owns the memory of all columns. */
PetscErrorCode SlipCellsDestroy(SlipCells *cells)
{
  PetscReal *data = (PetscReal *)cells->x;

  PetscFunctionBegin;
  PetscCall(PetscFree(data));
  cells->x = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

SlipCell SlipCellsGet(const SlipCells *c, PetscInt i)
{
  return (SlipCell){
    {c->x[i], c->y[i], c->z[i], c->length[i], c->width[i], c->strike ? c->strike[i] : 0, c->dip ? c->dip[i] : 90},
    c->rake ? c->rake[i] : 0,
    c->vertices ? c->vertices + 9 * (size_t)i : NULL,
    c->directions ? c->directions + 9 * (size_t)i : NULL};
}

/* Computes directions [n][3][3] of triangles once, because all n^2 entries need them; for vectors they are along
   strike. They are NULL for rectangles, whose kernels take angles. Collective. */
PetscErrorCode SlipCellsDirections(const SlipCells *c, SlipShared shared, PetscReal **directions)
{
  const PetscReal *rake = c->kernel.type->components > 1 ? NULL : c->rake;

  PetscInt start, end;

  PetscFunctionBegin;
  *directions = NULL;
  if (!c->vertices) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipSharedMalloc1(shared, 9 * (size_t)c->n, directions));
  SlipSharedSlice(shared, *directions, c->n, &start, &end);
  for (PetscInt i = start; i < end; i++)
    SlipPlaneDirections(c->strike ? c->strike[i] : 0, c->dip ? c->dip[i] : 90, rake ? rake[i] : 0,
                        *directions + 9 * (size_t)i);
  PetscCall(SlipSharedReady(shared));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- entries: for c components of slip, blocks [c][c] of a cell's rows and another one's columns ---- */

#define CELLS_AT_ONCE 32 /* two calls of a kernel's function for many pairs */
#define LANES_FOR_PAIR 3 /* how many pairs in lanes take as long as one by itself */

/* Puts into a, column-major, the symmetric part of the forces of cells with the areas p and q on each other. */
static void PutShear(const SlipKernelType *t, PetscReal unit, PetscReal p, const PetscReal block[], PetscReal q,
                     const PetscReal back[], PetscInt lda, PetscReal a[])
{
  const PetscInt c = t->components;

  for (PetscInt j = 0; j < c; j++)
    for (PetscInt i = 0; i < c; i++) a[j * lda + i] = unit * (p * block[i * c + j] + q * back[j * c + i]);
}

/* Puts averages, which are reciprocal, into a. Those over the cell of the lower number are used, so that bits on both
   sides of the diagonal are equal. */
static void PutAverage(const SlipCells *cells, PetscReal unit, PetscInt row, PetscInt column, PetscInt lda,
                       PetscReal a[])
{
  const PetscInt c = cells->kernel.type->components, i = PetscMin(row, column), j = PetscMax(row, column);
  const SlipCell receiver = SlipCellsGet(cells, i), source = SlipCellsGet(cells, j);
  const PetscReal area = cells->length[i] * cells->width[i];
  PetscReal block[SLIP_KERNEL_BLOCK];

  SlipKernelBlock(&cells->kernel, &receiver, &source, block);
  for (PetscInt l = 0; l < c; l++)
    for (PetscInt k = 0; k < c; k++) {
      PetscReal force = area * block[row > column ? l * c + k : k * c + l];

      if (i == j) {
        if (k != l) force = 0.5 * (force + area * block[l * c + k]);
        force += cells->edges[(i * c + k) * c + l];
      }
      a[l * lda + k] = 2 * unit * force;
    }
}

/* Computes entries one by one. */
static void EntriesSingly(const SlipCells *cells, PetscReal unit, PetscInt m, const PetscInt row[], PetscInt n,
                          const PetscInt column[], PetscInt lda, PetscReal a[])
{
  const SlipKernelType *t = cells->kernel.type;
  const PetscInt c = t->components, rows = unit == 0 ? 1 : c;

  for (PetscInt j = 0; j < n; j++)
    for (PetscInt i = 0; i < m; i++) {
      const PetscInt p = row[i], q = column[j];
      const SlipCell receiver = SlipCellsGet(cells, p), source = SlipCellsGet(cells, q);
      PetscReal block[SLIP_KERNEL_BLOCK], back[SLIP_KERNEL_BLOCK], *at = a + (size_t)j * c * lda + i * rows;

      if (unit != 0 && cells->kernel.average) {
        PutAverage(cells, unit, p, q, lda, at);
        continue;
      }
      SlipKernelBlock(&cells->kernel, &receiver, &source, block);
      if (unit == 0) {
        for (PetscInt l = 0; l < c; l++) at[l * lda] = block[c * c + l];
        continue;
      }
      SlipKernelBlock(&cells->kernel, &source, &receiver, back);
      PutShear(t, unit, cells->length[p] * cells->width[p], block, cells->length[q] * cells->width[q], back, lda, at);
    }
}

/*
  SlipCellsEntries - computes entries a, column-major with lda numbers from one column to the next, for the m cells of
  some rows and the n of some columns: [m c][n c] of the stiffness, or if unit is 0 [m][n c] of normal stress by slip
*/
void SlipCellsEntries(const SlipCells *cells, PetscReal unit, PetscInt m, const PetscInt row[], PetscInt n,
                      const PetscInt column[], PetscInt lda, PetscReal a[])
{
  const SlipKernelType *t = cells->kernel.type;
  const PetscInt c = t->components, rows = unit == 0 ? 1 : c, size = (c + t->normals) * c;
  const size_t all = (size_t)m * n;

  if (cells->vertices)
    SlipWorkAdd(SLIP_WORK_TRIANGLE_PAIR, LANES_FOR_PAIR * (PetscReal)all);
  else
    SlipWorkAdd(size > 1 ? SLIP_WORK_DIPPING_PAIR : SLIP_WORK_PAIR, (PetscReal)all);
  if (cells->kernel.average || !t->centres) {
    EntriesSingly(cells, unit, m, row, n, column, lda, a);
    return;
  }
  for (size_t first = 0; first < all; first += CELLS_AT_ONCE) {
    const PetscInt count = (PetscInt)PetscMin(CELLS_AT_ONCE, all - first);
    SlipCell receiver[CELLS_AT_ONCE], source[CELLS_AT_ONCE];
    PetscReal block[SLIP_KERNEL_BLOCK * CELLS_AT_ONCE], back[SLIP_KERNEL_BLOCK * CELLS_AT_ONCE];

    for (PetscInt k = 0; k < count; k++) {
      receiver[k] = SlipCellsGet(cells, row[(first + k) % m]);
      source[k] = SlipCellsGet(cells, column[(first + k) / m]);
    }
    (*t->centres)(&cells->kernel, count, receiver, source, block);
    if (unit != 0) (*t->centres)(&cells->kernel, count, source, receiver, back);
    for (PetscInt k = 0; k < count; k++) {
      const SlipDippingRectangle *p = &receiver[k].rectangle, *q = &source[k].rectangle;
      PetscReal *at = a + (first + k) / m * c * lda + (first + k) % m * rows;

      if (unit == 0)
        for (PetscInt l = 0; l < c; l++) at[l * lda] = block[size * k + c * c + l];
      else
        PutShear(t, unit, p->length * p->width, block + size * k, q->length * q->width, back + size * k, lda, at);
    }
  }
}

/* Gets how many cells' rows this process has. Collective. */
PetscErrorCode SlipCellsRows(MPI_Comm comm, const SlipCells *c, PetscInt *nlocal)
{
  PetscInt n = c->n;

  PetscFunctionBegin;
  *nlocal = c->order ? c->nlocal : PETSC_DECIDE;
  PetscCall(PetscSplitOwnership(comm, nlocal, &n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal SlipCellsUnit(const SlipCells *c)
{
  PetscReal area = 0;

  for (PetscInt i = 0; i < c->n; i++) area += c->length[i] * c->width[i];
  return (PetscReal)c->n / (2 * area);
}

/* Composes the weights with S as a vector, unless all cells have the same area up to rounding. */
PetscErrorCode SlipCellsCompose(Mat S, const SlipCells *c)
{
  const PetscInt components = c->kernel.type->components;
  const PetscReal unit = SlipCellsUnit(c);
  PetscReal *w, least = PETSC_MAX_REAL, most = 0;
  PetscInt start, end;
  Vec weights;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < c->n; i++) {
    least = PetscMin(least, c->length[i] * c->width[i]);
    most = PetscMax(most, c->length[i] * c->width[i]);
  }
  if (most - least <= 1e-12 * most) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatCreateVecs(S, NULL, &weights));
  PetscCall(VecGetOwnershipRange(weights, &start, &end));
  PetscCall(VecGetArrayWrite(weights, &w));
  for (PetscInt i = start; i < end; i++) {
    const PetscInt e = SlipCellsAt(c, i / components);

    w[i - start] = 2 * unit * c->length[e] * c->width[e];
  }
  PetscCall(VecRestoreArrayWrite(weights, &w));
  PetscCall(PetscObjectCompose((PetscObject)S, "SlipWeights", (PetscObject)weights));
  PetscCall(VecDestroy(&weights));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the weights of the rows of a stiffness, the areas of cells over their mean. weights: borrowed, dimensionless,
   with S's distribution, each twice for vectors of slip; NULL if all are 1, as on uniform grids. */
PetscErrorCode MatSlipGetWeights(Mat S, Vec *weights)
{
  PetscFunctionBegin;
  PetscCall(PetscObjectQuery((PetscObject)S, "SlipWeights", (PetscObject *)weights));
  PetscFunctionReturn(PETSC_SUCCESS);
}
