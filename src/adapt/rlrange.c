/* TSADAPTRL's guard rail against situations that the policy was not trained for: counted, and said once. */
#include <slipstep/private/slipadapt.h>

/* How far outside a range, in widths of it */
static PetscReal Excess(PetscReal x, PetscReal min, PetscReal max)
{
  const PetscReal beyond = PetscMax(min - x, x - max);

  return beyond <= 0 ? 0 : max > min ? beyond / (max - min) : PETSC_MAX_REAL;
}

PetscErrorCode TSAdaptRLWarnOutside_Private(TSAdapt adapt, PetscInt outside)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  const PetscReal *min, *max;
  const char *file;
  PetscInt worst = 0;

  PetscFunctionBegin;
  if (!outside || rl->outside++) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipPolicyGetFile(rl->policy, &file));
  PetscCall(SlipPolicyGetRange(rl->policy, &min, &max));
  for (PetscInt i = 1; i < rl->n; i++)
    if (Excess(rl->obs[i], min[i], max[i]) > Excess(rl->obs[worst], min[worst], max[worst])) worst = i;
  PetscCall(PetscPrintf(PetscObjectComm((PetscObject)adapt),
                        "Warning: at time %g s %" PetscInt_FMT " of %" PetscInt_FMT
                        " observations are outside the training range of policy %s, most of all %s = %g, in training "
                        "%g to %g (said once; the summary and -ts_view count)\n",
                        (double)rl->observer.time, outside, rl->n, file, rl->seen[worst].name, (double)rl->obs[worst],
                        (double)min[worst], (double)max[worst]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSAdaptRLGetCounts - what the learned controller did, and how often its guard rails acted

  Not collective

  Input Parameter:
. adapt - the controller

  Output Parameters (each may be `NULL`; 0 when adapt is not `TSADAPTRL`):
+ decisions - steps that the policy chose, over all runs
. outside   - of these, with an observation beyond its training range by more than a tenth of the range's width
. failures  - attempts that did not converge
- halvings  - steps halved after too many failures in a row

  Level: intermediate

.seealso: TSADAPTRL, SlipPolicySetRange()
@*/
PetscErrorCode TSAdaptRLGetCounts(TSAdapt adapt, PetscInt *decisions, PetscInt *outside, PetscInt *failures,
                                  PetscInt *halvings)
{
  const TSAdapt_RL *rl = NULL;
  PetscBool learned;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(adapt, TSADAPT_CLASSID, 1);
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTRL, &learned));
  if (learned) rl = (const TSAdapt_RL *)adapt->data;
  if (decisions) *decisions = rl ? rl->decisions : 0;
  if (outside) *outside = rl ? rl->outside : 0;
  if (failures) *failures = rl ? rl->failures : 0;
  if (halvings) *halvings = rl ? rl->halvings : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
