/* Limits of the steps of all integrators: they end at corners of the loading (SlipStepOps.corner), before each attempt
   of our types and, as TSPreStep, before each step of PETSc's; errors where a step is below the rounding of time or a
   state is not finite; and constant steps that cannot be taken as the user set them. */
#include <slipstep/private/slipts.h>
#include <slipstep/rooms/slipsys.h>

/* Constant steps grow back by this factor per step, because a length that was too long may still be too long. */
#define GROW_BACK 4

PetscErrorCode SlipRunFails(TS ts)
{
  PetscErrorCode (*told)(TS);

  PetscFunctionBegin;
  PetscCall(PetscObjectQueryFunction((PetscObject)ts, SLIP_RUN_FAILS_METHOD, &told));
  if (told) PetscCall((*told)(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether h is too short for a step from the time of ts. least: the shortest possible step [s] */
PetscBool SlipStepIsLost(TS ts, PetscReal h, PetscReal *least)
{
  *least = PETSC_MACHINE_EPSILON * PetscAbsReal(ts->ptime);
  return h >= *least || ts->ptime + h >= ts->max_time ? PETSC_FALSE : PETSC_TRUE;
}

/* Checks ts->time_step before an attempt. A step below the rounding of time does not advance; runs of centuries with
   tight tolerances need about four times that at the onset of an event. The last step to the final time may be that
   short, and must not pass it by rounding, because TSAdaptChoose() of PETSc 3.22 ends a run that does. */
PetscErrorCode SlipGuardStep(TS ts)
{
  const PetscReal t = ts->ptime;
  PetscReal now;
  const PetscReal h = ts->exact_final_time == TS_EXACTFINALTIME_MATCHSTEP
                        ? SlipControlEnd(ts->time_step, t, ts->max_time)
                        : ts->time_step;
  PetscReal least;
  const char *adapt = ts->adapt ? ((PetscObject)ts->adapt)->type_name : NULL;

  PetscFunctionBegin;
  ts->time_step = h;
  if (!SlipStepIsLost(ts, h, &least)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipRunFails(ts));
  PetscCall(SlipClockRead(ts, &now, NULL));
  SETERRQ(
    PetscObjectComm((PetscObject)ts), PETSC_ERR_CONV_FAILED,
    "At time %.15g s the next step is %g s, below the rounding of that time; expected at least %g s (-ts_type %s, "
    "-ts_adapt_type %s, -ts_adapt_dt_min %g s)",
    (double)now, (double)h, (double)least, ((PetscObject)ts)->type_name, adapt ? adapt : "none",
    (double)(ts->adapt ? ts->adapt->dt_min : 0));
}

/* Checks the number of attempts in a row that the controller has rejected. */
PetscErrorCode SlipGuardRejections(TS ts, PetscInt rejections)
{
  PetscReal now;

  PetscFunctionBegin;
  if (ts->max_reject < 0 || rejections <= ts->max_reject) PetscFunctionReturn(PETSC_SUCCESS);
  ts->reason = TS_DIVERGED_STEP_REJECTED;
  PetscCall(SlipClockRead(ts, &now, NULL));
  PetscCheck(!ts->errorifstepfailed, PetscObjectComm((PetscObject)ts), PETSC_ERR_NOT_CONVERGED,
             "At time %g s %" PetscInt_FMT " attempts in a row at a step were rejected (-ts_adapt_type %s), and "
             "-ts_max_reject is %" PetscInt_FMT ": %s",
             (double)now, rejections, ((PetscObject)ts->adapt)->type_name, ts->max_reject,
             TSConvergedReasons[ts->reason]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the time after an accepted step, which is the final time if only rounding separates them. */
PetscReal SlipTimeAfterStep(TS ts)
{
  const PetscReal time = ts->ptime + ts->time_step, end = ts->max_time;
  const PetscBool match = ts->exact_final_time == TS_EXACTFINALTIME_MATCHSTEP ? PETSC_TRUE : PETSC_FALSE;

  return match && time < end && SlipControlAtEnd(time, end) ? end : time;
}

PetscReal SlipStepAfterCorner(TS ts, PetscReal end, PetscReal whole)
{
  const PetscReal left = ts->max_time - end;

  return ts->exact_final_time == TS_EXACTFINALTIME_MATCHSTEP && left > 0 ? PetscMin(whole, left) : whole;
}

/* Ends a run if a constant step h of an explicit method left the domain of the right-hand side. A controller would
   reject it, but shorter constant steps would be too many, from a state that longer ones have made inaccurate. */
PetscErrorCode SlipGuardConstant(TS ts, PetscReal h)
{
  PetscBool constant;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, &constant));
  if (!constant) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipRunFails(ts));
  SETERRQ(PetscObjectComm((PetscObject)ts), PETSC_ERR_CONV_FAILED,
          "At time %.6g s a constant step of %.6g s leads to what is no state of the problem (-ts_type %s); expected a "
          "shorter -" SLIP_TS_DT ", or another -ts_adapt_type than none",
          (double)ts->ptime, (double)h, ((PetscObject)ts)->type_name);
}

/* Records that a constant step h of an implicit method was rejected, and warns once per run. */
PetscErrorCode SlipConstantRefused(TS ts, PetscReal h, SlipConstant *steps)
{
  PetscMPIInt rank;

  PetscFunctionBegin;
  if (steps->asked > 0) PetscFunctionReturn(PETSC_SUCCESS);
  steps->asked = h;
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm((PetscObject)ts), &rank));
  if (!rank && !steps->told)
    PetscCall(
      SlipWarning("a constant step of %.6g s cannot be taken at time %.6g s (-ts_adapt_type none): steps are shorter "
                  "from there, and grow back to it",
                  (double)h, (double)ts->ptime));
  steps->told = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the step after an accepted one of h; next: the step unless constant steps were shortened */
PetscReal SlipConstantAfter(TS ts, PetscReal h, PetscReal next, SlipConstant *steps)
{
  if (steps->asked <= 0) return next;
  next = PetscMin(GROW_BACK * h, steps->asked);
  if (next == steps->asked) steps->asked = 0;
  return SlipStepAfterCorner(ts, ts->ptime, next);
}

/* Returns the step after an attempt that left the domain: the controller's, or PETSc's share of the attempt's. */
PetscErrorCode SlipStepAfterFailure(TS ts, PetscReal *next_h)
{
  PetscErrorCode (*choose)(TSAdapt, TS, PetscReal, PetscReal *);

  PetscFunctionBegin;
  *next_h = ts->time_step * ts->adapt->scale_solve_failed;
  PetscCall(PetscObjectQueryFunction((PetscObject)ts->adapt, "TSAdaptChooseAfterFailure_C", &choose));
  if (choose) PetscCall((*choose)(ts->adapt, ts, ts->time_step, next_h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks that every component is finite: a NaN or infinity stays in the sum over all of them. */
PetscErrorCode SlipGuardState(Vec w, PetscBool *good)
{
  PetscScalar sum;

  PetscFunctionBegin;
  PetscCall(VecSum(w, &sum));
  *good = PetscIsInfOrNanScalar(sum) ? PETSC_FALSE : PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- corners of the loading ---- */

PetscErrorCode SlipMeetCorner(TS ts, PetscReal *whole, PetscReal *corner)
{
  PetscBool constant;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, &constant));
  if (!ts->steps && !constant) ts->time_step = PetscMin(ts->time_step, ts->adapt->dt_max);
  *whole = ts->time_step;
  *corner = PETSC_MAX_REAL;
  SlipProblemTry(ts, steps.corner, ts->ptime, corner);
  if (ts->time_step >= *corner - ts->ptime)
    ts->time_step = *corner - ts->ptime;
  else
    *corner = PETSC_MAX_REAL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where error estimates alone limit them, explicit steps of PETSc's types are at the bound of their stability: slip
   rates oscillate about the balance, which adds slip unnoticed. Errors decay without a change of sign up to so many
   relaxation times for pairs of orders 2 and 3, and up to more for higher ones. */
#define RELAXATIONS 1.5

PetscErrorCode SlipMeetRelaxation(TS ts)
{
  PetscReal rate = 0;
  PetscBool constant;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, &constant));
  if (!constant && !ts->usessnes) SlipProblemTry(ts, steps.relaxation, ts->vec_sol, &rate);
  if (rate > 0) ts->time_step = PetscMin(ts->time_step, PetscMax(RELAXATIONS / rate, ts->adapt->dt_min));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipMeetCornerBefore(TS ts, PetscBool ours, PetscBool *warned)
{
  PetscReal next = PETSC_MAX_REAL, after = PETSC_MAX_REAL, h;
  PetscBool constant;
  PetscMPIInt rank;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTNONE, &constant));
  if (!constant) {
    if (!ours) PetscCall(SlipMeetCorner(ts, &h, &next));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (*warned) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSGetTimeStep(ts, &h));
  SlipProblemTry(ts, steps.corner, ts->ptime, &next);
  if (ts->ptime + h <= next || SlipControlAtEnd(ts->ptime + h, next)) PetscFunctionReturn(PETSC_SUCCESS);
  SlipProblemTry(ts, steps.corner, next, &after);
  if (ours && after - next >= h) PetscFunctionReturn(PETSC_SUCCESS);
  *warned = PETSC_TRUE;
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm((PetscObject)ts), &rank));
  if (!rank && ours)
    PetscCall(SlipWarning("between its corners at %.6g and %.6g s the loading changes within less than the constant "
                          "step of %.6g s, so that one step has all of it: use another -ts_adapt_type than none, or a "
                          "shorter -" SLIP_TS_DT,
                          (double)next, (double)after, (double)h));
  if (!rank && !ours)
    PetscCall(
      SlipWarning("the constant step from %.6g to %.6g s passes a corner of the loading at %.6g s, and -ts_type %s "
                  "sees nothing of a pulse between its stages: use another -ts_adapt_type than none, or a "
                  "-" SLIP_TS_DT " of whose multiples the corners are",
                  (double)ts->ptime, (double)(ts->ptime + h), (double)next, ((PetscObject)ts)->type_name));
  PetscFunctionReturn(PETSC_SUCCESS);
}
