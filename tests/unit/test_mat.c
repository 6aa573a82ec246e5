/* Stiffness, viscosity and stage operator on one process. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>
#include <slipstep.h>
#include <slipstep/private/slipcompat.h>

#define Check(call) assert_int_equal((call), PETSC_SUCCESS)
#define MASS (2500.0 * 3000.0)
#define ZETA (0.8 / 3)

static const SlipGrid Even = {10, 10, 3000.0, 3000.0, 0.0, 30e9, 0.25, PETSC_FALSE};
static const SlipGrid Odd = {9, 12, 2000.0, 3600.0, 700.0, 30e9, 0.1, PETSC_FALSE};

static PetscReal EntryOf(Mat A, PetscInt i, PetscInt j)
{
  PetscScalar value;

  Check(MatGetValues(A, 1, &i, 1, &j, &value));
  return value;
}

/* Entries of the dense stiffness straight from the public kernel, the symmetric part. */
static void test_dense_entries(void **state)
{
  const SlipGrid *g = &Odd;
  const PetscReal a = g->length_x / g->nx, b = g->length_z / g->nz;
  Mat K;

  (void)state;
  Check(MatCreateSlipStiffness(PETSC_COMM_SELF, g, "dense", &K));
  for (PetscInt i = 0; i < g->nx * g->nz; i += 5)
    for (PetscInt j = 0; j < g->nx * g->nz; j++) {
      const PetscReal dx = (i % g->nx - j % g->nx) * a;
      const PetscReal zi = g->depth_top + (i / g->nx + 0.5) * b, zj = g->depth_top + (j / g->nx + 0.5) * b;
      const PetscReal expected =
        0.5 * (SlipKernelHalfSpace(30e9, 0.1, dx, zi, zj, a, b) + SlipKernelHalfSpace(30e9, 0.1, -dx, zj, zi, a, b));

      /* rounding of the distances only */
      assert_true(PetscAbsReal(EntryOf(K, i, j) - expected) < 1e-13 * EntryOf(K, i, i));
    }
  Check(MatDestroy(&K));
}

/* ||H H / mass - 4 zeta^2 K|| / ||4 zeta^2 K||, Frobenius. */
static PetscReal SquareError(Mat K, Mat H)
{
  Mat square, denseK, denseH;
  PetscReal error, norm;

  Check(MatConvert(K, MATDENSE, MAT_INITIAL_MATRIX, &denseK));
  Check(MatConvert(H, MATDENSE, MAT_INITIAL_MATRIX, &denseH));
  Check(MatMatMult(denseH, denseH, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &square));
  Check(MatScale(square, 1 / MASS));
  Check(MatScale(denseK, 4 * ZETA * ZETA));
  Check(MatNorm(denseK, NORM_FROBENIUS, &norm));
  Check(MatAXPY(square, -1, denseK, SAME_NONZERO_PATTERN));
  Check(MatNorm(square, NORM_FROBENIUS, &error));
  Check(MatDestroy(&square));
  Check(MatDestroy(&denseK));
  Check(MatDestroy(&denseH));
  return error / norm;
}

static void test_viscosity_squares_to_stiffness(void **state)
{
  const SlipGrid *const grids[] = {&Even, &Odd};

  (void)state;
  for (int k = 0; k < 2; k++) {
    Mat K, H;

    Check(MatCreateSlipStiffness(PETSC_COMM_SELF, grids[k], "dense", &K));
    Check(MatScale(K, 0.9)); /* the root must follow MatScale() */
    Check(MatCreateSlipViscosity(K, MASS, ZETA, "sqrtm", &H));
    assert_true(SquareError(K, H) < 1e-10);
    Check(MatDestroy(&H));
    Check(MatDestroy(&K));
  }
}

static void test_stage_is_the_sum(void **state)
{
  Mat K, H, B, dense;
  PetscReal theta;

  (void)state;
  Check(MatCreateSlipStiffness(PETSC_COMM_SELF, &Even, "dense", &K));
  Check(MatCreateSlipViscosity(K, MASS, ZETA, "sqrtm", &H));
  Check(MatCreateSlipStage(K, H, MASS, &B));
  for (int k = 0; k < 2; k++) {
    const PetscReal set = k ? 0.003 : 0.7;

    Check(MatSlipStageSetTheta(B, set));
    Check(MatSlipStageGetTheta(B, &theta));
    assert_true(theta == set);
    Check(MatConvert(B, MATDENSE, MAT_INITIAL_MATRIX, &dense));
    for (PetscInt i = 0; i < 100; i += 7)
      for (PetscInt j = 0; j < 100; j++) {
        const PetscReal expected = (i == j ? MASS / set : 0) + EntryOf(H, i, j) + set * EntryOf(K, i, j);

        /* three terms, one rounding each */
        assert_true(PetscAbsReal(EntryOf(dense, i, j) - expected) < 1e-13 * (MASS / set + set * EntryOf(K, i, i)));
      }
    Check(MatDestroy(&dense));
  }
  Check(MatDestroy(&B));
  Check(MatDestroy(&H));
  Check(MatDestroy(&K));
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
    cmocka_unit_test(test_dense_entries),
    cmocka_unit_test(test_viscosity_squares_to_stiffness),
    cmocka_unit_test(test_stage_is_the_sum),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  if (SlipStepInitializePackage()) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  if (PetscFinalize()) return 1;
  return failed;
}
