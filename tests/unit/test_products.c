/* Products of implicit steps: how many a step takes, that sums of known ones are products, and that steps keep their
   accuracy. */
#include "faultstart.h"
#include "unit.h"
#include <slipstep/rooms/slipelastic.h>
#include <slipstep/rooms/slipmat.h>
#include <slipstep/rooms/slipsnes.h>
#include <slipstep/private/slipfault.h>

/* Products with K so far. Those with a stage operator are others where it has one transform for K and H, and contain
   one with K where H is a diagonal. */
static PetscInt Products(PetscBool apart)
{
  const char *const names[] = {"SlipKMult", "SlipBMult"};
  PetscInt sum = 0;

  for (int k = 0; k < (apart ? 2 : 1); k++) {
    PetscEventPerfInfo info;
    PetscLogEvent event;

    ok(PetscLogEventGetId(names[k], &event));
    ok(PetscLogEventGetPerfInfo(PETSC_DETERMINE, event, &info));
    sum += info.count;
  }
  return sum;
}

/* Mean slip at the end of constant steps, and the products of one: of 192 cells, whose stages are solved directly where
   H is a diagonal */
static PetscReal Run(PetscBool quasi, PetscReal stage_error, PetscInt steps, PetscReal *each)
{
  const PetscReal end = 15;
  SlipFaultObservables o;
  PetscInt before;
  SlipFault fault;
  Vec w;
  TS ts;

  ok(PetscLogDefaultBegin());
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetStrings(fault, {"stiffness_scaling", "mean_slip"}, {"operator", "fft"}));
  ok(FaultSetReals(fault, {"nx", 16}, {"nz", 12}, {"length_x", 3000}, {"length_z", 2250}));
  ok(PetscOptionsSetValue(NULL, "-mat_slipsqrtm_setup", "sketch")); /* products are K's and H's own */
  if (quasi) {
    ok(SlipFaultSetString(fault, "viscosity", "radiation"));
    ok(SlipFaultSetBool(fault, "inertia", PETSC_FALSE));
  }
  ok(FaultStart(fault, TSADAPTNONE, end / (PetscReal)steps, end, &w, &ts));
  ok(TSBatheSetStageError(ts, stage_error));
  before = Products(!quasi);
  ok(TSSolve(ts, w));
  if (each) *each = (PetscReal)(Products(!quasi) - before) / (PetscReal)steps;
  ok(SlipFaultGetObservables(fault, end, w, NULL, &o));
  ok(SlipFaultDestroy(&fault));
  ObjectsDestroy(&w, &ts);
  return o.mean_slip;
}

/* Without memory of products and with stages solved to rounding a step took 25 to 30; with inertia two products besides
   those of conjugate gradients are left. What inexact stages add is small against the error of the step. */
static void steps_take_few(void **state)
{
  const PetscReal most[] = {8, 9}, exact_most[] = {15, 11};

  for (int quasi = 0; quasi < 2; quasi++) {
    PetscReal each, exact_each;
    const PetscReal fine = Run(quasi != 0, 0, 480, NULL), exact = Run(quasi != 0, 0, 60, &exact_each),
                    inexact = Run(quasi != 0, 0.1, 60, &each);

    printf("%s: %g products a step, to rounding %g; error %g, to rounding %g\n", quasi ? "radiation" : "inertia", each,
           exact_each, inexact / fine - 1, exact / fine - 1);
    assert_true(exact > 0.01 && each < most[quasi] && exact_each < exact_most[quasi]);
    assert_true(fabs(inexact - exact) < 0.1 * fabs(exact - fine) && inexact != exact);
  }
}

/* To rounding */
static void SameProduct(Vec value, Vec expected)
{

  AssertVecClose(value, expected, NORM_INFINITY, 1e-13);
}

static void Fill(Vec x, PetscReal phase)
{
  PetscReal *a;
  PetscInt n;

  ok(VecGetLocalSize(x, &n));
  ok(VecGetArrayWrite(x, &a));
  for (PetscInt i = 0; i < n; i++) a[i] = sin(phase + 0.7 * (PetscReal)i);
  ok(VecRestoreArrayWrite(x, &a));
}

/* K (2 x - y / 2) of known K x and K y, from a copy, without a product; with one where a bit has changed */
static void sums_are_known(void **state)
{
  const PetscReal factor[] = {2, -0.5};
  PetscInt before, after;
  SlipFault fault;
  Vec x, y, sum, image, expected, w;
  Mat K;
  TS ts;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetReals(fault, {"nx", 6}, {"nz", 5}));
  ok(FaultStart(fault, TSADAPTNONE, 0.1, 0.2, &w, &ts));
  ok(SlipElasticGetMatrices(fault->medium, &K, NULL, NULL));
  ok(SlipElasticStage(fault->medium, 0, 0.1));
  ok(MatCreateVecs(K, &x, &y));
  VecsDuplicate(x, &sum, &image, &expected);
  Fill(x, 0);
  Fill(y, 1);
  ok(SlipElasticApply(fault->medium, x, image, NULL));
  ok(SlipElasticApply(fault->medium, y, image, NULL));
  ok(VecCopy(x, sum));
  ok(VecAXPBY(sum, factor[1], factor[0], y));
  ok(MatMult(K, sum, expected));
  ok(SlipElasticStoreSum(fault->medium, sum, 2, factor, (const Vec[]){x, y}));
  before = Products(PETSC_TRUE);
  ok(VecCopy(sum, x));
  ok(SlipElasticApply(fault->medium, x, image, NULL));
  after = Products(PETSC_TRUE);
  assert_int_equal(after, before);
  SameProduct(image, expected);
  ok(VecShift(x, 1e-12));
  ok(SlipElasticApply(fault->medium, x, image, NULL));
  after = Products(PETSC_TRUE);
  assert_int_equal(after, before + 1);
  ok(SlipElasticForget(fault->medium));
  ok(SlipElasticApply(fault->medium, sum, image, NULL));
  after = Products(PETSC_TRUE);
  assert_int_equal(after, before + 2);
  ok(SlipFaultDestroy(&fault));
  ObjectsDestroy(&x, &y, &sum, &image, &expected, &w, &ts);
}

/* B x of the solution x of conjugate gradients, in rows of sliding and of sticking cells, without a product */
static void solutions_come_with_their_product(void **state)
{
  Vec mask, slope, rhs, x, image = NULL, expected;
  PetscInt before, after, iterations;
  SlipFault fault;
  Vec w;
  TS ts;
  Mat B, J;
  KSP ksp;
  PetscErrorCode (*get)(KSP, Vec *);

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(SlipFaultSetString(fault, "operator", "fft"));
  ok(FaultSetReals(fault, {"nx", 8}, {"nz", 6}));
  ok(FaultStart(fault, TSADAPTNONE, 0.1, 0.2, &w, &ts));
  ok(SlipElasticStage(fault->medium, 0, 0.3));
  ok(SlipElasticGetStage(fault->medium, &B, NULL));
  ok(MatCreateVecs(B, &mask, &slope));
  VecsDuplicate(mask, &rhs, &x, &expected);
  for (PetscInt i = 0; i < 48; i++) ok(VecSetValue(mask, i, i % 5 && i < 40, INSERT_VALUES));
  ok(VecAssemble(mask));
  ok(VecZeroEntries(slope));
  Fill(rhs, 2);
  ok(VecPointwiseMult(rhs, rhs, mask));
  ok(MatCreateSlipJacobian(B, &J));
  ok(MatSlipJacobianSetParts(J, B, mask, slope));
  ok(KSPCreate(PETSC_COMM_SELF, &ksp));
  ok(KSPSetType(ksp, KSPSLIPCG));
  ok(KSPSetOperators(ksp, J, J));
  ok(KSPSetTolerances(ksp, 1e-3, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  before = Products(PETSC_TRUE);
  ok(KSPSolve(ksp, rhs, x));
  after = Products(PETSC_TRUE);
  ok(KSPGetIterationNumber(ksp, &iterations));
  assert_true(iterations > 2 && after - before == iterations);
  ok(PetscObjectQueryFunction((PetscObject)ksp, "KSPSlipGetImage_C", &get));
  ok((*get)(ksp, &image));
  ok(MatMult(B, x, expected));
  SameProduct(image, expected);
  ok(SlipFaultDestroy(&fault));
  ObjectsDestroy(&mask, &slope, &rhs, &x, &expected, &w, &ts, &J, &ksp);
}

/* Set-ups that fail leave nothing behind: products of others go on to count, however many there were. */
static void failed_setups_leave_nothing(void **state)
{
  SlipProducts before, after;
  SlipFault fault;
  Vec x, y, w;
  Mat K;
  TS ts;

  for (int i = 0; i < 40; i++) {
    ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
    ok(SlipFaultSetString(fault, "stiffness_file", "missing.h5"));
    ok(FaultSetReals(fault, {"nx", 3}, {"nz", 2}));
    fails(SlipFaultSetUp(fault), "missing.h5");
    ok(SlipFaultDestroy(&fault));
  }
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetReals(fault, {"nx", 3}, {"nz", 2}));
  ok(FaultStart(fault, TSADAPTNONE, 0.1, 0.2, &w, &ts));
  ok(SlipElasticGetMatrices(fault->medium, &K, NULL, NULL));
  ok(MatCreateVecs(K, &x, &y));
  Fill(x, 0);
  ok(SlipProductsGet(&before));
  ok(MatMult(K, x, y));
  ok(SlipProductsGet(&after));
  AssertNear(after.k - before.k, 1, 0);
  ok(SlipFaultDestroy(&fault));
  ObjectsDestroy(&x, &y, &w, &ts);
}

SLIP_TESTS(steps_take_few, sums_are_known, solutions_come_with_their_product, failed_setups_leave_nothing)
