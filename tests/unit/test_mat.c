/* Stiffness, viscosity and stage operator on one process. */
#include "operators.h"
#include <math.h>

#define MASS (2500.0 * 3000.0)
#define ZETA (0.8 / 3)

static const SlipGrid Even = {10, 10, 3000.0, 3000.0, 0.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};
static const SlipGrid Wide = {24, 22, 3000.0, 2900.0, 0.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};
static const SlipGrid Odd = {9, 12, 2000.0, 3600.0, 700.0, ROCK(0.1, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};
static const SlipGrid Line = {13, 1, 2000.0, 100.0, 700.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};
static const SlipGrid Average = {11, 9, 3000.0, 2900.0, 0.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_WHOLE)};
static const SlipGrid AverageDeep = {7, 40, 1000.0, 4000.0, 300.0, ROCK(0.3, PETSC_FALSE, SLIP_AVERAGE_WHOLE)};
static const SlipGrid AverageFull = {40, 1, 4000.0, 90.0, 0.0, ROCK(0.2, PETSC_TRUE, SLIP_AVERAGE_CELL)};
static const SlipGrid Column = {1, 8, 500.0, 3600.0, 0.0, ROCK(0.25, PETSC_TRUE, SLIP_AVERAGE_CENTRE)};

static PetscReal EntryOf(Mat A, PetscInt i, PetscInt j)
{
  PetscScalar value;

  ok(MatGetValues(A, 1, &i, 1, &j, &value));
  return value;
}

/* Entries of the dense stiffness straight from the public kernel, the symmetric part. */
static void test_dense_entries(void **state)
{
  const SlipGrid *g = &Odd;
  const PetscReal a = g->length_x / g->nx, b = g->length_z / g->nz;
  Mat K;

  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, g, "dense", &K));
  for (PetscInt i = 0; i < g->nx * g->nz; i += 5)
    for (PetscInt j = 0; j < g->nx * g->nz; j++) {
      const PetscReal dx = (i % g->nx - j % g->nx) * a;
      const PetscReal zi = g->depth_top + (i / g->nx + 0.5) * b, zj = g->depth_top + (j / g->nx + 0.5) * b;
      const PetscReal expected =
        0.5 * (SlipKernelHalfSpace(30e9, 0.1, dx, zi, zj, a, b) + SlipKernelHalfSpace(30e9, 0.1, -dx, zj, zi, a, b));

      /* rounding of the distances only */
      assert_true(PetscAbsReal(EntryOf(K, i, j) - expected) < 1e-13 * EntryOf(K, i, i));
    }
  ok(MatDestroy(&K));
}

/* ||H H / mass - 4 zeta^2 K|| / ||4 zeta^2 K||, Frobenius. */
static PetscReal SquareError(Mat K, Mat H)
{
  Mat square, denseK, denseH;
  PetscReal error, norm;

  ok(MatConvert(K, MATDENSE, MAT_INITIAL_MATRIX, &denseK));
  ok(MatConvert(H, MATDENSE, MAT_INITIAL_MATRIX, &denseH));
  ok(MatMatMult(denseH, denseH, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &square));
  ok(MatScale(square, 1 / MASS));
  ok(MatScale(denseK, 4 * ZETA * ZETA));
  ok(MatNorm(denseK, NORM_FROBENIUS, &norm));
  ok(MatAXPY(square, -1, denseK, SAME_NONZERO_PATTERN));
  ok(MatNorm(square, NORM_FROBENIUS, &error));
  ObjectsDestroy(&square, &denseK, &denseH);
  return error / norm;
}

/* Largest difference between MatGetDiagonal() and the diagonal of the converted matrix, relative. */
static PetscReal DiagonalError(Mat A)
{
  Mat dense;
  Vec d, e;
  PetscReal norm, error;

  ok(MatConvert(A, MATDENSE, MAT_INITIAL_MATRIX, &dense));
  ok(MatCreateVecs(A, &d, &e));
  ok(MatGetDiagonal(A, d));
  ok(MatGetDiagonal(dense, e));
  ok(VecNorm(e, NORM_INFINITY, &norm));
  ok(VecAXPY(d, -1, e));
  ok(VecNorm(d, NORM_INFINITY, &error));
  ObjectsDestroy(&dense, &d, &e);
  return error / norm;
}

/* Averages over cells: the diagonal of all forms, in all of which the border's cells are the stiffer ones; entries from
   the public average. */
static void test_average_on_grids(void **state)
{
  const SlipGrid *const grids[] = {&Average, &AverageDeep, &AverageFull};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(grids); k++) {
    const SlipGrid *g = grids[k];
    const PetscReal a = g->length_x / g->nx, b = g->length_z / g->nz;
    const PetscReal share = g->kernel.average == SLIP_AVERAGE_WHOLE ? SLIP_CORE_INNER : SLIP_CORE_CELL;
    const PetscReal core[2] = {share * a, share * b};
    const char *const depth[] = {"blocks", "transform"};
    Mat dense;

    ok(MatCreateSlipStiffness(PETSC_COMM_SELF, g, "dense", &dense));
    for (PetscInt i = 0; i < g->nx * g->nz; i += 7)
      for (PetscInt j = 0; j < g->nx * g->nz; j++) {
        const SlipRectangle receiver = {(i % g->nx) * a, 0, g->depth_top + (i / g->nx + 0.5) * b, a, b};
        const SlipRectangle source = {(j % g->nx) * a, 0, g->depth_top + (j / g->nx + 0.5) * b, a, b};
        const PetscReal kernel = SlipKernelAverage(g->kernel.shear_modulus, g->kernel.poisson_ratio, &receiver, &source,
                                                   core, g->kernel.full_space);

        /* rounding, of the image up to 80 cells away: corners of 80 ln 80 */
        if (i != j) assert_true(PetscAbsReal(EntryOf(dense, i, j) - kernel) < 1e-12 * EntryOf(dense, i, i));
        if (i == j) assert_true(EntryOf(dense, i, i) > kernel - 1e-12 * kernel);
      }
    for (int t = 0; t < 2; t++) {
      Mat K;

      ok(MatCreateSlipStiffness(PETSC_COMM_SELF, g, "fft", &K));
      ok(MatSlipStiffnessSetDepth(K, depth[t]));
      ok(MatScale(K, 1.7));
      if (!t) ok(MatScale(dense, 1.7));
      assert_true(DiagonalError(K) < 1e-12);
      assert_true(MatDistance(K, dense) < 1e-12);
      ok(MatDestroy(&K));
    }
    ok(MatDestroy(&dense));
  }
}

/* 1e-12: rounding of transforms of at most 50 points. The exact root from sketches against the dense one: what the
   default tolerance promises, 1e-10, in the Frobenius norm, which counts at most 528 wrong directions of 1e-10 of the
   largest against 528 right ones of its size or a fifth; its products round terms of 4e-6 of the norm in single
   precision, 3e-13. The wide grid needs several rounds with a basis smaller than the whole space (6 nz of 12 nz at
   first). All follow MatScale(). */
static void test_fft_is_dense(void **state)
{
  const SlipGrid *const grids[] = {&Wide, &Even, &Odd, &Line, &Column, &Average};

  ok(PetscOptionsSetValue(NULL, "-mat_slipsqrtm_setup", "sketch"));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(grids); k++) {
    Mat K[2], H[2], B[2];

    for (int t = 0; t < 2; t++) {
      ok(MatCreateSlipStiffness(PETSC_COMM_SELF, grids[k], t ? "fft" : "dense", &K[t]));
      ok(MatScale(K[t], 1.7));
      ok(MatCreateSlipViscosity(K[t], MASS, ZETA, "sqrtm", &H[t]));
      ok(MatCreateSlipStage(K[t], H[t], MASS, &B[t]));
      ok(MatSlipStageSetTheta(B[t], 0.02));
      ok(MatSlipStageSetTheta(B[t], 0.4));
      assert_true(DiagonalError(K[t]) < 1e-12);
      assert_true(DiagonalError(H[t]) < 1e-11);
      assert_true(DiagonalError(B[t]) < 1e-11);
      assert_true(SquareError(K[t], H[t]) < 1e-10);
    }
    assert_true(MatDistance(K[1], K[0]) < 1e-12);
    assert_true(MatDistance(H[1], H[0]) < 1e-10);
    assert_true(MatDistance(B[1], B[0]) < 1e-10);
    for (int t = 0; t < 2; t++) ObjectsDestroy(&K[t], &H[t], &B[t]);
  }
  ok(PetscOptionsClearValue(NULL, "-mat_slipsqrtm_setup"));
}

/* Transforms in depth, forced at small sizes and by default at a deep one. 1e-12: rounding of transforms of a few
   hundred points; A and z z' q cancel at most by a small factor, as both are below s^2 q. */
static void test_transform_is_dense(void **state)
{
  const SlipGrid deep = {3, 67, 300.0, 6700.0, 50.0, ROCK(0.3, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};
  const SlipGrid buried = {5, 9, 1000.0, 1800.0, 20e3, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};
  const SlipGrid full = {7, 6, 1000.0, 900.0, 0.0, ROCK(0.2, PETSC_TRUE, SLIP_AVERAGE_CENTRE)};
  const SlipGrid *const grids[] = {&deep, &buried, &full, &Even, &Odd, &Line, &Column};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(grids); k++) {
    Mat K[2];

    for (int t = 0; t < 2; t++) {
      ok(MatCreateSlipStiffness(PETSC_COMM_SELF, grids[k], t ? "fft" : "dense", &K[t]));
      if (k) ok(MatSlipStiffnessSetDepth(K[t], "transform"));
      ok(MatScale(K[t], 0.6));
    }
    assert_true(DiagonalError(K[1]) < 1e-12);
    assert_true(MatDistance(K[1], K[0]) < 1e-12);
    for (int t = 0; t < 2; t++) ok(MatDestroy(&K[t]));
  }
}

/* All factors of lengths, alone and one after another, along strike and in depth, with rows and wavenumbers that fill
   the lanes of transforms, and others. Where everything is right the distance is at most 2e-15, as transforms add up
   in a tree. */
static void test_transforms_of_all_lengths_are_dense(void **state)
{
  const PetscInt lengths[] = {1, 2, 3, 4, 5, 8, 9, 15, 16, 17, 20, 25, 27, 32, 40, 45, 64, 90};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(lengths); k++)
    for (int deep = 0; deep < 2; deep++) {
      const PetscInt n = lengths[k];
      const SlipGrid grid = {deep ? 3 : n, deep ? n : 3, 900.0,
                             700.0,        0.0,          ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};
      Mat K[2];

      for (int t = 0; t < 2; t++) {
        ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, t ? "fft" : "dense", &K[t]));
        ok(MatSlipStiffnessSetDepth(K[t], "transform"));
      }
      AssertNear(MatDistance(K[1], K[0]), 0, 1e-13);
      for (int t = 0; t < 2; t++) ok(MatDestroy(&K[t]));
    }
}

/* A loose tolerance is kept too, and buys a smaller correction; one below rounding is refused with a message. */
static void test_root_tolerance(void **state)
{
  PetscReal distance;
  Mat K[2], H[2];

  ok(PetscOptionsInsertString(NULL, "-mat_slipsqrtm_setup sketch -mat_slipsqrtm_tolerance 1e-5"));
  for (int t = 0; t < 2; t++) {
    ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &Wide, t ? "fft" : "dense", &K[t]));
    ok(MatCreateSlipViscosity(K[t], MASS, ZETA, "sqrtm", &H[t]));
  }
  distance = MatDistance(H[1], H[0]);
  assert_true(distance < 1e-5 && distance > 1e-9);
  ok(MatDestroy(&H[1]));
  ok(PetscOptionsSetValue(NULL, "-mat_slipsqrtm_tolerance", "1e-20"));
  assert_int_not_equal(MatCreateSlipViscosity(K[1], MASS, ZETA, "sqrtm", &H[1]), 0);
  ok(PetscOptionsClear(NULL));
  ok(MatDestroy(&H[0]));
  for (int t = 0; t < 2; t++) ok(MatDestroy(&K[t]));
}

/* The root by another algorithm: Denman & Beavers (1976), Y -> (Y + Z^-1)/2, Z -> (Z + Y^-1)/2, on M^-1 K. */
static void test_viscosity_by_denman_beavers(void **state)
{
  const SlipGrid grid = {5, 4, 1500.0, 1600.0, 0.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};
  Mat K, H, Y, Z, identity, inverseY, inverseZ;
  const PetscInt N = 20;

  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, "dense", &K));
  ok(MatCreateSlipViscosity(K, MASS, ZETA, "sqrtm", &H));
  ok(MatDuplicate(K, MAT_COPY_VALUES, &Y));
  ok(MatScale(Y, 1 / MASS));
  ok(MatCreateSeqDense(PETSC_COMM_SELF, N, N, NULL, &identity));
  ok(MatShift(identity, 1));
  ok(MatDuplicate(identity, MAT_COPY_VALUES, &Z));
  for (int sweep = 0; sweep < 30; sweep++) {
    Mat factorY, factorZ;

    ok(MatDuplicate(Y, MAT_COPY_VALUES, &factorY));
    ok(MatDuplicate(Z, MAT_COPY_VALUES, &factorZ));
    ok(MatLUFactor(factorY, NULL, NULL, NULL));
    ok(MatLUFactor(factorZ, NULL, NULL, NULL));
    ok(MatDuplicate(identity, MAT_COPY_VALUES, &inverseY));
    ok(MatDuplicate(identity, MAT_COPY_VALUES, &inverseZ));
    ok(MatMatSolve(factorY, identity, inverseY));
    ok(MatMatSolve(factorZ, identity, inverseZ));
    ok(MatAXPY(Y, 1, inverseZ, SAME_NONZERO_PATTERN));
    ok(MatAXPY(Z, 1, inverseY, SAME_NONZERO_PATTERN));
    ok(MatScale(Y, 0.5));
    ok(MatScale(Z, 0.5));
    ObjectsDestroy(&factorY, &factorZ, &inverseY, &inverseZ);
  }
  ok(MatScale(Y, 2 * ZETA * MASS));
  assert_true(MatDistance(H, Y) < 1e-11); /* the iteration's rounding grows with the condition of K, about 10 here */
  ObjectsDestroy(&identity, &Y, &Z, &H, &K);
}

/* The spectral root is near the exact one but not equal (off by a few per cent in norm); "none" is zero. */
static void test_other_viscosities(void **state)
{
  Mat K, exact, spectral, none;
  PetscReal distance, norm;

  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &Even, "dense", &K));
  ok(MatCreateSlipViscosity(K, MASS, ZETA, "sqrtm", &exact));
  ok(MatCreateSlipViscosity(K, MASS, ZETA, "spectral", &spectral));
  ok(MatCreateSlipViscosity(K, MASS, ZETA, "none", &none));
  distance = MatDistance(spectral, exact);
  assert_true(distance > 1e-4 && distance < 0.1);
  assert_true(DiagonalError(spectral) < 1e-12);
  ok(MatNorm(none, NORM_INFINITY, &norm));
  assert_true(norm == 0);
  ObjectsDestroy(&K, &exact, &spectral, &none);
}

/* "auto" is dense while that is as fast, FFT beyond. */
static void test_auto(void **state)
{
  SlipGrid large = Even;
  PetscBool match;
  Mat K;

  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &Even, "auto", &K));
  ok(PetscObjectTypeCompare((PetscObject)K, MATSEQDENSE, &match));
  assert_true(match);
  ok(MatDestroy(&K));
  large.nx = 40;
  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &large, "auto", &K));
  ok(PetscObjectTypeCompare((PetscObject)K, "slipfft", &match));
  assert_true(match);
  ok(MatDestroy(&K));
}

/* No damping: an exact zero of either type. */
static void test_zero_damping(void **state)
{
  static const char *const types[] = {"dense", "fft"};

  for (int t = 0; t < 2; t++) {
    PetscReal norm;
    Mat K, H, dense;

    ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &Odd, types[t], &K));
    ok(MatCreateSlipViscosity(K, MASS, 0, "sqrtm", &H));
    ok(MatConvert(H, MATDENSE, MAT_INITIAL_MATRIX, &dense));
    ok(MatNorm(dense, NORM_INFINITY, &norm));
    assert_true(norm == 0);
    ObjectsDestroy(&dense, &H, &K);
  }
}

static void test_stage_is_the_sum(void **state)
{
  Mat K, H, B, dense;
  PetscReal theta;

  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &Even, "dense", &K));
  ok(MatCreateSlipViscosity(K, MASS, ZETA, "sqrtm", &H));
  ok(MatCreateSlipStage(K, H, MASS, &B));
  for (int k = 0; k < 2; k++) {
    const PetscReal set = k ? 0.003 : 0.7;

    ok(MatSlipStageSetTheta(B, set));
    ok(MatSlipStageGetTheta(B, &theta));
    assert_true(theta == set);
    ok(MatConvert(B, MATDENSE, MAT_INITIAL_MATRIX, &dense));
    for (PetscInt i = 0; i < 100; i += 7)
      for (PetscInt j = 0; j < 100; j++) {
        const PetscReal expected = (i == j ? MASS / set : 0) + EntryOf(H, i, j) + set * EntryOf(K, i, j);

        /* three terms, one rounding each */
        assert_true(PetscAbsReal(EntryOf(dense, i, j) - expected) < 1e-13 * (MASS / set + set * EntryOf(K, i, i)));
      }
    ok(MatDestroy(&dense));
  }
  ObjectsDestroy(&B, &H, &K);
}

/* Radiation damping without inertia: B = eta I + theta K, by products and by what solvers that factor blocks ask for */
static void test_radiation(void **state)
{
  const PetscReal eta = 4.33e6, theta = 0.7;
  const char *types[] = {"dense", "fft"};

  for (int t = 0; t < 2; t++) {
    PetscErrorCode (*entries)(Mat, Mat *, PetscReal *, Vec *);
    Mat K, H, B, dense, part, known;
    PetscReal scale;
    Vec diagonal;

    ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &Even, types[t], &K));
    ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &Even, "dense", &known));
    ok(MatCreateSlipRadiation(K, eta, &H));
    ok(MatCreateSlipStage(K, H, 0, &B));
    ok(MatSlipStageSetTheta(B, theta));
    ok(MatConvert(B, MATDENSE, MAT_INITIAL_MATRIX, &dense));
    ok(PetscObjectQueryFunction((PetscObject)B, "MatSlipGetDense_C", &entries));
    ok((*entries)(B, &part, &scale, &diagonal));
    for (PetscInt i = 0; i < 100; i += 7)
      for (PetscInt j = 0; j < 100; j++) {
        const PetscReal expected = (i == j ? eta : 0) + theta * EntryOf(known, i, j);
        PetscReal d;

        ok(VecGetValues(diagonal, 1, &i, &d));
        /* a transform's rounding, of the order of 1e-15 of the diagonal times the logarithm of its length */
        assert_true(PetscAbsReal(EntryOf(dense, i, j) - expected) < 1e-13 * (eta + theta * EntryOf(known, i, i)));
        assert_true(PetscAbsReal(scale * EntryOf(part, i, j) + (i == j ? d : 0) - expected) <
                    1e-13 * (eta + theta * EntryOf(known, i, i)));
      }
    ObjectsDestroy(&dense, &known, &B, &H, &K);
  }
}

/* ---- errors ---- */

static void AssertEntriesRefused(PetscInt N, const PetscReal *entries, const char *words)
{
  Mat K = NULL;

  fails(MatCreateSlipStiffnessFromEntries(PETSC_COMM_SELF, N, entries, "k.h5:/stiffness", &K), words);
  assert_non_null(strstr(message, "k.h5:/stiffness"));
}

static void test_entries(void **state)
{
  const PetscReal good[4] = {3e6, 1e6, 1e6 + 1e-3, 2e6};
  const PetscReal not_finite[4] = {3e6, NAN, 1e6, 2e6};
  const PetscReal not_symmetric[4] = {3e6, 1e6, 1.001e6, 2e6};
  const PetscReal negative[4] = {-3e6, -1e6, -1e6, -2e6};
  const PetscReal indefinite[4] = {1e6, 2e6, 2e6, 1e6};
  Mat K;

  ok(MatCreateSlipStiffnessFromEntries(PETSC_COMM_SELF, 2, good, "k.h5:/stiffness", &K));
  assert_true(EntryOf(K, 0, 0) == 3e6);
  assert_true(EntryOf(K, 0, 1) == EntryOf(K, 1, 0)); /* the symmetric part */
  ok(MatDestroy(&K));
  AssertEntriesRefused(2, not_finite, "(0, 1)");
  AssertEntriesRefused(2, not_symmetric, "not symmetric");
  AssertEntriesRefused(2, negative, "not positive definite");
  AssertEntriesRefused(2, indefinite, "order 2");
  AssertEntriesRefused(2, NULL, "rank 0");
  AssertEntriesRefused(0, good, "at least one row");
}

static void AssertGridRefused(SlipGrid grid, const char *type, const char *words)
{
  Mat K = NULL;

  fails(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, type, &K), words);
}

static void test_bad_grids(void **state)
{
  SlipGrid g = Even;

  AssertGridRefused(g, "quick", "\"quick\"");
  g.nx = 0;
  AssertGridRefused(g, "dense", "0 x 10");
  g = Even;
  g.kernel.poisson_ratio = 0.5;
  AssertGridRefused(g, "fft", "Poisson");
  g = Even;
  g.depth_top = -1;
  AssertGridRefused(g, "auto", "Depth of the upper edge");
  g = Even;
  g.length_z = NAN;
  AssertGridRefused(g, "dense", "Length in depth");
  g = Even;
  g.kernel.shear_modulus = 0;
  AssertGridRefused(g, "dense", "Shear modulus");
}

SLIP_TESTS(test_dense_entries, test_average_on_grids, test_fft_is_dense, test_transform_is_dense,
           test_transforms_of_all_lengths_are_dense, test_root_tolerance, test_viscosity_by_denman_beavers,
           test_other_viscosities, test_auto, test_zero_damping, test_stage_is_the_sum, test_radiation, test_entries,
           test_bad_grids)
