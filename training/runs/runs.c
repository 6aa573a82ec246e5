/* See runs.h. */
#include "runs.h"
#include "common/files.h"
#include "environment/libraryrun.h"
#include <slipcompat.h>

#define MARGINAL (PetscReal)1.25
#define MOST_OF_USUAL 20 /* steps of a run that is worth ending */

/* ---- a run ---- */

const SlipCourseNode *RunNodes(const RunResult *r)
{
  return (const SlipCourseNode *)r->course.data;
}

static PetscErrorCode ResultCreate(const RunEpisode *e, RunResult *r)
{
  PetscFunctionBegin;
  *r = (RunResult){.course = {.width = 3}};
  PetscCall(PetscCalloc2(e->kind->slips * e->n, &r->slip, e->n, &r->passed));
  for (PetscInt i = 0; i < e->n; i++) r->passed[i] = -1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RunResultDestroy(RunResult *r)
{
  PetscFunctionBegin;
  PetscCall(TableClear(&r->course));
  PetscCall(PetscFree2(r->slip, r->passed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* When the slip of a cell, a cubic between two steps, first reaches the level [s] after the first of them; faster ends
   of a bounded one would make it fall within */
static PetscReal Crossing(const PetscReal before[2], PetscReal s, PetscReal v, PetscReal h, PetscReal level,
                          PetscBool bounded)
{
  const PetscReal most = bounded ? 3 * (s - before[0]) / h : PETSC_MAX_REAL;
  const SlipCourseNode node[2] = {{0, before[0], PetscMin(before[1], most)}, {h, s, PetscMin(v, most)}};

  return SlipCourseTime(2, node, level / s);
}

static PetscErrorCode FollowCells(RunWatch *watch, PetscInt step, PetscReal t, const PetscReal a[])
{
  const RunEpisode *e = watch->e;
  const PetscInt column = e->kind->column;
  RunResult *r = watch->r;
  PetscReal row[3] = {t, 0, 0};

  PetscFunctionBegin;
  for (PetscInt i = 0; i < e->n; i++) {
    const PetscReal v = PetscAbsReal(a[3 * i]), s = a[3 * i + column];
    PetscReal *before = watch->before + 2 * i;

    row[1] += s / (PetscReal)e->n;
    row[2] += v / (PetscReal)e->n;
    if (step > 0 && e->level && r->passed[i] < 0 && s >= e->level[i])
      r->passed[i] = watch->last + Crossing(before, s, v, t - watch->last, e->level[i], e->kind->bounded);
    before[0] = r->slip[i] = s;
    before[1] = v;
  }
  PetscCall(TableAdd(&r->course, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

typedef struct {
  RunWatch watch;
  const RunRequest *request;
} Under;

static PetscErrorCode Follow(TS ts, PetscInt step, PetscReal t, Vec w, Under *under)
{
  RunWatch *watch = &under->watch;
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

PetscErrorCode RunCountEvent(const RunWatch *watch, TS ts, PetscInt *count)
{
  PetscFunctionBegin;
  if (++*count == watch->events) PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A monitor cannot end a run: the next step begins before its word is heard. */
static PetscErrorCode AfterStep(TS ts)
{
  Under *under;
  PetscInt step;
  PetscReal t;
  Vec w;

  PetscFunctionBegin;
  PetscCall(TSGetApplicationContext(ts, &under));
  PetscCall(TSGetStepNumber(ts, &step));
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(Follow(ts, step, t, w, under));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TYPE/CONTROLLER names a method of time steps as well, of PETSc's rk by its own name: adams/pi, 5dp/basic. of: that
   of the kind, or NULL */
static PetscErrorCode FindMethod(const RunRequest *request, const TSType of, char method[32], TSAdaptType *controller)
{
  char *slash = NULL;

  PetscFunctionBegin;
  *controller = request->type;
  PetscCall(PetscStrncpy(method, of ? of : "", 32));
  if (request->type) PetscCall(PetscStrchr(request->type, '/', &slash));
  if (!slash) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrncpy(method, request->type, (size_t)PetscMin(slash - request->type + 1, 32)));
  *controller = slash + 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* At its start. Options of its own, where a method is named. Without one friction that sticks takes TSBATHE, by which
   policies and classical controllers are compared; smooth friction is an explicit problem. */
static PetscErrorCode Configure(const RunEpisode *e, const char method[], TS ts, Vec w, PetscOptions *options)
{
  const PetscBool rk = method[0] >= '0' && method[0] <= '9' ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  *options = NULL;
  if (method[0]) {
    PetscCall(PetscOptionsCreate(options));
    PetscCall(PetscOptionsSetValue(*options, "-ts_type", rk ? TSRK : method));
    PetscCall(PetscObjectSetOptions((PetscObject)ts, *options));
  } else
    PetscCall(TSSetType(ts, TSBATHE));
  PetscCall(SlipFaultConfigureTS(e->fault, ts));
  if (method[0]) PetscCall(TSSetType(ts, rk ? TSRK : method));
  if (rk) PetscCall(TSRKSetType(ts, method));
  PetscCall(SlipFaultSetInitialState(e->fault, w));
  if (e->start) {
    PetscCall(VecCopy(e->start, w));
    PetscCall(TSSetTime(ts, e->begin));
    PetscCall(TSSetTimeStep(ts, e->step));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves: of explicit steps products with the stiffness */
static PetscErrorCode Count(TS ts, RunResult *r)
{
  PetscInt accepted, newton, linear;
  PetscBool bathe;

  PetscFunctionBegin;
  PetscCall(TSBatheIs(ts, &bathe));
  if (bathe) {
    PetscCall(TSBatheGetTotals(ts, &r->attempts, &accepted, &r->solves, &newton, &linear));
    r->rejected = r->attempts - accepted;
    r->attempts = r->solves;
  } else {
    PetscCall(TSGetStepNumber(ts, &accepted));
    PetscCall(TSGetStepRejections(ts, &r->rejected));
    r->attempts = accepted + r->rejected;
    r->solves = 2 * accepted + r->rejected;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* To the end of the request, by a TS that is configured */
static PetscErrorCode Integrate(const RunRequest *request, TS ts, Vec w, Under *under)
{
  RunEpisode *e = under->watch.e;
  RunResult *r = under->watch.r;
  TSConvergedReason reason;
  SlipProducts before, after;
  PetscReal t;

  PetscFunctionBegin;
  PetscCall(TSSetMaxTime(ts, request->end));
  PetscCall(TSSetMaxSteps(ts, request->most));
  PetscCall(TSSetErrorIfStepFails(ts, PETSC_FALSE));
  PetscCall(TSSetApplicationContext(ts, under));
  PetscCall(TSSetPostStep(ts, AfterStep));
  PetscCall(Follow(ts, 0, e->begin, w, under));
  PetscCall(SlipProductsGet(&before));
  PetscCall(RunSolve(ts, w, &r->good));
  PetscCall(SlipProductsGet(&after));
  r->work = PetscMax(1, (PetscReal)1e6 * (after.cost - before.cost));
  PetscCall(Count(ts, r));
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSGetConvergedReason(ts, &reason));
  if (!e->kind->early && reason != TS_CONVERGED_USER && t < request->end * (1 - 1e-9)) r->good = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A method that is named in the request but not for this fault is a run that does not end. */
PetscErrorCode RunIntegrate(RunEpisode *e, const RunRequest *request, RunResult *r)
{
  Under under = {.watch = {.e = e, .r = r, .events = request->events}, .request = request};
  PetscErrorCode code = PETSC_SUCCESS;
  TSAdaptType controller;
  PetscOptions options;
  char method[32];
  PetscBool named;
  Vec w;
  TS ts;

  PetscFunctionBegin;
  PetscCall(ResultCreate(e, r));
  PetscCall(PetscCalloc1(2 * e->n, &under.watch.before));
  PetscCall(SlipFaultCreateState(e->fault, &w));
  PetscCall(TSCreate(PETSC_COMM_SELF, &ts));
  PetscCall(FindMethod(request, e->kind->type, method, &controller));
  named = controller != request->type ? PETSC_TRUE : PETSC_FALSE;
  if (named) PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  code = Configure(e, method, ts, w, &options);
  if (named) PetscCall(PetscPopErrorHandler());
  if (!named) PetscCall(code);
  PetscCheck(
    !code || code == PETSC_ERR_ARG_INCOMP, PETSC_COMM_SELF, code,
    "%s names no method and controller: expected a -ts_type, or one of rk's by its name, before the slash, as in "
    "adams/pi or 5dp/basic",
    request->type);
  if (!code) {
    PetscCall(RunSetController(ts, request->policy, request->setting, controller, request->setting));
    PetscCall(Integrate(request, ts, w, &under));
  }
  PetscCall(TSDestroy(&ts));
  PetscCall(PetscOptionsDestroy(&options));
  PetscCall(VecDestroy(&w));
  PetscCall(PetscFree(under.watch.before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- its errors ---- */

PetscReal RunFieldError(PetscInt n, const PetscReal slip[], const PetscReal reference[])
{
  PetscReal sum = 0, whole = 0;

  for (PetscInt i = 0; i < n; i++) {
    sum += PetscSqr(slip[i] - reference[i]);
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
  const RunRequest request = {
    policy, type, setting, .end = e->end, .most = policy || !kind->most ? e->most : kind->most, .events = kind->events};
  RunResult r;

  PetscFunctionBegin;
  PetscCall(RunIntegrate(e, &request, &r));
  *result = (EpisodeResult){.done = 1,
                            .solves = r.solves,
                            .attempts = r.attempts,
                            .failures = r.rejected,
                            .usual = (PetscReal)e->usual,
                            .work = r.work,
                            .error = -1};
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

static PetscErrorCode DrawOfFamily(RunEpisode *e, Random *random, PetscInt tries)
{
  char text[ERROR_TEXT] = "";
  PetscErrorCode code;

  PetscFunctionBegin;
  PetscCheck(tries < FAMILY_TRIES, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "-train_family %s: of %d faults drawn none %s",
             e->family->file, FAMILY_TRIES, e->kind->expected);
  PetscCall(PetscPushErrorHandler(ErrorCapture, text));
  code = RunDrawOfFamily(e, random);
  PetscCall(PetscPopErrorHandler());
  PetscCheck(!code, PETSC_COMM_SELF, code, "-train_family %s: a fault of it cannot be made: %s", e->family->file, text);
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
    if (family)
      PetscCall(DrawOfFamily(e, &random, tries));
    else
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
  return RunEpisodeCreate(o->problem->cma->runs, (const Family *)o->family, 1, seed, (RunEpisode **)episode);
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
      PetscLogReal(kind->work ? r->work / e->work : (PetscReal)r->solves / r->usual) +
      kind->steep * PetscLogReal(PetscClipInterval(r->error / (kind->free * accuracy), (PetscReal)1, kind->worst));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RunsClassical(void *episode, TSAdaptType type, PetscReal rtol, EpisodeResult *r)
{
  return RunEpisodeRun((RunEpisode *)episode, NULL, type, rtol, r);
}

PetscErrorCode RunsSay(const CMAScore *score, char text[], size_t len)
{
  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(text, len, "cost %7.4f  dial kept %3.0f %%  solves %6.1f  error/dial %6.3f",
                          (double)score->cost, 100 * (double)score->within, (double)score->solves,
                          (double)score->error));
  PetscFunctionReturn(PETSC_SUCCESS);
}
