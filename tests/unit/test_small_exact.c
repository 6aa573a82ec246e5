/* The circuit's exact solution against the integrator, and what policies observe of the events of both small systems.
   */
#include "unit.h"
#include <math.h>
#include "../../examples/circuit.h"
#include "../../examples/sliding_mode.h"

typedef struct {
  const Circuit *c;
  PetscReal dt, w[CIRCUIT_N], largest;
  PetscInt rests;
  int sign;
} Against;

/* TSMonitor: the exact solution goes along, step by step */
static PetscErrorCode Compare(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  Against *a = (Against *)ctx;
  const PetscScalar *b;

  PetscFunctionBeginUser;
  (void)ts;
  (void)time;
  if (step < 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (step > 0) CircuitAdvance(a->c, a->dt, &a->sign, a->w);
  ok(VecGetArrayRead(w, &b));
  for (int k = 0; k < CIRCUIT_N; k++) a->largest = PetscMax(a->largest, fabs(b[k] - a->w[k]));
  a->rests += a->w[0] == 0 && b[0] == 0;
  ok(VecRestoreArrayRead(w, &b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* n constant steps: the largest difference at any of them */
static void Run(PetscReal m, PetscReal duration, PetscInt n, Against *a)
{
  Circuit c = CircuitCases[1];
  TSAdapt adapt;
  TS ts;
  Vec w;

  c.m = m;
  c.max_time = duration;
  ok(CircuitSetUnits(&c, PETSC_FALSE));
  *a = (Against){.c = &c, .dt = duration / (PetscReal)n, .sign = c.start[0] > 0 ? 1 : -1};
  for (int k = 0; k < CIRCUIT_N; k++) a->w[k] = c.start[k];
  ok(CircuitCreateState(&c, &w));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(CircuitConfigureTS(&c, ts));
  ok(TSGetAdapt(ts, &adapt));
  ok(TSAdaptSetType(adapt, TSADAPTNONE));
  ok(TSSetTimeStep(ts, a->dt));
  ok(TSMonitorSet(ts, Compare, a, NULL));
  ok(TSSolve(ts, w));
  ok(TSDestroy(&ts));
  ok(VecDestroy(&w));
}

/* Without a diode the difference is the integrator's error, of second order. */
static void test_flow(void **state)
{
  Against a, b;

  (void)state;
  Run(0, 4, 1000, &a);
  Run(0, 4, 2000, &b);
  print_message("without a diode %g and %g, order %.3f\n", a.largest, b.largest, log2(a.largest / b.largest));
  assert_true(a.rests == 0);
  assert_true(fabs(log2(a.largest / b.largest) - 2) < 0.05);
}

/* In a step across an event the rate of V1 is wrong by no more than the diode's jump, 2 m/C1. The system is
   dissipative, so what a step leaves does not grow, and the few events of the first kind (V1 through zero without a
   stop) add up at worst. */
static void test_events(void **state)
{
  const Circuit *c = &CircuitCases[1];
  Against a;

  (void)state;
  Run(c->m, 20, 40000, &a);
  print_message("with the diode %g, at rest at %d of 40000 steps\n", a.largest, (int)a.rests);
  assert_true(a.rests > 20000); /* V1 has come to rest for good after 7 s, and stops before */
  assert_true(a.largest < 2 * c->m / c->C1 * a.dt);
  assert_true(a.largest > 0);
}

static PetscReal ObserveCircuit(Circuit *c, const PetscReal at[], const char name[])
{
  PetscReal value = NAN;
  PetscBool known = PETSC_FALSE;
  PetscScalar *b;
  TS ts;
  Vec w;

  ok(CircuitSetUnits(c, PETSC_FALSE));
  ok(CircuitCreateState(c, &w));
  ok(VecGetArray(w, &b));
  for (int k = 0; k < CIRCUIT_N; k++) b[k] = at[k];
  ok(VecRestoreArray(w, &b));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(CircuitConfigureTS(c, ts));
  ok(TSSetSolution(ts, w));
  ok(CircuitObserve(ts, name, &value, &known));
  assert_true(known);
  ok(TSDestroy(&ts));
  ok(VecDestroy(&w));
  return value;
}

/* The exact solution's rate says when V1 gets to zero. */
static void test_circuit_event(void **state)
{
  Circuit c = CircuitCases[1];
  const PetscReal t = 1e-6, rest[] = {0, 0.1, 1}, away[] = {1, 9, 1};
  PetscReal to[CIRCUIT_N], left;

  (void)state;
  CircuitFlow(&c, 1, t, c.start, to);
  left = c.start[0] * t / (c.start[0] - to[0]) / sqrt(c.L * c.C2);
  assert_true(fabs(ObserveCircuit(&c, c.start, "log_event") - log10(left)) < 1e-4); /* the rate changes by 6e-6 in t */
  assert_true(ObserveCircuit(&c, rest, "log_event") == 1);
  assert_true(ObserveCircuit(&c, away, "log_event") == 1);
  left = sqrt(2 * CircuitEnergy(&c, c.start) / c.C1) / (c.m * c.R);
  assert_true(fabs(ObserveCircuit(&c, c.start, "log_level") - log10(left)) < 1e-14);
  c.m = 0;
  assert_true(ObserveCircuit(&c, c.start, "log_level") == 3);
}

/* TSMonitor: what is observed is of the time of the state */
static PetscErrorCode WatchLoad(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  const SlidingMode *m = (const SlidingMode *)ctx;
  PetscReal value = 0;
  PetscBool known;

  PetscFunctionBeginUser;
  (void)w;
  if (step < 0) PetscFunctionReturn(PETSC_SUCCESS);
  ok(SlidingModeObserve(ts, "load", &value, &known));
  assert_true(known && fabs(value - fabs(m->D * sin(m->omega * time)) / m->k) < 1e-12);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void test_sliding_mode_event(void **state)
{
  SlidingMode m = {.k = 2.0, .D = 2.5, .omega = 50, .start = 0.1};
  PetscReal r, at = 0.2, departs;
  TS ts;
  Vec w;

  (void)state;
  /* while it moves, by the rate at the start, where the disturbance is zero */
  assert_true(fabs(SlidingModeEvent(&m, 0, 0.1) - 0.1 / m.k) < 1e-15);
  /* at rest, when the exact solution leaves zero. The next rest is looked for first. */
  while (SlidingModeExact(&m, at, &r) != 0) at += 1e-4;
  departs = at;
  while (SlidingModeExact(&m, departs, &r) == 0) departs += 1e-6;
  assert_true(fabs(at + SlidingModeEvent(&m, at, 0) - departs) < 2e-6);
  m.D = 1.9;
  assert_true(SlidingModeEvent(&m, at, 0) == PETSC_MAX_REAL);

  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(SlidingModeConfigureTS(&m, ts));
  ok(VecCreateSeq(PETSC_COMM_SELF, 1, &w));
  ok(VecSet(w, m.start));
  ok(TSMonitorSet(ts, WatchLoad, &m, NULL));
  ok(TSSolve(ts, w));
  ok(TSDestroy(&ts));
  ok(VecDestroy(&w));
}

int main(int argc, char **argv)
{
  static const struct CMUnitTest tests[] = {cmocka_unit_test(test_flow), cmocka_unit_test(test_events),
                                            cmocka_unit_test(test_circuit_event),
                                            cmocka_unit_test(test_sliding_mode_event)};

  return RunTests(argc, argv, tests, NULL, NULL);
}
