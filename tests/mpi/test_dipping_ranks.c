/* Products of a dipping plane by transforms on several ranks against dense matrices. Exit code 0: good. */
#include "ranks.h"
#include "products.h"

enum { NX = 13, NZ = 11, N = NX * NZ };

static PetscReal rake[N];

/* To 1e-12 of K's product: dense sums of N terms and transforms round to some 1e-15 on any number of ranks. */
static PetscErrorCode Compare(const char what[], Vec a, Vec b, Vec size)
{
  PetscReal distance, norm;

  PetscCall(VecNorm(size, NORM_INFINITY, &norm));
  PetscCall(VecAXPY(a, -1, b));
  PetscCall(VecNorm(a, NORM_INFINITY, &distance));
  Check(distance <= 1e-12 * norm, "%s differs by %g, expected at most 1e-12", what, (double)(distance / norm));
  return PETSC_SUCCESS;
}

/* Products apart and at once, diagonals, and views, which are collective. */
static PetscErrorCode CompareTypes(PetscInt nx, PetscInt nz)
{
  const SlipKernel rock = {&SlipKernelDipping, 30e9, 0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE, NULL};
  const SlipDippingGrid grid = {.grid = {nx, nz, 100. * nx, 80. * nz, 0, rock}, .dip = 55, .rake = rake};
  Mat dense[2], fft[2];
  Vec u, y[2], both[2], expected[2];

  PetscCall(MatCreateSlipDippingStiffness(PETSC_COMM_WORLD, &grid, "dense", &dense[0], &dense[1]));
  PetscCall(MatCreateSlipDippingStiffness(PETSC_COMM_WORLD, &grid, "fft", &fft[0], &fft[1]));
  PetscCall(MatCreateVecs(fft[0], &u, NULL));
  for (PetscInt i = 0; i < nx * nz; i++) PetscCall(VecSetValue(u, i, PetscSinReal((PetscReal)(i * i)), INSERT_VALUES));
  PetscCall(VecAssemble(u));
  for (int t = 0; t < 2; t++) {
    PetscCall(MatCreateVecs(fft[t], &y[t], &both[t]));
    PetscCall(VecDuplicate(u, &expected[t]));
  }
  PetscCall(MatSlipStiffnessMultBoth(fft[0], fft[1], u, both[0], both[1]));
  for (int t = 0; t < 2; t++) {
    PetscCall(MatMult(dense[t], u, expected[t]));
    PetscCall(MatMult(fft[t], u, y[t]));
    PetscCall(Compare("product", y[t], expected[t], expected[0]));
    PetscCall(Compare("product of both", both[t], expected[t], expected[0]));
  }
  for (int t = 0; t < 2; t++) {
    PetscCall(MatGetDiagonal(dense[t], expected[t]));
    PetscCall(MatGetDiagonal(fft[t], y[t]));
    PetscCall(Compare("diagonal", y[t], expected[t], expected[0]));
    PetscCall(MatView(fft[t], PETSC_VIEWER_STDOUT_WORLD));
  }
  PetscCall(VecDestroy(&u));
  for (int t = 0; t < 2; t++) PetscCall(DestroyObjects(&y[t], &both[t], &expected[t], &dense[t], &fft[t]));
  return PETSC_SUCCESS;
}

/* Rows of cells that do not go evenly into ranks, fewer rows or columns than ranks, one component of slip and two. */
static PetscErrorCode Run(void)
{
  const PetscInt sizes[][2] = {{NX, NZ}, {12, 3}, {1, 9}, {10, 1}, {1, 1}};

  for (int general = 0; general < 2; general++) {
    for (PetscInt e = 0; e < N; e++) rake[e] = general ? 7 * e - 100 : 90;
    for (size_t s = 0; s < PETSC_STATIC_ARRAY_LENGTH(sizes); s++) PetscCall(CompareTypes(sizes[s][0], sizes[s][1]));
  }
  return PETSC_SUCCESS;
}

SLIP_RANKS(Run)
