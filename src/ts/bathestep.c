/* TSBATHE's step: attempts by one of its methods (bathemethod.c), the controller's choice, and exact ends of steps. */
#include <slipstep/private/slipbathe.h>
#include <petsctime.h>

/* A step that must end where a cell stops goes so far beyond that, over its length, that the cell sticks at its end;
   the allowed error of that; attempts to meet it */
static const PetscReal beyond_stop = 1e-3, near_stop = 1e-2;
enum { max_stop_tries = 4 };

/* Computes the attempt and fills its record, except whether it is accepted. */
static PetscErrorCode TSBatheAttempt(TS ts, PetscBool *ok)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const TSBatheMethodOps *row = ba->now;
  PetscReal h = ts->time_step;
  PetscReal parts_residual = 0.0; /* controllers must not see it, as it is of other steps */
  SlipProducts before, after;
  PetscBool doubling;
  PetscLogDouble begin, end;

  PetscFunctionBegin;
  PetscCall(PetscTime(&begin));
  ba->was = row;
  ba->last = (SlipAttempt){.step = ts->steps, .time = ts->ptime, .dt = h, .error = -1.0, .method = row->method};
  if (row->start) PetscCall((*row->start)(ts));
  PetscCall(TSBatheWantsDoubling(ts, &doubling));
  PetscCall(SlipProductsGet(&before));
  if (doubling)
    PetscCall(TSBatheDoubling(ts, h, &ba->last.residual, ok));
  else {
    PetscCall(TSBatheSubstep(ts, ts->ptime, h, ba->X0, ba->r0, ba->Y[0], ba->Y[1], ba->r, &ba->last.residual, ok));
    if (*ok && row->end) PetscCall((*row->end)(ts, h, ba->X0, ba->Y[0], ba->Y[1]));
    if (*ok) PetscCall(VecCopy(ba->Y[0], ba->Wm));
    if (*ok && ba->estimate.type == TSBATHE_ERROR_EMBEDDED && ba->k0_known) {
      PetscCall((*row->error)(ts, h, ba->estimate.E));
      PetscCall(TSBatheErrorNorm(ts, NORM_2, &ba->last.error));
    }
  }
  PetscCall(SlipProductsGet(&after));
  after = SlipProductsSince(&after, &before);
  if (ba->other) (*ba->other->learn)(ts, (PetscReal)(after.all + after.pc));
  if (*ok && ba->parts.n > 1) PetscCall(TSBatheInParts(ts, h, (doubling ? 2 : 1) * ba->parts.n, &parts_residual, ok));
  if (*ok) PetscCall(SlipGuardState(ba->Y[1], ok));
  if (*ok) PetscCall(TSBatheKeepErrorShare(ts));
  PetscCall(PetscTime(&end));
  ba->last.converged = ba->k2_known = *ok;
  PetscCall(SlipProductsGet(&after)); /* since the last attempt, so that the sum over attempts has all of a run */
  ba->last.products = SlipProductsSince(&after, &ba->totals.cost);
  ba->last.wall = end - begin;
  ba->totals.attempts++;
  ba->totals.explicits += row->method == TSBATHE_METHOD_EXPLICIT;
  ba->totals.solves += ba->last.solves;
  ba->totals.newton += ba->last.newton;
  ba->totals.linear += ba->last.linear;
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

/* Begins a run: sets totals to 0, and the first step if the controller chooses it. */
static PetscErrorCode TSBatheBeginRun(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscErrorCode (*f)(TSAdapt, TS, PetscReal *);
  PetscReal h = ts->time_step;

  PetscFunctionBegin;
  ba->totals = (TSBatheTotals){.attempts = 0};
  TSBatheFailuresBegin(&ba->failures);
  PetscCall(TSBatheMethodBegin(ts));
  ba->stages.error_share = 0;
  ba->last = (SlipAttempt){.time = ts->ptime, .error = -1.0};
  (void)SlipProductsRow(&ba->totals.cost);
  SlipProblemTry(ts, steps.begin, PETSC_FALSE);
  PetscCall(PetscObjectQueryFunction((PetscObject)ts->adapt, "TSAdaptChooseFirst_C", &f));
  if (f) {
    PetscCall((*f)(ts->adapt, ts, &h));
    PetscCall(TSBatheSetStep(ts, h));
  }
  SlipProblemTry(ts, steps.begin, PETSC_TRUE);
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
  SlipProblemTry(ts, history.accept, ts->ptime, ts->vec_sol, begin);
  if (begin) PetscCall(TSBatheBeginRun(ts));
  PetscCall(VecCopy(ts->vec_sol, ba->X0));
  ba->moreau.started = PETSC_FALSE;
  PetscCall(TSBatheChooseMethod(ts));
  PetscCall((*ba->now->begin)(ts, !fresh && unchanged ? PETSC_TRUE : PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Accepts the step whose end is in vec_sol. */
static PetscErrorCode TSBatheAccept(TS ts, PetscReal time)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  ba->status = TS_STEP_COMPLETE;
  ba->last.accepted = PETSC_TRUE;
  ba->totals.accepted++;
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
  ba->failures.row = 0;
  ba->status = TS_STEP_PENDING;
  PetscCall(VecCopy(ba->Y[1], ts->vec_sol));
  PetscCall(TSAdaptChoose(ts->adapt, ts, ts->time_step, NULL, &next, accept));
  ba->status = TS_STEP_INCOMPLETE;
  if (*accept) {
    PetscCall(TSBatheAccept(ts, SlipTimeAfterStep(ts)));
    PetscCall(TSBatheMethodWish(ts, whole, &next));
    TSBatheApproach(ts, &next);
    if (ba->stops && ba->was == &TSBatheImplicit) { /* derivatives jump where a cell stops */
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
static PetscErrorCode TSBatheRest(TS ts, PetscBool *rested)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const PetscReal t = ts->ptime;
  PetscReal end = t, h = ts->time_step;
  PetscBool constant;

  PetscFunctionBegin;
  *rested = PETSC_FALSE;
  if (ba->con) SlipProblemTry(ts, steps.rest, t, ts->max_time, ts->vec_sol, ba->Wm, ba->Y[1], &end, &h);
  if (!(end > t)) PetscFunctionReturn(PETSC_SUCCESS);
  *rested = PETSC_TRUE;
  ba->share = 0.5;
  ba->failures.row = 0;
  ba->totals.attempts++;
  ba->was = &TSBatheImplicit;
  ba->last = (SlipAttempt){.step = ts->steps, .time = t, .dt = end - t, .converged = PETSC_TRUE};
  PetscCall(VecZeroEntries(ba->estimate.E));
  PetscCall(VecCopy(ba->Y[1], ba->Y[0]));
  PetscCall(VecCopy(ba->Y[1], ts->vec_sol));
  PetscCall(SlipConstraintInitialReaction(ba->con, end, ts->vec_sol, ba->r));
  PetscCall(TSBatheStartDerivative(ts, end, ts->vec_sol, ba->r, ba->K2, &ba->k2_known));
  ba->stabilised.k2_sides = PETSC_FALSE;
  PetscCall(TSBatheAccept(ts, end));
  PetscCall(PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, &constant));
  PetscCall(TSBatheSetStep(ts, constant ? ts->time_step : h));
  PetscCall(TSBatheRunMonitors(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes steps end where a cell stops, which the problem computes. *again: the attempt must be repeated with such a
   step. *whole: the step before it was cut for that [s] */
static PetscErrorCode TSBatheMeetStop(TS ts, PetscInt *tries, PetscReal *whole, PetscBool *again)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscReal stop = PETSC_MAX_REAL;

  PetscFunctionBegin;
  *again = PETSC_FALSE;
  if (ba->k0_known) SlipProblemTry(ts, steps.stop, ba->share, ba->X0, ba->Wm, ba->Y[1], ba->K0, &stop);
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
  PetscInt rejections = 0, tries = 0;
  PetscBool ok, accept, again, constant, rejected = PETSC_FALSE;
  PetscReal whole, corner, cut = 0;

  PetscFunctionBegin;
  PetscCall(TSBatheBeginStep(ts));
  ba->status = TS_STEP_INCOMPLETE;
  PetscCall(TSBatheRest(ts, &accept));
  if (accept) PetscFunctionReturn(PETSC_SUCCESS);
  /* The controller's history of steps before a rest does not apply to steps after it. */
  if (ba->last.accepted && !ba->last.solves) ts->steprestart = PETSC_TRUE;
  PetscCall(SlipMeetCorner(ts, &whole, &corner));
  if (!(whole > ts->time_step)) whole = 0; /* it was not cut */
  while (!ts->reason && ba->status != TS_STEP_COMPLETE) {
    if (rejected) PetscCall(TSBatheChooseMethod(ts));
    if (ba->now->limit) PetscCall((*ba->now->limit)(ts, &whole));
    cut = ts->time_step;
    PetscCall(SlipGuardStep(ts));
    PetscCall(TSBatheAttempt(ts, &ok));
    accept = again = PETSC_FALSE;
    if (ok) PetscCall(TSBatheMeetStop(ts, &tries, &whole, &again));
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
  PetscCall(PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, &constant));
  if (constant && whole > 0 && ba->last.accepted && ba->last.dt == cut)
    ts->time_step = SlipStepAfterCorner(ts, ts->ptime, whole);
  if (constant && ba->last.accepted)
    ts->time_step = SlipConstantAfter(ts, PetscMax(ba->last.dt, ts->time_step), ts->time_step, &ba->failures.constant);
  PetscFunctionReturn(PETSC_SUCCESS);
}
