/* Small constraints: the elimination of free rows, operators that are not symmetric, bad input; and the example cases
   built on them against exact solutions. */
#include "models.h"
#include <slipstep/private/slipsnes.h>
#include <math.h>

/* n constant steps over [0, tmax] of a TS that is configured; w holds the start and receives the end */
static void Steps(TS ts, Vec w, PetscReal tmax, PetscInt n)
{
  SetAdapt(ts, TSADAPTNONE);
  ok(TSSetTime(ts, 0));
  ok(TSSetStepNumber(ts, 0));
  ok(TSSetMaxTime(ts, tmax));
  ok(TSSetTimeStep(ts, tmax / n));
  ok(TSSolve(ts, w));
}

static void Get(Vec w, PetscInt n, PetscReal values[])
{
  const PetscScalar *a;

  ok(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < n; i++) values[i] = a[i];
  ok(VecRestoreArrayRead(w, &a));
}

static Vec State(PetscInt n, const PetscReal values[])
{
  Vec w;
  PetscScalar *a;

  ok(VecCreateSeq(PETSC_COMM_SELF, n, &w));
  ok(VecGetArray(w, &a));
  for (PetscInt i = 0; i < n; i++) a[i] = values[i];
  ok(VecRestoreArray(w, &a));
  return w;
}

/* ---- a pendulum with dry friction: its free row is eliminated, its force is nonlinear there ---- */

static PetscReal friction = 0.2;

/* states (angle, rate): the constrained row is the second */
static PetscErrorCode PendulumForce(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  PetscFunctionBeginUser;
  (void)t, (void)ctx;
  F[0] = w[1] + 0.3 * PetscSinReal(w[0]); /* the second term makes the free row nonlinear */
  F[1] = -4 * PetscSinReal(w[0]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PendulumJacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  PetscFunctionBeginUser;
  (void)t, (void)ctx;
  J[0] = 0.3 * PetscCosReal(w[0]);
  J[1] = 1;
  J[2] = -4 * PetscCosReal(w[0]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PendulumBound(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx)
{
  PetscFunctionBeginUser;
  (void)t, (void)dq, (void)w, (void)ctx;
  q[0] = friction;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- two rates with a gyroscopic coupling: a constrained block that is not symmetric ---- */

static const PetscReal gyro[2][2] = {{-1, 3}, {-3, -1}};

static PetscErrorCode GyroForce(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  PetscFunctionBeginUser;
  (void)t, (void)ctx;
  for (PetscInt i = 0; i < 2; i++) F[i] = gyro[i][0] * w[0] + gyro[i][1] * w[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode GyroJacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  PetscFunctionBeginUser;
  (void)t, (void)w, (void)ctx;
  for (PetscInt i = 0; i < 4; i++) J[i] = gyro[i / 2][i % 2];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode GyroBound(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx)
{
  PetscFunctionBeginUser;
  (void)t, (void)w, (void)dq, (void)ctx;
  q[0] = q[1] = friction;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const PetscReal ones[] = {1, 1};
static const PetscInt second[] = {1}, both[] = {0, 1};
static const SlipSmall Pendulum = {2, ones, 1, second, PendulumForce, PendulumJacobian, PendulumBound, NULL};
static const SlipSmall Gyro = {2, ones, 2, both, GyroForce, GyroJacobian, GyroBound, NULL};

/* Classical Runge-Kutta with the friction of rates that keep the signs of the start */
static void RungeKutta(const SlipSmall *p, const PetscReal sign[], PetscReal tmax, PetscInt n, PetscReal w[])
{
  const PetscReal h = tmax / n, at[] = {0, 0.5, 0.5, 1}, weight[] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};

  for (PetscInt step = 0; step < n; step++) {
    PetscReal k[2] = {0, 0}, y[2], sum[2] = {w[0], w[1]};

    for (int s = 0; s < 4; s++) {
      for (int i = 0; i < 2; i++) y[i] = w[i] + at[s] * h * k[i];
      ok(p->force(0, y, k, NULL));
      for (PetscInt j = 0; j < p->nrows; j++) k[p->rows[j]] -= friction * sign[j];
      for (int i = 0; i < 2; i++) sum[i] += h * weight[s] * k[i];
    }
    w[0] = sum[0];
    w[1] = sum[1];
  }
}

static PetscReal SmallError(const SlipSmall *p, const PetscReal start[], const PetscReal exact[], PetscReal tmax,
                            PetscInt n, PetscInt *newton, PetscInt *solves)
{
  TS ts;
  Vec w = State(2, start);
  PetscReal end[2];

  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(SlipSmallConfigureTS(p, ts));
  Steps(ts, w, tmax, n);
  ok(TSBatheGetTotals(ts, NULL, NULL, solves, newton, NULL));
  Get(w, 2, end);
  ObjectsDestroy(&ts, &w);
  return PetscMax(fabs(end[0] - exact[0]), fabs(end[1] - exact[1]));
}

/* Order 2 within 0.1 at steps of 1/20 and less of the motion's own time; the Runge-Kutta solution's error is below
   1e-10 */
static void CheckOrder(const SlipSmall *p, const PetscReal start[], PetscReal tmax, PetscInt *newton, PetscInt *solves)
{
  PetscReal exact[2] = {start[0], start[1]}, sign[2], error[2];

  for (PetscInt j = 0; j < p->nrows; j++) sign[j] = start[p->rows[j]] > 0 ? 1 : -1;
  RungeKutta(p, sign, tmax, 2000, exact);
  for (PetscInt j = 0; j < p->nrows; j++) assert_true(exact[p->rows[j]] * sign[j] > 0); /* nothing has stopped */
  for (int i = 0; i < 2; i++) error[i] = SmallError(p, start, exact, tmax, 40 << i, newton, solves);
  print_message("errors %g %g, order %.3f\n", error[0], error[1], log2(error[0] / error[1]));
  assert_true(error[1] < 1e-4);
  assert_true(fabs(log2(error[0] / error[1]) - 2) < 0.1);
}

static void test_eliminated_row(void **state)
{
  const PetscReal start[] = {-1.2, 0.5};
  PetscInt newton, solves;

  (void)state;
  CheckOrder(&Pendulum, start, 0.8, &newton, &solves);
}

/* The problem is linear while both rates keep their sign: with the true inverse one Newton step solves each of the two
   stages of a step, and at most one more polishes it to rounding. A symmetrised operator would take a dozen. */
static void test_not_symmetric(void **state)
{
  const PetscReal start[] = {1, 2};
  PetscInt newton, solves;

  (void)state;
  CheckOrder(&Gyro, start, 0.15, &newton, &solves);
  assert_true(newton <= 4 * solves);
}

/* Both come to rest and stay: dissipation acts on both, and at rest nothing pushes */
static void test_rest(void **state)
{
  const PetscReal start[] = {1, 2};
  PetscReal end[2];
  TS ts;
  Vec w = State(2, start);

  (void)state;
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(SlipSmallConfigureTS(&Gyro, ts));
  Steps(ts, w, 6, 200);
  Get(w, 2, end);
  assert_true(end[0] == 0 && end[1] == 0);
  ObjectsDestroy(&ts, &w);
}

/* A free state whose balance w^3 - 2 w + 2 - start lets Newton's method go to and fro between 0 and 1 from start 0, as far each time: no state is
   taken for its solution, and the stage fails. From 2 it finds the square root of 2, to rounding. */
static PetscErrorCode CycleForce(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  PetscFunctionBeginUser;
  (void)t, (void)ctx;
  F[0] = w[0] - (w[0] * w[0] * w[0] - 2 * w[0] + 2);
  F[1] = 10 * w[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CycleJacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  PetscFunctionBeginUser;
  (void)t, (void)ctx;
  J[0] = 1 - (3 * w[0] * w[0] - 2);
  J[2] = 10;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static SNES Solver(const SlipSmall *p)
{
  SlipConstraint con;
  SNES snes;

  ok(SlipConstraintCreateSmall(p, &con));
  ok(SNESCreate(PETSC_COMM_SELF, &snes));
  ok(SNESSetType(snes, SNESSEMISMOOTH));
  ok(SNESSetSlipConstraint(snes, con));
  ok(SlipConstraintDestroy(&con));
  return snes;
}

/* A stage of length 1 from a state of n numbers; x is what its one constrained state becomes */
static SNESConvergedReason SolveStage(SNES snes, PetscInt n, const PetscReal start[], PetscReal *x)
{
  SlipStage stage = {.theta = 1, .omega = 1, .base = State(n, start)};
  Vec v = State(1, (const PetscReal[]){0}), r;
  SNESConvergedReason reason;

  ok(VecDuplicate(v, &r));
  ok(SNESSlipSolveStage(snes, &stage, v, r, NULL));
  ok(SNESGetConvergedReason(snes, &reason));
  Get(v, 1, x);
  ObjectsDestroy(&v, &r, &stage.base);
  return reason;
}

static void test_elimination_that_cycles(void **state)
{
  const SlipSmall cycle = {2, ones, 1, second, CycleForce, CycleJacobian, PendulumBound, NULL};
  const PetscReal start[][2] = {{0, 0}, {2, 0}};
  SNES snes = Solver(&cycle);
  PetscReal value;

  (void)state;
  assert_int_equal(SolveStage(snes, 2, start[0], &value), SLIP_SNES_DIVERGED_NAN);
  assert_true(SolveStage(snes, 2, start[1], &value) > 0);
  AssertNear(value, 10 * PetscSqrtReal(2) - friction, 1e-12);
  ok(SNESDestroy(&snes));
}

/* Two free states, the last of which is 0 and found at once. The balance of the first does not depend on it; is not a number, which the
   others do not notice; jumps across 0 at 1, by far more than rounding, or as by rounding; has the root sqrt(2); has a root that iterations
   with its approximate Jacobian approach by a tenth each; or is not a number where the constrained state is beyond 2, as after a full
   step. Where it has no root the constrained state alone would run away. */
enum { SINGULAR, UNKNOWN, JUMPING, ROUNDED, ROOT, ROUGH, BEYOND, BALANCES };

static PetscErrorCode BalanceForce(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  const int k = *(const int *)ctx;
  const PetscReal side = w[0] > 1 ? -1 : 1, x = w[2];
  const PetscReal force[] = {
    w[0], NAN, 1e-4 * side, 1e-10 * side, w[0] - (w[0] * w[0] * w[0] - 2 * w[0] + 2), 0.1 * w[0], x > 2 ? NAN : 0};

  PetscFunctionBeginUser;
  (void)t;
  F[0] = force[k];
  F[1] = 0;
  F[2] = k < ROUNDED ? 2 * x : k < BEYOND ? 10 * w[0] : 1 + friction + 0.7 * x * (1 - x * x);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BalanceJacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  const int k = *(const int *)ctx;

  PetscFunctionBeginUser;
  (void)t;
  J[0] = k == SINGULAR ? 1 : k == ROOT ? 3 - 3 * w[0] * w[0] : 0;
  J[6] = k < ROUNDED || k == BEYOND ? 0 : 10;
  J[8] = k < ROUNDED ? 2 : k < BEYOND ? 0 : 0.7 - 2.1 * w[2] * w[2];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* No state but a solution is taken for one: to 1e-13 of the state in the last iteration, or to what no iteration makes smaller. Points without
   one make steps shorter. */
static void test_eliminated_to_rounding(void **state)
{
  const PetscReal masses[] = {1, 1, 1}, first[BALANCES] = {0, 0, 1, 1, 2, 0.9, 0};
  const PetscReal found[BALANCES] = {NAN, NAN, NAN, 10 - friction, 10 * PetscSqrtReal(2) - friction, 10 - friction, 1};
  const PetscInt third[] = {2};

  (void)state;
  for (int k = 0; k < BALANCES; k++) {
    const SlipSmall balance = {3, masses, 1, third, BalanceForce, BalanceJacobian, PendulumBound, &k};
    const PetscReal start[] = {first[k], 0, 0};
    SNES snes = Solver(&balance);
    PetscReal value;
    const SNESConvergedReason reason = SolveStage(snes, 3, start, &value);

    if (k < ROUNDED)
      assert_int_equal(reason, SLIP_SNES_DIVERGED_NAN);
    else {
      assert_true(reason > 0);
      AssertNear(value, found[k], k == ROUNDED ? 2e-9 : 1e-12);
    }
    ok(SNESDestroy(&snes));
  }
}

/* One state that slides, with the strength 0.2 + 0.1 (x - 1), and G + q = 1.1 (x - 1) plus a rounding of 3e-11, or of -6e-11 just below 1, at which Newton's
   method arrives first: its next step makes the residual three times as large, and what was better is kept, with the strength there. Before, at x = 0, the residual is
   1.2 - 0.1 of G(0) and the strength there. */
static PetscErrorCode RoundedForce(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  const PetscReal x = w[0];

  PetscFunctionBeginUser;
  (void)t, (void)ctx;
  F[0] = 1.2 - (x < 0.5 ? 0 : x < 1 - 1e-12 ? -6e-11 : 3e-11);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RoundedJacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  PetscFunctionBeginUser;
  (void)t, (void)w, (void)J, (void)ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RoundedBound(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx)
{
  PetscFunctionBeginUser;
  (void)t, (void)ctx;
  q[0] = 0.2 + 0.1 * (w[0] - 1);
  if (dq) dq[0] = 0.1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void test_better_point_is_kept(void **state)
{
  const PetscInt only[] = {0};
  const SlipSmall rounded = {1, ones, 1, only, RoundedForce, RoundedJacobian, RoundedBound, NULL};
  SlipStage stage = {.theta = 1, .omega = 1, .base = State(1, (const PetscReal[]){0})};
  Vec x = State(1, (const PetscReal[]){0}), r;
  SNESConvergedReason reason;
  PetscReal value, reaction;
  SNES snes = Solver(&rounded);
  SlipConstraint con;
  Vec w = State(1, (const PetscReal[]){5});

  (void)state;
  ok(VecDuplicate(x, &r));
  ok(SNESGetSlipConstraint(snes, &con));
  ok(SlipConstraintInitialReaction(con, 0, w, r)); /* whose state is none of the stage's */
  ok(SNESSetTolerances(snes, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, 0, PETSC_DEFAULT));
  ok(SNESSlipSolveStage(snes, &stage, x, r, &value));
  AssertNear(value, (1.2 - 0.1) / (1.2 + 0.1), 1e-14);
  ok(SNESSetTolerances(snes, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, 50, PETSC_DEFAULT));
  ok(SNESSlipSolveStage(snes, &stage, x, r, NULL));
  ok(SNESGetConvergedReason(snes, &reason));
  assert_true(reason > 0);
  Get(x, 1, &value);
  Get(r, 1, &reaction);
  AssertNear(value, 1, 1e-15);
  AssertNear(reaction, -0.2 - 0.1 * (value - 1), 1e-16);
  ObjectsDestroy(&snes, &x, &r, &w, &stage.base);
}

/* What steps ask of the constraint: the rows that reactions enter gain a multiple of them, masses divide, in place or not; bounds find
   their derivatives zero and must not be negative. What is left of dG/dx without the free row, whose own entry is 2 - 0.3 cos w, is its Schur
   complement. */
static void test_operations(void **state)
{
  const PetscReal masses[] = {2, 4}, force[] = {6, 20};
  const SlipSmall heavy = {2, masses, 1, second, PendulumForce, PendulumJacobian, PendulumBound, NULL};
  SlipStage stage = {.theta = 1, .omega = 1, .base = State(2, (const PetscReal[]){0.1, 0.2})};
  const SlipConstraintOps *ops;
  PetscReal value[2], q;
  SlipConstraint con;
  Mat B;
  Vec F = State(2, force), k = State(2, force), one = State(1, (const PetscReal[]){3}), bound = State(1, force);

  (void)state;
  ok(SlipConstraintCreateSmall(&heavy, &con));
  ops = con->ops;
  ok((*ops->add_reaction)(con, -2, one, F, con->ctx));
  Get(F, 2, value);
  assert_true(value[0] == 6 && value[1] == 14);
  ok((*ops->solve_mass)(con, F, k, con->ctx));
  Get(k, 2, value);
  assert_true(value[0] == 3 && value[1] == 3.5);
  ok((*ops->solve_mass)(con, F, F, con->ctx));
  Get(F, 2, value);
  assert_true(value[0] == 3 && value[1] == 3.5);
  ok((*ops->stage)(con, &stage, con->ctx));
  ok((*ops->bound)(con, one, bound, one, con->ctx));
  Get(bound, 1, &q);
  Get(one, 1, value);
  assert_true(q == friction && value[0] == 0);
  ok((*ops->lift)(con, one, F, con->ctx));
  ok((*ops->jacobian)(con, one, &B, con->ctx));
  Get(F, 2, value);
  ok(MatGetValue(B, 0, 0, &q));
  AssertNear(q, 4 - 4 * PetscCosReal(value[0]) * (-1) / (2 - 0.3 * PetscCosReal(value[0])), 1e-13);
  friction = -0.1;
  fails((*ops->bound_state)(con, 0, k, bound, con->ctx), "The bound of reaction 0 is -0.1 at time 0");
  friction = 0.2;
  ObjectsDestroy(&F, &k, &one, &bound, &stage.base);
  ok(SlipConstraintDestroy(&con));
}

static void test_bad_input(void **state)
{
  const PetscReal massless[] = {1, 0};
  const PetscInt descending[] = {1, 0}, outside[] = {2};
  SlipSmall bad[5] = {Gyro, Gyro, Gyro, Gyro, Gyro};
  SlipConstraint con;

  (void)state;
  bad[0].mass = massless;
  bad[1].rows = descending;
  bad[2].rows = outside;
  bad[2].nrows = 1;
  bad[3].nrows = 0;
  bad[4].jacobian = NULL;
  ok(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  for (int i = 0; i < 5; i++)
    assert_int_equal((int)SlipConstraintCreateSmall(&bad[i], &con),
                     i < 4 ? PETSC_ERR_ARG_OUTOFRANGE : PETSC_ERR_ARG_NULL);
  ok(PetscPopErrorHandler());
  ok(SlipConstraintCreateSmall(&Gyro, &con));
  fails(SlipConstraintSetComponents(con, 2, NULL), "have one component each, expected 1, not 2");
  ok(SlipConstraintDestroy(&con));
}

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
  (void)state;
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

  PetscFunctionBeginUser;
  (void)ts;
  if (step < 0) PetscFunctionReturn(PETSC_SUCCESS);
  Get(w, 1, &value);
  exact = Exact(a->m, time, &r);
  a->largest = PetscMax(a->largest, fabs(value - exact));
  a->stuck += exact == 0 && value == 0;
  a->up += exact > 0;
  a->down += exact < 0;
  PetscFunctionReturn(PETSC_SUCCESS);
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

  (void)state;
  m->D = 2.5;
  m->model.start[0] = -0.01;
  ok(SlipModelSetUp(&m->model));
  ok(SlipModelCreateState(&m->model, &w));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(SlipModelConfigureTS(&m->model, ts));
  ok(TSMonitorSet(ts, Compare, &a, NULL));
  Steps(ts, w, 0.5, 50000);
  print_message("largest error %g; stuck %d, up %d, down %d\n", a.largest, (int)a.stuck, (int)a.up, (int)a.down);
  assert_true(a.stuck > 5000 && a.up > 5000 && a.down > 5000);
  assert_true(a.largest < 9e-5);
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

  (void)state;
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
  print_message("order %.3f before the arrest, largest error %g with it\n", log2(before[0] / before[1]), a.largest);
  assert_true(fabs(log2(before[0] / before[1]) - 2) < 0.05);
  assert_true(a.largest < (m->k + m->D) * 1e-3);
  assert_true(end == 0);
  assert_true(fabs(r + m->D * sin(m->omega * 0.5)) < 1e-12);
  DestroyModel(&m->model);
}

/* The default observations of a policy, in the units of the start */
static void test_sliding_mode_observe(void **state)
{
  SlipSlidingMode *m = SlidingMode(SLIP_MODEL_EVALUATION);
  const PetscReal w = -0.5 * m->model.start[0];

  (void)state;
  assert_true(fabs(ObserveModel(&m->model, &w, "energy") - 0.25) < 1e-15);
  assert_true(fabs(ObserveModel(&m->model, &w, "state_0") + 0.5) < 1e-15);
  assert_int_equal(-1, (int)SlipModelFindObservation(&m->model, "state_1"));
  DestroyModel(&m->model);
}

/* ---- the circuit ---- */

typedef struct {
  SlipCircuit *c;
  PetscReal time, energy, power, dissipated, rise;
} Balance;

static PetscErrorCode Watch(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  Balance *b = (Balance *)ctx;
  PetscReal a[CIRCUIT_N], energy, power;

  PetscFunctionBeginUser;
  (void)ts;
  if (step < 0) PetscFunctionReturn(PETSC_SUCCESS);
  Get(w, CIRCUIT_N, a);
  energy = SlipModelEnergy(&b->c->model, a);
  power = PetscSqr(a[0] - a[1]) / b->c->R + b->c->m * PetscAbsReal(a[0]);
  if (step > 0) {
    b->rise = PetscMax(b->rise, energy - b->energy);
    b->dissipated += 0.5 * (time - b->time) * (b->power + power);
  }
  b->time = time;
  b->energy = energy;
  b->power = power;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* n constant steps: what is left of the energy, its largest rise and what the balance lacks, all over the start's
   energy */
static void CircuitBalance(int which, PetscInt n, PetscReal *left, PetscReal *rise, PetscReal *lacks)
{
  Balance b = {.time = 0};
  PetscReal start;
  SlipModel model;
  TS ts;
  Vec w;

  ok(SlipModelCreate(&SlipCircuitOps, (SlipModelCase)which, &model));
  b.c = (SlipCircuit *)model;
  start = SlipModelEnergy(model, model->start);
  ok(SlipModelCreateState(model, &w));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(SlipModelConfigureTS(model, ts));
  ok(TSMonitorSet(ts, Watch, &b, NULL));
  Steps(ts, w, model->max_time, n);
  *left = b.energy / start;
  *rise = b.rise / start;
  *lacks = fabs(start - b.energy - b.dissipated) / start;
  ObjectsDestroy(&ts, &w);
  ok(SlipModelDestroy(&model));
}

/* The energy never rises by more than rounding, and what is lost is what resistor and diode take. Integrator and
   quadrature are of second order but for the kinks where V1 meets zero: a step four times shorter must gain a factor of
   8 of the 16, and leave (h/(R C1))^2 = 6e-5, here 1e-4. */
static void test_circuit_energy(void **state)
{
  (void)state;
  for (int i = 0; i < 2; i++) {
    PetscReal left, rise[2], lacks[2];

    CircuitBalance(i, 4000, &left, &rise[0], &lacks[0]);
    CircuitBalance(i, 16000, &left, &rise[1], &lacks[1]);
    print_message("energy left %g, balance lacks %g and %g\n", left, lacks[0], lacks[1]);
    assert_true(rise[0] <= 1e-12 && rise[1] <= 1e-12);
    assert_true(left < 0.1);
    assert_true(lacks[1] < 1e-4);
    assert_true(lacks[0] > 8 * lacks[1]);
  }
}

/* Of the energy's units the squares of the states add up to U/U_0; in the start's every state begins at 1 */
static void test_circuit_observe(void **state)
{
  const char *const names[] = {"state_0", "state_1", "state_2", "energy"};
  PetscReal sum = 0;
  SlipModel model;

  (void)state;
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

SLIP_TESTS(test_eliminated_row, test_not_symmetric, test_rest, test_elimination_that_cycles,
           test_eliminated_to_rounding, test_operations, test_better_point_is_kept, test_bad_input, test_exact_arrest,
           test_exact_departures, test_sliding_mode_order, test_sliding_mode_observe, test_circuit_energy,
           test_circuit_observe)
