/* Cross approximation of blocks: to its tolerance, even where rows and columns that matter are not reached by pivots.
   */
#include "unit.h"
#include "../../src/mat/common/lowrank.c"
#include "../../src/mat/hmatrix/aca.c"

/* The library hides it; the products of lowrank.c count their work, which nobody reads here. */
PetscErrorCode SlipWorkFlops(SlipWork work, PetscLogDouble flops)
{
  (void)work, (void)flops;
  return PETSC_SUCCESS;
}

enum { M = 70, N = 50 };

/* 1 / (distance) of two clusters: as the stiffness, of low rank to any tolerance. */
static PetscReal Smooth(void *ctx, PetscInt i, PetscInt j)
{
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
  assert_int_equal(SlipRankMost(7, 5), 2);
  assert_int_equal(SlipRankMost(46341, 46341), 23170);
  assert_int_equal(SlipRankMost(46341, 1 << 30), 46339); /* m - m^2/(m + n) = m - 1.9999 */
  assert_int_equal(SlipRankMost(1 << 30, 1 << 30), 1 << 29);
}

/* A number of a term in double or in single precision */
static PetscReal Kept(PetscBool whole, PetscReal a)
{
  return whole ? a : (PetscReal)(float)a;
}

/* The error of U V' in the Frobenius norm, relative, with all but its first terms in single precision; at most the
   tolerance. Single precision is enough for all terms at 1e-6, for most at 1e-10. */
static void test_to_the_tolerance(void **state)
{
  const SlipEntriesFn functions[] = {SmoothEntries, ApartEntries};
  PetscReal (*const entries[])(void *, PetscInt, PetscInt) = {Smooth, Apart};

  for (int f = 0; f < 2; f++)
    for (PetscReal tolerance = 1e-2; tolerance > 1e-11; tolerance *= 1e-2) {
      PetscReal *U, *V, error = 0, norm = 0;
      PetscInt rank, head;
      PetscBool found;

      ok(SlipCrossApproximate(functions[f], NULL, M, 1, N, 1, tolerance, 30, &rank, &head, &U, &V, &found));
      assert_true(found);
      assert_true(tolerance < 1e-7 ? head < rank : head == 0);
      for (PetscInt i = 0; i < M; i++)
        for (PetscInt j = 0; j < N; j++) {
          const PetscReal want = entries[f](NULL, i, j);
          PetscReal got = 0;

          for (PetscInt k = 0; k < rank; k++) got += Kept(k < head, U[k * M + i]) * Kept(k < head, V[k * N + j]);
          error += PetscSqr(got - want);
          norm += PetscSqr(want);
        }
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
  for (int f = 0; f < 4; f++)
    for (PetscReal tolerance = 1e-2; tolerance > 1e-11; tolerance *= 1e-2) {
      Tensor t = {.rows = f % 2 ? 1 : 2, .apart = (PetscBool)(f > 1)};
      PetscReal *U, *V, error = 0, norm = 0;
      PetscInt rank, head;
      PetscBool found;

      ok(SlipCrossApproximate(TensorEntries, &t, M, t.rows, N, 2, tolerance, 60, &rank, &head, &U, &V, &found));
      assert_true(found);
      assert_true(tolerance < 1e-7 ? head < rank : head == 0);
      for (PetscInt i = 0; i < t.rows * M; i++)
        for (PetscInt j = 0; j < 2 * N; j++) {
          const PetscReal want = TensorEntry(&t, i / t.rows, i % t.rows, j / 2, j % 2);
          PetscReal got = 0;

          for (PetscInt k = 0; k < rank; k++)
            got += Kept(k < head, U[k * t.rows * M + i]) * Kept(k < head, V[k * 2 * N + j]);
          error += PetscSqr(got - want);
          norm += PetscSqr(want);
        }
      assert_true(PetscSqrtReal(error / norm) <= tolerance);
      if (f == 0) assert_true(t.pairs <= (rank / 2 + 4) * (M + N));
      ok(PetscFree(U));
      ok(PetscFree(V));
    }
}

/* Terms and what is left of a block are the block, to rounding, and no less is left than is asked for; or more terms
   are needed than there may be. */
static void test_split(void **state)
{
  static PetscReal A[M * N], rest[M * N], U[M * 9], V[N * 9];
  PetscReal left = 0, norm = 0;
  PetscInt terms;
  PetscBool found;

  SmoothEntries(NULL, 0, M, 0, N, A);
  ok(PetscArraycpy(rest, A, M * N));
  SlipCrossSplit(M, N, 1e-4, 9, rest, &terms, U, V, &found);
  assert_true(found && terms > 0 && terms < 9);
  for (PetscInt k = 0; k < M * N; k++) {
    PetscReal sum = rest[k];

    for (PetscInt r = 0; r < terms; r++) sum += U[r * M + k % M] * V[r * N + k / M];
    assert_true(PetscAbsReal(sum - A[k]) <= 1e-15);
    left += PetscSqr(rest[k]);
    norm += PetscSqr(A[k]);
  }
  assert_true(PetscSqrtReal(left / norm) <= 1e-4);
  ok(PetscArraycpy(rest, A, M * N));
  SlipCrossSplit(M, N, 1e-4, terms - 1, rest, &terms, U, V, &found);
  assert_false(found);
}

SLIP_TESTS(largest_rank, test_split, test_to_the_tolerance, test_tuples)
