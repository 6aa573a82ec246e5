/* Episodes, see episodes.h. */
#include "episodes.h"
#include "environment/plainrows.h"
#include <math.h>
#include <slipcompat.h>

#define REFERENCE_STEP (1. / 60) /* constant step of the reference [T*] */
#define THINNING 4               /* every so many of its steps are kept */
#define MIN_SLIP 0.2 /* a drawn fault whose final slip is below this share of what its drop implies is drawn again */

static PetscErrorCode Means(Vec w, PetscReal *rate, PetscReal *slip, PetscReal *max_rate)
{
  const PetscScalar *a;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(w, &n));
  PetscCall(VecGetArrayRead(w, &a));
  *rate = *slip = *max_rate = 0;
  for (PetscInt i = 0; i < n; i += 3) {
    const PetscReal v = PetscAbsScalar(a[i]);

    *rate += v;
    *slip += PetscRealPart(a[i + 2]);
    *max_rate = PetscMax(*max_rate, v);
  }
  *rate *= 3. / (PetscReal)n;
  *slip *= 3. / (PetscReal)n;
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Slip of the reference at time t. */
static PetscReal CourseSlip(const Course *c, PetscReal t)
{
  PetscInt low = 0, high = c->path.n - 1;
  const PetscReal *a = c->path.data, *b;

  if (t <= a[0]) return a[1];
  if (t >= a[2 * high]) return a[2 * high + 1];
  while (high - low > 1) {
    const PetscInt mid = (low + high) / 2;

    if (a[2 * mid] <= t)
      low = mid;
    else
      high = mid;
  }
  a += 2 * low;
  b = a + 2;
  return a[1] + (b[1] - a[1]) * (t - a[0]) / (b[0] - a[0]);
}

/* The run has mean rate [m/s] and slip [m] at time t. */
static void Follow(Episode *e, PetscReal t, PetscReal rate, PetscReal slip)
{
  const PetscReal gap = PetscAbsReal(slip - CourseSlip(&e->course, t));

  e->peak = PetscMax(e->peak, rate);
  e->history += 0.5 * (gap + e->last_gap) * (t - e->last_t);
  e->last_gap = gap;
  e->last_t = t;
  e->last_slip = slip;
}

PetscErrorCode EpisodeFollow(Episode *e, PetscReal t, Vec w)
{
  PetscReal rate = 0, slip = 0, max_rate = 0;

  PetscFunctionBegin;
  PetscCall(Means(w, &rate, &slip, &max_rate));
  Follow(e, t, rate, slip);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Measure(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  Episode *e = (Episode *)ctx;

  PetscFunctionBegin;
  if (--e->attempts_left <= 0) PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  if (!attempt->accepted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(EpisodeFollow(e, attempt->time + attempt->dt, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void PlainMeans(const PlainFault *p, PetscReal *rate, PetscReal *slip, PetscReal *max_rate)
{
  *rate = *slip = *max_rate = 0;
  for (PetscInt i = 0; i < p->n; ++i) {
    *rate += PetscAbsReal(p->v[i]) / (PetscReal)p->n;
    *slip += p->s[i] / (PetscReal)p->n;
    *max_rate = PetscMax(*max_rate, PetscAbsReal(p->v[i]));
  }
}

/* PlainWatchFn */
static void MeasurePlain(const PlainFault *p, double time, void *ctx)
{
  PetscReal rate = 0, slip = 0, max_rate = 0;

  PlainMeans(p, &rate, &slip, &max_rate);
  Follow((Episode *)ctx, time, rate, slip);
}

/* Small constant steps until the fault rests, or for limit T*. */
static PetscErrorCode Reference(Episode *e, PetscReal limit)
{
  Course *c = &e->course;
  PetscReal rate, max_rate, row[2] = {0, 0};
  const PetscInt steps = (PetscInt)(limit / REFERENCE_STEP);

  PetscFunctionBegin;
  c->path.width = 2;
  c->path.n = 0;
  c->rest = -1;
  c->peak = 0;
  PetscCall(TableAdd(&c->path, row));
  PlainFaultSetState(&e->plain, e->plain_start);
  for (PetscInt k = 1; k <= steps && c->rest < 0; ++k) {
    row[0] = (PetscReal)k * REFERENCE_STEP * e->tstar;
    if (!PlainFaultAttempt(&e->plain, REFERENCE_STEP * e->tstar)) break;
    PlainFaultAccept(&e->plain);
    PlainMeans(&e->plain, &rate, &row[1], &max_rate);
    c->peak = PetscMax(c->peak, rate);
    if (max_rate == 0 && row[1] > 0) c->rest = row[0];
    if (k % THINNING == 0 || c->rest > 0) PetscCall(TableAdd(&c->path, row));
  }
  e->slip = row[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Release(Episode *e)
{
  PetscFunctionBegin;
  PetscCall(PlainFaultDestroy(&e->plain));
  PetscCall(TSDestroy(&e->ts));
  PetscCall(VecDestroy(&e->w));
  PetscCall(VecDestroy(&e->start));
  PetscCall(PetscFree(e->plain_start));
  PetscCall(SlipFaultDestroy(&e->fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One draw: useful when the reference came to rest having slipped. */
static PetscErrorCode TryDraw(Episode *e, const FaultDraw *d, PetscBool *good)
{
  const PetscScalar *w;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(SlipFaultCreate(PETSC_COMM_SELF, &e->fault));
  PetscCall(SlipFaultSetString(e->fault, "stiffness_scaling", FAULT_SCALING));
  for (PetscInt i = 0; i < d->nreal; ++i) PetscCall(SlipFaultSetReal(e->fault, d->name[i], d->value[i]));
  for (PetscInt f = 0; f < DRAW_FIELDS; ++f)
    PetscCall(SlipFaultSetField(e->fault, EpisodeFieldNames[f], d->n, d->field[f]));
  PetscCall(SlipFaultSetUp(e->fault));
  PetscCall(SlipFaultGetTimeScale(e->fault, &e->tstar));
  PetscCall(SlipFaultCreateState(e->fault, &e->w));
  PetscCall(VecDuplicate(e->w, &e->start));
  PetscCall(SlipFaultSetInitialState(e->fault, e->start));
  /* without objects */
  PetscCall(PlainFaultCreate(e->fault, e->start, &e->plain));
  PetscCall(PetscMalloc1(3 * d->n, &e->plain_start));
  PetscCall(VecGetArrayRead(e->start, &w));
  for (PetscInt i = 0; i < 3 * d->n; ++i) e->plain_start[i] = (double)PetscRealPart(w[i]);
  PetscCall(VecRestoreArrayRead(e->start, &w));
  PetscCall(Reference(e, d->limit));
  *good = e->course.rest > 0 && e->slip > MIN_SLIP * e->plain.known.drop_slip ? PETSC_TRUE : PETSC_FALSE;
  if (!*good) {
    PetscCall(Release(e));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  /* with them */
  e->tmax = d->margin * e->course.rest;
  PetscCall(TSCreate(PETSC_COMM_SELF, &e->ts));
  PetscCall(SlipFaultConfigureTS(e->fault, e->ts));
  PetscCall(TSBatheMonitorSet(e->ts, Measure, e, NULL));
  PetscCall(TSSetSolution(e->ts, e->w));
  PetscCall(TSSetMaxTime(e->ts, e->tmax));
  PetscCall(TSSetMaxSteps(e->ts, EPISODE_MAX_STEPS));
  PetscCall(TSGetAdapt(e->ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTRL));
  PetscCall(TSAdaptRLSetStrict(adapt, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EpisodeCreate(uint64_t seed, PetscInt side, Episode **episode)
{
  PetscBool good = PETSC_FALSE;
  FaultDraw *d;
  Random random;
  Episode *e;

  PetscFunctionBegin;
  PetscCheck(side >= 1 && side * side <= EPISODE_MAX_CELLS, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "Episodes of up to %" PetscInt_FMT " cells along a side, expected 1 to 12", side);
  PetscCall(PetscNew(&e));
  PetscCall(PetscNew(&d));
  RandomSeed(&random, seed);
  while (!good) {
    FaultDrawAtRandom(&random, side, d);
    PetscCall(TryDraw(e, d, &good));
  }
  PetscCall(PetscFree(d));
  *episode = e;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EpisodeDestroy(Episode **episode)
{
  PetscFunctionBegin;
  if (!*episode) PetscFunctionReturn(PETSC_SUCCESS);
  if ((*episode)->small)
    PetscCall(EpisodeSmallDestroy(&(*episode)->small));
  else
    PetscCall(Release(*episode));
  PetscCall(TableClear(&(*episode)->course.path));
  PetscCall(PetscFree(*episode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Nothing of an earlier run is left. */
static void Forget(Episode *e)
{
  e->history = e->peak = e->last_t = e->last_gap = e->last_slip = 0;
  e->attempts_left = 2 * EPISODE_MAX_STEPS;
}

PetscErrorCode EpisodeRewind(Episode *e, PetscReal accuracy)
{
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(VecCopy(e->start, e->w));
  PetscCall(TSSetTime(e->ts, 0));
  PetscCall(TSSetStepNumber(e->ts, 0));
  PetscCall(TSSetTimeStep(e->ts, 0.01 * e->tstar));
  PetscCall(TSSetConvergedReason(e->ts, TS_CONVERGED_ITERATING));
  PetscCall(TSRestartStep(e->ts));
  PetscCall(TSGetAdapt(e->ts, &adapt));
  PetscCall(TSAdaptRLSetAccuracy(adapt, accuracy));
  Forget(e);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void EpisodeConclude(const Episode *e, PetscInt solves, PetscInt accepted, EpisodeResult *r)
{
  r->solves = solves;
  r->failures = solves - accepted;
  r->slip_error = PetscAbsReal(e->last_slip / e->slip - 1);
  r->history_error = e->history / (e->tmax * e->slip);
  r->rate_error = PetscAbsReal(e->peak / e->course.peak - 1);
  r->done = e->last_t >= e->tmax * (1 - 1e-10) ? 1 : e->last_t / e->tmax;
}

PetscErrorCode EpisodeRunLibrary(Episode *e, SlipPolicy policy, PetscReal accuracy, EpisodeResult *result)
{
  PetscInt attempts, accepted, solves, newton, linear;
  TSAdapt adapt;

  PetscFunctionBegin;
  if (e->small) {
    PetscCall(EpisodeSmallRunLibrary(e->small, policy, accuracy, NULL, NULL, result));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(EpisodeRewind(e, accuracy));
  PetscCall(TSGetAdapt(e->ts, &adapt));
  PetscCall(TSAdaptRLSetPolicy(adapt, policy));
  PetscCall(TSSolve(e->ts, e->w));
  PetscCall(TSBatheGetTotals(e->ts, &attempts, &accepted, &solves, &newton, &linear));
  EpisodeConclude(e, solves, accepted, result);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EpisodeRun(Episode *e, SlipPolicy policy, PetscReal accuracy, EpisodeResult *result)
{
  PlainTotals totals;
  SlipObserved row[PLAIN_MAX_ROWS];
  PetscInt n;
  PetscBool known;

  PetscFunctionBegin;
  if (e->small) {
    PetscCall(EpisodeSmallRun(e->small, policy, accuracy, NULL, NULL, result));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PlainRowsFind(policy, NULL, &n, row, &known));
  if (!known) {
    PetscCall(EpisodeRunLibrary(e, policy, accuracy, result));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  Forget(e);
  PlainFaultSetState(&e->plain, e->plain_start);
  PetscCall(PlainRun(&e->plain, policy, accuracy, e->tmax, EPISODE_MAX_STEPS, MeasurePlain, e, &totals));
  EpisodeConclude(e, totals.attempts, totals.accepted, result);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a run that is watched ---- */

typedef struct {
  Episode *episode;
  SlipPolicy policy;
  EpisodeWatchFn fn;
  void *ctx;
} Watch;

static PetscErrorCode WatchingActor(TSAdapt adapt, TS ts, PetscInt n, const PetscReal obs[], const SlipAttempt *last,
                                    PetscBool guarded, PetscReal *h, void *ctx)
{
  Watch *watch = (Watch *)ctx;
  PetscReal action;

  PetscFunctionBegin;
  (void)adapt, (void)ts, (void)last, (void)guarded;
  watch->fn(n, obs, watch->ctx);
  PetscCall(SlipPolicyEvaluate(watch->policy, obs, &action, NULL));
  PetscCall(SlipPolicyActionToStep(watch->policy, action, watch->episode->tstar, watch->episode->tmax, h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EpisodeWatch(Episode *e, SlipPolicy policy, PetscReal accuracy, EpisodeWatchFn fn, void *ctx)
{
  Watch watch = {e, policy, fn, ctx};
  EpisodeResult result;
  const char *const *names;
  PetscReal dt[2];
  PetscInt n;
  TSAdapt adapt;

  PetscFunctionBegin;
  if (e->small) {
    PetscCall(EpisodeSmallRun(e->small, policy, accuracy, fn, ctx, &result));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(EpisodeRewind(e, accuracy));
  PetscCall(TSGetAdapt(e->ts, &adapt));
  PetscCall(SlipPolicyGetObservations(policy, &n, &names));
  PetscCall(SlipPolicyGetStepBounds(policy, e->tstar, e->tmax, &dt[0], &dt[1]));
  PetscCall(TSAdaptRLSetActor(adapt, n, names, dt[0], dt[1], WatchingActor, &watch));
  PetscCall(TSSolve(e->ts, e->w));
  PetscCall(TSAdaptRLSetActor(adapt, 0, NULL, 0, 0, NULL, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- cost ---- */

#define HISTORY_WEIGHT 0.3
#define HISTORY_FLOOR 0.02 /* what the history may be off at any dial */
#define HISTORY_DIALS 2    /* and per dial */
#define RATE_WEIGHT 0.2
#define RATE_FLOOR 0.1
#define RATE_DIALS 3
#define WORST_PENALTY 20
#define UNFINISHED 4

PetscReal EpisodePenalty(PetscReal x)
{
  const PetscReal over = PetscMax(0, x - 0.5) / 0.5;

  if (PetscIsInfOrNanReal(x)) return WORST_PENALTY;
  return PetscMin(x < 1 ? over * over : 1 + 3 * PetscLogReal(x), (PetscReal)WORST_PENALTY);
}

PetscReal EpisodeCost(const EpisodeResult *r, PetscReal accuracy)
{
  return PetscLogReal((PetscReal)(r->solves + 1)) + EpisodePenalty(r->slip_error / accuracy) +
         HISTORY_WEIGHT * EpisodePenalty(r->history_error / (HISTORY_FLOOR + HISTORY_DIALS * accuracy)) +
         RATE_WEIGHT * EpisodePenalty(r->rate_error / (RATE_FLOOR + RATE_DIALS * accuracy)) +
         (r->done < 1 ? UNFINISHED * (2 - r->done) : 0);
}
