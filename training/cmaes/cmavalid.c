/* How good a policy with an accuracy dial is, and its calibration: see cmatrain.h. */
#include "cmatrain.h"
#include <slipcompat.h>

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
PetscErrorCode CMAValidate(CMATrainer *t, const CMASet *set, const double weights[], const PetscReal shift[2],
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

    PetscCall(CMAValidate(t, set, t->best, move, &score));
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
PetscErrorCode CMACalibrate(CMATrainer *t, const CMASet *set)
{
  const PetscReal third = PetscLog10Real(t->o.high / t->o.low) / CMA_DIALS;
  PetscReal shift[CMA_DIALS], target[CMA_DIALS], lowest;
  const CMAScore *score = &t->score;

  PetscFunctionBegin;
  PetscCall(FindShifts(t, set, shift, target));
  t->shift[0] = (shift[0] + shift[1] + shift[2]) / 3;
  t->shift[1] = third > 0 ? (shift[2] - shift[0]) / (2 * third) : 0;
  lowest = PetscMin(shift[0], PetscMin(shift[1], shift[2]));
  PetscCall(CMAValidate(t, set, t->best, t->shift, &t->score));
  while (!KeepsEverywhere(score, target) && t->shift[0] > lowest) {
    t->shift[0] -= SHIFT_STEP;
    PetscCall(CMAValidate(t, set, t->best, t->shift, &t->score));
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

PetscErrorCode CMAReport(CMATrainer *t, const CMASet *set, const char what[])
{
  const PetscReal third = PetscLog10Real(t->o.high / t->o.low) / CMA_DIALS;
  CMAScore score;

  PetscFunctionBegin;
  PetscCall(CMAValidate(t, set, t->best, t->shift, &score));
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
