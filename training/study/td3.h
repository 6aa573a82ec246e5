/* Twin delayed deep deterministic policy gradient (Fujimoto et al. 2018), as Stable-Baselines3 2.7 computes it. */
#pragma once
#include "learner.h"

typedef struct {
  LearnerOptions o;
  DenseShape actor_shape, critic_shape, first_critic; /* first_critic: the shape of one */
  size_t nactor, ncritic;                             /* parameters: actor; all critics */
  Scalar *actor, *actor_target, *critics, *critic_target;
  Scalar *actor_grad, *critic_grad; /* gradients of the last steps */
  Adam actor_adam, critic_adam;
  PetscInt64 updates;
  /* work space */
  DenseWork actor_work, critic_work;
  Scalar *input;         /* critic input [O+1][B] */
  Scalar *y;             /* targets [B] */
  Scalar *action, *dqda; /* [B] */
  Scalar *normals;       /* [B] */
} TD3;

PETSC_INTERN PetscErrorCode TD3Create(const LearnerOptions *o, Random *r, void *learner); /* TD3 * */
PETSC_INTERN PetscErrorCode TD3Destroy(void *learner);
/* One gradient step. noise [B]: of the target's action, not yet clipped. losses->actor and mean_q keep their values
   in the steps that leave the actor alone. */
PETSC_INTERN void TD3Update(TD3 *t, const Batch *batch, const Scalar noise[], Losses *losses);
