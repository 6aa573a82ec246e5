/* The TQC interaction loop, see agent.h; the order of Stable-Baselines3's OffPolicyAlgorithm with train_freq 1. */
#include "agent.h"
#include <slipstep/private/slipcompat.h>

PetscErrorCode AgentCreate(const AgentOptions *o, uint64_t seed, Agent *a)
{
  const size_t B = (size_t)o->tqc.batch, O = (size_t)o->tqc.obs, A = (size_t)o->tqc.act;

  PetscFunctionBegin;
  PetscCheck(o->tqc.act == 1, PETSC_COMM_SELF, PETSC_ERR_SUP, "The agent chooses 1 action, not %" PetscInt_FMT,
             o->tqc.act);
  PetscCall(PetscMemzero(a, sizeof(*a)));
  a->o = *o;
  RandomSeed(&a->random, seed);
  PetscCall(TQCCreate(&o->tqc, &a->random, &a->tqc));
  PetscCall(ReplayCreate(o->tqc.obs, o->tqc.act, o->buffer, &a->replay));
  PetscCall(PetscCalloc5(O * B, &a->batch.obs, O * B, &a->batch.next_obs, A * B, &a->batch.action, B, &a->batch.reward,
                         B, &a->batch.done));
  PetscCall(PetscCalloc3((size_t)o->tqc.hidden * A, &a->eps, O, &a->obs, O, &a->next_obs));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AgentDestroy(Agent *a)
{
  PetscFunctionBegin;
  PetscCall(TQCDestroy(&a->tqc));
  PetscCall(ReplayDestroy(&a->replay));
  PetscCall(PetscFree5(a->batch.obs, a->batch.next_obs, a->batch.action, a->batch.reward, a->batch.done));
  PetscCall(PetscFree3(a->eps, a->obs, a->next_obs));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void DrawExploration(Agent *a)
{
  for (PetscInt i = 0; i < a->o.tqc.hidden * a->o.tqc.act; ++i) a->eps[i] = (Scalar)RandomNormal(&a->random);
}

PetscReal AgentAct(Agent *a, const PetscReal obs[], PetscBool explore)
{
  Scalar action;

  for (PetscInt i = 0; i < a->o.tqc.obs; ++i) a->next_obs[i] = (Scalar)obs[i];
  if (!explore) {
    TQCSample(&a->tqc, 1, a->next_obs, NULL, &action);
    return (PetscReal)action;
  }
  DrawExploration(a); /* before every step, as Stable-Baselines3 does with sde_sample_freq -1 and train_freq 1 */
  if (a->steps < a->o.learning_starts)
    action = (Scalar)(2 * RandomUniform(&a->random) - 1);
  else
    TQCSample(&a->tqc, 1, a->next_obs, a->eps, &action);
  for (PetscInt i = 0; i < a->o.tqc.obs; ++i) a->obs[i] = a->next_obs[i];
  a->action = action;
  a->pending = PETSC_TRUE;
  return (PetscReal)action;
}

void AgentLearn(Agent *a, const PetscReal next_obs[], PetscReal reward, PetscBool terminated)
{
  if (!a->pending) return;
  a->pending = PETSC_FALSE;
  for (PetscInt i = 0; i < a->o.tqc.obs; ++i) a->next_obs[i] = (Scalar)next_obs[i];
  ReplayAdd(&a->replay, a->obs, a->next_obs, &a->action, (Scalar)reward, terminated ? 1 : 0);
  if (++a->steps <= a->o.learning_starts) return;
  ReplaySample(&a->replay, &a->random, a->o.tqc.batch, &a->batch);
  DrawExploration(a);
  TQCUpdate(&a->tqc, &a->batch, a->eps, &a->losses);
  a->updates++;
}

void AgentForget(Agent *a)
{
  a->pending = PETSC_FALSE;
}
