/* TQC against numbers of sb3-contrib 2.7 (real classes, double and float). The network weights and the batch come
   from an integer hash; the key numbers are committed here, and the full set is compared when tqc_golden.json is
   found. Compiled for float here and for double in test_tqc_golden_double.c. */
#include "study/tqc.h"
#include "golden_learner.h"

static void GoldenNetworks(TQC *t)
{
  FillLayers(&t->latent, 0, 1, 1, t->actor);
  Fill(WIDTH, 5, 0, 16 / 8., t->actor + t->head_weight);
  Fill(1, 6, 0, 16 / 8., t->actor + t->head_bias);
  Fill(WIDTH, 0, -3, 0.5, t->actor + t->log_std);
  for (PetscInt i = 0; i < t->o.critics; ++i) {
    FillLayers(&t->critic, i, 100 + 10 * (uint32_t)i, 8, t->critics);
    FillLayers(&t->critic, i, 300 + 10 * (uint32_t)i, 8, t->target);
  }
  t->log_alpha = (Scalar)-0.5;
}

static void CheckActor(const char *base, const TQC *t, const Scalar *p)
{
  char path[256];

  CheckLayers(base, "latent.", &t->latent, p);
  Path(sizeof(path), path, "%s/mu.W", base);
  CheckTensor(path, WIDTH, p + t->head_weight);
  Path(sizeof(path), path, "%s/mu.b", base);
  CheckTensor(path, 1, p + t->head_bias);
  Path(sizeof(path), path, "%s/log_std", base);
  CheckTensor(path, WIDTH, p + t->log_std);
}

static void CheckCritics(const char *base, const TQC *t, const Scalar *p)
{
  char prefix[16];

  for (PetscInt i = 0; i < t->o.critics; ++i) {
    Path(sizeof(prefix), prefix, "q%d.", (int)i);
    CheckLayers(base, prefix, &t->critic, p + (size_t)i * t->critic.count);
  }
}

static void CheckParameters(const char *base, const char *when, const TQC *t)
{
  char path[128];

  Path(sizeof(path), path, "%s/params_%s", base, when);
  CheckActor(path, t, t->actor);
  CheckCritics(path, t, t->critics);
  Path(sizeof(path), path, "%s/target_params_%s", base, when);
  CheckCritics(path, t, t->target);
}

static void CheckPerSample(const char *base, const char *name, const Scalar *p)
{
  char path[128];

  for (int b = 0; b < BATCH; ++b) {
    Path(sizeof(path), path, "%s/%s/%d/0", base, name, b);
    Close(path, (double)p[b], Number(path), 1);
  }
}

/* Critic 0's quantiles of sample 0 at the stored action, before any update */
static void CheckQuantiles(const char *base, TQC *t, const Batch *batch)
{
  char path[128];

  for (int i = 0; i < OBS * BATCH; ++i) t->input[i] = batch->obs[i];
  for (int b = 0; b < BATCH; ++b) t->input[OBS * BATCH + b] = batch->action[b];
  DenseForward(&t->critic, t->critics, BATCH, t->input, &t->critic_work);
  for (int i = 0; i < t->o.quantiles; ++i) {
    Path(sizeof(path), path, "%s/step1/theta_sample0_critic0/%d", base, i);
    Close(path, (double)t->critic_work.out[3][i * BATCH], Number(path), 1);
  }
}

/* Mean quantile of each sample at the policy's action under the updated critics: the last forward pass of an update */
static void CheckMeanQ(const char *step, const TQC *t)
{
  const PetscInt n = t->o.critics * t->o.quantiles;
  Scalar q[BATCH] = {0};

  for (PetscInt i = 0; i < n; ++i)
    for (int b = 0; b < BATCH; ++b) q[b] += t->critic_work.out[3][i * BATCH + b] / (Scalar)n;
  CheckPerSample(step, "q_mean_after_critic_update", q);
}

static void CheckFirstStep(const char *base, const TQC *t)
{
  char step[64], path[128];
  const PetscInt n = t->o.critics * (t->o.quantiles - t->o.drop);

  Path(sizeof(step), step, "%s/step1", base);
  Path(sizeof(path), path, "%s/grad_critic", step);
  CheckCritics(path, t, t->critic_grad);
  Path(sizeof(path), path, "%s/grad_actor", step);
  CheckActor(path, t, t->actor_grad);
  for (PetscInt j = 0; j < n; ++j) {
    Path(sizeof(path), path, "%s/target_y_sample0/%d", step, (int)j);
    Close(path, (double)t->z[j * BATCH], Number(path), 1);
  }
  /* sample 3 is terminal: its targets are the reward alone */
  for (int j = 0; j < 3; ++j) {
    Path(sizeof(path), path, "%s/target_y_sample3_done/%d", step, j);
    Close(path, (double)t->z[j * BATCH + 3], Number(path), 1);
  }
  CheckMeanQ(step, t);
  CheckPerSample(step, "obs/mean_raw", t->now.mean_raw);
  CheckPerSample(step, "obs/mean", t->now.mean);
  CheckPerSample(step, "obs/noise", t->now.noise);
  CheckPerSample(step, "obs/var_plus_eps", t->now.var);
  CheckPerSample(step, "obs/action", t->now.action);
  CheckPerSample(step, "obs/logp", t->now.logp);
  CheckPerSample(step, "next_obs/mean_raw", t->next.mean_raw);
  CheckPerSample(step, "next_obs/action", t->next.action);
  CheckPerSample(step, "next_obs/logp", t->next.logp);
  CheckParameters(step, "after", t);
}

static void CheckLosses(const char *base, int step, const TQC *t, const Losses *l)
{
  const struct {
    const char *name;
    double value;
  } row[] = {{"critic_loss", l->critic},
             {"actor_loss", l->actor},
             {"ent_coef_loss", l->entropy},
             {"alpha", l->alpha},
             {"log_alpha_after", (double)t->log_alpha}};
  char path[128];

  for (size_t i = 0; i < sizeof(row) / sizeof(row[0]); ++i) {
    Path(sizeof(path), path, "%s/losses/%d/%s", base, step, row[i].name);
    Close(path, row[i].value, Number(path), 1); /* the losses are sums of terms of order 1 that cancel */
  }
}

/* Key numbers of section 8 of the specification; the last two are printed there to ten digits. */
typedef struct {
  PetscInt critics;
  double critic, actor, entropy, log_std0, log_std1, head_bias, out_bias, critic5, actor5;
} Key;
static const Key keys[] = {
  {5, 0.5154640163224714, 1.248506384259508, 0.48186381905045206, -0.04286425609473532, -0.020033753313838738,
   0.5318974286428055, 6.053670463300188e-4, 0.5279110346, 0.9170362870},
  {2, 0.4748616297165596, 1.2568072367477967, 0.48186381905045206, -0.042815237900219245, -0.020016034359978674,
   0.5246686122820725, 8.399938695357797e-4, 0.4876047305, 0.9337267043}};

static void CheckKeys(const Key *key, int step, const TQC *t, const Losses *l)
{
  if (step == 0) {
    Close("critic loss", l->critic, key->critic, 1);
    Close("actor loss", l->actor, key->actor, 1);
    Close("entropy loss", l->entropy, key->entropy, 1);
    Close("gradient of log_std[0]", (double)t->actor_grad[t->log_std], key->log_std0, 1);
    Close("gradient of log_std[1]", (double)t->actor_grad[t->log_std + 1], key->log_std1, 1);
    Close("gradient of the head's bias", (double)t->actor_grad[t->head_bias], key->head_bias, 1);
    Close("gradient of critic 0's output bias", (double)t->critic_grad[t->critic.bias[3]], key->out_bias, 0);
  } else if (step == 4) {
    Close("critic loss of step 5", l->critic, key->critic5, 1);
    Close("actor loss of step 5", l->actor, key->actor5, 1);
  }
}

static void RunGolden(const Key *key)
{
  LearnerOptions o = GoldenOptions(key->critics);
  Random r;
  TQC t;
  Losses losses;
  Batch batch = GoldenBatch();
  Scalar eps[WIDTH];
  char base[64];

  o.quantiles = 25;
  o.drop = 2;
  o.lr = 3e-4;
  RandomSeed(&r, 1);
  assert_int_equal(TQCCreate(&o, &r, &t), 0);
  GoldenNetworks(&t);
  Fill(WIDTH, 504, 0, 2, eps);
  Path(sizeof(base), base, "tqc_n%d_" PRECISION, (int)key->critics);
  if (golden) CheckQuantiles(base, &t, &batch);
  for (int step = 0; step < 5; ++step) {
    TQCUpdate(&t, &batch, eps, &losses);
    CheckKeys(key, step, &t, &losses);
    if (golden) {
      CheckLosses(base, step, &t, &losses);
      if (step == 0) CheckFirstStep(base, &t);
    }
  }
  if (golden) CheckParameters(base, "after_5_steps", &t);
  assert_int_equal(TQCDestroy(&t), 0);
}

static void test_five_critics(void **state)
{
  RunGolden(&keys[0]);
}

static void test_two_critics(void **state)
{
  RunGolden(&keys[1]);
}

/* The pooled quantiles and the loss against the definition, written plainly, for sizes that fill no block. */
static void test_quantiles_plain(void **state)
{
  enum { C = 3, Q = 7, KEEP = 17, B = 21 };
  static Scalar z[C * Q * B], sorted[C * Q * B], theta[C * Q * B], grad[C * Q * B], zero[B];
  double loss = 0;
  Random r;

  RandomSeed(&r, 3);
  for (int i = 0; i < C * Q * B; ++i) {
    z[i] = sorted[i] = (Scalar)(2 * RandomNormal(&r));
    theta[i] = (Scalar)RandomNormal(&r);
  }
  QuantileTargets(C * Q, KEEP, B, zero, zero, 1, 0, zero, sorted);
  for (int b = 0; b < B; ++b) {
    for (int j = 0; j < KEEP; ++j) {
      int below = 0;

      for (int i = 0; i < C * Q; ++i) below += z[i * B + b] < sorted[j * B + b];
      assert_int_equal(below, j); /* exactly the j-th smallest */
    }
  }
  const double value = QuantileHuber(C, Q, KEEP, B, theta, sorted, grad);
  for (int i = 0; i < C * Q; ++i) {
    for (int b = 0; b < B; ++b) {
      const double tau = (i % Q + 0.5) / Q;
      double g = 0;

      for (int j = 0; j < KEEP; ++j) {
        const double d = (double)sorted[j * B + b] - (double)theta[i * B + b], w = fabs(tau - (d < 0));

        loss += w * (fabs(d) > 1 ? fabs(d) - 0.5 : 0.5 * d * d);
        g -= w * fmax(-1, fmin(1, d));
      }
      Close("quantile gradient", (double)grad[i * B + b] * (B * C * Q * KEEP), g, KEEP);
    }
  }
  Close("quantile Huber loss", value, loss / (B * C * Q * KEEP), 1);
}

SLIP_TESTS_WITH(GoldenLoad, GoldenFree, test_five_critics, test_two_critics, test_quantiles_plain)
