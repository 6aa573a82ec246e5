/* MatCreateSlipCellStiffness() and MatCreateSlipCellNormalStiffness(), and the table of types. */
#include <slipmat.h>
#include <slipsys.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatinterface.h>

/* Up to this many cells the stiffness is stored densely: its viscosity is then a dense square root as well. */
#define SLIP_CELLS_DENSE_MAX 3000

/* cell [n] of each row; PetscFree() it */
static PetscErrorCode CellsOfRows(const SlipCells *c, PetscInt **cell)
{
  PetscFunctionBegin;
  PetscCall(PetscMalloc1(c->n, cell));
  for (PetscInt i = 0; i < c->n; i++) (*cell)[i] = SlipCellsAt(c, i);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StiffnessCreate_Dense(MPI_Comm comm, const SlipCells *c, PetscReal tolerance, Mat *S)
{
  const PetscReal unit = SlipCellsUnit(c);
  const PetscInt nlocal = c->order ? c->nlocal : PETSC_DECIDE;
  PetscScalar *a;
  PetscInt rstart, rend, lda, *cell;

  PetscFunctionBegin;
  (void)tolerance;
  PetscCall(MatCreateDense(comm, nlocal, nlocal, c->n, c->n, NULL, S));
  PetscCall(MatGetOwnershipRange(*S, &rstart, &rend));
  PetscCall(MatDenseGetLDA(*S, &lda));
  PetscCall(MatDenseGetArrayWrite(*S, &a));
  PetscCall(CellsOfRows(c, &cell));
  for (PetscInt j = 0; j < c->n; j++) { /* those that are not mirrored */
    const PetscInt end = j < rstart ? rend : PetscMin(j + 1, rend);

    if (end > rstart)
      SlipCellsEntries(c, unit, end - rstart, cell + rstart, 1, cell + j, (PetscReal *)a + (size_t)j * lda);
  }
  PetscCall(PetscFree(cell));
  for (PetscInt j = rstart; j < rend; j++)
    for (PetscInt i = j + 1; i < rend; i++) a[(size_t)j * lda + (i - rstart)] = a[(size_t)i * lda + (j - rstart)];
  PetscCall(MatDenseRestoreArrayWrite(*S, &a));
  PetscCall(MatAssemblyBegin(*S, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*S, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode NormalCreate_Dense(MPI_Comm comm, const SlipCells *c, PetscReal tolerance, Mat *Kn)
{
  const PetscInt nlocal = c->order ? c->nlocal : PETSC_DECIDE;
  PetscScalar *a;
  PetscInt rstart, rend, lda, *cell;

  PetscFunctionBegin;
  (void)tolerance;
  PetscCall(MatCreateDense(comm, nlocal, nlocal, c->n, c->n, NULL, Kn));
  PetscCall(MatGetOwnershipRange(*Kn, &rstart, &rend));
  PetscCall(MatDenseGetLDA(*Kn, &lda));
  PetscCall(MatDenseGetArrayWrite(*Kn, &a));
  PetscCall(CellsOfRows(c, &cell));
  for (PetscInt j = 0; j < c->n && rend > rstart; j++)
    SlipCellsEntries(c, 0, rend - rstart, cell + rstart, 1, cell + j, (PetscReal *)a + (size_t)j * lda);
  PetscCall(PetscFree(cell));
  PetscCall(MatDenseRestoreArrayWrite(*Kn, &a));
  PetscCall(MatAssemblyBegin(*Kn, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*Kn, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One row per type of storage. */
static const struct {
  const char *name;
  PetscErrorCode (*create)(MPI_Comm, const SlipCells *, PetscReal, Mat *);
  PetscErrorCode (*normal)(MPI_Comm, const SlipCells *, PetscReal, Mat *);
} SlipCellTypes[] = {
  {"dense", StiffnessCreate_Dense, NormalCreate_Dense},
  {"hmat", SlipStiffnessCreate_HMat, SlipNormalCreate_HMat},
};

/* The row of a type, after "auto" was decided */
static PetscErrorCode FindType(MPI_Comm comm, const char type[], PetscReal tolerance, PetscInt *row)
{
  const PetscInt ntypes = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(SlipCellTypes);
  PetscBool match = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCheck(tolerance > 0 && tolerance < 1, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Tolerance of hierarchical storage must lie in (0, 1), not %g", (double)tolerance);
  for (*row = 0; *row < ntypes; (*row)++) {
    PetscCall(PetscStrcmp(type, SlipCellTypes[*row].name, &match));
    if (match) break;
  }
  PetscCheck(match, comm, PETSC_ERR_ARG_UNKNOWN_TYPE,
             "The stiffness of an irregular mesh cannot be of type \"%s\"; known: dense, hmat, auto", type);
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
  MatCreateSlipCellStiffness - area-weighted stiffness of irregular cells, rectangles or triangles

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

  By cells->kernel.average K_ij is the average over cell i of SlipKernelAverage(), and reciprocity is exact. The core of
  an edge is SLIP_CORE_CELL of the geometric mean of the extents across it of the cells that share it, or of the cell's own where no
  cell follows. With SLIP_AVERAGE_WHOLE it is SLIP_CORE_INNER of the former, SLIP_CORE_BORDER of the latter.

  Errors: those of SlipCellsCheck(), PETSC_ERR_ARG_UNKNOWN_TYPE, PETSC_ERR_ARG_OUTOFRANGE for the tolerance

  Level: intermediate

.seealso: SlipCellsPartition(), MatSlipGetWeights(), MatCreateSlipStiffness(), MatCreateSlipViscosity()
@*/
PetscErrorCode MatCreateSlipCellStiffness(MPI_Comm comm, const SlipCells *cells, const char *type, PetscReal tolerance,
                                          Mat *S)
{
  SlipCells own;
  PetscReal *edges = NULL, *directions;
  PetscInt k;
  PetscBool automatic;
  const char *asked = type;

  PetscFunctionBegin;
  PetscCall(SlipMatInitializePackage());
  PetscCall(SlipCellsCheck(comm, cells, "cells"));
  PetscCall(ChooseType(cells, &type));
  PetscCall(FindType(comm, type, tolerance, &k));
  PetscCall(PetscLogEventBegin(SLIP_StiffnessSetUp, 0, 0, 0, 0));
  own = *cells;
  PetscCall(SlipCellsDirections(cells, &directions));
  own.directions = directions;
  if (own.kernel.average) PetscCall(SlipCellsEdges(&own, &edges));
  own.edges = edges;
  PetscCall(SlipCellTypes[k].create(comm, &own, tolerance, S));
  PetscCall(PetscFree(directions));
  PetscCall(PetscFree(edges));
  PetscCall(PetscLogEventEnd(SLIP_StiffnessSetUp, 0, 0, 0, 0));
  PetscCall(SlipLogProducts(*S, SLIP_StiffnessMult));
  PetscCall(PetscStrcmp(asked, "auto", &automatic));
  if (automatic)
    PetscCall(SlipNote(*S, "SlipWhy", "auto: %s %d cells", cells->n > SLIP_CELLS_DENSE_MAX ? "more than" : "at most",
                       SLIP_CELLS_DENSE_MAX));
  else
    PetscCall(SlipNote(*S, "SlipWhy", "%s as asked", type));
  PetscCall(SlipCellsCompose(*S, cells));
  PetscCall(MatSetOption(*S, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(MatSetOption(*S, MAT_SPD, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  MatCreateSlipCellNormalStiffness - what slip on cells does to the normal stress of cells

  Collective

  Input Parameters:
+ comm      - communicator
. cells     - the cells, the same on every process, with a kernel that has a row of normal stress; not kept
. type      - "dense" (MATDENSE), "hmat" (hierarchical, O(N log N)) or "auto"
- tolerance - of "hmat": error of each low-rank block in the Frobenius norm, relative (dimensionless), in (0, 1)

  Output Parameter:
. Kn - matrix [Pa/m], neither symmetric nor weighted, with the rows of MatCreateSlipCellStiffness()

  Note: entry (i, j) is the rise of normal stress, positive in compression, at the centre of cell i for unit slip on cell j,
  along its rake: sigma = sigma0 - p + Kn u

  Errors: those of SlipCellsCheck(), PETSC_ERR_SUP for a kernel without normal stress, PETSC_ERR_ARG_UNKNOWN_TYPE,
  PETSC_ERR_ARG_OUTOFRANGE for the tolerance

  Level: intermediate

.seealso: MatCreateSlipCellStiffness(), MatSlipStiffnessMultBoth(), MatCreateSlipDippingStiffness()
@*/
PetscErrorCode MatCreateSlipCellNormalStiffness(MPI_Comm comm, const SlipCells *cells, const char *type,
                                                PetscReal tolerance, Mat *Kn)
{
  SlipCells own = *cells;
  PetscReal *directions;
  PetscInt k;

  PetscFunctionBegin;
  PetscCall(SlipMatInitializePackage());
  PetscCall(SlipCellsCheck(comm, cells, "cells"));
  PetscCheck(cells->kernel.type->normals == 1, comm, PETSC_ERR_SUP,
             "Kernel \"%s\" has no row of normal stress, expected one that has, such as SlipKernelDipping",
             cells->kernel.type->name);
  PetscCall(ChooseType(cells, &type));
  PetscCall(FindType(comm, type, tolerance, &k));
  PetscCall(PetscLogEventBegin(SLIP_StiffnessSetUp, 0, 0, 0, 0));
  PetscCall(SlipCellsDirections(cells, &directions));
  own.directions = directions;
  PetscCall(SlipCellTypes[k].normal(comm, &own, tolerance, Kn));
  PetscCall(PetscFree(directions));
  PetscCall(PetscLogEventEnd(SLIP_StiffnessSetUp, 0, 0, 0, 0));
  PetscCall(SlipLogProducts(*Kn, SLIP_StiffnessMult));
  PetscFunctionReturn(PETSC_SUCCESS);
}
