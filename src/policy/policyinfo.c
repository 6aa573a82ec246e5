/* What one may ask of a SlipPolicy: observations, step bounds, attributes, digest; and its view. */
#include <slipcore.h>
#include <slipstep/private/slippolicy.h>
#include <stdlib.h>

/* Attributes that a file holds as numbers, when their text is one; all others are strings. */
static const char *const NumericAttributes[] = {"alpha", "seed", "training_steps", SLIP_POLICY_MOVING_DT_MAX};

/* The number that an attribute stands for, NaN when it is a text. */
PetscErrorCode SlipPolicyAttributeNumber_Private(const char name[], const char value[], PetscReal *number)
{
  char *end;
  PetscBool numeric = PETSC_FALSE;

  PetscFunctionBegin;
  *number = NAN;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(NumericAttributes) && !numeric; i++)
    PetscCall(PetscStrcmp(name, NumericAttributes[i], &numeric));
  if (!numeric || !value[0]) PetscFunctionReturn(PETSC_SUCCESS);
  *number = (PetscReal)strtod(value, &end);
  if (*end || PetscIsInfOrNanReal(*number)) *number = NAN;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipPolicyGetNumber - an attribute that is a number

  Not collective

  Input Parameters:
+ p    - the policy
- name - of the attribute, such as `SLIP_POLICY_MOVING_DT_MAX`

  Output Parameters:
+ value - the number, in the unit that the attribute's writer gave it; 0 when there is none
- has   - whether there is one

  Level: intermediate

.seealso: SlipPolicySetAttribute()
@*/
PetscErrorCode SlipPolicyGetNumber(SlipPolicy p, const char name[], PetscReal *value, PetscBool *has)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  *value = 0;
  *has = PETSC_FALSE;
  for (PetscInt i = 0; i < p->nattributes && !*has; i++) {
    char *end;

    PetscCall(PetscStrcmp(p->attributes[2 * i], name, has));
    if (!*has) continue;
    *value = (PetscReal)strtod(p->attributes[2 * i + 1], &end);
    if (*end || end == p->attributes[2 * i + 1] || PetscIsInfOrNanReal(*value)) {
      *has = PETSC_FALSE;
      *value = 0;
      break;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The shortest of two texts that reads back as the same number. */
PetscErrorCode SlipPolicyNumberText_Private(PetscReal number, size_t len, char text[])
{
  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(text, len, "%.15g", (double)number));
  if (strtod(text, NULL) != (double)number) PetscCall(PetscSNPrintf(text, len, "%.17g", (double)number));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipPolicyGetAttribute - what was noted about the training

  Not collective

  Input Parameters:
+ p    - the policy
- name - of the attribute, such as "problem"

  Output Parameter:
. value - its text, borrowed; `NULL` when there is none

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

/*@C
  SlipPolicySetAttribute - note something about the training, kept as an attribute of the file's root

  Logically collective

  Input Parameters:
+ p     - the policy
. name  - algorithm, problem, alpha, training_steps, seed, library_version, created, or any other name
- value - its text

  Level: intermediate

.seealso: SlipPolicyStore(), SlipPolicyView()
@*/
PetscErrorCode SlipPolicySetAttribute(SlipPolicy p, const char name[], const char value[])
{
  char text[64], **attributes;
  PetscReal number;
  PetscInt at = 0;
  int order = 1;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  PetscCall(SlipPolicyAttributeNumber_Private(name, value, &number));
  if (!PetscIsNanReal(number)) {
    PetscCall(SlipPolicyNumberText_Private(number, sizeof(text), text));
    value = text;
  }
  p->hash[0] = 0;
  while (at < p->nattributes && (order = strcmp(p->attributes[2 * at], name)) < 0) at++;
  if (at < p->nattributes && !order) {
    PetscCall(PetscFree(p->attributes[2 * at + 1]));
    PetscCall(PetscStrallocpy(value, &p->attributes[2 * at + 1]));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc1(2 * (p->nattributes + 1), &attributes));
  PetscCall(PetscArraycpy(attributes, p->attributes, 2 * at));
  PetscCall(PetscArraycpy(attributes + 2 * (at + 1), p->attributes + 2 * at, 2 * (p->nattributes - at)));
  PetscCall(PetscFree(p->attributes));
  p->attributes = attributes;
  PetscCall(PetscStrallocpy(name, &attributes[2 * at]));
  PetscCall(PetscStrallocpy(value, &attributes[2 * at + 1]));
  p->nattributes++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipPolicyGetObservations - names of what the policy observes

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
  SlipPolicyGetStepBounds - the smallest and the largest step the policy can choose

  Not collective

  Input Parameters:
+ p     - the policy
. tstar - time scale T* of the problem [s]
- tmax  - end of the simulated time [s]

  Output Parameters:
+ dt_min - [s]
- dt_max - [s]

  Note:
  Raises PETSC_ERR_ARG_OUTOFRANGE when the bounds, given in different units, do not fit this problem (dt_min >= dt_max).

  Level: intermediate

  Errors: PETSC_ERR_ARG_WRONGSTATE without an action, or without a maximum time that the steps are parts of

.seealso: SlipPolicySetAction()
@*/
PetscErrorCode SlipPolicyGetStepBounds(SlipPolicy p, PetscReal tstar, PetscReal tmax, PetscReal *dt_min,
                                       PetscReal *dt_max)
{
  const PetscReal unit[3] = {1, tstar, tmax};

  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  PetscCheck(p->has_action, PetscObjectComm((PetscObject)p), PETSC_ERR_ARG_WRONGSTATE,
             "Policy %s has no action (/action)", SlipPolicySource_Private(p));
  PetscCheck((p->dt_unit[0] < 2 && p->dt_unit[1] < 2) || tmax < PETSC_MAX_REAL, PetscObjectComm((PetscObject)p),
             PETSC_ERR_ARG_WRONGSTATE,
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

/*@C
  SlipPolicyGetHash - digest of everything the policy holds, for provenance

  Not collective

  Input Parameter:
. p - the policy

  Output Parameter:
. hash - 16 hexadecimal digits (FNV-1a, 64 bit), borrowed; the same for a policy in memory and loaded from its file

  Level: intermediate

.seealso: SlipPolicyGetFile()
@*/
PetscErrorCode SlipPolicyGetHash(SlipPolicy p, const char *hash[])
{
  size_t n;
  char *bytes;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  if (!p->hash[0]) {
    PetscCall(SlipPolicyPack_Private(p, &n, &bytes));
    PetscCall(
      PetscSNPrintf(p->hash, sizeof(p->hash), "%016llx", (unsigned long long)SlipHashBytes(SLIP_HASH_START, bytes, n)));
    PetscCall(PetscFree(bytes));
  }
  *hash = p->hash;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipPolicyGetFile - the file a policy came from or was stored to

  Not collective

  Input Parameter:
. p - the policy

  Output Parameter:
. file - borrowed; "(in memory)" when there is none

  Level: intermediate

.seealso: SlipPolicyLoad(), SlipPolicyGetHash()
@*/
PetscErrorCode SlipPolicyGetFile(SlipPolicy p, const char *file[])
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  *file = SlipPolicySource_Private(p);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipPolicyGetRange - smallest and largest values of the observations in training

  Not collective

  Input Parameter:
. p - the policy

  Output Parameters:
+ min - one per observation, dimensionless, borrowed; `NULL` when the policy does not know
- max - likewise, dimensionless

  Level: intermediate

.seealso: SlipPolicySetRange(), SlipPolicyEvaluate()
@*/
PetscErrorCode SlipPolicyGetRange(SlipPolicy p, const PetscReal *min[], const PetscReal *max[])
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  *min = p->range;
  *max = p->range ? p->range + p->n : NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipPolicyView - print a policy

  Collective

  Input Parameters:
+ p      - the policy
- viewer - an ASCII viewer, `NULL` for standard output

  Level: beginner

.seealso: SlipPolicyLoad()
@*/
PetscErrorCode SlipPolicyView(SlipPolicy p, PetscViewer viewer)
{
  const char *hash;
  PetscBool ascii;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  if (!viewer) PetscCall(PetscViewerASCIIGetStdout(PetscObjectComm((PetscObject)p), &viewer));
  PetscCall(PetscObjectTypeCompare((PetscObject)viewer, PETSCVIEWERASCII, &ascii));
  if (!ascii) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipPolicyGetHash(p, &hash));
  PetscCall(PetscViewerASCIIPrintf(viewer, "policy: %s, hash %s\n", SlipPolicySource_Private(p), hash));
  PetscCall(PetscViewerASCIIPushTab(viewer));
  for (PetscInt i = 0; i < p->nattributes; i++)
    PetscCall(PetscViewerASCIIPrintf(viewer, "%s: %s\n", p->attributes[2 * i], p->attributes[2 * i + 1]));
  for (PetscInt i = 0; i < p->n; i++) {
    PetscCall(PetscViewerASCIIPrintf(viewer, "observes %s, scale %g, offset %g", p->names[i], (double)p->scale[i],
                                     (double)p->offset[i]));
    PetscCall(PetscViewerASCIIUseTabs(viewer, PETSC_FALSE));
    if (p->range)
      PetscCall(
        PetscViewerASCIIPrintf(viewer, ", in [%g, %g] in training", (double)p->range[i], (double)p->range[p->n + i]));
    PetscCall(PetscViewerASCIIPrintf(viewer, "\n"));
    PetscCall(PetscViewerASCIIUseTabs(viewer, PETSC_TRUE));
  }
  for (PetscInt l = 0; l < p->nlayers; l++)
    PetscCall(PetscViewerASCIIPrintf(viewer, "layer %" PetscInt_FMT ": %" PetscInt_FMT " to %" PetscInt_FMT ", %s\n", l,
                                     p->layers[l].in, p->layers[l].out, SlipActivations[p->layers[l].activation]));
  if (p->has_action)
    PetscCall(PetscViewerASCIIPrintf(viewer, "step from %g %s to %g %s, %s spacing\n", (double)p->dt[0],
                                     SlipStepUnits[p->dt_unit[0]], (double)p->dt[1], SlipStepUnits[p->dt_unit[1]],
                                     p->log_spacing ? "logarithmic" : "linear"));
  PetscCall(PetscViewerASCIIPopTab(viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}
