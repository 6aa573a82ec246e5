/* K, H and B: types agree with each other, and products do not depend on the number of ranks. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>
#include <slipstep.h>
#include <slipstep/private/slipcompat.h>

/* Odd and even numbers of cells, neither divisible by 4, so that ranks own different numbers of rows. */
static const SlipGrid Grids[] = {
  {9, 7, 2700.0, 2450.0, 0.0, 30e9, 0.25, PETSC_FALSE},
  {6, 11, 3000.0, 2200.0, 500.0, 30e9, 0.31, PETSC_FALSE},
  {7, 5, 1000.0, 1000.0, 0.0, 30e9, 0.25, PETSC_TRUE},
};
#define MASS (2500.0 * 3000.0)
#define ZETA (0.8 / 3)

#define Check(call) assert_int_equal((call), PETSC_SUCCESS)

/* A field without symmetry, the same whatever the distribution. */
static void FillField(Vec x)
{
  PetscInt start, end;

  Check(VecGetOwnershipRange(x, &start, &end));
  for (PetscInt i = start; i < end; i++)
    Check(VecSetValue(x, i, PetscSinReal(1.0 + 0.7 * i + 0.01 * i * i), INSERT_VALUES));
  Check(VecAssemblyBegin(x));
  Check(VecAssemblyEnd(x));
}

/* Relative distance between A x and the same product of a one-rank copy made by every rank. */
static PetscReal DistanceToSerial(Mat A, Mat serial)
{
  Vec x, y, xs, ys;
  PetscInt start, end;
  const PetscScalar *py, *ps;
  PetscReal worst = 0, norm;

  Check(MatCreateVecs(A, &x, &y));
  Check(MatCreateVecs(serial, &xs, &ys));
  FillField(x);
  FillField(xs);
  Check(MatMult(A, x, y));
  Check(MatMult(serial, xs, ys));
  Check(VecNorm(ys, NORM_INFINITY, &norm));
  Check(VecGetOwnershipRange(y, &start, &end));
  Check(VecGetArrayRead(y, &py));
  Check(VecGetArrayRead(ys, &ps));
  for (PetscInt i = start; i < end; i++) worst = PetscMax(worst, PetscAbsReal(py[i - start] - ps[i]));
  Check(VecRestoreArrayRead(y, &py));
  Check(VecRestoreArrayRead(ys, &ps));
  Check(MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPIU_REAL, MPI_MAX, PETSC_COMM_WORLD));
  Check(VecDestroy(&x));
  Check(VecDestroy(&y));
  Check(VecDestroy(&xs));
  Check(VecDestroy(&ys));
  return worst / norm;
}

static void AssertDefaultLayout(Mat A)
{
  PetscInt m = PETSC_DECIDE, N, local;

  Check(MatGetSize(A, &N, NULL));
  Check(PetscSplitOwnership(PETSC_COMM_WORLD, &m, &N));
  Check(MatGetLocalSize(A, &local, NULL));
  assert_int_equal(m, local);
}

typedef struct {
  Mat K, H, B;
} Operators;

static Operators Create(MPI_Comm comm, const SlipGrid *grid, const char *type)
{
  Operators o;

  Check(MatCreateSlipStiffness(comm, grid, type, &o.K));
  Check(MatScale(o.K, 0.37));
  Check(MatCreateSlipViscosity(o.K, MASS, ZETA, "sqrtm", &o.H));
  Check(MatCreateSlipStage(o.K, o.H, MASS, &o.B));
  Check(MatSlipStageSetTheta(o.B, 0.2));
  return o;
}

static void Destroy(Operators *o)
{
  Check(MatDestroy(&o->K));
  Check(MatDestroy(&o->H));
  Check(MatDestroy(&o->B));
}

/* 1e-12: sums of N < 100 terms in another order, each product a few units of 1e-16 times the condition of the sum. */
static void test_products_do_not_depend_on_ranks(void **state)
{
  static const char *const types[] = {"dense", "fft", "auto"};

  (void)state;
  for (size_t g = 0; g < PETSC_STATIC_ARRAY_LENGTH(Grids); g++) {
    Operators reference = Create(PETSC_COMM_SELF, &Grids[g], "dense");

    for (size_t t = 0; t < PETSC_STATIC_ARRAY_LENGTH(types); t++) {
      Operators o = Create(PETSC_COMM_WORLD, &Grids[g], types[t]);

      AssertDefaultLayout(o.K);
      AssertDefaultLayout(o.H);
      AssertDefaultLayout(o.B);
      assert_true(DistanceToSerial(o.K, reference.K) < 1e-12);
      assert_true(DistanceToSerial(o.H, reference.H) < 1e-10);
      assert_true(DistanceToSerial(o.B, reference.B) < 1e-12);
      Destroy(&o);
    }
    Destroy(&reference);
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
    cmocka_unit_test(test_products_do_not_depend_on_ranks),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  if (SlipStepInitializePackage()) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  if (PetscFinalize()) return 1;
  return failed;
}
