/* What no integrator may go on with: a step that time does not resolve, and a state that is no number. */
#include <slipstep/private/slipts.h>

PetscErrorCode SlipRunFails(TS ts)
{
  PetscErrorCode (*told)(TS);

  PetscFunctionBegin;
  PetscCall(PetscObjectQueryFunction((PetscObject)ts, SLIP_RUN_FAILS_METHOD, &told));
  if (told) PetscCall((*told)(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is h too short for a step from the time of ts on? least: the shortest that is not [s] */
PetscBool SlipStepIsLost(TS ts, PetscReal h, PetscReal *least)
{
  *least = PETSC_MACHINE_EPSILON * PetscAbsReal(ts->ptime);
  return h >= *least || ts->ptime + h >= ts->max_time ? PETSC_FALSE : PETSC_TRUE;
}

/* Before an attempt with ts->time_step. A step below the rounding of time goes nowhere; runs of centuries at tight tolerances get along
   with some four times that, at the onset of an event. The rest of a run to its final time may be that short, and goes beyond it by no
   rounding: TSAdaptChoose() of PETSc 3.22 ends a run that does. */
PetscErrorCode SlipGuardStep(TS ts)
{
  const PetscReal t = ts->ptime;
  const PetscReal h = ts->exact_final_time == TS_EXACTFINALTIME_MATCHSTEP
                        ? SlipControlEnd(ts->time_step, t, ts->max_time)
                        : ts->time_step;
  PetscReal least;
  const char *adapt = ts->adapt ? ((PetscObject)ts->adapt)->type_name : NULL;

  PetscFunctionBegin;
  ts->time_step = h;
  if (!SlipStepIsLost(ts, h, &least)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipRunFails(ts));
  SETERRQ(
    PetscObjectComm((PetscObject)ts), PETSC_ERR_CONV_FAILED,
    "At time %.15g s the next step is %g s, below the rounding of that time; expected at least %g s (-ts_type %s, "
    "-ts_adapt_type %s, -ts_adapt_dt_min %g s)",
    (double)t, (double)h, (double)least, ((PetscObject)ts)->type_name, adapt ? adapt : "none",
    (double)(ts->adapt ? ts->adapt->dt_min : 0));
}

/* The time after the step that is taken, that of the end where only rounding is left until then. */
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

/* Is every component a number? In the sum of all what is none remains, on any number of ranks. */
PetscErrorCode SlipGuardState(Vec w, PetscBool *good)
{
  PetscScalar sum;

  PetscFunctionBegin;
  PetscCall(VecSum(w, &sum));
  *good = PetscIsInfOrNanScalar(sum) ? PETSC_FALSE : PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
