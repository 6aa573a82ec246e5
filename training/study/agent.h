/* The learner where a policy would stand: acts, stores what came of it, takes one gradient step per environment step.
   It knows no environment: observations in, action in [-1, 1] out. */
#pragma once
#include "learner.h"

/* A ring of transitions, sampled uniformly with replacement. done: 1 when the episode truly ended (no bootstrapping), 0
   also when it was merely cut off */
typedef struct {
  PetscInt obs;
  PetscInt64 capacity, size, next; /* transitions held at most, held now; where the next one goes */
  Scalar *data;                    /* [capacity][2 obs + 3]: obs, next_obs, action, reward, done */
} Replay;
PETSC_INTERN PetscInt ReplayWidth(const Replay *r);

typedef struct {
  const Learner *learner;
  LearnerOptions networks;
  PetscInt64 buffer;          /* capacity of the replay buffer in transitions */
  PetscInt64 learning_starts; /* steps with uniformly random actions before learning */
} AgentOptions;

typedef struct {
  AgentOptions o;
  void *learner;
  Replay replay;
  Random random;
  PetscInt64 steps;   /* environment steps stored */
  PetscInt64 updates; /* gradient steps done */
  Losses losses;      /* of the last gradient step */
  /* work space */
  Batch batch;
  Scalar *obs, *next_obs; /* scaled observations of the transition under way */
  Scalar action;
  PetscBool pending; /* obs and action await their outcome; no: the action will not be carried out */
} Agent;

PETSC_INTERN PetscErrorCode AgentCreate(const AgentOptions *o, uint64_t seed, Agent *a);
PETSC_INTERN PetscErrorCode AgentDestroy(Agent *a);
/* Action at obs [O]: exploring (random at first, then the policy with the learner's noise), or the deterministic
   policy's. */
PETSC_INTERN PetscReal AgentAct(Agent *a, const PetscReal obs[], PetscBool explore);
/* The outcome of the last exploring action: stores the transition and learns. Without a pending action nothing
   happens. */
PETSC_INTERN void AgentLearn(Agent *a, const PetscReal next_obs[], PetscReal reward, PetscBool terminated);
