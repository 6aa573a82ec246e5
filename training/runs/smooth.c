/* Implicit steps through cycles of events of small rate-and-state faults, with inertia or without (train
   -train_algorithm cmaes -train_problem smooth): a network that begins as the elementary controller. */
#include "ratiopolicy.h"
#include "runs.h"
#include <slipcompat.h>

enum { SMOOTH_EVENTS = 2 }; /* of an episode */
#define SMOOTH_REFERENCE_TYPE TSADAPTDSP
#define SMOOTH_REFERENCE_RTOL 1e-5
#define COARSE_RTOL 1e-2
#define USUAL_TYPE TSADAPTHEURISTIC
#define USUAL_RTOL 1e-3
#define EVENT_RATE 1e-3   /* an event begins when the fastest cell passes it [m/s], */
#define OVER_RATE 1e-4    /* and is over when all are slower than that [m/s] */
#define END_AFTER 0.3     /* of the recurrence after the last event, in which none may follow */
#define WITH_INERTIA 0.67 /* share of the draws */
#define EXACT 0.5         /* and of these with the exact viscosity, others with radiation */
#define MOST_ATTEMPTS 20000

typedef struct {
  RunEpisode base;   /* span: from one event to the next; RunResult.slip: of each event [m] */
  PetscReal loading; /* [m/s] */
} SmoothEpisode;

static PetscErrorCode Draw(RunEpisode *e, Random *random)
{
  PetscBool inertia;
  PetscReal side;

  PetscFunctionBegin;
  PetscCall(CyclesDraw(e, random, &side));
  inertia = RandomUniform(random) < WITH_INERTIA ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipFaultSetBool(e->fault, "inertia", inertia));
  PetscCall(SlipFaultSetReal(e->fault, "thickness", (PetscReal)RandomLog(random, 0.1, 1) * side));
  PetscCall(
    SlipFaultSetString(e->fault, "viscosity", inertia && RandomUniform(random) < EXACT ? "sqrtm" : "radiation"));
  PetscCall(SlipFaultSetUp(e->fault));
  PetscCall(SlipFaultGetReal(e->fault, "loading_rate", &((SmoothEpisode *)e)->loading));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- runs ---- */

/* Slip of each cell at a share of the last step, added sign times; a cubic between the ends of steps */
static void AddSlip(const RunWatch *watch, const PetscReal a[], PetscReal t, PetscReal share, PetscReal sign,
                    PetscReal slip[])
{
  const PetscReal h = t - watch->last, x = share, loading = ((const SmoothEpisode *)watch->e)->loading;

  for (PetscInt i = 0; i < watch->e->n; i++) {
    const PetscReal s0 = watch->before[2 * i], v0 = watch->before[2 * i + 1];
    const PetscReal s1 = a[3 * i + 1] + loading * t, v1 = a[3 * i];

    slip[i] +=
      sign * (s0 + x * (h * v0 + x * (3 * (s1 - s0) - h * (2 * v0 + v1) + x * (2 * (s0 - s1) + h * (v0 + v1)))));
  }
}

static PetscErrorCode Follow(RunWatch *watch, TS ts, PetscInt step, PetscReal t, PetscReal rate, const PetscReal a[])
{
  const PetscReal loading = ((const SmoothEpisode *)watch->e)->loading,
                  now = PetscLogReal(PetscMax(rate, (PetscReal)1e-30)),
                  before = PetscLogReal(PetscMax(watch->rate, (PetscReal)1e-30));
  const PetscInt n = watch->e->n;
  RunResult *r = watch->r;

  PetscFunctionBegin;
  if (step > 0) {
    const PetscBool within = r->events > r->ended ? PETSC_TRUE : PETSC_FALSE;
    const PetscReal bound = PetscLogReal(within ? (PetscReal)OVER_RATE : (PetscReal)EVENT_RATE);

    if ((within ? now <= bound : now > bound) && r->ended <= SMOOTH_EVENTS) {
      const PetscReal share = now != before ? PetscClipInterval((bound - before) / (now - before), 0, 1) : 1;

      (within ? r->over : r->begin)[r->ended] = watch->last + share * (t - watch->last);
      AddSlip(watch, a, t, share, within ? 1 : -1, r->slip + r->ended * n);
      if (within)
        PetscCall(RunCountEvent(watch, ts, &r->ended));
      else
        r->events++;
    }
  }
  for (PetscInt i = 0; i < n; i++) {
    watch->before[2 * i] = a[3 * i + 1] + loading * t;
    watch->before[2 * i + 1] = a[3 * i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The largest of the events: onset, over the recurrence; slips of cells; moment. 1 where an event is missed or added */
static PetscErrorCode Compare(const RunEpisode *e, const RunResult *r, PetscReal errors[], PetscReal *error)
{
  PetscReal onset = 0, slip = 0, moments = 0;

  PetscFunctionBegin;
  *error = 1;
  if (r->events != SMOOTH_EVENTS || r->ended != SMOOTH_EVENTS) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < SMOOTH_EVENTS; k++) {
    const PetscReal *a = r->slip + k * e->n, *b = e->reference.slip + k * e->n;
    PetscReal moment[2] = {0, 0};

    for (PetscInt i = 0; i < e->n; i++) {
      moment[0] += a[i];
      moment[1] += b[i];
    }
    onset = PetscMax(onset, PetscAbsReal(r->begin[k] - e->reference.begin[k]) / e->span);
    slip = PetscMax(slip, RunFieldError(e->n, a, b));
    moments = PetscMax(moments, PetscAbsReal(moment[0] / moment[1] - 1));
  }
  errors[SLIP_ERROR_SHIFT] = onset;
  errors[SLIP_ERROR_FIELD] = slip;
  errors[SLIP_ERROR_FINAL] = moments;
  *error = PetscMax(onset, PetscMax(slip, moments));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Judge(RunEpisode *e, PetscBool *good)
{
  const PetscInt last = SMOOTH_EVENTS - 1;
  RunRequest request = {NULL,
                        SMOOTH_REFERENCE_TYPE,
                        COARSE_RTOL,
                        .end = PETSC_MAX_REAL,
                        .most = MOST_ATTEMPTS / 10,
                        .events = SMOOTH_EVENTS};
  EpisodeResult usual;
  RunResult r;

  PetscFunctionBegin;
  PetscCall(RunIntegrate(e, &request, &r));
  e->end = r.over[last] + (PetscReal)END_AFTER * (r.begin[last] - r.begin[last - 1]);
  *good = r.good;
  PetscCall(RunResultDestroy(&r));
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  request = (RunRequest){NULL, SMOOTH_REFERENCE_TYPE, SMOOTH_REFERENCE_RTOL, .end = e->end, .most = MOST_ATTEMPTS};
  PetscCall(RunIntegrate(e, &request, &e->reference));
  e->span = e->reference.begin[last] - e->reference.begin[last - 1];
  *good = e->reference.good && e->reference.events == SMOOTH_EVENTS && e->reference.ended == SMOOTH_EVENTS
            ? PETSC_TRUE
            : PETSC_FALSE;
  if (*good) {
    PetscCall(RunEpisodeRun(e, NULL, USUAL_TYPE, USUAL_RTOL, &usual));
    e->usual = usual.solves;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

const RunKind RunSmooth = {.size = sizeof(SmoothEpisode),
                           .type = TSBATHE,
                           .slips = SMOOTH_EVENTS + 1, /* one more, which would be spurious */
                           .draw = Draw,
                           .judge = Judge,
                           .follow = Follow,
                           .compare = Compare,
                           .most = MOST_ATTEMPTS,
                           .lost = 6,
                           .free = 0.8,
                           .steep = 2,
                           .worst = 50};

/* ---- the problem for CMA-ES ---- */

static const CMARow Rows[] = {
  {SLIP_OBSERVES_ACCURACY, 1, 2, 0, 0}, {"log_error_step", 1, 0, 1, 0},     {"change_log_error_step", 1, 0, 0, 0},
  {"log_step_ratio", 1, 0, 0, 0},       {"rejected", 1, 0, 0, 0},           {"log_step", 0.1, 0, 0, 0},
  {"log_velocity", 0.1, 0, 0, 0},       {"change_log_velocity", 1, 0, 0, 0}};
static const CMAOptions Defaults = {.nsingle = 16,
                                    .batch_single = 6,
                                    .validation = 8,
                                    .calibration = 12,
                                    .diagonal = 10,
                                    .generations = 139,
                                    .sigma = 0.1};
static const RatioNetwork Network = {.defaults = &Defaults,
                                     .rows = PETSC_STATIC_ARRAY_LENGTH(Rows),
                                     .units = 8,
                                     .row = Rows,
                                     .bias = RATIO_SAFETY,
                                     .dial = {1e-3, 1e-1},
                                     .unit = 1e-2,
                                     .rtol = 1e-2,
                                     .power = 1.5};

static const CMAProblem CMASmooth = {RUNS,
                                     RATIO_FUNCTIONS,
                                     .episodes = "faults",
                                     .stream = 19,
                                     .dial = CMA_DIAL_SPREAD,
                                     .create = RunsCreate,
                                     .network = &Network,
                                     .runs = &RunSmooth,
                                     .classical = RunsClassical,
                                     .say = RunsSay};

const Problem ProblemSmooth = {.name = "smooth",
                               .meaning =
                                 "cycles of small rate-and-state faults by implicit steps, with inertia or without",
                               .cma = &CMASmooth};
