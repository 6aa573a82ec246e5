/* TSLAPUSTA: the formulas of a step, its estimate and what is in between, the lengths of steps, ends, rests that waves
   may end, and attempts that are refused. */
#include "../scriptadapt.h"
#include <math.h>

/* u' = rate u + 2 t, whose rates are those that drift follows; or 0 until 1.25 s and 1 from then on */
typedef struct {
  PetscReal shortest, corner, waits_until, most; /* most: u beyond it is no state */
  PetscReal rate;
  PetscBool jumps;
  PetscInt evaluations, attempts, rollbacks;
  PetscReal domain; /* the last time that was asked about */
} Problem;
static Problem p;

static PetscErrorCode Rates(TS ts, PetscReal t, Vec u, Vec f, void *ctx)
{
  p.evaluations++;
  PetscCall(VecCopy(u, f));
  PetscCall(VecScale(f, p.jumps ? 0 : p.rate));
  return VecShift(f, p.jumps ? (t >= 1.25 ? 1 : 0) : 2 * t);
}

static PetscErrorCode Follow(TS ts, PetscReal h, Vec w0, Vec F, Vec w1, void *ctx)
{
  return VecWAXPY(w1, h, F, w0);
}

static PetscErrorCode Shortest(TS ts, PetscReal *step, void *ctx)
{
  *step = p.shortest;
  return PETSC_SUCCESS;
}

static PetscErrorCode Waits(TS ts, PetscReal t, Vec w, PetscBool *waits, void *ctx)
{
  *waits = t < p.waits_until ? PETSC_TRUE : PETSC_FALSE;
  return PETSC_SUCCESS;
}

static PetscErrorCode Corner(TS ts, PetscReal t, PetscReal *next, void *ctx)
{
  *next = p.corner > t ? p.corner : PETSC_MAX_REAL;
  return PETSC_SUCCESS;
}

static PetscErrorCode RollBack(TS ts, void *ctx)
{
  p.rollbacks++;
  return PETSC_SUCCESS;
}

static PetscErrorCode Inside(TS ts, PetscReal t, Vec u, PetscBool *inside)
{
  PetscReal most;

  p.domain = t;
  PetscCall(VecMax(u, NULL, &most));
  *inside = most <= p.most ? PETSC_TRUE : PETSC_FALSE;
  if (!*inside) p.attempts++;
  return PETSC_SUCCESS;
}

static const SlipProblemOps Ops = {.drifts = {.drift = Follow, .shortest = Shortest, .waits = Waits},
                                   .steps = {.corner = Corner},
                                   .history = {.rollback = RollBack}};

/* A controller that wants what the test says, and takes all but so many of the first attempts */
static struct {
  const PetscReal *wants; /* of the first step, and after each attempt */
  int at, refuses, order;
  PetscReal error;
} script;

static PetscErrorCode Choose(TSAdapt adapt, TS ts, PetscReal h, PetscInt *scheme, PetscReal *next, PetscBool *accept,
                             PetscReal *wlte, PetscReal *wltea, PetscReal *wlter)
{
  PetscInt order;

  PetscCall(TSEvaluateWLTE(ts, NORM_INFINITY, &order, &script.error));
  script.order = (int)order;
  p.attempts++;
  *scheme = 0;
  *wlte = *wltea = *wlter = -1;
  *accept = script.at >= script.refuses || adapt->always_accept ? PETSC_TRUE : PETSC_FALSE;
  *next = script.wants[++script.at];
  return PETSC_SUCCESS;
}

/* A run from u0 that begins with wants[0] */
static TS Start(const char adapt[], const PetscReal wants[], PetscReal end, PetscReal u0, Vec *u)
{
  TS ts;

  ok(VecCreateSeq(PETSC_COMM_SELF, 1, u));
  ok(VecSet(*u, u0));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(TSSetProblemType(ts, TS_NONLINEAR));
  ok(TSSetType(ts, TSLAPUSTA));
  ok(TSSetRHSFunction(ts, NULL, Rates, NULL));
  ok(TSSetFunctionDomainError(ts, Inside));
  ok(TSSetSlipProblem(ts, &Ops, NULL));
  Configure(ts, adapt, end, *u);
  ok(TSSetTimeStep(ts, wants[0]));
  ok(TSSetMaxSteps(ts, 1000));
  ok(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_STEPOVER));
  script.wants = wants;
  script.at = script.refuses = 0;
  p.evaluations = p.attempts = p.rollbacks = 0;
  return ts;
}

/* The lengths of n steps, exactly */
static void AssertSteps(TS ts, int n, const PetscReal lengths[])
{
  for (int i = 0; i < n; i++) {
    PetscReal t0, t, next;

    ok(TSGetTime(ts, &t0));
    ok(TSStep(ts));
    ok(TSGetTime(ts, &t));
    ok(TSGetTimeStep(ts, &next));
    if (t != t0 + lengths[i]) fail_msg("step %d: %.17g, expected %.17g", i, (double)(t - t0), (double)lengths[i]);
    if (p.shortest > 0 && ((PetscObject)ts->adapt)->type_name[0] == 's') assert_true(next >= p.shortest);
  }
}

static const Problem nothing = {.corner = -1, .waits_until = -1, .most = PETSC_MAX_REAL};

static void test_list(void **state)
{
  /* in shortest steps of 1/8 s, exact; the fourth is 1.5 times, less one rounding */
  const PetscReal asked[] = {
    0.01, 0.125, 0.187, 0.1875 * (1 - PETSC_MACHINE_EPSILON), 0.2499, 0.25, 0.374, 0.375, 1.4, 1.5, 1.99,
    64,   0.05,  0.05};
  const PetscReal taken[] = {0.125, 0.125, 0.125, 0.1875, 0.1875, 0.25, 0.25, 0.375, 1, 1.5, 1.5, 64, 0.125};
  const PetscReal limited[] = {0.1, 0.35, 0.6, 0.61}, longer[] = {0.25, 0.25, 0.5};
  const PetscReal tenths[] = {0.3, 0.3}, same[] = {0.05, 0.3, 0.01, 0.01};
  Vec u;
  TS ts;

  p = nothing;
  p.shortest = 0.125;
  ts = Start("script", asked, 1e3, 1, &u);
  AssertSteps(ts, 13, taken);
  ObjectsDestroy(&ts, &u);
  p.shortest = 0.1; /* 0.3 over it is less than 3 when rounded */
  ts = Start("script", tenths, 1e3, 1, &u);
  AssertSteps(ts, 1, (const PetscReal[]){3 * 0.1});
  ObjectsDestroy(&ts, &u);
  p.shortest = 0.125; /* the controller's shortest is longer */
  ts = Start("script", limited, 1e3, 1, &u);
  ok(TSAdaptSetStepLimits(ts->adapt, 0.25, 100));
  AssertSteps(ts, 2, longer);
  ObjectsDestroy(&ts, &u);
  p.shortest = 0; /* there is no list */
  ts = Start("script", limited, 1e3, 1, &u);
  ok(TSAdaptSetStepLimits(ts->adapt, 0.0625, 100));
  AssertSteps(ts, 2, limited);
  ObjectsDestroy(&ts, &u);
  p.shortest = 0.125; /* constant steps are not of it */
  p.waits_until = 10;
  ts = Start(TSADAPTNONE, same, 1e3, 1, &u);
  AssertSteps(ts, 2, (const PetscReal[]){0.05, 0.05});
  ObjectsDestroy(&ts, &u);
}

/* Two equal steps where one would leave less than the shortest, until a corner and until the end */
static void test_ends(void **state)
{
  const PetscReal one[] = {1, 1, 1, 1};
  const struct {
    PetscReal end, steps[2];
  } row[] = {{1, {1, 1}}, {1.0625, {0.53125, 0.53125}}, {1.125, {1, 0.125}}, {0.875, {0.875, 1}}, {0.05, {0.05, 1}}};
  Vec u;
  TS ts;

  p = nothing;
  p.shortest = 0.125;
  for (int k = 0; k < 5; k++) {
    p.corner = row[k].end;
    ts = Start("script", one, 1e3, 1, &u);
    AssertSteps(ts, 2, row[k].steps);
    ObjectsDestroy(&ts, &u);
    p.corner = -1;
    for (int match = 0; match < 2; match++) {
      ts = Start("script", one, row[k].end, 1, &u);
      ok(TSSetExactFinalTime(ts, match ? TS_EXACTFINALTIME_MATCHSTEP : TS_EXACTFINALTIME_STEPOVER));
      AssertSteps(ts, 1, match ? row[k].steps : one);
      ObjectsDestroy(&ts, &u);
    }
  }
}

/* A step to a corner ends there, whatever rounding makes of its length */
static void test_corner(void **state)
{
  const PetscReal one[] = {1, 1};
  int beyond = 0;

  p = nothing;
  p.shortest = 0.125;
  for (int k = 1; k < 64; k++) {
    const PetscReal start = 0.01 * k;
    PetscReal t;
    Vec u;
    TS ts;

    p.corner = 0.9;
    if (start + (p.corner - start) > p.corner) beyond++;
    ts = Start("script", one, 1e3, 1, &u);
    ok(TSSetTime(ts, start));
    ok(TSStep(ts));
    ok(TSGetTime(ts, &t));
    assert_true(t <= p.corner && p.corner - t <= PETSC_MACHINE_EPSILON);
    ObjectsDestroy(&ts, &u);
  }
  assert_in_range(beyond, 1, 63);
}

/* The state and the rates of the next step's start after one of h, and the estimate, by hand */
static PetscReal ByHand(PetscReal t, PetscReal h, PetscReal u0, PetscReal *f, PetscReal *error)
{
  PetscReal mean = *f, first = 0, end = 0, u = u0 + h * mean;

  for (int k = 1; k <= 2; k++) {
    end = p.rate * u + 2 * (t + h);
    mean = 0.5 * (*f + end);
    if (k == 1) first = mean;
    u = u0 + h * mean;
  }
  *f = end;
  *error = h * fabs(mean - first);
  return u;
}

static PetscReal ValueAt(TS ts, PetscReal t)
{
  PetscScalar value;
  Vec x;

  ok(VecDuplicate(ts->vec_sol, &x));
  ok(TSInterpolate(ts, t, x));
  ok(VecSum(x, &value));
  ok(VecDestroy(&x));
  return value;
}

/* Steps of 0.5 and 0.75 s as written down, with two right-hand sides each and one for the start; linear in between; and
   back to the start of the second, from which it is the same but for its rates, which are asked for anew */
static void test_formulas(void **state)
{
  const PetscReal h[] = {0.5, 0.75, 0.75, 0.75, 0.75}, round = 8 * PETSC_MACHINE_EPSILON;
  PetscReal u[3] = {1}, f = -0.5, error, t;
  Vec x;
  TS ts;

  p = nothing;
  p.rate = -0.5;
  p.shortest = 0.125;
  ts = Start("script", h, 1e3, u[0], &x);
  for (int k = 0; k < 2; k++) {
    t = k ? h[0] : 0;
    u[k + 1] = ByHand(t, h[k], u[k], &f, &error);
    AssertSteps(ts, 1, &h[k]);
    assert_true(p.domain == t + h[k]);
    assert_int_equal(p.evaluations, 3 + 2 * k);
    assert_int_equal(script.order, 3);
    AssertNear(script.error, error, round);
    AssertNear(ValueAt(ts, t), u[k], round);
    AssertNear(ValueAt(ts, t + 0.25 * h[k]), 0.75 * u[k] + 0.25 * u[k + 1], round);
    AssertNear(ValueAt(ts, t + h[k]), u[k + 1], round);
  }
  ok(TSRollBack(ts));
  assert_int_equal(p.rollbacks, 1);
  ok(TSGetTime(ts, &t));
  assert_true(t == h[0]);
  ok(VecSum(ts->vec_sol, &error));
  AssertNear(error, u[1], round);
  ok(TSSetTimeStep(ts, h[1]));
  f = p.rate * u[1] + 2 * h[0];
  u[2] = ByHand(h[0], h[1], u[1], &f, &error);
  AssertSteps(ts, 1, &h[1]);
  assert_int_equal(p.evaluations, 8);
  ok(VecSum(ts->vec_sol, &error));
  AssertNear(error, u[2], round);
  ObjectsDestroy(&ts, &x);
}

/* What a controller refuses is taken back, but the shortest step is not refused; one that leads out of the domain ends
   the run */
static void test_refused(void **state)
{
  const PetscReal h[] = {1, 0.5, 0.125, 0.125, 1, 1}, short_enough[] = {0.5, 0.5};
  PetscReal f, error;
  Vec x;
  TS ts;

  p = nothing;
  p.rate = -0.5;
  p.shortest = 0.125;
  ts = Start("script", h, 1e3, 1, &x);
  script.refuses = 100;
  AssertSteps(ts, 1, (const PetscReal[]){0.125});
  assert_int_equal(p.attempts, 3);
  assert_int_equal(p.rollbacks, 2);
  f = p.rate;
  f = ByHand(0, 0.125, 1, &f, &error);
  ok(VecSum(ts->vec_sol, &error));
  AssertNear(error, f, 4 * PETSC_MACHINE_EPSILON);
  ObjectsDestroy(&ts, &x);
  p.most = 0.5; /* at 1/2 s, and at a quarter of it, the shortest */
  ts = Start("script", short_enough, 1e3, 1, &x);
  fails(TSStep(ts),
        "At time 0 s the shortest step, 0.125 s, leads to what is no state of the problem (-ts_type lapusta)");
  assert_int_equal(p.attempts, 2);
  ObjectsDestroy(&ts, &x);
  ts = Start(TSADAPTNONE, (const PetscReal[]){0.0625, 0.0625}, 1e3, 1, &x);
  fails(TSStep(ts), "a constant step of 0.0625 s");
  assert_int_equal(p.attempts, 1);
  ObjectsDestroy(&ts, &x);
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(VecCreateSeq(PETSC_COMM_SELF, 1, &x));
  ok(TSSetType(ts, TSLAPUSTA));
  ok(TSSetSolution(ts, x));
  fails(TSSetUp(ts), "expected a problem that says how its state follows constant rates");
  ObjectsDestroy(&ts, &x);
}

/* A rest that waves may end goes on by four shortest steps and one right-hand side each, the corrections being nothing;
   that in which something moves is the shortest instead, corrected as ever. */
static void test_waits(void **state)
{
  const PetscReal wants[] = {1, 1, 1, 1, 0.25, 0.25, 0.25, 0.25};
  PetscScalar u;
  Vec x;
  TS ts;

  p = nothing;
  p.jumps = PETSC_TRUE;
  p.shortest = 0.125;
  p.waits_until = 1.2;
  ts = Start("script", wants, 1e3, 3, &x);
  AssertSteps(ts, 2, (const PetscReal[]){0.5, 0.5});
  assert_int_equal(p.evaluations, 3);
  assert_true(script.error <= 1e-10); /* the least that is told */
  ok(VecSum(x, &u));
  assert_true(u == 3);
  AssertSteps(ts, 1, (const PetscReal[]){0.125}); /* not 0.5, in which all slides; nothing does */
  assert_int_equal(p.evaluations, 5);
  ok(VecSum(x, &u));
  assert_true(u == 3);
  AssertSteps(ts, 1, (const PetscReal[]){0.125}); /* its end slides */
  assert_int_equal(p.evaluations, 8);
  ok(VecSum(x, &u));
  assert_true(u == 3 + 0.5 * 0.125);
  AssertSteps(ts, 1, (const PetscReal[]){0.25}); /* it waits no longer */
  ok(VecSum(x, &u));
  assert_true(u == 3 + 0.5 * 0.125 + 0.25);
  ObjectsDestroy(&ts, &x);
}

SLIP_TESTS_WITH(Register, NULL, test_list, test_ends, test_corner, test_formulas, test_refused, test_waits)
