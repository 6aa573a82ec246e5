/* The circuit's exact solution against the integrator, and what policies observe of the events of both small systems.
   */
#include "models.h"
#include <math.h>

typedef struct {
  const SlipCircuit *c;
  PetscReal dt, w[CIRCUIT_N], largest, jump; /* jump: of the rate of V1 at an event [V/s] */
  PetscInt rests;
  int sign;
} Against;

/* TSMonitor: the exact solution goes along, step by step */
static PetscErrorCode Compare(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  Against *a = (Against *)ctx;
  const PetscScalar *b;

  if (step < 0) return PETSC_SUCCESS;
  if (step > 0) SlipCircuitAdvance(a->c, a->dt, &a->sign, a->w);
  b = VecRead(w);
  for (int k = 0; k < CIRCUIT_N; k++) a->largest = PetscMax(a->largest, fabs(b[k] - a->w[k]));
  a->rests += a->w[0] == 0 && b[0] == 0;
  return PETSC_SUCCESS;
}

/* n constant steps: the largest difference at any of them. m < 0: the study's diode */
static void Run(PetscReal m, PetscReal duration, PetscInt n, Against *a)
{
  SlipModel model;
  SlipCircuit *c;
  TS ts;
  Vec w;

  ok(SlipModelCreate(&SlipCircuitOps, SLIP_MODEL_EVALUATION, &model));
  c = (SlipCircuit *)model;
  if (m >= 0) c->m = m;
  model->max_time = duration;
  ok(SlipModelSetUp(model));
  *a = (Against){.c = c, .dt = duration / (PetscReal)n, .sign = model->start[0] > 0 ? 1 : -1};
  for (int k = 0; k < CIRCUIT_N; k++) a->w[k] = model->start[k];
  ok(SlipModelCreateState(model, &w));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(SlipModelConfigureTS(model, ts));
  SetAdapt(ts, TSADAPTNONE);
  ok(TSSetTimeStep(ts, a->dt));
  ok(TSMonitorSet(ts, Compare, a, NULL));
  ok(TSSolve(ts, w));
  a->jump = 2 * c->m / c->C1;
  ObjectsDestroy(&ts, &w);
  ok(SlipModelDestroy(&model));
}

/* Without a diode the difference is the integrator's error, of second order. */
static void test_flow(void **state)
{
  Against a, b;

  Run(0, 4, 1000, &a);
  Run(0, 4, 2000, &b);
  assert_true(a.rests == 0);
  AssertNear(log2(a.largest / b.largest), 2, 0.05);
}

/* In a step across an event the rate of V1 is wrong by no more than the diode's jump, 2 m/C1. The system is
   dissipative, so what a step leaves does not grow, and the few events of the first kind (V1 through zero without a
   stop) add up at worst. */
static void test_events(void **state)
{
  Against a;

  Run(-1, 20, 40000, &a);
  AssertLess(20000, a.rests); /* V1 has come to rest for good after 7 s, and stops before */
  AssertLess(a.largest, a.jump * a.dt);
  AssertLess(0, a.largest);
}

/* The exact solution's rate says when V1 gets to zero. */
static void test_circuit_event(void **state)
{
  const PetscReal t = 1e-6, rest[] = {0, 0.1, 1}, away[] = {1, 9, 1};
  PetscReal to[CIRCUIT_N], left, *start;
  SlipModel model;
  SlipCircuit *c;

  ok(SlipModelCreate(&SlipCircuitOps, SLIP_MODEL_EVALUATION, &model));
  c = (SlipCircuit *)model;
  start = model->start;
  SlipCircuitFlow(c, 1, t, start, to);
  left = start[0] * t / (start[0] - to[0]) / sqrt(c->L * c->C2);
  assert_true(fabs(ObserveModel(model, start, "log_event") - log10(left)) < 1e-4); /* the rate changes by 6e-6 in t */
  assert_true(ObserveModel(model, rest, "log_event") == 1);
  assert_true(ObserveModel(model, away, "log_event") == 1);
  left = sqrt(2 * SlipModelEnergy(model, start) / c->C1) / (c->m * c->R);
  assert_true(fabs(ObserveModel(model, start, "log_level") - log10(left)) < 1e-14);
  c->m = 0;
  assert_true(ObserveModel(model, start, "log_level") == 3);
  ok(SlipModelDestroy(&model));
}

/* TSMonitor: what is observed is of the time of the state */
static PetscErrorCode WatchLoad(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  const SlipSlidingMode *m = (const SlipSlidingMode *)ctx;
  const SlipProblemOps *problem;
  void *model;
  PetscReal value;
  PetscInt row;

  if (step < 0) return PETSC_SUCCESS;
  ok(TSGetSlipProblem(ts, &problem, &model));
  ok((*problem->observations.find)(ts, "load", &row, model));
  assert_true(row >= 0);
  ok((*problem->observations.observe)(ts, time, 1, &row, &value, model));
  assert_true(fabs(value - fabs(m->D * sin(m->omega * time)) / m->k) < 1e-12);
  return PETSC_SUCCESS;
}

static void test_sliding_mode_event(void **state)
{
  PetscReal r, at = 0.2, departs;
  SlipSlidingMode *m;
  SlipModel model;
  TS ts;
  Vec w;

  ok(SlipModelCreate(&SlipSlidingModeOps, SLIP_MODEL_TRAINING, &model));
  m = (SlipSlidingMode *)model;
  m->D = 2.5;
  ok(SlipModelSetUp(model));
  /* while it moves, by the rate at the start, where the disturbance is zero */
  assert_true(fabs(SlipSlidingModeEvent(m, 0, 0.1) - 0.1 / m->k) < 1e-15);
  /* at rest, when the exact solution leaves zero. The next rest is looked for first. */
  while ((*model->ops->exact)(model, at, &r) != 0) at += 1e-4;
  departs = at;
  while ((*model->ops->exact)(model, departs, &r) == 0) departs += 1e-6;
  assert_true(fabs(at + SlipSlidingModeEvent(m, at, 0) - departs) < 2e-6);
  m->D = 1.9;
  assert_true(SlipSlidingModeEvent(m, at, 0) == PETSC_MAX_REAL);

  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(SlipModelConfigureTS(model, ts));
  ok(SlipModelCreateState(model, &w));
  ok(TSMonitorSet(ts, WatchLoad, m, NULL));
  ok(TSSolve(ts, w));
  ObjectsDestroy(&ts, &w);
  ok(SlipModelDestroy(&model));
}

SLIP_TESTS(test_flow, test_events, test_circuit_event, test_sliding_mode_event)
