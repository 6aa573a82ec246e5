/* Code that controllers share: the error estimate, the two ends of a choice that follows it, the step after a
   failure */
#include <slipstep/private/slipadapt.h>
#include <slipstep/private/slipts.h>

/*
  Types with their own estimate (theta, bdf, alpha, bathe) supply E and its order, the power of h to which it is
  proportional; embedded Runge-Kutta pairs supply a second solution instead, as for PETSc's own controllers. q =
  1/order.
*/
PetscErrorCode SlipAdaptEvaluateError(TSAdapt adapt, TS ts, PetscReal *q, PetscReal *E)
{
  PetscReal unused[2];
  PetscInt order = PETSC_DECIDE;
  PetscBool good;
  Vec y;

  PetscFunctionBegin;
  *E = -1;
  if (ts->ops->evaluatewlte) {
    PetscCall(TSEvaluateWLTE(ts, adapt->wnormtype, &order, E));
  } else if (ts->ops->evaluatestep && adapt->candidates.inuse_set) {
    order = adapt->candidates.order[0];
    PetscCall(VecDuplicate(ts->vec_sol, &y));
    PetscCall(TSEvaluateStep(ts, order - 1, y, NULL));
    PetscCall(TSErrorWeightedNorm(ts, ts->vec_sol, y, adapt->wnormtype, E, &unused[0], &unused[1]));
    PetscCall(SlipGuardState(y, &good));
    PetscCall(VecDestroy(&y));
    if (!good) *E = (PetscReal)NAN; /* PETSc's infinity norm ignores NaN */
  }
  PetscCheck(!PetscIsNanReal(*E), PetscObjectComm((PetscObject)adapt), PETSC_ERR_FP,
             "At time %g s the error estimate of a step of %g s is not a number (-ts_type %s)", (double)ts->ptime,
             (double)ts->time_step, ((PetscObject)ts)->type_name);
  PetscCheck(*E < 0 || order >= 1, PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_OUTOFRANGE,
             "TS type %s estimates its error with order %" PetscInt_FMT "; expected at least 1",
             ((PetscObject)ts)->type_name, order);
  *q = (PetscReal)1 / (PetscReal)PetscMax(order, 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True if -ts_adapt_clip, the limits of the ratio of steps, has these values */
PetscBool SlipAdaptClips(TSAdapt adapt, PetscReal low, PetscReal high)
{
  return adapt->clip[0] == low && adapt->clip[1] == high ? PETSC_TRUE : PETSC_FALSE;
}

PetscErrorCode SlipAdaptCheckMinimum(TSAdapt adapt, TS ts, PetscReal h, const char why[])
{
  PetscFunctionBegin;
  if (h < adapt->dt_min) PetscCall(SlipRunFails(ts));
  PetscCheck(h >= adapt->dt_min, PetscObjectComm((PetscObject)adapt), PETSC_ERR_CONV_FAILED,
             "At time %g s %s asks for a step of %g s, below -ts_adapt_dt_min %g s (-ts_adapt_type %s)",
             (double)ts->ptime, why, (double)h, (double)adapt->dt_min, ((PetscObject)adapt)->type_name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the norm in which a controller measures the error of a step. type: `NORM_2`, PETSc's default: the root mean
   square over the components of the state, in which the error of one component counts the less the more there are;
   `NORM_INFINITY`: the largest of them. Option -ts_adapt_wnormtype <2>: the same; infinity in explicit runs of a
   SlipFault. Errors: PETSC_ERR_ARG_OUTOFRANGE for another norm. */
PetscErrorCode SlipAdaptSetNorm(TSAdapt adapt, NormType type)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(adapt, TSADAPT_CLASSID, 1);
  PetscCheck(type == NORM_2 || type == NORM_INFINITY, PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_OUTOFRANGE,
             "norm %s of the error of a step; expected NORM_2 or NORM_INFINITY",
             type >= NORM_1 && type <= NORM_1_AND_2 ? NormTypes[type] : "of an unknown number");
  adapt->wnormtype = type;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  A TSAdapt type based on the error estimate: its rule computes the next step, and whether this one is accepted, from E
  and q. Without an estimate the step is accepted and its size unchanged.
*/
static PetscErrorCode TSAdaptChoose_Error(TSAdapt adapt, TS ts, PetscReal h, PetscInt *next_sc, PetscReal *next_h,
                                          PetscBool *accept, PetscReal *wlte, PetscReal *wltea, PetscReal *wlter)
{
  const SlipAdaptByError *ctx = (const SlipAdaptByError *)adapt->data;
  PetscReal E, q = 1, longest;

  PetscFunctionBegin;
  PetscCall(SlipAdaptEvaluateError(adapt, ts, &q, &E));
  *next_sc = 0;
  *wlte = E;
  *wltea = *wlter = -1;
  *accept = PETSC_TRUE;
  *next_h = h;
  *next_h = (*ctx->next)(adapt, ts, h, E, q, accept);
  if (E < 0) PetscFunctionReturn(PETSC_SUCCESS);
  longest = adapt->clip[1] < PETSC_MAX_REAL / PetscMax(h, 1) ? h * adapt->clip[1] : PETSC_MAX_REAL;
  *next_h = PetscClipInterval(*next_h, h * adapt->clip[0], longest);
  if (*accept)
    *next_h = PetscClipInterval(*next_h, adapt->dt_min, adapt->dt_max);
  else
    PetscCall(SlipAdaptCheckMinimum(adapt, ts, *next_h, "the error estimate"));
  PetscCheck(*accept || *next_h < h, PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_OUTOFRANGE,
             "At time %g s a step of %g s is rejected and not made shorter: -ts_adapt_clip has the lower limit %g; "
             "expected less than 1",
             (double)ts->ptime, (double)h, (double)adapt->clip[0]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSAdaptChooseAfterFailure_Error(TSAdapt adapt, TS ts, PetscReal h_failed, PetscReal *h_next)
{
  PetscFunctionBegin;
  *h_next = ((const SlipAdaptByError *)adapt->data)->failure * h_failed;
  PetscCall(SlipAdaptCheckMinimum(adapt, ts, *h_next, "a solve that did not converge"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSAdaptDestroy_Error(TSAdapt adapt)
{
  const SlipAdaptByError *ctx = (const SlipAdaptByError *)adapt->data;

  PetscFunctionBegin;
  adapt->safety = ctx->safety;
  adapt->reject_safety = ctx->reject_safety;
  if (SlipAdaptClips(adapt, 0, PETSC_MAX_REAL)) PetscCall(TSAdaptSetClip(adapt, SLIP_CLIP_LOW, SLIP_CLIP_HIGH));
  PetscCall(PetscObjectComposeFunction((PetscObject)adapt, "TSAdaptChooseAfterFailure_C", NULL));
  PetscCall(PetscObjectComposeFunction((PetscObject)adapt, SLIP_STATE_METHOD, NULL));
  PetscCall(PetscFree(adapt->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipAdaptCreateByError(TSAdapt adapt, SlipAdaptByError *ctx, SlipAdaptNextFn next,
                                      PetscErrorCode (*state)(TSAdapt, SlipState))
{
  PetscFunctionBegin;
  ctx->next = next;
  ctx->failure = 0.6;
  ctx->safety = adapt->safety;
  ctx->reject_safety = adapt->reject_safety;
  if (SlipAdaptClips(adapt, SLIP_CLIP_LOW, SLIP_CLIP_HIGH)) { /* it was not set: the limits of the type suffice */
    adapt->clip[0] = 0;
    adapt->clip[1] = PETSC_MAX_REAL;
  }
  adapt->safety = adapt->reject_safety = 1;
  adapt->data = ctx;
  adapt->ops->choose = TSAdaptChoose_Error;
  adapt->ops->destroy = TSAdaptDestroy_Error;
  PetscCall(
    PetscObjectComposeFunction((PetscObject)adapt, "TSAdaptChooseAfterFailure_C", TSAdaptChooseAfterFailure_Error));
  PetscCall(PetscObjectComposeFunction((PetscObject)adapt, SLIP_STATE_METHOD, state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipAdaptFailureOption(TSAdapt adapt, SlipOptionItems PetscOptionsObject, const char option[])
{
  PetscReal *factor = &((SlipAdaptByError *)adapt->data)->failure;

  PetscFunctionBegin;
  PetscCall(
    PetscOptionsReal(option, "Factor on the step when a solve did not converge, in (0, 1)", "", *factor, factor, NULL));
  PetscCheck(*factor > 0 && *factor < 1, PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_OUTOFRANGE,
             "%s is %g; expected a number in (0, 1)", option, (double)*factor);
  PetscFunctionReturn(PETSC_SUCCESS);
}
