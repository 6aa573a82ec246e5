/* What controllers share: the error estimate of the step, whether a step is still allowed, and the step after a
   failure. */
#include <slipstep/private/slipadapt.h>

/*
  Types with their own estimate (theta, bdf, alpha, bathe) give E and its order, the power of h that it goes with;
  embedded Runge-Kutta pairs give a second solution instead, as in PETSc's own controllers.
*/
PetscErrorCode SlipAdaptEvaluateError(TSAdapt adapt, TS ts, PetscInt *order, PetscReal *E)
{
  PetscReal unused[2];
  Vec y;

  PetscFunctionBegin;
  *order = PETSC_DECIDE;
  *E = -1;
  if (ts->ops->evaluatewlte) {
    PetscCall(TSEvaluateWLTE(ts, adapt->wnormtype, order, E));
  } else if (ts->ops->evaluatestep && adapt->candidates.inuse_set) {
    *order = adapt->candidates.order[0];
    PetscCall(VecDuplicate(ts->vec_sol, &y));
    PetscCall(TSEvaluateStep(ts, *order - 1, y, NULL));
    PetscCall(TSErrorWeightedNorm(ts, ts->vec_sol, y, adapt->wnormtype, E, &unused[0], &unused[1]));
    PetscCall(VecDestroy(&y));
  }
  PetscCheck(!PetscIsNanReal(*E), PetscObjectComm((PetscObject)adapt), PETSC_ERR_FP,
             "At time %g s the error estimate of a step of %g s is not a number (-ts_type %s)", (double)ts->ptime,
             (double)ts->time_step, ((PetscObject)ts)->type_name);
  PetscCheck(*E < 0 || *order >= 1, PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_OUTOFRANGE,
             "TS type %s estimates its error with order %" PetscInt_FMT "; expected at least 1",
             ((PetscObject)ts)->type_name, *order);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipAdaptCheckMinimum(TSAdapt adapt, TS ts, PetscReal h, const char why[])
{
  PetscFunctionBegin;
  PetscCheck(h >= adapt->dt_min, PetscObjectComm((PetscObject)adapt), PETSC_ERR_CONV_FAILED,
             "At time %g s %s asks for a step of %g s, below -ts_adapt_dt_min %g s (-ts_adapt_type %s)",
             (double)ts->ptime, why, (double)h, (double)adapt->dt_min, ((PetscObject)adapt)->type_name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipAdaptFailureOption(TSAdapt adapt, SlipOptionItems PetscOptionsObject, const char option[])
{
  PetscReal *factor = (PetscReal *)adapt->data;

  PetscFunctionBegin;
  PetscCall(
    PetscOptionsReal(option, "Factor on the step when a solve did not converge, in (0, 1)", "", *factor, factor, NULL));
  PetscCheck(*factor > 0 && *factor < 1, PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_OUTOFRANGE,
             "%s is %g; expected a number in (0, 1)", option, (double)*factor);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipAdaptAfterFailure(TSAdapt adapt, TS ts, PetscReal h_failed, PetscReal *h_next)
{
  PetscFunctionBegin;
  *h_next = *(const PetscReal *)adapt->data * h_failed;
  PetscCall(SlipAdaptCheckMinimum(adapt, ts, *h_next, "a solve that did not converge"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipAdaptDestroyData(TSAdapt adapt)
{
  PetscFunctionBegin;
  PetscCall(PetscObjectComposeFunction((PetscObject)adapt, "TSAdaptChooseAfterFailure_C", NULL));
  PetscCall(PetscFree(adapt->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}
