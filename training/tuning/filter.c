/* See filter.h. All members of all generations run the same episodes at the same accuracies, so that the cost is a
   fixed function of seven numbers; a population is spread over the ranks. */
#include "filter.h"
#include "common/options.h"
#include "cmaes/cmaloop.h"
#include "problems/episodes.h"
#include <math.h>
#include <slipcompat.h>

enum { TRAIN_STREAM = 6, VALID_STREAM, GENERATION_STREAM }; /* seeds that no training of policies has */

typedef struct {
  PetscInt nsingle, nmesh, side; /* episodes of one cell, of meshes; cells along a side */
  PetscInt validation;           /* other episodes of each kind */
  PetscInt population, generations, interval, seed;
  PetscReal sigma, minutes;
  PetscReal low, high; /* range of the accuracy */
} FilterOptions;

static PetscErrorCode OptionsSet(MPI_Comm comm, FilterOptions *o)
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
  PetscReal cost, solves, within, error; /* means; share of runs within the accuracy; geometric mean of error over it */
} FilterScore;

typedef struct {
  PetscInt n, singles; /* single cells first */
  Episode **episode;   /* [n] */
  PetscReal *accuracy; /* [n] spread evenly over the logarithmic range; which episode has which is random as they are */
} FilterSet;

static PetscErrorCode SetCreate(const FilterOptions *o, PetscInt stream, PetscInt singles, PetscInt meshes,
                                FilterSet *set)
{
  PetscFunctionBegin;
  *set = (FilterSet){.n = singles + meshes, .singles = singles};
  PetscCall(PetscCalloc2(set->n, &set->episode, set->n, &set->accuracy));
  for (PetscInt i = 0; i < set->n; ++i) {
    const PetscInt k = i < singles ? i : i - singles, n = i < singles ? singles : meshes;

    PetscCall(EpisodeCreate(NULL, RandomStream(o->seed, stream, i), i < singles ? 1 : o->side, &set->episode[i]));
    set->accuracy[i] = o->low * PetscPowReal(o->high / o->low, ((PetscReal)k + (PetscReal)0.5) / (PetscReal)n);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetDestroy(FilterSet *set)
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < set->n; ++i) PetscCall(EpisodeDestroy((void **)&set->episode[i]));
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

typedef struct {
  CMALoop loop;
  FilterSet set;
  FilterOptions o;
  double start[FILTER_PARAMETERS];
} Tuning;

static PetscErrorCode Cost(const double x[], void *ctx, double *cost)
{
  FilterScore score;

  PetscFunctionBegin;
  PetscCall(Score(&((Tuning *)ctx)->set, x, &score));
  *cost = (double)score.cost;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Say(const Tuning *t, PetscInt64 generation, const char what[], const double x[])
{
  FilterScore s;

  PetscFunctionBegin;
  PetscCall(Score(&t->set, x, &s));
  PetscCall(PetscPrintf(t->loop.comm,
                        "generation %4" PetscInt64_FMT
                        "  %s: cost %7.4f  solves %5.1f  within %5.1f %%  error/accuracy %6.3f\n",
                        generation, what, (double)s.cost, (double)s.solves, 100 * (double)s.within, (double)s.error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Validate(void *ctx)
{
  const Tuning *t = (const Tuning *)ctx;

  return Say(t, t->loop.es.generation, "mean", t->loop.es.mean);
}

/* Start and end on other episodes, and the options that make `pi` the tuned filter, at any accuracy */
static PetscErrorCode Finish(void *ctx)
{
  Tuning *t = (Tuning *)ctx;
  TunedFilter best;

  PetscFunctionBegin;
  PetscCall(SetDestroy(&t->set));
  PetscCall(SetCreate(&t->o, VALID_STREAM, t->o.validation, t->o.nmesh ? t->o.validation : 0, &t->set));
  PetscCall(Say(t, 0, "other episodes", t->start));
  PetscCall(Say(t, t->loop.es.generation, "other episodes", t->loop.es.mean));
  FilterOfNumbers(t->loop.es.mean, &best);
  PetscCall(PetscPrintf(t->loop.comm,
                        "-ts_adapt_type pi -ts_adapt_pi_g1 %.4g -ts_adapt_pi_g2 %.4g -ts_adapt_pi_kappa %.4g "
                        "-ts_adapt_pi_ratio_min %.4g -ts_adapt_pi_ratio_max %.4g\n"
                        "-ts_rtol %.4g a^%.4g for an accuracy a\n",
                        (double)best.filter.g1, (double)best.filter.g2, (double)best.filter.kappa,
                        (double)best.filter.r_min, (double)best.filter.r_max, (double)best.factor, (double)best.power));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FilterTune(MPI_Comm comm, PetscInt *failed)
{
  static const CMALoopOps ops = {NULL, Cost, Validate, Finish};
  PetscBool only_help;
  Tuning t;

  PetscFunctionBegin;
  (void)failed;
  PetscCall(OptionsSet(comm, &t.o));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  if (only_help) PetscFunctionReturn(PETSC_SUCCESS);
  t.loop = (CMALoop){.generations = t.o.generations,
                     .interval = t.o.interval,
                     .minutes = t.o.minutes,
                     .seed = RandomStream,
                     .seeds = t.o.seed,
                     .stream = GENERATION_STREAM};
  FilterStart(t.start);
  PetscCall(CMALoopCreate(comm, FILTER_PARAMETERS, t.o.population, t.start, (double)t.o.sigma, &t.loop));
  PetscCall(SetCreate(&t.o, TRAIN_STREAM, t.o.nsingle, t.o.nmesh, &t.set));
  PetscCall(CMALoopRun(&t.loop, &ops, &t));
  PetscCall(SetDestroy(&t.set));
  PetscCall(CMALoopDestroy(&t.loop));
  PetscFunctionReturn(PETSC_SUCCESS);
}
