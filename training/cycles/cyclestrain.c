/* Training of the policy for cycles by CMA-ES: a network of three units that begins as the smaller of what the error
   estimate and the stability of explicit steps allow. Every rank holds the same episodes; members are spread over ranks. */
#include "cycles.h"
#include "cmaes/cmaes.h"
#include "common/files.h"
#include "common/options.h"
#include "common/rowblas.h"
#include <slipcompat.h>
#include <petsctime.h>
#include <math.h>

enum { TRAIN_STREAM, VALID_STREAM, GENERATION_STREAM };
enum { UNITS = 3, DIALS = 3 };
#define RATIO_MAX 10                              /* of steps, as basic's limits */
static const PetscReal Dial[2] = {1e-4, 1e-2};    /* range of the training */
static const PetscReal Trusted[2] = {1e-4, 1e-3}; /* and of the file: beyond, coarser faults than these lose events */
static const PetscReal Judged[DIALS] = {3e-4, 1e-3, 5e-3}; /* of the validation */

/* What is observed, scaled and shifted, and the start: the elementary controller's ratio of steps by the error, and that to
   the longest stable step, which grows with the dial. The scale is also how little a weight counts beside others. */
static const struct {
  const char *name;
  double scale, offset, error, stable;
} Rows[] = {{"log_error_step", 1, 0, 1, 0},   {"change_log_error_step", 1, 0, 0, 0},   {"log_step_ratio", 1, 0, 0, 0},
            {"rejected", 1, 0, 0, 0},         {SLIP_OBSERVES_ACCURACY, 1, 3, 0, 0.12}, {"log_step", 0.1, 0, 0, -1},
            {"log_relaxation", 0.1, 0, 0, -1}};
enum { ROWS = PETSC_STATIC_ARRAY_LENGTH(Rows), WEIGHTS = (ROWS + 2) * UNITS + 1, NUMBERS = WEIGHTS + 2 };
#define ERROR_BIAS (-0.046) /* log10 of the safety factor */
#define STABLE_BIAS 0.48    /* log10 of the step at the dial 1e-3 in units of the relaxation time: 3 */
#define RTOL_START 2e-2     /* tolerance at the dial 1e-3, of the worst cell */
#define RTOL_POWER 1
#define RTOL_SCALE 4 /* of the last two numbers: they may move so much faster than weights */

typedef struct {
  PetscInt episodes, batch, validation, population, generations, interval, seed;
  PetscReal sigma;
  char output[PETSC_MAX_PATH_LEN];
} CyclesOptions;

typedef struct {
  CyclesOptions o;
  MPI_Comm comm;
  PetscMPIInt rank, size;
  CycleEpisode *train, *valid;
  CMAES es;
  double best[NUMBERS], cost; /* the mean with the best validation, and that */
  PetscInt best_generation;
  PetscInt64 runs;
} CyclesTrainer;

/* min(e, s) = e - relu(e - s); e itself is relu(e) - relu(-e) */
static void Start(double w[NUMBERS])
{
  double *bias = w + ROWS * UNITS, *out = bias + UNITS;

  PetscArrayzero(w, NUMBERS);
  for (PetscInt i = 0; i < ROWS; ++i) {
    const double e = Rows[i].error / Rows[i].scale, s = Rows[i].stable / Rows[i].scale;

    w[i] = e;
    w[ROWS + i] = -e;
    w[2 * ROWS + i] = e - s;
  }
  bias[0] = ERROR_BIAS;
  bias[1] = -ERROR_BIAS;
  bias[2] = ERROR_BIAS - STABLE_BIAS;
  out[0] = 1;
  out[1] = out[2] = -1;
  w[WEIGHTS] = log(RTOL_START) / RTOL_SCALE;
  w[WEIGHTS + 1] = (double)RTOL_POWER / RTOL_SCALE;
}

/* range: of the dial */
static PetscErrorCode Policy(const double w[NUMBERS], const PetscReal range[2], SlipPolicy *policy)
{
  const char *names[ROWS];
  const double *out = w + (ROWS + 1) * UNITS, power = RTOL_SCALE * w[WEIGHTS + 1];
  PetscReal scale[ROWS], offset[ROWS], low[ROWS], high[ROWS];

  PetscFunctionBegin;
  for (PetscInt i = 0; i < ROWS; ++i) {
    PetscBool dial;

    names[i] = Rows[i].name;
    scale[i] = (PetscReal)Rows[i].scale;
    offset[i] = (PetscReal)Rows[i].offset;
    PetscCall(PetscStrcmp(names[i], SLIP_OBSERVES_ACCURACY, &dial));
    low[i] = dial ? PetscLog10Real(range[0]) : -1000; /* others have no range that a run could leave */
    high[i] = dial ? PetscLog10Real(range[1]) : 1000;
  }
  PetscCall(SlipPolicyCreate(PETSC_COMM_SELF, policy));
  PetscCall(SlipPolicySetObservations(*policy, ROWS, names, scale, offset));
  PetscCall(SlipPolicyAddLayer(*policy, ROWS, UNITS, w, w + ROWS * UNITS, SLIP_ACTIVATION_RELU));
  PetscCall(SlipPolicyAddLayer(*policy, UNITS, 1, out, out + UNITS, SLIP_ACTIVATION_LINEAR));
  PetscCall(SlipPolicySetAction(*policy, -1, 1, (PetscReal)1 / RATIO_MAX, "h", RATIO_MAX, "h", PETSC_TRUE));
  PetscCall(SlipPolicySetRange(*policy, low, high));
  PetscCall(SlipPolicySetAttribute(*policy, SLIP_POLICY_MEASURE, "history"));
  PetscCall(
    PolicySetNumber(*policy, SLIP_POLICY_RTOL_FACTOR, "%.6g", exp(RTOL_SCALE * w[WEIGHTS]) * pow(1e-3, -power)));
  PetscCall(PolicySetNumber(*policy, SLIP_POLICY_RTOL_POWER, "%.6g", power));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode OptionsSet(MPI_Comm comm, CyclesOptions *o)
{
  const NumberOption row[] = {
    OPTION_INTEGER("-train_episodes", "Faults of the training", &o->episodes, 1, 100000),
    OPTION_INTEGER("-train_batch", "Faults of a generation", &o->batch, 1, 100000),
    OPTION_INTEGER("-train_validation", "Faults of a validation", &o->validation, 1, 100000),
    OPTION_INTEGER("-train_population", "Members of a generation, 0: 4 + 3 ln(weights)", &o->population, 0, 10000),
    OPTION_INTEGER("-train_generations", "Generations", &o->generations, 0, 1e8),
    OPTION_INTEGER("-train_validation_interval", "Generations between validations; the best mean is written",
                   &o->interval, 1, 1e6),
    OPTION_INTEGER("-train_seed", "Seed of everything random", &o->seed, 0, PETSC_MAX_INT),
    OPTION_REAL("-train_sigma", "First step length of CMA-ES, in weights", &o->sigma, 1e-6, PETSC_MAX_REAL)};

  PetscFunctionBegin;
  *o = (CyclesOptions){
    .episodes = 16, .batch = 6, .validation = 8, .population = 12, .generations = 25, .interval = 5, .sigma = 0.04};
  PetscOptionsBegin(comm, NULL, "Training the policy for cycles by CMA-ES", "train");
  PetscCall(OptionsNumbers(PetscOptionsObject, PETSC_STATIC_ARRAY_LENGTH(row), row));
  PetscCall(
    PetscOptionsString("-train_output", "Policy to write (HDF5)", NULL, o->output, o->output, sizeof(o->output), NULL));
  PetscOptionsEnd();
  PetscCall(TrainCheckFiles(comm, o->output, "", ""));
  o->batch = PetscMin(o->batch, o->episodes);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- costs ---- */

static uint64_t StreamSeed(PetscInt seed, PetscInt stream, PetscInt i)
{
  Random r;

  RandomSeed(&r, ((uint64_t)seed << 34) + ((uint64_t)(stream + 3) << 32) + (uint64_t)i);
  return r.s[0];
}

/* The same faults and dials for every member: only differences between members count. */
static PetscErrorCode Generation(CyclesTrainer *t, PetscInt generation)
{
  CMAES *es = &t->es;
  PetscInt *deck;
  PetscReal *dial;
  double *x, *f;
  Random random;

  PetscFunctionBegin;
  RandomSeed(&random, StreamSeed(t->o.seed, GENERATION_STREAM, generation));
  PetscCall(PetscMalloc4(t->o.episodes, &deck, t->o.batch, &dial, es->n * es->lambda, &x, es->lambda, &f));
  for (PetscInt i = 0; i < t->o.episodes; ++i) deck[i] = i;
  for (PetscInt i = 0; i < t->o.batch; ++i) {
    const PetscInt j = i + (PetscInt)RandomIndex(&random, (uint64_t)(t->o.episodes - i)), swap = deck[i];

    deck[i] = deck[j];
    deck[j] = swap;
    dial[i] = (PetscReal)RandomLog(&random, Dial[0], Dial[1]);
  }
  CMAESSetDiagonal(es, PETSC_TRUE);
  PetscCall(CMAESAsk(es, &random, x));
  for (PetscInt k = 0; k < es->lambda; ++k) {
    SlipPolicy policy;

    f[k] = 0;
    if (k % t->size != t->rank) continue;
    PetscCall(Policy(x + k * es->n, Dial, &policy));
    for (PetscInt i = 0; i < t->o.batch; ++i) {
      CycleResult r;

      PetscCall(CycleEpisodeRun(&t->train[deck[i]], policy, dial[i], 0, &r));
      f[k] += CycleCost(&t->train[deck[i]], &r, dial[i]) / (double)t->o.batch;
    }
    PetscCall(SlipPolicyDestroy(&policy));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, f, (PetscMPIInt)es->lambda, MPI_DOUBLE, MPI_SUM, t->comm));
  PetscCall(CMAESTell(es, x, f));
  t->runs += es->lambda * t->o.batch;
  PetscCall(PetscFree4(deck, dial, x, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of the mean of now at every dial: mean cost, share of the runs that keep the dial, and products over the usual ones. It is
   kept when it is the best so far. */
static PetscErrorCode Validate(CyclesTrainer *t, PetscInt generation, PetscReal seconds)
{
  const double n = (double)(DIALS * t->o.validation);
  double sum[3] = {0, 0, 0};
  SlipPolicy policy;
  PetscBool better;

  PetscFunctionBegin;
  PetscCall(Policy(t->es.mean, Dial, &policy));
  for (PetscInt i = 0; i < DIALS * t->o.validation; ++i) {
    CycleEpisode *e = &t->valid[i / DIALS];
    CycleResult r;

    if (i % t->size != t->rank) continue;
    PetscCall(CycleEpisodeRun(e, policy, Judged[i % DIALS], 0, &r));
    sum[0] += CycleCost(e, &r, Judged[i % DIALS]) / n;
    sum[1] += (r.good && r.error <= Judged[i % DIALS] ? 1 : 0) / n;
    sum[2] += (double)r.products / (double)e->usual / n;
  }
  PetscCall(SlipPolicyDestroy(&policy));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 3, MPI_DOUBLE, MPI_SUM, t->comm));
  better = sum[0] < t->cost ? PETSC_TRUE : PETSC_FALSE;
  if (better) {
    t->cost = sum[0];
    t->best_generation = generation;
    PetscCall(PetscArraycpy(t->best, t->es.mean, NUMBERS));
  }
  PetscCall(
    PetscPrintf(t->comm,
                "generation %5" PetscInt_FMT
                "  validation: cost %7.4f  dial kept %3.0f %%  products %6.4f of basic's  sigma %6.4f  %5.0f s%s\n",
                generation, sum[0], 100 * sum[1], sum[2], t->es.sigma, (double)seconds, better ? "  best so far" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the whole ---- */

static PetscErrorCode Store(CyclesTrainer *t)
{
  SlipPolicy p;

  PetscFunctionBegin;
  if (t->rank || !t->o.output[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Policy(t->best, Trusted, &p));
  PetscCall(SlipPolicySetAttribute(p, "algorithm", "cmaes"));
  PetscCall(SlipPolicySetAttribute(p, "problem", "cycles"));
  PetscCall(PolicySetNumber(p, "generations", "%.0f", (double)t->best_generation));
  PetscCall(PolicySetNumber(p, "training_runs", "%.0f", (double)t->runs));
  PetscCall(PolicySetNumber(p, "validation_cost", "%.5f", t->cost));
  PetscCall(PolicySetNumber(p, "seed", "%.0f", (double)t->o.seed));
  PetscCall(SlipPolicyStore(p, t->o.output));
  PetscCall(SlipPolicyDestroy(&p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DrawAll(PetscInt seed, PetscInt stream, PetscInt n, CycleEpisode **e)
{
  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, e));
  for (PetscInt i = 0; i < n; ++i) PetscCall(CycleEpisodeCreate(StreamSeed(seed, stream, i), &(*e)[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(CyclesTrainer *t)
{
  PetscLogDouble begin, now;

  PetscFunctionBegin;
  PetscCall(PetscTime(&begin));
  PetscCall(DrawAll(t->o.seed, TRAIN_STREAM, t->o.episodes, &t->train));
  PetscCall(DrawAll(t->o.seed, VALID_STREAM, t->o.validation, &t->valid));
  PetscCall(PetscPrintf(t->comm, "%d numbers, population %" PetscInt_FMT ", %" PetscInt_FMT " faults\n", (int)NUMBERS,
                        t->es.lambda, t->o.episodes + t->o.validation));
  for (PetscInt generation = 0; generation <= t->o.generations; ++generation) {
    if (generation) PetscCall(Generation(t, generation));
    if (generation % t->o.interval && generation < t->o.generations) continue;
    PetscCall(PetscTime(&now));
    PetscCall(Validate(t, generation, (PetscReal)(now - begin)));
    PetscCall(Store(t));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CyclesTrain(MPI_Comm comm)
{
  CyclesTrainer t = {.comm = comm, .cost = PETSC_MAX_REAL};
  PetscBool only_help;

  PetscFunctionBegin;
  PetscCall(OptionsSet(comm, &t.o));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  if (only_help) PetscFunctionReturn(PETSC_SUCCESS);
  SlipBLASSetNumThreads(1); /* as in CMATrainerCreate() */
  PetscCallMPI(MPI_Comm_rank(comm, &t.rank));
  PetscCallMPI(MPI_Comm_size(comm, &t.size));
  Start(t.best);
  PetscCall(CMAESCreate(NUMBERS, t.o.population, t.best, t.o.sigma, &t.es));
  PetscCall(Run(&t));
  for (PetscInt i = 0; i < t.o.episodes; ++i) PetscCall(CycleEpisodeDestroy(&t.train[i]));
  for (PetscInt i = 0; i < t.o.validation; ++i) PetscCall(CycleEpisodeDestroy(&t.valid[i]));
  PetscCall(PetscFree(t.train));
  PetscCall(PetscFree(t.valid));
  PetscCall(CMAESDestroy(&t.es));
  PetscFunctionReturn(PETSC_SUCCESS);
}
