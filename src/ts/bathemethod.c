/* TSBATHE_METHOD_AUTO: each step uses the method that covers the controller's step with fewer products. This file
   provides the input of the rule in src/core/methodcosts.c. */
#include <slipstep/private/slipts.h>
#include <slipstep/private/slipsys.h>

/* Stability limits an explicit step even if its controller would take a longer one. The error of the step estimates the
   longer step, but by no more than this factor per step, because the error says nothing about later times. */
static const PetscReal wish_growth = 2;
/* After a rejected long step this estimate is not used before the end of that step, but for no more than so many cut
   steps, because explicit steps over years would be millions. Each further rejected step doubles the number, so that an
   event, in which most long steps would be rejected, has few of them. */
enum { first_wait = 32, last_wait = 4096 };

/* Chooses the method of the next step. Constant steps and those of a history are explicit where they are stable. */
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

/* Resets the count of cut steps after an implicit attempt. */
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

/* Changes *next, the controller's step after an accepted one, to what it would be without the cut of the step, whose
   length was `whole` before [s]. It leaves constant steps alone, and those of a policy, which has no tolerance. */
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

/* Records a rejected long step: before its end no step as long will succeed, which explicit steps do not show. */
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
  PetscCall(TSBatheSetDefaultMethod(ts, TSBATHE_METHOD_AUTO)); /* as in the run that wrote it */
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

/* ---- choices of the user ---- */

/*@
  TSBatheSetMethod - sets the method that computes the next attempts

  Logically collective

  Input Parameters:
+ ts     - of type TSBATHE or TSMOREAU, ignored otherwise
- method - TSBATHE_METHOD_IMPLICIT, the default of TSBATHE; TSBATHE_METHOD_EXPLICIT, that of TSMOREAU; or
           TSBATHE_METHOD_AUTO, which takes for each step the method that needs fewer products, and is the default of
           faults and small systems as the pages of SlipFaultConfigureTS() and SlipSmallConfigureTS() describe

  Options Database Key:
. -ts_bathe_method <implicit,explicit,auto> - the same, of TSBATHE

  Level: advanced

  Notes:
  It may change from attempt to attempt, for example by a controller: both methods lead from a state and its reaction to
  the next. The first explicit step after an implicit one costs one more product with K and one more with H. Explicit
  steps are cut to `TSBatheGetLongestStep()`.

  With auto, explicit steps cover the controller's step if they take fewer products with stiffness and viscosity, and
  applications of the preconditioner, than an implicit one. Both costs are moving means of counts of the last attempts,
  not times, so that results do not depend on chance. After cut explicit steps their error estimates the step that the
  controller would take, which grows up to twofold per step. After a rejected implicit step that begins at the end of
  that step or after 32 cut steps, a number that each further rejection doubles. Where there are no explicit steps, and
  where constant or given steps are too long to be stable, all steps are implicit. `SlipAttempt` has the method.

  Where a problem has no inertia (`side` of SlipProblemOps) explicit steps are those of TSRKC, as long as the
  controller's. They are taken where their stages cost less than the iterations of solves in a moving mean.

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

/* Sets the method of attempts where neither `TSBatheSetMethod()` nor its option has set it. ts: of type TSBATHE,
   ignored otherwise; method: implicit, explicit or auto. */
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
  TSBatheGetMethod - gets the method that computes the next attempts

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
