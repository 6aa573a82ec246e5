/* Getters of a SlipPolicy: observations, step bounds, range, attributes, file */
#include <slipstep/private/slippolicy.h>

/*@C
  SlipPolicyGetAttribute - gets an attribute that describes the training

  Not collective

  Input Parameters:
+ p    - the policy
- name - of the attribute, such as "problem"

  Output Parameter:
. value - its text, borrowed; `NULL` if there is none

  Level: intermediate

.seealso: SlipPolicySetAttribute(), SlipPolicyGetNumber()
@*/
PetscErrorCode SlipPolicyGetAttribute(SlipPolicy p, const char name[], const char **value)
{
  PetscBool same;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  *value = NULL;
  for (PetscInt i = 0; i < p->nattributes && !*value; i++) {
    PetscCall(PetscStrcmp(p->attributes[2 * i], name, &same));
    if (same) *value = p->attributes[2 * i + 1];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets an attribute that is a number. name: of the attribute, such as `SLIP_POLICY_MOVING_DT_MAX`; value: the number,
   in the unit in which it was set; 0 if there is none. */
PetscErrorCode SlipPolicyGetNumber(SlipPolicy p, const char name[], PetscReal *value, PetscBool *has)
{
  const char *text;

  PetscFunctionBegin;
  PetscCall(SlipPolicyGetAttribute(p, name, &text));
  *value = text ? SlipPolicyParseNumber_Private(text) : NAN;
  *has = PetscIsNanReal(*value) ? PETSC_FALSE : PETSC_TRUE;
  if (!*has) *value = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipPolicyGetObservations - gets the names of the policy's observations

  Not collective

  Input Parameter:
. p - the policy

  Output Parameters:
+ n     - their number
- names - their names [n], borrowed

  Level: intermediate

.seealso: SlipPolicySetObservations()
@*/
PetscErrorCode SlipPolicyGetObservations(SlipPolicy p, PetscInt *n, const char *const *names[])
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  if (n) *n = p->n;
  if (names) *names = (const char *const *)p->names;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipPolicyGetStepBounds - gets the smallest and the largest step that the policy can choose

  Not collective

  Input Parameters:
+ p     - the policy
. tstar - time scale T* of the problem [s]
- tmax  - end of the simulated time [s]

  Output Parameters:
+ dt_min - [s]; relative to the last attempt's step, dimensionless, if SlipPolicyIsRelative()
- dt_max - [s], likewise

  Note:
  Raises PETSC_ERR_ARG_OUTOFRANGE when the bounds, given in different units, do not fit this problem (dt_min >= dt_max).

  Level: intermediate

  Errors: PETSC_ERR_ARG_WRONGSTATE without an action, or without the maximum time that the steps are fractions of

.seealso: SlipPolicySetAction()
@*/
PetscErrorCode SlipPolicyGetStepBounds(SlipPolicy p, PetscReal tstar, PetscReal tmax, PetscReal *dt_min,
                                       PetscReal *dt_max)
{
  const PetscReal unit[4] = {1, tstar, tmax, 1};

  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  PetscCheck(p->has_action, PetscObjectComm((PetscObject)p), PETSC_ERR_ARG_WRONGSTATE,
             "Policy %s has no action (/action)", SlipPolicySource_Private(p));
  PetscCheck((p->dt_unit[0] != SLIP_STEP_UNIT_TMAX && p->dt_unit[1] != SLIP_STEP_UNIT_TMAX) || tmax < PETSC_MAX_REAL,
             PetscObjectComm((PetscObject)p), PETSC_ERR_ARG_WRONGSTATE,
             "Policy %s: its steps are parts of t_max, but there is none; expected -ts_max_time",
             SlipPolicySource_Private(p));
  *dt_min = p->dt[0] * unit[p->dt_unit[0]];
  *dt_max = p->dt[1] * unit[p->dt_unit[1]];
  PetscCheck(
    *dt_min < *dt_max && !PetscIsInfOrNanReal(*dt_max), PetscObjectComm((PetscObject)p), PETSC_ERR_ARG_OUTOFRANGE,
    "Policy %s: with T* = %g s and a maximum time of %g s its steps are in [%g, %g] s; expected dt_min < dt_max "
    "(attributes of /action)",
    SlipPolicySource_Private(p), (double)tstar, (double)tmax, (double)*dt_min, (double)*dt_max);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets whether the steps of a policy are multiples of the last attempt's (unit "h" of its action). relative:
   `PETSC_TRUE`: SlipPolicyActionToStep() computes the ratio of the next step to the last attempt's. */
PetscErrorCode SlipPolicyIsRelative(SlipPolicy p, PetscBool *relative)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  *relative = p->has_action && p->dt_unit[0] == SLIP_STEP_UNIT_H ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the file that a policy was loaded from or stored to. file: borrowed; "(in memory)" if there is none. */
PetscErrorCode SlipPolicyGetFile(SlipPolicy p, const char *file[])
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  *file = SlipPolicySource_Private(p);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the smallest and largest values of the observations in training. min: one per observation, dimensionless,
   borrowed; NULL if the policy has no range; max: likewise, dimensionless. */
PetscErrorCode SlipPolicyGetRange(SlipPolicy p, const PetscReal *min[], const PetscReal *max[])
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  *min = p->range;
  *max = p->range ? p->range + p->n : NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}
