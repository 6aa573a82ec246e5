/* The TQC agent: its networks, its life and its actions. The gradient step is in tqcupdate.c. */
#include "tqc.h"
#include <slipstep/private/slipcompat.h>

static PetscErrorCode GSDECreate(PetscInt A, PetscInt B, GSDE *s)
{
  const size_t n = (size_t)(A * B);

  PetscFunctionBegin;
  PetscCall(PetscCalloc6(n, &s->mean_raw, n, &s->mean, n, &s->noise, n, &s->var, n, &s->action, (size_t)B, &s->logp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode GSDEDestroy(GSDE *s)
{
  PetscFunctionBegin;
  PetscCall(PetscFree6(s->mean_raw, s->mean, s->noise, s->var, s->action, s->logp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TQCCreateWork(TQC *t)
{
  const TQCOptions *o = &t->o;
  const size_t HA = (size_t)(o->hidden * o->act), AB = (size_t)(o->act * o->batch);

  PetscFunctionBegin;
  PetscCall(DenseWorkCreate(&t->latent, o->batch, &t->actor_work));
  PetscCall(DenseWorkCreate(&t->critic, o->batch, &t->critic_work));
  PetscCall(GSDECreate(o->act, o->batch, &t->now));
  PetscCall(GSDECreate(o->act, o->batch, &t->next));
  PetscCall(PetscCalloc2(HA, &t->sigma, HA, &t->explore));
  PetscCall(PetscCalloc2((size_t)((o->obs + o->act) * o->batch), &t->input,
                         (size_t)(o->critics * o->quantiles * o->batch), &t->z));
  PetscCall(PetscCalloc4(AB, &t->dqda, AB, &t->dS, AB, &t->dg, AB, &t->dm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TQCCreate(const TQCOptions *o, Random *r, TQC *t)
{
  const PetscInt actor_size[] = {o->obs, o->hidden, o->hidden};
  const PetscInt critic_size[] = {o->obs + o->act, o->hidden, o->hidden, o->hidden, o->quantiles};
  const double bound = 1 / sqrt((double)o->hidden);

  PetscFunctionBegin;
  PetscCheck(o->critics > 0 && o->quantiles > 0 && o->hidden > 0 && o->batch > 0, PETSC_COMM_SELF,
             PETSC_ERR_ARG_OUTOFRANGE,
             "Critics %" PetscInt_FMT ", quantiles %" PetscInt_FMT ", hidden %" PetscInt_FMT ", batch %" PetscInt_FMT
             ": all must be positive",
             o->critics, o->quantiles, o->hidden, o->batch);
  PetscCheck(o->drop >= 0 && o->drop < o->quantiles, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "Dropped quantiles per critic %" PetscInt_FMT " must lie in [0, %" PetscInt_FMT ")", o->drop,
             o->quantiles);
  t->o = *o;
  DenseShapeInit(&t->latent, 1, 2, actor_size, PETSC_TRUE);
  DenseShapeInit(&t->critic, o->critics, 4, critic_size, PETSC_FALSE);
  t->head_weight = t->latent.count;
  t->head_bias = t->head_weight + (size_t)(o->act * o->hidden);
  t->log_std = t->head_bias + (size_t)o->act;
  t->nactor = t->log_std + (size_t)(o->hidden * o->act);
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
  PetscCall(TQCCreateWork(t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TQCDestroy(TQC *t)
{
  PetscFunctionBegin;
  PetscCall(PetscFree2(t->actor, t->actor_grad));
  PetscCall(PetscFree3(t->critics, t->target, t->critic_grad));
  PetscCall(AdamDestroy(&t->actor_adam));
  PetscCall(AdamDestroy(&t->critic_adam));
  PetscCall(AdamDestroy(&t->alpha_adam));
  PetscCall(DenseWorkDestroy(&t->actor_work));
  PetscCall(DenseWorkDestroy(&t->critic_work));
  PetscCall(GSDEDestroy(&t->now));
  PetscCall(GSDEDestroy(&t->next));
  PetscCall(PetscFree2(t->sigma, t->explore));
  PetscCall(PetscFree2(t->input, t->z));
  PetscCall(PetscFree4(t->dqda, t->dS, t->dg, t->dm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void TQCSample(TQC *t, PetscInt B, const Scalar obs[], const Scalar eps[], Scalar action[])
{
  const PetscInt H = t->o.hidden, A = t->o.act;

  for (PetscInt i = 0; eps && i < H * A; ++i) {
    t->sigma[i] = ScalarExp(t->actor[t->log_std + (size_t)i]);
    t->explore[i] = t->sigma[i] * eps[i];
  }
  DenseForward(&t->latent, t->actor, B, obs, &t->actor_work);
  GSDESample(H, A, B, t->actor_work.out[1], t->actor + t->head_weight, t->actor + t->head_bias, eps ? t->sigma : NULL,
             eps ? t->explore : NULL, &t->now);
  for (PetscInt i = 0; i < A * B; ++i) action[i] = t->now.action[i];
}
