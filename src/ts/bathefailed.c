/* TSBATHE after an attempt that did not converge: the next step, instabilities that steps must not pass, and what is
   told of it. */
#include <slipstep/private/slipbathe.h>
#include <petsc/private/snesimpl.h>

/* If an attempt fails because of an instability, the instability begins before the attempt's end, the barrier. Steps go
   half way to the barrier, so that each step, accepted or rejected, halves the uncertainty. Several rejections in a row
   cut by more: a few attempts shorten years to the seconds in which it grows. After most_towards accepted cut steps in
   a row one is not cut: the instability may have begun, and steps must follow it. */
static const PetscReal unstable_factor[] = {0.5, 0.2, 0.1};
enum { most_towards = 2 };
/* The barrier counts as reached if less than twice this share of the last step is left. */
static const PetscReal at_barrier = 1e-2, no_barrier = PETSC_MAX_REAL;
/* A residual below this share of a stage's first one shows that the solver was converging */
static const PetscReal floor_share = 1e-3;

void TSBatheFailuresBegin(TSBatheFailures *f)
{
  f->row = f->towards = 0;
  f->constant = (SlipConstant){.asked = 0};
  f->barrier = no_barrier;
}

PetscErrorCode TSBatheRestore(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  PetscCall(VecCopy(ba->X0, ts->vec_sol));
  if (ba->con) PetscCall(VecCopy(ba->r0, ba->r));
  PetscCall(SlipProblemRollBack(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the next step within the controller's bounds, and not beyond the end of a run that must end exactly there. */
PetscErrorCode TSBatheSetStep(TS ts, PetscReal h)
{
  PetscFunctionBegin;
  h = PetscClipInterval(h, ts->adapt->dt_min, ts->adapt->dt_max);
  PetscCall(TSSetTimeStep(ts, SlipStepAfterCorner(ts, ts->ptime, h)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns if shorter steps will not make a solve converge, because rounding, differences or an approximate Jacobian limit
   its residual: that is small then, and the first repetition, with a shorter step, has not halved it. */
static PetscErrorCode TSBatheTellFloor(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const char *prefix = ((PetscObject)ts->snes)->prefix ? ((PetscObject)ts->snes)->prefix : "";
  PetscReal norm, first;
  PetscMPIInt rank;

  PetscFunctionBegin;
  if (ba->con || ba->failures.floor_told || ba->failures.row > 2) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESGetFunctionNorm(ts->snes, &norm));
  first = ts->snes->rtol > 0 ? ts->snes->ttol / ts->snes->rtol : PETSC_MAX_REAL;
  if (ba->failures.row == 1) ba->failures.stagnated = norm < floor_share * first ? norm : 0;
  if (ba->failures.row == 1 || !(ba->failures.stagnated > 0) || norm < 0.5 * ba->failures.stagnated)
    PetscFunctionReturn(PETSC_SUCCESS);
  ba->failures.floor_told = PETSC_TRUE;
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm((PetscObject)ts), &rank));
  if (!rank)
    PetscCall(SlipWarning(
      "at time %.6g s a stage ended as %s with the residual %.3g, and with %.3g at a shorter step: shorter steps do "
      "not help there. -%ssnes_rtol and -%ssnes_atol say what is small enough, -%ssnes_test_jacobian whether the "
      "Jacobian fits",
      (double)ts->ptime, SNESConvergedReasons[ba->last.reason], (double)ba->failures.stagnated, (double)norm, prefix,
      prefix, prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Limits the step h of the controller after an attempt that went past an instability. */
static PetscErrorCode TSBatheRefused(TS ts, PetscReal *h)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const PetscInt last = PETSC_STATIC_ARRAY_LENGTH(unstable_factor) - 1;
  PetscBool constant;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, &constant));
  ba->failures.barrier = constant ? no_barrier : PetscMin(ba->failures.barrier, ts->ptime + ba->last.dt);
  ba->failures.towards = 0;
  if (constant)
    *h = PetscMin(*h, ba->last.dt * unstable_factor[last]);
  else
    *h = PetscMin(*h, (ba->failures.barrier - ts->ptime) * unstable_factor[PetscMin(ba->failures.row - 1, last)]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Limits the step h of the controller after an accepted step, if an instability is ahead. */
void TSBatheApproach(TS ts, PetscReal *h)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const PetscReal limit = unstable_factor[0] * (ba->failures.barrier - ts->ptime);

  if (limit < at_barrier * ba->last.dt) ba->failures.barrier = no_barrier;
  if (ba->failures.barrier == no_barrier || *h <= limit || ba->failures.towards == most_towards) {
    ba->failures.towards = 0;
  } else {
    ba->failures.towards++;
    *h = limit;
  }
}

/* Handles a stage that did not converge: restores the start, chooses the next step, and ends a run after too many
   failures. whole: the step before it was cut for a corner or a stop [s]; 0: it was not cut. */
PetscErrorCode TSBatheFailed(TS ts, PetscReal whole)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscErrorCode (*choose)(TSAdapt, TS, PetscReal, PetscReal *);
  PetscReal residual, time, h = ba->last.dt;
  PetscBool unstable = PETSC_FALSE, constant;
  PetscInt worst;
  Vec f, size;

  PetscFunctionBegin;
  TSBatheMethodRefused(ts);
  PetscCall(TSBatheRestore(ts));
  if (++ba->failures.row >= ba->failures.most) {
    PetscCall(TSBatheRunMonitors(ts));
    if (ba->con)
      PetscCall(SNESSlipGetWorstCell(ts->snes, &worst, &residual));
    else {
      PetscCall(SNESGetFunction(ts->snes, &f, NULL, NULL));
      PetscCall(VecDuplicate(f, &size));
      PetscCall(VecCopy(f, size));
      PetscCall(VecAbs(size));
      PetscCall(VecMax(size, &worst, &residual));
      PetscCall(VecDestroy(&size));
    }
    PetscCall(SlipRunFails(ts));
    PetscCall(SlipClockRead(ts, &time, NULL));
    SETERRQ(PetscObjectComm((PetscObject)ts), PETSC_ERR_NOT_CONVERGED,
            "%" PetscInt_FMT
            " attempts in a row did not converge (-ts_bathe_max_failures) at time %g, step %" PetscInt_FMT
            "; the last tried dt = %g and ended as %s, largest residual %g in cell %" PetscInt_FMT,
            ba->failures.row, (double)time, ts->steps, (double)h, SNESConvergedReasons[ba->last.reason],
            (double)residual, worst);
  }
  PetscCall(TSBatheTellFloor(ts));
  PetscCall(PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, &constant));
  if (constant && ba->failures.row == 1) PetscCall(SlipConstantRefused(ts, PetscMax(h, whole), &ba->failures.constant));
  if (!ts->reason) {
    if (ba->con && ba->was == &TSBatheImplicit) PetscCall(SlipConstraintWasUnstable(ba->con, &unstable));
    PetscCall(PetscObjectQueryFunction((PetscObject)ts->adapt, "TSAdaptChooseAfterFailure_C", &choose));
    if (choose)
      PetscCall((*choose)(ts->adapt, ts, h, &h));
    else if (!unstable)
      h = ts->time_step; /* TSAdaptCheckStage() has scaled it by scale_solve_failed */
    if (unstable) PetscCall(TSBatheRefused(ts, &h));
    PetscCall(TSBatheSetStep(ts, h));
  }
  PetscCall(TSBatheRunMonitors(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}
