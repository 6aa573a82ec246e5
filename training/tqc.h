/* Truncated quantile critics (Kuznetsov et al. 2020) with generalised state-dependent exploration (Raffin et al.
   2022), as Stable-Baselines3 2.7 and sb3-contrib 2.7 compute it. */
#pragma once
#include "dense.h"

typedef struct {
  PetscInt obs, act;     /* O, A */
  PetscInt hidden;       /* width of the hidden layers of all networks */
  PetscInt critics;      /* C */
  PetscInt quantiles;    /* per critic */
  PetscInt drop;         /* largest target quantiles left out, per critic */
  PetscInt batch;        /* samples in a gradient step */
  double lr, gamma, tau; /* learning rate of all optimisers, discount, Polyak coefficient */
} TQCOptions;

/* gSDE quantities of one batch, all [A][B] */
typedef struct {
  Scalar *mean_raw, *mean; /* head before and after the clamp to [-2, 2] */
  Scalar *noise;           /* n_k = sum_j h_j E_jk */
  Scalar *var;             /* S_k = sum_j h_j^2 sigma_jk^2 + 1e-6 */
  Scalar *action;          /* a = tanh(m + n) */
  Scalar *logp;            /* [B], summed over k */
} GSDE;

typedef struct {
  TQCOptions o;
  DenseShape latent, critic;
  size_t head_weight, head_bias, log_std; /* offsets in actor: mean head W[A][hidden], b[A], log_std [hidden][A] */
  size_t nactor, ncritic;                 /* parameters: actor with log_std; all critics */
  Scalar *actor, *critics, *target;       /* parameters */
  Scalar *actor_grad, *critic_grad;       /* gradients of the last step */
  Scalar log_alpha;                       /* lambda, alpha = exp(lambda) */
  Adam actor_adam, critic_adam, alpha_adam;
  /* work space */
  DenseWork actor_work, critic_work;
  GSDE now, next;
  Scalar *sigma, *explore;     /* [hidden][A] */
  Scalar *input;               /* critic input [O+A][B] */
  Scalar *z;                   /* target quantiles [C*quantiles][B], then sorted */
  Scalar *dqda, *dS, *dg, *dm; /* [A][B] */
} TQC;

/* Feature-major arrays with leading dimension TQCOptions.batch. action in [-1, 1]; done is 1 where bootstrapping
   stops. */
typedef struct {
  Scalar *obs, *next_obs; /* [O][B] */
  Scalar *action;         /* [A][B] */
  Scalar *reward, *done;  /* [B] */
} TQCBatch;

typedef struct {
  double critic, actor, entropy, alpha, mean_q;
} TQCLosses;

PETSC_INTERN PetscErrorCode TQCCreate(const TQCOptions *o, Random *r, TQC *t);
PETSC_INTERN PetscErrorCode TQCDestroy(TQC *t);
/* Actions [A][B] at obs [O][B], B <= o.batch. eps [hidden][A] standard normal, or NULL: the deterministic tanh(mean).
   */
PETSC_INTERN void TQCSample(TQC *t, PetscInt B, const Scalar obs[], const Scalar eps[], Scalar action[]);
/* One gradient step. eps [hidden][A]: one standard normal exploration matrix for the whole batch. */
PETSC_INTERN void TQCUpdate(TQC *t, const TQCBatch *batch, const Scalar eps[], TQCLosses *losses);

/* ---- parts, used by the above ---- */
/* gSDE at latent features h [H][B]: fills every field of s. head: W[A][H]; explore, sigma [H][A] (NULL: no noise). */
PETSC_INTERN void GSDESample(PetscInt H, PetscInt A, PetscInt B, const Scalar h[], const Scalar head[],
                             const Scalar bias[], const Scalar sigma[], const Scalar explore[], GSDE *s);
/* z [n][B]: sort every sample's values ascending and turn the smallest keep of them into y = r + (1-d) gamma (z -
   alpha logp). */
PETSC_INTERN void QuantileTargets(PetscInt n, PetscInt keep, PetscInt B, const Scalar reward[], const Scalar done[],
                                  Scalar gamma, Scalar alpha, const Scalar logp[], Scalar z[]);
/* Quantile Huber loss, the plain mean over everything: theta [C*Q][B], y [N][B]; grad = dL/dtheta. */
PETSC_INTERN double QuantileHuber(PetscInt C, PetscInt Q, PetscInt N, PetscInt B, const Scalar theta[],
                                  const Scalar y[], Scalar grad[]);
