/* The cheap stage operator of inexact Newton methods: how far it is from the exact one, and the Mats that it is made
   of. */
#include "unit.h"
#include "cells.h"

#define MASS (2500.0 * 3000.0)
#define ZETA (0.8 / 3)
#define SIDE 16
#define N (SIDE * SIDE)

static const PetscReal Thetas[] = {0.01, 0.1, 0.5, 1.5, 6.0};

static Mat Stiffness(PetscReal depth_top, PetscBool full_space, const char *type)
{
  const SlipGrid grid = {SIDE, SIDE, 3000.0, 3000.0, depth_top, ROCK(0.25, full_space, SLIP_AVERAGE_CENTRE)};
  Mat K;

  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, type, &K));
  ok(MatScale(K, 0.46));
  return K;
}

/* e'Ae */
static PetscReal Energy(Mat A, Vec e, Vec work)
{
  PetscScalar energy;

  ok(MatMult(A, e, work));
  ok(VecDot(e, work, &energy));
  return PetscRealPart(energy);
}

/* Largest share of the error that an iteration v += A^-1 (b - B v) leaves, in the norm of A, by the power method: a
   lower bound that 60 iterations bring close to the largest eigenvalue. A must have a Cholesky factor. */
static PetscReal Contraction(Mat B, Mat A)
{
  Mat factor;
  Vec e, r, work;
  PetscReal before, after = 0;
  IS order;

  ok(MatConvert(A, MATSEQDENSE, MAT_INITIAL_MATRIX, &factor));
  ok(ISCreateStride(PETSC_COMM_SELF, N, 0, 1, &order));
  ok(MatCholeskyFactor(factor, order, NULL));
  ok(MatCreateVecs(B, &e, &r));
  ok(VecDuplicate(e, &work));
  ok(VecFillSines(e));
  for (int k = 0; k < 60; k++) {
    before = Energy(A, e, work);
    ok(VecScale(e, 1 / PetscSqrtReal(before)));
    ok(MatMult(B, e, work));
    ok(MatSolve(factor, work, r));
    ok(VecAXPY(e, -1, r));
    after = Energy(A, e, work);
  }
  ObjectsDestroy(&factor, &order, &e, &r, &work);
  return PetscSqrtReal(after);
}

/* B of this stiffness with the exact root, and the share that its approximation leaves at several theta. */
static PetscReal WorstContraction(Mat K)
{
  PetscReal worst = 0;
  Mat H, B, A;

  ok(MatCreateSlipViscosity(K, MASS, ZETA, "sqrtm", &H));
  ok(MatCreateSlipStage(K, H, MASS, &B));
  ok(MatSlipStageSetJacobian(B, "approximate"));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(Thetas); k++) {
    PetscReal theta;

    ok(MatSlipStageSetTheta(B, Thetas[k]));
    ok(MatSlipStageGetApproximation(B, &A));
    assert_ptr_not_equal(A, B);
    ok(MatSlipStageGetTheta(A, &theta));
    assert_true(theta == Thetas[k]);
    worst = PetscMax(worst, Contraction(B, A));
  }
  ObjectsDestroy(&B, &H);
  return worst;
}

/* What the approximation of toeplitz_root.c is for: a few per cent where an image stands for the free surface. Nothing
   bounds it in theory; the prototype found at most 0.020 at 30 x 30, and 0.08 when the image was left out, as it is for
   a fault that is buried by half its depth. */
static void test_contraction_on_grids(void **state)
{
  static const struct {
    PetscReal depth_top;
    PetscBool full_space;
    PetscReal most;
  } rows[] = {{0, PETSC_FALSE, 0.03}, {400, PETSC_FALSE, 0.03}, {3000, PETSC_FALSE, 0.03}, {0, PETSC_TRUE, 0.03}};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(rows); k++) {
    Mat K = Stiffness(rows[k].depth_top, rows[k].full_space, "fft");
    const PetscReal worst = WorstContraction(K);

    assert_true(worst > 0 && worst < rows[k].most);
    ok(MatDestroy(&K));
  }
}

/* Without a grid: zeta / (2 + zeta) is a bound, from a + b >= 2 sqrt(a b). */
static void test_contraction_without_grid(void **state)
{
  PetscReal *entries, worst;
  Mat K = Stiffness(0, PETSC_FALSE, "dense"), bare;
  const PetscScalar *a;

  ok(PetscMalloc1(N * N, &entries));
  a = MatRead(K);
  ok(PetscArraycpy(entries, a, N * N));
  ok(MatCreateSlipStiffnessFromEntries(PETSC_COMM_SELF, N, entries, "test", &bare));
  worst = WorstContraction(bare);
  assert_true(worst > 0.02 && worst < ZETA / (2 + ZETA) + 1e-10);
  ok(PetscFree(entries));
  ObjectsDestroy(&K, &bare);
}

static void FillDirection(Vec x, PetscInt j)
{
  for (PetscInt i = 0; i < N; i++) ok(VecSetValue(x, i, PetscCosReal(0.3 * j + 0.1 * (j + 1) * i), INSERT_VALUES));
  ok(VecAssemble(x));
}

/* Largest |A x - B x| / |B x| of directions first to last; largest asymmetry of A between them and another vector. */
static void CompareOnDirections(Mat A, Mat B, PetscInt first, PetscInt last, PetscReal *distance, PetscReal *asymmetry)
{
  PetscReal norm, off;
  PetscScalar xAy, yAx;
  Vec x, y, Ax, Ay, Bx;

  ok(MatCreateVecs(B, &x, &y));
  VecsDuplicate(x, &Ax, &Ay, &Bx);
  *distance = *asymmetry = 0;
  ok(VecFillSines(y));
  ok(MatMult(A, y, Ay));
  for (PetscInt j = first; j <= last; j++) {
    FillDirection(x, j);
    ok(MatMult(A, x, Ax));
    ok(MatMult(B, x, Bx));
    ok(VecDot(y, Ax, &yAx));
    ok(VecDot(x, Ay, &xAy));
    ok(VecNorm(Bx, NORM_2, &norm));
    ok(VecAXPY(Ax, -1, Bx));
    ok(VecNorm(Ax, NORM_2, &off));
    *distance = PetscMax(*distance, off / norm);
    *asymmetry = PetscMax(*asymmetry, PetscAbsReal(xAy - yAx) / norm);
  }
  ObjectsDestroy(&x, &y, &Ax, &Ay, &Bx);
}

/* The approximation at all theta, when directions first to last are known. delta: what it leaves without them */
static void CheckCorrected(Mat B, Mat exact, PetscReal delta, PetscInt first, PetscInt last)
{
  PetscReal distance, asymmetry, share;
  Mat A;

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(Thetas); k++) {
    ok(MatSlipStageSetTheta(B, Thetas[k]));
    ok(MatSlipStageSetTheta(exact, Thetas[k]));
    ok(MatSlipStageGetApproximation(B, &A));
    CompareOnDirections(A, exact, first, last, &distance, &asymmetry);
    share = Contraction(exact, A);
    AssertLess(distance, 1e-6);
    AssertLess(asymmetry, 1e-12);
    assert_true(share <= delta / (1 - 2 * delta));
  }
}

/* The approximation learns from products with B at one theta, and is B on the directions it knows at any: on all of 20,
   and of 30, more than it keeps, on the last. Images have the tolerance of 1e-8, ten times that where earlier
   directions cover most of one, and the small matrices no condition worse than that of B, below 1e3: 1e-6 is above all
   that and far below the 0.1 and 0.01 that the approximations of cells and grids are off by. Symmetry: rounding.
   Convergence: the bound of secant.c. Takes K over. */
static void CheckCorrection(Mat K, PetscReal delta)
{
  Mat H, B, A, exact, root;
  Vec x, y;

  ok(MatCreateSlipViscosity(K, MASS, ZETA, "lanczos", &H));
  ok(MatCreateSlipViscosity(K, MASS, ZETA, "sqrtm", &root));
  ok(MatCreateSlipStage(K, H, MASS, &B));
  ok(MatSlipStageSetJacobian(B, "approximate"));
  ok(MatCreateSlipStage(K, root, MASS, &exact));
  ok(MatCreateVecs(B, &x, &y));
  for (PetscInt j = 0; j < 30; j++) {
    if (j == 20) CheckCorrected(B, exact, delta, 0, 19);
    ok(MatSlipStageSetTheta(B, 1.5));
    FillDirection(x, j);
    ok(MatMult(B, x, y));
    ok(MatSlipStageGetApproximation(B, &A));
  }
  CheckCorrected(B, exact, delta, 29, 29);
  ObjectsDestroy(&exact, &root, &B, &H, &K, &x, &y);
}

/* Irregular cells, whose rows are weighted */
static void test_correction_of_cells(void **state)
{
  PetscReal data[5 * N];
  const SlipCells cells = TwoGradedFaults(SIDE, SIDE / 2, 1, data);
  Mat K;

  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &cells, "dense", 1e-8, &K));
  CheckCorrection(K, ZETA / (2 + ZETA));
}

/* A grid, whose approximation has a viscosity of its own; delta as of test_contraction_on_grids() */
static void test_correction_of_a_grid(void **state)
{
  CheckCorrection(Stiffness(0, PETSC_FALSE, "fft"), 0.03);
}

/* In a full space the root of an endless plane is a Toeplitz matrix; a part of a fault three times as large, whose root
   is computed densely, has nearly its entries in the middle. Off by what that fault's edges do there, one length
   away. */
static void test_root_of_endless_plane(void **state)
{
  const SlipGrid small = {6, 6, 600.0, 600.0, 0, ROCK(0.25, PETSC_TRUE, SLIP_AVERAGE_CENTRE)},
                 large = {18, 18, 1800.0, 1800.0, 0, ROCK(0.25, PETSC_TRUE, SLIP_AVERAGE_CENTRE)};
  Mat K, H, part, whole;
  PetscReal difference = 0, size = 0;

  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &small, "fft", &K));
  ok(MatCreateSlipViscosity(K, MASS, ZETA, "toeplitz", &H));
  ok(MatConvert(H, MATDENSE, MAT_INITIAL_MATRIX, &part));
  ObjectsDestroy(&H, &K);
  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &large, "dense", &K));
  ok(MatCreateSlipViscosity(K, MASS, ZETA, "sqrtm", &whole));
  for (PetscInt i = 0; i < 36; i++)
    for (PetscInt j = 0; j < 36; j++) {
      const PetscInt k = (6 + i / 6) * 18 + 6 + i % 6, l = (6 + j / 6) * 18 + 6 + j % 6;
      PetscScalar a, b;

      ok(MatGetValues(part, 1, &i, 1, &j, &a));
      ok(MatGetValues(whole, 1, &k, 1, &l, &b));
      difference = PetscMax(difference, PetscAbsReal(a - b));
      size = PetscMax(size, PetscAbsReal(b));
    }
  AssertLess(difference, 1e-3 * size);
  ObjectsDestroy(&part, &whole, &K);
}

/* One product for all of B against three, and diagonals against the entries: rounding. */
static void test_fused_product(void **state)
{
  for (int full_space = 0; full_space < 2; full_space++) {
    Mat K = Stiffness(0, full_space ? PETSC_TRUE : PETSC_FALSE, "fft"), H, B, dense;
    Vec x, y, z, d;
    PetscReal size;

    ok(MatCreateSlipViscosity(K, MASS, ZETA, "toeplitz", &H));
    ok(MatCreateSlipStage(K, H, MASS, &B));
    ok(MatCreateVecs(K, &x, &y));
    VecsDuplicate(x, &z, &d);
    ok(VecFillSines(x));
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(Thetas); k++) {
      ok(MatSlipStageSetTheta(B, Thetas[k]));
      ok(MatMult(K, x, y));
      ok(VecScale(y, Thetas[k]));
      ok(VecAXPY(y, MASS / Thetas[k], x));
      ok(MatMult(H, x, z));
      ok(VecAXPY(y, 1, z));
      ok(VecNorm(y, NORM_2, &size));
      ok(MatMult(B, x, z));
      AssertVecNear(z, y, NORM_2, 1e-13 * size);
    }
    ok(MatConvert(H, MATDENSE, MAT_INITIAL_MATRIX, &dense));
    ok(MatGetDiagonal(H, d));
    ok(MatGetDiagonal(dense, z));
    ok(VecNorm(z, NORM_2, &size));
    AssertVecNear(z, d, NORM_2, 1e-13 * size);
    ObjectsDestroy(&dense, &x, &y, &z, &d, &B, &H, &K);
  }
}

/* Largest relative distance of the products with iterates that converge, one after the other, from those of exact. */
static PetscReal DistanceOfIterates(Mat exact, Mat H)
{
  PetscReal worst = 0, distance, size;
  PetscInt n;
  Vec x, y, z;

  ok(MatCreateVecs(H, &x, &y));
  ok(VecDuplicate(y, &z));
  ok(VecGetSize(x, &n));
  ok(VecFillSines(x));
  for (PetscInt k = 0; k < 30; k++) { /* more than are remembered */
    ok(VecSetValue(x, 17 * k % n, PetscPowRealInt(0.4, (int)k), ADD_VALUES));
    ok(VecAssemble(x));
    ok(MatMult(exact, x, y));
    ok(MatMult(H, x, z));
    ok(VecNorm(y, NORM_2, &size));
    ok(VecAXPY(z, -1, y));
    ok(VecNorm(z, NORM_2, &distance));
    worst = PetscMax(worst, distance / size);
  }
  ObjectsDestroy(&x, &y, &z);
  return worst;
}

/* The distance of K's viscosity set up by Lanczos' method, as that of large grids is, from the one given, which is
   destroyed. */
static PetscReal DistanceOfLanczos(Mat K, const char type[], const char option[], Mat exact)
{
  PetscReal distance;
  Mat H;

  ok(PetscOptionsSetValue(NULL, option, "lanczos"));
  ok(MatCreateSlipViscosity(K, MASS, ZETA, type, &H));
  ok(PetscOptionsClearValue(NULL, option));
  ok(MatSlipViscositySetTolerance(H, 1e-10)); /* of the exact root */
  distance = DistanceOfIterates(exact, H);
  ObjectsDestroy(&exact, &H);
  return distance;
}

/* The viscosities of large grids against those of small ones: 2e-10, twice the tolerance, for the exact root, and 1e-11
   for the spectral one, whose own tolerance is 1e-12. */
static void test_viscosities_of_large_grids(void **state)
{
  Mat K = Stiffness(0, PETSC_FALSE, "fft"), dense = Stiffness(0, PETSC_FALSE, "dense"), exact;

  ok(MatCreateSlipViscosity(dense, MASS, ZETA, "sqrtm", &exact));
  assert_true(DistanceOfLanczos(K, "sqrtm", "-mat_slipsqrtm_setup", exact) < 2e-10);
  ok(MatCreateSlipViscosity(K, MASS, ZETA, "spectral", &exact));
  assert_true(DistanceOfLanczos(K, "spectral", "-mat_slipspectral_type", exact) < 1e-11);
  ObjectsDestroy(&dense, &K);
}

/* Deep grids take hundreds of Lanczos steps without reorthogonalisation, where a small tolerance meets rounding. A
   field that is almost all new must not be asked for the digits of the little of it that is known. */
static void test_waves_of_deep_grid(void **state)
{
  const SlipGrid grid = {4, 400, 3000.0, 3000.0, 0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};
  PetscReal size, distance;
  Mat K, exact, H;
  Vec x, y, z;

  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, "fft", &K));
  ok(PetscOptionsSetValue(NULL, "-mat_slipspectral_type", "blocks"));
  ok(MatCreateSlipViscosity(K, MASS, ZETA, "spectral", &exact));
  ok(PetscOptionsSetValue(NULL, "-mat_slipspectral_type", "lanczos"));
  ok(MatCreateSlipViscosity(K, MASS, ZETA, "spectral", &H));
  ok(PetscOptionsClearValue(NULL, "-mat_slipspectral_type"));
  ok(MatCreateVecs(K, &x, &y));
  ok(VecDuplicate(y, &z));
  ok(VecSet(x, 1));
  for (int k = 0; k < 8; k++) {
    if (k) { /* k = 1: of another direction but for 1e-8; then ever less is new */
      ok(VecFillSines(z));
      if (k == 1) ok(VecScale(x, 1e-8));
      if (k > 1) ok(VecSetValue(z, 7 * k, 3, INSERT_VALUES));
      ok(VecAssemble(z));
      ok(VecAXPY(x, PetscPowRealInt(0.1, k - 1), z));
    }
    ok(MatMult(exact, x, y));
    ok(MatMult(H, x, z));
    ok(VecNorm(y, NORM_2, &size));
    ok(VecAXPY(z, -1, y));
    ok(VecNorm(z, NORM_2, &distance));
    assert_true(distance <= 1e-11 * size); /* ten times the tolerance, for the sum of increments */
  }
  ok(MatSlipViscosityAllow(H, 1e-3));
  for (int k = 0; k < 12;
       k++) { /* few digits, which few steps a wavenumber have; parts that are known are off as well */
    ok(VecFillSines(z));
    for (PetscInt i = 0; i < 100; i++) ok(VecSetValue(z, 13 * i + k, 10, INSERT_VALUES));
    ok(VecAssemble(z));
    ok(VecAYPX(x, 0.5, z));
    ok(MatMult(exact, x, y));
    ok(MatMult(H, x, z));
    ok(VecNorm(y, NORM_2, &size));
    ok(VecAXPY(z, -1, y));
    ok(VecNorm(z, NORM_2, &distance));
    assert_true(distance <= 3e-3 * size);
  }
  ObjectsDestroy(&x, &y, &z, &H, &exact, &K);
}

SLIP_TESTS(test_contraction_on_grids, test_contraction_without_grid, test_correction_of_cells,
           test_correction_of_a_grid, test_root_of_endless_plane, test_fused_product, test_viscosities_of_large_grids,
           test_waves_of_deep_grid)
