/* What the learners TQC and TD3 share, and the table by which the agent uses either: networks that act, one gradient
   step, the arrays that make up their state. Compiled in single precision, and in double for the golden test. */
#pragma once
#include "dense.h"

#define LEARNER_MAX_HIDDEN 6
#define LEARNER_MAX_ARRAYS 12
#define LEARNER_COUNTERS 3

typedef struct {
  PetscInt obs;                                       /* O; the action is one number */
  PetscInt actor_layers, actor[LEARNER_MAX_HIDDEN];   /* hidden layers of the actor and their widths */
  PetscInt critic_layers, critic[LEARNER_MAX_HIDDEN]; /* of each critic */
  PetscInt critics;                                   /* C */
  PetscInt quantiles;                                 /* per critic (TQC) */
  PetscInt drop;                                      /* largest target quantiles left out, per critic (TQC) */
  PetscInt batch;                                     /* B, samples in a gradient step */
  PetscReal lr, gamma, tau;            /* learning rate of all optimisers, discount, Polyak coefficient */
  PetscReal noise;                     /* TD3: standard deviation of exploration, in [-1, 1] */
  PetscReal smoothing, smoothing_clip; /* TD3: noise of the target's action */
  PetscInt delay;                      /* TD3: gradient steps of the critics to one of the actor */
} LearnerOptions;

/* Feature-major arrays with leading dimension LearnerOptions.batch. action in [-1, 1]; done is 1 where bootstrapping
   stops. */
typedef struct {
  Scalar *obs, *next_obs; /* [O][B] */
  Scalar *action;         /* [B] */
  Scalar *reward, *done;  /* [B] */
} Batch;

/* Of one gradient step; NaN where the learner has no such thing. */
typedef struct {
  double critic, actor, entropy, alpha, mean_q;
} Losses;

/* An array of a learner's state, for checkpoints. */
typedef struct {
  const char *path;
  Scalar *data;
  size_t n;
} LearnerArray;

/* The first array is all that the policy needs; n of them */
typedef struct {
  PetscInt n;
  LearnerArray array[LEARNER_MAX_ARRAYS];
  PetscInt64 *counter[LEARNER_COUNTERS]; /* of the optimisers' steps */
} LearnerState;

/* One learner. All functions take what create filled. */
typedef struct {
  const char *name;
  size_t size;      /* of what create fills */
  PetscInt critics; /* defaults */
  PetscReal lr;
  PetscBool clamp; /* the last layer of the policy is cut at -2 and 2 */
  PetscErrorCode (*create)(const LearnerOptions *o, Random *r, void *learner);
  PetscErrorCode (*destroy)(void *learner);
  /* Action in [-1, 1] at obs [O]: exploring, a uniformly random one before the learner has learnt (warm-up), or the
     policy's own. */
  Scalar (*act)(void *learner, const Scalar obs[], PetscBool explore, PetscBool warm_up, Random *r);
  void (*update)(void *learner, const Batch *batch, Random *r, Losses *losses);
  void (*state)(void *learner, LearnerState *s);
  /* Layers of the deterministic policy tanh(.) within such parameters: shape, offsets as in DenseShape */
  void (*policy)(void *learner, DenseShape *layers);
} Learner;

PETSC_INTERN const Learner LearnerTQC, LearnerTD3; /* rows of Learners[] in studyoptions.c */

/* Widths between first and last: DenseShape of a network with the given hidden layers. out 0: hidden layers only. */
PETSC_INTERN void LearnerShape(PetscInt nets, PetscInt in, PetscInt hidden, const PetscInt width[], PetscInt out,
                               DenseShape *s);
PETSC_INTERN PetscErrorCode LearnerCheckOptions(const LearnerOptions *o);
