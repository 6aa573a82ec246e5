/* Setters of a SlipPolicy, which check each part, and a check that the parts match */
#include <slipstep/private/slippolicy.h>
#include <stdlib.h>

const char *const SlipActivations[] = {"linear",           "relu", "tanh", "hardtanh2", "SlipActivation",
                                       "SLIP_ACTIVATION_", NULL};
const char *const SlipStepUnits[] = {"s", "T*", "t_max", "h", NULL};

const char *SlipPolicySource_Private(SlipPolicy p)
{
  return p->file ? p->file : "(in memory)";
}

/* The content has changed: the hash and the work arrays are out of date. */
static PetscErrorCode Changed(SlipPolicy p)
{
  PetscFunctionBegin;
  p->hash[0] = 0;
  p->factor = 0;
  PetscCall(PetscFree(p->work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks that every number of a dataset is finite; the error names the first that is not. */
static PetscErrorCode CheckFinite(SlipPolicy p, const char dataset[], PetscInt n, const PetscReal values[])
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++)
    PetscCheck(!PetscIsInfOrNanReal(values[i]), PetscObjectComm((PetscObject)p), PETSC_ERR_FP,
               "Policy %s: %s has the value %g at entry %" PetscInt_FMT "; expected finite numbers",
               SlipPolicySource_Private(p), dataset, (double)values[i], i);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipPolicySetObservations - sets what the policy observes

  Logically collective

  Input Parameters:
+ p      - the policy
. n      - number of observations, at least 1
. names  - their names [n], see `SlipObservationView()`
. scale  - factors [n], dimensionless, not zero
- offset - offsets [n], dimensionless; the network sees obs * scale + offset

  Level: intermediate

  Errors: PETSC_ERR_ARG_OUTOFRANGE for n < 1, PETSC_ERR_ARG_WRONG for an empty name or a scale of 0, PETSC_ERR_FP for
  numbers that are not finite

.seealso: SlipPolicyAddLayer(), SlipPolicyGetObservations()
@*/
PetscErrorCode SlipPolicySetObservations(SlipPolicy p, PetscInt n, const char *const names[], const PetscReal scale[],
                                         const PetscReal offset[])
{
  MPI_Comm comm = PetscObjectComm((PetscObject)p);

  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  PetscCheck(n > 0, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Policy %s: /observation/names has %" PetscInt_FMT " entries; expected at least 1",
             SlipPolicySource_Private(p), n);
  PetscCall(CheckFinite(p, "/observation/scale", n, scale));
  PetscCall(CheckFinite(p, "/observation/offset", n, offset));
  for (PetscInt i = 0; i < n; i++) {
    PetscCheck(names[i] && names[i][0], comm, PETSC_ERR_ARG_WRONG,
               "Policy %s: /observation/names entry %" PetscInt_FMT " is empty; expected a name",
               SlipPolicySource_Private(p), i);
    PetscCheck(scale[i] != 0, comm, PETSC_ERR_ARG_WRONG,
               "Policy %s: /observation/scale is 0 at entry %" PetscInt_FMT " (%s); expected a factor",
               SlipPolicySource_Private(p), i, names[i]);
  }
  for (PetscInt i = 0; i < p->n; i++) PetscCall(PetscFree(p->names[i]));
  PetscCall(PetscFree(p->names));
  PetscCall(PetscFree2(p->scale, p->offset));
  PetscCall(PetscFree(p->range));
  PetscCall(PetscCalloc1(n, &p->names));
  PetscCall(PetscMalloc2(n, &p->scale, n, &p->offset));
  p->n = n;
  for (PetscInt i = 0; i < n; i++) PetscCall(PetscStrallocpy(names[i], &p->names[i]));
  PetscCall(PetscArraycpy(p->scale, scale, n));
  PetscCall(PetscArraycpy(p->offset, offset, n));
  PetscCall(Changed(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipPolicyAddLayer - appends a dense layer to the network

  Logically collective

  Input Parameters:
+ p          - the policy
. in         - number of inputs, which is the number of outputs of the layer before
. out        - number of outputs; 1 in the last layer
. weight     - row-major [out][in], copied, dimensionless
. bias       - [out], copied, dimensionless
- activation - applied to weight x + bias

  Level: intermediate

  Errors: PETSC_ERR_ARG_OUTOFRANGE for sizes that are not positive or an unknown activation, PETSC_ERR_FP for numbers
  that are not finite

.seealso: SlipPolicySetObservations(), SlipPolicySetAction()
@*/
PetscErrorCode SlipPolicyAddLayer(SlipPolicy p, PetscInt in, PetscInt out, const PetscReal weight[],
                                  const PetscReal bias[], SlipActivation activation)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)p);
  char dataset[64];
  SlipLayer *layers, *layer;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  PetscCheck(in > 0 && out > 0, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Policy %s: /layers/%" PetscInt_FMT "/weight has shape [%" PetscInt_FMT ", %" PetscInt_FMT
             "]; expected positive sizes",
             SlipPolicySource_Private(p), p->nlayers, out, in);
  PetscCheck((int)activation >= 0 && activation <= SLIP_ACTIVATION_HARDTANH2, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Policy %s: layer %" PetscInt_FMT " has activation %d; expected a SlipActivation",
             SlipPolicySource_Private(p), p->nlayers, (int)activation);
  PetscCall(PetscSNPrintf(dataset, sizeof(dataset), "/layers/%" PetscInt_FMT "/weight", p->nlayers));
  PetscCall(CheckFinite(p, dataset, in * out, weight));
  PetscCall(PetscSNPrintf(dataset, sizeof(dataset), "/layers/%" PetscInt_FMT "/bias", p->nlayers));
  PetscCall(CheckFinite(p, dataset, out, bias));

  PetscCall(PetscMalloc1(p->nlayers + 1, &layers));
  PetscCall(PetscArraycpy(layers, p->layers, p->nlayers));
  PetscCall(PetscFree(p->layers));
  p->layers = layers;
  layer = &layers[p->nlayers];
  layer->in = in;
  layer->out = out;
  layer->activation = activation;
  PetscCall(PetscMalloc2(in * out, &layer->weight, out, &layer->bias));
  for (PetscInt o = 0; o < out; o++)
    for (PetscInt i = 0; i < in; i++) layer->weight[i * out + o] = weight[o * in + i];
  PetscCall(PetscArraycpy(layer->bias, bias, out));
  p->nlayers++;
  PetscCall(Changed(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FindUnit(SlipPolicy p, const char attribute[], const char unit[], PetscInt *index)
{
  PetscBool same = PETSC_FALSE;

  PetscFunctionBegin;
  for (*index = 0; SlipStepUnits[*index]; (*index)++) {
    PetscCall(PetscStrcmp(unit, SlipStepUnits[*index], &same));
    if (same) break;
  }
  PetscCheck(same, PetscObjectComm((PetscObject)p), PETSC_ERR_ARG_UNKNOWN_TYPE,
             "Policy %s: attribute %s of /action is \"%s\"; expected \"s\", \"T*\", \"t_max\" or \"h\"",
             SlipPolicySource_Private(p), attribute, unit);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipPolicySetAction - sets how the network's output is converted to a step

  Logically collective

  Input Parameters:
+ p           - the policy
. low         - lowest action, dimensionless
. high        - highest action, dimensionless
. dt_min      - step at the lowest action, in dt_min_unit; >= 0, > 0 with log_spacing
. dt_min_unit - "s", "T*" (the problem's time scale), "t_max" (the simulated duration) or "h" (the last attempt's step)
. dt_max      - step at the highest action, in dt_max_unit
. dt_max_unit - see dt_min_unit
- log_spacing - steps in geometric proportion between the bounds instead of linear

  Level: intermediate

  Errors: PETSC_ERR_ARG_OUTOFRANGE or PETSC_ERR_ARG_WRONG unless low < high and 0 <= dt_min < dt_max (0 < dt_min with
  log_spacing), all finite and in known units, both "h" or neither

.seealso: SlipPolicyActionToStep(), SlipPolicyGetStepBounds()
@*/
PetscErrorCode SlipPolicySetAction(SlipPolicy p, PetscReal low, PetscReal high, PetscReal dt_min,
                                   const char dt_min_unit[], PetscReal dt_max, const char dt_max_unit[],
                                   PetscBool log_spacing)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)p);
  PetscInt unit[2];
  PetscReal bounds[4] = {low, high, dt_min, dt_max};

  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  PetscCall(CheckFinite(p, "/action (low, high, dt_min, dt_max)", 4, bounds));
  PetscCall(FindUnit(p, "dt_min_unit", dt_min_unit, &unit[0]));
  PetscCall(FindUnit(p, "dt_max_unit", dt_max_unit, &unit[1]));
  PetscCheck(low < high, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Policy %s: attributes of /action are low = %g and high = %g; expected low < high",
             SlipPolicySource_Private(p), (double)low, (double)high);
  PetscCheck(dt_min >= 0 && dt_max > 0 && (unit[0] != unit[1] || dt_min < dt_max), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Policy %s: attributes of /action are dt_min = %g %s and dt_max = %g %s; expected 0 <= dt_min < dt_max",
             SlipPolicySource_Private(p), (double)dt_min, dt_min_unit, (double)dt_max, dt_max_unit);
  PetscCheck((unit[0] == SLIP_STEP_UNIT_H) == (unit[1] == SLIP_STEP_UNIT_H), comm, PETSC_ERR_ARG_WRONG,
             "Policy %s: attributes of /action are dt_min_unit = \"%s\" and dt_max_unit = \"%s\"; expected both \"h\", "
             "or neither",
             SlipPolicySource_Private(p), dt_min_unit, dt_max_unit);
  PetscCheck(!log_spacing || dt_min > 0, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Policy %s: attribute dt_min of /action is %g; expected > 0 with spacing \"log\"",
             SlipPolicySource_Private(p), (double)dt_min);
  p->low = low;
  p->high = high;
  p->dt[0] = dt_min;
  p->dt[1] = dt_max;
  p->dt_unit[0] = unit[0];
  p->dt_unit[1] = unit[1];
  p->log_spacing = log_spacing;
  p->has_action = PETSC_TRUE;
  PetscCall(Changed(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipPolicySetRange - sets the smallest and the largest value of each observation in training

  Logically collective; call it after `SlipPolicySetObservations()`

  Input Parameters:
+ p   - the policy
. min - minima [n], dimensionless
- max - maxima [n], not below the minima, dimensionless

  Level: intermediate

  Errors: PETSC_ERR_ORDER before SlipPolicySetObservations(), PETSC_ERR_ARG_OUTOFRANGE for a minimum above its maximum,
  PETSC_ERR_FP for numbers that are not finite

.seealso: SlipPolicyEvaluate()
@*/
PetscErrorCode SlipPolicySetRange(SlipPolicy p, const PetscReal min[], const PetscReal max[])
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  PetscCheck(p->n > 0, PetscObjectComm((PetscObject)p), PETSC_ERR_ORDER,
             "Call SlipPolicySetObservations() before SlipPolicySetRange()");
  PetscCall(CheckFinite(p, "/range/minimum", p->n, min));
  PetscCall(CheckFinite(p, "/range/maximum", p->n, max));
  for (PetscInt i = 0; i < p->n; i++)
    PetscCheck(min[i] <= max[i], PetscObjectComm((PetscObject)p), PETSC_ERR_ARG_OUTOFRANGE,
               "Policy %s: /range of %s is [%g, %g]; expected minimum <= maximum", SlipPolicySource_Private(p),
               p->names[i], (double)min[i], (double)max[i]);
  if (!p->range) PetscCall(PetscMalloc1(2 * p->n, &p->range));
  PetscCall(PetscArraycpy(p->range, min, p->n));
  PetscCall(PetscArraycpy(p->range + p->n, max, p->n));
  p->hash[0] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks that the policy is complete, and that every layer matches the one before; creates the work arrays. */
PetscErrorCode SlipPolicyCheck_Private(SlipPolicy p)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)p);
  const char *source = SlipPolicySource_Private(p);
  PetscInt in = p->n;

  PetscFunctionBegin;
  PetscCheck(p->n > 0, comm, PETSC_ERR_ARG_WRONGSTATE, "Policy %s has no observations (/observation/names)", source);
  PetscCheck(p->nlayers > 0, comm, PETSC_ERR_ARG_WRONGSTATE, "Policy %s has no layers (/layers/0)", source);
  PetscCheck(p->has_action, comm, PETSC_ERR_ARG_WRONGSTATE, "Policy %s has no action (/action)", source);
  p->width = in;
  for (PetscInt l = 0; l < p->nlayers; l++) {
    const SlipLayer *layer = &p->layers[l];

    PetscCheck(layer->in == in, comm, PETSC_ERR_ARG_SIZ,
               "Policy %s: /layers/%" PetscInt_FMT "/weight has shape [%" PetscInt_FMT ", %" PetscInt_FMT
               "]; expected %" PetscInt_FMT " columns, the number of %s",
               source, l, layer->out, layer->in, in, l ? "outputs of the layer before" : "observations");
    in = layer->out;
    p->width = PetscMax(p->width, in);
  }
  PetscCheck(in == 1, comm, PETSC_ERR_ARG_SIZ,
             "Policy %s: /layers/%" PetscInt_FMT "/weight has %" PetscInt_FMT
             " rows; expected 1, the last layer gives the action",
             source, p->nlayers - 1, in);
  if (!p->work) PetscCall(PetscMalloc1(2 * p->width, &p->work));
  PetscFunctionReturn(PETSC_SUCCESS);
}
/* Converts a text to a number, NaN if it is none. */
PetscReal SlipPolicyParseNumber_Private(const char text[])
{
  char *end;
  const PetscReal number = (PetscReal)strtod(text, &end);

  return *end || end == text || PetscIsInfOrNanReal(number) ? NAN : number;
}

/* Attributes that files store as numbers if their text is one; all others are strings */
static const char *const NumericAttributes[] = {"alpha",
                                                "seed",
                                                "training_steps",
                                                SLIP_POLICY_MOVING_DT_MAX,
                                                SLIP_POLICY_RTOL_FACTOR,
                                                SLIP_POLICY_RTOL_POWER,
                                                SLIP_POLICY_FIRST_STEP_FACTOR,
                                                SLIP_POLICY_FIRST_STEP_POWER,
                                                SLIP_POLICY_HOLD,
                                                SLIP_POLICY_CEILING};

/* True for attributes of the root that describe the file and not its policy */
PetscBool SlipPolicyOwnAttribute_Private(const char name[])
{
  return !strcmp(name, "format") || !strcmp(name, "version") || !strcmp(name, "checksum") ? PETSC_TRUE : PETSC_FALSE;
}

/* Gets the number of an attribute, NaN if it is a text. */
PetscErrorCode SlipPolicyAttributeNumber_Private(const char name[], const char value[], PetscReal *number)
{
  PetscBool numeric = PETSC_FALSE;

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(NumericAttributes) && !numeric; i++)
    PetscCall(PetscStrcmp(name, NumericAttributes[i], &numeric));
  *number = numeric ? SlipPolicyParseNumber_Private(value) : NAN;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the shortest text that reads back as the same number; 0 for -0, which a file stores as an integer. */
PetscErrorCode SlipPolicyNumberText_Private(PetscReal number, size_t len, char text[])
{
  PetscFunctionBegin;
  if (number == 0) number = 0;
  PetscCall(PetscSNPrintf(text, len, "%.15g", (double)number));
  if (strtod(text, NULL) != (double)number) PetscCall(PetscSNPrintf(text, len, "%.17g", (double)number));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipPolicySetAttribute - adds a note about the training, which is stored as an attribute of the file's root

  Logically collective

  Input Parameters:
+ p     - the policy
. name  - algorithm, problem, alpha, training_steps, seed, library_version, created, or any other name
- value - its text

  Level: intermediate

  Errors: PETSC_ERR_ARG_WRONG for format, version and checksum, which the file sets itself

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
  PetscCheck(!SlipPolicyOwnAttribute_Private(name), PetscObjectComm((PetscObject)p), PETSC_ERR_ARG_WRONG,
             "Policy %s: the attribute %s is the file's own, expected another name", SlipPolicySource_Private(p), name);
  PetscCall(SlipPolicyAttributeNumber_Private(name, value, &number));
  if (!PetscIsNanReal(number)) {
    PetscCall(SlipPolicyNumberText_Private(number, sizeof(text), text));
    value = text;
  }
  p->hash[0] = 0;
  p->factor = 0;
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
