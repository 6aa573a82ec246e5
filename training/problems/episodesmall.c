/* Episodes of the other problems of the table: instances of the environment, which runs them, or the same without
   objects. */
#include "episodes.h"
#include "environment/plainsmall.h"
#include <slipstep/rooms/slipmodels.h>
#include <slipcompat.h>

#define MAX_ATTEMPTS 3000

struct _EpisodeSmall {
  Environment env;
  EnvInstance instance;
  EnvRun run; /* at its start */
  PlainSmall plain;
};

/* The same system without objects: the model must live as long. */
PetscErrorCode EpisodeSmallCreate(const EnvOptions *o, uint64_t seed, EpisodeSmall *episode)
{
  PetscReal J[SLIP_MODEL_STATES * SLIP_MODEL_STATES] = {0};
  EpisodeSmall small;
  PlainSmall *p;
  SlipModel model;
  Random random;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(PetscNew(&small));
  *episode = small;
  PetscCall(EnvCreate(o, &small->env));
  small->env.o.max_steps = MAX_ATTEMPTS;
  RandomSeed(&random, seed);
  PetscCall(EnvInstanceCreate(&small->env.o, &random, PETSC_TRUE, &small->instance));
  PetscCall(o->problem->create(&small->env.o, &small->instance, &small->run));
  model = (SlipModel)small->run.model;
  p = &small->plain;
  *p = (PlainSmall){.n = model->ops->n,
                    .q = model->bound,
                    .tstar = small->run.tstar,
                    .tmax = small->run.tmax,
                    .model = model,
                    .force = model->ops->load};
  PetscCall((*model->ops->jacobian)(0, model->start, J, model));
  for (PetscInt i = 0; i < p->n; ++i) {
    p->A[i] = model->mass[i];
    p->start[i] = model->start[i];
    for (PetscInt j = 0; j < p->n; ++j) p->G[i][j] = J[i * p->n + j];
  }
  PetscCall(TSGetAdapt(small->run.ts, &adapt));
  PetscCall(TSAdaptGetStepLimits(adapt, &p->dt_low, &p->dt_high));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EpisodeSmallDestroy(void **episode)
{
  EpisodeSmall small = (EpisodeSmall)*episode;

  PetscFunctionBegin;
  PetscCall(small->env.o.problem->destroy(&small->run));
  PetscCall(EnvInstanceDestroy(&small->env.o, &small->instance));
  PetscCall(PetscFree(*episode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

typedef struct {
  PetscInt n;
  SlipPolicy policy;
  EpisodeWatchFn fn;
  void *ctx;
} Acting;

/* EnvActorFn. The environment does not scale observations here: the policy does. */
static PetscErrorCode Act(const EnvMoment *moment, PetscReal *action, PetscBool *stop, void *ctx)
{
  const Acting *a = (const Acting *)ctx;

  PetscFunctionBegin;
  (void)stop;
  if (a->fn) a->fn(a->n, moment->obs, a->ctx);
  PetscCall(SlipPolicyEvaluate(a->policy, moment->obs, action, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The larger of the errors at the ends of steps and between them, too */
static EpisodeResult Conclude(PetscInt solves, PetscInt failures, const PetscReal error[2], PetscBool finished)
{
  return (EpisodeResult){.solves = solves,
                         .attempts = solves,
                         .failures = failures,
                         .error = PetscMax(error[0], error[1]),
                         .done = finished ? 1 : 0};
}

PetscErrorCode EpisodeSmallRunLibrary(EpisodeSmall small, SlipPolicy policy, PetscReal accuracy, EpisodeWatchFn fn,
                                      void *ctx, EpisodeResult *result)
{
  Acting acting = {small->env.o.nobs, policy, fn, ctx};
  EnvResult r;

  PetscFunctionBegin;
  small->env.o.accuracy = accuracy;
  PetscCall(EnvRunInstance(&small->env, &small->instance, Act, &acting, &r));
  *result = Conclude(r.solves, r.attempts - r.accepted, r.error, r.finished);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EpisodeSmallRun(EpisodeSmall small, SlipPolicy policy, PetscReal accuracy, EpisodeWatchFn fn, void *ctx,
                               EpisodeResult *result)
{
  PlainSmallResult r;
  PlainPolicy p;
  PetscBool known;

  PetscFunctionBegin;
  PetscCall(PlainPolicyStart(policy, small->plain.model, &p, &known));
  if (known) {
    PetscCall(PlainSmallRun(&small->plain, &p, accuracy, small->instance.reference, MAX_ATTEMPTS, fn, ctx, &r));
    *result = Conclude(r.steps, 0, r.error, r.finished);
  } else
    PetscCall(EpisodeSmallRunLibrary(small, policy, accuracy, fn, ctx, result));
  result->cost = EpisodeCost(result, accuracy);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- for CMA-ES ---- */

static PetscErrorCode SetUpTraining(CMAOptions *o)
{
  const Preset *preset = ProblemPreset(o->problem, "dial");

  PetscFunctionBegin;
  *o = (CMAOptions){.problem = o->problem,
                    .hidden = 8,
                    CMA_DIAL_DEFAULTS,
                    .dt_min = preset->dt_min,
                    .dt_max = preset->dt_max,
                    .nsingle = 256,
                    .batch_single = 48,
                    .late_single = 48,
                    .validation = 60,
                    .calibration = 75,
                    .population = 16,
                    .diagonal = 200,
                    .generations = 1500,
                    .interval = 50,
                    .low = TSADAPTRL_ACCURACY_MIN};
  PetscCall(PetscStrncpy(o->dt_max_unit, preset->dt_max_unit, sizeof(o->dt_max_unit)));
  PetscCall(CMAObservationsSet(o, preset->names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CreateForCMA(const CMAOptions *o, uint64_t seed, PetscInt side, void **episode)
{
  EnvOptions e = {.problem = o->problem,
                  .log_spacing = PETSC_TRUE,
                  .continuation = 1. / 12,
                  .rtol = o->problem->rtol,
                  .atol = o->problem->atol,
                  .dt_min = o->dt_min,
                  .dt_max = o->dt_max,
                  .dt_min_unit = "T*",
                  .nobs = o->nobs};

  PetscFunctionBegin;
  (void)side;
  PetscCheck(o->nobs <= ENV_MAX_OBS, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "-train_observations has %" PetscInt_FMT " names, expected %d at most for %s", o->nobs, ENV_MAX_OBS,
             o->problem->name);
  PetscCall(PetscStrncpy(e.dt_max_unit, o->dt_max_unit, sizeof(e.dt_max_unit)));
  for (PetscInt i = 0; i < e.nobs; ++i) { /* unscaled: the policy does that */
    e.names[i] = o->names[i];
    e.scale[i] = 1;
  }
  PetscCall(EpisodeSmallCreate(&e, seed, (EpisodeSmall *)episode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RunForCMA(void *episode, SlipPolicy policy, PetscReal accuracy, EpisodeResult *result)
{
  return EpisodeSmallRun((EpisodeSmall)episode, policy, accuracy, NULL, NULL, result);
}

static PetscErrorCode WatchForCMA(void *episode, SlipPolicy policy, PetscReal accuracy, EpisodeWatchFn fn, void *ctx)
{
  EpisodeResult result;

  return EpisodeSmallRun((EpisodeSmall)episode, policy, accuracy, fn, ctx, &result);
}

const CMAProblem CMASmall = {
  CMA_DIAL,         .setup = SetUpTraining, .create = CreateForCMA, .destroy = EpisodeSmallDestroy,
  .run = RunForCMA, .watch = WatchForCMA};
