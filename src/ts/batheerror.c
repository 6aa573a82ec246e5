/* Error estimates of TSBATHE: rows that have none, and norms */
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipbathe.h>

/* The next function on a device, for cells with one component, whose rates are in ba->x. */
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

/* Sets e to 0 in the rate rows of cells that stick at the step's end. The constraint fixes their rate at exactly zero
   there, while the derivatives of a cell that has just stopped jump: for any length of the step the formula would give
   an error as large as the rate, and a controller would cut steps at every arrest. The rows that integrate the rate
   (displacement and slip) still have the error of the arrest. The derivative of a resting cell's rate is also zero. */
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
  for (PetscInt i = 0; i < n; i += c) { /* a cell slides along both axes or rests along both */
    const PetscInt plane = PetscMin(c, 2);
    PetscBool sticks = PETSC_TRUE;

    for (PetscInt k = i; k < i + plane; k++)
      if (x[k] != 0.0) sticks = PETSC_FALSE;
    for (PetscInt k = i; k < i + plane; k++) x[k] = sticks ? 1.0 : 0.0;
    for (PetscInt k = i + plane; k < i + c; k++) x[k] = x[k] == 0.0 ? 1.0 : 0.0; /* a closed cell, sliding or not */
  }
  PetscCall(VecRestoreArray(ba->x, &x));
  PetscCall(VecSet(ba->K1, 1.0)); /* r changes the rows that it enters: by a sum, or for a closed cell to 0 */
  PetscCall((*ba->ops->add_reaction)(ba->con, 1.0, ba->x, ba->K1, ba->ctx));
  PetscCall(VecGetLocalSize(e, &n));
  PetscCall(VecGetArrayRead(ba->K1, &mark));
  PetscCall(VecGetArray(e, &ee));
  for (PetscInt i = 0; i < n; i++)
    if (mark[i] != 1.0) ee[i] = 0.0;
  PetscCall(VecRestoreArray(e, &ee));
  PetscCall(VecRestoreArrayRead(ba->K1, &mark));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes TSErrorWeightedNorm() on the device. */
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

/* Computes the problem's own norm of E, or else the norm weighted by the tolerances of the TS, relative to the larger
   of the two compared solutions. */
PetscErrorCode TSBatheErrorNorm(TS ts, NormType type, PetscReal *norm)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const SlipProblemOps *problem;
  void *ctx;
  PetscReal enorma, enormr;

  PetscFunctionBegin;
  PetscCall(TSGetSlipProblem(ts, &problem, &ctx));
  if (problem && problem->steps.error) {
    if (ba->was->norm)
      PetscCall((*ba->was->norm)(ts, norm));
    else
      PetscCall((*problem->steps.error)(ts, ba->estimate.E, ba->X0, ba->Y[1], norm, ctx));
    *norm = SlipBatheRoundError(*norm);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecWAXPY(ba->K1, -1.0, ba->estimate.E, ba->Y[1]));
  if (SlipDeviceVecIs(ba->Y[1]) && SlipDeviceVecIs(ba->K1) && !ts->vrtol && ts->adapt->ignore_max < 0 &&
      (!ts->vatol || SlipDeviceVecIs(ts->vatol)))
    PetscCall(WeightedNormOnDevice(ts, ba->Y[1], ba->K1, type, norm));
  else
    PetscCall(TSErrorWeightedNorm(ts, ba->Y[1], ba->K1, type, norm, &enorma, &enormr));
  *norm = SlipBatheRoundError(*norm);
  PetscFunctionReturn(PETSC_SUCCESS);
}
