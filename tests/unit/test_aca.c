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

/* Blocks of 46,341 rows and columns have more numbers than 32 bits hold. */
static void largest_rank(void **state)
{
  (void)state;
  assert_int_equal(SlipRankMost(7, 5), 2);
  assert_int_equal(SlipRankMost(46341, 46341), 23170);
  assert_int_equal(SlipRankMost(46341, 1 << 30), 46339); /* m - m^2/(m + n) = m - 1.9999 */
  assert_int_equal(SlipRankMost(1 << 30, 1 << 30), 1 << 29);
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

/* Second derivatives of 1 / R between points of two lines, blocks [rows][2] as vectors' have; or where they decouple,
   the second a thousandth of the first. Counts pairs. */
typedef struct {
  PetscInt rows, pairs;
  PetscBool apart;
} Tensor;

static PetscReal TensorEntry(const Tensor *t, PetscInt i, PetscInt k, PetscInt j, PetscInt l)
{
  const PetscReal x[2] = {3 + (PetscReal)i / M + 2 * (PetscReal)j / N, 0.5 + (PetscReal)(i * i) / (M * M)};
  const PetscReal R2 = x[0] * x[0] + x[1] * x[1], R = PetscSqrtReal(R2);

  if (t->apart) return k == l ? (k ? 1e-3 / R2 : 1 / R) : 0;
  return ((k == l) - 3 * x[k] * x[l] / R2) / (R * R2);
}

static void TensorEntries(void *ctx, PetscInt i, PetscInt m, PetscInt j, PetscInt n, PetscReal a[])
{
  Tensor *t = (Tensor *)ctx;

  t->pairs += m * n;
  for (PetscInt c = 0; c < 2 * n; c++)
    for (PetscInt r = 0; r < t->rows * m; r++)
      a[c * t->rows * m + r] = TensorEntry(t, i + r / t->rows, r % t->rows, j + c / 2, c % 2);
}

/* To the tolerance as well, of two rows and of one for each pair. A row and a column of pairs serve two numbers of the
   rank where components see each other; four more are for the end, which is confirmed in four rows. */
static void test_tuples(void **state)
{
  (void)state;
  for (int f = 0; f < 4; f++)
    for (PetscReal tolerance = 1e-2; tolerance > 1e-11; tolerance *= 1e-2) {
      Tensor t = {.rows = f % 2 ? 1 : 2, .apart = (PetscBool)(f > 1)};
      PetscReal *U, *V, error = 0, norm = 0;
      PetscInt rank;
      PetscBool found;

      ok(SlipCrossApproximate(TensorEntries, &t, M, t.rows, N, 2, tolerance, 60, &rank, &U, &V, &found));
      assert_true(found);
      for (PetscInt i = 0; i < t.rows * M; i++)
        for (PetscInt j = 0; j < 2 * N; j++) {
          const PetscReal want = TensorEntry(&t, i / t.rows, i % t.rows, j / 2, j % 2);
          PetscReal got = 0;

          for (PetscInt k = 0; k < rank; k++) got += U[k * t.rows * M + i] * V[k * 2 * N + j];
          error += PetscSqr(got - want);
          norm += PetscSqr(want);
        }
      print_message("%s, %d rows, tolerance %g: rank %d, error %g, %d pairs\n", t.apart ? "apart" : "tensor",
                    (int)t.rows, (double)tolerance, (int)rank, (double)PetscSqrtReal(error / norm), (int)t.pairs);
      assert_true(PetscSqrtReal(error / norm) <= tolerance);
      if (f == 0) assert_true(t.pairs <= (rank / 2 + 4) * (M + N));
      ok(PetscFree(U));
      ok(PetscFree(V));
    }
}

SLIP_TESTS(largest_rank, test_to_the_tolerance, test_tuples)
