/* TSBATHE without a constraint: a good PETSc citizen. */
#include "unit.h"
#include <slipstep/private/slipbathe.h>

/* y0' = -2 t y0^2, y1' = cos t + (y1 - sin t) y0: nonlinear, non-autonomous, y = (1/(1+t^2), sin t) */
static void Exact(PetscReal t, PetscReal y[2])
{
  y[0] = 1.0 / (1.0 + t * t);
  y[1] = PetscSinReal(t);
}

static PetscErrorCode RHS(TS ts, PetscReal t, Vec y, Vec f, void *ctx)
{
  const PetscScalar *a = VecRead(y);
  PetscScalar *b;

  PetscCall(VecGetArray(f, &b));
  b[0] = -2.0 * t * a[0] * a[0];
  b[1] = PetscCosReal(t) + (a[1] - PetscSinReal(t)) * a[0];
  return VecRestoreArray(f, &b);
}

static PetscErrorCode RHSJacobian(TS ts, PetscReal t, Vec y, Mat J, Mat P, void *ctx)
{
  const PetscScalar *a = VecRead(y);
  PetscScalar v[4];

  v[0] = -4.0 * t * a[0];
  v[1] = 0.0;
  v[2] = a[1] - PetscSinReal(t);
  v[3] = a[0];
  PetscCall(MatSetValues(P, 2, (PetscInt[]){0, 1}, 2, (PetscInt[]){0, 1}, v, INSERT_VALUES));
  return MatAssemble(P);
}

/* The same with a mass matrix: diag(2, 3) (y' - f) = 0 */
static PetscErrorCode IFunction(TS ts, PetscReal t, Vec y, Vec ydot, Vec F, void *ctx)
{
  PetscCall(RHS(ts, t, y, F, ctx));
  PetscCall(VecAYPX(F, -1.0, ydot));
  PetscCall(VecSetValues(F, 0, NULL, NULL, INSERT_VALUES));
  {
    PetscScalar *f;

    PetscCall(VecGetArray(F, &f));
    f[0] *= 2.0;
    f[1] *= 3.0;
    PetscCall(VecRestoreArray(F, &f));
  }
  return PETSC_SUCCESS;
}

static PetscErrorCode IJacobian(TS ts, PetscReal t, Vec y, Vec ydot, PetscReal a, Mat J, Mat P, void *ctx)
{
  PetscCall(RHSJacobian(ts, t, y, J, P, ctx));
  PetscCall(MatScale(P, -1.0));
  PetscCall(MatShift(P, a));
  PetscCall(MatDiagonalScale(P, NULL, NULL));
  {
    PetscScalar v[4];

    PetscCall(MatGetValues(P, 2, (PetscInt[]){0, 1}, 2, (PetscInt[]){0, 1}, v));
    v[0] *= 2.0;
    v[1] *= 2.0;
    v[2] *= 3.0;
    v[3] *= 3.0;
    PetscCall(MatSetValues(P, 2, (PetscInt[]){0, 1}, 2, (PetscInt[]){0, 1}, v, INSERT_VALUES));
    PetscCall(MatAssemble(P));
  }
  return PETSC_SUCCESS;
}

/* A TS for the problem above with constant steps, ready to solve */
static TS Create(PetscBool implicit, PetscReal gamma, PetscReal h, PetscReal tmax, Vec *y)
{
  TS ts;
  Mat J;
  SNES snes;
  PetscReal y0[2];

  Exact(0.5, y0);
  ok(VecCreateSeq(PETSC_COMM_SELF, 2, y));
  ok(VecSetValues(*y, 2, (PetscInt[]){0, 1}, y0, INSERT_VALUES));
  ok(VecAssemble(*y));
  ok(MatCreateSeqDense(PETSC_COMM_SELF, 2, 2, NULL, &J));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(TSSetType(ts, TSBATHE));
  ok(TSBatheSetGamma(ts, gamma));
  if (implicit) {
    ok(TSBatheSetFirstStage(ts, TSBATHE_STAGE_TRAPEZOIDAL)); /* right for this one, A w' + f(t, w) */
    ok(TSSetIFunction(ts, NULL, IFunction, NULL));
    ok(TSSetIJacobian(ts, J, J, IJacobian, NULL));
  } else {
    ok(TSSetRHSFunction(ts, NULL, RHS, NULL));
    ok(TSSetRHSJacobian(ts, J, J, RHSJacobian, NULL));
  }
  ok(MatDestroy(&J));
  ok(TSSetTime(ts, 0.5));
  ok(TSSetTimeStep(ts, h));
  ok(TSSetMaxTime(ts, tmax));
  ok(TSSetMaxSteps(ts, 100000));
  ok(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  ok(TSGetSNES(ts, &snes));
  ok(SNESSetTolerances(snes, 1e-12, 1e-11, 1e-14, 50, 1000));
  ok(TSSetSolution(ts, *y));
  ok(TSSetFromOptions(ts));
  return ts;
}

static PetscReal Distance(Vec y, PetscReal t)
{
  PetscReal e[2], d;

  Exact(t, e);
  d = PetscMax(PetscAbsReal(VecRead(y)[0] - e[0]), PetscAbsReal(VecRead(y)[1] - e[1]));
  return d;
}

/* Order between two step sizes is 2 + O(h): 0.05 is what halving leaves of the O(h) part here */
static void test_order_two(void **state)
{
  for (int form = 0; form < 2; form++)
    for (int g = 0; g < 3; g++) { /* 2: both stages backward */
      PetscReal error[2];

      for (int k = 0; k < 2; k++) {
        Vec y;
        TS ts = Create(form ? PETSC_TRUE : PETSC_FALSE, g ? 2.0 - PetscSqrtReal(2.0) : 0.5, 0.02 / (1 + k), 2.5, &y);

        if (g == 2) ok(TSBatheSetFirstStage(ts, TSBATHE_STAGE_BACKWARD));
        ok(TSSolve(ts, y));
        error[k] = Distance(y, 2.5);
        ObjectsDestroy(&y, &ts);
      }
      AssertNear(log2(error[0] / error[1]), 2.0, 0.05);
    }
}

/* Estimates of one step against h, h/2: both O(h^3), and each within 20 % of the true local error at the small step */
static void test_estimates_are_third_order(void **state)
{
  for (int kind = 0; kind < 5; kind++) { /* 4: both stages backward */
    PetscReal wlte[2], truth = 0.0;
    PetscInt order;

    for (int k = 0; k < 2; k++) {
      PetscReal h = 0.04 / (1 + k);
      Vec y;
      PetscBool implicit = kind == 3 ? PETSC_TRUE : PETSC_FALSE;
      TS ts = Create(implicit, kind == 1 ? 2.0 - PetscSqrtReal(2.0) : 0.5, h, 10.0, &y);
      TSAdapt adapt;

      if (kind == 2) {
        ok(TSBatheSetError(ts, TSBATHE_ERROR_DOUBLING));
        ok(TSBatheSetDoublingOrder(ts, 2));
      }
      ok(TSGetAdapt(ts, &adapt));
      if (kind ==
          3) { /* an implicit form starts with doubling, which adapt none would leave out: basic with huge tolerances */
        ok(TSAdaptSetType(adapt, TSADAPTBASIC));
      }
      if (kind == 4) ok(TSBatheSetFirstStage(ts, TSBATHE_STAGE_BACKWARD));
      ok(TSSetTolerances(ts, 1.0, NULL, 0.0, NULL));
      ok(TSStep(ts));
      ok(TSEvaluateWLTE(ts, NORM_INFINITY, &order, &wlte[k]));
      assert_int_equal(order, 3); /* the power of h in the estimate, whoever asks */
      truth = Distance(y, 0.5 + h);
      ObjectsDestroy(&y, &ts);
    }
    AssertNear(log2(wlte[0] / wlte[1]), 3.0, 0.1);
    if (kind < 4) AssertNear(wlte[1] / truth, 1.0, 0.2); /* else stage 1, of order one, has its share too */
  }
}

/* The norm of a step's estimate e is relative to the larger of both compared solutions, y and y - e, to the twelve bits
   to which it is rounded. */
static void test_norm_of_the_error(void **state)
{
  PetscInt larger = 0, order; /* of the component that swings, how often y - e is */
  PetscReal norm;
  Vec y, e;
  TS ts = Create(PETSC_FALSE, 0.5, 0.5, 10.5, &y);

  ok(TSSetTolerances(ts, 1e-3, NULL, 0.1, NULL));
  for (int step = 0; step < 20; step++) {
    PetscReal sum = 0;

    ok(TSStep(ts));
    ok(TSBatheGetEstimates(ts, &e, NULL, NULL));
    for (int i = 0; i < 2; i++) {
      const PetscReal to = VecRead(y)[i], error = VecRead(e)[i];

      larger += i == 1 && fabs(to - error) > fabs(to);
      sum += PetscSqr(error / (1e-3 + 0.1 * PetscMax(fabs(to), fabs(to - error)))) / 2;
    }
    ok(TSEvaluateWLTE(ts, NORM_2, &order, &norm));
    AssertNear(norm / sqrt(sum), 1, 1.0 / 4096);
  }
  assert_true(larger > 3 && larger < 17);
  ok(TSDestroy(&ts));
  ok(VecDestroy(&y));
}

/* In the interior of one step the interpolant is as good as the step: O(h^3), so halving h gains 8 up to its O(h)
   part */
static void test_interpolation(void **state)
{
  for (int kind = 0; kind < 2; kind++)
    for (PetscReal s = 0.2; s < 0.95; s += 0.3) {
      PetscReal error[2];

      for (int k = 0; k < 2; k++) {
        PetscReal h = 0.04 / (1 + k);
        Vec y, z;
        TS ts = Create(PETSC_FALSE, 0.5, h, 10.0, &y);

        if (kind) ok(TSBatheSetError(ts, TSBATHE_ERROR_DOUBLING));
        ok(TSStep(ts));
        ok(VecDuplicate(y, &z));
        ok(TSInterpolate(ts, 0.5 + s * h, z));
        error[k] = Distance(z, 0.5 + s * h);
        ObjectsDestroy(&z, &y, &ts);
      }
      assert_true(log2(error[0] / error[1]) > 2.8);
    }
}

/* y' = lambda (y - cos t) - sin t, lambda = -1e6, started off the slow solution: L-stable, so the transient is gone
   after a few steps and the error is that of the slow part, far below h^2 */
static PetscErrorCode StiffRHS(TS ts, PetscReal t, Vec y, Vec f, void *ctx)
{
  const PetscScalar a = VecRead(y)[0];

  PetscCall(VecSetValue(f, 0, -1e6 * (a - PetscCosReal(t)) - PetscSinReal(t), INSERT_VALUES));
  return VecAssemble(f);
}

static PetscErrorCode StiffJacobian(TS ts, PetscReal t, Vec y, Mat J, Mat P, void *ctx)
{
  PetscCall(MatSetValue(P, 0, 0, -1e6, INSERT_VALUES));
  return MatAssemble(P);
}

static void test_stiff(void **state)
{
  TS ts;
  Vec y;
  Mat J;
  TSBatheFirstStage first;
  PetscScalar a;

  ok(VecCreateSeq(PETSC_COMM_SELF, 1, &y));
  ok(VecSet(y, 2.0));
  ok(MatCreateSeqDense(PETSC_COMM_SELF, 1, 1, NULL, &J));
  ts = MakeTS(TSBATHE, 0.05, 1.0);
  ok(TSSetRHSFunction(ts, NULL, StiffRHS, NULL));
  ok(TSSetRHSJacobian(ts, J, J, StiffJacobian, NULL));
  ok(TSSolve(ts, y));
  ok(VecGetValues(y, 1, (PetscInt[]){0}, &a));
  ok(TSBatheGetFirstStage(ts, &first));
  assert_int_equal(first, TSBATHE_STAGE_TRAPEZOIDAL); /* of a right-hand side */
  AssertNear(a, cos(1.0), 1e-7); /* h^2/|lambda| is 2.5e-9, the SNES tolerance 1e-8 of the residual */
  ObjectsDestroy(&y, &J, &ts);
}

/* A step to the end of a run whose end is rounded: the run ends exactly there, after this one step. */
static void test_last_step(void **state)
{
  const PetscReal end = 63.9; /* half of which and more is a step whose last bit weighs as much as that of the end */
  PetscInt rounded = 0, steps;
  PetscReal t;
  TS ts;
  Vec y;
  Mat J;

  ok(VecCreateSeq(PETSC_COMM_SELF, 1, &y));
  ok(MatCreateSeqDense(PETSC_COMM_SELF, 1, 1, NULL, &J));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(TSSetType(ts, TSBATHE));
  ok(TSSetRHSFunction(ts, NULL, StiffRHS, NULL));
  ok(TSSetRHSJacobian(ts, J, J, StiffJacobian, NULL));
  ok(TSSetMaxTime(ts, end));
  ok(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  for (PetscReal start = 0.1; start < 30; start += 0.317) {
    const PetscReal h = end - start;

    if (start + h == end) continue;
    rounded++;
    ok(VecSet(y, 1));
    ok(TSSetTime(ts, start));
    ok(TSSetStepNumber(ts, 0));
    ok(TSSetTimeStep(ts, h));
    ok(TSSolve(ts, y));
    ok(TSGetTime(ts, &t));
    ok(TSGetStepNumber(ts, &steps));
    if (t != end || steps != 1) fail_msg("from %.17g: %d steps to %.17g", (double)start, (int)steps, (double)t);
  }
  assert_true(rounded > 10);
  ObjectsDestroy(&y, &J, &ts);
}

/* Rolled back, the state is the start's bits, and the same step again gives the same bits */
static void test_rollback_and_stages(void **state)
{
  Vec y, start, end, *stages;
  TS ts = Create(PETSC_FALSE, 0.5, 0.1, 10.0, &y);
  PetscBool same;
  PetscInt n;
  PetscReal t;

  ok(TSStep(ts));
  VecsDuplicate(y, &start, &end);
  ok(VecCopy(y, start));
  ok(TSStep(ts));
  ok(VecCopy(y, end));
  ok(TSGetStages(ts, &n, &stages));
  assert_int_equal(n, 2);
  ok(VecEqual(stages[1], y, &same));
  assert_true(same);
  assert_true(Distance(stages[0], 0.65) < 1e-3);
  ok(TSRollBack(ts));
  ok(TSGetTime(ts, &t));
  assert_true(fabs(t - 0.6) < 1e-14);
  ok(VecEqual(start, y, &same));
  assert_true(same);
  ok(TSStep(ts));
  ok(VecEqual(end, y, &same));
  assert_true(same);
  ObjectsDestroy(&start, &end, &y, &ts);
}

/* An event where y0 = 1/2 (t = 1); it sets y0 to 1/4, so the step must restart */
static PetscErrorCode Event(TS ts, PetscReal t, Vec y, PetscScalar f[], void *ctx)
{
  PetscCall(VecGetValues(y, 1, (PetscInt[]){0}, f));
  f[0] -= 0.5;
  return PETSC_SUCCESS;
}

static PetscErrorCode PostEvent(TS ts, PetscInt n, PetscInt list[], PetscReal t, Vec y, PetscBool forward, void *ctx)
{
  *(PetscReal *)ctx = t;
  PetscCall(VecSetValue(y, 0, 0.25, INSERT_VALUES));
  PetscCall(VecAssemble(y));
  return TSRestartStep(ts);
}

/* After the event y0' = -2 t y0^2 with y0(1) = 1/4: y0 = 1/(t^2 + 3). The event is located to the handler's 1e-6 or
   better. */
static void test_event_and_restart(void **state)
{
  Vec y;
  TS ts = Create(PETSC_FALSE, 0.5, 0.01, 2.0, &y);
  PetscReal when = 0.0;
  PetscInt direction = -1;
  PetscBool stop = PETSC_FALSE;
  PetscScalar a;
  SlipAttempt last;

  ok(TSSetEventHandler(ts, 1, &direction, &stop, Event, PostEvent, &when));
  ok(TSSetEventTolerances(ts, 1e-10, NULL));
  ok(TSSolve(ts, y));
  AssertNear(when, 1.0, 1e-4); /* the integrator's own error, h^2 */
  ok(VecGetValues(y, 1, (PetscInt[]){0}, &a));
  AssertNear(a, 1.0 / 7.0, 1e-4);
  ok(TSBatheGetLastAttempt(ts, &last));
  assert_true(last.accepted && last.error >= 0.0);
  ObjectsDestroy(&y, &ts);
}

/* PETSc's controllers. Adaptive ones keep the global error near the tolerance (1e-5; 100 times is generous for 2 s) */
static void test_petsc_controllers(void **state)
{
  const char *const types[] = {TSADAPTNONE, TSADAPTBASIC, TSADAPTDSP, TSADAPTHISTORY};
  const PetscReal times[] = {0.5, 0.6, 0.8, 1.1, 1.3, 1.7, 2.0, 2.5};

  for (int k = 0; k < 4; k++)
    for (int form = 0; form < 2; form++) {
      Vec y;
      TS ts = Create(form ? PETSC_TRUE : PETSC_FALSE, 0.5, 0.05, 2.5, &y);
      TSAdapt adapt;
      PetscInt attempts, accepted, solves, steps, rejected;
      PetscReal t;

      ok(TSGetAdapt(ts, &adapt));
      ok(TSAdaptSetType(adapt, types[k]));
      if (k == 3) {
        ok(TSAdaptHistorySetHistory(adapt, 8, (PetscReal *)times, PETSC_FALSE));
        ok(TSSetTimeStep(ts, times[1] - times[0])); /* history chooses from the second step on */
      }
      ok(TSSetTolerances(ts, 1e-5, NULL, 1e-5, NULL));
      ok(TSSolve(ts, y));
      ok(TSGetTime(ts, &t));
      ok(TSGetStepNumber(ts, &steps));
      ok(TSGetStepRejections(ts, &rejected));
      ok(TSBatheGetTotals(ts, &attempts, &accepted, &solves, NULL, NULL));
      AssertNear(t, 2.5, 1e-12);
      assert_int_equal(attempts, steps + rejected);
      assert_int_equal(accepted, steps);
      /* one solve an attempt, but three where an implicit form starts, which happens until the first step is
         accepted */
      if (form && (k == 1 || k == 2))
        assert_true(solves >= attempts + 2 && (solves - attempts) % 2 == 0);
      else
        assert_int_equal(solves, attempts);
      AssertLess(Distance(y, t), (k == 3 ? 2e-2 : 1e-3));
      if (k == 3) assert_int_equal(steps, 7);
      ObjectsDestroy(&y, &ts);
    }
}

/* Composed hooks of a controller: the first step, and whether it has a use for errors */
static PetscErrorCode First(TSAdapt adapt, TS ts, PetscReal *h)
{
  *h = 100.0;
  return PETSC_SUCCESS;
}

static PetscErrorCode NeedsNot(TSAdapt adapt, PetscBool *flg)
{
  *flg = PETSC_FALSE;
  return PETSC_SUCCESS;
}

static PetscErrorCode RecordAttempt(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  *(SlipAttempt *)ctx = *attempt;
  return PETSC_SUCCESS;
}

static void test_controller_hooks(void **state)
{
  for (int needs = 0; needs < 2; needs++) {
    Vec y;
    TS ts = Create(PETSC_FALSE, 0.5, 0.1, 0.8, &y);
    TSAdapt adapt;
    SlipAttempt seen = {.solves = 0};

    ok(TSBatheSetError(ts, TSBATHE_ERROR_DOUBLING));
    ok(TSBatheMonitorSet(ts, RecordAttempt, &seen, NULL));
    ok(TSGetAdapt(ts, &adapt));
    ok(PetscObjectComposeFunction((PetscObject)adapt, "TSAdaptChooseFirst_C", First));
    if (!needs) ok(PetscObjectComposeFunction((PetscObject)adapt, "TSAdaptNeedsError_C", NeedsNot));
    ok(TSSolve(ts, y));
    assert_true(fabs(seen.dt - 0.3) < 1e-14); /* 100 clipped to the end */
    assert_int_equal(seen.solves, needs ? 3 : 1);
    assert_true(needs ? seen.error > 0.0 : seen.error == -1.0);
    assert_true(seen.accepted && seen.converged && seen.residual >= 0.0 && seen.residual < 1e-6);
    ObjectsDestroy(&y, &ts);
  }
}

typedef struct {
  PetscInt *order, calls, destroyed;
  PetscInt number; /* in the order of registration */
} Counted;

static PetscErrorCode CountAttempt(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  Counted *c = (Counted *)ctx;

  assert_int_equal(*c->order, c->number);
  *c->order = (*c->order + 1) % 20;
  c->calls++;
  return PETSC_SUCCESS;
}

static PetscErrorCode CountDestroyed(void **ctx)
{
  ((Counted *)*ctx)->destroyed++;
  return PETSC_SUCCESS;
}

/* Twenty of them are called in order; one that is set twice is called once; cancelled ones are called no more, and
   their contexts are destroyed once. */
static void test_attempt_monitors(void **state)
{
  Counted count[20];
  SlipAttempt last;
  PetscInt order = 0, attempts;
  Vec y;
  TS ts = Create(PETSC_FALSE, 0.5, 0.1, 0.8, &y);

  for (PetscInt i = 0; i < 20; i++) {
    count[i] = (Counted){.order = &order, .number = i};
    for (int k = 0; k < 2; k++) ok(TSBatheMonitorSet(ts, CountAttempt, &count[i], CountDestroyed));
  }
  ok(TSSolve(ts, y));
  ok(TSBatheGetTotals(ts, &attempts, NULL, NULL, NULL, NULL));
  assert_true(attempts > 1);
  for (PetscInt i = 0; i < 20; i++) assert_true(count[i].calls == attempts && !count[i].destroyed);
  ok(TSBatheMonitorCancel(ts));
  ok(TSBatheMonitorSet(ts, CountAttempt, &count[0], NULL));
  ok(TSBatheMonitorCancel(ts));
  ok(TSBatheMonitorSet(ts, RecordAttempt, &last, NULL));
  ok(TSSetTime(ts, 0.5));
  ok(TSSetStepNumber(ts, 0));
  ok(TSSolve(ts, y));
  ok(TSDestroy(&ts));
  for (PetscInt i = 0; i < 20; i++) assert_true(count[i].calls == attempts && count[i].destroyed == 1);
  ok(VecDestroy(&y));
}

/* What is set is what is got, and other types of TS are left alone by setters of choices only. */
static void test_pairs(void **state)
{
  TSBatheReactionType type;
  TSBatheError error;
  PetscReal gamma;
  PetscInt p;
  Vec y;
  TS ts = Create(PETSC_FALSE, 0.5, 0.1, 0.8, &y);

  ok(TSBatheSetReactionType(ts, TSBATHE_REACTION_IMPLICIT));
  ok(TSBatheGetReactionType(ts, &type));
  ok(TSBatheSetDoublingOrder(ts, 3));
  p = ((TS_Bathe *)ts->data)->estimate.order;
  ok(TSBatheSetError(ts, TSBATHE_ERROR_NONE));
  ok(TSBatheGetError(ts, &error));
  ok(TSBatheSetGamma(ts, 0.25));
  ok(TSBatheGetGamma(ts, &gamma));
  assert_true(type == TSBATHE_REACTION_IMPLICIT && p == 3 && error == TSBATHE_ERROR_NONE && gamma == 0.25);
  ok(TSSetType(ts, TSBDF));
  ok(TSBatheSetGamma(ts, 0.5));
  fails(TSBatheGetGamma(ts, &gamma), "TS type bdf, expected bathe");
  fails(TSBatheMonitorSet(ts, RecordAttempt, NULL, NULL), "TS type bdf, expected bathe");
  ObjectsDestroy(&ts, &y);
}

SLIP_TESTS(test_order_two, test_estimates_are_third_order, test_norm_of_the_error, test_interpolation, test_stiff,
           test_last_step, test_rollback_and_stages, test_event_and_restart, test_petsc_controllers,
           test_controller_hooks, test_attempt_monitors, test_pairs)
