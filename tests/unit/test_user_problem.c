/* Training on a user's table (sliptrain.h): tables and TSs that are refused, and runs that go back to the start, fail
   or never end. */
#include "unit.h"
#include "problems/episodes.h"
#include "sliptrain.h"

/* dw/dt = -w from 1 */
typedef enum { GOOD, EULER, ENDLESS, LONG, FAILING } Kind;
static Kind kind;
static int alive;

static PetscErrorCode Force(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  F[0] = kind == FAILING && t > 0.5 ? (PetscReal)NAN : -w[0];
  return PETSC_SUCCESS;
}

static PetscErrorCode Jacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  J[0] = -1;
  return PETSC_SUCCESS;
}

static PetscErrorCode Bound(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx)
{
  q[0] = 0;
  return PETSC_SUCCESS;
}

static PetscErrorCode Draw(uint64_t seed, void **instance, TS *ts, Vec *w)
{
  const PetscReal mass[] = {1};
  const PetscInt rows[] = {0};
  const SlipSmall problem = {
    .n = 1, .mass = mass, .nrows = 1, .rows = rows, .force = Force, .jacobian = Jacobian, .bound = Bound};

  PetscCall(TSCreate(PETSC_COMM_SELF, ts));
  PetscCall(SlipSmallConfigureTS(&problem, *ts));
  if (kind == EULER) PetscCall(TSSetType(*ts, TSBEULER));
  if (kind != ENDLESS) PetscCall(TSSetMaxTime(*ts, kind == LONG ? 1e4 : 1));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, 1, w));
  PetscCall(VecSet(*w, 1));
  PetscCall(TSSetSolution(*ts, *w));
  PetscCall(PetscObjectDereference((PetscObject)*w)); /* the TS has it */
  *instance = *ts;
  alive++;
  return PETSC_SUCCESS;
}

static PetscErrorCode Error(void *instance, TS ts, Vec w, PetscReal *error)
{
  assert_ptr_equal(instance, ts);
  PetscCall(VecNorm(w, NORM_2, error));
  *error = PetscAbsReal(*error - PetscExpReal(-1));
  return PETSC_SUCCESS;
}

static PetscErrorCode Destroy(void **instance)
{
  PetscCall(TSDestroy((TS *)instance));
  alive--;
  return PETSC_SUCCESS;
}

static const char *const names[] = {"log_accuracy", "log_time_left", NULL};
static const SlipTrainProblem Decay = {"decay", Draw, Error, Destroy, names, 0.01, 1};
static const Problem row = {.name = "decay", .cma = &CMAUser, .user = &Decay};
static const CMAOptions options = {.problem = &row};

/* Steps that follow the dial only */
static SlipPolicy Policy(void)
{
  const PetscReal scale[] = {1, 1}, zero[] = {0, 0}, weight[] = {0.25, 0}, bias[] = {0.5};
  SlipPolicy p;

  ok(SlipPolicyCreate(PETSC_COMM_SELF, &p));
  ok(SlipPolicySetObservations(p, 2, names, scale, zero));
  ok(SlipPolicyAddLayer(p, 2, 1, weight, bias, SLIP_ACTIVATION_LINEAR));
  ok(SlipPolicySetAction(p, -1, 1, Decay.dt_min, "T*", Decay.dt_max, "T*", PETSC_TRUE));
  return p;
}

static void test_wrong_tables(void **state)
{
  SlipTrainProblem p;

  p = Decay, p.name = NULL;
  assert_int_equal(SlipTrain(PETSC_COMM_SELF, &p), PETSC_ERR_ARG_NULL);
  p = Decay, p.draw = NULL;
  assert_int_equal(SlipTrain(PETSC_COMM_SELF, &p), PETSC_ERR_ARG_NULL);
  p = Decay, p.error = NULL;
  assert_int_equal(SlipTrain(PETSC_COMM_SELF, &p), PETSC_ERR_ARG_NULL);
  p = Decay, p.destroy = NULL;
  assert_int_equal(SlipTrain(PETSC_COMM_SELF, &p), PETSC_ERR_ARG_NULL);
  p = Decay, p.observations = NULL;
  assert_int_equal(SlipTrain(PETSC_COMM_SELF, &p), PETSC_ERR_ARG_NULL);
  p = Decay, p.dt_max = p.dt_min;
  assert_int_equal(SlipTrain(PETSC_COMM_SELF, &p), PETSC_ERR_ARG_OUTOFRANGE);
}

static void test_wrong_ts(void **state)
{
  void *e;

  kind = EULER;
  assert_int_equal((*CMAUser.create)(&options, 1, 1, &e), PETSC_ERR_ARG_WRONG);
  kind = ENDLESS;
  assert_int_equal((*CMAUser.create)(&options, 1, 1, &e), PETSC_ERR_ARG_OUTOFRANGE);
  alive = 0; /* a training ends there */
}

/* Every run begins at the start: the same bits, whatever ran before it. The composite method's error of decay over one
   time unit in steps h is below h^2. */
static void test_runs_repeat(void **state)
{
  SlipPolicy policy = Policy();
  EpisodeResult a, b, c;
  void *e;

  kind = GOOD;
  ok((*CMAUser.create)(&options, 1, 1, &e));
  ok((*CMAUser.run)(e, policy, 1e-1, &a));
  ok((*CMAUser.run)(e, policy, 1e-3, &b));
  ok((*CMAUser.run)(e, policy, 1e-1, &c));
  assert_true(a.done == 1 && b.done == 1 && a.failures == 0);
  assert_true(b.solves > a.solves && b.error < a.error && a.error > 0 && a.error < 1. / PetscSqr(a.solves - 1));
  assert_int_equal(a.solves, c.solves);
  assert_true(a.error == c.error);
  ok((*CMAUser.destroy)(&e));
  ok(SlipPolicyDestroy(&policy));
  assert_int_equal(alive, 0);
}

/* Neither ends a training; both cost more than a run that ends. */
static void test_runs_that_do_not_end(void **state)
{
  SlipPolicy policy = Policy();
  EpisodeResult r;
  void *e;

  kind = LONG; /* 400 steps of 1 s at most */
  ok((*CMAUser.create)(&options, 1, 1, &e));
  ok((*CMAUser.run)(e, policy, 1e-1, &r));
  assert_true(r.solves == EPISODE_MAX_STEPS && r.done < 0.05 && r.cost > 10);
  ok((*CMAUser.destroy)(&e));
  kind = FAILING; /* from half way */
  ok((*CMAUser.create)(&options, 1, 1, &e));
  for (int i = 0; i < 2; ++i) {
    ok((*CMAUser.run)(e, policy, 1e-1, &r));
    assert_true(r.done < 0.6 && r.failures > 0 && r.cost > 10);
  }
  ok((*CMAUser.destroy)(&e));
  ok(SlipPolicyDestroy(&policy));
}

SLIP_TESTS(test_wrong_tables, test_wrong_ts, test_runs_repeat, test_runs_that_do_not_end)
