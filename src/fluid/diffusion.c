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
#include <slipstep/private/slipwork.h>

/* Largest error of a pressure over the largest change of one by the solve, where SlipDiffusionAccuracy() allows no more
 */
#define FLUID_TOLERANCE 1e-9
/* A preconditioner serves other matrices up to this ratio of steps, and until a solve takes this many more iterations
   than the first one did, and twice as many */
#define FLUID_SIMILAR 2.0
enum { FLUID_ITERATIONS = 8, FLUID_PASSES = 8 };

struct _SlipDiffusion {
  MPI_Comm comm;
  PetscInt n, all; /* cells of this process, and of all */
  SlipFluidSides sides;
  SlipFluidCell *cell; /* [n] */
  PetscReal *t;        /* [pieces of all n cells] weights, */
  PetscReal *total;    /* [n] their sums, */
  PetscReal *sum;      /* [local pieces] and those of the cells that share a piece */
  PetscReal *held;     /* [local pieces] pressure of the border, NaN elsewhere */
  PetscReal *flux;     /* [pieces of all n cells] of the last solve, outwards [m^3/s] */
  PetscReal *gathered; /* [most] pressures of the pieces of a cell */
  PetscReal *value;    /* of the matrix, cell by cell */
  PetscReal dt;        /* the matrix is that of this step; 0: of none */
  PetscReal mean;      /* dt T/C on average, by which the solver is chosen */
  PetscReal ratio;     /* largest dt T/C: also by how much rounding grows from pressures to changes by fluxes */
  PetscReal accuracy;  /* [Pa] */
  PetscBool set;
  PetscBool similar;    /* the preconditioner may be that of another matrix: */
  PetscReal made;       /* that of this step; 0: of none */
  PetscInt first, last; /* iterations of the first solve with it, -1: none; and of the last one */
  PetscInt *other;      /* [pieces of all n cells] the cell at the other side, -1: none; NULL: unknowns are sides */
  const char *prefix;   /* of the solver's options */
  Vec lambda, residual; /* of pieces, with ghosts */
  Vec right, step;      /* of the unknowns; of pieces with ghosts */
  Mat A;
  KSP ksp;
};

static SlipFluidPieces Pieces(SlipDiffusion d, PetscInt i)
{
  const PetscInt first = d->sides.offset[i];

  return (SlipFluidPieces){d->sides.offset[i + 1] - first, d->sides.side + first, d->sides.part + first, d->t + first,
                           d->gathered};
}

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
static PetscErrorCode Sum_SlipDiffusion(SlipDiffusion d, const PetscReal x[], Vec sum)
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
  PetscCall(Sum_SlipDiffusion(d, d->flux, d->residual));
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
  for (PetscInt i = 0; i < d->n; i++) {
    const SlipFluidPieces p = Pieces(d, i);

    d->total[i] = SlipFluidCellWeights(&d->cell[i], &p);
    for (PetscInt k = s->offset[i]; k < s->offset[i + 1]; k++)
      if (s->cells[s->piece[k]] == 1) d->held[s->piece[k]] = d->cell[i].border; /* such a piece has no other owner */
  }
  PetscCall(Sum_SlipDiffusion(d, d->t, d->residual));
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
  const SlipFluidPieces p = Pieces(d, i);
  const PetscInt m = p.n, *piece = d->sides.piece + d->sides.offset[i];

  SlipFluidCellMatrix(&d->cell[i], dt, &p, d->total[i], value);
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

  *diagonal = d->cell[i].storage + dt * d->cell[i].sink;
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

/* Assembles the matrix for a step. */
static PetscErrorCode Assemble_SlipDiffusion(SlipDiffusion d, PetscReal dt)
{
  PetscReal *value = d->value, mean = 0;

  PetscFunctionBegin;
  d->ratio = 0;
  for (PetscInt i = 0; i < d->n; i++) {
    const SlipFluidCell *c = &d->cell[i];

    value = d->other ? CellValues(d, i, dt, value) : SideValues(d, i, dt, value);
    d->ratio = PetscMax(d->ratio, dt * d->total[i] / (c->storage + dt * c->sink));
    mean += dt * d->total[i] / (c->storage + dt * c->sink) / (PetscReal)d->all;
  }
  PetscCall(SlipAllreduceLargest(d->comm, 1, &d->ratio));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &mean, 1, MPIU_REAL, MPIU_SUM, d->comm));
  PetscCall(MatSetValuesCOO(d->A, d->value, INSERT_VALUES));
  d->dt = dt;
  d->mean = mean;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the pressures of sides from those of the cells: such that, if these were equal to the sides' on average, the
   fluxes would cancel. */
static PetscErrorCode Guess_SlipDiffusion(SlipDiffusion d, const PetscReal y[])
{
  const SlipFluidSides *s = &d->sides;
  PetscReal *a;
  Vec local;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < d->n; i++)
    for (PetscInt k = s->offset[i]; k < s->offset[i + 1]; k++) d->flux[k] = d->t[k] * y[i];
  PetscCall(Sum_SlipDiffusion(d, d->flux, d->lambda));
  PetscCall(VecGhostGetLocalForm(d->lambda, &local));
  PetscCall(VecGetArray(local, &a));
  for (PetscInt k = 0; k < s->owned + s->ghosts; k++)
    a[k] = d->held[k] == d->held[k] ? d->held[k] : d->sum[k] > 0 ? a[k] / d->sum[k] : 0;
  PetscCall(VecRestoreArray(local, &a));
  PetscCall(VecGhostRestoreLocalForm(d->lambda, &local));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes all fluxes and d->residual, what is left of them at the sides; then takes it from the fluxes. */
static PetscErrorCode Fluxes_SlipDiffusion(SlipDiffusion d, const PetscReal y[])
{
  const SlipFluidSides *s = &d->sides;
  PetscReal *lambda = d->gathered, *a;
  Vec local;

  PetscFunctionBegin;
  PetscCall(VecGhostGetLocalForm(d->lambda, &local));
  PetscCall(VecGetArray(local, &a));
  for (PetscInt i = 0; i < d->n; i++) {
    const SlipFluidPieces p = Pieces(d, i);

    for (PetscInt k = 0; k < p.n; k++) lambda[k] = a[s->piece[s->offset[i] + k]];
    SlipFluidCellFlux(&d->cell[i], &p, y[i], lambda, d->flux + s->offset[i]);
  }
  PetscCall(VecRestoreArray(local, &a));
  PetscCall(VecGhostRestoreLocalForm(d->lambda, &local));
  PetscCall(Sum_SlipDiffusion(d, d->flux, d->residual));
  PetscCall(VecGhostGetLocalForm(d->residual, &local));
  PetscCall(VecGetArray(local, &a));
  for (PetscInt k = 0; k < s->owned + s->ghosts; k++)
    if (d->held[k] == d->held[k]) a[k] = 0;
  for (PetscInt k = 0; k < s->offset[d->n]; k++) d->flux[k] -= a[s->piece[k]] / (PetscReal)s->cells[s->piece[k]];
  PetscCall(VecRestoreArray(local, &a));
  PetscCall(VecGhostRestoreLocalForm(d->residual, &local));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What a cell lacks [m^3] at its pressure and its fluxes */
static PetscReal Lack(SlipDiffusion d, PetscInt i, PetscReal dt, PetscReal b, PetscReal y)
{
  PetscReal out = 0;

  for (PetscInt k = d->sides.offset[i]; k < d->sides.offset[i + 1]; k++) out += d->flux[k];
  return b - (d->cell[i].storage + dt * d->cell[i].sink) * y - dt * out;
}

/* Solves for d->step, with the preconditioner of another matrix where it is similar and has been good enough. */
static PetscErrorCode Solve_SlipDiffusion(SlipDiffusion d, PetscReal tolerance, Vec right)
{
  const PetscReal ratio = d->made > 0 ? d->dt / d->made : 0;
  PetscBool keep = d->similar && ratio <= FLUID_SIMILAR && ratio * FLUID_SIMILAR >= 1 ? PETSC_TRUE : PETSC_FALSE;
  KSPConvergedReason reason;

  PetscFunctionBegin;
  if (d->last > 2 * d->first + FLUID_ITERATIONS) keep = PETSC_FALSE;
  if (!keep) PetscCall(SlipFluidSolverChoose(d->ksp, d->all, d->mean));
  PetscCall(KSPSetReusePreconditioner(d->ksp, keep));
  PetscCall(KSPSetTolerances(d->ksp, tolerance, 0, PETSC_DEFAULT, PETSC_DEFAULT));
  PetscCall(KSPSolve(d->ksp, right, d->step));
  PetscCall(KSPGetConvergedReason(d->ksp, &reason));
  PetscCheck(reason > 0 || reason == KSP_DIVERGED_ITS, d->comm, PETSC_ERR_NOT_CONVERGED,
             "the diffusion of fluid over %g s: %s, expected another preconditioner (-%spc_type jacobi)", (double)d->dt,
             KSPConvergedReasons[reason], d->prefix);
  PetscCall(KSPGetIterationNumber(d->ksp, &d->last));
  if (keep) PetscFunctionReturn(PETSC_SUCCESS);
  d->first = d->last;
  d->made = d->dt;
  d->similar = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Improves the pressures of cells, whose lack [n] is theirs with the fluxes of Fluxes_SlipDiffusion(). */
static PetscErrorCode ImproveCells_SlipDiffusion(SlipDiffusion d, PetscReal tolerance, const PetscReal lack[],
                                                 PetscReal y[])
{
  const PetscReal *step;
  PetscReal *right;

  PetscFunctionBegin;
  PetscCall(VecGetArray(d->right, &right));
  PetscCall(PetscArraycpy(right, lack, d->n));
  PetscCall(VecRestoreArray(d->right, &right));
  PetscCall(Solve_SlipDiffusion(d, tolerance, d->right));
  PetscCall(VecGetArrayRead(d->step, &step));
  for (PetscInt i = 0; i < d->n; i++) y[i] += step[i];
  PetscCall(VecRestoreArrayRead(d->step, &step));
  PetscCall(Guess_SlipDiffusion(d, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Improves the pressures of sides, and of cells with them: lack [n] is theirs with the fluxes of
   Fluxes_SlipDiffusion(),
   residual that of the sides. */
static PetscErrorCode Improve_SlipDiffusion(SlipDiffusion d, PetscReal dt, PetscReal tolerance, PetscReal lack[],
                                            PetscReal y[])
{
  const SlipFluidSides *s = &d->sides;
  PetscReal *r, *a;
  Vec local;

  PetscFunctionBegin;
  PetscCall(VecGhostGetLocalForm(d->residual, &local));
  PetscCall(VecGetArray(local, &r));
  for (PetscInt i = 0; i < d->n; i++) { /* without what was taken from the fluxes */
    for (PetscInt k = s->offset[i]; k < s->offset[i + 1]; k++)
      lack[i] -= dt * r[s->piece[k]] / (PetscReal)s->cells[s->piece[k]];
    lack[i] /= d->cell[i].storage + dt * (d->cell[i].sink + d->total[i]);
    for (PetscInt k = s->offset[i]; k < s->offset[i + 1]; k++)
      d->flux[k] = dt * (d->t[k] * lack[i] + r[s->piece[k]] / (PetscReal)s->cells[s->piece[k]]);
  }
  PetscCall(VecRestoreArray(local, &r));
  PetscCall(VecGhostRestoreLocalForm(d->residual, &local));
  PetscCall(Sum_SlipDiffusion(d, d->flux, d->residual));
  PetscCall(VecGetArray(d->residual, &r));
  for (PetscInt k = 0; k < s->owned; k++)
    if (d->held[k] == d->held[k]) r[k] = 0;
  PetscCall(VecRestoreArray(d->residual, &r));
  PetscCall(Solve_SlipDiffusion(d, tolerance, d->residual));
  PetscCall(VecAXPY(d->lambda, 1, d->step));
  PetscCall(VecGhostUpdateBegin(d->lambda, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGhostUpdateEnd(d->lambda, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGhostUpdateBegin(d->step, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGhostUpdateEnd(d->step, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGhostGetLocalForm(d->step, &local));
  PetscCall(VecGetArray(local, &a));
  for (PetscInt i = 0; i < d->n; i++) {
    PetscReal in = 0;

    for (PetscInt k = s->offset[i]; k < s->offset[i + 1]; k++) in += d->t[k] * a[s->piece[k]];
    y[i] += lack[i] + dt * in / (d->cell[i].storage + dt * (d->cell[i].sink + d->total[i]));
  }
  PetscCall(VecRestoreArray(local, &a));
  PetscCall(VecGhostRestoreLocalForm(d->step, &local));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDiffusionAccuracy(SlipDiffusion d, PetscReal error)
{
  PetscFunctionBegin;
  d->accuracy = error;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDiffusionRenew(SlipDiffusion d)
{
  PetscFunctionBegin;
  d->similar = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDiffusionSolve(SlipDiffusion d, PetscReal dt, const PetscReal b[], PetscReal y[])
{
  PetscReal *start, *lack, tolerance = FLUID_TOLERANCE, allowed;

  PetscFunctionBegin;
  PetscCheck(d->set, d->comm, PETSC_ERR_ORDER, "call SlipDiffusionSet() before SlipDiffusionSolve()");
  PetscCheck(dt > 0 && !PetscIsInfReal(dt), d->comm, PETSC_ERR_ARG_OUTOFRANGE, "a step of %g s: expected more than 0",
             (double)dt);
  SlipWorkTake(); /* whether a factorisation is at hand depends on restarts, and so do flops */
  if (dt != d->dt) PetscCall(Assemble_SlipDiffusion(d, dt));
  PetscCall(PetscMalloc2(d->n, &start, d->n, &lack));
  PetscCall(PetscArraycpy(start, y, d->n));
  PetscCall(Guess_SlipDiffusion(d, y));
  for (PetscInt pass = 0;; pass++) {
    PetscReal size[3] = {0, 0, 0}; /* of corrections, of changes, of pressures */

    PetscCall(Fluxes_SlipDiffusion(d, y));
    for (PetscInt i = 0; i < d->n; i++) {
      lack[i] = Lack(d, i, dt, b[i], y[i]);
      size[0] = SlipLarger(size[0], PetscAbsReal(lack[i] / (d->cell[i].storage + dt * d->cell[i].sink)));
      size[1] = SlipLarger(size[1], PetscAbsReal(y[i] - start[i]));
      size[2] = SlipLarger(size[2], PetscAbsReal(y[i]));
    }
    PetscCall(SlipAllreduceLargest(d->comm, 3, size));
    PetscCheck(!PetscIsInfOrNanReal(size[0]), d->comm, PETSC_ERR_FP,
               "the diffusion of fluid over %g s: pressures or sources are not finite", (double)dt);
    /* enough; or no more than rounding, which iterations do not lessen */
    allowed = PetscMax(FLUID_TOLERANCE * size[1], d->accuracy);
    if (size[0] <= allowed || size[0] <= 4 * PETSC_MACHINE_EPSILON * (1 + d->ratio) * size[2]) break;
    PetscCheck(
      pass < FLUID_PASSES, d->comm, PETSC_ERR_NOT_CONVERGED,
      "the diffusion of fluid over %g s: after %d solves %g Pa of a change of %g Pa are wrong, expected another "
      "preconditioner (-%spc_type jacobi)",
      (double)dt, (int)pass, (double)size[0], (double)size[1], d->prefix);
    if (allowed > 0) tolerance = PetscMax(0.3 * allowed / size[0], 1e-13);
    if (d->other)
      PetscCall(ImproveCells_SlipDiffusion(d, PetscMin(tolerance, 0.1), lack, y));
    else
      PetscCall(Improve_SlipDiffusion(d, dt, PetscMin(tolerance, 0.1), lack, y));
  }
  for (PetscInt i = 0; i < d->n; i++) y[i] += lack[i] / (d->cell[i].storage + dt * d->cell[i].sink);
  PetscCall(PetscFree2(start, lack));
  SlipWorkSkip();
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
    const SlipFluidPieces p = Pieces(d, i);

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
