/* The environment: episodes of a fault that an actor steps through, with observations and rewards. Public headers of
   the library only. The actor sits in TSAdapt rl's place, called back by TSSolve() before the first and after every
   attempt. */
#pragma once
#include "random.h"
#include "reward.h"

#define ENV_MAX_OBS 16

typedef struct {
  char problem[32]; /* "fault" */
  const Reward *reward;
  PetscBool wall_cost; /* cost of an attempt: wall time instead of nonlinear iterations */
  PetscReal alpha;
  PetscBool random; /* draw a fault for every episode */
  PetscInt nobs;
  char *names[ENV_MAX_OBS];                          /* observations */
  PetscReal scale[ENV_MAX_OBS], offset[ENV_MAX_OBS]; /* the network sees obs * scale + offset */
  PetscReal dt_min, dt_max;                          /* bounds of the action */
  char dt_min_unit[8], dt_max_unit[8];               /* "s", "T*" or "t_max" */
  PetscBool log_spacing;
  PetscReal rtol, atol;   /* relative; absolute in units of 0.1 mm and 0.1 mm/T*; 0: the fault's own */
  PetscReal continuation; /* step of the exact continuation [T*] */
  PetscInt max_steps;     /* attempts after which an episode is cut off, 0: never */
} EnvOptions;

/* One simulated fault: its own copy for the run and for the continuation. */
typedef struct {
  SlipFault fault;
  TS ts;
  Vec w;
  PetscReal tstar, tmax; /* [s] */
} EnvRun;

/* What an exact continuation from the current state meets; it watches itself while it runs. */
typedef struct {
  PetscReal slip; /* mean slip at the end [m] */
  PetscReal rate; /* largest slip rate still to come [m/s] */
  PetscReal time; /* when the slip passes nine tenths of its end; the start of the continuation if it already has [s] */
  PetscInt n, capacity; /* its samples ... */
  PetscReal *sample;    /* ... time and largest slip, [n][2] */
} EnvFuture;

/* What the actor is told. Returns the action in [-1, 1] in *action; done: the episode is over and no action is
   needed. */
typedef struct {
  const PetscReal *obs; /* [nobs], scaled */
  PetscReal reward;     /* of the last attempt */
  PetscBool first;      /* no attempt yet */
  PetscBool terminated; /* the run reached its end */
  PetscBool truncated;  /* cut off by max_steps */
  PetscBool overruled;  /* a guard rail will replace the next choice */
} EnvMoment;
typedef PetscErrorCode (*EnvActorFn)(const EnvMoment *moment, PetscReal *action, PetscBool *stop, void *ctx);

typedef struct {
  PetscInt attempts, accepted;
  PetscReal total;                 /* sum of rewards */
  PetscReal final_slip, reference; /* mean slip at the end, and of an exact run (NaN without continuation) [m] */
  PetscBool finished;              /* ran to its end */
} EnvResult;

typedef struct {
  EnvOptions o;
  PetscReal cost_min, cost_max;                         /* running extrema over successful attempts of all episodes */
  PetscReal obs_min[ENV_MAX_OBS], obs_max[ENV_MAX_OBS]; /* range of the observations met, unscaled */
  /* the episode under way */
  EnvRun run, fine;
  PetscReal dt_min, dt_max; /* [s] */
  PetscReal obs[ENV_MAX_OBS];
  EnvFuture start, before, now; /* futures of the start, of the state before the last attempt and of the one after it */
  EnvActorFn actor;
  void *ctx;
  EnvResult result;
  PetscBool stopped;
} Environment;

PETSC_INTERN PetscErrorCode EnvOptionsSet(EnvOptions *o); /* defaults and -train_* */
PETSC_INTERN PetscErrorCode EnvCreate(const EnvOptions *o, Environment *env);
/* One episode; random draws its fault when -train_random is set. */
PETSC_INTERN PetscErrorCode EnvRunEpisode(Environment *env, Random *random, EnvActorFn actor, void *ctx,
                                          EnvResult *result);

/* ---- faults (envfault.c) ---- */
PETSC_INTERN PetscErrorCode EnvDrawFault(Random *random, PetscInt n,
                                         PetscReal value[]); /* n = number of drawn parameters */
PETSC_INTERN PetscInt EnvDrawCount(void);
PETSC_INTERN PetscErrorCode EnvDescribeDraw(char text[], size_t len);
/* drawn: NULL for the fault of the options. */
PETSC_INTERN PetscErrorCode EnvRunCreate(const EnvOptions *o, const PetscReal drawn[], EnvRun *run);
PETSC_INTERN PetscErrorCode EnvRunDestroy(EnvRun *run);
/* future: where the continuations of fine will leave what they meet; free its sample with PetscFree(). */
PETSC_INTERN PetscErrorCode EnvContinuationCreate(const EnvOptions *o, const PetscReal drawn[], EnvFuture *future,
                                                  EnvRun *fine);
/* Run the fault on from state w at time t with small constant steps until it rests, into the future of
   EnvContinuationCreate(). r: reaction, NULL at the start. */
PETSC_INTERN PetscErrorCode EnvContinue(const EnvOptions *o, EnvRun *fine, Vec w, Vec r, PetscReal t,
                                        EnvFuture *future);
