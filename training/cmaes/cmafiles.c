/* Files of training by CMA-ES: policy, checkpoint, learning curve. The first rank writes. */
#include "cmatrain.h"
#include "common/files.h"
#include <slipcompat.h>
#include <petsctime.h>

#define CHECKPOINT_FORMAT "slipstep-cmaes"

PetscErrorCode CMAStorePolicy(CMATrainer *t, PetscBool unfinished)
{
  SlipPolicy p;

  PetscFunctionBegin;
  if (t->rank) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CMAPolicy(&t->o, t->best, t->shift, &p));
  if (t->cma->watch) PetscCall(SlipPolicySetRange(p, t->obs_min, t->obs_max));
  PetscCall(SlipPolicySetAttribute(p, "algorithm", "cmaes"));
  PetscCall(SlipPolicySetAttribute(p, "problem", ProblemPolicy(t->o.problem)));
  if (t->cma->measure) PetscCall(SlipPolicySetAttribute(p, SLIP_POLICY_MEASURE, t->cma->measure));
  if (unfinished) PetscCall(SlipPolicySetAttribute(p, SLIP_POLICY_UNFINISHED, "not calibrated"));
  PetscCall(PolicySetNumber(p, "generations", "%.0f", (double)t->best_generation));
  PetscCall(PolicySetNumber(p, "training_runs", "%.0f", (double)t->evaluations));
  PetscCall(PolicySetNumber(p, "validation_cost", "%.5f", (double)t->score.cost));
  PetscCall(PolicySetNumber(p, "seed", "%.0f", (double)t->o.seed));
  PetscCall(SlipPolicyStore(p, t->o.output));
  PetscCall(SlipPolicyDestroy(&p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- checkpoint ---- */

enum { ARRAYS = 7, NUMBERS = 10 };
typedef struct {
  const char *path;
  double *data;
  PetscInt n;
} CMAArray;

static void ListArrays(CMATrainer *t, CMAArray a[ARRAYS])
{
  CMAES *es = &t->es;
  const PetscInt n = es->n;
  const CMAArray list[ARRAYS] = {{"/mean", es->mean, n}, {"/path_sigma", es->ps, n}, {"/path_covariance", es->pc, n},
                                 {"/C", es->C, n * n},   {"/B", es->B, n * n},       {"/D", es->D, n},
                                 {"/best", t->best, n}};

  for (PetscInt i = 0; i < ARRAYS; ++i) a[i] = list[i];
}

PetscErrorCode CMACheckpointWrite(CMATrainer *t)
{
  CMAArray a[ARRAYS];
  PetscLogDouble now;
  PetscInt dims[1];
  SlipH5 h;

  PetscFunctionBegin;
  if (t->rank) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscTime(&now));
  PetscCall(SlipH5Create(t->o.checkpoint, &h));
  PetscCall(SlipH5WriteAttrString(&h, "/", "format", CHECKPOINT_FORMAT));
  PetscCall(SlipH5WriteAttrInt(&h, "/", "version", 1));
  PetscCall(SlipH5WriteAttrInt(&h, "/", "seed", t->o.seed));
  PetscCall(SlipH5WriteStrings(&h, "/observations", t->o.nobs, (const char *const *)t->o.names));
  ListArrays(t, a);
  for (PetscInt i = 0; i < ARRAYS; ++i) {
    dims[0] = a[i].n;
    PetscCall(SlipH5WriteReal(&h, a[i].path, 1, dims, a[i].data, NULL));
  }
  const PetscReal x[NUMBERS] = {t->es.sigma,
                                (PetscReal)t->es.generation,
                                (PetscReal)t->es.generation,
                                (PetscReal)t->evaluations,
                                (PetscReal)t->best_generation,
                                t->score.cost,
                                t->score.solves,
                                t->score.within,
                                t->score.error,
                                t->before + (PetscReal)(now - t->begin)};
  dims[0] = NUMBERS;
  PetscCall(SlipH5WriteReal(&h, "/counters", 1, dims, x, NULL));
  PetscCall(SlipH5Close(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMACheckpointRead(CMATrainer *t)
{
  CMAArray a[ARRAYS];
  double x[NUMBERS];
  SlipH5 h;

  PetscFunctionBegin;
  PetscCallFile("-train_resume", SlipH5OpenRead(t->o.resume, &h));
  PetscCall(CheckpointCheckFormat(&h, CHECKPOINT_FORMAT, " of -train_algorithm cmaes"));
  PetscCall(CheckpointCheckObservations(&h, t->o.nobs, t->o.names));
  ListArrays(t, a);
  for (PetscInt i = 0; i < ARRAYS; ++i)
    PetscCall(CheckpointReadArray(&h, a[i].path, a[i].n, sizeof(double), a[i].data));
  PetscCall(CheckpointReadArray(&h, "/counters", NUMBERS, sizeof(double), x));
  t->es.sigma = x[0];
  t->es.generation = (PetscInt64)x[1]; /* x[2] is the same */
  t->evaluations = (PetscInt64)x[3];
  t->best_generation = (PetscInt64)x[4];
  t->score = (CMAScore){.cost = x[5], .solves = x[6], .within = x[7], .error = x[8]}; /* the others are found again */
  t->before = x[9];
  PetscCall(SlipH5Close(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- learning curve ---- */

enum { COLUMNS = 9 };
static const CurveColumn Columns[COLUMNS] = {
  {"/generations/generation", ""},
  {"/generations/runs", ""},
  {"/generations/best", ""},
  {"/generations/median", ""},
  {"/generations/sigma", ""},
  {"/generations/validation_cost", ""},
  {"/generations/validation_solves", ""},
  {"/generations/within_dial", ""},
  {"/generations/wall_time", "s"},
};

PetscErrorCode CMALogOpen(CMATrainer *t)
{
  SlipH5Kind kind;

  PetscFunctionBegin;
  if (t->rank || !t->o.log[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&t->log));
  PetscCall(CurveKind(&kind));
  PetscCall(SlipH5CreateKind(&kind, t->o.log, t->log));
  PetscCall(CurveCreate(t->log, COLUMNS, Columns));
  PetscCall(SlipH5WriteAttrInt(t->log, "/", "seed", t->o.seed));
  PetscCall(SlipH5WriteAttrString(t->log, "/", "algorithm", "cmaes"));
  PetscCall(SlipH5Live(t->log));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CMALogRow(CMATrainer *t, const CMAScore *score)
{
  PetscLogDouble now;

  PetscFunctionBegin;
  if (!t->log) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscTime(&now));
  const PetscReal row[COLUMNS] = {(PetscReal)t->es.generation,
                                  (PetscReal)t->evaluations,
                                  t->least,
                                  t->median,
                                  t->es.sigma,
                                  score->cost,
                                  score->solves,
                                  score->within,
                                  t->before + (PetscReal)(now - t->begin)};
  PetscCall(CurveAppend(t->log, COLUMNS, Columns, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}
