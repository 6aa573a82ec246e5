/* Replay buffer: a ring of transitions, sampled uniformly with replacement. */
#pragma once
#include "learner.h"

typedef struct {
  PetscInt obs;
  PetscInt64 capacity, size, next; /* transitions held at most, held now; where the next one goes */
  Scalar *data;                    /* [capacity][2 obs + 3]: obs, next_obs, action, reward, done */
} Replay;

PETSC_INTERN PetscErrorCode ReplayCreate(PetscInt obs, PetscInt64 capacity, Replay *r);
PETSC_INTERN PetscErrorCode ReplayDestroy(Replay *r);
PETSC_INTERN PetscInt ReplayWidth(const Replay *r);
/* done: 1 when the episode truly ended (no bootstrapping), 0 also when it was merely cut off */
PETSC_INTERN void ReplayAdd(Replay *r, const Scalar obs[], const Scalar next_obs[], Scalar action, Scalar reward,
                            Scalar done);
PETSC_INTERN void ReplaySample(const Replay *r, Random *random, PetscInt batch, Batch *b);
