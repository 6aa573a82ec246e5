/* Cycles of events of small rate-and-state faults, by explicit steps (dials -problem cycles). The tolerances of
   src/fault/steps/cyclesteps.c are tested on them. */
#include "runs.h"
#include <slipcompat.h>

enum { EVENTS = 5 }; /* of an episode, after those at the start */
#define JUDGED 10    /* the dial bounds the error of this event's time */
#define REFERENCE_RTOL 1e-7
#define USUAL_RTOL 1e-3  /* of basic */
#define EVENT_RATE 1e-3  /* an event begins when the fastest cell passes it [m/s] */
#define QUIET_RATE 1e-5  /* and another one only after all were slower [m/s] */
#define END_AFTER 0.3    /* of the recurrence after the last event, in which none may follow */
#define MOST_STEPS 30000 /* of a reference */

/* ---- runs ---- */

static PetscErrorCode Draw(RunEpisode *e, Random *random)
{
  PetscReal side;

  PetscFunctionBegin;
  PetscCall(CyclesDraw(e, random, &side));
  PetscCall(SlipFaultSetUp(e->fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Follow(RunWatch *watch, TS ts, PetscInt step, PetscReal t, PetscReal rate, const PetscReal a[])
{
  const PetscReal bound = PetscLogReal(EVENT_RATE), now = PetscLogReal(PetscMax(rate, 1e-30)),
                  before = PetscLogReal(PetscMax(watch->rate, 1e-30));
  RunResult *r = watch->r;

  PetscFunctionBegin;
  (void)a;
  if (step == 0 || rate < QUIET_RATE) watch->armed = PETSC_TRUE;
  if (step > 0 && watch->armed && now > bound && before <= bound) {
    watch->armed = PETSC_FALSE;
    if (r->events <= EVENTS) r->begin[r->events] = watch->last + (t - watch->last) * (bound - before) / (now - before);
    PetscCall(RunCountEvent(watch, ts, &r->events));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of the time of event JUDGED over the recurrence, as that of these events lets expect */
static PetscErrorCode Compare(const RunEpisode *e, const RunResult *r, PetscReal errors[], PetscReal *error)
{
  const PetscReal *onset = e->reference.begin;

  PetscFunctionBegin;
  (void)errors;
  if (r->events != EVENTS) PetscFunctionReturn(PETSC_SUCCESS);
  *error = 0;
  for (PetscInt i = 1; i < EVENTS; i++)
    *error += PetscSqr((r->begin[i] - onset[i]) / e->span * JUDGED / (i + 1)) / (EVENTS - 1);
  *error = PetscSqrtReal(*error);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Its reference has events that are no farther apart than twice, and is found again with the usual tolerance. */
static PetscErrorCode Judge(RunEpisode *e, PetscBool *good)
{
  RunRequest request = {
    NULL, TSADAPTBASIC, USUAL_RTOL, .end = PETSC_MAX_REAL, .most = MOST_STEPS / 3, .events = EVENTS};
  PetscReal recurrence, first;
  EpisodeResult found;
  RunResult r;

  PetscFunctionBegin;
  *good = PETSC_FALSE;
  PetscCall(RunIntegrate(e, &request, &r));
  PetscCall(RunResultDestroy(&r));
  if (!r.good || r.events < EVENTS) PetscFunctionReturn(PETSC_SUCCESS);
  recurrence = r.begin[EVENTS - 1] - r.begin[EVENTS - 2];
  first = r.begin[1] - r.begin[0];
  if (recurrence > 2 * first || first > 2 * recurrence) PetscFunctionReturn(PETSC_SUCCESS);
  e->end = r.begin[EVENTS - 1] + END_AFTER * recurrence;
  request = (RunRequest){NULL, TSADAPTBASIC, REFERENCE_RTOL, .end = e->end, .most = MOST_STEPS, .events = EVENTS + 1};
  PetscCall(RunIntegrate(e, &request, &e->reference));
  if (!e->reference.good || e->reference.events != EVENTS) PetscFunctionReturn(PETSC_SUCCESS);
  e->span = e->reference.begin[EVENTS - 1] - e->reference.begin[EVENTS - 2];
  e->most = e->reference.solves;
  PetscCall(RunEpisodeRun(e, NULL, TSADAPTBASIC, USUAL_RTOL, &found));
  e->usual = found.solves;
  *good = found.done == 1 ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

const RunKind RunCycles = {.size = sizeof(RunEpisode),
                           .type = TSADAMS,
                           .early = PETSC_TRUE,
                           .events = EVENTS + 1, /* one more, which would be spurious */
                           .draw = Draw,
                           .judge = Judge,
                           .follow = Follow,
                           .compare = Compare,
                           .worst = 50};

/* ---- the problem: no policy of it is trained ---- */

static const CMAProblem CMACycles = {RUNS, .stream = 3, .runs = &RunCycles, .create = RunsCreate,
                                     .classical = RunsClassical};

const Problem ProblemCycles = {
  .name = "cycles", .meaning = "cycles of events of small rate-and-state faults", .cma = &CMACycles};
