/* Policies as HDF5 files (slippolicy.h): rank 0 reads or writes, and all ranks get its numbers and its errors. */
#include <slipstep/private/slippolicy.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/rooms/slipsys.h>
#include <time.h>

#define POLICY_FORMAT "slipstep-policy"
#define POLICY_VERSION 1

static PetscErrorCode ReadObservations(SlipH5 *h5, SlipPolicy p)
{
  PetscInt n, m;
  char **names;
  PetscReal *values[2] = {NULL, NULL};
  PetscErrorCode ierr;

  PetscFunctionBegin;
  PetscCall(SlipH5ReadStrings(h5, "/observation/names", &n, &names));
  ierr = SlipH5ReadRealSized(h5, "/observation/scale", 1, &n, "one for each observation", &m, &values[0]);
  if (!ierr) ierr = SlipH5ReadRealSized(h5, "/observation/offset", 1, &n, "one for each observation", &m, &values[1]);
  if (!ierr) ierr = SlipPolicySetObservations(p, n, (const char *const *)names, values[0], values[1]);
  PetscCall(SlipH5FreeStrings(n, &names));
  PetscCall(PetscFree(values[0]));
  PetscCall(PetscFree(values[1]));
  PetscCall(ierr);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadRange(SlipH5 *h5, SlipPolicy p)
{
  PetscReal *values[2] = {NULL, NULL};
  PetscInt m;
  PetscBool has;
  PetscErrorCode ierr;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h5, "/range", &has));
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  ierr = SlipH5ReadRealSized(h5, "/range/minimum", 1, &p->n, "one for each observation", &m, &values[0]);
  if (!ierr) ierr = SlipH5ReadRealSized(h5, "/range/maximum", 1, &p->n, "one for each observation", &m, &values[1]);
  if (!ierr) ierr = SlipPolicySetRange(p, values[0], values[1]);
  PetscCall(PetscFree(values[0]));
  PetscCall(PetscFree(values[1]));
  PetscCall(ierr);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadLayer(SlipH5 *h5, SlipPolicy p, const char group[])
{
  char path[128], name[64];
  const PetscInt columns = p->nlayers ? p->layers[p->nlayers - 1].out : p->n, want[2] = {-1, columns};
  PetscInt shape[2], rows;
  PetscReal *weight = NULL, *bias = NULL;
  PetscEnum activation;
  PetscBool known;
  PetscErrorCode ierr;

  PetscFunctionBegin;
  PetscCall(SlipH5ReadAttrString(h5, group, "activation", name, sizeof(name)));
  PetscCall(PetscEnumFind(SlipActivations, name, &activation, &known));
  PetscCheck(known, PETSC_COMM_SELF, PETSC_ERR_ARG_UNKNOWN_TYPE,
             "%s: attribute activation of %s is \"%s\"; expected relu, tanh, linear or hardtanh2", h5->name, group,
             name);
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s/weight", group));
  PetscCall(SlipH5ReadRealSized(
    h5, path, 2, want, p->nlayers ? "a column for each row of the layer before" : "a column for each observation",
    shape, &weight));
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s/bias", group));
  ierr = SlipH5ReadRealSized(h5, path, 1, &shape[0], "one for each row of weight", &rows, &bias);
  if (!ierr) ierr = SlipPolicyAddLayer(p, shape[1], shape[0], weight, bias, (SlipActivation)activation);
  PetscCall(PetscFree(weight));
  PetscCall(PetscFree(bias));
  PetscCall(ierr);
  PetscFunctionReturn(PETSC_SUCCESS);
}

enum { max_layers = 64 };

/* Reads /layers/0, /layers/1, ..., which must be contiguous, as layers after a gap would be ignored silently. */
static PetscErrorCode ReadLayers(SlipH5 *h5, SlipPolicy p)
{
  char group[64];
  PetscBool has;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h5, "/layers/0", &has));
  PetscCheck(has, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s has no group /layers/0; expected the first layer there", h5->name);
  PetscCall(SlipH5CountMembers(h5, "/layers", &n));
  PetscCheck(n <= max_layers, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s: /layers has %" PetscInt_FMT " members; expected at most %d", h5->name, n, (int)max_layers);
  for (PetscInt k = 0; has; k++) {
    PetscCall(PetscSNPrintf(group, sizeof(group), "/layers/%" PetscInt_FMT, k));
    PetscCall(SlipH5Has(h5, group, &has));
    if (has) PetscCall(ReadLayer(h5, p, group));
  }
  PetscCheck(n == p->nlayers, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s: /layers has %" PetscInt_FMT " members, but only %" PetscInt_FMT " numbered from 0 on; there is no %s",
             h5->name, n, p->nlayers, group);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadAction(SlipH5 *h5, SlipPolicy p)
{
  PetscReal low, high, dt_min, dt_max;
  char unit[2][64], squash[64], spacing[64] = "linear";
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipH5ReadAttrReal(h5, "/action", "low", &low));
  PetscCall(SlipH5ReadAttrReal(h5, "/action", "high", &high));
  PetscCall(SlipH5ReadAttrReal(h5, "/action", "dt_min", &dt_min));
  PetscCall(SlipH5ReadAttrReal(h5, "/action", "dt_max", &dt_max));
  PetscCall(SlipH5ReadAttrString(h5, "/action", "dt_min_unit", unit[0], sizeof(unit[0])));
  PetscCall(SlipH5ReadAttrString(h5, "/action", "dt_max_unit", unit[1], sizeof(unit[1])));
  PetscCall(SlipH5ReadAttrString(h5, "/action", "squash", squash, sizeof(squash)));
  PetscCheck(!strcmp(squash, "tanh"), PETSC_COMM_SELF, PETSC_ERR_ARG_UNKNOWN_TYPE,
             "%s: attribute squash of /action is \"%s\"; expected \"tanh\"", h5->name, squash);
  PetscCall(SlipH5HasAttribute(h5, "/action", "spacing", &has));
  if (has) PetscCall(SlipH5ReadAttrString(h5, "/action", "spacing", spacing, sizeof(spacing)));
  PetscCheck(!strcmp(spacing, "linear") || !strcmp(spacing, "log"), PETSC_COMM_SELF, PETSC_ERR_ARG_UNKNOWN_TYPE,
             "%s: attribute spacing of /action is \"%s\"; expected \"linear\" or \"log\"", h5->name, spacing);
  PetscCall(SlipPolicySetAction(p, low, high, dt_min, unit[0], dt_max, unit[1],
                                strcmp(spacing, "log") ? PETSC_FALSE : PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

enum { max_attributes = 64 };

/* Reads the description of the training: every attribute of the root, numbers as text. */
static PetscErrorCode ReadAttributes(SlipH5 *h5, SlipPolicy p)
{
  char *name[max_attributes], value[1024];
  PetscReal number;
  PetscBool text;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(SlipH5GetAttributes(h5, max_attributes, &n, name));
  for (PetscInt k = 0; k < n; k++) {
    if (!SlipPolicyOwnAttribute_Private(name[k])) {
      PetscCall(SlipH5IsText(h5, "/", name[k], &text));
      if (text) {
        PetscCall(SlipH5ReadAttrString(h5, "/", name[k], value, sizeof(value)));
      } else {
        PetscCall(SlipH5ReadAttrReal(h5, "/", name[k], &number));
        PetscCall(SlipPolicyNumberText_Private(number, sizeof(value), value));
      }
      PetscCall(SlipPolicySetAttribute(p, name[k], value));
    }
    PetscCall(PetscFree(name[k]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadContent(SlipH5 *h5, SlipPolicy p)
{
  char noted[64];
  const char *hash;
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipPolicyCheckFormat(h5, POLICY_FORMAT, POLICY_VERSION));
  PetscCall(ReadObservations(h5, p));
  PetscCall(ReadRange(h5, p));
  PetscCall(ReadLayers(h5, p));
  PetscCall(ReadAction(h5, p));
  PetscCall(ReadAttributes(h5, p));
  PetscCall(SlipPolicyCheck_Private(p));
  PetscCall(SlipH5HasAttribute(h5, "/", "checksum", &has)); /* older files have none */
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipH5ReadAttrString(h5, "/", "checksum", noted, sizeof(noted)));
  PetscCall(SlipPolicyGetHash(p, &hash));
  PetscCheck(!strcmp(noted, hash), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s: the checksum of its content is %s, expected \"%s\" (attribute checksum of /): it is damaged, or was "
             "edited; without that attribute it is read as it is",
             h5->name, hash, noted);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: reads the content of a file and packs it. The file is closed in any case. */
static PetscErrorCode ReadPacked(const char file[], size_t *n, char **bytes)
{
  SlipH5 h5;
  SlipPolicy p;
  PetscErrorCode ierr;

  PetscFunctionBegin;
  PetscCall(SlipPolicyCreate(PETSC_COMM_SELF, &p));
  PetscCall(PetscStrallocpy(file, &p->file));
  ierr = SlipH5OpenRead(file, &h5);
  if (!ierr) {
    ierr = ReadContent(&h5, p);
    PetscCall(SlipH5Close(&h5));
  }
  if (!ierr) ierr = SlipPolicyPack_Private(p, n, bytes);
  PetscCall(SlipPolicyDestroy(&p));
  PetscCall(ierr);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipPolicyLoad - reads a policy from an HDF5 file

  Collective; rank 0 reads, all ranks get identical numbers. If an error is raised the policy is not changed.

  Input Parameters:
+ policy - the policy
- file   - its name; slippolicy.h describes the format

  Errors: PETSC_ERR_FILE_OPEN if the file is missing, truncated or not HDF5; PETSC_ERR_FILE_UNEXPECTED, PETSC_ERR_FP,
  PETSC_ERR_ARG_SIZ, PETSC_ERR_ARG_UNKNOWN_TYPE or PETSC_ERR_ARG_OUTOFRANGE, with the dataset or attribute and what was
  expected, for another format or version, missing parts, wrong shapes, numbers that are not finite, unknown activations
  and units, bounds in the wrong order, or a content that does not match its checksum.

  Level: beginner

.seealso: SlipPolicyStore(), SlipPolicyCreate()
@*/
PetscErrorCode SlipPolicyLoad(SlipPolicy policy, const char file[])
{
  MPI_Comm comm;
  PetscMPIInt rank;
  PetscErrorCode ierr = PETSC_SUCCESS;
  size_t n = 0;
  char *bytes = NULL;
  unsigned long count;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(policy, SLIP_POLICY_CLASSID, 1);
  PetscAssertPointer(file, 2);
  PetscCall(PetscObjectGetComm((PetscObject)policy, &comm));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) ierr = ReadPacked(file, &n, &bytes);
  PetscCall(SlipErrorBcast(comm, ierr));
  count = (unsigned long)n;
  PetscCallMPI(MPI_Bcast(&count, 1, MPI_UNSIGNED_LONG, 0, comm));
  if (rank) PetscCall(PetscMalloc1(count, &bytes));
  PetscCallMPI(MPI_Bcast(bytes, (PetscMPIInt)count, MPI_BYTE, 0, comm));
  PetscCall(SlipPolicyClear_Private(policy));
  PetscCall(SlipPolicyUnpack_Private(policy, (size_t)count, bytes));
  PetscCall(PetscStrallocpy(file, &policy->file));
  PetscCall(PetscFree(bytes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteLayer(SlipH5 *h5, PetscInt k, const SlipLayer *layer)
{
  const PetscInt shape[2] = {layer->out, layer->in};
  char group[64], path[128];
  PetscReal *weight;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(group, sizeof(group), "/layers/%" PetscInt_FMT, k));
  PetscCall(PetscMalloc1(layer->in * layer->out, &weight));
  for (PetscInt o = 0; o < layer->out; o++)
    for (PetscInt i = 0; i < layer->in; i++) weight[o * layer->in + i] = layer->weight[i * layer->out + o];
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s/weight", group));
  PetscCall(SlipH5WriteReal(h5, path, 2, shape, weight, NULL));
  PetscCall(PetscFree(weight));
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s/bias", group));
  PetscCall(SlipH5WriteReal(h5, path, 1, shape, layer->bias, NULL));
  PetscCall(SlipH5WriteAttrString(h5, group, "activation", SlipActivations[layer->activation]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteContent(SlipH5 *h5, SlipPolicy p)
{
  const char *hash;
  PetscReal number;

  PetscFunctionBegin;
  PetscCall(SlipH5WriteAttrString(h5, "/", "format", POLICY_FORMAT));
  PetscCall(SlipH5WriteAttrInt(h5, "/", "version", POLICY_VERSION));
  PetscCall(SlipPolicyGetHash(p, &hash));
  PetscCall(SlipH5WriteAttrString(h5, "/", "checksum", hash));
  for (PetscInt i = 0; i < p->nattributes; i++) {
    const char *name = p->attributes[2 * i], *value = p->attributes[2 * i + 1];

    PetscCall(SlipPolicyAttributeNumber_Private(name, value, &number));
    if (PetscIsNanReal(number))
      PetscCall(SlipH5WriteAttrString(h5, "/", name, value));
    else if (number == PetscFloorReal(number) && PetscAbsReal(number) < 1e9)
      PetscCall(SlipH5WriteAttrInt(h5, "/", name, (PetscInt)number));
    else
      PetscCall(SlipH5WriteAttrReal(h5, "/", name, number));
  }
  PetscCall(SlipH5WriteStrings(h5, "/observation/names", p->n, (const char *const *)p->names));
  PetscCall(SlipH5WriteReal(h5, "/observation/scale", 1, &p->n, p->scale, NULL));
  PetscCall(SlipH5WriteReal(h5, "/observation/offset", 1, &p->n, p->offset, NULL));
  for (PetscInt l = 0; l < p->nlayers; l++) PetscCall(WriteLayer(h5, l, &p->layers[l]));
  PetscCall(SlipH5Group(h5, "/action", PETSC_FALSE));
  PetscCall(SlipH5WriteAttrReal(h5, "/action", "low", p->low));
  PetscCall(SlipH5WriteAttrReal(h5, "/action", "high", p->high));
  PetscCall(SlipH5WriteAttrString(h5, "/action", "squash", "tanh"));
  PetscCall(SlipH5WriteAttrReal(h5, "/action", "dt_min", p->dt[0]));
  PetscCall(SlipH5WriteAttrReal(h5, "/action", "dt_max", p->dt[1]));
  PetscCall(SlipH5WriteAttrString(h5, "/action", "dt_min_unit", SlipStepUnits[p->dt_unit[0]]));
  PetscCall(SlipH5WriteAttrString(h5, "/action", "dt_max_unit", SlipStepUnits[p->dt_unit[1]]));
  PetscCall(SlipH5WriteAttrString(h5, "/action", "spacing", p->log_spacing ? "log" : "linear"));
  if (p->range) {
    PetscCall(SlipH5WriteReal(h5, "/range/minimum", 1, &p->n, p->range, NULL));
    PetscCall(SlipH5WriteReal(h5, "/range/maximum", 1, &p->n, p->range + p->n, NULL));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: closing gives the file its name, so that an incomplete one is abandoned. */
static PetscErrorCode WriteFile(SlipPolicy p, const char file[])
{
  SlipH5 h5;
  PetscErrorCode ierr;

  PetscFunctionBegin;
  PetscCall(SlipH5Create(file, &h5));
  ierr = WriteContent(&h5, p);
  if (!ierr)
    ierr = SlipH5Close(&h5);
  else
    PetscCall(SlipH5Abandon(&h5));
  PetscCall(ierr);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets date and library version, by the clock of rank 0, unless the caller has set them. */
static PetscErrorCode NoteOrigin(SlipPolicy p)
{
  char created[32] = "";
  PetscBool has_created = PETSC_FALSE, has_version = PETSC_FALSE;
  time_t now = time(NULL);
  struct tm *utc = gmtime(&now);

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->nattributes; i++) {
    if (!strcmp(p->attributes[2 * i], "created")) has_created = PETSC_TRUE;
    if (!strcmp(p->attributes[2 * i], "library_version")) has_version = PETSC_TRUE;
  }
  if (!has_version) PetscCall(SlipPolicySetAttribute(p, "library_version", SLIPSTEP_VERSION));
  if (has_created) PetscFunctionReturn(PETSC_SUCCESS);
  if (utc) strftime(created, sizeof(created), "%Y-%m-%dT%H:%M:%SZ", utc);
  PetscCallMPI(MPI_Bcast(created, (PetscMPIInt)sizeof(created), MPI_CHAR, 0, PetscObjectComm((PetscObject)p)));
  PetscCall(SlipPolicySetAttribute(p, "created", created));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipPolicyStore - writes a policy to an HDF5 file

  Collective; rank 0 writes file.part.new and renames it, so that an older file is not changed if an error is raised

  Input Parameters:
+ policy - the policy; the attributes created and library_version are added if they are missing
- file   - the name

  Level: beginner

.seealso: SlipPolicyLoad()
@*/
PetscErrorCode SlipPolicyStore(SlipPolicy policy, const char file[])
{
  MPI_Comm comm;
  PetscMPIInt rank;
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(policy, SLIP_POLICY_CLASSID, 1);
  PetscAssertPointer(file, 2);
  PetscCall(SlipPolicyCheck_Private(policy));
  PetscCall(NoteOrigin(policy));
  PetscCall(PetscObjectGetComm((PetscObject)policy, &comm));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) ierr = WriteFile(policy, file);
  PetscCall(SlipErrorBcast(comm, ierr));
  if (file != policy->file) {
    PetscCall(PetscFree(policy->file));
    PetscCall(PetscStrallocpy(file, &policy->file));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
