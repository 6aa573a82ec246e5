/* What programs call around a run: configuring a TS for a small system with a set-valued reaction, checks of a TS after
   its options were set, and the last line of a summary. */
#include <slipstep/private/slipts.h>
#include <math.h>
#include <stdio.h>

#define SLIP_MAX_RUN 1e9 /* most steps of a run: hours for one cell, years for a fault */
#define DAYS (2 * 86400) /* seconds from which on a time is also printed in days or years */

/*@C
  SlipSmallConfigureTS - configures a TS to integrate a small system A dw/dt = F_s(t, w) + F_r

  Logically collective; before TSSetFromOptions().

  Input Parameters:
+ problem - the system (its arrays are copied, its ctx is borrowed)
- ts      - the TS, of one process

  Notes:
  This sets the type bathe, unless ts is of type moreau, with the constraint of SlipConstraintCreateSmall(), the
  controller dsp unless another is chosen, exact final time matchstep, and unlimited steps, rejections and failed
  solves. Each step is explicit or implicit, whichever costs less (TSBATHE_METHOD_AUTO); constant steps and those of a
  policy are implicit unless TSBatheSetMethod() or its option sets another method. Tolerances, step and final time are
  those of TSSetTolerances(), TSSetTimeStep(), TSSetMaxTime() and TSAdaptSetStepLimits(). Call TSSetSlipProblem() if a
  policy must observe more than the table of observations has for every problem.

  Level: beginner

  Errors: PETSC_ERR_WRONG_MPI_SIZE on more than one process, and those of SlipConstraintCreateSmall().

.seealso: SlipConstraintCreateSmall(), TSBATHE
@*/
PetscErrorCode SlipSmallConfigureTS(const SlipSmall *problem, TS ts)
{
  SlipConstraint con;
  PetscMPIInt size;
  PetscBool ours;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 2);
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)ts), &size));
  PetscCheck(size == 1, PetscObjectComm((PetscObject)ts), PETSC_ERR_WRONG_MPI_SIZE,
             "a system of %" PetscInt_FMT " states runs on one process, not on %d", problem->n, (int)size);
  PetscCall(SlipTSInitializePackage());
  PetscCall(SlipConstraintCreateSmall(problem, &con));
  PetscCall(TSSetProblemType(ts, TS_NONLINEAR));
  PetscCall(TSBatheIs(ts, &ours));
  if (!ours) PetscCall(TSSetType(ts, TSBATHE)); /* -ts_type may change it to TSMOREAU later */
  PetscCall(TSBatheSetConstraint(ts, con));
  PetscCall(SlipConstraintDestroy(&con));
  ts->default_adapt_type = TSADAPTDSP; /* constant steps are of little use here */
  PetscCall(TSSetMaxSteps(ts, PETSC_MAX_INT));
  PetscCall(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipSmallConfigureTSByMembers - configures a TS by the members of SlipSmall one by one, for languages without C's
                                  structs

  Logically collective; before TSSetFromOptions().

  Input Parameters:
+ ts       - the TS, of one process
. n        - number of states
. mass     - diagonal of A, positive [n], in units of the user's; copied
. nrows    - number of rows with a reaction
. rows     - where the reactions enter, ascending [nrows]; copied
. force    - F_s [n] of time and states, in units of A dw/dt
. jacobian - its derivative, J[i n + j] = dF_i/dw_j, zero on entry
. bound    - q >= 0 [nrows], and unless dq is NULL its derivative by |w_rows[k]|, zero on entry
- ctx      - passed to the functions, borrowed

  Level: intermediate

  Errors: those of SlipSmallConfigureTS()

.seealso: SlipSmallConfigureTS()
@*/
PetscErrorCode
SlipSmallConfigureTSByMembers(TS ts, PetscInt n, const PetscReal mass[], PetscInt nrows, const PetscInt rows[],
                              PetscErrorCode (*force)(PetscReal, const PetscReal[], PetscReal[], void *),
                              PetscErrorCode (*jacobian)(PetscReal, const PetscReal[], PetscReal[], void *),
                              PetscErrorCode (*bound)(PetscReal, const PetscReal[], PetscReal[], PetscReal[], void *),
                              void *ctx)
{
  const SlipSmall problem = {n, mass, nrows, rows, force, jacobian, bound, ctx};

  PetscFunctionBegin;
  PetscCall(SlipSmallConfigureTS(&problem, ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks numbers for which PETSc accepts any value, also a longest step so short that a run would not end and print no
   message. */
static PetscErrorCode CheckNumbers(TS ts)
{
  const MPI_Comm comm = PetscObjectComm((PetscObject)ts);
  PetscReal time, dt, end, atol, rtol, longest;
  PetscBool constant;
  TSAdapt adapt;
  PetscInt steps;

  PetscFunctionBegin;
  PetscCall(TSGetTime(ts, &time));
  PetscCall(TSGetTimeStep(ts, &dt));
  PetscCall(TSGetMaxTime(ts, &end));
  PetscCall(TSGetMaxSteps(ts, &steps));
  PetscCall(TSGetTolerances(ts, &atol, NULL, &rtol, NULL));
  PetscCheck(dt > 0 && isfinite(dt), comm, PETSC_ERR_ARG_OUTOFRANGE, "-" SLIP_TS_DT " is %.6g, expected a number > 0 s",
             (double)dt);
  PetscCheck(end > time && isfinite(end), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_max_time is %.6g, expected a number > %.6g s, the start", (double)end, (double)time);
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTNONE, &constant));
  PetscCall(TSAdaptGetStepLimits(adapt, NULL, &longest));
  if (constant) longest = dt;
  PetscCheck(end - time <= SLIP_MAX_RUN * longest, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-%s is %.6g s, of which a run of %.6g s takes %.3g, expected at most %.6g steps",
             constant ? SLIP_TS_DT : "ts_adapt_dt_max", (double)longest, (double)(end - time),
             (double)((end - time) / longest), SLIP_MAX_RUN);
  PetscCheck(steps >= 0, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_max_steps is %" PetscInt_FMT ", expected a whole number >= 0", steps);
  PetscCheck(rtol >= 0 && isfinite(rtol), comm, PETSC_ERR_ARG_OUTOFRANGE, "-ts_rtol is %.6g, expected a number >= 0",
             (double)rtol);
  PetscCheck(atol >= 0 && isfinite(atol), comm, PETSC_ERR_ARG_OUTOFRANGE, "-ts_atol is %.6g, expected a number >= 0",
             (double)atol);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheCheckOptions - refuses options that PETSc accepts and a run with friction cannot use: types other than bathe
  and moreau, which ignore the constraint, an interpolated end, and invalid steps, times and tolerances

  Collective; after TSSetFromOptions().

  Input Parameter:
. ts - the TS

  Level: intermediate

  Note:
  At an interpolated end, -ts_exact_final_time interpolate, only the solution would be that of the final time: reaction,
  outputs, results and checkpoints are those of steps.

  Errors: PETSC_ERR_SUP, with the type that -ts_type gave it, or -ts_exact_final_time; PETSC_ERR_ARG_OUTOFRANGE, with
  the option of the number.

.seealso: TSBATHE, SlipSmallConfigureTS()
@*/
PetscErrorCode TSBatheCheckOptions(TS ts)
{
  const SlipProblemOps *problem;
  TSExactFinalTimeOption end;
  PetscBool bathe;
  TSType type;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscCall(TSGetType(ts, &type));
  PetscCall(TSGetSlipProblem(ts, &problem, NULL));
  PetscCall(TSBatheIs(ts, &bathe));
  PetscCheck(bathe || (problem && problem->steps.any_integrator), PetscObjectComm((PetscObject)ts), PETSC_ERR_SUP,
             "-ts_type %s knows no friction, expected " TSBATHE " or " TSMOREAU, type);
  PetscCall(TSGetExactFinalTime(ts, &end));
  PetscCheck(end != TS_EXACTFINALTIME_INTERPOLATE, PetscObjectComm((PetscObject)ts), PETSC_ERR_SUP,
             "-ts_exact_final_time interpolate: what is written and compared is that of steps, expected matchstep (the "
             "last step ends at -ts_max_time) or stepover (the first one beyond it)");
  PetscCall(CheckNumbers(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipReportEnd - prints the last line of a summary: when a run ended and, if that was before its final time, why

  Collective; after TSSolve().

  Input Parameters:
+ ts    - the TS
- state - text that is added about the end, or NULL

  Output Parameter:
. complete - whether the final time was reached

  Level: intermediate

  Note:
  A program whose run is not complete ends with SLIP_EXIT_INCOMPLETE.

.seealso: SlipFaultReportEnd(), SlipOutputFinish()
@*/
PetscErrorCode SlipReportEnd(TS ts, const char state[], PetscBool *complete)
{
  TSConvergedReason reason;
  PetscReal time, end;
  PetscInt steps;
  char why[128] = "", long_time[40] = "", line[256]; /* by C's own printf, since PETSc's %g writes "5." for 5 */

  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscAssertPointer(complete, 3);
  PetscCall(TSGetTime(ts, &time));
  PetscCall(TSGetMaxTime(ts, &end));
  PetscCall(TSGetMaxSteps(ts, &steps));
  PetscCall(TSGetConvergedReason(ts, &reason));
  *complete = time >= end * (1 - 10 * PETSC_MACHINE_EPSILON) ? PETSC_TRUE : PETSC_FALSE; /* 10: sums of steps */
  if (time >= DAYS) {
    SlipTimeText(time, 6, line, sizeof(line));
    (void)snprintf(long_time, sizeof(long_time), " (%.32s)", line);
  }
  if (!*complete) {
    if (reason == TS_CONVERGED_ITS)
      (void)snprintf(why, sizeof(why), "stopped by -ts_max_steps %lld at ", (long long)steps);
    else if (reason == TS_CONVERGED_USER)
      (void)snprintf(why, sizeof(why), "stopped on demand at ");
    else
      (void)snprintf(why, sizeof(why), "stopped (%s) at ", TSConvergedReasons[reason]);
    (void)snprintf(line, sizeof(line), "%st = %g of %g s%s", why, (double)time, (double)end, long_time);
  } else
    (void)snprintf(line, sizeof(line), "t = %g s%s", (double)time, long_time);
  PetscCall(PetscPrintf(PetscObjectComm((PetscObject)ts), "%-24s %s%s%s\n", "end:", line, state && state[0] ? ", " : "",
                        state ? state : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}
