/* TSADAPTRL: what rests needs no steps. */
#include <slipstep/private/slipadapt.h>

/*
  TSAdaptRLMind_Private - mind whether the problem rests

  Collective. For policies with the attribute moving_dt_max [T*] only. A state at rest stays what it is until something
  slips, which the problem knows ("SlipRestTime_C"): the step goes there, however long. While anything moves, steps are
  no longer than the attribute: a policy trained on a few cells cannot know how little of a fine mesh may still be
  sliding.
*/
PetscErrorCode TSAdaptRLMind_Private(TSAdapt adapt, TS ts, PetscReal *h)
{
  const TSAdapt_RL *rl = (const TSAdapt_RL *)adapt->data;
  PetscErrorCode (*ask)(TS, PetscReal *);
  PetscReal limit, rest = 0;
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipPolicyGetNumber(rl->policy, SLIP_POLICY_MOVING_DT_MAX, &limit, &has));
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscObjectQueryFunction((PetscObject)ts, "SlipRestTime_C", &ask));
  if (ask) PetscCall((*ask)(ts, &rest));
  if (rest > 0)
    *h = PetscMax(PetscMin(rest, rl->observer.max_time - rl->observer.time), limit * rl->observer.tstar);
  else
    *h = PetscMin(*h, limit * rl->observer.tstar);
  PetscFunctionReturn(PETSC_SUCCESS);
}
