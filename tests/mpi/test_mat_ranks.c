/* K, H and B: types agree with each other, and products do not depend on the number of ranks. */
#define _XOPEN_SOURCE 700 /* mkdir, getpid */
#include "unit.h"
#include <stdlib.h>
#include "tempdir.h"

/* Odd and even numbers of cells, neither divisible by 4, so that ranks own different numbers of rows. */
static const SlipGrid Grids[] = {
  {9, 7, 2700.0, 2450.0, 0.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)},
  {6, 11, 3000.0, 2200.0, 500.0, ROCK(0.31, PETSC_FALSE, SLIP_AVERAGE_CENTRE)},
  {7, 5, 1000.0, 1000.0, 0.0, ROCK(0.25, PETSC_TRUE, SLIP_AVERAGE_CENTRE)},
  {9, 6, 2700.0, 2100.0, 0.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_WHOLE)},
  {8, 7, 2700.0, 2100.0, 0.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CELL)},
};
#define MASS (2500.0 * 3000.0)
#define ZETA (0.8 / 3)

/* Relative distance between A x and the same product of a one-rank copy made by every rank. */
static PetscReal DistanceToSerial(Mat A, Mat serial)
{
  Vec x, y, xs, ys;
  PetscInt start, end;
  const PetscScalar *py, *ps;
  PetscReal worst = 0, norm;

  ok(MatCreateVecs(A, &x, &y));
  ok(MatCreateVecs(serial, &xs, &ys));
  ok(VecFillSines(x));
  ok(VecFillSines(xs));
  ok(MatMult(A, x, y));
  ok(MatMult(serial, xs, ys));
  ok(VecNorm(ys, NORM_INFINITY, &norm));
  ok(VecGetOwnershipRange(y, &start, &end));
  py = VecRead(y);
  ps = VecRead(ys);
  for (PetscInt i = start; i < end; i++) worst = PetscMax(worst, PetscAbsReal(py[i - start] - ps[i]));
  ok(MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPIU_REAL, MPI_MAX, PETSC_COMM_WORLD));
  ObjectsDestroy(&x, &y, &xs, &ys);
  return worst / norm;
}

static void AssertDefaultLayout(Mat A)
{
  PetscInt m = PETSC_DECIDE, N, local;

  ok(MatGetSize(A, &N, NULL));
  ok(PetscSplitOwnership(PETSC_COMM_WORLD, &m, &N));
  ok(MatGetLocalSize(A, &local, NULL));
  assert_int_equal(m, local);
}

static PetscErrorCode PreconditionerMult(Mat P, Vec x, Vec y)
{
  PC pc;

  PetscCall(MatShellGetContext(P, &pc));
  return PCApply(pc, x, y);
}

typedef struct {
  Mat K, H, B;
} Operators;

static Operators Create(MPI_Comm comm, const SlipGrid *grid, const char *type)
{
  Operators o;

  ok(MatCreateSlipStiffness(comm, grid, type, &o.K));
  ok(MatSlipStiffnessSetFromOptions(o.K));
  ok(MatScale(o.K, 0.37));
  ok(MatCreateSlipViscosity(o.K, MASS, ZETA, "sqrtm", &o.H));
  ok(MatCreateSlipStage(o.K, o.H, MASS, &o.B));
  ok(MatSlipStageSetTheta(o.B, 0.2));
  return o;
}

static void Destroy(Operators *o)
{
  ObjectsDestroy(&o->K, &o->H, &o->B);
}

/* Products against one rank's: |K - K'|, |H - H'|, |B - B'|; tolerance 0: not compared */
static void AssertClose(const Operators *o, const Operators *other, PetscReal K, PetscReal H, PetscReal B)
{
  assert_true(DistanceToSerial(o->K, other->K) < K);
  if (H > 0) assert_true(DistanceToSerial(o->H, other->H) < H);
  assert_true(DistanceToSerial(o->B, other->B) < B);
}

/* Products on this communicator against one rank's. 1e-12: sums of N < 100 terms in another order. The exact root of
   type "fft" is truncated at 1e-10, so it is compared with one rank's own to 1e-12 and with the dense one to 1e-10. */
static void test_products_do_not_depend_on_ranks(void **state)
{
  static const char *const types[] = {"dense", "fft", "auto"};

  for (size_t g = 0; g < PETSC_STATIC_ARRAY_LENGTH(Grids); g++) {
    Operators dense = Create(PETSC_COMM_SELF, &Grids[g], "dense");
    Mat converted;

    for (size_t t = 0; t < PETSC_STATIC_ARRAY_LENGTH(types); t++) {
      Operators o = Create(PETSC_COMM_WORLD, &Grids[g], types[t]),
                serial = Create(PETSC_COMM_SELF, &Grids[g], types[t]);

      AssertDefaultLayout(o.K);
      AssertDefaultLayout(o.H);
      AssertDefaultLayout(o.B);
      ok(MatConvert(o.K, MATDENSE, MAT_INITIAL_MATRIX, &converted));
      assert_true(DistanceToSerial(converted, dense.K) < 1e-12);
      ok(MatDestroy(&converted));
      AssertClose(&o, &dense, 1e-12, 1e-10, 1e-10);
      AssertClose(&o, &serial, 1e-12, 1e-12, 1e-12);
      Destroy(&o);
      Destroy(&serial);
    }
    Destroy(&dense);
  }
}

/* Distributed transforms, K alone and within H and B; rows and wavenumbers that do not divide by the ranks. One plan
   serves every row, so that only the sums over vectors (VecNorm) could differ: 1e-12 is generous. */
static void test_transforms_do_not_depend_on_ranks(void **state)
{
  ok(PetscOptionsSetValue(NULL, "-mat_slipfft_depth", "transform"));
  for (size_t g = 0; g < PETSC_STATIC_ARRAY_LENGTH(Grids); g++) {
    Operators o = Create(PETSC_COMM_WORLD, &Grids[g], "fft"), serial = Create(PETSC_COMM_SELF, &Grids[g], "fft"),
              dense = Create(PETSC_COMM_SELF, &Grids[g], "dense");

    AssertDefaultLayout(o.K);
    AssertClose(&o, &serial, 1e-12, 1e-12, 1e-12);
    AssertClose(&o, &dense, 1e-12, 0, 1e-10);
    Destroy(&o);
    Destroy(&serial);
    Destroy(&dense);
  }
  ok(PetscOptionsClearValue(NULL, "-mat_slipfft_depth"));
}

/* Receives and sends of this rank so far, and their bytes */
static void Messages(PetscLogDouble counts[4])
{
  counts[0] = petsc_irecv_ct;
  counts[1] = petsc_irecv_len;
  counts[2] = petsc_isend_ct;
  counts[3] = petsc_isend_len;
}

/* The messages of a product, as -log_view counts them: one to every other rank each way, with the complex numbers of
   all rows at wavenumbers of other ranks. Ranks have 8 / size rows, as vectors do, so that the sum over the ranks does
   not depend on how the 7 wavenumbers are distributed. */
static void test_messages_of_transforms_are_logged(void **state)
{
#if defined(PETSC_USE_LOG) && !defined(PETSC_HAVE_BROKEN_RECURSIVE_MACRO)
  const SlipGrid grid = {6, 8, 3000.0, 2200.0, 500.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};
  PetscLogDouble before[4], counts[4];
  PetscMPIInt size;
  Vec x, y;
  Mat K;

  ok(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  ok(PetscOptionsSetValue(NULL, "-mat_slipfft_depth", "transform"));
  ok(MatCreateSlipStiffness(PETSC_COMM_WORLD, &grid, "fft", &K));
  ok(MatSlipStiffnessSetFromOptions(K));
  ok(MatCreateVecs(K, &x, &y));
  ok(VecFillSines(x));
  ok(MatMult(K, x, y)); /* creates the transforms */
  Messages(before);
  ok(MatMult(K, x, y));
  Messages(counts);
  for (int i = 0; i < 4; i++) counts[i] -= before[i];
  ok(MPI_Allreduce(MPI_IN_PLACE, counts, 4, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD));
  for (int sent = 0; sent < 2; sent++) {
    assert_true(counts[2 * sent] == 2 * size * (size - 1));
    assert_true(counts[2 * sent + 1] == 2 * 16 * (8 - 8 / size) * 7);
  }
  ok(PetscOptionsClearValue(NULL, "-mat_slipfft_depth"));
  ObjectsDestroy(&K, &x, &y);
#endif
}

/* The preconditioner as an operator: P x on this communicator against one rank's. */
static Mat PreconditionerOf(MPI_Comm comm, Mat B, PC *pc)
{
  Mat P;
  PetscInt m, N;

  ok(PCCreate(comm, pc));
  ok(PCSetOperators(*pc, B, B));
  ok(PCSetType(*pc, PCSLIPSTAGE));
  ok(PCSetUp(*pc));
  ok(MatGetSize(B, &N, NULL));
  ok(MatGetLocalSize(B, &m, NULL));
  ok(MatCreateShell(comm, m, m, N, N, *pc, &P));
  ok(MatShellSetOperation(P, MATOP_MULT, SlipMatShellFn(PreconditionerMult)));
  return P;
}

static void test_preconditioner_does_not_depend_on_ranks(void **state)
{
  static const char *const types[] = {"dense", "fft"};

  for (size_t t = 0; t < PETSC_STATIC_ARRAY_LENGTH(types); t++) {
    Operators o = Create(PETSC_COMM_WORLD, &Grids[0], types[t]), serial = Create(PETSC_COMM_SELF, &Grids[0], types[t]);
    PC pc, pc_serial;
    Mat P = PreconditionerOf(PETSC_COMM_WORLD, o.B, &pc),
        P_serial = PreconditionerOf(PETSC_COMM_SELF, serial.B, &pc_serial);

    assert_true(DistanceToSerial(P, P_serial) < 1e-12);
    ObjectsDestroy(&P, &P_serial);
    ok(PCDestroy(&pc));
    ok(PCDestroy(&pc_serial));
    Destroy(&o);
    Destroy(&serial);
  }
}

/* Viscosities without set-up; rows and wavenumbers that do not divide by the ranks. Lanczos' processes end at a
   tolerance: where rounding moves a step of theirs, products differ by that, 1e-10 as asked for here, and 1e-12 for the
   spectral one. */
static void test_lean_viscosities_do_not_depend_on_ranks(void **state)
{
  static const struct {
    const char *type;
    PetscReal tolerance;
  } rows[] = {{"toeplitz", 1e-12}, {"lanczos", 2e-10}, {"spectral", 2e-12}};

  ok(PetscOptionsSetValue(NULL, "-mat_slipspectral_type", "lanczos"));
  for (size_t g = 0; g < PETSC_STATIC_ARRAY_LENGTH(Grids); g++)
    for (size_t t = 0; t < PETSC_STATIC_ARRAY_LENGTH(rows); t++) {
      Mat K, H, K_serial, H_serial;

      if (Grids[g].kernel.average == SLIP_AVERAGE_WHOLE && t != 1) continue; /* they do not know the border's cells */
      ok(MatCreateSlipStiffness(PETSC_COMM_WORLD, &Grids[g], "fft", &K));
      ok(MatSlipStiffnessSetFromOptions(K));
      ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &Grids[g], "fft", &K_serial));
      ok(MatSlipStiffnessSetFromOptions(K_serial));
      ok(MatCreateSlipViscosity(K, MASS, ZETA, rows[t].type, &H));
      ok(MatCreateSlipViscosity(K_serial, MASS, ZETA, rows[t].type, &H_serial));
      ok(MatSlipViscositySetTolerance(H, 1e-10));
      ok(MatSlipViscositySetTolerance(H_serial, 1e-10));
      AssertDefaultLayout(H);
      assert_true(DistanceToSerial(H, H_serial) < rows[t].tolerance);
      ObjectsDestroy(&H, &H_serial, &K, &K_serial);
    }
  ok(PetscOptionsClearValue(NULL, "-mat_slipspectral_type"));
}

/* More ranks than cells: some own nothing. */
static void test_fewer_cells_than_ranks(void **state)
{
  const SlipGrid single = {1, 1, 3000.0, 3000.0, 0.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};
  static const char *const types[] = {"dense", "fft"};

  for (size_t t = 0; t < PETSC_STATIC_ARRAY_LENGTH(types); t++) {
    Operators o = Create(PETSC_COMM_WORLD, &single, types[t]), serial = Create(PETSC_COMM_SELF, &single, "dense");

    assert_true(DistanceToSerial(o.B, serial.B) < 1e-12);
    Destroy(&o);
    Destroy(&serial);
  }
}

/* Only rank 0 has the entries; a fault in them is an error on every rank, not a hang. */
static void test_entries_from_rank_0(void **state)
{
  const PetscReal good[9] = {4e6, 1e6, 0, 1e6, 3e6, 5e5, 0, 5e5, 2e6};
  const PetscReal bad[9] = {4e6, 1e6, 0, 1e6, -3e6, 5e5, 0, 5e5, 2e6};
  PetscMPIInt rank;
  PetscErrorCode code;
  PetscReal norm;
  Mat K;

  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  ok(MatCreateSlipStiffnessFromEntries(PETSC_COMM_WORLD, 3, rank ? NULL : good, "test", &K));
  AssertDefaultLayout(K);
  ok(MatNorm(K, NORM_INFINITY, &norm));
  assert_true(norm == 5e6);
  ok(MatDestroy(&K));
  ok(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  code = MatCreateSlipStiffnessFromEntries(PETSC_COMM_WORLD, 3, rank ? NULL : bad, "test", &K);
  ok(PetscPopErrorHandler());
  assert_int_not_equal(code, 0);
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
    cmocka_unit_test(test_products_do_not_depend_on_ranks),
    cmocka_unit_test(test_transforms_do_not_depend_on_ranks),
    cmocka_unit_test(test_messages_of_transforms_are_logged),
    cmocka_unit_test(test_preconditioner_does_not_depend_on_ranks),
    cmocka_unit_test(test_lean_viscosities_do_not_depend_on_ranks),
    cmocka_unit_test(test_fewer_cells_than_ranks),
    cmocka_unit_test(test_entries_from_rank_0),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  if (SlipStepInitializePackage()) return 1;
  if (PetscOptionsSetValue(NULL, "-mat_slipsqrtm_setup", "sketch")) return 1; /* Lanczos' method: "lanczos", below */
  failed = cmocka_run_group_tests_name("every rank multiplies small fields whole", tests, NULL, NULL);
  if (PetscOptionsSetValue(NULL, "-mat_slip_share", "true")) return 1;
  failed += cmocka_run_group_tests_name("ranks share rows and wavenumbers", tests, NULL, NULL);
  if (PetscFinalize()) return 1;
  return failed;
}
