/* Segments of sequences of events as a problem for CMA-ES: a network that begins as a digital filter. */
#include "sequences.h"
#include "runs/libraryepisode.h"
#include "runs/ratiopolicy.h"
#include "common/files.h"
#include <slipcompat.h>

/* The unit that is PI42 about estimates of 0.06, at tolerances so much looser than those at which dsp keeps the dial: its equal at the
   start, with room for estimates that are larger where they do no harm */
#define PROPORTIONAL 0.4
#define CHANGE 0.2
#define TARGET (-0.163) /* 0.4 log10(0.06^(1/3)) */
#define RTOL_START 1e-2 /* tolerance at the dial 1e-2 */
#define RTOL_POWER 0.87

static const RatioRow Rows[] = {{SLIP_OBSERVES_ACCURACY, 1, 2, 0},
                                {"log_error_step", 1, 0, PROPORTIONAL},
                                {"log_step_ratio", 1, 0, 0},
                                {"rejected", 1, 0, 0},
                                {"sliding_fraction", 1, 0, 0},
                                {"change_sliding_fraction", 2, 0, 0},
                                {"log_step", 0.1, -0.4, 0},
                                {"log_velocity", 0.1, 0.4, 0},
                                {"change_log_velocity", 1, 0, 0},
                                {"log_peak_ratio", 1, -0.5, 0},
                                {"growth", 0.3, 0, 0},
                                {"change_log_error_step", 1, 0, CHANGE}};
static const CMAOptions Defaults = {.nsingle = 48,
                                    .batch_single = 20,
                                    .population = 16,
                                    .validation = 12,
                                    .calibration = 64,
                                    .diagonal = 100000000, /* always */
                                    .generations = 60,
                                    .sigma = 0.08};
static const RatioNetwork Network = {.defaults = &Defaults,
                                     .rows = PETSC_STATIC_ARRAY_LENGTH(Rows),
                                     .units = 4,
                                     .row = Rows,
                                     .bias = TARGET,
                                     .dial = {3e-3, 1e-1},
                                     .unit = 1e-2,
                                     .rtol = RTOL_START,
                                     .power = RTOL_POWER};

static PetscErrorCode Policy(const CMAOptions *o, const double w[], SlipPolicy policy)
{
  PetscFunctionBegin;
  PetscCall(RatioPolicy(o, w, policy));
  PetscCall(PolicySetNumber(policy, SLIP_POLICY_HOLD, "%.6g", 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Create(const CMAOptions *o, uint64_t seed, void *e)
{
  (void)o;
  return SegmentEpisodeCreate(seed, 0, (SegmentEpisode *)e);
}

static PetscErrorCode Destroy(void *e)
{
  return SegmentEpisodeDestroy((SegmentEpisode *)e);
}

static PetscErrorCode Run(void *episode, SlipPolicy policy, TSAdaptType type, PetscReal setting, EpisodeResult *r)
{
  SegmentEpisode *e = (SegmentEpisode *)episode;
  PetscReal errors[SEGMENT_NUM_ERRORS];

  PetscFunctionBegin;
  PetscCall(SegmentEpisodeRun(e, policy, setting, type, setting, &r->solves, &r->failures, errors, &r->error));
  r->attempts = r->solves;
  r->usual = (PetscReal)e->usual;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const LibraryEpisodes Episodes = {
  sizeof(SegmentEpisode), Create, Destroy, Run, .lost = 2, .free = 0.7, .steep = 1, .worst = 4};

static const CMAProblem CMASequences = {LIBRARY_EPISODES,        .episodes = "segments",        .stream = 11,
                                        .dial = CMA_DIAL_SPREAD, .setup = RatioSetUp,           .start = RatioStart,
                                        .policy = Policy,        .range = RatioRange,           .network = &Network,
                                        .library = &Episodes,    .classical = LibraryClassical, .say = LibrarySay};

const Problem ProblemSequence = {
  .name = "sequence", .meaning = "segments of sequences of events of small faults", .cma = &CMASequences};
