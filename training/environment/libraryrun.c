/* Runs of the library itself, see libraryrun.h. */
#include "libraryrun.h"
#include <slipcompat.h>

PetscErrorCode RunSetController(TS ts, SlipPolicy policy, PetscReal accuracy, TSAdaptType type, PetscReal rtol)
{
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(ts, &adapt));
  if (policy) {
    PetscCall(TSAdaptSetType(adapt, TSADAPTRL));
    PetscCall(TSAdaptRLSetPolicy(adapt, policy));
    PetscCall(TSAdaptRLSetAccuracy(adapt, accuracy));
    PetscCall(TSAdaptRLSetStrict(adapt, PETSC_TRUE));
  } else {
    PetscCall(SlipAdaptSetController(adapt, type));
    PetscCall(TSSetTolerances(ts, PETSC_DEFAULT, NULL, rtol, NULL));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RunSolve(TS ts, Vec w, PetscBool *solved)
{
  PetscErrorCode code;

  PetscFunctionBegin;
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  code = TSSolve(ts, w);
  PetscCall(PetscPopErrorHandler());
  *solved = code ? PETSC_FALSE : PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetStart(SlipFault fault, const FaultRun *run, TS ts, Vec w)
{
  PetscFunctionBegin;
  PetscCall(SlipFaultSetInitialState(fault, w));
  if (!run->start) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecCopy(run->start, w));
  PetscCall(TSSetTime(ts, run->begin));
  PetscCall(TSSetTimeStep(ts, run->step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A monitor cannot end a run: the next step begins before its word is heard. */
static PetscErrorCode AfterStep(TS ts)
{
  const FaultRun *run;
  PetscInt step;
  PetscReal t;
  Vec w;

  PetscFunctionBegin;
  PetscCall(TSGetApplicationContext(ts, &run));
  PetscCall(TSGetStepNumber(ts, &step));
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSGetSolution(ts, &w));
  PetscCall((*run->follow)(ts, step, t, w, run->ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RunFault(SlipFault fault, FaultRun *run, PetscInt *solves, PetscInt *rejected, PetscBool *ended)
{
  PetscInt attempts, accepted, newton, linear;
  TSConvergedReason reason;
  PetscReal t;
  Vec w;
  TS ts;

  PetscFunctionBegin;
  PetscCall(SlipFaultCreateState(fault, &w));
  PetscCall(TSCreate(PETSC_COMM_SELF, &ts));
  PetscCall(PetscObjectSetOptions((PetscObject)ts, run->options));
  PetscCall(SlipFaultConfigureTS(fault, ts));
  PetscCall(SetStart(fault, run, ts, w));
  PetscCall(RunSetController(ts, run->policy, run->setting, run->type, run->setting));
  PetscCall(TSSetMaxTime(ts, run->end));
  PetscCall(TSSetMaxSteps(ts, run->most));
  PetscCall(TSSetErrorIfStepFails(ts, PETSC_FALSE));
  PetscCall(TSSetApplicationContext(ts, run));
  PetscCall(TSSetPostStep(ts, AfterStep));
  PetscCall((*run->follow)(ts, 0, run->begin, w, run->ctx));
  PetscCall(RunSolve(ts, w, ended));
  PetscCall(TSBatheGetTotals(ts, &attempts, &accepted, solves, &newton, &linear));
  *rejected = attempts - accepted;
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSGetConvergedReason(ts, &reason));
  if (reason != TS_CONVERGED_USER && t < run->end * (1 - 1e-9)) *ended = PETSC_FALSE;
  PetscCall(TSDestroy(&ts));
  PetscCall(VecDestroy(&w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal RunFieldError(PetscInt n, const PetscReal slip[], const PetscReal reference[])
{
  PetscReal sum = 0, whole = 0;

  for (PetscInt i = 0; i < n; i++) {
    sum += PetscSqr(slip[i] - reference[i]);
    whole += PetscSqr(reference[i]);
  }
  return PetscSqrtReal(sum / whole);
}
