/* Operators of cells, for slip along rakes and as a vector, on several ranks against one process: dense and
   hierarchical, with shares of equal cost and without an order, those of grids, and their distribution. Exit code 0:
   good. */
#include "ranks.h"
#include "cells.h"

enum { NX = 8, NZ = 6, N = 2 * NX * NZ, T = 2 * N };

/* The products with uniform slip along strike, up dip, and with random slip, rows [n] for each cell in the order of the
   cells; on every process */
static PetscErrorCode Product(Mat A, const PetscInt order[], PetscInt n, int slip, PetscReal product[])
{
  PetscInt start, end, columns, rows;
  const PetscScalar *p;
  Vec u, y;

  PetscCall(MatCreateVecs(A, &u, &y));
  PetscCall(VecGetSize(u, &columns));
  PetscCall(VecGetSize(y, &rows));
  columns /= n;
  rows /= n;
  PetscCall(VecGetOwnershipRange(u, &start, &end));
  for (PetscInt i = start; i < end; i++) {
    const PetscInt e = order ? order[i / columns] : i / columns, number = columns * e + i % columns;

    PetscCall(VecSetValue(u, i, slip == 2 ? PetscSinReal((PetscReal)(number * number)) : number % columns == slip,
                          INSERT_VALUES));
  }
  PetscCall(VecAssemble(u));
  PetscCall(MatMult(A, u, y));
  PetscCall(PetscArrayzero(product, rows * n));
  PetscCall(VecGetOwnershipRange(y, &start, &end));
  p = VecRead(y);
  for (PetscInt i = start; i < end; i++)
    product[rows * (order ? order[i / rows] : i / rows) + i % rows] = PetscRealPart(p[i - start]);
  PetscCallMPI(
    MPI_Allreduce(MPI_IN_PLACE, product, (int)(rows * n), MPIU_REAL, MPIU_SUM, PetscObjectComm((PetscObject)A)));
  return DestroyObjects(&u, &y);
}

/* To 1e-9: what is summed in another order rounds to 1e-13, and nothing else may differ. */
static PetscErrorCode Compare(Mat one, Mat many, const PetscInt order[], PetscInt n, const char type[])
{
  static PetscReal a[2 * T], b[2 * T];
  PetscReal most = 0;
  PetscInt rows;

  PetscCall(MatGetSize(one, &rows, NULL));
  for (int slip = 0; slip < 3; slip++) {
    PetscCall(Product(one, NULL, n, slip, a));
    PetscCall(Product(many, order, n, slip, b));
    for (PetscInt i = 0; i < rows; i++) most = PetscMax(most, PetscAbsReal(a[i]));
    for (PetscInt i = 0; i < rows; i++)
      Check(PetscAbsReal(a[i] - b[i]) <= 1e-9 * most, "%s: row %" PetscInt_FMT " is %.15g, expected %.15g", type, i,
            (double)b[i], (double)a[i]);
  }
  return PETSC_SUCCESS;
}

/* Rows and columns of S for each component where the cells' rows are, and of Kn one row and as many columns */
static PetscErrorCode CheckShares(Mat S, Mat Kn, PetscInt components, PetscInt cells)
{
  PetscInt m, n;

  PetscCall(MatGetLocalSize(S, &m, &n));
  Check(m == components * cells && n == components * cells, "S has %" PetscInt_FMT " x %" PetscInt_FMT " here", m, n);
  PetscCall(MatGetLocalSize(Kn, &m, &n));
  Check(m == cells && n == components * cells, "Kn has %" PetscInt_FMT " x %" PetscInt_FMT " here", m, n);
  return PETSC_SUCCESS;
}

static PetscErrorCode Create(MPI_Comm comm, const SlipCells *c, const char type[], Mat *S, Mat *Kn)
{
  if (c->kernel.type->components > 1) return MatCreateSlipCellVectorStiffness(comm, c, type, 1e-6, S, Kn);
  PetscCall(MatCreateSlipCellStiffness(comm, c, type, 1e-6, S));
  return MatCreateSlipCellNormalStiffness(comm, c, type, 1e-6, Kn);
}

static PetscErrorCode OfCells(const SlipCells *cells, const char type[], PetscBool shares)
{
  SlipCells shared = *cells;
  PetscInt *order = NULL, n = cells->n, nlocal = PETSC_DECIDE;
  Mat S[2], Kn[2];

  if (shares) PetscCall(SlipCellsPartition(PETSC_COMM_WORLD, cells, type, NULL, &order, &shared.nlocal));
  shared.order = order;
  if (shares)
    nlocal = shared.nlocal;
  else
    PetscCall(PetscSplitOwnership(PETSC_COMM_WORLD, &nlocal, &n));
  PetscCall(Create(PETSC_COMM_SELF, cells, type, &S[0], &Kn[0]));
  PetscCall(Create(PETSC_COMM_WORLD, &shared, type, &S[1], &Kn[1]));
  PetscCall(CheckShares(S[1], Kn[1], cells->kernel.type->components, nlocal));
  PetscCall(Compare(S[0], S[1], order, n, type));
  PetscCall(Compare(Kn[0], Kn[1], order, n, type));
  for (int k = 0; k < 2; k++) PetscCall(DestroyObjects(&S[k], &Kn[k]));
  return PetscFree(order);
}

/* An odd number of cells, so that shares of rows are not shares of cells; with the root and the stage operator, which
   is of both */
static PetscErrorCode OfGrid(const SlipKernel *kernel, const char type[])
{
  const SlipDippingGrid grid = {.grid = {9, 7, 900, 560, 0, *kernel}, .dip = 40, .tolerance = 1e-12};
  PetscInt n = 9 * 7, nlocal = PETSC_DECIDE;
  Mat S[2], Kn[2], H[2], B[2];

  PetscCall(PetscSplitOwnership(PETSC_COMM_WORLD, &nlocal, &n));
  PetscCall(MatCreateSlipDippingVectorStiffness(PETSC_COMM_SELF, &grid, "dense", &S[0], &Kn[0]));
  PetscCall(MatCreateSlipDippingVectorStiffness(PETSC_COMM_WORLD, &grid, type, &S[1], &Kn[1]));
  PetscCall(CheckShares(S[1], Kn[1], 2, nlocal));
  PetscCall(Compare(S[0], S[1], NULL, n, type));
  PetscCall(Compare(Kn[0], Kn[1], NULL, n, type));
  for (int k = 0; k < 2; k++) {
    PetscCall(MatCreateSlipViscosity(S[k], 7.5e6, 0.25, "sqrtm", &H[k]));
    PetscCall(MatCreateSlipStage(S[k], H[k], 7.5e6, &B[k]));
    PetscCall(MatSlipStageSetTheta(B[k], 0.02));
  }
  PetscCall(Compare(B[0], B[1], NULL, n, type));
  for (int k = 0; k < 2; k++) PetscCall(DestroyObjects(&B[k], &H[k], &S[k], &Kn[k]));
  return PETSC_SUCCESS;
}

/* In a full space K alone has transforms in depth. */
static PetscErrorCode OfFullSpace(const SlipKernel *kernel)
{
  SlipDippingGrid grid = {.grid = {9, 7, 900, 560, 0, *kernel}, .dip = 90};
  Mat S[2];

  grid.grid.kernel.full_space = PETSC_TRUE;
  PetscCall(MatCreateSlipDippingVectorStiffness(PETSC_COMM_SELF, &grid, "dense", &S[0], NULL));
  PetscCall(MatCreateSlipDippingVectorStiffness(PETSC_COMM_WORLD, &grid, "fft", &S[1], NULL));
  PetscCall(Compare(S[0], S[1], NULL, 9 * 7, "fft in a full space"));
  return DestroyObjects(&S[0], &S[1]);
}

static PetscErrorCode Run(void)
{
  static PetscReal data[8 * N], more[TRIANGLE_COLUMNS * T];
  SlipCells rectangles = TwoDippingPlanes(NX, NZ, data), triangles = TrianglesOf(&rectangles, more), rakes = triangles;

  rectangles.kernel.type = &SlipKernelDippingVector;
  triangles.kernel.type = &SlipKernelTriangleVector;
  for (int shares = 0; shares < 2; shares++)
    for (int hmat = 0; hmat < 2; hmat++) {
      PetscCall(OfCells(&rectangles, hmat ? "hmat" : "dense", (PetscBool)shares));
      PetscCall(OfCells(&triangles, hmat ? "hmat" : "dense", (PetscBool)shares));
      PetscCall(OfCells(&rakes, hmat ? "hmat" : "dense", (PetscBool)shares));
    }
  PetscCall(OfGrid(&rectangles.kernel, "dense"));
  PetscCall(OfGrid(&rectangles.kernel, "hmat"));
  PetscCall(OfFullSpace(&rectangles.kernel));
  return OfGrid(&rectangles.kernel, "fft");
}

SLIP_RANKS(Run)
