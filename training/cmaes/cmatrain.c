/* Training by CMA-ES, see cmatrain.h. Every rank holds the same strategy and the same episodes; one member's runs stay
   on one rank, so that results do not depend on the number of ranks. */
#include "cmatrain.h"
#include <slipstep/rooms/slipblas.h>
#include <slipcompat.h>
#include <petsctime.h>
#include <math.h>

#define CALIBRATIONS 72 /* validations of a calibration that moves the dial as far as it may, and of the report */

/* Of the problem's seeds; the last one is far from all problems' own. */
enum { TRAIN_STREAM, VALID_STREAM, GENERATION_STREAM, CALIBRATION_STREAM, FRESH_STREAM = 50 };

static const PetscReal unmoved[2] = {0, 0};

/* Wall time, the same on every rank [s] */
static PetscErrorCode Elapsed(const CMATrainer *t, PetscReal *seconds)
{
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(PetscTime(&now));
  *seconds = t->before + (PetscReal)(now - t->begin);
  PetscCallMPI(MPI_Bcast(seconds, 1, MPIU_REAL, 0, t->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* n of each kind; of problems of one kind with a dial twice as many. Every rank draws all. */
static PetscErrorCode SetCreate(const CMATrainer *t, PetscInt stream, PetscInt nsingle, PetscInt nmesh, CMASet *set)
{
  const CMAOptions *o = &t->o;

  PetscFunctionBegin;
  *set = (CMASet){.n = nsingle + nmesh, .nsingle = t->cma->kinds ? nsingle : nsingle + nmesh};
  PetscCall(PetscCalloc1(set->n, &set->episode));
  for (PetscInt i = 0; i < set->n; ++i)
    PetscCall((*t->cma->create)(o, (*t->cma->seed)(o->seed, t->cma->stream + stream, i), i < nsingle ? 1 : o->side,
                                &set->episode[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetDestroy(const CMATrainer *t, CMASet *set)
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < set->n; ++i) PetscCall((*t->cma->destroy)(&set->episode[i]));
  PetscCall(PetscFree(set->episode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- how good a policy is, on every rank ---- */

#define SHIFT_MAX 0.4 /* of the dial as the policy sees it [decades] */
#define SHIFT_MIN (-1.0)
#define SHIFT_STEP 0.02

/* Of a run: cost, ln solves, within, ln(error/dial), failures, attempts */
enum { COST, SOLVES, WITHIN, ERROR, FAILURES, ATTEMPTS, ROW };

static PetscErrorCode ValidationRun(const CMATrainer *t, const CMASet *set, SlipPolicy policy, PetscInt k,
                                    PetscInt dials, PetscReal row[ROW])
{
  const PetscReal x = ((PetscReal)(k % dials) + ((PetscReal)(k / dials % 7) + 0.5) / 7) / (PetscReal)dials;
  PetscReal dial = 1;
  EpisodeResult r;

  PetscFunctionBegin;
  if (t->cma->dial != CMA_DIAL_NONE) dial = t->o.low * PetscPowReal(t->o.high / t->o.low, x);
  PetscCall((*t->cma->run)(set->episode[k / dials], policy, dial, &r));
  row[COST] = r.cost;
  row[SOLVES] = PetscLogReal((PetscReal)r.solves);
  row[WITHIN] = r.error <= dial && r.done == 1 ? 1 : 0;
  row[ERROR] = PetscLogReal(PetscMax(r.error / dial, (PetscReal)1e-6));
  row[FAILURES] = (PetscReal)r.failures;
  row[ATTEMPTS] = (PetscReal)r.attempts;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Every episode at fixed positions of the dial, other ones for each. Kinds that have no episodes keep it always. */
static PetscErrorCode Score(CMATrainer *t, const CMASet *set, const double weights[], const PetscReal shift[2],
                            CMAScore *score)
{
  const PetscInt dials = t->cma->dial == CMA_DIAL_NONE ? 1 : CMA_DIALS, runs = set->n * dials;
  const PetscInt of_kind[CMA_KINDS] = {set->nsingle, set->n - set->nsingle};
  PetscReal *row, sum[ROW] = {0};
  SlipPolicy policy;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(ROW * runs, &row));
  PetscCall(CMAPolicy(&t->o, weights, shift, &policy));
  for (PetscInt k = t->rank; k < runs; k += t->size) PetscCall(ValidationRun(t, set, policy, k, dials, &row[ROW * k]));
  PetscCall(SlipPolicyDestroy(&policy));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, row, (PetscMPIInt)(ROW * runs), MPIU_REAL, MPIU_SUM, t->comm));
  *score = (CMAScore){0};
  for (PetscInt k = 0; k < runs; ++k) {
    const PetscInt kind = k / dials < set->nsingle ? 0 : 1;

    for (PetscInt i = 0; i < ROW; ++i) sum[i] += row[ROW * k + i] / (PetscReal)runs;
    score->kept[kind][k % dials] += row[ROW * k + WITHIN] / (PetscReal)of_kind[kind];
  }
  PetscCall(PetscFree(row));
  for (PetscInt kind = 0; kind < CMA_KINDS; ++kind)
    for (PetscInt i = 0; i < CMA_DIALS && !of_kind[kind]; ++i) score->kept[kind][i] = 1;
  score->cost = sum[COST];
  score->solves = PetscExpReal(sum[SOLVES]);
  score->within = sum[WITHIN];
  score->error = PetscExpReal(sum[ERROR]);
  score->failures = sum[FAILURES] / sum[ATTEMPTS];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The least share of a kind that keeps the dial in a third of its range. */
static PetscReal KeptInThird(const CMAScore *score, PetscInt third)
{
  PetscReal least = 1;

  for (PetscInt kind = 0; kind < CMA_KINDS; ++kind) least = PetscMin(least, score->kept[kind][third]);
  return least;
}

/* For each third of the dial's range the largest move with which the wanted share keeps the dial. Where no move gets so
   far, as at accuracies beyond the reach of the steps' bounds, the share that one does get to takes its place. */
static PetscErrorCode FindShifts(CMATrainer *t, const CMASet *set, PetscReal shift[CMA_DIALS],
                                 PetscReal target[CMA_DIALS])
{
  CMAScore score;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < CMA_DIALS; ++k) {
    shift[k] = SHIFT_MIN;
    target[k] = -1;
  }
  for (PetscReal s = SHIFT_MAX; s > SHIFT_MIN; s -= SHIFT_STEP) {
    const PetscReal move[2] = {s, 0};
    PetscInt left = 0;

    PetscCall(Score(t, set, t->best, move, &score));
    for (PetscInt k = 0; k < CMA_DIALS; ++k) {
      const PetscReal kept = PetscMin(KeptInThird(&score, k), t->o.within);

      if (kept > target[k]) {
        shift[k] = s;
        target[k] = kept;
      }
      left += target[k] < t->o.within ? 1 : 0;
    }
    if (!left) break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool KeepsEverywhere(const CMAScore *score, const PetscReal target[CMA_DIALS])
{
  for (PetscInt k = 0; k < CMA_DIALS; ++k)
    if (KeptInThird(score, k) < target[k]) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Training weighs solves against errors; how many runs keep the dial follows from that. Here the dial is moved, as the
   policy sees it, until the wanted share does, of either kind: a straight line over the decades through what the thirds
   of its range need, and then as far down as the third needs that the line does worst by, but not below what any of
   them needed. */
static PetscErrorCode Calibrate(CMATrainer *t, const CMASet *set)
{
  const PetscReal third = PetscLog10Real(t->o.high / t->o.low) / CMA_DIALS;
  PetscReal shift[CMA_DIALS], target[CMA_DIALS], lowest;
  const CMAScore *score = &t->score;

  PetscFunctionBegin;
  PetscCall(FindShifts(t, set, shift, target));
  t->shift[0] = (shift[0] + shift[1] + shift[2]) / 3;
  t->shift[1] = third > 0 ? (shift[2] - shift[0]) / (2 * third) : 0;
  lowest = PetscMin(shift[0], PetscMin(shift[1], shift[2]));
  PetscCall(Score(t, set, t->best, t->shift, &t->score));
  while (!KeepsEverywhere(score, target) && t->shift[0] > lowest) {
    t->shift[0] -= SHIFT_STEP;
    PetscCall(Score(t, set, t->best, t->shift, &t->score));
  }
  PetscCall(PetscPrintf(
    t->comm,
    "dial moved by %.2f decades in the middle of its range and %.2f a decade: cost %7.4f  solves %5.1f  within "
    "dial %5.1f %% (thirds of its range: single cells %.1f, %.1f, %.1f, meshes %.1f, %.1f, %.1f)  error/dial "
    "%6.3f\n",
    (double)t->shift[0], (double)t->shift[1], (double)score->cost, (double)score->solves, 100 * (double)score->within,
    100 * (double)score->kept[0][0], 100 * (double)score->kept[0][1], 100 * (double)score->kept[0][2],
    100 * (double)score->kept[1][0], 100 * (double)score->kept[1][1], 100 * (double)score->kept[1][2],
    (double)score->error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Report(CMATrainer *t, const CMASet *set, const char what[])
{
  const PetscReal third = PetscLog10Real(t->o.high / t->o.low) / CMA_DIALS;
  CMAScore score;

  PetscFunctionBegin;
  PetscCall(Score(t, set, t->best, t->shift, &score));
  PetscCall(
    PetscPrintf(t->comm, "%s, on %" PetscInt_FMT " fresh %s: dial kept by %.1f %%, solves %.1f, error/dial %.3f\n",
                what, set->n, t->cma->episodes, 100 * (double)score.within, (double)score.solves, (double)score.error));
  for (PetscInt k = 0; k < CMA_DIALS; ++k) {
    const PetscReal low = PetscLog10Real(t->o.low) + third * (PetscReal)k;

    PetscCall(PetscPrintf(t->comm, "  dial %.1e to %.1e: kept by %.1f %%", (double)PetscPowReal(10, low),
                          (double)PetscPowReal(10, low + third), 100 * (double)score.kept[0][k]));
    if (t->cma->kinds)
      PetscCall(PetscPrintf(t->comm, " of single cells, %.1f %% of meshes", 100 * (double)score.kept[1][k]));
    PetscCall(PetscPrintf(t->comm, "\n"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a training ---- */

PetscErrorCode CMATrainerCreate(MPI_Comm comm, const CMAOptions *o, CMATrainer *t)
{
  const PetscInt n = CMACount(o), most = PetscMax(o->batch_single + o->batch_mesh, o->late_single + o->late_mesh);
  PetscReal before, after;

  PetscFunctionBegin;
  SlipBLASSetNumThreads(1);
  PetscCall(PetscMemzero(t, sizeof(*t)));
  t->o = *o;
  t->cma = o->problem->cma;
  t->comm = comm;
  t->score.cost = PETSC_MAX_REAL;
  t->least = t->median = (PetscReal)NAN;
  PetscCallMPI(MPI_Comm_rank(comm, &t->rank));
  PetscCallMPI(MPI_Comm_size(comm, &t->size));
  PetscCall(PetscTime(&t->begin));
  PetscCall(PetscCalloc1(n, &t->best));
  PetscCall(PetscMalloc2(most, &t->batch.episode, most, &t->batch.dial));
  if (o->first[0])
    PetscCall(CMAStartRead(o, t->best));
  else
    (*t->cma->start)(o, t->best);
  PetscCall(CMAESCreate(n, o->population, t->best, o->sigma, &t->es));
  if (o->resume[0]) PetscCall(CMACheckpointRead(t));
  if (o->calibrate[0]) {
    t->o.generations = 0;
    PetscCall(CMAPolicyRead(t));
  }
  PetscCall(Elapsed(t, &before));
  PetscCall(SetCreate(t, TRAIN_STREAM, o->nsingle, o->nmesh, &t->train));
  PetscCall(SetCreate(t, VALID_STREAM, o->validation, t->cma->dial == CMA_DIAL_SPREAD ? o->validation : 0, &t->valid));
  PetscCall(Elapsed(t, &after));
  t->reference = (after - before) / (PetscReal)(t->train.n + t->valid.n);
  if (o->resume[0]) /* the same unless the episodes are others now */
    PetscCall(Score(t, &t->valid, t->best, unmoved, &t->score));
  PetscCall(CMALogOpen(t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMATrainerDestroy(CMATrainer *t)
{
  PetscFunctionBegin;
  if (t->log) PetscCall(SlipH5Close(t->log));
  PetscCall(PetscFree(t->log));
  PetscCall(SetDestroy(t, &t->train));
  PetscCall(SetDestroy(t, &t->valid));
  PetscCall(PetscFree2(t->batch.episode, t->batch.dial));
  PetscCall(PetscFree(t->best));
  PetscCall(CMAOptionsFree(&t->o));
  PetscCall(CMAESDestroy(&t->es));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a generation ---- */

/* k of n without repetition, appended; where the dial is drawn, it is with each. */
static PetscErrorCode Choose(CMATrainer *t, Random *random, PetscInt first, PetscInt n, PetscInt k)
{
  CMABatch *b = &t->batch;
  PetscInt *deck;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, &deck));
  for (PetscInt i = 0; i < n; ++i) deck[i] = first + i;
  for (PetscInt i = 0; i < PetscMin(k, n); ++i) {
    const PetscInt j = i + (PetscInt)RandomIndex(random, (uint64_t)(n - i)), swap = deck[i];

    deck[i] = deck[j];
    deck[j] = swap;
    b->dial[b->n] = 1;
    b->episode[b->n++] = deck[i];
  }
  PetscCall(PetscFree(deck));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The same episodes and dials for every member: only differences between members count. Dials that are spread are so
   evenly over the logarithmic range, their order against the episodes being random because the episodes' is. */
static PetscErrorCode Draw(CMATrainer *t, Random *random)
{
  const CMAOptions *o = &t->o;
  const PetscBool late = t->es.generation >= o->generations - o->late_generations ? PETSC_TRUE : PETSC_FALSE;
  CMABatch *b = &t->batch;

  PetscFunctionBegin;
  b->n = 0;
  PetscCall(Choose(t, random, 0, o->nsingle, late ? o->late_single : o->batch_single));
  b->singles = b->n;
  PetscCall(Choose(t, random, o->nsingle, o->nmesh, late ? o->late_mesh : o->batch_mesh));
  for (PetscInt i = 0; i < b->n && t->cma->dial == CMA_DIAL_SPREAD; ++i) {
    const PetscInt k = i < b->singles ? i : i - b->singles, n = i < b->singles ? b->singles : b->n - b->singles;

    b->dial[i] = o->low * PetscPowReal(o->high / o->low, ((PetscReal)k + RandomUniform(random)) / (PetscReal)n);
  }
  t->evaluations += t->es.lambda * b->n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Either kind counts by its mean: the numbers of its runs say how well that is known, not how much it matters. */
static PetscErrorCode Cost(CMATrainer *t, const double weights[], double *cost)
{
  const CMABatch *b = &t->batch;
  const PetscInt meshes = b->n - b->singles;
  const PetscReal kinds = (b->singles ? 1 : 0) + (meshes ? 1 : 0);
  SlipPolicy policy;
  EpisodeResult r;

  PetscFunctionBegin;
  *cost = 0;
  PetscCall(CMAPolicy(&t->o, weights, unmoved, &policy));
  for (PetscInt i = 0; i < b->n; ++i) {
    PetscCall((*t->cma->run)(t->train.episode[b->episode[i]], policy, b->dial[i], &r));
    *cost += (double)(r.cost / (kinds * (PetscReal)(i < b->singles ? b->singles : meshes)));
  }
  PetscCall(SlipPolicyDestroy(&policy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Draw, evaluate, learn: the members are spread over the ranks. */
static PetscErrorCode Generation(CMATrainer *t)
{
  const CMAOptions *o = &t->o;
  CMAES *es = &t->es;
  double *x, *f;
  Random random;

  PetscFunctionBegin;
  RandomSeed(&random, (*t->cma->seed)(o->seed, t->cma->stream + GENERATION_STREAM, t->cma->first + es->generation));
  PetscCall(Draw(t, &random));
  CMAESSetDiagonal(es, es->generation < o->diagonal ? PETSC_TRUE : PETSC_FALSE);
  PetscCall(PetscMalloc2(es->n * es->lambda, &x, es->lambda, &f));
  PetscCall(CMAESAsk(es, &random, x));
  for (PetscInt k = 0; k < es->lambda; ++k) {
    f[k] = 0;
    if (k % t->size == t->rank) PetscCall(Cost(t, x + k * es->n, &f[k]));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, f, (PetscMPIInt)es->lambda, MPI_DOUBLE, MPI_SUM, t->comm));
  PetscCall(CMAESTell(es, x, f));
  PetscCall(PetscSortReal(es->lambda, f));
  t->least = f[0];
  t->median = f[es->lambda / 2];
  PetscCall(PetscFree2(x, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- validation, and the end ---- */

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
  if (!t->cma->watch) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < t->o.nobs; ++i) {
    t->obs_min[i] = PETSC_MAX_REAL;
    t->obs_max[i] = PETSC_MIN_REAL;
  }
  PetscCall(CMAPolicy(&t->o, t->best, t->shift, &policy));
  for (PetscInt i = t->rank; i < set->n; i += t->size)
    for (PetscInt k = 0; k < CMA_DIALS; ++k)
      PetscCall((*t->cma->watch)(set->episode[i], policy,
                                 t->o.low * PetscPowReal(t->o.high / t->o.low, (PetscReal)k / (CMA_DIALS - 1)), Widen,
                                 t));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, t->obs_min, (PetscMPIInt)t->o.nobs, MPIU_REAL, MPIU_MIN, t->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, t->obs_max, (PetscMPIInt)t->o.nobs, MPIU_REAL, MPIU_MAX, t->comm));
  PetscCall(SlipPolicyDestroy(&policy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* [s], where the dial moves far, which few episodes make it do: the calibration validates its own set, and the report a
   fresh one of the same size, after their references are made as those of the training were. A validation lasted from
   begin to end. */
static PetscReal CalibrationTime(const CMATrainer *t, PetscReal begin, PetscReal end)
{
  const PetscReal n = 2 * (PetscReal)t->o.calibration;

  if (t->o.within <= 0) return 0;
  return CALIBRATIONS * (end - begin) * n / (PetscReal)t->valid.n + 2 * n * t->reference;
}

/* Says how good the mean is, and about how long the rest takes: of the generations that are left, in runs, of which
   late ones have more, and of the calibration. */
static PetscErrorCode Say(const CMATrainer *t, const CMAScore *score, PetscReal begin, PetscReal end, PetscBool better)
{
  const CMAOptions *o = &t->o;
  const PetscInt64 generations = o->generations - t->es.generation,
                   late = PetscMin(PetscMin((PetscInt64)o->late_generations, o->generations), generations);
  const PetscReal runs =
    (PetscReal)t->es.lambda * ((PetscReal)(o->late_single + o->late_mesh) * (PetscReal)late +
                               (PetscReal)(o->batch_single + o->batch_mesh) * (PetscReal)(generations - late));
  PetscReal seconds = end * runs / (PetscReal)t->evaluations;
  char cost[32] = "", left[32] = "", text[256];

  PetscFunctionBegin;
  if (o->minutes > 0) seconds = PetscMin(seconds, 60 * o->minutes - end);
  seconds = PetscMax(seconds, 0) + CalibrationTime(t, begin, end);
  if (t->es.generation) PetscCall(PetscSNPrintf(cost, sizeof(cost), "  cost %7.4f", (double)t->median));
  if (t->evaluations) PetscCall(PetscSNPrintf(left, sizeof(left), "  left up to about %.0f s", (double)seconds));
  PetscCall((*t->cma->say)(score, text, sizeof(text)));
  PetscCall(PetscPrintf(t->comm, "generation %5" PetscInt64_FMT "%s  validation: %s  sigma %6.4f%s%s\n",
                        t->es.generation, cost, text, t->es.sigma, left, better ? "  best so far" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The mean of now: score it, keep it, store it, say so. */
static PetscErrorCode Validate(CMATrainer *t)
{
  PetscReal begin, end;
  CMAScore score;
  PetscBool better;

  PetscFunctionBegin;
  PetscCall(Elapsed(t, &begin));
  PetscCall(Score(t, &t->valid, t->es.mean, unmoved, &score));
  PetscCall(Elapsed(t, &end));
  t->calibration = CalibrationTime(t, begin, end);
  better = score.cost < t->score.cost ? PETSC_TRUE : PETSC_FALSE;
  if (better) {
    t->score = score;
    t->best_generation = t->es.generation;
    PetscCall(PetscArraycpy(t->best, t->es.mean, t->es.n));
    if (t->o.output[0]) { /* should training end here: not calibrated, and with the range of the validation */
      PetscCall(FindRange(t, &t->valid));
      PetscCall(CMAStorePolicy(t, PETSC_TRUE));
    }
  }
  PetscCall(Say(t, &score, begin, end, better));
  PetscCall(CMALogRow(t, &score));
  if (t->o.checkpoint[0]) PetscCall(CMACheckpointWrite(t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* After the last validation: calibrate, store. */
static PetscErrorCode Finish(CMATrainer *t)
{
  PetscFunctionBegin;
  if (t->o.moved) PetscCall(PetscArraycpy(t->shift, t->o.move, PETSC_STATIC_ARRAY_LENGTH(t->shift)));
  if (t->o.within > 0 && !t->o.moved) {
    CMASet set, fresh;

    if (t->calibration > 0)
      PetscCall(PetscPrintf(t->comm, "calibration, up to about %.0f s\n", (double)t->calibration));
    PetscCall(SetCreate(t, FRESH_STREAM, t->o.calibration, t->o.calibration, &fresh));
    if (t->o.calibrate[0]) PetscCall(Report(t, &fresh, "before"));
    PetscCall(SetCreate(t, CALIBRATION_STREAM, t->o.calibration, t->o.calibration, &set));
    PetscCall(Calibrate(t, &set));
    PetscCall(SetDestroy(t, &set));
    PetscCall(Report(t, &fresh, "the result"));
    PetscCall(SetDestroy(t, &fresh));
  }
  PetscCall(FindRange(t, &t->train));
  if (t->o.output[0]) PetscCall(CMAStorePolicy(t, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMATrainerRun(CMATrainer *t)
{
  PetscReal seconds;

  PetscFunctionBegin;
  PetscCall(Elapsed(t, &seconds));
  PetscCall(PetscPrintf(t->comm,
                        "%" PetscInt_FMT " weights, population %" PetscInt_FMT ", %" PetscInt_FMT " %s after %.0f s\n",
                        t->es.n, t->es.lambda, t->train.n + t->valid.n, t->cma->episodes, (double)seconds));
  if (t->cma->start_counts && !t->es.generation) PetscCall(Validate(t));
  PetscCall(Elapsed(t, &seconds));
  while (t->es.generation < t->o.generations && (t->o.minutes <= 0 || seconds < 60 * t->o.minutes)) {
    PetscCall(Generation(t));
    if (t->es.generation % t->o.interval == 0) PetscCall(Validate(t));
    PetscCall(Elapsed(t, &seconds));
  }
  if (t->es.generation % t->o.interval) PetscCall(Validate(t));
  PetscCall(Finish(t));
  PetscFunctionReturn(PETSC_SUCCESS);
}
