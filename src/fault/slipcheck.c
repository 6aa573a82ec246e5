/* -fault_check_error: the run once more under the same controller, each step computed in two halves, and Richardson's
   estimate from the two final slips.

   The method is of order p = 2, or 1 with -ts_bathe_reaction implicit, so that the error of the run is (s_h -
   s_(h/2)) 2^p/(2^p - 1) to leading order. The controller sees the states of the finer run and so puts its steps
   where that run needs them. Repeating the old steps at their old times was tried and misleads: the finer run's event
   comes later, often after the short steps meant for it. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipoutput.h>

/* Before the run: remember where it begins */
PetscErrorCode SlipFaultCheckStart(SlipFault fault, TS ts)
{
  SlipFaultRunError *est = &fault->run_error;
  Vec w;

  PetscFunctionBegin;
  PetscCall(TSGetSolution(ts, &w));
  PetscCheck(w, fault->comm, PETSC_ERR_ORDER, "-%sfault_check_error needs the start: call TSSetSolution() first",
             SlipFaultPrefix(fault));
  PetscCall(VecDestroy(&est->start));
  PetscCall(VecDuplicate(w, &est->start));
  PetscCall(VecCopy(w, est->start));
  PetscCall(TSGetTime(ts, &est->start_time));
  PetscCall(TSGetTimeStep(ts, &est->start_step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The run from its start in halves of steps; w is its end */
static PetscErrorCode Repeat(SlipFault fault, TS ts, Vec w)
{
  SlipFaultRunError *est = &fault->run_error;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(VecCopy(est->start, w));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptReset(adapt));
  PetscCall(TSSetTime(ts, est->start_time));
  PetscCall(TSSetTimeStep(ts, est->start_step));
  PetscCall(TSSetStepNumber(ts, 0));
  PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_ITERATING));
  PetscCall(TSBatheSetHalved(ts, PETSC_TRUE));
  est->off = PETSC_TRUE;
  PetscCall(TSSolve(ts, w));
  est->off = PETSC_FALSE;
  PetscCall(TSBatheSetHalved(ts, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Relative error of the final mean slip of the run that ts did, signed, and the Bathe solves that finding it took; not a
   number when the repetition was stopped before its end, as by a signal. ts ends with the state and time of its run.
   Collective. */
PetscErrorCode SlipFaultCheckError(SlipFault fault, TS ts, SlipOutput run, PetscReal mean_slip, PetscReal *error,
                                   PetscInt *solves)
{
  SlipFaultOutput fields = fault->output;
  SlipFaultObservables obs;
  PetscReal order, time, reached;
  PetscInt step;
  Vec w, end;

  PetscFunctionBegin;
  PetscCall(SlipOutputClose(run));
  fault->output = NULL; /* no fields of it */
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(TSGetTime(ts, &time));
  PetscCall(TSGetStepNumber(ts, &step));
  PetscCall(VecDuplicate(w, &end));
  PetscCall(VecCopy(w, end));
  PetscCall(Repeat(fault, ts, w));
  PetscCall(TSBatheGetTotals(ts, NULL, NULL, solves, NULL, NULL));
  PetscCall(TSBatheGetOrder(ts, &order));
  PetscCall(SlipFaultGetObservables(fault, w, NULL, &obs));
  PetscCall(TSGetTime(ts, &reached));
  *error = reached < time * (1 - 10 * PETSC_MACHINE_EPSILON)
             ? NAN
             : (mean_slip - obs.mean_slip) / mean_slip / (1 - PetscPowReal(2, -order));
  PetscCall(VecCopy(end, w));
  PetscCall(TSSetTime(ts, time));
  PetscCall(TSSetStepNumber(ts, step));
  PetscCall(VecDestroy(&end));
  fault->output = fields;
  PetscFunctionReturn(PETSC_SUCCESS);
}
