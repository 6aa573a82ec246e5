/* The interaction loop of TQC and TD3, see agent.h; the order of Stable-Baselines3's OffPolicyAlgorithm with train_freq
   1. */
#include "agent.h"
#include <slipcompat.h>

PetscErrorCode AgentCreate(const AgentOptions *o, uint64_t seed, Agent *a)
{
  const LearnerOptions *n = &o->networks;
  const size_t B = (size_t)n->batch, O = (size_t)n->obs;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(a, sizeof(*a)));
  a->o = *o;
  RandomSeed(&a->random, seed);
  PetscCall(PetscCalloc1(o->learner->size, (char **)&a->learner));
  PetscCall(o->learner->create(n, &a->random, a->learner));
  PetscCall(ReplayCreate(n->obs, o->buffer, &a->replay));
  PetscCall(PetscCalloc5(O * B, &a->batch.obs, O * B, &a->batch.next_obs, B, &a->batch.action, B, &a->batch.reward, B,
                         &a->batch.done));
  PetscCall(PetscCalloc2(O, &a->obs, O, &a->next_obs));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AgentDestroy(Agent *a)
{
  PetscFunctionBegin;
  PetscCall(a->o.learner->destroy(a->learner));
  PetscCall(PetscFree(a->learner));
  PetscCall(ReplayDestroy(&a->replay));
  PetscCall(PetscFree5(a->batch.obs, a->batch.next_obs, a->batch.action, a->batch.reward, a->batch.done));
  PetscCall(PetscFree2(a->obs, a->next_obs));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal AgentAct(Agent *a, const PetscReal obs[], PetscBool explore)
{
  const PetscInt n = a->o.networks.obs;
  const PetscBool warm_up = a->steps < a->o.learning_starts ? PETSC_TRUE : PETSC_FALSE;
  Scalar action;

  for (PetscInt i = 0; i < n; ++i) a->next_obs[i] = (Scalar)obs[i];
  action = a->o.learner->act(a->learner, a->next_obs, explore, warm_up, &a->random);
  if (!explore) return (PetscReal)action;
  for (PetscInt i = 0; i < n; ++i) a->obs[i] = a->next_obs[i];
  a->action = action;
  a->pending = PETSC_TRUE;
  return (PetscReal)action;
}

void AgentLearn(Agent *a, const PetscReal next_obs[], PetscReal reward, PetscBool terminated)
{
  if (!a->pending) return;
  a->pending = PETSC_FALSE;
  for (PetscInt i = 0; i < a->o.networks.obs; ++i) a->next_obs[i] = (Scalar)next_obs[i];
  ReplayAdd(&a->replay, a->obs, a->next_obs, a->action, (Scalar)reward, terminated ? 1 : 0);
  a->steps++;
  if (a->replay.size <= PetscMin(a->o.learning_starts, a->replay.capacity - 1)) return; /* also after a transfer */
  ReplaySample(&a->replay, &a->random, a->o.networks.batch, &a->batch);
  a->o.learner->update(a->learner, &a->batch, &a->random, &a->losses);
  a->updates++;
}

void AgentForget(Agent *a)
{
  a->pending = PETSC_FALSE;
}
