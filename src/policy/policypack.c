/* Policies as strings of bytes, which ranks exchange and of which the hash is computed */
#include <slipstep/private/slippolicy.h>

/* A position in the bytes, for counting (bytes == NULL), writing or reading */
typedef struct {
  char *bytes;
  const char *source;
  size_t at;
} Stream;

static void Put(Stream *s, const void *data, size_t n)
{
  if (s->bytes) memcpy(s->bytes + s->at, data, n);
  s->at += n;
}

static void PutInt(Stream *s, PetscInt value)
{
  const int64_t wide = value;

  Put(s, &wide, sizeof(wide));
}

static void PutReals(Stream *s, PetscInt n, const PetscReal *values)
{
  Put(s, values, (size_t)n * sizeof(*values));
}

static void PutString(Stream *s, const char *text)
{
  const size_t n = strlen(text) + 1;

  PutInt(s, (PetscInt)n);
  Put(s, text, n);
}

static void Write(SlipPolicy p, Stream *s)
{
  PutInt(s, p->n);
  for (PetscInt i = 0; i < p->n; i++) PutString(s, p->names[i]);
  PutReals(s, p->n, p->scale);
  PutReals(s, p->n, p->offset);
  PutInt(s, p->range ? 1 : 0);
  if (p->range) PutReals(s, 2 * p->n, p->range);
  PutInt(s, p->nlayers);
  for (PetscInt l = 0; l < p->nlayers; l++) {
    const SlipLayer *layer = &p->layers[l];

    PutInt(s, layer->in);
    PutInt(s, layer->out);
    PutInt(s, layer->activation);
    for (PetscInt o = 0; o < layer->out; o++)
      for (PetscInt i = 0; i < layer->in; i++) PutReals(s, 1, &layer->weight[i * layer->out + o]);
    PutReals(s, layer->out, layer->bias);
  }
  PutInt(s, p->has_action);
  PutReals(s, 1, &p->low);
  PutReals(s, 1, &p->high);
  PutReals(s, 2, p->dt);
  PutInt(s, p->dt_unit[0]);
  PutInt(s, p->dt_unit[1]);
  PutInt(s, p->log_spacing);
  PutInt(s, p->nattributes);
  for (PetscInt i = 0; i < 2 * p->nattributes; i++) PutString(s, p->attributes[i]);
}

/* Packs the content of a policy, the same on every rank; free it by PetscFree(). */
PetscErrorCode SlipPolicyPack_Private(SlipPolicy p, size_t *n, char **bytes)
{
  Stream s = {NULL, NULL, 0};

  PetscFunctionBegin;
  Write(p, &s);
  *n = s.at;
  PetscCall(PetscMalloc1(*n, bytes));
  s.bytes = *bytes;
  s.at = 0;
  Write(p, &s);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscInt GetInt(Stream *s)
{
  int64_t wide;

  memcpy(&wide, s->source + s->at, sizeof(wide));
  s->at += sizeof(wide);
  return (PetscInt)wide;
}

static void GetReals(Stream *s, PetscInt n, PetscReal *values)
{
  memcpy(values, s->source + s->at, (size_t)n * sizeof(*values));
  s->at += (size_t)n * sizeof(*values);
}

static const char *GetString(Stream *s)
{
  const size_t n = (size_t)GetInt(s);
  const char *text = s->source + s->at;

  s->at += n;
  return text;
}

static PetscErrorCode GetObservations(SlipPolicy p, Stream *s)
{
  const PetscInt n = GetInt(s);
  const char **names;
  PetscReal *values;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(n, &names, 2 * n, &values));
  for (PetscInt i = 0; i < n; i++) names[i] = GetString(s);
  GetReals(s, 2 * n, values);
  PetscCall(SlipPolicySetObservations(p, n, names, values, values + n));
  if (GetInt(s)) {
    GetReals(s, 2 * n, values);
    PetscCall(SlipPolicySetRange(p, values, values + n));
  }
  PetscCall(PetscFree2(names, values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode GetLayer(SlipPolicy p, Stream *s)
{
  const PetscInt in = GetInt(s), out = GetInt(s);
  const SlipActivation activation = (SlipActivation)GetInt(s);
  PetscReal *weight, *bias;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(in * out, &weight, out, &bias));
  GetReals(s, in * out, weight);
  GetReals(s, out, bias);
  PetscCall(SlipPolicyAddLayer(p, in, out, weight, bias, activation));
  PetscCall(PetscFree2(weight, bias));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills an empty policy from the bytes of a complete one. */
PetscErrorCode SlipPolicyUnpack_Private(SlipPolicy p, size_t n, const char *bytes)
{
  Stream s = {NULL, bytes, 0};
  PetscReal bounds[4];
  PetscInt unit[2], count;
  PetscBool log_spacing;

  PetscFunctionBegin;
  PetscCall(GetObservations(p, &s));
  count = GetInt(&s);
  for (PetscInt l = 0; l < count; l++) PetscCall(GetLayer(p, &s));
  (void)GetInt(&s);
  GetReals(&s, 4, bounds);
  unit[0] = GetInt(&s);
  unit[1] = GetInt(&s);
  log_spacing = GetInt(&s) ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipPolicySetAction(p, bounds[0], bounds[1], bounds[2], SlipStepUnits[unit[0]], bounds[3],
                                SlipStepUnits[unit[1]], log_spacing));
  count = GetInt(&s);
  for (PetscInt i = 0; i < count; i++) {
    const char *name = GetString(&s), *value = GetString(&s);

    PetscCall(SlipPolicySetAttribute(p, name, value));
  }
  PetscCheck(s.at == n, PETSC_COMM_SELF, PETSC_ERR_PLIB, "Policy of %zu bytes unpacked to %zu", n, s.at);
  PetscCall(SlipPolicyCheck_Private(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}
