/* Segments of sequences of events as a problem for CMA-ES: a network that begins as the elementary controller. */
#include "sequences.h"
#include "environment/libraryepisode.h"
#include "environment/ratiopolicy.h"
#include <slipcompat.h>

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
                                     .bias = RATIO_SAFETY,
                                     .dial = {3e-3, 1e-1},
                                     .unit = 1e-2,
                                     .rtol = 2e-2,
                                     .power = 1};

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
  sizeof(SegmentEpisode), Create, Destroy, Run, .lost = 4, .free = 0.7, .steep = 1, .worst = 50};

static const CMAProblem CMASequences = {
  LIBRARY_EPISODES,    RATIO_FUNCTIONS,      .episodes = "segments",        .stream = 11,     .dial = CMA_DIAL_SPREAD,
  .network = &Network, .library = &Episodes, .classical = LibraryClassical, .say = LibrarySay};

const Problem ProblemSequence = {
  .name = "sequence", .meaning = "segments of sequences of events of small faults", .cma = &CMASequences};
