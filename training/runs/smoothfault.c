/* Implicit runs of small faults with cycles of events, and their errors. */
#include "smooth.h"
#include "cycles.h"
#include "environment/libraryrun.h"
#include <slipcompat.h>

#define COARSE_RTOL 1e-2
#define USUAL_TYPE TSADAPTHEURISTIC
#define USUAL_RTOL 1e-3
#define EVENT_RATE 1e-3   /* an event begins when the fastest cell passes it [m/s], */
#define OVER_RATE 1e-4    /* and is over when all are slower than that [m/s] */
#define END_AFTER 0.3     /* of the recurrence after the last event, in which none may follow */
#define WITH_INERTIA 0.67 /* share of the draws */
#define EXACT 0.5         /* and of these with the exact viscosity, others with radiation */
#define MOST_ATTEMPTS 20000

static PetscErrorCode RunCreate(PetscInt n, SmoothRun *r)
{
  PetscFunctionBegin;
  *r = (SmoothRun){.n = n};
  for (PetscInt i = 0; i <= SMOOTH_EVENTS; i++) PetscCall(PetscCalloc1(n, &r->event[i].slip));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RunDestroy(SmoothRun *r)
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i <= SMOOTH_EVENTS; i++) PetscCall(PetscFree(r->event[i].slip));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a run ---- */

typedef struct {
  SmoothRun *r;
  PetscInt most;     /* events after which it ends, when the last is over; 0: never */
  PetscReal loading; /* [m/s] */
  PetscReal *before; /* [2 n] slip and rate of each cell at the last step */
  PetscReal last, last_log;
} Watch;

/* Slip of each cell at a share of the last step, added sign times; a cubic between the ends of steps */
static void AddSlip(const Watch *watch, const PetscReal a[], PetscReal t, PetscReal share, PetscReal sign,
                    PetscReal slip[])
{
  const PetscReal h = t - watch->last, x = share;

  for (PetscInt i = 0; i < watch->r->n; i++) {
    const PetscReal s0 = watch->before[2 * i], v0 = watch->before[2 * i + 1];
    const PetscReal s1 = a[3 * i + 1] + watch->loading * t, v1 = a[3 * i];

    slip[i] +=
      sign * (s0 + x * (h * v0 + x * (3 * (s1 - s0) - h * (2 * v0 + v1) + x * (2 * (s0 - s1) + h * (v0 + v1)))));
  }
}

static PetscErrorCode Follow(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  Watch *watch = (Watch *)ctx;
  SmoothRun *r = watch->r;
  const PetscReal *a;
  PetscReal most = 0, now;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < r->n; i++) most = PetscMax(most, PetscAbsReal(a[3 * i]));
  now = PetscLogReal(PetscMax(most, (PetscReal)1e-30));
  if (step > 0) {
    const PetscBool within = r->events > r->ended ? PETSC_TRUE : PETSC_FALSE;
    const PetscReal bound = PetscLogReal(within ? (PetscReal)OVER_RATE : (PetscReal)EVENT_RATE);

    if ((within ? now <= bound : now > bound) && r->ended <= SMOOTH_EVENTS) {
      SmoothEvent *event = &r->event[r->ended];
      const PetscReal share =
        now != watch->last_log ? PetscClipInterval((bound - watch->last_log) / (now - watch->last_log), 0, 1) : 1;

      *(within ? &event->over : &event->begin) = watch->last + share * (t - watch->last);
      AddSlip(watch, a, t, share, within ? 1 : -1, event->slip);
      *(within ? &r->ended : &r->events) += 1;
      if (within && r->ended == watch->most) PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
    }
  }
  for (PetscInt i = 0; i < r->n; i++) {
    watch->before[2 * i] = a[3 * i + 1] + watch->loading * t;
    watch->before[2 * i + 1] = a[3 * i];
  }
  PetscCall(VecRestoreArrayRead(w, &a));
  watch->last_log = now;
  watch->last = t;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* events: after which it ends, 0: at the end of the episode; most: steps after which it is not good */
static PetscErrorCode Integrate(const SmoothEpisode *e, SlipPolicy policy, TSAdaptType type, PetscReal setting,
                                PetscInt events, PetscInt most, SmoothRun *r)
{
  Watch watch = {.r = r, .most = events};
  FaultRun run = {policy, type, setting, .end = e->end, .most = most, .follow = Follow, .ctx = &watch};

  PetscFunctionBegin;
  PetscCall(RunCreate(e->n, r));
  PetscCall(PetscCalloc1(2 * e->n, &watch.before));
  PetscCall(SlipFaultGetReal(e->fault, "loading_rate", &watch.loading));
  PetscCall(
    PetscOptionsCreate(&run.options)); /* without inertia the fault is an explicit problem unless they say otherwise */
  PetscCall(PetscOptionsSetValue(run.options, "-ts_type", TSBATHE));
  PetscCall(RunFault(e->fault, &run, &r->solves, &r->rejected, &r->good));
  PetscCall(PetscOptionsDestroy(&run.options));
  PetscCall(PetscFree(watch.before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- its error ---- */

static void CompareEvents(const SmoothEpisode *e, const SmoothEvent *a, const SmoothEvent *b, SmoothErrors *errors)
{
  PetscReal moment[2] = {0, 0};

  for (PetscInt i = 0; i < e->n; i++) {
    moment[0] += a->slip[i];
    moment[1] += b->slip[i];
  }
  errors->onset = PetscMax(errors->onset, PetscAbsReal(a->begin - b->begin) / e->recurrence);
  errors->slip = PetscMax(errors->slip, RunFieldError(e->n, a->slip, b->slip));
  errors->moment = PetscMax(errors->moment, PetscAbsReal(moment[0] / moment[1] - 1));
}

PetscErrorCode SmoothEpisodeRun(SmoothEpisode *e, SlipPolicy policy, PetscReal accuracy, TSAdaptType type,
                                PetscReal rtol, PetscInt *solves, PetscInt *rejected, SmoothErrors *errors,
                                PetscReal *error)
{
  SmoothRun r;

  PetscFunctionBegin;
  PetscCall(Integrate(e, policy, type, policy ? accuracy : rtol, 0, policy ? 20 * e->usual : MOST_ATTEMPTS, &r));
  *solves = r.solves;
  *rejected = r.rejected;
  *errors = (SmoothErrors){1, 1, 1};
  *error = r.good ? 1 : -1;
  if (r.good && r.events == SMOOTH_EVENTS && r.ended == SMOOTH_EVENTS) {
    *errors = (SmoothErrors){0, 0, 0};
    for (PetscInt i = 0; i < SMOOTH_EVENTS; i++) CompareEvents(e, &r.event[i], &e->reference.event[i], errors);
    *error = PetscMax(errors->onset, PetscMax(errors->slip, errors->moment));
  }
  PetscCall(RunDestroy(&r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- an episode ---- */

static PetscErrorCode Judge(SmoothEpisode *e, PetscBool *good)
{
  const PetscInt last = SMOOTH_EVENTS - 1;
  SmoothErrors errors;
  PetscReal error;
  PetscInt rejected;
  SmoothRun r;

  PetscFunctionBegin;
  e->end = PETSC_MAX_REAL;
  PetscCall(Integrate(e, NULL, SMOOTH_REFERENCE_TYPE, COARSE_RTOL, SMOOTH_EVENTS, MOST_ATTEMPTS / 10, &r));
  e->recurrence = r.event[last].begin - r.event[last - 1].begin;
  e->end = r.event[last].over + (PetscReal)END_AFTER * e->recurrence;
  *good = r.good;
  PetscCall(RunDestroy(&r));
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Integrate(e, NULL, SMOOTH_REFERENCE_TYPE, SMOOTH_REFERENCE_RTOL, 0, MOST_ATTEMPTS, &e->reference));
  e->recurrence = e->reference.event[last].begin - e->reference.event[last - 1].begin;
  *good = e->reference.good && e->reference.events == SMOOTH_EVENTS && e->reference.ended == SMOOTH_EVENTS
            ? PETSC_TRUE
            : PETSC_FALSE;
  if (*good) PetscCall(SmoothEpisodeRun(e, NULL, 0, USUAL_TYPE, USUAL_RTOL, &e->usual, &rejected, &errors, &error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SmoothEpisodeCreate(uint64_t seed, SmoothEpisode *e)
{
  PetscBool good = PETSC_FALSE;
  Random random;

  PetscFunctionBegin;
  RandomSeed(&random, seed);
  while (!good) {
    PetscReal side;

    *e = (SmoothEpisode){0};
    PetscCall(CycleFaultDraw(&random, &e->fault, &e->n, &side));
    e->inertia = RandomUniform(&random) < WITH_INERTIA ? PETSC_TRUE : PETSC_FALSE;
    PetscCall(SlipFaultSetBool(e->fault, "inertia", e->inertia));
    PetscCall(SlipFaultSetReal(e->fault, "thickness", (PetscReal)RandomLog(&random, 0.1, 1) * side));
    PetscCall(
      SlipFaultSetString(e->fault, "viscosity", e->inertia && RandomUniform(&random) < EXACT ? "sqrtm" : "radiation"));
    PetscCall(SlipFaultSetUp(e->fault));
    PetscCall(Judge(e, &good));
    if (!good) PetscCall(SmoothEpisodeDestroy(e));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SmoothEpisodeDestroy(SmoothEpisode *e)
{
  PetscFunctionBegin;
  PetscCall(RunDestroy(&e->reference));
  PetscCall(SlipFaultDestroy(&e->fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}
