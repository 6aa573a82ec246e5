/* Truncated quantile critics (Kuznetsov et al. 2020) with generalised state-dependent exploration (Raffin et al.
   2022), as Stable-Baselines3 2.7 and sb3-contrib 2.7 compute it. */
#pragma once
#include "learner.h"

/* The stochastic policy on one batch, all [B] */
typedef struct {
  Scalar *mean_raw, *mean; /* head before and after the clamp to [-2, 2] */
  Scalar *noise;           /* n = sum_j h_j E_j */
  Scalar *var;             /* S = sum_j h_j^2 sigma_j^2 + 1e-6 */
  Scalar *action;          /* a = tanh(m + n) */
  Scalar *logp;            /* log density of the action */
} Sample;

typedef struct {
  LearnerOptions o;
  DenseShape latent, critic;
  PetscInt hidden;                        /* H, width of the actor's last hidden layer */
  size_t head_weight, head_bias, log_std; /* offsets in actor: mean head W[H], b; log_std [H] */
  size_t nactor, ncritic;                 /* parameters: actor with log_std; all critics */
  Scalar *actor, *critics, *target;       /* parameters */
  Scalar *actor_grad, *critic_grad;       /* gradients of the last step */
  Scalar log_alpha;                       /* lambda, alpha = exp(lambda) */
  Adam actor_adam, critic_adam, alpha_adam;
  /* work space */
  DenseWork actor_work, critic_work;
  Sample now, next;
  Scalar *sigma, *explore;     /* [H] */
  Scalar *normals;             /* [H] */
  Scalar *input;               /* critic input [O+1][B] */
  Scalar *z;                   /* target quantiles [C*quantiles][B], then sorted */
  Scalar *dqda, *dS, *dg, *dm; /* [B] */
} TQC;

PETSC_INTERN PetscErrorCode TQCCreate(const LearnerOptions *o, Random *r, void *learner); /* TQC * */
PETSC_INTERN PetscErrorCode TQCDestroy(void *learner);
/* eps: standard normals [H], one exploration vector for the whole batch */
PETSC_INTERN void TQCUpdate(TQC *t, const Batch *batch, const Scalar eps[], Losses *losses);

/* ---- quantile.c ---- */
/* z [n][B]: sort every sample's values ascending and turn the smallest keep of them into y = r + (1-d) gamma (z -
   alpha logp). */
PETSC_INTERN void QuantileTargets(PetscInt n, PetscInt keep, PetscInt B, const Scalar reward[], const Scalar done[],
                                  Scalar gamma, Scalar alpha, const Scalar logp[], Scalar z[]);
/* Quantile Huber loss, the plain mean over everything: theta [C*Q][B], y [N][B]; grad = dL/dtheta. */
PETSC_INTERN double QuantileHuber(PetscInt C, PetscInt Q, PetscInt N, PetscInt B, const Scalar theta[],
                                  const Scalar y[], Scalar grad[]);
