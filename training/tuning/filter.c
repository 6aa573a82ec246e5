/* See filter.h. All members of all generations run the same episodes at the same accuracies, so that the cost is a fixed
   function of seven numbers; a population is spread over the ranks. */
#include "filter.h"
#include "common/options.h"
#include <math.h>
#include <petsctime.h>
#include <slipblas.h>
#include <slipcompat.h>

#define TRAIN_STREAM 6000000 /* seeds that no training of policies has */
#define VALID_STREAM 7000000
#define GENERATION_STREAM 8000000

static uint64_t StreamSeed(PetscInt seed, PetscInt64 stream, PetscInt64 k)
{
  return (uint64_t)seed * 0x9e3779b97f4a7c15u + (uint64_t)(stream + k);
}

PetscErrorCode FilterOptionsSet(MPI_Comm comm, FilterOptions *o)
{
  const NumberOption row[] = {
    OPTION_INTEGER("-train_singles", "Episodes of one cell", &o->nsingle, 1, 100000),
    OPTION_INTEGER("-train_meshes", "Episodes on small heterogeneous meshes", &o->nmesh, 0, 100000),
    OPTION_INTEGER("-train_mesh_side", "Largest number of cells along a side of these meshes", &o->side, 2, 12),
    OPTION_INTEGER("-train_validation", "Other episodes of each kind, for the score at the end", &o->validation, 1,
                   100000),
    OPTION_INTEGER("-train_population", "Members of a generation, 0: CMA-ES's default", &o->population, 0, 10000),
    OPTION_INTEGER("-train_generations", "Generations", &o->generations, 1, 1e8),
    OPTION_INTEGER("-train_validation_interval", "Generations from one line of progress to the next", &o->interval, 1,
                   1e6),
    OPTION_INTEGER("-train_seed", "Seed of everything random", &o->seed, 0, PETSC_MAX_INT),
    OPTION_REAL("-train_sigma", "First step length of CMA-ES, in logarithms", &o->sigma, 1e-6, PETSC_MAX_REAL),
    OPTION_REAL("-train_minutes", "Wall time after which the tuning ends [min], 0: no limit", &o->minutes, 0,
                PETSC_MAX_REAL),
    OPTION_REAL("-train_dial_low", "Lowest accuracy", &o->low, TSADAPTRL_ACCURACY_MIN, PETSC_MAX_REAL),
    OPTION_REAL("-train_dial_high", "Highest accuracy", &o->high, TSADAPTRL_ACCURACY_MIN, PETSC_MAX_REAL)};

  PetscFunctionBegin;
  *o = (FilterOptions){.nsingle = 96,
                       .nmesh = 32,
                       .side = 5,
                       .validation = 64,
                       .population = 12,
                       .generations = 100,
                       .interval = 10,
                       .sigma = 0.3,
                       .low = 3e-3,
                       .high = TSADAPTRL_ACCURACY_MAX};
  PetscOptionsBegin(comm, NULL, "Tuning a digital filter by CMA-ES", "train");
  PetscCall(OptionsNumbers(PetscOptionsObject, PETSC_STATIC_ARRAY_LENGTH(row), row));
  PetscOptionsEnd();
  PetscCheck(o->low <= o->high && o->high <= TSADAPTRL_ACCURACY_MAX, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-train_dial_low is %.6g and -train_dial_high %.6g, expected them in order and at most %g", (double)o->low,
             (double)o->high, TSADAPTRL_ACCURACY_MAX);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The exponent of the error before may have either sign. */
void FilterOfNumbers(const double x[], TunedFilter *f)
{
  f->filter = (SlipFilter){.name = "tuned",
                           .g1 = exp(-x[0]),
                           .g2 = x[1] != 0 ? 1 / x[1] : (double)PETSC_INFINITY,
                           .kappa = x[2],
                           .r_min = 1 / (1 + exp(-x[3])),
                           .r_max = 1 + exp(x[4])};
  f->factor = exp(x[5]);
  f->power = exp(x[6]);
}

/* H211b4 with a wider cap, and rtol equal to the accuracy */
void FilterStart(double x[])
{
  const double start[FILTER_PARAMETERS] = {log(0.25), 0.25, 0.25, log(0.8 / 0.2), 0, 0, 0};

  for (int i = 0; i < FILTER_PARAMETERS; ++i) x[i] = start[i];
}

/* ---- episodes ---- */

typedef struct {
  PetscInt n, singles; /* single cells first */
  Episode **episode;   /* [n] */
  PetscReal *accuracy; /* [n] spread evenly over the logarithmic range; which episode has which is random as they are */
} FilterSet;

static PetscErrorCode SetCreate(const FilterOptions *o, PetscInt64 stream, PetscInt singles, PetscInt meshes,
                                FilterSet *set)
{
  PetscFunctionBegin;
  *set = (FilterSet){.n = singles + meshes, .singles = singles};
  PetscCall(PetscCalloc2(set->n, &set->episode, set->n, &set->accuracy));
  for (PetscInt i = 0; i < set->n; ++i) {
    const PetscInt k = i < singles ? i : i - singles, n = i < singles ? singles : meshes;

    PetscCall(EpisodeCreate(NULL, StreamSeed(o->seed, stream, i), i < singles ? 1 : o->side, &set->episode[i]));
    set->accuracy[i] = o->low * PetscPowReal(o->high / o->low, ((PetscReal)k + (PetscReal)0.5) / (PetscReal)n);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetDestroy(FilterSet *set)
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < set->n; ++i) PetscCall(EpisodeDestroy(&set->episode[i]));
  PetscCall(PetscFree2(set->episode, set->accuracy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Either kind counts by its mean. */
static PetscErrorCode Score(const FilterSet *set, const double x[], FilterScore *score)
{
  const PetscInt meshes = set->n - set->singles;
  const PetscReal kinds = meshes ? 2 : 1;
  TunedFilter f;
  EpisodeResult r;

  PetscFunctionBegin;
  *score = (FilterScore){0, 0, 0, 0};
  FilterOfNumbers(x, &f);
  for (PetscInt i = 0; i < set->n; ++i) {
    const PetscReal a = set->accuracy[i], share = 1 / (kinds * (PetscReal)(i < set->singles ? set->singles : meshes));

    PetscCall(EpisodeRunFilter(set->episode[i], &f.filter, f.factor * PetscPowReal(a, f.power), &r));
    score->cost += share * EpisodeCost(&r, a);
    score->solves += share * (PetscReal)r.solves;
    score->within += r.done >= 1 && r.error <= a ? share : 0;
    score->error += share * PetscLogReal(PetscMax(r.error, PETSC_SMALL) / a);
  }
  score->error = PetscExpReal(score->error);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the tuning ---- */

static PetscErrorCode Generation(MPI_Comm comm, const FilterOptions *o, const FilterSet *set, CMAES *es)
{
  PetscMPIInt rank, size;
  FilterScore score;
  Random random;
  double *x, *f;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  RandomSeed(&random, StreamSeed(o->seed, GENERATION_STREAM, es->generation));
  PetscCall(PetscMalloc2(es->n * es->lambda, &x, es->lambda, &f));
  PetscCall(CMAESAsk(es, &random, x));
  for (PetscInt k = 0; k < es->lambda; ++k) {
    f[k] = 0;
    if (k % size != rank) continue;
    PetscCall(Score(set, x + k * es->n, &score));
    f[k] = (double)score.cost;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, f, (PetscMPIInt)es->lambda, MPI_DOUBLE, MPI_SUM, comm));
  PetscCall(CMAESTell(es, x, f));
  PetscCall(PetscFree2(x, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Progress(MPI_Comm comm, PetscInt64 generation, const char what[], const FilterScore *s)
{
  PetscFunctionBegin;
  PetscCall(PetscPrintf(
    comm, "generation %4" PetscInt64_FMT "  %s: cost %7.4f  solves %5.1f  within %5.1f %%  error/accuracy %6.3f\n",
    generation, what, (double)s->cost, (double)s->solves, 100 * (double)s->within, (double)s->error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The same on every rank: whether wall time is left */
static PetscErrorCode TimeIsLeft(MPI_Comm comm, const FilterOptions *o, PetscLogDouble begin, PetscMPIInt *left)
{
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(PetscTime(&now));
  *left = o->minutes <= 0 || now - begin < 60 * (PetscLogDouble)o->minutes;
  PetscCallMPI(MPI_Bcast(left, 1, MPI_INT, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FilterTune(MPI_Comm comm, const FilterOptions *o, TunedFilter *best, FilterScore *score)
{
  double start[FILTER_PARAMETERS];
  PetscLogDouble begin;
  PetscMPIInt left = 1;
  FilterSet set;
  CMAES es;

  PetscFunctionBegin;
  SlipBLASSetNumThreads(1); /* the ranks have the cores already, and the order of sums stays */
  PetscCall(PetscTime(&begin));
  FilterStart(start);
  PetscCall(CMAESCreate(FILTER_PARAMETERS, o->population, start, (double)o->sigma, &es));
  PetscCall(SetCreate(o, TRAIN_STREAM, o->nsingle, o->nmesh, &set));
  while (left && es.generation < o->generations) {
    PetscCall(Generation(comm, o, &set, &es));
    PetscCall(TimeIsLeft(comm, o, begin, &left));
    if (left && es.generation % o->interval && es.generation < o->generations) continue;
    PetscCall(Score(&set, es.mean, score));
    PetscCall(Progress(comm, es.generation, "mean", score));
  }
  PetscCall(SetDestroy(&set));
  PetscCall(SetCreate(o, VALID_STREAM, o->validation, o->nmesh ? o->validation : 0, &set));
  PetscCall(Score(&set, start, score));
  PetscCall(Progress(comm, 0, "other episodes", score));
  PetscCall(Score(&set, es.mean, score));
  PetscCall(Progress(comm, es.generation, "other episodes", score));
  FilterOfNumbers(es.mean, best);
  PetscCall(SetDestroy(&set));
  PetscCall(CMAESDestroy(&es));
  PetscFunctionReturn(PETSC_SUCCESS);
}
