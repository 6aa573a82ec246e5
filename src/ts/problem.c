/* The table of operations, composed with a TS, through which controllers and integrators use the problem of the TS. */
#include <slipstep/private/slipts.h>
#include <petsc/private/petscimpl.h>
#include <slipstep/private/slipsys.h>

typedef struct {
  const SlipProblemOps *ops;
  void *ctx;
} Problem;

/*@C
  TSSetSlipProblem - sets the operations through which controllers and integrators use the problem of a TS

  Logically collective

  Input Parameters:
+ ts      - the TS
. problem - its operations, borrowed: they must exist as long as ts; NULL: it has none
- ctx     - the last argument of each operation, borrowed

  Level: developer

  Note:
  The operations are structs, one for each of those who ask: control for controllers, steps for integrators, drifts for
  TSLAPUSTA, sides for explicit steps of TSBATHE, history, and observations. A problem fills those that it has.

.seealso: TSGetSlipProblem(), SlipObservationView(), TSADAPTRL
@*/
PetscErrorCode TSSetSlipProblem(TS ts, const SlipProblemOps *problem, void *ctx)
{
  Problem *p;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscCall(PetscNew(&p));
  *p = (Problem){.ops = problem, .ctx = ctx};
  PetscCall(SlipObjectComposeData((PetscObject)ts, "SlipProblem", p, SlipContainerDestroyDefault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  TSGetSlipProblem - gets the operations through which controllers and integrators use the problem of a TS

  Not collective

  Input Parameter:
. ts - the TS

  Output Parameters:
+ problem - its operations, borrowed; `NULL` when there are none
- ctx     - address of a pointer that receives their last argument; `NULL` if not needed

  Level: developer

.seealso: TSSetSlipProblem()
@*/
PetscErrorCode TSGetSlipProblem(TS ts, const SlipProblemOps **problem, void *ctx)
{
  Problem *p;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscCall(SlipObjectQueryData((PetscObject)ts, "SlipProblem", &p));
  *problem = p ? p->ops : NULL;
  if (ctx) *(void **)ctx = p ? p->ctx : NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Restores the history at the start of the step, of a problem with memory. */
PetscErrorCode SlipProblemRollBack(TS ts)
{
  const SlipProblemOps *problem;
  void *ctx;

  PetscFunctionBegin;
  PetscCall(TSGetSlipProblem(ts, &problem, &ctx));
  if (problem && problem->history.rollback) PetscCall((*problem->history.rollback)(ts, ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Replaces the norm E of the error of an attempt that ends in w, of the given order (NULL allowed), where that of the
   problem's history is larger, which has the order 3. */
PetscErrorCode SlipHistoryError(TS ts, Vec w, PetscReal *E, PetscInt *order)
{
  const SlipProblemOps *problem;
  PetscReal history = 0;
  void *ctx;

  PetscFunctionBegin;
  PetscCall(TSGetSlipProblem(ts, &problem, &ctx));
  if (problem && problem->history.error)
    PetscCall((*problem->history.error)(ts, ts->ptime + ts->time_step, w, &history, ctx));
  if (history > *E) {
    *E = history;
    if (order) *order = 3;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
