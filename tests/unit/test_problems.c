/* The table of problems that policies are trained on: episodes of each, their observations, errors and effects. */
#include "unit.h"
#include "study/trainer.h"
#include "problems/problems.h"

static TrainOptions Options(const char text[])
{
  TrainOptions o;

  ok(SetOptions(text));
  ok(TrainOptionsSet(PETSC_COMM_SELF, &o));
  return o;
}

/* An actor that always answers the same and remembers what it was told. */
typedef struct {
  PetscReal action, first[ENV_MAX_OBS], reward, largest;
  PetscInt nobs, calls;
} Constant;

static PetscErrorCode Act(const EnvMoment *m, PetscReal *action, PetscBool *stop, void *ctx)
{
  Constant *c = (Constant *)ctx;

  if (m->first) PetscCall(PetscArraycpy(c->first, m->obs, c->nobs));
  c->reward += m->reward;
  c->calls++;
  *action = c->action;
  return PETSC_SUCCESS;
}

/* One run with a constant action of the problem of the options */
static EnvResult Run(const TrainOptions *o, PetscBool reference, PetscReal action, Constant *c)
{
  Environment env;
  EnvInstance instance;
  EnvResult r;

  *c = (Constant){.action = action, .nobs = o->env.nobs};
  ok(EnvCreate(&o->env, &env));
  ok(EnvInstanceCreate(&o->env, NULL, reference, &instance));
  ok(EnvRunInstance(&env, &instance, Act, c, &r));
  ok(EnvInstanceDestroy(&o->env, &instance));
  assert_true(r.finished);
  assert_int_equal(c->calls, r.attempts + 1);
  assert_int_equal(r.solves, r.attempts); /* no doubling */
  return r;
}

/* What policies see before the first step, unscaled: the study's observations, with the library's start of the last
   attempt's row. */
static void test_first_observations(void **state)
{
  const struct {
    const char *options;
    PetscInt n;
    PetscReal value[8];
  } rows[] = {{"-train_problem sliding_mode", 6, {1, 1, 0.5, 0, 0, -0.5}},
              {"-train_problem circuit -circuit_unit start", 8, {1, 1, 1, 1, 0.5, 0, 0, -0.5}},
              {"-train_problem fault", 6, {1, 0, 0.5, 0, 0, -0.5}}};
  Constant c;

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(rows); ++k) {
    TrainOptions o = Options(rows[k].options);

    assert_int_equal(o.env.nobs, rows[k].n);
    (void)Run(&o, PETSC_FALSE, -0.9, &c);
    /* the fault starts with 1e-5 more than the critical displacement */
    for (PetscInt i = 0; i < rows[k].n; ++i) assert_true(fabs(c.first[i] - rows[k].value[i]) < 3e-5);
    ok(TrainOptionsFree(&o));
  }
}

/* Without a reward and a reference, as an algorithm that needs neither runs episodes. */
static void test_bare_runs(void **state)
{
  for (PetscInt k = 0; ProblemTable[k]; ++k) {
    char text[64];
    TrainOptions o;
    Constant c;
    EnvResult r;

    if (!ProblemTable[k]->create) continue;
    ok(PetscSNPrintf(text, sizeof(text), "-train_problem %s -train_reward balanced", ProblemTable[k]->name));
    o = Options(text);
    o.env.reward = NULL;
    r = Run(&o, PETSC_FALSE, 0.2, &c);
    assert_true(c.reward == 0 && r.total == 0);
    for (PetscInt i = 0; i < ENV_MAX_ERRORS; ++i) assert_true(isnan(r.error[i]));
    ok(TrainOptionsFree(&o));
  }
}

/* Errors fall with the square of the step: the circuit away from its corners, whose share is of the same order. */
static void test_errors_are_of_second_order(void **state)
{
  /* log spacing: h = 0.1 T* (2 s/0.1 T*)^((a + 1)/2); twice the difference of actions is a factor of two */
  TrainOptions o = Options("-train_problem circuit -train_reward accuracy -circuit_case evaluation -circuit_m 0");
  const PetscReal span = log(2.0 / (0.1 * sqrt(1. / 7))), halving = 2 * log(2) / span,
                  action = 2 * log(0.1 / (0.1 * sqrt(1. / 7))) / span - 1;
  PetscReal coarse, fine;
  Constant c;

  coarse = Run(&o, PETSC_TRUE, action, &c).error[0];
  fine = Run(&o, PETSC_TRUE, action - halving, &c).error[0];
  /* 4 within a tenth: the next order is h^3, and h is 0.1 s of an oscillation of 2.4 s */
  assert_true(coarse / fine > 3.6 && coarse / fine < 4.4);
  ok(TrainOptionsFree(&o));
}

/* The errors that the steps leave bound that of the run, and it is not known better than by a few times. The L2 error
   is that of the program's measure: relative to the exact solution here. */
static void test_effects_bound_the_error(void **state)
{
  TrainOptions o = Options("-train_problem sliding_mode -train_reward accuracy -train_alpha 1");
  PetscReal left, square = 0, reaction, bound;
  const PetscInt n = 1000;
  SlipModel m;
  EnvResult r;
  Constant c;

  ok(SlipModelCreate(&SlipSlidingModeOps, SLIP_MODEL_TRAINING, &m));
  r = Run(&o, PETSC_TRUE, 0.5, &c);
  left = (-r.total - 0.25 * r.attempts) / 50; /* sum of errors left, over the start: 50 is their weight */
  for (PetscInt i = 0; i < n; ++i) square += PetscSqr((*m->ops->exact)(m, 0.5 * (i + 0.5) / n, &reaction)) / n;
  bound = left * m->start[0] / sqrt(square);
  ok(SlipModelDestroy(&m));
  assert_true(r.error[0] > 0 && r.error[0] < bound);
  assert_true(r.error[0] > bound / 50);
  ok(TrainOptionsFree(&o));
}

/* Random instances: within their ranges, the same for the same seed, and they run. */
static void test_draws(void **state)
{
  for (PetscInt k = 0; ProblemTable[k]; ++k) {
    const Problem *p = ProblemTable[k];
    PetscReal a[ENV_MAX_DRAW], b[ENV_MAX_DRAW];
    char text[96];
    TrainOptions o;
    Environment env;
    EnvResult r;
    Random r1, r2;

    if (!p->create) continue;
    Constant c = {.action = 0};

    RandomSeed(&r1, 4);
    RandomSeed(&r2, 4);
    for (int i = 0; i < 100; ++i) {
      ok(ProblemDraw(p, &r1, a));
      ok(ProblemDraw(p, &r2, b));
      for (PetscInt j = 0; j < p->ndraw; ++j)
        assert_true(a[j] == b[j] && a[j] >= p->draw[j].low && a[j] <= p->draw[j].high);
    }
    ok(PetscSNPrintf(text, sizeof(text), "-train_problem %s -train_reward balanced -train_random", p->name));
    o = Options(text);
    c.nobs = o.env.nobs;
    ok(EnvCreate(&o.env, &env));
    for (int i = 0; i < 3; ++i) {
      ok(EnvRunEpisode(&env, &r1, Act, &c, &r));
      assert_true(r.finished && r.accepted == r.attempts);
      assert_true(r.total <= -0.25 * r.attempts && fabs(r.error[0]) < 0.2);
    }
    ok(TrainOptionsFree(&o));
  }
}

/* Every row for CMA-ES: the policy at the start runs through an episode of one cell to its end, and a second time to
   the same bits, whatever its dial was in between. */
static void test_episodes(void **state)
{
  const PetscReal unmoved[2] = {0, 0};

  for (PetscInt k = 0; ProblemTable[k]; ++k) {
    const CMAProblem *cma = ProblemTable[k]->cma;
    CMAOptions o = {.problem = ProblemTable[k]};
    EpisodeResult r[3];
    SlipPolicy policy;
    void *episode;
    double *w;

    assert_true(cma || ProblemTable[k]->create); /* else nobody could train on it */
    if (!cma || !cma->setup) continue;           /* of the latter no policy is trained */
    ok((*cma->setup)(&o));
    ok(PetscCalloc1(CMACount(&o), &w));
    (*cma->start)(&o, w);
    ok(CMAPolicy(&o, w, unmoved, &policy));
    ok((*cma->create)(&o, 2, 1, &episode)); /* of the first seeds the one with the shortest runs */
    for (int i = 0; i < 3; ++i) ok((*cma->run)(episode, policy, i == 1 ? 1e-3 : 1e-1, &r[i]));
    assert_true(r[0].done == 1 && r[0].solves > 1 && r[0].error > 0 && isfinite(r[0].cost));
    assert_true(r[0].solves == r[2].solves && r[0].cost == r[2].cost && r[0].error == r[2].error);
    assert_true(cma->dial == CMA_DIAL_NONE || r[1].solves > r[0].solves);
    ok((*cma->destroy)(&episode));
    ok(SlipPolicyDestroy(&policy));
    ok(PetscFree(w));
    for (PetscInt i = 0; i < o.nobs; ++i) ok(PetscFree(o.names[i]));
  }
}

SLIP_TESTS(test_first_observations, test_bare_runs, test_errors_are_of_second_order, test_effects_bound_the_error,
           test_draws, test_episodes)
