/* The TQC agent: its networks and its life, its gradient step, its actions. It explores by noise that is a linear
   function of the actor's last hidden layer (generalised state-dependent exploration), squashed by tanh. */
#include "tqc.h"
#include <slipcompat.h>

#define HALF_LOG_2PI ((Scalar)0.9189385332046727)

PetscErrorCode TQCCreate(const LearnerOptions *o, Random *r, void *learner)
{
  TQC *t = (TQC *)learner;
  const PetscInt H = o->actor[o->actor_layers > 0 ? o->actor_layers - 1 : 0];
  const double bound = 1 / sqrt((double)H);
  const size_t B = (size_t)o->batch;
  Sample *const s[] = {&t->now, &t->next};

  PetscFunctionBegin;
  PetscCall(LearnerCheckOptions(o));
  PetscCheck(o->quantiles > 0 && o->drop >= 0 && o->drop < o->quantiles, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "Dropped quantiles per critic %" PetscInt_FMT " must lie in [0, %" PetscInt_FMT ")", o->drop,
             o->quantiles);
  t->o = *o;
  t->hidden = H;
  LearnerShape(1, o->obs, o->actor_layers, o->actor, 0, &t->latent);
  LearnerShape(o->critics, o->obs + 1, o->critic_layers, o->critic, o->quantiles, &t->critic);
  t->head_weight = t->latent.count;
  t->head_bias = t->head_weight + (size_t)H;
  t->log_std = t->head_bias + 1;
  t->nactor = t->log_std + (size_t)H;
  t->ncritic = (size_t)o->critics * t->critic.count;
  t->log_alpha = 0;
  PetscCall(PetscMalloc2(t->nactor, &t->actor, t->nactor, &t->actor_grad));
  PetscCall(PetscMalloc3(t->ncritic, &t->critics, t->ncritic, &t->target, t->ncritic, &t->critic_grad));
  DenseInitialize(&t->latent, r, t->actor);
  for (size_t i = t->head_weight; i < t->log_std; ++i) t->actor[i] = (Scalar)(bound * (2 * RandomUniform(r) - 1));
  for (size_t i = t->log_std; i < t->nactor; ++i) t->actor[i] = -3;
  DenseInitialize(&t->critic, r, t->critics);
  PetscCall(PetscArraycpy(t->target, t->critics, t->ncritic));
  PetscCall(AdamCreate(t->nactor, &t->actor_adam));
  PetscCall(AdamCreate(t->ncritic, &t->critic_adam));
  PetscCall(AdamCreate(1, &t->alpha_adam));
  /* work space */
  PetscCall(DenseWorkCreate(&t->latent, o->batch, &t->actor_work));
  PetscCall(DenseWorkCreate(&t->critic, o->batch, &t->critic_work));
  for (int k = 0; k < 2; ++k)
    PetscCall(PetscCalloc6(B, &s[k]->mean_raw, B, &s[k]->mean, B, &s[k]->noise, B, &s[k]->var, B, &s[k]->action, B,
                           &s[k]->logp));
  PetscCall(PetscCalloc3((size_t)H, &t->sigma, (size_t)H, &t->explore, (size_t)H, &t->normals));
  PetscCall(
    PetscCalloc2((size_t)((o->obs + 1) * o->batch), &t->input, (size_t)(o->critics * o->quantiles * o->batch), &t->z));
  PetscCall(PetscCalloc4(B, &t->dqda, B, &t->dS, B, &t->dg, B, &t->dm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TQCDestroy(void *learner)
{
  TQC *t = (TQC *)learner;
  Sample *const s[] = {&t->now, &t->next};

  PetscFunctionBegin;
  PetscCall(PetscFree2(t->actor, t->actor_grad));
  PetscCall(PetscFree3(t->critics, t->target, t->critic_grad));
  PetscCall(AdamDestroy(&t->actor_adam));
  PetscCall(AdamDestroy(&t->critic_adam));
  PetscCall(AdamDestroy(&t->alpha_adam));
  PetscCall(DenseWorkDestroy(&t->actor_work));
  PetscCall(DenseWorkDestroy(&t->critic_work));
  for (int k = 0; k < 2; ++k)
    PetscCall(PetscFree6(s[k]->mean_raw, s[k]->mean, s[k]->noise, s[k]->var, s[k]->action, s[k]->logp));
  PetscCall(PetscFree3(t->sigma, t->explore, t->normals));
  PetscCall(PetscFree2(t->input, t->z));
  PetscCall(PetscFree4(t->dqda, t->dS, t->dg, t->dm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- one gradient step ---- */

/* Critic input: observations above actions, [O + 1][B]. */
static void CriticInput(TQC *t, const Scalar obs[], const Scalar action[])
{
  const size_t no = (size_t)(t->o.obs * t->o.batch), na = (size_t)t->o.batch;

  for (size_t i = 0; i < no; ++i) t->input[i] = obs[i];
  for (size_t i = 0; i < na; ++i) t->input[no + i] = action[i];
}

static void GSDESample(PetscInt H, PetscInt B, const Scalar h[], const Scalar head[], const Scalar bias[],
                       const Scalar sigma[], const Scalar explore[], Sample *s)
{
  ScalarGemv(CblasRowMajor, CblasTrans, H, B, 1, h, B, head, 1, 0, s->mean_raw, 1);
  for (PetscInt b = 0; b < B; ++b) {
    s->mean_raw[b] += bias[0];
    s->mean[b] = s->mean_raw[b] > 2 ? 2 : (s->mean_raw[b] < -2 ? -2 : s->mean_raw[b]);
    s->noise[b] = 0;
    s->var[b] = (Scalar)1e-6;
  }
  for (PetscInt j = 0; explore && j < H; ++j) {
    const Scalar v = sigma[j] * sigma[j], *hj = h + j * B;

    for (PetscInt b = 0; b < B; ++b) {
      s->noise[b] += hj[b] * explore[j];
      s->var[b] += hj[b] * hj[b] * v;
    }
  }
  for (PetscInt b = 0; b < B; ++b) {
    const Scalar n = s->noise[b], S = s->var[b], a = ScalarTanh(s->mean[b] + n);

    s->action[b] = a;
    s->logp[b] = -n * n / (2 * S) - ScalarLog(S) / 2 - HALF_LOG_2PI - ScalarLog(1 - a * a + (Scalar)1e-6);
  }
}

/* The exploration of normals eps [H] */
static void DrawExploration(TQC *t, const Scalar eps[])
{
  for (PetscInt i = 0; i < t->hidden; ++i) {
    t->sigma[i] = ScalarExp(t->actor[t->log_std + (size_t)i]);
    t->explore[i] = t->sigma[i] * eps[i];
  }
}

static void ActorForward(TQC *t, PetscInt B, const Scalar obs[], PetscBool explore, Sample *s)
{
  DenseForward(&t->latent, t->actor, B, obs, &t->actor_work);
  GSDESample(t->hidden, B, t->actor_work.out[t->latent.layers - 1], t->actor + t->head_weight, t->actor + t->head_bias,
             t->sigma, explore ? t->explore : NULL, s);
}

static double CriticStep(TQC *t, const Batch *batch, Scalar alpha)
{
  const LearnerOptions *o = &t->o;
  const PetscInt B = o->batch, n = o->critics * o->quantiles, keep = n - o->critics * o->drop;
  double loss;

  CriticInput(t, batch->next_obs, t->next.action);
  DenseForward(&t->critic, t->target, B, t->input, &t->critic_work);
  for (PetscInt i = 0; i < n * B; ++i) t->z[i] = t->critic_work.out[t->critic.layers - 1][i];
  QuantileTargets(n, keep, B, batch->reward, batch->done, (Scalar)o->gamma, alpha, t->next.logp, t->z);
  CriticInput(t, batch->obs, batch->action);
  DenseForward(&t->critic, t->critics, B, t->input, &t->critic_work);
  loss = QuantileHuber(o->critics, o->quantiles, keep, B, t->critic_work.out[t->critic.layers - 1], t->z,
                       t->critic_work.delta[t->critic.layers - 1]);
  DenseBackward(&t->critic, t->critics, B, t->input, &t->critic_work, t->critic_grad);
  AdamStep(&t->critic_adam, o->lr, t->critic_grad, t->critics);
  return loss;
}

/* Mean of all quantiles at (obs, a) and its gradient with respect to a, into dqda. Returns the mean over the batch. */
static double CriticValue(TQC *t, const Scalar obs[], const Scalar action[])
{
  const PetscInt B = t->o.batch, n = t->o.critics * t->o.quantiles;
  double sum = 0;

  CriticInput(t, obs, action);
  DenseForward(&t->critic, t->critics, B, t->input, &t->critic_work);
  for (PetscInt i = 0; i < n * B; ++i) {
    sum += (double)t->critic_work.out[t->critic.layers - 1][i];
    t->critic_work.delta[t->critic.layers - 1][i] = 1 / (Scalar)n;
  }
  DenseBackward(&t->critic, t->critics, B, t->input, &t->critic_work, NULL);
  DenseInputGradient(&t->critic, t->critics, B, &t->critic_work, t->o.obs, t->dqda);
  return sum / ((double)n * (double)B);
}

/* Gradient of mean(alpha logp - Q) through tanh, the noise and its density, o = 1 - a^2 and S the noise's variance:
     dg = -(q_a/B) o + (alpha/B) (-n/S + 2 a o/(o + 1e-6)),
     dm = dg + (alpha/B) n/S inside the clamp,
     dS = (alpha/B) (n^2/(2 S^2) - 1/(2 S));
   and backward through the mean head and the exploration (the features are not detached). */
static void ActorGradients(TQC *t, Scalar alpha)
{
  const PetscInt H = t->hidden, B = t->o.batch;
  const Scalar kappa = alpha / (Scalar)B, *h = t->actor_work.out[t->latent.layers - 1], *W = t->actor + t->head_weight;
  Scalar *dh = t->actor_work.delta[t->latent.layers - 1], *gW = t->actor_grad + t->head_weight,
         *gb = t->actor_grad + t->head_bias, *gstd = t->actor_grad + t->log_std, *dg = t->dg, *dm = t->dm, *dS = t->dS;
  const Sample *s = &t->now;

  gb[0] = 0;
  for (PetscInt i = 0; i < B; ++i) {
    const Scalar a = s->action[i], one = 1 - a * a, noise = s->noise[i], S = s->var[i];

    dg[i] = -(t->dqda[i] / (Scalar)B) * one + kappa * (-noise / S + 2 * a * one / (one + (Scalar)1e-6));
    dm[i] = s->mean_raw[i] >= 2 || s->mean_raw[i] <= -2 ? 0 : dg[i] + kappa * noise / S;
    dS[i] = kappa * (noise * noise / (2 * S * S) - 1 / (2 * S));
    gb[0] += dm[i];
  }
  for (PetscInt j = 0; j < H; ++j) {
    const Scalar E = t->explore[j], var = t->sigma[j] * t->sigma[j], w = W[j], *hj = h + j * B;
    Scalar *dhj = dh + j * B, sum_std = 0, sum_w = 0;

    for (PetscInt b = 0; b < B; ++b) {
      dhj[b] = dm[b] * w + dg[b] * E + 2 * dS[b] * hj[b] * var;
      sum_std += dg[b] * hj[b] * E + 2 * dS[b] * hj[b] * hj[b] * var;
      sum_w += dm[b] * hj[b];
    }
    gstd[j] = sum_std;
    gW[j] = sum_w;
  }
}

/* In the order of sb3-contrib: entropy coefficient, critics, actor, target critics. alpha is that before its own
   update: the same in the targets and the actor's loss. */
void TQCUpdate(TQC *t, const Batch *batch, const Scalar eps[], Losses *losses)
{
  const PetscInt B = t->o.batch;
  const Scalar alpha = ScalarExp(t->log_alpha);
  double mean_logp = 0, sum = 0;
  Scalar grad;

  DrawExploration(t, eps);
  ActorForward(t, B, batch->next_obs, PETSC_TRUE, &t->next);
  ActorForward(t, B, batch->obs, PETSC_TRUE, &t->now); /* last: its hidden layers are needed for the backward pass */
  losses->alpha = (double)alpha;
  for (PetscInt b = 0; b < B; ++b) sum += t->now.logp[b] - 1; /* lambda with the entropy against its target -1 */
  grad = (Scalar)(-sum / (double)B);
  losses->entropy = (double)t->log_alpha * (double)grad;
  AdamStep(&t->alpha_adam, t->o.lr, &grad, &t->log_alpha);
  losses->critic = CriticStep(t, batch, alpha);
  losses->mean_q = CriticValue(t, batch->obs, t->now.action);
  for (PetscInt b = 0; b < B; ++b) mean_logp += (double)t->now.logp[b];
  losses->actor = (double)alpha * mean_logp / (double)B - losses->mean_q;
  ActorGradients(t, alpha);
  DenseBackward(&t->latent, t->actor, B, batch->obs, &t->actor_work, t->actor_grad);
  AdamStep(&t->actor_adam, t->o.lr, t->actor_grad, t->actor);
  PolyakAverage(t->ncritic, t->o.tau, t->critics, t->target);
}

#if !defined(TRAIN_DOUBLE)
/* ---- as a learner ---- */

/* Exploration is drawn before every step, as Stable-Baselines3 does with sde_sample_freq -1 and train_freq 1, also when
   it goes unused. Without it the action is tanh(mean). */
static Scalar ActLearner(void *learner, const Scalar obs[], PetscBool explore, PetscBool warm_up, Random *r)
{
  TQC *t = (TQC *)learner;

  for (PetscInt i = 0; explore && i < t->hidden; ++i) t->normals[i] = (Scalar)RandomNormal(r);
  if (explore && warm_up) return (Scalar)(2 * RandomUniform(r) - 1);
  if (explore) DrawExploration(t, t->normals);
  ActorForward(t, 1, obs, explore, &t->now);
  return t->now.action[0];
}

static void Update(void *learner, const Batch *batch, Random *r, Losses *losses)
{
  TQC *t = (TQC *)learner;

  for (PetscInt i = 0; i < t->hidden; ++i) t->normals[i] = (Scalar)RandomNormal(r);
  TQCUpdate(t, batch, t->normals, losses);
}

static void State(void *learner, LearnerState *s)
{
  TQC *t = (TQC *)learner;

  *s = (LearnerState){10,
                      {{"/actor/parameters", t->actor, t->nactor},
                       {"/actor/adam_m", t->actor_adam.m, t->nactor},
                       {"/actor/adam_v", t->actor_adam.v, t->nactor},
                       {"/critics/parameters", t->critics, t->ncritic},
                       {"/critics/target", t->target, t->ncritic},
                       {"/critics/adam_m", t->critic_adam.m, t->ncritic},
                       {"/critics/adam_v", t->critic_adam.v, t->ncritic},
                       {"/entropy/log_alpha", &t->log_alpha, 1},
                       {"/entropy/adam_m", t->alpha_adam.m, 1},
                       {"/entropy/adam_v", t->alpha_adam.v, 1}},
                      {&t->actor_adam.t, &t->critic_adam.t, &t->alpha_adam.t}};
}

/* The hidden layers and the head of the mean, which follows them in the parameters. */
static void Policy(void *learner, DenseShape *layers)
{
  const TQC *t = (const TQC *)learner;

  LearnerShape(1, t->o.obs, t->o.actor_layers, t->o.actor, 1, layers);
}

const Learner LearnerTQC = {"tqc",      sizeof(TQC), 5,      3e-4,  PETSC_TRUE, TQCCreate,
                            TQCDestroy, ActLearner,  Update, State, Policy};
#endif
