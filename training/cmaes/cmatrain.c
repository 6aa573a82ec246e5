/* Training by CMA-ES, see cmatrain.h. Every rank holds the same episodes and the same strategy; a population is spread
   over the ranks, one member's episodes staying on one rank, so that results do not depend on their number. */
#include "cmatrain.h"
#include <slipblas.h>
#include <sliph5.h>
#include <slipcompat.h>

#include <petsctime.h>

#define CALIBRATIONS 30 /* validations of a calibration, about */

#define TRAIN_STREAM 1000000 /* seeds of episodes and generations do not meet */
#define VALID_STREAM 2000000
#define GENERATION_STREAM 3000000
#define CALIBRATION_STREAM 4000000

static const PetscReal unmoved[2] = {0, 0};

static uint64_t StreamSeed(PetscInt seed, PetscInt64 stream, PetscInt64 k)
{
  return (uint64_t)seed * 0x9e3779b97f4a7c15u + (uint64_t)(stream + k);
}

/* One of a problem of the table, which is no fault */
static PetscErrorCode CreateSmall(const CMAOptions *o, uint64_t seed, Episode **episode)
{
  EnvOptions e = {.problem = o->problem,
                  .log_spacing = PETSC_TRUE,
                  .continuation = 1. / 12,
                  .rtol = o->problem->rtol,
                  .atol = o->problem->atol,
                  .dt_min = o->dt_min,
                  .dt_max = o->dt_max,
                  .dt_min_unit = "T*"};

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(e.dt_max_unit, o->dt_max_unit, sizeof(e.dt_max_unit)));
  e.nobs = PetscMin(o->nobs, ENV_MAX_OBS);
  for (PetscInt i = 0; i < e.nobs; ++i) { /* unscaled: the policy does that */
    e.names[i] = o->names[i];
    e.scale[i] = 1;
  }
  PetscCall(EpisodeCreateSmall(&e, seed, episode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Every rank draws all. */
static PetscErrorCode SetCreate(const CMATrainer *t, PetscInt64 stream, PetscInt nsingle, PetscInt nmesh, CMASet *set)
{
  const CMAOptions *o = &t->o;

  PetscFunctionBegin;
  *set = (CMASet){.n = nsingle + nmesh, .nsingle = o->small ? nsingle + nmesh : nsingle};
  PetscCall(PetscCalloc1(set->n, &set->episode));
  for (PetscInt i = 0; i < set->n; ++i) {
    const uint64_t seed = StreamSeed(o->seed, stream, i);

    if (o->user)
      PetscCall(EpisodeCreateUser(o->user, seed, &set->episode[i]));
    else if (o->small)
      PetscCall(CreateSmall(o, seed, &set->episode[i]));
    else
      PetscCall(EpisodeCreate(o->family.n ? &o->family : NULL, seed, i < nsingle ? 1 : o->side, &set->episode[i]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetDestroy(CMASet *set)
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < set->n; ++i) PetscCall(EpisodeDestroy(&set->episode[i]));
  PetscCall(PetscFree(set->episode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMATrainerCreate(MPI_Comm comm, const CMAOptions *o, CMATrainer *t)
{
  const PetscInt n = CMACountWeights(o);
  double *mean;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(t, sizeof(*t)));
  t->o = *o;
  t->comm = comm;
  SlipBLASSetNumThreads(1); /* threads change the order of sums, and so bits; and the ranks have the cores already */
  PetscCall(PetscTime(&t->begin));
  PetscCallMPI(MPI_Comm_rank(comm, &t->rank));
  PetscCallMPI(MPI_Comm_size(comm, &t->size));
  t->score.cost = PETSC_MAX_REAL;
  PetscCall(PetscMalloc1(n, &mean));
  CMAStart(o, mean);
  PetscCall(CMAESCreate(n, o->population, mean, o->sigma, &t->es));
  PetscCall(PetscFree(mean));
  PetscCall(PetscCalloc1(n, &t->best));
  PetscCall(PetscArraycpy(t->best, t->es.mean, n));
  if (o->resume[0]) PetscCall(CMACheckpointRead(t));
  PetscCall(SetCreate(t, TRAIN_STREAM, o->nsingle, o->nmesh, &t->train));
  PetscCall(SetCreate(t, VALID_STREAM, o->validation, o->validation, &t->valid));
  if (o->resume[0]) /* the same unless the episodes are others now */
    PetscCall(CMAValidate(t, &t->valid, t->best, unmoved, &t->score));
  PetscCall(CMALogOpen(t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMATrainerDestroy(CMATrainer *t)
{
  PetscFunctionBegin;
  PetscCall(CMALogClose(t));
  PetscCall(SetDestroy(&t->train));
  PetscCall(SetDestroy(&t->valid));
  PetscCall(PetscFree(t->best));
  PetscCall(CMAESDestroy(&t->es));
  for (PetscInt i = 0; i < t->o.nobs; ++i) PetscCall(PetscFree(t->o.names[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a generation ---- */

typedef struct {
  PetscInt n, singles, *episode; /* single cells first */
  PetscReal *dial;
} Batch;

/* k of n without repetition, appended. */
static void Choose(Random *random, PetscInt first, PetscInt n, PetscInt k, PetscInt deck[], Batch *b)
{
  for (PetscInt i = 0; i < n; ++i) deck[i] = first + i;
  for (PetscInt i = 0; i < PetscMin(k, n); ++i) {
    const PetscInt j = i + (PetscInt)RandomIndex(random, (uint64_t)(n - i)), swap = deck[i];

    deck[i] = deck[j];
    deck[j] = swap;
    b->episode[b->n++] = deck[i];
  }
}

/* The same episodes and dials for every member: only differences between members count. The dials are spread evenly
   over the logarithmic range, their order against the episodes being random because the episodes' is. */
static PetscErrorCode DrawBatch(const CMATrainer *t, Random *random, Batch *b)
{
  PetscInt *deck;
  const PetscBool late = t->generation >= t->o.generations - t->o.late_generations ? PETSC_TRUE : PETSC_FALSE;
  const PetscInt singles = late ? t->o.late_single : t->o.batch_single,
                 meshes = late ? t->o.late_mesh : t->o.batch_mesh;
  const PetscInt most = singles + meshes;

  PetscFunctionBegin;
  b->n = 0;
  PetscCall(PetscMalloc2(most, &b->episode, most, &b->dial));
  PetscCall(PetscMalloc1(t->train.n, &deck));
  Choose(random, 0, t->o.nsingle, singles, deck, b);
  b->singles = b->n;
  Choose(random, t->o.nsingle, t->o.nmesh, meshes, deck, b);
  PetscCall(PetscFree(deck));
  for (PetscInt i = 0; i < b->n; ++i) {
    const PetscInt k = i < b->singles ? i : i - b->singles, n = i < b->singles ? b->singles : b->n - b->singles;

    b->dial[i] = t->o.low * PetscPowReal(t->o.high / t->o.low, ((PetscReal)k + RandomUniform(random)) / (PetscReal)n);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Either kind counts by its mean: the numbers of its runs say how well that is known, not how much it matters. */
static PetscErrorCode Cost(const CMATrainer *t, const double weights[], const Batch *b, double *cost)
{
  const PetscInt meshes = b->n - b->singles;
  const PetscReal kinds = (b->singles ? 1 : 0) + (meshes ? 1 : 0);
  SlipPolicy policy;
  EpisodeResult r;

  PetscFunctionBegin;
  *cost = 0;
  PetscCall(CMAPolicy(&t->o, weights, unmoved, &policy));
  for (PetscInt i = 0; i < b->n; ++i) {
    PetscCall(EpisodeRun(t->train.episode[b->episode[i]], policy, b->dial[i], &r));
    *cost += (double)(EpisodeCost(&r, b->dial[i]) / (kinds * (PetscReal)(i < b->singles ? b->singles : meshes)));
  }
  PetscCall(SlipPolicyDestroy(&policy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Generation(CMATrainer *t, PetscReal *best, PetscReal *median)
{
  CMAES *es = &t->es;
  Random random;
  Batch batch;
  double *x, *f;

  PetscFunctionBegin;
  RandomSeed(&random, StreamSeed(t->o.seed, GENERATION_STREAM, t->generation));
  PetscCall(DrawBatch(t, &random, &batch));
  PetscCall(PetscMalloc2(es->n * es->lambda, &x, es->lambda, &f));
  CMAESSetDiagonal(es, t->generation < t->o.diagonal ? PETSC_TRUE : PETSC_FALSE);
  PetscCall(CMAESAsk(es, &random, x));
  for (PetscInt k = 0; k < es->lambda; ++k) {
    f[k] = 0;
    if (k % t->size == t->rank) PetscCall(Cost(t, x + k * es->n, &batch, &f[k]));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, f, (PetscMPIInt)es->lambda, MPI_DOUBLE, MPI_SUM, t->comm));
  PetscCall(CMAESTell(es, x, f));
  PetscCall(PetscSortReal(es->lambda, f));
  *best = f[0];
  *median = f[es->lambda / 2];
  t->evaluations += es->lambda * batch.n;
  t->generation++;
  PetscCall(PetscFree2(x, f));
  PetscCall(PetscFree2(batch.episode, batch.dial));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the whole ---- */

static void Widen(PetscInt n, const PetscReal obs[], void *ctx)
{
  CMATrainer *t = (CMATrainer *)ctx;

  for (PetscInt i = 0; i < n; ++i) {
    t->obs_min[i] = PetscMin(t->obs_min[i], obs[i]);
    t->obs_max[i] = PetscMax(t->obs_max[i], obs[i]);
  }
}

/* The range of the observations that the best policy meets in the runs of a set, over which the ranks divide. */
static PetscErrorCode FindRange(CMATrainer *t, const CMASet *set)
{
  SlipPolicy policy;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < t->o.nobs; ++i) {
    t->obs_min[i] = PETSC_MAX_REAL;
    t->obs_max[i] = PETSC_MIN_REAL;
  }
  PetscCall(CMAPolicy(&t->o, t->best, t->shift, &policy));
  for (PetscInt i = t->rank; i < set->n; i += t->size)
    for (PetscInt k = 0; k < VALID_DIALS; ++k)
      PetscCall(EpisodeWatch(set->episode[i], policy,
                             t->o.low * PetscPowReal(t->o.high / t->o.low, (PetscReal)k / (VALID_DIALS - 1)), Widen,
                             t));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, t->obs_min, (PetscMPIInt)t->o.nobs, MPIU_REAL, MPIU_MIN, t->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, t->obs_max, (PetscMPIInt)t->o.nobs, MPIU_REAL, MPIU_MAX, t->comm));
  PetscCall(SlipPolicyDestroy(&policy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Elapsed(const CMATrainer *t, PetscReal *seconds)
{
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(PetscTime(&now));
  *seconds = t->before + (PetscReal)(now - t->begin);
  PetscCallMPI(MPI_Bcast(seconds, 1, MPIU_REAL, 0, t->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* [s]: of the generations that are left, in runs, of which late ones have more, and of the calibration, which validates its
   own set some thirty times. A validation lasted from begin to end. */
static PetscErrorCode TimeLeft(const CMATrainer *t, PetscReal begin, PetscReal end, PetscReal *left)
{
  const CMAOptions *o = &t->o;
  const PetscInt64 late = PetscMin((PetscInt64)o->late_generations, o->generations),
                   late_left = PetscMin(late, o->generations - t->generation),
                   early_left = o->generations - t->generation - late_left;
  const PetscReal of_late = (PetscReal)(o->late_single + o->late_mesh),
                  of_early = (PetscReal)(o->batch_single + o->batch_mesh);
  const PetscReal runs = (PetscReal)t->es.lambda * (of_late * (PetscReal)late_left + of_early * (PetscReal)early_left);

  PetscFunctionBegin;
  *left = end * runs / (PetscReal)t->evaluations;
  if (o->minutes > 0) *left = PetscMin(*left, 60 * o->minutes - end);
  *left = PetscMax(*left, 0);
  if (o->within > 0) *left += CALIBRATIONS * (end - begin) * (PetscReal)o->calibration / (PetscReal)o->validation;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Progress(CMATrainer *t, PetscReal best, PetscReal median)
{
  PetscReal left, begin, end;
  CMAScore score;
  PetscBool better;

  PetscFunctionBegin;
  PetscCall(Elapsed(t, &begin));
  PetscCall(CMAValidate(t, &t->valid, t->es.mean, unmoved, &score));
  PetscCall(Elapsed(t, &end));
  better = score.cost < t->score.cost ? PETSC_TRUE : PETSC_FALSE;
  if (better) {
    t->score = score;
    t->best_generation = t->generation;
    PetscCall(PetscArraycpy(t->best, t->es.mean, t->es.n));
    if (t->o.output[0]) { /* should training end here: not calibrated, and with the range of the validation */
      PetscCall(FindRange(t, &t->valid));
      PetscCall(CMAStorePolicy(t));
    }
  }
  PetscCall(TimeLeft(t, begin, end, &left));
  PetscCall(PetscPrintf(
    t->comm,
    "generation %5" PetscInt64_FMT "  cost %7.4f  validation: cost %7.4f  solves %5.1f  within dial %5.1f %%"
    "  error/dial %6.3f  sigma %6.4f  left %5.0f s%s\n",
    t->generation, (double)median, (double)score.cost, (double)score.solves, 100 * (double)score.within,
    (double)score.error, t->es.sigma, (double)left, better ? "  best so far" : ""));
  PetscCall(CMALogRow(t, best, median, &score));
  if (t->o.checkpoint[0]) PetscCall(CMACheckpointWrite(t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMATrainerRun(CMATrainer *t)
{
  PetscReal best = 0, median = 0, seconds;

  PetscFunctionBegin;
  PetscCall(Elapsed(t, &seconds));
  PetscCall(PetscPrintf(
    t->comm, "%" PetscInt_FMT " weights, population %" PetscInt_FMT ", %" PetscInt_FMT " episodes after %.0f s\n",
    t->es.n, t->es.lambda, t->train.n + t->valid.n, (double)seconds));
  while (t->generation < t->o.generations && (t->o.minutes <= 0 || seconds < 60 * t->o.minutes)) {
    PetscCall(Generation(t, &best, &median));
    if (t->generation % t->o.interval == 0) PetscCall(Progress(t, best, median));
    PetscCall(Elapsed(t, &seconds));
  }
  if (t->generation % t->o.interval) PetscCall(Progress(t, best, median));
  if (t->o.within > 0) {
    CMASet set;

    PetscCall(SetCreate(t, CALIBRATION_STREAM, t->o.calibration, t->o.calibration, &set));
    PetscCall(CMACalibrate(t, &set));
    PetscCall(SetDestroy(&set));
  }
  PetscCall(FindRange(t, &t->train));
  if (t->o.output[0]) PetscCall(CMAStorePolicy(t));
  PetscFunctionReturn(PETSC_SUCCESS);
}
