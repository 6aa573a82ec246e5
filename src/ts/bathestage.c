/* TSBATHE's two stages: the trapezoidal rule to t + gamma h, then the three-point backward formula to t + h. */
#include <slipstep/private/slipts.h>
#include <petsc/private/snesimpl.h>

/* Computes dw/dt = (x - base) / theta of a stage's iterate. The TS gets the DM of the solver meanwhile, because
   functions of the user may call TSGetDM(). */
static PetscErrorCode TSBatheBeginEvaluation(TS ts, SNES snes, Vec x, DM *save)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  *save = ts->dm;
  PetscCall(VecWAXPY(ba->Xdot, -1.0, ba->base, x));
  PetscCall(VecScale(ba->Xdot, 1.0 / ba->theta));
  PetscCall(SNESGetDM(snes, &ts->dm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes F(x) of a stage without constraint: IFunction(stage_time, x, (x - base) / theta). */
PetscErrorCode SNESTSFormFunction_Bathe(SNES snes, Vec x, Vec y, TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  DM save;

  PetscFunctionBegin;
  PetscCall(TSBatheBeginEvaluation(ts, snes, x, &save));
  PetscCall(TSComputeIFunction(ts, ba->stage_time, x, ba->Xdot, y, PETSC_FALSE));
  ts->dm = save;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SNESTSFormJacobian_Bathe(SNES snes, Vec x, Mat A, Mat P, TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  DM save;

  PetscFunctionBegin;
  PetscCall(TSBatheBeginEvaluation(ts, snes, x, &save));
  PetscCall(TSComputeIJacobian(ts, ba->stage_time, x, ba->Xdot, 1.0 / ba->theta, A, P, PETSC_FALSE));
  ts->dm = save;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts a solve and checks whether it converged. */
static PetscErrorCode TSBatheAfterSolve(TS ts, PetscInt stage, Vec w, PetscReal resnorm, PetscReal *worst,
                                        PetscBool *ok)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscInt nits, lits;
  SNESConvergedReason reason;

  PetscFunctionBegin;
  PetscCall(SNESGetIterationNumber(ts->snes, &nits));
  PetscCall(SNESGetLinearSolveIterations(ts->snes, &lits));
  PetscCall(SNESGetConvergedReason(ts->snes, &reason));
  ts->snes_its += nits;
  ts->ksp_its += lits;
  ba->last.newton += nits;
  ba->last.linear += lits;
  ba->last.reason = (PetscInt)reason;
  *worst = PetscMax(*worst, resnorm);
  PetscCall(TSPostStage(ts, ba->stage_time, stage, ba->Y));
  PetscCall(TSAdaptCheckStage(ts->adapt, ts, ba->stage_time, w, ok));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves one stage of a problem without constraint; rhs is NULL or the negative of the explicit part. */
static PetscErrorCode TSBatheSolveSmooth(TS ts, Vec rhs, Vec w, PetscReal *resnorm)
{
  PetscReal norm;

  PetscFunctionBegin;
  PetscCall(SNESSolve(ts->snes, rhs, w));
  PetscCall(SNESGetFunctionNorm(ts->snes, &norm));
  /* ttol = rtol * (norm of the first residual), so that this is the relative residual */
  *resnorm = ts->snes->ttol > 0.0 ? norm * ts->snes->rtol / ts->snes->ttol : norm;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves one stage of a problem with a constraint, from the guess in w; base is w0, or a1 w1 - a0 w0. */
static PetscErrorCode TSBatheSolveConstrained(TS ts, PetscReal omega, Vec explicit_part, Vec w0, Vec w1, Vec w, Vec r,
                                              PetscReal share, PetscReal *resnorm)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  SlipStage stage = {.t = ba->stage_time,
                     .theta = ba->theta,
                     .omega = omega,
                     .base = ba->base,
                     .explicit_part = explicit_part,
                     .from = {w0, w1},
                     .factor = {w1 ? -ba->c.a0 : 1, ba->c.a1},
                     .nfrom = w1 ? 2 : 1,
                     .share = share};

  PetscFunctionBegin;
  PetscCall((*ba->ops->reduce)(ba->con, w, ba->x, ba->ctx));
  PetscCall(SNESSlipSolveStage(ts->snes, &stage, ba->x, r, resnorm));
  PetscCall((*ba->ops->lift)(ba->con, ba->x, w, ba->ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves stage 1 from w0, also its guess; without constraint the right-hand side has -IFunction(t, w0, 0). */
static PetscErrorCode TSBatheStageOne(TS ts, PetscReal t, Vec w0, Vec r0, Vec w1, PetscReal share, PetscReal *resnorm)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  PetscCall(VecCopy(w0, ba->base));
  PetscCall(VecCopy(w0, w1));
  if (ba->first == TSBATHE_STAGE_BACKWARD) {
    if (ba->con)
      PetscCall(TSBatheSolveConstrained(ts, 1.0, NULL, w0, NULL, w1, ba->r1, share, resnorm));
    else
      PetscCall(TSBatheSolveSmooth(ts, NULL, w1, resnorm));
  } else if (ba->con) {
    PetscBool trapezoidal = ba->reaction == TSBATHE_REACTION_TRAPEZOIDAL ? PETSC_TRUE : PETSC_FALSE;

    PetscCall((*ba->ops->smooth)(ba->con, t, w0, ba->Fs, ba->ctx));
    if (trapezoidal) PetscCall((*ba->ops->add_reaction)(ba->con, 1.0, r0, ba->Fs, ba->ctx));
    PetscCall(TSBatheSolveConstrained(ts, trapezoidal ? 1.0 : 2.0, ba->Fs, w0, NULL, w1, ba->r1, share, resnorm));
  } else {
    PetscCall(VecZeroEntries(ba->Xdot));
    PetscCall(TSComputeIFunction(ts, t, w0, ba->Xdot, ba->affine, PETSC_FALSE));
    PetscCall(VecScale(ba->affine, -1.0));
    PetscCall(TSBatheSolveSmooth(ts, ba->affine, w1, resnorm));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TSBatheSubstep(TS ts, PetscReal t, PetscReal h, Vec w0, Vec r0, Vec w1, Vec w2, Vec r2,
                              PetscReal *resnorm, PetscBool *ok)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const SlipBathe c = ba->c;
  const PetscReal share = TSBatheStageShare(ts, h);
  PetscReal res = 0.0;

  PetscFunctionBegin;
  *resnorm = 0.0;
  ba->last.solves++;

  ba->stage_time = t + c.gamma * h;
  ba->theta = c.theta[0] * h;
  PetscCall(TSPreStage(ts, ba->stage_time));
  PetscCall(TSBatheStageOne(ts, t, w0, r0, w1, share, &res));
  PetscCall(TSBatheAfterSolve(ts, 0, w1, res, resnorm, ok));
  if (!*ok) PetscFunctionReturn(PETSC_SUCCESS);

  ba->stage_time = t + h;
  ba->theta = c.theta[1] * h;
  PetscCall(VecAXPBYPCZ(ba->base, c.a1, -c.a0, 0.0, w1, w0));
  PetscCall(VecCopy(w1, w2));
  PetscCall(TSPreStage(ts, ba->stage_time));
  if (ba->con)
    PetscCall(TSBatheSolveConstrained(ts, 1.0, NULL, w0, w1, w2, r2, share, &res));
  else
    PetscCall(TSBatheSolveSmooth(ts, NULL, w2, &res));
  PetscCall(TSBatheAfterSolve(ts, 1, w2, res, resnorm, ok));
  PetscFunctionReturn(PETSC_SUCCESS);
}
