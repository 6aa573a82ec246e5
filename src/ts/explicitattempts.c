/* A step of TSADAMS, TSRKC and TSLAPUSTA: attempts start from one state and become shorter until the controller accepts
   one or the run ends. Each type defines its own attempt. */
#include <slipstep/private/slipts.h>
#include <slipstep/private/slipwork.h>

/* SLIP_STATE_METHOD of types whose steps begin with the rates at the end of the last step: writes or reads what a
   checkpoint needs besides time, step and state. */
PetscErrorCode SlipAttemptsState(TS ts, SlipState s)
{
  SlipAttempts *at = (SlipAttempts *)ts->data;

  PetscFunctionBegin;
  if (!SlipStateIsLoading(s) && ts->steprestart) at->known = PETSC_FALSE; /* the next step computes the rates */
  PetscCall(SlipStateBool(s, "rates_known", &at->known));
  if (at->known) PetscCall(SlipStateVec(s, "rates", at->f));
  if (SlipStateIsLoading(s)) ts->steprestart = at->known ? PETSC_FALSE : PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the norm of the estimate e, of order h^3, of an attempt's error, and overwrites e. */
PetscErrorCode SlipAttemptsError(TS ts, Vec e, NormType type, PetscInt *order, PetscReal *wlte)
{
  SlipAttempts *at = (SlipAttempts *)ts->data;
  const SlipProblemOps *problem;
  PetscReal absolute, relative;
  void *ctx;

  PetscFunctionBegin;
  PetscCall(TSGetSlipProblem(ts, &problem, &ctx));
  if (problem && problem->steps.error)
    PetscCall((*problem->steps.error)(ts, e, at->start, ts->vec_sol, wlte, ctx));
  else {
    PetscCall(VecAXPY(e, 1, ts->vec_sol));
    PetscCall(TSErrorWeightedNorm(ts, ts->vec_sol, e, type, wlte, &absolute, &relative));
  }
  *wlte = PetscMax(*wlte, 1e-10); /* a very short step can have no error, but controllers divide by the norm */
  if (order) *order = 3;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Accept(TS ts, const SlipAttemptOps *ops, PetscReal next_h)
{
  SlipAttempts *at = (SlipAttempts *)ts->data;
  const SlipProblemOps *problem;
  PetscBool constant;
  void *ctx;

  PetscFunctionBegin;
  at->before = ts->ptime;
  at->h = ts->time_step;
  ts->ptime = SlipTimeAfterStep(ts);
  ts->time_step = next_h;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, &constant));
  if (constant && at->corner < PETSC_MAX_REAL) ts->time_step = SlipStepAfterCorner(ts, ts->ptime, at->whole);
  PetscCall((*ops->accept)(ts));
  PetscCall(TSGetSlipProblem(ts, &problem, &ctx));
  if (problem && problem->steps.finish) PetscCall((*problem->steps.finish)(ts, ts->ptime, ts->vec_sol, ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Retry(TS ts, const SlipAttemptOps *ops, PetscReal next_h, PetscBool good)
{
  SlipAttempts *at = (SlipAttempts *)ts->data;

  PetscFunctionBegin;
  PetscCall(VecCopy(at->start, ts->vec_sol));
  PetscCall(SlipProblemRollBack(ts));
  ts->time_step = next_h;
  ts->reject++;
  at->rejections++;
  if (ops->retry) PetscCall((*ops->retry)(ts, good));
  PetscCall(SlipGuardRejections(ts, at->rejections));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes a step; *accepted: an attempt was accepted. */
PetscErrorCode SlipAttemptsStep(TS ts, const SlipAttemptOps *ops, PetscBool *accepted)
{
  const PetscBool always = ts->adapt->always_accept;
  SlipAttempts *at = (SlipAttempts *)ts->data;
  PetscReal next_h = ts->time_step;
  PetscBool good;

  PetscFunctionBegin;
  *accepted = PETSC_FALSE;
  PetscCall(SlipProblemAccept(ts));
  PetscCall(VecCopy(ts->vec_sol, at->start));
  if (at->f && (ts->steprestart || !at->known)) PetscCall(TSComputeRHSFunction(ts, ts->ptime, ts->vec_sol, at->f));
  at->known = PETSC_TRUE;
  if (ops->begin) PetscCall((*ops->begin)(ts));
  at->rejections = 0;
  while (!ts->reason && !*accepted) {
    PetscCall(SlipMeetCorner(ts, &at->whole, &at->corner));
    if (ops->limit) PetscCall((*ops->limit)(ts));
    SlipWorkAdd(SLIP_WORK_ATTEMPT, 1);
    PetscCall(SlipGuardStep(ts));
    PetscCall((*ops->attempt)(ts, &good));
    if (good) {
      PetscCall(TSAdaptCandidatesClear(ts->adapt));
      PetscCall(TSAdaptCandidateAdd(ts->adapt, NULL, ops->order ? (*ops->order)(ts) : 2, 1, 1.0, 1.0, PETSC_TRUE));
      if (ops->whatever && (*ops->whatever)(ts)) ts->adapt->always_accept = PETSC_TRUE;
      PetscCall(TSAdaptChoose(ts->adapt, ts, ts->time_step, NULL, &next_h, accepted));
      ts->adapt->always_accept = always;
    } else
      PetscCall(SlipStepAfterFailure(ts, &next_h));
    if (!*accepted) PetscCall(Retry(ts, ops, next_h, good));
    if (!good) PetscCall(SlipGuardConstant(ts, at->whole));
  }
  if (*accepted) PetscCall(Accept(ts, ops, next_h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipAttemptsRollBack(TS ts)
{
  PetscFunctionBegin;
  PetscCall(VecCopy(((SlipAttempts *)ts->data)->start, ts->vec_sol));
  PetscCall(SlipProblemRollBack(ts));
  ts->steprestart = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
