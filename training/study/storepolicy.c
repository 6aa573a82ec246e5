/* The actor as a policy file of the library. */
#include "trainer.h"
#include "common/files.h"
#include "problems/problems.h"
#include <slipcompat.h>

static PetscErrorCode AddLayer(SlipPolicy p, PetscInt in, PetscInt out, const Scalar w[], const Scalar b[],
                               SlipActivation activation)
{
  PetscReal *weight, *bias;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(in * out, &weight, out, &bias));
  for (PetscInt i = 0; i < in * out; ++i) weight[i] = (PetscReal)w[i];
  for (PetscInt i = 0; i < out; ++i) bias[i] = (PetscReal)b[i];
  PetscCall(SlipPolicyAddLayer(p, in, out, weight, bias, activation));
  PetscCall(PetscFree2(weight, bias));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetAttributes(Trainer *t, SlipPolicy p)
{
  PetscFunctionBegin;
  PetscCall(SlipPolicySetAttribute(p, "algorithm", t->o.agent.learner->name));
  PetscCall(SlipPolicySetAttribute(p, "problem", ProblemPolicy(t->o.env.problem)));
  PetscCall(SlipPolicySetAttribute(p, "reward", t->o.env.reward->name));
  PetscCall(PolicySetNumber(p, "alpha", "%g", (double)t->o.env.alpha));
  PetscCall(PolicySetNumber(p, "training_steps", "%.0f", (double)t->best_steps));
  PetscCall(PolicySetNumber(p, "seed", "%.0f", (double)t->o.seed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrainerStorePolicy(Trainer *t, const char file[])
{
  const EnvOptions *e = &t->o.env;
  const Scalar *a = t->best_actor;
  DenseShape s;
  PetscBool clamp;
  SlipPolicy p;

  PetscFunctionBegin;
  PetscCall(SlipPolicyCreate(PETSC_COMM_SELF, &p));
  PetscCall(SlipPolicySetObservations(p, e->nobs, (const char *const *)e->names, e->scale, e->offset));
  t->agent.o.learner->policy(t->agent.learner, &s, &clamp);
  for (PetscInt l = 0; l < s.layers; ++l) {
    const SlipActivation last = clamp ? SLIP_ACTIVATION_HARDTANH2 : SLIP_ACTIVATION_LINEAR;

    PetscCall(AddLayer(p, s.size[l], s.size[l + 1], a + s.weight[l], a + s.bias[l],
                       l + 1 < s.layers ? SLIP_ACTIVATION_RELU : last));
  }
  PetscCall(SlipPolicySetAction(p, -1, 1, e->dt_min, e->dt_min_unit, e->dt_max, e->dt_max_unit, e->log_spacing));
  PetscCall(SlipPolicySetRange(p, t->env.obs_min, t->env.obs_max));
  PetscCall(SetAttributes(t, p));
  PetscCall(SlipPolicyStore(p, file));
  PetscCall(SlipPolicyDestroy(&p));
  PetscFunctionReturn(PETSC_SUCCESS);
}
