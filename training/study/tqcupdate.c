/* One gradient step of TQC, in the order of sb3-contrib: entropy coefficient, critics, actor, target critics. */
#include "tqc.h"

/* Critic input: observations above actions, [O + 1][B]. */
static void CriticInput(TQC *t, const Scalar obs[], const Scalar action[])
{
  const size_t no = (size_t)(t->o.obs * t->o.batch), na = (size_t)t->o.batch;

  for (size_t i = 0; i < no; ++i) t->input[i] = obs[i];
  for (size_t i = 0; i < na; ++i) t->input[no + i] = action[i];
}

/* eps: of the Gaussian [B]; gSDE's is in t->explore already */
static void ActorForward(TQC *t, const Scalar obs[], const Scalar eps[], Sample *s)
{
  const PetscInt H = t->hidden, B = t->o.batch;
  const Scalar *h = t->actor_work.out[t->latent.layers - 1], *head = t->actor + t->head_weight,
               *bias = t->actor + t->head_bias, *std = t->actor + t->log_std;

  DenseForward(&t->latent, t->actor, B, obs, &t->actor_work);
  if (t->o.gaussian)
    GaussSample(H, B, h, head, bias, std, std + H, eps, s);
  else
    GSDESample(H, B, h, head, bias, t->sigma, t->explore, s);
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
     dS = (alpha/B) (n^2/(2 S^2) - 1/(2 S)). */
static void HeadGradients(TQC *t, Scalar alpha)
{
  const PetscInt n = t->o.batch;
  const Scalar B = (Scalar)t->o.batch, kappa = alpha / B;
  const Sample *s = &t->now;

  for (PetscInt i = 0; i < n; ++i) {
    const Scalar a = s->action[i], one = 1 - a * a, noise = s->noise[i], S = s->var[i];

    t->dg[i] = -(t->dqda[i] / B) * one + kappa * (-noise / S + 2 * a * one / (one + (Scalar)1e-6));
    t->dm[i] = s->mean_raw[i] >= 2 || s->mean_raw[i] <= -2 ? 0 : t->dg[i] + kappa * noise / S;
    t->dS[i] = kappa * (noise * noise / (2 * S * S) - 1 / (2 * S));
  }
}

/* Backward through the mean head and the exploration (the features are not detached). */
static void GSDEBackward(TQC *t)
{
  const PetscInt H = t->hidden, B = t->o.batch;
  const Scalar *h = t->actor_work.out[t->latent.layers - 1], *W = t->actor + t->head_weight, *dg = t->dg, *dm = t->dm,
               *dS = t->dS;
  Scalar *dh = t->actor_work.delta[t->latent.layers - 1], *gW = t->actor_grad + t->head_weight,
         *gb = t->actor_grad + t->head_bias, *gstd = t->actor_grad + t->log_std;

  gb[0] = 0;
  for (PetscInt b = 0; b < B; ++b) gb[0] += dm[b];
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

void TQCUpdate(TQC *t, const Batch *batch, const Scalar eps[], Losses *losses)
{
  const PetscInt B = t->o.batch;
  const Scalar alpha =
    ScalarExp(t->log_alpha); /* before its own update: the same in the targets and the actor's loss */
  const Scalar *h = t->actor_work.out[t->latent.layers - 1];
  Scalar *dh = t->actor_work.delta[t->latent.layers - 1], *g = t->actor_grad, *p = t->actor, grad;
  double mean_logp = 0, sum = 0;

  for (PetscInt i = 0; i < t->hidden && !t->o.gaussian; ++i) {
    t->sigma[i] = ScalarExp(t->actor[t->log_std + (size_t)i]);
    t->explore[i] = t->sigma[i] * eps[i];
  }
  ActorForward(t, batch->next_obs, eps + B * (t->o.gaussian ? 1 : 0), &t->next);
  ActorForward(t, batch->obs, eps, &t->now); /* last: its hidden layers are needed for the backward pass */
  losses->alpha = (double)alpha;
  for (PetscInt b = 0; b < B; ++b) sum += t->now.logp[b] - 1; /* lambda with the entropy against its target -1 */
  grad = (Scalar)(-sum / (double)B);
  losses->entropy = (double)t->log_alpha * (double)grad;
  AdamStep(&t->alpha_adam, t->o.lr, &grad, &t->log_alpha);
  losses->critic = CriticStep(t, batch, alpha);
  losses->mean_q = CriticValue(t, batch->obs, t->now.action);
  for (PetscInt b = 0; b < B; ++b) mean_logp += (double)t->now.logp[b];
  losses->actor = (double)alpha * mean_logp / (double)B - losses->mean_q;
  if (t->o.gaussian) {
    GaussGradients(B, alpha, t->dqda, &t->now, t->dm, t->dS);
    HeadBackward(t->hidden, B, h, p + t->head_weight, t->dm, PETSC_TRUE, g + t->head_weight, g + t->head_bias, dh);
    HeadBackward(t->hidden, B, h, p + t->log_std, t->dS, PETSC_FALSE, g + t->log_std,
                 g + t->log_std + (size_t)t->hidden, dh);
  } else {
    HeadGradients(t, alpha);
    GSDEBackward(t);
  }
  DenseBackward(&t->latent, p, B, batch->obs, &t->actor_work, g);
  AdamStep(&t->actor_adam, t->o.lr, g, p);
  PolyakAverage(t->ncritic, t->o.tau, t->critics, t->target);
}
