/* TSBATHE_METHOD_AUTO: each step by the method that goes as far as the controller wants for fewer products. The rule is
   that of src/core/method.c; here is what it is asked with. */
#include <slipstep/private/slipts.h>
#include <slipstep/private/slipsys.h>

/* An explicit step is no longer than is stable, however far its controller would go. What it would do is told by the
   error of the step, but not by more from one step to the next, as that says nothing of what comes later. */
static const PetscReal wish_growth = 2;

/* Constant steps are as long as they are: explicit where these are stable. */
PetscErrorCode TSBatheChooseMethod(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const PetscReal h = ts->time_step;
  PetscBool given;

  PetscFunctionBegin;
  if (ba->method != TSBATHE_METHOD_AUTO) {
    ba->now = ba->method;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(TSBatheGetLongestStep(ts, &ba->longest));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ts->adapt, &given, TSADAPTNONE, TSADAPTHISTORY, ""));
  ba->now = TSBATHE_METHOD_IMPLICIT;
  if (given ? h <= ba->longest
            : SlipMethodIsExplicit(&ba->costs, h, ba->longest, ba->end.known ? PETSC_FALSE : PETSC_TRUE))
    ba->now = TSBATHE_METHOD_EXPLICIT;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* *next, the controller's after a step that was taken, to what it would be had the step not been cut. whole: before it
   was [s]. Constant steps and those of a policy, which knows no tolerance, are as they are said to be. */
PetscErrorCode TSBatheMethodWish(TS ts, PetscReal whole, PetscReal *next)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const PetscReal end = ts->ptime, h = ba->last.dt;
  PetscReal wish, error = ba->last.error;
  PetscBool given;
  PetscInt order;

  PetscFunctionBegin;
  if (ba->method != TSBATHE_METHOD_AUTO || ba->now != TSBATHE_METHOD_EXPLICIT || error < 0 || end < ba->refused ||
      h < ba->longest)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ts->adapt, &given, TSADAPTNONE, TSADAPTHISTORY, "rl", ""));
  if (given) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSEvaluateWLTE(ts, NORM_2, &order, &error));
  wish = wish_growth * PetscMax(whole, h);
  if (error > 0) wish = PetscMin(wish, ts->adapt->safety * h * PetscPowReal(error, -1 / (PetscReal)order));
  wish = PetscClipInterval(wish, ts->adapt->dt_min, ts->adapt->dt_max);
  if (ts->exact_final_time == TS_EXACTFINALTIME_MATCHSTEP) wish = SlipControlMatch(wish, ts->max_time - end);
  *next = PetscMax(*next, wish);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A long step that was refused says what explicit steps do not: that nothing as long will do before its end. */
void TSBatheMethodRefused(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  if (ba->method == TSBATHE_METHOD_AUTO && ba->now == TSBATHE_METHOD_IMPLICIT)
    ba->refused = PetscMax(ba->refused, ts->ptime + ba->last.dt);
}

PetscErrorCode TSBatheMethodState(SlipState s, TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscBool has = ba->method == TSBATHE_METHOD_AUTO ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  if (SlipStateIsLoading(s)) PetscCall(SlipStateHas(s, "method", &has));
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipStateGroup(s, "method"));
  PetscCall(SlipStateReal(s, "products_step", 1, &ba->costs.step));
  PetscCall(SlipStateReal(s, "products_solve", 1, &ba->costs.solve));
  PetscCall(SlipStateReal(s, "refused", 1, &ba->refused));
  PetscCall(SlipStateGroup(s, "ts"));
  PetscFunctionReturn(PETSC_SUCCESS);
}
