/* The sliding mode controller and the circuit as problems to evaluate, in the study's evaluation settings unless the
   -sliding_mode_ and -circuit_ options say otherwise. */
#include "evaluate.h"
#include "../examples/circuit.h"
#include "../examples/sliding_mode.h"
#include <slipcompat.h>

#define EVALUATION 1 /* of the two settings of each model */

static PetscErrorCode Destroy(void **model)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(*model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The states, then the reaction */
static PetscErrorCode Observe(const EvaluateCase *c, void *model, PetscReal t, Vec w, Vec r, PetscReal row[])
{
  const PetscScalar *a;

  PetscFunctionBegin;
  (void)model;
  (void)t;
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(PetscArraycpy(row, a, c->problem->nstates));
  PetscCall(VecRestoreArrayRead(w, &a));
  row[c->problem->nstates] = NAN; /* not known before the first step */
  if (!r) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(r, &a));
  row[c->problem->nstates] = a[0];
  PetscCall(VecRestoreArrayRead(r, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the sliding mode controller ---- */

static const char *const sliding_columns[] = {"w", "reaction"}, *const sliding_units[] = {"1", "1/s"};

static PetscErrorCode SlidingCreate(MPI_Comm comm, const EvaluateCase *c, void **model)
{
  SlidingMode *m;

  PetscFunctionBegin;
  (void)comm;
  (void)c;
  PetscCall(PetscNew(&m));
  PetscCall(SlidingModeSetFromOptions(m, EVALUATION));
  *model = m;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlidingStart(MPI_Comm comm, const EvaluateCase *c, void *model, TS *ts, Vec *w)
{
  SlidingMode *m = (SlidingMode *)model;

  PetscFunctionBegin;
  (void)comm;
  (void)c;
  PetscCall(TSCreate(PETSC_COMM_SELF, ts));
  PetscCall(SlidingModeConfigureTS(m, *ts));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, 1, w));
  PetscCall(VecSet(*w, m->start));
  PetscCall(TSSetSolution(*ts, *w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlidingExact(void *model, PetscReal t, PetscReal row[])
{
  PetscFunctionBegin;
  row[0] = SlidingModeExact((const SlidingMode *)model, t, &row[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const EvaluateProblem EvaluateSlidingMode = {.name = "sliding_mode",
                                                    .meaning =
                                                      "the sliding mode controller of the -sliding_mode_ options",
                                                    .nstates = 1,
                                                    .ncolumns = 2,
                                                    .columns = sliding_columns,
                                                    .units = sliding_units,
                                                    .rate = -1,
                                                    .create = SlidingCreate,
                                                    .destroy = Destroy,
                                                    .start = SlidingStart,
                                                    .observe = Observe,
                                                    .exact = SlidingExact};

/* ---- the circuit ---- */

static const char *const circuit_columns[] = {"V1", "V2", "i", "reaction"}, *const circuit_units[] = {"V", "V", "A",
                                                                                                      "A"};

static PetscErrorCode CircuitCreate(MPI_Comm comm, const EvaluateCase *c, void **model)
{
  Circuit *circuit;

  PetscFunctionBegin;
  (void)comm;
  (void)c;
  PetscCall(PetscNew(&circuit));
  PetscCall(CircuitSetFromOptions(circuit, EVALUATION));
  *model = circuit;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CircuitStart(MPI_Comm comm, const EvaluateCase *c, void *model, TS *ts, Vec *w)
{
  Circuit *circuit = (Circuit *)model;

  PetscFunctionBegin;
  (void)comm;
  (void)c;
  PetscCall(TSCreate(PETSC_COMM_SELF, ts));
  PetscCall(CircuitConfigureTS(circuit, *ts));
  PetscCall(CircuitCreateState(circuit, w));
  PetscCall(TSSetSolution(*ts, *w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const EvaluateProblem EvaluateCircuit = {.name = "circuit",
                                                .meaning = "the circuit of the -circuit_ options",
                                                .nstates = CIRCUIT_N,
                                                .ncolumns = CIRCUIT_N + 1,
                                                .columns = circuit_columns,
                                                .units = circuit_units,
                                                .rate = -1,
                                                .relative = PETSC_TRUE,
                                                .reference = 200000,
                                                .create = CircuitCreate,
                                                .destroy = Destroy,
                                                .start = CircuitStart,
                                                .observe = Observe};

const EvaluateProblem *const EvaluateProblems[] = {&EvaluateFault, &EvaluateSlidingMode, &EvaluateCircuit, NULL};
