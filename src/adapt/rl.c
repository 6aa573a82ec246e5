/* TSADAPTRL: a learned policy chooses the step; guard rails keep a run going where it would not. */
#include <slipstep/private/slipadapt.h>
#include <slipstep/private/slipsys.h>

/* Names of what is observed, in the order of the policy or the actor. */
PetscErrorCode TSAdaptRLSetNames_Private(TSAdapt adapt, PetscInt n, const char *const names[])
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;

  PetscFunctionBegin;
  PetscCall(PetscFree2(rl->seen, rl->obs));
  PetscCall(PetscCalloc2(n, &rl->seen, n, &rl->obs));
  rl->n = n;
  rl->needs_error = rl->sees_accuracy = PETSC_FALSE;
  for (PetscInt i = 0; i < n; i++) {
    PetscBool dial, error;

    PetscCall(SlipObservedSet(&rl->seen[i], names[i]));
    /* a problem's own observation of the error estimate is called so: log_slip_error */
    PetscCall(PetscStrendswith(names[i], "_error", &error));
    if (error || (rl->seen[i].row && rl->seen[i].row->kind == SLIP_OBSERVES_ERROR)) rl->needs_error = PETSC_TRUE;
    PetscCall(PetscStrcmp(names[i], SLIP_OBSERVES_ACCURACY, &dial));
    if (dial) rl->sees_accuracy = PETSC_TRUE;
  }
  rl->begun = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A solve begins: the state of now is the start. */
static PetscErrorCode Begin(TSAdapt adapt, TS ts)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  SlipObserver *o = &rl->observer;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLFindPolicy_Private(adapt, ts));
  PetscCall(SlipObserverStart(o, ts));
  o->accuracy = rl->accuracy;
  if (rl->actor) {
    o->dt_min = rl->actor_dt[0];
    o->dt_max = rl->actor_dt[1];
  } else {
    PetscCall(SlipPolicyGetStepBounds(rl->policy, o->tstar, o->max_time, &o->dt_min, &o->dt_max));
  }
  for (PetscInt i = 0; i < rl->n; i++) rl->seen[i].has_base = PETSC_FALSE;
  rl->begun = PETSC_TRUE;
  rl->steps = ts->steps;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What is known of the attempt that just ended; a TS that records none gives what the controller's arguments say. */
static PetscErrorCode RecordAttempt(TSAdapt adapt, TS ts, PetscReal h, PetscBool converged, PetscBool need_error)
{
  SlipAttempt *last = &((TSAdapt_RL *)adapt->data)->observer.last;
  PetscErrorCode (*get)(TS, SlipAttempt *);
  PetscInt p;

  PetscFunctionBegin;
  PetscCall(PetscObjectQueryFunction((PetscObject)ts, "TSBatheGetLastAttempt_C", &get));
  if (get) {
    PetscCall((*get)(ts, last));
  } else {
    PetscCall(PetscMemzero(last, sizeof(*last)));
    last->step = ts->steps;
    last->time = ts->ptime;
    last->dt = h;
    last->error = -1;
    last->residual = converged ? 0 : 2;
    last->solves = 1;
  }
  last->converged = converged;
  last->accepted = PETSC_FALSE;
  if (converged && need_error && last->error < 0) PetscCall(SlipAdaptEvaluateError(adapt, ts, &p, &last->error));
  PetscCheck(
    !converged || !need_error || last->error >= 0, PetscObjectComm((PetscObject)adapt), PETSC_ERR_SUP,
    "-ts_adapt_type rl needs an error estimate (its policy observes accuracy, log_error or log_slip_error, or "
    "-ts_adapt_rl_error_ceiling is set), but -ts_type %s gives none; with bathe use -ts_bathe_error doubling or "
    "embedded",
    ((PetscObject)ts)->type_name);
  ((TSAdapt_RL *)adapt->data)->observer.started = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Observe, and ask the actor or the policy for the next step. */
static PetscErrorCode Decide(TSAdapt adapt, TS ts, PetscBool state_changed, PetscBool guarded, PetscReal *h)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  SlipObserver *o = &rl->observer;
  const char *file = "(actor)";
  PetscReal action;
  PetscInt outside;

  PetscFunctionBegin;
  if (!rl->actor && guarded) PetscFunctionReturn(PETSC_SUCCESS);
  if (!rl->actor) PetscCall(SlipPolicyGetFile(rl->policy, &file));
  PetscCall(PetscLogEventBegin(SLIP_Observe, adapt, ts, 0, 0));
  PetscCall(SlipObserve(o, rl->n, rl->seen, state_changed, file));
  PetscCall(PetscLogEventEnd(SLIP_Observe, adapt, ts, 0, 0));
  for (PetscInt i = 0; i < rl->n; i++) rl->obs[i] = rl->seen[i].value;
  rl->decisions++;
  if (rl->actor) {
    PetscCall((*rl->actor)(adapt, ts, rl->n, rl->obs, o->started ? &o->last : NULL, guarded, h, rl->actor_ctx));
    PetscCheck(*h > 0 && !PetscIsInfOrNanReal(*h), PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_OUTOFRANGE,
               "The actor of TSAdaptRLSetActor() chose a step of %g s; expected a positive number", (double)*h);
  } else {
    PetscCall(PetscLogEventBegin(SLIP_Policy, adapt, 0, 0, 0));
    PetscCall(SlipPolicyEvaluate(rl->policy, rl->obs, &action, &outside));
    PetscCall(PetscLogEventEnd(SLIP_Policy, adapt, 0, 0, 0));
    PetscCall(SlipPolicyActionToStep(rl->policy, action, o->tstar, o->max_time, h));
    PetscCall(TSAdaptRLMind_Private(adapt, ts, h));
    PetscCall(TSAdaptRLWarnOutside_Private(adapt, outside));
  }
  *h = PetscClipInterval(*h, adapt->dt_min, adapt->dt_max);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TSAdaptChooseFirst_RL(TSAdapt adapt, TS ts, PetscReal *h)
{
  PetscFunctionBegin;
  PetscCall(Begin(adapt, ts));
  PetscCall(Decide(adapt, ts, PETSC_TRUE, PETSC_FALSE, h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The ceiling is the tolerance that the heuristic's formula is given here; a tenth at least is taken off each time. */
static PetscReal CeilingFactor(PetscReal E, PetscReal ceiling, PetscReal q)
{
  return PetscClipInterval(SlipHeuristicFactor(E / ceiling, q, 1), (PetscReal)0.1, (PetscReal)0.9);
}

PetscErrorCode TSAdaptChoose_RL(TSAdapt adapt, TS ts, PetscReal h, PetscInt *next_sc, PetscReal *next_h,
                                PetscBool *accept, PetscReal *wlte, PetscReal *wltea, PetscReal *wlter)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  SlipObserver *o = &rl->observer;
  const PetscBool limit = rl->error_ceiling > 0 ? PETSC_TRUE : PETSC_FALSE;
  PetscInt p;
  PetscReal E;

  PetscFunctionBegin;
  *next_sc = 0;
  *wltea = *wlter = -1;
  *next_h = h;
  if (!rl->begun || ts->steps < rl->steps) PetscCall(Begin(adapt, ts));
  rl->steps = ts->steps;
  PetscCall(RecordAttempt(adapt, ts, h, PETSC_TRUE, rl->needs_error || limit ? PETSC_TRUE : PETSC_FALSE));
  o->failures = 0;
  *wlte = o->last.error;
  *accept = !limit || o->last.error <= rl->error_ceiling || adapt->always_accept ? PETSC_TRUE : PETSC_FALSE;
  o->last.accepted = *accept;
  if (*accept) o->time = ts->ptime + h;
  PetscCall(Decide(adapt, ts, *accept, *accept ? PETSC_FALSE : PETSC_TRUE, next_h));
  if (*accept) PetscFunctionReturn(PETSC_SUCCESS);
  rl->ceilings++;
  PetscCall(SlipAdaptEvaluateError(adapt, ts, &p, &E));
  *next_h = h * CeilingFactor(o->last.error, rl->error_ceiling, (PetscReal)1 / (PetscReal)PetscMax(p, 2));
  PetscCall(SlipAdaptCheckMinimum(adapt, ts, *next_h, "-ts_adapt_rl_error_ceiling"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TSAdaptChooseAfterFailure_RL(TSAdapt adapt, TS ts, PetscReal h_failed, PetscReal *h_next)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  SlipObserver *o = &rl->observer;
  PetscBool guarded;

  PetscFunctionBegin;
  if (!rl->begun) PetscCall(Begin(adapt, ts));
  PetscCall(RecordAttempt(adapt, ts, h_failed, PETSC_FALSE, PETSC_FALSE));
  o->last.dt = h_failed;
  o->failures++;
  rl->failures++;
  guarded = o->failures >= rl->max_failures ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(Decide(adapt, ts, PETSC_FALSE, guarded, h_next));
  if (!guarded) PetscFunctionReturn(PETSC_SUCCESS);
  rl->halvings++;
  *h_next = 0.5 * h_failed;
  PetscCall(SlipAdaptCheckMinimum(adapt, ts, *h_next, "a solve that did not converge"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The trainer's rewards use the error, so an actor always gets it. */
PetscErrorCode TSAdaptNeedsError_RL(TSAdapt adapt, PetscBool *flg)
{
  const TSAdapt_RL *rl = (const TSAdapt_RL *)adapt->data;

  PetscFunctionBegin;
  *flg = rl->needs_error || rl->error_ceiling > 0 || rl->actor ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
