/* Cells of an irregular mesh: the entries of their stiffness, and what of them is kept with it. */
#include <slipmat.h>
#include <slipsys.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipmatcells.h>

int SlipCellKeyCompare(const void *a, const void *b)
{
  const SlipCellKey *p = (const SlipCellKey *)a, *q = (const SlipCellKey *)b;

  if (p->key != q->key) return p->key < q->key ? -1 : 1;
  return p->cell < q->cell ? -1 : p->cell > q->cell;
}

/* Cells whose x owns the memory of all columns. */
PetscErrorCode SlipCellsDestroy(SlipCells *cells)
{
  PetscReal *data = (PetscReal *)cells->x;

  PetscFunctionBegin;
  PetscCall(PetscFree(data));
  cells->x = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- entries ---- */

SlipCell SlipCellsGet(const SlipCells *c, PetscInt i)
{
  return (SlipCell){
    {c->x[i], c->y[i], c->z[i], c->length[i], c->width[i], c->strike ? c->strike[i] : 0, c->dip ? c->dip[i] : 90},
    c->rake ? c->rake[i] : 0,
    c->vertices ? c->vertices + 9 * (size_t)i : NULL,
    c->directions ? c->directions + 9 * (size_t)i : NULL};
}

/* directions [n][3][3] of triangles, which each of their n^2 entries asks for; NULL of rectangles, whose kernels take angles.
   PetscFree() it. */
PetscErrorCode SlipCellsDirections(const SlipCells *c, PetscReal **directions)
{
  PetscFunctionBegin;
  *directions = NULL;
  if (!c->vertices) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(9 * (size_t)c->n, directions));
  for (PetscInt i = 0; i < c->n; i++)
    SlipPlaneDirections(c->strike ? c->strike[i] : 0, c->dip ? c->dip[i] : 90, c->rake ? c->rake[i] : 0,
                        *directions + 9 * (size_t)i);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The force on cell i for unit slip on cell j */
static PetscReal Force(const SlipCells *c, PetscInt i, PetscInt j)
{
  const SlipCell receiver = SlipCellsGet(c, i), source = SlipCellsGet(c, j);
  PetscReal block[2]; /* shear, and normal where the kernel has it */

  SlipKernelBlock(&c->kernel, &receiver, &source, block);
  return c->length[i] * c->width[i] * block[0];
}

/* Compression of the centre of cell i for unit slip on cell j [Pa/m]; of kernels that have it */
PetscReal SlipCellsNormal(const SlipCells *c, PetscInt i, PetscInt j)
{
  const SlipCell receiver = SlipCellsGet(c, i), source = SlipCellsGet(c, j);
  PetscReal block[2];

  SlipKernelBlock(&c->kernel, &receiver, &source, block);
  return block[1];
}

PetscReal SlipCellsEntry(const SlipCells *c, PetscReal unit, PetscInt i, PetscInt j)
{
  if (c->kernel.average) return 2 * unit * (Force(c, i, j) + (i == j ? c->edges[i] : 0));
  return unit * (Force(c, i, j) + Force(c, j, i));
}

#define CELLS_AT_ONCE 32 /* two calls of a kernel's vectors */

/* One by one; equal bits on both sides of the diagonal */
static void EntriesSingly(const SlipCells *c, PetscReal unit, PetscInt m, const PetscInt row[], PetscInt n,
                          const PetscInt column[], PetscReal a[])
{
  for (PetscInt j = 0; j < n; j++)
    for (PetscInt i = 0; i < m; i++) {
      const PetscInt p = row[i], q = column[j];

      a[(size_t)j * m + i] =
        unit == 0 ? SlipCellsNormal(c, p, q) : SlipCellsEntry(c, unit, PetscMin(p, q), PetscMax(p, q));
    }
}

/* Entries a [m * n], column-major, of the cells of some rows and columns of the stiffness, or where unit is 0 of what slip does to normal
   stress */
void SlipCellsEntries(const SlipCells *c, PetscReal unit, PetscInt m, const PetscInt row[], PetscInt n,
                      const PetscInt column[], PetscReal a[])
{
  const size_t all = (size_t)m * n;

  if (c->kernel.average || !c->kernel.type->centres) {
    EntriesSingly(c, unit, m, row, n, column, a);
    return;
  }
  for (size_t first = 0; first < all; first += CELLS_AT_ONCE) {
    const PetscInt count = (PetscInt)PetscMin(CELLS_AT_ONCE, all - first);
    SlipCell receiver[CELLS_AT_ONCE], source[CELLS_AT_ONCE];
    PetscReal block[2 * CELLS_AT_ONCE], back[2 * CELLS_AT_ONCE];

    for (PetscInt k = 0; k < count; k++) {
      receiver[k] = SlipCellsGet(c, row[(first + k) % m]);
      source[k] = SlipCellsGet(c, column[(first + k) / m]);
    }
    (*c->kernel.type->centres)(&c->kernel, count, receiver, source, block);
    if (unit == 0) {
      for (PetscInt k = 0; k < count; k++) a[first + k] = block[2 * k + 1];
      continue;
    }
    (*c->kernel.type->centres)(&c->kernel, count, source, receiver, back);
    for (PetscInt k = 0; k < count; k++) {
      const SlipDippingRectangle *p = &receiver[k].rectangle, *q = &source[k].rectangle;

      a[first + k] = unit * (p->length * p->width * block[2 * k] + q->length * q->width * back[2 * k]);
    }
  }
}

PetscReal SlipCellsUnit(const SlipCells *c)
{
  PetscReal area = 0;

  for (PetscInt i = 0; i < c->n; i++) area += c->length[i] * c->width[i];
  return (PetscReal)c->n / (2 * area);
}

/* The weights as a vector composed with S, unless all cells have the same area to rounding. */
PetscErrorCode SlipCellsCompose(Mat S, const SlipCells *c)
{
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
    const PetscInt e = SlipCellsAt(c, i);

    w[i - start] = 2 * unit * c->length[e] * c->width[e];
  }
  PetscCall(VecRestoreArrayWrite(weights, &w));
  PetscCall(PetscObjectCompose((PetscObject)S, "SlipWeights", (PetscObject)weights));
  PetscCall(VecDestroy(&weights));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatSlipGetWeights - areas of the cells over their mean, by which the rows of a stiffness are weighted

  Not collective

  Input Parameter:
. S - stiffness

  Output Parameter:
. weights - borrowed, dimensionless, with S's distribution; NULL when all are 1, as on uniform grids

  Level: intermediate

.seealso: MatCreateSlipCellStiffness()
@*/
PetscErrorCode MatSlipGetWeights(Mat S, Vec *weights)
{
  PetscFunctionBegin;
  PetscCall(PetscObjectQuery((PetscObject)S, "SlipWeights", (PetscObject *)weights));
  PetscFunctionReturn(PETSC_SUCCESS);
}
