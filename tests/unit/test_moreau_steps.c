/* Steps of TSMOREAU one by one, against the formulas as written down: kicks with lagged damping, derivative, error
   estimate, what a changed state and a failed kick make of them, checkpoints, and the choice of methods. */
#include "../scriptadapt.h"
#include "../smallsteps.h"
#include <slipstep/rooms/slipcore.h>
#include <slipstep/private/slipstate.h>
#include <slipstep/private/slipbathe.h>
#include <math.h>

/* ---- a block: v' = Load - K u - H v - Q while it slides forwards, u' = v, s' = |v| ---- */

#define K 4.0
static PetscReal growth; /* of all that depends on time [1/s] */

static PetscReal H(PetscReal t)
{
  return 2 + 0.3 * growth * t;
}

static PetscReal Q(PetscReal t)
{
  return 0.25 + 0.1 * growth * t;
}

static PetscReal Load(PetscReal t)
{
  return 1.5 + 0.4 * growth * t;
}

#define ROUND 1e-14 /* of some ten operations with numbers near 1 */

static PetscErrorCode Force(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  PetscFunctionBeginUser;
  (void)ctx;
  F[0] = Load(t) - K * w[1] - H(t) * w[0];
  F[1] = w[0];
  F[2] = fabs(w[0]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Jacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  PetscFunctionBeginUser;
  (void)ctx;
  J[0] = -H(t);
  J[1] = -K;
  J[3] = 1;
  J[6] = w[0] < 0 ? -1 : 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Bound(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx)
{
  PetscFunctionBeginUser;
  (void)w, (void)dq, (void)ctx;
  q[0] = Q(t);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Longest stable step at first: omega is 2, the damping ratio 1/2 */
#define LONGEST (0.97 * 2 / (1 + PETSC_SQRT2) / 2)

/* The constraint's operations, and the damping at the nodes of the last step; kicks so many from now on fail */
static SlipConstraintOps ops;
static SlipExplicitOps with;
static PetscReal damping[SLIP_NUM_NODES];
static int failing;
static PetscErrorCode (*KickOf)(SlipConstraint, PetscReal, PetscReal, Vec, Vec, PetscBool *, void *);

static PetscErrorCode Settle(SlipConstraint con, SlipNode node, PetscReal t, Vec w, Vec p, void *ctx)
{
  PetscFunctionBeginUser;
  (void)con, (void)t, (void)w, (void)ctx;
  Get(p, 1, &damping[node]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Kick(SlipConstraint con, PetscReal t, PetscReal a, Vec g, Vec w, PetscBool *good, void *ctx)
{
  PetscFunctionBeginUser;
  PetscCall((*KickOf)(con, t, a, g, w, good, ctx));
  if (failing > 0 && failing--) *good = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A controller that takes each attempt but the refused, and wants the next step */
static struct {
  PetscReal next, shorter; /* after an attempt that was taken, or not [s] */
  int refuses;
} script;

static const SlipMethodCosts costs = {.step = 2, .solve = 1};

static PetscErrorCode Choose(TSAdapt adapt, TS ts, PetscReal h, PetscInt *scheme, PetscReal *next, PetscBool *accept,
                             PetscReal *wlte, PetscReal *wltea, PetscReal *wlter)
{
  PetscFunctionBeginUser;
  (void)adapt, (void)h;
  ((TS_Bathe *)ts->data)->moreau.costs = costs; /* whatever the attempt has taken */
  *scheme = 0;
  *wlte = *wltea = *wlter = -1;
  *accept = script.refuses > 0 && script.refuses-- ? PETSC_FALSE : PETSC_TRUE;
  *next = *accept ? script.next : script.shorter;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscInt attempts, reason;
static PetscReal tried[8], held; /* the reaction after the first */

static PetscReal stages[2]; /* times of the last */

static PetscErrorCode BeforeStage(TS ts, PetscReal t)
{
  PetscFunctionBeginUser;
  (void)ts;
  stages[0] = stages[1];
  stages[1] = t;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Keep(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  Vec reaction;

  PetscFunctionBeginUser;
  (void)w, (void)ctx;
  PetscCall(TSBatheGetReaction(ts, &reaction));
  if (!attempts) Get(reaction, 1, &held);
  assert_int_equal(attempt->solves, attempt->method == TSBATHE_METHOD_EXPLICIT ? 1 : attempt->solves);
  if (attempts < 8) tried[attempts] = attempt->dt;
  if (!attempts++) reason = attempt->reason;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static TS Start(const char type[], PetscReal v, Vec *x)
{
  static const PetscReal mass[] = {1, 1, 1};
  static const PetscInt rows[] = {0};
  const SlipSmall problem = {3, mass, 1, rows, Force, Jacobian, Bound, NULL};
  const PetscReal start[] = {v, 0, 0};
  TS_Bathe *ba;
  TS ts;

  *x = State(3, start);
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(SlipSmallConfigureTS(&problem, ts));
  ok(TSSetType(ts, type));
  ba = (TS_Bathe *)ts->data;
  ops = *ba->ops;
  with = *ops.explicit_ops;
  KickOf = with.kick;
  with.kick = Kick;
  with.settle = Settle;
  ops.explicit_ops = &with;
  ba->ops = &ops;
  Configure(ts, "script", 1e9, *x);
  ok(TSBatheMonitorSet(ts, Keep, NULL, NULL));
  ok(TSSetPreStage(ts, BeforeStage));
  attempts = reason = 0;
  failing = script.refuses = 0;
  growth = 0;
  script.next = script.shorter = 0.1;
  return ts;
}

/* ---- by hand ---- */

typedef struct {
  PetscReal t, v, u, s;
  PetscReal p, p_before, h, h_before; /* damping of the last two inner rates, and their steps */
  PetscReal p_end, a[2], h_a;         /* dv/dt at the start of this step and of the one before, that step: 0, unknown */
  PetscReal end, error[3];            /* dv/dt at the end; estimates of v, u and s */
} Block;

static PetscReal Acceleration(const Block *b)
{
  return Load(b->t) - K * b->u - H(b->t) * b->v - Q(b->t);
}

static void Anew(Block *b)
{
  b->p = H(b->t) * b->v;
  b->h = b->h_before = b->h_a = 0;
  b->end = Acceleration(b);
}

static void StepByHand(Block *b, PetscReal h)
{
  const PetscReal weight = SlipLagWeight(h, b->h, b->h_before, 2, H(b->t) / 4), v0 = b->v,
                  expected = weight * b->p + (1 - weight) * b->p_before;
  const PetscReal inner = v0 + h / 2 * (Load(b->t) - K * b->u - expected - Q(b->t)), p = H(b->t + h / 2) * inner;
  PetscReal change;

  b->a[1] = b->a[0];
  b->a[0] = b->end;
  b->t += h;
  b->u += h * inner;
  b->s += h * fabs(inner);
  b->v = inner + h / 2 * (Load(b->t) - K * b->u - 2 * p + expected - Q(b->t));
  b->p_end = p + h / (h + b->h) * (p - b->p);
  b->end = Acceleration(b);
  change = (b->end - b->a[0]) / h;
  /* h^3/12 of the second derivative of a, or h^2/6 of the first; and the trapezoidal rule is h^3/12 of it
     away from the right one, the midpoint rule's minus half as much */
  b->error[0] =
    b->h_a > 0 ? h * h * h / 12 * (change - (b->a[0] - b->a[1]) / b->h_a) / (0.5 * (h + b->h_a)) : h * h / 6 * change;
  b->error[1] = b->error[2] = 2.0 / 3 * h * (inner - 0.5 * (v0 + b->v));
  b->p_before = b->p;
  b->p = p;
  b->h_before = b->h;
  b->h = b->h_a = h;
}

static void Step(TS ts, PetscReal h)
{
  ok(TSSetTimeStep(ts, h));
  ok(TSStep(ts));
}

static void AssertBlock(TS ts, const Block *b)
{
  const PetscReal state[] = {b->v, b->u, b->s}, slope[] = {b->end, b->v, b->v};
  PetscReal w[3], e[3], k[3], scale;
  Vec x, error, derivative;

  ok(TSGetSolution(ts, &x));
  ok(TSBatheGetEstimates(ts, &error, &scale, &derivative));
  assert_non_null(error);
  assert_non_null(derivative);
  Get(x, 3, w);
  Get(error, 3, e);
  Get(derivative, 3, k);
  assert_true(scale == 1);
  for (int i = 0; i < 3; i++) {
    AssertNear(w[i], state[i], ROUND);
    AssertNear(e[i], b->error[i], ROUND);
    AssertNear(k[i], slope[i], ROUND);
  }
  AssertNear(damping[SLIP_NODE_INSIDE], b->p, ROUND);
  AssertNear(damping[SLIP_NODE_END], b->p_end, ROUND);
}

/* Lengths for which the weight of the last damping is 1, 1.47, 1.75 and 1.43 */
static const PetscReal lengths[] = {0.1, 0.3, 0.16, 0.08, 0.2};

static void test_steps(void **state)
{
  Block b = {.v = 0.1};
  Vec x;
  TS ts = Start(TSMOREAU, b.v, &x);

  (void)state;
  growth = 1;
  Anew(&b);
  for (int k = 0; k < 8; k++) {
    const PetscReal h = lengths[k % 5];

    if (k == 5) { /* a solution that was touched begins anew */
      ok(PetscObjectStateIncrease((PetscObject)x));
      Anew(&b);
    }
    StepByHand(&b, h);
    Step(ts, h);
    assert_true(b.v > 0);
    AssertNear(stages[0], b.t - h / 2, ROUND);
    AssertNear(stages[1], b.t, ROUND);
    AssertBlock(ts, &b);
    AssertNear(damping[SLIP_NODE_START], k == 0 || k == 5 ? b.p_before : damping[SLIP_NODE_START], ROUND);
  }
  ObjectsDestroy(&ts, &x);
}

/* The longest step is taken, a longer one is cut to it, which is told where steps are constant */
static void test_longest(void **state)
{
  PetscReal t[2];
  Vec x;
  TS ts = Start(TSMOREAU, 0.1, &x);

  (void)state;
  ok(TSBatheGetLongestStep(ts, &t[1]));
  AssertNear(t[1], LONGEST, ROUND);
  SetAdapt(ts, TSADAPTNONE);
  Step(ts, t[1]);
  ok(TSGetTime(ts, &t[0]));
  assert_true(t[0] == t[1]);
  assert_false(((TS_Bathe *)ts->data)->moreau.bound_told);
  Step(ts, 3);
  ok(TSGetTime(ts, &t[0]));
  assert_true(t[0] == 2 * t[1]);
  assert_true(((TS_Bathe *)ts->data)->moreau.bound_told);
  ObjectsDestroy(&ts, &x);
}

/* A cell without a solution ends the attempt, as a solve that failed does: the next one is a quarter as long, from the
   same start */
static void test_failed(void **state)
{
  Block b = {.v = 0.1};
  Vec x;
  TS ts = Start(TSMOREAU, b.v, &x);

  (void)state;
  growth = 1;
  Anew(&b);
  for (int k = 0; k < 2; k++) {
    StepByHand(&b, 0.3);
    Step(ts, 0.3);
  }
  attempts = 0;
  failing = 1;
  StepByHand(&b, 0.25 * 0.2);
  Step(ts, 0.2);
  assert_int_equal(attempts, 2);
  assert_int_equal(reason, SNES_DIVERGED_FUNCTION_DOMAIN);
  AssertNear(held, -Q(0.6), ROUND); /* the start's */
  assert_true(tried[0] == 0.2);
  AssertNear(tried[1], 0.05, ROUND);
  AssertBlock(ts, &b);
  ObjectsDestroy(&ts, &x);
}

/* ---- the choice of methods ---- */

static PetscReal WishAfter(TS ts, PetscReal h)
{
  PetscReal next;

  ((TS_Bathe *)ts->data)->moreau.costs = costs;
  Step(ts, h);
  ok(TSGetTimeStep(ts, &next));
  return next;
}

/* The error of a step as controllers see it */
static PetscReal Norm(const Block *b)
{
  return sqrt((PetscSqr(b->error[0]) + PetscSqr(b->error[1]) + PetscSqr(b->error[2])) / 3);
}

static void test_wish(void **state)
{
  PetscReal longest = LONGEST, t;
  Block b = {.v = 0.1};
  TSAdapt adapt;
  Vec x;
  TS ts;

  (void)state;
  for (int cut = 0; cut < 2; cut++)
    for (int last = 0; last < 8; last++) {
      const PetscReal asked = cut ? 3 * longest : 0.5 * longest;
      PetscReal want;

      b = (Block){.v = 0.1};
      Anew(&b);
      StepByHand(&b, longest);
      ts = Start(TSBATHE, 0.1, &x);
      ok(TSGetAdapt(ts, &adapt));
      ok(TSBatheSetMethod(ts, last == 6 ? TSBATHE_METHOD_EXPLICIT : TSBATHE_METHOD_AUTO));
      ok(TSSetTolerances(ts, last == 1 ? Norm(&b) / 8 : 1e3, NULL, 0,
                         NULL)); /* an error of 8 or little; of third order in h */
      if (last == 2) script.next = 100;
      if (last == 3) ok(TSAdaptSetStepLimits(adapt, 1e-3, 4 * longest));
      if (last == 4) {
        ok(TSSetMaxTime(ts, 3.5 * longest));
        ok(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
      }
      if (last == 5) ok(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_STEPOVER));
      if (last == 7) ok(TSBatheSetError(ts, TSBATHE_ERROR_NONE));
      want = 6 * longest;
      if (last == 1) want = adapt->safety * longest / 2;
      if (last == 2) want = 100;
      if (last == 3) want = 4 * longest;
      if (last == 4) want = SlipControlMatch(6 * longest, 2.5 * longest);
      if (!cut || last >= 6) want = script.next; /* the controller knows */
      AssertNear(WishAfter(ts, asked), want, last == 1 ? 1e-9 : 1e-12);
      ok(TSGetTime(ts, &t));
      AssertNear(t, cut ? longest : asked, ROUND);
      ObjectsDestroy(&ts, &x);
    }
}

/* After a long implicit step that was refused 64 explicit ones that are cut do not ask for more than the controller
   does, the 64th does, or one that ends beyond it; the 32nd, where an implicit one was taken in between. */
static void test_waits(void **state)
{
  const PetscReal longest = LONGEST;
  const struct {
    PetscReal refused, shorter;
    PetscInt steps[2];
  } row[] = {{1000, 3, {64, 64}}, {20, 3, {20, 21}}, {1000, 500, {33, 33}}}; /* in longest ones, with the first */
  PetscInt n;
  Vec x;
  TS ts;

  (void)state;
  for (int k = 0; k < 3; k++) {
    PetscReal next;

    ts = Start(TSBATHE, 0.1, &x);
    ok(TSBatheSetMethod(ts, TSBATHE_METHOD_AUTO));
    ok(TSSetTolerances(ts, 1e9, NULL, 0, NULL));
    script.next = 3 * longest;
    script.shorter = row[k].shorter * longest;
    script.refuses = 1;
    next = WishAfter(ts, row[k].refused * longest);
    for (n = 1; n < 100 && next < 3.5 * longest; n++) next = WishAfter(ts, 3 * longest);
    assert_true(tried[0] == row[k].refused * longest);
    AssertNear(tried[1], k == 2 ? 500 * longest : longest, ROUND);
    assert_in_range(n, row[k].steps[0], row[k].steps[1]);
    ObjectsDestroy(&ts, &x);
  }
}

/* A reaction that was given is that of the start, whatever the method there: a later implicit step from another state
   has its own */
static void test_given(void **state)
{
  const PetscReal back[] = {-0.3, 0, 0}, stale = 100;
  PetscReal w[2][3];

  (void)state;
  for (int given = 0; given < 2; given++) {
    Vec x, other = State(3, back), r = State(1, &stale);
    TS ts = Start(TSBATHE, 0.1, &x);

    ok(TSBatheSetMethod(ts, TSBATHE_METHOD_EXPLICIT));
    if (given) ok(TSBatheSetInitialReaction(ts, r));
    Step(ts, 0.1);
    ok(TSBatheSetMethod(ts, TSBATHE_METHOD_IMPLICIT));
    ok(VecCopy(other, x));
    Step(ts, 0.1);
    Get(x, 3, w[given]);
    ObjectsDestroy(&ts, &x, &other, &r);
  }
  for (int i = 0; i < 3; i++) assert_true(w[0][i] == w[1][i]);
}

SLIP_TESTS_WITH(Register, NULL, test_steps, test_longest, test_failed, test_wish, test_waits, test_given)
