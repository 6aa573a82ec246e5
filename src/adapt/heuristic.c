/* TSADAPTHEURISTIC accepts a step if the error estimate is at most 1, and computes the next step from it. */
#include <slipstep/private/slipadapt.h>

typedef struct {
  SlipAdaptByError base;
  PetscReal growth; /* c_up, largest ratio of successive steps */
  PetscBool again;  /* the previous attempt was rejected, too */
} TSAdapt_Heuristic;

/* If E falls more slowly than h^(1/q), h E^-q approaches E = 1 from above without reaching it; a step that was rejected
   before is therefore shortened further. */
static PetscReal Next_Heuristic(TSAdapt adapt, TS ts, PetscReal h, PetscReal E, PetscReal q, PetscBool *accept)
{
  TSAdapt_Heuristic *ctx = (TSAdapt_Heuristic *)adapt->data;
  PetscReal next = h * PetscMin(ctx->growth, adapt->safety * SlipControlHeuristic(E, q, PETSC_INFINITY));

  (void)ts;
  if (E < 0) return h;
  *accept = E <= 1 || adapt->always_accept ? PETSC_TRUE : PETSC_FALSE;
  if (!*accept && ctx->again) next *= adapt->reject_safety;
  ctx->again = *accept ? PETSC_FALSE : PETSC_TRUE;
  return next;
}

static PetscErrorCode TSAdaptSetFromOptions_Heuristic(TSAdapt adapt, SlipOptionItems PetscOptionsObject)
{
  TSAdapt_Heuristic *ctx = (TSAdapt_Heuristic *)adapt->data;

  PetscFunctionBegin;
  PetscOptionsHeadBegin(PetscOptionsObject, "Heuristic step-size controller options");
  PetscCall(PetscOptionsReal("-ts_adapt_heuristic_growth", "Largest ratio of successive steps, > 1", "", ctx->growth,
                             &ctx->growth, NULL));
  PetscCall(SlipAdaptFailureOption(adapt, PetscOptionsObject, "-ts_adapt_heuristic_failure_factor"));
  PetscOptionsHeadEnd();
  PetscCheck(ctx->growth > 1, PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_adapt_heuristic_growth is %g; expected > 1", (double)ctx->growth);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TSAdaptView() calls it only for ASCII viewers */
static PetscErrorCode TSAdaptView_Heuristic(TSAdapt adapt, PetscViewer viewer)
{
  const TSAdapt_Heuristic *ctx = (const TSAdapt_Heuristic *)adapt->data;

  PetscFunctionBegin;
  PetscCall(PetscViewerASCIIPrintf(viewer, "  growth at most %g, factor after a failed solve %g\n", (double)ctx->growth,
                                   (double)ctx->base.failure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipState_Heuristic(TSAdapt adapt, SlipState s)
{
  PetscFunctionBegin;
  PetscCall(SlipStateBool(s, "again", &((TSAdapt_Heuristic *)adapt->data)->again));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  TSADAPTHEURISTIC - controls steps by the textbook rule, without a filter

  The weighted error estimate E is proportional to h^(1/q) (TSEvaluateWLTE()). E > 1 rejects the step and repeats it
  with h E^-q; otherwise the next step is min(h_max, h min(growth, E^-q)). A second rejection in a row multiplies the
  step by -ts_adapt_reject_safety, too, and -ts_adapt_safety multiplies every E^-q. A solve that does not converge is
  repeated with the failure factor times h. A step below -ts_adapt_dt_min ends the run with an error.

  Options Database Keys:
+ -ts_adapt_heuristic_growth <2>           - largest ratio of successive steps
. -ts_adapt_heuristic_failure_factor <0.6> - factor on the step when a solve did not converge
. -ts_adapt_safety <1>                     - factor on E^-q
. -ts_adapt_reject_safety <0.9>            - further factor when a step is rejected again
- -ts_adapt_clip <low,high>                - further limits of the ratio of steps; none unless given

  Level: beginner

.seealso: TSADAPTPI, TSADAPTRL
M*/
PetscErrorCode TSAdaptCreate_Heuristic(TSAdapt adapt)
{
  TSAdapt_Heuristic *ctx;

  PetscFunctionBegin;
  PetscCall(PetscNew(&ctx));
  PetscCall(SlipAdaptCreateByError(adapt, &ctx->base, Next_Heuristic, SlipState_Heuristic));
  ctx->growth = 2;
  adapt->reject_safety = 0.9;
  adapt->ops->setfromoptions = TSAdaptSetFromOptions_Heuristic;
  adapt->ops->view = TSAdaptView_Heuristic;
  PetscFunctionReturn(PETSC_SUCCESS);
}
