/* See runs.h. */
#include "runs.h"
#include "common/files.h"
#include <slipcompat.h>

#define MARGINAL (PetscReal)1.25
#define MOST_OF_USUAL 20 /* steps of a run that is worth ending */

/* ---- a run ---- */

PetscErrorCode RunSetController(TS ts, TSAdaptType type, PetscReal rtol)
{
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(SlipAdaptSetController(adapt, type));
  PetscCall(TSSetTolerances(ts, PETSC_DEFAULT, NULL, rtol, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RunSolve(TS ts, Vec w, PetscBool *solved)
{
  PetscErrorCode code;

  PetscFunctionBegin;
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  code = TSSolve(ts, w);
  PetscCall(PetscPopErrorHandler());
  *solved = code ? PETSC_FALSE : PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RunResultDestroy(RunResult *r)
{
  PetscFunctionBegin;
  PetscCall(TableClear(&r->course));
  PetscCall(PetscFree2(r->slip, r->passed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A cell passes its level where its slip, a cubic between two steps, first reaches it; faster ends of a bounded one
   would make it fall within. */
static PetscErrorCode FollowCells(RunWatch *watch, PetscInt step, PetscReal t, const PetscReal a[])
{
  const RunEpisode *e = watch->e;
  RunResult *r = watch->r;
  PetscReal row[3] = {t, 0, 0};

  PetscFunctionBegin;
  for (PetscInt i = 0; i < e->n; i++) {
    const PetscReal v = PetscAbsReal(a[3 * i]), s = a[3 * i + e->kind->column], h = t - watch->last;
    PetscReal *before = watch->before + 2 * i;

    row[1] += s / (PetscReal)e->n;
    row[2] += v / (PetscReal)e->n;
    if (step > 0 && e->level && r->passed[i] < 0 && s >= e->level[i]) {
      const PetscReal most = e->kind->bounded ? 3 * (s - before[0]) / h : PETSC_MAX_REAL;
      const SlipCourseNode node[2] = {{0, before[0], PetscMin(before[1], most)}, {h, s, PetscMin(v, most)}};

      r->passed[i] = watch->last + SlipCourseTime(2, node, e->level[i] / s);
    }
    before[0] = r->slip[i] = s;
    before[1] = v;
  }
  PetscCall(TableAdd(&r->course, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Follow(TS ts, PetscInt step, PetscReal t, Vec w, RunWatch *watch)
{
  const RunKind *kind = watch->e->kind;
  const PetscReal *a;
  PetscReal rate = 0;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < watch->e->n; i++) rate = PetscMax(rate, PetscAbsReal(a[3 * i]));
  if (step == 0) {
    watch->last = t;
    watch->rate = rate;
  }
  if (kind->column) PetscCall(FollowCells(watch, step, t, a));
  if (kind->follow) PetscCall((*kind->follow)(watch, ts, step, t, rate, a));
  PetscCall(VecRestoreArrayRead(w, &a));
  watch->last = t;
  watch->rate = rate;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A monitor cannot end a run: the next step begins before its word is heard. */
static PetscErrorCode AfterStep(TS ts)
{
  RunWatch *watch;
  PetscInt step;
  PetscReal t;
  Vec w;

  PetscFunctionBegin;
  PetscCall(TSGetApplicationContext(ts, &watch));
  PetscCall(TSGetStepNumber(ts, &step));
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(Follow(ts, step, t, w, watch));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The TS at the start. Options of its own, where the kind names a type. Without one friction that sticks takes TSBATHE,
   by which policies and classical controllers are compared. */
static PetscErrorCode Configure(const RunEpisode *e, TS ts, Vec w, PetscOptions *options)
{
  const TSType type = e->kind->type;

  PetscFunctionBegin;
  *options = NULL;
  if (type) {
    PetscCall(PetscOptionsCreate(options));
    PetscCall(PetscOptionsSetValue(*options, "-ts_type", type));
    PetscCall(PetscObjectSetOptions((PetscObject)ts, *options));
  } else
    PetscCall(TSSetType(ts, TSBATHE));
  PetscCall(SlipFaultConfigureTS(e->fault, ts));
  if (type) PetscCall(TSSetType(ts, type));
  PetscCall(SlipFaultSetInitialState(e->fault, w));
  if (e->start) {
    PetscCall(VecCopy(e->start, w));
    PetscCall(TSSetTime(ts, e->begin));
    PetscCall(TSSetTimeStep(ts, e->step));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* To the end of the request, by a TS that is configured. */
static PetscErrorCode Integrate(const RunRequest *request, TS ts, Vec w, RunWatch *watch)
{
  RunResult *r = watch->r;
  TSConvergedReason reason;
  SlipProducts before, after;
  PetscInt accepted, newton, linear;
  PetscReal t;

  PetscFunctionBegin;
  PetscCall(TSSetMaxTime(ts, request->end));
  PetscCall(TSSetMaxSteps(ts, request->most));
  PetscCall(TSSetErrorIfStepFails(ts, PETSC_FALSE));
  PetscCall(TSSetApplicationContext(ts, watch));
  PetscCall(TSSetPostStep(ts, AfterStep));
  PetscCall(Follow(ts, 0, watch->e->begin, w, watch));
  PetscCall(SlipProductsGet(&before));
  PetscCall(RunSolve(ts, w, &r->good));
  PetscCall(SlipProductsGet(&after));
  r->work = PetscMax(1, (PetscReal)1e6 * (after.cost - before.cost));
  PetscCall(TSBatheGetTotals(ts, &r->attempts, &accepted, &r->solves, &newton, &linear));
  r->rejected = r->attempts - accepted;
  r->attempts = r->solves;
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSGetConvergedReason(ts, &reason));
  if (reason != TS_CONVERGED_USER && t < request->end * (1 - 1e-9)) r->good = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RunIntegrate(RunEpisode *e, const RunRequest *request, RunResult *r)
{
  RunWatch watch = {.e = e, .r = r};
  PetscOptions options;
  TSAdapt adapt;
  Vec w;
  TS ts;

  PetscFunctionBegin;
  *r = (RunResult){.course = {.width = 3}};
  PetscCall(PetscCalloc2(e->kind->slips * e->n, &r->slip, e->n, &r->passed));
  for (PetscInt i = 0; i < e->n; i++) r->passed[i] = -1;
  PetscCall(PetscCalloc1(2 * e->n, &watch.before));
  PetscCall(SlipFaultCreateState(e->fault, &w));
  PetscCall(TSCreate(PETSC_COMM_SELF, &ts));
  PetscCall(Configure(e, ts, w, &options));
  PetscCall(TSGetAdapt(ts, &adapt));
  if (request->policy) {
    PetscCall(TSAdaptSetType(adapt, TSADAPTRL));
    PetscCall(TSAdaptRLSetPolicy(adapt, request->policy));
    PetscCall(TSAdaptRLSetAccuracy(adapt, request->setting));
    PetscCall(TSAdaptRLSetStrict(adapt, PETSC_TRUE));
  } else
    PetscCall(RunSetController(ts, request->type, request->setting));
  PetscCall(Integrate(request, ts, w, &watch));
  PetscCall(TSDestroy(&ts));
  PetscCall(PetscOptionsDestroy(&options));
  PetscCall(VecDestroy(&w));
  PetscCall(PetscFree(watch.before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- its errors ---- */

PetscReal RunFieldError(PetscInt n, const PetscReal slip[], PetscInt stride, const PetscReal reference[])
{
  PetscReal sum = 0, whole = 0;

  for (PetscInt i = 0; i < n; i++) {
    sum += PetscSqr(slip[i * stride] - reference[i]);
    whole += PetscSqr(reference[i]);
  }
  return PetscSqrtReal(sum / whole);
}

PetscReal RunPassedError(const RunEpisode *e, const RunResult *r, PetscReal span)
{
  const PetscReal *a = r->passed, *b = e->reference.passed;
  PetscReal sum = 0;
  PetscInt passed = 0;

  for (PetscInt i = 0; i < e->n; i++) {
    const PetscReal over = e->reference.slip[i] / e->level[i];

    if (over > 1 / MARGINAL && over < MARGINAL) continue;
    if (b[i] >= 0) passed++;
    if (a[i] < 0 && b[i] < 0) continue;
    sum += a[i] < 0 || b[i] < 0 ? 1 : PetscMin(1, PetscSqr((a[i] - b[i]) / span));
  }
  return PetscSqrtReal(sum / (PetscReal)PetscMax(passed, 1));
}

PetscErrorCode RunEpisodeRun(RunEpisode *e, SlipPolicy policy, TSAdaptType type, PetscReal setting,
                             EpisodeResult *result)
{
  const RunKind *kind = e->kind;
  const RunRequest request = {policy, type, setting, .end = e->end,
                              .most = policy || !kind->most ? e->most : kind->most};
  RunResult r;

  PetscFunctionBegin;
  PetscCall(RunIntegrate(e, &request, &r));
  *result = (EpisodeResult){
    .done = 1, .solves = r.solves, .attempts = r.attempts, .failures = r.rejected, .work = r.work, .error = -1};
  for (PetscInt i = 0; i < SLIP_NUM_ERRORS; i++) result->errors[i] = 1;
  if (r.good) PetscCall((*kind->compare)(e, &r, result->errors, &result->error));
  if (result->error < 0) {
    result->error = kind->worst;
    result->done = 0;
  }
  PetscCall(RunResultDestroy(&r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- an episode ---- */

static PetscErrorCode Clear(RunEpisode *e)
{
  PetscFunctionBegin;
  PetscCall(RunResultDestroy(&e->reference));
  PetscCall(PetscFree(e->level));
  PetscCall(VecDestroy(&e->start));
  PetscCall(SlipFaultDestroy(&e->fault));
  e->most = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RunEpisodeCreate(const RunKind *kind, const Family *family, PetscInt larger, uint64_t seed,
                                RunEpisode **episode)
{
  PetscBool good = PETSC_FALSE;
  RunEpisode *e;
  Random random;

  PetscFunctionBegin;
  PetscCall(PetscCalloc(kind->size, episode));
  e = *episode;
  e->kind = kind;
  e->family = family;
  e->larger = larger;
  e->seed = seed;
  RandomSeed(&random, seed);
  for (PetscInt tries = 0; !good; tries++) {
    if (family) {
      char text[ERROR_TEXT] = "";
      PetscErrorCode code;

      PetscCheck(tries < FAMILY_TRIES, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
                 "-train_family %s: of %d faults drawn none %s", family->file, FAMILY_TRIES, kind->expected);
      PetscCall(PetscPushErrorHandler(ErrorCapture, text));
      code = RunDrawOfFamily(e, &random);
      PetscCall(PetscPopErrorHandler());
      PetscCheck(!code, PETSC_COMM_SELF, code, "-train_family %s: a fault of it cannot be made: %s", family->file,
                 text);
    } else
      PetscCall((*kind->draw)(e, &random));
    PetscCall((*kind->judge)(e, &good));
    if (!e->most) e->most = MOST_OF_USUAL * e->usual;
    if (!good) PetscCall(Clear(e));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RunEpisodeDestroy(RunEpisode **e)
{
  PetscFunctionBegin;
  if (*e) PetscCall(Clear(*e));
  PetscCall(PetscFree(*e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- of a problem for CMA-ES ---- */

PetscErrorCode RunsCreate(const CMAOptions *o, uint64_t seed, PetscInt side, void **episode)
{
  (void)side;
  return RunEpisodeCreate(o->problem->cma->runs, o->family, 1, seed, (RunEpisode **)episode);
}

PetscErrorCode RunsDestroy(void **episode)
{
  return RunEpisodeDestroy((RunEpisode **)episode);
}

PetscErrorCode RunsRun(void *episode, SlipPolicy policy, PetscReal accuracy, EpisodeResult *r)
{
  RunEpisode *e = (RunEpisode *)episode;
  const RunKind *kind = e->kind;

  PetscFunctionBegin;
  PetscCall(RunEpisodeRun(e, policy, NULL, accuracy, r));
  r->cost = kind->lost;
  if (r->done == 1 && kind->lost > 0)
    r->cost =
      PetscLogReal(r->work / e->work) +
      kind->steep * PetscLogReal(PetscClipInterval(r->error / (kind->free * accuracy), (PetscReal)1, kind->worst));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RunsClassical(void *episode, TSAdaptType type, PetscReal rtol, EpisodeResult *r)
{
  return RunEpisodeRun((RunEpisode *)episode, NULL, type, rtol, r);
}
