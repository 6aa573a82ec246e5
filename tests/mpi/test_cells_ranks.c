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
   Kn of the shares of processes against dense ones on any number of ranks. */
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
  PetscCall(SlipCellsPartition(PETSC_COMM_WORLD, &cells, "hmat", NULL, &order, &cells.nlocal));
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

/* Two patches of 48 cells 500 m apart: one block of low rank, a third of all work, whose terms are divided on several
   ranks. It is 1e-2 of the products, so that a lost term would be seen. */
static PetscErrorCode Divided(void)
{
  enum { along = 8, down = 6, half = along * down, all = 2 * half };
  static PetscReal column[5][all];
  const SlipCells cells = CellsOfColumns(all, column[0]);
  SlipCellsForecast *f;
  PetscReal blocks = 0;
  PetscMPIInt size;
  Mat dense, hmat;

  for (PetscInt e = 0; e < all; e++) {
    const PetscReal value[5] = {50 * (e % along) + 900 * (e / half), 0, 25 + 50 * (e / along % down), 50, 50};

    for (int k = 0; k < 5; k++) column[k][e] = value[k];
  }
  PetscCall(MatCreateSlipCellStiffness(PETSC_COMM_WORLD, &cells, "dense", 0.5, &dense));
  PetscCall(MatCreateSlipCellStiffness(PETSC_COMM_WORLD, &cells, "hmat", 1e-6, &hmat));
  PetscCall(Compare("hierarchical stiffness of patches", hmat, dense, 1e-7));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCall(PetscMalloc1(size, &f));
  PetscCall(SlipCellsForecasts(&cells, "hmat", 1e-6, PETSC_FALSE, size, f));
  for (PetscMPIInt r = 0; r < size; r++) blocks += f[r].blocks;
  Check(size == 1 ? blocks == 3 : blocks > 3, "%g parts of blocks on %d ranks", (double)blocks, (int)size);
  PetscCall(PetscFree(f));
  return DestroyObjects(&dense, &hmat);
}

/* What is predicted for each rank against what it has: memory within a quarter, as ranks of blocks follow from the
   tolerance alone, and numbers that blocks touch are its own
   or exchanged. */
static PetscErrorCode Forecast(void)
{
  const PetscReal number = (PetscReal)sizeof(PetscReal), index = (PetscReal)sizeof(PetscInt);
  SlipCells cells = TwoGradedFaults(NX, NZ, 1, data);
  PetscReal expected, least = 0, most = 0;
  SlipCellsForecast *f;
  PetscMPIInt rank, size;
  PetscInt *order;
  MatInfo info[2];
  Mat K;

  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCall(SlipCellsPartition(PETSC_COMM_WORLD, &cells, "hmat", NULL, &order, &cells.nlocal));
  cells.order = order;
  PetscCall(PetscMalloc1(size, &f));
  for (int k = 0; k < 2; k++) {
    const PetscReal tolerance = k ? 1e-8 : 1e-4;

    PetscCall(MatCreateSlipCellStiffness(PETSC_COMM_WORLD, &cells, "hmat", tolerance, &K));
    PetscCall(MatGetInfo(K, MAT_LOCAL, &info[k]));
    PetscCall(MatDestroy(&K));
    PetscCall(SlipCellsForecasts(&cells, "hmat", tolerance, PETSC_FALSE, size, f));
    Check(f[rank].cells == cells.nlocal, "rank %d has %d cells, predicted were %g", (int)rank, (int)cells.nlocal,
          (double)f[rank].cells);
    expected = f[rank].bytes + (number + 0.5 * index) * f[rank].touched;
    Check(info[k].memory < 1.25 * expected && info[k].memory > expected / 1.25,
          "rank %d has %g bytes to %g, predicted were %g", (int)rank, info[k].memory, (double)tolerance,
          (double)expected);
    least = PetscMax(least, expected / info[k].memory);
    most = PetscMax(most, f[rank].foreign);
    Check(f[rank].foreign >= f[rank].touched - 2 * f[rank].cells && f[rank].foreign < f[rank].touched &&
            (f[rank].foreign > 0) == (size > 1),
          "rank %d exchanges %g of %g numbers", (int)rank, (double)f[rank].foreign, (double)f[rank].touched);
  }
  PetscCall(
    PetscPrintf(PETSC_COMM_WORLD, "forecast: %g of the memory, %g numbers exchanged\n", (double)least, (double)most));
  PetscCall(PetscFree(f));
  return PetscFree(order);
}

static PetscErrorCode All(void)
{
  PetscCall(Run());
  PetscCall(Planes());
  PetscCall(Divided());
  return Forecast();
}

SLIP_RANKS(All)
