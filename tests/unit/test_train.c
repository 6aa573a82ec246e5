/* The trainer: rewards, the continuation behind the accuracy reward, reproducibility, checkpoints, the policy file. */
#include "unit.h"
#include "study/trainer.h"

/* Options of a short run, from the options database as a program would set them. */
static TrainOptions Options(const char extra[])
{
  TrainOptions o;

  ok(PetscOptionsClear(NULL));
  ok(PetscOptionsInsertString(NULL,
                              "-train_progress 0 -train_batch 32 -train_learning_starts 50 -train_max_attempts 200"));
  ok(PetscOptionsInsertString(NULL, extra));
  ok(TrainOptionsSet(PETSC_COMM_SELF, &o));
  return o;
}

/* With the options that it copied. */
static void Destroy(Trainer *t)
{
  TrainOptions o = t->o;

  ok(TrainerDestroy(t));
  ok(TrainOptionsFree(&o));
}

static PetscBool SameBits(Trainer *a, Trainer *b)
{
  LearnerState p, q;

  a->agent.o.learner->state(a->agent.learner, &p);
  b->agent.o.learner->state(b->agent.learner, &q);
  assert_int_equal(p.n, q.n);
  for (PetscInt i = 0; i < p.n; ++i) {
    assert_int_equal(p.array[i].n, q.array[i].n);
    if (memcmp(p.array[i].data, q.array[i].data, p.array[i].n * sizeof(Scalar))) return PETSC_FALSE;
  }
  return !memcmp(&a->agent.random, &b->agent.random, sizeof(Random)) && a->episodes == b->episodes ? PETSC_TRUE
                                                                                                   : PETSC_FALSE;
}

static void test_same_seed_same_bits(void **state)
{
  static const char *const runs[] = {"-train_steps 300 -train_seed 7", "-train_steps 300 -train_seed 7",
                                     "-train_steps 300 -train_seed 8"};
  Trainer t[3];

  for (int i = 0; i < 3; ++i) {
    const TrainOptions o = Options(runs[i]);

    ok(TrainerCreate(&o, &t[i]));
    ok(TrainerRun(&t[i]));
    assert_int_equal(t[i].agent.steps, 300);
    assert_int_equal(t[i].agent.updates, 250); /* the first after step 51 */
  }
  assert_true(SameBits(&t[0], &t[1]));
  assert_false(SameBits(&t[0], &t[2]));
  for (int i = 0; i < 3; ++i) Destroy(&t[i]);
}

/* Train to 200 steps, write, go on to 350; and read, go on to 350: the same bits. Three problems, both learners. */
static void test_resume_same_bits(void **state)
{
  static const char *const runs[] = {"-train_random -train_reward accuracy",
                                     "-train_algorithm td3 -train_problem circuit -train_random -train_reward balanced",
                                     "-train_problem sliding_mode -train_network 16,8"};
  const char *checkpoint = "test_train_checkpoint.h5";

  for (int i = 0; i < 3; ++i) {
    char text[256];
    TrainOptions o;
    Trainer a, b;

    ok(PetscSNPrintf(text, sizeof(text), "-train_steps 350 -train_seed 3 %s", runs[i]));
    o = Options(text);
    ok(TrainerCreate(&o, &a));
    a.o.steps = 200;
    ok(PetscStrncpy(a.o.checkpoint, checkpoint, sizeof(a.o.checkpoint)));
    ok(TrainerRun(&a));
    a.o.checkpoint[0] = 0;
    a.o.steps = 350;
    ok(TrainerRun(&a));
    ok(PetscSNPrintf(text, sizeof(text), "-train_steps 350 -train_seed 99 %s", runs[i]));
    o = Options(text);
    ok(PetscStrncpy(o.resume, checkpoint, sizeof(o.resume)));
    ok(TrainerCreate(&o, &b));
    assert_int_equal(b.agent.steps, 200);
    assert_false(SameBits(&a, &b));
    ok(TrainerRun(&b));
    assert_true(SameBits(&a, &b));
    Destroy(&a);
    Destroy(&b);
    assert_int_equal(remove(checkpoint), 0);
  }
}

/* On another mesh: the networks go on, the transitions and the evaluations begin anew. */
static void test_transfer(void **state)
{
  const char *checkpoint = "test_train_transfer.h5";
  const char *common = "-train_reward balanced -train_evaluate_interval 40 -train_resume test_train_transfer.h5";
  TrainOptions o = Options("-train_steps 120 -train_random -train_reward balanced -train_evaluate_interval 100");
  char text[256];
  Trainer a, b;

  ok(PetscStrncpy(o.checkpoint, checkpoint, sizeof(o.checkpoint)));
  ok(TrainerCreate(&o, &a));
  ok(TrainerRun(&a));
  ok(PetscSNPrintf(text, sizeof(text), "-train_steps 200 -train_transfer -fault_nx 2 -fault_nz 2 %s", common));
  o = Options(text);
  ok(TrainerCreate(&o, &b));
  assert_int_equal(b.agent.steps, 120);
  assert_int_equal(b.agent.replay.size, 0);
  assert_true(b.best < a.best);
  assert_memory_equal(a.actor, b.actor, a.nactor * sizeof(Scalar));
  ok(TrainerRun(&b));
  assert_int_equal(b.agent.replay.size, 80);
  assert_int_equal(b.agent.updates - a.agent.updates, 30); /* after 50 steps, -train_learning_starts */
  assert_true(b.best > -PETSC_MAX_REAL);
  Destroy(&a);
  Destroy(&b);
  assert_int_equal(remove(checkpoint), 0);
}

/* The stored policy answers what the trained actor answers: with its clamped head, and TD3's. */
static void test_policy_file(void **state)
{
  static const char *const runs[] = {"-train_network 32", "-train_algorithm td3"};
  const char *file = "test_train_policy.h5";

  (void)state;
  for (int i = 0; i < 2; ++i) {
    PetscReal obs[ENV_MAX_OBS] = {0.8, 0.1, 0.05, 1, 0.3, 0.02}, action;
    char text[128];
    TrainOptions o;
    Trainer t;
    SlipPolicy p;

    ok(PetscSNPrintf(text, sizeof(text), "-train_steps 150 -train_seed 5 %s", runs[i]));
    o = Options(text);
    ok(PetscStrncpy(o.output, file, sizeof(o.output)));
    ok(TrainerCreate(&o, &t));
    ok(TrainerRun(&t));
    ok(SlipPolicyCreate(PETSC_COMM_SELF, &p));
    ok(SlipPolicyLoad(p, file));
    ok(SlipPolicyEvaluate(p, obs, &action, NULL));
    assert_true(fabs(action - AgentAct(&t.agent, obs, PETSC_FALSE)) <
                1e-5); /* the actor computes in single precision */
    ok(SlipPolicyDestroy(&p));
    Destroy(&t);
    assert_int_equal(remove(file), 0);
  }
}

static void test_published_reward(void **state)
{
  SlipAttempt a = {.dt = 2, .converged = PETSC_TRUE, .error = 0.5};
  RewardInput in = {.attempt = &a, .dt_min = 1, .dt_max = 5, .cost = 3, .cost_min = 2, .cost_max = 4, .alpha = 2};
  const Reward *row;

  ok(RewardFind("published", &row));
  assert_true(fabs(row->value(&in) - 0.25 * 0.5 * exp(-1)) < 1e-15); /* S1 = 1/4, S2 = 1/2 */
  a.converged = PETSC_FALSE;
  assert_true(fabs(row->value(&in) + 0.25) < 1e-15);
}

/* An actor that always answers the same. */
static PetscErrorCode Constant(const EnvMoment *m, PetscReal *action, PetscBool *stop, void *ctx)
{
  if (!m->first) assert_true(m->reward < 0);
  *action = *(const PetscReal *)ctx;
  return PETSC_SUCCESS;
}

/* Short steps cost attempts and no error, long ones the reverse; the reference is that of an independent run. */
static void test_accuracy_reward(void **state)
{
  TrainOptions o = Options("-train_reward accuracy -train_max_attempts 0");
  Environment env;
  EnvResult fine, coarse, finest;
  Random r;
  PetscReal action = -0.1; /* 0.01 (1400)^0.45 T* = 0.26 T* */

  RandomSeed(&r, 1);
  ok(EnvCreate(&o.env, &env));
  ok(EnvRunEpisode(&env, &r, Constant, &action, &fine));
  action = 0.63; /* 3.7 T* */
  ok(EnvRunEpisode(&env, &r, Constant, &action, &coarse));
  assert_true(fine.finished && coarse.finished);
  /* The fine run is of second order with some 130 steps: 0.1 %. The continuation's step is a third of that. */
  assert_true(fabs(fine.error[0]) < 2e-3);
  assert_true(fabs(coarse.error[0]) > 2e-2);
  /* 0.02 T*: four times as short as the continuation's steps, whose error is a few 1e-4 (second order: a ninth of the
     fine run's 0.1 %) */
  action = -0.8;
  ok(EnvRunEpisode(&env, &r, Constant, &action, &finest));
  assert_true(fabs(finest.error[0]) < 5e-4);
  assert_int_equal(fine.attempts, fine.accepted);
  /* 0.25 each; the errors of the fine run's steps amount to some 0.1 % each of slip and peak, the coarse one's
     exceed its final error of 2 %, which weighs 1 */
  assert_true(fine.total < -0.25 * fine.attempts && fine.total > -0.25 * fine.attempts - 5);
  assert_true(coarse.total < -0.25 * coarse.attempts - 1);
  ok(TrainOptionsFree(&o));
}

SLIP_TESTS(test_same_seed_same_bits, test_resume_same_bits, test_transfer, test_policy_file, test_published_reward,
           test_accuracy_reward)
