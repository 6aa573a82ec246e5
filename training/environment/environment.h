/* The environment: episodes of a problem that an actor steps through, with observations and rewards. The actor sits in
   TSAdapt rl's place, called back by TSSolve() before the first and after every attempt. It knows no problem:
   problem.h. Public headers of the library only. */
#pragma once
#include "problem.h"

/* What the actor is told. Returns the action in [-1, 1] in *action; done: the episode is over and no action is
   needed. */
typedef struct {
  const PetscReal *obs; /* [nobs], scaled */
  PetscReal reward;     /* of the last attempt; 0 without EnvOptions.reward */
  PetscBool first;      /* no attempt yet */
  PetscBool terminated; /* the run reached its end */
  PetscBool truncated;  /* cut off by max_steps */
  PetscBool overruled;  /* a guard rail will replace the next choice */
} EnvMoment;
typedef PetscErrorCode (*EnvActorFn)(const EnvMoment *moment, PetscReal *action, PetscBool *stop, void *ctx);

typedef struct {
  PetscInt attempts, accepted, solves; /* solves: Bathe steps computed */
  PetscReal total;                     /* sum of rewards */
  PetscReal error[ENV_MAX_ERRORS];     /* as Problem.errors names them; NaN without a reference */
  PetscBool finished;                  /* ran to its end */
} EnvResult;

typedef struct {
  EnvOptions o;
  PetscReal cost_min, cost_max;                         /* running extrema over successful attempts of all episodes */
  PetscReal obs_min[ENV_MAX_OBS], obs_max[ENV_MAX_OBS]; /* range of the observations met, unscaled */
  /* the episode under way */
  EnvRun run;
  EnvJudge judge;           /* NULL: neither effects nor errors */
  PetscReal dt_min, dt_max; /* [s] */
  PetscReal obs[ENV_MAX_OBS];
  EnvActorFn actor;
  void *ctx;
  EnvResult result;
  PetscBool stopped;
} Environment;

PETSC_INTERN PetscErrorCode RewardFind(const char name[], const Reward **row); /* -train_reward */
PETSC_INTERN const char *ProblemPolicy(const Problem *p); /* the problem that its policies are for */
PETSC_INTERN const Preset *ProblemPreset(const Problem *p, const char reward[]);
PETSC_INTERN PetscErrorCode ProblemDraw(const Problem *p, Random *random, PetscReal drawn[]); /* [ndraw] */
/* Copies of names in place of those that are there, and what brings each to order one: the network sees value * scale +
   offset. */
PETSC_INTERN PetscErrorCode EnvObservationsSet(PetscInt n, const char *const names[], PetscInt *nobs, char *copies[],
                                               PetscReal scale[], PetscReal offset[]);
PETSC_INTERN PetscErrorCode EnvCreate(const EnvOptions *o, Environment *env);
/* The problem of the options when random is NULL, a drawn one otherwise; reference: know its exact solution, for errors
   and for rewards that need the continuation. */
PETSC_INTERN PetscErrorCode EnvInstanceCreate(const EnvOptions *o, Random *random, PetscBool reference,
                                              EnvInstance *instance);
PETSC_INTERN PetscErrorCode EnvInstanceDestroy(const EnvOptions *o, EnvInstance *instance);
/* One run of an instance, from its start to its end, to max_steps attempts, or until the actor stops it. Its errors are
   in the result when the instance has a reference. */
PETSC_INTERN PetscErrorCode EnvRunInstance(Environment *env, const EnvInstance *instance, EnvActorFn actor, void *ctx,
                                           EnvResult *result);
/* One episode: an instance that random draws when -train_random is set, with a reference when the reward needs it. */
PETSC_INTERN PetscErrorCode EnvRunEpisode(Environment *env, Random *random, EnvActorFn actor, void *ctx,
                                          EnvResult *result);
/* The relative tolerance of a TS, or PETSC_DEFAULT for that it has; its absolute ones by a factor */
PETSC_INTERN PetscErrorCode EnvSetTolerances(TS ts, PetscReal rtol, PetscReal factor);
