/* Policies with an accuracy dial: their steps, and where CMA-ES begins. That is a network that a person could have
   written: steps of a constant length that follows the dial, and one to the end when all cells rest; for other problems
   than the fault, three quarters of the way up the bounds at the coarsest dial, following the order of the method, and
   longer as the energy falls. */
#include "episodes.h"
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

PetscErrorCode DialPolicy(const CMAOptions *o, const double w[], SlipPolicy policy)
{
  char text[32];

  PetscFunctionBegin;
  (void)w;
  PetscCall(SlipPolicySetAction(policy, -1, 1, o->dt_min, "T*", o->dt_max, o->dt_max_unit, PETSC_TRUE));
  if (o->moving > 0) {
    PetscCall(PetscSNPrintf(text, sizeof(text), "%g", (double)o->moving));
    PetscCall(SlipPolicySetAttribute(policy, SLIP_POLICY_MOVING_DT_MAX, text));
  }
  if (CMAFind(o, STEP_FACTOR) >= 0) PetscCall(SlipPolicySetAttribute(policy, SLIP_POLICY_STEP_FACTOR, STEP_FACTOR));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Add factor times observation i, unscaled, to a unit of the first layer. */
static void AddTerm(const CMAOptions *o, PetscInt i, double factor, double row[], double *bias)
{
  if (i < 0) return;
  row[i] += factor / o->scale[i];
  *bias -= factor * o->offset[i] / o->scale[i];
}

void DialStart(const CMAOptions *o, double weights[])
{
  const double low = log10(o->dt_min), high = log10(o->dt_max), middle = 0.5 * (low + high);
  const double half = strcmp(o->dt_max_unit, "T*") ? HALF_RANGE : 0.5 * (high - low);
  const PetscBool small = o->problem->cma->kinds ? PETSC_FALSE : PETSC_TRUE;
  const double power = small ? SMALL_POWER : START_POWER;
  const PetscInt hidden = o->hidden, sliding = CMAFind(o, "sliding_fraction"), converged = CMAFind(o, "converged");
  double *w = weights, *bias = w + o->nobs * hidden;

  /* unit 0: log10 h less its middle, times the slope */
  bias[0] = NEAR_LINEAR * ((small ? SMALL_START * half : log10(START_STEP) - middle) - power * log10(o->high));
  AddTerm(o, CMAFind(o, "log_accuracy"), NEAR_LINEAR * power, w, &bias[0]);
  if (small) AddTerm(o, CMAFind(o, "log_energy"), NEAR_LINEAR * SMALL_ENERGY, w, &bias[0]);
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

PetscErrorCode DialSay(const CMAScore *score, char text[], size_t len)
{
  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(text, len, "cost %7.4f  solves %5.1f  within dial %5.1f %%  error/dial %6.3f",
                          (double)score->cost, (double)score->solves, 100 * (double)score->within,
                          (double)score->error));
  PetscFunctionReturn(PETSC_SUCCESS);
}
