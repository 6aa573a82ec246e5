/* The sliding mode controller and the circuit as problems to evaluate, in the study's evaluation settings unless the
   -sliding_mode_ and -circuit_ options say otherwise. */
#include "problems.h"
#include <slipcompat.h>

static PetscErrorCode Destroy(void **model)
{
  PetscFunctionBegin;
  PetscCall(SlipModelDestroy((SlipModel *)model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The states, then the reaction */
static PetscErrorCode Observe(const ProblemCase *c, void *model, PetscReal t, Vec w, Vec r, PetscReal row[])
{
  const PetscScalar *a;

  PetscFunctionBegin;
  (void)model, (void)t;
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(PetscArraycpy(row, a, c->problem->evaluation->nstates));
  PetscCall(VecRestoreArrayRead(w, &a));
  row[c->problem->evaluation->nstates] = NAN; /* not known before the first step */
  if (!r) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(r, &a));
  row[c->problem->evaluation->nstates] = a[0];
  PetscCall(VecRestoreArrayRead(r, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Create(MPI_Comm comm, const ProblemCase *c, void **model)
{
  PetscFunctionBegin;
  (void)comm;
  PetscCall(SlipModelCreate(c->problem->model, SLIP_MODEL_EVALUATION, (SlipModel *)model));
  PetscCall(SlipModelSetFromOptions((SlipModel)*model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Start(MPI_Comm comm, const ProblemCase *c, void *model, TS *ts, Vec *w)
{
  PetscFunctionBegin;
  (void)comm, (void)c;
  PetscCall(TSCreate(PETSC_COMM_SELF, ts));
  PetscCall(SlipModelConfigureTS((SlipModel)model, *ts));
  PetscCall(SlipModelCreateState((SlipModel)model, w));
  PetscCall(TSSetSolution(*ts, *w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Exact(void *model, PetscReal t, PetscReal row[])
{
  PetscFunctionBegin;
  row[0] = (*((SlipModel)model)->ops->exact)((SlipModel)model, t, &row[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define SMALL_EVALUATION(states, columns_, units_)                                                                     \
  .nstates = states, .ncolumns = states + 1, .columns = columns_, .units = units_, .rate = -1, .create = Create,       \
  .destroy = Destroy, .start = Start, .observe = Observe

static const char *const sliding_columns[] = {"w", "reaction"}, *const sliding_units[] = {"1", "1/s"};
const Evaluation EvaluationSlidingMode = {SMALL_EVALUATION(1, sliding_columns, sliding_units), .exact = Exact};

static const char *const circuit_columns[] = {"V1", "V2", "i", "reaction"}, *const circuit_units[] = {"V", "V", "A",
                                                                                                      "A"};
const Evaluation EvaluationCircuit = {SMALL_EVALUATION(3, circuit_columns, circuit_units), .relative = PETSC_TRUE,
                                      .reference = 200000};
