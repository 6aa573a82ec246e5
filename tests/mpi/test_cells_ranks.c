/* Hierarchical stiffness and Lanczos' viscosity on several ranks against dense ones. Exit code 0: good. */
#include "ranks.h"
#include "cells.h"
#include "products.h"

enum { NX = 36, NZ = 20, N = 2 * NX * NZ };

static PetscReal data[5 * N];

static PetscErrorCode Compare(const char what[], Mat A, Mat B, PetscReal tolerance)
{
  PetscReal error;
  Vec x;

  PetscCall(MatCreateVecs(B, &x, NULL));
  PetscCall(VecFillSines(x));
  PetscCall(ProductDistance(A, B, x, &error));
  Check(error <= tolerance, "%s differs by %g, expected at most %g", what, (double)error, (double)tolerance);
  return VecDestroy(&x);
}

/* Storage to 1e-6 of each low-rank block, so products to that, and the root likewise, as its condition is about 50. */
static PetscErrorCode Run(void)
{
  const SlipCells cells = TwoGradedFaults(NX, NZ, 1, data);
  Mat dense, hmat, root, lanczos;

  PetscCall(MatCreateSlipCellStiffness(PETSC_COMM_WORLD, &cells, "dense", 0.5, &dense));
  PetscCall(MatCreateSlipCellStiffness(PETSC_COMM_WORLD, &cells, "hmat", 1e-6, &hmat));
  PetscCall(MatView(hmat, PETSC_VIEWER_STDOUT_WORLD));
  PetscCall(Compare("hierarchical stiffness", hmat, dense, 1e-6));
  PetscCall(MatCreateSlipViscosity(dense, 7e6, 0.25, "lanczos", &root));
  PetscCall(MatCreateSlipViscosity(hmat, 7e6, 0.25, "lanczos", &lanczos));
  PetscCall(Compare("viscosity", lanczos, root, 1e-5));
  PetscCall(MatView(lanczos, PETSC_VIEWER_STDOUT_WORLD));
  return DestroyObjects(&dense, &hmat, &root, &lanczos);
}

/* A plane of dip 40 and a vertical one that ends at it from above, each cell with a rake of its own: hierarchical K and
   Kn of shares as METIS cuts them against dense ones on any number of ranks. */
static PetscErrorCode Planes(void)
{
  enum { along = 20, down = 16, upper = 8, all = along * (down + upper) };
  static PetscReal column[8][all];
  const PetscReal sine = PetscSinReal(40 * PETSC_PI / 180), cosine = PetscCosReal(40 * PETSC_PI / 180);
  SlipCells cells = DippingCellsOfColumns(all, column[0]);
  PetscInt *order;
  Mat K[2], Kn[2];

  for (PetscInt e = 0; e < all; e++) {
    const PetscInt j = e / along;
    const PetscBool dips = j < down;
    const PetscReal d = dips ? 50 * (j + 0.5) : 50 * 8, below = dips ? 0 : 50 * (j - down + 0.5);
    const PetscReal value[8] = {50 * (e % along + 0.5), d * cosine,  600 + d * sine - below, 50, 50, 0,
                                dips ? 40 : 90,         30 + 0.1 * e};

    for (int k = 0; k < 8; k++) column[k][e] = value[k];
  }
  PetscCall(SlipCellsPartition(PETSC_COMM_WORLD, &cells, "hmat", &order, &cells.nlocal));
  cells.order = order;
  for (int t = 0; t < 2; t++) {
    PetscCall(MatCreateSlipCellStiffness(PETSC_COMM_WORLD, &cells, t ? "hmat" : "dense", 1e-6, &K[t]));
    PetscCall(MatCreateSlipCellNormalStiffness(PETSC_COMM_WORLD, &cells, t ? "hmat" : "dense", 1e-6, &Kn[t]));
  }
  PetscCall(Compare("hierarchical stiffness of planes", K[1], K[0], 1e-6));
  /* ten times that, as slip of either sign changes normal stress by a tenth of what blocks, whose error is relative,
     hold */
  PetscCall(Compare("hierarchical normal stress of planes", Kn[1], Kn[0], 1e-5));
  for (int t = 0; t < 2; t++) PetscCall(DestroyObjects(&K[t], &Kn[t]));
  return PetscFree(order);
}

static PetscErrorCode Both(void)
{
  PetscCall(Run());
  return Planes();
}

SLIP_RANKS(Both)
