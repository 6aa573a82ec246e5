/* One cell of the matrix: its runs, timed, with their errors; a run that fails is a result too. */
#define _POSIX_C_SOURCE 200809L /* clock_gettime() */
#include "evaluate.h"
#include <slipcompat.h>
#include "common/files.h"
#include "environment/environment.h"
#include <petsctime.h>
#include <time.h>

/* What the monitors of a run fill. */
typedef struct {
  const ProblemCase *c;
  void *model;
  EvaluateResult *r;
  PetscInt failed;                     /* attempts that failed in a row */
  PetscInt max_failures, max_attempts; /* guard rail of rl; limit of evaluate */
  PetscBool learned, profile;
} Recorder;

static PetscErrorCode Record(Recorder *rec, PetscReal t, Vec w, Vec r)
{
  PetscReal row[EVALUATE_COLUMNS] = {t}, *profile;

  PetscFunctionBegin;
  PetscCall(rec->c->problem->evaluation->observe(rec->c, rec->model, t, w, r, row + 1));
  PetscCall(TableAdd(&rec->r->series, row));
  if (!rec->profile) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(rec->c->mesh + 1, &profile));
  profile[0] = t;
  PetscCall(rec->c->problem->evaluation->profiles(rec->c, rec->model, w, profile + 1));
  PetscCall(TableAdd(&rec->r->profile, profile));
  PetscCall(PetscFree(profile));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TSBatheAttemptFn */
static PetscErrorCode Watch(TS ts, const SlipAttempt *a, Vec w, void *ctx)
{
  Recorder *rec = (Recorder *)ctx;
  EvaluateResult *r = rec->r;
  const PetscReal row[EVALUATE_ATTEMPT] = {a->time, a->dt, a->accepted, a->error, a->converged};
  Vec reaction;

  PetscFunctionBegin;
  PetscCall(TableAdd(&r->steps, row));
  /* A learned controller steps by itself but for two guard rails: halved steps after max_failures failures in a
     row, and converged attempts that a ceiling of the error rejected. */
  if (rec->learned && (rec->failed >= rec->max_failures || (a->converged && !a->accepted))) r->guarded++;
  rec->failed = a->converged ? 0 : rec->failed + 1;
  r->failures += a->converged ? 0 : 1;
  if (++r->attempts >= rec->max_attempts) {
    PetscCall(
      PetscSNPrintf(r->reason, sizeof(r->reason), "%" PetscInt_FMT " attempts (-evaluate_max_attempts)", r->attempts));
    PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  }
  if (!a->accepted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSBatheGetReaction(ts, &reaction));
  PetscCall(Record(rec, a->time + a->dt, w, reaction));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Configure(const EvaluateCell *cell, TS ts)
{
  TSAdapt adapt;
  PetscReal end, rtol;
  PetscBool learned;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(SlipAdaptSetController(adapt, cell->controller)); /* a fault's may be pi with another filter */
  if (cell->policy) PetscCall(TSAdaptRLSetPolicyFile(adapt, cell->policy->file));
  PetscCall(TSAdaptRLSetStrict(adapt, PETSC_TRUE)); /* it is the policy that is evaluated */
  PetscCall(SlipCheckSolverOptions(ts));
  PetscCall(TSSetFromOptions(ts));
  PetscCall(TSBatheCheckOptions(ts));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTRL, &learned));
  PetscCheck(learned || cell->accuracy <= 0, PetscObjectComm((PetscObject)adapt), PETSC_ERR_SUP,
             "this controller knows no accuracy (-evaluate_accuracies)");
  if (cell->accuracy > 0) PetscCall(TSAdaptRLSetAccuracy(adapt, cell->accuracy));
  PetscCall(TSBatheSetReactionType(ts, cell->reaction));
  PetscCall(TSBatheSetError(ts, cell->error));
  PetscCall(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
  PetscCall(EnvSetTolerances(ts, cell->tolerance * rtol, cell->tolerance));
  if (cell->steps) {
    PetscCall(TSGetMaxTime(ts, &end));
    PetscCall(TSSetTimeStep(ts, end / (PetscReal)cell->steps));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Wall time, and processor time of all processes [s]: the second hardly depends on what else a machine does. */
typedef struct {
  PetscReal wall, cpu;
} Times;

/* TSSolve() and what became of it; rec is NULL for a repetition, which is only timed. */
static PetscErrorCode Solve(TS ts, Vec w, Recorder *rec, Times *times)
{
  PetscLogDouble begin, end;
  SlipProducts before, now;
  struct timespec cpu[2] = {{0, 0}, {0, 0}}; /* PetscGetCPUTime() has steps of 10 ms */
  PetscReal time, last;
  MPI_Comm comm;

  PetscFunctionBegin;
  PetscCall(PetscObjectGetComm((PetscObject)ts, &comm));
  if (rec) PetscCall(Record(rec, 0, w, NULL));
  if (rec) PetscCall(TSBatheMonitorSet(ts, Watch, rec, NULL));
  PetscCallMPI(MPI_Barrier(comm));
  PetscCall(PetscTime(&begin));
  PetscCall(SlipProductsGet(&before));
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu[0]);
  PetscCall(TSSolve(ts, w));
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu[1]);
  PetscCall(PetscTime(&end));
  times->wall = (PetscReal)(end - begin);
  times->cpu =
    (PetscReal)(cpu[1].tv_sec - cpu[0].tv_sec) + (PetscReal)1e-9 * (PetscReal)(cpu[1].tv_nsec - cpu[0].tv_nsec);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &times->wall, 1, MPIU_REAL, MPIU_MAX, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &times->cpu, 1, MPIU_REAL, MPIU_SUM, comm));
  if (!rec) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipProductsGet(&now));
  rec->r->products = (SlipProducts){now.k - before.k, now.h - before.h, now.pc - before.pc, now.all - before.all,
                                    now.cost - before.cost};
  PetscCall(
    TSBatheGetTotals(ts, &rec->r->attempts, &rec->r->accepted, &rec->r->solves, &rec->r->newton, &rec->r->linear));
  PetscCall(TSGetTime(ts, &time));
  PetscCall(TSGetMaxTime(ts, &last));
  rec->r->converged = time >= last * (1 - 1e-9) ? PETSC_TRUE : PETSC_FALSE;
  if (!rec->r->converged && !rec->r->reason[0])
    PetscCall(
      PetscSNPrintf(rec->r->reason, sizeof(rec->r->reason), "ended at %g s of %g s", (double)time, (double)last));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RunOnce(MPI_Comm comm, const ProblemCase *c, void *model, const EvaluateCell *cell, Recorder *rec,
                              Times *times)
{
  TS ts;
  Vec w;

  PetscFunctionBegin;
  PetscCall(c->problem->evaluation->start(comm, c, model, &ts, &w));
  PetscCall(Configure(cell, ts));
  PetscCall(Solve(ts, w, rec, times));
  PetscCall(VecDestroy(&w));
  PetscCall(TSDestroy(&ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static int Ascending(const void *a, const void *b)
{
  const PetscReal x = *(const PetscReal *)a, y = *(const PetscReal *)b;

  return (x > y) - (x < y);
}

/* The recorded run. What a failing one has allocated is not freed: PETSc's objects are in no state to be destroyed
   then. */
static PetscErrorCode RunRecorded(const EvaluateOptions *o, MPI_Comm comm, const ProblemCase *c, void *model,
                                  const EvaluateCell *cell, EvaluateResult *r, Times *times)
{
  Recorder rec = {.c = c, .model = model, .r = r, .max_failures = 3, .max_attempts = o->max_attempts};
  char failure[ERROR_TEXT] = "";
  PetscErrorCode ierr;
  PetscInt failed;

  PetscFunctionBegin;
  r->series.width = 1 + c->problem->evaluation->ncolumns;
  r->steps.width = EVALUATE_ATTEMPT;
  r->profile.width = 1 + c->mesh;
  rec.learned = cell->policy ? PETSC_TRUE : PETSC_FALSE;
  rec.profile = c->problem->evaluation->profiles && cell->tolerance == 1 ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-ts_adapt_rl_max_failures", &rec.max_failures, NULL));
  PetscCall(PetscPushErrorHandler(ErrorCapture, failure)); /* a failing run must not end the program */
  ierr = RunOnce(comm, c, model, cell, &rec, times);
  PetscCall(PetscPopErrorHandler());
  failed = ierr ? 1 : 0;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPIU_INT, MPI_MAX, comm));
  if (!failed) PetscFunctionReturn(PETSC_SUCCESS);
  r->converged = PETSC_FALSE;
  PetscCall(PetscStrncpy(r->reason, failure[0] ? failure : "another process failed", sizeof(r->reason)));
  for (PetscInt i = 0; i < r->steps.n; i++) r->accepted += r->steps.data[i * EVALUATE_ATTEMPT + 2] > 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- errors of a run against a reference: numbers only ---- */

/* Row of the reference at time t, linear between its rows; *at is where the last search ended. Times ascend. */
static void Interpolate(const Table *ref, PetscReal t, PetscInt *at, PetscReal row[])
{
  const PetscInt w = ref->width;
  const PetscReal *a, *b;
  PetscReal s;

  while (*at < ref->n - 2 && ref->data[(*at + 1) * w] < t) ++*at;
  a = &ref->data[*at * w];
  b = a + w;
  s = b[0] > a[0] ? (t - a[0]) / (b[0] - a[0]) : 1;
  s = PetscClipInterval(s, (PetscReal)0, (PetscReal)1);
  for (PetscInt k = 1; k < w; k++) row[k - 1] = (1 - s) * a[k] + s * b[k];
}

static PetscReal Norm2(PetscInt n, const PetscReal a[], const PetscReal b[])
{
  PetscReal sum = 0;

  for (PetscInt k = 0; k < n; k++) sum += PetscSqr(a[k] - (b ? b[k] : 0));
  return sum;
}

/*
  Errors at the ends of the accepted steps, e = |y - y_ref| over the state columns:
    final   e at the last step (signed for a single state), max  the largest e, both over |y_ref| at the end (relative
            problems; the largest |y_ref| where the state decays, that is for several states)
    l2      (int e^2 dt)^1/2 over (int |y_ref|^2 dt)^1/2, or over the root of the duration where errors are absolute;
            trapezoidal rule over the accepted steps
    rate    largest error of the rate column over its largest reference value
*/
PetscErrorCode EvaluateErrors(const Evaluation *p, void *model, const Table *ref, const Table *series,
                              EvaluateResult *r)
{
  const PetscInt n = p->nstates, w = series->width;
  PetscReal exact[EVALUATE_COLUMNS], errors = 0, sizes = 0, largest = 0, size = 0, rate = 0, rate_size = 0, e2 = 0,
                                     s2 = 0;
  PetscReal before_e2 = 0, before_s2 = 0, scale;
  PetscInt at = 0;

  PetscFunctionBegin;
  PetscCheck(series->n > 0, PETSC_COMM_SELF, PETSC_ERR_PLIB, "a run without rows");
  for (PetscInt i = 0; i < series->n; i++) {
    const PetscReal *row = &series->data[i * w], dt = i ? row[0] - row[-w] : 0;

    if (p->exact)
      PetscCall(p->exact(model, row[0], exact));
    else
      Interpolate(ref, row[0], &at, exact);
    e2 = Norm2(n, row + 1, exact);
    s2 = Norm2(n, exact, NULL);
    errors += 0.5 * dt * (before_e2 + e2);
    sizes += 0.5 * dt * (before_s2 + s2);
    largest = PetscMax(largest, e2);
    if (p->rate >= 0) rate = PetscMax(rate, PetscAbsReal(row[1 + p->rate] - exact[p->rate]));
    before_e2 = e2;
    before_s2 = s2;
  }
  for (PetscInt i = 0; i < ref->n; i++) {
    const PetscReal *row = &ref->data[i * ref->width + 1];

    size = PetscMax(size, Norm2(n, row, NULL));
    if (p->rate >= 0) rate_size = PetscMax(rate_size, PetscAbsReal(row[p->rate]));
  }
  scale = p->relative ? PetscSqrtReal(n > 1 ? size : s2) : 1;
  r->final = series->data[(series->n - 1) * w + 1];
  r->final_error = (n == 1 ? r->final - exact[0] : PetscSqrtReal(e2)) / scale;
  r->max_error = PetscSqrtReal(largest) / scale;
  r->l2_error = PetscSqrtReal(errors / (p->relative ? sizes : series->data[(series->n - 1) * w]));
  r->rate_error = p->rate >= 0 ? rate / rate_size : NAN;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- cells and references ---- */

PetscErrorCode EvaluateRunCell(const EvaluateOptions *o, MPI_Comm comm, const ProblemCase *c, void *model,
                               const EvaluateCell *cell, const EvaluateReference *ref, EvaluateResult *r)
{
  const PetscReal setup = r->wall_setup;
  PetscReal wall[EVALUATE_MAX];
  Times times = {0, 0};

  PetscFunctionBegin;
  PetscCall(PetscMemzero(r, sizeof(*r)));
  r->wall_setup = setup;
  r->final = r->final_error = r->max_error = r->l2_error = r->rate_error = NAN;
  PetscCall(RunRecorded(o, comm, c, model, cell, r, &times));
  wall[0] = times.wall;
  r->cpu = times.cpu;
  for (r->runs = 1; r->converged && r->runs < o->repetitions; r->runs++) {
    PetscCall(RunOnce(comm, c, model, cell, NULL, &times));
    wall[r->runs] = times.wall;
    r->cpu = PetscMin(r->cpu, times.cpu);
  }
  qsort(wall, (size_t)r->runs, sizeof(wall[0]), Ascending);
  r->wall = 0.5 * (wall[r->runs / 2] + wall[(r->runs - 1) / 2]);
  r->wall_min = wall[0];
  r->wall_max = wall[r->runs - 1];
  if (r->converged) PetscCall(EvaluateErrors(c->problem->evaluation, model, &ref->series, &r->series, r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EvaluateResultClear(EvaluateResult *r)
{
  PetscFunctionBegin;
  PetscCall(TableClear(&r->series));
  PetscCall(TableClear(&r->steps));
  PetscCall(TableClear(&r->profile));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EvaluateReferenceClear(EvaluateReference *r)
{
  PetscFunctionBegin;
  PetscCall(TableClear(&r->series));
  PetscCall(TableClear(&r->profile));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define EXACT_ROWS 5000 /* of an exact solution, for plots */

/* An even number: half as many make the run that it is compared with. */
PetscInt EvaluateReferenceSteps(const EvaluateOptions *o, const ProblemCase *c)
{
  const PetscInt steps = o->reference_steps > 0 ? o->reference_steps : c->problem->evaluation->reference / o->coarser;

  return 2 * (PetscMax(steps, 2) / 2);
}

/*
  The reference of a case: constant steps, the trapezoidal reaction. Such a run meets no tolerance and no controller,
  and its error falls with the square of the step while the sliding set does not change, at least in proportion to it
  where it does; so the difference to a run with half as many steps, recorded with it, is at least as large as the
  error that is left.
*/
PetscErrorCode EvaluateRunReference(const EvaluateOptions *o, MPI_Comm comm, const ProblemCase *c, void *model,
                                    EvaluateReference *ref)
{
  EvaluateCell cell = {
    .controller = TSADAPTNONE, .error = TSBATHE_ERROR_NONE, .reaction = TSBATHE_REACTION_TRAPEZOIDAL, .tolerance = 1};
  EvaluateOptions limits = *o;
  EvaluateResult fine = {0}, half = {0};
  PetscReal row[EVALUATE_COLUMNS], end;
  Times times;
  TS ts;
  Vec w;

  PetscFunctionBegin;
  if (c->problem->evaluation->exact) {
    PetscCall(c->problem->evaluation->start(comm, c, model, &ts, &w));
    PetscCall(TSSetFromOptions(ts));
    PetscCall(TSGetMaxTime(ts, &end));
    ref->series.width = 1 + c->problem->evaluation->ncolumns;
    for (PetscInt i = 0; i <= EXACT_ROWS; i++) {
      row[0] = end * (PetscReal)i / EXACT_ROWS;
      PetscCall(c->problem->evaluation->exact(model, row[0], row + 1));
      PetscCall(TableAdd(&ref->series, row));
    }
    PetscCall(VecDestroy(&w));
    PetscCall(TSDestroy(&ts));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  limits.max_attempts = PETSC_MAX_INT;
  ref->steps = cell.steps = EvaluateReferenceSteps(o, c);
  PetscCall(RunRecorded(&limits, comm, c, model, &cell, &fine, &times));
  ref->wall = times.wall;
  PetscCheck(fine.converged, comm, PETSC_ERR_NOT_CONVERGED,
             "the reference of %s with %" PetscInt_FMT " constant steps failed: %s", c->name, cell.steps, fine.reason);
  cell.steps /= 2;
  PetscCall(RunRecorded(&limits, comm, c, model, &cell, &half, &times));
  PetscCheck(half.converged, comm, PETSC_ERR_NOT_CONVERGED,
             "the reference of %s with %" PetscInt_FMT " constant steps failed: %s", c->name, cell.steps, half.reason);
  PetscCall(EvaluateErrors(c->problem->evaluation, model, &fine.series, &half.series, &half));
  ref->self_final = half.final_error;
  ref->self_max = half.max_error;
  ref->wall += times.wall;
  ref->series = fine.series;
  ref->profile = fine.profile;
  PetscCall(TableClear(&fine.steps));
  PetscCall(EvaluateResultClear(&half));
  PetscFunctionReturn(PETSC_SUCCESS);
}
