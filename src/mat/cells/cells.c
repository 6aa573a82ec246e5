/* Cells of an irregular mesh: checks, the entries of their stiffness, and MatCreateSlipCellStiffness(). */
#include <slipmat.h>
#include <slipsys.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmathmatrix.h>
#include <math.h>
#include <stdlib.h>

/* Up to this many cells the stiffness is stored densely: its viscosity is then a dense square root as well. */
#define SLIP_CELLS_DENSE_MAX 3000
/* Edges that differ by less than this share of the smaller cell touch. */
#define SLIP_CELLS_TOUCH 1e-6

/* ---- checks ---- */

static PetscErrorCode CheckRow(MPI_Comm comm, const SlipCells *c, PetscInt i, const char source[])
{
  const PetscReal value[5] = {c->x[i], c->y[i], c->z[i], c->length[i], c->width[i]};
  static const char *const name[5] = {"x", "y", "z", "length", "width"};

  PetscFunctionBegin;
  for (PetscInt k = 0; k < 5; k++) {
    PetscCheck(isfinite(value[k]), comm, PETSC_ERR_ARG_OUTOFRANGE,
               "%s: row %" PetscInt_FMT " has %s = %g m, expected a finite number", source, i, name[k],
               (double)value[k]);
    PetscCheck(k < 3 || value[k] > 0, comm, PETSC_ERR_ARG_OUTOFRANGE,
               "%s: row %" PetscInt_FMT " has %s = %g m, expected > 0", source, i, name[k], (double)value[k]);
  }
  PetscCheck(
    c->full_space || c->z[i] - 0.5 * c->width[i] >= -SLIP_CELLS_TOUCH * c->width[i], comm, PETSC_ERR_ARG_OUTOFRANGE,
    "%s: the cell of row %" PetscInt_FMT " reaches above the surface: its centre at depth %g m, its width %g m", source,
    i, (double)c->z[i], (double)c->width[i]);
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
    PetscMin(PetscMin(c->length[i], c->width[i]), PetscMin(c->length[j], c->width[j])) * SLIP_CELLS_TOUCH;

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
  are not positive, cells above the surface, pairs of rows that overlap on one plane (edges may touch), and elastic
  constants out of range

  Level: intermediate

.seealso: MatCreateSlipCellStiffness()
@*/
PetscErrorCode SlipCellsCheck(MPI_Comm comm, const SlipCells *c, const char source[])
{
  PetscInt rows[2];

  PetscFunctionBegin;
  PetscCheck(c->n > 0, comm, PETSC_ERR_ARG_OUTOFRANGE, "%s: a mesh needs at least one cell, not %" PetscInt_FMT, source,
             c->n);
  PetscCheck(c->shear_modulus > 0 && isfinite(c->shear_modulus), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Shear modulus must be positive and finite, not %g Pa", (double)c->shear_modulus);
  PetscCheck(c->poisson_ratio > -1 && c->poisson_ratio < 0.5, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Poisson's ratio must lie in (-1, 0.5), not %g", (double)c->poisson_ratio);
  for (PetscInt i = 0; i < c->n; i++) PetscCall(CheckRow(comm, c, i, source));
  PetscCall(FindOverlap(c, rows));
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

static PetscReal AreaTimesKernel(const SlipCells *c, PetscInt i, PetscInt j)
{
  return c->length[i] * c->width[i] *
         SlipKernelOffset(c->shear_modulus, c->poisson_ratio, c->x[i] - c->x[j], c->y[i] - c->y[j], c->z[i], c->z[j],
                          c->length[j], c->width[j], c->full_space);
}

PetscReal SlipCellsEntry(const SlipCells *c, PetscReal unit, PetscInt i, PetscInt j)
{
  return unit * (AreaTimesKernel(c, i, j) + AreaTimesKernel(c, j, i));
}

PetscReal SlipCellsUnit(const SlipCells *c)
{
  PetscReal area = 0;

  for (PetscInt i = 0; i < c->n; i++) area += c->length[i] * c->width[i];
  return (PetscReal)c->n / (2 * area);
}

static PetscErrorCode StiffnessCreate_Dense(MPI_Comm comm, const SlipCells *c, PetscReal tolerance, Mat *S)
{
  const PetscReal unit = SlipCellsUnit(c);
  const PetscInt nlocal = c->order ? c->nlocal : PETSC_DECIDE;
  PetscScalar *a;
  PetscInt rstart, rend, lda;

  PetscFunctionBegin;
  (void)tolerance;
  PetscCall(MatCreateDense(comm, nlocal, nlocal, c->n, c->n, NULL, S));
  PetscCall(MatGetOwnershipRange(*S, &rstart, &rend));
  PetscCall(MatDenseGetLDA(*S, &lda));
  PetscCall(MatDenseGetArrayWrite(*S, &a));
  for (PetscInt j = 0; j < c->n; j++)
    for (PetscInt i = rstart; i < rend; i++) {
      const PetscBool mirrored = (PetscBool)(j >= rstart && j < i);
      const PetscInt p = SlipCellsAt(c, i), q = SlipCellsAt(c, j);

      a[(size_t)j * lda + (i - rstart)] =
        mirrored ? 0 : SlipCellsEntry(c, unit, PetscMin(p, q), PetscMax(p, q)); /* equal bits on both sides */
    }
  for (PetscInt j = rstart; j < rend; j++)
    for (PetscInt i = j + 1; i < rend; i++) a[(size_t)j * lda + (i - rstart)] = a[(size_t)i * lda + (j - rstart)];
  PetscCall(MatDenseRestoreArrayWrite(*S, &a));
  PetscCall(MatAssemblyBegin(*S, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*S, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The weights as a vector composed with S, unless all cells have the same area to rounding. */
static PetscErrorCode ComposeWeights(Mat S, const SlipCells *c)
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

/* ---- the cells behind a stiffness ---- */

static PetscErrorCode CellsDestroy(SlipContainerArg arg)
{
  SlipCells *c = (SlipCells *)SlipContainerArgPointer(arg);
  PetscInt *order = (PetscInt *)c->order;

  PetscFunctionBegin;
  PetscCall(PetscFree(order));
  PetscCall(SlipCellsDestroy(c));
  PetscCall(PetscFree(c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A copy of the cells, composed with S. */
static PetscErrorCode ComposeCells(Mat S, const SlipCells *cells)
{
  const PetscReal *const from[5] = {cells->x, cells->y, cells->z, cells->length, cells->width};
  const size_t n = (size_t)cells->n;
  PetscReal *data;
  PetscInt *order = NULL;
  SlipCells *c;

  PetscFunctionBegin;
  PetscCall(PetscNew(&c));
  *c = *cells;
  PetscCall(PetscMalloc1(5 * n, &data));
  for (size_t k = 0; k < 5; k++) PetscCall(PetscArraycpy(data + k * n, from[k], n));
  c->x = data;
  c->y = data + n;
  c->z = data + 2 * n;
  c->length = data + 3 * n;
  c->width = data + 4 * n;
  if (cells->order) {
    PetscCall(PetscMalloc1(n, &order));
    PetscCall(PetscArraycpy(order, cells->order, n));
  }
  c->order = order;
  PetscCall(SlipObjectComposeData((PetscObject)S, "SlipCells", c, CellsDestroy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipCellsOf(Mat S, const SlipCells **cells)
{
  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)S, "SlipCells", cells));
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

/* One row per type of storage. */
static const struct {
  const char *name;
  PetscErrorCode (*create)(MPI_Comm, const SlipCells *, PetscReal, Mat *);
} SlipCellTypes[] = {
  {"dense", StiffnessCreate_Dense},
  {"hmat", SlipStiffnessCreate_HMat},
};

/* "dense" or "hmat" in place of "auto". */
static PetscErrorCode ChooseType(const SlipCells *cells, const char **type)
{
  PetscBool match;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(*type, "auto", &match));
  if (match) *type = cells->n > SLIP_CELLS_DENSE_MAX ? "hmat" : "dense";
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* cost [n]: what the row of each cell takes, in any unit. */
PetscErrorCode SlipCellsCosts(const SlipCells *cells, const char type[], PetscReal cost[])
{
  PetscBool hmat;

  PetscFunctionBegin;
  PetscCall(ChooseType(cells, &type));
  PetscCall(PetscStrcmp(type, "hmat", &hmat));
  if (hmat)
    PetscCall(SlipHMatCosts(cells, cost));
  else
    for (PetscInt i = 0; i < cells->n; i++) cost[i] = 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  MatCreateSlipCellStiffness - area-weighted stiffness of rectangular cells on parallel vertical strike-slip planes

  Collective

  Input Parameters:
+ comm      - communicator
. cells     - the cells, the same on every process; not kept
. type      - "dense" (MATDENSE), "hmat" (hierarchical, O(N log N)) or "auto"
- tolerance - of "hmat": error of each low-rank block in the Frobenius norm, relative (dimensionless), in (0, 1)

  Output Parameter:
. S - symmetric matrix [Pa/m]; its rows are in cells->order, cells->nlocal on this process, or in the order of the
      cells and distributed by PETSC_DECIDE when that is NULL

  Notes:
  K_ij, the stress drop at the centre of cell i for unit slip on cell j, is not symmetric when areas differ. In the
  continuum A_i K_ij = A_j K_ji (Betti's reciprocity of the forces on two cells); collocation at centres keeps that up
  to its own error, so S_ij = (A_i K_ij + A_j K_ji) / (2 mean(A)) is used. The balance of cell i per unit area,
  M dv/dt = -H v - K u + tau, becomes w_i M dv/dt = -(w H v)_i - (S u)_i + w_i tau_i with the weights w_i =
  A_i / mean(A) of MatSlipGetWeights(): M, tau and the friction stay per unit area, all operators are symmetric,
  and u.S u / (2 N) is the mean elastic energy per unit area. On cells of one size S = (K + K')/2.

  Errors: those of SlipCellsCheck(), PETSC_ERR_ARG_UNKNOWN_TYPE, PETSC_ERR_ARG_OUTOFRANGE for the tolerance

  Level: intermediate

.seealso: SlipCellsPartition(), MatSlipGetWeights(), MatCreateSlipStiffness(), MatCreateSlipViscosity()
@*/
PetscErrorCode MatCreateSlipCellStiffness(MPI_Comm comm, const SlipCells *cells, const char *type, PetscReal tolerance,
                                          Mat *S)
{
  const PetscInt ntypes = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(SlipCellTypes);
  PetscInt k;
  PetscBool match = PETSC_FALSE, automatic;
  const char *asked = type;

  PetscFunctionBegin;
  PetscCall(SlipStepInitializePackage());
  PetscCall(SlipCellsCheck(comm, cells, "cells"));
  PetscCheck(tolerance > 0 && tolerance < 1, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Tolerance of hierarchical storage must lie in (0, 1), not %g", (double)tolerance);
  PetscCall(ChooseType(cells, &type));
  for (k = 0; k < ntypes; k++) {
    PetscCall(PetscStrcmp(type, SlipCellTypes[k].name, &match));
    if (match) break;
  }
  PetscCheck(match, comm, PETSC_ERR_ARG_UNKNOWN_TYPE,
             "The stiffness of an irregular mesh cannot be of type \"%s\"; known: dense, hmat, auto", type);
  PetscCall(PetscLogEventBegin(SLIP_StiffnessSetUp, 0, 0, 0, 0));
  PetscCall(SlipCellTypes[k].create(comm, cells, tolerance, S));
  PetscCall(PetscLogEventEnd(SLIP_StiffnessSetUp, 0, 0, 0, 0));
  PetscCall(SlipLogProducts(*S, SLIP_StiffnessMult));
  PetscCall(PetscStrcmp(asked, "auto", &automatic));
  if (automatic)
    PetscCall(SlipNote(*S, "SlipWhy", "auto: %s %d cells", cells->n > SLIP_CELLS_DENSE_MAX ? "more than" : "at most",
                       SLIP_CELLS_DENSE_MAX));
  else
    PetscCall(SlipNote(*S, "SlipWhy", "%s as asked", type));
  PetscCall(ComposeWeights(*S, cells));
  PetscCall(ComposeCells(*S, cells));
  PetscCall(MatSetOption(*S, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(MatSetOption(*S, MAT_SPD, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}
