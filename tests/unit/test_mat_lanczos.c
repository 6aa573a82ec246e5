/* Viscosity by Lanczos' method: its products keep to the tolerance whatever was asked for before, cost less when it is
   loose, and its options are its own. */
#include "unit.h"
#include "products.h"
#include "cells.h"

#define MASS (2500.0 * 3000.0)
#define ZETA (0.8 / 3)
enum { NX = 22, NZ = 18, N = NX * NZ, SIDE = 10 };

static const SlipGrid Grid = {NX, NZ, 3000.0, 2600.0, 0.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};

/* H by Lanczos' method, and a dense root of the same stiffness: of a grid, or of irregular cells with weighted rows. */
static void Create(PetscBool cells, Mat *H, Mat *exact)
{
  static PetscReal data[5 * SIDE * SIDE];
  Mat K, dense;

  if (cells) {
    const SlipCells c = TwoGradedFaults(SIDE, SIDE / 2, 1, data);

    ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &c, "dense", 1e-8, &K));
    ok(MatCreateSlipViscosity(K, MASS, ZETA, "sqrtm", exact));
  } else {
    ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &Grid, "fft", &K));
    ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &Grid, "dense", &dense));
    ok(MatCreateSlipViscosity(dense, MASS, ZETA, "sqrtm", exact));
    ok(MatDestroy(&dense));
  }
  ok(MatCreateSlipViscosity(K, MASS, ZETA, "lanczos", H));
  ok(MatDestroy(&K));
}

/* A smooth hump (kind 0) or signs that alternate wildly, which need the fewest and the most steps; kind 2: a corner. */
static void Fill(Vec x, int kind)
{
  PetscInt n;

  ok(VecGetSize(x, &n));
  for (PetscInt i = 0; i < n; i++)
    ok(VecSetValue(x, i,
                   kind == 0   ? PetscSinReal(PETSC_PI * (PetscReal)(i + 1) / (PetscReal)(n + 1))
                   : kind == 1 ? PetscSinReal(37.0 * (PetscReal)i * (PetscReal)i)
                               : (i == n - 1 ? 1.0 : 0.0),
                   INSERT_VALUES));
  ok(VecAssemble(x));
}

/* |H x - exact x| / |exact x| */
static PetscReal Error(Mat H, Mat exact, Vec x)
{
  PetscReal error;

  ok(ProductDistance(H, exact, x, &error));
  return error;
}

/* Against the dense root, at every tolerance, for vectors of three kinds and their sums, which are products of
   increments: at most twice the tolerance, which all remembered products together may take beside the new one's fifth,
   so three times; and no more than four digits better, or the tolerance would buy nothing. Dense roots are good to
   1e-14. */
static void test_tolerance(void **state)
{
  for (int cells = 0; cells < 2; cells++)
    for (PetscReal tolerance = 1e-3; tolerance > 1e-12; tolerance *= 1e-2) {
      PetscReal worst = 0;
      Mat H, exact;
      Vec x, sum;

      Create((PetscBool)cells, &H, &exact);
      ok(MatSlipViscositySetTolerance(H, tolerance));
      ok(MatCreateVecs(H, &x, &sum));
      ok(VecSet(sum, 0));
      for (int kind = 0; kind < 3; kind++) {
        Fill(x, kind);
        worst = PetscMax(worst, Error(H, exact, x));
        ok(VecAXPY(sum, PetscPowRealInt(0.03, kind), x));
        worst = PetscMax(worst, Error(H, exact, sum));
      }
      AssertLess(worst, 3 * tolerance);
      AssertLess(1e-4 * tolerance, worst);
      ObjectsDestroy(&x, &sum, &H, &exact);
    }
}

/* A direction met first as a small part of x has an image of few digits. When it comes back as all of x, or most of it,
   that image must be forgotten: the error of a product is relative to that product. */
static void test_few_digits_are_forgotten(void **state)
{
  const PetscReal tolerance = 1e-7;

  for (PetscReal part = 1e-2; part > 1e-6; part *= 0.1) {
    Mat H, exact;
    Vec x, small, whole;

    Create(PETSC_FALSE, &H, &exact);
    ok(MatSlipViscositySetTolerance(H, tolerance));
    ok(MatCreateVecs(H, &x, &small));
    ok(VecDuplicate(x, &whole));
    Fill(x, 0);
    Fill(small, 2);
    AssertLess(Error(H, exact, x), 3 * tolerance);
    ok(VecWAXPY(whole, part, small, x));
    AssertLess(Error(H, exact, whole), 3 * tolerance);
    ok(VecAXPY(small, 1e-3, x)); /* both directions are known, but one not well enough */
    AssertLess(Error(H, exact, small), 3 * tolerance);
    ObjectsDestroy(&x, &small, &whole, &H, &exact);
  }
}

/* A solver that wants loose products gets one for an iterate far from the others, no worse than it said, and exact ones
   for the next and for iterates nearby; without its wish all are exact. */
static void test_loose_products(void **state)
{
  const PetscReal loose = 5e-4, tolerance = 1e-8;
  PetscErrorCode (*set)(Mat, PetscReal);
  Mat K, H, B, exact;
  Vec x, y;

  Create(PETSC_FALSE, &H, &exact);
  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &Grid, "fft", &K));
  ok(MatCreateSlipStage(K, H, MASS, &B));
  ok(PetscObjectQueryFunction((PetscObject)B, "MatSlipSetLoose_C", &set));
  assert_non_null(set);
  ok(MatSlipViscositySetTolerance(H, tolerance));
  ok(MatCreateVecs(H, &x, &y));
  Fill(x, 0);
  Fill(y, 1);
  ok(set(B, loose));
  {
    const PetscReal first = Error(H, exact, x);

    assert_true(first < 1.5 * loose && first > 10 * tolerance);
  }
  AssertLess(Error(H, exact, x), 3 * tolerance); /* the next, though it is the same */
  ok(VecAXPY(x, 1e-6, y));
  AssertLess(Error(H, exact, x), 3 * tolerance); /* near: what is spared is not worth a second product */
  ok(set(B, 0));
  AssertLess(Error(H, exact, y), 3 * tolerance);
  ObjectsDestroy(&x, &y, &B, &K, &H, &exact);
}

/* By default Lanczos' method comes first, and a factorised root once it has taken as much work as the set-up of that,
   0.02 s on this grid, a hundred of products of 10 to 30 with K or so. From the next theta on the stage is formed with
   it: exact Jacobians, as -mat_slipsqrtm_setup sketch has. The diagonal is that of before. */
static void test_a_factorised_root_comes_once_it_pays(void **state)
{
  Mat K, H, B, A, exact, lanczos;
  SlipProducts before, after;
  PetscInt n;
  Vec x, y, z;

  Create(PETSC_FALSE, &lanczos, &exact);
  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &Grid, "fft", &K));
  ok(MatCreateSlipViscosity(K, MASS, ZETA, "sqrtm", &H));
  ok(MatCreateSlipStage(K, H, MASS, &B));
  ok(MatSlipStageSetTheta(B, 0.5));
  ok(MatCreateVecs(exact, &x, &y));
  ok(VecDuplicate(x, &z));
  for (n = 0; n < 2000; n++) {
    ok(MatSlipStageGetApproximation(B, &A));
    if (A == B) break;
    for (PetscInt i = 0; i < N; i++)
      ok(VecSetValue(x, i, PetscSinReal((37.0 + (PetscReal)n) * (PetscReal)(i * i)), INSERT_VALUES));
    ok(VecAssemble(x));
    if (n < 10) assert_true(Error(H, exact, x) < 3e-8);
    ok(MatMult(H, x, y));
    ok(MatSlipStageSetTheta(B, 0.5));
  }
  printf("factorised after %d products\n", (int)n);
  assert_in_range(n, 50, 500);
  ok(SlipProductsGet(&before));
  ok(MatMult(H, x, y));
  ok(SlipProductsGet(&after));
  assert_int_equal(after.k - before.k, 0);
  assert_int_equal(after.h - before.h, 1);
  assert_int_equal(after.all - before.all, 1);
  /* 1e-10 of the norm, where the product is a tenth of that or more */
  assert_true(Error(H, exact, x) < 1e-9);
  ok(MatMult(B, x, y));
  ok(SlipProductsGet(&before));
  assert_int_equal(before.h - after.h, 3); /* two were those of Error() */
  ok(MatMult(K, x, z));
  ok(VecAXPBY(z, MASS / 0.5, 0.5, x)); /* mass / theta x + theta K x */
  ok(MatMultAdd(exact, x, z, z));
  AssertVecClose(y, z, NORM_2, 1e-9);
  ObjectsDestroy(&x, &y, &z, &B, &H, &K, &exact, &lanczos);
}

/* Two stiffnesses with prefixes of their own, one plain: each viscosity and stage reads its own options; a setter
   counts unless the option is read again. What was given up is refused by name. */
static void test_options_have_one_owner(void **state)
{
  static const char *const prefixes[] = {"one_", "two_", ""};
  static const char *const types[] = {"sliplanczos", "slipspectral", "slipspectral"};
  Mat K[3], H[3], B[3], A, exact, plain;
  MatType type;
  Vec x;

  ok(PetscOptionsInsertString(
    NULL, "-one_mat_slipsqrtm_setup lanczos -one_mat_slipsqrtm_tolerance 1e-3 -two_mat_slipsqrtm_setup sketch "
          "-two_mat_slipstage_jacobian approximate -mat_slipsqrtm_setup sketch"));
  for (int k = 0; k < 3; k++) {
    ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &Grid, "fft", &K[k]));
    ok(MatSetOptionsPrefix(K[k], prefixes[k]));
    ok(MatCreateSlipViscosity(K[k], MASS, ZETA, "sqrtm", &H[k]));
    ok(MatCreateSlipStage(K[k], H[k], MASS, &B[k]));
    ok(MatSlipStageSetFromOptions(B[k]));
    ok(MatSlipStageSetTheta(B[k], 1));
    ok(MatGetType(H[k], &type));
    assert_string_equal(type, types[k]);
    ok(MatSlipStageGetApproximation(B[k], &A));
    assert_int_equal(A == B[k], k == 2); /* by cost for the first, as asked for the second */
  }
  ok(MatSlipStageSetJacobian(B[0], "exact"));
  ok(MatSlipStageGetApproximation(B[0], &A));
  assert_ptr_equal(A, B[0]);
  fails(MatSlipStageSetJacobian(B[0], "cheap"), "\"cheap\", expected auto, exact or approximate");
  Create(PETSC_FALSE, &plain, &exact);
  ok(MatCreateVecs(exact, &x, NULL));
  Fill(x, 1);
  assert_true(Error(H[0], exact, x) > 1e-7);
  ok(MatSlipViscositySetTolerance(H[0], 1e-9)); /* as a program that has an option of its own does */
  assert_true(Error(H[0], exact, x) < 3e-9);
  ok(MatSlipViscositySetFromOptions(H[0]));
  assert_true(Error(H[0], exact, x) > 1e-7);
  assert_true(Error(plain, exact, x) < 3e-8);
  ok(PetscOptionsSetValue(NULL, "-two_mat_slipsqrtm_setup", "dense"));
  fails(MatCreateSlipViscosity(K[1], MASS, ZETA, "sqrtm", &A),
        "-two_mat_slipsqrtm_setup is \"dense\", expected auto, sketch or lanczos");
  ok(PetscOptionsClear(NULL));
  for (int k = 0; k < 3; k++) ObjectsDestroy(&B[k], &H[k], &K[k]);
  ObjectsDestroy(&x, &plain, &exact);
}

/* Nothing is read from the options database but by SetFromOptions(), with the prefix; what is known too late is
   said. */
static void test_stiffness_options(void **state)
{
  Mat K;
  Vec x, y;

  ok(PetscOptionsInsertString(NULL, "-mat_slipfft_depth none -one_mat_slipfft_depth transform"));
  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &Grid, "fft", &K));
  fails(MatSlipStiffnessSetFromOptions(K), "\"none\", expected auto, blocks or transform");
  ok(MatSetOptionsPrefix(K, "one_"));
  ok(MatSlipStiffnessSetFromOptions(K));
  ok(MatCreateVecs(K, &x, &y));
  Fill(x, 0);
  ok(MatMult(K, x, y));
  ok(MatSlipStiffnessSetDepth(K, "transform"));
  fails(MatSlipStiffnessSetDepth(K, "blocks"), "before the first product");
  ObjectsDestroy(&x, &y, &K);
  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &Grid, "fft", &K));
  ok(MatSlipStiffnessSetShare(K, PETSC_TRUE));
  ok(MatSlipStiffnessSetDepth(K, "blocks"));
  ok(MatCreateVecs(K, &x, &y));
  ok(MatMult(K, x, y));
  fails(MatSlipStiffnessSetShare(K, PETSC_FALSE), "before the stiffness is used");
  ok(PetscOptionsClear(NULL));
  ObjectsDestroy(&x, &y, &K);
}

/* With K, as -log_view counts them */
static PetscInt Products(void)
{
  PetscEventPerfInfo info;
  PetscLogEvent event;

  ok(PetscLogEventGetId("SlipKMult", &event));
  ok(PetscLogEventGetPerfInfo(PETSC_DETERMINE, event, &info));
  return info.count;
}

/* Rates of an explicit scheme, a front that moves on: to the error allowed, which spares more than half of the
   products, and to the tolerance again once that is taken back, though what is remembered then is worse. */
static void test_allowed_error(void **state)
{
  const PetscReal allowed = 1e-3, tolerance = 1e-9;

  ok(PetscLogDefaultBegin());
  for (int cells = 0; cells < 2; cells++) {
    PetscInt products[2], n;
    Mat H, exact;
    Vec x;

    Create((PetscBool)cells, &H, &exact);
    ok(MatSlipViscositySetTolerance(H, tolerance));
    ok(MatCreateVecs(H, &x, NULL));
    ok(VecGetSize(x, &n));
    for (int within = 1; within >= 0; within--) {
      const PetscReal most = within ? allowed : tolerance;
      PetscReal worst = 0;
      PetscInt before;

      ok(MatSlipViscosityAllow(H, within ? allowed : 0));
      before = Products();
      for (int k = 0; k < 30; k++) {
        for (PetscInt i = 0; i < n; i++)
          ok(VecSetValue(x, i, 1 + PetscTanhReal(k / 3.0 - 10.0 * (PetscReal)i / (PetscReal)n), INSERT_VALUES));
        ok(VecAssemble(x));
        worst = PetscMax(worst, Error(H, exact, x));
      }
      products[within] = Products() - before;
      assert_true(worst < 3 * most && worst > 1e-3 * most);
    }
    AssertLess(2 * products[1], products[0]);
    ObjectsDestroy(&x, &H, &exact);
  }
}

SLIP_TESTS(test_tolerance, test_few_digits_are_forgotten, test_loose_products, test_allowed_error,
           test_a_factorised_root_comes_once_it_pays, test_options_have_one_owner, test_stiffness_options)
