/* Adds stresses in time to the loads. Each term is a course, a function of time alone, times fields of shear and normal
   stress: records (stresshistory.c and SlipFaultAddStress()), tides and a nucleation. What integrators and the search
   for the end of rest must know of a course is in its row: where it begins and ends, and how long its period is. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <slipstep/private/slipelasticity.h>

#define NEVER PETSC_MAX_REAL

/* ---- courses ---- */

/* Returns the row of a record before t, and the share of the way from it to the next row; constant beyond the ends. */
PetscInt SlipRecordInterval(PetscInt rows, const PetscReal times[], PetscReal t, PetscReal *share)
{
  PetscInt low = 0, high = rows - 1;

  *share = 0;
  if (t <= times[0]) return 0;
  if (t >= times[high]) return high;
  while (high - low > 1) {
    const PetscInt middle = (low + high) / 2;

    if (times[middle] <= t)
      low = middle;
    else
      high = middle;
  }
  *share = (t - times[low]) / (times[high] - times[low]);
  return low;
}

static PetscReal RecordValue(const SlipLoadTerm *term, PetscReal t)
{
  PetscReal share;
  const PetscInt row = SlipRecordInterval(term->rows, term->times, t, &share);

  return share > 0 ? (1 - share) * term->values[row] + share * term->values[row + 1] : term->values[row];
}

/* Corners of records are those of all of them together, which steps may pass (stepends.c). */
static PetscReal NoEnd(const SlipLoadTerm *term, PetscReal t)
{
  (void)term, (void)t;
  return NEVER;
}

/* The argument of the sine is reduced first: after many periods it would lose digits. */
static PetscReal TideValue(const SlipLoadTerm *term, PetscReal t)
{
  const PetscReal periods = t / term->period;

  return PetscSinReal(2 * PETSC_PI * (periods - PetscFloorReal(periods) + term->phase));
}

static PetscReal TideScale(const SlipLoadTerm *term, PetscReal t)
{
  (void)t;
  return term->period;
}

/* The smooth rise of SCEC's benchmarks TPV101 to 104 */
static PetscReal RiseValue(const SlipLoadTerm *term, PetscReal t)
{
  const PetscReal T = term->duration;

  if (t <= 0) return 0;
  return t >= T ? 1 : PetscExpReal(PetscSqr(t - T) / (t * (t - 2 * T)));
}

static PetscReal RiseEnd(const SlipLoadTerm *term, PetscReal t)
{
  return t < 0 ? 0 : t < term->duration ? term->duration : NEVER;
}

static PetscReal RiseScale(const SlipLoadTerm *term, PetscReal t)
{
  return t >= 0 && t < term->duration ? term->duration : NEVER;
}

static const SlipCourse Record = {RecordValue, NoEnd, NoEnd, PETSC_FALSE},
                        Tide = {TideValue, NoEnd, TideScale, PETSC_FALSE},
                        Rise = {RiseValue, RiseEnd, RiseScale, PETSC_TRUE};

/* ---- the terms together ---- */

void SlipLoadsAddTerms(const SlipFaultLoads *loads, PetscReal t, PetscBool records, const PetscReal weight[],
                       PetscReal shear[], PetscReal p[])
{
  const PetscInt n = loads->n, c = loads->nterms ? loads->fault->layout.components : 1;

  for (PetscInt k = 0; k < loads->nterms; k++) {
    const SlipLoadTerm *term = &loads->terms[k];
    PetscReal value;

    if (records && term->course != &Record) continue;
    value = term->course->value(term, t);
    for (PetscInt i = 0; i < c * n && shear && term->shear; i++)
      shear[i] += (weight ? weight[i / c] : 1) * (value * term->shear[i]);
    for (PetscInt i = 0; i < n && p && term->normal; i++) p[i] -= value * term->normal[i];
  }
}

PetscReal SlipLoadsTermsTimes(const SlipFaultLoads *loads, PetscReal t, const PetscReal x[], PetscInt first,
                              PetscInt block)
{
  const PetscInt c = loads->fault->layout.components;
  PetscReal sum = 0;

  for (PetscInt k = 0; k < loads->nterms; k++) {
    const SlipLoadTerm *term = &loads->terms[k];
    const PetscReal value = term->course->value(term, t);

    for (PetscInt i = 0; i < loads->n && term->shear; i++)
      for (PetscInt j = 0; j < c; j++)
        sum += loads->weight[i] * (value * term->shear[c * i + j]) * x[block * i + first + j];
  }
  return sum;
}

PetscReal SlipLoadsStartShear(const SlipFaultLoads *loads, PetscInt i)
{
  const PetscInt c = loads->fault->layout.components;
  PetscReal sum = 0;

  for (PetscInt k = 0; k < loads->nterms; k++) {
    const SlipLoadTerm *term = &loads->terms[k];

    for (PetscInt j = 0; j < c && term->shear; j++)
      sum += term->course->value(term, 0) * term->shear[c * i + j] * SlipFaultAlong(loads->fault, i)[j];
  }
  return sum;
}

PetscReal SlipLoadsScale(const SlipFaultLoads *loads, PetscReal t)
{
  PetscReal scale = NEVER;

  for (PetscInt k = 0; k < loads->nterms; k++)
    scale = PetscMin(scale, loads->terms[k].course->scale(&loads->terms[k], t));
  return scale;
}

PetscErrorCode SlipLoadsTermsView(const SlipFaultLoads *loads, PetscViewer viewer)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < loads->nterms; k++) {
    const SlipLoadTerm *term = &loads->terms[k];
    char course[128] = "";

    if (term->rows)
      (void)snprintf(course, sizeof(course), ", %lld times from %.6g to %.6g s, %.6g and %.6g times that",
                     (long long)term->rows, (double)term->times[0], (double)term->times[term->rows - 1],
                     (double)term->values[0], (double)term->values[term->rows - 1]);
    PetscCall(PetscViewerASCIIPrintf(viewer, "stress in time: %s, shear up to %g Pa, normal up to %g Pa%s\n",
                                     term->name, (double)term->largest[0], (double)term->largest[1], course));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- set-up ---- */

PetscErrorCode SlipStressRecordDestroy(SlipStressRecord *record)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(record->name));
  PetscCall(PetscFree(record->times));
  PetscCall(PetscFree(record->values));
  PetscCall(PetscFree(record->shear));
  PetscCall(PetscFree(record->normal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode NewTerm(SlipFaultLoads *loads, const char name[], const SlipCourse *course, SlipLoadTerm **term)
{
  PetscFunctionBegin;
  PetscCall(PetscRealloc(sizeof(*loads->terms) * (size_t)(loads->nterms + 1), &loads->terms));
  *term = &loads->terms[loads->nterms++];
  **term = (SlipLoadTerm){.course = course};
  PetscCall(PetscStrallocpy(name, &(*term)->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds how large the fields of a term are. Collective. */
static PetscErrorCode Measure(const SlipFaultLoads *loads, SlipLoadTerm *term)
{
  const PetscInt c = loads->fault->layout.components;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < loads->n; i++) {
    if (term->shear) term->largest[0] = PetscMax(term->largest[0], SlipFaultLength(loads->fault, term->shear + c * i));
    if (term->normal) term->largest[1] = PetscMax(term->largest[1], PetscAbsReal(term->normal[i]));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, term->largest, 2, MPIU_REAL, MPIU_MAX, loads->fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the shear of cell i: along the rake, or, of two numbers, along strike and up dip; with one component of slip
   only what is along the rake counts. */
static void PutShear(SlipFaultLoads *loads, SlipLoadTerm *term, PetscInt i, const PetscReal *along,
                     const PetscReal *vector)
{
  const PetscInt c = loads->fault->layout.components;
  PetscReal *to = term->shear + c * i, rake[2];

  if (!vector)
    for (PetscInt k = 0; k < c; k++) to[k] = *along * SlipFaultAlong(loads->fault, i)[k];
  else if (c > 1)
    for (PetscInt k = 0; k < 2; k++) to[k] = vector[k];
  else {
    SlipDegrees(loads->fault->fields.cell[FIELD_RAKE][i], &rake[1], &rake[0]);
    to[0] = rake[0] * vector[0] + rake[1] * vector[1];
  }
}

/* Adds the term of a record with the numbers of the cells of this process. own: fields are of these cells only, and not
   of all */
static PetscErrorCode AddRecord(SlipFaultLoads *loads, const SlipStressRecord *record, PetscBool own)
{
  const SlipFaultMesh *mesh = &loads->fault->mesh;
  const PetscInt c = loads->fault->layout.components;
  SlipLoadTerm *term;

  PetscFunctionBegin;
  PetscCall(NewTerm(loads, record->name, &Record, &term));
  term->rows = record->rows;
  PetscCall(PetscMalloc2(term->rows, &term->times, term->rows, &term->values));
  PetscCall(PetscArraycpy(term->times, record->times, term->rows));
  PetscCall(PetscArraycpy(term->values, record->values, term->rows));
  if (record->nshear) PetscCall(PetscCalloc1(c * loads->n + 1, &term->shear));
  if (record->nnormal) PetscCall(PetscMalloc1(loads->n + 1, &term->normal));
  for (PetscInt i = 0; i < loads->n; i++) {
    const PetscInt row = own ? i : SlipFaultMeshRow(mesh, i);
    const PetscBool vector = record->nshear > 1 && record->nshear > mesh->N ? PETSC_TRUE : PETSC_FALSE;

    if (record->nshear)
      PutShear(loads, term, i, record->shear + (record->nshear > 1 ? row : 0), vector ? record->shear + 2 * row : NULL);
    if (record->nnormal) term->normal[i] = record->normal[record->nnormal > 1 ? row : 0];
  }
  PetscCall(Measure(loads, term));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Raises an error for a record that no term can be. Not collective. */
static PetscErrorCode CheckRecord(const SlipStressRecord *record, PetscInt N)
{
  const PetscReal *const field[] = {record->values, record->shear, record->normal};
  const PetscInt size[] = {record->rows, record->nshear, record->nnormal};
  static const char *const names[] = {"course", "shear", "normal"}, *const units[] = {"", " Pa", " Pa"};

  PetscFunctionBegin;
  PetscCheck(record->rows > 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED, "%s: time is empty, expected at least one",
             record->name);
  for (PetscInt k = 0; k < record->rows; k++)
    PetscCheck(isfinite(record->times[k]) && (!k || record->times[k] > record->times[k - 1]), PETSC_COMM_SELF,
               PETSC_ERR_FILE_UNEXPECTED,
               "%s: time[%" PetscInt_FMT "] is %.9g s, expected finite times, each later than the one before",
               record->name, k, (double)record->times[k]);
  PetscCheck(record->nshear || record->nnormal, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s: there is neither shear nor normal, expected one of them, or both", record->name);
  PetscCheck(record->nshear <= 1 || record->nshear == N || record->nshear == 2 * N, PETSC_COMM_SELF,
             PETSC_ERR_FILE_UNEXPECTED,
             "%s: shear has %" PetscInt_FMT " numbers, expected 1, %" PetscInt_FMT " for the cells, or %" PetscInt_FMT
             " for their components",
             record->name, record->nshear, N, 2 * N);
  PetscCheck(record->nnormal <= 1 || record->nnormal == N, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s: normal has %" PetscInt_FMT " numbers, expected 1, or %" PetscInt_FMT " for the cells", record->name,
             record->nnormal, N);
  for (int f = 0; f < 3; f++)
    for (PetscInt i = 0; i < size[f]; i++)
      PetscCheck(isfinite(field[f][i]), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
                 "%s: %s[%" PetscInt_FMT "] is %g%s, expected a finite number", record->name, names[f], i,
                 (double)field[f][i], units[f]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ShareReals(MPI_Comm comm, PetscInt n, PetscReal **x)
{
  PetscFunctionBegin;
  if (!*x) PetscCall(PetscMalloc1(PetscMax(n, 1), x));
  PetscCallMPI(MPI_Bcast(*x, (PetscMPIInt)n, MPIU_REAL, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Replaces the field x [n] of a record, which rank 0 has, by what this process needs: a number for all cells, or one or
   two of each of its own. */
static PetscErrorCode ShareField(const SlipFaultMesh *mesh, PetscInt n, PetscReal **x)
{
  const PetscInt each = n / mesh->N;
  PetscReal *own, *all, *mine;
  PetscMPIInt rank;

  PetscFunctionBegin;
  if (n <= 1) {
    PetscCall(ShareReals(mesh->comm, n, x));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCallMPI(MPI_Comm_rank(mesh->comm, &rank));
  PetscCall(PetscMalloc1(each * mesh->n + 1, &own));
  PetscCall(PetscMalloc2(rank ? 0 : mesh->N, &all, mesh->n, &mine));
  for (PetscInt k = 0; k < each; k++) {
    for (PetscInt e = 0; e < mesh->N && !rank; e++) all[e] = (*x)[each * e + k];
    PetscCall(SlipFaultScatterFirst(mesh, all, mine));
    for (PetscInt i = 0; i < mesh->n; i++) own[each * i + k] = mine[i];
  }
  PetscCall(PetscFree2(all, mine));
  PetscCall(PetscFree(*x));
  *x = own;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the records of -fault_stress_history on rank 0, and adds their terms. */
static PetscErrorCode AddHistory(SlipFaultLoads *loads)
{
  SlipFault fault = loads->fault;
  SlipStressRecord *records = NULL;
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscInt n = 0;
  PetscMPIInt rank;

  PetscFunctionBegin;
  if (!fault->options.text[FAULT_STRESS_HISTORY][0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (!rank) ierr = SlipLoadsReadHistory(fault, &n, &records);
  for (PetscInt k = 0; k < n && !ierr; k++) ierr = CheckRecord(&records[k], fault->mesh.N);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscCallMPI(MPI_Bcast(&n, 1, MPIU_INT, 0, fault->comm));
  if (rank) PetscCall(PetscCalloc1(n, &records));
  for (PetscInt k = 0; k < n; k++) {
    SlipStressRecord *r = &records[k];
    PetscInt size[4] = {r->rows, r->nshear, r->nnormal, r->name ? (PetscInt)strlen(r->name) + 1 : 0};

    PetscCallMPI(MPI_Bcast(size, 4, MPIU_INT, 0, fault->comm));
    r->rows = size[0];
    r->nshear = size[1];
    r->nnormal = size[2];
    if (rank) PetscCall(PetscMalloc1(size[3], &r->name));
    PetscCallMPI(MPI_Bcast(r->name, (PetscMPIInt)size[3], MPI_CHAR, 0, fault->comm));
    PetscCall(ShareReals(fault->comm, r->rows, &r->times));
    PetscCall(ShareReals(fault->comm, r->rows, &r->values));
    PetscCall(ShareField(&fault->mesh, r->nshear, &r->shear));
    PetscCall(ShareField(&fault->mesh, r->nnormal, &r->normal));
    PetscCall(AddRecord(loads, r, PETSC_TRUE));
    PetscCall(SlipStressRecordDestroy(r));
  }
  PetscCall(PetscFree(records));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the numbers of an option of tides, one for each of n, which are 0 where it is not given; n < 0: any number. */
static PetscErrorCode ReadTide(SlipFault fault, PetscInt id, PetscInt *n, PetscReal **x)
{
  const char *text = fault->options.text[id], *prefix = SlipFaultPrefix(fault);
  PetscBool good = PETSC_TRUE;
  PetscInt count = 0;

  PetscFunctionBegin;
  PetscCall(SlipFaultReadNumbers(fault, id, 0, NULL, &count, &good));
  PetscCheck(!text[0] || *n < 0 || count == *n, fault->comm, PETSC_ERR_ARG_WRONG,
             "-%sfault_%s is \"%s\", expected %lld numbers, one for each of -%sfault_tide_period", prefix,
             SlipFaultStrings[id].name, text, (long long)*n, prefix);
  if (*n < 0) *n = count;
  PetscCall(PetscCalloc1(*n, x));
  PetscCall(SlipFaultReadNumbers(fault, id, count, *x, &count, &good));
  for (PetscInt k = 0; k < *n && id == FAULT_TIDE_PERIOD; k++) good = good && (*x)[k] > 0 ? PETSC_TRUE : PETSC_FALSE;
  PetscCheck(good, fault->comm, PETSC_ERR_ARG_WRONG, "-%sfault_%s is \"%s\", expected numbers%s", prefix,
             SlipFaultStrings[id].name, text,
             id == FAULT_TIDE_PERIOD  ? " > 0 of s, or with " SLIP_TIME_UNITS " behind them, separated by commas"
             : id == FAULT_TIDE_PHASE ? " of degrees, separated by commas"
                                      : " of Pa, separated by commas");
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddTides(SlipFaultLoads *loads)
{
  SlipFault fault = loads->fault;
  const PetscInt c = fault->layout.components;
  PetscReal *period, *shear, *normal, *phase;
  PetscInt n = -1;

  PetscFunctionBegin;
  if (!fault->options.text[FAULT_TIDE_PERIOD][0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ReadTide(fault, FAULT_TIDE_PERIOD, &n, &period));
  PetscCall(ReadTide(fault, FAULT_TIDE_SHEAR, &n, &shear));
  PetscCall(ReadTide(fault, FAULT_TIDE_NORMAL, &n, &normal));
  PetscCall(ReadTide(fault, FAULT_TIDE_PHASE, &n, &phase));
  for (PetscInt k = 0; k < n; k++) {
    SlipLoadTerm *term;
    char name[96];

    (void)snprintf(name, sizeof(name), "tide of %.9g s and %g degrees", (double)period[k], (double)phase[k]);
    PetscCall(NewTerm(loads, name, &Tide, &term));
    term->period = period[k];
    term->phase = phase[k] / 360;
    if (shear[k] != 0) PetscCall(PetscCalloc1(c * loads->n + 1, &term->shear));
    if (normal[k] != 0) PetscCall(PetscMalloc1(loads->n + 1, &term->normal));
    for (PetscInt i = 0; i < loads->n; i++) {
      if (term->shear) PutShear(loads, term, i, &shear[k], NULL);
      if (term->normal) term->normal[i] = normal[k];
    }
    PetscCall(Measure(loads, term));
  }
  PetscCall(PetscFree(period));
  PetscCall(PetscFree(shear));
  PetscCall(PetscFree(normal));
  PetscCall(PetscFree(phase));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddNucleation(SlipFaultLoads *loads)
{
  SlipFault fault = loads->fault;
  PetscReal point[3] = {0, 0, 0}, number[3];
  SlipLoadTerm *term;

  PetscFunctionBegin;
  if (!fault->options.text[FAULT_NUCLEATION][0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultReadPoint(fault, FAULT_NUCLEATION, 3, "; then radius [m], amplitude [Pa] and duration [s]", point,
                               number));
  PetscCheck(number[0] > 0 && number[2] > 0, fault->comm, PETSC_ERR_ARG_WRONG,
             "-%sfault_nucleation %s has the radius %g m and the duration %g s, expected both to be > 0",
             SlipFaultPrefix(fault), fault->options.text[FAULT_NUCLEATION], (double)number[0], (double)number[2]);
  PetscCall(NewTerm(loads, "nucleation", &Rise, &term));
  term->duration = number[2];
  PetscCall(PetscCalloc1(fault->layout.components * loads->n + 1, &term->shear));
  for (PetscInt i = 0; i < loads->n; i++) {
    PetscReal r2 = 0, stress;
    SlipFaultCell cell;

    fault->mesh.kind->cell(&fault->mesh, SlipFaultMeshRow(&fault->mesh, i), &cell);
    for (int k = 0; k < 3; k++) r2 += PetscSqr(cell.centre[k] - point[k]);
    stress = r2 < PetscSqr(number[0]) ? number[1] * PetscExpReal(r2 / (r2 - PetscSqr(number[0]))) : 0;
    PutShear(loads, term, i, &stress, NULL);
  }
  PetscCall(Measure(loads, term));
  PetscCheck(
    term->largest[0] > 0 || number[1] == 0, fault->comm, PETSC_ERR_ARG_WRONG,
    "-%sfault_nucleation %s has no cell's centre within its radius of %g m: expected a point of the fault, or a "
    "larger radius",
    SlipFaultPrefix(fault), fault->options.text[FAULT_NUCLEATION], (double)number[0]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the times of all records once. */
static PetscErrorCode FindCorners(SlipFaultLoads *loads)
{
  PetscInt n = loads->rows;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < loads->nterms; k++) n += loads->terms[k].rows;
  PetscCall(PetscMalloc1(n + 1, &loads->corners));
  PetscCall(PetscArraycpy(loads->corners, loads->times, loads->rows));
  n = loads->rows;
  for (PetscInt k = 0; k < loads->nterms; k++) {
    PetscCall(PetscArraycpy(loads->corners + n, loads->terms[k].times, loads->terms[k].rows));
    n += loads->terms[k].rows;
  }
  PetscCall(PetscSortRemoveDupsReal(&n, loads->corners));
  loads->ncorners = n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates all terms; after the pore pressure. Collective. */
PetscErrorCode SlipLoadsTermsSetUp(SlipFaultLoads *loads)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < loads->ngiven; k++) {
    PetscCall(CheckRecord(&loads->given[k], loads->fault->mesh.N));
    PetscCall(AddRecord(loads, &loads->given[k], PETSC_FALSE));
  }
  PetscCall(AddHistory(loads));
  PetscCall(AddTides(loads));
  PetscCall(AddNucleation(loads));
  PetscCall(FindCorners(loads));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipLoadsTermsDestroy(SlipFaultLoads *loads)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < loads->nterms; k++) {
    SlipLoadTerm *term = &loads->terms[k];

    PetscCall(PetscFree(term->name));
    PetscCall(PetscFree2(term->times, term->values));
    PetscCall(PetscFree(term->shear));
    PetscCall(PetscFree(term->normal));
  }
  for (PetscInt k = 0; k < loads->ngiven; k++) PetscCall(SlipStressRecordDestroy(&loads->given[k]));
  PetscCall(PetscFree(loads->terms));
  PetscCall(PetscFree(loads->given));
  PetscCall(PetscFree(loads->corners));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CopyReals(PetscInt n, const PetscReal from[], PetscReal **to)
{
  PetscFunctionBegin;
  PetscCall(PetscMalloc1(PetscMax(n, 1), to));
  PetscCall(PetscArraycpy(*to, from, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultAddStress - adds a stress that changes in time, as a group of -fault_stress_history does

  Logically collective; before SlipFaultSetUp().

  Input Parameters:
+ fault   - the fault
. rows    - number of times
. time    - [rows] ascending [s]
. course - [rows] dimensionless factor of the stresses, linear between the times and constant before the first and
            after the last
. nshear  - 0, no shear stress; 1, one number; the number of cells; or twice that, along strike and up dip of each
. shear   - [nshear] shear stress at course 1 [Pa], along the rake unless it has two components; in the order of
            SlipFaultSetField()
. nnormal - 0, no normal stress; 1, one number; or the number of cells
- normal  - [nnormal] normal stress at course 1, positive in compression [Pa]

  Level: intermediate

  Notes:
  The fault copies the arrays, which must be the same on every rank. Stresses add up, and add to the initial traction,
  to its rate and to the normal stress; the normal stress less the pore pressure is at least 0.

  Errors: PETSC_ERR_ORDER after SlipFaultSetUp(); at SlipFaultSetUp() PETSC_ERR_FILE_UNEXPECTED for times that do not
  ascend, numbers that are not finite, and other sizes

.seealso: SlipFaultSetPressureFunction(), SlipFaultSetField(), SlipFaultSetReal()
@*/
PetscErrorCode SlipFaultAddStress(SlipFault fault, PetscInt rows, const PetscReal time[], const PetscReal course[],
                                  PetscInt nshear, const PetscReal shear[], PetscInt nnormal, const PetscReal normal[])
{
  SlipFaultLoads *loads;
  SlipStressRecord *record;
  char name[64];

  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscCheck(!fault->setup, fault->comm, PETSC_ERR_ORDER, "call SlipFaultAddStress() before SlipFaultSetUp()");
  loads = &fault->loads;
  PetscCall(PetscRealloc(sizeof(*loads->given) * (size_t)(loads->ngiven + 1), &loads->given));
  record = &loads->given[loads->ngiven++];
  *record = (SlipStressRecord){.rows = rows, .nshear = nshear, .nnormal = nnormal};
  (void)snprintf(name, sizeof(name), "stress %lld of SlipFaultAddStress()", (long long)loads->ngiven);
  PetscCall(PetscStrallocpy(name, &record->name));
  PetscCall(CopyReals(rows, time, &record->times));
  PetscCall(CopyReals(rows, course, &record->values));
  PetscCall(CopyReals(nshear, shear, &record->shear));
  PetscCall(CopyReals(nnormal, normal, &record->normal));
  PetscFunctionReturn(PETSC_SUCCESS);
}
