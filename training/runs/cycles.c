/* Cycles of events of small rate-and-state faults, by explicit steps (dials -problem cycles). The tolerances of
   src/fault/steps/cyclesteps.c are tested on them. */
#include "runs.h"
#include <slipcompat.h>
#include <math.h>

enum { EVENTS = 5 }; /* of an episode, after those at the start */
#define JUDGED 10    /* the dial bounds the error of this event's time */
#define REFERENCE_RTOL 1e-7
#define USUAL_RTOL 1e-3  /* of basic */
#define EVENT_RATE 1e-3  /* an event begins when the fastest cell passes it [m/s] */
#define QUIET_RATE 1e-5  /* and another one only after all were slower [m/s] */
#define END_AFTER 0.3    /* of the recurrence after the last event, in which none may follow */
#define MOST_STEPS 30000 /* of a reference */

#define SHEAR 32e9      /* [Pa] */
#define CORE_DEPTH 0.55 /* of the core, over that of the fault */

static const PetscInt Meshes[][2] = {{16, 8}, {20, 10}, {12, 12}, {24, 6}, {1, 48}, {1, 32}};

/* The weakening core, from a fifth of the depth to three quarters and over the middle two thirds along strike, is
   surrounded by cells that creep, of which the fault is half; a tenth of it, at one end, begins ten times faster than
   the rest. In SI units. */
static PetscErrorCode Draw(RunEpisode *e, Random *random)
{
  const PetscInt *mesh = Meshes[RandomIndex(random, PETSC_STATIC_ARRAY_LENGTH(Meshes))];
  const PetscInt nx = mesh[0], nz = mesh[1], n = nx * nz;
  const double cell = RandomLog(random, 200, 2500), stress = RandomLog(random, 15e6, 60e6),
               b = RandomLog(random, 0.01, 0.03), of_core = b * (0.13 + 0.4 * RandomUniform(random)),
               rim = 1.15 + RandomUniform(random);
  /* G d_c/(b sigma) is the length over which a rupture front weakens */
  const double slip = RandomLog(random, 2.5, 4.5) * cell / (SHEAR * 1 / (b * stress));
  const RunOption rows[] = {{"friction_law", 0, "rate_and_state"},
                            {"length_x", nx == 1 ? 1e7 : (double)nx * cell, NULL},
                            {"shear_modulus", SHEAR, NULL},
                            {"density", 2670, NULL},
                            {"friction_b", b, NULL},
                            {"friction_slip", slip, NULL},
                            {"loading_rate", 1e-9, NULL}};
  PetscReal *a, *rate;

  PetscFunctionBegin;
  PetscCall(RunNewFault(e, nx, nz, cell, stress));
  PetscCall(RunSetOptions(e->fault, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscCall(PetscMalloc2(n, &a, n, &rate));
  for (PetscInt i = 0; i < n; i++) {
    const double x = ((double)(i % nx) + 0.5) / (double)nx - 0.5, z = ((double)(i / nx) + 0.5) / (double)nz;
    const PetscBool core = (nx == 1 || fabs(x) < 1.0 / 3) && z > 0.2 && z < 0.2 + CORE_DEPTH ? PETSC_TRUE : PETSC_FALSE;

    a[i] = (PetscReal)(core ? of_core : b * rim);
    rate[i] = core && (nx == 1 ? z > 0.6 : x < -0.2) ? 1e-8 : 1e-9;
  }
  PetscCall(SlipFaultSetField(e->fault, "friction_a", n, a));
  PetscCall(SlipFaultSetField(e->fault, "initial_rate", n, rate));
  PetscCall(PetscFree2(a, rate));
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
