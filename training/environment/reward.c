/* The table of rewards. */
#include "reward.h"
#include "common/options.h"
#include <slipcompat.h>

#define SOLVE_COST 0.25   /* an attempt */
#define FAILURE_COST 0.25 /* on top of that, an attempt that did not converge */
#define EFFECT_PRICE 1    /* four attempts for an effect of 1 */
#define BALANCE 0.5
#define WORST_STEP 15 /* largest penalty of one step's error, so that one disaster does not drown everything else */

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
static PetscReal Priced(const RewardInput *in, PetscReal weight)
{
  if (!in->attempt->converged) return -SOLVE_COST - FAILURE_COST;
  return -SOLVE_COST - PetscMin(weight * EFFECT_PRICE * in->effect, (PetscReal)WORST_STEP);
}

static PetscReal Accuracy(const RewardInput *in)
{
  return Priced(in, in->alpha);
}

/* With N steps of second order a run costs N + weight/N^2, least at an N that grows as the cube root of the weight. The
   study's alphas, 0.5 to 128, would ask for six times as many steps with the last as with the first; their cube roots
   for less than twice as many. */
static PetscReal Balanced(const RewardInput *in)
{
  return Priced(in, (PetscReal)BALANCE * PetscPowReal(in->alpha, 1. / 3));
}

static const Reward RewardTable[] = {
  {"published", "length of the step, times cheapness, times exp(-alpha E_r); minus the length when it fails",
   PETSC_FALSE, Published},
  {"accuracy",
   "-0.25 an attempt (-0.5 a failed one) and alpha times the error that a step leaves; for the fault and alpha 1, -0.5 "
   "for each 1 % by which the step changes the final slip, 10 % by which it changes the peak rate and 5 % by which it "
   "shifts the event in time; for small systems -0.5 for each 1 % by which it leaves the exact solution",
   PETSC_TRUE, Accuracy},
  {"balanced", "as accuracy, with 0.5 times the cube root of alpha as the weight", PETSC_TRUE, Balanced},
  {NULL, NULL, PETSC_FALSE, NULL}};

PetscErrorCode RewardFind(const char name[], const Reward **row)
{
  const char *names[PETSC_STATIC_ARRAY_LENGTH(RewardTable)];
  PetscInt k;

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(RewardTable); ++i) names[i] = RewardTable[i].name;
  PetscCall(OptionFind("-train_reward", name, names, &k));
  *row = &RewardTable[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}
