/* TSADAPTLAPUSTA takes the shortest steps while any cell slides. */
#include <slipstep/private/slipadapt.h>
#include <slipstep/rooms/slipts.h>

#define GROWTH 2       /* largest ratio of successive steps */
#define TOO_LONG 4     /* ratio to the longest allowed step at its end above which a step is rejected */
#define LEAST_CUT 1e-3 /* smallest factor on a rejected step */

static PetscErrorCode TSAdaptChoose_Lapusta(TSAdapt adapt, TS ts, PetscReal h, PetscInt *next_sc, PetscReal *next_h,
                                            PetscBool *accept, PetscReal *wlte, PetscReal *wltea, PetscReal *wlter)
{
  const SlipProblemOps *problem;
  PetscReal longest, next;
  PetscBool lapusta;
  void *ctx;

  PetscFunctionBegin;
  PetscCall(TSGetSlipProblem(ts, &problem, &ctx));
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSLAPUSTA, &lapusta));
  PetscCheck(
    lapusta && problem && problem->control.slip_step, PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_WRONGSTATE,
    "-ts_adapt_type " TSADAPTLAPUSTA " bounds the slip of cells in steps of constant rates: expected a fault whose "
    "friction sticks, and -ts_type " TSLAPUSTA);
  PetscCall((*problem->control.slip_step)(ts, ts->ptime + h, ts->vec_sol, &longest, ctx));
  *next_sc = 0;
  *wlte = *wltea = *wlter = -1;
  *accept = h <= TOO_LONG * longest || h <= adapt->dt_min || adapt->always_accept ? PETSC_TRUE : PETSC_FALSE;
  next = *accept ? PetscMin(GROWTH * h, longest) : PetscMax(LEAST_CUT * h, longest);
  *next_h = PetscClipInterval(next, adapt->dt_min, adapt->dt_max);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  TSADAPTLAPUSTA - takes the shortest steps while any cell of a fault slides, and grows them while all rest

  Level: beginner

  Notes:
  It is for friction that sticks, which has no rate to limit a step, with -ts_type lapusta, which supplies the shortest
  step. The error is not estimated. Of friction that always slides TSADAPTDSP is more accurate for as many products than
  the rule of Lapusta et al. (2000), which bounds the slip of a step by a share of d_c.

  Reference: Lapusta, Rice, Ben-Zion & Zheng (2000)

.seealso: TSLAPUSTA, SLIPELASTICWAVES
M*/
PetscErrorCode TSAdaptCreate_Lapusta(TSAdapt adapt)
{
  PetscFunctionBegin;
  adapt->ops->choose = TSAdaptChoose_Lapusta;
  PetscFunctionReturn(PETSC_SUCCESS);
}
