/* The interaction loop of TQC and TD3, see agent.h; the order of Stable-Baselines3's OffPolicyAlgorithm with train_freq
   1. */
#include "agent.h"
#include <slipcompat.h>

PetscInt ReplayWidth(const Replay *r)
{
  return 2 * r->obs + 3;
}

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
  PetscCheck(o->buffer > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "-train_buffer %" PetscInt64_FMT " must be a positive number of transitions", o->buffer);
  a->replay = (Replay){.obs = n->obs, .capacity = o->buffer};
  PetscCall(PetscMalloc1((size_t)o->buffer * (size_t)ReplayWidth(&a->replay), &a->replay.data));
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
  PetscCall(PetscFree(a->replay.data));
  PetscCall(PetscFree5(a->batch.obs, a->batch.next_obs, a->batch.action, a->batch.reward, a->batch.done));
  PetscCall(PetscFree2(a->obs, a->next_obs));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void ReplayAdd(Replay *r, const Scalar obs[], const Scalar next_obs[], Scalar action, Scalar reward, Scalar done)
{
  Scalar *p = r->data + r->next * ReplayWidth(r);

  for (PetscInt i = 0; i < r->obs; ++i) *p++ = obs[i];
  for (PetscInt i = 0; i < r->obs; ++i) *p++ = next_obs[i];
  *p++ = action;
  *p++ = reward;
  *p = done;
  r->next = (r->next + 1) % r->capacity;
  r->size = PetscMin(r->size + 1, r->capacity);
}

static void ReplaySample(const Replay *r, Random *random, PetscInt batch, Batch *b)
{
  for (PetscInt k = 0; k < batch; ++k) {
    const Scalar *p = r->data + (PetscInt64)RandomIndex(random, (uint64_t)r->size) * ReplayWidth(r);

    for (PetscInt i = 0; i < r->obs; ++i) b->obs[i * batch + k] = *p++;
    for (PetscInt i = 0; i < r->obs; ++i) b->next_obs[i * batch + k] = *p++;
    b->action[k] = *p++;
    b->reward[k] = *p++;
    b->done[k] = *p;
  }
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
