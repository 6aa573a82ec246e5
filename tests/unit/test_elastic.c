/* A medium: its largest frequency against eigenvalues of a dense matrix. And one of a user's: the rock is strained
   uniformly, so that the stress along rakes grows at a rate by itself. It is -fault_stressing_rate by another way, and
   must equal it. */
#include "faultstart.h"
#include "unit.h"
#include "cells.h"
#include <slipstep/rooms/slipelastic.h>
#include <slipstep/private/slipelastic.h>
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipstate.h>
#include <petscblaslapack.h>

static PetscReal Rate; /* of the next medium [Pa/s] */

typedef struct {
  PetscReal rate;
  Vec along; /* of rate 1 */
} Strain;

static PetscErrorCode SetUp_Strain(SlipElastic el, const SlipElasticRock *rock)
{
  Strain *c;

  PetscCall(SlipElasticGetData(el, &c));
  PetscCall(VecDuplicate(rock->along, &c->along));
  return VecCopy(rock->along, c->along);
}

static PetscErrorCode Force_Strain(SlipElastic el, PetscReal t, Vec u, Vec v, Vec shear, Vec normal)
{
  Strain *c;

  PetscCall(SlipElasticGetData(el, &c));
  PetscCall(SlipElasticForceStatic(el, t, u, v, shear, normal));
  if (u && shear) PetscCall(VecAXPY(shear, -t * c->rate, c->along));
  return PETSC_SUCCESS;
}

/* The rate is part of the problem: a run with another one is another run. */
static PetscErrorCode Visit_Strain(SlipElastic el, SlipState s)
{
  PetscReal then;
  Strain *c;

  PetscCall(SlipElasticGetData(el, &c));
  then = c->rate;
  PetscCall(SlipStateReal(s, "rate", 1, &then));
  PetscCheck(then == c->rate, PETSC_COMM_SELF, PETSC_ERR_ARG_INCOMP, "the medium's rate is %g Pa/s, was %g Pa/s",
             (double)c->rate, (double)then);
  return PETSC_SUCCESS;
}

static PetscErrorCode Destroy_Strain(SlipElastic el)
{
  Strain *c;

  PetscCall(SlipElasticGetData(el, &c));
  PetscCall(VecDestroy(&c->along));
  return PetscFree(c);
}

static PetscErrorCode Create_Strain(SlipElastic el)
{
  const SlipElasticOps ops = {.setup = SetUp_Strain,
                              .force = Force_Strain,
                              .visit = Visit_Strain,
                              .destroy = Destroy_Strain,
                              .loads = PETSC_TRUE};
  Strain *c;

  PetscCall(PetscNew(&c));
  c->rate = Rate;
  return SlipElasticSetOps(el, &ops, c);
}

/* A fault of two components or one, under the rate by the medium or by its option; two sizes of cells' sides */
static SlipFault Make(PetscBool medium, PetscInt components, PetscReal rate)
{
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(SlipFaultSetString(fault, "stiffness_scaling", "none"));
  ok(FaultSetReals(fault, {"nx", 5}, {"nz", 4}, {"slip_components", components}, {"rake", 30}, {"dip", 60}));
  if (medium) {
    Rate = rate;
    ok(SlipFaultSetString(fault, "medium", "strain"));
  } else
    ok(SlipFaultSetReal(fault, "stressing_rate", rate));
  return fault;
}

static Vec Run(SlipFault fault, TSAdaptType type, PetscReal dt, PetscReal end, PetscInt *steps)
{
  TS ts;
  Vec w;

  ok(FaultStart(fault, type, dt, end, &w, &ts));
  ok(TSSolve(ts, w));
  ok(TSGetStepNumber(ts, steps));
  ok(TSDestroy(&ts));
  return w;
}

/* To rounding, which an event multiplies by its growth, some 1e3: under constant steps and under those that the fault
   chooses by default, as a medium that loads is a load to it. */
static void strain_is_stressing(void **state)
{
  ok(SlipElasticRegister("strain", Create_Strain));
  for (PetscInt components = 1; components < 3; components++)
    for (int constant = 0; constant < 2; constant++) {
      Vec w[2];
      PetscReal norm;
      PetscInt steps[2];

      for (int medium = 0; medium < 2; medium++) {
        SlipFault fault = Make((PetscBool)medium, components, 1e4);

        w[medium] = Run(fault, constant ? TSADAPTNONE : NULL, constant ? 0.05 : 0, 5, &steps[medium]);
        ok(SlipFaultDestroy(&fault));
      }
      assert_int_equal(steps[0], steps[1]);
      ok(VecNorm(w[0], NORM_INFINITY, &norm));
      assert_true(norm > 1e-3);
      AssertVecNear(w[1], w[0], NORM_INFINITY, 1e-12 * norm);
      ObjectsDestroy(&w[0], &w[1]);
    }
}

/* What a medium without memory keeps in a checkpoint is looked at where a run goes on. */
static void another_rate(void **state)
{
  for (int k = 0; k < 3; k++) {
    SlipFault fault = Make(PETSC_TRUE, 1, k == 2 ? 2e4 : 1e4);
    PetscReal omega;
    int stopped;
    TS ts;
    Vec w;

    ok(SlipFaultSetString(fault, k ? "restart" : "checkpoint", "strain.state"));
    ok(FaultStart(fault, NULL, 0, k ? 5 : 2, &w, &ts));
    ok(TSSetSolution(ts, w));
    if (k == 0) fault->medium->frequency = 1.25;
    if (k == 2)
      fails(SlipFaultCheckpointStart(fault, ts), "the medium's rate is 20000. Pa/s, was 10000. Pa/s");
    else {
      ok(SlipFaultCheckpointStart(fault, ts));
      ok(SlipElasticGetFrequency(fault->medium, &omega));
      AssertNear(omega, 1.25, 0); /* what was found is kept, not found again */
      ok(TSSolve(ts, w));
      ok(SlipFaultCheckpointFinish(fault, ts, &stopped));
    }
    ObjectsDestroy(&ts, &w, &fault);
  }
  (void)remove("strain.state");
}

static PetscInt Multiplied; /* products with the stiffness below */

static PetscErrorCode CountedMult(Mat K, Vec x, Vec y)
{
  Multiplied++;
  return VecAXPBY(y, 2, 0, x);
}

static PetscErrorCode Force_Alone(SlipElastic el, PetscReal t, Vec u, Vec v, Vec shear, Vec normal)
{
  return VecAXPBY(shear, 2, 0, u ? u : v);
}

static PetscErrorCode Create_Alone(SlipElastic el)
{
  return SlipElasticSetOps(el, &(SlipElasticOps){.force = Force_Alone}, NULL);
}

/* Products with a stiffness of a user's are counted as it counts itself, those of a viscosity included; a medium that
   multiplies by nothing counts by the calls of its force. */
static void products_are_counted(void **state)
{
  static const char *const viscosity[] = {"radiation", "lanczos"};
  Mat K, B;
  Vec x, y;

  ok(SlipElasticInitializePackage());
  ok(SlipElasticRegister("alone", Create_Alone));
  for (int k = 0; k < 3; k++) {
    SlipProducts before, now;
    SlipElasticRock rock = {.mass = 1,
                            .inertia = PETSC_TRUE,
                            .viscosity = viscosity[k == 1],
                            .zeta = 0.3,
                            .impedance = 1,
                            .tolerance = 1e-8,
                            .components = 1};
    SlipElastic el;

    ok(MatCreateShell(PETSC_COMM_SELF, 6, 6, 6, 6, NULL, &K));
    ok(MatShellSetOperation(K, MATOP_MULT, SlipMatShellFn(CountedMult)));
    ok(MatCreateVecs(K, &x, &y));
    ok(VecSet(x, 1));
    ok(SlipElasticCreate(PETSC_COMM_SELF, &el));
    ok(SlipElasticSetType(el, k == 2 ? "alone" : SLIPELASTICSTATIC));
    ok(SlipElasticSetStiffness(el, K, NULL));
    ok(SlipElasticSetUp(el, &rock));
    Multiplied = 0;
    ok(SlipProductsGet(&before));
    ok(SlipElasticForce(el, 0, x, x, y, NULL));
    ok(SlipElasticApply(el, x, y, NULL));
    ok(SlipElasticStage(el, 1, 0.5));
    ok(SlipElasticGetStage(el, &B, NULL));
    ok(MatMult(B, x, y));
    ok(SlipProductsGet(&now));
    assert_int_equal(Multiplied + (k == 2), now.k - before.k);
    assert_int_equal(k == 1 ? 2 : 0, now.h - before.h);
    assert_int_equal(now.k - before.k, now.all - before.all);
    assert_true(k != 1 || Multiplied > 3);
    ObjectsDestroy(&el, &K, &x, &y);
  }
}

/* ---- the largest frequency ---- */

#define MASS (2500.0 * 3000.0)
static PetscInt products;

/* An affine f, which counts */
static PetscErrorCode Force_Offset(SlipElastic el, PetscReal t, Vec u, Vec v, Vec shear, Vec normal)
{
  products++;
  PetscCall(SlipElasticForceStatic(el, t, u, v, shear, normal));
  return VecShift(shear, 1e9);
}

static PetscErrorCode Create_Offset(SlipElastic el)
{
  const SlipElasticOps ops = {.force = Force_Offset};

  return SlipElasticSetOps(el, &ops, NULL);
}

/* Of the dense D^-1 K D^-1/mass, D^2 = diag(weights), column by column */
static PetscReal LargestOf(Mat K)
{
  PetscReal *A, *omega, *work, largest;
  PetscBLASInt n, info, lwork;
  PetscScalar *k;
  PetscInt N;
  Vec w, x, y;

  ok(MatGetSize(K, &N, NULL));
  ok(MatSlipGetWeights(K, &w));
  ok(MatCreateVecs(K, &x, &y));
  ok(PetscMalloc3(N * N, &A, N, &omega, 3 * N, &work));
  for (PetscInt j = 0; j < N; j++) {
    PetscReal wj = 1, wi = 1;

    ok(VecZeroEntries(x));
    ok(VecSetValue(x, j, 1, INSERT_VALUES));
    ok(VecAssemble(x));
    ok(MatMult(K, x, y));
    ok(VecGetArray(y, &k));
    if (w) ok(VecGetValues(w, 1, &j, &wj));
    for (PetscInt i = 0; i < N; i++) {
      if (w) ok(VecGetValues(w, 1, &i, &wi));
      A[j * N + i] = k[i] / (MASS * PetscSqrtReal(wi * wj));
    }
    ok(VecRestoreArray(y, &k));
  }
  n = (PetscBLASInt)N;
  lwork = 3 * n;
  LAPACKsyev_("N", "U", &n, A, &n, omega, work, &lwork, &info);
  assert_int_equal(info, 0);
  largest = PetscSqrtReal(omega[N - 1]);
  ok(PetscFree3(A, omega, work));
  ObjectsDestroy(&x, &y);
  return largest;
}

/* Never below the exact one, beyond what blocks of hierarchical storage differ by when they are transposed, and at most
   0.5 % above, as promised, with at most 25 products: grids, cells that grow with depth, triangles, vectors, one
   cell. */
static void largest_frequency(void **state)
{
  static PetscReal data[8 * 200], corners[TRIANGLE_COLUMNS * 400];
  const SlipGrid grids[] = {{20, 15, 3000, 2400, 0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)},
                            {1, 1, 100, 100, 0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)}};

  ok(SlipElasticRegister("offset", Create_Offset));
  for (int kind = 0; kind < 6; kind++) {
    SlipElasticRock rock = {
      .mass = MASS, .inertia = PETSC_TRUE, .viscosity = "none", .tolerance = 1e-8, .components = 1};
    PetscReal omega, exact;
    SlipElastic el;
    SlipCells c;
    Mat K;

    if (kind < 2)
      ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grids[kind], kind ? "dense" : "fft", &K));
    else if (kind < 4) {
      c = TwoGradedFaults(12, 8, 1, data);
      ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &c, kind == 2 ? "dense" : "hmat", 1e-6, &K));
    } else {
      c = TwoDippingPlanes(10, 6, data);
      c = TrianglesOf(&c, corners);
      if (kind == 4)
        ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &c, "hmat", 1e-6, &K));
      else {
        c.kernel.type = &SlipKernelTriangleVector;
        ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &c, "dense", 1e-6, &K, NULL));
        rock.components = 2;
      }
    }
    exact = LargestOf(K);
    for (int affine = 0; affine < 2; affine++) {
      ok(SlipElasticCreate(PETSC_COMM_SELF, &el));
      if (affine) ok(SlipElasticSetType(el, "offset"));
      ok(SlipElasticSetStiffness(el, K, NULL));
      ok(SlipElasticSetUp(el, &rock));
      products = 0;
      ok(SlipElasticGetFrequency(el, &omega));
      assert_true(omega >= exact * (1 - 1e-6) && omega <= 1.005 * exact);
      if (affine) assert_in_range(products, 2, 25);
      products = 0;
      ok(SlipElasticGetFrequency(el, &omega));
      assert_int_equal(products, 0);
      ok(SlipElasticDestroy(&el));
    }
    ok(MatDestroy(&K));
  }
}

/* A run that has found it writes it to its file, and another one has none. */
static void in_the_file(void **state)
{
  for (int found = 0; found < 2; found++) {
    SlipFault fault = Make(PETSC_FALSE, 1, 0);
    PetscReal omega, written;
    PetscBool has;
    SlipH5 h;
    TS ts;
    Vec w;

    ok(SlipFaultSetString(fault, "output", "frequency.h5"));
    ok(FaultStart(fault, TSADAPTNONE, 0.05, 0.1, &w, &ts));
    if (found) ok(SlipElasticGetFrequency(fault->medium, &omega));
    ok(SlipFaultOutputStart(fault, ts));
    ok(TSSolve(ts, w));
    ok(SlipFaultOutputFinish(fault, ts, 0, 0));
    ok(SlipH5OpenRead("frequency.h5", &h));
    ok(SlipH5HasAttribute(&h, "/result", "largest_frequency", &has));
    assert_int_equal(has, found);
    if (found) {
      ok(SlipH5ReadAttrReal(&h, "/result", "largest_frequency", &written));
      AssertNear(written, omega, 0);
    }
    ok(SlipH5Close(&h));
    ObjectsDestroy(&ts, &w, &fault);
  }
  (void)remove("frequency.h5");
}

SLIP_TESTS(strain_is_stressing, another_rate, products_are_counted, largest_frequency, in_the_file)
