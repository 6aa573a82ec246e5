/* TSADAPTRL: the numbers in a policy's file besides its network: tolerance, first step, attempts without growth after a
   failed solve, and the error above which attempts are rejected. */
#include <slipstep/private/slipadapt.h>

/* Attempts without growth after PETSc has shortened a step because a solve failed. A relative policy does not observe
   this, and would otherwise return each time to the step that failed. */
#define HOLD 4

/* Above this error estimate a relative policy rejects an attempt. */
#define CEILING 1

/* factor a^power for the wanted accuracy a; has: the policy has such a number */
static PetscErrorCode OfDial(const TSAdapt_RL *rl, const char factor[], const char power[], PetscReal *number,
                             PetscBool *has)
{
  PetscReal exponent;
  PetscBool powered;

  PetscFunctionBegin;
  PetscCall(SlipPolicyGetNumber(rl->policy, factor, number, has));
  PetscCall(SlipPolicyGetNumber(rl->policy, power, &exponent, &powered));
  if (*has && powered) *number *= PetscPowReal(rl->observer.run.accuracy, exponent);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Given(TS ts, const char option[], PetscBool *given)
{
  return PetscOptionsHasName(((PetscObject)ts)->options, ((PetscObject)ts)->prefix, option, given);
}

/* -ts_rtol overrides the tolerance with which a policy was trained. */
PetscErrorCode TSAdaptRLSetTolerance_Private(TSAdapt adapt, TS ts)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  PetscReal rtol, trained;
  PetscBool follows, given;

  PetscFunctionBegin;
  PetscCall(OfDial(rl, SLIP_POLICY_RTOL_FACTOR, SLIP_POLICY_RTOL_POWER, &trained, &follows));
  if (!follows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Given(ts, "-ts_rtol", &given));
  if (!given) {
    PetscCall(TSSetTolerances(ts, PETSC_DEFAULT, NULL, trained, NULL));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (rl->told_rtol) PetscFunctionReturn(PETSC_SUCCESS);
  rl->told_rtol = PETSC_TRUE;
  PetscCall(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
  PetscCall(PetscPrintf(
    PetscObjectComm((PetscObject)adapt),
    "-ts_rtol %g, of the command line or a file of options, in place of the %.3g with which the policy keeps "
    "this dial: %s\n",
    (double)rtol, (double)trained,
    rtol < trained ? "errors and steps are smaller than it asks for"
                   : "errors may exceed it, leave the option out to keep the accuracy"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* -ts_dt overrides the first step of a policy. */
PetscErrorCode TSAdaptRLFirstStep_Private(TSAdapt adapt, TS ts, PetscReal *h)
{
  const TSAdapt_RL *rl = (const TSAdapt_RL *)adapt->data;
  PetscReal first;
  PetscBool has, given;

  PetscFunctionBegin;
  PetscCall(OfDial(rl, SLIP_POLICY_FIRST_STEP_FACTOR, SLIP_POLICY_FIRST_STEP_POWER, &first, &has));
  PetscCall(Given(ts, "-ts_dt", &given));
  if (has && !given && rl->observer.run.tstar > 0) *h = first * rl->observer.run.tstar;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* -ts_adapt_rl_error_ceiling overrides a policy's own ceiling. */
PetscErrorCode TSAdaptRLFindGuards_Private(TSAdapt adapt)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  PetscReal number;
  PetscBool has;

  PetscFunctionBegin;
  rl->ceiling = rl->error_ceiling;
  if (rl->actor) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipPolicyGetNumber(rl->policy, SLIP_POLICY_HOLD, &number, &has));
  rl->hold_after_failure = has ? (PetscInt)number : HOLD;
  if (rl->error_ceiling > 0 || !rl->relative) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipPolicyGetNumber(rl->policy, SLIP_POLICY_CEILING, &number, &has));
  rl->ceiling = has ? number : CEILING;
  PetscFunctionReturn(PETSC_SUCCESS);
}
