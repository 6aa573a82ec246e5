/* K and Kn of triangles on several ranks, with shares of METIS, against one process: dense entries and products in the
   order of the cells, and hierarchical products. Exit code 0: good. */
#include "ranks.h"
#include "cells.h"

enum { NX = 8, NZ = 6, N = 2 * NX * NZ, T = 2 * N };

/* The product with uniform and random slip, in the order of the cells; on every process */
static PetscErrorCode Product(Mat A, const SlipCells *c, int uniform, PetscReal product[])
{
  PetscInt start, end;
  const PetscScalar *p;
  Vec u, y;

  PetscCall(MatCreateVecs(A, &u, &y));
  PetscCall(VecGetOwnershipRange(u, &start, &end));
  for (PetscInt i = start; i < end; i++) {
    const PetscInt e = c->order ? c->order[i] : i;

    PetscCall(VecSetValue(u, i, uniform ? 1 : PetscSinReal((PetscReal)(e * e)), INSERT_VALUES));
  }
  PetscCall(VecAssemble(u));
  PetscCall(MatMult(A, u, y));
  PetscCall(PetscArrayzero(product, T));
  p = VecRead(y);
  for (PetscInt i = start; i < end; i++) product[c->order ? c->order[i] : i] = PetscRealPart(p[i - start]);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, product, T, MPIU_REAL, MPIU_SUM, PetscObjectComm((PetscObject)A)));
  return DestroyObjects(&u, &y);
}

/* To 1e-9: what is summed in another order rounds to 1e-13, and nothing else may differ. */
static PetscErrorCode Compare(PetscErrorCode (*create)(MPI_Comm, const SlipCells *, const char *, PetscReal, Mat *),
                              const SlipCells *cells, const char type[])
{
  SlipCells shared = *cells;
  PetscReal one[T], many[T], most = 0;
  PetscInt *order;
  Mat A, B;

  PetscCall(SlipCellsPartition(PETSC_COMM_WORLD, cells, type, &order, &shared.nlocal));
  shared.order = order;
  PetscCall(create(PETSC_COMM_SELF, cells, type, 1e-6, &A));
  PetscCall(create(PETSC_COMM_WORLD, &shared, type, 1e-6, &B));
  for (int uniform = 0; uniform < 2; uniform++) {
    PetscCall(Product(A, cells, uniform, one));
    PetscCall(Product(B, &shared, uniform, many));
    for (PetscInt i = 0; i < T; i++) most = PetscMax(most, PetscAbsReal(one[i]));
    for (PetscInt i = 0; i < T; i++)
      PetscCheck(PetscAbsReal(one[i] - many[i]) <= 1e-9 * most, PETSC_COMM_WORLD, PETSC_ERR_PLIB,
                 "%s: row %" PetscInt_FMT " is %.15g, expected %.15g", type, i, (double)many[i], (double)one[i]);
  }
  PetscCall(PetscFree(order));
  return DestroyObjects(&A, &B);
}

static PetscErrorCode Run(void)
{
  static PetscReal data[8 * N], more[TRIANGLE_COLUMNS * T];
  const SlipCells rectangles = TwoDippingPlanes(NX, NZ, data), cells = TrianglesOf(&rectangles, more);

  for (int hmat = 0; hmat < 2; hmat++) {
    PetscCall(Compare(MatCreateSlipCellStiffness, &cells, hmat ? "hmat" : "dense"));
    PetscCall(Compare(MatCreateSlipCellNormalStiffness, &cells, hmat ? "hmat" : "dense"));
  }
  return PETSC_SUCCESS;
}

SLIP_RANKS(Run)
