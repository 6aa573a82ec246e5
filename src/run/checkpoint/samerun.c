/* Compares a run with that of a checkpoint. The checkpoint has every row of the tables of parameters.c and choices.c
   whose part is the problem or its steps, and what files and options result in; they are compared where a run
   continues. */
#include <slipstep/private/sliprun.h>
#include <slipstep/private/slipsys.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Relative difference within which computed numbers, such as the critical energy, are the same; on other numbers of
   ranks they differ by rounding. */
#define CHECKPOINT_SAME 1e-6

typedef struct {
  SlipState s;
  PetscBool allowed;    /* differences are allowed, and announced */
  char text[2048];      /* differences that are refused */
  char announced[2048]; /* differences that are allowed */
} Differences;

static PetscErrorCode Differ(Differences *d, const char format[], const char name[], const char now[],
                             const char then[])
{
  char *text = d->allowed ? d->announced : d->text, one[512];

  PetscFunctionBegin;
  (void)snprintf(one, sizeof(one), format, name, now, then);
  PetscCall(PetscStrlcat(text, text[0] ? "; " : "", sizeof(d->text)));
  PetscCall(PetscStrlcat(text, one, sizeof(d->text)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Compares a number; tolerance: relative, for computed numbers */
static PetscErrorCode CompareReal(Differences *d, const char name[], PetscReal now, const char unit[],
                                  PetscReal tolerance)
{
  PetscReal then = now;
  char a[64], b[64];

  PetscFunctionBegin;
  PetscCall(SlipStateReal(d->s, name, 1, &then));
  if (PetscAbsReal(then - now) <= tolerance * PetscAbsReal(now)) PetscFunctionReturn(PETSC_SUCCESS);
  for (int digits = 6; digits <= 17; digits++) { /* the fewest that distinguish them */
    (void)snprintf(a, sizeof(a), "%.*g%s%s", digits, (double)now, unit[0] ? " " : "", unit);
    (void)snprintf(b, sizeof(b), "%.*g%s%s", digits, (double)then, unit[0] ? " " : "", unit);
    if (strcmp(a, b)) break;
  }
  PetscCall(Differ(d, "%s is %s, was %s", name, a, b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CompareText(Differences *d, const char name[], const char now[])
{
  char then[PETSC_MAX_PATH_LEN] = "";
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(then, now, sizeof(then)));
  PetscCall(SlipStateString(d->s, name, then, sizeof(then)));
  PetscCall(PetscStrcmp(now, then, &same));
  if (!same) PetscCall(Differ(d, "%s is %s, was %s", name, now, then));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Compares numbers of the local cells by a hash that does not depend on their distribution; least, mean and largest
   value describe them in messages. */
static PetscErrorCode CompareCells(Differences *d, SlipFault fault, const char name[], const char unit[],
                                   const PetscReal x[])
{
  PetscReal range[2] = {PETSC_MAX_REAL, PETSC_MAX_REAL}, sum = 0;
  uint64_t hash = 0;
  char values[96], digest[128], then[128];

  PetscFunctionBegin;
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal entry[] = {(PetscReal)SlipFaultMeshRow(&fault->mesh, i), x[i]};

    hash += SlipHashReals(SLIP_HASH_START, entry, 2);
    range[0] = PetscMin(range[0], x[i]);
    range[1] = PetscMin(range[1], -x[i]);
    sum += x[i];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &hash, 1, MPI_UINT64_T, MPI_SUM, fault->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, range, 2, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPIU_SUM, fault->comm));
  if (range[0] == -range[1])
    (void)snprintf(values, sizeof(values), "%.9g", (double)range[0]);
  else
    (void)snprintf(values, sizeof(values), "%.9g to %.9g, in the mean %.9g", (double)range[0], -(double)range[1],
                   (double)(sum / (PetscReal)fault->mesh.N));
  (void)snprintf(digest, sizeof(digest), "%016" PRIx64 " %s%s%s", hash, values, unit[0] ? " " : "", unit);
  PetscCall(PetscStrncpy(then, digest, sizeof(then)));
  PetscCall(SlipStateString(d->s, name, then, sizeof(then)));
  if (!strncmp(digest, then, 16)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Differ(d, "%s is %s, was %s", name, digest + 17, strlen(then) > 17 ? then + 17 : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Compares the type of a matrix, without PETSc's prefix for one process or several. */
static PetscErrorCode CompareType(Differences *d, const char name[], Mat A)
{
  MatType type;

  PetscFunctionBegin;
  PetscCall(MatGetType(A, &type));
  if (!strncmp(type, "seq", 3) || !strncmp(type, "mpi", 3)) type += 3;
  PetscCall(CompareText(d, name, type));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- rows of these tables, by their parts; those of the run and of the output may change ---- */

static PetscErrorCode CompareStrings(Differences *d, SlipFault fault)
{
  PetscFunctionBegin;
  for (PetscInt id = 0; id < FAULT_NUM_STRINGS; id++) {
    const SlipFaultString *p = &SlipFaultStrings[id];
    const char *text = SlipFaultGetText(fault, id);
    PetscBool has, same;

    d->allowed =
      p->part == SLIP_PART_STEPS && p->choices ? PETSC_TRUE : PETSC_FALSE; /* content of files is announced elsewhere */
    if (!d->allowed && p->part != SLIP_PART_PROBLEM) continue;
    PetscCall(SlipStateHasValue(d->s, p->name, &has));
    PetscCall(PetscStrcmp(text, p->value, &same));
    if (has)
      PetscCall(CompareText(d, p->name, text[0] ? text : "none"));
    else if (!same) /* the checkpoint's version had only the default */
      PetscCall(Differ(d, "%s is %s, was %s", p->name, text, p->value));
  }
  d->allowed = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- given options of PETSc's objects, all of which are part of the steps ---- */

static PetscBool IsOfSolver(const char name[])
{
  static const char *const groups[] = {"ts_", "snes_", "ksp_", "pc_", "mat_"};
  static const char *const others[] = {"ts_type", "ts_max_time", "ts_max_steps", "ts_dt", "ts_time_step"};
  PetscBool is = PETSC_FALSE;

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(groups); i++)
    if (!strncmp(name, groups[i], strlen(groups[i]))) is = PETSC_TRUE;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(others); i++)
    if (!strcmp(name, others[i])) is = PETSC_FALSE;
  return is && !strstr(name, "monitor") && !strstr(name, "view") ? PETSC_TRUE : PETSC_FALSE;
}

/* Lists these options with their values: "-name value -name value". */
static PetscErrorCode SolverOptions(TS ts, char text[], size_t len)
{
  const char *prefix;
  char *all, **words;
  PetscBool taken = PETSC_FALSE;
  size_t skip = 1;
  int n;

  PetscFunctionBegin;
  text[0] = '\0';
  PetscCall(TSGetOptionsPrefix(ts, &prefix));
  if (prefix) skip += strlen(prefix);
  PetscCall(PetscOptionsGetAll(((PetscObject)ts)->options, &all));
  PetscCall(PetscStrToArray(all, ' ', &n, &words));
  for (int i = 0; i < n; i++) {
    PetscBool name;

    PetscCall(PetscOptionsValidKey(words[i], &name));
    if (name)
      taken =
        (!prefix || !strncmp(words[i] + 1, prefix, skip - 1)) && IsOfSolver(words[i] + skip) ? PETSC_TRUE : PETSC_FALSE;
    if (name && taken)
      PetscCall(SlipHasOption(((PetscObject)ts)->options, NULL, words[i] + 1, &taken)); /* not a word of a value */
    if (!taken) continue;
    PetscCall(PetscStrlcat(text, text[0] ? " " : "", len));
    PetscCall(PetscStrlcat(text, words[i], len));
  }
  PetscCall(PetscStrToArrayDestroy(n, words));
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Compares options; numbers may be written in more than one way. */
static PetscErrorCode CompareOptions(Differences *d, TS ts)
{
  char text[2][8192];
  PetscOptions options[2];

  PetscFunctionBegin;
  PetscCall(SolverOptions(ts, text[0], sizeof(text[0])));
  PetscCall(PetscStrncpy(text[1], text[0], sizeof(text[1])));
  PetscCall(SlipStateString(d->s, "solver_options", text[1], sizeof(text[1])));
  d->allowed = PETSC_TRUE;
  for (int k = 0; k < 2; k++) {
    PetscCall(PetscOptionsCreate(&options[k]));
    PetscCall(PetscOptionsInsertString(options[k], text[k]));
  }
  for (int k = 0; k < 2; k++) {
    char **words;
    int n;

    PetscCall(PetscStrToArray(text[k], ' ', &n, &words));
    for (int i = 0; i < n; i++) {
      const char *value[2] = {NULL, NULL};
      PetscBool name, set[2], same;
      PetscReal a, b;
      char *end[2];

      PetscCall(PetscOptionsValidKey(words[i], &name));
      if (!name) continue;
      for (int j = 0; j < 2; j++) {
        PetscCall(PetscOptionsFindPair(options[j], NULL, words[i], &value[j], &set[j]));
        value[j] = !set[j] ? "not given" : value[j] && value[j][0] ? value[j] : "given";
      }
      a = strtod(value[0], &end[0]);
      b = strtod(value[1], &end[1]);
      same = a == b && end[0] > value[0] && end[1] > value[1] && !*end[0] && !*end[1] ? PETSC_TRUE : PETSC_FALSE;
      if ((!k || !set[0]) && !same && strcmp(value[0], value[1]))
        PetscCall(Differ(d, "%s is %s, was %s", words[i], value[0], value[1]));
    }
    PetscCall(PetscStrToArrayDestroy(n, words));
  }
  for (int k = 0; k < 2; k++) PetscCall(PetscOptionsDestroy(&options[k]));
  d->allowed = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- results of files and set-up ---- */

/* Compares the content of the record of -fault_pore_pressure, whatever its file's name; sums of hashes do not depend on
   the distribution of cells. The caller must ensure that a function of SlipFaultSetPressureFunction() is the same. */
static PetscErrorCode CompareRecord(Differences *d, SlipFault fault)
{
  const SlipFaultLoads *loads = &fault->loads;
  uint64_t hash = 0;
  char digest[64] = "no record";

  PetscFunctionBegin;
  for (PetscInt i = 0; i < fault->mesh.n && loads->rows; i++) {
    const PetscReal number = (PetscReal)SlipFaultMeshRow(&fault->mesh, i);
    uint64_t cell = SlipHashReals(SLIP_HASH_START, &number, 1);

    cell = SlipHashReals(cell, loads->times, (size_t)loads->rows);
    for (PetscInt k = 0; k < loads->rows; k++)
      cell = SlipHashReals(cell, &loads->record[(size_t)k * fault->mesh.n + i], 1);
    hash += cell;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &hash, 1, MPI_UINT64_T, MPI_SUM, fault->comm));
  if (loads->rows) (void)snprintf(digest, sizeof(digest), "of %lld times, %016" PRIx64, (long long)loads->rows, hash);
  PetscCall(CompareText(d, "pore_pressure", digest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does so with the records of -fault_stress_history and SlipFaultAddStress(); older checkpoints have none. */
static PetscErrorCode CompareHistory(Differences *d, SlipFault fault)
{
  const SlipFaultLoads *loads = &fault->loads;
  const PetscInt c = fault->layout.components;
  uint64_t hash = 0, courses = SLIP_HASH_START;
  PetscInt records = 0;
  char digest[64] = "none";
  PetscBool has;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < loads->nterms; k++) {
    records += loads->terms[k].rows ? 1 : 0;
    courses = SlipHashReals(courses, loads->terms[k].times, (size_t)loads->terms[k].rows);
    courses = SlipHashReals(courses, loads->terms[k].values, (size_t)loads->terms[k].rows);
  }
  for (PetscInt i = 0; i < fault->mesh.n && records; i++) {
    const PetscReal number = (PetscReal)SlipFaultMeshRow(&fault->mesh, i);
    uint64_t cell = SlipHashReals(courses, &number, 1);

    for (PetscInt k = 0; k < loads->nterms; k++) {
      const SlipLoadTerm *term = &loads->terms[k];

      if (term->rows && term->shear) cell = SlipHashReals(cell, term->shear + c * i, (size_t)c);
      if (term->rows && term->normal) cell = SlipHashReals(cell, term->normal + i, 1);
    }
    hash += cell;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &hash, 1, MPI_UINT64_T, MPI_SUM, fault->comm));
  if (records) (void)snprintf(digest, sizeof(digest), "of %lld records, %016" PRIx64, (long long)records, hash);
  PetscCall(SlipStateHasValue(d->s, "stress_history", &has));
  if (has)
    PetscCall(CompareText(d, "stress_history", digest));
  else if (records)
    PetscCall(Differ(d, "%s is %s, was %s", "stress_history", digest, "none"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does so with the wells; older checkpoints have none. */
static PetscErrorCode CompareWells(Differences *d, SlipFault fault)
{
  const SlipFaultLoads *loads = &fault->loads;
  uint64_t hash = SLIP_HASH_START;
  char digest[64] = "none";
  PetscBool has;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < loads->nwells; k++) {
    const SlipFaultWell *well = &loads->wells[k];
    const PetscReal own[] = {well->place[0], well->place[1], well->place[2],
                             well->radius,   well->spread,   (PetscReal)well->pressure};

    hash = SlipHashBytes(hash, well->name, strlen(well->name));
    hash = SlipHashReals(hash, own, PETSC_STATIC_ARRAY_LENGTH(own));
    hash = SlipHashReals(hash, well->time, (size_t)well->rows);
    hash = SlipHashReals(hash, well->value, (size_t)well->rows);
  }
  if (loads->nwells) (void)snprintf(digest, sizeof(digest), "%lld, %016" PRIx64, (long long)loads->nwells, hash);
  PetscCall(SlipStateHasValue(d->s, "wells", &has));
  if (has)
    PetscCall(CompareText(d, "wells", digest));
  else if (loads->nwells)
    PetscCall(Differ(d, "%s is %s, was %s", "wells", digest, "none"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Compares the content of the tolerances for -fault_accuracy; older checkpoints have none. */
static PetscErrorCode CompareTolerances(Differences *d, SlipFault fault)
{
  const SlipFaultTolerances *t = &fault->steps.tolerances;
  const char *file = fault->options.text[FAULT_TOLERANCES];
  char digest[PETSC_MAX_PATH_LEN + 32] = "", then[PETSC_MAX_PATH_LEN + 32];
  uint64_t hash = SlipHashReals(SLIP_HASH_START, t->accuracy, (size_t)t->accuracies);
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipStateHas(d->s, "tolerances", &has));
  if (!has || (!t->controllers && !SlipStateIsLoading(d->s))) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt c = 0; c < t->controllers; c++) hash = SlipHashReals(hash, t->row[c].rtol, (size_t)t->accuracies);
  (void)snprintf(digest, sizeof(digest), "%016" PRIx64 " %s", hash,
                 !t->controllers ? "(in no use)"
                 : file[0]       ? file
                                 : "of the library");
  PetscCall(PetscStrncpy(then, digest, sizeof(then)));
  PetscCall(SlipStateGroup(d->s, "tolerances"));
  PetscCall(SlipStateString(d->s, "content", then, sizeof(then)));
  d->allowed = PETSC_TRUE;
  if (strncmp(digest, then, 16)) PetscCall(Differ(d, "%s is %s, was %s", "tolerances", digest, then));
  d->allowed = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses the checkpoint of another run, with the differences, and announces another way to compute the same. */
PetscErrorCode SlipFaultVisitRun(SlipFault fault, SlipState s, TS ts)
{
  Differences d = {.s = s};
  const SlipParameter *p;
  PetscBool cells, hierarchical;
  PetscMPIInt rank;
  Mat K, H;
  char digest[128];

  PetscFunctionBegin;
  PetscCall(SlipElasticGetMatrices(fault->medium, &K, NULL, &H));
  PetscCall(SlipStateGroup(s, "parameters"));
  for (PetscInt id = 0; id < FAULT_NUM_REALS; id++) {
    const SlipParameter *p = SlipFaultRealRow(id);
    PetscReal value, apart = 0;

    d.allowed = p->part == SLIP_PART_STEPS ? PETSC_TRUE : PETSC_FALSE;
    if (!d.allowed && (p->part != SLIP_PART_PROBLEM || SlipFaultFieldOf(id) >= 0)) continue; /* fields are compared */
    PetscCall(SlipFaultGetReal(fault, p->name, &value));
    if (id == FAULT_HMAT_TOLERANCE) { /* a default follows from how steps are computed */
      if (PetscIsNanReal(fault->options.value[id])) d.allowed = PETSC_TRUE;
      PetscCall(SlipFaultIsHierarchical(fault, &hierarchical));
      if (!hierarchical) apart = PETSC_MAX_REAL; /* not in use */
    }
    PetscCall(CompareReal(&d, p->name, value, p->unit, apart));
  }
  d.allowed = PETSC_FALSE;
  PetscCall(CompareStrings(&d, fault));
  for (PetscInt i = 0; i < FAULT_NUM_SWITCHES; i++) {
    const SlipFaultSwitch *p = &SlipFaultSwitches[i];
    const PetscBool *at = (const PetscBool *)((const char *)fault + p->offset);

    if (p->part != SLIP_PART_PROBLEM) continue;
    if (at == &fault->options.inertia) at = &fault->kind.inertia; /* where it was not given, the law determined it */
    PetscCall(CompareText(&d, p->name, *at ? "yes" : "no"));
  }
  PetscCall(CompareText(&d, "ts_type", ((PetscObject)ts)->type_name));
  PetscCall(fault->mesh.kind->digest(&fault->mesh, digest, 64));
  PetscCall(CompareText(&d, "mesh", digest));
  /* The entries of -fault_stiffness_file as they were read, whatever the file's name, as scaling rounds them. Mesh,
     kernel and elastic moduli determine a computed stiffness. */
  (void)snprintf(digest, sizeof(digest), "no entries of a file");
  if (fault->options.text[FAULT_STIFFNESS_FILE][0])
    (void)snprintf(digest, sizeof(digest), "of %lld x %lld entries of a file, %016" PRIx64, (long long)fault->mesh.N,
                   (long long)fault->mesh.N, fault->operators.read);
  PetscCall(CompareText(&d, "stiffness", digest));
  PetscCall(CompareType(&d, "operator", K));
  PetscCall(CompareType(&d, "viscosity", H));
  cells = d.text[0] ? PETSC_FALSE : PETSC_TRUE; /* the number of cells is the same */
  for (PetscInt f = 0; (p = SlipFaultFieldRow(f)) && cells; f++)
    if (SlipFaultHasField(fault, f)) PetscCall(CompareCells(&d, fault, p->name, p->unit, fault->fields.cell[f]));
  if (cells) PetscCall(CompareRecord(&d, fault));
  if (cells) PetscCall(CompareHistory(&d, fault));
  PetscCall(CompareWells(&d, fault));
  if (!d.text[0]) PetscCall(CompareReal(&d, "scaling_of_stiffness", fault->operators.scaling, "", CHECKPOINT_SAME));
  if (!d.text[0]) PetscCall(CompareReal(&d, "critical_energy", fault->critical.energy, "Pa m", CHECKPOINT_SAME));
  PetscCheck(!d.text[0], fault->comm, PETSC_ERR_ARG_INCOMP, "-%sfault_restart %s is the checkpoint of another run: %s",
             SlipFaultPrefix(fault), fault->options.text[FAULT_RESTART], d.text);
  PetscCall(CompareOptions(&d, ts));
  PetscCall(CompareTolerances(&d, fault));
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (d.announced[0] && !rank)
    PetscCall(SlipWarning("the run goes on with other steps or solvers than it began with: %s (-%sfault_restart %s)",
                          d.announced, SlipFaultPrefix(fault), fault->options.text[FAULT_RESTART]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
