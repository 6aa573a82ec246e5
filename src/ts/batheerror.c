/* TSBATHE's error estimates and the stage derivatives that they are made of; the embedded one's weights are in
   src/core/batheweights.c. */
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipts.h>

/* Shares of its first residual that a stage may leave: more lets sliding cells be taken for resting ones, less is no
   cheaper than all that the solver can do */
static const PetscReal largest_share = 1e-2, least_share = 1e-9;

/* k0 where no step has left it: RHSFunction, or A^-1 (F_s + r0). An implicit form F(t, w, w') = 0 does not give it
   away. */
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

/* k2 = (w2 - a1 w1 + a0 w0) / (b h), from stage 2 without a solve */
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

/* What follows, of cells with one component, whose rates are in ba->x */
static PetscErrorCode DropStickingOnDevice(TS_Bathe *ba, PetscInt n, Vec e)
{
  const PetscScalar *mark;
  PetscScalar *x, *ee;
  PetscInt size;
  const SlipArrays cells[] = {{ba->x, .write = &x}}, rows[] = {{ba->K1, .read = &mark}, {e, .write = &ee}};

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(e, &size));
  PetscCall(SlipDeviceArraysRun(KERNEL_STAGE_STICKING, n, 0, NULL, 1, cells, 0, 0, NULL));
  PetscCall(VecSet(ba->K1, 1.0));
  PetscCall((*ba->ops->add_reaction)(ba->con, 1.0, ba->x, ba->K1, ba->ctx));
  PetscCall(SlipDeviceArraysRun(KERNEL_STAGE_DROP, size, 0, NULL, 2, rows, 0, 0, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Zero e in the rows of cells that stick at the step's end. The constraint fixes their rate at exactly zero there,
   while the derivatives of a cell that has just stopped jump: the formula would give an error of the order of the
   rate itself however short the step, and a controller would chase it at every arrest. What the arrest does to the
   accuracy still shows in the rows that integrate the rate (displacement and slip). The derivative of the rate of a
   resting cell is zero likewise. */
PetscErrorCode TSBatheDropSticking(TS ts, Vec w, Vec e)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscInt n, c;
  PetscScalar *x, *ee;
  const PetscScalar *mark;

  PetscFunctionBegin;
  PetscCall((*ba->ops->reduce)(ba->con, w, ba->x, ba->ctx));
  PetscCall(SlipConstraintGetComponents(ba->con, &c));
  PetscCall(VecGetLocalSize(ba->x, &n));
  if (c == 1 && SlipDeviceVecIs(ba->x) && SlipDeviceVecIs(e)) {
    PetscCall(DropStickingOnDevice(ba, n, e));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecGetArray(ba->x, &x));
  for (PetscInt i = 0; i < n; i += c) { /* a cell that slides along one axis does not rest along the other */
    const PetscInt plane = PetscMin(c, 2);
    PetscBool sticks = PETSC_TRUE;

    for (PetscInt k = i; k < i + plane; k++)
      if (x[k] != 0.0) sticks = PETSC_FALSE;
    for (PetscInt k = i; k < i + plane; k++) x[k] = sticks ? 1.0 : 0.0;
    for (PetscInt k = i + plane; k < i + c; k++) x[k] = x[k] == 0.0 ? 1.0 : 0.0; /* closed, whether it slides or not */
  }
  PetscCall(VecRestoreArray(ba->x, &x));
  PetscCall(VecSet(ba->K1, 1.0)); /* which changes where r enters, by a sum or, of a cell that is closed, to 0 */
  PetscCall((*ba->ops->add_reaction)(ba->con, 1.0, ba->x, ba->K1, ba->ctx)); /* the rows that r enters */
  PetscCall(VecGetLocalSize(e, &n));
  PetscCall(VecGetArrayRead(ba->K1, &mark));
  PetscCall(VecGetArray(e, &ee));
  for (PetscInt i = 0; i < n; i++)
    if (mark[i] != 1.0) ee[i] = 0.0;
  PetscCall(VecRestoreArray(e, &ee));
  PetscCall(VecRestoreArrayRead(ba->K1, &mark));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* e = w2 - w0 - h sum b^_i k_i; needs K0, K2 and the stages of the step */
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

/* e = (w_half - w_full) / (2^p - 1); a smooth problem's own order is 2 when doubling stands in for the embedded
   estimate */
PetscErrorCode TSBatheDoublingError(TS ts, Vec e)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscInt p = ba->error == TSBATHE_ERROR_DOUBLING ? ba->order : 2;

  PetscFunctionBegin;
  PetscCall(VecWAXPY(e, -1.0, ba->Wfull, ba->Y[1]));
  PetscCall(VecScale(e, 1.0 / (PetscPowRealInt(2.0, (int)p) - 1.0)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TSErrorWeightedNorm() on the device */
static PetscErrorCode WeightedNormOnDevice(TS ts, Vec y, Vec z, NormType type, PetscReal *norm)
{
  const PetscReal numbers[] = {ts->atol, ts->rtol, (ts->vatol ? 1 : 0) + (ts->vrtol ? 1 : 0)};
  const PetscReal *unused;
  PetscReal result[3];
  PetscInt n;
  const SlipArrays arrays[] = {
    {y, .read = &unused}, {z, .read = &unused}, {ts->vatol, .read = &unused}, {ts->vrtol, .read = &unused}};

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(y, &n));
  PetscCall(SlipDeviceArraysRun(KERNEL_WEIGHTED_NORM, n, 3, numbers, 4, arrays, 3, 2, result));
  PetscCheck(!PetscIsInfOrNanReal(result[0]), PetscObjectComm((PetscObject)ts), PETSC_ERR_FP,
             "Infinite or not-a-number generated in norm");
  *norm = type == NORM_INFINITY ? result[2] : PetscSqrtReal(result[0] / PetscMax(result[1], 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The problem's norm of E, or the weighted one with the tolerances of the TS, relative to the larger of the two
   solutions compared */
PetscErrorCode TSBatheErrorNorm(TS ts, NormType type, PetscReal *norm)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const SlipProblemOps *problem;
  void *ctx;
  PetscReal enorma, enormr;

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
  if (SlipDeviceVecIs(ba->Y[1]) && SlipDeviceVecIs(ba->K1) && !ts->vrtol && ts->adapt->ignore_max < 0 &&
      (!ts->vatol || SlipDeviceVecIs(ts->vatol)))
    PetscCall(WeightedNormOnDevice(ts, ba->Y[1], ba->K1, type, norm));
  else
    PetscCall(TSErrorWeightedNorm(ts, ba->Y[1], ba->K1, type, norm, &enorma, &enormr));
  *norm = SlipBatheRoundError(*norm);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The local error of the rates over their change within the attempt, from which the next ones tell how exactly stages
   have to be solved */
PetscErrorCode TSBatheKeepErrorShare(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscReal error, change;

  PetscFunctionBegin;
  ba->error_share = 0;
  if (!ba->con || ba->last.error < 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (ba->stabilised && ba->last.method == TSBATHE_METHOD_EXPLICIT) /* which has no error of rates of their own */
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

/* The first residual of a stage is that of its rates' change, so that what is left of it is an error of the rates over
   their change. The local error of a step goes with h^3, the change with h; of a longer step it is not trusted to have
   grown. */
PetscReal TSBatheStageShare(TS ts, PetscReal h)
{
  const TS_Bathe *ba = (const TS_Bathe *)ts->data;
  const PetscReal shorter = ba->error_dt > 0 ? PetscMin(1, h / ba->error_dt) : 1;
  const PetscReal share = ba->stage_error * ba->error_share * PetscSqr(shorter);

  if (ba->error == TSBATHE_ERROR_DOUBLING) return 0;
  if (ba->first == TSBATHE_STAGE_TRAPEZOIDAL && ba->reaction == TSBATHE_REACTION_IMPLICIT) return 0;
  return share > least_share ? PetscMin(share, largest_share) : 0;
}
