/* Slip under a pore pressure as a problem for CMA-ES: a network that begins as the elementary controller. */
#include "injections.h"
#include "environment/cmaproblem.h"
#include <slipcompat.h>

enum { UNITS = 8 };
static const PetscReal Dial[2] = {1e-3, 1e-1};

/* What is observed, scaled and shifted to order one */
static const struct {
  const char *name;
  double scale, offset;
} Rows[] = {{SLIP_OBSERVES_ACCURACY, 1, 2}, {"log_error_step", 1, 0},
            {"log_step_ratio", 1, 0},       {"rejected", 1, 0},
            {"sliding_fraction", 1, 0},     {"change_sliding_fraction", 2, 0},
            {"time_fraction", 2, -1},       {"log_step_share", 0.5, 1},
            {"log_step_past", 0.5, 0.5},    {"log_velocity", 0.2, 1},
            {"change_log_velocity", 1, 0}};
enum { ROWS = PETSC_STATIC_ARRAY_LENGTH(Rows), WEIGHTS = (ROWS + 2) * UNITS + 1 };
enum { ROW_ERROR_STEP = 1 };
#define LINEAR 0.4      /* slope of the unit that is the elementary controller */
#define SAFETY (-0.046) /* log10 of its safety factor */
#define DRAWN 0.3       /* standard deviation of the other units' weights, which nothing reads at the start */
#define RTOL_START 5e-3 /* tolerance at the dial 1e-2 */
#define RTOL_POWER 2
#define UNIT 1e-2 /* that dial */
#define LOST 6    /* cost of a run that did not end */
#define FREE 0.8  /* errors up to this share of the dial cost nothing */
#define STEEP 2   /* cost of an error beyond, a power */
#define WORST_ERROR 50

static PetscErrorCode SetUp(CMAOptions *o)
{
  const char *names[ROWS + 1] = {NULL};

  PetscFunctionBegin;
  *o = (CMAOptions){.problem = o->problem,
                    .hidden = UNITS,
                    .layers = 1,
                    .activation = SLIP_ACTIVATION_TANH,
                    .more = 2,
                    .nsingle = 40,
                    .batch_single = 16,
                    .validation = 8,
                    .calibration = 24,
                    .within = 0.95,
                    .diagonal = 10,
                    .generations = 139,
                    .interval = 5,
                    .sigma = 0.1,
                    .low = Dial[0],
                    .high = Dial[1],
                    .side = 2,
                    .late_single = 1};
  for (PetscInt i = 0; i < ROWS; ++i) names[i] = Rows[i].name;
  PetscCall(CMAObservationsSet(o, names));
  for (PetscInt i = 0; i < ROWS; ++i) {
    o->scale[i] = Rows[i].scale;
    o->offset[i] = Rows[i].offset;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Start(const CMAOptions *o, double w[])
{
  double *bias = w + ROWS * UNITS, *out = bias + UNITS;
  Random random;

  RandomSeed(&random, (uint64_t)o->seed);
  for (PetscInt i = 0; i < (ROWS + 1) * UNITS; ++i) w[i] = DRAWN * RandomNormal(&random);
  for (PetscInt i = 0; i < ROWS; ++i) w[i] = i == ROW_ERROR_STEP ? LINEAR : 0;
  bias[0] = LINEAR * SAFETY;
  out[0] = 1 / LINEAR;
  CMARatioStart(RTOL_START, RTOL_POWER, w + WEIGHTS);
}

static void Range(const CMAOptions *o, PetscReal low[], PetscReal high[])
{
  CMADialRange(o, Dial, low, high);
}

static PetscErrorCode Policy(const CMAOptions *o, const double w[], SlipPolicy policy)
{
  return CMARatioPolicy(o, w + WEIGHTS, UNIT, Dial, policy);
}

static PetscErrorCode Create(const CMAOptions *o, uint64_t seed, PetscInt side, void **episode)
{
  InjectionEpisode *e;

  PetscFunctionBegin;
  (void)o, (void)side;
  PetscCall(PetscNew(&e));
  PetscCall(InjectionEpisodeCreate(seed, e));
  *episode = e;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(void **episode)
{
  PetscFunctionBegin;
  PetscCall(InjectionEpisodeDestroy((InjectionEpisode *)*episode));
  PetscCall(PetscFree(*episode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Without a policy the classical controller */
static PetscErrorCode RunUnder(void *episode, SlipPolicy policy, TSAdaptType type, PetscReal setting,
                               EpisodeResult *result)
{
  InjectionEpisode *e = (InjectionEpisode *)episode;
  InjectionErrors errors;
  PetscInt solves, rejected;
  PetscReal error;

  PetscFunctionBegin;
  PetscCall(InjectionEpisodeRun(e, policy, setting, type, setting, &solves, &rejected, &errors, &error));
  *result = (EpisodeResult){.solves = solves,
                            .attempts = solves,
                            .failures = rejected,
                            .error = error < 0 ? WORST_ERROR : error,
                            .done = error < 0 ? 0 : 1,
                            .usual = (PetscReal)e->usual};
  result->errors[SLIP_ERROR_HISTORY] = errors.course;
  result->errors[SLIP_ERROR_SHIFT] = errors.front;
  result->errors[SLIP_ERROR_FIELD] = errors.field;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(void *episode, SlipPolicy policy, PetscReal accuracy, EpisodeResult *result)
{
  PetscFunctionBegin;
  PetscCall(RunUnder(episode, policy, NULL, accuracy, result));
  result->cost = result->done < 1 ? LOST
                                  : PetscLogReal((PetscReal)result->solves / result->usual) +
                                      STEEP * PetscLogReal(PetscClipInterval(result->error / (FREE * accuracy),
                                                                             (PetscReal)1, (PetscReal)WORST_ERROR));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Classical(void *episode, TSAdaptType type, PetscReal rtol, EpisodeResult *result)
{
  return RunUnder(episode, NULL, type, rtol, result);
}

static PetscErrorCode Say(const CMAScore *score, char text[], size_t len)
{
  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(text, len, "cost %7.4f  dial kept %3.0f %%  solves %6.1f  error/dial %6.3f",
                          (double)score->cost, 100 * (double)score->within, (double)score->solves,
                          (double)score->error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const CMAProblem CMAInjections = {.episodes = "faults",
                                         .seed = RandomStreamHashed,
                                         .stream = 15,
                                         .first = 1,
                                         .dial = CMA_DIAL_SPREAD,
                                         .start_counts = PETSC_TRUE,
                                         .measure = "history",
                                         .setup = SetUp,
                                         .start = Start,
                                         .policy = Policy,
                                         .range = Range,
                                         .create = Create,
                                         .destroy = Destroy,
                                         .run = Run,
                                         .classical = Classical,
                                         .say = Say};

const Problem ProblemInjection = {
  .name = "injection", .meaning = "small faults that slip under a pore pressure", .cma = &CMAInjections};
