/* Faults drawn at random, single cells and small meshes, as problems for CMA-ES: by implicit steps, and by steps that
   may be explicit. */
#include "episodes.h"
#include <slipcompat.h>

static const char *const Names[] = {"log_accuracy",
                                    "log_growth_time",
                                    "growth_rate",
                                    "start_growth_rate",
                                    "log_mode_rate",
                                    "log_push",
                                    "phase",
                                    "progress",
                                    "weakening",
                                    "damping_ratio",
                                    "log_step",
                                    "change_log_mode_rate",
                                    "log_slip_error",
                                    "seen_growth",
                                    "sliding_fraction",
                                    "log_peak_ratio",
                                    "log_step_limit",
                                    "log_solve_cost"};
enum { NAMES = PETSC_STATIC_ARRAY_LENGTH(Names), OF_PRODUCTS = 2 }; /* the last ones are observed by these alone */

#define DIAL_LOW 1e-3 /* finer accuracies of the whole history take hundreds of steps */

static PetscErrorCode SetUpTraining(CMAOptions *o)
{
  const char *names[NAMES + 1] = {NULL};
  const PetscInt n = o->problem == &ProblemProducts ? NAMES : NAMES - OF_PRODUCTS;

  PetscFunctionBegin;
  *o = (CMAOptions){.problem = o->problem,
                    .family = o->family,
                    .hidden = 12,
                    CMA_DIAL_DEFAULTS,
                    .dt_min = 1e-2,
                    .dt_max = 1e2,
                    .moving = 30,
                    .dt_max_unit = "T*",
                    .nsingle = 400,
                    .nmesh = 200,
                    .batch_single = 24,
                    .batch_mesh = 20,
                    .late_generations = 800,
                    .late_single = 90,
                    .late_mesh = 60,
                    .validation = 60,
                    .calibration = 100,
                    .population = 24,
                    .diagonal = 200,
                    .generations = 2600,
                    .interval = 50,
                    .low = DIAL_LOW};
  PetscCall(PetscArraycpy(names, Names, n));
  PetscCall(CMAObservationsSet(o, names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CreateForCMA(const CMAOptions *o, uint64_t seed, PetscInt side, void **episode)
{
  return EpisodeCreate(o->family, seed, side, (Episode **)episode);
}

const CMAProblem CMAFault = {CMA_DIAL,
                             .kinds = PETSC_TRUE,
                             .measure = "history",
                             .setup = SetUpTraining,
                             .create = CreateForCMA,
                             .destroy = EpisodeDestroy,
                             .run = EpisodeRun,
                             .classical = EpisodeRunClassical,
                             .watch = EpisodeWatch};

/* ---- likewise, with steps that may be explicit ---- */

static PetscErrorCode CreateProducts(const CMAOptions *o, uint64_t seed, PetscInt side, void **episode)
{
  return EpisodeCreateProducts(o->family, seed, side, (Episode **)episode);
}

static const CMAProblem CMAProducts = {CMA_DIAL,
                                       .kinds = PETSC_TRUE,
                                       .measure = "history",
                                       .setup = SetUpTraining,
                                       .create = CreateProducts,
                                       .destroy = EpisodeDestroy,
                                       .run = EpisodeRunProducts};

const Problem ProblemProducts = {.name = "fault_products",
                                 .meaning =
                                   "the faults of fault_dial, in steps that are explicit or implicit, as takes "
                                   "fewer products with stiffness and viscosity",
                                 .cma = &CMAProducts};

const Problem ProblemDial = {.name = "fault_dial",
                             .policy_problem = "fault",
                             .meaning =
                               "faults drawn as by -train_algorithm cmaes, at a random position of the accuracy dial",
                             .cma = &CMAFault};
