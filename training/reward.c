/* The table of rewards. */
#include "reward.h"
#include <slipstep/private/slipcompat.h>

#define SOLVE_COST 0.25   /* an attempt */
#define FAILURE_COST 0.25 /* on top of that, an attempt that did not converge */
#define SLIP_WEIGHT 50    /* per relative error of the final slip: 1 % weighs as much as two attempts */
#define RATE_WEIGHT 5     /* per relative error of the peak slip rate: 10 % weigh as much as two attempts */
#define TIME_WEIGHT 10    /* per relative shift in time: 5 % weigh as much as two attempts */
#define WORST_STEP 15     /* largest penalty of one step's error, so that one disaster does not drown everything else */

/* R = S1 S2 exp(-alpha E); -S1 when the step fails. S1: how long the step is, S2: how cheap it was. */
static PetscReal Published(const RewardInput *in)
{
  const PetscReal length =
    PetscClipInterval((in->attempt->dt - in->dt_min) / (in->dt_max - in->dt_min), (PetscReal)0, (PetscReal)1);
  const PetscReal span = PetscMax((PetscReal)1e-8, in->cost_max - in->cost_min);

  if (!in->attempt->converged) return -length;
  return length * (1 - (in->cost - in->cost_min) / span) * PetscExpReal(-in->alpha * in->attempt->error);
}

/* A price for each attempt and one for the error that the step leaves in what matters at the end. */
static PetscReal Accuracy(const RewardInput *in)
{
  const PetscReal error =
    in->alpha * (SLIP_WEIGHT * in->slip_error + RATE_WEIGHT * in->rate_error + TIME_WEIGHT * in->time_error);

  if (!in->attempt->converged) return -SOLVE_COST - FAILURE_COST;
  return -SOLVE_COST - PetscMin(error, (PetscReal)WORST_STEP);
}

const Reward RewardTable[] = {
  {"published", "length of the step, times cheapness, times exp(-alpha E_r); minus the length when it fails",
   PETSC_FALSE, Published},
  {"accuracy",
   "-0.25 an attempt (-0.5 a failed one) and, with alpha 1, -0.5 for each 1 % by which the step changes the final "
   "slip, "
   "10 % by which it changes the peak rate and 5 % by which it shifts the event in time",
   PETSC_TRUE, Accuracy},
  {NULL, NULL, PETSC_FALSE, NULL}};

PetscErrorCode RewardFind(const char name[], const Reward **row)
{
  char names[256] = "";
  PetscBool same;

  PetscFunctionBegin;
  for (*row = RewardTable; (*row)->name; ++*row) {
    PetscCall(PetscStrcmp(name, (*row)->name, &same));
    if (same) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(PetscStrlcat(names, " ", sizeof(names)));
    PetscCall(PetscStrlcat(names, (*row)->name, sizeof(names)));
  }
  SETERRQ(PETSC_COMM_WORLD, PETSC_ERR_ARG_UNKNOWN_TYPE, "-train_reward %s is not known; expected one of:%s", name,
          names);
}
