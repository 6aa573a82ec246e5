/* Episodes of the other problems of the table: instances of the environment, which runs them. */
#include "episodes.h"
#include <slipstep/private/slipcompat.h>

#define MAX_ATTEMPTS 1000

struct _EpisodeSmall {
  Environment env;
  EnvInstance instance;
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
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EpisodeSmallDestroy(EpisodeSmall *small)
{
  PetscFunctionBegin;
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

PetscErrorCode EpisodeSmallRun(EpisodeSmall small, SlipPolicy policy, PetscReal accuracy, EpisodeWatchFn fn, void *ctx,
                               EpisodeResult *result)
{
  Acting acting = {small->env.o.nobs, policy, fn, ctx};
  EnvResult r;

  PetscFunctionBegin;
  small->env.o.accuracy = accuracy;
  PetscCall(EnvRunInstance(&small->env, &small->instance, Act, &acting, &r));
  /* the larger of the errors at the ends of steps and between them, too */
  *result = (EpisodeResult){.solves = r.solves,
                            .failures = r.attempts - r.accepted,
                            .slip_error = PetscMax(r.error[0], r.error[1]),
                            .done = r.finished ? 1 : 0};
  PetscFunctionReturn(PETSC_SUCCESS);
}
