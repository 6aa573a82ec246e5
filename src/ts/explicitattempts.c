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
  PetscCall(SlipHistoryError(ts, ts->vec_sol, wlte, NULL));
  if (order) *order = 3;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TSSetUp(), TSReset() and TSDestroy() of these types, of vectors that at->own lists */
PetscErrorCode SlipAttemptsSetUp(TS ts)
{
  SlipAttempts *at = (SlipAttempts *)ts->data;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < at->nown; i++)
    if (!*at->own[i]) PetscCall(VecDuplicate(ts->vec_sol, at->own[i]));
  PetscCall(TSGetAdapt(ts, &ts->adapt));
  PetscCall(TSAdaptCandidatesClear(ts->adapt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipAttemptsReset(TS ts)
{
  SlipAttempts *at = (SlipAttempts *)ts->data;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < at->nown; i++) PetscCall(VecDestroy(at->own[i]));
  at->known = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipAttemptsDestroy(TS ts)
{
  PetscFunctionBegin;
  PetscCall((*ts->ops->reset)(ts));
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, SLIP_STATE_METHOD, NULL));
  PetscCall(PetscFree(ts->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes an attempt and asks the controller. *next_h: the step after it [s] */
static PetscErrorCode Attempt(TS ts, PetscReal *next_h, PetscBool *accepted)
{
  const PetscBool always = ts->adapt->always_accept;
  SlipAttempts *at = (SlipAttempts *)ts->data;
  const SlipAttemptOps *ops = at->ops;
  PetscBool good;

  PetscFunctionBegin;
  PetscCall(SlipMeetCorner(ts, &at->whole, &at->corner));
  if (ops->limit) PetscCall((*ops->limit)(ts));
  SlipWorkAdd(SLIP_WORK_ATTEMPT, 1);
  PetscCall(SlipGuardStep(ts));
  PetscCall((*ops->attempt)(ts, &good));
  if (good) {
    PetscCall(TSAdaptCandidatesClear(ts->adapt));
    PetscCall(TSAdaptCandidateAdd(ts->adapt, NULL, ops->order ? (*ops->order)(ts) : 2, 1, 1.0, 1.0, PETSC_TRUE));
    if (ops->whatever && (*ops->whatever)(ts)) ts->adapt->always_accept = PETSC_TRUE;
    PetscCall(TSAdaptChoose(ts->adapt, ts, ts->time_step, NULL, next_h, accepted));
    ts->adapt->always_accept = always;
  } else
    PetscCall(SlipStepAfterFailure(ts, next_h));
  if (*accepted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecCopy(at->start, ts->vec_sol));
  PetscCall(SlipProblemRollBack(ts));
  ts->time_step = *next_h;
  ts->reject++;
  at->rejections++;
  if (ops->retry) PetscCall((*ops->retry)(ts, good));
  PetscCall(SlipGuardRejections(ts, at->rejections));
  if (!good) PetscCall(SlipGuardConstant(ts, at->whole));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TSStep() of these types */
PetscErrorCode SlipAttemptsStep(TS ts)
{
  const PetscBool first = ts->steps == 0 && !ts->steprollback ? PETSC_TRUE : PETSC_FALSE;
  SlipAttempts *at = (SlipAttempts *)ts->data;
  PetscReal next_h = ts->time_step;
  PetscBool accepted = PETSC_FALSE, constant;

  PetscFunctionBegin;
  SlipProblemTry(ts, history.accept, ts->ptime, ts->vec_sol, first);
  PetscCall(VecCopy(ts->vec_sol, at->start));
  if (at->f && (ts->steprestart || !at->known)) PetscCall(TSComputeRHSFunction(ts, ts->ptime, ts->vec_sol, at->f));
  at->known = PETSC_TRUE;
  if (at->ops->begin) PetscCall((*at->ops->begin)(ts));
  at->rejections = 0;
  while (!ts->reason && !accepted) PetscCall(Attempt(ts, &next_h, &accepted));
  if (!accepted) PetscFunctionReturn(PETSC_SUCCESS);
  at->before = ts->ptime;
  at->h = ts->time_step;
  ts->ptime = SlipTimeAfterStep(ts);
  ts->time_step = next_h;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, &constant));
  if (constant && at->corner < PETSC_MAX_REAL) ts->time_step = SlipStepAfterCorner(ts, ts->ptime, at->whole);
  PetscCall((*at->ops->accept)(ts));
  SlipProblemTry(ts, steps.finish, ts->ptime, ts->vec_sol);
  if (at->ops->bound) PetscCall((*at->ops->bound)(ts));
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
