/* Training of the general policy by CMA-ES: a small network that begins as a digital filter. Every rank holds the same
   episodes; members of a population are spread over the ranks, so that results do not depend on their number. */
#include "ode.h"
#include "cmaes/cmaes.h"
#include "common/files.h"
#include "common/options.h"
#include "common/rowblas.h"
#include <slipcompat.h>
#include <petsctime.h>
#include <math.h>

#define NEAR_LINEAR 0.3 /* slope of the tanh unit that is the filter at first */
#define RATIO_MAX 10    /* of steps, as basic's limits */

enum { TRAIN_STREAM, VALID_STREAM, GENERATION_STREAM };

/* What is observed, its scaling for the network, and the filter at the start: a PI controller whose exponents are those of
   Hairer and Wanner (II, p. 31), 0.7 and -0.4 times q: 0.3 of the error's step and 0.4 of its change. */
static const struct {
  const char *name;
  double scale, filter;
} Rows[] = {{"log_error_step", 3, 0.3}, {"change_log_error_step", 3, 0.4},
            {"log_step_ratio", 3, 0},   {"change_log_step_ratio", 3, 0},
            {"rejected", 1, -0.1},      {"rejections", 3, 0},
            {"order", 0.25, 0}};
enum { ROWS = PETSC_STATIC_ARRAY_LENGTH(Rows) };
#define FILTER_BIAS (-0.03) /* log10 of the safety factor */

typedef struct {
  PetscInt hidden, episodes, batch, validation, population, diagonal, generations, interval, seed;
  PetscReal sigma, minutes;
  char output[PETSC_MAX_PATH_LEN];
} OdeOptions;

typedef struct {
  OdeOptions o;
  MPI_Comm comm;
  PetscMPIInt rank, size;
  OdeEpisode *train, *valid;
  CMAES es;
  double *best, cost; /* the mean with the best validation, and that */
  PetscInt best_generation;
  PetscInt64 runs;
} OdeTrainer;

static PetscInt CountWeights(PetscInt hidden)
{
  return (ROWS + 2) * hidden + 1;
}

static void Start(PetscInt hidden, double w[])
{
  double *bias = w + ROWS * hidden;

  for (PetscInt i = 0; i < CountWeights(hidden); ++i) w[i] = 0;
  for (PetscInt i = 0; i < ROWS; ++i) w[i] = NEAR_LINEAR * Rows[i].filter / Rows[i].scale;
  bias[0] = NEAR_LINEAR * FILTER_BIAS;
  bias[hidden] = 1 / NEAR_LINEAR;
}

static PetscErrorCode Policy(PetscInt hidden, const double w[], SlipPolicy *policy)
{
  const char *names[ROWS];
  PetscReal scale[ROWS], offset[ROWS];
  const double *out = w + (ROWS + 1) * hidden;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < ROWS; ++i) {
    names[i] = Rows[i].name;
    scale[i] = Rows[i].scale;
    offset[i] = 0;
  }
  PetscCall(SlipPolicyCreate(PETSC_COMM_SELF, policy));
  PetscCall(SlipPolicySetObservations(*policy, ROWS, names, scale, offset));
  PetscCall(SlipPolicyAddLayer(*policy, ROWS, hidden, w, w + ROWS * hidden, SLIP_ACTIVATION_TANH));
  PetscCall(SlipPolicyAddLayer(*policy, hidden, 1, out, out + hidden, SLIP_ACTIVATION_LINEAR));
  PetscCall(SlipPolicySetAction(*policy, -1, 1, (PetscReal)1 / RATIO_MAX, "h", RATIO_MAX, "h", PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- options ---- */

static PetscErrorCode OptionsSet(MPI_Comm comm, OdeOptions *o)
{
  const NumberOption row[] = {
    OPTION_INTEGER("-train_hidden", "Width of the hidden layer; 1: little more than a filter", &o->hidden, 1, 256),
    OPTION_INTEGER("-train_episodes", "Equations of the training", &o->episodes, 1, 100000),
    OPTION_INTEGER("-train_batch", "Equations of a generation", &o->batch, 1, 100000),
    OPTION_INTEGER("-train_validation", "Equations of a validation", &o->validation, 1, 100000),
    OPTION_INTEGER("-train_population", "Members of a generation, 0: 4 + 3 ln(weights)", &o->population, 0, 10000),
    OPTION_INTEGER("-train_diagonal", "Generations before the covariance may leave its diagonal", &o->diagonal, 0, 1e8),
    OPTION_INTEGER("-train_generations", "Generations", &o->generations, 1, 1e8),
    OPTION_INTEGER("-train_validation_interval", "Generations between validations; the best mean is written",
                   &o->interval, 1, 1e6),
    OPTION_INTEGER("-train_seed", "Seed of everything random", &o->seed, 0, PETSC_MAX_INT),
    OPTION_REAL("-train_sigma", "First step length of CMA-ES, in weights", &o->sigma, 1e-6, PETSC_MAX_REAL),
    OPTION_REAL("-train_minutes", "Wall time after which training ends [min], 0: no limit", &o->minutes, 0,
                PETSC_MAX_REAL)};

  PetscFunctionBegin;
  *o = (OdeOptions){.hidden = 8,
                    .episodes = 480,
                    .batch = 128,
                    .validation = 240,
                    .population = 20,
                    .diagonal = 40,
                    .generations = 240,
                    .interval = 20,
                    .sigma = 0.06};
  PetscOptionsBegin(comm, NULL, "Training the general policy by CMA-ES", "train");
  PetscCall(OptionsNumbers(PetscOptionsObject, PETSC_STATIC_ARRAY_LENGTH(row), row));
  PetscCall(
    PetscOptionsString("-train_output", "Policy to write (HDF5)", NULL, o->output, o->output, sizeof(o->output), NULL));
  PetscOptionsEnd();
  PetscCall(TrainCheckFiles(comm, o->output, "", ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- costs ---- */

static uint64_t StreamSeed(PetscInt seed, PetscInt stream, PetscInt i)
{
  Random r;

  RandomSeed(&r, ((uint64_t)seed << 34) + ((uint64_t)stream << 32) + (uint64_t)i);
  return r.s[0];
}

static PetscErrorCode Cost(const OdeEpisode *e, SlipPolicy policy, double *cost)
{
  OdeResult r;

  PetscFunctionBegin;
  PetscCall(OdeEpisodeRun(e, policy, e->tol, &r));
  *cost = OdeEpisodeCost(e, &r);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The same equations for every member: only differences between members count. */
static PetscErrorCode Generation(OdeTrainer *t, PetscInt generation)
{
  CMAES *es = &t->es;
  PetscInt *deck;
  double *x, *f;
  Random random;

  PetscFunctionBegin;
  RandomSeed(&random, StreamSeed(t->o.seed, GENERATION_STREAM, generation));
  PetscCall(PetscMalloc3(t->o.episodes, &deck, es->n * es->lambda, &x, es->lambda, &f));
  for (PetscInt i = 0; i < t->o.episodes; ++i) deck[i] = i;
  for (PetscInt i = 0; i < t->o.batch; ++i) {
    const PetscInt j = i + (PetscInt)RandomIndex(&random, (uint64_t)(t->o.episodes - i)), swap = deck[i];

    deck[i] = deck[j];
    deck[j] = swap;
  }
  CMAESSetDiagonal(es, generation < t->o.diagonal ? PETSC_TRUE : PETSC_FALSE);
  PetscCall(CMAESAsk(es, &random, x));
  for (PetscInt k = 0; k < es->lambda; ++k) {
    SlipPolicy policy;

    f[k] = 0;
    if (k % t->size != t->rank) continue;
    PetscCall(Policy(t->o.hidden, x + k * es->n, &policy));
    for (PetscInt i = 0; i < t->o.batch; ++i) {
      double cost = 0;

      PetscCall(Cost(&t->train[deck[i]], policy, &cost));
      f[k] += cost / (double)t->o.batch;
    }
    PetscCall(SlipPolicyDestroy(&policy));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, f, (PetscMPIInt)es->lambda, MPI_DOUBLE, MPI_SUM, t->comm));
  PetscCall(CMAESTell(es, x, f));
  t->runs += es->lambda * t->o.batch;
  PetscCall(PetscFree3(deck, x, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Mean cost, and rejected attempts over all, of the mean of now; it is kept when it is the best so far. */
static PetscErrorCode Validate(OdeTrainer *t, PetscInt generation, PetscReal seconds)
{
  double *cost, mean = 0;
  PetscInt counts[2] = {0, 0};
  PetscBool better;
  SlipPolicy policy;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(t->o.validation, &cost));
  PetscCall(Policy(t->o.hidden, t->es.mean, &policy));
  for (PetscInt i = t->rank; i < t->o.validation; i += t->size) {
    OdeResult r;

    PetscCall(OdeEpisodeRun(&t->valid[i], policy, t->valid[i].tol, &r));
    cost[i] = OdeEpisodeCost(&t->valid[i], &r);
    counts[0] += r.rejected;
    counts[1] += r.steps + r.rejected;
  }
  PetscCall(SlipPolicyDestroy(&policy));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, cost, (PetscMPIInt)t->o.validation, MPI_DOUBLE, MPI_SUM, t->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts, 2, MPIU_INT, MPI_SUM, t->comm));
  for (PetscInt i = 0; i < t->o.validation; ++i) mean += cost[i] / (double)t->o.validation;
  PetscCall(PetscFree(cost));
  better = mean < t->cost ? PETSC_TRUE : PETSC_FALSE;
  if (better) {
    t->cost = mean;
    t->best_generation = generation;
    PetscCall(PetscArraycpy(t->best, t->es.mean, t->es.n));
  }
  PetscCall(PetscPrintf(t->comm,
                        "generation %5" PetscInt_FMT
                        "  validation: work at equal error %6.4f of basic's  rejected %4.1f %%"
                        "  sigma %6.4f  %5.0f s%s\n",
                        generation, exp(mean), 100 * (double)counts[0] / (double)counts[1], t->es.sigma,
                        (double)seconds, better ? "  best so far" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the whole ---- */

static PetscErrorCode Store(OdeTrainer *t)
{
  SlipPolicy p;

  PetscFunctionBegin;
  if (t->rank || !t->o.output[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Policy(t->o.hidden, t->best, &p));
  PetscCall(SlipPolicySetAttribute(p, "algorithm", "cmaes"));
  PetscCall(SlipPolicySetAttribute(p, "problem", "ode"));
  PetscCall(PolicySetNumber(p, "generations", "%.0f", (double)t->best_generation));
  PetscCall(PolicySetNumber(p, "training_runs", "%.0f", (double)t->runs));
  PetscCall(PolicySetNumber(p, "validation_cost", "%.5f", t->cost));
  PetscCall(PolicySetNumber(p, "seed", "%.0f", (double)t->o.seed));
  PetscCall(SlipPolicyStore(p, t->o.output));
  PetscCall(SlipPolicyDestroy(&p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Draw(PetscInt seed, PetscInt stream, PetscInt n, OdeEpisode **e)
{
  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, e));
  for (PetscInt i = 0; i < n; ++i) PetscCall(OdeEpisodeCreate(StreamSeed(seed, stream, i), &(*e)[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Elapsed(MPI_Comm comm, PetscLogDouble begin, PetscReal *seconds)
{
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(PetscTime(&now));
  *seconds = (PetscReal)(now - begin);
  PetscCallMPI(MPI_Bcast(seconds, 1, MPIU_REAL, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(OdeTrainer *t, PetscLogDouble begin)
{
  PetscInt generation = 0;
  PetscReal seconds;

  PetscFunctionBegin;
  PetscCall(Elapsed(t->comm, begin, &seconds));
  PetscCall(PetscPrintf(t->comm,
                        "%" PetscInt_FMT " weights, population %" PetscInt_FMT ", %" PetscInt_FMT " equations\n",
                        t->es.n, t->es.lambda, t->o.episodes + t->o.validation));
  PetscCall(Validate(t, 0, seconds));
  while (generation < t->o.generations && (t->o.minutes <= 0 || seconds < 60 * t->o.minutes)) {
    PetscCall(Generation(t, generation++));
    PetscCall(Elapsed(t->comm, begin, &seconds));
    if (generation % t->o.interval == 0 || generation == t->o.generations) PetscCall(Validate(t, generation, seconds));
  }
  PetscCall(Store(t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OdeTrain(MPI_Comm comm)
{
  OdeTrainer t = {.comm = comm, .cost = PETSC_MAX_REAL};
  PetscLogDouble begin;
  PetscBool only_help;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(OptionsSet(comm, &t.o));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  if (only_help) PetscFunctionReturn(PETSC_SUCCESS);
  t.o.batch = PetscMin(t.o.batch, t.o.episodes);
  SlipBLASSetNumThreads(1); /* as in CMATrainerCreate() */
  PetscCall(PetscTime(&begin));
  PetscCallMPI(MPI_Comm_rank(comm, &t.rank));
  PetscCallMPI(MPI_Comm_size(comm, &t.size));
  n = CountWeights(t.o.hidden);
  PetscCall(PetscCalloc1(n, &t.best));
  Start(t.o.hidden, t.best);
  PetscCall(CMAESCreate(n, t.o.population, t.best, t.o.sigma, &t.es));
  PetscCall(Draw(t.o.seed, TRAIN_STREAM, t.o.episodes, &t.train));
  PetscCall(Draw(t.o.seed, VALID_STREAM, t.o.validation, &t.valid));
  PetscCall(Run(&t, begin));
  for (PetscInt i = 0; i < t.o.episodes; ++i) PetscCall(OdeEpisodeDestroy(&t.train[i]));
  for (PetscInt i = 0; i < t.o.validation; ++i) PetscCall(OdeEpisodeDestroy(&t.valid[i]));
  PetscCall(PetscFree(t.train));
  PetscCall(PetscFree(t.valid));
  PetscCall(PetscFree(t.best));
  PetscCall(CMAESDestroy(&t.es));
  PetscFunctionReturn(PETSC_SUCCESS);
}
