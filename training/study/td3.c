/* TD3: its networks and its gradient step, in the order of Stable-Baselines3: critics, then every o.delay steps actor
   and targets. */
#include "td3.h"
#include <slipcompat.h>

PetscErrorCode TD3Create(const LearnerOptions *o, Random *r, void *learner)
{
  TD3 *t = (TD3 *)learner;
  const size_t B = (size_t)o->batch;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(t, sizeof(*t)));
  PetscCall(LearnerCheckOptions(o));
  t->o = *o;
  LearnerShape(1, o->obs, o->actor_layers, o->actor, 1, &t->actor_shape);
  LearnerShape(o->critics, o->obs + 1, o->critic_layers, o->critic, 1, &t->critic_shape);
  LearnerShape(1, o->obs + 1, o->critic_layers, o->critic, 1, &t->first_critic);
  t->nactor = t->actor_shape.count;
  t->ncritic = (size_t)o->critics * t->critic_shape.count;
  PetscCall(PetscMalloc3(t->nactor, &t->actor, t->nactor, &t->actor_target, t->nactor, &t->actor_grad));
  PetscCall(PetscMalloc3(t->ncritic, &t->critics, t->ncritic, &t->critic_target, t->ncritic, &t->critic_grad));
  DenseInitialize(&t->actor_shape, r, t->actor);
  DenseInitialize(&t->critic_shape, r, t->critics);
  PetscCall(PetscArraycpy(t->actor_target, t->actor, t->nactor));
  PetscCall(PetscArraycpy(t->critic_target, t->critics, t->ncritic));
  PetscCall(AdamCreate(t->nactor, &t->actor_adam));
  PetscCall(AdamCreate(t->ncritic, &t->critic_adam));
  PetscCall(DenseWorkCreate(&t->actor_shape, o->batch, &t->actor_work));
  PetscCall(DenseWorkCreate(&t->critic_shape, o->batch, &t->critic_work));
  PetscCall(
    PetscCalloc5((size_t)((o->obs + 1) * o->batch), &t->input, B, &t->y, B, &t->action, B, &t->dqda, B, &t->normals));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TD3Destroy(void *learner)
{
  TD3 *t = (TD3 *)learner;
  PetscFunctionBegin;
  PetscCall(PetscFree3(t->actor, t->actor_target, t->actor_grad));
  PetscCall(PetscFree3(t->critics, t->critic_target, t->critic_grad));
  PetscCall(AdamDestroy(&t->actor_adam));
  PetscCall(AdamDestroy(&t->critic_adam));
  PetscCall(DenseWorkDestroy(&t->actor_work));
  PetscCall(DenseWorkDestroy(&t->critic_work));
  PetscCall(PetscFree5(t->input, t->y, t->action, t->dqda, t->normals));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Actions of the actor with the given parameters; its layers' outputs stay in the work space. */
static void Act(TD3 *t, const Scalar p[], PetscInt B, const Scalar obs[], Scalar action[])
{
  const Scalar *out = t->actor_work.out[t->actor_shape.layers - 1];

  DenseForward(&t->actor_shape, p, B, obs, &t->actor_work);
  for (PetscInt i = 0; i < B; ++i) action[i] = ScalarTanh(out[i]);
}

static Scalar Clip(Scalar x, Scalar limit)
{
  return x > limit ? limit : (x < -limit ? -limit : x);
}

/* Critic values [nets][B] at (obs, action), in the work space. */
static const Scalar *Values(TD3 *t, const DenseShape *s, const Scalar p[], const Scalar obs[], const Scalar action[])
{
  const size_t no = (size_t)(t->o.obs * t->o.batch), na = (size_t)t->o.batch;

  for (size_t i = 0; i < no; ++i) t->input[i] = obs[i];
  for (size_t i = 0; i < na; ++i) t->input[no + i] = action[i];
  DenseForward(s, p, t->o.batch, t->input, &t->critic_work);
  return t->critic_work.out[s->layers - 1];
}

/* y = r + (1 - d) gamma min_i Q_i at the smoothed action of the target actor */
static void Targets(TD3 *t, const Batch *batch, const Scalar noise[])
{
  const PetscInt B = t->o.batch;
  const Scalar *q;

  Act(t, t->actor_target, B, batch->next_obs, t->action);
  for (PetscInt i = 0; i < B; ++i) t->action[i] = Clip(t->action[i] + Clip(noise[i], (Scalar)t->o.smoothing_clip), 1);
  q = Values(t, &t->critic_shape, t->critic_target, batch->next_obs, t->action);
  for (PetscInt b = 0; b < B; ++b) {
    Scalar least = q[b];

    for (PetscInt i = 1; i < t->o.critics; ++i) least = q[i * B + b] < least ? q[i * B + b] : least;
    t->y[b] = batch->reward[b] + (1 - batch->done[b]) * (Scalar)t->o.gamma * least;
  }
}

/* Sum over the critics of the mean squared errors */
static double CriticStep(TD3 *t, const Batch *batch)
{
  const PetscInt B = t->o.batch;
  const Scalar *q = Values(t, &t->critic_shape, t->critics, batch->obs, batch->action);
  Scalar *delta = t->critic_work.delta[t->critic_shape.layers - 1];
  double loss = 0;

  for (PetscInt i = 0; i < t->o.critics; ++i) {
    for (PetscInt b = 0; b < B; ++b) {
      const Scalar e = q[i * B + b] - t->y[b];

      loss += (double)e * (double)e;
      delta[i * B + b] = 2 * e / (Scalar)B;
    }
  }
  DenseBackward(&t->critic_shape, t->critics, B, t->input, &t->critic_work, t->critic_grad);
  AdamStep(&t->critic_adam, t->o.lr, t->critic_grad, t->critics);
  return loss / (double)B;
}

/* Ascent of the first critic's value; returns its mean */
static double ActorStep(TD3 *t, const Batch *batch)
{
  const PetscInt B = t->o.batch, last = t->first_critic.layers - 1;
  const Scalar *q;
  Scalar *delta = t->actor_work.delta[t->actor_shape.layers - 1];
  double sum = 0;

  Act(t, t->actor, B, batch->obs, t->action);
  q = Values(t, &t->first_critic, t->critics, batch->obs, t->action);
  for (PetscInt b = 0; b < B; ++b) {
    sum += (double)q[b];
    t->critic_work.delta[last][b] = -1 / (Scalar)B;
  }
  DenseBackward(&t->first_critic, t->critics, B, t->input, &t->critic_work, NULL);
  DenseInputGradient(&t->first_critic, t->critics, B, &t->critic_work, t->o.obs, t->dqda);
  for (PetscInt i = 0; i < B; ++i) delta[i] = t->dqda[i] * (1 - t->action[i] * t->action[i]);
  DenseBackward(&t->actor_shape, t->actor, B, batch->obs, &t->actor_work, t->actor_grad);
  AdamStep(&t->actor_adam, t->o.lr, t->actor_grad, t->actor);
  return sum / (double)B;
}

void TD3Update(TD3 *t, const Batch *batch, const Scalar noise[], Losses *losses)
{
  t->updates++;
  losses->entropy = losses->alpha = (double)NAN;
  Targets(t, batch, noise);
  losses->critic = CriticStep(t, batch);
  if (t->updates % t->o.delay) return;
  losses->mean_q = ActorStep(t, batch);
  losses->actor = -losses->mean_q;
  PolyakAverage(t->ncritic, t->o.tau, t->critics, t->critic_target);
  PolyakAverage(t->nactor, t->o.tau, t->actor, t->actor_target);
}

#if !defined(TRAIN_DOUBLE)
/* ---- as a learner ---- */

/* The noise is added during the warm-up as well, as Stable-Baselines3 does. */
static Scalar ActLearner(void *learner, const Scalar obs[], PetscBool explore, PetscBool warm_up, Random *r)
{
  TD3 *t = (TD3 *)learner;
  Scalar action;

  if (explore && warm_up)
    action = (Scalar)(2 * RandomUniform(r) - 1);
  else
    Act(t, t->actor, 1, obs, &action);
  return explore ? Clip(action + (Scalar)(t->o.noise * RandomNormal(r)), 1) : action;
}

static void Update(void *learner, const Batch *batch, Random *r, Losses *losses)
{
  TD3 *t = (TD3 *)learner;

  for (PetscInt i = 0; i < t->o.batch; ++i) t->normals[i] = (Scalar)(t->o.smoothing * RandomNormal(r));
  TD3Update(t, batch, t->normals, losses);
}

static void State(void *learner, LearnerState *s)
{
  TD3 *t = (TD3 *)learner;

  *s = (LearnerState){8,
                      {{"/actor/parameters", t->actor, t->nactor},
                       {"/actor/target", t->actor_target, t->nactor},
                       {"/actor/adam_m", t->actor_adam.m, t->nactor},
                       {"/actor/adam_v", t->actor_adam.v, t->nactor},
                       {"/critics/parameters", t->critics, t->ncritic},
                       {"/critics/target", t->critic_target, t->ncritic},
                       {"/critics/adam_m", t->critic_adam.m, t->ncritic},
                       {"/critics/adam_v", t->critic_adam.v, t->ncritic}},
                      {&t->actor_adam.t, &t->critic_adam.t, &t->updates}};
}

static void Policy(void *learner, DenseShape *layers)
{
  *layers = ((TD3 *)learner)->actor_shape;
}

const Learner LearnerTD3 = {"td3",      sizeof(TD3), 2,      1e-3,  PETSC_FALSE, TD3Create,
                            TD3Destroy, ActLearner,  Update, State, Policy};
#endif
