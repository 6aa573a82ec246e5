/* Ends steps of any integrator at corners of the loading (SlipStepOps.corner): before each attempt of our types and,
   as TSPreStep, before each step of PETSc's types. It also applies the controller's longest step to the first step,
   which no controller has chosen. */
#include <slipstep/private/slipts.h>
#include <slipstep/rooms/slipsys.h>

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
