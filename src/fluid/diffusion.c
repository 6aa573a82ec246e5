/* One implicit stage of diffusion on the cells of a fault mesh. Fluid in a fault obeys, per area,
     S w dp/dt = div(k w/eta grad p) + sources - sinks;
   a cell has one pressure, and each of its sides has one, which the cells that share it have in common (cell.c). The
   fluxes that enter a side add up to zero: that is one equation for each side, after each cell's own balance has
   given its pressure. Sides that three or more cells share, where faults meet, need nothing of their own. The matrix is
   symmetric and positive definite, and conjugate gradients solve it for the difference from a guess. Where all cells
   are rectangles that are not cut, and at most two share a side, pressures of sides are means of those of the cells and
   are eliminated instead: the usual finite volumes, with half as many unknowns and a third of the matrix.

   Mass: the fluxes that the solver leaves do not cancel exactly. What is left at a side is taken in equal shares from
   the cells there, and the balance of each cell then gives its pressure, so that fluid is conserved to rounding. That
   change of the pressures is also the measure of the solver's error: it is the residual over the storage, which bounds
   the error because the inverse of storage plus diffusion, times the storage, has no row whose sum exceeds one. */
#include <slipstep/private/slipfluid.h>
#include <slipstep/private/slipsys.h>

/* Prepares the places of the matrix's values: all pairs of the pieces of each cell; or each cell and its neighbours. */
static PetscErrorCode Matrix_SlipDiffusion(SlipDiffusion d, PetscInt start)
{
  const SlipFluidSides *s = &d->sides;
  const PetscInt rows = d->other ? d->n : s->owned;
  size_t entries = 0, k = 0;
  PetscInt *row, *column;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < d->n; i++) {
    const PetscInt m = s->offset[i + 1] - s->offset[i];

    entries += (size_t)(d->other ? 1 + m : m * m);
  }
  PetscCall(PetscMalloc1(entries, &d->value));
  PetscCall(PetscMalloc2(entries, &row, entries, &column));
  for (PetscInt i = 0; i < d->n && d->other; i++) {
    for (PetscInt a = s->offset[i] - 1; a < s->offset[i + 1]; a++) {
      row[k] = start + i;
      column[k++] = a < s->offset[i] ? start + i : d->other[a]; /* PETSc leaves out those that are negative */
    }
  }
  for (PetscInt i = 0; i < d->n && !d->other; i++)
    for (PetscInt a = s->offset[i]; a < s->offset[i + 1]; a++)
      for (PetscInt b = s->offset[i]; b < s->offset[i + 1]; b++) {
        const PetscInt p = s->piece[a], q = s->piece[b];

        row[k] = p < s->owned ? s->first + p : s->ghost[p - s->owned];
        column[k++] = q < s->owned ? s->first + q : s->ghost[q - s->owned];
      }
  PetscCall(MatCreate(d->comm, &d->A));
  PetscCall(MatSetSizes(d->A, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetType(d->A, MATAIJ));
  PetscCall(MatSetPreallocationCOO(d->A, (PetscCount)entries, row, column));
  PetscCall(MatSetOption(d->A, MAT_SPD, PETSC_TRUE));
  PetscCall(PetscFree2(row, column));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds up numbers of the pieces of all cells at their pieces, of which all processes that have them get the sum. */
PetscErrorCode SlipDiffusionSum(SlipDiffusion d, const PetscReal x[], Vec sum)
{
  PetscReal *a;
  Vec local;

  PetscFunctionBegin;
  PetscCall(VecGhostGetLocalForm(sum, &local));
  PetscCall(VecZeroEntries(local));
  PetscCall(VecGetArray(local, &a));
  for (PetscInt k = 0; k < d->sides.offset[d->n]; k++) a[d->sides.piece[k]] += x[k];
  PetscCall(VecRestoreArray(local, &a));
  PetscCall(VecGhostRestoreLocalForm(sum, &local));
  PetscCall(VecGhostUpdateBegin(sum, ADD_VALUES, SCATTER_REVERSE));
  PetscCall(VecGhostUpdateEnd(sum, ADD_VALUES, SCATTER_REVERSE));
  PetscCall(VecGhostUpdateBegin(sum, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGhostUpdateEnd(sum, INSERT_VALUES, SCATTER_FORWARD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the cells at the other sides, if unknowns can be those of the cells: the sum of both numbers, less one. */
static PetscErrorCode Neighbours_SlipDiffusion(SlipDiffusion d, PetscInt start)
{
  const SlipFluidSides *s = &d->sides;
  PetscBool simple = PETSC_TRUE;
  PetscReal *a;
  Vec local;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < d->n; i++)
    if (d->cell[i].corners == 3 || s->offset[i + 1] - s->offset[i] > 4) simple = PETSC_FALSE;
  for (PetscInt k = 0; k < s->owned + s->ghosts; k++)
    if (s->cells[k] > 2) simple = PETSC_FALSE;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &simple, 1, MPIU_BOOL, MPI_LAND, d->comm));
  if (!simple) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(s->offset[d->n] + 1, &d->other));
  for (PetscInt i = 0; i < d->n; i++)
    for (PetscInt k = s->offset[i]; k < s->offset[i + 1]; k++) d->flux[k] = (PetscReal)(start + i);
  PetscCall(SlipDiffusionSum(d, d->flux, d->residual));
  PetscCall(VecGhostGetLocalForm(d->residual, &local));
  PetscCall(VecGetArray(local, &a));
  for (PetscInt k = 0; k < s->offset[d->n]; k++)
    d->other[k] = s->cells[s->piece[k]] == 2 ? (PetscInt)(a[s->piece[k]] - d->flux[k] + 0.5) : -1;
  PetscCall(VecRestoreArray(local, &a));
  PetscCall(VecGhostRestoreLocalForm(d->residual, &local));
  PetscCall(PetscArrayzero(d->flux, s->offset[d->n]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDiffusionCreate(const SlipFaultMesh *mesh, const char prefix[], SlipDiffusion *out)
{
  SlipDiffusion d;
  PetscInt entries, local;

  PetscFunctionBegin;
  PetscCall(PetscNew(&d));
  *out = d;
  d->comm = mesh->comm;
  d->n = mesh->n;
  d->all = mesh->N;
  PetscCall(SlipFluidSidesCreate(mesh, &d->sides));
  entries = d->sides.offset[d->n];
  local = d->sides.owned + d->sides.ghosts;
  PetscCall(PetscCalloc1(d->n, &d->cell));
  PetscCall(PetscMalloc2(d->n, &d->kept, 3 * d->n, &d->couple));
  PetscCall(PetscMalloc6(entries, &d->t, d->n, &d->total, local, &d->sum, local, &d->held, entries, &d->flux,
                         d->sides.most, &d->gathered));
  PetscCall(PetscArrayzero(d->flux, entries));
  for (PetscInt i = 0; i < d->n; i++) {
    SlipFaultCell cell;

    mesh->kind->cell(mesh, SlipFaultMeshRow(mesh, i), &cell);
    SlipFluidCellShape(&cell, &d->cell[i]);
  }
  PetscCall(VecCreateGhost(d->comm, d->sides.owned, PETSC_DETERMINE, d->sides.ghosts, d->sides.ghost, &d->lambda));
  PetscCall(VecDuplicate(d->lambda, &d->residual));
  PetscCall(Neighbours_SlipDiffusion(d, mesh->start));
  PetscCall(Matrix_SlipDiffusion(d, mesh->start));
  if (d->other)
    PetscCall(MatCreateVecs(d->A, &d->step, &d->right));
  else
    PetscCall(VecDuplicate(d->lambda, &d->step));
  PetscCall(KSPCreate(d->comm, &d->ksp));
  PetscCall(KSPSetOptionsPrefix(d->ksp, prefix));
  PetscCall(KSPAppendOptionsPrefix(d->ksp, "fault_fluid_"));
  PetscCall(KSPGetOptionsPrefix(d->ksp, &d->prefix));
  PetscCall(KSPSetOperators(d->ksp, d->A, d->A));
  PetscCall(KSPSetType(d->ksp, KSPCG));
  PetscCall(KSPSetFromOptions(d->ksp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDiffusionDestroy(SlipDiffusion *out)
{
  SlipDiffusion d = *out;

  PetscFunctionBegin;
  if (!d) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(KSPDestroy(&d->ksp));
  PetscCall(MatDestroy(&d->A));
  PetscCall(VecDestroy(&d->lambda));
  PetscCall(VecDestroy(&d->residual));
  PetscCall(VecDestroy(&d->right));
  PetscCall(VecDestroy(&d->step));
  PetscCall(PetscFree(d->other));
  PetscCall(PetscFree(d->cell));
  PetscCall(PetscFree(d->value));
  PetscCall(PetscFree2(d->kept, d->couple));
  PetscCall(PetscFree6(d->t, d->total, d->sum, d->held, d->flux, d->gathered));
  PetscCall(SlipFluidSidesDestroy(&d->sides));
  PetscCall(PetscFree(*out));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies coefficients, checked, and finds out whether one differs from what is there. */
static PetscErrorCode Take_SlipDiffusion(SlipDiffusion d, const SlipDiffusionCells *from, PetscBool *differs)
{
  PetscReal x[5] = {0};
  PetscInt bad = 0, flags[2];
  PetscMPIInt rank, size;

  PetscFunctionBegin;
  *differs = d->set ? PETSC_FALSE : PETSC_TRUE;
  for (PetscInt i = 0; i < d->n; i++) {
    const SlipFluidCell old = d->cell[i];
    SlipFluidCell *c = &d->cell[i];

    c->storage = from->storage[i];
    c->along = from->along[i];
    c->down = from->down[i];
    c->sink = from->sink ? from->sink[i] : 0;
    c->border = from->border ? from->border[i] : (PetscReal)NAN;
    if (c->storage != old.storage || c->along != old.along || c->down != old.down || c->sink != old.sink ||
        (c->border != old.border && (c->border == c->border || old.border == old.border)))
      *differs = PETSC_TRUE;
    if (!(c->storage > 0 && c->along >= 0 && c->down >= 0 && c->sink >= 0) ||
        PetscIsInfReal(c->storage + c->along + c->down + c->sink) || PetscIsInfReal(c->border))
      if (!bad) bad = i + 1;
  }
  PetscCallMPI(MPI_Comm_rank(d->comm, &rank));
  PetscCallMPI(MPI_Comm_size(d->comm, &size));
  flags[0] = *differs;
  flags[1] = bad ? size - rank : 0; /* the first process that has one */
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, flags, 2, MPIU_INT, MPI_MAX, d->comm));
  *differs = flags[0] ? PETSC_TRUE : PETSC_FALSE;
  if (!flags[1]) PetscFunctionReturn(PETSC_SUCCESS);
  if (bad && flags[1] == size - rank) {
    const SlipFluidCell *c = &d->cell[bad - 1];

    x[0] = c->storage, x[1] = c->along, x[2] = c->down, x[3] = c->sink, x[4] = c->border;
  }
  PetscCallMPI(MPI_Bcast(x, 5, MPIU_REAL, size - (PetscMPIInt)flags[1], d->comm));
  SETERRQ(
    d->comm, PETSC_ERR_ARG_OUTOFRANGE,
    "diffusion in a cell with storage %g m^3/Pa, mobility %g and %g m^3/(Pa s), leak-off %g m^3/(Pa s) and border "
    "pressure %g Pa: expected finite numbers, storage > 0 and no other one negative",
    (double)x[0], (double)x[1], (double)x[2], (double)x[3], (double)x[4]);
}

PetscErrorCode SlipDiffusionSet(SlipDiffusion d, const SlipDiffusionCells *cells)
{
  const SlipFluidSides *s = &d->sides;
  PetscBool differs;
  PetscReal *a;
  Vec local;

  PetscFunctionBegin;
  PetscCall(Take_SlipDiffusion(d, cells, &differs));
  if (!differs) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < s->owned + s->ghosts; k++) d->held[k] = (PetscReal)NAN;
  d->fastest = 0;
  for (PetscInt i = 0; i < d->n; i++) {
    const SlipFluidPieces p = SlipFluidPiecesOf(d, i);

    d->total[i] = SlipFluidCellWeights(&d->cell[i], &p);
    for (PetscInt k = s->offset[i]; k < s->offset[i + 1]; k++)
      if (s->cells[s->piece[k]] == 1) d->held[s->piece[k]] = d->cell[i].border; /* such a piece has no other owner */
  }
  for (PetscInt i = 0; i < d->n; i++) d->fastest = PetscMax(d->fastest, d->total[i] / d->cell[i].storage);
  PetscCall(SlipAllreduceLargest(d->comm, 1, &d->fastest));
  PetscCall(SlipDiffusionSum(d, d->t, d->residual));
  PetscCall(VecGhostGetLocalForm(d->residual, &local));
  PetscCall(VecGetArray(local, &a));
  PetscCall(PetscArraycpy(d->sum, a, s->owned + s->ghosts));
  PetscCall(VecRestoreArray(local, &a));
  PetscCall(VecGhostRestoreLocalForm(d->residual, &local));
  d->set = PETSC_TRUE;
  d->dt = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Values of the matrix for the pieces of cell i; the rows of pieces whose pressure is held, or through which nothing
   can flow, are those of a diagonal matrix. Returns the place of the next cell's. */
static PetscReal *SideValues(SlipDiffusion d, PetscInt i, PetscReal dt, PetscReal *value)
{
  const SlipFluidPieces p = SlipFluidPiecesOf(d, i);
  const PetscInt m = p.n, *piece = d->sides.piece + d->sides.offset[i];

  SlipFluidCellMatrix(&d->cell[i], d->kept[i], dt, &p, d->total[i], value);
  for (PetscInt a = 0; a < m; a++) {
    if (d->sum[piece[a]] == 0) value[m * a + a] = 1;
    if (d->held[piece[a]] != d->held[piece[a]]) continue;
    for (PetscInt b = 0; b < m; b++)
      if (b != a) value[m * a + b] = value[m * b + a] = 0;
  }
  return value + m * m;
}

/* Values of the row of cell i, where the pressures of sides are eliminated */
static PetscReal *CellValues(SlipDiffusion d, PetscInt i, PetscReal dt, PetscReal *value)
{
  PetscReal *diagonal = value++;

  *diagonal = d->kept[i];
  for (PetscInt k = d->sides.offset[i]; k < d->sides.offset[i + 1]; k++, value++) {
    const PetscInt piece = d->sides.piece[k];
    const PetscReal t = d->held[piece] == d->held[piece]  ? d->t[k]
                        : d->other[k] >= 0 && d->t[k] > 0 ? d->t[k] * ((d->sum[piece] - d->t[k]) / d->sum[piece])
                                                          : 0;

    *diagonal += dt * t;
    *value = -dt * t;
  }
  return value;
}

/* Assembles the matrix for a step, unless it is. */
PetscErrorCode SlipDiffusionAssemble(SlipDiffusion d, PetscReal dt)
{
  PetscReal *value = d->value, mean = 0;

  PetscFunctionBegin;
  if (dt == d->dt) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < d->n; i++) {
    value = d->other ? CellValues(d, i, dt, value) : SideValues(d, i, dt, value);
    mean += dt * d->total[i] / d->kept[i] / (PetscReal)d->all;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &mean, 1, MPIU_REAL, MPIU_SUM, d->comm));
  PetscCall(MatSetValuesCOO(d->A, d->value, INSERT_VALUES));
  d->dt = dt;
  d->mean = mean;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDiffusionMost(SlipDiffusion d, PetscInt *most)
{
  PetscFunctionBegin;
  *most = d->other ? 0 : d->sides.most;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, 1, MPIU_INT, MPI_MAX, d->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDiffusionFlow(SlipDiffusion d, PetscReal *border, PetscReal flux[])
{
  const SlipFluidSides *s = &d->sides;

  PetscFunctionBegin;
  if (border) {
    *border = 0;
    for (PetscInt k = 0; k < s->offset[d->n]; k++)
      if (s->cells[s->piece[k]] == 1) *border += d->flux[k];
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, border, 1, MPIU_REAL, MPIU_SUM, d->comm));
  }
  for (PetscInt i = 0; i < d->n && flux; i++) {
    const SlipFluidPieces p = SlipFluidPiecesOf(d, i);

    SlipFluidCellCentre(&d->cell[i], &p, d->flux + s->offset[i], flux + 2 * i);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDiffusionRadius(SlipDiffusion d, PetscReal radius[])
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < d->n; i++) radius[i] = SlipFluidCellRadius(&d->cell[i]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDiffusionBodies(SlipDiffusion d, PetscInt *bodies, PetscInt *apart, PetscInt faults[2])
{
  PetscFunctionBegin;
  *bodies = d->sides.bodies.bodies;
  *apart = d->sides.bodies.apart;
  for (int k = 0; k < 2; k++) faults[k] = d->sides.bodies.fault[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDiffusionView(SlipDiffusion d, PetscViewer viewer)
{
  PetscInt pieces;

  PetscFunctionBegin;
  PetscCall(VecGetSize(d->lambda, &pieces));
  PetscCall(PetscViewerASCIIPrintf(viewer, "Diffusion of fluid: %d sides, unknowns of the %s, %d bodies\n", (int)pieces,
                                   d->other ? "cells" : "sides", (int)d->sides.bodies.bodies));
  PetscCall(PetscViewerASCIIPushTab(viewer));
  PetscCall(KSPView(d->ksp, viewer));
  PetscCall(PetscViewerASCIIPopTab(viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}
