/* TSBATHE_METHOD_AUTO: each step by the method that goes as far as the controller wants for fewer products. The rule is
   that of src/core/methodcosts.c; here is what it is asked with. */
#include <slipstep/private/slipts.h>
#include <slipstep/private/slipsys.h>

/* An explicit step is no longer than is stable, however far its controller would go. What it would do is told by the
   error of the step, but not by more from one step to the next, as that says nothing of what comes later. */
static const PetscReal wish_growth = 2;
/* After a long step that was refused it does not grow beyond the controller's before that step's end, but for no longer
   than so many steps that were cut, as to the end of years explicit ones would be millions. Each further step that is
   refused doubles the number, so that an event, in which many would be, takes few of them. */
enum { first_wait = 32, last_wait = 4096 };

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
  PetscCall(TSStabilisedIs(ts, &ba->stabilised));
  if (ba->stabilised) {
    PetscCall(TSStabilisedChoose(ts));
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

/* After an implicit attempt */
static void TSBatheMethodWait(TS_Bathe *ba, PetscInt wait)
{
  ba->cut = 0;
  ba->wait = PetscMin(wait, last_wait);
}

PetscErrorCode TSBatheMethodBegin(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscBool other;

  PetscFunctionBegin;
  if (!ba->method_given && ba->con && ba->ops->explicit_ops && ba->ops->explicit_ops->by_default) {
    PetscCall(PetscObjectTypeCompareAny((PetscObject)ts->adapt, &other, TSADAPTNONE, TSADAPTHISTORY, "rl", ""));
    ba->method = other ? TSBATHE_METHOD_IMPLICIT : TSBATHE_METHOD_AUTO;
  }
  SlipMethodSetUp(&ba->costs);
  ba->implicit = 0;
  ba->refused = PETSC_MIN_REAL;
  TSBatheMethodWait(ba, first_wait);
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
  if (ba->now == TSBATHE_METHOD_IMPLICIT) TSBatheMethodWait(ba, first_wait);
  if (ba->method != TSBATHE_METHOD_AUTO || ba->stabilised || ba->now != TSBATHE_METHOD_EXPLICIT || error < 0 ||
      h < ba->longest)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ts->adapt, &given, TSADAPTNONE, TSADAPTHISTORY, "rl", ""));
  if (given || (end < ba->refused && ++ba->cut < ba->wait)) PetscFunctionReturn(PETSC_SUCCESS);
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

  if (ba->method != TSBATHE_METHOD_AUTO || ba->now != TSBATHE_METHOD_IMPLICIT) return;
  ba->refused = PetscMax(ba->refused, ts->ptime + ba->last.dt);
  TSBatheMethodWait(ba, 2 * ba->wait);
}

PetscErrorCode TSBatheMethodState(SlipState s, TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscBool has = ba->method == TSBATHE_METHOD_AUTO ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  if (SlipStateIsLoading(s)) PetscCall(SlipStateHas(s, "method", &has));
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSBatheSetDefaultMethod(ts, TSBATHE_METHOD_AUTO)); /* as it was */
  PetscCall(SlipStateGroup(s, "method"));
  PetscCall(SlipStateReal(s, "products_step", 1, &ba->costs.step));
  PetscCall(SlipStateReal(s, "products_solve", 1, &ba->costs.solve));
  PetscCall(SlipStateReal(s, "refused", 1, &ba->refused));
  PetscCall(SlipStateInt(s, "cut", 1, &ba->cut));
  PetscCall(SlipStateInt(s, "wait", 1, &ba->wait));
  PetscCall(TSStabilisedState(s, ts));
  PetscCall(SlipStateGroup(s, "ts"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what is asked for ---- */

/*@
  TSBatheSetMethod - how the next attempts are computed

  Logically collective

  Input Parameters:
+ ts     - of type TSBATHE or TSMOREAU, ignored otherwise
- method - TSBATHE_METHOD_IMPLICIT, the default of TSBATHE, TSBATHE_METHOD_EXPLICIT, that of TSMOREAU, or
           TSBATHE_METHOD_AUTO, by which each step is of the method that goes as far for fewer products, and which is
           the default of faults and small systems where SlipFaultConfigureTS() and SlipSmallConfigureTS() say so

  Options Database Key:
. -ts_bathe_method <implicit,explicit,auto> - the same, of TSBATHE

  Level: advanced

  Notes:
  It may change from attempt to attempt, as by a controller: both methods go from a state and its reaction to the next.
  The first explicit step after an implicit one costs a product with K and one with H more. Steps are cut to
  `TSBatheGetLongestStep()` where they are explicit.

  With auto the step that the controller wants is gone by explicit steps if these take fewer products with stiffness and
  viscosity, and applications of the preconditioner, than an implicit one. What either takes is a moving mean of the
  last attempts, no time, so that results do not depend on chance. After explicit steps that were cut the controller's
  wish is known by their error, and grows up to twofold a step; after an implicit step that was refused it does so from
  the end of that step on, or once 32 steps were cut, twice as many after each that is refused again. Where explicit
  steps do not exist, and where constant or given steps are longer than is stable, all steps are implicit. The method of
  an attempt is in `SlipAttempt`.

  Of a problem without inertia (`side` of SlipProblemOps) explicit steps are those of TSRKC, as long as the controller
  wants them, taken where their stages cost less than the iterations of solves do in a moving mean.

  Errors: PETSC_ERR_SUP at the next attempt, for an explicit method and a constraint without explicit_ops

.seealso: TSBatheGetMethod(), TSMOREAU, TSBATHE
@*/
PetscErrorCode TSBatheSetMethod(TS ts, TSBatheMethod method)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_FALSE, &ba));
  PetscValidLogicalCollectiveEnum(ts, method, 2);
  if (!ba) PetscFunctionReturn(PETSC_SUCCESS);
  ba->method = method;
  ba->method_given = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheSetDefaultMethod - how attempts are computed where neither `TSBatheSetMethod()` nor its option has said it

  Logically collective; for problems (SlipProblemOps), which know where auto has won

  Input Parameters:
+ ts     - of type TSBATHE, ignored otherwise
- method - implicit, explicit or auto

  Level: developer

.seealso: TSBatheSetMethod(), TSAdaptRLSetDefaultAccuracy()
@*/
PetscErrorCode TSBatheSetDefaultMethod(TS ts, TSBatheMethod method)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_FALSE, &ba));
  PetscValidLogicalCollectiveEnum(ts, method, 2);
  if (ba && !ba->method_given) ba->method = method;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetMethod - how the next attempts are computed

  Not collective

  Input Parameter:
. ts - of type TSBATHE or TSMOREAU

  Output Parameter:
. method - implicit, explicit or auto

  Level: advanced

.seealso: TSBatheSetMethod()
@*/
PetscErrorCode TSBatheGetMethod(TS ts, TSBatheMethod *method)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  *method = ba->method;
  PetscFunctionReturn(PETSC_SUCCESS);
}
