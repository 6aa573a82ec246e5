/* Slip under a pore pressure as a problem for CMA-ES: a network that begins as the elementary controller. */
#include "injections.h"
#include "runs/libraryepisode.h"
#include "runs/ratiopolicy.h"
#include <slipcompat.h>

static const RatioRow Rows[] = {{SLIP_OBSERVES_ACCURACY, 1, 2, 0}, {"log_error_step", 1, 0, 1},
                                {"log_step_ratio", 1, 0, 0},       {"rejected", 1, 0, 0},
                                {"sliding_fraction", 1, 0, 0},     {"change_sliding_fraction", 2, 0, 0},
                                {"time_fraction", 2, -1, 0},       {"log_step_share", 0.5, 1, 0},
                                {"log_step_past", 0.5, 0.5, 0},    {"log_velocity", 0.2, 1, 0},
                                {"change_log_velocity", 1, 0, 0}};
static const CMAOptions Defaults = {.nsingle = 40,
                                    .batch_single = 16,
                                    .validation = 8,
                                    .calibration = 24,
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
                                     .rtol = 5e-3,
                                     .power = 2};

static PetscErrorCode Create(const CMAOptions *o, uint64_t seed, void *e)
{
  (void)o;
  return InjectionEpisodeCreate(seed, (InjectionEpisode *)e);
}

static PetscErrorCode Destroy(void *e)
{
  return InjectionEpisodeDestroy((InjectionEpisode *)e);
}

static PetscErrorCode Run(void *episode, SlipPolicy policy, TSAdaptType type, PetscReal setting, EpisodeResult *r)
{
  InjectionEpisode *e = (InjectionEpisode *)episode;
  InjectionErrors errors;

  PetscFunctionBegin;
  PetscCall(InjectionEpisodeRun(e, policy, setting, type, setting, &r->solves, &r->failures, &errors, &r->error));
  r->attempts = r->solves;
  r->usual = (PetscReal)e->usual;
  r->errors[SLIP_ERROR_HISTORY] = errors.course;
  r->errors[SLIP_ERROR_SHIFT] = errors.front;
  r->errors[SLIP_ERROR_FIELD] = errors.field;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const LibraryEpisodes Episodes = {
  sizeof(InjectionEpisode), Create, Destroy, Run, .lost = 6, .free = 0.8, .steep = 2, .worst = 50};

static const CMAProblem CMAInjections = {
  LIBRARY_EPISODES,    RATIO_FUNCTIONS,      .episodes = "faults",          .stream = 15,     .dial = CMA_DIAL_SPREAD,
  .network = &Network, .library = &Episodes, .classical = LibraryClassical, .say = LibrarySay};

const Problem ProblemInjection = {
  .name = "injection", .meaning = "small faults that slip under a pore pressure", .cma = &CMAInjections};
