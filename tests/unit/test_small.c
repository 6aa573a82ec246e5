/* Small constraints: the elimination of free rows, operators that are not symmetric, bad input. */
#include "smallsteps.h"
#include <slipstep/private/slipsnes.h>
#include <math.h>

/* ---- a pendulum with dry friction: its free row is eliminated, its force is nonlinear there ---- */

static PetscReal friction = 0.2;

/* states (angle, rate): the constrained row is the second */
static PetscErrorCode PendulumForce(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  F[0] = w[1] + 0.3 * PetscSinReal(w[0]); /* the second term makes the free row nonlinear */
  F[1] = -4 * PetscSinReal(w[0]);
  return PETSC_SUCCESS;
}

static PetscErrorCode PendulumJacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  J[0] = 0.3 * PetscCosReal(w[0]);
  J[1] = 1;
  J[2] = -4 * PetscCosReal(w[0]);
  return PETSC_SUCCESS;
}

static PetscErrorCode PendulumBound(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx)
{
  q[0] = friction;
  return PETSC_SUCCESS;
}

/* ---- two rates with a gyroscopic coupling: a constrained block that is not symmetric ---- */

static const PetscReal gyro[2][2] = {{-1, 3}, {-3, -1}};

static PetscErrorCode GyroForce(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  for (PetscInt i = 0; i < 2; i++) F[i] = gyro[i][0] * w[0] + gyro[i][1] * w[1];
  return PETSC_SUCCESS;
}

static PetscErrorCode GyroJacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  for (PetscInt i = 0; i < 4; i++) J[i] = gyro[i / 2][i % 2];
  return PETSC_SUCCESS;
}

static PetscErrorCode GyroBound(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx)
{
  q[0] = q[1] = friction;
  return PETSC_SUCCESS;
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
  for (PetscInt j = 0; j < p->nrows; j++) AssertLess(0, exact[p->rows[j]] * sign[j]); /* nothing has stopped */
  for (int i = 0; i < 2; i++) error[i] = SmallError(p, start, exact, tmax, 40 << i, newton, solves);
  AssertLess(error[1], 1e-4);
  AssertNear(log2(error[0] / error[1]), 2, 0.1);
}

static void test_eliminated_row(void **state)
{
  const PetscReal start[] = {-1.2, 0.5};
  PetscInt newton, solves;

  CheckOrder(&Pendulum, start, 0.8, &newton, &solves);
}

/* The problem is linear while both rates keep their sign: with the true inverse one Newton step solves each of the two
   stages of a step, and at most one more polishes it to rounding. A symmetrised operator would take a dozen. */
static void test_not_symmetric(void **state)
{
  const PetscReal start[] = {1, 2};
  PetscInt newton, solves;

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

  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(SlipSmallConfigureTS(&Gyro, ts));
  Steps(ts, w, 6, 200);
  Get(w, 2, end);
  assert_true(end[0] == 0 && end[1] == 0);
  ObjectsDestroy(&ts, &w);
}

/* A free state whose balance w^3 - 2 w + 2 - start lets Newton's method go to and fro between 0 and 1 from start 0, as
   far each time: no state is taken for its solution, and the stage fails. From 2 it finds the square root of 2, to
   rounding. */
static PetscErrorCode CycleForce(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  F[0] = w[0] - (w[0] * w[0] * w[0] - 2 * w[0] + 2);
  F[1] = 10 * w[0];
  return PETSC_SUCCESS;
}

static PetscErrorCode CycleJacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  J[0] = 1 - (3 * w[0] * w[0] - 2);
  J[2] = 10;
  return PETSC_SUCCESS;
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

  assert_int_equal(SolveStage(snes, 2, start[0], &value), SLIP_SNES_DIVERGED_NAN);
  assert_true(SolveStage(snes, 2, start[1], &value) > 0);
  AssertNear(value, 10 * PetscSqrtReal(2) - friction, 1e-12);
  ok(SNESDestroy(&snes));
}

/* Two free states, the last of which is 0 and found at once. The balance of the first does not depend on it; is not a
   number, which the others do not notice; jumps across 0 at 1, by far more than rounding, or as by rounding; has the
   root sqrt(2); has a root that iterations with its approximate Jacobian approach by a tenth each; or is not a number
   where the constrained state is beyond 2, as after a full step. Where it has no root the constrained state alone would
   run away. */
enum { SINGULAR, UNKNOWN, JUMPING, ROUNDED, ROOT, ROUGH, BEYOND, BALANCES };

static PetscErrorCode BalanceForce(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  const int k = *(const int *)ctx;
  const PetscReal side = w[0] > 1 ? -1 : 1, x = w[2];
  const PetscReal force[] = {
    w[0], NAN, 1e-4 * side, 1e-10 * side, w[0] - (w[0] * w[0] * w[0] - 2 * w[0] + 2), 0.1 * w[0], x > 2 ? NAN : 0};

  F[0] = force[k];
  F[1] = 0;
  F[2] = k < ROUNDED ? 2 * x : k < BEYOND ? 10 * w[0] : 1 + friction + 0.7 * x * (1 - x * x);
  return PETSC_SUCCESS;
}

static PetscErrorCode BalanceJacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  const int k = *(const int *)ctx;

  J[0] = k == SINGULAR ? 1 : k == ROOT ? 3 - 3 * w[0] * w[0] : 0;
  J[6] = k < ROUNDED || k == BEYOND ? 0 : 10;
  J[8] = k < ROUNDED ? 2 : k < BEYOND ? 0 : 0.7 - 2.1 * w[2] * w[2];
  return PETSC_SUCCESS;
}

/* No state but a solution is taken for one: to 1e-13 of the state in the last iteration, or to what no iteration makes
   smaller. Points without one make steps shorter. */
static void test_eliminated_to_rounding(void **state)
{
  const PetscReal masses[] = {1, 1, 1}, first[BALANCES] = {0, 0, 1, 1, 2, 0.9, 0};
  const PetscReal found[BALANCES] = {NAN, NAN, NAN, 10 - friction, 10 * PetscSqrtReal(2) - friction, 10 - friction, 1};
  const PetscInt third[] = {2};

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

/* One state that slides, with the strength 0.2 + 0.1 (x - 1), and G + q = 1.1 (x - 1) plus a rounding of 3e-11, or of
   -6e-11 just below 1, at which Newton's method arrives first: its next step makes the residual three times as large,
   and what was better is kept, with the strength there. Before, at x = 0, the residual is 1.2 - 0.1 of G(0) and the
   strength there. */
static PetscErrorCode RoundedForce(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  const PetscReal x = w[0];

  F[0] = 1.2 - (x < 0.5 ? 0 : x < 1 - 1e-12 ? -6e-11 : 3e-11);
  return PETSC_SUCCESS;
}

static PetscErrorCode RoundedJacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  return PETSC_SUCCESS;
}

static PetscErrorCode RoundedBound(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx)
{
  q[0] = 0.2 + 0.1 * (w[0] - 1);
  if (dq) dq[0] = 0.1;
  return PETSC_SUCCESS;
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

/* What steps ask of the constraint: the rows that reactions enter gain a multiple of them, masses divide, in place or
   not; bounds find their derivatives zero and must not be negative. What is left of dG/dx without the free row, whose
   own entry is 2 - 0.3 cos w, is its Schur complement. */
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

  bad[0].mass = massless;
  bad[1].rows = descending;
  bad[2].rows = outside;
  bad[2].nrows = 1;
  bad[3].nrows = 0;
  bad[4].jacobian = NULL;
  for (int i = 0; i < 5; i++)
    assert_int_equal((int)SlipConstraintCreateSmall(&bad[i], &con),
                     i < 4 ? PETSC_ERR_ARG_OUTOFRANGE : PETSC_ERR_ARG_NULL);
  ok(SlipConstraintCreateSmall(&Gyro, &con));
  fails(SlipConstraintSetComponents(con, 2, NULL), "have one component each, expected 1, not 2");
  { /* integrators that know no constraint, with the solver of one that does */
    const TSType other[] = {TSBDF, TSCN, TSBEULER};

    for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(other); i++) {
      TS ts;
      Vec w;

      ok(VecCreateSeq(PETSC_COMM_SELF, Gyro.n, &w));
      ok(VecSet(w, 1));
      ok(TSCreate(PETSC_COMM_SELF, &ts));
      ok(TSSetType(ts, TSBATHE));
      ok(TSBatheSetConstraint(ts, con));
      ok(TSSetRHSFunction(ts, NULL, TSComputeRHSFunctionLinear, NULL));
      ok(TSSetType(ts, other[i]));
      ok(TSSetTimeStep(ts, 0.1));
      ok(TSSetMaxTime(ts, 1));
      ok(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_STEPOVER));
      fails(TSSolve(ts, w), "which -ts_type bathe and moreau have and no other");
      ObjectsDestroy(&ts, &w);
    }
  }
  ok(SlipConstraintDestroy(&con));
}

/* ---- a block on a belt whose friction falls with the square of the sliding rate ---- */

static PetscInt calls; /* of BeltForce(), and of StiffForce() */

/* states (spring's extension, rate over the belt's) */
static PetscErrorCode BeltForce(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  calls++;
  F[0] = w[1] + 0.1;
  F[1] = -100 * w[0];
  return PETSC_SUCCESS;
}

static PetscErrorCode BeltJacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  J[1] = 1;
  J[2] = -100;
  return PETSC_SUCCESS;
}

/* 4 at rest, where its derivative is 0, and 2 at once or within 0.02 */
static PetscErrorCode BeltBound(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx)
{
  const PetscReal x = PetscAbsReal(w[1]) / 0.02, fall = PetscExpReal(-x * x);

  if (*(PetscBool *)ctx) {
    q[0] = w[1] == 0 ? 4 : 2;
  } else {
    q[0] = 2 + 2 * fall;
    if (dq) dq[0] = -4 * x / 0.02 * fall;
  }
  return PETSC_SUCCESS;
}

static PetscErrorCode CountDepartures(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  PetscInt *count = (PetscInt *)ctx; /* and whether it rested */
  PetscReal at[2];

  Get(w, 2, at);
  if (step > 0 && count[1] && at[1] != 0) count[0]++;
  count[1] = at[1] == 0;
  return PETSC_SUCCESS;
}

/* Steps of 1 and of 27 ms from rest at 0: the spring is loaded to 4 in 0.4 s; of the slips that follow twelve begin
   within 10 s, by Bathe's stages and by explicit steps, whether the strength falls smoothly or at once. */
static void test_belt(void **state)
{
  static const char *const types[] = {TSMOREAU, TSBATHE};
  const PetscReal mass[] = {1, 1}, start[] = {0, 0}, end = 10;
  const PetscInt rows[] = {1};

  for (int jump = 0; jump < 2; jump++)
    for (int k = 0; k < 4; k++) {
      PetscBool jumps = jump ? PETSC_TRUE : PETSC_FALSE;
      const SlipSmall belt = {2, mass, 1, rows, BeltForce, BeltJacobian, BeltBound, &jumps};
      PetscInt count[2] = {0, 0};
      Vec w = State(2, start);
      TS ts;

      ok(TSCreate(PETSC_COMM_SELF, &ts));
      ok(SlipSmallConfigureTS(&belt, ts));
      ok(TSSetType(ts, types[k / 2]));
      ok(TSMonitorSet(ts, CountDepartures, count, NULL));
      Steps(ts, w, end, k % 2 ? 370 : 10000);
      assert_int_equal(count[0], 12);
      ObjectsDestroy(&ts, &w);
    }
}

/* ---- the method that is the default ---- */

/* The block on a dashpot of a million: an explicit step is stable up to a few microseconds. */
static PetscErrorCode StiffForce(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  PetscCall(BeltForce(t, w, F, ctx));
  F[1] -= 1e6 * w[1];
  return PETSC_SUCCESS;
}

static PetscErrorCode StiffJacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  PetscCall(BeltJacobian(t, w, J, ctx));
  J[3] = -1e6;
  return PETSC_SUCCESS;
}

/* The spring's extension after 10 s, and the method that was chosen; type, adapt: NULL for the default */
static PetscReal BeltEnd(PetscBool stiff, const char type[], const char adapt[], PetscReal dt, TSBatheMethod *method)
{
  const PetscReal mass[] = {1, 1}, start[] = {0, 0};
  const PetscInt rows[] = {1};
  PetscBool jumps = PETSC_FALSE;
  const SlipSmall belt = {.n = 2,
                          .mass = mass,
                          .nrows = 1,
                          .rows = rows,
                          .force = stiff ? StiffForce : BeltForce,
                          .jacobian = stiff ? StiffJacobian : BeltJacobian,
                          .bound = BeltBound,
                          .ctx = &jumps};
  PetscReal at[2];
  Vec w = State(2, start);
  TSAdapt control;
  TS ts;

  calls = 0;
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(SlipSmallConfigureTS(&belt, ts));
  if (type) ok(TSSetType(ts, type));
  ok(TSGetAdapt(ts, &control));
  if (adapt) ok(TSAdaptSetType(control, adapt));
  ok(TSSetTolerances(ts, 1e-6, NULL, 1e-6, NULL));
  ok(TSSetTimeStep(ts, dt));
  ok(TSSetMaxTime(ts, 10));
  ok(TSSetFromOptions(ts));
  ok(TSSolve(ts, w));
  ok(TSBatheGetMethod(ts, method));
  Get(w, 2, at);
  ObjectsDestroy(&ts, &w);
  return at[0];
}

/* Each step is explicit where that costs less: a third of the forces and fewer of implicit steps that keep the same
   tolerance, with an error of a hundredth of the swing, 0.06, after twelve slips. A stiff one takes no step of
   microseconds. Constant steps are as they were. */
static void test_default_method(void **state)
{
  const PetscReal exact = BeltEnd(PETSC_FALSE, TSMOREAU, TSADAPTNONE, 2e-5, &(TSBatheMethod){0});
  PetscReal at;
  TSBatheMethod method;
  PetscInt explicits;

  at = BeltEnd(PETSC_FALSE, NULL, NULL, 1e-4, &method);
  assert_int_equal(method, TSBATHE_METHOD_AUTO);
  assert_true(PetscAbsReal(at - exact) < 6e-4);
  explicits = calls;
  ok(PetscOptionsSetValue(NULL, "-ts_bathe_method", "implicit"));
  at = BeltEnd(PETSC_FALSE, NULL, NULL, 1e-4, &method);
  ok(PetscOptionsClearValue(NULL, "-ts_bathe_method"));
  assert_int_equal(method, TSBATHE_METHOD_IMPLICIT);
  assert_true(PetscAbsReal(at - exact) < 6e-4);
  assert_true(3 * explicits < calls);
  at = BeltEnd(PETSC_FALSE, NULL, TSADAPTNONE, 1e-3, &method);
  assert_int_equal(method, TSBATHE_METHOD_IMPLICIT);
  assert_true(PetscAbsReal(at - exact) < 6e-4);
  at = BeltEnd(PETSC_TRUE, NULL, NULL, 1e-4, &method);
  assert_true(calls < 10000);
}

SLIP_TESTS(test_default_method, test_belt, test_eliminated_row, test_not_symmetric, test_rest,
           test_elimination_that_cycles, test_eliminated_to_rounding, test_operations, test_better_point_is_kept,
           test_bad_input)
