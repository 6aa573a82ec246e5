/* Implicit steps through cycles as a problem for CMA-ES: a network that begins as the elementary controller. */
#include "smooth.h"
#include "runs/libraryepisode.h"
#include "runs/ratiopolicy.h"
#include <slipcompat.h>

static const RatioRow Rows[] = {
  {SLIP_OBSERVES_ACCURACY, 1, 2, 0}, {"log_error_step", 1, 0, 1},     {"change_log_error_step", 1, 0, 0},
  {"log_step_ratio", 1, 0, 0},       {"rejected", 1, 0, 0},           {"log_step", 0.1, 0, 0},
  {"log_velocity", 0.1, 0, 0},       {"change_log_velocity", 1, 0, 0}};
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

static PetscErrorCode Create(const CMAOptions *o, uint64_t seed, void *e)
{
  (void)o;
  return SmoothEpisodeCreate(seed, (SmoothEpisode *)e);
}

static PetscErrorCode Destroy(void *e)
{
  return SmoothEpisodeDestroy((SmoothEpisode *)e);
}

static PetscErrorCode Run(void *episode, SlipPolicy policy, TSAdaptType type, PetscReal setting, EpisodeResult *r)
{
  SmoothEpisode *e = (SmoothEpisode *)episode;
  SmoothErrors errors;

  PetscFunctionBegin;
  PetscCall(SmoothEpisodeRun(e, policy, setting, type, setting, &r->solves, &r->failures, &errors, &r->error));
  r->attempts = r->solves;
  r->usual = (PetscReal)e->usual;
  r->errors[SLIP_ERROR_FINAL] = errors.moment;
  r->errors[SLIP_ERROR_SHIFT] = errors.onset;
  r->errors[SLIP_ERROR_FIELD] = errors.slip;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const LibraryEpisodes Episodes = {sizeof(SmoothEpisode), Create,     Destroy,    Run, .lost = 6,
                                         .free = 0.8,           .steep = 2, .worst = 50};

static const CMAProblem CMASmooth = {
  LIBRARY_EPISODES,    RATIO_FUNCTIONS,      .episodes = "faults",          .stream = 19,     .dial = CMA_DIAL_SPREAD,
  .network = &Network, .library = &Episodes, .classical = LibraryClassical, .say = LibrarySay};

const Problem ProblemSmooth = {.name = "smooth",
                               .meaning =
                                 "cycles of small rate-and-state faults by implicit steps, with inertia or without",
                               .cma = &CMASmooth};
