/* Ruptures from a given stress as a problem for CMA-ES: a network that begins as a digital filter. */
#include "ruptures.h"
#include "runs/libraryepisode.h"
#include "runs/ratiopolicy.h"
#include "common/files.h"
#include <slipcompat.h>

/* The unit that is PI42, h_new = h E_n^(-0.6 q) E_(n-1)^(0.2 q), about estimates of 0.2: few attempts are rejected for E > 1 */
#define PROPORTIONAL 0.4
#define CHANGE 0.2
#define TARGET (-0.093) /* 0.4 log10(0.2^(1/3)) */
#define RTOL_START 0.5  /* tolerance at the dial 1e-2 */
#define RTOL_POWER 1.5
#define FIRST_START 0.03 /* first step at that dial [T*] */
#define FIRST_POWER 0.4
#define CEILING 3    /* cells that break give estimates beyond 1 without harm */
#define SHARE_2 0.3  /* of the faults that are twice as large along either side */
#define SHARE_3 0.04 /* and three times */
#define LITTLE 2     /* d_c: where the broken cells slip less in the mean, */
#define KEPT 0.5     /* this share of the faults is kept */

static const RatioRow Rows[] = {{SLIP_OBSERVES_ACCURACY, 1, 2, 0},
                                {"log_error_step", 1, 0, PROPORTIONAL},
                                {"log_step_ratio", 1, 0, 0},
                                {"rejected", 1, 0, 0},
                                {"sliding_fraction", 1, 0, 0},
                                {"change_sliding_fraction", 2, 0, 0},
                                {"log_step", 0.3, 0.3, 0},
                                {"log_velocity", 0.3, 0, 0},
                                {"change_log_velocity", 1, 0, 0},
                                {"log_peak_ratio", 1, -0.5, 0},
                                {"growth", 0.3, 0, 0},
                                {"weakening", 1, -0.5, 0},
                                {"change_log_error_step", 1, 0, CHANGE}};
static const CMAOptions Defaults = {.more = 4, /* the first step besides the tolerance */
                                    .nsingle = 56,
                                    .batch_single = 12,
                                    .validation = 8,
                                    .calibration = 24,
                                    .diagonal = 40,
                                    .generations = 140,
                                    .sigma = 0.1};
static const RatioNetwork Network = {.defaults = &Defaults,
                                     .rows = PETSC_STATIC_ARRAY_LENGTH(Rows),
                                     .units = 4,
                                     .row = Rows,
                                     .bias = TARGET,
                                     .dial = {2e-3, 1e-1},
                                     .unit = 1e-2,
                                     .rtol = RTOL_START,
                                     .power = RTOL_POWER};

static void Start(const CMAOptions *o, double w[])
{
  RatioStart(o, w);
  CMARatioStart(FIRST_START, FIRST_POWER, w + RatioNumbers(o) + 2);
}

static PetscErrorCode Policy(const CMAOptions *o, const double w[], SlipPolicy policy)
{
  PetscFunctionBegin;
  PetscCall(RatioPolicy(o, w, policy));
  PetscCall(CMADialNumberSet(w + RatioNumbers(o) + 2, Network.unit, SLIP_POLICY_FIRST_STEP_FACTOR,
                             SLIP_POLICY_FIRST_STEP_POWER, policy));
  PetscCall(PolicySetNumber(policy, SLIP_POLICY_HOLD, "%.6g", 0));
  PetscCall(PolicySetNumber(policy, SLIP_POLICY_CEILING, "%.6g", CEILING));
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
static PetscErrorCode Create(const CMAOptions *o, uint64_t seed, void *episode)
{
  RuptureEpisode *e = (RuptureEpisode *)episode;
  PetscBool kept = PETSC_FALSE;
  Random random;

  PetscFunctionBegin;
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
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(void *e)
{
  return RuptureEpisodeDestroy((RuptureEpisode *)e);
}

static PetscErrorCode Run(void *episode, SlipPolicy policy, TSAdaptType type, PetscReal setting, EpisodeResult *r)
{
  RuptureEpisode *e = (RuptureEpisode *)episode;

  PetscFunctionBegin;
  PetscCall(RuptureEpisodeRun(e, policy, setting, type, setting, &r->solves, &r->failures, r->errors, &r->error));
  r->attempts = r->solves;
  r->usual = (PetscReal)e->usual;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const LibraryEpisodes Episodes = {
  sizeof(RuptureEpisode), Create, Destroy, Run, .lost = 6, .free = 0.8, .steep = 2, .worst = 50};

static const CMAProblem CMARuptures = {LIBRARY_EPISODES,
                                       .episodes = "faults",
                                       .stream = 7,
                                       .dial = CMA_DIAL_SPREAD,
                                       .network = &Network,
                                       .library = &Episodes,
                                       .setup = RatioSetUp,
                                       .start = Start,
                                       .policy = Policy,
                                       .range = RatioRange,
                                       .classical = LibraryClassical,
                                       .say = LibrarySay};

const Problem ProblemRupture = {
  .name = "rupture", .meaning = "ruptures of small faults from a given stress", .cma = &CMARuptures};
