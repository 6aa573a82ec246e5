/* The example cases built on small constraints, sliding mode and circuit, against exact solutions. */
#include "smallsteps.h"
#include <math.h>

/* ---- the sliding mode controller ---- */

static SlipSlidingMode *SlidingMode(SlipModelCase setting)
{
  SlipModel model;

  ok(SlipModelCreate(&SlipSlidingModeOps, setting, &model));
  return (SlipSlidingMode *)model;
}

static PetscReal Exact(SlipSlidingMode *m, PetscReal t, PetscReal *r)
{
  return (*m->model.ops->exact)(&m->model, t, r);
}

static void DestroyModel(struct _p_SlipModel *model)
{
  ok(SlipModelDestroy(&model));
}

/* Closed form while it slides; then zero with the reaction that holds the disturbance. Gain above the disturbance. */
static void test_exact_arrest(void **state)
{
  for (int i = 0; i < 2; i++) {
    SlipSlidingMode *m = SlidingMode((SlipModelCase)i);
    PetscReal r, t = 0.04, w = m->model.start[0] + m->D / m->omega * (1 - cos(m->omega * t)) - m->k * t;

    assert_true(w > 0);
    assert_true(fabs(Exact(m, t, &r) - w) < 1e-15);
    assert_true(r == -m->k);
    assert_true(Exact(m, 0.4, &r) == 0);
    assert_true(fabs(r + m->D * sin(m->omega * 0.4)) < 1e-15);
    DestroyModel(&m->model);
  }
}

typedef struct {
  SlipSlidingMode *m;
  PetscReal largest;
  PetscInt stuck, up, down;
} Against;

static PetscErrorCode Compare(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  Against *a = (Against *)ctx;
  PetscReal value, exact, r;

  if (step < 0) return PETSC_SUCCESS;
  Get(w, 1, &value);
  exact = Exact(a->m, time, &r);
  a->largest = PetscMax(a->largest, fabs(value - exact));
  a->stuck += exact == 0 && value == 0;
  a->up += exact > 0;
  a->down += exact < 0;
  return PETSC_SUCCESS;
}

/* Gain below the disturbance: w sticks, departs to both sides and comes back to rest, which wipes every error out. So
   the error is that of one excursion at most: its departure and its arrest fall within a step, where the rate is wrong
   by less than k + D. 2 (k + D) h = 9e-5 for h = 1e-5 s bounds both. */
static void test_exact_departures(void **state)
{
  SlipSlidingMode *m = SlidingMode(SLIP_MODEL_TRAINING);
  Against a = {.m = m};
  TS ts;
  Vec w;

  m->D = 2.5;
  m->model.start[0] = -0.01;
  ok(SlipModelSetUp(&m->model));
  ok(SlipModelCreateState(&m->model, &w));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(SlipModelConfigureTS(&m->model, ts));
  ok(TSMonitorSet(ts, Compare, &a, NULL));
  Steps(ts, w, 0.5, 50000);
  assert_true(a.stuck > 5000 && a.up > 5000 && a.down > 5000);
  AssertLess(a.largest, 9e-5);
  ObjectsDestroy(&ts, &w);
  DestroyModel(&m->model);
}

/* Constant steps of the study's evaluation: second order before the arrest, and an error at the arrest of at most one
   step's travel, (k + D) h, that is gone when w has come to rest: the final w and reaction are exact. */
static void test_sliding_mode_order(void **state)
{
  SlipSlidingMode *m = SlidingMode(SLIP_MODEL_EVALUATION);
  Against a = {.m = m};
  PetscReal r, end, before[2];

  for (int i = 0; i < 3; i++) {
    const PetscReal tmax = i < 2 ? 0.06 : 0.5, h = i < 2 ? 0.06 / (60 << i) : 1e-3;
    TS ts;
    Vec w = State(1, m->model.start), reaction;

    a.largest = 0;
    ok(TSCreate(PETSC_COMM_SELF, &ts));
    ok(SlipModelConfigureTS(&m->model, ts));
    ok(TSMonitorSet(ts, Compare, &a, NULL));
    Steps(ts, w, tmax, (PetscInt)(tmax / h + 0.5));
    Get(w, 1, &end);
    ok(TSBatheGetReaction(ts, &reaction));
    Get(reaction, 1, &r);
    if (i < 2) before[i] = a.largest;
    ObjectsDestroy(&ts, &w);
  }
  AssertNear(log2(before[0] / before[1]), 2, 0.05);
  AssertLess(a.largest, (m->k + m->D) * 1e-3);
  assert_true(end == 0);
  AssertLess(fabs(r + m->D * sin(m->omega * 0.5)), 1e-12);
  DestroyModel(&m->model);
}

/* The default observations of a policy, in the units of the start */
static void test_sliding_mode_observe(void **state)
{
  SlipSlidingMode *m = SlidingMode(SLIP_MODEL_EVALUATION);
  const PetscReal w = -0.5 * m->model.start[0];

  assert_true(fabs(ObserveModel(&m->model, &w, "energy") - 0.25) < 1e-15);
  assert_true(fabs(ObserveModel(&m->model, &w, "state_0") + 0.5) < 1e-15);
  assert_int_equal(-1, (int)SlipModelFindObservation(&m->model, "state_1"));
  DestroyModel(&m->model);
}

/* ---- the circuit ---- */

/* Of the energy's units the squares of the states add up to U/U_0; in the start's every state begins at 1 */
static void test_circuit_observe(void **state)
{
  const char *const names[] = {"state_0", "state_1", "state_2", "energy"};
  PetscReal sum = 0;
  SlipModel model;

  ok(SlipModelCreate(&SlipCircuitOps, SLIP_MODEL_EVALUATION, &model));
  for (int i = 0; i < 3; i++) {
    const PetscReal value = ObserveModel(model, model->start, names[i]);

    sum += PetscSqr(value);
  }
  assert_true(fabs(sum - 1) < 1e-14);
  ((SlipCircuit *)model)->unit_start = PETSC_TRUE;
  ok(SlipModelSetUp(model));
  for (int i = 0; i < 4; i++) assert_true(fabs(ObserveModel(model, model->start, names[i]) - 1) < 1e-15);
  assert_int_equal(-1, (int)SlipModelFindObservation(model, "velocity"));
  ok(SlipModelDestroy(&model));
}

SLIP_TESTS(test_exact_arrest, test_exact_departures, test_sliding_mode_order, test_sliding_mode_observe,
           test_circuit_observe)
