/* TQC with a Gaussian instead of gSDE, in double precision: the gradient of the actor's loss against differences of the
   loss, and the density against its definition. */
#define TRAIN_DOUBLE
#include "unit.h"
#include "study/tqc.h"

enum { OBS = 4, BATCH = 16, H = 8 };

/* mean(alpha logp - Q) with the actor's parameters p, everything else as it is */
static double ActorLoss(TQC *t, const Batch *batch, const Scalar eps[], const Scalar p[], double alpha)
{
  const PetscInt n = t->o.critics * t->o.quantiles;
  double loss = 0;

  DenseForward(&t->latent, p, BATCH, batch->obs, &t->actor_work);
  GaussSample(H, BATCH, t->actor_work.out[0], p + t->head_weight, p + t->head_bias, p + t->log_std, p + t->log_std + H,
              eps, &t->now);
  for (int i = 0; i < OBS * BATCH; ++i) t->input[i] = batch->obs[i];
  for (int b = 0; b < BATCH; ++b) t->input[OBS * BATCH + b] = t->now.action[b];
  DenseForward(&t->critic, t->critics, BATCH, t->input, &t->critic_work);
  for (int b = 0; b < BATCH; ++b) {
    loss += alpha * t->now.logp[b] / BATCH;
    for (PetscInt i = 0; i < n; ++i)
      loss -= t->critic_work.out[t->critic.layers - 1][i * BATCH + b] / (double)(n * BATCH);
  }
  return loss;
}

static void test_gradient(void **state)
{
  const LearnerOptions o = {.obs = OBS,
                            .actor_layers = 1,
                            .actor = {H},
                            .critic_layers = 2,
                            .critic = {8, 8},
                            .critics = 2,
                            .quantiles = 5,
                            .drop = 1,
                            .batch = BATCH,
                            .gaussian = PETSC_TRUE,
                            .lr = 1e-3,
                            .gamma = 0.99,
                            .tau = 0.005};
  static Scalar obs[OBS * BATCH], next[OBS * BATCH], action[BATCH], reward[BATCH], done[BATCH], eps[2 * BATCH], p[128];
  const Batch batch = {obs, next, action, reward, done};
  Random r;
  TQC t;
  Losses losses;

  RandomSeed(&r, 5);
  assert_int_equal(TQCCreate(&o, &r, &t), 0);
  assert_int_equal(TQCNoiseCount(&t), 2 * BATCH);
  assert_true(t.nactor <= 128);
  for (int i = 0; i < OBS * BATCH; ++i) {
    obs[i] = RandomNormal(&r);
    next[i] = RandomNormal(&r);
  }
  for (int b = 0; b < BATCH; ++b) {
    action[b] = 2 * RandomUniform(&r) - 1;
    reward[b] = RandomNormal(&r);
    eps[b] = RandomNormal(&r);
    eps[BATCH + b] = RandomNormal(&r);
  }
  for (size_t i = 0; i < t.nactor; ++i) p[i] = t.actor[i];
  TQCUpdate(&t, &batch, eps, &losses);
  /* the loss is that of the actor before its step and the critics after theirs */
  assert_true(fabs(ActorLoss(&t, &batch, eps, p, losses.alpha) - losses.actor) < 1e-12);
  for (size_t i = 0; i < t.nactor; ++i) {
    const double step = 1e-6, keep = p[i];
    double difference;

    p[i] = keep + step;
    difference = ActorLoss(&t, &batch, eps, p, losses.alpha);
    p[i] = keep - step;
    difference -= ActorLoss(&t, &batch, eps, p, losses.alpha);
    p[i] = keep;
    /* truncation step^2 and rounding 1e-16/step, both some 1e-10; the margin is for third derivatives */
    assert_true(fabs(difference / (2 * step) - t.actor_grad[i]) < 1e-7);
  }
  assert_int_equal(TQCDestroy(&t), 0);
}

/* The density of a = tanh(m + sigma eps), for one feature that is 1: integrates to 1 over a. */
static void test_density(void **state)
{
  enum { N = 4000 };
  static Scalar h[N], eps[N], mean_raw[N], mean[N], noise[N], var[N], std_raw[N], action[N], logp[N];
  const Scalar head[] = {0.3}, bias[] = {0.1}, std_head[] = {-0.4}, std_bias[] = {-0.2};
  Sample s = {mean_raw, mean, noise, var, std_raw, action, logp};
  double sum = 0;

  for (int i = 0; i < N; ++i) {
    h[i] = 1;
    eps[i] = -8 + 16. * i / (N - 1);
  }
  GaussSample(1, N, h, head, bias, std_head, std_bias, eps, &s);
  assert_true(fabs(mean[0] - 0.4) < 1e-15 && fabs(var[0] - exp(-1.2)) < 1e-15);
  for (int i = 1; i < N; ++i) sum += 0.5 * (exp(logp[i]) + exp(logp[i - 1])) * (action[i] - action[i - 1]);
  /* the 1e-6 in the logarithm is felt where 1 - a^2 is of its size, at eps near 7 */
  assert_true(fabs(sum - 1) < 1e-4);
}

SLIP_TESTS(test_gradient, test_density)
