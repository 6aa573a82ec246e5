/* TSBATHE_METHOD_AUTO: each step uses the method that covers the controller's step with fewer products. This file
   provides the input of the rule in src/core/methodcosts.c. */
#include <slipstep/private/slipbathe.h>

/* Stability limits an explicit step even if its controller would take a longer one. The error of the step estimates the
   longer step, but by no more than this factor per step, because the error says nothing about later times. */
static const PetscReal wish_growth = 2;
/* After a rejected long step this estimate is not used before the end of that step, but for no more than so many cut
   steps, because explicit steps over years would be millions. Each further rejected step doubles the number, so that an
   event, in which most long steps would be rejected, has few of them. */
enum { first_wait = 32, last_wait = 4096 };

/* Chooses the method of the next attempt. */
PetscErrorCode TSBatheChooseMethod(TS ts)
{
  static const TSBatheMethodOps *const rows[] = {&TSBatheStabilised, &TSBatheMoreau}; /* explicit ones */
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscBool takes = PETSC_FALSE;

  PetscFunctionBegin;
  ba->other = NULL;
  ba->now = ba->choice.method == TSBATHE_METHOD_EXPLICIT ? &TSBatheMoreau : &TSBatheImplicit;
  if (ba->choice.method != TSBATHE_METHOD_AUTO) PetscFunctionReturn(PETSC_SUCCESS);
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(rows) && !takes; i++) {
    takes = PETSC_TRUE;
    if (rows[i]->exists) PetscCall((*rows[i]->exists)(ts, &takes));
    if (takes) ba->other = rows[i];
  }
  PetscCall((*ba->other->pays)(ts, &takes));
  if (takes) ba->now = ba->other;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TSBatheMethodBegin(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscBool other;

  PetscFunctionBegin;
  if (!ba->choice.given && ba->con && ba->ops->explicit_ops && ba->ops->explicit_ops->by_default) {
    PetscCall(PetscObjectTypeCompareAny((PetscObject)ts->adapt, &other, TSADAPTNONE, TSADAPTHISTORY, "rl", ""));
    ba->choice.method = other ? TSBATHE_METHOD_IMPLICIT : TSBATHE_METHOD_AUTO;
  }
  SlipMethodSetUp(&ba->moreau.costs);
  ba->stabilised.implicit = 0;
  ba->choice.refused = PETSC_MIN_REAL;
  ba->choice.cut = 0;
  ba->choice.wait = first_wait;
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
  if (ba->was == &TSBatheImplicit) {
    ba->choice.cut = 0;
    ba->choice.wait = first_wait;
  }
  if (ba->choice.method != TSBATHE_METHOD_AUTO || ba->was != &TSBatheMoreau || error < 0 || h < ba->moreau.longest)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ts->adapt, &given, TSADAPTNONE, TSADAPTHISTORY, "rl", ""));
  if (given || (end < ba->choice.refused && ++ba->choice.cut < ba->choice.wait)) PetscFunctionReturn(PETSC_SUCCESS);
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

  if (ba->choice.method != TSBATHE_METHOD_AUTO || ba->was != &TSBatheImplicit) return;
  ba->choice.refused = PetscMax(ba->choice.refused, ts->ptime + ba->last.dt);
  ba->choice.cut = 0;
  ba->choice.wait = PetscMin(2 * ba->choice.wait, last_wait);
}

PetscErrorCode TSBatheMethodState(SlipState s, TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscBool has = ba->choice.method == TSBATHE_METHOD_AUTO ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  if (SlipStateIsLoading(s)) PetscCall(SlipStateHas(s, "method", &has));
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSBatheSetDefaultMethod(ts, TSBATHE_METHOD_AUTO)); /* as in the run that wrote it */
  PetscCall(SlipStateGroup(s, "method"));
  PetscCall(SlipStateReal(s, "products_step", 1, &ba->moreau.costs.step));
  PetscCall(SlipStateReal(s, "products_solve", 1, &ba->moreau.costs.solve));
  PetscCall(SlipStateReal(s, "refused", 1, &ba->choice.refused));
  PetscCall(SlipStateInt(s, "cut", 1, &ba->choice.cut));
  PetscCall(SlipStateInt(s, "wait", 1, &ba->choice.wait));
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
  ba->choice.method = method;
  ba->choice.given = PETSC_TRUE;
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
  if (ba && !ba->choice.given) ba->choice.method = method;
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
  *method = ba->choice.method;
  PetscFunctionReturn(PETSC_SUCCESS);
}
