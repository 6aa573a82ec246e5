/* Ruptures from a given stress as a problem for CMA-ES: a network that begins as a digital filter. */
#include "ruptures.h"
#include "environment/cmaproblem.h"
#include "environment/environment.h"
#include "common/files.h"
#include <slipcompat.h>

enum { UNITS = 4 };
static const PetscReal Dial[2] = {2e-3, 1e-1};

/* What is observed, scaled and shifted to order one */
static const struct {
  const char *name;
  double scale, offset;
} Rows[] = {
  {SLIP_OBSERVES_ACCURACY, 1, 2}, {"log_error_step", 1, 0},          {"log_step_ratio", 1, 0}, {"rejected", 1, 0},
  {"sliding_fraction", 1, 0},     {"change_sliding_fraction", 2, 0}, {"log_step", 0.3, 0.3},   {"log_velocity", 0.3, 0},
  {"change_log_velocity", 1, 0},  {"log_peak_ratio", 1, -0.5},       {"growth", 0.3, 0},       {"weakening", 1, -0.5},
  {"change_log_error_step", 1, 0}};
enum { ROWS = PETSC_STATIC_ARRAY_LENGTH(Rows), WEIGHTS = (ROWS + 2) * UNITS + 1 };
enum { ROW_ERROR_STEP = 1, ROW_CHANGE = ROWS - 1 };
/* The unit that is PI42, h_new = h E_n^(-0.6 q) E_(n-1)^(0.2 q), about estimates of 0.2: few attempts are rejected for E > 1 */
#define LINEAR 0.4 /* its slope */
#define PROPORTIONAL 0.4
#define CHANGE 0.2
#define TARGET (-0.093) /* 0.4 log10(0.2^(1/3)) */
#define DRAWN 0.3       /* standard deviation of the other units' weights, which nothing reads at the start */
#define RTOL_START 0.5  /* tolerance at the dial 1e-2 */
#define RTOL_POWER 1.5
#define UNIT 1e-2        /* that dial */
#define FIRST_START 0.03 /* first step at that dial [T*] */
#define FIRST_POWER 0.4
#define LOST 6 /* cost of a run that did not end */
#define WORST_ERROR 50
#define FREE 0.8     /* errors up to this share of the dial cost nothing */
#define STEEP 2      /* cost of an error beyond, a power */
#define SHARE_2 0.3  /* of the faults that are twice as large along either side */
#define SHARE_3 0.04 /* and three times */
#define LITTLE 2     /* d_c: where the broken cells slip less in the mean, */
#define KEPT 0.5     /* this share of the faults is kept */

static PetscErrorCode SetUp(CMAOptions *o)
{
  const char *names[ROWS + 1] = {NULL};

  PetscFunctionBegin;
  *o = (CMAOptions){.problem = o->problem,
                    .family = o->family,
                    .hidden = UNITS,
                    .layers = 1,
                    .activation = SLIP_ACTIVATION_TANH,
                    .more = 4,
                    .nsingle = 56,
                    .batch_single = 12,
                    .validation = 8,
                    .calibration = 24,
                    .within = 0.95,
                    .diagonal = 40,
                    .generations = 140,
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
  for (PetscInt i = 0; i < ROWS; ++i)
    w[i] = LINEAR * (i == ROW_ERROR_STEP ? PROPORTIONAL : i == ROW_CHANGE ? CHANGE : 0);
  bias[0] = LINEAR * TARGET;
  out[0] = 1 / LINEAR;
  CMARatioStart(RTOL_START, RTOL_POWER, w + WEIGHTS);
  CMARatioStart(FIRST_START, FIRST_POWER, w + WEIGHTS + 2);
}

static void Range(const CMAOptions *o, PetscReal low[], PetscReal high[])
{
  CMADialRange(o, Dial, low, high);
}

static PetscErrorCode Policy(const CMAOptions *o, const double w[], SlipPolicy policy)
{
  PetscFunctionBegin;
  PetscCall(CMARatioPolicy(o, w + WEIGHTS, UNIT, Dial, policy));
  PetscCall(
    CMADialNumberSet(w + WEIGHTS + 2, UNIT, SLIP_POLICY_FIRST_STEP_FACTOR, SLIP_POLICY_FIRST_STEP_POWER, policy));
  PetscCall(PolicySetNumber(policy, SLIP_POLICY_HOLD, "%.6g", 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Mean over the cells that break of their final slip [d_c] */
static PetscReal Slipped(const RuptureEpisode *e)
{
  PetscReal sum = 0;
  PetscInt broken = 0;

  for (PetscInt i = 0; i < e->n; ++i)
    if (e->reference.broke[i] >= 0) {
      sum += e->reference.slip[i] / e->weaken[i];
      broken++;
    }
  return broken ? sum / (PetscReal)broken : 0;
}

/* Some faults larger, as fronts run farther there; and fewer of those that hardly slip, of which every third would be one */
static PetscErrorCode Create(const CMAOptions *o, uint64_t seed, PetscInt side, void **episode)
{
  RuptureEpisode *e;
  PetscBool kept = PETSC_FALSE;
  Random random;

  PetscFunctionBegin;
  (void)side;
  PetscCall(PetscNew(&e));
  if (o->family) {
    PetscCall(RuptureEpisodeOfFamily((const Family *)o->family, seed, e));
    kept = PETSC_TRUE;
  }
  RandomSeed(&random, seed);
  while (!kept) {
    const double size = RandomUniform(&random);
    const PetscInt larger = size < SHARE_3 ? 3 : size < SHARE_3 + SHARE_2 ? 2 : 1;

    PetscCall(RuptureEpisodeCreate(random.s[0], larger, e));
    kept = Slipped(e) >= LITTLE || RandomUniform(&random) < KEPT ? PETSC_TRUE : PETSC_FALSE;
    if (!kept) PetscCall(RuptureEpisodeDestroy(e));
  }
  *episode = e;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(void **episode)
{
  PetscFunctionBegin;
  PetscCall(RuptureEpisodeDestroy((RuptureEpisode *)*episode));
  PetscCall(PetscFree(*episode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Without a policy the classical controller */
static PetscErrorCode RunUnder(void *episode, SlipPolicy policy, TSAdaptType type, PetscReal setting,
                               EpisodeResult *result)
{
  RuptureEpisode *e = (RuptureEpisode *)episode;
  PetscReal errors[SLIP_NUM_ERRORS], error;
  PetscInt solves, rejected;

  PetscFunctionBegin;
  PetscCall(RuptureEpisodeRun(e, policy, setting, type, setting, &solves, &rejected, errors, &error));
  *result = (EpisodeResult){.solves = solves,
                            .attempts = solves,
                            .failures = rejected,
                            .error = error < 0 ? WORST_ERROR : error,
                            .done = error < 0 ? 0 : 1,
                            .usual = (PetscReal)e->usual};
  PetscCall(PetscArraycpy(result->errors, errors, SLIP_NUM_ERRORS));
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

static const CMAProblem CMARuptures = {.episodes = "faults",
                                       .seed = RandomStreamHashed,
                                       .stream = 7,
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

const Problem ProblemRupture = {
  .name = "rupture", .meaning = "ruptures of small faults from a given stress", .cma = &CMARuptures};
