/* TSBATHE's step: attempts, error estimates, the controller's choice, and recovery from failed stages. */
#include <slipstep/private/slipts.h>
#include <petsc/private/snesimpl.h>
#include <petsctime.h>

/* If an attempt fails because of an instability, the instability begins before the attempt's end, the barrier. Steps go
   half way to the barrier, so that each step, accepted or rejected, halves the uncertainty. Several rejections in a row
   cut by more: a few attempts shorten years to the seconds in which it grows. After most_towards accepted cut steps in
   a row one is not cut: the instability may have begun, and steps must follow it. */
static const PetscReal unstable_factor[] = {0.5, 0.2, 0.1};
enum { most_towards = 2 };
/* The barrier counts as reached if less than twice this share of the last step is left. */
static const PetscReal at_barrier = 1e-2, no_barrier = PETSC_MAX_REAL;
/* A step that must end where a cell stops goes so far beyond that, over its length, that the cell sticks at its end;
   the allowed error of that; attempts to meet it */
static const PetscReal beyond_stop = 1e-3, near_stop = 1e-2;
enum { max_stop_tries = 4 };

/* Returns whether the attempt doubles the step. It does not if the controller uses no error and the user has not chosen
   doubling. */
static PetscErrorCode TSBatheWantsDoubling(TS ts, PetscBool *flg)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscBool none, needs = PETSC_TRUE;
  PetscErrorCode (*f)(TSAdapt, PetscBool *);

  PetscFunctionBegin;
  *flg = PETSC_FALSE;
  if (ba->error == TSBATHE_ERROR_NONE) PetscFunctionReturn(PETSC_SUCCESS);
  if (ba->error == TSBATHE_ERROR_EMBEDDED && ba->k0_known) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscObjectQueryFunction((PetscObject)ts->adapt, "TSAdaptNeedsError_C", &f));
  if (f) PetscCall((*f)(ts->adapt, &needs));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ts->adapt, &none, TSADAPTNONE, TSADAPTHISTORY, ""));
  if (none && !(ba->error_set && ba->error == TSBATHE_ERROR_DOUBLING)) needs = PETSC_FALSE;
  *flg = needs;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the vectors that only doubling needs. */
static PetscErrorCode TSBatheSetUpDoubling(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  if (!ba->Wfull) PetscCall(VecDuplicate(ts->vec_sol, &ba->Wfull));
  if (!ba->Wmid) PetscCall(VecDuplicate(ts->vec_sol, &ba->Wmid));
  if (ba->con && !ba->rmid) PetscCall(VecDuplicate(ba->r, &ba->rmid));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes one step of an attempt and adds its residual, or 2 if it fails. */
static PetscErrorCode TSBatheCounted(TS ts, PetscReal t, PetscReal h, Vec w0, Vec r0, Vec w1, Vec w2, Vec r2,
                                     PetscReal *residual, PetscBool *ok)
{
  const TS_Bathe *ba = (const TS_Bathe *)ts->data;
  PetscReal res = 0.0;

  PetscFunctionBegin;
  if (ba->last.method == TSBATHE_METHOD_EXPLICIT && ba->stabilised)
    PetscCall(TSStabilisedSubstep(ts, t, h, w0, w1, w2, r2, ok));
  else if (ba->last.method == TSBATHE_METHOD_EXPLICIT)
    PetscCall(TSMoreauSubstep(ts, t, h, w0, w1, w2, r2, ok));
  else
    PetscCall(TSBatheSubstep(ts, t, h, w0, r0, w1, w2, r2, &res, ok));
  *residual += *ok ? res : 2.0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes a step h as two halves, whose result is the solution, and as a whole, which serves the error only. The whole
   comes first, so that Y, K2 and r end as those of the second half. */
static PetscErrorCode TSBatheDoubling(TS ts, PetscReal h, PetscReal *residual, PetscBool *ok)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscReal t = ts->ptime;
  PetscInt run = 1;

  PetscFunctionBegin;
  PetscCall(TSBatheSetUpDoubling(ts));
  PetscCall(TSBatheCounted(ts, t, h, ba->X0, ba->r0, ba->Y[0], ba->Wfull, ba->r, residual, ok));
  if (*ok) {
    run++;
    PetscCall(TSBatheCounted(ts, t, 0.5 * h, ba->X0, ba->r0, ba->Y[0], ba->Wmid, ba->rmid, residual, ok));
  }
  if (*ok) {
    run++;
    PetscCall(SlipProblemAdvance(ts, t + 0.5 * h, ba->Wmid));
    PetscCall(TSBatheCounted(ts, t + 0.5 * h, 0.5 * h, ba->Wmid, ba->rmid, ba->Y[0], ba->Y[1], ba->r, residual, ok));
  }
  *residual += 2.0 * (3 - run);
  if (!*ok) PetscFunctionReturn(PETSC_SUCCESS);
  if (ba->last.method == TSBATHE_METHOD_IMPLICIT)
    PetscCall(TSBatheEndDerivative(ts, 0.5 * h, ba->Wmid, ba->Y[0], ba->Y[1], ba->K2));
  PetscCall(VecCopy(ba->Wmid, ba->Wm));
  ba->share = 0.5;
  PetscCall(TSBatheDoublingError(ts, ba->E));
  PetscCall(TSBatheErrorNorm(ts, NORM_2, &ba->last.error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSBatheSingle(TS ts, PetscReal h, PetscReal *residual, PetscBool *ok)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  PetscCall(TSBatheCounted(ts, ts->ptime, h, ba->X0, ba->r0, ba->Y[0], ba->Y[1], ba->r, residual, ok));
  if (!*ok) PetscFunctionReturn(PETSC_SUCCESS);
  if (ba->last.method == TSBATHE_METHOD_IMPLICIT)
    PetscCall(TSBatheEndDerivative(ts, h, ba->X0, ba->Y[0], ba->Y[1], ba->K2));
  PetscCall(VecCopy(ba->Y[0], ba->Wm));
  ba->share = ba->last.method == TSBATHE_METHOD_EXPLICIT ? 0.5 : ba->c.gamma;
  if (ba->error != TSBATHE_ERROR_EMBEDDED || !ba->k0_known) PetscFunctionReturn(PETSC_SUCCESS);
  if (ba->last.method == TSBATHE_METHOD_EXPLICIT && ba->stabilised)
    PetscCall(TSStabilisedError(ts, h, ba->E));
  else if (ba->last.method == TSBATHE_METHOD_EXPLICIT)
    PetscCall(TSMoreauError(ts, h, ba->E));
  else
    PetscCall(TSBatheEmbeddedError(ts, h, ba->E));
  PetscCall(TSBatheErrorNorm(ts, NORM_2, &ba->last.error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Repeats the step in an even number of parts for TSBatheSetParts(); the error estimate does not change. */
static PetscErrorCode TSBatheInParts(TS ts, PetscReal h, PetscInt parts, PetscReal *residual, PetscBool *ok)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const PetscReal part = h / (PetscReal)parts;

  PetscFunctionBegin;
  PetscCall(TSBatheSetUpDoubling(ts));
  PetscCall(SlipProblemRollBack(ts));
  for (PetscInt k = 0; k < parts && *ok; k++) {
    const PetscBool odd = k % 2 ? PETSC_TRUE : PETSC_FALSE;
    Vec from = k ? (odd ? ba->Wmid : ba->Y[1]) : ba->X0, rfrom = k ? (odd ? ba->rmid : ba->r) : ba->r0;

    if (k) PetscCall(SlipProblemAdvance(ts, ts->ptime + (PetscReal)k * part, from));
    PetscCall(TSBatheCounted(ts, ts->ptime + (PetscReal)k * part, part, from, rfrom, ba->Y[0],
                             odd ? ba->Y[1] : ba->Wmid, odd ? ba->r : ba->rmid, residual, ok));
    if (*ok && ba->part)
      PetscCall((*ba->part)(ts, ts->ptime + (PetscReal)(k + 1) * part, odd ? ba->Y[1] : ba->Wmid, ba->part_ctx));
  }
  if (!*ok) PetscFunctionReturn(PETSC_SUCCESS);
  if (ba->last.method == TSBATHE_METHOD_IMPLICIT)
    PetscCall(TSBatheEndDerivative(ts, part, ba->Wmid, ba->Y[0], ba->Y[1], ba->K2));
  PetscCall(VecCopy(ba->Wmid, ba->Wm));
  ba->share = 1.0 - 1.0 / (PetscReal)parts;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts the products since the last attempt, so that the sum over attempts has all products of a run. */
static PetscErrorCode TSBatheProducts(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  SlipProducts now;

  PetscFunctionBegin;
  PetscCall(SlipProductsGet(&now));
  ba->last.products = SlipProductsSince(&now, &ba->cost);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the attempt and fills its record, except whether it is accepted. */
static PetscErrorCode TSBatheAttempt(TS ts, PetscBool *ok)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscReal h = ts->time_step;
  PetscReal parts_residual = 0.0; /* controllers must not see it, as it is of other steps */
  SlipProducts before, after;
  PetscBool doubling;
  PetscLogDouble begin, end;

  PetscFunctionBegin;
  PetscCall(PetscTime(&begin));
  ba->last = (SlipAttempt){.step = ts->steps, .time = ts->ptime, .dt = h, .error = -1.0, .method = ba->now};
  if (ba->stabilised)
    PetscCall(TSStabilisedStart(ts, PETSC_TRUE));
  else if (ba->now == TSBATHE_METHOD_EXPLICIT && !ba->start.known)
    PetscCall(TSMoreauStart(ts));
  ba->end.known = PETSC_FALSE;
  PetscCall(TSBatheWantsDoubling(ts, &doubling));
  PetscCall(SlipProductsGet(&before));
  if (doubling)
    PetscCall(TSBatheDoubling(ts, h, &ba->last.residual, ok));
  else
    PetscCall(TSBatheSingle(ts, h, &ba->last.residual, ok));
  PetscCall(SlipProductsGet(&after));
  after = SlipProductsSince(&after, &before);
  if (ba->stabilised)
    TSStabilisedLearn(ts);
  else if (ba->method == TSBATHE_METHOD_AUTO && ba->last.solves)
    SlipMethodLearn(&ba->costs, ba->now == TSBATHE_METHOD_EXPLICIT ? PETSC_TRUE : PETSC_FALSE, h, ba->longest,
                    (PetscReal)(after.all + after.pc) / (PetscReal)ba->last.solves);
  if (ba->now == TSBATHE_METHOD_EXPLICIT) ba->explicits++;
  if (*ok && ba->parts > 1) PetscCall(TSBatheInParts(ts, h, (doubling ? 2 : 1) * ba->parts, &parts_residual, ok));
  if (*ok) PetscCall(SlipGuardState(ba->Y[1], ok));
  if (*ok) PetscCall(TSBatheKeepErrorShare(ts));
  PetscCall(PetscTime(&end));
  ba->last.converged = *ok;
  PetscCall(TSBatheProducts(ts));
  ba->last.wall = end - begin;
  ba->attempts++;
  ba->solves += ba->last.solves;
  ba->newton += ba->last.newton;
  ba->linear += ba->last.linear;
  ba->k2_known = *ok;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Restores the state and the reaction at the step's start. */
static PetscErrorCode TSBatheRestore(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  PetscCall(VecCopy(ba->X0, ts->vec_sol));
  if (ba->con) PetscCall(VecCopy(ba->r0, ba->r));
  PetscCall(SlipProblemRollBack(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TSRollBack_Bathe(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  PetscCall(TSBatheRestore(ts));
  PetscCall(PetscObjectGetId((PetscObject)ts->vec_sol, &ba->sol_id));
  PetscCall(PetscObjectStateGet((PetscObject)ts->vec_sol, &ba->sol_state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the next step within the controller's bounds, and not beyond the end of a run that must end exactly there. */
static PetscErrorCode TSBatheSetStep(TS ts, PetscReal h)
{
  PetscFunctionBegin;
  h = PetscClipInterval(h, ts->adapt->dt_min, ts->adapt->dt_max);
  PetscCall(TSSetTimeStep(ts, SlipStepAfterCorner(ts, ts->ptime, h)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSBatheIsConstant(TS ts, PetscBool *constant)
{
  return PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, constant);
}

/* Limits the step h of the controller after an attempt that went past an instability. */
static PetscErrorCode TSBatheRefused(TS ts, PetscReal *h)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const PetscInt last = PETSC_STATIC_ARRAY_LENGTH(unstable_factor) - 1;
  PetscBool constant;

  PetscFunctionBegin;
  PetscCall(TSBatheIsConstant(ts, &constant));
  ba->barrier = constant ? no_barrier : PetscMin(ba->barrier, ts->ptime + ba->last.dt);
  ba->towards = 0;
  if (constant)
    *h = PetscMin(*h, ba->last.dt * unstable_factor[last]);
  else
    *h = PetscMin(*h, (ba->barrier - ts->ptime) * unstable_factor[PetscMin(ba->failures - 1, last)]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Limits the step h of the controller after an accepted step, if an instability is ahead. */
static void TSBatheApproach(TS ts, PetscReal *h)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const PetscReal limit = unstable_factor[0] * (ba->barrier - ts->ptime);

  if (limit < at_barrier * ba->last.dt) ba->barrier = no_barrier;
  if (ba->barrier == no_barrier || *h <= limit || ba->towards == most_towards) {
    ba->towards = 0;
  } else {
    ba->towards++;
    *h = limit;
  }
}

/* Begins a run: sets totals to 0, and the first step if the controller chooses it. */
static PetscErrorCode TSBatheBeginRun(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const SlipProblemOps *problem;
  void *ctx;
  PetscErrorCode (*f)(TSAdapt, TS, PetscReal *);
  PetscReal h = ts->time_step;

  PetscFunctionBegin;
  ba->attempts = ba->accepted = ba->solves = ba->newton = ba->linear = ba->failures = ba->towards = 0;
  ba->explicits = 0;
  PetscCall(TSBatheMethodBegin(ts));
  ba->constant = (SlipConstant){.asked = 0};
  ba->barrier = no_barrier;
  ba->error_share = 0;
  ba->last = (SlipAttempt){.time = ts->ptime, .error = -1.0};
  (void)SlipProductsRow(&ba->cost);
  PetscCall(TSGetSlipProblem(ts, &problem, &ctx));
  if (problem && problem->begin) PetscCall((*problem->begin)(ts, PETSC_FALSE, ctx));
  PetscCall(PetscObjectQueryFunction((PetscObject)ts->adapt, "TSAdaptChooseFirst_C", &f));
  if (f) {
    PetscCall((*f)(ts->adapt, ts, &h));
    PetscCall(TSBatheSetStep(ts, h));
  }
  if (problem && problem->begin) PetscCall((*problem->begin)(ts, PETSC_TRUE, ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets X0, r0 and K0, from which a step starts. They are the last step's end, r and K2 unless the solution was changed
   since then. */
static PetscErrorCode TSBatheBeginStep(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscObjectId id;
  PetscObjectState state;
  PetscBool begin = ts->steps == 0 && !ts->steprollback ? PETSC_TRUE : PETSC_FALSE, unchanged, fresh;

  PetscFunctionBegin;
  PetscCall(PetscObjectGetId((PetscObject)ts->vec_sol, &id));
  PetscCall(PetscObjectStateGet((PetscObject)ts->vec_sol, &state));
  unchanged = id == ba->sol_id && state == ba->sol_state ? PETSC_TRUE : PETSC_FALSE;
  fresh = begin || ts->steprestart ? PETSC_TRUE : PETSC_FALSE;
  if (ts->steprollback && unchanged && !fresh) PetscFunctionReturn(PETSC_SUCCESS); /* X0, r0, K0 are unchanged */
  PetscCall(SlipProblemAccept(ts));
  if (begin) PetscCall(TSBatheBeginRun(ts));
  PetscCall(VecCopy(ts->vec_sol, ba->X0));
  ba->start.known = PETSC_FALSE;
  PetscCall(TSBatheChooseMethod(ts));
  if (ba->con && ba->now == TSBATHE_METHOD_EXPLICIT && !ba->stabilised) {
    PetscCall(TSMoreauBegin(ts, !fresh && unchanged ? PETSC_TRUE : PETSC_FALSE));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (ba->con) {
    /* Stage 2's reaction of a cell that has just stopped contains the impulse that stopped it. In the next trapezoidal
       stage it would push the cell off again; resting cells therefore start with the reaction of static balance. */
    if (!ba->r_given && (fresh || !unchanged || ba->first == TSBATHE_STAGE_TRAPEZOIDAL))
      PetscCall(SlipConstraintInitialReaction(ba->con, ts->ptime, ts->vec_sol, ba->r));
    ba->r_given = PETSC_FALSE;
    PetscCall(VecCopy(ba->r, ba->r0));
  }
  if (ba->error != TSBATHE_ERROR_EMBEDDED) PetscFunctionReturn(PETSC_SUCCESS);
  if (ba->stabilised) {
    ba->k0_known = PETSC_FALSE;
    PetscCall(TSStabilisedStart(ts, !fresh && unchanged ? PETSC_TRUE : PETSC_FALSE));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!fresh && unchanged && ba->k2_known) {
    PetscCall(VecCopy(ba->K2, ba->K0));
    if (ba->con) PetscCall(TSBatheDropSticking(ts, ba->X0, ba->K0));
    ba->k0_known = PETSC_TRUE;
  } else
    PetscCall(TSBatheStartDerivative(ts, ts->ptime, ba->X0, ba->r0, ba->K0, &ba->k0_known));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSBatheRunMonitors(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  ba->last.products = SlipProductsRow(&ba->cost);
  PetscCall(SlipProductsPush(SLIP_PRODUCTS_LOOK));
  for (const TSBatheMonitor *m = ba->monitors; m; m = m->next) PetscCall((*m->fn)(ts, &ba->last, ts->vec_sol, m->ctx));
  PetscCall(SlipProductsPop());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Handles a stage that did not converge: restores the start, chooses the next step, and ends a run after too many
   failures. whole: the step before it was cut for a corner or a stop [s]; 0: it was not cut. */
static PetscErrorCode TSBatheFailed(TS ts, PetscReal whole)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscErrorCode (*f)(TSAdapt, TS, PetscReal, PetscReal *);
  PetscReal residual, time, h = ba->last.dt;
  PetscBool unstable = PETSC_FALSE, constant;
  PetscInt worst;

  PetscFunctionBegin;
  TSBatheMethodRefused(ts);
  PetscCall(TSBatheRestore(ts));
  if (++ba->failures >= ba->max_failures) {
    PetscCall(TSBatheRunMonitors(ts));
    PetscCall(TSBatheWorst(ts, &worst, &residual));
    PetscCall(SlipRunFails(ts));
    PetscCall(SlipClockRead(ts, &time, NULL));
    SETERRQ(
      PetscObjectComm((PetscObject)ts), PETSC_ERR_NOT_CONVERGED,
      "%" PetscInt_FMT " attempts in a row did not converge (-ts_bathe_max_failures) at time %g, step %" PetscInt_FMT
      "; the last tried dt = %g and ended as %s, largest residual %g in cell %" PetscInt_FMT,
      ba->failures, (double)time, ts->steps, (double)h, SNESConvergedReasons[ba->last.reason], (double)residual, worst);
  }
  PetscCall(TSBatheTellFloor(ts));
  PetscCall(TSBatheIsConstant(ts, &constant));
  if (constant && ba->failures == 1) PetscCall(SlipConstantRefused(ts, PetscMax(h, whole), &ba->constant));
  if (!ts->reason) {
    if (ba->con && ba->last.method == TSBATHE_METHOD_IMPLICIT) PetscCall(SlipConstraintWasUnstable(ba->con, &unstable));
    PetscCall(PetscObjectQueryFunction((PetscObject)ts->adapt, "TSAdaptChooseAfterFailure_C", &f));
    if (f)
      PetscCall((*f)(ts->adapt, ts, h, &h));
    else if (!unstable)
      h = ts->time_step; /* TSAdaptCheckStage() has scaled it by scale_solve_failed */
    if (unstable) PetscCall(TSBatheRefused(ts, &h));
    PetscCall(TSBatheSetStep(ts, h));
  }
  PetscCall(TSBatheRunMonitors(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Accepts the step whose end is in vec_sol. */
static PetscErrorCode TSBatheAccept(TS ts, PetscReal time)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  ba->status = TS_STEP_COMPLETE;
  ba->last.accepted = PETSC_TRUE;
  ba->accepted++;
  ts->ptime = time;
  PetscCall(PetscObjectGetId((PetscObject)ts->vec_sol, &ba->sol_id));
  PetscCall(PetscObjectStateGet((PetscObject)ts->vec_sol, &ba->sol_state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets the controller accept or reject a converged attempt. whole: as above */
static PetscErrorCode TSBatheJudge(TS ts, PetscReal whole, PetscBool *accept)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscReal next = ts->time_step;

  PetscFunctionBegin;
  ba->failures = 0;
  ba->status = TS_STEP_PENDING;
  PetscCall(VecCopy(ba->Y[1], ts->vec_sol));
  PetscCall(TSAdaptChoose(ts->adapt, ts, ts->time_step, NULL, &next, accept));
  ba->status = TS_STEP_INCOMPLETE;
  if (*accept) {
    PetscCall(TSBatheAccept(ts, SlipTimeAfterStep(ts)));
    PetscCall(TSBatheMethodWish(ts, whole, &next));
    TSBatheApproach(ts, &next);
    if (ba->stops && ba->last.method == TSBATHE_METHOD_IMPLICIT) { /* derivatives jump where a cell stops */
      PetscCall(SlipConstraintInitialReaction(ba->con, ts->ptime, ts->vec_sol, ba->r));
      ba->k2_known = PETSC_FALSE;
    }
  } else {
    TSBatheMethodRefused(ts);
    PetscCall(TSBatheRestore(ts));
  }
  ts->time_step = next;
  PetscCall(TSBatheRunMonitors(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes a step without a solve, to the time until which the problem computes that all of it rests. */
static PetscErrorCode TSBatheRest(TS ts, const SlipProblemOps *problem, void *ctx, PetscBool *rested)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const PetscReal t = ts->ptime;
  PetscReal end = t, h = ts->time_step;
  PetscBool constant;

  PetscFunctionBegin;
  *rested = PETSC_FALSE;
  if (!ba->con || !problem || !problem->rest) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall((*problem->rest)(ts, t, ts->max_time, ts->vec_sol, ba->Wm, ba->Y[1], &end, &h, ctx));
  if (!(end > t)) PetscFunctionReturn(PETSC_SUCCESS);
  *rested = PETSC_TRUE;
  ba->share = 0.5;
  ba->failures = 0;
  ba->attempts++;
  ba->last = (SlipAttempt){.step = ts->steps, .time = t, .dt = end - t, .converged = PETSC_TRUE};
  ba->end.known = PETSC_FALSE;
  PetscCall(VecZeroEntries(ba->E));
  PetscCall(VecCopy(ba->Y[1], ba->Y[0]));
  PetscCall(VecCopy(ba->Y[1], ts->vec_sol));
  PetscCall(SlipConstraintInitialReaction(ba->con, end, ts->vec_sol, ba->r));
  PetscCall(TSBatheStartDerivative(ts, end, ts->vec_sol, ba->r, ba->K2, &ba->k2_known));
  ba->k2_sides = PETSC_FALSE;
  PetscCall(TSBatheAccept(ts, end));
  PetscCall(TSBatheIsConstant(ts, &constant));
  PetscCall(TSBatheSetStep(ts, constant ? ts->time_step : h));
  PetscCall(TSBatheRunMonitors(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes steps end where a cell stops, which the problem computes. *again: the attempt must be repeated with such a
   step. *whole: the step before it was cut for that [s] */
static PetscErrorCode TSBatheMeetStop(TS ts, const SlipProblemOps *problem, void *ctx, PetscInt *tries,
                                      PetscReal *whole, PetscBool *again)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscReal stop = PETSC_MAX_REAL;

  PetscFunctionBegin;
  *again = PETSC_FALSE;
  if (problem && problem->stop && ba->k0_known)
    PetscCall((*problem->stop)(ts, ba->share, ba->X0, ba->Wm, ba->Y[1], ba->K0, &stop, ctx));
  ba->stops = stop < PETSC_MAX_REAL ? PETSC_TRUE : PETSC_FALSE;
  stop *= 1 + beyond_stop;
  if (!ba->stops || ts->time_step <= stop * (1 + near_stop) || stop < ts->adapt->dt_min || ++*tries > max_stop_tries)
    PetscFunctionReturn(PETSC_SUCCESS);
  *again = PETSC_TRUE;
  *whole = PetscMax(*whole, ts->time_step);
  ts->time_step = stop;
  ts->reject++;
  PetscCall(TSBatheRestore(ts));
  PetscCall(TSBatheRunMonitors(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TSStep_Bathe(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const SlipProblemOps *problem;
  void *ctx;
  PetscInt rejections = 0, tries = 0;
  PetscBool ok, accept, again, constant, rejected = PETSC_FALSE;
  PetscReal whole, corner, cut = 0;

  PetscFunctionBegin;
  PetscCall(TSGetSlipProblem(ts, &problem, &ctx));
  PetscCall(TSBatheBeginStep(ts));
  ba->status = TS_STEP_INCOMPLETE;
  PetscCall(TSBatheRest(ts, problem, ctx, &accept));
  if (accept) PetscFunctionReturn(PETSC_SUCCESS);
  /* The controller's history of steps before a rest does not apply to steps after it. */
  if (ba->last.accepted && !ba->last.solves) ts->steprestart = PETSC_TRUE;
  PetscCall(SlipMeetCorner(ts, &whole, &corner));
  if (!(whole > ts->time_step)) whole = 0; /* it was not cut */
  while (!ts->reason && ba->status != TS_STEP_COMPLETE) {
    if (rejected) PetscCall(TSBatheChooseMethod(ts));
    PetscCall(TSMoreauCut(ts, &whole));
    cut = ts->time_step;
    PetscCall(SlipGuardStep(ts));
    PetscCall(TSBatheAttempt(ts, &ok));
    accept = again = PETSC_FALSE;
    if (ok) PetscCall(TSBatheMeetStop(ts, problem, ctx, &tries, &whole, &again));
    if (again) continue;
    if (ok)
      PetscCall(TSBatheJudge(ts, whole, &accept));
    else
      PetscCall(TSBatheFailed(ts, whole));
    if (accept) break;
    rejected = PETSC_TRUE;
    ts->reject++;
    /* failed attempts have their own limit */
    if (ok && !ts->reason) PetscCall(SlipGuardRejections(ts, ++rejections));
  }
  PetscCall(TSBatheIsConstant(ts, &constant));
  if (constant && whole > 0 && ba->last.accepted && ba->last.dt == cut)
    ts->time_step = SlipStepAfterCorner(ts, ts->ptime, whole);
  if (constant && ba->last.accepted)
    ts->time_step = SlipConstantAfter(ts, PetscMax(ba->last.dt, ts->time_step), ts->time_step, &ba->constant);
  PetscFunctionReturn(PETSC_SUCCESS);
}
