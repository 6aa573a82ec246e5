/* Replay buffer, see replay.h. */
#include "replay.h"
#include <slipcompat.h>

PetscInt ReplayWidth(const Replay *r)
{
  return 2 * r->obs + 3;
}

PetscErrorCode ReplayCreate(PetscInt obs, PetscInt64 capacity, Replay *r)
{
  PetscFunctionBegin;
  PetscCheck(capacity > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "-train_buffer %" PetscInt64_FMT " must be a positive number of transitions", capacity);
  *r = (Replay){.obs = obs, .capacity = capacity};
  PetscCall(PetscMalloc1((size_t)capacity * (size_t)ReplayWidth(r), &r->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReplayDestroy(Replay *r)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(r->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void ReplayAdd(Replay *r, const Scalar obs[], const Scalar next_obs[], Scalar action, Scalar reward, Scalar done)
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

void ReplaySample(const Replay *r, Random *random, PetscInt batch, Batch *b)
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
