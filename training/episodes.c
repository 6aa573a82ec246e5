/* Episodes, see episodes.h. */
#include "episodes.h"
#include <slipstep/private/slipcompat.h>

#define REFERENCE_STEP (1. / 60) /* constant step of the reference [T*] */
#define THINNING 4               /* every so many of its steps are kept */
#define MIN_SLIP 0.2 /* a drawn fault whose final slip is below this share of what its drop implies is drawn again */

static PetscErrorCode FaultCreate(const FaultDraw *d, SlipFault *fault)
{
  PetscFunctionBegin;
  PetscCall(SlipFaultCreate(PETSC_COMM_SELF, fault));
  for (PetscInt i = 0; i < d->nreal; ++i) PetscCall(SlipFaultSetReal(*fault, d->name[i], d->value[i]));
  for (PetscInt f = 0; f < DRAW_FIELDS; ++f)
    PetscCall(SlipFaultSetField(*fault, EpisodeFieldNames[f], d->n, d->field[f]));
  PetscCall(SlipFaultSetUp(*fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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

static PetscErrorCode CourseAppend(Course *c, PetscReal t, PetscReal slip)
{
  PetscFunctionBegin;
  if (c->n == c->capacity) {
    c->capacity = c->capacity ? 2 * c->capacity : 256;
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)c->capacity, &c->t));
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)c->capacity, &c->slip));
  }
  c->t[c->n] = t;
  c->slip[c->n++] = slip;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Slip of the reference at time t. */
static PetscReal CourseSlip(const Course *c, PetscReal t)
{
  PetscInt low = 0, high = c->n - 1;

  if (t <= c->t[0]) return c->slip[0];
  if (t >= c->t[high]) return c->slip[high];
  while (high - low > 1) {
    const PetscInt mid = (low + high) / 2;

    if (c->t[mid] <= t)
      low = mid;
    else
      high = mid;
  }
  return c->slip[low] + (c->slip[high] - c->slip[low]) * (t - c->t[low]) / (c->t[high] - c->t[low]);
}

/* The reference's monitor. */
static PetscErrorCode Record(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  Course *c = &((Episode *)ctx)->course;
  const PetscReal t = attempt->time + attempt->dt;
  PetscReal rate, slip, max_rate;

  PetscFunctionBegin;
  PetscCall(Means(w, &rate, &slip, &max_rate));
  c->peak = PetscMax(c->peak, rate);
  if (attempt->step % THINNING == 0 || max_rate == 0) PetscCall(CourseAppend(c, t, slip));
  if (max_rate == 0 && slip > 0) {
    c->rest = t;
    PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Measure(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  Episode *e = (Episode *)ctx;
  const PetscReal t = attempt->time + attempt->dt;
  PetscReal rate, slip, max_rate, gap;

  PetscFunctionBegin;
  if (--e->attempts_left <= 0) PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  if (!attempt->accepted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Means(w, &rate, &slip, &max_rate));
  e->peak = PetscMax(e->peak, rate);
  gap = PetscAbsReal(slip - CourseSlip(&e->course, t));
  e->history += 0.5 * (gap + e->last_gap) * (t - e->last_t);
  e->last_gap = gap;
  e->last_t = t;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode MakeTS(Episode *e, TSBatheAttemptFn monitor, TS *ts)
{
  PetscFunctionBegin;
  PetscCall(TSCreate(PETSC_COMM_SELF, ts));
  PetscCall(SlipFaultConfigureTS(e->fault, *ts));
  PetscCall(TSBatheAddAttemptMonitor(*ts, monitor, e));
  PetscCall(TSSetSolution(*ts, e->w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Small constant steps until the fault rests, or for limit T*. */
static PetscErrorCode Reference(Episode *e, PetscReal limit)
{
  TSAdapt adapt;
  TS ts;

  PetscFunctionBegin;
  e->course.n = 0;
  e->course.rest = -1;
  e->course.peak = 0;
  PetscCall(CourseAppend(&e->course, 0, 0));
  PetscCall(VecCopy(e->start, e->w));
  PetscCall(MakeTS(e, Record, &ts));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTNONE));
  PetscCall(TSBatheSetError(ts, TSBATHE_ERROR_NONE));
  PetscCall(TSSetTimeStep(ts, REFERENCE_STEP * e->tstar));
  PetscCall(TSSetMaxTime(ts, limit * e->tstar));
  PetscCall(TSSolve(ts, e->w));
  PetscCall(TSDestroy(&ts));
  e->slip = e->course.slip[e->course.n - 1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Release(Episode *e)
{
  PetscFunctionBegin;
  PetscCall(TSDestroy(&e->ts));
  PetscCall(VecDestroy(&e->w));
  PetscCall(VecDestroy(&e->start));
  PetscCall(SlipFaultDestroy(&e->fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One draw: useful when the reference came to rest having slipped. */
static PetscErrorCode TryDraw(Episode *e, const FaultDraw *d, PetscBool *good)
{
  PetscReal log_drop, slip_scale;
  PetscBool known;
  PetscErrorCode (*observe)(TS, const char[], PetscReal *, PetscBool *);
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(FaultCreate(d, &e->fault));
  PetscCall(SlipFaultGetTimeScale(e->fault, &e->tstar));
  PetscCall(SlipFaultCreateState(e->fault, &e->w));
  PetscCall(VecDuplicate(e->w, &e->start));
  PetscCall(SlipFaultSetInitialState(e->fault, e->start));
  PetscCall(Reference(e, d->limit));
  PetscCall(MakeTS(e, Measure, &e->ts));
  PetscCall(PetscObjectQueryFunction((PetscObject)e->ts, "SlipObserve_C", &observe));
  PetscCall((*observe)(e->ts, "log_drop", &log_drop, &known));
  PetscCall((*observe)(e->ts, "progress", &slip_scale, &known)); /* of the reference's end, which w still is */
  *good = e->course.rest > 0 && slip_scale > MIN_SLIP ? PETSC_TRUE : PETSC_FALSE;
  e->tmax = d->margin * e->course.rest;
  PetscCall(TSSetMaxTime(e->ts, e->tmax));
  PetscCall(TSSetMaxSteps(e->ts, EPISODE_MAX_STEPS));
  PetscCall(TSGetAdapt(e->ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTRL));
  if (!*good) PetscCall(Release(e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EpisodeCreate(uint64_t seed, PetscInt side, Episode **episode)
{
  PetscBool good = PETSC_FALSE;
  FaultDraw *d;
  Random random;
  Episode *e;

  PetscFunctionBegin;
  PetscCheck(side >= 1 && side * side <= EPISODE_MAX_ELEMENTS, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "Episodes of up to %" PetscInt_FMT " elements along a side, expected 1 to 12", side);
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
  PetscCall(Release(*episode));
  PetscCall(PetscFree((*episode)->course.t));
  PetscCall(PetscFree((*episode)->course.slip));
  PetscCall(PetscFree(*episode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Back to the start; nothing of an earlier run is left. */
static PetscErrorCode Rewind(Episode *e, PetscReal accuracy)
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
  e->history = e->peak = e->last_t = e->last_gap = 0;
  e->attempts_left = 2 * EPISODE_MAX_STEPS;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Result(Episode *e, EpisodeResult *r)
{
  PetscInt attempts, accepted, newton, linear;
  PetscReal t, rate, slip, max_rate;

  PetscFunctionBegin;
  PetscCall(TSBatheGetTotals(e->ts, &attempts, &accepted, &r->solves, &newton, &linear));
  PetscCall(TSGetTime(e->ts, &t));
  PetscCall(Means(e->w, &rate, &slip, &max_rate));
  r->failures = attempts - accepted;
  r->slip_error = PetscAbsReal(slip / e->slip - 1);
  r->history_error = e->history / (e->tmax * e->slip);
  r->rate_error = PetscAbsReal(e->peak / e->course.peak - 1);
  r->done = t >= e->tmax * (1 - 1e-10) ? 1 : t / e->tmax;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EpisodeRun(Episode *e, SlipPolicy policy, PetscReal accuracy, EpisodeResult *result)
{
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(Rewind(e, accuracy));
  PetscCall(TSGetAdapt(e->ts, &adapt));
  PetscCall(TSAdaptRLSetPolicy(adapt, policy));
  PetscCall(TSSolve(e->ts, e->w));
  PetscCall(Result(e, result));
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
  const char *const *names;
  PetscReal dt[2];
  PetscInt n;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(Rewind(e, accuracy));
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
#define WORST_PENALTY 10
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
