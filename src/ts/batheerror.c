/* TSBATHE's error estimates, and the derivatives at stages from which they are computed; src/core/batheweights.c has
   the weights of the embedded estimate. */
#include <slipstep/private/sliploops.h>
#include <slipstep/private/slipts.h>

/* Limits of a stage's residual over its first residual: above the largest, sliding cells could be taken for resting
   ones; below the least, a solve is no cheaper than one to rounding */
static const PetscReal largest_share = 1e-2, least_share = 1e-9;

/* Computes k0 where no earlier step has: by RHSFunction, or as A^-1 (F_s + r0). An implicit form F(t, w, w') = 0 does
   not determine it. */
PetscErrorCode TSBatheStartDerivative(TS ts, PetscReal t, Vec w0, Vec r0, Vec k0, PetscBool *known)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  DM dm;
  TSIFunction ifunction;
  TSRHSFunction rhs;

  PetscFunctionBegin;
  *known = PETSC_TRUE;
  if (ba->con) {
    PetscCall((*ba->ops->smooth)(ba->con, t, w0, k0, ba->ctx));
    PetscCall((*ba->ops->add_reaction)(ba->con, 1.0, r0, k0, ba->ctx));
    PetscCall((*ba->ops->solve_mass)(ba->con, k0, k0, ba->ctx));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(TSGetDM(ts, &dm));
  PetscCall(DMTSGetIFunction(dm, &ifunction, NULL));
  PetscCall(DMTSGetRHSFunction(dm, &rhs, NULL));
  if (!ifunction && rhs)
    PetscCall(TSComputeRHSFunction(ts, t, w0, k0));
  else
    *known = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes k2 = (w2 - a1 w1 + a0 w0) / (b h) from stage 2, without a solve. */
PetscErrorCode TSBatheEndDerivative(TS ts, PetscReal h, Vec w0, Vec w1, Vec w2, Vec k2)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const SlipBathe c = ba->c;
  const PetscReal theta = c.theta[1] * h;

  PetscFunctionBegin;
  ba->k2_sides = PETSC_FALSE;
  PetscCall(VecCopy(w2, k2));
  PetscCall(VecAXPBYPCZ(k2, -c.a1 / theta, c.a0 / theta, 1.0 / theta, w1, w0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets e to 0 in the rate rows of cells that stick at the step's end. The constraint fixes their rate at exactly zero
   there, while the derivatives of a cell that has just stopped jump: for any length of the step the formula would give
   an error as large as the rate, and a controller would cut steps at every arrest. The rows that integrate the rate
   (displacement and slip) still have the error of the arrest. The derivative of a resting cell's rate is also zero. */
PetscErrorCode TSBatheDropSticking(TS ts, Vec w, Vec e)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscReal components;
  PetscInt n, c;

  PetscFunctionBegin;
  PetscCall((*ba->ops->reduce)(ba->con, w, ba->x, ba->ctx));
  PetscCall(SlipConstraintGetComponents(ba->con, &c));
  PetscCall(VecGetLocalSize(ba->x, &n));
  components = (PetscReal)c;
  /* a cell slides along both axes or rests along both; a closed cell may slide */
  PetscCall(SlipLoopRun(SLIP_LOOP_MARK_STICKING, n / c, &components, &ba->x, NULL));
  PetscCall(VecSet(ba->K1, 1.0)); /* r changes the rows that it enters: by a sum, or for a closed cell to 0 */
  PetscCall((*ba->ops->add_reaction)(ba->con, 1.0, ba->x, ba->K1, ba->ctx));
  PetscCall(VecGetLocalSize(e, &n));
  PetscCall(SlipLoopRun(SLIP_LOOP_DROP_UNMARKED, n, NULL, (const Vec[]){ba->K1, e}, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes e = w2 - w0 - h sum b^_i k_i from K0, K2 and the stages of the step. */
PetscErrorCode TSBatheEmbeddedError(TS ts, PetscReal h, Vec e)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const SlipBathe c = ba->c;
  const PetscBool trapezoidal = ba->first == TSBATHE_STAGE_TRAPEZOIDAL ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  /* stage 1: (w1 - w0) / (gamma h / 2) = k0 + k1 (+ A^-1 (r1 - r0) when the reaction is implicit), or k1 gamma h */
  PetscCall(VecWAXPY(ba->K1, -1.0, ba->X0, ba->Y[0]));
  PetscCall(VecScale(ba->K1, 1.0 / (c.theta[0] * h)));
  if (trapezoidal) PetscCall(VecAXPY(ba->K1, -1.0, ba->K0));
  PetscCall(VecZeroEntries(e));
  if (ba->con && trapezoidal && ba->reaction == TSBATHE_REACTION_IMPLICIT) {
    PetscCall((*ba->ops->add_reaction)(ba->con, 1.0, ba->r1, e, ba->ctx));
    PetscCall((*ba->ops->add_reaction)(ba->con, -1.0, ba->r0, e, ba->ctx));
    PetscCall((*ba->ops->solve_mass)(ba->con, e, e, ba->ctx));
    PetscCall(VecAXPY(ba->K1, -1.0, e));
    PetscCall(VecScale(e, h * c.weight[1]));
  }
  PetscCall(VecAXPY(e, h * c.error[0], ba->K0));
  PetscCall(VecAXPY(e, h * c.error[1], ba->K1));
  PetscCall(VecAXPY(e, h * c.error[2], ba->K2));
  if (ba->con) PetscCall(TSBatheDropSticking(ts, ba->Y[1], e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes e = (w_half - w_full) / (2^p - 1), with p = 2 for a smooth problem where doubling replaces the embedded
   estimate. */
PetscErrorCode TSBatheDoublingError(TS ts, Vec e)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscInt p = ba->error == TSBATHE_ERROR_DOUBLING ? ba->order : 2;

  PetscFunctionBegin;
  PetscCall(VecWAXPY(e, -1.0, ba->Wfull, ba->Y[1]));
  PetscCall(VecScale(e, 1.0 / (PetscPowRealInt(2.0, (int)p) - 1.0)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the problem's own norm of E, or else the norm weighted by the tolerances of the TS, relative to the larger
   of the two compared solutions. */
PetscErrorCode TSBatheErrorNorm(TS ts, NormType type, PetscReal *norm)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const SlipProblemOps *problem;
  void *ctx;

  PetscFunctionBegin;
  PetscCall(TSGetSlipProblem(ts, &problem, &ctx));
  if (problem && problem->error) {
    if (ba->last.method == TSBATHE_METHOD_EXPLICIT && ba->stabilised)
      PetscCall((*problem->side_error)(ts, ba->E, ba->X0, ba->Y[1], norm, ctx));
    else
      PetscCall((*problem->error)(ts, ba->E, ba->X0, ba->Y[1], norm, ctx));
    *norm = SlipBatheRoundError(*norm);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecWAXPY(ba->K1, -1.0, ba->E, ba->Y[1]));
  PetscCall(SlipVecWeightedNorm(ts, ba->Y[1], ba->K1, ts->adapt->ignore_max, type, norm));
  *norm = SlipBatheRoundError(*norm);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stores the local error of the rates over their change in the attempt, from which the next attempts compute how
   accurately they solve stages. */
PetscErrorCode TSBatheKeepErrorShare(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscReal error, change;

  PetscFunctionBegin;
  ba->error_share = 0;
  if (!ba->con || ba->last.error < 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (ba->stabilised && ba->last.method == TSBATHE_METHOD_EXPLICIT) /* it has no separate error of the rates */
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall((*ba->ops->reduce)(ba->con, ba->E, ba->x, ba->ctx));
  PetscCall(VecNorm(ba->x, NORM_2, &error));
  PetscCall(VecWAXPY(ba->K1, -1.0, ba->X0, ba->Y[1]));
  PetscCall((*ba->ops->reduce)(ba->con, ba->K1, ba->x, ba->ctx));
  PetscCall(VecNorm(ba->x, NORM_2, &change));
  if (change > 0) ba->error_share = SlipBatheRoundError(error / change);
  ba->error_dt = ba->last.dt;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the residual to which a stage is solved, over its first residual. As the first residual is that of the change
   of the rates, this is an error of the rates over their change. The local error of a step is proportional to h^3 and
   the change to h; for a longer step the error is not assumed to be larger. */
PetscReal TSBatheStageShare(TS ts, PetscReal h)
{
  const TS_Bathe *ba = (const TS_Bathe *)ts->data;
  const PetscReal shorter = ba->error_dt > 0 ? PetscMin(1, h / ba->error_dt) : 1;
  const PetscReal share = ba->stage_error * ba->error_share * PetscSqr(shorter);

  if (ba->error == TSBATHE_ERROR_DOUBLING) return 0;
  if (ba->first == TSBATHE_STAGE_TRAPEZOIDAL && ba->reaction == TSBATHE_REACTION_IMPLICIT) return 0;
  return share > least_share ? PetscMin(share, largest_share) : 0;
}
