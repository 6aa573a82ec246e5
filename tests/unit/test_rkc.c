/* TSRKC on right-hand sides whose steps are known exactly. */
#include "unit.h"
#include <slipstep/rooms/slipcore.h>

typedef enum { LINE, PARABOLA, DECAY, FOLLOW } Kind;

typedef struct {
  Kind kind;
  PetscReal largest, bound; /* largest |y| seen; of the domain, 0: all numbers */
  PetscInt asked;           /* for the domain */
} Problem;

static PetscErrorCode Rates(TS ts, PetscReal t, Vec y, Vec f, void *ctx)
{
  PetscScalar a, value = 0;

  PetscCall(VecGetValues(y, 1, (PetscInt[]){0}, &a));
  switch (((Problem *)ctx)->kind) {
  case LINE:
    value = 2 * t;
    break;
  case PARABOLA:
    value = 3 * t * t;
    break;
  case DECAY:
    value = -100 * a;
    break;
  case FOLLOW:
    value = -50 * (a - PetscSinReal(t)) + PetscCosReal(t);
    break;
  }
  PetscCall(VecSetValue(f, 0, value, INSERT_VALUES));
  return VecAssemble(f);
}

static Problem *domain; /* PETSc's function of it has no context */

static PetscErrorCode InDomain(TS ts, PetscReal t, Vec y, PetscBool *good)
{
  PetscScalar a;

  domain->asked++;
  PetscCall(VecGetValues(y, 1, (PetscInt[]){0}, &a));
  *good = PetscAbsReal(a) <= domain->bound ? PETSC_TRUE : PETSC_FALSE;
  return PETSC_SUCCESS;
}

static PetscErrorCode Largest(TS ts, PetscInt step, PetscReal t, Vec y, void *ctx)
{
  const PetscScalar a = VecRead(y)[0];

  ((Problem *)ctx)->largest = PetscMax(((Problem *)ctx)->largest, PetscAbsReal(a));
  return PETSC_SUCCESS;
}

/* y(0) = start, steps h chosen by the controller, the fastest rate said to be rate */
static TS Create(Problem *p, PetscReal start, PetscReal rate, PetscReal h, PetscReal end, const char adapt[], Vec *y)
{
  char option[64];
  TS ts;

  ok(VecCreateSeq(PETSC_COMM_SELF, 1, y));
  ok(VecSet(*y, start));
  ts = MakeTS(TSRKC, h, end);
  ok(TSSetRHSFunction(ts, NULL, Rates, p));
  SetAdapt(ts, adapt);
  ok(TSSetSolution(ts, *y));
  snprintf(option, sizeof(option), "-ts_rkc_rate %.17g", (double)rate);
  ok(PetscOptionsInsertString(NULL, option));
  ok(TSSetFromOptions(ts));
  ok(PetscOptionsClearValue(NULL, "-ts_rkc_rate"));
  return ts;
}

/* y' = 2 t is exact at any number of stages: each is of the time that its coefficients say. */
static void stage_times(void **state)
{
  for (PetscReal rate = 0; rate < 3e4; rate = 4 * rate + 1) {
    Problem p = {.kind = LINE};
    Vec y;
    TS ts = Create(&p, 0, rate > 0 ? rate : 1e-3, 0.25, 1, TSADAPTNONE, &y);

    ok(TSSolve(ts, y));
    AssertNear(VecRead(y)[0], 1, 1e-13);
    ObjectsDestroy(&y, &ts);
  }
}

/* Order 2 + O(h) of stages that are many, as of a stiffer problem */
static void order(void **state)
{
  PetscReal error[3];

  for (int k = 0; k < 3; k++) {
    Problem p = {.kind = FOLLOW};
    Vec y;
    TS ts = Create(&p, 0, 5000, 0.02 / (1 << k), 2, TSADAPTNONE, &y);

    ok(TSSolve(ts, y));
    error[k] = PetscAbsReal(VecRead(y)[0] - PetscSinReal(2));
    ObjectsDestroy(&y, &ts);
  }
  AssertLess(error[0], 1e-4);
  assert_true(error[0] / error[1] > 3.3 && error[1] / error[2] > 3.3);
}

/* One step h of y' = 3 t^2 from 0. The estimate is 0.8 (y0 - y1) + 0.4 h (f0 + f1) = h^3 (1.2 - 0.8 y1/h^3), 0.4 h^3 of
   an exact y1; Hermite's cubic has the rates of both ends, so that it is off by y1 - h^3 times s^2 (3 - 2 s). */
static void estimate_and_dense_output(void **state)
{
  for (int stages = 0; stages < 3; stages++) {
    const PetscReal h = 0.5, rate[] = {1, 40, 400};
    Problem p = {.kind = PARABOLA};
    PetscReal wlte, y1, t;
    Vec y, z;
    TS ts = Create(&p, 0, rate[stages], h, 10, TSADAPTNONE, &y);

    ok(TSSetTolerances(ts, 1, NULL, 0, NULL));
    ok(VecDuplicate(y, &z));
    ok(TSStep(ts));
    ok(TSGetTime(ts, &t));
    assert_true(t == h);
    y1 = VecRead(y)[0];
    for (PetscReal s = 0; s <= 1; s += 0.125) {
      ok(TSInterpolate(ts, s * h, z));
      AssertNear(VecRead(z)[0], s * s * s * h * h * h + (y1 - h * h * h) * s * s * (3 - 2 * s), 1e-15);
    }
    ObjectsDestroy(&z, &y, &ts);

    p = (Problem){.kind = PARABOLA}; /* once more, to be asked while the attempt is judged */
    ts = Create(&p, 0, rate[stages], h, 10, TSADAPTBASIC, &y);
    ok(TSSetTolerances(ts, 1, NULL, 0, NULL)); /* no step is refused */
    ok(TSStep(ts));
    ok(TSGetTimeStep(ts, &t));
    wlte = PetscAbsReal(1.2 * h * h * h - 0.8 * y1);
    AssertNear(t, PetscMin(10 * h, 0.9 * h * PetscPowReal(wlte, (PetscReal)-1 / 3)), 1e-12); /* basic's rule */
    ObjectsDestroy(&y, &ts);
  }
}

/* Steps that are unstable as the rate is understated leave the domain; nothing else refuses them. */
static void leaves_the_domain(void **state)
{
  Problem p = {.kind = DECAY, .bound = 2};
  PetscInt rejected;
  Vec y;
  TS ts = Create(&p, 1, 0.1, 0.5, 3, TSADAPTBASIC, &y);

  domain = &p;
  ok(TSSetFunctionDomainError(ts, InDomain));
  ok(TSSetMaxStepRejections(ts, -1));
  ok(TSSetTolerances(ts, 1e30, NULL, 0, NULL));
  ok(TSMonitorSet(ts, Largest, &p, NULL));
  ok(TSSolve(ts, y));
  ok(TSGetStepRejections(ts, &rejected));
  assert_true(rejected > 0 && p.asked > rejected);
  assert_true(p.largest <= p.bound);
  ObjectsDestroy(&y, &ts);
}

/* The longest step of so many stages, with the margin of the rate */
static void longest_step(void **state)
{
  for (PetscInt stages = 2; stages <= 20; stages += 6) {
    Problem p = {.kind = LINE};
    PetscReal t;
    Vec y;
    TS ts = Create(&p, 0, 10, 100, 1000, TSADAPTNONE, &y);

    ok(TSRKCSetMaxStages(ts, stages));
    ok(TSStep(ts));
    ok(TSGetTime(ts, &t));
    AssertNear(t, SlipRKCLongest(stages) / (1.05 * 10), 1e-12 * t);
    AssertNear(SlipRKCLongest(stages), 0.65 * (PetscReal)(stages * stages - 1), 0.05 * SlipRKCLongest(stages));
    ObjectsDestroy(&y, &ts);
  }
}

SLIP_TESTS(stage_times, order, estimate_and_dense_output, leaves_the_domain, longest_step)
