/* TSBATHE's implicit method: the trapezoidal rule to t + gamma h, then the three-point backward formula to t + h, the
   derivatives at both ends and the embedded estimate of the error; src/core/batheweights.c has its weights. */
#include <slipstep/private/slipbathe.h>
#include <petsc/private/snesimpl.h>

/* Limits of a stage's residual over its first residual: above the largest, sliding cells could be taken for resting
   ones; below the least, a solve is no cheaper than one to rounding */
static const PetscReal largest_share = 1e-2, least_share = 1e-9;

/* Computes dw/dt = (x - base) / theta of a stage's iterate. The TS gets the DM of the solver meanwhile, because
   functions of the user may call TSGetDM(). */
static PetscErrorCode TSBatheBeginEvaluation(TS ts, SNES snes, Vec x, DM *save)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  *save = ts->dm;
  PetscCall(VecWAXPY(ba->stages.Xdot, -1.0, ba->stages.base, x));
  PetscCall(VecScale(ba->stages.Xdot, 1.0 / ba->stages.theta));
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
  PetscCall(TSComputeIFunction(ts, ba->stages.time, x, ba->stages.Xdot, y, PETSC_FALSE));
  ts->dm = save;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SNESTSFormJacobian_Bathe(SNES snes, Vec x, Mat A, Mat P, TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  DM save;

  PetscFunctionBegin;
  PetscCall(TSBatheBeginEvaluation(ts, snes, x, &save));
  PetscCall(TSComputeIJacobian(ts, ba->stages.time, x, ba->stages.Xdot, 1.0 / ba->stages.theta, A, P, PETSC_FALSE));
  ts->dm = save;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the start of a step ---- */

PetscErrorCode TSBatheStartReaction(TS ts, PetscBool unchanged)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  if (!ba->con) PetscFunctionReturn(PETSC_SUCCESS);
  /* Stage 2's reaction of a cell that has just stopped contains the impulse that stopped it. In the next trapezoidal
     stage it would push the cell off again; resting cells therefore start with the reaction of static balance. */
  if (!ba->r_given && (!unchanged || ba->stages.first == TSBATHE_STAGE_TRAPEZOIDAL))
    PetscCall(SlipConstraintInitialReaction(ba->con, ts->ptime, ts->vec_sol, ba->r));
  ba->r_given = PETSC_FALSE;
  PetscCall(VecCopy(ba->r, ba->r0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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

static PetscErrorCode TSBatheImplicitBegin(TS ts, PetscBool unchanged)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  PetscCall(TSBatheStartReaction(ts, unchanged));
  ba->stabilised.k0_sides = PETSC_FALSE;
  if (ba->estimate.type != TSBATHE_ERROR_EMBEDDED) PetscFunctionReturn(PETSC_SUCCESS);
  if (unchanged && ba->k2_known && !ba->stabilised.k2_sides) {
    PetscCall(VecCopy(ba->K2, ba->K0));
    if (ba->con) PetscCall(TSBatheDropSticking(ts, ba->X0, ba->K0));
    ba->k0_known = PETSC_TRUE;
  } else
    PetscCall(TSBatheStartDerivative(ts, ts->ptime, ba->X0, ba->r0, ba->K0, &ba->k0_known));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Replaces K0 of an explicit attempt at the same step. */
static PetscErrorCode TSBatheImplicitStart(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  if (!ba->stabilised.k0_sides) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSBatheStartDerivative(ts, ts->ptime, ba->X0, ba->r0, ba->K0, &ba->k0_known));
  ba->stabilised.k0_sides = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- two stages ---- */

/* Solves a stage from the guess in w, counts the solve, and checks whether it converged. explicit_part: NULL, or
   its negative without a constraint; share: the residual to which it is solved; w1: NULL in stage 1 */
static PetscErrorCode TSBatheSolveStage(TS ts, PetscInt stage, PetscReal omega, Vec explicit_part, Vec w0, Vec w1,
                                        Vec w, Vec r, PetscReal share, PetscReal *worst, PetscBool *ok)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const SlipStage problem = {.t = ba->stages.time,
                             .theta = ba->stages.theta,
                             .omega = omega,
                             .base = ba->stages.base, /* w0, or a1 w1 - a0 w0 */
                             .explicit_part = explicit_part,
                             .from = {w0, w1},
                             .factor = {w1 ? -ba->stages.c.a0 : 1, ba->stages.c.a1},
                             .nfrom = w1 ? 2 : 1,
                             .share = share};
  PetscInt nits, lits;
  SNESConvergedReason reason;
  PetscReal norm;

  PetscFunctionBegin;
  if (ba->con) {
    PetscCall((*ba->ops->reduce)(ba->con, w, ba->x, ba->ctx));
    PetscCall(SNESSlipSolveStage(ts->snes, &problem, ba->x, r, &norm));
    PetscCall((*ba->ops->lift)(ba->con, ba->x, w, ba->ctx));
  } else {
    PetscCall(SNESSolve(ts->snes, explicit_part, w));
    PetscCall(SNESGetFunctionNorm(ts->snes, &norm));
    /* ttol = rtol * (norm of the first residual), so that this is the relative residual */
    if (ts->snes->ttol > 0.0) norm = norm * ts->snes->rtol / ts->snes->ttol;
  }
  PetscCall(SNESGetIterationNumber(ts->snes, &nits));
  PetscCall(SNESGetLinearSolveIterations(ts->snes, &lits));
  PetscCall(SNESGetConvergedReason(ts->snes, &reason));
  ts->snes_its += nits;
  ts->ksp_its += lits;
  ba->last.newton += nits;
  ba->last.linear += lits;
  ba->last.reason = (PetscInt)reason;
  *worst = PetscMax(*worst, norm);
  PetscCall(TSPostStage(ts, ba->stages.time, stage, ba->Y));
  PetscCall(TSAdaptCheckStage(ts->adapt, ts, ba->stages.time, w, ok));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the residual to which a stage is solved, over its first residual. As the first residual is that of the change
   of the rates, this is an error of the rates over their change. The local error of a step is proportional to h^3 and
   the change to h; for a longer step the error is not assumed to be larger. */
static PetscReal TSBatheStageShare(const TS_Bathe *ba, PetscReal h)
{
  const PetscReal shorter = ba->stages.error_dt > 0 ? PetscMin(1, h / ba->stages.error_dt) : 1;
  const PetscReal share = ba->stages.allowed * ba->stages.error_share * PetscSqr(shorter);

  if (ba->estimate.type == TSBATHE_ERROR_DOUBLING) return 0;
  if (ba->stages.first == TSBATHE_STAGE_TRAPEZOIDAL && ba->stages.reaction == TSBATHE_REACTION_IMPLICIT) return 0;
  return share > least_share ? PetscMin(share, largest_share) : 0;
}

static PetscErrorCode TSBatheImplicitSubstep(TS ts, PetscReal t, PetscReal h, Vec w0, Vec r0, Vec w1, Vec w2, Vec r2,
                                             PetscReal *residual, PetscBool *ok)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  TSBatheStages *st = &ba->stages;
  const SlipBathe c = st->c;
  const PetscReal share = TSBatheStageShare(ba, h);
  const PetscBool trapezoidal = st->first == TSBATHE_STAGE_TRAPEZOIDAL ? PETSC_TRUE : PETSC_FALSE;
  const PetscBool mean = st->reaction == TSBATHE_REACTION_TRAPEZOIDAL ? PETSC_TRUE : PETSC_FALSE;
  Vec explicit_part = NULL;

  PetscFunctionBegin;
  st->time = t + c.gamma * h;
  st->theta = c.theta[0] * h;
  PetscCall(TSPreStage(ts, st->time));
  PetscCall(VecCopy(w0, st->base));
  PetscCall(VecCopy(w0, w1));
  if (trapezoidal && ba->con) {
    explicit_part = st->Fs;
    PetscCall((*ba->ops->smooth)(ba->con, t, w0, st->Fs, ba->ctx));
    if (mean) PetscCall((*ba->ops->add_reaction)(ba->con, 1.0, r0, st->Fs, ba->ctx));
  } else if (trapezoidal) { /* -IFunction(t, w0, 0) */
    explicit_part = st->affine;
    PetscCall(VecZeroEntries(st->Xdot));
    PetscCall(TSComputeIFunction(ts, t, w0, st->Xdot, st->affine, PETSC_FALSE));
    PetscCall(VecScale(st->affine, -1.0));
  }
  PetscCall(TSBatheSolveStage(ts, 0, trapezoidal && !mean ? 2.0 : 1.0, explicit_part, w0, NULL, w1, st->r1, share,
                              residual, ok));
  if (!*ok) PetscFunctionReturn(PETSC_SUCCESS);

  st->time = t + h;
  st->theta = c.theta[1] * h;
  PetscCall(VecAXPBYPCZ(st->base, c.a1, -c.a0, 0.0, w1, w0));
  PetscCall(VecCopy(w1, w2));
  PetscCall(TSPreStage(ts, st->time));
  PetscCall(TSBatheSolveStage(ts, 1, 1.0, NULL, w0, w1, w2, r2, share, residual, ok));
  ba->share = c.gamma;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes K2 = (w2 - a1 w1 + a0 w0) / (b h) from stage 2, without a solve. */
static PetscErrorCode TSBatheImplicitEnd(TS ts, PetscReal h, Vec w0, Vec w1, Vec w2)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const SlipBathe c = ba->stages.c;
  const PetscReal theta = c.theta[1] * h;

  PetscFunctionBegin;
  PetscCall(VecCopy(w2, ba->K2));
  PetscCall(VecAXPBYPCZ(ba->K2, -c.a1 / theta, c.a0 / theta, 1.0 / theta, w1, w0));
  ba->stabilised.k2_sides = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the error ---- */

/* Computes e = w2 - w0 - h sum b^_i k_i from K0, K2 and the stages of the step. */
static PetscErrorCode TSBatheImplicitError(TS ts, PetscReal h, Vec e)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const SlipBathe c = ba->stages.c;
  const PetscBool trapezoidal = ba->stages.first == TSBATHE_STAGE_TRAPEZOIDAL ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  /* stage 1: (w1 - w0) / (gamma h / 2) = k0 + k1 (+ A^-1 (r1 - r0) when the reaction is implicit), or k1 gamma h */
  PetscCall(VecWAXPY(ba->K1, -1.0, ba->X0, ba->Y[0]));
  PetscCall(VecScale(ba->K1, 1.0 / (c.theta[0] * h)));
  if (trapezoidal) PetscCall(VecAXPY(ba->K1, -1.0, ba->K0));
  PetscCall(VecZeroEntries(e));
  if (ba->con && trapezoidal && ba->stages.reaction == TSBATHE_REACTION_IMPLICIT) {
    PetscCall((*ba->ops->add_reaction)(ba->con, 1.0, ba->stages.r1, e, ba->ctx));
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

/* Stores the local error of the rates over their change in the attempt, from which the next attempts compute how
   accurately they solve stages. */
PetscErrorCode TSBatheKeepErrorShare(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscReal error, change;

  PetscFunctionBegin;
  ba->stages.error_share = 0;
  if (!ba->con || ba->last.error < 0 || ba->was->norm) /* which has no separate error of the rates */
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall((*ba->ops->reduce)(ba->con, ba->estimate.E, ba->x, ba->ctx));
  PetscCall(VecNorm(ba->x, NORM_2, &error));
  PetscCall(VecWAXPY(ba->K1, -1.0, ba->X0, ba->Y[1]));
  PetscCall((*ba->ops->reduce)(ba->con, ba->K1, ba->x, ba->ctx));
  PetscCall(VecNorm(ba->x, NORM_2, &change));
  if (change > 0) ba->stages.error_share = SlipBatheRoundError(error / change);
  ba->stages.error_dt = ba->last.dt;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void TSBatheImplicitWeights(const TS_Bathe *ba, PetscReal weight[3])
{
  for (int k = 0; k < 3; k++) weight[k] = ba->stages.c.weight[k];
}

const TSBatheMethodOps TSBatheImplicit = {.method = TSBATHE_METHOD_IMPLICIT,
                                          .begin = TSBatheImplicitBegin,
                                          .start = TSBatheImplicitStart,
                                          .substep = TSBatheImplicitSubstep,
                                          .end = TSBatheImplicitEnd,
                                          .error = TSBatheImplicitError,
                                          .weights = TSBatheImplicitWeights};
