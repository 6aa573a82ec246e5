/* The file of a matrix. Each write copies it to FILE.part.new, adds one group there and takes FILE's place, under a
   lock: a run that is killed at any moment leaves a complete file, and processes of one run or of several may share
   it. */
#include "evaluate.h"
#include <slipcompat.h>
#include "common/files.h"
#include "common/options.h"
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

#define EVALUATE_FORMAT "slipstep-evaluation"
#define EVALUATE_VERSION 1
#define REFERENCE_ROWS 20000 /* kept of a reference at most */
#define CELL_ROWS 2000       /* kept of a cell at most, for plots; its numbers come from all of them */

/* ---- lock ---- */

/* A lock of this kind ends with its process, also with one that is killed; its file stays. */
static PetscErrorCode Lock(const char file[], int *lock)
{
  struct flock region = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
  char name[PETSC_MAX_PATH_LEN + 8];

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(name, sizeof(name), "%s.lock", file));
  *lock = open(name, O_RDWR | O_CREAT, 0666);
  PetscCheck(*lock >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot create %s: %s (-evaluate_output)", name,
             strerror(errno));
  PetscCheck(fcntl(*lock, F_SETLKW, &region) >= 0, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot lock %s", name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Begin(const EvaluateOptions *o, SlipH5 *h, int *lock)
{
  const SlipH5Kind kind = {.option = "evaluate_output"};
  char version[256];

  PetscFunctionBegin;
  PetscCall(Lock(o->output, lock));
  if (access(o->output, F_OK)) {
    PetscCall(SlipH5CreateKind(&kind, o->output, h));
    PetscCall(SlipH5WriteAttrString(h, "/", "format", EVALUATE_FORMAT));
    PetscCall(SlipH5WriteAttrInt(h, "/", "version", EVALUATE_VERSION));
    PetscCall(SlipH5WriteAttrString(h, "/", "settings", o->settings));
    PetscCall(SlipH5WriteAttrString(h, "/", "slipstep_version", SLIPSTEP_VERSION));
    PetscCall(PetscGetVersion(version, sizeof(version)));
    PetscCall(SlipH5WriteAttrString(h, "/", "petsc_version", version));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipH5CreateCopy(&kind, o->output, o->output, h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode End(SlipH5 *h, int lock)
{
  PetscFunctionBegin;
  PetscCall(SlipH5Close(h));
  close(lock);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What an older run has left under this name goes. */
static PetscErrorCode Group(SlipH5 *h, const char path[])
{
  PetscFunctionBegin;
  PetscCall(SlipH5RemoveGroup(h, path));
  PetscCall(SlipH5Group(h, path, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- tables ---- */

/* A table of at most rows rows, evenly chosen with the first and the last; in single precision unless exact. */
static PetscErrorCode WriteTable(SlipH5 *h, const char group[], const char name[], const Table *t, PetscInt rows,
                                 PetscBool exact)
{
  const PetscInt n = PetscMin(t->n, rows), w = t->width, dims[2] = {n, w};
  char path[4 * EVALUATE_NAME];
  PetscReal *data;
  float *single;

  PetscFunctionBegin;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", group, name));
  PetscCall(PetscMalloc2(n * w, &data, n * w, &single));
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt from =
      n > 1 ? (PetscInt)((PetscReal)i * (PetscReal)(t->n - 1) / (PetscReal)(n - 1) + (PetscReal)0.5) : 0;

    for (PetscInt k = 0; k < w; k++) {
      data[i * w + k] = t->data[from * w + k];
      single[i * w + k] = (float)data[i * w + k];
    }
  }
  if (exact)
    PetscCall(SlipH5WriteReal(h, path, 2, dims, data, NULL));
  else
    PetscCall(SlipH5WriteFloat(h, path, 2, dims, single, NULL));
  PetscCall(PetscFree2(data, single));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* "time s, mean_slip m, ...": what the columns of a table are */
static PetscErrorCode DescribeSeries(SlipH5 *h, const char group[], const Evaluation *p)
{
  char text[256] = "time s", path[4 * EVALUATE_NAME];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < p->ncolumns; k++)
    PetscCall(TextAdd(text, sizeof(text), ", %s %s", p->columns[k], p->units[k]));
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s/series", group));
  PetscCall(SlipH5WriteAttrString(h, path, "columns", text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteCase(SlipH5 *h, const char path[], const ProblemCase *c)
{
  PetscFunctionBegin;
  PetscCall(SlipH5WriteAttrString(h, path, "problem", c->problem->name));
  PetscCall(SlipH5WriteAttrReal(h, path, "size_km", c->size));
  PetscCall(SlipH5WriteAttrInt(h, path, "mesh", c->mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- references ---- */

PetscErrorCode EvaluateFileWriteReference(const EvaluateOptions *o, const ProblemCase *c, EvaluateReference *ref)
{
  char path[2 * EVALUATE_NAME];
  SlipH5 h;
  int lock;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(path, sizeof(path), "/references/%s", c->name));
  PetscCall(Begin(o, &h, &lock));
  PetscCall(Group(&h, path));
  PetscCall(WriteCase(&h, path, c));
  PetscCall(SlipH5WriteAttrString(&h, path, "kind", ref->steps ? "constant steps" : "exact solution"));
  PetscCall(SlipH5WriteAttrInt(&h, path, "steps", ref->steps));
  PetscCall(SlipH5WriteAttrReal(&h, path, "self_final", ref->self_final));
  PetscCall(SlipH5WriteAttrReal(&h, path, "self_max", ref->self_max));
  PetscCall(SlipH5WriteAttrReal(&h, path, "wall", ref->wall));
  PetscCall(SlipH5WriteAttrReal(&h, path, "final", ref->series.data[(ref->series.n - 1) * ref->series.width + 1]));
  PetscCall(WriteTable(&h, path, "series", &ref->series, REFERENCE_ROWS + 1, PETSC_TRUE));
  PetscCall(DescribeSeries(&h, path, c->problem->evaluation));
  PetscCall(WriteTable(&h, path, "profile", &ref->profile, 4 * EVALUATE_PROFILES, PETSC_FALSE));
  PetscCall(End(&h, lock));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EvaluateFileReadReference(const EvaluateOptions *o, const ProblemCase *c, EvaluateReference *ref)
{
  const PetscInt want[2] = {-1, 1 + c->problem->evaluation->ncolumns};
  char path[2 * EVALUATE_NAME];
  PetscInt dims[2];
  SlipH5 h;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(path, sizeof(path), "/references/%s/series", c->name));
  PetscCall(SlipH5OpenRead(o->output, &h));
  PetscCall(SlipH5ReadRealSized(&h, path, 2, want, "a column for each number of a row", dims, &ref->series.data));
  PetscCall(SlipH5Close(&h));
  ref->series.n = ref->series.capacity = dims[0];
  ref->series.width = dims[1];
  PetscCheck(dims[0] > 1, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s: %s has %" PetscInt_FMT " rows, expected at least 2", o->output, path, dims[0]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- cells ---- */

static PetscErrorCode WriteHow(SlipH5 *h, const EvaluateCell *cell)
{
  PetscFunctionBegin;
  PetscCall(SlipH5WriteAttrString(h, cell->path, "controller", cell->controller));
  PetscCall(SlipH5WriteAttrString(h, cell->path, "error", TSBatheErrors[cell->error]));
  PetscCall(SlipH5WriteAttrString(h, cell->path, "reaction", TSBatheReactionTypes[cell->reaction]));
  PetscCall(SlipH5WriteAttrReal(h, cell->path, "tolerance", cell->tolerance));
  PetscCall(SlipH5WriteAttrInt(h, cell->path, "steps", cell->steps));
  if (!cell->policy) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipH5WriteAttrReal(h, cell->path, "accuracy", cell->accuracy));
  PetscCall(SlipH5WriteAttrString(h, cell->path, "policy", cell->policy->name));
  PetscCall(SlipH5WriteAttrString(h, cell->path, "policy_file", cell->policy->file));
  PetscCall(SlipH5WriteAttrString(h, cell->path, "policy_hash", cell->policy->hash));
  PetscCall(SlipH5WriteAttrString(h, cell->path, "policy_algorithm", cell->policy->algorithm));
  PetscCall(SlipH5WriteAttrReal(h, cell->path, "policy_alpha", cell->policy->alpha));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteResult(SlipH5 *h, const char path[], const EvaluateResult *r)
{
  const struct {
    const char *name;
    PetscInt value;
  } counts[] = {{"converged", r->converged},
                {"accepted", r->accepted},
                {"rejected", r->attempts - r->accepted},
                {"solves", r->solves},
                {"newton_iterations", r->newton},
                {"linear_iterations", r->linear},
                {"failures", r->failures},
                {"guarded", r->guarded},
                {"repetitions", r->runs},
                {"products_k", r->products.k},
                {"products_h", r->products.h},
                {"products_pc", r->products.pc},
                {"products_all", r->products.all}};
  const struct {
    const char *name;
    PetscReal value;
  } numbers[] = {{"final", r->final},       {"final_error", r->final_error}, {"max_error", r->max_error},
                 {"l2_error", r->l2_error}, {"rate_error", r->rate_error},   {"wall", r->wall},
                 {"wall_min", r->wall_min}, {"wall_max", r->wall_max},       {"wall_setup", r->wall_setup},
                 {"cpu", r->cpu},           {"cost", r->products.cost}};

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(counts); i++)
    PetscCall(SlipH5WriteAttrInt(h, path, counts[i].name, counts[i].value));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(numbers); i++)
    PetscCall(SlipH5WriteAttrReal(h, path, numbers[i].name, numbers[i].value));
  PetscCall(SlipH5WriteAttrString(h, path, "reason", r->reason));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* When a cell was made, in an order that sorts: of cells of one policy's name but of different files, readers take the
   newest file's. */
static PetscErrorCode WriteDate(SlipH5 *h, const char path[])
{
  struct timespec now = {0, 0};
  const struct tm *utc;
  char day[32] = "", text[48];

  PetscFunctionBegin;
  (void)timespec_get(&now, TIME_UTC);
  utc = gmtime(&now.tv_sec);
  if (utc) strftime(day, sizeof(day), "%Y-%m-%dT%H:%M:%S", utc);
  snprintf(text, sizeof(text), "%s.%06ldZ", day, now.tv_nsec / 1000);
  PetscCall(SlipH5WriteAttrString(h, path, "created", text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EvaluateFileWriteCell(const EvaluateOptions *o, const ProblemCase *c, const EvaluateCell *cell,
                                     EvaluateResult *r)
{
  PetscMPIInt size;
  SlipH5 h;
  int lock;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCall(Begin(o, &h, &lock));
  PetscCall(Group(&h, cell->path));
  PetscCall(WriteCase(&h, cell->path, c));
  PetscCall(WriteHow(&h, cell));
  PetscCall(WriteResult(&h, cell->path, r));
  PetscCall(WriteDate(&h, cell->path));
  PetscCall(SlipH5WriteAttrInt(&h, cell->path, "ranks", c->mesh > o->spread ? size : 1));
  PetscCall(WriteTable(&h, cell->path, "series", &r->series, CELL_ROWS, PETSC_FALSE));
  if (r->series.n) PetscCall(DescribeSeries(&h, cell->path, c->problem->evaluation));
  PetscCall(WriteTable(&h, cell->path, "attempts", &r->steps, CELL_ROWS, PETSC_FALSE));
  if (r->converged) PetscCall(WriteTable(&h, cell->path, "profile", &r->profile, EVALUATE_PROFILES, PETSC_FALSE));
  PetscCall(End(&h, lock));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what is there ---- */

PetscErrorCode EvaluateFileCheck(const EvaluateOptions *o)
{
  char format[64] = "", *settings;
  PetscInt version = 0;
  PetscBool has, same;
  SlipH5 h;
  size_t len;

  PetscFunctionBegin;
  if (access(o->output, F_OK)) {
    PetscCallFile("-evaluate_output", SlipH5CheckCreateKind(&(SlipH5Kind){0}, o->output));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCallFile("-evaluate_output", SlipH5OpenRead(o->output, &h));
  PetscCall(SlipH5HasAttribute(&h, "/", "format", &has));
  if (has) PetscCall(SlipH5ReadAttrString(&h, "/", "format", format, sizeof(format)));
  PetscCall(PetscStrcmp(format, EVALUATE_FORMAT, &same));
  if (same) PetscCall(SlipH5ReadAttrInt(&h, "/", "version", &version));
  PetscCheck(version == EVALUATE_VERSION, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "-evaluate_output %s is no file of evaluate (format \"%s\", version %" PetscInt_FMT
             "), expected \"%s\", version %d, or a new name",
             o->output, format, version, EVALUATE_FORMAT, EVALUATE_VERSION);
  PetscCall(PetscStrlen(o->settings, &len));
  PetscCall(PetscCalloc1(len + 4096, &settings));
  PetscCall(SlipH5ReadAttrString(&h, "/", "settings", settings, len + 4096));
  PetscCall(PetscStrcmp(settings, o->settings, &same));
  PetscCheck(same, PETSC_COMM_SELF, PETSC_ERR_ARG_INCOMP,
             "-evaluate_output %s holds cells with the options \"%s\" but this run has \"%s\": expected the same, or "
             "another file",
             o->output, settings, o->settings);
  PetscCall(PetscFree(settings));
  PetscCall(SlipH5Close(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CellKnown(SlipH5 *h, const EvaluateCell *cell, EvaluateState *s)
{
  char hash[72];
  PetscInt converged = 1;

  PetscFunctionBegin;
  PetscCall(SlipH5HasAttribute(h, cell->path, "converged", &s->known));
  if (!s->known) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipH5ReadAttrInt(h, cell->path, "converged", &converged));
  s->failed = converged ? PETSC_FALSE : PETSC_TRUE;
  if (!cell->policy) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipH5ReadAttrString(h, cell->path, "policy_hash", hash, sizeof(hash)));
  PetscCall(PetscStrcmp(hash, cell->policy->hash, &s->known)); /* or another policy of this name has been here */
  if (!s->known) *s = (EvaluateState){.outdated = PETSC_TRUE};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EvaluateFileKnown(const EvaluateOptions *o, const EvaluateMatrix *m, PetscBool reference[],
                                 EvaluateState cell[])
{
  char path[2 * EVALUATE_NAME];
  SlipH5 h;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(reference, m->ncases));
  PetscCall(PetscArrayzero(cell, m->ncells));
  if (access(o->output, F_OK)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipH5OpenRead(o->output, &h));
  for (PetscInt i = 0; i < m->ncases; i++) {
    PetscCall(PetscSNPrintf(path, sizeof(path), "/references/%s/series", m->cases[i].name));
    PetscCall(SlipH5Has(&h, path, &reference[i]));
  }
  for (PetscInt i = 0; i < m->ncells; i++) PetscCall(CellKnown(&h, &m->cells[i], &cell[i]));
  PetscCall(SlipH5Close(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}
