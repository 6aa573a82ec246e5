/* TSLAPUSTA as a PETSc TS type: steps of a fault that remembers its waves, as those of Lapusta, Rice, Ben-Zion & Zheng
   (2000). Slip rates are constant within a step, what depends on slip follows them exactly (SlipProblemOps.drift), and
   so do the waves. A step predicts with the rates of its start, corrects with the mean of these and those that friction
   has then, twice, and is of second order; the next one begins with the rates of the second time. No rate of a state is
   ever extrapolated: in steps in which waves cross half a cell, the shortest that there is anything to know about, a
   cell may slip by many times its characteristic slip.

   The error estimate is the difference of the first and the last correction, and of order h^3. */
#include <slipstep/private/slipts.h>

enum { CORRECTIONS = 2 };

typedef struct {
  SlipAttempts at;
  Vec end;         /* rates at the end of the step, */
  Vec mean, first; /* those that lead there, and those of the first correction */
  Vec work;
} TS_Lapusta;

static PetscErrorCode TSReset_Lapusta(TS ts)
{
  TS_Lapusta *la = (TS_Lapusta *)ts->data;
  Vec *vecs[] = {&la->at.start, &la->at.f, &la->end, &la->mean, &la->first, &la->work};

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(vecs); i++) PetscCall(VecDestroy(vecs[i]));
  la->at.known = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSDestroy_Lapusta(TS ts)
{
  PetscFunctionBegin;
  PetscCall(TSReset_Lapusta(ts));
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, SLIP_STATE_METHOD, NULL));
  PetscCall(PetscFree(ts->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSSetUp_Lapusta(TS ts)
{
  TS_Lapusta *la = (TS_Lapusta *)ts->data;
  Vec *vecs[] = {&la->at.start, &la->at.f, &la->end, &la->mean, &la->first, &la->work};
  const SlipProblemOps *problem;

  PetscFunctionBegin;
  PetscCall(TSGetSlipProblem(ts, &problem, NULL));
  PetscCheck(problem && problem->drift, PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_WRONGSTATE,
             "-ts_type " TSLAPUSTA " is of faults: expected a problem that says how its state follows constant rates");
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(vecs); i++)
    if (!*vecs[i]) PetscCall(VecDuplicate(ts->vec_sol, vecs[i]));
  PetscCall(TSGetAdapt(ts, &ts->adapt));
  PetscCall(TSAdaptCandidatesClear(ts->adapt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* vec_sol after h at the rates la->mean */
static PetscErrorCode Drift(TS ts, PetscReal h)
{
  TS_Lapusta *la = (TS_Lapusta *)ts->data;
  const SlipProblemOps *problem;
  void *ctx;

  PetscFunctionBegin;
  PetscCall(TSGetSlipProblem(ts, &problem, &ctx));
  PetscCall((*problem->drift)(ts, h, la->at.start, la->mean, ts->vec_sol, ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* vec_sol and the rates there, at the end of an attempt; not good: it left the domain of the right-hand side */
static PetscErrorCode Attempt(TS ts, PetscBool *good)
{
  TS_Lapusta *la = (TS_Lapusta *)ts->data;
  const PetscReal t = ts->ptime, h = ts->time_step;

  PetscFunctionBegin;
  PetscCall(VecCopy(la->at.f, la->mean));
  for (PetscInt k = 0; k <= CORRECTIONS; k++) {
    if (k) PetscCall(VecAXPBYPCZ(la->mean, 0.5, 0.5, 0, la->at.f, la->end));
    if (k == 1) PetscCall(VecCopy(la->mean, la->first));
    PetscCall(Drift(ts, h));
    PetscCall(SlipGuardState(ts->vec_sol, good));
    if (*good) PetscCall(TSFunctionDomainError(ts, t + h, ts->vec_sol, good));
    if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
    if (k == CORRECTIONS) break;
    PetscCall(TSPreStage(ts, t + h));
    PetscCall(TSComputeRHSFunction(ts, t + h, ts->vec_sol, la->end));
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

static PetscErrorCode Accept(TS ts)
{
  TS_Lapusta *la = (TS_Lapusta *)ts->data;
  const Vec f = la->at.f;

  PetscFunctionBegin;
  la->at.f = la->end;
  la->end = f;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSStep_Lapusta(TS ts)
{
  static const SlipAttemptOps ops = {.attempt = Attempt, .accept = Accept};
  PetscBool accepted;

  PetscFunctionBegin;
  PetscCall(SlipAttemptsStep(ts, &ops, &accepted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Between both ends: the start, at the constant rates of the step */
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
  TSLAPUSTA - "lapusta": steps of constant slip rates, predicted and corrected, for faults that remember their waves

  Level: beginner

  Notes:
  Of second order, two right-hand sides a step. States of friction follow the rates of a step by themselves, and are
  stable at any step. TSAdapt type lapusta bounds the slip of a step; basic, dsp, pi and heuristic bound the error; none
  takes constant steps.

  Errors: PETSC_ERR_ARG_WRONGSTATE for problems without SlipProblemOps.drift

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
  ts->default_adapt_type = TSADAPTBASIC;
  ts->usessnes = PETSC_FALSE;
  ts->ops->reset = TSReset_Lapusta;
  ts->ops->destroy = TSDestroy_Lapusta;
  ts->ops->setup = TSSetUp_Lapusta;
  ts->ops->step = TSStep_Lapusta;
  ts->ops->evaluatewlte = TSEvaluateWLTE_Lapusta;
  ts->ops->rollback = SlipAttemptsRollBack;
  ts->ops->interpolate = TSInterpolate_Lapusta;
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, SLIP_STATE_METHOD, SlipAttemptsState));
  PetscFunctionReturn(PETSC_SUCCESS);
}
