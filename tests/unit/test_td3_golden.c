/* TD3 against numbers of Stable-Baselines3 2.7 (the real class, double and float); as test_tqc_golden.c. */
#include "study/td3.h"
#include "golden_learner.h"

static void GoldenNetworks(TD3 *t)
{
  FillLayers(&t->actor_shape, 0, 600, 4, t->actor);
  FillLayers(&t->actor_shape, 0, 620, 4, t->actor_target);
  for (PetscInt i = 0; i < t->o.critics; ++i) {
    FillLayers(&t->critic_shape, i, 700 + 10 * (uint32_t)i, 8, t->critics);
    FillLayers(&t->critic_shape, i, 800 + 10 * (uint32_t)i, 8, t->critic_target);
  }
}

/* Losses of section 8 of the specification, four steps in double */
static const double critic_losses[] = {3.803361666240351, 2.5974911115591754, 1.8278439527086336, 1.3519025524521395},
                    actor_losses[] = {0, 0.6089632931405851, 0, 0.913445733023068};

static void CheckCritics(const char *base, const char *name, const TD3 *t, const Scalar *p)
{
  char prefix[16];

  for (PetscInt i = 0; i < t->o.critics; ++i) {
    Path(sizeof(prefix), prefix, "%s%d.", name, (int)i);
    CheckLayers(base, prefix, &t->critic_shape, p + (size_t)i * t->critic_shape.count);
  }
}

static void CheckStep(int step, const TD3 *t)
{
  char path[64];

  for (int b = 0; golden && step == 0 && b < BATCH; ++b) {
    Path(sizeof(path), path, "td3_" PRECISION "/step1_y/%d/0", b);
    Close(path, (double)t->y[b], Number(path), 1);
  }
  if (golden && step == 0) CheckCritics("td3_" PRECISION "/step1_grad_critic", "q", t, t->critic_grad);
  if (golden && step == 1) CheckLayers("td3_" PRECISION "/step2_grad_actor", "", &t->actor_shape, t->actor_grad);
  if (!golden || step < 3) return;
  CheckLayers("td3_" PRECISION "/params_after_4_steps", "actor.", &t->actor_shape, t->actor);
  CheckLayers("td3_" PRECISION "/target_params_after_4_steps", "actor_t.", &t->actor_shape, t->actor_target);
  CheckCritics("td3_" PRECISION "/params_after_4_steps", "q", t, t->critics);
  CheckCritics("td3_" PRECISION "/target_params_after_4_steps", "tq", t, t->critic_target);
}

static void test_golden(void **state)
{
  LearnerOptions o = GoldenOptions(2);
  const Batch batch = GoldenBatch();
  Scalar noise[BATCH];
  Random r;
  TD3 t;
  Losses losses = {.critic = 0};
  char path[64];

  o.lr = 1e-3;
  o.smoothing_clip = 0.5;
  o.delay = 2;
  RandomSeed(&r, 1);
  assert_int_equal(TD3Create(&o, &r, &t), 0);
  GoldenNetworks(&t);
  Fill(BATCH, 900, 0, 0.7, noise);
  for (int step = 0; step < 4; ++step) {
    TD3Update(&t, &batch, noise, &losses);
    Close("critic loss", losses.critic, critic_losses[step], 1);
    if (step % 2) Close("actor loss", losses.actor, actor_losses[step], 1);
    Path(sizeof(path), path, "td3_" PRECISION "/losses/%d/critic_loss", step);
    if (golden) Close(path, losses.critic, Number(path), 1);
    Path(sizeof(path), path, "td3_" PRECISION "/losses/%d/actor_loss", step);
    if (golden && step % 2) Close(path, losses.actor, Number(path), 1);
    CheckStep(step, &t);
  }
  assert_int_equal(TD3Destroy(&t), 0);
}

SLIP_TESTS_WITH(GoldenLoad, GoldenFree, test_golden)
