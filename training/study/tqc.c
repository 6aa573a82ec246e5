/* The TQC agent: its networks, its life and its actions. The gradient step is in tqcupdate.c. */
#include "tqc.h"
#include <slipcompat.h>

PetscInt TQCNoiseCount(const TQC *t)
{
  return t->o.gaussian ? 2 * t->o.batch : t->hidden;
}

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
  t->nactor = t->log_std + (size_t)(H + (o->gaussian ? 1 : 0));
  t->ncritic = (size_t)o->critics * t->critic.count;
  t->log_alpha = 0;
  PetscCall(PetscMalloc2(t->nactor, &t->actor, t->nactor, &t->actor_grad));
  PetscCall(PetscMalloc3(t->ncritic, &t->critics, t->ncritic, &t->target, t->ncritic, &t->critic_grad));
  DenseInitialize(&t->latent, r, t->actor);
  for (size_t i = t->head_weight; i < t->log_std; ++i) t->actor[i] = (Scalar)(bound * (2 * RandomUniform(r) - 1));
  for (size_t i = t->log_std; i < t->nactor; ++i)
    t->actor[i] = o->gaussian ? (Scalar)(bound * (2 * RandomUniform(r) - 1)) : -3;
  DenseInitialize(&t->critic, r, t->critics);
  PetscCall(PetscArraycpy(t->target, t->critics, t->ncritic));
  PetscCall(AdamCreate(t->nactor, &t->actor_adam));
  PetscCall(AdamCreate(t->ncritic, &t->critic_adam));
  PetscCall(AdamCreate(1, &t->alpha_adam));
  /* work space */
  PetscCall(DenseWorkCreate(&t->latent, o->batch, &t->actor_work));
  PetscCall(DenseWorkCreate(&t->critic, o->batch, &t->critic_work));
  for (int k = 0; k < 2; ++k)
    PetscCall(PetscCalloc7(B, &s[k]->mean_raw, B, &s[k]->mean, B, &s[k]->noise, B, &s[k]->var, B, &s[k]->std_raw, B,
                           &s[k]->action, B, &s[k]->logp));
  PetscCall(PetscCalloc3((size_t)H, &t->sigma, (size_t)H, &t->explore, (size_t)TQCNoiseCount(t), &t->normals));
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
    PetscCall(PetscFree7(s[k]->mean_raw, s[k]->mean, s[k]->noise, s[k]->var, s[k]->std_raw, s[k]->action, s[k]->logp));
  PetscCall(PetscFree3(t->sigma, t->explore, t->normals));
  PetscCall(PetscFree2(t->input, t->z));
  PetscCall(PetscFree4(t->dqda, t->dS, t->dg, t->dm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#if !defined(TRAIN_DOUBLE)
/* ---- as a learner ---- */

/* The action at obs [O]. eps: standard normals [H], without gSDE one; NULL: the deterministic tanh(mean). */
static Scalar ChooseAction(TQC *t, const Scalar obs[], const Scalar eps[])
{
  const PetscInt H = t->hidden;
  const Scalar *h = t->actor_work.out[t->latent.layers - 1], *head = t->actor + t->head_weight,
               *bias = t->actor + t->head_bias, *std = t->actor + t->log_std;

  DenseForward(&t->latent, t->actor, 1, obs, &t->actor_work);
  if (t->o.gaussian)
    GaussSample(H, 1, h, head, bias, std, std + H, eps, &t->now);
  else {
    for (PetscInt i = 0; eps && i < H; ++i) {
      t->sigma[i] = ScalarExp(std[i]);
      t->explore[i] = t->sigma[i] * eps[i];
    }
    GSDESample(H, 1, h, head, bias, eps ? t->sigma : NULL, eps ? t->explore : NULL, &t->now);
  }
  return t->now.action[0];
}

/* Exploration is drawn before every step, as Stable-Baselines3 does with sde_sample_freq -1 and train_freq 1, also when
   it goes unused. */
static Scalar ActLearner(void *learner, const Scalar obs[], PetscBool explore, PetscBool warm_up, Random *r)
{
  TQC *t = (TQC *)learner;
  const PetscInt n = t->o.gaussian ? 1 : t->hidden;

  for (PetscInt i = 0; explore && i < n; ++i) t->normals[i] = (Scalar)RandomNormal(r);
  if (explore && warm_up) return (Scalar)(2 * RandomUniform(r) - 1);
  return ChooseAction(t, obs, explore ? t->normals : NULL);
}

static void Update(void *learner, const Batch *batch, Random *r, Losses *losses)
{
  TQC *t = (TQC *)learner;

  for (PetscInt i = 0; i < TQCNoiseCount(t); ++i) t->normals[i] = (Scalar)RandomNormal(r);
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
static void Policy(void *learner, DenseShape *layers, PetscBool *clamp)
{
  const TQC *t = (const TQC *)learner;

  LearnerShape(1, t->o.obs, t->o.actor_layers, t->o.actor, 1, layers);
  *clamp = t->o.gaussian ? PETSC_FALSE : PETSC_TRUE;
}

const Learner LearnerTQC = {"tqc",      sizeof(TQC), 5,      3e-4,  PETSC_TRUE, TQCCreate,
                            TQCDestroy, ActLearner,  Update, State, Policy};
#endif
