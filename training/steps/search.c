/* See steps.h. CMA-ES on the logarithms of the steps. The landscape is rough, so several searches begin at other
   places. */
#include "steps.h"
#include <slipcompat.h>
#include <math.h>

#define FAILED 10      /* error of steps that fail or do not get to the end */
#define SIGMA 0.25     /* of ln(step) */
#define SPREAD 0.5     /* of starts that are drawn */
#define REST_TAIL 1.05 /* a start's steps end a little after the reference rests */

/* One search: the best steps so far */
typedef struct {
  Episode *episode;
  PetscInt n;
  double *best, error; /* [n] */
} Search;

/* CMAESFn: the error of the steps exp(x) */
static PetscErrorCode Error(const double x[], void *ctx, double *error)
{
  Search *s = (Search *)ctx;
  double dt[EPISODE_MAX_STEPS];
  EpisodeResult r;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < s->n; ++i) dt[i] = exp(x[i]);
  PetscCall(EpisodeRunSteps(s->episode, s->n, dt, &r));
  *error = r.done < 1 || isnan(r.error) ? FAILED * (2 - r.done) : r.error;
  if (*error >= s->error) PetscFunctionReturn(PETSC_SUCCESS);
  s->error = *error;
  PetscCall(PetscArraycpy(s->best, x, s->n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The plan for one step less, one of whose steps is halved, and noise; or steps drawn about equal ones */
static void Start(const Episode *e, const StepsPlan *fewer, PetscInt k, Random *random, PetscInt n, double x[])
{
  const PetscReal span = REST_TAIL * (e->rest > 0 ? e->rest : e->tmax);

  if (fewer && fewer->n == n - 1 && n > 1 && k % 2 == 0) {
    const PetscInt halved = (PetscInt)RandomIndex(random, (uint64_t)fewer->n);

    for (PetscInt i = 0; i < n; ++i) x[i] = fewer->log_step[i > halved ? i - 1 : i];
    x[halved] -= log(2);
    x[halved + 1] -= log(2);
  } else {
    for (PetscInt i = 0; i < n; ++i) x[i] = log((double)span / (double)n) + SPREAD * RandomNormal(random);
  }
}

static PetscErrorCode SearchOnce(const StepsOptions *o, Episode *e, const StepsPlan *fewer, PetscInt k, PetscInt n,
                                 double best[], double *error)
{
  Search search = {e, n, best, PETSC_MAX_REAL};
  double *start;
  Random random;
  CMAES es;

  PetscFunctionBegin;
  RandomSeed(&random, ((uint64_t)o->seed << 32) + ((uint64_t)n << 16) + (uint64_t)k);
  PetscCall(PetscMalloc1(n, &start));
  Start(e, fewer, k, &random, n, start);
  PetscCall(CMAESCreate(n, o->population, start, SIGMA, &es));
  PetscCall(PetscFree(start));
  for (PetscInt g = 0; g < o->generations; ++g)
    PetscCall(CMAESGeneration(&es, PETSC_COMM_SELF, &random, Error, &search, NULL, NULL));
  *error = search.error;
  PetscCall(CMAESDestroy(&es));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StepsSearch(MPI_Comm comm, const StepsOptions *o, Episode *e, const StepsPlan *fewer, StepsPlan *plan)
{
  const PetscInt n = plan->n;
  double *x, *error;
  PetscInt best = 0;
  PetscMPIInt rank, size;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscCalloc2(n * o->restarts, &x, o->restarts, &error));
  for (PetscInt k = rank; k < o->restarts; k += size) PetscCall(SearchOnce(o, e, fewer, k, n, x + k * n, &error[k]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, x, (PetscMPIInt)(n * o->restarts), MPI_DOUBLE, MPI_SUM, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, error, (PetscMPIInt)o->restarts, MPI_DOUBLE, MPI_SUM, comm));
  for (PetscInt k = 1; k < o->restarts; ++k)
    if (error[k] < error[best]) best = k;
  plan->error = error[best];
  PetscCall(PetscArraycpy(plan->log_step, x + best * n, n));
  PetscCall(PetscFree2(x, error));
  PetscFunctionReturn(PETSC_SUCCESS);
}
