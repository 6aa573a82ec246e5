/* Repeats a run for -fault_check_error under the same controller, with each step computed in n parts, and applies
   Richardson's estimate to the two runs. The method is of order p = 2, or 1 with -ts_bathe_reaction implicit, so that
   the error of the run is (s_h - s_(h/n)) n^p/(n^p - 1) to leading order. The controller observes the states of the
   finer run and so puts its steps where that run needs them. Repeating the old steps at their old times misleads: the
   event of the finer run comes later, often after the short steps that were chosen for it. */
#include <slipstep/private/sliprun.h>
#include <slipstep/private/sliprunoutput.h>

/* Two parts suffice where errors add up. Where errors of long steps cancel, they do not in the halves: for a run of 10
   steps whose event was off by 5 % of its rise time, 2 parts gave 12 %, 4 parts 10 % and 8 parts 7 %. */
#define CHECK_PARTS 4

/* Stores the start of the run. */
PetscErrorCode SlipFaultCheckStart(SlipFault fault, TS ts)
{
  SlipFaultRunError *est = &fault->run->error;
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

/* TSBathePartFn */
static PetscErrorCode RecordPart(TS ts, PetscReal time, Vec w, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;

  PetscFunctionBegin;
  (void)ts;
  PetscCall(SlipFaultCourseAdd(fault, &fault->run->error.fine, time, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the RMS over the area of the difference of two slips at t, over that of the second one; for two components
   from their magnitudes. */
static PetscErrorCode FieldError(SlipFault fault, PetscReal t, Vec run, Vec reference, PetscReal *error)
{
  PetscReal sum[2] = {0, 0};
  const PetscReal *a, *b;
  Vec other;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(fault->cells, &other));
  const SlipArrays arrays[] = {{fault->cells, .read = &a}, {other, .read = &b}};

  PetscCall(SlipFaultGetSlip(fault, t, run, fault->cells));
  PetscCall(SlipFaultGetSlip(fault, t, reference, other));
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    sum[0] += fault->mesh.weight[i] * PetscSqr(a[i] - b[i]);
    sum[1] += fault->mesh.weight[i] * PetscSqr(b[i]);
  }
  PetscCall(SlipArraysRestore(2, arrays));
  PetscCall(VecDestroy(&other));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPI_SUM, fault->comm));
  *error = PetscSqrtReal(sum[0] / sum[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the errors [SLIP_NUM_ERRORS] of the run of ts, see SlipErrorKind, the signed relative error of its final mean
   slip, and the Bathe solves that this took. They are NaN when the repetition was stopped, for example by a signal. ts
   ends with the state and time of its run. Collective. */
PetscErrorCode SlipFaultCheckError(SlipFault fault, TS ts, SlipOutput run, PetscReal error[], PetscReal *final,
                                   PetscInt *solves)
{
  const SlipFaultCourse *course = &fault->run->error.course, *fine = &fault->run->error.fine;
  PetscReal order, time, reached, leading;
  PetscInt step;
  Vec w, end;
  SlipFaultRunError *est = &fault->run->error;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(SlipOutputClose(run));
  fault->run->started = PETSC_FALSE; /* for observers of the repetition */
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(TSGetTime(ts, &time));
  PetscCall(TSGetStepNumber(ts, &step));
  PetscCall(VecDuplicate(w, &end));
  PetscCall(VecCopy(w, end));
  /* the run again, from its start in parts of steps; w is its end */
  PetscCall(VecCopy(est->start, w));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptReset(adapt));
  PetscCall(TSSetTime(ts, est->start_time));
  PetscCall(TSSetTimeStep(ts, est->start_step));
  PetscCall(TSSetStepNumber(ts, 0));
  PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_ITERATING));
  PetscCall(TSBatheSetParts(ts, CHECK_PARTS, RecordPart, fault));
  est->off = PETSC_TRUE;
  est->fine.n = 0;
  PetscCall(TSSolve(ts, w));
  est->off = PETSC_FALSE;
  PetscCall(TSBatheSetParts(ts, 1, NULL, NULL));
  PetscCall(TSBatheGetTotals(ts, NULL, NULL, solves, NULL, NULL));
  PetscCall(TSBatheGetOrder(ts, &order));
  PetscCall(TSGetTime(ts, &reached));
  if (reached < time * (1 - 10 * PETSC_MACHINE_EPSILON) || !course->n) {
    *final = NAN;
  } else {
    leading = 1 / (1 - PetscPowReal(CHECK_PARTS, -order));
    SlipCourseCompare(course->n, course->node, fine->n, fine->node, error);
    PetscCall(FieldError(fault, time, end, w, &error[SLIP_ERROR_FIELD]));
    for (PetscInt k = 0; k < SLIP_NUM_ERRORS; k++) error[k] *= leading;
    *final = (1 - fine->node[fine->n - 1].slip / course->node[course->n - 1].slip) * leading;
  }
  PetscCall(VecCopy(end, w));
  PetscCall(TSSetTime(ts, time));
  PetscCall(TSSetStepNumber(ts, step));
  PetscCall(VecDestroy(&end));
  PetscFunctionReturn(PETSC_SUCCESS);
}
