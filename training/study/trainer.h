/* A training run with a replay buffer on one process: environment, agent, options, log, files. */
#pragma once
#include "agent.h"
#include "environment/environment.h"
#include <slipstep/rooms/sliph5.h>

#define TRAIN_MAX_LIST 64

typedef struct {
  PetscInt64 steps; /* environment steps, in total with those of a resumed checkpoint */
  PetscInt seed;
  PetscInt nalpha, nseed, seeds[TRAIN_MAX_LIST]; /* of a sweep; env.alpha and seed are those of one training */
  PetscReal alphas[TRAIN_MAX_LIST];
  char label[64];             /* before each progress line: which of several trainings it is */
  PetscInt progress;          /* steps between progress lines, 0: none */
  PetscInt evaluate_interval; /* steps between evaluations of the deterministic policy, 0: none */
  PetscInt evaluate_episodes;
  PetscInt checkpoint_interval;        /* steps between checkpoints */
  PetscBool transfer;                  /* the checkpoint is of another instance of the problem */
  char output[PETSC_MAX_PATH_LEN];     /* policy */
  char log[PETSC_MAX_PATH_LEN];        /* learning curve */
  char resume[PETSC_MAX_PATH_LEN];     /* checkpoint to continue */
  char checkpoint[PETSC_MAX_PATH_LEN]; /* checkpoint to write */
  AgentOptions agent;
  EnvOptions env;
} TrainOptions;

typedef struct {
  TrainOptions o;
  Agent agent;
  Environment env;
  Random instances;        /* draws the episodes' instances */
  EnvInstance *evaluation; /* [evaluate_episodes] instances of the evaluations */
  PetscInt64 episodes;
  PetscInt64 evaluated, checkpointed; /* steps at the last evaluation and checkpoint */
  double best;                        /* mean return of the best evaluation, whose actor is kept: */
  Scalar *actor;                      /* [nactor], the learner's, borrowed */
  size_t nactor;
  Scalar *best_actor; /* [nactor], of the last step when nothing was evaluated */
  PetscInt64 best_steps;
  SlipH5 *log;            /* NULL: none */
  PetscLogDouble begin;   /* wall time at the start [s] */
  PetscInt64 begin_steps; /* steps that the resumed checkpoint had */
} Trainer;

/* -train_*; alpha and seed are the first of their lists */
PETSC_INTERN PetscErrorCode TrainOptionsSet(MPI_Comm comm, TrainOptions *o);
PETSC_INTERN PetscErrorCode TrainOptionsFree(TrainOptions *o);
PETSC_INTERN PetscErrorCode TrainerTrain(const TrainOptions *o); /* create, run, destroy */
PETSC_INTERN PetscErrorCode TrainerCreate(const TrainOptions *o, Trainer *t);
PETSC_INTERN PetscErrorCode TrainerRun(Trainer *t); /* to the end; writes policy, log and checkpoint */
PETSC_INTERN PetscErrorCode TrainerDestroy(Trainer *t);

PETSC_INTERN PetscErrorCode TrainerStorePolicy(Trainer *t, const char file[]);
PETSC_INTERN PetscErrorCode CheckpointWrite(Trainer *t, const char file[]);
PETSC_INTERN PetscErrorCode CheckpointRead(Trainer *t, const char file[]);

/* Learning curve: groups /episodes and /evaluations, one row each. The file begins with the first row: a training that
   fails before it leaves none. */
PETSC_INTERN PetscErrorCode TrainLogEpisode(Trainer *t, const EnvResult *r);
PETSC_INTERN PetscErrorCode TrainLogEvaluation(Trainer *t, double mean_return, double attempts, double error);

/* All that the -train_ options say: one training, or one for each alpha and seed (sweep.c). Collective. A training of
   several that fails says why and does not stop the others; failed: how many did, on all ranks. */
PETSC_INTERN PetscErrorCode SweepTrain(MPI_Comm comm, PetscInt *failed);
