/* Episodes, see episodes.h. */
#include "episodes.h"
#include <math.h>
#include <slipcompat.h>

#define REFERENCE_STEP 0.01 /* of the reference, over the time in which the fault swings or grows */
#define FIRST_STEP 0.01     /* of a controller that does not choose it, SlipFaultConfigureTS()'s [T*] */
#define THINNING 10         /* every so many of its steps are kept */
#define MIN_SLIP 0.2        /* a drawn fault that slips less than this share of what its drop implies is drawn again */

#define CLASSICAL_ATTEMPTS 100000

/* What is drawn for runs whose steps may be explicit: products of an implicit solve of the longest explicit step, and
   that step of a fault of many cells, of which the few drawn ones are a picture, below that of the drawn ones */
#define LEAST_COST 8
#define MOST_COST 100
#define COARSE_SHARE 0.5
#define FINEST 30
#define COSTS_STREAM 19

/* The run has a mean slip [m] and rate [m/s] at time t. A step may come more than once. */
static PetscErrorCode Follow(Episode *e, PetscReal t, PetscReal slip, PetscReal rate)
{
  const PetscReal row[COURSE_WIDTH] = {t, slip, rate};

  PetscFunctionBegin;
  if (CourseNodes(&e->run)[e->run.n - 1].time >= t) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TableAdd(&e->run, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool AtEnd(const Episode *e, PetscReal t)
{
  return t >= e->tmax * (1 - 1e-10) ? PETSC_TRUE : PETSC_FALSE;
}

PetscErrorCode EpisodeFollow(Episode *e, PetscReal t, Vec w)
{
  const PetscScalar *a;
  PetscReal rate = 0, slip = 0;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(w, &n));
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < n; i += 3) {
    rate += 3 * PetscAbsScalar(a[i]) / (PetscReal)n;
    slip += 3 * PetscRealPart(a[i + 2]) / (PetscReal)n;
  }
  if (AtEnd(e, t)) e->field_error = RunFieldError(e->plain.n, a + 2, 3, e->field);
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCall(Follow(e, t, slip, rate));
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

/* Of the state [m], [m/s] */
static void Means(const PlainFault *p, PetscReal *slip, PetscReal *rate)
{
  *rate = *slip = 0;
  for (PetscInt i = 0; i < p->n; ++i) {
    *rate += PetscAbsReal(p->v[i]) / (PetscReal)p->n;
    *slip += p->s[i] / (PetscReal)p->n;
  }
}

/* PlainWatchFn */
static PetscErrorCode MeasurePlain(const PlainFault *p, double time, void *ctx)
{
  Episode *e = (Episode *)ctx;
  PetscReal rate, slip;

  PetscFunctionBegin;
  Means(p, &slip, &rate);
  if (AtEnd(e, time)) e->field_error = RunFieldError(p->n, p->s, 1, e->field);
  PetscCall(Follow(e, time, slip, rate));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Small constant steps until the fault rests, or to the end [s]; as far as can be told from the start, short enough for
   the swing and for the growth of the critical displacement, which is slower than the root of weakening less
   stiffness */
static PetscErrorCode Reference(Episode *e, PetscReal end)
{
  PlainFault *p = &e->plain;
  const PetscReal stiffness = p->known.critical_stiffness,
                  growth = PetscSqrtReal(PetscMax(p->known.critical_weakening - stiffness, 0)),
                  dt = REFERENCE_STEP * (1 / (PetscSqrtReal(stiffness) + growth / 2));
  PetscReal row[COURSE_WIDTH] = {0, 0, 0};

  PetscFunctionBegin;
  e->reference.n = 0;
  e->rest = -1;
  PetscCall(TableAdd(&e->reference, row));
  PlainFaultSetState(p, e->plain_start);
  for (PetscInt k = 1; (PetscReal)k * dt <= end && e->rest < 0; ++k) {
    row[0] = (PetscReal)k * dt;
    if (!PlainFaultAttempt(p, dt)) break;
    PlainFaultAccept(p);
    Means(p, &row[1], &row[2]);
    if (row[2] == 0 && row[1] > 0) e->rest = row[0];
    if (k % THINNING == 0 || e->rest > 0) PetscCall(TableAdd(&e->reference, row));
  }
  e->slip = row[1];
  PetscCall(PetscArraycpy(e->field, p->s, p->n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Release(Episode *e)
{
  PetscFunctionBegin;
  PetscCall(PlainFaultDestroy(&e->plain));
  PetscCall(TSDestroy(&e->ts));
  PetscCall(VecDestroy(&e->w));
  PetscCall(VecDestroy(&e->start));
  PetscCall(PetscFree2(e->plain_start, e->field));
  PetscCall(SlipFaultDestroy(&e->fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Its fields: of a family factors of the scalars; slip: mean of friction_slip [m], where the draw has its own */
static PetscErrorCode SetFields(SlipFault fault, const FaultDraw *d, PetscReal slip)
{
  PetscReal field[EPISODE_MAX_CELLS], factor = 1, gradient, top, width;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetReal(fault, "normal_stress_gradient", &gradient));
  PetscCall(SlipFaultGetReal(fault, "depth_top", &top));
  PetscCall(SlipFaultGetReal(fault, "length_z", &width));
  for (PetscInt f = 0; f < DRAW_FIELDS; ++f) {
    if (d->weakening > 0 && f == DRAW_FRICTION_SLIP)
      factor = slip;
    else if (!d->of_family)
      factor = 1;
    else if (d->spread[f] == 0)
      continue; /* uniform, or with depth */
    else
      PetscCall(SlipFaultGetReal(fault, EpisodeFieldNames[f], &factor));
    for (PetscInt i = 0; i < d->n; ++i) {
      const PetscReal depth = top + ((PetscReal)(i / d->nx) + (PetscReal)0.5) * width / (PetscReal)d->nz;

      field[i] = factor * d->field[f][i];
      if (f == DRAW_NORMAL_STRESS && d->of_family) field[i] += gradient * depth * d->field[f][i];
    }
    PetscCall(SlipFaultSetField(fault, EpisodeFieldNames[f], d->n, field));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The fault, and its start with and without objects */
static PetscErrorCode MakeFault(Episode *e, const FaultDraw *d, PetscReal slip)
{
  const PetscScalar *w;

  PetscFunctionBegin;
  PetscCall(SlipFaultCreate(PETSC_COMM_SELF, &e->fault));
  for (PetscInt i = 0; i < d->nstring; ++i) PetscCall(FamilySetWord(e->fault, d->string[i], d->text[i]));
  for (PetscInt i = 0; i < d->nreal; ++i) PetscCall(SlipFaultSetReal(e->fault, d->name[i], d->value[i]));
  PetscCall(SetFields(e->fault, d, slip));
  PetscCall(SlipFaultSetUp(e->fault));
  PetscCall(SlipFaultGetTimeScale(e->fault, &e->tstar));
  PetscCall(SlipFaultCreateState(e->fault, &e->w));
  PetscCall(VecDuplicate(e->w, &e->start));
  PetscCall(SlipFaultSetInitialState(e->fault, e->start));
  PetscCall(PlainFaultCreate(e->fault, e->start, &e->plain));
  PetscCall(PetscMalloc2(3 * e->plain.n, &e->plain_start, e->plain.n, &e->field));
  PetscCall(VecGetArrayRead(e->start, &w));
  for (PetscInt i = 0; i < 3 * e->plain.n; ++i) e->plain_start[i] = (double)PetscRealPart(w[i]);
  PetscCall(VecRestoreArrayRead(e->start, &w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One draw: useful when the reference came to rest having slipped. The weakening goes with 1/friction_slip. */
static PetscErrorCode TryDraw(Episode *e, const FaultDraw *d, PetscBool *good)
{
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(MakeFault(e, d, 1));
  if (d->weakening > 0) {
    const SlipFaultNumbers *f = &e->plain.known;
    const PetscReal slip = f->critical_weakening / (d->weakening * f->critical_stiffness);

    PetscCall(Release(e));
    PetscCall(MakeFault(e, d, slip));
  }
  if (e->plain.known.critical_stiffness > 0)
    PetscCall(Reference(e, d->limit / PetscSqrtReal(e->plain.known.critical_stiffness)));
  *good = e->rest > 0 && e->slip > MIN_SLIP * e->plain.known.drop_slip ? PETSC_TRUE : PETSC_FALSE;
  if (!*good) {
    PetscCall(Release(e));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  /* with them */
  e->tmax = d->margin * e->rest;
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

PetscErrorCode EpisodeCreate(const Family *family, uint64_t seed, PetscInt side, Episode **episode)
{
  PetscBool good = PETSC_FALSE;
  PetscInt tries = 0;
  FaultDraw *d;
  Random random;
  Episode *e;

  PetscFunctionBegin;
  PetscCheck(side >= 1 && side * side <= EPISODE_MAX_CELLS, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "Episodes of up to %" PetscInt_FMT " cells along a side, expected 1 to 12", side);
  PetscCall(PetscNew(&e));
  e->measure = SlipMeasures;
  e->reference.width = e->run.width = COURSE_WIDTH;
  PetscCall(PetscNew(&d));
  RandomSeed(&random, seed);
  while (!good) {
    if (family)
      PetscCall(FaultDrawOfFamily(family, &random, side, d));
    else
      FaultDrawAtRandom(&random, side, d);
    PetscCheck(
      !family || tries++ < FAMILY_TRIES, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
      "-train_family %s: of %d faults drawn none slips a fifth of what its weakening implies and comes to rest",
      family->file, FAMILY_TRIES);
    PetscCall(TryDraw(e, d, &good));
  }
  PetscCall(PetscFree(d));
  *episode = e;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What explicit and implicit steps take is drawn apart, so that the fault is that of the same seed elsewhere. Explicit
   steps without objects know no other damping than that of waves, and no friction that depends on the rate. */
PetscErrorCode EpisodeCreateProducts(const Family *family, uint64_t seed, PetscInt side, Episode **episode)
{
  PetscReal limit, zeta;
  Episode *e;
  char viscosity[16];
  Random random;

  PetscFunctionBegin;
  PetscCall(EpisodeCreate(family, seed, side, &e));
  *episode = e;
  PetscCall(SlipFaultGetString(e->fault, "viscosity", viscosity, sizeof(viscosity)));
  PetscCall(TSBatheGetLongestStep(e->ts, &limit));
  PetscCall(SlipFaultGetReal(e->fault, "damping_ratio", &zeta));
  e->omega = limit > 0 && limit < PETSC_MAX_REAL && strcmp(viscosity, "none") && strcmp(viscosity, "radiation") &&
                 !e->plain.friction.law->by_rate
               ? SLIP_LAG_MARGIN * SlipLagLimit(zeta, 1) / limit
               : 0;
  RandomSeed(&random, RandomStreamHashed(0, COSTS_STREAM, (PetscInt64)seed));
  SlipMethodSetUp(&e->costs);
  e->costs.solve = RandomLog(&random, LEAST_COST, MOST_COST) / SlipMethodSolve(&e->costs, 1);
  e->fineness = RandomUniform(&random) < COARSE_SHARE ? 1 : RandomLog(&random, 1, FINEST);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EpisodeDestroy(void **episode)
{
  Episode *e = (Episode *)*episode;

  PetscFunctionBegin;
  if (!e) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Release(e));
  PetscCall(TableClear(&e->reference));
  PetscCall(TableClear(&e->run));
  PetscCall(PetscFree(*episode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Nothing of an earlier run is left. */
static PetscErrorCode Forget(Episode *e)
{
  const PetscReal start[COURSE_WIDTH] = {0, 0, 0};

  PetscFunctionBegin;
  e->run.n = 0;
  PetscCall(TableAdd(&e->run, start));
  e->field_error = 0;
  e->attempts_left = 2 * EPISODE_MAX_STEPS;
  e->failures = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EpisodeRewind(Episode *e, PetscReal accuracy)
{
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(VecCopy(e->start, e->w));
  PetscCall(TSSetTime(e->ts, e->begin));
  PetscCall(TSSetStepNumber(e->ts, 0));
  PetscCall(TSSetTimeStep(e->ts, FIRST_STEP * e->tstar));
  PetscCall(TSSetConvergedReason(e->ts, TS_CONVERGED_ITERATING));
  PetscCall(TSRestartStep(e->ts));
  PetscCall(TSGetAdapt(e->ts, &adapt));
  PetscCall(TSAdaptRLSetAccuracy(adapt, accuracy));
  PetscCall(Forget(e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void EpisodeConclude(const Episode *e, PetscInt solves, PetscInt accepted, EpisodeResult *r)
{
  const PetscReal end = CourseNodes(&e->run)[e->run.n - 1].time;

  *r = (EpisodeResult){.solves = solves, .attempts = solves, .failures = solves - accepted};
  SlipCourseCompare(e->run.n, CourseNodes(&e->run), e->reference.n, CourseNodes(&e->reference), r->errors);
  r->errors[SLIP_ERROR_FIELD] = e->field_error;
  r->error = SlipMeasureOf(e->measure, r->errors);
  r->done = AtEnd(e, end) ? 1 : end / e->tmax;
}

PetscErrorCode EpisodeSolve(Episode *e, SlipPolicy policy, PetscReal accuracy, PetscInt *accepted, PetscInt *solves)
{
  PetscInt attempts, newton, linear;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(EpisodeRewind(e, accuracy));
  PetscCall(TSGetAdapt(e->ts, &adapt));
  PetscCall(TSAdaptRLSetPolicy(adapt, policy));
  PetscCall(TSSolve(e->ts, e->w));
  PetscCall(TSBatheGetTotals(e->ts, &attempts, accepted, solves, &newton, &linear));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EpisodeRunLibrary(Episode *e, SlipPolicy policy, PetscReal accuracy, EpisodeResult *result)
{
  PetscInt accepted, solves;

  PetscFunctionBegin;
  PetscCall(EpisodeSolve(e, policy, accuracy, &accepted, &solves));
  EpisodeConclude(e, solves, accepted, result);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Without objects, from the start on, if that knows what the policy observes */
static PetscErrorCode RunPlain(Episode *e, SlipPolicy policy, PetscReal accuracy, const SlipMethodCosts *costs,
                               EpisodeResult *result, PetscBool *known)
{
  PlainTotals totals;
  PlainPolicy p;

  PetscFunctionBegin;
  PetscCall(PlainPolicyStart(policy, NULL, &p, known));
  if (!*known) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Forget(e));
  PlainFaultSetState(&e->plain, e->plain_start);
  PetscCall(PlainRun(&e->plain, &p, accuracy, e->tmax, costs, costs ? EPISODE_MAX_EXPLICIT : EPISODE_MAX_STEPS,
                     MeasurePlain, e, &totals));
  EpisodeConclude(e, totals.attempts, totals.accepted, result);
  if (costs) result->solves = (PetscInt)PetscCeilReal((PetscReal)totals.products);
  result->cost = EpisodeCost(result, accuracy);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EpisodeRun(void *episode, SlipPolicy policy, PetscReal accuracy, EpisodeResult *result)
{
  PetscBool known;

  PetscFunctionBegin;
  PetscCall(RunPlain((Episode *)episode, policy, accuracy, NULL, result, &known));
  if (known) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(EpisodeRunLibrary((Episode *)episode, policy, accuracy, result));
  result->cost = EpisodeCost(result, accuracy);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EpisodeRunProducts(void *episode, SlipPolicy policy, PetscReal accuracy, EpisodeResult *result)
{
  Episode *e = (Episode *)episode;
  PetscBool known;

  PetscFunctionBegin;
  e->plain.omega = e->fineness * e->omega;
  PetscCall(RunPlain(e, policy, accuracy, &e->costs, result, &known));
  e->plain.omega = 0;
  PetscCheck(known, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "-train_problem fault_products has no residuals and no error estimates of all components: expected "
             "-train_observations that do not read them");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Its steps are not bounded as those of a policy: a tight tolerance takes many. */
PetscErrorCode EpisodeRunClassical(void *episode, TSAdaptType type, PetscReal rtol, EpisodeResult *result)
{
  Episode *e = (Episode *)episode;
  PetscInt attempts, accepted, solves, newton, linear;
  PetscReal rtol_before;
  TSAdapt adapt;
  PetscBool solved;

  PetscFunctionBegin;
  PetscCall(TSGetTolerances(e->ts, NULL, NULL, &rtol_before, NULL));
  PetscCall(EpisodeRewind(e, TSADAPTRL_ACCURACY_MAX));
  e->attempts_left = CLASSICAL_ATTEMPTS;
  PetscCall(TSSetMaxSteps(e->ts, CLASSICAL_ATTEMPTS));
  PetscCall(RunSetController(e->ts, type, rtol));
  PetscCall(RunSolve(e->ts, e->w, &solved));
  PetscCall(TSBatheGetTotals(e->ts, &attempts, &accepted, &solves, &newton, &linear));
  EpisodeConclude(e, solves, accepted, result);
  if (!solved) result->done = PetscMin(result->done, (PetscReal)0.99);
  PetscCall(TSSetTolerances(e->ts, PETSC_DEFAULT, NULL, rtol_before, NULL));
  PetscCall(TSSetMaxSteps(e->ts, EPISODE_MAX_STEPS));
  PetscCall(TSGetAdapt(e->ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTRL));
  PetscCall(TSAdaptRLSetStrict(adapt, PETSC_TRUE));
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

  PetscFunctionBegin;
  (void)adapt, (void)ts, (void)last, (void)guarded;
  watch->fn(n, obs, watch->ctx);
  PetscCall(SlipPolicyChoose(watch->policy, obs, watch->episode->tstar, watch->episode->tmax, h, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EpisodeWatch(void *episode, SlipPolicy policy, PetscReal accuracy, EpisodeWatchFn fn, void *ctx)
{
  Episode *e = (Episode *)episode;
  Watch watch = {e, policy, fn, ctx};
  const char *const *names;
  PetscReal dt[2];
  PetscInt n;
  TSAdapt adapt;

  PetscFunctionBegin;
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
  return PetscLogReal((PetscReal)(r->solves + 1)) + EpisodePenalty(r->error / accuracy) +
         (r->done < 1 ? UNFINISHED * (2 - r->done) : 0);
}
