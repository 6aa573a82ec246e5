/* Training by CMA-ES, see cmatrain.h. Every rank holds the same episodes and the same strategy; a population is spread over the
   ranks, one member's episodes staying on one rank, so that results do not depend on their number. */
#include "cmatrain.h"
#include <slipstep/private/sliperror.h>
#include <slipstep/private/sliph5.h>
#include <slipstep/private/slipcompat.h>
#include <petsctime.h>

#define TRAIN_STREAM 1000000 /* seeds of episodes and generations do not meet */
#define VALID_STREAM 2000000
#define GENERATION_STREAM 3000000
#define SHIFT_MAX 0.4 /* of the dial as the policy sees it [decades] */
#define SHIFT_MIN (-1.0)
#define SHIFT_STEP 0.05

static const PetscReal unmoved[2] = {0, 0};

static uint64_t StreamSeed(PetscInt seed, PetscInt64 stream, PetscInt64 k)
{
  return (uint64_t)seed * 0x9e3779b97f4a7c15u + (uint64_t)(stream + k);
}

PetscInt CMACountWeights(const CMAOptions *o)
{
  return o->nobs * o->hidden + o->hidden + (o->layers - 1) * (o->hidden + 1) * o->hidden + o->hidden + 1;
}

PetscErrorCode CMAPolicy(const CMAOptions *o, const double weights[], const PetscReal shift[2], SlipPolicy *policy)
{
  PetscInt in = o->nobs;
  PetscReal scale[CMA_MAX_OBS], offset[CMA_MAX_OBS];
  const double *w = weights;

  PetscFunctionBegin;
  PetscCall(SlipPolicyCreate(PETSC_COMM_SELF, policy));
  for (PetscInt i = 0; i < o->nobs; ++i) {
    scale[i] = o->scale[i];
    offset[i] = o->offset[i];
    if (strcmp(o->names[i], "log_accuracy")) continue;
    /* x + shift[0] + shift[1] (x - middle) in place of x */
    scale[i] *= 1 + shift[1];
    offset[i] += o->scale[i] * (shift[0] - shift[1] * 0.5 * PetscLog10Real(o->low * o->high));
  }
  PetscCall(SlipPolicySetObservations(*policy, o->nobs, (const char *const *)o->names, scale, offset));
  for (PetscInt l = 0; l < o->layers; ++l) {
    PetscCall(SlipPolicyAddLayer(*policy, in, o->hidden, w, w + in * o->hidden, SLIP_ACTIVATION_TANH));
    w += (in + 1) * o->hidden;
    in = o->hidden;
  }
  PetscCall(SlipPolicyAddLayer(*policy, in, 1, w, w + in, SLIP_ACTIVATION_LINEAR));
  PetscCall(SlipPolicySetAction(*policy, -1, 1, o->dt_min, "T*", o->dt_max, o->dt_max_unit, PETSC_TRUE));
  if (o->moving > 0) {
    char text[32];

    PetscCall(PetscSNPrintf(text, sizeof(text), "%g", (double)o->moving));
    PetscCall(SlipPolicySetAttribute(*policy, SLIP_POLICY_MOVING_DT_MAX, text));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The environment's view of another problem than the fault: unscaled observations. */
static PetscErrorCode SmallOptions(const CMAOptions *o, EnvOptions *e)
{
  PetscFunctionBegin;
  e->nobs = o->nobs;
  for (PetscInt i = 0; i < o->nobs; ++i) {
    e->names[i] = o->names[i];
    e->scale[i] = 1;
    e->offset[i] = 0;
  }
  e->rtol = o->problem->rtol;
  e->atol = o->problem->atol;
  e->dt_min = o->dt_min;
  e->dt_max = o->dt_max;
  PetscCall(PetscStrncpy(e->dt_min_unit, "T*", sizeof(e->dt_min_unit)));
  PetscCall(PetscStrncpy(e->dt_max_unit, o->dt_max_unit, sizeof(e->dt_max_unit)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Episodes [nsingle + nmesh]; every rank draws all. */
static PetscErrorCode MakeEpisodes(const CMATrainer *t, PetscInt64 stream, PetscInt nsingle, PetscInt nmesh,
                                   Episode ***list)
{
  EnvOptions small = {.problem = t->o.problem, .log_spacing = PETSC_TRUE, .continuation = 1. / 12};

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(nsingle + nmesh, list));
  for (PetscInt i = 0; t->o.problem && i < nsingle + nmesh; ++i) {
    PetscCall(SmallOptions(&t->o, &small));
    PetscCall(EpisodeCreateSmall(&small, StreamSeed(t->o.seed, stream, i), &(*list)[i]));
  }
  for (PetscInt i = 0; !t->o.problem && i < nsingle + nmesh; ++i)
    PetscCall(EpisodeCreate(StreamSeed(t->o.seed, stream, i), i < nsingle ? 1 : t->o.side, &(*list)[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Validate(CMATrainer *t, const double weights[], const PetscReal shift[2], CMAScore *score);

PetscErrorCode CMATrainerCreate(MPI_Comm comm, const CMAOptions *o, CMATrainer *t)
{
  const PetscInt n = CMACountWeights(o);
  double *mean;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(t, sizeof(*t)));
  t->o = *o;
  t->comm = comm;
  PetscCall(PetscTime(&t->begin));
  PetscCallMPI(MPI_Comm_rank(comm, &t->rank));
  PetscCallMPI(MPI_Comm_size(comm, &t->size));
  t->score.cost = PETSC_MAX_REAL;
  t->ntrain = o->nsingle + o->nmesh;
  t->nvalid = 2 * o->validation;
  PetscCall(PetscMalloc1(n, &mean));
  CMAStart(o, mean);
  PetscCall(CMAESCreate(n, o->population, mean, o->sigma, &t->es));
  PetscCall(PetscFree(mean));
  PetscCall(PetscCalloc1(n, &t->best));
  PetscCall(PetscArraycpy(t->best, t->es.mean, n));
  if (o->resume[0]) PetscCall(CMACheckpointRead(t));
  PetscCall(MakeEpisodes(t, TRAIN_STREAM, o->nsingle, o->nmesh, &t->train));
  PetscCall(MakeEpisodes(t, VALID_STREAM, o->validation, o->validation, &t->valid));
  if (o->resume[0])
    PetscCall(Validate(t, t->best, unmoved, &t->score)); /* the same unless the episodes are others now */
  PetscCall(CMALogOpen(t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMATrainerDestroy(CMATrainer *t)
{
  PetscFunctionBegin;
  PetscCall(CMALogClose(t));
  for (PetscInt i = 0; i < t->ntrain; ++i) PetscCall(EpisodeDestroy(&t->train[i]));
  for (PetscInt i = 0; i < t->nvalid; ++i) PetscCall(EpisodeDestroy(&t->valid[i]));
  PetscCall(PetscFree(t->train));
  PetscCall(PetscFree(t->valid));
  PetscCall(PetscFree(t->best));
  PetscCall(CMAESDestroy(&t->es));
  for (PetscInt i = 0; i < t->o.nobs; ++i) PetscCall(PetscFree(t->o.names[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a generation ---- */

typedef struct {
  PetscInt n, *episode;
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

/* The same episodes and dials for every member: only differences between members count. The dials are spread evenly over the
   logarithmic range, their order against the episodes being random because the episodes' is. */
static PetscErrorCode DrawBatch(const CMATrainer *t, Random *random, Batch *b)
{
  PetscInt *deck;
  const PetscInt most = t->o.batch_single + t->o.batch_mesh;

  PetscFunctionBegin;
  b->n = 0;
  PetscCall(PetscMalloc2(most, &b->episode, most, &b->dial));
  PetscCall(PetscMalloc1(t->ntrain, &deck));
  Choose(random, 0, t->o.nsingle, t->o.batch_single, deck, b);
  const PetscInt singles = b->n;
  Choose(random, t->o.nsingle, t->o.nmesh, t->o.batch_mesh, deck, b);
  PetscCall(PetscFree(deck));
  for (PetscInt i = 0; i < b->n; ++i) {
    const PetscInt k = i < singles ? i : i - singles, n = i < singles ? singles : b->n - singles;

    b->dial[i] = t->o.low * PetscPowReal(t->o.high / t->o.low, ((PetscReal)k + RandomUniform(random)) / (PetscReal)n);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Cost(const CMATrainer *t, const double weights[], const Batch *b, double *cost)
{
  SlipPolicy policy;
  EpisodeResult r;

  PetscFunctionBegin;
  *cost = 0;
  PetscCall(CMAPolicy(&t->o, weights, unmoved, &policy));
  for (PetscInt i = 0; i < b->n; ++i) {
    PetscCall(EpisodeRun(t->train[b->episode[i]], policy, b->dial[i], &r));
    *cost += (double)(EpisodeCost(&r, b->dial[i]) / (PetscReal)b->n);
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

/* ---- validation ---- */

/* One run of a validation; row: cost, ln solves, within, ln(error/dial). */
static PetscErrorCode ValidationRun(const CMATrainer *t, SlipPolicy policy, PetscInt k, PetscReal row[4])
{
  const PetscReal x = ((PetscReal)(k % VALID_DIALS) + ((PetscReal)(k / VALID_DIALS % 7) + 0.5) / 7) / VALID_DIALS;
  const PetscReal dial = t->o.low * PetscPowReal(t->o.high / t->o.low, x);
  EpisodeResult r;

  PetscFunctionBegin;
  PetscCall(EpisodeRun(t->valid[k / VALID_DIALS], policy, dial, &r));
  row[0] = EpisodeCost(&r, dial);
  row[1] = PetscLogReal((PetscReal)r.solves);
  row[2] = r.slip_error <= dial && r.done == 1 ? 1 : 0;
  row[3] = PetscLogReal(PetscMax(r.slip_error / dial, (PetscReal)1e-6));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Every validation episode at fixed positions of the dial, other ones for each; the policy sees the dial moved by shift[0] decades in
   the middle of its range and by shift[1] more for each decade from there. */
static PetscErrorCode Validate(CMATrainer *t, const double weights[], const PetscReal shift[2], CMAScore *score)
{
  const PetscInt runs = t->nvalid * VALID_DIALS;
  PetscReal *row, sum[4] = {0, 0, 0, 0}, third[VALID_DIALS] = {0};
  SlipPolicy policy;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(4 * runs, &row));
  PetscCall(CMAPolicy(&t->o, weights, shift, &policy));
  for (PetscInt k = t->rank; k < runs; k += t->size) PetscCall(ValidationRun(t, policy, k, &row[4 * k]));
  PetscCall(SlipPolicyDestroy(&policy));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, row, (PetscMPIInt)(4 * runs), MPIU_REAL, MPIU_SUM, t->comm));
  for (PetscInt k = 0; k < runs; ++k) {
    for (PetscInt i = 0; i < 4; ++i) sum[i] += row[4 * k + i] / (PetscReal)runs;
    third[k % VALID_DIALS] += row[4 * k + 2] / (PetscReal)t->nvalid;
  }
  PetscCall(PetscFree(row));
  *score = (CMAScore){sum[0], PetscExpReal(sum[1]), sum[2], PetscExpReal(sum[3]), {third[0], third[1], third[2]}};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where the wanted share of a third's runs keeps the dial, from the largest move down. */
static PetscErrorCode FindShifts(CMATrainer *t, PetscReal shift[VALID_DIALS])
{
  PetscBool found[VALID_DIALS] = {PETSC_FALSE};
  CMAScore score;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < VALID_DIALS; ++k) shift[k] = SHIFT_MIN;
  for (PetscReal s = SHIFT_MAX; s > SHIFT_MIN; s -= SHIFT_STEP) {
    const PetscReal move[2] = {s, 0};
    PetscInt left = VALID_DIALS;

    PetscCall(Validate(t, t->best, move, &score));
    for (PetscInt k = 0; k < VALID_DIALS; ++k) {
      if (!found[k] && score.third[k] >= t->o.within) {
        shift[k] = s;
        found[k] = PETSC_TRUE;
      }
      left -= found[k] ? 1 : 0;
    }
    if (!left) break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Training weighs solves against errors; how many runs keep the dial follows from that. Here the dial is moved, as the policy sees
   it, until the wanted share does: by what each third of its range needs, smoothed to a straight line over the decades. */
static PetscErrorCode Calibrate(CMATrainer *t)
{
  const PetscReal third = PetscLog10Real(t->o.high / t->o.low) / VALID_DIALS;
  PetscReal shift[VALID_DIALS];
  CMAScore score;

  PetscFunctionBegin;
  if (t->o.within <= 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindShifts(t, shift));
  t->shift[0] = (shift[0] + shift[1] + shift[2]) / 3;
  t->shift[1] = third > 0 ? (shift[2] - shift[0]) / (2 * third) : 0;
  PetscCall(Validate(t, t->best, t->shift, &score));
  t->score = score;
  PetscCall(PetscPrintf(
    t->comm,
    "dial moved by %.2f decades in the middle of its range and %.2f a decade: cost %7.4f  solves %5.1f  within "
    "dial %5.1f %% (%.1f, %.1f, %.1f of its thirds)  error/dial %6.3f\n",
    (double)t->shift[0], (double)t->shift[1], (double)score.cost, (double)score.solves, 100 * (double)score.within,
    100 * (double)score.third[0], 100 * (double)score.third[1], 100 * (double)score.third[2], (double)score.error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Widen(PetscInt n, const PetscReal obs[], void *ctx)
{
  CMATrainer *t = (CMATrainer *)ctx;

  for (PetscInt i = 0; i < n; ++i) {
    t->obs_min[i] = PetscMin(t->obs_min[i], obs[i]);
    t->obs_max[i] = PetscMax(t->obs_max[i], obs[i]);
  }
}

/* The range of the observations that the best policy meets in training. */
static PetscErrorCode FindRange(CMATrainer *t)
{
  SlipPolicy policy;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < t->o.nobs; ++i) {
    t->obs_min[i] = PETSC_MAX_REAL;
    t->obs_max[i] = PETSC_MIN_REAL;
  }
  PetscCall(CMAPolicy(&t->o, t->best, t->shift, &policy));
  for (PetscInt i = 0; i < t->ntrain; ++i)
    for (PetscInt k = 0; k < VALID_DIALS; ++k)
      PetscCall(EpisodeWatch(t->train[i], policy,
                             t->o.low * PetscPowReal(t->o.high / t->o.low, (PetscReal)k / (VALID_DIALS - 1)), Widen,
                             t));
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

static PetscErrorCode Progress(CMATrainer *t, PetscReal best, PetscReal median)
{
  PetscReal seconds, left;
  CMAScore score;
  PetscBool better;

  PetscFunctionBegin;
  PetscCall(Validate(t, t->es.mean, unmoved, &score));
  better = score.cost < t->score.cost ? PETSC_TRUE : PETSC_FALSE;
  if (better) {
    t->score = score;
    t->best_generation = t->generation;
    PetscCall(PetscArraycpy(t->best, t->es.mean, t->es.n));
  }
  PetscCall(Elapsed(t, &seconds));
  left = seconds * (PetscReal)(t->o.generations - t->generation) / (PetscReal)t->generation;
  if (t->o.minutes > 0) left = PetscMin(left, 60 * t->o.minutes - seconds);
  PetscCall(PetscPrintf(
    t->comm,
    "generation %5" PetscInt64_FMT "  cost %7.4f  validation: cost %7.4f  solves %5.1f  within dial %5.1f %%"
    "  error/dial %6.3f  sigma %6.4f  left %5.0f s%s\n",
    t->generation, (double)median, (double)score.cost, (double)score.solves, 100 * (double)score.within,
    (double)score.error, t->es.sigma, (double)PetscMax(left, 0), better ? "  best so far" : ""));
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
    t->es.n, t->es.lambda, t->ntrain + t->nvalid, (double)seconds));
  while (t->generation < t->o.generations && (t->o.minutes <= 0 || seconds < 60 * t->o.minutes)) {
    PetscCall(Generation(t, &best, &median));
    if (t->generation % t->o.interval == 0) PetscCall(Progress(t, best, median));
    PetscCall(Elapsed(t, &seconds));
  }
  if (t->generation % t->o.interval) PetscCall(Progress(t, best, median));
  PetscCall(Calibrate(t));
  PetscCall(FindRange(t));
  if (t->o.output[0]) PetscCall(CMAStorePolicy(t));
  PetscFunctionReturn(PETSC_SUCCESS);
}
