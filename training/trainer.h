/* A training run on one rank: environment, agent, options, log, files. */
#pragma once
#include "agent.h"
#include "environment.h"

typedef struct {
  PetscInt64 steps; /* environment steps, in total with those of a resumed checkpoint */
  PetscInt seed;
  PetscInt progress;          /* steps between progress lines, 0: none */
  PetscInt evaluate_interval; /* steps between evaluations of the deterministic policy, 0: none */
  PetscInt evaluate_episodes;
  PetscInt checkpoint_interval;        /* steps between checkpoints */
  char output[PETSC_MAX_PATH_LEN];     /* policy */
  char log[PETSC_MAX_PATH_LEN];        /* learning curve */
  char resume[PETSC_MAX_PATH_LEN];     /* checkpoint to continue */
  char checkpoint[PETSC_MAX_PATH_LEN]; /* checkpoint to write */
  AgentOptions agent;
  EnvOptions env;
} TrainOptions;

typedef struct _TrainLog *TrainLog;

typedef struct {
  TrainOptions o;
  Agent agent;
  Environment env;
  Random faults; /* draws the episodes' faults */
  PetscInt64 episodes;
  PetscInt64 evaluated, checkpointed; /* steps at the last evaluation and checkpoint */
  double best;                        /* mean return of the best evaluation, whose actor is kept: */
  Scalar *best_actor;                 /* [nactor], of the last step when nothing was evaluated */
  PetscInt64 best_steps;
  TrainLog log;
  PetscLogDouble begin;   /* wall time at the start [s] */
  PetscInt64 begin_steps; /* steps that the resumed checkpoint had */
  PetscInt rank, size;
} Trainer;

PETSC_INTERN PetscErrorCode TrainOptionsSet(MPI_Comm comm,
                                            TrainOptions *o); /* -train_*, with the rank's seed, alpha and file names */
PETSC_INTERN PetscErrorCode TrainerCreate(MPI_Comm comm, const TrainOptions *o, Trainer *t);
PETSC_INTERN PetscErrorCode TrainerRun(Trainer *t); /* to the end; writes policy, log and checkpoint */
PETSC_INTERN PetscErrorCode TrainerDestroy(Trainer *t);

PETSC_INTERN PetscErrorCode TrainerStorePolicy(Trainer *t, const char file[]);
PETSC_INTERN PetscErrorCode CheckpointWrite(Trainer *t, const char file[]);
PETSC_INTERN PetscErrorCode CheckpointRead(Trainer *t, const char file[]);

/* Learning curve: groups /episodes and /evaluations, one row each. */
PETSC_INTERN PetscErrorCode TrainLogOpen(const Trainer *t, const char file[], TrainLog *log);
PETSC_INTERN PetscErrorCode TrainLogEpisode(TrainLog log, const Trainer *t, const EnvResult *r);
PETSC_INTERN PetscErrorCode TrainLogEvaluation(TrainLog log, const Trainer *t, double mean_return, double attempts,
                                               double slip_error);
PETSC_INTERN PetscErrorCode TrainLogClose(TrainLog *log);
