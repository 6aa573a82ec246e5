/* TSLAPUSTA as a PETSc TS type: steps of a fault in a medium that radiates waves, as in Lapusta, Rice, Ben-Zion & Zheng
   (2000), and longer steps by the formulas of TSADAMS.

   In short steps, and in all where friction sticks or the controller estimates no errors, slip rates are constant
   within a step, and all that depends on slip, waves included, follows them exactly (SlipDriftOps.drift). A step
   predicts with the rates of its start and corrects twice, with the mean of these and of the rates that friction has at
   the end. It is of second order, and the next step begins with the rates at the end of the second correction. It never
   extrapolates the rate of a friction state, because in the shortest useful step, in
   which waves cross half a cell, a cell may slip by many times its characteristic slip.

   The error estimate is the difference of the first and the last correction, and of order h^3.

   Steps of a smooth problem that are longer than a few shortest ones are those of TSADAMS (adams.c), of a higher order:
   slow slip meets no waves, and its error decides when events come. The medium still sees constant rates in a step,
   which matter little there: its stress differs by the impedance times half the change of a rate that is far below a
   sigma over the impedance, where stress resists through friction alone.

   For any controller, steps are 1 or 1.5 times a power of 2 of the shortest step, because media with memory prepare
   each length of a step once. No step is shorter, and the shortest one is always accepted. */
#include <slipstep/private/slipts.h>

enum { CORRECTIONS = 2 };
/* Length of steps, in shortest steps, while all cells rest but waves may start slip. Waves of six cells, the least that
   a mesh has, exceed half their peak for twice as long. A step in which a cell moves is repeated as a shortest one. */
#define WAITING 4

/* Longest step of constant rates where longer ones are those of TSADAMS, in shortest steps. 1 to 16 make events of SEAS
   BP1-FD differ by 0.1 years and products by 2 %. */
#define STRAIGHT 4

static PetscErrorCode TSSetUp_Lapusta(TS ts)
{
  const SlipProblemOps *problem;

  PetscFunctionBegin;
  PetscCall(TSGetSlipProblem(ts, &problem, NULL));
  PetscCheck(problem && problem->drifts.drift, PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_WRONGSTATE,
             "-ts_type " TSLAPUSTA " is of faults: expected a problem that says how its state follows constant rates");
  PetscCall(TSSetUp_Adams(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes vec_sol and its rates at the end of an attempt. If not good, it left the domain of the right-hand side. */
static PetscErrorCode Attempt(TS ts, PetscBool *good)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  const PetscReal t = ts->ptime;
  PetscReal h = ts->time_step, change;

  PetscFunctionBegin;
  ad->straight = !ad->adams || h <= STRAIGHT * ad->shortest ? PETSC_TRUE : PETSC_FALSE;
  if (!ad->straight) {
    PetscCall((*SlipAdamsOps.attempt)(ts, good));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecCopy(ad->rate[0], ad->y));
  for (PetscInt k = 0; k <= CORRECTIONS; k++) {
    if (k) PetscCall(VecAXPBYPCZ(ad->y, 0.5, 0.5, 0, ad->rate[0], ad->star));
    if (k == 1) PetscCall(VecCopy(ad->y, ad->room[0]));
    SlipProblemTry(ts, drifts.drift, h, ad->at.start, ad->y, ts->vec_sol);
    PetscCall(SlipGuardState(ts->vec_sol, good));
    if (*good) PetscCall(TSFunctionDomainError(ts, t + h, ts->vec_sol, good));
    if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
    if (k == CORRECTIONS) break;
    PetscCall(TSPreStage(ts, t + h));
    PetscCall(TSComputeRHSFunction(ts, t + h, ts->vec_sol, ad->star));
    if (k || !ad->waits) continue;
    PetscCall(VecWAXPY(ad->room[1], -1, ad->rate[0], ad->star)); /* a difference, because zeros may have either sign */
    PetscCall(VecNorm(ad->room[1], NORM_INFINITY, &change));
    if (change == 0) { /* corrections change nothing then */
      PetscCall(VecCopy(ad->y, ad->room[0]));
      break;
    }
    if (h <= ad->shortest) continue;
    h = ts->time_step = ad->shortest;
    k = -1;
  }
  PetscCall(TSPostStage(ts, t + h, 0, &ts->vec_sol));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSEvaluateWLTE_Lapusta(TS ts, NormType type, PetscInt *order, PetscReal *wlte)
{
  TS_Adams *ad = (TS_Adams *)ts->data;

  PetscFunctionBegin;
  if (!ad->straight) {
    PetscCall(TSEvaluateWLTE_Adams(ts, type, order, wlte));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecWAXPY(ad->room[1], -1, ad->room[0], ad->y));
  PetscCall(VecScale(ad->room[1], ts->time_step));
  PetscCall(SlipAttemptsError(ts, ad->room[1], type, order, wlte));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Begin(TS ts)
{
  TS_Adams *ad = (TS_Adams *)ts->data;

  const SlipProblemOps *problem;
  PetscBool slips;

  PetscFunctionBegin;
  PetscCall((*SlipAdamsOps.begin)(ts));
  PetscCall(PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, &ad->constant));
  PetscCall(PetscObjectTypeCompare((PetscObject)ts->adapt, "lapusta", &slips));
  PetscCall(TSGetSlipProblem(ts, &problem, NULL));
  ad->adams = !ad->constant && !slips && !problem->drifts.waits ? PETSC_TRUE : PETSC_FALSE;
  ad->shortest = 0;
  SlipProblemTry(ts, drifts.shortest, &ad->shortest);
  if (ad->shortest > 0) ad->shortest = PetscMax(ad->shortest, ts->adapt->dt_min);
  ad->waits = PETSC_FALSE;
  if (ad->shortest > 0) SlipProblemTry(ts, drifts.waits, ts->ptime, ts->vec_sol, &ad->waits);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the longest allowed length up to h. An allowed h returns itself, in spite of the rounding of its ratio. */
static PetscReal OfList(PetscReal h, PetscReal shortest)
{
  PetscReal power;
  int exponent;

  if (!(h > shortest)) return shortest;
  power = frexp(h / shortest * (1 + 8 * PETSC_MACHINE_EPSILON), &exponent); /* in [0.5, 1) */
  return shortest * ldexp(power >= 0.75 ? 0.75 : 0.5, exponent);
}

/* Limits the step to the allowed lengths. Only a step that ends at a corner of the loading, or with the run, may have
   another length; where it would leave less than the shortest step until then, two equal steps are taken. */
static PetscErrorCode Limit(TS ts)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  PetscReal end = PETSC_MAX_REAL, left;

  PetscFunctionBegin;
  if (ad->constant || !(ad->shortest > 0)) PetscFunctionReturn(PETSC_SUCCESS);
  SlipProblemTry(ts, steps.corner, ts->ptime, &end); /* this step may not pass it */
  if (ts->exact_final_time == TS_EXACTFINALTIME_MATCHSTEP) end = PetscMin(end, ts->max_time);
  if (ad->waits) ts->time_step = PetscMin(ts->time_step, WAITING * ad->shortest);
  left = end - ts->ptime;
  if (ts->time_step < left) ts->time_step = OfList(ts->time_step, ad->shortest);
  if (ts->time_step < left && left - ts->time_step < ad->shortest) ts->time_step = left / 2;
  if (ts->time_step >= left) ts->time_step = SlipControlEnd(left, ts->ptime, end);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether any error is accepted: steps below the shortest would be too many and no more accurate. */
static PetscBool Whatever(TS ts)
{
  return ts->time_step <= ((TS_Adams *)ts->data)->shortest ? PETSC_TRUE : PETSC_FALSE;
}

static PetscErrorCode Retry(TS ts, PetscBool good)
{
  TS_Adams *ad = (TS_Adams *)ts->data;

  PetscFunctionBegin;
  if (!ad->straight) PetscCall((*SlipAdamsOps.retry)(ts, good));
  if (good || ad->constant || ad->at.whole > ad->shortest) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipRunFails(ts));
  SETERRQ(PetscObjectComm((PetscObject)ts), PETSC_ERR_CONV_FAILED,
          "At time %.6g s the shortest step, %.6g s, leads to what is no state of the problem (-ts_type %s)",
          (double)ts->ptime, (double)ad->shortest, ((PetscObject)ts)->type_name);
}

static PetscErrorCode Accept(TS ts)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  const Vec f = ad->rate[0];

  PetscFunctionBegin;
  if (ad->straight) { /* earlier rates are useless for the next step */
    ad->rate[0] = ad->star;
    ad->star = f;
    ad->n = ad->order = 1;
    ad->since = 0;
  } else
    PetscCall((*SlipAdamsOps.accept)(ts));
  if (!ad->constant) ts->time_step = PetscMax(ts->time_step, ad->shortest);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscInt Order(TS ts)
{
  return ((TS_Adams *)ts->data)->straight ? 2 : (*SlipAdamsOps.order)(ts);
}

/* Limits the next step to what is stable where slip rates relax. */
static PetscErrorCode Bound(TS ts)
{
  PetscFunctionBegin;
  if (((TS_Adams *)ts->data)->adams) PetscCall((*SlipAdamsOps.bound)(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const SlipAttemptOps ops = {.begin = Begin,
                                   .limit = Limit,
                                   .attempt = Attempt,
                                   .order = Order,
                                   .whatever = Whatever,
                                   .retry = Retry,
                                   .accept = Accept,
                                   .bound = Bound};

PetscErrorCode SlipLapustaIsStraight(TS ts, PetscBool *lapusta, PetscBool *straight)
{
  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSLAPUSTA, lapusta));
  *straight = *lapusta && ((TS_Adams *)ts->data)->straight ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Interpolates within the last step: from its start at the constant rates of the step, or as TSADAMS does. */
static PetscErrorCode TSInterpolate_Lapusta(TS ts, PetscReal t, Vec x)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  const PetscReal share = PetscClipInterval((t - ad->at.before) / (ts->ptime - ad->at.before), 0, 1);

  PetscFunctionBegin;
  if (!ad->straight) {
    PetscCall(TSInterpolate_Adams(ts, t, x));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecCopy(ad->at.start, x));
  PetscCall(VecAXPBY(x, share, 1 - share, ts->vec_sol));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  TSLAPUSTA - "lapusta": steps of constant slip rates, predicted and corrected, for faults in media that radiate waves

  Level: beginner

  Notes:
  The method is of second order and takes two right-hand sides a step. Friction states follow the rates of a step
  exactly, and are stable at any step. TSAdapt type lapusta limits the slip of a step; basic, dsp and heuristic
  limit the error; none takes constant steps. Under those that limit the error, steps longer than 4 shortest ones of
  friction whose cells always slide are those of TSADAMS, with its options. Steps of other controllers are shortened to
  1 or 1.5 times a power of 2 of the shortest step (SlipDriftOps.shortest). No step is shorter than that, and a step of
  that length is never rejected.

  Errors: PETSC_ERR_ARG_WRONGSTATE for problems without SlipDriftOps.drift

  References:
. * - N. Lapusta, J. R. Rice, Y. Ben-Zion, G. Zheng, Elastodynamic analysis for slow tectonic loading with spontaneous
  rupture episodes on faults with rate- and state-dependent friction, J. Geophys. Res. 105, 2000.

.seealso: TSADAMS, TSRKC, SLIPELASTICWAVES
M*/
PetscErrorCode TSCreate_Lapusta(TS ts)
{
  PetscFunctionBegin;
  PetscCall(TSCreate_Adams(ts));
  ((TS_Adams *)ts->data)->at.ops = &ops;
  ts->usessnes = PETSC_FALSE;
  ts->ops->setup = TSSetUp_Lapusta;
  ts->ops->evaluatewlte = TSEvaluateWLTE_Lapusta;
  ts->ops->interpolate = TSInterpolate_Lapusta;
  PetscFunctionReturn(PETSC_SUCCESS);
}
