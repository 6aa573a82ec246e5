/* A medium of a user's: the rock is strained uniformly, so that the stress along rakes grows at a rate by itself. It is
   -fault_stressing_rate by another way, and must equal it. */
#include "faultstart.h"
#include "unit.h"
#include <slipelastic.h>
#include <slipstep/private/slipstate.h>

static PetscReal Rate; /* of the next medium [Pa/s] */

typedef struct {
  PetscReal rate;
  Vec along; /* of rate 1 */
} Strain;

static PetscErrorCode SetUp_Strain(SlipElastic el, const SlipElasticRock *rock)
{
  Strain *c;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &c));
  PetscCall(VecDuplicate(rock->along, &c->along));
  PetscCall(VecCopy(rock->along, c->along));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Force_Strain(SlipElastic el, PetscReal t, Vec u, Vec v, Vec shear, Vec normal)
{
  Strain *c;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &c));
  PetscCall(SlipElasticForceStatic(el, t, u, v, shear, normal));
  if (u && shear) PetscCall(VecAXPY(shear, -t * c->rate, c->along));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The rate is part of the problem: a run with another one is another run. */
static PetscErrorCode Visit_Strain(SlipElastic el, SlipState s)
{
  PetscReal then;
  Strain *c;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &c));
  then = c->rate;
  PetscCall(SlipStateReal(s, "rate", 1, &then));
  PetscCheck(then == c->rate, PETSC_COMM_SELF, PETSC_ERR_ARG_INCOMP, "the medium's rate is %g Pa/s, was %g Pa/s",
             (double)c->rate, (double)then);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy_Strain(SlipElastic el)
{
  Strain *c;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &c));
  PetscCall(VecDestroy(&c->along));
  PetscCall(PetscFree(c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Create_Strain(SlipElastic el)
{
  const SlipElasticOps ops = {.setup = SetUp_Strain,
                              .force = Force_Strain,
                              .visit = Visit_Strain,
                              .destroy = Destroy_Strain,
                              .loads = PETSC_TRUE};
  Strain *c;

  PetscFunctionBegin;
  PetscCall(PetscNew(&c));
  c->rate = Rate;
  PetscCall(SlipElasticSetOps(el, &ops, c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A fault of two components or one, under the rate by the medium or by its option; two sizes of cells' sides */
static SlipFault Make(PetscBool medium, PetscInt components, PetscReal rate)
{
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetReals(fault, {"nx", 5}, {"nz", 4}, {"slip_components", components}, {"rake", 30}, {"dip", 60}));
  ok(SlipFaultSetString(fault, "stiffness_scaling", "none"));
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
  (void)state;
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
      ok(VecDestroy(&w[0]));
      ok(VecDestroy(&w[1]));
    }
}

/* What a medium without memory keeps in a checkpoint is looked at where a run goes on. */
static void another_rate(void **state)
{
  (void)state;
  for (int k = 0; k < 3; k++) {
    SlipFault fault = Make(PETSC_TRUE, 1, k == 2 ? 2e4 : 1e4);
    int stopped;
    TS ts;
    Vec w;

    ok(SlipFaultSetString(fault, k ? "restart" : "checkpoint", "strain.state"));
    ok(FaultStart(fault, NULL, 0, k ? 5 : 2, &w, &ts));
    ok(TSSetSolution(ts, w));
    if (k == 2)
      fails(SlipFaultCheckpointStart(fault, ts), "the medium's rate is 20000. Pa/s, was 10000. Pa/s");
    else {
      ok(SlipFaultCheckpointStart(fault, ts));
      ok(TSSolve(ts, w));
      ok(SlipFaultCheckpointFinish(fault, ts, &stopped));
    }
    ok(TSDestroy(&ts));
    ok(VecDestroy(&w));
    ok(SlipFaultDestroy(&fault));
  }
  (void)remove("strain.state");
}

static PetscInt Multiplied; /* products with the stiffness below */

static PetscErrorCode CountedMult(Mat K, Vec x, Vec y)
{
  PetscFunctionBegin;
  (void)K;
  Multiplied++;
  PetscCall(VecAXPBY(y, 2, 0, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Force_Alone(SlipElastic el, PetscReal t, Vec u, Vec v, Vec shear, Vec normal)
{
  PetscFunctionBegin;
  (void)el, (void)t, (void)normal;
  PetscCall(VecAXPBY(shear, 2, 0, u ? u : v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Create_Alone(SlipElastic el)
{
  PetscFunctionBegin;
  PetscCall(SlipElasticSetOps(el, &(SlipElasticOps){.force = Force_Alone}, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Products with a stiffness of a user's are counted as it counts itself, those of a viscosity included; a medium that
   multiplies by nothing counts by the calls of its force. */
static void products_are_counted(void **state)
{
  static const char *const viscosity[] = {"radiation", "lanczos"};
  Mat K, B;
  Vec x, y;

  (void)state;
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
    ok(SlipElasticDestroy(&el));
    ok(MatDestroy(&K));
    ok(VecDestroy(&x));
    ok(VecDestroy(&y));
  }
}

SLIP_TESTS(strain_is_stressing, another_rate, products_are_counted)
