/* Episodes of the other problems of the table: instances of the environment, which runs them, or the same without
   objects. */
#include "episodes.h"
#include "environment/plainrows.h"
#include "problemsmall.h"
#include <slipcompat.h>

#define MAX_ATTEMPTS 3000

struct _EpisodeSmall {
  Environment env;
  EnvInstance instance;
  EnvRun run; /* at its start */
  PlainSmall plain;
};

PetscErrorCode EpisodeCreateSmall(const EnvOptions *o, uint64_t seed, Episode **episode)
{
  EpisodeSmall small;
  Random random;

  PetscFunctionBegin;
  PetscCall(PetscNew(episode));
  PetscCall(PetscNew(&small));
  (*episode)->small = small;
  PetscCall(EnvCreate(o, &small->env));
  small->env.o.max_steps = MAX_ATTEMPTS;
  RandomSeed(&random, seed);
  PetscCall(EnvInstanceCreate(&small->env.o, &random, PETSC_TRUE, &small->instance));
  PetscCall(o->problem->create(&small->env.o, &small->instance, &small->run));
  small->run.problem = o->problem;
  PetscCall(ProblemSmallPlain(&small->run, &small->plain));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EpisodeSmallDestroy(EpisodeSmall *small)
{
  PetscFunctionBegin;
  PetscCall((*small)->env.o.problem->destroy(&(*small)->run));
  PetscCall(EnvInstanceDestroy(&(*small)->env.o, &(*small)->instance));
  PetscCall(PetscFree(*small));
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
  return (EpisodeResult){
    .solves = solves, .failures = failures, .error = PetscMax(error[0], error[1]), .done = finished ? 1 : 0};
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
  SlipObserved row[PLAIN_MAX_ROWS];
  PetscInt n;
  PetscBool known;

  PetscFunctionBegin;
  PetscCall(PlainRowsFind(policy, small->plain.model, &n, row, &known));
  if (!known) {
    PetscCall(EpisodeSmallRunLibrary(small, policy, accuracy, fn, ctx, result));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PlainSmallRun(&small->plain, policy, accuracy, small->instance.reference, MAX_ATTEMPTS, fn, ctx, &r));
  *result = Conclude(r.steps, 0, r.error, r.finished);
  PetscFunctionReturn(PETSC_SUCCESS);
}
