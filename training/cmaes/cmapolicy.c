/* The network of -train_algorithm cmaes: its weights as a policy, and where CMA-ES begins. That is a network that a
   person could have written: steps of a constant length that follows the dial, and one to the end when all cells rest;
   for other problems than the fault, three quarters of the way up the bounds at the coarsest dial, following the order of
   the method, and longer as the energy falls. */
#include "cmatrain.h"
#include <slipcompat.h>
#include <math.h>

#define START_STEP 0.8 /* at the coarsest dial [T*] */
#define SMALL_START                                                                                                    \
  0.5 /* of other problems, from -1 at the logarithm of the lower bound to 1 at that of the upper one */
#define SMALL_POWER 0.5     /* in place of START_POWER: the error goes with the square of the step */
#define SMALL_ENERGY (-0.2) /* step over energy's power: what the best sequences of steps of the circuit do */
#define HALF_RANGE                                                                                                     \
  1 /* decades from the middle of the bounds to either, where their units differ and T* is not known yet */
#define START_POWER 0.25              /* step over dial's power */
#define NEAR_LINEAR 0.4               /* slope of a tanh unit that is to stay close to linear */
#define STEP_FACTOR "log_growth_time" /* where a policy observes it, its steps are in units of that time */
#define SLIDING_SHARE 0.1             /* a smaller share of sliding cells than this counts as rest */

PetscInt CMACountWeights(const CMAOptions *o)
{
  return o->nobs * o->hidden + o->hidden + (o->layers - 1) * (o->hidden + 1) * o->hidden + o->hidden + 1;
}

/* Position of an observation; -1: not observed. */
static PetscInt Find(const CMAOptions *o, const char name[])
{
  for (PetscInt i = 0; i < o->nobs; ++i)
    if (!strcmp(o->names[i], name)) return i;
  return -1;
}

PetscErrorCode CMAPolicy(const CMAOptions *o, const double weights[], const PetscReal shift[2], SlipPolicy *policy)
{
  PetscInt in = o->nobs;
  PetscReal scale[CMA_MAX_OBS], offset[CMA_MAX_OBS];
  const double *w = weights;

  PetscFunctionBegin;
  PetscCall(SlipPolicyCreate(PETSC_COMM_SELF, policy));
  for (PetscInt i = 0; i < o->nobs; ++i) {
    scale[i] = o->scale[i];
    offset[i] = o->offset[i];
    if (strcmp(o->names[i], "log_accuracy")) continue;
    /* x + shift[0] + shift[1] (x - middle) in place of x */
    scale[i] *= 1 + shift[1];
    offset[i] += o->scale[i] * (shift[0] - shift[1] * 0.5 * PetscLog10Real(o->low * o->high));
  }
  PetscCall(SlipPolicySetObservations(*policy, o->nobs, (const char *const *)o->names, scale, offset));
  for (PetscInt l = 0; l < o->layers; ++l) {
    PetscCall(SlipPolicyAddLayer(*policy, in, o->hidden, w, w + in * o->hidden, SLIP_ACTIVATION_TANH));
    w += (in + 1) * o->hidden;
    in = o->hidden;
  }
  PetscCall(SlipPolicyAddLayer(*policy, in, 1, w, w + in, SLIP_ACTIVATION_LINEAR));
  PetscCall(SlipPolicySetAction(*policy, -1, 1, o->dt_min, "T*", o->dt_max, o->dt_max_unit, PETSC_TRUE));
  if (o->moving > 0) {
    char text[32];

    PetscCall(PetscSNPrintf(text, sizeof(text), "%g", (double)o->moving));
    PetscCall(SlipPolicySetAttribute(*policy, SLIP_POLICY_MOVING_DT_MAX, text));
  }
  if (Find(o, STEP_FACTOR) >= 0) PetscCall(SlipPolicySetAttribute(*policy, SLIP_POLICY_STEP_FACTOR, STEP_FACTOR));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Add factor times observation i, unscaled, to a unit of the first layer. */
static void AddTerm(const CMAOptions *o, PetscInt i, double factor, double row[], double *bias)
{
  if (i < 0) return;
  row[i] += factor / o->scale[i];
  *bias -= factor * o->offset[i] / o->scale[i];
}

/* weights [CMACountWeights()] */
void CMAStart(const CMAOptions *o, double weights[])
{
  const double low = log10(o->dt_min), high = log10(o->dt_max), middle = 0.5 * (low + high);
  const double half = strcmp(o->dt_max_unit, "T*") ? HALF_RANGE : 0.5 * (high - low);
  const double power = o->small ? SMALL_POWER : START_POWER;
  const PetscInt hidden = o->hidden, sliding = Find(o, "sliding_fraction"), converged = Find(o, "converged");
  double *w = weights, *bias = w + o->nobs * hidden;

  for (PetscInt i = 0; i < CMACountWeights(o); ++i) weights[i] = 0;
  /* unit 0: log10 h less its middle, times the slope */
  bias[0] = NEAR_LINEAR * ((o->small ? SMALL_START * half : log10(START_STEP) - middle) - power * log10(o->high));
  AddTerm(o, Find(o, "log_accuracy"), NEAR_LINEAR * power, w, &bias[0]);
  if (o->small) AddTerm(o, Find(o, "log_energy"), NEAR_LINEAR * SMALL_ENERGY, w, &bias[0]);
  /* unit 1: positive when everything rests after a first step */
  if (hidden > 1 && sliding >= 0 && converged >= 0) {
    bias[1] = 2 - 4;
    AddTerm(o, sliding, -2 / SLIDING_SHARE, w + o->nobs, &bias[1]);
    AddTerm(o, converged, 4, w + o->nobs, &bias[1]);
  }
  w = bias + hidden;
  for (PetscInt l = 1; l < o->layers; ++l, w += (hidden + 1) * hidden) {
    w[0] = 1;
    if (hidden > 1) w[hidden + 1] = 2;
  }
  w[0] = 1 / (NEAR_LINEAR * half);
  if (hidden > 1 && sliding >= 0 && converged >= 0) w[1] = w[hidden] = 1;
}
