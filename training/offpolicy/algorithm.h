/* The table of algorithms that train a policy, -train_algorithm. A row owns a whole training run on one process: it may
   use the replay-based trainer (trainer.h), or nothing but episodes of the environment (environment.h). */
#pragma once
#include "environment/environment.h"

typedef struct _TrainOptions TrainOptions;

typedef struct {
  const char *name, *meaning;
  PetscErrorCode (*options)(TrainOptions *o); /* read and check the algorithm's own options; NULL: it has none */
  /* Train the policy that o describes, on one process, and write o->output; also o->log and o->checkpoint if named. Of
     several at once on different ranks, each calls SweepYield() (sweep.h) once a second or so. */
  PetscErrorCode (*run)(const TrainOptions *o);
} Algorithm;

PETSC_INTERN PetscErrorCode AlgorithmFind(const char name[], const Algorithm **row);
