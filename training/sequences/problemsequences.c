/* Segments of sequences of events as a problem for CMA-ES: a network that begins as the elementary controller. */
#include "sequences.h"
#include "environment/ratiopolicy.h"
#include <slipcompat.h>

enum { UNITS = 4 };
static const PetscReal Dial[2] = {3e-3, 1e-1};

static const RatioRow Rows[] = {{SLIP_OBSERVES_ACCURACY, 1, 2, 0},
                                {"log_error_step", 1, 0, 1},
                                {"log_step_ratio", 1, 0, 0},
                                {"rejected", 1, 0, 0},
                                {"sliding_fraction", 1, 0, 0},
                                {"change_sliding_fraction", 2, 0, 0},
                                {"log_step", 0.1, -0.4, 0},
                                {"log_velocity", 0.1, 0.4, 0},
                                {"change_log_velocity", 1, 0, 0},
                                {"log_peak_ratio", 1, -0.5, 0},
                                {"growth", 0.3, 0, 0}};
enum { ROWS = PETSC_STATIC_ARRAY_LENGTH(Rows), WEIGHTS = (ROWS + 2) * UNITS + 1 };
#define RTOL_START 2e-2 /* tolerance at the dial UNIT */
#define UNIT 1e-2
#define LOST 4        /* cost of a run that did not end */
#define PENALISED 0.7 /* errors cost from this part of the dial on */
#define WORST_ERROR 50

static PetscErrorCode SetUp(CMAOptions *o)
{
  PetscFunctionBegin;
  *o = (CMAOptions){.problem = o->problem,
                    .nsingle = 48,
                    .batch_single = 20,
                    .population = 16,
                    .validation = 12,
                    .calibration = 64,
                    .within = 0.95,
                    .diagonal = 100000000, /* always */
                    .generations = 60,
                    .interval = 5,
                    .sigma = 0.08,
                    .low = Dial[0],
                    .high = Dial[1],
                    .side = 2,
                    .late_single = 1};
  PetscCall(RatioSetUp(ROWS, Rows, UNITS, o));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Start(const CMAOptions *o, double w[])
{
  RatioStart(o, Rows, RTOL_START, w);
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
  SegmentEpisode *e;

  PetscFunctionBegin;
  (void)o, (void)side;
  PetscCall(PetscNew(&e));
  PetscCall(SegmentEpisodeCreate(seed, 0, e));
  *episode = e;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(void **episode)
{
  PetscFunctionBegin;
  PetscCall(SegmentEpisodeDestroy((SegmentEpisode *)*episode));
  PetscCall(PetscFree(*episode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Without a policy the classical controller */
static PetscErrorCode RunUnder(void *episode, SlipPolicy policy, TSAdaptType type, PetscReal setting,
                               EpisodeResult *result)
{
  SegmentEpisode *e = (SegmentEpisode *)episode;
  PetscReal errors[SEGMENT_NUM_ERRORS], error;
  PetscInt solves, rejected;

  PetscFunctionBegin;
  PetscCall(SegmentEpisodeRun(e, policy, setting, type, setting, &solves, &rejected, errors, &error));
  *result = (EpisodeResult){.solves = solves,
                            .attempts = solves,
                            .failures = rejected,
                            .error = error < 0 ? WORST_ERROR : error,
                            .done = error < 0 ? 0 : 1,
                            .usual = (PetscReal)e->usual};
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(void *episode, SlipPolicy policy, PetscReal accuracy, EpisodeResult *result)
{
  const PetscReal from = (PetscReal)PENALISED * accuracy;

  PetscFunctionBegin;
  PetscCall(RunUnder(episode, policy, NULL, accuracy, result));
  result->cost = result->done < 1
                   ? LOST
                   : PetscLogReal((PetscReal)result->solves / result->usual) +
                       PetscLogReal(PetscClipInterval(result->error / from, (PetscReal)1, (PetscReal)WORST_ERROR));
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

static const CMAProblem CMASequences = {.episodes = "segments",
                                        .seed = RandomStreamHashed,
                                        .stream = 11,
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

const Problem ProblemSequence = {
  .name = "sequence", .meaning = "segments of sequences of events of small faults", .cma = &CMASequences};
