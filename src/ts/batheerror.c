/* Error estimates of TSBATHE: rows that have none, and norms */
#include <slipstep/private/slipbathe.h>
#include <slipstep/private/sliploops.h>

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

/* Computes the problem's own norm of E, or else the norm weighted by the tolerances of the TS, relative to the larger
   of the two compared solutions. */
PetscErrorCode TSBatheErrorNorm(TS ts, NormType type, PetscReal *norm)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const SlipProblemOps *problem;
  void *ctx;

  PetscFunctionBegin;
  PetscCall(TSGetSlipProblem(ts, &problem, &ctx));
  if (problem && problem->steps.error) {
    if (ba->was->norm)
      PetscCall((*ba->was->norm)(ts, norm));
    else
      PetscCall((*problem->steps.error)(ts, ba->estimate.E, ba->X0, ba->Y[1], norm, ctx));
  } else {
    PetscCall(VecWAXPY(ba->K1, -1.0, ba->estimate.E, ba->Y[1]));
    PetscCall(SlipVecWeightedNorm(ts, ba->Y[1], ba->K1, ts->adapt->ignore_max, type, norm));
  }
  PetscCall(SlipHistoryError(ts, ba->Y[1], norm, NULL));
  *norm = SlipBatheRoundError(*norm);
  PetscFunctionReturn(PETSC_SUCCESS);
}
