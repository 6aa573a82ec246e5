/* Cells of an irregular mesh: checks, the entries of their stiffness, and what of them is kept with it. */
#include <slipmat.h>
#include <slipsys.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipmatcells.h>
#include <math.h>
#include <stdlib.h>

/* ---- checks ---- */

static PetscErrorCode CheckRow(MPI_Comm comm, const SlipCells *c, PetscInt i, const char source[])
{
  const SlipCell cell = SlipCellsGet(c, i);
  const SlipDippingRectangle *r = &cell.rectangle;
  const PetscReal value[8] = {r->x, r->y, r->z, r->length, r->width, r->strike, r->dip, cell.rake};
  static const char *const name[8] = {"x", "y", "z", "length", "width", "strike", "dip", "rake"};
  static const char *const unit[8] = {"m", "m", "m", "m", "m", "degrees", "degrees", "degrees"};
  PetscReal sine, cosine;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < 8; k++) {
    PetscCheck(isfinite(value[k]), comm, PETSC_ERR_ARG_OUTOFRANGE,
               "%s: row %" PetscInt_FMT " has %s = %g %s, expected a finite number", source, i, name[k],
               (double)value[k], unit[k]);
    PetscCheck(k < 3 || k > 4 || value[k] > 0, comm, PETSC_ERR_ARG_OUTOFRANGE,
               "%s: row %" PetscInt_FMT " has %s = %g m, expected > 0", source, i, name[k], (double)value[k]);
  }
  PetscCheck(r->dip > 0 && r->dip <= 90, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "%s: row %" PetscInt_FMT " has dip = %g degrees, expected > 0 and at most 90", source, i, (double)r->dip);
  SlipDegrees(r->dip, &sine, &cosine);
  PetscCheck(
    c->kernel.full_space || r->z - 0.5 * r->width * sine >= -SLIP_TOUCH * r->width, comm, PETSC_ERR_ARG_OUTOFRANGE,
    "%s: the cell of row %" PetscInt_FMT " reaches above the surface: its centre at depth %g m, its width %g m", source,
    i, (double)r->z, (double)r->width);
  PetscFunctionReturn(PETSC_SUCCESS);
}

int SlipCellKeyCompare(const void *a, const void *b)
{
  const SlipCellKey *p = (const SlipCellKey *)a, *q = (const SlipCellKey *)b;

  if (p->key != q->key) return p->key < q->key ? -1 : 1;
  return p->cell < q->cell ? -1 : p->cell > q->cell;
}

/* Do two cells of (nearly) one plane share more than an edge? */
static PetscBool Overlap(const SlipCells *c, PetscInt i, PetscInt j)
{
  const PetscReal side =
    PetscMin(PetscMin(c->length[i], c->width[i]), PetscMin(c->length[j], c->width[j])) * SLIP_TOUCH;

  return PetscAbsReal(c->y[i] - c->y[j]) <= side &&
             PetscAbsReal(c->x[i] - c->x[j]) < 0.5 * (c->length[i] + c->length[j]) - side &&
             PetscAbsReal(c->z[i] - c->z[j]) < 0.5 * (c->width[i] + c->width[j]) - side
           ? PETSC_TRUE
           : PETSC_FALSE;
}

/* The first two rows that overlap, -1 when none do: each cell meets those that begin before it ends. */
static PetscErrorCode FindOverlap(const SlipCells *c, PetscInt rows[2])
{
  SlipCellKey *edge; /* left ones */

  PetscFunctionBegin;
  rows[0] = rows[1] = -1;
  PetscCall(PetscMalloc1(c->n, &edge));
  for (PetscInt i = 0; i < c->n; i++) edge[i] = (SlipCellKey){c->x[i] - 0.5 * c->length[i], i};
  qsort(edge, (size_t)c->n, sizeof(*edge), SlipCellKeyCompare);
  for (PetscInt i = 0; i < c->n && rows[0] < 0; i++) {
    const PetscReal right = edge[i].key + c->length[edge[i].cell];

    for (PetscInt j = i + 1; j < c->n && edge[j].key < right; j++) {
      if (!Overlap(c, edge[i].cell, edge[j].cell)) continue;
      rows[0] = PetscMin(edge[i].cell, edge[j].cell);
      rows[1] = PetscMax(edge[i].cell, edge[j].cell);
      break;
    }
  }
  PetscCall(PetscFree(edge));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipCellsCheck - refuse a mesh that no stiffness can be computed for

  Not collective, but every process of comm must pass the same cells

  Input Parameters:
+ comm   - communicator of the error messages
. cells  - the cells
- source - where they come from, for the messages

  Errors: PETSC_ERR_ARG_OUTOFRANGE for no cells, rows (counted from 0) with numbers that are not finite or extents that
  are not positive, cells above the surface, pairs of rows that overlap on one plane (edges may touch); those of
  SlipKernelCheck()

  Level: intermediate

.seealso: MatCreateSlipCellStiffness()
@*/
PetscErrorCode SlipCellsCheck(MPI_Comm comm, const SlipCells *c, const char source[])
{
  PetscInt rows[2];

  PetscFunctionBegin;
  PetscCheck(c->n > 0, comm, PETSC_ERR_ARG_OUTOFRANGE, "%s: a mesh needs at least one cell, not %" PetscInt_FMT, source,
             c->n);
  PetscCall(SlipKernelCheck(comm, &c->kernel));
  for (PetscInt i = 0; i < c->n; i++) PetscCall(CheckRow(comm, c, i, source));
  rows[0] = rows[1] = -1;
  if (!c->dip) PetscCall(FindOverlap(c, rows));
  PetscCheck(rows[0] < 0, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "%s: the cells of rows %" PetscInt_FMT " and %" PetscInt_FMT " overlap", source, rows[0], rows[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
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
    c->rake ? c->rake[i] : 0};
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
