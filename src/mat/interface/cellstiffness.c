/* MatCreateSlipCellStiffness(), its variants for normal stress and for vectors of slip, and the table of types. */
#include <slipstep/rooms/slipmat.h>
#include <slipstep/rooms/slipsys.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatinterface.h>

/* Up to this many rows the stiffness is stored densely: its viscosity is then a dense square root as well. A matrix of
   blocks to 1e-4 takes less time from 450 to 800 rectangles on, and from 600 (with inertia) to 1,800 triangles
   (ruptures and cycles; whole runs). */
#define SLIP_ROWS_DENSE_MAX 800

static PetscInt RowsOf(const SlipCells *c)
{
  return c->kernel.type->components * c->n;
}

static PetscErrorCode CellForecast_Dense(const SlipCells *c, PetscBool whole, PetscReal tolerance, PetscMPIInt size,
                                         const PetscInt order[], const PetscInt count[], SlipCellsForecast forecast[])
{
  const PetscReal columns = (PetscReal)c->kernel.type->components, rows = whole ? 1 : columns, N = (PetscReal)c->n;

  PetscFunctionBegin;
  (void)tolerance;
  (void)order;
  for (PetscMPIInt r = 0; r < size; r++) {
    SlipCellsForecast *f = &forecast[r];
    const PetscReal n = (PetscReal)count[r], numbers = rows * n * columns * N;

    f->cells = n;
    f->blocks += 1;
    f->bytes += (PetscReal)sizeof(PetscReal) * numbers;
    f->pairs += N * n - (whole ? 0 : 0.5 * n * n);
    f->flops += 2 * numbers;
    f->touched += columns * N + rows * n;
    f->foreign += columns * (N - n);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes this process' rows of S, or of Kn if normal, from the kernel, except entries that follow by symmetry */
static PetscErrorCode CellMatCreate_Dense(MPI_Comm comm, const SlipCells *c, PetscReal tolerance, PetscBool normal,
                                          Mat *A)
{
  const PetscReal unit = normal ? 0 : SlipCellsUnit(c);
  const PetscInt columns = c->kernel.type->components, rows = unit == 0 ? 1 : columns;
  PetscScalar *a;
  PetscInt nlocal, rstart, rend, lda, *cell;
  SlipCellsPairs pairs;

  PetscFunctionBegin;
  (void)tolerance;
  PetscCall(SlipCellsRows(comm, c, &nlocal));
  PetscCall(MatCreateDense(comm, rows * nlocal, columns * nlocal, rows * c->n, columns * c->n, NULL, A));
  PetscCall(MatGetOwnershipRange(*A, &rstart, &rend));
  rstart /= rows;
  rend /= rows;
  PetscCall(MatDenseGetLDA(*A, &lda));
  PetscCall(MatDenseGetArrayWrite(*A, &a));
  PetscCall(PetscMalloc1(c->n, &cell));
  for (PetscInt i = 0; i < c->n; i++) cell[i] = SlipCellsAt(c, i);
  PetscCall(SlipCellsPairsCreate(c, unit, rend - rstart, cell + rstart, c->n, cell, &pairs));
  for (PetscInt j = 0; j < c->n; j++) {
    const PetscInt end = unit == 0 || j < rstart ? rend : PetscMin(j + 1, rend);

    if (end > rstart)
      SlipCellsPairsEntries(&pairs, 0, end - rstart, j, 1, lda, (PetscReal *)a + (size_t)j * columns * lda);
  }
  PetscCall(SlipCellsPairsDestroy(&pairs));
  PetscCall(PetscFree(cell));
  for (PetscInt j = rows * rstart; j < rows * rend && unit != 0; j++)
    for (PetscInt i = j + 1; i < rows * rend; i++)
      a[(size_t)j * lda + (i - rows * rstart)] = a[(size_t)i * lda + (j - rows * rstart)];
  PetscCall(MatDenseRestoreArrayWrite(*A, &a));
  PetscCall(MatAssemblyBegin(*A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*A, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One row per type of storage. */
static const struct {
  const char *name;
  PetscErrorCode (*create)(MPI_Comm, const SlipCells *, PetscReal, PetscBool, Mat *);
  PetscErrorCode (*forecast)(const SlipCells *, PetscBool, PetscReal, PetscMPIInt, const PetscInt[], const PetscInt[],
                             SlipCellsForecast[]);
} SlipCellTypes[] = {
  {"dense", CellMatCreate_Dense, CellForecast_Dense},
  {"hmat", SlipCellMatCreate_HMat, SlipHMatForecast},
};

/* Replaces "auto" by "dense" or "hmat". */
static PetscErrorCode ChooseType(const SlipCells *cells, const char **type)
{
  PetscBool match;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(*type, "auto", &match));
  if (match) *type = RowsOf(cells) > SLIP_ROWS_DENSE_MAX ? "hmat" : "dense";
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the cost [n] of each cell's row, in any unit. */
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

PetscErrorCode SlipCellsForecastOfType(const SlipCells *cells, const char type[], PetscBool whole, PetscReal tolerance,
                                       PetscMPIInt size, const PetscInt order[], const PetscInt count[],
                                       SlipCellsForecast forecast[])
{
  PetscBool match = PETSC_FALSE;
  size_t k;

  PetscFunctionBegin;
  PetscCall(ChooseType(cells, &type));
  for (k = 0; k < PETSC_STATIC_ARRAY_LENGTH(SlipCellTypes) && !match; k++)
    PetscCall(PetscStrcmp(type, SlipCellTypes[k].name, &match));
  PetscCheck(match, PETSC_COMM_SELF, PETSC_ERR_SUP, "no forecast of a stiffness of type \"%s\"", type);
  PetscCall((*SlipCellTypes[k - 1].forecast)(cells, whole, tolerance, size, order, count, forecast));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates S with weights and notes, or Kn if normal; the cells must have been checked. */
static PetscErrorCode CellMatCreate(MPI_Comm comm, const SlipCells *cells, const char asked[], PetscReal tolerance,
                                    PetscBool normal, Mat *S)
{
  SlipCells own = *cells;
  SlipShared shared;
  PetscReal *edges = NULL, *directions, *numbers;
  const PetscInt ntypes = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(SlipCellTypes);
  const char *type = asked;
  PetscBool match = PETSC_FALSE;
  PetscInt k;

  PetscFunctionBegin;
  PetscCall(ChooseType(cells, &type));
  PetscCheck(tolerance > 0 && tolerance < 1, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Tolerance of hierarchical storage must lie in (0, 1), not %g", (double)tolerance);
  for (k = 0; k < ntypes; k++) {
    PetscCall(PetscStrcmp(type, SlipCellTypes[k].name, &match));
    if (match) break;
  }
  PetscCheck(match, comm, PETSC_ERR_ARG_UNKNOWN_TYPE,
             "The stiffness of an irregular mesh cannot be of type \"%s\"; known: dense, hmat, auto", type);
  PetscCall(PetscLogEventBegin(SLIP_StiffnessSetUp, 0, 0, 0, 0));
  PetscCall(SlipSharedCreate(comm, &shared));
  PetscCall(SlipCellsDirections(cells, shared, &directions));
  own.directions = directions;
  if (own.kernel.average && !normal) PetscCall(SlipCellsEdges(&own, shared, &edges));
  own.edges = edges;
  PetscCall(SlipCellsNumbers(&own, shared, &numbers));
  own.numbers = numbers;
  PetscCall(SlipCellTypes[k].create(comm, &own, tolerance, normal, S));
  PetscCall(SlipSharedDestroy(&shared));
  PetscCall(PetscLogEventEnd(SLIP_StiffnessSetUp, 0, 0, 0, 0));
  PetscCall(SlipLogProducts(*S, SLIP_StiffnessMult));
  if (normal) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrcmp(asked, "auto", &match));
  if (match)
    PetscCall(SlipNote(*S, "SlipWhy", "auto: %s %d %s", RowsOf(cells) > SLIP_ROWS_DENSE_MAX ? "more than" : "at most",
                       SLIP_ROWS_DENSE_MAX, cells->kernel.type->components > 1 ? "rows" : "cells"));
  else
    PetscCall(SlipNote(*S, "SlipWhy", "%s as asked", type));
  PetscCall(SlipCellsCompose(*S, cells));
  PetscCall(MatSetOption(*S, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(MatSetOption(*S, MAT_SPD, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CheckNormal(MPI_Comm comm, const SlipCells *cells)
{
  PetscFunctionBegin;
  PetscCheck(cells->kernel.type->normals == 1, comm, PETSC_ERR_SUP,
             "Kernel \"%s\" has no row of normal stress, expected one that has, such as SlipKernelDipping",
             cells->kernel.type->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  MatCreateSlipCellStiffness - creates the area-weighted stiffness of irregular cells, rectangles or triangles

  Collective

  Input Parameters:
+ comm      - communicator
. cells     - the cells, the same on every process; not needed after the call
. type      - "dense" (MATDENSE), "hmat" (hierarchical, O(N log N)) or "auto"
- tolerance - relative error of each low-rank block of "hmat" in the Frobenius norm, dimensionless, in (0, 1)

  Output Parameter:
. S - symmetric matrix [Pa/m]; its rows are in cells->order, cells->nlocal on this process, or in the order of the
      cells and distributed by PETSC_DECIDE if that is NULL

  Notes:
  K_ij, the stress drop at the centre of cell i for unit slip on cell j, is not symmetric if areas differ. In the
  continuum A_i K_ij = A_j K_ji (Betti's reciprocity of the forces on two cells). Collocation at centres satisfies that
  up to its own error, so that S_ij = (A_i K_ij + A_j K_ji) / (2 mean(A)). The balance of cell i per unit area,
  M dv/dt = -H v - K u + tau, becomes w_i M dv/dt = -(w H v)_i - (S u)_i + w_i tau_i with the weights w_i =
  A_i / mean(A) of MatSlipGetWeights(): M, tau and the friction stay per unit area, all operators are symmetric,
  and u.S u / (2 N) is the mean elastic energy per unit area. On cells of one size S = (K + K')/2.

  If cells->kernel.average is set, K_ij is the average over cell i of SlipKernelAverage(), and reciprocity is exact. The
  core of an edge is SLIP_CORE_CELL times the geometric mean of the extents across it of the cells that share it, or the
  cell's own extent where no cell follows. With SLIP_AVERAGE_WHOLE it is SLIP_CORE_INNER times the former,
  SLIP_CORE_BORDER times the latter.

  Errors: those of SlipCellsCheck(), PETSC_ERR_ARG_UNKNOWN_TYPE, PETSC_ERR_ARG_OUTOFRANGE for the tolerance

  Level: intermediate

.seealso: SlipCellsPartition(), MatSlipGetWeights(), MatCreateSlipStiffness(), MatCreateSlipViscosity()
@*/
PetscErrorCode MatCreateSlipCellStiffness(MPI_Comm comm, const SlipCells *cells, const char *type, PetscReal tolerance,
                                          Mat *S)
{
  PetscFunctionBegin;
  PetscCall(SlipMatInitializePackage());
  PetscCall(SlipCellsCheck(comm, cells, "cells"));
  PetscCall(SlipKernelCheckComponents(comm, &cells->kernel, 1));
  PetscCall(CellMatCreate(comm, cells, type, tolerance, PETSC_FALSE, S));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  MatCreateSlipCellNormalStiffness - creates the matrix of the change of cells' normal stress by slip

  Collective

  Input Parameters:
+ comm      - communicator
. cells     - the cells, the same on every process, with a kernel that has a row of normal stress; not needed after the
              call
. type      - "dense" (MATDENSE), "hmat" (hierarchical, O(N log N)) or "auto"
- tolerance - relative error of each low-rank block of "hmat" in the Frobenius norm, dimensionless, in (0, 1)

  Output Parameter:
. Kn - matrix [Pa/m], neither symmetric nor weighted, with the rows of MatCreateSlipCellStiffness()

  Note: entry (i, j) is the rise of normal stress, positive in compression, at the centre of cell i for unit slip on
  cell j, along its rake: sigma = sigma0 - p + Kn u

  Errors: those of SlipCellsCheck(), PETSC_ERR_SUP for a kernel without normal stress, PETSC_ERR_ARG_UNKNOWN_TYPE,
  PETSC_ERR_ARG_OUTOFRANGE for the tolerance

  Level: intermediate

.seealso: MatCreateSlipCellStiffness(), MatSlipStiffnessMultBoth(), MatCreateSlipDippingStiffness()
@*/
PetscErrorCode MatCreateSlipCellNormalStiffness(MPI_Comm comm, const SlipCells *cells, const char *type,
                                                PetscReal tolerance, Mat *Kn)
{
  PetscFunctionBegin;
  PetscCall(SlipMatInitializePackage());
  PetscCall(SlipCellsCheck(comm, cells, "cells"));
  PetscCall(SlipKernelCheckComponents(comm, &cells->kernel, 1));
  PetscCall(CheckNormal(comm, cells));
  PetscCall(CellMatCreate(comm, cells, type, tolerance, PETSC_TRUE, Kn));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  MatCreateSlipCellVectorStiffness - creates the stiffness of irregular cells, rectangles or triangles, for slip as a
  vector in each cell's plane, and the matrix of the change of normal stress

  Collective

  Input Parameters:
+ comm      - communicator
. cells     - the cells, the same on every process, with a kernel of two components, SlipKernelDippingVector or
              SlipKernelTriangleVector, or of three, with opening, SlipKernelDippingOpening or
              SlipKernelTriangleOpening; rakes are ignored; not needed after the call
. type      - "dense" (MATDENSE), "hmat" (hierarchical, O(N log N)) or "auto"
- tolerance - relative error of each low-rank block of "hmat" in the Frobenius norm, dimensionless, in (0, 1)

  Output Parameters:
+ S  - symmetric matrix [Pa/m], 2 N x 2 N: rows and columns 2 i and 2 i + 1 are slip and shear traction along strike and
       up dip of the cell of row i in MatCreateSlipCellStiffness(); 2 cells->nlocal of them on this process, or twice
       its rows of N by PETSC_DECIDE
- Kn - matrix [Pa/m], N x 2 N, neither symmetric nor weighted: compression of the centre of a cell; NULL: it is not
       created. With opening S is 3 N x 3 N, its rows 3 i + 2 are those of compression, and Kn consists of these rows
       (MatCreateSlipNormalRows())

  Notes:
  Where K_ij [2][2] is the stress drop at the centre of cell i, or its average over the cell, for unit slip along either
  component on cell j, S_ij = (A_i K_ij + A_j K_ji^T) / (2 mean(A)), for the reasons in MatCreateSlipCellStiffness().
  Its projection on directions in the cells' planes is the scalar stiffness of these rakes.

  "auto" is "dense" up to 800 rows. Hierarchical storage uses the clusters of the scalar stiffness; a low-rank block
  has both components.

  Errors: those of SlipCellsCheck(), PETSC_ERR_SUP for a kernel of one component, or without normal stress where Kn is
  wanted, PETSC_ERR_ARG_UNKNOWN_TYPE, PETSC_ERR_ARG_OUTOFRANGE for the tolerance

  Level: intermediate

.seealso: MatCreateSlipCellStiffness(), MatCreateSlipDippingVectorStiffness(), MatSlipGetWeights(),
  MatSlipStiffnessMultBoth()
@*/
PetscErrorCode MatCreateSlipCellVectorStiffness(MPI_Comm comm, const SlipCells *cells, const char *type,
                                                PetscReal tolerance, Mat *S, Mat *Kn)
{
  PetscFunctionBegin;
  PetscCall(SlipMatInitializePackage());
  PetscCall(SlipCellsCheck(comm, cells, "cells"));
  PetscCall(SlipKernelCheckComponents(comm, &cells->kernel, 2));
  if (Kn && cells->kernel.type->components == 2) PetscCall(CheckNormal(comm, cells));
  PetscCall(CellMatCreate(comm, cells, type, tolerance, PETSC_FALSE, S));
  if (!Kn) PetscFunctionReturn(PETSC_SUCCESS);
  if (cells->kernel.type->components == 3)
    PetscCall(MatCreateSlipNormalRows(*S, Kn));
  else
    PetscCall(CellMatCreate(comm, cells, type, tolerance, PETSC_TRUE, Kn));
  PetscFunctionReturn(PETSC_SUCCESS);
}
