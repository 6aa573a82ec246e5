/* Cycles of events of small rate-and-state faults, by explicit steps (train -train_algorithm cmaes -train_problem
   cycles): the tolerances of src/fault/cyclesteps.c are measured on them (dials -problem cycles). The network of a
   policy for them, of three units, begins as the smaller of what the error estimate and the stability of explicit steps
   allow. */
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
                           .lost = 4,
                           .free = 1,
                           .steep = 1,
                           .worst = 50};

/* ---- the problem for CMA-ES ---- */

enum { UNITS = 3 };
static const PetscReal Dial[2] = {1e-4, 1e-2};    /* range of the training */
static const PetscReal Trusted[2] = {1e-4, 1e-3}; /* and of the file: beyond, coarser faults than these lose events */
static const PetscReal Judged[CMA_DIALS] = {3e-4, 1e-3, 5e-3}; /* of the validation */

/* What is observed, scaled and shifted, and the start: the elementary controller's ratio of steps by the error, and
   that to the longest stable step, which grows with the dial. The scale is also how little a weight counts beside
   others. */
static const CMARow Rows[] = {{"log_error_step", 1, 0, 1, 0},          {"change_log_error_step", 1, 0, 0, 0},
                              {"log_step_ratio", 1, 0, 0, 0},          {"rejected", 1, 0, 0, 0},
                              {SLIP_OBSERVES_ACCURACY, 1, 3, 0, 0.12}, {"log_step", 0.1, 0, 0, -1},
                              {"log_relaxation", 0.1, 0, 0, -1}};
enum { ROWS = PETSC_STATIC_ARRAY_LENGTH(Rows), WEIGHTS = (ROWS + 2) * UNITS + 1 };
#define ERROR_BIAS (-0.046) /* log10 of the safety factor */
#define STABLE_BIAS 0.48    /* log10 of the step at the dial 1e-3 in units of the relaxation time: 3 */
#define RTOL_START 2e-2     /* tolerance at the dial 1e-3, of the worst cell */
#define RTOL_POWER 1
#define UNIT 1e-3 /* that dial */

static PetscErrorCode SetUp(CMAOptions *o)
{
  PetscFunctionBegin;
  *o = (CMAOptions){.problem = o->problem,
                    .hidden = UNITS,
                    .layers = 1,
                    .activation = SLIP_ACTIVATION_RELU,
                    .more = 2,
                    .nsingle = 16,
                    .batch_single = 6,
                    .validation = 8,
                    .population = 12,
                    .diagonal = 100000000, /* always */
                    .generations = 25,
                    .interval = 5,
                    .sigma = 0.04,
                    .low = Dial[0],
                    .high = Dial[1]};
  PetscCall(CMARowsSet(o, ROWS, Rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* min(e, s) = e - relu(e - s); e itself is relu(e) - relu(-e) */
static void Start(const CMAOptions *o, double w[])
{
  double *bias = w + ROWS * UNITS, *out = bias + UNITS;

  (void)o;
  for (PetscInt i = 0; i < ROWS; ++i) {
    const double e = Rows[i].start / Rows[i].scale, s = Rows[i].stable / Rows[i].scale;

    w[i] = e;
    w[ROWS + i] = -e;
    w[2 * ROWS + i] = e - s;
  }
  bias[0] = ERROR_BIAS;
  bias[1] = -ERROR_BIAS;
  bias[2] = ERROR_BIAS - STABLE_BIAS;
  out[0] = 1;
  out[1] = out[2] = -1;
  CMARatioStart(RTOL_START, RTOL_POWER, w + WEIGHTS);
}

static void Range(const CMAOptions *o, PetscReal low[], PetscReal high[])
{
  CMADialRange(o, Trusted, low, high);
}

static PetscErrorCode Policy(const CMAOptions *o, const double w[], SlipPolicy policy)
{
  return CMARatioPolicy(o, w + WEIGHTS, UNIT, Dial, policy);
}

static PetscErrorCode Say(const CMAScore *score, char text[], size_t len)
{
  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(text, len, "cost %7.4f  dial kept %3.0f %%  products %6.4f of basic's", (double)score->cost,
                          100 * (double)score->within, (double)score->over_usual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const CMAProblem CMACycles = {RUNS,
                                     .episodes = "faults",
                                     .stream = 3,
                                     .dial = CMA_DIAL_DRAWN,
                                     .judged = Judged,
                                     .runs = &RunCycles,
                                     .setup = SetUp,
                                     .start = Start,
                                     .policy = Policy,
                                     .range = Range,
                                     .create = RunsCreate,
                                     .say = Say};

const Problem ProblemCycles = {
  .name = "cycles", .meaning = "cycles of events of small rate-and-state faults", .cma = &CMACycles};
