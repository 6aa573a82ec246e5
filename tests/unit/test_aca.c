/* Cross approximation of blocks: to its tolerance, even where rows and columns that matter are not reached by pivots.
   */
#include "unit.h"
#include "../../src/mat/hmatrix/aca.c"

enum { M = 70, N = 50 };

/* 1 / (distance) of two clusters: as the stiffness, of low rank to any tolerance. */
static PetscReal Smooth(void *ctx, PetscInt i, PetscInt j)
{
  (void)ctx;
  return 1 / (3.0 + (PetscReal)i / M + 2 * (PetscReal)j / N);
}

/* Two such blocks that do not see each other: crosses of the first never meet the second, whose entries are smaller. */
static PetscReal Apart(void *ctx, PetscInt i, PetscInt j)
{
  if ((i < M / 2) != (j < N / 2)) return 0;
  return (i < M / 2 ? 1 : 0.1) * Smooth(ctx, i % (M / 2), j % (N / 2));
}

static void SmoothEntries(void *ctx, PetscInt i, PetscInt m, PetscInt j, PetscInt n, PetscReal a[])
{
  for (PetscInt k = 0; k < m * n; k++) a[k] = Smooth(ctx, i + k % m, j + k / m);
}

static void ApartEntries(void *ctx, PetscInt i, PetscInt m, PetscInt j, PetscInt n, PetscReal a[])
{
  for (PetscInt k = 0; k < m * n; k++) a[k] = Apart(ctx, i + k % m, j + k / m);
}

/* The error of U V' in the Frobenius norm, relative; at most the tolerance. */
static void test_to_the_tolerance(void **state)
{
  const SlipEntriesFn functions[] = {SmoothEntries, ApartEntries};
  PetscReal (*const entries[])(void *, PetscInt, PetscInt) = {Smooth, Apart};

  (void)state;
  for (int f = 0; f < 2; f++)
    for (PetscReal tolerance = 1e-2; tolerance > 1e-11; tolerance *= 1e-2) {
      PetscReal *U, *V, error = 0, norm = 0;
      PetscInt rank;
      PetscBool found;

      ok(SlipCrossApproximate(functions[f], NULL, M, 1, N, 1, tolerance, 30, &rank, &U, &V, &found));
      assert_true(found);
      for (PetscInt i = 0; i < M; i++)
        for (PetscInt j = 0; j < N; j++) {
          const PetscReal want = entries[f](NULL, i, j);
          PetscReal got = 0;

          for (PetscInt k = 0; k < rank; k++) got += U[k * M + i] * V[k * N + j];
          error += PetscSqr(got - want);
          norm += PetscSqr(want);
        }
      print_message("%s, tolerance %g: rank %d, error %g\n", f ? "apart" : "smooth", (double)tolerance, (int)rank,
                    (double)PetscSqrtReal(error / norm));
      assert_true(PetscSqrtReal(error / norm) <= tolerance);
      ok(PetscFree(U));
      ok(PetscFree(V));
    }
}

SLIP_TESTS(test_to_the_tolerance)
