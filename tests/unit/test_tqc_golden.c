/* TQC against numbers of sb3-contrib 2.7 (real classes, double and float). The network weights and the batch come
   from an integer hash; the key numbers are committed here, and the full set is compared when tqc_golden.json is
   found. Compiled for float here and for double in test_tqc_golden_double.c. Tolerances: double 1e-9; both sides
   round at 1e-16 and sums have some 1e5 terms. Float 1e-5 relative to the l2 norm of a tensor (SB3's atanh round
   trip alone costs 1e-6), see Close(). */
#include "tqc.h"
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include "golden_json.h"

#if defined(TRAIN_DOUBLE)
  #define TOLERANCE 1e-9
  #define PRECISION "f64"
#else
  #define TOLERANCE 1e-5
  #define PRECISION "f32"
#endif

enum { BATCH = 8, OBS = 6, WIDTH = 64 };

/* Formats the path of an entry. */
static void Path(size_t size, char out[], const char format[], ...)
{
  va_list args;
  int n;

  va_start(args, format);
  n = vsnprintf(out, size, format, args);
  va_end(args);
  assert_true(n > 0 && (size_t)n < size);
}

static char *golden; /* text of tqc_golden.json or NULL */

static Scalar Hash(uint32_t k, uint32_t tensor, double shift, double scale)
{
  uint32_t x = 2654435761u * (k + 1) + 1013904223u * (tensor + 1);

  for (int i = 0; i < 2; ++i) {
    x ^= x >> 16;
    x *= 73244475u;
  }
  x ^= x >> 16;
  return (Scalar)(float)(shift + scale * (2 * ((double)x + 0.5) / 4294967296.0 - 1));
}

static void Fill(size_t n, uint32_t tensor, double shift, double scale, Scalar *p)
{
  for (size_t k = 0; k < n; ++k) p[k] = Hash((uint32_t)k, tensor, shift, scale);
}

static void FillLayers(const DenseShape *s, PetscInt net, uint32_t tensor, double last_gain, Scalar *p)
{
  p += (size_t)net * s->count;
  for (PetscInt l = 0; l < s->layers; ++l) {
    const double scale = (l + 1 == s->layers ? last_gain : 1) / sqrt((double)s->size[l]);

    Fill((size_t)(s->size[l] * s->size[l + 1]), tensor + 2 * (uint32_t)l, 0, scale, p + s->weight[l]);
    Fill((size_t)s->size[l + 1], tensor + 2 * (uint32_t)l + 1, 0, scale, p + s->bias[l]);
  }
}

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

static TQCBatch GoldenBatch(void)
{
  static Scalar obs[OBS * BATCH], next[OBS * BATCH], act[BATCH], rew[BATCH], done[BATCH];
  TQCBatch b = {obs, next, act, rew, done};

  for (uint32_t i = 0; i < BATCH; ++i) {
    for (uint32_t j = 0; j < OBS; ++j) {
      obs[j * BATCH + i] = Hash(i * OBS + j, 500, 0, 3);
      next[j * BATCH + i] = Hash(i * OBS + j, 501, 0, 3);
    }
    act[i] = Hash(i, 502, 0, 1);
    rew[i] = Hash(i, 503, 0, 2);
    done[i] = i % 4 == 3;
  }
  return b;
}

/* scale: magnitude against which the error is relative */
static void Close(const char *what, double value, double expected, double scale)
{
  if (!(fabs(value - expected) <= TOLERANCE * fmax(scale, fabs(expected)))) {
    fail_msg("%s is %.16g, the reference %.16g (difference %.2e, allowed %.2e)", what, value, expected,
             fabs(value - expected), TOLERANCE * fmax(scale, fabs(expected)));
  }
}

static double Number(const char *path)
{
  const char *s = JsonFind(golden, path);

  if (!s) fail_msg("tqc_golden.json has no %s", path);
  return strtod(s, NULL);
}

/* A tensor against its shape-independent summary: sum, l2 norm, first three entries and last. */
static void CheckTensor(const char *path, size_t n, const Scalar *p)
{
  char entry[256];
  double sum = 0, l2 = 0, norm;

  for (size_t i = 0; i < n; ++i) {
    sum += p[i];
    l2 += (double)p[i] * p[i];
  }
  Path(sizeof(entry), entry, "%s/l2", path);
  norm = Number(entry);
  Close(entry, sqrt(l2), norm, norm);
  Path(sizeof(entry), entry, "%s/sum", path);
  Close(entry, sum, Number(entry), sqrt((double)n) * norm); /* |sum| <= sqrt(n) l2: entries cancel */
  for (size_t i = 0; i < (n < 3 ? n : 3); ++i) {
    Path(sizeof(entry), entry, "%s/first/%d", path, (int)i);
    Close(entry, (double)p[i], Number(entry), norm);
  }
  Path(sizeof(entry), entry, "%s/last", path);
  Close(entry, (double)p[n - 1], Number(entry), norm);
}

static void CheckLayers(const char *base, const char *prefix, const DenseShape *s, const Scalar *p)
{
  char path[256];

  for (PetscInt l = 0; l < s->layers; ++l) {
    Path(sizeof(path), path, "%s/%s.W%d", base, prefix, (int)l + 1);
    CheckTensor(path, (size_t)(s->size[l] * s->size[l + 1]), p + s->weight[l]);
    Path(sizeof(path), path, "%s/%s.b%d", base, prefix, (int)l + 1);
    CheckTensor(path, (size_t)s->size[l + 1], p + s->bias[l]);
  }
}

static void CheckActor(const char *base, const TQC *t, const Scalar *p)
{
  char path[256];

  CheckLayers(base, "latent", &t->latent, p);
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
    Path(sizeof(prefix), prefix, "q%d", (int)i);
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
static void CheckQuantiles(const char *base, TQC *t, const TQCBatch *batch)
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

static void CheckLosses(const char *base, int step, const TQC *t, const TQCLosses *l)
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

static void CheckKeys(const Key *key, int step, const TQC *t, const TQCLosses *l)
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
  const TQCOptions o = {OBS, 1, WIDTH, key->critics, 25, 2, BATCH, 3e-4, 0.99, 0.005};
  Random r;
  TQC t;
  TQCLosses losses;
  TQCBatch batch = GoldenBatch();
  Scalar eps[WIDTH];
  char base[64];

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
  (void)state;
  RunGolden(&keys[0]);
}

static void test_two_critics(void **state)
{
  (void)state;
  RunGolden(&keys[1]);
}

/* The pooled quantiles and the loss against the definition, written plainly, for sizes that fill no block. */
static void test_quantiles_plain(void **state)
{
  enum { C = 3, Q = 7, KEEP = 17, B = 21 };
  static Scalar z[C * Q * B], sorted[C * Q * B], theta[C * Q * B], grad[C * Q * B], zero[B];
  double loss = 0;
  Random r;

  (void)state;
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

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_five_critics), cmocka_unit_test(test_two_critics),
                                     cmocka_unit_test(test_quantiles_plain)};
  const char *source = getenv("SLIPSTEP_SOURCE");
  const char *const places[] = {"../shared/references", "../../shared/references"};
  char file[4096];

  if (PetscInitializeNoArguments()) return 1;
  for (size_t i = 0; i < 2 && !golden; ++i) {
    Path(sizeof(file), file, "%s/%s/tqc_golden.json", source ? source : ".", places[i]);
    golden = JsonLoad(file);
  }
  if (golden)
    printf("comparing with every number of %s\n", file);
  else
    printf("tqc_golden.json not found: only the committed numbers are compared, the full set is skipped\n");
  const int failed = cmocka_run_group_tests(tests, NULL, NULL);
  free(golden);
  if (PetscFinalize()) return 1;
  return failed;
}
