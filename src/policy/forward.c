/* Evaluates the network by pure functions on arrays. */
#include <slipstep/private/slippolicy.h>

static PetscReal Activate(SlipActivation activation, PetscReal y)
{
  switch (activation) {
  case SLIP_ACTIVATION_RELU:
    return y > 0 ? y : 0;
  case SLIP_ACTIVATION_TANH:
    return PetscTanhReal(y);
  case SLIP_ACTIVATION_HARDTANH2:
    return y < -2 ? -2 : (y > 2 ? 2 : y);
  default:
    return y;
  }
}

/*
  y [out] = f(W x + b), x [in], weight [in][out], without PETSc objects.

  With the transposed weight the inner loop runs over outputs: it vectorises without reordering any sum, so that results
  do not depend on the compiler's flags. Inputs that are 0, half of them after a relu, cost nothing.
*/
static void LayerForward(PetscInt in, PetscInt out, const PetscReal *weight, const PetscReal *bias,
                         SlipActivation activation, const PetscReal *restrict x, PetscReal *restrict y)
{
  for (PetscInt o = 0; o < out; o++) y[o] = bias[o];
  for (PetscInt i = 0; i < in; i++) {
    const PetscReal *restrict w = weight + i * out;
    const PetscReal xi = x[i];

    if (xi == 0) continue;
    for (PetscInt o = 0; o < out; o++) y[o] += w[o] * xi;
  }
  for (PetscInt o = 0; o < out; o++) y[o] = Activate(activation, y[o]);
}

/*@C
  SlipPolicyEvaluate - computes the action of a policy for one observation

  Not collective; no allocation, no communication

  Input Parameters:
+ p   - the policy
- obs - raw observations [n], dimensionless, in the order of `SlipPolicyGetObservations()`

  Output Parameters:
+ action  - low + (tanh(y) + 1)/2 (high - low), y the last layer's output; dimensionless
- outside - number of observations beyond the training range by more than a tenth of its width (`NULL` allowed); 0 if
            the policy has no range

  Level: intermediate

.seealso: SlipPolicyActionToStep(), SlipPolicySetRange()
@*/
PetscErrorCode SlipPolicyEvaluate(SlipPolicy p, const PetscReal obs[], PetscReal *action, PetscInt *outside)
{
  PetscReal *x, *y;

  PetscFunctionBegin;
  if (!p->work) PetscCall(SlipPolicyCheck_Private(p));
  x = p->work;
  y = p->work + p->width;
  for (PetscInt i = 0; i < p->n; i++) x[i] = obs[i] * p->scale[i] + p->offset[i];
  for (PetscInt l = 0; l < p->nlayers; l++) {
    const SlipLayer *layer = &p->layers[l];
    PetscReal *swap = x;

    LayerForward(layer->in, layer->out, layer->weight, layer->bias, layer->activation, x, y);
    x = y;
    y = swap;
  }
  *action = p->low + 0.5 * (PetscTanhReal(x[0]) + 1) * (p->high - p->low);
  if (outside) {
    *outside = 0;
    for (PetscInt i = 0; p->range && i < p->n; i++) {
      const PetscReal min = p->range[i], max = p->range[p->n + i], margin = 0.1 * (max - min);

      if (!(obs[i] >= min - margin && obs[i] <= max + margin)) (*outside)++;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipPolicyActionToStep - converts an action to a step size

  Not collective

  Input Parameters:
+ p      - the policy
. action - between low and high; values outside are clipped; dimensionless
. tstar  - time scale T* of the problem [s]
- tmax   - end of the simulated time [s]

  Output Parameter:
. h - dt_min + x (dt_max - dt_min), or dt_min (dt_max/dt_min)^x with logarithmic spacing [s];
      x = (action - low)/(high - low); relative to the last attempt's step if SlipPolicyIsRelative()

  Level: intermediate

  Errors: PETSC_ERR_FP for an action that is not finite, and those of SlipPolicyGetStepBounds()

.seealso: SlipPolicyEvaluate(), SlipPolicyGetStepBounds(), SlipPolicySetAction()
@*/
PetscErrorCode SlipPolicyActionToStep(SlipPolicy p, PetscReal action, PetscReal tstar, PetscReal tmax, PetscReal *h)
{
  PetscReal dt_min, dt_max, x;

  PetscFunctionBegin;
  PetscCall(SlipPolicyGetStepBounds(p, tstar, tmax, &dt_min, &dt_max));
  PetscCheck(!PetscIsInfOrNanReal(action), PetscObjectComm((PetscObject)p), PETSC_ERR_FP,
             "Policy %s: its action is %g; expected a finite number", SlipPolicySource_Private(p), (double)action);
  x = PetscClipInterval((action - p->low) / (p->high - p->low), (PetscReal)0, (PetscReal)1);
  *h = p->log_spacing ? dt_min * PetscPowReal(dt_max / dt_min, x) : dt_min + x * (dt_max - dt_min);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the observation that the attribute names. */
static PetscErrorCode FindFactor(SlipPolicy p)
{
  const char *name;
  PetscBool same = PETSC_FALSE;
  PetscInt k = 0;

  PetscFunctionBegin;
  PetscCall(SlipPolicyGetAttribute(p, SLIP_POLICY_STEP_FACTOR, &name));
  p->factor = -1;
  if (!name) PetscFunctionReturn(PETSC_SUCCESS);
  for (; k < p->n && !same; k += same ? 0 : 1) PetscCall(PetscStrcmp(p->names[k], name, &same));
  PetscCheck(same, PetscObjectComm((PetscObject)p), PETSC_ERR_ARG_WRONG,
             "Policy %s: attribute " SLIP_POLICY_STEP_FACTOR " is \"%s\"; expected the name of one of its observations",
             SlipPolicySource_Private(p), name);
  p->factor = k + 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipPolicyChoose - computes the step that the policy chooses

  Not collective

  Input Parameters:
+ p     - the policy
. obs   - values of its observations, in its order [n], dimensionless
. tstar - time scale T* of the problem [s]
- tmax  - end of the simulated time [s]

  Output Parameters:
+ h       - step of `SlipPolicyActionToStep()` for the action, times ten to the power of the observation that the
            attribute `SLIP_POLICY_STEP_FACTOR` names, if there is one [s]
- outside - number of observations beyond the training range by more than a tenth of its width, `NULL` allowed

  Level: intermediate

  Errors: PETSC_ERR_ARG_WRONG when the attribute names no observation, PETSC_ERR_FP for a step that is not finite, and
  those of SlipPolicyActionToStep()

.seealso: SlipPolicyEvaluate(), SlipPolicyActionToStep(), SlipPolicySetAttribute()
@*/
PetscErrorCode SlipPolicyChoose(SlipPolicy p, const PetscReal obs[], PetscReal tstar, PetscReal tmax, PetscReal *h,
                                PetscInt *outside)
{
  PetscReal action;

  PetscFunctionBegin;
  PetscCall(SlipPolicyEvaluate(p, obs, &action, outside));
  PetscCall(SlipPolicyActionToStep(p, action, tstar, tmax, h));
  if (p->factor == 0) PetscCall(FindFactor(p));
  if (p->factor < 0) PetscFunctionReturn(PETSC_SUCCESS);
  *h *= PetscPowReal(10, obs[p->factor - 1]);
  PetscCheck(*h > 0 && !PetscIsInfOrNanReal(*h), PetscObjectComm((PetscObject)p), PETSC_ERR_FP,
             "Policy %s: its step is %g s, with %s = %g; expected a positive number", SlipPolicySource_Private(p),
             (double)*h, p->names[p->factor - 1], (double)obs[p->factor - 1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}
