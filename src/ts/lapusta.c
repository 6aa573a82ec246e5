/* TSLAPUSTA as a PETSc TS type: steps of a fault in a medium that radiates waves, as in Lapusta, Rice, Ben-Zion & Zheng
   (2000). Slip rates are constant within a step, and all that depends on slip, waves included, follows them exactly
   (SlipDriftOps.drift). A step predicts with the rates of its start and corrects twice, with the mean of these and of
   the rates that friction has at the end. It is of second order, and the next step begins with the rates at the end of
   the second correction. It never extrapolates the rate of a friction state, because in the shortest useful step, in
   which waves cross half a cell, a cell may slip by many times its characteristic slip.

   The error estimate is the difference of the first and the last correction, and of order h^3.

   For any controller, steps are 1 or 1.5 times a power of 2 of the shortest step, because media with memory prepare
   each length of a step once. No step is shorter, and the shortest one is always accepted. */
#include <slipstep/private/slipts.h>

enum { CORRECTIONS = 2 };
/* Length of steps, in shortest steps, while all cells rest but waves may start slip. Waves of six cells, the least that
   a mesh has, exceed half their peak for twice as long. A step in which a cell moves is repeated as a shortest one. */
#define WAITING 4

typedef struct {
  SlipAttempts at;
  Vec end;         /* rates at the end of the step */
  Vec mean, first; /* rates that lead to the end, and those of the first correction */
  Vec work;
  PetscBool constant; /* the user chose constant steps */
  PetscReal shortest; /* shortest step [s]; 0: there is none */
  PetscBool waits;    /* all cells rest, and steps are short because waves may start slip */
} TS_Lapusta;

static PetscErrorCode TSSetUp_Lapusta(TS ts)
{
  const SlipProblemOps *problem;

  PetscFunctionBegin;
  PetscCall(TSGetSlipProblem(ts, &problem, NULL));
  PetscCheck(problem && problem->drifts.drift, PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_WRONGSTATE,
             "-ts_type " TSLAPUSTA " is of faults: expected a problem that says how its state follows constant rates");
  PetscCall(SlipAttemptsSetUp(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes vec_sol and its rates at the end of an attempt. If not good, it left the domain of the right-hand side. */
static PetscErrorCode Attempt(TS ts, PetscBool *good)
{
  TS_Lapusta *la = (TS_Lapusta *)ts->data;
  const PetscReal t = ts->ptime;
  PetscReal h = ts->time_step, change;

  PetscFunctionBegin;
  PetscCall(VecCopy(la->at.f, la->mean));
  for (PetscInt k = 0; k <= CORRECTIONS; k++) {
    if (k) PetscCall(VecAXPBYPCZ(la->mean, 0.5, 0.5, 0, la->at.f, la->end));
    if (k == 1) PetscCall(VecCopy(la->mean, la->first));
    SlipProblemTry(ts, drifts.drift, h, la->at.start, la->mean, ts->vec_sol);
    PetscCall(SlipGuardState(ts->vec_sol, good));
    if (*good) PetscCall(TSFunctionDomainError(ts, t + h, ts->vec_sol, good));
    if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
    if (k == CORRECTIONS) break;
    PetscCall(TSPreStage(ts, t + h));
    PetscCall(TSComputeRHSFunction(ts, t + h, ts->vec_sol, la->end));
    if (k || !la->waits) continue;
    PetscCall(VecWAXPY(la->work, -1, la->at.f, la->end)); /* a difference, because zeros may have either sign */
    PetscCall(VecNorm(la->work, NORM_INFINITY, &change));
    if (change == 0) { /* corrections change nothing then */
      PetscCall(VecCopy(la->mean, la->first));
      break;
    }
    if (h <= la->shortest) continue;
    h = ts->time_step = la->shortest;
    k = -1;
  }
  PetscCall(TSPostStage(ts, t + h, 0, &ts->vec_sol));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSEvaluateWLTE_Lapusta(TS ts, NormType type, PetscInt *order, PetscReal *wlte)
{
  TS_Lapusta *la = (TS_Lapusta *)ts->data;

  PetscFunctionBegin;
  PetscCall(VecWAXPY(la->work, -1, la->first, la->mean));
  PetscCall(VecScale(la->work, ts->time_step));
  PetscCall(SlipAttemptsError(ts, la->work, type, order, wlte));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Begin(TS ts)
{
  TS_Lapusta *la = (TS_Lapusta *)ts->data;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, &la->constant));
  la->shortest = 0;
  SlipProblemTry(ts, drifts.shortest, &la->shortest);
  if (la->shortest > 0) la->shortest = PetscMax(la->shortest, ts->adapt->dt_min);
  la->waits = PETSC_FALSE;
  if (la->shortest > 0) SlipProblemTry(ts, drifts.waits, ts->ptime, ts->vec_sol, &la->waits);
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
  TS_Lapusta *la = (TS_Lapusta *)ts->data;
  PetscReal end = PETSC_MAX_REAL, left;

  PetscFunctionBegin;
  if (la->constant || !(la->shortest > 0)) PetscFunctionReturn(PETSC_SUCCESS);
  SlipProblemTry(ts, steps.corner, ts->ptime, &end); /* this step may not pass it */
  if (ts->exact_final_time == TS_EXACTFINALTIME_MATCHSTEP) end = PetscMin(end, ts->max_time);
  if (la->waits) ts->time_step = PetscMin(ts->time_step, WAITING * la->shortest);
  left = end - ts->ptime;
  if (ts->time_step < left) ts->time_step = OfList(ts->time_step, la->shortest);
  if (ts->time_step < left && left - ts->time_step < la->shortest) ts->time_step = left / 2;
  if (ts->time_step >= left) ts->time_step = SlipControlEnd(left, ts->ptime, end);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether any error is accepted: steps below the shortest would be too many and no more accurate. */
static PetscBool Whatever(TS ts)
{
  return ts->time_step <= ((TS_Lapusta *)ts->data)->shortest ? PETSC_TRUE : PETSC_FALSE;
}

static PetscErrorCode Retry(TS ts, PetscBool good)
{
  TS_Lapusta *la = (TS_Lapusta *)ts->data;

  PetscFunctionBegin;
  if (good || la->constant || la->at.whole > la->shortest) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipRunFails(ts));
  SETERRQ(PetscObjectComm((PetscObject)ts), PETSC_ERR_CONV_FAILED,
          "At time %.6g s the shortest step, %.6g s, leads to what is no state of the problem (-ts_type %s)",
          (double)ts->ptime, (double)la->shortest, ((PetscObject)ts)->type_name);
}

static PetscErrorCode Accept(TS ts)
{
  TS_Lapusta *la = (TS_Lapusta *)ts->data;
  const Vec f = la->at.f;

  PetscFunctionBegin;
  la->at.f = la->end;
  la->end = f;
  if (!la->constant) ts->time_step = PetscMax(ts->time_step, la->shortest);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const SlipAttemptOps ops = {
  .begin = Begin, .limit = Limit, .attempt = Attempt, .whatever = Whatever, .retry = Retry, .accept = Accept};

/* Interpolates within the last step: from its start at the constant rates of the step. */
static PetscErrorCode TSInterpolate_Lapusta(TS ts, PetscReal t, Vec x)
{
  TS_Lapusta *la = (TS_Lapusta *)ts->data;
  const PetscReal share = PetscClipInterval((t - la->at.before) / (ts->ptime - la->at.before), 0, 1);

  PetscFunctionBegin;
  PetscCall(VecCopy(la->at.start, x));
  PetscCall(VecAXPBY(x, share, 1 - share, ts->vec_sol));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  TSLAPUSTA - "lapusta": steps of constant slip rates, predicted and corrected, for faults in media that radiate waves

  Level: beginner

  Notes:
  The method is of second order and takes two right-hand sides a step. Friction states follow the rates of a step
  exactly, and are stable at any step. TSAdapt type lapusta limits the slip of a step; basic, dsp, pi and heuristic
  limit the error; none takes constant steps. Steps of other controllers are shortened to 1 or 1.5 times a power of 2 of
  the shortest step (SlipDriftOps.shortest). No step is shorter than that, and a step of that length is never
  rejected.

  Errors: PETSC_ERR_ARG_WRONGSTATE for problems without SlipDriftOps.drift

  References:
. * - N. Lapusta, J. R. Rice, Y. Ben-Zion, G. Zheng, Elastodynamic analysis for slow tectonic loading with spontaneous
  rupture episodes on faults with rate- and state-dependent friction, J. Geophys. Res. 105, 2000.

.seealso: TSADAMS, TSRKC, SLIPELASTICWAVES
M*/
PetscErrorCode TSCreate_Lapusta(TS ts)
{
  TS_Lapusta *la;

  PetscFunctionBegin;
  PetscCall(PetscNew(&la));
  ts->data = (void *)la;
  la->at = (SlipAttempts){
    .ops = &ops, .nown = 6, .own = {&la->at.start, &la->at.f, &la->end, &la->mean, &la->first, &la->work}};
  ts->default_adapt_type = TSADAPTBASIC;
  ts->usessnes = PETSC_FALSE;
  ts->ops->reset = SlipAttemptsReset;
  ts->ops->destroy = SlipAttemptsDestroy;
  ts->ops->setup = TSSetUp_Lapusta;
  ts->ops->step = SlipAttemptsStep;
  ts->ops->evaluatewlte = TSEvaluateWLTE_Lapusta;
  ts->ops->rollback = SlipAttemptsRollBack;
  ts->ops->interpolate = TSInterpolate_Lapusta;
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, SLIP_STATE_METHOD, SlipAttemptsState));
  PetscFunctionReturn(PETSC_SUCCESS);
}
